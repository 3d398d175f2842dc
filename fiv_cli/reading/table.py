"""Variables of a dataset as a table: a row for each value, with the axes of its point beside it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

from fiv_cli.case.words import variable_meant
from fiv_cli.errors import UsageError
from fiv_cli.flags import NOT_COMPUTED
from fiv_cli.notation.names import pick
from fiv_cli.reading import select
from fiv_cli.reading.datasets import class_names, error_of, flag_names

if TYPE_CHECKING:
    import xarray as xr


def as_csv(analyses: Mapping[str, xr.Dataset], names: Sequence[str], at: Mapping[str, Any]) -> str:
    """The rows in which one of the variables has a value; classes in words, numbers with errors.

    Parameters
    ----------
    analyses : by name; the first with all the variables is meant
    at : which points: axis -> value, label or condition

    Raises
    ------
    UsageError : no analysis has all the variables; there is no such axis or value.
    """
    from xarray import merge

    beside = {str(name) for one in analyses.values() for name in one.coords}
    names = [name for name in names if name not in beside] or list(names)
    dataset = _holding(analyses, names)
    told = [one for name in names for one in (name, error_of(name)) if one in dataset]
    ragged = [name for name in told if select.row_sizes(dataset, name) is not None]
    if ragged:
        held = [select.observations(dataset, name, at) for name in ragged]
    else:
        part = select.subset(dataset, at)
        held = [part[name] for name in dict.fromkeys(told)]
    words = [_in_words(one) for one in held]
    frame = merge(words, compat="no_conflicts").to_dataframe().reset_index()
    rows = select.ragged_dims(dataset)
    axes = [str(name) for name, axis in dataset.coords.items() if axis.ndim == 1]
    axes = [name for name in axes if name not in rows]
    counted = [] if ragged else [str(dim) for dim in held[0].dims]
    values = [str(one.name) for one in held]
    columns = [name for name in dict.fromkeys([*axes, *counted, *values]) if name in frame]
    text: str = frame[columns].dropna(subset=values, how="all").to_csv(index=False)
    return text


def _holding(analyses: Mapping[str, xr.Dataset], names: Sequence[str]) -> xr.Dataset:
    """The first analysis with all the variables."""
    for dataset in analyses.values():
        if all(name in dataset.data_vars for name in names):
            return dataset
    known = {str(name): None for one in analyses.values() for name in one.data_vars}
    for name in names:
        if hint := variable_meant(name, known) if name not in known else "":
            raise UsageError(f"there is no variable {name!r}; {hint}")
        pick(name, known, "variable", "fiv show FILE.nc")
    raise UsageError(f"{', '.join(names)}: no analysis has all of these\nnext: a table for each")


def _in_words(values: xr.DataArray) -> xr.DataArray:
    """Classes by their names; what was not computed has no value, like NaN."""
    if not flag_names(values.attrs):
        return values
    words = class_names(values)
    words[words == NOT_COMPUTED] = None
    return values.copy(data=words.reshape(values.shape))
