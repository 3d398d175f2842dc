"""Compiled kernels: made by numba on first use, once per user, anew after any edit of their files.

numba's own file cache keeps the machine code. It does not see edits in other files than that of
the entry, so every state of the sources has a folder of its own.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cached_property
from importlib.metadata import version
from pathlib import Path
from typing import Any

from fiv_cli.codegen import cache as store
from fiv_cli.codegen.lower import machine_description

OWN = tuple(Path(__file__).with_name(name) for name in ("compiled.py", "kernels.py", "memory.py"))


class Compiled:
    """Kernels behind one entry.

    Parameters
    ----------
    name : of what is compiled, in the cache
    files : source files that decide the code; their content is the key
    declare : hands the entry to numba, with these options, and returns what it makes of it
    """

    def __init__(
        self, name: str, files: tuple[Path, ...], declare: Callable[..., Callable[..., Any]]
    ) -> None:
        self.name, self.files, self._declare = name, files, declare
        self._sources = self._read_sources()  # as they are imported

    def key(self) -> str:
        """Hash of the sources and where they lie (numba asks too), compiler, and processor."""
        versions = (version("numba"), version("llvmlite"))
        places = map(str, self.files)
        return store.content_key([self._sources, *places, *versions, machine_description()])

    def is_warm(self) -> bool:
        """Whether this user's cache holds the machine code."""
        return store.find_folder(self._folder()) is not None

    def load(self, announce: Callable[[str], None], sentence: str) -> None:
        """Have the entry at hand; `announce` is called with the sentence if it must be compiled."""
        if "function" not in vars(self) and not self.is_warm():
            announce(sentence)
        _ = self.function

    @cached_property
    def function(self) -> Callable[..., Any]:
        """The compiled entry."""
        folder = store.find_folder(self._folder())
        if folder is not None:
            return self._declared(folder)
        made: list[Callable[..., Any]] = []
        if self._read_sources() == self._sources:  # not edited since
            store.make_folder(self._folder(), lambda new: made.append(self._declared(new)))
        return made[0] if made else self._declare(cache=False)

    def _declared(self, folder: Path) -> Callable[..., Any]:
        """The entry from a folder of numba's, or compiled into it."""
        import numba

        before = numba.config.CACHE_DIR
        numba.config.CACHE_DIR = str(folder)
        try:
            return self._declare(cache=True)
        finally:
            numba.config.CACHE_DIR = before

    def _read_sources(self) -> bytes:
        return store.source_of(*self.files, *OWN)

    def _folder(self) -> str:
        return f"{self.name}-{self.key()}"
