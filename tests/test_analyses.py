"""Analyses: classes of steady states, equilibria, eigenvalues, histories, and what is handed on."""

from __future__ import annotations

from dataclasses import replace
from inspect import signature
from itertools import product
from math import atan, cos, pi, sin, sqrt
from typing import Any

import numpy as np
import pytest
from motions import TIGHT, defaults, motion, system
from small_models import DOUBLE_WELL, TWO_MASSES

from fiv_cli.analyses import all_analyses, execute, get_analysis
from fiv_cli.analyses.base import (
    Batch,
    Later,
    Outcome,
    Request,
    Section,
    SolverSettings,
    Start,
    Varied,
)
from fiv_cli.analyses.common import rest_of, sliding
from fiv_cli.analyses.motion.recording import sample_times
from fiv_cli.analyses.rest.linearisation import spectrum
from fiv_cli.analyses.rest.modes import coupled_modes
from fiv_cli.api import analyse
from fiv_cli.codegen.codes import CODE_SLIP_PLUS, CODE_STICK
from fiv_cli.codegen.generate import FLOW, JACOBIAN, TANGENT
from fiv_cli.codegen.setup import Setup
from fiv_cli.dynamics import recorder
from fiv_cli.dynamics import system as systems
from fiv_cli.flags import ATTRACTOR

FORCED = {"u0": 0.5, "omega": 1.2}
RELEASE = Section("event", "stick->slip")
UPWARD = Section("zero", state="x_dot", direction="up")


def respond(
    law: str = "coulomb",
    start: Any = None,
    model: str = "belt-1dof",
    solver: SolverSettings | None = None,
    section: Section | None = None,
    t_max: float = 1000.0,
    **changes: float,
) -> Outcome:
    """The steady state of a motion from a state (at rest at zero when left out)."""
    settings = {"section": section or Section("event"), "t_max": t_max}
    return analyse(model, law, "response", start or {}, settings, solver, **changes)


# --- classes -------------------------------------------------------------------------------------
@pytest.mark.parametrize("damping", [0.11, 0.2, 1.0, 2.0])
def test_a_stable_equilibrium_is_reached(damping: float) -> None:
    found = respond("linear-slope", Start("a", "equilibrium", {"x": 1e-3}), c=damping)
    assert found.status == "ok"
    assert found.values["attractor"] == "equilibrium"
    assert found.values["L_s"] == 0.0
    assert found.values["slip_fraction"] == 1.0
    assert found.values["x_max"] == found.values["x_min"] == pytest.approx(9.9)


@pytest.mark.parametrize("damping", [0.0, 0.05, 0.09])
def test_an_unstable_equilibrium_is_left(damping: float) -> None:
    start = Start("a", "equilibrium", {"x": 1e-3})
    found = respond("linear-slope", start, t_max=10_000.0, c=damping)
    assert found.values["attractor"] == "periodic"
    assert found.values["stick_fraction"] > 0.0
    assert found.values["L_s"] > 0.1


def test_an_undamped_slide_is_neutral() -> None:
    found = respond(start={"x": 2.0})
    assert (found.status, found.reason) == ("ok", "neutral_oscillation")
    assert found.values["attractor"] == "undecided"
    assert found.values["L_s"] == pytest.approx(0.3**2 / 2, rel=1e-8)


def test_a_slide_that_nonlinear_friction_alone_damps_is_not_neutral() -> None:
    """Where friction is least, slow oscillations fall as A' = -3 A^3 / 10 (averaging)."""
    law = {"mu_s": 0.4, "mu_m": 0.2, "v_m": 0.5, "v": 0.5}
    times, amplitudes = [], []
    for t_max in (1000.0, 3000.0):
        found = respond("cubic", {"x": 0.5}, section=UPWARD, t_max=t_max, N=1.0, c=0.0, **law)
        assert (found.values["attractor"], found.reason) == ("undecided", "nonhyperbolic")
        times.append(found.values["transient_used"])
        amplitudes.append(0.5 * (found.values["x_max"] - found.values["x_min"]))
    grown = np.diff(np.array(amplitudes) ** -2.0)
    assert grown == pytest.approx(0.6 * np.diff(times), rel=0.01)


@pytest.mark.parametrize("section", [Section("event"), UPWARD])
def test_a_nonlinear_oscillation_that_keeps_its_energy_has_no_attractor(section: Section) -> None:
    """About the only equilibrium, and in a well beside one that repels: no cycle attracts."""
    for changes, start, reasons in (
        ({"k": -1.0}, 0.8, {"neutral_oscillation"}),
        ({"k": 1.0}, 1.3, {"cycle_not_confirmed", "slide_not_decided"}),
    ):
        found = respond("coulomb", {"x": start}, DOUBLE_WELL, section=section, c=0.0, **changes)
        assert found.values["attractor"] == "undecided"
        assert found.reason in reasons


@pytest.mark.parametrize(
    ("friction", "lands_again", "least"),
    [(0.2, True, 0.98), (0.35, False, 0.995), (0.36, True, 0.995)],
)
def test_an_undamped_slide_is_neutral_if_it_never_lands_again(
    friction: float, lands_again: bool, least: float
) -> None:
    """Landings come ever more seldom, at 0.2 after 19,000 s: two frequencies come together.

    What is measured over a beat falls short of what is reached in ever so long by as much as few
    cycles of it miss where both are at their greatest: at 0.2 the beat is the shortest.
    """
    parameters = {"k1": 1.0, "k2": 1.0, "k3": 4.0 / 3.0, "alpha1": np.pi / 4.0, "alpha2": 0.0}
    parameters |= {"v": 0.5, "mu_k": friction, "c1": 0.0, "c2": 0.0}
    asked = {
        "response": {"section": Section("zero", state="x_dot", direction="up"), "t_max": 3000.0},
        "history": {"t_end": 30_000.0, "sample": 0.5},
    }
    for offset, goes_on in (({"x": 2.0, "y": -0.5}, lands_again), ({"x": 1e-3}, False)):
        start = Start("a", "equilibrium", offset)
        found, motion = (
            analyse("flutter-2dof", "coulomb", kind, start, settings, options={"states": "all"},
                    **parameters)
            for kind, settings in asked.items()
        )  # fmt: skip
        last = motion.ragged["event_time"].max(initial=0.0)
        assert (last > found.values["transient_used"]) == goes_on
        assert found.values["attractor"] == "undecided"
        assert (found.reason != "neutral_oscillation") == goes_on
        if not goes_on:
            after = motion.values["x"][np.arange(len(motion.values["x"])) * 0.5 > last]
            extent = found.values["x_max"] - found.values["x_min"]  # over a beat
            assert least * np.ptp(after) < extent < 1.001 * np.ptp(after)
            assert found.values["separation_fraction"] == 0.0 and found.values["y_max"] < 0.0


