"""What there is, listed: kinds of analyses, starts, figures and claims, and variables of a case."""

from __future__ import annotations

import importlib
import json
import re
from pathlib import Path
from typing import get_args

import click
import pytest
import xarray as xr
from small_cases import BELT

from fiv_cli import api
from fiv_cli.analyses import all_analyses
from fiv_cli.analyses.settings import TableSetting
from fiv_cli.case.kinds import FIGURES, STARTS, TABLES, TAKES, all_kinds
from fiv_cli.case.structure import FigureKind, InitialTable, What
from fiv_cli.case.words import OTHER_WORDS, variable_meant
from fiv_cli.cli.main import COMMANDS, run
from fiv_cli.plots.drawing import KINDS


def printed(capsys: pytest.CaptureFixture[str], *arguments: str) -> str:
    assert run(list(arguments)) == 0
    return capsys.readouterr().out


def test_every_kind_is_described() -> None:
    assert set(FIGURES) == set(get_args(FigureKind)) == set(KINDS)
    assert set(TAKES) == set(get_args(What))
    assert set(STARTS) == set(get_args(InitialTable.model_fields["kind"].annotation))
    assert [k.name for k in all_kinds() if k.table == "analysis"] == list(all_analyses())


def test_a_key_that_takes_one_of_some_words_says_them(capsys: pytest.CaptureFixture[str]) -> None:
    assert re.search(
        r"^on_loss .*: stop \| restart \| go-on$", printed(capsys, "kinds", "continue"), re.M
    )


def test_kinds_are_listed(capsys: pytest.CaptureFixture[str]) -> None:
    out = printed(capsys, "kinds")
    for kind in all_kinds():
        assert re.search(rf"^{re.escape(kind.name)} +{re.escape(kind.meaning)}", out, re.MULTILINE)
    document = json.loads(printed(capsys, "kinds", "--json"))
    assert len(document["kinds"]) == len(all_kinds())


@pytest.mark.parametrize("name", sorted({kind.name for kind in all_kinds() if kind.keys}))
def test_the_keys_of_a_kind_are_listed(name: str, capsys: pytest.CaptureFixture[str]) -> None:
    out = printed(capsys, "kinds", name)
    for kind in all_kinds():
        for key in kind.keys if kind.name == name else ():
            assert key.meaning and re.search(rf"^{key.name} ", out, re.MULTILINE)
    analysis = all_analyses().get(name)
    for setting in () if analysis is None else analysis.settings:
        assert setting.description in out
        for key in setting.keys if isinstance(setting, TableSetting) else ():
            assert f"\n{setting.name}.{key.name} " in out


def test_the_keys_of_a_table_are_listed(capsys: pytest.CaptureFixture[str]) -> None:
    assert re.search(r"\nexpect +required  a class", printed(capsys, "kinds", "claim"))
    assert run(["kinds", "shar"]) == 2
    assert "did you mean 'share'?" in capsys.readouterr().err
    assert run(["kinds", "belt-1dof"]) == 2
    assert "models and laws: fiv models" in capsys.readouterr().err


