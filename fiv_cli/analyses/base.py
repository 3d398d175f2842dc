"""What an analysis is: ``(system, parameters, start, settings) -> Outcome``.

To add an analysis: write ``fiv_cli/analyses/my_kind.py`` with its `SETTINGS` table, a function
``run`` and ``ANALYSIS = Analysis(...)``; list it in ``fiv_cli/analyses/__init__.py``; add its
variables to ``fiv_cli/data/variables.py``. An analysis knows nothing of workers and files.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any


@dataclass(frozen=True)
class Setting:
    """One key of an ``[[analysis]]`` table.

    Attributes
    ----------
    name : key
    type : "number", "integer", "string", "boolean", "section" (a table, see `Section`) or
        "state" (the name of a state of the model)
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
class Section:
    """A Poincaré section.

    Attributes
    ----------
    kind : "event" (a transition), "zero" (a velocity passes zero) or "phase" (stroboscopic)
    event : "slip->stick" or "stick->slip" when kind is "event"
    state : velocity state, e.g. ``x1_dot``, when kind is "zero"
    direction : "up", "down" or "both" when kind is "zero"
    phase : phase of the excitation, rad, when kind is "phase"
    contact : contact of the event, 1-based
    """

    kind: str
    event: str = "slip->stick"
    state: str = ""
    direction: str = "both"
    phase: float = 0.0
    contact: int = 1


@dataclass(frozen=True)
class SolverSettings:
    """How motions are integrated.

    Attributes
    ----------
    method : "taylor" or "rk4"
    rtol : relative tolerance of a Taylor step
    step : step of rk4, s (ignored by taylor)
    max_events : events after which a run ends with status "budget"
    max_steps : steps after which a run ends with status "budget"
    """

    method: str = "taylor"
    rtol: float = 1e-9
    step: float = 1e-3
    max_events: int = 1_000_000
    max_steps: int = 50_000_000


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
    """

    label: str
    kind: str
    values: Mapping[str, float] = field(default_factory=dict)
    carried: Mapping[str, Any] | None = None


@dataclass
class Outcome:
    """What came of one run: an answer, or why there is none.

    Attributes
    ----------
    status : "ok", "failed", "budget", "not_reached" or "not_computed"
    reason : "" or a key of the table of reasons in ``fiv_cli/data/flags.py``
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
    linear : True where mu_k > mu_s is harmless
    sizes : ``(settings) -> {dim: coordinate values}`` of own dims that settings fix (``time``)
    """

    kind: str
    title: str
    settings: tuple[Setting, ...]
    uses_starts: bool
    run: Callable[..., Outcome]
    linear: bool = False
    sizes: Callable[[Mapping[str, Any]], Mapping[str, Any]] = lambda settings: {}
