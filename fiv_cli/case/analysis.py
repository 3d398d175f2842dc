"""The tables ``[[analysis]]``: what is computed, with every setting filled in."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from typing import Any

from fiv_cli.analyses import all_analyses
from fiv_cli.analyses.base import Analysis, Question, Section, Setting, Varied
from fiv_cli.analyses.rest.linear import SYSTEM
from fiv_cli.analyses.spectra.spectrum import OF_SPECTROGRAMS, OF_STEADY_STATES
from fiv_cli.analyses.variables import variables_of
from fiv_cli.case.case import AnalysisSpec, Axis
from fiv_cli.case.physics import Physics, note_no_state
from fiv_cli.case.report import Path, Report
from fiv_cli.case.results import ATTRACTORS
from fiv_cli.case.structure import AnalysisTable, QuestionTable, SectionTable
from fiv_cli.case.tables import read_table, read_tables
from fiv_cli.friction import all_laws
from fiv_cli.models.base import Parameter
from fiv_cli.notation.names import ascii_name, listed, nearest, suggest
from fiv_cli.notation.units import convert
from fiv_cli.notation.values import check_interval, check_number, check_quantity, describe

_NAME = re.compile(r"[A-Za-z][A-Za-z0-9_-]*")


def read_analyses(
    raw: Mapping[str, Any], physics: Physics | None, axes: Sequence[Axis], report: Report
) -> tuple[AnalysisSpec, ...]:
    """The analyses in order; settings that need the model are checked when there is one."""
    tables = read_tables(AnalysisTable, raw.get("analysis", []), ("analysis",), report)
    if not raw.get("analysis"):
        kinds = listed(all_analyses())
        report.add(("analysis",), "a case has one [[analysis]] at least", f"kind = {kinds}")
    specs = []
    scheduled = bool(raw.get("schedule"))
    written = raw.get("analysis", [])
    if not isinstance(written, list) or len(tables) != len(written):
        report.unsure_of("analyses")
    for place, _, table in tables:
        spec = _analysis(table, place, physics, axes, scheduled, report)
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
    scheduled: bool,
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
    written = _meant(analysis, dict(table.model_extra or {}), place, report)
    idle = _refuse_idle(analysis, written, scheduled, place, report)
    given = {key: value for key, value in written.items() if key not in idle}
    reader = _Reader(physics, axes, given, idle, report)
    settings = {s.name: reader.setting(s, place) for s in analysis.settings}
    for one, other in (("parameter", "bracket"), ("bracket", "parameter")):
        needed = any(s.name == other and s.required for s in analysis.settings)
        if one in given and settings.get(other, 0) is None and other not in given and not needed:
            report.add((*place, other), f"is missing: it belongs to {one}")
    return AnalysisSpec(table.name or analysis.kind, analysis.kind, settings)


def _named(kind: str, place: Path, report: Report) -> Analysis | None:
    """The analysis of a kind; where that is misspelt the one it resembles, so as to check more."""
    titles = {name: analysis.title for name, analysis in all_analyses().items()}
    if kind not in titles:
        message = f"there is no analysis {kind!r}"
        report.add(place, message, listed(titles), suggest(kind, titles))
        report.unsure_of("analyses")
    return all_analyses().get(kind if kind in titles else nearest(kind, titles) or "")


def _meant(
    analysis: Analysis, given: Mapping[str, Any], place: Path, report: Report
) -> dict[str, Any]:
    """The settings; one that is misspelt is noted, and read as the one that it resembles."""
    known = {setting.name: setting.meaning for setting in analysis.settings}
    known |= {"name": "", "kind": ""}
    found = {key: value for key, value in given.items() if key in known}
    for key in [key for key in given if key not in known]:
        message = f"the analysis {analysis.kind!r} has no setting {key!r}"
        report.add((*place, key), message, listed(known), suggest(key, known))
        wanting = [s.name for s in analysis.settings if s.required and s.name not in found]
        left = [s.name for s in analysis.settings if s.name not in found]
        meant = nearest(key, wanting) or nearest(key, left)
        if meant is not None:
            found[meant] = given[key]
        else:
            report.unsure_of("analyses")  # it may have been the name
    return found


def _refuse_idle(
    analysis: Analysis, given: Mapping[str, Any], scheduled: bool, place: Path, report: Report
) -> tuple[str, ...]:
    """The settings that have no effect, each noted where it is given.

    `spectrum` is of a steady state, and with ``[schedule]`` of a motion: a spectrogram.
    """
    if analysis.kind != "spectrum":
        return ()
    for name in [name for name in OF_SPECTROGRAMS if name in given and not scheduled]:
        report.add(
            (*place, name),
            f"{name!r} belongs to a spectrogram, and without [schedule] there is none",
            suggestion='a [[figure]] of kind "spectrogram" transforms a history window by window',
        )
    for name in [name for name in OF_STEADY_STATES if name in given and scheduled]:
        report.add(
            (*place, name),
            f"{name!r} belongs to a steady state, and with [schedule] there is none: a spectrogram",
            "observe, f_max, resolution, window, hop and t_end",
            f"remove {name}; t_end says where the motion ends",
        )
    return OF_STEADY_STATES if scheduled else OF_SPECTROGRAMS


class _Reader:
    """Reads settings by their type; what cannot be read is noted and keeps its default."""

    def __init__(
        self,
        physics: Physics | None,
        axes: Sequence[Axis],
        given: Mapping[str, Any],
        idle: Sequence[str],
        report: Report,
    ) -> None:
        self.physics = physics
        self.axes = axes
        self.given = given
        self.idle = idle
        self.report = report

    def setting(self, setting: Setting, table: Path) -> Any:
        place = (*table, setting.name)
        if setting.name not in self.given:
            return self.left_out(setting, place)
        read = {
            "number": self.number,
            "integer": self.integer,
            "string": self.string,
            "boolean": self.boolean,
            "section": self.section,
            "state": self.state,
            "parameter": self.parameter,
            "bracket": self.bracket,
            "points": self.points,
            "question": self.question,
        }[setting.type]
        try:
            return read(setting, self.given[setting.name], place)
        except ValueError as error:
            self.report.add(place, str(error), _allowed(setting))
            return setting.default

    def left_out(self, setting: Setting, place: Path) -> Any:
        if setting.required:
            self.report.add(place, "is missing", _allowed(setting))
        if isinstance(setting.default, Section) and setting.name not in self.idle:
            self.check_section(setting.default, place)
        return setting.default

    def number(self, setting: Setting, value: object, place: Path) -> float:
        number = convert(check_quantity(value), setting.unit)
        low = number > setting.minimum if setting.exclusive else number >= setting.minimum
        if not low:
            raise ValueError(f"{number!r} is out of range")
        return number

    def integer(self, setting: Setting, value: object, place: Path) -> int:
        if isinstance(value, bool) or not isinstance(value, int):
            raise ValueError(f"must be a whole number, not {describe(value)}")
        if value < setting.minimum:
            raise ValueError(f"{value} is out of range")
        return value

    def string(self, setting: Setting, value: object, place: Path) -> str:
        if not isinstance(value, str):
            raise ValueError(f"must be a string, not {describe(value)}")
        if setting.choices and value not in setting.choices:
            hint = suggest(value, setting.choices)
            raise ValueError(f"{value!r} is not allowed" + (f"; {hint}" if hint else ""))
        if setting is SYSTEM and value == "averaged":
            self.check_average(place)
        return value

    def check_average(self, place: Path) -> None:
        """Note a system that has no fast motion, or a law without an average over it."""
        if self.physics is None:
            return
        if self.physics.model.averaged_forcing() is None:
            message = f"{self.physics.model.name} has no fast excitation to average over"
            self.report.add(place, message, suggestion='write system = "original"')
        uncertain = not self.report.is_sure_of("law")
        for law in [law for law in self.physics.laws if law.average is None and not uncertain]:
            known = [name for name, law in all_laws().items() if law.average is not None]
            self.report.add(place, f"the law {law.name!r} has no average", listed(known))

    def boolean(self, setting: Setting, value: object, place: Path) -> bool:
        if not isinstance(value, bool):
            raise ValueError(f"must be true or false, not {describe(value)}")
        return value

    def state(self, setting: Setting, value: object, place: Path) -> str:
        if not isinstance(value, str):
            raise ValueError(f"must be the name of a state, not {describe(value)}")
        name = ascii_name(value)
        if self.physics is not None and name not in self.physics.units_of_states():
            note_no_state(name, place, self.physics.units_of_states(), self.report)
        return name

    def parameter(self, setting: Setting, value: object, place: Path) -> Varied:
        if not isinstance(value, str):
            raise ValueError(f"must be the name of a parameter, not {describe(value)}")
        name = ascii_name(value)
        if self.physics is None:
            return Varied(name)
        table = varying(self.physics)
        if name not in table:
            meanings = {key: parameter.meaning for key, parameter in table.items()}
            message = f"there is no parameter {name!r} that can vary"
            self.report.unsure_of("parameters")
            self.report.add(place, message, listed(table), suggest(name, meanings))
        if name in [axis.name for axis in self.axes]:
            message = f"{name!r} is an axis of the grid: the analysis finds its value itself"
            self.report.add(place, message, suggestion=f"remove {name} from [grid]")
        unit = table[name].unit if name in table else "1"
        return Varied(name, self.followers(self.physics, name), unit)

    def followers(self, physics: Physics, leader: str) -> tuple[str, ...]:
        """Parameters whose value is that of `leader`, because nothing else gives them one."""
        given = {key.split(".")[-1] for key in physics.fixed} | {axis.name for axis in self.axes}
        table = physics.table().values()
        return tuple(p.name for p in table if p.default_from == leader and p.name not in given)

    def bracket(self, setting: Setting, value: object, place: Path) -> tuple[float, float]:
        low, high = check_interval(value)
        parameter = self.bracketed()
        if parameter is None:
            return 0.0, 1.0
        try:
            ends = parameter.read(low), parameter.read(high)
        except ValueError as error:
            raise ValueError(f"{error}; {parameter.name} is {parameter.allowed}") from None
        if not ends[0] < ends[1]:
            raise ValueError(f"{ends[0]!r} is not below {ends[1]!r}")
        return ends

    def points(
        self, setting: Setting, value: object, place: Path
    ) -> tuple[tuple[float, float], ...]:
        if not isinstance(value, list) or not value:
            raise ValueError(f"must be a list of points, not {describe(value)}")
        found = []
        for pair in value:
            radius, angle = check_interval(pair)
            found.append((convert(radius, "m"), convert(angle, "rad")))
        if self.physics is not None:
            self.check_points(found, self.physics, place)
        return tuple(found)

    def check_points(
        self, points: Sequence[tuple[float, float]], physics: Physics, place: Path
    ) -> None:
        """Note points of a model without a disc, or off its disc where that is fixed."""
        if physics.model.surface is None:
            self.report.add(place, f"{physics.model.name} has no elastic disc to take points of")
            return
        a, b = (physics.fixed.get(name, physics.default(name)) for name in ("a", "b"))
        varied = {"a", "b"} & {axis.name for axis in self.axes}
        for index, (radius, _) in enumerate(points):
            if not varied and self.is_placed() and not (a or 0.0) <= radius <= (b or 0.0):
                message = f"the radius {radius!r} is off the disc"
                self.report.add((*place, index), message, f"a = {a!r} to b = {b!r} m")

    def is_placed(self) -> bool:
        """Whether what the case gives for its parameters was understood."""
        return self.report.is_sure_of("parameters", "axes")

    def bracketed(self) -> Parameter | None:
        """The parameter that the bracket is of; None when there is none (noted elsewhere)."""
        name = self.given.get("parameter")
        if self.physics is None or not isinstance(name, str):
            return None
        return varying(self.physics).get(ascii_name(name))

    def question(self, setting: Setting, value: object, place: Path) -> Question:
        table = read_table(QuestionTable, value, place, self.report)
        if table is None:
            return Question(name="periodic")
        if isinstance(table.expect, str):
            return self.question_of_class(table, table.expect, place)
        if set(table.expect) != {"less_than"}:
            raise ValueError(f"a table with {listed(list(table.expect))} asks nothing")
        if self.physics is not None and table.variable not in self.numbers(self.physics):
            known = self.numbers(self.physics)
            hint = suggest(table.variable, known)
            self.report.add(
                (*place, "variable"), f"{table.variable!r} is no number", listed(known), hint
            )
        bound = check_number(table.expect["less_than"])
        return Question(table.variable, below=bound, counts=table.undecided == "counts")

    def question_of_class(self, table: QuestionTable, expect: str, place: Path) -> Question:
        if table.variable != "attractor":
            message = f"{table.variable!r} holds no class: give expect = {{ less_than = NUMBER }}"
            self.report.add((*place, "variable"), message, "attractor")
        name = expect.removeprefix("not ").strip()
        if name not in ATTRACTORS:
            message = f"there is no class {name!r}"
            hint = suggest(name, ATTRACTORS)
            self.report.add((*place, "expect"), message, listed(ATTRACTORS), hint)
        negated, counts = expect.startswith("not "), table.undecided == "counts"
        return Question("attractor", name, negated, counts=counts)

    def numbers(self, physics: Physics) -> list[str]:
        """The variables of a response that are one number at each point."""
        held = variables_of("response", physics.model, physics.options, {})
        return [variable.name for variable in held if variable.askable]

    def section(self, setting: Setting, value: object, place: Path) -> Section:
        table = read_table(SectionTable, value, place, self.report)
        if table is None or not isinstance(value, dict):
            return Section("event")
        forms = ("event", "zero", "phase")
        kinds = [key for key in forms if key in value or getattr(table, key) is not None]
        if len(kinds) != 1:
            raise ValueError("a section is given by one of event, zero and phase")
        section = Section(
            kind=kinds[0],
            event=table.event or "slip->stick",
            state=ascii_name(table.zero or ""),
            direction=table.direction,
            phase=convert(table.phase or 0.0, "rad"),
            contact=table.contact,
        )
        self.check_section(section, place)
        return section

    def check_section(self, section: Section, place: Path) -> None:
        """Note a section that the model can never pass through."""
        if self.physics is None:
            return
        if section.kind == "event":
            self.check_event(section, self.physics, place)
        elif section.kind == "zero":
            self.check_velocity(section.state, self.physics, place)
        else:
            self.check_forcing(self.physics, place)

    def check_event(self, section: Section, physics: Physics, place: Path) -> None:
        if not 1 <= section.contact <= physics.model.contacts:
            self.report.add(
                (*place, "contact"),
                f"there is no contact {section.contact}",
                f"1 to {physics.model.contacts}",
            )
        creeping = [law.name for law in physics.laws if law.capacity is None]
        if creeping and self.report.is_sure_of("law"):
            velocity = next(iter(name for name in _velocities(physics)))
            self.report.add(
                place,
                f"the law {creeping[0]!r} never sticks, so {section.event} never happens",
                suggestion=f'give another: section = {{ zero = "{velocity}" }}',
            )

    def check_velocity(self, name: str, physics: Physics, place: Path) -> None:
        velocities = _velocities(physics)
        if name not in velocities:
            units = dict.fromkeys(velocities, "")
            message = f"{name!r} is no velocity"
            note_no_state(name, (*place, "zero"), units, self.report, message)

    def check_forcing(self, physics: Physics, place: Path) -> None:
        """A phase needs an excitation that is on somewhere."""
        amplitudes = [forcing.amplitude for forcing in physics.model.forcings]
        if not amplitudes:
            self.report.add(place, f"{physics.model.name} has no excitation to take the phase of")
        elif self.is_placed() and not any(self.switched_on(name, physics) for name in amplitudes):
            self.report.add(
                place,
                f"the excitation is off ({listed(amplitudes)} = 0), so it has no phase",
                suggestion=f"give {amplitudes[0]} under [model.parameters] or as an axis",
            )

    def switched_on(self, amplitude: str, physics: Physics) -> bool:
        if amplitude in [axis.name for axis in self.axes]:
            return True
        if amplitude == ascii_name(str(self.given.get("parameter", ""))):
            return True
        return physics.fixed.get(amplitude, physics.default(amplitude)) != 0.0


def varying(physics: Physics) -> dict[str, Parameter]:
    """The parameters that can vary in one run: of the model, or of every law in use.

    Whole numbers and what is written into the generated code cannot.
    """
    own = {parameter.name for parameter in physics.model.parameters}
    shared = set.intersection(*({p.name for p in law.parameters} for law in physics.laws))
    structural = {name for law in physics.laws for name in law.structural}
    return {
        name: parameter
        for name, parameter in physics.table().items()
        if name in (own | shared) - structural and not parameter.integer
    }


def _velocities(physics: Physics) -> list[str]:
    states = physics.model.states(physics.options)
    return [f"{state.name}_dot" for state in states]


def _allowed(setting: Setting) -> str:
    """What a setting may be, in one line."""
    if setting.choices:
        return f"{listed(setting.choices)} ({setting.meaning})"
    unit = "" if setting.unit == "1" else f" in {setting.unit}"
    bound = ""
    if setting.minimum != float("-inf"):
        bound = f" {'>' if setting.exclusive else '>='} {setting.minimum:g}"
    form = {
        "section": '{ event = "slip->stick" }, { zero = "x_dot", direction = "up" } or '
        "{ phase = 0.0 }",
        "state": "the name of a state",
        "parameter": "the name of a parameter of the model or the law",
        "bracket": "[lowest, highest] value of the parameter",
        "points": "[[radius, angle], ...]",
        "question": '{ variable = "attractor", expect = "periodic" }, or with expect = '
        '"not periodic" or { less_than = 0.1 }',
    }.get(setting.type, setting.type)
    return f"{form}{unit}{bound} ({setting.meaning})"
