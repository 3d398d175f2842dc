"""The tables ``[grid]`` and ``[sweep]``: which axes there are, and their values."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import partial
from math import prod
from typing import Any, NamedTuple

from fiv_cli.case.axes import LONGEST_AXIS, AxisError, Candidate, Span, span_by_count, span_by_step
from fiv_cli.case.case import Axis, Refinement
from fiv_cli.case.form import Form, own_file
from fiv_cli.case.physics import (
    AMBIGUOUS,
    Physics,
    is_ambiguous,
    law_names,
    note_no_axis,
    note_no_state,
    note_nothing_to_vary,
    resolve_law,
)
from fiv_cli.case.refinement import halved, read_refinement
from fiv_cli.case.report import Path, Report
from fiv_cli.case.structure import RangeTable, SweepTable
from fiv_cli.friction import all_laws
from fiv_cli.notation.names import axis_name, listed, suggest
from fiv_cli.notation.units import exact, nearest_double
from fiv_cli.notation.values import check_quantity

MOST_POINTS = 10**9


class Grid(NamedTuple):
    """The axes in order, the groups that advance together, and what is refined."""

    axes: tuple[Axis, ...] = ()
    zips: tuple[tuple[str, ...], ...] = ()
    refinement: Refinement | None = None


def read_grid(form: Form, physics: Physics, report: Report) -> Grid:
    """The grid; axes that are refined hold their finest lattice."""
    counted = _candidates(form, physics, report)
    zips = _zips(form.sweep, [candidate.name for candidate in counted], physics, report)
    refinement = read_refinement(form.sweep, counted, zips, physics, report)
    if refinement is not None:
        counted = halved(counted, refinement, report)
    _check_zip_lengths(counted, zips, report)
    if not _few_enough(counted, zips, report):
        return Grid(tuple(Axis(one.name, one.kind, ()) for one in counted), zips)
    zipped = {axis_name(name) for group in form.sweep.zip for name in group}
    return Grid(tuple(_axis(one, one.name in zipped, report) for one in counted), zips, refinement)


def _candidates(form: Form, physics: Physics, report: Report) -> list[Candidate]:
    """Every axis that has a known name."""
    found: dict[str, Candidate] = {}
    for name, place, value in form.grid:
        candidate = _candidate(name, place, physics, report)
        if candidate is None:
            continue
        if name in found:
            report.add(place, f"the axis {name!r} is given twice")
        found.setdefault(name, replace(candidate, written=_written(candidate, value, report)))
    return list(found.values())


def _candidate(name: str, place: Path, physics: Physics, report: Report) -> Candidate | None:
    """The axis called `name`, or None and a note."""
    state = name.removeprefix("initial.")
    options = {option.name: option for option in physics.model.options}
    units, parameters = physics.units_of_states(), physics.table()
    if state != name and state in units:
        return Candidate(name, "start", place, float, units[state], f"numbers in {units[state]}")
    if state != name:
        note_no_state(state, place, physics, report)
    elif name == "friction":
        names = law_names(physics.model)
        named = partial(resolve_law, physics.model)
        return Candidate(name, "law", place, named, None, listed(names), names)
    elif name in options:
        own = options[name]
        return Candidate(name, "option", place, own.text, None, own.allowed, own.choices)
    elif name in parameters:
        if physics.laws_known and is_ambiguous(physics.laws, name):
            hint = "values under [friction.LAW]; or run the laws one by one"
            report.add(place, AMBIGUOUS.format(name), suggestion=hint, relates=True)
        parameter = parameters[name]
        read, unit = parameter.checked, parameter.unit
        return Candidate(name, "parameter", place, read, unit, parameter.allowed)
    else:
        note_nothing_to_vary(name, place, physics, report)
    return None


def _written(
    candidate: Candidate, value: list[Any] | RangeTable, report: Report
) -> Span | list[Any]:
    """The axis, not yet built; an empty list, and a note, where it is none."""
    if isinstance(value, list):
        if not value:
            report.add(candidate.place, "the axis is empty", candidate.allowed)
        return value
    if candidate.unit is None:
        report.add(candidate.place, "names are listed, not given as a range", candidate.allowed)
        return []
    try:
        return _exact_span(value, candidate.unit)
    except AxisError as error:
        given = error.key in value.model_fields_set
        report.add((*candidate.place, error.key) if given else candidate.place, str(error))
    except ValueError as error:
        report.add(candidate.place, str(error), candidate.allowed)
    return []


def _exact_span(table: RangeTable, unit: str) -> Span:
    """The span of a range table; AxisError and ValueError say what is wrong."""
    start, stop = exact(table.start, unit), exact(table.stop, unit)
    nearest_double(start), nearest_double(stop)
    if (table.step is None) == (table.num is None):
        raise AxisError("give either step or num")
    if table.step is not None:
        if table.scale == "log":
            raise AxisError('scale = "log" goes with num, not with step', "scale")
        return span_by_step(start, stop, exact(table.step, unit))
    return span_by_count(start, stop, int(table.num or 0), table.scale)


def _few_enough(
    counted: Sequence[Candidate], zips: Sequence[Sequence[str]], report: Report
) -> bool:
    """Whether the grid can be held at all."""
    too_long = [one for one in counted if one.count > LONGEST_AXIS]
    for one in too_long:
        report.add(one.place, f"the axis has {one.count:,} values", f"at most {LONGEST_AXIS:,}")
    points = count_points({one.name: one.count for one in counted}, zips)
    if points > MOST_POINTS:
        report.add(("grid",), f"the grid has {points:,} points", f"at most {MOST_POINTS:,}")
    return not too_long and points <= MOST_POINTS


def count_points(lengths: Mapping[str, int], zips: Sequence[Sequence[str]]) -> int:
    """Number of points of a grid: the product over axes, a zipped group counting once."""
    followers = {name for group in zips for name in group[1:]}
    return prod(length for name, length in lengths.items() if name not in followers)


def _axis(candidate: Candidate, zipped: bool, report: Report) -> Axis:
    values: list[Any] = []
    if isinstance(candidate.written, Span):
        with report.noting(candidate.place, candidate.allowed):
            values = [candidate.read(value) for value in candidate.written.values()]
    else:
        elements = (_element(candidate, *one, report) for one in enumerate(candidate.written))
        values = [value for value in elements if value is not None]
    if not zipped:
        _refuse_repeats(candidate, values, report)
    return Axis(candidate.name, candidate.kind, tuple(values))


def _element(candidate: Candidate, index: int, value: Any, report: Report) -> Any:
    """An element of a list, a number in SI; None, and a note, where it is not allowed."""
    try:
        if candidate.unit is not None:
            value = nearest_double(exact(check_quantity(value), candidate.unit))
        return candidate.read(value)
    except ValueError as error:
        place, hint = (*candidate.place, index), suggest(str(value), candidate.choices)
        if candidate.kind == "law" and value not in all_laws():
            hint = own_file(str(value), report) or hint
        report.add(place, str(error), candidate.allowed, hint, of_name=candidate.unit is None)
        return None


def _refuse_repeats(candidate: Candidate, values: Sequence[Any], report: Report) -> None:
    if len(set(values)) == len(values):
        return
    repeated = [repr(value) for value, count in Counter(values).items() if count > 1]
    report.add(candidate.place, f"values repeat: {listed(repeated[:3])}", "each value once")


def _zips(
    table: SweepTable, names: Sequence[str], physics: Physics, report: Report
) -> tuple[tuple[str, ...], ...]:
    """The groups of ``[sweep] zip`` that are sound."""
    sound: list[tuple[str, ...]] = []
    for index, group in enumerate(table.zip):
        place: Path = ("sweep", "zip", index)
        members = tuple(map(axis_name, group))
        unknown = [name for name in members if name not in names]
        for name in unknown:
            note_no_axis(name, f"{name!r} is no axis of the grid", place, names, physics, report)
        taken = {name for other in sound for name in other}
        if len(set(members)) < len(members) or taken & set(members):
            report.add(place, "an axis is zipped twice")
        elif len(members) < 2:
            report.add(place, "a group that advances together has two axes at least")
        elif not unknown:
            sound.append(members)
    return tuple(sound)


def _check_zip_lengths(
    counted: Sequence[Candidate], zips: Sequence[Sequence[str]], report: Report
) -> None:
    lengths = {one.name: one.count for one in counted}
    for index, group in enumerate(zips):
        sizes = {name: lengths[name] for name in group if lengths[name]}
        if len(set(sizes.values())) > 1:
            shown = ", ".join(f"{name} has {size}" for name, size in sizes.items())
            report.add(("sweep", "zip", index), f"axes that advance together differ: {shown}")


def refuse_fixed_axes(form: Form, report: Report) -> None:
    """Note every axis whose name the case also fixes."""
    for axis in form.grid:
        for place in form.places_of(axis.name):
            report.add(
                axis.place,
                f"{axis.name!r} is an axis and is also fixed, by {'.'.join(map(str, place))}",
                "one of the two",
                f"to compute a single value of an axis: --set grid.{axis.name}=[VALUE]",
            )
