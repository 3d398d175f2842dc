"""Variables of a dataset as a table: a row for each value, with the axes of its point beside it."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from fiv_cli.analyses.catalogue import computed_by
from fiv_cli.case.words import variable_meant
from fiv_cli.errors import UsageError
from fiv_cli.flags import NOT_COMPUTED
from fiv_cli.notation.names import listed, pick, suggest
from fiv_cli.reading import select
from fiv_cli.reading.datasets import (
    analysis_of,
    class_names,
    error_of,
    flag_names,
    standard_error_of,
)

if TYPE_CHECKING:
    import xarray as xr


EVERYTHING = ("all", "everything", "*")


def as_csv(analyses: Mapping[str, xr.Dataset], names: Sequence[str], at: Mapping[str, Any]) -> str:
    """The rows in which one of the variables has a value; classes in words, numbers with errors.

    Beside values of any number at a point stand, in each row, those that a point has one of; points
    without any of the former come last.

    Parameters
    ----------
    analyses : by name; one of them has all the variables
    names : ``VARIABLE[VALUE]`` is a column of its values at one value of its own axis, of a state
        or a contact, ``VARIABLE[*]`` a column for each
    at : which points: axis -> value, label or condition; or variable -> class

    Raises
    ------
    UsageError : no analysis has all the variables, or several have, or they share no rows; there is
        no such axis or value.
    """
    dataset, told = _asked(analyses, names)
    axes = [str(name) for name, axis in dataset.coords.items() if axis.ndim == 1]
    axes = [name for name in axes if name not in select.ragged_dims(dataset)]
    held, alone = _rows(dataset, told, at)
    told_by_axes = {dataset[name].dims[0] for name in axes} | {*select.ragged_dims(dataset)}
    counted = [str(dim) for dim in held[0].dims if dim not in told_by_axes]
    columns = [*dict.fromkeys([*axes, *counted, *told])]
    return _lines(held, columns, told) + _lines(alone, columns, told, header=False)


def without_row(
    analyses: Mapping[str, xr.Dataset], names: Sequence[str], at: Mapping[str, Any]
) -> str:
    """How many of the points have no row in `as_csv`, with their reasons; "" where all have one.

    Nor is it told where classes are chosen; of variables with any number of values at a point it is
    where there is none at all.
    """
    from xarray import ones_like

    dataset, told = _asked(analyses, names)
    if {*at} & {*dataset.data_vars}:
        return ""
    part = select.subset(dataset, at, nearest=False)
    points, sizes = part["status"], [select.row_sizes(part, name) for name in told]
    ragged = [one for one in sizes if one is not None]
    if ragged:
        empty = not any(bool((one > 0).any()) for one in ragged)
        of = part.get("attractor", part.get("reason", points))
        classes = ", ".join(dict.fromkeys(class_names(of).ravel().tolist()))
        return f"no values at any of these {points.size} points: {classes}" * empty
    lacking = ones_like(points, bool)
    for name in told:
        has_value = _in_words(part[name]).notnull()
        lacking = lacking & ~has_value.any(
            [dim for dim in has_value.dims if dim not in points.dims]
        )
    lacking = lacking.transpose(*points.dims)
    counts = Counter(class_names(part.get("reason", points))[lacking.values.ravel()].tolist())
    why = ", ".join(f"{name} {count}" for name, count in counts.most_common() if name != "none")
    why = why and f": {why} (fiv show without --csv says what it means)"
    return f"{counts.total()} of {points.size} points without a row{why}" if counts else ""


def _asked(
    analyses: Mapping[str, xr.Dataset], names: Sequence[str]
) -> tuple[xr.Dataset, list[str]]:
    """What has the variables, with columns of parts of them; the columns, with errors."""
    if {*names} & {*EVERYTHING}:
        raise UsageError(f"a table has the same number of values of each\n{_every_table(analyses)}")
    beside = {str(name) for one in analyses.values() for name in one.coords}
    names = [name for name in names if name not in beside] or list(names)
    parts = [name.removesuffix("]").partition("[") for name in names]
    held_by = _holding(analyses, [name for name, _, _ in parts])
    columns_of = [_columns(held_by, name, wanted) for name, _, wanted in parts]
    names = [name for columns in columns_of for name in columns]
    dataset = held_by.assign({name: of for columns in columns_of for name, of in columns.items()})
    told = [one for name in names for one in (name, *_errors_of(held_by, name))]
    return dataset, list(dict.fromkeys(told))


def _errors_of(dataset: xr.Dataset, name: str) -> list[str]:
    """What says how far a variable may be off, by chance where that is known of some value."""
    by_chance = dataset.get(standard_error_of(name))
    is_known = by_chance is not None and bool(by_chance.notnull().any())
    return [error_of(name)] * (error_of(name) in dataset) + [standard_error_of(name)] * is_known


def _columns(dataset: xr.Dataset, name: str, wanted: str) -> dict[str, xr.DataArray]:
    """A variable or, at the values that are `wanted` of its own axis, what has one per point."""
    values = dataset[name]
    if not wanted:
        return {name: values}
    own = [str(dim) for dim in values.dims if dim not in dataset["status"].dims]
    own = [dim for dim in own if select.axis_of(dataset, dim).dtype.kind != "f"]  # nor over time
    if len(own) != 1 or select.row_sizes(dataset, name) is not None:
        told = f"it has values along: {', '.join(map(str, values.dims)) or 'nothing'}"
        raise UsageError(
            f"{name}[{wanted}]: no variable with one axis of its own that is "
            f"counted or named\n{told}\nnext: --csv {name}, a row for each value"
        )
    axis = select.axis_of(dataset, own[0])
    kept = (
        np.full(axis.size, True) if wanted == "*" else select.matching(axis, wanted, nearest=False)
    )
    bare = values.drop_vars([one for one in values.coords if own[0] in values[one].dims])
    return {f"{name}[{axis.values[at]}]": bare.isel({own[0]: at}) for at in np.flatnonzero(kept)}


def _every_table(analyses: Mapping[str, xr.Dataset]) -> str:
    """What to type for each table that all variables together need."""
    sets: dict[tuple[str, Any], list[str]] = {}
    for analysis, dataset in analyses.items():
        names = [str(name) for name in dataset.data_vars]
        for name in (n for n in names if n not in map(error_of, names)):
            sets.setdefault((analysis, dataset[name].dims), []).append(name)
    of = {one: f" --analysis {one}" if len(analyses) > 1 else "" for one in analyses}
    tables = [f"--csv {','.join(held)}{of[one]}" for (one, _), held in sets.items()]
    return f"next: a command for each: {'; '.join(tables)}"


def _lines(
    held: Sequence[xr.DataArray], columns: Sequence[str], told: Sequence[str], header: bool = True
) -> str:
    """Rows of variables that share their dims; none without a value."""
    from xarray import merge

    if not held:
        return ""
    frame = merge(held, compat="no_conflicts").to_dataframe().reset_index()
    frame = frame.dropna(subset=[name for name in told if name in frame], how="all")
    columns = [name for name in columns if name in frame or name in told]
    text: str = frame.reindex(columns=columns).to_csv(index=False, header=header)
    return text


def _rows(
    dataset: xr.Dataset, told: Sequence[str], at: Mapping[str, Any]
) -> tuple[list[xr.DataArray], list[xr.DataArray]]:
    """Variables over the points chosen, or over the values of any number that one of them holds.

    Beside the latter what is told of points that hold no such value.
    """
    ragged = {n: rows for n in told if (rows := select.row_sizes(dataset, n)) is not None}
    results = {n: at[n] for n in at if n in dataset.data_vars and flag_names(dataset[n].attrs)}
    at = {name: wanted for name, wanted in at.items() if name not in results}
    chosen = [select.having(dataset[name], wanted) for name, wanted in results.items()]
    in_words = dataset.assign({name: _in_words(dataset[name]) for name in told})
    points = [name for name in told if name not in ragged]
    for mask in chosen:
        in_words = in_words.assign({name: in_words[name].where(mask) for name in points})
    if not ragged:
        part = select.subset(in_words, at, nearest=False)
        return [part[name] for name in points], []
    first = next(iter(ragged.values()))
    if any(rows.name != first.name for rows in ragged.values()) or any(
        not {*dataset[name].dims} <= {*first.dims} for name in [*points, *results]
    ):
        raise UsageError(_in_rows_of_their_own(dataset, ragged, points, first))
    masks = {f"is {name}": mask for name, mask in zip(results, chosen, strict=True)}
    with_points = in_words.set_coords(points).assign_coords(masks)
    without = select.subset(in_words[points].where(first == 0), at, nearest=False)
    held = [select.observations(with_points, name, at) for name in ragged]
    for has in masks:
        held = [values[values[has].values.astype(bool)] for values in held]
    return held, [without[name] for name in points]


def _in_rows_of_their_own(
    dataset: xr.Dataset,
    ragged: Mapping[str, xr.DataArray],
    points: Sequence[str],
    first: xr.DataArray,
) -> str:
    """Which variables share their rows, where not all do."""
    sets: dict[str, list[str]] = {}
    for name, rows in ragged.items():
        sets.setdefault(str(rows.name), []).append(name)
    for name in points:
        fits = {*dataset[name].dims} <= {*first.dims}
        sets.setdefault(str(first.name) if fits else str(dataset[name].dims), []).append(name)
    tables = [f"--csv {','.join(names)}" for names in sets.values()]
    message = "not all of these have the same number of values at a point"
    return f"{message}\nnext: a command for each: {'; '.join(tables)}"


def _without_error(name: str, dataset: xr.Dataset) -> str:
    """What tells of a number how far it may be off, where the dataset has it and no error of it."""
    of = name.removesuffix("_error")
    if of == name or name in dataset or of not in dataset:
        return ""
    told = "what points tell of their trust stands last in `fiv show`"
    again = "the same run with --set solver.rtol=1e-10 -o B.nc, then fiv diff"
    return f"no error of {of!r} is computed; {told}\nnext: to see how far it moves, {again}"


def _holding(analyses: Mapping[str, xr.Dataset], names: Sequence[str]) -> xr.Dataset:
    """The analysis with all the variables."""
    having = [one for one, held in analyses.items() if all(n in held.data_vars for n in names)]
    if len(having) > 1:
        which = " or ".join(f"--analysis {name}" for name in having)
        raise UsageError(f"{', '.join(names)}: of several analyses\nnext: {which}")
    if having:
        return analyses[having[0]]
    known = {str(name): None for one in analyses.values() for name in one.data_vars}
    for name in names:
        if told := next(filter(None, (_without_error(name, one) for one in analyses.values())), ""):
            raise UsageError(told)
        others = {*names} & {*known}  # what stands beside these is rather meant
        beside = [one for held in analyses.values() if others & {*held} for one in map(str, held)]
        tried = (
            word(name, some) for some in (beside, [*known]) for word in (variable_meant, suggest)
        )
        had = [str(analysis_of(one, of).get("kind")) for of, one in analyses.items()]
        given = computed_by(name, had=had)
        hints = [] if name in known else [next(filter(None, tried), ""), given]
        if hint := "; ".join(filter(None, hints)):
            raise UsageError(f"there is no variable {name!r}; {hint}")
        pick(name, known, "variable", "fiv show FILE.nc")
    raise UsageError(
        f"{', '.join(names)}: no analysis has all of these: {_of_analyses(analyses, names)}\n"
        "next: a command for each"
    )


def _of_analyses(analyses: Mapping[str, xr.Dataset], names: Sequence[str]) -> str:
    """Which of some variables each analysis has: ``L_s in response; stable in eigenvalues``."""
    own = {of: [n for n in names if n in one.data_vars] for of, one in analyses.items()}
    return "; ".join(f"{listed(held)} in {of}" for of, held in own.items() if held)


def _in_words(values: xr.DataArray) -> xr.DataArray:
    """Classes by their names; what was not computed has no value, like NaN."""
    if not flag_names(values.attrs):
        return values
    words = class_names(values)
    words[words == NOT_COMPUTED] = None
    return values.copy(data=words.reshape(values.shape))
