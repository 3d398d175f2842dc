"""The tables ``[model]`` and ``[friction]``: names and numbers against the model and the laws."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field, replace

from fiv_cli.case.form import Form, own_file
from fiv_cli.case.report import Path, Report
from fiv_cli.case.structure import SEVERAL_LAWS, FrictionTable, ModelTable
from fiv_cli.friction import TANH_OF, all_laws, get_law, laws_of, why_unfit
from fiv_cli.friction.base import Law
from fiv_cli.models import all_models
from fiv_cli.models.base import Model, Option, Parameter
from fiv_cli.models.excitation import BASE, following
from fiv_cli.models.origin import Origin
from fiv_cli.notation.names import ascii_name, listed, nearest, suggest


@dataclass(frozen=True)
class Physics:
    """What a case computes with: the model, its options and its friction laws.

    Attributes
    ----------
    model : the model
    options : every option; one that is an axis holds a value under which the model has the states
        of every value of the axis
    laws : the laws in use: one, or those of the axis ``friction``
    fixed : parameter -> SI value, given by the case; ``LAW.NAME`` when given for one law only
    unread : parameters whose value was given and is not sound
    laws_known : False where a law is none that the model knows; `laws` are then all it can have
    """

    model: Model
    options: Mapping[str, str]
    laws: tuple[Law, ...]
    fixed: Mapping[str, float] = field(default_factory=dict)
    unread: frozenset[str] = frozenset()
    laws_known: bool = True

    @property
    def given(self) -> set[str]:
        """The parameters that the case gives a value, were it under one of its laws."""
        return {name.split(".")[-1] for name in self.fixed}

    def origins(self) -> dict[str, Origin]:
        """Model or law that is not in the box -> where it stands."""
        things: tuple[Model | Law, ...] = (self.model, *self.laws)
        return {thing.name: thing.origin for thing in things if thing.origin is not None}

    def table(self) -> dict[str, Parameter]:
        """Every parameter of the model and of the laws in use, by name."""
        adopted = {law.name: self.model.adopted(law) for law in self.laws}
        return _of_laws(adopted) | {p.name: p for p in self.model.parameters}

    def units_of_states(self) -> dict[str, str]:
        """Every state and velocity -> its unit."""
        return state_units(self.model, self.options)

    def varying(self) -> dict[str, Parameter]:
        """The parameters that can vary in one run: of the model, or of every law in use.

        Whole numbers and what is written into the generated code cannot.
        """
        own = {parameter.name for parameter in self.model.parameters}
        tables = [{parameter.name for parameter in law.parameters} for law in self.laws]
        shared = set.intersection(*tables) if self.laws_known else set.union(*tables)
        structural = {name for law in self.laws for name in law.structural}
        return {
            name: parameter
            for name, parameter in self.table().items()
            if name in (own | shared) - structural and not parameter.integer
        }

    def what_varies(self) -> dict[str, str]:
        """Everything that may be an axis of the grid -> its meaning."""
        return (
            {parameter.name: parameter.meaning for parameter in self.table().values()}
            | {option.name: option.meaning for option in self.model.options}
            | {"friction": "the friction law"}
            | {f"initial.{name}": "component of the start" for name in self.units_of_states()}
        )

    def default(self, name: str) -> float | None:
        """The default of a parameter on this model; None when it follows another parameter."""
        return self.table()[name].default


def _of_laws(tables: Mapping[str, Iterable[Parameter]]) -> dict[str, Parameter]:
    """Every parameter of some laws, as the first has it, and what it may be under all of them."""
    found: dict[str, Parameter] = {}
    for law, table in tables.items():
        for parameter in table:
            own = replace(parameter, law=law)
            found[own.name] = found.get(own.name, own).within(own)
    return found


def _names_in(laws: Iterable[Law]) -> set[str]:
    """Names of laws and of their parameters."""
    return {name for law in laws for name in (law.name, *(p.name for p in law.parameters))}


MODEL_TABLE = ("model", "parameters")
AMBIGUOUS = "{!r} means different things to the laws in use"


def is_ambiguous(laws: Iterable[Law], name: str) -> bool:
    """Whether a parameter of this name has several units under these laws."""
    return len({p.unit for law in laws for p in law.parameters if p.name == name}) > 1


def state_units(model: Model, options: Mapping[str, str]) -> dict[str, str]:
    """State -> unit: the coordinates in order, then their velocities."""
    states = model.states(options)
    velocities = {f"{state.name}_dot": per_second(state.unit) for state in states}
    return {state.name: state.unit for state in states} | velocities


def per_second(unit: str) -> str:
    """The unit of a rate."""
    return "s-1" if unit == "1" else f"{unit} s-1"


def read_physics(form: Form, report: Report) -> Physics:
    """The model of a case, its options, its laws, and what it gives for their parameters."""
    model = all_models()[form.model.name]
    axes = {entry.name: entry.value for entry in form.grid}
    reader = _Reader(report)
    options = {**model.default_options(), **reader.options(model, form.model)}
    options |= _options_of_axes(model, options, axes)
    laws, known = reader.laws(model, form.friction, axes.get("friction"))
    of_laws = _leaders(form.friction.model_extra or {}, _shared(laws))
    model = reader.following(model, form.model, laws, of_laws)
    fixed = reader.of_model(model, laws, form.model)
    fixed |= reader.of_laws(model, laws, form.friction, of_laws)
    return Physics(model, options, laws, fixed, frozenset(reader.unread), known)


def note_no_axis(
    name: str, message: str, place: Path, axes: Collection[str], physics: Physics, report: Report
) -> None:
    """Note that `name` is no axis of the case, nor, perhaps, anything that could be one."""
    known = physics.what_varies()
    if name == "initial":
        alone = "there is one start alone, which is no axis"
        more = "a second [[initial]], or a table of several rows, makes it one"
        report.add(place, alone, listed(axes), more, relates=True)
    elif name in known:
        report.add(place, message, listed(axes), suggest(name, axes), relates=True)
    elif suggest(name, known) or counterpart(name, physics.table()):
        note_nothing_to_vary(name, place, physics, report)
    else:
        nothing = f"there is nothing called {name!r} to vary"
        report.add(place, nothing, listed(axes), of_name=True)


def note_nothing_to_vary(name: str, place: Path, physics: Physics, report: Report) -> None:
    """Note that nothing is called `name` that could be an axis of some case."""
    message = f"there is nothing called {name!r} to vary"
    hint = SEVERAL_LAWS if name in ("law", "laws") else counterpart(name, physics.table())
    hint = hint or _excitation_of(name, physics)
    known = physics.what_varies()
    hint = hint or " ".join(filter(None, (suggest(name, known), _others_with(name))))
    report.unknown(place, message, name, known, hint)


def _excitation_of(name: str, physics: Physics) -> str:
    """What the case must have for an axis such as ``omega_v``, where it is one of an excitation."""
    prefix, _, what = name.partition("_")
    if prefix not in ("A", "omega", "phase", "F"):
        return ""
    states = [name for name in physics.units_of_states() if not name.endswith("_dot")]
    homes = {"schedule": [*physics.table()], "forcing": [*states, BASE]}
    home = next((table for table, names in homes.items() if what in names), "")
    return f"an axis where [{home}] has {what} = {{ amplitude = 1.0 }}" if home else ""


USUAL = {
    "speed": {"v0", "vb", "vd", "vdr", "vbelt", "beltspeed", "velocity"},
    "preload": {"no", "n0", "fn", "fn0", "p0", "normalforce", "load"},
}
"""Role of a parameter -> what papers call such parameters, in small letters without underscores."""


def counterpart(name: str, known: Mapping[str, Parameter]) -> str:
    """Which of the `known` parameters another model, or a word such as "preload", means by `name`.

    >>> counterpart("F", {p.name: p for p in all_models()["pin-on-disc"].parameters})
    "here it is 'N0' (normal preload)"
    >>> counterpart("v_belt", {p.name: p for p in all_models()["pin-on-disc"].parameters})
    "here it is 'Omega' (disc speed)"
    """
    tables = [model.parameters for model in all_models().values()]
    tables += [law.parameters for law in all_laws().values()]
    others = [p for table in tables for p in table if p.name == name]
    meant = {p.role for p in others} | {name}
    meant |= {role for role, words in USUAL.items() if name.lower().replace("_", "") in words}
    # a cubic spring has no counterpart among others
    units = {p.unit for p in others if p.role == "stiffness"}
    here = [p for p in known.values() if p.role in meant - {""} and (not units or p.unit in units)]
    alike = [p for p in known.values() if p.name.lower() == name.lower() and p not in here]
    said = " or ".join(f"{p.name!r} ({p.meaning})" for p in [*here, *alike])
    return f"here it is {said}" if here else ""


def note_no_state(name: str, place: Path, physics: Physics, report: Report, hint: str = "") -> None:
    """Note that the model has no state `name`."""
    report.unknown(place, f"there is no state {name!r}", name, physics.units_of_states(), hint)


def law_names(model: Model) -> list[str]:
    """The names that ``law =`` may be on this model, ``tanh`` included."""
    taken = laws_of(model)
    plain = [name for name in taken if not name.startswith(TANH_OF)]
    return [*plain, "tanh"] if len(plain) < len(taken) else plain


def resolve_law(model: Model, name: object, of: str | None = None) -> str:
    """The contract name of the law called `name` (and `of`); ValueError when there is none."""
    regularised = TANH_OF + (of or model.default_law.removeprefix(TANH_OF))
    full = regularised if name == "tanh" else name
    if full not in laws_of(model):
        law = all_laws().get(str(full))
        why = why_unfit(model, law) if law else f"{full!r} is no friction law of {model.name}"
        raise ValueError(why)
    return str(full)


def _options_of_axes(
    model: Model, options: Mapping[str, str], axes: Mapping[str, object]
) -> dict[str, str]:
    """For each option that is an axis, the value that stands for all of the axis."""
    found = {o.name: _known_texts(o, axes[o.name]) for o in model.options if o.name in axes}
    chosen: dict[str, str] = {}
    for option in [option for option in model.options if found.get(option.name)]:
        texts = found[option.name]
        if option.join is not None:
            chosen[option.name] = option.join(texts)
        else:
            most = [len(model.states({**options, **chosen, option.name: t})) for t in texts]
            chosen[option.name] = texts[most.index(max(most))]
    return chosen


def _known_texts(option: Option, values: object) -> list[str]:
    """The values of an axis that are allowed; the grid notes the others."""
    texts = []
    for value in values if isinstance(values, list) else []:
        with suppress(ValueError, TypeError):
            texts.append(option.text(value))
    return texts


def _known_law(model: Model, name: object, of: str | None = None) -> str | None:
    """The contract name of a law; None where the model knows none of the kind (noted elsewhere)."""
    try:
        return resolve_law(model, name, of)
    except ValueError:
        return None


def _in_another(name: str, elsewhere: Mapping[str, str]) -> str:
    """The parameter of another table, name -> table, that is nearly called `name`."""
    near = nearest(name, elsewhere)
    return f"did you mean {near!r}? It stands in [{elsewhere[near]}]" if near else ""


def _others_with(name: str) -> str:
    """The laws or, if there are none, the models that have a parameter `name`."""
    plain = [law for law in all_laws().values() if not law.name.startswith(TANH_OF)]
    of_laws = [law.name for law in plain if name in {p.name for p in law.parameters}]
    models = all_models().values()
    of_models = [model.name for model in models if name in {p.name for p in model.parameters}]
    kind, having = ("law", of_laws) if of_laws else ("model", of_models)
    return f"{name!r} is of {kind} {listed(having)} (fiv models {name})" if having else ""


def _leaders(given: Mapping[str, object], known: Collection[str]) -> dict[str, str]:
    """Key of a parameter that is given the name of another -> that one, both of those `known`."""
    named = {k: ascii_name(v) for k, v in given.items() if isinstance(v, str)}
    return {k: leader for k, leader in named.items() if {ascii_name(k), leader} <= {*known}}


def _shared(laws: Sequence[Law]) -> set[str]:
    """The parameters that all laws have."""
    return set.intersection(*({p.name for p in law.parameters} for law in laws))


class _Reader:
    """Reads what a case gives for options, laws and parameters; keeps what is not sound."""

    def __init__(self, report: Report) -> None:
        self.report = report
        self.unread: set[str] = set()
        self.refused: list[object] = []

    def options(self, model: Model, table: ModelTable) -> dict[str, str]:
        known = {option.name: option for option in model.options}
        chosen = {}
        for name, value in table.options.items():
            place: Path = ("model", "options", name)
            if name not in known:
                self.report.unknown(place, f"unknown option {name!r}", name, known)
                continue
            try:
                chosen[name] = known[name].text(value)
            except ValueError as error:
                option = known[name]
                hint = suggest(str(value), option.choices)
                self.report.add(place, str(error), option.allowed, hint, of_name=True)
        return chosen

    def laws(
        self, model: Model, table: FrictionTable, axis: object
    ) -> tuple[tuple[Law, ...], bool]:
        """The laws in use, and whether all are known; where not, all that the model can have."""
        written = axis if isinstance(axis, list) else []
        names = [_known_law(model, name) for name in written] + self.law_of_table(model, table)
        chosen = [name for name in names if name is not None] or [model.default_law]
        known = None not in names
        named = (*written, table.law, table.of)
        self.refused = [name for name in named if name and _known_law(model, name) is None]
        return tuple(
            get_law(name) for name in dict.fromkeys(chosen if known else laws_of(model))
        ), known

    def law_of_table(self, model: Model, table: FrictionTable) -> list[str | None]:
        if table.law is None and table.of is not None:
            self.report.add(("friction", "of"), 'only law = "tanh" is "of" another law')
        if table.law is None:
            return []
        if table.of is not None and table.law in {*laws_of(model)} - {"tanh"}:
            message = f"law {table.law!r} is not of another law"
            self.report.add(("friction", "of"), message)
        name = _known_law(model, table.law, table.of)
        if name is None:
            of = table.law == "tanh" and table.of
            written, place = (of, "of") if of else (table.law, "law")
            message, hint = self.why_not(model, written, f"of {model.name}")
            self.report.unknown(("friction", place), message, written, law_names(model), hint)
        return [name]

    def why_not(self, model: Model, name: str, whose: str) -> tuple[str, str]:
        """Why the law `name` is not to be had, and what to do."""
        law = all_laws().get(name)
        unfit = why_unfit(model, law) if law else ""
        hint = "" if law else own_file(name, self.report)
        return unfit or f"{name!r} is no friction law {whose}", hint

    def following(
        self, model: Model, table: ModelTable, laws: Sequence[Law], of_laws: Mapping[str, str]
    ) -> Model:
        """The model with the parameters, of it and its laws, that are given the name of another
        following that."""
        own = {p.name: p for p in model.parameters}
        sound = self.leaders(_leaders(table.parameters, own), own, MODEL_TABLE)
        known = {p.name: p for law in laws for p in model.adopted(law)}
        return following(model, sound | self.leaders(of_laws, known, ("friction",)))

    def leaders(
        self, leaders: Mapping[str, str], known: Mapping[str, Parameter], table: Path
    ) -> dict[str, str]:
        """Parameter -> the one whose value it takes, of a table those that may."""
        sound, followers = {}, {ascii_name(name) for name in leaders}
        for key, leader in leaders.items():
            place, own, other = (*table, key), known[ascii_name(key)], known[leader]
            if own.unit != other.unit:
                message = f"{own.name} is in {own.unit}, and the parameter {leader} in {other.unit}"
                self.report.add(place, message, own.allowed)
            elif leader in followers or other.default_from == own.name:
                message = f"{leader} takes the value of another itself"
                self.report.add(place, message, "the name of a parameter that has a value")
            else:
                sound[own.name] = leader
        return sound

    def of_model(self, model: Model, laws: Sequence[Law], table: ModelTable) -> dict[str, float]:
        known = {p.name: p for p in model.parameters}
        elsewhere = {p.name: "friction" for law in laws for p in law.parameters}
        follow = _leaders(table.parameters, known)
        given = {key: value for key, value in table.parameters.items() if key not in follow}
        return self.parameters(given, known, elsewhere, MODEL_TABLE)

    def of_laws(
        self, model: Model, laws: Sequence[Law], table: FrictionTable, follow: Collection[str]
    ) -> dict[str, float]:
        """The laws' parameters, and those of the tables ``[friction.LAW]``."""
        left = {*self.left_of_others(model, laws), *follow}
        extra = {n: value for n, value in (table.model_extra or {}).items() if n not in left}
        own_tables = {name: value for name, value in extra.items() if isinstance(value, dict)}
        plain = {name: value for name, value in extra.items() if name not in own_tables}
        known = _of_laws({law.name: law.parameters for law in laws})
        elsewhere = {p.name: "model.parameters" for p in model.parameters}
        found = self.parameters(plain, known, elsewhere, ("friction",))
        self.refuse_ambiguous(laws, found)
        for name, values in own_tables.items():
            if name not in self.refused:  # which is told where it is named
                found |= self.of_law(model, laws, name, values)
        return found

    def left_of_others(self, model: Model, laws: Sequence[Law]) -> set[str]:
        """What the file gives to other laws of the model, where ``--set`` has chosen the laws."""
        at = ("friction", "law"), ("grid", "friction")
        if not any(map(self.report.is_overridden, at)):
            return set()
        told = _names_in(map(get_law, laws_of(model))) - _names_in(laws)
        return {name for name in told if not self.report.is_overridden(("friction", name))}

    def refuse_ambiguous(self, laws: Sequence[Law], names: Iterable[str]) -> None:
        for name in names:
            if is_ambiguous(laws, name):
                self.report.add(
                    ("friction", name),
                    AMBIGUOUS.format(name),
                    suggestion=f"write it in the law's own table, [friction.{laws[0].name}]",
                )

    def of_law(
        self, model: Model, laws: Sequence[Law], name: str, values: Mapping[str, object]
    ) -> dict[str, float]:
        """``[friction.NAME]``: the parameters of one of the laws in use."""
        whole = [law for law in laws if law.name == name]
        matching = whole or [law for law in laws if law.name.startswith(f"{name} of ")]
        if not matching:
            names = [*(law.name for law in laws), *(p.name for law in laws for p in law.parameters)]
            message, hint = self.why_not(model, name, "that this case uses")
            self.report.unknown(("friction", name), message, name, dict.fromkeys(names), hint)
            return {}
        known = _of_laws({law.name: law.parameters for law in matching})
        found = self.parameters(values, known, {}, ("friction", name))
        if len(laws) == 1:
            return found
        return {f"{law.name}.{key}": value for law in matching for key, value in found.items()}

    def parameters(
        self,
        written: Mapping[str, object],
        known: Mapping[str, Parameter],
        elsewhere: Mapping[str, str],
        table: Path,
    ) -> dict[str, float]:
        """The parameters given in one table, in SI."""
        found: dict[str, float] = {}
        for key, value in written.items():
            name, place = ascii_name(key), (*table, key)
            if name not in known:
                meanings = {other: parameter.meaning for other, parameter in known.items()}
                home = elsewhere.get(name)
                hint = f"{name!r} stands in [{home}]: write it there" if home else ""
                hint = hint or counterpart(name, known) or _in_another(name, elsewhere)
                hint = hint or " ".join(filter(None, (suggest(name, meanings), _others_with(name))))
                self.report.unknown(place, f"unknown parameter {key!r}", name, meanings, hint)
            elif name in found:
                self.report.add(place, f"{name} is given twice")
            elif isinstance(value, str) and ascii_name(value) in {**known, **elsewhere}:
                together = f'[sweep] zip = [["{name}", "{value}"]], both under [grid]'
                hint = f"one may have the value of another of its table; here: {together}"
                self.report.add(place, f"{value!r} is a parameter, not a value", suggestion=hint)
            else:
                self.parameter(known[name], value, place, found)
        return found

    def parameter(
        self, parameter: Parameter, value: object, place: Path, found: dict[str, float]
    ) -> None:
        with self.report.noting(place, parameter.allowed):
            found[parameter.name] = parameter.read(value)
        if parameter.name not in found:
            self.unread.add(parameter.name)
