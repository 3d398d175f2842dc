"""Starts in the dataset: where every motion began, whatever kind of start it had."""

from __future__ import annotations

import json
import pickle
import tomllib
from pathlib import Path

import numpy as np
import pytest
import xarray as xr

from fiv_cli import api
from fiv_cli.case.case import Case
from fiv_cli.case.identity import differences, document, fingerprint
from fiv_cli.cli.main import run as fiv
from fiv_cli.errors import CaseError
from fiv_cli.sweep.plan import make_plan

KINDS = """
schema = 1
[model]
name = "belt-1dof"
[model.parameters]
c = 0.05
[grid]
v = [2.0, 3.0]
[[initial]]
kind = "equilibrium"
offset = { x = 0.1 }
[[initial]]
kind = "state"
state = { x = 10.0, x_dot = "v" }
[[initial]]
kind = "random"
count = 3
box = { x = [4.0, 6.0], x_dot = [-1.0, 1.0] }
[[initial]]
label = "up"
kind = "continue"
along = "v"
from = "state"
[[analysis]]
kind = "response"
t_max = 200.0
[[analysis]]
kind = "spectrum"
t_max = 200.0
f_max = 1.0
"""


def test_the_state_that_a_motion_began_in_is_stored_for_every_kind_of_start() -> None:
    results = api.run(api.load(tomllib.loads(KINDS)), workers=1)
    found = results["response"]
    xr.testing.assert_identical(results["spectrum"]["initial_state"], found["initial_state"])
    begun = found["initial_state"].transpose("v", "initial", "state")
    at = {str(label): begun.sel(initial=label).values for label in found["initial"].values}
    rest = found["L_s_reference"].sel(initial="equilibrium", state="x").values
    np.testing.assert_allclose(at["equilibrium"], np.column_stack([rest + 0.1, [0.0, 0.0]]))
    assert at["state"].tolist() == [[10.0, 2.0], [10.0, 3.0]]
    drawn = np.array([at[f"random-{i:03d}"] for i in range(3)])
    assert (np.abs(drawn - [5.0, 0.0]) < 1.0).all() and len(np.unique(drawn[..., 0])) == 6
    assert at["up"][0].tolist() == at["state"][0].tolist()
    # a contact that sticks takes on the belt's new velocity
    ends = found.sel(initial="up", v=2.0)
    assert float(ends["x_min"]) <= at["up"][1][0] <= float(ends["x_max"])


SLOWING = """
schema = 1
[model]
name = "belt-1dof"
[schedule]
v = { start = 2.0, stop = 1.0, over = 200.0 }
[[initial]]
kind = "equilibrium"
offset = { x = 0.1 }
[[initial]]
kind = "random"
count = 2
box = { x = [4.0, 6.0], x_dot = [-1.0, 1.0] }
[[analysis]]
kind = "history"
t_end = 1.0
[[analysis]]
kind = "spectrogram"
f_max = 1.0
resolution = 0.05
"""


def test_motions_and_spectrograms_keep_their_starts_too() -> None:
    asked = tomllib.loads(SLOWING) | {"figure": [{"kind": "spectrogram"}]}
    results = api.run(api.load(asked), workers=1)
    motion = results["history"]
    assert motion["initial_state"].sizes == {"initial": 3, "state": 2}
    for state in ("x", "x_dot"):
        begun = motion["initial_state"].sel(state=state).values
        assert begun.tolist() == motion[state].isel(time=0).values.tolist()
    xr.testing.assert_identical(motion["initial_state"], results["spectrogram"]["initial_state"])
    (mesh,) = api.figure(results, "spectrogram").axes[0].collections  # not one of the history
    assert mesh.get_array().size == results["spectrogram"]["spectrogram"].isel(initial=0).size


HALVES = """
schema = 1
[model]
name = "belt-1dof"
[grid]
v = [1.0]
omega = [1.0, 2.0]
[[initial]]
label = "begun"
kind = "state"
state = { x = 6.0 }
[[initial]]
label = "on"
kind = "continue"
along = "omega"
from = "begun"
on_loss = "go-on"
[[analysis]]
kind = "history"
t_end = 8.0
sample = 0.5
"""


