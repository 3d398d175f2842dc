"""One case from plan to dataset: lock, resume, run, assemble, sum up."""

from __future__ import annotations

import contextlib
import os
import shlex
import time
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

import fiv_cli
from fiv_cli import ending
from fiv_cli.case.case import Case
from fiv_cli.case.identity import default_output, differences, document, fingerprint
from fiv_cli.case.overrides import parse_override
from fiv_cli.data.log import RUN_SUFFIX, came, logger, run_folder
from fiv_cli.data.provenance import command_of, provenance
from fiv_cli.errors import LockedError, StorageError, StoreMismatchError
from fiv_cli.files import leftovers
from fiv_cli.flags import NOT_COMPUTED, STATUS
from fiv_cli.sweep import journal as store
from fiv_cli.sweep.answer import Answer, answers
from fiv_cli.sweep.journal import Journal
from fiv_cli.sweep.lock import hold, holder
from fiv_cli.sweep.output import check_output
from fiv_cli.sweep.parts import Part, dealt_out, divisions, part_folders
from fiv_cli.sweep.plan import AnalysisPlan, Plan, counted, make_plan
from fiv_cli.sweep.policy import Policy
from fiv_cli.sweep.progress import Progress
from fiv_cli.sweep.receipt import is_made, made_from, write_receipt
from fiv_cli.sweep.scheduler import Scheduler

if TYPE_CHECKING:
    from fiv_cli.data.dataset import Dataset

SHOWN_ERRORS = 3
PENDING = "pending"
GOES_ON = "what is finished is kept; the same command{} goes on from here"
WITHOUT = " without --fresh"
CHANGED = (
    "next: a case that is changed so takes fiv run --fresh, or -o FILE.nc, which keeps this one"
)

LOOKED_AT = 8
"""How many other runs, the last ones, are asked for points: to read a thousand takes seconds."""

WORTH_REUSING = 0.5
"""Share of the points to begin with that others must hold to be told: a dataset makes way."""

SLOW, VAST = 1_000_000, 20_000_000
"""Points of a dataset that takes some seconds to write, which is said, and half a minute."""

SCANT = 0.01
"""Share of the points of a vast dataset below which it is not written before the run ends."""


@dataclass(frozen=True)
class Summary:
    """How a run ended.

    Attributes
    ----------
    output : the dataset
    counts : status -> number of points, over all analyses
    ran : points run now
    seconds : wall-clock time
    answers : what each analysis has found
    errors : (what, command that runs the point alone), the first distinct ones
    refined : of each refined analysis, how many of its points were run
    ignored : shards that could not be used, and why
    unwritten : why there is no dataset; empty: there is one
    fresh : what was stored before was thrown away, as the same command would again
    """

    output: Path
    counts: dict[str, int]
    ran: int
    seconds: float
    answers: tuple[Answer, ...] = ()
    errors: tuple[tuple[str, str], ...] = ()
    refined: tuple[str, ...] = ()
    ignored: tuple[tuple[Path, str], ...] = ()
    unwritten: str = ""
    fresh: bool = False

    @property
    def complete(self) -> bool:
        """Whether every point has its answer."""
        return self.sound and not self.counts.get(PENDING, 0)

    @property
    def sound(self) -> bool:
        """Whether every point that was run has its answer."""
        return not any(self.counts.get(status, 0) for status in ("failed", "budget"))

    def lines(self) -> list[str]:
        """The summary for people."""
        filled = sum(answer.filled for answer in self.answers)
        counts = ", ".join(counted_statuses(self.counts, filled))
        total = sum(self.counts.values())
        lines = [f"ignored {path}: {why}; its points are run again" for path, why in self.ignored]
        lines.append(
            f"{self.output}: {counted(total)}: {counts} ({self.ran} run now, {self.seconds:.1f} s)"
        )
        lines += [line for answer in self.answers for line in answer.lines()]
        for what, command in self.errors:
            lines += [f"  {what}", f"    alone: {command}"]
        lines += [f"  {line}" for line in self.refined]
        lines += [f"  {self.unwritten}"] if self.unwritten else []
        is_open = self.complete and any(answer.open for answer in self.answers)
        lines += [f"  {CHANGED}"] if is_open else []
        goes_on = self.sound and 0 < self.counts.get(PENDING, 0) < total
        return lines + [f"  {GOES_ON.format(WITHOUT * self.fresh)}"] * goes_on


