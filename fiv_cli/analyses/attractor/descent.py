"""A slide watched on its way down to an equilibrium; what is asked is in ``grounds.py``."""

from __future__ import annotations

import math
import sys
from collections.abc import Callable
from functools import cache
from pathlib import Path

import numpy as np

from fiv_cli.analyses.attractor import grounds
from fiv_cli.analyses.attractor.grounds import AGREEMENT, FALLEN, LEADING, LINEAR, SAMPLES
from fiv_cli.analyses.attractor.level_set import LevelSet
from fiv_cli.codegen.compiled import Compiled
from fiv_cli.codegen.memory import (
    Array,
    FixedFloat,
    FixedInt,
    Floats,
    Floats2,
    Frame,
    Frames,
    Ints,
    address_of,
    call_generated,
    floats_at,
    native,
)
from fiv_cli.dynamics.system import Vector

# What a look at a slide says: nothing; that sliding is linear from here; that it falls as it
# should; that there is no room for another look.
NOTHING, IS_LINEAR, FALLS, FULL = 0, 1, 2, 3
ROOM = 64  # looks, at first


class Slide(Frame):
    """Level sets about an equilibrium, and the looks at a slide since it began."""

    equilibrium: Floats
    free: Ints  # places of the states that slide freely
    inverse: Floats2  # modes by free states, of which each has a real and an imaginary part
    shares: Floats2  # switching functions by modes
    weights: Floats  # of modes
    eigenvalues: Floats  # real and imaginary parts
    is_bounded: FixedInt
    period: FixedFloat
    bent: float  # smallest size at which sliding was found to be nonlinear
    level: float  # of the last look
    size: float
    count: int
    times: Floats
    sizes: Floats  # weighted sums of ...
    amplitudes: Floats2
    now: Floats

    # --- is sliding linear? see `LevelSet.nonlinearity` ---
    field: FixedInt  # address of what gives the rates
    coefficients: Floats
    shapes: Floats2  # samples by free states
    straight: Floats2  # rates of their modes where sliding is linear, samples by modes, likewise
    shape_sizes: Floats
    rounding: FixedFloat
    slowest: FixedFloat
    sample: Floats  # scratch
    outputs: Floats


def slide_at(address: int) -> Slide:
    """The slide whose frame is at an address."""
    return Slide.at(address)


@native
def measure_slide(slide: Slide, y: Floats) -> None:
    """Modal amplitudes, level and size of a state."""
    modes = len(slide.free)
    slide.size, slide.level = 0.0, 0.0
    for mode in range(modes):
        real, imag = 0.0, 0.0
        for j in range(modes):
            off = y[slide.free[j]] - slide.equilibrium[slide.free[j]]
            real += slide.inverse[mode, 2 * j] * off
            imag += slide.inverse[mode, 2 * j + 1] * off
        slide.now[mode] = math.sqrt(real * real + imag * imag)
        slide.size += slide.weights[mode] * slide.now[mode]
    for guard in range(slide.shares.shape[0]):
        reached = 0.0
        for mode in range(modes):
            reached += slide.shares[guard, mode] * slide.now[mode]
        slide.level = max(slide.level, reached)


@native
def nonlinearity(slide: Slide) -> float:
    """`LevelSet.nonlinearity` of what was measured."""
    n, modes, worst = len(slide.equilibrium), len(slide.free), 0.0
    reach = max(slide.size, slide.rounding)
    for sample in range(SAMPLES):
        for i in range(n):
            slide.sample[i] = slide.equilibrium[i]
        for j in range(modes):
            slide.sample[slide.free[j]] += reach * slide.shapes[sample, j]
        call_generated(slide.field, slide.coefficients, 0.0, slide.sample, slide.outputs)
        square = 0.0
        for mode in range(modes):
            real = -reach * slide.straight[sample, 2 * mode]
            imag = -reach * slide.straight[sample, 2 * mode + 1]
            for j in range(modes):
                rate = slide.outputs[n + slide.free[j]]
                real += slide.inverse[mode, 2 * j] * rate
                imag += slide.inverse[mode, 2 * j + 1] * rate
            square += slide.weights[mode] * slide.weights[mode] * (real * real + imag * imag)
        worst = max(worst, math.sqrt(square) / slide.shape_sizes[sample])
    return worst / (reach * slide.slowest)


@native
def is_linear(slide: Slide) -> bool:
    """Whether sliding is linear from what was measured, and meets nothing."""
    if slide.size == 0.0:
        return True
    bent = nonlinearity(slide)
    return bent <= LINEAR and 1.0 - slide.level - len(slide.free) * bent > 0.0


@native
def look_at_slide(slide: Slide, time: float, y: Floats) -> int:
    """Look at the slide, again if it was looked at just now; what that says."""
    measure_slide(slide, y)
    if slide.is_bounded == 1 and not slide.level < 1.0:
        slide.count = 0
        return NOTHING
    if slide.size < FALLEN * slide.bent:
        if is_linear(slide):
            return IS_LINEAR
        slide.bent = slide.size
    if slide.count > 0 and slide.times[slide.count - 1] == time:
        slide.count -= 1
    row = slide.count
    if row == len(slide.times):
        return FULL
    slide.times[row], slide.sizes[row] = time, slide.size
    for mode in range(len(slide.now)):
        slide.amplitudes[row, mode] = slide.now[mode]
    slide.count = row + 1
    return FALLS if slide.level <= FALLEN and has_fallen(slide) else NOTHING


