"""Worker processes: loky's executor, started anew when a worker has died."""

from __future__ import annotations

import os
from concurrent.futures import Future
from typing import Any

from fiv_cli.sweep.worker import Result, Task, initialise, run_task

_THREADS_OF = ("OMP", "OPENBLAS", "MKL")
_ONE_THREAD = {f"{library}_NUM_THREADS": "1" for library in _THREADS_OF}


class WorkerPool:
    """Processes that run tasks; none outlives this one."""

    def __init__(self, workers: int) -> None:
        self.workers = workers
        self._executor = self._started()

    def submit(self, task: Task) -> Future[Result]:
        """Hand a task to the workers."""
        future: Future[Result] = self._executor.submit(run_task, task)
        return future

    def restart(self) -> None:
        """Replace all processes after one of them died."""
        self.close()
        self._executor = self._started()

    def close(self) -> None:
        """End all processes, whatever they are doing."""
        self._executor.shutdown(wait=True, kill_workers=True)

    def _started(self) -> Any:
        from joblib.externals.loky import ProcessPoolExecutor

        return ProcessPoolExecutor(
            self.workers, initializer=initialise, initargs=(os.getpid(),), env=_ONE_THREAD
        )
