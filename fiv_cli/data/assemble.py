"""From blocks of outcomes to one dataset.

Blocks are read one at a time and written into arrays of the final type, by the position of each
point: workers, chunks and order leave no trace, and memory is that of the dataset.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from fiv_cli.analyses.variables import Role, Variable, motions
from fiv_cli.case.case import Axis
from fiv_cli.data.block import Array, Block, dtype_of, fill_value, padded
from fiv_cli.data.layout import Layout
from fiv_cli.data.modes import follow_modes
from fiv_cli.flags import REASONS, TABLES
from fiv_cli.models import get_model
from fiv_cli.models.base import Parameter

Placed = tuple[NDArray[np.int64], Block]
"""Positions of the rows of a block (negative: not part of the dataset), and the block."""

Blocks = Callable[[], Iterable[Placed]]


@dataclass
class _Survey:
    """What a first pass over the blocks finds.

    Attributes
    ----------
    owner : (size,) number of the last block that holds each point; -1: none
    row_sizes : ragged group -> (size,) rows of each point
    own_shapes : variable -> largest shape of its own dims
    """

    owner: NDArray[np.int32]
    row_sizes: dict[str, NDArray[np.int32]] = field(default_factory=dict)
    own_shapes: dict[str, tuple[int, ...]] = field(default_factory=dict)


def assemble(layout: Layout, blocks: Blocks) -> xr.Dataset:
    """The dataset of one analysis.

    Parameters
    ----------
    layout : dims, coordinates and variables
    blocks : gives an iterator over the placed blocks, twice the same; where two blocks hold the
        same point the later one counts

    Returns
    -------
    xarray.Dataset without global attributes; points that no block holds are ``pending``
    """
    survey = _survey(layout, blocks)
    arrays = _allocated(layout, survey)
    starts = {group: _row_starts(sizes) for group, sizes in survey.row_sizes.items()}
    for number, (positions, block) in enumerate(blocks()):
        rows = _owned_rows(survey.owner, positions, number)
        _fill(layout, arrays, starts, block, positions, rows)
    dataset = _dataset(layout, arrays, survey)
    return follow_modes(dataset) if layout.kind == "eigenvalues" else dataset


def _survey(layout: Layout, blocks: Blocks) -> _Survey:
    survey = _Survey(np.full(layout.size, -1, np.int32))
    for variable in layout.variables:
        if variable.ragged:
            survey.row_sizes[variable.ragged] = np.zeros(layout.size, np.int32)
    for number, (positions, block) in enumerate(blocks()):
        placed = positions >= 0
        survey.owner[positions[placed]] = number
        for group, sizes in block.row_sizes.items():
            survey.row_sizes[group][positions[placed]] = sizes[placed]
        for name, array in block.values.items():
            known = survey.own_shapes.get(name, array.shape[1:])
            survey.own_shapes[name] = tuple(map(max, known, array.shape[1:]))
    return survey


def _owned_rows(
    owner: NDArray[np.int32], positions: NDArray[np.int64], number: int
) -> NDArray[np.int64]:
    """Rows of block `number` that no later block replaces."""
    placed = np.flatnonzero(positions >= 0)
    return placed[owner[positions[placed]] == number]


def _row_starts(sizes: NDArray[np.int32]) -> NDArray[np.int64]:
    return np.concatenate([[0], np.cumsum(sizes, dtype=np.int64)])


def _allocated(layout: Layout, survey: _Survey) -> dict[str, Array]:
    return {v.name: _empty(v, layout, survey) for v in layout.variables}


def _empty(variable: Variable, layout: Layout, survey: _Survey) -> Array:
    """An array of fill values: flat over the points, then the variable's own dims."""
    if variable.ragged:
        shape: tuple[int, ...] = (int(survey.row_sizes[variable.ragged].sum(dtype=np.int64)),)
    elif variable.role is Role.ALONG:
        shape = _own_shape(variable, layout, survey)
    else:
        shape = (layout.size, *_own_shape(variable, layout, survey))
    return np.full(shape, fill_value(variable), dtype_of(variable))


def _own_shape(variable: Variable, layout: Layout, survey: _Survey) -> tuple[int, ...]:
    """Sizes of the own dims: the longest that any variable has along each."""
    return tuple(_dim_size(dim, layout, survey) for dim in variable.dims)


