"""The cubic law against Thomsen & Fidlin's averaged amplitudes (thesis 2.2's Stribeck curve)."""

from __future__ import annotations

import numpy as np
import pytest
from motions import motion

from fiv_cli.analyses.base import SolverSettings

V_M = 0.5  # slip speed of the least friction, m/s


def settled(speed: float, fall: float) -> tuple[float, float]:
    """Largest speed of the settled mass on a belt, m/s, and the share of time that it sticks."""
    given = {"m": 1.0, "k": 1.0, "N": 1.0, "c": 0.0, "v_m": V_M, "v": speed}
    solver = SolverSettings(rtol=1e-9, max_events=10**6)
    begun = motion("belt-1dof", "cubic", {"x_dot": 0.3}, solver, **given, mu_s=0.5, mu_m=0.5 - fall)
    begun.run(400.0 / fall)
    begun.start_measuring(np.zeros(1))
    begun.run(450.0 / fall, measuring=True)
    measures = begun.measures
    return float(begun.extremes[1, 1]), float(measures.shares[0, 1] / measures.measured_time)


@pytest.mark.parametrize("speed", [0.92 * V_M, 0.97 * V_M])
def test_sliding_oscillations_have_the_averaged_amplitude(speed: float) -> None:
    """2 sqrt(v_m^2 - v^2), up to the square of the fall of friction: the small parameter."""
    averaged = 2.0 * np.sqrt(V_M**2 - speed**2)
    errors = [abs(settled(speed, fall)[0] - averaged) for fall in (0.04, 0.02)]
    assert errors[0] / errors[1] == pytest.approx(4.0, rel=0.05)


def test_stick_slip_stops_where_the_averaged_amplitude_meets_the_belt() -> None:
    """At v = sqrt(4/5) v_m sliding takes over; the vibration ends at v_m."""
    stop = np.sqrt(0.8) * V_M
    shares = [settled(factor * stop, 0.02)[1] for factor in (0.99, 1.01)]
    assert shares[0] > 0.0 == shares[1]
    assert settled(1.01 * V_M, 0.02)[0] < 1e-3
