"""Friction that is higher while slip speeds up than while it slows down (non-reversible).

    F_T = sgn(v) (mu_k + (mu_s - mu_k) exp(-|v|/v_s) tanh(sgn(v) a/a_0)) N     sliding
    |F_T| <= mu_s N                                                           sticking
    du/dt = a = (v - u)/tau

Thesis 2.6; Stefanski, Wojewoda, Wiercigroch & Kapitaniak, Chaos, Solitons & Fractals 16 (2003) 661.
There exp(-|v|) has no velocity scale, so v_s = 1 m/s, and the law asks for the sign of the slip
acceleration. A force that jumps with an acceleration which follows from the force has no answer
where either sign contradicts itself; so it is told here from u, the slip velocity a time tau late,
and its sign is reached over the acceleration a_0. As tau and a_0 tend to zero this is 2.6: of a
slip that is stated at the orders 1 and 2, and periods of stick-slip at the order 1 in tau. In
steady sliding F_T = mu_k N. About it the force resists accelerations below a_0 as a mass
M = (mu_s - mu_k) exp(-|v|/v_s) N/a_0 would, beside tau ever so short: motions that come near it
slow down as a_0 shrinks, without a limit, and may end there. a_0 is physics, and no small number.

While slip slows down friction falls to (2 mu_k - mu_s) N: where mu_s > 2 mu_k it drives, as the
formula says. tau is to be short against what the motion does; steps are of the order of it.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

from fiv_cli.friction.base import Law, Slip
from fiv_cli.friction.coulomb import FALLING, MU_K, MU_S
from fiv_cli.friction.stribeck import V_S
from fiv_cli.models.base import Parameter, State

if TYPE_CHECKING:
    from sympy import Expr


def _acceleration(slip: Slip, p: Mapping[str, Expr]) -> Expr:
    """The slip acceleration as the contact has noticed it, m/s2."""
    return (slip.v - slip.states["late_velocity"]) / p["tau"]


def sense(slip: Slip, p: Mapping[str, Expr]) -> Expr:
    """1 while slip speeds up, -1 while it slows down, 0 in steady sliding."""
    import sympy

    return sympy.tanh(slip.sign * _acceleration(slip, p) / p["a_0"])


def force(slip: Slip, p: Mapping[str, Expr]) -> Expr:
    """F_T in N."""
    import sympy

    rise = (p["mu_s"] - p["mu_k"]) * sympy.exp(-slip.speed / p["v_s"]) * sense(slip, p)
    return slip.sign * (p["mu_k"] + rise) * slip.N


def _positive(name: str, symbol: str, unit: str, default: float, meaning: str) -> Parameter:
    return Parameter(name, symbol, unit, default, meaning, "2.6", 0.0, exclusive=True)


LAW = Law(
    name="stefanski",
    title="friction that is higher while slip speeds up than while it slows down",
    reference="thesis 2.6; Stefanski et al., Chaos, Solitons & Fractals 16 (2003) 661",
    numerics_version=1,
    parameters=(
        MU_S,
        MU_K,
        V_S,
        _positive(
            "a_0", "a_0", "m s-2", 0.1, "slip acceleration that makes most of the difference"
        ),
        _positive("tau", r"\tau", "s", 0.01, "time by which the contact is late"),
    ),
    force=force,
    capacity=lambda N, p: p["mu_s"] * N,
    states=(State("late_velocity", "u", "m s-1", "slip velocity, a time tau late"),),
    rates=lambda slip, p: {"late_velocity": _acceleration(slip, p)},
    requirements=(FALLING,),
)
