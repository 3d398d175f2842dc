"""What there is to say of a variable of a dataset: its name, unit, meaning, own dims, and its role.

Each analysis declares its own (`Analysis.variables`); shards, assembly, NetCDF attributes,
comparison, summaries, figures and what a case may ask for read them through ``catalogue.py``.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping
from dataclasses import KW_ONLY, dataclass, field
from enum import Enum, auto
from typing import TypedDict, Unpack

from fiv_cli.analyses.settings import Section, Settings, Varied
from fiv_cli.models.base import State
from fiv_cli.notation.names import dotted_symbol

INT_FILL = -2147483647
"""Stands for "not computed" in integer variables (the NetCDF default for int32)."""


class Role(Enum):
    """What a variable is there for."""

    STATUS = auto()  # whether a point was computed, and how: known at every point
    ANSWER = auto()  # a number that the analysis is asked for
    CLASS = auto()  # an answer that is one of a few classes
    SHARE = auto()  # share of time, measured over a motion of any class, an undecided one too
    DETAIL = auto()  # what an answer refers to, or what was met on the way to it
    TRUST = auto()  # how far an answer can be trusted
    WORK = auto()  # what an answer has cost
    ALONG = auto()  # a coordinate along a dim of its own: no dims of the grid


@dataclass(frozen=True)
class Variable:
    """One variable of a dataset.

    Attributes
    ----------
    name : name in datasets and in `Outcome.values` / `Outcome.ragged`
    units : UDUNITS string
    long_name : what it is
    along : its own dims, after those of the grid and ``initial``, separated by spaces
    kind : "float", "int" or "flag"
    flags : key of `flags.TABLES` when kind is "flag"
    ragged : name of the group of ragged arrays it belongs to ("" when it is not ragged)
    symbol : LaTeX
    comment : what else a reader must know
    role : what it is there for
    headline : place among what a figure shows unless it says otherwise; 0: not among these
    width : name of the variable that holds the width of the interval it was bisected to
    statistic : a mean over the motion: two computations of a motion that is not periodic agree in
        it, and in no other number, but for the error of a finite window
    unbounded : has no bound where the motion diverges
    margin : the least is the worst
    velocities : its dim ``state`` holds the velocities too, behind the displacements
    derived : it stands in no file: fiv makes it of others when it reads one
    """

    name: str
    units: str
    long_name: str
    along: str = ""
    _: KW_ONLY
    kind: str = "float"
    flags: str = ""
    ragged: str = ""
    symbol: str = ""
    comment: str = ""
    role: Role = Role.ANSWER
    headline: int = 0
    width: str = ""
    statistic: bool = False
    unbounded: bool = False
    margin: bool = False
    velocities: bool = False
    derived: bool = False

    @property
    def is_class(self) -> bool:
        """Whether it has one of a few values at each point, and borders between them."""
        bordered = self.role not in (Role.STATUS, Role.WORK) and self.one_per_point
        return bordered and self.kind in ("flag", "int")

    @property
    def dims(self) -> tuple[str, ...]:
        """Own dims, after those of the grid and ``initial``."""
        return tuple(self.along.split())

    @property
    def sample_dim(self) -> str:
        """Dim along which its ragged group is stored."""
        return f"{self.ragged}_obs"

    @property
    def one_per_point(self) -> bool:
        """Whether it has one value at each point."""
        return self.role is not Role.ALONG and not self.along and not self.ragged

    @property
    def askable(self) -> bool:
        """Whether a question about a run can be about this number, or about one of some contact."""
        answers = self.role in (Role.ANSWER, Role.SHARE) and self.kind != "flag"
        return answers and (self.one_per_point or (self.along == "contact" and not self.ragged))

    @property
    def tells_trust(self) -> bool:
        """Whether it says how an answer was reached, and is none itself."""
        return self.role in (Role.TRUST, Role.WORK)


class Facts(TypedDict, total=False):
    """What may be said of a variable besides, see `Variable`."""

    ragged: str
    symbol: str
    comment: str
    role: Role
    headline: int


def classes(
    name: str, long_name: str, along: str = "", of: str = "", **facts: Unpack[Facts]
) -> Variable:
    """A flag variable; `of` names its table where that has another name."""
    facts.setdefault("role", Role.CLASS)
    return Variable(name, "1", long_name, along, kind="flag", flags=of or name, **facts)


def detail(
    name: str, long_name: str, along: str = "", of: str = "", **facts: Unpack[Facts]
) -> Variable:
    """A flag variable that was met on the way to an answer; its classes are not counted."""
    facts["role"] = Role.DETAIL
    return classes(name, long_name, along, of, **facts)


def count(name: str, long_name: str, along: str = "", **facts: Unpack[Facts]) -> Variable:
    """A whole number."""
    return Variable(name, "1", long_name, along, kind="int", **facts)


def axis(name: str, units: str, long_name: str, along: str = "", symbol: str = "") -> Variable:
    """A coordinate along a dim that no grid has, of its own name unless `along` says another."""
    return Variable(name, units, long_name, along or name, role=Role.ALONG, symbol=symbol)


def share(name: str, long_name: str, along: str) -> Variable:
    """A share of the time of a motion."""
    return Variable(name, "1", long_name, along, role=Role.SHARE, statistic=True)


def trust(name: str, long_name: str, along: str = "", **facts: Unpack[Facts]) -> Variable:
    """A pure number that says how far to trust an answer."""
    facts["role"] = Role.TRUST
    return Variable(name, "1", long_name, along, **facts)


STATUS = classes("status", "whether the point was computed", role=Role.STATUS)
REASON = classes("reason", "why there is no better answer", role=Role.STATUS)
COMPUTED = classes(
    "computed",
    "whether the point was run, or its class filled in from those around it",
    role=Role.STATUS,
    comment="sampled: filled in first, then run all the same",
)
"""Beside these two where the grid was refined."""


@dataclass(frozen=True)
class Subject:
    """What the variables of an analysis depend on.

    Attributes
    ----------
    states : displacements of the model
    contact : the dim of its contacts; "" where it has one only
    surface : whether it has an elastic disc to look at
    settings : settings of the analysis
    internal : states of the friction laws in use, and what they store
    powers : excitation that does work -> what it is, in words
    stops : how many of the contacts are stops
    """

    states: tuple[State, ...]
    contact: str
    surface: bool
    settings: Settings
    internal: tuple[State, ...] = ()
    powers: Mapping[str, str] = field(default_factory=dict)
    stops: int = 0

    @property
    def varied(self) -> Varied:
        """The parameter that the analysis itself varies, where it varies one."""
        varied: Varied = self.settings["parameter"]
        return varied

    @property
    def observed(self) -> tuple[str, str]:
        """The state that is looked at, and its unit."""
        units = {name: unit for name, unit, _, _ in motions(self.states)}
        name = self.settings.get("observe") or self.states[0].name
        return name, units[name]

    @property
    def units(self) -> list[str]:
        """The units that displacements have, each once."""
        return sorted({state.unit for state in self.states})

    def of_states(self, power: str = "") -> str:
        """Unit of what holds every displacement (to a `power`); "1" where they have several."""
        return f"{self.units[0]}{power}" if len(self.units) == 1 else "1"

    @property
    def mixed(self) -> str:
        """What must be said of a variable over the displacements."""
        return "each state in its own unit (state_units)" if len(self.units) > 1 else ""


def rate_unit(unit: str) -> str:
    """Unit of the time derivative of a quantity in `unit`."""
    return "s-1" if unit == "1" else f"{unit} s-1"


def motions(states: tuple[State, ...]) -> list[tuple[str, str, str, str]]:
    """(name, unit, symbol, meaning) of every state, then of every velocity."""
    positions = [(s.name, s.unit, s.symbol, s.meaning) for s in states]
    velocities = [
        (f"{s.name}_dot", rate_unit(s.unit), dotted_symbol(s.symbol), f"velocity: {s.meaning}")
        for s in states
    ]
    return positions + velocities


SLIP_BEYOND = Variable(
    "slip_beyond",
    "m s-1",
    "greatest slip speed, where friction was not measured that far",
    comment="of motions at the ends of steps; of a drive, over what rests",
    role=Role.TRUST,
)
"""Of every analysis under a law that is known up to a slip speed."""

# --- what several analyses have -------------------------------------------------------------------
ATTRACTOR = classes("attractor", "class of the steady state", headline=1)
PERIOD = Variable("period", "s", "period of the attractor", symbol="T", headline=2)
MULTIPLICITY = count("multiplicity", "section points per period")
PERIOD_RATIO = Variable("period_ratio", "1", "period over the period of the excitation")

OF_SOLVER = (
    trust("energy_residual", "largest energy imbalance over the energy exchanged"),
    count("n_steps", "integration steps", role=Role.WORK),
    count("n_events", "events (transitions of contact)", role=Role.WORK),
)
"""What every motion says of itself, ..."""

OF_MOTION = (*OF_SOLVER, trust("event_residual", "largest switching function left at an event"))
"""... and one that keeps no ledger of its events."""

GROUNDS = (
    Variable(
        "decay_margin",
        "1",
        "share of the way to the nearest switching surface that a slide to rest leaves free",
        comment="of the level set through the motion when its class was told; equilibria only",
        role=Role.TRUST,
        margin=True,
    ),
    trust(
        "cycle_residual",
        "miss of the cycle after a period, over its extent",
        comment="of the cycle that Newton's method found; periodic motions only",
    ),
    trust(
        "section_drift",
        "difference between the halves of the section set, over its spread; 0: stationary",
        comment="of means and spreads, the largest beyond what sampling explains",
    ),
)
"""By how much a class meets its grounds (`analyses/attractor/grounds.py`)."""

TRANSIENT_USED = Variable(
    "transient_used", "s", "time simulated before the steady state was accepted", role=Role.WORK
)

OF_STEADY_STATE = (*GROUNDS, *OF_MOTION, TRANSIENT_USED)
"""How a steady state was reached, and how far to trust its class."""

_NO_WAY = (
    "1 for the way along the cycle where nothing outside beats time; zero for what contact "
    "determines: a slip velocity that sticks, and the transverse position and velocity of a slider "
    "in rigid contact"
)
MULTIPLIERS = (
    Variable("floquet_multiplier", "1", "modulus of the multiplier", "multiplier", comment=_NO_WAY),
    Variable("floquet_multiplier_real", "1", "real part of the multiplier", "multiplier"),
    Variable("floquet_multiplier_imag", "1", "imaginary part", "multiplier"),
)
"""Floquet multipliers of a periodic motion."""


INITIAL_STATE = Variable(
    "initial_state",
    "1",
    "state that the motion begins in",
    "state",
    comment="each state in its own unit (state_units); missing where another version computed it",
    role=Role.DETAIL,
    velocities=True,
)


def section_value(subject: Subject) -> Variable:
    """The observed state wherever a steady motion passes the section."""
    observed, unit = subject.observed
    return Variable("section_value", unit, f"{observed} at the section", ragged="section")


def own_section(subject: Subject) -> list[Variable]:
    """Which section the motion chose, where the case leaves that to it."""
    if subject.settings.get("section") != Section("own"):
        return []
    event = "contact that the section is an event of, counted from 1"
    return [
        detail(
            "section_kind", "section that section_value lies on", of="section",
            comment="turning_point: the coordinate that is observed is least",
        ),
        count("section_contact", event, role=Role.DETAIL),
    ]  # fmt: skip


def impacts(subject: Subject, when: str) -> list[Variable]:
    """What is counted at stops."""
    if not subject.stops:
        return []
    piled_up = "impacts whose flights piled up until the stop stayed closed"
    return [
        count("n_impacts", f"impacts on stops {when}", role=Role.DETAIL),
        count("n_accumulations", f"{piled_up} {when}", role=Role.DETAIL),
    ]


def extremes(states: tuple[State, ...], *, rms: bool) -> list[Variable]:
    """The bounds of a steady motion, and its mean size."""
    words = {"min": "least", "max": "greatest"} | ({"rms": "root mean square of"} if rms else {})
    return [
        Variable(
            f"{name}_{end}", unit, f"{word} {name} in the steady state", unbounded=end != "min"
        )
        for name, unit, _, _ in motions(states)
        for end, word in words.items()
    ]


def amplitude(name: str, units: str) -> Variable:
    """Half the range of a steady motion: its size, without the offset that its extremes have."""
    return Variable(
        f"{name}_amplitude",
        units,
        f"amplitude of {name}",
        comment=f"({name}_max - {name}_min)/2",
        unbounded=True,
        derived=True,
    )


def extremes_of(name: str) -> tuple[str, str]:
    """What an amplitude is half the distance of."""
    stem = name.removesuffix("_amplitude")
    return f"{stem}_min", f"{stem}_max"


def ranged(names: Collection[str]) -> list[str]:
    """What has both a least and a greatest value among these names of variables."""
    stems = (name.removesuffix("_max") for name in names if name.endswith("_max"))
    return [stem for stem in stems if f"{stem}_min" in names]


def derived(variables: Iterable[Variable]) -> list[Variable]:
    """What fiv makes of these variables of an analysis when it reads them."""
    units = {variable.name: variable.units for variable in variables if variable.one_per_point}
    return [amplitude(stem, units[f"{stem}_max"]) for stem in ranged(units)]
