"""Two masses on a moving belt or two, coupled by a spring and a damper (thesis 3.1.2.2).

    m1 x1'' + (c1 + c2) x1' - c2 x2' + (k1 + k2) x1 - k2 x2 = F_T1,    v_rel1 = v - x1'
    m2 x2'' + c2 (x2' - x1') + k2 (x2 - x1)                 = F_T2,    v_rel2 = v2 - x2'

v2 = v and N2 = N where not given: one belt. A mass that none presses (N or N2 = 0) slides freely.

Thesis 3.13-3.17. The damping is given by the ratio D = c2 / (2 sqrt(m2 k2)) and by c1/c2. While
mass i sticks, x_i = x_i(t_i) + v (t - t_i); 3.18 and 3.20 are printed without x_i(t_i), and 3.16
and 3.17 hold for either mass sticking alone. The two contacts stick and slip independently;
whether both stick at once is decided jointly.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from fiv_cli.models.base import Contact, Equations, Example, Model, Options, Parameter, State

if TYPE_CHECKING:
    from fiv_cli.models.symbols import Symbols

PARAMETERS = (
    Parameter("m1", "m_1", "kg", 2.5, "mass at the wall", "3.13", 0.0, exclusive=True),
    Parameter("m2", "m_2", "kg", 1.0, "mass at the end", "3.14", 0.0, exclusive=True),
    Parameter("k1", "k_1", "N m-1", 2.0, "stiffness wall to mass 1", "3.13", 0.0),
    Parameter("k2", "k_2", "N m-1", 1.0, "stiffness mass 1 to mass 2", "3.13", 0.0),
    Parameter("N", "N", "N", 20.0, "normal force on mass 1", "3.15", 0.0, role="preload"),
    Parameter("v", "v", "m s-1", 1.0, "velocity of the belt under mass 1", "3.15", role="speed"),
    Parameter(
        "D", "D", "1", 0.3, "damping ratio c2 / (2 sqrt(m2 k2))", "Figure 3.9", 0.0, role="damping"
    ),
    Parameter("c1_over_c2", "c_1/c_2", "1", 1.0, "ratio of the damping coefficients", "3.13", 0.0),
    Parameter(
        "N2",
        "N_2",
        "N",
        None,
        "normal force on mass 2; 0: no friction",
        "3.15",
        0.0,
        default_from="N",
    ),
    Parameter(
        "v2",
        "v_2",
        "m s-1",
        None,
        "velocity of the belt under mass 2",
        "3.15",
        default_from="v",
    ),
)

STATES = (
    State("x1", "x_1", "m", "displacement of mass 1"),
    State("x2", "x_2", "m", "displacement of mass 2"),
)


def equations(symbols: Symbols, options: Options) -> Equations:
    """Equations 3.13 and 3.14 under given friction forces."""
    import sympy

    p = symbols.parameter
    x1, x2 = symbols.coordinate("x1"), symbols.coordinate("x2")
    x1_dot, x2_dot = symbols.velocity("x1"), symbols.velocity("x2")
    c2 = 2 * p("D") * sympy.sqrt(p("m2") * p("k2"))
    coupling = p("k2") * (x2 - x1) + c2 * (x2_dot - x1_dot)
    wall = p("k1") * x1 + p("c1_over_c2") * c2 * x1_dot
    return Equations(
        accelerations={
            "x1": (symbols.tangential_force(0) - wall + coupling) / p("m1"),
            "x2": (symbols.tangential_force(1) - coupling) / p("m2"),
        },
        contacts=(
            Contact(slip_velocity=p("v") - x1_dot, slip_coordinate="x1", normal_force=p("N")),
            Contact(slip_velocity=p("v2") - x2_dot, slip_coordinate="x2", normal_force=p("N2")),
        ),
        kinetic_energy=(p("m1") * x1_dot**2 + p("m2") * x2_dot**2) / 2,
        potential_energy=(p("k1") * x1**2 + p("k2") * (x2 - x1) ** 2) / 2,
    )


MODEL = Model(
    name="belt-2mass",
    title="two coupled masses on a moving belt",
    reference="thesis 3.1.2.2; equations 3.13-3.21",
    numerics_version=1,
    parameters=PARAMETERS,
    states=lambda options: STATES,
    equations=equations,
    default_law="stribeck",
    constant_load=True,
    law_defaults={"mu_k": 0.1, "mu_s": 0.4},
    contacts=2,
    base=("x1", "x2"),
    example=Example("v", 1.0, 4.0, {}, {"f_max": 2.0}),
    sliding=Example("v", 1.0, 6.0, law="stribeck"),
)
