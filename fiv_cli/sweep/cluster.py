"""Workers of a cluster, behind a scheduler of dask.distributed that is running already.

The scheduler moves a task to another worker where one dies, so that only the deaths of a task's own
process come back from it (see `host`). A worker takes tasks only after it has said that it would
compute the same bits; it is asked when it joins. A scheduler that was lost is waited for, and has
all tasks anew.
"""

from __future__ import annotations

import asyncio
import contextlib
import logging
import secrets
import sys
import threading
import time
from collections import defaultdict
from collections.abc import Callable, Collection, Iterator
from concurrent import futures
from contextlib import contextmanager
from itertools import count
from pathlib import Path
from typing import Any

from fiv_cli.data.provenance import surroundings
from fiv_cli.errors import ClusterError, UsageError
from fiv_cli.sweep import host
from fiv_cli.sweep.plan import counted
from fiv_cli.sweep.worker import Result, Task
from fiv_cli.sweep.workers import Beat, Died

PATIENCE = 60.0
"""Seconds in which a scheduler must answer, also again after it was lost."""

ROUND = 1.0
"""Seconds after which is looked again who has joined, and that a result may take at first."""


class Cluster:
    """The workers of a scheduler.

    Parameters
    ----------
    place : address of the scheduler, or its scheduler file
    note : told who computes, and who may not and why

    Raises
    ------
    ClusterError
        no scheduler answers there, or all of its workers would compute other bits.
    """

    def __init__(self, place: str, note: Callable[[str], None]) -> None:
        self.size = 0
        self._place, self._note = place, note
        self._own, self._name = surroundings(), f"fiv-{secrets.token_hex(8)}"
        self._numbers = count(1)
        self._tasks: dict[int, Task] = {}
        self._futures: dict[int, Any] = {}
        self._patience: defaultdict[int, float] = defaultdict(lambda: ROUND)
        self._died: dict[int, Beat | None] = {}
        self._idle: set[int] = set()
        self._admitted: dict[str, bool] = {}
        self._looked, self._told = 0.0, -1
        self._ended = threading.Event()
        self._client = _connected(place)
        self._look_round()
        if self._admitted and not any(self._admitted.values()):
            self.close()
            raise ClusterError(
                f"{place}: no worker there would compute the same bits, see above\n"
                "next: start workers with the same packages, on the same kind of processor"
            )

    def submit(self, task: Task) -> int:
        """Hand a task to the scheduler."""
        number = next(self._numbers)
        self._tasks[number] = task
        with _cut_off():  # then it is sent when the connection is there again
            self._send(number)
        return number

    def completed(self, seconds: float) -> list[tuple[int, Result]]:
        """The tasks that have ended and what came of them; waits so long for the first."""
        self._ended.wait(seconds)
        self._ended.clear()
        if self._client.status not in ("running", "connecting"):
            raise ClusterError(
                f"{self._place}: the scheduler is gone, and has not come back for {PATIENCE:g} s\n"
                "next: start it again, or leave --cluster out; the same command, without "
                "--fresh, goes on from here"
            )
        with _cut_off():
            if time.monotonic() - self._looked > ROUND:
                self._look_round()
                self._send_again()
            return self._answers()
        return []

    def lost(self) -> list[tuple[int, Beat | None]]:
        """The tasks that ended their processes, and at which row."""
        died, self._died = self._died, {}
        return list(died.items())

    def beats(self) -> list[tuple[int, Beat]]:
        """Nothing: where a task is, its worker says when it has ended."""
        return []

    def close(self) -> None:
        """Drop all tasks, and leave nothing behind on the workers."""
        with _cut_off():
            if self._client.status == "running":
                self._client.cancel([*self._futures.values()], force=True)
                self._on_workers(host.release, self._name)
        self._client.close(timeout=ROUND)

    def _send(self, number: int) -> None:
        """To any worker that may take part; where there is none, when one has joined."""
        admitted = [address for address, joined in self._admitted.items() if joined]
        if not self.size:
            return
        future = self._client.submit(
            host.run,
            self._tasks[number],
            self._name,
            key=f"{self._name}-{number}-{secrets.token_hex(4)}",
            workers=admitted,
            pure=False,
        )
        future.add_done_callback(lambda _: self._ended.set())
        self._futures[number] = future

    def _send_again(self) -> None:
        """What went with the scheduler, or with the last of the workers that it was sent to.

        That a task has no worker counts when it is seen twice: it may just be on its way.
        """
        held = {key for keys in self._client.processing().values() for key in keys}
        idle = {n for n, f in self._futures.items() if f.status == "pending" and f.key not in held}
        gone = [n for n in self._tasks if self._status(n) in ("cancelled", "lost")]
        for number in (*gone, *(idle & self._idle)):
            self._send(number)
        self._idle = idle - self._idle

    def _status(self, number: int) -> str:
        """How it is with a task."""
        future = self._futures.get(number)
        return "lost" if future is None else str(future.status)

    def _answers(self) -> list[tuple[int, Result]]:
        """What the tasks that have ended came to; those whose processes died are kept apart."""
        from distributed import KilledWorker

        for number in [n for n in self._tasks if self._status(n) == "error"]:
            error = self._futures[number].exception()
            if not isinstance(error, KilledWorker):
                raise error
            self._died[number] = None
            self._forget(number)
        results: list[tuple[int, Result]] = []
        for number in [n for n in self._tasks if self._status(n) == "finished"]:
            try:
                answer = self._futures[number].result(timeout=self._patience[number])
            except (OSError, asyncio.CancelledError, futures.CancelledError):
                self._patience[number] *= 2
                break  # it went with its worker, or the scheduler, and is to be sent again
            self._forget(number)
            if isinstance(answer, Died):
                self._died[number] = answer.beat
            else:
                results.append((number, answer))
        return results

    def _forget(self, number: int) -> None:
        del self._tasks[number], self._futures[number]
        self._patience.pop(number, None)

    def _look_round(self) -> None:
        """See who has joined, and who has left."""
        self._looked = time.monotonic()
        threads = self._client.nthreads()
        self._admitted = {a: joined for a, joined in self._admitted.items() if a in threads}
        self._ask([address for address in threads if address not in self._admitted])
        size = sum(number for address, number in threads.items() if self._admitted.get(address))
        if size != self._told:
            self._note(f"{self._place}: {counted(size, 'task')} at once")
        self.size = self._told = size

    def _ask(self, addresses: Collection[str]) -> None:
        """Let those who have joined take part, if they would compute the same bits."""
        found = self._on_workers(surroundings, workers=addresses) if addresses else {}
        answered = {a: theirs for a, theirs in found.items() if not isinstance(theirs, OSError)}
        for address, theirs in answered.items():  # who did not is asked again
            differing = _differences(self._own, theirs)
            self._admitted[address] = not differing
            if differing:
                self._note(f"worker {address} is refused: {'; '.join(differing)}")

    def _on_workers(
        self, act: Callable[..., Any], *arguments: Any, **chosen: Any
    ) -> dict[str, Any]:
        """What `act` returns, or the exception that it raises, on each worker."""
        found: dict[str, Any] = self._client.run(act, *arguments, on_error="return", **chosen)
        return found


