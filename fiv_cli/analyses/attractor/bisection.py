"""Where the answer to a question changes along a line: a scan, then bisection of each change.

Pure search: what is asked, and what a look costs, is the business of the function that looks. A
look may come out open (nothing was decided); such a look is never taken for a yes or a no, and the
stretch that it lies in is as wide as what was decided on both sides says.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial
from itertools import pairwise
from typing import Any

import numpy as np


@dataclass(frozen=True)
class Look:
    """What was found at one value.

    Attributes
    ----------
    value : where
    answer : yes, no, or None: open
    label : class that was found
    carry : what a look that goes on from here starts with; None: nothing can
    """

    value: float
    answer: bool | None
    label: str
    carry: Any = None


MOST_LOOKS = 300
"""Looks that the end of one branch may cost."""

FINER = 8.0
"""How much shorter than the width asked for the last steps along a branch are at least."""

SAFETY = 2.0
"""How many times farther than it seems a branch may go on."""

WIDENING = 4.0
"""Growth of the distance at which a change is looked for that closer looks find elsewhere."""

NARROWER = 4.0
"""How much more closely than a change the end of its branch is looked for by closer looks."""

Looking = Callable[[float, Look | None], Look]
"""Looks at a value, going on from an earlier look, or (None) from the start."""

Foreseeing = Callable[[Look, Look, float], Look | None]
"""What a look at a value would go on from where a branch leads through two looks; None: unknown."""


def unforeseen(earlier: Look, last: Look, value: float) -> None:
    """Nothing is known of where a branch leads."""


@dataclass(frozen=True)
class Change:
    """Two looks with different answers, the first one visited first."""

    before: Look
    after: Look

    @property
    def low(self) -> Look:
        """The look at the lower value."""
        return min(self.before, self.after, key=lambda look: look.value)

    @property
    def high(self) -> Look:
        """The look at the higher value."""
        return max(self.before, self.after, key=lambda look: look.value)

    @property
    def middle(self) -> float:
        """The best guess of where the answer changes."""
        return 0.5 * (self.low.value + self.high.value)

    @property
    def width(self) -> float:
        """Length of the stretch within which it changes."""
        return self.high.value - self.low.value

    @property
    def decided(self) -> bool:
        """Whether both sides have an answer."""
        return self.before.answer is not None and self.after.answer is not None


@dataclass(frozen=True)
class Found:
    """The looks of a scan in the order in which they were taken, and the changes between them."""

    looks: list[Look]
    changes: list[Change]


def scanned(values: Sequence[float], look: Looking, width: float) -> Found:
    """Looks at all values, each from the start, and every change between them."""
    looks = [look(value, None) for value in values]
    decided = [place for place, taken in enumerate(looks) if taken.answer is not None]
    changes = []
    for place, following in pairwise(decided):
        before, after = looks[place], looks[following]
        if before.answer != after.answer:
            changes.append(_bisected(before, after, looks[place + 1 : following], look, width))
    return Found(looks, in_order([*changes, *open_steps(looks)]))


def followed(
    values: Sequence[float],
    look: Looking,
    width: float,
    first: Look | None = None,
    foresee: Foreseeing = unforeseen,
) -> Found:
    """Looks at values in turn, each going on from the one before, and the ends of what is followed.

    The end of a branch is approached along the branch, see `branch_end`. Nothing more is looked at
    where nothing is left to go on from.

    Parameters
    ----------
    first : the look at the first of the values, if it has been taken
    """
    looks = [look(values[0], None) if first is None else first]
    changes = []
    for value in values[1:]:
        if looks[-1].carry is None:
            break
        reached = look(value, looks[-1])
        place = _last_decided(looks)
        if place is not None and reached.answer not in (None, looks[place].answer):
            end = branch_end(looks, reached, values[-1], look, width, foresee)
            if isinstance(end, Change):
                changes.append(end)
            else:
                reached = end
        looks.append(reached)
    return Found(looks, in_order([*changes, *open_steps(looks)]))


def branch_end(
    looks: Sequence[Look],
    target: Look,
    limit: float,
    look: Looking,
    width: float,
    foresee: Foreseeing = unforeseen,
    most: int = MOST_LOOKS,
) -> Change | Look:
    """The end of a branch that was left on the way to `target`, or a look there that is on it.

    A step that is too long falls off a branch that goes on. How long it may be shrinks towards the
    end, mostly in proportion to what is left; so by how many times the length of a step that fell
    off the branch went on after it, it may go on after the last one, too. The end is approached by
    ever shorter steps, from the last look on the branch and from where the branch is foreseen,
    until what may be left of it is within `width`, or `most` looks are taken. It is said to lie
    within that.

    Parameters
    ----------
    looks : those before, in turn; the last decided one is on the branch
    limit : nothing is looked at beyond it
    """
    return _Branch(looks, target, limit, look, width, foresee).end(most)


def _last_decided(looks: Sequence[Look]) -> int | None:
    places = [place for place, one in enumerate(looks) if one.answer is not None]
    return places[-1] if places else None


def open_steps(looks: Sequence[Look]) -> list[Change]:
    """Steps between a decided look and an open one that lie on no stretch between yes and no.

    Nothing is known of what happens there; the steps are left as wide as they are.
    """
    decided = [place for place, one in enumerate(looks) if one.answer is not None]
    between = {
        place
        for first, last in pairwise(decided)
        if looks[first].answer != looks[last].answer
        for place in range(first, last)
    }
    return [
        Change(before, after)
        for place, (before, after) in enumerate(pairwise(looks))
        if (before.answer is None) != (after.answer is None) and place not in between
    ]


def in_order(changes: Sequence[Change]) -> list[Change]:
    """Changes by rising value."""
    return sorted(changes, key=lambda change: change.middle)


def _bisected(
    before: Look, after: Look, inside: Sequence[Look], look: Looking, width: float
) -> Change:
    """A change between two decided looks with open ones inside, each look from the start."""
    while True:
        value = _next_value(before, inside, after, width)
        if value is None:
            return Change(before, after)
        here = look(value, None)
        if here.answer is None:
            inside = _sorted([*inside, here], before)
        elif here.answer == before.answer:
            before, inside = here, _between(inside, here, after)
        else:
            after, inside = here, _between(inside, before, here)


class _Branch:
    """A branch that was left on the way from one look to another, followed to its end."""

    def __init__(
        self,
        looks: Sequence[Look],
        target: Look,
        limit: float,
        look: Looking,
        width: float,
        foresee: Foreseeing,
    ) -> None:
        decided = [place for place, one in enumerate(looks) if one.answer is not None]
        self.before = self.origin = looks[decided[-1]]
        on_it = [looks[place] for place in decided[-2:]]
        self.earlier = on_it[0] if on_it[0].answer == self.before.answer else self.before
        self.target, self.limit = target, limit
        self.inside = list(looks[decided[-1] + 1 :])
        self.off = [target]  # looks off the branch, the nearest last
        self.look, self.foresee = look, foresee
        self.width, self.finest = width, width / FINER
        self.falls = [self._step_to(target.value)]  # what fell off: from where, by how long a step
        self.has_moved = False  # whether a look has gone on since

    def end(self, most: int) -> Change | Look:
        """The end of the branch, or a look at the target where it has none on the way."""
        ahead = None if self.inside else self._foreseen(self.target.value)
        if ahead is not None:
            reached = self.look(self.target.value, ahead)
            if reached.answer == self.before.answer:
                return reached
        for left in reversed(range(most)):
            value = self._next_value() if left else None
            place = self._beyond() if value is None else value
            if value is None and self._step_to(place) in self.falls:  # the target, looked at first
                self.off.append(self.target)
                break
            here = self._look_on(place)
            self._take(here)
            if not self.off:
                is_there = here.value == self.target.value
                return here if is_there else self.look(self.target.value, self.origin)
            if value is None and not self.has_moved:
                break
        return Change(self.before, self.off[-1])

    def _next_value(self) -> float | None:
        """Where to look next; None where no more than the width may be left of the branch."""
        if self.has_moved:  # a step from nearer by may not fall off there
            return self.off[-1].value
        value = _next_value(self.before, self.inside, self.off[-1], self.finest)
        if value is None and self._may_go_on():
            self.finest = 0.5 * self._step_to(self.off[-1].value)[1]
            value = _next_value(self.before, self.inside, self.off[-1], self.finest)
        return value

    def _may_go_on(self) -> bool:
        """Whether the branch may go on for longer than the width, or up to the limit."""
        return self._rest() > self.width or self._rest() >= self._step_to(self.limit)[1]

    def _rest(self) -> float:
        """How far the branch may go on, see `branch_end`."""
        place, length = self._step_to(self.off[-1].value)
        farthest = max(abs(place - start) / fallen for start, fallen in self.falls)
        return SAFETY * length * (1.0 + farthest)

    def _beyond(self) -> float:
        """The value that far ahead, and the width at least, or the limit."""
        place, ahead = self._step_to(self.limit)
        share = min(max(self.width, self._rest()) / ahead, 1.0)
        return place + share * (self.limit - place)

    def _step_to(self, value: float) -> tuple[float, float]:
        """From where a look at a value goes on, and how far."""
        place = self._origin_of(value).value
        return place, abs(value - place)

    def _origin_of(self, value: float) -> Look:
        """The nearest look behind a value that something can go on from, an open one too."""
        ahead = abs(value - self.before.value)
        behind = [one for one in self.inside if abs(one.value - self.before.value) < ahead]
        return next((one for one in reversed(behind) if one.carry is not None), self.origin)

    def _look_on(self, value: float) -> Look:
        """A look that goes on along the branch: from where it is foreseen, or from the last one."""
        origin = self._origin_of(value)
        ahead = self._foreseen(value) if origin is self.origin else None
        first = None if ahead is None else self.look(value, ahead)
        if first is not None and first.answer == self.before.answer:
            return first
        here = self.look(value, origin)
        falls = here.answer not in (None, self.before.answer)
        return first if first is not None and first.answer is None and falls else here

    def _foreseen(self, value: float) -> Look | None:
        """What a look foresees to go on from."""
        if self.earlier is self.origin:
            return None
        return self.foresee(self.earlier, self.origin, value)

    def _take(self, here: Look) -> None:
        """Book a look on the way."""
        if here.answer not in (None, self.before.answer):
            self.falls.append(self._step_to(here.value))
            self.off.append(here)
            self.inside = _between(self.inside, self.before, here)
            self.has_moved = False
            return
        if here.answer is None:
            self.inside = _sorted([*self.inside, here], self.before)
            self.has_moved = here is self.inside[-1]
        else:
            self._advance(here)
        ahead = abs(self.target.value - here.value)
        self.off = [one for one in self.off if abs(self.target.value - one.value) < ahead]

    def _advance(self, here: Look) -> None:
        """Go on from a look that is still on the branch."""
        self.before, self.has_moved = here, True
        if here.carry is not None:
            self.earlier, self.origin = self.origin, here
        self.inside = _between(self.inside, here, self.target)


def confirmed_within(
    change: Change,
    look: Looking,
    origin: Look | None,
    limits: tuple[float, float],
    foresee: Foreseeing = unforeseen,
) -> float:
    """Distance from the middle of a change within which closer looks find it, too.

    Both sides are looked at again, and then ever farther from the middle until the answer is what
    it was; where looks go on from one another, the end of the branch is looked for in between. NaN
    where a side is open, or the limits are reached before.

    Parameters
    ----------
    look : closer than those that found the change
    origin : what each look goes on from; None: the start
    limits : values that may be looked at
    foresee : where a branch leads, see `branch_end`
    """
    if not change.decided:
        return float("nan")
    closer = partial(_held, change=change, look=look, limits=limits)
    before, after = closer(change.before, origin), closer(change.after, origin)
    sides = [before, after]
    if origin is not None and before is not None:
        width = change.after.value - change.before.value
        well_before = look(float(np.clip(before.value - width, *limits)), before)
        on_it, limit = [well_before, before], limits[width > 0.0]
        while after is not None:
            end = branch_end(on_it, after, limit, look, change.width / NARROWER, foresee)
            if isinstance(end, Change):
                sides += [end.before, end.after]
                break
            on_it.append(end)  # closer looks are on the branch still
            after = closer(replace(change.after, value=end.value), end)
            sides.append(after)
    off = [float("nan") if one is None else abs(one.value - change.middle) for one in sides]
    return float(np.max(off))


def _held(
    side: Look, origin: Look | None, change: Change, look: Looking, limits: tuple[float, float]
) -> Look | None:
    """A look at a side of a change, or ever farther from its middle, with the answer there."""
    value, away = side.value, side.value - change.middle
    here = look(value, origin)
    while here.answer != side.answer:
        if value in limits:
            return None
        away *= WIDENING
        value = min(max(change.middle + away, limits[0]), limits[1])
        here = look(value, origin)
    return here


def _next_value(before: Look, inside: Sequence[Look], after: Look, width: float) -> float | None:
    """The middle of the wider stretch between what is decided and what is open; None: enough."""
    ends = [(before, inside[0]), (inside[-1], after)] if inside else [(before, after)]
    begin, end = max(ends, key=lambda pair: abs(pair[1].value - pair[0].value))
    value = 0.5 * (begin.value + end.value)
    enough = abs(end.value - begin.value) <= width or value in (begin.value, end.value)
    return None if enough else value


def _sorted(looks: Sequence[Look], first: Look) -> list[Look]:
    return sorted(looks, key=lambda one: abs(one.value - first.value))


def _between(looks: Sequence[Look], begin: Look, end: Look) -> list[Look]:
    """The looks strictly between two others."""
    low, high = sorted((begin.value, end.value))
    return [one for one in looks if low < one.value < high]


@dataclass(frozen=True)
class Edge:
    """An end of a range.

    Attributes
    ----------
    value : where
    kind : "change": an answer changes there; "bracket": no more was looked at; "undecided": no
        more is known
    width : how well it is known; NaN where nothing changes
    """

    value: float
    kind: str
    width: float = float("nan")


@dataclass(frozen=True)
class Range:
    """A stretch in which the way up and the way back have different answers."""

    low: Edge
    high: Edge


def hysteresis(up: Found, back: Found, bracket: tuple[float, float]) -> list[Range]:
    """Stretches of `bracket` in which the way up and the way back have different answers.

    Where one of the ways has none it is not known whether they differ.
    """
    ways = [_answers(found, bracket) for found in (up, back)]
    edges = sorted([edge for way in ways for edge, _ in way], key=lambda edge: edge.value)
    edges = [*edges, Edge(bracket[1], "bracket")]
    ranges = [Range(low, high) for low, high in pairwise(edges) if _differ(ways, low, high)]
    return [one for one in ranges if not _is_doubtful(one)]


def _answers(found: Found, bracket: tuple[float, float]) -> list[tuple[Edge, bool | None]]:
    """The answer behind each edge on one way, the first one that of the bracket."""
    looks = sorted(found.looks, key=lambda one: one.value)
    begin = Edge(bracket[0], "bracket"), None if looks[0].value > bracket[0] else looks[0].answer
    ends = [(Edge(looks[0].value, "undecided"), looks[0].answer)] * (looks[0].value > bracket[0])
    for change in found.changes:
        edge = Edge(change.middle, "change", change.width)
        if not change.decided:
            known = change.low if change.high.answer is None else change.high
            edge = Edge(known.value, "undecided")
        ends.append((edge, change.high.answer))
    return [begin, *sorted(ends, key=lambda end: end[0].value)]


def _differ(ways: Sequence[Sequence[tuple[Edge, bool | None]]], low: Edge, high: Edge) -> bool:
    """Whether both ways have answers between two edges next to each other, and other ones."""
    middle = 0.5 * (low.value + high.value)
    one, other = ([answer for edge, answer in way if edge.value <= middle][-1] for way in ways)
    return low.value < high.value and None not in (one, other) and one != other


def _is_doubtful(one: Range) -> bool:
    """Whether both ends may be the same."""
    return one.high.value - one.low.value <= 0.5 * (one.low.width + one.high.width)
