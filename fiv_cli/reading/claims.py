"""What a publication says, held against a dataset: confirmed, contradicted or undetermined.

A claim selects points, and each point is a *hit*, a *miss* or *open*. Open is what the dataset
cannot answer: a point that was not computed, or one whose class is undecided; of a share that is
an interval, one whose two ends say different things. The verdict needs a number of hits (all of
the points, one, or a share): it is confirmed when the hits suffice even if every open point were a
miss, contradicted when they would not suffice even if every open point were a hit, and undetermined
in between. Open points that are no more than `HANDFUL` of them all leave the verdict to the rest;
the finding counts them.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from fiv_cli.reading import select
from fiv_cli.reading.datasets import flag_names, name_of_only, numbers
from fiv_cli.reading.known import unknown_points
from fiv_cli.reading.reductions import reduced
from fiv_cli.reading.shares import HIGH, LOW, SHARE, with_share

if TYPE_CHECKING:
    import xarray as xr

    from fiv_cli.case.case import ClaimSpec

    Analyses = Mapping[str, xr.Dataset]

CONFIRMED, CONTRADICTED, UNDETERMINED = "confirmed", "contradicted", "undetermined"

# Share of the points that may be open without leaving a claim undetermined that the rest decides.
HANDFUL = 0.005

# Counterexamples that a finding names; the rest is counted.
NAMED_MISSES = 3


@dataclass(frozen=True)
class Verdict:
    """What came of one claim.

    Attributes
    ----------
    verdict : "confirmed", "contradicted" or "undetermined"
    found : one line, what the dataset holds
    hits, points, open : counts of what the claim was tried on (points of the grid, values of a
        ragged variable, or steps between neighbours)
    """

    verdict: str
    found: str
    hits: int = 0
    points: int = 0
    open: int = 0


@dataclass(frozen=True)
class _Trial:
    """One claim tried on every point.

    Attributes
    ----------
    hit, open : masks, shape (n,); never both
    found : what the dataset holds, in words
    row : where each of the n lies, shape (n,); several may lie at the same place
    place : row -> its name
    noun : what is counted
    """

    hit: np.ndarray
    open: np.ndarray
    found: str
    row: np.ndarray
    place: Callable[[int], str]
    noun: str = "points"


@dataclass(frozen=True)
class _Values:
    """The values a claim is about, flat, with where they come from.

    Attributes
    ----------
    values : shape (n,)
    low, high : ends of the interval that holds the value; equal where it is known, shape (n,)
    open : the value is not known, shape (n,)
    row : flat index of the grid point (and start) of each value, shape (n,)
    rows : array over the grid (and start) that `row` counts in C order
    """

    values: np.ndarray
    open: np.ndarray
    row: np.ndarray
    rows: xr.DataArray
    low: np.ndarray
    high: np.ndarray


def evaluate(
    claim: ClaimSpec, analyses: Analyses, other: Callable[[str], Analyses | None]
) -> Verdict:
    """Hold `claim` against the analyses of its case's dataset.

    Parameters
    ----------
    claim : what is claimed
    analyses : name of the analysis -> dataset
    other : name of another case -> its analyses, None where it has not been run

    Returns
    -------
    Verdict : never raises for what the dataset lacks; that is undetermined, and says why
    """
    try:
        dataset = _dataset_of(claim.variable, claim.analysis, analyses)
        if claim.share:
            dataset, claim = _counted(dataset, claim)
        part = select.subset(dataset, claim.at, nearest=False)
        part = reduced(part, claim.variable, claim.reduce) if claim.reduce else part
        trial = _try(claim, part, other)
    except select.SelectionError as error:
        return Verdict(UNDETERMINED, str(error).replace("\n", "; "))
    return _judge(trial, claim.holds)


def _counted(dataset: xr.Dataset, claim: ClaimSpec) -> tuple[xr.Dataset, ClaimSpec]:
    """The dataset as the share that the claim is about, and the claim about it.

    What `at` says of axes that are counted along says what is counted; the rest selects shares.
    """
    over = {name.replace(".", "_") for name in claim.share["over"]}
    counted = {name: at for name, at in claim.at.items() if name.replace(".", "_") in over}
    chosen = {name: at for name, at in claim.at.items() if name not in counted}
    part = select.subset(dataset, counted, nearest=False)
    part = with_share(part, claim.variable, claim.share)
    return part, replace(claim, variable=SHARE, at=chosen)


def _dataset_of(variable: str, analysis: str, analyses: Analyses) -> xr.Dataset:
    if list(analyses) == [""] and analysis == name_of_only(analyses[""]):
        analysis = ""  # a file of one analysis does not say its name
    if analysis and analysis not in analyses:
        raise select.SelectionError(f"{analysis}: no analysis of the dataset")
    candidates = [analyses[analysis]] if analysis else list(analyses.values())
    for dataset in candidates:
        if variable in dataset.variables:
            return dataset
    raise select.SelectionError(f"{variable}: no variable of the dataset")


def _judge(trial: _Trial, holds: str | float) -> Verdict:
    """From hits, misses and open points to a verdict."""
    points, hits, unknown = trial.hit.size, int(trial.hit.sum()), int(trial.open.sum())
    if points == 0:
        return Verdict(UNDETERMINED, "nothing to try it on")
    handful = unknown <= HANDFUL * points
    needed = _needed(holds, points - unknown if handful else points)
    verdict = UNDETERMINED
    if hits >= needed:
        verdict = CONFIRMED
    elif handful or hits + unknown < needed:
        verdict = CONTRADICTED
    return Verdict(verdict, _finding(trial, hits, points, unknown), hits, points, unknown)


def _needed(holds: str | float, points: int) -> int:
    """Hits that confirm a claim on so many points."""
    if holds == "all":
        return points
    if holds == "any":
        return 1
    # 0.9 of 10 is 9 points, not 9.000000000000002
    return math.ceil(round(float(holds) * points, 9))


def _finding(trial: _Trial, hits: int, points: int, unknown: int) -> str:
    parts = [f"{hits} of {points} {trial.noun}", trial.found]
    if unknown:
        parts.append(f"{unknown} not decided or not computed")
    parts.append(_where_missed(trial))
    return ", ".join(part for part in parts if part)


def _where_missed(trial: _Trial) -> str:
    """The first places that were missed by name, the rest by number."""
    missed = np.unique(trial.row[~trial.hit & ~trial.open])
    named = "; ".join(filter(None, (trial.place(int(row)) for row in missed[:NAMED_MISSES])))
    rest = missed.size - NAMED_MISSES
    return f"not at {named}" + (f" and {rest} more" if rest > 0 else "") if named else ""


def _try(claim: ClaimSpec, part: xr.Dataset, other: Callable[[str], Analyses | None]) -> _Trial:
    expect = claim.expect
    if expect in ("increasing", "decreasing"):
        return _try_monotonic(claim.variable, expect, part)
    if isinstance(expect, Mapping):
        return _try_table(claim, expect, part, other)
    return _try_class(claim.variable, expect, part)


def _try_table(
    claim: ClaimSpec,
    expect: Mapping[str, Any],
    part: xr.Dataset,
    other: Callable[[str], Analyses | None],
) -> _Trial:
    if "interval" in expect:
        return _try_interval(claim.variable, expect, part)
    if "less_than" in expect:
        return _try_less_than(claim, expect["less_than"], part, other)
    return _try_value(claim.variable, expect, part)


def _try_class(variable: str, expect: str, part: xr.Dataset) -> _Trial:
    """A class name, or ``not CLASS``."""
    negated, name = _split_negation(expect)
    found = _values(part, variable, allow_undecided=name == "undecided")
    classes = flag_names(part[variable].attrs)
    hit = (found.values == _code_of(name, variable, classes)) != negated
    return _trial(found, hit, _count_classes(found, classes))


def _code_of(name: str, variable: str, classes: Mapping[int, str]) -> int:
    for code, meaning in classes.items():
        if meaning == name:
            return code
    allowed = ", ".join(classes.values()) or "none: it is no flag"
    raise select.SelectionError(f"{name}: no class of {variable} ({allowed})")


def _split_negation(expect: str) -> tuple[bool, str]:
    return expect.startswith("not "), expect.removeprefix("not ").strip()


def _count_classes(found: _Values, classes: Mapping[int, str]) -> str:
    counts = Counter(found.values[~found.open].tolist())
    named = [f"{classes.get(code, code)} {count}" for code, count in counts.most_common()]
    return "found " + ", ".join(named) if named else ""


def _try_value(variable: str, expect: Mapping[str, Any], part: xr.Dataset) -> _Trial:
    """``{ value, tolerance }``: each value lies within the (absolute) tolerance."""
    found = _values(part, variable)
    value, tolerance = float(expect["value"]), float(expect["tolerance"])
    least, greatest = value - tolerance, value + tolerance
    hit = (found.low >= least) & (found.high <= greatest)
    missed = (found.high < least) | (found.low > greatest) | np.isnan(found.values)
    return _trial(found, hit, _range(found, part[variable]), ~hit & ~missed)


def _range(found: _Values, variable: xr.DataArray) -> str:
    """The values found, from least to greatest, with their unit."""
    known = ~found.open & ~np.isnan(found.values)
    unit = str(variable.attrs.get("units", "1"))
    unit = "" if unit == "1" else f" {unit}"
    if not known.any():
        return "no value found"
    low, high = found.low[known].min(), found.high[known].max()
    span = f"{low:.6g}" if low == high else f"{low:.6g} to {high:.6g}"
    return f"found {span}{unit}"


def _try_interval(variable: str, expect: Mapping[str, Any], part: xr.Dataset) -> _Trial:
    """``{ interval = [a, b], tolerance }``: what is found reaches from a to b, and no further.

    With ``of = CLASS`` (or ``"not CLASS"``) it is about the values of the one axis that is left
    at which `variable` has that class; without, about the values of `variable` themselves.
    """
    undecided = "undecided" in str(expect.get("of"))
    found = _values(part, variable, allow_undecided=undecided)
    if "of" in expect:
        found = _axis_values_where(found, str(expect["of"]), variable, part)
    wide = found.low < found.high
    values = np.where(wide, np.nan, found.values)
    found = _exact(values, found.open | wide, found.row, found.rows)
    low, high = (float(bound) for bound in expect["interval"])
    tolerance = float(expect["tolerance"])
    ends = (
        _end(low - found.values, found.open, tolerance),
        _end(found.values - high, found.open, tolerance),
    )
    label = _one_axis(part) if "of" in expect else part[variable]
    return _Trial(
        np.array([end == "hit" for end in ends]),
        np.array([end == "open" for end in ends]),
        _range(found, label),
        np.arange(2),
        lambda end: "",
        "ends",
    )


def _end(excess: np.ndarray, unknown: np.ndarray, tolerance: float) -> str:
    """Whether one end of an interval is a "hit", a "miss" or "open".

    Parameters
    ----------
    excess : how far each value goes beyond the end, shape (n,); NaN: that is not known either
    unknown : the value may be there or not, shape (n,)
    """
    known = np.nanmax(excess[~unknown], initial=-math.inf)
    maybe = excess[unknown]
    may_reach = bool((np.isnan(maybe) | (np.abs(maybe) <= tolerance)).any())
    may_exceed = bool((np.isnan(maybe) | (maybe > tolerance)).any())
    if known > tolerance:
        return "miss"
    if known >= -tolerance:
        return "open" if may_exceed else "hit"
    return "open" if may_reach else "miss"


def _axis_values_where(found: _Values, name: str, variable: str, part: xr.Dataset) -> _Values:
    negated, name = _split_negation(name)
    code = _code_of(name, variable, flag_names(part[variable].attrs))
    axis = _one_axis(part)
    place = np.unravel_index(found.row, found.rows.shape)[found.rows.dims.index(axis.dims[0])]
    values = axis.values[place].astype(float)
    wanted = found.open | ((found.values == code) != negated)
    return _exact(values[wanted], found.open[wanted], found.row[wanted], found.rows)


def _one_axis(part: xr.Dataset) -> xr.DataArray:
    """The single numeric axis along which anything is left to vary."""
    axes = [select.axis_of(part, str(name)) for name in part.coords if part.coords[name].ndim == 1]
    left = {
        str(axis.dims[0]): axis
        for axis in axes
        if axis.size > 1 and select.is_numeric(axis) and str(axis.dims[0]) in _grid_dims(part)
    }
    if len(left) != 1:
        names = ", ".join(left) or "none"
        raise select.SelectionError(
            f"one numeric axis must be left to vary, found: {names}; narrow it with `at`"
        )
    return next(iter(left.values()))


def _try_monotonic(variable: str, expect: str, part: xr.Dataset) -> _Trial:
    """Each step along the one axis left goes the right way; labels are lines of their own."""
    axis = _one_axis(part)
    ends = [_lines_along(part, name, str(axis.dims[0])) for name in _ends_of(part, variable)]
    (low, unknown), (high, _) = ends
    least, greatest, open_ = _steps(low, high, unknown, expect == "increasing")
    open_ |= (least <= 0.0) & (greatest > 0.0)
    known = _Values(
        low.ravel(), unknown.ravel(), np.arange(low.size), part[variable], low.ravel(), high.ravel()
    )
    return _Trial(
        (least > 0.0).ravel() & ~open_.ravel(),
        open_.ravel(),
        _range(known, part[variable]),
        np.arange(least.size),
        lambda step: _step_name(axis, step),
        "steps",
    )


def _lines_along(part: xr.Dataset, variable: str, dim: str) -> tuple[np.ndarray, np.ndarray]:
    """Values and whether they are unknown, shape (lines, points along `dim`)."""
    if dim not in part[variable].dims:
        raise select.SelectionError(f"{variable}: not one value per point along {dim}")
    array = numbers(part[variable]).transpose(..., dim)
    unknown = unknown_points(part, variable, False).broadcast_like(array).transpose(*array.dims)
    shape = (-1, array.sizes[dim])
    return array.values.reshape(shape), unknown.values.reshape(shape)


def _steps(
    low: np.ndarray, high: np.ndarray, unknown: np.ndarray, rising: bool
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Least and greatest steps between neighbours in the sense asked for, and which are open.

    A step is open where an end of it has no value.
    """
    missing = unknown | ~np.isfinite(low)
    below, above = np.where(missing, np.nan, low), np.where(missing, np.nan, high)
    least, greatest = below[:, 1:] - above[:, :-1], above[:, 1:] - below[:, :-1]
    least, greatest = (least, greatest) if rising else (-greatest, -least)
    return least, greatest, missing[:, 1:] | missing[:, :-1]


