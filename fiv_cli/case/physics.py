"""The tables ``[model]`` and ``[friction]``: names and numbers against the model and the laws."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping
from contextlib import suppress
from dataclasses import dataclass, field
from typing import Any

from fiv_cli.case.report import Path, Report
from fiv_cli.case.structure import FrictionTable, ModelTable
from fiv_cli.case.tables import read_table
from fiv_cli.friction import TANH_OF, get_law
from fiv_cli.friction.base import Law
from fiv_cli.models import all_models
from fiv_cli.models.base import Model, Option, Parameter
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
    """

    model: Model
    options: Mapping[str, str]
    laws: tuple[Law, ...]
    fixed: Mapping[str, float] = field(default_factory=dict)

    def table(self) -> dict[str, Parameter]:
        """Every parameter of the model and of the laws in use, by name."""
        adopted = [self.model.adopted(law.parameters) for law in reversed(self.laws)]
        named = {p.name: p for table in adopted for p in table}
        return named | {p.name: p for p in self.model.parameters}

    def units_of_states(self) -> dict[str, str]:
        """Every state and velocity -> its unit."""
        return state_units(self.model, self.options)

    def varying(self) -> dict[str, Parameter]:
        """The parameters that can vary in one run: of the model, or of every law in use.

        Whole numbers and what is written into the generated code cannot.
        """
        own = {parameter.name for parameter in self.model.parameters}
        shared = set.intersection(*({p.name for p in law.parameters} for law in self.laws))
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

    def of_another_law(self, name: str) -> bool:
        """Whether some law of the model, in use or not, has this parameter."""
        laws = (get_law(law) for law in self.model.laws)
        return any(p.name == name for law in laws for p in law.parameters)

    def default(self, name: str) -> float | None:
        """The default of a parameter on this model; None when it follows another parameter."""
        return self.table()[name].default


def state_units(model: Model, options: Mapping[str, str]) -> dict[str, str]:
    """State -> unit: the coordinates in order, then their velocities."""
    states = model.states(options)
    velocities = {f"{state.name}_dot": per_second(state.unit) for state in states}
    return {state.name: state.unit for state in states} | velocities


def per_second(unit: str) -> str:
    """The unit of a rate."""
    return "s-1" if unit == "1" else f"{unit} s-1"


def read_physics(raw: Mapping[str, Any], report: Report) -> Physics | None:
    """The model and laws of a case, or None when there is no model to speak of."""
    if "model" not in raw:
        return None
    table = read_table(ModelTable, raw["model"], ("model",), report)
    friction = read_table(FrictionTable, raw.get("friction", {}), ("friction",), report)
    model = _model(table, report)
    if model is None or table is None or friction is None:
        return None
    written = raw["model"].get("parameters", {})
    if not isinstance(written, dict) or written.keys() != table.parameters.keys():
        report.unsure_of("parameters")  # what has no sound form was noted and left out
    options = {**model.default_options(), **_options(model, table, report)}
    options |= _options_of_axes(model, options, raw)
    laws = _laws(model, raw, friction, report)
    physics = Physics(model, options, laws)
    fixed = _model_parameters(physics, table, report) | _friction_parameters(
        physics, friction, raw.get("friction", {}), report
    )
    return Physics(model, options, laws, fixed)


def note_no_axis(
    name: str, message: str, place: Path, axes: Collection[str], physics: Physics, report: Report
) -> None:
    """Note that `name` is no axis of the case; not where one was misread that may be this one."""
    if name in report.misread:
        report.add(place, *report.misread[name])
        return
    possible = name in physics.what_varies() or physics.of_another_law(name)
    if report.is_sure_of("axes") or not possible:
        report.add(place, message, listed(axes), suggest(name, axes))


def note_no_state(
    name: str, place: Path, units: Mapping[str, str], report: Report, message: str = ""
) -> None:
    """Note that the model has no state `name`; not where a misread option decides which it has."""
    if report.is_sure_of("options"):
        text = message or f"there is no state {name!r}"
        report.add(place, text, listed(units), suggest(name, units))


