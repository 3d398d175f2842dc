"""Where the class of the steady state changes along one parameter.

The suppression boundary A_b against R by simulation, the speeds at which stick-slip exists at each
preload, the ends of a bistable range: a scan of a bracket, and each change found in it bisected.
What is computed at each value is the analysis `response`; see ``boundaries.py``.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from fiv_cli.analyses.attractor import response
from fiv_cli.analyses.base import Analysis, Outcome, Setting, SolverSettings, Start

if TYPE_CHECKING:
    from fiv_cli.dynamics.system import System

SETTINGS = (
    Setting("parameter", "parameter", None, "what is varied: no axis of the grid", required=True),
    Setting("bracket", "bracket", None, "where changes are looked for", required=True),
    Setting("of", "question", None, "the question whose answer changes", required=True),
    Setting("scan", "integer", 9, "values looked at first, both ends included", minimum=2),
    Setting(
        "width",
        "number",
        1e-4,
        "width to which a change is bisected, as a share of the bracket",
        minimum=0.0,
        exclusive=True,
    ),
    Setting(
        "follow",
        "string",
        "none",
        "where a run begins: at the start (none), or where the one before ended",
        choices=("none", "up", "down", "both"),
    ),
    *response.SETTINGS,
)


def run(
    system: System,
    parameters: Mapping[str, float],
    start: Start | None,
    settings: Mapping[str, Any],
    solver: SolverSettings,
) -> Outcome:
    """Every change of the answer in the bracket, by rising value."""
    from fiv_cli.analyses.attractor.boundaries import boundaries

    assert start is not None
    return boundaries(system, parameters, start, settings, solver)


ANALYSIS = Analysis(
    "boundary",
    "where the class of the steady state changes along a parameter",
    SETTINGS,
    True,
    run,
    chains=False,
)
