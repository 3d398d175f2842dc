"""What is wrong with a model or a law that somebody else has written.

The laws that the models in the box are tested for: tables are complete, equations name what the
tables declare, units fit, accelerations follow from the energies, friction opposes slip.
"""

from __future__ import annotations

import random
import re
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass
from functools import partial
from typing import Any

import sympy
from sympy import Expr

from fiv_cli.errors import Problem
from fiv_cli.flags import PIECES
from fiv_cli.friction import all_laws, get_law, why_unfit
from fiv_cli.friction.base import Law, Slip
from fiv_cli.models.base import Contact, Equations, Model, Parameter, State
from fiv_cli.models.origin import Origin
from fiv_cli.models.symbols import Symbols
from fiv_cli.notation.names import ascii_name, listed, suggest
from fiv_cli.notation.units import parse_unit
from fiv_cli.own.dimensions import Dimension, MixedUnitsError, dimension, dimension_of, spoken
from fiv_cli.own.lines import Lines
from fiv_cli.own.load import is_name

ROUNDING = 1e-9
SHOWN = 160  # characters of an expression that are shown


@dataclass(frozen=True)
class Fault:
    """One thing wrong.

    Attributes
    ----------
    place : (call, key, keyword) as `Lines.of` takes them; the key is left out of what is said
        where it is a number
    """

    place: tuple[str, str | int, str]
    message: str
    allowed: str = ""
    suggestion: str = ""

    def problem(self, lines: Lines) -> Problem:
        """The same with its line."""
        named = ".".join(str(part) for part in self.place if isinstance(part, str) and part)
        line = lines.of(*self.place) or lines.of(self.place[0])
        return Problem(named, self.message, self.allowed, self.suggestion, line)


def problems_of(thing: Model | Law, origin: Origin) -> list[Problem]:
    """Everything that is wrong with a model or a law, each with its line."""
    lines = Lines(origin.text)
    checks = _OF_LAWS if isinstance(thing, Law) else _OF_MODELS
    for check in checks:  # what a later one finds would follow from what an earlier one does
        try:
            found = [fault.problem(lines) for fault in check(thing)]  # type: ignore[operator]
        except Exception as error:
            return [lines.problem(error, origin.path)]
        if found:
            return found
    return []


# --- tables ---------------------------------------------------------------------------------------
_TYPES: dict[str, tuple[Callable[[Any], bool], str]] = {
    "parameters": (
        lambda value: isinstance(value, tuple) and all(isinstance(p, Parameter) for p in value),
        "a tuple of Parameter(...), one alone with a comma behind it",
    ),
    "states": (callable, "lambda options: (State(...), ...), one alone with a comma behind it"),
    "equations": (callable, "a function equations(symbols, options)"),
    "contacts": (lambda value: isinstance(value, int), "how many contacts the equations return"),
}


def _types_of_model(model: Model) -> Iterator[Fault]:
    for name, (fits, allowed) in _TYPES.items():
        if not fits(getattr(model, name)):
            yield Fault(("Model", model.name, name), f"{name} is something else", allowed)


def _tables_of_model(model: Model) -> Iterator[Fault]:
    yield from _header(model)
    yield from _parameters(model.parameters)
    names = [p.name for p in model.parameters]
    states = model.states(model.default_options())
    yield from _states(states)
    for option in model.options:
        if option.text(option.default) != option.default:
            yield Fault(("Option", option.name, "default"), "is none of the choices")
    for forcing in model.forcings:
        if forcing.amplitude not in names:
            yield _no("Forcing", forcing.amplitude, "amplitude", "parameter", names)
    yield from _law_of(model)


def _law_of(model: Model) -> Iterator[Fault]:
    laws = all_laws()
    if not model.contacts:
        return
    if model.default_law not in laws:
        yield _no("Model", model.name, "default_law", "law", laws, model.default_law)
        return
    unfit = why_unfit(model, laws[model.default_law])
    if unfit and model.contacts:
        yield Fault(("Model", model.name, "default_law"), unfit)
    yield from _defaults_of_laws(model)
    known = [p.name for p in model.parameters_under(laws[model.default_law].parameters)]
    if model.example is not None and model.example.axis not in known:
        yield _no("Example", model.example.axis, "", "parameter", known)


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


