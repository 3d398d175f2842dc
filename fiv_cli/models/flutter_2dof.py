"""The minimal model of mode-coupling instability (thesis 3.1.3, Figure 3.11).

    m x'' + c1 x' + k11 x + k12 y  = F_T
    m y'' + c2 y' + k12 x + k22' y = F_N - F,     F_N = -k3 y,    v_rel = v - x'

Thesis 3.22-3.24, with k11, k12 and k22 = k22' + k3 of 3.23: the contact stiffness is written as
the force F_N here, so that the mass can leave the belt. The dampers are horizontal (c1) and
vertical (c2). In sliding F_T = mu_k F_N makes the stiffness matrix unsymmetric (3.25).
"""

from __future__ import annotations

from math import pi
from typing import TYPE_CHECKING

from fiv_cli.models import inclined_springs
from fiv_cli.models.base import Equations, Example, Model, Options, Parameter

if TYPE_CHECKING:
    from fiv_cli.models.symbols import Symbols

PARAMETERS = (
    Parameter("m", "m", "kg", 1.0, "mass", "3.22", 0.0, exclusive=True),
    Parameter("k1", "k_1", "N m-1", 1.0, "stiffness of the first spring", "3.23", 0.0),
    Parameter("k2", "k_2", "N m-1", 1.0, "stiffness of the second spring", "3.23", 0.0),
    Parameter("k3", "k_3", "N m-1", 2.0, "contact stiffness", "3.24", 0.0, exclusive=True),
    Parameter("alpha1", r"\alpha_1", "rad", pi / 4, "inclination of the first spring", "3.23"),
    Parameter("alpha2", r"\alpha_2", "rad", pi / 6, "inclination of the second spring", "3.23"),
    Parameter("c1", "c_1", "N s m-1", 0.0, "horizontal damping coefficient", "3.22", 0.0),
    Parameter("c2", "c_2", "N s m-1", 0.0, "vertical damping coefficient", "3.22", 0.0),
    Parameter("F", "F", "N", 1.0, "preload", "3.22", 0.0, role="preload"),
    Parameter("v", "v", "m s-1", 1.0, "belt velocity", "3.1.3", role="speed"),
)


def equations(symbols: Symbols, options: Options) -> Equations:
    """Equation 3.22 under given contact forces."""
    p = symbols.parameter
    x, y = symbols.coordinate("x"), symbols.coordinate("y")
    x_dot, y_dot = symbols.velocity("x"), symbols.velocity("y")
    k11, k12, k22 = inclined_springs.inclined(p("alpha1"), p("alpha2"), p("k1"), p("k2"))
    horizontal = symbols.tangential_force(0) - p("c1") * x_dot - k11 * x - k12 * y
    vertical = symbols.normal_force(0) - p("F") - p("c2") * y_dot - k12 * x - k22 * y
    springs = (k11 * x**2 + k22 * y**2) / 2 + k12 * x * y
    return Equations(
        accelerations={"x": horizontal / p("m"), "y": vertical / p("m")},
        contacts=(inclined_springs.contact(symbols, options),),
        kinetic_energy=p("m") * (x_dot**2 + y_dot**2) / 2,
        potential_energy=springs + p("F") * y + symbols.closed(0) * p("k3") * y**2 / 2,
    )


MODEL = Model(
    name="flutter-2dof",
    title="mass on a belt with two inclined springs: mode coupling",
    reference="thesis 3.1.3; equations 3.22-3.29",
    numerics_version=1,
    parameters=PARAMETERS,
    states=lambda options: inclined_springs.STATES,
    equations=equations,
    default_law="coulomb",
    law_defaults={"mu_k": 0.3, "mu_s": "mu_k"},
    options=inclined_springs.OPTIONS,
    base=("x",),
    example=Example("mu_k", 4.0, 6.0, {"c1": 0.1, "c2": 0.1, "states": "all"}, {"f_max": 2.0}),
)
