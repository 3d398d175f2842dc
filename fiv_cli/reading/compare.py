"""Whether two datasets agree, and where they do not.

Status and class are compared exactly. Numbers are compared where both sides are of the same class
(the L_s of a rest against that of stick-slip is no error of a number), equilibrium or periodic, or
where the analysis knows no classes; quasi-periodic and chaotic motions only by L_s and by the
shares of time, within the error of a finite window, because two computations of such a motion agree
for a while only. What says how an answer was reached (how far to trust it, what it cost) is left
out unless a tolerance is given. Of points that a refined map did not run, but filled in, its class
alone is compared.
"""

from __future__ import annotations

from collections.abc import Callable, Hashable, Iterable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from functools import partial
from itertools import islice
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from fiv_cli.analyses.catalogue import named
from fiv_cli.analyses.variables import Role
from fiv_cli.case.grammar import SAME
from fiv_cli.case.toml import parse_toml
from fiv_cli.errors import InputError, UsageError
from fiv_cli.flags import ATTRACTOR
from fiv_cli.reading import select
from fiv_cli.reading.datasets import (
    error_of,
    filled_in,
    flag_names,
    is_class,
    name_of_only,
    standard_error_of,
)
from fiv_cli.reading.over_laws import stretches
from fiv_cli.reading.select import ragged_dims, row_sizes
from fiv_cli.reading.shares import drawn_of

Mask = NDArray[np.bool_]
Array = NDArray[Any]  # of any kind: numbers, classes, texts

EXACT_CLASSES = ("equilibrium", "periodic", "contact_lost")
SAMPLED_CLASSES = ("quasiperiodic", "chaotic")


@dataclass(frozen=True)
class Tolerance:
    """Numbers a and b agree when ``|a - b| <= atol + rtol max(|a|, |b|)``."""

    rtol: float = 1e-6
    atol: float = 1e-12


@dataclass(frozen=True)
class Tolerances:
    """Tolerances of a comparison.

    Attributes
    ----------
    default : of every variable without its own
    sampled : of L_s, mean powers and shares of time of quasi-periodic and chaotic motions; `atol`
        of these shares alone, which are of order one
    variables : name -> its own
    ignore : names that are not compared
    standard_errors : how many combined ones two values of the same chaos may lie apart, where both
        sides tell theirs; 0 where a file says how closely they are compared
    """

    default: Tolerance = Tolerance()
    sampled: Tolerance = Tolerance(rtol=0.1, atol=0.02)
    variables: Mapping[str, Tolerance] = field(default_factory=dict)
    ignore: tuple[str, ...] = ()
    standard_errors: float = 4.0

    def of(self, name: str) -> Tolerance:
        """The tolerance of a variable."""
        return self.variables.get(name, self.default)

    def of_sampled(self, name: str) -> Tolerance:
        """The same where it was measured over a window of a motion that does not repeat."""
        is_share = named(name).role is Role.SHARE
        return self.sampled if is_share else replace(self.sampled, atol=self.of(name).atol)


ALONG = "; what lies along it is not compared"
REDRAWN = (
    "random starts are drawn anew at other parameters: shares of them can be compared, not one "
    "with another (fiv show: shares)"
)
PLACES = 100
"""How many stretches of points that have come into another class are named."""


@dataclass(frozen=True)
class Change:
    """Points that are of one class in the first dataset, and of another in the second.

    Attributes
    ----------
    first, second : the classes
    count : of the points
    places : the stretches along an axis in which they lie, the first hundred
    """

    first: str
    second: str
    count: int
    places: tuple[str, ...]


@dataclass(frozen=True)
class Difference:
    """One thing in which two datasets differ.

    Attributes
    ----------
    what : variable, coordinate or dim
    text : how, with the worst offender and where it is
    count : number of values that differ
    changes : of classes, the most frequent first
    """

    what: str
    text: str
    count: int = 1
    changes: tuple[Change, ...] = ()