def test_a_motion_goes_on_from_the_end_of_the_one_before() -> None:
    """The base is at rest, so that its frequency changes nothing: two halves are the whole."""
    case = tomllib.loads(HALVES)
    first, second = (
        api.run(api.load(case), workers=1).sel(initial="on", omega=omega, v=1.0)
        for omega in (1.0, 2.0)
    )
    case["analysis"][0]["t_end"] = 16.0
    whole = api.run(api.load(case), workers=1).sel(initial="begun", omega=1.0, v=1.0)
    halves = np.concatenate([first["x"], second["x"][1:]])
    np.testing.assert_allclose(halves, whole["x"], atol=1e-9)
    assert {*whole["contact_state"].values.tolist()} > {0}  # it sticks and slips


SWEPT = """
schema = 1
[model]
name = "belt-1dof"
[model.parameters]
c = 0.1
[friction]
mu_s = 0.4
mu_k = 0.2
[grid]
v = { start = 0.5, stop = 5.0, num = 10 }
[[initial]]
label = "far"
kind = "state"
state = { x = 10.0 }
[[initial]]
label = "near"
kind = "equilibrium"
[[initial]]
label = "up"
kind = "continue"
along = "v"
from = "far"
on_loss = "go-on"
[[initial]]
label = "down"
kind = "continue"
along = "v"
direction = "down"
from = "near"
on_loss = "go-on"
[[analysis]]
kind = "response"
"""


def test_a_hysteresis_sweep_carries_the_motion_on_whatever_its_class() -> None:
    """Up, stick-slip is lost to rest; down, rest stays: every point as when begun there alone."""
    found = api.run(api.load(tomllib.loads(SWEPT)), workers=1)
    classes = api.names_of(found["attractor"])
    up, down = (classes.sel(initial=label).values.tolist() for label in ("up", "down"))
    assert set(down) == {"equilibrium"} and (found["status"] == 0).all()
    lost = up.index("equilibrium")
    assert up == ["periodic"] * lost + ["equilibrium"] * (len(up) - lost) and 0 < lost < len(up)
    begun = found["initial_state"].sel(initial="up")
    for point, told in zip(begun.transpose("v", "state"), up, strict=True):
        start, v = dict(zip(begun["state"].values, point.values, strict=True)), float(point["v"])
        alone = api.analyse(
            "belt-1dof", "coulomb", "response", start, v=v, c=0.1, mu_s=0.4, mu_k=0.2
        )
        assert alone.values["attractor"] == told
    rested = found["L_s_reference"].sel(initial="up", state="x").values[lost:-1]
    assert begun.sel(state="x").values[lost + 1 :].tolist() == rested.tolist()


@pytest.mark.parametrize("steps", ["grid", "shorter"])
def test_a_sweep_in_steps_of_the_grid_is_one_by_hand(steps: str) -> None:
    """A step of 0.8 throws stick-slip into the basin of rest; shorter ones come through to it."""
    case = tomllib.loads(SWEPT)
    case["grid"]["v"] = [1.0, 1.8]
    case["friction"] = {"law": "stribeck", "mu_s": 1.0, "mu_k": 0.5, "v_s": 0.5}
    case["model"] = {"name": "belt-1dof", "parameters": {"N": 1.0, "c": 0.1}}
    case["initial"][2]["steps"] = steps
    found = api.run(api.load(case), workers=1)
    begun = found["initial_state"].sel(initial="up", v=1.8)
    start = dict(zip(begun["state"].values, begun.values, strict=True))
    laws = {"mu_s": 1.0, "mu_k": 0.5, "v_s": 0.5, "N": 1.0, "c": 0.1}
    far = api.analyse("belt-1dof", "stribeck", "response", {"x": 10.0}, v=1.0, **laws)
    assert far.carry is not None
    literal = np.allclose(list(start.values()), far.carry["state"], rtol=0.0, atol=0.0)
    assert literal == (steps == "grid")
    there = api.analyse("belt-1dof", "stribeck", "response", start, v=1.8, **laws)
    told = api.names_of(found["attractor"]).sel(initial="up", v=1.8).item()
    assert (
        told == there.values["attractor"] == {"grid": "equilibrium", "shorter": "periodic"}[steps]
    )


