"""Sliding equilibria: every real one, counted, ordered, and a reason where there is none."""

from __future__ import annotations

from dataclasses import replace
from decimal import Decimal, localcontext
from math import asin, cos, pi, sin
from typing import Any

import numpy as np
import pytest
from motions import defaults, system
from small_models import DOUBLE_WELL

from fiv_cli.analyses.base import Varied
from fiv_cli.analyses.rest.equilibria import all_equilibria, equilibria, relative_residual, sliding
from fiv_cli.api import analyse
from fiv_cli.codegen.derive import derive
from fiv_cli.codegen.reduce import derive_statics
from fiv_cli.codegen.setup import Setup
from fiv_cli.flags import reason_code
from fiv_cli.models import get_model
from fiv_cli.models.base import Contact, Equations, Model, Options, Parameter
from fiv_cli.schedule import make_schedule

# Thesis 6.4.2.1: mu_k, then x1, y1, x2, y2, phi. At 1.4 the thesis prints x1 with a minus sign,
# which no root of 6.18 has.
PRINTED = (
    (0.3, (-0.0042, -0.0304, -0.0036, -0.0061, -0.0001)),
    (1.4, (+0.0053, -0.0263, -0.0147, -0.0053, 0.0026)),
    (2.5, (0.0124, -0.0233, -0.0232, -0.0046, 0.0041)),
)
# Eigenvalues of the coupled modes, with the decimals that the thesis prints of each part.
EIGENVALUES = (
    (0.3, (((-0.05, 2), (100.0, 0)), ((-0.04, 2), (89.4, 1)))),
    (1.4, (((-0.05, 2), (98.7, 1)), ((-0.048, 3), (93.7, 1)))),
    (2.5, (((11.98, 2), (102.6, 1)), ((-12.08, 2), (102.6, 1)))),
)


def found_at(model: str | Model, options: dict[str, str] | None = None, **changes: float) -> Any:
    """The equilibria under Coulomb friction, and the sliding system."""
    built = system(model, options=options, rtol=1e-9)
    state = sliding(built, defaults(model, "coulomb", **changes))
    return all_equilibria(state), state


@pytest.mark.parametrize(("mu_k", "printed"), PRINTED)
def test_printed_equilibria_of_the_five_degrees_of_freedom(
    mu_k: float, printed: tuple[float, ...]
) -> None:
    found, state = found_at("belt-5dof", mu_k=mu_k)
    assert len(found.states) == 1 and found.certified
    assert tuple(np.round(found.states[0][:5], 4)) == printed
    assert np.max(np.abs(state.rates(found.states[0]))) < 1e-12 * 200.0  # of the preload, N


@pytest.mark.parametrize(("mu_k", "printed"), EIGENVALUES)
def test_printed_eigenvalues_of_the_coupled_modes(mu_k: float, printed: Any) -> None:
    found, state = found_at("belt-5dof", mu_k=mu_k)
    values = np.linalg.eigvals(state.jacobian(found.states[0]))
    for (real, real_digits), (imaginary, imaginary_digits) in printed:
        same = np.round(values.real, real_digits) == real
        assert np.any(same & (np.round(values.imag, imaginary_digits) == imaginary))


def test_one_real_and_a_conjugate_pair_without_the_cubic_spring() -> None:
    """What the thesis says of k_nl = 1e4 holds for k_nl = 0; the cubic spring adds three pairs."""
    linear, _ = found_at("belt-5dof", mu_k=1.4, k_nl=0.0)
    cubic, _ = found_at("belt-5dof", mu_k=1.4)
    assert (len(linear.states), linear.n_complex) == (1, 2)
    assert (len(cubic.states), cubic.n_complex) == (1, 8)


