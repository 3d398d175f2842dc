"""Reading case files: what a good one means, and that a bad one is told all that is wrong."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from fiv_cli import api
from fiv_cli.analyses.base import Section, SolverSettings
from fiv_cli.case.case import Case, StartSpec
from fiv_cli.case.identity import fingerprint
from fiv_cli.case.load import load_case, parse_case
from fiv_cli.case.starts import AT_REST
from fiv_cli.errors import CaseError, Problem, UsageError
from fiv_cli.friction import get_law
from fiv_cli.models import get_model
from fiv_cli.models.origin import Origin

PIN = """\
schema = 1
title = "Map"
reference = "Figure 7.6"
assumed = ["initial.far"]

[model]
name = "pin-on-disc"
parameters = { c1 = 0.002, "β" = "15 deg" }

[friction]
mu_k = 0.2

[grid]
"Ω" = { start = 0.5, stop = 2.0, step = 0.5 }
N0 = ["30 N", "0.05 kN"]

[[initial]]
label = "far"
kind = "state"
state = { phi_dot = "Omega", theta = "1 deg" }

[[analysis]]
kind = "response"
section = { zero = "phi_dot", direction = "up" }
t_max = "2 min"

[[figure]]
kind = "map"
x = "Ω"
y = "N0"
select = { initial = "far" }

[[claim]]
source = "7.3"
text = "periodic"
variable = "attractor"
expect = "periodic"
at = { N0 = "30 <= . < 40", "Ω" = "0.5 rad/s", initial = "far" }
"""

BELT = """\
schema = 1
[model]
name = "belt-1dof"
[[analysis]]
kind = "history"
t_end = 30
"""


def parse(text: str, *overrides: str) -> Case:
    return parse_case(text, "case.toml", overrides)


def problems(text: str, *overrides: str) -> list[Problem]:
    """Everything wrong with a case; fails when nothing is."""
    with pytest.raises(CaseError) as caught:
        parse(text, *overrides)
    return list(caught.value.problems)


def only_problem(text: str, *overrides: str) -> Problem:
    (problem,) = problems(text, *overrides)
    return problem


FLUTTER = """\
schema = 1
[model]
name = "flutter-2dof"
[friction]
stribeck.mu_s = 0.9
[grid]
friction = ["coulomb", "stribeck"]
mu_k = [0.5]
[[analysis]]
kind = "response"
"""


def belt(*lines: str) -> str:
    """The belt's case with more lines, tables behind it."""
    return BELT + "\n".join(lines) + "\n"


class TestGoodCase:
    def test_what_is_given_for_one_law_is_not_the_others(self) -> None:
        case = parse(FLUTTER)
        assert case.parameters_at("stribeck", {"mu_k": 0.5})["mu_s"] == 0.9
        assert case.parameters_at("coulomb", {"mu_k": 0.5})["mu_s"] == 0.5

    def test_everything_written_arrives(self) -> None:
        case = parse(PIN)
        assert (case.title, case.reference, case.assumed) == (
            "Map",
            "Figure 7.6",
            ("initial.far",),
        )
        assert (case.model, case.law) == ("pin-on-disc", "coulomb")
        assert case.parameters["c1"] == 0.002
        assert case.parameters["mu_k"] == 0.2
        assert case.parameters["beta"] == pytest.approx(math.pi / 12, rel=1e-15)
        assert case.axis("Omega").values == (0.5, 1.0, 1.5, 2.0)
        assert case.axis("N0").values == (30.0, 50.0)
        assert [axis.name for axis in case.axes] == ["Omega", "N0"]
        assert set(case.explicit) == {"c1", "beta", "mu_k"}

    def test_analysis_is_complete(self) -> None:
        (analysis,) = parse(PIN).analyses
        assert analysis.name == analysis.kind == "response"
        assert analysis.settings == {
            "section": Section("zero", state="phi_dot", direction="up"),
            "observe": None,
            "t_max": 120.0,
            "transient": 0.0,
            "lyapunov": "auto",
            "powers": "none",
        }

    def test_start_names_a_parameter(self) -> None:
        (start,) = parse(PIN).starts
        assert start.state == {"phi_dot": "Omega", "theta": math.pi / 180}

    def test_figures_and_claims_speak_the_contract_names(self) -> None:
        case = parse(PIN)
        assert case.figures[0].settings["x"] == "Omega"
        assert case.claims[0].at == {"N0": "30 <= . < 40", "Omega": 0.5, "initial": "far"}

    def test_axes_are_no_parameters(self) -> None:
        assert not {"Omega", "N0"} & set(parse(PIN).parameters)

    def test_defaults_are_the_models_before_the_laws(self) -> None:
        assert parse(BELT).parameters["mu_k"] == 0.23

    def test_default_start_is_at_rest(self) -> None:
        assert parse(BELT).starts == (AT_REST,)
        assert StartSpec("rest", "state") == AT_REST

    def test_default_solver(self) -> None:
        assert parse(BELT).solver == SolverSettings()

    def test_file_and_text_mean_the_same(self, tmp_path: Path) -> None:
        file = tmp_path / "case.toml"
        file.write_text(PIN, encoding="utf-8")
        case = load_case(file)
        assert case.text == PIN
        assert case.axes == parse(PIN).axes

    def test_byte_order_mark_is_harmless(self, tmp_path: Path) -> None:
        file = tmp_path / "case.toml"
        file.write_bytes(b"\xef\xbb\xbf" + BELT.encode())
        assert load_case(file).model == "belt-1dof"

    def test_unquoted_start_axis(self) -> None:
        case = parse(belt("[grid]", "initial.x_dot = [0.0, 1.0]", "friction.mu_k = [0.1]"))
        assert [(axis.name, axis.kind) for axis in case.axes] == [
            ("initial.x_dot", "start"),
            ("mu_k", "parameter"),
        ]
        assert case.axes[0].dim == "initial_x_dot"


