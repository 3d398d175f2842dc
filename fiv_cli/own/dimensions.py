"""What an expression is measured in, from what its symbols are measured in."""

from __future__ import annotations

from collections.abc import Mapping
from fractions import Fraction

import sympy
from sympy import Expr
from sympy.functions.elementary.hyperbolic import HyperbolicFunction
from sympy.functions.elementary.trigonometric import TrigonometricFunction

from fiv_cli.notation.units import parse_unit

Dimension = tuple[Fraction, Fraction, Fraction]
"""Exponents of kg, m and s; the radian counts as 1."""

NUMBER: Dimension = (Fraction(0), Fraction(0), Fraction(0))
_NAMES = ("kg", "m", "s")
_SPOKEN = ("1", "N", "N m", "N m-1", "N s m-1", "N m s", "m s-1", "m s-2", "N m-2", "N m-3", "s-1")
_OF_NUMBERS = (sympy.exp, sympy.log, TrigonometricFunction, HyperbolicFunction)


class MixedUnitsError(ValueError):
    """Two quantities that cannot stand together; `terms` are the two."""

    def __init__(self, message: str, *terms: Expr) -> None:
        self.terms = terms
        super().__init__(message)


def dimension(unit: str) -> Dimension:
    """The dimension of a unit; ValueError where it is none."""
    parsed = parse_unit(unit) if unit != "1" else parse_unit("rad")
    return Fraction(parsed.mass), Fraction(parsed.length), Fraction(parsed.time)


def spoken(dimension_: Dimension) -> str:
    """A dimension as a unit."""
    for unit in _SPOKEN:
        if dimension(unit) == dimension_:
            return unit
    powers = zip(_NAMES, dimension_, strict=True)
    return " ".join(f"{name}{power if power != 1 else ''}" for name, power in powers if power)


def dimension_of(expression: Expr, known: Mapping[Expr, Dimension | None]) -> Dimension | None:
    """The dimension of an expression; None where it is not known, as that of zero.

    Raises
    ------
    MixedUnitsError
        quantities of different dimensions are added, or one is no number and must be.
    """
    if expression.is_Symbol:
        return known.get(expression)
    if expression.is_Number or expression.is_NumberSymbol:
        return None if expression == 0 else NUMBER
    parts = {part: dimension_of(part, known) for part in expression.args}
    if expression.is_Add:
        return _of_sum(parts)
    if expression.is_Mul:
        return _product(list(parts.values()))
    if expression.is_Pow:
        base, exponent = expression.args
        return _power(base, exponent, parts)
    if isinstance(expression, sympy.Abs | sympy.Max | sympy.Min):
        return _of_sum(parts)
    if isinstance(expression, _OF_NUMBERS):
        _refuse_quantity(expression, parts)
        return NUMBER
    return NUMBER if isinstance(expression, sympy.sign) else None


def _of_sum(parts: Mapping[Expr, Dimension | None]) -> Dimension | None:
    first: Expr | None = None
    for term, found in parts.items():
        if found is None:
            continue
        if first is not None and found != parts[first]:
            one, other = (f"{t} in {spoken(parts[t] or NUMBER)}" for t in (first, term))
            raise MixedUnitsError(f"{one} and {other} are added", first, term)
        first = term if first is None else first
    return None if first is None else parts[first]


def _product(factors: list[Dimension | None]) -> Dimension | None:
    if any(factor is None for factor in factors):
        return None
    columns = zip(*(factor for factor in factors if factor is not None), strict=True)
    mass, length, time = (sum(column, Fraction(0)) for column in columns)
    return mass, length, time


def _power(base: Expr, exponent: Expr, parts: Mapping[Expr, Dimension | None]) -> Dimension | None:
    found = parts[base]
    if found is None or found == NUMBER:
        return found
    if not exponent.is_Rational:
        raise MixedUnitsError(f"{base} in {spoken(found)} has the power {exponent}", base, exponent)
    times = Fraction(int(exponent.p), int(exponent.q))
    mass, length, time = (times * part for part in found)
    return mass, length, time


def _refuse_quantity(expression: Expr, parts: Mapping[Expr, Dimension | None]) -> None:
    for argument, found in parts.items():
        if found not in (None, NUMBER):
            said = f"{expression.func.__name__} is taken of {argument} in {spoken(found)}"
            raise MixedUnitsError(said, argument)
