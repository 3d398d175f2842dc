"""Memory as machine code sees it: addresses and lengths, and calls of generated code by address.

Kernels (hand-written, compiled by numba, see `kernels.py`) annotate their parameters with the names
of this file. They share a frame of named numbers and arrays, so that Python hands over one address
instead of an array at a time.
"""

from __future__ import annotations

import ctypes
import math
from collections.abc import Callable, Mapping, Sequence
from ctypes import addressof
from dataclasses import dataclass
from functools import cache
from struct import pack_into
from typing import Any, ClassVar, Generic, Self, TypeVar

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
OwnFloats = NDArray[np.float64]
Floats2 = NDArray[np.float64]
Ints = NDArray[np.int64]
OwnInts = NDArray[np.int64]
Ints2 = NDArray[np.int64]
Array = NDArray[Any]  # of floats or of integers: its field says
FixedInt = int
FixedFloat = float

WORD = 8  # bytes of an integer, a float, an address


@dataclass(frozen=True)
class Kind:
    """What a field of a frame holds.

    Attributes
    ----------
    element : float or int
    depth : number of indices, 0 of a scalar
    is_own : whether the array lies in the frame's own block
    is_fixed : whether kernels never write the scalar
    """

    element: type
    depth: int = 0
    is_own: bool = False
    is_fixed: bool = False

    @property
    def words(self) -> int:
        """Words that the field takes in a frame: a value, or an address and lengths."""
        return 1 + self.depth


KINDS = {
    "float": Kind(float),
    "int": Kind(int),
    "FixedFloat": Kind(float, is_fixed=True),
    "FixedInt": Kind(int, is_fixed=True),
    "Floats": Kind(float, 1),
    "Floats2": Kind(float, 2),
    "OwnFloats": Kind(float, 1, is_own=True),
    "Ints": Kind(int, 1),
    "Ints2": Kind(int, 2),
    "OwnInts": Kind(int, 1, is_own=True),
}
DTYPES = {float: np.dtype(np.float64), int: np.dtype(np.int64)}
NOTHING = ctypes.c_char * 0

Kernel = TypeVar("Kernel", bound=Callable[..., object])


def native(function: Kernel) -> Kernel:
    """Mark a kernel; under Python it stays what it is."""
    function.__native__ = True  # type: ignore[attr-defined]
    return function


def inlined(function: Kernel) -> Kernel:
    """Mark a kernel that becomes part of its callers: root search so gains up to 8 % of a run."""
    function.__inlined__ = True  # type: ignore[attr-defined]
    return native(function)


def bits_of(value: float) -> int:
    """The 64 bits of a float, as an integer."""
    return int(np.float64(value).view(np.int64))


def float_of(bits: int) -> float:
    """The float of 64 bits."""
    return float(np.int64(bits).view(np.float64))


def call_generated(
    address: int, coefficients: Floats, time: float, state: Floats, out: Floats
) -> None:
    """Call the generated function at `address` with the data of the arrays."""
    function = generated_function(address)
    function(address_of(coefficients), time, address_of(state), address_of(out))


@cache
def generated_function(address: int) -> Callable[[int, float, int, int], None]:
    """A generated function as Python calls it."""
    pointer = ctypes.c_void_p
    return ctypes.CFUNCTYPE(None, pointer, ctypes.c_double, pointer, pointer)(int(address))


def call_driver(address: int, frame: int, until: float, interval: float, measuring: bool) -> int:
    """Call the driver at `address` with the frame at another one."""
    arguments = (ctypes.c_int64, ctypes.c_double, ctypes.c_double, ctypes.c_bool)
    driver = ctypes.CFUNCTYPE(ctypes.c_int64, *arguments)(address)
    reason: int = driver(frame, until, interval, measuring)
    return reason


class Field:
    """A named number or array of a frame: `place` is its first word."""

    def __init__(self, name: str, place: int, kind: Kind) -> None:
        self.name, self.place, self.kind = name, place, kind


class Integer(Field):
    """A whole number, in a word of its own."""

    def __get__(self, frame: Frame, owner: type) -> int:
        return frame.words.item(self.place)

    def __set__(self, frame: Frame, value: int) -> None:
        frame.words[self.place] = value


