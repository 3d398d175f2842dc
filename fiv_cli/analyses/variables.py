"""The one table of dataset variables: names, units, meanings, own dims, flags, and their roles.

To add a variable: add it to the function of its analysis. Everything else (shards, assembly, NetCDF
attributes, comparison, summaries, figures, what a case may ask for) reads it from here.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import KW_ONLY, dataclass
from enum import Enum, auto
from functools import cache
from typing import Any, TypedDict, Unpack

from fiv_cli.analyses.base import Varied
from fiv_cli.models.base import Model, Options, Parameter, State

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
        """Whether a question about a run can be about this number."""
        answers = self.role in (Role.ANSWER, Role.SHARE) and self.kind != "flag"
        return answers and self.one_per_point

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
    """

    states: tuple[State, ...]
    contact: str
    surface: bool
    settings: Mapping[str, Any]

    @property
    def varied(self) -> Varied | None:
        """The parameter that the analysis itself varies."""
        return self.settings.get("parameter")

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


def variables_of(
    kind: str,
    model: Model,
    options: Options,
    settings: Mapping[str, Any],
    varying: tuple[Parameter, ...] = (),
) -> tuple[Variable, ...]:
    """Every variable of an analysis of `kind` on `model`, ``status`` and ``reason`` first.

    Parameters
    ----------
    kind : kind of the analysis
    options : options of the model (they decide its states)
    settings : settings of the analysis (``observe`` decides the unit of ``section_value``)
    varying : parameters that vary in time; each is a variable over ``time``
    """
    contact = "contact" if model.contacts > 1 else ""
    subject = Subject(model.states(options), contact, model.surface is not None, settings)
    own = _BY_KIND[kind](subject)
    over_time = [Variable(p.name, p.unit, p.meaning, "time", symbol=p.symbol) for p in varying]
    return (STATUS, REASON, *own, *over_time)


_ANYTHING = Subject(
    states=(State("state", "x", "1", "any state"),),
    contact="contact",
    surface=True,
    settings={
        "parameter": Varied("parameter"), "follow": "both", "points": ((0.0, 0.0),),
        "system": "averaged",
    },
)  # fmt: skip
"""A subject of which every analysis has all the variables that it can have."""


def possible_variables(kind: str) -> list[Variable]:
    """Every variable that an analysis of `kind` can have, on a model with a state ``state``."""
    return _BY_KIND[kind](_ANYTHING)


@cache
def every_variable() -> Mapping[str, Variable]:
    """All variables that there are, by name; the state ``state`` stands for those of any model."""
    known = [v for kind in _BY_KIND for v in possible_variables(kind)]
    return {v.name: v for v in (STATUS, REASON, COMPUTED, *known)}


def named(name: str) -> Variable:
    """What is known of the variable of this name, in a dataset of any model, from its name alone.

    Role and all that goes with it, not its unit or dims. The states of a model and what this
    version does not know are plain answers.
    """
    known, ending = every_variable(), name.rpartition("_")[2]
    plain = Variable(name, "1", name)
    return known.get(name) or known.get(f"state_{ending}") or plain


def own_dims() -> list[str]:
    """The dims that variables have besides those of the grid."""
    return list(dict.fromkeys(dim for v in every_variable().values() for dim in v.dims))


def rate_unit(unit: str) -> str:
    """Unit of the time derivative of a quantity in `unit`."""
    return "s-1" if unit == "1" else f"{unit} s-1"


def motions(states: tuple[State, ...]) -> list[tuple[str, str, str, str]]:
    """(name, unit, symbol, meaning) of every state, then of every velocity."""
    positions = [(s.name, s.unit, s.symbol, s.meaning) for s in states]
    velocities = [
        (f"{s.name}_dot", rate_unit(s.unit), rf"\dot{{{s.symbol}}}", f"velocity: {s.meaning}")
        for s in states
    ]
    return positions + velocities


# --- what several analyses have -------------------------------------------------------------------
ATTRACTOR = classes("attractor", "class of the steady state", headline=1)
PERIOD = Variable("period", "s", "period of the attractor", symbol="T")
MULTIPLICITY = count("multiplicity", "section points per period")
PERIOD_RATIO = Variable("period_ratio", "1", "period over the period of the excitation")

OF_SOLVER = (
    trust("energy_residual", "largest energy imbalance over the energy exchanged"),
    count("n_steps", "integration steps", role=Role.WORK),
    count("n_events", "events (transitions of contact)", role=Role.WORK),
)  # fmt: skip
"""What every motion says of itself."""

