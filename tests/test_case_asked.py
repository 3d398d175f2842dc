"""Figures and claims ask for what the analyses of their case will hold, or the case is refused."""

from __future__ import annotations

import re
from contextlib import nullcontext
from pathlib import Path

import pytest

from fiv_cli.case.grammar import Bounds
from fiv_cli.case.load import load_case, parse_case
from fiv_cli.case.others import held_otherwise, not_run
from fiv_cli.errors import CaseError, Problem
from fiv_cli.sweep.plan import make_plan

BELT = """\
schema = 1
[model]
name = "belt-1dof"
[grid]
v = [0.5, 1.0]
[[analysis]]
kind = "response"
[[analysis]]
kind = "eigenvalues"
"""


BOUNDARY = """\
[[analysis]]
kind = "boundary"
parameter = "mu_k"
bracket = [0.1, 0.2]
of = { expect = "periodic" }
"""


def claim(variable: str, expect: str, *lines: str) -> str:
    table = ["[[claim]]", 'source = "a"', 'text = "b"', f'variable = "{variable}"']
    return BELT + "\n".join([*table, f"expect = {expect}", *lines]) + "\n"


TAKE = 'take = { what = "share", of = ". > 0", over = "v" }'
OF_CLASS = TAKE.replace(". > 0", "periodic")
MEAN = 'take = { what = "mean", over = "v" }'
CLASSES = 'take = { what = "classes", over = "v" }'


SPREAD = 'take = { what = "spread", over = "initial" }'
LIMITS = "ylim = { perod = [0, 1] }"
SEVERAL = 'variable = ["L_s", "growth_rate"]'
START_AXIS = '[grid]\n"initial.x" = [0.0, 0.1, 0.2]'
LESS = "{{ less_than = {{ {} }} }}"
THERE = "claim.0.expect.less_than"
OVER = f"{THERE}.take.over"
COMPARED = (
    '{ value = { variable = "mode_frequency", at = { mode = 0 }, times = 2 }, tolerance = "5 %" }'
)


def figure(*lines: str) -> str:
    return BELT + "\n".join(["[[figure]]", *lines]) + "\n"


def plane(*lines: str) -> str:
    return figure('kind = "map"', *lines).replace("v = [0.5, 1.0]", "v = [0.5, 1.0]\nk = [1, 2]")


def test_what_other_cases_found_is_overlaid_on_levels_of_what_is_mapped_alone() -> None:
    """Of classes, too, which have no level, it said: attractor = NUMBER."""
    for variable in ("L_s", "attractor"):
        lines = plane(
            'level = { "b:boundary" = "v" }', f'variable = "{variable}"', "overlay = true"
        )
        with pytest.raises(CaseError, match="alone, and has none") as refused:
            make_plan(parse_case(lines, "a.toml"))
        assert "variable = A NUMBER" in str(refused.value)
        assert "attractor = NUMBER" not in str(refused.value)


def test_a_motion_has_a_force_at_each_instant_though_an_equilibrium_has_but_one() -> None:
    shown = figure('kind = "history"', 'variable = "F_T"')
    make_plan(parse_case(shown + '[[analysis]]\nkind = "equilibrium"\n', "a.toml"))


@pytest.mark.parametrize("kind", ["history", "spectrum"])
def test_of_a_motion_a_state_is_a_variable_and_no_axis(kind: str) -> None:
    found = problem(figure(f'kind = "{kind}"', 'select = { state = "x" }'))
    assert found.path == "figure.0.select.state" and found.allowed == 'variable = "x"'
    make_plan(parse_case(figure(f'kind = "{kind}"', found.allowed), "a.toml"))


def of_two(text: str) -> str:
    return text.replace("belt-1dof", "belt-2mass")


def problem(text: str) -> Problem:
    """The one problem of a case, when it is planned."""
    with pytest.raises(CaseError) as caught:
        make_plan(parse_case(text, "a.toml"))
    (only,) = caught.value.problems
    return only


