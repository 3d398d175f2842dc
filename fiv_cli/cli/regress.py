"""``fiv regress``: small sweeps against their stored answers."""

from __future__ import annotations

import shutil
import subprocess
import tempfile
import time
from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

import click

from fiv_cli import ending
from fiv_cli.cli.common import PartType, provide_cache, with_option
from fiv_cli.cli.reports import Verdict, report, report_options
from fiv_cli.errors import UsageError

if TYPE_CHECKING:
    from fiv_cli.reading.compare import Difference
    from fiv_cli.sweep.parts import Part

DIFFERENT = 5
SHOWN = 10
"""Differences that are printed of one sweep."""


@dataclass(frozen=True)
class Sweep:
    """A regression sweep: a folder with a case, its answer and its tolerances."""

    folder: Path

    @property
    def case(self) -> Path:
        """The case file."""
        return self.folder / "case.toml"

    @property
    def reference(self) -> Path:
        """The stored answer."""
        return self.folder / "reference.nc"

    @property
    def tolerances(self) -> Path:
        """How close an answer must come."""
        return self.folder / "tolerances.toml"


@click.command("regress")
@click.argument("folder", type=click.Path(path_type=Path), default=Path("sweeps"), metavar="[DIR]")
@with_option
@click.option("--workers", type=click.IntRange(min=1), default=2, show_default=True)
@click.option("--shard", "part", type=PartType(), help="Run every N-th sweep only, from the I-th.")
@report_options
@click.option(
    "--regenerate",
    is_flag=True,
    help="Store new answers instead. Refused while the working tree has changes.",
)
def command(
    folder: Path,
    workers: int,
    part: Part | None,
    junit: Path | None,
    summary: Path | None,
    regenerate: bool,
) -> int:
    """Run every sweep of DIR (default: sweeps) and compare it with its reference.

    Each sweep is a folder with case.toml, reference.nc and tolerances.toml. The exit code is 5
    when any differs.

    In CI, keep ~/.cache/fiv (or the folder that FIV_CACHE_DIR names) between jobs, and nothing is
    compiled twice; `fiv verify` and `fiv claims --strict` write the same reports.

    \b
    Examples:
      fiv regress
      fiv regress sweeps/pin-reached
      fiv regress --shard 2/4 --junit regress.xml --summary "$GITHUB_STEP_SUMMARY"
      fiv regress --regenerate
    """
    sweeps = find_sweeps(folder)
    if part is not None:
        sweeps = sweeps[part.number - 1 :: part.of]
    provide_cache()
    if regenerate:
        _refuse_dirty_tree(folder)
    verdicts = [_regress(sweep, workers, regenerate) for sweep in sweeps]
    report("fiv regress", verdicts, junit, summary)
    return 0 if all(verdict.passed for verdict in verdicts) else DIFFERENT


def find_sweeps(folder: Path) -> list[Sweep]:
    """The sweeps in a folder, or the one that the folder is.

    Raises
    ------
    UsageError
        there is none.
    """
    if (folder / "case.toml").is_file():
        return [Sweep(folder)]
    found = [Sweep(path.parent) for path in sorted(folder.glob("*/case.toml"))]
    if not found:
        raise UsageError(
            f"{folder}: holds no sweep\nnext: name a folder with NAME/case.toml and "
            "NAME/reference.nc in it"
        )
    return found


def _regress(sweep: Sweep, workers: int, regenerate: bool) -> Verdict:
    """Run one sweep, and compare it or store it."""
    begun = time.monotonic()
    with (
        tempfile.TemporaryDirectory(prefix="fiv-regress-") as scratch,
        ending.last_act(partial(shutil.rmtree, scratch, ignore_errors=True)),
    ):
        output = Path(scratch) / "result.nc"
        _run(sweep, output, workers)
        if regenerate:
            _store(output, sweep.reference)
            lines = ["reference stored"]
        else:
            lines = _described(_differences(sweep, output))
    name = sweep.folder.name
    click.echo("\n  ".join([f"{name}: {lines[0]}", *lines[1:]]))
    seconds = time.monotonic() - begun
    return Verdict("sweeps", name, "\n".join(lines), len(lines) == 1, seconds)


def _store(output: Path, reference: Path) -> None:
    from fiv_cli.files import refuse_special, write_whole

    refuse_special(reference, "DIR")
    write_whole(reference, output.read_bytes())


def _run(sweep: Sweep, output: Path, workers: int) -> None:
    from fiv_cli import api
    from fiv_cli.sweep.policy import Policy
    from fiv_cli.sweep.progress import for_stderr
    from fiv_cli.sweep.run import run_case

    run_case(api.load(sweep.case), output, Policy(workers=workers), for_stderr(quiet=True))


def _differences(sweep: Sweep, output: Path) -> list[Difference]:
    from fiv_cli.reading.compare import Tolerances, compare, read_tolerances
    from fiv_cli.reading.datasets import read_analyses

    if not sweep.reference.exists():
        raise UsageError(
            f"{sweep.reference}: missing\nnext: `fiv regress {sweep.folder} --regenerate`"
        )
    own = sweep.tolerances
    tolerances = read_tolerances(own) if own.exists() else Tolerances(standard_errors=0.0)
    return compare(read_analyses(sweep.reference), read_analyses(output), tolerances)


def _described(differences: Sequence[Difference]) -> list[str]:
    """What is said of a sweep: in one line where it agrees, in several where it does not."""
    if not differences:
        return ["agrees"]
    return [
        f"{len(differences)} differences (reference against now)",
        *(
            f"{one.what}: {one.text}" + (f" ({one.count})" if one.count > 1 else "")
            for one in differences[:SHOWN]
        ),
    ]


def _refuse_dirty_tree(folder: Path) -> None:
    """New references must belong to a commit."""
    inside = folder if folder.is_dir() else Path()
    state = subprocess.run(
        ["git", "-C", str(inside), "status", "--porcelain", "--untracked-files=no"],
        capture_output=True,
        text=True,
        check=False,
    )
    if state.returncode == 0 and state.stdout.strip():
        raise UsageError(
            "the working tree has changes, so new references would belong to no commit\n"
            "next: commit first, then `fiv regress --regenerate`"
        )
