"""Every friction law: its table, its formula, and that it is odd and continuous where it should."""

from __future__ import annotations

from dataclasses import replace
from math import asinh, exp, inf, isfinite, log, nan, sqrt, tanh
from typing import Any

import numpy as np
import pytest
import sympy
from motions import defaults

from fiv_cli import api
from fiv_cli.analyses.rest.equilibria import equilibria, sliding
from fiv_cli.codegen.setup import Setup
from fiv_cli.dynamics.system import build_system
from fiv_cli.errors import CaseError
from fiv_cli.friction import TANH_OF, all_laws, get_law, why_unfit
from fiv_cli.friction.base import Law, Slip
from fiv_cli.models import all_models, get_model
from fiv_cli.models.base import Parameter

# Values of every parameter, then |F_T| at a slip speed of 0.7 m/s and the static capacity, for
# F_N = 5 N, by hand.
ROWS: dict[str, tuple[dict[str, float], float, float | None]] = {
    "coulomb": ({"mu_s": 0.4, "mu_k": 0.23}, 0.23 * 5, 0.4 * 5),
    "stribeck": (
        {"mu_s": 0.4, "mu_k": 0.1, "v_s": 0.5, "delta": 2},
        (0.1 + 0.3 * exp(-1.96)) * 5,
        0.4 * 5,
    ),
    "exponential": (
        {"mu_s": 0.8, "mu_k": 0.35, "mu_0": 0.6, "alpha": 2.0},
        (0.35 + 0.25 * exp(-1.4)) * 5,
        0.8 * 5,
    ),
    "linear-slope": ({"F0": 10.0, "alpha_0": -0.1}, 10.0 - 0.07, 10.0),
    "hyperbolic": ({"mu_0": 0.4, "delta": 3.0}, 0.4 / 3.1 * 5, 0.4 * 5),
    "viscous": ({"mu_s": 0.4, "mu_k": 0.23, "F_V": 0.2}, 0.23 * 5 + 0.14, 0.4 * 5),
    "stribeck-viscous": (
        {"mu_s": 0.4, "mu_k": 0.1, "v_s": 0.5, "delta": 2, "F_V": 0.2},
        (0.1 + 0.3 * exp(-1.96)) * 5 + 0.14,
        0.4 * 5,
    ),
    "four-parameter": (
        {"mu_0": 0.4, "d": 0.3, "g": 2.0, "e": 0.1},
        0.4 * (0.7 / 2.4 + 0.3 + 0.049) * 5,
        0.4 * 5,
    ),
    "cubic": ({"mu_s": 0.4, "mu_m": 0.25, "v_m": 0.7}, 0.25 * 5, 0.4 * 5),
    "rational": (
        {"mu_s": 0.4, "mu_k": 0.1, "v_s": 0.5, "delta": 2},
        (0.1 + 0.3 / 2.96) * 5,
        0.4 * 5,
    ),
    "simscape": (
        {"mu_s": 0.4, "mu_k": 0.1, "v_brk": 1.0, "F_V": 0.2},
        (sqrt(exp(1)) * 0.3 * exp(-0.245) * 0.7 + 0.1 * tanh(7.0)) * 5 + 0.14,
        None,
    ),
    "stefanski": (
        {"mu_s": 0.4, "mu_k": 0.23, "v_s": 0.5, "a_0": 0.1, "tau": 0.01},
        0.23 * 5,
        0.4 * 5,
    ),
    "hysteretic": (
        {"mu_s": 0.4, "mu_k": 0.23, "v_s": 0.5, "a_0": 0.1, "tau": 0.01, "Delta_mu_s": 0.1},
        (0.23 + 0.05 / 2.4 * exp(-1.4)) * 5,
        0.5 * 5,
    ),
    "hysteretic-rough": (
        {
            "mu_s": 0.4,
            "mu_k": 0.23,
            "v_s": 0.5,
            "a_0": 0.1,
            "tau": 0.01,
            "Delta_mu_s": 0.1,
            "roughness": 0.2,
            "correlation_length": 0.1,
            "seed": 3.0,
        },
        (0.23 + 0.05 / 2.4 * (exp(-1.4) + 0.2)) * 5,
        (0.23 + 0.27 * 1.2) * 5,
    ),
    "switch": ({"mu_s": 0.4, "mu_k": 0.23, "eta": 1e-4, "alpha": 10.0}, 0.23 * 5, None),
    "karnopp": ({"mu_s": 0.4, "mu_k": 0.23, "eta": 1e-4}, 0.23 * 5, None),
    "rate-and-state": (
        {"mu_0": 0.4, "a_rate": 0.02, "b_state": 0.03, "D_c": 1e-3, "v_0": 0.1},
        0.02 * asinh(3.5 * exp((0.4 + 0.03 * log(1 / 7)) / 0.02)) * 5,
        None,
    ),
    "rate-and-state-cutoff": (
        {"mu_0": 0.4, "a_rate": 0.02, "b_state": 0.03, "D_c": 1e-3, "v_0": 0.1, "v_c": 1e-4},
        (0.4 + 0.02 * log(7.001) + 0.03 * log(1 / 7)) * 5,
        (0.4 + 0.02 * log(1e-3)) * 5,
    ),
    "linear-regularisation": ({"mu_k": 0.23, "v_tol": 1.4}, 0.5 * 0.23 * 5, None),
    "jenkins": ({"mu_k": 0.23, "sigma_0": 100.0}, 0.23 * 5, None),
    "reset-integrator": (
        {"mu_k": 0.23, "sigma_0": 100.0, "a_stick": 0.4, "sigma_1": 3.0},
        0.23 * 5,
        None,
    ),
    "gms": (
        {
            "mu_s": 0.4,
            "mu_k": 0.1,
            "v_s": 0.5,
            **{f"alpha_{i}": i / 10 for i in range(1, 5)},
            **dict.fromkeys(("k_1", "k_2", "k_3", "k_4"), 250.0),
            "C_lag": 10.0,
            "sigma_2": 0.2,
        },
        (0.1 + 0.3 * exp(-1.96) + 0.14) * 5,
        None,
    ),
    "bristle": ({"mu_k": 0.23, "delta_b": 1e-3, "spread": 0.3}, 0.23 * 5, None),
    "elasto-plastic": (
        {
            "mu_s": 0.4,
            "mu_k": 0.1,
            "v_s": 0.5,
            "sigma_0": 100.0,
            "sigma_1": 3.0,
            "sigma_2": 0.2,
            "x_ba": 0.5,
            "blend": 0.8,
        },
        (0.1 + 0.3 * exp(-1.96) + 0.14) * 5,
        None,
    ),
    "dahl": ({"mu_k": 0.23, "sigma_0": 100.0}, 0.23 * 5, None),
    "lugre": (
        {
            "mu_s": 0.4,
            "mu_k": 0.1,
            "v_s": 0.5,
            "delta": 2,
            "sigma_0": 100.0,
            "sigma_1": 3.0,
            "sigma_2": 0.2,
        },
        (0.1 + 0.3 * exp(-1.96) + 0.14) * 5,
        None,
    ),
}
LAWS = tuple(all_laws().values())
PLAIN = tuple(law for law in LAWS if not law.name.startswith(TANH_OF))
STICKING = tuple(law for law in PLAIN if law.kind == "set-valued")
SIGMA, SPEED, NORMAL = 2.0, 0.7, 5.0
by_law = pytest.mark.parametrize("law", LAWS, ids=lambda law: law.name)


