"""The first root of a switching function over a step, from its own polynomial.

The polynomial lives on [0, 1] (one step). Bernstein coefficients bound it: all positive means no
root, one change of sign exactly one root, anything else is halved, left half first. A pair of
roots closer than `TWIN_WIDTH` is told from a near miss at the minimum between them, so neither a
double root nor a root at the very end of the step is lost.

The functions work on one flat array, made by `scratch`: pieces of the halving, each a row of
Bernstein coefficients with its interval behind them, and last the polynomial itself. (Views of
an array would cost more than the arithmetic: each is counted atomically.)
"""

from __future__ import annotations

from math import comb

import numpy as np
from numpy.typing import NDArray

from fiv_cli.codegen.native import Floats, inlined, native

NO_ROOT = 2.0
HIGHEST_ORDER = 24
ROUNDING = 8.0 * 2.220446049250313e-16
TWIN_WIDTH = 2.0**-22
MAX_DEPTH = 60
LAST_STEP = 1e-8  # a Newton step this short leaves its square as error
LAST_DIGITS = 4.5e-16  # two units in the last place
ROW = HIGHEST_ORDER + 3  # coefficients of a piece, then the two ends of its interval
LOW, HIGH = HIGHEST_ORDER + 1, HIGHEST_ORDER + 2
POLYNOMIAL = MAX_DEPTH * ROW  # where the polynomial stands

# Share of the coefficient of x^i in Bernstein coefficient j of degree n: at (n SQUARE + j ROW + i).
SQUARE = ROW * ROW
TO_BERNSTEIN = np.array(
    [
        comb(j, i) / comb(n, i) if i <= j <= n else 0.0
        for n in range(HIGHEST_ORDER + 1)
        for j in range(ROW)
        for i in range(ROW)
    ]
)


@native
def evaluate(work: Floats, degree: int, x: float) -> float:
    """Value of the polynomial by Horner's rule."""
    value = work[POLYNOMIAL + degree]
    for k in range(degree - 1, -1, -1):
        value = value * x + work[POLYNOMIAL + k]
    return value


@native
def slope(work: Floats, degree: int, x: float) -> float:
    """Its derivative by Horner's rule."""
    value = 0.0
    for k in range(degree, 0, -1):
        value = value * x + k * work[POLYNOMIAL + k]
    return value


@native
def bracketed_root(
    work: Floats, degree: int, low: float, high: float, at_low: float, at_high: float
) -> float:
    """Root with p(low) > 0 >= p(high), by Newton steps kept inside the bracket.

    A step that is not half as long as the one before halves the bracket instead: far out, where
    the highest power rules, Newton steps shrink by a few per cent each. Even and odd powers are
    summed apart: two short chains of operations instead of a long one.
    """
    x = low + (high - low) * at_low / (at_low - at_high)  # where the chord passes zero
    if not low < x < high:
        x = 0.5 * (low + high)
    moved = high - low
    top_even = degree - degree % 2
    top_odd = degree - 1 + degree % 2
    for _ in range(100):
        square = x * x
        even, even_slope = work[POLYNOMIAL + top_even], 0.0
        for k in range(top_even - 2, -1, -2):
            even_slope = even_slope * square + even
            even = even * square + work[POLYNOMIAL + k]
        odd, odd_slope = work[POLYNOMIAL + top_odd], 0.0
        for k in range(top_odd - 2, 0, -2):
            odd_slope = odd_slope * square + odd
            odd = odd * square + work[POLYNOMIAL + k]
        value = even + x * odd
        derivative = odd + 2.0 * (x * even_slope + square * odd_slope)
        if value > 0.0:
            low = x
        else:
            high = x
        new = x - value / derivative if derivative != 0.0 else low
        if low < new < high and 2.0 * abs(new - x) <= moved:
            moved = abs(new - x)
            if moved <= LAST_STEP:
                return new
        else:  # a halved bracket converges slowly: its last step says nothing of the error
            new = 0.5 * (low + high)
            moved = high - low
            if not low < new < high:
                return new
        x = new
    return x


@native
def lowest_point(work: Floats, degree: int, low: float, high: float, tolerance: float) -> float:
    """Where p is least in a short bracket, if it reaches `tolerance` there; else NO_ROOT."""
    for _ in range(60):
        middle = 0.5 * (low + high)
        if slope(work, degree, middle) < 0.0:
            low = middle
        else:
            high = middle
        if high - low <= LAST_DIGITS:
            break
    x = 0.5 * (low + high)
    return x if evaluate(work, degree, x) <= tolerance else NO_ROOT


