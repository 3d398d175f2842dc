"""Sliding equilibria of the unexcited system (thesis 3.31, 6.18)."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from fiv_cli.analyses.base import Analysis, Outcome, SolverSettings, Start

if TYPE_CHECKING:
    from fiv_cli.dynamics.system import System


def run(
    system: System,
    parameters: Mapping[str, float],
    start: Start | None,
    settings: Mapping[str, Any],
    solver: SolverSettings,
) -> Outcome:
    """Equilibria, contact forces there and what is left of the equations (residual)."""
    from fiv_cli.analyses.common import equilibria, sliding

    state = sliding(system, parameters)
    solutions = equilibria(state)
    if not solutions:
        return Outcome(status="failed", reason="no_equilibrium", values={"n_solutions": 0})
    forces = np.array([state.contact_forces(y) for y in solutions])
    m = len(system.coordinates)
    return Outcome(
        values={
            "equilibrium": np.array([y[:m] for y in solutions]),
            "n_solutions": len(solutions),
            "F_N": _per_contact(forces[:, :, 0]),
            "F_T": _per_contact(forces[:, :, 1]),
            "residual": np.array([np.max(np.abs(state.rates(y))) for y in solutions]),
        }
    )


def _per_contact(values: Any) -> Any:
    """(solution, contact), or (solution,) on models with one contact."""
    return values[:, 0] if values.shape[1] == 1 else values


ANALYSIS = Analysis(
    "equilibrium", "sliding equilibria of the unexcited system", (), False, run, linear=True
)
