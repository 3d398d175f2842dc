"""The commands around case files, through a real process where the shell sees the difference."""

from __future__ import annotations

import importlib
import json
import os
import re
import subprocess
import sys
from collections.abc import Iterator, Sequence
from itertools import chain
from pathlib import Path
from typing import Any

import click
import pytest
from disturbed import by_default
from small_cases import BELT as CASE
from small_models import SUITED

from fiv_cli import api
from fiv_cli.analyses import all_analyses
from fiv_cli.analyses.catalogue import possible_variables
from fiv_cli.case.load import parse_case
from fiv_cli.case.schema import case_schema
from fiv_cli.case.template import case_template
from fiv_cli.cli.common import print_table
from fiv_cli.cli.main import COMMANDS, run
from fiv_cli.errors import LockedError
from fiv_cli.friction import all_laws, get_law
from fiv_cli.models import all_models
from fiv_cli.notation.tables import plain_table
from fiv_cli.sweep.plan import make_plan

ENTRY = "import sys; from fiv_cli.cli.main import main; sys.argv[0] = 'fiv'; main()"


def fiv(*arguments: str, **environment: str) -> subprocess.CompletedProcess[str]:
    """Run the program in a process of its own."""
    return subprocess.run(
        [sys.executable, "-c", ENTRY, *arguments],
        capture_output=True,
        text=True,
        check=False,
        env={**os.environ, **environment},
        timeout=120,
    )


@pytest.fixture
def case(tmp_path: Path) -> Path:
    file = tmp_path / "belt.toml"
    file.write_text(CASE)
    return file


class TestHelp:
    def test_each_command_has_the_help_option_of_fiv(self) -> None:
        """In a process of its own: a command keeps the first that it is given."""
        asked = "from fiv_cli.cli.main import COMMANDS, run; [run([n, '-h']) for n in COMMANDS]"
        told = subprocess.run([sys.executable, "-c", asked], capture_output=True, text=True)
        assert re.findall(r"^Usage: fiv (\S+)", told.stdout, re.MULTILINE) == [*COMMANDS]

    def test_help_lists_every_command(self, capsys: pytest.CaptureFixture[str]) -> None:
        assert run(["--help"]) == 0
        out = capsys.readouterr().out
        assert "Exit codes" in out
        for name, (_, text) in COMMANDS.items():
            assert re.search(rf"^  {name} +{re.escape(text)}$", out, re.MULTILINE)

    @pytest.mark.parametrize("name", COMMANDS)
    def test_every_command_teaches_by_example(self, name: str) -> None:
        command = importlib.import_module(COMMANDS[name][0]).command
        assert isinstance(command, click.Command)
        help_text = click.Context(command, info_name=name).get_help()
        assert f"fiv {name}" in help_text

    def test_version(self, capsys: pytest.CaptureFixture[str]) -> None:
        assert run(["--version"]) == 0
        assert capsys.readouterr().out.startswith("fiv ")


