"""Tangent vectors through impacts and separation: closed forms, and neighbours of the motion."""

from __future__ import annotations

import cmath
from math import log
from typing import Any

import bouncing_ball as ball
import numpy as np
import pytest
from motions import TIGHT, defaults, motion, system, transitions
from numpy.typing import NDArray
from small_models import BALL, BOUNCER, TWO_BOUNCERS

from fiv_cli.analyses.attractor.lyapunov import Exponent, book_growth
from fiv_cli.analyses.base import Section, Start
from fiv_cli.api import analyse
from fiv_cli.codegen.codes import STICK
from fiv_cli.codegen.generate import FLOW, TANGENT
from fiv_cli.dynamics.motion import Motion

Matrix = NDArray[np.float64]

# --- a ball on a shaking table: closed form ------------------------------------------------------
AMPLITUDE = 0.1


def flying(stable: bool) -> tuple[float, dict[str, float], float]:
    """Phase of impact, the ball a tenth of a period after it, and the time then."""
    phase, flown = ball.impact_phase(AMPLITUDE, stable), ball.PERIOD / 10
    return phase, ball.in_flight(AMPLITUDE, phase, flown), phase / ball.OMEGA + flown


@pytest.mark.parametrize("stable", [True, False], ids=["stable", "unstable"])
def test_multipliers_of_a_bouncing_ball(stable: bool) -> None:
    """The impact depends on time (the table moves), and so does its tangent."""
    phase, start, begun = flying(stable)
    bounced = motion(BALL, start=start, time=begun)
    bounced.carry_tangents(np.eye(4))
    bounced.run(begun + ball.PERIOD)
    assert transitions(bounced) == ["separation->separation"]
    np.testing.assert_allclose(bounced.y, motion(BALL, start=start, time=begun).y, atol=1e-12)
    found = np.sort_complex(np.linalg.eigvals(bounced.tangents.T))
    np.testing.assert_allclose(found, ball.multipliers(AMPLITUDE, phase), rtol=1e-11)


def test_exponent_and_multipliers_of_an_impacting_response() -> None:
    phase, start, begun = flying(stable=True)
    until = 2 * ball.PERIOD - begun  # to phase 0 of the table, where a response starts
    bounced = motion(BALL, start=start, time=begun)
    bounced.run(begun + until)
    state = dict(zip(bounced.system.state_names, bounced.y + 1e-3, strict=True))
    chosen = {"section": Section("zero", state="z_dot", direction="down"), "t_max": 500.0}
    found = analyse(BALL, "coulomb", "response", Start("a", "state", state), chosen, A=AMPLITUDE)
    assert found.values["attractor"] == "periodic"
    assert found.values["period"] == pytest.approx(ball.PERIOD, rel=1e-7)
    expected = np.sort(np.abs(ball.multipliers(AMPLITUDE, phase)))[::-1]
    np.testing.assert_allclose(found.values["floquet_multiplier"], expected, rtol=1e-6)
    assert found.values["lyapunov"] == pytest.approx(log(expected[0]) / ball.PERIOD, rel=1e-5)


def test_a_tangent_grows_through_impacts_by_the_largest_multiplier() -> None:
    """What an exponent is made of, on the unstable bounce, before rounding leaves it."""
    phase, start, begun = flying(stable=False)
    bounced = motion(BALL, start=start, time=begun)
    growth = Exponent(bounced, autonomous=False, blocks=18).growth
    for period in range(1, 19):
        bounced.run(begun + period * ball.PERIOD)
        book_growth(growth, bounced.frame)
    largest = np.max(np.abs(ball.multipliers(AMPLITUDE, phase)))
    assert growth.growths[-1] == pytest.approx(log(largest), rel=1e-6)
    assert bounced.frame.n_impacts == 18


# --- neighbours of the motion --------------------------------------------------------------------
BEGIN = 1.0  # s, when transients of the start are over

IMPACTING: dict[str, Any] = {
    "rigid": (BOUNCER, {"z": 0.3, "x_dot": 0.3}, {"contact": "rigid"}, {"A": 15.0}, 4.2),
    "compliant": (
        BOUNCER, {"z": 0.3, "x_dot": 0.3}, {"contact": "compliant"}, {"A": 15.0, "k_c": 300.0}, 4.2,
    ),
    "elastic": (
        BOUNCER, {"z": 0.3, "x_dot": 0.3}, {"contact": "elastic"}, {"A": 15.0, "k_c": 300.0}, 4.2,
    ),
    "two contacts": (
        TWO_BOUNCERS, {"z1": 0.3, "z2": 0.2, "x1_dot": 0.3}, {}, {"A": 15.0, "m2": 1.2}, 4.2,
    ),
    "five degrees": ("belt-5dof", {"x1_dot": 1.0}, {}, {"mu_k": 1.2, "mu_s": 3.0}, 0.3),
    "five degrees, slope": (
        "belt-5dof", {"x1_dot": 1.0}, {"slope_force": "include"}, {"mu_k": 1.2, "mu_s": 3.0}, 0.3,
    ),
}  # fmt: skip


