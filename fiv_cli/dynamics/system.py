"""A compiled system: a model, a law and options, ready to move."""

from __future__ import annotations

from collections.abc import Callable, Hashable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property, partial
from operator import itemgetter
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from fiv_cli.codegen.codes import ENERGY_OUTPUTS, PER_CONTACT, SEPARATION, index_of
from fiv_cli.codegen.generate import JACOBIAN, JACOBIAN_ORDER, Generated, StateTable, generate
from fiv_cli.codegen.generate import TANGENT as TANGENT_TEXT
from fiv_cli.codegen.memory import call_generated
from fiv_cli.codegen.setup import Setup
from fiv_cli.dynamics.pieces import Pieces
from fiv_cli.dynamics.rows import call_rows
from fiv_cli.friction import get_law
from fiv_cli.schedule import rate_of

Vector = NDArray[np.float64]

_BUILT: dict[Hashable, System] = {}


def build_system(setup: Setup, announce: Callable[[str], None] = lambda message: None) -> System:
    """The compiled system, from memory, from the per-user cache, or made now.

    `announce` is called with a sentence when something has to be generated or compiled.
    """
    if setup.key not in _BUILT:
        generated = generate(setup, announce)
        if not generated.is_compiled():
            announce(f"compiling {setup.title} (once per user)")
        _BUILT[setup.key] = System(setup, generated)
    return _BUILT[setup.key]


