"""One point of a sweep again, with its full motion."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator, Mapping
from contextlib import suppress
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import xarray as xr

from fiv_cli.analyses import get_analysis
from fiv_cli.analyses.base import Outcome, Start
from fiv_cli.analyses.execute import Request, execute, prepare
from fiv_cli.case.case import Axis, Case
from fiv_cli.data.assemble import assemble
from fiv_cli.data.block import pack
from fiv_cli.data.layout import Dim, Layout
from fiv_cli.errors import UsageError
from fiv_cli.flags import advice
from fiv_cli.models import get_model
from fiv_cli.sweep.plan import AnalysisPlan, make_plan
from fiv_cli.sweep.points import (
    StartEntry,
    Values,
    continued_start,
    exclusion,
    point_key,
    request_at,
    resolve_start,
)
from fiv_cli.sweep.worker import Segment, Task, run_task

NEAR = 1e-9
"""Relative distance within which a number names a value of an axis."""


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
        `at` is off the grid or names something else, or the point is not computed at all.
    """
    analysis = _with_starts(case)
    position, place = locate(analysis, _canonical(case, at))
    _refuse_excluded(analysis, analysis.point(position)[0])
    return Point(case, analysis, position, place)


def run_again(
    point: Point, settings: Mapping[str, float], announce: Callable[[str], None]
) -> tuple[xr.Dataset, Outcome]:
    """Run one point as an analysis ``history``.

    Parameters
    ----------
    settings : of the analysis ``history``; what is left out keeps the case's or the default
    announce : told when something must be compiled

    Returns
    -------
    an analysis ``history`` over dims of size one, and what the run came to
    """
    analysis = point.analysis
    values, index = analysis.point(point.position)
    full = _settings(point.case, settings)
    start = _start(analysis, point.position, values, analysis.entry(index), announce)
    request = _as_history(request_at(analysis.template, values, start), full)
    prepare([request], announce)
    outcome = execute(request)
    return _dataset(analysis, point.position, full, outcome), outcome


def locate(analysis: AnalysisPlan, at: Mapping[str, str]) -> tuple[int, dict[str, Any]]:
    """Position of the point that `at` names, and its coordinates.

    Raises
    ------
    UsageError
        an unknown name, a value that is none of the axis, or an axis left open.
    """
    layout = analysis.layout
    names = [axis.name for dim in layout.dims for axis in dim.axes]
    known = [*names, *(["initial"] if layout.labels is not None else [])]
    for name in at:
        if name not in known:
            raise UsageError(
                f"--at {name}: no axis of this case\nnext: choose from {', '.join(known)}"
            )
    indices = [_index_along(dim, at) for dim in layout.dims]
    if layout.labels is not None:
        indices.append(_pick("initial", layout.labels, at.get("initial")))
    position = int(np.ravel_multi_index(indices, layout.shape)) if indices else 0
    return position, _place(analysis, position)


def _place(analysis: AnalysisPlan, position: int) -> dict[str, Any]:
    values, index = analysis.point(position)
    names = [name for name, _ in analysis.template.axes]
    place: dict[str, Any] = dict(zip(names, values, strict=True))
    entry = analysis.entry(index)
    return place if entry is None else {**place, "initial": entry.label}


def _canonical(case: Case, at: Mapping[str, str]) -> dict[str, str]:
    """`at` with each option that is a list (``[[0, 0]]``) as the text that stands for it."""
    texts = dict(at)
    for option in get_model(case.model).options:
        if option.read is not None and option.name in texts:
            with suppress(ValueError):  # noted where the axis is searched
                text = texts[option.name]
                texts[option.name] = option.text(json.loads(text) if "[" in text else text)
    return texts


def _with_starts(case: Case) -> AnalysisPlan:
    """The analysis whose points are run again: the first that has starts."""
    for analysis in make_plan(case).analyses:
        if analysis.layout.labels is not None:
            return analysis
    raise UsageError(
        f"{case.source}: no analysis of this case has starts, so there is no motion to show\n"
        "next: give it an [[analysis]] of kind response or history"
    )


def _index_along(dim: Dim, at: Mapping[str, str]) -> int:
    """Index along a dim; zipped axes must agree."""
    if len(dim.axes) > 1:
        return _index_of_tuple(dim, at)
    axis = dim.axes[0]
    return _pick(axis.name, axis.values, at.get(axis.name))


def _index_of_tuple(dim: Dim, at: Mapping[str, str]) -> int:
    """Index along zipped axes: where all that is given holds."""
    fitting = [
        i
        for i in range(dim.size)
        if all(_same(axis.values[i], at[axis.name]) for axis in dim.axes if axis.name in at)
    ]
    if len(fitting) == 1:
        return fitting[0]
    names = ", ".join(axis.name for axis in dim.axes)
    what = "several points fit" if fitting else "no point fits"
    raise UsageError(f"--at: {what} along {names}\nnext: `fiv check` prints the axes")


