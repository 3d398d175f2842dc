"""What is wrong with a model or a law that somebody else has written.

The laws that the models in the box are tested for: tables are complete, equations name what the
tables declare, units fit, accelerations follow from the energies, friction opposes slip.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import replace
from functools import partial
from math import isnan, nan

import numpy as np
import sympy
from sympy import Expr

from fiv_cli.errors import Problem, UsageError
from fiv_cli.flags import PIECES
from fiv_cli.friction.base import HELD, Law, Slip
from fiv_cli.friction.powers import eased
from fiv_cli.models.base import Model
from fiv_cli.models.origin import Origin
from fiv_cli.notation.names import listed, suggest
from fiv_cli.own.dimensions import Dimension, MixedUnitsError, dimension, dimension_of, spoken
from fiv_cli.own.equations import (
    names_in,
    names_of_equations,
    units_of_equations,
    unused_parameters,
    without_series,
)
from fiv_cli.own.fault import Fault, named, none_called, shown
from fiv_cli.own.lines import Lines
from fiv_cli.own.mechanics import energies, mechanics
from fiv_cli.own.tables import tables_of_law, tables_of_model, twice, types_of_law, types_of_model
from fiv_cli.own.written import each_option, per_second, some_option

_SLIP = {"v": "m s-1", "sign": "1", "speed": "m s-1", "N": "N"}
"""What a law is written in."""

SLOW = 1e-3  # m/s, of a slip that no law is known to drive
FAST = 1.0  # m/s, at which both sides are compared
FASTEST = 100.0  # m/s, up to which a law is looked at
SIDES = "slip.speed is |v|; slip.v has a sign"
ROUNDING = 1e-12
ALIKE = 1e-9  # of the larger force


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


class Names(dict[str, Expr]):
    """Parameters, or states, of a law by name; what is not there is told with what is."""

    def __init__(self, what: str, prefix: str, names: Iterable[str]) -> None:
        self.what = what
        super().__init__({name: sympy.Symbol(f"{prefix}{name}", real=True) for name in names})

    def __missing__(self, name: str) -> Expr:
        hint = suggest(name, [*self])
        message = f"there is no {self.what} {name!r}; the law has {listed([*self])}"
        raise UsageError(f"{message}\nnext: {hint}" if hint else message)


def _symbols_of(law: Law) -> tuple[Slip, Names]:
    """What a law is written in, and its parameters."""
    v, sign, speed, normal = (sympy.Symbol(name, real=True) for name in _SLIP)
    states = Names("state", "", [state.name for state in law.states])
    slip = Slip(v, sign, speed, normal, states, law.row_symbols())
    return slip, Names("parameter", "p.", [parameter.name for parameter in law.parameters])


def _forces_of_law(law: Law) -> Iterator[Fault]:
    slip, parameters = _symbols_of(law)
    states = {state.name: state.unit for state in law.states}
    own = {name: sympy.Symbol(name, real=True) for name in (*_SLIP, *states)}
    units: dict[Expr, Dimension | None] = {own[n]: dimension(u) for n, u in _SLIP.items()}
    units |= {own[name]: dimension(unit) for name, unit in states.items()}
    units |= {parameters[p.name]: dimension(p.unit) for p in law.parameters}
    units |= {number: None for row in slip.rows for number in row}
    found = {"force": (law.force(slip, parameters), dimension("N"))}
    if law.capacity is not None:
        found["capacity"] = (law.capacity(slip.N, parameters), dimension("N"))
    rates = law.rates(slip, parameters) if law.rates is not None else {}
    if not isinstance(rates, Mapping):
        allowed = "{name of a state: its rate, ...}"
        yield Fault(("Law", law.name, "rates"), f"gives {type(rates).__name__}", allowed)
        return
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


def _rests(law: Law) -> Iterator[Fault]:
    """What steady slip comes to is asked for where equilibria are."""
    try:
        if law.rests and not law.pieces:
            law.sliding(*_symbols_of(law))
    except (ValueError, NotImplementedError):
        message = "steady slip does not follow from the rates: no single solution in closed form"
        hint = "say the force there: steady=lambda slip, p: ..."
        yield Fault(("Law", law.name, "rates"), message, "", hint)


def _begins(law: Law) -> Iterator[Fault]:
    """Slip begins at v = 0: there the force, and how it changes, are numbers."""
    if law.pieces or law.states:
        return
    (slip, parameters), defaults = _symbols_of(law), law.defaults
    values = {symbol: defaults[name] for name, symbol in parameters.items()}
    begun = replace(slip, sign=sympy.Integer(1), speed=slip.v, N=sympy.Integer(1))
    found = eased(law.force(begun, parameters), slip.v)
    for what in ("F_T", "its slope", "its second derivative"):
        if not found.subs(slip.v, 0).subs(values).is_finite:
            message = f"{what} is no number at v = 0, where slip begins"
            hint = "write a power (slip.speed / p['v_0']) ** p['q'], without exp or log; give what "
            hint += "is taken the logarithm of, or divides, a part that does not vanish at rest"
            yield Fault(("Law", law.name, "force"), message, "", hint)
            return
        found = found.diff(slip.v)


def _signed_powers(law: Law) -> Iterator[Fault]:
    """A power with an exponent that is no fixed whole number is one of |v|: v itself has a sign."""
    if law.pieces:
        return
    slip, parameters = _symbols_of(law)
    values = {symbol: law.defaults[name] for name, symbol in parameters.items()}
    back = {slip.v: -1, slip.speed: 1, slip.sign: -1, slip.N: 1, **values}
    for power in sympy.sympify(law.force(slip, parameters)).atoms(sympy.Pow):
        base = power.base.subs(back)
        if not power.exp.is_Integer and slip.v in power.base.free_symbols and base.is_negative:
            message = f"{shown(power)}: a power of what is negative where v is"
            yield Fault(("Law", law.name, "force"), message, "", SIDES)
            return


def _bounded(law: Law) -> Iterator[Fault]:
    """What the force is divided by vanishes at no speed."""
    if law.pieces or law.states:
        return
    slip, parameters = _symbols_of(law)
    values = {symbol: law.defaults[name] for name, symbol in parameters.items()}
    for power in sympy.sympify(law.force(slip, parameters)).atoms(sympy.Pow):
        for sign in (1, -1) if power.exp.subs(values).is_negative else ():
            along = {slip.v: sign * slip.speed, slip.sign: sign, slip.N: 1, **values}
            if (v := _sign_change(power.base.subs(along), slip.speed)) is not None:
                message = f"near v = {sign * v:.2g} m/s F_T has no bound: it has {shown(power)}"
                hint = "divide by what vanishes at no speed" if sign > 0 else SIDES
                yield Fault(("Law", law.name, "force"), message, "", hint)
                return


def _sign_change(expression: Expr, speed: Expr) -> float | None:
    """The first speed, m/s, at which an expression has another sign; None where it keeps it."""
    speeds = np.append(0.0, np.geomspace(SLOW, FASTEST, 2000))
    with np.errstate(all="ignore"):
        found = np.sign(sympy.lambdify(speed, expression, "numpy")(speeds))
        steps = np.diff(np.broadcast_to(found, speeds.shape))
    changes = np.flatnonzero(np.isfinite(steps) & (steps != 0.0))
    return float(speeds[changes[0]]) if changes.size else None


def _opposes_slip(law: Law) -> Iterator[Fault]:
    """The force of steady slip is along v_rel, and stick bears what slip begins with."""
    if law.pieces:
        return
    none = [v for v in (-FAST, FAST) if isnan(_size_at(law, v))]
    if len(none) == 1:
        message = f"at v = {none[0]:g} m/s F_T is no number, at {-none[0]:g} m/s it is one"
        yield Fault(("Law", law.name, "force"), message, "", SIDES)
        return
    drives = [v for v in (-SLOW, SLOW) if _force_at(law, v) * v < 0.0]
    if drives:
        message = f"at v = {drives[0]:g} m/s it drives the slip: F_T is along v, which turns"
        hint = "friction that turns with slip is slip.sign * ..., or an odd function of slip.v"
        hint += ", or of states where their rates are zero" if law.states else ""
        yield Fault(("Law", law.name, "force"), message, "", hint)
    elif law.capacity is not None and not law.states:
        borne, begun = float(law.capacity(1.0, law.defaults)), abs(_force_at(law, 0.0))
        if borne < begun * (1.0 - ROUNDING):
            message = f"stick bears {borne:g} N where slip begins with {begun:g} N (N = 1 N)"
            hint = "what sticks would have no state to go on in"
            yield Fault(("Law", law.name, "capacity"), message, "", hint)


def asymmetry(law: Law) -> str:
    """What differs between slip to the one and to the other side, in one line; empty if none."""
    if law.pieces:
        return ""
    back, forth = (_size_at(law, v) for v in (-FAST, FAST))
    if abs(back - forth) <= ALIKE * max(back, forth):
        return ""
    sizes = f"at v = {-FAST:g} m/s |F_T| is {back:.3g} N, at {FAST:g} m/s {forth:.3g} N (N = 1 N)"
    return f"{law.name} is asymmetric: {sizes}; slip.speed is |v|, slip.v has a sign"


def _size_at(law: Law, v: float) -> float:
    """|F_T| in N; nan where it is no number, as the logarithm of what is negative is none."""
    try:
        return abs(_force_at(law, v))
    except TypeError:
        return nan


def _force_at(law: Law, v: float) -> float:
    sign = -1.0 if v < 0.0 else 1.0
    at = Slip(*map(sympy.Float, (v, sign, abs(v), 1.0)))
    return float(sympy.sympify(law.sliding(at, law.defaults)))


def _unused_parameters(law: Law) -> Iterator[Fault]:
    """Parameters that nothing reads: a sweep over one would be flat."""
    slip, parameters = _symbols_of(law)
    given = [law.force(slip, parameters)]
    given += [] if law.capacity is None else [law.capacity(slip.N, parameters)]
    given += [] if law.rates is None else law.rates(slip, parameters).values()
    others = [requirement.reads for requirement in law.requirements], law.structural
    used = names_in((given, others, [parameter.default_from for parameter in law.parameters]))
    for parameter in () if law.pieces or law.surface else law.parameters:
        if parameter.name not in used:
            hint = "use it, or take it out"
            yield Fault(("Parameter", parameter.name, ""), "the law does not read it", "", hint)


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
    yield from without_series(place, expression)
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
_OF_LAWS = (
    types_of_law,
    tables_of_law,
    _pieces_of_law,
    _forces_of_law,
    _rests,
    _begins,
    _signed_powers,
    _bounded,
    _opposes_slip,
    _unused_parameters,
)
