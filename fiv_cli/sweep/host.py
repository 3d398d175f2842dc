"""What a worker of a cluster does: hands each task to a process of its own.

A point that ends its process, or is ended by its wall-clock limit, ends neither the worker nor
what else that runs, and the worker says which point it was, as on one machine.
"""

from __future__ import annotations

import asyncio
import multiprocessing
import threading
from pathlib import Path

from fiv_cli.sweep.pool import WorkerPool
from fiv_cli.sweep.worker import Result, Task
from fiv_cli.sweep.workers import GLANCE, Died

_pools: dict[int, WorkerPool] = {}
_released: set[str] = set()


async def run(task: Task, owner: str) -> Result | Died:
    """Run a task of a sweep, known as `owner`, in the process of one of the worker's threads.

    The worker would look a hundred times a second into a thread that it had itself given the task.
    """
    from distributed import get_worker

    worker = get_worker()
    threads, folder = worker.executors["default"], Path(worker.local_directory)
    return await asyncio.get_running_loop().run_in_executor(threads, _run, task, owner, folder)


def _started(folder: Path) -> WorkerPool:
    """A process of this thread's own."""
    # Who looks after workers makes daemons of them, which may have no children; these end with the
    # worker by themselves.
    multiprocessing.current_process()._config["daemon"] = False  # type: ignore[attr-defined]
    beats = folder / f"beats-{threading.get_ident()}"
    beats.mkdir(exist_ok=True)
    return WorkerPool(1, beats)


def _run(task: Task, owner: str, folder: Path) -> Result | Died:
    thread = threading.get_ident()
    if thread not in _pools:
        _pools[thread] = _started(folder)
    pool = _pools[thread]
    pool.submit(task)
    while owner not in _released:
        for _, result in pool.completed(GLANCE):
            return result
        for _, beat in pool.lost():
            return Died(beat)
    _pools.pop(thread).close()
    return Died(None)


def release(owner: str) -> None:
    """End what this worker still runs of a sweep; a process that runs nothing waits for more."""
    _released.add(owner)
