"""When a return map counts as settled, and on which period: maps whose answer is known."""

import numpy as np
import pytest

from fiv_cli.analyses.attractor.settling import settled_period


def spiral(modulus, turn, count, centre=2.0):
    """Points of a map that spirals into a fixed point, shape (count, 2)."""
    path = 0.3 * (modulus * np.exp(1j * turn)) ** np.arange(count)
    return np.column_stack([centre + path.real, centre + path.imag])


@pytest.mark.parametrize("turn", [2 * np.pi / 3 + 1e-4, np.pi / 2 - 1e-4, 2 * np.pi / 5, 1.0, 0.0])
def test_a_spiral_ends_in_a_fixed_point_whatever_its_turn(turn):
    points = spiral(0.97, turn, 900)
    found = [settled_period(points[:count]) for count in range(16, 900, 16)]
    assert set(found) == {0, 1}


@pytest.mark.parametrize("period", [2, 3, 4, 12])
def test_distinct_points_make_the_period_longer(period):
    levels = 1.0 + 0.01 * np.arange(period)
    points = np.tile(levels, 30)[:, None] + spiral(0.5, 0.0, 30 * period, 0.0)[:, :1]
    assert settled_period(points) == period


def test_a_slow_approach_has_not_settled():
    points = 1.0 + 1e-6 * 0.999 ** np.arange(2000)[:, None]
    assert settled_period(points) == 0
