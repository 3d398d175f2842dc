"""What a figure takes from the dataset of another case: variables over the same axes."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import TYPE_CHECKING

from fiv_cli.case.identity import output_of
from fiv_cli.data.hdf5 import read_attributes
from fiv_cli.errors import UsageError
from fiv_cli.reading.changed import changed_since
from fiv_cli.reading.datasets import read_analyses

if TYPE_CHECKING:
    import xarray as xr


def lent(names: Iterable[str]) -> Iterator[xr.Dataset]:
    """The variables called ``CASE:VARIABLE``, each in a dataset, under that name.

    Beside it stands what is told of each of its values: of critical ones the mode, which says what
    belongs together, and how many are unstable on either side.

    Raises
    ------
    UsageError : a case has not been run, or its dataset has no such variable
    """
    for name in [name for name in names if ":" in name]:
        case, _, variable = name.partition(":")
        path = output_of(case)
        if not path.exists():
            raise UsageError(f"{name}: {path} is not there\nnext: fiv run {case}.toml")
        holding = (one for one in read_analyses(path).values() if variable in one.data_vars)
        dataset = next(holding, None)
        if dataset is None:
            raise UsageError(f"{name}: no variable of {path}\nnext: fiv show {path}")
        beside = [one for one, of in dataset.items() if of.dims == dataset[variable].dims]
        beside += [of_point for of_point in ("status", "reason") if of_point in dataset]
        yield dataset[list({*beside})].rename_vars({variable: name})


def changed(names: Iterable[str]) -> Iterator[str]:
    """Of each case that lends variables so called how its file differs from what was run."""
    for case in dict.fromkeys(name.partition(":")[0] for name in names if ":" in name):
        path = output_of(case)
        if since := changed_since(read_attributes(path), path, drawn=False):
            yield f"what is drawn of {case} is of {path} as it was run; {since}"
