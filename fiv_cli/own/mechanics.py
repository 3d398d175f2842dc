"""What is wrong with the mechanics of a model: its energies, and what its forces do."""

from __future__ import annotations

import random
from collections.abc import Collection, Iterator
from typing import Any

import sympy
from sympy import Expr

from fiv_cli.codegen.setup import default_parameters
from fiv_cli.friction import get_law
from fiv_cli.models.base import Model, Options
from fiv_cli.models.symbols import Symbols
from fiv_cli.own.fault import Fault, shown
from fiv_cli.own.written import Written, number_of, under_options, values_of

ROUNDING = 1e-9
MOTIONS = 50  # whose damping is looked at


def mechanics(written: Written) -> Iterator[Fault]:
    """Missing inertia, forces that are not affine, friction that drives, loads that vary."""
    yield from _stops(written)
    yield from _inertia(written)
    yield from _affine(written)
    yield from _friction_opposes_slip(written)
    yield from _force_opens_gap(written)
    yield from _constant_load(written)
    yield from _contacts_press(written)


def _stops(written: Written) -> Iterator[Fault]:
    found = sum(contact.is_stop for contact in written.equations.contacts)
    if found != written.model.stops:
        message = f"is {written.model.stops}, and of the contacts {found} are stops"
        hint = f"write stops={found}: their impacts are counted"
        yield Fault(("Model", written.model.name, "stops"), message, "", hint)


def _inertia(written: Written) -> Iterator[Fault]:
    kinetic = sympy.sympify(written.equations.kinetic_energy)
    for name in written.equations.accelerations:
        if not sympy.diff(kinetic, written.symbols.velocity(name)):
            message = f"does not hold {name}_dot: the energy of that motion is missing"
            yield Fault(("Equations", 0, "kinetic_energy"), message)


def _constant_load(written: Written) -> Iterator[Fault]:
    known = {written.symbols.parameter(p.name) for p in written.model.parameters}
    for i, contact in enumerate(written.equations.contacts if written.model.constant_load else ()):
        load = contact.normal_force
        if not contact.is_stop and (load is None or sympy.sympify(load).free_symbols - known):
            message = f"the normal force of contact {i + 1} is not constant"
            yield Fault(("Model", written.model.name, "constant_load"), message, "", "leave it out")


def _contacts_press(written: Written) -> Iterator[Fault]:
    """What cannot open is pressed together where nothing has moved; a stop gives back no more."""
    symbols, model = written.symbols, written.model
    known = default_parameters(model, get_law(model.default_law))
    fixed: dict[Expr, float] = {symbols.parameter(name): value for name, value in known.items()}
    for name in written.states:
        fixed |= {symbols.coordinate(name): 0.0, symbols.velocity(name): 0.0}
    at_rest = values_of(written, {symbols.time: 0.0, **fixed})
    for i, contact in enumerate(written.equations.contacts):
        load = sympy.sympify(contact.normal_force if contact.gap is None else 0)
        if number_of(load, at_rest) < 0.0:
            message = f"is {shown(load)}, which pulls where nothing has moved: F_N presses"
            yield Fault(("Contact", i, "normal_force"), message)
        share = number_of(sympy.sympify(contact.restitution), at_rest)
        if not 0.0 <= share <= 1.0:
            message = f"an impact gives back {share:g} of what it takes"
            yield Fault(("stop", i, "restitution"), message, "0 to 1")


def _affine(written: Written) -> Iterator[Fault]:
    for name, acceleration in written.equations.accelerations.items():
        slopes = [sympy.diff(acceleration, force) for force in written.forces]
        if any(slope.free_symbols & {*written.forces} for slope in map(sympy.sympify, slopes)):
            message = f"that of {name!r} is not linear in the forces of contacts"
            yield Fault(("Equations", 0, "accelerations"), message)


def _friction_opposes_slip(written: Written) -> Iterator[Fault]:
    symbols, equations = written.symbols, written.equations
    for i, contact in enumerate(equations.contacts):
        if contact.is_stop:
            continue
        force = symbols.tangential_force(i)
        response: Any = sum(
            sympy.diff(contact.slip_velocity, symbols.velocity(name)) * sympy.diff(a, force)
            for name, a in equations.accelerations.items()
        )
        effect = number_of(sympy.sympify(response), values_of(written, {}))
        if effect > 0.0:
            message = f"F_T of contact {i + 1} drives its slip: it acts along v_rel on the model"
            hint = "v_rel is the velocity of the drive less that of the body"
            yield Fault(("Contact", i, "slip_velocity"), message, "", hint)
        elif effect == 0.0:
            message = f"F_T of contact {i + 1} changes no velocity that its slip velocity holds"
            hint = f"add symbols.tangential_force({i}) to the force on the body that slips there"
            yield Fault(("Equations", 0, "accelerations"), message, "", hint)


