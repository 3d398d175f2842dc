"""The analyses, by kind.

One folder per question; in it one file per kind, of its name, declares what is asked and answered,
and the others compute.

An analysis is a declaration: what a case may set, what its answers hold, and what computes it. In a
folder of this one, here ``motion/reach.py``::

    from fiv_cli.analyses.base import Analysis, Later
    from fiv_cli.analyses.settings import Number
    from fiv_cli.analyses.variables import OF_MOTION, Subject, Variable


    def variables(subject: Subject) -> list[Variable]:
        unit, comment = subject.of_states(), subject.mixed
        reach = Variable("reach", unit, "greatest displacement", "state", comment=comment)
        return [reach, *OF_MOTION]


    ANALYSIS = Analysis(
        "reach",
        "how far a motion goes",
        (Number("t_end", "end of the motion", unit="s", above=0.0, required=True),),
        variables,
        Later("fiv_cli.analyses.motion.travel:reach"),
        recorded=True,
    )

What computes it stands apart, in `motion/travel.py`, so that `fiv check` needs no engine::

    import numpy as np

    from fiv_cli.analyses.base import Outcome
    from fiv_cli.analyses.common import balance, stopped, trust
    from fiv_cli.analyses.motion.recording import begun


    def reach(system, request):
        motion = begun(system, request)
        if isinstance(motion, Outcome):  # there is no such start, and the outcome says why
            return motion
        energy = motion.energy()
        motion.start_measuring(np.zeros(len(system.coordinates)))
        outcome = stopped(motion.run(request.settings["t_end"], measuring=True)) or Outcome()
        travelled = np.abs(motion.extremes[:, : len(system.coordinates)])
        outcome.values |= {"reach": travelled.max(axis=0), **trust(motion)}
        outcome.values["energy_residual"] = balance(motion, energy).residual
        return outcome

`Motion` (`fiv_cli/dynamics/motion.py`) says what else can be asked of a motion: its energies,
sections, samples, events and tangents. A variable that is `ragged="group"` goes into
`outcome.ragged`, of any length per point; where there is no answer, `Outcome(reason=...)` says why,
by a name of `fiv_cli/flags.py`. List the declaration below, add a test to `tests/test_analyses.py`
and a case.
"""

from __future__ import annotations

from fiv_cli.analyses.attractor import boundary, response
from fiv_cli.analyses.base import Analysis
from fiv_cli.analyses.cycles import cycle
from fiv_cli.analyses.motion import characteristic, history
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
    characteristic.ANALYSIS,
)


_BY_KIND = {analysis.kind: analysis for analysis in _ANALYSES}


def all_analyses() -> dict[str, Analysis]:
    """Every analysis, by kind (a copy)."""
    return _BY_KIND.copy()


def get_analysis(kind: str) -> Analysis:
    """The analysis of this kind; KeyError when there is none."""
    return _BY_KIND[kind]
