"""A compiled system: a model, a law and options, ready to move."""

from __future__ import annotations

from collections.abc import Callable, Hashable, Mapping
from dataclasses import dataclass
from functools import cached_property
from operator import itemgetter
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fiv_cli.codegen.generate import JACOBIAN, Generated, generate
from fiv_cli.codegen.generate import TANGENT as TANGENT_TEXT
from fiv_cli.codegen.setup import Setup
from fiv_cli.models.base import rate_of

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
    def tangent_table(self) -> NDArray[np.int64]:
        """`Tables.table` with the tangent functions, compiled on first use."""
        from fiv_cli.dynamics import kernel

        table = self.tables.table.copy()
        for index, state in self.generated.states.items():
            for place, kind in ((kernel.TANGENT, "tangent"), (kernel.SWITCHING, "switching")):
                name = f"{state.name}_{kind}"
                table[index, place] = self.generated.address(name, TANGENT_TEXT)
            table[index, kernel.MOVED] = self.generated.address("moved", TANGENT_TEXT)
        return table

    @cached_property
    def tangent_impacts(self) -> NDArray[np.int64]:
        """`Tables.impacts` with the functions that carry tangents, compiled on first use."""
        impacts = self.tables.impacts.copy()
        for index, state in self.generated.states.items():
            for contact in state.impacts:
                name = f"{state.name}_impact_tangent_{contact}"
                place = self.n_contacts + contact
                impacts[index, place] = self.generated.address(name, TANGENT_TEXT)
        return impacts

    def parameter_values(self, parameters: Mapping[str, float]) -> tuple[float, ...]:
        """Parameters in generated order; the slip signs and the sector follow them there."""
        values: tuple[float, ...] = self._take_own(self.known(parameters))
        return values

    def parameter_vector(self, parameters: Mapping[str, float]) -> Vector:
        """`parameter_values`, slip signs +1, sector 0; shape (n_parameters,)."""
        return np.array([*self.parameter_values(parameters), *(1.0,) * self.n_contacts, 0.0])

    @cached_property
    def _take_own(self) -> itemgetter[Any]:
        """Takes the model's and the law's parameters (there are several) out of a mapping."""
        own = len(self.generated.parameter_names) - 1 - self.n_contacts
        return itemgetter(*self.generated.parameter_names[:own])

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


@dataclass(frozen=True)
class Tables:
    """Tables of addresses and switching functions, indexed by contact state (see kernel.py).

    `impacts` holds, per contact, the impact function and then, while tangents are carried, the
    one that takes them through the impact; `ends` is 1 for a contact that cannot open, whose loss
    ends a motion.
    """

    table: NDArray[np.int64]
    impacts: NDArray[np.int64]
    guards: NDArray[np.int64]
    config: NDArray[np.int64]
    ends: NDArray[np.int64]


def _tables(generated: Generated) -> Tables:
    from fiv_cli.dynamics import kernel

    contacts = len(generated.smooth)
    count = 3**contacts
    most = max(len(state.guards) for state in generated.states.values())
    table = np.zeros((count, kernel.TABLE_WIDTH), np.int64)
    impacts = np.zeros((count, 2 * contacts), np.int64)
    guards = np.full((count, max(most, 1), 2), -1, np.int64)
    for index, state in generated.states.items():
        table[index, kernel.TAYLOR] = generated.address(f"{state.name}_taylor")
        table[index, kernel.FIELD] = generated.address(f"{state.name}_field")
        table[index, kernel.N_GUARDS] = len(state.guards)
        table[index, kernel.HAS_ANGLE] = int(state.has_angle)
        table[index, kernel.N_ARGUMENTS] = state.n_arguments
        for contact in state.impacts:
            impacts[index, contact] = generated.address(f"{state.name}_impact_{contact}")
        for place, guard in enumerate(state.guards):
            guards[index, place] = guard
    ends = np.ones(contacts, np.int64)
    for state in generated.states.values():
        ends[np.array(state.kinds) == kernel.SEPARATION] = 0
    return Tables(table, impacts, guards, _config(generated), ends)


def _config(generated: Generated) -> NDArray[np.int64]:
    from fiv_cli.dynamics import kernel

    config = np.full(kernel.CONFIG_WIDTH, -1, np.int64)
    config[kernel.N_STATES] = len(generated.state_names)
    config[kernel.N_CONTACTS] = len(generated.smooth)
    config[kernel.ORDER] = generated.order
    config[kernel.TANGENT_ORDER] = generated.tangent_order
    config[kernel.N_PARAMETERS] = len(generated.parameter_names)
    config[kernel.N_COORDINATES] = len(generated.coordinates)
    config[kernel.COEFFICIENTS] = generated.address("coefficients")
    config[kernel.STATE] = generated.address("state")
    config[kernel.VALUE_AND_SLOPE] = generated.address("value_and_slope")
    config[kernel.BERNSTEIN] = generated.address("bernstein")
    config[kernel.METHOD] = kernel.METHOD_TAYLOR
    config[kernel.ZONE_CONTACT] = 0
    if generated.zone is not None:
        start, width, contact = generated.zone
        config[kernel.ZONE_START] = generated.parameter_names.index(start)
        config[kernel.ZONE_WIDTH] = generated.parameter_names.index(width)
        config[kernel.ZONE_CONTACT] = contact
    return config
