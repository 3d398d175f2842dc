"""A block: the outcomes of many points as arrays, as workers return and shards store them."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fiv_cli.analyses.base import Outcome
from fiv_cli.analyses.variables import INT_FILL, Role, Variable
from fiv_cli.flags import STATUS, TABLES, reason_code

KEY_BYTES = 32

Array = NDArray[Any]


@dataclass
class Block:
    """Outcomes of n points.

    Attributes
    ----------
    keys : (n, 32) uint8, sha256 of what decides each point
    status, reason : (n,) int8, codes of `flags.STATUS` and `flags.REASON`
    values : variable -> (n, ...) array, padded with the fill value; absent: no point has it
    row_sizes : ragged group -> (n,) int32
    ragged : ragged variable -> concatenated rows
    messages : row -> details
    carries : row -> what a continuing neighbour needs, plain data
    """

    keys: Array
    status: Array
    reason: Array
    values: dict[str, Array] = field(default_factory=dict)
    row_sizes: dict[str, Array] = field(default_factory=dict)
    ragged: dict[str, Array] = field(default_factory=dict)
    messages: dict[int, str] = field(default_factory=dict)
    carries: dict[int, dict[str, Any]] = field(default_factory=dict)

    def __len__(self) -> int:
        return len(self.status)

    @property
    def nbytes(self) -> int:
        """Memory that the arrays take."""
        tables = self.values, self.row_sizes, self.ragged
        arrays = [array for table in tables for array in table.values()]
        return sum(array.nbytes for array in (self.keys, self.status, self.reason, *arrays))


def pack(
    outcomes: Sequence[Outcome],
    keys: Sequence[bytes],
    variables: Sequence[Variable],
    carries: Mapping[int, dict[str, Any]] | None = None,
) -> Block:
    """Outcomes as arrays.

    An outcome that cannot be stored (a variable that is not in the table, a wrong shape) becomes
    a failed one, with the reason in its message: one bad point never loses the others.

    Parameters
    ----------
    outcomes, keys : one per point; each key has 32 bytes
    variables : the variables of the analysis
    carries : row -> plain data for a continuing neighbour
    """
    stored = [variable for variable in variables if variable.role is not Role.STATUS]
    columns = {(v.name, bool(v.ragged)): _Column.of(v) for v in stored}
    checked = [_storable(outcome, columns) for outcome in outcomes]
    block = Block(
        keys=np.frombuffer(b"".join(keys), np.uint8).reshape(len(keys), KEY_BYTES),
        status=np.array([STATUS.codes[outcome.status] for outcome in checked], np.int8),
        reason=np.array([reason_code(outcome.reason) for outcome in checked], np.int8),
        messages={row: o.message for row, o in enumerate(checked) if o.message},
        carries=dict(carries or {}),
    )
    for variable in stored:
        if not variable.ragged:
            _pack_value(block, checked, variable)
    _pack_groups(block, checked, stored)
    return block


def fault_of_block(block: Block, variables: Sequence[Variable]) -> str:
    """What is wrong with the form of a stored block; empty where it is what `pack` makes."""
    return next(_faults(block, {v.name: v for v in variables}), "")


def _faults(block: Block, table: Mapping[str, Variable]) -> Iterator[str]:
    count = len(block.status)
    if block.keys.dtype != np.uint8 or block.keys.shape != (count, KEY_BYTES):
        yield "its keys have another form"
    for name, array in (("status", block.status), ("reason", block.reason)):
        codes = list(TABLES[name].codes.values())
        if array.dtype != np.int8 or array.shape != (count,) or not np.isin(array, codes).all():
            yield f"{name} holds what no point has"
    if any(row not in range(count) for row in (*block.messages, *block.carries)):
        yield "it tells of rows that it has not"
    if not all(isinstance(message, str) for message in block.messages.values()):
        yield "its messages are no texts"
    yield from _faults_of_values(block, table, count)
    yield from _faults_of_rows(block, table, count)


def _faults_of_values(block: Block, table: Mapping[str, Variable], count: int) -> Iterator[str]:
    for name, array in block.values.items():
        variable = table.get(name)
        if variable is None or variable.ragged:
            yield f"{name} is no variable of the analysis"
        elif array.shape[:1] != (count,) or array.ndim != 1 + len(variable.dims):
            yield f"{name} has the shape {array.shape}"
        else:
            yield from _faults_of_array(array, variable)


def _faults_of_rows(block: Block, table: Mapping[str, Variable], count: int) -> Iterator[str]:
    groups = {variable.ragged for variable in table.values() if variable.ragged}
    for group, sizes in block.row_sizes.items():
        if group not in groups or sizes.shape != (count,) or sizes.dtype != np.int32:
            yield f"the rows of {group} have another form"
        elif (sizes < 0).any():
            yield f"rows of {group} have a negative length"
    for name, array in block.ragged.items():
        variable = table.get(name)
        if variable is None or variable.ragged not in block.row_sizes:
            yield f"{name} is no variable of the analysis"
            continue
        total = int(block.row_sizes[variable.ragged].sum(dtype=np.int64))
        if array.shape != (total,):
            yield f"{name} has the shape {array.shape}"
        else:
            yield from _faults_of_array(array, variable)


def _faults_of_array(array: Array, variable: Variable) -> Iterator[str]:
    codes = list(TABLES[variable.flags].codes.values()) if variable.flags else []
    if array.dtype != dtype_of(variable):
        yield f"{variable.name} is of type {array.dtype}"
    elif codes and not np.isin(array, codes).all():
        yield f"{variable.name} holds what is no class"


def fill_value(variable: Variable) -> float | int:
    """What stands where nothing was computed."""
    if variable.kind == "int":
        return INT_FILL
    if variable.kind == "flag":
        return TABLES[variable.flags].fill_code
    return float("nan")


def dtype_of(variable: Variable) -> np.dtype[Any]:
    """Data type of a variable in shards and datasets."""
    return np.dtype({"int": "int32", "flag": "int8"}.get(variable.kind, "float64"))


def padded(array: Array, shape: tuple[int, ...], fill: float | int) -> Array:
    """`array` enlarged to `shape` with `fill` behind its ends; unchanged where it fits."""
    if array.shape == shape:
        return array
    result = np.full(shape, fill, array.dtype)
    result[tuple(slice(size) for size in array.shape)] = array
    return result


@dataclass(frozen=True)
class _Column:
    """How the values of a variable are stored, settled once for many points."""

    variable: Variable
    dtype: np.dtype[Any]
    codes: Mapping[str, int]
    ndim: int

    @classmethod
    def of(cls, variable: Variable) -> _Column:
        codes = TABLES[variable.flags].codes if variable.flags else {}
        ndim = 1 if variable.ragged else len(variable.dims)
        return cls(variable, dtype_of(variable), codes, ndim)

    def converted(self, value: object) -> Array | float | int:
        """A value of one point: an array of the column's type, or a plain number.

        Most values are plain already; an array for each would cost more than a cheap model.
        """
        if self.ndim == 0 and self.dtype.kind == "f" and isinstance(value, float):
            return value
        if self.ndim == 0 and type(value) is str and self.codes:
            return self.codes[value]
        array = np.asarray(value)
        if array.dtype != self.dtype:
            array = self._cast(array)
        if array.ndim != self.ndim:
            name, dims = self.variable.name, self.variable.dims or self.ndim
            raise ValueError(f"{name} has {array.ndim} dims instead of {dims}")
        return array

    def _cast(self, array: Array) -> Array:
        if array.dtype.kind in "US":
            names = [self.codes[str(name)] for name in array.ravel()]
            array = np.array(names).reshape(array.shape)
        if self.variable.kind == "int" and array.dtype.kind == "f":
            array = np.where(np.isnan(array), INT_FILL, array)
        return array.astype(self.dtype, casting="unsafe")


_Columns = Mapping[tuple[str, bool], _Column]
"""By name, and whether it is ragged."""


def _storable(outcome: Outcome, columns: _Columns) -> Outcome:
    """`outcome` with plain arrays of the table's types, or a failed outcome that says why not."""
    try:
        return _converted(outcome, columns)
    except (KeyError, TypeError, ValueError, OverflowError) as error:
        message = f"the result cannot be stored: {type(error).__name__}: {error}"
        return Outcome("failed", "internal_error", message=message)


