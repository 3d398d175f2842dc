"""Coulomb friction with stiction.

    F_T = sgn(v) mu_k N          sliding        (thesis 3.5, 6.3, 7.14)
    |F_T| <= mu_s N              sticking       (thesis 3.9, 6.8, 7.16)

In transient motions mu_k must not exceed mu_s: such a contact could neither stick nor slip.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

from fiv_cli.friction.base import Law, Slip
from fiv_cli.models.base import Parameter, Requirement

if TYPE_CHECKING:
    from sympy import Expr

MU_K = Parameter(
    "mu_k", r"\mu_k", "1", 0.3, "coefficient of kinetic friction", "3.5", 0.0, role="friction"
)
MU_S = Parameter(
    "mu_s", r"\mu_s", "1", 0.4, "coefficient of static friction", "3.9", 0.0, role="static friction"
)

FALLING = Requirement(
    ("mu_k", "mu_s"),
    lambda p: p["mu_k"] <= p["mu_s"],
    "mu_k <= mu_s",
    "mu_k is above mu_s",
    "mu_k_above_mu_s",
    in_motion=True,
)


def force(slip: Slip, p: Mapping[str, Expr]) -> Expr:
    """F_T in N (thesis 3.5)."""
    return slip.sign * p["mu_k"] * slip.N


def average(slip: Slip, p: Mapping[str, Expr], amplitude: Expr, reversing: bool) -> Expr:
    """F_T in N averaged over a fast slip velocity of this amplitude (thesis 5.14).

    The share of time in which slip is forward is arccos(-v/U)/pi, and
    -1 + (2/pi) arccos(-v/U) = (2/pi) arcsin(v/U).
    """
    import sympy

    if not reversing:
        return force(slip, p)
    return 2 / sympy.pi * sympy.asin(slip.v / amplitude) * p["mu_k"] * slip.N


LAW = Law(
    name="coulomb",
    title="Coulomb friction with stiction",
    reference="thesis 3.5, 3.9",
    numerics_version=1,
    parameters=(MU_S, MU_K),
    force=force,
    capacity=lambda N, p: p["mu_s"] * N,
    average=average,
    requirements=(FALLING,),
    only_in_stick=("mu_s",),
)
