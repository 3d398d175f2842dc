"""Where motions pass what the equations of their model take as small."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from math import isfinite
from typing import Any

import xarray as xr

from fiv_cli.models import get_model
from fiv_cli.models.base import State


def passing(dataset: xr.Dataset) -> dict[str, dict[str, Any]]:
    """State -> how small it is to be, and at how many points it passes that; of those it does."""
    return {name: facts for name, facts in _each(dataset) if facts["points"]}


def lines(found: Mapping[str, Mapping[str, Any]]) -> list[str]:
    """For people."""
    return [
        f"  {name} passes {facts['small']:g} {facts['units']} at {facts['points']} of "
        f"{facts['of']} points, though the equations of the model take it as small"
        for name, facts in found.items()
    ]


def _each(dataset: xr.Dataset) -> Iterator[tuple[str, dict[str, Any]]]:
    for state in _small_states(str(dataset.attrs.get("model", ""))):
        reached = _greatest(dataset, state.name)
        if reached is not None:
            count = int((reached > state.small).sum())
            facts = {"small": state.small, "units": state.unit, "points": count}
            yield state.name, {**facts, "of": reached.size}


def _small_states(model: str) -> list[State]:
    """The states that a model takes as small; none of a model that is not here."""
    try:
        known = get_model(model)
    except KeyError:
        return []
    return [state for state in known.states(known.default_options()) if isfinite(state.small)]


def _greatest(dataset: xr.Dataset, name: str) -> xr.DataArray | None:
    """The greatest distance of a state from 0 at each point; None where no motion tells it."""
    ends = [one for one in (f"{name}_min", f"{name}_max", name) if one in dataset.data_vars]
    if not ends:
        return None
    own = [dim for dim in dataset[ends[0]].dims if dim not in dataset["status"].dims]
    sizes: list[xr.DataArray] = [abs(dataset[one]).max(own) for one in ends]
    return xr.concat(sizes, "end").max("end")
