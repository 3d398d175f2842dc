"""response (being written)."""
from __future__ import annotations
from fiv_cli.analyses.base import Analysis, Outcome, Setting, Section
import math


def run(system, parameters, start, settings, solver):
    raise NotImplementedError

SETTINGS = (
    Setting("section", "section", Section("event"), "Poincaré section that the steady state is judged on"),
    Setting("observe", "state", None, "state whose value at the section is kept; the first state when left out"),
    Setting("t_max", "number", 1000.0, "budget of simulated time", "s", minimum=0.0, exclusive=True),
    Setting("transient", "number", 0.0, "time before the steady state is looked for", "s", minimum=0.0),
    Setting("lyapunov", "string", "auto", "largest Lyapunov exponent: auto computes it where the motion is not periodic", choices=("auto", "always", "never")),
)
ANALYSIS = Analysis("response", "steady-state response", SETTINGS, True, run)
