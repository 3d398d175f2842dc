"""Level sets of decay about a stable sliding equilibrium: what cannot leave ends there.

What is asked, and the numbers, are in ``grounds.py``.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, fields, replace
from functools import cache, cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fiv_cli.analyses.attractor.grounds import HURWITZ, LINEAR, SAMPLES
from fiv_cli.analyses.rest.equilibria import Sliding
from fiv_cli.analyses.rest.linearisation import free_jacobian, free_states, inverted
from fiv_cli.dynamics.motion import Motion
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

    At one equilibrium or, in rows, at several.

    Attributes
    ----------
    sliding : the unexcited system in sliding
    equilibrium : state vector, shape (..., n_states)
    number : of the equilibrium among the solutions of the point, from 1; shape (...)
    eigenvalues : of sliding at it, 1/s; shape (..., n_free)
    vectors, inverse : eigenvectors of the free states, as columns, and the inverse matrix
    shares : share of each switching function that a unit amplitude of each mode can take; shape
        (..., n_guards, n_free)
    weights : by which amplitudes of modes are compared; shape (..., n_free)
    shapes : distances from the equilibrium whose weighted amplitudes sum to one; shape (...,
        SAMPLES, n_free)
    straight : rates of their modal amplitudes where sliding is linear, likewise
    shape_sizes : weighted sizes of their modal amplitudes; shape (..., SAMPLES)
    slowest : rate of the slowest decay, 1/s; shape (...)
    period : the longest natural period; the slowest decay time where nothing oscillates, s
    rounding : weighted amplitude below which rounding of the rates passes for their nonlinear part
    asked, answer : a state whose `margin` is known
    """

    sliding: Sliding
    equilibrium: Vector
    number: NDArray[np.intp]
    eigenvalues: Complex
    vectors: Complex
    inverse: Complex
    shares: Real
    weights: Vector
    shapes: Real
    straight: Complex
    shape_sizes: Vector
    slowest: Vector
    period: Vector
    rounding: Vector
    asked: Vector
    answer: Vector

    @cached_property
    def free(self) -> NDArray[np.intp]:
        """Places of the states that no rigid contact determines."""
        return free_states(self.sliding.system)

    @property
    def keeps(self) -> bool:
        """Whether springs hold it: where a slide ends depends on where it begins."""
        return bool(self.sliding.held)

    def where_it_ends(self, state: Vector) -> tuple[LevelSet, float] | None:
        """The level sets about the place where a slide from a state ends, and its margin there."""
        kept = self.eigenvalues == 0.0
        amplitudes = self.inverse @ (state - self.equilibrium)[self.free]
        rest, here = self.equilibrium.copy()[None], self.sliding[None]
        rest[0, self.free] += (self.vectors[:, kept] @ amplitudes[kept]).real
        rows, found = level_sets(here, rest, free_jacobian(here, rest), self.number[None])
        return (found[0], float(found.margins(state[None])[0])) if len(rows) > 0 else None

    # --- the level --------------------------------------------------------------------------------
    @property
    def is_bounded(self) -> NDArray[np.bool_]:
        """Whether some switching function limits the level set."""
        return np.asarray((self.shares > 0.0).any(axis=(-2, -1)))

    def amplitudes(self, state: Vector) -> Vector:
        """Modal amplitudes of the distance from the equilibrium; shape (..., n_free)."""
        return np.abs(_times(self.inverse, (state - self.equilibrium)[..., self.free]))

    def level(self, amplitudes: Vector) -> Vector:
        """V over c: below 1 no switching surface is met."""
        return np.asarray(np.max(_times(self.shares, amplitudes), axis=-1, initial=0.0))

    # --- is sliding linear there? -----------------------------------------------------------------
    def nonlinearity(self, amplitudes: Vector) -> Vector:
        """Largest nonlinear part of the rates over the slowest decay, on the level set.

        Looked at in `SAMPLES` points with the weighted sum of `amplitudes`: one mode after the
        other large, at every phase.
        """
        reach = np.maximum(np.sum(self.weights * amplitudes, axis=-1), self.rounding)[..., None]
        states = np.repeat(self.equilibrium[..., None, :], SAMPLES, axis=-2)
        states[..., self.free] += reach[..., None] * self.shapes
        rates = self.sliding.rates(states)[..., self.free].swapaxes(-1, -2)
        straight = self.straight.swapaxes(-1, -2)
        bent = np.abs(self.inverse @ rates - reach[..., None] * straight)
        norms = np.linalg.norm(self.weights[..., None] * bent, axis=-2)
        return np.asarray(np.max(norms / (reach * self.shape_sizes), axis=-1) / self.slowest)

    def margins(self, states: NDArray[np.float64]) -> Vector:
        """1 - V/c where sliding from a state is linear and meets nothing; NaN where it is not."""
        amplitudes = self.amplitudes(states)
        levels, found = self.level(amplitudes), np.full(len(states), np.nan)
        near = np.flatnonzero(levels < 1.0)
        if len(near) > 0:
            there = self if len(near) == len(states) else self[near]
            amplitudes, levels = amplitudes[near], levels[near]
            bent = np.where(amplitudes.any(axis=-1), there.nonlinearity(amplitudes), 0.0)
            left = 1.0 - levels - amplitudes.shape[-1] * bent
            found[near] = np.where((bent <= LINEAR) & (left > 0.0), 1.0 - levels, np.nan)
        return found

    def asked_of(self, states: NDArray[np.float64]) -> LevelSet:
        """The same; the margins of these states are known."""
        return replace(self, asked=states, answer=self.margins(states))

    def __getitem__(self, rows: Any) -> LevelSet:
        """About some of the equilibria."""
        return LevelSet(*(getattr(self, name)[rows] for name in FIELDS))


