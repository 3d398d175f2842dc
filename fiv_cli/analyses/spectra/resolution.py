"""The bins and windows that a `spectrum` or a `spectrogram` is asked for."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from fiv_cli.analyses.base import Settings

DEFAULT_BINS = 256
WINDOW_BINS = 16  # least spectral lines of the window in one bin
SLICE_BINS = 4  # of a window of a spectrogram: the lobe of a sinusoid is as wide as a bin
HOPS = 4  # windows of a spectrogram that begin within the length of one


def bin_width(settings: Settings) -> float:
    """Distance of two frequencies of the grid, Hz."""
    return float(settings["resolution"] or settings["f_max"] / DEFAULT_BINS)


def window_length(settings: Settings) -> float:
    """Length of the window of a motion that is not periodic, s."""
    return float(settings["window"] or WINDOW_BINS / bin_width(settings))


def slice_length(settings: Settings) -> float:
    """Length of a window of a spectrogram, s."""
    return float(settings["window"] or SLICE_BINS / bin_width(settings))


def hop(settings: Settings) -> float:
    """Time from one window of a spectrogram to the next, s."""
    return float(settings["hop"] or slice_length(settings) / HOPS)


def frequencies(settings: Settings) -> NDArray[np.float64]:
    """Middles of the bins, Hz: from 0 up to f_max."""
    width = bin_width(settings)
    count = int(np.floor(settings["f_max"] / width * (1.0 + 1e-12))) + 1
    grid: NDArray[np.float64] = width * np.arange(count, dtype=np.float64)
    return grid
