"""The amplitude spectrum of the steady state, beside the unstable eigenfrequencies.

Thesis 6.4.2.2, Figure 6.18. What is computed is told in ``amplitudes.py``.
"""

from __future__ import annotations

from dataclasses import replace

from fiv_cli.analyses.attractor import response
from fiv_cli.analyses.base import Analysis, Later
from fiv_cli.analyses.settings import Number
from fiv_cli.analyses.variables import (
    ATTRACTOR,
    INITIAL_STATE,
    MULTIPLICITY,
    OF_STEADY_STATE,
    PERIOD,
    Subject,
    Variable,
    axis,
)

OBSERVED = "state whose amplitudes are shown; the first state when left out"
F_MAX = Number("f_max", "highest frequency", unit="Hz", above=0.0, required=True)
RESOLUTION = Number(
    "resolution", "width of a frequency bin; f_max / 256 when left out", unit="Hz", above=0.0
)

KEPT_OF_STEADY_STATE = (ATTRACTOR, INITIAL_STATE, PERIOD, MULTIPLICITY, *OF_STEADY_STATE)
"""What a spectrum says of the steady state that it is of."""

FREQUENCY = axis("frequency", "Hz", "middle of the bin", symbol="f")


def variables(subject: Subject) -> list[Variable]:
    """What is told of each bin, of the modes, and of the steady state."""
    observed, unit = subject.observed
    pair = (
        "of the linearised system at the first sliding equilibrium, a conjugate pair once, from 0"
    )
    return [
        FREQUENCY,
        ATTRACTOR,
        INITIAL_STATE,
        Variable(
            "amplitude",
            unit,
            f"amplitude of {observed}",
            "frequency",
            comment="peak of a sinusoid; root of the sum of squares over the bin, mean left out; "
            "lines of a period, or a Hann window where the motion is not periodic",
        ),
        Variable("mean", unit, f"mean of {observed}"),
        Variable(
            "response_frequency",
            "Hz",
            "frequency of the largest line in the largest band of a bin's width",
        ),
        Variable("variance_shown", "1", "share of the mean square that lies below f_max"),
        PERIOD,
        MULTIPLICITY,
        Variable("mode_frequency", "Hz", "frequency of the mode", "mode", comment=pair),
        Variable("mode_growth", "rad s-1", "growth rate of the mode", "mode", comment=pair),
        Variable("unstable_frequency", "Hz", "frequency of the growing mode", "mode", comment=pair),
        *OF_STEADY_STATE,
    ]


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
    variables,
    Later("fiv_cli.analyses.spectra.amplitudes:steady_spectrum"),
    counterpart="spectrogram",
    spans=response.SPANS,
    figure="spectrum",
    answer="amplitudes of the steady state, beside the unstable eigenfrequencies",
)