def _converted(outcome: Outcome, columns: _Columns) -> Outcome:
    if outcome.status not in STATUS.codes:
        raise ValueError(f"unknown status {outcome.status!r}")
    reason_code(outcome.reason)
    values = {
        name: _column(columns, name, False).converted(value)
        for name, value in outcome.values.items()
        if not _sums_up(name, value, columns)
    }
    rows = {
        name: _column(columns, name, True).converted(value)
        for name, value in outcome.ragged.items()
    }
    _check_rows(rows, columns)
    return Outcome(outcome.status, outcome.reason, values, rows, outcome.message)


def _sums_up(name: str, value: Any, columns: _Columns) -> bool:
    """Whether a value is the summary of what a ragged variable holds row by row: not stored.

    Raises
    ------
    TypeError
        it is the rows themselves.
    """
    if (name, True) not in columns:
        return False
    if np.ndim(value) > 0:
        raise TypeError(f"{name} is ragged: it goes into Outcome.ragged, not into Outcome.values")
    return True


def _column(columns: _Columns, name: str, ragged: bool) -> _Column:
    if (name, ragged) not in columns:
        kind = "ragged variables" if ragged else "variables"
        raise KeyError(f"{name} is not among the {kind} that the analysis declares")
    return columns[name, ragged]


def _check_rows(rows: Mapping[str, Any], columns: _Columns) -> None:
    sizes: dict[str, int] = {}
    for name, row in rows.items():
        group = columns[name, True].variable.ragged
        if sizes.setdefault(group, len(row)) != len(row):
            raise ValueError(f"the rows of the group {group!r} differ in length")


