"""Laws whose stick is a band of slip velocities: closed forms, and how they tend to exact stick."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from motions import motion, system, times
from numpy.typing import NDArray
from scipy.optimize import brentq

from fiv_cli.dynamics.motion import Stop
from fiv_cli.errors import UsageError
from fiv_cli.models import get_model
from fiv_cli.models.base import Equations, Model, Options

STUCK_ON = {"v": 0.4, "mu_s": 0.6, "mu_k": 0.3, "N": 5.0}
MOST, LEAST = 3.0, 1.5  # N: what holds, and slides


def _crept(alpha: float, time: float) -> float:
    """By how far slip goes that dies out from 1 m/s, or stays."""
    return float(-np.expm1(-alpha * time)) / alpha if alpha else time


@pytest.mark.parametrize(("law", "alpha"), [("switch", 3.0), ("karnopp", 0.0)])
def test_a_band_is_left_and_met_when_closed_forms_say(law: str, alpha: float) -> None:
    """Undamped, m = k = 1: slip dies out or stays, then two harmonic motions."""
    eta, v, t_end = 0.01, 0.4, 40.0
    given = {"alpha": alpha} if alpha else {}
    begun = motion("belt-1dof", law, {"x": 1.0, "x_dot": v}, eta=eta, **STUCK_ON, **given)
    begun.run(t_end)
    expected, x, left = [0.0], 1.0, 0.0
    while expected[-1] < t_end:
        begin, slipping = x, left
        held = brentq(
            lambda s, x=begin, left=slipping: x + v * s - left * _crept(alpha, s) - MOST,
            *(0.0, 20.0), xtol=1e-15,
        )  # fmt: skip
        slip, x = left * np.exp(-alpha * held), MOST
        expected.append(expected[-1] + held)
        if slip < 0.999 * eta:  # it yields, about x = MOST
            turned = np.arccos((v - eta) / (v - slip))
            x += (v - slip) * np.sin(turned)
            expected.append(expected[-1] + turned)
        out = x - LEAST  # it slides, about x = LEAST, until it is as fast again
        expected.append(expected[-1] + 2 * np.pi - 2 * np.arctan2(out, v - eta))
        x, left = LEAST - out, eta
    met = [at for at in expected[1:] if at < t_end]
    assert len(met) > 7
    np.testing.assert_allclose(times(begun), met, atol=1e-9)


@pytest.mark.parametrize(
    ("law", "mu_k", "u0", "order"),
    [
        ("switch", 0.3, 2.0, 0.5),
        ("switch", 0.6, 2.0, 1.0),
        ("karnopp", 0.3, 2.0, 0.5),  # let go against the way it slid
        ("karnopp", 0.3, 0.0, 1.0),  # ... along it
    ],
)
def test_a_band_tends_to_exact_stick(law: str, mu_k: float, u0: float, order: float) -> None:
    """By how much a motion that sticks on the way is off, as the band shrinks to a 16th of it."""
    shaken = STUCK_ON | {"mu_k": mu_k, "c": 0.1, "u0": u0, "omega": 0.9}

    def end(name: str, **changes: float) -> NDArray[np.float64]:
        begun = motion("belt-1dof", name, {"x": 1.0}, **shaken, **changes)
        assert begun.run(12.0) == Stop.REACHED
        return begun.y

    exact = end("coulomb")
    errors = [np.abs(end(law, eta=eta) - exact).max() for eta in (1.6e-3, 1e-4, 6.25e-6)]
    measured = np.log(np.divide(errors[:-1], errors[1:])) / np.log(16.0)
    assert measured == pytest.approx([order, order], abs=0.05)


def _between(symbols: Any, options: Options) -> Equations:
    """A mass that two belts press on."""
    found = get_model("belt-1dof").equations(symbols, options)
    second = symbols.tangential_force(1) / symbols.parameter("m")
    accelerations = {"x": found.accelerations["x"] + second}
    return replace(found, accelerations=accelerations, contacts=found.contacts * 2)


def test_contacts_that_act_on_one_another_do_not_know_what_is_demanded_of_each() -> None:
    model: Model = replace(get_model("belt-1dof"), equations=_between, contacts=2)
    with pytest.raises(UsageError, match="what would hold contact 1 alone"):
        system(model, "switch")