def test_a_quasiperiodic_response() -> None:
    found = respond(t_max=20_000.0, u0=0.5, omega=0.5)
    assert found.values["attractor"] == "quasiperiodic"
    assert abs(found.values["lyapunov"]) < 6e-4
    assert found.values["L_s_window"] == pytest.approx(10_000.0)
    assert len(found.ragged["section_value"]) > 100


def test_a_slow_way_into_a_cycle_is_no_torus() -> None:
    """It comes in by 0.83 in a period, 28 section points, and its exponent is nearly zero."""
    before, after = (respond(t_max=t_max, u0=0.5, omega=1.31) for t_max in (1e4, 1e5))
    assert (before.values["attractor"], before.reason) == ("undecided", "section_drifts")
    assert after.values["attractor"] == "periodic"
    assert after.values["floquet_multiplier"][0] == pytest.approx(0.82726, abs=1e-5)


CHAOS = {"u0": 2.0, "omega": 2.1}


def separation_rate(blocks: int, span: float = 4.0, distance: float = 1e-8) -> float:
    """Largest exponent of the chaotic belt by two neighbours, drawn together after each block."""
    one = motion("belt-1dof", start={"x": 0.2}, **CHAOS)
    one.run(100 * span)
    direction, growth = np.array([1.0, 0.0]), 0.0
    for _ in range(blocks):
        state = one.y + distance * direction
        start = dict(zip(("x", "x_dot"), state, strict=True))
        other = motion("belt-1dof", start=start, time=one.time, **CHAOS)
        goal = one.time + span
        one.run(goal)
        other.run(goal)
        apart = other.y - one.y
        size = float(np.linalg.norm(apart))
        growth += np.log(size / distance)
        direction = apart / size
    return growth / (blocks * span)


def test_a_chaotic_response() -> None:
    """The exponent through saltation is that of two neighbours that are really followed."""
    found = respond(t_max=20_000.0, **CHAOS)
    assert found.values["attractor"] == "chaotic"
    assert found.values["lyapunov"] == pytest.approx(separation_rate(1000), rel=0.15)
    assert found.values["lyapunov"] > 0.03


def test_a_class_does_not_depend_on_what_is_observed() -> None:
    """Not on the velocity either, which is that of the disc wherever the pin comes to stick."""
    start, fixed = {"phi_dot": 0.5}, {"Omega": 0.5}
    settings = ({"observe": name, "t_max": 600.0} for name in ("phi", "phi_dot", "theta_dot"))
    found = [
        analyse("pin-on-disc", "coulomb", "response", start, one, None, **fixed).values
        for one in settings
    ]
    assert {one["attractor"] for one in found} == {"chaotic"}
    assert len({one["lyapunov"] for one in found}) == 1


def test_more_time_undoes_no_chaos_but_tells_more_of_it() -> None:
    """However long the window, its tangent stays a number; its rate is told within its error."""
    found = [
        respond(model="pin-on-disc", start={"phi_dot": 0.5}, Omega=0.5, t_max=t_max).values
        for t_max in (600.0, 15_000.0)
    ]
    assert [one["attractor"] for one in found] == ["chaotic", "chaotic"]
    for name in ("lyapunov", "L_s"):
        errors = [one[f"{name}_standard_error"] for one in found]
        assert 0.0 < errors[1] < 0.5 * errors[0]  # as the root of the time, one fifth
        apart = abs(found[0][name] - found[1][name])
        assert apart < 4.0 * np.hypot(*errors)


def test_the_intensity_of_chaos_scatters_as_its_standard_error_says() -> None:
    """Over windows that follow sixteen starts upon one attractor."""
    speeds = np.linspace(0.2, 1.0, 16)
    chaos = {"model": "pin-on-disc", "Omega": 0.5, "t_max": 600.0}
    found = [respond(start={"phi_dot": float(speed)}, **chaos).values for speed in speeds]
    assert {one["attractor"] for one in found} == {"chaotic"}
    sizes = np.array([one["L_s"] for one in found])
    told = np.sqrt(np.mean([one["L_s_standard_error"] ** 2 for one in found]))
    assert 0.5 < np.std(sizes, ddof=1) / told < 2.0  # 0.5 of 16 draws: one in 3,000


def test_a_motion_with_a_period_has_an_intensity_without_a_standard_error() -> None:
    found = respond(start={"x_dot": 0.1}, mu_k=0.1, mu_s=0.3, v=0.1).values
    assert found["attractor"] == "periodic"
    assert "L_s" in found and "L_s_standard_error" not in found


def test_contact_is_lost() -> None:
    found = respond(start={"theta_dot": 150.0}, model="pin-on-disc")
    assert (found.status, found.reason) == ("ok", "contact_lost")
    assert found.values["attractor"] == "contact_lost"
    assert 0.0 < found.values["transient_used"] < 0.1


def test_divergence_is_an_answer() -> None:
    found = respond("linear-slope", {"x": 20.0}, v=1e9, alpha_0=-0.9)
    assert (found.status, found.reason) == ("ok", "diverged")
    assert found.values["attractor"] == "diverged"


