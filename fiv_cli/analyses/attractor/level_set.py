"""Level sets of decay about a stable sliding equilibrium: what cannot leave ends there.

What is asked, and the numbers, are in ``grounds.py``.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cache, cached_property

import numpy as np
from numpy.typing import NDArray

from fiv_cli.analyses.attractor.grounds import HURWITZ, LINEAR, SAMPLES
from fiv_cli.analyses.rest.equilibria import Sliding
from fiv_cli.analyses.rest.linearisation import free_states
from fiv_cli.dynamics.system import System, Vector

Real = NDArray[np.float64]
Complex = NDArray[np.complex128]

DIFFERENCE = 1e-3  # step of a central difference, over the size of the equilibrium
UNSEEN = 1e-3  # weight of a mode that no switching function sees, over the largest weight
ROUNDING = 1e-12  # of rates, over those of the equilibrium's size, and far below LINEAR
PHASES = 4  # of an excitation, at which sliding is compared with that of the unexcited system
SAME = 1e-9  # ... to this share
TURNS = 64  # looks at each turn of an excitation that moves switching functions
SEED = 7411  # of the points of a level set that are looked at


@dataclass(frozen=True)
class LevelSet:
    """The neighbourhood of a stable sliding equilibrium in which sliding decays.

    Attributes
    ----------
    sliding : the unexcited system in sliding
    equilibrium : state vector, shape (n_states,)
    number : of the equilibrium among the solutions of the point, from 1
    eigenvalues : of sliding at it, 1/s; shape (n_free,)
    vectors, inverse : eigenvectors of the free states, as columns, and the inverse matrix
    lowered : by how much an excitation lowers each switching function at times
    """

    sliding: Sliding
    equilibrium: Vector
    number: int
    eigenvalues: Complex
    vectors: Complex
    inverse: Complex
    lowered: tuple[float, ...] = ()

    @cached_property
    def free(self) -> NDArray[np.intp]:
        """Places of the states that no rigid contact determines."""
        return free_states(self.sliding.system)

    @cached_property
    def period(self) -> float:
        """The longest natural period; the slowest decay time where nothing oscillates, s."""
        turning = np.abs(self.eigenvalues.imag)
        turning = turning[turning > 0.0]
        return float(2 * np.pi / np.min(turning)) if len(turning) else 1.0 / self.slowest

    @cached_property
    def slowest(self) -> float:
        """Rate of the slowest decay, 1/s."""
        return float(-np.max(self.eigenvalues.real))

    # --- the level --------------------------------------------------------------------------------
    @cached_property
    def shares(self) -> Real:
        """Share of each switching function that a unit amplitude of each mode can take.

        Shape (n_guards, n_free).
        """
        margins, slopes = self._guards
        return np.asarray(np.abs(slopes @ self.vectors) / margins[:, None], np.float64)

    @cached_property
    def _guards(self) -> tuple[Vector, Real]:
        """Switching functions at the equilibrium, and their slopes by the free states."""
        margins = self.sliding.field(self.equilibrium).switching
        margins = margins + self.lowered if self.lowered else margins
        m, size = len(self.sliding.system.coordinates), np.max(np.abs(self.equilibrium))
        steps = np.full(len(self.equilibrium), DIFFERENCE * (size if size > 0.0 else 1.0))
        steps[m : 2 * m] *= np.max(np.abs(self.eigenvalues))
        moved = np.tile(self.equilibrium, (2, len(self.free), 1))
        for column, place in enumerate(self.free):
            moved[:, column, place] += (steps[place], -steps[place])
        shares = self.sliding.field(moved).switching / (2.0 * steps[self.free])[:, None]
        return margins, np.ascontiguousarray((shares[0] - shares[1]).T)

    @cached_property
    def is_bounded(self) -> bool:
        """Whether some switching function limits the level set."""
        return bool(np.any(self.shares > 0.0))

    @property
    def holds(self) -> bool:
        """Whether the equilibrium itself is on no switching surface."""
        return bool(np.all(self._guards[0] > 0.0))

    def amplitudes(self, state: Vector) -> Vector:
        """Modal amplitudes of the distance from the equilibrium; shape (n_free,)."""
        return np.asarray(np.abs(self.inverse @ (state - self.equilibrium)[self.free]), np.float64)

    def level(self, amplitudes: Vector) -> float:
        """V over c: below 1 no switching surface is met."""
        return float(np.max(self.shares @ amplitudes, initial=0.0))

    @cached_property
    def weights(self) -> Vector:
        """By which amplitudes of modes are compared; shape (n_free,)."""
        seen = np.max(self.shares, axis=0, initial=0.0)
        largest = np.max(seen, initial=0.0)
        return np.maximum(seen, UNSEEN * largest) if largest > 0.0 else np.ones(len(seen))

    # --- is sliding linear there? -----------------------------------------------------------------
    def nonlinearity(self, amplitudes: Vector) -> float:
        """Largest nonlinear part of the rates over the slowest decay, on the level set.

        Looked at in `SAMPLES` points with the weighted sum of `amplitudes`: one mode after the
        other large, at every phase.
        """
        reach = max(float(self.weights @ amplitudes), self._rounding)
        states = np.repeat(self.equilibrium[None, :], SAMPLES, axis=0)
        states[:, self.free] += reach * self.shapes
        rates = self.sliding.rates(states)[:, self.free]
        modal, sizes = self._modal_shapes
        bent = np.abs(self.inverse @ rates.T - reach * self.eigenvalues[:, None] * modal)
        norms = np.linalg.norm(self.weights[:, None] * bent, axis=0)
        return float(np.max(norms / (reach * sizes))) / self.slowest

    @cached_property
    def _rounding(self) -> float:
        """Weighted amplitude below which rounding of the rates passes for their nonlinear part."""
        whole = self.weights @ np.abs(self.inverse @ self.equilibrium[self.free])
        return float(ROUNDING * whole * np.max(np.abs(self.eigenvalues)) / self.slowest)

    @cached_property
    def _modal_shapes(self) -> tuple[Complex, Vector]:
        """Modal amplitudes of `shapes`, as columns, and their weighted sizes."""
        modal = self.inverse @ self.shapes.T
        return modal, np.linalg.norm(self.weights[:, None] * np.abs(modal), axis=0)

    @cached_property
    def shapes(self) -> Real:
        """Distances from the equilibrium whose weighted amplitudes sum to one."""
        sizes, phases = _drawn(len(self.eigenvalues))
        away = (sizes / self.weights * phases @ self.vectors.T).real
        return np.asarray(away / (np.abs(away @ self.inverse.T) @ self.weights)[:, None])

    def margin(self, state: Vector) -> float:
        """1 - V/c where sliding from `state` is linear and meets nothing; NaN where it is not."""
        amplitudes = self.amplitudes(state)
        level = self.level(amplitudes)
        if not level < 1.0:
            return float("nan")
        bent = self.nonlinearity(amplitudes) if np.any(amplitudes > 0.0) else 0.0
        left = 1.0 - level - len(amplitudes) * bent
        return 1.0 - level if bent <= LINEAR and left > 0.0 else float("nan")


@cache
def _drawn(modes: int) -> tuple[Real, Complex]:
    """Sizes of modes, one after the other large, and their phases; shape (SAMPLES, modes)."""
    random = np.random.default_rng(SEED)
    sizes, phases = np.zeros((SAMPLES, modes)), np.zeros((SAMPLES, modes), complex)
    for row in range(SAMPLES):
        sizes[row] = random.exponential(size=modes) ** 3
        phases[row] = np.exp(2j * np.pi * random.random(modes))
    return sizes, phases


def level_set(
    sliding: Sliding, equilibrium: Vector, jacobian: Real, number: int
) -> LevelSet | None:
    """The level sets about an equilibrium; None where it is not stable, or on a border.

    Parameters
    ----------
    jacobian : of the free states, shape (n_free, n_free), 1/s
    number : of the equilibrium among the solutions, from 1
    """
    values, vectors = np.linalg.eig(jacobian)
    if np.max(values.real) >= -HURWITZ * np.max(np.abs(values)):
        return None
    try:
        inverse = np.linalg.inv(vectors)
    except np.linalg.LinAlgError:
        return None
    levels = LevelSet(
        sliding, equilibrium, number, values.astype(complex), vectors.astype(complex),
        inverse.astype(complex),
    )  # fmt: skip
    return levels if levels.holds else None


def under_excitation(
    system: System, parameters: Mapping[str, float], target: LevelSet
) -> LevelSet | None:
    """The level sets where an excitation leaves sliding alone: a sector with the same kinetic
    friction does, and a drive whose speed varies. None where it does not.

    The rates of the excited system are those of the unexcited one at every phase and on either
    side of a sector's border; switching functions may move as a whole, and the least counts.
    """
    known = system.known(parameters)
    period = system.setup.model.excitation_period(known)
    if period is None:
        return target
    fastest = system.setup.model.fastest(known)
    turns = TURNS * max(1, round(period * fastest / (2 * np.pi)))
    moved = _all_moved(system, parameters, target, np.arange(PHASES) * period / PHASES)
    if moved is None or not np.any(moved):
        return None if moved is None else target
    moved = _all_moved(system, parameters, target, np.arange(turns) * period / turns)
    if moved is None:
        return None
    least, greatest = np.min(moved, axis=0), np.max(moved, axis=0)
    between = (greatest - least) * (np.pi / TURNS) ** 2  # what a harmonic may be below its samples
    lowered = replace(target, lowered=tuple(np.minimum(least - between, 0.0).tolist()))
    return lowered if lowered.holds else None


def _all_moved(
    system: System, parameters: Mapping[str, float], target: LevelSet, times: Vector
) -> Real | None:
    """By how much switching functions are moved, at these times on either side of a border."""
    motion_parameters = system.parameter_vector(parameters)
    own = target.sliding.parameters
    motion_parameters[-1 - system.n_contacts : -1] = own[-1 - system.n_contacts : -1]
    states = np.stack([target.equilibrium, target.equilibrium])
    states[1][target.free] += np.max(np.abs(target.equilibrium)) * target.shapes[0]
    moved = []
    for zone in (0.0, 1.0):
        motion_parameters[-1] = zone
        coefficients = system.coefficients(motion_parameters)
        for time in times.tolist():
            found = _moved(target, coefficients, time, states)
            if found is None:
                return None
            moved.append(found)
    return np.array(moved)


def _moved(target: LevelSet, coefficients: Vector, time: float, states: Real) -> Vector | None:
    """By how much an excitation moves the switching functions; None where it moves the rates too,
    or does not move them alike in all states."""
    sliding = target.sliding
    found = sliding.system.field(sliding.index, coefficients, time, states)
    still = sliding.field(states)
    scale = np.max(np.abs(still.rates), axis=-1, keepdims=True)
    if np.any(np.max(np.abs(found.rates - still.rates), axis=-1, keepdims=True) > SAME * scale):
        return None
    by = found.switching - still.switching
    if np.any(np.abs(by[1] - by[0]) > SAME * np.max(np.abs(still.switching))):
        return None
    return np.where(np.abs(by[0]) > SAME * np.abs(still.switching[0]), by[0], 0.0)
