"""Who runs the tasks of a sweep: processes of this machine (`pool`), or of others (`cluster`).

Everything else, what to run next, what is stored, what is tried again, is the scheduler's.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

from fiv_cli.sweep.worker import Result, Task

GLANCE = 0.2
"""Seconds after which is looked again whether a worker died, or the program is to end."""


@dataclass(frozen=True)
class Beat:
    """The row of a task that is being run, or was when its worker died, and for how long, s."""

    row: int
    seconds: float


@dataclass(frozen=True)
class Died:
    """What comes of a task whose process died: where it was, if it had begun."""

    beat: Beat | None


class Workers(Protocol):
    """Run tasks; a task is known by the number that `submit` gives it."""

    @property
    def size(self) -> int:
        """How many tasks can run at once, now."""

    def submit(self, task: Task) -> int:
        """Hand a task to the workers."""

    def completed(self, seconds: float) -> Sequence[tuple[int, Result]]:
        """The tasks that have ended and what came of them; waits so long for the first."""

    def lost(self) -> Sequence[tuple[int, Beat | None]]:
        """The tasks whose worker died, and at which row; None: before it had begun, or after."""

    def beats(self) -> Sequence[tuple[int, Beat]]:
        """Where the tasks are that are being run, as far as is known."""

    def close(self) -> None:
        """Drop all tasks, and end what was started for them."""
