"""The amplitude spectrum of the steady state, beside the unstable eigenfrequencies.

Thesis 6.4.2.2, Figure 6.18. What is computed is told in ``amplitudes.py``.
"""

from __future__ import annotations

from dataclasses import replace

from fiv_cli.analyses.attractor import response
from fiv_cli.analyses.base import Analysis, Later
from fiv_cli.analyses.settings import Number

OBSERVED = "state whose amplitudes are shown; the first state when left out"
F_MAX = Number("f_max", "highest frequency", unit="Hz", above=0.0, required=True)
RESOLUTION = Number(
    "resolution", "width of a frequency bin; f_max / 256 when left out", unit="Hz", above=0.0
)

ANALYSIS = Analysis(
    "spectrum",
    "amplitude spectrum of the steady state",
    (
        *(
            replace(setting, meaning=OBSERVED) if setting.name == "observe" else setting
            for setting in response.SETTINGS
        ),
        F_MAX,
        RESOLUTION,
        Number(
            "window",
            "time over which a motion that is not periodic is transformed (under a Hann window); "
            "16 / resolution when left out",
            unit="s",
            above=0.0,
        ),
    ),
    Later("fiv_cli.analyses.spectra.amplitudes:steady_spectrum"),
    counterpart="spectrogram",
    figure="spectrum",
)
