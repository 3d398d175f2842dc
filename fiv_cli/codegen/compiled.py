"""Compiled kernels: made by numba on first use, once per user, anew after any edit of their files.

numba keeps machine code in files of its own, which it finds by the entry's file: it sees no edit
in another one, and reads what anybody may have written. So its files are made in a folder that
lives as long as the compiling or loading takes, and are kept, packed into one, by the rules of
`cache.py`: under a key that follows every source, whole, and nobody else's.
"""

from __future__ import annotations

from collections.abc import Callable
from contextlib import suppress
from functools import cached_property
from importlib.metadata import version
from io import BytesIO
from pathlib import Path
from zipfile import ZipFile, ZipInfo

from fiv_cli.codegen import cache as store
from fiv_cli.codegen.lower import machine_description

Entry = Callable[..., int]
OWN = tuple(Path(__file__).with_name(name) for name in ("compiled.py", "kernels.py", "memory.py"))


class Compiled:
    """Kernels behind one entry.

    Parameters
    ----------
    name : of what is compiled, in the cache
    files : source files that decide the code; their content is the key
    declare : hands the entry to numba, with these options, and returns what it makes of it
    """

    def __init__(self, name: str, files: tuple[Path, ...], declare: Callable[..., Entry]) -> None:
        self.name, self.files, self._declare = name, files, declare
        self._sources = self._read_sources()  # as they are imported

    def key(self) -> str:
        """Hash of the sources and where they lie (numba asks too), compiler, and processor."""
        versions = (version("numba"), version("llvmlite"))
        places = map(str, self.files)
        return store.content_key([self._sources, *places, *versions, machine_description()])

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
        with suppress(OSError), store.scratch_folder() as folder:
            return self._made_in(folder)
        return self._declare(cache=False)  # there is nowhere to put a file

    def _made_in(self, folder: Path) -> Entry:
        """The entry, loaded from what was kept, or compiled and kept."""
        kept = store.read(self._file())
        if kept is not None:
            ZipFile(BytesIO(kept)).extractall(folder)
        entry = self._declared(folder)
        made = _packed(folder)  # numba may have found nothing in what was kept
        if made != kept and self._read_sources() == self._sources:  # not edited since
            store.write(self._file(), made)
        return entry

    def _declared(self, folder: Path) -> Entry:
        """The entry, with numba's files in this folder."""
        import numba

        before = numba.config.CACHE_DIR
        numba.config.CACHE_DIR = str(folder)
        try:
            return self._declare(cache=True)
        finally:
            numba.config.CACHE_DIR = before

    def _read_sources(self) -> bytes:
        return store.source_of(*self.files, *OWN)

    def _file(self) -> str:
        return f"{self.name}-{self.key()}.zip"


def _packed(folder: Path) -> bytes:
    """The files of a folder as one, the same for the same files."""
    content = BytesIO()
    with ZipFile(content, "w") as archive:
        for path in sorted(path for path in folder.rglob("*") if path.is_file()):
            archive.writestr(ZipInfo(str(path.relative_to(folder))), path.read_bytes())
    return content.getvalue()
