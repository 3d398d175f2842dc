"""From a model and a law to the equations of every contact state.

Each contact slips, sticks or is separated. In every combination the contact forces follow from
conditions that are affine in them (accelerations are affine in the contact forces): a sticking
contact has no slip acceleration, a closed rigid contact no gap acceleration. From these come the
rates, the switching functions, the contact forces and the powers of the energy balance.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from itertools import chain, product

import sympy
from sympy import Expr

from fiv_cli.codegen.codes import (
    CAPACITY_DOWN,
    CAPACITY_UP,
    GAP,
    JAMMING,
    NORMAL,
    PARTING,
    PIECE,
    SEPARATION,
    SINGULAR,
    SLIP,
    STICK,
    VELOCITY,
    index_of,
)
from fiv_cli.codegen.gather import gathered
from fiv_cli.codegen.graph import Graph, Node
from fiv_cli.codegen.joint import Joint, Row, are_free, joints
from fiv_cli.codegen.setup import Setup
from fiv_cli.errors import UsageError
from fiv_cli.friction.base import Slip, room_of_pieces
from fiv_cli.friction.powers import eased
from fiv_cli.friction.surface import way_slid
from fiv_cli.models.base import Contact, Equations
from fiv_cli.models.symbols import Symbols
from fiv_cli.schedule import rate_of

SHORT = 4  # terms of a sum that is merged into a power, where what springs store cancels


@dataclass(frozen=True)
class Guard:
    """A switching function; of an element's piece also its place among those of all elements."""

    kind: int
    contact: int
    node: Node
    place: int = 0


@dataclass(frozen=True)
class ContactState:
    """The equations of one combination of slip, stick and separation.

    Attributes
    ----------
    kinds : SLIP, STICK or SEPARATION, per contact
    values : nodes of the state vector; a constrained entry is a function of the others
    rates : their time derivatives
    guards : switching functions
    angle : angle of the sector, None where it does not move or does not exist
    contacts : nodes of `CONTACT_OUTPUTS`, per contact
    stored : what the law has stored, per contact; none of a law that stores nothing
    energies : nodes of `ENERGY_OUTPUTS`, then the power of each excitation
    impacts : contact -> velocity entries after an impact on it (position -> node)
    """

    kinds: tuple[int, ...]
    values: tuple[Node, ...]
    rates: tuple[Node, ...]
    guards: tuple[Guard, ...]
    angle: Node | None
    contacts: tuple[tuple[Node, Node, Node], ...]
    stored: tuple[Node, ...]
    energies: tuple[Node, ...]
    impacts: Mapping[int, Mapping[int, Node]]

    @property
    def name(self) -> str:
        """``slip``, ``stick_slip`` ...: one word per contact."""
        return "_".join(("slip", "stick", "separation")[kind] for kind in self.kinds)


@dataclass(frozen=True)
class Derivation:
    """Everything that follows from a model with a law.

    Attributes
    ----------
    graph : the expressions
    state_names : entries of the state vector: coordinates, velocities, internal states
    parameter_names : entries of the parameter vector: parameters, numbers of pieces, signs of
        slip, zone
    states : contact states by `index_of`
    smooth : per contact, whether its law has no border at zero slip
    sliding : kinds of the contacts where all slide: SLIP, of a stop SEPARATION
    bounces : per contact, whether an impact gives something back
    pieced : contacts whose law is given by pieces, the name of that law, and whether it has
        parameters of its own there
    zone : start and width parameters of the sector and its contact, if any
    """

    graph: Graph
    state_names: tuple[str, ...]
    parameter_names: tuple[str, ...]
    states: Mapping[int, ContactState]
    smooth: tuple[bool, ...]
    sliding: tuple[int, ...]
    bounces: tuple[bool, ...]
    pieced: tuple[tuple[int, str, bool], ...]
    zone: tuple[str, str, int] | None


