"""What ``fiv show`` and `api.observations` tell of a part of a dataset."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest
from small_cases import BELT

from fiv_cli import api
from fiv_cli.case.toml import parse_toml
from fiv_cli.cli.main import run as fiv

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


def test_values_are_taken_at_some_points(stored: Path) -> None:
    every = api.observations(stored, "section_value")
    some = api.observations(stored, "section_value", v=[0.3, ". >= 0.95"], N="10 N")
    kept = (every["v"].isin([GRID["v"][2], 1.0]) & (every["N"] == 10.0)).values
    assert some.identical(every[kept]) and 0 < some.size < every.size
    mass = float(every["m"][0])
    assert api.observations(stored, "section_value", m=mass).identical(every)
