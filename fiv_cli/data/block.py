"""A block: the outcomes of many points as arrays, as workers return and shards store them."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from itertools import groupby
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fiv_cli.analyses.base import Columns, Outcome
from fiv_cli.analyses.variables import INT_FILL, Role, Variable
from fiv_cli.flags import STATUS, TABLES, reason_code

KEY_BYTES = 32

Array = NDArray[Any]
Rows = slice | list[int]


@dataclass
class Block:
    """Outcomes of n points.

    Attributes
    ----------
    keys : (n, 32) uint8, sha256 of what decides each point
    status, reason : (n,) int8, codes of `flags.STATUS` and `flags.REASON`
    values : variable -> (n, ...) array, padded with the fill value; absent: no point has it; of a
        coordinate that all points share one row
    row_sizes : ragged group -> (n,) int32
    ragged : ragged variable -> concatenated rows
    messages : row -> details
    carries : row -> what a continuing neighbour needs, plain data
    seconds : (n,) float32, about how long each point took
    plan, positions : digest of a plan, and (n,) int64 where the points lie in it (-1: nowhere),
        which spares whoever has that plan the search by keys; empty: not known
    """

    keys: Array
    status: Array
    reason: Array
    values: dict[str, Array] = field(default_factory=dict)
    row_sizes: dict[str, Array] = field(default_factory=dict)
    ragged: dict[str, Array] = field(default_factory=dict)
    messages: dict[int, str] = field(default_factory=dict)
    carries: dict[int, dict[str, Any]] = field(default_factory=dict)
    seconds: Array = field(default_factory=lambda: np.zeros(0, np.float32))
    plan: bytes = b""
    positions: Array = field(default_factory=lambda: np.zeros(0, np.int64))

    def __post_init__(self) -> None:
        if not len(self.seconds):
            self.seconds = np.zeros(len(self.status), np.float32)

    def __len__(self) -> int:
        return len(self.status)

    @property
    def shapes(self) -> dict[str, tuple[int, ...]]:
        """Variable -> shape of its own dims."""
        return {name: array.shape[1:] for name, array in self.values.items()}

    def block(self) -> Block:
        """Itself, as of a stored block."""
        return self

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
    table = _Table.of(variables)
    try:
        block = _stacked(outcomes, table)
    except UNSTORABLE:  # of one of them: which is found alone
        block = _stacked([_storable(outcome, table) for outcome in outcomes], table)
    block.keys = np.frombuffer(b"".join(keys), np.uint8).reshape(len(keys), KEY_BYTES)
    block.carries = dict(carries or {})
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
    if block.seconds.dtype != np.float32 or block.seconds.shape != (count,):
        yield "its costs have another form"
    if block.positions.dtype != np.int64 or block.positions.shape not in ((0,), (count,)):
        yield "its positions have another form"
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
        elif array.ndim != 1 + len(variable.dims) or not _has_rows(array, variable, count):
            yield f"{name} has the shape {array.shape}"
        else:
            yield from _faults_of_array(array, variable)


def _has_rows(array: Array, variable: Variable, count: int) -> bool:
    return len(array) == count or (len(array) == 1 and variable.role is Role.ALONG)


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

    def joined(self, parts: Sequence[tuple[Rows, Array]], size: int) -> Array:
        """The values of `size` points, of which each part has some rows; fill values elsewhere."""
        if any(array.ndim != self.ndim + 1 for _, array in parts):
            raise ValueError(f"{self.variable.name} has not {self.ndim} dims")
        shapes = {array.shape[1:] for _, array in parts}
        if self.variable.role is Role.ALONG and _is_shared([rows for _, rows in parts]):
            return self._cast(parts[0][1][:1].copy())
        if len(parts) == 1 and len(parts[0][1]) == size and parts[0][1].flags.owndata:
            return parts[0][1]
        largest = tuple(map(max, zip(*shapes, strict=True)))
        whole = np.empty((size, *largest), self.dtype)
        if len(shapes) > 1 or sum(len(array) for _, array in parts) < size:
            whole[...] = fill_value(self.variable)
        for rows, array in parts:
            whole[(rows, *map(slice, array.shape[1:]))] = self._cast(array)
        return whole

    def stacked(self, values: Sequence[object]) -> Array:
        """The values of some points."""
        if self.ndim == 0:
            return self._plain(list(values))
        arrays = [self.converted(value) for value in values]
        if len({array.shape for array in arrays}) == 1:
            return np.array(arrays)
        return self.joined([([row], array[None]) for row, array in enumerate(arrays)], len(arrays))

    def _plain(self, values: list[Any]) -> Array:
        """Numbers and names; an array for each would cost more than a cheap model."""
        if self.codes:
            values = [self.codes[value] if type(value) is str else value for value in values]
        if {*map(type, values)} <= PLAIN[self.dtype.kind]:
            return np.array(values).astype(self.dtype, casting="unsafe")
        return np.array([self.converted(value) for value in values])

    def converted(self, value: object) -> Array:
        """A value of one point as an array of the column's type."""
        array = self._cast(np.asarray(value))
        if array.ndim != self.ndim:
            name, dims = self.variable.name, self.variable.dims or self.ndim
            raise ValueError(f"{name} has {array.ndim} dims instead of {dims}")
        return array

    def _cast(self, array: Array) -> Array:
        if array.dtype == self.dtype:
            return array
        if array.dtype.kind in "US":
            names = [self.codes[str(name)] for name in array.ravel()]
            array = np.array(names).reshape(array.shape)
        if self.variable.kind == "int" and array.dtype.kind == "f":
            array = np.where(np.isnan(array), INT_FILL, array)
        return array.astype(self.dtype, casting="unsafe")


