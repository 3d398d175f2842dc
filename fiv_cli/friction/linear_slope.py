"""Friction that varies linearly with the slip speed.

    F_T = sgn(v) (F0 + alpha_0 |v|)     sliding    (thesis 3.2, with v_r = |v|)
    |F_T| <= F0                         sticking

The law is a force, not a coefficient: the normal force does not enter. Section 3.1.1 gives no
static capacity; F0 makes the law continuous at v = 0 (so mu_s N = F0). A falling one passes zero at
|v| = F0/(-alpha_0), beyond which it drives: it is for slower slip.
"""

from __future__ import annotations

from fiv_cli.friction.base import Law
from fiv_cli.models.base import Parameter

LAW = Law(
    name="linear-slope",
    title="friction linear in the slip speed",
    reference="thesis 3.2",
    numerics_version=1,
    parameters=(
        Parameter("F0", "F_0", "N", 10.0, "friction force at zero slip speed", "3.2", 0.0),
        Parameter(
            "alpha_0",
            r"\alpha_0",
            "N s m-1",
            -0.1,
            "slope of the friction force",
            "3.2",
            role="fall",
        ),
    ),
    force=lambda slip, p: slip.sign * (p["F0"] + p["alpha_0"] * slip.speed),
    capacity=lambda N, p: p["F0"],
    constant_load=True,
)
