"""Several runs as one dataset, as one run of all their points would have it.

``xr.concat`` alone makes numbers of classes where a run has no point, leaves gaps among values of
any number per point, and lets the first run speak for all.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import xarray as xr

from fiv_cli.analyses.catalogue import named
from fiv_cli.data.assemble import numbered, point_of_each
from fiv_cli.data.dataset import Dataset, Labelled
from fiv_cli.data.modes import follow_modes
from fiv_cli.flags import STATUS, TABLES
from fiv_cli.reading.select import SelectionError, axis_names, observations, ragged_dims

ROW = "_row"
"""Where each point of the whole lies among those of the runs, one behind another; -1: nowhere."""

SUMMED = ("points_run", "points_filled_in", "sample_size", "sample_mislabelled")
"""Attributes of a refined run that count its points."""


def joined(runs: Sequence[xr.Dataset], along: str) -> xr.Dataset:
    """Runs of one analysis as one dataset.

    Parameters
    ----------
    runs : whole datasets; a point of the grid of all that none of them has is ``pending``
    along : an axis of each, or a fixed parameter

    Raises
    ------
    SelectionError : a run has no such parameter, two have the same value of it, or not the same
        variables of any number of values per point
    """
    _refuse_unlike(runs, along)
    axes = {along, *(str(dim) for run in runs for dim in run["status"].dims)}
    begins = np.cumsum([0, *(run["status"].size for run in runs)])
    whole = xr.concat(
        [_over(run, axes, int(begin)) for run, begin in zip(runs, begins, strict=False)],
        along,
        join="outer",
        data_vars="all",
        coords="different",
        compat="equals",
        fill_value=_fills(runs),
    )
    _refuse_twice(whole[along])
    for dim, sizes in ragged_dims(runs[0]).items():
        whole = whole.assign(_in_order(runs, whole[ROW], dim, str(sizes.name)))
    whole = whole.drop_vars(ROW)
    if "mode_number" in whole.coords:  # each run has followed its own modes
        whole = follow_modes(Dataset.of(whole)).to_xarray()
    for axis in whole.coords.values():  # which lacks no value, whatever xarray takes for granted
        axis.encoding["_FillValue"] = None
    return whole.drop_attrs(deep=False).assign_attrs(_of_all(runs) | _lacking(whole["status"]))


def _refuse_unlike(runs: Sequence[xr.Dataset], along: str) -> None:
    for number, run in enumerate(runs, 1):
        if along not in run.coords:
            known = ", ".join([*axis_names(run), *_fixed(run)])
            raise SelectionError(f"{along}: no parameter of run {number}\nit has {known}")
        if run[along].dims not in ((), (along,)):
            raise SelectionError(_together(run, along, number))
        if _in_rows(run) != _in_rows(runs[0]):
            raise SelectionError(
                f"run {number} holds other variables of any number of values per point\n"
                "next: join runs of one analysis"
            )


def _together(run: xr.Dataset, along: str, number: int) -> str:
    """That an axis of a run advances with others, and how its points are found in another run."""
    names = [str(name) for name, coord in run.coords.items() if coord.dims == run[along].dims]
    others = ", ".join(name for name in names if name != along)
    places = ", ".join(f"{name}=run[{name!r}]" for name in names)
    return (
        f"{along}: in run {number} it advances together with {others}\n"
        f"next: of a run over a grid the same points are grid.sel({places})"
    )


def _refuse_twice(axis: xr.DataArray) -> None:
    values, counts = np.unique(axis.values, return_counts=True)
    if counts.max() > 1:
        value = values[counts.argmax()]
        raise SelectionError(
            f"{axis.name} = {value}: {counts.max()} runs have it\nnext: leave out all but one, or "
            "join along another parameter"
        )


def _fixed(run: xr.Dataset) -> list[str]:
    return [str(name) for name, coord in run.coords.items() if coord.ndim == 0]


def _in_rows(run: xr.Dataset) -> list[str]:
    """The variables of any number of values per point."""
    return [str(name) for dim in ragged_dims(run) for name in run if dim in run[name].dims]


def _over(run: xr.Dataset, axes: set[str], begin: int) -> xr.Dataset:
    """The run over all `axes`, with the places of its points, from `begin`, in place of rows."""
    places = np.arange(begin, begin + run["status"].size).reshape(run["status"].shape)
    plain = run.drop_dims([*ragged_dims(run)])
    placed = plain.assign({ROW: (run["status"].dims, places)})
    return placed.expand_dims([name for name in _fixed(run) if name in axes])


def _fills(runs: Sequence[xr.Dataset]) -> dict[str, Any]:
    """What stands at a point that no run has, where that is not NaN."""
    tables = {str(name): named(str(name)).flags for run in runs for name in run}
    flags = {name: np.int8(TABLES[flag].fill_code) for name, flag in tables.items() if flag}
    sizes = {str(one.name): np.int32(0) for run in runs for one in ragged_dims(run).values()}
    return {**flags, **sizes, ROW: -1}


def _in_order(
    runs: Sequence[xr.Dataset], rows: xr.DataArray, dim: str, size: str
) -> dict[str, xr.Variable]:
    """The values along `dim` of all runs, in the order of the points of the whole."""
    counts = np.concatenate([run[size].values.ravel() for run in runs])
    held = rows.values[rows.values >= 0]
    begins = np.cumsum(counts) - counts
    into = np.cumsum(counts[held]) - counts[held]
    order = np.repeat(begins[held] - into, counts[held]) + np.arange(counts[held].sum())
    sizes = np.where(rows.values >= 0, counts[rows.values], 0).ravel()
    point = point_of_each(dim, tuple(map(str, rows.dims)), sizes)
    made = {dim: numbered(dim, len(order)), dim.removesuffix("obs") + "point": point}
    values = {
        name: Labelled(
            (dim,), np.concatenate([observations(run, name) for run in runs])[order], one.attrs
        )
        for name, one in ((name, runs[0][name]) for name in _in_rows(runs[0]))
        if dim in one.dims
    }
    return {name: xr.Variable(dim, v.values, v.attrs) for name, v in (values | made).items()}


def _lacking(status: xr.DataArray) -> dict[str, str]:
    """What a dataset says that lacks points."""
    there = int((status != STATUS.fill_code).sum())
    return {} if there == status.size else {"partial": f"{there} of {status.size} points"}


def _of_all(runs: Sequence[xr.Dataset]) -> dict[str, Any]:
    """Attributes: those that all runs share; of their cases all; what they count, added up."""
    first, *others = (run.attrs for run in runs)
    shared = {n: v for n, v in first.items() if all(n in o and o[n] == v for o in others)}
    texts = {n: dict.fromkeys(run.attrs.get(n, "") for run in runs) for n in ("case", "history")}
    refined = all(run.attrs.keys() >= {*SUMMED} for run in runs)
    counted = {n: sum(run.attrs[n] for run in runs) for n in SUMMED} if refined else {}
    for name in ("variables_json", "partial"):  # of the form that each has
        shared.pop(name, None)
    told = {name: "\n".join(each) for name, each in texts.items()}
    return {**shared, **counted, **told, "figures_json": first.get("figures_json", "[]")}