def read_tolerances(path: Path) -> Tolerances:
    """Tolerances from a TOML file.

    ``[default]``, ``[sampled]`` and ``[variables.NAME]`` hold ``rtol`` and ``atol``; ``ignore``
    lists names.

    Raises
    ------
    UsageError
        there is no such file.
    InputError
        it is not TOML, or has another form.
    """
    try:
        table = parse_toml(path.read_text(encoding="utf-8"))
        return _tolerances(table)
    except OSError as error:
        raise UsageError(f"{path}: {error.strerror}\nnext: name a TOML file") from error
    except (AttributeError, TypeError, ValueError) as error:
        raise InputError(
            f"{path}: no table of tolerances: {error}\n"
            "next: [default] rtol = 1e-6, [variables.L_s] rtol = 1e-4, ignore = [...]"
        ) from error


def _tolerances(table: Mapping[str, Any]) -> Tolerances:
    unknown = set(table) - {"default", "sampled", "variables", "ignore"}
    if unknown:
        raise ValueError(f"unknown key {sorted(unknown)[0]!r}")
    own = {name: Tolerance(**entry) for name, entry in table.get("variables", {}).items()}
    general = {name: Tolerance(**table[name]) for name in ("default", "sampled") if name in table}
    ignore = tuple(table.get("ignore", ()))
    return Tolerances(**general, variables=own, ignore=ignore, standard_errors=0.0)


def compare(
    left: Mapping[str, xr.Dataset], right: Mapping[str, xr.Dataset], tolerances: Tolerances
) -> list[Difference]:
    """Every difference between two sets of datasets, by name of the analysis.

    First of which axes a part alone can be compared, and which starts are others; then which class
    became which, that of the steady state before others: numbers follow it.
    """
    left, right = _alike_named(left, right)
    axes, differences = [], []
    for name in sorted(left.keys() | right.keys()):
        if name not in left or name not in right:
            side = "first" if name in left else "second"
            differences.append(Difference(name, f"only in the {side} dataset"))
        else:
            one, other = (_found(side[name]) for side in (left, right))
            if another := _other_axes(one, other):
                differences.append(Difference(name or "axes", another))
                continue
            prefix = f"{name}/" if name else ""
            one, other, cut = _at_common_points(one, other)
            axes += [Difference(prefix + axis, text) for axis, text in cut.items()]
            axes += [Difference(prefix + "initial", REDRAWN)] * _are_redrawn(one, other)
            differences.extend(_Pair(one, other, {*cut}, tolerances, prefix).differences())
    return [*axes, *sorted(differences, key=_rank)]


def _are_redrawn(one: xr.Dataset, other: xr.Dataset) -> bool:
    """Whether random starts of the same labels are others."""
    if not all("initial_state" in side for side in (one, other)):
        return False
    random, labels = {*drawn_of(one)} & {*drawn_of(other)}, map(str, one["initial"].values)
    drawn = [label for label in labels if label.rpartition("-")[0] in random]
    if one["initial_state"].shape != other["initial_state"].shape:
        return False
    own, its = (side["initial_state"].sel(initial=drawn).values for side in (one, other))
    return not np.array_equal(own, its, equal_nan=True)


def _alike_named(
    left: Mapping[str, xr.Dataset], right: Mapping[str, xr.Dataset]
) -> tuple[Mapping[str, xr.Dataset], Mapping[str, xr.Dataset]]:
    """Both as they are or, where one has a single analysis, by the names of these."""
    return (left, right) if left.keys() == right.keys() else (_by_name(left), _by_name(right))


def _by_name(analyses: Mapping[str, xr.Dataset]) -> dict[str, xr.Dataset]:
    """By the names of analyses, also of one that is alone in its file."""
    return {name or name_of_only(one): one for name, one in analyses.items()}


def _other_axes(one: xr.Dataset, other: xr.Dataset) -> str:
    """That two datasets have other axes, or in another order: their points cannot be compared."""
    dims = [tuple(map(str, side["status"].dims)) for side in (one, other) if "status" in side]
    if len(dims) < 2 or dims[0] == dims[1]:
        return ""
    orders = " against ".join(", ".join(order) or "none" for order in dims)
    if {*dims[0]} != {*dims[1]}:
        return f"other axes, {orders}: no point is compared"
    return f"the axes of [grid] in another order, {orders}: run one of them in that of the other"


