"""The way in from Python: the steps of the commands, on xarray objects, with the same errors."""

from __future__ import annotations

import contextlib
import doctest
import subprocess
import sys
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr
from hypothesis import given
from hypothesis import strategies as st
from matplotlib.figure import Figure

from fiv_cli import api, errors
from fiv_cli.analyses.base import Section
from fiv_cli.case.identity import fingerprint
from fiv_cli.case.toml import parse_toml, toml_text
from fiv_cli.cli.main import run as command
from fiv_cli.models import get_model
from fiv_cli.plots.drawing import figures_called

TEXT = """
schema = 1
title = "Belt, with \\"quotes\\" and µ"
[model]
name = "belt-1dof"
parameters = { k = 2.0 }
[grid]
v = [0.5, 1.0]
"initial.x_dot" = [0.0, 0.25]
[[initial]]
label = "far"
kind = "state"
[[analysis]]
kind = "response"
t_max = 200.0
[[analysis]]
kind = "equilibrium"
[[figure]]
kind = "curve"
variable = "L_s"
[[claim]]
source = "here"
text = "stick-slip"
variable = "attractor"
expect = "periodic"
"""
BELT: dict[str, Any] = {
    "schema": 1,
    "model": {"name": "belt-1dof"},
    "analysis": [{"kind": "response"}],
}
ONE: dict[str, Any] = {**BELT, "grid": {"v": np.array([0.5, 1.0])}}


