"""A plate on two rollers that turn against each other: the Timoshenko oscillator.

    m x'' = F_1 + F_2,    N_1 = m g (a - x) / (2 a),    N_2 = m g (a + x) / (2 a)

x is the displacement of the plate's middle, 2 a the distance of the axes. The left roller carries
the plate to the right at v, the right one to the left. While the plate is slower than both,
F_1 + F_2 = mu_k (N_1 - N_2) = -mu_k m g x / a: friction is its spring, omega^2 = mu_k g / a.

Henaff, Le Doudic, Pilette et al., A study of kinetic friction: The Timoshenko oscillator,
American Journal of Physics 86 (2018) 174.
"""

from fiv_cli.models.base import Contact, Equations, Example, Model, Parameter, State

PARAMETERS = (
    Parameter("m", "m", "kg", 0.1, "mass of the plate", minimum=0.0, exclusive=True),
    Parameter("a", "a", "m", 0.1, "half the distance of the axes", minimum=0.0, exclusive=True),
    Parameter("g", "g", "m s-2", 9.81, "gravity", minimum=0.0),
    Parameter("v", "v", "m s-1", 0.5, "speed of the rollers; negative: outwards", role="speed"),
)


def equations(symbols, options):
    """The plate under given friction forces of both rollers."""
    p = symbols.parameter
    x, x_dot = symbols.coordinate("x"), symbols.velocity("x")
    weight = p("m") * p("g")
    rollers = ((p("v"), p("a") - x), (-p("v"), p("a") + x))  # speed, lever of the other roller
    return Equations(
        accelerations={"x": sum(symbols.tangential_force(i) for i in range(2)) / p("m")},
        contacts=tuple(
            Contact(
                slip_velocity=speed - x_dot,
                slip_coordinate="x",
                normal_force=weight * lever / (2 * p("a")),
                ends_at_zero_normal_force=True,  # it tips
            )
            for speed, lever in rollers
        ),
        kinetic_energy=p("m") * x_dot**2 / 2,
        potential_energy=0 * x,
    )


MODEL = Model(
    name="plate-on-rollers",
    title="plate on two rollers that turn against each other",
    reference="Henaff et al., American Journal of Physics 86 (2018) 174",
    numerics_version=1,
    parameters=PARAMETERS,
    states=lambda options: (State("x", "x", "m", "displacement of the plate"),),
    equations=equations,
    contacts=2,
    default_law="coulomb",
    law_defaults={"mu_k": 0.3, "mu_s": 0.3},
    example=Example("v", 0.2, 1.0),
)


def verify(bench):
    """The period of small motions, and the speed of the rollers as the greatest of large ones."""
    from math import pi, sqrt

    from fiv_cli.verify import Check

    source = "closed form, Timoshenko oscillator"
    found = bench("plate-on-rollers", "coulomb", "eigenvalues", mu_k=0.2, a=0.15)
    frequency = max(float(f) for f in found.values["mode_frequency"])
    expected = sqrt(0.2 * 9.81 / 0.15) / (2 * pi)
    yield Check("frequency (Hz)", source, frequency, expected, 1e-12)
    thrown = {"x_dot": 0.5}
    moved = bench("plate-on-rollers", "coulomb", "history", thrown, {"t_end": 20.0}, v=0.1)
    late = moved.values["x_dot"][-1000:]
    yield Check("greatest speed in the end (m/s)", source, float(max(late)), 0.1, 1e-5)
