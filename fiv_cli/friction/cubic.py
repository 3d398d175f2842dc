"""Friction that falls to a least value and rises again, as a cubic in the slip speed.

    F_T = (mu_s sgn(v) - k_1 v + k_3 v^3) N,                                        sliding
    k_1 = 3/2 (mu_s - mu_m)/v_m,   k_3 = 1/2 (mu_s - mu_m)/v_m^3
    |F_T| <= mu_s N                                                                 sticking

The least coefficient is mu_m, at |v| = v_m. Thomsen & Fidlin, International Journal of Non-Linear
Mechanics 38 (2003) 389-403, who give the amplitude of its stick-slip in closed form. It stands for
a Stribeck curve up to a few v_m; beyond, it rises without bound.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

from fiv_cli.friction.base import Law, Slip
from fiv_cli.friction.coulomb import MU_S
from fiv_cli.models.base import Parameter, Requirement

if TYPE_CHECKING:
    from sympy import Expr


def force(slip: Slip, p: Mapping[str, Expr]) -> Expr:
    """F_T in N."""
    fall, relative = p["mu_s"] - p["mu_m"], slip.speed / p["v_m"]
    return slip.sign * (p["mu_s"] - fall * (3 * relative - relative**3) / 2) * slip.N


LAW = Law(
    name="cubic",
    title="friction that falls to a least value and rises, cubic in the slip speed",
    reference="Thomsen & Fidlin, Int. J. Non-Linear Mech. 38 (2003) 389",
    numerics_version=1,
    parameters=(
        MU_S,
        Parameter("mu_m", r"\mu_m", "1", 0.25, "least coefficient of friction", "", 0.0),
        Parameter(
            "v_m", "v_m", "m s-1", 0.5, "slip speed of the least friction", "", 0.0, exclusive=True
        ),
    ),
    force=force,
    capacity=lambda N, p: p["mu_s"] * N,
    requirements=(
        Requirement(
            ("mu_m", "mu_s"),
            lambda p: p["mu_m"] <= p["mu_s"],
            "mu_m <= mu_s",
            "mu_m is above mu_s",
            "mu_k_above_mu_s",
            in_motion=True,
        ),
    ),
)
