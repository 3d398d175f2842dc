"""From a start to a cycle, to its branch, to what is stored of them."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import asdict, replace
from functools import partial
from itertools import product
from typing import Any, cast

import numpy as np

from fiv_cli.analyses.attractor.own_section import (
    OWN,
    first_section,
    own_section,
    recorded,
    turning_points,
)
from fiv_cli.analyses.base import Outcome, Request, Section, Settings
from fiv_cli.analyses.common import carry, rest_of, start_motion, stopped
from fiv_cli.analyses.cycles.branch import (
    CLOSED,
    Continuation,
    End,
    Point,
    first_point,
    follow,
    stable_until,
)
from fiv_cli.analyses.cycles.end_error import end_error
from fiv_cli.analyses.cycles.first_guess import (
    Begin,
    Guess,
    Returns,
    guess_between,
    guesses,
    returns,
)
from fiv_cli.analyses.cycles.grazed import grazed
from fiv_cli.analyses.cycles.periodic import Anchor, Cycle, Problem, close, floquet, problem_of
from fiv_cli.dynamics.system import System

NEUTRAL = 1e-8  # distance from 1 at which a multiplier is 1 to the accuracy of a cycle
STRIDE = 0.1  # share by which the period may change from neighbour to neighbour
COURSE, LEAST_RETURNS = 8.5, 2  # of its last returns in time, and so many, by which is told ...
SETTLED = 1e-3  # ... whether a swing grows or dies away: by which share it changes at least
ELSEWHERE = (0.5, 0.1, 0.9)  # of the way to an end of the bracket, where a cycle is looked for
BRIDGES = 5  # halvings of the way between neighbours


def find_cycle(system: System, request: Request) -> Outcome:
    """The cycle near what the start leads to, and its branch where a parameter is given."""
    start = request.start
    carried = start.carried if start is not None and start.kind == "continue" else None
    problem = problem_of(system, request)
    if carried is not None:
        outcome, begun = _continued(problem, request, carried), np.array(carried["state"])
    else:
        _, solutions = rest_of(system, request)
        exact = replace(request, solver=problem.solver)
        begin = partial(start_motion, system, exact, solutions[0] if solutions else None)
        first = begin()
        if isinstance(first, Outcome):
            return first
        outcome, begun = _reached(problem, request, cast(Begin, begin)), first.y
        if outcome.reason == "no_cycle" and request.settings["parameter"] is not None:
            outcome.message += _elsewhere(system, request)
    outcome.values["initial_state"] = begun[: 2 * len(system.coordinates)].copy()
    return outcome


# --- the cycle -----------------------------------------------------------------------------------
def _continued(problem: Problem, request: Request, carried: Mapping[str, Any]) -> Outcome:
    """What becomes of the cycle of a neighbour."""
    if problem.section.kind == OWN:
        problem = replace(problem, section=Section(**carried["section"]))
    cycle = _bridged(problem, _carried_guess(carried), carried["parameters"], BRIDGES)
    if cycle is not None:
        return _told(problem, cycle, request)
    period, strides = float(carried["period"]), 2**BRIDGES
    message = f"the neighbour's cycle, of period {period:.6g} s, is lost in {strides} strides, too"
    return Outcome(reason="no_cycle", message=message)


def _reached(problem: Problem, request: Request, begin: Begin) -> Outcome:
    """The cycle that the motion from the start comes near, at the first section that has it."""
    settings = request.settings
    for section in _sections(problem, settings, begin):
        at = replace(problem, section=section)
        passed = returns(at, begin, settings["transient"], settings["t_max"])
        if len(passed.times) < 2:
            outcome = stopped(passed.stop) or _without_return(at, passed, settings)
            continue
        asked = settings["multiplicity"], settings["transient"]
        cycle = _closed(at, guesses(at, begin, passed, *asked))
        if cycle is not None:
            return _told(at, cycle, request)
        outcome, last = Outcome(reason="no_cycle"), (at, passed)
    if outcome.reason == "no_cycle":
        outcome.message = _where_it_was(*last, begin, settings)
    return outcome


def _without_return(problem: Problem, passed: Returns, settings: Settings) -> Outcome:
    place, count = _place(problem, settings), len(passed.times)
    message = f"{place}the motion meets the section {count} times up to t = {settings['t_max']:g} s"
    return Outcome(reason="no_return", message=message)


def _where_it_was(problem: Problem, passed: Returns, begin: Begin, settings: Settings) -> str:
    """What the start led to that is no cycle: when, and how, the motion returned last."""
    begun, ended = passed.times[-2:]
    names = problem.system.state_names
    name = settings["observe"] or names[0]

    def swing(one: float, other: float) -> float:
        guess = guess_between(problem, begin, one, other)
        return 0.0 if guess is None else 2.0 * float(guess.scales[names.index(name)])

    last = swing(begun, ended)
    return (
        f"{_place(problem, settings)}the motion returns last at t = {ended:.6g} s, "
        f"{ended - begun:.6g} s after the return before; between them {name} "
        f"{f'swings by {last:.3g}' if last > 0.0 else 'rests'}"
        f"{_course(problem, passed, begin, settings['transient'], swing)}"
    )


def _course(
    problem: Problem,
    passed: Returns,
    begin: Begin,
    transient: float,
    swing: Callable[[float, float], float],
) -> str:
    """On which side of a cycle that repels a start lies, where swings over several returns tell.

    Where the motion was followed for fewer it is followed on.
    """
    until = transient + COURSE * float(passed.times[-1] - passed.times[-2])
    early = returns(problem, begin, transient, until).times
    late = passed.times if len(passed.times) > len(early) else early
    many = (len(early) - 1) // 2
    if many < LEAST_RETURNS:
        return ""
    first, last = swing(transient, early[many - 1]), swing(late[-1 - many], late[-1])
    if not abs(last - first) > SETTLED * first > 0.0:
        return ""
    course, other = ("dies away", "more") if last < first else ("grows", "less")
    return (
        f"; followed up to t = {late[-1]:.6g} s, it swings by {first:.3g} over its first {many} "
        f"returns and by {last:.3g} over its last: so far it {course}, to where a longer t_max "
        f"shows; a start beside a cycle that repels swings by {other} at first"
    )


def _elsewhere(system: System, request: Request) -> str:
    """Another value of the parameter, within its bracket, at which the start leads to a cycle."""
    varied, bracket = request.settings["parameter"], request.settings["bracket"]
    alone = {**request.settings, "parameter": None, "bracket": None}
    for share, end in product(ELSEWHERE, bracket or ()):
        value = request.parameters[varied.name]
        value += share * (end - value)
        there = replace(request, parameters=varied.at(request.parameters, value), settings=alone)
        if "cycle_period" in find_cycle(system, there).values:
            return f"; at {varied.name} = {value:.4g} there is one: let the branch begin there"
    return ""


def _place(problem: Problem, settings: Settings) -> str:
    """The value at which the cycle is looked for that a branch would begin with."""
    varied = settings["parameter"]
    return "" if varied is None else f"at {varied.name} = {problem.parameters[varied.name]:.6g} "


def _sections(problem: Problem, settings: Settings, begin: Begin) -> Iterator[Section]:
    """The section of the case or, where it leaves that to the motion, what the motion may have."""
    if problem.section.kind != OWN:
        yield problem.section
        return
    observed = settings["observe"] or problem.system.state_names[0]
    first = first_section(problem.system, observed)
    yield first
    motion, transient = begin(), settings["transient"]
    motion.run(transient)
    own = own_section(motion, observed, settings["t_max"] - transient)
    others = own, turning_points(problem.system, observed)
    yield from dict.fromkeys(section for section in others if section != first)


def _closed(problem: Problem, candidates: Iterator[Guess]) -> Cycle | None:
    """The first guess that becomes a cycle."""
    for guess in candidates:
        cycle = close(problem, guess.anchor, guess.period, guess.scales)
        if cycle is not None:
            return cycle
    return None


def _bridged(
    problem: Problem, guess: Guess, before: Mapping[str, float], bridges: int
) -> Cycle | None:
    """The cycle that a neighbour's, of the parameters `before`, turns into.

    Where it is not found in one stride, or another one is, the way is halved.
    """
    cycle = close(problem, guess.anchor, guess.period, guess.scales)
    if cycle is not None and abs(cycle.period - guess.period) <= STRIDE * guess.period:
        return cycle
    if bridges == 0:
        return None
    middle = {n: 0.5 * (value + before[n]) for n, value in problem.parameters.items()}
    nearer = _bridged(replace(problem, parameters=middle), guess, before, bridges - 1)
    if nearer is None:
        return None
    own = Guess(nearer.anchor, nearer.period, nearer.scales)
    return _bridged(problem, own, middle, bridges - 1)


def _carried_guess(carried: Mapping[str, Any]) -> Guess:
    """The neighbour's cycle."""
    sticking, closed = (tuple(bool(s) for s in carried[name]) for name in ("sticking", "closed"))
    state, phase = np.array(carried["state"], dtype=float), float(carried["phase"])
    anchor = Anchor(state, sticking, phase, closed)
    return Guess(anchor, float(carried["period"]), np.array(carried["scales"], dtype=float))


