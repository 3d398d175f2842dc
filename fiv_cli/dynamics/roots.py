"""The first root of a switching function over a step, from its own polynomial.

The polynomial lives on [0, 1] (one step). Bernstein coefficients bound it: all positive means no
root, one change of sign exactly one root, anything else is halved, left half first. A pair of
roots closer than `TWIN_WIDTH` is told from a near miss at the minimum between them, so neither a
double root nor a root at the very end of the step is lost.
"""

from __future__ import annotations

from math import comb

import numpy as np
from numba import njit

from fiv_cli.dynamics.compiled import CACHE

NO_ROOT = 2.0
HIGHEST_ORDER = 24
ROUNDING = 8.0 * 2.220446049250313e-16
TWIN_WIDTH = 2.0**-22
MAX_DEPTH = 60
# Row of the scratch array that holds the polynomial; rows above it are halved pieces, each with
# its interval in the last two columns.
POLYNOMIAL = MAX_DEPTH

INVERSE_BINOMIALS = np.array(
    [[1.0 / comb(n, k) if k <= n else 0.0 for k in range(HIGHEST_ORDER + 1)]
     for n in range(HIGHEST_ORDER + 1)]
)  # fmt: skip


@njit("float64(float64[::1], int64, float64)", **CACHE)
def evaluate(p, degree, x):  # type: ignore[no-untyped-def]
    """Horner's rule."""
    value = p[degree]
    for k in range(degree - 1, -1, -1):
        value = value * x + p[k]
    return value


@njit("float64(float64[::1], int64, float64)", **CACHE)
def slope(p, degree, x):  # type: ignore[no-untyped-def]
    """Derivative by Horner's rule."""
    value = 0.0
    for k in range(degree, 0, -1):
        value = value * x + k * p[k]
    return value


@njit("float64(float64[::1], int64, float64, float64)", **CACHE)
def bracketed_root(p, degree, low, high):  # type: ignore[no-untyped-def]
    """Root with p(low) > 0 >= p(high), by Newton steps kept inside the bracket."""
    x = 0.5 * (low + high)
    for _ in range(100):
        value = evaluate(p, degree, x)
        if value > 0.0:
            low = x
        else:
            high = x
        derivative = slope(p, degree, x)
        new = x - value / derivative if derivative != 0.0 else 0.5 * (low + high)
        if not low < new < high:
            new = 0.5 * (low + high)
        if abs(new - x) <= 1e-16 or not low < new < high:
            return new
        x = new
    return x


@njit("float64(float64[::1], int64, float64, float64, float64)", **CACHE)
def lowest_point(p, degree, low, high, tolerance):  # type: ignore[no-untyped-def]
    """Where p is least in a short bracket, if it reaches `tolerance` there; else NO_ROOT."""
    for _ in range(60):
        middle = 0.5 * (low + high)
        if slope(p, degree, middle) < 0.0:
            low = middle
        else:
            high = middle
        if high - low <= 1e-16:
            break
    x = 0.5 * (low + high)
    return x if evaluate(p, degree, x) <= tolerance else NO_ROOT


@njit("void(float64[::1], int64, float64[:, ::1])", **CACHE)
def to_bernstein(p, degree, stack):  # type: ignore[no-untyped-def]
    """Bernstein coefficients of p on [0, 1] into row 0 of `stack`."""
    b = stack[0]
    for j in range(degree + 1):
        b[j] = p[j] * INVERSE_BINOMIALS[degree, j]
    for level in range(1, degree + 1):  # undo the differences
        for j in range(degree, level - 1, -1):
            b[j] = b[j] + b[j - 1]


@njit("float64(int64, float64[:, ::1])", **CACHE)
def first_root(degree, stack):  # type: ignore[no-untyped-def]
    """First x in [0, 1] where p passes from positive to zero or below; NO_ROOT if none.

    `p` is row `POLYNOMIAL` of `stack`, the array that `scratch` makes. It starts positive (its
    known zeros at the start are divided out by the caller); a start at or below zero is a root
    at 0.
    """
    p = stack[POLYNOMIAL]
    if p[0] <= 0.0:
        return 0.0
    total = 0.0
    weighted = 0.0
    falling = 0.0
    for k in range(1, degree + 1):
        size = abs(p[k])
        total += size
        weighted += k * size
        if p[k] < 0.0:
            falling += size
    if p[0] > falling * (1.0 + ROUNDING):
        return NO_ROOT
    if 2.0 * abs(p[1]) > weighted:  # monotonic over the whole step
        end = evaluate(p, degree, 1.0)
        if end > ROUNDING * (total + p[0]):
            return NO_ROOT
        if end < 0.0:
            return bracketed_root(p, degree, 0.0, 1.0)
    tolerance = ROUNDING * (total + p[0])
    low_at, high_at = stack.shape[1] - 2, stack.shape[1] - 1
    to_bernstein(p, degree, stack)
    stack[0, low_at] = 0.0
    stack[0, high_at] = 1.0
    top = 0
    while top >= 0:
        b = stack[top]
        low = stack[top, low_at]
        high = stack[top, high_at]
        changes = 0
        negative = False
        for j in range(degree + 1):
            if b[j] < -tolerance and not negative:
                changes += 1
                negative = True
            elif b[j] > tolerance and negative:
                changes += 1
                negative = False
        if changes == 0:
            if b[degree] <= tolerance:
                return high
            top -= 1
        elif changes == 1:
            return bracketed_root(p, degree, low, high)
        elif high - low < TWIN_WIDTH or top >= MAX_DEPTH - 2:
            touch = lowest_point(p, degree, low, high, tolerance)
            if touch != NO_ROOT:
                if evaluate(p, degree, touch) < -tolerance:
                    return bracketed_root(p, degree, low, touch)
                return touch
            top -= 1
        else:
            right = stack[top]
            left = stack[top + 1]
            for j in range(degree + 1):  # de Casteljau at one half
                left[j] = right[0]
                for i in range(degree - j):
                    right[i] = 0.5 * (right[i] + right[i + 1])
            middle = 0.5 * (low + high)
            stack[top, low_at] = middle
            stack[top + 1, low_at] = low
            stack[top + 1, high_at] = middle
            top += 1
    return NO_ROOT


def scratch(order: int) -> np.ndarray:
    """Scratch array of `first_root` for polynomials up to `order`."""
    return np.zeros((MAX_DEPTH + 1, order + 3))