EVENT_RESIDUAL = trust("event_residual", "largest switching function left at an event")

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

OF_STEADY_STATE = (*GROUNDS, *OF_SOLVER, EVENT_RESIDUAL, TRANSIENT_USED)
"""How a steady state was reached, and how far to trust its class."""

_NO_WAY = (
    "zero for what contact determines: a slip velocity that sticks, and the transverse position "
    "and velocity of a slider in rigid contact"
)
MULTIPLIERS = (
    Variable("floquet_multiplier", "1", "modulus of the multiplier", "multiplier", comment=_NO_WAY),
    Variable("floquet_multiplier_real", "1", "real part of the multiplier", "multiplier"),
    Variable("floquet_multiplier_imag", "1", "imaginary part", "multiplier"),
)
"""Floquet multipliers of a periodic motion."""


def _section_value(subject: Subject) -> Variable:
    observed, unit = subject.observed
    return Variable("section_value", unit, f"{observed} at the section", ragged="section")


def _extremes(states: tuple[State, ...], *, rms: bool) -> list[Variable]:
    """The bounds of a steady motion, and its mean size."""
    words = [("min", "least"), ("max", "greatest")] + rms * [("rms", "root mean square of")]
    return [
        Variable(f"{name}_{ending}", unit, f"{word} {name} in the steady state",
                 unbounded=ending != "min")
        for name, unit, _, _ in motions(states)
        for ending, word in words
    ]  # fmt: skip


def _averaging(settings: Mapping[str, Any], along: str = "") -> list[Variable]:
    """How far an averaged system can be trusted."""
    if settings.get("system") != "averaged":
        return []
    comment = "of the averaged system without damping; below 5 averaging is in doubt"
    name = "excitation frequency over the highest natural one"
    return [Variable("averaging_ratio", "1", name, along, comment=comment)]


# --- motions --------------------------------------------------------------------------------------
def _history(subject: Subject) -> list[Variable]:
    at_contacts = f"{subject.contact} time"
    return [
        axis("time", "s", "time", symbol="t"),
        *(Variable(n, u, m, "time", symbol=s) for n, u, s, m in motions(subject.states)),
        Variable("F_T", "N", "tangential contact force", at_contacts, symbol="F_T"),
        Variable("F_N", "N", "normal contact force", at_contacts, symbol="F_N"),
        classes("contact_state", "state of contact", at_contacts, role=Role.DETAIL),
        Variable("kinetic_energy", "J", "kinetic energy", "time"),
        Variable("potential_energy", "J", "potential energy", "time"),
        Variable("friction_power", "W", "power of friction on the model", "time"),
        Variable("drive_power", "W", "power of the drive", "time"),
        Variable("other_power", "W", "power of all other forces", "time"),
        Variable("friction_work", "J", "work of friction on the model"),
        Variable("drive_work", "J", "work of the drive"),
        Variable("other_work", "J", "work of all other forces"),
        Variable("impact_loss", "J", "energy lost in impacts"),
        *_EVENTS,
        *(_SURFACE if subject.settings.get("points") else ()),
        *OF_SOLVER,
    ]


_EVENTS = (
    Variable("event_time", "s", "instant of the event", ragged="event"),
    classes(
        "event_from", "contact before", of="contact_state", ragged="event", role=Role.DETAIL
    ),
    classes("event_to", "contact after", of="contact_state", ragged="event", role=Role.DETAIL),
    count("event_contact", "contact, counted from 1", ragged="event"),
    trust("event_residual", "switching function left at the event", ragged="event"),
)  # fmt: skip

_SURFACE = (
    Variable("w", "m", "transverse displacement of the disc", "point time", symbol="w"),
    axis("point_radius", "m", "radius of the point", "point", symbol="r"),
    axis("point_angle", "rad", "angle of the point", "point", symbol=r"\theta"),
)
"""The displacement of a disc at points that are fixed in space."""


# --- rest -----------------------------------------------------------------------------------------
def _equilibrium(subject: Subject) -> list[Variable]:
    at_contacts = f"solution {subject.contact}"
    return [
        Variable(
            "equilibrium",
            subject.of_states(),
            "sliding equilibrium of the unexcited system",
            "solution state",
            comment=subject.mixed,
        ),
        count(
            "n_solutions",
            "sliding equilibria with closed contacts",
            comment="the first is the one that growing loads lead to, then by distance from it",
            headline=1,
        ),
        count("n_pulling", "real solutions in which a contact would pull"),
        count("n_complex", "solutions that are not real"),
        classes("complete", "whether these are all the solutions"),
        Variable("F_N", "N", "normal contact force", at_contacts, symbol="F_N"),
        Variable("F_T", "N", "tangential contact force", at_contacts, symbol="F_T"),
        trust("residual", "largest acceleration left", "solution"),
        *(_DISPLACEMENT if subject.surface else ()),
    ]


