"""A ball that bounces once a period of a shaking table (`small_models.BALL`), in closed form.

It leaves at g T/2 and comes back at -g T/2, so the table moves at TABLE_SPEED = -A omega sin(phase)
where they meet.
"""

from __future__ import annotations

from math import asin, cos, pi

import numpy as np
from numpy.typing import NDArray

GRAVITY, RESTITUTION, OMEGA, PERIOD = 10.0, 0.8, 2 * pi, 1.0
TABLE_SPEED = (1 - RESTITUTION) / (1 + RESTITUTION) * GRAVITY * PERIOD / 2


def impact_phase(amplitude: float, stable: bool) -> float:
    """Phase of the table at which the ball meets it, rad; there are two."""
    first = asin(-TABLE_SPEED / (amplitude * OMEGA))
    return first if stable else pi - first


def in_flight(amplitude: float, phase: float, flown: float) -> dict[str, float]:
    """The ball so many seconds after an impact at a phase of the table."""
    leaving = GRAVITY * PERIOD / 2
    height = amplitude * cos(phase) + leaving * flown - GRAVITY * flown**2 / 2
    return {"z": height, "z_dot": leaving - GRAVITY * flown}


def multipliers(amplitude: float, phase: float) -> NDArray[np.complex128]:
    """Multipliers: the bouncing ones have product e^2 and the trace of the linearised map."""
    acceleration, e = -amplitude * OMEGA**2 * cos(phase), RESTITUTION
    trace = 1 - e + (e * GRAVITY + (1 + e) * acceleration) * (1 + e) / GRAVITY
    idle = np.exp(np.roots([1.0, 0.2, 1.0]) * PERIOD)  # x, which takes no part
    return np.sort_complex(np.concatenate([np.roots([1.0, -trace, e**2]), idle]))
