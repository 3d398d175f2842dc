"""The values of a grid axis, exactly as the decimals in the case say.

An axis is counted before it is built, so an absurd one costs nothing. Linear axes are computed
in integers over a common denominator (Python rounds an integer quotient correctly), logarithmic
ones in forty decimal digits: every value is the double nearest to the decimal meant.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Sequence
from dataclasses import dataclass, field, replace
from decimal import Context, Decimal
from fractions import Fraction
from itertools import pairwise
from math import floor, lcm
from typing import Any

from fiv_cli.case.report import Path

# Values of one axis are held in memory; more of them than this is a mistake or several axes.
LONGEST_AXIS = 10_000_000
_DIGITS = Context(prec=40)


class AxisError(ValueError):
    """An axis that cannot be built; `key` is the key at fault ("" for the whole axis)."""

    def __init__(self, message: str, key: str = "") -> None:
        self.key = key
        super().__init__(message)


@dataclass(frozen=True)
class Span:
    """A regular axis from `start` to `stop`, both included, of `count` values."""

    start: Fraction
    stop: Fraction
    count: int
    logarithmic: bool = False

    def values(self) -> list[float]:
        """The values, each the nearest double."""
        return self._logarithmic() if self.logarithmic else self._linear()

    @property
    def second(self) -> float:
        """The value after the first."""
        share, span = Fraction(1, max(self.count - 1, 1)), self.stop - self.start
        if self.logarithmic:
            return float(self.start) * float(self.stop / self.start) ** float(share)
        return float(self.start + share * span)

    def halved(self, times: int) -> Span:
        """The same stretch with the spacing halved so often; its values stay among the new ones."""
        return replace(self, count=(self.count - 1) * 2**times + 1)

    def _linear(self) -> list[float]:
        gaps = max(self.count - 1, 1)
        scale = lcm(self.start.denominator, self.stop.denominator)
        low, high = int(self.start * scale), int(self.stop * scale)
        return [(low * gaps + (high - low) * i) / (scale * gaps) for i in range(self.count)]

    def _logarithmic(self) -> list[float]:
        low, ratio = _decimal(self.start), _decimal(self.stop / self.start)
        gaps = max(self.count - 1, 1)
        exponents = (_DIGITS.divide(Decimal(i), Decimal(gaps)) for i in range(self.count))
        inner = [float(_DIGITS.multiply(low, _DIGITS.power(ratio, e))) for e in exponents]
        return [float(self.start), *inner[1:-1], float(self.stop)][: self.count]


ROUNDING = Fraction(1, 10**9)
"""Of a step, by which a stop may be off that was rounded, as one of a conversion of units is."""


def span_by_step(start: Fraction, stop: Fraction, step: Fraction) -> Span:
    """The axis start, start + step, ..., stop, rising or falling.

    AxisError when a step does not land on stop, but for rounding: it ends at stop, as written.
    """
    if step == 0:
        raise AxisError("the step must not be 0", "step")
    gaps = (stop - start) / step
    gaps = Fraction(round(gaps)) if abs(gaps - round(gaps)) < ROUNDING else gaps
    if gaps < 0:
        raise AxisError(
            f"steps of {float(step)!r} from {float(start)!r} lead away from {float(stop)!r}: "
            f"give step = {float(-step)!r}, or exchange start and stop",
            "step",
        )
    if gaps.denominator != 1:
        below = start + floor(gaps) * step
        raise AxisError(
            f"steps of {float(step)!r} from {float(start)!r} miss the stop {float(stop)!r}: "
            f"the nearest stops are {float(below)!r} and {float(below + step)!r}",
            "stop",
        )
    return Span(start, stop, int(gaps) + 1)


def span_by_count(start: Fraction, stop: Fraction, num: int, scale: str) -> Span:
    """The axis of `num` values from start up or down to stop, ``scale`` "linear" or "log"."""
    if num < 1 or (num == 1) != (start == stop):
        raise AxisError(f"{num} values cannot include both ends", "num")
    for key, end in (("start", start), ("stop", stop)) if scale == "log" else ():
        if end <= 0:
            raise AxisError(f"a logarithmic axis lies above 0, not at {float(end):g}", key)
    return Span(start, stop, num, logarithmic=scale == "log")


def span_of_list(values: Sequence[Fraction]) -> Span:
    """The axis of which these are the values; AxisError when they do not rise evenly."""
    first, last, gaps = values[0], values[-1], max(len(values) - 1, 1)
    rising = all(low < high for low, high in pairwise(values))
    linear = all(value == first + (last - first) * i / gaps for i, value in enumerate(values))
    constant = first > 0 and all(
        high * values[0] == low * values[min(1, gaps)] for low, high in pairwise(values)
    )
    if not rising or not (linear or constant):
        raise AxisError("its values do not rise evenly")
    return Span(first, last, len(values), logarithmic=not linear)


def _decimal(value: Fraction) -> Decimal:
    return _DIGITS.divide(Decimal(value.numerator), Decimal(value.denominator))


@dataclass(frozen=True)
class Candidate:
    """An axis by name, before its values are read.

    Attributes
    ----------
    read : one value, in SI -> what is kept; ValueError when it is not allowed
    unit : None for names
    allowed, choices : what a value may be, in words, and by name
    written : the axis as a span, or as the list that the case has; empty where it is neither
    """

    name: str
    kind: str
    place: Path
    read: Callable[[Any], Any]
    unit: str | None = None
    allowed: str = ""
    choices: Collection[str] = ()
    written: Span | list[Any] = field(default_factory=list)

    @property
    def count(self) -> int:
        """How many values there are; they are counted before they are built."""
        return self.written.count if isinstance(self.written, Span) else len(self.written)
