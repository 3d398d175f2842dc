"""Friction with two branches, one of slip that speeds up and a lower one of slip that slows down.

    F_T = sgn(v) (mu_k + (mu_s + Delta mu_s/(1 + |v|/v_s) - mu_k) g) N    speeding up
    F_T = sgn(v) (mu_k - (mu_s - mu_k) g) N                               slowing down
    |F_T| <= (mu_s + Delta mu_s) N                                        sticking
    g = exp(-|v|/v_s)

Thesis 2.7-2.10; Wojewoda, Stefanski, Wiercigroch & Kapitaniak, Phil. Trans. R. Soc. A 366 (2008)
747. g, which they leave open, and the velocity scale of Delta mu_s share v_s. Which branch holds is
told as in `stefanski`, by tanh(sgn(v) a/a_0), a of a slip velocity that is a time tau late: as
tau and a_0 tend to zero this is 2.7. In steady sliding F_T is the mean of the branches. With
Delta mu_s = 0 it is `stefanski`. Where mu_s > 2 mu_k slow slip that slows down is driven.

The branch of sticking is that of a contact stiffness k_S without bound: exact stick. With a finite
one, 2.8 takes v^2/(2|a|) for the way from rest. A free mass m that has stopped is then pushed back
by F_0 > 0, with m a^2 - F_0 a + k_S v^2/2 = 0: no a solves this above v = F_0/sqrt(2 k_S m), where
the mass slides, slows down, and is pushed off anew at each stop; it never rests. So there is no
pre-sliding here (`dahl`, `lugre` and others have it), and no implicit equation left to solve. The
stochastic part f_R is that of `hysteretic-rough`.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

from fiv_cli.friction import stefanski
from fiv_cli.friction.base import Law, Slip
from fiv_cli.models.base import Parameter

if TYPE_CHECKING:
    from sympy import Expr

RISE = Parameter(
    "Delta_mu_s",
    r"\Delta\mu_s",
    "1",
    0.1,
    "by how much break-away is above mu_s",
    "2.9",
    0.0,
    role="friction",
)


def force(slip: Slip, p: Mapping[str, Expr]) -> Expr:
    """F_T in N: what `stefanski` has, and Delta mu_s of the upper branch."""
    import sympy

    fall = sympy.exp(-slip.speed / p["v_s"]) / (1 + slip.speed / p["v_s"])
    rise = p["Delta_mu_s"] * fall * (1 + stefanski.sense(slip, p)) / 2
    return stefanski.force(slip, p) + slip.sign * rise * slip.N


LAW = Law(
    name="hysteretic",
    title="friction with an upper branch while slip speeds up and a lower one while it slows down",
    reference="thesis 2.7-2.10; Wojewoda et al., Phil. Trans. R. Soc. A 366 (2008) 747",
    numerics_version=1,
    parameters=(*stefanski.LAW.parameters, RISE),
    force=force,
    capacity=lambda N, p: (p["mu_s"] + p["Delta_mu_s"]) * N,
    states=stefanski.LAW.states,
    rates=stefanski.LAW.rates,
    requirements=stefanski.LAW.requirements,
)
