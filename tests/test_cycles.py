"""Periodic orbits by Newton's method, and the branches they lie on."""

from __future__ import annotations

from dataclasses import replace
from itertools import combinations
from math import atan, cos, exp, log, pi, sin, sqrt
from typing import Any
from unittest.mock import ANY

import bouncing_ball as ball
import numpy as np
import pytest
from motions import defaults, system
from scipy.integrate import quad, solve_ivp
from scipy.optimize import brentq
from small_models import BALL

from fiv_cli import api
from fiv_cli.analyses.base import Outcome, Section, SolverSettings, Start, Varied
from fiv_cli.analyses.cycles.branch import (
    Continuation,
    _are_apart,
    _jumps,
    _kind_of_change,
    _over_period,
    _unreversed,
    first_point,
)
from fiv_cli.analyses.cycles.first_guess import Returns, near_returns
from fiv_cli.analyses.cycles.periodic import (
    Anchor,
    Equations,
    Problem,
    _closed,
    begin,
    close,
    newton,
    passage,
)
from fiv_cli.api import analyse
from fiv_cli.case.load import parse_case
from fiv_cli.codegen.codes import CODE_NAMES, CODE_STICK, SEPARATION, SLIP, STICK
from fiv_cli.dynamics.motion import Motion, Stop
from fiv_cli.errors import CaseError

TURNING = Section("zero", state="x_dot", direction="down")
LANDING = Section("zero", state="z_dot", direction="down")


def cycle(
    model: Any = "belt-1dof",
    law: str = "coulomb",
    start: Any = None,
    branch: tuple[str, float, float] | None = None,
    section: Section | None = None,
    t_max: float = 50.0,
    **changes: Any,
) -> Outcome:
    """The cycle from a start; `branch` gives the parameter to follow it along and the bracket."""
    settings: dict[str, Any] = {"section": section or Section("event"), "t_max": t_max}
    for name in ("transient", "multiplicity", "width"):
        settings |= {name: changes.pop(name)} if name in changes else {}
    if branch is not None:
        varied = Varied(branch[0], changes.pop("followers", ()))
        settings |= {"parameter": varied, "bracket": branch[1:]}
    return analyse(model, law, "cycle", start or {}, settings, **changes)


def coulomb_belt() -> Problem:
    """The belt with its defaults, for the parts of the analysis."""
    solver = SolverSettings(rtol=1e-12)
    parameters = defaults("belt-1dof", "coulomb")
    return Problem(system("belt-1dof"), parameters, solver, Section("event"))


def ends(found: Outcome) -> list[tuple[str, float]]:
    """Kind and value of the changes and ends of a branch, in its order."""
    values = found.ragged
    return list(zip(values["cycle_end_kind"], values["cycle_end"], strict=True))


# --- cycles --------------------------------------------------------------------------------------
@pytest.mark.parametrize("start", [{}, {"x": 9.0}, {"x": -3.0, "x_dot": 0.4}])
def test_the_coulomb_cycle_from_a_rough_start(start: dict[str, float]) -> None:
    found = cycle(start=start).values
    assert found["cycle_period"] == pytest.approx(pi + 2 * atan(1 / 1.7) + 3.4, abs=1e-11)
    np.testing.assert_allclose(found["cycle_section"], [0.6, 1.0], atol=1e-11)
    np.testing.assert_allclose(found["floquet_multiplier"], [1.0, 0.0], atol=1e-12)
    assert found["stable"] == "stable"
    assert found["x_max"] == pytest.approx(2.3 + sqrt(1 + 1.7**2), abs=1e-11)
    assert found["residual"] < 1e-11
    assert (found["multiplicity"], found["n_events"]) == (1, 2)


@pytest.mark.parametrize(
    ("x_dot", "ratio", "releases"), [(0.0, 4, (3.531843, 3.625851)), (1.0, 3, (3.866518, 4.026946))]
)
def test_two_cycles_of_the_excited_belt_coexist(x_dot: float, ratio: int, releases: Any) -> None:
    """Gates of an independent computation: omega = 1.2, periods 4 and 3 of the excitation."""
    section = Section("event", event="stick->slip")
    found = cycle(start={"x_dot": x_dot}, section=section, t_max=300.0, u0=0.5, omega=1.2)
    assert found.values["period_ratio"] == ratio
    assert found.values["multiplicity"] == 2
    np.testing.assert_allclose(np.sort(found.ragged["section_value"]), releases, atol=1e-6)
    assert found.values["stable"] == "stable"
    assert found.values["floquet_multiplier"][1] == pytest.approx(0.0, abs=1e-12)


@pytest.mark.parametrize(
    ("D", "period", "multiplier"), [(0.3, 19.25064477, -0.7302530), (0.2, 20.5694052, -0.9868573)]
)
def test_two_masses_nearly_flip(D: float, period: float, multiplier: float) -> None:
    """At D = 0.2 the multiplier is about -0.987; a short run looks aperiodic."""
    found = cycle("belt-2mass", "stribeck", t_max=300.0, D=D).values
    assert found["cycle_period"] == pytest.approx(period, abs=1e-7)
    assert found["floquet_multiplier_real"][1] == pytest.approx(multiplier, abs=1e-6)
    assert found["stable"] == "stable"


def test_an_unstable_sliding_cycle() -> None:
    """Between the stable equilibrium and stick-slip; its multiplier is exp(trace integrated)."""
    c, near = 0.65, {"x": 3.55, "x_dot": 0.0}
    found = cycle(law="stribeck", start=near, section=TURNING, t_max=14.0, c=c).values
    assert found["stable"] == "unstable"
    assert (found["n_events"], found["multiplicity"]) == (0, 1)

    def rates(t: float, y: Any) -> list[float]:
        friction = 10 * (0.23 + 0.17 * exp(-(1 - y[1])))
        return [y[1], friction - c * y[1] - y[0]]

    period, begin = found["cycle_period"], found["cycle_section"]
    around = solve_ivp(rates, (0, period), begin, rtol=1e-12, atol=1e-12, dense_output=True)
    np.testing.assert_allclose(around.y[:, -1], begin, atol=1e-9)
    trace = quad(lambda t: 1.7 * exp(-(1 - around.sol(t)[1])) - c, 0, period, epsabs=1e-11)[0]
    assert found["floquet_multiplier"][0] == pytest.approx(exp(trace), rel=1e-8)


