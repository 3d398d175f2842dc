"""The per-user cache of generated text and object code, keyed by content.

A key is the hash of everything that decides the content (source files, options, order, LLVM,
processor), so an edited model, law or engine file has another key and never meets stale code.
Files and folders appear whole: written under a temporary name, then renamed. Two processes that
generate the same thing at once both succeed.
"""

from __future__ import annotations

import contextlib
import hashlib
import os
import shutil
import stat
import tempfile
from collections.abc import Callable, Iterable
from functools import partial
from pathlib import Path

from fiv_cli import ending

VARIABLE = "FIV_CACHE_DIR"  # of the environment: the folder, if not in the user's cache folder
SEAL = "seal"  # file of a folder: hash of the others


def cache_root() -> Path:
    """``$FIV_CACHE_DIR``, or ``fiv`` in the user's cache folder."""
    given = os.environ.get(VARIABLE)
    if given:
        return Path(given)
    base = os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache"
    return Path(base) / "fiv"


def content_key(parts: Iterable[str | bytes]) -> str:
    """Hash of `parts` in order."""
    digest = hashlib.sha256()
    for part in parts:
        data = part.encode() if isinstance(part, str) else part
        digest.update(len(data).to_bytes(8, "little"))
        digest.update(data)
    return digest.hexdigest()[:32]


def source_of(*paths: Path) -> bytes:
    """Content of source files, for a key."""
    return b"\0".join(path.read_bytes() for path in paths)


def read(name: str) -> bytes | None:
    """A cached file's content, None when it is not there or not whole."""
    try:
        data = (cache_root() / name).read_bytes()
    except OSError:
        return None
    checksum, content = data[:32], data[32:]
    return content if hashlib.sha256(content).digest() == checksum else None


def write(name: str, content: bytes) -> None:
    """Store atomically; a cache that cannot be written is done without."""
    with contextlib.suppress(OSError):
        root = cache_root()
        root.mkdir(parents=True, exist_ok=True)
        handle, temporary = tempfile.mkstemp(dir=root)
        try:
            with os.fdopen(handle, "wb") as file:
                file.write(hashlib.sha256(content).digest() + content)
            Path(temporary).replace(root / name)
        finally:
            Path(temporary).unlink(missing_ok=True)  # there only where the disk is full


# --- folders that others write into ---------------------------------------------------------------
def find_folder(name: str) -> Path | None:
    """A cached folder that is whole, this user's own and can be written; None without one."""
    folder = cache_root() / name
    with contextlib.suppress(OSError):
        if _is_private(folder) and (folder / SEAL).read_text() == _seal(folder):
            return folder
    return None


def make_folder(name: str, fill: Callable[[Path], object]) -> None:
    """Keep a folder that `fill` writes into; a cache that cannot be written is done without."""
    with contextlib.suppress(OSError):
        root = cache_root()
        root.mkdir(mode=0o700, parents=True, exist_ok=True)
        new = Path(tempfile.mkdtemp(dir=root))
        remove = partial(shutil.rmtree, new, ignore_errors=True)
        with contextlib.ExitStack() as at_end:
            at_end.enter_context(ending.last_act(remove))
            at_end.callback(remove)
            fill(new)
            (new / SEAL).write_text(_seal(new))
            if find_folder(name) is None:  # else another process was faster
                shutil.rmtree(root / name, ignore_errors=True)
                new.rename(root / name)


def _is_private(folder: Path) -> bool:
    status = folder.stat()
    others = stat.S_IRWXG | stat.S_IRWXO
    is_own = status.st_uid == os.getuid() and not status.st_mode & others
    return is_own and os.access(folder, os.W_OK)


def _seal(folder: Path) -> str:
    """Hash of the names and contents of a folder's files."""
    paths = sorted(path for path in folder.rglob("*") if path.is_file() and path.name != SEAL)
    named = [(str(path.relative_to(folder)), path.read_bytes()) for path in paths]
    return content_key(part for pair in named for part in pair)
