"""A signal that asks the program to end, remembered.

An exception that a signal handler raises is lost when it strikes in a finalizer or in a callback
of a library: Python prints it and goes on. So the handler leaves a note as well, and whatever
runs for long calls `heed` between its steps.
"""

from __future__ import annotations

_asked: list[BaseException] = []


def ask(exception: BaseException) -> None:
    """Note that the program must end with `exception`."""
    _asked.append(exception)


def heed() -> None:
    """Raise what was asked for, if anything was.

    Raises
    ------
    SystemExit, KeyboardInterrupt
        the program was asked to end.
    """
    if _asked:
        raise _asked[0]
