"""Worker processes: loky's executor, started anew when a worker has died."""

from __future__ import annotations

import contextlib
import os
import signal
import time
from collections.abc import Sequence
from concurrent.futures import Future
from multiprocessing import resource_tracker
from multiprocessing.connection import wait
from typing import Any

from joblib.externals.loky import process_executor

from fiv_cli import ending
from fiv_cli.sweep.tokens import Context
from fiv_cli.sweep.worker import Result, Task, initialise, run_task

GRACE = 1.0
"""Seconds that a worker has to follow SIGTERM."""

_THREADS_OF = ("OMP", "OPENBLAS", "MKL")
_ONE_THREAD = {f"{library}_NUM_THREADS": "1" for library in _THREADS_OF}


class WorkerPool:
    """Processes that run tasks; none outlives this one."""

    def __init__(self, workers: int) -> None:
        self.workers = workers
        self._last_act = contextlib.ExitStack()
        self._last_act.enter_context(ending.last_act(self._kill))
        self._start()

    def submit(self, task: Task) -> Future[Result]:
        """Hand a task to the workers."""
        with ending.starting():
            future: Future[Result] = self._executor.submit(run_task, task)
        return future

    def has_lost_a_worker(self) -> bool:
        """Whether a process has ended (loky waits for ever for one that died while it answered)."""
        return not all(process.is_alive() for process in self._context.started)

    def restart(self) -> None:
        """Replace all processes after one of them died."""
        self.stop()
        self._start()

    def close(self) -> None:
        """End all processes for good."""
        self.stop()
        self._last_act.close()

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
            self.workers,
            context=self._context,
            initializer=initialise,
            initargs=(os.getpid(),),
            env=_ONE_THREAD,
        )

    def _kill(self) -> None:
        for process in self._context.started:
            _send(process, signal.SIGKILL)


def end(processes: Sequence[Any]) -> None:
    """End child processes: SIGTERM, then SIGKILL to those that stay."""
    for process in processes:
        _send(process, signal.SIGTERM)
    deadline = time.monotonic() + GRACE
    left = list(processes)
    while left and (seconds := deadline - time.monotonic()) > 0.0:
        wait([process.sentinel for process in left], seconds)
        left = [process for process in left if process.is_alive()]
    for process in left:
        _send(process, signal.SIGKILL)
    for process in processes:
        process.join()


def _let_go(connection: Any) -> None:
    """Close a connection that another thread closes as soon as this one has."""
    handle, connection._handle = connection._handle, None  # first: it must not be closed twice
    os.close(handle)


def _send(process: Any, number: int) -> None:
    with contextlib.suppress(ProcessLookupError):
        if process.pid is not None and process.exitcode is None:
            os.kill(process.pid, number)


# loky's own asks `pgrep` for the children of a worker, which has none, and hangs where there is no
# such program.
process_executor.kill_process_tree = lambda process: end([process])
