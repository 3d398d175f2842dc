"""The steady state reached from a start: its class, L_s, period, section, exponents.

What is computed, and how a run ends, is told in ``steady_state.py``.
"""

from __future__ import annotations

from fiv_cli.analyses.base import Analysis, Later, Section
from fiv_cli.analyses.settings import Choice, Number, SectionSetting, StateName

SETTINGS = (
    SectionSetting(
        "section",
        "Poincaré section by which the steady state is judged",
        default=Section("event"),
    ),
    StateName("observe", "state whose value at the section is kept; the first state when left out"),
    Number("t_max", "budget of simulated time", default=1000.0, unit="s", above=0.0),
    Number(
        "transient", "time before the steady state is looked for", default=0.0, unit="s", least=0.0
    ),
    Choice(
        "lyapunov",
        "exponents and multipliers: auto computes them where the class needs them and on "
        "periodic motions, never leaves them out",
        default="auto",
        choices=("auto", "never"),
    ),
)

ANALYSIS = Analysis(
    "response",
    "steady-state response",
    SETTINGS,
    Later("fiv_cli.analyses.attractor.steady_state:steady_state"),
    figure="bifurcation",
)
