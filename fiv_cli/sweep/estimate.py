"""What a run will cost, from a sample of its points: `fiv check --estimate`, and before a long run.

The sample is spread evenly over the grid and the starts, the same each time, and grows until it
tells the mean cost of a point or patience ends. Chains are a stratum for each start, sampled in
pieces; of maps that are refined some are drawn (``map_estimate.py``). The costs of points differ a
hundredfold, chaos being dear, so the range is that of the mean of the sample, symmetric in its
logarithm. What takes too long is given up: it counts at least as what it took until then, and at
most as all steps that it may make.
"""

from __future__ import annotations

import itertools
import os
import time
from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from math import ceil, exp, hypot, inf, prod, sqrt
from typing import NamedTuple, Protocol

import numpy as np

from fiv_cli.analyses import get_analysis
from fiv_cli.analyses.base import AT_ONCE
from fiv_cli.analyses.execute import prepare
from fiv_cli.case.case import Case
from fiv_cli.case.identity import default_output, differences
from fiv_cli.data.assemble import LARGE
from fiv_cli.data.log import run_folder
from fiv_cli.flags import advice
from fiv_cli.notation.amounts import HOUR, duration, size
from fiv_cli.sweep.journal import Journal, Record, stored_identity
from fiv_cli.sweep.map_estimate import Cost, Drawing
from fiv_cli.sweep.plan import (
    LARGE_BYTES,
    LARGE_POINT,
    AnalysisPlan,
    continues,
    counted,
    dim_of,
    make_plan,
    visiting_order,
)
from fiv_cli.sweep.policy import Policy
from fiv_cli.sweep.probe import PARTS, Probe, Tried, is_answered, part_of
from fiv_cli.sweep.refine import Maps
from fiv_cli.sweep.requests import StartEntry, Values
from fiv_cli.sweep.worker import Segment, Task, run_task

PATIENCE = 20.0  # s for the points of an analysis, after which no other is begun
PIECES = 8  # points that this leaves room for where each is given up
ENOUGH = 0.1  # relative standard error of the mean cost at which the sample is large enough
LEAST_POINTS, LEAST_UNITS = 200, 8  # ... if it holds so many (fewer rarely hold the dearest ones)
MOST = 20_000  # places that are spread evenly; those after them come in order
LINKS = 30  # points of a piece of a chain
TASK, BLOCK = 0.02, 1.0  # s that a task aims for, of points that are run alone and in blocks
OF_FIRST = 0.25  # share of the limit of a task after which the first point is given up
ROOM = 100  # times as dear as is known a point may be, without being given up and when it was
LOADING = 0.3  # s below which the first point is run again: it also loads code

# Before a run: s for all its analyses, also as a share of what it takes; least and most for a task.
GLANCE, WORTH, GLIMPSE = 3.0, 0.05, (0.25, 1.0)
STEPS = 1e9  # that a run may make for each place that is tried at least: half an hour's at most
# Of fewer, some points for a share of their time, by so many steps: what a run of all may take, s.
FEW, PART, FEW_STEPS, SHORT = 4, PARTS[0], 10_000, HOUR / 3.0

# Relative error that no sample removes: a core of a machine that others use is by half slower for
# minutes, and there is work besides the points.
OF_TIMING = 0.2
# Bytes of a run for each byte of results, and besides (measured on runs of 4 to a million points).
ON_DISK, OF_FILES = 2.3, 100e3  # shards and dataset
IN_MEMORY, OF_A_PROCESS, OF_THE_FIRST = 1.3, 200e6, 250e6  # the first knows eigenvalues, too
MERGING, MOST_MERGING = 1.7, 130e6  # shards that become one
BUSY = 1.3  # times as long as on free cores, from which on it is said
STARTING = 1.0  # s that a run takes besides its points


