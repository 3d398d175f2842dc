"""The system linearised at a sliding equilibrium, and its eigenvalues (thesis 3.33-3.37, 5.15)."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cache

import numpy as np
from numpy.typing import NDArray

from fiv_cli.analyses.base import Outcome, Settings, SolverSettings
from fiv_cli.analyses.rest.averaging import LEAST_RATIO, averaged_sliding, frequency_ratio
from fiv_cli.analyses.rest.equilibria import Sliding, all_equilibria, free_coordinates, sliding
from fiv_cli.dynamics.system import System, Vector

Real = NDArray[np.float64]
Complex = NDArray[np.complex128]

COUPLED = 1e-3  # relative distance of the frequencies of two coupled modes
NEUTRAL = 1e-14  # growth rates below this share of the largest eigenvalue are rounding
SURE = 1e-6  # a correction of an eigenvalue beyond this share of it is not one


def sliding_system(system: System, parameters: Mapping[str, float], which: str) -> Sliding:
    """The ``original`` system without its excitation, or the one ``averaged`` over it."""
    if which == "averaged":
        return averaged_sliding(system, parameters)
    return sliding(system, parameters)


def eigenvalues_at(
    system: System,
    parameters: Mapping[str, float],
    start: None,
    settings: Settings,
    solver: SolverSettings,
) -> Outcome:
    """Eigenvalues (rad/s) and vectors at the equilibrium asked for, by rising frequency."""
    which, number = settings["system"], settings["at_equilibrium"]
    state = sliding_system(system, parameters, which)
    found = all_equilibria(state)
    if len(found.states) < number:
        return Outcome(status="failed", reason=found.reason or "no_equilibrium")
    at = found.states[number - 1]
    values = _described(*modes_at(state, at))
    if which == "original":
        return Outcome(values=values)
    ratio = frequency_ratio(system, parameters, free_jacobian(state, at))
    reason = "" if ratio >= LEAST_RATIO else "averaging_invalid"
    return Outcome(reason=reason, values={**values, "averaging_ratio": ratio})


def _described(values: Complex, vectors: Complex) -> dict[str, object]:
    """The variables that describe a spectrum."""
    magnitude = np.abs(values)
    ratio = np.where(magnitude > 0.0, -values.real / np.where(magnitude > 0.0, magnitude, 1.0), 0.0)
    return {
        "eigenvalue_real": values.real,
        "eigenvalue_imag": values.imag,
        "mode_frequency": np.abs(values.imag) / (2.0 * np.pi),
        "damping_ratio": ratio,
        "eigenvector_real": vectors.real.T,
        "eigenvector_imag": vectors.imag.T,
        "coupled_with": coupled_modes(values),
        "growth_rate": float(np.max(values.real)),
        "stable": stability(values),
    }


def modes_at(state: Sliding, y: Vector) -> tuple[Complex, Complex]:
    """Eigenvalues and vectors (columns, over all states) of the system linearised at `y`.

    What a closed rigid contact determines is no freedom of its own: it has no eigenvalues, and
    follows in the vectors.
    """
    values, free_vectors = spectrum(free_jacobian(state, y))
    free = free_states(state.system)
    if len(free) == len(y):
        return values, free_vectors
    m = len(state.system.coordinates)
    determined = np.setdiff1d(np.arange(m), free)
    vectors = np.zeros((len(y), len(values)), complex)
    vectors[free] = free_vectors
    vectors[m + determined] = state.jacobian(y)[np.ix_(determined, free)] @ free_vectors
    moving = values != 0.0
    vectors[np.ix_(determined, moving)] = vectors[m + determined][:, moving] / values[moving]
    return values, _normalised(vectors)


def free_jacobian(state: Sliding, y: Vector) -> Real:
    """Derivative of the rates of `free_states` by these; shape (free states, free states)."""
    free = free_states(state.system)
    if len(free) == len(y):
        return np.ascontiguousarray(state.jacobian(y))
    return state.jacobian(y)[np.ix_(free, free)]


@cache
def free_states(system: System) -> NDArray[np.intp]:
    """Places of the states that no rigid contact determines: coordinates, then velocities, ..."""
    m, n = len(system.coordinates), len(system.state_names)
    coordinates = np.array(free_coordinates(system), dtype=np.intp)
    return np.concatenate([coordinates, m + coordinates, np.arange(2 * m, n)])


def spectrum(jacobian: Real) -> tuple[Complex, Complex]:
    """Eigenvalues by rising frequency (a pair: positive imaginary part first) and vectors.

    Vectors are columns, of unit length, their largest entry real and positive. The real parts
    are exact zeros where there is no damping, and have few digits less than the frequencies
    where damping is weak.
    """
    mechanical = _is_mechanical(jacobian)
    undamped = mechanical and not jacobian[len(jacobian) // 2 :, len(jacobian) // 2 :].any()
    values, vectors = _undamped(jacobian) if undamped else _damped(jacobian, mechanical)
    order = np.lexsort((-values.imag, values.real, np.round(np.abs(values.imag), 12)))
    return values[order], _normalised(vectors[:, order])


def _normalised(vectors: Complex) -> Complex:
    """Columns of unit length whose largest entry is real and positive."""
    largest = vectors[np.argmax(np.abs(vectors), axis=0), np.arange(vectors.shape[1])]
    unit: Complex = vectors * (np.abs(largest) / largest) / np.linalg.norm(vectors, axis=0)
    return unit


def _is_mechanical(jacobian: Real) -> bool:
    """Whether the state is coordinates and their velocities, and nothing else."""
    m = len(jacobian) // 2
    return 2 * m == len(jacobian) and bool((jacobian[:m] == _velocities(m)).all())


@cache
def _velocities(m: int) -> Real:
    """Derivative of the rates of m coordinates, which are their velocities, by both."""
    return np.hstack([np.zeros((m, m)), np.eye(m)])


def _undamped(jacobian: Real) -> tuple[Complex, Complex]:
    """From the squares of the eigenvalues, which are those of the stiffness: real while stable."""
    m = len(jacobian) // 2
    squares, shapes = np.linalg.eig(jacobian[m:, :m])
    roots: Complex = np.sqrt(squares.astype(complex))
    values: Complex = np.concatenate([roots, -roots])
    values += 0.0  # no negative zeros
    vectors = np.tile(shapes.astype(complex), 2)
    return values, np.vstack([vectors, values * vectors])


def _damped(jacobian: Real, mechanical: bool) -> tuple[Complex, Complex]:
    values, vectors = np.linalg.eig(jacobian)
    values, vectors = values.astype(complex), vectors.astype(complex)
    if mechanical:
        values = _corrected(values, _correction(jacobian, values, vectors))
    return values, vectors


def _corrected(values: Complex, steps: Complex) -> Complex:
    """Real eigenvalues stay real; pairs, which stand side by side, conjugate to the last bit."""
    corrected = values + np.where(values.imag == 0.0, steps.real, steps)
    upper = np.flatnonzero(values.imag > 0.0)
    corrected[upper + 1] = corrected[upper].conj()
    return corrected


def _correction(jacobian: Real, values: Complex, vectors: Complex) -> Complex:
    """One step of the two-sided Rayleigh quotient of ``s^2 + s C + K``.

    The eigenvalues of the matrix have an error of rounding of the *frequencies*; here the terms
    that decide the real parts, as small as the damping, are summed on their own. Nothing is
    corrected where two modes all but coincide.
    """
    m = len(values) // 2
    stiffness, damping = -jacobian[m:, :m], -jacobian[m:, m:]
    try:
        left = np.linalg.inv(vectors)[:, m:]
    except np.linalg.LinAlgError:
        return np.zeros_like(values)
    shapes = vectors[:m]
    residual = shapes * values**2 + (damping @ shapes) * values + stiffness @ shapes
    step = -np.einsum("im,mi->i", left, residual)
    result: Complex = np.where(np.abs(step) <= SURE * np.abs(values), step, 0.0)
    return result


def stability(values: Complex) -> str:
    """``stable``, ``unstable`` or, where the largest real part is zero to rounding, ``neutral``."""
    growth = float(values.real.max())
    if abs(growth) <= NEUTRAL * float(np.abs(values).max()):
        return "neutral"
    return "unstable" if growth > 0.0 else "stable"


def coupled_modes(values: Complex) -> NDArray[np.int64]:
    """For each mode, the one it has merged with (the last of several), else -1.

    Two modes have merged when they differ in growth and not, or less, in frequency.
    """
    frequency, growth = values.imag[:, None], values.real[:, None]
    split = np.abs(frequency - values.imag)
    same = (split <= COUPLED * np.abs(frequency)) & (frequency != 0.0)
    merged = same & (split < np.abs(growth - values.real))
    partner: NDArray[np.int64] = np.where(merged, np.arange(len(values)), -1).max(axis=1)
    return partner
