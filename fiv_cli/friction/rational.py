"""Friction that falls from its static to its kinetic value as a rational function of the speed.

    F_T = sgn(v) (mu_k + (mu_s - mu_k)/(1 + (|v|/v_s)^delta)) N     sliding
    |F_T| <= mu_s N                                                 sticking

Half of the fall lies behind at |v| = v_s. The tail is an inverse power, where Stribeck's is
exponential: friction that goes on falling far above v_s. Hess & Soom's has delta = 2; with delta =
1 and mu_k = 0 it is the hyperbolic law. `delta` is a whole number, as with Stribeck's law and for
the same reason. There is no viscous rise.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

from fiv_cli.friction.base import Law, Slip
from fiv_cli.friction.coulomb import FALLING, MU_K, MU_S
from fiv_cli.friction.stribeck import V_S, exponent

if TYPE_CHECKING:
    from sympy import Expr


def force(slip: Slip, p: Mapping[str, Expr]) -> Expr:
    """F_T in N."""
    fall = (p["mu_s"] - p["mu_k"]) / (1 + (slip.speed / p["v_s"]) ** p["delta"])
    return slip.sign * (p["mu_k"] + fall) * slip.N


LAW = Law(
    name="rational",
    title="Coulomb friction that falls as a rational function of the slip speed",
    reference="Hess & Soom, ASME J. Tribology 112 (1990) 147",
    numerics_version=1,
    parameters=(MU_S, MU_K, V_S, exponent(2.0)),
    force=force,
    capacity=lambda N, p: p["mu_s"] * N,
    structural=("delta",),
    requirements=(FALLING,),
)
