"""Parameters that vary in time: piecewise linear, constant before and after.

Between two kinks a scheduled parameter is ``value + rate * t`` in the generated code. At a kink the
driver stops, takes up the next piece and decides the contact states anew: the rate jumps, and with
it the forces in stick.
"""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise

Points = tuple[tuple[float, float], ...]  # (time in s, SI value), times rising


@dataclass(frozen=True)
class Schedule:
    """What varies in time.

    Attributes
    ----------
    curves : (parameter, its points); sorted by parameter
    """

    curves: tuple[tuple[str, Points], ...] = ()

    @cached_property
    def names(self) -> tuple[str, ...]:
        """Parameters that vary."""
        return tuple(name for name, _ in self.curves)

    @cached_property
    def kinks(self) -> tuple[float, ...]:
        """Times at which some rate jumps, s."""
        return tuple(sorted({time for _, points in self.curves for time, _ in points}))

    @property
    def instants(self) -> tuple[float, ...]:
        """The start and every kink, s: what varies is extreme at one of them."""
        return 0.0, *self.kinks

    def next_kink(self, time: float) -> float:
        """The first kink after `time`, s; infinity when none follows."""
        place = bisect_right(self.kinks, time)
        return self.kinks[place] if place < len(self.kinks) else float("inf")

    def piece(self, time: float) -> dict[str, tuple[float, float]]:
        """Parameter -> (value at t = 0 of the line that holds from `time` on, rate)."""
        return {name: _line(points, time) for name, points in self.curves}

    def values(self, time: float) -> dict[str, float]:
        """Parameter -> its value at `time`, SI."""
        return {name: value + rate * time for name, (value, rate) in self.piece(time).items()}


STEADY = Schedule()
"""Nothing varies."""


def make_schedule(curves: Mapping[str, Iterable[tuple[float, float]]]) -> Schedule:
    """The schedule of these curves.

    Raises
    ------
    ValueError
        when a curve has no points or its times do not rise
    """
    return Schedule(tuple((name, _checked(name, curves[name])) for name in sorted(curves)))


def _checked(name: str, points: Iterable[tuple[float, float]]) -> Points:
    found = tuple((float(time), float(value)) for time, value in points)
    if not found:
        raise ValueError(f"the schedule of {name} has no points")
    if any(later <= earlier for (earlier, _), (later, _) in pairwise(found)):
        raise ValueError(f"the times of the schedule of {name} do not rise")
    return found


def _line(points: Points, time: float) -> tuple[float, float]:
    place = bisect_right([t for t, _ in points], time)
    if place == 0 or place == len(points):
        return points[max(place - 1, 0)][1], 0.0
    (begun, first), (ended, last) = points[place - 1], points[place]
    rate = (last - first) / (ended - begun)
    return first - rate * begun, rate


def rate_of(parameter: str) -> str:
    """Name of the rate of a parameter that varies in time."""
    return f"{parameter}.rate"
