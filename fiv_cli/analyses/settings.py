"""The settings of an analysis: each type reads its value, refuses, describes and shows itself.

To add a type, derive from `Setting`: `taken` reads, `check` says what the case does not allow,
`form` and `schema` describe, `sample` shows.
"""

from __future__ import annotations

import json
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import KW_ONLY, dataclass, replace
from types import MappingProxyType
from typing import Any, ClassVar, NamedTuple, Protocol

from fiv_cli.dynamics.settings import Section
from fiv_cli.flags import TABLES
from fiv_cli.friction.base import Law
from fiv_cli.friction.surface import forcings_under
from fiv_cli.models.base import Model, Parameter
from fiv_cli.notation.names import ascii_name, listed, suggest, surely_meant
from fiv_cli.notation.units import convert
from fiv_cli.notation.values import (
    INTERVAL_SCHEMA,
    QUANTITY_SCHEMA,
    check_interval,
    check_number,
    check_quantity,
    describe,
)

Schema = dict[str, Any]


Settings = Mapping[str, Any]
"""What an analysis is asked, defaults filled in: each value is what its `Setting` makes of it."""


@dataclass(frozen=True)
class Varied:
    """A parameter that an analysis itself varies.

    Attributes
    ----------
    name : contract name
    followers : parameters that take its value, because the case gives them no other
    unit : its unit
    """

    name: str
    followers: tuple[str, ...] = ()
    unit: str = "1"

    def at(self, parameters: Mapping[str, float], value: float) -> dict[str, float]:
        """`parameters` with this one, and what follows it, at `value` (SI)."""
        return {**parameters, **dict.fromkeys((self.name, *self.followers), value)}


@dataclass(frozen=True)
class Question:
    """A question that a run answers with yes or no.

    Attributes
    ----------
    variable : the variable that decides
    name : class asked for, where the variable holds a class
    negated : "not CLASS"; of a number, that it must stay above
    below : the number that the variable must stay below (or above); None: it holds a class
    counts : a run that is undecided when its time is up has an answer like any other
    contact : the contact whose number it is, from 1; None: there is one for all
    """

    variable: str = "attractor"
    name: str = ""
    negated: bool = False
    below: float | None = None
    counts: bool = False
    contact: int | None = None

    @property
    def changes(self) -> str:
        """Where its answer changes: ``at the border of periodic``, ``at which L_s passes 0.1``."""
        if self.below is None:
            name = self.name.replace("_", " ")
            return f"at the border of {name}" if name else "at which the answer changes"
        return f"at which {self.variable} passes {self.below:g}"


class Known(Protocol):
    """What a setting may ask of the case that it stands in."""

    @property
    def model(self) -> Model:
        """The model."""

    @property
    def options(self) -> Mapping[str, str]:
        """Every option of the model."""

    @property
    def laws(self) -> Sequence[Law]:
        """The friction laws in use."""

    @property
    def axes(self) -> Collection[str]:
        """Names of the axes of the grid."""

    @property
    def varied(self) -> str:
        """The parameter that the analysis itself varies, as written; "" where there is none."""

    def units_of_states(self) -> Mapping[str, str]:
        """Every state and velocity -> its unit."""

    def varying(self) -> Mapping[str, Parameter]:
        """The parameters that may vary."""

    def followers(self, leader: str) -> tuple[str, ...]:
        """Parameters whose value is that of `leader`."""

    def value(self, name: str) -> float | None:
        """The value of a parameter, SI; None where it varies."""

    def numbers(self, along: str = "") -> Collection[str]:
        """The variables of a `response` that are one number at each point, or each of `along`."""


@dataclass(frozen=True)
class Refusal:
    """Why a value is not accepted.

    Attributes
    ----------
    message : what is wrong
    allowed : what it may be
    suggestion : what to write instead
    place : where in the value
    of_name : it is a name that nothing in the case has
    of_key : it is a key that its table does not have
    relates : what else the case has does not allow it
    """

    message: str
    allowed: str = ""
    suggestion: str = ""
    place: tuple[str | int, ...] = ()
    of_name: bool = False
    of_key: bool = False
    relates: bool = False

    def within(self, key: str) -> Refusal:
        """The same, seen from the table that holds the value under `key`."""
        return replace(self, place=(key, *self.place))