def test_words_of_the_field_lead_to_what_is_called_otherwise_here(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    known = {*TABLES, *(kind.name for kind in all_kinds() if kind.keys)}
    assert {kind for kinds in OTHER_WORDS.values() for kind in kinds} <= known
    assert not known & {*OTHER_WORDS}
    for word, kind in (
        *(("neighbour", "continue"), ("hysteresis", "continue"), ("carry", "continue")),
        *(("Poincaré map", "bifurcation"), ("basin of attraction", "basin"), ("FFT", "spectrum")),
        *(("time series", "history"), ("timeseries", "history"), ("Hopf", "critical")),
        *(("Lyapunov", "response"), ("Floquet", "cycle"), ("limit cycle", "cycle")),
        *(("stability map", "map"), ("stability", "eigenvalues"), ("damping", "eigenvalues")),
        *(("squeal", "response"), ("stick-slip", "response"), ("eigenvalue", "eigenvalues")),
    ):
        assert run(["kinds", word]) == 2
        told = capsys.readouterr().err
        assert f"\n  fiv kinds {kind}: " in told, word
    assert run(["kinds", "box"]) == 2
    assert "it is a setting: fiv kinds random\n" in capsys.readouterr().err
    case = tmp_path / "belt.toml"
    case.write_text(BELT + '\n[[initial]]\nkind = "hysteresis"\n')
    assert run(["check", str(case)]) == 3
    assert "here it is 'continue': `fiv kinds continue`" in capsys.readouterr().err


def test_a_model_is_shown_with_a_law(capsys: pytest.CaptureFixture[str]) -> None:
    out = printed(capsys, "models", "pin-on-disc", "stribeck")
    assert out == printed(capsys, "models", "pin-on-disc", "--law", "stribeck")
    assert re.search(r"^mu_k .* 0\.23 ", out, re.M) and "exp(-(|v|/v_s)^delta)" in out
    document = json.loads(printed(capsys, "models", "belt-5dof", "--law", "lugre", "--json"))
    assert {p["name"]: p["default"] for p in document["law"]["parameters"]}["mu_s"] == 3.0
    for wrong, words in (
        (["annular-plate", "--law", "coulomb"], "has no frictional contact"),
        (["pin-on-disc", "--law", "strybeck"], "did you mean 'stribeck'"),
        (["--law", "stribeck"], "fiv models stribeck"),
        (["stribeck", "coulomb"], "coulomb: a law is for a model"),
        (["pin-on-disc", "stribeck", "--law", "coulomb"], "two laws, stribeck and coulomb"),
    ):
        assert run(["models", *wrong]) == 2
        assert words in capsys.readouterr().err


def test_the_variables_listed_are_those_of_the_dataset(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    case = tmp_path / "belt.toml"
    case.write_text(BELT)
    out = printed(capsys, "variables", str(case))
    document = json.loads(printed(capsys, "variables", str(case), "--json"))["analyses"]
    found = api.run(api.load(case), tmp_path / "belt.nc", workers=1)
    (listed,) = document.values()
    own = {one["name"] for one in listed}
    with xr.open_dataset(tmp_path / "belt.nc") as file:
        assert {one["name"] for one in listed if one["stored"]} == own & {*file.variables}
    for text in (out, printed(capsys, "show", str(tmp_path / "belt.nc"))):
        assert text.index("in no file") < text.index("x_amplitude") > text.index("x_max")
    ways_back = {name for name in found.data_vars if str(name).endswith(("_row_size", "_point"))}
    assert set(found.data_vars) - ways_back <= own <= {*found.data_vars, *found.coords}
    for one in listed:
        array = found[one["name"]]
        assert array.attrs.get("units", "1") == one["unit"]
        assert array.dims[len(array.dims) - len(one["dims"].split()) :] == tuple(
            one["dims"].split()
        )
        words = len(one["meaning"].split(" | "))
        shown = f"; {words} words, which --json lists" if words > 12 else one["meaning"]
        assert re.search(rf"^{one['name']} .*{re.escape(shown)}$", out, re.MULTILINE)


def test_variables_are_listed_to_whom_a_figure_was_refused(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    case = tmp_path / "belt.toml"
    case.write_text(f'{BELT}\n[[figure]]\nkind = "curve"\nname = "wrong"\nvariable = "force"\n')
    assert run(["check", str(case)]) == 3
    assert "`fiv variables" in capsys.readouterr().err
    case.write_text(case.read_text().replace("force", "shares"))
    assert run(["check", str(case)]) == 3
    assert 'take = { what = "share", of = "each", over = "initial" }' in capsys.readouterr().err
    assert "\nstick_fraction " in printed(capsys, "variables", str(case))


def test_help_lists_every_kind_of_figure() -> None:
    command = importlib.import_module(COMMANDS["plot"][0]).command
    text = " ".join(click.Context(command, info_name="plot").get_help().split())
    assert all(re.search(rf"\b{kind}\b", text) for kind in FIGURES)


@pytest.mark.parametrize(
    ("word", "following"),
    [
        *(("map", "fiv kinds map"), ("refine", "fiv kinds refine"), ("Floquet", "fiv kinds cycle")),
        ("model", "fiv kinds model"),
    ],
)
def test_a_command_that_is_none_but_a_kind(
    word: str, following: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert run([word]) == 2
    told = capsys.readouterr().err.splitlines()
    assert told[-1].endswith(following)
    assert ("did you mean 'models'" in told[-2]) == (word == "model")


def test_words_of_the_field_lead_to_the_variables_they_mean_here() -> None:
    known = ["L_s", "response_frequency", "lyapunov"]
    assert variable_meant("dominant_frequency", known) == "here it is 'response_frequency'"
    assert variable_meant("event_kind", ["event_from"]) == "here it is 'event_from'"
    assert variable_meant("Lyapunov exponent", known) == "here it is 'lyapunov'"
    assert variable_meant("stability", ["branch_stable"]) == "here it is 'branch_stable'"
    assert variable_meant("equilibrium", ["L_s_reference"]) == "here it is 'L_s_reference'"
    assert variable_meant("RMS", ["period"]) == variable_meant("period", known) == ""
