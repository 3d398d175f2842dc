"""Worker processes: loky's executor, started anew when a worker has died."""

from __future__ import annotations

import contextlib
import gc
import os
import signal
import time
from collections.abc import Iterable, Sequence
from concurrent.futures import FIRST_COMPLETED, BrokenExecutor, Future, wait
from dataclasses import replace
from itertools import count
from multiprocessing import connection, resource_tracker
from pathlib import Path
from typing import Any, NamedTuple

from joblib.externals.loky import process_executor

from fiv_cli import ending
from fiv_cli.sweep.tokens import Context
from fiv_cli.sweep.worker import Result, Task, initialise, last_beat, run_task
from fiv_cli.sweep.workers import Beat

GRACE = 1.0
"""Seconds that a worker has to follow SIGTERM."""

_THREADS_OF = ("OMP", "OPENBLAS", "MKL")
_ONE_THREAD = {f"{library}_NUM_THREADS": "1" for library in _THREADS_OF}


class _Flight(NamedTuple):
    """A task that a worker has: its number, and the file that tells its row."""

    number: int
    heartbeat: Path

    def beat(self) -> Beat | None:
        """Where the task is."""
        beat = last_beat(self.heartbeat)
        return None if beat is None else Beat(beat[0], time.time() - beat[1])


class WorkerPool:
    """Processes that run tasks; none outlives this one.

    Parameters
    ----------
    workers : how many
    folder : for files that tell which row each of them runs
    """

    def __init__(self, workers: int, folder: Path) -> None:
        self.size = workers
        self._folder = folder
        self._numbers = count(1)
        self._flights: dict[Future[Result], _Flight] = {}
        self._last_act = contextlib.ExitStack()
        self._last_act.enter_context(ending.last_act(self._kill))
        self._start()

    def submit(self, task: Task) -> int:
        """Hand a task to the workers; where they have died meanwhile it is lost."""
        number = next(self._numbers)
        heartbeat = self._folder / f".beat-{number}"
        try:
            with ending.starting():
                future = self._executor.submit(run_task, replace(task, heartbeat=heartbeat))
        except BrokenExecutor as error:
            future = Future()
            future.set_exception(error)
        self._flights[future] = _Flight(number, heartbeat)
        return number

    def completed(self, seconds: float) -> list[tuple[int, Result]]:
        """The tasks that have ended and what came of them; waits so long for the first."""
        wait(self._flights, seconds, FIRST_COMPLETED)
        ended = [future for future in self._flights if future.done() and not _is_lost(future)]
        return [(self._flights.pop(future).number, future.result()) for future in ended]

    def lost(self) -> list[tuple[int, Beat | None]]:
        """After a worker died: all tasks that have not ended, their workers being replaced.

        (loky waits for ever for one that died while it answered.)
        """
        alive = all(process.is_alive() for process in self._context.started)
        if alive and not any(map(_is_lost, self._flights)):
            return []
        beats = dict(self.beats())
        self.stop()
        unfinished = [f for f in self._flights if not f.done() or _is_lost(f)]
        lost = [self._flights.pop(future) for future in unfinished]
        _remove(lost)
        self._start()
        return [(flight.number, beats.get(flight.number)) for flight in lost]

    def beats(self) -> list[tuple[int, Beat]]:
        """Where the tasks are that are being run."""
        found = ((flight.number, flight.beat()) for flight in self._flights.values())
        return [(number, beat) for number, beat in found if beat is not None]

    def close(self) -> None:
        """Drop all tasks and end all processes for good."""
        self.stop()
        self._last_act.close()
        _remove(self._flights.values())
        self._flights.clear()

    def stop(self) -> None:
        """End all processes, whatever they are doing, then the thread that looks after them."""
        end(self._context.started)
        thread, answers = self._executor._executor_manager_thread, self._executor._result_queue
        self._executor.shutdown(wait=False, kill_workers=True)
        if thread is not None:
            thread.join(GRACE)
            if thread.is_alive():  # it waits for the rest of an answer that broke off
                _let_go(answers._writer)
                thread.join()

    def _start(self) -> None:
        with ending.starting():  # on its own: where it starts this, Python unblocks signals
            resource_tracker.ensure_running()
        self._context = Context()
        self._executor = process_executor.ProcessPoolExecutor(
            self.size,
            context=self._context,
            initializer=initialise,
            initargs=(os.getpid(), *gc.get_threshold()),
            env=_ONE_THREAD,
        )

    def _kill(self) -> None:
        for process in self._context.started:
            _send(process, signal.SIGKILL)


def _is_lost(future: Future[Result]) -> bool:
    """Whether the worker of a task died, or was ended."""
    if future.cancelled():
        return True
    ended = (BrokenExecutor, process_executor.ShutdownExecutorError)
    return future.done() and isinstance(future.exception(), ended)


def _remove(flights: Iterable[_Flight]) -> None:
    for flight in flights:
        flight.heartbeat.unlink(missing_ok=True)


def end(processes: Sequence[Any]) -> None:
    """End child processes: SIGTERM, then SIGKILL to those that stay."""
    for process in processes:
        _send(process, signal.SIGTERM)
    deadline = time.monotonic() + GRACE
    left = list(processes)
    while left and (seconds := deadline - time.monotonic()) > 0.0:
        connection.wait([process.sentinel for process in left], seconds)
        left = [process for process in left if process.is_alive()]
    for process in left:
        _send(process, signal.SIGKILL)
    for process in processes:
        process.join()


def _let_go(pipe: Any) -> None:
    """Close a connection that another thread closes as soon as this one has."""
    handle, pipe._handle = pipe._handle, None  # first: it must not be closed twice
    os.close(handle)


def _send(process: Any, number: int) -> None:
    with contextlib.suppress(ProcessLookupError):
        if process.pid is not None and process.exitcode is None:
            os.kill(process.pid, number)


# loky's own asks `pgrep` for the children of a worker, which has none, and hangs where there is no
# such program.
process_executor.kill_process_tree = lambda process: end([process])
