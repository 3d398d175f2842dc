"""Motions: exact events, measured orders, invariances, and what happens on borders."""

from __future__ import annotations

from dataclasses import replace
from math import asin, atan, cos, pi, sin, sqrt
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from motions import TIGHT, booked, defaults, ledger, motion, system, times, transitions
from numpy.typing import NDArray

from fiv_cli.analyses.base import SolverSettings
from fiv_cli.codegen.codes import CODE_STICK
from fiv_cli.dynamics import motion as dynamics_motion
from fiv_cli.dynamics.motion import Motion, Stop, next_stride, samples_at
from fiv_cli.dynamics.settings import Section
from fiv_cli.errors import UsageError

EVENTS = 50  # events for which two computations must agree one by one
FORCED = {"u0": 0.5, "omega": 1.2}
SECTOR = {"beta": 2.0, "psi_a": 0.3}
MOTIONS = {
    "belt": ("belt-1dof", "coulomb", {"x": 0.0}, {}, 150.0, 2e-3),
    "forced belt": ("belt-1dof", "coulomb", {"x": 0.0}, FORCED, 150.0, 2e-3),
    "damped Stribeck belt": ("belt-1dof", "stribeck", {"x": 0.0}, {"c": 0.1}, 200.0, 2e-3),
    "hyperbolic belt": (
        "belt-1dof", "hyperbolic", {"x": 0.0}, {"N": 2.5, "v": 0.2}, 300.0, 2e-3,
    ),
    "reversing mass": (
        "belt-1dof", "coulomb", {"x": 0.0},
        {"v": 0.0, "N": 1.0, "u0": 2.0, "omega": 0.7}, 200.0, 2e-3,
    ),
    "pin": ("pin-on-disc", "coulomb", {"phi_dot": 2.0}, {}, 2.0, 2e-5),
    "pin on a sector": ("pin-on-disc", "coulomb", {"phi_dot": 2.0}, SECTOR, 2.0, 2e-5),
}  # fmt: skip


def set_out(name: str, solver: SolverSettings = TIGHT, share: float = 1.0) -> tuple[Motion, float]:
    """One of `MOTIONS` at its start, and a share of the time that it is given."""
    model, law, start, changes, t_end, _ = MOTIONS[name]
    return motion(model, law, start, solver, **changes), share * t_end


def moved(name: str, solver: SolverSettings = TIGHT) -> Motion:
    """One of `MOTIONS` up to its time or number of events."""
    begun, t_end = set_out(name, replace(solver, max_events=EVENTS))
    begun.run(t_end)
    return begun


# --- exact events ------------------------------------------------------------------------------
def belt_events(count: int) -> NDArray[np.float64]:
    """Event times of the Coulomb belt from rest, s (closed form)."""
    first = asin(1 / 2.3)
    release = first + 1.7 + sqrt(2.3**2 - 1)
    slip, stick = pi + 2 * atan(1 / 1.7), 3.4
    releases = release + np.arange(count) * (slip + stick)
    return np.concatenate([[first], np.stack([releases, releases + slip], axis=1).ravel()])[:count]


def test_event_times_are_exact() -> None:
    begun = moved("belt")
    expected = belt_events(begun.n_events)
    assert begun.n_events > 30
    np.testing.assert_allclose(times(begun), expected, rtol=0.0, atol=1e-11)
    assert np.max(ledger(begun)[:, 4]) < 1e-14


@pytest.mark.parametrize("name", MOTIONS)
def test_two_integrators_agree_event_by_event(name: str) -> None:
    step = MOTIONS[name][5]
    exact, rough = moved(name), moved(name, SolverSettings("rk4", TIGHT.rtol, step))
    assert exact.n_events >= 10
    assert transitions(exact) == transitions(rough)
    np.testing.assert_allclose(times(exact), times(rough), rtol=1e-7)
    np.testing.assert_allclose(exact.y, rough.y, rtol=1e-5, atol=1e-7)


def test_sticking_holds_exactly() -> None:
    for name, velocity in (("belt", 1.0), ("forced belt", 1.0), ("pin", 2.0)):
        begun, t_end = set_out(name)
        taken = samples_at(begun.system, np.linspace(0.0, t_end, 3001))
        begun.run(t_end, samples=taken)
        column = begun.system.state_names.index(f"{begun.system.coordinates[0]}_dot")
        sticking = taken.codes[:, 0] == CODE_STICK
        assert sticking.sum() > 500
        assert np.all(taken.states[sticking, column] == velocity)
        assert not np.any(taken.states[~sticking, column] == velocity)