def _step_name(axis: xr.DataArray, step: int) -> str:
    """A step by its ends; steps are counted line after line."""
    begin = step % (axis.size - 1)
    return f"{axis.name} = {axis.values[begin]:g} to {axis.values[begin + 1]:g}"


def _try_less_than(
    claim: ClaimSpec,
    bound: Any,
    part: xr.Dataset,
    other: Callable[[str], Analyses | None],
) -> _Trial:
    """Each value lies below a number, or below another case's value at the same point."""
    found = _values(part, claim.variable)
    if isinstance(bound, int | float):
        bounds, open_ = np.full(found.values.shape, float(bound)), found.open
    else:
        bounds, missing = _other_values(claim, str(bound), found, other)
        open_ = found.open | missing
    hit = (found.high < bounds) & ~open_
    return _trial(
        replace(found, open=open_),
        hit,
        f"{_range(found, part[claim.variable])}, against {_span(bounds)}",
        ~hit & (found.low < bounds),
    )


def _span(values: np.ndarray) -> str:
    known = values[~np.isnan(values)]
    return f"{known.min():.6g} to {known.max():.6g}" if known.size else "nothing"


def _other_values(
    claim: ClaimSpec, bound: str, found: _Values, other: Callable[[str], Analyses | None]
) -> tuple[np.ndarray, np.ndarray]:
    """Value of ``CASE:variable`` at the point of each value found, and where there is none."""
    case, _, variable = bound.rpartition(":")
    analyses = other(case)
    if analyses is None:
        raise select.SelectionError(f"{case} has not been run")
    dataset = _dataset_of(variable, "", analyses)
    shared = {
        name: wanted
        for name, wanted in claim.at.items()
        if name.replace(".", "_") in select.axis_names(dataset)
    }
    partner = select.subset(dataset, shared, nearest=False)
    array = numbers(partner[variable])
    array = array.where(~unknown_points(partner, variable, False))
    matched = _at_points_of(array, found.rows)
    values = matched.values.ravel()[found.row]
    return values, np.isnan(values)