_DISPLACEMENT = (Variable("w", "m", "displacement of the disc at the contact", "solution"),)


def _eigenvalues(subject: Subject) -> list[Variable]:
    mixed = "each state in its own unit; scaled to length one"
    return [
        Variable("eigenvalue_real", "rad s-1", "real part of the eigenvalue", "mode"),
        Variable("eigenvalue_imag", "rad s-1", "imaginary part of the eigenvalue", "mode"),
        Variable("mode_frequency", "Hz", "frequency of the mode", "mode"),
        Variable("damping_ratio", "1", "damping ratio of the mode", "mode"),
        Variable(
            "eigenvector_real", "1", "real part of the eigenvector", "mode state",
            comment=mixed, velocities=True,
        ),
        Variable(
            "eigenvector_imag", "1", "imaginary part of the mode", "mode state",
            comment=mixed, velocities=True,
        ),
        count("coupled_with", "mode of equal frequency; -1: none", "mode"),
        Variable(
            "coupling_point",
            "1",
            "where on the longest numeric axis the mode merges with another, before the next point",
            "mode",
            comment="between the points, where the two come to differ more in growth than in "
            "frequency, and in both by less than 1 %; with more damping they pass at a distance",
        ),
        Variable("growth_rate", "rad s-1", "largest real part", headline=1),
        classes(
            "stable",
            "whether the equilibrium is stable",
            comment="neutral: the largest real part is zero to rounding, as without damping",
            headline=1,
        ),
        *_averaging(subject.settings),
    ]  # fmt: skip


def _critical(subject: Subject) -> list[Variable]:
    varied = subject.settings["parameter"]
    ranked = "as at the lower end of the bracket, by rising frequency from 0; followed from there"
    moves = f"what the mode (or the equilibrium) does as {varied.name} rises"
    return [
        Variable(
            "critical_value", varied.unit, f"critical value of {varied.name}", "crossing",
            headline=1, width="critical_width",
        ),
        Variable("critical_width", varied.unit, "width of the interval that holds it", "crossing"),
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
        *_averaging(subject.settings, "crossing"),
    ]  # fmt: skip


def _plate(subject: Subject) -> list[Variable]:
    comment = "R(r0)^2/M: how a unit force at r0 accelerates the mode there; 0: a node"
    return [
        axis("k", "1", "nodal circles"),
        axis("l", "1", "nodal diameters"),
        Variable("radius", "m", "radius", "r", symbol="r"),
        Variable("plate_frequency", "rad s-1", "natural frequency of the disc", "k l"),
        Variable("inverse_modal_mass", "kg-1", "inverse modal mass at r0", "k l", comment=comment),
        Variable("shape", "1", "mode shape R(r)/R(r0)", "k l r"),
    ]


# --- steady states --------------------------------------------------------------------------------
def _response(subject: Subject) -> list[Variable]:
    states, contact = subject.states, subject.contact
    return [
        ATTRACTOR,
        Variable(
            "L_s",
            subject.of_states("2"),
            "vibration intensity: mean squared distance from the sliding equilibrium",
            symbol="L_s",
            comment="thesis 6.20, on discs 6.42 (of the slider alone); over one period, or over "
            "L_s_window; 0 at the equilibrium",
            headline=1,
            statistic=True,
            unbounded=True,
        ),
        *_reference(subject),
        Variable(
            "L_s_window", "s", "window of L_s, of extremes and of fractions", role=Role.DETAIL
        ),
        PERIOD,
        MULTIPLICITY,
        PERIOD_RATIO,
        Variable("response_frequency", "Hz", "one over the period"),
        _section_value(subject),
        share("stick_fraction", "share of time in stick", contact),
        share("slip_fraction", "share of time in slip", contact),
        share("separation_fraction", "share of time in separation", contact),
        *_extremes(states, rms=True),
        Variable("lyapunov", "s-1", "largest nontrivial Lyapunov exponent"),
        *MULTIPLIERS,
        *OF_STEADY_STATE,
    ]