def unknown(message: str, name: str, names: Collection[str], *place: str) -> Refusal:
    """Why a `name` that is none of `names` is not accepted."""
    return Refusal(message, listed(names), suggest(name, names), place, of_name=True)


class Reading(NamedTuple):
    """What a value means, and what is wrong with it; the default where it means nothing."""

    value: Any
    refusals: tuple[Refusal, ...] = ()


@dataclass(frozen=True)
class Setting:
    """One key of an ``[[analysis]]`` table.

    Attributes
    ----------
    name : key
    meaning : one line
    default : value when the key is left out; None: see `meaning`
    required : must be given
    partner : setting without which it cannot be given
    later : came after results were stored: at its default it is no part of their identity
    form : what it may be, in words
    """

    name: str
    meaning: str
    _: KW_ONLY
    default: Any = None
    required: bool = False
    partner: str = ""
    later: bool = False

    form: ClassVar[str] = ""

    @property
    def allowed(self) -> str:
        """What it may be, in one line."""
        return f"{self.form} ({self.meaning})"

    @property
    def description(self) -> str:
        """What it means, for who writes one."""
        return self.meaning

    def suits(self, model: Model) -> bool:
        """Whether a case of `model` can have it."""
        return True

    def read(self, value: object, known: Known) -> Reading:
        """The meaning of a TOML value."""
        try:
            taken = self.taken(value, known)
        except ValueError as error:
            return Reading(self.default, (Refusal(str(error), self.allowed),))
        return Reading(taken, self.refusals(taken, known))

    def left_out(self, known: Known) -> Reading:
        """Its default, which not every case allows."""
        if self.required:
            return Reading(self.default, (Refusal("is missing", self.allowed),))
        return Reading(self.default, self.refusals(self.default, known))

    def refusals(self, value: Any, known: Known) -> tuple[Refusal, ...]:
        """Everything that the case does not allow of a value."""
        found = () if value is None else self.check(value, known)
        return tuple(replace(one, relates=True) for one in found)

    def taken(self, value: object, known: Known) -> Any:
        """A TOML value as analyses take it; ValueError says what is wrong with its form."""
        raise NotImplementedError

    def check(self, value: Any, known: Known) -> Iterable[Refusal]:
        """What the case does not allow of a value that has its form."""
        return ()

    def schema(self) -> Schema:
        """JSON schema of the value."""
        return {"type": "string"}

    def example(self, model: Model, varied: Parameter) -> str:
        """TOML of its default, or of a value that a case of `model` may give."""
        if self.default is None:
            return self.sample(model, varied)
        return json.dumps(self.default)

    def sample(self, model: Model, varied: Parameter) -> str:
        """TOML of a value; where a parameter is asked for, `varied`."""
        return '""'


@dataclass(frozen=True)
class Number(Setting):
    """A number in SI, or a string with its unit.

    Attributes
    ----------
    unit : its unit
    above : it is greater
    least : it is no less
    """

    unit: str = "1"
    above: float = float("-inf")
    least: float = float("-inf")

    @property
    def allowed(self) -> str:
        bounds = [f"> {self.above:g}"] * (self.above != float("-inf"))
        bounds += [f">= {self.least:g}"] * (self.least != float("-inf"))
        return ", ".join([f"a number{self._in_unit(' in {}')}", *bounds]) + f" ({self.meaning})"

    @property
    def description(self) -> str:
        return f"{self.meaning}{self._in_unit(' ({})')}"

    def _in_unit(self, words: str) -> str:
        return "" if self.unit == "1" else words.format(self.unit)

    def taken(self, value: object, known: Known) -> float:
        number = convert(check_quantity(value), self.unit)
        if not (number > self.above and number >= self.least):
            raise ValueError(f"{number!r} is out of range")
        return number

    def schema(self) -> Schema:
        return QUANTITY_SCHEMA

    def sample(self, model: Model, varied: Parameter) -> str:
        return "30.0" if self.required else "0.01"


@dataclass(frozen=True)
class Integer(Setting):
    """A whole number, no less than `least`."""

    least: int = 1

    @property
    def allowed(self) -> str:
        return f"a whole number, >= {self.least} ({self.meaning})"

    def taken(self, value: object, known: Known) -> int:
        if isinstance(value, bool) or not isinstance(value, int):
            raise ValueError(f"must be a whole number, not {describe(value)}")
        if value < self.least:
            raise ValueError(f"{value} is out of range")
        return value

    def schema(self) -> Schema:
        return {"type": "integer", "minimum": self.least}

    def sample(self, model: Model, varied: Parameter) -> str:
        return str(self.least)


