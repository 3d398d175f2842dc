"""Puts what turns with an angle into the form with the fewest products.

The acceleration of a gap on a disc is a sum over modal coordinates and their rates, each times the
sine or cosine of a multiple of the slider's angle, times speeds and forces that all modes share. As
it is derived, the shared factors stand within the sum and the squares of sines beside those of
cosines: three times the products of what is written here, ``cos^2 + sin^2 = 1`` used, the sums over
the modes innermost.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Collection, Mapping, Sequence

import sympy
from sympy import Expr

Term = tuple[tuple[Expr, ...], Expr]  # factors that terms share, and the rest of the product


def gathered(
    expression: Expr,
    entries: Collection[Expr],
    forces: Collection[Expr],
    varied: Mapping[Expr, Expr],
) -> Expr:
    """A polynomial in entries of the state, functions of them and forces, equal to `expression`.

    Parameters
    ----------
    varied : the symbols of parameters that vary in time -> what varies; each is one factor
    """
    turning = [f for f in expression.atoms(sympy.cos, sympy.sin) if f.has(*entries)]
    if not turning:
        return expression
    whole = {symbol: sympy.Dummy(f"{symbol}", real=True) for symbol in varied}
    inserted = {symbol: one - (varied[symbol] - symbol) for symbol, one in whole.items()}
    squares = {sympy.sin(f.args[0]) ** 2: 1 - sympy.cos(f.args[0]) ** 2 for f in turning}
    expanded = sympy.expand(sympy.expand(expression.xreplace(inserted)).subs(squares))
    factors = [*entries, *forces, *whole.values(), *turning]
    split = [term.as_independent(*factors, as_Add=False) for term in expanded.args]
    uses = Counter(f for _, product in split for f in product.free_symbols if f in entries)
    terms = [_parted(weight, product, uses) for weight, product in split]
    return _nested(terms).xreplace({one: varied[symbol] for symbol, one in whole.items()})


def _parted(weight: Expr, product: Expr, uses: Counter[Expr]) -> Term:
    """What turns stays with the entry that is in the fewest terms: its own modal coordinate."""
    powers = [factor.as_base_exp() for factor in sympy.Mul.make_args(product)]
    factors = [base for base, exponent in powers for _ in range(int(exponent))]
    turning = [factor for factor in factors if not factor.is_Symbol]
    shared = [factor for factor in factors if factor.is_Symbol]
    if turning and (entries := [factor for factor in shared if factor in uses]):
        own = min(entries, key=lambda entry: (uses[entry], str(entry)))
        shared.remove(own)
        turning.append(own)
    return tuple(shared), sympy.Mul(weight, *turning)


def _nested(terms: Sequence[Term]) -> Expr:
    """The sum of `terms`, the factor that most of them share outermost."""
    shared = Counter(factor for factors, _ in terms for factor in set(factors))
    if not shared:
        return sympy.Add(*(rest for _, rest in terms))
    most = min(shared, key=lambda factor: (-shared[factor], str(factor)))
    inside, outside = [], []
    for factors, rest in terms:
        if most in factors:
            at = factors.index(most)
            inside.append(((*factors[:at], *factors[at + 1 :]), rest))
        else:
            outside.append((factors, rest))
    return most * _nested(inside) + _nested(outside)
