"""The tables ``[[figure]]`` and ``[[claim]]``: what is made of the answers."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

from fiv_cli.analyses.catalogue import every_variable, named, own_dims
from fiv_cli.case.case import (
    SEVERAL,
    AnalysisSpec,
    Axis,
    ClaimSpec,
    FigureSpec,
    StartSpec,
)
from fiv_cli.case.form import Form
from fiv_cli.case.grammar import Bounds, Expected, Reference, parse_condition
from fiv_cli.case.kinds import refuse_foreign_keys
from fiv_cli.case.physics import Physics, note_no_axis
from fiv_cli.case.report import Path, Report
from fiv_cli.case.structure import ClaimTable, FigureTable, TakeTable
from fiv_cli.case.tables import read_table
from fiv_cli.notation.names import ascii_name, axis_name, can_name_a_file, listed
from fiv_cli.notation.units import convert

BRANCH_ALONE = (
    'an axis; or kind = "branch" for what an analysis `cycle` follows by itself, which '
    "`fiv plot SWEEP.nc BRANCH.nc --figure bifurcation` draws into the diagram of a sweep"
)


@dataclass(frozen=True)
class Answers:
    """What figures and claims may speak of: the case's axes, starts and analyses."""

    physics: Physics
    axes: tuple[Axis, ...]
    starts: tuple[StartSpec, ...]
    analyses: tuple[AnalysisSpec, ...]

    def axis_names(self) -> dict[str, str]:
        """Axis -> kind."""
        return {axis.name: axis.kind for axis in self.axes}

    def labels(self) -> list[str]:
        """Labels along ``initial``; random starts, or a table, by what theirs begin with."""
        return [start.label for start in self.starts]

    def has_label(self, value: object) -> bool:
        """Whether `value` is a label, or one of several starts."""
        several = tuple(f"{start.label}-" for start in self.starts if start.kind in SEVERAL)
        return value in self.labels() or str(value).startswith(several)

    def varied_by(self, name: str) -> str:
        """That an analysis looks for values of what is called `name`, if one does; else nothing."""
        names = ((spec.name, spec.settings.get("parameter")) for spec in self.analyses)
        found = [own for own, varied in names if varied is not None and varied.name == name]
        return f": {found[0]!r} varies it, and finds values of it" if found else ""

    def unit(self, name: str) -> str:
        """The unit of an axis of numbers."""
        if name.startswith("initial."):
            return self.physics.units_of_states()[name.removeprefix("initial.")]
        return self.physics.table()[name].unit


def read_figures(
    form: Form, written: Sequence[Mapping[str, Any]], answers: Answers, report: Report
) -> tuple[FigureSpec, ...]:
    """The figures in order, each with a name of its own; `written` is how the case has them."""
    figures: list[FigureSpec] = []
    for index, (table, element) in enumerate(zip(form.figure, written, strict=True)):
        place = ("figure", index)
        refuse_foreign_keys(table, f"a figure of kind {table.kind!r}", place, report)
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


def read_claims(form: Form, answers: Answers, report: Report) -> tuple[ClaimSpec, ...]:
    """The claims in order."""
    return tuple(
        _claim(table, ("claim", index), answers, report) for index, table in enumerate(form.claim)
    )


def _free(name: str, taken: Sequence[str]) -> str:
    """`name`, or `name-2`, `name-3`, ... when it is taken."""
    numbered = (f"{name}-{n}" for n in range(2, len(taken) + 3))
    return next(one for one in (name, *numbered) if one not in taken)


def _check_analysis(name: str | None, answers: Answers, place: Path, report: Report) -> None:
    known = [analysis.name for analysis in answers.analyses]
    if name is not None and name not in known:
        report.unknown((*place, "analysis"), f"there is no analysis named {name!r}", name, known)


def _check_figure_axes(table: FigureTable, answers: Answers, place: Path, report: Report) -> None:
    if table.kind == "bifurcation" and not answers.axes:
        message = "a bifurcation diagram lies over an axis of [grid], and this case has none"
        report.add((*place, "kind"), message, BRANCH_ALONE)
        return
    for key, known in _known_of_axes(table.kind, answers).items():
        name = axis_name(getattr(table, key) or "")
        message = f"a figure of kind {table.kind!r} has no {key} {name!r}"
        if name and name not in known:
            note_no_axis(name, message, (*place, key), known, answers.physics, report)
    for name, axis in _axes_as_levels(table).items():
        if ":" in name and axis not in answers.axis_names():  # of another case; else there is none
            message = f"a line where {axis!r} has a value needs this axis, which the case has not"
            at = (*place, "level", name)
            note_no_axis(axis, message, at, [*answers.axis_names()], answers.physics, report)
    spread = len(answers.axes) + ("initial" in (table.x, table.y))
    if table.kind == "map" and spread < 2:
        over_starts = ' (or of several starts, with y = "initial")' * _has_many(answers)
        report.add(place, f"a map needs a grid of two axes{over_starts}")
    if table.kind == "map" and table.overlay and table.level is None:
        message = "maps are overlaid as lines, and no level says which"
        report.add((*place, "overlay"), message, "level = NUMBER or [NUMBER, ...]")