def check_text(value: object, form: str) -> str:
    """A string; ValueError, which says of what `form` it is to be, for anything else."""
    if not isinstance(value, str):
        raise ValueError(f"must be {form}, not {describe(value)}")
    return value


@dataclass(frozen=True)
class Text(Setting):
    """A string."""

    form: ClassVar[str] = "a string"

    def taken(self, value: object, known: Known) -> str:
        return check_text(value, self.form)


@dataclass(frozen=True)
class Choice(Text):
    """One of several words."""

    choices: tuple[str, ...] = ()

    @property
    def allowed(self) -> str:
        return f"{listed(self.choices)} ({self.meaning})"

    @property
    def description(self) -> str:
        return f"{self.meaning}: {' | '.join(self.choices)}"

    def taken(self, value: object, known: Known) -> str:
        word = super().taken(value, known)
        if word not in self.choices:
            hint = suggest(word, self.choices)
            raise ValueError(f"{word!r} is not allowed" + (f"; {hint}" if hint else ""))
        return word

    def schema(self) -> Schema:
        return {"type": "string", "enum": list(self.choices)}

    def sample(self, model: Model, varied: Parameter) -> str:
        return f'"{self.choices[0]}"'


@dataclass(frozen=True)
class StateName(Text):
    """The name of a state of the model."""

    form: ClassVar[str] = "the name of a state"

    def taken(self, value: object, known: Known) -> str:
        return ascii_name(super().taken(value, known))

    def check(self, value: str, known: Known) -> Iterator[Refusal]:
        units = known.units_of_states()
        if value not in units:
            yield unknown(f"there is no state {value!r}", value, units)

    def sample(self, model: Model, varied: Parameter) -> str:
        return f'"{model.states(model.default_options())[0].name}"'


@dataclass(frozen=True)
class ParameterName(Setting):
    """The name of a parameter that the analysis varies; its value is a `Varied`."""

    form: ClassVar[str] = "the name of a parameter of the model or the law"

    def taken(self, value: object, known: Known) -> Varied:
        name = ascii_name(check_text(value, self.form))
        if name not in known.varying():
            return Varied(name)
        return Varied(name, known.followers(name), known.varying()[name].unit)

    def check(self, value: Varied, known: Known) -> Iterator[Refusal]:
        table = {name: parameter.meaning for name, parameter in known.varying().items()}
        without = [law for law in known.laws if value.name not in (p.name for p in law.parameters)]
        if value.name not in table and 0 < len(without) < len(known.laws):
            message = f"{value.name!r} is no parameter of {without[0].name}"
            own = f"of {without[0].name}: {listed([p.name for p in without[0].parameters])}"
            advice = "what varies must be a parameter of every law of the case, or of the model"
            yield Refusal(message, own, advice, of_name=True)
        elif (state := value.name.removeprefix("initial.")) in {*known.units_of_states()} - {
            *table
        }:
            message = f"{value.name!r} is a component of the start, which only axes vary"
            axis = f'[grid] "initial.{state}" = {{ start = 0.0, stop = 1.0, num = 33 }}'
            advice = f"make it an axis of a `response`: {axis}, finer where the answer changes with"
            refine = '[sweep] refine = { levels = 5, of = "attractor" }'
            yield Refusal(message, listed([*table]), f"{advice} {refine}", of_name=True)
        elif value.name not in table:
            message = f"there is no parameter {value.name!r} that can vary"
            yield unknown(message, value.name, table)
        if value.name in known.axes:
            message = f"{value.name!r} is an axis of the grid: the analysis finds its value itself"
            aside = "or ask in a case of its own, whose answers claims have as CASE:VARIABLE"
            alike = f'; what advances with it follows it: [model.parameters] NAME = "{value.name}"'
            advice = f"remove {value.name} from [grid], {aside}{alike * (len(known.axes) > 1)}"
            yield Refusal(message, suggestion=advice)

    def sample(self, model: Model, varied: Parameter) -> str:
        return f'"{varied.name}"'