FIELDS = tuple(field.name for field in fields(LevelSet))


def _times(matrix: NDArray[Any], vector: NDArray[Any]) -> NDArray[Any]:
    """The product, row by row."""
    return (matrix @ vector[..., None])[..., 0]


@cache
def _drawn(modes: int) -> tuple[Real, Complex]:
    """Sizes of modes, one after the other large, and their phases; shape (SAMPLES, modes)."""
    random = np.random.default_rng(SEED)
    sizes, phases = np.zeros((SAMPLES, modes)), np.zeros((SAMPLES, modes), complex)
    for row in range(SAMPLES):
        sizes[row] = random.exponential(size=modes) ** 3
        phases[row] = np.exp(2j * np.pi * random.random(modes))
    return sizes, phases


def level_sets(
    sliding: Sliding, equilibria: Vector, jacobians: Real, numbers: NDArray[np.intp]
) -> tuple[NDArray[np.intp], LevelSet]:
    """The level sets about equilibria, in rows: which have some, and these.

    One that is not stable, or on a border, has none. Modes of springs that hold, which neither grow
    nor decay, have the eigenvalue zero.

    Parameters
    ----------
    jacobians : of the free states, shape (rows, n_free, n_free), 1/s
    numbers : of the equilibria among the solutions of their points, from 1
    """
    values, vectors = np.linalg.eig(jacobians)
    speeds = np.max(np.abs(values), axis=-1)
    growths = values.real
    if sliding.held.any():
        kept = sliding.held[:, None] & (np.abs(values) <= HURWITZ * speeds[:, None])
        values, growths = np.where(kept, 0.0, values), np.where(kept, -np.inf, growths)
        for row in np.flatnonzero(sliding.held):  # of several zeros `eig` has one vector
            last = np.linalg.svd(jacobians[row])[2][np.count_nonzero(~kept[row]) :]
            vectors[row][:, kept[row]] = last.T
    stable = np.max(growths, axis=-1) < -HURWITZ * speeds
    inverses = _inverses(values, vectors)
    stable &= ~np.isnan(inverses).any(axis=(1, 2))
    margins, slopes = _guards(sliding, equilibria, speeds)
    rows = np.flatnonzero(stable & (margins > 0.0).all(axis=-1))
    values, vectors = values[rows].astype(complex), vectors[rows].astype(complex)
    inverses, shares = inverses[rows], np.abs(slopes[rows] @ vectors) / margins[rows, :, None]
    weights, unknown = _weights(shares), np.full(len(rows), np.nan)
    shapes = _shapes(vectors, inverses, weights)
    modal = shapes @ inverses.swapaxes(-1, -2)
    sizes = np.linalg.norm(weights[:, None] * np.abs(modal), axis=-1)
    slowest = -np.max(np.where(values == 0.0, -np.inf, values.real), axis=-1)
    whole = np.abs(_times(inverses, equilibria[rows][:, free_states(sliding.system)]))
    rounding = ROUNDING * np.sum(weights * whole, axis=-1) * speeds[rows] / slowest
    return rows, LevelSet(
        sliding[rows], equilibria[rows], numbers[rows], values, vectors, inverses, shares,
        weights, shapes, values[:, None] * modal, sizes, slowest, _periods(values, slowest),
        np.maximum(rounding, np.finfo(float).tiny), unknown[:, None], unknown,
    )  # fmt: skip


def undamped_level(
    sliding: Sliding, equilibria: Vector, jacobians: Real, states: Vector
) -> NDArray[np.float64]:
    """V over c of slides whose modes neither grow nor decay, in rows, or all of one equilibrium.

    Below 1 such a slide meets no switching surface, ever; above it may, and sooner or later does
    where its frequencies have no common period.

    Parameters
    ----------
    jacobians : of the free states, shape (rows, n_free, n_free), 1/s
    states : of the slides, shape (rows, n_states)
    """
    values, vectors = np.linalg.eig(jacobians)
    margins, slopes = _guards(sliding, equilibria, np.max(np.abs(values), axis=-1))
    away = (states - equilibria)[:, free_states(sliding.system)]
    amplitudes = np.abs(_times(_inverses(values, vectors), away))
    reached = _times(np.abs(slopes @ vectors), amplitudes)
    return np.asarray(np.max(reached / margins, axis=-1, initial=0.0))