def _tables_of_law(law: Law) -> Iterator[Fault]:
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
    yield from _twice("State", [state.name for state in each])
    for state in each:
        if not state.name.isidentifier() or state.name.endswith("_dot"):
            yield Fault(("State", state.name, ""), f"{state.name!r} is no name of a state")
        yield from _unit("State", state.name, state.unit)


def _parameters(table: Iterable[Parameter]) -> Iterator[Fault]:
    parameters = list(table)
    names = [p.name for p in parameters]
    yield from _twice("Parameter", names)
    for p in parameters:
        if ascii_name(p.name) != p.name or not p.name.isidentifier():
            yield Fault(("Parameter", p.name, ""), f"{p.name!r} is no name", "letters of ASCII")
        if not (p.symbol and p.meaning):
            yield Fault(("Parameter", p.name, ""), "has no symbol or no meaning")
        yield from _unit("Parameter", p.name, p.unit)
        yield from _default(p, names)


def _default(parameter: Parameter, names: list[str]) -> Iterator[Fault]:
    place, value = ("Parameter", parameter.name, "default"), parameter.default
    if value is None:
        if parameter.default_from not in names:
            yield _no("Parameter", parameter.name, "default_from", "parameter", [*names],
                      str(parameter.default_from))  # fmt: skip
    elif not isinstance(value, int | float) or isinstance(value, bool):
        yield Fault(place, f"its default is {value!r}", "a number in SI")
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


def _twice(call: str, names: list[str]) -> Iterator[Fault]:
    for name in dict.fromkeys(names):
        if names.count(name) > 1:
            yield Fault((call, name, ""), f"{name!r} stands there twice")


def _no(
    call: str, key: str | int, keyword: str, what: str, known: Iterable[str], name: str = ""
) -> Fault:
    names, wanted = [*known], name or str(key)
    message = f"there is no {what} {wanted!r}"
    return Fault((call, key, keyword), message, listed(names), suggest(wanted, names))


# --- equations ------------------------------------------------------------------------------------
@dataclass(frozen=True)
class _Written:
    """The equations of a model under some options, and what its symbols are measured in."""

    model: Model
    states: Mapping[str, str]
    symbols: Symbols
    equations: Equations
    units: Mapping[Expr, Dimension | None]

    @classmethod
    def of(cls, model: Model, options: Mapping[str, str]) -> _Written:
        symbols = Symbols()
        units: dict[Expr, Dimension | None] = {
            symbols.time: dimension("s"),
            symbols.zone: dimension("1"),
        }
        tables = model.parameters_under(get_law(model.default_law).parameters)
        units |= {symbols.parameter(p.name): dimension(p.unit) for p in tables}
        states = {state.name: state.unit for state in model.states(options)}
        for name, unit in states.items():
            units[symbols.coordinate(name)] = dimension(unit)
            units[symbols.velocity(name)] = _per_second(dimension(unit))
        for i in range(model.contacts):
            units |= dict.fromkeys(
                (symbols.tangential_force(i), symbols.normal_force(i)), dimension("N")
            )
            units[symbols.closed(i)] = dimension("1")
        if model.derived is not None:
            units |= {symbols.parameter(name): None for name in model.derived.names(options)}
        equations = model.mechanics(symbols, options)
        return cls(model, states, symbols, equations, units)

    @property
    def forces(self) -> list[Expr]:
        """The symbols of the forces of all contacts."""
        each = (self.symbols.tangential_force, self.symbols.normal_force)
        return [force(i) for i in range(self.model.contacts) for force in each]

    def named(self) -> Iterator[tuple[tuple[str, str | int, str], Expr, str]]:
        """(place, expression, unit) of everything."""
        equations = self.equations
        for name, acceleration in equations.accelerations.items():
            unit = f"{self.states.get(name, '1')} s-2".removeprefix("1 ")
            yield ("Equations", 0, "accelerations"), sympy.sympify(acceleration), unit
        yield ("Equations", 0, "kinetic_energy"), sympy.sympify(equations.kinetic_energy), "J"
        yield ("Equations", 0, "potential_energy"), sympy.sympify(equations.potential_energy), "J"
        for i, contact in enumerate(equations.contacts):
            table = {"slip_velocity": "m s-1", "normal_force": "N", "gap": "m"}
            for name, unit in table.items():
                expression = getattr(contact, name)
                if expression is not None:
                    yield ("Contact", i, name), sympy.sympify(expression), unit


