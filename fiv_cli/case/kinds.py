"""Every kind of thing that a case may hold: analyses, starts, figures, and what claims say.

What each is and which keys it has, for people (``fiv kinds``) and for what reads the tables.
"""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Literal, get_args, get_origin

from pydantic import BaseModel
from pydantic.fields import FieldInfo

from fiv_cli.analyses import all_analyses
from fiv_cli.analyses.settings import Setting, TableSetting
from fiv_cli.case.report import Path, Report
from fiv_cli.case.structure import (
    AnalysisTable,
    ClaimTable,
    CurveTable,
    FigureTable,
    ForceTable,
    FrictionTable,
    InitialTable,
    ModelTable,
    RangeTable,
    RefineTable,
    SolverTable,
    SweepTable,
    TakeTable,
)
from fiv_cli.notation.names import listed

STARTS = {
    "equilibrium": ("a sliding equilibrium of the unexcited system, moved", ("offset",)),
    "state": ("a state; what is not given is 0", ("state",)),
    "random": (
        "random states in a box, labelled LABEL-000, LABEL-001, ...; others at other parameters",
        ("count", "seed", "box"),
    ),
    "table": ("states from a list, or from a CSV file", ("states", "file")),
    "continue": (
        "where the motion of the neighbour along an axis ended",
        ("along", "direction", "from", "on_loss", "steps", "offset"),
    ),
}
"""Kind of start -> what it is, and its keys besides those of every start."""

OF_EVERY_START = ("label",)

INSTEAD = {"contact": "select = { contact = NUMBER }"}
"""Key of some kinds -> what to write in the others."""

FIGURES = {
    "map": (
        'a variable over two axes, or one and the starts (y = "initial"): classes in colours, '
        "numbers in shades or as lines",
        ("x", "y", "variable", "take", "level", "overlay", "border", "zlim", "zlabel"),
    ),
    "basin": (
        "starts over two of their states, coloured by what they reach, and where they rest; over "
        "them motions, such as the unstable cycle that is their border: fiv plot BASINS.nc "
        "HISTORY.nc --figure basin",
        ("x", "y"),
    ),
    "bifurcation": (
        "what motions pass at the section and where they rest, along an axis, of a `response` or a "
        "`cycle`; with the equilibria, stable or not, where the case has `eigenvalues`, too (and, "
        "without a `response`, `equilibrium`; where these turn is read between the points unless "
        "the file of a `critical` is drawn with it), and the cycles of a `cycle` on the same "
        "section (of unstable ones on another their extremes)",
        ("x", "variable"),
    ),
    "curve": (
        "variables along an axis, of all analyses of the case that have it, a line for each start "
        "(of up to six of a table; more look alike); of a dataset without the axis, across; on "
        "amplitudes the values of the file of a `critical`",
        ("x", "y", "variable", "take"),
    ),
    "branch": ("branches of cycles and their ends, along their parameter", ()),
    "eigenvalues": (
        "growth rates and frequencies of modes, along an axis; with critical values of another "
        "case where growth is zero: fiv plot MODES.nc CRITICAL.nc --figure eigenvalues",
        ("x", "unit"),
    ),
    "history": (
        "displacements in time, or the states, forces and others that variable names",
        ("variable", "contact", "window"),
    ),
    "phase": (
        "one state, or force, against another",
        ("x", "y", "variable", "contact", "window", "overlay"),
    ),
    "spectrum": (
        "amplitudes over frequency, of each unit a panel, upright lines of several side by side, a "
        "line's width apart; along an axis of more than three numbers, or x, shades, frequency "
        "upright",
        ("x", "variable", "window", "unit"),
    ),
    "spectrogram": ("amplitudes over time and frequency", ("variable", "unit", "resolution")),
    "mode-shape": ("shapes of the modes of a disc", ("unit",)),
}
"""Kind of figure -> what it shows, and its keys besides those of every figure."""

OF_EVERY_FIGURE = (
    *("name", "title", "analysis", "select", "log", "xlim", "ylim", "xlabel", "ylabel", "words"),
)

