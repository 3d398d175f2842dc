"""The tables ``[grid]`` and ``[sweep]``: which axes there are, and their values."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from math import prod
from typing import Any, NamedTuple

from fiv_cli.case.axes import LONGEST_AXIS, AxisError, Span, span_by_count, span_by_step
from fiv_cli.case.case import Axis, Refinement
from fiv_cli.case.physics import (
    Physics,
    law_names,
    note_no_axis,
    note_no_state,
    resolve_law,
)
from fiv_cli.case.refinement import halved, read_refinement
from fiv_cli.case.report import Path, Report
from fiv_cli.case.structure import RangeTable, SweepTable
from fiv_cli.case.tables import read_table
from fiv_cli.notation.names import ascii_name, listed, nearest, suggest
from fiv_cli.notation.units import exact, nearest_double
from fiv_cli.notation.values import check_quantity, describe

MOST_POINTS = 10**9
_RANGE_KEYS = {"start", "stop", "step", "num", "scale"}


@dataclass(frozen=True)
class Candidate:
    """An axis by name, before its values are read: `read` turns one value into what is kept."""

    name: str
    kind: str
    place: Path
    read: Callable[[Any], Any]
    unit: str | None = None
    allowed: str = ""


class Grid(NamedTuple):
    """The axes in order, the groups that advance together, and what is refined."""

    axes: tuple[Axis, ...] = ()
    zips: tuple[tuple[str, ...], ...] = ()
    refinement: Refinement | None = None


def read_grid(raw: Mapping[str, Any], physics: Physics, report: Report) -> Grid:
    """The grid; axes that are refined hold their finest lattice."""
    counted = _candidates(raw.get("grid", {}), physics, report)
    table = read_table(SweepTable, raw.get("sweep", {}), ("sweep",), report)
    zips = _zips(table, [candidate.name for candidate, _ in counted], physics, report)
    refinement = read_refinement(table, counted, zips, physics, report)
    if refinement is not None:
        counted = halved(counted, refinement, report)
    if not _few_enough(counted, zips, report):
        return Grid(tuple(Axis(c.name, c.kind, ()) for c, _ in counted), zips)
    zipped = {name for group in zips for name in group}
    axes = tuple(_axis(c, form, c.name in zipped, report) for c, form in counted)
    if all(axis.values for axis in axes) and report.is_sure_of("values"):
        _check_zip_lengths(axes, zips, report)
    return Grid(axes, zips, refinement)


def _candidates(
    grid: object, physics: Physics, report: Report
) -> list[tuple[Candidate, Span | list[Any]]]:
    """Every axis that has a known name; an unsound form is noted and becomes an empty list."""
    if not isinstance(grid, dict):
        report.add(("grid",), f"must be a table, not {describe(grid)}")
        report.unsure_of("axes")
        return []
    found: dict[str, tuple[Candidate, Span | list[Any]]] = {}
    for key, place, value in _flattened(grid):
        candidate = _candidate(key, place, physics, report)
        if candidate is None:
            candidate = _meant(key, place, grid, physics, report)
        if candidate is None:
            continue
        if candidate.name in found:
            report.add(place, f"the axis {candidate.name!r} is given twice")
        found.setdefault(candidate.name, (candidate, _form(candidate, value, report) or []))
    return list(found.values())


def _meant(
    key: str, place: Path, grid: Mapping[str, Any], physics: Physics, report: Report
) -> Candidate | None:
    """The axis that a misspelt one resembles, so that its values are checked all the same."""
    report.unsure_of("axes")
    name = nearest(ascii_name(key), physics.what_varies())
    if name is None or name in {_axis_name(other) for other, _, _ in _flattened(grid)}:
        return None
    return _candidate(name, place, physics, report)


def _flattened(grid: Mapping[str, Any]) -> Iterable[tuple[str, Path, Any]]:
    """Axes with their places; ``initial.x = ...`` may be written without quotes."""
    for key, value in grid.items():
        nested = isinstance(value, dict) and not _RANGE_KEYS & value.keys()
        if nested and key in ("initial", "friction"):
            for inner, axis in value.items():
                yield f"{key}.{inner}", ("grid", key, inner), axis
        else:
            yield key, ("grid", key), value


def _candidate(key: str, place: Path, physics: Physics, report: Report) -> Candidate | None:
    """The axis that `key` names, or None and a note."""
    name = ascii_name(key)
    if name.startswith("initial."):
        return _start_axis(name, place, physics, report)
    if name == "friction":
        return _law_axis(place, physics)
    options = {option.name: option for option in physics.model.options}
    if name in options:
        return Candidate(name, "option", place, options[name].text, allowed=options[name].allowed)
    return _parameter_axis(name.removeprefix("friction."), place, physics, report)


def _start_axis(name: str, place: Path, physics: Physics, report: Report) -> Candidate | None:
    units = physics.units_of_states()
    state = name.removeprefix("initial.")
    if state not in units:
        note_no_state(state, place, units, report)
        return None
    return Candidate(name, "start", place, _finite, units[state], f"numbers in {units[state]}")


def _finite(value: float) -> float:
    return value


def _law_axis(place: Path, physics: Physics) -> Candidate:
    names = law_names(physics.model)
    return Candidate(
        "friction",
        "law",
        place,
        lambda value: resolve_law(physics.model, str(value)),
        allowed=listed(names),
    )


def _parameter_axis(name: str, place: Path, physics: Physics, report: Report) -> Candidate | None:
    table = physics.table()
    if name not in table:
        if report.is_sure_of("law") or not physics.of_another_law(name):
            known = physics.what_varies()
            message = f"there is nothing called {name!r} to vary"
            report.misread[name] = message, listed(known), suggest(name, known)
            report.add(place, *report.misread[name])
        return None
    return Candidate(
        name,
        "parameter",
        place,
        table[name].checked,
        table[name].unit,
        table[name].allowed,
    )


def _form(candidate: Candidate, value: object, report: Report) -> Span | list[Any] | None:
    """The axis as a span or a list, not yet built; None and a note when it is neither."""
    if isinstance(value, dict):
        return _span(candidate, value, report)
    if not isinstance(value, list):
        report.add(
            candidate.place,
            f"an axis is a list or a range, not {describe(value)}",
            "[1, 2, 3], { start, stop, step } or { start, stop, num, scale }",
            "a single value is fixed under [model.parameters] or [friction]",
        )
        return None
    if not value:
        report.add(candidate.place, "the axis is empty", candidate.allowed)
        return None
    return value


def _span(candidate: Candidate, value: dict[str, Any], report: Report) -> Span | None:
    table = read_table(RangeTable, value, candidate.place, report)
    if table is None or not value.keys() <= _RANGE_KEYS:
        return None
    if candidate.unit is None:
        report.add(candidate.place, "names are listed, not given as a range", candidate.allowed)
        return None
    try:
        return _exact_span(table, candidate.unit)
    except AxisError as error:
        place = (*candidate.place, error.key) if error.key in value else candidate.place
        report.add(place, str(error))
    except ValueError as error:
        report.add(candidate.place, str(error), candidate.allowed)
    return None


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


def _length(form: Span | list[Any]) -> int:
    return form.count if isinstance(form, Span) else len(form)


def _few_enough(
    counted: Sequence[tuple[Candidate, Span | list[Any]]],
    zips: Sequence[Sequence[str]],
    report: Report,
) -> bool:
    """Whether the grid can be held at all; counted, not built."""
    lengths = {candidate.name: _length(form) for candidate, form in counted}
    too_long = [c for c, form in counted if _length(form) > LONGEST_AXIS]
    for candidate in too_long:
        count = lengths[candidate.name]
        report.add(candidate.place, f"the axis has {count:,} values", f"at most {LONGEST_AXIS:,}")
    points = count_points(lengths, zips)
    if points > MOST_POINTS:
        report.add(("grid",), f"the grid has {points:,} points", f"at most {MOST_POINTS:,}")
    return not too_long and points <= MOST_POINTS


def count_points(lengths: Mapping[str, int], zips: Sequence[Sequence[str]]) -> int:
    """Number of points of a grid: the product over axes, a zipped group counting once."""
    followers = {name for group in zips for name in group[1:]}
    return prod(length for name, length in lengths.items() if name not in followers)


def _axis(candidate: Candidate, form: Span | list[Any], zipped: bool, report: Report) -> Axis:
    numbers = form.values() if isinstance(form, Span) else _listed_values(candidate, form, report)
    values = _checked(candidate, numbers, isinstance(form, Span), report)
    if not zipped:
        _refuse_repeats(candidate, values, report)
    return Axis(candidate.name, candidate.kind, tuple(values))


def _listed_values(candidate: Candidate, form: list[Any], report: Report) -> list[Any]:
    """The elements of a list, numbers in SI; those that are no numbers are noted."""
    if candidate.unit is None:
        return form
    numbers: list[Any] = []
    for index, value in enumerate(form):
        try:
            numbers.append(nearest_double(exact(check_quantity(value), candidate.unit)))
        except ValueError as error:
            report.add((*candidate.place, index), str(error), candidate.allowed)
            report.unsure_of("values")
            numbers.append(None)
    return numbers


def _checked(
    candidate: Candidate, values: Sequence[Any], regular: bool, report: Report
) -> list[Any]:
    """The values that are allowed; the first that is not is noted (each one of a list)."""
    kept = []
    for index, value in enumerate(values):
        if value is None:
            continue
        try:
            kept.append(candidate.read(value))
        except ValueError as error:
            place = candidate.place if regular else (*candidate.place, index)
            report.add(place, str(error), candidate.allowed)
            report.unsure_of("values")
            if regular:
                break
    return kept


def _refuse_repeats(candidate: Candidate, values: Sequence[Any], report: Report) -> None:
    if len(set(values)) == len(values) or not report.is_sure_of("zips"):
        return
    repeated = [repr(value) for value, count in Counter(values).items() if count > 1]
    report.add(candidate.place, f"values repeat: {listed(repeated[:3])}", "each value once")


def _zips(
    table: SweepTable | None, names: Sequence[str], physics: Physics, report: Report
) -> tuple[tuple[str, ...], ...]:
    """The groups of ``[sweep] zip`` that are sound."""
    groups = [] if table is None else table.zip
    sound: list[tuple[str, ...]] = []
    taken: set[str] = set()
    for index, group in enumerate(groups):
        place: Path = ("sweep", "zip", index)
        members = tuple(_axis_name(name) for name in group)
        if _sound_group(members, names, taken, place, physics, report):
            sound.append(members)
            taken.update(members)
        else:
            report.unsure_of("zips")
    return tuple(sound)


def _axis_name(name: str) -> str:
    return ascii_name(name).removeprefix("friction.")


def _sound_group(
    members: Sequence[str],
    names: Sequence[str],
    taken: set[str],
    place: Path,
    physics: Physics,
    report: Report,
) -> bool:
    unknown = [name for name in members if name not in names]
    for name in unknown:
        note_no_axis(name, f"{name!r} is no axis of the grid", place, names, physics, report)
    twice = len(set(members)) < len(members) or bool(taken & set(members))
    if twice:
        report.add(place, "an axis is zipped twice")
    if len(members) < 2:
        report.add(place, "a group that advances together has two axes at least")
    return not unknown and not twice and len(members) >= 2


def _check_zip_lengths(axes: Sequence[Axis], zips: Sequence[Sequence[str]], report: Report) -> None:
    lengths = {axis.name: len(axis.values) for axis in axes}
    for index, group in enumerate(zips):
        sizes = {name: lengths[name] for name in group}
        if len(set(sizes.values())) > 1:
            shown = ", ".join(f"{name} has {size}" for name, size in sizes.items())
            report.add(("sweep", "zip", index), f"axes that advance together differ: {shown}")


def refuse_fixed_axes(raw: Mapping[str, Any], axes: Iterable[Axis], report: Report) -> None:
    """Note every axis whose name the case also fixes."""
    written = {_axis_name(key): place for key, place, _ in _flattened(_table(raw, "grid"))}
    for axis in [axis for axis in axes if axis.name in written]:
        for place in fixed_places(raw, axis.name):
            shown = ".".join(map(str, place))
            report.add(
                written[axis.name],
                f"{axis.name!r} is an axis and is also fixed, by {shown}",
                "one of the two",
                f"to compute a single value of an axis: --set grid.{axis.name}=[VALUE]",
            )


def fixed_places(raw: Mapping[str, Any], name: str) -> list[Path]:
    """Where the case fixes what an axis, or the time, varies."""
    if name == "friction":
        return [("friction", "law")] if "law" in _table(raw, "friction") else []
    tables: list[Path] = [("model", "parameters"), ("model", "options"), ("friction",)]
    tables += [("friction", k) for k, v in _table(raw, "friction").items() if isinstance(v, dict)]
    return [
        (*path, key)
        for path in tables
        for key in _table(raw, *map(str, path))
        if ascii_name(key) == name
    ]


def _table(raw: Mapping[str, Any], *path: str) -> Mapping[str, Any]:
    """The table at `path`, empty when there is none."""
    table: Any = raw
    for key in path:
        table = table.get(key, {}) if isinstance(table, dict) else {}
    return table if isinstance(table, dict) else {}
