"""A file of a model, or of a law, to start from: it runs as it stands."""

from __future__ import annotations

from fiv_cli.errors import UsageError
from fiv_cli.friction import all_laws
from fiv_cli.models import all_models
from fiv_cli.own.load import is_name

_MODEL = '''\
"""A mass on a moving belt, held by a spring that stiffens and a damper.

    m x'' + c x' + k x + k_3 x^3 = F_T,      v_rel = v - x'

Look at it, check it, run it (FILE.py is this file):

    fiv models @NAME@ --with FILE.py
    fiv verify --with FILE.py
    fiv new @NAME@ --with FILE.py > case.toml
    fiv run case.toml --with FILE.py
"""

from fiv_cli.models.base import Contact, Equations, Example, Model, Parameter, State

# name, symbol (LaTeX), unit (SI; "1" for a number), default, meaning. minimum=0.0 bounds the range,
# exclusive=True leaves the bound out. role="preload", "speed" or "damping" says what a parameter
# is where its unit does not (N s m-1 is damping, N m-1 stiffness): "damping" is all that takes
# energy out, or in, and has no potential. With the default None and default_from="v" a parameter
# has the value of v unless a case gives it one.
PARAMETERS = (
    Parameter("m", "m", "kg", 1.0, "mass", minimum=0.0, exclusive=True),
    Parameter("k", "k", "N m-1", 1.0, "stiffness of the spring", minimum=0.0),
    Parameter("k_3", "k_3", "N m-3", 0.1, "what stiffens it", minimum=0.0),
    Parameter("c", "c", "N s m-1", 0.0, "damping coefficient", minimum=0.0),
    Parameter("N", "N", "N", 10.0, "normal force", minimum=0.0, role="preload"),
    Parameter("v", "v", "m s-1", 1.0, "belt velocity", role="speed"),
)

# The velocity of x is x_dot. A rotation has the unit "rad".
STATES = (State("x", "x", "m", "displacement of the mass"),)


def equations(symbols, options):
    """Accelerations under given contact forces, the contacts, and both energies, in SymPy."""
    import sympy  # here, not above: a case is checked without it

    p = symbols.parameter
    x, x_dot = symbols.coordinate("x"), symbols.velocity("x")
    spring = p("k") * x + p("k_3") * x**3
    friction = symbols.tangential_force(0)  # acts on the mass along v_rel; of contact 1: (1)
    return Equations(
        accelerations={"x": (friction - spring - p("c") * x_dot) / p("m")},
        contacts=(
            Contact(
                slip_velocity=p("v") - x_dot,  # of the drive, less that of the body
                slip_coordinate="x",  # the state whose velocity sticking determines
                normal_force=p("N"),  # may depend on states; where it may fall to zero, say
                # ends_at_zero_normal_force=True (a motion ends there) or gap=... (it lifts off)
            ),
            # A stop at x = d, behind it: stop(gap=p("d") - x, coordinate="x", restitution=p("e")),
            # imported as Contact is; its force, symbols.normal_force(1), is taken from that on the
            # mass, and MODEL says contacts=2, stops=1.
            # A second belt that rubs: Contact(slip_velocity=p("v_2") - x_dot, slip_coordinate="x",
            # normal_force=p("N_2")); its symbols.tangential_force(1) is added to friction, v_2 and
            # N_2 to PARAMETERS, and MODEL says contacts=2.
        ),
        kinetic_energy=p("m") * x_dot**2 / 2,
        potential_energy=p("k") * x**2 / 2 + sympy.Rational(1, 4) * p("k_3") * x**4,
    )


MODEL = Model(
    name="@NAME@",
    title="mass on a belt with a stiffening spring",
    reference="where the equations come from",
    numerics_version=1,
    parameters=PARAMETERS,
    states=lambda options: STATES,
    equations=equations,
    default_law="coulomb",
    law_defaults={"mu_k": 0.23, "mu_s": 0.4},  # of laws that have them; "mu_s": "mu_k" follows it
    constant_load=True,  # the normal force is a parameter; else leave it out
    example=Example("v", 0.5, 2.0),  # for v from 0.5 to 2.0 m/s it vibrates somewhere
)


def verify(bench):
    """What is known of the model without fiv; `fiv verify --with FILE.py` holds it against that.

    bench(model, law, analysis, start, settings, **parameters) computes one point. Energy, units,
    derivatives and two ways of integrating are checked of every model in any case.
    """
    from math import atan, pi

    from fiv_cli.verify import Check

    sliding = bench("@NAME@", "coulomb", "equilibrium", k_3=0.0, mu_k=0.2, N=10.0, k=4.0)
    x = float(sliding.values["equilibrium"][0][0])
    yield Check("x of steady sliding (m)", "closed form, mu_k N / k", x, 0.5, 1e-12)
    cycle = bench("@NAME@", "coulomb", "response", {}, k_3=0.0, mu_k=0.23, mu_s=0.4)
    reach = (0.4 - 0.23) * 10.0  # m, of the mass about its equilibrium when it lets go
    period = pi + 2.0 * atan(1.0 / reach) + 2.0 * reach
    found = float(cycle.values["period"])
    yield Check("period of stick-slip (s)", "closed form", found, period, 1e-9)
'''

_LAW = '''\
"""Friction that falls with the square of the slip speed.

    F_T = sgn(v_rel) mu_0 F_N / (1 + f v_rel^2),      |F_T| <= mu_0 F_N in stick

    fiv models @NAME@ --with FILE.py
    fiv plot --law @NAME@ --with FILE.py -o law.png
    fiv verify --with FILE.py
"""

from fiv_cli.friction.base import Law
from fiv_cli.models.base import Parameter

LAW = Law(
    name="@NAME@",
    title="friction that falls with the square of the slip speed",
    reference="where the formula comes from",
    numerics_version=1,
    parameters=(
        Parameter("mu_0", r"\\mu_0", "1", 0.4, "coefficient at zero slip", minimum=0.0),
        Parameter("fall", "f", "s2 m-2", 1.0, "rate of fall", minimum=0.0),
    ),
    # slip.v is the slip velocity, slip.sign its sign, slip.speed = |v|, slip.N the normal force;
    # a power may have any exponent: (slip.speed / p["v_0"]) ** p["q"], where v_0 is in m s-1
    force=lambda slip, p: slip.sign * p["mu_0"] / (1 + p["fall"] * slip.speed**2) * slip.N,
    capacity=lambda N, p: p["mu_0"] * N,  # what stick can bear; None: it never sticks
    # A state of its own begins at zero; that of a bristle (State is imported as Parameter is):
    # states=(State("z", "z", "m", "deflection"),),
    # rates=lambda slip, p: {"z": slip.v - slip.speed * p["stiff"] * slip.states["z"] / p["mu_0"]},
    # force=lambda slip, p: p["stiff"] * slip.states["z"] * slip.N,
)
'''


def model_template(name: str) -> str:
    """The text of a file of a model called `name`; UsageError where it cannot be called so."""
    return _named(name, "model", _MODEL)


def law_template(name: str) -> str:
    """The text of a file of a law called `name`; UsageError where it cannot be called so."""
    return _named(name, "law", _LAW)


def _named(name: str, kind: str, text: str) -> str:
    if name in {**all_models(), **all_laws()}:
        raise UsageError(f"{name!r} is there already\nnext: fiv new-{kind} ANOTHER-NAME")
    if not is_name(name):
        raise UsageError(f"{name!r} is no name for a {kind}\nnext: fiv new-{kind} my-{kind}")
    return text.replace("@NAME@", name)
