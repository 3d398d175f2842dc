"""What is wrong in a case is told in three phases, and each is whole.

Form, names with the values that are wrong whatever these mean, and what does not fit together.
"""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from fiv_cli.case.load import parse_case
from fiv_cli.case.toml import parse_toml, toml_text
from fiv_cli.errors import CaseError

# line -> how it would be right, in the order of the phases
FORM = {
    "schema = 2": "schema = 1",
    "titel = 'a'": "title = 'a'",
    "name = 'pin-on-disk'": "name = 'pin-on-disc'",
    "parameters = { c1 = [1], c2 = -1, d1 = 2 }": "parameters = { c1 = 1, c2 = -1, d1 = 2 }",
    "N0 = 30": "N0 = [20, 30, 30]",
    "kind = 'respons'": "kind = 'response'",
    "kind = 'stat'": "kind = 'state'",
    "kind = 'pie'": "kind = 'curve'",
    "rtol = 'a'": "rtol = 1e-9",
    "expect = { value = 3 }": "expect = { value = 3, tolerance = 1 }",
}
NAMES = {
    "d1 = 2": "k2 = 2",
    "law = 'colomb'": "law = 'coulomb'",
    "Omgea =": "Omega =",
    "zip = [['NO', 'Omega']]": "zip = [['c2', 'Omega']]",
    "fi = 0": "phi = 0",
    "observ = 'phi'": "observe = 'phi'",
    "select = { initial = 'fra' }": "select = { initial = 'far' }",
    "x = 'mu'": "x = 'c2'",
    "variable = 'atractor'": "variable = 'attractor'",
    "at = { Om = 1 }": "at = { N0 = '1 m' }",
}
VALUES = {
    "c2 = -1": "c2 = 1",
    "mu_s = 0.1": "mu_s = 0.3",
    "[20, 30, 30]": "[20, 30]",
    "stop = 1.3": "stop = 1.5",
    "zip = [['c2', 'Omega']]": "zip = [['N0', 'Omega']]",
    "count = 2": "",
    "t_max = -1": "t_max = 1",
    "x = 'c2'": "x = 'N0'",
    "variable = 'attractor'": "variable = 'period'",
    "at = { N0 = '1 m' }": "at = { N0 = 20 }",
}
CASE = """\
schema = 2
titel = 'a'
[model]
name = 'pin-on-disk'
parameters = { c1 = [1], c2 = -1, d1 = 2 }
[friction]
law = 'colomb'
mu_s = 0.1
mu_k = 0.2
[grid]
N0 = 30
Omgea = { start = 0.5, stop = 1.3, step = 1.0 }
[sweep]
zip = [['NO', 'Omega']]
[[initial]]
kind = 'stat'
label = 'far'
state = { fi = 0 }
count = 2
[[analysis]]
kind = 'respons'
observ = 'phi'
t_max = -1
[[figure]]
kind = 'pie'
x = 'mu'
select = { initial = 'fra' }
[[claim]]
source = 'here'
text = 'so'
variable = 'atractor'
at = { Om = 1 }
expect = { value = 3 }
[solver]
rtol = 'a'
"""


def mended(text: str, mistakes: dict[str, str]) -> str:
    for wrong, right in mistakes.items():
        assert text.count(wrong) == 1, wrong
        text = text.replace(wrong, right)
    return text


def told(text: str) -> list[str]:
    with pytest.raises(CaseError) as caught:
        parse_case(text, "a.toml")
    assert all(problem.line is not None for problem in caught.value.problems)
    return [problem.path for problem in caught.value.problems]


def test_the_form_is_told_first_and_whole() -> None:
    assert told(CASE) == [
        "schema",
        "titel",
        "model.name",
        "model.parameters.c1",
        "grid.N0",
        "initial.0.kind",
        "analysis.0.kind",
        "figure.0.kind",
        "claim.0.expect",
        "solver.rtol",
    ]


