"""One mass on a moving belt, with damper, spring and a moving base (thesis 3.1.1, 3.1.2).

    m x'' + c x' + k (x - u0 cos(omega t)) = F_T,      v_rel = v - x'

Thesis 3.1, 3.4 and 3.10. The printed right-hand side of 3.3 is read as F0 + alpha_0 v (3.2
linearised), and the stick force (3.7, 3.11) as c v + k (x - u0 cos(omega t)): both follow from
the equation above. During stick x = x(t_s) + v (t - t_s); 3.8 prints it without x(t_s).

Inside the circle of radius v/sqrt(k/m) about x = mu_k N/k the undamped Coulomb oscillator is a
neutral centre: what is found there depends on the start.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from fiv_cli.models.base import (
    Contact,
    Equations,
    Example,
    Forcing,
    Model,
    Options,
    Parameter,
    State,
)

if TYPE_CHECKING:
    from fiv_cli.models.symbols import Symbols

PARAMETERS = (
    Parameter("m", "m", "kg", 1.0, "mass", "3.1", 0.0, exclusive=True),
    Parameter("k", "k", "N m-1", 1.0, "stiffness of the spring", "3.1", 0.0),
    Parameter("c", "c", "N s m-1", 0.0, "damping coefficient", "3.1", 0.0),
    Parameter("N", "N", "N", 10.0, "normal force", "3.5", 0.0, role="preload"),
    Parameter("v", "v", "m s-1", 1.0, "belt velocity", "3.6", role="speed"),
    Parameter(
        "u0", "u_0", "m", 0.0, "amplitude of the base's motion", "3.10", 0.0, role="amplitude"
    ),
    Parameter(
        "omega",
        r"\omega",
        "rad s-1",
        1.0,
        "frequency of the base's motion",
        "3.10",
        0.0,
        exclusive=True,
        role="frequency",
    ),
)


def equations(symbols: Symbols, options: Options) -> Equations:
    """Equations 3.1 and 3.10 under a given friction force."""
    import sympy

    p = symbols.parameter
    x, x_dot = symbols.coordinate("x"), symbols.velocity("x")
    stretch = x - p("u0") * sympy.cos(p("omega") * symbols.time)
    force = symbols.tangential_force(0) - p("c") * x_dot - p("k") * stretch
    return Equations(
        accelerations={"x": force / p("m")},
        contacts=(
            Contact(
                slip_velocity=p("v") - x_dot,
                slip_coordinate="x",
                normal_force=p("N"),
            ),
        ),
        kinetic_energy=p("m") * x_dot**2 / 2,
        potential_energy=p("k") * stretch**2 / 2,
    )


MODEL = Model(
    name="belt-1dof",
    title="mass on a moving belt, one degree of freedom",
    reference="thesis 3.1.1, 3.1.2; equations 3.1-3.12",
    numerics_version=1,
    parameters=PARAMETERS,
    states=lambda options: (State("x", "x", "m", "displacement of the mass"),),
    equations=equations,
    default_law="coulomb",
    constant_load=True,
    law_defaults={"mu_k": 0.23, "mu_s": 0.4, "F0": 10.0, "alpha_0": -0.1},
    forcings=(Forcing("u0", lambda p: p["omega"], "harmonic motion of the base"),),
    base=("x",),
    example=Example("v", 0.5, 2.0, {"c": 0.1}, {"f_max": 2.0}),
    sliding=Example("v", 1.0, 6.0, {"c": 0.1}, law="stribeck"),
)
