"""Compiled kernels: made by numba on first use, once per user, anew after any edit of their files.

numba is asked for the LLVM text of an entry, as optimised, and no more. What LLVM makes of it is
kept and loaded like the machine code of generated text (see `cache.py`, `lower.py`), under a key
that follows every source: where it is at hand numba is not imported.
"""

from __future__ import annotations

import ctypes
import re
from collections.abc import Callable
from functools import cached_property
from importlib.metadata import version
from pathlib import Path
from typing import Any

from fiv_cli.codegen import cache as store
from fiv_cli.codegen.lower import compile_entry, load_object, machine_description

Entry = Callable[..., Any]
SOURCES = ("compiled.py", "kernels.py", "lower.py", "memory.py")
OWN = tuple(Path(__file__).with_name(name) for name in SOURCES)
C_TYPES: dict[str, Any] = {
    "int64": ctypes.c_int64,
    "float64": ctypes.c_double,
    "boolean": ctypes.c_bool,
}


class Compiled:
    """Kernels behind one entry.

    Parameters
    ----------
    name : of what is compiled, in the cache
    signature : of the entry, in numba's words, such as ``int64(int64, float64)``
    files : source files that decide the code; their content is the key
    declare : tells numba of the kernels, and returns the entry that is to be compiled
    """

    def __init__(
        self, name: str, signature: str, files: tuple[Path, ...], declare: Callable[[], Entry]
    ) -> None:
        self.name, self.signature, self.files, self._declare = name, signature, files, declare
        self._sources = self._read_sources()  # as they are imported

    def key(self) -> str:
        """Hash of the sources, compiler, and processor."""
        versions = (version("numba"), version("llvmlite"))
        return store.content_key([self._sources, *versions, machine_description()])

    def is_warm(self) -> bool:
        """Whether this user's cache holds the machine code."""
        return store.read(self._file()) is not None

    def load(self, announce: Callable[[str], None], sentence: str) -> None:
        """Have the entry at hand; `announce` is called with the sentence if it must be compiled."""
        if "function" not in vars(self) and not self.is_warm():
            announce(sentence)
        _ = self.function

    @cached_property
    def function(self) -> Entry:
        """The compiled entry."""
        result, *arguments = (C_TYPES[name] for name in re.findall(r"\w+", self.signature))
        return ctypes.CFUNCTYPE(result, *arguments)(self.address)

    @cached_property
    def address(self) -> int:
        """Where its machine code is."""
        address: int = self._engine.get_function_address(self.name)
        return address

    @cached_property
    def _engine(self) -> Any:
        """What holds the machine code in memory."""
        return load_object(store.kept(self._file(), self._made, self._is_unedited))

    def _made(self) -> bytes:
        """The machine code, compiled now."""
        from fiv_cli.codegen.kernels import text_of

        return compile_entry(text_of(self._declare(), self.signature, self.name), self.name)

    def _is_unedited(self) -> bool:
        """Whether the sources are still those that were imported."""
        return self._read_sources() == self._sources

    def _read_sources(self) -> bytes:
        return store.source_of(*self.files, *OWN)

    def _file(self) -> str:
        return f"{self.name}-{self.key()}.o"
