"""Section sets that stay, and section sets that move."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from fiv_cli.analyses.attractor.stationarity import FEWEST, drift


def column(values: np.ndarray) -> np.ndarray:
    return np.asarray(values, float)[:, None]


@given(turn=st.floats(0.08, 3.1), phase=st.floats(0.0, 6.3), count=st.integers(400, 3000))
def test_a_rotation_stays_whatever_is_left_of_its_last_turn(
    turn: float, phase: float, count: int
) -> None:
    assert drift(column(np.cos(turn * np.arange(count) + phase))) == 0.0


def test_a_random_set_hardly_ever_moves() -> None:
    random = np.random.default_rng(1)
    moved = [drift(column(random.normal(size=300))) > 0.0 for _ in range(2000)]
    assert np.mean(moved) < 1e-2


def test_a_chaotic_orbit_stays() -> None:
    orbit = [0.3]
    for _ in range(2000):
        orbit.append(3.9 * orbit[-1] * (1.0 - orbit[-1]))
    assert drift(column(np.array(orbit))) == 0.0


@pytest.mark.parametrize("rate", [1.0, 1e-3, 1e-6])
def test_a_creep_is_seen_however_slow(rate: float) -> None:
    assert drift(column(5.0 + rate * np.arange(400))) > 1.0


@given(turn=st.floats(0.3, 2.8), share=st.floats(1.0, 10.0))
def test_a_creep_below_a_rotation_is_seen(turn: float, share: float) -> None:
    """The mean moves by `share` of the amplitude over the window."""
    count = np.arange(1000)
    assert drift(column(np.cos(turn * count) + share * count / 1000)) > 0.0


@pytest.mark.parametrize("scale", [100.0, 400.0])
def test_a_spiral_that_shrinks_is_seen_by_its_spread(scale: float) -> None:
    count = np.arange(400)
    assert drift(column(np.exp(-count / scale) * np.cos(2.4 * count))) > 0.0


def test_a_state_that_does_not_move_says_nothing() -> None:
    points = np.column_stack([np.cos(2.4 * np.arange(400)), np.full(400, 3.0)])
    assert drift(points) == 0.0


def test_what_hardly_moves_may_do_as_it_likes() -> None:
    """A displacement beside a velocity is of another kind; a mode a thousandth as large is not."""
    count = np.arange(400)
    points = np.column_stack([np.cos(2.4 * count), 1e-5 * count / 400, np.sin(2.4 * count)])
    assert drift(points, (2,)) == 0.0
    assert drift(points, (1, 2)) > 0.0


def test_few_points_say_nothing() -> None:
    assert np.isnan(drift(column(np.arange(FEWEST - 1))))
