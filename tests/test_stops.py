"""Frictionless stops with restitution; contacts with a law and coefficients of their own."""

from __future__ import annotations

from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np
import pytest
from motions import booked, by_both, ledger, motion
from scipy.optimize import fsolve
from small_models import ON_TWO_BELTS, SMALL, _coordinates, _parameters

from fiv_cli import api
from fiv_cli.cli.equations import equation_lines
from fiv_cli.codegen.codes import (
    CODE_SEPARATION,
    CODE_SLIP_MINUS,
    CODE_SLIP_PLUS,
    SEPARATION,
    SLIP,
    STICK,
)
from fiv_cli.errors import UsageError
from fiv_cli.friction import get_law
from fiv_cli.models import get_model
from fiv_cli.models.base import Contact, Equations, Forcing, Options, stop

CLOSED = (CODE_SLIP_PLUS, CODE_SLIP_MINUS)


def _stopped(symbols: Any, options: Options) -> Equations:
    """m x'' = F_T - c x' - k x + A cos(omega t) - F_1 + F_2: a mass on a belt between two stops."""
    import sympy

    p = symbols.parameter
    x, x_dot = symbols.coordinate("x"), symbols.velocity("x")
    friction, push = symbols.tangential_force(0), p("A") * sympy.cos(p("omega") * symbols.time)
    stops = symbols.normal_force(2) - symbols.normal_force(1)
    free = push + p("G") - p("c") * x_dot - p("k") * x
    return Equations(
        accelerations={"x": (friction + stops + free) / p("m")},
        contacts=(
            Contact(slip_velocity=p("v") - x_dot, slip_coordinate="x", normal_force=p("N")),
            stop(p("ahead") - x, "x", restitution=p("e")),
            stop(x + p("behind"), "x", restitution=p("e")),
        ),
        kinetic_energy=p("m") * x_dot**2 / 2,
        potential_energy=p("k") * x**2 / 2 - p("G") * x,
    )


STOPPED = replace(
    SMALL,
    name="stopped",
    title="a mass on a belt between two stops",
    parameters=_parameters(
        m=1.0, c=0.0, k=1.0, G=0.0, A=0.0, omega=2.0, N=10.0, v=1.0, ahead=1.0, behind=9.0, e=0.5
    ),
    states=lambda options: _coordinates("x"),
    equations=_stopped,
    contacts=3,
    stops=2,
    forcings=(Forcing("A", lambda p: p["omega"], "harmonic force"),),
)
FREE = {"N": 0.0, "mu_k": 0.0, "mu_s": 0.0}


def test_impacts_that_pile_up_end_at_the_instant_of_their_closed_form() -> None:
    """A mass falls with G = 2 through h = 1: it lies still from t_1 + 2 t_1 e / (1 - e) on."""
    begun = motion(STOPPED, k=0.0, G=2.0, e=0.5, **FREE)
    assert booked(begun, 20.0).residual < 1e-12
    rows = ledger(begun)
    hits = rows[rows[:, 3] == 1]
    flights = 2.0 * 0.5 ** np.arange(1, 30)
    np.testing.assert_allclose(hits[:30, 0], 1.0 + np.concatenate([[0.0], flights.cumsum()]))
    assert hits[-1, 0] == pytest.approx(3.0, abs=1e-12)
    assert hits[-1, 1] == CODE_SEPARATION and hits[-1, 2] in CLOSED
    assert begun.y.tolist() == [1.0, 0.0] and begun.kinds.tolist() == [SLIP, SLIP, SEPARATION]


@pytest.mark.parametrize("e", [0.0, 0.3, 1.0])
def test_an_impact_gives_back_its_share_of_the_speed(e: float) -> None:
    begun = motion(STOPPED, start={"x_dot": 3.0}, k=0.0, e=e, **FREE)
    moved = booked(begun, 1.0)
    assert begun.y[1] == pytest.approx(-3.0 * e, rel=1e-14)
    assert moved.impact == pytest.approx(4.5 * (1.0 - e * e), rel=1e-14)


