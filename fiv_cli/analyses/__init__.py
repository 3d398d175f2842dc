"""The analyses, by kind.

One folder per question; in it one file per kind, of its name, declares what is asked and answered,
and the others compute.
"""

from __future__ import annotations

from fiv_cli.analyses.attractor import boundary, response
from fiv_cli.analyses.base import Analysis
from fiv_cli.analyses.cycles import cycle
from fiv_cli.analyses.motion import history
from fiv_cli.analyses.rest import critical, eigenvalues, equilibrium, plate
from fiv_cli.analyses.spectra import spectrogram, spectrum

_ANALYSES: tuple[Analysis, ...] = (
    history.ANALYSIS,
    equilibrium.ANALYSIS,
    eigenvalues.ANALYSIS,
    critical.ANALYSIS,
    response.ANALYSIS,
    spectrum.ANALYSIS,
    spectrogram.ANALYSIS,
    boundary.ANALYSIS,
    cycle.ANALYSIS,
    plate.ANALYSIS,
)


def all_analyses() -> dict[str, Analysis]:
    """Every analysis, by kind (a copy)."""
    return {analysis.kind: analysis for analysis in _ANALYSES}


def get_analysis(kind: str) -> Analysis:
    """The analysis of this kind; KeyError when there is none."""
    return all_analyses()[kind]