TABLE = """
schema = 1
[model]
name = "belt-1dof"
[[initial]]
label = "basin"
kind = "table"
{starts}
[[analysis]]
kind = "response"
t_max = 100.0
"""


def table(folder: Path, content: str | None = None, starts: str = 'file = "starts.csv"') -> Case:
    """A case whose starts are a table, in a file of this content or in the case itself."""
    if content is not None:
        (folder / "starts.csv").write_text(content, encoding="utf-8")
    (folder / "case.toml").write_text(TABLE.format(starts=starts))
    return api.load(folder / "case.toml")


def test_a_table_of_starts_is_a_start_for_each_row(tmp_path: Path) -> None:
    filed = table(tmp_path, "x_dot [cm/s], x\n50, 1.0\n\n-20, 25 mm\n0, 1.0\n50, 1.0\n")
    rows = '{ x = 1, x_dot = 0.5 }, { x = "25 mm", x_dot = -0.2 }, { x = 1, x_dot = 0 }'
    inline = table(tmp_path, None, f"states = [{rows}, {{ x = 1, x_dot = 0.5 }}]")
    found = api.run(filed, workers=1)
    begun = found["initial_state"].transpose("initial", "state").values.tolist()
    assert begun == [[1.0, 0.5], [0.025, -0.2], [1.0, 0.0], [1.0, 0.5]]
    other = table(tmp_path, "# x_dot [cm/s]; x [mm]\r\n50;1 m\r\n-20;25\r\n0;1000\r\n50;1e3\r\n")
    assert fingerprint(other) == fingerprint(filed)
    assert found["initial"].values.tolist() == [f"basin-{i:03d}" for i in range(4)]
    assert (found["status"] == 0).all() and fingerprint(filed) == fingerprint(inline)
    xr.testing.assert_identical(found.drop_attrs(), api.run(inline, workers=1).drop_attrs())


def test_a_table_of_one_row_is_no_axis_and_a_mistake_in_it_is_told_alone(tmp_path: Path) -> None:
    """A heading that was wrong had a figure over the starts told wrong, too."""
    over = '[grid]\nv = [1.0, 2.0]\n[[figure]]\nkind = "map"\nx = "v"\ny = "initial"\n'
    starts = f'file = "starts.csv"\n{over}'
    with pytest.raises(CaseError, match="there is one start alone, which is no axis") as told:
        table(tmp_path, "x\n1.0\n", starts)
    assert "a table of several rows" in str(told.value)
    with pytest.raises(CaseError, match="there is no state 'x_dt'") as told:
        table(tmp_path, "x_dt\n1.0\n", starts)
    assert "one start" not in str(told.value)
    table(tmp_path, "x\n1.0\n2.0\n", starts)
    select = 'select = { initial = "basin 001" }\n'  # as a legend has it
    with pytest.raises(CaseError, match="did you mean 'basin-001'"):
        table(tmp_path, "x\n1.0\n2.0\n", starts + select)


def test_a_changed_file_is_another_case(tmp_path: Path) -> None:
    before = table(tmp_path, "x\n1.0\n2.0\n")
    after = table(tmp_path, "x\n1.0\n2.5\n")
    assert fingerprint(before) != fingerprint(after)
    (told,) = differences(document(before), after)
    assert told.startswith("starts.basin.rows: stored")


def test_thousands_of_starts_are_no_burden(tmp_path: Path) -> None:
    rows = "".join(f"{i / 1000},{-i}\n" for i in range(5000))
    (plan,) = make_plan(table(tmp_path, "x,x_dot\n" + rows)).analyses
    assert plan.size == 5000 and len(np.unique(plan.keys(), axis=0)) == 5000
    assert len(pickle.dumps(plan.template)) < 1_000_000
    assert len(json.dumps(document(table(tmp_path)))) < 10_000