class TestExitCodes:
    def test_done(self, case: Path) -> None:
        done = fiv("check", str(case))
        assert (done.returncode, done.stderr) == (0, "")

    @pytest.mark.parametrize(
        ("arguments", "fragment"),
        [
            (["modles"], "did you mean 'models'"),
            (["models", "--no-such-option"], "options: --"),
            (["models", "--no-such-option"], "example: fiv models"),
            (["new", "belt-1dof", "response"], "example: fiv new "),
            (["plot", "a.nc", "--xlim", "1"], "next: write xlim under [[figure]] in the case"),
            (["plot", "a.nc", "--at", "v=1"], "next: write select under [[figure]] in the case"),
            (["plot", "a.nc", "--pdf"], "next: -o FILE.pdf"),
            (["plot", "a.nc", "--t-max", "1"], "--title, --no-title\nexample: fiv "),
            (["plot", "a.nc", "b.nc", "--label", "a"], "next: one --label WORDS for each file"),
            (["plot", "a.nc", "--label", "a"], "tells several files in one figure apart"),
            (["plot", "--title", "off"], "next: --title, or --no-title"),
            (["run", "a.toml", "--estimate"], "next: fiv check --estimate"),
            (["run", "a.toml", "--claims"], "next: fiv claims"),
            (["run", "a.toml", "--jobs", "2"], "next: --workers"),
            (["run", "a.toml", "--refine"], "next: write it in the case: fiv kinds refine"),
            (["run", "a.toml", "--t-max", "9"], "next: write t_max under [[analysis]] in the case"),
            (["run", "a.toml", "--rtol", "1"], "next: write rtol under [solver] in the case"),
            (["run", "a.toml", "--mu_k", "1"], "next: --set model.parameters.mu_k=VALUE"),
            (["show", "a.nc", "--mu_k", "1"], "next: write model.parameters.mu_k = VALUE in"),
            (["check", "a.toml", "--estimates"], "Did you mean '--estimate'"),
            (["laws"], "next: fiv models --laws"),
            (["models", "belt-1dov"], "did you mean 'belt-1dof'"),
            (["models", "stribek", "--laws"], "did you mean 'stribeck'"),
            (["new", "belt-1dov"], "did you mean 'belt-1dof'"),
            (["new", "belt-1dof", "--analysis", "respond"], "did you mean 'response'"),
            (["check"], "Missing argument"),
            (["check", "none.toml"], "no such file"),
            (["check", "."], "is a folder"),
        ],
    )
    def test_usage(self, arguments: list[str], fragment: str) -> None:
        done = fiv(*arguments)
        assert done.returncode == 2
        assert fragment in done.stderr
        assert done.stdout == ""
        assert "Traceback" not in done.stderr

    def test_a_template_replaces_no_file(self, tmp_path: Path) -> None:
        target = tmp_path / "new.toml"
        assert fiv("new", "belt-1dof", "-o", str(target)).returncode == 0
        assert target.read_text() == fiv("new", "belt-1dof").stdout
        target.write_text("my work")
        again = fiv("new", "belt-1dof", "-o", str(target))
        assert (again.returncode, target.read_text()) == (2, "my work")
        assert "next: -o ANOTHER" in again.stderr

    def test_invalid_case(self, case: Path) -> None:
        case.write_text(CASE.replace("v =", "w ="))
        done = fiv("check", str(case))
        assert done.returncode == 3
        assert f"{case}:5: grid.w: " in done.stderr
        assert "Traceback" not in done.stderr

    def test_malformed_override(self, case: Path) -> None:
        done = fiv("check", str(case), "--set", "grid")
        assert done.returncode == 2
        assert "--set grid: PATH=VALUE is wanted" in done.stderr

    def test_invalid_override(self, case: Path) -> None:
        done = fiv("check", str(case), "--set", "model.parameters.m=-1")
        assert done.returncode == 3
        assert "(--set model.parameters.m=-1)" in done.stderr

    def test_every_case_is_checked_and_the_worst_decides(self, case: Path, tmp_path: Path) -> None:
        bad = tmp_path / "bad.toml"
        bad.write_text("schema = 2\n")
        done = fiv("check", str(bad), str(case), "none.toml")
        assert done.returncode == 3
        assert "belt-1dof" in done.stdout
        assert "schema" in done.stderr
        assert "none.toml" in done.stderr

    def test_interrupt(self, monkeypatch: pytest.MonkeyPatch) -> None:
        monkeypatch.setattr("fiv_cli.cli.main.cli", _Raising(KeyboardInterrupt()))
        assert run(["models"]) == 130

    def test_own_errors_carry_their_code(self, monkeypatch: pytest.MonkeyPatch) -> None:
        monkeypatch.setattr("fiv_cli.cli.main.cli", _Raising(LockedError("held by 42")))
        assert run(["models"]) == 7

    def test_internal_error_is_one_paragraph(
        self, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
    ) -> None:
        monkeypatch.delenv("FIV_DEBUG", raising=False)
        monkeypatch.setattr("fiv_cli.cli.main.cli", _Raising(RuntimeError("boom")))
        assert run(["models"]) == 1
        error = capsys.readouterr().err
        assert error.startswith("fiv: internal error: RuntimeError: boom")
        assert "Traceback" not in error

    def test_internal_error_with_traceback_on_demand(
        self, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
    ) -> None:
        monkeypatch.setenv("FIV_DEBUG", "1")
        monkeypatch.setattr("fiv_cli.cli.main.cli", _Raising(RuntimeError("boom")))
        assert run(["models"]) == 1
        assert "Traceback" in capsys.readouterr().err

    def test_terminated(self) -> None:
        script = (
            "import os, signal, sys\n"
            "from fiv_cli.cli import main\n"
            "class Waiting:\n"
            "    def make_context(self, *_):\n"
            "        os.kill(os.getpid(), signal.SIGTERM)\n"
            "        signal.pause()\n"
            "main.cli = Waiting()\n"
            "main.main()\n"
        )
        command = [sys.executable, "-c", script]
        done = subprocess.run(command, check=False, timeout=60, preexec_fn=by_default)
        assert done.returncode == 143

    def test_a_reader_that_goes_away_is_no_trouble(self) -> None:
        command = [sys.executable, "-c", ENTRY, "schema"]
        with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE) as process:
            assert process.stdout is not None
            assert process.stderr is not None
            process.stdout.close()
            assert process.stderr.read() == b""
        assert process.returncode == 141

    @pytest.mark.skipif(not Path("/dev/full").exists(), reason="needs /dev/full")
    def test_a_full_disk_is_said(self) -> None:
        with Path("/dev/full").open("w") as full:
            done = subprocess.run(
                [sys.executable, "-c", ENTRY, "schema"],
                stdout=full,
                stderr=subprocess.PIPE,
                text=True,
                check=False,
            )
        assert done.returncode == 2
        assert "No space left" in done.stderr
        assert "Traceback" not in done.stderr