@pytest.mark.parametrize(
    ("budget", "reason"),
    [({"max_events": 2}, "too_many_events"), ({"max_steps": 5}, "too_many_steps")],
)
def test_budgets_are_reported(budget: Any, reason: str) -> None:
    found = respond(solver=SolverSettings(**budget))
    assert (found.status, found.reason) == ("budget", reason)


def test_too_short_a_time_is_undecided() -> None:
    found = respond(t_max=60.0, u0=0.5, omega=0.5)
    assert found.values["attractor"] == "undecided"
    assert found.reason == "time_budget"


@pytest.mark.parametrize("damping", [0.65, 0.68])
def test_a_law_without_stick_can_keep_its_cycle_beside_a_stable_equilibrium(damping: float) -> None:
    """No event tells that the oscillation has died: only arriving at the equilibrium does."""
    near = respond("tanh of stribeck", {"x": 2.9}, section=UPWARD, t_max=4000.0, c=damping)
    far = respond("tanh of stribeck", {}, section=UPWARD, t_max=4000.0, c=damping)
    assert near.values["attractor"] == "equilibrium"
    assert far.values["attractor"] == "periodic"
    assert far.values["x_max"] - far.values["x_min"] > 1.5


def test_a_mass_that_came_to_rest_is_stuck() -> None:
    found = respond(start={"x": 20.0}, v=0.0, N=1.0)
    assert found.values["attractor"] == "equilibrium"
    assert found.reason == "stuck"
    assert found.values["stick_fraction"] == 1.0
    assert found.values["x_max"] == pytest.approx(-0.22, abs=1e-6)


@pytest.mark.parametrize(("ratio", "amplitude"), [(0.6, 1.4865816), (1.5, 0.5537749)])
@pytest.mark.parametrize("section", [UPWARD, Section("phase"), Section("phase", phase=1.0)])
def test_forced_sliding_without_stick(section: Section, ratio: float, amplitude: float) -> None:
    changes = {"v": 0.0, "N": 1.0, "mu_k": 0.5, "mu_s": 0.5, "u0": 1.0, "omega": ratio}
    found = respond(start={"x": 1.0}, section=section, **changes)
    assert found.values["attractor"] == "periodic"
    assert found.values["period_ratio"] == 1.0
    assert found.values["x_max"] == pytest.approx(amplitude, abs=1e-6)
    assert found.values["x_min"] == pytest.approx(-amplitude, abs=1e-6)


def test_an_unexcited_system_has_no_phase_to_strobe() -> None:
    found = respond(section=Section("phase"), t_max=400.0)
    assert found.status == "ok"
    assert found.values["attractor"] in ("undecided", "quasiperiodic")
    assert found.values["L_s"] == pytest.approx(1.7296603704, rel=0.1)


# --- measures ------------------------------------------------------------------------------------
def test_the_coulomb_cycle() -> None:
    slip, stick = pi + 2 * atan(1 / 1.7), 3.4
    found = respond(solver=TIGHT).values
    assert found["period"] == pytest.approx(slip + stick, abs=1e-12)
    assert found["stick_fraction"] == pytest.approx(stick / (slip + stick), abs=1e-12)
    assert found["slip_fraction"] + found["stick_fraction"] == pytest.approx(1.0, abs=1e-15)
    assert found["L_s"] == pytest.approx(1.7296603704, abs=1e-10)
    assert found["L_s_reference"] == pytest.approx([2.3])
    assert (found["multiplicity"], found["response_frequency"]) == (1, 1.0 / found["period"])
    assert found["x_dot_max"] == 1.0
    assert found["x_dot_min"] == pytest.approx(-sqrt(1 + 1.7**2), abs=1e-12)
    np.testing.assert_allclose(found["floquet_multiplier"], [1.0, 0.0], atol=1e-12)
    assert "lyapunov" not in found  # stick forgets all: what is left of the multiplier is rounding


@pytest.mark.parametrize(
    ("law", "changes"),
    [("coulomb", FORCED), ("stribeck", {"c": 0.1}), ("tanh of stribeck", {"c": 0.1, "sigma": 5.0})],
)
def test_measures_are_those_of_the_samples(law: str, changes: Any) -> None:
    """Along whole periods, fine samples must give the integrals that were carried along."""
    section = UPWARD if law.startswith("tanh") else Section("event")
    found = respond(law, section=section, t_max=4000.0, **changes).values
    assert found["attractor"] == "periodic"
    period = found["period"]
    begun = found["transient_used"] + 40 * period  # the class is told before the motion has arrived
    end = begun + period
    settings = {"t_end": end, "sample": period / 20_000}
    moved = analyse("belt-1dof", law, "history", {}, settings, **changes).values
    inside = moved["time"] >= begun
    x, time = moved["x"][inside], moved["time"][inside]
    spread = np.trapezoid((x - found["L_s_reference"][0]) ** 2, time) / (time[-1] - time[0])
    assert found["L_s"] == pytest.approx(spread, rel=1e-4)
    assert found["x_max"] == pytest.approx(np.max(x), rel=1e-6)
    assert found["x_min"] == pytest.approx(np.min(x), rel=1e-5, abs=1e-6)
    rms = np.sqrt(np.trapezoid(x**2, time) / (time[-1] - time[0]))
    assert found["x_rms"] == pytest.approx(rms, rel=1e-4)
    sticking = np.mean(moved["contact_state"][inside] == 2)
    assert found["stick_fraction"] == pytest.approx(sticking, abs=1e-3)


def test_a_multiplier_is_the_rate_of_the_return_map() -> None:
    """The forced belt at omega = 0.85: distances at the section shrink by the multiplier."""
    found = respond(section=RELEASE, u0=0.5, omega=0.85, solver=TIGHT)
    times, states = np.zeros(12), np.zeros((12, 2))
    begun = motion("belt-1dof", start={}, u0=0.5, omega=0.85)
    begun.run(1e3, RELEASE, (times, states))
    steps = np.abs(np.diff(states[:, 0]))
    rates = steps[3:6] / steps[2:5]
    assert found.values["floquet_multiplier"][0] == pytest.approx(rates[-1], rel=1e-3)
    exponent = np.log(found.values["floquet_multiplier"][0]) / found.values["period"]
    assert found.values["lyapunov"] == pytest.approx(exponent, rel=1e-12)


