"""Lines through crossings, of which a point of an axis has several."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import chain, pairwise
from typing import TYPE_CHECKING

import numpy as np

from fiv_cli.plots import labels, points

if TYPE_CHECKING:
    import xarray as xr

MOST_STEPS = 3  # of one line that are told of
ROOM = (1.0, 4.0, np.inf)  # of the steps beside it, that a step of a followed value may have ...
SMALL = 0.02  # ... or of all values
SHORTER = 1.01


def parted(axis: xr.DataArray) -> np.ndarray:
    """Between which neighbours along an axis no line leads.

    There one that others advance with stands still, or turns, or a drive turns its sense.
    """
    x = points.positions(axis)
    steps, is_speed = np.diff(x), axis.attrs.get("role") == "speed"
    first: float = next(iter(steps[steps != 0.0]), 1.0)
    return np.asarray((steps * first <= 0.0) | (is_speed & (x[1:] * x[:-1] < 0.0)))


Place = tuple[int, int]
"""Numbers of a point and of a crossing there."""


def joined(axis: xr.DataArray, values: np.ndarray, modes: np.ndarray) -> list[list[Place]]:
    """Lines through crossings, shape (points, crossings), as places along them.

    Crossings of neighbours are joined as far as it can be told that they belong together.
    """
    rows = [
        [(point, int(i)) for i in np.argsort(row)[: np.isfinite(row).sum()]]
        for point, row in enumerate(values)
    ]
    lines: dict[Place, list[Place]] = {place: [place] for row in rows for place in row}
    for (before, after), apart in zip(pairwise(rows), parted(axis), strict=True):
        for one, other in [] if apart else _pairs(before, after, values, modes):
            lines[other] = lines[one]
            lines[one].append(other)
    distinct = {id(line): line for line in lines.values()}.values()
    x = points.positions(axis)
    return [piece for line in distinct for piece in _followed(line, x, values, modes)]


def not_joined(
    axis: xr.DataArray, values: np.ndarray, lines: Sequence[Sequence[Place]]
) -> list[int]:
    """Points between which and the next fewer lines lead than both have crossings."""
    counts = np.isfinite(values).sum(axis=1)
    led = np.zeros(counts.size - 1, int)
    for line in lines:
        led[[place for place, _ in line[:-1]]] += 1
    fewer = (np.minimum(counts[1:], counts[:-1]) > led) & ~parted(axis)
    steps: list[int] = np.flatnonzero(fewer).tolist()
    return steps


def broken(
    words: str,
    along: object,
    steps: Sequence[tuple[float, float]],
    x: np.ndarray,
    what: str = "it",
) -> Iterator[str]:
    """What to do where lines of crossings are not joined, from one place to the next of all x."""
    for step in steps[:MOST_STEPS]:
        ends = " and ".join(labels.number_text(one, x.tolist()) for one in step)
        yield (
            f"{words}: not joined between {along} = {ends}, where {what} steps by more than beside "
            f"it; if it is one line, more values of {along} in its case join it"
        )


def _pairs(
    before: list[Place], after: list[Place], values: np.ndarray, modes: np.ndarray
) -> list[tuple[Place, Place]]:
    """Which crossings of two neighbours may be one: of one mode, the others in order.

    All are in order where that is the shorter way: the numbers of modes differ then.
    """
    pairs = []
    for mode in {modes[place] for place in before}:
        own, its = ([p for p in row if modes[p] == mode] for row in (before, after))
        pairs += _nearest(own, its, values)
    if len(before) != len(after):
        return pairs
    left = ([p for p in row if p not in chain(*pairs)] for row in (before, after))
    pairs += zip(*left, strict=True)
    in_order = [*zip(before, after, strict=True)]
    return in_order if _way(pairs, values) > SHORTER * _way(in_order, values) else pairs


def _way(pairs: Sequence[tuple[Place, Place]], values: np.ndarray) -> float:
    return float(sum(abs(values[one] - values[other]) for one, other in pairs))


def _nearest(
    before: list[Place], after: list[Place], values: np.ndarray
) -> list[tuple[Place, Place]]:
    """In order where they are equally many, else those that are nearest to one another."""
    if len(before) == len(after) or not before or not after:
        return [*zip(before, after, strict=False)]
    apart = np.abs(np.subtract.outer([values[p] for p in before], [values[p] for p in after]))
    to, back = apart.argmin(axis=1).tolist(), apart.argmin(axis=0).tolist()
    return [(before[n], after[m]) for n, m in enumerate(to) if back[m] == n]


def _followed(
    line: list[Place], x: np.ndarray, values: np.ndarray, modes: np.ndarray
) -> list[list[Place]]:
    """The pieces of a line between steps that are large against those beside them.

    The more speaks for a step, the larger it may be: that as many crossings of the same mode lie
    at both its ends, and that the line goes on as it does.
    """
    at = tuple(np.array(line).T)
    steps, counts = np.diff(values[at]), np.isfinite(values).sum(axis=1)[at[0]]
    slopes = steps / np.diff(x[at[0]])
    alike = (np.diff(counts) == 0) & (np.diff(modes[at]) == 0)
    beside = np.stack([np.append(np.nan, slopes)[:-1], np.append(slopes, np.nan)[1:]])
    goes_on = (beside * slopes > 0.0).any(axis=0)
    room = np.take(ROOM, alike * 1 + goes_on) * np.nan_to_num(np.abs(beside)).max(axis=0)
    kept = (np.abs(slopes) <= room) | (alike & np.isnan(beside).all(axis=0))
    kept |= np.abs(steps) <= SMALL * (np.nanmax(values) - np.nanmin(values))
    cuts = [0, *(np.flatnonzero(~kept) + 1).tolist(), len(line)]
    return [line[begin:end] for begin, end in pairwise(cuts)]


def modes_of(dataset: xr.Dataset, array: xr.DataArray) -> xr.DataArray:
    """The mode of each crossing; one and the same where that means nothing."""
    return dataset["crossing_mode"] if "crossing_mode" in dataset else array * 0.0