class _Raising:
    """A command group that fails."""

    def __init__(self, error: BaseException) -> None:
        self.error = error

    def make_context(self, *_: object) -> click.Context:
        raise self.error


class TestModels:
    def test_list(self, capsys: pytest.CaptureFixture[str]) -> None:
        assert run(["models"]) == 0
        out = capsys.readouterr().out
        assert all(f"\n{name} " in out for name in all_models())

    @pytest.mark.parametrize("name", list(all_models()))
    def test_one(self, name: str, capsys: pytest.CaptureFixture[str]) -> None:
        model = all_models()[name]
        assert run(["models", name]) == 0
        out = capsys.readouterr().out
        for parameter in model.parameters:
            assert re.search(rf"^{parameter.name} .*\S+ +{parameter.unit} ", out, re.MULTILINE)
        for state in model.states(model.default_options()):
            assert f"  {state.name}'' = " in out
        assert ("|F_T| <= " in out) == bool(model.contacts)

    def test_the_equations_under_an_option(self, capsys: pytest.CaptureFixture[str]) -> None:
        name = "disc-nonlinear-contact"
        assert run(["models", name, "--option", "geometry=linear"]) == 0
        out = capsys.readouterr().out
        assert "  u'' = " in out and "q_" not in out.split("Equations")[1]
        assert run(["models", name, "--option", "geometry=linear", "--law", "stribeck"]) == 0
        assert "exp(" in capsys.readouterr().out
        for option, told in (
            ("geometry=flat", "must be nonlinear, linear"),
            ("geometri=linear", "did you mean 'geometry'"),
        ):
            assert run(["models", name, "--option", option]) == 2
            assert told in capsys.readouterr().err
        assert run(["models", "stribeck", "--option", "geometry=linear"]) == 2
        assert "--option is for a model" in capsys.readouterr().err

    def test_which_have_a_parameter_or_a_state(self, capsys: pytest.CaptureFixture[str]) -> None:
        """Whoever looked for a cubic spring had to read the table of every model."""
        assert run(["models", "k_nl"]) == 0
        rows = capsys.readouterr().out.splitlines()[2:]
        having = [
            m.name for m in all_models().values() if any(p.name == "k_nl" for p in m.parameters)
        ]
        assert [row.split()[0] for row in rows] == having
        assert run(["models", "phi", "--json"]) == 0
        found = json.loads(capsys.readouterr().out)["of"]
        assert {"of": "pin-on-disc", "unit": "rad"}.items() <= found[-1].items()
        assert run(["models", "geometry"]) == 0
        assert "option: " in capsys.readouterr().out

    def test_equations_are_those_of_the_model(self, capsys: pytest.CaptureFixture[str]) -> None:
        run(["models", "belt-1dof"])
        out = capsys.readouterr().out
        assert "  x'' = (F_T - c*x' - k*(-u0*cos(omega*t) + x))/m\n" in out
        assert "  F_T = F_N*mu_k*sgn(v)" in out

    @pytest.mark.parametrize("name", list(all_laws()))
    def test_law(self, name: str, capsys: pytest.CaptureFixture[str]) -> None:
        assert run(["models", name, "--laws"]) == 0
        out = capsys.readouterr().out
        assert "F_T = " in out
        assert ("never sticks" in out) == (all_laws()[name].capacity is None)
        named = [parameter.name for parameter in all_laws()[name].parameters]
        own = "mu_k = 0.23" in out  # on the belt, where the law alone has another
        assert own == ("mu_k" in named)
        assert ("States of its own" in out) == bool(all_laws()[name].states)

    def test_json(self, capsys: pytest.CaptureFixture[str]) -> None:
        assert run(["models", "--json"]) == 0
        found = json.loads(capsys.readouterr().out)
        assert found["schema"] == 1
        assert [model["name"] for model in found["models"]] == list(all_models())
        assert run(["models", "stribeck", "--laws", "--json"]) == 0
        law = json.loads(capsys.readouterr().out)
        assert [parameter["name"] for parameter in law["parameters"]] == [
            "mu_s",
            "mu_k",
            "v_s",
            "delta",
        ]

    def test_a_terminal_shows_brackets_as_they_are(
        self, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
    ) -> None:
        monkeypatch.setattr(sys.stdout, "isatty", lambda: True)
        print_table("[model]", ("a long name",), [("[b]",)])
        out = capsys.readouterr().out
        assert "[model]" in out
        assert "[b]" in out

    def test_plain_table(self) -> None:
        assert plain_table(("a", "bb"), [("ccc", "d")]) == ["a    bb", "ccc  d"]


