"""``fiv status``: how far a run has come."""

from __future__ import annotations

import time
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING

import click

from fiv_cli.cli.common import (
    STILL_TO_RUN,
    json_option,
    plain,
    print_json,
    set_option,
    with_option,
)

if TYPE_CHECKING:
    from fiv_cli.sweep.journal import Journal


@dataclass(frozen=True)
class Standing:
    """How far a run has come.

    Attributes
    ----------
    dataset_partial : it says so itself
    running : process that is running it; None: nobody is
    running_parts : parts of it that are being run, ``3/16``
    counts : status -> number of points
    refined : of each refined analysis, in a line, how much of it was run
    stored_case_differs : how what is stored differs from the case; then it is not counted
    elapsed, rate, left : of a live run: seconds since it began, points per second, seconds to go
        at that rate
    pace : the same in words
    """

    case: str
    dataset: str
    dataset_exists: bool
    dataset_partial: bool
    running: int | None
    running_parts: list[str]
    points: int
    counts: dict[str, int]
    refined: list[str]
    ignored_shards: list[str]
    stored_case_differs: list[str]
    elapsed: float | None = None
    rate: float | None = None
    left: float | None = None
    pace: str = ""

    def lines(self) -> list[str]:
        """For people."""
        left = self.counts["pending"]
        done = self.points - left
        holds = f" ({self._dataset_holds()})" if left else ""
        running = [f"  process {self.running} is running it{self.pace}"] if self.running else []
        if left and done and not (running or self.running_parts):
            running = ["  nobody is running it; the same `fiv run` goes on from here"]
        lines = [
            f"{self.case}: {done} of {self.points} points done",
            *(f"  {count} {status}" for status, count in self.counts.items() if count),
            *(f"  {line}" for line in self.refined),
            f"  dataset {self.dataset}{holds}",
            *running,
            *([f"  running: part {', '.join(self.running_parts)}"] if self.running_parts else []),
            *(f"  ignored {shard}" for shard in self.ignored_shards),
        ]
        if self.stored_case_differs:
            lines.append("  what is stored belongs to another case, or to this one as it was:")
        return lines + [f"    {line}" for line in self.stored_case_differs]

    def _dataset_holds(self) -> str:
        """What the dataset is of a case that has points to run."""
        if not self.dataset_exists:
            return "not written yet"
        if not self.stored_case_differs:
            return "partial"
        return (
            f"{'partial' if self.dataset_partial else 'complete'}, of another version of the case"
        )


@click.command("status")
@click.argument("case")
@click.option(
    "-o", "--output", type=click.Path(path_type=Path), help="The dataset, if not the default."
)
@set_option
@with_option
@json_option
@click.option("--exit-code", is_flag=True, help="Exit with 8 where points are still to run.")
def command(
    case: str, output: Path | None, overrides: tuple[str, ...], as_json: bool, exit_code: bool
) -> int:
    """Say how many points of CASE are done, failed or still to run, without running anything.

    \b
    Examples:
      fiv new pin-on-disc > a.toml && fiv status a.toml
      fiv status a.toml --set model.parameters.N0=20 -o lighter.nc --json
      while fiv run a.toml --max-points 1000; [ $? = 8 ]; do fiv status a.toml; done
    """
    standing = _standing(case, output, overrides)
    if as_json:
        print_json(plain(standing))
    else:
        click.echo("\n".join(standing.lines()))
    return STILL_TO_RUN if exit_code and standing.counts["pending"] else 0


def _standing(source: str, output: Path | None, overrides: tuple[str, ...]) -> Standing:
    """What is known of a run."""
    from fiv_cli import api
    from fiv_cli.case.identity import default_output, differences
    from fiv_cli.data.netcdf import global_attributes
    from fiv_cli.sweep.journal import Journal, stored_identity
    from fiv_cli.sweep.lock import holder
    from fiv_cli.sweep.output import run_folder
    from fiv_cli.sweep.parts import part_folders
    from fiv_cli.sweep.plan import make_plan
    from fiv_cli.sweep.run import count_statuses, refinements

    case = api.load(source, overrides)
    path = output or default_output(case)
    folder = run_folder(path)
    parts = part_folders(folder)
    journal = Journal(folder, make_plan(case), parts.values())
    stored = stored_identity(folder)
    differing = [] if stored is None else differences(stored, case)
    if not differing:
        journal.load()
    counts = count_statuses(journal)
    standing = Standing(
        case=source,
        dataset=str(path),
        dataset_exists=path.exists(),
        dataset_partial=path.exists() and "partial" in (global_attributes(path) or {}),
        running=holder(folder),
        running_parts=[str(part) for part, own in parts.items() if holder(own) is not None],
        points=sum(counts.values()),
        counts=counts,
        refined=refinements(journal),
        ignored_shards=[f"{shard}: {why}" for shard, why in journal.ignored],
        stored_case_differs=differing,
    )
    return standing if standing.running is None else _on_its_way(standing, journal)


def _on_its_way(standing: Standing, journal: Journal) -> Standing:
    """What its files tell of a run that goes on: a lock since it began, a shard for each chunk."""
    begun, now = (journal.folder / "lock").stat().st_mtime, time.time()
    course = journal.course(begun, standing.counts["pending"])
    return replace(
        standing,
        elapsed=course.elapsed(now),
        rate=course.rate(now),
        left=course.left(now),
        pace=f": {course.pace(now)}",
    )
