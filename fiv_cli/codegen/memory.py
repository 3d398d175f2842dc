"""Arrays as machine code sees them: addresses and lengths, and calls of generated code by address.

Kernels (hand-written, compiled by numba, see `kernels.py`) annotate their parameters with the names
of this file. They share a frame of arrays, so that Python hands over one address instead of an
array at a time.
"""

from __future__ import annotations

import ctypes
import math
from collections.abc import Callable, Mapping
from functools import cache
from types import SimpleNamespace
from typing import Any

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
OwnFloats = NDArray[np.float64]
Floats2 = NDArray[np.float64]
Ints = NDArray[np.int64]
OwnInts = NDArray[np.int64]
Ints2 = NDArray[np.int64]
Ints3 = NDArray[np.int64]

ARRAYS = {
    "Floats": (float, 1),
    "Floats2": (float, 2),
    "OwnFloats": (float, 1),
    "Ints": (int, 1),
    "Ints2": (int, 2),
    "Ints3": (int, 3),
    "OwnInts": (int, 1),
}
NOTHING = ctypes.c_char * 0


def native(function: Callable[..., Any]) -> Callable[..., Any]:
    """Mark a kernel; under Python it stays what it is."""
    function.__native__ = True  # type: ignore[attr-defined]
    return function


def inlined(function: Callable[..., Any]) -> Callable[..., Any]:
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
def generated_function(address: int) -> Any:
    """A generated function as Python calls it."""
    pointer = ctypes.c_void_p
    return ctypes.CFUNCTYPE(None, pointer, ctypes.c_double, pointer, pointer)(int(address))


class Frame:
    """Base of the record of arrays that kernels share: annotated fields, nothing else.

    In memory each field is its address and its lengths, as 64-bit words; of an array of the
    frame's own (`OwnFloats`, `OwnInts`) the address counts from that of the frame, so that a frame
    is copied together with arrays that follow it in the same block.
    """

    @classmethod
    @cache
    def places(cls) -> Mapping[str, int]:
        """Field -> its first word."""
        places, place = {}, 0
        for name, annotation in cls.__annotations__.items():
            places[name] = place
            place += 1 + ARRAYS[annotation][1]
        return places

    @classmethod
    def words(cls, arrays: Mapping[str, NDArray[Any]]) -> Ints:
        """The words of these arrays, zeros for the rest; keep the arrays alive meanwhile."""
        places = cls.places()
        words = np.zeros(sum(1 + ARRAYS[kind][1] for kind in cls.__annotations__.values()), int)
        for name, array in arrays.items():
            element, depth = ARRAYS[cls.__annotations__[name]]
            expected = np.float64 if element is float else np.int64
            suits = array.dtype == expected and array.ndim == depth and array.flags.c_contiguous
            if not suits:
                raise TypeError(f"{name} is no array that a frame can hold")
            words[places[name] : places[name] + 1 + depth] = address_of(array), *array.shape
        return words

    @classmethod
    def at(cls, address: int) -> SimpleNamespace:
        """The arrays of the frame at an address, as kernels that Python runs take them."""
        count = len(cls.words({}))
        words = list((ctypes.c_int64 * count).from_address(address))
        shown = {}
        for name, place in cls.places().items():
            element, depth = ARRAYS[cls.__annotations__[name]]
            start, shape = words[place], words[place + 1 : place + 1 + depth]
            if cls.__annotations__[name].startswith("Own"):
                start += address
            kind = ctypes.c_double if element is float else ctypes.c_int64
            data = (kind * math.prod(shape)).from_address(start)
            shown[name] = np.frombuffer(data, kind).reshape(shape)
        return SimpleNamespace(**shown)


def address_of(array: NDArray[Any]) -> int:
    """Where the data of a contiguous array begin (numpy's own ways take four times as long)."""
    return ctypes.addressof(NOTHING.from_buffer(array))  # type: ignore[arg-type]