@dataclass(frozen=True)
class Estimate:
    """What one analysis will cost.

    Attributes
    ----------
    name : of the analysis
    points : to be run, least and most
    sampled, stored : points that were run for this, and that are stored and need not be run
    given_up, limit : those that were sampled and took more than so many s
    slowed : times as long as it takes while others run that ran before
    failed : reason -> how many of those sampled failed for it
    expected : s of the whole run, processor time over the workers
    seconds : ... least and most that is likely; the most may be infinite
    memory, disk : bytes
    """

    name: str
    points: tuple[int, int]
    sampled: int
    stored: int
    given_up: int
    limit: float
    expected: float
    seconds: tuple[float, float]
    memory: float
    disk: float
    workers: int
    slowed: float
    failed: Mapping[str, int]

    def failures(self) -> list[str]:
        """Why points of the sample failed, for people: those of the run will, too."""
        return [
            f"    of {counted(self.sampled)} {count} failed: {reason}: {advice(reason)}"
            for reason, count in self.failed.items()
        ]

    def line(self) -> str:
        """For people."""
        besides = f"; {counted(self.stored)} are stored" if self.stored else ""
        return (
            f"  estimate of {self.name}: {self.time_on_workers()}; "
            f"{size(self.memory)} of memory, "
            f"{size(self.disk)} on disk ({self.basis()}{besides})"
        )

    def time_on_workers(self) -> str:
        """How long it takes on free cores; longer while others are at work, which is said."""
        busy = f", {self.slowed:.1f} times that beside what runs here now"
        free = f"{self.time()} on {counted(self.workers, 'worker')}, cores being free"
        return free + busy * (self.slowed > BUSY)

    def time(self) -> str:
        """How long it takes: the range alone where points were given up."""
        low, high = self.seconds
        if high == inf:
            return f"at least {duration(low)}"
        span = f"{duration(low)} to {duration(high)}"
        return span if self.given_up else f"{duration(self.expected)} ({span})"

    def basis(self) -> str:
        """From how many points that is known."""
        some = f"from {self.sampled} of {_span(self.points)}"
        given_up = f", {self.given_up} given up after {duration(self.limit)} and taken as"
        return some + f"{given_up} up to all their time or steps" * bool(self.given_up)


class Crew(NamedTuple):
    """Who computes: so many workers, on so many cores, each with so many processes before."""

    workers: int
    cores: float
    load: float


class Unit(NamedTuple):
    """Points that are sampled together: some that start on their own, or a piece of a chain.

    Attributes
    ----------
    segments : the points
    lead : the point before a piece that does not begin its chain, run for its end alone
    """

    segments: tuple[Segment, ...]
    lead: Segment | None = None


@dataclass
class Stratum:
    """The points that start on their own, or the chains of one start.

    Attributes
    ----------
    points : how many are to be run
    left : units that were not run yet
    counts, seconds, most : of each unit that was, its points and what they took, least and most
    stored, given_up : bytes of the results, and points that took too long
    failed : why others failed
    is_exhausted : there are no more units
    """

    points: float
    left: Iterator[Unit]
    counts: list[int] = field(default_factory=list)
    seconds: list[float] = field(default_factory=list)
    most: list[float] = field(default_factory=list)
    stored: int = 0
    given_up: int = 0
    failed: Counter[str] = field(default_factory=Counter)
    is_exhausted: bool = False

    @property
    def share(self) -> float:
        """How much of it is sampled."""
        return inf if self.is_exhausted else sum(self.counts) / self.points

    @property
    def total(self) -> float:
        """What all its points take, s."""
        return self.points * sum(self.seconds) / max(1, sum(self.counts))

    @property
    def error(self) -> float:
        """Standard error of `total`, s: of a ratio, from units of a finite number of points."""
        many = len(self.counts)
        if many < 2 or self.is_exhausted:
            return 0.0 if self.is_exhausted else self.total
        if self.total == inf:
            return inf
        expected = np.multiply(self.counts, self.total / self.points)
        deviation = float(np.subtract(self.seconds, expected).std(ddof=1))
        return deviation * sqrt(many * max(0.0, 1.0 - self.share)) / self.share

    @property
    def dearest(self) -> Stratum:
        """The same, were what was given up to take the most that it may."""
        return replace(self, seconds=self.most)

    @property
    def is_told(self) -> bool:
        """Whether there are units enough to believe `error`."""
        return self.is_exhausted or len(self.counts) >= LEAST_UNITS


class Effort(NamedTuple):
    """What a sample may cost.

    Attributes
    ----------
    patience : s after which nothing more is begun
    limit : s after which a task is given up
    places : tasks that are tried at least, while patience lasts
    share : ... and of what all points take, as far as is known, after which no more is begun either
    """

    patience: float
    limit: float
    places: int = 1
    share: float = inf

    def until(self, total: float) -> float:
        """Seconds of the sample after which nothing more is begun."""
        return min(self.patience, self.share * total)

    def is_spent(self, seconds: float, tried: int, total: float) -> bool:
        """Whether nothing more is begun."""
        return seconds > (self.until(total) if tried >= self.places else self.patience)


