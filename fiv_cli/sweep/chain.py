"""Chains: points of a sweep that each go on from what the one before left.

A point is given what is stored of the one before, however the chain is cut into tasks.

A step of the grid that is too long throws the motion off a branch that goes on. So where a cycle or
an equilibrium that is followed is lost, the way from the point before is gone again in shorter
steps, until they tell whether the branch reaches the point; only what these lose, too, is lost,
unless the steps of the grid alone are asked for. A chain that goes on whatever its class goes on
with what the step of the grid led to then.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, fields, replace
from typing import Any

from fiv_cli.analyses.attractor.bisection import Look, branch_end
from fiv_cli.analyses.attractor.foresight import REPEATING, foreseen
from fiv_cli.analyses.base import Batch, Outcome, Request
from fiv_cli.data.block import from_plain, to_plain
from fiv_cli.flags import is_retried
from fiv_cli.friction import get_law
from fiv_cli.sweep.requests import (
    StartEntry,
    Template,
    Values,
    continued_start,
    law_at,
    request_at,
    resolve_start,
)

UNDECIDED = "undecided"  # the class of a motion that could not be told
WIDTH = 2.0  # steps of the grid within which an end is found: no more is asked than whether
UNSURE = 0.5  # ... the next point lies before it; a chain of one point has shown no step yet
MOST_STEPS = 50  # tried on the way from one point to the next

Carry = dict[str, Any]


@dataclass(frozen=True)
class ChainState:
    """What the next point of a chain needs to know of the one before.

    Attributes
    ----------
    lost : the class that is followed was lost
    carry : `Outcome.carry` of the neighbour; None where it was lost
    attractor : class that is followed, of the last point that could be told; empty: none yet
    blocked : reason why nothing after it can be run now (an outer circumstance); empty: none
    values : axis values of the point that left `carry`; empty: none
    earlier : the same two of the point before that one; None where it was on no such branch
    begun : what the neighbour itself began with; None: the start
    last : of a class that was lost the last point of it, from where a chain that turns back goes on
    """

    lost: bool
    carry: Carry | None
    attractor: str
    blocked: str = ""
    values: list[Any] | None = None
    earlier: Carry | None = None
    begun: Carry | None = None
    last: Carry | None = None

    def is_sound(self) -> bool:
        """Whether it has the form that `plain` stores (a shard may be made by hand)."""
        words = isinstance(self.attractor, str) and isinstance(self.blocked, str)
        carries = (self.carry, self.earlier, self.begun, self.last)
        carried = all(isinstance(one, dict | None) for one in carries)
        if not (words and carried and isinstance(self.lost, bool)):
            return False
        placed = isinstance(self.values, list) if self.carry is not None else self.values is None
        behind = (self.earlier, {"values", "carry"}), (self.last, {"values", "carry", "attractor"})
        return placed and all(one is None or one.keys() == keys for one, keys in behind)

    def plain(self) -> dict[str, Any]:
        """As plain data, for a shard."""
        return {field.name: getattr(self, field.name) for field in fields(self)}


def state_after(
    outcome: Outcome, values: Values, before: ChainState | None, entry: StartEntry
) -> ChainState:
    """State of a chain after a point; the class is lost when it changes or nothing is carried.

    A chain that goes on whatever its class ends only where nothing is carried.
    A point that is undecided, its motion going on when its time was up, ends nothing: the class
    followed stays that of the points before it. A point that failed for an outer reason is run
    again on resume; until then nothing behind it is run, so that what stands behind it never
    depends on that failure.
    """
    told, followed = _told(outcome), _followed(before)
    minds = entry.spec.on_loss != "go-on"
    lost = outcome.status != "ok" or outcome.carry is None or (minds and _changes(outcome, before))
    blocked = "" if before is None else before.blocked
    if outcome.status == "failed" and is_retried(outcome.reason):
        blocked = outcome.reason
    if lost:
        return ChainState(True, None, told or followed, blocked, last=_last(before))
    carry, earlier = _stored_form(outcome.carry), None
    if before is not None and not before.lost:
        earlier = {"values": before.values, "carry": before.carry}
    return ChainState(False, carry, told or followed, blocked, list(values), earlier)


def _last(state: ChainState | None) -> Carry | None:
    """The last point of a class that is lost by now."""
    if state is None or state.lost:
        return None if state is None else state.last
    return {"values": state.values, "carry": state.carry, "attractor": state.attractor}


def _turned(entry: StartEntry, state: ChainState | None, values: Values) -> ChainState | None:
    """What a point goes on from: back where a class was lost, that is what it was lost from."""
    last = None if state is None or state.blocked else state.last
    if last is None or last["values"] != list(values) or entry.spec.on_loss == "restart":
        return state
    return ChainState(False, last["carry"], last["attractor"], values=last["values"])


def _told(outcome: Outcome) -> str:
    """The class of a motion; empty where it has none, or none that could be told."""
    attractor = str(outcome.values.get("attractor", ""))
    return "" if attractor == UNDECIDED else attractor


def _followed(before: ChainState | None) -> str:
    """The class that a chain follows; empty: none yet."""
    return "" if before is None or before.lost else before.attractor


def _changes(outcome: Outcome, before: ChainState | None) -> bool:
    """Whether the class at a point is another one than that of the chain."""
    classes = {_told(outcome), _followed(before)}
    return "" not in classes and len(classes) == 2


@dataclass(frozen=True)
class Chain:
    """Runs the points of a chain.

    Attributes
    ----------
    run : the outcome of a point
    """

    template: Template
    entry: StartEntry
    run: Callable[[Request], Outcome]

    def point(
        self, request: Request, values: Values, before: ChainState | None
    ) -> tuple[Outcome, ChainState]:
        """The outcome of a point, and what it leaves to the next one."""
        before = _turned(self.entry, before, values)
        barrier = _barrier(self.entry, before)
        if barrier:
            outcome = Outcome("not_reached", barrier)
            return outcome, state_after(outcome, values, before, self.entry)
        begun = None if before is None else before.carry
        if begun is None:
            start = resolve_start(self.template, values, self.entry)
        else:
            start = continued_start(self.entry, begun)
        outcome = self.run(replace(request, start=start))
        state = state_after(outcome, values, before, self.entry)
        shorter = self.entry.spec.steps == "shorter"
        if shorter and before is not None and _changes(outcome, before):
            way = _Way(self, before, values, request)
            if way.is_passable() and way.reaches():
                outcome, begun = way.reached
                state = state_after(outcome, values, before, self.entry)
        return outcome, replace(state, begun=begun)


class _Way:
    """The way from one point of a chain to the next, gone in steps of its own."""

    reached: tuple[Outcome, Carry | None]  # the outcome at its end, and what that began with

    def __init__(self, chain: Chain, before: ChainState, values: Values, request: Request) -> None:
        self.chain, self.before, self.values = chain, before, values
        self.requests = {values: request}
        names = [name for name, _ in chain.template.axes]
        self.place = names.index(chain.entry.spec.along)

    def is_passable(self) -> bool:
        """Whether a branch leads along it, and nothing changes but numbers in the equations."""
        assert self.before.values is not None
        stands = self.before.values[self.place] == self.values[self.place]  # where a chain turns
        if self.before.attractor not in REPEATING or stands:
            return False
        template = self.chain.template
        structural = get_law(law_at(template, self.values)).structural
        return all(
            kind == "parameter" and name not in structural
            for (name, kind), one, other in zip(
                template.axes, self.before.values, self.values, strict=True
            )
            if one != other
        )

    def reaches(self) -> bool:
        """Whether steps short enough to tell reach its end on the branch."""
        assert self.before.values is not None
        begin, end = self.before.values[self.place], self.values[self.place]
        looks = [Look(begin, True, "", self.before.carry)]
        if self.before.earlier is not None:
            earlier, carry = self.before.earlier["values"], self.before.earlier["carry"]
            looks.insert(0, Look(earlier[self.place], True, "", carry))
        share = UNSURE if self.before.earlier is None else WIDTH
        lost, width = Look(end, False, ""), share * abs(end - begin)
        found = branch_end(looks, lost, end, self._look, width, foreseen, MOST_STEPS)
        return isinstance(found, Look) and bool(found.answer)

    def _look(self, value: float, origin: Look | None) -> Look:
        """Whether a step from `origin` stays on the branch; None: not decided."""
        assert origin is not None
        entry, place = self.chain.entry, self._at(value)
        start = continued_start(entry, origin.carry)
        outcome = self.chain.run(replace(self._request(place), start=start, in_passing=True))
        state = state_after(outcome, place, self.before, entry)
        kept = not state.lost and not _changes(outcome, self.before)
        if kept and place == self.values:
            self.reached = outcome, origin.carry
        return Look(value, kept, "", state.carry)

    def _request(self, place: Values) -> Request:
        """What is asked at a place on the way; what is found there for all starts is kept."""
        if place not in self.requests:
            alone = request_at(self.chain.template, place, None)
            self.requests[place] = replace(alone, batch=Batch([alone]))
        return self.requests[place]

    def _at(self, value: float) -> Values:
        """All axis values where the one that is followed has a value on the way."""
        assert self.before.values is not None
        begin, end = self.before.values[self.place], self.values[self.place]
        share = (value - begin) / (end - begin)
        pairs = zip(self.before.values, self.values, strict=True)
        between = (b if a == b or value == end else a + share * (b - a) for a, b in pairs)
        return tuple(between)


def _barrier(entry: StartEntry, state: ChainState | None) -> str:
    """Why a point cannot be reached along its chain; empty where it can."""
    if state is None:
        return ""
    restarted = state.lost and entry.spec.on_loss == "restart"
    ended = "class_changed" if state.lost or state.carry is None else ""
    return state.blocked or ("" if restarted else ended)


def _stored_form(carry: Any) -> Carry:
    """`carry` as it would come back from a shard, so that resuming changes nothing."""
    form: Carry = from_plain(to_plain(carry))
    return form
