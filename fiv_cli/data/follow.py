"""Modes followed by continuity along the grid, instead of sorted anew at each point.

A pure step from dataset to dataset: it renumbers modes and computes nothing.
"""

from __future__ import annotations

import numpy as np
import xarray as xr
from numpy.typing import NDArray

Complex = NDArray[np.complex128]
Order = NDArray[np.intp]


def follow_modes(dataset: xr.Dataset) -> xr.Dataset:
    """Renumber modes so that each continues its neighbour's along the first numeric axis.

    Parameters
    ----------
    dataset : holds ``eigenvalue_real/imag(..., mode)`` and ``eigenvector_real/imag(..., mode,
        state)``; the first point with eigenvalues along the axis keeps its numbering

    Returns
    -------
    a dataset in which every variable along ``mode`` is renumbered, ``coupled_with`` included
    """
    axis = _axis_to_follow(dataset)
    if axis is None:
        return dataset
    values = _complex(dataset, "eigenvalue", axis, ("mode",))
    vectors = _complex(dataset, "eigenvector", axis, ("mode", "state"))
    orders = np.empty(values.shape, np.intp)
    for curve in np.ndindex(values.shape[:-2]):
        orders[curve] = _follow_curve(values[curve], vectors[curve])
    return _renumbered(dataset, orders, axis)


def _axis_to_follow(dataset: xr.Dataset) -> str | None:
    """The first dim with more than one numeric value."""
    for name in dataset["eigenvalue_real"].dims[:-1]:
        numeric = name not in dataset.coords or dataset[name].dtype.kind == "f"
        if numeric and dataset.sizes[name] > 1:
            return str(name)
    return None


def _arranged(dataset: xr.Dataset, name: str, axis: str, last: tuple[str, ...]) -> list[str]:
    others = [str(dim) for dim in dataset[name].dims if dim not in (axis, *last)]
    return [*others, axis, *last]


def _complex(dataset: xr.Dataset, stem: str, axis: str, last: tuple[str, ...]) -> Complex:
    """Real and imaginary parts, with the followed axis before `last`."""
    order = _arranged(dataset, f"{stem}_real", axis, last)
    real = dataset[f"{stem}_real"].transpose(*order).values
    imag = dataset[f"{stem}_imag"].transpose(*order).values
    result: Complex = real + 1j * imag
    return result


def _follow_curve(values: Complex, vectors: Complex) -> Order:
    """Numbering of the modes at each point of a curve.

    Parameters
    ----------
    values : (points, modes), NaN where nothing was computed
    vectors : (points, modes, states)

    Returns
    -------
    (points, modes): which of a point's modes stands at each place
    """
    count = values.shape[1]
    orders = np.tile(np.arange(count), (len(values), 1))
    previous: tuple[Complex, Complex] | None = None
    for point, (value, vector) in enumerate(zip(values, vectors, strict=True)):
        if not np.isfinite(value).all():
            continue
        if previous is not None:
            orders[point] = _matched(*previous, value, vector)
        previous = value[orders[point]], vector[orders[point]]
    return orders


def _matched(
    old_values: Complex, old_vectors: Complex, new_values: Complex, new_vectors: Complex
) -> Order:
    """For each old mode the new one that continues it: near in value and alike in shape."""
    from scipy.optimize import linear_sum_assignment

    scale = max(float(np.abs(old_values).max()), np.finfo(float).tiny)
    distance = np.abs(old_values[:, None] - new_values[None, :]) / scale
    old, new = _unit_rows(old_vectors), _unit_rows(new_vectors)
    unlike = 1.0 - np.abs(old.conj() @ new.T)
    order: Order = linear_sum_assignment(distance + 0.1 * unlike)[1]
    return order


def _unit_rows(vectors: Complex) -> Complex:
    vectors = np.nan_to_num(vectors)
    lengths = np.linalg.norm(vectors, axis=1, keepdims=True)
    result: Complex = vectors / np.where(lengths > 0.0, lengths, 1.0)
    return result


def _renumbered(dataset: xr.Dataset, orders: Order, axis: str) -> xr.Dataset:
    result = dataset.copy()
    for name, variable in dataset.data_vars.items():
        if "mode" in variable.dims:
            result[name] = _taken(dataset, str(name), orders, axis)
    if "coupled_with" in dataset:
        result["coupled_with"] = _partners_renumbered(result["coupled_with"], orders, axis)
    return result


def _taken(dataset: xr.Dataset, name: str, orders: Order, axis: str) -> xr.DataArray:
    """One variable with its modes in the new order."""
    variable = dataset[name]
    behind = tuple(str(d) for d in variable.dims[variable.dims.index("mode") + 1 :])
    arranged = variable.transpose(*_arranged(dataset, name, axis, ("mode", *behind)))
    index = orders.reshape(*orders.shape, *(1 for _ in behind))
    taken = np.take_along_axis(arranged.values, index, axis=orders.ndim - 1)
    return arranged.copy(data=taken).transpose(*variable.dims)


def _partners_renumbered(partners: xr.DataArray, orders: Order, axis: str) -> xr.DataArray:
    """``coupled_with`` names modes by number: these follow the renumbering."""
    dims = [str(d) for d in partners.dims if d not in (axis, "mode")]
    arranged = partners.transpose(*dims, axis, "mode")
    inverse = np.argsort(orders, axis=-1)
    old = arranged.values
    moved = np.take_along_axis(inverse, np.clip(old, 0, orders.shape[-1] - 1), axis=-1)
    renamed = np.where(old >= 0, moved, old).astype(old.dtype)
    return arranged.copy(data=renamed).transpose(*partners.dims)