class Try(Protocol):
    """Runs points for what they take; for a share of the limit at most."""

    def __call__(self, segments: tuple[Segment, ...], share: float = 1.0) -> Tried:
        """What they give and take."""


def estimate(case: Case, workers: int, announce: Callable[[str], None]) -> Iterator[Estimate]:
    """What is left of each analysis of a case will cost; stores nothing."""
    journal, effort = _stored(case), Effort(PATIENCE, PATIENCE / PIECES)
    crew = _crew(workers, os.cpu_count() or 1)
    for analysis, record in zip(journal.plan.analyses, journal.records, strict=True):
        if not (record.wanted() & ~record.done()).any():
            announce(f"every point of {analysis.layout.name} is stored: nothing is to be run")
            continue
        prepare(analysis.systems(), announce)
        announce(f"running a sample of the points of {analysis.layout.name}")
        left = int((record.wanted() & ~record.done()).sum())
        with Probe(effort.limit) as probe:
            run = partial(_tried, probe, analysis)
            found = _estimated(analysis, record, left, run, effort, crew)
        yield from found


def _crew(workers: int, cores: float) -> Crew:
    return Crew(workers, cores, os.getloadavg()[0] / cores)


def foreseen(journal: Journal, policy: Policy) -> list[Estimate]:
    """What a run that begins now will cost, from a glance at the analyses that may take long."""
    left = [
        _at_most_left(*part) for part in zip(journal.plan.analyses, journal.records, strict=True)
    ]
    limit = sum(left) if policy.max_points is None else policy.max_points
    left = np.diff(np.minimum(np.cumsum([0, *left]), limit)).tolist()
    crew = _crew(policy.workers, inf if policy.cluster else os.cpu_count() or 1)
    most_of_a_point = policy.time_limit or inf
    parts = list(zip(journal.plan.analyses, journal.records, left, strict=True))
    dear = [part for part in parts if _may_be_long(part[0], part[2], most_of_a_point, crew)]
    patience = GLANCE / max(1, len(dear))
    return [one for part in dear for one in _glanced_at(*part, patience, most_of_a_point, crew)]


def _at_most_left(analysis: AnalysisPlan, record: Record) -> int:
    """How many points may have to be run; of a map that is refined it is not known yet."""
    wanted = record.wanted() if analysis.maps is None else record.mine
    return int((wanted & ~record.done()).sum())


def _places(analysis: AnalysisPlan, left: int) -> int:
    """How many places are tried before a run that has so many points left; 1: none need be."""
    return max(1, min(PIECES, int(left * analysis.template.solver.max_steps / STEPS)))


def _may_be_long(analysis: AnalysisPlan, left: int, most_of_a_point: float, crew: Crew) -> bool:
    """Whether so many points may take so long that some are tried before."""
    share = left / _parallel(analysis, crew)
    if not left or share * most_of_a_point < SHORT:
        return False
    if _places(analysis, left) > 1 or not get_analysis(analysis.template.analysis).spans:
        return True
    starts = range(len(analysis.template.entries))
    some = list(itertools.islice(_single(analysis, starts), FEW))
    for first in some[:1]:
        _of_a_part(analysis, first)  # which loads code
    return share * max((_of_a_part(analysis, one) for one in some), default=0.0) > SHORT


def _of_a_part(analysis: AnalysisPlan, segment: Segment) -> float:
    """What a point takes if its motion takes all its time, s, from a part of it; inf: not told."""
    part = part_of(analysis.template, PART)
    part = replace(part, solver=replace(part.solver, max_steps=FEW_STEPS))
    result = run_task(Task(part, analysis.layout.variables, (segment,)))
    return result.seconds / PART if is_answered(result) else inf


def _glanced_at(
    analysis: AnalysisPlan,
    record: Record,
    left: int,
    patience: float,
    most_of_a_point: float,
    crew: Crew,
) -> list[Estimate]:
    """The estimate of an analysis from what a glance tells; few points are given all of it."""
    places, (least, most) = _places(analysis, left), GLIMPSE
    fair = max(HOUR * crew.workers / left, least)
    limit = min(fair, most if places > 1 else patience, most_of_a_point)
    effort = Effort(patience, limit, places, WORTH)
    guess = ROOM * limit if places == 1 else inf
    with Probe(limit, most_of_a_point, guess) as probe:
        run = partial(_tried, probe, analysis)
        return _estimated(analysis, record, left, run, effort, crew)


def _stored(case: Case) -> Journal:
    """What runs of a case have stored where its dataset goes."""
    folder = run_folder(default_output(case))
    journal, identity = Journal(folder, make_plan(case)), stored_identity(folder)
    if identity is not None and not differences(identity, case):
        journal.load()
    return journal