@dataclass(frozen=True)
class Bracket(Setting):
    """The lowest and the highest value of the parameter that the analysis varies, SI."""

    form: ClassVar[str] = "[lowest, highest] value of the parameter"

    def taken(self, value: object, known: Known) -> tuple[float, float] | None:
        ends = check_interval(value)
        parameter = known.varying().get(ascii_name(known.varied))
        if parameter is None:  # told of the parameter
            return None
        try:
            low, high = (parameter.read(end) for end in ends)
        except ValueError as error:
            raise ValueError(f"{error}; {parameter.name} is {parameter.allowed}") from None
        if not low < high:
            raise ValueError(f"{low!r} is not below {high!r}")
        return low, high

    def schema(self) -> Schema:
        return INTERVAL_SCHEMA

    def sample(self, model: Model, varied: Parameter) -> str:
        size = varied.default or 1.0
        return f"[{size / 2!r}, {2 * size!r}]"


@dataclass(frozen=True)
class DiscPoints(Setting):
    """Places on a disc: pairs of a radius, m, and an angle, rad."""

    form: ClassVar[str] = "[[radius, angle], ...]"

    def suits(self, model: Model) -> bool:
        return model.surface is not None

    def taken(self, value: object, known: Known) -> tuple[tuple[float, float], ...]:
        if not isinstance(value, list) or not value:
            raise ValueError(f"must be a list of points, not {describe(value)}")
        pairs = map(check_interval, value)
        return tuple((convert(radius, "m"), convert(angle, "rad")) for radius, angle in pairs)

    def check(self, value: Sequence[tuple[float, float]], known: Known) -> Iterator[Refusal]:
        if not self.suits(known.model):
            yield Refusal(f"{known.model.name} has no elastic disc to take points of")
            return
        a, b = known.value("a"), known.value("b")
        if a is None or b is None:
            return
        for index, (radius, _) in enumerate(value):
            if not a <= radius <= b:
                message, disc = (
                    f"the radius {radius!r} is off the disc",
                    f"a = {a!r} to b = {b!r} m",
                )
                yield Refusal(message, disc, place=(index,))

    def schema(self) -> Schema:
        return {"type": "array", "items": INTERVAL_SCHEMA}

    def sample(self, model: Model, varied: Parameter) -> str:
        return "[[0.1, 0.0]]"


def read_settings(
    settings: Sequence[Setting],
    given: Mapping[str, object],
    known: Known,
    whose: str,
    instead: Mapping[str, str] = MappingProxyType({}),
) -> Reading:
    """A table of settings: name -> value, defaults filled in, and all that is wrong with it.

    A key that is none of them is refused, and read as the one that is meant.

    Parameters
    ----------
    given : the table as TOML has it
    whose : what has these settings, for messages
    instead : key that is none of them -> what to write
    """
    names = {setting.name: setting.meaning for setting in settings}
    refusals, written = [], dict(given)
    for key in [key for key in given if key not in names]:
        message = f"{whose} has no setting {key!r}"
        hint = instead.get(key) or suggest(key, names)
        refusals.append(Refusal(message, listed(names), hint, (key,), of_key=True))
        meant = surely_meant(key, [name for name in names if name not in written])
        written |= {meant: written[key]} if meant is not None else {}
    values = {}
    for setting in settings:
        name = setting.name
        found = setting.read(written[name], known) if name in written else setting.left_out(known)
        values[name] = found.value
        refusals += [one.within(name) for one in found.refusals]
        if name in written and setting.partner and setting.partner not in written:
            refusals.append(Refusal(f"is missing: it belongs to {name}").within(setting.partner))
    return Reading(values, tuple(refusals))


@dataclass(frozen=True)
class TableSetting(Setting):
    """A table of settings of its own, of which one thing is made."""

    whose: ClassVar[str] = ""
    keys: ClassVar[tuple[Setting, ...]] = ()
    instead: ClassVar[Mapping[str, str]] = {}

    def read(self, value: object, known: Known) -> Reading:
        if not isinstance(value, dict):
            message = f"must be a table, not {describe(value)}"
            return Reading(self.default, (Refusal(message, self.allowed),))
        found = read_settings(self.keys, value, known, self.whose, self.instead)
        if found.refusals:
            return Reading(self.default, found.refusals)
        return super().read(found.value, known)

    def schema(self) -> Schema:
        return schema_of(self.keys) | {"type": "object", "additionalProperties": False}


