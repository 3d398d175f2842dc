"""Coulomb friction with static friction and a viscous part.

    F_T = mu_k N sgn(v) + F_V v     sliding    (thesis 2.2)
    |F_T| <= mu_s N                 sticking

The viscous part is a force that does not vanish with the load; in a contact that opens it does.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import TYPE_CHECKING

from fiv_cli.friction import coulomb
from fiv_cli.friction.base import Law, Slip
from fiv_cli.models.base import Parameter

if TYPE_CHECKING:
    from sympy import Expr

F_V = Parameter("F_V", "F_V", "N s m-1", 0.1, "viscous friction coefficient", "2.2", 0.0)


def with_viscous_part(law: Law) -> Callable[[Slip, Mapping[str, Expr]], Expr]:
    """F_T in N of `law`, and F_V v (thesis 2.2)."""
    return lambda slip, p: law.force(slip, p) + p["F_V"] * slip.v


LAW = replace(
    coulomb.LAW,
    name="viscous",
    title="Coulomb friction with a viscous part",
    reference="thesis 2.2",
    numerics_version=1,
    parameters=(*coulomb.LAW.parameters, F_V),
    force=with_viscous_part(coulomb.LAW),
    average=None,
)