def _pick(name: str, values: tuple[Any, ...], text: str | None) -> int:
    if text is None and len(values) == 1:
        return 0
    if text is None:
        raise UsageError(f"--at: {name} is left open\nnext: --at {name}={values[0]}")
    fitting = [i for i, value in enumerate(values) if _same(value, text)]
    if not fitting:
        raise UsageError(f"--at {name}={text}: off the grid\nnext: {_nearest(name, values, text)}")
    return fitting[0]


def _same(value: Any, text: str) -> bool:
    if isinstance(value, str):
        return value == text.strip("\"' ")
    number = _number(text)
    return number is not None and abs(number - value) <= NEAR * max(abs(number), abs(value))


def _number(text: str) -> float | None:
    try:
        return float(text)
    except ValueError:
        return None


def _nearest(name: str, values: tuple[Any, ...], text: str) -> str:
    number = _number(text)
    if isinstance(values[0], str) or number is None:
        return f"choose from {', '.join(map(str, values[:12]))}"
    return f"the nearest is --at {name}={min(values, key=lambda value: abs(value - number))}"


def _refuse_excluded(analysis: AnalysisPlan, values: Values) -> None:
    unmet = exclusion(analysis.template, values)
    if unmet is not None:
        message = f"--at: this point is not computed: {unmet.reason}"
        raise UsageError(f"{message}\nnext: {advice(unmet.reason)}")


def _settings(case: Case, given: Mapping[str, float]) -> dict[str, Any]:
    """Settings of ``history``: given here, or by the case, or the default."""
    settings = {setting.name: setting.default for setting in get_analysis("history").settings}
    for spec in case.analyses:
        if spec.kind == "history":
            settings |= dict(spec.settings)
    if settings["t_end"] is None:
        settings["t_end"] = next(_ends(case), None)
    return {**settings, **given}


def _ends(case: Case) -> Iterator[float]:
    """How long the motions of a case last, s."""
    for spec in case.analyses:
        if spec.settings.get("t_end") is not None:
            yield spec.settings["t_end"]
    if case.schedule.curves:
        yield case.schedule.kinks[-1]
    yield from (s.settings["t_max"] for s in case.analyses if "t_max" in s.settings)


def _as_history(request: Request, settings: Mapping[str, Any]) -> Request:
    return replace(request, analysis="history", settings=settings)


def _start(
    analysis: AnalysisPlan,
    position: int,
    values: Values,
    entry: StartEntry | None,
    announce: Callable[[str], None],
) -> Start | None:
    if entry is None:
        return None
    if entry.spec.kind != "continue":
        return resolve_start(analysis.template, values, entry)
    prepare([request_at(analysis.template, values, None)], announce)
    return _start_on_branch(analysis, position, values, entry)


def _start_on_branch(
    analysis: AnalysisPlan, position: int, values: Values, entry: StartEntry
) -> Start:
    """Follow the branch up to the point before this one."""
    chain = next(
        chain for chains in analysis.chain_sets() for chain in chains.positions if position in chain
    )
    before = chain[: int(np.flatnonzero(chain == position)[0])]
    if not len(before):
        return resolve_start(analysis.template, values, entry)
    points = tuple(analysis.point(int(p))[0] for p in before)
    index = analysis.template.entries.index(entry)
    segment = Segment(points, index)
    state = run_task(Task(analysis.template, analysis.layout.variables, (segment,))).states[0]
    if state.carry is not None and not state.lost:
        return continued_start(entry, state.carry)
    if entry.spec.on_loss == "restart":
        return resolve_start(analysis.template, values, entry)
    raise UsageError(
        f"--at: the branch {entry.label!r} ends before this point\nnext: {advice('class_changed')}"
    )


def _dataset(
    analysis: AnalysisPlan, position: int, settings: Mapping[str, Any], outcome: Outcome
) -> xr.Dataset:
    layout = analysis.layout
    values, index = analysis.point(position)
    by_name = dict(zip([name for name, _ in analysis.template.axes], values, strict=True))
    single = Layout(
        name="history",
        kind="history",
        model=layout.model,
        options=layout.options,
        settings=settings,
        dims=tuple(_single(dim, by_name) for dim in layout.dims),
        labels=None if layout.labels is None else (layout.labels[index],),
        varying=layout.varying,
    )
    key = point_key(analysis.template, values, analysis.entry(index))
    block = pack([outcome], [key], single.variables)
    return assemble(single, lambda: [(np.zeros(1, np.int64), block)])


def _single(dim: Dim, by_name: Mapping[str, Any]) -> Dim:
    return Dim(tuple(Axis(axis.name, axis.kind, (by_name[axis.name],)) for axis in dim.axes))
