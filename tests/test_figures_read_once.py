"""Figures are read once, when a case is checked; a dataset carries what was understood."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from fiv_cli.case.grammar import parse_condition
from fiv_cli.case.load import load_case
from fiv_cli.cli.main import run as fiv
from fiv_cli.data.netcdf import read_datasets
from fiv_cli.errors import CaseError
from fiv_cli.reading import select
from fiv_cli.reading.datasets import figures_in, read_analyses

CASE = """
schema = 1
title = "broken $\\\\mu_k^$ and $sound$"
[model]
name = "pin-on-disc"
[grid]
"friction.mu_k" = [0.2, 0.3]
N0 = [10.0, 20.0, 30.0]
[[analysis]]
kind = "equilibrium"
[[figure]]
kind = "curve"
x = "N0"
variable = "n_solutions"
select = { "friction.mu_k" = 0.3 }
[[figure]]
kind = "curve"
[[claim]]
source = "here"
text = "it rests"
variable = "n_solutions"
at = { "friction.mu_k" = ". == 0.3" }
expect = { value = 1, tolerance = 0 }
"""


@pytest.fixture(autouse=True)
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    Path("a.toml").write_text(CASE)


def run(*settings: str) -> None:
    overrides = [word for line in settings for word in ("--set", line)]
    command = ["run", "a.toml", "-o", "a.nc", "--workers", "1", "-q", *overrides]
    assert fiv(command) == 0


def test_a_case_that_is_right_can_be_run_and_drawn(capsys: pytest.CaptureFixture[str]) -> None:
    """A quoted key with a dot, ``==``, and a title whose mathematics is broken."""
    assert fiv(["check", "a.toml"]) == 0
    assert fiv(["run", "a.toml", "--workers", "1", "-q"]) == 0
    capsys.readouterr()
    assert fiv(["plot", "runs/a.nc"]) == 0
    drawn = capsys.readouterr().out.split()
    assert drawn == ["runs/a-curve.png", "runs/a-curve-2.png"]
    assert all(Path(path).stat().st_size > 1000 for path in drawn)
    assert fiv(["claims", "a.toml", "--strict"]) == 0
    assert "1 confirmed" in capsys.readouterr().out


def test_the_figures_of_a_dataset_are_those_of_its_case() -> None:
    run()
    assert figures_in(read_analyses("a.nc")) == list(load_case("a.toml").figures)


def test_figures_set_on_the_command_line_are_drawn() -> None:
    run('figure.0.variable="residual"', "figure.0.select={}")
    first, _ = figures_in(read_analyses("a.nc"))
    assert first.settings == {"x": "N0", "variable": "residual", "select": {}}


def test_a_dataset_of_before_is_read_from_its_case(monkeypatch: pytest.MonkeyPatch) -> None:
    """0.1.0 kept no figures: the text of the case is read as it would be now."""
    run("figure.1.name=second")
    analyses = read_analyses("a.nc")
    understood = figures_in(analyses)
    for dataset in analyses.values():
        del dataset.attrs["figures_json"]
    assert figures_in(analyses) == understood
    assert understood[1].name == "second"


def test_shares_that_a_dataset_of_before_asks_for_are_drawn() -> None:
    """Its text says ``share`` where a case now says `take`; so do the figures of later ones."""
    now = 'take = { what = "share", of = ". > 0", over = ["N0"] }'
    before = now.replace("take", "share").replace('what = "share", ', "")
    Path("a.toml").write_text(CASE.replace('kind = "curve"\n[[', f'kind = "curve"\n{now}\n[['))
    run()
    analyses = read_analyses("a.nc")
    understood = figures_in(analyses)
    assert understood[1].settings["take"]["what"] == "share"
    for dataset in analyses.values():
        figures = json.loads(dataset.attrs["figures_json"])
        share = figures[1]["settings"].pop("take")
        figures[1]["settings"]["share"] = {k: v for k, v in share.items() if k != "what"}
        dataset.attrs["figures_json"] = json.dumps(figures)
    assert figures_in(analyses) == understood
    for dataset in analyses.values():
        del dataset.attrs["figures_json"]
        dataset.attrs["case"] = dataset.attrs["case"].replace(now, before)
    assert figures_in(analyses) == understood


def test_what_is_missing_is_told_once() -> None:
    Path("a.toml").write_text(CASE.replace('variable = "n_solutions"\nat', "at"))
    with pytest.raises(CaseError) as caught:
        load_case("a.toml")
    assert [problem.path for problem in caught.value.problems] == ["claim.0.variable"]


def test_a_variable_set_on_the_command_line_is_told_as_such() -> None:
    with pytest.raises(CaseError, match=r"figure\.0\.variable \(--set figure\.0\.variable=no\)"):
        load_case("a.toml", ["figure.0.variable=no"])


@pytest.mark.parametrize(
    ("text", "tests"),
    [(". == 0.3", (("==", 0.3),)), (". != 0.3", (("!=", 0.3),)),
     ("0.09 <= . < 0.28", ((">=", 0.09), ("<", 0.28))),
     (" .>-1e-3 ", ((">", -1e-3),)), ("+.25<.", ((">", 0.25),)), (".", ()), ("0.3", ()),
     ("1 < . <", ()), (". = 3", ()), ("== 3", ()), ("", ())],
)  # fmt: skip
def test_there_is_one_grammar_of_conditions(
    text: str, tests: tuple[tuple[str, float], ...]
) -> None:
    assert parse_condition(text) == tests
    assert (select.condition(text) is not None) == bool(tests)
    Path("a.toml").write_text(CASE.replace(". == 0.3", text))
    codes = {True: 0, False: 3}
    given_as_number = text == "0.3"
    assert fiv(["check", "a.toml"]) == codes[bool(tests) or given_as_number]


def test_names_of_figures_are_names_of_files() -> None:
    for name in ("a/b", "a\\u001bb", ""):
        Path("a.toml").write_text(
            CASE.replace('kind = "curve"\n[', f'kind = "curve"\nname = "{name}"\n[')
        )
        assert fiv(["check", "a.toml"]) == 3
    run_dataset = {"name": "../x", "kind": "curve", "settings": {}}
    Path("a.toml").write_text(CASE)
    run()
    damaged = read_datasets(Path("a.nc"))[""].assign_attrs(figures_json=json.dumps([run_dataset]))
    damaged.to_netcdf("bad.nc")
    assert fiv(["plot", "bad.nc"]) == 3