def _differences(own: dict[str, str], theirs: dict[str, str] | Exception) -> list[str]:
    """What is not the same on another machine."""
    if isinstance(theirs, Exception):
        return [f"fiv does not work there ({type(theirs).__name__}: {theirs})"]
    names = (name for name in own if theirs.get(name) != own[name])
    return [f"{name} {theirs.get(name, 'unknown')} there, {own[name]} here" for name in names]


def _connected(place: str) -> Any:
    """A client of the scheduler at an address or named in a file."""
    if sys.modules.get("dask", sys) is None:
        del sys.modules["dask"]  # it was out of sight: see `cli.main`
    try:
        from distributed import Client
    except ImportError:
        raise UsageError(
            "--cluster: dask.distributed is not installed\n"
            "next: in the folder of fiv's sources, pip install '.[cluster]'"
        ) from None
    for name in ("distributed", "distributed.client", "tornado"):  # what is lost is said here
        logging.getLogger(name).setLevel(logging.CRITICAL)
    where = {"scheduler_file": place} if Path(place).is_file() else {"address": place}
    try:
        return Client(**where, timeout=PATIENCE, set_as_default=False)
    except (OSError, ValueError) as error:
        raise ClusterError(
            f"--cluster {place}: no scheduler answers there: {error}\n"
            "next: start one with `dask scheduler`, and workers with `dask worker`"
        ) from error


@contextmanager
def _cut_off() -> Iterator[None]:
    """What fails while the scheduler is out of reach is done again when it is back."""
    with contextlib.suppress(OSError, asyncio.CancelledError, futures.CancelledError):
        yield
