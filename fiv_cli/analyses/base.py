"""What an analysis is: ``(system, parameters, start, settings) -> Outcome``.

To add an analysis: write ``fiv_cli/analyses/my_kind.py`` with its `SETTINGS` table, a function
``run`` and ``ANALYSIS = Analysis(...)``; list it in ``fiv_cli/analyses/__init__.py``; add its
variables to ``fiv_cli/analyses/variables.py``. An analysis knows nothing of workers and files.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any

from fiv_cli.codegen.setup import Setup
from fiv_cli.dynamics.settings import Section, SolverSettings
from fiv_cli.schedule import STEADY, Points, Schedule

if TYPE_CHECKING:
    from fiv_cli.friction.base import Law
    from fiv_cli.models.base import Model, Requirement

__all__ = [
    "STEADY",
    "Analysis",
    "Outcome",
    "Points",
    "Question",
    "Schedule",
    "Section",
    "Setting",
    "Setup",
    "SolverSettings",
    "Start",
    "Varied",
]


@dataclass(frozen=True)
class Setting:
    """One key of an ``[[analysis]]`` table.

    Attributes
    ----------
    name : key
    type : "number", "integer", "string", "boolean", "section" (a table, see `Section`), "state"
        (the name of a state of the model), "parameter" (that of a parameter of the model or the
        law, see `Varied`), "bracket" (its lowest and highest value, SI), "question" (a table, see
        `Question`) or "points" (on a disc: pairs of radius, m, and angle, rad)
    default : value when the key is left out; None: see `meaning`
    meaning : one line
    unit : unit of a number, for "30 s" strings
    choices : allowed strings
    minimum : least value; exclusive where `exclusive`
    required : must be given
    """

    name: str
    type: str
    default: Any
    meaning: str
    unit: str = "1"
    choices: tuple[str, ...] = ()
    minimum: float = float("-inf")
    exclusive: bool = False
    required: bool = False


@dataclass(frozen=True)
class Varied:
    """A parameter that an analysis itself varies.

    Attributes
    ----------
    name : contract name
    followers : parameters that take its value, because the case gives them no other
    unit : its unit
    """

    name: str
    followers: tuple[str, ...] = ()
    unit: str = "1"

    def at(self, parameters: Mapping[str, float], value: float) -> dict[str, float]:
        """`parameters` with this one, and what follows it, at `value` (SI)."""
        return {**parameters, **dict.fromkeys((self.name, *self.followers), value)}


@dataclass(frozen=True)
class Question:
    """A question that a run answers with yes or no.

    Attributes
    ----------
    variable : the variable that decides
    name : class asked for, where the variable holds a class
    negated : "not CLASS"
    below : the number that the variable must stay below; None: it holds a class
    counts : a run that is undecided when its time is up has an answer like any other
    """

    variable: str = "attractor"
    name: str = ""
    negated: bool = False
    below: float | None = None
    counts: bool = False


def broken(
    model: Model, law: Law, parameters: Mapping[str, float], linear: bool = False
) -> Requirement | None:
    """The first requirement of the model and its law that the parameters do not meet, if any."""
    return next((r for r in requirements(model, law, linear) if not r.holds(parameters)), None)


def requirements(model: Model, law: Law, linear: bool = False) -> list[Requirement]:
    """What the parameters of a point must be to one another; `linear`: no motion is followed."""
    own = (*model.requirements, *law.requirements)
    return [requirement for requirement in own if not (linear and requirement.in_motion)]


@dataclass(frozen=True)
class Start:
    """One start of a run, resolved for one point.

    Attributes
    ----------
    label : coordinate along dim ``initial``
    kind : "equilibrium" (of the unexcited system, plus `values` as offset), "state" (`values`,
        the rest 0) or "continue" (from `carried`; `values` is the offset from an equilibrium)
    values : state name -> SI value; velocities carry the suffix ``_dot``
    carried : what the neighbour's `Outcome.carry` held, for "continue"
    named : state -> parameter whose value it takes, among `values`
    """

    label: str
    kind: str
    values: Mapping[str, float] = field(default_factory=dict)
    carried: Mapping[str, Any] | None = None
    named: Mapping[str, str] = field(default_factory=dict)

    def at(self, parameters: Mapping[str, float]) -> Start:
        """The same start where the parameters have other values."""
        taken = {state: parameters[name] for state, name in self.named.items()}
        return replace(self, values={**self.values, **taken})


@dataclass
class Outcome:
    """What came of one run: an answer, or why there is none.

    Attributes
    ----------
    status : "ok", "failed", "budget", "not_reached" or "not_computed"
    reason : "" or a key of the table of reasons in ``fiv_cli/flags.py``
    values : variable name -> scalar, array (over the variable's own dims) or flag name
    ragged : variable name -> 1-D array of any length
    message : details for the log (may be empty)
    carry : plain dict of floats/arrays that a continuing neighbour starts from; None: class lost
    """

    status: str = "ok"
    reason: str = ""
    values: dict[str, Any] = field(default_factory=dict)
    ragged: dict[str, Any] = field(default_factory=dict)
    message: str = ""
    carry: dict[str, Any] | None = None


def _without_contact(model: Model) -> str:
    if model.contacts:
        return ""
    return f"{model.name} has no contact and does not move: only its modes can be computed"


@dataclass(frozen=True)
class Analysis:
    """An analysis: its settings and its function.

    Attributes
    ----------
    kind : name in case files
    title : one line
    settings : table of settings
    uses_starts : whether the dim ``initial`` exists
    run : ``(system, parameters, start, settings, solver) -> Outcome``; `start` is None where
        `uses_starts` is false; `settings` holds every setting, defaults filled in, a section as
        `Section`
    linear : no motion is followed: some requirements fall away, tangents are not carried
    varying : whether parameters may vary in time
    unsuited : model -> why it cannot be analysed so; empty where it can
    generated : whether `run` takes a compiled system; otherwise its `Setup` is enough
    chains : whether a point may continue from its neighbour along an axis
    recorded : ``(schedule) -> bool``: whether `run` follows a motion and no more, so that tangents
        are not needed nor, from a given state, equilibria
    sizes : ``(settings) -> {dim: coordinate values}`` of own dims that settings fix (``time``)
    """

    kind: str
    title: str
    settings: tuple[Setting, ...]
    uses_starts: bool
    run: Callable[..., Outcome]
    linear: bool = False
    varying: bool = False
    unsuited: Callable[[Model], str] = _without_contact
    generated: bool = True
    chains: bool = True
    recorded: Callable[[Schedule], bool] = lambda schedule: False
    sizes: Callable[[Mapping[str, Any]], Mapping[str, Any]] = lambda settings: {}
