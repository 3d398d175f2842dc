"""A real scheduler and real workers, each in processes of their own on the loopback."""

from __future__ import annotations

import os
import signal
import socket
import sys
from collections.abc import Mapping
from contextlib import ExitStack
from dataclasses import dataclass, field
from pathlib import Path

from disturbed import Run, wait_for

QUIET = ("--no-dashboard", "--host", "127.0.0.1")
TESTS = Path(__file__).parent


def free_port() -> int:
    """A port that nobody listens at."""
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        port: int = probe.getsockname()[1]
        return port


class Dask(Run):
    """A command of dask, whose processes bear a mark like those of a run."""

    program = (sys.executable, "-m", "dask")


@dataclass
class LoopbackCluster:
    """A scheduler at an address that stays, and workers that may come and go.

    Attributes
    ----------
    folder : where they run
    port : of the scheduler
    workers : live `dask worker` commands
    """

    folder: Path
    port: int = field(default_factory=free_port)
    workers: list[Dask] = field(default_factory=list)

    @property
    def address(self) -> str:
        """Where the scheduler answers."""
        return f"tcp://127.0.0.1:{self.port}"

    def __enter__(self) -> LoopbackCluster:
        self._stack = ExitStack()
        self.start_scheduler()
        return self

    def __exit__(self, *exception: object) -> None:
        self._stack.close()

    def start_scheduler(self) -> None:
        """Start the scheduler, at the same place each time."""
        arguments = ("scheduler", "--port", str(self.port), *QUIET)
        self.scheduler = self._stack.enter_context(Dask(arguments, self.folder))
        wait_for(self._answers, "no scheduler")

    def start_worker(
        self, *options: str, processes: int = 1, environment: Mapping[str, str] | None = None
    ) -> Dask:
        """Start a `dask worker` with so many processes."""
        own = ("--nworkers", str(processes), "--nthreads", "1", *QUIET, *options)
        paths = os.pathsep.join([str(TESTS), *sys.path])
        worker = Dask(
            ("worker", self.address, *own, "--local-directory", str(self.folder)),
            self.folder,
            {"PYTHONPATH": paths, **(environment or {})},
        )
        self.workers.append(self._stack.enter_context(worker))
        return worker

    def kill_scheduler(self) -> None:
        """End the scheduler without a word."""
        self.scheduler.process.send_signal(signal.SIGKILL)
        self.scheduler.process.wait()

    def _answers(self) -> bool:
        with socket.socket() as probe:
            return probe.connect_ex(("127.0.0.1", self.port)) == 0
