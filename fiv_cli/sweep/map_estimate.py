"""What a refined map will cost: it is drawn as far as patience lasts, and its borders grow on.

From one time that a map is halved to the next, the points along borders that are curves double in
a plane; as long as the lattice is too coarse for them, they grow as the lattice does.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

from fiv_cli.data.block import Block
from fiv_cli.sweep.borders import BLANK, Classes, draw
from fiv_cli.sweep.refine import USUAL_SAMPLE, Maps, Numbers

Run = Callable[[Sequence[int]], tuple[Block, float]]


class Cost(NamedTuple):
    """What a map, or several, is likely to take: least and most."""

    points: tuple[float, float]
    seconds: tuple[float, float]


@dataclass
class Level:
    """What a map is asked for by being halved once more.

    Attributes
    ----------
    wanted, run : numbers of points
    seconds : that those which were run took
    """

    wanted: int = 0
    run: int = 0
    seconds: float = 0.0

    @property
    def of_a_point(self) -> float:
        """Mean time of a point, s."""
        return self.seconds / max(1, self.run)


@dataclass
class Drawing:
    """A map that is drawn.

    Attributes
    ----------
    numbers : positions of its points
    run : computes the points at some positions; their block, row by row, and the time, s
    at_once : how many points that are
    levels : the coarse lattice, then each time that it is halved
    """

    maps: Maps
    numbers: Numbers
    run: Run
    at_once: int
    levels: list[Level] = field(default_factory=list)
    stored: int = 0

    def until(self, end: float) -> None:
        """Draw it, until it is done or the clock shows `end`."""
        depth, shape = self.maps.refinement.levels, self.numbers.shape
        classes, known = np.full(shape, BLANK, np.int32), np.zeros(shape, bool)
        picture = draw(classes, known, depth)
        while not picture.complete and time.monotonic() < end:
            if len(self.levels) <= picture.level + known.any():
                self.levels.append(Level())
            new = np.flatnonzero(picture.wanted & ~known)
            self.levels[-1].wanted += len(new)
            np.random.default_rng(0).shuffle(new)
            for first in range(0, len(new), self.at_once):
                if time.monotonic() < end:
                    places = new[first : first + self.at_once]
                    classes.ravel()[places] = self._classes(self.numbers.ravel()[places])
                    known.ravel()[places] = True
            picture = draw(classes, known, depth)

    def _classes(self, positions: Numbers) -> Classes:
        block, seconds = self.run(positions.tolist())
        level = self.levels[-1]
        level.run, level.seconds = level.run + len(positions), level.seconds + seconds
        self.stored += block.nbytes
        return self.maps.classes_of(block)

    def cost(self) -> Cost:
        """Of the whole map, its last levels growing as those before them."""
        plane, lattice = 2.0 ** (self.numbers.ndim - 1), 2.0**self.numbers.ndim
        last, to_come = self.levels[-1], self.maps.refinement.levels + 1 - len(self.levels)
        seen = last.wanted / self.levels[-2].wanted if len(self.levels) > 2 else lattice
        known = sum(level.wanted for level in self.levels)
        growths = plane, min(max(seen, plane), lattice)
        beyond = [sum(last.wanted * by**n for n in range(1, to_come + 1)) for by in growths]
        low, high = (min(known + more + self._again, self.numbers.size) for more in beyond)
        seconds = sum(level.wanted * level.of_a_point for level in self.levels)
        least, most = (seconds + (one - known) * last.of_a_point for one in (low, high))
        return Cost((low, high), (least, most))

    @property
    def _again(self) -> int:
        """How many points are run although their class is filled in."""
        given = self.maps.refinement.sample
        return USUAL_SAMPLE if given is None else given
