"""What an analysis is: ``(system, request) -> Outcome``, or the same of many points at once.

To add an analysis:

1. write ``fiv_cli/analyses/QUESTION/my_kind.py`` with ``ANALYSIS = Analysis(...)``: its kind and
   title, its settings (``settings.py`` has their types), its variables (``variables.py`` says what
   there is to say of one), and the function that computes it. That function may stand in the same
   file if the file needs no engine to be imported; otherwise in a file of its own, named by
   `Later`;
2. list it in ``fiv_cli/analyses/__init__.py``;
3. add a row to ``tests/test_analyses.py`` and a case in ``configs/``.

An analysis knows nothing of workers and files.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import KW_ONLY, dataclass, field, replace
from functools import cached_property, lru_cache
from importlib import import_module
from typing import TYPE_CHECKING, Any

from fiv_cli.analyses.settings import Question, Settings, Varied
from fiv_cli.codegen.setup import Setup
from fiv_cli.dynamics.settings import Section, SolverSettings
from fiv_cli.models.excitation import at_every_phase
from fiv_cli.models.works import with_each_power
from fiv_cli.schedule import STEADY, Points, Schedule

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from fiv_cli.analyses.settings import Setting
    from fiv_cli.analyses.variables import Subject, Variable
    from fiv_cli.friction.base import Law
    from fiv_cli.models.base import Model, Requirement

__all__ = [
    "STEADY",
    "Analysis",
    "Later",
    "Outcome",
    "Points",
    "Question",
    "Request",
    "Schedule",
    "Section",
    "Settings",
    "Setup",
    "SolverSettings",
    "Start",
    "Varied",
]


AT_ONCE = 128
"""Points of which what can be found at once is."""

EACH = "each"
"""A choice of ``powers``."""


def broken(
    model: Model, law: Law, parameters: Mapping[str, float], linear: bool = False
) -> Requirement | None:
    """The first requirement of the model and its law that the parameters do not meet, if any."""
    return next((r for r in requirements(model, law, linear) if not r.holds(parameters)), None)


@lru_cache(maxsize=256)
def requirements(model: Model, law: Law, linear: bool = False) -> tuple[Requirement, ...]:
    """What the parameters of a point must be to one another; `linear`: no motion is followed."""
    own: Sequence[Requirement] = (*model.requirements, *law.requirements)
    if model.varied:
        table = {p.name: p for p in model.parameters_under(law)}
        own = at_every_phase(own, model.varied, table)
    return tuple(requirement for requirement in own if not (linear and requirement.in_motion))


def as_asked(model: Model, settings: Settings) -> Model:
    """The model as an analysis under these settings takes it."""
    return with_each_power(model) if settings.get("powers") == EACH else model


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
    named : state -> parameter whose value it takes, among `values`; after a minus the opposite
    from_rest : whether a motion that came to rest goes on from there, plus `values`, and not from
        the equilibrium that this point has
    literal : whether it begins in just the state of the neighbour, so that what stuck slips where
        the speed of its partner is another; else it sticks still, at that speed
    """

    label: str
    kind: str
    values: Mapping[str, float] = field(default_factory=dict)
    carried: Mapping[str, Any] | None = None
    named: Mapping[str, str] = field(default_factory=dict)
    from_rest: bool = False
    literal: bool = False

    def at(self, parameters: Mapping[str, float]) -> Start:
        """The same start where the parameters have other values."""
        taken = {state: value_of(name, parameters) for state, name in self.named.items()}
        return replace(self, values={**self.values, **taken})


def value_of(name: str, parameters: Mapping[str, float]) -> float:
    """Value of the parameter that a start names; of ``-NAME`` the opposite."""
    value = parameters[name.removeprefix("-")]
    return -value if name.startswith("-") else value


@dataclass
class Request:
    """One point of one analysis.

    Attributes
    ----------
    setup : the model, the law, and how they are taken
    parameters : every parameter of the model and of the law, SI
    analysis : kind
    settings : every setting of the analysis
    solver : integrator settings
    start : None where the analysis has no starts
    batch : the points that are run with this one, if any
    in_passing : whether no more is asked than to what rest or cycle the start leads: what has come
        to none by half of its time is not measured, and nothing goes on from it
    """

    setup: Setup
    parameters: Mapping[str, float]
    analysis: str
    settings: Settings
    solver: SolverSettings = field(default_factory=SolverSettings)
    start: Start | None = None
    batch: Batch | None = field(default=None, compare=False, repr=False)
    in_passing: bool = False


