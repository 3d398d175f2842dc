"""What a person sees of a run while it goes on: a bar on a terminal, elsewhere a line now and then.

All of it goes to stderr.
"""

from __future__ import annotations

import sys
import threading
import time
from collections.abc import Callable
from typing import Any, Protocol

from fiv_cli.data.course import Course
from fiv_cli.notation.amounts import duration

INTERVAL = 30.0
"""Seconds between lines where there is no terminal."""


class Progress(Protocol):
    """Told what happens while a sweep runs."""

    def begin(self, total: int, done: int) -> None:
        """`done` of `total` points are stored; again when what was found asks for more."""

    def turn(self, name: str, later: int, grows: bool) -> None:
        """The points of an analysis are next, which may be more; so many of others follow."""

    def advance(self, points: int, failed: int) -> None:
        """So many more points are done; so many of them failed."""

    def slow(self, seconds: float, where: str) -> None:
        """A point took so long, longer than any before it."""

    def note(self, text: str) -> None:
        """Something worth a line."""

    def end(self) -> None:
        """The run ends."""


class Silent:
    """Shows nothing."""

    def begin(self, total: int, done: int) -> None:
        """Nothing."""

    def turn(self, name: str, later: int, grows: bool) -> None:
        """Nothing."""

    def advance(self, points: int, failed: int) -> None:
        """Nothing."""

    def slow(self, seconds: float, where: str) -> None:
        """Nothing."""

    def note(self, text: str) -> None:
        """Nothing."""

    def end(self) -> None:
        """Nothing."""


class _Followed:
    """What both ways of showing a run keep of it."""

    def __init__(self, title: str, clock: Callable[[], float]) -> None:
        self.title, self.clock = title, clock
        self.course = Course(0, [clock()], [0])

    def begin(self, total: int, done: int) -> None:
        """The first time, or once more when what was found asks for more."""
        if not self.course.total:
            self.course = Course(total, [self.clock()], [done])
        self.course.total = total

    def turn(self, name: str, later: int, grows: bool) -> None:
        """A pace of its own, from now on: what was compiled before it is no part of that."""
        if name != self.course.name:
            self.course.note(self.clock(), 0)
        self.course.turn(name, later, grows)

    def advance(self, points: int, failed: int) -> None:
        """Count."""
        self.course.note(self.clock(), points, failed)

    def slow(self, seconds: float, where: str) -> None:
        """Keep where it was."""
        self.course.slowest = f"{duration(seconds)} at {where}"


class Lines(_Followed):
    """A line every `INTERVAL` seconds, whether anything has happened or not."""

    def __init__(
        self,
        write: Callable[[str], object] = lambda text: print(text, file=sys.stderr, flush=True),
        title: str = "",
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        super().__init__(title, clock)
        self._write = write
        self._ended = threading.Event()

    def begin(self, total: int, done: int) -> None:
        """Say what there is to do, the first time."""
        if not self.course.total:
            points = f"{total} {'point' if total == 1 else 'points'}"
            self.note(f"{self.title}{points}, {done} already stored, {total - done} to run")
            threading.Thread(target=self._tell_again, daemon=True).start()
        super().begin(total, done)

    def _tell_again(self) -> None:
        while not self._ended.wait(INTERVAL):
            self.tell()

    def tell(self) -> None:
        """Say how far it is."""
        self.note(f"{self.title}{self.course.line(self.clock())}")

    def note(self, text: str) -> None:
        """Write a line."""
        self._write(text)

    def end(self) -> None:
        """No more lines: the summary follows."""
        self._ended.set()


class Bar(_Followed):
    """A rich progress bar, and the pace behind it, which goes on where no point is done."""

    def __init__(self, title: str = "", clock: Callable[[], float] = time.monotonic) -> None:
        from rich.console import Console
        from rich.progress import BarColumn, MofNCompleteColumn, TextColumn
        from rich.progress import Progress as RichProgress

        super().__init__(title, clock)
        self._bar = RichProgress(
            TextColumn("{task.description}"),
            BarColumn(bar_width=16),
            MofNCompleteColumn(),
            _pace_column(self),
            console=Console(stderr=True),
            transient=True,
        )
        self._task: Any = self._bar.add_task(f"{title}points")

    def begin(self, total: int, done: int) -> None:
        """Show the bar, or how much longer it has become."""
        super().begin(total, done)
        self._bar.update(self._task, total=total, completed=done)
        self._bar.start()

    def advance(self, points: int, failed: int) -> None:
        """Move the bar."""
        super().advance(points, failed)
        some = f" ({self.course.failed} failed)" if self.course.failed else ""
        self._bar.update(self._task, advance=points, description=f"{self.title}points{some}")

    def note(self, text: str) -> None:
        """A line above the bar."""
        self._bar.console.print(text, markup=False, highlight=False)

    def end(self) -> None:
        """Take the bar away."""
        self._bar.stop()


def _pace_column(shown: _Followed) -> Any:
    """A column that rich asks for its text ten times a second."""
    from rich.progress import ProgressColumn
    from rich.text import Text

    class PaceColumn(ProgressColumn):
        def render(self, task: object) -> Text:
            course = shown.course
            slowest = f"; slowest {course.slowest}" if course.slowest else ""
            text = course.pace(shown.clock()) + slowest
            return Text(text, no_wrap=True, overflow="ellipsis")

    return PaceColumn()


def for_stderr(quiet: bool, title: str = "") -> Progress:
    """The progress that fits where stderr goes; each of its lines begins with `title`."""
    if quiet:
        return Silent()
    return Bar(title) if sys.stderr.isatty() else Lines(title=title)