TAKES = {
    "share": (
        'at how many points `of` holds, of 1 (in a figure of = "each": that of each class, a line '
        "or panel for each); over random starts alone, p of n, claims tell its standard error "
        "sqrt(p (1 - p) / n)",
        ("of", "over", "relative_to"),
    ),
    "entries": ("how often `of` comes to hold along an axis", ("of", "over")),
    "first": (
        "where along an axis `of` holds first: from there back to the value before",
        ("of", "over"),
    ),
    "last": (
        "where along an axis `of` holds last: from there on to the next value",
        ("of", "over"),
    ),
    "classes": (
        "how many classes there are; over the starts: where there are 2, what is reached depends "
        "on the start",
        ("over",),
    ),
    "least": ("the least of the numbers", ("over",)),
    "greatest": ("the greatest of the numbers", ("over",)),
    "mean": ("their mean", ("over",)),
    "spread": ("the greatest less the least", ("over",)),
    "difference": (
        "what the last along an axis, or of a list that chooses there, has more than the first",
        ("over",),
    ),
    "peak": ("at which point of an axis the greatest is", ("over",)),
}
"""`what` is taken of many values -> what it is, and the other keys of ``take``."""

SCHEDULES = {
    "ramp": ("from one value to another, straight", ("start", "stop", "over")),
    "points": ("straight lines between points", ("points",)),
    "harmonic": (
        "mean + amplitude cos(omega t + phase), an excitation like a force; of a parameter v its "
        "mean v, A_v, omega_v and phase_v may be axes",
        ("mean", "amplitude", "omega", "phase"),
    ),
}
"""How a parameter varies in time -> what it is, and its keys."""

_BY_KIND = {
    InitialTable: ("kind", STARTS, OF_EVERY_START),
    FigureTable: ("kind", FIGURES, OF_EVERY_FIGURE),
    CurveTable: ("", SCHEDULES, ()),
    TakeTable: ("what", TAKES, ()),
}
"""Table -> the key that says its kind, its kinds, the keys of all."""

EXPECTS = {
    '"CLASS"': 'the class is this; "not CLASS": another',
    "{ value = V, tolerance = T }": 'it differs from V by no more than T, or than "5 %" of V',
    "{ less_than = V }": 'it is below V: a number, "VARIABLE", "CASE:VARIABLE" or a table',
    "{ greater_than = V }": "it is above V, likewise",
    "{ between = [LOW, HIGH] }": "it lies there; the ends count",
    '"increasing"': 'each step along the one axis that is left goes up; "decreasing": down',
}
"""Forms of ``expect`` -> when they hold."""


