"""What a friction law is.

To add a law: write ``fiv_cli/friction/my_law.py`` with a docstring (formula and source), its
parameter table, what its parameters must be to one another (`Requirement`), ``force`` and
``capacity``, and ``LAW = Law(...)``; list it in ``fiv_cli/friction/__init__.py``; add a row to
``tests/test_friction.py``.

``force(slip, parameters)`` returns F_T as a SymPy expression. `slip` gives the signed slip
velocity ``v``, the sign of slip ``sign`` (+1 or -1, a property of the contact state, never
computed from v), the speed ``speed`` = sign * v >= 0, the normal force ``N`` and the law's
internal states by name. Whatever contains ``sign`` or ``speed`` is non-analytic at v = 0: the
contact state then has a border there, and an event lies on it.

A law may be given by *pieces*, between which each of its elements changes: a slider that is held or
slides, intervals of the slip velocity. A piece is a row of numbers that force, rates and guards
contain (`Slip.rows`); it is left where a guard falls to zero, which is an event.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import TYPE_CHECKING

from fiv_cli.models.base import Parameter, Requirement, State, followed
from fiv_cli.models.origin import Origin

if TYPE_CHECKING:
    from sympy import Expr


HELD = {"D": "N", "m": "kg"}
"""What `Slip.holding` is made of where there is no system: the force demanded, the mass; units."""


def _held(rate: Expr) -> Expr:
    import sympy

    demand, mass = (sympy.Symbol(name, real=True) for name in HELD)
    return demand - mass * rate


@dataclass(frozen=True)
class Slip:
    """The symbols a law is written in (SymPy): v m/s, sign, speed m/s, N newtons, states.

    `rows` are the numbers of the pieces that the elements of the law are in, an element each.
    `holding(rate)` is the force F_T, N, under which v changes at this rate, m/s2.
    """

    v: Expr
    sign: Expr
    speed: Expr
    N: Expr
    states: Mapping[str, Expr] = field(default_factory=dict)
    rows: Sequence[Sequence[Expr]] = ()
    holding: Callable[[Expr], Expr] = _held


STORED = State("stored_energy", "E_s", "J", "energy that friction has stored")


@dataclass(frozen=True)
class Exit:
    """What follows where a guard of a piece falls to zero.

    Attributes
    ----------
    to : name of the piece
    zeros : of each of its guards, how many derivatives, from the value on, are zero then
    begins_anew : whether the state of the element, which has one of its own, begins anew at zero
    """

    to: str
    zeros: tuple[int, ...]
    begins_anew: bool = False


@dataclass(frozen=True)
class Piece:
    """A sub-state of a slipping contact: what an element of a law is in.

    Attributes
    ----------
    name : its first word is what events are booked under, see `flags.PIECES`
    row : the numbers that the law's expressions contain
    exits : what follows where each guard falls to zero; None of one that does not
    """

    name: str
    row: tuple[float, ...]
    exits: tuple[Exit | None, ...]


@dataclass(frozen=True)
class Surface:
    """How friction varies along the surface.

    Attributes
    ----------
    amplitude : parameter that it varies with; where this is zero, it does not
    wavelength : parameters -> way after which it is as before, m
    along : ``(way slid, parameters)`` -> those parameters that vary, as they are there
    """

    amplitude: str
    wavelength: Callable[[Mapping[str, float]], float]
    along: Callable[[Expr, Mapping[str, Expr]], Mapping[str, Expr]]


@dataclass(frozen=True, eq=False)
class Law:
    """A friction law.

    Attributes
    ----------
    name : contract name
    title : one line
    reference : source of the formula
    numerics_version : raised whenever a change of this file changes numbers
    parameters : its parameter table
    force : ``(Slip, parameters) -> F_T`` in N, positive along v
    capacity : ``(N, parameters) -> static capacity`` in N; None for a law that cannot stick; of a
        system it finds the internal states among the parameters
    states : internal states; they begin at zero
    rates : ``(Slip, parameters) -> {state: rate}``
    structural : parameters whose value is written into the generated code (exponents)
    average : ``(Slip, parameters, U, reversing) -> F_T`` in N, averaged over a fast harmonic slip
        velocity of amplitude U about v: `reversing` says whether it changes the sign of slip
        (U > |v|); None for a law without such a form (see `averaged.py`)
    requirements : what its parameters must be to one another
    constant_load : it gives a force that does not depend on the normal force
    only_in_stick : parameters that sliding does not read
    steady : ``(Slip, parameters) -> F_T`` in N of steady sliding, where the states are at rest;
        None: what `rates` say
    stored : ``(Slip, parameters) -> energy`` in J that friction may give back, under a constant
        normal force; None: none
    pieces : those that an element may be in, the one that it begins in first
    elements : that change from piece to piece, each for itself
    guards : ``(Slip, parameters) -> the guards of each element``, positive inside a piece
    resting : ``(v, parameters) -> name of the piece of each element`` in steady sliding; None: of
        a law by pieces, whose states never rest, so that there is no equilibrium
    snaps : parameters -> events that a metre of steady slip brings; None: none
    surface : how it varies from place to place; None: it does not
    reach : slip speed up to which it is known, m/s; beyond, it is assumed
    origin : where it stands, if not in the box
    """

    name: str
    title: str
    reference: str
    numerics_version: int
    parameters: tuple[Parameter, ...]
    force: Callable[[Slip, Mapping[str, Expr]], Expr]
    capacity: Callable[[Expr, Mapping[str, Expr]], Expr] | None
    states: tuple[State, ...] = ()
    rates: Callable[[Slip, Mapping[str, Expr]], Mapping[str, Expr]] | None = None
    structural: tuple[str, ...] = ()
    average: Callable[[Slip, Mapping[str, Expr], Expr, bool], Expr] | None = None
    requirements: tuple[Requirement, ...] = ()
    constant_load: bool = False
    only_in_stick: tuple[str, ...] = ()
    steady: Callable[[Slip, Mapping[str, Expr]], Expr] | None = None
    stored: Callable[[Slip, Mapping[str, Expr]], Expr] | None = None
    pieces: tuple[Piece, ...] = ()
    elements: int = 1
    guards: Callable[[Slip, Mapping[str, Expr]], Sequence[Sequence[Expr]]] | None = None
    resting: Callable[[float, Mapping[str, float]], Sequence[str]] | None = None
    snaps: Callable[[Mapping[str, float]], float] | None = None
    surface: Surface | None = None
    reach: float = float("inf")
    origin: Origin | None = None

    @property
    def kind(self) -> str:
        """``set-valued`` (it sticks), ``regularised`` (smooth) or ``dynamic`` (with states)."""
        if self.states:
            return "dynamic"
        return "regularised" if self.capacity is None else "set-valued"

    @property
    def inner(self) -> tuple[State, ...]:
        """What a motion tells of it over time: its states, and what it has stored."""
        return self.states if self.stored is None else (*self.states, STORED)

    @cached_property
    def places(self) -> dict[str, int]:
        """Name of a piece -> its number."""
        return {piece.name: number for number, piece in enumerate(self.pieces)}

    @property
    def events(self) -> tuple[str, ...]:
        """Words for the pieces in a ledger."""
        return tuple(piece.name.split()[0] for piece in self.pieces)

    @property
    def rests(self) -> bool:
        """Whether it has a state of steady sliding."""
        return self.resting is not None or not self.pieces

    @property
    def shape(self) -> tuple[int, int]:
        """Elements that are in a piece each, and numbers of a piece."""
        return (self.elements, len(self.pieces[0].row)) if self.pieces else (0, 0)

    def row_symbols(self) -> list[list[Expr]]:
        """What the numbers of the pieces are called where a law is written out."""
        import sympy

        elements, length = self.shape
        tail = [f"_{element + 1}" if elements > 1 else "" for element in range(elements)]
        return [
            [sympy.Symbol(f"n{place + 1}{end}", real=True) for place in range(length)]
            for end in tail
        ]

    def at_rest(self, v: float, parameters: Mapping[str, float]) -> list[int]:
        """Number of the piece that each element is in while it slides steadily at v, m/s.

        The first one where there is no such state, or nothing slides.
        """
        if self.resting is None or v == 0.0:
            return [0] * self.shape[0]
        return [self.places[name] for name in self.resting(v, parameters)]

    def rows_at(self, v: float, parameters: Mapping[str, float]) -> list[tuple[float, ...]]:
        """The numbers of these pieces, an element each."""
        return [self.pieces[number].row for number in self.at_rest(v, parameters)]

    def sliding(self, slip: Slip, parameters: Mapping[str, Expr]) -> Expr:
        """F_T in N of steady sliding, where the internal states rest."""
        import sympy

        if self.rates is None or self.steady is not None:
            return (self.steady or self.force)(slip, parameters)
        states = {state.name: sympy.Symbol(state.name, real=True) for state in self.states}
        moving = replace(slip, states=states)
        rates = self.rates(moving, parameters)
        (rest,) = sympy.solve([rates[name] for name in states], list(states.values()), dict=True)
        return sympy.sympify(self.force(moving, parameters)).subs(rest)

    @property
    def defaults(self) -> dict[str, float]:
        """Parameter -> default of its own table; a model may have others."""
        return self.completed({})

    def completed(self, given: Mapping[str, float]) -> dict[str, float]:
        """Parameter -> value: as given, else the default of its own table."""
        defaults = {p.name: p.default for p in self.parameters if p.default is not None}
        return followed(self.parameters, {**defaults, **given})


def room_of_pieces(laws: Iterable[Law]) -> tuple[int, int]:
    """Most numbers that a piece of any of these laws has, and most ways out of one."""
    pieces = [piece for law in laws for piece in law.pieces]
    longest = max((len(piece.row) for piece in pieces), default=0)
    return longest, max((len(piece.exits) for piece in pieces), default=0)