def _per_second(found: Dimension) -> Dimension:
    mass, length, time = found
    return mass, length, time - 1


Check = Callable[[_Written], Iterator[Fault]]


def _each_option(check: Check, model: Model) -> Iterator[Fault]:
    """What a check finds under the first options under which it finds anything."""
    found = (list(check(written)) for written in _under_options(model))
    yield from next(filter(None, found), [])


def _some_option(check: Check, model: Model) -> Iterator[Fault]:
    """What a check finds under the default options, where it finds something under all."""
    found = [list(check(written)) for written in _under_options(model)]
    yield from found[0] if all(found) and found else []


def _under_options(model: Model) -> Iterator[_Written]:
    """The equations under the default options, and under each other choice of one of them."""
    defaults = model.default_options()
    others = ({o.name: c} for o in model.options for c in o.choices if c != o.default)
    for chosen in ({}, *others) if model.contacts else ():
        yield _Written.of(model, {**defaults, **chosen})


def _names_of_equations(written: _Written) -> Iterator[Fault]:
    equations = written.equations
    states = [str(name) for name in equations.accelerations]
    if set(states) != set(written.states):
        message = f"has {listed(states)}; the states are {listed(written.states)}"
        yield Fault(("Equations", 0, "accelerations"), message)
        return
    for place, expression, _ in written.named():
        for symbol in sorted(expression.free_symbols - written.units.keys(), key=str):
            yield _unknown_symbol(place, symbol, written)
    for i, contact in enumerate(equations.contacts):
        yield from _of_contact(i, contact, written)


def _unknown_symbol(place: tuple[str, str | int, str], symbol: Expr, written: _Written) -> Fault:
    kind, _, name = symbol.name.partition(".")
    what = {"p": "parameter", "q": "state"}.get(kind, "symbol")
    known = [s.name.partition(".")[2] for s in written.units if s.name.startswith(f"{kind}.")]
    return Fault(
        place, f"names the {what} {name or kind!r}, which no table has", listed(known),
        suggest(name, known) if known else "take symbols from the argument `symbols`",
    )  # fmt: skip


def _of_contact(number: int, contact: Contact, written: _Written) -> Iterator[Fault]:
    forces = {*written.forces}
    for keyword in ("slip_velocity", "normal_force", "gap"):
        expression = sympy.sympify(getattr(contact, keyword) or 0)
        own = forces & expression.free_symbols
        if own:
            message = f"depends on the force {min(map(str, own))}, which follows from it"
            allowed = "states, parameters and time"
            yield Fault(("Contact", number, keyword), message, allowed)
    if contact.law is not None:
        yield from _of_its_own_law(number, contact.law, written.model)
    if not contact.is_stop:
        yield from _of_slip(number, contact, written)


def _of_slip(number: int, contact: Contact, written: _Written) -> Iterator[Fault]:
    symbols, coordinate = written.symbols, contact.slip_coordinate
    names, place = [*written.equations.accelerations], ("Contact", number, "slip_coordinate")
    if coordinate not in names:
        yield _no(*place, "state", names, coordinate)
    elif not sympy.diff(contact.slip_velocity, symbols.velocity(coordinate)):
        yield Fault(place, f"the slip velocity does not depend on {coordinate}_dot")
    for earlier, other in enumerate(written.equations.contacts[:number]):
        both = not other.is_stop and other.slip_coordinate == coordinate
        if both and not _parallel(contact, other, written):
            numbers = f"contacts {earlier + 1} and {number + 1}"
            message = (
                f"{numbers} are both solved for {coordinate!r}, and slip in different directions"
            )
            yield Fault(place, message, "", "name another state that its slip velocity depends on")


def _of_its_own_law(number: int, name: str, model: Model) -> Iterator[Fault]:
    """The law that a contact has of its own is in the box, or in the file of its model."""
    try:
        origin = get_law(name).origin
    except KeyError:
        yield _no("Contact", number, "law", "law", all_laws(), name)
        return
    if origin not in (None, model.origin):
        message = f"the law {name!r} stands in another file"
        yield Fault(("Contact", number, "law"), message, "", "write it into this one")


