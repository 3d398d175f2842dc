"""What a refined map will cost: it is drawn as far as patience lasts, and then foreseen.

What was not run is taken to be as the nearest point that was, and to take as long: points at
borders are dearer than others. So borders are as long as they are known to be, and double from one
time that a map is halved to the next in a plane; where classes mix, as beside chaos, they grow by
more (`MIXED`).
"""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

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
class Drawing:
    """A map that is drawn.

    Attributes
    ----------
    numbers : positions of its points
    classes, known : of each point its class, where that is stored or was run
    run : computes the points at some positions; their block, row by row, and the time, s
    at_once : how many points that are
    stored : bytes of what was run
    seconds : what each point took that was run, else NaN
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
        self.seconds = np.full(self.known.shape, np.nan)
        self.given = self.known.copy()

    def until(self, end: float) -> None:
        """Draw it, until it is done or the clock shows `end`."""
        picture = self._drawn(self.classes, self.known)
        while not picture.complete and time.monotonic() < end:
            new = np.flatnonzero(picture.wanted & ~self.known)
            np.random.default_rng(0).shuffle(new)
            for first in range(0, len(new), self.at_once):
                if time.monotonic() < end:
                    self._run(new[first : first + self.at_once])
            picture = self._drawn(self.classes, self.known)

    def _drawn(self, classes: Classes, known: Mask) -> Picture:
        return draw(classes, known, self.maps.refinement.levels)

    def _run(self, places: Numbers) -> None:
        block, seconds = self.run(self.numbers.ravel()[places].tolist())
        self.classes.ravel()[places] = self.maps.classes_of(block)
        self.known.ravel()[places] = True
        self.seconds.ravel()[places] = seconds / len(places)
        self.stored += block.nbytes

    @property
    def was_run(self) -> Mask:
        """The points that were run for this."""
        return ~np.isnan(self.seconds)

    def _lattice(self, mask: Mask, level: int) -> Mask:
        """The points of the lattice that was halved so often."""
        step = 2 ** (self.maps.refinement.levels - level)
        return mask[(slice(None, None, step),) * mask.ndim]

    def cost(self) -> Cost:
        """Of all that is not stored; the further from what was run, the less sure."""
        if not self.was_run.any():
            return Cost((0.0, 0.0), (0.0, 0.0))
        asked, seconds = self._foreseen() & ~self.given, _as_nearest(self.seconds, self.was_run)
        points, spent, unsure = np.zeros(2), np.zeros(2), 0.0
        for level in range(self.maps.refinement.levels + 1):
            new = asked & self._is_new(level)
            left = new & ~self.was_run
            spread = np.array([MIXED**-unsure, MIXED**unsure])
            points += (new & self.was_run).sum() + left.sum() * spread
            spent += seconds[new & self.was_run].sum() + seconds[left].sum() * spread
            unsure += left.sum() / max(1, new.sum())
        more = np.minimum(points + self._again, self.numbers.size) - points
        (low, high), (least, most) = points + more, spent + more * seconds.mean()
        return Cost((low, high), (least, most))

    def _foreseen(self) -> Mask:
        """The points that will be run, were every other as the nearest that is known."""
        classes = _as_nearest(self.classes, self.known)
        return self._drawn(classes, np.ones_like(self.known)).wanted

    def _is_new(self, level: int) -> Mask:
        """The points of the lattice that is halved so often, without those of the one before."""
        new = np.zeros_like(self.known)
        self._lattice(new, level)[...] = True
        if level:
            self._lattice(new, level - 1)[...] = False
        return new

    @property
    def _again(self) -> int:
        """How many points are run although their class is filled in."""
        given = self.maps.refinement.sample
        return USUAL_SAMPLE if given is None else given


def _as_nearest(values: Any, known: Mask) -> Any:
    """Of each point the value of the nearest that is known."""
    from scipy.ndimage import distance_transform_edt

    nearest = distance_transform_edt(~known, return_distances=False, return_indices=True)
    return values[tuple(nearest)]
