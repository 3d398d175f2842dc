"""A branch of cycles that turns back where a landing is missed, and goes on without any.

Two torsional inertias of a drill string: the bit rubs on the rock with a falling friction torque.
Its stick-slip is stable up to a fold, turns, is stable again and ends where the bit no longer
sticks; from there an unstable slip goes back. Met by a user whose branch was lost at a tight width.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

from fiv_cli import api
from fiv_cli.analyses.base import Start
from fiv_cli.case.toml import toml_text
from fiv_cli.cli.main import run as fiv
from fiv_cli.dynamics.settings import Section

DRILL = '''"""A bit on rock below a string that a table turns."""

from fiv_cli.models.base import Contact, Equations, Model, Parameter, State


def equations(symbols, options):
    p = symbols.parameter
    (top, bit), speeds = map(symbols.coordinate, "ab"), [*map(symbols.velocity, "ab")]
    string = p("k") * (top - bit) + p("c") * (speeds[0] - speeds[1])
    table = p("k_t") * top + p("c_t") * speeds[0]
    friction = p("r") * symbols.tangential_force(0)
    return Equations(
        accelerations={"a": (-table - string) / p("J_a"), "b": (string + friction) / p("J_b")},
        contacts=(Contact(-p("r") * (p("Omega") + speeds[1]), "b", p("W")),),
        kinetic_energy=(p("J_a") * speeds[0] ** 2 + p("J_b") * speeds[1] ** 2) / 2,
        potential_energy=(p("k_t") * top**2 + p("k") * (top - bit) ** 2) / 2,
    )


NUMBERS = {"J_a": ("kg m2", 40.0), "J_b": ("kg m2", 10.0), "k": ("N m rad-1", 300.0),
           "k_t": ("N m rad-1", 500.0), "r": ("m", 0.1), "W": ("N", 1e4), "Omega": ("rad s-1", 5.2)}
DAMPING = {"c": 2.0, "c_t": 10.0}
MODEL = Model(
    name="drill",
    title="drill string",
    reference="none",
    numerics_version=1,
    parameters=(
        *(Parameter(n, n, unit, value, n) for n, (unit, value) in NUMBERS.items()),
        *(Parameter(n, n, "N m s rad-1", c, n, role="damping") for n, c in DAMPING.items()),
    ),
    states=lambda options: (State("a", "a", "rad", "top"), State("b", "b", "rad", "bit")),
    equations=equations,
    default_law="stribeck",
    law_defaults={"mu_k": 0.23, "mu_s": 0.4, "v_s": 0.1},
    constant_load=True,
)
'''
BRANCH = {
    "schema": 1,
    "model": {"name": "drill"},
    "friction": {"law": "stribeck", "delta": 2},
    "initial": [{"kind": "state", "state": {"b": 0.0}}],
    "analysis": [
        {"kind": "cycle", "parameter": "Omega", "bracket": [4.0, 9.0], "observe": "b"}
        | {"section": {"event": "stick->slip"}}
    ],
}


@pytest.fixture(scope="module")
def drill(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("drill") / "drill.py"
    path.write_text(DRILL)
    return path


@pytest.mark.parametrize("width", [1e-5, 1e-6, 1e-8, 1e-9])
def test_a_branch_is_the_same_however_closely_its_changes_are_looked_for(
    drill: Path, width: float
) -> None:
    case = api.load(BRANCH, {"analysis.0.width": width}, using=drill)
    found = api.run(case, workers=1)
    kinds = api.names_of(found["cycle_end_kind"]).values.tolist()
    assert kinds == ["bracket", "fold", "fold", "grazing", "bracket"]
    known = [4.0, 7.71378754, 7.64377815, 7.99839856, 4.0]
    errors = found["cycle_end_error"].values
    assert (np.abs(found["cycle_end"].values - known) <= errors + 1e-8).all()
    assert (errors <= 20.0 * width).all()
    for end in known:  # the cycles on the way there are kept
        assert np.abs(found["branch_value"].values - end).min() < 0.05


BELT = {"name": "belt-1dof", "parameters": {"c": 0.2, "v": 2.0}}


def belt_case(offset: float, **settings: object) -> dict[str, Any]:
    """A branch along the belt's speed, from a start so far off the sliding equilibrium."""
    cycle = {"kind": "cycle", "parameter": "v", "bracket": [1.0, 3.5], "observe": "x"}
    return {
        "schema": 1,
        "model": BELT,
        "friction": {"law": "stribeck", "mu_s": 0.4, "mu_k": 0.23, "v_s": 0.5, "delta": 1.0},
        "initial": [{"kind": "equilibrium", "offset": {"x": offset}}],
        "analysis": [cycle | {"section": {"zero": "x_dot", "direction": "down"}} | settings],
    }


