"""What the README tells its reader to type is understood."""

from __future__ import annotations

import importlib
import os
import re
import shlex
import subprocess
import sys
import textwrap
from pathlib import Path
from typing import Any

import pytest

import fiv_cli.analyses
from fiv_cli.analyses.base import Request, Start
from fiv_cli.analyses.variables import Subject
from fiv_cli.case.grammar import parse_expect
from fiv_cli.case.kinds import TABLES
from fiv_cli.case.load import parse_case
from fiv_cli.cli import main
from fiv_cli.cli.common import STILL_TO_RUN, UNSOUND
from fiv_cli.cli.main import COMMANDS
from fiv_cli.codegen.setup import Setup, default_parameters
from fiv_cli.dynamics.settings import SolverSettings
from fiv_cli.dynamics.system import build_system
from fiv_cli.errors import FivError
from fiv_cli.models import all_models

ROOT = Path(__file__).parents[1]
README = (ROOT / "README.md").read_text()


def blocks(language: str) -> list[str]:
    return re.findall(rf"```{language}\n(.*?)```", README, re.DOTALL)


def spoken() -> list[str]:
    """Every command line, in blocks and in running text."""
    lines = [line for block in blocks("sh") for line in block.splitlines()]
    return [*lines, *re.findall(r"`((?:fiv|make) [^`\n]+)`", README)]


def words(line: str) -> list[str]:
    """A command line without comment and redirection."""
    return shlex.split(line.partition(" > ")[0], comments=True)


LINES = [words(line)[1:] for line in spoken() if line.startswith("fiv ")]
TARGETS = sorted({words(line)[1] for line in spoken() if line.startswith("make ")})


@pytest.mark.parametrize("name", sorted({line[0] for line in LINES} - {"--help"}))
def test_every_command_exists(name: str) -> None:
    assert name in COMMANDS


@pytest.mark.parametrize(
    "line", [line for line in LINES if line[1:] not in ([], ["--help"])], ids=" ".join
)
def test_every_command_line_is_understood(line: list[str]) -> None:
    """All of it but for files of the user's own, which are not there."""
    command = importlib.import_module(COMMANDS[line[0]][0]).command
    context = command.make_context(line[0], line[1:], resilient_parsing="--with" in line)
    assert context.params


@pytest.mark.parametrize("target", TARGETS)
def test_every_make_target_exists(target: str) -> None:
    assert re.search(rf"^{target}:", (ROOT / "Makefile").read_text(), re.MULTILINE)


def all_explained(table: str) -> list[str]:
    """Every example that `fiv kinds TABLE` gives."""
    return re.findall(r"\n\n((?:    .*\n)+)", TABLES[table][0])


def explained(table: str) -> str:
    """The first example that `fiv kinds TABLE` gives."""
    example, *_ = all_explained(table)
    return textwrap.dedent(example)


def test_the_case_is_right() -> None:
    (case,) = blocks("toml")
    assert parse_case(case, "squeal.toml").model == "pin-on-disc"


@pytest.mark.parametrize(
    ("table", "axes"),
    [
        ("friction", ["friction", "Omega"]),
        ("grid", ["Omega", "mu_k", "initial.phi_dot"]),
        ("refine", ["Omega"]),  # beside the grid of the case, as those below
        ("forcing", ["Omega"]),
        ("initial", ["Omega"]),
        ("figure", ["Omega"]),
    ],
)
def test_the_example_of_a_table_fits_into_the_case(table: str, axes: list[str]) -> None:
    (case,) = blocks("toml")
    kept = (line for line in case.splitlines() if line[:5] not in ("Omega", "state"))
    text = "\n".join(kept) if table == "grid" else case
    grid = "" if "[grid]" in explained(table) else "[grid]\n"
    text = text.replace("[grid]\n", explained(table) + grid)
    assert [axis.name for axis in parse_case(text, "a.toml").axes] == axes


