"""Friction that falls hyperbolically with the slip speed.

    F_T = sgn(v) mu_0 / (1 + delta |v|) N     sliding
    |F_T| <= mu_0 N                           sticking

Leine, van Campen, de Kraker & van den Steen, Nonlinear Dynamics 16 (1998) 41-54. It falls to
nothing, as 1/|v|: where friction comes to a rest or rises, `four_parameter` or `rational` stands.
"""

from __future__ import annotations

from fiv_cli.friction.base import Law
from fiv_cli.models.base import Parameter

LAW = Law(
    name="hyperbolic",
    title="friction falling hyperbolically with the slip speed",
    reference="Leine et al., Nonlinear Dynamics 16 (1998) 41",
    numerics_version=1,
    parameters=(
        Parameter("mu_0", r"\mu_0", "1", 0.4, "coefficient of friction at zero slip", "", 0.0),
        Parameter("delta", r"\delta", "s m-1", 3.0, "rate of fall with slip speed", "", 0.0),
    ),
    force=lambda slip, p: slip.sign * p["mu_0"] / (1 + p["delta"] * slip.speed) * slip.N,
    capacity=lambda N, p: p["mu_0"] * N,
)