def run_case(case: Case, output: Path, policy: Policy, progress: Progress) -> Summary:
    """Run what is left of `case` and write its dataset.

    Raises
    ------
    UsageError, StorageError
        the output cannot be written.
    StoreMismatchError
        another case is stored there.
    LockedError
        a live run holds the run directory.
    """
    begun = time.monotonic()
    plan = make_plan(case)
    refuse_output(case, output, policy.fresh)
    if policy.part is not None:
        return _run_part(plan, output, policy.part, policy, progress)
    folder = run_folder(output)
    store.create(folder)
    with hold(folder):
        _claim(folder, case, policy.fresh)
        journal = _loaded(Journal(folder, plan, part_folders(folder).values()))
        _sweep_leftovers(folder, output)
        if not policy.fresh and (elsewhere := _stored_elsewhere(journal)):
            progress.note(elsewhere)
        scheduler = Scheduler(journal, policy, progress, logger(folder))
        with _reported(scheduler, output, begun):
            _run_all(scheduler)
            with ending.heeded():  # afterwards: one signal leaves it the seconds that it takes
                unwritten = _written(journal, output, progress)
                summary = _summed_up(journal, output, scheduler.ran, begun, policy.fresh)
                return replace(summary, unwritten=unwritten)


def refuse_output(case: Case, output: Path, fresh: bool) -> None:
    """Raise what `run_case` would because of what is stored where its results go."""
    if not fresh:
        _refuse_another(run_folder(output), case)
    check_output(output, None if fresh else case)


def _run_part(plan: Plan, output: Path, part: Part, policy: Policy, progress: Progress) -> Summary:
    """Run what is left of a part of a plan, in a run directory of its own; without a dataset."""
    begun, case, run = time.monotonic(), plan.case, run_folder(output)
    _refuse_another(run, case)
    folder = part.folder(run)
    store.create(folder)
    with hold(folder):
        _claim(folder, case, policy.fresh)
        dealt = dealt_out(plan, part.of, run, lambda: _costs(Journal(run, plan)))
        mine = [parts == part.number for parts in dealt]
        journal = _loaded(Journal(folder, plan, [run], mine))
        _sweep_leftovers(folder, folder)
        scheduler = Scheduler(journal, policy, progress, logger(folder))
        with _reported(scheduler, folder, begun):
            _run_all(scheduler)
        return _summed_up(journal, folder, scheduler.ran, begun, policy.fresh)


def assemble_case(case: Case, output: Path) -> tuple[Summary, list[str]]:
    """Write the dataset of what runs and parts have stored; the lines say what is missing.

    Raises
    ------
    UsageError, StorageError, StoreMismatchError, LockedError
        as of `run_case`.
    """
    begun = time.monotonic()
    plan = make_plan(case)
    check_output(output, case)
    folder = run_folder(output)
    store.create(folder)
    with hold(folder):
        _claim(folder, case, False)
        journal = _loaded(Journal(folder, plan, part_folders(folder).values()))
        if journal.shards():
            write_dataset(journal, output)
        summary = _summed_up(journal, output, 0, begun)
        return summary, list(_missing(journal, output))


def _missing(journal: Journal, output: Path) -> Iterator[str]:
    """Of each part that has points to run, how many, and who runs them."""
    run = run_folder(output)
    for of in divisions(run):
        left = np.zeros(of + 1, np.int64)
        for parts, record in zip(dealt_out(journal.plan, of, run), journal.records, strict=True):
            left += np.bincount(parts[record.wanted() & ~record.done()], minlength=of + 1)
        for number in np.flatnonzero(left):
            part = Part(int(number), of)
            process = holder(part.folder(run))
            what = f"process {process} is running it" if process else f"--shard {part} runs them"
            yield f"part {part}: {counted(int(left[number]))} to run; {what}"


