"""What a mechanical model is: tables that people read, and equations that are written once.

To add a model:

1. write ``fiv_cli/models/my_model.py``: docstring with the equations and their source, the
   tables below, a function ``equations(symbols, options) -> Equations`` and
   ``MODEL = Model(...)``;
2. add it to the list in ``fiv_cli/models/__init__.py``;
3. add a row to ``tests/test_models.py`` and a case in ``configs/``.

Accelerations are written under *given* contact forces (`Symbols.tangential_force`,
`Symbols.normal_force`); code generation works out what those forces are in slip, in stick and
in separation, the switching functions, the Jacobian, the Taylor recurrences and the energy
balance. Nothing here imports SymPy: a model does that inside ``equations``.
"""

from __future__ import annotations

from collections.abc import Callable, Container, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from fractions import Fraction
from math import inf, lcm, pi, radians
from typing import TYPE_CHECKING, Protocol

from fiv_cli.errors import UsageError
from fiv_cli.models.origin import Origin
from fiv_cli.notation.units import convert
from fiv_cli.notation.values import check_quantity

if TYPE_CHECKING:
    from sympy import Expr

    from fiv_cli.models.symbols import Symbols

Options = Mapping[str, str]

MOST_RATIO = 50  # of whole numbers that frequencies of excitations are to one another
SAME_RATIO = 1e-12

ROLES_OF_UNITS = (
    dict.fromkeys(("N m-1", "N m", "N m-3"), "stiffness")
    | dict.fromkeys(("N s m-1", "N m s"), "damping")
    | {"kg": "mass", "kg m2": "inertia", "m": "length", "rad": "angle"}
)
"""What a parameter in this unit is, unless it says otherwise."""


@dataclass(frozen=True)
class Parameter:
    """A parameter of a model or of a friction law.

    Attributes
    ----------
    name : contract name, the thesis' symbol in ASCII (``mu_k``, ``N0``)
    symbol : LaTeX
    unit : UDUNITS string in SI, ``"1"`` when dimensionless
    default : SI value; None when it follows from another parameter (see `default_from`)
    minimum, maximum : closed range of allowed values
    meaning : one line
    equation : where the source introduces it
    default_from : name of the parameter whose value is the default
    integer : only whole numbers are allowed
    exclusive : the range is open at `minimum`
    role : what it is in any model (``"preload"``), so that another model's name for it leads to
        this one; what its unit says when left out
    law : in a case: the law whose it is, or whose range is the narrowest
    """

    name: str
    symbol: str
    unit: str
    default: float | None
    meaning: str
    equation: str = ""
    minimum: float = float("-inf")
    maximum: float = float("inf")
    exclusive: bool = False
    integer: bool = False
    default_from: str | None = None
    role: str = ""
    law: str = ""

    def __post_init__(self) -> None:
        if not self.role:
            object.__setattr__(self, "role", ROLES_OF_UNITS.get(self.unit, ""))

    @property
    def allowed(self) -> str:
        """What it may be, in one line."""
        kind = "a whole number" if self.integer else "a number"
        unit = "" if self.unit == "1" else f" in {self.unit}"
        bounds = []
        if self.minimum != float("-inf"):
            bounds.append(f"{'>' if self.exclusive else '>='} {self.minimum:g}")
        if self.maximum != float("inf"):
            bounds.append(f"<= {self.maximum:g}")
        range_ = f", {' and '.join(bounds)}" if bounds else ""
        whose = f" of {self.law}" if self.law else ""
        return f"{kind}{unit}{range_} ({self.meaning}{whose})"

    def within(self, other: Parameter) -> Parameter:
        """What both may be, where they are one quantity: that of two laws."""
        low, lower = (self.minimum, self.exclusive), (other.minimum, other.exclusive)
        if self.unit != other.unit or (low >= lower and self.maximum <= other.maximum):
            return self
        (least, exclusive), most = max(low, lower), min(self.maximum, other.maximum)
        return replace(self, minimum=least, exclusive=exclusive, maximum=most, law=other.law)

    def read(self, value: object) -> float:
        """`value` of a case file in SI; ValueError when it is not allowed."""
        number = convert(check_quantity(value), self.unit)
        is_told = isinstance(value, str) and self.unit != "1"
        said = f"{value!r} ({number:.6g} {self.unit})" if is_told else ""
        return self.checked(number, said)

    def checked(self, number: float, said: str = "") -> float:
        """`number` (SI), `said` in other words; ValueError when it is not allowed."""
        low = number > self.minimum if self.exclusive else number >= self.minimum
        if not (low and number <= self.maximum):
            degrees = "" if said else self._in_degrees(number)
            raise ValueError(f"{said or repr(number)} is out of range{degrees}")
        if self.integer and number != int(number):
            raise ValueError(f"{said or repr(number)} is not a whole number")
        return number

    def _in_degrees(self, number: float) -> str:
        """What to write where an angle out of range is in degrees, most likely."""
        meant = self.unit == "rad" and self.minimum <= radians(number) <= self.maximum
        return f': in degrees write "{number:g} deg"' * meant