def schema_of(settings: Iterable[Setting]) -> Schema:
    """JSON schema of a table of settings: its properties, and those it must have."""
    table = list(settings)
    properties = {one.name: one.schema() | {"description": one.description} for one in table}
    required = [one.name for one in table if one.required]
    return {"properties": properties} | ({"required": required} if required else {})


@dataclass(frozen=True)
class SectionSetting(TableSetting):
    """A Poincaré section: one of `event`, `zero` and `phase`; it may be left to the motion."""

    form: ClassVar[str] = (
        '{ event = "any" }, { event = "slip->stick" }, { zero = "x_dot", direction = "up" } or '
        "{ phase = 0.0 }"
    )
    whose: ClassVar[str] = "a section"
    keys: ClassVar[tuple[Setting, ...]] = (
        Choice(
            "event",
            "a transition of a contact, or what closes it; any: the first that the motion has, "
            "or where nothing sticks the points at which `observe` turns back",
            choices=("any", "slip->stick", "stick->slip", "impact"),
        ),
        Integer("contact", "contact of the event, from 1", default=1),
        Text("zero", "velocity that passes zero, e.g. x_dot"),
        Choice("direction", "sense of it", default="both", choices=("up", "down", "both")),
        Number("phase", "phase of the excitation", unit="rad"),
    )

    def taken(self, value: Any, known: Known) -> Section:
        kinds = [kind for kind in ("event", "zero", "phase") if value[kind] is not None]
        if len(kinds) != 1:
            raise ValueError("a section is given by one of event, zero and phase")
        if value["event"] == "any":
            return Section("own")
        return Section(
            kind=kinds[0],
            event=value["event"] or "slip->stick",
            state=ascii_name(value["zero"] or ""),
            direction=value["direction"],
            phase=value["phase"] or 0.0,
            contact=value["contact"],
        )

    def check(self, value: Section, known: Known) -> Iterable[Refusal]:
        """A section that the model can never pass through."""
        checks = {"event": _check_event, "zero": _check_velocity, "phase": _check_phase}
        return checks[value.kind](value, known) if value.kind in checks else ()

    def example(self, model: Model, varied: Parameter) -> str:
        return '{ event = "any" }'


def _check_event(section: Section, known: Known) -> Iterator[Refusal]:
    from fiv_cli.models.symbols import Symbols  # SymPy

    model, number = known.model, section.contact
    if not 1 <= number <= model.contacts:
        yield Refusal(f"there is no contact {number}", f"1 to {model.contacts}", place=("contact",))
        return
    contact = model.equations(Symbols(), known.options).contacts[number - 1]
    named = f"contact {number} of {model.name}"
    why = [f"the law {law.name!r} never sticks" for law in known.laws if law.capacity is None]
    if contact.is_stop:
        why = [f"{named} never sticks"]
    if section.event == "impact":
        why = [f"{named} never separates"] if contact.gap is None else []
    if why:
        message = f"{why[0]}, so {section.event} never happens"
        other = f'give another: section = {{ zero = "{next(iter(_velocities(known)))}" }}'
        yield Refusal(message, suggestion=other)


def _check_velocity(section: Section, known: Known) -> Iterator[Refusal]:
    velocities = _velocities(known)
    if section.state not in velocities:
        yield unknown(f"{section.state!r} is no velocity", section.state, velocities, "zero")


def _velocities(known: Known) -> list[str]:
    return [name for name in known.units_of_states() if name.endswith("_dot")]


def _check_phase(section: Section, known: Known) -> Iterator[Refusal]:
    """A phase needs an excitation that is on somewhere."""
    amplitudes = [one.amplitude for one in forcings_under(known.model, known.laws)]
    if not amplitudes:
        message = f"{known.model.name} has no excitation to take the phase of"
        yield Refusal(message, suggestion="give it one: fiv kinds force, fiv kinds harmonic")
    elif all(known.value(name) == 0.0 for name in amplitudes):
        message = f"the excitation is off ({listed(amplitudes)} = 0), so it has no phase"
        on = f"give {amplitudes[0]} a value, or make it an axis"
        yield Refusal(message, suggestion=on)