# --- measured orders -----------------------------------------------------------------------------
def order_of(steps: NDArray[np.float64], errors: NDArray[np.float64]) -> float:
    """Slope of log(error) over log(step)."""
    return float(np.polyfit(np.log(steps), np.log(errors), 1)[0])


@pytest.mark.parametrize("name", ["forced belt", "damped Stribeck belt", "pin"])
def test_order_of_rk4_survives_events(name: str) -> None:
    model, law, start, changes, t_end, _ = MOTIONS[name]
    t_end, largest = (t_end / 5, 0.16) if model == "belt-1dof" else (0.2, 1.6e-3)
    exact = motion(model, law, start, **changes)
    exact.run(t_end)
    steps = largest / 2.0 ** np.arange(5)
    errors = []
    for step in steps:
        rough = motion(model, law, start, SolverSettings("rk4", TIGHT.rtol, step), **changes)
        rough.run(t_end)
        assert transitions(rough) == transitions(exact)
        errors.append(np.max(np.abs(rough.y - exact.y)))
    assert exact.n_events >= 5
    assert order_of(steps, np.array(errors)) == pytest.approx(4.0, abs=0.5)


@pytest.mark.parametrize("name", ["forced belt", "hyperbolic belt", "pin"])
def test_order_of_taylor_survives_events(name: str) -> None:
    """With the order of the series held, the error falls as the power of the step it gives."""
    model, law, start, changes, t_end, _ = MOTIONS[name]
    t_end = t_end / 5 if model == "belt-1dof" else 0.2
    parameters = defaults(model, law, **changes)
    built = system(model, law, rtol=1e-4, parameters=parameters)
    exact = motion(model, law, start, **changes)
    exact.run(t_end)
    tolerances = 10.0 ** -np.arange(3, 10)
    errors = []
    for rtol in tolerances:
        rough = Motion(built, parameters, SolverSettings(rtol=rtol), start)
        rough.run(t_end)
        errors.append(np.max(np.abs(rough.y - exact.y)))
    order = built.generated.order
    steps = tolerances ** (1.0 / order)
    assert order_of(steps, np.array(errors)) == pytest.approx(order, rel=0.25)


# --- energy --------------------------------------------------------------------------------------
@pytest.mark.parametrize("rtol", [1e-7, 1e-10, 1e-13])
@pytest.mark.parametrize("name", MOTIONS)
def test_energy_is_accounted_for(name: str, rtol: float) -> None:
    begun, t_end = set_out(name, SolverSettings(rtol=rtol))
    before = begun.energy()
    found = booked(begun, t_end)
    assert found.residual < 10 * rtol
    assert abs(found.friction) > 0.01 * before
    assert (found.drive == 0.0) == (name == "reversing mass")


@pytest.mark.parametrize("rtol", [1e-6, 1e-9, 1e-12])
def test_a_step_does_not_jump_over_the_layer_of_a_regularised_law(rtol: float) -> None:
    """Far from zero slip tanh is constant to rounding: its series knows nothing of the layer."""
    begun = motion("belt-1dof", "tanh of stribeck", {}, SolverSettings(rtol=rtol), c=0.3)
    assert booked(begun, 100.0).residual < rtol
    assert begun.extremes[1, 0] == pytest.approx(4.40845490399, rel=10 * rtol)


def test_a_step_does_not_jump_over_the_layer_of_an_exponential_law() -> None:
    """At 30 times the Stribeck velocity exp(-v) is rounding, and grows to one within a step."""
    changes = {
        "m": 0.307, "k": 6.567, "c": 0.0633, "N": 1.448, "v": -0.2368, "u0": 4.835, "omega": 2.79,
        "mu_k": 0.109, "mu_s": 0.381,
    }  # fmt: skip
    start = {"x": -1.063, "x_dot": 1.544}
    begun = motion("belt-1dof", "stribeck", start, SolverSettings(rtol=1e-12), **changes)
    assert booked(begun, 60.0).residual < 1e-10
    assert begun.extremes[1, 1] > 25.0


# --- invariances ---------------------------------------------------------------------------------
UNITS = {  # exponents of (mass, length, time) in each parameter of the belt
    "m": (1, 0, 0), "k": (1, 0, -2), "c": (1, 0, -1), "N": (1, 1, -2), "v": (0, 1, -1),
    "u0": (0, 1, 0), "omega": (0, 0, -1), "mu_k": (0, 0, 0), "mu_s": (0, 0, 0),
}  # fmt: skip