@dataclass(frozen=True)
class Requirement:
    """What parameters must be to one another: where they are not, nothing is computed.

    Attributes
    ----------
    reads : the parameters that decide
    holds : parameters -> whether they are as they must be
    rule : what they must be, in one line
    fault : what is wrong where they are not, in words
    reason : what a point is told where they are not, see ``fiv_cli/flags.py``
    in_motion : harmless where no motion is followed
    """

    reads: tuple[str, ...]
    holds: Callable[[Mapping[str, float]], bool]
    rule: str
    fault: str
    reason: str
    in_motion: bool = False


@dataclass(frozen=True)
class State:
    """A generalised coordinate; its velocity is the state ``name_dot``.

    Attributes
    ----------
    small : how great it may be in equations that take it as small; of an angle 0.25 rad, up to
        which sin(x) is x to a hundredth. `fiv show` counts the motions that pass it.
    """

    name: str
    symbol: str
    unit: str
    meaning: str
    small: float = inf


@dataclass(frozen=True)
class Option:
    """A switch of a model with the thesis' choice as default.

    Attributes
    ----------
    name : contract name
    choices : what it may be; empty where `read` decides
    default : one of them, or what `read` would return
    meaning : one line
    read : value in a case file -> the text that stands for it; ValueError says what is wrong
    form : what `read` takes, in words
    join : several such texts -> the one under which the model has the states of each
    later : came after results were stored: at its default it is no part of their identity
    """

    name: str
    choices: tuple[str, ...]
    default: str
    meaning: str
    read: Callable[[object], str] | None = None
    form: str = ""
    join: Callable[[Iterable[str]], str] | None = None
    later: bool = False

    @property
    def allowed(self) -> str:
        """What it may be, in one line."""
        return self.form or ", ".join(self.choices)

    def text(self, value: object) -> str:
        """The text that stands for `value`; ValueError when it is not allowed."""
        if self.read is not None:
            return self.read(value)
        if value not in self.choices:
            raise ValueError(f"{value!r} is not allowed")
        return str(value)


@dataclass(frozen=True)
class Derived:
    """Numbers that follow from parameters by more than a formula: the modes of a plate.

    Attributes
    ----------
    names : options -> names, which `Symbols.parameter` knows like those of parameters
    values : (parameters, options) -> name -> SI value
    sources : parameters that they depend on
    """

    names: Callable[[Options], tuple[str, ...]]
    values: Callable[[Mapping[str, float], Options], Mapping[str, float]]
    sources: tuple[str, ...]


@dataclass(frozen=True)
class Forcing:
    """A periodic excitation: active when `amplitude` is not zero.

    Attributes
    ----------
    amplitude : parameter that switches it on (set to 0 in the "unexcited system")
    frequency : parameters (and `Model.derived` numbers) -> angular frequency, rad/s
    meaning : one line
    fast_velocity : parameters -> amplitude of the slip velocity, m/s, that the excitation alone
        gives a free mass at a high frequency (thesis 5.12); None: its fast motion is not averaged
    """

    amplitude: str
    frequency: Callable[[Mapping[str, float]], float]
    meaning: str
    fast_velocity: Callable[[Mapping[str, float]], float] | None = None


