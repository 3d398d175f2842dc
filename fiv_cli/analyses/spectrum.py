"""The amplitude spectrum of the steady state, beside the unstable eigenfrequencies.

Thesis 6.4.2.2, Figure 6.18. What is computed is told in ``amplitudes.py``.
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

OBSERVED = "state whose amplitudes are shown; the first state when left out"

SETTINGS = (
    *(replace(s, meaning=OBSERVED) if s.name == "observe" else s for s in response.SETTINGS),
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
        "16 / resolution when left out", "s", minimum=0.0, exclusive=True,
    ),
)  # fmt: skip


def bin_width(settings: Mapping[str, Any]) -> float:
    """Distance of two frequencies of the grid, Hz."""
    return float(settings["resolution"] or settings["f_max"] / DEFAULT_BINS)


def window_length(settings: Mapping[str, Any]) -> float:
    """Length of the window of a motion that is not periodic, s."""
    return float(settings["window"] or WINDOW_BINS / bin_width(settings))


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
    """The spectrum of the steady state that `start` leads to."""
    from fiv_cli.analyses.amplitudes import steady_spectrum

    assert start is not None
    return steady_spectrum(system, parameters, start, settings, solver)


ANALYSIS = Analysis(
    "spectrum",
    "amplitude spectrum of the steady state",
    SETTINGS,
    True,
    run,
    sizes=lambda settings: {"frequency": frequencies(settings)},
)