def test_then_names_and_values_that_are_wrong_whatever_these_mean() -> None:
    assert told(mended(CASE, FORM)) == [
        "model.parameters.d1",
        "model.parameters.c2",
        "friction.law",
        "grid.N0",
        "grid.Omgea",
        "sweep.zip.0",
        "initial.0.state.fi",
        "initial.0.count",
        "analysis.0.observ",
        "analysis.0.t_max",
        "figure.0.x",
        "figure.0.select.initial",
        "claim.0.variable",
        "claim.0.at.Om",
    ]


def test_then_what_does_not_fit_and_the_third_look_is_the_last() -> None:
    text = mended(mended(CASE, FORM), NAMES)
    assert told(text) == [
        "model.parameters.c2",
        "friction.mu_k",
        "grid.N0",
        "grid.Omega.stop",
        "sweep.zip.0",
        "initial.0.count",
        "analysis.0.t_max",
        "figure.0.x",
        "claim.0.at.N0",
        "claim.0.expect",
    ]
    assert parse_case(mended(text, VALUES), "a.toml").zips == (("N0", "Omega"),)


KEYS = {
    "analysis": ("[[analysis]]", "[[anaylsis]]"),
    "model.parameters": ("parameters =", "paramters ="),
    "grid.Omega.stop": ("stop =", "stopp ="),
    "initial.0.label": ("label =", "lable ="),
    "analysis.0.kind": ("kind = 'response'", "knid = 'response'"),
    "analysis.0.t_max": ("t_max =", "tmax ="),
    "figure.0.select": ("select =", "selct ="),
    "claim.0.text": ("text =", "txt ="),
}


@pytest.mark.parametrize("key", KEYS)
def test_a_misspelt_key_hides_nothing_and_nothing_else_follows_from_it(key: str) -> None:
    """The case is right but for it, then wrong in all its values."""
    text = mended(mended(CASE, FORM), NAMES)
    spelt = told(text)
    for case, rest in ((mended(text, VALUES), []), (text, spelt)):
        with pytest.raises(CaseError) as caught:
            parse_case(mended(case, dict([KEYS[key]])), "a.toml")
        (wrong, *others) = sorted(
            caught.value.problems, key=lambda problem: "unknown" not in problem.message
            and "no setting" not in problem.message
        )  # fmt: skip
        assert f"did you mean '{key.split('.')[-1]}'" in wrong.suggestion
        assert {problem.path for problem in others} == {*rest}


def test_from_what_a_figure_or_a_claim_names_nothing_follows() -> None:
    text = mended(mended(mended(CASE, FORM), NAMES), VALUES)
    wrong = {"x = 'N0'": "x = 'mu'", "at = { N0 = 20 }": "at = { N0 = 21 }"}
    assert told(mended(text, wrong)) == ["figure.0.x", "claim.0.at.N0"]


@pytest.mark.parametrize(
    ("case", "table", "name"),
    [
        ("ch3/belt_harmonic", "schedule", "v"),
        ("ch5/fig_5_11a", "friction", "law"),
        ("ch5/fig_5_05", "model", "A_b"),
        ("ch6/fig_6_10", "grid", "k_nl"),
        ("ch5/critical_speed", "friction", "law"),
    ],
)
def test_from_a_misspelt_name_only_unknown_names_follow(case: str, table: str, name: str) -> None:
    """No phase of an excitation that is not there, and no property of a law that is not meant."""
    path = Path("configs") / f"{case}.toml"
    document = parse_toml(path.read_text())
    inner = document[table]["parameters"] if table == "model" else document[table]
    if name == "law":
        inner[name] += "zq"
    else:
        inner[f"{name}zq"] = inner.pop(name)
    with pytest.raises(CaseError) as caught:
        parse_case(toml_text(document), str(path))
    said = [problem.message for problem in caught.value.problems]
    assert all(
        re.search("unknown|nothing called|no parameter|no friction law", one) for one in said
    )