def _dim_size(dim: str, layout: Layout, survey: _Survey) -> int:
    found = [
        survey.own_shapes[variable.name][variable.dims.index(dim)]
        for variable in layout.variables
        if dim in variable.dims and variable.name in survey.own_shapes
    ]
    return max(found, default=_known_size(dim, layout)) or 1


def _known_size(dim: str, layout: Layout) -> int:
    """Size of an own dim before any point is known."""
    model = get_model(layout.model)
    if dim == "contact":
        return model.contacts
    if dim == "state":
        displacements = len(model.states({**model.default_options(), **layout.options}))
        return displacements * (1 + any(v.velocities for v in layout.variables))
    return 1


def _fill(
    layout: Layout,
    arrays: dict[str, Array],
    starts: dict[str, NDArray[np.int64]],
    block: Block,
    positions: NDArray[np.int64],
    rows: NDArray[np.int64],
) -> None:
    """Write the given rows of a block where they belong."""
    targets = positions[rows]
    arrays["status"][targets] = block.status[rows]
    arrays["reason"][targets] = block.reason[rows]
    for variable in layout.variables:
        if variable.ragged:
            _fill_ragged(arrays, starts, block, variable, targets, rows)
        elif variable.name in block.values:
            _fill_value(arrays[variable.name], block.values[variable.name], variable, targets, rows)


def _fill_value(
    target: Array,
    source: Array,
    variable: Variable,
    targets: NDArray[np.int64],
    rows: NDArray[np.int64],
) -> None:
    if variable.role is Role.ALONG:
        _fill_coordinate(target, source[rows])
        return
    shape = target.shape[1:]
    target[targets] = padded(source[rows], (len(rows), *shape), fill_value(variable))


def _fill_coordinate(target: Array, candidates: Array) -> None:
    """A coordinate is the same for all points; a run that ended early has only its beginning."""
    for candidate in candidates:
        known = np.isfinite(candidate)
        target[: len(candidate)][known] = candidate[known]


def _fill_ragged(
    arrays: dict[str, Array],
    starts: dict[str, NDArray[np.int64]],
    block: Block,
    variable: Variable,
    targets: NDArray[np.int64],
    rows: NDArray[np.int64],
) -> None:
    if variable.name not in block.ragged:
        return
    begins = _row_starts(block.row_sizes[variable.ragged])
    source, target = block.ragged[variable.name], arrays[variable.name]
    for row, position in zip(rows, targets, strict=True):
        piece = source[begins[row] : begins[row + 1]]
        begin = starts[variable.ragged][position]
        target[begin : begin + len(piece)] = piece


def _dataset(layout: Layout, arrays: dict[str, Array], survey: _Survey) -> xr.Dataset:
    variables = {v.name: _variable(v, layout, arrays[v.name]) for v in layout.variables}
    for group, sizes in survey.row_sizes.items():
        variables[f"{group}_row_size"] = _row_size(group, layout, sizes)
    own_dims = {dim for v in layout.variables for dim in v.dims}
    coordinates = _coordinates(layout)
    coordinates |= _own_coordinates(layout, own_dims, survey)
    coordinates |= {v.name: variables.pop(v.name) for v in layout.variables if v.role is Role.ALONG}
    return xr.Dataset(variables, coords=coordinates)


def _variable(variable: Variable, layout: Layout, array: Array) -> xr.Variable:
    if variable.ragged:
        return xr.Variable((variable.sample_dim,), array, attributes_of(variable))
    if variable.role is Role.ALONG:
        return xr.Variable(variable.dims, array, attributes_of(variable))
    shaped = array.reshape((*layout.shape, *array.shape[1:]))
    return xr.Variable((*layout.dim_names, *variable.dims), shaped, attributes_of(variable))


def _row_size(group: str, layout: Layout, sizes: NDArray[np.int32]) -> xr.Variable:
    attributes = {
        "units": "1",
        "long_name": f"number of values along {group}_obs that belong to the point",
        "sample_dimension": f"{group}_obs",
    }
    return xr.Variable(layout.dim_names, sizes.reshape(layout.shape), attributes)


