"""Amplitudes over time and frequency of a motion whose parameters vary in time (thesis 4.3.2).

What is computed is told in ``over_time.py``.
"""

from __future__ import annotations

from fiv_cli.analyses.base import Analysis, Later
from fiv_cli.analyses.settings import Number, StateName
from fiv_cli.analyses.spectra.spectrum import F_MAX, FREQUENCY, OBSERVED, RESOLUTION
from fiv_cli.analyses.variables import INITIAL_STATE, OF_MOTION, Subject, Variable, axis


def variables(subject: Subject) -> list[Variable]:
    """What is told of each window."""
    observed, unit = subject.observed
    comment = "peak of a sinusoid; root of the sum of squares over the bin, mean left out; Hann"
    amplitude = f"amplitude of {observed}"
    return [
        axis("time", "s", "middle of the window", symbol="t"),
        FREQUENCY,
        Variable("spectrogram", unit, amplitude, "time frequency", comment=comment),
        Variable("mean", unit, f"mean of {observed} in the window", "time"),
        INITIAL_STATE,
        *OF_MOTION,
    ]


ANALYSIS = Analysis(
    "spectrogram",
    "amplitudes over time and frequency",
    (
        StateName("observe", OBSERVED),
        F_MAX,
        RESOLUTION,
        Number(
            "window",
            "time that is transformed at once (under a Hann window); 4 / resolution when left out",
            unit="s",
            above=0.0,
        ),
        Number(
            "hop",
            "time from window to window; a quarter of a window when left out",
            unit="s",
            above=0.0,
        ),
        Number(
            "t_end",
            "end of the motion; the last kink of the schedule when left out",
            unit="s",
            above=0.0,
        ),
    ),
    variables,
    Later("fiv_cli.analyses.spectra.over_time:spectrogram"),
    varying=True,
    constant=False,
    counterpart="spectrum",
    recorded=True,
    spans=("t_end",),
    single=True,
    figure="spectrogram",
    answer="amplitudes of a motion whose parameters vary ([schedule])",
)
