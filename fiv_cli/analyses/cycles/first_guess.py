"""Where a cycle may be: near-returns of a motion to its section.

The motion from a start is followed and its section points are kept. Two points that lie close
to each other, m returns apart, are a guess of a cycle of m points: the last ones where the
motion settles, early ones where it passes an unstable cycle.

A motion that comes by an unstable cycle and then settles is closest to itself where it settles.
Where nothing comes of that, the first places are tried at which it came closer to itself than
before and after, and at last the start, which may lie beside a cycle that the motion leaves before
it first meets the section.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fiv_cli.analyses.cycles.periodic import (
    MOST_EVENTS,
    Anchor,
    Problem,
    anchor_at,
    extents,
    is_at_rest,
    to_longest_piece,
)
from fiv_cli.dynamics.motion import Motion, Stop
from fiv_cli.dynamics.system import Vector

KEPT = 1024  # section points looked at
RETURNS = 8  # most returns per period looked for, unless the case says how many
CLOSE = 1e-6  # near-returns closer than this share of the section set are equally good
PASSAGES = 3  # by what a motion leaves again that are tried for each number of returns
FULL_TURN = 0.1  # share of a period of the excitation by which a near-return may miss it

Begin = Callable[[], Motion]


@dataclass(frozen=True)
class Guess:
    """A point near a cycle, its period (s) and the extent of the motion in every state."""

    anchor: Anchor
    period: float
    scales: Vector


@dataclass(frozen=True)
class Returns:
    """Section points of a motion; `stop` says why there are no more of them."""

    times: Vector
    points: NDArray[np.float64]
    stop: Stop


def returns(problem: Problem, begin: Begin, transient: float, t_max: float) -> Returns:
    """The section points of the motion after `transient`, s, the last `KEPT` up to `t_max`."""
    motion = begin()
    stop = motion.run(transient) if transient > 0.0 else Stop.REACHED
    times, points = np.zeros(KEPT), np.zeros((KEPT, len(motion.y)))
    count = 0
    while motion.time < t_max and stop in (Stop.REACHED, Stop.SECTION_FULL):
        if count == KEPT:
            half = KEPT // 2
            times[:half], points[:half] = times[half:], points[half:]
            count = half
        room = times[count:], points[count:]
        stop = motion.run(t_max, problem.section, room, None, False, problem.excitation or t_max)
        count += motion.n_sections
    return Returns(times[:count], points[:count], stop)


def near_returns(
    problem: Problem, passed: Returns, multiplicity: int | None, begun: float
) -> list[tuple[float, float]]:
    """Times of the two ends of near-returns, the most promising first.

    For each number of returns the closest pair counts; fewer returns come first among equals. Then
    come the first passages, and from where the motion has `begun` the time between first returns.
    """
    numbers = range(1, RETURNS + 1) if multiplicity is None else (multiplicity,)
    closest, passages, starts = [], [], []
    for m in numbers:
        if len(passed.times) <= m:
            continue
        spans = passed.times[m:] - passed.times[:-m]
        apart = np.where(_whole_turns(problem, spans), _distances(passed.points, m), np.inf)
        pairs, best = [*zip(passed.times, passed.times[m:], strict=False)], int(np.argmin(apart))
        if np.isfinite(apart[best]):
            closest.append((max(apart[best], CLOSE) * m, *pairs[best]))
            passages += [pairs[at] for at in _passages(apart)]
            starts.append((begun, begun + float(spans[0])))
    return [(one, other) for _, one, other in sorted(closest)] + passages + starts


def _passages(apart: Vector) -> list[int]:
    """Where a motion comes closer to itself than before and after: the first places."""
    before, after = np.append(np.inf, apart[:-1]), np.append(apart[1:], 0.0)
    met = np.isfinite(apart) & (apart <= before) & (apart < after)
    return [int(at) for at in np.flatnonzero(met)[:PASSAGES]]


def _distances(points: NDArray[np.float64], m: int) -> Vector:
    """Largest difference of points m apart, each state against its range in the section."""
    spread = np.ptp(points, axis=0)
    largest = np.max(np.abs(points), axis=0)
    scales = np.where(spread > CLOSE * largest, spread, np.maximum(largest, 1e-300))
    apart: Vector = np.max(np.abs(points[m:] - points[:-m]) / scales, axis=1)
    return apart


def _whole_turns(problem: Problem, spans: Vector) -> NDArray[np.bool_]:
    """Whether a time is close to a whole number of periods of the excitation."""
    if problem.excitation is None:
        return np.ones(len(spans), bool)
    turns = spans / problem.excitation
    near: NDArray[np.bool_] = (np.abs(turns - np.round(turns)) < FULL_TURN) & (turns > 0.5)
    return near


def guess_between(problem: Problem, begin: Begin, begun: float, ended: float) -> Guess | None:
    """The point in the middle of the longest piece between two times of the motion.

    None where the motion rests.
    """
    motion = begin()
    if begun > motion.time:
        motion.run(begun)
    motion.keep_ledger(MOST_EVENTS)
    motion.start_measuring(np.zeros(len(problem.system.coordinates)))
    motion.run(ended, measuring=True)
    extremes = motion.extremes
    if is_at_rest(extremes, len(problem.system.coordinates)):
        return None
    times = motion.ledger.times - begun
    again = begin()
    again.run(begun + to_longest_piece(times, ended - begun))
    return Guess(anchor_at(problem, again), ended - begun, extents(extremes))


def guesses(
    problem: Problem, begin: Begin, passed: Returns, multiplicity: int | None, transient: float
) -> Iterator[Guess]:
    """Guesses of cycles, the most promising first."""
    for begun, ended in near_returns(problem, passed, multiplicity, transient):
        guess = guess_between(problem, begin, begun, ended)
        if guess is not None:
            yield guess
