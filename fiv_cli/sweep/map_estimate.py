"""What a refined map will cost: it is drawn as far as patience lasts, and then foreseen.

What was not run is taken to be as the nearest point that was, and to take as long: points at
borders are dearer than others. So borders are as long as they are known to be, and double from one
time that a map is halved to the next in a plane; where classes mix, as beside chaos, they grow by
more (`MIXED`).
"""

from __future__ import annotations

import time
from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

from fiv_cli.sweep.borders import BLANK, Classes, Mask, Picture, draw
from fiv_cli.sweep.probe import Tried
from fiv_cli.sweep.refine import USUAL_SAMPLE, Maps, Numbers

MIXED = 1.1
"""By how much more, or less, than is foreseen borders grow each time that a map is halved (those of
a pin with chaos, from 6 points a side to 161, grew by 1.0 to 1.2)."""

Run = Callable[[Sequence[int]], Tried]


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
    run : computes the points at some positions, row by row
    at_once : how many points that are
    stored, given_up : bytes of what was run, and points that took too long
    failed : why others failed, and how many
    seconds : what each point took that was run, least and most, else NaN
    given : points that were stored from the beginning
    """

    maps: Maps
    numbers: Numbers
    classes: Classes
    known: Mask
    run: Run
    at_once: int
    stored: int = 0
    given_up: int = 0
    failed: Counter[str] = field(default_factory=Counter)

    def __post_init__(self) -> None:
        self.seconds = np.full((2, *self.known.shape), np.nan)
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
        result, *seconds, nbytes = self.run(self.numbers.ravel()[places].tolist())
        self.known.ravel()[places] = True
        self.seconds.reshape(2, -1)[:, places] = np.array(seconds)[:, None] / len(places)
        self.stored += nbytes
        if result is None:
            self.classes.ravel()[places] = BLANK
            self.given_up += len(places)
            return
        self.classes.ravel()[places] = self.maps.classes_of(result.block)
        self.failed += result.failures()

    @property
    def was_run(self) -> Mask:
        """The points that were run for this."""
        return ~np.isnan(self.seconds[0])

    def _lattice(self, mask: Mask, level: int) -> Mask:
        """The points of the lattice that was halved so often."""
        step = 2 ** (self.maps.refinement.levels - level)
        return mask[(slice(None, None, step),) * mask.ndim]

    def cost(self) -> Cost:
        """Of all that is not stored; the further from what was run, the less sure."""
        if not self.was_run.any():
            return Cost((0.0, 0.0), (0.0, 0.0))
        asked, nearest = self._foreseen() & ~self.given, _nearest(self.was_run)
        seconds = np.stack([some[nearest] for some in self.seconds])
        points, spent, unsure = np.zeros(2), np.zeros(2), 0.0
        for level in range(self.maps.refinement.levels + 1):
            new = asked & self._is_new(level)
            left = new & ~self.was_run
            spread = np.array([MIXED**-unsure, MIXED**unsure])
            points += (new & self.was_run).sum() + left.sum() * spread
            spent += seconds[:, new & self.was_run].sum(1) + seconds[:, left].sum(1) * spread
            unsure += left.sum() / max(1, new.sum())
        more = np.minimum(points + self._again, self.numbers.size) - points
        (low, high), (least, most) = points + more, spent + more * seconds.reshape(2, -1).mean(1)
        return Cost((low, high), (least, most))

    def _foreseen(self) -> Mask:
        """The points that will be run, were every other as the nearest that is known."""
        classes = self.classes[_nearest(self.known)]
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


def _nearest(known: Mask) -> tuple[Numbers, ...]:
    """Of each point the nearest that is known."""
    from scipy.ndimage import distance_transform_edt

    return tuple(distance_transform_edt(~known, return_distances=False, return_indices=True))
