"""What is wrong with the names and the units in the equations of a model."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import is_dataclass
from typing import Any

import sympy
from sympy import Expr
from sympy.core.function import Application

from fiv_cli.codegen.graph import UNARY
from fiv_cli.friction import all_laws, get_law
from fiv_cli.models.base import Contact, Model
from fiv_cli.notation.names import listed, suggest
from fiv_cli.own.dimensions import Dimension, MixedUnitsError, dimension, dimension_of, spoken
from fiv_cli.own.fault import Fault, Place, named, none_called, shown
from fiv_cli.own.written import Written, under_options, values_of

ROUNDING = 1e-9


def names_of_equations(written: Written) -> Iterator[Fault]:
    """What equations name that no table has, and contacts that cannot be solved."""
    equations = written.equations
    states = [str(name) for name in equations.accelerations]
    if set(states) != set(written.states):
        message = f"has {listed(states)}; the states are {listed(written.states)}"
        yield Fault(("Equations", 0, "accelerations"), message)
        return
    for place, expression, _ in written.named():
        for symbol in sorted(expression.free_symbols - written.units.keys(), key=str):
            yield _unknown_symbol(place, symbol, written)
        yield from without_series(place, expression)
    for i, contact in enumerate(equations.contacts):
        yield from _of_contact(i, contact, written)


def without_series(place: Place, expression: Expr) -> Iterator[Fault]:
    """What no step of a Taylor series can be taken of."""
    found = {one for one in expression.atoms(Application) if one.func.__name__ not in UNARY}
    for one in sorted(found, key=str):
        hint = "what changes from one side to the other is a contact, or smooth: tanh"
        if one.func in (sympy.Abs, sympy.sign):
            hint = f"of a slip velocity slip.speed is |v|, slip.sign its sign; else {hint}"
        yield Fault(place, f"{shown(one)} has no series", f"+ - * / **, {listed(UNARY)}", hint)


def _unknown_symbol(place: Place, symbol: Expr, written: Written) -> Fault:
    kind, _, name = symbol.name.partition(".")
    what = {"p": "parameter", "q": "state", "F_T": "force", "F_N": "force"}.get(kind, "symbol")
    if what == "force":
        count = len(written.equations.contacts)
        message = f"names {named(symbol.name)}, of {count}: tangential_force(0) is of the first"
        return Fault(place, message)
    known = [s.name.partition(".")[2] for s in written.units if s.name.startswith(f"{kind}.")]
    return Fault(
        place, f"names the {what} {name or kind!r}, which no table has", listed(known),
        suggest(name, known) if known else "take symbols from the argument `symbols`",
    )  # fmt: skip


def _of_contact(number: int, contact: Contact, written: Written) -> Iterator[Fault]:
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


def _of_slip(number: int, contact: Contact, written: Written) -> Iterator[Fault]:
    symbols, coordinate = written.symbols, contact.slip_coordinate
    names, place = [*written.equations.accelerations], ("Contact", number, "slip_coordinate")
    if coordinate not in names:
        yield none_called(*place, "state", names, coordinate)
    elif not sympy.diff(contact.slip_velocity, symbols.velocity(coordinate)):
        yield Fault(place, f"the slip velocity does not depend on {coordinate}_dot")
    for earlier, other in enumerate(written.equations.contacts[:number]):
        both = not other.is_stop and other.slip_coordinate == coordinate
        if both and not _parallel(contact, other, written):
            numbers = f"contacts {earlier + 1} and {number + 1}"
            message = (
                f"{numbers} are both solved for {coordinate!r}, and slip in different directions"
            )
            hint = "name another state that its slip velocity depends on; where each has its "
            hint += "contact, what one more bears in stick is not determined: give it a mass"
            yield Fault(place, message, "", hint)


def _of_its_own_law(number: int, name: str, model: Model) -> Iterator[Fault]:
    """The law that a contact has of its own is in the box, or in the file of its model."""
    try:
        origin = get_law(name).origin
    except KeyError:
        yield none_called("Contact", number, "law", "law", all_laws(), name)
        return
    if origin not in (None, model.origin):
        message = f"the law {name!r} stands in another file"
        yield Fault(("Contact", number, "law"), message, "", "write it into this one")


def _parallel(one: Contact, other: Contact, written: Written) -> bool:
    """Whether two contacts have one direction: those stick jointly."""
    rows = [
        [sympy.diff(c.slip_velocity, written.symbols.velocity(n))
         for n in written.equations.accelerations]
        for c in (one, other)
    ]  # fmt: skip
    values = values_of(written, {})
    matrix = sympy.Matrix(rows).subs(values)
    return bool(matrix.rank(iszerofunc=lambda x: abs(x) < ROUNDING) == 1)


def unused_parameters(model: Model) -> Iterator[Fault]:
    """Parameters that nothing reads under any options: a sweep over one would be flat.

    One that says where its source has it (`equation`) may stand for completeness.
    """
    read = [requirement.reads for requirement in model.requirements]
    others = [parameter.default_from for parameter in model.parameters]
    told = (model.law_defaults, model.derived and model.derived.sources, read, others, model.varied)
    used = names_in((told, model.forcings, [w.equations for w in under_options(model)]))
    if model.revolution or model.surface:  # functions, of which only the text tells
        text = model.origin.text if model.origin else ""
        used |= {
            p.name for p in model.parameters if len(re.findall(f"['\"]{p.name}['\"]", text)) > 1
        }
    for parameter in model.parameters:
        if parameter.name not in used and not parameter.equation:
            hint = "use it, take it out, or say where the source has it: equation=..."
            yield Fault(("Parameter", parameter.name, ""), "no equation depends on it", "", hint)


def names_in(thing: Any) -> set[str]:
    """Names of parameters, and texts, in expressions and in all that holds them."""
    if isinstance(thing, str):
        return {thing}
    if isinstance(thing, sympy.Basic):
        return {symbol.name.removeprefix("p.") for symbol in thing.free_symbols}
    if is_dataclass(thing):
        thing = vars(thing)
    values = thing.values() if isinstance(thing, Mapping) else thing
    return set().union(*map(names_in, values)) if isinstance(values, Iterable) else set()


def units_of_equations(written: Written) -> Iterator[Fault]:
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
    written: Written, units: Mapping[Expr, Dimension | None]
) -> Iterator[tuple[Place, str, set[Any]]]:
    for place, expression, unit in written.named():
        try:
            found = dimension_of(expression, units)
        except MixedUnitsError as error:
            terms = set().union(*(term.free_symbols for term in error.terms))
            yield place, named(str(error)), terms
            continue
        if found is not None and found != dimension(unit):
            keyword = place[2].replace("_", " ")
            message = f"{keyword}: {shown(expression)} is in {spoken(found)}, not in {unit}"
            yield place, message, expression.free_symbols
