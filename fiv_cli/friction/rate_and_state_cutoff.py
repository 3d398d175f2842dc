"""Rate-and-state friction that sticks below a slip speed that is cut off, so that slip may turn.

    F_T = sgn(v) (mu_0 + a ln((|v| + v_c)/v_0) + b ln(v_0 theta/D_c)) N       sliding
    |F_T| <= (mu_0 + a ln(v_c/v_0) + b ln(v_0 theta/D_c)) N                   sticking
    d(theta)/dt = 1 - |v| theta/D_c

The common form of `rate-and-state` with v_c under its logarithm: friction falls no more below v_c,
and is a jump at v = 0, which is stick. It differs from that law by a v_c/|v|; the one bends where
nothing resolves it, this one is met exactly. In stick the contact ages, theta = theta_0 + t: what
it holds grows as b ln t, as Dieterich measured (J. Geophysical Research 77 (1972) 3690). Let go it
creeps, with a rate of a N/(m v_c) at first. Steady slip is as in `rate-and-state`, v_c << |v|.

It cannot creep below v_c under a load that it bears: there it is held. v_c is no material's number,
and below some 30 a N sqrt(rtol/(k m)) (m, k of what slips) slip that begins is within the error of
a step: the motion then ends in `no_consistent_state`, and needs a smaller rtol.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import TYPE_CHECKING

from fiv_cli.friction import rate_and_state
from fiv_cli.friction.base import Slip
from fiv_cli.models.base import Parameter, Requirement

if TYPE_CHECKING:
    from sympy import Expr

CUTOFF = Parameter(
    "v_c", "v_c", "m s-1", 1e-3, "slip speed below which friction falls no more", "",
    0.0, exclusive=True,
)  # fmt: skip


def _coefficient(speed: Expr, age: Expr, p: Mapping[str, Expr]) -> Expr:
    import sympy

    direct = p["a_rate"] * sympy.log((speed + p["v_c"]) / p["v_0"])
    return p["mu_0"] + direct + p["b_state"] * sympy.log(1 + age)


def force(slip: Slip, p: Mapping[str, Expr]) -> Expr:
    """F_T in N."""
    return slip.sign * _coefficient(slip.speed, slip.states["age"], p) * slip.N


def _resists(p: Mapping[str, float]) -> bool:
    from math import log

    return p["mu_0"] + p["a_rate"] * log(p["v_c"] / p["v_0"]) > 0.0


LAW = replace(
    rate_and_state.LAW,
    name="rate-and-state-cutoff",
    title="rate-and-state friction that sticks below a slip speed",
    parameters=(*rate_and_state.LAW.parameters, CUTOFF),
    force=force,
    capacity=lambda N, p: _coefficient(0, p.get("age", 0), p) * N,
    requirements=(
        Requirement(
            ("mu_0", "a_rate", "v_c", "v_0"),
            _resists,
            "mu_0 + a_rate ln(v_c/v_0) > 0",
            "v_c is so small that at rest friction would drive",
            "no_number",
        ),
    ),
)
