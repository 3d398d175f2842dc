"""Parts of a dataset by the names and values of its axes; ragged variables follow.

A selection maps an axis to what is wanted of it: a number, a label, a list of either, or a
condition on the value ``.`` such as ``"0.9 <= . < 1.8"``. A label stands also for the members of
a random start (``far`` for ``far-000``, ``far-001``, ...).
"""

from __future__ import annotations

import json
import math
import operator
import re
from collections.abc import Callable, Hashable, Mapping, Sequence
from types import MappingProxyType
from typing import Any

import numpy as np
import xarray as xr

from fiv_cli.analyses.catalogue import computed_by
from fiv_cli.case.grammar import SAME, parse_condition
from fiv_cli.errors import UsageError
from fiv_cli.flags import NOT_COMPUTED
from fiv_cli.notation.units import convert
from fiv_cli.reading.datasets import flag_names, is_class

_COMPARE: dict[str, Callable[[np.ndarray, float], np.ndarray]] = {
    "<": operator.lt,
    "<=": operator.le,
    ">": operator.gt,
    ">=": operator.ge,
    "==": operator.eq,
    "!=": lambda values, bound: (values < bound) | (values > bound),  # of nothing it is not known
}

MOST_NAMED = 12  # labels of an axis that a message names


class SelectionError(UsageError):
    """What is selected does not exist in the dataset."""


def computing(name: str) -> str:
    """What computes a variable that a dataset does not have; "" where nothing does."""
    told = computed_by(name)
    return f"{told}; of one point `fiv history` does" if '"history"' in told else told


def condition(text: str) -> Callable[[np.ndarray], np.ndarray] | None:
    """The condition that `text` states on ``.``; None when it is no condition.

    Bounds are moved outwards (inwards, for a strict one) by a relative 1e-9, so that a value
    written like the bound counts as equal to it.
    """
    tests = parse_condition(text)
    if not tests:
        return None
    return lambda values: np.logical_and.reduce([_holds(values, *test) for test in tests])


def _holds(values: np.ndarray, sign: str, bound: float) -> np.ndarray:
    equal = np.isclose(values, bound, rtol=SAME, atol=0.0)
    return np.where(equal, sign in ("<=", ">=", "=="), _COMPARE[sign](values, bound))


def axis_of(dataset: xr.Dataset, name: str) -> xr.DataArray:
    """The axis called `name` (``initial.x_dot`` and ``initial_x_dot`` are the same), one dim.

    A dim without a coordinate counts from 0.
    """
    name = name.replace(".", "_")
    if name in dataset.coords and dataset.coords[name].ndim == 1:
        return dataset.coords[name]
    if name in dataset.dims:
        return xr.DataArray(np.arange(dataset.sizes[name]), dims=name, name=name)
    known = ", ".join(str(axis) for axis in axis_names(dataset)) or "none"
    of_class = name in dataset and "flag_meanings" in dataset[name].attrs
    where = f" --at {name}=CLASS" * of_class
    hint = f"; fiv show FILE.nc --csv {name}{where} lists the variable" * (name in dataset)
    raise SelectionError(f"{name}: no axis of this dataset\nits axes: {known}{hint}")


def has_axis(dataset: xr.Dataset, axis: Hashable) -> bool:
    """Whether `axis_of` has an axis of this name."""
    name = str(axis).replace(".", "_")
    return name in dataset.dims or (name in dataset.coords and dataset.coords[name].ndim == 1)


def axis_names(dataset: xr.Dataset) -> list[str]:
    """Names of every axis that can be selected on, observations of ragged arrays left out.

    Axes that advance together are all named, their common dim is not; nor are units along one.
    """
    hidden = set(ragged_dims(dataset))
    units = {f"{dim}_units" for dim in dataset.dims}
    coords = [name for name, c in dataset.coords.items() if c.ndim == 1 and c.dims[0] not in hidden]
    coords = [name for name in coords if name not in units]
    named = {dataset.coords[name].dims[0] for name in coords}
    bare = [dim for dim in dataset.dims if dim not in named and dim not in hidden]
    return [str(name) for name in [*coords, *bare]]