def _is_shared(parts: Sequence[Array]) -> bool:
    """Whether all rows of all parts are the same."""
    first, different = parts[0][:1], [rows[:1] if rows.strides[0] == 0 else rows for rows in parts]
    return all(rows.shape[1:] == first.shape[1:] and (rows == first).all() for rows in different)


UNSTORABLE = (KeyError, TypeError, ValueError, OverflowError)
"""What a value raises that is none of its variable's."""

PLAIN: Mapping[str, set[type]] = {"f": {float, np.float64}, "i": {int}}
"""Kind of a column -> types whose values it takes as they are."""


@dataclass(frozen=True)
class _Table:
    """The columns of an analysis.

    Attributes
    ----------
    values : of variables that a point has one value of
    groups : ragged group -> columns of its variables
    """

    values: Mapping[str, _Column]
    groups: Mapping[str, Mapping[str, _Column]]

    @classmethod
    def of(cls, variables: Sequence[Variable]) -> _Table:
        columns = [_Column.of(v) for v in variables if v.role is not Role.STATUS]
        groups: dict[str, dict[str, _Column]] = {}
        for column in columns:
            if column.variable.ragged:
                groups.setdefault(column.variable.ragged, {})[column.variable.name] = column
        plain = {one.variable.name: one for one in columns if not one.variable.ragged}
        return cls(plain, groups)

    def check(self, outcomes: Sequence[Outcome | Columns]) -> None:
        """KeyError, TypeError: a value has no column, or rows stand where their summary would."""
        rows = {name for group in self.groups.values() for name in group}
        _refuse(
            "variables", {n for outcome in outcomes for n in outcome.values} - {*self.values} - rows
        )
        _refuse("ragged variables", {n for outcome in outcomes for n in outcome.ragged} - rows)
        for name in rows - {*self.values}:
            if any(np.ndim(one.values[name]) > 0 for one in outcomes if name in one.values):
                raise TypeError(
                    f"{name} is ragged: it goes into Outcome.ragged, not into Outcome.values"
                )


def _refuse(kind: str, names: set[str]) -> None:
    if names:
        raise KeyError(f"{min(names)} is not among the {kind} that the analysis declares")