def force(law: Law, v: float, parameters: dict[str, Any]) -> float:
    """F_T at a signed slip velocity."""
    sign = 1 if v >= 0.0 else -1
    slip = Slip(v, sign, sign * v, NORMAL, rows=law.rows_at(v, parameters))
    return float(law.sliding(slip, parameters))


def row_of(law: Law) -> tuple[dict[str, float], float, float | None]:
    """The row of a law; a regularised one by that of the law it regularises."""
    if not law.name.startswith(TANH_OF):
        return ROWS[law.name]
    values, kinetic, _ = ROWS[law.name.removeprefix(TANH_OF)]
    return values | {"sigma": SIGMA}, tanh(SIGMA * SPEED) * kinetic, None


def test_every_law_has_a_row() -> None:
    assert set(ROWS) == {law.name for law in PLAIN}
    assert {law.name for law in LAWS} == set(ROWS) | {TANH_OF + law.name for law in STICKING}


def test_the_registry_hands_out_copies() -> None:
    laws = all_laws()
    assert all(name == law.name for name, law in laws.items())
    laws.clear()
    assert get_law("coulomb").name == "coulomb"
    with pytest.raises(KeyError):
        get_law("no-such-law")


@by_law
def test_parameter_tables_are_complete(law: Law) -> None:
    assert law.title and law.reference and law.numerics_version >= 1
    names = [p.name for p in law.parameters]
    assert len(names) == len(set(names))
    assert set(names) <= set(row_of(law)[0])
    assert set(law.structural) <= set(names)
    for p in law.parameters:
        assert p.symbol and p.unit and p.meaning
        assert p.default is not None or p.default_from in names
        if p.default is not None:
            above = p.default > p.minimum if p.exclusive else p.default >= p.minimum
            assert above and p.default <= p.maximum