def is_numeric(axis: xr.DataArray) -> bool:
    """Whether the axis holds numbers rather than labels."""
    return axis.dtype.kind in "fiu"


def matching(axis: xr.DataArray, wanted: Any, *, nearest: bool) -> np.ndarray:
    """Which entries of `axis` are meant by `wanted`, as a mask.

    Parameters
    ----------
    axis : coordinate along one dim
    wanted : number, label, condition, or a list of these
    nearest : take the nearest number; otherwise it must agree to 1e-9

    Raises
    ------
    SelectionError : nothing matches
    """
    if isinstance(wanted, list | tuple):
        return np.logical_or.reduce([matching(axis, one, nearest=nearest) for one in wanted])
    if is_numeric(axis):
        mask = _matching_number(axis, wanted, nearest)
    else:
        mask = _matching_label(axis.values.astype(str), str(wanted))
    if not mask.any():
        there = _what_exists(axis, wanted)
        raise SelectionError(f"{axis.name} = {wanted}: not in this dataset\n{there}")
    return mask


def _matching_number(axis: xr.DataArray, wanted: float | str, nearest: bool) -> np.ndarray:
    test = condition(wanted) if isinstance(wanted, str) else None
    if test is not None:
        return np.asarray(test(axis.values))
    value = _in_unit_of(axis, wanted)
    distance = np.abs(axis.values - value)
    if nearest and axis.dtype.kind == "f":  # what is counted has no nearest
        return distance == np.min(distance)
    return distance <= SAME * abs(value)


def _in_unit_of(axis: xr.DataArray, wanted: float | str) -> float:
    """A number, or a number with a unit ("20 rpm"), in the unit of the axis."""
    try:
        return convert(wanted, str(axis.attrs.get("units", "1")))
    except ValueError as error:
        raise SelectionError(
            f"{axis.name} = {wanted}: {error}\nwrite a number or a condition such as '0.1 <= . < 2'"
        ) from error


def _matching_label(labels: np.ndarray, wanted: str) -> np.ndarray:
    member = re.compile(re.escape(wanted) + r"(-\d+)?$")
    exact = labels == wanted
    return exact if exact.any() else np.array([bool(member.match(label)) for label in labels])


def _what_exists(axis: xr.DataArray, wanted: Any) -> str:
    if not is_numeric(axis) or axis.size <= 8:
        values = [f"{value:g}" if is_numeric(axis) else str(value) for value in axis.values]
        if len(values) > MOST_NAMED:
            values[MOST_NAMED - 1 : -1] = ["..."]
        return f"{axis.name}: {', '.join(values)}"
    span = f"{axis.name}: {axis.size} values from {axis.values.min():g} to {axis.values.max():g}"
    if condition(str(wanted)):
        return span
    nearest = axis.values[np.abs(axis.values - _in_unit_of(axis, wanted)).argmin()]
    return f"{span}; the nearest is {nearest:.12g}"


def having(classes: xr.DataArray, wanted: str | Sequence[str]) -> xr.DataArray:
    """Where a result has one of the classes that are wanted."""
    names = [wanted] if isinstance(wanted, str) else wanted
    known = [name for name in flag_names(classes.attrs).values() if name != NOT_COMPUTED]
    for name in names:
        if name not in known:
            told = f"{classes.name} = {name}: no such class\nthere are: {', '.join(known)}"
            raise SelectionError(told)
    return is_class(classes, tuple(names))


def subset(
    dataset: xr.Dataset, selection: Mapping[str, Any], *, nearest: bool = True
) -> xr.Dataset:
    """The part of `dataset` that `selection` names; every dim stays, ragged rows follow.

    Raises
    ------
    SelectionError : an axis, value or label does not exist, or values do not stand together
    """
    masks: dict[str, np.ndarray] = {}
    for name, wanted in selection.items():
        axis = axis_of(dataset, name)
        dim = str(axis.dims[0])
        mask = matching(axis, wanted, nearest=nearest)
        masks[dim] = mask & masks.get(dim, True)
        if not masks[dim].any():
            raise SelectionError(_never_together(dataset, dim, selection))
    return masked(dataset, masks)