def _carry(problem: Problem, cycle: Cycle) -> dict[str, object]:
    """What a continuing neighbour starts from."""
    return carry("periodic", cycle.anchor.state, cycle.anchor.sticking) | {
        "closed": [int(closed) for closed in cycle.anchor.closed],
        "phase": cycle.anchor.phase,
        "period": cycle.period,
        "scales": cycle.scales.tolist(),
        "parameters": dict(problem.parameters),
    }


def _told(problem: Problem, cycle: Cycle, request: Request) -> Outcome:
    """What is stored of a cycle, and of its branch where a parameter is given."""
    settings, names = request.settings, problem.system.state_names
    observed = names.index(settings["observe"] or names[0])
    outcome = _outcome(problem, cycle, observed)
    if request.settings["section"].kind == OWN:
        outcome = recorded(outcome, problem.section)
        outcome.carry = {**(outcome.carry or {}), "section": asdict(problem.section)}
    if settings["parameter"] is not None and settings["bracket"] is not None:
        _add_branch(outcome, problem, cycle, settings, observed)
    return outcome


def _outcome(problem: Problem, cycle: Cycle, observed: int) -> Outcome:
    names = problem.system.motions
    values: dict[str, object] = {
        "cycle_period": cycle.period,
        "multiplicity": len(cycle.points),
        "stable": _stability(cycle),
        "residual": cycle.residual,
        "n_events": len(cycle.around.times),
        **floquet(cycle.multipliers),
    }
    for name, least, greatest in zip(names, *cycle.extremes, strict=False):
        values |= {f"{name}_min": float(least), f"{name}_max": float(greatest)}
    if problem.excitation is not None:
        values["period_ratio"] = float(round(cycle.period / problem.excitation))
    shown = np.zeros(0)
    if len(cycle.points):
        points = np.roll(cycle.points, -int(np.argmin(cycle.points[:, observed])), axis=0)
        values["cycle_section"] = points[0, : 2 * len(problem.system.coordinates)]
        shown = points[:, observed]
    return Outcome(values=values, ragged={"section_value": shown}, carry=_carry(problem, cycle))