def _axes_as_levels(table: FigureTable) -> dict[str, str]:
    """Variable -> the axis that stands in place of its level."""
    level = table.level if isinstance(table.level, dict) else {}
    return {name: axis_name(own) for name, own in level.items() if isinstance(own, str)}


def _known_of_axes(kind: str, answers: Answers) -> dict[str, list[str]]:
    """For each of x and y that names an axis in a figure of this kind: what it may be."""
    axes = [axis.name for axis in answers.axes]
    if kind == "map":
        axes += ["initial"] * _has_many(answers)
        return {"x": axes, "y": axes}
    if kind in ("curve", "bifurcation", "eigenvalues", "spectrum"):
        return {"x": axes}
    return {}


def _has_many(answers: Answers) -> bool:
    """Whether there are several starts."""
    return sum(start.size for start in answers.starts) > 1


def _canonical(table: FigureTable, answers: Answers, place: Path, report: Report) -> dict[str, Any]:
    """Names in their contract spelling and the selection in SI."""
    changed: dict[str, Any] = {}
    for key in ("x", "y"):
        value = getattr(table, key)
        if value is not None:
            changed[key] = ascii_name(value)
    if table.select:
        of = [table.variable] if isinstance(table.variable, str) else table.variable or []
        narrows = table.kind == "curve"
        changed["select"] = _selection(
            table.select, answers, (*place, "select"), report, of, narrows=narrows
        )
    if axes := _axes_as_levels(table):
        changed["level"] = {**table.level, **axes}  # type: ignore[dict-item]
    if table.take is not None:
        changed["take"] = _take(table.take, answers, (*place, "take"), report)
    return changed


def _take(
    table: TakeTable, answers: Answers, place: Path, report: Report, elsewhere: bool = False
) -> dict[str, Any]:
    """What is taken, its axes by their contract names and its reference in SI.

    Of a case `elsewhere` they are left as they are, since its axes are its own.
    """
    over = list(map(axis_name, table.over))
    if elsewhere:
        kept = {"of": table.of, "relative_to": dict(table.relative_to or {})}
        return {"what": table.what, "over": over} | {k: one for k, one in kept.items() if one}
    known = [*answers.axis_names(), "initial", *own_dims()]
    for name in [name for name in over if name not in known]:
        message = f"{name!r} is no axis of this case"
        note_no_axis(name, message, (*place, "over"), known, answers.physics, report)
    found: dict[str, Any] = {"what": table.what, "over": [name for name in over if name in known]}
    if table.of is not None:
        found["of"] = table.of
    if table.relative_to:
        at = (*place, "relative_to")
        found["relative_to"] = _selection(table.relative_to, answers, at, report)
    return found


def _selection(
    given: Mapping[str, Any],
    answers: Answers,
    place: Path,
    report: Report,
    of: Sequence[str] = (),
    narrows: bool = False,
) -> dict[str, Any]:
    """Axis -> value in SI, or label, or condition, for the keys that are dims.

    Where it is said `of` which variables, their own dims are named among what is allowed. Where a
    result `narrows` it, what is asked of that is left as it is.
    """
    kinds = dict.fromkeys(own_dims(), "own") | answers.axis_names() | {"initial": "label"}
    found: dict[str, Any] = {}
    for key, value in given.items():
        name, at = axis_name(key), (*place, key)
        if name not in kinds:
            own = dict.fromkeys(dim for one in of for dim in named(one).dims)
            known = [*answers.axis_names(), "initial", *own]
            message = f"{name!r} is no axis of this case{answers.varied_by(name)}"
            if not _is_result(name, answers.physics):
                note_no_axis(name, message, at, known, answers.physics, report)
            elif narrows:
                found[name] = value
            else:
                report.add(at, f"{name!r} is a result, and no axis", listed(known), NARROWS)
        elif isinstance(value, list):
            kept = (_wanted(name, kinds[name], one, answers, at, report) for one in value)
            found[name] = [one for one in kept if one is not None]
        else:
            found[name] = _wanted(name, kinds[name], value, answers, at, report)
    return {name: value for name, value in found.items() if value not in (None, [])}


