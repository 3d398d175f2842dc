"""``fiv status``: how far a run has come."""

from __future__ import annotations

import time
from contextlib import suppress
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
from fiv_cli.errors import FivError

if TYPE_CHECKING:
    from collections.abc import Sequence

    from fiv_cli.case.case import Case
    from fiv_cli.data.log import Told
    from fiv_cli.sweep.answer import Answer


LOOKS = 5  # at files that a live run may merge meanwhile


@dataclass(frozen=True)
class Standing:
    """How far a run has come.

    Attributes
    ----------
    dataset_partial : it says so itself
    dataset_of_other_points : it has another grid, or other starts, than the case
    running : process that is running it; None: nobody is
    running_parts : parts of it that are being run, ``3/16``
    counts : status -> number of points
    answers : what each analysis has found so far
    refined : of each refined analysis, in a line, how much of it was run
    stored_case_differs : how what is stored differs from the case; then it is not counted
    elapsed, rate, left : of a live run, or else of the last one: seconds so far, points per second
        of the analysis that came last, seconds that it still takes at that rate; None: there was
        none
    pace : the same in words
    """

    case: str
    dataset: str
    dataset_exists: bool
    dataset_partial: bool
    dataset_of_other_points: bool
    running: int | None
    running_parts: list[str]
    points: int
    counts: dict[str, int]
    answers: list[Answer]
    refined: list[str]
    ignored_shards: list[str]
    stored_case_differs: list[str]
    elapsed: float | None = None
    rate: float | None = None
    left: float | None = None
    pace: str = ""

    def lines(self) -> list[str]:
        """For people."""
        from fiv_cli.sweep.plan import counted
        from fiv_cli.sweep.run import counted_statuses

        left, filled = self.counts["pending"], sum(answer.filled for answer in self.answers)
        asked = self.points - filled
        run = f"{asked - left} of {counted(asked)} done{self._in_vain()}"
        run += f", {filled} filled in" * bool(filled)
        holds = self._dataset_holds()
        found = [line for answer in self.answers for line in answer.lines(reasons=False)]
        lines = [
            f"{self.case}: {run}",
            f"  {', '.join(counted_statuses(self.counts, filled))}",
            *found,
            *(f"  {line}" for line in self.refined),
            f"  dataset {self.dataset}" + (f" ({holds})" if holds else ""),
            *self._going_on(),
            *([f"  running: part {', '.join(self.running_parts)}"] if self.running_parts else []),
            *(f"  ignored {shard}" for shard in self.ignored_shards),
        ]
        if self.stored_case_differs:
            lines.append("  what is stored belongs to another case, or to this one as it was:")
        return lines + [f"    {line}" for line in self.stored_case_differs]

    def _in_vain(self) -> str:
        """How many of the points that are done have no answer."""
        ends = {"failed": "failed", "budget": "met max_steps or max_events"}
        told = [
            f"{self.counts[status]} {how}" for status, how in ends.items() if self.counts[status]
        ]
        return f", of which {' and '.join(told)}" if told else ""

    def _going_on(self) -> list[str]:
        """Who is running it, or was, how fast, and what to do."""
        if self.running:
            told = f": {self.pace}" if self.pace else ""
            return [f"  process {self.running} is running it{told}; `kill {self.running}` stops it"]
        if self.running_parts or not self.counts["pending"]:
            return []
        goes_on = "  nobody is running it; the same `fiv run` goes on from here"
        last = [f"  the last run that computed points: {self.pace}"] if self.pace else []
        return [goes_on] * (self.points > self.counts["pending"]) + last

    def _dataset_holds(self) -> str:
        """What the dataset lacks, or holds instead; empty where it is all of it."""
        whole = "partial" if self.dataset_partial else "complete"
        if not self.dataset_exists:
            return "not written yet"
        if self.stored_case_differs:
            return f"{whole}, of another version of the case"
        if self.dataset_of_other_points:
            return f"{whole}, of another grid or other starts; `fiv run` writes this one"
        stored = self.points - self.counts["pending"]
        if stored and self.dataset_partial == bool(self.counts["pending"]):
            return "partial" * self.dataset_partial
        return f"{whole}, as it was before; `fiv run` writes it anew"


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
    """What is known of a run; looked at again where a live one merged its files meanwhile."""
    from fiv_cli.data.shard import UnreadableShard

    for _ in range(LOOKS - 1):
        with suppress(UnreadableShard):
            return _stored_of(source, output, overrides)
    return _stored_of(source, output, overrides)


def _stored_of(source: str, output: Path | None, overrides: tuple[str, ...]) -> Standing:
    from fiv_cli import api
    from fiv_cli.case.identity import default_output, differences
    from fiv_cli.data.log import run_folder, runs_in
    from fiv_cli.data.netcdf import global_attributes
    from fiv_cli.sweep.answer import answers
    from fiv_cli.sweep.journal import Journal, stored_identity
    from fiv_cli.sweep.lock import holder
    from fiv_cli.sweep.parts import part_folders
    from fiv_cli.sweep.plan import make_plan
    from fiv_cli.sweep.run import count_statuses, pending, refinements

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
        dataset_of_other_points=_is_of_other_points(path, case),
        running=holder(folder),
        running_parts=[str(part) for part, own in parts.items() if holder(own) is not None],
        points=sum(counts.values()),
        counts=counts,
        answers=answers(journal),
        refined=refinements(journal),
        ignored_shards=[f"{shard}: {why}" for shard, why in journal.ignored],
        stored_case_differs=differing,
    )
    runs = [] if differing else runs_in(folder)
    return _with_pace(standing, runs, pending(journal), journal.grows)


def _is_of_other_points(path: Path, case: Case) -> bool:
    from fiv_cli.reading.claims import of_same_points
    from fiv_cli.reading.datasets import read_analyses

    with suppress(FivError, OSError):  # none, or none that can be read: told by what reads it
        return not of_same_points(read_analyses(path), case)
    return False


def _with_pace(
    standing: Standing, runs: Sequence[Told], pending: dict[str, int], grows: bool
) -> Standing:
    """What the log tells of a run that goes on, or of the last one that did anything."""
    if standing.running is None:
        runs = [run for run in runs if len(run.course.times) > 1]
    if not runs:
        return standing
    course, left = runs[-1].course, sum(pending.values())
    ended = None if standing.running else runs[-1].last
    # what was under way when a run was ended took its time, too; after the last point nothing is
    now = (ended if left else course.times[-1]) if ended else time.time()
    course.total, course.later = course.done + left, left - pending.get(course.name, left)
    course.grows = grows
    return replace(
        standing,
        elapsed=course.elapsed(ended or now),
        rate=course.rate(now),
        left=course.left(now),
        pace=course.pace(now, ended),
    )
