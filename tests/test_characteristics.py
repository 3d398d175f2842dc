"""What the laws make of a slip that is stated: loops, limits, work, break-away."""

from __future__ import annotations

from math import pi, tanh
from typing import Any

import numpy as np
import pytest

from fiv_cli import api
from fiv_cli.errors import CaseError
from fiv_cli.friction import TANH_OF, all_laws, why_unfit
from fiv_cli.models import get_model

MU, SIGMA_0, LOAD = 0.3, 1e3, 2.0
BEND = MU / SIGMA_0  # deflection in steady sliding, m
BELT = get_model("belt-1dof")
LAWS = [
    n for n, law in all_laws().items() if not n.startswith(TANH_OF) and not why_unfit(BELT, law)
]


def loop(law: str, amplitude: float, **given: Any) -> dict[str, Any]:
    """The law under a slip of this amplitude and a load of `LOAD`."""
    names = ("omega", "drift", "periods", "samples", "load")
    asked = {"amplitude": amplitude, "load": LOAD}
    asked |= {name: given.pop(name) for name in names if name in given}
    found = api.analyse(BELT, law, "characteristic", None, asked, **given)
    assert found.status == "ok"
    return found.values


def test_coulomb_friction_takes_four_mu_k_N_A_in_a_period_and_holds_mu_s_N() -> None:
    found = loop("coulomb", 0.5, mu_k=MU, mu_s=0.4, omega=3.0)
    assert found["loop_work"] == pytest.approx(4.0 * MU * LOAD * 0.5, rel=1e-12)
    assert found["static_capacity"] == 0.4 * LOAD
    np.testing.assert_allclose(found["slip"], -0.5 * np.cos(3.0 * found["time"]), atol=1e-9)


@pytest.mark.parametrize("amplitude", [0.1 * BEND, BEND, 10.0 * BEND])
def test_the_pre_sliding_loop_of_dahl_has_the_area_of_the_closed_form(amplitude: float) -> None:
    """4 mu N (A - g tanh(A/g)), g = mu/sigma_0: of the order A^3 where it hardly slides."""
    area = 4.0 * MU * LOAD * (amplitude - BEND * tanh(amplitude / BEND))
    periods = 2 + round(4.0 * BEND / amplitude)  # the start is forgotten over the slip mu/sigma_0
    for omega in (1.0, 30.0):  # it does not depend on the rate
        found = loop("dahl", amplitude, mu_k=MU, sigma_0=SIGMA_0, omega=omega, periods=periods)
        assert found["loop_work"] == pytest.approx(area, rel=1e-5)
    last = found["deflection"][-1000:]
    assert np.max(last) == pytest.approx(BEND * tanh(amplitude / BEND), rel=1e-4)


@pytest.mark.parametrize(
    ("law", "steepness", "values", "order", "others"),
    [
        ("tanh of coulomb", "sigma", (50.0, 100.0, 200.0), 2.0, {}),
        ("dahl", "sigma_0", (1e2, 2e2, 4e2), 1.0, {}),
        ("lugre", "sigma_0", (1e2, 2e2, 4e2), 1.0, {"mu_s": MU, "sigma_1": 0.0}),
        ("simscape", "v_brk", (0.4, 0.2, 0.1), 2.0, {"mu_s": MU, "F_V": 0.0}),
        ("elasto-plastic", "sigma_0", (1e2, 2e2, 4e2), 1.0, {"mu_s": MU, "sigma_1": 0.0}),
        ("linear-regularisation", "v_tol", (0.1, 0.05, 0.025), 2.0, {}),
    ],
)
def test_steep_laws_tend_to_coulomb_under_a_stated_slip(
    law: str, steepness: str, values: tuple[float, ...], order: float, others: dict[str, float]
) -> None:
    """Work that is not done while slip turns round: bristles bend, or slip is in the layer."""
    exact = 4.0 * MU * LOAD
    works = [loop(law, 1.0, mu_k=MU, **{steepness: v}, **others)["loop_work"] for v in values]
    errors = exact - np.array(works)
    assert np.all(errors > 0.0)
    assert np.log2(errors[:-1] / errors[1:]) == pytest.approx(order, abs=0.02)


