"""Changes of the class of the steady state along a parameter, by simulation.

Runs of `response` at a few values of the parameter (the scan), then bisection of every change of
the answer to a question, such as "is it periodic?". Where runs follow one another (``follow``), a
change is the end of the branch that was followed: it is bisected by going on from the last run
that was still on the branch. A bistable range is where the way up and the way back differ.

A run that is undecided, fails or runs out of budget has no answer, and none is guessed: a change
next to it is as wide as what was decided on both sides. Only where the question says so
(``undecided = "counts"``) is a motion that is undecided when its time is up an answer: one that had
not lost contact, or had not diverged, by then.

How closely a change is bisected says nothing of the runs: near it they take ever longer to show
their class, and errors of integration decide. So both sides are run again in shorter steps and
with more time, and where an answer is another one then ever farther from the change: that far, and
by what the closer runs may be wrong themselves, it may be off.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial

import numpy as np
from numpy.typing import NDArray

from fiv_cli.analyses.attractor.bisection import (
    Change,
    Edge,
    Found,
    Look,
    confirmed_within,
    followed,
    hysteresis,
    scanned,
)
from fiv_cli.analyses.attractor.foresight import foreseen
from fiv_cli.analyses.attractor.steady_state import steady_state
from fiv_cli.analyses.base import (
    Outcome,
    Question,
    Request,
    Settings,
    Start,
    broken,
)
from fiv_cli.analyses.catalogue import named
from fiv_cli.analyses.variables import OF_MOTION, Role, Variable, extremes_of
from fiv_cli.dynamics.system import System

NOTHING = "not_computed"
CLOSER = 1e-4  # share of the error of integration that a change is confirmed with
LONGER = 2.0  # ... and growth of the time given
LARGEST = 2**31 - 1  # what an integer variable of a dataset can hold


@dataclass
class _Runs:
    """Runs of `response` along a parameter, and what they cost together."""

    system: System
    request: Request
    count: int = 0
    undecided: Counter[str] = field(default_factory=Counter)  # reasons of those without an answer
    failed: list[Outcome] = field(default_factory=list)
    totals: dict[str, float] = field(default_factory=dict)

    @property
    def settings(self) -> Settings:
        """What is asked."""
        return self.request.settings

    def look(self, value: float, origin: Look | None) -> Look:
        """The answer at `value` from the start, or going on from `origin`."""
        parameters = self.settings["parameter"].at(self.request.parameters, value)
        outcome = self._outcome(parameters, origin)
        label = str(outcome.values.get("attractor", NOTHING))
        answer = answered(self.settings["of"], outcome)
        self.count += 1
        self.undecided.update([outcome.reason or "none"] if answer is None else [])
        self._book(outcome)
        return Look(value, answer, label, outcome.carry)

    def _outcome(self, parameters: Mapping[str, float], origin: Look | None) -> Outcome:
        setup = self.system.setup
        unmet = broken(setup.model, setup.law, parameters)
        if unmet is not None:
            return Outcome("not_computed", unmet.reason)
        assert self.request.start is not None
        start = self.request.start.at(parameters)
        if origin is not None:
            start = going_on(start, origin.carry)
        return steady_state(self.system, replace(self.request, parameters=parameters, start=start))

    def closer(self) -> _Runs:
        """Runs that tell the class more closely, booked with these; a time asked for stays."""
        longer = 1.0 if self.settings["of"].counts else LONGER
        settings = {**self.settings, "t_max": longer * self.settings["t_max"]}
        solver = self.request.solver.with_error(CLOSER)
        request = replace(self.request, settings=settings, solver=solver)
        return replace(self, request=request, count=0, undecided=Counter())

    def _book(self, outcome: Outcome) -> None:
        if outcome.status != "ok":
            self.failed.append(outcome)
        for variable in OF_MOTION:
            self.totals[variable.name] = self._total(variable, outcome.values)

    def _total(self, variable: Variable, values: Mapping[str, float]) -> float:
        """Work adds up; of what tells how far to trust it the worst counts."""
        name = variable.name
        if variable.role is Role.WORK:
            return min(self.totals.get(name, 0) + values.get(name, 0), LARGEST)
        return float(np.fmax(self.totals.get(name, np.nan), values.get(name, np.nan)))


def answered(question: Question, outcome: Outcome) -> bool | None:
    """Whether a run satisfies the question; None where it does not tell."""
    label = str(outcome.values.get("attractor", NOTHING))
    if outcome.status not in ("ok", "budget") or _is_open(label, question, outcome.status):
        return None
    if question.below is None:
        return (label == question.name) != question.negated
    if label == "diverged" and named(question.variable).unbounded:
        return question.negated
    value = _number(question.variable, outcome, question.contact)
    if np.isnan(value):
        return None
    return value > question.below if question.negated else value < question.below


def _number(name: str, outcome: Outcome, contact: int | None = None) -> float:
    """The number of a run, or of a contact in it; NaN where it has none."""
    if named(name).derived:
        low, high = (_number(end, outcome) for end in extremes_of(name))
        return 0.5 * (high - low)
    found = outcome.values.get(name, np.nan)
    return float(found if contact is None or np.ndim(found) == 0 else found[contact - 1])


def _is_open(label: str, question: Question, status: str) -> bool:
    """Whether a class tells nothing.

    That a motion is undecided may itself be asked for, or count as a class where its time was up.
    """
    counts = question.name == "undecided" or (question.counts and status == "ok")
    return label == NOTHING or (label == "undecided" and not counts)


def going_on(start: Start, carry: Mapping[str, object]) -> Start:
    """The start of a run that goes on from what another one left.

    Of an equilibrium that is the very state in which it was recognised, which lies a little beside
    it. It is not moved again by the offset of the start: such a kick does not shrink with the
    steps, and leaves the basin of an equilibrium before that ends.
    """
    return Start(start.label, "continue", {}, {**carry, "attractor": "followed"})


def boundaries(system: System, request: Request) -> Outcome:
    """Every change of the answer in the bracket, by rising value, and its two sides."""
    runs, settings = _Runs(system, request), request.settings
    passes = _passes(runs)
    listed = sorted(
        ((change, way) for way, found in passes.items() for change in found.changes),
        key=lambda pair: pair[0].middle,
    )
    values = _crossings(listed) | _scans(passes, settings)
    errors = values["boundary_error"] = _errors(runs, listed)
    at_changes = {change.middle: error for (change, _), error in zip(listed, errors, strict=True)}
    values |= _bistable(passes, settings, at_changes)
    values |= {"n_runs": runs.count, "n_undecided": runs.undecided.total(), **runs.totals}
    values["undecided_reason"] = next(iter(dict(runs.undecided.most_common(1))), "none")
    return _concluded(runs, passes, values, [change for change, _ in listed])


def _passes(runs: _Runs) -> dict[str, Found]:
    """The ways along the bracket that the setting ``follow`` asks for."""
    (low, high), follow = runs.settings["bracket"], runs.settings["follow"]
    values = [float(value) for value in np.linspace(low, high, runs.settings["scan"])]
    width = runs.settings["width"] * (high - low)
    if follow == "none":
        return {follow: scanned(values, runs.look, width)}
    go = partial(followed, look=runs.look, width=width, foresee=foreseen)
    if follow == "down":
        return {follow: go(values[::-1])}
    up = go(values)
    last = up.looks[-1]
    if follow == "up" or len(up.looks) < len(values) or last.carry is None:
        return {"up": up}
    return {"up": up, "down": go(values[::-1], first=last)}


def _crossings(listed: Sequence[tuple[Change, str]]) -> dict[str, object]:
    """The variables along the dim ``crossing``."""
    changes = [change for change, _ in listed]
    return {
        "boundary": np.array([change.middle for change in changes]),
        "boundary_width": np.array([change.width for change in changes]),
        "class_below": _names(change.low.label for change in changes),
        "class_above": _names(change.high.label for change in changes),
        "answer_below": _names(_word(change.low) for change in changes),
        "answer_above": _names(_word(change.high) for change in changes),
        "found_going": _names(way for _, way in listed),
        "n_crossings": len(changes),
    }


def _errors(runs: _Runs, listed: Sequence[tuple[Change, str]]) -> NDArray[np.float64]:
    """Distance from each change within which closer runs find it, too; NaN: they do not."""
    closer = runs.closer()
    errors = [_error(runs.settings["bracket"], closer, change, way) for change, way in listed]
    runs.count += closer.count
    return np.array(errors, dtype=float)


def _error(bracket: tuple[float, float], closer: _Runs, change: Change, way: str) -> float:
    """How far a change may be off: what closer runs say, and what is left of their own error."""
    origin = None if way == "none" else change.before
    if origin is not None and origin.carry is None:  # nothing to go on from
        return float("nan")
    away = confirmed_within(change, closer.look, origin, bracket, foreseen)
    return (1.0 + CLOSER) * away + closer.request.solver.rtol * float(np.max(np.abs(bracket)))


def _names(words: Iterable[str]) -> NDArray[np.str_]:
    return np.array(list(words), dtype=np.str_)


def _word(look: Look) -> str:
    return {True: "yes", False: "no", None: "open"}[look.answer]


def _scans(passes: Mapping[str, Found], settings: Settings) -> dict[str, np.ndarray]:
    """The variables along the dim ``scan``: what each pass found, by rising value."""
    low, high = settings["bracket"]
    values = np.linspace(low, high, settings["scan"])
    names = ("scan_class", "scan_class_back")
    return {"scan": values} | {
        name: _names(_label_at(float(value), one.looks) for value in values)
        for name, one in zip(names, passes.values(), strict=False)
    }


def _label_at(value: float, looks: Sequence[Look]) -> str:
    return next((look.label for look in looks if look.value == value), NOTHING)


def _bistable(
    passes: Mapping[str, Found], settings: Settings, errors: Mapping[float, float]
) -> dict[str, object]:
    """The variables along the dim ``range``: where the two ways differ.

    Parameters
    ----------
    errors : value of a change -> how far it may be off
    """
    if settings["follow"] != "both":
        return {}
    up, back = passes.get("up"), passes.get("down")
    ranges = hysteresis(up, back, settings["bracket"]) if up and back else []
    edges = {"low": [one.low for one in ranges], "high": [one.high for one in ranges]}
    values: dict[str, object] = {}
    for side, some in edges.items():
        values[f"bistable_{side}"] = np.array([edge.value for edge in some])
        values[f"bistable_{side}_width"] = np.array([edge.width for edge in some])
        values[f"bistable_{side}_error"] = np.array([_off(edge, errors) for edge in some])
        values[f"bistable_{side}_kind"] = _names(edge.kind for edge in some)
    return values


def _off(edge: Edge, errors: Mapping[float, float]) -> float:
    """How far an end of a range may be off; an edge of the bracket is what it is."""
    if edge.kind == "bracket":
        return 0.0
    return errors[edge.value] if edge.kind == "change" else float("nan")


def _concluded(
    runs: _Runs, passes: Mapping[str, Found], values: dict[str, object], changes: Sequence[Change]
) -> Outcome:
    """The outcome, with the reason why there may be more, or less, than was found."""
    looks = [look for one in passes.values() for look in one.looks]
    if all(look.answer is None for look in looks):
        first = next(iter(runs.failed), Outcome("budget", "time_budget"))
        return Outcome(first.status, first.reason, values, message=first.message)
    if len(looks) < len(passes) * runs.settings["scan"]:
        return Outcome(reason="branch_ended", values=values)
    if not all(change.decided for change in changes):
        return Outcome(reason="undecided_in_part", values=values)
    return Outcome(reason="" if changes else "no_crossing", values=values)