@settings(max_examples=20)
@given(mass=st.integers(-30, 30), length=st.integers(-30, 14))  # 1e6 m has diverged
def test_units_of_mass_and_length_change_no_digit(mass: int, length: int) -> None:
    _check_units((2.0**mass, 2.0**length, 1.0), exactly=True)


@settings(max_examples=20)
@given(time=st.integers(-10, 10))
def test_the_unit_of_time_changes_rounding_only(time: int) -> None:
    _check_units((1.0, 1.0, 2.0**time), exactly=False)


def _check_units(units: tuple[float, float, float], exactly: bool) -> None:
    parameters = defaults("belt-1dof", "coulomb", c=0.02, **FORCED)
    scaled = {
        name: value * float(np.prod(np.array(units) ** np.array(UNITS[name])))
        for name, value in parameters.items()
    }
    built = system("belt-1dof", "coulomb")
    plain = Motion(built, parameters, TIGHT, {"x": 0.3})
    other = Motion(built, scaled, TIGHT, {"x": 0.3 * units[1]})
    plain.run(80.0)
    other.run(80.0 * units[2])
    expected = plain.y * np.array([units[1], units[1] / units[2]])
    assert plain.n_events == other.n_events > 10
    np.testing.assert_allclose(other.y, expected, rtol=0.0 if exactly else 1e-11)


@pytest.mark.parametrize("law", ["coulomb", "stribeck", "linear-slope", "hyperbolic"])
def test_the_mirrored_motion_is_the_mirror_image(law: str) -> None:
    """Right and left are alike, bit for bit: the sign of slip is nowhere computed from a speed."""
    one = motion("belt-1dof", law, {"x": 0.3, "x_dot": 1.4}, c=0.05)
    other = motion("belt-1dof", law, {"x": -0.3, "x_dot": -1.4}, c=0.05, v=-1.0)
    one.run(100.0)
    other.run(100.0)
    assert one.n_events == other.n_events > 10
    assert np.array_equal(times(one), times(other))
    assert np.array_equal(one.y, -other.y)


@pytest.mark.parametrize("name", ["forced belt", "pin on a sector"])
def test_motions_side_by_side_do_not_disturb_each_other(name: str) -> None:
    (alone, t_end), (one, _) = set_out(name), set_out(name)
    alone.run(t_end)
    model, law, _, changes, *_ = MOTIONS[name]
    section = Section("event")
    while one.run(t_end, section, (np.zeros(1), np.zeros((1, len(one.y))))) != Stop.REACHED:
        motion(model, law, {one.system.coordinates[0]: 0.01}, **changes).run(t_end / 50)
    assert np.array_equal(one.y, alone.y)


@pytest.mark.parametrize("name", ["forced belt", "hyperbolic belt", "pin on a sector"])
def test_a_motion_in_pieces_is_the_motion(name: str) -> None:
    (whole, t_end), (pieces, _) = set_out(name, share=0.2), set_out(name)
    whole.run(t_end)
    for stop in np.sort(np.random.default_rng(3).uniform(0.0, t_end, 40)):
        assert pieces.run(float(stop)) == Stop.REACHED
        assert pieces.time == stop
    pieces.run(t_end)
    assert transitions(pieces) == transitions(whole)
    np.testing.assert_allclose(times(pieces), times(whole), rtol=1e-10)
    np.testing.assert_allclose(pieces.y, whole.y, rtol=1e-9, atol=1e-11)


@pytest.mark.parametrize("name", ["forced belt", "pin on a sector"])
def test_watching_changes_nothing(name: str) -> None:
    """Samples, measures and a full ledger leave the motion as it is, bit for bit."""
    (alone, t_end), (watched, _) = set_out(name), set_out(name)
    alone.run(t_end)
    watched.keep_ledger(3)
    watched.start_measuring(np.ones(len(watched.system.coordinates)))
    taken = samples_at(watched.system, np.linspace(0, t_end, 777))
    watched.run(t_end, samples=taken, measuring=True)
    assert watched.y.tobytes() == alone.y.tobytes()
    assert (watched.n_events, watched.n_steps) == (alone.n_events, alone.n_steps)


