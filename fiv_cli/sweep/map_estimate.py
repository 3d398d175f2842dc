"""What a refined map will cost: it is drawn as far as patience lasts, and then foreseen.

What was not run is taken to be as the nearest point that was. So its borders are as long as they
are known to be, and double from one time that a map is halved to the next in a plane; where classes
mix, as beside chaos, they grow by more (`MIXED`).
"""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from fiv_cli.data.block import Block
from fiv_cli.sweep.borders import Classes, Mask, Picture, draw
from fiv_cli.sweep.refine import USUAL_SAMPLE, Maps, Numbers

MIXED = 1.1
"""By how much more, or less, than is foreseen borders grow each time that a map is halved (those of
a pin with chaos, from 6 points a side to 161, grew by 1.0 to 1.2)."""

Run = Callable[[Sequence[int]], tuple[Block, float]]


class Cost(NamedTuple):
    """What a map, or several, is likely to take: least and most."""

    points: tuple[float, float]
    seconds: tuple[float, float]


@dataclass
class Level:
    """What was run of the points that a map is asked for by being halved once more.

    Attributes
    ----------
    run : how many
    seconds : that they took
    """

    run: int = 0
    seconds: float = 0.0


@dataclass
class Drawing:
    """A map that is drawn.

    Attributes
    ----------
    numbers : positions of its points
    classes, known : of each point its class, where that is stored or was run
    run : computes the points at some positions; their block, row by row, and the time, s
    at_once : how many points that are
    stored : bytes of what was run
    levels : the coarse lattice, then each time that it is halved
    given : points that were stored from the beginning
    """

    maps: Maps
    numbers: Numbers
    classes: Classes
    known: Mask
    run: Run
    at_once: int
    stored: int = 0

    def __post_init__(self) -> None:
        self.levels = [Level() for _ in range(self.maps.refinement.levels + 1)]
        self.given = self.known.copy()

    def until(self, end: float) -> None:
        """Draw it, until it is done or the clock shows `end`."""
        picture = self._drawn(self.classes, self.known)
        while not picture.complete and time.monotonic() < end:
            level = self.levels[picture.level + bool(self._lattice(self.known, 0).all())]
            new = np.flatnonzero(picture.wanted & ~self.known)
            np.random.default_rng(0).shuffle(new)
            for first in range(0, len(new), self.at_once):
                if time.monotonic() < end:
                    self._run(new[first : first + self.at_once], level)
            picture = self._drawn(self.classes, self.known)

    def _drawn(self, classes: Classes, known: Mask) -> Picture:
        return draw(classes, known, self.maps.refinement.levels)

    def _run(self, places: Numbers, level: Level) -> None:
        block, seconds = self.run(self.numbers.ravel()[places].tolist())
        self.classes.ravel()[places] = self.maps.classes_of(block)
        self.known.ravel()[places] = True
        level.run, level.seconds = level.run + len(places), level.seconds + seconds
        self.stored += block.nbytes

    def _lattice(self, mask: Mask, level: int) -> Mask:
        """The points of the lattice that was halved so often."""
        step = 2 ** (self.maps.refinement.levels - level)
        return mask[(slice(None, None, step),) * mask.ndim]

    def cost(self) -> Cost:
        """Of all that is not stored; the further from what was run, the less sure."""
        asked = self._foreseen() & ~self.given
        counts = [np.count_nonzero(self._lattice(asked, n)) for n in range(len(self.levels))]
        points, seconds = np.zeros(2), np.zeros(2)
        unsure, of_a_point = 0.0, 0.0
        for level, count in zip(self.levels, np.diff(counts, prepend=0).tolist(), strict=True):
            left = max(0, count - level.run)
            of_a_point = level.seconds / level.run if level.run else of_a_point
            spread = np.array([MIXED**-unsure, MIXED**unsure])
            points += level.run + left * spread
            seconds += level.seconds + left * of_a_point * spread
            unsure += left / max(1, count)
        more = np.minimum(points + self._again, self.numbers.size) - points
        (low, high), (least, most) = points + more, seconds + more * of_a_point
        return Cost((low, high), (least, most))

    def _foreseen(self) -> Mask:
        """The points that will be run, were every other as the nearest that is known."""
        from scipy.ndimage import distance_transform_edt

        nearest = distance_transform_edt(~self.known, return_distances=False, return_indices=True)
        return self._drawn(self.classes[tuple(nearest)], np.ones_like(self.known)).wanted

    @property
    def _again(self) -> int:
        """How many points are run although their class is filled in."""
        given = self.maps.refinement.sample
        return USUAL_SAMPLE if given is None else given
