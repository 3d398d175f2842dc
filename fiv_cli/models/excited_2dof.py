"""Mode coupling under a tangential harmonic force (thesis 5.2, Figure 5.1).

    m x'' + c11 x' + c12 y' + k11 x + k12 y  = F_T + A_b sin(omega t)
    m y'' + c12 x' + c22 y' + k12 x + k22' y = F_N - F,   F_N = -k3 y,   v_rel = v - x'

Thesis 5.1-5.4, with the matrices of 5.2 and k22 = k22' + k3: the contact stiffness is written as
the force F_N here, so that the mass can leave the belt. The dampers lie along the springs. The
frequency is given as the ratio R = omega/omega_1 with omega_1 = sqrt(k1/m) (5.5).

In the averaged system the fast motion is x = -(A_b/(m omega^2)) sin(omega t): 5.10a prints C_h
for C_b, and both forms of 5.15 lack -2 zeta a_2 in the entry (2, 4). Nothing of that is typed
here: the averaged system is this one under the averaged friction law, without the force.
"""

from __future__ import annotations

from collections.abc import Mapping
from math import pi, sqrt
from typing import TYPE_CHECKING

from fiv_cli.models import inclined_springs
from fiv_cli.models.base import Equations, Example, Forcing, Model, Options, Parameter

if TYPE_CHECKING:
    from fiv_cli.models.symbols import Symbols

PARAMETERS = (
    Parameter("m", "m", "kg", 1.0, "mass", "5.1", 0.0, exclusive=True),
    Parameter(
        "k1", "k_1", "N m-1", 1.0, "stiffness of the first spring", "5.2", 0.0, exclusive=True
    ),
    Parameter("k2", "k_2", "N m-1", 0.5, "stiffness of the second spring", "5.2", 0.0),
    Parameter("k3", "k_3", "N m-1", 0.5, "contact stiffness", "5.4", 0.0, exclusive=True),
    Parameter("alpha1", r"\alpha_1", "rad", pi / 6, "inclination of the first spring", "5.2"),
    Parameter("alpha2", r"\alpha_2", "rad", pi / 4, "inclination of the second spring", "5.2"),
    Parameter("c1", "c_1", "N s m-1", 1e-3, "damping coefficient along spring k1", "5.2", 0.0),
    Parameter("c2", "c_2", "N s m-1", 1e-3, "damping coefficient along spring k2", "5.2", 0.0),
    Parameter("F", "F", "N", 2.0, "preload", "5.1", 0.0, role="preload"),
    Parameter("v", "v", "m s-1", 0.3, "belt velocity", "5.3", role="speed"),
    Parameter(
        "A_b", "A_b", "N", 0.0, "amplitude of the tangential force", "5.1", 0.0, role="amplitude"
    ),
    Parameter(
        "R",
        "R",
        "1",
        20.0,
        "frequency ratio omega/sqrt(k1/m)",
        "5.5",
        0.0,
        exclusive=True,
        role="frequency",
    ),
)


def equations(symbols: Symbols, options: Options) -> Equations:
    """Equation 5.1 under given contact forces."""
    import sympy

    p = symbols.parameter
    x, y = symbols.coordinate("x"), symbols.coordinate("y")
    x_dot, y_dot = symbols.velocity("x"), symbols.velocity("y")
    k11, k12, k22 = inclined_springs.inclined(p("alpha1"), p("alpha2"), p("k1"), p("k2"))
    c11, c12, c22 = inclined_springs.inclined(p("alpha1"), p("alpha2"), p("c1"), p("c2"))
    excitation = p("A_b") * sympy.sin(p("R") * sympy.sqrt(p("k1") / p("m")) * symbols.time)
    horizontal = -c11 * x_dot - c12 * y_dot - k11 * x - k12 * y
    vertical = -c12 * x_dot - c22 * y_dot - k12 * x - k22 * y
    springs = (k11 * x**2 + k22 * y**2) / 2 + k12 * x * y
    return Equations(
        accelerations={
            "x": (symbols.tangential_force(0) + excitation + horizontal) / p("m"),
            "y": (symbols.normal_force(0) - p("F") + vertical) / p("m"),
        },
        contacts=(inclined_springs.contact(symbols, options),),
        kinetic_energy=p("m") * (x_dot**2 + y_dot**2) / 2,
        potential_energy=springs + p("F") * y + symbols.closed(0) * p("k3") * y**2 / 2,
    )


def omega(parameters: Mapping[str, float]) -> float:
    """Angular frequency of the tangential force, rad/s (5.5)."""
    return parameters["R"] * sqrt(parameters["k1"] / parameters["m"])


def fast_velocity(parameters: Mapping[str, float]) -> float:
    """Amplitude of the fast slip velocity, m/s: omega_1 C_b of 5.12a and 5.14."""
    return parameters["A_b"] / (parameters["m"] * omega(parameters))


MODEL = Model(
    name="excited-2dof",
    title="mass on a belt with two inclined springs and a tangential excitation",
    reference="thesis 5.2; equations 5.1-5.15",
    numerics_version=1,
    parameters=PARAMETERS,
    states=lambda options: inclined_springs.STATES,
    equations=equations,
    default_law="coulomb",
    law_defaults={"mu_k": 0.4, "mu_s": "mu_k"},
    options=inclined_springs.OPTIONS,
    forcings=(Forcing("A_b", omega, "tangential harmonic force", fast_velocity),),
    base=("x",),
    example=Example("mu_k", 0.3, 0.6, {"states": "all"}, {"f_max": 2.0}),
)