def _force_opens_gap(written: Written) -> Iterator[Fault]:
    """That of a contact that holds its gap closed; a force given as a function acts as it is."""
    symbols, equations = written.symbols, written.equations
    for i, contact in enumerate(equations.contacts):
        if contact.gap is None or contact.normal_force is not None:
            continue
        force = symbols.normal_force(i)
        response: Any = sum(
            sympy.diff(contact.gap, symbols.coordinate(name)) * sympy.diff(a, force)
            for name, a in equations.accelerations.items()
        )
        effect = number_of(sympy.sympify(response), values_of(written, {}))
        if effect <= 0.0:
            way = "closes" if effect else "does not act on"
            message = f"F_N of contact {i + 1} {way} its gap, which it is to open"
            hint = f"add or subtract symbols.normal_force({i}) where it pushes the model away"
            yield Fault(("Equations", 0, "accelerations"), message, "", hint)


def energies(written: Written) -> Iterator[Fault]:
    """Without damping, excitation and friction the Jacobi integral is constant.

    A model may leave a force out by choice; under some option it must be so.
    """
    terms = [term.subs(_switched_off(written)) for term in _power(written)]
    values = values_of(written, {})
    numbers = [number_of(term, values) for term in terms]
    if abs(sum(numbers)) <= ROUNDING * sum(map(abs, numbers)):
        return
    message = "do not fit the accelerations"
    left = sympy.expand(sum(terms))
    if left.count_ops() < 60:
        message += f": without damping, excitation and friction they change by {shown(left)}"
    hint = 'a parameter that takes energy out or in says role="damping", an excitation is a Forcing'
    yield Fault(("Equations", 0, "potential_energy"), f"energies {message}", "", hint)


def fed_by_damping(model: Model) -> str:
    """That damping gives energy to some motion, as with a wrong sign, in one line; empty if none.

    It may be meant so: a negative damping is.
    """
    kept = {p.name for p in model.parameters if p.role == "damping"}
    if not kept or not all(_is_fed(written, kept) for written in under_options(model)):
        return ""
    return f"{model.name}: its damping gives energy to some motions; is a sign wrong?"


def pulling(model: Model, options: Options) -> list[str]:
    """Which contacts hold together what would part: their normal force may be negative."""
    symbols = Symbols()
    equations = model.mechanics(symbols, options)
    states = [of(name) for name in equations.accelerations
              for of in (symbols.coordinate, symbols.velocity)]  # fmt: skip
    return [
        f"contact {number} cannot part: where its normal force falls below zero it pulls, and "
        "friction drives; in its Contact ends_at_zero_normal_force = True ends a motion there, "
        "gap = ... lets it lift off"
        for number, one in enumerate(equations.contacts, 1)
        if one.gap is None and one.normal_force is not None and not one.ends_at_zero_normal_force
        and sympy.sympify(one.normal_force).has(*states)
        and not sympy.sympify(one.normal_force).has(sympy.Max, sympy.Abs)
    ]  # fmt: skip


def _is_fed(written: Written, kept: Collection[str]) -> bool:
    symbols = written.symbols
    damping = {symbols.parameter(name) for name in kept}
    off = {
        symbol: value for symbol, value in _switched_off(written).items() if symbol not in damping
    }
    gained = sum(_power(written), sympy.Integer(0)).subs(off)
    moving = [symbols.velocity(name) for name in written.states]
    values = values_of(written, {})
    rest = {symbol: value for symbol, value in values.items() if symbol not in moving}
    power = sympy.lambdify([moving], gained.subs(rest))
    chance = random.Random(0)
    motions = ([chance.uniform(-1.0, 1.0) for _ in moving] for _ in range(MOTIONS))
    return any(power(speeds) > ROUNDING for speeds in motions)


def _power(written: Written) -> list[Expr]:
    """The terms of the rate of the Jacobi integral, T + U where nothing turns."""
    symbols, equations = written.symbols, written.equations
    total = sympy.sympify(equations.potential_energy - equations.kinetic_energy)
    for name in equations.accelerations:
        momentum = sympy.diff(equations.kinetic_energy, symbols.velocity(name))
        total += momentum * symbols.velocity(name)
    terms = [sympy.diff(total, symbols.time)]
    for name, acceleration in equations.accelerations.items():
        terms.append(sympy.diff(total, symbols.coordinate(name)) * symbols.velocity(name))
        terms.append(sympy.diff(total, symbols.velocity(name)) * acceleration)
    for i, contact in enumerate(equations.contacts):
        if contact.normal_force is None:  # it keeps the gap closed: no power, on its rate
            rate = sum(
                sympy.diff(contact.gap, symbols.coordinate(n)) * symbols.velocity(n)
                for n in equations.accelerations
            )
            terms.append(-symbols.normal_force(i) * rate)
    return [sympy.sympify(term) for term in terms]


def _switched_off(written: Written) -> dict[Expr, Any]:
    """Friction, damping and excitation at zero, elastic contacts closed."""
    symbols, model = written.symbols, written.model
    off: dict[Expr, Any] = {symbols.tangential_force(i): 0 for i in range(model.contacts)}
    off |= {symbols.parameter(p.name): 0 for p in model.parameters if p.role == "damping"}
    off |= {symbols.parameter(forcing.amplitude): 0 for forcing in model.forcings}
    off |= {symbols.closed(i): 1 for i in range(model.contacts)}
    for i, contact in enumerate(written.equations.contacts):
        if contact.normal_force is not None:
            off[symbols.normal_force(i)] = contact.normal_force
    return off