@pytest.mark.parametrize(
    "text",
    [
        claim("attractor", '"not equilibrium"'),
        claim("L_s", '"increasing"'),
        claim("period", "{ value = 6.3, tolerance = 1.0 }", 'analysis = "response"'),
        claim("L_s", "{ between = [0.5, 1.0] }"),
        claim("attractor", "{ less_than = 1 }", OF_CLASS),
        claim("L_s", "{ less_than = 1 }", TAKE),
        claim("stable", '"unstable"'),
        claim("v", '"increasing"'),
        claim("x_min", '{ less_than = "x_max" }'),
        claim("L_s", "{ less_than = { at = { v = 0.5 }, times = 2 } }", "at = { v = 1.0 }"),
        claim("response_frequency", COMPARED),
        claim("L_s", LESS.format('take = { what = "mean", over = "v" }'), TAKE),
        figure('kind = "curve"', 'variable = ["x_min", "x_max"]'),
        figure('kind = "curve"', SEVERAL),
        figure('kind = "curve"', 'x = "v"', SEVERAL, "select = { mode = 0 }"),
        figure('kind = "history"', 'variable = "friction_power"'),
        figure('kind = "curve"', "log = true", "xlim = [0.1, 1]"),
        figure('kind = "curve"', 'variable = ["period", "L_s"]', LIMITS.replace("perod", "period")),
        figure('kind = "eigenvalues"', "ylim = { mode_frequency = [0, 1] }"),
        figure('kind = "history"', "ylim = { x = [0, 1] }"),
        figure('kind = "history"', 'variable = ["x", "F_T"]', "ylim = { F_T = [0, 1] }"),
        figure('kind = "curve"', 'log = "y"', "xlim = [0, 1]"),
        plane('variable = "L_s"', "log = true", "zlim = [0, 1]"),
        plane('variable = "attractor"', "level = { growth_rate = 0.0 }"),
        plane("level = { damping_ratio = [0, 0.1] }", "select = { mode = 0 }"),
        plane('variable = "L_s"', "level = { L_s = 0.1, growth_rate = 0 }"),
        plane('variable = "attractor"', OF_CLASS, "level = { share = 0.5, growth_rate = 0 }"),
    ],
)
def test_what_will_be_there(text: str) -> None:
    case = parse_case(text, "a.toml")
    assert make_plan(case).size == 2 * 2 ** len(case.axes)


