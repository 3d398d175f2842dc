"""What ``fiv show`` and `api.observations` tell of a part of a dataset."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest
import xarray as xr
from small_cases import BELT

from fiv_cli import api
from fiv_cli.case.toml import parse_toml, toml_text
from fiv_cli.cli.main import run as fiv
from fiv_cli.errors import UsageError
from fiv_cli.reading.table import _holding

GRID = {"v": [0.1 * k for k in range(1, 11)], "N": [5.0, 10.0]}


@pytest.fixture(scope="module")
def stored(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A dataset of two analyses over two axes."""
    path = tmp_path_factory.mktemp("show") / "a.nc"
    case = parse_toml(BELT)
    case["grid"], case["analysis"] = GRID, [*case["analysis"], {"kind": "eigenvalues"}]
    api.run(api.load(case), output=path)
    return path


def shown(capsys: pytest.CaptureFixture[str], *command: object) -> Any:
    capsys.readouterr()
    assert fiv([*map(str, command), "--json"]) == 0
    return json.loads(capsys.readouterr().out)["analyses"]


def test_a_point_is_shown_alone(stored: Path, capsys: pytest.CaptureFixture[str]) -> None:
    one = shown(capsys, "show", stored, "--at", "v=0.3,N=10", "--at", "initial=rest")
    whole = api.read(stored)
    for name, told in one.items():
        part = whole[name].sel(v=GRID["v"][2], N=10.0)
        assert set(told["dims"].values()) == {1}
        for variable in ("section_value", "period") if name == "response" else ("growth_rate",):
            span = told["ranges"][variable]
            assert span["least"] == span["greatest"] and span["values"] == 1
        if name == "eigenvalues":
            modes = part["eigenvalue_imag"].values.tolist()
            assert told["ranges"]["eigenvalue_imag"]["each"] == modes


