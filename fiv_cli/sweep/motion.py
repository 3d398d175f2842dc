"""The whole motion of one point of a sweep: planned and run as a case of its own."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from decimal import Decimal
from itertools import groupby
from math import ceil
from operator import itemgetter
from pathlib import Path
from shlex import quote
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from fiv_cli.analyses import get_analysis
from fiv_cli.analyses.base import Outcome
from fiv_cli.case.case import AnalysisSpec, Axis, Case, StartSpec
from fiv_cli.case.identity import MOTION, STEADY_STATE, default_output, fingerprint
from fiv_cli.data.assemble import assemble, axis_attributes
from fiv_cli.data.dataset import Dataset
from fiv_cli.data.layout import Dim, Layout
from fiv_cli.data.netcdf import global_attributes, write_datasets
from fiv_cli.data.provenance import provenance
from fiv_cli.errors import UsageError
from fiv_cli.flags import MOTION_OF_A_CYCLE, REASONS, STABLE, STATUS, advice
from fiv_cli.models import get_model
from fiv_cli.notation.units import convert
from fiv_cli.sweep.output import check_output
from fiv_cli.sweep.plan import AnalysisPlan, make_plan
from fiv_cli.sweep.policy import Policy
from fiv_cli.sweep.requests import StartEntry, Values, request_at
from fiv_cli.sweep.worker import ChainState, Result, Segment, Task, imported, run_task

if TYPE_CHECKING:
    import xarray as xr

NEAR = 1e-9
"""Relative distance within which a number names a value of an axis."""

LEAST_DIGITS = 3
"""Digits with which a rounded number, as `fiv show` prints it, names a value of an axis."""

MOST_NAMED = 12
"""Values of an axis that a message names."""

SAMPLES_A_PERIOD = 1000
WHOLE = 1e-9  # relative: so many samples are a whole number of them

NO_BRANCH = {"parameter": None, "bracket": None}


@dataclass(frozen=True)
class SteadyPart:
    """What is wanted of the steady state: how many of its periods (None: not counted), and whether
    the motion begins there."""

    periods: float | None
    settled: bool


@dataclass(frozen=True)
class Point:
    """One point of a sweep.

    Attributes
    ----------
    case : the case
    analysis : the analysis whose grid and starts are meant
    position : where it is in the dataset of `analysis`
    place : axis -> value, and ``initial`` -> label
    """

    case: Case
    analysis: AnalysisPlan
    position: int
    place: dict[str, Any]


def find_point(case: Case, at: Mapping[str, str]) -> Point:
    """The point of `case` that `at` names (axis -> value as written, ``initial`` -> label).

    Raises
    ------
    UsageError
        `at` is off the grid, names something else or leaves an axis open, or the point is not
        computed at all.
    """
    analysis = _with_starts(case)
    layout = analysis.layout
    dims = [*layout.dims, Dim((Axis("initial", "start", layout.labels or ()),))]
    names = [axis.name for dim in dims for axis in dim.axes]
    for name in at:
        if name not in names:
            raise UsageError(
                f"--at {name}: no axis of this case\nnext: choose from {', '.join(names)}"
            )
    written = _canonical(case, layout, at)
    indices = _indices(dims, written)
    values = [axis.values[i] for dim, i in zip(dims, indices, strict=True) for axis in dim.axes]
    _refuse_excluded(analysis, tuple(values[:-1]))
    position = int(np.ravel_multi_index(indices, layout.shape))
    return Point(case, analysis, position, dict(zip(names, values, strict=True)))


def motion_settings(t_end: float | str | None, sample: float | str | None) -> dict[str, float]:
    """Settings of ``history`` as they are given, with or without a unit; the others are left out.

    Raises
    ------
    UsageError
        one is no positive time.
    """
    given = {"t_end": t_end, "sample": sample}
    return {name: _seconds(name, value) for name, value in given.items() if value is not None}


def _seconds(name: str, value: float | str) -> float:
    option = f"--{name.replace('_', '-')}"
    number = _number(value)
    try:
        seconds = convert(value if number is None else number, "s")
    except ValueError as error:
        raise UsageError(
            f'{option} {value}: {error}\nnext: {option} 20 or {option} "2 min"'
        ) from error
    if not 0.0 < seconds < float("inf"):
        raise UsageError(f"{option} {value}: must be a positive time\nnext: {option} 20")
    return seconds


def steady_part(
    periods: float | None, settled: bool, t_end: float | str | None
) -> SteadyPart | None:
    """What is wanted of the steady state, if anything.

    Raises
    ------
    UsageError
        the number of periods is none, or the end is given twice.
    """
    if periods is not None and t_end is not None:
        raise UsageError("--periods, --t-end: both say where the motion ends\nnext: leave out one")
    if periods is not None and not 0.0 < periods < float("inf"):
        raise UsageError(f"--periods {periods:g}: must be a positive number\nnext: --periods 3")
    return SteadyPart(periods, settled) if settled or periods is not None else None


def write_motion(
    point: Point,
    settings: Mapping[str, float],
    path: Path,
    announce: Callable[[str], None],
    steady: SteadyPart | None = None,
) -> Outcome:
    """Run one point as `run_motion`, and write its motion to `path`.

    Raises
    ------
    UsageError, StorageError
        `path` cannot be written, or holds a whole sweep.
    """
    identity = fingerprint(point.case)
    check_output(path, None)
    stored = (global_attributes(path) or {}) if path.exists() else {}
    if stored and MOTION not in stored:
        raise UsageError(f"{path}: holds a sweep; it is left alone\nnext: -o ANOTHER.nc")
    dataset, outcome = run_motion(point, settings, announce, steady=steady)
    if stored:
        same = str(stored["fingerprint"]) == identity
        other = "" if same else " (another case, or this one before)"
        announce(f"{path}: the motion at {stored[MOTION]}{other} that it held is replaced")
    attributes = provenance(point.case, identity)
    place = [f"{name}={value}" for name, value in point.place.items()]
    settled = steady is not None and steady.settled
    attributes[MOTION] = ", ".join([*place, *["settled"] * settled])
    again = str(attributes["history"]).replace("fiv run", "fiv history", 1)
    attributes["history"] = f"{again} --at {quote(','.join(place))}{' --settled' * settled}"
    write_datasets(path, {"history": Dataset.of(dataset)}, attributes)
    return outcome


def run_motion(
    point: Point,
    settings: Mapping[str, float],
    announce: Callable[[str], None],
    policy: Policy | None = None,
    steady: SteadyPart | None = None,
) -> tuple[xr.Dataset, Outcome]:
    """Run one point as an analysis ``history``.

    Parameters
    ----------
    settings : of the analysis ``history``; what is left out keeps the case's or the default
    announce : told when something must be compiled
    policy : says what prepares and runs a point
    steady : what of the steady state is wanted; None: the motion from its start

    Returns
    -------
    an analysis ``history`` over dims of size one, and what the run came to, without its values

    Raises
    ------
    UsageError
        the branch that the point lies on ends before it; or no steady state is reached there, or
        one without a period.
    """
    run = _Run(point, announce, policy or Policy())
    reached = None if steady is None else run.steady_state()
    if reached and steady and steady.periods is not None:
        cycles = any(spec.kind == "cycle" for spec in point.case.analyses)
        settings = _over_periods(settings, reached, steady.periods, cycles)
    alone = run.plan("history", {**_settings(point.case), **settings})
    settled = reached if steady and steady.settled else None
    block = run.result(
        _continued(alone) if settled else alone, settled.state if settled else None
    ).block
    label = point.place["initial"]
    status = STATUS.names[int(block.status[0])]
    reason = REASONS[int(block.reason[0])].name
    if status == "not_reached":
        raise UsageError(
            f"--at: the branch {label!r} ends before this point\nnext: {advice(reason)}"
        )
    layout = replace(alone.layout, labels=(label,))
    dataset = assemble(layout, lambda: [(np.zeros(1, np.int64), block)])
    found = dataset.to_xarray()
    if settled:
        announce(f"steady state: {settled.what.replace('_', ' ')}")
        found.attrs[STEADY_STATE] = settled.what
    return found, Outcome(status, reason, message=block.messages.get(0, ""))


# --- which point ----------------------------------------------------------------------------------
def _with_starts(case: Case) -> AnalysisPlan:
    """The analysis whose points are run again: the first that has starts."""
    for analysis in make_plan(case).analyses:
        if analysis.layout.labels is not None:
            return analysis
    kinds = ", ".join(dict.fromkeys(spec.kind for spec in case.analyses))
    raise UsageError(
        f"{case.source}: nothing starts in this case ({kinds}), so there is no motion to show\n"
        "next: give it an [[analysis]] of kind response or history; or draw what it has: "
        f"fiv run {case.source}, then fiv plot {default_output(case)}"
    )


def _canonical(case: Case, layout: Layout, at: Mapping[str, str]) -> dict[str, str]:
    """`at` with numbers in SI, and each option that is a list (``[[0, 0]]``) as its text."""
    texts, axes = dict(at), [axis for dim in layout.dims for axis in dim.axes]
    for axis in [one for one in axes if one.name in at and _number(at[one.name]) is None]:
        with suppress(ValueError, KeyError):  # noted where the axis is searched; names have no unit
            unit = axis_attributes(axis, layout)["units"]
            texts[axis.name] = repr(convert(at[axis.name].strip("\"' "), unit))
    for option in get_model(case.model).options:
        if option.read is not None and option.name in texts:
            with suppress(ValueError):  # noted where the axis is searched
                text = texts[option.name]
                texts[option.name] = option.text(json.loads(text) if "[" in text else text)
    return texts


def _indices(dims: Sequence[Dim], at: Mapping[str, str]) -> list[int]:
    """Index along each dim; what is wrong along several is told at once."""
    indices, refused = [], []
    for dim in dims:
        try:
            indices.append(_index_along(dim, at))
        except UsageError as error:
            refused.append(str(error))
    if refused:
        raise UsageError("\n".join(refused))
    return indices


def _index_along(dim: Dim, at: Mapping[str, str]) -> int:
    """Index along a dim of the only place at which all that is given holds."""
    given = [axis for axis in dim.axes if axis.name in at]
    meant = [_meant(axis, at[axis.name]) for axis in given]
    fitting = [i for i in range(dim.size) if all(i in places for places in meant)]
    if len(fitting) == 1:
        return fitting[0]
    for axis, places in zip(given, meant, strict=True):
        if not places:
            raise _off_the_grid(axis, at[axis.name], [one.name for one in dim.axes if one != axis])
    names = ", ".join(axis.name for axis in dim.axes)
    if not fitting:
        raise UsageError(f"--at: no point fits along {names}\nnext: `fiv check` prints the axes")
    left = next((axis for axis in dim.axes if axis.name not in at), dim.axes[0])
    values = (f"--at {quote(f'{left.name}={left.values[i]}')}" for i in fitting[:MOST_NAMED])
    hint = " or ".join(dict.fromkeys(values))
    raise UsageError(f"--at: several points fit along {names}\nnext: {hint}")


def _meant(axis: Axis, text: str) -> set[int]:
    """The places along an axis that `text` names; where none agrees, those that it rounds."""
    same = {i for i, value in enumerate(axis.values) if _same(value, text)}
    return same or {i for i, value in enumerate(axis.values) if _is_rounded(value, text)}


def _is_rounded(value: Any, text: str) -> bool:
    """Whether `value` is written so when rounded to as many digits, and these are not too few."""
    number = _number(text)
    if isinstance(value, str) or number is None:
        return False
    digits = len(Decimal(text).as_tuple().digits)
    return digits >= LEAST_DIGITS and float(f"{value:.{digits - 1}e}") == number


def _same(value: Any, text: str) -> bool:
    if isinstance(value, str):
        return value == text.strip("\"' ")
    number = _number(text)
    return number is not None and abs(number - value) <= NEAR * max(abs(number), abs(value))


def _number(text: float | str) -> float | None:
    try:
        return float(text)
    except ValueError:
        return None


def _off_the_grid(axis: Axis, text: str, together: Sequence[str]) -> UsageError:
    """What there is, and how to have the value itself; axes `together` advance with this one."""
    number, first = _number(text), axis.values[:MOST_NAMED]
    if isinstance(first[0], str) or number is None:
        more = f" ... {axis.values[-1]}" * (len(axis.values) > MOST_NAMED)
        hint = f"choose from {', '.join(map(str, first))}{more}"
    else:
        nearest = min(axis.values, key=lambda value: abs(value - number))
        hint = f"the nearest is --at {axis.name}={nearest}"
        if axis.kind == "parameter":
            hint += f"; for {text} itself add --set 'grid.{axis.name}=[{text}]'"
            hint += "".join(f" --set 'grid.{name}=[VALUE]'" for name in together)
    return UsageError(f"--at {axis.name}={text}: off the grid\nnext: {hint}")


def _refuse_excluded(analysis: AnalysisPlan, values: Values) -> None:
    unmet = analysis.unmet(values)
    if unmet is not None:
        message = f"--at: this point is not computed: {unmet.reason}"
        raise UsageError(f"{message}\nnext: {advice(unmet.reason)}")


class _SteadyState(NamedTuple):
    """What a point reaches.

    Attributes
    ----------
    period : s; NaN: none
    state : how to go on
    what, reason : its class, and why that is no other
    """

    period: float
    state: ChainState
    what: str
    reason: str


# --- its motion -----------------------------------------------------------------------------------
@dataclass(frozen=True)
class _Run:
    """Runs analyses of one point alone."""

    point: Point
    announce: Callable[[str], None]
    policy: Policy

    def plan(self, kind: str, settings: Mapping[str, Any]) -> AnalysisPlan:
        """The only analysis of the case of this point alone."""
        case = self.point.case
        spec = AnalysisSpec(kind, kind, settings)
        axes = tuple(replace(axis, values=(self.point.place[axis.name],)) for axis in case.axes)
        bare = replace(case, axes=axes, analyses=(spec,), figures=(), claims=(), refinement=None)
        (alone,) = make_plan(bare).analyses
        return alone

    def result(self, alone: AnalysisPlan, state: ChainState | None = None) -> Result:
        """What the point comes to; from `state`, if one is given, else from its own start."""
        prepare = imported(self.policy.preparer)
        prepare(alone.systems(), self.announce)
        analysis = self.point.analysis
        own, start = analysis.point(self.point.position)
        values, _ = alone.point(start)
        before = _points_before(self.point, start) if state is None else []
        if before:
            prepare([request_at(analysis.template, values, None)], self.announce)
            state = _as_begun(before, own, start, analysis, self.policy.executor)
        return run_task(_task(alone, Segment((values,), start, state), self.policy.executor))

    def steady_state(self) -> _SteadyState:
        """What the point reaches.

        In a case that looks for cycles alone it is the one that is found, stable or not.
        """
        case = self.point.case
        if case.schedule.curves:
            raise UsageError(
                "--settled: a parameter varies in time\nnext: --t-end TIME, without it"
            )
        settings = {spec.kind: spec.settings for spec in reversed(case.analyses)}
        if "cycle" in settings and "response" not in settings:
            kind, named, other = "cycle", "cycle_period", NO_BRANCH
        else:
            kind, named, other = "response", "period", {}
        own = settings.get(kind, get_analysis(kind).default_settings)
        result = self.result(_continued(self.plan(kind, {**own, **other})))
        ((_, state),) = result.states.items()
        reason = REASONS[int(result.block.reason[0])].name
        if state.carry is None:
            raise UsageError(
                f"--settled: the point reaches no steady state ({reason})\nnext: {advice(reason)}"
            )
        period = result.block.values.get(named, np.full(1, np.nan))
        reached = str(state.carry["attractor"])
        if kind == "cycle":
            reached = f"{STABLE.names[int(result.block.values['stable'][0])]} cycle"
        return _SteadyState(float(period[0]), state, reached, reason)


def _continued(alone: AnalysisPlan) -> AnalysisPlan:
    """The same from starts that can be gone on from: each continues from itself, at first."""
    entries = tuple(
        entry
        if entry is None or entry.spec.kind == "continue"
        else StartEntry(entry.label, StartSpec(entry.label, "continue"), origin=entry)
        for entry in alone.template.entries
    )
    return replace(alone, template=replace(alone.template, entries=entries))


def _over_periods(
    settings: Mapping[str, float], found: _SteadyState, periods: float, cycles: bool
) -> Mapping[str, float]:
    """The settings of a history over so many periods of the steady state that is reached.

    Samples are as far apart as is asked for, or less, so that one is at the end: a spectrum of a
    record that is not whole has other lines.
    """
    if not np.isfinite(found.period):
        is_open = found.what == "undecided"
        why = f" ({found.reason}: {advice(found.reason)})" * is_open
        raise UsageError(
            f"--periods: the steady state has no period: its class is {found.what}{why}\n"
            f"next: --settled --t-end TIME, or another point{f'; {MOTION_OF_A_CYCLE}' * cycles}"
        )
    t_end = periods * found.period
    if "sample" not in settings:
        return {**settings, "sample": found.period / SAMPLES_A_PERIOD, "t_end": t_end}
    count = max(1, ceil(t_end / settings["sample"] * (1.0 - WHOLE)))
    return {**settings, "sample": t_end / count, "t_end": t_end}


def _settings(case: Case) -> dict[str, Any]:
    """Settings of ``history``: those that the case gives it, or the defaults."""
    settings = get_analysis("history").default_settings
    for spec in case.analyses:
        if spec.kind == "history":
            settings |= spec.settings
    if settings["t_end"] is None:
        settings["t_end"] = next(_ends(case), None)
    return settings


def _ends(case: Case) -> Iterator[float]:
    """How long the motions of a case last, s."""
    for spec in case.analyses:
        if spec.settings.get("t_end") is not None:
            yield spec.settings["t_end"]
    if case.schedule.curves:
        yield case.schedule.kinks[-1]
    yield from (s.settings["t_max"] for s in case.analyses if "t_max" in s.settings)


def _points_before(point: Point, start: int) -> list[tuple[Values, int]]:
    """The points, with their starts, that lead to this one; none where it starts on its own."""
    for chains in point.analysis.chain_sets():
        for chain in chains.positions if start in chains.entries else ():
            if point.position in chain:
                before = chain[: int(np.flatnonzero(chain == point.position)[0])]
                return list(point.analysis.points(before))
    return []


def _as_begun(
    before: Sequence[tuple[Values, int]],
    own: Values,
    start: int,
    analysis: AnalysisPlan,
    executor: str,
) -> ChainState | None:
    """What a point of a branch goes on from: the one before, or a step on the way from there."""
    state = _state_after(before, analysis, executor)
    again = run_task(_task(analysis, Segment((own,), start, state), executor)).states[0]
    return state if state is None or again.begun is None else replace(state, carry=again.begun)


def _state_after(
    points: Sequence[tuple[Values, int]], analysis: AnalysisPlan, executor: str
) -> ChainState | None:
    """What the last of these points of a branch leaves to the next."""
    state = None
    for start, leg in groupby(points, key=itemgetter(1)):
        segment = Segment(tuple(values for values, _ in leg), start, state)
        state = run_task(_task(analysis, segment, executor)).states[0]
    return state


def _task(analysis: AnalysisPlan, segment: Segment, executor: str) -> Task:
    return Task(analysis.template, analysis.layout.variables, (segment,), executor)