# --- starts --------------------------------------------------------------------------------------
def following(before: Outcome, **changes: float) -> Outcome:
    """The steady state of a neighbour that starts where `before` ended."""
    start = Start("up", "continue", {"x": 1e-6}, before.carry)
    return respond("stribeck", start, **changes)


def test_neighbours_follow_their_branch() -> None:
    """At c = 0.7 stick-slip and sliding coexist: each is found by following it."""
    cycle = respond("stribeck", {}, c=0.65)
    rest = respond("stribeck", Start("a", "equilibrium", {"x": 1e-6}), c=0.75)
    assert cycle.values["attractor"] == "periodic"
    assert rest.values["attractor"] == "equilibrium"
    assert following(cycle, c=0.7).values["attractor"] == "periodic"
    assert following(rest, c=0.7).values["attractor"] == "equilibrium"
    assert following(cycle, c=0.7).values["x_max"] > following(rest, c=0.7).values["x_max"] + 0.5


@pytest.mark.parametrize(
    ("N0", "told"), [(8.0, "equilibrium"), (20.0, "periodic"), (30.0, "chaotic")]
)
def test_what_is_told_in_passing_is_told_the_same(N0: float, told: str) -> None:
    """What is neither rest nor a cycle by half of its time leaves nothing to go on from."""
    one, start = system("pin-on-disc"), Start("a", "state", {"phi_dot": 1.75})
    parameters = defaults("pin-on-disc", "coulomb", Omega=1.75, N0=N0)
    default = get_analysis("response").default_settings
    settings = default | {"section": RELEASE, "observe": "phi", "t_max": 150.0}
    whole = Request(one.setup, parameters, "response", settings, start=start)
    found = execute.answer(whole)
    passed = execute.answer(replace(whole, in_passing=True))
    assert found.values["attractor"] == told
    if told == "chaotic":
        assert passed.values == {"attractor": "undecided"}
        assert passed.carry is None
    else:
        assert passed.carry == found.carry
        np.testing.assert_equal(passed.values, found.values)


def test_a_sticking_contact_takes_on_the_new_drive_velocity() -> None:
    from fiv_cli.analyses.common import start_motion
    from fiv_cli.dynamics.motion import Motion

    carried = {"attractor": "periodic", "state": [1.0, 1.0], "sticking": [1]}
    parameters = defaults("belt-1dof", "coulomb", v=1.3)
    start = Start("up", "continue", {}, carried)
    one = system("belt-1dof")
    begun = start_motion(one, Request(one.setup, parameters, "response", {}, TIGHT, start), None)
    assert isinstance(begun, Motion)
    assert list(begun.y) == [1.0, 1.3]
    assert begun.kinds[0] == 1


def test_what_is_handed_on_is_plain_and_at_phase_zero() -> None:
    found = respond(**FORCED, t_max=4000.0)
    assert found.carry is not None
    assert set(found.carry) == {"attractor", "state", "sticking"}
    again = respond(start=Start("up", "continue", {}, found.carry), t_max=4000.0, **FORCED)
    assert again.values["L_s"] == pytest.approx(found.values["L_s"], rel=1e-6)
    assert again.values["transient_used"] < found.values["transient_used"]


def test_without_an_equilibrium_there_is_no_start_from_it() -> None:
    found = respond(start=Start("a", "equilibrium", {"x": 1e-3}), v=0.0)
    assert (found.status, found.reason) == ("failed", "no_drive")


# --- equilibria and eigenvalues ------------------------------------------------------------------
@pytest.mark.parametrize(
    ("law", "changes", "expected"),
    [
        ("coulomb", {}, 2.3),
        ("coulomb", {"v": -1.0}, -2.3),
        ("coulomb", {"u0": 0.5}, 2.3),
        ("stribeck", {"c": 0.2}, 2.3 + 1.7 * np.exp(-1.0) - 0.0),
        ("linear-slope", {"c": 0.05}, 10.0 - 0.1),
        ("hyperbolic", {"mu_0": 0.4, "delta": 3.0}, 1.0),
    ],
)
def test_sliding_equilibria(law: str, changes: Any, expected: float) -> None:
    found = analyse("belt-1dof", law, "equilibrium", **changes)
    assert found.values["n_solutions"] == 1
    assert found.values["equilibrium"][0, 0] == pytest.approx(expected, rel=1e-12)
    assert found.values["F_N"][0] == 10.0 or law == "linear-slope"
    assert found.values["F_T"][0] == pytest.approx(expected, rel=1e-12)
    assert found.values["residual"][0] < 1e-13


def test_a_drive_at_rest_has_no_sliding_equilibrium() -> None:
    found = analyse("belt-1dof", "coulomb", "equilibrium", v=0.0)
    assert (found.status, found.reason) == ("failed", "no_drive")


@pytest.mark.parametrize(
    ("law", "slope"),
    [("coulomb", 0.0), ("stribeck", -1.7 * np.exp(-1.0)), ("hyperbolic", -10 * 0.4 * 3 / 16),
     ("linear-slope", -0.1)],
)  # fmt: skip
def test_eigenvalues_of_the_belt(law: str, slope: float) -> None:
    """m s^2 + (c + dF/dv) s + k = 0 with the slope of each law at the belt's speed."""
    changes = {"c": 0.3, "m": 2.0, "k": 5.0}
    found = analyse("belt-1dof", law, "eigenvalues", **changes).values
    expected = np.roots([2.0, 0.3 + slope, 5.0])
    assert found["eigenvalue_real"] == pytest.approx(expected.real, abs=1e-13)
    assert np.abs(found["eigenvalue_imag"]) == pytest.approx(np.abs(expected.imag), abs=1e-13)
    assert found["mode_frequency"] == pytest.approx(np.abs(expected.imag) / (2 * pi))
    side = "stable" if expected[0].real < 0.0 else "unstable"
    assert found["stable"] == ("neutral" if expected[0].real == 0.0 else side)
    assert found["growth_rate"] == pytest.approx(np.max(expected.real), abs=1e-13)
    fastest = expected[np.argmax(expected.real)]
    assert found["growth_frequency"] == pytest.approx(abs(fastest.imag) / (2 * pi))


