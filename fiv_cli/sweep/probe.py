"""Points that are run for what they take, in a process that is ended where they take too long.

It is forked: so it has all code that is loaded here, and begins in milliseconds. What limits it is
its processor time, as others may use this machine too; the system ends it, in compiled code also.
"""

from __future__ import annotations

import gc
import multiprocessing
import os
import signal
import time
from contextlib import suppress
from dataclasses import dataclass, replace
from math import inf
from multiprocessing.connection import Connection
from multiprocessing.process import BaseProcess
from typing import NamedTuple

from fiv_cli import ending
from fiv_cli.flags import STATUS
from fiv_cli.sweep.worker import Result, Task, initialise, run_task

FEW_STEPS = 100_000
"""Steps of a point that was given up, which say what all that it may take would cost."""


class Tried(NamedTuple):
    """What came of a task.

    Attributes
    ----------
    result : None where it was given up
    least, most : processor time of it all, s
    nbytes : that its results take; where it was given up, as those of its first steps
    """

    result: Result | None
    least: float
    most: float
    nbytes: int


@dataclass
class Probe:
    """Runs tasks, each for at most `limit` seconds; no point of a run takes more than `most`."""

    limit: float
    most: float = inf
    _process: BaseProcess | None = None
    _pipe: Connection | None = None

    def __enter__(self) -> Probe:
        return self

    def __exit__(self, *exception: object) -> None:
        self._end()

    def run(self, task: Task, share: float = 1.0) -> Tried:
        """What a task gives and takes; of one that is given up, at most what its steps may.

        share : of the limit, after which this one is given up
        """
        ending.heed()
        limit = share * self.limit
        found = self._answer(task, limit)
        if found is not None:
            return Tried(*found, found[1], found[0].block.nbytes)
        points = sum(len(segment.values) for segment in task.segments)
        longest, nbytes = self._first_steps(task)
        most = points * min(self.most, longest)
        return Tried(None, limit, max(limit, most), points * nbytes)

    def _first_steps(self, task: Task) -> tuple[float, int]:
        """What the first point takes if it makes all steps that it may, s, and its bytes."""
        first, solver = task.segments[0], task.template.solver
        few = replace(task.template, solver=replace(solver, max_steps=FEW_STEPS))
        alone = replace(first, values=first.values[:1])
        found = self._answer(replace(task, template=few, segments=(alone,)), self.limit)
        if found is None or found[0].block.status[0] != STATUS.codes["budget"]:
            return inf, 0 if found is None else found[0].block.nbytes
        return found[1] * solver.max_steps / FEW_STEPS, found[0].block.nbytes

    def _answer(self, task: Task, limit: float) -> tuple[Result, float] | None:
        """What a task gives, and its processor time, s; None: it was ended after `limit`."""
        pipe = self._begun() if self._pipe is None else self._pipe
        with suppress(EOFError, ConnectionError):
            pipe.send((task, limit))
            answer: tuple[Result, float] = pipe.recv()
            return answer
        self._end()
        return None

    def _begun(self) -> Connection:
        context = multiprocessing.get_context("fork")
        self._pipe, theirs = context.Pipe()
        with ending.starting():
            self._process = context.Process(
                target=_serve, args=(theirs, self._pipe, os.getpid()), daemon=True
            )
            self._process.start()
        theirs.close()
        return self._pipe

    def _end(self) -> None:
        if self._process is not None and self._pipe is not None:
            self._process.kill()
            self._process.join()
            self._pipe.close()
        self._process = self._pipe = None


def _serve(pipe: Connection, theirs: Connection, parent: int) -> None:
    """Run what comes; SIGPROF keeps its default action, which ends the process."""
    theirs.close()
    signal.set_wakeup_fd(-1)
    signal.signal(signal.SIGTERM, signal.SIG_DFL)
    initialise(parent, *gc.get_threshold())
    with suppress(EOFError, ConnectionError, ending.Ended):  # the parent is ending, or was about to
        while True:
            task, limit = pipe.recv()
            signal.setitimer(signal.ITIMER_PROF, limit)
            begun = time.process_time()
            result = run_task(task)
            seconds = time.process_time() - begun
            signal.setitimer(signal.ITIMER_PROF, 0.0)
            pipe.send((result, seconds))