class TestFriction:
    def test_tanh_takes_the_default_law(self) -> None:
        case = parse(belt("[friction]", 'law = "tanh"', "sigma = 20"))
        assert case.law == "tanh of coulomb"
        assert case.parameters["sigma"] == 20.0
        assert "mu_s" not in case.parameters

    def test_tanh_of_another(self) -> None:
        case = parse(belt("[friction]", 'law = "tanh"', 'of = "stribeck"'))
        assert case.law == "tanh of stribeck"

    def test_of_without_tanh(self) -> None:
        problem = only_problem(belt("[friction]", 'law = "stribeck"', 'of = "coulomb"'))
        assert problem.path == "friction.of"

    def test_laws_as_an_axis_keep_their_own_parameters(self) -> None:
        case = parse(
            belt(
                "[friction]",
                "mu_s = 0.5",
                "[friction.hyperbolic]",
                "delta = 2.0",
                "[grid]",
                'friction = ["coulomb", "stribeck", "hyperbolic", "tanh"]',
            )
        )
        assert case.axis("friction").values[-1] == "tanh of coulomb"
        assert case.parameters["mu_s"] == 0.5
        assert case.parameters_at("hyperbolic", {})["delta"] == 2.0
        assert case.parameters_at("stribeck", {})["delta"] == 1.0
        assert "delta" not in case.parameters_at("coulomb", {})
        assert case.parameters_at("stribeck", {"mu_s": 0.7})["mu_s"] == 0.7

    def test_a_parameter_that_laws_read_differently_is_refused(self) -> None:
        text = belt("[friction]", "delta = 2", "[grid]", 'friction = ["stribeck", "hyperbolic"]')
        assert "different things" in only_problem(text).message

    def test_a_table_of_a_law_that_is_not_in_use(self) -> None:
        problem = only_problem(belt("[friction.stribeck]", "v_s = 1"))
        assert problem.path == "friction.stribeck"

    def test_rising_friction_in_time(self) -> None:
        problem = only_problem(belt("[friction]", "mu_k = 0.5"))
        assert problem.path == "friction.mu_k"
        assert "mu_s = 0.4" in problem.message

    def test_rising_friction_is_harmless_in_a_linear_analysis(self) -> None:
        text = belt("[friction]", "mu_k = 0.5").replace('"history"\nt_end = 30', '"equilibrium"')
        assert parse(text).parameters["mu_k"] == 0.5

    def test_friction_on_a_sector_counts_where_there_is_one(self) -> None:
        text = PIN.replace("c1 = 0.002", "c1 = 0.002, mu_k_2 = 0.9")
        assert "mu_k_2 is above mu_s_2" in only_problem(text).message
        assert parse(text, "model.parameters.β=0.0").parameters["mu_k_2"] == 0.9

    def test_rising_friction_on_an_axis_is_left_to_the_plan(self) -> None:
        assert parse(belt("[grid]", "mu_k = [0.3, 0.5]")).axis("mu_k").values == (0.3, 0.5)


class TestStarts:
    def test_random(self) -> None:
        text = belt(
            "[[initial]]",
            'kind = "random"',
            'label = "far"',
            "count = 3",
            "seed = 7",
            "box = { x = [-1, '5 mm'], x_dot = [0, 1] }",
        )
        (start,) = parse(text).starts
        assert (start.count, start.seed) == (3, 7)
        assert start.box == {"x": (-1.0, 0.005), "x_dot": (0.0, 1.0)}

    def test_continued(self) -> None:
        text = belt(
            "[grid]",
            "v = [1, 2]",
            "[[initial]]",
            'label = "near"',
            'kind = "equilibrium"',
            "offset = { x = 1e-4 }",
            "[[initial]]",
            'label = "down"',
            'kind = "continue"',
            'along = "v"',
            'direction = "down"',
            'from = "near"',
            'on_loss = "restart"',
        )
        start = parse(text).starts[1]
        assert (start.along, start.direction, start.from_label, start.on_loss) == (
            "v",
            "down",
            "near",
            "restart",
        )

    @pytest.mark.parametrize(
        ("chains", "faulty"),
        [
            ([("up", "up", "far"), ("down", "down", "up"), ("again", "up", "down")], []),
            ([("down", "down", "up"), ("up", "up", "far")], []),  # in any order
            ([("up", "up", "down"), ("down", "down", "up")], [1, 2]),
            ([("up", "up", "up")], [1]),
            ([("up", "up", "far"), ("again", "up", "up")], [2]),
            ([("up", "up", "far"), ("down", "down", "up"), ("other", "down", "up")], [3]),
        ],
    )
    def test_continued_from_a_chain(
        self, chains: list[tuple[str, str, str]], faulty: list[int]
    ) -> None:
        tables = [
            f'[[initial]]\nlabel = "{label}"\nkind = "continue"\nalong = "v"\n'
            f'direction = "{direction}"\nfrom = "{origin}"'
            for label, direction, origin in chains
        ]
        far = '[[initial]]\nlabel = "far"\nkind = "state"'
        text = belt("[grid]", "v = [1, 2]", far, *tables)
        if faulty:
            assert [p.path for p in problems(text)] == [f"initial.{i}.from" for i in faulty]
        else:
            assert len(parse(text).starts) == 1 + len(chains)

    def test_continued_from_nowhere_along_nothing(self) -> None:
        text = belt("[[initial]]", 'kind = "continue"', 'from = "far"', 'along = "v"')
        assert only_problem(text).path == "initial.0.from"
        text = belt(
            *("[[initial]]", 'kind = "state"', 'label = "far"'),
            *("[[initial]]", 'kind = "continue"', 'from = "far"', 'along = "v"'),
        )
        assert only_problem(text).path == "initial.1.along"

    @pytest.mark.parametrize(
        ("others", "told"),
        [((), 'kind = "equilibrium"'), (("[[initial]]", 'label = "far"', 'kind = "state"'), "far")],
    )
    def test_continued_from_nothing(self, others: tuple[str, ...], told: str) -> None:
        chain = ("[[initial]]", 'kind = "continue"', 'along = "v"')
        text = belt("[grid]", "v = [1, 2]", *chain, *others)
        assert only_problem(text).allowed.count(told) == 1

    @pytest.mark.parametrize(
        ("line", "path"),
        [
            ("state = { y = 0 }", "initial.0.state.y"),
            ('state = { x = "w" }', "initial.0.state.x"),
            ('state = { x = "3 kg" }', "initial.0.state.x"),
            ("offset = { x = 1 }", "initial.0.offset"),
            ('label = "a,b"', "initial.0.label"),
            ("seed = -1", "initial.0.seed"),
        ],
    )
    def test_what_a_state_cannot_have(self, line: str, path: str) -> None:
        found = problems(belt("[[initial]]", 'kind = "state"', line))
        assert path in {problem.path for problem in found}

    def test_label_twice(self) -> None:
        start = ("[[initial]]", 'kind = "state"', 'label = "a"')
        assert only_problem(belt(*start, *start)).path == "initial.1.label"

    def test_empty_box(self) -> None:
        text = belt("[[initial]]", 'kind = "random"', "box = { x = [1, 0] }")
        assert "above" in only_problem(text).message

    def test_as_many_random_starts_as_would_fill_the_world(self) -> None:
        text = belt(
            "[[initial]]", 'kind = "random"', "count = 1_000_000_000_000", "box = { x = [0, 1] }"
        )
        assert "runs" in only_problem(text).message


