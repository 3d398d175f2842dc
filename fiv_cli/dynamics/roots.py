"""The first root of a switching function over a step, from its own polynomial.

The polynomial lives on [0, 1] (one step). Bernstein coefficients bound it: all positive means no
root, one change of sign exactly one root, anything else is halved, left half first. A pair of
roots closer than `TWIN_WIDTH` is told from a near miss at the minimum between them, so neither a
double root nor a root at the very end of the step is lost.

The coefficients of the whole step are written by straight-line code (`codegen/emit.py`), which
takes a third of the time of loops.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from fiv_cli.codegen.memory import (
    FixedInt,
    Floats,
    Floats2,
    Frame,
    call_generated,
    inlined,
    native,
)

NO_ROOT = 2.0
ROUNDING = 8.0 * 2.220446049250313e-16
TWIN_WIDTH = 2.0**-22
MAX_DEPTH = 60
LAST_STEP = 4e-6  # a step of Halley's this short leaves its cube as error
LAST_DIGITS = 4.5e-16  # two units in the last place


class Search(Frame):
    """What a search works on.

    The pieces of the halving are rows of Bernstein coefficients; `lows` and `highs` are the ends
    of their intervals.
    """

    order: FixedInt  # highest power
    value_slope_bend: FixedInt  # address of the generated function of polynomials of this order
    bernstein: FixedInt  # address of the one that writes Bernstein coefficients
    polynomial: Floats
    pieces: Floats2
    lows: Floats
    highs: Floats
    at_guess: Floats  # value, slope, bend


@native
def evaluate(polynomial: Floats, degree: int, x: float) -> float:
    """Value of the polynomial by Horner's rule."""
    value = polynomial[degree]
    for k in range(degree - 1, -1, -1):
        value = value * x + polynomial[k]
    return value


@native
def slope(polynomial: Floats, degree: int, x: float) -> float:
    """Its derivative by Horner's rule."""
    value = 0.0
    for k in range(degree, 0, -1):
        value = value * x + k * polynomial[k]
    return value


@native
def bracketed_root(run: Search, low: float, high: float, x: float) -> float:
    """Root with p(low) > 0 >= p(high), by Halley's steps from x, kept inside the bracket.

    A step that is not half as long as the one before halves the bracket instead: far out, where
    the highest power rules, steps shrink by a few per cent each.
    """
    polynomial, found = run.polynomial, run.at_guess
    if not low < x < high:
        x = 0.5 * (low + high)
    moved = high - low
    for _ in range(100):
        call_generated(run.value_slope_bend, polynomial, x, polynomial, found)
        value = found[0]
        steep, bent = found[1] * found[1], value * found[2]
        if value > 0.0:
            low = x
        else:
            high = x
        # Near a turn, where Halley's steps are short without being near a root, there is none.
        new = x - value * found[1] / (steep - 0.5 * bent) if abs(bent) < steep else low
        if low < new < high and 2.0 * abs(new - x) <= moved:
            moved = abs(new - x)
            if moved <= LAST_STEP and abs(bent) <= LAST_STEP * steep:
                return new
        else:  # a halved bracket converges slowly: its last step says nothing of the error
            new = 0.5 * (low + high)
            moved = high - low
            if not low < new < high:
                return new
        x = new
    return x


@native
def chord(low: float, high: float, at_low: float, at_high: float) -> float:
    """Where the chord passes zero."""
    return low + (high - low) * at_low / (at_low - at_high)


@native
def polygon(run: Search, row: int) -> float:
    """Where the control polygon of a piece passes zero: close to where the piece does."""
    piece, j = run.pieces[row], 1
    while j < run.order and piece[j] > 0.0:
        j += 1
    place = chord(j - 1.0, float(j), piece[j - 1], piece[j]) / run.order
    return run.lows[row] + (run.highs[row] - run.lows[row]) * place


@native
def lowest_point(
    polynomial: Floats, degree: int, low: float, high: float, tolerance: float
) -> float:
    """Where p is least in a short bracket, if it reaches `tolerance` there; else NO_ROOT."""
    for _ in range(60):
        middle = 0.5 * (low + high)
        if slope(polynomial, degree, middle) < 0.0:
            low = middle
        else:
            high = middle
        if high - low <= LAST_DIGITS:
            break
    x = 0.5 * (low + high)
    return x if evaluate(polynomial, degree, x) <= tolerance else NO_ROOT