def _reference(subject: Subject) -> list[Variable]:
    """The equilibria that a steady state is measured from, and comes to rest at."""
    return [
        Variable(
            "L_s_reference",
            subject.of_states(),
            "sliding equilibrium that L_s is measured from",
            "state",
            comment=subject.mixed,
            role=Role.DETAIL,
        ),
        count(
            "L_s_reference_index",
            "number of that equilibrium among the solutions of `equilibrium`, from 1",
            comment="the one reached; of a motion that does not rest, the first, from which a "
            "start of kind `equilibrium` is offset too",
            role=Role.DETAIL,
        ),
        count(
            "equilibrium_index",
            "number of the equilibrium reached, among the solutions of `equilibrium`, from 1",
            role=Role.DETAIL,
        ),
    ]


def _boundary(subject: Subject) -> list[Variable]:
    varied, sides = subject.settings["parameter"], "class of the steady state"
    way = "direction in which it was met; none: every run begins at the start"
    confirmed = "distance within which runs in shorter steps and with more time find it; missing "
    confirmed += "where a side is open or they do not find it"
    return [
        Variable(
            "boundary", varied.unit, f"{varied.name} at which the answer changes", "crossing",
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
        classes(
            "answer_below", "answer to the question below", "crossing", of="answer",
            role=Role.DETAIL,
        ),
        classes(
            "answer_above", "answer to the question above", "crossing", of="answer",
            role=Role.DETAIL,
        ),
        classes("found_going", way, "crossing", of="followed", role=Role.DETAIL),
        count("n_crossings", "changes in the bracket"),
        count("n_runs", "responses computed"),
        count("n_undecided", "responses without an answer"),
        axis("scan", varied.unit, f"{varied.name} looked at first"),
        classes("scan_class", f"{sides} there", "scan", of="attractor", role=Role.DETAIL),
        *(_way_back(varied.unit, sides) if subject.settings["follow"] == "both" else ()),
        *OF_SOLVER,
        EVENT_RESIDUAL,
    ]  # fmt: skip


def _way_back(unit: str, sides: str) -> list[Variable]:
    """What a bracket followed up and down again has besides."""
    back = f"{sides} there on the way down"
    end = "end of a range in which the way up and the way down differ"
    known = "width of the interval that it was bisected to; missing at the end of the bracket"
    return [
        classes("scan_class_back", back, "scan", of="attractor", role=Role.DETAIL),
        Variable("bistable_low", unit, f"lower {end}", "range", width="bistable_low_width"),
        Variable("bistable_low_width", unit, known, "range"),
        Variable("bistable_high", unit, f"upper {end}", "range", width="bistable_high_width"),
        Variable("bistable_high_width", unit, known, "range"),
    ]


# --- spectra --------------------------------------------------------------------------------------
KEPT_OF_STEADY_STATE = (ATTRACTOR, PERIOD, MULTIPLICITY, *OF_STEADY_STATE)
"""What a spectrum says of the steady state that it is of."""

_FREQUENCY = axis("frequency", "Hz", "middle of the bin", symbol="f")


def _spectrum(subject: Subject) -> list[Variable]:
    observed, unit = subject.observed
    pair = "of the linearised system at the first sliding equilibrium, a conjugate pair once"
    return [
        _FREQUENCY,
        ATTRACTOR,
        Variable(
            "amplitude",
            unit,
            f"amplitude of {observed}",
            "frequency",
            comment="peak of a sinusoid; root of the sum of squares over the bin, mean left out; "
            "lines of a period, or a Hann window where the motion is not periodic",
        ),
        Variable("mean", unit, f"mean of {observed}"),
        Variable("response_frequency", "Hz", "frequency of the largest amplitude"),
        Variable("variance_shown", "1", "share of the mean square that lies below f_max"),
        PERIOD,
        MULTIPLICITY,
        Variable("mode_frequency", "Hz", "frequency of the mode", "mode", comment=pair),
        Variable("mode_growth", "rad s-1", "growth rate of the mode", "mode", comment=pair),
        Variable("unstable_frequency", "Hz", "frequency of the growing mode", "mode", comment=pair),
        *OF_STEADY_STATE,
    ]


def _spectrogram(subject: Subject) -> list[Variable]:
    observed, unit = subject.observed
    comment = "peak of a sinusoid; root of the sum of squares over the bin, mean left out; Hann"
    amplitude = f"amplitude of {observed}"
    return [
        axis("time", "s", "middle of the window", symbol="t"),
        _FREQUENCY,
        Variable("spectrogram", unit, amplitude, "time frequency", comment=comment),
        Variable("mean", unit, f"mean of {observed} in the window", "time"),
        *OF_SOLVER,
        EVENT_RESIDUAL,
    ]


# --- cycles ---------------------------------------------------------------------------------------
def _cycle(subject: Subject) -> list[Variable]:
    observed, _ = subject.observed
    return [
        Variable("cycle_period", "s", "period of the cycle", symbol="T", headline=2),
        classes("stable", "whether the cycle is stable", headline=1),
        MULTIPLICITY,
        PERIOD_RATIO,
        Variable(
            "cycle_section",
            "1",
            f"point of the cycle at the section, where {observed} is least",
            "state",
            comment="each state in its own unit (state_units)",
            velocities=True,
        ),
        _section_value(subject),
        *MULTIPLIERS,
        *_extremes(subject.states, rms=False),
        trust("residual", "miss after a period, over the extent of the cycle"),
        count("n_events", "events per period", role=Role.WORK),
        *(_branch(subject) if subject.varied is not None else ()),
    ]


_OFF = "how far it may be off"
_CYCLES_AGAIN = (
    "what it was bisected to, and what cycles of ten times the error of integration move it by; "
    "missing where these do not show it"
)


def _branch(subject: Subject) -> list[Variable]:
    """The branch of a cycle along a parameter, and where it changes or ends."""
    varied, (observed, unit) = subject.settings["parameter"], subject.observed
    name, branch = varied.name, "branch"
    return [
        Variable("branch_value", varied.unit, f"{name} along the branch", ragged=branch),
        Variable("branch_period", "s", "period along the branch", ragged=branch),
        Variable("branch_min", unit, f"least {observed} of the cycle", ragged=branch),
        Variable("branch_max", unit, f"greatest {observed} of the cycle", ragged=branch),
        Variable(
            "branch_multiplier", "1", "modulus of the largest nontrivial multiplier", ragged=branch
        ),
        classes("branch_stable", "stability", of="stable", ragged=branch, role=Role.DETAIL),
        *_changes(varied),
        *_end("lowest", varied),
        *_end("highest", varied),
    ]


def _changes(varied: Varied) -> list[Variable]:
    """Where a branch changes or ends, in its order."""
    name, end = varied.name, "cycle_end"
    kinds = "fold, flip (a multiplier passes -1), torus (a pair passes 1 in modulus), branching (a "
    kinds += "multiplier passes 1), grazing (an event enters or leaves), contact lost, equilibrium "
    kinds += (
        "(the cycle shrinks to rest), bracket (its edge), budget (of points), mu_k above mu_s, "
    )
    kinds += "closed (round to its first cycle)"
    return [
        Variable(
            "cycle_end",
            varied.unit,
            f"{name} where the branch changes or ends",
            ragged=end,
            comment="in the order of the branch, within cycle_end_error",
        ),
        Variable(
            "cycle_end_width",
            varied.unit,
            "half the bracket that it was bisected to",
            ragged=end,
            comment="no bound of its error",
        ),
        Variable("cycle_end_error", varied.unit, _OFF, ragged=end, comment=_CYCLES_AGAIN),
        classes("cycle_end_kind", "what happens", of="cycle_end", ragged=end, comment=kinds),
        count("cycle_end_direction", f"1: {name} rising, -1: falling", ragged=end),
        classes(
            "cycle_end_goes_on", "whether the branch goes on", of="goes_on", ragged=end,
            role=Role.DETAIL,
        ),
    ]  # fmt: skip


def _end(side: str, varied: Varied) -> list[Variable]:
    """One end of the range of a parameter in which a branch lies."""
    name, unit = f"cycle_{side}", varied.unit
    return [
        Variable(
            name, unit, f"{side} {varied.name} of the branch", headline=int(side == "highest")
        ),
        Variable(f"{name}_width", unit, "half the bracket that it was bisected to"),
        Variable(f"{name}_error", unit, _OFF, comment=_CYCLES_AGAIN),
        classes(f"{name}_kind", "what is there", of="cycle_end"),
    ]


_BY_KIND: Mapping[str, Callable[[Subject], list[Variable]]] = {
    "history": _history,
    "equilibrium": _equilibrium,
    "eigenvalues": _eigenvalues,
    "critical": _critical,
    "response": _response,
    "spectrum": _spectrum,
    "boundary": _boundary,
    "cycle": _cycle,
    "plate": _plate,
    "spectrogram": _spectrogram,
}
