"""Looks at a motion, taken in machine code, are those that Python takes, bit for bit."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from fiv_cli.analyses.attractor import steady_state, watch
from fiv_cli.analyses.base import Section
from fiv_cli.api import analyse

STRIBECK = {"c": 0.1, "N": 1.0, "v": 1.5, "mu_s": 1.0, "mu_k": 0.5, "v_s": 0.5, "delta": 1.0}
CASES: dict[str, tuple[str, dict[str, float], dict[str, Any], dict[str, float]]] = {
    "a slide": ("stribeck", {"x": 0.9}, {}, STRIBECK),
    "a growing slide": ("stribeck", {"x": 1.87}, {}, STRIBECK),
    "a shaken mass": ("coulomb", {}, {"t_max": 1000.0}, {"u0": 0.5, "omega": 0.85}),
    "a window": ("coulomb", {}, {"t_max": 1000.0}, {"u0": 0.5, "omega": 0.5}),
    "forced sliding": (
        "coulomb",
        {},
        {"t_max": 500.0},
        {"u0": 0.5, "omega": 0.5, "v": 9.0, "c": 0.5},
    ),
    "a drive at rest": ("coulomb", {"x": 30.0}, {}, {"v": 0.0, "c": 0.1}),
}


class InPython:
    """Stands for the compiled looks."""

    def __init__(self) -> None:
        self.calls = 0

    def function(self, address: int) -> int:
        """As the compiled form is called."""
        self.calls += 1
        with np.errstate(all="ignore"):
            return watch.follow_at(address)


def seen(name: str) -> dict[str, Any]:
    """Everything that is told of a case."""
    law, start, given, parameters = CASES[name]
    settings = {"section": Section("event"), "observe": "x", **given}
    found = analyse("belt-1dof", law, "response", start, settings, **parameters)
    return {**found.values, **found.ragged, "reason": found.reason}


@pytest.mark.parametrize("name", CASES)
def test_python_sees_what_the_machine_code_does(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    expected, plain = seen(name), InPython()
    monkeypatch.setattr(steady_state, "FOLLOW", plain)
    found = seen(name)
    assert found.keys() == expected.keys()
    for variable, value in expected.items():
        np.testing.assert_array_equal(found[variable], value, err_msg=variable)
