"""Modes followed by continuity along the grid, instead of sorted anew at each point.

A pure step from dataset to dataset: it renumbers modes, and marks which have merged, and where; it
computes nothing anew. Modes are followed along the ordered axis with the most points, row by row,
and each row is joined to the row before it, so that a number means the same all over a grid. Along
an axis whose values rise and fall, or repeat, there are no neighbours: each point has numbers of
its own there.
(Around a point where two modes merge no numbering is continuous all the way round.)
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import product

import numpy as np
from numpy.typing import NDArray

from fiv_cli.analyses.rest.modes import (
    Complex,
    Modes,
    Order,
    continued,
    coupled_modes,
    followed,
    modes_of,
)
from fiv_cli.analyses.variables import INT_FILL
from fiv_cli.data.dataset import Dataset, Labelled

# Two modes merge where they come to differ more in growth than in frequency, if they then differ
# in both by less than this share of the frequency: with much damping they pass at a distance.
MERGED = 0.01

Index = tuple[int, ...]


def follow_modes(dataset: Dataset) -> Dataset:
    """Renumber modes so that each continues its neighbours', and mark where two merge.

    Parameters
    ----------
    dataset : holds ``eigenvalue_real/imag(..., mode)`` and ``eigenvector_real/imag(..., mode,
        state)``; the first point with eigenvalues along the axes keeps its numbering

    Returns
    -------
    a dataset in which every variable along ``mode`` is renumbered, with a coordinate
    ``mode_number`` that both of a conjugate pair share; ``coupled_with`` and ``coupling_point``,
    where there are any, are filled in
    """
    axes = _axes_to_follow(dataset)
    try:
        dataset = _followed(dataset, axes) if axes else dataset
    except np.linalg.LinAlgError as error:  # the numbers of modes are not worth the eigenvalues
        comment = f"the modes of each point are numbered on their own: {error}"
        real = dataset.variables["eigenvalue_real"]
        told = replace(real, attrs={**real.attrs, "comment": comment})
        dataset = dataset.assign({"eigenvalue_real": told})
    return _with_numbers(dataset)


def _followed(dataset: Dataset, axes: list[str]) -> Dataset:
    """The dataset with its modes renumbered along these dims."""
    values = _complex(dataset, "eigenvalue", axes, ("mode",))
    vectors = _complex(dataset, "eigenvector", axes, ("mode", "state"))
    orders = np.empty(values.shape, np.intp)
    for block in np.ndindex(values.shape[: -len(axes) - 1]):
        orders[block] = follow_grid(values[block], vectors[block])
    followed = _renumbered(dataset, orders, axes)
    pointed = "coupling_point" in dataset.variables
    return _with_coupling_points(followed, axes) if pointed else followed


# --- one grid -------------------------------------------------------------------------------------
def follow_grid(values: Complex, vectors: Complex) -> Order:
    """Numbering of the modes at each point of a grid.

    Parameters
    ----------
    values : (..., points, modes), NaN where nothing was computed; rows lie along the last axis
        but one, and are joined along the others
    vectors : (..., points, modes, states)

    Returns
    -------
    (..., points, modes): which of a point's modes stands at each place
    """
    orders = np.broadcast_to(np.arange(values.shape[-1]), values.shape).copy()
    done: dict[Index, _Row] = {}
    for place in np.ndindex(values.shape[:-2]):
        row = _Row(values[place], vectors[place], orders[place])
        first = row.joined_to([done[before] for before in _before(place)])
        row.follow(first)
        done[place] = row
    return orders


def _before(place: Index) -> Iterator[Index]:
    """The neighbouring rows that come before this one, the nearest in storage first."""
    for axis in reversed(range(len(place))):
        if place[axis] > 0:
            yield (*place[:axis], place[axis] - 1, *place[axis + 1 :])


@dataclass(frozen=True)
class _Row:
    """One row of points: eigenvalues (points, modes), vectors, and their order, to be filled."""

    values: Complex
    vectors: Complex
    orders: Order

    def known(self) -> NDArray[np.bool_]:
        """Where something was computed, (points,)."""
        return np.asarray(np.isfinite(self.values).all(axis=1))

    @cached_property
    def modes(self) -> Modes:
        """The modes of the points as they are stored."""
        return modes_of(self.values, self.vectors)

    def joined_to(self, rows: list[_Row]) -> int:
        """Number one point as its neighbour in the first of `rows` that has one; its place."""
        for row in rows:
            both = np.flatnonzero(self.known() & row.known())
            if both.size:
                place = int(both[0])
                before = row.modes[place].taken(row.orders[place])
                (self.orders[place],) = followed([(before, self.modes[place])])
                return place
        found = np.flatnonzero(self.known())
        return int(found[0]) if found.size else 0

    def follow(self, first: int) -> None:
        """Number all other points from the one at `first`, upwards and downwards."""
        known = np.flatnonzero(self.known())
        self._follow(known[known >= first])
        self._follow(known[known <= first][::-1])

    def _follow(self, points: Order) -> None:
        """Number the points after the first, each as the one before it.

        Mostly a point is numbered as the one before it, so many are matched at once as if all
        were: so far as that is true it is what they are matched to.
        """
        ahead = 1
        while len(points) > 1:
            order, some = self.orders[points[0]].copy(), points[: ahead + 1]
            found = continued(self.modes[some[:-1]].taken(order), self.modes[some[1:]])
            changed = np.flatnonzero((found != order).any(axis=1))
            told = int(changed[0]) + 1 if changed.size else len(found)
            self.orders[some[1 : told + 1]] = found[:told]
            points, ahead = points[told:], 1 if changed.size else 2 * ahead


# --- the dataset's axes ---------------------------------------------------------------------------
def _axes_to_follow(dataset: Dataset) -> list[str]:
    """The dims with more than one value along which an axis is ordered, the longest first."""
    dims, sizes = dataset.variables["eigenvalue_real"].dims[:-1], dataset.sizes
    ordered = [dim for dim in dims if sizes[dim] > 1 and _ordered_axes(dataset, dim)]
    return sorted(ordered, key=lambda name: -sizes[name])


def _ordered_axes(dataset: Dataset, dim: str) -> list[str]:
    """Of the numeric axes along `dim`, one or several that advance together, those in order."""
    found = dataset.variables.items()
    along = {n: axis for n, axis in found if n in dataset.coords and axis.dims == (dim,)}
    return [n for n, axis in along.items() if axis.dtype.kind == "f" and _is_ordered(axis.values)]


def _is_ordered(values: NDArray[np.float64]) -> bool:
    """Whether values rise or fall throughout."""
    steps = np.diff(values)
    return bool(np.all(steps > 0.0) or np.all(steps < 0.0))


def _arranged(variable: Labelled, axes: list[str], last: tuple[str, ...]) -> tuple[str, ...]:
    """Dims in which other dims come first and rows, along the first of `axes`, last."""
    others = [dim for dim in variable.dims if dim not in (*axes, *last)]
    return (*others, *axes[1:], *axes[:1], *last)


def _complex(dataset: Dataset, stem: str, axes: list[str], last: tuple[str, ...]) -> Complex:
    """Real and imaginary parts, with the followed axes before `last`."""
    parts = (dataset.variables[f"{stem}_{part}"] for part in ("real", "imag"))
    real, imag = (part.arranged(_arranged(part, axes, last)) for part in parts)
    result: Complex = real + 1j * imag
    return result


def _renumbered(dataset: Dataset, orders: Order, axes: list[str]) -> Dataset:
    along = {n: v for n, v in dataset.variables.items() if n not in dataset.coords}
    found = {n: _taken(v, orders, axes) for n, v in along.items() if "mode" in v.dims}
    return dataset.assign(found)


def _taken(variable: Labelled, orders: Order, axes: list[str]) -> Labelled:
    """One variable with its modes in the new order."""
    behind = variable.dims[variable.dims.index("mode") + 1 :]
    dims = _arranged(variable, axes, ("mode", *behind))
    index = orders.reshape(*orders.shape, *(1 for _ in behind))
    taken = np.take_along_axis(variable.arranged(dims), index, axis=orders.ndim - 1)
    return replace(variable, values=Labelled(dims, taken, {}).arranged(variable.dims))


# --- modes by number ------------------------------------------------------------------------------
def _with_numbers(dataset: Dataset) -> Dataset:
    """The dataset with ``mode_number``, and in ``coupled_with`` the numbers of the partners."""
    values = _complex(dataset, "eigenvalue", [], ("mode",))
    numbers = mode_numbers(values.reshape(-1, values.shape[-1]))
    named = {"units": "1", "long_name": "mode, counted from 1; a conjugate pair is one"}
    coordinate = {"mode_number": Labelled(("mode",), numbers, named)}
    dataset = dataset.assign(coordinate, coords=("mode_number",))
    if "coupled_with" not in dataset.variables:
        return dataset
    coupled = dataset.variables["coupled_with"]
    numbered = np.append(numbers, -1)
    found = np.full(values.shape, INT_FILL, coupled.dtype)
    for row in np.ndindex(values.shape[:-2]):
        known = np.isfinite(values[row])
        found[row] = np.where(known, numbered[coupled_modes(values[row])], INT_FILL)
    return dataset.assign({"coupled_with": replace(coupled, values=found)})


def mode_numbers(values: Complex) -> NDArray[np.int32]:
    """The number of the mode that each eigenvalue belongs to, from 1.

    Parameters
    ----------
    values : (points, modes), followed, NaN where nothing was computed; of a conjugate pair the
        eigenvalue of positive frequency is counted, and the other has its number
    """
    twins = (values.imag < 0.0).any(axis=0) & ~(values.imag >= 0.0).any(axis=0)
    numbers = np.cumsum(~twins, dtype=np.int32)
    for twin in np.flatnonzero(twins):
        row = values[np.isfinite(values[:, twin])][0]
        distance = np.where(twins, np.inf, np.abs(row - row[twin].conj()))
        numbers[twin] = numbers[np.nanargmin(distance)]
    return numbers


# --- where modes merge ----------------------------------------------------------------------------
def _with_coupling_points(dataset: Dataset, axes: list[str]) -> Dataset:
    along = _ordered_axes(dataset, axes[0])[0]
    coordinate = dataset.variables[along]
    values = _complex(dataset, "eigenvalue", axes, ("mode",))
    points = np.full(values.shape, np.nan)
    for row in np.ndindex(values.shape[:-2]):
        points[row] = coupling_points(coordinate.values.astype(float), values[row])
    variable = dataset.variables["coupling_point"]
    dims = _arranged(variable, axes, ("mode",))
    attributes = {
        **variable.attrs,
        "units": coordinate.attrs.get("units", "1"),
        "along": along,
        "long_name": f"{along} at which the mode merges with another, before the next point",
    }
    filled = Labelled(dims, points, attributes).arranged(variable.dims)
    return dataset.assign({"coupling_point": Labelled(variable.dims, filled, attributes)})


def coupling_points(axis: NDArray[np.float64], values: Complex) -> NDArray[np.float64]:
    """Where pairs of followed modes merge or part along a row.

    The square of the difference of two eigenvalues is a smooth function of the parameter where
    they merge: negative while they differ in frequency, positive where they differ in growth.

    Parameters
    ----------
    axis : (points,), the parameter
    values : (points, modes), followed

    Returns
    -------
    (points, modes): the value between a point and the next at which the mode does so, else NaN
    """
    places = np.full(values.shape, np.nan)
    modes = range(values.shape[1])
    for first, second in product(modes, modes):
        if first < second:
            for point, place in _merging(axis, values[:, first], values[:, second]):
                places[point, [first, second]] = place
    return places


def _merging(
    axis: NDArray[np.float64], first: Complex, second: Complex
) -> Iterator[tuple[int, float]]:
    """Each point after which these two modes merge or part, and where."""
    squares = (first - second) ** 2
    same_side = first.imag * second.imag > 0.0
    frequency = np.abs(first.imag)
    told = np.isfinite(squares) & same_side
    told = told[:-1] & told[1:] & np.diff(squares.real < 0.0)
    for point in np.flatnonzero(told).tolist():
        here, there = squares[point], squares[point + 1]
        share = here.real / (here.real - there.real)
        rest = abs(here.imag + share * (there.imag - here.imag))
        if rest <= 2.0 * (MERGED * frequency[point]) ** 2:
            yield point, _root(axis, squares.real, point)


def _root(axis: NDArray[np.float64], heights: NDArray[np.float64], point: int) -> float:
    """Zero between a point and the next, of the cubic through them and their neighbours."""
    near = slice(max(point - 1, 0), point + 3)
    x, y = axis[near], heights[near]
    x, y = x[np.isfinite(y)], y[np.isfinite(y)]
    low, high = axis[point], axis[point + 1]
    scaled = (x - low) / (high - low)
    roots = np.roots(np.polyfit(scaled, y, len(x) - 1))
    real = roots[(np.abs(roots.imag) < 1e-9) & (roots.real >= 0.0) & (roots.real <= 1.0)].real
    straight = heights[point] / (heights[point] - heights[point + 1])
    share = min(real, key=lambda root: abs(root - straight), default=straight)
    return float(low + share * (high - low))
