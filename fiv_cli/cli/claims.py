"""``fiv claims``: what the publication says, held against what was computed."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import click

from fiv_cli.cli.common import json_option, print_json, set_option, with_option
from fiv_cli.cli.reports import Verdict, report, report_options
from fiv_cli.errors import CaseError, DifferenceError, UsageError, printable

if TYPE_CHECKING:
    from fiv_cli.reading.undecided import Undecided

DEFAULT = Path("configs")


@dataclass(frozen=True)
class Entry:
    """One line of the ledger."""

    case: str
    source: str
    text: str
    verdict: str
    found: str
    note: str
    standard_error: float | None = None


@click.command("claims")
@click.argument("paths", nargs=-1, type=click.Path(path_type=Path), metavar="[DIR or CASE...]")
@click.option("--strict", is_flag=True, help="Exit 5 on a contradiction without a note, or no run.")
@set_option
@click.option("-o", "--output", type=click.Path(path_type=Path), help="The dataset, as of the run.")
@json_option
@report_options
@with_option
def command(
    paths: tuple[Path, ...],
    strict: bool,
    overrides: tuple[str, ...],
    output: Path | None,
    as_json: bool,
    junit: Path | None,
    summary: Path | None,
) -> None:
    """Hold every [[claim]] of the cases against their datasets.

    DIR (default: configs) stands for every case file in it. A claim is confirmed, contradicted
    or undetermined (points it needs are not computed or undecided, or may be off by more than what
    is expected leaves); of open points that are no more than 0.5 % of those it is tried on the
    rest decides, whatever they might hold, and the finding counts them. A share is held as it is:
    its standard error is told, and `expect` has to allow for it. A case whose dataset is not there
    is "not run", with the command that computes it. Nothing is computed here. With --set or -o the
    dataset is the one that `fiv run` writes with the same. The last line counts the points of the
    datasets that have no class, and why. The exit code is 0 whatever the verdicts, unless --strict
    is given.

    \b
    Examples:
      fiv run configs/ch7/fig_7_06_reached.toml && fiv claims configs/ch7/fig_7_06_reached.toml
      fiv claims configs/ch7 --json
      fiv claims squeal.toml -o runs/lighter.nc --set 'model.parameters.N0="20 N"'
      fiv claims --strict --junit claims.xml --summary summary.md
    """
    from fiv_cli.reading.undecided import Undecided

    undecided = Undecided()
    files = case_files(paths or (DEFAULT,))
    if output and len(files) > 1:
        raise UsageError(
            f"-o {output}: one dataset, {len(files)} cases\nname its own: fiv claims CASE -o FILE"
        )
    ledger = [entry for file in files for entry in judge(file, undecided, overrides, output)]
    if as_json:
        print_json({"claims": ledger, "classes": undecided.as_plain()})
    else:
        counted = [undecided.line()] if undecided.points else []
        click.echo(printable("\n".join([*lines(ledger), *counted])))
    report("fiv claims", [_verdict(entry) for entry in ledger], junit, summary)
    if strict:
        _demand(ledger)
    elif not as_json and any(map(_is_held_against, ledger)):
        click.echo("the exit code is 0 all the same; with --strict it is 5", err=True)


def case_files(paths: Iterable[Path]) -> list[Path]:
    """The case files meant: a folder stands for all of those below it, in order.

    Raises
    ------
    UsageError : a path does not exist, or a folder holds no case
    """
    return [file for path in paths for file in _files_of(path)]


def _files_of(path: Path) -> list[Path]:
    if path.is_file():
        return [path]
    if not path.is_dir():
        raise UsageError(f"{path}: there is no such file or folder\nname a case: fiv claims CASE")
    files = [file for file in sorted(path.rglob("*.toml")) if _is_case(file)]
    if not files:
        raise UsageError(f"{path}: no case files in it\nname a case: fiv claims CASE")
    return files


def _is_case(file: Path) -> bool:
    """Whether a TOML file found in a folder is a case of its own.

    Run directories keep a copy of theirs; other TOML files (tolerances, projects) have no schema.
    """
    from fiv_cli.case.toml import parse_toml

    if any(parent.suffix == ".run" for parent in file.parents):
        return False
    try:
        return "schema" in parse_toml(file.read_text(encoding="utf-8"))
    except ValueError:
        return True  # broken: loading it says where


def judge(
    path: Path, undecided: Undecided, overrides: Sequence[str] = (), output: Path | None = None
) -> list[Entry]:
    """The ledger of one case file and its dataset; points of no class count in `undecided`."""
    from fiv_cli import api
    from fiv_cli.reading.claims import dataset_of, held_against

    try:
        case = api.load(path, overrides)
    except CaseError:
        entry = _without_its_model(path)
        if entry is None:
            raise
        return [entry]
    analyses, missing = dataset_of(case, output)
    undecided.add((analyses or {}).values())
    verdicts = zip(case.claims, held_against(case, analyses, missing), strict=True)
    return [
        Entry(str(path), c.source, c.text, v.verdict, v.found, c.note, v.standard_error)
        for c, v in verdicts
    ]


def _without_its_model(path: Path) -> Entry | None:
    """What stands for a case whose model is in a file that was not named; None: it is another."""
    from fiv_cli.case.toml import parse_toml
    from fiv_cli.models import all_models
    from fiv_cli.own.load import files_with
    from fiv_cli.reading.claims import NOT_RUN

    try:
        model = parse_toml(path.read_text(encoding="utf-8")).get("model")
    except ValueError:
        return None
    name = model.get("name") if isinstance(model, dict) else None
    if (
        not isinstance(name, str)
        or name in all_models()
        or not (files := files_with(name, str(path)))
    ):
        return None
    given = "".join(f" --with {file}" for file in files)
    said = f"its model stands in {files[0]}: fiv claims {path}{given}"
    return Entry(str(path), f"model {name!r}", "not known here", NOT_RUN, said, "")


def lines(ledger: Sequence[Entry]) -> list[str]:
    """The ledger for people: the cases in order, and a count of the verdicts."""
    from fiv_cli.reading.claims import tally

    printed = []
    for case in dict.fromkeys(entry.case for entry in ledger):
        printed.append(case)
        printed += [line for entry in ledger if entry.case == case for line in _lines_of(entry)]
    return [*printed, tally([entry.verdict for entry in ledger])]


def _lines_of(entry: Entry) -> list[str]:
    indent = " " * 15
    found = [
        f"  {entry.verdict:<12} {entry.source}: {entry.text}",
        f"{indent}{entry.found}",
    ]
    return [*found, f"{indent}note: {entry.note}"] if entry.note else found


def _is_held_against(entry: Entry) -> bool:
    """Whether --strict minds: contradicted without a note, or not tried."""
    from fiv_cli.reading.claims import CONTRADICTED, NOT_RUN

    return entry.verdict == NOT_RUN or (entry.verdict == CONTRADICTED and not entry.note)


def _verdict(entry: Entry) -> Verdict:
    name = f"{entry.source}: {entry.text}"
    return Verdict(entry.case, name, f"{entry.verdict}: {entry.found}", not _is_held_against(entry))


def _demand(ledger: Sequence[Entry]) -> None:
    """DifferenceError when a claim is contradicted without a note, or was not tried."""
    from fiv_cli.reading.claims import NOT_RUN

    minded = [entry for entry in ledger if _is_held_against(entry)]
    not_run = sum(entry.verdict == NOT_RUN for entry in minded)
    if minded:
        raise DifferenceError(
            f"{len(minded) - not_run} claims contradicted without a note, {not_run} not run\n"
            "run the cases, and correct the claim or add a `note` that explains the difference"
        )
