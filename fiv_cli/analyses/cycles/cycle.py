"""Periodic orbits, stable or not, and where they end along a parameter.

A first guess comes from the motion that the start leads to: two section points that nearly agree.
Newton's method makes a cycle of it (``periodic.py``). With `parameter` and `bracket` the branch
of that cycle is followed both ways (``branch.py``): what "exists" means, apart from what a start
reaches.
"""

from __future__ import annotations

from fiv_cli.analyses.base import Analysis, Later, Section
from fiv_cli.analyses.settings import (
    Bracket,
    Integer,
    Number,
    ParameterName,
    SectionSetting,
    StateName,
)

ANALYSIS = Analysis(
    "cycle",
    "periodic orbits and where they end",
    (
        SectionSetting(
            "section",
            "Poincaré section whose returns give the first guess, and where the cycle is reported",
            default=Section("event"),
        ),
        StateName(
            "observe", "state whose value at the section is kept; the first state when left out"
        ),
        Number(
            "t_max", "time allowed for reaching a first guess", default=100.0, unit="s", above=0.0
        ),
        Number(
            "transient", "time before a first guess is looked for", default=0.0, unit="s", least=0.0
        ),
        Integer("multiplicity", "section points per period; found from the motion when left out"),
        ParameterName(
            "parameter",
            "along which the branch is followed: no axis of the grid",
            partner="bracket",
        ),
        Bracket("bracket", "how far the branch is followed", partner="parameter"),
        Number(
            "width",
            "width to which its ends are bracketed, as a share of the bracket",
            default=1e-6,
            above=0.0,
        ),
    ),
    Later("fiv_cli.analyses.cycles.find_cycle:find_cycle"),
)
