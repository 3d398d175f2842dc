"""Laws with internal states: closed forms, published numbers, and the laws that they tend to."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
import sympy
from motions import TIGHT, booked, motion, transitions
from scipy.linalg import expm

from fiv_cli import api
from fiv_cli.analyses.base import SolverSettings
from fiv_cli.codegen.codes import CODE_SEPARATION, CODE_SLIP_PLUS
from fiv_cli.codegen.setup import Setup, default_parameters
from fiv_cli.dynamics.motion import Motion, Stop
from fiv_cli.dynamics.settings import Section
from fiv_cli.dynamics.system import build_system
from fiv_cli.friction import get_law
from fiv_cli.friction.base import Law, Slip
from fiv_cli.models import get_model
from fiv_cli.models.base import Parameter, State

BELT = get_model("belt-1dof")
AT_REST = ("equilibrium", "eigenvalues")
MAXWELL = Law(
    name="maxwell",
    title="a spring of stiffness sigma in series with a damper: F_T = sigma z, z' = v - z/tau",
    reference="",
    numerics_version=1,
    parameters=(
        Parameter("sigma", r"\sigma", "N m-1", 3.0, "stiffness", "", 0.0),
        Parameter("tau", r"\tau", "s", 0.7, "how long the spring remembers", "", 0.0),
    ),
    force=lambda slip, p: p["sigma"] * slip.states["z"],
    capacity=None,
    states=(State("z", "z", "m", "stretch of the spring"),),
    rates=lambda slip, p: {"z": slip.v - slip.states["z"] / p["tau"]},
)


def test_an_internal_state_moves_with_the_slip() -> None:
    """m x'' = -k x - c x' + sigma z and z' = v - x' - z/tau: linear, so a matrix exponential."""
    p = default_parameters(BELT, MAXWELL, c=0.1, m=2.0)
    solver = SolverSettings(rtol=1e-13)
    begun = Motion(build_system(Setup.of(BELT, MAXWELL, parameters=p)), p, solver, {"x": 0.3})
    begun.run(5.0)
    matrix = np.zeros((4, 4))  # of x, x', z and 1
    matrix[0, 1] = 1.0
    matrix[1, :3] = np.array([-p["k"], -p["c"], p["sigma"]]) / p["m"]
    matrix[2, 1:] = -1.0, -1.0 / p["tau"], p["v"]
    expected = expm(5.0 * matrix) @ np.array([0.3, 0.0, 0.0, 1.0])
    np.testing.assert_allclose(begun.y, expected[:3], rtol=0.0, atol=1e-11)


def test_lugre_stick_slip_is_that_of_the_published_example() -> None:
    """Canudas de Wit et al. 1995, a mass pulled by a spring: the period, the largest velocity."""
    bristles = {"sigma_0": 1e5, "sigma_1": 1e5**0.5, "sigma_2": 0.4, "v_s": 1e-3}
    pulled = {"m": 1.0, "k": 2.0, "v": 0.1, "N": 1.0, "mu_s": 1.5, "mu_k": 1.0}
    begun = motion("belt-1dof", "lugre", {}, **pulled, **bristles)
    begun.run(40.0)
    begun.start_measuring(np.zeros(1))
    times, states = np.zeros(5), np.zeros((5, 3))
    begun.run(80.0, Section("zero", state="x_dot", direction="up"), (times, states), measuring=True)
    assert np.diff(times[: begun.n_sections]) == pytest.approx(6.3627, abs=5e-5)
    largest = 0.1 - begun.extremes[0, 1]  # of the pulled mass: seen from the belt
    assert largest == pytest.approx(0.3698, abs=5e-5)


@pytest.mark.parametrize("direction", [1.0, -1.0])
def test_dahl_yields_exponentially_over_a_stated_slip(direction: float) -> None:
    """Thesis 2.11 at constant v: z = (mu_k/sigma_0) (1 - exp(-sigma_0 v t/mu_k))."""
    heavy = {"m": 1e15, "k": 0.0, "v": direction * 0.02, "mu_k": 0.3, "sigma_0": 50.0}
    begun = motion("belt-1dof", "dahl", {}, **heavy)
    begun.run(0.4)
    slipped = 0.3 / 50.0 * (1.0 - np.exp(-50.0 * 0.02 * 0.4 / 0.3))
    assert begun.y[2] == pytest.approx(direction * slipped, rel=1e-12)