def _stability(cycle: Cycle) -> str:
    """In words; neutral where a neighbour keeps its distance."""
    if abs(cycle.largest - 1.0) <= NEUTRAL:
        return "neutral"
    return "stable" if cycle.stable else "unstable"


# --- its branch ----------------------------------------------------------------------------------
def _add_branch(
    outcome: Outcome, problem: Problem, cycle: Cycle, settings: Settings, observed: int
) -> None:
    """Follow the branch both ways and store its points and its ends."""
    varied, bracket = settings["parameter"], settings["bracket"]
    value = problem.parameters[varied.name]
    if not bracket[0] <= value <= bracket[1]:
        outcome.reason = "outside_bracket"
        return
    width = settings["width"] * (bracket[1] - bracket[0])
    line = Continuation(problem, varied, bracket, width)
    points, ends, stable_ends = _both_ways(line, cycle, value)
    errors = [end_error(line, end) for end in ends]
    events = [grazed(line, end) for end in ends]
    outcome.ragged |= _branch_arrays(points, observed) | _end_arrays(ends, errors, events)
    for side, extreme in (("lowest", np.argmin), ("highest", np.argmax)) if ends else ():
        place = int(extreme([end.value for end in ends]))
        outcome.values |= {
            **_end_values(f"cycle_{side}", ends[place], errors[place]),
            f"cycle_{side}_width": ends[place].width,
        }
    for side, end in zip(("lowest", "highest"), stable_ends, strict=False):
        if end is not None:
            place = next(i for i, one in enumerate(ends) if one is end)
            outcome.values |= _end_values(f"stable_{side}", end, errors[place])


