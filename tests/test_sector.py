"""A pin on the border of its sector: the motion belongs to the side that it goes on into."""

from __future__ import annotations

from math import cos, pi, sin, sqrt
from typing import Any

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st
from motions import TIGHT, motion, times, transitions

from fiv_cli.analyses.base import SolverSettings
from fiv_cli.dynamics.motion import Motion, Stop

# Without springs k2 and k3 the normal force is N0 and phi a harmonic oscillator between events.
FREE = {"k2": 0.0, "k3": 0.0, "c1": 0.0, "c2": 0.0}
STIFFNESS, INERTIA, ARM, PRELOAD, SPEED = 15.0, 12e-4, 0.1, 30.0, 2.0
FREQUENCY = sqrt(STIFFNESS / INERTIA)
OUTSIDE, INSIDE = (0.4, 0.23), (0.3, 0.2)  # static, kinetic
SPAN = 1.0
STEPWISE = SolverSettings("rk4", 1e-13, 1e-4)
SPEEDS = st.floats(-10.0, 10.0).filter(lambda speed: abs(speed - SPEED) > 1e-3)


def pin(phi: float, speed: float, psi_a: float, solver: Any = TIGHT, **changes: float) -> Motion:
    """The free pin, which stands at the angle -phi of the disc."""
    start = {"phi": phi, "phi_dot": speed}
    parameters = FREE | {"beta": SPAN, "psi_a": psi_a} | changes
    return motion("pin-on-disc", start=start, solver=solver, **parameters)


def start_of_sector(phi: float, border: str, turns: int = 0) -> float:
    """psi_a for which the pin at `phi` stands on the border."""
    return -phi - (SPAN if border == "end" else 0.0) + 2 * pi * turns


def side(border: str, upwards: bool) -> tuple[float, float]:
    """Coefficients of friction of the side that a motion goes into."""
    return INSIDE if upwards is (border == "start") else OUTSIDE


def arc(phi: float, speed: float, friction: float, t: float) -> tuple[float, float]:
    """phi and its rate after slip under the constant force `friction`."""
    rest = friction * ARM / STIFFNESS
    angle = FREQUENCY * t
    return (
        rest + (phi - rest) * cos(angle) + speed / FREQUENCY * sin(angle),
        speed * cos(angle) - (phi - rest) * FREQUENCY * sin(angle),
    )


def until_rest(phi: float, speed: float, friction: float) -> float:
    """A time over which slip under `friction` neither ends nor reaches the other border."""
    rest = friction * ARM / STIFFNESS
    fastest = sqrt(((phi - rest) * FREQUENCY) ** 2 + speed**2)
    steepest = FREQUENCY * fastest  # rate of the speed
    return min(0.5 * abs(speed - SPEED) / steepest, 0.5 * SPAN / (fastest + SPEED))


# --- slipping ------------------------------------------------------------------------------------
@pytest.mark.parametrize("solver", [TIGHT, STEPWISE], ids=["taylor", "rk4"])
@pytest.mark.parametrize("border", ["start", "end"])
@settings(max_examples=30)
@given(phi=st.floats(-3.0, 3.0), speed=SPEEDS, turns=st.integers(-3, 3))
@example(phi=0.0, speed=5.0, turns=0)
@example(phi=0.0, speed=-5.0, turns=1)
@example(phi=-2 * pi, speed=-5.0, turns=0)
@example(phi=-2 * pi, speed=5.0, turns=0)
def test_a_slip_that_begins_on_a_border(
    border: str, solver: Any, phi: float, speed: float, turns: int
) -> None:
    upwards = speed < SPEED
    friction = side(border, upwards)[1] * PRELOAD * (1.0 if upwards else -1.0)
    end = until_rest(phi, speed, friction)
    begun = pin(phi, speed, start_of_sector(phi, border, turns), solver)
    assert begun.run(end) == Stop.REACHED
    assert transitions(begun) == []
    expected = arc(phi, speed, friction, end)
    np.testing.assert_allclose(begun.y[[0, 2]], expected, rtol=1e-9, atol=1e-9)


@pytest.mark.parametrize("border", ["start", "end"])
@pytest.mark.parametrize("speed", [-4.0, 0.0, 2.5, 6.0])
@pytest.mark.parametrize("away", [1e-4, 1e-6, 1e-9])
def test_a_slip_across_a_border(border: str, speed: float, away: float) -> None:
    """From a little before it: the friction of one side up to it, of the other from there."""
    upwards = speed < SPEED
    sign = 1.0 if upwards else -1.0
    begun = pin(0.01, speed, start_of_sector(0.01, border) + sign * away)
    first = side(border, not upwards)[1] * PRELOAD * sign
    second = side(border, upwards)[1] * PRELOAD * sign
    low, high = 0.0, 2.0 * away / abs(speed - SPEED)
    for _ in range(100):
        t = 0.5 * (low + high)
        crossed = sign * (SPEED * t - arc(0.01, speed, first, t)[0] + 0.01) >= away
        low, high = (low, t) if crossed else (t, high)
    end = high + until_rest(*arc(0.01, speed, first, high), second)
    assert begun.run(end) == Stop.REACHED
    expected = arc(*arc(0.01, speed, first, high), second, end - high)
    np.testing.assert_allclose(begun.y[[0, 2]], expected, rtol=0, atol=1e-12)
    assert len(times(begun)) == 1
    assert times(begun)[0] == pytest.approx(high, abs=1e-13)