class Number(Field):
    """A float, in a word of its own."""

    def __get__(self, frame: Frame, owner: type) -> float:
        return frame.floats.item(self.place)

    def __set__(self, frame: Frame, value: float) -> None:
        frame.floats[self.place] = value


class ArrayField(Field):
    """An array, looked up once (most are never needed in Python)."""

    def __get__(self, frame: Frame, owner: type) -> Array:
        if self.kind.is_own:
            block = frame.floats if self.kind.element is float else frame.words
            array: Array = block[frame.parts[self.name]]
        else:
            array = frame.shown[self.name]
        frame.__dict__[self.name] = array
        return array

    def elsewhere(self, words: Ints) -> Array:
        """The array that the words of a frame tell of."""
        start, *shape = words[self.place : self.place + self.kind.words].tolist()
        found = words_at(start, math.prod(shape)).view(DTYPES[self.kind.element])
        return found.reshape(shape)


class Frame:
    """Base of the record of scalars and arrays that kernels share: annotated fields, nothing else.

    In memory, in 64-bit words, a scalar is its value, an array its address and its lengths. Of an
    array of the frame's own (`OwnFloats`, `OwnInts`) the address counts from that of the frame, so
    that a frame is copied together with the arrays that follow it in the same block.

    Attributes
    ----------
    words, floats : the block, as integers and as floats
    address : where it begins
    parts : own array -> where it lies in the block
    shown : the arrays elsewhere, kept alive
    """

    fields: ClassVar[dict[str, Field]]
    length: ClassVar[int]  # words of the fields

    def __init_subclass__(cls) -> None:
        cls.fields, cls.length = {}, 0
        for base in reversed(cls.mro()[:-2]):  # without Frame itself and object
            for name, annotation in base.__annotations__.items():
                kind = KINDS[annotation]
                scalar = Number if kind.element is float else Integer
                cls.fields[name] = (ArrayField if kind.depth else scalar)(name, cls.length, kind)
                setattr(cls, name, cls.fields[name])
                cls.length += kind.words

    def __init__(self, words: Ints, parts: dict[str, slice], shown: Mapping[str, Array]) -> None:
        self.words: Ints = words
        self.floats: Floats = words.view(DTYPES[float])
        self.address = address_of(words)
        self.parts, self.shown = parts, shown

    @classmethod
    def holding(cls, shown: Mapping[str, Array], own: Mapping[str, int]) -> Self:
        """A frame of these arrays, and of its own ones of these lengths, zero like its scalars."""
        frame = cls(np.zeros(cls.length + sum(own.values()), np.int64), {}, {})
        end = cls.length
        for name, length in own.items():
            frame.place_own(name, slice(end, end + length))
            end += length
        for name, array in shown.items():
            kind = cls.fields[name].kind
            suits = array.dtype == DTYPES[kind.element] and array.ndim == kind.depth
            if not (suits and array.flags.c_contiguous):
                raise TypeError(f"{name} is no array that a frame can hold")
            frame.show(name, array)
        return cls(frame.words, frame.parts, shown)

    def copy(self) -> Self:
        """A frame with own arrays and scalars of its own, and the same arrays elsewhere."""
        return type(self)(self.words.copy(), self.parts, self.shown)

    def place_own(self, name: str, part: slice) -> None:
        """Say where in the block an own array lies; it may be part of another."""
        place = self.fields[name].place
        self.words[place : place + 2] = part.start * WORD, part.stop - part.start
        self.parts[name] = part

    def put(self, name: str, values: Sequence[float]) -> None:
        """Let an own array of floats begin with these (numpy takes three times as long)."""
        place = WORD * self.parts[name].start
        pack_into(f"{len(values)}d", self.words, place, *values)  # type: ignore[arg-type]

    def tell(self, **numbers: float) -> None:
        """Set numbers."""
        for name, value in numbers.items():
            setattr(self, name, value)

    def show(self, name: str, array: Array) -> None:
        """Show kernels another array as the field `name`, and keep it alive meanwhile."""
        own = self.__dict__
        if array is (own[name] if name in own else self.shown.get(name)):
            return
        place, words, shape = self.fields[name].place, self.words, array.shape
        words[place] = address_of(array)
        words[place + 1] = shape[0]
        if len(shape) == 2:
            words[place + 2] = shape[1]
        own[name] = array

    @classmethod
    def at(cls, address: int) -> Self:
        """The frame at an address, as kernels that Python runs take it."""
        words, parts, shown = words_at(address, cls.length), {}, {}
        for name, field in cls.fields.items():
            if field.kind.is_own:
                first = words.item(field.place) // WORD
                parts[name] = slice(first, first + words.item(field.place + 1))
            elif isinstance(field, ArrayField):
                shown[name] = field.elsewhere(words)
        end = max([cls.length, *(part.stop for part in parts.values())])
        return cls(words_at(address, end), parts, shown)


