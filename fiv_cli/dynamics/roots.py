"""The first root of a switching function over a step, from its own polynomial.

The polynomial lives on [0, 1] (one step). Bernstein coefficients bound it: all positive means no
root, one change of sign exactly one root, anything else is halved, left half first. A pair of
roots closer than `TWIN_WIDTH` is told from a near miss at the minimum between them, so neither a
double root nor a root at the very end of the step is lost.
"""

from __future__ import annotations

import numpy as np
from numba import njit

from fiv_cli.dynamics.compiled import CACHE

NO_ROOT = 2.0
ROUNDING = 8.0 * 2.220446049250313e-16
TWIN_WIDTH = 2.0**-22
MAX_DEPTH = 60


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
    weight = 1.0  # C(degree, j), built up term by term
    for j in range(degree + 1):
        b[j] = p[j] / weight
        weight = weight * (degree - j) / (j + 1)
    for level in range(1, degree + 1):  # undo the differences
        for j in range(degree, level - 1, -1):
            b[j] = b[j] + b[j - 1]


@njit("float64(float64[::1], int64, float64[:, ::1], float64[:, ::1])", **CACHE)
def first_root(p, degree, stack, intervals):  # type: ignore[no-untyped-def]
    """First x in [0, 1] where p passes from positive to zero or below; NO_ROOT if none.

    `p` starts positive (its known zeros at the start are divided out by the caller); a start at
    or below zero is a root at 0. `stack` is (MAX_DEPTH, degree + 1) and `intervals`
    (MAX_DEPTH, 2) of scratch.
    """
    if p[0] <= 0.0:
        return 0.0
    total = 0.0
    weighted = 0.0
    for k in range(1, degree + 1):
        total += abs(p[k])
        weighted += k * abs(p[k])
    if p[0] > total:
        return NO_ROOT
    if 2.0 * abs(p[1]) > weighted:  # monotonic over the whole step
        if evaluate(p, degree, 1.0) > ROUNDING * (total + p[0]):
            return NO_ROOT
    tolerance = ROUNDING * (total + p[0])
    to_bernstein(p, degree, stack)
    intervals[0, 0] = 0.0
    intervals[0, 1] = 1.0
    top = 0
    while top >= 0:
        b = stack[top]
        low = intervals[top, 0]
        high = intervals[top, 1]
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
            intervals[top, 0] = middle
            intervals[top + 1, 0] = low
            intervals[top + 1, 1] = middle
            top += 1
    return NO_ROOT


def scratch(order: int) -> tuple[np.ndarray, np.ndarray]:
    """Scratch arrays of `first_root` for polynomials up to `order`."""
    return np.empty((MAX_DEPTH, order + 1)), np.empty((MAX_DEPTH, 2))
