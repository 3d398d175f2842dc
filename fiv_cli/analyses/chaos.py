"""The 0-1 test for chaos on a sequence of section values.

Gottwald & Melbourne, SIAM J. Applied Dynamical Systems 8 (2009) 129: the growth of the mean
square displacement of a sequence driven by the observable is uncorrelated with time for regular
motion (K near 0) and perfectly correlated for chaos (K near 1). It uses nothing but the section
set, so it is independent of the Lyapunov exponent.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

FEWEST = 100  # section values below which the test says nothing
FREQUENCIES = 40  # test frequencies, spread over (pi/5, 4 pi/5) away from resonances


def regularity(values: NDArray[np.float64]) -> float:
    """K of the 0-1 test: near 0 regular, near 1 chaotic; NaN for too few or constant values."""
    if len(values) < FEWEST or np.ptp(values) == 0.0:
        return float("nan")
    golden = (np.sqrt(5.0) - 1.0) / 2.0
    shares = (np.arange(1, FREQUENCIES + 1) * golden) % 1.0
    frequencies = np.pi / 5.0 + 3.0 * np.pi / 5.0 * shares
    return float(np.median([_correlation(values, c) for c in frequencies]))


def _correlation(values: NDArray[np.float64], frequency: float) -> float:
    """Correlation of the mean square displacement with time, its oscillating part removed."""
    steps = np.arange(1, len(values) + 1)
    p = np.cumsum(values * np.cos(frequency * steps))
    q = np.cumsum(values * np.sin(frequency * steps))
    lags = range(1, len(values) // 10 + 1)
    displacement = np.array([_mean_square(p, lag) + _mean_square(q, lag) for lag in lags])
    oscillation = (1.0 - np.cos(np.array(lags) * frequency)) / (1.0 - np.cos(frequency))
    smooth = displacement - np.mean(values) ** 2 * oscillation
    if np.ptp(smooth) == 0.0:
        return 0.0
    return float(np.corrcoef(lags, smooth)[0, 1])


def _mean_square(path: NDArray[np.float64], lag: int) -> float:
    length = len(path) - len(path) // 10
    return float(np.mean((path[lag : lag + length] - path[:length]) ** 2))
