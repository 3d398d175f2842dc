"""The base-excited belt as an expert writes it with SciPy: DOP853, events, state by state.

The opponent of the benchmark: `solve_ivp` with terminal event functions, restarted at every
transition, stick integrated as the linear motion that it is. Nothing of fiv is used.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import solve_ivp


def stick_points(
    omega: float, t_end: float, rtol: float, u0: float = 0.5
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """States at slip->stick and the final state; m = k = v = 1, N = 10, mu_s .4, mu_k .23."""
    kinetic, static = 2.3, 4.0
    t, x, velocity = 0.0, 0.0, 0.0
    points = []
    sticking, sign = False, 1.0

    def slip(t: float, y: NDArray[np.float64]) -> list[float]:
        return [y[1], -y[0] + u0 * np.cos(omega * t) + sign * kinetic]

    def meets_belt(t: float, y: NDArray[np.float64]) -> float:
        return sign * (1.0 - y[1])

    def stick(t: float, y: NDArray[np.float64]) -> list[float]:
        return [1.0]

    def released(t: float, y: NDArray[np.float64]) -> float:
        return static - abs(y[0] - u0 * np.cos(omega * t))

    for event in (meets_belt, released):
        event.terminal = True  # type: ignore[attr-defined]
        event.direction = -1.0  # type: ignore[attr-defined]
    options = {"method": "DOP853", "rtol": rtol, "atol": rtol}
    while t < t_end:
        if sticking:
            found = solve_ivp(stick, (t, t_end), [x], events=released, **options)
            t, x, velocity = found.t[-1], found.y[0, -1], 1.0
            if found.status == 1:
                sticking, sign = False, np.sign(x - u0 * np.cos(omega * t))
        else:
            found = solve_ivp(slip, (t, t_end), [x, velocity], events=meets_belt, **options)
            t, x, velocity = found.t[-1], found.y[0, -1], found.y[1, -1]
            if found.status == 1:
                demand = x - u0 * np.cos(omega * t)
                sticking = abs(demand) <= static
                sign = sign if sticking else np.sign(demand)
                velocity = 1.0
                if sticking:
                    points.append((x, velocity))
    return np.array(points), np.array([x, velocity])