def _at_points_of(array: xr.DataArray, points: xr.DataArray) -> xr.DataArray:
    """`array` at the coordinates of `points`: NaN where it has no such point."""
    import xarray as xr

    alone = [dim for dim in array.dims if dim not in points.dims]
    if any(array.sizes[dim] > 1 for dim in alone):
        raise select.SelectionError(
            f"{', '.join(map(str, alone))}: an axis of the other case only; narrow it with `at`"
        )
    array = array.isel(dict.fromkeys(alone, 0), drop=True)
    for dim in array.dims:
        array = _reindexed(array, str(dim), select.axis_of(points.to_dataset(name="p"), str(dim)))
    return xr.broadcast(array, points, exclude=[])[0].transpose(*points.dims)


def _reindexed(array: xr.DataArray, dim: str, axis: xr.DataArray) -> xr.DataArray:
    if dim not in array.coords:
        return array
    if array.sizes[dim] == 1 and not select.is_numeric(array.coords[dim]):
        # the one start of the other case stands for whatever start this case has
        return array.isel({dim: 0}, drop=True)
    if not select.is_numeric(axis):
        return array.reindex({dim: axis.values})
    tolerance = select.SAME * float(np.max(np.abs(axis.values)))
    return array.reindex({dim: axis.values}, method="nearest", tolerance=tolerance)


