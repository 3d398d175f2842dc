"""A case, clean and complete: what a case file means once nothing in it is wrong."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from fiv_cli.analyses import get_analysis
from fiv_cli.analyses.base import SolverSettings
from fiv_cli.case.grammar import Expected
from fiv_cli.friction import get_law
from fiv_cli.models import get_model
from fiv_cli.models.base import Parameter, State, followed
from fiv_cli.models.origin import Origin
from fiv_cli.schedule import STEADY, Schedule

SEVERAL = ("random", "table")
"""Kinds of starts of which a table of the case holds several."""


@dataclass(frozen=True)
class Axis:
    """One axis of the grid.

    Attributes
    ----------
    name : canonical name: a parameter, an option, ``friction`` or ``initial.STATE``
    kind : "parameter", "option", "law" or "start"
    values : numbers in SI (the doubles nearest to the decimals written), or names
    """

    name: str
    kind: str
    values: tuple[Any, ...]

    @property
    def dim(self) -> str:
        """Name of the axis as a dim of the dataset (``initial.x_dot`` -> ``initial_x_dot``)."""
        return self.name.replace(".", "_")


@dataclass(frozen=True)
class Refinement:
    """How a coarse grid is halved along the borders of a class.

    Attributes
    ----------
    levels : how often
    of : variable that holds the class
    axes : names of the axes that are halved; those of the case hold the finest lattice
    sample : points of each map that are run although their class was filled in; None: a tenth of
        them, but no more than 100
    seed : seed of the sample
    """

    levels: int
    of: str
    axes: tuple[str, ...]
    sample: int | None
    seed: int


@dataclass(frozen=True)
class StartSpec:
    """One ``[[initial]]`` table.

    Attributes
    ----------
    label : unique; random starts and those of a table have labels ``label-000`` ...
    kind : "equilibrium", "state", "random", "table" or "continue"
    offset : state -> SI value (equilibrium, continue)
    state : state -> SI value; or "NAME", "-NAME": that of a parameter, or the opposite (state)
    count : number of random starts, or of those of a table
    seed, box : random starts; box is state -> (low, high)
    rows : state -> SI value, of each start of a table
    along, direction, from_label, on_loss, steps : continue
    """

    label: str
    kind: str
    offset: Mapping[str, float] = field(default_factory=dict)
    state: Mapping[str, float | str] = field(default_factory=dict)
    count: int = 1
    seed: int = 0
    box: Mapping[str, tuple[float, float]] = field(default_factory=dict)
    rows: tuple[Mapping[str, float], ...] = ()
    along: str = ""
    direction: str = "up"
    from_label: str = ""
    on_loss: str = "stop"
    steps: str = "shorter"

    @property
    def size(self) -> int:
        """How many starts there are."""
        return self.count if self.kind in SEVERAL else 1

    @property
    def labels(self) -> tuple[str, ...]:
        """Its values of the dim ``initial``."""
        numbered = (f"{self.label}-{i:03d}" for i in range(self.size))
        return tuple(numbered) if self.kind in SEVERAL else (self.label,)


@dataclass(frozen=True)
class AnalysisSpec:
    """One ``[[analysis]]`` table: `settings` holds every setting, defaults filled in."""

    name: str
    kind: str
    settings: Mapping[str, Any]

    @property
    def told(self) -> dict[str, Any]:
        """The settings without those that came later and are at their default."""
        own = {one.name: one.default for one in get_analysis(self.kind).settings if one.later}
        return {key: v for key, v in self.settings.items() if key not in own or v != own[key]}


@dataclass(frozen=True)
class FigureSpec:
    """One ``[[figure]]`` table."""

    name: str
    kind: str
    settings: Mapping[str, Any]


@dataclass(frozen=True)
class ClaimSpec:
    """One ``[[claim]]`` table: what the publication says, as a check."""

    source: str
    text: str
    variable: str
    expect: Expected
    at: Mapping[str, Any] = field(default_factory=dict)
    holds: str | float = "all"
    note: str = ""
    analysis: str = ""
    take: Mapping[str, Any] = field(default_factory=dict)
    undecided_counts: bool = False


@dataclass(frozen=True)
class Case:
    """A valid case.

    Attributes
    ----------
    source : path as given on the command line
    text : the file verbatim
    overrides : the ``--set`` lines, verbatim, in order
    options : every option of the model (those that are axes hold their default)
    law : contract name (``tanh of coulomb``); the first one when the law is an axis
    parameters : every parameter of model and law(s), SI; those that are axes are left out. Where
        the laws of an axis ``friction`` differ in one, it stands as ``LAW.NAME``; `parameters_at`
        gives what holds at a point
    explicit : names of the parameters that the case itself gives
    axes : the grid, in order
    zips : groups of axis names that advance together
    refinement : None: every point of the grid is run
    schedule : parameters that vary in time; `parameters` holds their values at t = 0
    own : model or law that is not in the box -> where it stands
    """

    source: str
    text: str
    overrides: tuple[str, ...]
    title: str
    reference: str
    assumed: tuple[str, ...]
    model: str
    options: Mapping[str, str]
    law: str
    parameters: Mapping[str, float]
    explicit: tuple[str, ...]
    axes: tuple[Axis, ...]
    zips: tuple[tuple[str, ...], ...]
    starts: tuple[StartSpec, ...]
    analyses: tuple[AnalysisSpec, ...]
    figures: tuple[FigureSpec, ...]
    claims: tuple[ClaimSpec, ...]
    solver: SolverSettings
    refinement: Refinement | None = None
    schedule: Schedule = STEADY
    own: Mapping[str, Origin] = field(default_factory=dict)

    def axis(self, name: str) -> Axis:
        """The axis called `name`; KeyError when there is none."""
        for axis in self.axes:
            if axis.name == name:
                return axis
        raise KeyError(name)

    @property
    def laws(self) -> tuple[str, ...]:
        """Contract names of the laws in use."""
        return next((axis.values for axis in self.axes if axis.kind == "law"), (self.law,))

    @property
    def internal(self) -> tuple[State, ...]:
        """The states of the laws in use, and what they store."""
        return tuple(dict.fromkeys(state for law in self.laws for state in get_law(law).inner))

    @property
    def reach(self) -> float:
        """Slip speed up to which every law in use is known, m/s."""
        return min((get_law(law).reach for law in self.laws), default=float("inf"))

    @property
    def varying(self) -> tuple[Parameter, ...]:
        """The parameters that vary in time."""
        model = get_model(self.model)
        table = model.parameters_under(get_law(self.law))
        return tuple(p for p in table if p.name in self.schedule.names)

    def parameters_at(self, law: str, varied: Mapping[str, float]) -> dict[str, float]:
        """Every parameter of the model and of `law` at one point of the grid, SI.

        Parameters
        ----------
        law : contract name of the law at this point
        varied : values of the axes that are parameters; those that `law` lacks are left out

        Returns
        -------
        parameter -> value in the order of the model's and the law's tables. A parameter that
        follows another one (`Parameter.default_from`) takes that one's value at this point.
        """
        model = get_model(self.model)
        own = model.parameters_under(get_law(law))
        given = {**self.parameters, **_of_law(self.parameters, law), **varied}
        return followed(own, given)


def _of_law(parameters: Mapping[str, float], law: str) -> dict[str, float]:
    """The parameters kept as ``LAW.NAME`` for this law, by their bare names."""
    prefix = f"{law}."
    return {
        name.removeprefix(prefix): value
        for name, value in parameters.items()
        if name.startswith(prefix)
    }
