"""flutter-2dof and excited-2dof: sliding in closed form, loss of contact, landings, tanh."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
import pytest
from lumped_reference import excited_matrices, flutter_matrices, sliding_motion
from motions import TIGHT, booked, defaults, motion, times, transitions
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

from fiv_cli.analyses.base import SolverSettings
from fiv_cli.analyses.common import balance
from fiv_cli.api import analyse
from fiv_cli.codegen.codes import CODE_SEPARATION, CODE_SLIP_PLUS
from fiv_cli.dynamics.motion import Stop, samples_at

MATRICES = {"flutter-2dof": flutter_matrices, "excited-2dof": excited_matrices}
STATES = ("x", "y", "x_dot", "y_dot")
BILATERAL, ALL = {"states": "slip"}, {"states": "all"}
SPRING = {"states": "all", "impact": "none"}
# A start and parameters of each model; in all of them the mass only slides.
SLIDING: list[tuple[str, dict[str, float], dict[str, float]]] = [
    ("flutter-2dof", {"x": 0.1, "y": -0.3}, {}),
    ("flutter-2dof", {"x": 0.1, "y": -0.3, "y_dot": 0.2}, {"mu_k": 4.1, "c1": 0.1, "c2": 0.3}),
    ("flutter-2dof", {"y": -0.31}, {"mu_k": 4.6}),
    ("excited-2dof", {"x": 0.2, "y": -1.5}, {}),
    ("excited-2dof", {"x": 0.2, "y": -1.5}, {"A_b": 3.0, "R": 20.0, "mu_k": 0.7}),
    ("excited-2dof", {"y": -1.5, "x_dot": 0.1}, {"A_b": 1.0, "R": 5.0, "c1": 0.2, "c2": 0.5}),
]


def vector(start: Mapping[str, float]) -> np.ndarray[Any, Any]:
    """Start as (x, y, x', y')."""
    return np.array([start.get(name, 0.0) for name in STATES])


# --- sliding -------------------------------------------------------------------------------------
@pytest.mark.parametrize(("model", "start", "changes"), SLIDING)
def test_bilateral_sliding_is_a_matrix_exponential(
    model: str, start: dict[str, float], changes: dict[str, float]
) -> None:
    """States at 41 instants over 20 s; the harmonic force is part of the linear system."""
    begun = motion(model, "coulomb", start, TIGHT, BILATERAL, **changes)
    taken = samples_at(begun.system, np.linspace(0.0, 20.0, 41))
    assert begun.run(20.0, samples=taken) == Stop.REACHED
    assert begun.n_events == 0
    parameters = defaults(model, "coulomb", **changes)
    expected = sliding_motion(parameters, MATRICES[model](parameters), vector(start), taken.times)
    scale = np.max(np.abs(expected))
    np.testing.assert_allclose(taken.states, expected, atol=1e-10 * scale)


@pytest.mark.parametrize("model", MATRICES)
def test_bilateral_friction_keeps_its_sign_and_the_normal_force_may_pull(model: str) -> None:
    """Neither slip that reverses nor a contact that pulls is an event; mu F_N changes sign too."""
    start = {"y": 1.0, "x_dot": 2.5}
    begun = motion(model, "coulomb", start, TIGHT, BILATERAL)
    taken = samples_at(begun.system, np.linspace(0.0, 10.0, 101))
    begun.run(10.0, samples=taken)
    normal, friction, slip = taken.outputs[:, 0], taken.outputs[:, 1], taken.outputs[:, 2]
    assert begun.n_events == 0
    assert np.min(normal) < 0.0 < np.max(normal) and np.min(slip) < 0.0 < np.max(slip)
    mu_k = defaults(model, "coulomb")["mu_k"]
    np.testing.assert_allclose(friction, mu_k * normal, rtol=1e-14)


def test_bilateral_sliding_on_a_belt_that_runs_the_other_way() -> None:
    """The sign of friction is that of the drive at rest, not of the slip at the start."""
    start, changes = {"x": 0.1, "y": -0.3, "x_dot": -3.0}, {"v": -1.0}
    begun = motion("flutter-2dof", "coulomb", start, TIGHT, BILATERAL, **changes)
    begun.run(3.0)
    parameters = defaults("flutter-2dof", "coulomb", **changes)
    matrices = flutter_matrices(parameters)
    expected = sliding_motion(parameters, matrices, vector(start), np.array([3.0]), sign=-1.0)
    np.testing.assert_allclose(begun.y, expected[0], atol=1e-11)


# --- the end of contact --------------------------------------------------------------------------
@pytest.mark.parametrize(
    ("model", "start", "changes"),
    [
        ("flutter-2dof", {"x": 0.1, "y": -0.9}, {"v": 9.0}),
        ("flutter-2dof", {"y": -0.8}, {"mu_k": 4.6, "v": 30.0}),
        ("excited-2dof", {"y": -6.0}, {"v": 9.0}),
        ("excited-2dof", {"y": -6.0}, {"v": 9.0, "A_b": 3.0, "R": 5.0}),
    ],
)
def test_until_separation_ends_where_the_normal_force_vanishes(
    model: str, start: dict[str, float], changes: dict[str, float]
) -> None:
    """The first zero of y in the closed form, the belt being too fast to stick to."""
    parameters = defaults(model, "coulomb", **changes)
    matrices = MATRICES[model](parameters)

    def height(t: float) -> float:
        return float(sliding_motion(parameters, matrices, vector(start), np.array([t]))[0, 1])

    grid = np.linspace(0.0, 5.0, 51)
    heights = sliding_motion(parameters, matrices, vector(start), grid)[:, 1]
    first = int(np.argmax(heights > 0.0))
    lost = brentq(height, grid[first - 1], grid[first], xtol=1e-14, rtol=1e-14)
    begun = motion(model, "coulomb", start, TIGHT, None, **changes)
    assert begun.run(10.0) == Stop.CONTACT_LOST
    assert begun.n_events == 0
    assert begun.time == pytest.approx(lost, abs=1e-11)
    assert abs(begun.y[1]) < 1e-13


def test_a_start_out_of_contact_is_contact_lost() -> None:
    begun = motion("flutter-2dof", "coulomb", {"y": 0.1}, TIGHT, None)
    assert begun.run(1.0) == Stop.CONTACT_LOST


@pytest.mark.parametrize("model", MATRICES)
def test_all_states_go_on_through_separation_and_land_plastically(model: str) -> None:
    """The same instant of separation; then flight, and landings that end the gap rate."""
    start, changes = {"x": 0.1, "y": -6.0}, {"v": 1.0, "mu_k": 0.3}
    ends = motion(model, "coulomb", start, TIGHT, None, **changes)
    assert ends.run(60.0) == Stop.CONTACT_LOST
    begun = motion(model, "coulomb", start, TIGHT, ALL, **changes)
    found = booked(begun, 60.0)
    lifts = [t for t, w in zip(times(begun), transitions(begun), strict=True) if "->sep" in w]
    assert lifts[0] == pytest.approx(ends.time, abs=1e-12)
    assert begun.frame.n_impacts >= 1
    assert found.impact > 0.0
    assert found.residual < 1e-12


def test_a_landing_costs_the_energy_of_the_gap_rate() -> None:
    """Only y meets the belt: the loss is half the mass times y' squared, x keeps its speed."""
    start = {"x": 0.1, "y": 0.5, "x_dot": 0.3}
    flight = motion("flutter-2dof", "coulomb", start, TIGHT, ALL)
    assert flight.codes == [CODE_SEPARATION]
    flight.run(1.5)
    landing = times(flight)[0]
    begun = motion("flutter-2dof", "coulomb", start, TIGHT, ALL)
    begun.run(landing - 1e-9)
    fall, along = begun.y[3], begun.y[2]
    found = booked(begun, landing + 1e-9)
    assert fall < -0.1
    assert found.impact == pytest.approx(fall**2 / 2, rel=1e-7)
    assert begun.y[2] == pytest.approx(along, abs=1e-7)
    assert begun.codes == [CODE_SLIP_PLUS]