@by_law
def test_forces_are_those_of_the_formula(law: Law) -> None:
    values, kinetic, static = row_of(law)
    assert force(law, SPEED, values) == pytest.approx(kinetic, rel=1e-14)
    if static is None:
        assert law.capacity is None
    else:
        assert law.capacity is not None
        assert float(law.capacity(NORMAL, values)) == pytest.approx(static, rel=1e-14)


@by_law
def test_friction_is_odd_and_drives_with_the_slip(law: Law) -> None:
    values = row_of(law)[0]
    for v in (1e-3, 0.1, 1.0, 3.0):
        assert force(law, -v, values) == -force(law, v, values) < 0.0


@pytest.mark.parametrize("law", STICKING, ids=lambda law: law.name)
def test_regularised_laws_tend_to_the_law(law: Law) -> None:
    smooth = get_law(TANH_OF + law.name)
    values = ROWS[law.name][0]
    assert force(smooth, SPEED, values | {"sigma": 1e3}) == force(law, SPEED, values)
    assert force(smooth, 0.0, values | {"sigma": 1e3}) == 0.0


@pytest.mark.parametrize("name", ["stribeck", "linear-slope", "hyperbolic"])
def test_falling_laws_begin_at_their_capacity(name: str) -> None:
    law, (values, _, static) = get_law(name), ROWS[name]
    assert force(law, 0.0, values) == pytest.approx(static, rel=1e-14)


def outside(p: Parameter) -> list[float]:
    """Values just outside of what a parameter may be."""
    below = p.minimum if p.exclusive else p.minimum - 1e-9
    bounds = [value for value in (below, p.maximum + 1e-9) if isfinite(value)]
    return [*bounds, inf, nan, *([1.5] if p.integer else [])]


@by_law
@pytest.mark.parametrize("as_axis", [False, True])
def test_what_is_out_of_range_is_refused_with_law_and_range(law: Law, as_axis: bool) -> None:
    smooth = law.name.startswith(TANH_OF)
    names = {"law": "tanh", "of": law.name.removeprefix(TANH_OF)} if smooth else {"law": law.name}
    base = {"schema": 1, "model": {"name": "belt-1dof"}, "analysis": [{"kind": "equilibrium"}]}
    for p in law.parameters:
        for value in outside(p):
            given = {"grid": {p.name: [value]}} if as_axis else {}
            friction = names | ({} if as_axis else {p.name: value})
            with pytest.raises(CaseError) as caught:
                api.load(base | given | {"friction": friction})
            (problem,) = caught.value.problems
            assert p.name in problem.path and repr(value) in problem.message
            assert problem.allowed.startswith(p.allowed.removesuffix(")"))
            assert f" of {law.name})" in problem.allowed


@pytest.mark.parametrize(
    "given", [{"friction": {"mu_k": 0.0}}, {"grid": {"mu_k": [0.1, 0.0]}}], ids=["fixed", "axis"]
)
def test_of_several_laws_the_narrowest_range_holds(given: dict[str, Any]) -> None:
    """Coulomb's may be zero; Dahl's was divided by."""
    laws = {"friction": ["coulomb", "jenkins"]}
    case = {"schema": 1, "model": {"name": "belt-1dof"}, "analysis": [{"kind": "equilibrium"}]}
    with pytest.raises(CaseError, match=r"> 0 \(coefficient of kinetic friction of jenkins\)"):
        api.load(case | given | {"grid": given.get("grid", {}) | laws})


def symbolic(law: Law) -> tuple[Slip, dict[str, Any]]:
    """What a law is written in, as symbols; its structural parameters are numbers."""
    v, sign, normal = sympy.symbols("v sign N", real=True)
    states = {state.name: sympy.Symbol(state.name, real=True) for state in law.states}
    symbols = {p.name: sympy.Symbol(p.name, positive=True) for p in law.parameters}
    values = symbols | {name: sympy.Integer(2) for name in law.structural}
    return Slip(v, sign, sign * v, normal, states, law.row_symbols()), values


