"""Coulomb friction with stiction.

F_T = sgn(v) mu_k N          sliding        (thesis 3.5, 6.3, 7.14)
|F_T| <= mu_s N              sticking       (thesis 3.9, 6.8, 7.16)

In transient motions mu_k must not exceed mu_s: such a contact could neither stick nor slip.
"""

from __future__ import annotations

from fiv_cli.friction.base import Law
from fiv_cli.models.base import Parameter

MU_K = Parameter("mu_k", r"\mu_k", "1", 0.3, "coefficient of kinetic friction", "3.5", minimum=0.0)
MU_S = Parameter("mu_s", r"\mu_s", "1", 0.4, "coefficient of static friction", "3.9", minimum=0.0)

LAW = Law(
    name="coulomb",
    title="Coulomb friction with stiction",
    reference="thesis 3.5, 3.9",
    numerics_version=1,
    parameters=(MU_S, MU_K),
    force=lambda slip, p: slip.sign * p["mu_k"] * slip.N,
    capacity=lambda N, p: p["mu_s"] * N,
)
