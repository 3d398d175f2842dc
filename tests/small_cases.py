"""Texts of small cases that several tests run, on other versions of the program too."""

from __future__ import annotations

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

ENDLESS = (
    FAR.format(v=10, N=120, transient=1e13, t_max=2e13)
    .replace("start = 0.5, stop = 2.0, num = 10", "start = 2.0, stop = 3.0, num = 2")
    .replace("num = 120", "num = 2")
    .replace("x = 10.0", "x = 0.5")
    .replace("[[initial]]", "[solver]\nmax_steps = 1000000000000\n[[initial]]")
)
"""Four points that slide for ever: no event brings them back to Python."""
