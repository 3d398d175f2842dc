"""The equations of a model as they are written, and what their symbols are measured in."""

from __future__ import annotations

import random
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass

import sympy
from sympy import Expr

from fiv_cli.friction import get_law
from fiv_cli.models.base import Equations, Model
from fiv_cli.models.symbols import Symbols
from fiv_cli.own.dimensions import Dimension, dimension
from fiv_cli.own.fault import Fault, Place


@dataclass(frozen=True)
class Written:
    """The equations of a model under some options, and what its symbols are measured in."""

    model: Model
    states: Mapping[str, str]
    symbols: Symbols
    equations: Equations
    units: Mapping[Expr, Dimension | None]

    @classmethod
    def of(cls, model: Model, options: Mapping[str, str]) -> Written:
        symbols = Symbols()
        units: dict[Expr, Dimension | None] = {
            symbols.time: dimension("s"),
            symbols.zone: dimension("1"),
        }
        tables = model.parameters_under(get_law(model.default_law))
        units |= {symbols.parameter(p.name): dimension(p.unit) for p in tables}
        states = {state.name: state.unit for state in model.states(options)}
        for name, unit in states.items():
            units[symbols.coordinate(name)] = dimension(unit)
            units[symbols.velocity(name)] = per_second(dimension(unit))
        for i in range(model.contacts):
            units |= dict.fromkeys(
                (symbols.tangential_force(i), symbols.normal_force(i)), dimension("N")
            )
            units[symbols.closed(i)] = dimension("1")
        if model.derived is not None:
            units |= {symbols.parameter(name): None for name in model.derived.names(options)}
        equations = model.mechanics(symbols, options)
        return cls(model, states, symbols, equations, units)

    @property
    def forces(self) -> list[Expr]:
        """The symbols of the forces of all contacts."""
        each = (self.symbols.tangential_force, self.symbols.normal_force)
        return [force(i) for i in range(self.model.contacts) for force in each]

    def named(self) -> Iterator[tuple[Place, Expr, str]]:
        """(place, expression, unit) of everything."""
        equations = self.equations
        for name, acceleration in equations.accelerations.items():
            unit = f"{self.states.get(name, '1')} s-2".removeprefix("1 ")
            yield ("Equations", 0, "accelerations"), sympy.sympify(acceleration), unit
        yield ("Equations", 0, "kinetic_energy"), sympy.sympify(equations.kinetic_energy), "J"
        yield ("Equations", 0, "potential_energy"), sympy.sympify(equations.potential_energy), "J"
        for i, contact in enumerate(equations.contacts):
            table = {"slip_velocity": "m s-1", "normal_force": "N", "gap": "m"}
            for name, unit in table.items():
                expression = getattr(contact, name)
                if expression is not None:
                    yield ("Contact", i, name), sympy.sympify(expression), unit


def per_second(found: Dimension) -> Dimension:
    """The dimension of a rate."""
    mass, length, time = found
    return mass, length, time - 1


Check = Callable[[Written], Iterator[Fault]]


def each_option(check: Check, model: Model) -> Iterator[Fault]:
    """What a check finds under the first options under which it finds anything."""
    found = (list(check(written)) for written in under_options(model))
    yield from next(filter(None, found), [])


def some_option(check: Check, model: Model) -> Iterator[Fault]:
    """What a check finds under the default options, where it finds something under all."""
    found = [list(check(written)) for written in under_options(model)]
    yield from found[0] if all(found) and found else []


def under_options(model: Model) -> Iterator[Written]:
    """The equations under the default options, and under each other choice of one of them."""
    defaults = model.default_options()
    others = ({o.name: c} for o in model.options for c in o.choices if c != o.default)
    for chosen in ({}, *others) if model.contacts else ():
        yield Written.of(model, {**defaults, **chosen})


def values_of(written: Written, fixed: Mapping[Expr, float]) -> dict[Expr, float]:
    """A value for every symbol: parameters near their defaults, states by chance."""
    chance = random.Random(0)
    values = {symbol: chance.uniform(0.3, 0.9) for symbol in sorted(written.units, key=str)}
    for p in written.model.parameters:
        if p.default:
            values[written.symbols.parameter(p.name)] = p.default * chance.uniform(0.8, 1.2)
    return {**values, **fixed}


def number_of(expression: Expr, values: Mapping[Expr, float]) -> float:
    """An expression at these values."""
    return float(expression.subs(values).evalf())