@pytest.mark.parametrize("name", ["forced belt", "reversing mass", "pin", "pin on a sector"])
def test_tangents_change_nothing_and_follow_neighbours(name: str) -> None:
    """A tangent vector is the derivative of the motion by its start, through every event."""
    (alone, t_end), (carried, _) = set_out(name, share=0.1), set_out(name)
    alone.run(t_end)
    carried.carry_tangents(np.eye(len(carried.y)))
    carried.run(t_end)
    np.testing.assert_allclose(carried.y, alone.y, rtol=1e-12)
    assert alone.n_events >= 3
    model, law, start, changes, *_ = MOTIONS[name]
    first, shift, neighbours = carried.system.coordinates[0], 1e-6, []
    for sign in (1.0, -1.0):
        beside = start | {first: start.get(first, 0.0) + sign * shift}
        near = motion(model, law, beside, **changes)
        near.run(t_end)
        neighbours.append(near.y)
    difference = (neighbours[0] - neighbours[1]) / (2 * shift)
    scale = np.max(np.abs(carried.tangents[0]))
    np.testing.assert_allclose(carried.tangents[0], difference, atol=1e-5 * max(scale, 1.0))


def saltation(start: dict[str, float], instant: float) -> NDArray[np.float64]:
    """What an event of the Coulomb belt makes of unit tangents (columns) of slip or stick."""
    begun = motion("belt-1dof", start=start)
    begun.run(instant - 1e-7)
    begun.carry_tangents(np.eye(2))
    begun.run(instant + 1e-7)
    assert begun.n_events == 1
    return begun.tangents.T


def test_saltation_at_events() -> None:
    """Landing on the belt loses the velocity; release turns a displacement into a velocity."""
    landing = saltation({}, asin(1 / 2.3))
    np.testing.assert_allclose(landing, [[1.0, 0.0], [0.0, 0.0]], atol=1e-6)
    release = saltation({"x": 3.0, "x_dot": 1.0}, 1.0)
    np.testing.assert_allclose(release[:, 0], [1.0, -1.7], atol=1e-6)


@settings(max_examples=10)
@given(phase=st.floats(-6.0, 6.0), turns=st.integers(-2, 2))
def test_the_sector_turns_with_its_phase(phase: float, turns: int) -> None:
    """Whole turns of psi_a change nothing; delaying the disc turns the sector."""
    first, whole, later = (
        motion("pin-on-disc", start={"phi": 0.01, "phi_dot": 1.0}, beta=1.0, psi_a=psi_a, time=time)
        for psi_a, time in ((phase, 0.0), (phase + 2 * pi * turns, 0.0), (phase + 2.0 * 0.5, 0.5))
    )
    first.run(1.0)
    whole.run(1.0)
    later.run(1.5)
    assert transitions(first) == transitions(whole) == transitions(later)
    np.testing.assert_allclose(whole.y, first.y, rtol=1e-9)
    np.testing.assert_allclose(later.y, first.y, rtol=1e-9)


# --- on borders ----------------------------------------------------------------------------------
@pytest.mark.parametrize(
    ("x", "first"),
    [
        (3.0, "stick->slip+"),
        (4.0, "slip+->stick"),
        (5.0, "slip+->stick"),
        (-5.0, "slip-->stick"),
        (-4.0, "stick->slip+"),
    ],
)
def test_at_rest_on_the_belt_the_demanded_force_decides(x: float, first: str) -> None:
    """It sticks below the capacity (4 N) and slips the way of the demand above it."""
    begun = motion("belt-1dof", start={"x": x, "x_dot": 1.0})
    begun.run(10.0)
    assert transitions(begun)[0] == first
    if first == "stick->slip+":
        assert times(begun)[0] == pytest.approx(4.0 - x, abs=1e-12)


@pytest.mark.parametrize("method", ["taylor", "rk4"])
def test_release_without_a_jump_of_force(method: str) -> None:
    """With mu_s = mu_k the acceleration starts at zero; its derivative decides."""
    begun = motion("belt-1dof", start={"x": 1.0, "x_dot": 1.0}, mu_s=0.23,
                   solver=SolverSettings(method, 1e-13, 1e-3))  # fmt: skip
    begun.run(6.0)
    assert transitions(begun) == ["stick->slip+"]
    assert times(begun)[0] == pytest.approx(1.3, abs=1e-12)
    tau = 6.0 - 1.3
    np.testing.assert_allclose(begun.y, [2.3 + sin(tau), cos(tau)], atol=1e-9)


