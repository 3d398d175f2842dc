"""From blocks of outcomes to one dataset.

Blocks are read one at a time and written into arrays of the final type, by the position of each
point: workers, chunks and order leave no trace, and memory is that of the dataset.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from itertools import pairwise
from pathlib import Path
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from fiv_cli.analyses.variables import Role, Variable, motions
from fiv_cli.case.case import Axis
from fiv_cli.data.block import Array, Block, dtype_of, fill_value, padded
from fiv_cli.data.dataset import Dataset, Labelled
from fiv_cli.data.layout import Layout
from fiv_cli.data.mapped import let_go, mapped
from fiv_cli.data.modes import follow_modes
from fiv_cli.flags import REASONS, TABLES
from fiv_cli.friction import get_law
from fiv_cli.models import get_model
from fiv_cli.models.base import Parameter
from fiv_cli.models.excitation import terms_of

Rows = NDArray[np.int64]


class Stored(Protocol):
    """A block that may have to be read first: its outline is at hand."""

    @property
    def row_sizes(self) -> Mapping[str, NDArray[np.int32]]:
        """As of the block."""

    @property
    def shapes(self) -> Mapping[str, tuple[int, ...]]:
        """As of the block."""

    def block(self) -> Block:
        """The block."""


Placed = tuple[Rows, Stored]
"""Positions of the rows of a block (negative: not part of the dataset), and the block."""

Blocks = Callable[[], Iterable[Placed]]


LARGE = 256 * 2**20
"""Bytes of a dataset beyond which its arrays lie in files."""


@dataclass
class _Survey:
    """What a first pass over the blocks finds.

    Attributes
    ----------
    owner : (size,) number of the last block that holds each point; -1: none
    row_sizes : ragged group -> (size,) rows of each point
    own_shapes : variable -> largest shape of its own dims
    complete : variables that all points have, in that shape
    """

    owner: NDArray[np.int32]
    row_sizes: dict[str, NDArray[np.int32]] = field(default_factory=dict)
    own_shapes: dict[str, tuple[int, ...]] = field(default_factory=dict)
    complete: frozenset[str] = frozenset()


def assemble(layout: Layout, blocks: Blocks, scratch: Path | None = None) -> Dataset:
    """The dataset of one analysis.

    Parameters
    ----------
    layout : dims, coordinates and variables
    blocks : gives an iterator over the placed blocks, twice the same; where two blocks hold the
        same point the later one counts
    scratch : folder for files that hold the arrays of a large dataset; None: memory does

    Returns
    -------
    the dataset without global attributes; points that no block holds are ``pending``
    """
    assembly = _Assembly(layout, _survey(layout, blocks), scratch)
    for number, (positions, stored) in enumerate(blocks()):
        assembly.fill(stored.block(), positions, number)
    dataset = assembly.dataset()
    return follow_modes(dataset) if layout.kind == "eigenvalues" else dataset


def _survey(layout: Layout, blocks: Blocks) -> _Survey:
    survey = _Survey(np.full(layout.size, -1, np.int32))
    for variable in layout.variables:
        if variable.ragged:
            survey.row_sizes[variable.ragged] = np.zeros(layout.size, np.int32)
    shapes_of_blocks = []
    for number, (positions, stored) in enumerate(blocks()):
        shapes_of_blocks.append(stored.shapes)
        placed = positions >= 0
        survey.owner[positions[placed]] = number
        for group, sizes in stored.row_sizes.items():
            survey.row_sizes[group][positions[placed]] = sizes[placed]
        for name, shape in stored.shapes.items():
            known = survey.own_shapes.get(name, shape)
            survey.own_shapes[name] = tuple(map(max, known, shape))
    if (survey.owner >= 0).all():
        survey.complete = frozenset(
            name
            for name, shape in survey.own_shapes.items()
            if all(shapes.get(name) == shape for shapes in shapes_of_blocks)
        )
    return survey


def _row_starts(sizes: NDArray[np.int32]) -> Rows:
    return np.concatenate([[0], np.cumsum(sizes, dtype=np.int64)])


class _Assembly:
    """The arrays of a dataset, flat over its points, and what they become."""

    def __init__(self, layout: Layout, survey: _Survey, scratch: Path | None = None) -> None:
        self.layout, self.survey = layout, survey
        self.scratch = scratch if 8 * layout.size * len(layout.variables) > LARGE else None
        self.arrays = {variable.name: self._empty(variable) for variable in layout.variables}
        self.starts = {group: _row_starts(sizes) for group, sizes in survey.row_sizes.items()}

    def _empty(self, variable: Variable) -> Array:
        """An array of fill values: flat over the points, then the variable's own dims."""
        if variable.ragged:
            shape: list[int] = [self.survey.row_sizes[variable.ragged].sum(dtype=np.int64)]
        else:
            points = [] if variable.role is Role.ALONG else [self.layout.size]
            shape = [*points, *map(self._dim_size, variable.dims)]
        fill, dtype = fill_value(variable), dtype_of(variable)
        if self.scratch is not None:
            return mapped(fill, tuple(map(int, shape)), dtype, self.scratch)
        if variable.name in self.survey.complete and variable.role is not Role.ALONG:
            return np.empty(shape, dtype)
        return np.full(shape, fill, dtype)

    def _dim_size(self, dim: str) -> int:
        """Size of an own dim: the longest that any variable has along it."""
        sizes = [
            self.survey.own_shapes[variable.name][variable.dims.index(dim)]
            for variable in self.layout.variables
            if dim in variable.dims and variable.name in self.survey.own_shapes
        ]
        return max(sizes, default=self._known_size(dim)) or 1

    def _known_size(self, dim: str) -> int:
        """Size of an own dim before any point is known."""
        if dim == "contact":
            return get_model(self.layout.model).contacts
        if dim == "state":
            with_velocities = any(variable.velocities for variable in self.layout.variables)
            return len(self._motions()) // (1 if with_velocities else 2)
        return 1

    def _motions(self) -> list[tuple[str, str, str, str]]:
        model = get_model(self.layout.model)
        return motions(model.states({**model.default_options(), **self.layout.options}))

    def fill(self, block: Block, positions: Rows, number: int) -> None:
        """Write the rows of block `number` that no later block replaces where they belong."""
        placed = np.flatnonzero(positions >= 0)
        rows = placed[self.survey.owner[positions[placed]] == number]
        stretches = list(_stretches(rows, positions[rows]))
        for taken, place in stretches:
            self.arrays["status"][place] = block.status[taken]
            self.arrays["reason"][place] = block.reason[taken]
        for variable in self.layout.variables:
            if variable.name in (block.ragged if variable.ragged else block.values):
                fill = self._fill_ragged if variable.ragged else self._fill_value
                for taken, place in stretches:
                    fill(variable, block, taken, place)
                let_go(self.arrays[variable.name])

    def _fill_value(self, variable: Variable, block: Block, rows: slice, place: slice) -> None:
        source, target = block.values[variable.name], self.arrays[variable.name]
        if variable.role is Role.ALONG:
            _fill_coordinate(target, source if len(source) == 1 else source[rows])
            return
        shape = (rows.stop - rows.start, *target.shape[1:])
        target[place] = padded(source[rows], shape, fill_value(variable))

    def _fill_ragged(self, variable: Variable, block: Block, rows: slice, place: slice) -> None:
        begins, starts = _row_starts(block.row_sizes[variable.ragged]), self.starts[variable.ragged]
        source = block.ragged[variable.name][begins[rows.start] : begins[rows.stop]]
        self.arrays[variable.name][starts[place.start] : starts[place.stop]] = source

    def dataset(self) -> Dataset:
        """The dataset."""
        variables = {v.name: self._variable(v) for v in self.layout.variables}
        coordinates = _coordinates(self.layout) | self._own_coordinates()
        for group, sizes in self.survey.row_sizes.items():
            count = int(sizes.sum(dtype=np.int64))
            variables[f"{group}_row_size"] = _row_size(group, self.layout, sizes)
            variables[f"{group}_point"] = self._aside(
                point_of_each(f"{group}_obs", self.layout.dim_names, sizes)
            )
            coordinates[f"{group}_obs"] = self._aside(numbered(f"{group}_obs", count))
        for variable in self.layout.variables:
            if variable.role is Role.ALONG:
                coordinates[variable.name] = variables.pop(variable.name)
        return Dataset({**variables, **coordinates}, frozenset(coordinates))

    def _aside(self, made: Labelled) -> Labelled:
        """What takes much memory, where the other arrays are."""
        if self.scratch is None:
            return made
        values = mapped(made.values, made.values.shape, made.dtype, self.scratch)
        return replace(made, values=values)

    def _variable(self, variable: Variable) -> Labelled:
        array, attributes = self.arrays[variable.name], attributes_of(variable)
        if variable.ragged:
            return Labelled((variable.sample_dim,), array, attributes)
        if variable.role is Role.ALONG:
            return Labelled(variable.dims, array, attributes)
        shaped = array.reshape((*self.layout.shape, *array.shape[1:]))
        return Labelled((*self.layout.dim_names, *variable.dims), shaped, attributes)

    def _own_coordinates(self) -> dict[str, Labelled]:
        """Of states their names and units, of contacts and all else their numbers."""
        dims = dict.fromkeys(dim for variable in self.layout.variables for dim in variable.dims)
        named = {"state", "contact", *(v.name for v in self.layout.variables)}
        coordinates = {dim: numbered(dim, self._dim_size(dim)) for dim in dims if dim not in named}
        if "state" in dims:
            names, units, *_ = zip(*self._motions()[: self._dim_size("state")], strict=True)
            coordinates["state"] = _texts("state", names, "state")
            coordinates["state_units"] = _texts("state", units, "unit")
        if "contact" in dims:
            numbers = np.arange(1, self._dim_size("contact") + 1, dtype=np.int32)
            attributes = {"units": "1", "long_name": "contact, counted from 1"}
            coordinates["contact"] = Labelled(("contact",), numbers, attributes)
        return coordinates