def test_three_equilibria_of_the_pin_in_closed_form() -> None:
    """Without k1 and friction, with b0 = l2: phi (1 - phi) (1 - phi/2) = 0, s = b0 k3/(k2 + k3)
    (phi^2/2 - phi), c0 theta = s - b0 phi^2/2."""
    found, state = found_at("pin-on-disc", k1=0.0, mu_k=0.0)
    phi = np.array([y[0] for y in found.states])
    theta = np.array([y[1] for y in found.states])
    np.testing.assert_allclose(phi, [0.0, 1.0, 2.0], atol=1e-13)
    s = 0.1 / 2 * (phi**2 / 2 - phi)
    np.testing.assert_allclose(theta, s / 0.1 - phi**2 / 2, atol=1e-13)
    normal = [state.contact_forces(y)[0, 0] for y in found.states]
    np.testing.assert_allclose(normal, 30.0 - 1000.0 * s, rtol=1e-13)
    assert found.certified and found.n_complex == 0


def test_the_first_equilibrium_grows_out_of_no_load() -> None:
    """A little friction moves the first of three equilibria a little, whatever the others do."""
    first = [found_at("pin-on-disc", k1=0.0, mu_k=mu)[0].states[0] for mu in (0.0, 1e-6)]
    assert 0.0 < np.max(np.abs(first[1] - first[0])) < 1e-5


@pytest.mark.parametrize("seed", range(6))
def test_no_real_solution_is_missed_by_the_polynomial(seed: int) -> None:
    """At random parameters it finds whatever Newton's iteration finds from random starts."""
    from fiv_cli.analyses.rest.equilibria import _newton

    rng = np.random.default_rng(seed)
    factors = {name: rng.uniform(0.3, 3.0) for name in ("k1", "k2", "k3", "c0", "N0", "mu_k")}
    changes = {n: f * defaults("pin-on-disc", "coulomb")[n] for n, f in factors.items()}
    changes["k1"] *= 0.02  # so that there are often three
    found, state = found_at("pin-on-disc", **changes)
    assert found.certified
    n_real = len(found.states) + found.pulling
    assert n_real + found.n_complex == 3
    seen: list[Any] = []
    for _ in range(30):
        start = np.append(rng.uniform(-4.0, 4.0, 2), (0.0, 0.0))
        (solution,) = _newton(state[None], start[None])
        if np.isfinite(solution).all() and not any(np.allclose(solution, y, 1e-6) for y in seen):
            seen.append(solution)
    assert 1 <= len(seen) <= n_real
    held = [y for y in seen if state.contact_forces(y)[0, 0] >= 0.0]
    assert all(any(np.allclose(y, z, rtol=1e-9) for z in found.states) for y in held)


@pytest.mark.parametrize("slope_force", ["omit", "include"])
@pytest.mark.parametrize("mu_k", [0.1, 1.4, 2.9])
def test_a_stiff_contact_leaves_one_equilibrium(slope_force: str, mu_k: float) -> None:
    found, state = found_at(
        "belt-5dof", {"slope_force": slope_force}, mu_k=mu_k, k_nl=1e7, F=1000.0
    )
    assert found.certified and len(found.states) == 1
    assert np.max(np.abs(state.rates(found.states[0]))) < 1e-12 * 1000.0


# --- discs ----------------------------------------------------------------------------------------
def yielding(state: Any) -> float:
    """What the disc yields under the contact, m/N: the sum of R^2/(M (omega^2 - l^2 Omega^2))."""
    names = state.system.generated.parameter_names
    known = dict(zip(names, state.parameters, strict=True))
    modes = [name.split("_")[1:] for name in names if name.startswith("mobility_")]
    return float(
        sum(
            known[f"mobility_{k}_{n}"]
            / (known[f"omega_{k}_{n}"] ** 2 - int(n) ** 2 * known["Omega"] ** 2)
            for k, n in modes
        )
    )


def test_a_rigid_contact_on_a_disc_in_closed_form() -> None:
    """N = N0 / (1 + k_z S), whatever the friction does to the angle."""
    found, state = found_at("disc-rigid-contact", {"modes": "0,1"}, mu_k=0.4, mu_s=0.8)
    assert len(found.states) == 1 and found.certified
    normal, tangential, _ = state.contact_forces(found.states[0])[0]
    assert normal == pytest.approx(500.0 / (1.0 + 3e4 * yielding(state)), rel=1e-12)
    assert tangential == pytest.approx(0.4 * normal, rel=1e-13)
    assert np.max(np.abs(state.rates(found.states[0]))) < 1e-11 * 500.0


