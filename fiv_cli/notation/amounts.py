"""Times and sizes as people say them."""

from __future__ import annotations

MINUTE, HOUR, DAY = 60.0, 3600.0, 86400.0


def duration(seconds: float) -> str:
    """A length of time in two digits.

    >>> [duration(s) for s in (0.03, 40.0, 700.0, 9000.0, 4e5)]
    ['0.03 s', '40 s', '12 min', '2.5 h', '4.6 days']
    """
    for unit, length, most in (("s", 1.0, 2 * MINUTE), ("min", MINUTE, 2 * HOUR), ("h", HOUR, DAY)):
        if seconds < most:
            return f"{_two_digits(seconds / length)} {unit}"
    return f"{_two_digits(seconds / DAY)} days"


def size(count: float) -> str:
    """A number of bytes in two digits.

    >>> [size(count) for count in (800.0, 3.5e6, 6.8e10)]
    ['0.8 kB', '3.5 MB', '68 GB']
    """
    for unit, length in (("kB", 1e3), ("MB", 1e6), ("GB", 1e9)):
        if count < 1e3 * length:
            return f"{_two_digits(count / length)} {unit}"
    return f"{_two_digits(count / 1e12)} TB"


def _two_digits(number: float) -> str:
    return f"{number:.2g}" if number < 10.0 else f"{number:,.0f}"
