"""What was found at each point, where there are few: a row for each answer that a point has.

Likewise of branches of cycles: a row for each change of one, and each end.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping, Sequence
from math import inf
from typing import TYPE_CHECKING, Any

import numpy as np

from fiv_cli.analyses.catalogue import named
from fiv_cli.analyses.variables import Role
from fiv_cli.flags import NOT_COMPUTED
from fiv_cli.notation.amounts import told_apart, with_error
from fiv_cli.notation.tables import plain_table
from fiv_cli.reading import select
from fiv_cli.reading.datasets import error_of, flag_names, numbers, standard_error_of

if TYPE_CHECKING:
    import xarray as xr

# Points that are told one by one. Of more, the first where a point may have several answers: their
# range says little; else none.
MOST_POINTS = 24
SEVERAL = "crossing"

# What is told of a change, or an end, of a branch; of more than some, the first.
ENDS = "cycle_end"
OF_ENDS = (ENDS, *(f"{ENDS}_{of}" for of in ("error", "kind", "direction", "goes_on")))
OF_GRAZINGS = (f"{ENDS}_event", f"{ENDS}_contact")
MOST_ENDS = 48

Row = dict[str, Any]


def each_point(dataset: xr.Dataset) -> list[Row]:
    """Name -> value of the axes that vary, of the answers and their errors, and how it went."""
    names, points = _answers(dataset), dataset["status"]
    several = any(SEVERAL in dataset[name].dims for name in names)
    if not names or (points.size > MOST_POINTS and not several):
        return []
    kept = dataset[[*names, *({"status", "reason"} & {*dataset})]]
    rows = [row for place in range(min(points.size, MOST_POINTS)) for row in _rows(kept, place)]
    return rows if len(rows) > 1 else []


def _answers(dataset: xr.Dataset) -> list[str]:
    """The classes, what figures show first, and what has an error, which follows it."""
    grid, found = {*dataset["status"].dims}, []
    for name in map(str, dataset.data_vars):
        variable, error = named(name), error_of(name)
        told = variable.role is Role.CLASS or variable.headline or error in dataset
        if told and {*dataset[name].dims} <= {*grid, SEVERAL}:
            found += [name, *(one for one in (error, standard_error_of(name)) if one in dataset)]
    return found


def _rows(dataset: xr.Dataset, place: int) -> Iterator[Row]:
    """The rows of one point: of one that has no answer, the one that says so."""
    points = dataset["status"]
    index = dict(zip(points.dims, np.unravel_index(place, points.shape), strict=True))
    one = dataset.isel(index)
    axes = {name: one[name].item() for name in _varying(dataset)}
    values = {str(name): _told(array) for name, array in one.items()}
    count = max(sum(value is not None for value in told) for told in values.values())
    for number in range(count):
        yield axes | {name: told[min(number, len(told) - 1)] for name, told in values.items()}


def _varying(dataset: xr.Dataset) -> list[str]:
    """The axes of the points that have more values than one."""
    grid = dataset["status"].dims
    axes = dataset.coords.items()
    return [str(n) for n, axis in axes if axis.ndim == 1 and axis.size > 1 and axis.dims[0] in grid]


def branch_ends(dataset: xr.Dataset) -> list[Row]:
    """The same of changes and ends of branches, in their order; [] where no branch was followed."""
    if ENDS in dataset and dataset[ENDS].ndim > 1:  # of joined runs
        dataset = select.contiguous(dataset)
    sizes = select.row_sizes(dataset, ENDS) if ENDS in dataset else None
    if sizes is None:
        return []
    place = np.unravel_index(select.row_of_each(sizes), sizes.shape)
    index = dict(zip(sizes.dims, place, strict=True))
    axes = {name: dataset[name].values[index[dataset[name].dims[0]]] for name in _varying(dataset)}
    known = {name: _told(dataset[name]) for name in (*OF_ENDS, *OF_GRAZINGS) if name in dataset}
    if not any(known.get(OF_GRAZINGS[0], ())):
        known = {name: told for name, told in known.items() if name not in OF_GRAZINGS}
    columns = {name: values.tolist() for name, values in axes.items()} | known
    return [dict(zip(columns, row, strict=True)) for row in zip(*columns.values(), strict=True)]


def _told(array: xr.DataArray) -> list[Any]:
    """Its values; None where there is none."""
    names = flag_names(array.attrs)
    if names:
        classes = [names[code] for code in array.values.ravel().tolist()]
        missing = "" if array.name == "status" else NOT_COMPUTED
        return [None if name == missing else name for name in classes]
    values = numbers(array).values.ravel().tolist()
    return [value if np.isfinite(value) else None for value in values]


def lines(part: Mapping[str, Any], units: Mapping[str, str], points: int) -> list[str]:
    """The same for people, of the part of a summary that one analysis has."""
    rows = part["each_point"]
    if not rows:
        return []
    more = points - MOST_POINTS
    by_chance = [name for name in rows[0] if any(row.get(standard_error_of(name)) for row in rows)]
    meant = [f"± of {', '.join(by_chance)} of what has no period: standard error"] * bool(by_chance)
    return [
        " ".join(["  at each point:", *meant]),
        *_table(rows, part["axes"], units),
        *[f"    and {more} more points"] * (more > 0),
    ]


def lines_of_ends(part: Mapping[str, Any], units: Mapping[str, str]) -> list[str]:
    """The same of branches."""
    rows = part.get("branch_ends", ())
    if not rows:
        return []
    more = len(rows) - MOST_ENDS
    head = "  where branches change or end, in their order (direction 1: the parameter rises):"
    return [
        head,
        *_table(rows[:MOST_ENDS], part["axes"], units),
        *[f"    and {more} more"] * (more > 0),
    ]


def _table(rows: Sequence[Row], axes: Collection[str], units: Mapping[str, str]) -> list[str]:
    names = [name for name in rows[0] if not name.endswith("_error") and name != "reason"]
    heads = [f"{name} ({units[name]})" if units.get(name, "1") != "1" else name for name in names]
    columns = [_column(rows, name, name in axes) for name in names]
    table = plain_table(heads, [*zip(*columns, strict=True)])
    return [f"    {line}" for line in table]


def _column(rows: Sequence[Row], name: str, is_axis: bool) -> list[str]:
    values = [row[name] for row in rows]
    if is_axis and all(isinstance(value, float) for value in values):
        return told_apart(values)
    return [_cell(row, name) for row in rows]


def _cell(row: Row, name: str) -> str:
    value, error = row[name], row.get(error_of(name), row.get(standard_error_of(name)))
    if value is None:
        return ""
    if name == "status" and row.get("reason", "none") != "none":
        return f"{value}, {row['reason']}"
    if error is None and error_of(name) in row:
        error = inf
    return with_error(value, error) if isinstance(value, float) else str(value)