def every_part(law: Law) -> list[Any]:
    """Force, rates and guards as symbols."""
    slip, values = symbolic(law)
    rates = law.rates(slip, values) if law.rates else {}
    guards = law.guards(slip, values) if law.guards else ()
    there = law.surface.along(sympy.Symbol("way"), values) if law.surface else {}
    parts = [law.force(slip, values), *rates.values(), *there.values()]
    return [*parts, *(g for of_one in guards for g in of_one)]


@by_law
def test_every_parameter_is_read(law: Law) -> None:
    """In sliding, but for those of stick alone; a law that cannot stick has none of these."""
    values = symbolic(law)[1]
    read = set().union(*(part.free_symbols for part in every_part(law)))
    unread = {p.name for p in law.parameters if values[p.name] not in read}
    led = {p.default_from for p in law.parameters}  # another one follows it
    assert unread - led == {*law.only_in_stick, *law.structural} - led
    assert law.capacity is not None or not law.only_in_stick


@by_law
def test_forces_are_analytic_in_a_contact_state(law: Law) -> None:
    """With the sign of slip given, nothing like |v| or sign(v) is left to differentiate."""
    for expression in every_part(law):
        assert not expression.atoms(sympy.Abs, sympy.sign, sympy.Heaviside, sympy.Piecewise)


@pytest.mark.parametrize(
    ("law", "changes", "other", "values"),
    [
        ("stribeck", {"mu_s": 0.1}, "coulomb", {"mu_k": 0.1}),
        ("viscous", {"F_V": 0.0}, "coulomb", {}),
        ("stribeck-viscous", {"F_V": 0.0}, "stribeck", {}),
        ("four-parameter", {"d": 0.0, "e": 0.0}, "hyperbolic", {"delta": 2.0}),
        ("rational", {"mu_k": 0.0, "delta": 1}, "hyperbolic", {"delta": 2.0}),
        ("four-parameter", {"d": 1.0, "e": 0.0}, "coulomb", {"mu_k": 0.4}),
        ("lugre", {"mu_s": 0.1, "sigma_2": 0.0}, "dahl", {"mu_k": 0.1}),
        ("linear-regularisation", {"v_tol": 0.1}, "coulomb", {}),
        ("hysteretic", {"Delta_mu_s": 0.0}, "stefanski", {}),
        ("hysteretic-rough", {"roughness": 0.0}, "hysteretic", {}),
    ],
)
def test_laws_contain_one_another(
    law: str, changes: dict[str, float], other: str, values: dict[str, float]
) -> None:
    own = ROWS[law][0] | changes
    for v in (-2.0, -0.3, 0.1, 1.0):
        contained = force(get_law(other), v, ROWS[other][0] | values)
        assert force(get_law(law), v, own) == pytest.approx(contained, rel=1e-14)


def test_a_law_with_a_name_of_the_model_is_not_taken() -> None:
    disc = all_models()["disc-rigid-contact"]
    mine = replace(get_law("hyperbolic"), name="mine", parameters=disc.parameters[:1])
    assert why_unfit(disc, mine) == "'mine' and disc-rigid-contact have parameters of one name: a"


LARGER = [pytest.param(name, marks=pytest.mark.campaign) for name in ("flutter-2dof", "belt-5dof")]


@pytest.mark.parametrize("model", ["belt-1dof", *LARGER])
def test_every_law_is_linearised_with_its_states(model: str) -> None:
    """By differentiated code, at the slide, against central differences of the rates."""
    table = get_model(model)
    for law in (law for law in PLAIN if law.rests and not why_unfit(table, law)):
        own = {name: value for name, value in row_of(law)[0].items() if name != "F0"}
        parameters = defaults(model, law.name, **own)
        state = sliding(build_system(Setup.of(model, law, parameters=parameters)), parameters)
        (at,) = equilibria(state)[:1]
        n = len(at)
        assert n == 2 * len(state.system.coordinates) + len(law.states)
        steps = 1e-6 * np.maximum(np.abs(at), 1e-2) * np.eye(n)
        central = [(state.rates(at + h) - state.rates(at - h)) / (2.0 * h.sum()) for h in steps]
        jacobian, scale = state.jacobian(at), np.abs(state.jacobian(at)).max()
        np.testing.assert_allclose(jacobian, np.array(central).T, rtol=1e-5, atol=1e-7 * scale)