@pytest.mark.parametrize("mu_k", [0.05, 0.1, 0.15, 0.2])
def test_of_modes_that_grow_alike_the_frequency_told_is_the_lowest(mu_k: float) -> None:
    """Not that of whichever rounding lets grow faster."""
    changes = {"c1": 0.1, "c2": 0.1, "mu_k": mu_k}
    found = analyse("flutter-2dof", "coulomb", "eigenvalues", **changes).values
    assert found["eigenvalue_real"] == pytest.approx(-0.05, abs=1e-12)
    assert found["growth_frequency"] == min(found["mode_frequency"])


def test_the_jacobian_is_the_derivative_of_the_rates() -> None:
    state = sliding(system("pin-on-disc"), defaults("pin-on-disc", "coulomb"))
    at = np.array([0.03, -0.02, 0.5, -0.3])
    step = 1e-6
    differences = [(state.rates(at + step * e) - state.rates(at - step * e)) / (2 * step)
                   for e in np.eye(4)]  # fmt: skip
    np.testing.assert_allclose(state.jacobian(at), np.array(differences).T, rtol=1e-6, atol=1e-4)


def test_the_spectrum_is_ordered_and_its_vectors_normalised() -> None:
    matrix = np.random.default_rng(5).normal(size=(6, 6))
    values, vectors = spectrum(matrix)
    np.testing.assert_allclose(matrix @ vectors, vectors * values, atol=1e-12)
    assert np.all(np.diff(np.round(np.abs(values.imag), 10)) >= 0.0)
    np.testing.assert_allclose(np.linalg.norm(vectors, axis=0), 1.0, rtol=1e-12)
    largest = vectors[np.argmax(np.abs(vectors), axis=0), np.arange(6)]
    np.testing.assert_allclose(largest.imag, 0.0, atol=1e-14)
    assert np.all(largest.real > 0.0)


@pytest.mark.parametrize("number", [1, 2, 3, 4])
def test_eigenvalues_at_each_equilibrium(number: int) -> None:
    """A buckled pin has three equilibria."""
    changes = {"k1": 0.0, "mu_k": 0.0}
    settings = {"at_equilibrium": number}
    found = analyse("pin-on-disc", "coulomb", "eigenvalues", None, settings, **changes)
    places = analyse("pin-on-disc", "coulomb", "equilibrium", **changes).values["equilibrium"]
    if number > len(places):
        assert (found.status, found.reason) == ("failed", "no_equilibrium")
        return
    state = sliding(system("pin-on-disc"), defaults("pin-on-disc", "coulomb", **changes))
    jacobian = state.jacobian(np.array([*places[number - 1], 0.0, 0.0]))
    expected = np.linalg.eigvals(jacobian)
    values = found.values["eigenvalue_real"] + 1j * found.values["eigenvalue_imag"]
    np.testing.assert_allclose(np.sort_complex(values), np.sort_complex(expected), rtol=1e-9)


@pytest.mark.parametrize(("friction", "expected"), [(4.2, "neutral"), (4.3, "unstable")])
def test_undamped_modes_are_neutral_until_they_merge(friction: float, expected: str) -> None:
    found = analyse("flutter-2dof", "coulomb", "eigenvalues", mu_k=friction).values
    assert found["stable"] == expected
    assert (found["growth_rate"] == 0.0) == (expected == "neutral")
    values = found["eigenvalue_real"] + 1j * found["eigenvalue_imag"]
    assert (coupled_modes(values).max() >= 0) == (expected == "unstable")


@pytest.mark.parametrize("damping", [1e-7, 1e-9, 1e-12])
def test_growth_rates_keep_their_digits_under_weak_damping(damping: float) -> None:
    """-(y.C x)/(2 y.x) with x, y the undamped mode and its dual, but for the damping squared."""
    changes = {"mu_k": 3.0, "c1": damping, "c2": 2.0 * damping}
    found = analyse("flutter-2dof", "coulomb", "eigenvalues", **changes).values
    undamped = sliding(system("flutter-2dof"), defaults("flutter-2dof", "coulomb", mu_k=3.0))
    stiffness = -undamped.jacobian(np.zeros(4))[2:, :2]
    squares, shapes = np.linalg.eig(stiffness)
    duals = np.linalg.inv(shapes)
    rates = -np.diag(duals @ np.diag([damping, 2.0 * damping]) @ shapes) / 2.0
    expected = rates[np.argsort(squares)].repeat(2)
    np.testing.assert_allclose(found["eigenvalue_real"], expected, rtol=1e-12)
    assert found["stable"] == "stable"


def test_conjugate_pairs_are_conjugate_to_the_last_bit() -> None:
    found = analyse("belt-5dof", "coulomb", "eigenvalues", mu_k=1.4).values
    values = found["eigenvalue_real"] + 1j * found["eigenvalue_imag"]
    assert set(values) == set(values.conj())


def test_merged_modes_know_each_other() -> None:
    values = np.array([0.1 + 2j, 0.1 - 2j, -0.1 + 2j, -0.1 - 2j, -0.3 + 7j, -0.3 - 7j])
    (partner,) = coupled_modes(values[None])
    assert set(partner[:2]) <= {2, 3}
    assert set(partner[2:4]) <= {0, 1}
    assert list(partner[4:]) == [-1, -1]


