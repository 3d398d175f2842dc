"""The amplitude spectrum of the steady state, beside the unstable eigenfrequencies.

Thesis 6.4.2.2, Figure 6.18. What is computed is told in ``amplitudes.py``. Where parameters vary in
time there is no steady state: the answer is a spectrogram (thesis 4.3.2), see ``spectrogram.py``.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import TYPE_CHECKING, Any

from fiv_cli.analyses.attractor import response
from fiv_cli.analyses.base import Analysis, Outcome, Setting, SolverSettings, Start
from fiv_cli.analyses.spectra.resolution import frequencies

if TYPE_CHECKING:
    from fiv_cli.dynamics.system import System

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


def run(
    system: System,
    parameters: Mapping[str, float],
    start: Start | None,
    settings: Mapping[str, Any],
    solver: SolverSettings,
) -> Outcome:
    """The spectrum of the steady state that `start` leads to, or the spectrogram of a motion."""
    from fiv_cli.analyses.spectra.amplitudes import steady_spectrum
    from fiv_cli.analyses.spectra.spectrogram import spectrogram

    assert start is not None
    if system.setup.schedule.curves:
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
