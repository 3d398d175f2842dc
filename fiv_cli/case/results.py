"""The tables ``[[figure]]`` and ``[[claim]]``: what is made of the answers."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from fiv_cli.analyses.catalogue import own_dims
from fiv_cli.case.case import AnalysisSpec, Axis, ClaimSpec, FigureSpec, StartSpec
from fiv_cli.case.grammar import parse_condition
from fiv_cli.case.physics import Physics, note_no_axis
from fiv_cli.case.report import Path, Report
from fiv_cli.case.structure import ClaimTable, FigureTable, TakeTable
from fiv_cli.case.tables import read_tables
from fiv_cli.notation.names import ascii_name, can_name_a_file, listed, suggest
from fiv_cli.notation.units import convert


@dataclass(frozen=True)
class Answers:
    """What figures and claims may speak of: the case's axes, starts and analyses.

    `physics` is None when the model is not known; names are then not checked.
    """

    physics: Physics | None
    axes: tuple[Axis, ...]
    starts: tuple[StartSpec, ...]
    analyses: tuple[AnalysisSpec, ...]

    def axis_names(self) -> dict[str, str]:
        """Axis -> kind."""
        return {axis.name: axis.kind for axis in self.axes}

    def labels(self) -> list[str]:
        """Labels along ``initial``; a random start stands for all of its own."""
        return [start.label for start in self.starts]


def read_figures(
    raw: Mapping[str, Any], answers: Answers, report: Report
) -> tuple[FigureSpec, ...]:
    """The figures in order, each with a name of its own."""
    figures: list[FigureSpec] = []
    for place, element, table in read_tables(
        FigureTable, raw.get("figure", []), ("figure",), report
    ):
        _check_analysis(table.analysis, answers, place, report)
        _check_figure_axes(table, answers, place, report)
        taken = [figure.name for figure in figures]
        if table.name in taken:
            report.add((*place, "name"), f"the name {table.name!r} is taken", "unique names")
        if table.name is not None and not can_name_a_file(table.name):
            message = f"{table.name!r} cannot be part of the name of a file"
            report.add((*place, "name"), message, "one character at least, and no slash")
        given = {key: value for key, value in element.items() if key not in ("kind", "name")}
        settings = given | _canonical(table, answers, place, report)
        figures.append(FigureSpec(table.name or _free(table.kind, taken), table.kind, settings))
    return tuple(figures)


def read_claims(raw: Mapping[str, Any], answers: Answers, report: Report) -> tuple[ClaimSpec, ...]:
    """The claims in order."""
    return tuple(
        _claim(table, place, answers, report)
        for place, _, table in read_tables(ClaimTable, raw.get("claim", []), ("claim",), report)
    )


def _free(name: str, taken: Sequence[str]) -> str:
    """`name`, or `name-2`, `name-3`, ... when it is taken."""
    numbered = (f"{name}-{n}" for n in range(2, len(taken) + 3))
    return next(one for one in (name, *numbered) if one not in taken)


def _check_analysis(name: str | None, answers: Answers, place: Path, report: Report) -> None:
    known = [analysis.name for analysis in answers.analyses]
    if name is not None and name not in known and report.is_sure_of("analyses"):
        report.add(
            (*place, "analysis"),
            f"there is no analysis named {name!r}",
            listed(known),
            suggest(name, known),
        )


def _check_figure_axes(table: FigureTable, answers: Answers, place: Path, report: Report) -> None:
    for key, known in _known_of_axes(table.kind, answers).items():
        value = getattr(table, key)
        if value is not None and answers.physics is not None and ascii_name(value) not in known:
            message = f"a figure of kind {table.kind!r} has no {key} {value!r}"
            note_no_axis(ascii_name(value), message, (*place, key), known, answers.physics, report)
    missing = table.kind == "map" and answers.physics is not None and len(answers.axes) < 2
    if missing and report.is_sure_of("axes"):
        report.add(place, "a map needs a grid of two axes")
    if table.kind == "map" and table.overlay and table.level is None:
        message = "maps are overlaid as lines, and no level says which"
        report.add((*place, "overlay"), message, "level = NUMBER or [NUMBER, ...]")


def _known_of_axes(kind: str, answers: Answers) -> dict[str, list[str]]:
    """For each of x and y that names an axis in a figure of this kind: what it may be."""
    states = list(answers.physics.units_of_states()) if answers.physics else []
    axes = [axis.name for axis in answers.axes]
    if kind == "phase":
        return {"x": states, "y": states}
    if kind == "map":
        return {"x": axes, "y": axes}
    if kind in ("curve", "bifurcation", "eigenvalues", "spectrum"):
        return {"x": axes}
    return {}


def _canonical(table: FigureTable, answers: Answers, place: Path, report: Report) -> dict[str, Any]:
    """Names in their contract spelling and the selection in SI."""
    changed: dict[str, Any] = {}
    for key in ("x", "y"):
        value = getattr(table, key)
        if value is not None:
            changed[key] = ascii_name(value)
    if table.select:
        changed["select"] = _selection(table.select, answers, (*place, "select"), report)
    if table.take is not None:
        changed["take"] = _take(table.take, answers, (*place, "take"), report)
    return changed


def _take(table: TakeTable, answers: Answers, place: Path, report: Report) -> dict[str, Any]:
    """What is taken, its axes by their contract names and its reference in SI."""
    known = [*answers.axis_names(), "initial", *own_dims()]
    over = [ascii_name(name).removeprefix("friction.") for name in table.over]
    for name in over:
        if answers.physics is not None and name not in known:
            message = f"{name!r} is no axis of this case"
            note_no_axis(name, message, (*place, "over"), known, answers.physics, report)
    found: dict[str, Any] = {"what": table.what, "over": over}
    if table.of is not None:
        found["of"] = table.of
    if table.relative_to:
        at = (*place, "relative_to")
        found["relative_to"] = _selection(table.relative_to, answers, at, report)
    return found


def _selection(
    given: Mapping[str, Any], answers: Answers, place: Path, report: Report
) -> dict[str, Any]:
    """Axis -> value in SI, or label, or condition, for the keys that are dims."""
    kinds = dict.fromkeys(own_dims(), "own") | answers.axis_names() | {"initial": "label"}
    found = {}
    for key, value in given.items():
        name = ascii_name(key).removeprefix("friction.")
        if name not in kinds:
            if answers.physics is not None:
                known = [*answers.axis_names(), "initial"]
                message = f"{name!r} is no axis of this case"
                note_no_axis(name, message, (*place, key), known, answers.physics, report)
            continue
        try:
            found[name] = _selected(name, kinds[name], value, answers)
        except ValueError as error:
            if kinds[name] != "label" or report.is_sure_of("starts"):
                report.add((*place, key), str(error))
    return found


def _selected(name: str, kind: str, value: Any, answers: Answers) -> Any:
    if kind == "label":
        _check_label(value, answers)
        return value
    if kind == "option" and answers.physics is not None:
        return next(o for o in answers.physics.model.options if o.name == name).text(value)
    if kind in ("own", "option", "law") or not isinstance(value, str):
        return value
    if parse_condition(value):
        return value.strip()
    return convert(value, _unit(name, answers))


def _check_label(value: object, answers: Answers) -> None:
    labels = answers.labels()
    random = tuple(f"{start.label}-" for start in answers.starts if start.kind == "random")
    if value not in labels and not str(value).startswith(random):
        hint = suggest(str(value), labels)
        raise ValueError(
            f"there is no start {value!r}; there are: {listed(labels)}. {hint}".strip()
        )


def _unit(name: str, answers: Answers) -> str:
    if answers.physics is None:
        return "1"
    if name.startswith("initial."):
        return answers.physics.units_of_states()[name.removeprefix("initial.")]
    return answers.physics.table()[name].unit


def _claim(table: ClaimTable, place: Path, answers: Answers, report: Report) -> ClaimSpec:
    _check_analysis(table.analysis, answers, place, report)
    return ClaimSpec(
        source=table.source,
        text=table.text,
        variable=table.variable,
        expect=table.expect,
        at=_selection(table.at, answers, (*place, "at"), report),
        holds=table.holds,
        note=table.note,
        analysis=table.analysis or "",
        take=_take(table.take, answers, (*place, "take"), report) if table.take else {},
    )