class Sample(NamedTuple):
    """What some points of an analysis say of all of them.

    Attributes
    ----------
    run, given_up : how many points, and how many of them took too long
    stored : bytes of the results
    cost : of all points, on one core
    errors : standard errors of its least and its most time, over these
    failed : why points failed, and how many
    """

    run: int
    given_up: int
    stored: int
    cost: Cost
    errors: tuple[float, float]
    failed: Counter[str]


def _of_strata(strata: Sequence[Stratum], points: int, left: float) -> Sample:
    """Of so many points, of which a share is left."""
    both = strata, [stratum.dearest for stratum in strata]
    low, high = (left * sum(stratum.total for stratum in some) for some in both)
    least, most = (_relative_error(some) for some in both)
    return Sample(
        run=sum(sum(stratum.counts) for stratum in strata),
        given_up=sum(stratum.given_up for stratum in strata),
        stored=sum(stratum.stored for stratum in strata),
        cost=Cost((left * points, left * points), (low, high)),
        errors=(least, most),
        failed=sum((stratum.failed for stratum in strata), Counter[str]()),
    )


def _of_maps(
    analysis: AnalysisPlan, maps: Maps, record: Record, run: Try, effort: Effort
) -> Sample:
    """From as many maps as can be drawn while patience lasts, from one at least."""
    begun, first = time.monotonic(), _seconds_of_first(analysis, run)
    at_once = _fitting(effort.limit / ROOM, first, AT_ONCE)
    patience = effort.until(first * analysis.size)
    drawings: list[Drawing] = []
    for (place,) in _spread([len(maps.numbers)]):
        numbers = maps.numbers[place]
        classes, known = record.told_classes()[numbers], record.done()[numbers]
        drawing = Drawing(maps, numbers, classes, known, partial(_at, analysis, run), at_once)
        drawing.until(begun + patience * (len(drawings) + 1))
        drawings.append(drawing)
        if (time.monotonic() - begun) * (1.0 + 1.0 / len(drawings)) > patience:
            break
    costs, many = [drawing.cost() for drawing in drawings], len(maps.numbers)
    cost = Cost(*(tuple(np.mean(pairs, axis=0) * many) for pairs in zip(*costs, strict=True)))
    if analysis.chain_sets():  # run whole where any map asks for a point of them
        most = analysis.size / cost.points[1]
        cost = Cost(*((least, high * most) for least, high in cost))
    seconds = [high for _, (_, high) in costs]
    several = len(costs) > 1 and 0.0 < cost.seconds[1] < inf  # of what is stored none costs any
    apart = float(np.std(seconds, ddof=1) / np.mean(seconds)) if several else 1.0
    error = apart * sqrt((1.0 - len(costs) / many) / len(costs))
    tried = sum(int(drawing.was_run.sum()) for drawing in drawings)
    given_up = sum(drawing.given_up for drawing in drawings)
    stored = sum(drawing.stored for drawing in drawings)
    failed = sum((drawing.failed for drawing in drawings), Counter[str]())
    return Sample(tried, given_up, stored, cost, (error, error), failed)


def _at(analysis: AnalysisPlan, run: Try, positions: Sequence[int]) -> Tried:
    """What the points at some positions give and take."""
    shape, dims = analysis.layout.shape, len(analysis.layout.dims)
    places = [[int(i) for i in np.unravel_index(number, shape)] for number in positions]
    return run(
        tuple(
            Segment((_values(analysis, place[:dims]),), place[-1] if len(place) > dims else 0)
            for place in places
        )
    )


def _estimated(
    analysis: AnalysisPlan, record: Record, left: int, run: Try, effort: Effort, crew: Crew
) -> list[Estimate]:
    """What the points left of one analysis will cost; nothing where none of it can be run."""
    if analysis.maps is not None:
        sample = _of_maps(analysis, analysis.maps, record, run, effort)
    else:
        strata = _sampled(analysis, run, effort)
        sample = _of_strata(strata, _points(analysis), left / analysis.size)
    stored = int(np.count_nonzero(record.done() & record.wanted()))
    return [_told(analysis, sample, stored, crew, effort.limit)] if sample.run else []