def attributes_of(variable: Variable) -> dict[str, Any]:
    """CF attributes of a variable, ``symbol`` and ``comment``."""
    attributes: dict[str, Any] = {"units": variable.units, "long_name": variable.long_name}
    if variable.symbol:
        attributes["symbol"] = variable.symbol
    if variable.comment:
        attributes["comment"] = variable.comment
    if variable.flags:
        attributes |= _flag_attributes(variable.flags)
    if variable.role not in (Role.STATUS, Role.ALONG):
        attributes["ancillary_variables"] = "status reason"
    return attributes


def _flag_attributes(table: str) -> dict[str, Any]:
    """CF attributes of a flag variable."""
    codes = TABLES[table].codes
    attributes: dict[str, Any] = {
        "flag_values": np.array(list(codes.values()), np.int8),
        "flag_meanings": " ".join(codes),
    }
    if table == "reason":
        attributes["comment"] = "; ".join(f"{r.name}: {r.advice}" for r in REASONS)
    return attributes


def _coordinates(layout: Layout) -> dict[str, xr.Variable]:
    coordinates = {}
    for dim in layout.dims:
        for axis in dim.axes:
            coordinates[axis.dim] = _axis_coordinate(axis, dim.name, layout.model)
    if layout.labels is not None:
        attributes = {"long_name": "start of the run", "units": "1"}
        coordinates["initial"] = xr.Variable(("initial",), _text(layout.labels), attributes)
    return coordinates


def _axis_coordinate(axis: Axis, dim: str, model: str) -> xr.Variable:
    values = _text(axis.values) if axis.kind in ("option", "law") else np.array(axis.values, float)
    return xr.Variable((dim,), values, _axis_attributes(axis, model))


def _axis_attributes(axis: Axis, model: str) -> dict[str, Any]:
    """Unit, meaning and symbol of an axis."""
    if axis.kind == "parameter":
        return _parameter_attributes(_parameter(axis.name, model))
    if axis.kind == "start":
        return _start_attributes(axis, model)
    return {"units": "1", "long_name": "friction law" if axis.kind == "law" else axis.name}


def _parameter_attributes(parameter: Parameter) -> dict[str, Any]:
    return {
        "units": parameter.unit,
        "long_name": parameter.meaning,
        "symbol": parameter.symbol,
    }


def _parameter(name: str, model: str) -> Parameter:
    """The parameter of the model or of one of its laws."""
    from fiv_cli.friction import get_law

    tables = [get_model(model).parameters, *(get_law(n).parameters for n in get_model(model).laws)]
    return next(p for table in tables for p in table if p.name == name)


def _start_attributes(axis: Axis, model: str) -> dict[str, Any]:
    state = axis.name.removeprefix("initial.")
    table = get_model(model)
    for name, unit, symbol, meaning in motions(table.states(table.default_options())):
        if name == state:
            return {"units": unit, "long_name": f"start: {meaning}", "symbol": symbol}
    raise KeyError(state)


def _own_coordinates(layout: Layout, dims: set[str], survey: _Survey) -> dict[str, xr.Variable]:
    coordinates: dict[str, xr.Variable] = {}
    if "state" in dims:
        coordinates |= _state_coordinates(layout, _dim_size("state", layout, survey))
    if "contact" in dims:
        numbers = np.arange(1, _dim_size("contact", layout, survey) + 1, dtype=np.int32)
        attributes = {"units": "1", "long_name": "contact, counted from 1"}
        coordinates["contact"] = xr.Variable(("contact",), numbers, attributes)
    return coordinates


def _state_coordinates(layout: Layout, size: int) -> dict[str, xr.Variable]:
    """Names and units along the dim ``state``: displacements, then velocities."""
    model = get_model(layout.model)
    known = motions(model.states({**model.default_options(), **layout.options}))[:size]
    return {
        "state": xr.Variable(
            ("state",), _text([k[0] for k in known]), {"units": "1", "long_name": "state"}
        ),
        "state_units": xr.Variable(
            ("state",), _text([k[1] for k in known]), {"units": "1", "long_name": "unit"}
        ),
    }


def _text(names: Iterable[str]) -> Array:
    return np.array([str(name) for name in names], dtype=np.str_)
