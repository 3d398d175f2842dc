"""Where a curve leaves one motion for another: no line leads from one to the other.

A step that is seen, and that no curve takes: longer by far than those beside it.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING

import numpy as np

from fiv_cli.reading.datasets import numbers

if TYPE_CHECKING:
    import xarray as xr

SAME = 1e-6  # relative distance of values of one motion
MANY = 1e6  # passages: more than any cycle has
MARKS = ("period", "L_s")  # of a motion, beside its shares of stick and slip
STEP = 3.0  # times those beside it: a step that no curve takes ...
LEAP = 6.0  # ... or within a kind of cycle, where a square root begins steeply
# Shares of its range by which a line leaps at least where it breaks; beside a kind of one
# point, or at an end, where a step has none beside it: or a share of the lesser of both values.
SEEN, SEEN_ALONE, GROWN = 0.02, 0.25, 0.5
# ... or, on its both sides, the steps of a mark, and of its range: no root nor grazing does that
CLEAR, GREAT = 12.0, 0.1
TURNED = 2.0  # ... or the steps on its both sides, which lead the other way
SHARE_OF_STEP = 0.5  # of its own, that the step of what a line goes over to has at most


def changes_over(y: np.ndarray, starts: np.ndarray) -> np.ndarray:
    """Between which neighbours a line leaves its motion for that of another start.

    At one of both it has the value of another start, whose step between them is shorter by far.
    """
    with_, steps = np.isclose(starts, y, rtol=SAME, atol=0.0), np.abs(np.diff(starts, axis=1))
    met = with_[:, 1:] != with_[:, :-1]
    return np.asarray((met & (steps < SHARE_OF_STEP * np.abs(np.diff(y)))).any(axis=0))


def kinds(dataset: xr.Dataset) -> xr.DataArray:
    """One number for how often a cycle passes the section, and which contacts stick on it."""
    passages = numbers(dataset.get("multiplicity", dataset["status"]))
    sticks = dataset.get("stick_fraction", passages * 0.0) > 0.0
    if "contact" in sticks.dims:
        sticks = (sticks * 2.0 ** np.arange(sticks.sizes["contact"])).sum("contact")
    return passages.fillna(0.0) + MANY * sticks


def of_changing_passages(kinds: np.ndarray) -> np.ndarray:
    """Between which neighbours how often cycles pass the section changes, and beside it again: no
    three points are of one branch there, but for one whose period doubles."""
    passages = kinds % MANY
    low, high = np.minimum(passages[1:], passages[:-1]), np.maximum(passages[1:], passages[:-1])
    changes = (low > 0.0) & (high > low) & (high != 2.0 * low)
    again = np.pad(changes, 1)
    return np.asarray(changes & (again[:-2] | again[2:]))


def of_a_handover(kinds: np.ndarray) -> np.ndarray:
    """Between which neighbours sticking goes over from some contacts to others at a single point:
    what sticks there is of a branch on neither side."""
    sticks = (kinds // MANY).astype(int)
    before, here, after = sticks[:-2], sticks[1:-1], sticks[2:]
    lost, gained = before & ~after, after & ~before
    alone = np.pad((lost > 0) & (gained > 0) & (here != before) & (here != after), 1)
    return np.asarray(alone[1:] | alone[:-1])


def marks_of_motions(dataset: xr.Dataset) -> Iterator[xr.DataArray]:
    """What leaps, one or the other, where a line goes over to another cycle of the same kind."""
    shares = [name for name in map(str, dataset) if name.endswith("_fraction")]
    for name in [name for name in (*MARKS, *shares) if name in dataset]:
        one = numbers(dataset[name])
        yield from (
            [one.isel(contact=n) for n in range(one.sizes["contact"])]
            if "contact" in one.dims
            else [one]
        )


def told_apart(kinds: np.ndarray, marks: Sequence[xr.DataArray]) -> tuple[np.ndarray, np.ndarray]:
    """Numbers of kinds of cycles along a line, which change where any mark of motions leaps; and
    between which neighbours a mark alone tells that they do.

    They are negative of what passes no section.
    """
    changes = kinds[1:] != kinds[:-1]
    surely = np.zeros_like(changes)
    for one in marks:
        if one.shape == kinds.shape and one.notnull().any():
            ends = float(one.min()), float(one.max())
            changes = changes | leaps(one.values, kinds, ends, logarithmic=False)
            surely = surely | _clearly(one.values, kinds, ends)
    numbered = 1 + np.cumsum(np.append(False, changes | surely))
    return np.where(kinds > 0.0, 1, -1) * numbered, surely


def _clearly(mark: np.ndarray, kinds: np.ndarray, ends: tuple[float, float]) -> np.ndarray:
    """Between which neighbours a mark of cycles of one kind steps far more than on both sides, at
    an end of a row of these than twice before it; other steps as great are passed over. Where both
    sides lead the other way, no curve leads through a step that is twice theirs."""
    is_cycle = np.where(kinds % MANY > 0.0, kinds, np.nan)
    steps = np.where(is_cycle[1:] == is_cycle[:-1], np.abs(np.diff(mark)), np.nan)
    clear, known = np.zeros(steps.shape, bool), np.isfinite(steps)
    for row in np.split(np.arange(steps.size), np.flatnonzero(~known)):
        row = row[known[row]]
        least = max(CLEAR * float(np.median(steps[row])), GREAT * np.ptp(ends)) if row.size else 0.0
        great = row[steps[row] > least]
        plain = np.setdiff1d(row, great)
        for step in great.tolist():
            before, after = plain[plain < step][-2:], plain[plain > step][:2]
            both = before.size and after.size
            beside = [before[-1], after[0]] if both else [*before, *after]
            clear[step] = len(beside) == 2 and steps[step] > CLEAR * steps[beside].max()
    turns = np.where(np.isfinite(steps), np.diff(mark), 0.0)
    before, here, after = turns[:-2], turns[1:-1], turns[2:]
    against = (before * here < 0.0) & (here * after < 0.0)
    least = TURNED * np.maximum(np.abs(before), np.abs(after))
    clear[1:-1] |= against & (np.abs(here) > np.maximum(least, GREAT * np.ptp(ends)))
    return clear


def leaps(
    y: np.ndarray,
    kinds: np.ndarray,
    shown: tuple[float, float],
    logarithmic: bool,
    surely: np.ndarray | bool = False,
) -> np.ndarray:
    """Between which neighbours a line steps by more than beside it, to a cycle of another kind.

    Where a cycle gains a stick on its way the line goes on. Steps are compared with those within a
    kind: beside them, else the median of all. No value elsewhere decides on a step that is seen,
    where `shown` are the least and the greatest that are. To a cycle of the same kind it is one
    that leaps by more than the steps on both sides of it, whatever they do: where both lead to
    other kinds, than these. Where motions `surely` differ there need be no step.
    """
    height = np.log10(np.where(y > 0.0, y, np.nan)) if logarithmic else y
    steps, differ = np.abs(np.diff(height)), kinds[1:] != kinds[:-1]
    within = steps[~differ & np.isfinite(steps)]
    if not within.size:
        return np.zeros(steps.shape, bool)
    known = np.pad(np.where(differ, np.nan, steps), 1, constant_values=np.nan)
    beside, is_alone = np.fmax(known[:-2], known[2:]), np.isnan(known[:-2] + known[2:])
    moving = np.where(np.minimum(kinds[1:], kinds[:-1]) > 0.0, steps, np.nan)
    around = np.pad(moving, 1, constant_values=np.nan)
    of_others = np.isnan(beside) & ~differ
    beside = np.where(of_others, np.fmax(around[:-2], around[2:]), beside)
    unsure = np.isnan(beside) | (is_alone & ~differ)
    beside = np.where(unsure, np.fmax(beside, np.median(within)), beside)
    grown = np.abs(np.diff(y)) > GROWN * np.minimum(np.abs(y[1:]), np.abs(y[:-1]))
    extent = float(np.ptp(np.log10(shown) if logarithmic else shown))
    least = np.where(is_alone & ~(grown & differ), SEEN_ALONE, SEEN) * extent
    least = np.maximum(np.where(differ, STEP, LEAP) * beside, least)
    return np.asarray((differ | grown) & (steps > least) | (surely & np.isfinite(steps)))
