"""What a run will cost, from a few of its points: `fiv check --estimate`.

Run are corners of the grid, its middle and points by chance (seeded), the starts an axis like any
other; of a chain its first points. What they take says what the others will, as far as these are
like them.
"""

from __future__ import annotations

import itertools
import os
import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from math import prod, sqrt

import numpy as np

from fiv_cli.analyses.base import AT_ONCE
from fiv_cli.analyses.execute import prepare
from fiv_cli.case.case import Case
from fiv_cli.notation.amounts import duration, size
from fiv_cli.sweep.plan import AnalysisPlan, counted, dim_of, make_plan, visiting_order
from fiv_cli.sweep.policy import Policy
from fiv_cli.sweep.requests import StartEntry, Values
from fiv_cli.sweep.worker import Result, Segment, Task, run_task

SAMPLES = 12  # points of an analysis that are run; of one that is computed in blocks, a block
MOST_CORNERS = 4
LINKS = 3  # points at the beginning of a chain
PATIENCE = 20.0  # s for the points of an analysis, after which no other is begun
LOADING = 1.0  # s below which the first point is run again: it also loads code

# Bytes of a run for each byte of results, and besides (measured on runs of 4 to 5,000 points).
ON_DISK, OF_FILES = 2.3, 100e3  # shards and dataset
IN_MEMORY, OF_A_PROCESS = 1.3, 200e6
STARTING = 1.0  # s that a run takes besides its points


@dataclass(frozen=True)
class Estimate:
    """What one analysis will cost.

    Attributes
    ----------
    name : of the analysis
    points : to be run, least and most
    sampled : points that were run for this
    seconds : of the whole run on `workers`, least and most that is likely
    memory, disk : bytes
    """

    name: str
    points: tuple[int, int]
    sampled: int
    seconds: tuple[float, float]
    memory: float
    disk: float
    workers: int

    def line(self) -> str:
        """For people."""
        low, high = map(duration, self.seconds)
        span = low if low == high else f"{low} to {high}"
        return (
            f"  estimate of {self.name}: {span} on {counted(self.workers, 'worker')}, "
            f"{size(self.memory)} of memory, {size(self.disk)} on disk "
            f"(from {counted(self.sampled)} of {_span(self.points)})"
        )


def estimate(case: Case, workers: int, announce: Callable[[str], None]) -> Iterator[Estimate]:
    """What each analysis of a case will cost, run from nothing; stores nothing."""
    for analysis in make_plan(case).analyses:
        prepare(analysis.systems(), announce)
        announce(f"running a few points of {analysis.layout.name}")
        results = _results(analysis)
        if results:
            yield _estimated(analysis, results, workers)


def _estimated(analysis: AnalysisPlan, results: Sequence[Result], workers: int) -> Estimate:
    sampled = sum(len(result.block) for result in results)
    bytes_per_point = sum(result.block.nbytes for result in results) / sampled
    points, at_once = _points(analysis), _parallel(analysis, workers)
    low, high = _of_a_point([result.seconds / len(result.block) for result in results])
    span = STARTING + low * points[0] / at_once, STARTING + high * points[1] / at_once
    processes = 1 + workers * (workers > 1 and span[1] > Policy().in_process_below)
    stored = bytes_per_point * analysis.size
    return Estimate(
        name=analysis.layout.name,
        points=points,
        sampled=sampled,
        seconds=span,
        memory=OF_A_PROCESS * processes + IN_MEMORY * stored,
        disk=OF_FILES + ON_DISK * stored,
        workers=workers,
    )


def _of_a_point(costs: Sequence[float]) -> tuple[float, float]:
    """What a point takes in the mean, s: two standard errors to either side, of one cost a half."""
    usual, error = float(np.mean(costs)), 2.0 * float(np.std(costs)) / sqrt(len(costs))
    error = error if len(costs) > 1 else 0.5 * usual
    return max(usual - error, min(0.5 * usual, *costs)), usual + error


def _points(analysis: AnalysisPlan) -> tuple[int, int]:
    """How many points are run, least and most."""
    most = analysis.size - sum(analysis.excluded().values())
    if analysis.maps is None:
        return most, most
    return min(most, len(analysis.maps.numbers) * prod(analysis.maps.coarse.values())), most


def _parallel(analysis: AnalysisPlan, workers: int) -> float:
    """How many points are run at once: of a chain one after the other."""
    entries = analysis.template.entries
    chained = [entry for entry in entries if entry is not None and entry.spec.kind == "continue"]
    most = min(workers, os.cpu_count() or 1)
    if len(chained) < len(entries):
        return most
    return min(most, analysis.size / max(c.positions.shape[1] for c in analysis.chain_sets()))


def _results(analysis: AnalysisPlan) -> list[Result]:
    """What a few points give and take."""
    segments = list(itertools.islice(_segments(analysis), SAMPLES))
    if not segments:
        return []
    if analysis.template.linear:
        segments = [segments[i % len(segments)] for i in range(min(AT_ONCE, analysis.size))]
        task = _task(analysis, segments)
        run_task(task)  # loads code
        return [run_task(task)]
    begun, results = time.monotonic(), []
    first = run_task(_task(analysis, segments[:1]))
    if first.seconds > LOADING:
        results.append(first)
    for segment in segments[len(results) :]:
        if results and time.monotonic() - begun > PATIENCE:
            break
        results.append(run_task(_task(analysis, [segment])))
    return results


def _task(analysis: AnalysisPlan, segments: Sequence[Segment]) -> Task:
    return Task(analysis.template, analysis.layout.variables, tuple(segments))


def _segments(analysis: AnalysisPlan) -> Iterator[Segment]:
    """Points that are computed, from starts likewise; of a chain its beginning."""
    entries = analysis.template.entries
    sizes = [dim.size for dim in analysis.layout.dims]
    for *places, index in _places([*sizes, len(entries)]):
        followed = _followed(analysis, places, entries[index])
        values = tuple(_values(analysis, along) for along in followed)
        if analysis.unmet(values[0]) is None:
            yield Segment(values, index)


def _followed(
    analysis: AnalysisPlan, places: list[int], entry: StartEntry | None
) -> list[list[int]]:
    """The place itself, or the first places of the chain that leads through it."""
    if entry is None or entry.spec.kind != "continue":
        return [places]
    dim = dim_of(analysis.layout.dims, entry.spec.along)
    begin = visiting_order(analysis.layout.dims[dim], entry)[:LINKS]
    return [[*places[:dim], place, *places[dim + 1 :]] for place in begin]


def _values(analysis: AnalysisPlan, places: Sequence[int]) -> Values:
    found = {
        axis.name: axis.values[place]
        for dim, place in zip(analysis.layout.dims, places, strict=True)
        for axis in dim.axes
    }
    return tuple(found[name] for name, _ in analysis.template.axes)


def _places(sizes: Sequence[int]) -> list[tuple[int, ...]]:
    """Corners, the middle and places by chance: more than are needed, some may not be computed."""
    random = np.random.default_rng(0)
    corners = list(itertools.product(*((0, size - 1) for size in sizes[:8])))
    rest = tuple(size // 2 for size in sizes[8:])
    chosen = random.permutation(len(corners))[:MOST_CORNERS]
    places = [(*corners[i], *rest) for i in chosen] + [tuple(size // 2 for size in sizes)]
    count = min(4 * SAMPLES, prod(sizes)) - len(places)
    places += [tuple(random.integers(sizes).tolist()) for _ in range(count)]
    return list(dict.fromkeys(places))


def _span(points: tuple[int, int]) -> str:
    low, high = points
    return counted(high) if low == high else f"{low} to {counted(high)}"