def _never_together(dataset: xr.Dataset, dim: str, selection: Mapping[str, Any]) -> str:
    """Of parameters that advance together, what was asked for and what there is."""
    axes = {name: axis_of(dataset, name) for name in selection}
    axes = {name: axis for name, axis in axes.items() if axis.dims == (dim,)}
    names, wanted = ", ".join(axes), ", ".join(str(selection[name]) for name in axes)
    rows = [
        ", ".join(map(str, row)) for row in zip(*(a.values for a in axes.values()), strict=True)
    ]
    there = "; ".join(rows if len(rows) <= 8 else [*rows[:3], "...", rows[-1]])
    return f"{names} = {wanted}: never together in this dataset\n{names}: {there}"


def masked(dataset: xr.Dataset, masks: Mapping[str, np.ndarray]) -> xr.Dataset:
    """The part of `dataset` that a mask for each of some dims leaves; ragged rows follow."""
    indices = {dim: np.flatnonzero(mask) for dim, mask in masks.items()}
    return dataset.isel({**indices, **_observations(dataset, masks)})


def part_of_each(
    analyses: Mapping[str, xr.Dataset], selection: Mapping[str, Any]
) -> dict[str, xr.Dataset]:
    """The part of each analysis at just the values that `selection` names.

    An axis that one does not have, as ``initial`` of eigenvalues, says nothing of it.

    Raises
    ------
    SelectionError : an axis is in none of them, or a value is not on it
    """
    own = {name: _known(dataset, selection) for name, dataset in analyses.items()}
    for axis in selection:
        if not any(axis in known for known in own.values()):
            axis_of(next(iter(analyses.values())), axis)
    return {name: subset(one, own[name], nearest=False) for name, one in analyses.items()}


def _known(dataset: xr.Dataset, selection: Mapping[str, Any]) -> dict[str, Any]:
    """What `selection` says of the axes that the dataset has."""
    names = axis_names(dataset)
    return {name: said for name, said in selection.items() if name.replace(".", "_") in names}


def _observations(dataset: xr.Dataset, masks: Mapping[str, np.ndarray]) -> dict[str, np.ndarray]:
    """Observations, per ragged dim, of the rows that the masks leave."""
    kept = {}
    for dim, sizes in ragged_dims(dataset).items():
        wanted = [masks.get(str(d), np.ones(dataset.sizes[d], bool)) for d in sizes.dims]
        rows = np.ones(sizes.shape, bool)
        for place, mask in enumerate(wanted):
            rows &= np.expand_dims(mask, [d for d in range(sizes.ndim) if d != place])
        kept[dim] = np.flatnonzero(np.repeat(rows.ravel(), sizes.values.ravel()))
    return kept


def ragged_dims(dataset: xr.Dataset) -> dict[str, xr.DataArray]:
    """Dim of the observations -> row sizes, for each contiguous ragged array of the dataset."""
    return {
        str(variable.attrs["sample_dimension"]): variable
        for variable in dataset.data_vars.values()
        if variable.attrs.get("sample_dimension") in dataset.dims
    }


def row_sizes(dataset: xr.Dataset, name: str) -> xr.DataArray | None:
    """Row sizes of the ragged variable `name`; None when it is an ordinary one."""
    sizes = ragged_dims(dataset)
    return next((sizes[str(dim)] for dim in dataset[name].dims if str(dim) in sizes), None)


def row_of_each(sizes: xr.DataArray) -> np.ndarray:
    """Flat (C order) index of the row that each observation belongs to, shape (observations,)."""
    flat = sizes.values.ravel()
    return np.repeat(np.arange(flat.size), flat)