def periods(law: str, **changes: float) -> float:
    """Period of the stick-slip of a mass on a belt under friction that falls at once."""
    given = {"v": 0.4, "mu_s": 0.6, "mu_k": 0.3, "v_s": 0.3, "delta": 2.0, "N": 5.0} | changes
    begun = motion("belt-1dof", law, {}, SolverSettings(rtol=1e-11), **given)
    begun.run(40.0)
    times, states = np.zeros(2), np.zeros((2, len(begun.y)))
    begun.run(80.0, Section("zero", state="x_dot", direction="down"), (times, states))
    return float(np.diff(times)[0])


@pytest.mark.parametrize(
    ("law", "stiffness", "values", "order"),
    [
        ("lugre", "sigma_0", (3.2e4, 6.4e4, 1.28e5), 2 / 3),
        ("tanh of stribeck", "sigma", (800.0, 1600.0, 3200.0), 0.9),
    ],
)
def test_stiff_laws_tend_to_the_set_valued_one(
    law: str, stiffness: str, values: tuple[float, ...], order: float
) -> None:
    """Break-away passes a fold, which delays it by a stiffness to the power -2/3.

    Beside it tanh has creep, of first order, in these steepnesses the larger part.
    """
    exact = periods("stribeck")
    others = {"sigma_1": 10.0} if law == "lugre" else {}
    found = [periods(law, **{stiffness: value}, **others) for value in values]
    errors = np.abs(np.array(found) - exact)
    assert np.log2(errors[:-1] / errors[1:]) == pytest.approx(order, abs=0.03)
    assert errors[-1] < 1e-2


def test_steady_sliding_and_its_modes_tend_to_those_of_the_set_valued_law() -> None:
    """The slide is Stribeck's exactly; the growth rate tends to Stribeck's at first order."""
    given = {"v": 0.4, "mu_s": 0.6, "mu_k": 0.3, "v_s": 0.3, "delta": 2.0, "c": 0.1}
    exact = {kind: api.analyse(BELT, "stribeck", kind, **given).values for kind in AT_REST}
    errors = []
    for sigma_0 in (1e3, 2e3, 4e3):
        bristles = given | {"sigma_0": sigma_0, "sigma_1": 0.0}
        found = {kind: api.analyse(BELT, "lugre", kind, **bristles).values for kind in AT_REST}
        assert found["equilibrium"]["complete"] == "certified"
        x, x_exact = found["equilibrium"]["equilibrium"], exact["equilibrium"]["equilibrium"]
        np.testing.assert_allclose(x, x_exact, rtol=1e-14)
        errors.append(found["eigenvalues"]["growth_rate"] - exact["eigenvalues"]["growth_rate"])
    assert np.log2(np.array(errors[:-1]) / errors[1:]) == pytest.approx(1.0, abs=0.01)


@pytest.mark.parametrize("law", ["dahl", "lugre"])
def test_bristles_of_an_open_contact_stay_as_they_were(law: str) -> None:
    """Also where the slip turns round, which nothing marks while the contact is open."""
    start = {"x1": 0.02, "x1_dot": 5.1, "y1": 0.02, "y1_dot": 1.0, "deflection": 1e-4}
    begun = motion("belt-5dof", law, start, mu_k=0.3)
    assert begun.y[begun.system.places["x1_dot"]] > 5.0  # the speed of the belt
    begun.run(0.004)
    assert begun.y[begun.system.places["x1_dot"]] < 5.0 and begun.codes == [CODE_SEPARATION]
    assert begun.y[begun.system.places["deflection"]] == 1e-4


@pytest.mark.parametrize("slide", [-1.0, 3.0])
def test_contact_closes_on_stiff_bristles(slide: float) -> None:
    """At re-contact the normal force is zero to rounding, not against the steps of the bristles.

    They shorten the first step so much that the rounding of the gap passed for a force that
    pulls: no contact state was left at one start in five.
    """
    bristles = {"sigma_0": 1e5, "mu_k": 0.1, "mu_s": 3.0, "v_s": 0.1}
    for height in np.linspace(0.021, 0.022, 8):
        thrown = {"y1": height, "y1_dot": -0.5, "y2": 2e-3, "x1_dot": slide, "deflection": -3e-5}
        begun = motion("belt-5dof", "lugre", thrown, **bristles)
        assert begun.run(0.02) == Stop.REACHED and begun.frame.n_impacts == 1


@pytest.mark.parametrize("law", ["dahl", "tanh of stribeck"])
def test_one_of_two_contacts_at_rest_that_cannot_stick(law: str) -> None:
    """It begins to slide, the way that it is left behind; the process died of it."""
    begun = motion("belt-2mass", law, {"x1_dot": 1.0, "x1": 0.5}, v=1.0)
    assert begun.codes == [CODE_SLIP_PLUS, CODE_SLIP_PLUS]
    assert begun.run(5.0) == Stop.REACHED and np.all(np.isfinite(begun.y))


