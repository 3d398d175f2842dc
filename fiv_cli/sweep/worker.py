"""What a worker process does: run the points of a task and return them as one block.

Values never depend on how points are packed into tasks: a task only says which points to run,
and a point of a chain is given exactly what its neighbour left.
"""

from __future__ import annotations

import contextlib
import ctypes
import gc
import importlib
import os
import signal
import sys
import time
import traceback
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from itertools import chain, islice
from pathlib import Path
from typing import Any

from fiv_cli import ending
from fiv_cli.analyses import get_analysis
from fiv_cli.analyses.base import AT_ONCE, Batch, Outcome, Request, Start
from fiv_cli.analyses.catalogue import variables_of
from fiv_cli.analyses.variables import Variable
from fiv_cli.data.block import Block, pack
from fiv_cli.data.states import on_all_states
from fiv_cli.flags import REASONS, STATUS
from fiv_cli.own.load import know
from fiv_cli.sweep.chain import Chain, ChainState, state_after
from fiv_cli.sweep.requests import (
    StartEntry,
    Template,
    Values,
    exclusion,
    is_shared,
    point_key,
    request_at,
    resolve_start,
    shared_setup,
)

EXECUTOR = "fiv_cli.analyses.execute:execute"
EXECUTOR_OF_BLOCKS = "fiv_cli.analyses.execute:execute_all"

BLOCK_SECONDS = 0.1
"""That points which are run at once may take: no more is lost sight of."""

_PR_SET_PDEATHSIG = 1
_KEPT = (-3, 32 * 2**20), (-1, 128 * 2**20)  # M_MMAP_THRESHOLD and M_TRIM_THRESHOLD of mallopt


@dataclass(frozen=True)
class Segment:
    """Points that are run one after the other: a piece of a chain, or a single point.

    Attributes
    ----------
    values : axis values of each point
    entry : index of the start
    state : what the point before left; None at the beginning of a chain
    previous : key of the point before; empty at the beginning
    """

    values: tuple[Values, ...]
    entry: int
    state: ChainState | None = None
    previous: bytes = b""


@dataclass(frozen=True)
class Task:
    """Points for one worker to run.

    Attributes
    ----------
    template : what they share
    variables : the table of their variables
    segments : the points
    executor : ``module:function`` that turns a `Request` into an `Outcome`
    time_limit : wall-clock limit of a point, s; the worker dies when it is passed
    heartbeat : file into which the row being run is written; None in the parent's own process
    """

    template: Template
    variables: tuple[Variable, ...]
    segments: tuple[Segment, ...]
    executor: str = EXECUTOR
    time_limit: float | None = None
    heartbeat: Path | None = None


@dataclass
class Result:
    """What came of a task.

    Attributes
    ----------
    block : the outcomes, row by row in the order of the task
    seconds : time the points took
    longest : the row that took longest, and how long, s
    states : segment number -> state after its last point, for segments of chains
    """

    block: Block
    seconds: float
    longest: tuple[int, float] = (0, 0.0)
    states: dict[int, ChainState] = field(default_factory=dict)

    def failures(self) -> Counter[str]:
        """Reasons for which points failed, and of how many."""
        codes = self.block.reason[self.block.status == STATUS.codes["failed"]]
        return Counter(REASONS[code].name for code in codes.tolist())


def run_task(task: Task) -> Result:
    """Run every point of a task."""
    begun = time.perf_counter()
    know(task.template.own)
    execute = imported(task.executor)
    outcomes: list[Outcome] = []
    keys: list[bytes] = []
    states: dict[int, ChainState] = {}
    carries: dict[int, dict[str, Any]] = {}
    points = list(_points(task))
    batches = _batches(task, points)
    with _Pulse(task) as pulse:
        if _is_run_in_blocks(task):
            outcomes = list(_run_in_blocks(task.template, batches, pulse))
            keys = [point_key(task.template, *point) for point in points]
        coming = chain.from_iterable(batches)
        for number, segment in enumerate(() if outcomes else task.segments):
            ran = list(_run_segment(task.template, segment, coming, execute, pulse))
            outcomes += [outcome for outcome, _, _ in ran]
            keys += [key for _, key, _ in ran]
            last = ran[-1][2]
            if last is not None:
                states[number] = last
                carries[len(outcomes) - 1] = last.plain()
    block = pack(outcomes, keys, task.variables, carries)
    seconds = time.perf_counter() - begun
    block.seconds[:] = seconds / len(block)
    return Result(block, seconds, pulse.longest, states)


