"""The steady state reached from a start: its class, L_s, period, section, exponents.

What is computed, and how a run ends, is told in ``steady_state.py``.
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
        "Poincaré section by which the steady state is judged",
    ),
    Setting(
        "observe",
        "state",
        None,
        "state whose value at the section is kept; the first state when left out",
    ),
    Setting(
        "t_max", "number", 1000.0, "budget of simulated time", "s", minimum=0.0, exclusive=True
    ),
    Setting(
        "transient", "number", 0.0, "time before the steady state is looked for", "s", minimum=0.0
    ),
    Setting(
        "lyapunov",
        "string",
        "auto",
        "exponents and multipliers: auto computes them where the class needs them and on "
        "periodic motions, never leaves them out",
        choices=("auto", "never"),
    ),
)


def run(
    system: System,
    parameters: Mapping[str, float],
    start: Start | None,
    settings: Mapping[str, Any],
    solver: SolverSettings,
) -> Outcome:
    """The steady state that `start` leads to."""
    from fiv_cli.analyses.attractor.steady_state import steady_state

    assert start is not None
    return steady_state(system, parameters, start, settings, solver)


ANALYSIS = Analysis("response", "steady-state response", SETTINGS, True, run)
