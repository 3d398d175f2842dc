"""What a worker of a cluster does: hands each task to a process of its own.

A point that ends its process, or is ended by its wall-clock limit, ends neither the worker nor
what else that runs, and the worker says which point it was, as on one machine.
"""

from __future__ import annotations

import atexit
import multiprocessing
import shutil
import tempfile
import threading
from pathlib import Path
from typing import NamedTuple

from fiv_cli.sweep.pool import WorkerPool
from fiv_cli.sweep.worker import Result, Task
from fiv_cli.sweep.workers import GLANCE, Died

_owns: dict[int, _Own] = {}
_released: set[str] = set()


class _Own(NamedTuple):
    """The process of a thread of this worker, and where it says which point it runs."""

    pool: WorkerPool
    folder: Path

    @classmethod
    def started(cls) -> _Own:
        # Who looks after workers makes daemons of them, which may have no children; these end with
        # the worker by themselves.
        multiprocessing.current_process()._config["daemon"] = False  # type: ignore[attr-defined]
        folder = Path(tempfile.mkdtemp(prefix="fiv-host-"))
        atexit.register(shutil.rmtree, folder, ignore_errors=True)
        return cls(WorkerPool(1, folder), folder)

    def close(self) -> None:
        """End the process."""
        self.pool.close()
        shutil.rmtree(self.folder, ignore_errors=True)


def run(task: Task, owner: str) -> Result | Died:
    """Run a task of a sweep, known as `owner`, in the process of this thread."""
    thread = threading.get_ident()
    if thread not in _owns:
        _owns[thread] = _Own.started()
    pool = _owns[thread].pool
    pool.submit(task)
    while owner not in _released:
        for _, result in pool.completed(GLANCE):
            return result
        for _, beat in pool.lost():
            return Died(beat)
    _owns.pop(thread).close()
    return Died(None)


def release(owner: str) -> None:
    """End what this worker still runs of a sweep; a process that runs nothing waits for more."""
    _released.add(owner)