def _is_run_in_blocks(task: Task) -> bool:
    """Whether points can be run at once: no chains, no limit to the time of each."""
    begun = (task.template.entries[place] for place in {one.entry for one in task.segments})
    alone = all(entry is None or entry.spec.kind != "continue" for entry in begun)
    in_blocks = get_analysis(task.template.analysis).in_blocks
    return alone and in_blocks and task.executor == EXECUTOR and task.time_limit is None


def _points(task: Task) -> Iterator[tuple[Values, StartEntry | None]]:
    """The points of a task, each with its start."""
    for segment in task.segments:
        entry = task.template.entries[segment.entry]
        yield from ((values, entry) for values in segment.values)


def _batches(
    task: Task, points: Iterable[tuple[Values, StartEntry | None]]
) -> Iterator[list[Request]]:
    """The points of a task, a batch at a time; those on chains without starts."""
    template, shared, points = task.template, _shared_starts(task), iter(points)
    setup = shared_setup(template, task.segments[0].values[0])
    while some := list(islice(points, AT_ONCE)):
        requests: list[Request] = []
        batch = Batch(requests)
        for values, entry in some:
            start = None
            if entry is not None and entry.spec.kind != "continue":
                start = shared.get(entry.label) or resolve_start(template, values, entry)
            requests.append(request_at(template, values, start, batch, setup))
        yield requests


def _shared_starts(task: Task) -> dict[str, Start]:
    """Label -> start, of those that are the same at all points."""
    template, first = task.template, task.segments[0].values[0]
    return {
        entry.label: resolve_start(template, first, entry)
        for entry in template.entries
        if entry is not None and is_shared(template, entry)
    }


def _run_in_blocks(
    template: Template, batches: Iterable[Sequence[Request]], pulse: _Pulse
) -> Iterator[Outcome]:
    """Outcomes of points that begin on their own.

    Those without motions all at once, as they cost the less together; motions that end at a time
    as many as take a short time; others are set out at once, and run one after the other.
    """
    execute = imported(EXECUTOR_OF_BLOCKS)
    ends = get_analysis(template.analysis).recorded
    count = least = 1 if ends else AT_ONCE
    for batch in batches:
        begin = 0
        while block := batch[begin : begin + count]:
            begun = time.perf_counter()
            together = len(block) if ends or template.linear else 1
            yield from _outcomes_of(template, block, execute, pulse, together)
            begin += len(block)
            share = BLOCK_SECONDS / (time.perf_counter() - begun)
            count = max(least, min(AT_ONCE, int(share * len(block))))


def _outcomes_of(
    template: Template,
    requests: Sequence[Request],
    execute: Callable[[Sequence[Request]], Iterator[Outcome]],
    pulse: _Pulse,
    together: int,
) -> list[Outcome]:
    """Outcomes of a block; so many are run `together`."""
    refused = [_refusal(request, template) for request in requests]
    asked = zip(requests, refused, strict=True)
    found = execute([request for request, refusal in asked if refusal is None])
    outcomes = []
    for row, refusal in enumerate(refused):
        if row % together == 0:
            ending.heed()
            pulse.beat(together)
        outcomes.append(refusal or next(found))
    next(found, None)  # which fills the columns that are read now
    return [_placed(*one, template) for one in zip(outcomes, requests, strict=True)]


def _internal_error(error: Exception) -> Outcome:
    message = f"{type(error).__name__}: {error}\n{traceback.format_exc()}"
    return Outcome("failed", "internal_error", message=message)


def lost_point(task: Task, reason: str, message: str) -> Result:
    """The result of a one-point task that cannot be run: a failed point."""
    (segment,) = task.segments
    entry = task.template.entries[segment.entry]
    key = point_key(task.template, segment.values[0], entry, segment.previous)
    outcome = Outcome("failed", reason, message=message)
    state = None
    if entry is not None and entry.spec.kind == "continue":
        state = state_after(outcome, segment.values[0], segment.state, entry)
    carries = {} if state is None else {0: state.plain()}
    states = {} if state is None else {0: state}
    return Result(pack([outcome], [key], task.variables, carries), 0.0, states=states)


def keep_memory() -> None:
    """Have this process take again what memory it has freed.

    The system hands out pages one by one as they are touched, which takes longer than to fill them.
    """
    if sys.platform == "linux":
        for limit in _KEPT:
            ctypes.CDLL(None).mallopt(*limit)


def initialise(parent: int, *thresholds: int) -> None:
    """Prepare a worker process: it must not outlive its parent, which heeds what asks for an end.

    It looks for garbage at the parent's `thresholds`.

    Until here such signals were blocked (see `ending.starting`).
    """
    keep_memory()
    gc.set_threshold(*thresholds)
    for number in (signal.SIGINT, signal.SIGHUP):  # a terminal sends them to all its processes
        signal.signal(number, signal.SIG_IGN)
    signal.pthread_sigmask(signal.SIG_UNBLOCK, ending.NAMES)
    if sys.platform == "linux":
        ctypes.CDLL(None).prctl(_PR_SET_PDEATHSIG, signal.SIGKILL)
    if os.getppid() != parent:  # it died before the line above took effect
        os._exit(1)


