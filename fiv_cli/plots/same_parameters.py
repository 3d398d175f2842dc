"""Which part of one dataset is at the parameters that another holds fixed."""

from __future__ import annotations

import json
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from fiv_cli.plots.labels import value_label
from fiv_cli.reading import select

if TYPE_CHECKING:
    import xarray as xr


def of_the_same(dataset: xr.Dataset, diagram: xr.Dataset) -> xr.Dataset | None:
    """The part of a dataset at what a diagram holds fixed; None: it has no such."""
    known, chosen = _axes_and_numbers(dataset), choices(dataset)
    fixed = _numbers_held(diagram, known) | choices(diagram)
    spread = {n: value for n, value in fixed.items() if n in known and known[n].size > 1}
    for name, value in fixed.items():
        if name not in spread and not _agree(chosen.get(name, known.get(name, value)), value):
            return None
    try:
        return select.subset(dataset, spread, nearest=False)
    except select.SelectionError:
        return None


def differing(dataset: xr.Dataset, diagram: xr.Dataset) -> list[str]:
    """In which parameters, laws and options a dataset is of no part of a diagram."""
    known, chosen = _axes_and_numbers(dataset), choices(dataset)
    fixed = _numbers_held(diagram, known) | choices(diagram)
    return [
        name
        for name, value in fixed.items()
        if (name in chosen or name in known)
        and not any(
            _agree(one, value)
            for one in np.ravel(chosen[name] if name in chosen else known[name].values).tolist()
        )
    ]


def _axes_and_numbers(dataset: xr.Dataset) -> dict[str, xr.DataArray]:
    return {str(name): coord for name, coord in dataset.coords.items() if coord.ndim < 2}


def _numbers_held(diagram: xr.Dataset, known: Mapping[str, xr.DataArray]) -> dict[str, Any]:
    """Not what counts results, as section points: of these a dataset may have but one."""
    return {
        name: coord.item()
        for name, coord in _axes_and_numbers(diagram).items()
        if coord.size == 1 and coord.dtype.kind in ("f" if coord.ndim else "fiu") and name in known
    }


def choices(dataset: xr.Dataset) -> dict[str, Any]:
    """Law and options of a dataset, where each is one."""
    told = json.loads(dataset.attrs.get("options_json", "{}"))
    told |= {"friction": dataset.attrs["law"]} if "law" in dataset.attrs else {}
    axes = {name: dataset[name] for name in told if name in dataset.coords}
    return {
        name: axes[name].item() if name in axes else value
        for name, value in told.items()
        if name not in axes or axes[name].size == 1
    }


def held_words(dataset: xr.Dataset, name: str) -> list[str]:
    """The numbers that a dataset has of a parameter, or its law, or an option of its model."""
    chosen = choices(dataset).get("friction" if name == "law" else name)
    if chosen is not None and name not in dataset.coords:
        return [f"{name}: {chosen}"]
    held = dataset.coords.get(name)
    if held is None or held.ndim > 1 or held.dtype.kind not in "fi":
        return []
    return [value_label(held, value) for value in np.ravel(held.values)]


def _agree(one: Any, other: Any) -> bool:
    """Whether two names, or two numbers, are the same."""
    return bool(one == other if isinstance(other, str) else np.isclose(one, other, atol=0.0))