def _told(
    analysis: AnalysisPlan, sample: Sample, stored: int, crew: Crew, limit: float
) -> Estimate:
    workers, at_once = crew.workers, _parallel(analysis, crew)
    spreads = [exp(2.0 * hypot(error, OF_TIMING)) for error in sample.errors]
    low, high = (STARTING + seconds / at_once for seconds in sample.cost.seconds)
    low, high = low / spreads[0], high * spreads[1]
    of_a_point, points = sample.stored / sample.run, stored + sample.cost.points[1]
    processes = workers * (workers > 1 and high * at_once > Policy().in_process_below)
    return Estimate(
        name=analysis.layout.name,
        points=(ceil(sample.cost.points[0]), ceil(sample.cost.points[1])),
        sampled=sample.run,
        stored=stored,
        given_up=sample.given_up,
        limit=limit,
        expected=sqrt(low * high),
        seconds=(low, high),
        memory=OF_A_PROCESS * processes + _of_dataset(analysis, of_a_point),
        disk=OF_FILES + ON_DISK * of_a_point * points,
        workers=workers,
        slowed=max(1.0, crew.load + min(workers / crew.cores, 1.0)),
        failed=dict(sample.failed),
    )


def _of_dataset(analysis: AnalysisPlan, of_a_point: float) -> float:
    """Bytes of memory of the process that assembles the dataset; a large one lies in files."""
    results = of_a_point * analysis.size
    whole = OF_THE_FIRST + IN_MEMORY * results + min(MERGING * results, MOST_MERGING)
    in_files = 8 * analysis.size * len(analysis.layout.variables) > LARGE
    return min(whole, LARGE_BYTES + LARGE_POINT * analysis.size) if in_files else whole


def _relative_error(strata: Sequence[Stratum]) -> float:
    """Standard error of what all points take, over it."""
    total = sum(stratum.total for stratum in strata)
    return hypot(*(stratum.error for stratum in strata)) / total if 0.0 < total < inf else inf


def _points(analysis: AnalysisPlan) -> int:
    """How many points are run."""
    return analysis.size - sum(analysis.excluded().values())


def _parallel(analysis: AnalysisPlan, crew: Crew) -> float:
    """How many points are run at once: of a chain one after the other."""
    entries = analysis.template.entries
    chained = [entry for entry in entries if entry is not None and continues(entry)]
    most = min(crew.workers, crew.cores, max(1, _points(analysis)))
    if len(chained) < len(entries):
        return most
    return min(most, analysis.size / max(c.positions.shape[1] for c in analysis.chain_sets()))


def _sampled(analysis: AnalysisPlan, run: Try, effort: Effort) -> list[Stratum]:
    """The strata of an analysis, with what a sample of their points takes."""
    begun = time.monotonic()
    strata = _strata(analysis, _seconds_of_first(analysis, run), effort)
    while not _is_enough(strata):
        stratum = min(strata, key=lambda stratum: stratum.share)
        tried, total = sum(len(one.counts) for one in strata), sum(one.total for one in strata)
        if stratum.counts and effort.is_spent(time.monotonic() - begun, tried, total):
            break
        unit = next(stratum.left, None)
        stratum.is_exhausted = unit is None
        if unit is not None:
            _run(analysis, unit, stratum, run)
    return strata


def _is_enough(strata: Sequence[Stratum]) -> bool:
    if all(stratum.is_exhausted for stratum in strata):
        return True
    many = sum(sum(stratum.counts) for stratum in strata) >= LEAST_POINTS
    told = all(stratum.is_told for stratum in strata)
    return many and told and _relative_error(strata) < ENOUGH


def _seconds_of_first(analysis: AnalysisPlan, run: Try) -> float:
    """What one point takes, which is not kept: the first may load code."""
    starts = range(len(analysis.template.entries))
    segment = next(_single(analysis, starts), None)
    if segment is None:
        return 0.0
    first = run((segment,), OF_FIRST)
    is_told = first.result is None or first.least > LOADING
    return first.least if is_told else run((segment,), OF_FIRST).least


def _run(analysis: AnalysisPlan, unit: Unit, stratum: Stratum, run: Try) -> None:
    """Run a unit and note what it takes; where the point before it is given up, that point.

    Several points that are given up together may each be cheap: the first of them tells.
    """
    segments = unit.segments
    if unit.lead is not None:
        ended = run((unit.lead,))
        if ended.result is None:
            _note(analysis, (unit.lead,), ended, stratum)
            return
        segments = (replace(segments[0], state=ended.result.states[0]),)
    found = run(segments)
    if found.result is None and len(segments) > 1:
        segments = segments[:1]
        found = run(segments)
    _note(analysis, segments, found, stratum)