def test_regularised_work_falls_short_by_the_closed_form() -> None:
    """4 mu N A pi^2/(24 sigma^2 v^2), v = A omega, at leading order."""
    sigma, amplitude, omega = 200.0, 0.5, 2.0
    found = loop("tanh of coulomb", amplitude, mu_k=MU, sigma=sigma, omega=omega)
    missing = 4.0 * MU * LOAD * amplitude - found["loop_work"]
    closed = 4.0 * MU * LOAD * amplitude * pi**2 / (24.0 * (sigma * amplitude * omega) ** 2)
    assert missing == pytest.approx(closed, rel=1e-3)


@pytest.mark.parametrize("law", LAWS)
def test_friction_takes_energy_in_every_period(law: str) -> None:
    """Also where it falls with the slip speed, and about a mean one."""
    one_way = law == "rate-and-state"  # it is for slip that does not turn round
    for drift in (0.3, 0.3 if one_way else 0.0):
        assert loop(law, 0.2, drift=drift)["loop_work"] > 0.0


@pytest.mark.parametrize(("sigma_1", "passive"), [(10.0, True), (1e4, False)])
def test_lugre_is_passive_where_its_docstring_says_so(sigma_1: float, passive: bool) -> None:
    """sigma_1^2 |v| <= 4 g (sigma_1 + sigma_2), over every stretch but for the bristles' energy.

    Beyond, slip that begins fast on bristles bent against it is driven by their damping.
    """
    given = {"mu_s": 0.4, "mu_k": MU, "v_s": 0.1, "sigma_0": SIGMA_0, "sigma_1": sigma_1}
    found = loop("lugre", 0.01, omega=10.0, load=1.0, samples=4000, **given)
    velocity, bent = found["slip_dot"], found["deflection"]
    steady = MU + (0.4 - MU) * np.exp(-((velocity / 0.1) ** 2))
    promised = sigma_1 * np.abs(velocity) <= 4.0 * steady
    assert bool(np.all(promised)) == passive
    taken = np.cumsum(found["F_T"] * velocity) * (found["time"][1] - found["time"][0])
    gained = taken - SIGMA_0 * (bent**2 - bent[0] ** 2) / 2.0
    assert bool(np.all(np.diff(gained) > -1e-9)) == passive


def test_break_away_is_less_under_a_load_that_grows_faster() -> None:
    """From mu_s N to mu_k N (Canudas de Wit et al. 1995): there is no time for the static value."""
    given = {"mu_s": 1.5, "mu_k": 1.0, "v_s": 1e-3, "N": 1.0, "m": 1.0, "k": 2.0}
    bristles = {"sigma_0": 1e5, "sigma_1": 1e5**0.5, "sigma_2": 0.4}
    broken = []
    for rate in (0.1, 1.0, 10.0, 50.0):  # N/s: the spring is pulled at rate/k
        asked, pull = {"t_end": 2.0 / rate, "sample": 1e-3 / rate}, rate / given["k"]
        held = {"x_dot": pull}
        found = api.analyse(BELT, "lugre", "history", held, asked, v=pull, **given, **bristles)
        broken.append(np.max(found.values["F_T"]))
    assert broken == pytest.approx([1.5, 1.43, 1.22, 1.0], abs=0.02)


def test_friction_lags_behind_the_velocity() -> None:
    """Higher while slip speeds up than while it slows down; a law without states does not lag."""
    given = {"mu_s": 0.6, "mu_k": MU, "v_s": 0.1, "drift": 0.11, "omega": 10.0, "samples": 64}
    bent = loop("lugre", 0.01, sigma_0=50.0, sigma_1=0.0, periods=3, **given)["F_T"]
    at_once = loop("stribeck", 0.01, delta=2, periods=3, **given)["F_T"]
    speeding, slowing = 2 * 64, 2 * 64 + 32  # both at the velocity of the drift
    assert bent[speeding] > bent[slowing] + 0.05
    assert at_once[speeding] == pytest.approx(at_once[slowing], rel=1e-9)


