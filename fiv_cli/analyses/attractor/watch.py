"""A motion followed in machine code, look after look, until one may tell what it is.

A look is taken where section points have filled up or a time has passed; most tell nothing: the
section does not repeat, the slide is too far out for its end to be known. What a look that may tell
is worth is asked in `steady_state.py`, on the grounds of ``grounds.py``.
"""

from __future__ import annotations

import math
import sys
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

from fiv_cli.analyses.attractor import descent, grounds, lyapunov, settling
from fiv_cli.analyses.attractor.descent import FULL, NOTHING, Slide, look_at_slide, slide_at
from fiv_cli.analyses.attractor.lyapunov import Growth, book_growth, growth_at
from fiv_cli.analyses.attractor.settling import (
    LEAST,
    floor_scales,
    grow_scales,
    period_among,
)
from fiv_cli.codegen.codes import STICK
from fiv_cli.codegen.compiled import Compiled
from fiv_cli.codegen.memory import (
    FixedFloat,
    FixedInt,
    Floats,
    Floats2,
    Frame,
    Ints,
    call_driver,
    call_generated,
    native,
)
from fiv_cli.dynamics import compiled, kernel, roots
from fiv_cli.dynamics.arrays import NO_WORKS
from fiv_cli.dynamics.compiled import run_at
from fiv_cli.dynamics.kernel import (
    REACHED,
    SECTION_FULL,
    SECTION_PHASE,
    STEP_BUDGET,
    Run,
    holds,
    state_index,
)
from fiv_cli.dynamics.motion import Motion
from fiv_cli.dynamics.system import Vector

CHUNK = 16  # section points between two looks at the return map
KEPT = 4096  # section points kept
ALMOST = 1.0 - 1e-12  # of a time that has passed
NEXT = 1e-9  # share of a period by which a phase must lie ahead


class Watch(Frame):
    """What is looked for along a motion, and what has been seen."""

    # --- the motion ---
    driver: FixedInt  # addresses of the driver and of the motion's frame
    motion: FixedInt
    is_measuring: FixedInt
    interval: FixedFloat  # of a stroboscopic section, s
    offset: FixedFloat  # ... and when it begins
    excitation: FixedFloat  # period, s; 0: none

    # --- looks ---
    until: FixedFloat  # time of the last one, s
    is_paced: FixedInt  # whether time that passes brings one on
    span: float  # ... so much, s, which doubles while events go on
    shortest: FixedFloat
    longest: FixedFloat
    goal: float
    is_under_way: int
    goals: Floats  # times up to which the tangent whose growth this is (0: none) is normalised
    n_passed: int
    growth: FixedInt
    spans: Floats  # measured by then, s
    spreads: Floats  # ... and the integral of L_s over them
    n_before: int  # points and events at the look before
    n_events: int
    has_new: int  # whether there are points since

    # --- section points ---
    times: Floats
    points: Floats2  # with the phase of an excitation in two columns more
    works: Floats2  # done by then; no rows: not asked for
    scales: Floats  # largest values of what is in `n_scaled` points
    judged: Floats  # scratch
    count: int
    n_scaled: int

    # --- what may tell ---
    nearness: FixedFloat  # of a repetition, and from when on
    waiting_until: FixedFloat
    early: FixedFloat  # of one that is worth an early attempt, 0: none; and after so many steps
    early_steps: FixedFloat
    early_passages: FixedFloat  # ... and passages
    may_rest: FixedInt
    knows_slides: FixedInt  # whether `slides` are there; otherwise each may tell
    slides: Ints  # addresses of what is known of slides to the equilibria
    ways: Floats  # numbers of pieces, then slip signs, at the equilibria
    asks_waiting: FixedInt
    patience: FixedFloat
    last_point: float
    last_event: float
    has_waited: int
    rest_tells: int  # whether the last look may tell of rest
    told_by: int  # the slide that did, -1: none
    ends_in_stick: FixedInt


def watch_at(address: int) -> Watch:
    """The watch whose frame is at an address."""
    return Watch.at(address)


@native
def begin_look(watch: Watch, run: Run) -> None:
    """Say how far the motion goes until the next look, and make room for section points."""
    watch.goal = watch.until
    if watch.n_passed < len(watch.goals):
        watch.goal = watch.goals[watch.n_passed]
    if watch.is_paced == 1:
        watch.goal = min(run.time + watch.span, watch.until)
    if watch.count + CHUNK > KEPT:
        forget_oldest(watch)
    run.first_step = 0.0  # another motion may have used the scratch arrays
    run.n_sections = watch.count
    run.max_sections = watch.count + CHUNK
    if run.section_kind == SECTION_PHASE:
        turns = math.floor((run.time - watch.offset) / watch.interval + NEXT) + 1.0
        run.next_phase = watch.offset + turns * watch.interval
    watch.n_before, watch.n_events = watch.count, run.n_events


