"""A refined analysis: which points of its finest lattice are run, and what the others are given.

Each start and each combination of the axes that are not halved is a map of its own, refined along
its own borders (see `borders`). A chain goes through several maps, and is run whole where any of
them asks for a point of it. What decides is the stored results alone, and of these only the
points that the refinement itself asks for: how often a run was interrupted, or what else the store
holds, changes nothing. The points are those of the full grid, with the same keys, so a run of the
full grid goes on from a refined one.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fiv_cli.case.case import Refinement
from fiv_cli.case.refinement import coarse_size
from fiv_cli.data.block import Block, fill_value
from fiv_cli.data.layout import Layout
from fiv_cli.data.refined import described, refinement_attributes
from fiv_cli.flags import COMPUTED
from fiv_cli.sweep.borders import BLANK, Classes, Mask, draw, sample

USUAL_SAMPLE = 100
"""Points of a large map that are run although their class was filled in."""

Numbers = NDArray[np.int64]


@dataclass(frozen=True)
class Stage:
    """How far a refined analysis has come; all arrays by position.

    Attributes
    ----------
    classes, known : (size,) class of each point, where it has a result
    wanted : (size,) points to run, those that have been run included
    sampled : (size,) those of them whose class was filled in before they were run
    drawn : (size,) class of each point by the borders; valid when `complete`
    complete : nothing more is to be run
    level : how often every map is halved so far
    """

    classes: Classes
    known: Mask
    wanted: Mask
    sampled: Mask
    drawn: Classes
    complete: bool
    level: int

    @property
    def filled(self) -> Mask:
        """(size,) points that are given a class without a run; none before all is drawn."""
        return ~self.wanted if self.complete else np.zeros_like(self.wanted)

    def origins(self) -> NDArray[np.int8]:
        """(size,) codes of `COMPUTED`: where the class of each point comes from."""
        told = self.sampled & self.known & (self.classes != BLANK) & (self.drawn != BLANK)
        origins = np.full(self.wanted.shape, COMPUTED.fill_code, np.int8)
        origins[self.filled] = COMPUTED.codes["filled_in"]
        origins[self.wanted & self.known] = COMPUTED.codes["run"]
        origins[told] = COMPUTED.codes["sampled"]
        origins[told & (self.classes != self.drawn)] = COMPUTED.codes["sampled_and_mislabelled"]
        return origins

    def filled_classes(self, fill: int) -> Classes:
        """(size,) class of each point by the borders, `fill` where there is none around it."""
        return np.where(self.drawn == BLANK, np.int32(fill), self.drawn)


@dataclass(frozen=True)
class Maps:
    """The points of a refined analysis as maps that are drawn one by one.

    Attributes
    ----------
    refinement : how they are drawn
    numbers : positions of the points, shape (maps, points along each halved dim ...)
    coarse : dim -> points of the coarse grid along it
    fill : the class of a point that has none
    """

    refinement: Refinement
    numbers: Numbers
    coarse: Mapping[str, int]
    fill: int

    def classes_of(self, block: Block) -> Classes:
        """The class of each row of a block."""
        nothing = np.full(len(block), self.fill, np.int32)
        return block.values.get(self.refinement.of, nothing)

    def attributes(self, stage: Stage) -> dict[str, Any]:
        """What a reader must know of the dataset."""
        refinement = self.refinement
        return refinement_attributes(refinement.of, refinement.levels, self.coarse, stage.origins())

    def described(self, stage: Stage) -> str:
        """How much was run, in a sentence."""
        if stage.complete:
            return described(self.attributes(stage))
        return (
            f"halved {stage.level} of {self.refinement.levels} times so far; "
            "more points are to be run as its borders are found"
        )

    def stage(self, classes: Classes, known: Mask, chains: Iterable[Numbers] = ()) -> Stage:
        """How far the maps have come.

        Parameters
        ----------
        classes : (size,) class of each point, where known
        known : (size,) points with a stored result
        chains : positions of the points of chains, shape (chains, points of each)
        """
        size, levels = self.numbers.size, self.refinement.levels
        wanted, sampled = np.zeros(size, bool), np.zeros(size, bool)
        drawn = classes.copy()
        reached = levels
        for numbers in self.numbers:
            picture = draw(classes[numbers], known[numbers], levels)
            wanted[numbers] = picture.wanted
            drawn[numbers] = picture.classes
            reached = min(reached, picture.level)
            if picture.complete:
                sampled[numbers] = self._sample(~picture.wanted)
        wanted |= sampled
        for numbers in chains:
            wanted[numbers] |= wanted[numbers].any(axis=1, keepdims=True)
        complete = not (wanted & ~known).any()
        return Stage(classes, known, wanted, sampled, drawn, complete, reached)

    def _sample(self, filled: Mask) -> Mask:
        count = self.refinement.sample
        if count is None:
            count = min(USUAL_SAMPLE, int(np.count_nonzero(filled)) // 10)
        return sample(filled, count, self.refinement.seed)


def maps_of(layout: Layout, refinement: Refinement) -> Maps | None:
    """The maps of an analysis; None where none of its axes is halved, or it has no such class."""
    told = [one for one in layout.variables if one.name == refinement.of and one.is_class]
    places = [
        place
        for place, dim in enumerate(layout.dims)
        if dim.size > 1 and all(axis.name in refinement.axes for axis in dim.axes)
    ]
    if not (places and told):
        return None
    numbers = np.moveaxis(
        np.arange(layout.size).reshape(layout.shape), places, range(-len(places), 0)
    )
    halved = [layout.dims[place] for place in places]
    return Maps(
        refinement,
        numbers.reshape(-1, *(dim.size for dim in halved)),
        {dim.name: coarse_size(dim.size, refinement.levels) for dim in halved},
        int(fill_value(told[0])),
    )