@pytest.mark.parametrize(
    ("content", "place", "message"),
    [
        ("x, x_dot\n1, 2\n3, fast\n", '"row 3".x_dot', "'fast' is not a number"),
        ("x [mm]\n1\n2 s\n", '"row 3".x', "does not fit"),
        ("x, speed\n1, 2\n", "file.speed", "there is no state 'speed'"),
        ("x [mm], label\n1 cm, a\n", "file.label", "there is no state 'label'"),
        ("x, x\n1, 2\n", "file", "the column x stands in it twice"),
        ("x, x_dot\n1, 2\n3\n", "file", "row 3 has 1 cells, and the header 2"),
        ("x\n\n", "file", "holds no starts"),
        ("x; x_dot\n1,5; 0\n", '"row 2".x', "decimals stand behind a point"),
        ("[]\n1\n", "file", "'[]' in its header is no state"),
        (None, "file", "cannot be read: No such file"),
    ],
)
def test_what_is_wrong_in_a_file_of_starts_is_told_with_row_and_column(
    tmp_path: Path, content: str | None, place: str, message: str
) -> None:
    with pytest.raises(CaseError) as caught:
        table(tmp_path, content)
    (problem,) = caught.value.problems
    assert problem.path.endswith(place) and message in problem.message and problem.line == 8


@pytest.mark.parametrize("starts", ["", 'file = "starts.csv"\nstates = [{ x = 1 }]'])
def test_a_table_stands_in_the_case_or_in_a_file(tmp_path: Path, starts: str) -> None:
    with pytest.raises(CaseError, match=r"needs its states, or a file|has both states and a file"):
        table(tmp_path, "x\n1\n", starts)


def test_a_start_takes_the_opposite_of_a_parameter_too() -> None:
    """At each point, and along what is bisected: a bit at rest on rock, seen from the table."""
    start = {"kind": "state", "state": {"x": 1.0, "x_dot": "-v"}}
    case = {"schema": 1, "model": {"name": "belt-1dof"}, "initial": [start]}
    swept = api.load(case | {"grid": {"v": [0.5, 1.0]}, "analysis": [{"kind": "response"}]})
    found = api.run(swept, workers=1)["initial_state"].sel(state="x_dot")
    assert found.values.ravel().tolist() == [-0.5, -1.0]
    start["state"]["x_dot"] = "-w"
    with pytest.raises(CaseError, match="there is no parameter 'w'"):
        api.load(case | {"analysis": [{"kind": "response"}]})


def test_labels_of_several_words_serve_wherever_a_label_does(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    text = """\
schema = 1
[model]
name = "belt-1dof"
[grid]
v = [0.5, 1.0]
[[initial]]
label = "from rest"
kind = "state"
[[initial]]
label = "any start"
kind = "random"
count = 3
box = { x = [-1, 1] }
[[initial]]
label = "up again"
kind = "continue"
along = "v"
from = "from rest"
[[analysis]]
kind = "response"
[[figure]]
kind = "curve"
variable = "attractor"
select = { initial = ["from rest", "up again"] }
[[claim]]
source = "here"
text = "it vibrates"
variable = "attractor"
at = { initial = "from rest" }
expect = "periodic"
"""
    Path("a.toml").write_text(text)
    assert fiv(["run", "a.toml", "--workers", "1", "-q"]) == 0
    assert fiv(["claims", "a.toml"]) == 0
    assert fiv(["plot", "runs/a.nc"]) == 0
    assert (
        fiv(["run", "a.toml", "-q", "--set", 'initial."from rest".state.x=0.1', "-o", "b.nc"]) == 0
    )
    capsys.readouterr()
    assert fiv(["show", "runs/a.nc", "--csv", "attractor", "--at", "initial=any start-001"]) == 0
    assert capsys.readouterr().out.splitlines()[1] == "0.5,any start-001,periodic"
    assert fiv(["history", "a.toml", "--at", "v=1"]) != 0
    assert "--at 'initial=from rest' or --at 'initial=any start-000'" in capsys.readouterr().err
    for wrong in ("from  rest", " rest", "a,b"):
        Path("a.toml").write_text(text.replace("up again", wrong))
        assert fiv(["check", "a.toml"]) == 3
