"""How fast points are done, and how long the rest will take."""

from __future__ import annotations

from bisect import bisect_right
from dataclasses import dataclass

from fiv_cli.notation.amounts import duration

RECENT = 60.0
"""Seconds of which a rate is taken at the least; of a long run it is the later half."""


EARLY = 0.1  # share of the points done below which they say little of the others


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

    def rate(self, now: float) -> float:
        """Points per second of late, since the points before the last ones at the latest."""
        since = now - max(RECENT, self.elapsed(now) / 2)
        place = max(0, min(bisect_right(self.times, since) - 1, len(self.times) - 2))
        seconds = now - self.times[place]
        return (self.done - self.counts[place]) / seconds if seconds > 0.0 else 0.0

    def left(self, now: float) -> float | None:
        """Seconds that the rest takes at this rate; None where nothing tells."""
        rate = self.rate(now)
        return (self.total - self.done) / rate if rate > 0.0 else None

    def pace(self, now: float) -> str:
        """``2.5 min elapsed, 31 points/s, some 40 s to go``."""
        elapsed, left = f"{duration(self.elapsed(now))} elapsed", self.left(now)
        if left is None:
            return elapsed
        rate = self.rate(now)
        speed = f"{rate:.2g}" if rate < 10.0 else f"{rate:,.0f}"
        early = ", were the others alike" if self.done < EARLY * self.total else ""
        return f"{elapsed}, {speed} points/s, some {duration(left)} to go{early}"

    def line(self, now: float) -> str:
        """All of it."""
        parts = [f"{self.done} of {self.total} points done, {self.failed} failed", self.pace(now)]
        return "; ".join([*parts, *([f"slowest {self.slowest}"] if self.slowest else [])])
