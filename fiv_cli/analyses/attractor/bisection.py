"""Where the answer to a question changes along a line: a scan, then bisection of each change.

Pure search: what is asked, and what a look costs, is the business of the function that looks. A
look may come out open (nothing was decided); such a look is never taken for a yes or a no, and the
stretch that it lies in is as wide as what was decided on both sides says.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
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
"""How much shorter than the width asked for the last steps along a branch are."""

WIDENING = 4.0
"""Growth of the distance at which a change is looked for that closer looks find elsewhere."""

Looking = Callable[[float, Look | None], Look]
"""Looks at a value, going on from an earlier look, or (None) from the start."""


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
    values: Sequence[float], look: Looking, width: float, first: Look | None = None
) -> Found:
    """Looks at values in turn, each going on from the one before, and the ends of what is followed.

    The end of a branch is approached along the branch, by ever shorter steps. A step that was too
    long falls off a branch that goes on, so an end counts when a step `FINER` times shorter than
    `width` has fallen off, too, and it is said to lie within `width` of the last look on the
    branch. Nothing more is looked at where nothing is left to go on from.

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
            end = _Branch(looks[place], reached, looks[place + 1 :], look, width).end()
            if isinstance(end, Change):
                changes.append(end)
            else:
                reached = end
        looks.append(reached)
    return Found(looks, in_order([*changes, *open_steps(looks)]))


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
        self, before: Look, target: Look, inside: Sequence[Look], look: Looking, width: float
    ) -> None:
        self.before = self.origin = before
        self.target = target
        self.inside = list(inside)
        self.off = [target]  # looks off the branch, the nearest last
        self.look = look
        self.width = width

    def end(self) -> Change | Look:
        """The end of the branch, or a look at the target where it has none on the way.

        A branch that bears none but tiny steps is left after `MOST_LOOKS`, at the width reached.
        """
        for _ in range(MOST_LOOKS):
            value = _next_value(self.before, self.inside, self.off[-1], self.width / FINER)
            if value is not None:
                self._take(self._look_on(value))
            elif not self._goes_on():
                break
            if not self.off:
                return self.before
        return Change(self.before, self.off[-1])

    def _look_on(self, value: float) -> Look:
        """A look that goes on from the nearest one behind it, an open one too."""
        ahead = abs(value - self.before.value)
        behind = [one for one in self.inside if abs(one.value - self.before.value) < ahead]
        able = [one for one in behind if one.carry is not None]
        return self.look(value, able[-1] if able else self.origin)

    def _take(self, here: Look) -> None:
        """Book a look on the way."""
        if here.answer is None:
            self.inside = _sorted([*self.inside, here], self.before)
        elif here.answer == self.before.answer:
            self._advance(here)
        else:
            self.off.append(here)
            self.inside = _between(self.inside, self.before, here)

    def _advance(self, here: Look) -> None:
        """Go on from a look that is still on the branch."""
        self.before, self.origin = here, here if here.carry is not None else self.origin
        ahead = abs(self.target.value - here.value)
        self.off = [one for one in self.off if abs(self.target.value - one.value) < ahead]
        if self.off:
            self.inside = _between(self.inside, here, self.off[-1])

    def _goes_on(self) -> bool:
        """Whether the branch bears one more step, of what is left or of the width asked for."""
        for value in (self.off[-1].value, self._at_width()):
            here = self._look_on(value)
            if here.answer == self.before.answer:
                self._advance(here)
                return True
        if here.answer is not None and abs(self.off[-1].value - self.before.value) < self.width:
            self.off.append(here)
        return False

    def _at_width(self) -> float:
        """The value one width further on, or the target."""
        ahead = self.target.value - self.before.value
        return self.before.value + max(-self.width, min(self.width, ahead))


def confirmed_within(
    change: Change, look: Looking, origin: Look | None, limits: tuple[float, float]
) -> float:
    """Distance from the middle of a change within which closer looks find it, too.

    Both sides are looked at again, and then ever farther from the middle until the answer is what
    it was. NaN where a side is open, or the limits are reached before.

    Parameters
    ----------
    look : closer than those that found the change
    origin : what each look goes on from; None: the start
    limits : values that may be looked at
    """
    if not change.decided:
        return float("nan")
    sides = (change.low, change.high)
    return float(np.max([_held_from(side, change, look, origin, limits) for side in sides]))


def _held_from(
    side: Look, change: Change, look: Looking, origin: Look | None, limits: tuple[float, float]
) -> float:
    """Distance from the middle of a change at which the answer is that of a side of it."""
    value, away = side.value, side.value - change.middle
    while look(value, origin).answer != side.answer:
        if value in limits:
            return float("nan")
        away *= WIDENING
        value = min(max(change.middle + away, limits[0]), limits[1])
    return abs(value - change.middle)


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
class Range:
    """A stretch in which the way up and the way back have different answers.

    Attributes
    ----------
    low, high : its ends
    low_width, high_width : how well they are known; NaN where an end is that of the bracket
    """

    low: float
    high: float
    low_width: float
    high_width: float


def hysteresis(
    up: Sequence[Change], back: Sequence[Change], bracket: tuple[float, float]
) -> list[Range]:
    """Stretches of `bracket` in which the way up and the way back have different answers.

    Parameters
    ----------
    up, back : decided changes on the way up, and on the way back from its end, in any order.
        Both ways agree at the upper end, where one goes over into the other
    """
    ends = sorted((change.middle, change.width) for change in (*up, *back))
    if len(ends) % 2 == 1:
        ends.insert(0, (bracket[0], float("nan")))
    pairs = zip(ends[::2], ends[1::2], strict=True)
    ranges = [Range(low, high, width, other) for (low, width), (high, other) in pairs]
    return [
        one for one in ranges if not one.high - one.low <= 0.5 * (one.low_width + one.high_width)
    ]