def _stretches(rows: Rows, positions: Rows) -> Iterator[tuple[slice, slice]]:
    """Rows that follow one another and so do their positions: those, and these."""
    cuts = np.flatnonzero((np.diff(rows) != 1) | (np.diff(positions) != 1)) + 1
    for begin, end in pairwise([0, *cuts.tolist(), len(rows)]):
        if begin < end:
            row, position = int(rows[begin]), int(positions[begin])
            count = end - begin
            yield slice(row, row + count), slice(position, position + count)


def _fill_coordinate(target: Array, candidates: Array) -> None:
    """A coordinate is the same for all points; a run that ended early has only its beginning."""
    known = np.fmax.reduce(np.where(np.isfinite(candidates), candidates, np.nan))
    place = target[: len(known)]
    place[...] = np.where(np.isnan(known), place, known)


def _row_size(group: str, layout: Layout, sizes: NDArray[np.int32]) -> Labelled:
    attributes = {
        "units": "1",
        "long_name": f"number of values along {group}_obs that belong to the point",
        "sample_dimension": f"{group}_obs",
    }
    return Labelled(layout.dim_names, sizes.reshape(layout.shape), attributes)


def point_of_each(dim: str, points: tuple[str, ...], sizes: NDArray[np.int32]) -> Labelled:
    """The point that each value along a ragged dim belongs to, of points over the dims `points`."""
    attributes = {
        "units": "1",
        "long_name": "point that the value belongs to",
        "comment": f"flat (C order) index over ({', '.join(points)}), from 0",
    }
    return Labelled((dim,), np.repeat(np.arange(len(sizes), dtype=np.int32), sizes), attributes)