class TestGrid:
    def test_endpoints_are_included_and_exact(self) -> None:
        case = parse(belt("[grid]", "mu_k = { start = 0.05, stop = 2.95, step = 0.05 }"))
        values = case.axis("mu_k").values
        assert len(values) == 59
        assert values[17] == 0.9
        assert values[-1] == 2.95

    @pytest.mark.parametrize(
        ("axis", "fragment"),
        [
            ("mu_k = []", "empty"),
            ("mu_k = 0.3", "a list or a range"),
            ("mu_k = [0.1, 0.1]", "repeat"),
            ("mu_k = [0.1, -0.1]", "out of range"),
            ("mu_k = [0.1, true]", "boolean"),
            ("mu_k = [0.1, nan]", "finite"),
            ('mu_k = [0.1, "1 N"]', "does not fit"),
            ("mu_k = { start = 0, stop = 1, step = 0.3 }", "0.9 and 1.2"),
            (
                "mu_k = { start = 1, stop = 0, step = 0.5 }",
                "from 1.0 lead away from 0.0: give step = -0.5",
            ),
            ("mu_k = { start = 0, stop = 1, step = 0 }", "the step must not be 0"),
            (
                "mu_k = { start = 0, stop = 1, step = -0.5 }",
                "lead away from 1.0: give step = 0.5, or exchange",
            ),
            ("mu_k = { start = 0, stop = 1 }", "either step or num"),
            ("mu_k = { start = 0, stop = 1, num = 1 }", "both ends"),
            ('mu_k = { start = 0, stop = 1, num = 3, scale = "log" }', "above 0"),
            ('mu_k = { start = 1, stop = 2, step = 1, scale = "log" }', "not with step"),
            ("mu_k = { start = 0, stop = 1, number = 3 }", "unknown key"),
            ('mu_k = { start = 0, stop = 1, num = 3, scale = "cubic" }', "not allowed"),
            ('friction = ["coulomb", "colomb"]', "no friction law"),
            ('friction = { start = "a", stop = "b", num = 3 }', "listed"),
            ("mu_kk = [1]", "nothing called"),
            ('"initial.y" = [1]', "no state"),
            ("v = [1e400]", "finite"),
        ],
    )
    def test_bad_axes(self, axis: str, fragment: str) -> None:
        assert fragment in only_problem(belt("[grid]", axis)).message

    def test_grid_of_1e12_points_is_counted_not_built(self) -> None:
        text = belt(
            "[grid]", *(f"{name} = {{ start = 1, stop = 10000, step = 1 }}" for name in "mkN")
        )
        assert "1,000,000,000,000 points" in only_problem(text).message

    def test_axis_of_1e12_values_is_counted_not_built(self) -> None:
        found = problems(belt("[grid]", "v = { start = 0, stop = 1e12, step = 1 }"))
        assert {problem.path for problem in found} == {"grid", "grid.v"}

    def test_fixed_and_varied(self) -> None:
        problem = only_problem(belt("[friction]", "mu_k = 0.3", "[grid]", '"μ_k" = [0.1, 0.2]'))
        assert "also fixed" in problem.message
        assert problem.line == BELT.count("\n") + 4

    def test_an_override_lets_vary_what_the_case_fixes(self) -> None:
        text = belt("[friction]", 'law = "coulomb"', "mu_k = 0.3")
        vary = "grid.mu_k=[0.1, 0.2]", 'grid.friction=["coulomb", "stribeck"]'
        case = parse(text, *vary)
        assert (case.axis("mu_k").values, case.laws) == ((0.1, 0.2), ("coulomb", "stribeck"))
        both = only_problem(text, "friction.mu_k=0.2", vary[0])
        assert "also fixed" in both.message

    @pytest.mark.parametrize("given", ['"friction.mu_k"', "friction.mu_k", "mu_k", '"μ_k"'])
    @pytest.mark.parametrize("name", ["mu_k", "friction.mu_k", '"friction.mu_k"', '"μ_k"'])
    def test_an_override_of_an_axis_may_call_it_by_another_name(self, given, name) -> None:
        text = belt("[grid]", f"{given} = {{ start = 0.1, stop = 0.3, num = 3 }}", "N = [1, 2]")
        case = parse(text, f"grid.{name}=[0.1, 0.2]")
        assert [axis.name for axis in case.axes] == ["mu_k", "N"]
        assert case.axis("mu_k").values == (0.1, 0.2)
        assert case.axis("mu_k") == parse(text, f"grid.{name}.num=2", f"grid.{name}.stop=0.2").axis(
            "mu_k"
        )
        assert parse(belt("[friction]", "mu_k = 0.3"), f"grid.{name}=[0.1, 0.2]").axis("mu_k")

    def test_an_override_makes_an_axis_beside_laws_or_changes_one_of_them(self) -> None:
        text = belt("[grid]", 'friction = ["coulomb", "stribeck"]')
        case = parse(text, "grid.friction.mu_k=[0.1, 0.2]", "grid.friction.0=exponential")
        assert case.laws == ("exponential", "stribeck")
        assert case.axis("mu_k").values == (0.1, 0.2)

    @pytest.mark.parametrize(
        ("given", "name"), [("v_s = 0.05", "v_s"), ("stribeck = { v_s = 0.05 }", "stribeck")]
    )
    def test_what_is_left_of_a_law_that_an_override_replaces_does_not_count(
        self, given: str, name: str
    ) -> None:
        text = belt(
            "[friction]", "mu_k = 0.3", given, "[grid]", 'friction = ["coulomb", "stribeck"]'
        )
        one = "grid.friction=['coulomb']"
        assert parse(text, one).laws == ("coulomb",)
        assert fingerprint(parse(text, one)) == fingerprint(parse(text.replace(given, ""), one))
        problem = only_problem(text, one, "friction.v_s=0.1")
        assert problem.path == "friction.v_s"  # which the override asks for itself
        chosen = belt("[friction]", given)
        assert only_problem(chosen).path == f"friction.{name}"
        assert parse(chosen, "friction.law=coulomb").laws == ("coulomb",)

    def test_law_fixed_and_varied(self) -> None:
        text = belt("[friction]", 'law = "coulomb"', "[grid]", 'friction = ["coulomb", "stribeck"]')
        assert "also fixed" in only_problem(text).message

    def test_zip_lets_values_repeat(self) -> None:
        case = parse(
            belt("[grid]", "u0 = [1, 1]", "omega = [1, 2]", "[sweep]", 'zip = [["u0", "ω"]]')
        )
        assert case.zips == (("u0", "omega"),)

    @pytest.mark.parametrize(
        ("group", "fragment"),
        [
            ('["u0", "v"]', "no axis"),
            ('["u0"]', "two axes"),
            ('["u0", "u0"]', "twice"),
            ('["u0", "k"]', "differ"),
        ],
    )
    def test_bad_zips(self, group: str, fragment: str) -> None:
        text = belt(
            "[grid]",
            "u0 = [1, 2]",
            "k = [1, 2, 3]",
            "omega = [1, 2]",
            "[sweep]",
            f"zip = [{group}]",
        )
        assert fragment in only_problem(text).message

    def test_start_axis_needs_an_analysis_with_starts(self) -> None:
        text = belt("[grid]", '"initial.x" = [0, 1]')
        text = text.replace('"history"\nt_end = 30', '"equilibrium"')
        assert "no analysis" in only_problem(text).message


