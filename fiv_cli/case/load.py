"""From a TOML text to a `Case`, or to one error that lists everything wrong in it."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path as FilePath
from typing import Any

from fiv_cli.analyses import get_analysis
from fiv_cli.analyses.base import requirements
from fiv_cli.case.analysis import read_analyses
from fiv_cli.case.case import AnalysisSpec, Axis, Case, StartSpec
from fiv_cli.case.grid import MOST_POINTS, Grid, count_points, read_grid, refuse_fixed_axes
from fiv_cli.case.lines import locate
from fiv_cli.case.overrides import apply_overrides, parse_override
from fiv_cli.case.physics import Physics, read_physics
from fiv_cli.case.refinement import refuse_chains
from fiv_cli.case.report import Path, Report
from fiv_cli.case.results import Answers, read_claims, read_figures
from fiv_cli.case.schedule import at_the_start, read_schedule, refuse_unsuited_analyses
from fiv_cli.case.solver import read_solver
from fiv_cli.case.starts import read_starts
from fiv_cli.case.structure import CaseTable, HeaderTable
from fiv_cli.case.tables import keys_of, read_table
from fiv_cli.case.toml import MOST_BYTES, TooMuchError, parse_toml, too_large
from fiv_cli.errors import CaseError, Problem, UsageError
from fiv_cli.friction.base import Law
from fiv_cli.models import get_model
from fiv_cli.models.base import Model, Parameter, Requirement
from fiv_cli.notation.names import listed, nearest, suggest
from fiv_cli.schedule import STEADY

# What decides which variables there will be.
DECIDE_VARIABLES = ("analyses", "axes", "law", "options")

_AT_LINE = re.compile(r" \(at (?:line (\d+), column (\d+)|end of document)\)$")


def load_case(path: str | FilePath, overrides: Sequence[str] = ()) -> Case:
    """Read the case file at `path` and apply ``--set`` lines.

    Raises
    ------
    UsageError
        There is no readable file at `path`, or an override is malformed.
    CaseError
        The file, or an override, is invalid; holds every problem found.
    """
    source = str(path)
    return parse_case(_read(source), source, overrides)


def parse_case(text: str, source: str, overrides: Sequence[str] = ()) -> Case:
    """The case that `text` means; errors as `load_case`, naming `source`."""
    parsed = [parse_override(override) for override in overrides]
    try:
        document, places, unplaced = apply_overrides(_toml(text, source), parsed)
    except RecursionError:  # of paths of --set, which are no text of the case
        raise CaseError(source, [Problem("case", "tables or lists nest too deeply")]) from None
    report = Report(source, locate(text), places)
    report.add_problems(unplaced)
    case = _build(document, report, source, text, tuple(overrides))
    report.raise_if_any(case if report.is_sure_of(*DECIDE_VARIABLES) else None)
    if case is None:
        raise AssertionError("a case without problems was not built")
    return case


def _read(source: str) -> str:
    try:
        with FilePath(source).open("rb") as file:
            content = file.read(MOST_BYTES + 1)
        if len(content) > MOST_BYTES:
            raise _too_much(source, too_large(len(content)))
        return content.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        line = error.object[: error.start].count(b"\n") + 1
        problem = Problem("case", "is not UTF-8 text", "a TOML file in UTF-8", line=line)
        raise CaseError(source, [problem]) from None
    except FileNotFoundError:
        raise UsageError(f"{source}: there is no such file{_nearby(source)}") from None
    except IsADirectoryError:
        raise UsageError(
            f"{source} is a folder, not a case file\nnext: name a file in it, e.g. {source}/*.toml"
        ) from None
    except (OSError, ValueError) as error:
        raise UsageError(f"{source}: cannot be read: {error}") from None


def _nearby(source: str) -> str:
    """What may have been meant instead of a missing file."""
    path = FilePath(source)
    siblings = [str(other) for other in path.parent.glob("*.toml")] if path.parent.is_dir() else []
    hint = suggest(source, sorted(siblings))
    return f"\nnext: {hint}" if hint else "\nnext: check the path; `fiv new MODEL` writes a case"


def _toml(text: str, source: str) -> dict[str, Any]:
    try:
        return parse_toml(text)
    except TooMuchError as error:
        raise _too_much(source, error) from None
    except ValueError as error:  # TOMLDecodeError, or an integer too long to read
        raise CaseError(source, [_syntax_problem(str(error), text)]) from None


def _too_much(source: str, error: TooMuchError) -> CaseError:
    return CaseError(source, [Problem("case", error.message, error.allowed, line=error.line)])


def _syntax_problem(message: str, text: str) -> Problem:
    match = _AT_LINE.search(message)
    what = f"invalid TOML: {_AT_LINE.sub('', message)}"
    if match is None:
        return Problem("case", what)
    if match[1] is None:
        return Problem("case", f"{what} at the end of the file", line=text.count("\n") + 1)
    return Problem("case", what, line=int(match[1]), column=int(match[2]))


def _build(
    raw: Mapping[str, Any], report: Report, source: str, text: str, overrides: tuple[str, ...]
) -> Case | None:
    """The case, as far as it can be understood; every problem goes to `report`."""
    raw = _meant(raw, report)
    header = _header(raw, report)
    physics = read_physics(raw, report)
    grid = Grid() if physics is None else read_grid(raw, physics, report)
    axes, zips = grid.axes, grid.zips
    refuse_fixed_axes(raw, axes, report)
    analyses = read_analyses(raw, physics, axes, report)
    starts = () if physics is None else read_starts(raw, physics, axes, report)
    if physics is None:
        report.unsure_of("starts")
    schedule = STEADY if physics is None else read_schedule(raw, physics, axes, report)
    answers = Answers(physics, axes, starts, analyses)
    figures, claims = read_figures(raw, answers, report), read_claims(raw, answers, report)
    solver = read_solver(raw, report)
    if physics is None or header is None:
        return None
    _refuse_unused_start_axes(axes, analyses, report)
    _refuse_needless_chains(analyses, starts, report)
    refuse_chains(grid.refinement, starts, report)
    refuse_unsuited_analyses(raw, schedule, analyses, report)
    physics = at_the_start(physics, schedule)
    _refuse_too_many_runs(axes, zips, starts, report)
    parameters = _fixed_parameters(physics, axes)
    case = Case(
        source=source,
        text=text,
        overrides=overrides,
        title=header.title,
        reference=header.reference,
        assumed=tuple(header.assumed),
        model=physics.model.name,
        options=physics.options,
        law=physics.laws[0].name,
        parameters=parameters,
        explicit=tuple(physics.fixed),
        axes=axes,
        zips=zips,
        starts=starts,
        analyses=analyses,
        figures=figures,
        claims=claims,
        solver=solver,
        refinement=grid.refinement,
        schedule=schedule,
    )
    if report.is_sure_of("law", "parameters", "axes"):
        _refuse_what_does_not_fit(case, physics, raw, report)
    return case


def _meant(raw: Mapping[str, Any], report: Report) -> dict[str, Any]:
    """The tables and keys under their names; a misspelt one is noted, and read as what it meant."""
    known = keys_of(CaseTable)
    found: dict[str, Any] = {key: value for key, value in raw.items() if key in known}
    for key in [key for key in raw if key not in known]:
        report.add((key,), f"unknown table or key {key!r}", listed(known), suggest(key, known))
        meant = nearest(key, known)
        if meant is not None and meant not in found:
            found[meant] = raw[key]
            report.rename(key, meant)
    return found


def _header(raw: Mapping[str, Any], report: Report) -> HeaderTable | None:
    """The keys above the first table."""
    if "model" not in raw:
        report.add(("model",), "is missing", "the table [model] with its name")
    own = {key: raw[key] for key in keys_of(HeaderTable) if key in raw}
    return read_table(HeaderTable, own, (), report)


def _fixed_parameters(physics: Physics, axes: Sequence[Axis]) -> dict[str, float]:
    """Every parameter that is no axis: as given, or its default.

    A parameter that follows an axis (`default_from`) is left to the point. Where several laws
    are in use and give a parameter different values, it is kept by law, as ``LAW.NAME``.
    """
    varied = {axis.name for axis in axes}
    by_law = {law.name: _values_under(physics, law) for law in physics.laws}
    found = _values(physics, "", physics.model.parameters)
    for law, values in by_law.items():
        for name, value in values.items():
            agreed = all(other.get(name, value) == value for other in by_law.values())
            found[name if agreed else f"{law}.{name}"] = value
    return {key: value for key, value in found.items() if key.split(".")[-1] not in varied}


def _values_under(physics: Physics, law: Law) -> dict[str, float]:
    return _values(physics, f"{law.name}.", physics.model.adopted(law.parameters))


def _values(physics: Physics, prefix: str, table: Sequence[Parameter]) -> dict[str, float]:
    """The values of the parameters of one table, what is given for one law going first."""
    found = {}
    for parameter in table:
        shared = physics.fixed.get(parameter.name, parameter.default)
        value = physics.fixed.get(prefix + parameter.name, shared)
        if value is not None:
            found[parameter.name] = value
    return found


def _refuse_unused_start_axes(
    axes: Sequence[Axis], analyses: Sequence[AnalysisSpec], report: Report
) -> None:
    used = any(get_analysis(analysis.kind).uses_starts for analysis in analyses)
    if used or not report.is_sure_of("analyses"):
        return
    for axis in axes:
        if axis.kind == "start":
            report.add(("grid", axis.name), "no analysis of this case has a start to vary")


def _refuse_needless_chains(
    analyses: Sequence[AnalysisSpec], starts: Sequence[StartSpec], report: Report
) -> None:
    """Some analyses follow a branch by themselves; their points do not continue from others."""
    followed = [start.label for start in starts if start.kind == "continue"]
    for index, analysis in enumerate(analyses):
        if followed and not get_analysis(analysis.kind).chains:
            report.add(
                ("analysis", index),
                f"{analysis.kind!r} cannot begin at the neighbour's end (start {followed[0]!r})",
                'starts of kind "equilibrium", "state" or "random"',
                'give it a case of its own; follow = "up" | "down" follows a branch in the bracket',
            )


def _refuse_too_many_runs(
    axes: Sequence[Axis],
    zips: Sequence[Sequence[str]],
    starts: Sequence[StartSpec],
    report: Report,
) -> None:
    """Random starts multiply the points of the grid."""
    labels = sum(start.count if start.kind == "random" else 1 for start in starts)
    points = count_points({axis.name: len(axis.values) for axis in axes}, zips)
    if labels > 1 and labels * points > MOST_POINTS:
        message = f"{labels:,} starts of {points:,} points are {labels * points:,} runs"
        report.add(("initial",), message, f"at most {MOST_POINTS:,}")


def _refuse_what_does_not_fit(
    case: Case, physics: Physics, raw: Mapping[str, Any], report: Report
) -> None:
    """Note parameters that are not to one another what the model and its laws require.

    Those of an axis are left to the plan, which counts the points.
    """
    linear = all(get_analysis(analysis.kind).linear for analysis in case.analyses)
    for law in physics.laws:
        for values in _in_time(case, law):
            requirement = _unmet(physics.model, law, values, linear)
            if requirement is not None:
                _note_unmet(requirement, values, case, raw, report)
                return


def _note_unmet(
    requirement: Requirement,
    values: Mapping[str, float],
    case: Case,
    raw: Mapping[str, Any],
    report: Report,
) -> None:
    given = [name for name in requirement.reads if name in (*case.explicit, *case.schedule.names)]
    left = [name for name in requirement.reads if name not in given]
    shown = ", ".join(f"{name} = {values[name]!r}" for name in requirement.reads)
    report.add(
        _place_of((given or left)[0], raw),
        f"{shown}: {requirement.fault}",
        requirement.rule + (" in an analysis in time" if requirement.in_motion else ""),
        f"not given, so its default stands: {listed(left)}" if given and left else "",
    )


def _unmet(model: Model, law: Law, values: Mapping[str, float], linear: bool) -> Requirement | None:
    """The first requirement that these parameters do not meet; some may be left to the point."""
    complete = (r for r in requirements(model, law, linear) if values.keys() >= set(r.reads))
    return next((r for r in complete if not r.holds(values)), None)


def _in_time(case: Case, law: Law) -> Iterable[dict[str, float]]:
    """The fixed parameters at the start and wherever a schedule has a kink.

    Of one that an analysis in time varies itself, an end of the bracket where it may be.
    """
    values = case.parameters_at(law.name, {})
    model = get_model(case.model)
    for spec in case.analyses:
        varied, bracket = spec.settings.get("parameter"), spec.settings.get("bracket")
        if varied is not None and bracket is not None and not get_analysis(spec.kind).linear:
            ends = [varied.at(values, end) for end in bracket]
            values = next((end for end in ends if not _unmet(model, law, end, False)), ends[0])
    return ({**values, **case.schedule.values(time)} for time in case.schedule.instants)


def _place_of(name: str, raw: Mapping[str, Any]) -> Path:
    """Where a case gives a parameter, for messages."""
    if name in raw.get("schedule", {}):
        return "schedule", name
    model = raw.get("model", {}).get("parameters", {})
    return ("model", "parameters", name) if name in model else ("friction", name)