@pytest.mark.parametrize("model", ["disc-rigid-contact", "excited-disc", "disc-nonlinear-contact"])
@pytest.mark.parametrize("slope_force", ["omit", "include"])
def test_modes_of_a_disc_leave_a_polynomial(model: str, slope_force: str) -> None:
    """The two parts of a doublet combine, in the slope at the contact too."""
    options = {"modes": "0,1", "slope_force": slope_force}
    first = derive_statics(Setup.of(model, "exponential", options)).reductions[0]
    assert first.scalar == "F_N.0"
    assert first.eliminated == ("C_0_1", "D_0_1")


def test_a_rest_is_derived_the_same_before_and_after_a_schedule() -> None:
    """What is kept of a case at constant speed serves one whose speed varies, and back."""
    steady, varying = (
        Setup.of("belt-1dof", "coulomb", schedule=make_schedule(curves))
        for curves in ({}, {"v": [(0.0, 1.0), (9.0, 0.0)]})
    )
    assert derive(varying).parameter_names != derive(steady).parameter_names
    assert derive_statics(varying) == derive_statics(steady)


@pytest.mark.parametrize(("F", "k_nl"), [(1000.0, 1e6), (1e4, 1e8), (1e4, 0.0)])
def test_a_compliant_contact_on_a_disc_is_a_cubic(F: float, k_nl: float) -> None:
    """r0 phi = ((1 + mu) N - F) / k1, u = r0 phi - 2 (F - N) / k3, d = -S N - u and
    N = k2 d + k_nl d^3."""
    modes = {"modes": "0,1"}
    found, state = found_at("disc-nonlinear-contact", modes, F=F, k_nl=k_nl, mu_k=0.3)
    k1, k2, k3 = 1e5, 5e4, 6e4
    slope = -yielding(state) - 1.3 / k1 - 2.0 / k3
    d = np.polynomial.Polynomial([F / k1 + 2.0 * F / k3, slope])
    roots = (k_nl * d**3 + k2 * d - np.polynomial.Polynomial([0.0, 1.0])).roots()
    (normal,) = roots[np.abs(roots.imag) < 1e-6 * np.abs(roots)].real
    (solution,) = found.states
    assert state.contact_forces(solution)[0, 0] == pytest.approx(normal, rel=1e-11)
    assert solution[0] == pytest.approx((1.3 * normal - F) / k1 / 0.1, rel=1e-11)
    assert found.certified and found.n_complex == (2 if k_nl else 0)


DISCS = [
    ("disc-rigid-contact", {}),
    ("excited-disc", {"states": "all"}),
    ("excited-disc", {"states": "slip"}),
    ("disc-nonlinear-contact", {}),
]


@pytest.mark.parametrize(("model", "options"), DISCS)
def test_a_disc_at_its_critical_speed_has_no_equilibrium_and_beyond_it_one_again(
    model: str, options: dict[str, str]
) -> None:
    """At omega = l Omega the load meets no stiffness; just above it the disc comes towards the
    slider by so much that a unilateral contact would have to pull."""
    law = get_model(model).default_law
    built = system(model, law, options)
    critical = built.known(defaults(model, law))["omega_0_2"] / 2.0
    found = {}
    for speed in (0.9, 1.0, 1.001, 1.05):
        changes = {"Omega": speed * critical}
        found[speed] = analyse(model, law, "equilibrium", options=options, **changes)
    assert (found[1.0].status, found[1.0].reason) == ("failed", "singular_equilibrium")
    bilateral = options.get("states") == "slip"
    assert found[1.001].reason == ("" if bilateral else "contact_would_pull")
    for outcome in (found[0.9], found[1.05], *([found[1.001]] if bilateral else [])):
        assert (outcome.status, outcome.reason) == ("ok", "")
        assert outcome.values["complete"] == "certified"
    assert all(found[speed].values["F_N"][0] > 0.0 for speed in (0.9, 1.05))
    linear = analyse(model, law, "eigenvalues", options=options, Omega=critical)
    assert (linear.status, linear.reason) == ("failed", "singular_equilibrium")
    beside = analyse(model, law, "eigenvalues", options=options, Omega=0.9 * critical)
    assert beside.status == "ok"