def _loaded(journal: Journal) -> Journal:
    journal.load()
    return journal


def _stored_elsewhere(journal: Journal) -> str:
    """Of a run that begins from nothing: who holds most of its points, and what to type."""
    plan, folder = journal.plan, journal.folder
    places = {folder.parent, default_output(plan.case).parent} if not journal.shards() else ()
    enough = WORTH_REUSING * journal.progress()[1]
    for other in _newest(path for place in places for path in place.glob(f"*{RUN_SUFFIX}")):
        stored = store.stored_identity(other) if other != folder else None
        if stored is None or differences(stored, plan.case) or store.most(other) < enough:
            continue
        done, _ = _loaded(Journal(other, plan)).progress()
        if done > enough:
            into = f"-o {other.with_suffix('.nc')} (in Python: output)"
            using = f"the same run with {into} uses them, and overwrites that dataset"
            return f"{counted(done)} of it lie in {other}; {using}"
    return ""


def _newest(folders: Iterable[Path]) -> list[Path]:
    """Those of the last few runs; none when they go away meanwhile."""
    with contextlib.suppress(OSError):
        return sorted(folders, key=lambda path: -path.stat().st_mtime)[:LOOKED_AT]
    return []


def _costs(journal: Journal) -> list[NDArray[np.float32]]:
    """What the points of each analysis will take, as far as those that are stored tell."""
    journal.load()
    return [journal.costs(index) for index in range(len(journal.records))]


def _run_all(scheduler: Scheduler) -> None:
    """Run what is left, and what the borders found in it ask for, until they ask no more."""
    with scheduler:
        more = True
        while more:
            more = scheduler.run()
            scheduler.journal.ask()


def write_dataset(journal: Journal, output: Path) -> None:
    """Assemble the dataset from the shards of a journal, unless it is there already.

    One that lacks points says so, in the attribute ``partial``.
    """
    from fiv_cli.data.netcdf import write_datasets

    case = journal.plan.case
    attributes = provenance(case, fingerprint(case)) | _partial(journal)
    sources = made_from(journal.shards(), attributes)
    if is_made(journal.folder, output, sources):
        return
    datasets = {
        analysis.layout.name: _assembled(journal, index)
        for index, analysis in enumerate(journal.plan.analyses)
    }
    write_datasets(output, datasets, attributes)
    write_receipt(journal.folder, output, sources)


def _written(journal: Journal, output: Path, progress: Progress) -> str:
    """Write the dataset of a run; or say why not, where it lacks nearly all of its points."""
    size = sum(analysis.size for analysis in journal.plan.analyses)
    done, total = journal.progress()
    if size >= VAST and done < min(total, SCANT * size):
        command = command_of(journal.plan.case).replace("fiv run", "fiv assemble", 1)
        return (
            f"{output} is not written, as {done:,} of its {size:,} points are done: the same "
            f"command (without --fresh) goes on, `{command} -o {output}` writes it as it is (for "
            "minutes)"
        )
    if size >= SLOW:
        told = f"{done:,} of its {size:,} points are done"
        progress.note(f"writing {output}: {told}; Ctrl-C now leaves it unwritten")
    write_dataset(journal, output)
    return ""


def _partial(journal: Journal) -> dict[str, object]:
    """What a dataset says of the points that it lacks; of one that is whole, nothing."""
    counts = count_statuses(journal)
    total, left = sum(counts.values()), counts[PENDING]
    so_far = " known so far, of a map that is being refined" * journal.grows
    return {"partial": f"{total - left} of {counted(total)}{so_far}"} if left else {}


