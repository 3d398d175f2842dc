"""The base-excited belt as an expert writes it with SciPy: DOP853, events, state by state.

The opponent of the benchmark: `solve_ivp` with terminal event functions, restarted at every
transition. Nothing of fiv is used.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import solve_ivp


def stick_points(
    omega: float, t_end: float, rtol: float, max_step: float = np.inf, u0: float = 0.5
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """States at slip->stick and the final state; m = k = v = 1, N = 10, mu_s .4, mu_k .23.

    SciPy looks for an event by its sign at the ends of a step, so a pair of roots inside one step
    is missed; `max_step` bounds what can be missed.
    """
    kinetic, static = 2.3, 4.0
    t, state = 0.0, np.array([0.0, 0.0])
    points = []
    sticking, sign = False, 1.0

    def base(t: float) -> float:
        return u0 * np.cos(omega * t)

    def slip(t: float, y: NDArray[np.float64]) -> list[float]:
        return [y[1], -(y[0] - base(t)) + sign * kinetic]

    def stick(t: float, y: NDArray[np.float64]) -> list[float]:
        return [1.0, 0.0]

    def meets_belt(t: float, y: NDArray[np.float64]) -> float:
        return sign * (1.0 - y[1])

    def released(t: float, y: NDArray[np.float64]) -> float:
        return static - abs(y[0] - base(t))

    for event in (meets_belt, released):
        event.terminal = True  # type: ignore[attr-defined]
        event.direction = -1.0  # type: ignore[attr-defined]
    while t < t_end:
        motion, event = (stick, released) if sticking else (slip, meets_belt)
        found = solve_ivp(
            motion, (t, t_end), state, "DOP853", events=event, rtol=rtol, atol=rtol,
            max_step=max_step,
        )  # fmt: skip
        t, state = found.t[-1], found.y[:, -1]
        if found.status != 1:
            break
        state[1] = 1.0
        demand = state[0] - base(t)
        if not sticking and abs(demand) <= static:
            sticking = True
            points.append(state.copy())
        else:
            sticking, sign = False, float(np.sign(demand))
    return np.array(points), state
