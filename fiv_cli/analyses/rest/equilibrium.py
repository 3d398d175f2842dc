"""Sliding equilibria of the unexcited system: all of them (thesis 3.31, 6.18, 7.12-7.17).

How they are found, and when the set is certified to be complete, is told in ``equilibria.py``.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from fiv_cli.analyses.base import Analysis, Outcome, SolverSettings
from fiv_cli.analyses.rest.linear import SYSTEM

if TYPE_CHECKING:
    from fiv_cli.dynamics.system import System


def run(
    system: System,
    parameters: Mapping[str, float],
    start: None,
    settings: Mapping[str, Any],
    solver: SolverSettings,
) -> Outcome:
    """Equilibria, contact forces there and what is left of the equations (residual)."""
    from fiv_cli.analyses.rest.equilibria import all_equilibria
    from fiv_cli.analyses.rest.linearisation import sliding_system
    from fiv_cli.analyses.rest.surface import at_the_contact

    state = sliding_system(system, parameters, settings["system"])
    found = all_equilibria(state)
    solutions = found.states
    counts: dict[str, Any] = {
        "n_solutions": len(solutions),
        "n_pulling": found.pulling,
        "complete": "certified" if found.certified else "not_certified",
    }
    counts |= {} if found.n_complex is None else {"n_complex": found.n_complex}
    if not solutions:
        return Outcome(status="failed", reason=found.reason, values=counts)
    forces = np.array([state.contact_forces(y) for y in solutions])
    m = len(system.coordinates)
    if system.setup.model.surface is not None:
        counts["w"] = np.array([at_the_contact(system, parameters, y) for y in solutions])
    return Outcome(
        values=counts
        | {
            "equilibrium": np.array([y[:m] for y in solutions]),
            "F_N": _per_contact(forces[:, :, 0]),
            "F_T": _per_contact(forces[:, :, 1]),
            "residual": np.array([np.max(np.abs(state.rates(y))) for y in solutions]),
        }
    )


def _per_contact(values: Any) -> Any:
    """(solution, contact), or (solution,) on models with one contact."""
    return values[:, 0] if values.shape[1] == 1 else values


ANALYSIS = Analysis(
    "equilibrium",
    "sliding equilibria of the unexcited system",
    (SYSTEM,),
    run,
    uses_starts=False,
    linear=True,
)
