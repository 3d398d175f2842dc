"""What is wrong with a model or a law that somebody else has written.

The laws that the models in the box are tested for: tables are complete, equations name what the
tables declare, units fit, accelerations follow from the energies, friction opposes slip.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from functools import partial

import sympy
from sympy import Expr

from fiv_cli.errors import Problem
from fiv_cli.flags import PIECES
from fiv_cli.friction.base import HELD, Law, Slip
from fiv_cli.models.base import Model
from fiv_cli.models.origin import Origin
from fiv_cli.notation.names import listed
from fiv_cli.own.dimensions import Dimension, MixedUnitsError, dimension, dimension_of, spoken
from fiv_cli.own.equations import (
    names_of_equations,
    units_of_equations,
    unused_parameters,
    without_series,
)
from fiv_cli.own.fault import Fault, named, none_called
from fiv_cli.own.lines import Lines
from fiv_cli.own.mechanics import energies, mechanics
from fiv_cli.own.tables import tables_of_law, tables_of_model, twice, types_of_model
from fiv_cli.own.written import each_option, per_second, some_option

_SLIP = {"v": "m s-1", "sign": "1", "speed": "m s-1", "N": "N"}
"""What a law is written in."""

SLOW = 1e-3  # m/s, of a slip that no law is known to drive
ROUNDING = 1e-12


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
    found |= {f"rate of {n}": (rate, per_second(units[own[n]] or dimension("1")))
              for n, rate in rates.items() if n in own}  # fmt: skip
    read = set().union(
        *(sympy.sympify(expression).free_symbols for expression, _ in found.values())
    )
    held = {sympy.Symbol(name, real=True): dimension(unit) for name, unit in HELD.items()}
    units |= {symbol: unit for symbol, unit in held.items() if symbol in read}
    for name, (expression, unit) in found.items():
        yield from _of_law(law, name, sympy.sympify(expression), unit, units)


def _pieces_of_law(law: Law) -> Iterator[Fault]:
    """Pieces are alike, lead to pieces, and are told apart by as many guards as they have exits."""
    if not law.pieces:
        return
    names, (elements, width) = [piece.name for piece in law.pieces], law.shape
    ways = len(law.pieces[0].exits)
    yield from twice("Piece", names)
    for piece in law.pieces:
        place = ("Piece", piece.name, "")
        if (len(piece.row), len(piece.exits)) != (width, ways):
            yield Fault(place, "its numbers or its exits are not as many as those of the others")
        if piece.name.split()[0] not in PIECES:
            message = f"{piece.name.split()[0]!r} is no word that events are booked under"
            yield Fault(place, message, listed(PIECES))
        for way in (way for way in piece.exits if way is not None):
            if way.to not in names:
                yield none_called("Exit", way.to, "to", "piece", names)
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
        yield none_called("Law", law.name, "resting", "piece", law.places, name)


def _opposes_slip(law: Law) -> Iterator[Fault]:
    """A force without memory is along v_rel, and stick bears what slip begins with."""
    if law.states or law.pieces:
        return
    drives = [v for v in (-SLOW, SLOW) if _force_at(law, v) * v < 0.0]
    if drives:
        message = f"at v = {drives[0]:g} m/s it drives the slip: F_T is along v, which turns"
        hint = "friction that turns with slip is slip.sign * ..., or an odd function of slip.v"
        yield Fault(("Law", law.name, "force"), message, "", hint)
    elif law.capacity is not None:
        borne, begun = float(law.capacity(1.0, law.defaults)), abs(_force_at(law, 0.0))
        if borne < begun * (1.0 - ROUNDING):
            message = f"stick bears {borne:g} N where slip begins with {begun:g} N (N = 1 N)"
            hint = "what sticks would have no state to go on in"
            yield Fault(("Law", law.name, "capacity"), message, "", hint)


def _force_at(law: Law, v: float) -> float:
    sign = -1.0 if v < 0.0 else 1.0
    at = Slip(*map(sympy.Float, (v, sign, abs(v), 1.0)))
    return float(sympy.sympify(law.force(at, law.defaults)))


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
        yield Fault(place, message, listed([named(symbol.name) for symbol in units]))
        return
    structural = [sympy.Symbol(f"p.{name}", real=True) for name in law.structural]
    yield from without_series(place, expression, structural)
    try:
        found = dimension_of(expression, units)
    except MixedUnitsError as error:
        yield Fault(place, f"{name}: {named(str(error))}")
        return
    if found is not None and found != unit:
        yield Fault(place, f"{name} is in {spoken(found)}, not in {spoken(unit)}")


_OF_MODELS = (
    types_of_model,
    tables_of_model,
    *(partial(each_option, check) for check in (names_of_equations, units_of_equations, mechanics)),
    partial(some_option, energies),
    unused_parameters,
)
_OF_LAWS = (tables_of_law, _pieces_of_law, _forces_of_law, _opposes_slip)
