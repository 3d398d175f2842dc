"""Where the class of the steady state changes along one parameter.

The suppression boundary A_b against R by simulation, the speeds at which stick-slip exists at each
preload, the ends of a bistable range: a scan of a bracket, and each change found in it bisected.
What is computed at each value is the analysis `response`; see ``boundaries.py``.
"""

from __future__ import annotations

from fiv_cli.analyses.attractor import response
from fiv_cli.analyses.base import Analysis, Later
from fiv_cli.analyses.settings import (
    Bracket,
    Choice,
    Integer,
    Number,
    ParameterName,
    QuestionSetting,
)

ANALYSIS = Analysis(
    "boundary",
    "where the class of the steady state changes along a parameter",
    (
        ParameterName("parameter", "what is varied: no axis of the grid", required=True),
        Bracket("bracket", "where changes are looked for", required=True),
        QuestionSetting("of", "the question whose answer changes", required=True),
        Integer("scan", "values looked at first, both ends included", default=9, least=2),
        Number(
            "width",
            "width to which a change is bisected, as a share of the bracket",
            default=1e-4,
            above=0.0,
        ),
        Choice(
            "follow",
            "where a run begins: at the start (none), or where the one before ended",
            default="none",
            choices=("none", "up", "down", "both"),
        ),
        *response.SETTINGS,
    ),
    Later("fiv_cli.analyses.attractor.boundaries:boundaries"),
    chains=False,
)
