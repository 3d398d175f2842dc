"""What of a result is the friction law's doing: how answers differ along the axis ``friction``."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from fiv_cli.analyses.variables import Role
from fiv_cli.flags import NOT_COMPUTED
from fiv_cli.reading import select
from fiv_cli.reading.datasets import flag_names, numbers, variables_in

if TYPE_CHECKING:
    import xarray as xr

LAWS = "friction"
HEADING = (
    "  over the laws, at the points known under every one (spread: greatest less least over the "
    "laws, of the largest magnitude among them):"
)
OPEN = (NOT_COMPUTED, "undecided")  # no class


def spread(dataset: xr.Dataset) -> dict[str, Any]:
    """How far each answer depends on the law; {} where the law is no dim of its own.

    Returns
    -------
    variable -> of a class: at how many ``points`` it is known under every law, at how many of
    these it is the ``same``, and law -> ``counts`` of the classes there, and at how many of them
    it stands ``alone`` against all others, which agree; of a number: at how many ``points`` it is
    known under every law, the ``median`` and ``greatest`` spread there (greatest less least over
    the laws, relative to the largest magnitude among them), and law -> at how many points it gives
    the ``lowest`` and the ``highest``. Numbers that differ nowhere are left out.
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
    return {
        name: facts for name, facts in told.items() if facts["points"] and facts.get("greatest", 1)
    }


def _of_class(variable: xr.DataArray) -> dict[str, Any]:
    names = flag_names(variable.attrs)
    unknown = [code for code, name in names.items() if name in OPEN]
    known = (~variable.isin(unknown)).all(LAWS)
    facts: dict[str, Any] = {"points": int(known.sum())}
    facts |= {"same": int((known & _agrees(variable)).sum()), "counts": {}, "alone": {}}
    for law in variable[LAWS].values.tolist():
        own, others = variable.sel({LAWS: law}), variable.drop_sel({LAWS: law})
        counts = {name: int((known & (own == code)).sum()) for code, name in names.items()}
        alone = known & _agrees(others) & (own != others.isel({LAWS: 0}))
        facts["counts"][law] = {name: count for name, count in counts.items() if count}
        facts["alone"][law] = int(alone.sum()) if others.sizes[LAWS] > 1 else 0
    return facts


def _agrees(variable: xr.DataArray) -> xr.DataArray:
    """Where a class is the same under all laws."""
    return variable.min(LAWS) == variable.max(LAWS)


def _of_number(variable: xr.DataArray) -> dict[str, Any]:
    values = numbers(variable)
    low, high = values.min(LAWS, skipna=False), values.max(LAWS, skipna=False)
    scale = abs(values).max(LAWS)
    relative = ((high - low) / scale.where(scale > 0.0, 1.0)).values.ravel()
    known = relative[np.isfinite(relative)]
    if not known.size:
        return {"points": 0}
    middle, worst = float(np.median(known)), float(known.max())
    facts = {"points": int(known.size), "median": middle, "greatest": worst}
    return facts | {
        name: {
            law: int((values.sel({LAWS: law}) == end).where(high > low, False).sum())
            for law in values[LAWS].values.tolist()
        }
        for name, end in {"lowest": low, "highest": high}.items()
    }


def lines(spreads: Mapping[str, Mapping[str, Any]]) -> list[str]:
    """The same for people."""
    return [HEADING] * bool(spreads) + [
        line for name, facts in spreads.items() for line in _lines(name, facts)
    ]


def _lines(name: str, facts: Mapping[str, Any]) -> Iterator[str]:
    """A line for a number; of a class, one more for each law."""
    if "same" not in facts:
        spread = f"spread {facts['median']:.3g} (median), {facts['greatest']:.3g} at most"
        ends = ", ".join(f"{end} under {_most(facts[end])}" for end in ("lowest", "highest"))
        yield f"    {name:<20} {spread}, at {facts['points']} points; most often {ends}"
        return
    agreed = f"the same at {facts['same']} of {facts['points']} points known under every law"
    yield f"    {name:<20} {agreed}"
    for law, counts in facts["counts"].items():
        classes = ", ".join(f"{one} {count}" for one, count in counts.items())
        alone = f"; alone at {facts['alone'][law]}" if facts["alone"][law] else ""
        yield f"      {law:<18} {classes}{alone}"


def _most(counts: Mapping[str, int]) -> str:
    """The law, or those laws, of the greatest count."""
    most = max(counts.values())
    return f"{' and '.join(law for law, count in counts.items() if count == most)} ({most})"