class _Expectation(Setting):
    """A class, "not CLASS", or the bound that a number stays below or above."""

    form: ClassVar[str] = (
        'a class, "not CLASS", or of a number { less_than = NUMBER } or { greater_than = NUMBER }'
    )

    @property
    def description(self) -> str:
        return f"{self.form}; {self.meaning}"

    def taken(self, value: object, known: Known) -> str | tuple[str, float]:
        if isinstance(value, str):
            return value
        if not isinstance(value, dict):
            raise ValueError(f"must be a class or a table, not {describe(value)}")
        if list(value) not in (["less_than"], ["greater_than"]):
            raise ValueError(f"a table with {listed(list(value))} asks nothing")
        ((sign, bound),) = value.items()
        return sign, check_number(bound)

    def schema(self) -> Schema:
        return {"anyOf": [{"type": "string"}, {"type": "object"}]}

    def sample(self, model: Model, varied: Parameter) -> str:
        return '"periodic"'


def _check_number(question: Question, known: Known) -> Iterator[Refusal]:
    """A variable of the model, and a contact where each has a number of its own."""
    name, number, every = question.variable, question.contact, known.model.contacts
    numbers, of_contacts = known.numbers(), known.numbers("contact")
    if name not in (*numbers, *of_contacts):
        message = f"{name!r} is not one number at each point"
        yield unknown(message, name, [*numbers, *of_contacts], "variable")
    elif name in of_contacts and number is None:
        one = f"contact = 1, or another up to {every}"
        yield Refusal(f"{name!r} has a number for each contact", one, place=("variable",))
    elif name in of_contacts and number is not None and number > every:
        yield Refusal(f"there is no contact {number}", f"1 to {every}", place=("contact",))
    elif name in numbers and number is not None:
        message = f"{name!r} has no number for each contact"
        others = f", or of {listed([*of_contacts])}" * bool(of_contacts)
        yield Refusal(message, f"no contact{others}", place=("contact",))


@dataclass(frozen=True)
class QuestionSetting(TableSetting):
    """A question that a run answers with yes or no."""

    form: ClassVar[str] = (
        '{ variable = "attractor", expect = "periodic" }, or with expect = "not periodic", '
        "{ less_than = 0.1 } or { greater_than = 0.1 }"
    )
    whose: ClassVar[str] = "a question"
    instead: ClassVar[Mapping[str, str]] = {
        "less_than": "write expect = { less_than = NUMBER }",
        "greater_than": "write expect = { greater_than = NUMBER }",
    }
    keys: ClassVar[tuple[Setting, ...]] = (
        Text("variable", "variable that decides", default="attractor"),
        _Expectation(
            "expect",
            "of a motion that diverges L_s, greatest and effective values lie above any number",
            required=True,
        ),
        Choice(
            "undecided",
            "a run that is undecided at t_max: open, it has no answer; counts, undecided is a "
            "class like the others (a contact that was not lost within t_max is not lost)",
            default="open",
            choices=("open", "counts"),
        ),
        Integer("contact", "contact whose number it is, from 1, where each has one"),
    )

    def taken(self, value: Any, known: Known) -> Question:
        expect, counts = value["expect"], value["undecided"] == "counts"
        facts = {"counts": counts, "contact": value["contact"]}
        if not isinstance(expect, str):
            sign, bound = expect
            return Question(value["variable"], "", sign == "greater_than", bound, **facts)
        name = expect.removeprefix("not ").strip()
        return Question(value["variable"], name, expect.startswith("not "), **facts)

    def check(self, value: Question, known: Known) -> Iterator[Refusal]:
        if value.below is not None:
            yield from _check_number(value, known)
            return
        if value.contact is not None:
            yield Refusal("a class is that of all contacts", "no contact", place=("contact",))
        if value.variable != "attractor":
            message = f"{value.variable!r} holds no class"
            hint = "give expect = { less_than = NUMBER } or { greater_than = NUMBER }"
            yield Refusal(message, "attractor", hint, place=("variable",))
        table = TABLES["attractor"]
        classes = [name for name in table.codes if name != table.fill]
        if value.name not in classes:
            yield unknown(f"there is no class {value.name!r}", value.name, classes, "expect")

    def sample(self, model: Model, varied: Parameter) -> str:
        return '{ variable = "attractor", expect = "equilibrium" }'