class TestCheck:
    def test_json(self, case: Path, tmp_path: Path) -> None:
        bad = tmp_path / "bad.toml"
        bad.write_text(CASE.replace("v =", "w ="))
        done = fiv("check", "--json", str(case), str(bad))
        assert done.returncode == 3
        good, wrong = json.loads(done.stdout)["cases"]
        assert (good["valid"], good["problems"]) == (True, [])
        assert good["plan"]
        assert not wrong["valid"]
        assert [(p["path"], p["line"]) for p in wrong["problems"]] == [("grid.w", 5)]

    def test_environment_twin_of_an_option(self, case: Path) -> None:
        done = fiv("check", str(case), FIV_CHECK_SET="model.parameters.m=-1")
        assert done.returncode == 3

    def test_the_plan_counts_points(self, case: Path) -> None:
        assert "2 points" in fiv("check", str(case)).stdout


def units_of(template: str, mark: str = "#") -> tuple[list[str], list[list[int]]]:
    """The lines of a template, and those behind a mark that are to be taken in together."""
    lines, units = template.split("\n"), []
    for number, line in enumerate(lines):
        if line.startswith(f"{mark}   "):
            units[-1].append(number)
        elif line.startswith(f"{mark} "):
            units.append([number])
    return lines, units


def with_lines(lines: Sequence[str], taken_in: Sequence[int]) -> str:
    """A template with the # taken off some lines."""
    return "\n".join(
        re.sub(r"^#+ +", "", line) if number in taken_in else line
        for number, line in enumerate(lines)
    )