def _assembled(journal: Journal, index: int) -> Dataset:
    """The dataset of one analysis, what its borders enclose filled in."""
    from fiv_cli.data.assemble import assemble
    from fiv_cli.data.refined import fill_in

    analysis, stage = journal.plan.analyses[index], journal.records[index].stage
    dataset = assemble(analysis.layout, partial(journal.stored, index), journal.folder)
    maps = analysis.maps
    if maps is None or stage is None:
        return dataset
    classes = stage.filled_classes(maps.fill)
    filled = fill_in(dataset, maps.refinement.of, classes, stage.origins())
    return replace(filled, attrs=maps.attributes(stage))


def refinements(journal: Journal) -> list[str]:
    """Of each refined analysis, in a line, how much of it was run."""
    return [
        f"{analysis.layout.name}: {analysis.maps.described(record.stage)}"
        for analysis, record in zip(journal.plan.analyses, journal.records, strict=True)
        if analysis.maps is not None and record.stage is not None
    ]


def counted_statuses(counts: Mapping[str, int], filled: int) -> list[str]:
    """``3 ok``, ``5 filled in``, of those that occur."""
    told = {**counts, NOT_COMPUTED: counts.get(NOT_COMPUTED, 0) - filled, "filled in": filled}
    return [f"{count} {status}" for status, count in told.items() if count]


def count_statuses(journal: Journal) -> dict[str, int]:
    """Status -> number of points, over all analyses, as far as is known what is to be run."""
    counts = dict.fromkeys(STATUS.codes, 0)
    for index in range(len(journal.records)):
        statuses = journal.statuses(index)
        for status, code in STATUS.codes.items():
            counts[status] += int(np.count_nonzero(statuses == code))
    return counts


def pending(journal: Journal) -> dict[str, int]:
    """Analysis -> points that are still to be run, as far as is known."""
    names = (analysis.layout.name for analysis in journal.plan.analyses)
    code, indices = STATUS.codes[PENDING], range(len(journal.records))
    left = (np.count_nonzero(journal.statuses(index) == code) for index in indices)
    return {name: int(count) for name, count in zip(names, left, strict=True)}


def reproduction(plan: Plan, analysis: AnalysisPlan, position: int) -> str:
    """The command that runs one point alone."""
    case = plan.case
    values, index = analysis.point(position)
    axes = [name for name, _ in analysis.template.axes]
    quoted = {name: _toml(value) for name, value in zip(axes, values, strict=True)}
    axes_set = {("grid", name) for name in quoted}
    kept = [line for line in case.overrides if parse_override(line).keys[:2] not in axes_set]
    kept += [f"grid.{_toml_key(name)}=[{value}]" for name, value in quoted.items()]
    settings = [f"--set {shlex.quote(line)}" for line in kept]
    entry = analysis.entry(index)
    start = "" if entry is None else f"   # initial: {entry.label}"
    files = [f"--with {origin.path}" for origin in analysis.template.own if origin.is_named]
    return " ".join(["fiv run", case.source, *files, *settings]) + start


@contextmanager
def _reported(scheduler: Scheduler, output: Path, begun: float) -> Iterator[None]:
    """Sum up and log on every path, also when the run is interrupted or fails."""
    journal, log, note = scheduler.journal, scheduler.log, scheduler.progress.note
    part = scheduler.policy.part
    where = f"-o {output}" if part is None else f"--shard {part}"
    command = f"{command_of(journal.plan.case)} {where}"
    log(f"fiv {fiv_cli.__version__}: {command}; {came(*journal.progress())}")
    for path, why in journal.ignored:
        log(f"ignored {path}: {why}")
    if journal.grows:
        note("a refined map: what is to be run grows as its borders are found")
    try:
        with ending.last_act(partial(_say_at_last, journal, scheduler.policy.fresh)):
            yield
    except BaseException as error:
        asked = isinstance(error, ending.Ended)
        why = str(error) if asked else f"stopped by {type(error).__name__}"
        log(f"{why} after {scheduler.ran} points")
        journal.ask()
        fresh = scheduler.policy.fresh
        for line in _summed_up(journal, output, scheduler.ran, begun, fresh).lines():
            note(line)
        if asked:
            raise ending.Ended(f"{why}: {_left_behind(scheduler, output)}") from error
        raise
    log(f"finished: {scheduler.ran} points run")