def law_names(model: Model) -> list[str]:
    """The names that ``law =`` may be on this model, ``tanh`` included."""
    plain = [name for name in model.laws if not name.startswith(TANH_OF)]
    return [*plain, "tanh"] if len(plain) < len(model.laws) else plain


def resolve_law(model: Model, name: str, of: str | None = None) -> str:
    """The contract name of the law called `name` (and `of`); ValueError when there is none."""
    regularised = TANH_OF + (of or model.laws[0].removeprefix(TANH_OF))
    full = regularised if name == "tanh" else name
    if full not in model.laws:
        raise ValueError(f"{full!r} is no friction law of {model.name}")
    return full


def _model(table: ModelTable | None, report: Report) -> Model | None:
    """The model; where its name is misspelt the one it resembles, so that the rest is checked."""
    models = all_models()
    if table is None:
        return None
    titles = {name: model.title for name, model in models.items()}
    if table.name not in models:
        report.add(
            ("model", "name"),
            f"there is no model {table.name!r}",
            listed(titles),
            suggest(table.name, titles),
        )
        others = [name for name in titles if name != nearest(table.name, titles)]
        if nearest(table.name, others) is not None:
            return None  # it may mean either
    return models.get(nearest(table.name, titles) or "")


def _options(model: Model, table: ModelTable, report: Report) -> dict[str, str]:
    known = {option.name: option for option in model.options}
    chosen = {}
    for name, value in table.options.items():
        place: Path = ("model", "options", name)
        if name not in known:
            report.add(place, f"unknown option {name!r}", listed(known), suggest(name, known))
            report.unsure_of("options")
            continue
        try:
            chosen[name] = known[name].text(value)
        except ValueError as error:
            option = known[name]
            report.add(place, str(error), option.allowed, suggest(str(value), option.choices))
            report.unsure_of("options")
    return chosen


def _options_of_axes(
    model: Model, options: Mapping[str, str], raw: Mapping[str, Any]
) -> dict[str, str]:
    """For each option that is an axis, the value that stands for all of the axis."""
    grid = raw.get("grid")
    axes = grid if isinstance(grid, dict) else {}
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


def _laws(
    model: Model, raw: Mapping[str, Any], friction: FrictionTable, report: Report
) -> tuple[Law, ...]:
    """The laws in use; the model's default where none that it knows, or resembles it, is named."""
    names = [*_laws_of_axis(model, raw, report), *_law_of_table(model, friction, report)]
    return tuple(get_law(name) for name in dict.fromkeys(names or [model.laws[0]]))


def _laws_of_axis(model: Model, raw: Mapping[str, Any], report: Report) -> list[str]:
    """The laws of the axis ``friction`` as far as they are known; the grid notes the others."""
    grid = raw.get("grid")
    values = grid.get("friction") if isinstance(grid, dict) else None
    names = values if isinstance(values, list) else []
    found = []
    for name in names:
        try:
            found.append(resolve_law(model, name))
        except (ValueError, TypeError):
            report.unsure_of("law")
    return found


def _law_of_table(model: Model, friction: FrictionTable, report: Report) -> list[str]:
    if friction.law is None:
        if friction.of is not None:
            report.add(("friction", "of"), 'only law = "tanh" is "of" another law')
        return []
    if friction.of is not None and friction.law in {*model.laws} - {"tanh"}:
        report.add(("friction", "of"), f"law {friction.law!r} is not of another law")
    try:
        return [resolve_law(model, friction.law, friction.of)]
    except ValueError as error:
        key = "of" if friction.law == "tanh" and friction.of else "law"
        value = friction.of if key == "of" else friction.law
        names = law_names(model)
        report.add(("friction", key), str(error), listed(names), suggest(str(value), names))
        report.unsure_of("law")
        meant = nearest(str(value), names)
        return [] if meant is None else [resolve_law(model, meant)]


