"""eigenvalues (being written)."""
from __future__ import annotations
from fiv_cli.analyses.base import Analysis, Outcome, Setting, Section
import math


def run(system, parameters, start, settings, solver):
    raise NotImplementedError

SETTINGS = (
    Setting("system", "string", "original", "which linearised system", choices=("original",)),
)
ANALYSIS = Analysis("eigenvalues", "complex eigenvalues at the sliding equilibrium", SETTINGS, False, run, linear=True)
