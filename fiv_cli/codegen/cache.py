"""The per-user cache of generated text and object code, keyed by content.

A key is the hash of everything that decides the content (source files, options, order, LLVM,
processor), so an edited model, law or engine file has another key and never meets stale code.
Files appear whole, see ``fiv_cli/files.py``. Of two processes that need the same thing at once one
makes it, and the other waits.

What is read here is executed, so only what nobody else can have written is read: the folder and
each file must belong to this user and be writable by nobody else. A folder that is not so, or that
cannot be written, is not used: a temporary one takes its place for this run, and one warning
says so. The environment carries that choice to worker processes.

Entries are touched when they are used. Whenever something new is written, those go that nobody
has used for `KEPT_AGE`, and, beyond `KEPT_BYTES`, those that were used longest ago, but none that
was used within `SPARED_AGE`. A running process never needs a file for longer than it takes to read
it (what is loaded lies in memory), and a file that went too early is only made again; so a week
since the last use is more than the longest pause between the parent's reading and that of a worker
that it starts.
"""

from __future__ import annotations

import atexit
import contextlib
import fcntl
import hashlib
import os
import shutil
import stat
import sys
import tempfile
import time
from collections.abc import Callable, Iterable, Iterator
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple

from fiv_cli import ending
from fiv_cli.files import write_whole

VARIABLE = "FIV_CACHE_DIR"  # of the environment: the folder, if not in the user's cache folder
NONE = Path(os.devnull)  # the folder that stands for none: nothing is kept

DAY = 86400.0  # s
KEPT_AGE = 90 * DAY
SPARED_AGE = 7 * DAY
KEPT_BYTES = 512 * 1024**2

OWN_FOLDER, OWN_FILE = 0o700, 0o600
OTHERS_WRITE = stat.S_IWGRP | stat.S_IWOTH


def cache_root() -> Path:
    """``$FIV_CACHE_DIR``, or ``fiv`` in the user's cache folder.

    Raises
    ------
    RuntimeError
        neither is there: this user has no home folder.
    """
    given = os.environ.get(VARIABLE)
    if given:
        return Path(given)
    base = os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache"
    return Path(base) / "fiv"


def provide() -> Path:
    """The folder to use, made where it is not there; a temporary one where it cannot be used."""
    try:
        root = cache_root()
    except RuntimeError:
        return replace_for_this_run("there is no home folder to keep compiled code in")
    trouble = _trouble(root)
    return replace_for_this_run(trouble) if trouble else root


def replace_for_this_run(why: str) -> Path:
    """Let compiled code go to a temporary folder, or nowhere, and say so in one line."""
    try:
        root = Path(tempfile.mkdtemp(prefix="fiv-cache-"))
        remove = partial(shutil.rmtree, root, ignore_errors=True)
        atexit.register(remove)
        ending.at_last(remove)
    except OSError:
        root = NONE
    os.environ[VARIABLE] = str(root)
    print(
        f"warning: {why}; it is compiled for this run only, which takes up to a minute "
        f"(next time: {VARIABLE}=FOLDER in the environment, a folder of your own)",
        file=sys.stderr,
    )
    return root


def frozen(value: Any) -> Any:
    """What JSON holds, tuples in place of its lists."""
    if isinstance(value, dict):
        return {key: frozen(item) for key, item in value.items()}
    return tuple(map(frozen, value)) if isinstance(value, list) else value


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
    """A cached file's content, None when it is not there, not whole or not this user's own."""
    try:
        data = _own_content(provide() / name)
    except OSError:
        return None
    checksum, content = data[:32], data[32:]
    return content if hashlib.sha256(content).digest() == checksum else None


def kept(name: str, make: Callable[[], bytes], sound: Callable[[], bool] = lambda: True) -> bytes:
    """A cached file's content; where it is not there, what `make` returns, which is then kept.

    Of all processes of this user one makes it, while the others wait.

    Parameters
    ----------
    sound : whether what was made may be kept
    """
    found = read(name)
    if found is not None:
        return found
    with _alone(provide() / f".{name}.lock"):
        content = read(name)
        if content is None:
            content = make()
            if sound():
                write(name, content)
    return content


