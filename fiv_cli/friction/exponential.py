"""Friction that falls exponentially from its value at rest to its kinetic value.

    F_T = sgn(v) (mu_k + (mu_0 - mu_k) exp(-alpha |v|)) N     sliding
    |F_T| <= mu_s N                                           sticking

Thesis 4.5 (where mu_k is called mu_1) and 5.18 (where mu_0 = mu_s). With alpha = 0 it is
Coulomb's law with the coefficient mu_0.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from fiv_cli.friction.base import Law, Slip
from fiv_cli.friction.coulomb import MU_K, MU_S
from fiv_cli.models.base import Parameter


def force(slip: Slip, p: Mapping[str, Any]) -> Any:
    """F_T in N (thesis 4.5, 5.18)."""
    import sympy

    decay = sympy.exp(-p["alpha"] * slip.speed)
    return slip.sign * (p["mu_k"] + (p["mu_0"] - p["mu_k"]) * decay) * slip.N


LAW = Law(
    name="exponential",
    title="Coulomb friction that falls exponentially with speed",
    reference="thesis 4.5, 5.18",
    numerics_version=1,
    parameters=(
        MU_S,
        MU_K,
        Parameter(
            "mu_0",
            r"\mu_0",
            "1",
            None,
            "coefficient of kinetic friction at rest",
            "4.5",
            0.0,
            default_from="mu_s",
        ),
        Parameter("alpha", r"\alpha", "s m-1", 1.0, "rate of the fall", "4.5", 0.0),
    ),
    force=force,
    capacity=lambda N, p: p["mu_s"] * N,
)
