"""Shares: of the points along some axes, how many satisfy a condition.

The share of phases and starts from which stick-slip survives is one number at each speed and
preload; the share of a plane of speeds and preloads in which it exists is an area. A share
divided by the share at a reference point is a ratio of areas.

A point without an answer may satisfy the condition or not: a share over such points is an interval,
from none of them to all.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import xarray as xr

from fiv_cli.reading import select
from fiv_cli.reading.datasets import flag_names
from fiv_cli.reading.known import is_class, unknown_points

# The variables that a share becomes: the middle of the interval, and its ends.
SHARE, LOW, HIGH = "share", "share_low", "share_high"


def with_share(dataset: xr.Dataset, variable: str, share: Mapping[str, Any]) -> xr.Dataset:
    """The dataset with the axes of a share counted out.

    Parameters
    ----------
    dataset : any dataset with a ``status``
    variable : what the condition is on; one value per point
    share : ``of``, a condition on numbers (``". > 0"``) or a class (``"not equilibrium"``);
        ``over``, the axes that are counted along; and ``relative_to``, axis -> value, the point
        whose share is one (or nothing)

    Returns
    -------
    xr.Dataset : ``share_low``, ``share_high``, the ``share`` in the middle, and ``status`` over the
        axes that are left. Where no point at all has an answer the shares are NaN, and the status
        is that of the first point

    Raises
    ------
    SelectionError : no such variable, axis, class or reference point
    """
    if variable not in dataset:
        raise select.SelectionError(f"{variable}: no variable of the dataset")
    dims = [str(select.axis_of(dataset, name).dims[0]) for name in share["over"]]
    missing = unknown_points(dataset, variable, "undecided" in share["of"])
    held = hits(dataset[variable], share["of"])
    found = xr.Dataset(
        {
            LOW: held.where(~missing, 0.0).mean(dims).where(~missing.all(dims)),
            HIGH: held.where(~missing, 1.0).mean(dims).where(~missing.all(dims)),
            "status": _status(dataset["status"], missing, dims),
        }
    )
    found = _relative(found, share.get("relative_to", {}))
    found = found.assign({SHARE: 0.5 * (found[LOW] + found[HIGH])})
    words = _words(variable, share["of"])
    words += " over that of the reference" if "relative_to" in share else ""
    for name, end in ((SHARE, ""), (LOW, ", at least"), (HIGH, ", at most")):
        found[name].attrs = {"units": "1", "long_name": words + end}
    return found.assign_attrs(dataset.attrs)


def hits(array: xr.DataArray, of: str) -> xr.DataArray:
    """1 where the condition holds, else 0; a value that does not apply (NaN) does not hold."""
    if flag_names(array.attrs):
        name = of.removeprefix("not ").strip()
        if name not in flag_names(array.attrs).values():
            raise select.SelectionError(f"{name}: no class of {array.name}")
        return (is_class(array, (name,)) != of.startswith("not ")).astype(float)
    test = select.condition(of)
    if test is None:
        raise select.SelectionError(f"{of}: no condition on {array.name}, such as '. > 0'")
    return array.copy(data=test(array.values).astype(float))


def _status(status: xr.DataArray, missing: xr.DataArray, dims: Sequence[str]) -> xr.DataArray:
    """Status "ok" where a point along `dims` is known, else what the first one says."""
    stacked = status.stack(counted=dims).transpose(..., "counted")
    first = missing.stack(counted=dims).transpose(*stacked.dims).argmax("counted")
    names = {name: code for code, name in flag_names(status.attrs).items()}
    shown = stacked.isel(counted=first).drop_vars(["counted", *dims], errors="ignore")
    # a point of undecided class has been computed, and is yet no answer
    pending = xr.where(shown == names["ok"], names["pending"], shown)
    found = xr.where(missing.all(dims), pending, names["ok"])
    return found.astype(status.dtype).assign_attrs(status.attrs)


def _relative(found: xr.Dataset, reference: Mapping[str, Any]) -> xr.Dataset:
    """The shares over that at the reference point, when there is one."""
    if not reference:
        return found
    part = select.subset(found, reference, nearest=False)
    dims = [str(select.axis_of(found, name).dims[0]) for name in reference]
    whole = part.isel(dict.fromkeys(dims, 0), drop=True)
    ends = ((LOW, HIGH), (HIGH, LOW))
    ratios = {name: found[name] / whole[by].where(whole[by] > 0.0) for name, by in ends}
    return found.assign({n: ratio.transpose(*found[n].dims) for n, ratio in ratios.items()})


def _words(variable: str, of: str) -> str:
    """``share with stick fraction > 0``, ``share that is not equilibrium``."""
    if "." in of:
        return f"share with {of.replace('.', variable.replace('_', ' '), 1)}"
    return f"share that is {of.replace('_', ' ')}"