# --- why there is none ----------------------------------------------------------------------------
def test_a_contact_that_would_have_to_pull_keeps_a_solution_out() -> None:
    """An upward preload is held by a bilateral contact only."""
    for options, reason in (({"states": "all"}, "contact_would_pull"), ({"states": "slip"}, "")):
        found, state = found_at("belt-5dof", options, F=-1.0)
        assert found.reason == reason
        assert (len(found.states), found.pulling) == ((0, 1) if reason else (1, 0))
        assert all(state.contact_forces(y)[0, 0] < 0.0 for y in found.states)
    assert reason_code("contact_would_pull")


@pytest.mark.parametrize("changes", [{"k4": 0.0}, {"k1": 0.0, "k3": 0.0}, {"k5": 0.0, "k6": 0.0}])
def test_what_nothing_holds_has_no_equilibrium(changes: dict[str, float]) -> None:
    found, _ = found_at("belt-5dof", **changes)
    assert not found.states and found.reason == "singular_equilibrium"


@pytest.mark.parametrize("states", ["until-separation", "slip"])
def test_at_divergence_the_stiffness_is_singular_and_beyond_it_the_contact_would_pull(
    states: str,
) -> None:
    """k11 k22 = k12 (k12 + mu k3), thesis 3.23 and 3.25: the equilibrium leaves by infinity."""
    k1, k2, k3, angles = 1.0, 1.0, 2.0, (2.4, pi / 6)
    (c1, s1), (c2, s2) = ((cos(angle), sin(angle)) for angle in angles)
    k11, k22 = k1 * c1**2 + k2 * c2**2, k1 * s1**2 + k2 * s2**2 + k3
    k12 = -k1 * s1 * c1 + k2 * s2 * c2
    critical = (k11 * k22 / k12 - k12) / k3
    found = {}
    for name, mu in {"below": 0.99 * critical, "at": critical, "above": 1.01 * critical}.items():
        found[name], _ = found_at("flutter-2dof", {"states": states}, alpha1=2.4, mu_k=mu, mu_s=mu)
    assert found["at"].reason == "singular_equilibrium"
    assert (len(found["below"].states), found["below"].reason) == (1, "")
    beyond = "" if states == "slip" else "contact_would_pull"
    assert (found["above"].reason, found["above"].certified) == (beyond, True)


@pytest.mark.parametrize("F", [1e-3, 1.0, 1e4])
@pytest.mark.parametrize("k2", [1.2, 2.0, 5.0])
def test_where_the_equilibrium_leaves_by_infinity_is_told_to_rounding(k2: float, F: float) -> None:
    """The same, however small the load, and however far away the last equilibrium lies."""
    with localcontext() as exact:
        exact.prec = 50
        c1, s1, c2, s2 = (Decimal(x(angle)) for angle in (pi / 4, pi / 6) for x in (cos, sin))
        stiffness = Decimal(k2)
        k11, k22 = c1**2 + stiffness * c2**2, s1**2 + stiffness * s2**2 + 2
        k12 = -s1 * c1 + stiffness * s2 * c2
        critical = (k11 * k22 / k12 - k12) / 2
    settings = {"parameter": Varied("mu_k"), "bracket": (0.0, 200.0), "system": "original"}
    changes = {"k2": k2, "F": F, "c1": 0.1, "c2": 0.1}
    found = analyse("flutter-2dof", "coulomb", "critical", settings=settings, **changes).values
    last = int(np.argmax(found["critical_value"]))
    assert found["crossing_kind"][last] == "end"
    assert abs(Decimal(found["critical_value"][last]) - critical) <= found["critical_error"][last]


def test_a_drive_at_standstill_slides_nothing() -> None:
    found, state = found_at("belt-1dof", v=0.0)
    assert found.reason == "no_drive" and equilibria(state) == []


