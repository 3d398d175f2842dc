"""A slide watched on its way down to an equilibrium; what is asked is in ``grounds.py``."""

from __future__ import annotations

import math
import sys
from collections.abc import Callable
from functools import cache, cached_property
from pathlib import Path

import numpy as np

from fiv_cli.analyses.attractor import grounds
from fiv_cli.analyses.attractor.grounds import AGREEMENT, FALLEN, LEADING
from fiv_cli.analyses.attractor.level_set import LevelSet
from fiv_cli.codegen.compiled import Compiled
from fiv_cli.codegen.memory import (
    FixedFloat,
    FixedInt,
    Floats,
    Floats2,
    Frame,
    Ints,
    address_of,
    floats_at,
    native,
)
from fiv_cli.dynamics.system import Vector

# What a look at a slide says: nothing; that it is to be seen whether sliding is linear from here;
# that it falls as it should; that there is no room for another look.
NOTHING, MAY_BE_LINEAR, FALLS, FULL = 0, 1, 2, 3
ROOM = 64  # looks


class Slide(Frame):
    """Level sets about an equilibrium, and the looks at a slide since it began."""

    equilibrium: Floats
    free: Ints  # places of the states that slide freely
    inverse_real: Floats2  # modes by free states
    inverse_imag: Floats2
    shares: Floats2  # switching functions by modes
    weights: Floats  # of modes
    rates: Floats
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
            real += slide.inverse_real[mode, j] * off
            imag += slide.inverse_imag[mode, j] * off
        slide.now[mode] = math.sqrt(real * real + imag * imag)
        slide.size += slide.weights[mode] * slide.now[mode]
    for guard in range(slide.shares.shape[0]):
        reached = 0.0
        for mode in range(modes):
            reached += slide.shares[guard, mode] * slide.now[mode]
        slide.level = max(slide.level, reached)


@native
def look_at_slide(slide: Slide, time: float, y: Floats) -> int:
    """Look at the slide, again if it was looked at just now; what that says."""
    measure_slide(slide, y)
    if slide.is_bounded == 1 and not slide.level < 1.0:
        slide.count = 0
        return NOTHING
    if slide.size < FALLEN * slide.bent:
        return MAY_BE_LINEAR
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
            measured, rate = math.log(after / before) / elapsed, slide.rates[mode]
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
def _blank(states: int, free: int, guards: int) -> Slide:
    """What slides of these sizes copy."""
    return Slide.holding(
        {
            "equilibrium": np.zeros(states),
            "free": np.zeros(free, np.int64),
            "inverse_real": np.zeros((free, free)),
            "inverse_imag": np.zeros((free, free)),
            "shares": np.zeros((guards, free)),
            **{name: np.zeros(free) for name in ("weights", "rates", "now")},
            **{name: np.zeros(0) for name in ("times", "sizes")},
            "amplitudes": np.zeros((0, free)),
        },
        {},
    )


class Descent:
    """A slide watched on its way down to an equilibrium.

    Parameters
    ----------
    target : the level sets about it
    bent : smallest size at which sliding is known to be nonlinear
    """

    def __init__(self, target: LevelSet, bent: float = np.inf) -> None:
        self.target, self.bent = target, bent

    @cached_property
    def slide(self) -> Slide:
        """What a look reads and writes."""
        target = self.target
        guards, modes = target.shares.shape
        slide = _blank(len(target.equilibrium), modes, guards).copy()
        slide.show("equilibrium", target.equilibrium)
        slide.show("free", target.free.astype(np.int64))
        slide.show("inverse_real", target.inverse.real.copy())
        slide.show("inverse_imag", target.inverse.imag.copy())
        slide.show("shares", np.ascontiguousarray(target.shares))
        slide.show("weights", target.weights)
        slide.show("rates", target.eigenvalues.real.copy())
        slide.is_bounded, slide.period = int(target.is_bounded), target.period
        slide.bent = self.bent
        return slide

    def margin(self, time: float, state: Vector) -> float:
        """1 - V/c as soon as the slide is sure to end at the equilibrium; NaN before.

        Parameters
        ----------
        time : s
        state : of sliding, shape (n_states,)
        """
        if "slide" not in vars(self) and self.bent == np.inf:  # most that are linear are at once
            exact = self.target.margin(state)
            if not np.isnan(exact):
                return exact
        found = self._look(time, state)
        if found == MAY_BE_LINEAR:
            exact = self.target.margin(state)
            if not np.isnan(exact):
                return exact
            self.slide.bent = self.slide.size
            found = self._look(time, state)
        if found == FULL:
            self._make_room()
            found = self._look(time, state)
        if found != FALLS:
            return np.nan
        return 1.0 - float(self.target.level(self.target.amplitudes(state)))

    def _look(self, time: float, state: Vector) -> int:
        found: int = LOOK.function(self.slide.address, time, address_of(state))
        return found

    def _make_room(self) -> None:
        for name in ("times", "sizes", "amplitudes"):
            looks = getattr(self.slide, name)
            more = np.zeros((max(len(looks), ROOM), *looks.shape[1:]))
            self.slide.show(name, np.concatenate([looks, more]))