@pytest.mark.parametrize(
    ("text", "path", "words"),
    [
        (claim("atractor", '"periodic"'), "claim.0.variable", "did you mean 'attractor'"),
        (claim("Ls", "{ less_than = 1 }"), "claim.0.variable", "'Ls'"),
        (claim("x", "{ less_than = 1 }"), "claim.0.variable", "'x'"),
        (
            claim("period", '"increasing"', 'analysis = "eigenvalues"'),
            "claim.0.variable",
            "'period'",
        ),
        (claim("L_s", '"periodic"'), "claim.0.expect", "no class 'periodic'"),
        (
            claim("L_s", '"increasing"') + '[[analysis]]\nname = "again"\nkind = "response"\n',
            "claim.0.variable",
            "of several analyses",
        ),
        (claim("attractor", "{ value = 3, tolerance = 1 }"), "claim.0.expect", "not a number"),
        (claim("attractor", "{ less_than = 3 }"), "claim.0.expect", "not a number"),
        (
            claim("attractor", '"periodic"', 'undecided = "counts"'),
            "claim.0.undecided",
            "they have no class",
        ),
        (claim("attractor", '"increasing"'), "claim.0.expect", "not a number"),
        (claim("attractor", '"not perodic"'), "claim.0.expect", "did you mean 'periodic'"),
        (claim("L_s", '"periodic"', TAKE), "claim.0.expect", "'share' is a number"),
        (claim("L_s", "{ less_than = 1 }", OF_CLASS), "claim.0.take.of", "no class 'periodic'"),
        (claim("stable", "{ less_than = 1 }", OF_CLASS), "claim.0.take.of", "no class 'periodic'"),
        (claim("attractor", "{ less_than = 1 }", MEAN), "claim.0.take.what", "there is no mean"),
        (claim("L_s", "{ less_than = 2 }", CLASSES), "claim.0.take.what", "has no classes"),
        (figure('kind = "curve"', 'variable = "L_s"', OF_CLASS), "figure.0.take.of", "a number"),
        (
            figure('kind = "history"', 'variable = "friction_work"'),
            "figure.0.variable",
            "friction_work",
        ),
        (claim("L_s", LESS.format("at = { v = 2 }")), f"{THERE}.at.v", "2 is not on the axis"),
        (claim("L_s", LESS.format("at = { u = 2 }")), f"{THERE}.at.u", "nothing called 'u'"),
        (claim("L_s", '{ less_than = "L_s" }'), THERE, "is what the claim itself is about"),
        (claim("L_s", LESS.format('variable = "L"')), f"{THERE}.variable", "computes 'L'"),
        (claim("L_s", LESS.format('analysis = "b"')), f"{THERE}.analysis", "named 'b'"),
        (claim("L_s", LESS.format('variable = "attractor"')), f"{THERE}.variable", "a class"),
        (claim("L_s", LESS.format('variable = "x_max"')), THERE, "'x_max' is in m, 'L_s' in m2"),
        (claim("L_s", LESS.format('variable = "section_value"')), THERE, "several values"),
        (claim("growth_rate", LESS.format('variable = "eigenvalue_real"')), THERE, "several"),
        (claim("L_s", LESS.format('take = { what = "mean" }')), OVER, "missing"),
        (claim("L_s", '{ less_than = "belt:L_s" }'), THERE, "there is no case belt.toml"),
        (claim("L_s", f'{{ less_than = "{"x" * 5000}:L_s" }}'), THERE, "there is no case xx"),
        (
            claim("L_s", LESS.format('take = { what = "share", over = "v" }')),
            f"{THERE}.take",
            "of:",
        ),
        (claim("L_s", LESS.format('take = { what = "mean", over = "u" }')), OVER, "called 'u'"),
        (claim("stable", '"yess"'), "claim.0.expect", "no class 'yess'"),
        (figure('kind = "curve"', 'variable = "L_S"'), "figure.0.variable", "did you mean 'L_s'"),
        (figure('kind = "curve"', 'variable = ["L_s", "z"]'), "figure.0.variable", "'z'"),
        (plane(SEVERAL), "figure.0.variable", "of one analysis"),
        *(
            (
                figure('kind = "curve"', x, SEVERAL).replace("[grid]", START_AXIS),
                "figure.0.x",
                "'growth_rate' of the analysis 'eigenvalues' has no axis 'initial.x'",
            )
            for x in ('x = "initial.x"', "")
        ),
        (
            figure('kind = "curve"', SEVERAL) + '[[analysis]]\nname = "again"\nkind = "response"\n',
            "figure.0.variable",
            "2 analyses compute 'L_s'",
        ),
        (
            figure('kind = "curve"', SEVERAL, "select = { crossing = 0 }"),
            "figure.0.select.crossing",
            "has no axis 'crossing'",
        ),
        (figure('kind = "curve"', 'y = "L_S"'), "figure.0.y", "did you mean 'L_s'"),
        (figure('kind = "curve"', "log = true", "xlim = [0, 1]"), "figure.0.xlim", "above 0"),
        (figure('kind = "curve"', SEVERAL, LIMITS), "figure.0.ylim.perod", "no variable of this"),
        (figure('kind = "bifurcation"', LIMITS), "figure.0.ylim", "with a panel for each"),
        (figure('kind = "history"', LIMITS), "figure.0.ylim.perod", "no variable of this"),
        (plane('variable = "L_s"', 'log = "z"', "zlim = [0, 1]"), "figure.0.zlim", "above 0"),
        (
            plane('variable = "L_s"', SPREAD, "level = { L_s = [0.1] }"),
            "figure.0.level.L_s",
            "this map shows the spread of 'L_s'",
        ),
        (figure('kind = "curve"', 'log = "xz"'), "figure.0.log", "a curve has no shades"),
        (figure('kind = "history"', "contact = 2"), "figure.0.contact", "is no contact 2"),
        (of_two(figure('kind = "history"', "contact = [1, 0]")), "figure.0.contact", "contact 0"),
        (of_two(figure('kind = "phase"', "contact = [1, 2]")), "figure.0.contact", "one contact"),
        (
            of_two(figure('kind = "history"', 'variable = "F_T_1"')),
            "figure.0.variable",
            'write variable = "F_T", contact = 1',
        ),
        (
            figure('kind = "history"', 'variable = "L_s"'),
            "figure.0.variable",
            "'L_s' has no value at each instant of a motion",
        ),
        (
            of_two(claim("F_N2", "{ less_than = 1 }") + '[[analysis]]\nkind = "equilibrium"\n'),
            "claim.0.variable",
            'write variable = "F_N", at = { contact = 2 }',
        ),
        (
            figure('kind = "curve"', 'variable = "growth_rate"', 'analysis = "response"'),
            "figure.0.variable",
            "the analysis 'response' does not compute 'growth_rate'",
        ),
        (
            figure('kind = "bifurcation"', 'variable = "x_max"'),
            "figure.0.variable",
            'kind = "curve" shows x_max along an axis; every value at which x turns back: '
            'observe = "x" and section = { zero = "x_dot" }',
        ),
        (
            figure('kind = "bifurcation"', 'variable = "L_s"'),
            "figure.0.variable",
            'kind = "curve" shows L_s along an axis',
        ),
        *(
            (
                figure(f'kind = "{kind}"', f'{key} = "section_value"'),
                f"figure.0.{key}",
                f'of a motion, which this figure shows kind = "{other}" shows section_value',
            )
            for kind, key, other in (
                ("phase", "x", "bifurcation"),
                ("phase", "variable", "bifurcation"),
                ("history", "variable", "bifurcation"),
            )
        ),
        (
            figure('kind = "bifurcation"', 'select = { attractor = "periodic" }'),
            "figure.0.select.attractor",
            "is a result, and no axis to a class a curve narrows itself",
        ),
        (plane("level = 0.5"), "figure.0.level", "'attractor' holds classes"),
        (
            figure('kind = "curve"', 'variable = "boundary"').replace(
                '[[analysis]]\nkind = "response"\n', BOUNDARY + BOUNDARY + 'name = "other"\n'
            ),
            "figure.0.analysis",
            'shows that of one analysis = "other"',
        ),
        (plane("level = { stable = 0.5 }"), "figure.0.level.stable", "have no level"),
        (plane("level = { growth_rate = 0 }", "overlay = true"), "figure.0.overlay", "alone"),
        (plane("level = { growth = 0 }"), "figure.0.level.growth", "here it is 'growth_rate'"),
        (plane('level = { growth_rate = "v" }'), "figure.0.level.growth_rate", "another case"),
        (plane('level = { attractor = "periodic" }'), "figure.0.level.attractor", "have no level"),
        (plane('level = { growth_rate = "" }'), "figure.0.level", "must be a number"),
        (plane("level = { damping_ratio = 0 }"), "figure.0.level.damping_ratio", "for each mode"),
        (
            plane('variable = "L_s"', "level = [1, 2, 3, 4, 5, 6, 7, 8, 9]"),
            "figure.0.level",
            "9 lines in one map",
        ),
        (plane("level = { growth_rate = [] }"), "figure.0.level", "not an empty list"),
        (
            figure(
                'kind = "curve"',
                'x = "v"',
                "select = { v = 99 }",
                'take = { what = "share", of = "periodic", over = "initial" }',
            ),
            "figure.0.select.v",
            "99 is not on the axis v",
        ),
        (figure('kind = "curve"', "contact = 2"), "figure.0.contact", "has no contact"),
        (figure('kind = "curve"', "window = [0, 1]"), "figure.0.window", "has no window"),
        (figure('kind = "curve"', 'log = "y"', "ylim = [-1, 1]"), "figure.0.ylim", "above 0"),
        (figure('kind = "curve"', 'name = "a/b"'), "figure.0.name", "name of a file"),
        (figure('kind = "curve"', 'name = ""'), "figure.0.name", "name of a file"),
    ],
)
def test_what_will_not_be_there(text: str, path: str, words: str) -> None:
    found = problem(text)
    assert found.path == path
    assert found.line is not None
    assert words in f"{found.message} {found.suggestion}"


