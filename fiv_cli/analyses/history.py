"""history (being written)."""
from __future__ import annotations
from fiv_cli.analyses.base import Analysis, Outcome, Setting, Section
import math


def run(system, parameters, start, settings, solver):
    raise NotImplementedError

SETTINGS = (
    Setting("t_end", "number", None, "end of the motion", "s", minimum=0.0, exclusive=True, required=True),
    Setting("sample", "number", None, "interval of the samples; t_end / 2000 when left out", "s", minimum=0.0, exclusive=True),
)
ANALYSIS = Analysis("history", "the motion in time", SETTINGS, True, run)