@dataclass(frozen=True, eq=False)
class System:
    """A compiled system.

    Attributes
    ----------
    setup : what it is
    generated : text, tables and machine code
    """

    setup: Setup
    generated: Generated

    @cached_property
    def state_names(self) -> tuple[str, ...]:
        """Entries of the state vector."""
        return self.generated.state_names

    @property
    def coordinates(self) -> tuple[str, ...]:
        """Generalised coordinates: the first entries of the state vector."""
        return self.generated.coordinates

    @cached_property
    def n_contacts(self) -> int:
        """Number of contacts."""
        return len(self.generated.smooth)

    @cached_property
    def tables(self) -> Tables:
        """What the driver reads."""
        return _tables(self.generated)

    @cached_property
    def jacobians(self) -> Mapping[int, int]:
        """Index of the contact state -> address of its linearised flow, compiled on first use."""
        return {
            index: self.generated.address(f"{state.name}_jacobian", JACOBIAN)
            for index, state in self.generated.states.items()
        }

    @cached_property
    def tangent_tables(self) -> Mapping[str, NDArray[np.int64]]:
        """Addresses of the functions that carry tangents, compiled on first use, by field."""
        tables = {
            "followed": np.zeros_like(self.tables.field),
            "tangent": np.zeros_like(self.tables.field),
            "switching_with_tangent": np.zeros_like(self.tables.field),
            "impact_with_tangent": np.zeros_like(self.tables.impact),
        }
        for index, state in self.generated.states.items():
            name, address = state.name, partial(self.generated.address, part=TANGENT_TEXT)
            tables["followed"][index] = address(f"{name}_followed")
            tables["tangent"][index] = address(f"{name}_tangent")
            tables["switching_with_tangent"][index] = address(f"{name}_switching")
            for contact in state.impacts:
                place = index, contact
                tables["impact_with_tangent"][place] = address(f"{name}_impact_tangent_{contact}")
        return tables

    @cached_property
    def greatest_slip(self) -> Vector:
        """Where its motions leave how fast they slip beyond what its law is known up to, m/s."""
        return np.array([self.setup.law.reach] if self.setup.law.reach < np.inf else [])

    @cached_property
    def sum_tangent(self) -> int:
        """Address of the function that sums the series of tangents, compiled on first use."""
        return self.generated.address("moved", TANGENT_TEXT)

    @cached_property
    def sliding_index(self) -> int:
        """Number of the contact state in which every contact slips and every stop is open."""
        return index_of(self.generated.sliding)

    @cached_property
    def outputs_width(self) -> int:
        """Most numbers that a field function writes."""
        return int(np.max(self.tables.energy_place)) + self.n_energies

    @property
    def n_energies(self) -> int:
        """Numbers that a field function writes of energies and powers."""
        return len(ENERGY_OUTPUTS) + len(self.setup.model.powers)

    # --- generated functions, called from Python --------------------------------------------------
    def coefficients(self, parameters: Vector) -> Vector:
        """What depends on parameters alone, as generated code reads it; shape (..., terms)."""
        shape = *parameters.shape[:-1], max(self.generated.n_coefficients, 1)
        coefficients = np.zeros(shape)
        fill = self.tables.numbers["fill_coefficients"]
        call_rows(fill, coefficients, 0.0, parameters, coefficients)
        return coefficients

    def field(self, index: int, coefficients: Vector, time: float, y: Vector) -> FieldOutput:
        """What a contact state makes of a state, or of each of some, (..., n_states)."""
        tables, n = self.tables, y.shape[-1]
        out = np.zeros((*y.shape[:-1], self.outputs_width))
        if y.ndim == 1:
            call_generated(tables.field[index], coefficients, time, y, out)
        else:
            call_rows(tables.field[index], coefficients, time, y, out)
        contacts, energies = tables.contact_place[index], tables.energy_place[index]
        stored = contacts + PER_CONTACT * self.n_contacts
        forces = out[..., contacts:stored]
        return FieldOutput(
            out[..., :n],
            out[..., n : 2 * n],
            out[..., 2 * n : 2 * n + tables.n_guards[index]],
            forces.reshape(*y.shape[:-1], self.n_contacts, PER_CONTACT),
            out[..., stored:energies],
            out[..., energies : energies + len(ENERGY_OUTPUTS)],
            out[..., energies + len(ENERGY_OUTPUTS) : energies + self.n_energies],
        )

    def linearised(
        self, index: int, coefficients: Vector, time: float, y: Vector, places: Sequence[int]
    ) -> NDArray[np.float64]:
        """Tangents along these entries of the state as a contact state lets them be, and their
        rates, by differentiated code; shape (..., entries, n_states, 2)."""
        *rows, n = y.shape
        count = len(places)
        joined = np.zeros((*rows, count, 2 * n))
        series = np.zeros((*rows, count, 2 * n, JACOBIAN_ORDER + 1))
        joined[..., :n] = y[..., None, :]
        joined[..., range(count), [n + place for place in places]] = 1.0
        call_rows(self.jacobians[index], coefficients, time, joined, series)
        return series[..., n:, :]

    def parameter_values(self, parameters: Mapping[str, float]) -> tuple[float, ...]:
        """Parameters of model and law in generated order."""
        values: tuple[float, ...] = self._take_own(self.known(parameters))
        return values

    def parameter_vector(self, parameters: Mapping[str, float]) -> Vector:
        """`parameter_values`, first pieces, slip signs +1, sector 0; shape (n_parameters,)."""
        return self.parameter_vectors([parameters])[0]

    def parameter_vectors(self, points: Sequence[Mapping[str, float]]) -> NDArray[np.float64]:
        """The same of several points, in rows."""
        behind = (*self.pieces.first_rows, *(1.0,) * self.n_contacts, 0.0)
        return np.array([(*self.parameter_values(point), *behind) for point in points])

    @cached_property
    def pieces(self) -> Pieces:
        """What its laws are given by, where they are given by pieces."""
        own, laws = self.setup.law, self.generated.pieced
        return Pieces({i: own if name == own.name else get_law(name) for i, name, _ in laws})

    @property
    def n_own_parameters(self) -> int:
        """Parameters of model and law: numbers of pieces, slip signs and sector follow them."""
        rows = len(self.pieces.first_rows)
        return len(self.generated.parameter_names) - 1 - self.n_contacts - rows

    @cached_property
    def _take_own(self) -> itemgetter[Any]:
        """Takes the model's and the law's parameters (there are several) out of a mapping."""
        return itemgetter(*self.generated.parameter_names[: self.n_own_parameters])

    @cached_property
    def _is_extended(self) -> bool:
        return self.setup.model.derived is not None or bool(self.setup.schedule.curves)

    def known(self, parameters: Mapping[str, float]) -> Mapping[str, float]:
        """The parameters, what is computed from them, and rates (zero) of what varies.

        What varies in time stands as it is at t = 0.
        """
        if not self._is_extended:
            return parameters
        known = {**parameters, **self.setup.schedule.values(0.0)}
        if self.setup.model.derived is not None:
            known |= self.setup.model.derived.values(known, self.setup.options)
        return known | {rate_of(name): 0.0 for name in self.setup.schedule.names}

    def told_to_law(self, contact: int, point: Mapping[str, float]) -> Mapping[str, float]:
        """The parameters that the law of a contact, given by pieces, has there."""
        own = {i for i, _, has_own in self.generated.pieced if has_own}
        return self.setup.own_parameters(contact, self.known(point)) if contact in own else point

    @property
    def motions(self) -> tuple[str, ...]:
        """The displacements and velocities: the states but for those of the friction law."""
        return self.state_names[: 2 * len(self.coordinates)]

    @cached_property
    def places(self) -> Mapping[str, int]:
        """Name of an entry of the state vector -> its place."""
        return {name: place for place, name in enumerate(self.state_names)}

    def state_vector(self, values: Mapping[str, float]) -> Vector:
        """State vector from named values, the rest 0; shape (n_states,)."""
        vector = np.zeros(len(self.state_names))
        for name, value in values.items():
            if name in self.places:
                vector[self.places[name]] = value
        return vector


