"""Reductions: one number for all that a variable holds along an axis of its own, in claims.

The greatest displacement between two instants, the frequency at which a spectrum is largest, how
often contact is lost in a stretch of time.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
import xarray as xr

from fiv_cli.reading import select
from fiv_cli.reading.datasets import numbers
from fiv_cli.reading.shares import hits


def reduced(dataset: xr.Dataset, variable: str, reduce: Mapping[str, Any]) -> xr.Dataset:
    """The dataset with one number in place of what `variable` holds along an axis.

    Parameters
    ----------
    dataset : any dataset with a ``status``
    variable : of one value per place along the axis
    reduce : ``over``, an axis that is none of the grid; ``take``, what is taken along it: least,
        greatest, range, mean, peak (the place of the greatest), or share or entries of the
        condition or class ``of``: where it holds, and how often it comes to

    Returns
    -------
    xr.Dataset : `variable` is NaN where it has no value along the whole axis

    Raises
    ------
    SelectionError : no such variable, axis or class
    """
    if variable not in dataset:
        raise select.SelectionError(f"{variable}: no variable of the dataset")
    axis = select.axis_of(dataset, reduce["over"])
    dim = str(axis.dims[0])
    if dim not in dataset[variable].dims or dim in dataset["status"].dims:
        raise select.SelectionError(f"{variable}: not one value per {reduce['over']} at a point")
    if "of" in reduce:
        counted = _COUNTED[reduce["take"]](hits(dataset[variable], reduce["of"]), dim)
        return dataset.assign({variable: counted.assign_attrs(units="1")})
    array = numbers(dataset[variable])
    if reduce["take"] == "peak":
        found, unit = _peak(array, axis, dim), axis.attrs.get("units", "1")
    else:
        found, unit = _TAKEN[reduce["take"]](array, dim), array.attrs.get("units", "1")
    return dataset.assign({variable: found.assign_attrs(units=unit)})


def _entries(holds: xr.DataArray, dim: str) -> xr.DataArray:
    """How often what is 0 or 1 along `dim` rises: not where it is 1 from the first."""
    return (holds.diff(dim) > 0.0).sum(dim).astype(float)


def _peak(array: xr.DataArray, axis: xr.DataArray, dim: str) -> xr.DataArray:
    """The place along `axis` of the greatest value; NaN where there is none."""
    place = array.fillna(-np.inf).argmax(dim)
    at = array.isel({dim: 0}, drop=True).copy(data=axis.values[place.values].astype(float))
    return at.where(array.notnull().any(dim))


_Reduction = Callable[[xr.DataArray, str], xr.DataArray]
_COUNTED: dict[str, _Reduction] = {
    "entries": _entries,
    "share": lambda holds, dim: holds.mean(dim),
}
_TAKEN: dict[str, _Reduction] = {
    "least": lambda array, dim: array.min(dim),
    "greatest": lambda array, dim: array.max(dim),
    "mean": lambda array, dim: array.mean(dim),
    "range": lambda array, dim: array.max(dim) - array.min(dim),
}
