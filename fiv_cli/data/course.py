"""How fast points are done, and how long the rest will take."""

from __future__ import annotations

from bisect import bisect_right
from dataclasses import dataclass
from itertools import pairwise

from fiv_cli.notation.amounts import duration

RECENT = 60.0
"""Seconds of which a rate is taken at the least; of a long run it is the later half."""


EARLY = 0.1  # share of the points done below which they say little of the others
YOUNG = 20.0  # seconds in which these few tell nothing at all
LATE = 16  # the last instants, whose longest distance says until when nothing new is no delay


@dataclass
class Course:
    """How far a run has come, and when.

    Attributes
    ----------
    total : points that are to be done, as far as is known
    times, counts : instants, s, and how many points were done then; the first is the beginning
    failed : points that failed
    slowest : what is known of the point that took longest; empty: nothing
    """

    total: int
    times: list[float]
    counts: list[int]
    failed: int = 0
    slowest: str = ""

    @property
    def done(self) -> int:
        """Points that are done."""
        return self.counts[-1]

    def note(self, now: float, points: int, failed: int = 0) -> None:
        """So many more points are done."""
        self.times.append(now)
        self.counts.append(self.done + points)
        self.failed += failed

    def elapsed(self, now: float) -> float:
        """Seconds since the beginning."""
        return now - self.times[0]

    def _judged(self, now: float) -> float:
        """Up to when points are counted on: the last that came, until more are overdue."""
        last = self.times[-LATE:]
        gaps = (after - before for before, after in pairwise(last))
        return last[-1] if now - last[-1] <= max(gaps, default=0.0) else now

    def rate(self, now: float) -> float:
        """Points per second of late, since the points before the last ones at the latest."""
        now = self._judged(now)
        since = now - max(RECENT, self.elapsed(now) / 2)
        place = max(0, min(bisect_right(self.times, since) - 1, len(self.times) - 2))
        seconds = now - self.times[place]
        return (self.done - self.counts[place]) / seconds if seconds > 0.0 else 0.0

    def left(self, now: float) -> float | None:
        """Seconds that the rest takes at this rate; None where nothing tells, or little yet.

        So where it should be done by now: the rest takes longer than the points before.
        """
        rate = self.rate(now)
        if rate == 0.0 or (self._is_early and self.elapsed(now) < YOUNG):
            return None
        left = (self.total - self.done) / rate - (now - self._judged(now))
        return left if left > 0.0 or self.done >= self.total else None

    @property
    def _is_early(self) -> bool:
        return self.done < EARLY * self.total

    def pace(self, now: float) -> str:
        """``2.5 min elapsed, 31 points/s, some 40 s to go``."""
        elapsed, rate = f"{duration(self.elapsed(now))} elapsed", self.rate(now)
        if rate == 0.0:
            return elapsed
        speed = f"{rate:.2g}" if rate < 10.0 else f"{rate:,.0f}"
        told, left = f"{elapsed}, {speed} points/s", self.left(now)
        alike = ", were the others alike" if self._is_early else ""
        return told if left is None else f"{told}, some {duration(left)} to go{alike}"

    def line(self, now: float) -> str:
        """All of it."""
        parts = [f"{self.done} of {self.total} points done, {self.failed} failed", self.pace(now)]
        return "; ".join([*parts, *([f"slowest {self.slowest}"] if self.slowest else [])])
