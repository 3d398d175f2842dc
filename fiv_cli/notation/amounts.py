"""Times, sizes and numbers with errors as people say them."""

from __future__ import annotations

from collections.abc import Collection
from math import floor, inf, isfinite, log10

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


def told_apart(values: Collection[float]) -> list[str]:
    """Numbers in six digits, or in as many as tell them apart.

    >>> told_apart([0.3, 0.301]), told_apart([0.3, 0.30000001])
    (['0.3', '0.301'], ['0.3', '0.30000001'])
    """
    for digits in range(6, 17):
        texts = [f"{value:.{digits}g}" for value in values]
        if len({*texts}) == len({*values}):
            return texts
    return [f"{value:.17g}" for value in values]


def with_error(value: float, error: float | None) -> str:
    """A number in as many digits as its error allows, and the error; without one in six digits.

    An infinite error is one that was looked for and not found.

    >>> with_error(5.4916634121, 1.5e-8), with_error(6.83943, 2e-3), with_error(2.5, None)
    ('5.491663412 ± 1.5e-08', '6.8394 ± 0.0020', '2.5')
    """
    if error == inf:
        return f"{value:.6g} ± unknown"
    if error is None or not (isfinite(error) and isfinite(value)):
        return f"{value:.6g}"
    if error == 0.0:
        return f"{value:.15g} ± 0"
    digits = floor(log10(max(abs(value), error))) - floor(log10(error)) + 2
    shown = (f"{value:#.{min(digits, 15)}g}", f"{error:#.2g}")
    return " ± ".join(number.rstrip(".") for number in shown)


def _two_digits(number: float) -> str:
    return f"{number:.2g}" if number < 10.0 else f"{number:,.0f}"
