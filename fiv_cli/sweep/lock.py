"""The lock of a run directory: one live process at a time.

The kernel holds it (flock) and lets go when the process ends however it ends, so there is no
stale lock to clear up; the file only tells others whose it is.
"""

from __future__ import annotations

import fcntl
import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from fiv_cli.errors import LockedError, StorageError


@contextmanager
def hold(folder: Path) -> Iterator[None]:
    """Hold the run directory `folder` for as long as the context lasts.

    Raises
    ------
    LockedError
        a live process holds it.
    StorageError
        the lock file cannot be written.
    """
    descriptor = _opened(folder / "lock")
    try:
        _acquire(descriptor, folder)
        yield
    finally:
        os.close(descriptor)


def holder(folder: Path) -> int | None:
    """Process id of the live run that holds `folder`; None when nobody does."""
    try:
        descriptor = os.open(folder / "lock", os.O_RDWR | os.O_NOFOLLOW)
    except OSError:
        return None
    try:
        fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        return _stated_holder(descriptor)
    finally:
        os.close(descriptor)
    return None


def _opened(path: Path) -> int:
    try:
        return os.open(path, os.O_RDWR | os.O_CREAT | os.O_NOFOLLOW, 0o644)
    except OSError as error:
        raise StorageError(
            f"{path}: cannot be written: {error.strerror}\n"
            "next: choose another place with -o FILE.nc"
        ) from error


def _acquire(descriptor: int, folder: Path) -> None:
    try:
        fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError as error:
        raise LockedError(
            f"{folder}: process {_stated_holder(descriptor)} is running this case\n"
            "next: wait for it, or choose another output with -o FILE.nc"
        ) from error
    os.ftruncate(descriptor, 0)
    os.pwrite(descriptor, str(os.getpid()).encode(), 0)


def _stated_holder(descriptor: int) -> int:
    text = os.pread(descriptor, 32, 0).decode(errors="replace").strip()
    return int(text) if text.isdigit() else 0