@pytest.mark.parametrize("rtol", [1e-7, 1e-9])
def test_multipliers_of_fast_modes_that_the_cycle_leaves_at_rest(rtol: float) -> None:
    """Sliding on a stiff belt: 16 Hz in steps of that motion, beside modes of 300 to 500 Hz.

    The dampers alone take phase volume: the multipliers' product is exp(-period times their sum).
    """
    section = Section("zero", state="x1_dot", direction="up")
    start = {
        "x1": -3.26951935, "y1": 3.12342914, "x2": 3.30762e-3, "y2": 1.37705e-3, "phi": 0.11311826,
        "y1_dot": -1.22505663, "x2_dot": -1.29442e-3, "y2_dot": -5.3923e-4, "phi_dot": -4.452069e-2,
    }  # fmt: skip
    options = {"contact_stiffness": "linear", "states": "slip"}
    stiff = {"F": 800.0, "k4": 5e6, "k5": 5e6, "k6": 5e6, "mu_k": 1.2}
    found = analyse(
        "belt-5dof", "coulomb", "cycle", start, {"section": section, "t_max": 0.5},
        options=options, solver=SolverSettings(rtol=rtol), **stiff,
    ).values  # fmt: skip
    assert found["cycle_period"] == pytest.approx(0.06104462, abs=1e-7)
    volume = exp(-0.58 * found["cycle_period"])  # c / m of five dampers, c (l1^2 + l2^2) / J
    assert np.prod(found["floquet_multiplier"]) == pytest.approx(volume, rel=1e-6)
    assert found["stable"] == "stable"


# --- a ball on a shaking table: everything in closed form ----------------------------------------
def bouncing(stable: bool) -> dict[str, float]:
    """A ball that bounces once a period, at time 0, a millimetre above where it should be."""
    phase = ball.impact_phase(0.1, stable)
    found = ball.in_flight(0.1, phase, (-phase / ball.OMEGA) % ball.PERIOD)
    return found | {"z": found["z"] + 1e-3}


@pytest.mark.parametrize("stable", [True, False])
def test_a_bouncing_cycle_is_found_stable_or_not(stable: bool) -> None:
    found = cycle(BALL, start=bouncing(stable), section=LANDING, t_max=6.0).values
    assert found["period_ratio"] == 1.0
    assert found["stable"] == ("stable" if stable else "unstable")
    expected = np.sort(np.abs(ball.multipliers(0.1, ball.impact_phase(0.1, stable))))[::-1]
    np.testing.assert_allclose(found["floquet_multiplier"], expected, rtol=1e-8)


# Fold: the table is just fast enough. Flip: multiplier -1, from trace and determinant e^2.
FOLD = ball.TABLE_SPEED / ball.OMEGA
RISE = 2 * ball.GRAVITY * (1 + ball.RESTITUTION**2) / (1 + ball.RESTITUTION) ** 2 / ball.OMEGA**2
EXACT = {"fold": FOLD, "flip": sqrt(FOLD**2 + RISE**2)}


def test_a_branch_of_impacting_cycles_folds_and_flips_where_it_must() -> None:
    start, branch = bouncing(stable=True), ("A", 0.05, 0.5)
    found = cycle(BALL, start=start, section=LANDING, t_max=6.0, branch=branch)
    kinds = [kind for kind, _ in ends(found)]
    assert set(EXACT) <= set(kinds)
    assert_ends_within_their_errors(found, 1e-6 * 0.45)
    assert found.values["cycle_lowest"] == pytest.approx(FOLD, abs=1e-6)
    assert found.values["cycle_lowest_kind"] == "fold"
    turn = kinds.index("fold")
    assert found.ragged["cycle_end_goes_on"][turn] == "yes"
    value, stable = found.ragged["branch_value"], np.array(found.ragged["branch_stable"])
    for side in ("stable", "unstable"):  # a figure's lines begin there, not a step further on
        assert np.min(np.abs(value[stable == side] - EXACT["flip"])) <= 1e-6 * 0.45


def assert_ends_within_their_errors(found: Outcome, width: float, cycles: float = 2e-8) -> None:
    """Ends lie within their errors; these are the brackets and what `cycles` are worth."""
    arrays = (found.ragged[f"cycle_end{name}"] for name in ("_kind", "", "_width", "_error"))
    for kind, value, half, error in zip(*arrays, strict=True):
        if kind in EXACT:
            assert abs(value - EXACT[kind]) <= error <= half + cycles + width
            assert half <= 0.5 * width + 1e-10


@pytest.mark.parametrize("width", [1e-4, 1e-5, 1e-8, 1e-10, 1e-13])
@pytest.mark.parametrize(("low", "high"), [(0.05, 0.5), (0.031, 0.6)])
def test_the_error_of_an_end_is_bounded_however_closely_it_is_bisected(
    width: float, low: float, high: float
) -> None:
    start, branch = bouncing(stable=True), ("A", low, high)
    found = cycle(BALL, start=start, section=LANDING, t_max=6.0, branch=branch, width=width)
    assert_ends_within_their_errors(found, width * (high - low))
    assert found.values["cycle_lowest_error"] == found.ragged["cycle_end_error"].min(
        where=found.ragged["cycle_end"] == found.values["cycle_lowest"], initial=np.inf
    )


# --- rigid contact with a disc: two states are determined by the others ---------------------------
def on_the_disc(t_max: float = 2.0, **changes: float) -> tuple[Outcome, Problem]:
    """A stick-slip cycle in rigid contact with a disc of one doublet, and its problem."""
    model, options = "disc-rigid-contact", {"modes": "0,1"}
    given = {"c_z": 2.0, "xi": 0.03, "mu_s": 0.8, "mu_k": 0.5, **changes}
    start, settings = {"phi": 0.02}, {"section": Section("event"), "t_max": t_max}
    found = analyse(model, "coulomb", "cycle", start, settings, options=options, **given)
    built = system(model, "coulomb", options, SolverSettings().rtol)
    solver = SolverSettings(rtol=1e-12)
    return found, Problem(built, defaults(model, "coulomb", **given), solver, Section("event"))


def differences(problem: Problem, anchor: Anchor, span: float, scales: Any) -> Any:
    """Central differences of the state after `span` by the state at `anchor`."""
    columns = []
    for shift in np.diag(1e-6 * scales):
        ends = [
            passage(problem, replace(anchor, state=anchor.state + moved), span, tangents=False)
            for moved in (shift, -shift)
        ]
        columns.append((ends[0].state - ends[1].state) / (2 * np.max(shift)))
    return np.array(columns).T


@pytest.mark.parametrize(("Omega", "sticks"), [(5.0, False), (0.5, True)], ids=["slip", "stick"])
def test_multipliers_on_a_disc_are_those_of_the_return_map(Omega: float, sticks: bool) -> None:
    """Two are zero for z, which contact determines, one because the contact sticks."""
    found, problem = on_the_disc(Omega=Omega)
    carried = found.carry
    anchor = Anchor(np.array(carried["state"]), (sticks,), 0.0, (True,))
    assert (carried["sticking"], carried["closed"]) == ([int(sticks)], [1])
    around = differences(problem, anchor, carried["period"], np.array(carried["scales"]))
    expected = np.sort(np.abs(np.linalg.eigvals(around)))[::-1]
    multipliers = found.values["floquet_multiplier"]
    np.testing.assert_allclose(multipliers, expected, atol=1e-5)
    assert multipliers[0] == pytest.approx(1.0, abs=1e-9)
    np.testing.assert_allclose(multipliers[-3:], 0.0, atol=1e-12)
    assert 0.3 < multipliers[1] < 0.9
    assert found.values["stable"] == "stable"
    assert found.values["n_events"] == 2
    assert found.values["residual"] < 1e-9


