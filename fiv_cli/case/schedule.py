"""The table ``[schedule]``: parameters that vary in time."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import replace

from fiv_cli.analyses import all_analyses, get_analysis
from fiv_cli.case.case import AnalysisSpec, Axis
from fiv_cli.case.form import Form
from fiv_cli.case.physics import Physics
from fiv_cli.case.report import Path, Report
from fiv_cli.case.structure import CurveTable
from fiv_cli.friction.surface import on_surface
from fiv_cli.models.base import Forcing, Parameter, leaders
from fiv_cli.models.excitation import frequency_of
from fiv_cli.notation.names import listed
from fiv_cli.notation.units import convert
from fiv_cli.notation.values import check_quantity
from fiv_cli.schedule import STEADY, Points, Schedule, make_schedule

_FORMS = "{ start, stop, over }, { points = [[time, value], ...] } or { mean, amplitude, omega }"


def read_schedule(form: Form, physics: Physics, axes: Sequence[Axis], report: Report) -> Schedule:
    """What varies in time, with every parameter that follows one of them."""
    curves: dict[str, Points] = {}
    for name, place, table in form.schedule:
        if table.is_harmonic:
            continue
        if name in curves:
            report.add(place, f"the schedule of {name!r} is given twice")
        elif may_vary(name, place, physics, report) and not _clashes(
            name, place, form, axes, report
        ):
            points = _points(physics.table()[name], table, place, report)
            if points is not None:
                curves[name] = points
    if not curves:
        return STEADY
    curves |= _following(curves, physics, axes)
    _refuse_phases(curves, physics, axes, report)
    _refuse_surfaces(curves, physics, report)
    refuse_sectors(curves, physics, report)
    return make_schedule(curves)


def at_the_start(physics: Physics, schedule: Schedule) -> Physics:
    """`physics` with what varies in time fixed at its value at t = 0."""
    names = set(schedule.names)
    kept = {key: v for key, v in physics.fixed.items() if key.split(".")[-1] not in names}
    return replace(physics, fixed=kept | schedule.values(0.0))


def refuse_unsuited_analyses(
    form: Form, schedule: Schedule, analyses: Sequence[AnalysisSpec], report: Report
) -> None:
    """Steady states, equilibria and eigenvalues belong to constant parameters, others do not."""
    names = listed(schedule.names)
    for index, spec in enumerate(analyses):
        analysis = get_analysis(spec.kind)
        meant = f'kind = "{analysis.counterpart}"' if analysis.counterpart else ""
        if schedule.curves and not analysis.varying:
            able = [kind for kind, other in all_analyses().items() if other.varying]
            report.add(
                ("analysis", index),
                f"{spec.kind!r} belongs to constant parameters, but {names} varies in time",
                f"analyses of kind {listed(able)}",
                meant
                or f"give it a case of its own without [schedule], with {names} fixed or an axis",
            )
        elif all(one.value.is_harmonic for one in form.schedule) and not analysis.constant:
            report.add(
                ("analysis", index),
                f"{spec.kind!r} belongs to parameters that vary, but there is no [schedule]",
                "parameters under [schedule]",
                f'{meant} is of a steady state; a [[figure]] of kind "spectrogram" transforms a '
                "history window by window",
            )


def may_vary(name: str, place: Path, physics: Physics, report: Report) -> bool:
    """Whether a schedule of `name` makes sense; notes why it does not."""
    known = physics.varying()
    if name not in physics.table():
        meanings = {key: parameter.meaning for key, parameter in known.items()}
        report.unknown(place, f"there is no parameter {name!r} to vary in time", name, meanings)
        return False
    derived = physics.model.derived
    sources = () if derived is None else derived.sources
    free = [other for other in known if other not in sources]
    if name not in free:
        report.add(place, _why_not(name, sources, physics), listed(free))
    return name in free


def _clashes(name: str, place: Path, form: Form, axes: Sequence[Axis], report: Report) -> bool:
    """Whether something else gives what varies a value; notes what does."""
    clashes = [".".join(map(str, where)) for where in form.places_of(name)]
    clashes += [f"grid.{axis.name}, as an axis" for axis in axes if axis.name == name]
    for shown in clashes:
        message = f"{name!r} varies in time and is also given by {shown}"
        report.add(place, message, "one of the two", "its schedule also says where it starts")
    return bool(clashes)


def _why_not(name: str, sources: Collection[str], physics: Physics) -> str:
    if name in sources:
        return f"the modes of the plate depend on {name!r}: it cannot vary in time"
    if any(name in law.structural for law in physics.laws):
        return f"{name!r} is part of the form of the law: it cannot vary in time"
    return f"{name!r} cannot vary in time (it counts, or not every law in use has it)"


def _points(parameter: Parameter, table: CurveTable, place: Path, report: Report) -> Points | None:
    """The curve as (time, value) in SI; None and a note where it is not sound."""
    if table.model_fields_set == {"points"}:
        return _listed(parameter, table.points or [], place, report)
    if table.model_fields_set == {"start", "stop", "over"}:
        return _ramp(parameter, table, place, report)
    report.add(place, "is neither a ramp nor a list of points, nor harmonic", _FORMS)
    return None


def _ramp(parameter: Parameter, table: CurveTable, place: Path, report: Report) -> Points | None:
    start = _value(parameter, table.start, (*place, "start"), report)
    stop = _value(parameter, table.stop, (*place, "stop"), report)
    over = _time(table.over, (*place, "over"), report)
    if start is None or stop is None or over is None:
        return None
    if over <= 0.0:
        report.add((*place, "over"), f"{over!r} is out of range", "a time in s, > 0")
        return None
    return (0.0, start), (over, stop)


def _listed(
    parameter: Parameter, pairs: Sequence[Sequence[object]], place: Path, report: Report
) -> Points | None:
    found: list[tuple[float, float]] = []
    for index, pair in enumerate(pairs):
        here = (*place, "points", index)
        if len(pair) != 2:
            report.add(here, f"a point has a time and a value, not {len(pair)} numbers", _FORMS)
            return None
        time = _time(pair[0], here, report)
        value = _value(parameter, pair[1], here, report)
        if time is None or value is None:
            return None
        if found and time <= found[-1][0]:
            report.add(here, f"its time {time!r} does not rise", "rising times, in s")
            return None
        found.append((time, value))
    if not found:
        report.add((*place, "points"), "a schedule has one point at least", _FORMS)
    return tuple(found) or None


def _value(parameter: Parameter, value: object, place: Path, report: Report) -> float | None:
    with report.noting(place, parameter.allowed):
        return parameter.read(value)
    return None


def _time(value: object, place: Path, report: Report) -> float | None:
    with report.noting(place, "a time in s"):
        return convert(check_quantity(value), "s")
    return None


def _following(
    curves: Mapping[str, Points], physics: Physics, axes: Sequence[Axis]
) -> dict[str, Points]:
    """Parameters whose value is that of one that varies, because nothing else gives them one."""
    given = {*physics.given, *curves, *(axis.name for axis in axes)}
    found = leaders(physics.table().values(), given)
    return {name: curves[leader] for name, leader in found.items() if leader in curves}


# --- phases ---------------------------------------------------------------------------------------
def _refuse_phases(
    curves: Mapping[str, Points], physics: Physics, axes: Sequence[Axis], report: Report
) -> None:
    """A phase is frequency times time: of a frequency that varies it would be wrong."""
    for forcing in physics.model.forcings:
        if forcing.amplitude in curves or _is_on(forcing, physics, axes):
            for name in sorted(curves.keys() & {*frequency_of(forcing)}):
                report.add(
                    ("schedule", name),
                    f"the {forcing.meaning} has a phase that depends on {name!r}: "
                    "it cannot vary in time",
                    suggestion=f"switch it off ({forcing.amplitude} = 0)",
                )


def _refuse_surfaces(curves: Mapping[str, Points], physics: Physics, report: Report) -> None:
    """How far surfaces have slid has no formula while their drive ramps."""
    for law in (law for law in physics.laws if law.surface is not None):
        moving = on_surface(physics.model, law).forcings[len(physics.model.forcings) :]
        read = {name for forcing in moving for name in frequency_of(forcing)}
        for name in sorted(curves.keys() & read):
            report.add(
                ("schedule", name),
                f"the friction of {law.name!r} varies along a surface that {name!r} moves: "
                "it cannot vary in time",
                suggestion="another friction law",
            )


def refuse_sectors(curves: Iterable[str], physics: Physics, report: Report) -> None:
    """The bounds of a sector are read once."""
    if not physics.model.forcings:
        return
    from fiv_cli.models.symbols import Symbols

    zone = physics.model.equations(Symbols(), physics.options).zone
    for name in sorted({*curves} & (set() if zone is None else {zone.start, zone.width})):
        report.add(("schedule", name), f"the sector's {name!r} cannot vary in time")


def _is_on(forcing: Forcing, physics: Physics, axes: Sequence[Axis]) -> bool:
    if forcing.amplitude in [axis.name for axis in axes]:
        return True
    return physics.fixed.get(forcing.amplitude, physics.default(forcing.amplitude)) != 0.0