class TestNew:
    @pytest.mark.parametrize(("name", "kind"), SUITED)
    def test_every_line_behind_a_mark_may_be_taken_in(self, name: str, kind: str) -> None:
        """One by one, and all together."""
        model, analysis = all_models()[name], all_analyses()[kind]
        lines, units = units_of(case_template(model, analysis))
        for taken_in in [[], *units, list(chain(*units))]:
            case = parse_case(with_lines(lines, taken_in), "new.toml")
            make_plan(case)
            assert (case.model.split(" + ")[0], case.analyses[0].kind) == (name, kind)
        assert set(case.parameters) - set(case.schedule.names) <= set(case.explicit)
        if analysis.varying:
            assert len(case.schedule.names) == 1
        settings = {s.name for s in analysis.settings if s.suits(model)}
        assert all(case.analyses[0].settings[setting] is not None for setting in settings)
        assert case.claims and case.figures and case.figures[0].settings
        kinds = ["state", "equilibrium", "random", "table"] + ["continue"] * bool(case.axes)
        if analysis.uses_starts and analysis.chains:
            assert [start.kind for start in case.starts] == kinds

    @pytest.mark.parametrize(("name", "kind"), SUITED)
    def test_every_line_behind_two_marks_may_be_taken_in_alone(self, name: str, kind: str) -> None:
        """A second axis (with it or without, the pair that goes together), and a refined grid."""
        analysis = all_analyses()[kind]
        lines, units = units_of(case_template(all_models()[name], analysis), "##")
        cases = [
            parse_case(with_lines(lines, taken_in), "new.toml")
            for unit in units
            for taken_in in (unit, unit[:1])
        ]
        sizes = [make_plan(case).analyses[0].size for case in cases]
        if not analysis.single:
            assert len(cases[0].axes) == 2 and cases[0].zips and sizes[1] > sizes[0]
            is_classed = any(v.is_class and not v.ragged for v in possible_variables(analysis))
            assert (cases[-1].refinement is not None) == is_classed

    @pytest.mark.parametrize(("name", "kind"), SUITED)
    def test_what_is_behind_a_mark_is_what_holds_without_it(self, name: str, kind: str) -> None:
        """The parameters, options and settings of the solver that are shown are the defaults."""
        lines, units = units_of(case_template(all_models()[name], all_analyses()[kind]))
        bare = parse_case("\n".join(lines), "new.toml")
        tables = (unit for unit in units if "[" not in lines[unit[0]].partition("#")[2][:4])
        spelt = parse_case(with_lines(lines, list(chain(*tables))), "new.toml")
        following = {p.name for p in all_models()[name].adopted(get_law(bare.law))}
        for parameter, value in bare.parameters.items():
            assert spelt.parameters[parameter] == value or parameter in following
        assert (spelt.options, spelt.solver) == (bare.options, bare.solver)

    @pytest.mark.parametrize(
        "name",
        [
            "belt-1dof",
            "pin-on-disc",
            *(
                pytest.param(name, marks=pytest.mark.campaign)
                for name, model in all_models().items()
                if model.contacts and name not in ("belt-1dof", "pin-on-disc")
            ),
        ],
    )
    def test_the_first_case_of_a_model_vibrates(self, name: str) -> None:
        text = case_template(all_models()[name], all_analyses()["response"])
        found = api.run(parse_case(text, "new.toml"), workers=1)
        assert "periodic" in api.names_of(found["attractor"]).values

    @pytest.mark.parametrize("model", [m for m in all_models().values() if m.contacts])
    def test_sliding_changes_its_stability_in_the_first_case_of_a_model(self, model: Any) -> None:
        text = case_template(model, all_analyses()["critical"])
        found = api.run(parse_case(text, "new.toml"), workers=1)
        assert (found["n_crossings"] >= 1).all()

    def test_what_does_not_suit_a_model(self, capsys: pytest.CaptureFixture[str]) -> None:
        assert run(["new", "annular-plate"]) == 2
        refused = capsys.readouterr().err
        assert "does not move" in refused and "--analysis plate" in refused
        assert run(["new", "belt-1dof", "--analysis", "plate"]) == 2
        assert "has no elastic disc" in capsys.readouterr().err

    def test_stdout_is_the_file(self, capsys: pytest.CaptureFixture[str]) -> None:
        assert run(["new", "pin-on-disc"]) == 0
        expected = case_template(all_models()["pin-on-disc"], all_analyses()["response"])
        assert capsys.readouterr().out == expected