@native
def forget_oldest(watch: Watch) -> None:
    """Keep the newer half of the section points."""
    half = KEPT // 2
    for row in range(half, watch.count):
        watch.times[row - half] = watch.times[row]
        for i in range(watch.points.shape[1]):
            watch.points[row - half, i] = watch.points[row, i]
        for i in range(watch.works.shape[1]):
            watch.works[row - half, i] = watch.works[row, i]
    watch.count -= half


@native
def end_look(watch: Watch, run: Run) -> None:
    """Book what has passed since the look before."""
    watch.count = run.n_sections
    watch.has_new = 1 if watch.count > watch.n_before else 0
    watch.has_waited = 0
    if run.n_events == watch.n_events:
        watch.span = watch.shortest if watch.is_paced == 1 else watch.span
    else:
        # Where stick-slip goes on there is nothing to look at before section points are full.
        watch.span = min(2.0 * watch.span, watch.longest) if watch.is_paced == 1 else watch.span
        watch.last_event = run.time
        if watch.excitation == 0.0:  # else a border of the sector, which is no surface
            for number in range(len(watch.slides)):
                slide_at(watch.slides[number]).count = 0
    if watch.has_new == 1:
        watch.last_point = run.time


@native
def take_in(watch: Watch, run: Run) -> None:
    """Phases and scales of new section points."""
    n = run.n_states
    if watch.n_scaled == 0 or watch.n_scaled > watch.count:
        watch.n_scaled = 0
        for i in range(len(watch.scales)):
            watch.scales[i] = LEAST
    if watch.excitation > 0.0:
        for row in range(watch.n_scaled, watch.count):
            phase = 2.0 * math.pi * watch.times[row] / watch.excitation
            # Shifted by 2: a sine that is always zero must not be judged by its rounding.
            watch.points[row, n] = 2.0 + math.cos(phase)
            watch.points[row, n + 1] = 2.0 + math.sin(phase)
    grow_scales(watch.points, watch.scales, watch.n_scaled, watch.count)
    watch.n_scaled = watch.count


@native
def judge(watch: Watch, run: Run) -> None:
    """By what repetitions are judged: phases weigh as much as the largest state."""
    n, reach = run.n_states, LEAST
    for i in range(n):
        watch.judged[i] = watch.scales[i]
        reach = max(reach, watch.scales[i])
    for i in range(n, len(watch.scales)):
        watch.judged[i] = reach * watch.scales[i]
    floor_scales(watch.judged)
    for i in range(n, len(watch.scales)):
        watch.judged[i] /= reach


@native
def repeats(watch: Watch, run: Run) -> bool:
    """Whether the section repeats as closely as is worth an attempt to close the motion."""
    if watch.has_new == 0 or run.time < watch.waiting_until:
        return False
    take_in(watch, run)
    judge(watch, run)
    points, judged, count = watch.points, watch.judged, watch.count
    if count < 3:
        return False
    if watch.early > 0.0 and run.n_steps >= watch.early_steps:
        m = period_among(points, judged, count, watch.early, math.inf)
        span = watch.times[count - 1] - watch.times[count - 1 - m]
        if m > 0 and run.time >= watch.early_passages * span:
            return True
    return period_among(points, judged, count, watch.nearness, math.inf) > 0


@native
def all_slide(run: Run) -> bool:
    """Whether every contact slips, stops open."""
    for i in range(run.n_contacts):
        if run.kinds[i] != run.sliding_kinds[i]:
            return False
    return True


@native
def slides(watch: Watch, run: Run) -> bool:
    """Whether all contacts slip the way they do at an equilibrium."""
    for i in range(len(run.rows)):
        if run.rows[i] != watch.ways[i]:
            return False
    for i in range(run.n_contacts):
        if run.slip_signs[i] != watch.ways[len(run.rows) + i]:
            return False
    return all_slide(run)


@native
def comes_down(watch: Watch, run: Run) -> bool:
    """Whether it may be told of a slide where it ends."""
    tells = watch.knows_slides == 0
    for number in range(len(watch.slides)):
        found = look_at_slide(slide_at(watch.slides[number]), run.time, run.y)
        if found != NOTHING and not tells:
            watch.told_by = number if found != FULL else -1
        tells = tells or found != NOTHING
    return tells


@native
def is_stuck(watch: Watch, run: Run) -> bool:
    """Whether something holds and nothing moves (what accelerates is not asked)."""
    if watch.excitation > 0.0 or not holds(run):
        return False
    n, m, index = run.n_states, run.n_coordinates, state_index(run.kinds, run.n_contacts)
    call_generated(run.field[index], run.coefficients, run.time, run.y, run.outputs)
    for i in range(n):
        if run.outputs[n + i] != 0.0 and not m <= i < 2 * m:
            return False
    return True


@native
def may_rest(watch: Watch, run: Run) -> bool:
    """Whether the motion may be on its way to rest."""
    watch.told_by = -1
    if watch.may_rest == 0:
        return False
    return comes_down(watch, run) if slides(watch, run) else is_stuck(watch, run)


