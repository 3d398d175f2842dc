"""A friction law averaged over a fast oscillation of the slip velocity (thesis 5.13, 5.14).

    F_T(v) = (1/2pi) int_0^2pi f(v + U cos s) ds,    f: the law that is averaged

U, m/s, is the amplitude of the slip velocity that a high-frequency tangential excitation makes;
the averaged system is the model without the excitation under this law. The average is analytic
where the fast motion reverses slip (|v| < U) and where it does not (|v| >= U), but not across:
there are two laws, and the equilibrium's v decides which one applies. There is no stick.

A law states its average in its own file (`Law.average`), in closed form or as a quadrature that
is split where the fast velocity passes through zero, so that it can be differentiated exactly.
Laws regularised by tanh have none: their average tends to that of the law that they regularise,
which is the one to use.
"""

from __future__ import annotations

from collections.abc import Mapping
from functools import cache
from typing import TYPE_CHECKING

from fiv_cli.friction.base import Law, Slip
from fiv_cli.models.base import Parameter

if TYPE_CHECKING:
    from sympy import Expr

FAST_VELOCITY = Parameter(
    "fast_velocity", "U", "m s-1", None, "amplitude of the fast slip velocity", "5.14", 0.0
)


@cache
def averaged(law: Law, reversing: bool) -> Law:
    """`law` averaged over a fast slip velocity that does, or does not, reverse slip.

    Parameters
    ----------
    law : a law with an `average`
    reversing : whether the amplitude `FAST_VELOCITY` is above the slip speed
    """
    average = law.average
    assert average is not None, f"{law.name} states no average"

    def force(slip: Slip, p: Mapping[str, Expr]) -> Expr:
        return average(slip, p, p[FAST_VELOCITY.name], reversing)

    kind = "reversing" if reversing else "one-way"
    return Law(
        name=f"{kind} average of {law.name}",
        title=f"{law.title}, averaged over a fast {kind} slip",
        reference="thesis 5.13, 5.14",
        numerics_version=law.numerics_version,
        parameters=(*law.parameters, FAST_VELOCITY),
        force=force,
        capacity=None,
        structural=law.structural,
    )
