"""The system linearised at a sliding equilibrium, and its eigenvalues (thesis 3.33-3.37, 5.15)."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from contextlib import suppress
from functools import cache

import numpy as np
from numpy.typing import NDArray

from fiv_cli.analyses.base import Outcome, Request
from fiv_cli.analyses.rest.averaging import LEAST_RATIO, averaged_sliding, frequency_ratio
from fiv_cli.analyses.rest.equilibria import Sliding, equilibria_at, free_coordinates, sliding_at
from fiv_cli.dynamics.system import System, Vector

Real = NDArray[np.float64]
Complex = NDArray[np.complex128]

NEUTRAL = 1e-14  # growth rates below this share of the largest eigenvalue are rounding
SAME_GROWTH = 1e-9  # modes grow alike where they differ by less than this share of it
SURE = 1e-6  # a correction of an eigenvalue beyond this share of it is not one


def sliding_system(system: System, parameters: Mapping[str, float], which: str) -> Sliding:
    """The ``original`` system without its excitation, or the one ``averaged`` over it."""
    ((_, state),) = sliding_systems(system, [parameters], which)
    return state[0]


def sliding_systems(
    system: System, points: Sequence[Mapping[str, float]], which: str
) -> Iterable[tuple[NDArray[np.intp], Sliding]]:
    """The same at several points: the systems that there are, and which points are in each."""
    if which == "averaged":
        return averaged_sliding(system, points)
    return [(np.arange(len(points)), sliding_at(system, points))]


def eigenvalues_at(system: System, requests: Sequence[Request]) -> list[Outcome]:
    """Eigenvalues (rad/s) and vectors at the equilibrium asked for, by rising frequency."""
    which, number = requests[0].settings["system"], requests[0].settings["at_equilibrium"]
    outcomes = [Outcome()] * len(requests)
    for rows, sliding in sliding_systems(system, [r.parameters for r in requests], which):
        found = equilibria_at(sliding)
        here = [place for place, one in enumerate(found) if len(one.states) >= number]
        for row, one in zip(rows.tolist(), found, strict=True):
            outcomes[row] = Outcome(status="failed", reason=one.reason or "no_equilibrium")
        if here:
            at, states = sliding[here], np.array([found[i].states[number - 1] for i in here])
            values, vectors = modes_at(at, states)
            described = _described(values, vectors[:, : len(system.motions)])
            for row, told in zip(rows[here].tolist(), described, strict=True):
                outcomes[row] = Outcome(values=told)
            if which == "averaged":
                for row, jacobian in zip(
                    rows[here].tolist(), free_jacobian(at, states), strict=True
                ):
                    _judge(outcomes[row], system, requests[row].parameters, jacobian)
    return outcomes


def _judge(
    outcome: Outcome, system: System, parameters: Mapping[str, float], jacobian: Real
) -> None:
    """Add how far averaging can be trusted."""
    ratio = frequency_ratio(system, parameters, jacobian)
    outcome.values["averaging_ratio"] = ratio
    outcome.reason = "" if ratio >= LEAST_RATIO else "averaging_invalid"


def _described(values: Complex, shapes: Complex) -> list[dict[str, object]]:
    """The variables that describe spectra and their modes, in columns; of each row."""
    magnitude, growth = np.abs(values), values.real
    as_fast = growth.max(axis=-1) - SAME_GROWTH * magnitude.max(axis=-1)
    fastest = (growth >= as_fast[:, None]).argmax(axis=-1)[:, None]
    frequency = np.abs(values.imag) / (2.0 * np.pi)
    sure = np.where(magnitude > 0.0, magnitude, 1.0)
    columns = {
        "eigenvalue_real": values.real,
        "eigenvalue_imag": values.imag,
        "mode_frequency": frequency,
        "damping_ratio": np.where(magnitude > 0.0, -values.real / sure, 0.0),
        "eigenvector_real": shapes.real.swapaxes(1, 2),
        "eigenvector_imag": shapes.imag.swapaxes(1, 2),
        "growth_rate": values.real.max(axis=-1).tolist(),
        "growth_frequency": np.take_along_axis(frequency, fastest, axis=-1)[:, 0].tolist(),
        "stable": [stability(one) for one in values],
    }
    return [dict(zip(columns, row, strict=True)) for row in zip(*columns.values(), strict=True)]


def modes_at(state: Sliding, y: Vector) -> tuple[Complex, Complex]:
    """Eigenvalues and vectors (columns, over all states) of the system linearised at `y`.

    At one point or, in rows, at several. What a closed rigid contact determines is no freedom of
    its own: it has no eigenvalues, and follows in the vectors.
    """
    free, n = free_states(state.system), y.shape[-1]
    jacobian = state.jacobian(y)
    values, free_vectors = spectrum(_square(jacobian, free))
    if len(free) == n:
        return values, free_vectors
    m = len(state.system.coordinates)
    determined = np.setdiff1d(np.arange(m), free)
    vectors = np.zeros((*y.shape, values.shape[-1]), complex)
    vectors[..., free, :] = free_vectors
    rates = jacobian[..., determined[:, None], free] @ free_vectors
    vectors[..., m + determined, :] = rates
    moving = np.broadcast_to((values != 0.0)[..., None, :], rates.shape)
    vectors[..., determined, :] = np.divide(
        rates, values[..., None, :], out=np.zeros(rates.shape, complex), where=moving
    )
    return values, _normalised(vectors)


def free_jacobian(state: Sliding, y: Vector) -> Real:
    """Derivative of the rates of `free_states` by these; shape (..., free states, free states)."""
    return _square(state.jacobian(y), free_states(state.system))


def _square(matrices: Real, places: NDArray[np.intp]) -> Real:
    """These rows and columns."""
    return np.ascontiguousarray(matrices[..., places[:, None], places])


@cache
def free_states(system: System) -> NDArray[np.intp]:
    """Places of the states that no rigid contact determines: coordinates, then velocities, ..."""
    m, n = len(system.coordinates), len(system.state_names)
    coordinates = np.array(free_coordinates(system), dtype=np.intp)
    return np.concatenate([coordinates, m + coordinates, np.arange(2 * m, n)])


def spectrum(jacobian: Real) -> tuple[Complex, Complex]:
    """Eigenvalues by rising frequency (a pair: positive imaginary part first) and vectors.

    Of one matrix or of a stack of them. Vectors are columns, of unit length, their largest entry
    real and positive. The real parts are exact zeros where there is no damping, and have few
    digits less than the frequencies where damping is weak.
    """
    matrices = jacobian.reshape(-1, *jacobian.shape[-2:])
    values = np.zeros(matrices.shape[:-1], complex)
    shapes = np.zeros(matrices.shape, complex)  # rows
    mechanical = _are_mechanical(matrices)
    m = matrices.shape[-1] // 2
    undamped = mechanical & ~matrices[:, m:, m:].any(axis=(1, 2))
    for rows, solve in (
        (undamped, _undamped),
        (mechanical & ~undamped, _weakly_damped),
        (~mechanical, _damped),
    ):
        if rows.any():
            found, vectors = solve(matrices[rows])
            values[rows], shapes[rows] = found, vectors.swapaxes(1, 2)
    order = np.lexsort((-values.imag, values.real, np.round(np.abs(values.imag), 12)))
    values = np.take_along_axis(values, order, axis=1)
    shapes = np.take_along_axis(shapes, order[:, :, None], axis=1)
    vectors = _normalised(shapes.swapaxes(1, 2))
    return values.reshape(jacobian.shape[:-1]), vectors.reshape(jacobian.shape)


def _normalised(vectors: Complex) -> Complex:
    """Columns of unit length whose largest entry is real and positive."""
    places = np.argmax(np.abs(vectors), axis=-2)[..., None, :]
    largest = np.take_along_axis(vectors, places, axis=-2)
    lengths = np.linalg.norm(vectors, axis=-2, keepdims=True)
    unit: Complex = vectors * (np.abs(largest) / largest) / lengths
    return unit


def _are_mechanical(jacobians: Real) -> NDArray[np.bool_]:
    """For each, whether its state is coordinates and their velocities, and nothing else."""
    m = jacobians.shape[-1] // 2
    if 2 * m != jacobians.shape[-1]:
        return np.zeros(len(jacobians), bool)
    told: NDArray[np.bool_] = (jacobians[:, :m] == _velocities(m)).all(axis=(1, 2))
    return told


@cache
def _velocities(m: int) -> Real:
    """Derivative of the rates of m coordinates, which are their velocities, by both."""
    return np.hstack([np.zeros((m, m)), np.eye(m)])


def _undamped(jacobians: Real) -> tuple[Complex, Complex]:
    """From the squares of the eigenvalues, which are those of the stiffness: real while stable."""
    m = jacobians.shape[-1] // 2
    squares, shapes = np.linalg.eig(jacobians[:, m:, :m])
    roots: Complex = np.sqrt(squares.astype(complex))
    values: Complex = np.concatenate([roots, -roots], axis=1)
    values += 0.0  # no negative zeros
    vectors = np.tile(shapes.astype(complex), 2)
    return values, np.concatenate([vectors, values[:, None] * vectors], axis=1)


def _damped(jacobians: Real) -> tuple[Complex, Complex]:
    values, vectors = np.linalg.eig(jacobians)
    return values.astype(complex), vectors.astype(complex)


def _weakly_damped(jacobians: Real) -> tuple[Complex, Complex]:
    values, vectors = _damped(jacobians)
    return _corrected(values, _correction(jacobians, values, vectors)), vectors


def _corrected(values: Complex, steps: Complex) -> Complex:
    """Real eigenvalues stay real; pairs, which stand side by side, conjugate to the last bit."""
    corrected = values + np.where(values.imag == 0.0, steps.real, steps)
    row, upper = np.nonzero(values.imag > 0.0)
    corrected[row, upper + 1] = corrected[row, upper].conj()
    return corrected


def _correction(jacobians: Real, values: Complex, vectors: Complex) -> Complex:
    """One step of the two-sided Rayleigh quotient of ``s^2 + s C + K``, for each matrix.

    The eigenvalues of the matrix have an error of rounding of the *frequencies*; here the terms
    that decide the real parts, as small as the damping, are summed on their own. Nothing is
    corrected where two modes all but coincide.
    """
    m = values.shape[-1] // 2
    stiffness, damping = -jacobians[:, m:, :m], -jacobians[:, m:, m:]
    left = inverted(vectors)[..., m:]
    shapes, by_mode = vectors[:, :m], values[:, None, :]
    residual = shapes * by_mode**2 + (damping @ shapes) * by_mode + stiffness @ shapes
    step = -np.einsum("nim,nmi->ni", left, residual)
    result: Complex = np.where(np.abs(step) <= SURE * np.abs(values), step, 0.0)
    return result


def inverted(matrices: Complex) -> Complex:
    """Inverses; NaN of the singular ones."""
    with suppress(np.linalg.LinAlgError):
        return np.linalg.inv(matrices).astype(complex, copy=False)
    if len(matrices) == 1:
        return np.full(matrices.shape, complex(np.nan, np.nan))
    return np.concatenate([inverted(matrices[row : row + 1]) for row in range(len(matrices))])


def stability(values: Complex) -> str:
    """``stable``, ``unstable`` or, where the largest real part is zero to rounding, ``neutral``."""
    growth = float(values.real.max())
    if abs(growth) <= NEUTRAL * float(np.abs(values).max()):
        return "neutral"
    return "unstable" if growth > 0.0 else "stable"
