"""A start in contact to rounding is in contact: the gap's derivatives or the force decide."""

from __future__ import annotations

from math import sqrt
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from motions import motion, times, transitions
from small_models import RAISED_BOUNCER

from fiv_cli.codegen.codes import CODE_SEPARATION, CODE_SLIP_PLUS
from fiv_cli.dynamics.motion import Motion, Stop

ULP = 2.0**-52
MODAL = {
    "C_0_0": -3e-5, "C_0_1": 7e-5, "D_0_1": -4e-5, "C_0_2": 2e-5, "D_0_2": 5e-5,
    "C_0_1_dot": 2e-2, "D_0_2_dot": -1e-2,
}  # fmt: skip
SIZE = sum(abs(value) for name, value in MODAL.items() if "dot" not in name)
DISC = {"phi": 0.3, "phi_dot": 1.0, **MODAL}
ALL = {"states": "all"}
# law, options, parameters that press it down, coordinate that closes the gap, the other ones
CASES: dict[str, Any] = {
    "disc-rigid-contact": ("coulomb", {}, {"Omega": 5.0}, "z", DISC),
    "excited-disc": ("exponential", ALL, {"Omega": 5.0, "F": 3e3}, "u", DISC),
    "disc-nonlinear-contact": ("coulomb", ALL, {"Omega": 5.0, "F": 3e3}, "u", DISC),
    "belt-5dof": (
        "coulomb", {}, {"F": 3e3}, "y1",
        {"x1": 0.013, "x2": -0.021, "y2": 3.3e-4, "phi": 7e-3, "x2_dot": 0.3, "phi_dot": 0.1},
    ),
}  # fmt: skip