def test_rate_and_state_has_the_logarithmic_slope_in_steady_slip() -> None:
    """(a - b) ln v: the work of a slow loop about a mean velocity is that of its mean."""
    given = {"mu_0": 0.6, "a_rate": 0.01, "b_state": 0.015, "D_c": 1e-5, "v_0": 1e-2}
    found = loop("rate-and-state", 0.1, drift=0.2, load=1.0, samples=64, **given)
    steady = 0.6 - 0.005 * np.log(found["slip_dot"] / 1e-2)
    np.testing.assert_allclose(found["F_T"][64:], steady[64:], rtol=1e-4)


def printed(velocity: Any, rising: Any, more: float) -> Any:
    """Thesis 2.9 and 2.10, g = exp(-|v|/0.5), over the normal force; 2.6 where `more` is zero."""
    speed = np.abs(velocity)
    fall = np.exp(-speed / 0.5)
    upper = MU + (0.4 + more / (1.0 + speed / 0.5) - MU) * fall
    return np.sign(velocity) * np.where(rising, upper, MU - (0.4 - MU) * fall)


@pytest.mark.parametrize(("law", "rise"), [("stefanski", {}), ("hysteretic", {"Delta_mu_s": 0.2})])
def test_laws_of_the_acceleration_tend_to_the_printed_ones_as_the_contact_is_late_by_less(
    law: str, rise: dict[str, float]
) -> None:
    """With the sign of the acceleration, at first order but for where slip turns."""
    given = {"mu_s": 0.4, "mu_k": MU, "v_s": 0.5, "a_0": 1e-4, "omega": 2.0, "samples": 8000}
    missing = []
    for tau in (0.04, 0.02, 0.01):
        found = loop(law, 0.5, tau=tau, load=1.0, **given, **rise)
        velocity = found["slip_dot"]
        rising = velocity * np.cos(2.0 * found["time"]) > 0.0
        wrong = np.abs(printed(velocity, rising, rise.get("Delta_mu_s", 0.0)) - found["F_T"]) > 1e-3
        missing.append(np.mean(wrong[8000:]))
        assert found["loop_work"] > 0.0
    assert np.log2(np.array(missing[:-1]) / missing[1:]) == pytest.approx(1.0, abs=0.1)


@pytest.mark.parametrize("law", ["jenkins", "linear-regularisation", "stribeck", "stefanski"])
def test_loops_are_drawn(law: str) -> None:
    """By the sense of slip; the pieces of a law, which its ledger holds, are no contact states."""
    case = {
        "schema": 1,
        "model": {"name": "belt-1dof"},
        "friction": {"law": law},
        "analysis": [{"kind": "characteristic", "amplitude": 0.1}],
        "figure": [{"kind": "phase", "x": "slip_dot", "y": "F_T"}],
    }
    (ax,) = api.figure(api.run(api.load(case))).axes
    held = [line for line in ax.lines if line.get_linestyle() == "--"]
    sticks = law in ("stribeck", "stefanski")
    assert len(held) == sticks
    colours = {tuple(c.get_colors()[0]) for c in ax.collections}
    assert len(colours) == 1 + sticks  # the others have no border at zero slip
    bare = case | {"figure": [{"kind": "phase"}]}
    (loop,) = api.figure(api.run(api.load(bare))).axes
    assert (loop.get_xlabel(), loop.get_ylabel()) == ("$s$ (m)", "$F_T$ (N)")
    case["figure"][0]["y"] = "F_X"
    with pytest.raises(CaseError, match="did you mean 'F_T'"):
        api.load(case)