def test_a_curve_is_not_narrowed_to_a_number() -> None:
    along = figure('kind = "curve"', 'variable = "boundary"', "select = { boundary_width = 1 }")
    found = problem(along.replace('[[analysis]]\nkind = "response"\n', BOUNDARY))
    assert "status" in found.allowed and "is a number" in found.message


def test_a_curve_is_narrowed_to_a_class_that_stands_beside_its_values() -> None:
    curve = figure('kind = "curve"', 'variable = "boundary"', "select = { CLASS }")
    curve = curve.replace('[[analysis]]\nkind = "response"\n', BOUNDARY)
    make_plan(parse_case(curve.replace("CLASS", 'class_below = "periodic"'), "a.toml"))
    found = problem(curve.replace("CLASS", 'class_below = "periodc"'))
    assert "has no class 'periodc'" in found.message


@pytest.mark.parametrize(
    ("grid", "lines", "left"),
    [
        ("v = [1, 2]", (), ""),
        ("v = [1, 2]\nk = [3, 4]", (), "v, k"),
        ("v = [1, 2]\nk = [3, 4]\n[sweep]\nzip = [['v', 'k']]", (), ""),
        ("v = [1, 2]\nk = [3, 4]", ("at = { k = 3 }",), ""),
        ("v = [1, 2]\nk = [3, 4, 5]", ('at = { k = ". >= 4" }',), "v, k"),
        ("v = [1, 2]\nk = [3, 4]", (MEAN,), ""),
        ("v = [1, 2]\n'initial.x' = [3, 4]", (MEAN.replace('"v"', '"initial.x"'),), ""),
        ("v = [1, 2]", ("at = { v = 2 }",), "none"),
        ("v = [1]", (), "none"),
    ],
)
def test_a_trend_is_along_the_one_axis_that_is_left(
    grid: str, lines: tuple[str, ...], left: str
) -> None:
    text = claim("L_s", '"increasing"', *lines).replace("v = [0.5, 1.0]", grid)
    if left:
        assert problem(text).message.endswith(f"left are {left}")
    else:
        make_plan(parse_case(text, "a.toml"))