class FieldOutput(NamedTuple):
    """What a field function says of a state.

    Attributes
    ----------
    state : with the entries that contact determines; shape (n_states,)
    rates : its time derivatives; shape (n_states,)
    switching : switching functions of the contact state; shape (n_guards,)
    contacts : `CONTACT_OUTPUTS` per contact; shape (n_contacts, 3)
    stored : by the law, per contact, J; shape (n_contacts,), (0,) of a law that stores nothing
    energies : `ENERGY_OUTPUTS`
    powers : those of `Model.powers`
    """

    state: Vector
    rates: Vector
    switching: Vector
    contacts: Vector
    stored: Vector
    energies: Vector
    powers: Vector


@dataclass(frozen=True)
class Tables:
    """What the driver reads of a system: see `kernel.Run`, whose fields these are.

    Attributes
    ----------
    numbers : the scalars among them
    """

    taylor: NDArray[np.int64]
    field: NDArray[np.int64]
    guards: NDArray[np.int64]
    measured: NDArray[np.int64]
    powers: NDArray[np.int64]
    impact: NDArray[np.int64]
    n_guards: NDArray[np.int64]
    guard_kinds: NDArray[np.int64]
    guard_contacts: NDArray[np.int64]
    guard_places: NDArray[np.int64]
    has_angle: NDArray[np.int64]
    n_arguments: NDArray[np.int64]
    contact_place: NDArray[np.int64]
    energy_place: NDArray[np.int64]
    is_end: NDArray[np.int64]
    is_one_way: NDArray[np.int64]
    sliding_kinds: NDArray[np.int64]
    bounces: NDArray[np.int64]
    numbers: Mapping[str, int]

    def arrays(self) -> dict[str, NDArray[np.int64]]:
        """The arrays by name."""
        return {name: table for name, table in vars(self).items() if name != "numbers"}


def _tables(generated: Generated) -> Tables:
    contacts, states = len(generated.smooth), generated.states
    most = max(1, *(len(state.guards) for state in states.values()))
    of_guards = dict.fromkeys(("guard_kinds", "guard_contacts", "guard_places"), (most,))
    widths = {"impact": (contacts,), **of_guards}
    per_state = {
        name: np.zeros((3**contacts, *widths.get(name, ())), np.int64)
        for name in (*widths, "taylor", "field", "guards", "measured", "powers", "n_guards",
                     "has_angle", "n_arguments", "contact_place", "energy_place")
    }  # fmt: skip
    per_contact = {
        "is_end": np.ones(contacts, np.int64),
        "is_one_way": np.array(generated.smooth, np.int64),
        "sliding_kinds": np.array(generated.sliding, np.int64),
        "bounces": np.array(generated.bounces, np.int64),
    }
    tables = Tables(**per_state, **per_contact, numbers=_numbers(generated))
    for index, state in states.items():
        _enter_state(tables, generated, index, state)
    return tables


def _enter_state(tables: Tables, generated: Generated, index: int, state: StateTable) -> None:
    """Fill in what is known of a contact state."""
    contacts = len(generated.smooth)
    tables.taylor[index] = generated.address(f"{state.name}_taylor")
    tables.field[index] = generated.address(f"{state.name}_field")
    tables.guards[index] = generated.address(f"{state.name}_guards")
    tables.measured[index] = generated.address(f"{state.name}_measured")
    tables.powers[index] = generated.address(f"{state.name}_powers")
    for contact in state.impacts:
        tables.impact[index, contact] = generated.address(f"{state.name}_impact_{contact}")
    tables.n_guards[index] = len(state.guards)
    told = tables.guard_kinds, tables.guard_contacts, tables.guard_places
    for number, guard in enumerate(state.guards):
        for table, entry in zip(told, guard, strict=True):
            table[index, number] = entry
    tables.has_angle[index] = int(state.has_angle)
    tables.n_arguments[index] = state.n_arguments
    first = 2 * len(generated.state_names) + len(state.guards) + int(state.has_angle)
    tables.contact_place[index] = first
    tables.energy_place[index] = first + PER_CONTACT * contacts + generated.n_stored
    tables.is_end[np.array(state.kinds) == SEPARATION] = 0


def _numbers(generated: Generated) -> dict[str, int]:
    names = generated.parameter_names
    start, width, contact = generated.zone or ("", "", 0)
    return {
        "n_states": len(generated.state_names),
        "n_coordinates": len(generated.coordinates),
        "n_contacts": len(generated.smooth),
        "all_sliding": index_of(generated.sliding),
        "most_open": max(
            generated.states, key=lambda i: generated.states[i].kinds.count(SEPARATION)
        ),
        "order": generated.order,
        "tangent_order": generated.tangent_order,
        "fill_coefficients": generated.address("coefficients"),
        "sum_series": generated.address("state"),
        "value_slope_bend": generated.address("value_slope_bend"),
        "bernstein": generated.address("bernstein"),
        "sector_start": names.index(start) if start else -1,
        "sector_width": names.index(width) if width else -1,
        "inside_sector": len(names) - 1,
        "sector_contact": contact,
    }