@pytest.mark.parametrize(
    ("excess", "sticks"), [(-1e-3, True), (0.0, True), (1e-9, False), (1e-3, False)]
)
def test_a_demand_that_grazes_the_capacity(excess: float, sticks: bool) -> None:
    """A resting mass, pulled harmonically up to just its capacity."""
    begun = motion(
        "belt-1dof", start={}, v=0.0, N=1.0, mu_s=0.4, mu_k=0.23, u0=0.4 * (1 + excess), omega=0.7
    )
    begun.run(60.0)
    assert (begun.n_events == 0) is sticks
    if sticks:
        assert list(begun.y) == [0.0, 0.0]


def test_reversal_above_the_capacity() -> None:
    """Driven hard over a resting ground, slip reverses without a stop."""
    begun = motion("belt-1dof", start={"x": 1.5}, v=0.0, N=1.0, mu_s=0.23, u0=1.0, omega=0.6)
    begun.run(200.0)
    assert set(transitions(begun)) == {"slip+->slip-", "slip-->slip+"}
    assert begun.n_events > 30


def test_a_mass_at_rest_stays_for_ever() -> None:
    begun = motion("belt-1dof", start={"x": 0.3}, v=0.0, N=1.0)
    assert begun.run(1e6) == Stop.REACHED
    assert (begun.n_events, begun.n_steps) == (0, 1)
    assert list(begun.y) == [0.3, 0.0]


@pytest.mark.parametrize("law", ["coulomb", "stribeck"])
def test_what_stands_still_is_stepped_over_however_short_the_last_slip(law: str) -> None:
    run = motion("belt-1dof", law, {"x": 0.1, "x_dot": 1e-7}, v=0.0)
    assert run.run(1000.0) == Stop.REACHED
    assert (run.n_events, run.y[1]) == (1, 0.0)
    assert run.n_steps < 20


@pytest.mark.parametrize("psi_a", [0.0, -1.0])
@pytest.mark.parametrize("speed", [0.0, 2.0, 5.0])
def test_a_pin_on_the_border_of_its_sector(psi_a: float, speed: float) -> None:
    """Starting on a border is starting an instant beside it, on the side it moves to."""
    start = {"phi_dot": speed}
    on = motion("pin-on-disc", start=start, beta=1.0, psi_a=psi_a)
    beside = motion(
        "pin-on-disc", start=start, beta=1.0, psi_a=psi_a + (1e-9 if speed > 2 else -1e-9)
    )
    assert on.run(0.3) == Stop.REACHED
    beside.run(0.3)
    borders = [w for w in transitions(on) if w in ("slip+->slip+", "slip-->slip-")]
    assert len(borders) <= 2
    np.testing.assert_allclose(on.y, beside.y, rtol=1e-5, atol=1e-6)


# --- sections ------------------------------------------------------------------------------------
def section_points(begun: Motion, section: Section, count: int, interval: float = 0.0) -> Any:
    """The first section points of a motion: times and states."""
    points = np.zeros(count), np.zeros((count, len(begun.y)))
    assert begun.run(1e4, section, points, phase_interval=interval) == Stop.SECTION_FULL
    return points


@pytest.mark.parametrize(("event", "x"), [("slip->stick", 0.6), ("stick->slip", 4.0)])
def test_sections_on_events(event: str, x: float) -> None:
    found, states = section_points(motion("belt-1dof"), Section("event", event), 6)
    np.testing.assert_allclose(states[2:], [[x, 1.0]] * 4, atol=1e-12)
    np.testing.assert_allclose(np.diff(found[2:]), 7.605040788107404, atol=1e-11)


@pytest.mark.parametrize(("direction", "count"), [("up", 1), ("down", 1), ("both", 2)])
def test_sections_on_a_velocity(direction: str, count: int) -> None:
    section = Section("zero", state="x_dot", direction=direction)
    found, states = section_points(motion("belt-1dof"), section, 4 * count)
    assert np.all(np.abs(states[:, 1]) < 1e-12)
    period = found[3 * count] - found[2 * count]
    assert period == pytest.approx(7.605040788107404, abs=1e-9)


@pytest.mark.parametrize(("direction", "count"), [("up", 1), ("down", 1), ("both", 2)])
def test_a_velocity_section_on_an_event(direction: str, count: int) -> None:
    """On resting ground every reversal is an event and a zero of the velocity at once."""
    begun = motion(
        "belt-1dof", start={"x": 1.0}, v=0.0, N=1.0, mu_k=0.5, mu_s=0.5, u0=1.0, omega=0.6
    )
    begun.run(500.0)
    found, _ = section_points(begun, Section("zero", state="x_dot", direction=direction), 4 * count)
    assert found[3 * count] - found[2 * count] == pytest.approx(2 * pi / 0.6, abs=1e-9)


