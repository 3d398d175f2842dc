"""Takes out coordinates whose part in the equations turns with an angle: the modes of a disc.

Under a given normal force a modal coordinate is linear, with the sine or cosine of a multiple of
the slider's angle. Inserted into the other equations the two parts of a doublet combine by
cos^2 + sin^2 = 1, and what is left is polynomial.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import sympy
from sympy import Expr


@dataclass(frozen=True)
class Eliminated:
    """What is left, and what was taken out.

    Attributes
    ----------
    expressions : of the coordinates and contacts that are left; each vanishes
    values : coordinate -> its value, in terms of what is left
    """

    expressions: dict[Expr, Expr]
    values: dict[Expr, Expr]


def without_modes(vanishing: Mapping[Expr, Expr], coordinates: Sequence[Expr]) -> Eliminated | None:
    """Take the modal coordinates out of the equations at rest.

    Parameters
    ----------
    vanishing : unknown -> the equation that belongs to it
    coordinates : those of the unknowns that are no normal forces

    Returns
    -------
    None where functions of unknowns remain
    """
    unknowns = list(vanishing)
    circles = _circles(vanishing.values(), unknowns)
    names = {function: symbol for circle in circles for function, symbol in circle.names.items()}
    algebraic = {key: expression.subs(names) for key, expression in vanishing.items()}
    turning = [symbol for circle in circles for symbol in circle.names.values()]
    angles = {symbol for circle in circles for symbol in circle.angle.free_symbols}
    values: dict[Expr, Expr] = {}
    modes = [k for k in coordinates if k not in angles and turning and algebraic[k].has(*turning)]
    for key in modes:
        value = _solved(algebraic[key], key, [*unknowns, *turning])
        if value is not None:
            values[key] = value
    if any(value.has(*values) for value in values.values()):
        return None
    left = {
        key: _folded(expression.subs(values), circles)
        for key, expression in algebraic.items()
        if key not in values
    }
    if turning and any(expression.has(*turning) for expression in left.values()):
        return None
    functions = {symbol: function for function, symbol in names.items()}
    return Eliminated(left, {key: value.subs(functions) for key, value in values.items()})


@dataclass(frozen=True)
class _Circle:
    """Sine and cosine of one angle, and the symbols that stand for them."""

    angle: Expr
    cosine: Expr
    sine: Expr

    @property
    def names(self) -> dict[Expr, Expr]:
        return {sympy.cos(self.angle): self.cosine, sympy.sin(self.angle): self.sine}


def _circles(expressions: Expr, unknowns: Sequence[Expr]) -> list[_Circle]:
    functions = {f for e in expressions for f in e.atoms(sympy.cos, sympy.sin)}
    angles = {f.args[0] for f in functions if f.free_symbols & set(unknowns)}
    return [
        _Circle(angle, sympy.Dummy("cosine", real=True), sympy.Dummy("sine", real=True))
        for angle in sorted(angles, key=str)
    ]


def _solved(expression: Expr, coordinate: Expr, unknowns: Sequence[Expr]) -> Expr | None:
    """The coordinate that makes an expression vanish, where it is linear with a constant slope."""
    slope = sympy.diff(expression, coordinate)
    if slope == 0 or slope.free_symbols & set(unknowns):
        return None
    return -expression.subs(coordinate, 0) / slope


def _folded(expression: Expr, circles: Sequence[_Circle]) -> Expr:
    """`expression` with sine^2 + cosine^2 = 1 used from the innermost sums outwards."""
    turning = [symbol for circle in circles for symbol in circle.names.values()]
    if not turning or not expression.has(*turning) or not expression.args:
        return expression
    inner = expression.func(*(_folded(argument, circles) for argument in expression.args))
    if not inner.has(*turning):
        return inner
    squares = {circle.sine**2: 1 - circle.cosine**2 for circle in circles}
    return sympy.expand(sympy.expand(inner).subs(squares))
