"""The tables ``[[analysis]]``: what is computed, with every setting filled in."""

from __future__ import annotations

import json
import re
from collections.abc import Sequence
from dataclasses import dataclass

from fiv_cli.analyses import all_analyses
from fiv_cli.analyses.base import Analysis
from fiv_cli.analyses.catalogue import variables_of
from fiv_cli.analyses.settings import read_settings
from fiv_cli.analyses.variables import derived
from fiv_cli.case.case import AnalysisSpec, Axis
from fiv_cli.case.form import Form
from fiv_cli.case.physics import Physics, counterpart
from fiv_cli.case.report import Path, Report
from fiv_cli.case.structure import AnalysisTable
from fiv_cli.case.words import setting_meant
from fiv_cli.models.base import leaders
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
        found = leaders(self.table().values(), {*self.given, *self.axes})
        return tuple(name for name, other in found.items() if other == leader)

    def value(self, name: str) -> float | None:
        """The value of a parameter, SI; None where it varies, or could not be read."""
        if name in (*self.axes, *self.unread, ascii_name(self.varied)):
            return None
        return self.fixed.get(name, self.default(name))

    def numbers(self, along: str = "") -> list[str]:
        """The variables of a `response` that are one number at each point, or each of `along`."""
        held = variables_of("response", self.model, self.options, {"powers": "mean"})
        return [one.name for one in (*held, *derived(held)) if one.askable and one.along == along]


def read_analyses(
    form: Form, physics: Physics, axes: Sequence[Axis], report: Report
) -> tuple[AnalysisSpec, ...]:
    """The analyses in order, with every setting."""
    specs: list[AnalysisSpec] = []
    for index, table in enumerate(form.analysis):
        place = ("analysis", index)
        spec = _analysis(table, place, physics, axes, report)
        _check_name(spec, specs, place, report)
        specs.append(spec)
    return tuple(specs)


def _check_name(
    spec: AnalysisSpec, others: Sequence[AnalysisSpec], place: Path, report: Report
) -> None:
    if not _NAME.fullmatch(spec.name):
        report.add((*place, "name"), f"{spec.name!r} is no name", "letters, digits, _ and -")
    if spec.name in [other.name for other in others]:
        report.add((*place, "name"), f"the name {spec.name!r} is taken", "unique names")


def _analysis(
    table: AnalysisTable, place: Path, physics: Physics, axes: Sequence[Axis], report: Report
) -> AnalysisSpec:
    analyses = all_analyses()
    analysis = analyses[table.kind]
    name, model = table.name or analysis.kind, physics.model
    if analysis.unsuited(model):
        suited = [kind for kind, one in analyses.items() if not one.unsuited(model)]
        report.add((*place, "kind"), analysis.unsuited(model), listed(suited), of_name=True)
        return AnalysisSpec(name, analysis.kind, analysis.default_settings)
    given = table.model_extra or {}
    known = _surroundings(physics, axes, given.get("parameter"))
    settings = analysis.default_settings
    found = read_settings(analysis.settings, given, known, f"the analysis {analysis.kind!r}")
    for one in found.refusals:
        named = given.get("parameter") if one.of_name and one.place == ("parameter",) else None
        hint = counterpart(str(named), known.varying())
        key = str(one.place[0])
        elsewhere = any(key in other.default_settings for other in analyses.values())
        hint = hint or (setting_meant(key, settings) if one.of_key and not elsewhere else "")
        hint = hint or one.suggestion
        hint = hint or _where_it_belongs(key, analysis)
        at = (*place, *one.place)
        report.add(at, one.message, one.allowed, hint, one.of_name, one.of_key, one.relates)
    return AnalysisSpec(name, analysis.kind, found.value)


def _where_it_belongs(key: str, analysis: Analysis) -> str:
    """Where a setting belongs that the analysis does not have."""
    if key in analysis.default_settings:
        return ""
    others = {kind: other.default_settings for kind, other in all_analyses().items()}
    meant = nearest(key, sorted({name for settings in others.values() for name in settings}))
    kinds = [kind for kind, settings in others.items() if meant in settings]
    kinds = [kind for kind in kinds if kind == analysis.counterpart] or kinds
    belongs = f"{meant!r} belongs to kind = {' or '.join(map(json.dumps, kinds))}"
    return belongs if kinds else suggest(key, {"name": "of the analysis"})


def _surroundings(physics: Physics, axes: Sequence[Axis], varied: object) -> Surroundings:
    names = tuple(axis.name for axis in axes)
    return Surroundings(
        **vars(physics), axes=names, varied=varied if isinstance(varied, str) else ""
    )
