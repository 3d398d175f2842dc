"""What of a result is the friction law's doing: how answers differ along the axis ``friction``."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from fiv_cli.analyses.variables import Role
from fiv_cli.flags import NOT_COMPUTED
from fiv_cli.reading import select
from fiv_cli.reading.datasets import flag_names, numbers, variables_in

if TYPE_CHECKING:
    import xarray as xr

LAWS = "friction"
OPEN = (NOT_COMPUTED, "undecided")  # no class


def spread(dataset: xr.Dataset) -> dict[str, Any]:
    """How far each answer depends on the law; {} where the law is no dim of its own.

    Returns
    -------
    variable -> of a class: at how many ``points`` it is known under every law, and at how many of
    these it is the ``same``; of a number: at how many ``points`` it is known under every law, and
    its ``median`` and ``greatest`` spread (greatest less least over the laws, relative to the
    largest magnitude among them)
    """
    if LAWS not in dataset["status"].dims or dataset.sizes[LAWS] < 2:
        return {}
    grid = dataset["status"].dims
    asked = [v.name for v in variables_in(dataset, Role.CLASS, Role.ANSWER, Role.SHARE)]
    counts = {str(sizes.name) for sizes in select.ragged_dims(dataset).values()}
    held = [dataset[name] for name in asked if name in dataset.keys() - counts]
    told = {
        str(variable.name): _of_class(variable)
        if flag_names(variable.attrs)
        else _of_number(variable)
        for variable in held
        if variable.dims == grid
    }
    return {name: facts for name, facts in told.items() if facts["points"]}


def _of_class(variable: xr.DataArray) -> dict[str, Any]:
    names = flag_names(variable.attrs)
    unknown = [code for code, name in names.items() if name in OPEN]
    known = (~variable.isin(unknown)).all(LAWS)
    same = known & (variable.min(LAWS) == variable.max(LAWS))
    return {"points": int(known.sum()), "same": int(same.sum())}


def _of_number(variable: xr.DataArray) -> dict[str, Any]:
    values = numbers(variable)
    width = values.max(LAWS, skipna=False) - values.min(LAWS, skipna=False)
    scale = abs(values).max(LAWS)
    relative = (width / scale.where(scale > 0.0, 1.0)).values.ravel()
    known = relative[np.isfinite(relative)]
    if not known.size:
        return {"points": 0}
    middle, worst = float(np.median(known)), float(known.max())
    return {"points": int(known.size), "median": middle, "greatest": worst}


def lines(spreads: Mapping[str, Mapping[str, Any]]) -> list[str]:
    """The same for people, a line each."""
    heading = ["  over the laws, at the points that are known under every one:"] if spreads else []
    return [*heading, *(f"    {name:<20} {_line(facts)}" for name, facts in spreads.items())]


def _line(facts: Mapping[str, Any]) -> str:
    if "same" in facts:
        return f"the same at {facts['same']} of {facts['points']} points"
    return (
        f"differs by {facts['median']:.3g} of itself (median), {facts['greatest']:.3g} at most, "
        f"at {facts['points']} points"
    )
