"""Stribeck's curve without a jump: break-away, fall and viscous rise as one smooth function.

    F_T = (sqrt(2 e) (mu_s - mu_k) exp(-(v/v_St)^2) v/v_St + mu_k tanh(v/v_C)) N + F_V v
    v_St = sqrt(2) v_brk,   v_C = v_brk/10

The friction of the blocks "Translational Friction" of Simscape (MathWorks), whose forces are mu_s
N (break-away), mu_k N (Coulomb) and F_V v here. The peak is close to mu_s N and lies at the
break-away velocity v_brk. There is no stick: below v_brk friction rises with the speed, and a
loaded contact creeps at a share of v_brk. The smaller v_brk, the closer to a set-valued law, and
the dearer: the slope at rest is some 10 mu_k N/v_brk.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

from fiv_cli.friction.base import Law, Slip
from fiv_cli.friction.coulomb import FALLING, MU_K, MU_S
from fiv_cli.friction.viscous import F_V
from fiv_cli.models.base import Parameter

if TYPE_CHECKING:
    from sympy import Expr

COULOMB_SHARE = 10  # the Coulomb velocity is this part of the break-away velocity


def force(slip: Slip, p: Mapping[str, Expr]) -> Expr:
    """F_T in N."""
    import sympy

    relative = slip.v / (sympy.sqrt(2) * p["v_brk"])
    peak = sympy.sqrt(2 * sympy.E) * (p["mu_s"] - p["mu_k"]) * sympy.exp(-(relative**2)) * relative
    steady = p["mu_k"] * sympy.tanh(COULOMB_SHARE * slip.v / p["v_brk"])
    return (peak + steady) * slip.N + p["F_V"] * slip.v


LAW = Law(
    name="simscape",
    title="smooth Stribeck curve with a break-away velocity (Simscape)",
    reference="MathWorks Simscape, Translational Friction",
    numerics_version=1,
    parameters=(
        MU_S,
        MU_K,
        Parameter(
            "v_brk", r"v_\mathrm{brk}", "m s-1", 0.01, "break-away velocity", "", 0.0,
            exclusive=True,
        ),
        F_V,
    ),
    force=force,
    capacity=None,
    requirements=(FALLING,),
)  # fmt: skip