@dataclass(frozen=True, eq=False)
class Batch:
    """Points that are run one after the other, and what of them was found at once.

    Attributes
    ----------
    requests : the points; those on chains without their starts
    known : what was found, by what finds it, the system and the `id` of a point's parameters
    """

    requests: Sequence[Request]
    known: dict[tuple[object, object, int], Any] = field(default_factory=dict)

    def alike(self, request: Request) -> list[Request]:
        """The points in the same system."""
        key = request.setup.key
        return [one for one in self.requests if one.setup.key == key]

    def has(self, request: Request) -> bool:
        """Whether this is one of the points (the `id` of another may be given again)."""
        return id(request.parameters) in self._places

    @cached_property
    def _places(self) -> frozenset[int]:
        return frozenset(id(one.parameters) for one in self.requests)


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
    columns, row : further answers, of several points side by side, and which of them it is
    """

    status: str = "ok"
    reason: str = ""
    values: dict[str, Any] = field(default_factory=dict)
    ragged: dict[str, Any] = field(default_factory=dict)
    message: str = ""
    carry: dict[str, Any] | None = None
    columns: Columns | None = None
    row: int = 0

    def whole(self) -> Outcome:
        """The same without columns."""
        if self.columns is None:
            return self
        values, ragged = self.columns.at(self.row)
        return replace(self, values=values | self.values, ragged=ragged | self.ragged, columns=None)


@dataclass(frozen=True)
class Columns:
    """Answers of several points side by side.

    Attributes
    ----------
    values : variable name -> array, a row for each point
    ragged : variable name -> rows of all points, one after the other
    lengths : how many each has of these
    """

    values: dict[str, NDArray[Any]]
    ragged: dict[str, NDArray[Any]]
    lengths: NDArray[np.int64]

    def at(self, row: int) -> tuple[dict[str, Any], dict[str, Any]]:
        """Values and ragged variables of a point."""
        end = int(self.lengths[: row + 1].sum())
        begin = end - int(self.lengths[row])
        values = {name: array[row] for name, array in self.values.items()}
        return values, {name: array[begin:end] for name, array in self.ragged.items()}


def _without_contact(model: Model) -> str:
    if model.contacts:
        return ""
    return f"{model.name} has no contact and does not move: only its modes can be computed"


@dataclass(frozen=True)
class Later:
    """A function that is imported when it is called, so that a declaration needs no engine.

    Attributes
    ----------
    place : "module:function"
    """

    place: str

    @property
    def function(self) -> Callable[..., Any]:
        """The function."""
        module, name = self.place.split(":")
        found: Callable[..., Any] = getattr(import_module(module), name)
        return found

    def __call__(self, *arguments: object) -> Any:
        return self.function(*arguments)


@dataclass(frozen=True)
class Analysis:
    """An analysis: what it is asked, what computes it, and what it suits.

    Attributes
    ----------
    kind : name in case files
    title : one line
    settings : what a case may say of it
    variables : what its answers hold on a subject, without ``status`` and ``reason``
    run : ``(system, request) -> Outcome``; see `in_blocks`
    uses_starts : whether the dim ``initial`` exists
    linear : no motion is followed: some requirements fall away, tangents are not carried
    varying : whether parameters may vary in time
    constant : whether parameters may all be constant in time
    counterpart : the kind that is meant where they vary, or do not; "" where there is none
    unsuited : model -> why it cannot be analysed so; empty where it can
    in_blocks : whether `run` takes requests that differ in parameters and starts alone, and answers
        one after the other, with columns that may be filled when it has answered the last
    generated : whether `run` takes a compiled system; otherwise its `Setup` is enough
    chains : whether a point may continue from its neighbour along an axis
    recorded : whether `run` follows a motion and no more, so that tangents are not needed nor,
        from a given state, equilibria
    spans : settings that say for how long motions are followed; all work grows as these do
    single : whether one point says something, so that a template has no grid
    figure : kind of figure that shows its answer
    answer : what it gives, in a sentence, where the title does not say all
    """

    kind: str
    title: str
    settings: tuple[Setting, ...]
    variables: Callable[[Subject], Sequence[Variable]]
    run: Callable[..., Any]
    _: KW_ONLY
    uses_starts: bool = True
    linear: bool = False
    in_blocks: bool = False
    varying: bool = False
    constant: bool = True
    counterpart: str = ""
    unsuited: Callable[[Model], str] = _without_contact
    generated: bool = True
    chains: bool = True
    recorded: bool = False
    spans: tuple[str, ...] = ()
    single: bool = False
    figure: str = "curve"
    answer: str = ""

    @property
    def default_settings(self) -> dict[str, Any]:
        """Every setting as it is when a case leaves it out."""
        return {setting.name: setting.default for setting in self.settings}
