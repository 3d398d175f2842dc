"""How far a change on a branch of cycles, or its end, may be off.

How closely it was bisected says nothing of the cycles in which it shows. So it is looked for once
more among cycles of ten times the error of integration: by more than that moves it, the cycles' own
error does not. Near a fold this is much more than the error, which goes as its square.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from fiv_cli.analyses.cycles.branch import (
    FIRST,
    LONGER,
    UNBOUND,
    Continuation,
    End,
    Point,
    closer,
    is_close,
    middle_of,
    moved_by,
    openness,
    step,
)

LOOSER = 10.0  # growth of the error of integration
STEPS = 2000  # in which it is found again; near a grazing many fail
SLACK = 10.0  # times as much as opens the last cycle as far as it is: so far there may be none


def end_error(line: Continuation, end: End) -> float:
    """Distance within which a change or an end lies; NaN where it is not found again, or where
    nothing says why no cycle follows: one may, if closer than rounding tells."""
    if not end.is_met:
        return float("nan")
    if end.last is None:  # an edge, a first cycle
        return end.width
    solver = line.problem.solver.with_error(LOOSER)
    looser = replace(line, problem=replace(line.problem, solver=solver))
    unsure = end.width + SLACK * openness(line, end.last)
    if end.well_before is None:  # the cycle shrinks to rest
        return unsure + abs(moved_by(looser, end.last))
    again = _found_again(looser, end.well_before)
    if again is None:
        return float("nan")
    apart = unsure + abs(again - end.value)
    return float(np.maximum(apart, _to_grazing(end.well_before, end.last)))


def _found_again(line: Continuation, here: Point) -> float | None:
    """Where the branch first changes after a point; None where it does not."""
    length = FIRST
    for _ in range(STEPS):
        there = step(line, here, length)
        if there is not None and there.character == here.character:
            here, length = there, min(LONGER * length, FIRST)
            if here.value in line.bracket:
                return None
        elif is_close(line, here, length):
            return middle_of(line, *closer(line, here, length))
        else:
            length *= 0.5
    return None


def _to_grazing(well: Point, here: Point) -> float:
    """Twice the change of the parameter to where the multiplier has grown without bound, if it is
    about to.

    Towards a grazing it goes as the inverse of that change (Nordmark 1991), and from some size on
    no cycle is closed any more that is there, and the multiplier itself is known to half of it. NaN
    where it was not seen to grow.
    """
    if here.cycle.largest < UNBOUND:
        return 0.0
    before, after = 1.0 / well.cycle.largest, 1.0 / here.cycle.largest
    if after >= before:
        return float("nan")
    return 2.0 * abs(here.value - well.value) * after / (before - after)