def test_the_notebook_runs(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("squeal.toml").write_text(blocks("toml")[0])
    (notebook,) = [block for block in blocks("python") if "import api" in block]
    exec(notebook, {})
    said = capsys.readouterr().out
    assert "Omega = 2.0, 8.0" in said
    assert re.search(r"2\.0 +far +periodic\n8\.0 +far +equilibrium", said)
    assert {path.name for path in tmp_path.iterdir()} == {"squeal.toml", "phase.png"}


def test_the_claim_is_understood() -> None:
    """Those of the page about the grammar, on the grid and from the start that they speak of."""
    (case,) = blocks("toml")
    grid = '[grid]\npsi_a = [0.0, 1.0]\nbeta = [0.0, "15 deg"]'
    up = '[[initial]]\nlabel = "up"\nkind = "continue"\nalong = "Omega"\nfrom = "far"\n'
    whole, *parts = all_explained("claim")
    others = (f'[[claim]]\nsource = "here"\ntext = "there"\n{part}' for part in parts)
    modes = '[[analysis]]\nkind = "eigenvalues"\n'
    text = "".join([case.replace("[grid]", grid), up, modes, whole, *others])
    *expected, share, line = [said.expect for said in parse_case(text, "a.toml").claims[1:]]
    forms = {"less_than": 0.6}, {"between": [6.5, 7.0]}, {"greater_than": 1}
    assert expected == [parse_expect(form) for form in forms]
    assert share.greatest.take == {"what": "share", "over": ["initial"], "of": "periodic"}
    assert (line.least.variable, line.share) == ("growth_frequency", 0.05)


def test_models_are_all_named() -> None:
    assert {name for name in all_models() if f"`{name}`" not in README} == set()


def test_every_path_exists() -> None:
    for path in re.findall(r"`((?:configs|fiv_cli|tests)/[\w/.]+)`", README):
        assert (ROOT / path).exists() or path.endswith("my_law.py"), path


def test_help_lists_every_exit_code() -> None:
    def below(error: type[FivError]) -> set[int]:
        return {error.exit_code}.union(*map(below, error.__subclasses__()))

    codes = below(FivError) | {0, UNSOUND, STILL_TO_RUN, main.INTERRUPTED, main.READER_GONE}
    (listed,) = re.findall(r"Exit codes:\n((?:  .*\n)+)", main.EPILOG)
    assert codes <= set(map(int, re.findall(r"\b\d+\b", listed)))


HELP = {name: str(importlib.import_module(COMMANDS[name][0]).command.help) for name in COMMANDS}
HELP |= {f"kinds {table}": text for table, (text, _) in TABLES.items() if text}


@pytest.mark.parametrize("name", HELP)
def test_help_names_cases_that_there_are(name: str) -> None:
    for path in re.findall(r"configs/\S+?\.toml", HELP[name]):
        assert list(ROOT.glob(path)), path


def with_fiv(folder: Path) -> dict[str, str]:
    """An environment in which a shell finds `fiv`, in the folder."""
    (folder / "fiv").write_text(f'#!/bin/sh\nexec {sys.executable} -m fiv_cli "$@"\n')
    (folder / "fiv").chmod(0o755)
    return {**os.environ, "PATH": f"{folder}:{os.environ['PATH']}"}


def examples(name: str) -> list[str]:
    """The lines of a command's help that are to be typed."""
    found = re.findall(r"^ *(?:while )?fiv .*$", HELP[name], re.MULTILINE)
    return [line.strip() for line in found]


# A scheduler of another machine; every sweep, or new answers of all; what a shell's start-up does.
NOT_HERE = ("--cluster", "--regenerate", "fiv regress --shard", "| source")
# Where exit codes other than 0 are the answer: points are left, a difference, a claim not run.
ANSWERS = {"--max-points 3 ": 8, "fiv diff ": 5, "fiv claims --strict": 5}


@pytest.mark.campaign
@pytest.mark.parametrize("name", [name for name in COMMANDS if examples(name)])
def test_the_examples_of_help_work_as_printed(name: str, tmp_path: Path) -> None:
    """One after the other, in a folder with the cases and the sweeps."""
    for folder in ("configs", "sweeps"):
        (tmp_path / folder).symlink_to(ROOT / folder)
    environment = with_fiv(tmp_path)
    for line in examples(name):
        if line == "fiv regress" or any(words in line for words in NOT_HERE):
            continue
        done = subprocess.run(
            line, shell=True, cwd=tmp_path, env=environment, capture_output=True, text=True
        )
        expected = next((code for part, code in ANSWERS.items() if part in line), 0)
        assert done.returncode == expected, f"{line}\n{done.stdout}{done.stderr}"


def test_the_analysis_that_help_shows_works() -> None:
    """On a mass that slides to and fro about its start, twice as far as where it would rest."""
    indented = re.findall(r"::\n\n((?:    .*\n|\n)+)", f"{fiv_cli.analyses.__doc__}")
    declaration, engine = map(textwrap.dedent, indented)
    spoken: dict[str, Any] = {}
    exec(declaration, spoken)
    exec(engine, spoken)
    setup = Setup.of("belt-1dof")
    parameters = default_parameters(setup.model, setup.law, v=100.0)
    start = Start("rest", "state")
    request = Request(setup, parameters, "reach", {"t_end": 10.0}, SolverSettings(), start)
    outcome = spoken["reach"](build_system(setup), request)
    subject = Subject(setup.model.states({}), "", False, {"t_end": 10.0})
    assert set(outcome.values) == {v.name for v in spoken["ANALYSIS"].variables(subject)}
    assert outcome.values["reach"] == pytest.approx([2.0 * parameters["mu_k"] * parameters["N"]])


def test_parts_from_batch_queues_join_to_the_dataset_of_one_run(tmp_path: Path) -> None:
    """The array of Slurm, as `sbatch` would start it, and the rules for make; of three parts."""
    job, rules = (
        textwrap.dedent(re.split(r":\n", part, maxsplit=1)[1])
        for part in HELP["assemble"].split("\b\n")[2:]
    )
    folders = {name: tmp_path / name for name in ("one", "slurm", "make")}
    for folder in folders.values():
        folder.mkdir()
        (folder / "a.toml").write_text(blocks("toml")[0])
    environment = with_fiv(tmp_path)

    def start(name: str, *command: str, **more: str) -> None:
        subprocess.run(command, cwd=folders[name], env={**environment, **more}, check=True)

    start("one", "fiv", "run", "-q", "a.toml")
    (folders["slurm"] / "job.sh").write_text(job.replace("16", "3"))
    first, last, cpus = re.findall(r"--array=(\d+)-(\d+) --cpus-per-task=(\d+)", job)[0]
    assert (first, last) == ("1", "16")
    for number in "312":
        start("slurm", "sh", "job.sh", SLURM_ARRAY_TASK_ID=number, SLURM_CPUS_PER_TASK=cpus)
    start("slurm", "fiv", "assemble", "a.toml")
    (folders["make"] / "Makefile").write_text(rules.replace("16", "3"))
    start("make", "make", "-s", "-j", "4")
    made = [(folder / "runs" / "a.nc").read_bytes() for folder in folders.values()]
    assert made == made[:1] * 3
