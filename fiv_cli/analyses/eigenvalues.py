"""Complex eigenvalues of the system linearised at its sliding equilibrium.

Thesis 3.2.1, equations 3.33-3.37. The Jacobian is exact: it is generated from the equations,
not differenced.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from fiv_cli.analyses.base import Analysis, Outcome, Setting, SolverSettings, Start

if TYPE_CHECKING:
    from fiv_cli.dynamics.system import System

COUPLED = 1e-3  # relative distance of the frequencies of two coupled modes

SETTINGS = (
    Setting("system", "string", "original", "which linearised system", choices=("original",)),
)


def run(
    system: System,
    parameters: Mapping[str, float],
    start: Start | None,
    settings: Mapping[str, Any],
    solver: SolverSettings,
) -> Outcome:
    """Eigenvalues in rad/s and eigenvectors, by rising frequency."""
    from fiv_cli.analyses.common import equilibria, sliding

    state = sliding(system, parameters)
    solutions = equilibria(state)
    if not solutions:
        return Outcome(status="failed", reason="no_equilibrium")
    values, vectors = spectrum(state.jacobian(solutions[0]))
    magnitude = np.abs(values)
    ratio = np.where(magnitude > 0.0, -values.real / np.where(magnitude > 0.0, magnitude, 1.0), 0.0)
    return Outcome(
        values={
            "eigenvalue_real": values.real,
            "eigenvalue_imag": values.imag,
            "mode_frequency": np.abs(values.imag) / (2.0 * np.pi),
            "damping_ratio": ratio,
            "eigenvector_real": vectors.real.T,
            "eigenvector_imag": vectors.imag.T,
            "coupled_with": coupled_modes(values),
            "growth_rate": float(np.max(values.real)),
            "stable": int(np.max(values.real) < 0.0),
        }
    )


def spectrum(
    jacobian: NDArray[np.float64],
) -> tuple[NDArray[np.complex128], NDArray[np.complex128]]:
    """Eigenvalues by rising frequency (a pair: positive imaginary part first) and vectors.

    Vectors are columns, of unit length, their largest entry real and positive.
    """
    values, vectors = np.linalg.eig(jacobian)
    values, vectors = values.astype(complex), vectors.astype(complex)
    order = np.lexsort((-values.imag, values.real, np.round(np.abs(values.imag), 12)))
    values, vectors = values[order], vectors[:, order]
    largest = vectors[np.argmax(np.abs(vectors), axis=0), np.arange(len(values))]
    return values, vectors * (np.abs(largest) / largest)


def coupled_modes(values: NDArray[np.complex128]) -> NDArray[np.int64]:
    """For each mode, the one it has merged with: same frequency, opposite growth; else -1."""
    partner = np.full(len(values), -1, np.int64)
    for i, first in enumerate(values):
        for j, second in enumerate(values):
            same = abs(first.imag - second.imag) <= COUPLED * abs(first.imag)
            if i != j and same and first.imag != 0.0 and first.real * second.real < 0.0:
                partner[i] = j
    return partner


ANALYSIS = Analysis(
    "eigenvalues",
    "complex eigenvalues at the sliding equilibrium",
    SETTINGS,
    False,
    run,
    linear=True,
)