class TestBadInput:
    """One of each kind of mistake."""

    def test_missing_file(self, tmp_path: Path) -> None:
        with pytest.raises(UsageError, match="no such file"):
            load_case(tmp_path / "none.toml")

    def test_misspelt_file(self, tmp_path: Path) -> None:
        (tmp_path / "stick_slip.toml").write_text(BELT)
        with pytest.raises(UsageError, match=r"did you mean '.*stick_slip.toml'"):
            load_case(tmp_path / "stickslip.toml")

    def test_folder(self, tmp_path: Path) -> None:
        with pytest.raises(UsageError, match="is a folder"):
            load_case(tmp_path)

    def test_no_text(self, tmp_path: Path) -> None:
        file = tmp_path / "case.toml"
        file.write_bytes(b"schema = 1\ntitle = '\xff'\n")
        with pytest.raises(CaseError, match=r"case.toml:2: case: is not UTF-8"):
            load_case(file)

    def test_invalid_toml_has_line_and_column(self) -> None:
        problem = only_problem("schema = 1\n[model\n")
        assert (problem.line, problem.column) == (2, 7)
        assert "invalid TOML" in problem.message

    def test_toml_cut_short(self) -> None:
        assert only_problem('schema = 1\ntitle = """a').line == 2

    def test_absurd_nesting(self) -> None:
        assert "nest" in only_problem("a = " + "[" * 50_000).message

    def test_absurd_integer(self) -> None:
        assert only_problem("schema = " + "1" * 5000).path == "case"

    @pytest.mark.parametrize("version", ["2", "true", "1.0", '"1"'])
    def test_schema(self, version: str) -> None:
        assert only_problem(BELT.replace("schema = 1", f"schema = {version}")).path == "schema"

    def test_empty_file(self) -> None:
        paths = {problem.path for problem in problems("")}
        assert {"schema", "model", "analysis"} <= paths

    def test_no_analysis(self) -> None:
        text = BELT.split("[[analysis]]")[0]
        assert only_problem(text).path == only_problem("analysis = []\n" + text).path == "analysis"

    @pytest.mark.parametrize(
        ("lines", "path", "fragment"),
        [
            (["[shedule]", "v = 1"], "shedule", "unknown table"),
            (["[sweep]", "refine = { levels = 5 }"], "sweep.refine", "no numeric axis"),
            (["[solver]", "rtoll = 1e-9"], "solver.rtoll", "unknown key"),
            (["[solver]", "rtol = 1"], "solver.rtol", "out of range"),
            (["[solver]", 'method = "euler"'], "solver.method", "not allowed"),
            (["[solver]", "max_events = 1.5"], "solver.max_events", "does not fit"),
            (["[solver]", "step = 0"], "solver.step", "out of range"),
            (["[model.parameters]", "m = -1"], "model.parameters.m", "out of range"),
            (
                ["[model.parameters]", "m = '-30 g'"],
                "model.parameters.m",
                "'-30 g' (-0.03 kg) is out",
            ),
            (["[model.parameters]", "m = nan"], "model.parameters.m", "finite"),
            (["[model.parameters]", "m = inf"], "model.parameters.m", "finite"),
            (["[model.parameters]", "m = true"], "model.parameters.m", "boolean"),
            (["[model.parameters]", "m = [1]"], "model.parameters.m", "a list"),
            (["[model.parameters]", "m = 2020-01-01"], "model.parameters.m", "number"),
            (["[model.parameters]", 'm = "3 N"'], "model.parameters.m", "does not fit 'kg'"),
            (["[model.parameters]", 'm = "heavy"'], "model.parameters.m", "not a number"),
            (["[model.parameters]", 'm = "3 stone"'], "model.parameters.m", "unknown unit"),
            (["[model.parameters]", "mass = 1"], "model.parameters.mass", "unknown parameter"),
            (["[model.parameters]", "mu_k = 1"], "model.parameters.mu_k", "unknown parameter"),
            (["[model.parameters]", '"ω" = 1', "omega = 2"], "model.parameters.omega", "twice"),
            (["[model.options]", 'a = "b"'], "model.options.a", "unknown option"),
            (["[friction]", 'law = "dry"'], "friction.law", "no friction law"),
            (["[friction]", "m = 2"], "friction.m", "unknown parameter"),
            (
                ["[friction]", 'law = "stribeck"', "delta = 1.5"],
                "friction.delta",
                "not a whole number",
            ),
            (["[[analysis]]", 'kind = "respons"'], "analysis.1.kind", "no analysis"),
            (["[[analysis]]", 'kind = "history"'], "analysis.1.t_end", "is missing"),
            (["[[figure]]", 'kind = "pie"'], "figure.0.kind", "not allowed"),
            (["[[figure]]", 'kind = "curve"', 'x = "mu"'], "figure.0.x", "nothing called 'mu'"),
            (["[[figure]]", 'kind = "curve"', 'colour = "red"'], "figure.0.colour", "unknown key"),
            (["[[figure]]", 'kind = "map"', "overlay = true"], "figure.0.overlay", "no level says"),
            (["[[figure]]", 'kind = "map"', "level = []"], "figure.0.level", "an empty list"),
            (["[[figure]]", 'kind = "map"', "level = [1, true]"], "figure.0.level", "a number"),
            (["figure = 3"], "analysis.0.figure", "no setting"),
        ],
    )
    def test_tables(self, lines: list[str], path: str, fragment: str) -> None:
        found = {problem.path: problem for problem in problems(belt(*lines))}
        assert fragment in found[path].message
        assert found[path].line is not None

    def test_a_key_of_another_table_is_led_to_that_of_this_one(self) -> None:
        said = problems(belt("[[figure]]", 'kind = "bifurcation"', 'of = "L_s"'))
        found = next(problem for problem in said if problem.path == "figure.0.of")
        assert found.suggestion.startswith("did you mean 'variable'")

    def test_unknown_model(self) -> None:
        problem = only_problem(BELT.replace("belt-1dof", "belt-1dov"))
        assert problem.suggestion.startswith("did you mean 'belt-1dof'")
        assert "pin-on-disc" in problem.allowed

    def test_names_that_differ_in_case_only(self) -> None:
        """Omega and omega are different: the one that exists is named, with its meaning."""
        problem = only_problem(belt("[model.parameters]", "Omega = 1"))
        assert "'omega' (frequency of the base's motion)" in problem.suggestion

    def test_law_parameter_in_the_models_table_is_sent_home(self) -> None:
        problem = only_problem(belt("[model.parameters]", "mu_k = 0.1"))
        assert "[friction]" in problem.suggestion

    def test_message_has_place_value_allowed_and_next_step(self) -> None:
        with pytest.raises(CaseError) as caught:
            parse(belt("[model.parameters]", "m = -1.5"))
        lines = str(caught.value).splitlines()
        assert lines[0].startswith("case.toml: 1 problem")
        assert lines[1] == "  case.toml:8: model.parameters.m: -1.5 is out of range"
        assert lines[2] == "      allowed: a number in kg, > 0 (mass)"
        assert lines[-1] == "next: correct the file, then `fiv check case.toml`"