@native
def has_fallen(slide: Slide) -> bool:
    """Whether it has fallen, over two successive stretches as the linear system does."""
    last, back = slide.count - 1, 1
    while 2 * back <= last:
        first, middle = last - 2 * back, last - back
        is_down = slide.sizes[last] <= FALLEN * slide.sizes[first]
        if is_down and agrees(slide, first, middle) and agrees(slide, middle, last):
            return True
        back *= 2
    return False


@native
def agrees(slide: Slide, first: int, last: int) -> bool:
    """Whether every leading mode changed at its own rate between two looks."""
    elapsed = slide.times[last] - slide.times[first]
    if elapsed < slide.period * (1.0 - 1e-9):
        return False
    largest = 0.0
    for mode in range(len(slide.now)):
        largest = max(largest, slide.weights[mode] * slide.amplitudes[first, mode])
    for mode in range(len(slide.now)):
        before, after = slide.amplitudes[first, mode], slide.amplitudes[last, mode]
        if slide.weights[mode] * before >= LEADING * largest:
            if before <= 0.0 or after <= 0.0:
                return False
            measured, rate = math.log(after / before) / elapsed, slide.eigenvalues[2 * mode]
            if not abs(measured - rate) <= AGREEMENT * abs(rate):
                return False
    return True


def look_at(address: int, time: float, state: int) -> int:
    """`look_at_slide` with the slide and the state at addresses."""
    slide = slide_at(address)
    return look_at_slide(slide, time, floats_at(state, 1, len(slide.equilibrium))[0])


def _declared() -> Callable[..., int]:
    from fiv_cli.codegen.kernels import register, register_frame

    register_frame(Slide, slide_at)
    register(sys.modules[__name__])
    return look_at


FILES = (Path(__file__), Path(grounds.__file__))
LOOK = Compiled("look", "int64(int64, float64, int64)", FILES, _declared)


@cache
def _blank(states: int, free: int, outputs: int) -> Slide:
    """What slides of these sizes copy."""
    kinds = {name: field.kind for name, field in Slide.fields.items() if field.kind.depth}
    none: dict[str, Array] = {
        name: np.zeros((0,) * kind.depth, kind.element) for name, kind in kinds.items()
    }
    scratch = {"now": np.zeros(free), "sample": np.zeros(states), "outputs": np.zeros(outputs)}
    return Slide.holding(none | scratch, {})


def slides_to(targets: LevelSet) -> Frames[Slide]:
    """What looks at slides to several equilibria read and write."""
    (count, free), sliding = targets.eigenvalues.shape, targets.sliding
    blank = _blank(targets.equilibrium.shape[1], free, sliding.system.outputs_width)
    slides = Frames(blank, count)
    slides.show("free", targets.free)
    for name in ("equilibrium", "shares", "weights", "shapes", "shape_sizes"):
        slides.show_rows(name, np.ascontiguousarray(getattr(targets, name)))
    for name in ("inverse", "eigenvalues", "straight"):
        slides.show_rows(name, np.ascontiguousarray(getattr(targets, name)).view(float))
    slides.show_rows("coefficients", sliding.coefficients)
    for name in ("times", "sizes"):
        slides.show_rows(name, np.empty((count, ROOM)))
    slides.show_rows("amplitudes", np.empty((count, ROOM, free)))
    slides.tell(
        field=sliding.system.tables.field[sliding.index], bent=np.inf, slowest=targets.slowest,
        rounding=targets.rounding, period=targets.period, is_bounded=targets.is_bounded,
    )  # fmt: skip
    return slides


class Descent:
    """A slide watched on its way down to an equilibrium.

    Parameters
    ----------
    target : the level sets about it
    slide : what a look reads and writes; none given: one of its own
    """

    def __init__(self, target: LevelSet, slide: Slide | None = None) -> None:
        self.target = target
        self.slide = slides_to(target[None]).frame(0) if slide is None else slide

    def margin(self, time: float, state: Vector) -> float:
        """1 - V/c as soon as the slide is sure to end at the equilibrium; NaN before.

        Parameters
        ----------
        time : s
        state : of sliding, shape (n_states,)
        """
        if (state == self.target.asked).all() and not np.isnan(self.target.answer):
            return float(self.target.answer)
        found = self._look(time, state)
        if found == FULL:
            self._make_room()
            found = self._look(time, state)
        return np.nan if found == NOTHING else 1.0 - self.slide.level

    def _look(self, time: float, state: Vector) -> int:
        found: int = LOOK.function(self.slide.address, time, address_of(state))
        return found

    def _make_room(self) -> None:
        for name in ("times", "sizes", "amplitudes"):
            looks = getattr(self.slide, name)
            self.slide.show(name, np.concatenate([looks, np.empty_like(looks)]))
