"""What `take` makes of a variable: one number in place of all that it holds along some axes.

The share of phases and starts from which stick-slip survives is one number at each speed and
preload; the share of a plane of speeds and preloads in which it exists is an area. How often
contact is lost in a stretch of time, the frequency of the strongest line, the last speed at which
a motion is not the equilibrium: all are taken alike, for figures and for claims.

A point without an answer may hold anything: what is taken over such points is an interval, from
the least to the greatest that they allow. Where that says nothing, there is no answer either. What
is taken of values that may be off may be off, too; one of which a condition holds only within its
error is none that is counted for sure.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from typing import Any

import numpy as np
import xarray as xr

from fiv_cli.case.structure import EACH
from fiv_cli.flags import NOT_COMPUTED
from fiv_cli.reading import select
from fiv_cli.reading.datasets import (
    class_names,
    error_of,
    flag_names,
    is_class,
    numbers,
    unknown_points,
)

MOVING = "moving"
SIZE = "of_size"
"""Attribute of a difference: the greatest of what differs, by its size, in the same unit."""


@dataclass(frozen=True)
class _Taking:
    """One way of taking.

    Attributes
    ----------
    take : values (or, counted, 1 where the condition holds, else 0) and the axes -> what is left
    ends : the least and the greatest that a point without an answer may hold; None: one such
        point leaves nothing known
    """

    take: Callable[[xr.DataArray, Sequence[xr.DataArray]], xr.DataArray]
    ends: tuple[float, float] | None = None


def taken_of_each(dataset: xr.Dataset, variable: str, take: Mapping[str, Any]) -> xr.Dataset:
    """`taken` of `EACH` class that some point holds, along a dim of these; of anything else once.

    What is undecided may be of any class, and is of none.
    """
    if take.get("of") != EACH or variable not in dataset:
        return taken(dataset, variable, take)
    classes, codes = flag_names(dataset[variable].attrs), np.unique(dataset[variable].values)
    if not classes:
        raise select.SelectionError(f"{variable}: a number, and no class; of = '. > 0'")
    held = [name for code, name in classes.items() if code in codes]
    names = [name for name in held if name not in (NOT_COMPUTED, "undecided")] or held
    parts = [taken(dataset, variable, take, name) for name in names]
    told: Any = {"compat": "override", "coords": "minimal", "combine_attrs": "override"}
    words = [name.replace("_", " ") for name in names]
    found = xr.concat(parts, "class", **told).assign_coords({"class": words})
    return found.transpose(..., "class")


def taken(
    dataset: xr.Dataset, variable: str, take: Mapping[str, Any], of: str | Sequence[str] = ""
) -> xr.Dataset:
    """What is taken of `variable`, over the axes that are left.

    Parameters
    ----------
    dataset : any dataset with a ``status``
    variable : what it is taken of; one value per place along each axis of ``over``
    take : ``what``, and the axes ``over``; for what is counted ``of``, a condition on numbers
        (``". > 0"``), a class (``"not equilibrium"``) or a list of classes; for a share
        ``relative_to``, axis -> value, the point whose share is one (or nothing)
    of : counted in place of that

    Returns
    -------
    xr.Dataset : the variable called as ``what`` is, its ends ``WHAT_low`` and ``WHAT_high``,
        ``WHAT_error`` of what may be off, and ``status``. Where nothing is known they are NaN, and
        the status is that of some point there. Of a spread and a difference `MOVING` says which of
        what is compared vibrate; a difference has the `SIZE` of what differs

    Raises
    ------
    SelectionError : no such variable, axis, class or reference point; of a difference, one value
    """
    if variable not in dataset:
        raise select.SelectionError(f"{variable}: no variable of the dataset")
    dataset = _looked_at(dataset, take)
    axes = [select.axis_of(dataset, name) for name in take["over"]]
    for axis in axes:
        if axis.dims[0] not in dataset[variable].dims:
            raise select.SelectionError(f"{variable}: not one value per {axis.name}")
    array, what, of = dataset[variable], take["what"], of or take.get("of", "")
    missing = unknown_points(dataset, variable, "undecided" in of)
    blurred = _blurred(dataset, variable, of)
    low, high, unknown = _between(_TAKINGS[what], _values(array, of), missing, blurred, axes)
    ends = {f"{what}_low": low.where(~unknown), f"{what}_high": high.where(~unknown)}
    interval = xr.Dataset({**ends, "status": _status(_answered(dataset), unknown, axes)})
    if take.get("relative_to"):
        interval = _relative(interval, take["relative_to"])
    if what in _MOVED and error_of(variable) in dataset:
        off = dataset[error_of(variable)].fillna(math.inf).where(array.notnull())
        interval[f"{what}_error"] = _moved(what, numbers(array), off, _dims(axes))
    if what in ("difference", "spread") and "attractor" in dataset:
        interval[MOVING] = _moving(dataset["attractor"], axes, what)
    named: dict[str, Any] = {"units": _unit(array, what, axes[0])}
    named |= {"long_name": _words(array, take, axes[0])}
    if what == "difference":
        named[SIZE] = float(np.abs(numbers(array)).max())
    return _with_middle(interval, what, named).assign_attrs(dataset.attrs)


def _looked_at(dataset: xr.Dataset, take: Mapping[str, Any]) -> xr.Dataset:
    """The part of which something is taken: of an axis both its ends, for a difference, or those of
    a list of its values that tells which is less which."""
    if take["what"] != "difference":
        return dataset
    axis = select.axis_of(dataset, take["over"][0])
    if axis.size < 2:
        raise select.SelectionError(f"{axis.name}: one value alone, which differs from no other")
    listed = _places_in(axis, take.get("listed", ()))
    tells = bool(listed) and listed[0] != listed[-1]
    return dataset.isel({str(axis.dims[0]): [listed[0], listed[-1]] if tells else [0, -1]})


def _places_in(axis: xr.DataArray, listed: Sequence[Any]) -> list[int]:
    """Where the entries of a list stand along an axis; none where one of them means several.

    One that parameters which advance with it have left out stands nowhere.
    """
    found = []
    for one in listed:
        for nearest in (False, True):  # as what chose them may have taken the nearest
            with suppress(select.SelectionError):
                found.append(np.flatnonzero(select.matching(axis, one, nearest=nearest)).tolist())
                break
    return [place for (place,) in found] if all(len(own) == 1 for own in found) else []


def in_order(take: Mapping[str, Any], selection: Mapping[str, Any]) -> dict[str, Any]:
    """What is taken, of a list of values of its axis the last less the first of this list."""
    known = {name.replace(".", "_"): wanted for name, wanted in selection.items()}
    listed = known.get(take["over"][0].replace(".", "_"))
    return {**take, "listed": [*listed]} if isinstance(listed, list | tuple) else {**take}


def _moving(attractor: xr.DataArray, axes: Sequence[xr.DataArray], what: str) -> xr.DataArray:
    """Which of two ends vibrate: 0 none, 1 the first, 2 the last, 3 both; of what is spread 0 none,
    1 some, 2 all."""
    moving = ~is_class(attractor, ("equilibrium",))
    dims = [dim for dim in _dims(axes) if dim in moving.dims]
    if what == "spread":
        return moving.any(dims).astype(int) + moving.all(dims)
    return (moving * xr.DataArray([1, 2], dims=dims)).sum(dims) if dims else moving.astype(int)


def _moved(what: str, array: xr.DataArray, off: xr.DataArray, dims: list[str]) -> xr.DataArray:
    """How far what is taken may be off: an extreme, as far as it may lie where it is, or beside."""
    if what not in ("least", "greatest"):
        return _MOVED[what] * off.max(dims)
    extreme = {"least": xr.DataArray.min, "greatest": xr.DataArray.max}[what]
    found = extreme(array, dims)
    below, above = (abs(extreme(array + sign * off, dims) - found) for sign in (-1.0, 1.0))
    return below.where(below > above, above)


def without_value(part: xr.Dataset, variable: str, take: Mapping[str, Any]) -> str:
    """How many decided points have no value, their classes, and how they are taken; "" of none.

    What has axes of its own, such as crossings, has fewer values at some points by its nature.
    """
    part = _looked_at(part, take)
    array, status = numbers(part[variable]), part["status"]
    lacking = array.isnull() & ~unknown_points(part, variable, allow_undecided=False)
    if not set(array.dims) <= set(status.dims) or not lacking.any():
        return ""
    classes = part.get("attractor", status).transpose(*lacking.dims)
    counts = Counter(class_names(classes)[lacking.values.ravel()].tolist())
    listed = ", ".join(f"{name} {count}" for name, count in counts.most_common())
    counted = f'count as not "{take["of"]}"' if take.get("of") else "are left out"
    return f"{counts.total()} without {variable} ({listed}) {counted}"


def told_by_class(
    found: xr.Dataset, part: xr.Dataset, variable: str, take: Mapping[str, Any]
) -> xr.Dataset:
    """What is taken of numbers, whose status is a class of decided points without one where these
    leave nothing, or that they were filled in; of several such classes the last that there are."""
    has_classes = "attractor" in part and {*part[variable].dims} <= {*part["status"].dims}
    if take.get("of") or not has_classes:
        return found
    part, status = _looked_at(part, take), found["status"]
    nothing = found[f"{take['what']}_low"].isnull() & is_class(status, ("ok",))
    dims = _dims([select.axis_of(part, name) for name in take["over"]])
    lacking = numbers(part[variable]).isnull() & ~unknown_points(part, variable, False)
    names = {**flag_names(status.attrs)}
    for name in flag_names(part["attractor"].attrs).values():
        here = nothing & (lacking & is_class(part["attractor"], (name,))).any(dims)
        if here.any():
            names[max(names) + 1] = name
            status = status.where(~here, max(names))
    if "computed" in part:
        filled = is_class(part["computed"], ("filled_in",)) & numbers(part[variable]).isnull()
        open_ = is_class(part["attractor"], ("undecided",)).any(dims)
        here = is_class(found["status"], ("undecided",)) & filled.any(dims) & ~open_
        if here.any():
            names[max(names) + 1] = "filled_in"
            status = status.where(~here, max(names))
    kept = {"flag_values": np.array([*names], np.int8), "flag_meanings": " ".join(names.values())}
    return found.assign(status=status.assign_attrs(found["status"].attrs | kept))


def _values(array: xr.DataArray, of: str | Sequence[str]) -> xr.DataArray:
    """The numbers; with `of` 1 where it holds, else 0, also where no value applies (NaN)."""
    if not of:
        return numbers(array)
    if known := flag_names(array.attrs).values():
        negated = isinstance(of, str) and of.startswith("not ")
        names = tuple(one.removeprefix("not ") for one in ([of] if isinstance(of, str) else of))
        for name in names:
            if name not in known:
                raise select.SelectionError(f"{name}: no class of {array.name}")
        return (is_class(array, names) != negated).astype(float)
    test = select.condition(of) if isinstance(of, str) else None
    if test is None:
        raise select.SelectionError(f"{of}: no condition on {array.name}, such as '. > 0'")
    return array.copy(data=test(array.values).astype(float))


def _blurred(dataset: xr.Dataset, variable: str, of: str | Sequence[str]) -> xr.DataArray:
    """Where a condition holds of a value, and not of all that it may be within its error."""
    array, error = dataset[variable], dataset.get(error_of(variable))
    if error is None or not of:
        return xr.DataArray(False)
    held = _values(array, of)
    low, high = (array + sign * error.fillna(math.inf) for sign in (-1.0, 1.0))
    return array.notnull() & ((_values(low, of) != held) | (_values(high, of) != held))


def _between(
    taking: _Taking,
    values: xr.DataArray,
    missing: xr.DataArray,
    blurred: xr.DataArray,
    axes: Sequence[xr.DataArray],
) -> tuple[xr.DataArray, xr.DataArray, xr.DataArray]:
    """The least and the greatest that may be found, and where nothing is known."""
    along = [dim for dim in _dims(axes) if dim in missing.dims]
    if taking.ends is None:
        value = taking.take(values, axes)
        told = ~blurred.any([dim for dim in _dims(axes) if dim in blurred.dims])
        return value.where(told, -math.inf), value.where(told, math.inf), missing.any(along)
    unsure = missing | blurred
    one, other = (taking.take(values.where(~unsure, end), axes) for end in taking.ends)
    # a place that there is for one end only may be anywhere, or nowhere
    sure = one.isnull() == other.isnull()
    low, high = one.where(one <= other, other), other.where(one <= other, one)
    return low.where(sure, -math.inf), high.where(sure, math.inf), missing.all(along)


def _answered(dataset: xr.Dataset) -> xr.DataArray:
    """The status of each point; what is filled in has an answer, as what was run."""
    status = dataset["status"]
    if "computed" not in dataset:
        return status
    codes = {name: code for code, name in flag_names(status.attrs).items()}
    return status.where(~is_class(dataset["computed"], ("filled_in",)), codes["ok"])


def _status(
    status: xr.DataArray, unknown: xr.DataArray, axes: Sequence[xr.DataArray]
) -> xr.DataArray:
    """Status "ok" where something is known, else what some point says, or "undecided"."""
    codes = {name: code for code, name in flag_names(status.attrs).items()}
    worst = status.max([dim for dim in _dims(axes) if dim in status.dims])
    # a point of undecided class has been computed, and is yet no answer
    undecided = max(codes.values()) + 1
    told = xr.where(unknown, worst.where(worst != codes["ok"], undecided), codes["ok"])
    names = {
        "flag_values": np.array([*codes.values(), undecided], np.int8),
        "flag_meanings": " ".join([*codes, "undecided"]),
    }
    return told.astype(status.dtype).assign_attrs(status.attrs | names)


def _relative(shares: xr.Dataset, reference: Mapping[str, Any]) -> xr.Dataset:
    """The shares over that at the reference point."""
    part = select.subset(shares, reference, nearest=False)
    whole = part.isel({d: 0 for d in part.dims if part.sizes[d] < shares.sizes[d]}, drop=True)
    ends = (("share_low", "share_high"), ("share_high", "share_low"))
    ratios = {name: shares[name] / whole[by].where(whole[by] > 0.0) for name, by in ends}
    return shares.assign({n: ratio.transpose(*shares[n].dims) for n, ratio in ratios.items()})


def _with_middle(interval: xr.Dataset, what: str, named: Mapping[str, str]) -> xr.Dataset:
    """The dataset with the middle of the interval, NaN of one without end, and all ends named."""
    low, high = interval[f"{what}_low"], interval[f"{what}_high"]
    middle = 0.5 * (low.where(np.isfinite(low)) + high.where(np.isfinite(high)))
    interval = interval.assign({what: middle})
    for name, bound in ((what, ""), (f"{what}_low", ", at least"), (f"{what}_high", ", at most")):
        interval[name].attrs = {**named, "long_name": named["long_name"] + bound}
    return interval


def _unit(array: xr.DataArray, what: str, axis: xr.DataArray) -> str:
    if what in ("share", "entries", "classes"):
        return "1"
    own = axis if what in ("first", "last", "peak") else array
    return str(own.attrs.get("units", "1"))


def _words(array: xr.DataArray, take: Mapping[str, Any], axis: xr.DataArray) -> str:
    """``share with stick fraction > 0``, ``share that is not equilibrium``, ``spread of L_s``.

    A place is ``last disc speed that is periodic``.
    """
    name, of = str(array.name), take.get("of", "")
    if not isinstance(of, str):
        of = " or ".join(filter(None, [", ".join(of[:-1]), of[-1]]))
    words = name if "symbol" in array.attrs else name.replace("_", " ")
    if "." in of:
        words = f"with {of.replace('.', words, 1)}"
    elif of:
        words = f"that is {of.replace('_', ' ')}" * (of != EACH)
    if take["what"] in ("first", "last"):
        words = f"{axis.attrs.get('long_name', axis.name)} {words}"
    over = "over that of the reference" if take.get("relative_to") else ""
    is_plain = take["what"] == "classes" and name == "attractor"
    of_what = f"{'of ' * (take['what'] in ('spread', 'difference', 'classes'))}{words}"
    what = "number of classes" if take["what"] == "classes" else take["what"]
    named = " ".join(filter(None, (what, "" if is_plain else of_what, over)))
    if take["what"] != "difference":
        return named
    first, last = (f"{end:.6g}" if select.is_numeric(axis) else end for end in axis.values[[0, -1]])
    of_axis = f", {axis.name}" * select.is_numeric(axis)  # names tell themselves of what they are
    return f"{named}{of_axis}: {last} less {first}"


# --- ways of taking -------------------------------------------------------------------------------
def _dims(axes: Sequence[xr.DataArray]) -> list[str]:
    """Their dims; axes that advance together have one."""
    return list(dict.fromkeys(str(axis.dims[0]) for axis in axes))


def _entries(held: xr.DataArray, axes: Sequence[xr.DataArray]) -> xr.DataArray:
    """How often what is 0 or 1 along the axis rises: not where it is 1 from the first."""
    (dim,) = _dims(axes)
    return (held.diff(dim) > 0.0).sum(dim).astype(float)


def _first(held: xr.DataArray, axes: Sequence[xr.DataArray]) -> xr.DataArray:
    """The first place along the axis that is held; NaN where there is none."""
    (axis,), (dim,) = axes, _dims(axes)
    if not select.is_numeric(axis):
        raise select.SelectionError(f"{axis.name}: an axis of labels, whose places are no numbers")
    is_held = held > 0.0
    place = is_held.argmax(dim)
    places = place.copy(data=axis.values[place.values].astype(float))
    return places.where(is_held.any(dim))


def _last(held: xr.DataArray, axes: Sequence[xr.DataArray]) -> xr.DataArray:
    back = {dim: slice(None, None, -1) for dim in _dims(axes)}
    return _first(held.isel(back), [axis.isel(back) for axis in axes])


def _classes(codes: xr.DataArray, axes: Sequence[xr.DataArray]) -> xr.DataArray:
    """How many there are; what may be of any class (inf) is of one of its own."""
    known = np.unique(codes.values[np.isfinite(codes.values)])
    counts = sum(codes.isin([code]).any(_dims(axes)) for code in known)
    return (codes.isin([math.inf]).sum(_dims(axes)) + counts).astype(float)


def _spread(array: xr.DataArray, axes: Sequence[xr.DataArray]) -> xr.DataArray:
    """From the least to the greatest; of one alone of several that has a value there is none."""
    dims = _dims(axes)
    alone = (array.notnull().sum(dims) < 2) & (array.isnull().sum(dims) > 0)
    return (array.max(dims) - array.min(dims)).where(~alone)


def _difference(array: xr.DataArray, axes: Sequence[xr.DataArray]) -> xr.DataArray:
    """The last along the axis less the first."""
    (dim,) = _dims(axes)
    return array.isel({dim: -1}) - array.isel({dim: 0})


def _peak(array: xr.DataArray, axes: Sequence[xr.DataArray]) -> xr.DataArray:
    """The place of the greatest value along the axis."""
    return _first((array == array.max(_dims(axes))).astype(float), axes)


_HELD_OR_NOT, _ANYTHING = (0.0, 1.0), (-math.inf, math.inf)
_MOVED = {"least": 1.0, "greatest": 1.0, "mean": 1.0, "spread": 2.0, "difference": 2.0}
"""How far they may be off, in greatest errors of the values."""

_TAKINGS = {
    "share": _Taking(lambda held, axes: held.mean(_dims(axes)), _HELD_OR_NOT),
    "entries": _Taking(_entries),
    "first": _Taking(_first, _HELD_OR_NOT),
    "last": _Taking(_last, _HELD_OR_NOT),
    "classes": _Taking(_classes, (math.nan, math.inf)),
    "least": _Taking(lambda array, axes: array.min(_dims(axes)), _ANYTHING),
    "greatest": _Taking(lambda array, axes: array.max(_dims(axes)), _ANYTHING),
    "mean": _Taking(lambda array, axes: array.mean(_dims(axes)), _ANYTHING),
    "spread": _Taking(_spread),
    "difference": _Taking(_difference),
    "peak": _Taking(_peak),
}