def derive(setup: Setup) -> Derivation:
    """Derive all contact states."""
    return _Deriver(setup).derive()


class _Deriver:
    def __init__(self, setup: Setup) -> None:
        self.setup, self.powers = setup, setup.model.powers
        scheduled = setup.schedule.names
        self.symbols = Symbols(setup.structural, scheduled)
        self.graph = Graph()
        self.equations: Equations = setup.model.mechanics(self.symbols, setup.options)
        self.contacts = self.equations.contacts
        self.laws = [setup.law_of(contact) for contact in self.contacts]
        self.pieced = [i for i, law in enumerate(self.laws) if law.pieces]
        self.width, self.ways = room_of_pieces(self.laws)
        self.coordinates = [state.name for state in setup.model.states(setup.options)]
        self.internal = [
            [f"{state.name}_{i + 1}" if len(self.laws) > 1 else state.name for state in law.states]
            for i, law in enumerate(self.laws)
        ]
        self.parameters = [*setup.parameter_names, *map(rate_of, scheduled)]
        self.law_forces = [self._law_force(i) for i in range(len(self.contacts))]

    # --- the parts of the vector ------------------------------------------------------------------
    @property
    def state_names(self) -> list[str]:
        velocities = [f"{name}_dot" for name in self.coordinates]
        return [*self.coordinates, *velocities, *chain.from_iterable(self.internal)]

    def derive(self) -> Derivation:
        states = {}
        self._joints(self._all_held())  # what all contacts at once leave open is refused first
        for kinds in product((SLIP, STICK, SEPARATION), repeat=len(self.contacts)):
            each = all(self._possible(i, kind) for i, kind in enumerate(kinds))
            if each and not self._blocked(kinds):
                states[index_of(kinds)] = self._contact_state(kinds)
        signs = [f"sign.{i}" for i in range(len(self.contacts))]
        rows = [symbol.name for i in range(len(self.contacts)) for symbol in self._rows(i)]
        zone = self.equations.zone
        return Derivation(
            graph=self.graph,
            state_names=tuple(self.state_names),
            parameter_names=(*self.parameters, *rows, *signs, "zone"),
            states=states,
            smooth=tuple(self._is_smooth(i) for i in range(len(self.contacts))),
            sliding=tuple(SEPARATION if contact.is_stop else SLIP for contact in self.contacts),
            bounces=tuple(contact.restitution != 0 for contact in self.contacts),
            pieced=tuple(
                (i, self.laws[i].name, bool(self.contacts[i].law_parameters)) for i in self.pieced
            ),
            zone=None if zone is None else (zone.start, zone.width, zone.contact),
        )

    def _possible(self, contact: int, kind: int) -> bool:
        if kind == STICK:
            return (
                self.laws[contact].capacity is not None and not self.contacts[contact].sliding_only
            )
        if kind == SEPARATION:
            return self.contacts[contact].gap is not None
        return True

    def _all_held(self) -> tuple[int, ...]:
        """Every contact that can stick does, every stop is open."""
        return tuple(
            SEPARATION if contact.is_stop else STICK if self._possible(i, STICK) else SLIP
            for i, contact in enumerate(self.contacts)
        )

    def _blocked(self, kinds: tuple[int, ...]) -> bool:
        """Whether a closed stop is in the way of what sticks, or of another stop that is closed."""
        closed = self._closed(kinds)
        if not any(self.contacts[i].is_stop for i in closed):
            return False
        slips, gaps = self._conditions(kinds)
        return not are_free([*slips.values(), *gaps.values()])

    # --- the law ----------------------------------------------------------------------------------
    def _law_parameters(self, contact: int) -> dict[str, Expr]:
        law = self.laws[contact]
        given = self.equations.law_parameters_at(contact, law.parameters, self.symbols)
        if law.surface is None:
            return given
        if law is not self.setup.law:
            raise UsageError(
                f"a contact of {self.setup.model.name} has a law of its own, {law.name!r}, that "
                "varies along the surface\nnext: leave its law to the case"
            )
        way = way_slid(
            self.contacts[contact], self.coordinates, self.symbols, self.setup.schedule.names
        )
        return {**given, **law.surface.along(way, given)}

    def _slip(self, contact: int) -> Slip:
        sign = self.symbols.sign(contact)
        v = sympy.Symbol("v", real=True)
        law, names = self.laws[contact], self.internal[contact]
        return Slip(
            v=v,
            sign=sign,
            speed=sign * v,
            N=self.symbols.normal_force(contact),
            states={
                state.name: self.symbols.coordinate(entry)
                for state, entry in zip(law.states, names, strict=True)
            },
            rows=self._rows_of(contact),
            holding=partial(self._holding, contact),
        )

    def _holding(self, contact: int, rate: Expr) -> Expr:
        """F_T of a contact under which its slip velocity changes at this rate."""
        count, own = len(self.contacts), self.symbols.tangential_force(contact)
        acceleration = self._slip_acceleration(self.contacts[contact])
        found = (rate - acceleration.subs(own, 0)) / sympy.diff(acceleration, own)
        if found.free_symbols & set(map(self.symbols.tangential_force, range(count))):
            raise UsageError(
                f"the law {self.laws[contact].name!r} asks what would hold contact {contact + 1} "
                "alone, and another contact acts on it\n"
                "next: a friction law that does not ask: coulomb or stribeck, say; near karnopp "
                "and switch is linear-regularisation"
            )
        return found

    def _law_force(self, contact: int) -> Expr:
        slip = self._slip(contact)
        return eased(self.laws[contact].force(slip, self._law_parameters(contact)), slip.v)

    def _law_rates(self, contact: int) -> Mapping[str, Expr]:
        rates, slip = self.laws[contact].rates, self._slip(contact)
        given = {} if rates is None else rates(slip, self._law_parameters(contact))
        return {name: eased(rate, slip.v) for name, rate in given.items()}

    def _rows_of(self, contact: int) -> list[list[sympy.Symbol]]:
        return self.symbols.rows(contact, *self.laws[contact].shape)

    def _rows(self, contact: int) -> list[sympy.Symbol]:
        """Those of a contact in the parameter vector: a row of each element, all of one width."""
        elements, _ = self.laws[contact].shape
        return [s for row in self.symbols.rows(contact, elements, self.width) for s in row]

    def _law_guards(self, contact: int) -> Sequence[Sequence[Expr]]:
        """Those of each element."""
        guards = self.laws[contact].guards
        given = self._slip(contact), self._law_parameters(contact)
        return () if guards is None else guards(*given)

    def _is_smooth(self, contact: int) -> bool:
        if self.contacts[contact].sliding_only:
            return True
        told = (self.law_forces[contact], *self._law_rates(contact).values())
        told += tuple(chain.from_iterable(self._law_guards(contact)))
        borders = any(self.symbols.sign(contact) in part.free_symbols for part in told)
        return self.laws[contact].capacity is None and not borders

    # --- one contact state ------------------------------------------------------------------------
    def _contact_state(self, kinds: tuple[int, ...]) -> ContactState:
        names, stuck = self._leaves(kinds), self._joints(kinds)
        pivots = self._constrain(kinds, stuck, names)
        forces = self._forces(kinds, stuck, names)
        names.update(forces.nodes)
        values = [names[self._entry(name)] for name in self.state_names]
        rates, angle = self._rates(kinds, names), self._angle(kinds, names)
        guards = self._guards(kinds, stuck, names, forces.determinant, pivots)
        n, switching = len(values), [guard.node for guard in guards]
        with self.graph.merging(SHORT):
            energies = self._energies(names)
        merged = self.graph.merged([*values, *rates, *switching, *([angle] if angle else [])])
        return ContactState(
            kinds=kinds,
            values=tuple(merged[:n]),
            rates=tuple(merged[n : 2 * n]),
            guards=tuple(
                replace(guard, node=node)
                for guard, node in zip(guards, merged[2 * n :], strict=False)
            ),
            angle=merged[-1] if angle else None,
            contacts=tuple(self._contact_outputs(i, names) for i in range(len(kinds))),
            stored=tuple(self._stored(names)),
            energies=tuple(energies),
            impacts=self._impacts(kinds, names),
        )

    def _entry(self, name: str) -> Expr:
        return self.symbols.coordinate(name)

    def _leaves(self, kinds: tuple[int, ...]) -> dict[Expr, Node]:
        symbols, graph = self.symbols, self.graph
        names: dict[Expr, Node] = {
            symbols.time: graph.time(),
            symbols.zone: graph.parameter("zone"),
        }
        for position, name in enumerate(self.state_names):
            names[self._entry(name)] = graph.state(position, name)
        for name in self.parameters:
            names[sympy.Symbol(f"p.{name}", real=True)] = graph.parameter(name)
        for i, kind in enumerate(kinds):
            names[symbols.sign(i)] = graph.parameter(f"sign.{i}")
            names[symbols.closed(i)] = graph.number(0.0 if kind == SEPARATION else 1.0)
            names |= {symbol: graph.parameter(symbol.name) for symbol in self._rows(i)}
        return names

    def _joints(self, kinds: tuple[int, ...]) -> list[Joint]:
        """The sticking contacts, those of one direction together."""
        return joints(*self._conditions(kinds))

    def _conditions(self, kinds: tuple[int, ...]) -> tuple[dict[int, Row], dict[int, Row]]:
        """Rows of the slip velocities of contacts that stick, of the gap rates of closed ones."""
        slips = {i: c.slip_velocity for i, c in enumerate(self.contacts) if kinds[i] == STICK}
        gaps = {i: self._time_derivative(self.contacts[i].gap) for i in self._closed(kinds)}
        slip_rows, gap_rows = ({i: self._row(v) for i, v in r.items()} for r in (slips, gaps))
        return slip_rows, gap_rows

    def _row(self, rate: Expr) -> Row:
        """What each velocity adds to a rate."""
        return [sympy.diff(rate, self.symbols.velocity(name)) for name in self.coordinates]

    def _closed(self, kinds: tuple[int, ...]) -> list[int]:
        """The closed rigid contacts."""
        return [
            i
            for i, (contact, kind) in enumerate(zip(self.contacts, kinds, strict=True))
            if kind != SEPARATION and self._is_rigid(contact)
        ]

    def _constrain(
        self, kinds: tuple[int, ...], stuck: Sequence[Joint], names: dict[Expr, Node]
    ) -> Node | None:
        """Replace the entries that a closed rigid gap or a sticking contact determines.

        In stick the slip velocity is zero identically, not up to integration error. Returned is
        the determinant of what the velocities follow from.
        """
        closed = [self.contacts[i] for i in self._closed(kinds)]
        positions = {str(c.gap_coordinate): c.gap for c in closed}
        self._eliminate(positions, names)
        velocities = {f"{c.gap_coordinate}_dot": self._time_derivative(c.gap) for c in closed}
        for contact in (self.contacts[joint.leader] for joint in stuck):
            velocities[f"{contact.slip_coordinate}_dot"] = contact.slip_velocity
        if len(velocities) < len(closed) + len(stuck):
            raise UsageError(
                f"{len(closed) + len(stuck)} conditions of contact are solved for the velocities "
                f"{', '.join(velocities)}\n"
                "next: give each contact a slip_coordinate and gap_coordinate of its own"
            )
        return self._eliminate(velocities, names)

    def _eliminate(self, conditions: Mapping[str, Expr], names: dict[Expr, Node]) -> Node | None:
        """Replace entries by what makes the conditions, affine in them, vanish jointly.

        Returns the determinant.
        """
        entries = [self._entry(name) for name in conditions]
        rows = [self._affine(condition, entries, names) for condition in conditions.values()]
        solution, determinant = _solve(self.graph, rows)
        names.update(zip(entries, solution, strict=True))
        return determinant

    @staticmethod
    def _is_rigid(contact: Contact) -> bool:
        return contact.normal_force is None

    def _time_derivative(self, expression: Expr) -> Expr:
        """Total derivative of a function of coordinates and time."""
        total = sympy.diff(expression, self.symbols.time)
        for name in self.coordinates:
            slope = sympy.diff(expression, self.symbols.coordinate(name))
            total += slope * self.symbols.velocity(name)
        return total

    # --- contact forces ---------------------------------------------------------------------------
    def _forces(
        self, kinds: tuple[int, ...], stuck: Sequence[Joint], names: dict[Expr, Node]
    ) -> _Forces:
        unknowns, conditions = self._unknowns(kinds, stuck)
        known = self._explicit_forces(kinds, names)
        names = {**names, **known}
        for joint in stuck:
            names.update(self._shares(joint, names))
        rows = [self._affine(c, unknowns, names) for c in conditions]
        solution, determinant = _solve(self.graph, rows)
        for symbol, node in zip(unknowns, solution, strict=True):
            known[symbol] = node
        names = {**names, **known}
        for joint in stuck:
            for i in joint.factors:
                force = self._borne(i, joint)
                known[self.symbols.tangential_force(i)] = self.graph.build(force, names)
        for i, kind in enumerate(kinds):
            if kind == SLIP:
                force = self._slip_force(i)
                known[self.symbols.tangential_force(i)] = self.graph.build(force, names)
        return _Forces(known, determinant)

    def _borne(self, contact: int, joint: Joint) -> Expr:
        """The stick force of a contact, of the demand on its joint: all of it where it is alone."""
        demand = self.symbols.tangential_force(joint.leader)
        return demand if len(joint.factors) == 1 else self.symbols.share(contact) * demand

    def _shares(self, joint: Joint, names: Mapping[Expr, Node]) -> dict[Expr, Node]:
        """Of contacts that stick jointly, what each bears of their demand: as it can bear."""
        if len(joint.factors) == 1:
            return {}
        graph = self.graph
        factors = {i: graph.build(factor, names) for i, factor in joint.factors.items()}
        sizes = {i: graph.unary("sqrt", graph.mul(f, f)) for i, f in factors.items()}
        able = {i: self._capacity(i, names) for i in factors}
        every = graph.add(*(graph.mul(size, able[i]) for i, size in sizes.items()))
        return {
            self.symbols.share(i): graph.div(graph.mul(graph.div(f, sizes[i]), able[i]), every)
            for i, f in factors.items()
        }

    def _slip_force(self, contact: int) -> Expr:
        v = self._slip(contact).v
        return self.law_forces[contact].subs(v, self.contacts[contact].slip_velocity)

    def _unknowns(
        self, kinds: tuple[int, ...], stuck: Sequence[Joint]
    ) -> tuple[list[Expr], list[Expr]]:
        """Force symbols to solve for, and the expressions that must vanish."""
        unknowns, conditions = [], []
        leaders = {joint.leader for joint in stuck}
        for i, (contact, kind) in enumerate(zip(self.contacts, kinds, strict=True)):
            if i in leaders:
                unknowns.append(self.symbols.tangential_force(i))
                conditions.append(self._slip_acceleration(contact))
            if kind != SEPARATION and self._is_rigid(contact):
                unknowns.append(self.symbols.normal_force(i))
                conditions.append(self._gap_acceleration(contact))
        slipping = {
            self.symbols.tangential_force(i): self._slip_force(i)
            for i, kind in enumerate(kinds)
            if kind == SLIP
        }
        held = {
            self.symbols.tangential_force(i): self._borne(i, joint)
            for joint in stuck
            for i in joint.factors
        }
        return unknowns, [condition.subs(slipping).xreplace(held) for condition in conditions]

    def _explicit_forces(
        self, kinds: tuple[int, ...], names: Mapping[Expr, Node]
    ) -> dict[Expr, Node]:
        known: dict[Expr, Node] = {}
        for i, (contact, kind) in enumerate(zip(self.contacts, kinds, strict=True)):
            if kind == SEPARATION:
                known[self.symbols.normal_force(i)] = self.graph.zero
                known[self.symbols.tangential_force(i)] = self.graph.zero
            elif contact.normal_force is not None:
                node = self.graph.build(contact.normal_force, names)
                known[self.symbols.normal_force(i)] = node
        return known

    def _slip_acceleration(self, contact: Contact) -> Expr:
        return self._gathered(self._second_derivative(contact.slip_velocity))

    def _gap_acceleration(self, contact: Contact) -> Expr:
        return self._gathered(self._second_derivative(self._time_derivative(contact.gap)))

    def _gathered(self, acceleration: Expr) -> Expr:
        symbols, contacts = self.symbols, range(len(self.contacts))
        forces = [*map(symbols.normal_force, contacts), *map(symbols.tangential_force, contacts)]
        entries = [self._entry(name) for name in self.state_names]
        varied = {
            sympy.Symbol(f"p.{name}", real=True): symbols.parameter(name)
            for name in self.setup.schedule.names
        }
        return gathered(acceleration, entries, forces, varied)

    def _second_derivative(self, velocity: Expr) -> Expr:
        """Total derivative of a function of coordinates, velocities and time."""
        total = self._time_derivative(velocity)
        for name in self.coordinates:
            slope = sympy.diff(velocity, self.symbols.velocity(name))
            if slope != 0:
                total += slope * self.equations.accelerations[name]
        return total

    def _affine(
        self, expression: Expr, unknowns: Sequence[Expr], names: Mapping[Expr, Node]
    ) -> tuple[list[Node], Node]:
        """``(coefficients, rest)`` of an expression affine in `unknowns`."""
        slopes = [sympy.diff(expression, symbol) for symbol in unknowns]
        rest = expression.subs(dict.fromkeys(unknowns, 0))
        build = self.graph.build
        return [build(slope, names) for slope in slopes], build(rest, names)

    # --- rates, guards, outputs -------------------------------------------------------------------
    def _rates(self, kinds: tuple[int, ...], names: Mapping[Expr, Node]) -> list[Node]:
        build = self.graph.build
        rates = [names[self.symbols.velocity(name)] for name in self.coordinates]
        rates += [build(self.equations.accelerations[name], names) for name in self.coordinates]
        for contact, kind in enumerate(kinds):
            apart = [self.graph.zero] * len(
                self.internal[contact]
            )  # what nothing touches stays as it is
            rates += apart if kind == SEPARATION else self._internal_rates(contact, names)
        return rates

    def _internal_rates(self, contact: int, names: Mapping[Expr, Node]) -> list[Node]:
        slip, rates = self._slip(contact), self._law_rates(contact)
        velocity, build = self.contacts[contact].slip_velocity, self.graph.build
        states = self.laws[contact].states
        return [build(rates[state.name].subs(slip.v, velocity), names) for state in states]

    def _guards(
        self,
        kinds: tuple[int, ...],
        stuck: Sequence[Joint],
        names: Mapping[Expr, Node],
        determinant: Node | None,
        pivots: Node | None,
    ) -> tuple[Guard, ...]:
        guards: list[Guard] = []
        for i, kind in enumerate(kinds):
            guards += self._guards_of(i, kind, names)
        for joint in stuck:
            guards += self._partings(joint, names)
        if determinant is not None and not determinant.constant:
            # A friction force opposes the slip acceleration that it is solved from: each
            # sticking contact turns the sign of the determinant.
            orientation = self.graph.number((-1.0) ** len(stuck))
            kind = JAMMING if self._closed(kinds) else SINGULAR
            guards.append(Guard(kind, 0, self.graph.mul(orientation, determinant)))
        if pivots is not None and not pivots.constant:
            guards.append(Guard(SINGULAR, 0, self.graph.mul(pivots, pivots)))
        return tuple(guards)

    def _partings(self, joint: Joint, names: Mapping[Expr, Node]) -> Iterator[Guard]:
        """What is negative unless contacts that stick jointly go on having one speed.

        They begin at rest; what must vanish is the rate at which their drives part.
        """
        leading = self.contacts[joint.leader].slip_velocity
        for i, factor in joint.followers:
            apart = sympy.simplify(self.contacts[i].slip_velocity - factor * leading)
            rate = self.graph.build(self._time_derivative(apart), names)
            if rate is not self.graph.zero:
                yield Guard(PARTING, i, self.graph.negative(self.graph.mul(rate, rate)))

    def _guards_of(self, contact: int, kind: int, names: Mapping[Expr, Node]) -> list[Guard]:
        graph, description = self.graph, self.contacts[contact]
        if kind == SEPARATION:
            return [Guard(GAP, contact, graph.build(description.gap, names))]
        guards = []
        normal = names[self.symbols.normal_force(contact)]
        if kind == STICK:
            demand = names[self.symbols.tangential_force(contact)]
            capacity = self._capacity(contact, names)
            guards.append(Guard(CAPACITY_UP, contact, graph.subtract(capacity, demand)))
            guards.append(Guard(CAPACITY_DOWN, contact, graph.add(capacity, demand)))
        elif not self._is_smooth(contact):
            sign = names[self.symbols.sign(contact)]
            velocity = graph.build(description.slip_velocity, names)
            guards.append(Guard(VELOCITY, contact, graph.mul(sign, velocity)))
        if kind == SLIP:
            v = self._slip(contact).v
            first = sum(self.laws[i].elements for i in self.pieced if i < contact)
            for element, of_element in enumerate(self._law_guards(contact), first):
                for way, guard in enumerate(of_element):
                    node = graph.build(guard.subs(v, description.slip_velocity), names)
                    guards.append(Guard(PIECE, contact, node, element * self.ways + way))
        if description.gap is not None or description.ends_at_zero_normal_force:
            guards.append(Guard(NORMAL, contact, normal))
        return guards

    def _capacity(self, contact: int, names: Mapping[Expr, Node]) -> Node:
        law, parameters = self.laws[contact], self._law_parameters(contact)
        assert law.capacity is not None
        normal = self.symbols.normal_force(contact)
        if not self.contacts[contact].static_friction:
            first = [piece.row for piece in law.pieces[:1]]
            at_rest = Slip(sympy.Integer(0), sympy.Integer(1), sympy.Integer(0), normal, rows=first)
            return self.graph.build(eased(law.force(at_rest, parameters), at_rest.v), names)
        known = {**parameters, **self._slip(contact).states}
        return self.graph.build(law.capacity(normal, known), names)

    def _angle(self, kinds: tuple[int, ...], names: Mapping[Expr, Node]) -> Node | None:
        zone = self.equations.zone
        if zone is None or kinds[zone.contact] == STICK:
            return None
        return self.graph.build(zone.angle, names)

    def _contact_outputs(self, contact: int, names: Mapping[Expr, Node]) -> tuple[Node, Node, Node]:
        return (
            names[self.symbols.normal_force(contact)],
            names[self.symbols.tangential_force(contact)],
            self.graph.build(self.contacts[contact].slip_velocity, names),
        )

    def _stored(self, names: Mapping[Expr, Node]) -> Iterator[Node]:
        if self.setup.law.stored is not None:
            for contact, law in enumerate(self.laws):
                stored = law.stored or (lambda slip, p: sympy.S.Zero)
                energy = stored(self._slip(contact), self._law_parameters(contact))
                yield self.graph.build(energy, names)

    def _energies(self, names: Mapping[Expr, Node]) -> list[Node]:
        build, graph = self.graph.build, self.graph
        kinetic, potential = self.equations.kinetic_energy, self.equations.potential_energy
        power = self._second_derivative(kinetic + potential)
        forces = [self.symbols.tangential_force(i) for i in range(len(self.contacts))]
        other = build(power.subs(dict.fromkeys(forces, 0)), names)
        friction, drive = graph.zero, graph.zero
        for force, contact in zip(forces, self.contacts, strict=True):
            on_system = sympy.diff(power, force)
            friction = graph.add(friction, graph.mul(names[force], build(on_system, names)))
            velocity = build(on_system + contact.slip_velocity, names)
            drive = graph.add(drive, graph.mul(names[force], velocity))
        excited = [build(self.equations.powers.get(of, sympy.S.Zero), names) for of in self.powers]
        return [build(kinetic, names), build(potential, names), other, friction, drive, *excited]

    # --- impacts ----------------------------------------------------------------------------------
    def _impacts(
        self, kinds: tuple[int, ...], names: Mapping[Expr, Node]
    ) -> dict[int, dict[int, Node]]:
        return {
            i: self._impact(i, names)
            for i, (contact, kind) in enumerate(zip(self.contacts, kinds, strict=True))
            if kind == SEPARATION and contact.impact == "plastic"
        }

    def _impact(self, contact: int, names: Mapping[Expr, Node]) -> dict[int, Node]:
        """Velocities after the impulse that closes the gap plastically."""
        graph, description = self.graph, self.contacts[contact]
        force = self.symbols.normal_force(contact)
        rate = self._time_derivative(description.gap)
        responses = {
            name: sympy.diff(self.equations.accelerations[name], force) for name in self.coordinates
        }
        effect = sum(
            sympy.diff(rate, self.symbols.velocity(name)) * response
            for name, response in responses.items()
        )
        closing = rate if description.closing_rate is None else description.closing_rate
        closing *= 1 + description.restitution
        impulse = graph.negative(graph.div(graph.build(closing, names), graph.build(effect, names)))
        after = {}
        for name, response in responses.items():
            if response != 0:
                velocity = names[self.symbols.velocity(name)]
                jump = graph.mul(impulse, graph.build(response, names))
                position = self.state_names.index(f"{name}_dot")
                after[position] = graph.add(velocity, jump)
        return after