def test_a_response_on_a_disc_has_the_multipliers_of_its_cycle() -> None:
    changes = {"Omega": 5.0, "c_z": 2.0, "xi": 0.03, "mu_s": 0.8, "mu_k": 0.5}
    settings = {"section": Section("event"), "t_max": 4.0}
    found = analyse(
        "disc-rigid-contact", "coulomb", "response", {"phi": 0.02}, settings,
        options={"modes": "0,1"}, **changes,
    ).values  # fmt: skip
    assert found["attractor"] == "periodic"
    expected = on_the_disc(Omega=5.0)[0].values["floquet_multiplier"]
    np.testing.assert_allclose(found["floquet_multiplier"], expected, atol=1e-6)
    assert found["lyapunov"] == pytest.approx(log(expected[1]) / found["period"], rel=1e-5)


@pytest.mark.parametrize(("Omega", "kind"), [(5.0, SLIP), (0.5, STICK)])
def test_a_closed_rigid_contact_stays_closed_where_a_motion_is_taken_up_again(
    Omega: float, kind: int
) -> None:
    """Its gap is zero to rounding; what a step of Newton's method lifts is pressed in again."""
    found, problem = on_the_disc(Omega=Omega)
    anchor = Anchor(np.array(found.carry["state"]), (kind == STICK,), 0.0, (True,))
    rounded = begin(problem, anchor).y + problem.system.state_vector({"z": 1e-15})
    assert Motion(problem.system, problem.parameters, problem.solver, rounded).kinds[0] == kind
    lifted = begin(problem, anchor).y + problem.system.state_vector({"z": 1e-9})
    opened = Motion(problem.system, problem.parameters, problem.solver, lifted)
    assert opened.kinds[0] == SEPARATION
    closed = _closed(problem, anchor, opened)
    assert closed.kinds[0] == kind
    np.testing.assert_allclose(closed.y, begin(problem, anchor).y, rtol=1e-12)
    apart = replace(anchor, state=lifted, sticking=(False,), closed=(False,))
    assert begin(problem, apart).kinds[0] == SEPARATION


def test_tangents_on_a_disc_through_flights_and_landings() -> None:
    """Against neighbours of the motion, through impacts, stick and reversals of friction."""
    _, problem = on_the_disc(Omega=5.0, N0=50.0)
    start = {"phi": 1e-3, "z": 1.5e-3, "phi_dot": 10.0, "C_0_1": -1e-3, "C_0_1_dot": 1.0}
    anchor, span = Anchor(problem.system.state_vector(start), (False,), 0.0, (False,)), 0.02
    found = passage(problem, anchor, span)
    words = [CODE_NAMES[before] for before, _, _ in found.events]
    assert words.count("separation") == 3
    assert {"slip+", "slip-", "stick"} < set(words)
    scales = np.array([1e-2, 1e-3, 1e-3, 1e-3, 10.0, 1.0, 1.0, 1.0])
    tangents = found.monodromy * scales / scales[:, None]
    expected = differences(problem, anchor, span, scales) * scales / scales[:, None]
    np.testing.assert_allclose(tangents, expected, atol=1e-6 * np.max(np.abs(expected)))


# --- ends of branches ----------------------------------------------------------------------------
def speed_that_misses(c: float) -> float:
    """Belt speed at which a slip from release just touches the speed of the belt again."""
    w = sqrt(1 - c**2 / 4)

    def missed(v: float) -> float:
        stretch, slope = 1.7 - c * v, (v + c * (1.7 - c * v) / 2) / w
        cosine, sine = slope * w - c * stretch / 2, stretch * w + c * slope / 2
        rise, fall = cosine * c / 2 + sine * w, sine * c / 2 - cosine * w
        t = (atan(rise / fall) + pi * np.arange(1, 4)) / w  # where it is greatest or least
        return float(
            np.max(np.exp(-c * t / 2) * (cosine * np.cos(w * t) - sine * np.sin(w * t))) - v
        )

    return brentq(missed, 0.5, 5.0, xtol=1e-14)


@pytest.mark.parametrize("c", [0.1, 0.3])
@pytest.mark.parametrize("share", [1e-6, 1e-12])
def test_stick_slip_ends_where_the_landing_is_missed(c: float, share: float) -> None:
    """Damped Coulomb belt: the speed from the closed form of the slip."""
    found = cycle(branch=("v", 0.1, 4.0), c=c, v=0.5, width=share)
    (low, lowest), (high, highest) = ends(found)
    assert (low, lowest, high) == ("bracket", 0.1, "grazing")
    width = found.ragged["cycle_end_width"][-1]
    assert width <= 0.5 * (share + 1e-10) * 3.9
    error = found.ragged["cycle_end_error"][-1]
    assert abs(highest - speed_that_misses(c)) <= error <= 4 * width
    assert found.ragged["cycle_end_goes_on"] == ["no", "no"]
    assert set(found.ragged["branch_stable"]) == {"stable"}
    assert np.all(np.diff(found.ragged["branch_value"]) > 0.0)


@pytest.mark.parametrize(
    ("name", "bracket", "rest"),
    [("v", (0.5, 8.0), log(1.7 / 0.2)), ("c", (0.1, 2.0), 1.7 * exp(-1.0))],
)
def test_a_branch_turns_at_a_grazing_and_shrinks_to_the_equilibrium(
    name: str, bracket: tuple[float, float], rest: float
) -> None:
    """Stribeck belt: stick-slip, the unstable sliding cycle back, and the Hopf point c = -dF/dv."""
    found = cycle(law="stribeck", branch=(name, *bracket), t_max=60.0, c=0.2)
    (_, first), (turn, corner), (last, point) = ends(found)
    assert first == bracket[0]
    assert (turn, last) == ("grazing", "equilibrium")
    assert point == pytest.approx(rest, abs=3e-6)
    assert corner > point
    assert found.ragged["cycle_end_goes_on"] == ["no", "yes", "no"]
    assert found.ragged["cycle_end_event"] == ["not_computed", "stick", "not_computed"]
    assert found.ragged["cycle_end_contact"].tolist() == [0, 1, 0]
    stable = np.array(found.ragged["branch_stable"]) == "stable"
    turned = int(np.argmax(found.ragged["branch_value"]))
    assert np.all(stable[:turned]) and not np.any(stable[turned + 1 :])
    assert found.values["cycle_highest"] == found.values["stable_highest"] == corner
    kinds = [found.values[f"stable_{end}_kind"] for end in ("lowest", "highest")]
    assert kinds == ["bracket", "grazing"]


def test_a_branch_that_starts_at_an_edge_of_its_bracket_ends_where_any_other_does() -> None:
    """It shrinks to the Hopf point below, where 3 N (mu_s - mu_k) exp(-3 v) = c."""
    found = cycle(
        law="exponential", start={"x": 2.6}, branch=("v", 1.85, 2.0), section=Section("own"),
        m=1.0, k=1.0, c=0.02, N=10.0, v=2.0, mu_s=0.4, mu_k=0.2, alpha=3.0,
    )  # fmt: skip
    assert ends(found) == [("equilibrium", ANY), ("bracket", 2.0)]
    low, error = (found.values[f"cycle_lowest{of}"] for of in ("", "_error"))
    assert abs(low - log(300.0) / 3.0) <= error <= 1e-6


