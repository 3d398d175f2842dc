"""A branch of cycles along a parameter: where it goes, turns, changes stability and ends.

Pseudo-arclength continuation (H. B. Keller, 1977): the unknowns of a cycle and the parameter are
moved together along the branch, so that it is followed round folds, and past every change of
stability. A change between two points of the branch is bracketed along it. Where no cycle follows,
the step is bisected until the parameter of the last cycle and that of the first failure are as
close as asked for: between them the branch ends.

A cycle of a system with friction may end without a fold. At a *grazing* an event enters or leaves
its sequence, or an earlier one takes the place of a later one: a sliding motion touches zero slip
velocity, a landing is missed. The branch may go on with the other sequence, turn back with it, or
end.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import combinations

import numpy as np

from fiv_cli.analyses.base import Varied, broken
from fiv_cli.analyses.cycles.periodic import (
    OPEN,
    Anchor,
    Cycle,
    Equations,
    Matrix,
    Passage,
    Problem,
    Shooting,
    across_flow,
    anchor_at,
    begin,
    close,
    describe,
    inverse_of,
    newton,
    passage,
    shooting,
    to_longest_piece,
)
from fiv_cli.dynamics.motion import Motion, Stop
from fiv_cli.dynamics.system import Vector
from fiv_cli.flags import CYCLE_END

FIRST, LONGEST, SHORTEST = 0.01, 0.05, 1e-10  # lengths of a step along the branch
ORDINARY = 1e-3  # a step as long as this is not about to meet an end
LONGER = 1.5  # growth of a step ...
PATIENCE = 3  # ... after so many that went well
BLURRED = 0.1  # share of that, from which on the last digits of the states alone open it
ASTRAY = 0.7  # share of a step by which the cycle found may lie off the cycle foreseen ...
BENT = 0.2  # ... and one of the same events
STRAIGHT = 0.005  # share of it by which a cycle of another branch lies off at least ...
OFF = 1e-5  # ... and distance
MIRRORED = 0.25  # share of its bend by which an arc may fail to be its own mirror image
REACH = 7.0  # steps: a cycle that seems to lie further off is not looked for
DIFFERENCES = tuple(10.0**-e for e in range(7, 13))  # of the parameter, over the bracket ...
ALIKE = 1e-2  # ... the first for which the rates to both sides differ by no more than this share
FLAT = 1e-4  # ... or than this, over the whole bracket
AMPLIFIED = 10.0  # growth of the error of integration by which is told what it grows to
JUMPED = 10.0  # of the change to one side of the parameter: one so much greater is a jump
MOST_POINTS = 800
TRIES = 5  # steps tried, per point allowed
BISECTIONS = 200
FURTHER = 8.0  # an end is looked for so many times as closely as asked, to see if it moves ...
TRIES_FURTHER = 16  # ... in so many steps
BEYOND = (1e-5, 1e-4, 1e-3, 1e-2)  # distances behind an end at which motions are looked at
CHANGES = tuple(10.0**-e for e in range(5, 13))  # of the parameter, over the bracket
UNBOUND = 1e3  # a multiplier beyond grows without bound, as one does towards a grazing
ASIDE = 0.05  # share of the way to a change by which a step ends beside where it is foreseen
HALVINGS = 40  # of a stretch in which a jump is looked for
APART = 1e-3  # share of its extent by which a motion over a period jumps at least
CORNERS = (1e-4, 1e-3, 1e-2, 5e-2)  # distances from an end at which another branch is looked for
AHEAD = 0.5  # distance from there within which it is looked for ...
BESIDE = 0.4  # ... and found
NEARBY = 4.0  # steps within which what lies beyond a change must have been found
AROUND = 60  # points allowed on the way back to the end
MEETING = 1e-4  # share of the bracket within which two branches end at one value, or of extents
SAME = 1e-6  # share of period and extent within which two cycles are one
# Share of the bracket within which a value counts as its edge, or of that edge.
EDGE, LAST_DIGITS = 1e-12, 1e-15
STEEP = 0.3  # a direction with more of the parameter in it than this is well off a fold
UPRIGHT = 0.1  # a direction with less of the parameter in it than this is about to turn
LEVEL = 1e-8  # ... and with less than this does so by rounding: the branch stands upright there
SHRUNK = 1e-2  # a cycle this much smaller than the first one may be about to vanish
LARGER = (1.2, 1.5)  # times as large are those by which its place is told, if not by neighbours ...
SETTLED = 0.1  # ... and told alike: within this share of the way there
CLOSE_TO_ONE = 0.05  # a multiplier may pass 1 within a step from there
ON_CIRCLE = 0.5  # a multiplier's angle closer to 0 or pi than this is that of a real one

DOUBLED = 0.05  # share of its extent by which a doubled cycle misses itself that is about to be one

FLIP, TORUS, FOLD, BRANCHING = "flip", "torus", "fold", "branching"
GRAZING, CONTACT_LOST, AT_REST, AT_EDGE = "grazing", "contact_lost", "equilibrium", "bracket"
BUDGET, OTHER, CLOSED = "budget", "other", "closed"


@dataclass(frozen=True)
class Continuation:
    """What is followed.

    Attributes
    ----------
    problem : the system, its parameters at the first cycle
    varied : the parameter
    bracket : its lowest and highest value
    width : how closely changes and ends are bracketed
    """

    problem: Problem
    varied: Varied
    bracket: tuple[float, float]
    width: float

    @property
    def span(self) -> float:
        """Extent of the bracket."""
        return self.bracket[1] - self.bracket[0]

    def holding(self, value: float) -> Problem | None:
        """The problem at a `value` inside the bracket, if one `like` it; None at any other."""
        return self.like(value) if self.bracket[0] <= value <= self.bracket[1] else None

    def like(self, value: float) -> Problem | None:
        """The problem at a `value` that makes sense and leaves the excitation on or off; else None.

        A cycle's period is free without an excitation and bound to its period with one.
        """
        there = self.at(value)
        same = (there.excitation is None) == (self.problem.excitation is None)
        return there if same and not _invalid(there) else None

    def beside(self, value: float, shift: float) -> dict[float, Problem]:
        """The problems a `shift` below and above a value that are like it.

        Beyond an edge of the bracket, too: the branch ends there, not its motions.
        """
        found = {there: self.like(there) for there in (value - shift, value + shift)}
        return {there: problem for there, problem in found.items() if problem is not None}

    def invalid(self, value: float) -> str:
        """Reason why there is nothing to compute at `value`; empty where there is."""
        return _invalid(self.at(value))

    def at(self, value: float) -> Problem:
        """The problem at another value of the parameter."""
        return self.problem.changed(self.varied, value)


def _invalid(problem: Problem) -> str:
    """Reason why there is nothing to compute; empty where there is."""
    setup = problem.system.setup
    unmet = broken(setup.model, setup.law, problem.parameters)
    return "" if unmet is None else unmet.reason


@dataclass(frozen=True)
class Point:
    """A cycle on a branch.

    Attributes
    ----------
    value : of the parameter
    cycle : the cycle
    frame : the conditions it was found by
    unknowns : its unknowns in `frame`, and the parameter over the extent of the bracket
    tangent : direction of the branch in these unknowns, of length one
    inverse : of the conditions' derivative, for steps across any direction but the branch's
    kept : the way along the parameter and the stability of the point before it, where rounding
        alone would decide them; else None
    """

    value: float
    cycle: Cycle
    frame: Shooting
    unknowns: Vector
    tangent: Vector
    inverse: Matrix
    kept: tuple[bool, bool] | None = None

    @property
    def slope(self) -> float:
        """Share of the parameter in the direction of the branch, with its sign."""
        return float(self.tangent[-1])

    @cached_property
    def character(self) -> tuple[bool, bool, object]:
        """What changes at a mark: way along the parameter, stability, sequence of events."""
        return *(self.kept or (self.slope > 0.0, self.cycle.stable)), self.cycle.signature


@dataclass(frozen=True)
class End:
    """A change on a branch, or its end.

    Attributes
    ----------
    value : of the parameter
    width : the change lies this close to it
    kind : see the constants of this module
    direction : 1 where the parameter was rising along the branch, else -1
    goes_on : whether the branch was followed beyond
    last : the last point before it; None where it is not found by it
    well_before : the last before it from which the branch went on in steps of ordinary length; None
        where no step failed
    beyond : the first point after it; None where there is none
    is_met : whether something ends the branch; else no cycle was found, and one may follow
    """

    value: float
    width: float
    kind: str
    direction: int
    goes_on: bool
    last: Point | None = None
    well_before: Point | None = None
    beyond: Point | None = None
    is_met: bool = True


# --- the branch's equations ----------------------------------------------------------------------
def _conditions(line: Continuation, frame: Shooting, unknowns: Vector) -> Equations | None:
    """The closing conditions and their Jacobian, the derivative by the parameter last."""
    own, value = unknowns[:-1], _within(line, float(unknowns[-1] * line.span))
    here = line.holding(value)
    found = None if here is None else frame.around(here, own, tangents=False)
    if here is None or found is None:
        return None

    def jacobian() -> Matrix | None:
        along = frame.around(here, own)
        return None if along is None else _jacobian(line, frame, own, value, along)

    return Equations(frame.values(found, own), jacobian, found)


def _jacobian(
    line: Continuation, frame: Shooting, own: Vector, value: float, here: Passage
) -> Matrix | None:
    """Derivative of the closing conditions by `own` and by the parameter over the bracket's extent.

    None where motions on both sides of the parameter have other events.
    """
    values, rates = frame.values(here, own), []
    for shift in DIFFERENCES:
        sides = line.beside(value, shift * line.span)
        rates = list(_rates(frame, own, value, here.events, values, sides))
        if rates and len(rates) == len(sides) and _are_alike(rates[0], rates[-1], line.span):
            break
    if not rates:
        return None
    return np.column_stack([frame.jacobian(here), _rate(rates) * line.span])


def _rates(
    frame: Shooting,
    own: Vector,
    value: float,
    events: object,
    values: Vector,
    sides: Mapping[float, Problem],
) -> Iterator[Vector]:
    """Rate of change of the conditions by the parameter, to each side that has the same events."""
    for there, problem in sides.items():
        beside = frame.around(problem, own, tangents=False)
        if beside is not None and beside.events == events:
            yield (frame.values(beside, own) - values) / (there - value)


def _are_alike(one: Vector, other: Vector, span: float) -> bool:
    """Whether rates to both sides differ by so little that their mean is right to its square.

    Beside a grazing they do not: there the conditions bend within ever shorter stretches. Where the
    parameter changes next to nothing, rounding alone differs, and more so closer by.
    """
    apart, size = (float(np.linalg.norm(by)) for by in (one - other, one + other))
    return apart <= max(ALIKE * size, FLAT / span)


def _rate(rates: Sequence[Vector]) -> Vector:
    """The rate from those to one side or both; where one side jumps, that of the other."""
    least, most = min(rates, key=np.linalg.norm), max(rates, key=np.linalg.norm)
    jumps = np.linalg.norm(most) > JUMPED * np.linalg.norm(least)
    return least if jumps else np.mean(rates, axis=0)


def _across(inverse: Matrix, tangent: Vector, row: Vector) -> Matrix:
    """What solves the conditions together with `row`, from what does with another one."""
    share = tangent / (row @ tangent)
    bordered = inverse - np.outer(share, row @ inverse)
    bordered[:, -1] = share
    return bordered


def first_point(line: Continuation, cycle: Cycle, value: float, rising: bool) -> Point | None:
    """The point of the branch at `cycle`, about to go up or down along the parameter."""
    free = 1 if cycle.autonomous else 0
    way = np.zeros(len(cycle.anchor.state) + free + 1)
    way[-1] = line.span if rising else -line.span
    return _framed(line, cycle, value, way)


def step(line: Continuation, here: Point, length: float) -> Point | None:
    """The next point, `length` along the branch, or at the edge of the bracket before that."""
    foreseen = here.unknowns + length * here.tangent
    low, high = line.bracket[0] / line.span, line.bracket[1] / line.span
    across = here.tangent
    if not low <= foreseen[-1] <= high:
        edge = min(max(foreseen[-1], low), high)
        share = (edge - here.unknowns[-1]) / (foreseen[-1] - here.unknowns[-1])
        foreseen = here.unknowns + share * length * here.tangent
        across = np.append(np.zeros(len(foreseen) - 1), 1.0)
    return _corrected(line, here, foreseen, across, length)


def _corrected(
    line: Continuation, here: Point, foreseen: Vector, across: Vector, length: float
) -> Point | None:
    """The cycle of the branch in the plane across `across` through `foreseen`, a step ahead."""

    def conditions(unknowns: Vector) -> Equations | None:
        found = _conditions(line, here.frame, unknowns)
        if found is None:
            return None
        values = np.append(found.values, across @ (unknowns - foreseen))
        return Equations(values, lambda: _with_row(found.jacobian(), across), found.around)

    bordered, start = _across(here.inverse, here.tangent, across), foreseen
    for known in (bordered, None):  # what a correction leaves may open a very sensitive motion
        root = newton(conditions, start, known, REACH * length)
        if root is None:
            return None
        astray = float(np.linalg.norm(root[0] - foreseen)) / length
        alike = root[1].around.events == here.cycle.around.events
        if astray > (BENT if alike else ASTRAY) or (alike and _leaves(here, *root)):
            return None
        point = _point(line, here, *root)
        if point is not None:
            return point
        start = root[0]
    return None


def _leaves(here: Point, unknowns: Vector, found: Equations) -> bool:
    """Whether the way to a cycle is no arc of the branch, but leads to another one beside it.

    An arc leaves its chord as it comes back to it: the directions of the branch at both ends mirror
    each other in the chord. Of two branches side by side they point the same way.
    """
    gone = unknowns - here.unknowns
    length = float(np.linalg.norm(gone))
    chord = gone / length
    ahead = float(chord @ here.tangent)
    if np.linalg.norm(chord - ahead * here.tangent) <= max(STRAIGHT, OFF / length):
        return False
    inverse = inverse_of(found.jacobian())
    if inverse is None:
        return True
    there = inverse[:, -1] * np.sign(chord @ inverse[:, -1]) / np.linalg.norm(inverse[:, -1])
    mirrored = 2.0 * ahead * chord - here.tangent
    bent = np.linalg.norm(there - here.tangent)
    return bool(np.linalg.norm(there - mirrored) > MIRRORED * bent)


def _with_row(jacobian: Matrix | None, row: Vector) -> Matrix | None:
    """The Jacobian with another row below, where there is one."""
    return None if jacobian is None else np.vstack([jacobian, row])


def _point(line: Continuation, before: Point, unknowns: Vector, found: Equations) -> Point | None:
    """The cycle with these unknowns in the frame of `before`, in a frame of its own."""
    frame, value = before.frame, _within(line, float(unknowns[-1] * line.span))
    problem = line.at(value)
    anchor = frame.anchor_of(unknowns[:-1])
    period = frame.period_of(problem, unknowns[:-1])
    shift = to_longest_piece(found.around.times, period) if found.around.events else 0.0
    motion = _later(problem, anchor, shift)
    behind = _later(line.at(before.value), frame.anchor, shift * frame.period / period)
    moved = describe(problem, anchor_at(problem, motion), period) if motion and behind else None
    if motion is None or behind is None or moved is None:
        return None
    is_open = moved.residual > OPEN * max(1.0, moved.largest)
    if is_open and not _is_rounding(problem, moved):  # its last correction led to other events
        return None
    gone = unknowns - before.unknowns
    way = [motion.y - behind.y, gone[len(frame.scales) : -1] * frame.period, gone[-1:] * line.span]
    point = _framed(line, moved, value, np.concatenate(way))
    if point is not None and abs(point.slope) <= LEVEL:
        return replace(point, kept=before.character[:2])
    return None if point is None else _unreversed(before, point, float(gone[-1]))


def _is_rounding(problem: Problem, cycle: Cycle) -> bool:
    """Whether a cycle is open by no more than what errors of integration grow to on the way round.

    A motion that follows what repels it for long forgets its start, and not these.
    """
    looser = replace(problem, solver=problem.solver.with_error(AMPLIFIED))
    end = passage(looser, cycle.anchor, cycle.period, tangents=False)
    if end.stop != Stop.REACHED or end.events != cycle.around.events:
        return False
    return cycle.residual <= float(np.max(np.abs(end.state - cycle.around.state) / cycle.scales))


def _unreversed(before: Point, point: Point, gone: float) -> Point | None:
    """`point` with a direction that suits where the parameter has `gone` since `before`.

    Between cycles of the same events: where both directions contradict it the step has jumped, and
    there is no point, nor where the branch seems to turn and cannot; where the new one alone
    contradicts it, well off a fold, it is turned round.
    """
    if before.kept or before.cycle.signature != point.cycle.signature:
        return point
    if before.cycle.largest > max(UNBOUND, JUMPED * point.cycle.largest):
        return None  # a multiplier without bound does not fall at once: another cycle
    ahead, onward = gone * before.slope, before.slope * point.slope
    if ahead < 0.0 < onward:
        return None
    steep = min(abs(before.slope), abs(point.slope)) > STEEP
    if steep and onward < 0.0 < ahead:
        return replace(point, tangent=-point.tangent)
    return point if onward >= 0.0 or _can_turn(before.cycle, point.cycle) else None


def _can_turn(before: Cycle, after: Cycle) -> bool:
    """Whether a multiplier passes 1 between two cycles, as it does where their branch turns.

    None does where a motion is about to graze, and the direction of the branch has no limit.
    """
    gaps = [1.0 - np.array(cycle.nontrivial) for cycle in (before, after)]
    close = min(float(np.min(np.abs(gap), initial=np.inf)) for gap in gaps) < CLOSE_TO_ONE
    return close or bool(np.prod(gaps[0]).real * np.prod(gaps[1]).real < 0.0)


def _within(line: Continuation, value: float) -> float:
    """The edge of the bracket where `value` is there to rounding."""
    for edge in line.bracket:
        if abs(value - edge) <= max(EDGE * line.span, LAST_DIGITS * abs(edge)):
            return edge
    return value


def _later(problem: Problem, anchor: Anchor, span: float) -> Motion | None:
    """The motion through `anchor`, so much later; None where it does not last."""
    motion = begin(problem, anchor)
    return motion if motion.run(motion.time + span) == Stop.REACHED else None


def _framed(line: Continuation, cycle: Cycle, value: float, way: Vector) -> Point | None:
    """The point of the branch at `cycle`, going on along `way` (physical units)."""
    place = cycle.anchor, cycle.period, cycle.scales
    if cycle.autonomous:
        frame = across_flow(*place, cycle.around.rates)
    else:
        frame = shooting(line.at(value), *place)
    unknowns = np.append(frame.start, value / line.span)
    jacobian = _jacobian(line, frame, frame.start, value, cycle.around)
    if jacobian is None:
        return None
    n = len(frame.scales)
    scaled = np.concatenate(
        [way[:n] / frame.scales, way[n:-1] / frame.period, [way[-1] / line.span]]
    )
    if frame.normal is not None:  # the way along the flow is no way along the branch
        scaled[:n] -= (scaled[:n] @ frame.normal) * frame.normal
    gone = float(np.linalg.norm(scaled))
    inverse = inverse_of(np.vstack([jacobian, scaled / gone])) if gone > 0.0 else None
    length = 0.0 if inverse is None else float(np.linalg.norm(inverse[:, -1]))
    if inverse is None or length == 0.0:
        return None
    return Point(value, cycle, frame, unknowns, inverse[:, -1] / length, inverse)


# --- along the branch ----------------------------------------------------------------------------
def follow(
    line: Continuation, first: Point, most: int = MOST_POINTS, round_corners: bool = True
) -> tuple[list[Point], list[End]]:
    """The points of a branch from `first` on, which is not among them, and its ends.

    Parameters
    ----------
    most : points after which it is given up (an end of kind "budget")
    round_corners : whether a branch of other cycles that begins at an end is gone on with
    """
    walk = _Walk(first, first, first, round_corners)
    if first.value == line.bracket[way_of(first) > 0]:
        return [], [End(first.value, 0.0, AT_EDGE, way_of(first), False)]
    for _ in range(TRIES * most):
        if len(walk.points) >= most:
            break
        there = step(line, walk.here, walk.length)
        if there is not None:
            last = _advance(line, walk, there)
        elif is_close(line, walk.here, walk.length):
            last = _turn(line, walk)
        else:
            walk.length, walk.in_a_row = 0.5 * walk.length, 0
            continue
        if last is not None:
            return walk.cycles(), [*walk.ends, last]
    given_up = End(walk.here.value, 0.0, BUDGET, way_of(walk.here), False)
    return walk.cycles(), [*walk.ends, given_up]


@dataclass
class _Walk:
    """How far a branch has been followed.

    Attributes
    ----------
    first : the point that the branch is followed from
    here : the last point
    well : the last from which the branch went on in steps of ordinary length
    round_corners : whether other branches are gone on with
    length : of the next step
    in_a_row : steps that went well since one that did not
    points, ends : what was passed
    before : points that were passed before each of the ends
    rounded : corners that were gone round as they were met again
    """

    first: Point
    here: Point
    well: Point
    round_corners: bool
    length: float = FIRST
    in_a_row: int = PATIENCE
    points: list[Point] = field(default_factory=list)
    ends: list[End] = field(default_factory=list)
    before: list[int] = field(default_factory=list)
    rounded: list[End] = field(default_factory=list)

    def cycles(self) -> list[Point]:
        """The points, with the last before each of the ends, to which steps were bisected."""
        found = list(self.points)
        for end, place in reversed(list(zip(self.ends, self.before, strict=True))):
            known = self.points[place - 1] if place else self.first
            if end.last is not None and end.last is not known:
                found.insert(place, end.last)
        return found

    def pass_end(self, end: End) -> None:
        """Note an end at which the branch goes on."""
        self.ends.append(end)
        self.before.append(len(self.points))

    def cut_at(self, corner: End) -> None:
        """Forget what was passed after a corner."""
        place = next(n for n, end in enumerate(self.ends) if end is corner)
        del self.ends[place + 1 :], self.points[self.before[place] :], self.before[place + 1 :]

    def go_on_along(self, way: Sequence[Point]) -> None:
        """Go on with another branch, from the last of the points that lead to it from its end."""
        self.here, self.well, self.length, self.in_a_row = way[-1], way[-1], FIRST, 0
        self.points.extend(way)


def stable_until(first: Point, ends: Sequence[End]) -> End | None:
    """Which of the ends on one way along a branch is that of its stable part; None: has none."""
    if not first.cycle.stable:
        return None
    return next(end for end in ends if end.beyond is None or not end.beyond.cycle.stable)


def _advance(line: Continuation, walk: _Walk, there: Point) -> End | None:
    """Go to the next point, or to the first after a change before it; the end reached there."""
    walk.in_a_row += 1
    changes = there.character != walk.here.character
    way = [there]
    if changes:
        end, way, walk.length = _first_change(line, walk, there)
        there = way[-1]
        walk.in_a_row = 0
        if end is not None:
            walk.pass_end(end)
        if there is walk.here:  # what was found lies on another branch: this one may end here
            return _turn(line, walk) if is_close(line, there, walk.length) else None
    if walk.in_a_row >= PATIENCE:
        walk.length = min(LONGER * walk.length, LONGEST)
    if changes or walk.length >= ORDINARY:
        walk.well = there
    walk.here = there
    walk.points.extend(way)
    return _known_end(line, walk.first, walk.points)


def _turn(line: Continuation, walk: _Walk) -> End | None:
    """Go on with the branch that begins where this one ends; the end where there is none."""
    end = _last_end(line, walk)
    told_before = _told_before(line, walk.ends, end)
    if told_before is not None:
        return _again(line, walk, told_before, end)
    corner = walk.round_corners and end.kind == GRAZING
    met = [e.last for e in walk.ends if abs(e.value - end.value) <= MEETING * line.span and e.last]
    way = _round_corner(line, walk.here, met) if corner else []
    if not way:
        return end
    walk.pass_end(replace(end, goes_on=True, beyond=way[0]))
    walk.go_on_along(way)
    return None


def _told_before(line: Continuation, ends: Sequence[End], end: End) -> End | None:
    """The corner that has been gone round before, and is met again the same way.

    So close to it the two sides are no longer told apart: what was gone on with was the same side.
    """
    for one in ends if end.kind in (GRAZING, OTHER) else ():
        same_way = one.kind == GRAZING and one.direction == end.direction
        if same_way and abs(one.value - end.value) <= MEETING * line.span:
            return one
    return None


def _again(line: Continuation, walk: _Walk, corner: End, end: End) -> End | None:
    """Go round a corner that is met again at once; the end where that was tried, or cannot be.

    So close to it the cycles beyond may lie on the side from which it was come to.
    """
    is_new = walk.round_corners and not any(one is corner for one in walk.rounded)
    way = _round_corner(line, corner.last, []) if is_new and corner.last else []
    if not way:
        return _one_corner(walk, corner, end)
    walk.cut_at(corner)
    walk.ends[-1] = replace(corner, goes_on=True, beyond=way[0])
    walk.rounded.append(walk.ends[-1])
    walk.go_on_along(way)
    return None


def _one_corner(walk: _Walk, corner: End, again: End) -> End:
    """The corner as the end of the branch, as wide as it was met apart; nothing beyond it."""
    walk.cut_at(corner)
    walk.ends.pop()
    walk.before.pop()
    return replace(
        corner,
        width=again.width + abs(again.value - corner.value),
        goes_on=False,
        last=None,
        well_before=None,
        beyond=None,
    )


def _known_end(line: Continuation, first: Point, points: list[Point]) -> End | None:
    """The end that the last point has reached: an edge of the bracket, rest, or the first point."""
    here = points[-1]
    if here.value in line.bracket:
        return End(here.value, 0.0, AT_EDGE, way_of(here), False)
    if len(points) > 1 and _passes(line, first, points[-2], here):
        return End(first.value, 0.0, CLOSED, way_of(here), False)
    rest = _rest_ahead(first, *points[-2:]) if len(points) > 1 else np.nan
    if not abs(rest - here.value) <= line.width:
        return None
    return End(rest, abs(rest - here.value), AT_REST, way_of(here), False, here)


def _size(first: Point, point: Point) -> float:
    """Of a cycle, relative to the first."""
    return float(np.max(point.cycle.scales / first.cycle.scales))


def _rest_ahead(first: Point, before: Point, here: Point) -> float:
    """The parameter at which cycles that shrink are at rest; NaN where they do not, or are large.

    Towards a Hopf point it goes as the square of the amplitude.
    """
    larger, smaller = (_size(first, point) for point in (before, here))
    if smaller > SHRUNK or smaller >= larger:
        return np.nan
    share = smaller**2 / (larger**2 - smaller**2)
    return here.value + share * (here.value - before.value)


def _at_rest(walk: _Walk, here: Point) -> End | None:
    """The end where cycles that shrink are at rest, by two before the last that are larger.

    None where they tell two places, as towards a fold.
    """
    size, places = _size(walk.first, here), []
    for times in LARGER:
        before = (p for p in reversed(walk.points) if _size(walk.first, p) >= times * size)
        places.append(_rest_ahead(walk.first, next(before, here), here))
    rest, other = places
    if not abs(rest - other) <= SETTLED * abs(rest - here.value):
        return None
    return End(rest, FURTHER * abs(rest - other), AT_REST, way_of(here), False, here)


def _passes(line: Continuation, first: Point, before: Point, here: Point) -> bool:
    """Whether the branch has come round to its first cycle, the way that it set out."""
    low, high = sorted((before.value, here.value))
    if not low <= first.value <= high or way_of(here) != way_of(first):
        return False
    problem, cycle = line.at(first.value), here.cycle
    again = close(problem, cycle.anchor, cycle.period, cycle.scales)
    if again is None or abs(again.period - first.cycle.period) > SAME * again.period:
        return False
    apart = np.abs(again.extremes - first.cycle.extremes) / again.scales
    return bool(np.max(apart) <= SAME)


def moved_by(line: Continuation, here: Point) -> float:
    """How far the parameter of a cycle moves on a `line` of other tolerance, to first order.

    Across the branch's direction there; NaN where the motion does not last.
    """
    found = _conditions(line, here.frame, here.unknowns)
    if found is None:
        return float("nan")
    return float(here.inverse[-1] @ np.append(found.values, 0.0)) * line.span


def openness(line: Continuation, here: Point) -> float:
    """Change of the parameter that opens a cycle as far as this one is; NaN where none does.

    It is open by what its states' last digits are of its extent at least: a residual that is less
    is luck.
    """
    found = _conditions(line, here.frame, here.unknowns)
    jacobian = None if found is None else found.jacobian()
    rate = 0.0 if jacobian is None else float(np.linalg.norm(jacobian[:, -1]))
    gap = max(here.cycle.residual, here.cycle.last_digits)
    return gap * line.span / rate if rate > 0.0 else float("nan")


def is_close(line: Continuation, here: Point, length: float) -> bool:
    """Whether a step this long stays within what an end is bracketed to."""
    return reach_of(line, here, length) <= line.width or length < SHORTEST


def way_of(point: Point) -> int:
    return 1 if point.character[0] else -1


def reach_of(line: Continuation, here: Point, length: float) -> float:
    """Change of the parameter over a stretch of the branch."""
    return length * abs(here.slope) * line.span


def middle_of(line: Continuation, here: Point, length: float) -> float:
    """The parameter half a stretch of the branch further on."""
    return here.value + 0.5 * way_of(here) * reach_of(line, here, length)


def _first_change(
    line: Continuation, walk: _Walk, there: Point
) -> tuple[End | None, list[Point], float]:
    """The first change of character on the way to a point, the points after it, the next step.

    Where what changes is not found on the way, `there` lies on another branch: no change, and the
    last point before it.
    """
    here, away, seen = walk.here, walk.length, True
    length = _aim(here, there, away, beyond=False)
    for _ in range(BISECTIONS):
        middle = step(line, here, length)
        if middle is not None and middle.character == here.character:
            here, away = middle, away - length
            if away <= 0.0 or here.value in line.bracket:
                return None, [here], length
            length = _aim(here, there, away, beyond=True) if seen else length
            continue
        if middle is not None:
            there, away = middle, length
        if is_close(line, here, length):
            break
        seen = seen and middle is not None
        length = _aim(here, there, away, beyond=False) if seen else 0.5 * length
    near = away <= NEARBY * length
    way = [there] if near else walk.round_corners and _way_from(line, here, there)
    width, kind = 0.5 * reach_of(line, here, length), _kind_of_change(line, here, there)
    if not way:
        return None, [here], length
    value = middle_of(line, here, length)
    end = End(value, width, kind, way_of(here), True, here, walk.well, way[0])
    return end, way, max(length, FIRST * SHRUNK)


def _aim(here: Point, there: Point, away: float, beyond: bool) -> float:
    """Length of a step that ends a little before, or `beyond`, where stability changes on the way.

    Where something else changes on the way to `there`: half of it, or all.
    """
    if here.character[::2] != there.character[::2]:
        return away if beyond else 0.5 * away
    share = (here.cycle.largest - 1.0) / (here.cycle.largest - there.cycle.largest)
    return away * (min(share + ASIDE, 1.0) if beyond else max(share - ASIDE, 0.5 * share))


def _way_from(line: Continuation, here: Point, there: Point) -> list[Point]:
    """The branch of other cycles from where `here` ends to `there`; empty where it is not so.

    It is so where that branch, followed back from `there`, ends at the same grazing.
    """
    if there.cycle.signature == here.cycle.signature:
        return []
    back, ends = follow(line, _reversed(there), most=AROUND, round_corners=False)
    before = [there, *back]
    if len(ends) > 1:  # it went on beyond
        before = before[: 1 + next((n for n, one in enumerate(before) if one is ends[0].last), 0)]
    begins_here = ends[0].kind == GRAZING and (
        abs(ends[0].value - here.value) <= MEETING * line.span or _meet(here, before[-1])
    )
    return [*map(_reversed, reversed(before[1:])), there] if begins_here else []


def _meet(one: Point, other: Point) -> bool:
    """Whether two cycles are nearly one, whatever the bracket.

    Towards a grazing at which a multiplier grows without bound a branch is not followed to the end.
    """
    apart = np.abs(one.cycle.extremes - other.cycle.extremes) / one.cycle.scales
    of_period = abs(other.cycle.period / one.cycle.period - 1.0)
    return max(float(np.max(apart)), of_period) <= MEETING


def _reversed(point: Point) -> Point:
    """The same cycle, with the other direction of its branch."""
    kept = point.kept and (not point.kept[0], point.kept[1])
    return replace(point, tangent=-point.tangent, kept=kept)


def _kind_of_change(line: Continuation, here: Point, there: Point) -> str:
    if here.cycle.signature != there.cycle.signature:
        return GRAZING
    if way_of(here) != way_of(there):
        return FLIP if _is_doubled(line, here) else FOLD
    before, after = here.cycle.nontrivial, there.cycle.nontrivial
    crossing = min((*before, *after), key=lambda multiplier: abs(abs(multiplier) - 1.0))
    angle = abs(float(np.angle(crossing)))
    if angle < ON_CIRCLE and abs(crossing.imag) < 1e-6:
        return BRANCHING
    return FLIP if abs(crossing.imag) < 1e-6 else TORUS


def _is_doubled(line: Continuation, here: Point) -> bool:
    """Whether a cycle is nearly another one, of half its period, gone round twice.

    A branch of doubled cycles comes to the flip of that one, and goes back half a period on.
    """
    problem, half = line.at(here.value), 0.5 * here.cycle.period
    if problem.excitation and round(here.cycle.period / problem.excitation) % 2:
        return False
    later = _later(problem, here.cycle.anchor, half)
    return later is not None and _distance(here, later.y, here.cycle.anchor.state) < DOUBLED


# --- the end of a branch -------------------------------------------------------------------------
def _last_end(line: Continuation, walk: _Walk) -> End:
    """What ends the branch between its last cycle and the step from there that fails.

    A step fails too where the cycle foreseen lies beyond a grazing that the branch runs along, and
    would meet later: by as much as closer steps move the end, it may be off. And it fails where
    cycles shrink to rest and rounding opens them before the parameter is as close as asked.
    """
    here, length = closer(line, walk.here, walk.length)
    value = middle_of(line, here, length)
    moved = abs(value - middle_of(line, walk.here, walk.length))
    kind, further = _kind_of_end(line, here)
    width = 0.5 * reach_of(line, here, length) + moved + further
    if kind in (FOLD, OTHER, AT_REST) and (rest := _at_rest(walk, here)):
        return rest
    ahead = _in_bracket(line, here.unknowns + BEYOND[-1] * here.tangent)
    is_met = kind != OTHER or line.holding(ahead) is None
    return End(value, width, kind, way_of(here), False, here, walk.well, is_met=is_met)


def closer(line: Continuation, here: Point, length: float) -> tuple[Point, float]:
    """The last point before an end, and the step from there that fails, of shorter steps."""
    shortest = length / FURTHER
    for _ in range(TRIES_FURTHER):
        there = step(line, here, 0.5 * length)
        if there is not None and there.character == here.character:
            here = there
        elif (length := 0.5 * length) <= shortest:
            break
    return here, length


def _kind_of_end(line: Continuation, here: Point) -> tuple[str, float]:
    """By the motions a little farther along the branch, where its cycles would have been, and by
    how much more of the parameter it shows."""
    for distance in BEYOND:
        further = reach_of(line, here, distance) if distance > BEYOND[0] else 0.0
        unknowns = here.unknowns + distance * here.tangent
        value = _in_bracket(line, unknowns)
        if line.holding(value) is None:
            unmet = line.invalid(value)
            return unmet if unmet in CYCLE_END.codes else OTHER, further
        beyond = _over_period(line, here, unknowns)
        if beyond.stop == Stop.CONTACT_LOST:
            return CONTACT_LOST, further
        if beyond.stop != Stop.REACHED or beyond.events != here.cycle.around.events:
            return GRAZING, further
        if _jumps(line, here, unknowns):
            return GRAZING, further
    events = here.cycle.around.events
    if here.cycle.largest > UNBOUND:
        return GRAZING, 0.0
    if any(one.events != events for one in _beside(line, here)):
        is_upright = abs(here.slope) < UPRIGHT  # where the parameter hardly tells how far it is
        return GRAZING, _to_other_events(line, here) if is_upright else 0.0
    if here.kept and here.cycle.last_digits > BLURRED * OPEN:
        return AT_REST, 0.0  # too small for its digits, before the parameter came as close as asked
    gap = min((abs(1.0 - multiplier) for multiplier in here.cycle.nontrivial), default=0.0)
    return FOLD if abs(here.slope) < UPRIGHT and gap < CLOSE_TO_ONE else OTHER, 0.0


def _to_other_events(line: Continuation, here: Point) -> float:
    """The least change of the parameter alone, to a power of ten of the bracket, that brings other
    events; 0 where none does."""
    events, least = here.cycle.around.events, 0.0
    for distance in CHANGES:
        way = np.append(np.zeros(len(here.unknowns) - 1), distance)
        sides = (_over_period(line, here, here.unknowns + sign * way) for sign in (1.0, -1.0))
        if all(one.events == events for one in sides):
            break
        least = distance * line.span
    return least


def motions_beyond(line: Continuation, here: Point) -> Iterator[Passage]:
    """Motions over the period of the last cycle, from farther along the branch and from beside."""
    for distance in BEYOND:
        yield _over_period(line, here, here.unknowns + distance * here.tangent)
    yield from _beside(line, here)


def _beside(line: Continuation, here: Point) -> Iterator[Passage]:
    """Motions next to the last cycle, to whichever side.

    At a grazing the direction of the branch may have no limit, and what lies ahead be none of it.
    """
    return (_over_period(line, here, here.unknowns + BEYOND[0] * way) for way in _all_ways(here))


def _all_ways(here: Point) -> Matrix:
    """Each of the unknowns, up and down."""
    return np.concatenate([np.eye(len(here.unknowns)), -np.eye(len(here.unknowns))])


def _ways_with_pairs(here: Point) -> Matrix:
    """These, and then each two of the unknowns together."""
    pairs = combinations(np.eye(len(here.unknowns)), 2)
    both = np.array([one + sign * other for one, other in pairs for sign in (1.0, -1.0)])
    return np.concatenate([_all_ways(here), *(np.array([both, -both]) / np.sqrt(2.0))])


def _over_period(line: Continuation, here: Point, unknowns: Vector) -> Passage:
    """The motion from a point near the last cycle, over its period."""
    problem, anchor = line.at(_in_bracket(line, unknowns)), here.frame.anchor_of(unknowns[:-1])
    return passage(problem, anchor, here.cycle.period, tangents=False)


def _in_bracket(line: Continuation, unknowns: Vector) -> float:
    """The parameter among the unknowns, or the edge of the bracket next to it."""
    return min(max(float(unknowns[-1] * line.span), line.bracket[0]), line.bracket[1])


def _jumps(line: Continuation, here: Point, there: Vector) -> bool:
    """Whether the motion over a period jumps on the way from the last cycle to `there`.

    Where an earlier landing takes the place of a later one the sequence of events stays, and the
    motion jumps all the same. The way is halved towards the greater change: what is left of it
    on a way of no length is a jump.
    """
    low, high = here.unknowns, there
    before, after = (_over_period(line, here, unknowns).state for unknowns in (low, high))
    for _ in range(HALVINGS):
        if not _are_apart(here, before, after):
            return False
        middle = 0.5 * (low + high)
        between = _over_period(line, here, middle).state
        if _distance(here, before, between) > _distance(here, between, after):
            high, after = middle, between
        else:
            low, before = middle, between
    return _are_apart(here, before, after)


def _are_apart(here: Point, one: Vector, other: Vector) -> bool:
    return _distance(here, one, other) > APART


def _distance(here: Point, one: Vector, other: Vector) -> float:
    """Distance of two states, relative to the extent of the cycle."""
    return float(np.max(np.abs(one - other) / here.frame.scales))


def _round_corner(line: Continuation, here: Point, met: list[Point]) -> list[Point]:
    """The first points of a branch with another sequence of events that begins where this ends.

    Cycles near the last one are looked for from all sides; one counts if its own branch, followed
    back, ends at the same value of the parameter. The branches of `met`, which have ended there,
    are gone on with already. Empty where there is none.
    """
    for distance in CORNERS:
        tried = {point.cycle.signature for point in (here, *met)}
        for way in _ways_with_pairs(here):
            found = _beyond_corner(line, here, here.unknowns + distance * way)
            if found is None or found.cycle.signature in tried:
                continue
            if points := _way_from(line, here, found):
                return points
            tried.add(found.cycle.signature)
    return []


def _beyond_corner(line: Continuation, here: Point, guess: Vector) -> Point | None:
    """The nearest cycle to `guess`, where the motion has other events; None without one.

    Where that leads back to cycles of the same events: one as far from the last cycle as it is.
    """
    away = guess - here.unknowns

    def conditions(unknowns: Vector) -> Equations | None:
        return _conditions(line, here.frame, unknowns)

    def as_far(unknowns: Vector) -> Equations | None:
        found = conditions(unknowns)
        if found is None:
            return None
        values = np.append(found.values, away @ (unknowns - guess))
        return Equations(values, lambda: _with_row(found.jacobian(), away), found.around)

    first = conditions(guess)
    if first is None or first.around.events == here.cycle.around.events:
        return None
    for sought in (conditions, as_far):
        root = newton(sought, guess, reach=AHEAD)
        is_near = root is not None and np.linalg.norm(root[0] - here.unknowns) <= BESIDE
        if root and is_near and root[1].around.events != here.cycle.around.events:
            return _point(line, here, *root)
    return None