@pytest.mark.parametrize("beta", [0.0, 2 * pi])
@pytest.mark.parametrize("speed", [-4.0, 2.0, 6.0])
def test_no_border_without_a_sector_or_an_outside(beta: float, speed: float) -> None:
    begun = pin(0.0, speed, 0.0, beta=beta)
    uniform = motion(
        "pin-on-disc", start={"phi_dot": speed}, **FREE,
        mu_s=(OUTSIDE if beta == 0.0 else INSIDE)[0], mu_k=(OUTSIDE if beta == 0.0 else INSIDE)[1],
    )  # fmt: skip
    begun.run(10.0)
    uniform.run(10.0)
    assert transitions(begun) == transitions(uniform)
    np.testing.assert_allclose(begun.y, uniform.y, rtol=0, atol=1e-12)


# --- at rest on the disc -------------------------------------------------------------------------
@pytest.mark.parametrize("border", ["start", "end"])
@pytest.mark.parametrize("phi", [-0.2, -0.09, 0.081, 0.15])
@pytest.mark.parametrize("turns", [0, 1])
def test_at_rest_the_acceleration_decides(border: str, phi: float, turns: int) -> None:
    """The spring demands more than either side can hold, 12 N outside: it slips its way."""
    upwards = phi > 0.0
    friction = side(border, upwards)[1] * PRELOAD * (1.0 if upwards else -1.0)
    begun = pin(phi, SPEED, start_of_sector(phi, border, turns))
    end = 0.2 / FREQUENCY
    begun.run(end)
    assert transitions(begun) == []
    np.testing.assert_allclose(begun.y[[0, 2]], arc(phi, SPEED, friction, end), atol=1e-12)


@pytest.mark.parametrize("border", ["start", "end"])
@pytest.mark.parametrize("phi", [0.0, 0.03, 0.059, 0.07])
def test_a_pin_that_sticks_on_a_border_is_held_by_the_side_it_will_slip_into(
    border: str, phi: float
) -> None:
    """The disc carries it until the spring demands the capacity of the side above."""
    static, kinetic = side(border, upwards=True)
    limit = static * PRELOAD * ARM / STIFFNESS
    begun = pin(phi, SPEED, start_of_sector(phi, border))
    release = max((limit - phi) / SPEED, 0.0)
    end = release + 0.2 / FREQUENCY
    begun.run(end)
    assert transitions(begun) == ["stick->slip+"] * (phi < limit)
    assert times(begun) == pytest.approx([release] * (phi < limit), abs=1e-13)
    at_release = max(limit, phi)
    expected = arc(at_release, SPEED, kinetic * PRELOAD, end - release)
    np.testing.assert_allclose(begun.y[[0, 2]], expected, rtol=0, atol=1e-11)


def test_a_disc_at_rest_holds_the_pin_on_the_border_by_the_side_it_is_pushed_to() -> None:
    """10 N are too much for the sector, which holds 9 N, and not for the rest of the disc."""
    pushed = 10.0 * ARM / STIFFNESS
    for phi, border, sticks in [
        (pushed, "start", False), (pushed, "end", True),
        (-pushed, "start", True), (-pushed, "end", False),
    ]:  # fmt: skip
        begun = pin(phi, 1e-3, start_of_sector(phi, border), Omega=1e-3)
        begun.run(0.01)
        assert bool(begun.y[2] == 1e-3) is sticks
        assert begun.n_events == 0


def test_with_no_force_at_all_it_belongs_to_the_side_above() -> None:
    """Thrown off a border where it sticks, it may go either way; the sector is half open."""
    begun = pin(0.0, SPEED, 0.0, k1=0.0)
    begun.run(1.0)
    assert begun.frame.parameters[-1] == 1.0
    assert (begun.n_events, begun.y[2]) == (0, SPEED)


# --- beside the border ---------------------------------------------------------------------------
@pytest.mark.parametrize("border", ["start", "end"])
@settings(max_examples=40)
@given(
    phi=st.floats(-0.15, 0.15),
    speed=st.one_of(st.just(SPEED), SPEEDS),
    off=st.sampled_from([1e-9, 1e-12, 1e-15]),
    turns=st.integers(-2, 2),
)
@example(phi=0.0, speed=2.0, off=1e-12, turns=0)
def test_on_the_border_is_beside_it_on_the_side_it_moves_into(
    border: str, phi: float, speed: float, off: float, turns: int
) -> None:
    """The whole pin, past its first release: springs, damping and a varying normal force."""
    place = start_of_sector(phi, border, turns)
    on = full_pin(phi, speed, place)
    moved = full_pin(phi, speed, place)
    moved.run(1e-6)
    upwards = speed < SPEED or (speed == SPEED and goes_up(moved, phi))
    beside = full_pin(phi, speed, place - (off if upwards else -off))
    assert on.run(0.02) == beside.run(0.02) == Stop.REACHED
    assert transitions(on) == transitions(beside)
    np.testing.assert_allclose(on.y, beside.y, rtol=0, atol=1e-6)


def full_pin(phi: float, speed: float, psi_a: float) -> Motion:
    """The pin with every spring, on a disc of 2 rad/s."""
    start = {"phi": phi, "phi_dot": speed}
    return motion("pin-on-disc", start=start, beta=SPAN, psi_a=psi_a)


def goes_up(moved: Motion, phi: float) -> bool:
    """Whether a pin that began at rest on the disc goes, or is carried on, to larger angles."""
    sticks = moved.y[2] == SPEED
    return phi > 0.0 if sticks else bool(moved.y[2] < SPEED)
