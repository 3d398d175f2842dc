"""What kinds of analyses, starts and figures are called elsewhere -> what they are called here."""

from __future__ import annotations

import unicodedata

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
    "contour contours heatmap isoline isolines": "map",
    "fixedpoint fixedpoints equilibria": "equilibrium",
    "axis axes parameterstudy scan range": "grid",
    "adaptive adaptivegrid bisection": "refine boundary",
    "modeshape modeshapes": "mode-shape plate",
    "excitation external": "forcing harmonic",
    "rampup rampdown": "ramp",
    "law laws measured": "friction characteristic",
    "expect test assertion": "claim",
    "tolerance rtol integrator": "solver",
}

OTHER_WORDS = {word: kinds.split() for words, kinds in _MEANT.items() for word in words.split()}
"""Word, as `meant` looks for it -> the kinds that may be meant, the likeliest first."""


def meant(word: str) -> list[str]:
    """The kinds that a word of the field may mean; ``Poincaré map`` is ``poincaremap``."""
    plain = unicodedata.normalize("NFD", word.casefold())
    return OTHER_WORDS.get("".join(filter(str.isalpha, plain)), [])


def called_here(word: str) -> str:
    """What to type to read of what is meant; "" where no kind is."""
    found = meant(word)
    return f"here it is {' or '.join(map(repr, found))}: `fiv kinds {found[0]}`" if found else ""