class TestSections:
    def section(self, text: str, model: str = "belt-1dof", more: str = "") -> str:
        return f"""schema = 1
[model]
name = "{model}"
{more}
[[analysis]]
kind = "response"
section = {text}
"""

    @pytest.mark.parametrize(
        ("text", "section"),
        [
            ('{ event = "stick->slip" }', Section("event", event="stick->slip")),
            ('{ zero = "x_dot" }', Section("zero", state="x_dot")),
        ],
    )
    def test_good(self, text: str, section: Section) -> None:
        assert parse(self.section(text)).analyses[0].settings["section"] == section

    def test_phase_where_the_excitation_is_on(self) -> None:
        text = self.section('{ phase = "90 deg" }', more="parameters = { u0 = 0.1 }")
        assert parse(text).analyses[0].settings["section"] == Section("phase", phase=math.pi / 2)

    @pytest.mark.parametrize(
        ("text", "fragment"),
        [
            ("{ phase = 0 }", "excitation is off"),
            ('{ zero = "x" }', "no velocity"),
            ('{ event = "slip" }', "not allowed"),
            ('{ event = "slip->stick", zero = "x_dot" }', "one of event, zero and phase"),
            ("{ }", "one of event, zero and phase"),
            ('{ event = "slip->stick", contact = 2 }', "no contact 2"),
            ('"slip->stick"', "must be a table"),
        ],
    )
    def test_bad(self, text: str, fragment: str) -> None:
        assert any(fragment in problem.message for problem in problems(self.section(text)))

    @pytest.mark.parametrize("model", ["belt-1dof", "pin-on-disc"])
    def test_what_cannot_separate_has_no_impact(self, model: str) -> None:
        (told,) = problems(self.section('{ event = "impact" }', model))
        assert told.message == f"contact 1 of {model} never separates, so impact never happens"

    @pytest.mark.parametrize("law", ["coulomb", "tanh"])
    @pytest.mark.parametrize("model", ["belt-5dof", "disc-nonlinear-contact"])
    def test_what_separates_has_impacts_under_every_law(self, model: str, law: str) -> None:
        text = self.section('{ event = "impact" }', model) + f"[friction]\nlaw = '{law}'"
        assert parse(text).analyses[0].settings["section"] == Section("event", event="impact")

    def test_a_law_that_never_sticks_has_no_stick_event(self) -> None:
        asked = '"response"\nsection = { event = "slip->stick" }'
        text = belt("[friction]", 'law = "tanh"').replace('"history"\nt_end = 30', asked)
        assert 'zero = "x_dot"' in only_problem(text).suggestion


