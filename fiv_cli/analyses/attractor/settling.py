"""Has a return map settled? Pure functions of the section points met so far.

A map has settled on period m when the last points repeat those m earlier to `SETTLED`, and the
rate at which the repetition improves leaves less than that to come. The second condition is what
tells a slow transient (a multiplier of -0.99) from a settled motion.
"""

from __future__ import annotations

import sys
from collections.abc import Callable
from functools import partial
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from fiv_cli.codegen.compiled import Compiled
from fiv_cli.codegen.memory import Floats, Floats2, address_of, floats_at, native

SETTLED = 1e-8  # relative to the largest value of each state at the section
LEAST = float(np.finfo(float).tiny)  # a scale that is none
SMALLEST = 1e-7  # a state below this share of the largest one is judged by that: it is rounding
LONGEST = 512  # longest period looked for, in section points: a turn of a disc may hold hundreds
NEARLY = 1e-4  # a shorter period whose repetition is this close, and improving, is waited for
FLOOR = 1e-10  # a repetition this close is the noise of integration: its rate says nothing
LAST, MOST_RETURNS = 8, 100  # points whose nearest return is looked for, and after how many
DISTINCT = 1e-6  # points of one period lie further apart than this: else the period is shorter


@native
def grow_scales(points: Floats2, scales: Floats, first: int, count: int) -> None:
    """Take further points into the largest value of each state."""
    for row in range(first, count):
        for i in range(points.shape[1]):
            scales[i] = max(scales[i], abs(points[row, i]))


@native
def floor_scales(scales: Floats) -> None:
    """Judge a state that is rounding by a share of the largest of all."""
    largest = 0.0
    for i in range(len(scales)):
        largest = max(largest, scales[i])
    for i in range(len(scales)):
        scales[i] = max(scales[i], SMALLEST * largest)


@native
def _distance(points: Floats2, scales: Floats, row: int, m: int) -> float:
    """Largest scaled difference between a point and the one m earlier."""
    worst = 0.0
    for i in range(points.shape[1]):
        worst = max(worst, abs(points[row, i] - points[row - m, i]) / scales[i])
    return worst


@native
def _is_apart(points: Floats2, scales: Floats, row: int, m: int, tolerance: float) -> bool:
    """Whether a point is further than `tolerance` from the one m earlier."""
    for i in range(points.shape[1]):
        if abs(points[row, i] - points[row - m, i]) / scales[i] > tolerance:
            return True
    return False


@native
def _repetition(points: Floats2, scales: Floats, count: int, m: int) -> float:
    """Largest difference of the last m points, of which there is one m earlier, from that."""
    worst = 0.0
    for back in range(min(m, count - m)):
        worst = max(worst, _distance(points, scales, count - 1 - back, m))
    return worst


