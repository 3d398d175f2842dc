"""What excites the model: the table ``[forcing]``, and the harmonic part of ``[schedule]``."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace

from fiv_cli.case.form import Form
from fiv_cli.case.physics import Physics
from fiv_cli.case.report import Path, Report
from fiv_cli.case.schedule import may_vary, refuse_sectors
from fiv_cli.case.structure import CurveTable, ForceTable
from fiv_cli.models.base import Model, Parameter, leaders
from fiv_cli.models.excitation import BASE, BETWEEN, NAMES, Term, excited
from fiv_cli.notation.names import ascii_name


@dataclass(frozen=True)
class _Asked:
    """An excitation that a case asks for, and where."""

    term: Term
    place: Path
    table: ForceTable | CurveTable

    def values(self) -> Iterator[tuple[str, object, Path]]:
        """The parameters that it gives, each with what is written, and its place."""
        for key in [key for key in NAMES if key in self.table.model_fields_set]:
            yield self.term.named(key), getattr(self.table, key), (*self.place, key)


def with_excitations(form: Form, physics: Physics, report: Report) -> Physics:
    """`physics` under the forces and the harmonic variations that the case gives."""
    asked = [*_forces(form, physics.model, report), *_variations(form, physics, report)]
    if not asked:
        return physics
    carried = _carried(asked, form, physics)
    terms = [one.term.text for one in asked] + [term.text for term in carried]
    name = BETWEEN.join([physics.model.name, *terms])
    found = replace(physics, model=excited(physics.model, name))
    followed, fixed = _values(asked, found, form, report)
    _refuse_what_does_nothing(asked, form, report)
    for term, leader in carried.items():
        followed |= {term.named(key): leader.named(key) for key in ("amplitude", "omega", "phase")}
    name = BETWEEN.join([name, *(f"{one} = {other}" for one, other in followed.items())])
    unread = {parameter for one in asked for parameter, _, _ in one.values()} - {*followed, *fixed}
    return replace(
        found,
        model=excited(physics.model, name),
        fixed={**physics.fixed, **fixed},
        unread=physics.unread | unread,
    )


def _carried(asked: list[_Asked], form: Form, physics: Physics) -> dict[Term, Term]:
    """What varies because it takes the value of something that does -> that one's variation."""
    varied = {one.term.of: one.term for one in asked if one.term.kind == "parameter"}
    given = {*physics.given, *varied, *(axis.name for axis in form.grid)}
    table = physics.table()
    own = {p.name for p in physics.model.parameters}
    return {
        Term("parameter", name, "" if name in own else table[name].unit): varied[leader]
        for name, leader in leaders(table.values(), given).items()
        if leader in varied
    }


def forced(model: Model) -> dict[str, str]:
    """What ``[forcing]`` may name on a model -> what is meant."""
    if model.derived is not None or not model.contacts:
        return {}
    states = model.states(model.default_options())
    moved = {BASE: f"motion of what holds {', '.join(model.base)}, through springs and dampers"}
    return {s.name: f"force along it: {s.meaning}" for s in states} | (moved if model.base else {})


def _forces(form: Form, model: Model, report: Report) -> Iterator[_Asked]:
    known = forced(model)
    seen: set[str] = set()
    for name, place, table in form.forcing:
        if name in seen:
            report.add(place, f"the forcing of {name!r} is given twice")
        elif not known:
            models = "a lumped model; of a disc, its own excitation"
            report.add(place, f"{model.name} takes no [forcing]", models, "fiv models", True)
        elif name not in known:
            hint = _instead_of_base(model) if name == BASE else ""
            report.unknown(place, f"{model.name} has no {name!r} to force", name, known, hint)
        elif name == BASE and table.constant is not None:
            message = "the base has no constant part: it is where coordinates are counted from"
            report.add((*place, "constant"), message, "amplitude, omega, phase")
        else:
            seen.add(name)
            yield _Asked(Term(BASE if name == BASE else "force", name), place, table)


def _instead_of_base(model: Model) -> str:
    """Why nothing that holds the model can move, and what stands for it."""
    states = model.states(model.default_options())
    if any(state.unit != "rad" for state in states):
        return f'base=("{states[0].name}",) in its MODEL says what moves with it'
    return (
        "its coordinates turn about axes that stand still; a spring whose far end moves by u "
        f"exerts a moment, stiffness x arm x u: give it as {states[0].name}"
    )


def _variations(form: Form, physics: Physics, report: Report) -> Iterator[_Asked]:
    """The harmonic curves of ``[schedule]``."""
    seen: set[str] = set()
    for name, place, table in form.schedule:
        if not table.is_harmonic:
            continue
        own = physics.table().get(name)
        if name in seen:
            report.add(place, f"the schedule of {name!r} is given twice")
        elif own is not None and own.role == "frequency":
            why = f"{name!r} is a frequency, and a phase needs a constant one"
            report.add(place, why, suggestion="vary another parameter, or give it a ramp")
        elif may_vary(name, place, physics, report):
            assert own is not None
            seen.add(name)
            refuse_sectors([name], physics, report)
            law = own.name not in {p.name for p in physics.model.parameters}
            yield _Asked(Term("parameter", name, own.unit if law else ""), place, table)


def _values(
    asked: list[_Asked], physics: Physics, form: Form, report: Report
) -> tuple[dict[str, str], dict[str, float]]:
    """What the tables give: parameters that follow another, and values in SI."""
    known, followed, fixed = physics.table(), dict[str, str](), dict[str, float]()
    for name, value, place in (one for found in asked for one in found.values()):
        elsewhere = [other for other in form.places_of(name) if other != place]
        if elsewhere:
            shown = ".".join(map(str, elsewhere[0]))
            report.add(place, f"{name} is also given by {shown}", "one of the two")
        elif ascii_name(str(value)) in known and isinstance(value, str):
            if _agrees(known[name], known[ascii_name(value)], followed, place, report):
                followed[name] = ascii_name(value)
        else:
            named = f", or the name of a parameter in {known[name].unit}"
            with report.noting(place, known[name].allowed + named):
                fixed[name] = known[name].read(value)
    return followed, fixed


def _agrees(
    parameter: Parameter,
    leader: Parameter,
    followed: Mapping[str, str],
    place: Path,
    report: Report,
) -> bool:
    """Whether one can take the value of the other; notes where it cannot."""
    chain, name = [parameter.name], leader.name
    while name in followed and name not in chain:
        chain, name = [*chain, name], followed[name]
    if name in chain or not parameter.name.startswith(("A_", "omega_", "phase_")):
        report.add(place, f"{parameter.name} cannot follow {leader.name}", parameter.allowed)
        return False
    if parameter.unit != leader.unit:
        message = f"{leader.name!r} is in {leader.unit}, not in {parameter.unit}"
        report.add(place, message, parameter.allowed)
    return parameter.unit == leader.unit


def _refuse_what_does_nothing(asked: list[_Asked], form: Form, report: Report) -> None:
    """Note an excitation without an amplitude, nor a constant part, here or on an axis."""
    axes = {axis.name for axis in form.grid}
    for one in asked:
        keys = {"amplitude"} | ({"constant"} if one.term.kind == "force" else set())
        if not keys & one.table.model_fields_set and not axes & set(map(one.term.named, keys)):
            report.add(
                (*one.place, "amplitude"), "is missing", "a number >= 0",
                f"give it here, or {one.term.named('amplitude')} as an axis under [grid]",
            )  # fmt: skip