def overtaking(v: float, c: float = 0.2) -> float:
    """By how much the mass, a slip after its stick ended, would overtake the belt, m/s: SciPy."""

    def rates(_: float, y: np.ndarray) -> list[float]:
        friction = 10.0 * (0.23 + 0.17 * np.exp(-abs(v - y[1]) / 0.5))
        return [y[1], friction - c * y[1] - y[0]]

    def is_fastest(_: float, y: np.ndarray) -> float:
        return rates(0.0, y)[1]

    is_fastest.direction = -1.0  # type: ignore[attr-defined]
    start = [10.0 * 0.4 - c * v, v]
    accuracy = {"method": "DOP853", "rtol": 1e-13, "atol": 1e-13}
    slip = solve_ivp(rates, (0.0, 8.0), start, events=is_fastest, **accuracy)
    return float(slip.y_events[0][slip.t_events[0] > 1.0][0, 1]) - v


@pytest.mark.parametrize(("offset", "settings"), [(2.2, {}), (1.9, {"t_max": 15.0})])
def test_stick_slip_and_the_unstable_cycle_within_it_are_one_branch(
    offset: float, settings: dict[str, object]
) -> None:
    """From either of them: one begins at the Hopf point, and they meet where a slip grazes."""
    found = api.run(api.load(belt_case(offset, **settings)), workers=1)
    kinds = api.names_of(found["cycle_end_kind"]).values
    places = np.argsort(kinds)
    assert kinds[places].tolist() == ["bracket", "equilibrium", "grazing"]
    hopf = 0.5 * np.log(10.0 * (0.4 - 0.23) / (0.5 * 0.2))
    known = [1.0, hopf, brentq(overtaking, 2.5, 2.8, xtol=1e-11)]
    errors = found["cycle_end_error"].values[places]
    assert (np.abs(found["cycle_end"].values[places] - known) <= errors + 1e-9).all()
    assert {*api.names_of(found["branch_stable"]).values.tolist()} >= {"stable", "unstable"}


def test_at_any_damping_a_branch_of_stick_slip_goes_on_to_the_equilibrium() -> None:
    """At those of 0.35 to 0.55 N s/m it ended at its grazing, though its cycle went on."""
    damping = np.linspace(0.3, 0.6, 7)
    law = {"law": "stribeck", "mu_s": 0.4, "mu_k": 0.2, "v_s": 0.5, "delta": 1.0}
    cycle = {
        "kind": "cycle", "section": {"zero": "x_dot", "direction": "down"}, "observe": "x",
        "parameter": "v", "bracket": [0.1, 9.0], "width": 1e-8,
    }  # fmt: skip
    case = {
        "schema": 1, "friction": law, "grid": {"c": damping.tolist()}, "analysis": [cycle],
        "model": {"name": "belt-1dof", "parameters": {"N": 10.0, "v": 0.3}},
    }  # fmt: skip
    found = api.run(api.load(case), workers=1)
    is_rest = api.names_of(found["cycle_end_kind"]).values == "equilibrium"
    hopf = 0.5 * np.log(0.2 * 10.0 / (0.5 * damping))
    assert found["cycle_end"].values[is_rest] == pytest.approx(hopf, abs=1e-6)


def test_what_leads_to_a_corner_is_no_part_of_the_way_from_it() -> None:
    """At some dampings the stable part came twice, and `stable_highest` was the Hopf point."""
    cycle = {
        "kind": "cycle", "section": {"zero": "x_dot", "direction": "down"}, "observe": "x",
        "parameter": "v", "bracket": [0.3, 8.0], "width": 1e-8,
    }  # fmt: skip
    case = {
        "schema": 1,
        "model": {"name": "belt-1dof", "parameters": {"N": 10.0, "v": 0.4}},
        "friction": {"law": "stribeck", "mu_s": 0.4, "mu_k": 0.23, "v_s": 0.5, "delta": 1.0},
        "grid": {"c": [1.0, 1.001]},
        "analysis": [cycle],
    }
    found = api.run(api.load(case), workers=1)
    known = [brentq(overtaking, 0.6, 0.8, (c,), xtol=1e-11) for c in found["c"].values]
    errors = found["stable_highest_error"].values[:, 0]
    assert (np.abs(found["stable_highest"].values[:, 0] - known) <= errors + 1e-8).all()
    stable = api.names_of(found["branch_stable"]).values == "stable"
    for number in (0, 1):
        own = found["branch_point"].values == number
        rising = np.diff(found["branch_value"].values[own]) > 0.0
        np.testing.assert_array_equal(rising[:-1], stable[own][1:-1])  # there, and back from it


