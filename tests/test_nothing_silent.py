"""What is no answer is told: balances without a number, claims on points without a class."""

from __future__ import annotations

import json
import tomllib
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import synthetic_datasets as data
import xarray as xr
from small_models import TWO_MASSES

from fiv_cli import api
from fiv_cli.cli.main import run as fiv
from fiv_cli.errors import CaseError
from fiv_cli.flags import advice
from fiv_cli.models.base import Equations, Options
from fiv_cli.reading.claims import CONFIRMED, CONTRADICTED, UNDETERMINED
from fiv_cli.sweep.answer import Answer


# --- a balance without a number ------------------------------------------------------------------
def _mistaken(symbols: Any, options: Options) -> Equations:
    """Two masses, and an energy that is the root of a negative number where they are."""
    found = TWO_MASSES.equations(symbols, options)
    root = (symbols.coordinate("x1") - 1000) ** 0.5
    return replace(found, potential_energy=found.potential_energy + root)


MISTAKEN = replace(TWO_MASSES, name="mistaken", equations=_mistaken)


@pytest.mark.parametrize(("kind", "settings"), [("response", {}), ("history", {"t_end": 9.0})])
def test_energies_that_are_no_number_fail_the_point(kind: str, settings: Any) -> None:
    found = api.analyse(MISTAKEN, "coulomb", kind, {"x1": 0.3}, settings, N2=8.0)
    assert (found.status, found.reason, found.values) == ("failed", "no_number", {})


# --- points of several systems --------------------------------------------------------------------
def test_what_rests_is_told_under_each_option_of_a_grid() -> None:
    """Points of two systems are told side by side of both, and as each alone."""
    case: dict[str, Any] = {
        "schema": 1,
        "model": {"name": "flutter-2dof"},
        "friction": {"law": "coulomb"},
        "grid": {"mu_k": [0.067], "c1": [0.1, 0.2, 0.3], "c2": [0.1, 0.2]},
        "initial": [{"label": "small", "kind": "equilibrium", "offset": {"x": 1e-3}}],
        "analysis": [{"kind": "response"}],
    }
    options = ["until-separation", "all"]
    case["grid"]["states"] = options
    both = api.run(api.load(case), workers=1)
    assert (api.names_of(both["attractor"]) == "equilibrium").all()
    for option in options:
        case["grid"]["states"] = [option]
        alone = api.run(api.load(case), workers=1)
        xr.testing.assert_identical(
            both[["attractor", "L_s", "n_steps"]].sel(states=[option]).drop_attrs(),
            alone[["attractor", "L_s", "n_steps"]].drop_attrs(),
        )