@native
def _shrinking_divisor(points: Floats2, scales: Floats, count: int, m: int) -> bool:
    """Whether a shorter period is on its way: its repetition is small and still improves.

    A negative multiplier makes every second period agree sooner than every one.
    """
    for d in range(1, m // 2 + 1):
        if m % d == 0:
            now = _repetition(points, scales, count, d)
            before = _repetition(points, scales, count - m, d)
            if now <= NEARLY and now < before:
                return True
    return False


@native
def _least_period(points: Floats2, scales: Floats, count: int, m: int) -> int:
    """The least divisor of the period m that tells all its points apart.

    On a spiral whose turn is near 2 pi p/m, the points m apart agree sooner than neighbours do.
    """
    for d in range(1, m):
        if m % d == 0:
            worst = 0.0
            for back in range(m):
                worst = max(worst, _distance(points, scales, count - 1 - back, d))
            if worst <= DISTINCT:
                return d
    return m


@native
def period_among(
    points: Floats2, scales: Floats, count: int, tolerance: float, remaining: float
) -> int:
    """Period of the first `count` points, 0: they have not settled; see `settled_period`."""
    for m in range(1, min(LONGEST, (count - 1) // 2) + 1):
        if _is_apart(points, scales, count - 1, m, tolerance):
            continue
        now = _repetition(points, scales, count, m)
        if now > tolerance:
            continue
        before = _repetition(points, scales, count - m, m)
        rate = now / before if before > 0.0 else 0.0
        if now <= FLOOR or (rate < 1.0 and now * rate / (1.0 - rate) <= remaining):
            shorter = count >= 3 * m + 1 and _shrinking_divisor(points, scales, count, m)
            return 0 if shorter else _least_period(points, scales, count, m)
    return 0


@native
def _lasting_period(points: Floats2, scales: Floats, tolerance: float) -> int:
    count = points.shape[0]
    half = count // 2
    for m in range(1, min(LONGEST, half // 4) + 1):
        whole = half // m * m  # over all of it, too, nothing has moved
        if _is_apart(points, scales, count - 1, whole, tolerance):
            continue
        lasts = True
        for row in range(count - half, count):
            if _is_apart(points, scales, row, m, tolerance):
                lasts = False
                break
        if lasts:
            return m
    return 0


@native
def _scales_of(address: int, count: int, width: int) -> Floats:
    """Scales of `count` points at an address, put into the room behind them."""
    scales, points = floats_at(address, count + 1, width)[count], floats_at(address, count, width)
    for i in range(width):
        scales[i] = LEAST
    grow_scales(points, scales, 0, count)
    floor_scales(scales)
    return scales


def settled_at(address: int, count: int, width: int, tolerance: float, remaining: float) -> int:
    """`settled_period` of `count` points at an address, with room for the scales behind them."""
    scales = _scales_of(address, count, width)
    return period_among(floats_at(address, count, width), scales, count, tolerance, remaining)


def lasting_at(address: int, count: int, width: int, tolerance: float) -> int:
    """`lasting_period`, likewise."""
    scales = _scales_of(address, count, width)
    return _lasting_period(floats_at(address, count, width), scales, tolerance)


def _declared(entry: Callable[..., int]) -> Callable[..., int]:
    from fiv_cli.codegen.kernels import register

    register(sys.modules[__name__])
    return entry


_FILES = (Path(__file__),)
_SETTLED = Compiled(
    "settled",
    "int64(int64, int64, int64, float64, float64)",
    _FILES,
    partial(_declared, settled_at),
)
_LASTING = Compiled(
    "lasting", "int64(int64, int64, int64, float64)", _FILES, partial(_declared, lasting_at)
)


def load_settling(announce: Callable[[str], None]) -> None:
    """Have `settled_period` at hand; `announce` is called with a sentence if it is compiled."""
    _SETTLED.load(announce, "compiling the search for periods (once per user, a few seconds)")


def nearest_return(points: NDArray[np.float64]) -> int:
    """After how many section points the last ones come nearest to where they were.

    Parameters
    ----------
    points : as of `settled_period`, twice `LAST` at least
    """
    extent = np.ptp(points, axis=0)
    scales = np.maximum(extent, SMALLEST * extent.max()) + np.finfo(float).tiny
    after = range(1, max(2, min(len(points) // 4, MOST_RETURNS)))
    gaps = [np.abs((points[-LAST:] - points[-LAST - n : -n]) / scales).max() for n in after]
    return 1 + int(np.argmin(gaps))


def lasting_period(points: NDArray[np.float64], tolerance: float = SETTLED) -> int:
    """Section points per period of a map that has repeated itself all through its second half.

    On a stiff system the noise of integration may lie above `FLOOR`, and a rate that is made of
    noise never tells that a map has settled. That it stays where it is does.

    Parameters
    ----------
    points : as of `settled_period`
    """
    if len(points) < 8:
        return 0
    return _asked(_LASTING, points, tolerance)


def _asked(compiled: Compiled, points: NDArray[np.float64], *tolerances: float) -> int:
    count, width = points.shape
    room = np.empty((count + 1, width))
    room[:count] = points
    found: int = compiled.function(address_of(room), count, width, *tolerances)
    return found


def settled_period(
    points: NDArray[np.float64], tolerance: float = SETTLED, remaining: float | None = None
) -> int:
    """Section points per period of a settled map; 0 when it has not settled.

    Parameters
    ----------
    points : section points, oldest first; shape (count, n). Two columns of an excitation's phase
        (cosine, sine) belong to them on a forced system
    tolerance : of the repetition, over the largest value of each state
    remaining : of what its improvement leaves to come; as `tolerance` when left out
    """
    if len(points) < 3:
        return 0
    left = tolerance if remaining is None else remaining
    return _asked(_SETTLED, points, tolerance, left)
