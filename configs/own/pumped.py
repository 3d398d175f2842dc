"""A slider on rough ground whose spring is pumped: parametric excitation against dry friction.

    m x'' + k (1 - eps cos(omega t)) x + k_3 x^3 = F_T,      v_rel = -x'

At omega = 2 sqrt(k/m), in the first approximation (Bogoliubov and Mitropolsky, Asymptotic methods
in the theory of non-linear oscillations, 1961), pumping adds eps sqrt(k/m) a / 4 to the rate of the
amplitude a at most, friction takes 2 mu N / (pi sqrt(k m)) from it: rest is stable however strong
the pumping, and a motion grows only from a > 8 mu N / (pi eps k).
"""

from fiv_cli.models.base import Contact, Equations, Example, Forcing, Model, Parameter, State

PARAMETERS = (
    Parameter("m", "m", "kg", 1.0, "mass", minimum=0.0, exclusive=True),
    Parameter("k", "k", "N m-1", 1.0, "mean stiffness", minimum=0.0, exclusive=True),
    Parameter("k_3", "k_3", "N m-3", 0.001, "what stiffens the spring", minimum=0.0),
    Parameter("N", "N", "N", 1.0, "normal force", minimum=0.0, role="preload"),
    Parameter("eps", r"\varepsilon", "1", 0.2, "depth of pumping", minimum=0.0, role="amplitude"),
    Parameter(
        "omega",
        r"\omega",
        "rad s-1",
        2.0,
        "frequency of pumping",
        minimum=0.0,
        exclusive=True,
        role="frequency",
    ),
)


def equations(symbols, options):
    """The slider under a given friction force."""
    import sympy

    p = symbols.parameter
    x, x_dot = symbols.coordinate("x"), symbols.velocity("x")
    stiffness = p("k") * (1 - p("eps") * sympy.cos(p("omega") * symbols.time))
    spring = stiffness * x + p("k_3") * x**3
    return Equations(
        accelerations={"x": (symbols.tangential_force(0) - spring) / p("m")},
        contacts=(Contact(slip_velocity=-x_dot, slip_coordinate="x", normal_force=p("N")),),
        kinetic_energy=p("m") * x_dot**2 / 2,
        potential_energy=stiffness * x**2 / 2 + p("k_3") * x**4 / 4,
    )


MODEL = Model(
    name="pumped-slider",
    title="slider on rough ground, its stiffness pumped",
    reference="Bogoliubov and Mitropolsky 1961, first approximation",
    numerics_version=1,
    parameters=PARAMETERS,
    states=lambda options: (State("x", "x", "m", "displacement of the slider"),),
    equations=equations,
    default_law="coulomb",
    law_defaults={"mu_k": 0.1, "mu_s": 0.1},
    constant_load=True,
    forcings=(Forcing("eps", lambda p: p["omega"], "pumping of the spring"),),
    example=Example("eps", 0.1, 0.4),
)
