"""Return maps: when they have settled, and on what; regular or chaotic."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

from fiv_cli.analyses.attractor.chaos import FEWEST, regularity, regularity_in_bands
from fiv_cli.analyses.attractor.settling import (
    LONGEST,
    SETTLED,
    lasting_period,
    period_among,
    settled_period,
)

Points = NDArray[np.float64]


def detection(points: Points) -> tuple[int, int]:
    """(number of points, period) at which a map is first called settled, looking at each point."""
    for count in range(3, len(points) + 1):
        period = settled_period(points[:count])
        if period:
            return count, period
    return 0, 0


def spiral(multiplier: complex, count: int, fixed: float = 3.0, begin: float = 1.0) -> Points:
    """Approach of a fixed point of the plane with a pair of multipliers; shape (count, 2)."""
    z = begin * multiplier ** np.arange(count)
    return np.stack([fixed + z.real, -1.0 + z.imag], axis=1)


def approach(multiplier: float, nearest: float, count: int = 400) -> Points:
    """Approach of 3 that has come as near as `nearest`; shape (count, 1)."""
    back = np.arange(count)[::-1]
    with np.errstate(over="ignore"):
        away = np.minimum(nearest / np.abs(multiplier) ** back, 1.0)
    return (3.0 + np.sign(multiplier) ** back * away)[:, None]


@pytest.mark.parametrize("multiplier", [0.5, 0.9, 0.95, 0.99, -0.5, -0.9, -0.95, -0.99])
def test_a_slow_approach_is_not_taken_for_arrival(multiplier: float) -> None:
    """Neighbours that agree say nothing while they still improve; then the fixed point is one."""
    points = approach(multiplier, nearest=20 * SETTLED)
    assert settled_period(points) == 0
    if multiplier == 0.99:
        assert abs(points[-1, 0] - points[-2, 0]) < SETTLED
    assert settled_period(approach(multiplier, nearest=1e-13)) == 1


@given(
    modulus=st.floats(0.3, 0.9), turn=st.floats(0.0, 1.0), begin=st.floats(1e-3, 1.0)
)  # fmt: skip
def test_every_spiral_ends_in_one_fixed_point(modulus: float, turn: float, begin: float) -> None:
    """Also where the turn is near a fraction, so that points apart agree sooner than neighbours."""
    points = spiral(modulus * np.exp(2j * np.pi * turn), 400, begin=begin)
    count, period = detection(points)
    assert period == 1
    assert np.max(np.abs(points[count - 1] - [3.0, -1.0])) <= 10 * SETTLED


@pytest.mark.parametrize("turn", [1 / 3 + 1e-5, 1 / 4 - 1e-5, 1 / 5, 0.16, 0.0])
def test_a_slow_spiral_ends_in_a_fixed_point_whatever_its_turn(turn: float) -> None:
    points = spiral(0.97 * np.exp(2j * np.pi * turn), 900, begin=0.3)
    found = [settled_period(points[:count]) for count in range(16, 900, 16)]
    assert set(found) == {0, 1}


def test_a_map_that_hardly_settles_has_not_settled() -> None:
    points = 1.0 + 1e-6 * 0.999 ** np.arange(2000)[:, None]
    assert settled_period(points) == 0


@pytest.mark.parametrize("multiplier", [0.6, -0.6, -0.9])
@pytest.mark.parametrize("period", [1, 2, 3, 4, 5, 8, 12, 17, 32, 64, 300])
def test_periods_are_found(period: int, multiplier: float) -> None:
    """A cycle of distinct points that is approached at a rate per turn of the cycle."""
    count = 600 * period // 2 + 600
    cycle = np.cos(np.arange(period) * 2.4) + 0.01 * np.arange(period)
    steps = np.arange(count)
    error = multiplier ** (steps // period)
    points = (cycle[steps % period] + 0.1 * error)[:, None]
    assert settled_period(points) == period


@given(share=st.floats(0.01, 0.49), amplitude=st.floats(0.01, 10.0))
def test_a_rotation_does_not_settle_unless_it_closes(share: float, amplitude: float) -> None:
    closes = any(abs(share * m - round(share * m)) < 1e-6 for m in range(1, LONGEST + 1))
    angle = 2 * np.pi * share * np.arange(300)
    points = amplitude * np.stack([np.cos(angle), np.sin(angle)], axis=1)
    if not closes:
        assert settled_period(points) == 0


@pytest.mark.parametrize(("p", "q"), [(1, 3), (2, 5), (3, 8), (7, 30), (13, 64), (101, 300)])
def test_a_rational_rotation_has_the_period_of_its_denominator(p: int, q: int) -> None:
    angle = 2 * np.pi * p / q * np.arange(3 * q + 2)
    assert settled_period(np.stack([np.cos(angle), np.sin(angle)], axis=1)) == q


@given(exponent=st.integers(-60, 60))
def test_the_answer_does_not_depend_on_units(exponent: int) -> None:
    points = spiral(0.7 * np.exp(0.9j), 120)
    assert detection(points * 2.0**exponent) == detection(points)


def test_a_state_that_is_zero_but_for_rounding_does_not_count() -> None:
    noise = 1e-17 * np.random.default_rng(2).normal(size=200)
    points = np.stack([3.0 + 0.5 ** np.arange(200), noise], axis=1)
    assert settled_period(points) == 1


def test_noise_of_integration_is_no_obstacle() -> None:
    noise = 1e-11 * np.random.default_rng(2).normal(size=(200, 1))
    assert settled_period(3.0 + noise) == 1


@pytest.mark.parametrize("period", [1, 3, 10])
@pytest.mark.parametrize(("noise", "lasts"), [(1e-9, True), (1e-6, False)])
def test_a_cycle_under_the_noise_of_a_stiff_integration(
    period: int, noise: float, lasts: bool
) -> None:
    """The noise hides the rate of settling; that nothing moves any more tells."""
    random = np.random.default_rng(3)
    points = np.tile(random.uniform(1.0, 2.0, (period, 4)), (400 // period, 1))
    points = points + noise * random.uniform(-1.0, 1.0, points.shape)
    assert lasting_period(points) == (period if lasts else 0)


@pytest.mark.parametrize("rate", [1.0 - 1e-3, 1.0 + 1e-3])
def test_a_map_that_creeps_does_not_last(rate: float) -> None:
    """Neighbours within 1e-8 of each other, and 1e-6 over the window."""
    creeping = 1.0 + 5e-9 / abs(rate - 1.0) * rate ** np.arange(400.0)[:, None]
    assert np.max(np.abs(np.diff(creeping, axis=0))) < 1e-8
    assert lasting_period(creeping) == 0


def test_few_points_say_nothing() -> None:
    assert settled_period(np.ones((2, 1))) == 0
    assert settled_period(np.zeros((0, 1))) == 0


class Guarded:
    """Points as machine code takes them: a row of a negative number is not theirs."""

    def __init__(self, points: Points) -> None:
        self.points, self.shape = points, points.shape

    def __getitem__(self, place: tuple[int, int]) -> float:
        assert place[0] >= 0
        return float(self.points[place])


@pytest.mark.parametrize("period", [1, 2, 6])
def test_only_points_that_are_there_tell_whether_a_map_has_settled(period: int) -> None:
    """What lay before them in memory decided it, or ended the process."""
    steps = np.arange(5 * period)
    points = (np.cos(steps % period * 2.4) + 1e-9 * 0.6 ** (steps // period))[:, None]
    for count in range(3, len(points) + 1):
        guarded, scales = Guarded(points[:count]), np.ones(1)
        found = period_among(guarded, scales, count, SETTLED, SETTLED)  # type: ignore[arg-type]
        assert found == settled_period(points[:count])
    assert found == period


# --- the 0-1 test --------------------------------------------------------------------------------
def iterates(step: Callable[[float], float], begin: float, count: int = 1500) -> Points:
    """A sequence of iterates after 100 that are dropped."""
    values = [begin]
    for _ in range(count + 100):
        values.append(step(values[-1]))
    return np.array(values[101:])


@pytest.mark.parametrize("rate", [3.7, 3.9, 3.99])
def test_chaos_of_the_logistic_map(rate: float) -> None:
    assert regularity(iterates(lambda x: rate * x * (1 - x), 0.31)) > 0.9


@pytest.mark.parametrize("rate", [3.2, 3.5, 3.55, 3.83])
def test_cycles_of_the_logistic_map(rate: float) -> None:
    assert abs(regularity(iterates(lambda x: rate * x * (1 - x), 0.31))) < 0.1


@pytest.mark.parametrize("share", [0.6180339887, 0.4142135624, 0.05, 0.271828])
def test_a_rotation_is_regular(share: float) -> None:
    values = np.sin(2 * np.pi * share * np.arange(1500)) + 0.3 * np.cos(
        4 * np.pi * share * np.arange(1500)
    )
    assert abs(regularity(values)) < 0.2


def logistic(rate: float) -> Points:
    """Iterates of the logistic map."""
    return iterates(lambda x: rate * x * (1 - x), 0.31)


def rotation(share: float) -> Points:
    """An observable of a rotation of the circle, with a mean of its own."""
    phase = 2 * np.pi * share * np.arange(1500)
    return np.exp(np.cos(phase)) + np.sin(phase)


SEQUENCES = {
    "chaotic": logistic(3.9),
    "weakly chaotic": logistic(3.6),
    "periodic": logistic(3.55),
    "on a torus": rotation(0.4142135624),
}


@pytest.mark.parametrize("name", SEQUENCES)
@pytest.mark.parametrize(("size", "offset"), [(1e-6, 0.1), (1.0, -3.0), (1e4, 1e4)])
def test_the_test_does_not_see_offset_and_size(name: str, size: float, offset: float) -> None:
    values = SEQUENCES[name]
    assert regularity(offset + size * values) == pytest.approx(regularity(values), abs=1e-8)


@pytest.mark.parametrize("offset", [0.0, 0.1, 1.0])
def test_small_chaos_on_a_large_mean_is_chaos(offset: float) -> None:
    assert regularity(offset + 1e-6 * SEQUENCES["chaotic"]) > 0.9


@pytest.mark.parametrize("share", [0.6180339887, 0.4142135624, 0.05, 0.271828])
def test_a_rotation_with_a_mean_is_regular(share: float) -> None:
    assert abs(regularity(5.0 + rotation(share))) < 0.2


@pytest.mark.parametrize("count", [FEWEST, 137, 1024, 1500])
@pytest.mark.parametrize("name", SEQUENCES)
def test_the_test_is_that_of_its_definition(name: str, count: int) -> None:
    """Every frequency and every lag in a loop, without a Fourier transform."""
    values = SEQUENCES[name][:count]
    centred, lags = values - np.mean(values), range(1, count // 10 + 1)
    length, found = count - count // 10, []
    for k in range(1, 41):
        share = k * (np.sqrt(5.0) - 1.0) / 2.0 % 1.0
        turning = np.pi / 5.0 * (1.0 + 3.0 * share) * np.arange(1, count + 1)
        p, q = np.cumsum(centred * np.cos(turning)), np.cumsum(centred * np.sin(turning))
        squares = [
            np.mean((p[lag : lag + length] - p[:length]) ** 2)
            + np.mean((q[lag : lag + length] - q[:length]) ** 2)
            for lag in lags
        ]
        found.append(np.corrcoef(lags, squares)[0, 1])
    assert regularity(values) == pytest.approx(np.median(found), abs=1e-12)
    bounds = np.quantile(found, np.linspace(0.05, 0.95, 18))
    told = [regularity(values, (bound,)) > bound for bound in bounds]
    assert told == (np.median(found) > bounds).tolist()


@pytest.mark.parametrize("bands", [2, 3, 7, 20])
def test_chaos_in_bands_that_are_visited_in_turn(bands: int) -> None:
    """Behind the steps from band to band it is not seen; a torus in bands stays one."""
    steps = 1e3 * np.cos(2.4 * (np.arange(1500) % bands))
    for name, values in SEQUENCES.items():
        assert regularity(steps + values) < 0.3
        within = regularity_in_bands(steps + values)
        assert within > 0.9 if "chaotic" in name else within < 0.3
    assert regularity_in_bands(steps) < 0.3


def test_too_few_or_constant_values_say_nothing() -> None:
    assert np.isnan(regularity(np.arange(FEWEST - 1.0)))
    assert np.isnan(regularity(np.ones(500)))
