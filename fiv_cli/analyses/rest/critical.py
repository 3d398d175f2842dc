"""Critical values of a parameter: where a mode of the sliding equilibrium changes stability.

The eigenvalues of thesis 3.33-3.37 (averaged: 5.15) as functions of one parameter, without a grid
in it: every crossing inside a bracket, of any mode, to rounding.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from fiv_cli.analyses.base import Analysis, Outcome, Setting, SolverSettings, Start
from fiv_cli.analyses.rest.linear import SYSTEM

if TYPE_CHECKING:
    from fiv_cli.dynamics.system import System

SETTINGS = (
    Setting("parameter", "parameter", None, "what is varied: no axis of the grid", required=True),
    Setting("bracket", "bracket", None, "where its critical values are looked for", required=True),
    SYSTEM,
)


def run(
    system: System,
    parameters: Mapping[str, float],
    start: Start | None,
    settings: Mapping[str, Any],
    solver: SolverSettings,
) -> Outcome:
    """Every crossing by rising value, with its kind, direction and mode."""
    from fiv_cli.analyses.rest.crossings import critical_values

    varied, bracket = settings["parameter"], settings["bracket"]
    return critical_values(system, parameters, varied, bracket, settings["system"])


ANALYSIS = Analysis(
    "critical",
    "critical values of a parameter, by complex eigenvalues",
    SETTINGS,
    False,
    run,
    linear=True,
)