@pytest.fixture(autouse=True)
def own_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Every test works in a folder of its own."""
    monkeypatch.chdir(tmp_path)
    return tmp_path


class Told:
    """A progress that keeps what it is told."""

    def __init__(self) -> None:
        self.total = self.done = 0

    def begin(self, total: int, done: int) -> None:
        self.total, self.done = total, done

    def turn(self, name: str, later: int, grows: bool) -> None:
        assert (name, later, grows) == ("response", 0, False)

    def advance(self, points: int, failed: int) -> None:
        self.done += points

    def slow(self, seconds: float, where: str) -> None:
        pass

    def note(self, text: str) -> None:
        pass

    def end(self) -> None:
        pass


def test_what_is_public() -> None:
    tree = {"CaseError", "FivError", "UsageError"}
    functions = {"load", "check", "run", "claims", "history", "read", "names_of", "figure"}
    functions |= {"analyse", "observations", "join", "diff"}
    assert set(api.__all__) == tree | functions
    shown = {test.name.split(".")[-1]: test.examples for test in doctest.DocTestFinder().find(api)}
    for name in functions:
        assert any(f"api.{name}(" in example.source for example in shown[name]), name


def test_the_examples_run(own_folder: Path) -> None:
    found = doctest.testmod(api, optionflags=doctest.ELLIPSIS)
    assert found.attempted > 30 and found.failed == 0
    assert list(own_folder.iterdir()) == []


def test_importing_it_is_light() -> None:
    program = (
        "import sys\nfrom fiv_cli import api\n"
        "print([m for m in ('numpy', 'xarray', 'numba', 'sympy', 'click') if m in sys.modules])"
    )
    assert subprocess.check_output([sys.executable, "-c", program], text=True) == "[]\n"


# --- cases --------------------------------------------------------------------------------------
def test_a_dict_is_the_case_that_its_file_is(own_folder: Path) -> None:
    (own_folder / "a.toml").write_text(TEXT)
    from_file, from_dict = api.load("a.toml"), api.load(parse_toml(TEXT))
    assert replace(from_dict, source="a.toml", text=TEXT) == from_file
    assert fingerprint(from_dict) == fingerprint(from_file)


@pytest.mark.parametrize(
    "document",
    [
        {"a": 1, "b": [1.5, 1e-300, float("inf")], "c": True, "d": 'a "b"\n\\ \x7f\t é', "e": []},
        {"t": {"x": {"y": {}}, "a b": [[0, 1], [2]]}, "l": [{"k": 1}, {"k": {"m": "x"}}], "z": 0},
    ],
)
def test_tables_survive_being_written(document: dict[str, Any]) -> None:
    assert parse_toml(toml_text(document)) == document


def test_overrides_are_lines_or_values() -> None:
    by_value = api.load(ONE, {"grid.v": [0.5], "model.parameters": {"k": 2}, "title": "a b"})
    lines = ["grid.v=[0.5]", "model.parameters={ k = 2 }", 'title="a b"']
    assert by_value == api.load(ONE, lines)
    assert (by_value.axis("v").values, by_value.title) == ((0.5,), "a b")


def test_every_problem_of_a_dict_is_told_without_lines() -> None:
    wrong = {**BELT, "model": {"name": "belt-1dof", "parameters": {"mas": 1.0, "k": "2 kg"}}}
    with pytest.raises(api.CaseError) as caught:
        api.load({**wrong, "grdi": {}})
    paths = [problem.path for problem in caught.value.problems]
    assert paths == ["model.parameters.mas", "model.parameters.k", "grdi"]
    assert all(problem.line is None for problem in caught.value.problems)
    assert "\n  <dict>: grdi:" in str(caught.value)
    assert str(caught.value).endswith("next: correct it and try again")


@pytest.mark.parametrize(
    ("document", "place"),
    [
        ({"grid": {"v": [1.0, None]}}, "grid.v.1"),
        ({"analysis": [{"kind": "response", "t_max": 1j}]}, "analysis.0.t_max"),
        ({"model": {1: "x"}}, "model.1"),
        ({"title": "\ud800"}, "title"),
    ],
)
def test_what_no_file_can_hold_is_told(document: dict[str, Any], place: str) -> None:
    with pytest.raises(api.CaseError) as caught:
        api.load({**BELT, **document})
    (problem,) = caught.value.problems
    assert problem.path == place


@given(
    st.dictionaries(
        st.sampled_from(["schema", "model", "grid", "analysis", "initial", "title", "solver"]),
        st.recursive(
            st.none() | st.booleans() | st.integers() | st.floats() | st.text() | st.binary(),
            lambda inner: st.lists(inner) | st.dictionaries(st.text() | st.integers(), inner),
        ),
    )
)
def test_any_dict_is_a_case_or_is_refused(document: dict[str, Any]) -> None:
    with contextlib.suppress(api.CaseError):
        api.load({**BELT, **document})


def test_a_dict_within_itself_is_refused() -> None:
    endless: dict[str, Any] = {}
    endless["a"] = endless
    with pytest.raises(api.CaseError, match="nests too deeply"):
        api.load({**BELT, "grid": endless})


def test_a_missing_file_is_what_the_command_says(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(api.UsageError) as caught:
        api.load("nowhere.toml")
    assert command(["check", "nowhere.toml"]) == caught.value.exit_code == 2
    assert capsys.readouterr().err == f"{caught.value}\n"


def test_a_plan_is_what_the_command_prints(
    own_folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (own_folder / "a.toml").write_text(TEXT)
    plan = api.check(api.load("a.toml"))
    assert (plan.size, [analysis.size for analysis in plan.analyses]) == (6, [4, 2])
    assert command(["check", "a.toml"]) == 0
    assert capsys.readouterr().out == f"{plan}\n"


# --- runs ---------------------------------------------------------------------------------------
def test_a_run_is_the_dataset_of_the_command(own_folder: Path) -> None:
    (own_folder / "a.toml").write_text(TEXT)
    assert command(["run", "a.toml", "-q", "-o", "of_command.nc"]) == 0
    found = api.run(api.load("a.toml"), "of_api.nc", workers=1)
    assert isinstance(found, xr.DataTree)
    assert list(found.children) == ["response", "equilibrium"]
    assert (own_folder / "of_api.nc").read_bytes() == (own_folder / "of_command.nc").read_bytes()
    assert found.identical(api.read("of_command.nc"))


def test_without_an_output_nothing_is_left(own_folder: Path) -> None:
    found = api.run(api.load(ONE))
    assert isinstance(found, xr.Dataset)
    assert found["L_s"].sizes == {"v": 2, "initial": 1}
    assert api.names_of(found["status"]).values.ravel().tolist() == ["ok", "ok"]
    assert list(own_folder.iterdir()) == []


def test_a_run_goes_on_where_it_stopped_and_tells_how_far_it_is() -> None:
    told = [Told(), Told(), Told()]
    api.run(api.load(ONE), "a.nc", progress=told[0])
    api.run(api.load(ONE, {"grid.v": [0.5, 1.0, 1.5]}), "a.nc", progress=told[1])
    api.run(api.load(ONE), "a.nc", fresh=True, progress=told[2])
    assert [one.done for one in told] == [one.total for one in told] == [2, 3, 2]


def test_somebody_computes() -> None:
    with pytest.raises(api.UsageError, match="workers=0"):
        api.run(api.load(ONE), workers=0)


def test_another_case_is_refused() -> None:
    api.run(api.load(ONE), "a.nc")
    with pytest.raises(errors.StoreMismatchError, match="another case"):
        api.run(api.load(ONE, {"model.parameters.k": 2.0}), "a.nc")


def test_threads_wait_for_one_another() -> None:
    program = (
        "from concurrent.futures import ThreadPoolExecutor\n"
        "from fiv_cli import api\n"
        f"case = api.load({BELT!r})\n"
        "with ThreadPoolExecutor(3) as threads:\n"
        "    found = list(threads.map(lambda workers: api.run(case, workers=workers), (1, 2, 1)))\n"
        "print([one.identical(found[0]) for one in found])"
    )
    said = subprocess.check_output([sys.executable, "-c", program], text=True)
    assert said == "[True, True, True]\n"


# --- motions ------------------------------------------------------------------------------------
def test_a_motion_is_that_of_the_command(own_folder: Path) -> None:
    (own_folder / "a.toml").write_text(TEXT)
    at = "v=0.5,initial.x_dot=0.25,initial=far"
    line = ["history", "a.toml", "--at", at, "--t-end", "0.5 min", "-o", "m.nc"]
    assert command(line) == 0
    case = api.load("a.toml")
    place = {"v": np.float64(0.5), "initial.x_dot": 0.25, "initial": "far"}
    motion = api.history(case, place, t_end=30.0)
    assert motion.identical(api.read("m.nc"))
    assert motion["time"].values[-1] == 30.0
    assert {path.name for path in own_folder.iterdir()} == {"a.toml", "m.nc"}
    kept = api.history(case, place, t_end="0.5 min", output="kept.nc")
    assert kept.identical(api.read("kept.nc"))


@pytest.mark.parametrize(
    ("at", "said"),
    [
        ({"w": 1.0}, "--at w: no axis"),
        ({"v": 0.7}, "--at v=0.7: off the grid"),
        ({}, "next: --at v=0.5"),
    ],
)
def test_a_point_that_is_none_is_what_the_command_says(
    own_folder: Path, capsys: pytest.CaptureFixture[str], at: dict[str, float], said: str
) -> None:
    (own_folder / "a.toml").write_text(toml_text(ONE))
    with pytest.raises(api.UsageError, match=said) as caught:
        api.history(api.load("a.toml"), at)
    places = [f"--at={name}={value}" for name, value in at.items()]
    assert command(["history", "a.toml", *places]) == 2
    assert capsys.readouterr().err == f"{caught.value}\n"


def test_a_motion_does_not_overwrite_a_sweep() -> None:
    api.run(api.load(ONE), "a.nc")
    with pytest.raises(api.UsageError, match="holds a sweep"):
        api.history(api.load(ONE), {"v": 1.0}, output="a.nc")


# --- figures ------------------------------------------------------------------------------------
def test_a_figure_is_drawn_on_a_panel() -> None:
    found = api.run(api.load(ONE))
    own = Figure()
    left, right = own.subplots(1, 2)
    assert api.figure(found, "curve", axis=right) is own
    assert right.get_xlabel() and right.lines and not left.lines
    alone = api.figure(found, "curve")
    assert alone is not own
    assert [line.get_xydata().tolist() for line in alone.axes[0].lines] == [
        line.get_xydata().tolist() for line in right.lines
    ]


def test_a_figure_of_several_panels_needs_its_own() -> None:
    found = api.run(api.load({**ONE, "analysis": [{"kind": "eigenvalues"}]}))
    with pytest.raises(api.UsageError, match="needs 2 panels\nnext: leave `axis` out"):
        api.figure(found, "eigenvalues", axis=Figure().subplots())
    assert len(api.figure(found, "eigenvalues").axes) == 2


def test_the_figures_of_a_case_go_first() -> None:
    found = api.run(api.load(parse_toml(TEXT)))
    axis = api.figure(found).axes[0]
    assert axis.get_ylabel().startswith("$L_s$") or "vibration" in axis.get_ylabel()
    with pytest.raises(api.UsageError, match="there is no figure, nor kind of figure,") as refused:
        api.figure(found, "nonsense")
    assert "run it again first" in str(refused.value)
    motion = {"history": next(iter(found.children.values())).to_dataset()}
    motion["history"].attrs["history"] = "fiv history a.toml --settled"  # its own command
    with pytest.raises(api.UsageError, match=r"`fiv history a\.toml --settled` again"):
        figures_called(motion, "nonsense")


def test_an_amplitude_is_without_the_offset_and_in_no_file(own_folder: Path) -> None:
    """A mass that a fast belt drags and a base shakes: friction shifts the motion, and no more."""
    amplitude = 0.1 / np.hypot(0.75, 0.1)  # of the linear motion
    said = {"source": "closed form", "text": "its amplitude", "variable": "x_amplitude"}
    case = {
        "schema": 1,
        "model": {"name": "belt-1dof", "parameters": {"v": 5.0, "u0": 0.1, "omega": 0.5, "c": 0.2}},
        "grid": {"N": [10.0, 20.0]},
        "analysis": [{"kind": "response"}],
        "figure": [{"kind": "curve", "variable": "x_amplitude"}],
        "claim": [{**said, "expect": {"value": amplitude, "tolerance": 1e-9}}],
    }
    found = api.run(api.load(case), output="a.nc")
    weak, strong = found["x_max"].values.ravel()
    assert strong - weak == pytest.approx(0.23 * 10.0)
    assert api.claims(api.load(case), found)[0].verdict == "confirmed"
    with xr.open_dataset("a.nc") as stored:
        assert "x_amplitude" not in stored and "x_max" in stored


def test_numbers_have_no_names() -> None:
    found = api.run(api.load(ONE))
    with pytest.raises(api.UsageError, match="L_s: holds numbers"):
        api.names_of(found["L_s"])
    assert api.names_of(found["status"][:0]).size == 0


# --- one point without a case --------------------------------------------------------------------
def test_a_model_of_ones_own_is_analysed() -> None:
    belt = get_model("belt-1dof")
    heavier = replace(belt, name="heavier", law_defaults={**belt.law_defaults, "mu_k": 0.1})
    found = api.analyse(heavier, None, "equilibrium")
    same = api.analyse("belt-1dof", "coulomb", "equilibrium", mu_k=0.1)
    np.testing.assert_array_equal(found.values["equilibrium"], same.values["equilibrium"])
    assert found.values["equilibrium"].ravel().tolist() == [1.0]


def test_a_model_that_is_typed_has_no_versions() -> None:
    program = (
        "from dataclasses import replace\nfrom fiv_cli import api\n"
        "from fiv_cli.models.belt_1dof import MODEL\n"
        "def equations(symbols, options):\n    return MODEL.equations(symbols, options)\n"
        "try:\n    api.analyse(replace(MODEL, equations=equations), None, 'equilibrium')\n"
        "except api.UsageError as error:\n    print(error)"
    )
    said = subprocess.check_output([sys.executable, "-c", program], text=True)
    assert said.startswith("model belt-1dof: written in no file") and "next: " in said


@pytest.mark.parametrize(
    ("arguments", "named", "said"),
    [
        (("belt-1dofs", None, "response"), {}, "no model 'belt-1dofs'; did you mean 'belt-1dof'"),
        (("belt-1dof", "coulom", "response"), {}, "no friction law 'coulom'; did you mean"),
        (("belt-1dof", None, "respons"), {}, "no analysis 'respons'; did you mean 'response'"),
        (("belt-1dof", None, "response"), {"mass": 1.0}, "no parameter of belt-1dof with coulomb"),
        (("belt-1dof", None, "history"), {"t_end": 10}, "\nnext: settings={'t_end': 10}"),
        (("belt-1dof", None, "response", {"y": 1.0}), {}, "no state of belt-1dof 'y'"),
        (("belt-1dof", None, "eigenvalues", {"x": 1.0}), {}, "eigenvalues begins nowhere"),
        (("belt-1dof", None, "plate"), {}, "belt-1dof has no elastic disc"),
        (("belt-1dof", None, "response"), {"options": {"a": "b"}}, "no option of belt-1dof 'a'"),
        (("belt-5dof", None, "equilibrium"), {"options": {"impact": "x"}}, "impact: 'x' is not"),
    ],
)
def test_a_wrong_call_says_what_is_wrong(
    arguments: tuple[Any, ...], named: dict[str, Any], said: str
) -> None:
    with pytest.raises(api.UsageError) as caught:
        api.analyse(*arguments, **named)
    assert said in str(caught.value)
    assert "\nnext: " in str(caught.value)


def test_settings_are_those_of_a_case() -> None:
    written = {"section": {"event": "stick->slip"}, "t_max": "5 min", "observe": "x"}
    objects = {"section": Section("event", "stick->slip"), "t_max": 300.0}
    first, second = (api.analyse("belt-1dof", None, "response", {}, s) for s in (written, objects))
    assert first.values["period"] == second.values["period"]
    assert first.ragged["section_value"] == pytest.approx([4.0])  # mu_s N / k
    bracket = {"parameter": "mu_k", "bracket": [0, 6]}
    onset = api.analyse("flutter-2dof", None, "critical", None, bracket)
    assert onset.values["critical_value"][0] == pytest.approx(5 / 2 + 3**0.5)


def test_settings_that_no_case_may_have() -> None:
    wrong = {"tmax": 1.0, "section": {"event": "slip"}, "observe": "y"}
    with pytest.raises(api.CaseError) as caught:
        api.analyse("belt-1dof", None, "spectrum", {}, wrong)
    paths = {problem.path for problem in caught.value.problems}
    assert paths == {f"settings.{name}" for name in ("tmax", "section.event", "observe", "f_max")}


@pytest.mark.parametrize("ask", [api.run, api.check, api.history, api.claims])
def test_what_is_no_case_yet_is_told_how_it_becomes_one(ask: Any) -> None:
    with pytest.raises(api.UsageError, match=r"a dict is none\nnext: api\.load"):
        ask({"schema": 1})
