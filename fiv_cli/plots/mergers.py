"""Where two modes merge, or part, between the points of a grid, and their eigenvalue there."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from fiv_cli.plots import points

if TYPE_CHECKING:
    import xarray as xr


def mergers(
    part: xr.Dataset, axis: xr.DataArray, mode: int
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Before which points of a line a mode merges with another, where, and its eigenvalue there.

    That is in rad/s. The mean of both modes is smooth there, and so is the square of their
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
        pair = values[point : point + 2, [mode, other]]
        share = (places[point, mode] - x[point]) / (x[point + 1] - x[point])
        mean, apart = pair.mean(axis=1), pair[:, 0] - pair[:, 1]
        squares = (apart**2).imag
        half = 0.5 * np.sqrt(1j * (squares[0] + share * (squares[1] - squares[0])))
        half *= -1.0 if (half * apart[0].conjugate()).real < 0.0 else 1.0
        found.append((point + 1, places[point, mode], mean[0] + share * (mean[1] - mean[0]) + half))
    if not found:
        return none
    after, where, met = map(np.array, zip(*found, strict=True))
    return after, where, met


def growth_at_mergers(
    part: xr.Dataset, axis: xr.DataArray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Before which points of a line modes merge, where, and the largest growth rate there, rad/s.

    It has a corner there: of the modes that do not merge it is read between their points.
    """
    real = part["eigenvalue_real"].transpose(str(axis.dims[0]), "mode").values
    every = [mergers(part, axis, mode) for mode in range(real.shape[1])]
    x = points.positions(axis)
    met = sorted({pair for after, at, _ in every for pair in zip(after, at, strict=True)})
    largest = []
    for point, place in met:
        share = (place - x[point - 1]) / (x[point] - x[point - 1])
        straight = real[point - 1] + share * (real[point] - real[point - 1])
        merged = [values.real[at == place].max(initial=-np.inf) for _, at, values in every]
        largest.append(np.where(np.isfinite(merged), merged, straight).max())
    after, places = np.array(met).reshape(-1, 2).T
    return after.astype(int), places, np.array(largest)
