"""Powers of the slip speed, (|v|/v_0)^q, whose exponent is no whole number.

Such a power has no Taylor series at v = 0, where every slip begins. There, u^q is taken as

    (u^2 + e^2)^(q/2),      e = 1e-9

which is off by e^q at u = 0, and by q/2 (e/u)^2 of itself far above e. Slip that begins slowly
passes there in a time of the order sqrt(e), so that a motion is off by the order e^(q + 1/2), as
measured for q from 0.7 on (e^0.7 at q = 1/2). A period of stick-slip is off by 1e-13 of itself
from q = 1 on, by 3e-10 at q = 0.7 and by 1e-7 at q = 1/2.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from sympy import Expr

EASED = 1e-9


def eased(expression: Expr, v: Expr) -> Expr:
    """`expression` with a series at v = 0: powers of what vanishes there are smoothed."""
    import sympy

    return sympy.sympify(expression).replace(
        lambda one: one.is_Pow and _breaks(one, v),
        lambda one: (one.base**2 + EASED**2) ** (one.exp / 2),
    )


def _breaks(power: Expr, v: Expr) -> bool:
    is_whole = power.exp.is_Number and power.exp == int(power.exp)
    return not is_whole and power.base.subs(v, 0) == 0
