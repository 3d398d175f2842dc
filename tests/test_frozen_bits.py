"""The driver moves as it has always done, bit for bit.

The digests stand for every array that a motion leaves: event times, states, samples, measures,
tangents. They hold where the processor multiplies and adds in one operation, which generated code
then does (every x86-64 since 2013, every ARM), with the functions of the GNU C library. What
changes them on purpose raises the version of the numerics.
"""

from __future__ import annotations

from hashlib import sha256

import numpy as np
import pytest
from watched import CASES, watched

FROZEN = {
    "belt": "becb167218f4794f",
    "forced belt": "0c0e3337a8729971",
    "belt, rk4": "80cfba6359813861",
    "impacts": "8855ab519b97448d",
    "separation": "3dbcac3698fc7f77",
    "sector": "50c56aa3b0b18bc4",
    "slider with impacts": "7c31ad3233812758",
    "disc": "eaef684db931e264",
}


def digest(name: str) -> str:
    """Of all that a motion leaves, names included; zeros have no sign."""
    _, left = watched(name)
    numbers = {part: np.ravel(array).tolist() for part, array in left.items()}
    text = {
        part: [value.hex() if isinstance(value, float) else value for value in values]
        for part, values in numbers.items()
    }
    return sha256(repr(sorted(text.items())).encode()).hexdigest()[:16]


@pytest.mark.parametrize("name", CASES)
def test_a_motion_has_the_bits_that_it_had(name: str) -> None:
    assert digest(name) == FROZEN[name]
