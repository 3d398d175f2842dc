"""What is wrong in the tables of a model or a law."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import replace
from math import isinf
from typing import Any

from fiv_cli.friction import all_laws, why_unfit
from fiv_cli.friction.base import Law
from fiv_cli.models.base import Model, Option, Parameter, State
from fiv_cli.models.excitation import frequency_of
from fiv_cli.notation.names import suggest
from fiv_cli.notation.units import parse_unit
from fiv_cli.own.fault import Fault, none_called
from fiv_cli.own.load import is_name

Type = tuple[Callable[[Any], bool], str]


def _tuple_of(kind: type) -> Type:
    allowed = f"a tuple of {kind.__name__}(...), one alone with a comma behind it"
    return (
        lambda value: isinstance(value, tuple) and all(isinstance(v, kind) for v in value),
        allowed,
    )


_OF_MODEL: dict[str, Type] = {
    "parameters": _tuple_of(Parameter),
    "states": (callable, "lambda options: (State(...), ...), one alone with a comma behind it"),
    "options": _tuple_of(Option),
    "equations": (callable, "a function equations(symbols, options)"),
    "contacts": (lambda value: isinstance(value, int), "how many contacts the equations return"),
    "stops": (lambda value: isinstance(value, int), "how many of these are stops"),
}
_OF_LAW: dict[str, Type] = {
    "parameters": _tuple_of(Parameter),
    "states": _tuple_of(State),
    "force": (callable, "lambda slip, p: F_T in N"),
    "capacity": (
        lambda value: value is None or callable(value),
        "lambda N, p: what stick can bear, in N; None: it never sticks",
    ),
    "rates": (
        lambda value: value is None or callable(value),
        "lambda slip, p: {name of a state: its rate}; leave it out of a law without states",
    ),
}


def types_of_model(model: Model) -> Iterator[Fault]:
    """What a model is given in place of tables and functions."""
    return _types(model, _OF_MODEL)


def types_of_law(law: Law) -> Iterator[Fault]:
    """What a law is given in place of tables and functions."""
    return _types(law, _OF_LAW)


def _types(thing: Model | Law, types: Mapping[str, Type]) -> Iterator[Fault]:
    for name, (fits, allowed) in types.items():
        if not fits(getattr(thing, name)):
            yield Fault((type(thing).__name__, thing.name, name), "is something else", allowed)


def tables_of_model(model: Model) -> Iterator[Fault]:
    """What is wrong with the parameters, states, options and defaults of a model."""
    yield from _header(model)
    yield from _parameters(model.parameters)
    names = [p.name for p in model.parameters]
    states: object = model.states(model.default_options())
    if not isinstance(states, tuple) or not all(isinstance(one, State) for one in states):
        yield Fault(("Model", model.name, "states"), "gives something else", _OF_MODEL["states"][1])
        return
    yield from _states(states)
    for attribute in ("base", "vibration"):
        for name in {*getattr(model, attribute)} - {state.name for state in states}:
            every = [state.name for state in states]
            yield none_called("Model", model.name, attribute, "state", every, name)
    for option in model.options:
        if option.text(option.default) != option.default:
            yield Fault(("Option", option.name, "default"), "is none of the choices")
    for forcing in model.forcings:
        if forcing.amplitude not in names:
            yield none_called("Forcing", forcing.amplitude, "amplitude", "parameter", names)
        for name in () if model.derived else {*frequency_of(forcing)} - {*names}:
            yield none_called("Forcing", forcing.amplitude, "frequency", "parameter", names, name)
    yield from _law_of(model)


_ELSEWHERE = "one in a file of its own is named with a further --with FILE.py"


def _law_of(model: Model) -> Iterator[Fault]:
    laws = all_laws()
    if not model.contacts:
        return
    if model.default_law not in laws:
        fault = none_called("Model", model.name, "default_law", "law", laws, model.default_law)
        yield replace(fault, message=f"{fault.message}; {_ELSEWHERE}")
        return
    unfit = why_unfit(model, laws[model.default_law])
    if unfit and model.contacts:
        yield Fault(("Model", model.name, "default_law"), unfit)
    yield from _defaults_of_laws(model)
    known = [p.name for p in model.parameters_under(laws[model.default_law])]
    if model.example is not None and model.example.axis not in known:
        yield none_called("Example", model.example.axis, "", "parameter", known)


def _defaults_of_laws(model: Model) -> Iterator[Fault]:
    theirs = {p.name for law in all_laws().values() for p in law.parameters}
    names, place = {*theirs, *(p.name for p in model.parameters)}, ("Model", model.name)
    for name, value in model.law_defaults.items():
        if name not in theirs:
            message = f"no law has a parameter {name!r}"
            yield Fault((*place, "law_defaults"), message, "", suggest(name, theirs))
        if not isinstance(value, int | float) and value not in names:
            allowed = "a number, or the name of a parameter"
            yield Fault((*place, "law_defaults"), f"{name} is {value!r} by default", allowed)


def tables_of_law(law: Law) -> Iterator[Fault]:
    """What is wrong with the parameters and states of a law."""
    yield from _header(law)
    yield from _parameters(law.parameters)
    yield from _states(law.states)
    if bool(law.states) != (law.rates is not None):
        yield Fault(("Law", law.name, "states"), "states and rates belong together")


def _header(thing: Model | Law) -> Iterator[Fault]:
    call = type(thing).__name__
    if not is_name(thing.name):
        yield Fault((call, 0, "name"), f"{thing.name!r} is no name", "letters, digits, - . _")
    for attribute in ("title", "reference"):
        value = getattr(thing, attribute)
        if not isinstance(value, str) or not value or not value.isprintable():
            yield Fault((call, 0, attribute), f"{attribute} is {value!r}", "a text of one line")
    if not isinstance(thing.numerics_version, int):
        yield Fault((call, thing.name, "numerics_version"), "is no whole number", "1, 2, ...")


def _states(states: Iterable[State]) -> Iterator[Fault]:
    each = list(states)
    yield from twice("State", [state.name for state in each])
    for state in each:
        if not state.name.isidentifier() or state.name.endswith("_dot"):
            yield Fault(("State", state.name, ""), f"{state.name!r} is no name of a state")
        yield from _unit("State", state.name, state.unit)


def _parameters(table: Iterable[Parameter]) -> Iterator[Fault]:
    parameters = list(table)
    names = [p.name for p in parameters]
    yield from twice("Parameter", names)
    for p in parameters:
        if not (p.name.isascii() and p.name.isidentifier()):
            yield Fault(("Parameter", p.name, ""), f"{p.name!r} is no name", "letters of ASCII")
        if not (p.symbol and p.meaning):
            yield Fault(("Parameter", p.name, ""), "has no symbol or no meaning")
        yield from _unit("Parameter", p.name, p.unit)
        yield from _default(p, names)


def _default(parameter: Parameter, names: list[str]) -> Iterator[Fault]:
    place, value = ("Parameter", parameter.name, "default"), parameter.default
    if value is None:
        if parameter.default_from not in names:
            yield none_called("Parameter", parameter.name, "default_from", "parameter", [*names],
                      str(parameter.default_from))  # fmt: skip
    elif parameter.default_from is not None:
        yield Fault(place, f"it has a default, {value!r}, and default_from", "one of them is None")
    elif not isinstance(value, int | float) or isinstance(value, bool) or isinf(value):
        allowed = "a number in SI; or None, and default_from = another parameter's name"
        yield Fault(place, f"its default is {value!r}", allowed)
    else:
        try:
            parameter.checked(value)
        except ValueError as error:
            yield Fault(place, f"its default {error}", parameter.allowed)


def _unit(call: str, name: str, unit: str, of: str = "") -> Iterator[Fault]:
    try:
        found = parse_unit(unit) if unit != "1" else None
    except (ValueError, TypeError, AttributeError) as error:
        yield Fault((call, name, "unit"), f"{of}{error}", 'as "N m-1", "kg", "1"')
        return
    if found is not None and found.factor != 1:
        message = f"{of}{unit!r} is not in SI (a case may give values in it all the same)"
        yield Fault((call, name, "unit"), message, "products of kg, m, s, rad, N, Pa, J, W")


def twice(call: str, names: list[str]) -> Iterator[Fault]:
    """Names that stand twice."""
    for name in dict.fromkeys(names):
        if names.count(name) > 1:
            yield Fault((call, name, ""), f"{name!r} stands there twice")
