"""Amplitudes over frequency of a steady state.

An amplitude is the peak of a sinusoid, in the unit of the observed state; the mean is taken off
and given apart. Every spectrum stands on the same bins: a bin shows the root of the sum of the
squares of what falls into it, so that half the sum of the squares over all bins is the mean
square of the motion about its mean (what lies above f_max is left out; `variance_shown` says how
much is there).

- A periodic motion has lines at the multiples of one over its period: the Fourier coefficients
  over one period, sampled so densely that what folds back is negligible.
- Any other motion is sampled over the window, weighted by Hann's function and transformed; the
  sum over a bin is divided by the function's noise bandwidth (3/2), so that a sinusoid shows its
  amplitude and noise its power.

Samples are taken between events on the series of the integrator, so no event is smeared.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from fiv_cli.analyses.attractor.steady_state import steady_state
from fiv_cli.analyses.base import Outcome, Request, Settings, Start
from fiv_cli.analyses.common import start_motion, stopped
from fiv_cli.analyses.rest.equilibria import equilibria, sliding
from fiv_cli.analyses.rest.linearisation import spectrum
from fiv_cli.analyses.spectra.resolution import bin_width, frequencies, window_length
from fiv_cli.analyses.spectra.spectrum import KEPT_OF_STEADY_STATE
from fiv_cli.dynamics.motion import Motion, samples_at
from fiv_cli.dynamics.system import System, Vector

OVERSAMPLED = 16  # samples per period of the highest frequency
LEAST_SAMPLES = 16384
HANN_BANDWIDTH = 1.5  # noise bandwidth of Hann's window, in its spectral lines
NEUTRAL = 1e-9  # growth below this share of the frequency is rounding


@dataclass(frozen=True)
class Lines:
    """Spectral lines.

    Attributes
    ----------
    frequency : Hz, rising, without 0
    square : squared amplitudes, already divided by the bandwidth of the window
    mean : of the motion
    weighted : whether they are of a weighted window, in which a sinusoid has several
    """

    frequency: Vector
    square: Vector
    mean: float
    weighted: bool


def steady_spectrum(system: System, request: Request) -> Outcome:
    """The steady state, its spectrum, and the eigenfrequencies of the sliding equilibrium."""
    steady, settings = steady_state(system, request), request.settings
    modes = {"frequency": frequencies(settings)} | growing_modes(system, request.parameters)
    names = [variable.name for variable in KEPT_OF_STEADY_STATE]
    kept = {name: steady.values[name] for name in names if name in steady.values}
    outcome = Outcome(steady.status, steady.reason, kept | modes, {}, steady.message, steady.carry)
    if steady.carry is None:
        return outcome
    if kept["attractor"] == "equilibrium":
        outcome.values |= _at_rest(steady.values[f"{_observed(system, settings)}_min"], settings)
        return outcome
    return _with_lines(outcome, system, request)


def _observed(system: System, settings: Settings) -> str:
    return str(settings["observe"] or system.state_names[0])


def _at_rest(mean: float, settings: Settings) -> dict[str, object]:
    """Nothing moves: no amplitude anywhere."""
    return {"amplitude": np.zeros(len(frequencies(settings))), "mean": mean, "variance_shown": 1.0}


def _with_lines(outcome: Outcome, system: System, request: Request) -> Outcome:
    """Go on from where the steady state was accepted, and transform."""
    follow, settings = Start("", "continue", {}, outcome.carry), request.settings
    motion = start_motion(system, replace(request, start=follow), None)
    assert isinstance(motion, Motion)
    place = system.state_names.index(_observed(system, settings))
    period = outcome.values.get("period")
    length = float(period) if period is not None else window_length(settings)
    values, end = sampled(motion, place, length, settings["f_max"])
    if end is not None:
        outcome.status, outcome.reason = end.status, end.reason
        return outcome
    lines = period_lines(values, length) if period is not None else window_lines(values, length)
    outcome.values |= on_bins(lines, settings)
    return outcome


def sampled(
    motion: Motion, place: int, length: float, f_max: float
) -> tuple[Vector, Outcome | None]:
    """One state at equal intervals over `length` (s), its end left out; why it stopped, or None.

    A power of two of samples, at least `OVERSAMPLED` per period of f_max (Hz).
    """
    least = max(LEAST_SAMPLES, OVERSAMPLED * f_max * length)
    count = 2 ** int(np.ceil(np.log2(least)))
    samples = samples_at(motion.system, motion.time + length * np.arange(count) / count)
    stop = motion.run(motion.time + length, samples=samples)
    return samples.states[:, place].copy(), stopped(stop)


def period_lines(values: Vector, period: float) -> Lines:
    """Fourier coefficients of one period."""
    transformed = np.fft.rfft(values) / len(values)
    square = (2.0 * np.abs(transformed[1:])) ** 2
    frequency = np.arange(1, len(transformed)) / period
    return Lines(frequency, square, float(transformed[0].real), weighted=False)


def window_lines(values: Vector, length: float) -> Lines:
    """Lines of the weighted window."""
    count = len(values)
    mean = float(np.mean(values))
    weights = 0.5 - 0.5 * np.cos(2 * np.pi * np.arange(count) / count)
    transformed = np.fft.rfft((values - mean) * weights)
    square = (2.0 * np.abs(transformed[1:]) / np.sum(weights)) ** 2
    frequency = np.arange(1, len(transformed)) / length
    return Lines(frequency, square / HANN_BANDWIDTH, mean, weighted=True)


def _peak(lines: Lines, width: float) -> float:
    """Frequency of the largest line in the largest band of a bin's width, Hz; NaN: nothing moves.

    A single line may be the largest of all where a broad band holds more, in each of its bins. No
    edge of a bin splits a band.
    """
    ends = np.searchsorted(lines.frequency, lines.frequency + width)
    total = np.insert(np.cumsum(lines.square), 0, 0.0)
    first = int(np.argmax(total[ends] - total[:-1]))
    top = first + int(np.argmax(lines.square[first : ends[first]]))
    if lines.square[top] <= 0.0:
        return float("nan")
    return _between(lines, top) if lines.weighted else float(lines.frequency[top])


def _between(lines: Lines, top: int) -> float:
    """Frequency of a sinusoid from a line of a Hann window and those beside, Hz.

    Two neighbouring lines a >= b of a sinusoid stand in the ratio (1 + d)/(2 - d), with d the
    distance from a towards b in lines.
    """
    beside = [i for i in (top - 1, top + 1) if 0 <= i < len(lines.square)]
    second = max(beside, key=lambda i: float(lines.square[i]))
    if lines.square[second] > lines.square[top]:  # the band ends between them
        top, second = second, top
    ratio = float(np.sqrt(lines.square[second] / lines.square[top]))
    share = (second - top) * (2.0 * ratio - 1.0) / (1.0 + ratio)
    return float((top + 1 + share) * lines.frequency[0])


def on_bins(lines: Lines, settings: Settings) -> dict[str, object]:
    """Amplitudes on the common grid, and how much of the motion they show."""
    grid, width = frequencies(settings), bin_width(settings)
    place = np.floor(lines.frequency / width + 0.5).astype(int)
    inside = place < len(grid)
    square = np.bincount(place[inside], lines.square[inside], len(grid))
    total = float(np.sum(lines.square))
    return {
        "amplitude": np.sqrt(square),
        "mean": lines.mean,
        "response_frequency": _peak(lines, width),
        "variance_shown": float(np.sum(square)) / total if total > 0.0 else 1.0,
    }


def growing_modes(
    system: System, parameters: Mapping[str, float]
) -> dict[str, NDArray[np.float64]]:
    """Frequencies (Hz) and growth rates (rad/s) of the modes of the first sliding equilibrium.

    A conjugate pair is one mode; `unstable_frequency` is NaN for those that do not grow.
    """
    state = sliding(system, parameters)
    solutions = equilibria(state)
    if not solutions:
        return {}
    values = spectrum(state.jacobian(solutions[0]))[0]
    values = values[values.imag > 0.0]
    growing = values.real > NEUTRAL * np.max(np.abs(values), initial=0.0)
    hertz = values.imag / (2.0 * np.pi)
    return {
        "mode_frequency": hertz,
        "mode_growth": values.real.copy(),
        "unstable_frequency": np.where(growing, hertz, np.nan),
    }
