"""Which of several cycles a start leads to, as their size tells."""

from __future__ import annotations

import json

import numpy as np
import xarray as xr

from fiv_cli.reading.datasets import is_class

# Of the tolerance, relative: in shipped cases L_s differs by no more than 10 of it between starts
# that reach one cycle, by 1e5 and more where they reach two.
ANOTHER = 1e3


def size_of_cycles(dataset: xr.Dataset) -> xr.DataArray:
    """L_s of what is periodic; the range of all at points where some have none.

    Where nothing slides at rest nothing does: L_s is measured from there.
    """
    is_cycle = is_class(dataset["attractor"], ("periodic",))
    size = dataset.get("L_s", xr.full_like(is_cycle, float("nan"), float)).where(is_cycle)
    for name in [n for n in displacements(dataset) if f"{n}_min" in dataset][:1]:
        extent = (dataset[f"{name}_max"] - dataset[f"{name}_min"]).where(is_cycle)
        lacking = (size.isnull() & extent.notnull()).any("initial")
        size = extent.where(lacking, size)
    return size


def number_of_each(sizes: np.ndarray, tolerance: float) -> np.ndarray:
    """The number of the cycle of each size, from the least: where they differ, it is another."""
    order = np.argsort(sizes)
    another = np.diff(sizes[order]) > tolerance * sizes[order][1:]
    number = np.zeros(sizes.size, int)
    number[order] = np.append(0, np.cumsum(another))
    return number


def displacements(dataset: xr.Dataset) -> list[str]:
    """Those whose greatest value is known."""
    greatest = [n for n in map(str, dataset) if n.endswith("_max") and not n.endswith("_dot_max")]
    return [name.removesuffix("_max") for name in greatest]


def tolerance(dataset: xr.Dataset) -> float:
    """Relative: a motion whose L_s differs by more is another."""
    return ANOTHER * float(json.loads(dataset.attrs["solver_json"])["rtol"])
