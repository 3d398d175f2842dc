"""What is integrated along a motion, against closed forms, and the rules that integrate it."""

from __future__ import annotations

from math import cos, pi, sin

import numpy as np
import pytest
from motions import motion

from fiv_cli.analyses.base import SolverSettings
from fiv_cli.dynamics.arrays import lobatto, lobatto_reach, quadratures, work_rule

REST = 2.3  # where friction holds the sliding mass on the belt
SWING = 0.7  # amplitude of an undamped motion that is slower than the belt: it never sticks


@pytest.mark.parametrize("span", [0.01, 1.0, 5.0, 100.0])
@pytest.mark.parametrize("rtol", [1e-5, 1e-9, 1e-13])
def test_measures_of_undamped_sliding(rtol: float, span: float) -> None:
    """x = REST + SWING sin t, begun where neither x nor its rate is at an extreme."""
    start = {"x": REST + SWING * sin(0.3), "x_dot": SWING * cos(0.3)}
    begun = motion("belt-1dof", start=start, solver=SolverSettings(rtol=rtol))
    begun.start_measuring(np.array([REST]))
    begun.run(span, measuring=True)
    squares = SWING**2 * (span / 2 - (sin(2 * (0.3 + span)) - sin(0.6)) / 4)
    phases = np.array([0.3, 0.3 + span, *np.arange(0.0, 101.0, pi / 2)])
    phases = phases[(phases >= 0.3) & (phases <= 0.3 + span)]
    extremes = begun.extremes
    allowed = max(1e-13, 10.0 * rtol)  # that of the motion itself
    assert begun.measures.spread == pytest.approx(squares, rel=allowed)
    turns = REST + SWING * np.sin(phases), SWING * np.cos(phases)
    np.testing.assert_allclose(extremes[0], [turn.min() for turn in turns], rtol=allowed)
    np.testing.assert_allclose(extremes[1], [turn.max() for turn in turns], rtol=allowed)


def test_extremes_and_squares_of_a_tight_motion_are_right_to_rounding() -> None:
    """A tenth of the tolerance of the motion: quadrature and turning points add no error."""
    begun = motion("belt-1dof", start={"x": REST, "x_dot": SWING})
    begun.start_measuring(np.array([REST]))
    begun.run(2 * pi, measuring=True)
    expected = [[REST - SWING, -SWING], [REST + SWING, SWING]]
    np.testing.assert_allclose(begun.extremes, expected, rtol=1e-14)
    squares = [2 * pi * REST**2 + pi * SWING**2, pi * SWING**2]
    np.testing.assert_allclose(begun.measures.squares, squares, rtol=1e-14)


@pytest.mark.parametrize("model", ["belt-1dof", "belt-5dof"])
def test_energies_measured_alone_are_those_measured_with_all(model: str) -> None:
    """By another rule, at other nodes."""

    def measured(reference: np.ndarray | None) -> list[float]:
        begun = motion(model, start={"x": 3.0})
        begun.start_measuring(reference)
        begun.run(20.0, measuring=True)
        found = begun.measures
        works = found.other_work, found.friction_work, found.drive_work, found.impact_loss
        return [*works, found.measured_time, *found.works, *found.shares.ravel()]

    everything = measured(np.zeros(len(motion(model).system.coordinates)))
    assert measured(None) == pytest.approx(everything, rel=1e-12)
    assert any(everything)


@pytest.mark.parametrize("count", range(2, 15))
def test_a_rule_is_exact_up_to_its_degree_and_no_further(count: int) -> None:
    nodes, weights = lobatto(count)
    assert (nodes[0], nodes[-1]) == (0.0, 1.0)
    for power in range(2 * count - 2):
        assert weights @ nodes**power == pytest.approx(1.0 / (power + 1), abs=4e-16)
    if count < 12:  # beyond, what is missed is below rounding
        assert abs(weights @ nodes ** (2 * count - 2) - 1.0 / (2 * count - 1)) > 1e-15


@pytest.mark.parametrize("count", range(2, 12))
def test_a_rule_integrates_an_oscillation_to_rounding_as_far_as_it_reaches(count: int) -> None:
    nodes, weights = lobatto(count)
    phase = lobatto_reach(count)
    exact = sin(phase) / phase
    assert weights @ np.cos(phase * nodes) == pytest.approx(exact, abs=4e-16)
    assert abs(weights @ np.cos(10 * phase * nodes) - sin(10 * phase) / (10 * phase)) > 1e-15


@pytest.mark.parametrize("order", [14, 16, 24])
def test_longer_parts_of_a_step_take_more_nodes_and_any_part_has_a_rule(order: int) -> None:
    rules = quadratures(order, 1e-9)
    most = order // 2 + 2
    assert len(rules) == most * (most + 1) // 2
    shares = [rules[count * (count - 1) // 2, 2] for count in range(2, most + 1)]
    assert np.all(np.diff(shares) > 0.0)
    assert shares[-1] == np.inf


@pytest.mark.parametrize("order", range(4, 40))
def test_the_rule_of_works_is_exact_for_series_of_its_order(order: int) -> None:
    nodes, weights = work_rule(order)
    for power in range(order + 1):
        assert weights @ nodes**power == pytest.approx(1.0 / (power + 1), abs=1e-15)
