"""What a person sees of a run while it goes on: a bar on a terminal, a line now and then elsewhere.

All of it goes to stderr.
"""

from __future__ import annotations

import sys
import time
from collections.abc import Callable
from typing import Any, Protocol

INTERVAL = 30.0
"""Seconds between lines where there is no terminal."""


class Progress(Protocol):
    """Told what happens while a sweep runs."""

    def begin(self, total: int, done: int) -> None:
        """`done` of `total` points are stored; again when what was found asks for more."""

    def advance(self, points: int, failed: int) -> None:
        """So many more points are done; so many of them failed."""

    def note(self, text: str) -> None:
        """Something worth a line."""

    def end(self) -> None:
        """The run ends."""


class Silent:
    """Shows nothing."""

    def begin(self, total: int, done: int) -> None:
        """Nothing."""

    def advance(self, points: int, failed: int) -> None:
        """Nothing."""

    def note(self, text: str) -> None:
        """Nothing."""

    def end(self) -> None:
        """Nothing."""


class Lines:
    """One line every `INTERVAL` seconds."""

    def __init__(
        self,
        write: Callable[[str], object] = lambda text: print(text, file=sys.stderr, flush=True),
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        self._write = write
        self._clock = clock
        self._total = self._done = self._failed = 0
        self._last = clock()

    def begin(self, total: int, done: int) -> None:
        """Say what there is to do, the first time."""
        if not self._total:
            self._last = self._clock()
            self._write(f"{total} points, {done} already stored, {total - done} to run")
        self._total, self._done = total, done

    def advance(self, points: int, failed: int) -> None:
        """Count, and say so when it is time."""
        self._done += points
        self._failed += failed
        if self._clock() - self._last >= INTERVAL:
            self._last = self._clock()
            self._write(f"{self._done} of {self._total} points done, {self._failed} failed")

    def note(self, text: str) -> None:
        """Write a line."""
        self._write(text)

    def end(self) -> None:
        """Nothing: the summary follows."""


class Bar:
    """A rich progress bar."""

    def __init__(self) -> None:
        from rich.console import Console
        from rich.progress import BarColumn, MofNCompleteColumn, TextColumn, TimeRemainingColumn
        from rich.progress import Progress as RichProgress

        self._bar = RichProgress(
            TextColumn("{task.description}"),
            BarColumn(),
            MofNCompleteColumn(),
            TimeRemainingColumn(),
            console=Console(stderr=True),
            transient=True,
        )
        self._task: Any = self._bar.add_task("points")
        self._failed = 0

    def begin(self, total: int, done: int) -> None:
        """Show the bar, or how much longer it has become."""
        self._bar.update(self._task, total=total, completed=done)
        self._bar.start()

    def advance(self, points: int, failed: int) -> None:
        """Move the bar."""
        self._failed += failed
        text = f"points ({self._failed} failed)" if self._failed else "points"
        self._bar.update(self._task, advance=points, description=text)

    def note(self, text: str) -> None:
        """A line above the bar."""
        self._bar.console.print(text, markup=False, highlight=False)

    def end(self) -> None:
        """Take the bar away."""
        self._bar.stop()


def for_stderr(quiet: bool) -> Progress:
    """The progress that fits where stderr goes."""
    if quiet:
        return Silent()
    return Bar() if sys.stderr.isatty() else Lines()
