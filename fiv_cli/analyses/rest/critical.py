"""Critical values of a parameter: where a mode of the sliding equilibrium changes stability.

The eigenvalues of thesis 3.33-3.37 (averaged: 5.15) as functions of one parameter, without a grid
in it: every crossing inside a bracket, of any mode, to rounding (``crossings.py``).
"""

from __future__ import annotations

from fiv_cli.analyses.base import Analysis, Later
from fiv_cli.analyses.rest.system_choice import SYSTEM, averaging
from fiv_cli.analyses.settings import Bracket, ParameterName
from fiv_cli.analyses.variables import Subject, Variable, classes, count


def variables(subject: Subject) -> list[Variable]:
    """What is told of each crossing, and of the bracket."""
    varied = subject.varied
    ranked = "as at the lower end of the bracket, by rising frequency from 0; followed from there"
    moves = f"what the mode (or the equilibrium) does as {varied.name} rises"
    return [
        Variable(
            "critical_value", varied.unit, f"critical value of {varied.name}", "crossing",
            headline=1, width="critical_width",
        ),
        Variable("critical_width", varied.unit, "width of the interval that holds it", "crossing"),
        Variable(
            "critical_error", varied.unit, "how far it may be off", "crossing",
            comment="that interval, and rounding of the other parameters",
        ),
        classes("crossing_kind", "what happens there", "crossing"),
        classes("crossing_direction", moves, "crossing"),
        count("crossing_mode", "mode that crosses; -1: none", "crossing", comment=ranked),
        Variable(
            "crossing_frequency", "rad s-1", "frequency of the mode that crosses", "crossing"
        ),
        count("unstable_below", "growing eigenvalues below; -1: none at all", "crossing"),
        count("unstable_above", "growing eigenvalues above; -1: none at all", "crossing"),
        count("n_crossings", "crossings in the bracket"),
        Variable("growth_at_low", "rad s-1", "largest real part at the lower end of the bracket"),
        Variable("growth_at_high", "rad s-1", "largest real part at the upper end of the bracket"),
        *averaging(subject, "crossing"),
    ]  # fmt: skip


ANALYSIS = Analysis(
    "critical",
    "critical values of a parameter, by complex eigenvalues",
    (
        ParameterName("parameter", "what is varied: no axis of the grid", required=True),
        Bracket("bracket", "where its critical values are looked for", required=True),
        SYSTEM,
    ),
    variables,
    Later("fiv_cli.analyses.rest.crossings:critical_values"),
    uses_starts=False,
    linear=True,
    in_blocks=True,
    answer=(
        "every value of a parameter in a bracket at which a mode changes stability, to "
        "rounding: curves without a grid in that parameter"
    ),
)