def _parallel(one: Contact, other: Contact, written: _Written) -> bool:
    """Whether two contacts have one direction: those stick jointly."""
    rows = [
        [sympy.diff(c.slip_velocity, written.symbols.velocity(n))
         for n in written.equations.accelerations]
        for c in (one, other)
    ]  # fmt: skip
    values = _values(written, {})
    matrix = sympy.Matrix(rows).subs(values)
    return bool(matrix.rank(iszerofunc=lambda x: abs(x) < ROUNDING) == 1)


def _units_of_equations(written: _Written) -> Iterator[Fault]:
    """A wrong unit, told at the parameter that would set it right where one alone would."""
    mistakes = list(_mistakes(written, written.units))
    if not mistakes:
        return
    place, message, symbols = mistakes[0]
    bare = [n for _, e, _ in written.named() for n in e.atoms(sympy.Float)]
    if bare:
        yield Fault(place, message, "", f"the bare number {bare[0]:g}: make a Parameter of it")
        return
    suspects = [
        parameter
        for parameter in written.model.parameters
        if (symbol := written.symbols.parameter(parameter.name)) in symbols
        and not list(_mistakes(written, {**written.units, symbol: None}))
    ]
    if suspects:
        first, *others = suspects
        message += f"; with another unit of {first.name} (now {first.unit!r}) all would fit"
        message += "".join(f", or of {p.name} ({p.unit!r})" for p in others)
        place = ("Parameter", first.name, "unit")
    yield Fault(place, message)


def _mistakes(
    written: _Written, units: Mapping[Expr, Dimension | None]
) -> Iterator[tuple[tuple[str, str | int, str], str, set[Any]]]:
    for place, expression, unit in written.named():
        try:
            found = dimension_of(expression, units)
        except MixedUnitsError as error:
            terms = set().union(*(term.free_symbols for term in error.terms))
            yield place, _spoken(str(error)), terms
            continue
        if found is not None and found != dimension(unit):
            keyword = place[2].replace("_", " ")
            message = f"{keyword}: {_shown(expression)} is in {spoken(found)}, not in {unit}"
            yield place, message, expression.free_symbols


# --- mechanics ------------------------------------------------------------------------------------
def _mechanics(written: _Written) -> Iterator[Fault]:
    yield from _inertia(written)
    yield from _affine(written)
    yield from _friction_opposes_slip(written)
    yield from _constant_load(written)


def _inertia(written: _Written) -> Iterator[Fault]:
    kinetic = sympy.sympify(written.equations.kinetic_energy)
    for name in written.equations.accelerations:
        if not sympy.diff(kinetic, written.symbols.velocity(name)):
            message = f"does not hold {name}_dot: the energy of that motion is missing"
            yield Fault(("Equations", 0, "kinetic_energy"), message)


def _constant_load(written: _Written) -> Iterator[Fault]:
    known = {written.symbols.parameter(p.name) for p in written.model.parameters}
    for i, contact in enumerate(written.equations.contacts if written.model.constant_load else ()):
        load = contact.normal_force
        if not contact.is_stop and (load is None or sympy.sympify(load).free_symbols - known):
            message = f"the normal force of contact {i + 1} is not constant"
            yield Fault(("Model", written.model.name, "constant_load"), message, "", "leave it out")


def _affine(written: _Written) -> Iterator[Fault]:
    for name, acceleration in written.equations.accelerations.items():
        slopes = [sympy.diff(acceleration, force) for force in written.forces]
        if any(slope.free_symbols & {*written.forces} for slope in map(sympy.sympify, slopes)):
            message = f"that of {name!r} is not linear in the forces of contacts"
            yield Fault(("Equations", 0, "accelerations"), message)


def _friction_opposes_slip(written: _Written) -> Iterator[Fault]:
    symbols, equations = written.symbols, written.equations
    for i, contact in enumerate(equations.contacts):
        if contact.is_stop:
            continue
        force = symbols.tangential_force(i)
        response: Any = sum(
            sympy.diff(contact.slip_velocity, symbols.velocity(name)) * sympy.diff(a, force)
            for name, a in equations.accelerations.items()
        )
        effect = _number(sympy.sympify(response), _values(written, {}))
        if effect >= 0.0:
            way = "drives" if effect else "does not act on"
            message = f"F_T of contact {i + 1} {way} its slip: it acts along v_rel on the model"
            hint = "v_rel is the velocity of the drive less that of the body"
            yield Fault(("Contact", i, "slip_velocity"), message, "", hint)


