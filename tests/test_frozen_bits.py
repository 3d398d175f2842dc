"""The driver moves as it has always done, bit for bit.

The digests stand for every array that a motion leaves: event times, states, samples, tangents, and
to twelve digits what is measured along it and the numbers of the plate (nodes and weights of
quadratures, and mode shapes, are as good as the LAPACK that numpy came with, which takes other
instructions on another processor). They hold where the processor multiplies and adds
in one operation, which generated code then does (every x86-64 since 2013, every ARM), with the
functions of the GNU C library. What changes them on purpose raises the version of the numerics.
"""

from __future__ import annotations

from hashlib import sha256

import numpy as np
import pytest
from watched import CASES, watched

from fiv_cli.models import disc

FROZEN = {
    "belt": "2378b029eee15896",
    "forced belt": "eeccdee1eab32515",
    "belt, rk4": "9dda300b15174c3c",
    "impacts": "fd27609692d84972",
    "separation": "fac3ef6c09ec1a7c",
    "sector": "81de2f157f243185",
    "slider with impacts": "e62a8a3731b8a2f9",
    "disc": "35a052565972692d",
}


MEASURED = ("totals", "extremes", "shares")


def digest(name: str) -> str:
    """Of all that a motion leaves."""
    _, left = watched(name)
    text = [(part, [written(part, x) for x in np.ravel(left[part]).tolist()]) for part in left]
    return sha256(repr(sorted(text)).encode()).hexdigest()[:16]


def written(part: str, number: float) -> str:
    """A number with all the digits that count."""
    return f"{number:.12e}" if part in MEASURED else float(number).hex()


@pytest.fixture(autouse=True)
def plate_to_twelve_digits(monkeypatch: pytest.MonkeyPatch) -> None:
    exact = disc._mode
    rounded = lambda *of: tuple(float(f"{number:.12e}") for number in exact(*of))  # noqa: E731
    monkeypatch.setattr(disc, "_mode", rounded)


@pytest.mark.parametrize("name", CASES)
def test_a_motion_has_the_bits_that_it_had(name: str) -> None:
    assert digest(name) == FROZEN[name]
