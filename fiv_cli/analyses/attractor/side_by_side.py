"""The steady states of many points: where motions come to rest is told side by side.

Motions without an excitation are set out together. One that begins within a level set of decay, or
that the first look at it finds sure to slide to an equilibrium, is told to rest by its row among
columns; any other is followed as in ``steady_state.py``, from where it is.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fiv_cli.analyses.attractor.descent import LOOK, NOTHING
from fiv_cli.analyses.attractor.rests import Rests, landscape_at
from fiv_cli.analyses.attractor.steady_state import (
    Followed,
    at_equilibrium,
    first_look,
    paced,
    patience_of,
    reached,
    resting,
    section_of,
    steady_state,
)
from fiv_cli.analyses.attractor.watch import FOLLOW, Watch, blank_watch, followed
from fiv_cli.analyses.base import Columns, Outcome, Request
from fiv_cli.codegen.memory import WORD, Frames
from fiv_cli.dynamics.motion import SECTION_WORDS, STOPS, Motion, Stop, no_samples, section_words
from fiv_cli.dynamics.recorder import Beginning, decide, set_out
from fiv_cli.dynamics.system import System
from fiv_cli.flags import ATTRACTOR

TOLD_BY = Watch.fields["told_by"].place


def steady_states(system: System, requests: Sequence[Request]) -> Iterator[Outcome]:
    """The steady states that starts lead to, each when it is asked for.

    Columns are filled when the last one has been.
    """
    settings = requests[0].settings
    if len(requests) > 1 and settings["transient"] == 0.0 and settings.get("powers") == "none":
        yield from SideBySide(system, requests).outcomes()
    else:
        yield from (steady_state(system, request) for request in requests)


class SideBySide:
    """Motions of a system from the starts of several points."""

    def __init__(self, system: System, requests: Sequence[Request]) -> None:
        self.system, self.requests, self.settings = system, requests, requests[0].settings
        self.landscape = landscape_at(system, requests)
        pairs = zip(requests, self.landscape.begun, strict=True)
        points = [Beginning(request.parameters, state) for request, state in pairs]
        self.runs = set_out(system, requests[0].solver, points)
        begun = decide(self.runs)
        self.initial = self.runs.own("y")[:, : len(system.motions)].copy()
        self.ways = self.landscape.unexcited.parameters[:, system.n_own_parameters : -1].copy()
        self.slides_now = self._slide()
        self.is_plain = begun & self._are_plain() & (self.slides_now | self._move())
        # Of each that rests, the number of the level set that it is in.
        self.targets = np.where(self._rest_at_once(), self.landscape.ends[:-1], -1)
        self.has_moved = np.zeros(len(requests), bool)

    # --- what is known at the beginning -----------------------------------------------------------
    def _are_plain(self) -> NDArray[np.bool_]:
        """Which begin at a state of their own, and are neither excited nor held by springs."""
        names = self.system.generated.parameter_names
        excitations = [names.index(f.amplitude) for f in self.system.setup.model.forcings]
        own: NDArray[np.bool_] = (self.runs.own("parameters")[:, excitations] == 0.0).all(axis=1)
        own &= np.isfinite(self.landscape.begun).all(axis=1) & ~self.landscape.unexcited.held
        starts = (request.start for request in self.requests)
        return own & [start is not None and start.carried is None for start in starts]

    def _slide(self) -> NDArray[np.bool_]:
        """Which slide the way they do at an equilibrium."""
        own = self.runs.own("parameters")[:, self.system.n_own_parameters : -1]
        sliding = self.runs.own("kinds") == self.runs.blank.sliding_kinds
        return np.asarray(sliding.all(axis=1) & (own == self.ways).all(axis=1))

    def _move(self) -> NDArray[np.bool_]:
        """Which do not stand still: what does may be stuck."""
        kinds, moving = self.runs.own("kinds"), ~self.slides_now
        states = kinds @ 3 ** np.arange(kinds.shape[1])
        for index in set(states[moving].tolist()):
            rows = np.flatnonzero(moving & (states == index))
            if self.system.tables.field[index]:
                there = self.runs.own("coefficients")[rows], 0.0, self.runs.own("y")[rows]
                moving[rows] = self.system.field(index, *there).rates.any(axis=1)
        return moving

    def _rest_at_once(self) -> NDArray[np.bool_]:
        """Which begin in the first level set of theirs."""
        ends, levels = self.landscape.ends, self.landscape.level_sets
        rest = self.is_plain & self.slides_now & (np.diff(ends) > 0)
        first = ends[:-1][rest]
        there = (self.runs.own("y")[rest] == levels.asked[first]).all(axis=1)
        rest[rest] = there & ~np.isnan(levels.answer[first])
        return rest

    # --- going on ---------------------------------------------------------------------------------
    def outcomes(self) -> Iterator[Outcome]:
        """What comes of each, when it is asked for."""
        columns = Columns({}, {}, np.zeros(len(self.requests), np.int64))
        try:
            for row, target in enumerate(self.targets.tolist()):
                stop = self._first_look(row) if target < 0 and self.is_plain[row] else None
                if self.targets[row] >= 0:
                    yield Outcome(columns=columns, row=row)
                else:
                    yield self._alone(row, stop)
        finally:
            columns.values.update(self._columns())

    def _first_look(self, row: int) -> int | None:
        """Follow a motion to the first look that may tell something; None: it tells already."""
        first, end = self.landscape.ends.item(row), self.landscape.ends.item(row + 1)
        if self.slides_now[row]:
            for number in range(first, end):
                if LOOK.function(self._slides_at[number], 0.0, self._states_at[row]) != NOTHING:
                    return None
        code: int = FOLLOW.function(self._watches_at[row])
        told_by = self.watches.words.item((row, TOLD_BY))
        if code <= Stop.SECTION_FULL and told_by >= 0:
            self.targets[row], self.has_moved[row] = first + told_by, True
        return code

    def _alone(self, row: int, code: int | None) -> Outcome:
        """Follow a motion on, alone."""
        request, rests = self.requests[row], Rests(self.landscape, row)
        if code is None:
            return reached(self.system, request, rests)
        frame, samples = self.runs.frame(row), no_samples(self.system)
        motion = Motion.of_frame(self.system, request.solver, frame, samples, has_begun=True)
        so_far = Followed(motion, self.watches.frame(row), self.initial[row], STOPS[code])
        return reached(self.system, request, rests, so_far)

    @cached_property
    def watches(self) -> Frames[Watch]:
        """What follows the motions."""
        n, half = len(self.system.state_names), 0.5 * self.settings["t_max"]
        rests = [Rests(self.landscape, row) for row in range(len(self.requests))]
        natural = np.array([one.natural_period for one in rests])
        patience = np.array([
            patience_of(self.system, request.parameters, None, period)
            for request, period in zip(self.requests, natural.tolist(), strict=True)
        ])  # fmt: skip
        section, blank = section_of(self.system, self.settings), blank_watch(n)
        watches = Frames(blank, len(rests))
        watches.show_rows("ways", self.ways)
        watches.show_parts("slides", np.array(self._slides_at, np.int64), self.landscape.ends)
        watches.tell(**followed(self.runs.addresses, patience), **first_look(half, n))
        watches.tell(**paced(natural, patience, [one.is_neutral for one in rests], n))
        offset = section.phase / (2 * np.pi) * patience
        watches.tell(may_rest=1, knows_slides=1, told_by=-1, offset=offset)
        self.runs.words[:, SECTION_WORDS] = section_words(self.system, section)
        for name, array in (("times", blank.times), ("states", blank.points)):
            self.runs.show(f"section_{name}", array)
        return watches

    @cached_property
    def _slides_at(self) -> list[int]:
        return self.landscape.slides.addresses if len(self.landscape.level_sets.number) else []

    @cached_property
    def _watches_at(self) -> list[int]:
        return self.watches.addresses

    @cached_property
    def _states_at(self) -> list[int]:
        """Where the state of each motion is."""
        first = WORD * self.runs.blank.parts["y"].start
        return [address + first for address in self.runs.addresses]

    # --- what came of it --------------------------------------------------------------------------
    def _columns(self) -> dict[str, NDArray[Any]]:
        """What is told of those that rest; of the others their rows say nothing."""
        levels, count = self.landscape.level_sets, len(self.requests)
        if not len(levels.number):
            return {}
        targets, kinds = np.maximum(self.targets, 0), self.runs.own("kinds")
        states = levels.equilibrium[targets]
        values = resting(self.system, states, kinds, self._told("time"))
        values |= at_equilibrium(levels.number[targets], self._margins(targets))
        values |= {"attractor": np.int8(ATTRACTOR.codes["equilibrium"])}
        values |= {name: self._told(name) for name in ("n_steps", "n_events")}
        values |= {"event_residual": self._told("largest_residual"), "initial_state": self.initial}
        values["L_s_reference"] = states[:, : len(self.system.coordinates)]
        return {
            name: np.broadcast_to(value, (count, *np.shape(value)[1:]))
            for name, value in values.items()
        }

    def _told(self, name: str) -> NDArray[Any]:
        return self.runs.told(name).copy()

    def _margins(self, targets: NDArray[np.intp]) -> NDArray[np.float64]:
        """1 - V/c where each was told to rest: at its beginning, or when it was looked at."""
        answers = self.landscape.level_sets.answer[targets]
        if not self.has_moved.any():
            return answers
        levels = self.landscape.slides.told("level")[targets]
        return np.where(self.has_moved, 1.0 - levels, answers)
