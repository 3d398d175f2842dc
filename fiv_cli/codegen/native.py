"""Hand-written kernels to machine code: the part of Python that they need, no more.

A kernel is a function marked `native`, with annotated parameters. Its text is read with `ast` and
written as LLVM IR, the functions that it calls likewise. There is nothing to infer: a variable has
the type of what it is first set to, arrays come as parameters or as fields of a `Frame`. So a
driver of a thousand lines takes two seconds where a general front end takes twenty, and a call
from Python hands over one address instead of an array at a time.

What a kernel may use: int, float and bool; arrays by index (never counted from the end, never out
of bounds: nothing checks), their rows, what follows an index, ``len`` and ``shape``; assignment,
``if``, ``while``, ``for`` over ``range``, ``break``, ``continue``, ``return``; arithmetic,
comparison, ``and``, ``or``, ``not``, conditional expressions; abs, min, max, int, float, np.floor,
np.sqrt; constants of its module; other kernels. Anything else is a `KernelError` that says
where. There is no fast-math and no contraction to fused multiply-add: the same text under Python
gives the same bits. What Python would raise while it runs is not looked for: a variable that is
not set on the way, an integer beyond 64 bits or divided by zero. A float divided by zero is
infinite or NaN, as in numpy.
"""

from __future__ import annotations

import ctypes
from collections.abc import Callable, Mapping
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fiv_cli.codegen import cache as store
from fiv_cli.codegen.lower import load_object, machine_description

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
C_TYPES: dict[str, Any] = {"float": ctypes.c_double, "int": ctypes.c_int64, "bool": ctypes.c_bool}


class KernelError(NotImplementedError):
    """A kernel uses what is not lowered; says where."""


def native(function: Callable[..., Any]) -> Callable[..., Any]:
    """Mark a kernel; under Python it stays what it is."""
    function.__native__ = True  # type: ignore[attr-defined]
    return function


def inlined(function: Callable[..., Any]) -> Callable[..., Any]:
    """Mark a kernel that is to be compiled into its callers."""
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
                raise KernelError(f"{name} is no array that a frame can hold")
            words[places[name] : places[name] + 1 + depth] = words_of(array)
        return words


def words_of(array: NDArray[Any]) -> tuple[int, ...]:
    """Address and lengths of an array, as frames and compiled kernels take them."""
    return (address_of(array), *array.shape)


def address_of(array: NDArray[Any]) -> int:
    """Where the data of a contiguous array begin (numpy's own ways take four times as long)."""
    return ctypes.addressof(NOTHING.from_buffer(array))  # type: ignore[arg-type]


# --- compiling, loading ---------------------------------------------------------------------------
class Library:
    """Kernels that are compiled together, once per user, on first use.

    Parameters
    ----------
    name : of the file in the cache
    files : source files that decide the code; their content is the key
    entries : the kernels that Python calls; scalars and one frame as parameters
    """

    def __init__(self, name: str, files: tuple[Path, ...], entries: tuple[Any, ...]):
        self.name, self.files, self.entries = name, files, entries
        self._sources = self._read_sources()  # as they are imported
        self._functions: dict[Any, Any] = {}
        self._engine: Any = None

    def key(self) -> str:
        """Hash of the sources, what is asked of them, the compiler and the processor.

        And of whether kernels are checked: under ``python -O`` the assertions of the translator
        are not there, and what it made of an unsound kernel must not be found without it.
        """
        asked = map(symbol, self.entries)
        checked = f"checked: {__debug__}"
        return store.content_key([self._sources, machine_description(), checked, *asked])

    def is_warm(self) -> bool:
        """Whether this user's cache holds the object code."""
        return store.read(self._file()) is not None

    def function(self, entry: Any) -> Any:
        """The compiled kernel, to be called with addresses of frames or data, and scalars."""
        if entry not in self._functions:
            if entry not in self.entries:
                raise KernelError(f"{self.name} does not hold {symbol(entry)}")
            address = self._loaded().get_function_address(symbol(entry))
            self._functions[entry] = _prototype(entry)(address)
        return self._functions[entry]

    def _read_sources(self) -> bytes:
        own = [Path(__file__).with_name(name) for name in ("native.py", "translate.py", "lower.py")]
        return store.source_of(*self.files, *own)

    def _file(self) -> str:
        return f"{self.name}-{self.key()}.o"

    def _loaded(self) -> Any:
        if self._engine is None:
            code = store.read(self._file())
            if code is None:
                from fiv_cli.codegen.translate import compile_kernels

                code = compile_kernels(self.entries)
                if self._read_sources() == self._sources:  # not edited since
                    store.write(self._file(), code)
            self._engine = load_object(code)
        return self._engine


def symbol(kernel: Any) -> str:
    """Name of a kernel in object code: two modules may have kernels of one name."""
    return f"{kernel.__module__}.{kernel.__qualname__}"


def _prototype(entry: Any) -> Any:
    """How Python calls a kernel (from its annotations: its text need not be read for that)."""
    annotations = dict(entry.__annotations__)
    if not all(isinstance(name, str) for name in annotations.values()):
        raise KernelError(f"{symbol(entry)}: its file imports no annotations from __future__")
    result = annotations.pop("return")
    kinds: list[Any] = []
    for name in annotations.values():
        depth = ARRAYS[name][1] if name in ARRAYS else 0
        kinds += [C_TYPES.get(name, ctypes.c_void_p), *[ctypes.c_int64] * depth]
    if result != "None" and result not in C_TYPES:
        raise KernelError(f"{symbol(entry)}: Python cannot take {result} from a kernel")
    return ctypes.CFUNCTYPE(C_TYPES.get(result), *kinds)
