"""Where motions pass what the equations of their model take as small."""

from __future__ import annotations

import functools
import operator
from collections.abc import Container, Iterable, Iterator, Mapping
from math import isfinite
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from fiv_cli.models import get_model
from fiv_cli.models.base import State

if TYPE_CHECKING:
    import xarray as xr


BRANCH = "branch_min", "branch_max"  # of the state that is observed along a branch


def passing(dataset: xr.Dataset) -> dict[str, dict[str, Any]]:
    """State -> how small it is to be, and at how many points it passes that; of those it does."""
    return {name: facts for name, facts in _each(_with_branches(dataset)) if facts["points"]}


def _with_branches(dataset: xr.Dataset) -> xr.Dataset:
    """With how far the observed state goes along the branch of each point, where one is followed.

    Not of datasets that are joined, whose branches are not in one row.
    """
    from fiv_cli.reading.select import row_sizes

    sizes = row_sizes(dataset, BRANCH[0]) if BRANCH[0] in dataset else None
    if sizes is None or dataset[BRANCH[0]].ndim > 1:
        return dataset
    state = observed_along(str(dataset[BRANCH[0]].attrs["long_name"]))
    rows = {name: dataset[name].values for name in BRANCH}
    far = furthest(rows, sizes.values.ravel()).reshape(sizes.shape)
    return dataset.assign({along_branch(state): (sizes.dims, far)})


def furthest(rows: Mapping[str, NDArray[Any]], sizes: NDArray[Any]) -> NDArray[np.float64]:
    """How far from zero the branch of each point goes, 0 where none is; of its rows in turn."""
    far, row = np.zeros(sizes.size), np.repeat(np.arange(sizes.size), sizes)
    for name in BRANCH:
        np.fmax.at(far, row, np.abs(rows[name][: row.size]))
    return far


def observed_along(words: str) -> str:
    """The state that the words of `BRANCH` are about: least phi of the cycle."""
    return words.split(" ")[1]


def along_branch(state: str) -> str:
    """What tells how far a state goes along a branch."""
    return f"{state} along the branch"


def lines(found: Mapping[str, Mapping[str, Any]]) -> list[str]:
    """For people."""
    return [
        f"{name} passes {facts['small']:g} {facts['units']} at {facts['points']} of "
        f"{facts['of']} points, though the equations of the model take it as small"
        for name, facts in found.items()
    ]


def passing_in(
    model: str, blocks: Iterable[tuple[NDArray[np.intp], Mapping[str, NDArray[Any]]]], size: int
) -> dict[str, dict[str, Any]]:
    """The same of what a run has stored: for each block the points, less than 0 where none is."""
    parts = list(blocks)
    counts = {
        state: sum(_count(values, positions >= 0, state) for positions, values in parts)
        for state in small_states(model)
    }
    return {
        state.name: {"small": state.small, "units": state.unit, "points": count, "of": size}
        for state, count in counts.items()
        if count
    }


def _count(values: Mapping[str, NDArray[Any]], known: NDArray[np.bool_], state: State) -> int:
    passed = np.zeros(known.size, bool)
    for name in _ends(state.name, values):
        passed |= (np.abs(values[name]).reshape(known.size, -1) > state.small).any(axis=1)
    return int((passed & known).sum())


def _each(dataset: xr.Dataset) -> Iterator[tuple[str, dict[str, Any]]]:
    for state in small_states(str(dataset.attrs.get("model", ""))):
        passed = _passed(dataset, state)
        if passed is not None:
            facts = {"small": state.small, "units": state.unit, "points": int(passed.sum())}
            yield state.name, {**facts, "of": passed.size}


def small_states(model: str) -> list[State]:
    """The states that a model takes as small; none of a model that is not here."""
    try:
        known = get_model(model)
    except KeyError:
        return []
    return [state for state in known.states(known.default_options()) if isfinite(state.small)]


def _passed(dataset: xr.Dataset, state: State) -> xr.DataArray | None:
    """At which points a motion passes what is small; None where no motion tells it."""
    ends = _ends(state.name, dataset.data_vars)
    own = (
        [dim for dim in dataset[ends[0]].dims if dim not in dataset["status"].dims] if ends else []
    )
    masks = [(abs(dataset[one]) > state.small).any(own) for one in ends]
    return functools.reduce(operator.or_, masks) if masks else None


def _ends(name: str, known: Container[Any]) -> list[str]:
    """The variables that tell how far a state goes."""
    told = f"{name}_min", f"{name}_max", name, along_branch(name)
    return [one for one in told if one in known]
