"""The tables ``[[initial]]``: where motions start."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

from fiv_cli.case.case import Axis, StartSpec
from fiv_cli.case.form import Form
from fiv_cli.case.kinds import refuse_foreign_keys
from fiv_cli.case.physics import Physics, counterpart, note_no_axis, note_no_state
from fiv_cli.case.report import Path, Report
from fiv_cli.case.start_table import rows_in
from fiv_cli.case.structure import InitialTable
from fiv_cli.notation.names import ascii_name, axis_name, listed
from fiv_cli.notation.units import convert

AT_REST = StartSpec("rest", "state")

_LABEL = re.compile(r"[A-Za-z0-9_.+-]+(?: [A-Za-z0-9_.+-]+)*")
BEGINNINGS = ("equilibrium", "state", "continue")
ONE_OF = 'states = [{ STATE = value, ... }, ...], or file = "starts.csv"'


def read_starts(
    form: Form, physics: Physics, axes: Sequence[Axis], report: Report
) -> tuple[StartSpec, ...]:
    """The starts in order; one at rest, all states zero, when the case names none."""
    places: list[Path] = [("initial", index) for index in range(len(form.initial))]
    tables = zip(form.initial, places, strict=True)
    starts = [_start(table, place, physics, report) for table, place in tables]
    _check_labels(starts, places, report)
    for start, place in zip(starts, places, strict=True):
        if start.kind == "continue":
            _check_continued(start, place, starts, axes, physics, report)
    return tuple(starts) or (AT_REST,)


def _start(table: InitialTable, place: Path, physics: Physics, report: Report) -> StartSpec:
    refuse_foreign_keys(table, f"a start of kind {table.kind!r}", place, report)
    rows = _rows(table, place, physics, report) if table.kind == "table" else ()
    return StartSpec(
        label=table.label if table.label is not None else table.kind,
        kind=table.kind,
        offset=_numbers(table.offset, physics, (*place, "offset"), report),
        state=_state(table.state, physics, (*place, "state"), report),
        count=len(rows) or table.count,
        seed=table.seed,
        box=_box(table, physics, place, report),
        rows=rows,
        along=axis_name(table.along or ""),
        direction=table.direction,
        from_label=table.from_label or "",
        on_loss=table.on_loss,
        steps=table.steps,
    )


def _known_states(
    values: Mapping[str, Any], physics: Physics, place: Path, report: Report
) -> Iterable[tuple[str, str, Path, Any]]:
    """State, its unit, place and value of the entries that name a state."""
    units = physics.units_of_states()
    for key, value in values.items():
        name = ascii_name(key)
        if name in units:
            yield name, units[name], (*place, key), value
        else:
            note_no_state(name, (*place, key), physics, report)


def _numbers(
    values: Mapping[str, Any], physics: Physics, place: Path, report: Report
) -> dict[str, float]:
    found = {}
    for name, unit, key_place, value in _known_states(values, physics, place, report):
        with report.noting(key_place, f"a number in {unit}"):
            found[name] = convert(value, unit)
    return found


def _rows(
    table: InitialTable, place: Path, physics: Physics, report: Report
) -> tuple[dict[str, float], ...]:
    """The starts of a table, in the case or in a file."""
    if bool(table.states) == bool(table.file):
        has = "has both states and a file" if table.file else "needs its states, or a file"
        report.add(place, f"a table of starts {has}", ONE_OF)
    places = (((*place, "states", number), row) for number, row in enumerate(table.states))
    given = rows_in(table.file, (*place, "file"), physics, report) if table.file else places
    return tuple(_numbers(row, physics, row_place, report) for row_place, row in given)


def _state(
    values: Mapping[str, Any], physics: Physics, place: Path, report: Report
) -> dict[str, float | str]:
    parameters = {p.name: p.meaning for p in physics.table().values()}
    found: dict[str, float | str] = {}
    for name, unit, key_place, value in _known_states(values, physics, place, report):
        negative = isinstance(value, str) and value.startswith("-")
        named = ascii_name(value.removeprefix("-").lstrip()) if isinstance(value, str) else ""
        if named in parameters:
            found[name] = f"{'-' * negative}{named}"
        elif named.isidentifier():
            message, hint = f"there is no parameter {named!r}", counterpart(named, physics.table())
            report.unknown(key_place, message, named, parameters, hint)
        else:
            allowed = f"a number in {unit}, or the name of a parameter, a minus before it or not"
            with report.noting(key_place, allowed):
                found[name] = convert(value, unit)
    return found


def _box(
    table: InitialTable, physics: Physics, place: Path, report: Report
) -> dict[str, tuple[float, float]]:
    if table.kind == "random" and not table.box:
        report.add(place, "a random start needs its box", "box = { STATE = [low, high], ... }")
    found = {}
    for name, unit, key_place, bounds in _known_states(table.box, physics, (*place, "box"), report):
        with report.noting(key_place, f"two numbers in {unit}"):
            found[name] = low, high = convert(bounds[0], unit), convert(bounds[1], unit)
            if low > high:
                raise ValueError(f"the low end {low!r} is above the high end {high!r}")
    return found


def _check_labels(starts: Sequence[StartSpec], places: Sequence[Path], report: Report) -> None:
    seen: set[str] = set()
    for start, place in zip(starts, places, strict=True):
        if not _LABEL.fullmatch(start.label):
            allowed = "letters, digits, _ . + -, single spaces between words"
            report.add((*place, "label"), f"{start.label!r} is no label", allowed)
        if start.label in seen:
            report.add((*place, "label"), f"the label {start.label!r} is taken", "unique labels")
        seen.add(start.label)


def _check_continued(
    start: StartSpec,
    place: Path,
    starts: Sequence[StartSpec],
    axes: Sequence[Axis],
    physics: Physics,
    report: Report,
) -> None:
    """A continued start follows a numeric axis; it begins where another does, or a chain ends."""
    followable = [axis.name for axis in axes if axis.kind == "parameter"]
    if not start.along:
        report.add((*place, "along"), "is missing", f"a numeric axis: {listed(followable)}")
    elif start.along not in followable:
        message = f"{start.along!r} is no numeric axis of the grid"
        note_no_axis(start.along, message, (*place, "along"), followable, physics, report)
    by_label = {other.label: other for other in starts if other.kind in BEGINNINGS}
    beginnings = [label for label in by_label if label != start.label]
    if not start.from_label:
        report.add((*place, "from"), "is missing", _allowed_first(beginnings, by_label))
    elif start.from_label not in beginnings:
        message = f"there is no start {start.from_label!r} to begin at, {listed(BEGINNINGS)}"
        hint = "" if beginnings else _allowed_first(beginnings, by_label)
        report.unknown((*place, "from"), message, start.from_label, beginnings, hint)
    elif by_label[start.from_label].kind == "continue":
        _check_next_leg(start, (*place, "from"), by_label, report)


def _allowed_first(beginnings: Sequence[str], by_label: Mapping[str, StartSpec]) -> str:
    """At what the first point of a chain may begin."""
    own = [label for label in beginnings if by_label[label].kind != "continue"]
    if own:
        return f"the label of the start of the first point: {listed(own)}"
    return (
        "the label of a start for the first point; there is none yet, add [[initial]] "
        'label = "first", kind = "equilibrium" and write from = "first"'
    )


def _check_next_leg(
    start: StartSpec, place: Path, by_label: Mapping[str, StartSpec], report: Report
) -> None:
    """A chain that begins at the end of another goes back along the axis, and alone."""
    before = by_label[start.from_label]
    back = "down" if start.direction == "up" else "up"
    if (before.along, before.direction) != (start.along, back):
        message = f"{before.label!r} goes {before.direction} along {before.along}, not {back} along"
        allowed = "a chain begins where one the other way ends"
        report.add(place, f"{message} {start.along}", allowed, relates=True)
    rivals = [o.label for o in by_label.values() if o.from_label == before.label]
    if rivals[0] != start.label:
        message = f"{rivals[0]!r} begins at the end of {before.label!r} already"
        report.add(place, message, "one chain; give this one a chain of its own to begin at")
    passed = [start.label]
    while before.kind == "continue" and before.label not in passed:
        passed.append(before.label)
        before = by_label.get(before.from_label, AT_REST)
    if before.label in passed:
        chains = " from ".join(map(repr, [*passed, before.label]))
        report.add(place, f"{chains}: none has a beginning", "a start that is no chain at last")