def _model_parameters(physics: Physics, table: ModelTable, report: Report) -> dict[str, float]:
    known = {p.name: p for p in physics.model.parameters}
    base: Path = ("model", "parameters")
    elsewhere = {p.name: "friction" for law in physics.laws for p in law.parameters}
    return _read_parameters(physics, table.parameters.items(), known, elsewhere, base, report)


def _friction_parameters(
    physics: Physics, friction: FrictionTable, raw: object, report: Report
) -> dict[str, float]:
    """The law's parameters, and those of the tables ``[friction.LAW]``."""
    extra = dict(friction.model_extra or {})
    own_tables = {name: value for name, value in extra.items() if isinstance(value, dict)}
    plain = [(name, value) for name, value in extra.items() if name not in own_tables]
    known = {p.name: p for law in reversed(physics.laws) for p in law.parameters}
    elsewhere = {p.name: "model.parameters" for p in physics.model.parameters}
    found = _read_parameters(physics, plain, known, elsewhere, ("friction",), report)
    _refuse_ambiguous(physics.laws, found, report)
    for name, values in own_tables.items():
        found |= _law_table(physics, name, values, report)
    return found


def _refuse_ambiguous(laws: tuple[Law, ...], found: Iterable[str], report: Report) -> None:
    for name in found:
        units = {p.unit for law in laws for p in law.parameters if p.name == name}
        if len(units) > 1:
            report.add(
                ("friction", name),
                f"{name!r} means different things to the laws in use",
                suggestion=f"write it in the law's own table, [friction.{laws[0].name}]",
            )


def _law_table(
    physics: Physics, name: str, values: Mapping[str, Any], report: Report
) -> dict[str, float]:
    """``[friction.NAME]``: the parameters of one of the laws in use."""
    laws = {law.name: law for law in physics.laws}
    matching = [law for law in laws if law == name or (name == "tanh" and law.startswith(TANH_OF))]
    if not matching and not report.is_sure_of("law"):
        return {}
    if not matching:
        known = [*laws, *(p.name for law in physics.laws for p in law.parameters)]
        report.add(
            ("friction", name),
            f"{name!r} is no friction law that this case uses",
            f"tables of {listed(laws)}",
            suggest(name, known),
        )
        return {}
    parameters = {p.name: p for p in laws[matching[0]].parameters}
    found = _read_parameters(physics, values.items(), parameters, {}, ("friction", name), report)
    if len(laws) == 1:
        return found
    return {f"{law}.{key}": value for law in matching for key, value in found.items()}


def _read_parameters(
    physics: Physics,
    items: Iterable[tuple[str, object]],
    known: Mapping[str, Parameter],
    elsewhere: Mapping[str, str],
    base: Path,
    report: Report,
) -> dict[str, float]:
    """The parameters given in one table, in SI."""
    found: dict[str, float] = {}
    for key, value in items:
        name, place = ascii_name(key), (*base, key)
        if name not in known and physics.of_another_law(name) and not report.is_sure_of("law"):
            continue
        if name not in known:
            _note_unknown(name, known, elsewhere, place, report)
            report.unsure_of("parameters")
        elif name in found:
            report.add(place, f"{name} is given twice")
        else:
            _read_parameter(known[name], value, place, found, report)
    return found


def _read_parameter(
    parameter: Parameter, value: object, place: Path, found: dict[str, float], report: Report
) -> None:
    try:
        found[parameter.name] = parameter.read(value)
    except ValueError as error:
        report.add(place, str(error), parameter.allowed)
        report.unsure_of("parameters")


def _note_unknown(
    name: str,
    known: Mapping[str, Parameter],
    elsewhere: Mapping[str, str],
    place: Path,
    report: Report,
) -> None:
    meanings = {key: parameter.meaning for key, parameter in known.items()}
    if name in elsewhere:
        hint = f"{name!r} stands in [{elsewhere[name]}]: write it there"
    else:
        hint = suggest(name, meanings)
    report.add(place, f"unknown parameter {name!r}", listed(meanings), hint)