def _storable(outcome: Outcome, table: _Table) -> Outcome:
    """`outcome`, or a failed outcome that says why it cannot be stored."""
    try:
        _stacked([outcome], table)
    except UNSTORABLE as error:
        message = f"the result cannot be stored: {type(error).__name__}: {error}"
        return Outcome("failed", "internal_error", message=message)
    return outcome


def _stacked(outcomes: Sequence[Outcome], table: _Table) -> Block:
    """The arrays of outcomes, without keys."""
    runs = list(_runs(outcomes))
    table.check([*outcomes, *(run.columns for run in runs if run.columns is not None)])
    block = Block(
        keys=np.zeros((0, KEY_BYTES), np.uint8),
        status=np.array([STATUS.codes[outcome.status] for outcome in outcomes], np.int8),
        reason=np.array([reason_code(outcome.reason) for outcome in outcomes], np.int8),
        messages={row: o.message for row, o in enumerate(outcomes) if o.message},
    )
    told = [(row, outcome.values) for row, outcome in enumerate(outcomes) if outcome.values]
    for name, column in table.values.items():
        parts: list[tuple[Rows, Array]] = [
            (run.rows, run.values[name]) for run in runs if name in run.values
        ]
        own = [(row, values[name]) for row, values in told if values.get(name) is not None]
        if own:
            rows, values = zip(*own, strict=True)
            parts.append((list(rows), column.stacked(values)))
        if parts:
            block.values[name] = column.joined(parts, len(outcomes))
    for group, columns in table.groups.items():
        counts, rows = zip(*(run.ragged(group, columns) for run in runs), strict=True)
        block.row_sizes[group] = np.concatenate(counts)
        for name in columns:
            block.ragged[name] = np.concatenate([some[name] for some in rows])
    return block


@dataclass(frozen=True)
class _Run:
    """Outcomes that follow one another, without columns, or with the rows of the same that do so.

    Attributes
    ----------
    outcomes : these
    rows : which rows of the block they become
    """

    outcomes: Sequence[Outcome]
    rows: slice

    @property
    def columns(self) -> Columns | None:
        """The columns, if any."""
        return self.outcomes[0].columns

    @property
    def _places(self) -> slice:
        first = self.outcomes[0].row
        return slice(first, first + len(self.outcomes))

    @cached_property
    def values(self) -> dict[str, Array]:
        """Their rows of the columns."""
        if self.columns is None:
            return {}
        return {name: array[self._places] for name, array in self.columns.values.items()}

    def ragged(self, group: str, table: Mapping[str, _Column]) -> tuple[Array, dict[str, Array]]:
        """How many rows of a ragged group each has, and these, one after the other."""
        if self.columns is None or not table.keys() & self.columns.ragged.keys():
            return _concatenated(self.outcomes, group, table)
        lengths, places = self.columns.lengths, self._places
        begin, end = lengths[: places.start].sum(), lengths[: places.stop].sum()
        columns = self.columns.ragged
        return lengths[places].astype(np.int32), {
            name: column.converted(columns[name][begin:end]) for name, column in table.items()
        }


def _runs(outcomes: Sequence[Outcome]) -> Iterator[_Run]:
    """Outcomes cut to pieces that can be taken at once."""

    def piece(row: int) -> tuple[int, int]:
        outcome = outcomes[row]
        return (0, 0) if outcome.columns is None else (id(outcome.columns), outcome.row - row)

    for _, rows in groupby(range(len(outcomes)), piece):
        first, *rest = rows
        place = slice(first, first + 1 + len(rest))
        yield _Run(outcomes[place], place)


def _concatenated(
    outcomes: Sequence[Outcome], group: str, columns: Mapping[str, _Column]
) -> tuple[Array, dict[str, Array]]:
    """As `_Run.ragged`, of outcomes without columns."""
    if not any(outcome.ragged for outcome in outcomes):
        none = {name: np.empty(0, column.dtype) for name, column in columns.items()}
        return np.zeros(len(outcomes), np.int32), none
    found = {
        name: [None if (rows := outcome.ragged.get(name)) is None else column.converted(rows)
               for outcome in outcomes]
        for name, column in columns.items()
    }  # fmt: skip
    sizes = [
        {len(rows) for rows in given if rows is not None}
        for given in zip(*found.values(), strict=True)
    ]
    if any(len(some) > 1 for some in sizes):
        raise ValueError(f"the rows of the group {group!r} differ in length")
    counts = np.array([sum(some) for some in sizes], np.int32)
    return counts, {
        name: _end_to_end(found[name], counts, column) for name, column in columns.items()
    }


