"""What a stiff law will cost, said before the run, against the steps that are counted."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from motions import defaults, motion

from fiv_cli import api
from fiv_cli.analyses.base import Outcome, SolverSettings
from fiv_cli.analyses.rest.stiffness import cost_of
from fiv_cli.codegen.setup import Setup
from fiv_cli.sweep.stiff import DEAR, stiff_laws

FAST = SolverSettings()


def steps(model: str, law: str, t_end: float, **given: float) -> int:
    """Steps from rest to `t_end`."""
    begun = motion(model, law, {}, FAST, **given)
    begun.run(t_end)
    return begun.n_steps


@pytest.mark.parametrize(
    ("model", "law", "t_end", "given"),
    [
        ("belt-1dof", "dahl", 60.0, {"sigma_0": 1e3, "v": 0.5, "N": 1.0}),
        ("belt-1dof", "lugre", 60.0, {"sigma_0": 1e4, "sigma_1": 30.0, "v_s": 0.1, "v": 0.5}),
        ("belt-2mass", "lugre", 30.0, {"sigma_0": 1e3, "v_s": 0.1}),
        ("belt-1dof", "bristle", 60.0, {"delta_b": 1e-3, "v": 0.5, "N": 1.0}),
        ("pin-on-disc", "dahl", 0.3, {"sigma_0": 1e5, "Omega": 5.0, "mu_k": 0.2}),
    ],
)
def test_the_cost_of_a_stiff_law_is_told_from_its_fastest_rate(
    model: str, law: str, t_end: float, given: dict[str, float]
) -> None:
    """Within a factor of two where the contact slides most of the time."""
    own = {name: given[name] for name in given if name in defaults(model, "coulomb")}
    counted = steps(model, law, t_end, **given) / steps(model, "coulomb", t_end, **own)
    parameters = defaults(model, law, **given)
    cost = cost_of(Setup.of(model, law, parameters=parameters), [parameters])
    assert counted > DEAR
    assert 0.5 < counted / cost.sliding[0] < 2.0


@pytest.mark.parametrize(
    ("law", "given"),
    [
        ("tanh of coulomb", {"sigma": 1e3}),
        ("simscape", {}),
        ("linear-regularisation", {"v_tol": 1e-3}),
        ("jenkins", {"sigma_0": 1e5}),
    ],
)
def test_what_a_smooth_law_costs_at_rest_is_told_as_a_bound(
    law: str, given: dict[str, float]
) -> None:
    """The belt carries the mass along, a part of the time."""
    counted = steps("belt-1dof", law, 60.0, v=0.5, **given) / steps(
        "belt-1dof", "coulomb", 60.0, v=0.5
    )
    parameters = defaults("belt-1dof", law, v=0.5, **given)
    cost = cost_of(Setup.of("belt-1dof", law), [parameters])
    assert cost.sliding[0] < 1.0 < 10.0 < counted < cost.resting[0]


def stiff(**friction: Any) -> list[str]:
    """What is said of the laws of a case of the belt."""
    case = {
        "schema": 1,
        "model": {"name": "belt-1dof"},
        "friction": friction,
        "grid": {"friction": ["coulomb", "stribeck", "lugre", "tanh"], "v": [0.5, 1.0, 2.0]},
        "analysis": [{"kind": "response"}, {"kind": "eigenvalues"}],
    }
    return stiff_laws(api.check(api.load(case)).analyses)


def test_a_law_that_costs_a_hundredfold_says_so_where_it_costs_most() -> None:
    assert stiff(sigma_0=20.0, sigma=50.0) == []
    said = stiff(sigma_0=1e4, sigma=1e4)
    assert said[0] == (
        "lugre is stiff: some 20,000 times the steps of coulomb "
        "(at friction=lugre,v=2.0,initial=rest)"
    )
    assert said[1].startswith("tanh of coulomb is stiff: up to 7,000 times the steps of coulomb, ")


def test_rate_and_state_is_as_stiff_at_rest_as_can_be_said() -> None:
    case = {
        "schema": 1,
        "model": {"name": "belt-1dof", "parameters": {"v": 0.01}},
        "friction": {"law": "rate-and-state"},
        "analysis": [{"kind": "response"}],
    }
    (said,) = stiff_laws(api.check(api.load(case)).analyses)
    assert "up to 1,000,000,000 times" in said and "nearly rests" in said


@pytest.mark.parametrize(
    ("kind", "settings"),
    [("response", {"t_max": 50.0}), ("history", {"t_end": 2.0, "sample": 0.1})],
)
def test_steps_that_do_not_move_the_time_are_not_made(kind: str, settings: Any) -> None:
    """They end a run at once with a reason of its own, as if all that are allowed were made."""

    def found(most: int) -> Outcome:
        asked = "belt-1dof", "tanh of coulomb", kind, {"x": 1.0}, settings
        return api.analyse(*asked, solver=SolverSettings(max_steps=most), sigma=1e17)

    few, all_of_them = found(2000), found(10**9)
    assert (few.status, few.reason) == ("budget", "too_many_steps")
    assert (all_of_them.status, all_of_them.reason) == ("budget", "time_stands_still")
    assert all_of_them.values.pop("n_steps") == 10**9 and few.values.pop("n_steps") == 2000
    for name, value in few.values.items():
        np.testing.assert_array_equal(all_of_them.values[name], value)
