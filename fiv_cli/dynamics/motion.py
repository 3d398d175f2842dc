"""A motion: one run of a system, taken forward piece by piece."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from enum import IntEnum
from functools import cache, cached_property
from time import perf_counter

import numpy as np
from numpy.typing import NDArray

from fiv_cli import ending
from fiv_cli.codegen.memory import address_of, call_generated
from fiv_cli.dynamics import kernel
from fiv_cli.dynamics.arrays import FIRST_STRIDE, NO_SECTION, PLACES, MotionArrays, layout_of
from fiv_cli.dynamics.compiled import DRIVER
from fiv_cli.dynamics.settings import Section, SolverSettings
from fiv_cli.dynamics.system import System, Vector
from fiv_cli.models.base import rate_of

DIRECTIONS = {"up": 1, "down": -1, "both": 0}
KIND_NAMES = {"slip": kernel.SLIP, "stick": kernel.STICK, "separation": kernel.SEPARATION}
CODE_NAMES = ("slip+", "slip-", "stick", "separation")


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


INFINITE = float("inf")
CALL_SECONDS = 0.1  # that a call of the driver may take
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
}


@dataclass
class Measures:
    """What is integrated along a motion while measuring.

    Attributes
    ----------
    totals : see the M_ constants of the kernel
    extremes : least value, greatest value, integral of the square; shape (3, n_states)
    shares : time in slip, stick, separation; shape (n_contacts, 3)
    reference : the sliding equilibrium that L_s is measured from, NaN for a coordinate that does
        not count; shape (n_coordinates,)
    """

    totals: Vector
    extremes: NDArray[np.float64]
    shares: NDArray[np.float64]
    reference: Vector

    @property
    def time(self) -> float:
        """Measured time, s."""
        return float(self.totals[kernel.M_TIME])


def no_measures(system: System) -> Measures:
    """Measures before the first step."""
    extremes = np.zeros((3, len(system.state_names)))
    extremes[0], extremes[1] = np.inf, -np.inf
    return Measures(
        np.zeros(kernel.MEASURES_WIDTH),
        extremes,
        np.zeros((system.n_contacts, 3)),
        np.zeros(len(system.coordinates)),
    )


@dataclass
class Samples:
    """The motion at given times.

    Attributes
    ----------
    times : shape (n,), s
    states : shape (n, n_states)
    outputs : per contact (F_N, F_T, v_rel), then energies and powers; shape (n, ...)
    codes : contact states, see `CODE_NAMES`; shape (n, n_contacts)
    count : samples taken so far
    """

    times: Vector
    states: NDArray[np.float64]
    outputs: NDArray[np.float64]
    codes: NDArray[np.int64]
    count: int = 0


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
    """

    def __init__(
        self,
        system: System,
        parameters: Mapping[str, float],
        solver: SolverSettings,
        state: Mapping[str, float] | Vector,
        time: float = 0.0,
        sticking: tuple[bool, ...] = (),
    ) -> None:
        self.system = system
        self.solver = solver
        self.tables = system.tables
        self.layout = layout = layout_of(system, solver)
        self.arrays = arrays = MotionArrays(layout)
        self.ledger, self.tangents = layout.shared["ledger"], layout.shared["tangents"]
        self.samples = no_samples(system)
        values = system.parameter_values(parameters)
        arrays.floats[layout.given] = values
        self.kink = self._take_up_schedule(time) if system.setup.schedule.curves else INFINITE
        if len(state):
            vector = state if isinstance(state, np.ndarray) else system.state_vector(state)
            arrays.y[:] = vector
        if time != 0.0:
            arrays.clock[kernel.TIME] = time
        for contact, sticks in enumerate(sticking):
            arrays.kinds[contact] = kernel.STICK if sticks else kernel.SLIP
        self.is_lost = False  # no contact state is consistent with the initial state
        self.is_entered = False  # a contact state was seen to be decided
        self.stride = FIRST_STRIDE  # steps of a call of the driver

    @property
    def clock(self) -> Vector:
        """Times, see the kernel."""
        return self.arrays.clock

    @property
    def counters(self) -> NDArray[np.int64]:
        """What was counted, see the kernel."""
        return self.arrays.counters

    @property
    def config(self) -> NDArray[np.int64]:
        """See the kernel."""
        return self.layout.shared["config"]

    # The contact state is decided at the first look or by the first `run`: of a motion that is only
    # run the driver is called once.
    @property
    def started(self) -> bool:
        """Whether a contact state is consistent with the initial state."""
        if self.is_entered:
            return True
        if self.clock[kernel.TASK] == kernel.ENTER and not self.is_lost:
            self.is_lost = self._advance(self.time, False, 0.0) == Stop.NO_STATE
        self.is_entered = not self.is_lost
        return self.is_entered

    def _entered(self) -> MotionArrays:
        """The arrays with the contact state decided."""
        if not self.is_entered:
            _ = self.started
        return self.arrays

    @property
    def y(self) -> Vector:
        """State vector; shape (n_states,)."""
        return self._entered().y

    @property
    def parameters(self) -> Vector:
        """Parameters, signs of slip, sector."""
        return self._entered().parameters

    @property
    def coefficients(self) -> Vector:
        """What depends on parameters alone, as the generated code reads it."""
        return self._entered().coefficients

    @property
    def kinds(self) -> NDArray[np.int64]:
        """Kind of each contact's state; shape (n_contacts,)."""
        return self._entered().kinds

    @property
    def limits(self) -> NDArray[np.int64]:
        """Budgets, see the kernel."""
        return self.arrays.limits

    @cached_property
    def measures(self) -> Measures:
        """What was measured; before `start_measuring`, residuals and impacts only."""
        shared = self.layout.shared
        return Measures(
            self.arrays.measures, shared["extremes"], shared["shares"], shared["reference"]
        )

    # --- parameters that vary in time -----------------------------------------------------------
    def _take_up_schedule(self, time: float) -> float:
        """Set what varies to the piece that begins at `time`; returns where it ends, s."""
        schedule, names = self.system.setup.schedule, self.system.generated.parameter_names
        for name, (value, rate) in schedule.piece(time).items():
            self.arrays.parameters[names.index(name)] = value
            self.arrays.parameters[names.index(rate_of(name))] = rate
        self.clock[kernel.FILLED_FOR] = 0.0
        return schedule.next_kink(time)

    def _pass_kink(self) -> None:
        """Go on with the next piece: forces jump, so the contact states are decided anew."""
        self.kink = self._take_up_schedule(self.kink)
        self.clock[kernel.TASK] = kernel.DECIDE

    # --- generated functions at the present state -------------------------------------------------
    def _field(self, kinds: NDArray[np.int64]) -> tuple[int, Vector]:
        index = kernel.state_index(kinds, len(kinds))
        out = self._output()
        address = self.tables.table[index, kernel.FIELD]
        call_generated(address, self.coefficients, self.time, self.y, out)
        return index, out

    def _output(self) -> Vector:
        """Room for what the generated functions say of a state."""
        return np.zeros(self.layout.shared["stages"].shape[1])

    def _is_out_of_contact(self) -> bool:
        """Whether a contact that cannot open would have to pull."""
        count = self.system.n_contacts
        index, out = self._field(np.full(count, kernel.SLIP, np.int64))
        first = kernel.contact_outputs(self.tables.table, index, len(self.y))
        normal_forces = out[first : first + kernel.PER_CONTACT * count : kernel.PER_CONTACT]
        return bool(np.any((self.tables.ends == 1) & (normal_forces < 0.0)))

    # --- going on -------------------------------------------------------------------------------
    @property
    def time(self) -> float:
        """Current time, s."""
        return float(self.clock[kernel.TIME])

    @property
    def n_events(self) -> int:
        """Events so far."""
        return int(self.counters[kernel.EVENTS])

    @property
    def n_steps(self) -> int:
        """Steps so far."""
        return int(self.counters[kernel.STEPS])

    @property
    def codes(self) -> list[int]:
        """Contact states, see `CODE_NAMES`."""
        first = len(self.parameters) - 1 - self.system.n_contacts
        return [
            int(kernel.code_of(kind, self.parameters[first + i]))
            for i, kind in enumerate(self.kinds)
        ]

    def keep_ledger(self, rows: int) -> None:
        """Record up to `rows` further events."""
        self.ledger = np.zeros((rows, kernel.LEDGER_WIDTH))
        self.arrays.show("ledger", self.ledger)
        self.counters[kernel.LEDGER] = 0

    def start_measuring(self, reference: Vector) -> None:
        """Forget what was measured and measure from here on, L_s about `reference`."""
        residual = self.measures.totals[kernel.M_RESIDUAL]
        self.measures = no_measures(self.system)
        self.measures.totals[kernel.M_RESIDUAL] = residual
        self.measures.reference[:] = reference
        self.arrays.show("measures", self.measures.totals)
        for name in ("extremes", "shares", "reference"):
            self.arrays.show(name, getattr(self.measures, name))

    def carry_tangents(self, tangents: NDArray[np.float64]) -> None:
        """Carry tangent vectors (rows) along from here on."""
        self.stride = FIRST_STRIDE // (1 + len(tangents))  # steps cost more now
        self._may_go_on()
        self.tangents = np.ascontiguousarray(tangents, dtype=float)
        self.arrays.show("tangents", self.tangents)
        if len(tangents):
            self.arrays.show("table", self.system.tangent_table)
            self.arrays.show("impacts", self.system.tangent_impacts)

    def run(
        self,
        t_stop: float,
        section: Section | None = None,
        sections: tuple[Vector, NDArray[np.float64]] | None = None,
        samples: Samples | None = None,
        measuring: bool = False,
        phase_interval: float = 0.0,
    ) -> Stop:
        """Go on until `t_stop`, full `sections`, or an end.

        Parameters
        ----------
        t_stop : s
        section : what goes into `sections`
        sections : times (m,) and states (m, n_states) to fill from the front
        samples : filled where its times are reached
        measuring : whether `measures` are integrated
        phase_interval : period of the excitation, s, for a stroboscopic section
        """
        arrays, layout = self.arrays, self.layout
        arrays.floats[layout.first_step] = 0.0  # another motion may have used the scratch arrays
        arrays.frame[layout.n_sections] = 0
        arrays.frame[PLACES["section"]] = section_address(self.system, section)
        self._fill_sections(*sections or self._no_sections())
        self._fill_samples(samples or no_samples(self.system))

        while self.kink < t_stop:
            stop = self._advance(self.kink, measuring, phase_interval)
            if stop != Stop.REACHED:
                return self._stuck(stop)
            self._pass_kink()
        stop = self._advance(t_stop, measuring, phase_interval)
        return stop if stop == Stop.REACHED else self._stuck(stop)

    def _stuck(self, stop: Stop) -> Stop:
        """`stop`, or what it is that leaves no contact state."""
        if stop == Stop.NO_STATE and self.clock[kernel.TASK] == kernel.ENTER:
            self.is_lost = True
            if self._is_out_of_contact():
                return Stop.CONTACT_LOST
        return Stop.JAMMED if stop == Stop.NO_STATE and self._is_jammed() else stop

    def _is_jammed(self) -> bool:
        """Whether the determinant of an algebraic normal force has lost its sign in sliding."""
        index = kernel.state_index(np.zeros_like(self.kinds), len(self.kinds))
        kinds = self.tables.guards[index, : self.tables.table[index, kernel.N_GUARDS], 0]
        first, places = 2 * len(self.y), np.flatnonzero(kinds == kernel.JAMMING)
        out, coefficients = self._output(), self.coefficients.copy()
        parameters = self.parameters.copy()
        for sign in (1.0, -1.0):
            parameters[-1 - len(self.kinds) : -1] = sign
            call_generated(
                self.config[kernel.COEFFICIENTS], coefficients, 0.0, parameters, coefficients
            )
            field = self.tables.table[index, kernel.FIELD]
            call_generated(field, coefficients, self.time, self.y, out)
            if np.any(out[first + places] <= 0.0):
                return True
        return False

    def _fill_sections(self, times: Vector, states: NDArray[np.float64]) -> None:
        self.arrays.frame[self.layout.max_sections] = len(times)
        self.arrays.show("section_times", times)
        self.arrays.show("section_states", states)

    def _no_sections(self) -> tuple[Vector, NDArray[np.float64]]:
        """Where no section is asked for (shared: nothing is ever written)."""
        return self.layout.shared["section_times"], self.layout.shared["section_states"]

    def _fill_samples(self, samples: Samples) -> None:
        self.arrays.frame[self.layout.n_sampled] = samples.count
        if samples is not self.samples:
            self.samples = samples
            for name in ("times", "states", "outputs", "codes"):
                self.arrays.show(f"sample_{name}", getattr(samples, name))

    def _advance(self, t_stop: float, measuring: bool, phase_interval: float) -> Stop:
        """Call the driver."""
        driver = DRIVER.function
        code = driver(self.arrays.address, t_stop, phase_interval, measuring)
        while code == kernel.STEP_BUDGET and self._may_go_on():
            begun = perf_counter()
            code = driver(self.arrays.address, t_stop, phase_interval, measuring)
            self.stride = next_stride(self.stride, perf_counter() - begun)
        self.samples.count = self.arrays.frame.item(self.layout.n_sampled)
        return STOPS[code]

    def _may_go_on(self) -> bool:
        """Whether steps are left; the driver comes back every so often, to be ended here.

        What it goes on from is all in the arrays, so a motion in pieces has the bits of one in one.
        """
        ending.heed()
        done, limit = self.n_steps, self.solver.max_steps
        self.limits[kernel.MAX_STEPS] = min(done + self.stride, limit)
        return done < limit

    @property
    def n_sections(self) -> int:
        """Section points of the last `run`."""
        return int(self.counters[kernel.SECTIONS])

    def rates(self) -> Vector:
        """Time derivative of the state; shape (n_states,). NaN where no contact state holds."""
        n = len(self.y)
        if not self._has_equations():
            return np.full(n, np.nan)
        return self._field(self.kinds)[1][n : 2 * n]

    def _has_equations(self) -> bool:
        """Whether the contact state is one of the model's: one that was never found is not."""
        index = kernel.state_index(self.kinds, len(self.kinds))
        return bool(self.tables.table[index, kernel.FIELD] != 0)

    # --- energy ---------------------------------------------------------------------------------
    def energy(self) -> float:
        """Kinetic and potential energy, J; NaN where no contact state holds."""
        if not self._has_equations():
            return float("nan")
        index, out = self._field(self.kinds)
        first = kernel.contact_outputs(self.tables.table, index, len(self.y))
        first += kernel.PER_CONTACT * self.system.n_contacts
        return float(out[first + kernel.KINETIC] + out[first + kernel.POTENTIAL])