def _run_segment(
    template: Template,
    segment: Segment,
    requests: Iterator[Request],
    execute: Callable[[Request], Outcome],
    pulse: _Pulse,
) -> Iterator[tuple[Outcome, bytes, ChainState | None]]:
    entry = template.entries[segment.entry]
    state, previous = segment.state, segment.previous

    def run(request: Request) -> Outcome:
        pulse.allow()
        return _outcome_of(template, execute, request)

    for values, request in zip(segment.values, requests, strict=False):
        ending.heed()
        pulse.beat()
        key = point_key(template, values, entry, previous)
        if entry is None or entry.spec.kind != "continue":
            yield run(request), key, None
            continue
        outcome, state = Chain(template, entry, run).point(request, values, state)
        previous = key
        yield outcome, key, state


def _outcome_of(
    template: Template, execute: Callable[[Request], Outcome], request: Request
) -> Outcome:
    """The outcome of a point; an exception is a failed point, never a lost task."""
    refusal = _refusal(request, template)
    if refusal is not None:
        return refusal
    try:
        outcome = execute(request)
    except Exception as error:
        return _internal_error(error)
    return _placed(outcome, request, template)


def _refusal(request: Request, template: Template) -> Outcome | None:
    """The outcome of a point that is not to be run; an exception says so, too."""
    try:
        unmet = exclusion(request, template.linear)
    except Exception as error:
        return _internal_error(error)
    return None if unmet is None else Outcome("not_computed", unmet.reason)


def _placed(outcome: Outcome, request: Request, template: Template) -> Outcome:
    """`outcome` over the states of the dataset, where an axis decides which a point has."""
    options, model = request.setup.options, request.setup.model
    if options == template.options:
        return outcome
    variables = variables_of(request.analysis, model, template.options, request.settings)
    try:
        return on_all_states(outcome.whole(), model, options, template.options, variables)
    except Exception as error:
        return _internal_error(error)


def imported(path: str) -> Callable[..., Any]:
    """The function that ``module:function`` names."""
    module, _, name = path.partition(":")
    function: Callable[..., Any] = getattr(importlib.import_module(module), name)
    return function


class _Pulse:
    """Tells the parent which row is being run, and ends the process when one takes too long.

    Attributes
    ----------
    longest : the row that took longest, and how long, s
    """

    def __init__(self, task: Task) -> None:
        self.longest = (0, 0.0)
        self._row, self._rows, self._since = -1, 1, time.perf_counter()
        self._path = task.heartbeat
        self._limit = task.time_limit
        self._file = -1

    def __enter__(self) -> _Pulse:
        if self._path is not None:
            with contextlib.suppress(OSError):  # a full disk: go on without
                flags = os.O_WRONLY | os.O_CREAT | os.O_TRUNC | os.O_NOFOLLOW
                self._file = os.open(self._path, flags)
        return self

    def __exit__(self, *exception: object) -> None:
        self._take_time()
        if self._path is not None and self._file >= 0:
            os.close(self._file)
            self._path.unlink(missing_ok=True)
        if self._limit is not None:
            signal.setitimer(signal.ITIMER_REAL, 0.0)

    def beat(self, rows: int = 1) -> None:
        """A new row begins, or several at once.

        SIGALRM keeps its default action, which ends the process even inside compiled code.
        """
        self._take_time()
        self._row, self._rows = self._row + rows, rows
        if self._file >= 0:
            with contextlib.suppress(OSError):
                os.pwrite(self._file, self._row.to_bytes(8, "little"), 0)

    def allow(self) -> None:
        """A run begins, which may take as long as a point may."""
        if self._limit is not None:
            signal.setitimer(signal.ITIMER_REAL, self._limit)

    def _take_time(self) -> None:
        """Of the row that has just ended."""
        begun, self._since = self._since, time.perf_counter()
        seconds = (self._since - begun) / self._rows
        if seconds > self.longest[1] and self._row >= 0:
            self.longest = (self._row, seconds)


def last_beat(heartbeat: Path) -> tuple[int, float] | None:
    """The row a dead worker was running, and since when (seconds since the epoch).

    None when it had not begun or had already finished.
    """
    try:
        content, since = heartbeat.read_bytes(), heartbeat.stat().st_mtime
    except OSError:
        return None
    return (int.from_bytes(content, "little"), since) if len(content) == 8 else None