# --- histories -----------------------------------------------------------------------------------
def test_histories_hold_the_motion_at_their_samples() -> None:
    found = analyse("belt-1dof", "coulomb", "history", {}, {"t_end": 0.4, "sample": 0.1}).values
    time = np.array([0.0, 0.1, 0.2, 0.3, 0.4])
    np.testing.assert_allclose(found["time"], time, rtol=1e-15)
    np.testing.assert_allclose(found["x"], 2.3 * (1 - np.cos(time)), atol=1e-12)
    np.testing.assert_allclose(found["x_dot"], 2.3 * np.sin(time), atol=1e-12)
    assert np.all(found["F_N"] == 10.0)
    np.testing.assert_allclose(found["F_T"], 2.3, rtol=1e-14)
    assert np.all(found["contact_state"] == 0)
    np.testing.assert_allclose(found["kinetic_energy"], found["x_dot"] ** 2 / 2, rtol=1e-14)
    np.testing.assert_allclose(found["friction_power"], 2.3 * found["x_dot"], rtol=1e-13)
    np.testing.assert_allclose(found["drive_power"], 2.3, rtol=1e-14)


@pytest.mark.parametrize(
    ("t_end", "interval", "expected"),
    [(1.0, 0.5, [0.0, 0.5, 1.0]), (1.0, 0.4, [0.0, 0.4, 0.8, 1.0]), (0.3, 0.1, [0, 0.1, 0.2, 0.3])],
)
def test_the_end_is_always_sampled_once(t_end: float, interval: float, expected: Any) -> None:
    assert sample_times({"t_end": t_end, "sample": interval}) == pytest.approx(expected)


