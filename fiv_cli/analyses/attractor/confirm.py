"""Is a motion whose section repeats on its way to a cycle of its own?

What is asked, and the numbers, are in ``grounds.py``. The return map is differentiated near the
motion; the steps of Newton's method that follow use that derivative (chords). The multipliers are
those of the cycle itself: it is gone round once more with tangents, unless the motion was on it.
"""

from __future__ import annotations

import numpy as np

from fiv_cli.analyses.attractor.grounds import CLOSED, NEIGHBOUR, REACH, STRAIGHT
from fiv_cli.analyses.cycles.first_guess import guess_between
from fiv_cli.analyses.cycles.periodic import (
    MOST_EVENTS,
    Orbit,
    Passage,
    Problem,
    Shooting,
    anchor_at,
    begin,
    least_squares,
    newton,
    shooting,
    sorted_multipliers,
)
from fiv_cli.dynamics.motion import Motion
from fiv_cli.dynamics.system import Vector

CHORDS = 6  # steps with one derivative
DERIVATIVES = 3  # of the return map at most
SETTLED = 1e-10  # last correction, over the extent of the motion
SLOW = 0.1  # a chord step that leaves more than this of the last one asks for a new derivative
FAINT = 1e-3  # a displacement (velocity) below this share of the largest is judged by that
ON_IT = 1e-8  # distance from the cycle that multipliers do not notice
ROUNDED = 1e-9  # distance from 1 of a multiplier that may be 1 ...
BESIDE_THE_FLOW = 1e-5  # ... and of one beside that of the flow, which both are off by a root of it
ROUNDING = 1e-9  # of the extent: a distance that says nothing


def confirm(
    problem: Problem, motion: Motion, period: float, from_afar: bool = False
) -> Orbit | None:
    """The cycle that `motion`, which repeats after `period` (s), comes to; None: it is not sure.

    Parameters
    ----------
    from_afar : whether the motion hardly repeats yet, so that the way there must be straight
    """
    conditions = _conditions(problem, motion, period)
    return None if conditions is None else _closed(problem, conditions, from_afar)


def is_drawn_to_cycle(problem: Problem, motion: Motion, period: float) -> bool:
    """Whether Newton's method finds a cycle that attracts, beside a motion that nearly returns.

    Within a torus there may be one that repels, or is neutral.

    Parameters
    ----------
    period : after which it nearly returns, s
    """
    conditions = _conditions(problem, motion, period)
    if conditions is None:
        return False
    found = newton(lambda unknowns: conditions.conditions(problem, unknowns), conditions.start)
    if found is None or np.abs(found[0] - conditions.start).max() > NEIGHBOUR:
        return False
    around = conditions.around(problem, found[0])
    return around is not None and _attracts(_orbit(problem, conditions, found[0], around))


def _conditions(problem: Problem, motion: Motion, period: float) -> Shooting | None:
    """What closes a motion after `period` (s); None where it does not last."""
    here = anchor_at(problem, motion)
    now = here.phase / (2 * np.pi) * (problem.excitation or 0.0)
    guess = guess_between(problem, lambda: begin(problem, here, MOST_EVENTS), now, now + period)
    if guess is None:
        return None
    scales = _scales(guess.scales, len(problem.system.coordinates))
    return shooting(problem, guess.anchor, guess.period, scales)


def _scales(extents: Vector, n_coordinates: int) -> Vector:
    """By what distances are judged: of a state that hardly moves, a share of what moves most."""
    floored = extents.copy()
    for first in (0, n_coordinates, 2 * n_coordinates):
        group = floored[first : None if first == 2 * n_coordinates else first + n_coordinates]
        np.maximum(group, FAINT * group.max(initial=0.0), out=group)
    return floored


def _closed(problem: Problem, conditions: Shooting, from_afar: bool) -> Orbit | None:
    unknowns = conditions.start
    first = found = conditions.around(problem, unknowns)
    way = None  # of the first step
    for number in range(DERIVATIVES):
        if found is None or first is None:
            return None
        derived = found
        inverse = least_squares(conditions.jacobian(found))
        if way is None:
            way = -inverse @ conditions.values(found, unknowns)
            if from_afar and np.abs(way).max() > (1.0 + STRAIGHT) * NEIGHBOUR:
                return None
        enough = SETTLED if from_afar and number == 0 else CLOSED
        unknowns, found, last_step = _chords(problem, conditions, unknowns, found, inverse)
        if last_step <= enough and found is not None:
            moved = unknowns - conditions.start
            if from_afar and not _is_straight(way, moved):
                return None
            is_near = float(np.abs(moved).max()) <= ON_IT
            last = derived if is_near else conditions.around(problem, unknowns)
            return None if last is None else _own(problem, conditions, unknowns, first, last)
        found = conditions.around(problem, unknowns)
    return None


def _is_straight(way: Vector, moved: Vector) -> bool:
    """Whether the first step led to the cycle, so that the return map is linear up to there."""
    beside, whole = np.abs(way - moved).max(), np.abs(moved).max()
    return bool(beside <= max(STRAIGHT * whole, ON_IT))


def _chords(
    problem: Problem, conditions: Shooting, unknowns: Vector, found: Passage, inverse: Vector
) -> tuple[Vector, Passage | None, float]:
    """Steps with one derivative: the unknowns, the motion from there, the size of the last step."""
    last = np.inf
    for _ in range(CHORDS):
        step = -inverse @ conditions.values(found, unknowns)
        size = float(np.abs(step).max())
        if size <= SETTLED or (not size <= SLOW * last and last < np.inf):
            return unknowns, found, size
        unknowns = unknowns + step
        moved = conditions.around(problem, unknowns, tangents=False)
        if moved is None:
            return unknowns, None, np.inf
        found, last = moved, size
    return unknowns, found, last


def _own(
    problem: Problem, conditions: Shooting, unknowns: Vector, first: Passage, last: Passage
) -> Orbit | None:
    """The cycle gone round in `last`, where the motion itself, gone on in `first`, comes to it."""
    orbit = _orbit(problem, conditions, unknowns, last)
    gap = _distance(first.state, first.begun, conditions.scales)
    moved = float(np.abs(unknowns - conditions.start).max())
    same = first.events == last.events
    allowed = max(REACH * gap / max(1.0 - orbit.largest, 1e-300), ROUNDING)
    close = moved <= min(allowed, NEIGHBOUR) and orbit.residual <= CLOSED
    return orbit if _attracts(orbit) and same and close else None


def _attracts(orbit: Orbit) -> bool:
    """Whether neighbours come nearer, and do not only seem to by rounding."""
    return orbit.largest < 1.0 - (BESIDE_THE_FLOW if orbit.autonomous else ROUNDED)


def _orbit(problem: Problem, conditions: Shooting, unknowns: Vector, around: Passage) -> Orbit:
    """The cycle that is gone round in `around`."""
    residual = _distance(around.state, around.begun, conditions.scales)
    anchor, period = conditions.anchor_of(unknowns), conditions.period_of(problem, unknowns)
    multipliers = sorted_multipliers(around.monodromy)
    return Orbit(anchor, period, residual, multipliers, autonomous=problem.excitation is None)


def _distance(one: Vector, other: Vector, scales: Vector) -> float:
    return float((np.abs(one - other) / scales).max())