def numbered(dim: str, count: int) -> Labelled:
    """Counts along a dim, by which two datasets are aligned."""
    attributes = {"units": "1", "long_name": f"number along {dim}, counted from 0"}
    return Labelled((dim,), np.arange(count, dtype=np.int32), attributes)


def attributes_of(variable: Variable) -> dict[str, object]:
    """CF attributes of a variable, ``symbol`` and ``comment``."""
    attributes: dict[str, object] = {"units": variable.units, "long_name": variable.long_name}
    if variable.symbol:
        attributes["symbol"] = variable.symbol
    if variable.comment:
        attributes["comment"] = variable.comment
    if variable.flags:
        attributes |= _flag_attributes(variable.flags)
    if variable.role not in (Role.STATUS, Role.ALONG):
        attributes["ancillary_variables"] = "status reason"
    return attributes


def _flag_attributes(table: str) -> dict[str, object]:
    """CF attributes of a flag variable."""
    codes = TABLES[table].codes
    attributes: dict[str, object] = {
        "flag_values": np.array(list(codes.values()), np.int8),
        "flag_meanings": " ".join(codes),
    }
    if table == "reason":
        attributes["comment"] = "; ".join(f"{r.name}: {r.advice}" for r in REASONS)
    return attributes


def _coordinates(layout: Layout) -> dict[str, Labelled]:
    coordinates: dict[str, Labelled] = {}
    for dim in layout.dims:
        for axis in dim.axes:
            coordinates[axis.dim] = _axis_coordinate(axis, dim.name, layout)
    if layout.labels is not None:
        coordinates["initial"] = _texts("initial", layout.labels, "start of the run")
    for name, value in layout.fixed.items():
        attributes = axis_attributes(Axis(name, "parameter", ()), layout)
        coordinates[name] = Labelled((), np.array(value), attributes)
    return coordinates


