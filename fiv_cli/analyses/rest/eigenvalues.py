"""Complex eigenvalues of the system linearised at its sliding equilibrium.

Thesis 3.2.1, equations 3.33-3.37; averaged over a fast excitation, 5.15. The Jacobian is exact:
it is generated from the equations, not differenced.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from fiv_cli.analyses.base import Analysis, Outcome, Setting, SolverSettings, Start
from fiv_cli.analyses.rest.linear import SYSTEM

if TYPE_CHECKING:
    from fiv_cli.dynamics.system import System

SETTINGS = (
    SYSTEM,
    Setting(
        "at_equilibrium",
        "integer",
        1,
        "which equilibrium, as `equilibrium` numbers them from 1",
        minimum=1,
    ),
)


def run(
    system: System,
    parameters: Mapping[str, float],
    start: Start | None,
    settings: Mapping[str, Any],
    solver: SolverSettings,
) -> Outcome:
    """Eigenvalues in rad/s and eigenvectors, by rising frequency."""
    from fiv_cli.analyses.rest.linearisation import eigenvalues_at

    return eigenvalues_at(system, parameters, settings["system"], settings["at_equilibrium"])


ANALYSIS = Analysis(
    "eigenvalues",
    "complex eigenvalues at the sliding equilibrium",
    SETTINGS,
    False,
    run,
    linear=True,
)