@pytest.mark.parametrize("kind", ["response", "cycle"])
def test_a_transient_that_takes_all_the_time_is_refused(kind: str) -> None:
    text = belt().replace('"history"\nt_end = 30', f'"{kind}"\nt_max = 50.0\ntransient = {{}}')
    assert parse(text.format(49.0)).analyses[0].settings["transient"] == 49.0
    assert "leave nothing of t_max = 50 s" in only_problem(text.format(50.0)).message


TAKEN = '{ what = "greatest", over = "initial" }'


class TestClaims:
    def claim(self, expect: str, more: str = "") -> str:
        variable = "attractor" if "periodic" in expect else "L_s"
        lines = ["[[claim]]", 'source = "a"', 'text = "b"', f'variable = "{variable}"']
        return belt(*lines, more, expect).replace('"history"\nt_end = 30', '"response"')

    @pytest.mark.parametrize(
        "expect",
        [
            '"periodic"',
            '"not periodic"',
            '"increasing"',
            '"decreasing"',
            "{ value = 1.0, tolerance = 0.1 }",
            "{ between = [0.1, 0.2] }",
            "{ greater_than = 3 }",
        ],
    )
    def test_good(self, expect: str) -> None:
        text = self.claim(f"expect = {expect}\n[grid]\nmu_k = [0.1, 0.2]")
        assert parse(text).claims[0].holds == "all"

    @pytest.mark.parametrize(
        "expect",
        [
            '"Periodic!"',
            "{ value = 1.0 }",
            "{ value = nan, tolerance = 0.1 }",
            "{ value = 1, tolerance = -1 }",
            "{ between = [2, 1] }",
            "{ between = 2 }",
            "{ between = [1, 2], tolerance = 0 }",
            '{ less_than = "L_s + 1" }',
            "{ }",
            "3",
        ],
    )
    def test_bad(self, expect: str) -> None:
        assert only_problem(self.claim(f"expect = {expect}")).path.startswith("claim.0.expect")

    @pytest.mark.parametrize(
        ("expect", "words"),
        [
            (
                "{ interval = [0.1, 0.2], tolerance = 0.05 }",
                "write expect = { between = [0.05, 0.25] }",
            ),
            (
                '{ interval = [0.1, 0.2], tolerance = 0, of = "chaotic" }',
                'write take = { what = "first", of = "chaotic", over = AXIS } and '
                "expect = { value = 0.1, tolerance = 0 }, or",
            ),
        ],
    )
    def test_intervals_of_before(self, expect: str, words: str) -> None:
        assert words in only_problem(self.claim(f"expect = {expect}")).message

    @pytest.mark.parametrize(
        ("expect", "words"),
        [
            ('{ value = "0.9*L_s" }', 'write { variable = "L_s", times = 0.9 }'),
            ('{ value = "0.9*L_s" }', "a value has a tolerance"),
            ('{ less_than = "2 * a:L_s" }', 'times = 2.0, case = "a" }'),
            ('{ value = "20 rpm", tolerance = 1 }', "20 rpm is 2.09439510239 in SI"),
            ('{ between = [0, "3 mm"] }', "3 mm is 0.003 in SI"),
            ('"3 rad/s"', "3 rad/s is 3 in SI"),
            ("{ less_than = { varable = 1 } }", "has no varable: { variable, analysis, case,"),
            ("{ less_than = { times = 0 } }", "above 0"),
            ("{ less_than = { at = 3 } }", "at must be a table"),
        ],
    )
    def test_what_to_write_instead(self, expect: str, words: str) -> None:
        assert words in only_problem(self.claim(f"expect = {expect}")).message

    @pytest.mark.parametrize("holds", ['"most"', "0", "1.5", "true"])
    def test_bad_share(self, holds: str) -> None:
        text = self.claim('expect = "periodic"', f"holds = {holds}")
        assert only_problem(text).path == "claim.0.holds"

    @pytest.mark.parametrize("wanted", ['"periodic"', '["periodic", "chaotic"]'])
    def test_a_result_narrows_a_claim_to_its_classes(self, wanted: str) -> None:
        (claim,) = parse(
            self.claim("expect = { less_than = 3 }", f"at.attractor = {wanted}")
        ).claims
        assert claim.at["attractor"]

    @pytest.mark.parametrize(
        ("more", "words"),
        [
            ('at.attractor = "chaos"', "has no class 'chaos'"),
            ("at.x_amplitude = 3", "is a number, and no axis: a claim is narrowed to classes"),
            ('at.cycle_end_kind = "fold"', "the analysis 'response' has no axis 'cycle_end_kind'"),
            (f'at.attractor = "periodic"\ntake = {TAKEN}', "no trend and nothing taken"),
        ],
    )
    def test_results_that_do_not_narrow_it(self, more: str, words: str) -> None:
        assert words in only_problem(self.claim("expect = { less_than = 3 }", more)).message

    def test_what_is_a_result_and_an_axis_is_an_axis(self) -> None:
        lines = ["[[claim]]", 'source = "a"', 'text = "b"', 'variable = "x"', "at.time = 30.0"]
        (claim,) = parse(belt(*lines, "expect = { less_than = 3 }")).claims
        assert claim.at == {"time": 30.0}

    def test_a_curve_alone_selects_classes(self) -> None:
        figure = [
            "[[figure]]",
            'kind = "curve"',
            'variable = "L_s"',
            'select.attractor = "periodic"',
        ]
        text = belt(*figure).replace('"history"\nt_end = 30', '"response"')
        assert parse(text).figures
        ends = text.replace(
            '"response"', '"boundary"\nparameter = "mu_k"\nbracket = [0.1, 0.3]\nof = OF'
        )
        ends = ends.replace("OF", '{ variable = "attractor", expect = "periodic" }')
        ends = ends.replace('variable = "L_s"\nselect.attractor', "select.class_above")
        assert parse(ends).figures  # it shows `boundary` unless it says otherwise
        problem = only_problem(ends.replace('"curve"', '"curve"\nvariable = "n_crossings"'))
        assert "does not stand beside each value of 'n_crossings'" in problem.message
        assert problem.allowed == "beside those of boundary, boundary_width, boundary_error"
        other = text.replace('"curve"\nvariable = "L_s"', '"basin"')
        assert "is a result, and no axis" in only_problem(other).message

    @pytest.mark.parametrize("holds", ['"any"', "0.9", "1"])
    def test_good_share(self, holds: str) -> None:
        assert parse(self.claim('expect = "periodic"', f"holds = {holds}")).claims

    def test_all_that_is_missing_is_named(self) -> None:
        found = {problem.path for problem in problems(belt("[[claim]]", "holds = 3"))}
        assert found == {
            f"claim.0.{key}" for key in ("source", "text", "variable", "expect", "holds")
        }


