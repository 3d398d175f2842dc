"""Friction that falls from its static to its kinetic value (Stribeck effect).

    F_T = sgn(v) (mu_k + (mu_s - mu_k) exp(-(|v|/v_s)^delta)) N     sliding
    |F_T| <= mu_s N                                                 sticking

Thesis 2.3; 3.12 is delta = 1, v_s = 1 m/s. `delta` is a whole number: any other exponent makes
the law non-analytic at v = 0, where every slip starts. There is no viscous rise
(`stribeck_viscous`), no lag and no pre-sliding (`lugre`).
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

from fiv_cli.friction.base import Law, Slip
from fiv_cli.friction.coulomb import FALLING, MU_K, MU_S
from fiv_cli.models.base import Parameter

if TYPE_CHECKING:
    from sympy import Expr


V_S = Parameter("v_s", "v_s", "m s-1", 1.0, "Stribeck velocity", "2.3", 0.0, exclusive=True)


def exponent(default: float) -> Parameter:
    """The Stribeck exponent."""
    name, meaning = "delta", "Stribeck exponent"
    return Parameter(name, r"\delta", "1", default, meaning, "2.3", 1.0, 8.0, integer=True)


def force(slip: Slip, p: Mapping[str, Expr]) -> Expr:
    """F_T in N (thesis 2.3, 3.12)."""
    import sympy

    decay = sympy.exp(-((slip.speed / p["v_s"]) ** p["delta"]))
    return slip.sign * (p["mu_k"] + (p["mu_s"] - p["mu_k"]) * decay) * slip.N


LAW = Law(
    name="stribeck",
    title="Coulomb friction with Stribeck effect",
    reference="thesis 2.3, 3.12",
    numerics_version=1,
    parameters=(
        MU_S,
        MU_K,
        V_S,
        exponent(1.0),
    ),
    force=force,
    capacity=lambda N, p: p["mu_s"] * N,
    structural=("delta",),
    requirements=(FALLING,),
)
