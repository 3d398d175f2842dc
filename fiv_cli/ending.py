"""Signals that ask the program to end: noted, and heeded at safe points.

An exception that a signal handler raises strikes anywhere: within a lock of a library, which then
waits for itself, or within a finalizer, where it is lost. So the handlers only take note. A
watching thread, which also runs while the main thread is in compiled code, ends the process at
once where there is nothing to put in order. Within `heeded` it leaves that to the work itself,
which calls `heed` between its steps; it steps in where no such point is reached in time, or when
a second signal comes. What follows where one was heeded may take its time. To be ended at any
instant is safe: files appear whole or not at all.

A signal that was ignored on entry (a job in the background, ``nohup``) stays ignored.
"""

from __future__ import annotations

import contextlib
import os
import signal
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import cache
from select import select
from typing import NoReturn

PATIENCE = 3.0
"""Seconds in which a safe point must be reached."""

ECHO = 0.5
"""Seconds in which another signal is the same: `timeout` sends it to a process and to its group."""

MANY = 4096  # signals at once

NAMES: dict[int, str] = {
    signal.SIGINT: "interrupted",
    signal.SIGTERM: "terminated",
    signal.SIGHUP: "hung up",
}
"""Signals that ask for an end, and what the program then is."""

_SHOW_CURSOR = b"\x1b[?25h"  # a progress bar hides it

_noted: list[int] = []
_heeding: list[object] = []
_heeded: list[object] = []
_last_acts: list[Callable[[], object]] = []
_starting = threading.Lock()


class Ended(BaseException):
    """A signal asked the program to end."""


@cache
def take_over() -> None:
    """From here on signals that ask for an end are noted, and watched for."""
    reader, writer = os.pipe()
    os.set_blocking(writer, False)
    signal.set_wakeup_fd(writer, warn_on_full_buffer=False)
    for number in NAMES:
        if signal.getsignal(number) != signal.SIG_IGN:  # else: ignored on entry
            signal.signal(number, lambda number, frame: _noted.append(number))
    threading.Thread(target=_watch, args=(reader,), daemon=True).start()


def how_to_end() -> str:
    """What ends this process where Ctrl-C does not, as of a job in the background; or nothing."""
    ignored = [n for n in NAMES if signal.getsignal(n) == signal.SIG_IGN]
    if signal.SIGINT not in ignored or signal.SIGTERM in ignored:
        return ""
    return f"SIGINT does not end it (a job in the background); `kill {os.getpid()}` does"


def heed() -> None:
    """A safe point: raise what was asked for, if anything was.

    Raises
    ------
    Ended
        the program was asked to end.
    """
    if _noted:
        _heeded.append(None)
        raise Ended(NAMES[_noted[0]])


@contextmanager
def heeded() -> Iterator[None]:
    """Work that calls `heed` often, and has something to say when it is ended."""
    heed()
    _heeding.append(None)
    try:
        yield
    finally:
        _heeding.pop()
    heed()


def at_last(act: Callable[[], object]) -> None:
    """Do `act` when a signal ends the process, which runs nothing that `atexit` holds."""
    _last_acts.append(act)


@contextmanager
def last_act(act: Callable[[], object]) -> Iterator[None]:
    """Work that calls for `act` when the process is ended meanwhile; `act` takes no lock."""
    at_last(act)
    try:
        yield
    finally:
        _last_acts.remove(act)


@contextmanager
def starting() -> Iterator[None]:
    """Processes are being started: nothing ends this one before it knows them.

    They begin with the signals blocked, so that none strikes while they import.
    """
    mask = signal.pthread_sigmask(signal.SIG_BLOCK, NAMES)
    try:
        with _starting:
            yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, mask)


def disregard() -> None:
    """The work is done, its exit code stands: no signal changes it while Python clears up."""
    for number in NAMES:
        signal.signal(number, signal.SIG_IGN)


def finish(said: str = "") -> None:
    """Say which signal ended the program, or `said`, and leave; nothing where none did."""
    if _noted:
        _leave_for(_noted[0], said)


def _leave_for(number: int, said: str = "") -> NoReturn:
    """End the process without running anything more of it but the last acts."""
    with contextlib.suppress(OSError):  # a terminal that is gone
        show_cursor = _SHOW_CURSOR if os.isatty(2) else b""
        os.write(2, show_cursor + f"{said or NAMES[number]}\n".encode())
    _starting.acquire(timeout=PATIENCE)
    for act in reversed(_last_acts):
        with contextlib.suppress(Exception):
            act()
    os._exit(128 + number)


def _watch(reader: int) -> None:
    """Wait for a signal, then for the main thread to heed it, and to do what follows."""
    number = _signal_from(reader)
    if _heeding or _heeded:
        time.sleep(ECHO)
        if _comes(reader, 0.0):
            os.read(reader, MANY)
        if not _comes(reader, PATIENCE) and _heeded:
            _signal_from(reader)
    _leave_for(number)


def _comes(reader: int, seconds: float) -> bool:
    """Whether a signal comes within so many seconds."""
    return bool(select([reader], [], [], seconds)[0])


def _signal_from(reader: int) -> int:
    """The next signal that asks for an end."""
    while (number := os.read(reader, 1)[0]) not in NAMES:
        pass
    return number