def _periods(values: Complex, slowest: Vector) -> Vector:
    turning = np.abs(values.imag)
    least = np.min(turning, axis=-1, where=turning > 0.0, initial=np.inf)
    return np.where(least < np.inf, 2 * np.pi / least, 1.0 / slowest)


def _weights(shares: Real) -> Vector:
    seen = np.max(shares, axis=-2, initial=0.0)
    largest = np.max(seen, axis=-1, keepdims=True, initial=0.0)
    return np.where(largest > 0.0, np.maximum(seen, UNSEEN * largest), 1.0)


def _shapes(vectors: Complex, inverses: Complex, weights: Vector) -> Real:
    sizes, phases = _drawn(vectors.shape[-1])
    drawn = sizes / weights[:, None] * phases
    away = (drawn @ vectors.swapaxes(-1, -2)).real
    amplitudes = np.abs(away @ inverses.swapaxes(-1, -2))
    return np.asarray(away / np.sum(amplitudes * weights[:, None], axis=-1, keepdims=True))


def _inverses(values: Complex, vectors: Complex) -> Complex:
    """Inverse matrices of eigenvectors, of real ones by real numbers; NaN where there are none."""
    found = np.empty(vectors.shape, complex)
    real = (values.imag == 0.0).all(axis=-1)
    found[real], found[~real] = inverted(vectors[real].real), inverted(vectors[~real])
    return found


def _guards(sliding: Sliding, equilibria: Vector, speeds: Vector) -> tuple[Vector, Real]:
    """Switching functions at equilibria, and their slopes by the free states.

    Parameters
    ----------
    speeds : largest eigenvalue at each, 1/s
    """
    free, m = free_states(sliding.system), len(sliding.system.coordinates)
    sizes = np.max(np.abs(equilibria), axis=-1, keepdims=True)
    steps = np.repeat(DIFFERENCE * np.where(sizes > 0.0, sizes, 1.0), equilibria.shape[-1], axis=1)
    steps[:, m : 2 * m] *= speeds[:, None]
    columns, away = np.arange(len(free)), steps[:, free]
    moved = np.tile(equilibria[:, None, None, :], (1, 2, len(free), 1))
    moved[:, 0, columns, free] += away
    moved[:, 1, columns, free] -= away
    shares = sliding.field(moved).switching / (2.0 * away)[:, None, :, None]
    slopes = (shares[:, 0] - shares[:, 1]).swapaxes(-1, -2)
    return sliding.field(equilibria).switching, np.ascontiguousarray(slopes)


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
    moved = _all_moved(system, parameters, target, np.arange(PHASES) * period / PHASES)
    if moved is None or not np.any(moved):
        return None if moved is None else target
    moved = _all_moved(system, parameters, target, _phases(system, known, period))
    if moved is None:
        return None
    at_rest = target.sliding.field(target.equilibrium).switching
    lowest = at_rest + np.minimum(_least(moved), 0.0)
    if np.any(lowest <= 0.0):
        return None
    shares = target.shares * (at_rest / lowest)[:, None]
    return replace(target, shares=shares, asked=np.full_like(target.asked, np.nan))


def holds_through(motion: Motion, parameters: Mapping[str, float]) -> bool:
    """Whether a motion that stands still in stick does so at every phase of an excitation."""
    system, index = motion.system, motion.state_index
    known = system.known(parameters)
    period = system.setup.model.excitation_period(known)
    assert period is not None
    guards = []
    for phase in _phases(system, known, period).tolist():
        found = system.field(index, motion.coefficients, phase, motion.y)
        if np.any(found.rates != 0.0):
            return False
        guards.append(found.switching)
    return bool(np.all(_least(np.array(guards)) > 0.0))


def _phases(system: System, known: Mapping[str, float], period: float) -> Vector:
    """Instants of a period, `TURNS` of each turn of the fastest excitation."""
    fastest = system.setup.model.fastest(known)
    turns = TURNS * max(1, round(period * fastest / (2 * np.pi)))
    return np.arange(turns) * period / turns


def _least(sampled: Real) -> Vector:
    """What a harmonic that is sampled so may come down to, of each column."""
    least, greatest = np.min(sampled, axis=0), np.max(sampled, axis=0)
    return np.asarray(least - (greatest - least) * (np.pi / TURNS) ** 2)


def _all_moved(
    system: System, parameters: Mapping[str, float], target: LevelSet, times: Vector
) -> Real | None:
    """By how much switching functions are moved, at these times on either side of a border."""
    motion_parameters = system.parameter_vector(parameters)
    own = target.sliding.parameters
    motion_parameters[-1 - system.n_contacts : -1] = own[-1 - system.n_contacts : -1]
    states = np.stack([target.equilibrium, target.equilibrium])
    states[1][target.free] += np.max(np.abs(target.equilibrium)) * target.shapes[0]
    _, width, _ = system.generated.zone or ("", "", 0)
    has_sector = bool(width) and parameters[width] != 0.0
    moved = []
    for zone in (0.0, 1.0) if has_sector else (0.0,):
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
