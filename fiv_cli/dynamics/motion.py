"""A motion: one run of a system, taken forward piece by piece."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from enum import IntEnum
from functools import cache
from operator import attrgetter
from time import perf_counter
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from fiv_cli import ending
from fiv_cli.codegen.codes import (
    JAMMING,
    KINETIC,
    PER_CONTACT,
    POTENTIAL,
    SEPARATION,
    SINGULAR,
    SLIP,
    STICK,
)
from fiv_cli.codegen.memory import call_generated
from fiv_cli.dynamics import kernel
from fiv_cli.dynamics.arrays import (
    FIRST_STRIDE,
    NO_EXTREMES,
    NO_WORKS,
    blank_frame,
    extremes_of,
    ledger_of,
    sample_width,
)
from fiv_cli.dynamics.compiled import DRIVER
from fiv_cli.dynamics.settings import Section, SolverSettings
from fiv_cli.dynamics.system import FieldOutput, System, Vector
from fiv_cli.errors import UsageError
from fiv_cli.schedule import rate_of

DIRECTIONS = {"up": 1, "down": -1, "both": 0}
EVENTS = {
    "slip->stick": (SLIP, STICK),
    "stick->slip": (STICK, SLIP),
    "impact": (SEPARATION, kernel.ANY),
}
"""Events that a section may lie on: kinds of the contact before and after."""


class Stop(IntEnum):
    """Why a motion stopped."""

    REACHED = kernel.REACHED
    SECTION_FULL = kernel.SECTION_FULL
    STEP_BUDGET = kernel.STEP_BUDGET
    EVENT_BUDGET = kernel.EVENT_BUDGET
    DIVERGED = kernel.DIVERGED
    CONTACT_LOST = kernel.CONTACT_LOST
    NO_STATE = kernel.NO_STATE
    JAMMED = kernel.JAMMED
    CHATTERING = kernel.CHATTERING
    DEPENDENT = kernel.DEPENDENT
    NO_NUMBER = kernel.NO_NUMBER
    STANDS_STILL = kernel.NO_NUMBER + 1  # which the driver does not see


INFINITE = float("inf")
CALL_SECONDS = 0.1  # that a call of the driver may take
STILL = 1000  # steps in which nothing moves, many more than events at one instant may take
STOPS = tuple(Stop)  # by their numbers

# Reasons of the outcomes of motions that could not go on.
STOP_REASONS = {
    Stop.STEP_BUDGET: "too_many_steps",
    Stop.EVENT_BUDGET: "too_many_events",
    Stop.DIVERGED: "diverged",
    Stop.CONTACT_LOST: "contact_lost",
    Stop.NO_STATE: "no_consistent_state",
    Stop.JAMMED: "jammed",
    Stop.CHATTERING: "chattering",
    Stop.DEPENDENT: "dependent_contacts",
    Stop.NO_NUMBER: "no_number",
    Stop.STANDS_STILL: "time_stands_still",
}


class _Here(NamedTuple):
    """How many steps have led where: to which time and state."""

    n_steps: int
    place: tuple[float, bytes]


class Measures(NamedTuple):
    """What is integrated along a motion while measuring, as far as it is.

    Attributes
    ----------
    measured_time : s
    spread : integral of the squared distance from the reference
    other_work, friction_work, drive_work, impact_loss : terms of the energy balance, J
    largest_residual : of an event, relative
    least, greatest, squares : of each state, and the integral of its square; shape (n_states,)
    shares : time in slip, stick, separation; shape (n_contacts, 3)
    works : of each excitation, J
    """

    measured_time: float
    spread: float
    other_work: float
    friction_work: float
    drive_work: float
    impact_loss: float
    largest_residual: float
    least: Vector
    greatest: Vector
    squares: Vector
    shares: NDArray[np.float64]
    works: Vector

    @property
    def all_works(self) -> Vector:
        """Those of the energy balance, then of each excitation, J."""
        own = self.other_work, self.friction_work, self.drive_work, self.impact_loss
        return np.array([*own, *self.works])


# Sums that begin anew with every measuring; the largest residual, behind them, does not.
SUMS = slice(*(kernel.Run.fields[n].place for n in ("measured_time", "largest_residual")))


class Ledger(NamedTuple):
    """Events, each an entry of every array.

    Attributes
    ----------
    times : s
    before, after : contact states, see `CODE_NAMES`, or pieces of the law, see `Law.events`
    contacts : 0-based
    residuals : of the switching functions, relative
    """

    times: Vector
    before: NDArray[np.int64]
    after: NDArray[np.int64]
    contacts: NDArray[np.int64]
    residuals: Vector


LEDGER_OF = attrgetter(*(f"ledger_{name}" for name in Ledger._fields))


@dataclass
class Samples:
    """The motion at given times; what is told over time lies end to end in memory.

    Attributes
    ----------
    times : shape (n,), s
    states : shape (n, n_states)
    outputs : per contact (F_N, F_T, v_rel), what each has stored, then energies and powers;
        shape (n, ...)
    codes : contact states, see `CODE_NAMES`; shape (n, n_contacts)
    count : samples taken so far
    """

    times: Vector
    states: NDArray[np.float64]
    outputs: NDArray[np.float64]
    codes: NDArray[np.int64]
    count: int = 0

    @property
    def forces(self) -> NDArray[np.float64]:
        """(F_N, F_T, v_rel); shape (n, n_contacts, 3)."""
        contacts = self.codes.shape[1]
        of_contacts = self.outputs[:, : PER_CONTACT * contacts]
        return of_contacts.reshape(len(self.times), contacts, PER_CONTACT)


class Motion:
    """One run of a system.

    Parameters
    ----------
    system : the compiled system
    parameters : every parameter, SI
    solver : integrator settings
    state : initial state by name, the rest 0; or a state vector
    time : initial time, s
    sticking : contacts that stick from the start; they take on the drive's velocity
    events : room for a ledger that is kept from the start, and is the next motion's too
    """

    def __init__(
        self,
        system: System,
        parameters: Mapping[str, float],
        solver: SolverSettings,
        state: Mapping[str, float] | Vector,
        time: float = 0.0,
        sticking: tuple[bool, ...] = (),
        events: int = 0,
    ) -> None:
        frame = blank_frame(system, solver, events).copy()
        frame.put("parameters", system.parameter_values(parameters))
        self._take(system, solver, frame, no_samples(system), time)
        if len(state):
            vector = state if isinstance(state, np.ndarray) else system.state_vector(state)
            frame.y[:] = vector
        if time:
            frame.time = time
        for contact, sticks in enumerate(sticking):
            frame.kinds[contact] = STICK if sticks else frame.sliding_kinds[contact]

    @classmethod
    def of_frame(
        cls,
        system: System,
        solver: SolverSettings,
        frame: kernel.Run,
        samples: Samples,
        has_begun: bool = False,
    ) -> Motion:
        """The motion of a frame that was set out at t = 0 and shows `samples` already.

        `has_begun` : whether its contact state is decided
        """
        motion = cls.__new__(cls)
        motion._take(system, solver, frame, samples, 0.0)
        motion._has_begun = has_begun
        return motion

    def _take(
        self,
        system: System,
        solver: SolverSettings,
        frame: kernel.Run,
        samples: Samples,
        time: float,
    ) -> None:
        self.system, self.solver, self._frame, self.samples = system, solver, frame, samples
        self._has_begun = False
        self.stride = FIRST_STRIDE  # steps of a call of the driver
        self.kink = self._take_up_schedule(time) if system.setup.schedule.curves else INFINITE

    @property
    def frame(self) -> kernel.Run:
        """What the driver reads and writes.

        The contact state that a motion begins in is decided when it is first looked at, or by
        the call of the driver that takes it on.
        """
        if not self._has_begun:
            self._advance(self._frame.time, False, 0.0)
        return self._frame

    @property
    def started(self) -> bool:
        """Whether a contact state is consistent with the initial state."""
        return self.frame.task != kernel.ENTER

    @property
    def y(self) -> Vector:
        """State vector; shape (n_states,)."""
        return self.frame.y

    @property
    def kinds(self) -> NDArray[np.int64]:
        """Kind of each contact's state; shape (n_contacts,)."""
        return self.frame.kinds

    @property
    def is_held(self) -> bool:
        """Whether a contact sticks or a stop is closed."""
        return bool(kernel.holds(self.frame))

    @property
    def slip_signs(self) -> Vector:
        """Sign of slip in each contact, where it slips; shape (n_contacts,)."""
        return self.frame.slip_signs

    @property
    def ways(self) -> Vector:
        """How it slides: the numbers of the pieces of its law, then the signs of slip."""
        return self.frame.parameters[self.system.n_own_parameters : -1]

    @property
    def coefficients(self) -> Vector:
        """What depends on parameters alone, as the generated code reads it."""
        return self.frame.coefficients

    @property
    def tangents(self) -> NDArray[np.float64]:
        """Tangent vectors, as rows."""
        return self.frame.tangents

    @property
    def measures(self) -> Measures:
        """What was measured; before `start_measuring`, residuals and impacts only."""
        return Measures(*(getattr(self.frame, name) for name in Measures._fields))

    @property
    def extremes(self) -> NDArray[np.float64]:
        """Least and greatest value of each state while measuring; shape (2, n_states)."""
        return np.array([self.frame.least, self.frame.greatest])

    @property
    def ledger(self) -> Ledger:
        """Events since `keep_ledger`, or since the start."""
        count = self.frame.n_ledger
        return Ledger(*[array[:count] for array in LEDGER_OF(self.frame)])

    # --- parameters that vary in time -----------------------------------------------------------
    def _take_up_schedule(self, time: float) -> float:
        """Set what varies to the piece that begins at `time`; returns where it ends, s."""
        schedule, names = self.system.setup.schedule, self.system.generated.parameter_names
        for name, (value, rate) in schedule.piece(time).items():
            self._frame.parameters[names.index(name)] = value
            self._frame.parameters[names.index(rate_of(name))] = rate
        self._frame.filled_for = 0.0
        return schedule.next_kink(time)

    def _pass_kink(self) -> None:
        """Go on with the next piece: forces jump, so the contact states are decided anew."""
        self.kink = self._take_up_schedule(self.kink)
        self._frame.task = kernel.DECIDE

    # --- generated functions at the present state -------------------------------------------------
    @property
    def state_index(self) -> int:
        """Number of the contact state."""
        return int(kernel.state_index(self.kinds, len(self.kinds)))

    def _field(self, index: int) -> FieldOutput:
        return self.system.field(index, self.coefficients, self.time, self.y)

    def _is_out_of_contact(self) -> bool:
        """Whether a contact that cannot open would have to pull."""
        normal_forces = self._field(self.system.sliding_index).contacts[:, 0]
        return bool(np.any((self.system.tables.is_end == 1) & (normal_forces < 0.0)))

    # --- going on -------------------------------------------------------------------------------
    @property
    def time(self) -> float:
        """Current time, s."""
        return self.frame.time

    @property
    def n_events(self) -> int:
        """Events so far."""
        return self.frame.n_events

    @property
    def n_steps(self) -> int:
        """Steps so far."""
        return self.frame.n_steps

    @property
    def codes(self) -> list[int]:
        """Contact states, see `CODE_NAMES`."""
        pairs = zip(self.kinds.tolist(), self.slip_signs.tolist(), strict=True)
        return [int(kernel.code_of(kind, sign)) for kind, sign in pairs]

    def keep_ledger(self, rows: int) -> None:
        """Record up to `rows` further events."""
        if len(self.frame.ledger_times) != rows:
            for name, array in ledger_of(rows).items():
                self.frame.show(name, array)
        self.frame.n_ledger = 0

    def start_measuring(self, reference: Vector | None = None) -> None:
        """Forget what was measured and measure from here on, L_s about `reference`.

        Without one only energies are measured and shares: half of what it takes.
        """
        self.frame.words[SUMS] = 0
        self.frame.n_impacts = self.frame.n_accumulations = 0
        measured = NO_EXTREMES if reference is None else extremes_of(reference, len(self.y))
        for name, array in measured.items():
            self.frame.show(name, array)
        self.frame.show("shares", np.zeros((self.system.n_contacts, 3)))
        self.frame.show("works", np.zeros(len(self.system.setup.model.powers)))

    def carry_tangents(self, tangents: NDArray[np.float64]) -> None:
        """Carry tangent vectors (rows) along from here on."""
        self.stride = FIRST_STRIDE // (1 + len(tangents))  # steps cost more now
        self._may_go_on()
        self.frame.show("tangents", np.ascontiguousarray(tangents, dtype=float))
        if len(tangents):
            self.frame.sum_tangent = self.system.sum_tangent
            for name, table in self.system.tangent_tables.items():
                self.frame.show(name, table)

    def run(
        self,
        t_stop: float,
        section: Section | None = None,
        sections: tuple[NDArray[np.float64], ...] | None = None,
        samples: Samples | None = None,
        measuring: bool = False,
        phase_interval: float = 0.0,
    ) -> Stop:
        """Go on until `t_stop`, full `sections`, or an end.

        Parameters
        ----------
        t_stop : s
        section : what goes into `sections`
        sections : what `show_section` shows, to fill from the front
        samples : filled where its times are reached
        measuring : whether `measures` are integrated
        phase_interval : period of the excitation, s, for a stroboscopic section

        Raises
        ------
        UsageError : a stroboscopic section without a period
        """
        frame = self._frame
        frame.first_step = 0.0  # another motion may have used the scratch arrays
        frame.n_sections = 0
        if section is not None and section.kind == "phase":
            frame.next_phase = self._next_phase(section.phase, phase_interval)
        if sections is not None or frame.section_kind != kernel.SECTION_NONE:
            self.show_section(section, *sections or self._no_sections())
        self._fill_samples(samples or no_samples(self.system))
        return self.go_on(t_stop, measuring, phase_interval)

    def go_on(self, t_stop: float, measuring: bool, phase_interval: float = 0.0) -> Stop:
        """Go on as `run` does, with the section and the samples that are asked for already."""
        while self.kink < t_stop:
            stop = self._advance(self.kink, measuring, phase_interval)
            if stop != Stop.REACHED:
                return self.explained(stop)
            self._pass_kink()
        stop = self._advance(t_stop, measuring, phase_interval)
        return stop if stop == Stop.REACHED else self.explained(stop)

    def _next_phase(self, phase: float, period: float) -> float:
        """The next instant of a stroboscopic section; one that is now has been passed."""
        if not period > 0.0:
            raise UsageError(
                f"phase_interval={period}: a section at a phase of the excitation has no period\n"
                "next: give the period of the excitation, s"
            )
        offset = phase / (2 * np.pi) * period
        return float(offset + (np.floor((self.time - offset) / period + 1e-9) + 1) * period)

    def explained(self, stop: Stop) -> Stop:
        """`stop`, or what it is that leaves no contact state."""
        if stop != Stop.NO_STATE:
            return stop
        if self.n_steps == 0 and self._is_out_of_contact():
            return Stop.CONTACT_LOST
        if self._is_dependent():
            return Stop.DEPENDENT
        return Stop.JAMMED if self._is_jammed() else stop

    def _is_dependent(self) -> bool:
        """Whether the conditions of the contacts at rest are not independent, or may not be."""
        kinds = np.where(self.frame.is_at_rest == 1, STICK, self.frame.sliding_kinds)
        index = int(kernel.state_index(kinds, len(kinds)))
        tables = self.system.tables
        if tables.field[index] == 0:
            return False
        is_singular = SINGULAR in tables.guard_kinds[index, : tables.n_guards[index]]
        return is_singular or bool(np.isnan(self._field(index).switching).any())

    def _is_jammed(self) -> bool:
        """Whether the determinant of an algebraic normal force has lost its sign in sliding."""
        tables, parameters = self.system.tables, self.frame.parameters.copy()
        index = self.system.sliding_index
        kinds = tables.guard_kinds[index, : tables.n_guards[index]]
        for sign in (1.0, -1.0):
            parameters[-1 - len(self.kinds) : -1] = sign
            coefficients = self.system.coefficients(parameters)
            switching = self.system.field(index, coefficients, self.time, self.y).switching
            if np.any(switching[kinds == JAMMING] <= 0.0):
                return True
        return False

    def show_section(
        self,
        section: Section | None,
        times: Vector,
        states: NDArray[np.float64],
        works: NDArray[np.float64] = NO_WORKS,
    ) -> None:
        """Say what goes into which section points: times (m,), states (m, n_states) and, where
        they are asked for, `Measures.all_works` done by then, (m, works)."""
        frame = self._frame
        frame.words[SECTION_WORDS] = section_words(self.system, section)
        frame.max_sections = len(times)
        frame.show("section_times", times)
        frame.show("section_states", states)
        frame.show("section_works", works)

    def _no_sections(self) -> tuple[Vector, NDArray[np.float64]]:
        """Where no section is asked for (shared: nothing is ever written)."""
        return self._frame.shown["section_times"], self._frame.shown["section_states"]

    def _fill_samples(self, samples: Samples) -> None:
        self._frame.n_sampled = samples.count
        if samples is not self.samples:
            self.samples = samples
            for name in ("times", "states", "outputs", "codes"):
                self._frame.show(f"sample_{name}", getattr(samples, name).T)

    def _advance(self, t_stop: float, measuring: bool, phase_interval: float) -> Stop:
        """Call the driver."""
        self._has_begun, frame = True, self._frame
        stop = self.drive(DRIVER.function, frame.address, t_stop, phase_interval, measuring)
        self.samples.count = frame.n_sampled
        return stop

    def drive(self, going_on: Callable[..., int], *asked: float) -> Stop:
        """Call what goes on with the motion until it ends for another reason than to look up."""
        code, since = going_on(*asked), _Here(0, (0.0, b""))
        while code == kernel.STEP_BUDGET and self._may_go_on():
            begun, here = perf_counter(), _Here(self.n_steps, (self.time, self.y.tobytes()))
            since = here if here.place != since.place else since
            if here.n_steps - since.n_steps >= STILL:
                self.frame.n_steps = self.solver.max_steps  # the rest would be like these
                return Stop.STANDS_STILL
            code = going_on(*asked)
            self.stride = next_stride(self.stride, perf_counter() - begun)
        return STOPS[code]

    def _may_go_on(self) -> bool:
        """Whether steps are left; the driver comes back every so often, to be ended here.

        What it goes on from is all in the arrays, so a motion in pieces has the bits of one in one.
        """
        ending.heed()
        done, limit = self.n_steps, self.solver.max_steps
        self.frame.max_steps = min(done + self.stride, limit)
        return done < limit

    @property
    def n_sections(self) -> int:
        """Section points of the last `run`."""
        return self.frame.n_sections

    def rates(self) -> Vector:
        """Time derivative of the state; shape (n_states,). NaN where no contact state holds."""
        n = len(self.y)
        return self._outputs()[0][n : 2 * n].copy()

    def _outputs(self) -> tuple[Vector, int]:
        """What the field function says of the state (until the next one), and where energies begin.

        NaN where no contact state holds.
        """
        index, tables, outputs = self.state_index, self.system.tables, self.frame.outputs
        field = tables.field.item(index)
        if field:
            call_generated(field, self.coefficients, self.time, self.y, outputs)
        else:
            outputs[:] = np.nan
        return outputs, tables.energy_place.item(index)

    # --- energy ---------------------------------------------------------------------------------
    def energy(self) -> float:
        """Kinetic and potential energy, J; NaN where no contact state holds."""
        outputs, first = self._outputs()
        return outputs.item(first + KINETIC) + outputs.item(first + POTENTIAL)