@dataclass(frozen=True)
class _Forces:
    nodes: dict[Expr, Node]
    determinant: Node | None


def _solve(graph: Graph, rows: Sequence[tuple[list[Node], Node]]) -> tuple[list[Node], Node | None]:
    """Solve ``coefficients . u + rest = 0`` by elimination; also its determinant."""
    matrix = [list(coefficients) for coefficients, _ in rows]
    right = [graph.negative(rest) for _, rest in rows]
    size = len(rows)
    determinant: Node | None = None
    for column in range(size):
        pivot = matrix[column][column]
        determinant = pivot if determinant is None else graph.mul(determinant, pivot)
        for row in range(column + 1, size):
            factor = graph.div(matrix[row][column], pivot)
            for k in range(column + 1, size):
                eliminated = graph.mul(factor, matrix[column][k])
                matrix[row][k] = graph.subtract(matrix[row][k], eliminated)
            right[row] = graph.subtract(right[row], graph.mul(factor, right[column]))
    solution: list[Node] = [graph.zero] * size
    for row in reversed(range(size)):
        total = right[row]
        for k in range(row + 1, size):
            total = graph.subtract(total, graph.mul(matrix[row][k], solution[k]))
        solution[row] = graph.div(total, matrix[row][row])
    return solution, determinant