def test_a_closed_branch_is_followed_once_round() -> None:
    """Stribeck belt: as v_s rises the slope at slip passes through a maximum, and damping wins on
    both sides of it; stick-slip and the unstable sliding cycle meet at two grazings."""
    c, v = 0.5672859798991304, 1.2155511997619755
    found = cycle(law="stribeck", branch=("v_s", 0.3, 2.5), c=c, v=v, t_max=150.0)
    kinds = [kind for kind, _ in ends(found)]
    assert kinds[-1] == "closed"
    assert kinds.count("grazing") == 2
    assert found.values["cycle_lowest"] < 0.6
    assert found.values["cycle_highest"] > 1.3
    assert "stable_highest" not in found.values  # round it there is no highest
    value, stable = found.ragged["branch_value"], np.array(found.ragged["branch_stable"])
    assert value[-2] < 1.0 <= value[-1]  # round to v_s = 1, from below as it set out
    assert {"stable", "unstable"} <= set(stable)


def test_a_branch_goes_no_further_than_friction_makes_sense() -> None:
    """Coulomb belt: the time in stick, 2 (mu_s - mu_k) N / (k v), is gone at mu_k = mu_s."""
    found = cycle(branch=("mu_k", 0.1, 0.9))
    assert found.values["cycle_highest_kind"] == "mu_k_above_mu_s"
    assert found.values["cycle_highest"] == pytest.approx(0.4, abs=1e-6)
    mu_k = found.ragged["branch_value"]
    slip = pi + 2 * np.arctan(1 / (10 * (0.4 - mu_k)))
    np.testing.assert_allclose(found.ragged["branch_period"], slip + 20 * (0.4 - mu_k), rtol=1e-9)
    assert set(found.ragged["branch_multiplicity"]) == {1}
    far = mu_k < 0.3999  # from where it lands along the belt's speed, and x with the root of errors
    lands = found.ragged["branch_section"][far]  # as far below mu_k N as it let go above
    np.testing.assert_allclose(lands, 20 * mu_k[far] - 4, atol=1e-9)


@pytest.mark.parametrize(
    ("before", "after", "kind"),
    [
        (-0.99, -1.01, "flip"),
        (0.99, 1.01, "branching"),
        (0.99 * np.exp(1.1j), 1.01 * np.exp(1.1j), "torus"),
    ],
)
def test_what_a_multiplier_does_at_the_unit_circle(before: Any, after: Any, kind: str) -> None:
    line = Continuation(coulomb_belt(), Varied("v"), (0.5, 2.0), 1e-6)
    anchor = Anchor(np.array([2.3, -1.97]), (False,))
    found = close(line.problem, anchor, 7.6, np.ones(2))
    assert found is not None
    point = first_point(line, found, 1.0, True)
    assert point is not None
    here, there = (
        replace(point, cycle=replace(found, multipliers=np.array([1.0, m, np.conj(m), 0.1])))
        for m in (before, after)
    )
    assert _kind_of_change(line, here, there) == kind


def test_a_doubled_branch_ends_at_the_flips_of_the_single_one() -> None:
    """It comes back from there as the same cycle half a period on: no fold."""
    undamped = {
        "followers": ("mu_s",),
        "c1": 0.0,
        "c2": 0.0,
        "options": {"states": "all"},
        "section": TURNING,
    }
    lifted = {"start": {"y": 1.0}, "t_max": 1000.0, **undamped}
    laws = [{"mu_s": mu, "mu_k": mu} for mu in (5.0, 2.5)]
    doubled = cycle("flutter-2dof", branch=("mu_k", 2.6, 7.0), **laws[0], **lifted)
    single = cycle("flutter-2dof", branch=("mu_k", 2.4, 3.2), **laws[1], **lifted)
    assert (doubled.values["multiplicity"], single.values["multiplicity"]) == (2, 1)
    assert [kind for kind, _ in ends(doubled)] == ["flip", "flip", "closed"]
    at = single.ragged["cycle_end_kind"].index("flip")
    flip, error = (single.ragged[f"cycle_end{of}"][at] for of in ("", "_error"))
    off = abs(doubled.values["cycle_lowest"] - flip)
    assert off <= error + doubled.values["cycle_lowest_error"]


@pytest.mark.parametrize(
    ("slopes", "multipliers", "gone", "turned"),
    [
        ((0.5, 0.5), (0.7, 0.8), 0.1, 1.0),
        ((0.5, 0.5), (0.7, 0.8), -0.1, None),  # up at both, but down between them
        ((-0.5, -0.5), (0.7, 0.8), 0.1, None),
        ((0.5, -0.5), (0.7, 0.8), 0.1, -1.0),  # no fold so near
        ((0.05, -0.05), (0.9, 1.1), 0.1, 1.0),  # a fold
        ((0.05, -0.05), (0.98, 0.99), 0.1, 1.0),
        ((0.25, -0.001), (0.738, 0.739), 0.1, None),  # no multiplier passes 1
    ],
)
def test_directions_suit_where_the_parameter_went(
    slopes: Any, multipliers: Any, gone: float, turned: Any
) -> None:
    line = Continuation(coulomb_belt(), Varied("v"), (0.5, 2.0), 1e-6)
    found = close(line.problem, Anchor(np.array([2.3, -1.97]), (False,)), 7.6, np.ones(2))
    assert found is not None
    point = first_point(line, found, 1.0, True)
    assert point is not None
    before, after = (
        replace(
            point,
            tangent=np.array([1.0, slope]),
            cycle=replace(found, multipliers=np.array([1.0, multiplier])),
        )
        for slope, multiplier in zip(slopes, multipliers, strict=True)
    )
    kept = _unreversed(before, after, gone)
    assert (None if kept is None else kept.slope / slopes[1]) == turned


def test_the_pin_s_stick_slip_exists_beyond_what_starts_reach() -> None:
    """N0 = 30 N: followed from 5 rad/s the stable cycle lives to 14.83 rad/s, and ends grazing."""
    found = cycle(
        "pin-on-disc", start={"phi_dot": 5.0}, branch=("Omega", 0.5, 20.0), t_max=3.0,
        transient=2.0, Omega=5.0,
    )  # fmt: skip
    assert found.values["cycle_highest_kind"] == "grazing"
    assert found.values["cycle_highest"] == pytest.approx(14.82921, abs=2e-5)
    assert found.values["stable_highest"] == found.values["cycle_highest"]
    (flip,) = [value for kind, value in ends(found) if kind == "flip"]
    assert (found.values["stable_lowest_kind"], found.values["stable_lowest"]) == ("flip", flip)
    at_flip = cycle(
        "pin-on-disc", start={"phi_dot": 5.0}, t_max=3.0, transient=2.0, Omega=flip, multiplicity=1
    )
    assert flip == pytest.approx(1.90190, abs=2e-5)
    assert at_flip.status == "ok"