def _rank(one: Difference) -> int:
    return 2 if not one.changes else 0 if one.what.rpartition("/")[2] == "attractor" else 1


def _found(dataset: xr.Dataset) -> xr.Dataset:
    """What was found, without the fixed parameters that it was found under, and as it is stored.

    Nor what leads observations back to their points, by the number of these in the file.
    """
    parameters = [name for name, coord in dataset.coords.items() if coord.ndim == 0]
    derived = [name for name in dataset if named(str(name)).derived]
    back = [f"{dim.removesuffix('_obs')}_point" for dim in ragged_dims(dataset)]
    return dataset.drop_vars([*parameters, *derived, *back], errors="ignore")


def _at_common_points(
    one: xr.Dataset, other: xr.Dataset
) -> tuple[xr.Dataset, xr.Dataset, dict[str, str]]:
    """Both at those values of the grid's axes that both have, and axis -> in what it differs.

    An axis without a value in common stays as it is.
    """
    masks: list[dict[str, Mask]] = [{}, {}]
    told: dict[str, str] = {}
    for dim in map(str, one["status"].dims if "status" in one and "status" in other else ()):
        names = [name for name in _axes_along(one, dim) if name in _axes_along(other, dim)]
        pairs = [(one[name].values, other[name].values) for name in names]
        if all(np.array_equal(a, b) for a, b in pairs):
            continue
        if one.sizes[dim] == other.sizes[dim] == 1:  # the one value of each, as of a parameter
            told |= {
                name: f"{_spoken(a)} against {_spoken(b)}"
                for name, (a, b) in zip(names, pairs, strict=True)
            }
            continue
        of_both = [
            np.logical_and.reduce([_is_among(*pair[::way]) for pair in pairs]) for way in (1, -1)
        ]
        count = int(of_both[0].sum())
        if count and count == of_both[1].sum():
            masks[0][dim], masks[1][dim] = of_both
            sizes = f"{of_both[0].size} against {of_both[1].size} values"
            told |= dict.fromkeys(names, f"{sizes}, {count} of them in both and compared")
    one, other = (select.masked(side, mask) for side, mask in zip((one, other), masks, strict=True))
    return one, other.assign_coords({name: one[name] for name in told}), told


def _spoken(value: Array) -> str:
    """The one value of an axis."""
    return str(np.asarray(value).item())


def _axes_along(dataset: xr.Dataset, dim: str) -> list[str]:
    return [str(name) for name, coord in dataset.coords.items() if coord.dims == (dim,)]


def _is_among(values: Array, others: Array) -> Mask:
    """Which values are others, too: the same label, or number within what counts as the same."""
    if values.dtype.kind not in "fiu":
        return np.isin(values.astype(str), others.astype(str))
    ordered = np.sort(others)
    place = np.searchsorted(ordered, values)
    beside = ordered[np.clip([place - 1, place], 0, ordered.size - 1)]
    return np.asarray(np.isclose(beside, values, rtol=SAME, atol=0.0).any(axis=0))