def test_a_ledger_longer_than_a_page(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(recorder, "LEDGER_ROWS", 4096)
    found = analyse("belt-1dof", "coulomb", "history", {}, {"t_end": 20_000.0, "sample": 1e4})
    times = np.array(found.ragged["event_time"])
    assert len(times) == found.values["n_events"] > 4096 + 500
    assert np.all(np.diff(times) > 0.0)
    np.testing.assert_allclose(times[3::2] - times[1:-2:2], 7.605040788107404, atol=1e-9)
    assert set(zip(found.ragged["event_from"], found.ragged["event_to"], strict=True)) == {
        (CODE_SLIP_PLUS, CODE_STICK), (CODE_STICK, CODE_SLIP_PLUS),
    }  # fmt: skip
    assert set(found.ragged["event_contact"]) == {1}


def test_no_row_is_lost_where_two_contacts_change_at_once(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(recorder, "LEDGER_ROWS", 3)
    found = analyse(TWO_MASSES, "coulomb", "history", {}, {"t_end": 50.0, "sample": 1.0})
    assert len(found.ragged["event_time"]) == found.values["n_events"] > 20
    assert list(found.ragged["event_contact"]) == [1, 2] * (found.values["n_events"] // 2)
    assert found.values["F_N"].shape == (2, 51)


def test_after_the_end_of_a_motion_there_are_no_samples() -> None:
    found = analyse(
        "pin-on-disc", "coulomb", "history", {"theta_dot": 150.0}, {"t_end": 0.1, "sample": 1e-4}
    )
    assert found.reason == "contact_lost"
    known = np.isfinite(found.values["phi"])
    assert 0 < known.sum() < len(known)
    assert np.all(np.diff(known.astype(int)) <= 0)
    assert np.array_equal(found.values["contact_state"] >= 0, known)


# --- execution -----------------------------------------------------------------------------------
def test_an_exception_is_an_outcome() -> None:
    belt, start = Setup.of("belt-1dof", "coulomb"), Start("a", "state")
    request = execute.Request(belt, {"m": 1.0}, "response", {}, start=start)
    found = execute.execute(request)
    assert (found.status, found.reason) == ("failed", "internal_error")
    assert "KeyError" in found.message


ROOTS = {"system": "original"}
AT_ONCE = (
    ("pin-on-disc", "coulomb", "equilibrium", ROOTS, {"Omega": [2.0, 0.0, 5.0], "k1": [20.0, 2e3]}),
    ("flutter-2dof", "coulomb", "eigenvalues", {**ROOTS, "at_equilibrium": 1},
     {"c1": [0.0, 0.1], "mu_k": [0.3, 1.2, 2.5], "v": [1.0, 0.0]}),
    ("excited-2dof", "coulomb", "eigenvalues", {"system": "averaged", "at_equilibrium": 1},
     {"A_b": [1.0, 40.0], "v": [0.1, 2.0]}),
    ("flutter-2dof", "coulomb", "critical",
     {**ROOTS, "parameter": Varied("mu_k"), "bracket": (0.0, 3.0)},
     {"c1": [0.0, 0.1], "alpha1": [-np.pi / 4, np.pi / 4]}),
)  # fmt: skip


@pytest.mark.parametrize(("model", "law", "kind", "settings", "grid"), AT_ONCE)
def test_points_run_at_once_are_answered_as_alone(
    model: str, law: str, kind: str, settings: dict[str, Any], grid: dict[str, list[float]]
) -> None:
    """To the last bit, one that breaks its equations included."""
    setup, known = Setup.of(model, law), defaults(model, law)
    points = [
        {**known, **dict(zip(grid, values, strict=True))} for values in product(*grid.values())
    ]
    requests = [execute.Request(setup, point, kind, settings) for point in points]
    alone = [execute.execute(request) for request in requests]
    assert len({repr(found.values) for found in alone}) > 1
    for given, expected in (
        (requests, alone),
        ([replace(requests[0], parameters={}), *requests], [None, *alone]),
    ):
        for found, one in zip(execute.execute_all(given), expected, strict=True):
            if one is None:
                assert found.reason == "internal_error"
            else:
                assert (found.status, found.reason) == (one.status, one.reason)
                np.testing.assert_equal(found.values, one.values)


@pytest.mark.parametrize("rows", [10, 2**15])
def test_motions_recorded_by_one_call_are_those_recorded_alone(
    rows: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Ledgers included, whatever a page holds; one among them loses its contact, one its steps."""
    setup, known = Setup.of("pin-on-disc"), defaults("pin-on-disc", "coulomb")
    settings = {"t_end": 3.0, "sample": 0.5, "points": ()}
    requests = [
        execute.Request(
            setup, {**known, "Omega": 2.0, "N0": 1.0 + i}, "history", settings,
            SolverSettings(max_events=40), Start("a", "state", {"theta_dot": 150.0 * (i == 4)}),
        )
        for i in range(20)
    ]  # fmt: skip
    alone = [execute.execute(request) for request in requests]
    assert {"", "contact_lost", "too_many_events"} == {found.reason for found in alone}
    monkeypatch.setattr(recorder, "LEDGER_ROWS", rows)
    for found, one in zip(execute.execute_all(requests), alone, strict=True):
        assert (found.status, found.reason) == (one.status, one.reason)
        np.testing.assert_equal(found.whole().values, one.values)
        np.testing.assert_equal(found.whole().ragged, one.ragged)


REST = {"section": Section("own"), "observe": None, "t_max": 60.0, "transient": 0.0,
        "lyapunov": "auto", "powers": "none"}  # fmt: skip
TOGETHER = (
    ("belt-1dof", "coulomb", {"c": 0.5, "mu_k": 0.2}, {"v": [0.3, 2.0], "u0": [0.0, 0.1]}, "x", {}),
    ("belt-1dof", "coulomb", {"c": 0.0}, {"v": [0.0, 1.0, -1.0]}, "x", {}),
    ("belt-1dof", "lugre", {"c": 0.5}, {"v": [0.0, 0.1, 1.0]}, "x", {}),
    ("belt-1dof", "coulomb", {"c": 0.5}, {"v": [0.1, 2.0]}, "x", {"transient": 3.0}),
    ("belt-5dof", "coulomb", {"F": 200.0, "k_nl": 1e4, "mu_s": 3.0}, {"mu_k": [0.3, 1.4]}, "x1",
     {"section": Section("event")}),
    ("pin-on-disc", "coulomb", {"Omega": 2.0}, {"N0": [0.0, 10.0, 30.0]}, "phi", {}),
    ("belt-2mass", "stribeck", {"N2": 5.0}, {"v": [0.0, 0.5, 2.0], "D": [0.0, 0.3]}, "x1", {}),
    ("disc-nonlinear-contact", "coulomb", {}, {"mu_k": [0.0, 0.3]}, "u", {"t_max": 2.0}),
    ("pin-on-disc", "coulomb", {"Omega": 2.0}, {"N0": [10.0]}, "phi", {"powers": "mean"}),
)  # fmt: skip


@pytest.mark.parametrize(("model", "law", "given", "grid", "state", "settings"), TOGETHER)
def test_steady_states_told_side_by_side_are_those_told_alone(
    model: str,
    law: str,
    given: dict[str, float],
    grid: dict[str, list[float]],
    state: str,
    settings: dict[str, Any],
) -> None:
    """At rest at once, on the way there, not at all, nowhere to begin; whatever is beside them."""
    setup, known = Setup.of(model, law), {**defaults(model, law), **given}
    points = [
        {**known, **dict(zip(grid, values, strict=True))} for values in product(*grid.values())
    ]
    starts = [Start("a", "equilibrium", {state: offset}) for offset in (0.0, 1e-4)]
    starts += [Start("a", "state", {state: value}) for value in (0.0, 0.1, np.nan)]
    starts.append(Start("a", "state", {f"{state}_dot": 2.0}))
    solver = SolverSettings(max_steps=20_000)
    requests = [
        Request(setup, point, "response", REST | settings, solver, start)
        for point in points
        for start in starts
    ]
    alone = [execute.execute(request) for request in requests]
    broken = [*requests[:2], replace(requests[0], parameters={}), *requests[2:]]
    for given_requests, expected in (
        (requests, alone),
        (requests[::-1], alone[::-1]),
        (broken, [*alone[:2], execute.execute(broken[2]), *alone[2:]]),
    ):
        together = list(execute.execute_all(given_requests))
        for found, one in zip([outcome.whole() for outcome in together], expected, strict=True):
            assert (found.status, found.reason) == (one.status, one.reason)
            if "attractor" in found.values and found.values["attractor"] in ATTRACTOR.names:
                found.values["attractor"] = ATTRACTOR.names[found.values["attractor"]]  # its code
            np.testing.assert_equal((found.values, found.ragged), (one.values, one.ragged))


def test_points_run_one_after_the_other_are_answered_as_alone() -> None:
    """Their equilibria are found together, where none of them breaks its equations."""
    setup, known = Setup.of("pin-on-disc"), defaults("pin-on-disc", "coulomb")
    points = [{**known, "Omega": 2.0, "N0": load} for load in (0.0, 10.0, 30.0)]
    settings = {"t_end": 0.1, "sample": 0.01, "points": ()}
    start = Start("a", "equilibrium", {"phi": 1e-3})
    alone = [Request(setup, point, "history", settings, start=start) for point in points]
    for others in ([], [replace(alone[0], parameters={})]):
        batch = Batch([*alone, *others])
        for request in alone:
            found, one = execute.execute(replace(request, batch=batch)), execute.execute(request)
            assert (found.status, found.reason) == (one.status, one.reason)
            np.testing.assert_equal(found.values, one.values)


def test_motions_recorded_side_by_side_are_those_recorded_alone() -> None:
    """Some that lose contact, at once or later, and some that begin nowhere, among them."""
    setup, known = Setup.of("pin-on-disc"), defaults("pin-on-disc", "coulomb")
    loads, settings = (10.0, 0.0, 30.0), {"t_end": 0.3, "sample": 0.01, "points": ()}
    states = {"phi_dot": 1.0}, {"theta_dot": 150.0}, {"theta": 10.0}, {"phi": np.nan}
    starts = [Start("a", "equilibrium", {"phi": 1e-2})]
    starts += [Start("a", "state", state) for state in states]
    requests = [
        Request(setup, {**known, "N0": load}, "history", settings, start=start)
        for load in loads
        for start in starts
    ]
    together, alone = list(execute.execute_all(requests)), map(execute.execute, requests)
    assert len({(one.status, one.reason) for one in together}) >= 3
    for found, one in zip([outcome.whole() for outcome in together], alone, strict=True):
        assert (found.status, found.reason) == (one.status, one.reason)
        np.testing.assert_equal((found.values, found.ragged), (one.values, one.ragged))


def test_what_is_asked_along_a_parameter_is_none_of_the_points_of_a_batch() -> None:
    """Parameters made on the way, one after the other, may lie at the same place in memory."""
    setup, known = Setup.of("pin-on-disc"), defaults("pin-on-disc", "coulomb")
    first = Request(setup, known, "response", {})
    first, built = replace(first, batch=Batch([first])), system("pin-on-disc")
    for load in np.linspace(5.0, 40.0, 300):
        there = replace(first, parameters={**known, "N0": load})
        found, alone = (rest_of(built, one)[1] for one in (there, replace(there, batch=None)))
        np.testing.assert_array_equal(found, alone)


def test_a_request_gives_what_the_analysis_gives() -> None:
    parameters = defaults("belt-1dof", "coulomb")
    settings = {"section": Section("event"), "observe": None, "t_max": 1000.0, "transient": 0.0,
                "lyapunov": "auto"}  # fmt: skip
    start = Start("a", "state", {"x": 0.0})
    belt = Setup.of("belt-1dof", "coulomb")
    request = execute.Request(belt, parameters, "response", settings, start=start)
    said: list[str] = []
    execute.prepare([request, request], said.append)
    found = execute.execute(request)
    assert found.values["L_s"] == respond().values["L_s"]
    assert execute.execute(request).values["period"] == found.values["period"]


def test_a_pin_that_starts_off_its_disc_is_an_answer_without_energies() -> None:
    """No contact state holds: there are no equations to call."""
    begun = motion("pin-on-disc", start={"theta": 10.0})
    assert not begun.started
    assert np.isnan(begun.energy())
    assert np.all(np.isnan(begun.rates()))
    found = analyse("pin-on-disc", "coulomb", "history", {"theta": 10.0}, {"t_end": 1.0})
    assert (found.status, found.reason) == ("ok", "contact_lost")
    assert np.isnan(found.values["energy_residual"])
    assert len(found.ragged["event_time"]) == 0


@pytest.mark.parametrize("kind", all_analyses())
def test_what_computes_an_analysis_takes_what_every_analysis_is_given(kind: str) -> None:
    analysis = get_analysis(kind)
    run = analysis.run.function if isinstance(analysis.run, Later) else analysis.run
    of = "system" if analysis.generated else "setup"
    asked = "requests" if analysis.in_blocks else "request"
    assert list(signature(run).parameters) == [of, asked]


@pytest.mark.parametrize(
    ("analysis", "kind", "compiled"),
    [
        ("history", "state", {FLOW}),
        ("history", "equilibrium", {FLOW, JACOBIAN}),
        ("eigenvalues", "state", {FLOW, JACOBIAN}),
        ("response", "state", {FLOW, JACOBIAN, TANGENT}),
    ],
)
def test_tangents_are_compiled_only_where_they_are_carried(
    analysis: str, kind: str, compiled: set[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """What is prepared is what a run uses."""
    monkeypatch.setattr(systems, "_BUILT", {})
    parameters = defaults("belt-1dof", "coulomb")
    kept = get_analysis(analysis)
    settings = kept.default_settings | {"t_end": 1.0}
    start = Start("a", kind) if kept.uses_starts else None
    belt = Setup.of("belt-1dof", "coulomb")
    request = execute.Request(belt, parameters, analysis, settings, start=start)
    execute.prepare([request], lambda sentence: None)
    (built,) = systems._BUILT.values()
    assert set(built.generated._engines) == compiled
    execute.execute(request)
    assert set(built.generated._engines) == compiled


def test_pin_friction_curve_of_the_equilibrium() -> None:
    """F_T = mu_k F_N at the pin, and the moments balance."""
    values = analyse("pin-on-disc", "coulomb", "equilibrium").values
    phi, theta = values["equilibrium"][0]
    stretch = 0.1 * theta + 0.01 * phi**2 / 0.2
    assert values["F_N"][0] == pytest.approx(30.0 - 1000.0 * stretch, rel=1e-12)
    assert values["F_T"][0] == pytest.approx(0.23 * values["F_N"][0], rel=1e-12)
    moment = -15.0 * phi - 1000 * 0.01 / 0.1 * phi * stretch - 1000 * 0.1 * 0.1 * (phi + theta)
    assert moment + 0.1 * values["F_T"][0] == pytest.approx(0.0, abs=1e-12)
    assert cos(phi) > sin(abs(theta))


def test_a_shaken_mass_that_reverses_and_never_sticks_is_periodic() -> None:
    """There is no slip->stick to judge by: the excitation itself is the section."""
    found = respond(v=0.0, mu_s=0.05, mu_k=0.05, u0=1.0, omega=0.6)
    assert found.values["attractor"] == "periodic"
    assert found.values["period_ratio"] == 1.0
    assert found.values["stick_fraction"] == 0.0
    assert len(found.ragged["section_value"]) == 0


def test_sliding_over_a_sector_repeats_with_the_disc() -> None:
    changes = {"Omega": 4.0, "beta": 0.26, "psi_a": 0.3}
    found = respond(start={"phi_dot": 4.0}, model="pin-on-disc", t_max=200.0, **changes)
    assert found.values["attractor"] == "periodic"
    assert found.values["period_ratio"] == 1.0
    assert found.values["stick_fraction"] == 0.0


def test_a_slide_that_is_quiet_late_in_the_budget_is_an_equilibrium() -> None:
    """At 0.5 rad/s three revolutions do not fit twice into half of the budget."""
    found = respond(start={"phi_dot": 0.5}, model="pin-on-disc", t_max=150.0, Omega=0.5, N0=2.0)
    assert found.values["attractor"] == "equilibrium"
    assert found.values["L_s"] == 0.0
