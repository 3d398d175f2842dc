"""What is left to run, handed out as tasks.

Two kinds of work: points that start on their own, and chains, of which only the next piece can run.
The former are taken from all over the grid, so that what is there early shows the whole of it, and
its rate tells how long the rest will take, though one corner be slow. After a worker died the
points that may be to blame are run alone.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fiv_cli.sweep.journal import Record
from fiv_cli.sweep.plan import AnalysisPlan, ChainSet
from fiv_cli.sweep.worker import ChainState, Result, Segment, Task

Positions = NDArray[np.int64]

TOGETHER, RUNS = 16, 64  # points that stay together, at most, and runs of such, at least
GOLDEN = (math.sqrt(5.0) - 1.0) / 2.0


@dataclass(slots=True)
class Cursor:
    """How far a chain has come.

    Attributes
    ----------
    positions : its points, in the order in which they are visited
    leg : of so many points each has one start; the next leg begins where the one before ends
    offset : the next point
    state : what the point before left; None at the beginning
    previous : key of the point before
    alone : offsets of points that are run in a task of their own
    """

    positions: Positions
    leg: int
    offset: int = 0
    state: ChainState | None = None
    previous: bytes = b""
    alone: frozenset[int] = frozenset()

    @property
    def is_alone(self) -> bool:
        """Whether the next point is run in a task of its own."""
        return self.offset in self.alone

    def stop(self, count: int) -> int:
        """Offset at which the next piece of at most `count` points ends."""
        if self.is_alone:
            return self.offset + 1
        end = min(self.offset + count, (self.offset // self.leg + 1) * self.leg)
        return min([end, *(cut for cut in self.alone if cut > self.offset)])


@dataclass
class Job:
    """A task under way, and what must be known when it ends.

    Attributes
    ----------
    positions : position of each row of the task
    pieces : the chains that it goes on with, each by how many points; none of points that start
        on their own
    alone : nothing else may run beside it: it is one point that may have ended a worker
    """

    task: Task
    positions: Positions
    pieces: tuple[tuple[Cursor, int], ...] = ()
    alone: bool = False


class Queue:
    """The work that is left of one analysis."""

    def __init__(
        self,
        analysis: AnalysisPlan,
        record: Record,
        executor: str,
        time_limit: float | None = None,
    ) -> None:
        self._analysis = analysis
        self._variables = analysis.layout.variables
        self._executor = executor
        self._time_limit = time_limit
        done = record.done() | ~record.wanted()
        singles = analysis.single_positions()
        self._singles: deque[Positions] = deque([spread(singles[~done[singles]])])
        self._suspects: deque[int] = deque()
        self._cursors = deque(
            cursor
            for chains in analysis.chain_sets()
            for cursor in _cursors(analysis, chains, record, done)
        )
        self.left = int(sum(map(len, self._singles))) + sum(
            len(cursor.positions) - cursor.offset for cursor in self._cursors
        )

    def next_job(self, count: int) -> Job | None:
        """A job of at most `count` points; None when nothing can be started now."""
        if self._suspects:
            return self._single_job(np.array([self._suspects.popleft()]), alone=True)
        if self._cursors:
            return self._chain_job(count)
        while self._singles and not len(self._singles[0]):
            self._singles.popleft()
        if not self._singles:
            return None
        first = self._singles[0]
        self._singles[0] = first[count:]
        return self._single_job(first[:count])

    def finished(self, job: Job, result: Result) -> None:
        """Take note that a job has ended; the rest of its chains can run now."""
        self.left -= len(job.positions)
        end = 0
        for number, (cursor, count) in enumerate(job.pieces):
            end += count
            cursor.offset += count
            cursor.state = result.states[number]
            cursor.previous = result.block.keys[end - 1].tobytes()
            if cursor.offset < len(cursor.positions):
                self._cursors.append(cursor)

    def lost(self, job: Job, row: int | None) -> None:
        """Take a job back whose worker died while it ran `row` (None: before or after)."""
        if job.pieces:
            self._cursors.extendleft(cursor for cursor, _ in reversed(job.pieces))
            if row is not None:
                _suspect(job.pieces, row)
        elif row is None:
            self._singles.appendleft(job.positions)
        else:
            self._suspects.append(int(job.positions[row]))
            self._singles.appendleft(np.delete(job.positions, row))

    def _single_job(self, positions: Positions, alone: bool = False) -> Job:
        points = self._analysis.points(positions)
        segments = tuple(Segment((values,), entry) for values, entry in points)
        return Job(self._task(segments), positions, alone=alone)

    def _chain_job(self, count: int) -> Job:
        """The next pieces of as many chains as `count` points allow for."""
        alone = self._cursors[0].is_alone
        pieces: list[tuple[Cursor, int]] = []
        ran: list[Positions] = []
        while count > 0 and self._cursors and not (ran and (alone or self._cursors[0].is_alone)):
            cursor = self._cursors.popleft()
            ran.append(cursor.positions[cursor.offset : cursor.stop(count)])
            pieces.append((cursor, len(ran[-1])))
            count -= len(ran[-1])
        segments = tuple(
            self._segment(cursor, positions)
            for (cursor, _), positions in zip(pieces, ran, strict=True)
        )
        return Job(self._task(segments), np.concatenate(ran), tuple(pieces), alone)

    def _segment(self, cursor: Cursor, positions: Positions) -> Segment:
        values, entries = zip(*self._analysis.points(positions), strict=True)
        return Segment(values, entries[0], cursor.state, cursor.previous)

    def _task(self, segments: tuple[Segment, ...]) -> Task:
        return Task(
            self._analysis.template,
            self._variables,
            segments,
            self._executor,
            self._time_limit,
        )


def _suspect(pieces: Iterable[tuple[Cursor, int]], row: int) -> None:
    """Of the points of these chains run the one alone that stands in this row."""
    for cursor, count in pieces:
        if row < count:
            cursor.alone |= {cursor.offset + row}
            return
        row -= count


def spread(positions: Positions) -> Positions:
    """The same, in an order of which each beginning is spread evenly over all of them.

    That is by the multiples of the golden ratio, less what is whole of them (Weyl). Neighbours, as
    the starts of one set of parameters, stay together: they share what these have been asked for.
    """
    together = max(1, min(TOGETHER, positions.size // RUNS))
    runs = np.arange(positions.size) // together
    return positions[np.argsort(runs * GOLDEN % 1.0, kind="stable")]


def _cursors(
    analysis: AnalysisPlan, chains: ChainSet, record: Record, done: NDArray[np.bool_]
) -> Iterable[Cursor]:
    """The chains that are not finished, each where it can go on."""
    for positions in chains.positions:
        stored = done[positions]
        prefix = len(positions) if stored.all() else int(np.argmin(stored))
        if prefix < len(positions):
            yield _resumed(analysis, Cursor(positions, chains.leg), record, prefix)


def _resumed(analysis: AnalysisPlan, cursor: Cursor, record: Record, prefix: int) -> Cursor:
    """`cursor` behind the last point of its finished beginning whose state is stored."""
    for offset in range(prefix, 0, -1):
        state = record.states.get(int(cursor.positions[offset - 1]))
        if state is not None:
            cursor.offset, cursor.state = offset, state
            cursor.previous = analysis.chain_key(cursor.positions[:offset])
            break
    return cursor