@dataclass(frozen=True)
class _Pair:
    """Two datasets of one analysis, which `prefix` names in front of what differs."""

    left: xr.Dataset
    right: xr.Dataset
    cut: set[str]  # axes that differ beyond what is compared
    tolerances: Tolerances
    prefix: str

    def differences(self) -> Iterator[Difference]:
        yield from self._of_names()
        apart: set[Hashable] = set()
        for difference, dims in self._of_coordinates():
            yield difference
            apart |= {*dims}
        both = self.left.data_vars.keys() & self.right.data_vars.keys() - {*self.tolerances.ignore}
        for name in map(str, self.left.data_vars):
            if name in both and not apart & self._dims(name):
                yield from self._of_variable(name)

    def _dims(self, name: str) -> set[Hashable]:
        """Where the values of a variable lie; values at different places cannot be compared."""
        sizes = row_sizes(self.left, name)
        return {*self.left[name].dims, *(() if sizes is None else sizes.dims)}

    def _told(self, name: str, text: str, count: int = 1) -> Difference:
        return Difference(self.prefix + name, text, count)

    def _of_names(self) -> Iterator[Difference]:
        for name in sorted(map(str, self.left.variables.keys() ^ self.right.variables.keys())):
            if name not in {*self.tolerances.ignore, "computed"}:  # of a map that is refined
                side = "first" if name in self.left.variables else "second"
                yield self._told(name, f"only in the {side} dataset")

    def _of_coordinates(self) -> Iterator[tuple[Difference, tuple[Hashable, ...]]]:
        """What differs, and the dims along which nothing can be compared then."""
        counted = {*ragged_dims(self.left), *ragged_dims(self.right)}
        for name in map(str, self.left.coords):
            known = name in self.right.coords and name not in self.cut
            if not known or counted & {*self.left[name].dims}:
                continue
            a, b, dims = self.left[name].values, self.right[name].values, self.left[name].dims
            if a.shape != b.shape:
                yield self._told(name, f"{a.size} against {b.size} values{ALONG}"), dims
            elif not np.array_equal(a, b):
                index = int(np.flatnonzero(a != b)[0])
                values = f"{_spoken(a.ravel()[index])} against {_spoken(b.ravel()[index])}"
                text = f"value {index}: {values}{ALONG}"
                yield self._told(name, text, int(np.count_nonzero(a != b))), dims

    def _of_variable(self, name: str) -> Iterator[Difference]:
        a, b = self.left[name], self.right[name]
        form = _difference_of_form(a, b)
        if form:
            yield self._told(name, form)
            return
        if named(name).tells_trust and name not in self.tolerances.variables:
            return
        if a.attrs.get("along") in self.cut:  # it tells of what lies before the next value there
            return
        sizes, others = row_sizes(self.left, name), row_sizes(self.right, name)
        if sizes is not None and others is not None and sizes.name == others.name:
            yield from self._of_rows(name, sizes, others)
        elif sizes is not None or others is not None:
            counted = [rows if rows is None else rows.name for rows in (sizes, others)]
            yield self._told(name, f"rows counted by {counted[0]} against {counted[1]}")
        elif not (name.endswith("_row_size") and "attractor" in self.left):
            yield from self._of_values(name, a, b)

    def _of_values(self, name: str, a: xr.DataArray, b: xr.DataArray) -> Iterator[Difference]:
        if a.shape != b.shape:
            yield self._told(name, f"shape {a.shape} against {b.shape}")
            return
        x, y = a.values, b.values
        exact, sampled = self._compared(name)
        bad = a.copy(data=_differs(x, y, self.tolerances.of(name))) & exact
        apart = _differs(x, y, self.tolerances.of_sampled(name)) & ~self._by_chance(name, x, y)
        bad = bad | (a.copy(data=apart) & sampled)
        mask = bad.transpose(*a.dims).values.ravel()
        if flag_names(a.attrs) and mask.any():
            yield self._of_classes(name, x.ravel(), y.ravel(), mask)
        else:
            yield from self._of_worst(name, x.ravel(), y.ravel(), mask, partial(_place, a))

    def _by_chance(self, name: str, x: Array, y: Array) -> Mask:
        """Where two values lie within the standard errors that both sides tell."""
        told = [side.get(standard_error_of(name)) for side in (self.left, self.right)]
        if any(one is None or one.shape != x.shape for one in told):
            return np.zeros(x.shape, bool)
        combined = np.hypot(*(one.values for one in told if one is not None))
        return np.asarray(np.abs(x - y) <= self.tolerances.standard_errors * combined)

    def _of_classes(self, name: str, x: Array, y: Array, bad: Mask) -> Difference:
        """Which class became which, at how many points."""
        pairs, counts = np.unique(np.stack([x[bad], y[bad]], axis=1), axis=0, return_counts=True)
        changes = tuple(
            Change(
                _named(self.left[name], first),
                _named(self.right[name], second),
                int(count),
                tuple(_stretches(self.left[name], (x == first) & (y == second) & bad)),
            )
            for (first, second), count in zip(pairs, counts, strict=True)
        )
        changes = tuple(sorted(changes, key=lambda one: -one.count))
        told = [f"{one.first} -> {one.second} {one.count} at {one.places[0]}" for one in changes]
        return Difference(self.prefix + name, ", ".join(told), int(bad.sum()), changes)

    def _of_rows(
        self, name: str, sizes: xr.DataArray, others: xr.DataArray
    ) -> Iterator[Difference]:
        """Row by row: the numbers of rows must agree, then the values."""
        exact, _ = self._compared(name)
        wanted = np.broadcast_to(np.asarray(exact), sizes.shape).ravel()
        counts = [rows.values.ravel().astype(int) for rows in (sizes, others)]
        unequal = (counts[0] != counts[1]) & wanted
        if unequal.any():
            row = int(np.argmax(unequal))
            text = f"{counts[0][row]} against {counts[1][row]} values at {_place(sizes, row)}"
            yield self._told(name, text, int(np.count_nonzero(unequal)))
            return
        x, y = (
            dataset[name].values[np.repeat(wanted, count)]
            for dataset, count in zip((self.left, self.right), counts, strict=True)
        )
        points = np.repeat(np.flatnonzero(wanted), counts[0][wanted])
        bad = _differs(x, y, self.tolerances.of(name))
        yield from self._of_worst(name, x, y, bad, lambda row: _place(sizes, int(points[row])))

    def _of_worst(
        self, name: str, x: Array, y: Array, bad: Mask, place: Callable[[int], str]
    ) -> Iterator[Difference]:
        """What differs as one difference: how many values, and the one that does so most."""
        if bad.any():
            worst = int(np.argmax(np.where(bad, _gap(x, y), -1.0)))
            sides = ((self.left, x), (self.right, y))
            digits = 12 if f"{x[worst]:.12g}" != f"{y[worst]:.12g}" else 17
            left, right = (
                f"{_named(one[name], values[worst], digits)}{_error(one, name, values.size, worst)}"
                for one, values in sides
            )
            text = f"{left} against {right} at {place(worst)}"
            yield self._told(name, text, int(np.count_nonzero(bad)))

    def _compared(self, name: str) -> tuple[xr.DataArray | bool, xr.DataArray | bool]:
        """Where a variable is compared with its own tolerance, and where with that of sampling.

        Where a side was filled in, the class alone is.
        """
        found, filled = self._of_one_class(name), filled_in_either(self.left, self.right)
        if filled is None or name in _refined(self.left, self.right):
            return found
        if not {*filled.dims} <= self._dims(name):  # it is of no point
            return found
        return found[0] & ~filled, found[1] & ~filled

    def _of_one_class(self, name: str) -> tuple[xr.DataArray | bool, xr.DataArray | bool]:
        """The same by the attractor of both sides."""
        if "attractor" not in self.left or "attractor" not in self.right:
            return True, False
        if named(name).role is Role.STATUS or name == "attractor":
            return True, False
        return self._both(EXACT_CLASSES), (
            self._both(SAMPLED_CLASSES) if named(name).statistic else False
        )

    def _both(self, classes: Iterable[str]) -> xr.DataArray:
        """Where both are of one of the classes; of the same, unless nobody asks for that."""
        left, right = self.left["attractor"], self.right["attractor"]
        codes = [ATTRACTOR.codes[name] for name in classes]
        alike = (left == right) | ("attractor" in self.tolerances.ignore)
        return left.isin(codes) & right.isin(codes) & alike


