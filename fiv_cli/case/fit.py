"""What is right in itself and does not fit together: the last thing that is told of a case."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence

from fiv_cli.analyses import get_analysis
from fiv_cli.analyses.base import requirements
from fiv_cli.case.case import AnalysisSpec, Axis, Case, StartSpec
from fiv_cli.case.form import Form
from fiv_cli.case.grid import MOST_POINTS, count_points
from fiv_cli.case.physics import Physics
from fiv_cli.case.refinement import refuse_along_chains
from fiv_cli.case.report import Report
from fiv_cli.case.schedule import refuse_unsuited_analyses
from fiv_cli.friction.base import Law
from fiv_cli.models.base import Model, Requirement
from fiv_cli.notation.names import listed


def refuse_what_does_not_fit(case: Case, form: Form, physics: Physics, report: Report) -> None:
    """Note analyses, starts, axes and parameters that exclude one another."""
    _refuse_unused_start_axes(case.axes, case.analyses, report)
    _refuse_needless_chains(case.analyses, case.starts, report)
    _refuse_endless_transients(case.analyses, report)
    _refuse_branches_from_elsewhere(case, physics, report)
    refuse_along_chains(case.refinement, case.starts, report)
    refuse_unsuited_analyses(form, case.schedule, case.analyses, report)
    _refuse_too_many_runs(case.axes, case.zips, case.starts, report)
    _refuse_unmet_requirements(case, form, physics, report)


def _refuse_unused_start_axes(
    axes: Sequence[Axis], analyses: Sequence[AnalysisSpec], report: Report
) -> None:
    if any(get_analysis(analysis.kind).uses_starts for analysis in analyses):
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
                'starts of kind "equilibrium", "state", "random" or "table"',
                'give it a case of its own; follow = "up" | "down" follows a branch in the bracket',
            )


def _refuse_endless_transients(analyses: Sequence[AnalysisSpec], report: Report) -> None:
    """A steady state is looked for after the transient, and before the time is up."""
    for index, analysis in enumerate(analyses):
        transient, t_max = (analysis.settings.get(name) for name in ("transient", "t_max"))
        if transient is not None and t_max is not None and transient >= t_max:
            place = ("analysis", index, "transient")
            message = f"{transient:g} s leave nothing of t_max = {t_max:g} s"
            report.add(place, message, f"less than {t_max:g} s; or raise t_max")


def _refuse_branches_from_elsewhere(case: Case, physics: Physics, report: Report) -> None:
    """Where a bracket may be left out, the branch in it is followed from the case's own value."""
    law = physics.laws[0]
    for index, spec in enumerate(case.analyses):
        required = {one.name for one in get_analysis(spec.kind).settings if one.required}
        if "bracket" in required or not spec.settings.get("bracket"):
            continue
        name, (low, high) = spec.settings["parameter"].name, spec.settings["bracket"]
        own = case.parameters_at(law.name, {}).get(name)
        if own is not None and not low <= own <= high:
            of_law = name in (parameter.name for parameter in law.parameters)
            table = "friction" if of_law else "model.parameters"
            of_whom = "the case's own" if name in case.explicit else "the default"
            report.add(
                ("analysis", index, "bracket"),
                f"the branch is followed both ways from {name} = {own!r}, "
                f"{of_whom}, which lies outside",
                f"a bracket that holds it; or {name} between {low!r} and {high!r} in [{table}]",
            )


def _refuse_too_many_runs(
    axes: Sequence[Axis],
    zips: Sequence[Sequence[str]],
    starts: Sequence[StartSpec],
    report: Report,
) -> None:
    """Random starts, and those of a table, multiply the points of the grid."""
    labels = sum(start.size for start in starts)
    points = count_points({axis.name: len(axis.values) for axis in axes}, zips)
    if labels > 1 and labels * points > MOST_POINTS:
        message = f"{labels:,} starts of {points:,} points are {labels * points:,} runs"
        report.add(("initial",), message, f"at most {MOST_POINTS:,}")


def _refuse_unmet_requirements(case: Case, form: Form, physics: Physics, report: Report) -> None:
    """Note parameters that are not to one another what the model and its laws require.

    Those of an axis are left to the plan, which counts the points; those that were given and
    could not be read are told already.
    """
    linear = all(get_analysis(analysis.kind).linear for analysis in case.analyses)
    for law in physics.laws:
        for values in _in_time(case, law, physics):
            requirement = _unmet(physics.model, law, values, linear)
            if requirement is not None:
                _note_unmet(requirement, values, case, form, report)
                return


def _note_unmet(
    requirement: Requirement,
    values: Mapping[str, float],
    case: Case,
    form: Form,
    report: Report,
) -> None:
    given = [name for name in requirement.reads if name in (*case.explicit, *case.schedule.names)]
    left = [name for name in requirement.reads if name not in given]
    shown = ", ".join(f"{name} = {values[name]!r}" for name in requirement.reads)
    curves = [entry.place for entry in form.schedule if entry.name in given]
    fixed = [place for name in given for place in form.places_of(name)]
    report.add(
        next(iter([*curves, *fixed]), ("friction",)),
        f"{shown}: {requirement.fault}",
        requirement.rule + (" in an analysis in time" if requirement.in_motion else ""),
        f"not given, so its default stands: {listed(left)}" if given and left else "",
    )


def _unmet(model: Model, law: Law, values: Mapping[str, float], linear: bool) -> Requirement | None:
    """The first requirement that these parameters do not meet; some may be left to the point."""
    complete = (r for r in requirements(model, law, linear) if values.keys() >= set(r.reads))
    return next((r for r in complete if not r.holds(values)), None)


def _in_time(case: Case, law: Law, physics: Physics) -> Iterable[dict[str, float]]:
    """The fixed parameters at the start and wherever a schedule has a kink.

    Of one that an analysis in time varies itself, an end of the bracket where it may be.
    """
    complete = case.parameters_at(law.name, {}).items()
    values = {name: value for name, value in complete if name not in physics.unread}
    for spec in case.analyses:
        varied, bracket = spec.settings.get("parameter"), spec.settings.get("bracket")
        if varied is not None and bracket is not None and not get_analysis(spec.kind).linear:
            ends = [varied.at(values, end) for end in bracket]
            values = next(
                (end for end in ends if not _unmet(physics.model, law, end, False)), ends[0]
            )
    return ({**values, **case.schedule.values(time)} for time in case.schedule.instants)
