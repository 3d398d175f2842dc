"""Where the class of the steady state changes along one parameter.

The suppression boundary A_b against R by simulation, the speeds at which stick-slip exists at each
preload, the ends of a bistable range: a scan of a bracket, and each change found in it bisected.
What is computed at each value is the analysis `response`; see ``scan.py``.
"""

from __future__ import annotations

from fiv_cli.analyses.attractor import response
from fiv_cli.analyses.base import Analysis, Later
from fiv_cli.analyses.settings import (
    Bracket,
    Choice,
    Integer,
    Number,
    ParameterName,
    Question,
    QuestionSetting,
)
from fiv_cli.analyses.variables import OF_MOTION, Subject, Variable, axis, classes, count, detail


def variables(subject: Subject) -> list[Variable]:
    """What is told of each change, of the scan, and of all runs."""
    varied, sides = subject.varied, "class of the steady state"
    way = "direction in which it was met; none: every run begins at the start"
    question = subject.settings.get("of") or Question()
    confirmed = "distance within which runs in shorter steps and with more time find it (where "
    confirmed += (
        'undecided = "counts", in the same time: that of what is undecided is t_max\'s own)'
    )
    confirmed += "; missing where a side is open or they do not find it"
    return [
        Variable(
            "boundary", varied.unit, f"{varied.name} {question.changes}", "crossing",
            headline=1, width="boundary_width",
        ),
        Variable(
            "boundary_width", varied.unit, "width of the interval that it was bisected to",
            "crossing", comment="no bound of its error",
        ),
        Variable(
            "boundary_error", varied.unit, "how far it may be off", "crossing", comment=confirmed
        ),
        classes("class_below", f"{sides} below", "crossing", of="attractor"),
        classes("class_above", f"{sides} above", "crossing", of="attractor"),
        detail("answer_below", "answer to the question below", "crossing", of="answer"),
        detail("answer_above", "answer to the question above", "crossing", of="answer"),
        detail("found_going", way, "crossing", of="followed"),
        count("n_crossings", "changes in the bracket"),
        count("n_runs", "responses computed"),
        count("n_undecided", "responses without an answer"),
        detail("undecided_reason", "commonest reason why these have none", of="reason"),
        axis("scan", varied.unit, f"{varied.name} looked at first"),
        detail("scan_class", f"{sides} there", "scan", of="attractor"),
        *(_way_back(varied.unit, sides) if subject.settings["follow"] == "both" else ()),
        *OF_MOTION,
    ]  # fmt: skip


def _way_back(unit: str, sides: str) -> list[Variable]:
    """What a bracket followed up and down again has besides."""
    back = f"{sides} there on the way down"
    return [
        detail("scan_class_back", back, "scan", of="attractor"),
        *_end("low", unit),
        *_end("high", unit),
    ]


def _end(side: str, unit: str) -> tuple[Variable, ...]:
    """One end of a range."""
    name, end = f"bistable_{side}", f"{side}er end of a range in which the way up and down differ"
    known = "width of the interval that it was bisected to; missing where nothing changes"
    off = "that of the boundary there; 0 at an edge of the bracket, missing at undecided runs"
    kind = "what is there: a change of the answer, the bracket, or runs without one (undecided)"
    return (
        Variable(name, unit, end, "range", width=f"{name}_width"),
        Variable(f"{name}_width", unit, known, "range"),
        Variable(f"{name}_error", unit, "how far it may be off", "range", comment=off),
        detail(f"{name}_kind", kind, "range", of="range_end"),
    )


ANALYSIS = Analysis(
    "boundary",
    "where the class of the steady state changes along a parameter",
    (
        ParameterName("parameter", "what is varied: no axis of the grid", required=True),
        Bracket("bracket", "where changes are looked for", required=True),
        QuestionSetting("of", "the question whose answer changes", required=True),
        Integer("scan", "values looked at first, both ends included", default=9, least=2),
        Number(
            "width",
            "width to which a change is bisected, as a share of the bracket",
            default=1e-4,
            above=0.0,
        ),
        Choice(
            "follow",
            "where a run begins: at the start (none; a motion may go on beyond where the answer of "
            "the start changes), or where the one before ended (offsets count "
            "for the first alone); the end of what is followed so is approached by ever shorter "
            "steps, until it stays where it is",
            default="none",
            choices=("none", "up", "down", "both"),
        ),
        *response.SETTINGS,
    ),
    variables,
    Later("fiv_cli.analyses.attractor.scan:boundaries"),
    chains=False,
    answer=(
        "where the answer changes along a parameter, by simulation, bisected; ends of followed "
        "branches and bistable ranges"
    ),
)
