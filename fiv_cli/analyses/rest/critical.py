"""Critical values of a parameter: where a mode of the sliding equilibrium changes stability.

The eigenvalues of thesis 3.33-3.37 (averaged: 5.15) as functions of one parameter, without a grid
in it: every crossing inside a bracket, of any mode, to rounding (``crossings.py``).
"""

from __future__ import annotations

from fiv_cli.analyses.base import Analysis, Later
from fiv_cli.analyses.rest.linear import SYSTEM
from fiv_cli.analyses.settings import Bracket, ParameterName

ANALYSIS = Analysis(
    "critical",
    "critical values of a parameter, by complex eigenvalues",
    (
        ParameterName("parameter", "what is varied: no axis of the grid", required=True),
        Bracket("bracket", "where its critical values are looked for", required=True),
        SYSTEM,
    ),
    Later("fiv_cli.analyses.rest.crossings:critical_values"),
    uses_starts=False,
    linear=True,
)