def closed(name: str) -> tuple[float, float]:
    """The coordinate that leaves no gap, and its rate."""
    *_, start = CASES[name]
    if name != "belt-5dof":  # the rigid contact takes up its gap
        state = motion("disc-rigid-contact", "coulomb", {**start, "z": -1.0}, Omega=5.0).y
        return float(state[1]), float(state[1 + len(state) // 2])
    along = start["x1"] - start["x2"]
    rate = start["x2_dot"] * start["phi"] - along * start["phi_dot"]
    return start["y2"] - along * start["phi"], rate


def begun_with(name: str, gap: float, rate: float = 0.0) -> Motion:
    """A motion that begins with this gap and rate, to rounding."""
    law, options, pressed, coordinate, start = CASES[name]
    place, speed = closed(name)
    start = {**start, coordinate: place + gap, f"{coordinate}_dot": speed + rate}
    return motion(name, law, start, options=options, **pressed)


@pytest.mark.parametrize("name", CASES)
@settings(max_examples=15)
@given(ulps=st.integers(-20, 20), speed_ulps=st.integers(-20, 20))
def test_a_gap_of_rounding_is_none(name: str, ulps: int, speed_ulps: int) -> None:
    """It stays in contact, pressed by the preload, as one without rounding does."""
    begun = begun_with(name, ulps * 1e-4 * ULP, speed_ulps * 1e-2 * ULP)
    exact = begun_with(name, 0.0)
    assert begun.codes == exact.codes == [CODE_SLIP_PLUS]
    assert begun.run(2e-4) == exact.run(2e-4) == Stop.REACHED
    assert transitions(begun) == transitions(exact) == []
    np.testing.assert_allclose(begun.y, exact.y, rtol=1e-9, atol=1e-13)


@pytest.mark.parametrize("name", CASES)
@pytest.mark.parametrize("share", [1e-9, 1e-6])
def test_a_gap_beyond_rounding_falls_and_lands(name: str, share: float) -> None:
    """Under a constant acceleration: the preload's and the disc's."""
    gap = share * (SIZE if name != "belt-5dof" else 6e-4)
    begun = begun_with(name, gap)
    assert begun.codes == [CODE_SEPARATION]
    landing = landing_time(begun_with(name, gap), gap)
    begun.run(1.5 * landing)
    assert transitions(begun)[0] == "separation->slip+"
    assert times(begun)[0] == pytest.approx(landing, rel=1e-2)


def landing_time(begun: Motion, gap: float) -> float:
    """When a gap that opens at no rate has closed."""
    rates = begun.rates()
    half = len(rates) // 2
    names = begun.system.state_names[:half]
    accelerations = dict(zip(names, rates[half:], strict=True))
    if "y1" in names:
        return sqrt(2 * gap / -gap_acceleration_of_belt(begun, accelerations))
    slider = accelerations["z" if "z" in names else "u"]
    return sqrt(2 * gap / (disc_acceleration(begun, accelerations) - slider))


def gap_acceleration_of_belt(begun: Motion, second: dict[str, float]) -> float:
    """Second derivative of y1 - y2 + (x1 - x2) phi."""
    state = dict(zip(begun.system.state_names, begun.y, strict=True))
    along, along_dot = state["x1"] - state["x2"], state["x1_dot"] - state["x2_dot"]
    turning = (second["x1"] - second["x2"]) * state["phi"]
    turning += 2 * along_dot * state["phi_dot"] + along * second["phi"]
    return second["y1"] - second["y2"] + turning


def disc_acceleration(begun: Motion, second: dict[str, float]) -> float:
    """Second derivative of w where the slider is, by differences along the motion's parabola."""
    half = len(begun.y) // 2
    place, speed = begun.y[:half], begun.y[half:]
    bend = np.array([second[name] for name in begun.system.state_names[:half]])
    step = 1e-5
    values = [displacement(begun, place + h * speed + h * h / 2 * bend) for h in (-step, 0, step)]
    return float((values[0] - 2 * values[1] + values[2]) / step**2)


def displacement(begun: Motion, coordinates: Any) -> float:
    """w under the slider, as the rigid contact takes it up."""
    names = begun.system.state_names[: len(coordinates)]
    start = dict(zip(names, coordinates, strict=True))
    start.pop("u", None)
    return float(motion("disc-rigid-contact", "coulomb", {**start, "z": -1.0}).y[1])


# --- which way it goes on ------------------------------------------------------------------------
CONTACTS = ["rigid", "compliant", "elastic"]


@pytest.mark.parametrize("contact", CONTACTS)
@pytest.mark.parametrize("ulps", [-3, -1, 0, 1, 3])
@pytest.mark.parametrize("level", [0.0, 0.5])
def test_what_is_lifted_separates_at_once(contact: str, ulps: int, level: float) -> None:
    """Pulled up by 5 N more than its weight: one motion in the air, no event."""
    begun = bouncer(contact, level, ulps, {}, A=15.0)
    begun.run(0.1)
    assert begun.codes == [CODE_SEPARATION]
    assert transitions(begun) == []
    free = 15.0 / 9 * (1 - np.cos(0.3)) - 10.0 * 0.01 / 2
    assert begun.y[1] - begun.y[2] == pytest.approx(free, abs=1e-13)


@pytest.mark.parametrize("contact", CONTACTS)
@pytest.mark.parametrize("ulps", [-3, -1, 0, 1, 3])
@pytest.mark.parametrize(("rate", "opens"), [(1e-9, True), (2.0, True), (-2.0, False)])
def test_the_gap_rate_decides(contact: str, ulps: int, rate: float, opens: bool) -> None:
    begun = bouncer(contact, 0.5, ulps, {"z_dot": rate})
    assert (begun.codes == [CODE_SEPARATION]) is opens
    begun.run(1e-9)
    if opens and rate > 1.0:
        begun.run(0.39)
        assert transitions(begun) == []
        assert begun.y[1] - begun.y[2] == pytest.approx(2.0 * 0.39 - 5.0 * 0.39**2, abs=1e-13)
    elif not opens:
        assert transitions(begun) == []


def bouncer(
    contact: str, level: float, ulps: int, start: dict[str, float], **changes: float
) -> Motion:
    """A mass over a resting floor at `level`, apart by so many units in the last place of it."""
    state = {"floor": level, "z": level + ulps * level * ULP, **start}
    return motion(RAISED_BOUNCER, start=state, options={"contact": contact}, **changes)