def test_what_is_assumed_of_impacts_is_told_where_motions_separate(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """It decides how large they are; of motions in contact it says nothing."""
    case = (
        'schema = 1\n[model]\nname = "flutter-2dof"\n[model.options]\nstates = "all"\n'
        "[model.parameters]\nc1 = 0.1\nc2 = 0.1\nv = 3.0\n"
        '[grid]\nmu_k = [{}]\n[[initial]]\nkind = "equilibrium"\noffset = {{ x = 1e-3 }}\n'
        '[[analysis]]\nkind = "response"\n'
    )
    for mu_k, told in ((0.1, False), (10.0, True)):
        (tmp_path / "a.toml").write_text(case.format(mu_k))
        output = str(tmp_path / f"{mu_k}.nc")
        assert fiv(["run", str(tmp_path / "a.toml"), "-o", output]) == 0
        assert ("--set model.options.impact=none" in capsys.readouterr().err) == told


# --- branches from elsewhere ----------------------------------------------------------------------
@pytest.mark.parametrize(("kind", "told"), [("cycle", True), ("boundary", False)])
def test_a_branch_begins_at_the_cases_own_value(kind: str, told: bool) -> None:
    of = {"variable": "attractor", "expect": "periodic"} if kind == "boundary" else None
    asked = {"kind": kind, "parameter": "v", "bracket": [0.5, 0.9]} | ({"of": of} if of else {})
    case = {"schema": 1, "model": {"name": "belt-1dof"}, "analysis": [asked]}
    if not told:
        assert api.load(case).analyses[0].settings["bracket"] == (0.5, 0.9)
        return
    with pytest.raises(CaseError, match=r"both ways from v = 1\.0, the default.*outside") as caught:
        api.load(case)
    assert "or v between 0.5 and 0.9 in [model.parameters]" in str(caught.value)
    assert api.load(case | {"model": {"name": "belt-1dof", "parameters": {"v": 0.7}}})


# --- figures and claims of what is not there ------------------------------------------------------
FAR = {"label": "far", "kind": "state", "state": {"x": 10.0}}
ASKING: dict[str, Any] = {
    "schema": 1,
    "model": {"name": "belt-1dof"},
    "grid": {"v": [0.5, 1.0, 1.5], "friction": ["coulomb", "stribeck"]},
    "initial": [FAR],
    "analysis": [{"kind": "response"}, {"kind": "eigenvalues"}],
}
CLAIM = {"source": "here", "text": "said", "expect": {"less_than": 1.0}}
OVER_PHASES = {"what": "mean", "over": ["psi_a"]}


@pytest.mark.parametrize(
    ("table", "said", "told", "allowed"),
    [
        ("figure", {"kind": "curve", "variable": "F_N"}, "computes 'F_N'", ""),
        ("figure", {"kind": "mode-shape"}, "of kind 'mode-shape' shows", "bifurcation, map"),
        ("figure", {"kind": "curve", "variable": "section_value"}, "be drawn as a curve", "L_s"),
        ("figure", {"kind": "bifurcation", "variable": "L_s"}, "a bifurcation", "section_value"),
        ("figure", {"kind": "map", "variable": "section_value"}, "be drawn as a map", "L_s"),
        (
            "figure",
            {"kind": "curve", "variable": "L_s", "select": {"v": ". > 2"}},
            "'. > 2'",
            "1.5",
        ),
        ("figure", {"kind": "bifurcation", "select": {"v": 0.75}}, "0.75 is not", "0.5, 1.0"),
        ("claim", {"variable": "L_s", "at": {"v": 0.75}}, "0.75 is not on the axis v", "0.5, 1.0"),
        ("claim", {"variable": "L_s", "at": {"v": ". < 0.5"}}, "'. < 0.5' is not on the axis", ""),
        ("claim", {"variable": "L_s", "at": {"v": [0.5, 9.0]}}, "9.0 is not on the axis v", ""),
        ("claim", {"variable": "L_s", "at": {"friction": "tanh"}}, "'tanh' is not on", "stribeck"),
        ("claim", {"variable": "growth_rate", "at": {"initial": "far"}}, "no axis 'initial'", "v"),
        ("claim", {"variable": "L_s", "take": OVER_PHASES | {"over": ["mode"]}}, "'mode'", "v"),
        (
            "claim",
            {"variable": "section_value", "take": OVER_PHASES | {"over": ["v"]}},
            "has any number of values at a point",
            "",
        ),
    ],
)
def test_what_is_not_there_is_told_before_the_run(
    table: str, said: dict[str, Any], told: str, allowed: str
) -> None:
    asked = {**(CLAIM if table == "claim" else {}), **said}
    with pytest.raises(CaseError) as refused:
        api.load({**ASKING, table: [asked]})
    (problem,) = refused.value.problems
    assert told in problem.message
    assert allowed in problem.allowed


@pytest.mark.parametrize(
    ("table", "asked"),
    [
        ("figure", {"kind": "curve", "variable": "stick_fraction", "select": {"contact": [1, 7]}}),
        ("figure", {"kind": "history", "variable": "x1", "select": {"contact": 7}}),
        ("claim", {**CLAIM, "variable": "stick_fraction", "at": {"contact": 7}}),
    ],
)
def test_a_contact_that_the_model_has_not_is_told_before_the_run(
    table: str, asked: dict[str, Any]
) -> None:
    analyses = [{"kind": "response"}, {"kind": "history", "t_end": 9.0}]
    case = ASKING | {"model": {"name": "belt-2mass"}, "analysis": analyses}
    case["grid"], case["initial"] = {"v": [0.5, 1.0]}, [{"label": "rest", "kind": "state"}]
    with pytest.raises(CaseError) as refused:
        api.load({**case, table: [asked]})
    (problem,) = refused.value.problems
    assert problem.path.endswith(".contact") and "7" in problem.message
    assert problem.allowed in ("1, 2", "1 to 2")


def test_a_shorter_grid_leaves_claims_about_the_rest() -> None:
    """One point of a case can be run alone, whatever its claims speak of."""
    case = {**ASKING, "claim": [{**CLAIM, "variable": "L_s", "at": {"v": 1.5}}]}
    assert len(api.load(case, overrides={"grid.v": [0.5]}).claims) == 1


# --- what a run ends with -------------------------------------------------------------------------
CHAIN = """
schema = 1
[model]
name = "pin-on-disc"
parameters = { N0 = "30 N" }
[grid]
Omega = [1.5, 2.5, 15.5, 16.5, 17.5]
[[initial]]
label = "far"
kind = "state"
state = { phi_dot = "Omega" }
[[initial]]
label = "followed"
kind = "continue"
along = "Omega"
from = "far"
[[analysis]]
kind = "response"
section = { event = "stick->slip" }
"""


def test_a_run_ends_with_its_answer(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Classes and reasons with their counts, what to change, and where chains ended."""
    case, output = tmp_path / "chain.toml", str(tmp_path / "chain.nc")
    case.write_text(CHAIN)
    assert fiv(["run", str(case), "-o", output, "--workers", "1"]) == 0
    told = capsys.readouterr().err
    assert "  response: periodic 4, equilibrium 4\n" in told
    assert "WARNING: 2 points of response lie behind the end of what was followed" in told
    assert 'on_loss = "restart"' in told and 'on_loss = "go-on"' in told and "--fresh" not in told
    hasty = [*("run", str(case), "--set", "analysis.0.t_max=2.0"), "-o", f"{output}2.nc"]
    assert fiv([*hasty, "--workers", "1"]) == 0
    told = capsys.readouterr().err
    assert "  response: undecided 7, equilibrium 3\n" in told
    assert f"    time_budget 4: {advice('time_budget', 'response')}\n" in told
    assert "WARNING: 7 of 10 points of response have no answer" in told
    assert "  next: a case that is changed so takes fiv run --fresh" in told
    assert fiv([*hasty, "-q"]) == 0
    assert capsys.readouterr().err == ""


ASKED = """
schema = 1
[model]
name = "belt-1dof"
parameters = { v = 6.0 }
[grid]
c = [0.1, 0.2]
[[initial]]
kind = "state"
state = { x = 5.0 }
[[analysis]]
kind = "boundary"
parameter = "v"
bracket = [0.5, 4.0]
of = { expect = "periodic" }
[[analysis]]
kind = "cycle"
[[analysis]]
kind = "history"
t_end = 1.0
"""


def test_a_curve_of_what_varies_along_a_motion_is_told_before_the_run() -> None:
    figure = {"kind": "curve", "x": "c", "variable": "x"}
    with pytest.raises(CaseError, match=r"'x' varies along a motion.*\n.*\"history\""):
        api.load({**tomllib.loads(ASKED), "figure": [figure]})


def test_every_analysis_ends_with_its_answer(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Numbers with their range where it tells no class; a cycle that there is not is no answer."""
    case, output = tmp_path / "asked.toml", tmp_path / "asked.nc"
    case.write_text(ASKED)
    assert fiv(["run", str(case), "-o", str(output), "--workers", "1"]) == 0
    lines = capsys.readouterr().err.splitlines()
    found = api.read(output)["boundary"]["boundary"]
    ends = f"{float(found.min()):.6g} to {float(found.max()):.6g}"
    errors = api.read(output)["boundary"]["boundary_error"]
    count = f"{int(found.count())}, within {float(errors.max()):.2g}"
    assert f"  boundary: boundary {ends} m s-1 ({count})" in lines
    assert "  history: 2 answers" in lines
    told = lines.index("  cycle: 0 answers")
    assert lines[told + 1].startswith("    no_cycle 2: ")
    assert "  WARNING: 2 of 2 points of cycle have no answer" in lines[told:]


# --- what a run will cost ------------------------------------------------------------------------
def test_an_estimate_runs_a_sample_and_keeps_nothing(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """Of a few points, all: two starts, one of which is a chain."""
    monkeypatch.chdir(tmp_path)
    Path("chain.toml").write_text(CHAIN + '[[analysis]]\nkind = "eigenvalues"\n')
    assert fiv(["check", "chain.toml", "--estimate", "--json", "--workers", "3"]) == 0
    (case,) = json.loads(capsys.readouterr().out)["cases"]
    of_response, of_eigenvalues = case["estimates"]
    assert of_response["points"] == [10, 10] and of_eigenvalues["points"] == [5, 5]
    assert of_response["sampled"] == 10 and of_eigenvalues["sampled"] == 5
    for one in case["estimates"]:
        low, high = one["seconds"]
        assert (
            0.0 < low < one["expected"] < high
            and one["memory"] > one["disk"] > 0.0
            and one["workers"] == 3
        )
    assert [path.name for path in tmp_path.iterdir()] == ["chain.toml"]
    assert fiv(["check", "chain.toml", "--estimate"]) == 0
    assert "  estimate of response: " in capsys.readouterr().out


def test_a_grid_of_a_hundred_million_points_is_told_what_it_means(
    capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    case = tmp_path / "large.toml"
    axis = "{ start = 1.0, stop = 2.0, num = 10000 }"
    case.write_text(f'schema = 1\n[model]\nname = "belt-1dof"\n[grid]\nv = {axis}\nN = {axis}\n'
                    '[[analysis]]\nkind = "response"\n')  # fmt: skip
    assert fiv(["check", str(case)]) == 0
    told = capsys.readouterr().out
    assert "100,000,000 points: some 5.1 GB of memory" in told
    assert "--estimate" in told


def test_a_long_run_says_so_once(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr("fiv_cli.sweep.scheduler.LONG", 0.0)
    monkeypatch.setattr("fiv_cli.sweep.scheduler.LARGEST_CHUNK", 1)  # a point each
    (tmp_path / "chain.toml").write_text(CHAIN)
    assert fiv(["run", str(tmp_path / "chain.toml"), "-o", str(tmp_path / "a.nc")]) == 0
    assert capsys.readouterr().err.count("to go on 2 workers") == 1


# --- claims on points without a class -----------------------------------------------------------
@pytest.mark.parametrize(
    ("expect", "verdict"),
    [
        ({"greater_than": 0.5}, UNDETERMINED),
        ({"less_than": 0.5}, UNDETERMINED),
        ({"value": 0.8, "tolerance": 0.05}, UNDETERMINED),
        ({"greater_than": 0.19}, CONFIRMED),
        ({"less_than": 0.96}, CONFIRMED),
        ({"greater_than": 0.96}, CONTRADICTED),
    ],
)
def test_a_share_is_known_as_far_as_the_decided_points_say(expect: Any, verdict: str) -> None:
    """Of 200 points 40 are periodic, 10 are not, 150 may be either: a share of 0.2 to 0.95."""
    classes = np.repeat(["periodic", "equilibrium", "undecided"], [40, 10, 150]).astype(object)
    points = data.response(classes, np.ones(200), data.axes(Omega=np.arange(200.0)))
    share = {"what": "share", "of": "periodic", "over": ["Omega"]}
    assert data.tried(points, "attractor", expect, take=share).verdict == verdict


def test_what_is_found_beside_a_loss_of_contact_says_what_it_lacks(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """More time gives no number to a motion that has ended; and what was found is an answer."""
    case, output = tmp_path / "end.toml", str(tmp_path / "end.nc")
    of = 'variable = "stick_fraction", expect = { greater_than = 0.0 }'
    case.write_text(
        'schema = 1\n[model]\nname = "pin-on-disc"\nparameters = { N0 = 10.0 }\n'
        '[[initial]]\nkind = "state"\nstate = { phi_dot = "Omega" }\n'
        '[[analysis]]\nkind = "boundary"\nparameter = "Omega"\nbracket = [14.0, 15.0]\n'
        f"of = {{ {of} }}\nscan = 3\n"
    )
    assert fiv(["run", str(case), "-o", output, "--workers", "1"]) == 0
    told = "WARNING: 1 of 1 points of boundary have no answer for all of the bracket"
    assert told in capsys.readouterr().err
    assert fiv(["show", output]) == 0
    shown = capsys.readouterr().out
    assert "beside it ended (contact lost), without a number: asking for a class in `of`" in shown
    assert "larger `t_max`" not in shown


@pytest.mark.parametrize(
    ("reason", "verdict"),
    [("section_drifts", CONFIRMED), ("time_budget", UNDETERMINED), ("none", CONFIRMED)],
)
def test_how_a_motion_sticks_on_its_way_is_not_how_it_ends(reason: str, verdict: str) -> None:
    """Of 200 motions 150 have no class: what they do is known if they had settled, else not."""
    classes = np.repeat(["periodic", "undecided"], [50, 150]).astype(object)
    axis = data.axes(Omega=np.arange(200.0))
    flag = data.flags(("Omega",), np.full(200, reason), ("none", "section_drifts", "time_budget"))
    sticking = (("Omega",), np.full(200, 0.3))
    points = data.response(classes, np.ones(200), axis, reason=flag, stick_fraction=sticking)
    share = {"what": "share", "of": ". > 0", "over": ["Omega"]}
    found = data.tried(points, "stick_fraction", {"greater_than": 0.9}, take=share)
    assert found.verdict == verdict


def test_a_run_says_what_passes_what_its_equations_take_as_small(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """As `fiv show` does, without being asked."""
    case, output = tmp_path / "far.toml", str(tmp_path / "far.nc")
    starts = "\n".join(
        f'[[initial]]\nlabel = "s{phi}"\nkind = "state"\nstate = {{ phi = {phi} }}'
        for phi in (0.01, 0.3, 0.4)
    )
    history = '[[analysis]]\nkind = "history"\nt_end = 0.1\nsample = 0.01'
    case.write_text(f'schema = 1\n[model]\nname = "pin-on-disc"\n{starts}\n{history}\n')
    assert fiv(["run", str(case), "-o", output, "--workers", "1"]) == 0
    remark = "phi passes 0.25 rad at 2 of 3 points, though the equations of the model take it as"
    assert f"  WARNING: {remark}" in capsys.readouterr().err
    assert fiv(["show", output]) == 0
    assert f"  {remark}" in capsys.readouterr().out


def test_what_a_branch_passes_beyond_its_first_cycle_is_told_too(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """That of 50 N is within 0.25 rad at 13 rad/s, and not at its end."""
    case, output = tmp_path / "far.toml", str(tmp_path / "far.nc")
    case.write_text("""schema = 1
[model]
name = "pin-on-disc"
parameters = { N0 = 50.0, Omega = 13.0 }
[[initial]]
label = "followed"
kind = "state"
state = { phi_dot = 13.0 }
[[analysis]]
kind = "cycle"
parameter = "Omega"
bracket = [12.9, 19.95]
""")
    assert fiv(["run", str(case), "-o", output, "--workers", "1"]) == 0
    remark = "phi passes 0.25 rad at 1 of 1 points"
    assert f"  WARNING: {remark}" in capsys.readouterr().err
    assert fiv(["show", output]) == 0
    assert f"  {remark}" in capsys.readouterr().out


@pytest.mark.parametrize(("going_on", "told"), [(True, "itself ended there"), (False, "go-on")])
def test_a_chain_that_goes_on_in_any_case_is_not_told_to(going_on: bool, told: str) -> None:
    found = {"classes": {"periodic": 1}, "reasons": {"contact_lost": 1}, "said": {}, "still": ()}
    counted = {"found": (), "asked": 2, "open": 0, "filled": 0, "not_reached": 3, "beyond": ()}
    answer = Answer("a", "response", options=(), **found, **counted, going_on=going_on)
    warning = list(answer.lines())[-1]
    assert warning.startswith("  WARNING: 3 points of a lie behind") and told in warning
    assert ("go-on" in warning) != going_on


def test_that_exponents_are_left_out_is_told_where_chaos_stays_undecided(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    case = tmp_path / "chaos.toml"
    case.write_text(
        'schema = 1\nmodel = { name = "pin-on-disc", parameters = { Omega = 0.5 } }\n'
        'initial = [{ label = "far", kind = "state", state = { phi_dot = "Omega" } }]\n'
        'analysis = [{ kind = "response", t_max = 100.0 }]\n'
    )
    for changes, is_told in ([], False), (["--set", 'analysis.0.lyapunov="never"'], True):
        output = str(tmp_path / f"{is_told}.nc")
        assert fiv(["run", str(case), "-o", output, "--workers", "1", *changes]) == 0
        assert fiv(["show", output]) == 0
        printed = capsys.readouterr()
        for text in (printed.err, printed.out):
            assert ("undecided 1" in text) == is_told
            assert ('under lyapunov = "never" chaos is undecided' in text) == is_told
