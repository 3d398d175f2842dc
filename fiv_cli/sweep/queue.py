"""What is left to run, handed out as tasks.

Two kinds of work: points that start on their own, taken in order, and chains, of which only the
next piece can run. After a worker died the points that may be to blame are run alone.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Iterable
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from fiv_cli.sweep.journal import Record
from fiv_cli.sweep.plan import AnalysisPlan, ChainSet
from fiv_cli.sweep.worker import ChainState, Result, Segment, Task

Positions = NDArray[np.int64]


@dataclass
class Cursor:
    """How far a chain has come.

    Attributes
    ----------
    entry : index of its start
    positions : its points, in the order in which they are visited
    offset : the next point
    state : what the point before left; None at the beginning
    previous : key of the point before
    alone : offsets of points that are run in a task of their own
    """

    entry: int
    positions: Positions
    offset: int = 0
    state: ChainState | None = None
    previous: bytes = b""
    alone: set[int] = field(default_factory=set)

    def stop(self, count: int) -> int:
        """Offset at which the next piece of at most `count` points ends."""
        if self.offset in self.alone:
            return self.offset + 1
        end = min(self.offset + count, len(self.positions))
        return min([end, *(cut for cut in self.alone if cut > self.offset)])


@dataclass
class Job:
    """A task under way, and what must be known when it ends.

    Attributes
    ----------
    positions : position of each row of the task
    cursor : the chain it belongs to; None for points that start on their own
    alone : nothing else may run beside it: it is one point that may have ended a worker
    """

    task: Task
    positions: Positions
    cursor: Cursor | None = None
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
        self._singles: deque[Positions] = deque([singles[~done[singles]]])
        self._suspects: deque[int] = deque()
        self._cursors = deque(
            cursor
            for chains in analysis.chain_sets()
            for cursor in _cursors(analysis, chains, record, done)
        )
        self.left = int(sum(map(len, self._singles))) + sum(
            len(cursor.positions) - cursor.offset for cursor in self._cursors
        )

    def next_job(self, count: int, heartbeat: Path | None = None) -> Job | None:
        """A job of at most `count` points; None when nothing can be started now."""
        if self._suspects:
            return self._single_job(np.array([self._suspects.popleft()]), heartbeat, alone=True)
        if self._cursors:
            return self._chain_job(self._cursors.popleft(), count, heartbeat)
        while self._singles and not len(self._singles[0]):
            self._singles.popleft()
        if not self._singles:
            return None
        first = self._singles[0]
        self._singles[0] = first[count:]
        return self._single_job(first[:count], heartbeat)

    def finished(self, job: Job, result: Result) -> None:
        """Take note that a job has ended; the rest of its chain can run now."""
        self.left -= len(job.positions)
        cursor = job.cursor
        if cursor is None:
            return
        cursor.offset += len(job.positions)
        cursor.state = result.states[0]
        cursor.previous = result.block.keys[-1].tobytes()
        if cursor.offset < len(cursor.positions):
            self._cursors.append(cursor)

    def lost(self, job: Job, row: int | None) -> None:
        """Take a job back whose worker died while it ran `row` (None: before or after)."""
        if job.cursor is not None:
            if row is not None:
                job.cursor.alone.add(job.cursor.offset + row)
            self._cursors.appendleft(job.cursor)
        elif row is None:
            self._singles.appendleft(job.positions)
        else:
            self._suspects.append(int(job.positions[row]))
            self._singles.appendleft(np.delete(job.positions, row))

    def _single_job(self, positions: Positions, heartbeat: Path | None, alone: bool = False) -> Job:
        points = self._analysis.points(positions)
        segments = tuple(Segment((values,), entry) for values, entry in points)
        return Job(self._task(segments, heartbeat), positions, alone=alone)

    def _chain_job(self, cursor: Cursor, count: int, heartbeat: Path | None) -> Job:
        positions = cursor.positions[cursor.offset : cursor.stop(count)]
        values = tuple(values for values, _ in self._analysis.points(positions))
        segment = Segment(values, cursor.entry, cursor.state, cursor.previous)
        alone = cursor.offset in cursor.alone
        return Job(self._task((segment,), heartbeat), positions, cursor, alone)

    def _task(self, segments: tuple[Segment, ...], heartbeat: Path | None) -> Task:
        return Task(
            self._analysis.template,
            self._variables,
            segments,
            self._executor,
            self._time_limit,
            heartbeat,
        )


def _cursors(
    analysis: AnalysisPlan, chains: ChainSet, record: Record, done: NDArray[np.bool_]
) -> Iterable[Cursor]:
    """The chains that are not finished, each where it can go on."""
    for positions in chains.positions:
        stored = done[positions]
        prefix = len(positions) if stored.all() else int(np.argmin(stored))
        if prefix < len(positions):
            yield _resumed(analysis, Cursor(chains.entry, positions), record, prefix)


def _resumed(analysis: AnalysisPlan, cursor: Cursor, record: Record, prefix: int) -> Cursor:
    """`cursor` behind the last point of its finished beginning whose state is stored."""
    for offset in range(prefix, 0, -1):
        state = record.states.get(int(cursor.positions[offset - 1]))
        if state is not None:
            cursor.offset, cursor.state = offset, state
            cursor.previous = analysis.chain_key(cursor.positions[:offset])
            break
    return cursor
