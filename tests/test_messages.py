"""What a newcomer gets wrong, and that the message at once says what to write."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
from small_cases import BELT

from fiv_cli.cli.main import run
from fiv_cli.flags import advice
from fiv_cli.models import all_models

CASE = """\
schema = 1
title = "a pin"

[model]
name = "pin-on-disc"
parameters = { N0 = "30 N" }

[grid]
Omega = { start = 0.5, stop = 9.0, step = 1.7 }

[[initial]]
label = "far"
kind = "state"
state = { phi_dot = "Omega" }

[[analysis]]
kind = "equilibrium"

[[claim]]
source = "a hunch"
text = "all of them"
variable = "n_solutions"
at = { Omega = ". >= 7" }
expect = { value = 1, tolerance = 0 }
"""


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    Path("pin.toml").write_text(CASE)


def checked(capsys: pytest.CaptureFixture[str], old: str = "", new: str = "") -> str:
    """What `fiv check` says of the case in which `old` was written as `new`."""
    assert old in CASE
    Path("pin.toml").write_text(CASE.replace(old, new, 1))
    run(["check", "pin.toml"])
    return capsys.readouterr().err


@pytest.mark.parametrize(
    ("old", "new", "advice"),
    [
        ('"30 N"', "30 N", 'a number with its unit stands in quotes: "30 N"'),
        ('"30 N"', "30,5", "decimals stand behind a point: 30.5"),
        ('"pin-on-disc"', "pin-on-disc", 'a text stands in quotes: "pin-on-disc"'),
        ('"far"', "far  # a start", 'a text stands in quotes: "far"'),
        ("9.0, step", "9.0 step", "a comma stands before step"),
        ("1.7 }", "1.7, }", "no comma stands before the }"),
        ("9.0, step", "9.0,\n step", "a table in braces ends in the same line, with }"),
        ("0.5", ".5", "a digit stands before the point: 0.5"),
        ("9.0", "9.", "a digit stands behind the point: 9.0"),
        ("{ start = 0.5, stop = 9.0, step = 1.7 }", "0.5:9.0", "{ start = 0.5, stop = 9.0,"),
        ("{ start = 0.5, stop = 9.0, step = 1.7 }", "1, 2", "stands in brackets: [1, 2]"),
        ("{ start = 0.5, stop = 9.0, step = 1.7 }", "(1, 2)", "stands in brackets: [1, 2]"),
        ("{ start = 0.5, stop = 9.0, step = 1.7 }", "[1, 2", "a list that begins above"),
        ('"a pin"', r'"\mu"', r"a backslash in double quotes is written \\"),
        ('"a pin"', '"a pin', "quotes are closed in the same line"),
        ('label = "far"', 'label: "far"', 'write label = "far"'),
        ('label = "far"', 'label "far"', 'write label = "far"'),
        ('label = "far"', "label = None", "a key without a value is left out"),
        ("[grid]", "[model]", "each table once"),
        ("schema = 1\n", "schema = 1\nschema = 1\n", "each key once"),
        ("Omega = {", "Ω = {", 'stands in quotes: "Ω" ='),
    ],
)
def test_what_is_no_toml_is_shown_with_what_to_write(
    old: str, new: str, advice: str, capsys: pytest.CaptureFixture[str]
) -> None:
    said = checked(capsys, old, new)
    assert "invalid TOML" in said and 'KEY = a number, "a text"' in said
    assert advice in said


@pytest.mark.parametrize(
    ("old", "new", "advice"),
    [
        ("30 N", "30 lbf", "unknown unit 'lbf'; it may be in N, nN, uN, mN, cN, kN, MN, GN\n"),
        (
            "30 N",
            "3*mu",
            "unknown unit '*mu': a text is a number and its unit, no formula (axes that",
        ),
        ("30 N", "N*mu", 'a unit, such as "2.5 N": no formula (axes that advance together: zip'),
        ("30 N", "30 mm", "does not fit 'N'; it may be in N,"),
        ("30 N", "30,5 N", "decimals stand behind a point"),
        ("0.5", '"3 knots"', "it may be in rad s-1, Hz,"),
        ("0.5", '"3 knots"', "rpm; of rad: "),
        ('". >= 7"', '">= 7"', 'did you mean ". >= 7"?'),
        ('". >= 7"', '"Omega >= 7"', 'did you mean ". >= 7"?'),
        ('". >= 7"', '"seven"', 'a condition on the value ".", such as ". >= 7"'),
    ],
)
def test_a_value_says_what_it_may_be(
    old: str, new: str, advice: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert advice in checked(capsys, old, new)


@pytest.mark.parametrize(
    ("table", "said"),
    [
        (
            '[[initial]]\nkind = "continue"\naxis = "v"',
            "allowed: label, kind, offset, along, direction, from, on_loss, steps\n"
            "      did you mean 'along'",
        ),
        ('[[initial]]\nkind = "state"\ncout = 3', "allowed: label, kind, state\n"),
        ("[[initial]]\nbox = {}\nnumber = 3", "allowed: label, kind, count, seed, box\n"),
        ("[schedule]\nN = { start = 1, stop = 2, time = 3 }", "allowed: start, stop, over\n"),
        (
            '[[claim]]\ntake = { what = "mean", over = "v", per = "N" }',
            "allowed: what, over\n",
        ),
    ],
)
def test_the_keys_of_its_kind_are_told_of_a_table(
    table: str, said: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "a.toml").write_text(f"{BELT}{table}\n")
    assert run(["check", str(tmp_path / "a.toml")]) == 3
    assert said in capsys.readouterr().err


def test_several_values_may_be_selected(capsys: pytest.CaptureFixture[str]) -> None:
    assert checked(capsys, '". >= 7"', '[7.3, "9.0 rad/s", ". < 1"]') == ""
    assert "'fax' is not a number" in checked(capsys, '". >= 7"', '[7.3, "fax"]')
    said = checked(capsys, 'Omega = ". >= 7"', 'initial = ["far", "fax"]')
    assert "there is no start 'fax'" in said and "did you mean 'far'?" in said


def test_what_is_wrong_with_an_argument_is_not_the_file(
    capsys: pytest.CaptureFixture[str],
) -> None:
    assert run(["run", "pin.toml", "--set", "model.param.N0=3"]) == 3
    said = capsys.readouterr().err
    assert "model.param (--set model.param.N0=3): unknown key" in said
    assert said.endswith("next: correct what --set says, then give the same command again\n")
    assert run(["run", "pin.toml", "--set", "far.kind=state"]) == 3
    assert "[[initial]]: --set initial.far.KEY=VALUE" in capsys.readouterr().err
    assert run(["check", "pin.toml", "--set", "initial.far.kind=state"]) == 0
    Path("pin.toml").write_text(CASE.replace("label =", "lable ="))
    assert run(["run", "pin.toml", "--set", "model.param.N0=3"]) == 3
    assert "next: correct the file and what --set says" in capsys.readouterr().err


def test_a_case_and_its_dataset_are_told_apart(capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["plot", "pin.toml"]) == 2
    assert "a case, not a dataset\nnext: fiv run pin.toml" in capsys.readouterr().err
    assert run(["run", "pin.toml", "--workers", "1", "-q"]) == 0
    capsys.readouterr()
    for arguments, said in (
        (["show", "pin.toml"], "next: name its dataset, runs/pin.nc\n"),
        (["run", "runs/pin.nc"], "next: fiv show runs/pin.nc, fiv plot runs/pin.nc"),
        (["plot", "pin.nc"], "did you mean 'runs/pin.nc'?"),
        (
            ["plot", "runs/pin.nc", "--figure", "map"],
            "figure map of runs/pin.nc: not written: a map needs two axes",
        ),
        (
            ["plot", "runs/pin.nc", "--figure", "map"],
            "runs/pin.nc can be drawn with --figure curve",
        ),
    ):
        assert run(arguments) == 2
        assert said in capsys.readouterr().err


@pytest.mark.parametrize(
    ("old", "new", "advice"),
    [
        ("N0 =", "F =", "here it is 'N0' (normal preload)"),
        ("N0 =", "preload =", "here it is 'N0' (normal preload)"),
        ("N0 =", "mu =", "did you mean 'mu_s'? It stands in [friction]"),
        ("N0 =", "mu_k =", "'mu_k' stands in [friction]: write it there"),
        ("\nOmega =", "\nv =", "here it is 'Omega' (disc speed)"),
        ('"Omega"', '"v"', "here it is 'Omega' (disc speed)"),
        ('"equilibrium"', '"critical"\nparameter = "F"\nbracket = [1, 2]', "here it is 'N0'"),
    ],
)
def test_the_name_of_another_model_leads_to_the_one_here(
    old: str, new: str, advice: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert advice in checked(capsys, old, new)


def test_a_long_list_is_told_once(capsys: pytest.CaptureFixture[str]) -> None:
    said = checked(capsys, "N0 =", "N00 = 1, J = 1, N0 =")
    assert said.count("J_c, J_L, k1") == 1 and said.count("allowed: as above") == 1


def test_every_model_says_which_parameter_is_its_preload_and_its_speed(
    capsys: pytest.CaptureFixture[str],
) -> None:
    for model in all_models().values():
        roles = [parameter.role for parameter in model.parameters]
        shipped = model.contacts and "thesis" in model.reference
        assert not shipped or {"preload", "speed"} <= set(roles)
        assert roles.count("speed") <= 1
    assert run(["models", "pin-on-disc"]) == 0
    assert re.search(r"^N0 +preload +N_0 ", capsys.readouterr().out, re.MULTILINE)


@pytest.mark.parametrize(
    ("old", "new", "advice"),
    [
        ('"equilibrium"', '"bifurcation"', "analyses compute, figures draw"),
        ('"state"', '"rest"', "`fiv kinds` says what each is"),
        ('"Omega"', '"Omega / 2"', "a number in rad s-1, or the name of a parameter"),
        ("{ phi_dot", "[ 1 ] # { phi_dot", "a table, as { NAME = VALUE } (values of"),
        ("stop = 9.0", "end = 9.0", "for example { start = 1, stop = 2, num = 5 }"),
        ('"30 N"', "[10, 20]", "several values are an axis, under [grid]"),
        ("[grid]", '[friction]\nname = "coulomb"\n[grid]', 'write law = "coulomb"'),
        ("[grid]", '[friction]\nlaw = ["coulomb"]\n[grid]', "write friction = ["),
        ("[grid]", '[[friction]]\nlaw = "lugre"\n[grid]', "write friction = ["),
        ("[grid]", '[grid]\nlaw = ["coulomb"]', "write friction = ["),
        ("\nOmega =", "\nomega_Omega =", "an axis where [schedule] has Omega = { amplitude"),
        ("\nOmega =", "\nA_phi =", "an axis where [forcing] has phi = { amplitude"),
        ("[grid]", '[grid]\n"friction.law" = ["coulomb"]', "write friction = ["),
        ("[grid]", "[parameters]\nN0 = 3\n[grid]", "'parameters' stands in [model]"),
        ("schema = 1", "schema = 1\nN0 = 3", "'N0' stands in [model.parameters], or as an axis in"),
        ('"pin-on-disc"', '"brake"', "`fiv models` says what each is"),
        ('"pin-on-disc"', '"pin"', "did you mean 'pin-on-disc'"),
        ('"n_solutions"', '"amplitude"', "`fiv variables pin.toml` says what each is"),
        ("[[claim]]", '[[figure]]\nkind = "curve"\ny = "n_solution"\n[[claim]]', "'n_solutions'"),
        ("{ value = 1, tolerance = 0 }", '"all of them"', '"not CLASS", "increasing"'),
        ("[[initial]]", "[solver]\nrtol = 1\n[[initial]]", "allowed: at most 0.001"),
        ("[[initial]]", "[schedule]\nN0 = [1, 2]\n[[initial]]", "{ start = 1, stop = 2, over"),
        ("[[initial]]", '[sweep]\nzip = ["Omega"]\n[[initial]]', '[["a", "b"]]'),
        ('{ Omega = ". >= 7" }', '{ start = "far" }', "allowed: Omega, initial\n"),
        ('{ Omega = ". >= 7" }', '{ v = ". >= 7" }', "here it is 'Omega' (disc speed)"),
    ],
)
def test_a_word_that_is_none_leads_to_those_there_are(
    old: str, new: str, advice: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert advice in checked(capsys, old, new)


def test_a_broken_axis_is_told_once(capsys: pytest.CaptureFixture[str]) -> None:
    said = checked(capsys, "step = 1.7", "step = 0.3")
    assert "1 problem;" in said and "the nearest stops are 8.9 and 9.2" in said


def test_a_law_is_shown_by_its_name(capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["models", "coulomb"]) == 0
    assert "|F_T| <= F_N*mu_s" in capsys.readouterr().out


def test_a_name_that_is_no_model_may_be_that_of_a_law(capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["models", "tanh"]) == 2
    assert "did you mean 'tanh of coulomb'" in capsys.readouterr().err


def test_a_case_in_which_nothing_starts_says_what_it_has(
    capsys: pytest.CaptureFixture[str],
) -> None:
    assert run(["history", "pin.toml"]) == 2
    said = capsys.readouterr().err
    assert "nothing starts in this case (equilibrium)" in said
    assert "kind response or history; or draw what it has: fiv run pin.toml, then fiv plot" in said


def test_a_misspelt_figure_or_law_to_draw(capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["run", "pin.toml", "--workers", "1", "-q"]) == 0
    assert run(["plot", "runs/pin.nc", "--figure", "curvy"]) == 2
    assert "did you mean 'curve'?" in capsys.readouterr().err
    assert run(["plot", "--law", "stribek"]) == 2
    assert "did you mean 'stribeck'" in capsys.readouterr().err


def test_an_option_of_another_command_is_named_with_what_it_takes(
    capsys: pytest.CaptureFixture[str],
) -> None:
    assert run(["new", "belt-1dof", "--law", "stribeck"]) == 2
    assert capsys.readouterr().err.endswith("next: fiv models --law LAW\n")


def test_an_option_given_again_though_one_counts(capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["new", "belt-1dof", "--analysis", "history", "--analysis", "cycle"]) == 0
    said = capsys.readouterr()
    assert 'kind = "cycle"' in said.out
    assert said.err == "WARNING: --analysis is given 2 times; the last counts\n"
    assert run(["diff", "--set", "a", "--at", "v=1", "--at", "N=1", "--json", "--json"]) == 2
    assert "WARNING" not in capsys.readouterr().err


def test_what_to_do_about_a_lost_contact_names_an_option_that_the_model_has() -> None:
    """Every model that has the option, and no other."""
    for model in all_models().values():
        options = [option.name for option in model.options]
        told = "`states`" in advice("contact_lost", "response", options)
        assert told == ("states" in options)


def test_where_tests_disagree_other_sections_are_named() -> None:
    told = advice("tests_disagree", "response")
    assert '"stick->slip" for "slip->stick", or the contrary' in told
    assert '{ zero = "x_dot" }' in told
