"""A mass on a belt that carries it against a stop: impact and friction.

    m x'' + k x = F_T,    v_rel = v - x',    x <= d,    x'(+) = -e x'(-) at the stop

Friction oscillators with a stop: Hinrichs, Oestreich and Popp, Chaos, Solitons & Fractals 8 (1997)
535; Popp, Journal of Applied Mathematics and Mechanics 64 (2000) 765. Slip about
x_e = mu_k N / k keeps (x - x_e)^2 + (x'/omega)^2, so the mass that hits the stop at the speed of
the belt comes back

- where d < x_e (or k = 0) to the stop, at e times its speed: its flights add up like those of a
  bouncing ball, to 2 e v / (a (1 - e)) for k = 0, a = mu_k N / m; then it stays;
- where d > x_e and it is slung far enough to be caught by the belt, in a cycle of stick, impact
  and slip.
"""

from fiv_cli.models.base import Contact, Equations, Example, Model, Parameter, State, stop

PARAMETERS = (
    Parameter("m", "m", "kg", 1.0, "mass", minimum=0.0, exclusive=True),
    Parameter("k", "k", "N m-1", 1.0, "stiffness of the spring", minimum=0.0),
    Parameter("N", "N", "N", 1.0, "normal force on the belt", minimum=0.0, role="preload"),
    Parameter("v", "v", "m s-1", 1.0, "belt velocity", role="speed"),
    Parameter("d", "d", "m", 0.5, "place of the stop"),
    Parameter("e", "e", "1", 0.6, "restitution at the stop", minimum=0.0, maximum=1.0),
)


def equations(symbols, options):
    """The mass under the friction of the belt and the force of the stop."""
    p = symbols.parameter
    x, x_dot = symbols.coordinate("x"), symbols.velocity("x")
    on_mass = symbols.tangential_force(0) - symbols.normal_force(1)
    return Equations(
        accelerations={"x": (on_mass - p("k") * x) / p("m")},
        contacts=(
            Contact(slip_velocity=p("v") - x_dot, slip_coordinate="x", normal_force=p("N")),
            stop(gap=p("d") - x, coordinate="x", restitution=p("e")),
        ),
        kinetic_energy=p("m") * x_dot**2 / 2,
        potential_energy=p("k") * x**2 / 2,
    )


MODEL = Model(
    name="belt-with-stop",
    title="mass on a belt that carries it against a stop",
    reference="Hinrichs, Oestreich, Popp, Chaos, Solitons & Fractals 8 (1997) 535",
    numerics_version=1,
    parameters=PARAMETERS,
    states=lambda options: (State("x", "x", "m", "displacement of the mass"),),
    equations=equations,
    contacts=2,
    stops=1,
    default_law="coulomb",
    law_defaults={"mu_k": 0.2, "mu_s": 0.8},
    example=Example("v", 0.2, 0.6),
)
