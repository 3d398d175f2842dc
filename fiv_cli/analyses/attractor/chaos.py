"""The 0-1 test for chaos on a sequence of section values.

Gottwald & Melbourne, SIAM J. Applied Dynamical Systems 8 (2009) 129: the growth of the mean
square displacement of a sequence driven by the observable is uncorrelated with time for regular
motion (K near 0) and perfectly correlated for chaos (K near 1). It uses nothing but the section
set, so it is independent of the Lyapunov exponent.

The mean of the observable is taken off first: it drives a turning of the sequence, which says
nothing and hides what a small observable on a large mean does. Displacements of all lags come from
one autocorrelation, by the Fourier transform.

Chaos in narrow bands that are visited in turn hides likewise: behind the step from band to band.
There the mean of each band is taken off.
"""

from __future__ import annotations

from functools import cache

import numpy as np
from numpy.typing import NDArray

FEWEST = 100  # section values below which the test says nothing
FREQUENCIES = 40  # test frequencies, spread over (pi/5, 4 pi/5) away from resonances
LONGEST_LAG = 10  # as a share of the sequence, one over this
MOST_BANDS = 20  # that are looked for
FEWEST_IN_BAND = 25  # section values
AT_ONCE = 7  # frequencies looked at together: three times that is more than half of all
SMOOTH = 128  # a transform is as long as a multiple of this: a product of small primes

Values = NDArray[np.float64]
Paths = NDArray[np.complex128]


def regularity(values: Values, bounds: tuple[float, ...] = ()) -> float:
    """K of the 0-1 test: near 0 regular, near 1 chaotic; NaN for too few or constant values.

    K is the median over test frequencies. Where `bounds` are given only on which side of each it
    lies is sure: no more frequencies are looked at than settle that.
    """
    if len(values) < FEWEST or np.ptp(values) == 0.0:
        return float("nan")
    centred, turning = values - np.mean(values), _turning(len(values))
    found = np.zeros(0)
    while len(found) < FREQUENCIES and not _are_told(found, bounds):
        some = turning[len(found) : len(found) + AT_ONCE]
        more = _correlations(displacements(np.cumsum(centred * some, axis=1)))
        found = np.append(found, more)
    return float(np.median(found))


def regularity_in_bands(values: Values, bounds: tuple[float, ...] = ()) -> float:
    """The same of what is left within bands, of as many as say most of chaos.

    A torus beside a resonance passes for chaos here as well, and more easily: this is to be asked
    only of what an exponent already says is chaotic.
    """
    counts = range(2, min(MOST_BANDS, len(values) // FEWEST_IN_BAND) + 1)
    found = [regularity(_within_bands(values, count), bounds) for count in counts]
    return float(np.nanmax(found, initial=-1.0))


def _within_bands(values: Values, count: int) -> Values:
    """The values less the mean of their band, where bands are visited in turn."""
    within = values.copy()
    for band in range(count):
        within[band::count] -= np.mean(values[band::count])
    return within


def _are_told(found: Values, bounds: tuple[float, ...]) -> bool:
    """Whether more than half of all frequencies are known to be on one side of each bound."""
    above = [int(np.count_nonzero(found > bound)) for bound in bounds]
    sides = [max(count, len(found) - count) for count in above]
    return bool(bounds) and min(sides) > FREQUENCIES // 2


def _turning(count: int) -> Paths:
    """exp(i c k) of every test frequency c, k = 1 ... count; shape (FREQUENCIES, count)."""
    return _turns(1 << (count - 1).bit_length())[:, :count]


@cache
def _turns(count: int) -> Paths:
    golden = (np.sqrt(5.0) - 1.0) / 2.0
    shares = (np.arange(1, FREQUENCIES + 1) * golden) % 1.0
    frequencies = np.pi / 5.0 + 3.0 * np.pi / 5.0 * shares
    return np.asarray(np.exp(1j * frequencies[:, None] * np.arange(1, count + 1)))


def displacements(paths: Paths | Values) -> Values:
    """Mean square displacement of each path at lags 1, 2, ...; shape (paths, lags).

    |b - a|^2 is |b|^2 + |a|^2 - 2 Re(b a*), and the last is the correlation of the path with its
    first nine tenths.
    """
    count = paths.shape[1]
    lags = count // LONGEST_LAG
    length = count - lags
    squares = np.cumsum(paths.real**2 + paths.imag**2, axis=1)
    starts = squares[:, length - 1 : length]
    ends = squares[:, length : length + lags] - squares[:, :lags]
    room = -(-count // SMOOTH) * SMOOTH
    spectrum = np.fft.fft(paths, room)
    spectrum *= np.conj(np.fft.fft(paths[:, :length], room))
    shared = np.fft.ifft(spectrum)[:, 1 : lags + 1].real
    return np.asarray((starts + ends - 2.0 * shared) / length)


def _correlations(displacements: Values) -> Values:
    """Correlation of each row with the lag; 0 where nothing changes."""
    lags = np.arange(displacements.shape[1], dtype=float)
    lags -= np.mean(lags)
    changes = displacements - np.mean(displacements, axis=1, keepdims=True)
    sizes = np.sqrt(np.sum(changes**2, axis=1) * np.sum(lags**2))
    return np.asarray(np.divide(changes @ lags, sizes, out=np.zeros(len(sizes)), where=sizes > 0.0))