def _left_behind(scheduler: Scheduler, output: Path) -> str:
    """What there is of a run that was ended: a dataset of the points that are done."""
    journal = scheduler.journal
    if not journal.shards():
        before = f"{output} is that of a run before" if output.is_file() else "there is no dataset"
        return f"no point is done, and {before}; the same command begins again"
    if output == journal.folder:
        return f"{output} holds what is done of its part"
    try:
        unwritten = _written(journal, output, scheduler.progress)
    except StorageError as error:
        return f"{error}"
    if unwritten:
        return unwritten
    if _partial(journal):
        waiting = "; its workers had brought no point yet" * scheduler.awaits
        return f"{output} holds what is done, and is marked partial{waiting}"
    return f"{output} is whole"


def _say_at_last(journal: Journal, fresh: bool) -> None:
    """Of a run that is ended at once: what there is of it, on stderr."""
    done, total = journal.progress()
    same = f"the same command{WITHOUT * fresh}"
    told = f"{came(done, total)}, and stored; {same} goes on from here"
    if done == total and not journal.grows:
        told = f"every point is stored; {same} writes the dataset"
    elif not done:
        told = "no point is done; the same command begins again"
    os.write(2, f"{told}\n".encode())


def _claim(folder: Path, case: Case, fresh: bool) -> None:
    """Make the run directory this case's own, or refuse another's."""
    if not fresh:
        _refuse_another(folder, case)
    else:
        for part, own in part_folders(folder).items():
            _refuse_live(part, own)
        store.clear(folder)
        store.create(folder)
    store.write_identity(folder, document(case), _effective_text(case))


def _refuse_live(part: Part, folder: Path) -> None:
    process = holder(folder)
    if process is not None:
        raise LockedError(
            f"{folder}: process {process} is running part {part} of this case\n"
            "next: wait for it, or choose another output with -o FILE.nc"
        )


def _refuse_another(folder: Path, case: Case) -> None:
    """Refuse a run directory that holds results of another case."""
    stored = store.stored_identity(folder)
    differing = [] if stored is None else differences(stored, case)
    if differing:
        raise StoreMismatchError(
            "\n".join(
                [
                    f"{folder}: holds results of another case",
                    *(f"  {line}" for line in differing),
                    "next: keep both with -o FILE.nc (fiv plot and fiv diff take two), change it "
                    "back, or throw what is stored away with --fresh",
                ]
            )
        )


def _effective_text(case: Case) -> str:
    """The case as it is run: overrides first, as comments."""
    return "".join(f"# --set {line}\n" for line in case.overrides) + case.text


def _summed_up(
    journal: Journal, output: Path, ran: int, begun: float, fresh: bool = False
) -> Summary:
    return Summary(
        output=output,
        counts=count_statuses(journal),
        ran=ran,
        seconds=time.monotonic() - begun,
        fresh=fresh,
        answers=tuple(answers(journal)),
        errors=tuple(_errors(journal)),
        refined=tuple(refinements(journal)),
        ignored=tuple(journal.ignored),
    )


def _errors(journal: Journal) -> list[tuple[str, str]]:
    """The first distinct errors, with the command that runs each point alone."""
    found = []
    for index, analysis in enumerate(journal.plan.analyses):
        for position, what in journal.messages(index, SHOWN_ERRORS):
            found.append((what, reproduction(journal.plan, analysis, position)))
    return found[:SHOWN_ERRORS]


def _sweep_leftovers(folder: Path, output: Path) -> None:
    """Remove what a killed run left: heartbeats and half-written files."""
    patterns = (".beat-*", ".*.tmp", "shards/.*.tmp")
    own = [path for pattern in patterns for path in folder.glob(pattern)]
    for path in (*own, *leftovers(output)):
        with contextlib.suppress(OSError):  # what is no file, or another's, is no leftover
            path.unlink()


def _toml(value: object) -> str:
    return f'"{value}"' if isinstance(value, str) else repr(value)


def _toml_key(name: str) -> str:
    return f'"{name}"' if "." in name else name
