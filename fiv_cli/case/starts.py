"""The tables ``[[initial]]``: where motions start."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

from fiv_cli.case.case import Axis, StartSpec
from fiv_cli.case.physics import Physics, note_no_axis, note_no_state
from fiv_cli.case.report import Path, Report
from fiv_cli.case.structure import InitialTable
from fiv_cli.case.tables import read_tables
from fiv_cli.notation.names import ascii_name, listed, suggest
from fiv_cli.notation.units import convert

AT_REST = StartSpec("rest", "state")

_LABEL = re.compile(r"[A-Za-z0-9_.+-]+")
_KEYS_OF_KIND = {
    "equilibrium": {"offset"},
    "state": {"state"},
    "random": {"count", "seed", "box"},
    "continue": {"along", "direction", "from", "on_loss", "offset"},
}
_COMMON_KEYS = {"label", "kind"}


def read_starts(
    raw: Mapping[str, Any], physics: Physics, axes: Sequence[Axis], report: Report
) -> tuple[StartSpec, ...]:
    """The starts in order; one at rest, all states zero, when the case names none."""
    tables = read_tables(InitialTable, raw.get("initial", []), ("initial",), report)
    starts = [_start(table, element, place, physics, report) for place, element, table in tables]
    places = [place for place, _, _ in tables]
    if not all(isinstance(element.get("label", ""), str) for _, element, _ in tables):
        report.unsure_of("starts")
    _check_labels(starts, places, report)
    for start, place in zip(starts, places, strict=True):
        if start.kind == "continue":
            _check_continued(start, place, starts, axes, physics, report)
    return tuple(starts) or (AT_REST,)


def _start(
    table: InitialTable, raw: Mapping[str, Any], place: Path, physics: Physics, report: Report
) -> StartSpec:
    if raw.get("kind") == table.kind:
        _refuse_foreign_keys(table.kind, raw, place, report)
    units = physics.units_of_states()
    return StartSpec(
        label=table.label if table.label is not None else table.kind,
        kind=table.kind,
        offset=_numbers(table.offset, units, (*place, "offset"), report),
        state=_state(table.state, physics, (*place, "state"), report),
        count=_at_least(1, table.count, (*place, "count"), report),
        seed=_at_least(0, table.seed, (*place, "seed"), report),
        box=_box(table, units, place, report),
        along=_axis_name(table.along or ""),
        direction=table.direction,
        from_label=table.from_label or "",
        on_loss=table.on_loss,
    )


def _refuse_foreign_keys(kind: str, raw: Mapping[str, Any], place: Path, report: Report) -> None:
    keys = _KEYS_OF_KIND[kind] | _COMMON_KEYS
    known = set().union(*_KEYS_OF_KIND.values())
    for key in raw:
        if key in known and key not in keys:
            report.add(
                (*place, key), f"a start of kind {kind!r} has no {key}", listed(sorted(keys))
            )


def _known_states(
    values: Mapping[str, Any], units: Mapping[str, str], place: Path, report: Report
) -> Iterable[tuple[str, Path, Any]]:
    """State, place and value of the entries that name a state."""
    for key, value in values.items():
        name = ascii_name(key)
        if name in units:
            yield name, (*place, key), value
        else:
            note_no_state(name, (*place, key), units, report)


def _numbers(
    values: Mapping[str, Any], units: Mapping[str, str], place: Path, report: Report
) -> dict[str, float]:
    found = {}
    for name, key_place, value in _known_states(values, units, place, report):
        try:
            found[name] = convert(value, units[name])
        except ValueError as error:
            report.add(key_place, str(error), f"a number in {units[name]}")
    return found


def _state(
    values: Mapping[str, Any], physics: Physics, place: Path, report: Report
) -> dict[str, float | str]:
    units, parameters = physics.units_of_states(), physics.table()
    found: dict[str, float | str] = {}
    for name, key_place, value in _known_states(values, units, place, report):
        if isinstance(value, str) and ascii_name(value) in parameters:
            found[name] = ascii_name(value)
            continue
        try:
            found[name] = convert(value, units[name])
        except ValueError as error:
            meanings = {p.name: p.meaning for p in parameters.values()}
            report.add(
                key_place,
                str(error),
                f"a number in {units[name]}, or the name of a parameter",
                suggest(str(value), meanings),
            )
    return found


def _at_least(least: int, value: int, place: Path, report: Report) -> int:
    if value < least:
        report.add(place, f"{value} is out of range", f"a whole number >= {least}")
    return value


def _box(
    table: InitialTable, units: Mapping[str, str], place: Path, report: Report
) -> dict[str, tuple[float, float]]:
    if table.kind == "random" and not table.box:
        report.add(place, "a random start needs its box", "box = { STATE = [low, high], ... }")
    found = {}
    for name, key_place, bounds in _known_states(table.box, units, (*place, "box"), report):
        try:
            low, high = (convert(bound, units[name]) for bound in bounds)
        except ValueError as error:
            report.add(key_place, str(error), f"two numbers in {units[name]}")
            continue
        if low > high:
            report.add(key_place, f"the low end {low!r} is above the high end {high!r}")
        found[name] = (low, high)
    return found


def _axis_name(name: str) -> str:
    return ascii_name(name).removeprefix("friction.")


def _check_labels(starts: Sequence[StartSpec], places: Sequence[Path], report: Report) -> None:
    seen: set[str] = set()
    for start, place in zip(starts, places, strict=True):
        if not _LABEL.fullmatch(start.label):
            report.add(
                (*place, "label"), f"{start.label!r} is no label", "letters, digits, _ . + -"
            )
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
    """A continued start follows a numeric axis and begins where another start does."""
    followable = [axis.name for axis in axes if axis.kind == "parameter"]
    if start.along not in followable:
        message = f"{start.along!r} is no numeric axis of the grid" if start.along else "is missing"
        note_no_axis(start.along, message, (*place, "along"), followable, physics, report)
    beginnings = [other.label for other in starts if other.kind in ("equilibrium", "state")]
    if start.from_label not in beginnings and report.is_sure_of("starts"):
        message = f"no start is labelled {start.from_label!r}" if start.from_label else "is missing"
        report.add(
            (*place, "from"),
            message,
            f"a start of kind equilibrium or state: {listed(beginnings)}",
            suggest(start.from_label, beginnings),
        )