def test_a_history_holds_the_states_of_the_laws_of_every_contact() -> None:
    """What a contact has slipped it has bent, as long as it has not yielded; Coulomb has none."""
    case = {
        "schema": 1,
        "model": {"name": "belt-2mass"},
        "friction": {"sigma_0": 1e-2},
        "grid": {"friction": ["coulomb", "dahl"]},
        "initial": [{"label": "far", "kind": "state", "state": {"x1_dot": 0.5}}],
        "analysis": [{"kind": "history", "t_end": 2.0}],
    }
    found = api.run(api.load(case)).sel(initial="far")
    assert found["deflection"].attrs["units"] == "m"
    assert found["deflection"].dims == ("friction", "contact", "time")
    assert np.isnan(found["deflection"].sel(friction="coulomb")).all()
    bent = found["deflection"].sel(friction="dahl")
    np.testing.assert_allclose(found["F_T"].sel(friction="dahl"), 1e-2 * bent * found["N"])
    for contact, mass in enumerate(("x1", "x2")):
        slipped = found["v"] * found["time"] - found[mass].sel(friction="dahl")
        np.testing.assert_allclose(bent[contact], slipped, rtol=0.2)
        assert bent[contact].max() > 0.5


def heated(law: Law) -> Law:
    """`law`, with one more state: what it has taken for good, (F_T v - dE/dz z') along the slip."""
    assert law.stored is not None and law.rates is not None
    stored, given = law.stored, law.rates

    def rates(slip: Slip, p: Any) -> dict[str, Any]:
        own = replace(slip, states={state.name: slip.states[state.name] for state in law.states})
        found, energy = given(own, p), stored(own, p)
        given_back = sum(sympy.diff(energy, z) * found[name] for name, z in own.states.items())
        return {**found, "heat": law.force(own, p) * slip.v - given_back}

    def force(slip: Slip, p: Any) -> Any:
        return law.force(replace(slip, states={n: slip.states[n] for n in found}), p)

    found = [state.name for state in law.states]
    states = (*law.states, State("heat", "Q", "J", "energy taken for good"))
    return replace(law, name=f"heated {law.name}", force=force, states=states, rates=rates)


@pytest.mark.parametrize("name", ["dahl", "lugre", "jenkins", "gms", "elasto-plastic"])
def test_what_friction_takes_it_has_stored_or_turned_to_heat(name: str) -> None:
    """Through every event and reversal: the heat is a state of its own, integrated beside."""
    given = {"sigma_0": 30.0} if "sigma_0" in get_law(name).defaults else {"k_1": 20.0}
    given |= {"v": 0.3, "c": 0.05, "N": 5.0} | ({"v_s": 0.2} if name == "lugre" else {})
    law, asked = heated(get_law(name)), {"t_end": 6.0}
    found = api.analyse(BELT, law, "history", {"x": 0.7}, asked, TIGHT, **given).values
    turns = np.diff(np.sign(given["v"] - found["x_dot"]))
    assert np.count_nonzero(turns) >= 2 and found["stored_energy"].max() > 1e-4
    assert found["friction_loss"] == pytest.approx(found["heat"][-1], rel=1e-10)


@pytest.mark.parametrize("v", [2e-3, 2e-2])
def test_rate_and_state_slides_unsteadily_below_the_critical_stiffness(v: float) -> None:
    """(b - a) N/D_c of the quasi-static spring and slider (Ruina 1983), and what inertia adds."""
    a, b, D_c, N, m = 0.01, 0.015, 1e-3, 10.0, 1.5
    given = {"a_rate": a, "b_state": b, "D_c": D_c, "N": N, "m": m, "v": v, "mu_0": 0.6}
    asked = {"parameter": "k", "bracket": [1.0, 1e3]}
    found = api.analyse(BELT, "rate-and-state", "critical", None, asked, **given).values
    critical = (b - a) * N / D_c * (1.0 + m * v**2 / (a * N * D_c))
    assert found["critical_value"] == pytest.approx([critical], rel=1e-9)
    frequency = np.sqrt(critical * v / (m * v + N * a * D_c / v))
    assert found["crossing_frequency"] == pytest.approx([frequency], rel=1e-6)
    assert (found["unstable_below"], found["unstable_above"]) == ([2], [0])


