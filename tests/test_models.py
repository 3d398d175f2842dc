"""Every model: its tables, its equations, and the code that follows from them."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
import pytest
import sympy
from motions import defaults, motion, system

from fiv_cli.errors import UsageError
from fiv_cli.friction import get_law, laws_of
from fiv_cli.models import all_models, get_model
from fiv_cli.models.base import Contact, Equations, Model
from fiv_cli.models.symbols import Symbols

# One row for each model: a start, parameters that excite it, and how long it is followed, s.
ROWS: dict[str, tuple[dict[str, float], dict[str, float], float]] = {
    "belt-1dof": ({"x": 0.5}, {"u0": 0.5, "omega": 0.85, "c": 0.1}, 30.0),
    "belt-2mass": ({"x1": 0.5, "x2": -0.5}, {}, 30.0),
    "flutter-2dof": ({"y": -0.3}, {"F": 2.0, "mu_k": 0.5}, 10.0),
    "excited-2dof": ({"y": -3.0}, {"A_b": 2.0, "R": 5.0}, 10.0),
    "belt-5dof": ({"y1": -0.02}, {"mu_k": 1.4, "v": 0.5}, 1.0),
    "disc-rigid-contact": ({"phi": 1e-3}, {"N0": 300.0}, 0.02),
    "excited-disc": ({"u": -2e-3}, {"A": 2e4, "xi": 2e-4}, 0.02),
    "disc-nonlinear-contact": ({"u": -2e-2}, {"mu_k": 0.5}, 0.02),
    "pin-on-disc": ({"phi_dot": 2.0}, {"beta": 1.0, "psi_a": 0.5}, 0.5),
}
# Two modes of a disc: the equations of one more are those of another one.
FEW = {"modes": "0,0 0,2"}
MODELS = tuple(all_models().values())
MOVING = tuple(model for model in MODELS if model.contacts)
by_model = pytest.mark.parametrize("model", MODELS, ids=lambda model: model.name)
by_moving_model = pytest.mark.parametrize("model", MOVING, ids=lambda model: model.name)


# What dissipates: zero in the balance of energy.
DAMPING = ("c", "c1", "c2", "c4", "c5", "c6", "D", "xi", "c_z", "C_phi")
# Options under which the contact forces derive from a potential.
CONSERVATIVE = {"slope_force": "include"}


def equations_of(model: Model, **options: str) -> tuple[Symbols, Equations]:
    """The symbols and equations of a model under its default options, or others."""
    symbols = Symbols()
    return symbols, model.equations(symbols, options_of(model, **options))


def options_of(model: Model, **options: str) -> dict[str, str]:
    """The default options of a model with few modes, and those of `options` that it has."""
    known = model.default_options()
    return known | {name: value for name, value in (FEW | options).items() if name in known}


def test_every_model_has_a_row() -> None:
    assert set(ROWS) == {model.name for model in MOVING}
    assert [model.name for model in MODELS if model not in MOVING] == ["annular-plate"]


def test_the_registry_hands_out_copies_and_names_are_those_of_the_models() -> None:
    models = all_models()
    assert all(name == model.name for name, model in models.items())
    models.clear()
    assert all_models()
    with pytest.raises(KeyError):
        get_model("no-such-model")


@by_model
def test_parameter_tables_are_complete(model: Model) -> None:
    names = [p.name for p in model.parameters]
    assert len(names) == len(set(names))
    for p in model.parameters:
        assert p.symbol and p.unit and p.meaning
        assert p.equation or "thesis" not in model.reference
        assert p.default is not None or p.default_from in names
        assert p.minimum < p.maximum
        if p.default is not None:
            above = p.default > p.minimum if p.exclusive else p.default >= p.minimum
            assert above and p.default <= p.maximum


@by_model
def test_states_options_and_laws_are_complete(model: Model) -> None:
    assert model.title and model.reference and model.numerics_version >= 1
    for state in model.states(model.default_options()):
        assert state.name and state.symbol and state.unit and state.meaning
    for option in model.options:
        assert option.text(option.default) == option.default and option.meaning
        assert option.allowed and (option.read is None) == bool(option.choices)
    assert laws_of(model)[0] == model.default_law
    known = {p.name for law in laws_of(model) for p in get_law(law).parameters}
    assert set(model.law_defaults) <= known
    own = {p.name for p in model.parameters}
    assert not own & known
    assert {forcing.amplitude for forcing in model.forcings} <= own


@by_moving_model
def test_equations_use_what_the_tables_declare(model: Model) -> None:
    symbols, equations = equations_of(model)
    coordinates = [state.name for state in model.states(options_of(model))]
    assert set(equations.accelerations) == set(coordinates)
    assert len(equations.contacts) == model.contacts
    allowed = {symbols.time, symbols.zone}
    allowed |= {symbols.parameter(p.name) for p in model.parameters}
    allowed |= {f(name) for name in coordinates for f in (symbols.coordinate, symbols.velocity)}
    if model.derived is not None:
        allowed |= {symbols.parameter(name) for name in model.derived.names(options_of(model))}
        assert set(model.derived.sources) <= {p.name for p in model.parameters}
    for i in range(model.contacts):
        allowed |= {symbols.tangential_force(i), symbols.normal_force(i), symbols.closed(i)}
    used = set().union(*(sympy.sympify(e).free_symbols for e in equations.accelerations.values()))
    used |= equations.kinetic_energy.free_symbols | equations.potential_energy.free_symbols
    assert used <= allowed
    declared = {symbols.parameter(p.name) for p in model.parameters}
    everywhere = used | set().union(
        *(sympy.sympify(c.slip_velocity).free_symbols for c in equations.contacts),
        *(sympy.sympify(c.normal_force or 0).free_symbols for c in equations.contacts),
        *(sympy.sympify(e).free_symbols for e in equations.law_parameters.values()),
        {symbols.parameter(equations.zone.start), symbols.parameter(equations.zone.width)}
        if equations.zone
        else set(),
    )
    elsewhere = {"p.l1", "p.l3"} if model.name == "pin-on-disc" else set()
    if model.derived is not None:
        elsewhere = {str(symbols.parameter(name)) for name in model.derived.sources}
    in_expanded_equations = {p for p in declared if str(p) not in elsewhere}
    assert in_expanded_equations <= everywhere


@by_moving_model
def test_accelerations_follow_from_the_energies(model: Model) -> None:
    """Without damping and friction the Jacobi integral of the unexcited system is constant.

    It is T + U where nothing spins. A force that keeps a gap closed has power on its rate, zero.
    """
    symbols, equations = equations_of(model, **CONSERVATIVE)
    total = equations.potential_energy - equations.kinetic_energy
    for name in equations.accelerations:
        momentum = sympy.diff(equations.kinetic_energy, symbols.velocity(name))
        total += momentum * symbols.velocity(name)
    power: Any = sympy.diff(total, symbols.time)
    for i, contact in enumerate(equations.contacts):
        if contact.normal_force is None:
            power -= symbols.normal_force(i) * rate(symbols, equations, contact.gap)
    for name, acceleration in equations.accelerations.items():
        power += sympy.diff(total, symbols.coordinate(name)) * symbols.velocity(name)
        power += sympy.diff(total, symbols.velocity(name)) * acceleration
    off = {symbols.tangential_force(i): 0 for i in range(model.contacts)}
    off |= {symbols.parameter(p.name): 0 for p in model.parameters if p.name in DAMPING}
    elastic = {i: c for i, c in enumerate(equations.contacts) if c.normal_force is not None}
    off |= {symbols.normal_force(i): c.normal_force for i, c in elastic.items()}
    off |= {symbols.closed(i): 1 for i in range(model.contacts)}
    off |= {symbols.parameter(forcing.amplitude): 0 for forcing in model.forcings}
    assert sympy.simplify(power.subs(off)) == 0


def rate(symbols: Symbols, equations: Equations, expression: Any) -> Any:
    """Time derivative of a function of the coordinates."""
    names = equations.accelerations
    return sum(sympy.diff(expression, symbols.coordinate(n)) * symbols.velocity(n) for n in names)


@by_moving_model
def test_friction_acts_along_the_slip_velocity(model: Model) -> None:
    """F_T pushes the model with the drive: its generalised force is minus d(v_rel)/d(velocity).

    On a disc it also has a moment of arm h/2 about the middle plane, where v_rel is taken.
    """
    symbols, equations = equations_of(model)
    middle_plane = {symbols.parameter("h"): 0}
    for i, contact in enumerate(equations.contacts):
        force = symbols.tangential_force(i)
        power = sum(
            sympy.diff(equations.kinetic_energy, symbols.velocity(name)) * sympy.diff(a, force)
            for name, a in equations.accelerations.items()
        )
        slip_of_model = sum(
            sympy.diff(contact.slip_velocity, symbols.velocity(name)) * symbols.velocity(name)
            for name in equations.accelerations
        )
        assert sympy.simplify((power + slip_of_model).subs(middle_plane)) == 0


@by_moving_model
def test_the_load_is_constant_where_the_table_says_so(model: Model) -> None:
    symbols, equations = equations_of(model)
    parameters = {symbols.parameter(p.name) for p in model.parameters}
    loads = [contact.normal_force for contact in equations.contacts]
    constant = all(n is not None and n.free_symbols <= parameters for n in loads)
    assert constant == model.constant_load


EVERY_LAW = [pytest.param(laws_of, id="every law", marks=pytest.mark.campaign)]
FEW_LAWS = [pytest.param(lambda model: laws_of(model)[:2], id="two laws")]


@by_moving_model
@pytest.mark.parametrize("laws", FEW_LAWS + EVERY_LAW)
def test_every_law_of_a_model_moves_it(
    model: Model, laws: Callable[[Model], Sequence[str]]
) -> None:
    start, changes, t_end = ROWS[model.name]
    for law in sorted({*laws(model)} - {"rate-and-state"}):  # whose slip may not turn round
        begun = motion(model.name, law, start, options=options_of(model), **changes)
        begun.run(t_end)
        assert begun.time == t_end, law
        assert np.all(np.isfinite(begun.y)), law


@by_moving_model
def test_the_unexcited_system_has_no_period_of_excitation(model: Model) -> None:
    _, changes, _ = ROWS[model.name]
    built = system(model.name, model.default_law, options_of(model))
    known = built.known(defaults(model.name, model.default_law, **changes))
    assert (model.excitation_period(known) is not None) == bool(model.forcings)
    assert model.excitation_period(model.unexcited(known)) is None


@by_moving_model
def test_state_vectors_go_by_name(model: Model) -> None:
    built = system(model.name, model.default_law, options_of(model))
    names = [state.name for state in model.states(options_of(model))]
    assert built.state_names == (*names, *(f"{name}_dot" for name in names))
    assert built.coordinates == tuple(names)
    vector = built.state_vector({f"{names[-1]}_dot": 3.0})
    assert vector[-1] == 3.0 and np.count_nonzero(vector) == 1


def test_a_rigid_contact_names_what_its_closed_gap_determines() -> None:
    """Else nothing would keep the gap closed, and what was generated so would be kept."""
    gap = Symbols().coordinate("z")
    with pytest.raises(UsageError, match="gap_coordinate\nnext: name the state"):
        Contact(gap, "x", None, gap=gap)
    assert Contact(gap, "x", None, gap=gap, gap_coordinate="z").gap_coordinate == "z"