@pytest.mark.parametrize("bracket", [(0.5, 20.0), (0.5, 16.0), (0.5, 12.0), (2.0, 6.0)])
def test_the_end_of_a_branch_is_one_whatever_its_bracket(bracket: tuple[float, float]) -> None:
    """Another stable cycle lies 0.03 rad beside it, on to 9.66 rad/s: a long step must not land
    there. At its end, a grazing, no multiplier is near 1 and its direction has no limit."""
    named = {"phi": 0.073874, "theta": -0.044935, "phi_dot": 2.5, "theta_dot": 5.23226}
    found = cycle(
        "pin-on-disc", start=named, branch=("Omega", *bracket), Omega=2.5, N0=30.0, c1=2e-3, c2=2e-3
    )
    assert found.values["cycle_highest_kind"] == "grazing"
    assert abs(found.values["cycle_highest"] - 3.63957643) <= found.values["cycle_highest_error"]


@pytest.mark.parametrize("width", [1e-5, 1e-6, 1e-7])
def test_the_end_of_a_branch_that_runs_along_a_grazing_lies_within_its_error(width: float) -> None:
    """Beside it the motion bends within ever less of the parameter, and the cycle foreseen lies
    beyond it: what steps fail there say nothing of the cycles that follow. The inverse of the
    multiplier goes there along a straight line, which is zero at 0.1924985 rad/s."""
    changes = {"Omega": 2.0, "N0": 25.0}
    branch = ("Omega", 0.1, 15.0)
    found = cycle("pin-on-disc", start={"phi_dot": 2.0}, branch=branch, width=width, **changes)
    assert found.values["cycle_lowest_kind"] == "grazing"
    error = found.values["cycle_lowest_error"]
    assert abs(found.values["cycle_lowest"] - 0.1924985) <= error <= max(4.0 * 14.9 * width, 1e-5)
    near = found.ragged["branch_value"] < 0.1930
    values, inverses = (
        found.ragged["branch_value"][near],
        1 / found.ragged["branch_multiplier"][near],
    )
    slope, at_zero = np.polyfit(values, inverses, 1)
    assert -at_zero / slope == pytest.approx(0.1924985, abs=1e-6)


@pytest.mark.parametrize("width", [1e-9, 1e-11])
def test_a_branch_does_not_step_aside_where_its_multiplier_grows_without_bound(
    width: float,
) -> None:
    """A cycle of multiplier 1.47 lies beside one of 34,716, and turns: no end of its branch."""
    changes = {"Omega": 2.0, "N0": 28.0, "solver": SolverSettings(rtol=1e-11)}
    branch = ("Omega", 0.1, 20.0)
    found = cycle("pin-on-disc", start={"phi_dot": 2.0}, branch=branch, width=width, **changes)
    assert found.values["cycle_lowest_kind"] == "grazing"
    assert abs(found.values["cycle_lowest"] - 0.215275) <= found.values["cycle_lowest_error"] < 1e-4
    assert found.ragged["branch_multiplier"][np.argmin(found.ragged["branch_value"])] > 1e3


@pytest.mark.campaign
@pytest.mark.parametrize("seed", range(40))
def test_ends_agree_within_their_errors_whatever_the_bracket_and_the_width(seed: int) -> None:
    random = np.random.default_rng(seed)
    changes = {"Omega": random.uniform(2.0, 9.0), "N0": random.uniform(15.0, 60.0)}
    changes["c1"] = 10.0 ** random.uniform(-3.2, -2.3)
    name, (low, high) = [("Omega", (0.1, 20.0)), ("N0", (2.0, 110.0))][seed % 2]
    begun, found = changes[name], []
    for share, width in ((1.0, 1e-6), (1.0, 1e-7), (1.0, 1e-8), (0.5, 1e-7)):
        bracket = name, begun - share * (begun - low), begun + share * (high - begun)
        start = {"phi_dot": changes["Omega"]}
        found.append(cycle("pin-on-disc", start=start, branch=bracket, width=width, **changes))
    for end in ("cycle_lowest", "cycle_highest"):
        met = [one.values for one in found if one.values.get(f"{end}_kind", "bracket") != "bracket"]
        for one, other in combinations(met, 2):
            errors = one[f"{end}_error"] + other[f"{end}_error"]
            assert not abs(one[end] - other[end]) > errors  # an error may be unknown: NaN