@native
def waits(watch: Watch, run: Run) -> bool:
    """Whether nothing has told for long that stick-slip goes on."""
    since = watch.last_point if watch.excitation > 0.0 else watch.last_event
    if watch.is_paced == 0 or watch.asks_waiting == 0 or run.time - since < watch.patience * ALMOST:
        return False
    if watch.excitation == 0.0 and not all_slide(run):
        return False
    watch.has_waited, watch.last_point = 1, run.time
    return True


@native
def has_stuck(watch: Watch, run: Run) -> bool:
    """Whether a motion that is asked for sliding alone has stuck while it was measured."""
    if watch.ends_in_stick == 1:
        for i in range(run.n_contacts):
            if run.shares[i, STICK] > 0.0:
                return True
    return False


@native
def pass_goals(watch: Watch, run: Run) -> None:
    """Book what was measured and how the tangent has grown, at each of the goals."""
    while watch.n_passed < len(watch.goals) and run.time >= watch.goals[watch.n_passed]:
        watch.spans[watch.n_passed] = run.measured_time
        watch.spreads[watch.n_passed] = run.spread
        watch.n_passed += 1
        if watch.growth != 0:
            book_growth(growth_at(watch.growth), run)


@native
def follow(watch: Watch, run: Run) -> int:
    """Go on until a look may tell something, time is up, or an end; why the driver stopped."""
    while True:
        if watch.is_under_way == 0:
            pass_goals(watch, run)
            if run.time >= watch.until:
                watch.has_new = 0
                return REACHED
            begin_look(watch, run)
        measuring = watch.is_measuring == 1
        code = call_driver(watch.driver, watch.motion, watch.goal, watch.interval, measuring)
        watch.is_under_way = 1 if code == STEP_BUDGET else 0
        if code == STEP_BUDGET:
            return code
        end_look(watch, run)
        if code > SECTION_FULL or has_stuck(watch, run):
            return code
        watch.rest_tells = 1 if may_rest(watch, run) else 0
        tells = repeats(watch, run) or watch.rest_tells == 1
        if waits(watch, run) or tells:
            return code


def follow_at(address: int) -> int:
    """`follow` with the watch at an address."""
    watch = watch_at(address)
    return watch_follow(watch, run_at(watch.motion))


watch_follow = follow  # numba reads no functions off modules


def _declared() -> Callable[..., int]:
    from fiv_cli.codegen.kernels import register, register_frame

    register_frame(Run, run_at)
    register_frame(Watch, watch_at)
    register_frame(Slide, slide_at)
    register_frame(Growth, growth_at)
    for module in (roots, kernel, settling, descent, lyapunov, sys.modules[__name__]):
        register(module)
    return follow_at


PARTS = (descent, grounds, lyapunov, settling)
FILES = (*compiled.FILES, *(Path(str(part.__file__)) for part in PARTS), Path(__file__))
FOLLOW = Compiled("follow", "int64(int64)", FILES, _declared)


def load_watch(announce: Callable[[str], None]) -> None:
    """Have all that follows motions at hand; `announce` is called if it must be compiled."""
    FOLLOW.load(announce, "compiling what follows motions (once per user, a few seconds)")
    descent.LOOK.load(announce, "compiling what looks at slides (once per user, a few seconds)")
    settling.load_settling(announce)


def watch_over(motion: Motion, ways: Vector, excitation: float | None, patience: float) -> Watch:
    """A watch over a motion.

    Parameters
    ----------
    ways : `Motion.ways` at the equilibria
    excitation : its period, s; None: none
    patience : time between two looks, s, and without section points, at most
    """
    watch = blank_watch(len(motion.y) + (0 if excitation is None else 2)).copy()
    watch.show("ways", np.array(ways, dtype=float))
    watch.tell(**followed(motion.frame.address, patience))
    watch.excitation, watch.interval = excitation or 0.0, excitation or patience
    watch.may_rest = int(motion.started)
    watch.last_event = watch.last_point = motion.time
    return watch


def followed(motions: Any, patience: Any) -> dict[str, Any]:
    """What a watch is told of its motion: where that is, and the time between two looks, s."""
    times = dict.fromkeys(("interval", "longest", "patience"), patience)
    return {"driver": compiled.DRIVER.address, "motion": motions, **times}


@cache
def blank_watch(width: int) -> Watch:
    """What new watches copy (their section points are shared: one motion is followed at a time)."""
    return Watch.holding(
        {
            "times": np.zeros(KEPT),
            "points": np.zeros((KEPT, width)),
            "works": NO_WORKS,
            "slides": np.zeros(0, np.int64),
            **{name: np.zeros(0) for name in ("goals", "spans", "spreads")},
            **{name: np.zeros(width) for name in ("scales", "judged", "ways")},
        },
        {},
    )