CLAIMS = """\
A [[figure]] draws and a [[claim]] checks one variable of a dataset. Its points are selected (`at`;
a figure says `select`), one number may be taken of many (`take`), and `expect` says what must hold.

    [[claim]]
    source = "Figure 7.13"                       # where it is said
    text = "a sector of 15 degrees leaves less than 0.6 of the speeds and phases with stick-slip"
    variable = "stick_fraction"                  # `analysis = NAME` where several hold it
    at = { beta = "15 deg", Omega = ". <= 6" }
    take = { what = "share", of = ". > 0", over = ["Omega", "psi_a"], relative_to = { beta = 0 } }
    expect = { less_than = 0.6 }
    holds = "all"                                # of the points: all, any, or a share such as 0.9
    note = "what is known about a difference"

Which points: axis -> a number in SI, a quantity ("15 deg"), a label (initial = "far" stands for
far-000, far-001, ... too), a list of these, or a condition on the value, which is called `.`:
"0.9 <= . < 1.8", ". > 5", ". == 0.3", ". != 0". An axis is one of the grid, `initial`, or one that
the variable has of its own (time, frequency, mode, crossing, ...). What `at` says of an axis of
`over` says what is taken; the rest says of which results the claim speaks. Section points have no
axis: a claim on section_value speaks of each of them. A result narrows a claim to the values beside
which it is of a class: at = { attractor = "periodic" }, or ["periodic", "quasiperiodic"].

What is taken of them, along one axis or several (`over`), grid or own: `fiv kinds take` lists it.
`of` is a condition on a number (". > 0"), and "CLASS", "not CLASS" or a list of classes of a class;
`relative_to` gives a share over that at another point, a ratio of areas. A point that is decided
and has no number (L_s where contact is lost) is none at which a condition holds; it is told.

A border that was found is the last place of a class along an axis, or the first: it lies between
that and the value beside it (at an end of the axis there is none; a `boundary` analysis bisects
it). Here stick-slip ends by 7 rad/s:

    variable = "attractor"
    at = { initial = "up" }                      # one of several starts
    take = { what = "last", of = "periodic", over = "Omega" }
    expect = { between = [6.5, 7.0] }

What is reached depends on the start where there are two classes over the starts: `fiv show` says
where that is, and a map of it with level = 1.5 draws its border.

    variable = "attractor"
    at = { Omega = "5.25 <= . <= 6.75" }         # bistable
    take = { what = "classes", over = "initial" }
    expect = { greater_than = 1 }

In place of a number may stand what another variable is at the same points, "VARIABLE", what another
case beside this one holds there, "CASE:VARIABLE", or a table { variable, analysis, case, at, take,
times }. What that leaves out is as in the claim: here a sector halves the share of starts.

    variable = "attractor"
    at = { beta = "15 deg" }
    take = { what = "share", of = "periodic", over = "initial" }
    expect = { less_than = { at = { beta = 0 }, times = 0.5 } }

To 5 % the frequency is that of the mode that grows, of `eigenvalues` in the same case:

    variable = "response_frequency"
    expect = { value = "growth_frequency", tolerance = "5 %" }

A number that may be off, as that of a `boundary`, is held against what is expected with all of its
error. A point that was not computed, or whose class is undecided, may hold anything: what is taken
over such points is an interval (share_low, share_high), and a claim about it is decided where both
ends say the same: one about a border is not while undecided points lie beside it. Otherwise such
points leave a claim undetermined where they could turn it, unless they are no more than 0.5 % of
those it is tried on: then the rest decides, whatever they might hold. A share over random starts is
held as it was found: its standard error is told, and not allowed for (add two or three of them to a
tolerance). One over a lattice of starts (axes initial.x) counts its points, each alike: lay them in
the middles of cells, not on the edges of the range. `refine` halves the steps between the outermost
points: the window is theirs and half a finest step beyond, so lay these that much inside its edges.

A map draws the line at which its numbers have a `level`: the border of a region, also in a jump, to
rest half-way between the points. Of several levels only that next to rest lies in such a jump, and
none with border = false; of an interval each end has its line. With overlay = true there are the
lines alone, all in one panel, and those that a `boundary` or `critical` found.
Over a map of anything, of classes too, lie lines of other variables of the case, as
level = { growth_rate = 0.0 }, or of what another has found, "CASE:growth_rate": read between the
points, so up to half a step off where a number jumps to rest, and a step at another jump. Exact are
the ends that a `boundary` bisects along an axis, level = { "CASE:boundary" = "c" }, and, where an
equilibrium loses stability, a `critical`, level = { "CASE:critical_value" = "mu_k" }: the axis that
has the value. A .csv of the figure has them all.

Examples: configs/ch7/fig_7_13.toml, fig_7_06_exists.toml (borders), fig_7_15.toml (overlaid lines),
configs/ch4/fig_4_15.toml (claims about motions and spectra).
"""

GRID = """\
Every combination of the values of all axes is a point. An axis is a parameter of the model or the
law, an option of the model, the law itself (`fiv kinds friction`), or a state of the starts.

    [grid]
    Omega = { start = "10 rpm", stop = "80 rpm", num = 8 }       # both ends included
    mu_k = [0.2, 0.23]
    "initial.phi_dot" = { start = 0.0, stop = 9.0, step = 0.5 }  # of starts; off a rest, from it

Axes that advance together, as one: [sweep] zip = [["Omega", "N0"]]; a parameter that always has
the value of another, for `critical` and `boundary` too: c2 = "c1" under [model.parameters],
mu_s = "mu_k" under [friction]. Points along the borders of classes only: `fiv kinds refine`.
"""

