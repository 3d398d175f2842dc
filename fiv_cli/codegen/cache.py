"""The per-user cache of generated text and object code, keyed by content.

A key is the hash of everything that decides the content (source files, options, order, LLVM,
processor), so an edited model, law or engine file has another key and never meets stale code.
Files appear whole: written under a temporary name, then renamed. Two processes that generate the
same thing at once both succeed, with the same bytes.
"""

from __future__ import annotations

import contextlib
import hashlib
import os
import tempfile
from collections.abc import Iterable
from pathlib import Path

VARIABLE = "FIV_CACHE_DIR"  # of the environment: the folder, if not in the user's cache folder


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