def filled_in_either(left: xr.Dataset, right: xr.Dataset) -> xr.DataArray | None:
    """Points that one side did not run, but filled in; None of maps that are not refined."""
    if not any("computed" in one for one in (left, right)):
        return None
    status = left["status"]
    if status.shape != right["status"].shape:
        return None
    sides = [filled_in(one, str(one.attrs.get("refined_of"))) for one in (left, right)]
    return sides[0] | status.copy(data=sides[1].values)


def count_filled(left: Mapping[str, xr.Dataset], right: Mapping[str, xr.Dataset]) -> int:
    """At how many points both are compared by the class alone, since one was filled in there."""
    left, right = _alike_named(left, right)
    pairs = [(one, right[name]) for name, one in left.items() if name in right]
    alike = [pair for pair in pairs if not _other_axes(*pair)]
    masks = (filled_in_either(*_at_common_points(*map(_found, pair))[:2]) for pair in alike)
    return sum(int(one.sum()) for one in masks if one is not None)


def _refined(*sides: xr.Dataset) -> list[str]:
    """What has an answer where points were filled in, too."""
    return ["computed", *(str(one.attrs.get("refined_of")) for one in sides)]


def has_sampled(left: Mapping[str, xr.Dataset]) -> bool:
    """Whether some numbers are those of a window of a motion that does not repeat."""
    classes = (one["attractor"] for one in left.values() if "attractor" in one)
    return any(bool(is_class(one, SAMPLED_CLASSES).any()) for one in classes)