FRICTION = """\
One law, or several as an axis of the grid; `fiv show` then says how far each answer depends on the
law. `fiv models --laws` lists laws, `fiv models NAME` the parameters of one.

    [friction]
    mu_s = 0.4                            # of every law that has it; "mu_k": follows that
    stribeck = { v_s = 0.05 }             # of this one
    [grid]
    friction = ["coulomb", "stribeck"]    # a single one: law = "stribeck" under [friction]

Measured friction is law = "FILE.csv", a table of slip velocity and coefficient, named from the
folder of the case. Any law that sticks is smoothed by law = "tanh", of = "stribeck". Example:
configs/ch7/pin_laws.toml.
"""

SWEEP = """\
How the points of [grid] are taken: axes that advance together, or finer along borders only (`fiv
kinds refine`). What varies stands under [grid] (`fiv kinds grid`); up and down an axis, each motion
from the end of its neighbour's, is a start (`fiv kinds continue`).

    [sweep]
    zip = [["Omega", "N0"]]
"""

REFINE = """\
A map that is run along the borders of its classes only: [grid] is coarse, and its spacing is halved
`levels` times where neighbours differ. 9 x 9 points grow to the picture of 257 x 257 for 3 to 13 %
of the runs along one closed border; more along many, or where chaos mixes classes, and where levels
are few or the coarse grid fine (25 points a side, halved once: 69 %). Of the time it saves less:
motions along a border, and chaotic ones, are those that take long. Where the coarse grid was run
already, the same -o uses its points. A seeded sample of the points that are filled in is run as
well, to say how many are wrong; an island between the points of the coarse grid is not seen.

    [sweep]
    refine = { levels = 5, of = "attractor" }

Where starts follow an axis, `along` names the other axes: along the one all points are run.
"""


SCHEDULE = """\
A parameter that varies in time: a ramp, straight lines between points, or harmonically, each with
its keys below and in `fiv kinds ramp`, `fiv kinds points`, `fiv kinds harmonic`.

    [schedule]
    Omega = { start = 6.0, stop = 0.5, over = 35.0 }    # rad/s, s
    N0 = { mean = 30.0, amplitude = 2.0, omega = 5.0 }
"""

FORCING = """\
Forces on coordinates of the model, or the motion of its base; `fiv models NAME` lists them.

    [forcing]
    phi = { amplitude = 0.1, omega = 5.0 }
"""

INITIAL = """\
Where motions start, each table a start; `initial` is an axis of the dataset, with their labels.

    [[initial]]
    label = "disc-speed"
    kind = "state"
    state = { phi_dot = "Omega" }                # a number in SI, or a parameter: "Omega", "-Omega"
    [[initial]]
    label = "anywhere"
    kind = "random"
    count = 100
    box = { phi = [-0.1, 0.1], phi_dot = [0.0, 5.0] }
    [[initial]]
    label = "up"
    kind = "continue"                            # each begins where the one before it ended
    along = "Omega"
    from = "disc-speed"                          # the first
    on_loss = "go-on"                            # whatever becomes of the motion
    steps = "shorter"                            # or grid: a step of the grid may lose it early
"""

FIGURE = """\
What `fiv plot` draws. Points are selected, and numbers taken, as by claims: `fiv kinds claim`.

    [[figure]]
    kind = "curve"
    x = "Omega"
    variable = "period"
    select = { initial = "far" }

Examples: configs/ch7/basin_shares.toml (basins), fig_7_15.toml (lines at a level of a map).
"""

TABLES: dict[str, tuple[str, type[BaseModel]]] = {
    "model": ("", ModelTable),
    "grid": (GRID, RangeTable),
    "sweep": (SWEEP, SweepTable),
    "refine": (REFINE, RefineTable),
    "friction": (FRICTION, FrictionTable),
    "schedule": (SCHEDULE, CurveTable),
    "forcing": (FORCING, ForceTable),
    "initial": (INITIAL, InitialTable),
    "analysis": ("", AnalysisTable),
    "solver": ("", SolverTable),
    "figure": (FIGURE, FigureTable),
    "claim": (CLAIMS, ClaimTable),
    "take": ("", TakeTable),
}
"""Table of a case -> what it is for, with an example, and its form."""


@dataclass(frozen=True)
class Key:
    """A key of a table: its name, its default as TOML ("" where there is none), its meaning."""

    name: str
    default: str
    meaning: str


