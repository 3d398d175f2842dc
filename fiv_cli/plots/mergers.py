"""Where two modes merge, or part, between the points of a grid, and their eigenvalue there."""

from __future__ import annotations

from itertools import chain
from typing import TYPE_CHECKING

import numpy as np

from fiv_cli.plots import points

if TYPE_CHECKING:
    import xarray as xr

GROWTH = "growth_rate"
NEAR = 4  # places on each side of a merger, between it and the points beside it ...
FRACTIONS = np.linspace(0.0, 1.0, NEAR + 2)[1:-1] ** 2  # ... as shares of the way to these


def mergers(
    part: xr.Dataset, axis: xr.DataArray, mode: int
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Before which points of a line a mode merges with another, where, and its eigenvalue there.

    That is in rad/s, and on both sides at places that are closer the nearer they lie to that one,
    where it has a root. The mean of both modes is smooth there, and so is the square of their
    difference, whose real part is zero.
    """
    none = np.zeros(0, int), np.zeros(0), np.zeros(0, complex)
    if part.get("coupling_point", axis).attrs.get("along") != axis.name:
        return none
    at = [str(axis.dims[0]), "mode"]
    places = part["coupling_point"].transpose(*at).values
    real, imaginary = (part[f"eigenvalue_{one}"].transpose(*at).values for one in ("real", "imag"))
    values, x, found = real + 1j * imaginary, points.positions(axis), []
    for point in np.flatnonzero(np.isfinite(places[:, mode])).tolist():
        same_side = values[point].imag * values[point, mode].imag > 0.0
        alike = np.flatnonzero((places[point] == places[point, mode]) & same_side)
        other = next((n for n in alike.tolist() if n != mode), mode)
        step = x[point + 1] - x[point]
        shares = _close_to((places[point, mode] - x[point]) / step)
        met = _between(values[point : point + 2, [mode, other]], shares)
        where = np.where(shares == shares[NEAR], places[point, mode], x[point] + shares * step)
        found.append((np.full(shares.size, point + 1), where, met))
    if not found:
        return none
    after, where, met = map(np.concatenate, zip(*found, strict=True))
    return after, where, met


def _close_to(share: float) -> np.ndarray:
    """Shares of a step around one of them, which is that of the number NEAR."""
    below = share * (1.0 - FRACTIONS[::-1])
    return np.concatenate([below, [share], share + (1.0 - share) * FRACTIONS])


def _between(pair: np.ndarray, shares: np.ndarray) -> np.ndarray:
    """The first of a pair of eigenvalues, shape (2 points, pair), at shares of the step, which
    merge at the middle one of these."""
    mean, apart = pair.mean(axis=1), pair[:, 0] - pair[:, 1]
    squares = apart[0] ** 2 + shares * (apart[1] ** 2 - apart[0] ** 2)
    squares[NEAR] = 1j * squares[NEAR].imag
    half = 0.5 * np.sqrt(squares)
    towards = np.where(np.arange(shares.size) <= NEAR, apart[0], apart[1])
    half = np.where((half * towards.conjugate()).real < 0.0, -half, half)
    return np.asarray(mean[0] + shares * (mean[1] - mean[0]) + half)


def growth_at_mergers(
    part: xr.Dataset, axis: xr.DataArray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Before which points of a line modes merge, where, and the largest growth rate there, rad/s.

    It has a root there. Modes that do not merge, some of which a model may not have under all of
    its options, are read between their points.
    """
    real = part["eigenvalue_real"].transpose(str(axis.dims[0]), "mode").values
    every = [mergers(part, axis, mode) for mode in range(real.shape[1])]
    x, found = points.positions(axis), []
    for point in sorted({*chain(*(after.tolist() for after, _, _ in every))}):
        own = [(at[after == point], values.real[after == point]) for after, at, values in every]
        begin, step = x[point - 1], x[point] - x[point - 1]
        places = np.concatenate([at for at, _ in own])
        shares, first = np.unique((places - begin) / step, return_index=True)
        lines = [
            np.interp(shares, [0.0, *(at - begin) / step, 1.0], [before, *values, behind])
            for (at, values), before, behind in zip(own, *real[point - 1 : point + 1], strict=True)
        ]
        found.append((np.full(shares.size, point), places[first], np.fmax.reduce(lines)))
    none = np.zeros(0, int), np.zeros(0), np.zeros(0)
    after, at, largest = map(np.concatenate, zip(none, *found, strict=True))
    return after, at, largest