class TestOverrides:
    def test_axis_is_replaced(self) -> None:
        assert parse(PIN, "grid.N0=[1, 2]").axis("N0").values == (1.0, 2.0)

    def test_string_with_unit(self) -> None:
        assert parse(BELT, 'model.parameters.N="30 N"').parameters["N"] == 30.0
        assert parse(BELT, "model.parameters.N=0.03 kN").parameters["N"] == 30.0

    def test_tables_are_made_on_the_way(self) -> None:
        assert parse(BELT, "solver.rtol=1e-6").solver.rtol == 1e-6

    def test_elements_by_index_and_by_name(self) -> None:
        for key in ("0", "history"):
            (analysis,) = parse(BELT, f"analysis.{key}.t_end=7").analyses
            assert analysis.settings["t_end"] == 7.0

    def test_a_parameter_that_is_an_axis_is_set_in_the_grid(self) -> None:
        problem = only_problem(PIN, "model.parameters.N0=30")
        assert problem.path == "grid.N0"
        assert problem.suggestion.endswith("--set grid.N0=[VALUE]")

    def test_later_wins(self) -> None:
        assert parse(BELT, "title=a", "title=b").title == "b"

    def test_quoted_key(self) -> None:
        case = parse(BELT, 'grid."initial.x"=[0, 1]')
        assert case.axis("initial.x").values == (0.0, 1.0)

    @pytest.mark.parametrize("text", ["", "grid", "=1", "a.=1", "a=", "a=[1", "a=1\nb=2", "a b=1"])
    def test_malformed(self, text: str) -> None:
        with pytest.raises(UsageError, match="--set"):
            parse(BELT, text)

    @pytest.mark.parametrize(
        ("text", "path", "suggestion"),
        [
            ("modl.name=1", "modl", "did you mean 'model'"),
            ("model.parameters.n=1", "model.parameters.n", "did you mean 'N'"),
            ("model.parameters.v_belt=1", "model.parameters.v_belt", "here it is 'v'"),
            ("model.parameters.k1=1", "model.parameters.k1", "here it is 'k'"),
            ("model.parameters.m=-1", "model.parameters.m", ""),
            ("analysis.histori.t_end=1", "analysis.histori.t_end", "did you mean 'history'"),
            ("analysis.3.t_end=1", "analysis.3.t_end", "there are: 0, history"),
            ("schema.a=1", "schema.a", ""),
        ],
    )
    def test_a_wrong_one_is_the_place(self, text: str, path: str, suggestion: str) -> None:
        problem = only_problem(BELT, text)
        assert (problem.path, problem.override) == (path, text)
        assert problem.line is None
        assert problem.suggestion.startswith(suggestion)

    def test_no_spring_is_taken_for_a_cubic_one(self) -> None:
        """It was said that here it is the linear one."""
        assert "here it is" not in only_problem(BELT, "model.parameters.k_nl=1").suggestion

    def test_an_angle_that_is_too_great_may_be_in_degrees(self) -> None:
        pin = BELT.replace("belt-1dof", "pin-on-disc")
        for value, told in (("15", True), ("-1", False), ('"400 deg"', False), ('"30 rad"', False)):
            found = problems(pin, f"model.parameters.beta={value}")
            (said,) = [one.message for one in found if one.path.endswith("beta")]
            assert ("in degrees write" in said) == told and "is out of range" in said


