"""equilibrium (being written)."""
from __future__ import annotations
from fiv_cli.analyses.base import Analysis, Outcome, Setting, Section
import math


def run(system, parameters, start, settings, solver):
    raise NotImplementedError

ANALYSIS = Analysis("equilibrium", "sliding equilibria of the unexcited system", (), False, run, linear=True)