def observations(
    dataset: xr.Dataset, name: str, at: Mapping[str, Any] = MappingProxyType({})
) -> xr.DataArray:
    """The values of the ragged variable `name`, at just the points that `at` names.

    Each has the coordinates of its point.

    Where datasets of the same axes were joined along a parameter (``xr.concat``), what fills up
    the shorter ones is left out.

    Raises
    ------
    SelectionError : there is no such variable, it has a value for each point, or the axes of what
        was joined differed: nothing tells then which values belong where; or no such axis or value
    """
    sizes = row_sizes(dataset, name) if name in dataset else None
    if sizes is None:
        told = _those_of_any_number(dataset)
        raise SelectionError(f"{name}: not of any number of values per point\n{told}")
    obs = str(sizes.attrs["sample_dimension"])
    if sizes.isnull().any():
        raise SelectionError("the axes of the joined datasets differ\nnext: api.join(runs, ...)")
    joined = [dim for dim in dataset[name].dims if dim != obs]
    rows = sizes.transpose(*joined, ...).astype(int)
    counts = rows.values.reshape(*(rows.sizes[dim] for dim in joined), -1).sum(axis=-1)
    kept = np.arange(dataset.sizes[obs]) < counts[..., None]
    row = row_of_each(rows)
    _refuse_cut(dataset, obs, joined, kept, row)
    of_points = {
        str(axis): (obs, xr.broadcast(rows, coord)[1].values.ravel()[row], coord.attrs)
        for axis, coord in rows.coords.items()
    }
    stored = dataset[name].transpose(*joined, obs)
    values = xr.DataArray(stored.values[kept], of_points, [obs], name, stored.attrs)
    for axis, wanted in at.items():
        values = values[_lying_at(axis, wanted, rows, values)]
    return values


def _lying_at(axis: str, wanted: Any, rows: xr.DataArray, values: xr.DataArray) -> np.ndarray:
    """Which values lie where `axis`, or a parameter that all points share, is `wanted`."""
    if axis not in rows.coords:
        known = ", ".join(str(name) for name, coord in rows.coords.items() if coord.ndim)
        raise SelectionError(f"{axis}: no axis of this dataset\nits axes: {known}")
    there = rows.coords[axis]
    there = there if there.ndim else there.expand_dims(axis)
    return np.isin(values[axis], there[matching(there, wanted, nearest=False)])


def _those_of_any_number(dataset: xr.Dataset) -> str:
    """Which they are; where this is but the head of a file of several analyses, where to look."""
    groups = [] if dataset.data_vars else [*json.loads(dataset.attrs.get("analyses_json", "{}"))]
    if len(groups) > 1:
        return (
            f"this is the head of a file of several analyses: {', '.join(groups)}\n"
            'next: api.observations("FILE.nc", ...), or open one of them: group="NAME"'
        )
    ragged = {str(v) for dim in ragged_dims(dataset) for v in dataset if dim in dataset[v].dims}
    return f"these are: {', '.join(sorted(ragged)) or 'none here'}"


def _refuse_cut(
    dataset: xr.Dataset, obs: str, joined: Sequence[Hashable], kept: np.ndarray, row: np.ndarray
) -> None:
    """Refuse what was selected, or reordered, apart from its ragged values: they would be others'.

    Raises
    ------
    SelectionError
    """
    point = f"{obs.removesuffix('_obs')}_point"
    if point not in dataset:
        return
    stored = dataset[point].transpose(*joined, obs).values  # NaN: fills up a shorter run
    size = dataset["status"].size // math.prod(dataset.sizes[dim] for dim in joined)
    whole = np.array_equal(kept, ~np.isnan(stored))
    if not (whole and np.array_equal(stored[kept], row % size)):
        raise SelectionError(
            "points were selected, or axes transposed, apart from the values that belong to them\n"
            "next: take the values of the whole dataset, then select: "
            "values = api.observations(whole, ...); values[values['AXIS'] == 2.0]"
        )


def contiguous(dataset: xr.Dataset) -> xr.Dataset:
    """The dataset with the values of ragged variables one behind another, also of joined runs.

    Without those that nothing leads back to their points.
    """
    for obs in ragged_dims(dataset):
        names = [str(name) for name, one in dataset.items() if obs in one.dims]
        joined = [name for name in names if dataset[name].ndim > 1]
        try:
            values = {name: observations(dataset, name) for name in joined or names[:1]}
        except SelectionError:  # points were selected apart from them
            dataset = dataset.drop_dims(obs)
            continue
        if joined:
            rows = {name: (obs, one.values, one.attrs) for name, one in values.items()}
            dataset = dataset.drop_dims(obs).assign(rows)
    return dataset