def test_stroboscopic_sections() -> None:
    begun = motion("belt-1dof", **FORCED)
    interval = 2 * pi / 1.2
    found, _ = section_points(begun, Section("phase"), 10, interval)
    np.testing.assert_allclose(found, interval * np.arange(1, 11), rtol=1e-14)
    shifted, _ = section_points(begun, Section("phase", phase=pi), 3, interval)
    np.testing.assert_allclose(shifted, interval * (10.5 + np.arange(3)), rtol=1e-14)
    with pytest.raises(UsageError, match="phase_interval"):
        begun.run(1e3, Section("phase"))


def test_a_stroboscopic_instant_on_an_event() -> None:
    """The mass is released after exactly 1 s, where the section lies."""
    begun = motion("belt-1dof", start={"x": 3.0, "x_dot": 1.0})
    found, states = section_points(begun, Section("phase"), 3, 1.0)
    np.testing.assert_allclose(found, [1.0, 2.0, 3.0], rtol=1e-12)
    np.testing.assert_allclose(states[0], [4.0, 1.0], rtol=1e-12)


# --- budgets -------------------------------------------------------------------------------------
@pytest.mark.parametrize(
    ("budget", "stop"),
    [({"max_events": 7}, Stop.EVENT_BUDGET), ({"max_steps": 7}, Stop.STEP_BUDGET)],
)
def test_budgets(budget: Any, stop: Stop) -> None:
    begun = motion("belt-1dof", solver=SolverSettings(rtol=1e-13, **budget))
    assert begun.run(1e5) == stop
    assert 7 in (begun.n_events, begun.n_steps)


@pytest.mark.parametrize("steps", [1, 13])
@pytest.mark.parametrize("name", MOTIONS)
def test_a_motion_in_pieces_has_the_bits_of_one_in_one(
    name: str, steps: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The driver comes back to Python every so often, to be ended there."""

    def bits(stride: int) -> tuple[list[bytes], int]:
        begun, t_end = set_out(name, share=0.25)
        size = len(begun.system.state_names)
        begun.start_measuring(np.zeros(len(begun.system.coordinates)))
        begun.carry_tangents(np.eye(size))
        begun.stride = begun.frame.max_steps = stride
        taken = samples_at(begun.system, np.linspace(0.0, t_end, 101))
        sections = np.zeros(40), np.zeros((40, size))
        section = Section("event", "slip->stick", contact=1)
        stop = begun.run(t_end, section, sections, taken, True)
        changing = (field for field in begun.frame.fields.values() if not field.kind.is_fixed)
        scalars = [getattr(begun.frame, field.name) for field in changing if not field.kind.depth]
        arrays = [begun.y, begun.kinds, *begun.ledger, begun.tangents, np.array(scalars, float),
                  begun.extremes, begun.measures.squares, begun.measures.shares,
                  *sections, taken.states, taken.outputs, taken.codes]  # fmt: skip
        return [array.tobytes() for array in arrays], stop

    monkeypatch.setattr(dynamics_motion, "next_stride", lambda stride, seconds: stride)
    assert bits(steps) == bits(10**9)


def test_a_call_of_the_driver_takes_a_tenth_of_a_second() -> None:
    assert next_stride(4000, 0.2) == 2000
    assert next_stride(4000, 0.08) == 5000
    assert next_stride(4000, 1e-6) == 8000  # never much more at once
    assert next_stride(1, 10.0) == 1


def test_divergence_is_noticed() -> None:
    begun = motion("belt-1dof", "linear-slope", start={"x": 20.0}, v=1e9, alpha_0=-0.9)
    assert begun.run(1e5) == Stop.DIVERGED


def test_loss_of_contact_ends_a_motion() -> None:
    flying = motion("pin-on-disc", start={"theta_dot": 150.0})
    assert flying.run(1.0) == Stop.CONTACT_LOST
    pressed = defaults("pin-on-disc", "coulomb")["N0"] - 1000.0 * (
        0.1 * flying.y[1] + 0.1**2 / 0.2 * flying.y[0] ** 2
    )
    assert pressed == pytest.approx(0.0, abs=1e-10)


def test_a_start_without_contact_ends_at_once() -> None:
    begun = motion("pin-on-disc", start={"theta": 0.4})
    assert begun.run(1.0) == Stop.CONTACT_LOST
    assert begun.time == 0.0
