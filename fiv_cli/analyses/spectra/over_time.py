"""Amplitudes over time and frequency of a motion whose parameters vary in time.

The motion is sampled at equal intervals on the series of the integrator, `OVERSAMPLED` times per
period of the highest frequency, and transformed window by window (``fourier.py``). The bins are
those of a spectrum: a bin shows the root of the sum of the squares of what falls into it.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from fiv_cli.analyses.base import Outcome, Request, Settings
from fiv_cli.analyses.common import balance, carry, initial_state, stopped, trust
from fiv_cli.analyses.motion.recording import begun, varying_at
from fiv_cli.analyses.spectra.resolution import bin_width, frequencies, hop, slice_length
from fiv_cli.codegen.codes import STICK
from fiv_cli.dynamics.motion import Motion, samples_at
from fiv_cli.dynamics.system import System, Vector
from fiv_cli.fourier import HANN_BANDWIDTH, TimeFrequency, short_time

OVERSAMPLED = 8  # samples per period of the highest frequency
PAGE = 2**14  # samples taken at a time: every state of each is held


def spectrogram(system: System, request: Request) -> Outcome:
    """The observed state over time and frequency, from the start to the end of the run."""
    settings = request.settings
    t_end = end_of(system, settings)
    if not slice_length(settings) < t_end:
        return Outcome(status="failed", reason="window_too_long")
    motion = begun(system, request)
    if isinstance(motion, Outcome):
        return motion
    initial, energy_before = initial_state(motion), motion.energy()
    motion.start_measuring()
    place = system.state_names.index(settings["observe"] or system.state_names[0])
    interval = 1.0 / (OVERSAMPLED * float(settings["f_max"]))
    values, end = _sampled(motion, place, interval, t_end)
    windows = short_time(values, interval, slice_length(settings), hop(settings))
    outcome = end or Outcome(carry=carry("", motion.y, (kind == STICK for kind in motion.kinds)))
    outcome.values |= _on_bins(windows, settings) | varying_at(system, windows.time)
    outcome.values |= {"initial_state": initial} | trust(motion)
    outcome.values["energy_residual"] = balance(motion, energy_before).residual
    return outcome


def end_of(system: System, settings: Settings) -> float:
    """End of the run, s: as the case says, else the last kink of what varies."""
    given = settings["t_end"]
    return float(given) if given is not None else system.setup.schedule.kinks[-1]


def _sampled(
    motion: Motion, place: int, interval: float, t_end: float
) -> tuple[Vector, Outcome | None]:
    """One state at equal intervals from 0 to `t_end`, NaN after an early end; why it ended."""
    count = int(np.floor(t_end / interval * (1.0 + 1e-12))) + 1
    times: Vector = interval * np.arange(count, dtype=np.float64)
    values = np.full(len(times), np.nan)
    for first in range(0, len(times), PAGE):
        samples = samples_at(motion.system, times[first : first + PAGE])
        end = stopped(motion.run(float(samples.times[-1]), samples=samples, measuring=True))
        values[first : first + samples.count] = samples.states[: samples.count, place]
        if end is not None:
            return values, end
    return values, None


def _on_bins(windows: TimeFrequency, settings: Settings) -> dict[str, NDArray[np.float64]]:
    grid = frequencies(settings)
    place = np.floor(windows.frequency / bin_width(settings) + 0.5).astype(int)
    inside = place < len(grid)
    squares = windows.amplitude[:, inside] ** 2 / HANN_BANDWIDTH
    sums = [np.bincount(place[inside], row, len(grid)) for row in squares]
    return {
        "time": windows.time,
        "frequency": grid,
        "spectrogram": np.sqrt(np.array(sums)),
        "mean": windows.mean,
    }
