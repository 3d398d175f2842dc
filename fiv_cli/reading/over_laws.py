"""What of a result is the friction law's doing: how answers differ along the axis ``friction``."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from fiv_cli.analyses.variables import Role
from fiv_cli.flags import NOT_COMPUTED
from fiv_cli.friction import all_laws
from fiv_cli.reading import select
from fiv_cli.reading.claims import point_name
from fiv_cli.reading.datasets import flag_names, numbers, variables_in
from fiv_cli.reading.shares import drawn_of, family_of

if TYPE_CHECKING:
    import xarray as xr

LAWS = "friction"
HEADING = (
    "  over the laws, at the points known under every one (spread: greatest less least over the "
    "laws, of the largest magnitude among them):"
)
OPEN = (NOT_COMPUTED, "undecided")  # no class
OF_STICK = ("stick_fraction", "slip_fraction")  # say nothing of a law that never sticks
WITHOUT_RANDOM = "    random starts are others under each law, and are left out"
NAMED = 4  # stretches of a grid that are named
ROUNDING = 1e-12  # relative; numbers that differ by no more are one
ALIKE = (
    "    no number differs by more than rounding: at these parameters the laws may be one (as "
    "coulomb and stribeck where mu_s = mu_k)"
)


def spread(dataset: xr.Dataset) -> dict[str, Any]:
    """How far each answer depends on the law; {} where the law is no dim of its own.

    Returns
    -------
    variable -> of a class: at how many ``points`` it is known under every law, at how many of
    these it is the ``same``, where it ``differs``, and law -> ``counts`` of the classes there, and
    at how many of them it stands ``alone`` against all others, which agree; of a number: at how
    many ``points`` it is known under every law, the ``median`` and ``greatest`` spread there
    (greatest less least over the laws, relative to the largest magnitude among them), where the
    greatest lies (``at``), and law -> at how many points it gives the ``lowest`` and the
    ``highest``. Of several crossings the first is meant, where it is of one direction under every
    law. Numbers that differ nowhere are left out;
    of shares of stick and slip the laws ``without`` stick are. Random starts are others under each
    law, and are left out: facts have ``random_starts`` where there are any.
    """
    if LAWS not in dataset["status"].dims or dataset.sizes[LAWS] < 2:
        return {}
    random: dict[str, Any] = {}
    if "initial" in dataset["status"].dims:
        same = ~np.isin([family_of(one) for one in dataset["initial"].values], drawn_of(dataset))
        dataset = dataset.isel(initial=np.flatnonzero(same))
        random = {} if same.all() else {"random_starts": "left out"}
    if not dataset["status"].size:
        return {}
    grid = dataset["status"].dims
    asked = [v.name for v in variables_in(dataset, Role.CLASS, Role.ANSWER, Role.SHARE)]
    counts = {str(sizes.name) for sizes in select.ragged_dims(dataset).values()}
    held = [dataset[name] for name in asked if name in dataset.keys() - counts]
    first = [_first(one, dataset) if "crossing" in one.dims else one for one in held]
    told = {str(variable.name): _told(variable) for variable in first if variable.dims == grid}
    return {
        name: facts | random
        for name, facts in told.items()
        if facts["points"] and facts.get("greatest", 1.0) > ROUNDING
    }


def _first(variable: xr.DataArray, dataset: xr.Dataset) -> xr.DataArray:
    """Of the first crossing; a number where all laws have one in the same direction."""
    first, directions = variable.isel(crossing=0), dataset.get("crossing_direction")
    if flag_names(variable.attrs) or directions is None:
        return first
    return first.where(_agrees(directions.isel(crossing=0)))


def _told(variable: xr.DataArray) -> dict[str, Any]:
    if flag_names(variable.attrs):
        return _of_class(variable)
    known, laws = all_laws(), variable[LAWS].values.tolist()
    smooth = [law for law in laws if law in known and known[law].capacity is None]
    if variable.name not in OF_STICK or not smooth:
        return _of_number(variable)
    rest = variable.drop_sel({LAWS: smooth})
    return (_of_number(rest) if rest.sizes[LAWS] > 1 else {"points": 0}) | {"without": smooth}


def _of_class(variable: xr.DataArray) -> dict[str, Any]:
    names = flag_names(variable.attrs)
    unknown = [code for code, name in names.items() if name in OPEN]
    known = (~variable.isin(unknown)).all(LAWS)
    facts: dict[str, Any] = {"points": int(known.sum())}
    differs = known & ~_agrees(variable)
    facts |= {"same": facts["points"] - int(differs.sum()), "differs": [*stretches(differs)]}
    facts |= {"counts": {}, "alone": {}}
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
    relative = (high - low) / scale.where(scale > 0.0, 1.0)
    known = relative.values[np.isfinite(relative.values)]
    if not known.size:
        return {"points": 0}
    middle, worst = float(np.median(known)), float(known.max())
    place = point_name(relative, int(np.nanargmax(relative.values)))
    facts = {"points": int(known.size), "median": middle, "greatest": worst, "at": place}
    return facts | {
        name: {
            law: int((values.sel({LAWS: law}) == end).where(high > low, False).sum())
            for law in values[LAWS].values.tolist()
        }
        for name, end in {"lowest": low, "highest": high}.items()
    }


def stretches(marked: xr.DataArray) -> Iterator[str]:
    """Names of the marked points; neighbours along the longest axis of numbers are one."""
    axes = [c for c in marked.coords.values() if c.ndim == 1 and select.is_numeric(c)]
    if not axes:
        yield from (point_name(marked, row) for row in np.flatnonzero(marked.values).tolist())
        return
    axis = max(axes, key=lambda axis: axis.size)
    along = marked.transpose(..., axis.dims[0])
    edges = np.diff(along.values.reshape(-1, axis.size), prepend=False, append=False)
    ends = np.argwhere(edges).reshape(-1, 2, 2).tolist()  # (row, begin) and (row, one behind)
    for (row, begin), (_, end) in ends:
        last = f" to {_last(along, axis, end - 1)}" if end - begin > 1 else ""
        yield point_name(along, row * axis.size + begin) + last


def _last(along: xr.DataArray, axis: xr.DataArray, place: int) -> str:
    """A value of an axis; of axes that advance as one, which share its dim, those of all."""
    if sum(coord.dims == axis.dims for coord in along.coords.values()) == 1:
        return f"{axis.values[place]:g}"
    return point_name(along.isel(dict.fromkeys(along.dims[:-1], 0)), place)


def lines(spreads: Mapping[str, Mapping[str, Any]]) -> list[str]:
    """The same for people."""
    alike = all(facts.get("same") == facts["points"] for facts in spreads.values())
    told = [line for name, facts in spreads.items() for line in _lines(name, facts)]
    random = any("random_starts" in facts for facts in spreads.values())
    return [HEADING, *[WITHOUT_RANDOM] * random, *told, *[ALIKE] * alike] if spreads else []


def _lines(name: str, facts: Mapping[str, Any]) -> Iterator[str]:
    """A line for a number; of a class, one more for each law."""
    if "same" not in facts:
        spread = f"spread {facts['median']:.3g} (median), {facts['greatest']:.3g} at most"
        spread += f" ({facts['at']})" * bool(facts["at"])
        ends = ", ".join(f"{end} under {_most(facts[end])}" for end in ("lowest", "highest"))
        without = ", ".join(facts.get("without", ()))
        left = f"; not of {without}, without stick" * bool(without)
        yield f"    {name:<20} {spread}, at {facts['points']} points; most often {ends}{left}"
        return
    agreed = f"the same at {facts['same']} of {facts['points']} points known under every law"
    named, more = facts["differs"][:NAMED], len(facts["differs"]) - NAMED
    elsewhere = f"; not at {'; '.join(named)}" + f"; and {more} more" * (more > 0)
    yield f"    {name:<20} {agreed}{elsewhere * any(named)}"
    for law, counts in facts["counts"].items():
        classes = ", ".join(f"{one} {count}" for one, count in counts.items())
        alone = f"; alone at {facts['alone'][law]}" if facts["alone"][law] else ""
        yield f"      {law:<18} {classes}{alone}"


def _most(counts: Mapping[str, int]) -> str:
    """The law, or those laws, of the greatest count."""
    most = max(counts.values())
    return f"{' and '.join(law for law, count in counts.items() if count == most)} ({most})"