def _difference_of_form(a: xr.DataArray, b: xr.DataArray) -> str:
    """In what two variables cannot be compared; empty where they can."""
    if a.attrs.get("units") != b.attrs.get("units"):
        return f"units {a.attrs.get('units')!r} against {b.attrs.get('units')!r}"
    if a.dims != b.dims or a.dtype.kind != b.dtype.kind:
        return f"{a.dtype} over {a.dims} against {b.dtype} over {b.dims}"
    return ""


def _differs(x: Array, y: Array, tolerance: Tolerance) -> Mask:
    """Where two arrays differ; two NaN agree, a NaN and a number do not."""
    if x.dtype.kind != "f":
        return np.asarray(x != y)
    finite = np.isfinite(x) & np.isfinite(y)
    u, w = np.where(finite, x, 0.0), np.where(finite, y, 0.0)
    allowed = tolerance.atol + tolerance.rtol * np.maximum(np.abs(u), np.abs(w))
    same = np.where(finite, np.abs(u - w) <= allowed, (x == y) | (np.isnan(x) & np.isnan(y)))
    return np.asarray(~same.astype(bool))


def _gap(x: Array, y: Array) -> NDArray[np.float64]:
    """Relative distance; infinite where a side is not a number."""
    x, y = np.asarray(x, float), np.asarray(y, float)
    finite = np.isfinite(x) & np.isfinite(y)
    u, w = np.where(finite, x, 0.0), np.where(finite, y, 0.0)
    scale = np.maximum(np.abs(u), np.abs(w))
    return np.where(finite, np.abs(u - w) / np.where(scale > 0.0, scale, 1.0), np.inf)


def _named(variable: xr.DataArray, value: float, digits: int = 12) -> str:
    """A value, by its name where it is a flag."""
    names = flag_names(variable.attrs)
    return names.get(int(value), str(value)) if names else f"{value:.{digits}g}"


def _error(dataset: xr.Dataset, name: str, count: int, index: int) -> str:
    """How far a value may be off by itself, where all of the variable, `count`, were compared."""
    errors = dataset.get(error_of(name))
    if errors is None or not errors.size == dataset[name].size == count:
        return ""
    error = errors.values.ravel()[index]
    return f" ± {error:.2g}" if np.isfinite(error) else ""


def _stretches(variable: xr.DataArray, marked: Mask) -> Iterator[str]:
    """The marked elements, neighbours along an axis as one: ``Omega=3.6 to 5.4, initial=far``."""
    along = {str(dim) for coord in variable.coords.values() for dim in coord.dims}
    if variable.size > 1 and along.issuperset(map(str, variable.dims)):
        where = variable.copy(data=marked.reshape(variable.shape)).squeeze()
        yield from islice(stretches(where), PLACES)
    else:
        yield from (_place(variable, index) for index in np.flatnonzero(marked)[:PLACES].tolist())


def _place(variable: xr.DataArray, index: int) -> str:
    """Coordinates of the element at a flat (C order) index: ``mu_k=0.4, initial=far``.

    Those of which there are several.
    """
    parts = []
    place = np.unravel_index(index, variable.shape)
    for dim, i in zip(variable.dims, place, strict=True):
        if variable.sizes[dim] == 1:
            continue
        coordinates = [n for n, c in variable.coords.items() if c.dims == (dim,)]
        parts += [f"{n}={variable[n].values[int(i)]}" for n in coordinates] or [f"{dim}={int(i)}"]
    return ", ".join(parts) or "the only point"
