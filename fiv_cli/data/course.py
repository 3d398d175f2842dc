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
LONG, UNBOUND = 180.0, ": t_max, or --time-limit, bounds what a point takes"  # s without one
ALIKE = 0.8  # share of each other within which the rate of late is that of the whole run
TOLD = 0.1  # share of its time that a run took to compile and prepare, at least, if that is told
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
    name : of the analysis whose points are being done, whose pace is no other's; empty: of none yet
    later : points of analyses that come after it
    since : place of its beginning in `times`
    grows : what it has found may ask for more of its points
    """

    total: int
    times: list[float]
    counts: list[int]
    failed: int = 0
    slowest: str = ""
    name: str = ""
    later: int = 0
    since: int = 0
    grows: bool = False

    @property
    def done(self) -> int:
        """Points that are done."""
        return self.counts[-1]

    def note(self, now: float, points: int, failed: int = 0) -> None:
        """So many more points are done."""
        self.times.append(now)
        self.counts.append(self.done + points)
        self.failed += failed

    def turn(self, name: str, later: int, grows: bool = False) -> None:
        """The points of an analysis are next; so many of others come after them."""
        if name != self.name:
            self.since = len(self.times) - 1
        self.name, self.later, self.grows = name, later, grows

    def elapsed(self, now: float) -> float:
        """Seconds since the beginning."""
        return now - self.times[0]

    def _judged(self, now: float) -> float:
        """Up to when points are counted on: the last that came, until more are overdue."""
        last = self.times[self.since :][-LATE:]
        gaps = (after - before for before, after in pairwise(last))
        return last[-1] if now - last[-1] <= max(gaps, default=0.0) else now

    def rate(self, now: float) -> float:
        """Points per second of late, since the points before the last ones at the latest.

        It is that of one analysis: an eigenvalue is no measure of a motion.
        """
        now = self._judged(now)
        since = now - max(RECENT, self._own(now) / 2)
        place = min(bisect_right(self.times, since) - 1, len(self.times) - 2)
        place = max(self.since, place)
        seconds = now - self.times[place]
        return (self.done - self.counts[place]) / seconds if seconds > 0.0 else 0.0

    def left(self, now: float) -> float | None:
        """Seconds that the analysis still takes at this rate; None where nothing tells, or little.

        So where more time has gone since points came last than would be left: the rest takes longer
        than the points before.
        """
        rate = self.rate(now)
        if rate == 0.0 or (self._is_early and self._own(now) < YOUNG):
            return None
        points = self.total - self.later - self.done
        waited = now - self._judged(now)
        left = points / rate - waited
        return max(left, 0.0) if left > waited or self.done >= self.total else None

    def _own(self, now: float) -> float:
        """Seconds since the analysis began."""
        return now - self.times[self.since]

    @property
    def _is_early(self) -> bool:
        before = self.counts[self.since]  # what was stored took no time of this run
        return self.done - before < EARLY * (self.total - self.later - before)

    @property
    def _prepared(self) -> float:
        """Seconds before any point of this run was begun."""
        nothing = self.counts[self.since] == self.counts[0]
        return self.times[self.since] - self.times[0] if nothing else 0.0

    def pace(self, now: float, ended: float | None = None) -> str:
        """``2.5 min elapsed, 31 points/s, some 40 s to go``; "of late": not that of all.

        Of a run that has `ended` then, the time that it took from its beginning to its end.
        """
        elapsed, rate = f"{duration(self.elapsed(ended or now))} elapsed", self.rate(now)
        before = self._prepared if ended and self._prepared >= TOLD * self.elapsed(ended) else 0.0
        elapsed += f", {duration(before)} of them before its first point began" * (before > 0.0)
        if rate == 0.0 and not self.name:
            return f"{elapsed}, being compiled or prepared"
        if rate == 0.0:
            return elapsed + UNBOUND * (self._own(now) >= LONG)
        speed = f"{rate:.2g}" if rate < 10.0 else f"{rate:,.0f}"
        whole = (self.done - self.counts[0]) / (self.elapsed(self._judged(now)) - before)
        late = "" if ALIKE * rate <= whole <= rate / ALIKE else " of late"
        told, left = f"{elapsed}, {speed} points/s{late}", self.left(now)
        alike = ", were the others alike" if self._is_early else ""
        if left is None:
            return told
        after = f" in {self.name}, {self.later} points of others after it" if self.later else ""
        known = " with the points that are known so far" if self.grows else ""
        return f"{told}, some {duration(left)} to go{alike}{known}{after}"

    def line(self, now: float) -> str:
        """All of it."""
        parts = [f"{self.done} of {self.total} points done, {self.failed} failed", self.pace(now)]
        return "; ".join([*parts, *([f"slowest {self.slowest}"] if self.slowest else [])])
