"""Section sets that stay, and section sets that move."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from fiv_cli.analyses.attractor.stationarity import FEWEST, drift, parting


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


# --- tori, and what is on its way to a cycle ------------------------------------------------------
turns = st.floats(0.1, 3.0)


def spiral(modulus: float, turn: float, clusters: int = 1) -> np.ndarray:
    """About a cycle with so many section points, 400 times round it, seen through a skew lens."""
    place = np.arange(400 * clusters)
    turned = 0.01 * (modulus * np.exp(1j * turn)) ** (place / clusters)
    if clusters > 1:
        turned += np.exp(2j * np.pi * place / clusters)
    skew = np.array([[1.0, 0.4, 30.0], [0.3, -0.2, 7.0]])
    return 5.0 + np.column_stack([turned.real, turned.imag]) @ skew


def forced(rate: float) -> np.ndarray:
    """A linear oscillator under two forces, at the phases of the first one, bent by an observer."""
    times = 2.0 * np.pi * np.arange(1000)
    place = np.exp(1j * rate * times) / (1.3 - rate**2 + 0.1j)
    return np.column_stack([place.real + 0.1 * place.real**2, place.imag * np.exp(place.real / 9)])


@given(st.sampled_from([0.979, 0.999, 0.9999, 1.0001, 1.001]), turns, st.sampled_from([1, 2, 7]))
def test_no_spiral_is_a_torus_however_slow(modulus: float, turn: float, clusters: int) -> None:
    """Of modulus 0.9999 the halves of the set differ by 2 % in their spread."""
    moved = parting(spiral(modulus, turn, clusters))
    assert np.isnan(moved) or np.sign(moved) == np.sign(modulus - 1.0)


@given(turns)
def test_a_rotation_is_a_torus(turn: float) -> None:
    assert parting(spiral(1.0, turn)) == 0.0


@pytest.mark.parametrize("rate", [5**0.5 / 2 - 0.5, 0.5**0.5, (2 / 3) ** 0.5, 0.9**0.5, 3**-0.5])
def test_two_frequencies_are_a_torus(rate: float) -> None:
    assert parting(forced(rate)) == 0.0


def test_a_torus_that_has_been_seen_in_part_is_not_told() -> None:
    """A hundred times slower at one place than elsewhere, which the points pass a few times."""
    angles = [0.0]
    for _ in range(900):
        further = 2.0 * np.pi / 3.0 + 1e-2 - 9.9e-3 * np.cos(3.0 * angles[-1])
        angles.append(angles[-1] + further)
    assert parting(np.column_stack([np.cos(angles), np.sin(angles)])) != 0.0