def next_stride(stride: int, seconds: float) -> int:
    """Steps of the next call of the driver, after one that took so long."""
    share = CALL_SECONDS / max(seconds, 1e-9)
    return max(1, int(stride * min(share, 2.0)))


FIRST_OF_SECTION = kernel.Run.fields["section_kind"].place
SECTION_WORDS = slice(FIRST_OF_SECTION, FIRST_OF_SECTION + 6)


@cache
def section_words(system: System, section: Section | None) -> NDArray[np.int64]:
    """A section as the kernel reads it: kind, from, to, contact, state, direction."""
    if section is None:
        return np.array([kernel.SECTION_NONE, 0, 0, 0, 0, 0])
    contact = section.contact - 1
    if section.kind == "event":
        before, after = EVENTS[section.event]
        return np.array([kernel.SECTION_EVENT, before, after, contact, 0, 0])
    if section.kind == "zero":
        state, direction = system.state_names.index(section.state), DIRECTIONS[section.direction]
        return np.array([kernel.SECTION_ZERO, 0, 0, contact, state, direction])
    return np.array([kernel.SECTION_PHASE, 0, 0, contact, 0, 0])


def samples_at(system: System, times: Vector) -> Samples:
    """Room for the motion at `times`."""
    contacts, count = system.n_contacts, len(times)
    return Samples(
        times,
        np.zeros((len(system.state_names), count)).T,
        np.zeros((sample_width(system), count)).T,
        np.zeros((contacts, count), np.int64).T,
    )


@cache
def no_samples(system: System) -> Samples:
    """No samples at all (shared: nothing is ever written)."""
    return samples_at(system, np.zeros(0))