def test_points_are_shown_where_a_condition_holds(
    stored: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    some = shown(capsys, "show", stored, "--at", "v=. >= 0.85")
    assert [part["dims"]["v"] for part in some.values()] == [2, 2]


OFF = [
    ({"v": 0.32}, "v: 10 values from 0.1 to 1; the nearest is 0.3"),
    ({"v": ". > 2"}, "v: 10 values from 0.1 to 1"),
    ({"N": "7 N"}, "N: 5, 10"),
    ({"initial": "far"}, "initial: rest"),
    ({"speed": 1}, "speed: no axis of this dataset\nits axes: v, N, initial"),
]


@pytest.mark.parametrize(("at", "there"), OFF)
def test_off_the_grid_is_told_what_there_is(
    at: dict[str, Any], there: str, stored: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    place = ",".join(f"{name}={value}" for name, value in at.items())
    assert fiv(["show", str(stored), "--at", place]) != 0
    assert there in capsys.readouterr().err
    with pytest.raises(api.UsageError) as refused:
        api.observations(stored, "section_value", **at)
    assert there in str(refused.value)


def test_several_places_are_told_to_be_all_combinations(
    stored: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    first, last = GRID["v"][0], GRID["v"][-1]
    assert fiv(["show", str(stored), "--at", f"v={first},N=10", "--at", f"v={last},N=10"]) == 0
    assert "combination" not in capsys.readouterr().err
    assert fiv(["show", str(stored), "--at", f"v={first},N=10", "--at", f"v={last},N=5"]) == 0
    told = capsys.readouterr().err
    assert f"--at: every combination of v = {first}, {last} and N = 10, 5" in told


def test_values_are_taken_at_some_points(stored: Path) -> None:
    every = api.observations(stored, "section_value")
    some = api.observations(stored, "section_value", v=[0.3, ". >= 0.95"], N="10 N")
    kept = (every["v"].isin([GRID["v"][2], 1.0]) & (every["N"] == 10.0)).values
    assert some.identical(every[kept]) and 0 < some.size < every.size
    mass = float(every["m"][0])
    assert api.observations(stored, "section_value", m=mass).identical(every)


FOLLOWED = {
    "schema": 1,
    "model": {"name": "pin-on-disc", "parameters": {"N0": 30.0}},
    "grid": {"c1": [0.001, 0.005], "mu_k": [0.23, 0.9]},  # the last above mu_s: not computed
    "initial": [{"kind": "state", "state": {"phi_dot": "Omega"}}],
}
PERIODIC = {"variable": "attractor", "expect": "periodic"}


@pytest.mark.parametrize(
    ("follow", "of", "said"),
    [
        ("up", PERIODIC, ["still periodic at the upper end of the bracket at 1 of 4 points"]),
        (
            "both",  # stick-slip ends at one point on the way up, the other has it both ways
            PERIODIC,
            [
                f"still periodic at the {end} end of the bracket at 1 of 4"
                for end in ("upper", "lower")
            ],
        ),
        (
            "up",  # an equilibrium is asked for, and has not ended either where it was found
            PERIODIC | {"expect": "equilibrium"},
            [f"still {name} at the upper end" for name in ("equilibrium", "periodic")],
        ),
        ("none", PERIODIC, []),
    ],
)
def test_what_was_followed_to_the_end_of_a_bracket_is_told(
    follow: str,
    of: dict[str, str],
    said: list[str],
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
) -> None:
    settings = {"parameter": "Omega", "bracket": [2.0, 5.0], "follow": follow, "of": of}
    case = tmp_path / "a.toml"
    case.write_text(toml_text(FOLLOWED | {"analysis": [{"kind": "boundary", **settings}]}))
    assert fiv(["run", str(case), "-o", str(tmp_path / "a.nc"), "--workers", "1"]) == 0
    ended = capsys.readouterr().err
    assert fiv(["show", str(tmp_path / "a.nc")]) == 0
    shown = capsys.readouterr().out
    assert "  not_computed, mu_k_above_mu_s\n" in shown
    for told in (ended, shown):
        lines = [line.strip() for line in told.splitlines() if "    still " in line]
        assert len(lines) == len(said) and all(map(str.startswith, lines, said))
        endings = (": widen it", ", and perhaps beyond; what was found inside it stands")
        unmet = (
            ": what is asked for was not met inside it: a start in its basin (a `state`, say) "
            "meets it, or a bracket that is wider at either end"
        )
        for line in lines:
            met = line.startswith(f"still {of['expect']} ")
            assert line.endswith(endings if met else unmet)


FRICTIONLESS_TO_DAMPED = {
    "schema": 1,
    "model": {"name": "belt-1dof"},
    "grid": {"c": [0.0, 0.05, 0.5]},
    "initial": [{"label": "far", "kind": "state", "state": {"x": 1.0}}],
    "analysis": [{"kind": "cycle", "parameter": "v", "bracket": [0.5, 4.0]}],
}


def test_where_branches_begin_and_end_is_told(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """A branch begins at the case's own speed: check says so, where nothing was found the run."""
    case, output = tmp_path / "a.toml", tmp_path / "a.nc"
    case.write_text(toml_text(FRICTIONLESS_TO_DAMPED))
    assert fiv(["check", str(case)]) == 0
    planned = capsys.readouterr().out
    assert ", v = 1, " in planned and "both ways from the case's own 1.0\n" in planned
    assert fiv(["run", str(case), "-o", str(output), "--workers", "1"]) == 0
    ended = capsys.readouterr().err
    assert "\n      c=0.5,initial=far: at v = 1 the motion returns last at t = " in ended
    assert "; between them x rests; followed up to t = " in ended
    found = api.read(output)
    for place in ([], ["--at", "c=0.05"]):
        told = shown(capsys, "show", output, *place)[""]
        assert told["branches_begin"] == "v = 1 m s-1"
        rows = [row for row in told["branch_ends"] if row.get("c", 0.05) == 0.05]
        ends = api.observations(found, "cycle_end", c=0.05).values.tolist()
        assert [row["cycle_end"] for row in rows] == ends and len(ends) == 2
        assert [row["cycle_end_direction"] for row in rows] == [-1, 1]
        assert {row["cycle_end_goes_on"] for row in rows} == {"no"}
        assert [row["cycle_end_kind"] for row in rows] == ["bracket", "grazing"]
        assert [row["cycle_end_event"] for row in rows] == [None, "stick"]
        assert [row["cycle_end_contact"] for row in rows] == [0, 1]
    assert fiv(["check", str(case), "--set", "model.parameters.v=9.0"]) == 3
    assert "from v = 9.0, the case's own, which lies outside" in capsys.readouterr().err


def test_a_name_that_is_missing_is_sought_beside_those_that_are_there() -> None:
    told = {
        "response": ["response_frequency", "L_s"],
        "eigenvalues": ["growth_rate", "mode_frequency"],
    }
    held = {kind: xr.Dataset(dict.fromkeys(names, 0.0)) for kind, names in told.items()}
    with pytest.raises(UsageError, match="'frequency'; here it is 'mode_frequency'"):
        _holding(held, ["growth_rate", "frequency"])
    with pytest.raises(UsageError, match="here it is 'response_frequency' or 'mode_frequency'"):
        _holding(held, ["frequency"])