def next_stride(stride: int, seconds: float) -> int:
    """Steps of the next call of the driver, after one that took so long."""
    share = CALL_SECONDS / max(seconds, 1e-9)
    return max(1, int(stride * min(share, 2.0)))


@cache
def section_address(system: System, section: Section | None) -> int:
    """Where a section stands as the kernel reads it."""
    return address_of(NO_SECTION if section is None else section_vector(system, section))


@cache
def section_vector(system: System, section: Section) -> NDArray[np.int64]:
    """A section as the kernel reads it."""
    vector = np.zeros_like(NO_SECTION)
    vector[kernel.SECTION_CONTACT] = section.contact - 1
    if section.kind == "event":
        before, after = section.event.split("->")
        vector[kernel.SECTION_KIND] = kernel.SECTION_EVENT
        vector[kernel.SECTION_FROM] = KIND_NAMES[before]
        vector[kernel.SECTION_TO] = KIND_NAMES[after]
    elif section.kind == "zero":
        vector[kernel.SECTION_KIND] = kernel.SECTION_ZERO
        vector[kernel.SECTION_STATE] = system.state_names.index(section.state)
        vector[kernel.SECTION_DIRECTION] = DIRECTIONS[section.direction]
    else:
        vector[kernel.SECTION_KIND] = kernel.SECTION_PHASE
    return vector


def samples_at(system: System, times: Vector) -> Samples:
    """Room for the motion at `times`."""
    contacts, count = system.n_contacts, len(times)
    return Samples(
        times,
        np.zeros((count, len(system.state_names))),
        np.zeros((count, kernel.PER_CONTACT * contacts + kernel.N_ENERGIES)),
        np.zeros((count, contacts), np.int64),
    )


@cache
def no_samples(system: System) -> Samples:
    """No samples at all (shared: nothing is ever written)."""
    return samples_at(system, np.zeros(0))