@dataclass(frozen=True)
class Kind:
    """One kind: its table, how it is written there, what it is, its keys, and what it gives."""

    table: str
    name: str
    meaning: str
    keys: tuple[Key, ...] = ()
    answer: str = ""


def all_kinds() -> list[Kind]:
    """Everything that analyses, starts, schedules, forces, figures and claims know."""
    analyses = all_analyses().values()
    return [
        *(Kind("analysis", a.kind, a.title, _of_settings(a.settings), a.answer) for a in analyses),
        *(
            Kind("initial", name, meaning, keys_in(InitialTable, [*own, *OF_EVERY_START]))
            for name, (meaning, own) in STARTS.items()
        ),
        *(
            Kind("figure", name, meaning, keys_in(FigureTable, [*own, *OF_EVERY_FIGURE]))
            for name, (meaning, own) in FIGURES.items()
        ),
        *(
            Kind("schedule", name, meaning, keys_in(CurveTable, own))
            for name, (meaning, own) in SCHEDULES.items()
        ),
        Kind(
            "forcing",
            "force",
            "constant + amplitude cos(omega t + phase) on a coordinate x, or the base: fiv models "
            "NAME lists them; F_x, A_x, omega_x and phase_x may be axes",
            keys_in(ForceTable),
        ),
        *(
            Kind("claim.take", name, meaning, keys_in(TakeTable, own))
            for name, (meaning, own) in TAKES.items()
        ),
        *(Kind("claim.expect", form, meaning) for form, meaning in EXPECTS.items()),
    ]


def _of_settings(settings: Iterable[Setting], place: str = "") -> tuple[Key, ...]:
    """The settings of an analysis; those of one that is a table itself stand below it."""
    found: list[Key] = []
    for one in settings:
        plain = isinstance(one.default, str | int | float)
        default = "required" if one.required else json.dumps(one.default) if plain else ""
        found.append(Key(place + one.name, default, one.description))
        if isinstance(one, TableSetting):
            found += _of_settings(one.keys, f"{place}{one.name}.")
    return tuple(found)


def keys_in(form: type[BaseModel], names: Sequence[str] = ()) -> tuple[Key, ...]:
    """The keys of a table of a case, those called `names` or all."""
    fields = {field.alias or name: field for name, field in form.model_fields.items()}
    return tuple(
        Key(name, _default(fields[name]), _meaning(fields[name])) for name in names or list(fields)
    )


def keys_for(form: type[BaseModel], table: Mapping[str, Any]) -> dict[str, str]:
    """Key -> its meaning, of those that this `table` may have: by its kind, if it tells that.

    Otherwise those of all kinds that have the keys it has.
    """
    keys = {key.name: key.meaning for key in keys_in(form)}
    told_by, kinds, of_every = _BY_KIND.get(form, ("", {}, ()))
    given, told = keys.keys() & table.keys() - {told_by, *of_every}, table.get(told_by)
    fitting = [own for _, own in kinds.values() if given <= {*own}]
    if isinstance(told, str) and told in kinds:
        fitting = [kinds[told][1]]
    own = {told_by, *of_every, *(key for one in fitting for key in one)}
    return {key: meaning for key, meaning in keys.items() if not fitting or key in own}


def refuse_foreign_keys(table: BaseModel, what: str, place: Path, report: Report) -> None:
    """Note the keys of other kinds that a table has, which would do nothing."""
    given = table.model_dump(exclude_unset=True, by_alias=True)
    keys = keys_for(type(table), given)
    for key in sorted(given.keys() - keys.keys()):
        report.add((*place, key), f"{what} has no {key}", INSTEAD.get(key) or listed(keys))


def _meaning(field: FieldInfo) -> str:
    """What a key means, and the words that it takes, if it is one of some."""
    words = get_args(field.annotation) if get_origin(field.annotation) is Literal else ()
    return ": ".join([field.description or "", *([" | ".join(words)] if words else [])])


def _default(field: FieldInfo) -> str:
    if field.is_required():
        return "required"
    return "" if field.default in (None, {}, [], "") else json.dumps(field.default)