def landing_slope(model: str, carried: Any, changes: dict[str, float]) -> float:
    """Rate of the first velocity just before a cycle's landing; the drive has none."""
    solver, parameters = SolverSettings(rtol=1e-12), defaults(model, "coulomb", **changes)
    problem = Problem(system(model), parameters, solver, Section("event"))
    anchor = Anchor(np.array(carried["state"]), tuple(map(bool, carried["sticking"])))
    around = passage(problem, anchor, carried["period"], tangents=False)
    landing = next(n for n, event in enumerate(around.events) if event[1] == CODE_STICK)
    before = begin(problem, anchor)
    before.run(before.time + around.times[landing] - 1e-9)
    return float(before.rates()[len(before.y) // 2])


def test_a_branch_ends_where_an_earlier_landing_takes_the_place_of_a_later_one() -> None:
    """The sequence of events stays. What lands at a grazing lands with a slope of its slip velocity
    that vanishes like the square root of the distance from it; another landing keeps its own."""
    base = {"Omega": 3.55, "N0": 26.3, "c1": 0.0022}
    start, branch = {"phi_dot": 3.8}, ("k1", 500.0, 3000.0)
    found = cycle("pin-on-disc", start=start, branch=branch, transient=2.0, t_max=5.0, **base)
    assert found.values["cycle_lowest_kind"] == "grazing"
    assert found.carry is not None
    follows = Start("followed", "continue", {}, found.carry)
    sizes = []
    for distance in (4.0, 1.0, 0.25):
        changes = base | {"k1": found.values["cycle_lowest"] + distance}
        beside = cycle("pin-on-disc", start=follows, **changes)
        assert beside.values["n_events"] == 2
        sizes.append(landing_slope("pin-on-disc", beside.carry, changes))
    assert sizes[0] / sizes[1] == pytest.approx(2.0, rel=0.1)
    assert sizes[1] / sizes[2] == pytest.approx(2.0, rel=0.1)


def test_a_motion_that_changes_smoothly_does_not_jump() -> None:
    """However far its ends lie apart; nor where the way is too short to tell."""
    line = Continuation(coulomb_belt(), Varied("v"), (0.5, 2.0), 1e-6)
    found = close(line.problem, Anchor(np.array([2.3, -1.97]), (False,)), 7.6, np.ones(2))
    assert found is not None
    here = first_point(line, found, 1.0, True)
    assert here is not None
    for length, apart in ((1e-2, True), (1e-5, False)):
        there = here.unknowns + length * here.tangent
        ends = [_over_period(line, here, unknowns).state for unknowns in (here.unknowns, there)]
        assert _are_apart(here, *ends) == apart
        assert not _jumps(line, here, there)


@pytest.mark.parametrize("away", [1e-3, 1e-2])
def test_an_unstable_cycle_that_a_start_comes_by_is_found_however_long_one_waits(
    away: float,
) -> None:
    """From beside it the motion comes to rest, or to the stable one, within a few periods."""
    exact = cycle(law="stribeck", start={"x": 3.55}, section=TURNING, t_max=14.0, c=0.65).values
    assert exact["stable"] == "unstable"
    begin = {"x": float(exact["x_max"]) - away}
    beside = cycle(law="stribeck", start=begin, section=TURNING, t_max=500.0, c=0.65).values
    assert beside["cycle_period"] == pytest.approx(exact["cycle_period"], rel=1e-10)
    assert beside["stable"] == "unstable"


# --- what cannot be found ------------------------------------------------------------------------
@pytest.mark.parametrize(
    ("changes", "reason"),
    [
        ({"start": {"x": 2.3, "x_dot": 0.5}}, "no_return"),  # slides, and never sticks
        ({"start": {"x": 9.0}, "t_max": 5.0}, "no_return"),  # one landing only
        ({"law": "stribeck", "c": 1.0, "section": TURNING}, "no_cycle"),  # comes to rest
        ({"branch": ("v", 2.0, 4.0)}, "outside_bracket"),
        ({"section": Section("zero", state="x_dot"), "mu_s": 0.0, "mu_k": 0.0, "k": 1e-9,
          "t_max": 1.0}, "no_return"),
    ],
)  # fmt: skip
def test_why_there_is_no_cycle(changes: dict[str, Any], reason: str) -> None:
    found = cycle(**changes)
    assert (found.status, found.reason) == ("ok", reason)


def test_the_window_of_a_forced_cycle() -> None:
    """The period-4 motion at omega = 1.2 is near the upper end of its window, a fold."""
    forced = {"u0": 0.5, "omega": 1.2, "t_max": 300.0}
    found = cycle(branch=("omega", 0.5, 2.0), **forced)
    (_, low), (turn, high), _ = ends(found)
    assert turn == "fold"
    assert low < 1.2 < high
    value, stable = found.ragged["branch_value"], np.array(found.ragged["branch_stable"])
    own = int(np.flatnonzero(value == 1.2)[0])
    assert np.all(np.diff(value[: own + 2]) > 0.0)  # both ways lead away from the first cycle
    assert np.all(stable[: own + 1] == "stable") and stable[-1] == "unstable"
    follows = Start("followed", "continue", {}, found.carry)
    for omega, there in ((low + 1e-4, True), (low - 1e-4, False), (high + 1e-4, False)):
        beside = cycle(start=follows, **{**forced, "omega": omega})
        assert ("cycle_period" in beside.values) == there
        assert beside.reason == ("" if there else "no_cycle")


def test_a_cycle_is_followed_from_neighbour_to_neighbour() -> None:
    """Along a grid: stable or not, the neighbour's cycle is the first guess; strides are halved."""
    first = cycle(law="stribeck", start={"x": 3.55}, section=TURNING, t_max=14.0, c=0.65)
    assert first.carry is not None
    follows = Start("followed", "continue", {}, first.carry)
    second = cycle(law="stribeck", start=follows, section=TURNING, c=0.66)
    assert second.values["stable"] == "unstable"
    assert second.values["x_max"] > first.values["x_max"]
    third = cycle(law="stribeck", start=follows, section=TURNING, c=0.703)
    assert third.values["stable"] == "unstable"
    assert third.values["x_dot_max"] == pytest.approx(1.0, abs=0.02)  # nearly sticks
    lost = cycle(law="stribeck", start=follows, section=TURNING, c=0.8)
    assert (lost.reason, lost.carry) == ("no_cycle", None)


# --- parts ---------------------------------------------------------------------------------------
def root_of(conditions: Any, start: Any, *known: Any, **reach: float) -> Any:
    """What Newton's method finds of conditions that give values and a derivative; None: nothing."""

    def equations(u: Any) -> Equations:
        values, derivative = conditions(u)
        return Equations(values, derivative, None)  # type: ignore[arg-type]

    found = newton(equations, np.array(start), *known, **reach)
    return None if found is None else found[0]


def test_newton_finds_a_root_or_says_so() -> None:
    def circle_and_line(u: Any) -> Any:
        values = np.array([u @ u - 2.0, u[0] - u[1]])
        return values, lambda: np.array([2 * u, [1.0, -1.0]])

    np.testing.assert_allclose(root_of(circle_and_line, [3.0, 0.5]), [1.0, 1.0], atol=1e-9)
    assert root_of(circle_and_line, [3.0, 0.5], reach=1.0) is None

    def nothing(u: Any) -> Any:
        return np.array([u @ u + 1.0]), lambda: 2 * u[None, :]

    assert root_of(nothing, [3.0]) is None


def test_newton_asks_for_a_jacobian_only_where_a_step_is_taken_from() -> None:
    """Of the trials of a step those that make it worse are refused by their values alone."""
    tried, taken = [], []

    def bent(u: Any) -> Any:
        def jacobian() -> Any:
            taken.append(u[0])
            return np.array([[10.0 / (1.0 + (10.0 * u[0]) ** 2)]])

        tried.append(u[0])
        return np.arctan(10.0 * u), jacobian

    np.testing.assert_allclose(root_of(bent, [0.19]), 0.0, atol=1e-9)
    assert len(taken) < len(tried)
    assert np.all(np.diff(np.abs(taken)) < 0.0)


def test_newton_with_a_derivative_from_nearby_takes_none_of_its_own() -> None:
    """... where that one does; from afar it does."""
    derived = []

    def circle_and_line(u: Any) -> Any:
        def jacobian() -> Any:
            derived.append(u)
            return np.array([2 * u, [1.0, -1.0]])

        return np.array([u @ u - 2.0, u[0] - u[1]]), jacobian

    nearby, start = np.linalg.inv([[2.4, 1.8], [1.0, -1.0]]), [1.1, 0.95]
    np.testing.assert_allclose(root_of(circle_and_line, start, nearby), [1.0, 1.0], atol=1e-9)
    assert not derived
    np.testing.assert_allclose(root_of(circle_and_line, start, -nearby), [1.0, 1.0], atol=1e-9)
    assert derived


def test_near_returns_are_ranked_by_their_distance() -> None:
    """A spiral out of an unstable period two: its own returns come first, early ones; at last come
    the first returns from where the motion began."""
    times = np.arange(20.0)
    side = np.where(np.arange(20) % 2 == 0, 1.0, -1.0)
    points = (side * (1.0 + 1e-3 * 1.5 ** np.arange(20)))[:, None]
    passed = Returns(times, points, Stop.REACHED)
    found = near_returns(coulomb_belt(), passed, None, begun=-0.5)
    assert found[0] == (0.0, 2.0)
    assert found[-8:] == [(-0.5, m - 0.5) for m in range(1, 9)]
    assert near_returns(coulomb_belt(), passed, 3, begun=-0.5)[0][1] >= 3.0


@pytest.mark.parametrize("offset", [(0.40, 0.30), (0.41, 0.31), (0.42, 0.31)])
def test_a_start_beside_a_cycle_that_repels_leads_to_it(offset: tuple[float, float]) -> None:
    """The motion is away before its first return; period and amplitude are those that shooting
    with an integrator of its own finds (SciPy, DOP853, events)."""
    start = Start("beside", "equilibrium", dict(zip(("x", "y"), offset, strict=True)))
    settings = {"section": Section("zero", state="x_dot", direction="down"), "t_max": 15.0}
    parameters = {"k1": 2.0, "k2": 1.0, "k3": 2.0, "c1": 0.1, "c2": 0.1, "mu_k": 0.7}
    options = {"states": "all"}
    found = api.analyse(
        "flutter-2dof", "coulomb", "cycle", start, settings, options=options, **parameters
    )
    assert found.values["stable"] == "unstable"
    assert found.values["cycle_period"] == pytest.approx(4.0727254075, abs=2e-9)
    assert found.values["x_max"] == pytest.approx(0.50924445, abs=1e-8)


CASE = """
schema = 1
title = "branch"
[model]
name = "belt-1dof"
[[analysis]]
kind = "cycle"
"""


@pytest.mark.parametrize(("line", "missing"), [("parameter = 'v'", "bracket"),
                                               ("bracket = [1, 2]", "parameter")])  # fmt: skip
def test_a_parameter_and_its_bracket_belong_together(line: str, missing: str) -> None:
    with pytest.raises(CaseError, match=f"analysis.0.{missing}: is missing"):
        parse_case(CASE + line + "\n", "case.toml")


def test_the_half_turn_of_the_closed_form() -> None:
    """`speed_that_misses` itself: without damping the landing is never missed."""
    assert speed_that_misses(0.1) == pytest.approx(1.866757460950, abs=1e-9)
    x, v = 1.7, 1.0
    assert x * cos(0.0) + v * sin(0.0) == x


def return_above_the_belt(v: float, c: float) -> float:
    """How far above the belt's speed v the mass comes that has let go at it: by SciPy, m/s."""
    force = lambda slip: 10.0 * (0.25 + 0.15 * np.exp(-abs(slip)))  # noqa: E731
    rates = lambda t, y: [y[1], force(v - y[1]) - c * y[1] - y[0]]  # noqa: E731
    greatest = lambda t, y: rates(t, y)[1]  # noqa: E731
    greatest.direction = -1  # type: ignore[attr-defined]
    exact = {"method": "DOP853", "rtol": 1e-13, "atol": 1e-13}
    gone = solve_ivp(rates, (0.0, 3.0), [4.0 - c * v, v], **exact).y[:, -1]
    found = solve_ivp(rates, (3.0, 9.0), gone, events=greatest, **exact)
    return float(found.y_events[0][0][1] - v)


@pytest.mark.parametrize("speed", [0.4, 0.4955])
def test_a_branch_is_followed_through_a_canard_explosion(speed: float) -> None:
    """The cycle grows by a half while the speed falls by 1e-6, and forgets its start on the way: no
    multiplier is near 1, and there is no fold. Its end is a grazing, SciPy's to 1e-11."""
    asked = {"parameter": "v", "bracket": [0.35, 0.6], "t_max": 1000.0, "observe": "x"}
    asked["section"] = Section("zero", state="x_dot")
    start = {"x": 2.6 if speed > 0.45 else 0.0}
    found = api.analyse("belt-1dof", "cubic", "cycle", start, asked, c=0.05, v=speed)
    ends = zip(*(found.ragged[f"cycle_end{of}"] for of in ("_kind", "", "_error")), strict=True)
    told = {kind: (value, error) for kind, value, error in ends}
    assert len(told) == len(found.ragged["cycle_end"])
    # where friction falls as fast as the damper damps: 1.5 N (mu_s - mu_m) / v_m (1 - (v / v_m)^2)
    hopf = 0.5 * np.sqrt(1.0 - 0.05 / (1.5 * 10.0 * (0.4 - 0.25) / 0.5))
    for kind, value in (("grazing", 0.49394433767987), ("equilibrium", hopf)):
        assert abs(told[kind][0] - value) <= told[kind][1] <= 3e-7
    others = {"bracket"} if speed < 0.45 else set()  # from stick-slip it goes on behind the grazing
    assert {*told} == {"grazing", "equilibrium"} | others


def test_an_end_of_which_nothing_says_why_has_no_error() -> None:
    """In a narrow bracket, so close to the end of a canard that rounding opens all cycles."""
    asked = {"parameter": "v", "bracket": [0.49394, 0.49396], "t_max": 1000.0, "observe": "x"}
    asked["section"] = Section("zero", state="x_dot")
    found = api.analyse("belt-1dof", "cubic", "cycle", {"x": 2.6}, asked, c=0.05, v=0.493955)
    kinds = found.ragged["cycle_end_kind"]
    assert list(kinds) == ["other", "bracket"] and found.ragged["cycle_end"][1] == 0.49396
    assert np.isnan(found.ragged["cycle_end_error"][0])


@pytest.mark.parametrize(("c", "near"), [(0.03, 11.4), (0.05, 8.02), (0.1, 4.92)])
@pytest.mark.parametrize("width", [1e-6, 1e-8, 1e-10])
def test_stick_slip_under_a_falling_law_ends_within_the_error(
    c: float, near: float, width: float
) -> None:
    """Its last cycles have next to no stick: one that does not close to it is none, and that which
    begins there, without any, is unstable."""
    end = brentq(lambda v: return_above_the_belt(v, c), near - 0.1, near + 0.1, xtol=1e-13)
    asked = {"parameter": "v", "bracket": [0.25, 14.0], "width": width, "t_max": 1000.0}
    asked |= {"section": {"zero": "x_dot", "direction": "down"}, "observe": "x"}
    table = {"schema": 1, "model": {"name": "belt-1dof", "parameters": {"c": c}}}
    table["friction"] = {"law": "stribeck", "mu_s": 0.4, "mu_k": 0.25}
    start = {"label": "rest", "kind": "state"}
    found = api.run(
        api.load(table | {"initial": [start], "analysis": [{"kind": "cycle", **asked}]}), workers=1
    )
    for name in ("cycle_highest", "stable_highest"):
        told, error = (found[name + of].item() for of in ("", "_error"))
        assert abs(told - end) <= error <= max(2.0 * width * 13.75, 2e-8)


@pytest.mark.parametrize("width", [1e-7, 1e-8, 1e-9])
def test_the_end_of_stick_slip_is_one_however_closely_it_is_bisected(width: float) -> None:
    """So close to the grazing that its two sides are not told apart it is met several times."""
    law = {"mu_s": 0.4, "mu_k": 0.2, "v_s": 0.5, "delta": 1.0}
    found = analyse(
        "belt-1dof", "stribeck", "cycle", Start("slip", "state", named={"x_dot": "v"}),
        {"parameter": Varied("v"), "bracket": (0.3, 1.3), "width": width},
        m=1.0, k=100.0, c=1.0, N=10.0, v=0.5, **law,
    )  # fmt: skip
    ends = [found.ragged[f"cycle_end{name}"] for name in ("_kind", "", "_error")]
    (grazing,) = [
        (value, error) for kind, value, error in zip(*ends, strict=True) if kind == "grazing"
    ]
    # by SciPy's DOP853 from the release, at 1e-13
    assert abs(grazing[0] - 0.87243760397) <= grazing[1] <= 1e-7


@pytest.mark.parametrize("x", [3.425, 3.43, 3.435, 3.437])
def test_a_branch_of_unstable_slip_turns_into_stick_slip_from_whichever_start(x: float) -> None:
    """At the grazing the direction of the branch has no limit; what lies along it tells nothing."""
    law = {"mu_s": 0.4, "mu_k": 0.2, "alpha": 3.0}
    found = analyse(
        "belt-1dof", "exponential", "cycle", {"x": x},
        {"parameter": Varied("v"), "bracket": (0.7, 1.6), "width": 1e-8, "t_max": 20.0},
        m=1.0, k=1.0, c=0.5, N=10.0, v=1.1, **law,
    )  # fmt: skip
    kinds, ends, errors = (found.ragged[f"cycle_end{of}"] for of in ("_kind", "", "_error"))
    assert sorted(kinds) == ["bracket", "equilibrium", "grazing"]
    assert found.values["cycle_lowest"] == 0.7
    # where 3 N (mu_s - mu_k) exp(-3 v) = c; by DOP853 from the release, at 1e-13
    order = np.argsort(ends)
    assert abs(ends[order[1]] - np.log(12.0) / 3.0) <= errors[order[1]] <= 1e-6
    assert abs(ends[order[2]] - 1.305958392473) <= errors[order[2]] <= 1e-6


@pytest.mark.parametrize("mu_k", [4.0, 4.2, 4.22, 4.225])
def test_a_motion_that_dies_away_is_no_cycle(mu_k: float) -> None:
    """Below flutter sliding decays; what is left after a thousand seconds is 1e-7 of the offset."""
    start = Start("near", "equilibrium", {"x": 0.1})
    asked = {"section": Section("zero", state="x_dot"), "t_max": 1000.0}
    found = analyse(
        "flutter-2dof", "coulomb", "cycle", start, asked, c1=0.1, c2=0.1, mu_k=mu_k
    )  # fmt: skip
    assert (found.reason, found.values.get("stable")) == ("no_cycle", None)


def cycle_case(
    model: dict[str, Any], friction: dict[str, Any], state: dict[str, str], **analysis: Any
) -> Any:
    """The cycle that a case reaches from a state, watched where x turns."""
    section = {"zero": "x_dot", "direction": "both"}
    return api.run(
        api.load(
            {"schema": 1, "model": model, "friction": friction}
            | {"initial": [{"kind": "state", "state": state}]}
            | {"analysis": [{"kind": "cycle", "section": section, "observe": "x"} | analysis]}
        ),
        workers=1,
    )


@pytest.mark.parametrize("c", [6.0, 10.0])
@pytest.mark.parametrize("width", [1e-8, 1e-11, 1e-13])
def test_a_cycle_shrinks_to_rest_within_the_error(c: float, width: float) -> None:
    """Where the law falls as fast as the damping rises: as the last digits of tiny cycles tell."""
    belt = {"m": 5.0, "k": 2000.0, "c": c, "N": 50.0, "v": 0.3}
    law = {"law": "stribeck", "mu_s": 0.5, "mu_k": 0.3, "v_s": 0.1}
    model = {"name": "belt-1dof", "parameters": belt}
    found = cycle_case(model, law, {"x_dot": "v"}, parameter="v", bracket=[0.1, 0.6], width=width)
    assert api.names_of(found["cycle_end_kind"]).values[-1] == "equilibrium"
    told, error = (found[f"cycle_end{of}"].values[-1] for of in ("", "_error"))
    assert abs(told - 0.1 * log(100.0 / c)) <= error <= max(width, 1e-9)


@pytest.mark.parametrize("width", [1e-6, 1e-9])
def test_a_branch_that_rounding_opens_on_its_way_to_rest_ends_at_the_hopf_point(
    width: float,
) -> None:
    """Where eigenvalues cross, though the last cycle found lies 5e-6 beside: no fold."""
    model = {"name": "flutter-2dof", "parameters": {"c1": 0.05, "c2": 0.2}}
    model["options"] = {"states": "all"}
    law = {"law": "stribeck", "mu_s": 2.5, "mu_k": 1.2, "v_s": 0.2}
    asked = {"parameter": "mu_k", "bracket": [0.82, 2.5]}
    found = cycle_case(model, law, {"x_dot": "v"}, **asked, t_max=500.0, width=width)
    critical = {"schema": 1, "model": model, "friction": law}
    critical |= {"analysis": [{"kind": "critical", **asked}]}
    (hopf,) = api.run(api.load(critical), workers=1)["critical_value"].values
    assert api.names_of(found["cycle_end_kind"]).values[-1] == "equilibrium"
    told, error = (found[f"cycle_end{of}"].values[-1] for of in ("", "_error"))
    assert abs(told - hopf) <= error <= 1e-8


def test_a_grazing_says_which_event_of_which_contact_enters_or_leaves() -> None:
    """Of two coupled masses the one without a load never sticks; it overtakes the belt below the
    speed at which it would be as fast, which cycles beside it show."""

    def cycles(**settings: Any) -> Any:
        loaded = {"name": "belt-2mass", "parameters": {"N": 0.0, "N2": 20.0}}
        start = {"kind": "equilibrium", "offset": {"x2": 3.0}}
        case = {"schema": 1, "model": loaded, "friction": {"law": "stribeck"}, "initial": [start]}
        return api.run(api.load(case | settings), workers=1)

    asked = {"kind": "cycle", "observe": "x2"}
    found = cycles(analysis=[asked | {"parameter": "v", "bracket": [0.5, 4.0]}])
    kinds, events = (api.names_of(found[f"cycle_end_{of}"]).values for of in ("kind", "event"))
    assert kinds.tolist() == ["bracket", "grazing", "bracket"]
    assert events.tolist() == ["not_computed", "slip_reversal", "not_computed"]
    assert found["cycle_end_contact"].values.tolist() == [0, 1, 0]
    at = found["cycle_end"].values[1]
    beside = cycles(analysis=[asked], grid={"v": [at - 0.01, at + 0.01]})
    faster = beside["x1_dot_max"].values.ravel() > beside["v"].values
    assert faster.tolist() == [True, False]


def test_cycles_of_all_sizes_at_one_parameter_lead_to_rest() -> None:
    """Flutter that only slips is linear: at the critical friction it is neutral up to a grazing."""
    model = {"name": "flutter-2dof", "parameters": {"c1": 0.1, "c2": 0.1}}
    model |= {"options": {"states": "all"}}
    asked = {"parameter": "mu_k", "bracket": [3.0, 8.8], "transient": 500.0, "t_max": 600.0}
    found = cycle_case(model, {"law": "coulomb", "mu_k": 5.0}, {}, **asked)
    kinds = api.names_of(found["cycle_end_kind"]).values.tolist()
    assert kinds == ["equilibrium", "grazing", "fold", "fold", "bracket"]
    assert api.names_of(found["cycle_end_event"]).values[1] == "stick"
    told, error = (found[f"cycle_end{of}"].values[0] for of in ("", "_error"))
    assert abs(told - 4.38133283987163) <= error <= 1e-10  # of the eigenvalues, in 40 digits
    size = (found["branch_max"] - found["branch_min"]).values
    assert size[0] < 0.01 * size.max()