def _energies(written: _Written) -> Iterator[Fault]:
    """Without damping, excitation and friction the Jacobi integral is constant.

    A model may leave a force out by choice; under some option it must be so.
    """
    terms = [term.subs(_switched_off(written)) for term in _power(written)]
    values = _values(written, {})
    numbers = [_number(term, values) for term in terms]
    if abs(sum(numbers)) <= ROUNDING * sum(map(abs, numbers)):
        return
    message = "do not fit the accelerations"
    left = sympy.expand(sum(terms))
    if left.count_ops() < 60:
        message += f": without damping, excitation and friction they change by {_shown(left)}"
    hint = 'a parameter that takes energy out or in says role="damping", an excitation is a Forcing'
    yield Fault(("Equations", 0, "potential_energy"), f"energies {message}", "", hint)


def _power(written: _Written) -> list[Expr]:
    """The terms of the rate of the Jacobi integral, T + U where nothing turns."""
    symbols, equations = written.symbols, written.equations
    total = sympy.sympify(equations.potential_energy - equations.kinetic_energy)
    for name in equations.accelerations:
        momentum = sympy.diff(equations.kinetic_energy, symbols.velocity(name))
        total += momentum * symbols.velocity(name)
    terms = [sympy.diff(total, symbols.time)]
    for name, acceleration in equations.accelerations.items():
        terms.append(sympy.diff(total, symbols.coordinate(name)) * symbols.velocity(name))
        terms.append(sympy.diff(total, symbols.velocity(name)) * acceleration)
    for i, contact in enumerate(equations.contacts):
        if contact.normal_force is None:  # it keeps the gap closed: no power, on its rate
            rate = sum(
                sympy.diff(contact.gap, symbols.coordinate(n)) * symbols.velocity(n)
                for n in equations.accelerations
            )
            terms.append(-symbols.normal_force(i) * rate)
    return [sympy.sympify(term) for term in terms]


def _switched_off(written: _Written) -> dict[Expr, Any]:
    """Friction, damping and excitation at zero, elastic contacts closed."""
    symbols, model = written.symbols, written.model
    off: dict[Expr, Any] = {symbols.tangential_force(i): 0 for i in range(model.contacts)}
    off |= {symbols.parameter(p.name): 0 for p in model.parameters if p.role == "damping"}
    off |= {symbols.parameter(forcing.amplitude): 0 for forcing in model.forcings}
    off |= {symbols.closed(i): 1 for i in range(model.contacts)}
    for i, contact in enumerate(written.equations.contacts):
        if contact.normal_force is not None:
            off[symbols.normal_force(i)] = contact.normal_force
    return off


def _values(written: _Written, fixed: Mapping[Expr, float]) -> dict[Expr, float]:
    """A value for every symbol: parameters near their defaults, states by chance."""
    chance = random.Random(0)
    values = {symbol: chance.uniform(0.3, 0.9) for symbol in sorted(written.units, key=str)}
    for p in written.model.parameters:
        if p.default:
            values[written.symbols.parameter(p.name)] = p.default * chance.uniform(0.8, 1.2)
    return {**values, **fixed}


def _number(expression: Expr, values: Mapping[Expr, float]) -> float:
    return float(expression.subs(values).evalf())


_SLIP = {"v": "m s-1", "sign": "1", "speed": "m s-1", "N": "N"}


# --- laws -----------------------------------------------------------------------------------------
def _forces_of_law(law: Law) -> Iterator[Fault]:
    names = _SLIP
    states = {state.name: state.unit for state in law.states}
    own = {name: sympy.Symbol(name, real=True) for name in (*names, *states)}
    v, sign, speed, normal = (own[name] for name in names)
    rows = law.row_symbols()
    slip = Slip(v, sign, speed, normal, {name: own[name] for name in states}, rows)
    parameters = {p.name: sympy.Symbol(f"p.{p.name}", real=True) for p in law.parameters}
    units: dict[Expr, Dimension | None] = {own[n]: dimension(u) for n, u in names.items()}
    units |= {own[name]: dimension(unit) for name, unit in states.items()}
    units |= {parameters[p.name]: dimension(p.unit) for p in law.parameters}
    units |= {number: None for row in rows for number in row}
    found = {"force": (law.force(slip, parameters), dimension("N"))}
    if law.capacity is not None:
        found["capacity"] = (law.capacity(slip.N, parameters), dimension("N"))
    rates = law.rates(slip, parameters) if law.rates is not None else {}
    if set(rates) != set(states):
        message = f"gives the rates of {listed([*rates])}; its states are {listed(states)}"
        yield Fault(("Law", law.name, "rates"), message)
    found |= {f"rate of {n}": (rate, _per_second(units[own[n]] or dimension("1")))
              for n, rate in rates.items() if n in own}  # fmt: skip
    for name, (expression, unit) in found.items():
        yield from _of_law(law, name, sympy.sympify(expression), unit, units)