@native
def halve(run: Search, row: int) -> None:
    """Split a piece at its middle (de Casteljau): right half stays, left half goes on top."""
    piece, left = run.pieces[row], run.pieces[row + 1]
    for j in range(run.order + 1):
        left[j] = piece[0]
        for i in range(run.order - j):
            piece[i] = 0.5 * (piece[i] + piece[i + 1])
    middle = 0.5 * (run.lows[row] + run.highs[row])
    run.lows[row + 1], run.highs[row + 1] = run.lows[row], middle
    run.lows[row] = middle


@native
def sign_changes(piece: Floats, degree: int, tolerance: float) -> int:
    """Changes of sign of a piece that starts positive; what is within `tolerance` has no sign."""
    changes = 0
    negative = False
    for j in range(degree + 1):
        value = piece[j]
        if value < -tolerance and not negative:
            changes += 1
            negative = True
        elif value > tolerance and negative:
            changes += 1
            negative = False
    return changes


@native
def may_touch(piece: Floats, degree: int, tolerance: float) -> bool:
    """Whether a piece without a change of sign has a coefficient within `tolerance` of zero."""
    for j in range(1, degree + 1):
        if piece[j] <= tolerance:
            return True
    return False


@inlined
def first_root(run: Search, degree: int, total: float, end: float) -> float:
    """First x in [0, 1] where p passes from positive to zero or below; NO_ROOT if none.

    `total` is the sum of its coefficients' absolute values, `end` that of the coefficients; those
    beyond the degree are zero. It starts positive (its known zeros at the start are divided out
    by the caller); a start at or below zero is a root at 0.
    """
    polynomial = run.polynomial
    start = polynomial[0]
    if start <= 0.0:
        return 0.0
    tolerance = ROUNDING * total
    # p(x) >= start + p1 x - rest x^2, which is least at an end of [0, 1].
    first = polynomial[1]
    rest = 0.5 * (total - end) + min(first, 0.0)
    if start + first - rest > tolerance:
        return NO_ROOT
    if end >= 0.0:  # else there is a root, and where the polygon passes zero is close to it
        second = 2.0 * polynomial[2]
        steepness, curvature, power = abs(first) + abs(second), 0.0, 2.0
        for k in range(3, degree + 1):
            power += 1.0
            slope_term = power * abs(polynomial[k])
            steepness += slope_term
            curvature += (power - 1.0) * slope_term
        # Monotonic, or concave: least at an end, one root at most.
        if 2.0 * abs(first) > steepness or -second > curvature:
            return NO_ROOT if end > tolerance else 1.0
    call_generated(run.bernstein, polynomial, 0.0, polynomial, run.pieces[0])
    run.lows[0], run.highs[0] = 0.0, 1.0
    return first_of_pieces(run, degree, tolerance)


@native
def first_of_pieces(run: Search, degree: int, tolerance: float) -> float:
    """`first_root` by halving, where the Bernstein coefficients of the whole are at hand."""
    polynomial, top, row = run.polynomial, run.order, 0
    while row >= 0:
        low, high, piece = run.lows[row], run.highs[row], run.pieces[row]
        changes = sign_changes(piece, top, tolerance)
        if changes == 0:
            if piece[top] <= tolerance:
                return high
            if may_touch(piece, top, tolerance) and slope(polynomial, degree, low) < 0.0:
                touch = lowest_point(polynomial, degree, low, high, tolerance)
                if touch != NO_ROOT:
                    return touch
            row -= 1
        elif changes == 1:
            return bracketed_root(run, low, high, polygon(run, row))
        elif high - low < TWIN_WIDTH or row + 2 > MAX_DEPTH:
            touch = lowest_point(polynomial, degree, low, high, tolerance)
            if touch != NO_ROOT:
                depth = evaluate(polynomial, degree, touch)
                if depth < -tolerance:
                    return bracketed_root(run, low, touch, chord(low, touch, piece[0], depth))
                return touch
            row -= 1
        else:
            halve(run, row)
            row += 1
    return NO_ROOT


def scratch(order: int) -> dict[str, NDArray[np.float64]]:
    """The arrays that a search in polynomials up to this power works on, by name."""
    return {
        "polynomial": np.zeros(order + 1),
        "pieces": np.zeros((MAX_DEPTH, order + 1)),
        "lows": np.zeros(MAX_DEPTH),
        "highs": np.zeros(MAX_DEPTH),
        "at_guess": np.zeros(3),
    }
