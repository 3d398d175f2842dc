"""Texts of files of models, as a user writes them."""

from __future__ import annotations

MODEL = '''\
"""A mass on a belt, on a spring that stiffens."""

from fiv_cli.friction.base import Law
from fiv_cli.models.base import Contact, Equations, Example, Model, Parameter, State

PARAMETERS = (
    Parameter("m", "m", "kg", 1.0, "mass", minimum=0.0, exclusive=True),
    Parameter("k", "k", "N m-1", 1.0, "stiffness", minimum=0.0),
    Parameter("k3", "k_3", "N m-3", 0.5, "what stiffens it"),
    Parameter("c", "c", "N s m-1", 0.0, "damping", minimum=0.0),
    Parameter("N", "N", "N", 10.0, "normal force", minimum=0.0, role="preload"),
    Parameter("v", "v", "m s-1", 1.0, "belt velocity", role="speed"),
)


def equations(symbols, options):
    p = symbols.parameter
    x, x_dot = symbols.coordinate("x"), symbols.velocity("x")
    spring = p("k") * x + p("k3") * x**3
    return Equations(
        accelerations={"x": (symbols.tangential_force(0) - spring - p("c") * x_dot) / p("m")},
        contacts=(Contact(p("v") - x_dot, "x", p("N")),),
        kinetic_energy=p("m") * x_dot**2 / 2,
        potential_energy=p("k") * x**2 / 2 + p("k3") * x**4 / 4,
    )


MODEL = Model(
    name="my-belt",
    title="mass on a belt with a stiffening spring",
    reference="none",
    numerics_version=1,
    parameters=PARAMETERS,
    states=lambda options: (State("x", "x", "m", "displacement"),),
    equations=equations,
    default_law="coulomb",
    constant_load=True,
    law_defaults={"mu_k": 0.2, "mu_s": 0.4},
    example=Example("v", 0.5, 2.0, {"c": 0.1}, {"f_max": 2.0}),
)

LAW = Law(
    name="my-law",
    title="friction that falls with the square of the slip speed",
    reference="none",
    numerics_version=1,
    parameters=(
        Parameter("mu_0", r"\\mu_0", "1", 0.4, "coefficient at zero slip", minimum=0.0),
        Parameter("fall", "f", "s2 m-2", 1.0, "rate of fall", minimum=0.0),
    ),
    force=lambda slip, p: slip.sign * p["mu_0"] / (1 + p["fall"] * slip.speed**2) * slip.N,
    capacity=lambda N, p: p["mu_0"] * N,
)
'''

CASE = """\
schema = 1
[model]
name = "my-belt"
[grid]
v = [0.5, 1.0]
[[initial]]
label = "far"
kind = "state"
state = { x = 5.0 }
[[analysis]]
kind = "response"
t_max = 400.0
"""