# --- where no polynomial exists -------------------------------------------------------------------
def _pendulum(symbols: Any, options: Options) -> Equations:
    """m x'' = F_T - k sin x."""
    import sympy

    p, x, x_dot = symbols.parameter, symbols.coordinate("x"), symbols.velocity("x")
    force = symbols.tangential_force(0) - p("k") * sympy.sin(x)
    return Equations(
        accelerations={"x": force / p("m")},
        contacts=(Contact(p("v") - x_dot, "x", normal_force=p("N")),),
        kinetic_energy=p("m") * x_dot**2 / 2,
        potential_energy=-p("k") * sympy.cos(x),
    )


PENDULUM = replace(
    DOUBLE_WELL,
    name="belt-pendulum",
    title="pendulum on a belt",
    parameters=tuple(Parameter(n, n, "1", 1.0, n) for n in ("m", "k", "N", "v")),
    equations=_pendulum,
    law_defaults={},
)


def test_elsewhere_several_are_found_and_none_is_certified() -> None:
    """sin x = mu N / k: the first from zero, others further away, no claim to be complete."""
    found, _ = found_at(PENDULUM, mu_k=0.5, mu_s=0.6)
    angles = [y[0] for y in found.states]
    assert angles[0] == pytest.approx(asin(0.5), rel=1e-13)
    assert len(angles) > 1 and not found.certified and found.n_complex is None
    np.testing.assert_allclose(np.sin(angles), 0.5, atol=1e-12)
    assert min(abs(angle - (pi - asin(0.5))) for angle in angles) < 1e-9


# --- the analysis ---------------------------------------------------------------------------------
def test_the_analysis_counts_and_flags() -> None:
    found = analyse("pin-on-disc", "coulomb", "equilibrium", k1=0.0, mu_k=0.0)
    values = found.values
    assert (values["n_solutions"], values["n_pulling"], values["n_complex"]) == (3, 0, 0)
    assert values["complete"] == "certified"
    assert values["equilibrium"].shape == (3, 2) and values["F_N"].shape == (3,)
    assert np.all(values["residual"] < 1e-9)


def test_the_analysis_says_why_there_is_none() -> None:
    found = analyse("belt-5dof", "coulomb", "equilibrium", F=-1.0)
    assert (found.status, found.reason) == ("failed", "contact_would_pull")
    assert (found.values["n_solutions"], found.values["n_pulling"]) == (0, 1)


APART = {
    "M": 1.7832251493666335e-06, "m": 3.647218110796836e-12, "k1": 0.00012150711402465643,
    "k5": 9202002.341400677, "k_nl": 3319456779.97991, "l2": 24.804895070347268,
}  # fmt: skip


def test_what_leaves_forces_over_is_no_equilibrium(monkeypatch: pytest.MonkeyPatch) -> None:
    """Springs eleven orders of magnitude apart: what Newton's steps end at is none."""
    found = analyse("belt-5dof", "coulomb", "equilibrium", **APART)
    assert (found.status, found.reason) == ("failed", "inexact_equilibrium")
    monkeypatch.setattr("fiv_cli.analyses.rest.equilibria.EXACT", np.inf)
    left = analyse("belt-5dof", "coulomb", "equilibrium", **APART).values["residual"]
    assert max(left) > 1e-9


def test_where_what_a_displacement_contributes_vanishes_rounding_is_none_the_less() -> None:
    """Figure 6.22 at mu_k = 0.6: what pulls sideways is equal, and the slider stays in place."""
    point = {"mu_k": 0.6, "mu_s": 4.0, "k_nl": 0.0, "F": 1e4}
    options = {"geometry": "linear"}
    found = analyse("disc-nonlinear-contact", "coulomb", "equilibrium", options=options, **point)
    assert found.status == "ok" and found.values["residual"] < 1e-9


@pytest.mark.parametrize(
    "model", ["belt-5dof", "pin-on-disc", "flutter-2dof", "disc-rigid-contact"]
)
def test_of_an_equilibrium_no_force_is_left_but_rounding(model: str) -> None:
    parameters = defaults(model, "coulomb")
    state = sliding(system(model, "coulomb", parameters=parameters), parameters)
    for solution in equilibria(state):
        assert relative_residual(state, solution) < 1e-14
        assert relative_residual(state, solution * (1.0 + 1e-6)) > 1e-8
