"""Does the set of section points stay where it is?

Means and spreads of the two halves are compared. How far they may differ by chance is told by how
far the partial sums of each half wander about their mean: of a quasi-periodic sequence these are
bounded, and what is left of a turn at the ends is all that its means differ by; of a random one
they wander as a bridge does, correlated or not. A mean that creeps at a constant rate differs by
4 times what its partial sums explain, however slowly it creeps.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from fiv_cli.analyses.grounds import NEGLIGIBLE, WANDERING

FEWEST = 32  # section points below which nothing is said
STILL = 1e-9  # spread, over its values, of a state that does not move


def drift(points: NDArray[np.float64]) -> float:
    """Largest difference between the halves of a section set, in its spread; 0: stationary.

    A difference that sampling may bring about counts as none; NaN: too few points.

    Parameters
    ----------
    points : section points, oldest first; shape (count, n)
    """
    if len(points) < FEWEST:
        return float("nan")
    spread = np.std(points, axis=0)
    moving = spread > STILL * np.max(np.abs(points), axis=0)
    shown = (points[:, moving] - np.mean(points[:, moving], axis=0)) / spread[moving]
    return float(max((_difference(column) for column in (*shown.T, *(shown**2).T)), default=0.0))


def _difference(values: NDArray[np.float64]) -> float:
    """Difference between the means of two halves; 0 where sampling explains it."""
    half = len(values) // 2
    before, after = values[:half], values[-half:]
    apart = abs(float(np.mean(after) - np.mean(before)))
    sampling = _wandering(before) + _wandering(after)
    return 0.0 if apart <= max(WANDERING * sampling, NEGLIGIBLE) else apart


def _wandering(values: NDArray[np.float64]) -> float:
    """Range of the partial sums about the mean, over the number of values."""
    return float(np.ptp(np.cumsum(values - np.mean(values)))) / len(values)
