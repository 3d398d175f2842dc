"""Brent's method for functions whose values are asked of somebody else."""

from __future__ import annotations

import math
import sys
from collections.abc import Callable, Generator
from typing import Any

MOST_STEPS = 100
ULP = sys.float_info.epsilon

Asking = Generator[Any, Any, float]


def zero(function: Callable[[float], Asking], low: float, high: float, resolution: float) -> Asking:
    """A zero of a function of opposite signs at both ends, by Brent's method.

    R. P. Brent, Algorithms for Minimization without Derivatives (1973), chapter 4, in the order of
    operations of `scipy.optimize.brentq`.
    """
    before, best = low, high
    f_before = yield from function(before)
    f_best = yield from function(best)
    other, f_other, last, step = before, f_before, 0.0, 0.0
    for _ in range(MOST_STEPS):
        if f_before != 0.0 and f_best != 0.0 and (f_before < 0.0) != (f_best < 0.0):
            other, f_other = before, f_before
            last = step = best - before
        if abs(f_other) < abs(f_best):
            before, best, other = best, other, best
            f_before, f_best, f_other = f_best, f_other, f_best
        least = (resolution + 4.0 * ULP * abs(best)) / 2.0
        half = (other - best) / 2.0
        if f_best == 0.0 or abs(half) < least:
            break
        tried = math.inf
        if abs(last) > least and abs(f_best) < abs(f_before):
            tried = _interpolated(before, best, other, f_before, f_best, f_other)
        is_short = 2.0 * abs(tried) < min(abs(last), 3.0 * abs(half) - least)
        last, step = (step, tried) if is_short else (half, half)
        before, f_before = best, f_best
        best += step if abs(step) > least else math.copysign(least, half)
        f_best = yield from function(best)
    return best


def _interpolated(
    before: float, best: float, other: float, f_before: float, f_best: float, f_other: float
) -> float:
    """Step from the best value to where a straight line, or a parabola on its side, is zero."""
    if before == other:
        return -f_best * (best - before) / (f_best - f_before)
    slope, other_slope = (f_before - f_best) / (before - best), (f_other - f_best) / (other - best)
    bent = f_other * other_slope - f_before * slope
    scale = other_slope * slope * (f_other - f_before)
    return -f_best * bent / scale if scale != 0.0 else math.inf