@contextlib.contextmanager
def _alone(path: Path) -> Iterator[None]:
    """No other process makes the same meanwhile; where that cannot be had, each makes its own."""
    try:
        descriptor = os.open(path, os.O_RDWR | os.O_CREAT | os.O_NOFOLLOW, OWN_FILE)
    except OSError:
        yield
        return
    try:
        fcntl.flock(descriptor, fcntl.LOCK_EX)
        yield
        path.unlink(missing_ok=True)  # who waits for it finds what was made
    finally:
        os.close(descriptor)


def write(name: str, content: bytes) -> None:
    """Store atomically; where that fails, in a folder for this run, and a warning says why."""
    root = provide()
    if root == NONE:
        return
    data = hashlib.sha256(content).digest() + content
    try:
        write_whole(root / name, data, mode=OWN_FILE, durable=False)
    except OSError as error:
        root = replace_for_this_run(f"{root}: compiled code cannot be kept ({error.strerror})")
        with contextlib.suppress(OSError):  # then it is compiled once more by each process
            write_whole(root / name, data, mode=OWN_FILE, durable=False)
    else:
        _discard_old(root)


# --- whose it is ----------------------------------------------------------------------------------
def _trouble(root: Path) -> str:
    """Why a folder cannot be used; empty where it can (it is made where it is not there)."""
    if root == NONE:
        return ""
    try:
        _make_own(root)
        found = root.stat()
    except OSError as error:
        return f"{root}: compiled code cannot be kept there ({error.strerror})"
    whose = _not_own(found)
    if whose:
        return f"{root}: compiled code is not taken from there, the folder {whose}"
    if not os.access(root, os.W_OK | os.X_OK):
        return f"{root}: compiled code cannot be kept there (it cannot be written)"
    return ""


def _make_own(folder: Path) -> None:
    """Make a folder and what is missing above it, closed to others whatever the umask."""
    if folder.is_dir():
        return
    if folder.parent != folder:
        _make_own(folder.parent)
    with contextlib.suppress(FileExistsError):  # another process has just made it
        folder.mkdir(mode=OWN_FOLDER)
    if not folder.is_dir():
        raise NotADirectoryError(20, os.strerror(20))


def _not_own(found: os.stat_result) -> str:
    """In what a file or folder is not this user's alone; empty where it is."""
    if found.st_uid != os.geteuid():
        return "belongs to another user"
    return "can be written by others (chmod go-w)" if found.st_mode & OTHERS_WRITE else ""


def _own_content(path: Path) -> bytes:
    """What stands in a regular file of this user's own; it counts as used now.

    Raises
    ------
    OSError
        there is no such file.
    """
    descriptor = os.open(path, os.O_RDONLY | os.O_NOFOLLOW | os.O_NONBLOCK | os.O_CLOEXEC)
    with os.fdopen(descriptor, "rb") as file:
        found = os.fstat(descriptor)
        if not stat.S_ISREG(found.st_mode) or _not_own(found):
            raise PermissionError(path)
        with contextlib.suppress(OSError):  # on a disk that is read only
            os.utime(descriptor)
        return file.read()


# --- what goes ------------------------------------------------------------------------------------
class _Entry(NamedTuple):
    """A file of the cache: when it was used last, and its size."""

    used: float
    size: int
    path: Path


def _discard_old(root: Path) -> None:
    """Remove what has not been used for long, see above; a failure is no harm."""
    with contextlib.suppress(OSError):
        for entry in _superfluous(_entries(root), time.time()):
            entry.path.unlink(missing_ok=True)


def _entries(root: Path) -> list[_Entry]:
    """Every file of this user in the folder; folders in it are not the cache's."""
    found = []
    for path in root.iterdir():
        status = path.lstat()
        if stat.S_ISREG(status.st_mode) and status.st_uid == os.geteuid():
            found.append(_Entry(status.st_mtime, status.st_size, path))
    return found


def _superfluous(entries: Iterable[_Entry], now: float) -> list[_Entry]:
    """Of the entries those that go."""
    room, going = KEPT_BYTES, []
    for entry in sorted(entries, reverse=True):
        room -= entry.size
        age = now - entry.used
        if age > KEPT_AGE or (room < 0 and age > SPARED_AGE):
            going.append(entry)
    return going
