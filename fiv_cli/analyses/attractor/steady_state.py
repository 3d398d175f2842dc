"""The steady state reached from a start: its class, L_s, period, section, exponents.

A run ends as soon as its class is known, on the grounds of ``grounds.py``: a slide that a stable
equilibrium keeps, a cycle that Newton's method confirms, a motion that has diverged or lost
contact. When half of the time budget has not brought that, the other half is measured as a
window, with the largest Lyapunov exponent carried along; what is not known then is ``undecided``.

Definitions: L_s is the mean of the sum of (X - X_e)^2 over the displacement states (thesis 6.20),
on discs those of the slider (6.42), integrated along whole periods, or along the window. X_e is
the equilibrium that was reached or, of a motion that does not rest, the first one of the point
(`L_s_reference_index`), from which an ``equilibrium`` start is offset too.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fiv_cli.analyses.attractor.chaos import regularity, regularity_in_bands
from fiv_cli.analyses.attractor.confirm import confirm, is_drawn_to_cycle
from fiv_cli.analyses.attractor.descent import Descent
from fiv_cli.analyses.attractor.grounds import (
    CHAOTIC,
    CLOSER,
    EARLY,
    GROWN,
    KEPT,
    NEARLY,
    REGULAR,
    RESTING,
    SIGNIFICANT,
)
from fiv_cli.analyses.attractor.level_set import (
    LevelSet,
    holds_through,
    under_excitation,
)
from fiv_cli.analyses.attractor.lyapunov import Exponent, error_of_mean
from fiv_cli.analyses.attractor.own_section import (
    OWN,
    first_section,
    is_missed,
    long_enough,
    own_section,
    recorded,
    tells_more,
    turning_points,
)
from fiv_cli.analyses.attractor.rests import Rests, rests_at
from fiv_cli.analyses.attractor.settling import (
    SETTLED,
    lasting_period,
    nearest_return,
    settled_period,
)
from fiv_cli.analyses.attractor.stationarity import FEWEST, drift, parting
from fiv_cli.analyses.attractor.watch import ALMOST, FOLLOW, Watch, watch_over
from fiv_cli.analyses.base import EACH, Outcome, Request, Section, Settings
from fiv_cli.analyses.common import (
    at_once,
    balance,
    carry,
    impacts,
    initial_state,
    start_motion,
    stopped,
    trust,
)
from fiv_cli.analyses.cycles.periodic import (
    ROUNDING,
    Orbit,
    begin,
    extents,
    floquet,
    problem_of,
    repeats,
)
from fiv_cli.codegen.codes import OTHER_POWER, SEPARATION, SLIP, STICK
from fiv_cli.dynamics.arrays import NO_WORKS
from fiv_cli.dynamics.motion import Motion, Stop
from fiv_cli.dynamics.system import System, Vector

PATIENCE = 4.0  # s; ... the longest of which passes between two looks at a motion, or before one
REVOLUTIONS = 3.0  # ... without section points is asked what it is without them
BLOCKS = 64  # pieces of a measured window, between which a tangent is renormalised ...
LONGEST_BLOCK = 200.0  # ... natural periods; in longer ones it may grow beyond all numbers
SHOWN = 512  # section values stored of a motion that is not periodic
PASSAGES = 4  # along a cycle that an early attempt takes, for each state
ATTEMPT = 8000  # steps of one state that it costs beside them
UPON = (
    1e-6  # share by which the level of a slide may be off that just touches a surface, and goes on
)
SAME_VALUE = 1e-9  # share of itself by which what is the same at each section point varies
SAME_PERIOD = 1e-6  # share by which the period at the section may differ from that of the cycle


@dataclass(frozen=True)
class Followed:
    """A motion that has been followed for a while.

    Attributes
    ----------
    motion, watch : as `_Response` has them
    initial : where it began, displacements and velocities
    stop : why it is looked up from
    """

    motion: Motion
    watch: Watch
    initial: Vector
    stop: Stop


def steady_state(system: System, request: Request) -> Outcome:
    """The steady state that the start leads to."""
    return reached(system, request, at_once(system, request, rests_at))


def reached(
    system: System, request: Request, rests: Rests, followed: Followed | None = None
) -> Outcome:
    """The same where it is known what there is to come to rest at."""
    section = section_of(system, request.settings)
    response = _response(system, request, rests, section, followed)
    if isinstance(response, Outcome):
        return response
    outcome = response.outcome()
    if request.settings["section"].kind != OWN:
        return outcome
    if is_missed(outcome):
        observed = observed_of(system, request.settings)
        span = long_enough(outcome, response.patience, request.settings["t_max"])
        other = own_section(response.motion, observed, span)
        found = _response(system, request, rests, other)
        found = found if isinstance(found, Outcome) else found.outcome()
        if tells_more(found, other, outcome):
            section, outcome = other, found
    return recorded(outcome, section)


def observed_of(system: System, settings: Settings) -> str:
    """The state that is looked at."""
    return settings["observe"] or system.state_names[0]


def section_of(system: System, settings: Settings) -> Section:
    """The section that is asked for, or the one that is tried first where the motion chooses."""
    section: Section = settings["section"]
    return first_section(system, observed_of(system, settings)) if section.kind == OWN else section


def _response(
    system: System,
    request: Request,
    rests: Rests,
    section: Section,
    followed: Followed | None = None,
) -> _Response | Outcome:
    """The run from the start, judged by `section`, or the outcome that says why there is none."""
    motion = followed.motion if followed else start_motion(system, request, rests.first)
    if isinstance(motion, Outcome):
        return motion
    if section is not request.settings["section"]:
        request = replace(request, settings={**request.settings, "section": section})
    return _Response(system, request, rests, motion, followed)


def patience_of(
    system: System, parameters: Mapping[str, float], excitation: float | None, natural: float
) -> float:
    """The longest of 4 s, three revolutions of disc or excitation, three natural periods, s."""
    turning = system.setup.model.revolution
    spans = [PATIENCE]
    speed = 0.0 if turning is None else abs(turning(parameters))
    if speed > 0.0:
        spans.append(REVOLUTIONS * 2 * np.pi / speed)
    if excitation is not None:
        spans.append(REVOLUTIONS * excitation)
    if np.isfinite(natural):
        spans.append(REVOLUTIONS * natural)
    return max(spans)


def paced(natural: Any, patience: Any, asks_waiting: Any, n: int) -> dict[str, Any]:
    """What a watch is told of how often a motion is looked at, of one or of several.

    `n` : how many states it has
    """
    span = np.minimum(natural, patience)
    passages = PASSAGES * n
    return {
        "span": span,
        "shortest": span,
        "asks_waiting": asks_waiting,
        "early_passages": passages,
    }


def first_look(half: float, n: int) -> dict[str, Any]:
    """What a watch is told before the first look at a motion, beside its defaults of zero."""
    return {"until": half, "is_paced": 1, "nearness": NEARLY, "rest_tells": 1} | early(0, n)


def early(attempts: int, n: int) -> dict[str, float]:
    """What makes an early attempt worth while, after so many."""
    return {"early": [*EARLY, 0.0][attempts], "early_steps": ATTEMPT * (attempts + 1) / n}


def resting(system: System, states: Vector, kinds: NDArray[np.int64], time: Any) -> dict[str, Any]:
    """What is told of rest in a state; of several, in rows, in columns."""
    values: dict[str, Any] = {
        "attractor": "equilibrium",
        "transient_used": time,
        "energy_residual": 0.0,
    }
    for name, kind in (("stick", STICK), ("slip", SLIP), ("separation", SEPARATION)):
        share = (kinds == kind).astype(float)
        values[f"{name}_fraction"] = share if kinds.shape[-1] > 1 else share.T[0]
    for name, value in zip(system.motions, states.T, strict=False):
        values |= {f"{name}_min": value, f"{name}_max": value, f"{name}_rms": np.abs(value)}
    return values


def at_equilibrium(number: Any, margin: Any) -> dict[str, Any]:
    """What is told of an equilibrium, beside what is of rest there."""
    reached = {"equilibrium_index": number, "L_s_reference_index": number}
    return reached | {"L_s": 0.0, "decay_margin": margin}


class _Response:
    """One run on its way to a steady state."""

    def __init__(
        self,
        system: System,
        request: Request,
        rests: Rests,
        motion: Motion,
        followed: Followed | None = None,
    ) -> None:
        self.system, self.settings, self.solver = system, request.settings, request.solver
        self.problem = problem_of(system, request)
        self.ways = rests.unexcited.parameters[system.n_own_parameters : -1]
        self.rests, self.motion = rests, motion
        self.initial = followed.initial if followed else initial_state(motion)
        self.excitation = self.problem.excitation
        self.patience = patience_of(
            system, request.parameters, self.excitation, rests.natural_period
        )
        self.section = self.problem.section
        self.observed = system.state_names.index(observed_of(system, self.settings))
        self.stop: Stop = Stop.REACHED
        self.exponent_error = 0.0
        self.nearness = NEARLY  # repetition of the section that is worth an attempt to close it
        self.waiting_until = 0.0  # ... and the time before which it is not
        self.n_early = 0  # attempts before that
        self.is_unconfirmed = False  # the section repeated, and no cycle was found
        self.is_nonhyperbolic = False  # nonlinear terms lead to a neutral equilibrium, or off
        self.in_passing = request.in_passing
        self.tells_powers = self.settings.get("powers") != "none"
        self.tells_works = self.settings.get("powers") == EACH
        self.spent = {"n_steps": 0, "n_events": 0}  # before the motion was put on its cycle
        self.looked: Stop | None = None  # why the first look was taken, where it was taken before
        if followed is not None:
            self.looked, self.watch = followed.stop, followed.watch
            self._show_slides()

    @cached_property
    def watch(self) -> Watch:
        """What the motion is followed by; few that come to rest at once need it."""
        watch = watch_over(self.motion, self.ways, self.excitation, self.patience)
        waits = int(self.excitation is not None or self.rests.is_neutral)
        n = len(self.motion.y)
        watch.tell(**paced(self.rests.natural_period, self.patience, waits, n))
        watch.show("works", self._room_for_works(len(watch.times)))
        return watch

    @cached_property
    def descents(self) -> list[Descent]:
        """Slides down to the stable equilibria, of which an excitation leaves nothing but those
        that do not feel it."""
        found = self.rests.descents(anew=self.looked is None)
        if self.excitation is None:
            return found
        parameters = self.problem.parameters
        felt = (under_excitation(self.system, parameters, one.target) for one in found)
        return [Descent(target) for target in felt if target is not None]

    # --- the course of a run ----------------------------------------------------------------------
    def outcome(self) -> Outcome:
        """Follow the motion until its class is known."""
        t_max, transient = self.settings["t_max"], self.settings["transient"]
        if transient > 0.0:
            self.stop = self.motion.run(min(transient, t_max))
            self.watch.last_event = self.watch.last_point = self.motion.time
        half = transient + 0.5 * max(t_max - transient, 0.0)
        if self.looked is None:
            answer = self._ended() or self._rest() or self._settle(half)
        else:
            answer = self._settle(half)
        if answer is None and self.in_passing:
            return Outcome(reason="time_budget", values={"attractor": "undecided"})
        answer = answer or self._window(t_max)
        if answer.values["attractor"] == "undecided" and answer.status == "ok":
            answer.carry = self._carry("undecided")  # the motion goes on, whatever it is
        spent = trust(self.motion)
        answer.values |= spent | {name: spent[name] + n for name, n in self.spent.items()}
        answer.values["initial_state"] = self.initial
        self._add_reference(answer)
        return answer

    def _ended(self) -> Outcome | None:
        """The outcome of a motion that cannot go on."""
        outcome = stopped(self.stop)
        if outcome is None:
            return None
        classes = {Stop.DIVERGED: "diverged", Stop.CONTACT_LOST: "contact_lost"}
        outcome.values["attractor"] = classes.get(self.stop, "undecided")
        outcome.values["transient_used"] = self.motion.time
        return outcome

    @property
    def _goes_on(self) -> bool:
        return self.stop in (Stop.REACHED, Stop.SECTION_FULL)

    def _settle(self, until: float) -> Outcome | None:
        """Go on until the class is known; None when it is not by then."""
        while self.looked is not None or (self.motion.time < until and self._goes_on):
            answer = self._look(until, self.section, is_paced=True)
            if answer is None and self.watch.has_waited:
                answer = self._neutral() if self.excitation is None else self._forced_sliding()
            if answer is not None:
                return answer
        return self._ended()

    def _look(
        self, until: float, section: Section, measuring: bool = False, is_paced: bool = False
    ) -> Outcome | None:
        """The class, once it is known, of the motion where it may be told next."""
        stop, self.looked = self.looked, None
        if stop is None:
            self._ask(until, section, measuring, is_paced)
        if stop in (None, Stop.STEP_BUDGET):
            stop = self.motion.drive(FOLLOW.function, self.watch.address)
        self.stop = stop if stop == Stop.REACHED else self.motion.explained(stop)
        if self._has_stuck():
            return None
        rests = self._rest() if self.watch.rest_tells or self.excitation is not None else None
        return rests or (self._cycle(section) if self.watch.has_new else None)

    def _ask(self, until: float, section: Section, measuring: bool, is_paced: bool) -> None:
        """Say what the motion is followed for."""
        watch, n = self.watch, len(self.motion.y)
        watch.tell(**(first_look(until, n) | early(self.n_early, n)))
        watch.is_measuring, watch.is_paced = measuring, is_paced
        watch.nearness, watch.waiting_until = self.nearness, self.waiting_until
        watch.offset = section.phase / (2 * np.pi) * watch.interval
        self.motion.show_section(section, watch.times, watch.points, watch.works)

    def _has_stuck(self) -> bool:
        """Whether a motion that is followed as long as it slides has stuck."""
        ends = self.watch.ends_in_stick
        return bool(ends and np.any(self.motion.measures.shares[:, STICK] > 0.0))

    def _is_sliding(self) -> bool:
        """Whether all contacts slip the way they do at an equilibrium."""
        return self._all_slide() and bool((self.motion.ways == self.ways).all())

    def _all_slide(self) -> bool:
        """Whether every contact slips, stops open."""
        frame = self.motion.frame
        return bool((frame.kinds == frame.sliding_kinds).all())

    def _is_quiet(self) -> bool:
        """Whether all contacts have slipped long enough without an event."""
        waited = self.motion.time - self.watch.last_event >= self.patience * ALMOST
        return waited and self._all_slide()

    @property
    def _times(self) -> Vector:
        """Times of the section points, s."""
        return self.watch.times[: self.watch.count]

    @property
    def _points(self) -> NDArray[np.float64]:
        """Section points; shape (count, n_states)."""
        return self.watch.points[: self.watch.count, : len(self.motion.y)]

    def _map_points(self) -> NDArray[np.float64]:
        """Section points, with the phase of the excitation where there is one."""
        points = self._points
        if self.excitation is None:
            return points
        phase = 2 * np.pi * self._times / self.excitation
        reach = np.max(np.abs(points), initial=np.finfo(float).tiny)
        # Shifted by 2: a sine that is always zero must not be judged by its rounding.
        return np.column_stack([points, reach * (2 + np.cos(phase)), reach * (2 + np.sin(phase))])

    # --- at rest ----------------------------------------------------------------------------------
    def _rest(self) -> Outcome | None:
        """The equilibrium that the motion is at, or cannot but slide to."""
        if not self.motion.started:
            return None
        if self._is_sliding():
            for descent in self.descents:
                margin = descent.margin(self.motion.time, self.motion.y)
                if not math.isnan(margin):
                    return self._at_equilibrium(descent.target, margin)
            if self.springs:
                return self._held_by_springs()
            if not self.watch.knows_slides:
                self._show_slides()
        return self._stuck()

    def _show_slides(self) -> None:
        """Let machine code look at the slides."""
        slides = [descent.slide.address for descent in self.descents]
        self.watch.show("slides", np.array(slides, np.int64))
        self.watch.knows_slides = 1

    @cached_property
    def springs(self) -> list[LevelSet]:
        """Those that springs hold, where no excitation moves them."""
        targets = self.rests.level_sets if self.excitation is None else ()
        return [target for target in targets if target.keeps]

    def _held_by_springs(self) -> Outcome | None:
        """The place of rest that friction, a spring there, will not be torn off from."""
        for target in self.springs:
            there = target.where_it_ends(self.motion.y)
            if there is not None and not math.isnan(there[1]):
                outcome = self._at_equilibrium(*there)
                rest = there[0].equilibrium[: len(self.system.coordinates)]
                outcome.values["L_s_reference"] = rest
                return outcome
        return None

    def _at_equilibrium(self, target: LevelSet, margin: float) -> Outcome:
        outcome = self._resting_in(target.equilibrium)
        if self.tells_powers:
            found = target.sliding.field(target.equilibrium)
            powers = self._mean_powers([*found.energies[OTHER_POWER:], 0.0, *found.powers])
            outcome.values |= powers
        outcome.values |= at_equilibrium(int(target.number), margin)
        return outcome

    def _stuck(self) -> Outcome | None:
        """What sticks holds all and nothing moves: it stays so (a drive at standstill)."""
        if not (self.motion.is_held and self._stands_still()):
            return None
        if self.excitation is not None and not holds_through(self.motion, self.problem.parameters):
            return None
        outcome = self._resting_in(self.motion.y)
        outcome.values["decay_margin"] = 1.0
        outcome.values |= self._mean_powers(np.zeros(self._n_works))
        outcome.reason = "stuck"
        return outcome

    def _stands_still(self) -> bool:
        """Whether nothing moves, nor will.

        What contacts determine has no acceleration, whatever their forces leave by rounding.
        """
        frame, m = self.motion.frame, len(self.system.coordinates)
        moving, accelerations, inner = np.split(self.motion.rates(), [m, 2 * m])
        if moving.any() or inner.any():
            return False
        all_stick = np.all((frame.kinds == STICK) | (frame.sliding_kinds == SEPARATION))
        return self._is_held() or bool(all_stick and not accelerations.any())

    @property
    def _n_works(self) -> int:
        return len(self.motion.measures.all_works)

    def _is_held(self) -> bool:
        """Whether sticking contacts and stops determine every velocity, whatever the others do.

        Where they leave one free, a motion may stand still on the border between two basins.
        """
        motion, m = self.motion, len(self.system.coordinates)
        pushed = motion.y.copy()
        pushed[m : 2 * m] += 1.0
        index = motion.state_index
        moved = self.system.field(index, motion.coefficients, motion.time, pushed).rates
        return not np.any(moved[:m])

    def _resting_in(self, state: Vector) -> Outcome:
        values = resting(self.system, state, self.motion.kinds, self.motion.time)
        return Outcome(values=values, carry=self._carry("equilibrium") | {"state": state.tolist()})

    def _neutral(self) -> Outcome | None:
        """Undamped sliding: what is found depends on the start, so it is no attractor.

        It is measured over a beat of its frequencies. None: it may slide for a while only.
        """
        if self._is_sliding() and self.rests.undamped_levels(self.motion.y[None])[0] > 1.0 + UPON:
            return None
        if not self._keeps_its_level():
            return None
        begun, last_event = self.motion.time, self.watch.last_event
        beat = min(self.rests.longest_beat, self.settings["t_max"] - begun)
        outcome = self._measure_window(begun + max(self.patience, beat))
        if self.watch.last_event > last_event or not self._goes_on:
            return None
        outcome.reason = "neutral_oscillation"
        outcome.values["attractor"] = "undecided"
        return outcome

    def _keeps_its_level(self) -> bool:
        """Whether a slide goes on, and keeps its distance from a neutral equilibrium."""
        events, turns = self.motion.n_events, np.zeros((FEWEST, len(self.motion.y)))
        section = turning_points(self.system, self.system.state_names[self.observed])
        room = np.zeros(FEWEST), turns, NO_WORKS
        self.stop = self.motion.run(self.settings["t_max"], section, room)
        if self.motion.n_events > events or not self._goes_on:
            self.watch.last_event = self.motion.time
            return False
        levels = self.rests.undamped_levels(turns[: self.motion.n_sections])
        varies = float(np.ptp(levels)) > KEPT * levels.max(initial=0.0) if levels.size else False
        self.is_nonhyperbolic = varies and drift(levels[:, None]) != 0.0
        return not self.is_nonhyperbolic

    def _forced_sliding(self) -> Outcome | None:
        """Does a motion that never sticks repeat with the excitation? None: it sticks again.

        Only a stroboscopic section has points of it, so it is followed so until its time is up.
        """
        strobe, t_max = Section("phase"), self.settings["t_max"]
        self.watch.count = self.watch.n_scaled = 0
        begun, energy = self._start_measuring(), self.motion.energy()
        self.watch.ends_in_stick = 1
        while self.motion.time < t_max and self._goes_on:
            answer = self._look(t_max, strobe, measuring=True)
            if self._has_stuck():
                self.watch.count = self.watch.n_scaled = self.watch.ends_in_stick = 0
                return None
            if answer is not None:
                return answer
        values = {"attractor": "undecided", "transient_used": begun} | self._measured(energy)
        undecided = Outcome(reason="slide_not_decided", values=values)
        return self._ended() or self._closed_at_last() or undecided

    def _closed_at_last(self) -> Outcome | None:
        """The cycle under an excitation whose few section points repeat up to rounding, or none."""
        period = self.excitation
        cycle = None if period is None else confirm(self.problem, self.motion, period)
        return None if cycle is None else self._measured_cycle(cycle, 1, Section("phase"))

    # --- periodic ---------------------------------------------------------------------------------
    def _cycle(self, section: Section, lasting: bool = False) -> Outcome | None:
        """The cycle that the section points settle on, once it is confirmed."""
        if self.motion.time < self.waiting_until:
            return None
        points = self._map_points()
        answer = self._early_cycle(points, section)
        if answer is not None:
            return answer
        multiplicity = settled_period(points, self.nearness, remaining=np.inf)
        if lasting and not multiplicity:
            multiplicity = lasting_period(points)
        if not multiplicity:
            return None
        cycle = confirm(self.problem, self.motion, self._span(multiplicity))
        answer = None if cycle is None else self._measured_cycle(cycle, multiplicity, section)
        if answer is None:
            self._wait()
        return answer

    def _span(self, multiplicity: int) -> float:
        """Time that so many section points last took, s."""
        return float(self._times[-1] - self._times[-1 - multiplicity])

    def _early_cycle(self, points: NDArray[np.float64], section: Section) -> Outcome | None:
        """The cycle that the section points are still far from, where the way there is straight.

        An attempt is made where the motion has cost as much since the last one.
        """
        n, attempts = len(self.motion.y), self.n_early
        if attempts == len(EARLY) or n * self.motion.n_steps < ATTEMPT * (attempts + 1):
            return None
        multiplicity = settled_period(points, EARLY[attempts], remaining=np.inf)
        if not multiplicity or self.motion.time < n * PASSAGES * self._span(multiplicity):
            return None
        self.n_early += 1
        shares = (share for share in range(1, multiplicity + 1) if multiplicity % share == 0)
        return next(filter(None, (self._far_cycle(share, section) for share in shares)), None)

    def _far_cycle(self, multiplicity: int, section: Section) -> Outcome | None:
        """The cycle of so many section points that the way from here to is straight."""
        cycle = confirm(self.problem, self.motion, self._span(multiplicity), from_afar=True)
        return None if cycle is None else self._measured_cycle(cycle, multiplicity, section)

    def _wait(self) -> None:
        """No cycle yet: wait until the section repeats more closely, at last for longer."""
        if self.nearness > SETTLED:
            self.nearness = max(self.nearness * CLOSER, SETTLED)
            return
        self.is_unconfirmed = True
        self.waiting_until = 2.0 * self.motion.time

    def _measured_cycle(self, cycle: Orbit, multiplicity: int, section: Section) -> Outcome | None:
        """Measure one period on the cycle, from a section point on; None: not the section's."""
        before = self.motion
        self.motion = begin(replace(self.problem, solver=self.solver), cycle.anchor)
        self._next_points(1, section)
        begun = self._start_measuring()
        energy = self.motion.energy()
        points, works = self._next_points(multiplicity, section, measuring=True)
        period, full = self.motion.time - begun, self.stop == Stop.SECTION_FULL
        scales = extents(self.motion.extremes)
        share = repeats(self.problem, points, scales, period) if full else 1
        if not full or abs(period - cycle.period) > SAME_PERIOD * cycle.period or share > 1:
            shorter = confirm(self.problem, self.motion, period / share) if share > 1 else None
            self.motion, self.stop = before, Stop.REACHED
            if shorter is None:
                return None
            return self._measured_cycle(shorter, multiplicity // share, section)
        self.spent = {"n_steps": before.n_steps, "n_events": before.n_events}
        values: dict[str, object] = {"multiplicity": multiplicity, "transient_used": before.time}
        values |= self._measured(energy) | self._described(cycle, period)
        if self.tells_works:
            done = self._named(self.motion.measures.all_works)
            values |= {f"{name}_work": float(work) for name, work in done.items()}
        # Begun at the least value: the order tells nothing of the transient.
        first = int(np.argmin(points[:, self.observed]))
        passed = self._passed(points, np.vstack([works[:1], np.diff(works, axis=0)]))
        if section is not self.section:
            passed = {name: found[:0] for name, found in passed.items()}
        ragged = {name: np.append(found[first:], found[:first]) for name, found in passed.items()}
        return Outcome(values=values, ragged=ragged, carry=self._carry("periodic"))

    def _passed(self, points: NDArray[np.float64], works: NDArray[np.float64]) -> dict[str, Vector]:
        """What is stored of section points, and of the works since the point before each."""
        told = self._named(works.T) if self.tells_works else {}
        found = {f"section_{name}_work": work for name, work in told.items()}
        return {"section_value": points[:, self.observed], **found}

    def _described(self, cycle: Orbit, period: float) -> dict[str, object]:
        """What is known of a cycle beside its measures; `period` is that at the section, s."""
        values: dict[str, object] = {
            "attractor": "periodic",
            "period": period,
            "response_frequency": 1.0 / period,
            "cycle_residual": cycle.residual,
        }
        if self.excitation is not None:
            # of so many periods of the excitation Newton's method closed the cycle
            values["period_ratio"] = float(round(period / self.excitation))
        return values | self._floquet(cycle)

    def _next_points(
        self, count: int, section: Section, measuring: bool = False
    ) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """The states at the next section points, and the works done by then."""
        times, points = np.zeros(count), np.zeros((count, len(self.system.state_names)))
        works = self._room_for_works(count)
        until = self.motion.time + self.settings["t_max"]
        self.stop = self.motion.run(
            until, section, (times, points, works), None, measuring, self.watch.interval
        )
        return points, works

    def _room_for_works(self, count: int) -> NDArray[np.float64]:
        return np.zeros((count, self._n_works)) if self.tells_works else NO_WORKS

    def _start_measuring(self) -> float:
        reference = np.zeros(len(self.system.coordinates))
        if self.rests.first is not None:
            reference = self.rests.first[: len(reference)].copy()
        counted = self.system.setup.model.vibration or self.system.coordinates
        reference[[name not in counted for name in self.system.coordinates]] = np.nan
        self.motion.start_measuring(reference)
        return self.motion.time

    def _measured(self, energy_before: float) -> dict[str, object]:
        """Everything that was integrated along the measured stretch."""
        measures, motion = self.motion.measures, self.motion
        time = measures.measured_time
        shares = measures.shares / time
        fractions = [
            shares[:, kind] if len(shares) > 1 else float(shares[0, kind])
            for kind in (STICK, SLIP, SEPARATION)
        ]
        values: dict[str, object] = {
            "L_s": measures.spread / time,
            "L_s_window": time,
            "stick_fraction": fractions[0],
            "slip_fraction": fractions[1],
            "separation_fraction": fractions[2],
            "energy_residual": balance(motion, energy_before).residual,
        }
        values |= impacts(motion)
        values |= self._mean_powers(measures.all_works / time)
        if self.rests.first is None:
            values["L_s"] = float("nan")
        for i, name in enumerate(self.system.motions):
            values[f"{name}_min"] = float(measures.least[i])
            values[f"{name}_max"] = float(measures.greatest[i])
            values[f"{name}_rms"] = float(np.sqrt(measures.squares[i] / time))
        return values

    def _named(self, works: ArrayLike) -> dict[str, Any]:
        """Works, or powers, in the order of `Measures.all_works`, by what does them."""
        other, friction, drive, impact, *each = np.asarray(works)
        found = dict(zip(self.system.setup.model.powers, each, strict=True))
        found |= {"friction": friction, "wear": drive - friction, "drive": drive}
        return found | {"other": other, "impact": impact}

    def _mean_powers(self, powers: ArrayLike) -> dict[str, float]:
        """Mean powers, where they may be asked for."""
        if not self.tells_powers:
            return {}
        return {f"mean_{name}_power": float(p) for name, p in self._named(powers).items()}

    def _floquet(self, cycle: Orbit) -> dict[str, object]:
        """Multipliers, and the exponent of the largest nontrivial one where it is not rounding."""
        if self.settings["lyapunov"] == "never":
            return {}
        values: dict[str, object] = {**floquet(cycle.multipliers)}
        if cycle.largest > ROUNDING:
            values["lyapunov"] = float(np.log(cycle.largest) / cycle.period)
        return values

    # --- not periodic -----------------------------------------------------------------------------
    def _window(self, t_max: float) -> Outcome:
        """Measure the rest of the budget and say what its tests say."""
        self.watch.count = self.watch.n_scaled = 0
        with_exponent = self.settings["lyapunov"] != "never"
        outcome = self._measure_window(t_max, with_exponent)
        if "attractor" in outcome.values:
            return outcome
        ended = self._ended()
        if ended is not None:
            return ended
        self.waiting_until = 0.0
        answer = self._cycle(self.section, lasting=True)
        if answer is None and self.watch.count == 0:
            answer = self._closed_at_last()
        if answer is not None:
            return answer
        told, outcome.reason = self._class_of(outcome)
        if told == "quasiperiodic":
            near = nearest_return(self._map_points())
            answer = self._far_cycle(near, self.section)
            if answer is not None:
                return answer
            if is_drawn_to_cycle(self.problem, self.motion, self._span(near)):
                told, outcome.reason = "undecided", "time_budget"
        outcome.values["attractor"] = told
        if outcome.reason == "slide_not_decided":  # of a slide so short it is that of the start
            for name in ("lyapunov", "lyapunov_standard_error"):
                outcome.values.pop(name, None)
        if told != "undecided":
            outcome.carry = self._carry(told)
        return outcome

    def _measure_window(self, until: float, with_exponent: bool = False) -> Outcome:
        begun = self._start_measuring()
        energy = self.motion.energy()
        autonomous = self.excitation is None
        blocks = max(BLOCKS, math.ceil((until - begun) / self.rests.natural_period / LONGEST_BLOCK))
        exponent = Exponent(self.motion, autonomous, blocks) if with_exponent else None
        answer = self._measure_to(np.linspace(begun, until, blocks + 1)[1:], exponent)
        if answer is not None:
            return answer
        if exponent is not None:
            exponent.release()
        if self.motion.measures.measured_time <= 0.0:
            return Outcome(reason="time_budget", values={"attractor": "undecided"})
        values = self._measured(energy) | {"transient_used": begun}
        if self.rests.first is not None and self.watch.n_passed > 1:  # one stretch has no scatter
            values["L_s_standard_error"] = self._error_of_intensity()
        if exponent is not None:
            self.exponent_error = exponent.error
            if np.isfinite(exponent.mean):
                values["lyapunov"] = exponent.mean
                values["lyapunov_standard_error"] = self.exponent_error
        # Of works only the points are told up to which they have been measured from one before.
        first = np.searchsorted(self._times, begun, side="right") if self.tells_works else -1
        works = np.diff(self.watch.works[: self.watch.count][first:], axis=0)
        passed = self._passed(self._points[first + 1 :], works)
        shown = {name: found[-SHOWN:].copy() for name, found in passed.items()}
        return Outcome(values=values, ragged=shown)

    def _error_of_intensity(self) -> float:
        """Standard error of L_s as measured over the window."""
        booked = slice(self.watch.n_passed)
        spans, spreads = self.watch.spans[booked], self.watch.spreads[booked]
        return error_of_mean(np.diff(spreads, prepend=0.0), np.diff(spans, prepend=0.0))

    def _measure_to(self, goals: Vector, exponent: Exponent | None) -> Outcome | None:
        """Measure up to the last goal, keeping section points; the class as soon as it is known."""
        watch = self.watch
        watch.show("goals", goals)
        for name in ("spans", "spreads"):
            watch.show(name, np.zeros(len(goals)))
        watch.n_passed, watch.growth = 0, 0 if exponent is None else exponent.growth.address
        while watch.n_passed < len(goals) and self._goes_on:
            answer = self._look(float(goals[-1]), self.section, measuring=True)
            if answer is not None:
                return answer
        watch.show("goals", np.zeros(0))
        return None

    def _class_of(self, outcome: Outcome) -> tuple[str, str]:
        """A stationary section and two agreeing tests, or undecided."""
        if self.is_unconfirmed:
            return "undecided", "cycle_not_confirmed"
        begun = outcome.values["transient_used"]
        if self.watch.asks_waiting and self.excitation is None and self.watch.last_event <= begun:
            # what slides between two events is no torus
            return "undecided", "nonhyperbolic" if self.is_nonhyperbolic else "time_budget"
        if self.watch.count == 0:
            slides = self._is_quiet() and self.excitation is None
            return "undecided", "slide_not_decided" if slides else "no_section_points"
        exponent = outcome.values.get("lyapunov", float("nan"))
        regular, bounds = np.nan, (REGULAR, CHAOTIC)
        telling = self._points[:, self._telling()]
        if np.isfinite(exponent):
            regular = regularity(telling, bounds)
        if np.isnan(regular):
            return "undecided", "time_budget"
        if exponent > self._growth_of_chaos() and regular <= CHAOTIC:
            within = regularity_in_bands(telling, bounds)
            regular = max(regular, within)
        outcome.values["zero_one"] = regular
        told, reason = self._by_two_tests(exponent, regular)
        points, observed = self._map_points(), telling[:, None]
        # A weak mode that still dies away, or is shaken slowly, undoes no chaos, but any torus.
        m = len(self.system.coordinates)
        kinds = m, 2 * m
        moved = drift(observed) if told == "chaotic" else drift(points, kinds)
        if told == "quasiperiodic" and moved == 0.0:
            moved = abs(parting(points, kinds))
        if math.isnan(moved):
            return "undecided", "time_budget"
        outcome.values["section_drift"] = moved
        return (told, reason) if moved == 0.0 else ("undecided", "section_drifts")

    def _telling(self) -> int:
        """The state whose section values are tested: what is observed or, where it is the same at
        each, as the velocity of what comes to stick, the first that varies."""
        points, m = self._points, len(self.system.coordinates)
        reach = np.abs(points).max(axis=0)
        for kind in (slice(0, m), slice(m, 2 * m)):  # what is always 0 varies by its rounding
            reach[kind] = reach[kind].max()
        varies = np.ptp(points, axis=0) > SAME_VALUE * reach
        return self.observed if varies[self.observed] or not varies.any() else int(varies.argmax())

    def _by_two_tests(self, exponent: float, regular: float) -> tuple[str, str]:
        """What Lyapunov exponent and 0-1 test say together."""
        uncertain, window = SIGNIFICANT * self.exponent_error, self._section_time
        threshold = self._growth_of_chaos()
        if exponent > threshold and regular > CHAOTIC:
            return "chaotic", ""
        if exponent < -max(uncertain, min(self._resting_growth, GROWN) / window):  # it settles
            return "undecided", "time_budget"
        if abs(exponent) > min(threshold, self._drift_of_torus / window) or regular >= REGULAR:
            return "undecided", "tests_disagree"
        return "quasiperiodic", ""

    def _growth_of_chaos(self) -> float:
        """Exponent above which neighbours part as they do on no torus, 1/s."""
        least = min(self._resting_growth, self._drift_of_torus) / self._section_time
        return max(SIGNIFICANT * self.exponent_error, least)

    @property
    def _section_time(self) -> float:
        """From the first section point to the last, s."""
        return float(self._times[-1] - self._times[0])

    @property
    def _resting_growth(self) -> float:
        return RESTING * max(self.watch.count - 1, 1)

    @property
    def _drift_of_torus(self) -> float:
        """On a torus neighbours drift apart in proportion to time, and never approach."""
        return GROWN + float(np.log(self.watch.count))

    # --- what is handed on ------------------------------------------------------------------------
    def _carry(self, attractor: str) -> dict[str, object]:
        """State for a continuing neighbour: at phase 0 of an excitation, else where it is."""
        motion = self.motion
        if self.excitation is not None and attractor != "equilibrium":
            turns = np.ceil(motion.time / self.excitation - 1e-9)
            motion.run(turns * self.excitation)
        return carry(attractor, motion.y, (kind == STICK for kind in motion.kinds))

    def _add_reference(self, outcome: Outcome) -> None:
        if not self.rests.solutions:
            return
        number = outcome.values.setdefault("L_s_reference_index", 1)
        reference = self.rests.solutions[number - 1][: len(self.system.coordinates)]
        outcome.values.setdefault("L_s_reference", reference)
