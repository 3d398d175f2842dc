"""Periodic orbits, stable or not, and where they end along a parameter.

A first guess comes from the motion that the start leads to: two section points that nearly agree.
Newton's method makes a cycle of it (``periodic.py``). With `parameter` and `bracket` the branch
of that cycle is followed both ways (``branch.py``): what "exists" means, apart from what a start
reaches.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from fiv_cli.analyses.base import Analysis, Outcome, Section, Setting, SolverSettings, Start

if TYPE_CHECKING:
    from fiv_cli.dynamics.system import System

SETTINGS = (
    Setting(
        "section",
        "section",
        Section("event"),
        "Poincaré section whose returns give the first guess, and where the cycle is reported",
    ),
    Setting(
        "observe",
        "state",
        None,
        "state whose value at the section is kept; the first state when left out",
    ),
    Setting(
        "t_max",
        "number",
        100.0,
        "time allowed for reaching a first guess",
        "s",
        minimum=0.0,
        exclusive=True,
    ),
    Setting(
        "transient", "number", 0.0, "time before a first guess is looked for", "s", minimum=0.0
    ),
    Setting(
        "multiplicity",
        "integer",
        None,
        "section points per period; found from the motion when left out",
        minimum=1,
    ),
    Setting(
        "parameter", "parameter", None, "along which the branch is followed: no axis of the grid"
    ),
    Setting("bracket", "bracket", None, "how far the branch is followed"),
    Setting(
        "width",
        "number",
        1e-6,
        "width to which its ends are bracketed, as a share of the bracket",
        minimum=0.0,
        exclusive=True,
    ),
)


def run(
    system: System,
    parameters: Mapping[str, float],
    start: Start | None,
    settings: Mapping[str, Any],
    solver: SolverSettings,
) -> Outcome:
    """The cycle near what `start` leads to, and its branch where a parameter is given."""
    from fiv_cli.analyses.cycles.find_cycle import find_cycle

    assert start is not None
    return find_cycle(system, parameters, start, settings, solver)


ANALYSIS = Analysis("cycle", "periodic orbits and where they end", SETTINGS, True, run)