@dataclass(frozen=True)
class Contact:
    """One frictional contact, as SymPy expressions.

    Attributes
    ----------
    slip_velocity : v_rel, m/s; friction on the model acts along +v_rel
    slip_coordinate : name of the state whose velocity v_rel = 0 is solved for in stick
    normal_force : F_N as a function of states and parameters, N; None for a rigid contact,
        whose F_N is algebraic (it keeps the gap closed)
    gap : positive when the surfaces are apart, m; None when the contact cannot separate
    gap_coordinate : name of the state that a closed rigid gap determines; None otherwise
    ends_at_zero_normal_force : the run ends ("contact lost") when F_N reaches zero
    impact : "plastic" (the gap rate is zero after re-contact) or "none"; the impulse acts on
        the accelerations as F_N does, and its tangential part is ignored
    closing_rate : gap rate that the impulse is computed from, when it is not the gap's own
    sliding_only : the contact always slides the way the drive moves it at rest: there is neither
        stick nor reversal of friction; without a gap it is bilateral (F_N may be negative)
    static_friction : False: it sticks up to the kinetic friction at zero speed, not more
    law : name of its friction law, where that is the model's matter and not the case's
    law_parameters : law parameter name -> expression seen by its law, where it has its own
    restitution : share of the gap rate that an impact gives back (Newton); 0: plastic
    is_stop : at a sliding equilibrium it is open, see `stop`
    """

    slip_velocity: Expr
    slip_coordinate: str
    normal_force: Expr | None
    gap: Expr | None = None
    gap_coordinate: str | None = None
    ends_at_zero_normal_force: bool = False
    impact: str = "plastic"
    closing_rate: Expr | None = None
    sliding_only: bool = False
    static_friction: bool = True
    law: str | None = None
    law_parameters: Mapping[str, Expr] = field(default_factory=dict)
    restitution: Expr | int = 0
    is_stop: bool = False

    def __post_init__(self) -> None:
        if self.normal_force is None and (self.gap is None or self.gap_coordinate is None):
            raise UsageError(
                "a rigid contact (normal_force = None) has no gap or no gap_coordinate\n"
                "next: name the state that the closed gap determines"
            )


def stop(
    gap: Expr,
    coordinate: str | None = None,
    normal_force: Expr | None = None,
    restitution: Expr | int = 0,
) -> Contact:
    """A frictionless stop: what closes the gap and rests on nothing.

    Parameters
    ----------
    gap : distance that is left, m
    coordinate : of a rigid stop: the state that the closed gap determines
    normal_force : of a soft stop: its force, N, where it is closed
    restitution : share of the gap rate that an impact on a rigid stop gives back; its impacts may
        pile up: when their flights are below rounding, it stays closed
    """
    import sympy

    return Contact(
        slip_velocity=sympy.Integer(0),
        slip_coordinate="",
        normal_force=normal_force,
        gap=gap,
        gap_coordinate=coordinate,
        impact="plastic" if normal_force is None else "none",
        law="none",
        restitution=restitution,
        is_stop=True,
    )


@dataclass(frozen=True)
class Zone:
    """A sector [start, start + width) of an angle in which parameters take other values.

    Attributes
    ----------
    angle : SymPy expression, rad, taken modulo 2 pi; it grows where the slip velocity is positive
    start, width : parameter names, rad
    contact : index of the contact whose sticking freezes the angle
    """

    angle: Expr
    start: str
    width: str
    contact: int = 0


@dataclass(frozen=True)
class Equations:
    """The mechanics of a model in SymPy.

    Attributes
    ----------
    accelerations : state name -> acceleration, affine in the contact forces
    contacts : the frictional contacts
    kinetic_energy, potential_energy : J (or N m)
    law_parameters : law parameter name -> expression seen by the law, for parameters that
        differ between zones
    zone : the non-uniform sector, if any
    powers : excitation -> what it puts in, W, of those of `Model.powers`
    """

    accelerations: Mapping[str, Expr]
    contacts: tuple[Contact, ...]
    kinetic_energy: Expr
    potential_energy: Expr
    law_parameters: Mapping[str, Expr] = field(default_factory=dict)
    zone: Zone | None = None
    powers: Mapping[str, Expr] = field(default_factory=dict)

    def law_parameters_at(
        self, contact: int, table: Iterable[Parameter], symbols: Symbols
    ) -> dict[str, Expr]:
        """What the parameters of a law are at a contact."""
        given = {**self.law_parameters, **self.contacts[contact].law_parameters}
        return {p.name: given.get(p.name, symbols.parameter(p.name)) for p in table}


