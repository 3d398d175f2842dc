"""Friction that varies along the surface: its statistics, its motions, what it excites."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from math import exp, pi
from typing import Any

import numpy as np
import pytest
import sympy
from motions import booked, ledger, motion, system
from numpy.typing import NDArray
from scipy.integrate import solve_ivp

from fiv_cli import api
from fiv_cli.codegen.codes import CODE_STICK
from fiv_cli.dynamics.motion import samples_at
from fiv_cli.errors import CaseError, UsageError
from fiv_cli.friction import get_law
from fiv_cli.friction.surface import HIGHEST, roughness_at
from fiv_cli.models import get_model
from fiv_cli.models.base import Equations, Model, Options

ROUGH = "hysteretic-rough"
WAVE = 8 * pi
GIVEN = {"mu_s": 0.4, "mu_k": 0.3, "v_s": 0.2, "a_0": 0.5, "tau": 0.05, "Delta_mu_s": 0.1}
GIVEN |= {"roughness": 0.2, "correlation_length": 0.3, "seed": 4.0}
PULLED = {"c": 0.2, "v": 0.1, "N": 5.0, **GIVEN}


@cache
def _written() -> Any:
    way, seed = sympy.symbols("way seed")
    told = roughness_at(way, {"seed": seed, "correlation_length": 1.0})
    return sympy.lambdify((way, seed), told, "numpy")


def surface(ways: NDArray[np.float64], seed: float) -> NDArray[np.float64]:
    """r for a correlation length of 1 m."""
    return np.asarray(_written()(ways, seed))


def test_the_surface_has_the_variance_and_the_correlation_that_it_states() -> None:
    ways = np.arange(400) * WAVE / 400
    drawn = np.array([surface(ways, seed) for seed in range(300)])
    along = np.array([np.mean(drawn * np.roll(drawn, -k, axis=1), axis=1) for k in range(128)])
    expected = np.exp(-(ways[:128] ** 2) / 2)
    assert np.abs(along - expected[:, None]).max() < 0.005  # of each one, up to 8 lengths
    assert np.abs(drawn.mean(axis=1)).max() < 1e-12 and np.abs(drawn).max() <= HIGHEST
    # Over seeds, each place is drawn anew: within four standard errors of mean 0 and variance 1.
    assert np.abs(drawn.mean(axis=0)).max() < 4 / 300**0.5
    assert np.abs(drawn.var(axis=0) - 1).max() < 4 * (2 / 300) ** 0.5


def test_a_seed_is_one_motion_and_none_is_that_of_the_smooth_surface() -> None:
    def end(law: str = ROUGH, **changes: float) -> NDArray[np.float64]:
        begun = motion("belt-1dof", law, {}, **{**PULLED, **changes})
        begun.run(30.0)
        return begun.y

    first = end()
    assert np.array_equal(first, end()) and np.abs(first - end(seed=5.0)).max() > 1e-3
    smooth = {"roughness": 0.0, "seed": 9.0}
    np.testing.assert_allclose(end(**smooth), end("hysteretic", **smooth), atol=1e-11)


def test_the_motion_is_that_of_the_equations_typed_apart() -> None:
    p = PULLED | {"v": 2.0, "m": 1.0, "k": 1.0}

    def rates(t: float, y: NDArray[np.float64]) -> list[float]:
        x, x_dot, late = y
        v = p["v"] - x_dot
        (r,) = surface(np.array([(p["v"] * t - x) / p["correlation_length"]]), p["seed"])
        g = exp(-v / p["v_s"]) + p["roughness"] * r
        above = (1 + np.tanh((v - late) / p["tau"] / p["a_0"])) / 2
        rising = p["mu_s"] + p["Delta_mu_s"] / (1 + v / p["v_s"]) - p["mu_k"]
        falling = p["mu_s"] - p["mu_k"]
        friction = (p["mu_k"] + (rising * above - falling * (1 - above)) * g) * p["N"]
        return [x_dot, friction - p["c"] * x_dot - p["k"] * x, (v - late) / p["tau"]]

    begun = motion("belt-1dof", ROUGH, {}, **p)
    begun.run(20.0)
    apart = solve_ivp(rates, (0.0, 20.0), np.zeros(3), "DOP853", rtol=1e-11, atol=1e-12)
    np.testing.assert_allclose(begun.y, apart.y[:, -1], atol=1e-8)


def test_at_a_steady_slip_the_mean_of_friction_is_that_of_the_smooth_surface() -> None:
    speed = 0.4
    heavy = GIVEN | {"m": 1e15, "k": 0.0, "v": speed, "N": 5.0}
    begun = motion("belt-1dof", ROUGH, {"late_velocity": speed}, **heavy)
    times = np.arange(1, 257) * WAVE * GIVEN["correlation_length"] / speed / 256
    samples = samples_at(begun.system, times)
    begun.run(times[-1], samples=samples)
    forces, swing = samples.forces[:, 0, 1], 0.1 / (1 + speed / 0.2) / 2
    assert np.mean(forces) == pytest.approx((0.3 + swing * exp(-speed / 0.2)) * 5.0, rel=1e-9)
    assert np.std(forces) == pytest.approx(GIVEN["roughness"] * swing * 5.0, rel=1e-8)


def test_stick_bears_what_the_place_bears_and_friction_takes_energy() -> None:
    given = PULLED | {"v": 0.4}
    begun = motion("belt-1dof", ROUGH, {}, **given)
    samples = samples_at(begun.system, np.linspace(0.01, 60.0, 6000))
    begun.run(60.0, samples=samples)
    forces, slips = samples.forces[:, 0, 1], samples.forces[:, 0, 2]
    assert np.all(forces * slips >= 0.0)
    times, before, _, _, _ = ledger(begun).T
    released = times[before == CODE_STICK]
    assert len(released) > 5
    capacities = []
    for at in released[1:]:
        near = np.searchsorted(samples.times, at) - 1  # while it sticks the place is the same
        way = given["v"] * samples.times[near] - samples.states[near, 0]
        (r,) = surface(np.array([way / GIVEN["correlation_length"]]), GIVEN["seed"])
        capacities.append((0.3 + 0.2 * (1 + GIVEN["roughness"] * r)) * 5.0)
        stuck = slice(near - 1, near + 1)
        assert slips[near] == 0.0
        reached = forces[near] + (at - samples.times[near]) * np.diff(forces[stuck])[0] / 0.01
        assert reached == pytest.approx(capacities[-1], rel=1e-4)
    assert np.ptp(capacities) > 0.1


def test_the_energy_balance_closes_on_a_rough_surface() -> None:
    assert booked(motion("pin-on-disc", ROUGH, {}, roughness=0.3), 0.5).residual < 1e-10


@pytest.mark.parametrize("speed", [1.0, -0.6])
def test_a_slide_has_the_period_at_which_the_drive_passes_a_wavelength(speed: float) -> None:
    given = GIVEN | {"correlation_length": 0.05, "c": 0.2, "v": speed, "N": 1.0}
    found = api.analyse("belt-1dof", ROUGH, "response", **given)
    assert found.values["attractor"] == "periodic"
    assert found.values["period"] == pytest.approx(WAVE * 0.05 / abs(speed), rel=1e-8)


def test_two_belts_of_speeds_without_a_common_period_are_not_computed() -> None:
    case = {
        "schema": 1,
        "title": "rough",
        "model": {"name": "belt-2mass", "parameters": {"v": 1.0}},
        "friction": {"law": ROUGH},
        "grid": {"v2": [1.0, 2.0**0.5]},
        "analysis": [{"kind": "history", "t_end": 1.0}],
    }
    found = api.run(api.load(case))
    assert api.names_of(found["reason"]).values.ravel().tolist() == ["none", "no_common_period"]


def test_what_does_not_know_its_place_is_refused() -> None:
    case = {
        "schema": 1,
        "title": "ramp",
        "model": {"name": "belt-1dof"},
        "friction": {"law": ROUGH},
        "schedule": {"v": {"start": 1.0, "stop": 0.0, "over": 5.0}},
        "analysis": [{"kind": "history", "t_end": 1.0}],
    }
    with pytest.raises(CaseError, match="surface that 'v' moves"):
        api.load(case)


def _sideways(symbols: Any, options: Options) -> Equations:
    """A belt that runs the faster, the further out the mass is."""
    found = get_model("belt-1dof").equations(symbols, options)
    (contact,) = found.contacts
    faster = contact.slip_velocity + symbols.coordinate("x")
    return replace(found, contacts=(replace(contact, slip_velocity=faster),))


def _its_own(symbols: Any, options: Options) -> Equations:
    """A belt that is rough whatever the case says."""
    found = get_model("belt-1dof").equations(symbols, options)
    told = {name: sympy.Float(value) for name, value in get_law(ROUGH).defaults.items()}
    own = replace(found.contacts[0], law=ROUGH, law_parameters=told)
    return replace(found, contacts=(own,))


def test_a_contact_that_is_rough_of_itself_is_refused() -> None:
    model: Model = replace(get_model("belt-1dof"), equations=_its_own)
    with pytest.raises(UsageError, match="varies along the surface"):
        system(model)


def test_a_contact_whose_way_is_no_function_of_the_state_is_refused() -> None:
    model: Model = replace(get_model("belt-1dof"), equations=_sideways)
    with pytest.raises(UsageError, match="how far this contact has slid"):
        system(model, ROUGH)
