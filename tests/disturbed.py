"""Real runs of `fiv`, and signals that disturb them."""

from __future__ import annotations

import os
import shlex
import signal
import subprocess
import sys
import time
import uuid
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import ClassVar

PATIENCE = 30.0
ENDING = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)
# The program tested; another version's shows the faults that each test was written for.
FIV = shlex.split(os.environ.get("FIV_UNDER_TEST", f"{shlex.quote(sys.executable)} -m fiv_cli"))
MARK = "FIV_TEST_RUN"


def by_default() -> None:
    """In the child: signals as a shell gives them, whatever the test run itself was given."""
    for number in ENDING:
        signal.signal(number, signal.SIG_DFL)


def ignoring() -> None:
    """In the child: all of them ignored."""
    for number in ENDING:
        signal.signal(number, signal.SIG_IGN)


def in_the_background() -> None:
    """In the child: signals as a shell without job control gives them to what it does not await."""
    by_default()
    signal.signal(signal.SIGINT, signal.SIG_IGN)


def wait_for(condition: Callable[[], object], what: str, patience: float = PATIENCE) -> None:
    """Wait until something holds."""
    end = time.monotonic() + patience
    while not condition():
        assert time.monotonic() < end, what
        time.sleep(0.005)


@dataclass
class Run:
    """A `fiv` command in a process group of its own, whose processes bear a mark.

    Attributes
    ----------
    arguments : what stands behind ``fiv``, or behind another `program`
    folder : where it runs
    environment : variables beside those of the test run
    entry : run in the child before it begins
    """

    arguments: tuple[str, ...]
    folder: Path
    environment: Mapping[str, str] = field(default_factory=dict)
    entry: Callable[[], None] = by_default
    program: ClassVar[Sequence[str]] = FIV

    def __enter__(self) -> Run:
        self.mark = uuid.uuid4().hex
        self.errors = self.folder / f"{self.mark}.stderr"
        with self.errors.open("w") as errors:
            self.process = subprocess.Popen(
                [*self.program, *self.arguments],
                cwd=self.folder,
                env={**os.environ, **self.environment, MARK: self.mark},
                stdout=subprocess.DEVNULL,
                stderr=errors,
                start_new_session=True,
                preexec_fn=self.entry,
            )
        return self

    def __exit__(self, *exception: object) -> None:
        for pid in self.processes():
            os.kill(pid, signal.SIGKILL)
        self.process.wait()

    def processes(self) -> list[int]:
        """Every live process of this run, whoever its parent is by now."""
        numbers = [path.name for path in Path("/proc").iterdir() if path.name.isdigit()]
        return [pid for pid in map(int, numbers) if self._has(pid)]

    def _has(self, pid: int) -> bool:
        wanted = f"{MARK}={self.mark}".encode()
        try:
            alive = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0] != "Z"
            return alive and wanted in Path(f"/proc/{pid}/environ").read_bytes().split(b"\0")
        except OSError:
            return False

    def listens(self) -> bool:
        """Whether its handlers are in place (or it has ended)."""
        lines = Path(f"/proc/{self.process.pid}/status").read_text().splitlines()
        caught = next((int(line[7:], 16) for line in lines if line.startswith("SigCgt")), 0)
        return bool(caught >> (signal.SIGTERM - 1) & 1) or self.process.poll() is not None

    def send(self, number: int, to_all: bool = False) -> None:
        """A signal to the process, or to its whole group as a terminal sends it."""
        if self.process.poll() is None:
            (os.killpg if to_all else os.kill)(self.process.pid, number)

    def code(self, patience: float = PATIENCE) -> int:
        """How it ended; nothing may be left of it."""
        code = self.process.wait(patience)
        wait_for(lambda: not self.processes(), "a process stayed behind", 10.0)
        return code

    @property
    def said(self) -> str:
        """What it wrote to stderr."""
        return self.errors.read_text()