def _end_values(name: str, end: End, error: float) -> dict[str, object]:
    return {name: end.value, f"{name}_error": error, f"{name}_kind": end.kind}


def _both_ways(
    line: Continuation, cycle: Cycle, value: float
) -> tuple[list[Point], list[End], list[End | None]]:
    """The whole branch, from its end below to its end above, as it was followed.

    A closed one from the first cycle up, round to it again. Last come the ends of the part that is
    stable with the first cycle; a closed branch has none that is the lowest or the highest.
    """
    down, up = (first_point(line, cycle, value, rising) for rising in (False, True))
    if down is None or up is None:
        return [], [], []
    above, ends_above = follow(line, up)
    if ends_above[-1].kind == CLOSED:
        return [up, *above], ends_above, []
    below, ends_below = follow(line, down)
    stable_ends = [stable_until(down, ends_below), stable_until(up, ends_above)]
    return [*reversed(below), up, *above], [*reversed(ends_below), *ends_above], stable_ends


def _branch_arrays(points: list[Point], observed: int) -> dict[str, object]:
    cycles = [point.cycle for point in points]
    at_section = [np.sort(cycle.points[:, observed]) for cycle in cycles]
    return {
        "branch_value": np.array([point.value for point in points]),
        "branch_period": np.array([cycle.period for cycle in cycles]),
        "branch_min": np.array([cycle.extremes[0, observed] for cycle in cycles]),
        "branch_max": np.array([cycle.extremes[1, observed] for cycle in cycles]),
        "branch_multiplicity": np.array([passed.size for passed in at_section], dtype=int),
        "branch_section": np.concatenate([*at_section, np.zeros(0)]),
        "branch_multiplier": np.array([cycle.largest for cycle in cycles]),
        "branch_stable": [_stability(cycle) for cycle in cycles],
    }


def _end_arrays(
    ends: list[End], errors: list[float], events: list[tuple[str, int]]
) -> dict[str, object]:
    return {
        "cycle_end": np.array([end.value for end in ends]),
        "cycle_end_width": np.array([end.width for end in ends]),
        "cycle_end_error": np.array(errors),
        "cycle_end_kind": [end.kind for end in ends],
        "cycle_end_event": [event for event, _ in events],
        "cycle_end_contact": np.array([contact for _, contact in events], dtype=int),
        "cycle_end_direction": np.array([end.direction for end in ends], dtype=int),
        "cycle_end_goes_on": ["yes" if end.goes_on else "no" for end in ends],
    }