def test_rate_and_state_friction_after_a_step_of_the_slip_speed() -> None:
    """The direct effect at once, a ln(v/v_0); then the age, of the closed form, after D_c."""
    a, b, D_c, faster = 0.01, 0.015, 1e-3, 3e-2
    heavy = {"m": 1e15, "k": 0.0, "a_rate": a, "b_state": b, "D_c": D_c, "v_0": 1e-2, "N": 1.0}
    begun = motion("belt-1dof", "rate-and-state", {}, mu_0=0.6, v=faster, **heavy)
    for time in (0.0, 0.02, 0.1):
        begun.run(time)
        age = 1.0 / 3.0 + 2.0 / 3.0 * np.exp(-faster * time / D_c)  # v_0 theta/D_c
        coefficient = 0.6 + a * np.log(3.0) + b * np.log(age)
        assert begun.y[2] + 1.0 == pytest.approx(age, rel=1e-12)
        (force,) = begun.system.field(0, begun.coefficients, time, begun.y).contacts[:, 1]
        assert force == pytest.approx(coefficient, rel=1e-12)


AGEING = {
    "mu_0": 0.4,
    "a_rate": 0.01,
    "b_state": 0.02,
    "D_c": 1e-2,
    "v_0": 1e-2,
    "c": 0.1,
    "N": 5.0,
}


@pytest.mark.parametrize("speed", [1e-2, 1e-3])
def test_a_contact_that_is_held_bears_the_more_the_longer_it_is(speed: float) -> None:
    """The spring k v t of a mass on a slow belt meets what stick has grown to, as b ln t."""
    given = AGEING | {"v": speed, "v_c": 1e-4}
    begun = motion("belt-1dof", "rate-and-state-cutoff", {"x_dot": speed}, **given)
    begun.keep_ledger(10)
    begun.run(300.0 * 1e-2 / speed)
    released = begun.ledger[0][0]
    held = 0.4 + 0.01 * np.log(1e-4 / 1e-2) + 0.02 * np.log(1.0 + released)  # v_0/D_c = 1/s
    assert speed * (released + 0.1) == pytest.approx(5.0 * held, rel=1e-10)  # k v t + c v


def test_a_cut_off_tends_to_rate_and_state_and_lets_slip_turn() -> None:
    one_way = motion("belt-1dof", "rate-and-state", {}, **AGEING, v=3.0)
    one_way.run(10.0)
    errors = []
    for cutoff in (1e-3, 1e-4, 1e-5):
        begun = motion("belt-1dof", "rate-and-state-cutoff", {}, **AGEING, v=3.0, v_c=cutoff)
        begun.run(10.0)
        errors.append(np.abs(begun.y - one_way.y).max())
    assert np.log10(np.divide(errors[:-1], errors[1:])) == pytest.approx([1.0, 1.0], abs=0.01)
    shaken = AGEING | {"v": 0.0, "u0": 4.0, "omega": 0.5, "v_c": 1e-4}
    begun = motion("belt-1dof", "rate-and-state-cutoff", {}, **shaken)
    assert booked(begun, 60.0).residual < 1e-11
    assert {"stick->slip+", "stick->slip-", "slip+->slip-"} <= set(transitions(begun))


def test_about_steady_sliding_the_sign_of_the_acceleration_is_a_mass() -> None:
    """(mu_s - mu_k) exp(-v/v_s) N/a_0 of it; the lag damps by a share of the order tau."""
    p = {"v": 0.4, "N": 5.0, "mu_s": 0.8, "mu_k": 0.4, "v_s": 1.0, "a_0": 0.1}
    heavier = 1.0 + 0.4 * np.exp(-0.4) * 5.0 / 0.1
    found = [
        api.analyse(BELT, "stefanski", "eigenvalues", **p, tau=tau).values for tau in (0.01, 0.005)
    ]
    rates = [one["growth_rate"] for one in found]
    assert np.max(found[1]["eigenvalue_imag"]) == pytest.approx(heavier**-0.5, rel=1e-6)
    assert rates[0] < 0.0 and rates[0] / rates[1] == pytest.approx(2.0, rel=1e-3)


def test_a_bristle_that_hardly_moves_ends_its_run() -> None:
    """At 1e-21 m/s Newton's steps to an event follow rounding, which led 1000 steps too far."""
    case = {
        "schema": 1,
        "model": {"name": "belt-1dof", "parameters": {"c": 0.5, "v": 0.0}},
        "friction": {"law": "lugre"},
        "initial": [{"label": "near", "kind": "equilibrium", "offset": {"x": 1e-4}}],
        "analysis": [{"kind": "response", "transient": 3.0, "t_max": 60.0}],
        "solver": {"max_steps": 20000},
    }
    found = api.run(api.load(case), workers=1)
    assert found["status"].item() == 0 and found["n_steps"].item() < 20000
