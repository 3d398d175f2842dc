"""Friction that falls hyperbolically to a rest and rises with the square of the slip speed.

    F_T = sgn(v) mu_0 ((1 - d)/(1 + g |v|) + d + e v^2) N     sliding
    |F_T| <= mu_0 N                                           sticking

The hyperbolic law is d = e = 0, Coulomb's d = 1, e = 0. The static coefficient is the kinetic one
at rest; e stands for a rise within what was measured, not for one without bound.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

from fiv_cli.friction.base import Law, Slip
from fiv_cli.models.base import Parameter

if TYPE_CHECKING:
    from sympy import Expr


def force(slip: Slip, p: Mapping[str, Expr]) -> Expr:
    """F_T in N."""
    falling = (1 - p["d"]) / (1 + p["g"] * slip.speed)
    return slip.sign * p["mu_0"] * (falling + p["d"] + p["e"] * slip.speed**2) * slip.N


LAW = Law(
    name="four-parameter",
    title="friction falling hyperbolically to a rest, rising with the square of the speed",
    reference="Magnus, Schwingungen; Awrejcewicz & Dzyubak, Int. J. Bifurcation Chaos 15 (2005)",
    numerics_version=1,
    parameters=(
        Parameter("mu_0", r"\mu_0", "1", 0.4, "coefficient of friction at zero slip", "", 0.0),
        Parameter("d", "d", "1", 0.3, "share that does not fall", "", 0.0, 1.0),
        Parameter("g", "g", "s m-1", 1.42, "rate of fall with slip speed", "", 0.0),
        Parameter("e", "e", "s2 m-2", 0.01, "rise with the square of slip speed", "", 0.0),
    ),
    force=force,
    capacity=lambda N, p: p["mu_0"] * N,
)
