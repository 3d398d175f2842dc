"""The tables ``[[analysis]]``: what is computed, with every setting filled in."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from fiv_cli.analyses import all_analyses
from fiv_cli.analyses.base import Analysis
from fiv_cli.analyses.catalogue import variables_of
from fiv_cli.analyses.settings import ParameterName, Refusal, read_settings
from fiv_cli.case.case import AnalysisSpec, Axis
from fiv_cli.case.physics import Physics
from fiv_cli.case.report import Path, Report
from fiv_cli.case.structure import AnalysisTable
from fiv_cli.case.tables import read_tables
from fiv_cli.notation.names import ascii_name, listed, nearest, suggest

_NAME = re.compile(r"[A-Za-z][A-Za-z0-9_-]*")


@dataclass(frozen=True)
class Surroundings(Physics):
    """The case as a setting of one of its analyses knows it (see `settings.Known`).

    Attributes
    ----------
    axes : names of the axes of the grid
    varied : the parameter that the analysis itself varies, as written; "" where there is none
    """

    axes: tuple[str, ...] = ()
    varied: str = ""

    def followers(self, leader: str) -> tuple[str, ...]:
        """Parameters whose value is that of `leader`, because nothing else gives them one."""
        given = {key.split(".")[-1] for key in self.fixed} | {*self.axes}
        table = self.table().values()
        return tuple(p.name for p in table if p.default_from == leader and p.name not in given)

    def value(self, name: str) -> float | None:
        """The value of a parameter, SI; None where it varies."""
        if name in (*self.axes, ascii_name(self.varied)):
            return None
        return self.fixed.get(name, self.default(name))

    def numbers(self) -> list[str]:
        """The variables of a `response` that are one number at each point."""
        held = variables_of("response", self.model, self.options, {})
        return [variable.name for variable in held if variable.askable]


def read_analyses(
    raw: Mapping[str, Any], physics: Physics | None, axes: Sequence[Axis], report: Report
) -> tuple[AnalysisSpec, ...]:
    """The analyses in order; settings that need the model are checked when there is one."""
    tables = read_tables(AnalysisTable, raw.get("analysis", []), ("analysis",), report)
    if not raw.get("analysis"):
        kinds = listed(all_analyses())
        report.add(("analysis",), "a case has one [[analysis]] at least", f"kind = {kinds}")
    specs = []
    written = raw.get("analysis", [])
    if not isinstance(written, list) or len(tables) != len(written):
        report.unsure_of("analyses")
    for place, _, table in tables:
        spec = _analysis(table, place, physics, axes, report)
        if spec is not None:
            specs.append(spec)
            _check_name(spec, specs[:-1], place, report)
        else:
            report.unsure_of("analyses")
    return tuple(specs)


def _check_name(
    spec: AnalysisSpec, others: Sequence[AnalysisSpec], place: Path, report: Report
) -> None:
    if not _NAME.fullmatch(spec.name):
        report.add((*place, "name"), f"{spec.name!r} is no name", "letters, digits, _ and -")
    if spec.name in [other.name for other in others]:
        report.add((*place, "name"), f"the name {spec.name!r} is taken", "unique names")


def _analysis(
    table: AnalysisTable,
    place: Path,
    physics: Physics | None,
    axes: Sequence[Axis],
    report: Report,
) -> AnalysisSpec | None:
    analyses = all_analyses()
    analysis = _named(table.kind, (*place, "kind"), report)
    if analysis is None:
        return None
    unsuited = "" if physics is None else analysis.unsuited(physics.model)
    if physics is not None and unsuited:
        suited = [kind for kind, one in analyses.items() if not one.unsuited(physics.model)]
        report.add((*place, "kind"), unsuited, listed(suited))
        return None
    given = dict(table.model_extra or {})
    known = None if physics is None else _surroundings(physics, axes, given.get("parameter"))
    whose = f"the analysis {analysis.kind!r}"
    found = read_settings(analysis.settings, given, known, whose)
    for refusal in found.refusals:
        _note(refusal, analysis, place, report)
    return AnalysisSpec(table.name or analysis.kind, analysis.kind, found.value)


def _surroundings(physics: Physics, axes: Sequence[Axis], varied: object) -> Surroundings:
    names = tuple(axis.name for axis in axes)
    return Surroundings(
        **vars(physics), axes=names, varied=varied if isinstance(varied, str) else ""
    )


def _note(refusal: Refusal, analysis: Analysis, place: Path, report: Report) -> None:
    """Note what is wrong with a setting, unless it only follows from a name that was misread."""
    key = refusal.place[0]
    setting = next((one for one in analysis.settings if one.name == key), None)
    if setting is None:
        report.unsure_of("analyses")  # it may have been the name
    if isinstance(setting, ParameterName):
        report.unsure_of("parameters")
    if report.is_sure_of(*refusal.follows):
        where = (*place, *refusal.place)
        report.add(where, refusal.message, refusal.allowed, refusal.suggestion)


def _named(kind: str, place: Path, report: Report) -> Analysis | None:
    """The analysis of a kind; where that is misspelt the one it resembles, so as to check more."""
    titles = {name: analysis.title for name, analysis in all_analyses().items()}
    if kind not in titles:
        message = f"there is no analysis {kind!r}"
        report.add(place, message, listed(titles), suggest(kind, titles))
        report.unsure_of("analyses")
    return all_analyses().get(kind if kind in titles else nearest(kind, titles) or "")