def _pieces_of_law(law: Law) -> Iterator[Fault]:
    """Pieces are alike, lead to pieces, and are told apart by as many guards as they have exits."""
    if not law.pieces:
        return
    names, (elements, width) = [piece.name for piece in law.pieces], law.shape
    ways = len(law.pieces[0].exits)
    yield from _twice("Piece", names)
    for piece in law.pieces:
        place = ("Piece", piece.name, "")
        if (len(piece.row), len(piece.exits)) != (width, ways):
            yield Fault(place, "its numbers or its exits are not as many as those of the others")
        if piece.name.split()[0] not in PIECES:
            message = f"{piece.name.split()[0]!r} is no word that events are booked under"
            yield Fault(place, message, listed(PIECES))
        for way in (way for way in piece.exits if way is not None):
            if way.to not in names:
                yield _no("Exit", way.to, "to", "piece", names)
            if len(way.zeros) != ways:
                yield Fault(("Exit", way.to, "zeros"), f"has not {ways} numbers, one of each guard")
    yield from _guards_of_law(law, elements, ways)


def _guards_of_law(law: Law, elements: int, ways: int) -> Iterator[Fault]:
    v = sympy.Symbol("v", real=True)
    states = {state.name: sympy.Symbol(state.name, real=True) for state in law.states}
    slip = Slip(v, sympy.Integer(1), v, sympy.Symbol("N"), states, law.row_symbols())
    given = law.guards(slip, law.defaults) if law.guards is not None else ()
    if [len(each) for each in given] != [ways] * elements:
        message = f"gives no {ways} guards, one of each exit, of {elements} elements"
        yield Fault(("Law", law.name, "guards"), message)
    resting = law.resting(1.0, law.defaults) if law.resting is not None else ()
    for name in (name for name in resting if name not in law.places):
        yield _no("Law", law.name, "resting", "piece", law.places, name)


def _of_law(
    law: Law,
    name: str,
    expression: Expr,
    unit: Dimension,
    units: Mapping[Expr, Dimension | None],
) -> Iterator[Fault]:
    place = ("Law", law.name, "rates" if name.startswith("rate") else name)
    strange = sorted(map(str, expression.free_symbols - units.keys()))
    if strange:
        message = (
            f"{name} names {strange[0]!r}, which is neither a parameter nor a state of the law"
        )
        yield Fault(place, message, listed([_spoken(symbol.name) for symbol in units]))
        return
    try:
        found = dimension_of(expression, units)
    except MixedUnitsError as error:
        yield Fault(place, f"{name}: {_spoken(str(error))}")
        return
    if found is not None and found != unit:
        yield Fault(place, f"{name} is in {spoken(found)}, not in {spoken(unit)}")


def _shown(expression: Expr) -> str:
    text = _spoken(sympy.sstr(expression))
    return text if len(text) <= SHOWN else f"{text[:SHOWN]} ..."


def _spoken(text: str) -> str:
    """Symbols by the names that a model gives them."""
    return re.sub(r"\b[pq]\.", "", re.sub(r"\b(F_[NT])\.(\d+)", _numbered, text))


def _numbered(force: re.Match[str]) -> str:
    return f"{force[1]} of contact {int(force[2]) + 1}"


_OF_MODELS = (
    _types_of_model,
    _tables_of_model,
    *(
        partial(_each_option, check)
        for check in (_names_of_equations, _units_of_equations, _mechanics)
    ),
    partial(_some_option, _energies),
)
_OF_LAWS = (_tables_of_law, _pieces_of_law, _forces_of_law)
