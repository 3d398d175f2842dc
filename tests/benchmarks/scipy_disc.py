"""Chapter 4's slider on an elastic disc, by an expert with SciPy: DOP853, events, restarts.

Slip and stick in permanent contact on a decelerating disc; the algebraic normal force in closed
form, array operations over the seven modes. Nothing of fiv's equations is used.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import solve_ivp

ORDER = np.array([0.0, 1, 1, 2, 2, 3, 3])
PHASE = np.array([0.0, *[0.0, -np.pi / 2] * 3])  # sines are cosines turned back
PARTNER = np.array([0, 2, 1, 4, 3, 6, 5])
TURN = np.array([0.0, *[1.0, -1.0] * 3]) * ORDER
R0, H, M, K_Z, K_PHI, N0 = 0.1, 0.002, 0.1, 3e4, 2000.0, 500.0
MU_0, MU_1, MU_S, ALPHA = 0.6, 0.35, 0.8, 1.0
FIRST_STEP = 1e-6  # s: after a transition an event function starts at zero

Vector = NDArray[np.float64]


class Slider:
    """State (phi, q, phi', q'); z = w(r0, phi) throughout."""

    def __init__(
        self, mobility: Vector, omega: Vector, start: float, stop: float, over: float,
        c_z: float, c_phi: float,
    ) -> None:  # fmt: skip
        self.mobility, self.squares = mobility, omega**2
        self.start, self.deceleration = start, (stop - start) / over
        self.c_z, self.c_phi = c_z, c_phi

    def speed(self, t: float) -> float:
        """Omega."""
        return self.start + self.deceleration * t

    def solve(self, t: float, y: Vector, sign: float) -> tuple[float, Vector, float, float]:
        """phi'', q'', F_N and F_T; sign 0: in stick."""
        phi, q, phi_dot, q_dot = y[0], y[1:8], y[8], y[9:]
        speed, angle = self.speed(t), ORDER * phi + PHASE
        n, g = np.cos(angle), -ORDER * np.sin(angle)
        free = ((ORDER * speed) ** 2 - self.squares) * q
        free -= TURN * (2 * speed * q_dot[PARTNER] + self.deceleration * q[PARTNER])
        slope, inertia = g @ q, M * R0**2
        z, z_dot = n @ q, n @ q_dot + phi_dot * slope
        held = self.c_phi * phi_dot + K_PHI * phi
        lever = H / (2 * R0)
        rest = N0 + self.c_z * z_dot + K_Z * z
        rest += M * (2 * phi_dot * (g @ q_dot) - phi_dot**2 * ((ORDER**2 * n) @ q) + n @ free)
        pressed = 1 + M * (self.mobility * n) @ n
        turned = M * lever * (self.mobility * n) @ g
        if sign:
            v = R0 * (speed - phi_dot)
            mu = sign * (MU_1 + (MU_0 - MU_1) * np.exp(-ALPHA * sign * v))
            rest -= M * slope * held / inertia
            normal = rest / (pressed - mu * (turned + M * slope * R0 / inertia))
            friction = mu * normal
            turning = (R0 * friction - held) / inertia
        else:
            turning = self.deceleration
            friction = (inertia * turning + held) / R0
            normal = (rest + M * slope * turning + turned * friction) / pressed
        modal = free + self.mobility * (lever * friction * g - normal * n)
        return turning, modal, normal, friction

    def rate(self, t: float, y: Vector, sign: float) -> Vector:
        """Rate of the state."""
        turning, modal, _, _ = self.solve(t, y, sign)
        return np.concatenate([y[8:], [turning], modal])

    def events(self, sign: float) -> list[Any]:
        """What ends slip or stick."""
        if sign:
            functions = [lambda t, y: sign * (self.speed(t) - y[8])]
        else:
            functions = [self._margin(1.0), self._margin(-1.0)]
        for function in functions:
            function.terminal, function.direction = True, -1.0  # type: ignore[attr-defined]
        return functions

    def _margin(self, side: float) -> Any:
        def margin(t: float, y: Vector) -> float:
            _, _, normal, friction = self.solve(t, y, 0.0)
            return MU_S * normal - side * friction

        return margin


def run(slider: Slider, t_end: float, rtol: float, max_step: float) -> tuple[Vector, Vector]:
    """Event times and the final state of the motion from rest."""
    t, y, sign, times = 0.0, np.zeros(16), 1.0, []
    while t < t_end:
        found = _stretch(slider, t, t_end, y, sign, rtol, max_step)
        t, y = float(found.t[-1]), found.y[:, -1].copy()
        if found.status != 1:
            break
        times.append(t)
        if sign:
            y[8] = slider.speed(t)
            _, _, normal, friction = slider.solve(t, y, 0.0)
            sign = 0.0 if abs(friction) <= MU_S * normal else float(np.sign(friction))
        else:
            sign = 1.0 if len(found.t_events[0]) else -1.0
    return np.array(times), y


def _stretch(
    slider: Slider, t: float, t_end: float, y: Vector, sign: float, rtol: float, max_step: float
) -> Any:
    """One contact state, to its end."""
    return solve_ivp(
        lambda t, y: slider.rate(t, y, sign), (t, t_end), y, method="DOP853", rtol=rtol,
        atol=rtol * 1e-3, events=slider.events(sign), max_step=max_step,
        first_step=min(FIRST_STEP, t_end - t),
    )  # fmt: skip
