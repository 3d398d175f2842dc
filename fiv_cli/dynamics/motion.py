"""A motion: one run of a system, taken forward piece by piece."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from enum import IntEnum
from functools import cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fiv_cli.codegen.names import rate_of
from fiv_cli.dynamics import kernel, roots
from fiv_cli.dynamics.settings import Section, SolverSettings
from fiv_cli.dynamics.system import System, Vector

SCRATCH_ROWS = 7
# A state (m, rad, and those per s) beyond this has diverged. Growth in a nonlinear contact ends in
# ever shorter steps, so a bound far above anything mechanical would only cost time.
BOUND = 1e6
NO_SECTION = np.zeros(6, np.int64)
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

    def afresh(self) -> Measures:
        """For a motion that measures nothing: totals of its own, the rest is never written."""
        return Measures(np.zeros(kernel.MEASURES_WIDTH), self.extremes, self.shares, self.reference)


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
        self._allocate(system, solver)
        self.parameters = system.parameter_vector(parameters)
        self.kink = self._take_up_schedule(time)
        vector = state if isinstance(state, np.ndarray) else system.state_vector(state)
        self.y[:] = vector
        self.clock[kernel.TIME] = time
        for contact, sticks in enumerate(sticking):
            self.kinds[contact] = kernel.STICK if sticks else kernel.SLIP
        self.started = self._enter()

    def _allocate(self, system: System, solver: SolverSettings) -> None:
        scratch = scratch_of(system)
        n, contacts = len(system.state_names), system.n_contacts
        self.config = self.tables.config
        if solver.method == "rk4":
            self.config = self.config.copy()
            self.config[kernel.METHOD] = kernel.METHOD_RK4
        self.clock = np.zeros(kernel.CLOCK_WIDTH)
        self.kinds = np.zeros(contacts, np.int64)
        self.coefficients = np.zeros(max(system.generated.n_coefficients, 1))
        self.y = np.zeros(n)
        self.tolerances = np.array([solver.rtol, solver.step, BOUND])
        self.strips = np.zeros(self.tables.guards.shape[1] + 3, np.int64)
        self.counters = np.zeros(kernel.COUNTERS_WIDTH, np.int64)
        self.limits = np.array([solver.max_steps, solver.max_events, 0], np.int64)
        self.series, self.work, self.stages = scratch.series, scratch.work, scratch.stages
        self.roots, self.options = scratch.roots, scratch.options
        self.quadrature = scratch.quadrature
        self.measures = scratch.unmeasured.afresh()
        self.ledger, self.tangents = scratch.no_ledger, scratch.no_tangents

    # --- parameters that vary in time -----------------------------------------------------------
    def _take_up_schedule(self, time: float) -> float:
        """Set what varies to the piece that begins at `time`; returns where it ends, s."""
        schedule, names = self.system.schedule, self.system.generated.parameter_names
        if not schedule.curves:
            return float("inf")
        for name, (value, rate) in schedule.piece(time).items():
            self.parameters[names.index(name)] = value
            self.parameters[names.index(rate_of(name))] = rate
        self.clock[kernel.FILLED_FOR] = 0.0
        return schedule.next_kink(time)

    def _pass_kink(self) -> None:
        """Go on with the next piece: forces jump, so the contact states are decided anew."""
        self.kink = self._take_up_schedule(self.kink)
        self.clock[kernel.TASK] = kernel.DECIDE

    # --- start ----------------------------------------------------------------------------------
    def _enter(self) -> bool:
        """Find the contact state of the initial state; False when none is consistent."""
        self.clock[kernel.TASK] = kernel.ENTER
        nothing, nowhere = scratch_of(self.system).no_sections
        idle = no_samples(self.system)
        stop = self._advance(self.time, NO_SECTION, (nothing, nowhere), idle, False, 0.0)
        return stop == Stop.REACHED

    def _field(self, kinds: NDArray[np.int64]) -> tuple[int, Vector]:
        index = kernel.state_index(kinds, len(kinds))
        out = np.zeros(self.stages.shape[1])
        address = self.tables.table[index, kernel.FIELD]
        call(address, self.coefficients, self.time, self.y, out)
        return index, out

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
        self.ledger = np.zeros((rows, 5))
        self.counters[kernel.LEDGER] = 0

    def start_measuring(self, reference: Vector) -> None:
        """Forget what was measured and measure from here on, L_s about `reference`."""
        residual = self.measures.totals[kernel.M_RESIDUAL]
        self.measures = no_measures(self.system)
        self.measures.totals[kernel.M_RESIDUAL] = residual
        self.measures.reference[:] = reference

    def carry_tangents(self, tangents: NDArray[np.float64]) -> None:
        """Carry tangent vectors (rows) along from here on."""
        self.tangents = np.ascontiguousarray(tangents, dtype=float)
        if len(tangents):
            self.tables = replace(
                self.tables,
                table=self.system.tangent_table,
                impacts=self.system.tangent_impacts,
            )

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
        if not self.started:
            return Stop.CONTACT_LOST if self._is_out_of_contact() else self._stuck(Stop.NO_STATE)
        times, states = sections or scratch_of(self.system).no_sections
        samples = samples or no_samples(self.system)
        self.clock[kernel.FIRST_STEP] = 0.0  # another motion may have used the scratch arrays
        self.counters[kernel.SECTIONS] = 0
        self.counters[kernel.SAMPLED] = samples.count
        self.limits[kernel.MAX_SECTIONS] = len(times)
        vector = self.section_vector(section)

        def go_on(until: float) -> Stop:
            return self._advance(until, vector, (times, states), samples, measuring, phase_interval)

        while self.kink < t_stop:
            stop = go_on(self.kink)
            if stop != Stop.REACHED:
                return self._stuck(stop)
            self._pass_kink()
        return self._stuck(go_on(t_stop))

    def _stuck(self, stop: Stop) -> Stop:
        """`stop`, or that it is jamming which leaves no contact state."""
        return Stop.JAMMED if stop == Stop.NO_STATE and self._is_jammed() else stop

    def _is_jammed(self) -> bool:
        """Whether the determinant of an algebraic normal force has lost its sign in sliding."""
        index = kernel.state_index(np.zeros_like(self.kinds), len(self.kinds))
        kinds = self.tables.guards[index, : self.tables.table[index, kernel.N_GUARDS], 0]
        first, places = 2 * len(self.y), np.flatnonzero(kinds == kernel.JAMMING)
        out, coefficients = np.zeros(self.stages.shape[1]), self.coefficients.copy()
        parameters = self.parameters.copy()
        for sign in (1.0, -1.0):
            parameters[-1 - len(self.kinds) : -1] = sign
            call(self.config[kernel.COEFFICIENTS], coefficients, 0.0, parameters, coefficients)
            field = self.tables.table[index, kernel.FIELD]
            call(field, coefficients, self.time, self.y, out)
            if np.any(out[first + places] <= 0.0):
                return True
        return False

    def _advance(
        self,
        t_stop: float,
        section: NDArray[np.int64],
        sections: tuple[Vector, NDArray[np.float64]],
        samples: Samples,
        measuring: bool,
        phase_interval: float,
    ) -> Stop:
        """Call the driver."""
        times, states = sections
        code = kernel.advance(
            self.tables.table, self.tables.impacts, self.tables.guards, self.config, self.clock,
            self.kinds, self.parameters, self.coefficients, self.y, self.tolerances, self.strips,
            self.counters, self.limits, t_stop, section, phase_interval,
            self.tables.ends, times, states, samples.times, samples.states, samples.outputs,
            samples.codes, self.ledger, measuring, self.quadrature, self.measures.reference,
            self.measures.totals, self.measures.extremes, self.measures.shares, self.tangents,
            self.series, self.work, self.stages, self.roots, self.options,
        )  # fmt: skip
        samples.count = int(self.counters[kernel.SAMPLED])
        return Stop(code)

    @property
    def n_sections(self) -> int:
        """Section points of the last `run`."""
        return int(self.counters[kernel.SECTIONS])

    def section_vector(self, section: Section | None) -> NDArray[np.int64]:
        """A section as the kernel reads it."""
        if section is None:
            return NO_SECTION
        vector = np.zeros_like(NO_SECTION)
        vector[kernel.SECTION_CONTACT] = section.contact - 1
        if section.kind == "event":
            before, after = section.event.split("->")
            vector[kernel.SECTION_KIND] = kernel.SECTION_EVENT
            vector[kernel.SECTION_FROM] = KIND_NAMES[before]
            vector[kernel.SECTION_TO] = KIND_NAMES[after]
        elif section.kind == "zero":
            vector[kernel.SECTION_KIND] = kernel.SECTION_ZERO
            vector[kernel.SECTION_STATE] = self.system.state_names.index(section.state)
            vector[kernel.SECTION_DIRECTION] = DIRECTIONS[section.direction]
        else:
            vector[kernel.SECTION_KIND] = kernel.SECTION_PHASE
        return vector

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


@dataclass(frozen=True)
class Scratch:
    """What the motions of a system share: arrays written before they are read, or never."""

    series: Vector
    work: Vector
    stages: NDArray[np.float64]
    roots: Vector
    options: NDArray[np.int64]
    quadrature: NDArray[np.float64]
    unmeasured: Measures
    no_ledger: NDArray[np.float64]
    no_tangents: NDArray[np.float64]
    no_sections: tuple[Vector, NDArray[np.float64]]


@cache
def scratch_of(system: System) -> Scratch:
    """Scratch arrays of a system (one set a process: motions run one at a time)."""
    n, contacts, order = len(system.state_names), system.n_contacts, system.generated.order
    guards = system.tables.guards.shape[1]
    rows = 2 * n + 2 * guards + 2
    width = max(2 * n + guards + 1 + 3 * contacts + kernel.N_ENERGIES, 2 * n, order + 1)
    options = np.zeros((contacts, kernel.OPTIONS_WIDTH), np.int64)
    options[:, kernel.ONE_WAY] = system.generated.smooth
    return Scratch(
        series=np.zeros(rows * (order + 1)),
        work=np.zeros(rows * (order + 1)),
        stages=np.zeros((SCRATCH_ROWS, width)),
        roots=roots.scratch(),
        options=options,
        quadrature=gauss_nodes(order // 2 + 3),
        unmeasured=no_measures(system),
        no_ledger=np.zeros((0, 5)),
        no_tangents=np.zeros((0, n)),
        no_sections=(np.zeros(1), np.zeros((1, n))),
    )


def call(address: Any, coefficients: Vector, time: float, state: Vector, out: Vector) -> None:
    """Call a generated function from Python."""
    kernel.call_once(address, coefficients, time, state, out)


@cache
def gauss_nodes(count: int) -> NDArray[np.float64]:
    """Gauss-Legendre nodes and weights on [0, 1]; shape (count, 2)."""
    nodes, weights = np.polynomial.legendre.leggauss(count)
    return np.ascontiguousarray(np.stack([0.5 * (nodes + 1.0), 0.5 * weights], axis=1))


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
