"""The five-degree-of-freedom slider as an expert writes it with SciPy: DOP853, events, restarts.

The opponent of the benchmark: `solve_ivp` with terminal event functions, restarted at every
transition, plastic impact, right-hand sides in plain floating-point arithmetic (faster here than
array operations on ten entries). Nothing of fiv is used.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import solve_ivp

M = m = 1.0
J = 0.1
C = 0.1
K1, K2, K3, K4, K5, K6 = 1e4, 5e3, 6e3, 1e4, 1e4, 1e4
ARM = 0.2
V, F, K_NL = 1.0, 200.0, 1e4
FIRST_STEP = 1e-4  # s: at a reversal an event function starts at zero and must have risen

Vector = NDArray[np.float64]
Floats = list[float]


def compression(y: Sequence[float]) -> float:
    """y2 - (x1 - x2) phi - y1, m."""
    return y[3] - (y[0] - y[2]) * y[4] - y[1]


def normal_force(y: Sequence[float]) -> float:
    """F_N, N."""
    d = compression(y)
    return K2 * d + K_NL * d * d * d


def motion(y: Sequence[float], friction: float, normal: float) -> Floats:
    """Rates of (x1, y1, x2, y2, phi) and of their rates (thesis 6.1)."""
    x1, y1, x2, y2, phi, x1_dot, y1_dot, x2_dot, y2_dot, phi_dot = y
    diagonal = 0.5 * K3 * (x1 - y1)
    first = C * (y2_dot + ARM * phi_dot) + K5 * (y2 + ARM * phi)
    second = C * (y2_dot - ARM * phi_dot) + K6 * (y2 - ARM * phi)
    return [
        x1_dot,
        y1_dot,
        x2_dot,
        y2_dot,
        phi_dot,
        (friction - C * x1_dot - K1 * x1 - diagonal) / M,
        (normal - F - C * y1_dot + diagonal) / M,
        (-friction - C * x2_dot - K4 * x2) / m,
        (-normal - first - second) / m,
        (normal * (x1 - x2) - ARM * (first - second)) / J,
    ]


def held(y: Sequence[float]) -> float:
    """Friction force that keeps slider and belt together (thesis 6.6), N."""
    slider = C * y[5] + K1 * y[0] + 0.5 * K3 * (y[0] - y[1])
    belt = C * y[7] + K4 * y[2]
    return slider - M * (slider + belt) / (M + m)


def struck(y: Vector) -> Vector:
    """The state after a plastic impact (thesis 6.10-6.12 with the full gap rate)."""
    lever = y[0] - y[2]
    closing = y[8] - lever * y[9] - (y[5] - y[7]) * y[4] - y[6]
    impulse = closing / (1 / M + 1 / m + lever**2 / J)
    after = y.copy()
    after[6] += impulse / M
    after[8] -= impulse / m
    after[9] += impulse * lever / J
    return after


def ends(function: Callable[[Floats], float]) -> Callable[[float, Vector], float]:
    """An event where `function` falls to zero."""

    def event(t: float, y: Vector) -> float:
        return function(y.tolist())

    event.terminal = True  # type: ignore[attr-defined]
    event.direction = -1.0  # type: ignore[attr-defined]
    return event


OPENS = ends(compression)
CLOSES = ends(lambda y: -compression(y))


def stick_points(
    mu_k: float, t_end: float, rtol: float, max_step: float = np.inf, mu_s: float = 3.0
) -> tuple[Vector, Vector]:
    """States at slip->stick and the final state, from zero.

    SciPy looks for an event by its sign at the ends of a step, so a pair of roots inside one step
    is missed; `max_step` bounds what can be missed.
    """
    t, y, state, sign = 0.0, np.zeros(10), "slip", 1.0
    points = []

    def slip(t: float, y: Vector) -> Floats:
        values = y.tolist()
        normal = normal_force(values)
        return motion(values, sign * mu_k * normal, normal)

    def stick(t: float, y: Vector) -> Floats:
        values = y.tolist()
        return motion(values, held(values), normal_force(values))

    def flight(t: float, y: Vector) -> Floats:
        return motion(y.tolist(), 0.0, 0.0)

    meets_belt = ends(lambda y: sign * (V + y[7] - y[5]))
    released = ends(lambda y: mu_s * normal_force(y) - abs(held(y)))
    states: dict[str, tuple[Any, list[Any]]] = {
        "slip": (slip, [meets_belt, OPENS]),
        "stick": (stick, [released, OPENS]),
        "separation": (flight, [CLOSES]),
    }
    while t < t_end:
        rate, events = states[state]
        found = solve_ivp(
            rate, (t, t_end), y, method="DOP853", events=events, rtol=rtol, atol=rtol * 1e-2,
            max_step=max_step, first_step=min(FIRST_STEP, t_end - t),
        )  # fmt: skip
        t, y = found.t[-1], found.y[:, -1]
        if found.status != 1:
            break
        if state == "separation":
            y = struck(y)
            state, sign = "slip", float(np.sign(V + y[7] - y[5]))
        elif len(found.t_events[-1]):
            state = "separation"
        elif state == "stick":
            state, sign = "slip", float(np.sign(held(y)))
        else:
            y[5] = V + y[7]
            demand = held(y)
            if abs(demand) <= mu_s * normal_force(y):
                state = "stick"
                points.append(y.copy())
            else:
                sign = float(np.sign(demand))
    return np.array(points), y