def _pack_value(block: Block, outcomes: Sequence[Outcome], variable: Variable) -> None:
    """Stack one variable over the points; nothing where no point has it."""
    values = [outcome.values.get(variable.name) for outcome in outcomes]
    if all(value is None for value in values):
        return
    fill = fill_value(variable)
    if not variable.dims:
        plain = [fill if value is None else value for value in values]
        block.values[variable.name] = np.array(plain, dtype_of(variable))
        return
    shapes = {None if array is None else array.shape for array in values}
    if len(shapes) == 1:
        block.values[variable.name] = np.array(values)
        return
    largest = tuple(max(sizes) for sizes in zip(*(shapes - {None}), strict=True))
    stack = np.full((len(values), *largest), fill, dtype_of(variable))
    for row, array in enumerate(values):
        if array is not None:
            place: tuple[Any, ...] = (row, *(slice(size) for size in array.shape))
            stack[place] = array
    block.values[variable.name] = stack


def _pack_groups(block: Block, outcomes: Sequence[Outcome], variables: Sequence[Variable]) -> None:
    """Concatenate the ragged variables over the points, group by group."""
    groups: dict[str, list[Variable]] = {}
    for variable in variables:
        if variable.ragged:
            groups.setdefault(variable.ragged, []).append(variable)
    for group, members in groups.items():
        sizes = np.array([_group_size(outcome, members) for outcome in outcomes], np.int32)
        block.row_sizes[group] = sizes
        for variable in members:
            block.ragged[variable.name] = _concatenated(outcomes, sizes, variable)


def _group_size(outcome: Outcome, members: Sequence[Variable]) -> int:
    return max(len(outcome.ragged.get(variable.name, ())) for variable in members)


def _concatenated(outcomes: Sequence[Outcome], sizes: Array, variable: Variable) -> Array:
    empty = np.empty(0, dtype_of(variable))
    rows = [
        padded(outcome.ragged.get(variable.name, empty), (int(size),), fill_value(variable))
        for outcome, size in zip(outcomes, sizes, strict=True)
    ]
    return np.concatenate(rows) if rows else empty


def to_plain(value: Any) -> Any:
    """Nested dicts, lists, numbers and arrays as JSON data without loss."""
    if isinstance(value, np.ndarray):
        return {"__array__": value.tolist(), "dtype": value.dtype.str, "shape": list(value.shape)}
    if isinstance(value, np.generic):
        return value.item()
    if isinstance(value, Mapping):
        return {str(key): to_plain(item) for key, item in value.items()}
    if isinstance(value, tuple | list):
        return [to_plain(item) for item in value]
    return value


def from_plain(value: Any) -> Any:
    """Inverse of `to_plain` (tuples come back as lists)."""
    if isinstance(value, dict) and "__array__" in value:
        return np.array(value["__array__"], value["dtype"]).reshape(value["shape"])
    if isinstance(value, dict):
        return {key: from_plain(item) for key, item in value.items()}
    if isinstance(value, list):
        return [from_plain(item) for item in value]
    return value