def _trial(
    found: _Values, hit: np.ndarray, text: str, between: np.ndarray | bool = False
) -> _Trial:
    """A trial; `between`: where the two ends of an interval say different things."""
    return _Trial(
        hit & ~found.open,
        found.open | between,
        text,
        found.row,
        lambda row: point_name(found.rows, row),
    )


def point_name(points: xr.DataArray, row: int) -> str:
    """Where the flat (C order) index `row` lies on the axes of `points` that vary."""
    place = np.unravel_index(row, points.shape) if points.ndim else ()
    return ", ".join(
        f"{name} = {_shown(coord.values[index])}"
        for dim, index in zip(points.dims, place, strict=True)
        if points.sizes[dim] > 1
        for name, coord in points.coords.items()
        if coord.dims == (dim,)
    )


def _shown(value: Any) -> str:
    return f"{value:g}" if isinstance(value, float | np.floating) else str(value)


def _values(part: xr.Dataset, variable: str, allow_undecided: bool = False) -> _Values:
    """Every value of `variable` in `part`; padding along its own dims is left out."""
    rows = _rows(part)
    sizes = select.row_sizes(part, variable)
    if sizes is not None:
        return _ragged_values(part, variable, rows, sizes)
    array = numbers(part[variable]).transpose(*rows.dims, ..., missing_dims="ignore")
    own = [dim for dim in array.dims if dim not in rows.dims]
    array = array.broadcast_like(rows).transpose(*rows.dims, *own)
    per_row = math.prod(array.sizes[dim] for dim in own)
    row = np.repeat(np.arange(rows.size), per_row)
    unknown = unknown_points(part, variable, allow_undecided).values.ravel()[row]
    flat = array.values.ravel()
    kept = ~np.isnan(flat) | unknown if own else np.ones(flat.shape, bool)
    if variable == SHARE:
        low, high = (part[name].transpose(*rows.dims).values.ravel() for name in (LOW, HIGH))
        return _Values(flat, unknown, row, rows, low, high)
    return _exact(flat[kept], unknown[kept], row[kept], rows)


