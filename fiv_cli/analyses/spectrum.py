"""The amplitude spectrum of the steady state, beside the unstable eigenfrequencies.

Thesis 6.4.2.2, Figure 6.18. What is computed is told in ``amplitudes.py``. Where parameters vary in
time there is no steady state: the answer is a spectrogram (thesis 4.3.2), see ``spectrogram.py``.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from fiv_cli.analyses import response
from fiv_cli.analyses.base import Analysis, Outcome, Setting, SolverSettings, Start

if TYPE_CHECKING:
    from fiv_cli.dynamics.system import System

DEFAULT_BINS = 256
WINDOW_BINS = 16  # least spectral lines of the window in one bin
SLICE_BINS = 4  # of a window of a spectrogram: the lobe of a sinusoid is as wide as a bin
HOPS = 4  # windows of a spectrogram that begin within the length of one

# Settings that count without [schedule] only, and with it only.
OF_STEADY_STATES = tuple(s.name for s in response.SETTINGS if s.name != "observe")
OF_SPECTROGRAMS = ("hop", "t_end")

OBSERVED = "state whose amplitudes are shown; the first state when left out"


def _of_response(setting: Setting) -> Setting:
    """A setting of `response` with what it means here."""
    if setting.name == "observe":
        return replace(setting, meaning=OBSERVED)
    return replace(setting, meaning=f"without [schedule]: {setting.meaning}")


SETTINGS = (
    *map(_of_response, response.SETTINGS),
    Setting(
        "f_max", "number", None, "highest frequency", "Hz", minimum=0.0, exclusive=True,
        required=True,
    ),
    Setting(
        "resolution", "number", None,
        "width of a frequency bin; f_max / 256 when left out", "Hz", minimum=0.0, exclusive=True,
    ),
    Setting(
        "window", "number", None,
        "time over which a motion that is not periodic is transformed (under a Hann window); "
        "16 / resolution when left out; of a spectrogram 4 / resolution", "s", minimum=0.0,
        exclusive=True,
    ),
    Setting(
        "hop", "number", None,
        "spectrogram: time from window to window; a quarter of a window when left out", "s",
        minimum=0.0, exclusive=True,
    ),
    Setting(
        "t_end", "number", None,
        "spectrogram: end of the motion; the last kink of the schedule when left out", "s",
        minimum=0.0, exclusive=True,
    ),
)  # fmt: skip


def bin_width(settings: Mapping[str, Any]) -> float:
    """Distance of two frequencies of the grid, Hz."""
    return float(settings["resolution"] or settings["f_max"] / DEFAULT_BINS)


def window_length(settings: Mapping[str, Any]) -> float:
    """Length of the window of a motion that is not periodic, s."""
    return float(settings["window"] or WINDOW_BINS / bin_width(settings))


def slice_length(settings: Mapping[str, Any]) -> float:
    """Length of a window of a spectrogram, s."""
    return float(settings["window"] or SLICE_BINS / bin_width(settings))


def hop(settings: Mapping[str, Any]) -> float:
    """Time from one window of a spectrogram to the next, s."""
    return float(settings["hop"] or slice_length(settings) / HOPS)


def frequencies(settings: Mapping[str, Any]) -> NDArray[np.float64]:
    """Middles of the bins, Hz: from 0 up to f_max."""
    width = bin_width(settings)
    count = int(np.floor(settings["f_max"] / width * (1.0 + 1e-12))) + 1
    grid: NDArray[np.float64] = width * np.arange(count, dtype=np.float64)
    return grid


def run(
    system: System,
    parameters: Mapping[str, float],
    start: Start | None,
    settings: Mapping[str, Any],
    solver: SolverSettings,
) -> Outcome:
    """The spectrum of the steady state that `start` leads to, or the spectrogram of a motion."""
    from fiv_cli.analyses.amplitudes import steady_spectrum
    from fiv_cli.analyses.spectrogram import spectrogram

    assert start is not None
    if system.schedule.curves:
        return spectrogram(system, parameters, start, settings, solver)
    return steady_spectrum(system, parameters, start, settings, solver)


ANALYSIS = Analysis(
    "spectrum",
    "amplitude spectrum of the steady state",
    SETTINGS,
    True,
    run,
    varying=True,
    recorded=lambda schedule: bool(schedule.curves),
    sizes=lambda settings: {"frequency": frequencies(settings)},
)
