"""Which points of a lattice must be run to draw the borders between its classes.

A coarse lattice is run whole. Then it is halved again and again, but only along borders: cells
whose corners disagree, and their neighbours, are run on the lattice of half the spacing, all other
new points take the class of the corners around them. A border that leaves the cells that were run
is followed into the next ones before the lattice is halved again, so that in the end every two
neighbours of different class have both been run: a border that was met anywhere is drawn whole,
and all that can be missed is an island between the points of the coarse lattice.

A point that was run in vain (its process died, say) is `BLANK`: it agrees with whatever is around
it, so that an accident draws no border.

Everything here is a pure function of the classes found so far. What is wanted next follows from
what is known, so a run that was interrupted goes on as if nothing had happened.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

Mask = NDArray[np.bool_]
Classes = NDArray[np.int32]

BLANK = int(np.iinfo(np.int32).min)
"""Class of a point that was run without coming to any."""


@dataclass(frozen=True)
class Picture:
    """A map of classes, as far as it is known.

    Attributes
    ----------
    wanted : points to run, those that have been run included; shape of the fine lattice
    classes : class of every point, of those that were not run from the corners around them; valid
        when `complete`
    complete : whether every wanted point is known
    level : how often the lattice is halved, as far as all of it is known
    """

    wanted: Mask
    classes: Classes
    complete: bool
    level: int


def draw(classes: Classes, known: Mask, levels: int) -> Picture:
    """The map as far as what is known goes, and what must be run to go on.

    Parameters
    ----------
    classes : class of each point of the fine lattice, where known, or `BLANK`; every length is a
        multiple of 2**levels plus one, and two at least
    known : which points have been run; those that are not wanted are not looked at
    levels : how often the coarse lattice is halved
    """
    wanted = np.zeros(classes.shape, bool)
    found = _every(classes, 2**levels)
    _every(wanted, 2**levels)[...] = True
    if (wanted & ~known).any():
        return Picture(wanted, classes, False, 0)
    for level in range(1, levels + 1):
        step = 2 ** (levels - level)
        finer = _halved(found, _every(classes, step), _every(known, step), _every(wanted, step))
        if finer is None:
            return Picture(wanted, classes, False, level - 1)
        found = finer
    return Picture(wanted, found, True, levels)


def sample(filled: Mask, count: int, seed: int) -> Mask:
    """A seeded choice of at most `count` of the `filled` points, the same on every machine."""
    places = np.flatnonzero(filled)
    chosen = places[np.argsort(_scattered(places, seed), kind="stable")[:count]]
    mask = np.zeros(filled.shape, bool)
    mask.ravel()[chosen] = True
    return mask


def _scattered(places: NDArray[np.int64], seed: int) -> NDArray[np.uint64]:
    """A number for each place that is as good as random.

    The finaliser of SplitMix64 (Steele, Lea & Flood, OOPSLA 2014): generators of NumPy may change
    their streams from version to version.
    """
    x = places.astype(np.uint64) + np.uint64((seed + 1) * 0x9E3779B97F4A7C15 % 2**64)
    x = (x ^ (x >> np.uint64(30))) * np.uint64(0xBF58476D1CE4E5B9)
    x = (x ^ (x >> np.uint64(27))) * np.uint64(0x94D049BB133111EB)
    return x ^ (x >> np.uint64(31))


def _every(array: Any, step: int) -> Any:
    """The points of the lattice of spacing `step`, as a view."""
    return array[(slice(None, None, step),) * array.ndim]


def _halved(coarse: Classes, classes: Classes, known: Mask, wanted: Mask) -> Classes | None:
    """The map on the lattice of half the spacing; None where points are wanted first.

    Parameters
    ----------
    coarse : the map before
    classes, known, wanted : on the finer lattice; `wanted` is added to
    """
    refined = _grown(_disagreeing(coarse))
    while True:
        wanted |= _points_of(refined)
        if (wanted & ~known).any():
            return None
        found = np.where(wanted, classes, _prolonged(coarse))
        followed = _parents(_disagreeing(found)) & ~refined
        if not followed.any():
            return found
        refined |= _grown(followed)


def _disagreeing(classes: Classes) -> Mask:
    """Cells whose corners are not all of one class, blank ones left out."""
    least = np.where(classes == BLANK, np.iinfo(np.int32).max, classes)
    for axis in range(classes.ndim):
        least = np.minimum(*_neighbours(least, axis))
    return least < _greatest(classes)


def _greatest(classes: Classes) -> Classes:
    """The greatest class at the corners of each cell; blank where they all are."""
    for axis in range(classes.ndim):
        classes = np.maximum(*_neighbours(classes, axis))
    return classes


def _neighbours(array: Any, axis: int) -> tuple[Any, Any]:
    """Every entry but the last along `axis`, and every one but the first."""
    before: list[slice] = [slice(None)] * array.ndim
    after = list(before)
    before[axis], after[axis] = slice(None, -1), slice(1, None)
    return array[tuple(before)], array[tuple(after)]


def _grown(cells: Mask) -> Mask:
    """Cells and all that touch them, at a corner too."""
    for axis in range(cells.ndim):
        grown = cells.copy()
        first, last = _neighbours(grown, axis)
        before, after = _neighbours(cells, axis)
        first |= after
        last |= before
        cells = grown
    return cells


def _points_of(cells: Mask) -> Mask:
    """Points of the halved lattice in and around the given cells."""
    for axis in range(cells.ndim):
        doubled = np.repeat(cells, 2, axis)
        shape = list(doubled.shape)
        shape[axis] += 1
        points = np.zeros(shape, bool)
        first, last = _neighbours(points, axis)
        first |= doubled
        last |= doubled
        cells = points
    return cells


def _prolonged(coarse: Classes) -> Classes:
    """The map on the halved lattice: new points take the class of the cell they lie in."""
    finer = _greatest(coarse)
    for axis, length in enumerate(coarse.shape):
        finer = np.take(finer, np.minimum(np.arange(2 * length - 1) // 2, length - 2), axis)
    old = _every(finer, 2)
    old[...] = np.where(coarse == BLANK, old, coarse)
    return finer


def _parents(cells: Mask) -> Mask:
    """Cells that hold any of the given cells of the halved lattice."""
    for axis in range(cells.ndim):
        shape = cells.shape
        pairs = cells.reshape(*shape[:axis], shape[axis] // 2, 2, *shape[axis + 1 :])
        cells = np.logical_or.reduce(pairs, axis + 1)
    return cells
