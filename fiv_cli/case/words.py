"""What kinds of analyses, starts and figures, and variables, are called elsewhere and here."""

from __future__ import annotations

import unicodedata
from collections.abc import Collection, Mapping

_MEANT = {
    "amplitude amplitudes lyapunov chaos attractor steadystate squeal stickslip": "response",
    "neighbour neighbor hysteresis carry carryon updown upsweep downsweep sweepup": "continue",
    "continuation follow numericalcontinuation": "continue cycle",
    "poincare poincaremap poincaresection section returnmap": "response bifurcation",
    "bifurcationdiagram orbitdiagram": "bifurcation response",
    "basinofattraction basinsofattraction basins": "basin random",
    "bistable bistability multistable multistability coexistence": "classes basin continue",
    "montecarlo sampling samples": "random share",
    "initialcondition initialconditions ic start starts": "initial",
    "timeseries timehistory timetrace trajectory transient simulation simulate motion": "history",
    "waveform plotintime": "history",
    "phaseportrait phaseplane phasespace loop": "phase",
    "fft psd fourier frequencies harmonics": "spectrum spectrogram",
    "stft waterfall timefrequency": "spectrogram",
    "floquet limitcycle limitcycles periodicorbit orbit multiplier multipliers": "cycle response",
    "hopf flutter threshold onset": "critical eigenvalues boundary",
    "eigenvalue eigenfrequency eigenfrequencies stability modes jacobian linear": "eigenvalues",
    "damping growthrate dampingratio": "eigenvalues",
    "stabilitymap stabilitychart stabilitydiagram phasediagram": "map eigenvalues response",
    "contour contours heatmap isoline isolines classmap parametermap": "map",
    "fixedpoint fixedpoints equilibria": "equilibrium",
    "axis axes parameterstudy scan range lattice latticeofstarts": "grid",
    "adaptive adaptivegrid bisection": "refine boundary",
    "modeshape modeshapes": "mode-shape plate",
    "excitation external": "forcing harmonic",
    "rampup rampdown": "ramp",
    "law laws measured": "friction characteristic",
    "expect test assertion lessthan greaterthan between increasing decreasing": "claim",
    "tolerance rtol integrator": "solver",
}

OTHER_WORDS = {word: kinds.split() for words, kinds in _MEANT.items() for word in words.split()}
"""Word, as `meant` looks for it -> the kinds that may be meant, the likeliest first."""


_VARIABLES = {
    "dominantfrequency mainfrequency peakfrequency": "response_frequency",
    "frequency freq f": "response_frequency mode_frequency",
    "rms intensity vibrationindex index": "L_s",
    "lyapunovexponent exponent largestexponent": "lyapunov",
    "class classes motion regime state": "attractor",
    "criticalvalue threshold critical mucrit": "critical_value",
    "sticktime stickratio stickingtime": "stick_fraction",
    "multiplier multipliers floquet": "floquet_multiplier",
    "growth growthrate realpart": "mode_growth growth_rate",
    "eigenfrequency eigenfrequencies frequencies imaginarypart": "mode_frequency",
    "damping dampingratio": "damping_ratio",
    "poincare section": "section_value",
    "frictionforce tangentialforce contactforce": "F_T",
    "normalforce normalload": "F_N",
    "eventkind eventtype eventstate event events transition": "event_from event_to",
    "equilibrium equilibria steadysliding slidingequilibrium restposition": "L_s_reference",
    "stability stable linearstability": "stable branch_stable",
    "flutterfrequency onsetfrequency squealfrequency": "growth_frequency unstable_frequency",
    "energy mechanicalenergy energybalance balance": "energy_residual",
    "power dissipation frictionwork": "friction_power",
}


def variable_meant(word: str, known: Collection[str]) -> str:
    """Which of the `known` variables a word of the field may mean, as a hint; "" for none."""
    return _hint(_VARIABLES, word, known)


_SETTINGS = {
    "low high lower upper start stop from to min max begin end range interval": "bracket",
    "condition criterion question predicate expect what": "of",
    "tolerance tol accuracy precision": "width",
    "tend duration time simtime maxtime": "t_max t_end",
    "burnin settle skip discard": "transient",
    "samples steps points num": "scan points",
}


def setting_meant(word: str, known: Collection[str]) -> str:
    """Which of the `known` settings of an analysis a word may mean, as a hint; "" for none."""
    return _hint(_SETTINGS, word, known)


def _hint(called: Mapping[str, str], word: str, known: Collection[str]) -> str:
    for words, names in called.items():
        here = [name for name in names.split() if name in known]
        if here and _plain(word) in words.split():
            return f"here it is {' or '.join(map(repr, here))}"
    return ""


def meant(word: str) -> list[str]:
    """The kinds that a word of the field may mean; ``Poincaré map`` is ``poincaremap``."""
    return OTHER_WORDS.get(_plain(word), [])


def _plain(word: str) -> str:
    return "".join(filter(str.isalpha, unicodedata.normalize("NFD", word.casefold())))


def called_here(word: str) -> str:
    """What to type to read of what is meant; "" where no kind is."""
    found = meant(word)
    return f"here it is {' or '.join(map(repr, found))}: `fiv kinds {found[0]}`" if found else ""
