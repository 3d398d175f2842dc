"""Short-time Fourier transform of a sampled motion, on SciPy's `ShortTimeFFT`.

Windows are Hann's; the mean of each is taken off. A line shows the amplitude (peak) of a sinusoid
in the unit of the motion. Only windows that lie wholly inside the samples are given.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Vector = NDArray[np.float64]

HANN_BANDWIDTH = 1.5  # noise bandwidth of Hann's window, in its spectral lines


@dataclass(frozen=True)
class TimeFrequency:
    """Amplitudes over time and frequency.

    Attributes
    ----------
    time : middles of the windows, s; shape (m,)
    frequency : Hz, from 0; shape (n,)
    amplitude : shape (m, n); 0 at frequency 0
    mean : of each window, shape (m,)
    """

    time: Vector
    frequency: Vector
    amplitude: NDArray[np.float64]
    mean: Vector


def short_time(values: Vector, interval: float, window: float, hop: float) -> TimeFrequency:
    """Transform `values`, taken every `interval` s from t = 0.

    Parameters
    ----------
    values : shape (n,)
    window : length of a window, s; rounded to samples
    hop : time between two windows, s; rounded to samples

    Raises
    ------
    ValueError
        when a window is longer than the samples, or has fewer than four
    """
    from scipy.signal import ShortTimeFFT
    from scipy.signal.windows import hann

    size, step = round(window / interval), max(1, round(hop / interval))
    if not 4 <= size <= len(values):
        raise ValueError(f"a window of {size} samples does not fit {len(values)} samples")
    transform = ShortTimeFFT(
        hann(size, sym=False),
        step,
        1.0 / interval,
        fft_mode="onesided2X",
        scale_to="magnitude",
    )
    count, middle = (len(values) - size) // step + 1, transform.m_num_mid
    found = transform.stft_detrend(values, "constant", 0, count, k_offset=middle)
    amplitude = np.abs(found).T
    amplitude[:, 0] = 0.0
    begins = step * np.arange(count)
    mean = np.array([np.mean(values[begin : begin + size]) for begin in begins])
    return TimeFrequency((begins + middle) * interval, np.asarray(transform.f), amplitude, mean)