# --- a spring that only pushes -------------------------------------------------------------------
def pushed(model: str, p: Mapping[str, float]) -> Callable[[float, Any], np.ndarray[Any, Any]]:
    """One right-hand side for sliding, either way, and flight: for motions that never stick."""
    damping, stiffness = MATRICES[model](p)
    forced, springs = p.get("A_b", 0.0), stiffness - np.diag([0.0, p["k3"]])
    omega = p.get("R", 0.0) * np.sqrt(p["k1"] / p["m"])

    def rates(t: float, state: Any) -> np.ndarray[Any, Any]:
        q, velocities, normal = state[:2], state[2:], max(-p["k3"] * state[1], 0.0)
        friction = np.sign(p["v"] - velocities[0]) * p["mu_k"] * normal
        force = [friction + forced * np.sin(omega * t), normal - p["F"]]
        return np.append(velocities, (force - damping @ velocities - springs @ q) / p["m"])

    return rates


@pytest.mark.parametrize(
    ("model", "changes"),
    [("flutter-2dof", {"mu_k": 5.0, "c1": 0.1}), ("excited-2dof", {"A_b": 3.0, "R": 5.0})],
)
def test_without_an_impact_the_mass_moves_as_scipy_moves_it(
    model: str, changes: dict[str, float]
) -> None:
    """On a belt too fast to stick to; landings cost nothing."""
    start, changes = {"x": 0.1, "y": 2.0}, {"v": 99.0, **changes}
    begun = motion(model, "coulomb", start, TIGHT, SPRING, **changes)
    taken = samples_at(begun.system, np.linspace(0.0, 12.0, 61))
    begun.start_measuring(np.zeros(2))
    before = begun.energy()
    assert begun.run(12.0, samples=taken, measuring=True) == Stop.REACHED
    rates = pushed(model, defaults(model, "coulomb", **changes))
    expected = solve_ivp(rates, (0.0, 12.0), vector(start), "DOP853", taken.times,
                         rtol=1e-12, atol=1e-14, max_step=1e-2).y.T  # fmt: skip
    np.testing.assert_allclose(taken.states, expected, rtol=0.0, atol=1e-9)
    assert {*transitions(begun)} == {"slip+->separation", "separation->slip+"}
    found = balance(begun, before)
    assert found.impact == 0.0 and abs(found.residual) < 1e-12