def test_a_bifurcation_diagram_without_an_axis_is_told_what_draws_a_branch() -> None:
    text = figure('kind = "bifurcation"', 'x = "v"').replace("v = [0.5, 1.0]", "")
    assert 'kind = "branch"' in problem(text).allowed


def test_another_case_is_asked_for_one_number_at_each_point(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("belt.toml").write_text(BELT)
    asked = {"attractor": "a class", "eigenvalue_real": "several values", "L_s": ""}
    for name, told in asked.items():
        text = claim("L_s", f'{{ less_than = "belt:{name}" }}')
        assert told in problem(text).message if told else make_plan(parse_case(text, "a.toml"))


def test_of_an_analysis_that_is_not_understood_any_variable_may_be_asked() -> None:
    """Which it has depends on what was misspelt; what none of its kind has is told all the same."""
    text = claim("L_s", '"increasing"') + figure('kind = "curve"', 'x = "w"').replace(BELT, "")
    text = text.replace('kind = "response"', 'kind = "response"\nobserve = "xinf"')
    with pytest.raises(CaseError) as caught:
        parse_case(text.replace('"L_s"', '"Ls"'), "a.toml")
    assert [p.path for p in caught.value.problems] == [
        "analysis.0.observe",
        "claim.0.variable",
        "figure.0.x",
    ]


def test_a_case_that_a_claim_compares_with_is_read_where_it_lies(tmp_path: Path) -> None:
    """Its variables are known; that it was not run is told, and that it names this one is fine."""
    this, other = tmp_path / "this.toml", tmp_path / "other.toml"
    this.write_text(claim("L_s", '{ less_than = "other:L_s" }'))
    other.write_text(claim("L_s", '{ greater_than = "this:L_s" }'))
    (told,) = not_run(load_case(this))
    assert told.endswith(f"not run yet: fiv run {other}")
    rest = BELT.replace("response", "equilibrium")
    for text, words in ((rest, "computes 'L_s'"), ("schema = 1", f"fiv check {other}")):
        other.write_text(text)
        with pytest.raises(CaseError, match=words):
            load_case(this)


def test_an_axis_that_the_other_case_alone_has_is_told_with_all_that_narrows_it(
    tmp_path: Path,
) -> None:
    """What is allowed is taken as it stands."""
    this, other = tmp_path / "this.toml", tmp_path / "other.toml"
    other.write_text(BELT.replace("[0.5, 1.0]", "[0.5, 1.0]\nN = [1.0, 2.0]"))
    for variable, own, at in (
        ("L_s", "N = 1.0", []),
        ("floquet_multiplier", "N = 1.0", ["at = { multiplier = 1 }"]),
        ("floquet_multiplier", "multiplier = 0, N = 1.0", []),
    ):
        this.write_text(claim(variable, f'{{ less_than = "other:{variable}" }}', *at))
        with pytest.raises(CaseError) as caught:
            load_case(this)
        (told,) = caught.value.problems
        assert f"at = {{ {own} }} }}" in told.allowed
        this.write_text(claim(variable, f"{{ {told.allowed.partition(', or that')[0]} }}", *at))
        load_case(this)
    zipped = "[0.5, 1.0]\nN = [1.0, 2.0]\nm = [1.0, 2.0]\n[sweep]\nzip = [['N', 'm']]"
    other.write_text(BELT.replace("[0.5, 1.0]", zipped))
    said = "less_than = { case = 'other', variable = 'L_s', times = 0.5"
    this.write_text(claim("L_s", f"{{ {said} }} }}"))
    with pytest.raises(CaseError, match=r"at = { N = 1.0 }, times = 0.5 }"):
        load_case(this)
    for name in ("N", "m"):  # either tells which
        this.write_text(claim("L_s", f"{{ {said}, at = {{ {name} = 2.0 }} }} }}"))
        load_case(this)


def test_a_case_whose_line_a_map_draws_is_read_where_it_lies(tmp_path: Path) -> None:
    this, other = tmp_path / "this.toml", tmp_path / "other.toml"
    this.write_text(plane('variable = "attractor"', 'level = { "other:growth_rate" = 0.0 }'))
    other.write_text(BELT)
    (told,) = not_run(load_case(this))
    assert told == f"a map draws a line of other, not run yet: fiv run {other}"
    assert [*held_otherwise(load_case(this))] == []
    (told,) = held_otherwise(load_case(this, ["model.parameters.m=2.0"]))
    assert f"other, which is computed at m = 1 (here 2): give {other} what this" in told
    critical = 'kind = "critical"\nparameter = "mu_k"\nbracket = [0.0, 1.0]'
    (tmp_path / "crossings.toml").write_text(BELT.replace('kind = "response"', critical))
    for level, words in (
        ('"v"', ""),
        ('"vv"', "did you mean 'v'"),
        ("0.5", "no one number at each point.*"),
    ):
        line = f'level = {{ "crossings:critical_value" = {level} }}'
        this.write_text(plane('variable = "attractor"', line))
        with pytest.raises(CaseError, match=words) if words else nullcontext():
            load_case(this)
    for name, words in (
        ("growth", "no analysis of .*other.toml computes 'growth'"),
        ("stable", "'stable' has no one number"),
        ("damping_ratio", "'damping_ratio' has no one number"),
    ):
        this.write_text(plane('variable = "attractor"', f'level = {{ "other:{name}" = 0.0 }}'))
        with pytest.raises(CaseError, match=words):
            load_case(this)


def test_what_is_told_to_write_of_several_values_can_be_written() -> None:
    """Also where what is compared with was no table."""
    text = claim("growth_rate", '{ less_than = "eigenvalue_real" }')
    with pytest.raises(CaseError, match="has several values at a point") as caught:
        parse_case(text, "a.toml")
    told = re.search(r"allowed: less_than = (\{.*\}), or that", str(caught.value))
    assert told is not None
    written = text.replace('"eigenvalue_real"', told[1])
    bounds = parse_case(written, "a.toml").claims[0].expect
    assert isinstance(bounds, Bounds)
    (reference,) = bounds.references.values()
    assert (reference.variable, dict(reference.at)) == ("eigenvalue_real", {"mode": 0})


def test_a_result_of_another_analysis_narrows_nothing_and_is_told_so() -> None:
    text = claim("growth_rate", "{ less_than = 0.0 }", 'at = { attractor = "equilibrium" }')
    with pytest.raises(CaseError, match="'eigenvalues' has no axis 'attractor'") as caught:
        parse_case(text, "a.toml")
    assert "a result narrows what is drawn, or claimed, of its own analysis alone" in str(
        caught.value
    )


def test_a_basin_is_of_the_only_response_whatever_other_analyses_there_are() -> None:
    two = '[[analysis]]\nkind = "eigenvalues"\nname = "other"\n'
    assert parse_case(BELT + two + '[[figure]]\nkind = "basin"\n', "a.toml", ())


@pytest.mark.parametrize(("name", "is_known"), [("x", True), ("initial.x_dot", True), ("z", False)])
def test_a_basin_is_drawn_over_components_of_starts(name: str, is_known: bool) -> None:
    """Which its axes call ``initial.x``, and the model ``x``."""
    text = figure('kind = "basin"', f'x = "{name}"')
    with nullcontext() if is_known else pytest.raises(CaseError, match="there is no state 'z'"):
        parse_case(text, "case.toml", ())


def test_what_a_figure_shows_unasked_may_not_be_of_two_analyses() -> None:
    """One of them would be left out without a word."""
    second = BOUNDARY.replace(
        'kind = "boundary"', 'kind = "boundary"\nname = "followed"\nfollow = "up"'
    )
    curve = '[[figure]]\nkind = "curve"\nx = "v"\n'
    assert parse_case(BELT.partition("[[analysis]]")[0] + BOUNDARY + curve, "a.toml", ())
    with pytest.raises(CaseError, match="2 analyses compute boundary, and a figure shows that of"):
        parse_case(BELT.partition("[[analysis]]")[0] + BOUNDARY + second + curve, "a.toml", ())