def walk(schema: Any) -> Iterator[dict[str, Any]]:
    """Every object in a JSON document."""
    if isinstance(schema, dict):
        yield schema
    inner = schema.values() if isinstance(schema, dict) else schema
    for one in inner if isinstance(schema, dict | list) else ():
        yield from walk(one)


class TestSchema:
    def branch(self, table: str, key: str, value: str) -> dict[str, Any]:
        """What the schema says of `table` where `key` is `value`."""
        for rule in case_schema()["$defs"][table]["allOf"]:
            if rule["if"]["properties"][key]["const"] == value:
                return rule["then"]
        raise AssertionError(f"no rule for {value}")

    def test_references_resolve(self) -> None:
        schema = case_schema()
        references = [one["$ref"] for one in walk(schema) if isinstance(one.get("$ref"), str)]
        assert references
        assert {ref.removeprefix("#/$defs/") for ref in references} <= set(schema["$defs"])

    def test_types_are_those_of_json_schema(self) -> None:
        types = {"object", "array", "string", "number", "integer", "boolean", "null"}
        found = {one["type"] for one in walk(case_schema()) if isinstance(one.get("type"), str)}
        assert found <= types

    def test_names_are_listed(self) -> None:
        tables = case_schema()["$defs"]
        assert tables["ModelTable"]["properties"]["name"]["enum"] == list(all_models())
        assert tables["AnalysisTable"]["properties"]["kind"]["enum"] == list(all_analyses())
        assert set(all_laws()) < set(tables["FrictionTable"]["properties"]["law"]["enum"])

    @pytest.mark.parametrize("name", list(all_models()))
    def test_parameters_of_a_model(self, name: str) -> None:
        known = self.branch("ModelTable", "name", name)["properties"]["parameters"]
        assert list(known["properties"]) == [p.name for p in all_models()[name].parameters]
        assert not known["additionalProperties"]
        assert all(about["description"] for about in known["properties"].values())

    @pytest.mark.parametrize("kind", list(all_analyses()))
    def test_settings_of_an_analysis(self, kind: str) -> None:
        settings = all_analyses()[kind].settings
        rule = self.branch("AnalysisTable", "kind", kind)
        assert set(rule["properties"]) == {setting.name for setting in settings}
        assert rule.get("required", []) == [s.name for s in settings if s.required]

    def test_every_table_of_the_case_is_described(self) -> None:
        properties = case_schema()["properties"]
        assert set(properties) >= {"schema", "model", "friction", "grid", "sweep", "initial"}
        assert all("description" in about or "$ref" in about for about in properties.values())

    def test_command(self, capsys: pytest.CaptureFixture[str]) -> None:
        assert run(["schema"]) == 0
        assert json.loads(capsys.readouterr().out) == json.loads(json.dumps(case_schema()))


class TestCompletion:
    def complete(self, words: Sequence[str]) -> list[str]:
        done = fiv(
            _FIV_COMPLETE="bash_complete",
            COMP_WORDS=" ".join(["fiv", *words]),
            COMP_CWORD=str(len(words)),
        )
        assert done.returncode == 0
        return [line.partition(",")[2] for line in done.stdout.splitlines()]

    def test_commands(self) -> None:
        assert self.complete(["s"]) == ["schema", "status", "show"]

    def test_options(self) -> None:
        assert "--laws" in self.complete(["models", "--l"])

    @pytest.mark.parametrize("shell", ["zsh", "fish"])
    def test_script(self, shell: str, capsys: pytest.CaptureFixture[str]) -> None:
        assert run(["completion", shell]) == 0
        assert "_FIV_COMPLETE" in capsys.readouterr().out