def _note(
    analysis: AnalysisPlan, segments: Sequence[Segment], found: Tried, stratum: Stratum
) -> None:
    points = (values for segment in segments for values in segment.values)
    stratum.counts.append(sum(analysis.unmet(values) is None for values in points))
    stratum.seconds.append(found.least)
    stratum.most.append(found.most)
    stratum.given_up += stratum.counts[-1] * (found.result is None)
    stratum.stored += found.nbytes
    if found.result is not None:
        stratum.failed += found.result.failures()


def _tried(
    probe: Probe, analysis: AnalysisPlan, segments: tuple[Segment, ...], share: float = 1.0
) -> Tried:
    """What points give and take."""
    return probe.run(Task(analysis.template, analysis.layout.variables, segments), share)


def _strata(analysis: AnalysisPlan, seconds: float, effort: Effort) -> list[Stratum]:
    """All points, where one takes some `seconds`."""
    entries = analysis.template.entries
    of_a_start = _points(analysis) / len(entries)
    if not of_a_start:
        return []
    alone = [index for index, entry in enumerate(entries) if not continues(entry)]
    aimed_for = BLOCK if analysis.template.linear else min(TASK, effort.limit / ROOM)
    at_once = _fitting(min(aimed_for, effort.limit / 4.0), seconds, AT_ONCE)
    links = _fitting(effort.limit / 2.0, seconds, LINKS)
    strata = [Stratum(of_a_start * len(alone), _units(_single(analysis, alone), at_once))]
    strata += [
        Stratum(of_a_start, _pieces(analysis, index, entry, links))
        for index, entry in enumerate(entries)
        if entry is not None and continues(entry)
    ]
    return strata if alone else strata[1:]


def _fitting(aimed_for: float, seconds: float, most: int) -> int:
    """How many points of some `seconds` take what is aimed for."""
    return max(1, min(most, int(aimed_for / max(seconds, 1e-6))))


def _units(segments: Iterator[Segment], at_once: int) -> Iterator[Unit]:
    while together := tuple(itertools.islice(segments, at_once)):
        yield Unit(together)


def _single(analysis: AnalysisPlan, starts: Sequence[int]) -> Iterator[Segment]:
    """Points that are computed, each by itself."""
    for *places, start in _spread([*(dim.size for dim in analysis.layout.dims), len(starts)]):
        values = _values(analysis, places)
        if analysis.unmet(values) is None:
            yield Segment((values,), starts[start])


def _pieces(analysis: AnalysisPlan, index: int, entry: StartEntry, links: int) -> Iterator[Unit]:
    """Pieces of the chains of a start."""
    dims = analysis.layout.dims
    dim = dim_of(dims, entry.spec.along)
    order = visiting_order(dims[dim], entry)
    sizes = [one.size for one in dims]
    sizes[dim] = ceil(len(order) / links)
    for places in _spread(sizes):
        along = range(places[dim] * links, min((places[dim] + 1) * links, len(order)))
        points = [[*places[:dim], order[link], *places[dim + 1 :]] for link in along]
        segment = Segment(tuple(_values(analysis, point) for point in points), index)
        if not along.start:
            yield Unit((segment,))
            continue
        before = [*places[:dim], order[along.start - 1], *places[dim + 1 :]]
        yield Unit((segment,), Segment((_values(analysis, before),), index))


def _values(analysis: AnalysisPlan, places: Sequence[int]) -> Values:
    found = {
        axis.name: axis.values[place]
        for dim, place in zip(analysis.layout.dims, places, strict=True)
        for axis in dim.axes
    }
    return tuple(found[name] for name, _ in analysis.template.axes)


def _spread(sizes: Sequence[int]) -> Iterator[list[int]]:
    """All places, the first many of which are spread evenly (multiples of irrational steps)."""
    ratio = float(max(np.roots([1.0, *[0.0] * (len(sizes) - 1), -1.0, -1.0]).real))
    steps = ratio ** -np.arange(1.0, len(sizes) + 1.0)
    drawn = ((0.5 + np.outer(np.arange(MOST), steps)) % 1.0 * sizes).astype(np.int64)
    numbers: list[int] = np.ravel_multi_index(tuple(drawn.T), sizes).tolist()
    seen = set()
    for number in itertools.chain(numbers, range(prod(sizes))):
        if number not in seen:
            seen.add(number)
            yield [int(place) for place in np.unravel_index(number, sizes)]


def _span(points: tuple[int, int]) -> str:
    low, high = points
    return counted(high) if low == high else f"{low} to {counted(high)}"