@dataclass(frozen=True)
class Example:
    """What a new case of a model sweeps.

    Attributes
    ----------
    axis : a parameter of the model or of the law
    low, high : its range
    given : parameters and options that are not their defaults
    settings : settings of analyses likewise, where they are required or have a default
    law : name of the law; empty: the default one of the model
    """

    axis: str
    low: float
    high: float
    given: Mapping[str, float | str] = field(default_factory=dict)
    settings: Mapping[str, float] = field(default_factory=dict)
    law: str = ""

    @property
    def middle(self) -> float:
        """The middle of the range."""
        return (self.low + self.high) / 2


def _regular(known: Mapping[str, float], options: Options) -> tuple[str, str]:
    """The equations of most models mean something under all parameters."""
    return "", ""


class Friction(Protocol):
    """What a model takes of a friction law: tables that stand above it."""

    @property
    def parameters(self) -> tuple[Parameter, ...]:
        """Of the law."""

    @property
    def origin(self) -> Origin | None:
        """Where it stands, if not in the box."""


@dataclass(frozen=True, eq=False)
class Model:
    """A mechanical model: what the user sees, and where its equations are.

    Attributes
    ----------
    name : contract name, ``belt-1dof``
    title : one line
    reference : source of the equations
    numerics_version : raised whenever a change of this file changes numbers
    parameters : the model's own parameters
    states : generalised coordinates under given options
    options : switches
    contacts : number of contacts that `equations` returns
    stops : how many of these are frictionless stops, whose impacts are counted
    constant_load : every contact is pressed by the same force at all times
    default_law : name of the friction law where a case names none
    law_defaults : law parameter -> default on this model, see `defaults_of`; a name: the value of
        that parameter
    law_leaders : law parameter -> the one whose value it takes, as a case says
    forcings : periodic excitations
    revolution : parameters -> angular speed of the disc, rad/s; None when nothing turns
    derived : numbers that are computed from the parameters, if any
    surface : ``(parameters, options, radius, angle)`` -> coordinate -> its weight in the transverse
        displacement of the disc there, in the space-fixed frame; None without an elastic disc
    equations : ``(Symbols, options) -> Equations``; imports SymPy
    vibration : coordinates that L_s counts (thesis 6.20, 6.42); none named: all
    requirements : what its parameters, and those of its laws, must be to one another
    singular : (parameters and derived numbers, options) -> the reason of ``fiv_cli/flags.py`` why
        its equations mean nothing there, and a message; ("", "") where they do
    base : coordinates that what holds the model would carry along if it moved; none: it cannot
    varied : parameters that vary harmonically, see ``excitation.py``
    powers : excitation that does work -> what it is, in words
    example : what a new case begins with: from rest it vibrates somewhere in the range
    sliding : likewise one that follows no motion: in the range sliding changes its stability; None:
        in that of `example`
    origin : where it stands, if not in the box
    """

    name: str
    title: str
    reference: str
    numerics_version: int
    parameters: tuple[Parameter, ...]
    states: Callable[[Options], tuple[State, ...]]
    equations: Callable[[Symbols, Options], Equations]
    default_law: str
    law_defaults: Mapping[str, float | str] = field(default_factory=dict)
    law_leaders: Mapping[str, str] = field(default_factory=dict)
    options: tuple[Option, ...] = ()
    contacts: int = 1
    stops: int = 0
    constant_load: bool = False
    forcings: tuple[Forcing, ...] = ()
    revolution: Callable[[Mapping[str, float]], float] | None = None
    derived: Derived | None = None
    surface: Callable[[Mapping[str, float], Options, float, float], Mapping[str, float]] | None = (
        None
    )
    vibration: tuple[str, ...] = ()
    requirements: tuple[Requirement, ...] = ()
    singular: Callable[[Mapping[str, float], Options], tuple[str, str]] = _regular
    example: Example | None = None
    base: tuple[str, ...] = ()
    varied: tuple[str, ...] = ()
    powers: Mapping[str, str] = field(default_factory=dict)
    sliding: Example | None = None
    origin: Origin | None = None

    def mechanics(self, symbols: Symbols, options: Options) -> Equations:
        """The equations under `options`; UsageError unless their contacts are as many as declared.

        The table alone says how many contacts the results of a case have.
        """
        found = self.equations(symbols, options)
        if not isinstance(found, Equations):
            raise UsageError(
                f"equations of {self.name} returns {type(found).__name__}, not Equations(...)\n"
                "next: end it with return Equations(...)"
            )
        count = len(found.contacts)
        if count != self.contacts:
            contacts = "contact" if count == 1 else "contacts"
            raise UsageError(
                f"{self.name} returns {count} {contacts} and declares {self.contacts}\n"
                f"next: write contacts={count} in its Model(...), or mend its equations"
            )
        return found

    def default_options(self) -> dict[str, str]:
        """Option name -> default choice."""
        return {option.name: option.default for option in self.options}

    def parameters_under(self, law: Friction) -> tuple[Parameter, ...]:
        """Its own parameters, then those of a law, as on this model."""
        return (*self.parameters, *self.adopted(law))

    def adopted(self, law: Friction) -> tuple[Parameter, ...]:
        """Parameters of a law with the defaults that they have on this model."""
        defaults = self.defaults_of(law)
        return tuple(_with_default(p, defaults.get(p.name)) for p in law.parameters)

    def defaults_of(self, law: Friction) -> dict[str, float | str]:
        """Parameter of a law -> the default that this model gives it.

        A law of one's own keeps what its file says, but on models of one's own, and what a case
        says to follow another.
        """
        is_kept = law.origin is not None and self.origin is None
        told = {**({} if is_kept else self.law_defaults), **self.law_leaders}
        return {p.name: told[p.name] for p in law.parameters if p.name in told}

    def excitation_period(self, known: Mapping[str, float]) -> float | None:
        """Common period of the excitations that are on, s; None where none is.

        `known` : parameters and derived numbers
        """
        frequency = common_frequency(self.forcings, known)
        return 2 * pi / abs(frequency) if frequency else None

    def fastest(self, known: Mapping[str, float]) -> float:
        """Highest angular frequency of the excitations that are on, rad/s; 0 where none is."""
        on = [forcing for forcing in self.forcings if known[forcing.amplitude] != 0.0]
        return max((abs(forcing.frequency(known)) for forcing in on), default=0.0)

    def averaged_forcing(self) -> Forcing | None:
        """The excitation whose fast motion can be averaged out, if any."""
        return next((f for f in self.forcings if f.fast_velocity is not None), None)

    def unexcited(self, parameters: Mapping[str, float]) -> dict[str, float]:
        """The same parameters with every excitation switched off."""
        return {**parameters, **{forcing.amplitude: 0.0 for forcing in self.forcings}}


