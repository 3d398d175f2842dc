"""How far a change on a branch of cycles, or its end, may be off.

How closely it was bisected says nothing of the cycles in which it shows. So it is looked for once
more among cycles of ten times the error of integration: by more than that moves it, the cycles' own
error does not. Near a fold this is much more than the error, which goes as its square.
"""

from __future__ import annotations

from dataclasses import replace

from fiv_cli.analyses.cycles.branch import Continuation, End, Point, is_close, reach_of, step
from fiv_cli.analyses.cycles.branch import way_of as way

LOOSER = 10.0  # growth of the error of integration
BACK = (1e-4, 1e-2)  # stretches of the branch, to both sides, in which it is looked for


def end_error(line: Continuation, end: End) -> float:
    """Distance within which a change or an end lies; NaN where it is not found again."""
    if end.last is None:  # an edge of the bracket, a first cycle, a cycle that shrinks to rest
        return end.width
    solver = line.problem.solver.with_error(LOOSER)
    looser = replace(line, problem=replace(line.problem, solver=solver))
    for back in BACK:
        again = _found_again(looser, end.last, max(back, end.length))
        if again is not None:
            return end.width + abs(again - end.value)
    return float("nan")


def _found_again(line: Continuation, last: Point, back: float) -> float | None:
    """Where the branch changes within `back` of a point; None where it does not."""
    behind = step(line, _turned(last), back)
    here = None if behind is None else _turned(behind)
    away = 2.0 * back
    if here is None or here.character != last.character or _goes_on(line, here, away):
        return None
    while not is_close(line, here, away):
        away *= 0.5
        here = _goes_on(line, here, away) or here
        if here.value in line.bracket:
            return None
    return here.value + 0.5 * way(here) * reach_of(line, here, away)


def _goes_on(line: Continuation, here: Point, length: float) -> Point | None:
    """The point `length` further on; None where the branch changes before."""
    there = step(line, here, length)
    return there if there is not None and there.character == here.character else None


def _turned(point: Point) -> Point:
    """The same point, about to go the other way."""
    return replace(point, tangent=-point.tangent)