@native
def to_bernstein(work: Floats, degree: int) -> None:
    """Bernstein coefficients of the polynomial on [0, 1], into the first row."""
    for j in range(degree + 1):
        shares = degree * SQUARE + j * ROW
        value = work[POLYNOMIAL]
        for i in range(1, j + 1):
            value += work[POLYNOMIAL + i] * TO_BERNSTEIN[shares + i]
        work[j] = value


@native
def halve(work: Floats, degree: int, row: int) -> None:
    """Split a piece at its middle (de Casteljau): right half stays, left half goes on top."""
    left = row + ROW
    for j in range(degree + 1):
        work[left + j] = work[row]
        for i in range(degree - j):
            work[row + i] = 0.5 * (work[row + i] + work[row + i + 1])
    middle = 0.5 * (work[row + LOW] + work[row + HIGH])
    work[left + LOW] = work[row + LOW]
    work[left + HIGH] = middle
    work[row + LOW] = middle


@native
def sign_changes(work: Floats, degree: int, row: int, tolerance: float) -> int:
    """Changes of sign of a piece that starts positive; what is within `tolerance` has no sign."""
    changes = 0
    negative = False
    for j in range(degree + 1):
        value = work[row + j]
        if value < -tolerance and not negative:
            changes += 1
            negative = True
        elif value > tolerance and negative:
            changes += 1
            negative = False
    return changes


@native
def may_touch(work: Floats, degree: int, row: int, tolerance: float) -> bool:
    """Whether a piece without a change of sign has a coefficient within `tolerance` of zero."""
    for j in range(1, degree + 1):
        if work[row + j] <= tolerance:
            return True
    return False


@inlined
def first_root(degree: int, work: Floats, total: float, end: float) -> float:
    """First x in [0, 1] where p passes from positive to zero or below; NO_ROOT if none.

    p stands at `POLYNOMIAL`; `total` is the sum of its coefficients' absolute values, `end` that
    of the coefficients. It starts positive (its known zeros at the start are divided out by the
    caller); a start at or below zero is a root at 0.
    """
    start = work[POLYNOMIAL]
    if start <= 0.0:
        return 0.0
    tolerance = ROUNDING * total
    # p(x) >= start + p1 x - rest x^2, which is least at an end of [0, 1].
    first = work[POLYNOMIAL + 1]
    rest = 0.5 * (total - end) + min(first, 0.0)
    if start + first - rest > tolerance:
        return NO_ROOT
    second = 2.0 * work[POLYNOMIAL + 2]
    steepness, curvature, power = abs(first) + abs(second), 0.0, 2.0
    for k in range(3, degree + 1):
        power += 1.0
        slope_term = power * abs(work[POLYNOMIAL + k])
        steepness += slope_term
        curvature += (power - 1.0) * slope_term
    # Monotonic, or concave: least at an end, one root at most.
    if 2.0 * abs(first) > steepness or -second > curvature:
        if end > tolerance:
            return NO_ROOT
        return bracketed_root(work, degree, 0.0, 1.0, start, end) if end < 0.0 else 1.0
    to_bernstein(work, degree)
    work[LOW], work[HIGH] = 0.0, 1.0
    row = 0
    while row >= 0:
        low, high = work[row + LOW], work[row + HIGH]
        changes = sign_changes(work, degree, row, tolerance)
        if changes == 0:
            if work[row + degree] <= tolerance:
                return high
            if may_touch(work, degree, row, tolerance) and slope(work, degree, low) < 0.0:
                touch = lowest_point(work, degree, low, high, tolerance)
                if touch != NO_ROOT:
                    return touch
            row -= ROW
        elif changes == 1:
            return bracketed_root(work, degree, low, high, work[row], work[row + degree])
        elif high - low < TWIN_WIDTH or row + 2 * ROW >= POLYNOMIAL:
            touch = lowest_point(work, degree, low, high, tolerance)
            if touch != NO_ROOT:
                depth = evaluate(work, degree, touch)
                if depth < -tolerance:
                    return bracketed_root(work, degree, low, touch, work[row], depth)
                return touch
            row -= ROW
        else:
            halve(work, degree, row)
            row += ROW
    return NO_ROOT


def scratch() -> NDArray[np.float64]:
    """The array that the functions of this file work on."""
    return np.zeros(POLYNOMIAL + ROW)
