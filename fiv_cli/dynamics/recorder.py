"""Motions of one system side by side, and recorded so: samples, events, works.

The frame of each is a row of one block, and so is what is sampled of it: columns of answers are
parts of a few arrays. The ledger is that of all, one motion behind the other.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from fiv_cli import ending
from fiv_cli.codegen.codes import KINETIC, POTENTIAL, STICK
from fiv_cli.codegen.compiled import Compiled
from fiv_cli.codegen.memory import Array, Frames, address_of, call_driver
from fiv_cli.dynamics.arrays import blank_frame, ledger_of, sample_width
from fiv_cli.dynamics.compiled import DRIVER, FILES, run_at
from fiv_cli.dynamics.kernel import ENTER, NO_NUMBER, REACHED, Run
from fiv_cli.dynamics.motion import STOPS, Ledger, Motion, Samples, Stop
from fiv_cli.dynamics.settings import SolverSettings
from fiv_cli.dynamics.system import System, Vector

LEDGER_ROWS = 2**15  # events that a page of the ledger holds
AT_ONCE = 16  # motions that are run between two looks at what may ask for an end

EVENTS, MOST_EVENTS, BOOKED = (
    Run.fields[name].place for name in ("n_events", "max_events", "n_ledger")
)
REASONS = NO_NUMBER + 1  # why the driver stops; an edit of its files has this compiled anew


def run_each(driver: int, address: int, width: int, count: int, until: float) -> int:
    """Run motions one after the other as long as each comes to the end.

    Parameters
    ----------
    address, width : where their frames lie, each so many bytes behind the one before
    until : the end, s

    Returns
    -------
    number of the last that was run, times `REASONS`, plus why it stopped
    """
    booked, row, stop = run_at(address).n_ledger, -1, REACHED
    while stop == REACHED and row < count - 1:
        row += 1
        run = run_at(address + row * width)
        run.n_ledger = booked
        stop = call_driver(driver, address + row * width, until, 0.0, True)
        booked = run.n_ledger
    return row * REASONS + stop


def _declare() -> Callable[..., int]:
    from fiv_cli.codegen.kernels import register_frame

    register_frame(Run, run_at)
    return run_each


RUN_EACH = Compiled(
    "record",
    "int64(int64, int64, int64, int64, float64)",
    (*FILES, Path(__file__)),
    _declare,
)


def load_recorder(announce: Callable[[str], None]) -> None:
    """Have what runs motions at hand; `announce` is called if it must be compiled."""
    RUN_EACH.load(
        announce, "compiling what runs motions side by side (once per user, a few seconds)"
    )


class Beginning(NamedTuple):
    """Where a motion begins, at t = 0.

    Attributes
    ----------
    parameters : every parameter, SI
    state : shape (n_states,)
    sticking : contacts that stick from the start; none given: as the state says
    """

    parameters: Mapping[str, float]
    state: Vector
    sticking: tuple[bool, ...] = ()


def set_out(system: System, solver: SolverSettings, begun: Sequence[Beginning]) -> Frames[Run]:
    """The frames of motions at their beginnings."""
    blank = blank_frame(system, solver)
    frames = Frames(blank, len(begun))
    own = [system.parameter_values(one.parameters) for one in begun]
    frames.own("parameters")[:, : len(own[0])] = own
    frames.own("y")[:] = [one.state for one in begun]
    for row, one in enumerate(begun):
        if one.sticking:
            frames.own("kinds")[row] = np.where(one.sticking, STICK, blank.sliding_kinds)
    return frames


def decide(frames: Frames[Run]) -> NDArray[np.bool_]:
    """Have every motion that begins at t = 0 decide its contact state; which have found one."""
    rest = frames.words
    while len(rest):
        place = address_of(rest), rest.strides[0], len(rest)
        last, _ = divmod(RUN_EACH.function(DRIVER.address, *place, 0.0), REASONS)
        rest = rest[last + 1 :]
    return np.asarray(frames.told("task") != ENTER)


class Recorder:
    """Motions of a system, sampled at the same times.

    Attributes
    ----------
    states, outputs, codes : as of `Samples`; shape (motions, numbers of a sample, times)
    works : of each excitation, J; shape (motions, excitations)
    """

    def __init__(
        self, system: System, solver: SolverSettings, begun: Sequence[Beginning], times: Vector
    ) -> None:
        self.system, self.solver, self.times = system, solver, times
        self._frames, count, contacts = (
            set_out(system, solver, begun),
            len(begun),
            system.n_contacts,
        )
        self.states = np.empty((count, len(system.state_names), len(times)))
        self.outputs = np.empty((count, sample_width(system), len(times)))
        self.codes = np.empty((count, contacts, len(times)), np.int64)
        self.works = np.zeros((count, len(system.setup.model.powers)))
        at_one_instant = contacts + len(self._frames.blank.in_piece)
        self._page, self._booked = ledger_of(LEDGER_ROWS + at_one_instant), 0
        self._pages: list[list[Array]] = []
        for name in ("states", "outputs", "codes"):
            self._frames.show_rows(f"sample_{name}", getattr(self, name))
        self._frames.show_rows("works", self.works)
        for name, array in {"sample_times": times, **self._page}.items():
            self._frames.show(name, array)

    # --- going on ---------------------------------------------------------------------------------
    def run(self) -> list[Stop]:
        """Take every motion to the last of the times; why each stopped.

        What is not reached holds no numbers.
        """
        stops: list[Stop] = []
        run = self._run_alone if self.system.setup.schedule.curves else self._run_some
        while len(stops) < len(self._frames):
            ending.heed()
            stops += run(len(stops))
        self._turn_page()
        count = self.told("n_sampled")
        for row in np.flatnonzero(count < len(self.times)):
            self.states[row, :, count[row] :] = self.outputs[row, :, count[row] :] = np.nan
            self.codes[row, :, count[row] :] = -1
        return stops

    def _run_some(self, first: int) -> list[Stop]:
        """Run motions from this one on, to the first that stops before the end; why each did."""
        if self._booked > LEDGER_ROWS // 2:
            self._turn_page()
        frames, until = self._frames.words[first : first + AT_ONCE], self.times.item(-1)
        frames[0, BOOKED], room = self._booked, (LEDGER_ROWS - self._booked) // len(frames)
        frames[:, MOST_EVENTS] = min(room, self.solver.max_events)
        place = address_of(frames), frames.strides[0], len(frames)
        done, code = divmod(RUN_EACH.function(DRIVER.address, *place, until), REASONS)
        row, stop = first + done, STOPS[code]
        if stop == Stop.NO_STATE:
            stop = self._motion(row).explained(stop)
        elif stop == Stop.STEP_BUDGET:
            stop = self._motion(row).go_on(until, True)
        return [Stop.REACHED] * done + [self._gone_on(row, stop)]

    def _run_alone(self, row: int) -> list[Stop]:
        """Run a motion whose parameters vary."""
        self._open_page(row)
        motion = self._motion(row)
        return [self._gone_on(row, motion.go_on(self.times.item(-1), True), motion)]

    def _gone_on(self, row: int, stop: Stop, motion: Motion | None = None) -> Stop:
        """Why a motion stops at last; where it lacked room in the ledger it goes on."""
        words = self._frames.words[row]
        self._booked = words.item(BOOKED)
        while stop == Stop.EVENT_BUDGET and words.item(EVENTS) < self.solver.max_events:
            self._turn_page()
            self._open_page(row)
            motion = motion or self._motion(row)
            stop = motion.go_on(self.times.item(-1), True)
            self._booked = words.item(BOOKED)
        return stop

    def _open_page(self, row: int) -> None:
        """Let a motion have what is left of the page."""
        words, room = self._frames.words[row], LEDGER_ROWS - self._booked
        words[BOOKED] = self._booked
        words[MOST_EVENTS] = min(self.solver.max_events, words.item(EVENTS) + room)

    def _motion(self, row: int) -> Motion:
        """A motion by itself."""
        told = self.states[row].T, self.outputs[row].T, self.codes[row].T
        samples = Samples(self.times, *told)
        return Motion.of_frame(self.system, self.solver, self._frames.frame(row), samples)

    def _turn_page(self) -> None:
        """Put aside what the ledger holds."""
        self._pages.append([array[: self._booked].copy() for array in self._page.values()])
        self._booked = 0

    # --- what came of it --------------------------------------------------------------------------
    @property
    def lengths(self) -> Array:
        """Events of each motion, which lie one after the other in `ledger`."""
        return self.told("n_events")

    @property
    def ledger(self) -> Ledger:
        """Events of all motions, one after the other."""
        pages = map(np.concatenate, zip(*self._pages, strict=True))
        found = dict(zip(self._page, pages, strict=True))
        return Ledger(**{name.removeprefix("ledger_"): array for name, array in found.items()})

    def own(self, name: str) -> Array:
        """An array of every motion's own, as a row of each; shape (motions, ...)."""
        return self._frames.own(name)

    def told(self, name: str) -> Array:
        """A number of every frame; shape (motions,)."""
        return self._frames.told(name).copy()

    def energies(self) -> tuple[Vector, Vector]:
        """Kinetic and potential energy at the end, and what friction has stored in all contacts, J.

        Shape (motions,) each; NaN where no contact state holds.
        """
        kinds, times = self.own("kinds"), self.told("time")
        states, found = kinds @ 3 ** np.arange(kinds.shape[1]), np.full((2, len(times)), np.nan)
        for index, time in set(zip(states.tolist(), times.tolist(), strict=True)):
            if self.system.tables.field[index]:
                rows = np.flatnonzero((states == index) & (times == time))
                own = self.own("coefficients")[rows], time, self.own("y")[rows]
                there = self.system.field(index, *own)
                found[0, rows] = there.energies[:, KINETIC] + there.energies[:, POTENTIAL]
                found[1, rows] = there.stored.sum(axis=1)
        return found[0], found[1]