COUPLED = {"k2": 0.5, "k3": 1.0, "alpha1": math.pi / 6.0, "alpha2": math.pi / 4.0}


def _damped(extra: str, parameters: str) -> str:
    given = ", ".join([*(f"{name} = {value}" for name, value in COUPLED.items()), parameters])
    model = f"[model]\nname = 'flutter-2dof'\nparameters = {{ {given.removesuffix(', ')} }}\n"
    return f"schema = 1\n{model}[[analysis]]\nkind = 'critical'\n{extra}"


def test_a_parameter_with_the_name_of_another_has_its_value():
    """Where it is an axis, and where an analysis varies it: as if both were written."""
    along = "parameter = 'mu_k'\nbracket = [0.0, 4.0]\n[grid]\nc1 = [0.02, 0.3]\n"
    both = "c2 = [0.02, 0.3]\n[sweep]\nzip = [['c1', 'c2']]\n"
    follows, written = (
        api.run(parse_case(text, "x.toml"))
        for text in (_damped(along, "c2 = 'c1'"), _damped(along + both, ""))
    )
    np.testing.assert_array_equal(*(one["critical_value"].values for one in (follows, written)))
    assert [one["c1"].attrs["symbol"] for one in (follows, written)] == ["c_1 = c_2", "c_1"]
    varied = "parameter = 'c1'\nbracket = [0.001, 1.0]\n[grid]\nmu_k = [0.6]\n"
    found = api.run(parse_case(_damped(varied, "c2 = 'c1'"), "x.toml"))
    at = found["critical_value"].values.ravel()[0]
    own = {**COUPLED, "c1": at, "c2": at, "mu_k": 0.6}
    growth = api.analyse("flutter-2dof", "coulomb", "eigenvalues", **own).values["growth_rate"]
    assert growth == pytest.approx(0.0, abs=1e-12)


def test_a_parameter_of_a_law_may_follow_another_too():
    """It stood in no case that varies the other one itself: the advice was two axes."""
    text = "schema = 1\n[model]\nname = 'belt-2mass'\n[friction]\nlaw = 'coulomb'\n{}"
    swept = "[grid]\nmu_k = [0.1, 0.5]\n{}[[analysis]]\nkind = 'eigenvalues'\n"
    both = "mu_s = [0.1, 0.5]\n[sweep]\nzip = [['mu_k', 'mu_s']]\n"
    follows, written = (
        api.run(parse_case(text.format(one), "x.toml"), workers=1)
        for one in ("mu_s = 'mu_k'\n" + swept.format(""), swept.format(both))
    )
    assert follows.attrs["model"] == "belt-2mass + mu_s = mu_k"
    np.testing.assert_array_equal(follows["growth_rate"], written["growth_rate"])
    own = replace(get_law("stribeck"), name="own", origin=Origin("own.py", ""))
    followed = get_model("belt-2mass + mu_s = mu_k").defaults_of(own)
    assert followed == {"mu_s": "mu_k"}  # of its file's defaults on a model of others the rest
    for law, told in (("mu_k = 'mu_s'\nmu_s = 'mu_k'", "takes the value of another itself"),
                      ("mu_s = 'N'", "'N' is a parameter, not a value")):  # fmt: skip
        with pytest.raises(CaseError, match=told):
            parse_case(text.format(f"{law}\n{swept.format('')}"), "x.toml")


@pytest.mark.parametrize(
    ("parameters", "told"),
    [
        ("c2 = 'k1'", "c2 is in N s m-1, and the parameter k1 in N m-1"),
        ("c1 = 'c2', c2 = 'c1'", "c2 takes the value of another itself"),
        ("c1 = 'c1'", "c1 takes the value of another itself"),
        ("c1 = 'mu_k'", "'mu_k' is a parameter, not a value"),
    ],
)
def test_a_parameter_that_cannot_follow_another_is_refused(parameters, told):
    along = "parameter = 'mu_k'\nbracket = [0.0, 4.0]\n"
    with pytest.raises(CaseError, match=told):
        parse_case(_damped(along, parameters), "x.toml")
