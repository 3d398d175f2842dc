"""What several analyses need: sliding equilibria, linearisation, starts, energy balance."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fiv_cli.analyses.base import Outcome, SolverSettings, Start
from fiv_cli.dynamics import kernel
from fiv_cli.dynamics.motion import STOP_REASONS, Motion, Stop, call
from fiv_cli.dynamics.system import System, Vector

NEWTON_STEPS = 60
CONVERGED = 1e-13  # last Newton step, relative to the solution
SAME_SOLUTION = 1e-8
# Newton starts, as multiples of the first solution: other real solutions of the spring forces.
SPREAD = (-30.0, -10.0, -3.0, -1.0, -0.3, 0.3, 3.0, 10.0, 30.0)


@dataclass(frozen=True)
class Sliding:
    """The unexcited system, sliding in the direction that the drive imposes at rest.

    Attributes
    ----------
    system : the compiled system
    parameters : parameter vector with slip signs
    coefficients : generated coefficients
    index : contact state "all slip"
    moving : whether every contact has slip velocity at rest, as a sliding equilibrium needs
    """

    system: System
    parameters: Vector
    coefficients: Vector
    index: int
    moving: bool

    def field(self, y: Vector) -> Vector:
        """Field output at y (see kernel.py)."""
        n_outputs = 3 * len(y) + 64
        out = np.zeros(n_outputs + kernel.N_ENERGIES)
        address = self.system.tables.table[self.index, kernel.FIELD]
        call(address, self.coefficients, 0.0, y, out)
        return out

    def rates(self, y: Vector) -> Vector:
        """dy/dt; shape (n_states,)."""
        n = len(y)
        return self.field(y)[n : 2 * n]

    def contact_forces(self, y: Vector) -> NDArray[np.float64]:
        """(F_N, F_T, v_rel) per contact; shape (n_contacts, 3)."""
        first = kernel.contact_outputs(self.system.tables.table, self.index, len(y))
        count = self.system.n_contacts
        return self.field(y)[first : first + 3 * count].reshape(count, 3)

    def jacobian(self, y: Vector) -> NDArray[np.float64]:
        """Exact derivative of `rates` (by differentiated code); shape (n, n)."""
        n, order = len(y), self.system.generated.order
        address = self.system.tangent_table[self.index, kernel.TANGENT]
        rows = 2 * n + 2 * (self.system.tables.guards.shape[1] + 1)
        series = np.zeros(rows * (order + 1))
        matrix = np.zeros((n, n))
        for column in range(n):
            joined = np.concatenate([y, np.eye(n)[column]])
            call(address, self.coefficients, 0.0, joined, series)
            matrix[:, column] = series[n * (order + 1) : 2 * n * (order + 1)].reshape(n, -1)[:, 1]
        return matrix


def sliding(system: System, parameters: Mapping[str, float]) -> Sliding:
    """The unexcited system in sliding."""
    vector = system.parameter_vector(system.model.unexcited(parameters))
    coefficients = np.zeros(max(system.generated.n_coefficients, 1))
    fill = system.tables.config[kernel.COEFFICIENTS]
    call(fill, coefficients, 0.0, vector, coefficients)
    state = Sliding(system, vector, coefficients, 0, True)
    velocities = state.contact_forces(np.zeros(len(system.state_names)))[:, 2]
    first = len(vector) - 1 - system.n_contacts
    vector[first : first + system.n_contacts] = np.where(velocities < 0.0, -1.0, 1.0)
    call(fill, coefficients, 0.0, vector, coefficients)
    smooth = np.array(system.generated.smooth)
    moving = bool(np.all((velocities != 0.0) | smooth))
    return Sliding(system, vector, coefficients, 0, moving)


def equilibria(state: Sliding) -> list[Vector]:
    """Sliding equilibria with closed contacts, by Newton from a fixed set of starts.

    Each is a state vector with zero velocities; the first is the one reached from zero.
    """
    if not state.moving:
        return []
    n = len(state.system.state_names)
    found: list[Vector] = []
    first = _newton(state, np.zeros(n))
    if first is not None:
        found.append(first)
        for factor in SPREAD:
            other = _newton(state, factor * first)
            if other is not None and _is_new(other, found):
                found.append(other)
    return [y for y in found if np.all(state.contact_forces(y)[:, 0] >= 0.0)]


def _newton(state: Sliding, start: Vector) -> Vector | None:
    """Root of the accelerations at zero velocity; None when Newton does not converge."""
    m = len(state.system.coordinates)
    y = start.copy()
    for _ in range(NEWTON_STEPS):
        matrix = state.jacobian(y)[m : 2 * m, :m]
        try:
            step = np.linalg.solve(matrix, state.rates(y)[m : 2 * m])
        except np.linalg.LinAlgError:
            return None
        y[:m] -= step
        if not np.all(np.isfinite(y)):
            return None
        if np.max(np.abs(step)) <= CONVERGED * np.max(np.abs(y), initial=1e-300):
            return y
    return None


def _is_new(candidate: Vector, found: list[Vector]) -> bool:
    scale = max(np.max(np.abs(candidate), initial=0.0), 1e-300)
    return all(np.max(np.abs(candidate - known)) > SAME_SOLUTION * scale for known in found)


def start_motion(
    system: System,
    parameters: Mapping[str, float],
    start: Start,
    solver: SolverSettings,
    equilibrium: Vector | None,
) -> Motion | Outcome:
    """The motion that `start` describes, or the outcome that says why there is none."""
    if start.kind == "continue" and start.carried is not None:
        return _continued(system, parameters, start, solver, equilibrium)
    if start.kind == "state":
        return Motion(system, parameters, solver, start.values)
    if equilibrium is None:
        return Outcome(status="failed", reason="no_equilibrium")
    return Motion(system, parameters, solver, _offset(system, equilibrium, start.values))


def _continued(
    system: System,
    parameters: Mapping[str, float],
    start: Start,
    solver: SolverSettings,
    equilibrium: Vector | None,
) -> Motion | Outcome:
    carried = start.carried
    assert carried is not None
    if carried["attractor"] == "equilibrium":
        if equilibrium is None:
            return Outcome(status="failed", reason="no_equilibrium")
        return Motion(system, parameters, solver, _offset(system, equilibrium, start.values))
    sticking = tuple(bool(s) for s in carried["sticking"])
    state = np.array(carried["state"], dtype=float)
    return Motion(system, parameters, solver, state, sticking=sticking)


def _offset(system: System, equilibrium: Vector, values: Mapping[str, float]) -> Vector:
    return equilibrium + system.state_vector(values)


def stopped(stop: Stop) -> Outcome | None:
    """The outcome of a motion that could not go on; None when it could."""
    reason = STOP_REASONS.get(stop)
    if reason is None:
        return None
    if stop in (Stop.STEP_BUDGET, Stop.EVENT_BUDGET):
        return Outcome(status="budget", reason=reason)
    if stop in (Stop.DIVERGED, Stop.CONTACT_LOST):
        return Outcome(reason=reason)
    return Outcome(status="failed", reason=reason)


@dataclass(frozen=True)
class Balance:
    """Energy balance over a measured stretch, J."""

    kinetic_potential_before: float
    kinetic_potential_after: float
    other: float
    friction: float
    drive: float
    impact: float

    @property
    def residual(self) -> float:
        """What the balance leaves over, relative to its largest term."""
        change = self.kinetic_potential_after - self.kinetic_potential_before
        terms = (
            self.kinetic_potential_before,
            self.kinetic_potential_after,
            self.other,
            self.friction,
            self.drive,
            self.impact,
        )
        largest = max(abs(term) for term in terms)
        rest = change - self.other - self.friction + self.impact
        return abs(rest) / largest if largest > 0.0 else 0.0


def balance(motion: Motion, energy_before: float) -> Balance:
    """Energy balance of what `motion` has measured."""
    totals = motion.measures.totals
    return Balance(
        energy_before,
        motion.energy(),
        float(totals[kernel.M_OTHER]),
        float(totals[kernel.M_FRICTION]),
        float(totals[kernel.M_DRIVE]),
        float(totals[kernel.M_IMPACT]),
    )


def trust(motion: Motion) -> dict[str, float]:
    """The variables that say how far a run can be trusted, without the energy balance."""
    return {
        "event_residual": float(motion.measures.totals[kernel.M_RESIDUAL]),
        "n_steps": motion.n_steps,
        "n_events": motion.n_events,
    }