def test_what_sticks_is_torn_off_by_an_impact() -> None:
    """It moves with the belt, v = 1, meets the stop at t = 1 and slides: x'' = mu_k N - k x."""
    begun = motion(STOPPED, start={"x_dot": 1.0}, e=0.5, mu_k=0.3, mu_s=0.4)
    begun.run(0.9)
    assert begun.kinds[0] == STICK
    begun.run(1.25)
    t = 0.25
    assert begun.kinds.tolist() == [SLIP, SEPARATION, SEPARATION]
    assert begun.y[0] == pytest.approx(3.0 - 2.0 * np.cos(t) - 0.5 * np.sin(t), rel=1e-13)


@pytest.mark.parametrize("omega", [1.8, 2.0])
def test_the_orbit_of_one_impact_a_period(omega: float) -> None:
    """x'' + x = A cos(omega t) and a stop at 0 (Shaw & Holmes, J. Sound Vib. 90 (1983) 129)."""
    e, period, forced = 0.8, 2.0 * np.pi / omega, 1.0 / (1.0 - omega**2)

    def left(unknowns: Any) -> list[float]:
        phase, a, b, speed = unknowns
        angles, free = omega * np.array([0.0, period]) + phase, np.array([0.0, period])
        x = forced * np.cos(angles) + a * np.cos(free) + b * np.sin(free)
        x_dot = -forced * omega * np.sin(angles) - a * np.sin(free) + b * np.cos(free)
        return [x[0], x[1], x_dot[0] + e * speed, x_dot[1] - speed]

    *_, speed = fsolve(left, [0.3, 0.1, 0.1, 1.0], xtol=1e-13)
    given = {"A": 1.0, "omega": omega, "e": e, "ahead": 0.0, **FREE}
    found = api.analyse(STOPPED, "coulomb", "response", {"x": -0.3}, **given).values
    assert found["attractor"] == "periodic"
    assert found["period"] == pytest.approx(period, rel=1e-9)
    assert found["x_dot_max"] == pytest.approx(speed, rel=1e-9)
    assert found["x_max"] == pytest.approx(0.0, abs=1e-15)
    np.testing.assert_allclose(np.prod(found["floquet_multiplier"]), e * e, rtol=1e-8)


def test_a_motion_of_irregular_impacts_is_chaotic() -> None:
    """Past the flip of one impact a period, judged by the impacts: nothing ever sticks."""
    given = {"A": 1.0, "omega": 2.8, "e": 0.8, "ahead": 0.0, **FREE}
    found = api.analyse(STOPPED, "coulomb", "response", {"x": -0.3}, {"t_max": 2000.0}, **given)
    assert (found.values["attractor"], found.values["section_kind"]) == ("chaotic", "impact")
    assert found.values["section_contact"] == 2 and found.values["lyapunov"] > 0.05


def test_series_and_rk4_meet_the_same_impacts() -> None:
    given = {"A": 2.0, "e": 0.6, "ahead": 0.5, "behind": 0.4, "mu_k": 0.02, "mu_s": 0.03}
    by_both(8.0, 1e-3, STOPPED, start={"x": 0.1}, **given)


def test_impacts_and_what_they_pile_up_to_are_counted_where_there_are_stops() -> None:
    """A mass that the belt carries to the stop and catches again, and one that falls on it."""
    caught = {"ahead": 0.5, "e": 0.8, "v": 0.4, "N": 1.0, "mu_k": 0.2, "mu_s": 0.8}
    cycle = api.analyse(STOPPED, "coulomb", "response", {"x_dot": 0.4}, **caught).values
    assert (cycle["n_impacts"], cycle["n_accumulations"]) == (1, 0)
    fallen = api.analyse(
        STOPPED, "coulomb", "history", {}, {"t_end": 4.0}, k=0.0, G=2.0, **FREE
    )  # fmt: skip
    codes = fallen.ragged["event_from"]
    assert fallen.values["n_impacts"] == np.count_nonzero(codes == CODE_SEPARATION) > 20
    assert fallen.values["n_accumulations"] == 1
    plain = api.analyse("belt-5dof", "coulomb", "history", {}, {"t_end": 0.01}).values
    assert "n_impacts" not in plain


