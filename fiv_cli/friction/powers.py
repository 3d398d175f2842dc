"""Powers of the slip speed, (|v|/v_0)^q, whose exponent is no whole number.

Such a power has no Taylor series at v = 0, where every slip begins. There, u^q is taken as

    u^2 (u^2 + e^2)^(q/2 - 1),      e = 10^-(6 + 3/(1 + q^4))

which vanishes at u = 0, as u^q does (slip begins with what stick bears, however small q), is off
by the order e^q near e, and by (1 - q/2) (e/u)^2 of itself far above. Slip that begins slowly
passes there in a time of the order sqrt(e), so that a motion is off by the order e^(q + 1/2). A
period of stick-slip is off by 1e-12 of itself from q = 1.5 on, by 2e-11 at q = 1, by 1e-9 at
q = 0.7, by 1e-6 at q = 1/2 and by 4e-6 at q = 0.3.

A step there is as short as e v_0 over the rate of the slip velocity. It must not be lost in the
time since the beginning (2e-16 of it): e is no smaller than the exponent needs.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from sympy import Expr


def eased(expression: Expr, v: Expr) -> Expr:
    """`expression` with a series at v = 0: powers of what vanishes there are smoothed."""
    import sympy

    return sympy.sympify(expression).replace(
        lambda one: one.is_Pow and _breaks(one, v),
        lambda one: one.base**2 * (one.base**2 + _square_of_width(one.exp)) ** (one.exp / 2 - 1),
    )


def _breaks(power: Expr, v: Expr) -> bool:
    is_whole = power.exp.is_Number and power.exp == int(power.exp)
    return not is_whole and power.base.subs(v, 0) == 0


def _square_of_width(exponent: Expr) -> Expr:
    import sympy

    return sympy.Integer(10) ** (-2 * (6 + 3 / (1 + exponent**4)))