def _axis_coordinate(axis: Axis, dim: str, layout: Layout) -> Labelled:
    values = _text(axis.values) if axis.kind in ("option", "law") else np.array(axis.values, float)
    return Labelled((dim,), values, axis_attributes(axis, layout))


def axis_attributes(axis: Axis, layout: Layout) -> dict[str, str]:
    """Unit, meaning, symbol and role of an axis; symbols of parameters that follow it, too."""
    if axis.kind == "parameter":
        parameter, (*_, leaders) = _parameter(axis.name, layout), terms_of(layout.model)
        following = [name for name, leader in leaders.items() if leader == axis.name]
        symbols = [parameter.symbol, *(_parameter(name, layout).symbol for name in following)]
        role = {"role": parameter.role} if parameter.role else {}
        return _attributes(parameter.unit, parameter.meaning, " = ".join(symbols)) | role
    if axis.kind == "start":
        table = get_model(layout.model)
        states = motions(table.states(table.default_options()))
        named = {name: rest for name, *rest in states}
        unit, symbol, meaning = named[axis.name.removeprefix("initial.")]
        return _attributes(unit, f"start: {meaning}", symbol)
    return {"long_name": "friction law" if axis.kind == "law" else axis.name}


def _attributes(unit: str, meaning: str, symbol: str) -> dict[str, str]:
    return {"units": unit, "long_name": meaning, "symbol": symbol}


def _parameter(name: str, layout: Layout) -> Parameter:
    """The parameter of the model or of one of the laws in use."""
    laws = (get_law(law).parameters for law in layout.laws)
    tables = [get_model(layout.model).parameters, *laws]
    return next(p for table in tables for p in table if p.name == name)


def _texts(dim: str, names: Iterable[str], meaning: str) -> Labelled:
    return Labelled((dim,), _text(names), {"long_name": meaning})


def _text(names: Iterable[str]) -> Array:
    return np.array([str(name) for name in names], dtype=np.str_)