def begun_from(name: str, state: Any, sticking: tuple[bool, ...] = (), time: float = 0.0) -> Motion:
    """A motion of one of `IMPACTING` from a state vector."""
    model, _, options, changes, _ = IMPACTING[name]
    built = system(model, options=options)
    parameters = defaults(model, "coulomb", **changes)
    begun = Motion(built, parameters, TIGHT, state, time, sticking)
    begun.keep_ledger(1000)
    return begun


def derivative(name: str, state: Any, sticking: tuple[bool, ...], until: float) -> Matrix:
    """Central differences of the flow, by each entry of the state."""
    columns = []
    for i, value in enumerate(state):
        shift = 1e-6 * max(abs(value), 1e-3)
        ends = []
        for sign in (1.0, -1.0):
            near = np.array(state)
            near[i] += sign * shift
            moved = begun_from(name, near, sticking, BEGIN)
            moved.run(until)
            ends.append(moved.y)
        columns.append((ends[0] - ends[1]) / (2 * shift))
    return np.array(columns).T


@pytest.mark.parametrize("name", IMPACTING)
def test_tangents_follow_neighbours_through_contact_and_flight(name: str) -> None:
    """Through landing, sticking, release and lift-off, entry by entry."""
    _, start, _, _, span = IMPACTING[name]
    state = begun_from(name, start)
    state.run(BEGIN)
    sticking = tuple(bool(kind == STICK) for kind in state.kinds)
    carried = begun_from(name, state.y.copy(), sticking, BEGIN)
    carried.carry_tangents(np.eye(len(carried.y)))
    carried.run(BEGIN + span)
    landings = [words for words in transitions(carried) if words.startswith("separation")]
    assert len(landings) >= 2
    scale = np.maximum(np.abs(state.y), 1e-3)
    found = carried.tangents.T * scale / scale[:, None]
    expected = derivative(name, state.y.copy(), sticking, BEGIN + span) * scale / scale[:, None]
    largest = max(float(np.max(np.abs(expected))), 1.0)  # differences are good to 1e-8 of a state
    np.testing.assert_allclose(found, expected, atol=3e-7 * largest)


# --- generated code ------------------------------------------------------------------------------
@pytest.mark.parametrize("model", [BALL, BOUNCER, "belt-5dof"], ids=["ball", "bouncer", "5dof"])
def test_impact_tangents_are_directional_derivatives(model: Any) -> None:
    """A complex step through the impact's own text: no difference, no cancellation."""
    built = system(model)
    vector = built.parameter_vector(defaults(model, "coulomb"))
    n = len(built.state_names)
    flow = functions(built.generated.texts[FLOW], cmath)
    tangent = functions(built.generated.texts[TANGENT], cmath)
    slots = np.zeros(max(built.generated.n_coefficients, 1))
    flow["coefficients"](None, 0.0, vector, slots)
    state, direction = np.cos(np.arange(n) + 0.3), np.sin(np.arange(n) + 1.1)
    after, both, out = np.zeros(n, complex), np.zeros(8 * n, complex), np.zeros(8 * n, complex)
    flow["separation_impact_0"](slots, 0.7, state + 1e-30j * direction, after)
    tangent["separation_impact_tangent_0"](slots, 0.7, np.append(state, direction), both)
    np.testing.assert_allclose(both[4 * n : 6 * n : 2].real, after.real, rtol=1e-12)
    np.testing.assert_allclose(both[6 * n :: 2].real, after.imag / 1e-30, rtol=1e-9, atol=1e-12)
    flow["separation_field"](slots, 0.7, state, both_field := np.zeros(100, complex))
    moved = state + 1e-30j * both_field[n : 2 * n].real
    flow["separation_impact_0"](slots, 0.7 + 1e-30j, moved, out[:n])
    np.testing.assert_allclose(
        both[4 * n + 1 : 6 * n : 2].real, out[:n].imag / 1e-30, rtol=1e-9, atol=1e-9
    )


def functions(text: str, library: Any) -> dict[str, Any]:
    """The functions of a generated text, run by Python."""
    names: dict[str, Any] = {
        name: getattr(library, name) for name in ("exp", "log", "sqrt", "sin", "cos", "tanh")
    }
    exec(text, names)
    return names