FrameKind = TypeVar("FrameKind", bound=Frame)


class Frames(Generic[FrameKind]):
    """Frames of one kind side by side: copies of one, the rows of a block.

    Parameters
    ----------
    blank : what is copied
    count : how many
    """

    def __init__(self, blank: FrameKind, count: int) -> None:
        self.blank = blank
        self.words = np.tile(blank.words, (count, 1))
        self._shown: dict[str, Array] = {}
        self._shown_rows: dict[str, Array] = {}

    def __len__(self) -> int:
        return len(self.words)

    def own(self, name: str) -> Array:
        """An array of every frame's own, as a row of each; shape (frames, ...)."""
        part = self.blank.parts[name]
        return self.words.view(getattr(self.blank, name).dtype)[:, part]

    def told(self, name: str) -> Array:
        """A number of every frame; shape (frames,)."""
        field = self.blank.fields[name]
        return self.words.view(DTYPES[field.kind.element])[:, field.place]

    def tell(self, **numbers: float | Array) -> None:
        """Numbers of every frame: one for all, or an array with that of each."""
        for name, values in numbers.items():
            self.told(name)[:] = values

    def show(self, name: str, array: Array) -> None:
        """Show every frame an array, and keep it alive meanwhile."""
        self._shown[name] = array
        self._tell_of(name, array)

    def show_rows(self, name: str, rows: Array) -> None:
        """Show each frame its row of an array."""
        self._shown_rows[name] = rows
        self._tell_of(name, rows[0])
        self.words[:, self.blank.fields[name].place] += rows.strides[0] * np.arange(len(rows))

    def show_parts(self, name: str, array: Array, ends: Array) -> None:
        """Show each frame a part of an array, from one of the ends to the next."""
        self.show(name, array)
        place = self.blank.fields[name].place
        self.words[:, place] += array.strides[0] * ends[:-1]
        self.words[:, place + 1] = np.diff(ends)

    def _tell_of(self, name: str, array: Array) -> None:
        place = self.blank.fields[name].place
        self.words[:, place] = address_of(array)
        self.words[:, place + 1 : place + 1 + array.ndim] = array.shape

    @property
    def addresses(self) -> list[int]:
        """Where each begins."""
        first, width = address_of(self.words), self.words.strides[0]
        return list(range(first, first + width * len(self.words), width))

    def frame(self, row: int) -> FrameKind:
        """One of the frames."""
        return self._shown_as(self.words[row], row)

    def copy(self, row: int) -> FrameKind:
        """A copy of one of the frames, which is shown the same arrays."""
        return self._shown_as(self.words[row].copy(), row)

    def _shown_as(self, words: Ints, row: int) -> FrameKind:
        frame = type(self.blank)(words, self.blank.parts, self.blank.shown)
        rows = {name: array[row] for name, array in self._shown_rows.items()}
        vars(frame).update(self._shown | rows)
        return frame


def words_at(address: int, count: int) -> Ints:
    """So many words from an address on."""
    return np.ctypeslib.as_array((ctypes.c_int64 * int(count)).from_address(int(address)))


def floats_at(address: int, rows: int, columns: int) -> Floats2:
    """The matrix that begins at an address."""
    return words_at(address, rows * columns).view(np.float64).reshape(rows, columns)


def address_of(array: Array) -> int:
    """Where the data of a contiguous array begin (numpy's own ways take four times as long)."""
    return addressof(NOTHING.from_buffer(array))  # type: ignore[arg-type]