@pytest.mark.parametrize("bracket", [(0.01, 10.0), (1.0, 2.5), (1.6, 1.9)])
def test_a_branch_leads_to_the_corner_it_is_gone_on_from_in_steps(
    bracket: tuple[float, float],
) -> None:
    """Where the contact begins to be lost, a multiplier grows without bound towards the corner.

    In a short bracket the branch ended there; in others a straight line of 0.07 m/s led on.
    """
    case = {
        "schema": 1,
        "model": {"name": "flutter-2dof", "options": {"states": "all"}}
        | {"parameters": {"c1": 0.1, "c2": 0.1, "v": 1.75}},
        "friction": {"law": "coulomb", "mu_k": 5.0},
        "initial": [{"kind": "equilibrium", "offset": {"x": 3.0}}],
        "analysis": [
            {"kind": "cycle", "parameter": "v", "bracket": [*bracket], "observe": "x"}
            | {"section": {"zero": "x_dot", "direction": "down"}, "t_max": 1000.0}
        ],
    }
    found = api.run(api.load(case), workers=1)
    kinds = api.names_of(found["cycle_end_kind"]).values.tolist()
    assert kinds == ["bracket", "grazing", "fold", "bracket"]
    ends, errors = found["cycle_end"].values, found["cycle_end_error"].values
    known = [bracket[0], 1.7831889, 1.6764161, bracket[1]]
    assert (np.abs(ends - known) <= errors + 1e-7).all()
    value, at_section = found["branch_value"].values, found["branch_section"].values
    turn, fold = np.argmin(np.abs(value - ends[1])), np.argmin(np.abs(value - ends[2]))
    way = slice(turn + 1, fold + 1)
    assert (api.names_of(found["branch_stable"]).values[way][:-1] == "unstable").all()
    assert at_section[way][0] == pytest.approx(at_section[turn], abs=1e-3)
    assert np.interp(-1.75, -value[way], at_section[way]) == pytest.approx(3.2641, abs=2e-3)
    assert np.abs(np.diff(value[way])).max() < 0.05
    assert abs(value[way][0] - value[turn]) < 0.01


@pytest.mark.parametrize(
    ("offset", "direction", "t_max"),
    [({"x": 1.3}, "down", 15.0), ({"x_dot": 1.0}, "both", 8.0), ({"x": 1.0}, "both", 100.0)],
)
def test_of_no_cycle_it_is_told_on_which_side_of_one_that_repels_it_lies(
    offset: dict[str, float], direction: str, t_max: float
) -> None:
    """That one has an amplitude of 1.71; the first of these is followed on for it."""
    law = {"mu_s": 0.4, "mu_k": 0.23, "v_s": 0.5, "delta": 1.0}
    section = Section("zero", state="x_dot", direction=direction)
    settings, start = {"section": section, "t_max": t_max}, Start("near", "equilibrium", offset)
    found = api.analyse("belt-1dof", "stribeck", "cycle", start, settings, c=0.2, v=2.0, **law)
    assert found.reason == "no_cycle"
    told = (
        ": so far it dies away, to where a longer t_max shows; a start beside a cycle that repels "
    )
    assert found.message.endswith(f"{told}swings by more at first")


def test_where_a_branch_has_no_first_cycle_another_beginning_is_told(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """At 3 m/s the mass comes to rest; it sticks and slips below 2.65 m/s."""
    case = tmp_path / "a.toml"
    case.write_text(
        toml_text(belt_case(2.2) | {"model": BELT | {"parameters": {"c": 0.2, "v": 3.0}}})
    )
    assert fiv(["run", str(case), "--workers", "1", "-o", str(tmp_path / "a.nc")]) == 0
    assert "; at v = 2 there is one: let the branch begin there" in capsys.readouterr().err