def _exact(values: np.ndarray, unknown: np.ndarray, row: np.ndarray, rows: xr.DataArray) -> _Values:
    """Values that are no intervals."""
    return _Values(values, unknown, row, rows, values, values)


def _ends_of(part: xr.Dataset, variable: str) -> tuple[str, str]:
    """The variables that hold the two ends of the interval of a variable."""
    return (LOW, HIGH) if variable == SHARE else (variable, variable)


def _ragged_values(
    part: xr.Dataset, variable: str, rows: xr.DataArray, sizes: xr.DataArray
) -> _Values:
    """Observations of every row; a row that is not known stands as one open value."""
    unknown = unknown_points(part, variable, False).values.ravel()
    row = select.row_of_each(sizes.transpose(*rows.dims))
    known = ~unknown[row]
    open_rows = np.flatnonzero(unknown)
    values = np.concatenate([part[variable].values[known], np.full(open_rows.size, np.nan)])
    unknown = np.arange(values.size) >= known.sum()
    return _exact(values, unknown, np.concatenate([row[known], open_rows]), rows)


def _grid_dims(part: xr.Dataset) -> tuple[str, ...]:
    return tuple(str(dim) for dim in part["status"].dims)


def _rows(part: xr.Dataset) -> xr.DataArray:
    """The points: the grid (and starts), in C order."""
    return part["status"]


def tally(verdicts: list[str]) -> str:
    """``3 confirmed, 1 contradicted`` from a list of verdicts, most decided first."""
    order = (CONFIRMED, CONTRADICTED, UNDETERMINED, "not run")
    counts = Counter(verdicts)
    named = [f"{counts[name]} {name}" for name in order if counts[name]]
    return ", ".join(named) or "no claims"
