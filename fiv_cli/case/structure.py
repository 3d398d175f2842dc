"""The form of a case file: which tables and keys there are, and of what type.

Pydantic checks the form and yields the JSON schema; what the names and numbers *mean* is checked
against the model, law and analysis tables elsewhere in this package.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Annotated, Any, ClassVar, Literal, Self

from pydantic import (
    BaseModel,
    BeforeValidator,
    ConfigDict,
    Field,
    PlainValidator,
    StringConstraints,
    WithJsonSchema,
    model_validator,
)

from fiv_cli.case.grammar import (
    EXPECT_SCHEMA,
    HOLDS_SCHEMA,
    check_counted,
    check_holds,
    in_place_of_reduce,
    in_place_of_share,
    parse_expect,
)
from fiv_cli.notation.values import (
    INTERVAL_SCHEMA,
    QUANTITY_SCHEMA,
    WANTED_SCHEMA,
    check_interval,
    check_number,
    check_quantity,
    check_wanted,
    describe,
)

# The version of the case-file format that this program reads.
SCHEMA_VERSION = 1

_NUMBERS: list[dict[str, Any]] = [
    {"type": "number"},
    {"type": "array", "items": {"type": "number"}, "minItems": 1},
]
LEVELS_SCHEMA = {
    "anyOf": [
        *_NUMBERS,
        {
            "type": "object",
            "additionalProperties": {"anyOf": [*_NUMBERS, {"type": "string", "minLength": 1}]},
        },
    ]
}


LIMITS_SCHEMA = {
    "anyOf": [INTERVAL_SCHEMA, {"type": "object", "additionalProperties": INTERVAL_SCHEMA}]
}


SEVERAL_LAWS = (
    'several laws are an axis: write friction = ["coulomb", "stribeck"] under [grid]; '
    "parameters of one law stand under [friction.stribeck]"
)


def _check_law(value: object) -> object:
    if isinstance(value, list):
        raise ValueError(SEVERAL_LAWS)
    return value


def check_levels(value: object) -> list[float] | dict[str, list[float] | str]:
    """One number, or a list of numbers, as a list, or such a list for each variable of a table.

    There the name of an axis may stand in its place.

    Raises
    ------
    ValueError : anything else
    """
    if isinstance(value, dict):
        return {
            name: one if one and isinstance(one, str) else _check_numbers(one)
            for name, one in value.items()
        }
    return _check_numbers(value)


def _check_numbers(value: object) -> list[float]:
    if isinstance(value, list) and not value:
        raise ValueError("must be a number or a list of numbers, not an empty list")
    return [check_number(level) for level in (value if isinstance(value, list) else [value])]


def _check_version(value: object) -> int:
    if type(value) is not int or value != SCHEMA_VERSION:
        raise ValueError(f"must be {SCHEMA_VERSION}, not {describe(value)}")
    return value


SchemaVersion = Annotated[
    int, PlainValidator(_check_version), WithJsonSchema({"const": SCHEMA_VERSION})
]
Quantity = Annotated[Any, PlainValidator(check_quantity), WithJsonSchema(QUANTITY_SCHEMA)]
Wanted = Annotated[Any, PlainValidator(check_wanted), WithJsonSchema(WANTED_SCHEMA)]
Number = Annotated[float, BeforeValidator(check_number)]
Interval = Annotated[
    Any,
    PlainValidator(check_interval),
    WithJsonSchema(INTERVAL_SCHEMA),
]


def check_limits(value: object) -> tuple[Any, Any] | dict[str, tuple[Any, Any]]:
    """A range, or one for each variable of a table; ValueError for anything else."""
    if isinstance(value, dict):
        return {name: check_interval(one) for name, one in value.items()}
    return check_interval(value)


Limits = Annotated[Any, PlainValidator(check_limits), WithJsonSchema(LIMITS_SCHEMA)]
Levels = Annotated[Any, PlainValidator(check_levels), WithJsonSchema(LEVELS_SCHEMA)]


MOST_LINES = 8
"""Levels in one map whose lines can be told apart."""

MOST_LEVELS = 12
"""A lattice halved more often than this has more points than can be held."""


class Table(BaseModel):
    """A table of the case file: unknown keys are errors, and types are not converted."""

    model_config = ConfigDict(extra="forbid", strict=True, populate_by_name=False)

    # Key of 0.1.0 that is gone -> what to write now for the value it has.
    gone: ClassVar[Mapping[str, Callable[[Any], str]]] = {}
    # What another table calls it -> the key of this one.
    elsewhere: ClassVar[Mapping[str, str]] = {}
    example: ClassVar[str] = ""


class OpenTable(BaseModel):
    """A table whose further keys depend on a name in it and are checked against its table."""

    model_config = ConfigDict(extra="allow", strict=True)


class ModelTable(Table):
    """The mechanical model."""

    example: ClassVar[str] = "parameters = { m = 2.0 }, or on the command line model.parameters.m=2"

    name: str = Field(description="name of the model; `fiv models` lists them")
    parameters: dict[str, Quantity] = Field(
        default={},
        description="what differs from the default; the name of another, whose value it is then",
    )
    options: dict[str, Any] = Field(default={}, description="switches of the model")


class FrictionTable(OpenTable):
    """The friction law; its parameters stand directly in this table."""

    example: ClassVar[str] = f"one table [friction]; {SEVERAL_LAWS}"

    law: Annotated[str | None, BeforeValidator(_check_law)] = Field(
        default=None, description="name of the law; `fiv models --laws`"
    )
    of: str | None = Field(default=None, description='the law that law = "tanh" regularises')


class RangeTable(Table):
    """A regular axis; both ends are included."""

    example: ClassVar[str] = "{ start = 1, stop = 2, num = 5 }, or step = 0.25 in place of num"

    start: Quantity = Field(description="first value")
    stop: Quantity = Field(description="last value, included")
    step: Quantity | None = Field(
        default=None, description="between values, below 0 if they fall; must hit stop"
    )
    num: int | None = Field(default=None, description="number of values, instead of step")
    scale: Literal["linear", "log"] = Field(default="linear", description="spacing, with num")


class HarmonicTable(Table):
    """What A cos(omega t + phase) takes."""

    amplitude: Quantity | None = Field(default=None, description="amplitude, SI")
    omega: Quantity | None = Field(
        default=None,
        description="frequency in rad/s, or the name of a parameter; default: that of the first "
        "excitation, and of this the model's own, else 1",
    )
    phase: Quantity | None = Field(default=None, description="phase at t = 0, rad")


class ForceTable(HarmonicTable):
    """An external force on a coordinate, or the motion of the base."""

    example: ClassVar[str] = "{ amplitude = 1.0, omega = 0.8, phase = 0.0, constant = 0.5 }"

    constant: Quantity | None = Field(default=None, description="constant part of the force, SI")


class CurveTable(HarmonicTable):
    """How a parameter varies in time: a ramp, straight lines between points, or harmonically."""

    example: ClassVar[str] = (
        "{ start = 1, stop = 2, over = 10 }, { points = [[0, 1], [10, 2]] } or "
        "{ mean = 1, amplitude = 0.2, omega = 0.5 }"
    )

    start: Quantity | None = Field(default=None, description="value up to t = 0")
    stop: Quantity | None = Field(default=None, description="value from t = over on")
    over: Quantity | None = Field(default=None, description="how long the ramp takes, s")
    points: list[list[Quantity]] | None = Field(
        default=None, description="[time, value] with rising times; constant before and after"
    )
    mean: Quantity | None = Field(
        default=None, description="of a harmonic variation; default: the parameter's own value"
    )

    @property
    def is_harmonic(self) -> bool:
        """Whether only what a harmonic variation takes is given."""
        return bool(self.model_fields_set) and self.model_fields_set <= {
            "mean", *HarmonicTable.model_fields
        }  # fmt: skip


class RefineTable(Table):
    """How a grid is halved along the borders of a class."""

    levels: int = Field(
        ge=1, le=MOST_LEVELS, description="how often the spacing of the grid is halved"
    )
    of: str = Field(default="attractor", description="class whose borders are followed")
    along: list[str] | None = Field(
        default=None,
        description="axes that are halved (none that a start follows); default: numbers, no zips",
    )
    sample: int | None = Field(
        default=None,
        ge=0,
        description="filled points of each map that are run as well; default: a tenth, at most 100",
    )
    seed: int = Field(default=0, ge=0, description="seed of the sample")


class SweepTable(Table):
    """How axes combine, and which of their points are run."""

    zip: list[list[str]] = Field(
        default=[], description='groups of axes that advance together: [["a", "b"]]'
    )
    refine: RefineTable | None = Field(
        default=None, description="[grid] is coarse, and halved along the borders of a class only"
    )


class InitialTable(Table):
    """One start of the motion."""

    elsewhere: ClassVar[Mapping[str, str]] = {"axis": "along", "over": "along"}

    label: str | None = Field(
        default=None, description="unique name, also in figures; default: the kind"
    )
    kind: Literal["equilibrium", "state", "random", "table", "continue"] = Field(
        description="equilibrium + offset, a state, random states in a box, a table of states, or "
        "the neighbour's end"
    )
    offset: dict[str, Quantity] = Field(
        default={}, description="state -> what is added to the equilibrium's"
    )
    state: dict[str, Quantity] = Field(
        default={}, description="values of states; a string may name a parameter; the rest is 0"
    )
    count: int = Field(default=1, ge=1, description="number of random starts")
    seed: int = Field(default=0, ge=0, description="seed of random starts")
    box: dict[str, Interval] = Field(default={}, description="state -> [low, high]")
    states: list[dict[str, Quantity]] = Field(
        default=[], description="table: each start, its numbers in SI or with a unit; the rest is 0"
    )
    file: str | None = Field(
        default=None,
        description="table: a CSV file beside the case: a header of states such as x, x_dot [mm/s] "
        "and a start in each row, LABEL-000, LABEL-001, ...",
    )
    along: str | None = Field(default=None, description="axis along which a start is continued")
    direction: Literal["up", "down"] = Field(default="up", description="sense along the axis")
    from_label: str | None = Field(
        default=None,
        alias="from",
        description="needed: label of the start of the first point; of a chain the other way "
        "along: this one begins where that one ended, or lost its class (a hysteresis loop; "
        "mostly with on_loss go-on)",
    )
    on_loss: Literal["stop", "restart", "go-on"] = Field(
        default="stop",
        description="what follows where the class of motion is lost: nothing, the start anew, or "
        "the motion as it then is, of whatever class",
    )
    steps: Literal["shorter", "grid"] = Field(
        default="shorter",
        description="shorter: what sticks goes along with its partner, and where a step of the "
        "grid loses the class, shorter ones tell whether it is there still; grid: an ordinary "
        "sweep, each point begins in just the state in which the one before ended",
    )


class AnalysisTable(OpenTable):
    """One analysis; its settings stand directly in this table."""

    kind: str = Field(description="kind of analysis")
    name: str | None = Field(default=None, description="unique name; default: the kind")


Names = Annotated[
    list[str],
    BeforeValidator(lambda value: [value] if isinstance(value, str) else value),
    WithJsonSchema({"anyOf": [{"type": "string"}, {"type": "array", "items": {"type": "string"}}]}),
]
Contacts = Annotated[
    list[int],
    BeforeValidator(lambda value: value if isinstance(value, list) else [value]),
    WithJsonSchema(
        {"anyOf": [{"type": "integer"}, {"type": "array", "items": {"type": "integer"}}]}
    ),
]
What = Literal[
    "share",
    "entries",
    "first",
    "last",
    "classes",
    "least",
    "greatest",
    "mean",
    "spread",
    "difference",
    "peak",
]
# What is counted needs `of`; what is found in one place needs one axis.
COUNTED = ("share", "entries", "first", "last")
ALONG_ONE = ("entries", "first", "last", "difference", "peak")


Of = Annotated[
    Any,
    WithJsonSchema({"anyOf": [{"type": "string"}, {"type": "array", "items": {"type": "string"}}]}),
]


EACH = "each"
"""In a figure the share of each class that occurs."""


class TakeTable(Table):
    """One number in place of all that a variable holds along some axes."""

    what: What = Field(
        description="least, greatest, mean; spread: greatest less least; peak: where on the axis "
        "the greatest lies; share: of the points at which `of` holds; entries: how often `of` "
        "comes to hold; first, last: where on the axis `of` holds; classes: how many there are"
    )
    over: Names = Field(description="axis, or axes, along which it is taken")
    of: Of | None = Field(
        default=None,
        description='share, entries, first, last: condition (". > 0"), a class, or "not CLASS"; '
        "a list of classes: any of them; share in a figure: each, of every class that occurs",
    )
    relative_to: dict[str, Quantity] = Field(
        default={}, description="axis -> value: the shares are over that at this point"
    )

    @model_validator(mode="after")
    def _agrees(self) -> Self:
        if self.what in COUNTED and self.of is None:
            raise ValueError(
                f'{self.what} needs of: a class, "not CLASS", or a condition (". > 0")'
                + ', or "each" in a figure' * (self.what == "share")
            )
        if self.what in COUNTED:
            check_counted(self.of)
        elif self.of is not None:
            raise ValueError(f"of is for {', '.join(COUNTED)}; {self.what} is taken of all values")
        if not self.over or (self.what in ALONG_ONE and len(self.over) > 1):
            raise ValueError(f"{self.what} is taken along one axis, not {len(self.over)}")
        if self.what != "share" and self.relative_to:
            raise ValueError(f"relative_to is for share, not {self.what}")
        return self


FigureKind = Literal[
    "curve",
    "bifurcation",
    "map",
    "basin",
    "history",
    "phase",
    "spectrum",
    "spectrogram",
    "eigenvalues",
    "branch",
    "mode-shape",
]


class FigureTable(Table):
    """One figure that `fiv plot` draws."""

    gone: ClassVar[Mapping[str, Callable[[Any], str]]] = {"share": in_place_of_share}
    elsewhere: ClassVar[Mapping[str, str]] = {"of": "variable", "at": "select"}

    kind: FigureKind = Field(description="kind of figure")
    name: str | None = Field(default=None, description="unique name; default: the kind")
    title: str | None = Field(default=None, description="title; default: the case's")
    analysis: str | None = Field(default=None, description="name of the analysis to draw")
    x: str | None = Field(
        default=None, description="horizontal: an axis, or a state (phase, basin)"
    )
    y: str | None = Field(
        default=None,
        description="vertical: an axis (map), a state (phase, basin), or the variable of a curve",
    )
    variable: str | list[str] | None = Field(
        default=None,
        description="variable(s) to draw; curves of several units have a panel each, and ylabel "
        "means the first; a bifurcation shows section_value alone",
    )
    select: dict[str, Wanted] = Field(
        default={},
        description=(
            "axis, initial, or what the variable has besides (state, mode, contact, crossing) -> "
            "value, list of values or condition to draw"
        ),
    )
    take: TakeTable | None = Field(
        default=None, description="draw one number for all that the variable holds along axes"
    )
    level: Levels | None = Field(
        default=None,
        description="map: a line where its numbers have this value, or each of these; of any "
        'variables over its axes { growth_rate = 0, L_s = [1e-4, 1e-3], "CASE:growth_rate" = 0 }; '
        'where an axis has the value found over the other { "CASE:critical_value" = "mu_k" }',
    )
    contact: Contacts | None = Field(
        default=None,
        description="contact to draw, from 1, or of a history several, [1, 2]; default: all that "
        "have a value; phase, and a history's panels of states: the (first) contact that colours "
        "are about (sticks of others are bands)",
    )
    window: Interval | None = Field(default=None, description="stretch of time to draw, s")
    overlay: bool = Field(
        default=False,
        description="phase: all motions in one panel; map: the lines at `level` alone, all in one",
    )
    border: bool = Field(
        default=True,
        description="map: whether the line of the level next to rest leads on along a jump to rest",
    )
    log: bool | Literal["x", "y", "xy", "z", "xz", "yz", "xyz"] = Field(
        default=False,
        description='logarithmic axes: true, "x", "y" or "xy"; "z": the shades of a map',
    )
    xlim: Interval | None = Field(default=None, description="range of x")
    ylim: Limits | None = Field(
        default=None,
        description="range of y, of several panels that of the first; of a curve, eigenvalues or "
        "a history, for the panels of these variables, { period = [0, 0.1], L_s = [0, 1e-3] }",
    )
    zlim: Interval | None = Field(default=None, description="map: range of its shades")
    xlabel: str | None = Field(default=None, description="label of x, in place of its own")
    zlabel: str | None = Field(
        default=None, description="map: label of its colour bar, in place of its own"
    )
    ylabel: str | None = Field(default=None, description="label of y, in place of its own")
    words: dict[Annotated[str, StringConstraints(min_length=1)], str] = Field(
        default={},
        description="what stands in the legend and at axes, or the variable that does -> what to "
        'write in its place: { "contact 1" = "lower belt", "equilibrium" = "steady sliding", '
        '"L_s = 0.001 m^2" = "border" }, this a whole entry, as tables spell it',
    )
    unit: Literal["Hz", "rad/s"] | None = Field(default=None, description="unit: Hz or rad/s")
    resolution: Quantity | None = Field(
        default=None, description="spectrogram of a history: what it tells apart, Hz"
    )


class ClaimTable(Table):
    """What the publication says, as a check."""

    elsewhere: ClassVar[Mapping[str, str]] = {"select": "at", "where": "at"}
    gone: ClassVar[Mapping[str, Callable[[Any], str]]] = {
        "share": in_place_of_share,
        "reduce": in_place_of_reduce,
    }

    source: str = Field(description="where it says so")
    text: str = Field(description="what it says")
    variable: str = Field(description="variable of the dataset that decides")
    expect: Annotated[Any, PlainValidator(parse_expect), WithJsonSchema(EXPECT_SCHEMA)] = Field(
        description='a class, "not CLASS", "increasing", "decreasing", { value, tolerance }, '
        "{ less_than }, { greater_than } or { between }"
    )
    take: TakeTable | None = Field(
        default=None, description="the claim is about one number for all along axes"
    )
    at: dict[str, Wanted] = Field(
        default={},
        description='axis -> value, list of values or condition ("0.9 <= . < 1.8"); '
        "result -> class, or classes, that it must have",
    )
    holds: Annotated[Any, PlainValidator(check_holds), WithJsonSchema(HOLDS_SCHEMA)] = Field(
        default="all", description="all, any, or the share of points that must agree"
    )
    undecided: Literal["open", "counts"] = Field(
        default="open",
        description="a point of undecided class: open, it has no answer; counts, what was measured "
        "of it until t_max is one",
    )
    note: str = Field(default="", description="what is known about a difference")
    analysis: str | None = Field(default=None, description="name of the analysis that decides")


class SolverTable(Table):
    """How motions are integrated."""

    method: Literal["taylor", "rk4"] = Field(default="taylor", description="integrator")
    rtol: Number = Field(
        default=1e-9, ge=1e-15, le=1e-3, description="relative tolerance of a Taylor step"
    )
    step: Quantity = Field(default=1e-3, description="step of rk4, s")
    max_events: int = Field(default=1_000_000, ge=1, description="events after which a run ends")
    max_steps: int = Field(default=50_000_000, ge=1, description="steps after which a run ends")


class HeaderTable(Table):
    """The keys above the first table."""

    schema_version: SchemaVersion = Field(alias="schema", description="version of this format")
    title: str = Field(default="", description="one line")
    reference: str = Field(default="", description="figure or section of the publication")
    assumed: list[str] = Field(
        default=[], description="what the publication leaves open and this case chose"
    )


class CaseTable(HeaderTable):
    """A case of fiv, a batch tool for friction-induced vibration."""

    model: ModelTable = Field(description="the mechanical model")
    friction: FrictionTable = Field(default=FrictionTable(), description="the friction law")
    grid: dict[str, list[Quantity] | RangeTable] = Field(
        default={}, description="ordered axes: parameters, options, friction, initial.STATE"
    )
    schedule: dict[str, CurveTable] = Field(default={}, description="parameters that vary in time")
    forcing: dict[str, ForceTable] = Field(
        default={}, description="external forces on coordinates, and motion of the base"
    )
    sweep: SweepTable = Field(default=SweepTable(), description="how axes combine")
    initial: list[InitialTable] = Field(default=[], description="starts of the motion")
    analysis: list[AnalysisTable] = Field(description="what is computed")
    figure: list[FigureTable] = Field(default=[], description="what `fiv plot` draws")
    claim: list[ClaimTable] = Field(default=[], description="what the publication says")
    solver: SolverTable = Field(default=SolverTable(), description="how motions are integrated")