def test_a_belt_pulls_a_mass_against_a_stop() -> None:
    """Where the sliding equilibrium lies beyond the stop, the mass comes to rest at it."""
    pulled = {"mu_k": 0.3, "mu_s": 0.4}
    rest = api.analyse(STOPPED, "coulomb", "equilibrium", ahead=2.0, **pulled)
    assert (rest.status, rest.reason) == ("failed", "contact_would_pull")
    held = api.analyse(STOPPED, "coulomb", "response", {"x": 0.0}, ahead=2.0, **pulled)
    assert (held.values["attractor"], held.values["x_max"]) == ("equilibrium", 2.0)
    free = api.analyse(STOPPED, "coulomb", "equilibrium", ahead=4.0, **pulled).values
    assert free["equilibrium"].item() == pytest.approx(3.0, rel=1e-14)
    np.testing.assert_allclose(free["F_N"], [[10.0, 0.0, 0.0]])


def test_each_contact_may_have_its_own_law_and_coefficients() -> None:
    """Two belts, the second greased: at rest k x = mu_k N_1 + mu N_2 + b V_2."""
    model = replace(
        ON_TWO_BELTS,
        name="greased",
        parameters=(*ON_TWO_BELTS.parameters, *_parameters(mu=0.1, b=0.25)),
        equations=partial(_greased, told=("mu_s", "mu_k", "F_V")),
    )
    for law, drops in (("coulomb", 0.0), ("lugre", 0.25 * 6.0)):
        given = {"sigma_2": drops / 6.0} if law == "lugre" else {}
        found = api.analyse(model, law, "equilibrium", V2=2.0, mu_k=0.3, mu_s=0.3, **given)
        load = 0.3 * 6.0 + drops + 0.1 * 4.0 + 0.25 * 2.0
        assert found.values["equilibrium"].item() == pytest.approx(load, rel=1e-12), law


def test_a_law_of_a_contact_says_which_of_its_parameters_it_lacks() -> None:
    told = ("mu_s", "mu_k")
    model = replace(ON_TWO_BELTS, name="dry", equations=partial(_greased, told=told))
    with pytest.raises(UsageError, match=r"dry has the law 'viscous' without its F_V\nnext: give"):
        api.analyse(model, "coulomb", "equilibrium")


@pytest.mark.parametrize("law", ["dahl", "gms"])
def test_what_a_law_tells_of_itself_it_does_not_tell_of_stops(law: str) -> None:
    given = {"mu_k": 0.3, "ahead": 2.0}
    found = api.analyse(STOPPED, law, "history", {"x": 1.0}, {"t_end": 3.0}, **given).values
    states = np.array([found[state.name] for state in get_law(law).states])
    assert np.isfinite(states[:, 0]).all() and np.isnan(states[:, 1:]).all()
    assert found["stored_energy"][0].max() > 0.0 == found["stored_energy"][1:].max()


def test_equations_show_the_laws_of_contacts_and_what_impacts_give_back() -> None:
    told = replace(ON_TWO_BELTS, equations=partial(_greased, told=("mu_k",)))
    assert "  law_2 = viscous (mu_k = mu)" in equation_lines(told)
    assert {
        "  restitution_2 = e",
        "  law_2 = none",
        "  impact_2: adds -impulse/m to x'; so that gap_2' is -e of what it was after it",
    } <= set(equation_lines(STOPPED))


@pytest.mark.parametrize(
    ("impact", "told"),
    [
        ("plastic", "is 0 after it"),
        ("thesis", "has changed by -phi'*(x1 - x2) - y1' + y2' after it"),
        ("none", "none, velocities go on as they are"),
    ],
)
def test_equations_show_what_an_impact_does(impact: str, told: str) -> None:
    belt = get_model("belt-5dof")
    chosen = tuple(replace(o, default=impact) if o.name == "impact" else o for o in belt.options)
    (line,) = (one for one in equation_lines(replace(belt, options=chosen)) if "  impact:" in one)
    added = "adds impulse/M to y1', -impulse/m to y2', impulse*(x1 - x2)/J to phi'"
    assert line.endswith(told) and (added in line) == (impact != "none")


def _greased(symbols: Any, options: Options, told: tuple[str, ...]) -> Equations:
    """A mass on two belts; the second has a law of its own, of whose parameters some are told."""
    p, found = symbols.parameter, ON_TWO_BELTS.equations(symbols, options)
    dry, greased = found.contacts
    own = {"mu_s": p("mu"), "mu_k": p("mu"), "F_V": p("b")}
    given = {name: own[name] for name in told}
    return replace(found, contacts=(dry, replace(greased, law="viscous", law_parameters=given)))
