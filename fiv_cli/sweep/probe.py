"""Points that are run for what they take, in a process that is ended where they take too long.

It is forked: so it has all code that is loaded here, and begins in milliseconds. The system ends
it, in compiled code also. What is told is processor time, as others may use this machine too.
"""

from __future__ import annotations

import gc
import multiprocessing
import os
import resource
import signal
import time
from contextlib import suppress
from dataclasses import dataclass, replace
from math import inf
from multiprocessing.connection import Connection
from multiprocessing.process import BaseProcess
from typing import Any, NamedTuple

from fiv_cli import ending
from fiv_cli.analyses import get_analysis
from fiv_cli.flags import STATUS
from fiv_cli.sweep.requests import Template
from fiv_cli.sweep.worker import Result, Task, initialise, run_task

FEW_STEPS = 100_000
"""Steps of a task that was given up, which say what all that it may take would cost."""

PARTS = (1e-3, 1e-2, 1e-1)
"""Shares of the time of its motions, likewise, ..."""

TELLING = 0.1
"""... up to the first that takes this share of what a task may."""

WAITING = 20.0
"""Times the limit, which is processor time, for which others may keep a task waiting."""

SPENT = 0.5
"""Share of the limit that a process has spent at least that was ended for it."""


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
    """Runs tasks, each for at most `limit` seconds.

    Attributes
    ----------
    most : seconds that no point of a run takes more than
    guess : what one that is given up is taken for at most, where neither time nor steps bound it
    """

    limit: float
    most: float = inf
    guess: float = inf
    _spent: float = 0.0
    _known: Template | None = None  # of the last task: of many starts it is large
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
        found = self._answer(task, share * self.limit)
        if isinstance(found, float):
            points = sum(len(segment.values) for segment in task.segments)
            by_steps, nbytes = self._first_steps(task, max(1000, FEW_STEPS // points))
            bound = min(by_steps, self._parts(task))
            longest = min(points * self.most, bound if bound < inf else points * self.guess)
            return Tried(None, found, max(found, longest), nbytes)
        result, seconds = found
        return Tried(result, seconds, seconds, result.block.nbytes)

    def _first_steps(self, task: Task, few: int) -> tuple[float, int]:
        """What a task takes if all its points make all steps that they may, s, and its bytes."""
        solver = task.template.solver
        template = replace(task.template, solver=replace(solver, max_steps=few))
        found = self._answer(replace(task, template=template), self.limit)
        if isinstance(found, float):
            return inf, 0
        block = found[0].block
        is_told = (block.status == STATUS.codes["budget"]).any()
        return found[1] * solver.max_steps / few if is_told else inf, block.nbytes

    def _parts(self, task: Task) -> float:
        """What a task takes if all its motions take all their time, s."""
        longest = inf
        for share in PARTS if get_analysis(task.template.analysis).spans else ():
            found = self._answer(replace(task, template=part_of(task.template, share)), self.limit)
            if isinstance(found, float) or not is_answered(found[0]):
                break
            longest = found[1] / share
            if found[1] > TELLING * self.limit:
                break
        return longest

    def _answer(self, task: Task, limit: float) -> tuple[Result, float] | float:
        """What a task gives, and its processor time, s; the time alone: it was ended.

        One that ended for anything but its own time, as others kept it waiting, is begun once more;
        so is one whose time was up before that was spent, by a clock that goes in ticks.
        """
        for _ in range(2):
            pipe, before = self._begun() if self._pipe is None else self._pipe, self._spent
            with suppress(EOFError, ConnectionError):
                same = task.template is self._known
                pipe.send((None if same else task.template, task.variables, task.segments, limit))
                self._known = task.template
                result, seconds, self._spent = pipe.recv()
                return result, seconds
            spent, reason = self._end()
            if reason == -signal.SIGPROF and spent - before > SPENT * limit:
                break
        return min(limit, spent - before)

    def _begun(self) -> Connection:
        import scipy.optimize  # noqa: F401  which points load: a process that is ended did in vain

        context = multiprocessing.get_context("fork")
        self._pipe, theirs = context.Pipe()
        with ending.starting():
            self._process = context.Process(
                target=_serve, args=(theirs, self._pipe, os.getpid()), daemon=True
            )
            self._process.start()
        theirs.close()
        return self._pipe

    def _end(self) -> tuple[float, int | None]:
        """End the process; its processor time, s, and with what code it had ended before."""
        before, code = _of_children(), None
        if self._process is not None and self._pipe is not None:
            self._process.kill()
            self._process.join()
            self._pipe.close()
            code = self._process.exitcode
        self._process = self._pipe = self._known = None
        self._spent = 0.0
        return _of_children() - before, code


def part_of(template: Template, share: float) -> Template:
    """Motions for a share of their time."""
    spans = get_analysis(template.analysis).spans
    given = {name: template.settings[name] for name in spans}
    short = {name: share * span for name, span in given.items() if span is not None}
    return replace(template, settings={**template.settings, **short})


def is_answered(result: Result) -> bool:
    """Whether no point of it failed, nor met a limit."""
    return bool((result.block.status == STATUS.codes["ok"]).all())


def _of_children() -> float:
    """Processor time of the processes that have ended, s."""
    spent = resource.getrusage(resource.RUSAGE_CHILDREN)
    return spent.ru_utime + spent.ru_stime


def _serve(pipe: Connection, theirs: Connection, parent: int) -> None:
    """Run what comes; SIGPROF and SIGALRM keep their default action, which ends the process.

    The time in which a task is sent is no part of what its points take: a run sends many at once.
    """
    known: Any = None
    theirs.close()
    signal.set_wakeup_fd(-1)
    signal.signal(signal.SIGTERM, signal.SIG_DFL)
    initialise(parent, *gc.get_threshold())
    with suppress(EOFError, ConnectionError, ending.Ended):  # the parent is ending, or was about to
        while True:
            template, variables, segments, limit = pipe.recv()
            known = template or known
            begun, began = time.process_time(), time.perf_counter()
            signal.setitimer(signal.ITIMER_PROF, limit)
            signal.setitimer(signal.ITIMER_REAL, WAITING * limit)
            result = run_task(Task(known, variables, segments))
            signal.setitimer(signal.ITIMER_PROF, 0.0)
            signal.setitimer(signal.ITIMER_REAL, 0.0)
            ended, took = time.process_time(), time.perf_counter() - began
            spent = ended - begun or took  # less than a tick of the processor's clock is none
            pipe.send((result, spent, ended))