def test_flutter_with_flights_is_that_of_the_spring() -> None:
    """Plastic impacts take most of what the belt gives; on a spring SciPy finds the same cycle."""
    start, changes = {"y": -4.0}, {"mu_k": 0.6}
    asked = "excited-2dof", "coulomb", "response", start, {"powers": "each"}
    plastic, found = (analyse(*asked, options=o, **changes).values for o in (ALL, SPRING))
    assert plastic["impact_work"] > plastic["drive_work"] / 2
    assert found["impact_work"] == found["stick_fraction"] == 0.0
    assert found["friction_work"] == pytest.approx(-found["damping_work"], abs=1e-9)

    def height(t: float, state: Any) -> float:
        return float(state[1])

    settled = motion("excited-2dof", "coulomb", start, TIGHT, SPRING, **changes)
    settled.run(2000.0)
    p, period = defaults("excited-2dof", "coulomb", **changes), found["period"]
    cycle = solve_ivp(pushed("excited-2dof", p), (0.0, period), settled.y, "DOP853",
                      np.linspace(0.0, period, 1001), events=height,
                      rtol=1e-12, atol=1e-14, max_step=1e-2)  # fmt: skip
    np.testing.assert_allclose(cycle.y[:, -1], settled.y, rtol=0.0, atol=1e-8)
    between = np.diff(cycle.t_events[0])[0] / period
    aloft = between if cycle.y_events[0][0][3] > 0.0 else 1.0 - between
    assert found["separation_fraction"] == pytest.approx(aloft, rel=1e-9)
    stiffness = excited_matrices(p)[1] + [[0.0, p["mu_k"] * p["k3"]], [0.0, 0.0]]
    rest = np.linalg.solve(stiffness, [0.0, -p["F"]])
    away = np.sum((cycle.y[:2, :-1].T - rest) ** 2, axis=1)
    assert found["L_s"] == pytest.approx(np.mean(away), rel=1e-6)
    assert found["y_max"] == pytest.approx(np.max(cycle.y[1]), rel=1e-4)


# --- integrators and laws ------------------------------------------------------------------------
@pytest.mark.parametrize(
    ("model", "changes"),
    [
        ("flutter-2dof", {"F": 4.0, "mu_k": 0.2, "mu_s": 0.5}),
        ("excited-2dof", {"mu_k": 0.3, "mu_s": 0.5}),
        ("excited-2dof", {"A_b": 2.0, "R": 5.0}),
    ],
)
def test_two_integrators_agree_through_every_state(model: str, changes: dict[str, float]) -> None:
    start = {"x": 0.5, "y": -4.0}
    solvers = (TIGHT, SolverSettings("rk4", TIGHT.rtol, 1e-3))
    exact, rough = (motion(model, "coulomb", start, s, ALL, **changes) for s in solvers)
    assert booked(exact, 25.0).residual < 1e-12
    assert rough.run(25.0) == Stop.REACHED
    found = transitions(exact)
    assert found == transitions(rough)
    assert any("separation" in word for word in found)
    assert any("->stick" in word or "->slip-" in word for word in found)
    np.testing.assert_allclose(times(exact), times(rough), atol=1e-8)


def test_the_regularised_law_converges_to_the_discontinuous_one() -> None:
    """tanh(sigma v): through reversals of slip the error falls as 1/sigma."""
    start, changes = {"x": 0.2, "y": -1.5}, {"A_b": 12.0, "R": 5.0, "mu_k": 0.4}
    exact = motion("excited-2dof", "coulomb", start, TIGHT, None, **changes)
    assert exact.run(4.0) == Stop.REACHED
    assert sum("slip+->slip-" in w or "slip-->slip+" in w for w in transitions(exact)) >= 4
    errors = []
    for sigma in (1e3, 1e4, 1e5):
        smooth = motion("excited-2dof", "tanh of coulomb", start, SolverSettings(rtol=1e-12), None,
                        sigma=sigma, **changes)  # fmt: skip
        assert smooth.run(4.0) == Stop.REACHED
        errors.append(float(np.max(np.abs(smooth.y - exact.y))))
    assert errors[2] < 1e-6
    assert errors[0] / errors[1] == pytest.approx(10.0, rel=0.1)
    assert errors[1] / errors[2] == pytest.approx(10.0, rel=0.01)
