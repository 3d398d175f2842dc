"""The one way in which fiv writes a file: whole or not at all, and through nobody's link.

What is written goes to a new file in the target's folder, under a name that nobody can foresee,
opened so that it must not exist and is no link; it is renamed when it is complete. In a folder
that others can write to, whatever they put there is replaced, never written through.
"""

from __future__ import annotations

import contextlib
import errno
import os
import secrets
import stat
from collections.abc import Iterable, Iterator
from pathlib import Path

from fiv_cli.errors import StorageError, UsageError

NEW = os.O_RDWR | os.O_CREAT | os.O_EXCL | os.O_NOFOLLOW | os.O_CLOEXEC
ORDINARY = 0o666  # less what the user's umask takes away
SUFFIX = ".tmp"
NETCDF = (b"\x89HDF", b"CDF")
"""How a file of NetCDF begins, in format 4 and before."""


def refuse_special(path: Path, option: str = "-o") -> None:
    """Refuse to write to what is there and is no regular file: a folder, a pipe, a device.

    Raises
    ------
    UsageError
    """
    try:
        mode = path.stat().st_mode
    except (FileNotFoundError, NotADirectoryError):
        return
    except OSError as error:
        raise StorageError(
            f"{path}: cannot be written: {error.strerror}\nnext: {option} ANOTHER"
        ) from error
    if stat.S_ISDIR(mode):
        raise UsageError(f"{path}: is a folder\nnext: name a file, {option} {path}/NAME")
    if not stat.S_ISREG(mode):
        raise UsageError(
            f"{path}: is no regular file (a pipe, a device or the like); it is left alone\n"
            f"next: name a regular file or a new one with {option} FILE"
        )


@contextlib.contextmanager
def replacing(path: Path, *, mode: int = ORDINARY, durable: bool = True) -> Iterator[Path]:
    """A new empty file to be written by name; it takes the place of `path` when the block ends.

    Parameters
    ----------
    mode : permissions of the file, before the umask
    durable : wait until content and name are on the disk

    Raises
    ------
    OSError
        it cannot be written, or another file stands under its name; nothing is left behind, and
        what was at `path` is as it was.
    """
    temporary = path.with_name(f".{path.name}.{secrets.token_hex(8)}{SUFFIX}")
    descriptor = os.open(temporary, NEW, mode)
    try:
        yield temporary
        _refuse_another(descriptor, temporary)
        if durable:
            os.fsync(descriptor)
        temporary.replace(path)
    except BaseException:
        with contextlib.suppress(OSError):
            temporary.unlink()
        raise
    finally:
        os.close(descriptor)
    if durable:
        _sync_folder(path.parent)


def write_whole(
    path: Path, *content: bytes | memoryview, mode: int = ORDINARY, durable: bool = True
) -> None:
    """Replace the file at `path` by `content`, part after part, as `replacing` does.

    Raises
    ------
    OSError
    """
    with replacing(path, mode=mode, durable=durable) as temporary:
        _fill(temporary, content)


def write_first(path: Path, content: bytes) -> None:
    """Write `content` to a new file at `path`; what another process has put there meanwhile stays.

    Raises
    ------
    OSError
    """
    own = path.with_name(f"{path.name}.{secrets.token_hex(8)}")
    write_whole(own, content)
    try:
        with contextlib.suppress(FileExistsError):
            os.link(own, path)
    finally:
        own.unlink()


def append_line(path: Path, line: str) -> None:
    """Append a line to the regular file at `path`, which is made if need be.

    Raises
    ------
    OSError
        it cannot be written, or is a link.
    """
    descriptor = _opened(path, os.O_WRONLY | os.O_APPEND | os.O_CREAT)
    with os.fdopen(descriptor, "a", encoding="utf-8") as file:
        file.write(f"{line}\n")


def leftovers(path: Path) -> Iterator[Path]:
    """Files that a process killed while it wrote `path` has left; only its owner may ask."""
    beginning = f".{path.name}."
    with contextlib.suppress(OSError):
        for other in path.parent.iterdir():
            if other.name.startswith(beginning) and other.name.endswith(SUFFIX):
                yield other


def _fill(temporary: Path, content: Iterable[bytes | memoryview]) -> None:
    with os.fdopen(_opened(temporary, os.O_WRONLY), "wb") as file:
        file.writelines(content)


def _opened(path: Path, flags: int) -> int:
    """`path` itself, never what it links to, and without waiting for a reader of a pipe."""
    return os.open(path, flags | os.O_NOFOLLOW | os.O_NONBLOCK | os.O_CLOEXEC, ORDINARY)


def _refuse_another(descriptor: int, temporary: Path) -> None:
    """OSError where the name no longer stands for the file that was opened under it."""
    own, now = os.fstat(descriptor), os.lstat(temporary)
    if (own.st_dev, own.st_ino) != (now.st_dev, now.st_ino):
        raise OSError(errno.EPERM, "another file was put in its place while it was written")


def _sync_folder(folder: Path) -> None:
    """Make the rename itself durable."""
    descriptor = os.open(folder, os.O_RDONLY)
    try:
        os.fsync(descriptor)
    finally:
        os.close(descriptor)