def _end_to_end(given: Sequence[Array | None], counts: Array, column: _Column) -> Array:
    fill, dtype = fill_value(column.variable), column.dtype
    rows = [
        np.full(count, fill, dtype) if rows is None else rows
        for rows, count in zip(given, counts.tolist(), strict=True)
    ]
    return np.concatenate(rows)


def joined(
    blocks: Sequence[Block], rows: NDArray[np.int64], variables: Sequence[Variable]
) -> Block:
    """The rows with these numbers, counted through all blocks, as one block."""

    def column(name: str) -> Array:
        return np.concatenate([getattr(block, name) for block in blocks])[rows]

    whole = Block(
        column("keys"),
        column("status"),
        column("reason"),
        messages=_joined_texts(blocks, rows, "messages"),
        carries=_joined_texts(blocks, rows, "carries"),
        seconds=column("seconds"),
    )
    present = {name for block in blocks for name in (*block.values, *block.row_sizes)}
    for variable in variables:
        if variable.name in present and not variable.ragged:
            whole.values[variable.name] = _joined_values(blocks, variable, rows)
    for group in dict.fromkeys(variable.ragged for variable in variables):
        if group in present:
            _join_rows(whole, blocks, rows, [v for v in variables if v.ragged == group])
    return whole


def _joined_texts(blocks: Sequence[Block], rows: NDArray[np.int64], name: str) -> dict[int, Any]:
    """What some rows have to tell, by the row that each becomes."""
    becomes = {row: place for place, row in enumerate(rows.tolist())}
    found: dict[int, Any] = {}
    begin = 0
    for block in blocks:
        found |= {begin + row: text for row, text in getattr(block, name).items()}
        begin += len(block)
    return {becomes[row]: text for row, text in found.items() if row in becomes}


def _joined_values(blocks: Sequence[Block], variable: Variable, rows: NDArray[np.int64]) -> Array:
    """Some rows of a variable over all blocks, as large as the largest of them."""
    name, fill, dtype = variable.name, fill_value(variable), dtype_of(variable)
    given = [block.values[name] for block in blocks if name in block.values]
    if variable.role is Role.ALONG and _is_shared(given):
        return given[0][:1]
    own = tuple(map(max, zip(*(array.shape[1:] for array in given), strict=True)))
    none = np.zeros((0, *own), dtype)
    every = []
    for block in blocks:
        array = block.values.get(name, none)
        if len(array) == 1:
            array = np.broadcast_to(array, (len(block), *array.shape[1:]))
        every.append(padded(array, (len(block), *own), fill))
    return np.concatenate(every)[rows]


def _join_rows(
    whole: Block,
    blocks: Sequence[Block],
    rows: NDArray[np.int64],
    members: Sequence[Variable],
) -> None:
    """The ragged variables of a group over all blocks."""
    group = members[0].ragged
    sizes = np.concatenate([b.row_sizes.get(group, np.zeros(len(b), np.int32)) for b in blocks])
    begins = np.cumsum(sizes, dtype=np.int64) - sizes
    chosen = sizes[rows]
    ends = np.cumsum(chosen, dtype=np.int64)
    places = np.repeat(begins[rows] - ends + chosen, chosen) + np.arange(chosen.sum())
    whole.row_sizes[group] = chosen
    for variable in members:
        none = np.zeros(0, dtype_of(variable))
        rows_of = np.concatenate([block.ragged.get(variable.name, none) for block in blocks])
        whole.ragged[variable.name] = rows_of[places]


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