def _wanted(
    name: str, kind: str, value: Any, answers: Answers, at: Path, report: Report
) -> float | str | None:
    """One value of an axis that is selected; None, and a note, where it is none."""
    if kind == "label" and not answers.has_label(value):
        spelt = str(value).replace(" ", "-")  # figures leave out the hyphen of a table's starts
        hint = f"did you mean {spelt!r}?" if answers.has_label(spelt) else ""
        report.unknown(at, f"there is no start {value!r}", str(value), answers.labels(), hint)
        return None
    try:
        return _selected(name, kind, value, answers)
    except ValueError as error:
        together = f'[sweep] zip = [["{name}", "{value}"]] makes both advance together'
        is_parameter = isinstance(value, str) and value in answers.physics.table()
        meant = together if is_parameter else _condition_meant(str(at[-1]), value)
        report.add(at, str(error), _SELECTS, meant)
        return None


def _is_result(name: str, physics: Physics) -> bool:
    """Whether some analysis gives what is called `name`: a variable, or one of a state."""
    state, _, of_it = name.rpartition("_")
    of_states = f"state_{of_it}" if state in physics.units_of_states() else name
    return not every_variable().keys().isdisjoint((name, of_states))


NARROWS = (
    'to a class a curve narrows itself, and a claim, at = { attractor = "periodic" }; figures and '
    'claims count what has it, take = { what = "share", of = "periodic", over = AXIS }'
)
_SELECTS = (
    'a number, a quantity ("20 rpm"), a condition on the value ".", such as ". >= 7", '
    "or a list of these"
)


def _condition_meant(key: str, value: object) -> str:
    """The condition that was meant by ``">= 7"`` or ``"Omega >= 7"``."""
    meant = f". {str(value).strip().removeprefix(key).strip()}"
    return f'did you mean "{meant}"?' if parse_condition(meant) else ""


def _selected(name: str, kind: str, value: Any, answers: Answers) -> Any:
    if kind == "option":
        return next(o for o in answers.physics.model.options if o.name == name).text(value)
    if kind in ("own", "label", "law") or not isinstance(value, str):
        return value
    if parse_condition(value):
        return value.strip()
    return convert(value, answers.unit(name))


def _claim(table: ClaimTable, place: Path, answers: Answers, report: Report) -> ClaimSpec:
    _check_analysis(table.analysis, answers, place, report)
    return ClaimSpec(
        source=table.source,
        text=table.text,
        variable=table.variable,
        expect=_expected(table, place, answers, report),
        at=_selection(table.at, answers, (*place, "at"), report, [table.variable], narrows=True),
        holds=table.holds,
        note=table.note,
        analysis=table.analysis or "",
        take=_take(table.take, answers, (*place, "take"), report) if table.take else {},
        undecided_counts=table.undecided == "counts",
    )


def _expected(table: ClaimTable, place: Path, answers: Answers, report: Report) -> Expected:
    """What is expected, with all that is left out of what it is compared with."""
    if not isinstance(table.expect, Bounds):
        return table.expect
    bounds, found = table.expect, {}
    for key, one in bounds.references.items():
        found[key] = _reference(one, table, (*place, "expect", key), answers, report)
    least = found.get("value", found.get("greater_than", bounds.least))
    greatest = found.get("value", found.get("less_than", bounds.greatest))
    return replace(bounds, least=least, greatest=greatest)


def _reference(
    said: Reference, claim: ClaimTable, place: Path, answers: Answers, report: Report
) -> Reference:
    """A reference in the contract's names; axes and values of another case are its own."""
    variable, take, at = said.variable or claim.variable, said.take, dict(said.at)
    analysis = said.analysis or (claim.analysis or "") * (variable == claim.variable)
    if not said.case:
        _check_analysis(analysis or None, answers, place, report)
        at = _selection(at, answers, (*place, "at"), report, [variable])
    if take is not None:
        form = read_table(TakeTable, take, (*place, "take"), report)
    else:
        form = claim.take if variable == claim.variable else None
    elsewhere = bool(said.case)
    taken = _take(form, answers, (*place, "take"), report, elsewhere) if form else {}
    return replace(said, variable=variable, analysis=analysis, at=at, take=taken)
