"""Cycles told long before the section repeats: what they are, and from how far away."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from motions import TIGHT, defaults, motion, system

from fiv_cli import api
from fiv_cli.analyses.attractor.confirm import confirm
from fiv_cli.analyses.base import Section, Start
from fiv_cli.analyses.cycles.periodic import Problem
from fiv_cli.api import analyse
from fiv_cli.reading.datasets import class_names
from fiv_cli.sweep.policy import Policy
from fiv_cli.sweep.progress import Silent
from fiv_cli.sweep.run import run_case

# Near the end of a window of seven sticks in four periods of the base (Figure 3.6).
SHAKEN = {"u0": 0.5, "omega": 1.935}
PERIOD = 16 * 2 * np.pi / SHAKEN["omega"]


def test_a_slow_cycle_is_told_long_before_it_is_reached() -> None:
    """A multiplier of 0.9896 over 52 s: the section repeats to 1e-5 after 15,000 s."""
    settings: dict[str, Any] = {"section": Section("event"), "observe": "x", "t_max": 1e4}
    start = Start("rest", "state")
    found = analyse("belt-1dof", "coulomb", "response", start, settings, **SHAKEN).values
    assert found["attractor"] == "periodic" and found["multiplicity"] == 7
    assert found["transient_used"] < 5e3 and found["cycle_residual"] < 1e-9
    assert found["period"] == pytest.approx(PERIOD, rel=1e-9)
    assert np.max(found["floquet_multiplier"]) == pytest.approx(0.98956573, rel=1e-6)


def test_from_afar_less_is_confirmed_and_the_same() -> None:
    """Once the way to the cycle is straight it stays so; until then none is told."""
    parameters = defaults("belt-1dof", "coulomb", **SHAKEN)
    problem = Problem(system("belt-1dof"), parameters, TIGHT, Section("event"))
    shaken = motion("belt-1dof", **SHAKEN)
    found = []
    for number in range(1, 60, 2):
        shaken.run(number * PERIOD + 1.0)
        found.append([confirm(problem, shaken, PERIOD, far) for far in (False, True)])
    near, far = ([one is not None for one in each] for each in zip(*found, strict=True))
    assert far == sorted(far) and near == sorted(near) and 0 < sum(far) < sum(near)


CASE = {"schema": 1, "analysis": [{"kind": "response", "t_max": 1e4}]}
HALVED = {
    "model": {"name": "belt-2mass", "parameters": {"v": 0.225, "N": 12.0}},
    "friction": {"law": "stribeck", "mu_s": 0.4, "mu_k": 0.1},
    "initial": [{"label": "belt", "kind": "state", "state": {"x1_dot": "v", "x2_dot": "v"}}],
}
TORUS = {"model": {"name": "belt-1dof", "parameters": {"u0": 0.5, "omega": 0.3}}}
UNDAMPED = {
    "model": {
        "name": "belt-1dof",
        "parameters": {"u0": 0.5, "omega": 0.6180339887, "v": 5.0, "c": 0.0},
    },
    "initial": [{"label": "a", "kind": "state", "state": {"x": 3.1171}}],
    "analysis": [{"kind": "response", "t_max": 1e4, "section": {"phase": 0.0}}],
    "solver": {"rtol": 1e-13},
}


@pytest.mark.parametrize(
    ("given", "told"),
    [(HALVED, "undecided"), (TORUS, "quasiperiodic"), (UNDAMPED, "quasiperiodic")],
)
def test_no_torus_is_told_where_a_cycle_lies_within_what_the_motion_nearly_repeats(
    given: dict[str, Any], told: str, tmp_path: Path
) -> None:
    """Beside a period doubling both masses stick on each turn, so that there can be no torus; the
    motion comes to a cycle of 24 sticks by 3 % a period. Within a torus there is none that draws:
    that about which an undamped one swings freely is neutral."""
    run_case(api.load({**CASE, **given}), tmp_path / "a.nc", Policy(workers=1), Silent())
    found = api.read(tmp_path / "a.nc")["attractor"]
    assert class_names(found) == [told]