def common_frequency(forcings: Iterable[Forcing], known: Mapping[str, float]) -> float | None:
    """Angular frequency of which those of all excitations that are on are multiples, rad/s.

    0 where none is on; None where there is none, up to `MOST_RATIO`.
    """
    on = (forcing for forcing in forcings if known[forcing.amplitude] != 0.0)
    found = [frequency for one in on if (frequency := one.frequency(known)) != 0.0]
    if len(set(found)) < 2:
        return found[0] if found else 0.0
    ratios = [Fraction(one / found[0]).limit_denominator(MOST_RATIO) for one in found]
    misses = [abs(r * found[0] - one) for r, one in zip(ratios, found, strict=True)]
    if any(miss > SAME_RATIO * abs(one) for miss, one in zip(misses, found, strict=True)):
        return None
    return found[0] / lcm(*(ratio.denominator for ratio in ratios))


def leaders(table: Iterable[Parameter], given: Container[str] = ()) -> dict[str, str]:
    """Parameter -> the one whose value it takes, where it is not `given` one of its own."""
    every = {p.name: p.default_from for p in table if p.default_from is not None}
    following = {name: leader for name, leader in every.items() if name not in given}
    return {name: _first_leader(name, following) for name in following}


def _first_leader(name: str, following: Mapping[str, str]) -> str:
    """The one that is followed in the end: some follow one that follows another."""
    met: list[str] = []
    while name in following and name not in met:
        met.append(name)
        name = following[name]
    return name


def followed(table: Sequence[Parameter], given: Mapping[str, float]) -> dict[str, float]:
    """The values that a table of parameters has, in its order: as given, or as their leaders'."""
    sources = {p.name: p.name for p in table} | leaders(table, given)
    return {name: given[source] for name, source in sources.items() if source in given}


def _with_default(parameter: Parameter, default: float | str | None) -> Parameter:
    if default is None:
        return parameter
    if isinstance(default, str):
        return replace(parameter, default=None, default_from=default)
    return replace(parameter, default=default, default_from=None)
