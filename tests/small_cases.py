"""Texts of small cases that several tests run."""

from __future__ import annotations

from fiv_cli.analyses import all_analyses
from fiv_cli.models import all_models

# Names of models and analyses that go together.
SUITED = [
    (name, kind)
    for name, model in all_models().items()
    for kind, analysis in all_analyses().items()
    if not analysis.unsuited(model)
]

BELT = """\
schema = 1
[model]
name = "belt-1dof"
[grid]
v = [1.0, 2.0]
[[analysis]]
kind = "response"
"""
PIN = """\
schema = 1
[model]
name = "pin-on-disc"
[grid]
mu_k = [0.1, 0.2]
[[analysis]]
kind = "equilibrium"
"""
FAR = """\
schema = 1
[model]
name = "belt-1dof"
[grid]
v = {{ start = 0.5, stop = 2.0, num = {v} }}
N = {{ start = 5.0, stop = 20.0, num = {N} }}
[[initial]]
label = "far"
kind = "state"
state = {{ x = 10.0 }}
[[analysis]]
kind = "response"
transient = {transient}
t_max = {t_max}
"""
