"""The averaged system: the law against its integral, the Jacobian against the printed one."""

from __future__ import annotations

from collections.abc import Callable
from math import asin, cos, pi, sin, sqrt

import numpy as np
import pytest
import sympy
from motions import defaults, system
from scipy.integrate import quad

from fiv_cli.analyses.rest import averaging
from fiv_cli.analyses.rest.equilibria import equilibria
from fiv_cli.analyses.rest.linearisation import sliding_system
from fiv_cli.api import analyse
from fiv_cli.friction import all_laws, get_law
from fiv_cli.friction.averaged import FAST_VELOCITY, averaged
from fiv_cli.friction.base import Slip
from fiv_cli.models import all_models

MODEL = "excited-2dof"
DISC = "excited-disc"
# mu_k is not mu_0: else nothing falls with the speed.
VALUES = {"mu_k": 0.4, "mu_s": 0.8, "mu_0": 0.7, "alpha": 1.3}
AVERAGED_LAWS = [law.name for law in all_laws().values() if law.average is not None]


def average_at(name: str, v: float, amplitude: float, **changes: float) -> tuple[float, float]:
    """Averaged friction of a law with N = 1, and its slope, at one slip velocity."""
    law = averaged(get_law(name), amplitude > abs(v))
    symbol = sympy.Symbol("v", real=True)
    slip = Slip(v=symbol, sign=int(np.sign(v)), speed=int(np.sign(v)) * symbol, N=1)
    values = VALUES | changes | {FAST_VELOCITY.name: amplitude}
    force = sympy.sympify(law.force(slip, values))
    return float(force.subs(symbol, v)), float(sympy.diff(force, symbol).subs(symbol, v))


def integral_at(name: str, v: float, amplitude: float, **changes: float) -> float:
    """The same average by adaptive quadrature, split where the fast slip reverses."""
    law, symbol = get_law(name), sympy.Symbol("v", real=True)

    def of_one_sign(sign: int) -> Callable[[float], float]:
        slip = Slip(v=symbol, sign=sign, speed=sign * symbol, N=1)
        return sympy.lambdify(symbol, law.force(slip, VALUES | changes))

    ways = {sign: of_one_sign(sign) for sign in (-1, 1)}

    def force(phase: float) -> float:
        fast = v + amplitude * cos(phase)
        return ways[1 if fast > 0.0 else -1](fast)

    corner = pi - np.arccos(min(1.0, v / amplitude)) if amplitude > abs(v) else pi / 2
    ends = ((0.0, corner), (corner, pi))
    return sum(quad(force, *two, epsabs=1e-13, epsrel=1e-12, limit=500)[0] for two in ends) / pi


@pytest.mark.parametrize("name", AVERAGED_LAWS)
@pytest.mark.parametrize("amplitude", [1e-3, 0.29, 0.31, 1.0, 50.0])
@pytest.mark.parametrize("v", [0.3, -0.3])
def test_an_averaged_law_is_its_integral(name: str, amplitude: float, v: float) -> None:
    found, slope = average_at(name, v, amplitude)
    assert found == pytest.approx(integral_at(name, v, amplitude), rel=1e-12, abs=1e-13)
    step = 1e-5
    rise = integral_at(name, v + step, amplitude) - integral_at(name, v - step, amplitude)
    assert slope == pytest.approx(rise / (2.0 * step), rel=1e-5, abs=1e-7)


@pytest.mark.parametrize("v", [0.0, 1e-3, -0.9, 0.9999, 1.0, 1.5])
@pytest.mark.parametrize("alpha", [0.0, 1e-3, 10.0, 100.0])
def test_the_averaged_exponential_law_by_any_fall(v: float, alpha: float) -> None:
    found = average_at("exponential", v, 1.0, alpha=alpha)[0]
    assert found == pytest.approx(integral_at("exponential", v, 1.0, alpha=alpha), abs=2e-13)


@pytest.mark.parametrize("v", [0.0, -0.3, 0.999])
def test_slope_of_the_averaged_exponential_law(v: float) -> None:
    """2 mu_0/(pi sqrt(U^2 - V^2)) from the jump, and the mean slope of what is smooth."""
    alpha = VALUES["alpha"]

    def smooth(phase: float) -> float:
        return -alpha * (VALUES["mu_0"] - VALUES["mu_k"]) * np.exp(-alpha * abs(v + cos(phase)))

    corner = float(np.arccos(-v))
    mean = sum(quad(smooth, *ends, epsabs=1e-13)[0] for ends in ((0.0, corner), (corner, pi))) / pi
    jump = 2.0 * VALUES["mu_0"] / (pi * sqrt(1.0 - v**2))
    assert average_at("exponential", v, 1.0)[1] == pytest.approx(jump + mean, rel=1e-12)


def test_without_a_fall_the_averaged_exponential_law_is_coulombs() -> None:
    for amplitude in (0.2, 0.5):
        same = average_at("coulomb", 0.3, amplitude, mu_k=VALUES["mu_0"])
        found = average_at("exponential", 0.3, amplitude, alpha=0.0)
        assert found == pytest.approx(same, rel=1e-14)


def test_limits_of_the_averaged_coulomb_law() -> None:
    """A fast motion that reverses slip makes dry friction viscous; a small one does nothing."""
    assert average_at("coulomb", 0.3, 0.2999) == (0.4, 0.0)
    assert average_at("coulomb", 0.3, 0.3) == (0.4, 0.0)
    force, slope = average_at("coulomb", 0.3, 3e5)
    assert force == pytest.approx(2.0 / pi * 0.4 * 1e-6, rel=1e-11)
    assert slope == pytest.approx(2.0 / pi * 0.4 / 3e5, rel=1e-11)


def test_only_models_of_one_contact_are_averaged() -> None:
    """The fast slip velocity is that of the contact."""
    for model in all_models().values():
        assert model.averaged_forcing() is None or model.contacts == 1


# --- the Jacobian of the thesis -------------------------------------------------------------------
def printed_jacobian(mu: float, v: float, u: float) -> np.ndarray:
    """5.15 with -2 zeta a_2 in the entry (2, 4), at m = k1 = 1; u stands for omega_1 C_b.

    States x, x', y, y' as printed.
    """
    alpha1, alpha2, eta2, eta3, zeta, preload = pi / 6, pi / 4, 0.5, 0.5, 0.0005, 2.0
    a1, a3 = cos(alpha1) ** 2 + cos(alpha2) ** 2, sin(alpha1) ** 2 + sin(alpha2) ** 2
    a2 = -sin(alpha1) * cos(alpha1) + sin(alpha2) * cos(alpha2)
    a4 = cos(alpha1) ** 2 + eta2 * cos(alpha2) ** 2
    a5 = -sin(alpha1) * cos(alpha1) + eta2 * sin(alpha2) * cos(alpha2)
    a6 = sin(alpha1) ** 2 + eta2 * sin(alpha2) ** 2 + eta3
    share = 1.0 if v >= u else 2.0 / pi * asin(v / u)
    stiffness = np.array([[a4, a5 + share * mu * eta3], [a5, a6]])
    y_e = np.linalg.solve(stiffness, [0.0, -preload])[1]
    viscous = 0.0 if v >= u else 2.0 * mu / (pi * sqrt(u**2 - v**2)) * eta3 * y_e
    return np.array(
        [
            [0, 1, 0, 0],
            [-a4, -2 * zeta * a1 + viscous, -stiffness[0, 1], -2 * zeta * a2],
            [0, 0, 0, 1],
            [-a5, -2 * zeta * a2, -a6, -2 * zeta * a3],
        ]
    )


@pytest.mark.parametrize("mu", [0.4, 0.7])
@pytest.mark.parametrize("u", [0.0, 0.1, 0.3, 0.3001, 0.4, 1.75, 30.0])
def test_the_averaged_jacobian_is_the_printed_one(mu: float, u: float) -> None:
    parameters = defaults(MODEL, "coulomb", mu_k=mu, A_b=20.0 * u)
    state = sliding_system(system(MODEL), parameters, "averaged")
    jacobian = state.jacobian(equilibria(state)[0])
    printed = printed_jacobian(mu, 0.3, u)[np.ix_([0, 2, 1, 3], [0, 2, 1, 3])]
    np.testing.assert_allclose(jacobian, printed, rtol=1e-12, atol=1e-14)


def test_without_excitation_the_averaged_system_is_the_original_one() -> None:
    original = analyse(MODEL, "coulomb", "eigenvalues").values
    found = analyse(MODEL, "coulomb", "eigenvalues", None, {"system": "averaged"}).values
    np.testing.assert_array_equal(found["eigenvalue_real"], original["eigenvalue_real"])
    np.testing.assert_array_equal(found["eigenvalue_imag"], original["eigenvalue_imag"])


def test_the_averaged_equilibrium_carries_less_friction() -> None:
    settings = {"system": "averaged"}
    found = analyse(MODEL, "coulomb", "equilibrium", None, settings, A_b=8.0).values
    share = 2.0 / pi * asin(0.3 / 0.4)
    assert found["F_T"][0] == pytest.approx(share * 0.4 * found["F_N"][0], rel=1e-14)
    assert found["residual"][0] < 1e-14


@pytest.mark.parametrize(("ratio", "reason"), [(5.4, "averaging_invalid"), (5.6, "")])
def test_a_slow_excitation_is_no_fast_one(ratio: float, reason: str) -> None:
    """The highest natural frequency at these values is 1.1 omega_1; the answer is given all the
    same."""
    changes = {"R": ratio, "A_b": 1.75 * ratio}
    settings = {"system": "averaged"}
    found = analyse(MODEL, "coulomb", "eigenvalues", None, settings, **changes)
    assert (found.status, found.reason) == ("ok", reason)
    assert (found.values["averaging_ratio"] < averaging.LEAST_RATIO) == bool(reason)


def test_the_averaged_motion_is_what_remains_of_the_excited_one() -> None:
    """The mean of the excited response tends to the averaged equilibrium as R grows."""
    amplitude = 1.75  # A_b / R: the excitation stabilises
    averaged_x = analyse(
        MODEL, "coulomb", "equilibrium", None, {"system": "averaged"}, A_b=amplitude * 40.0, R=40.0
    ).values["equilibrium"][0]
    start = {"x": float(averaged_x[0]), "y": float(averaged_x[1]), "x_dot": -amplitude}
    settings = {"t_end": 40.0, "sample": 0.01}
    changes = {"A_b": amplitude * 40.0, "R": 40.0}
    found = analyse(MODEL, "tanh of coulomb", "history", start, settings, **changes).values
    slow = slice(-1572, None)  # a hundred periods of the excitation
    assert np.mean(found["x"][slow]) == pytest.approx(averaged_x[0], abs=1e-3)
    assert np.mean(found["y"][slow]) == pytest.approx(averaged_x[1], abs=1e-3)


# --- the slider on a disc -------------------------------------------------------------------------
@pytest.mark.parametrize("amplitude", [0.0, 9e3, 2e4, 1e6])
def test_the_averaged_equilibrium_on_a_disc_carries_the_averaged_friction(amplitude: float) -> None:
    """U = A / (m R omega_cr), omega_cr being half the frequency of the mode (0, 2)."""
    settings = {"system": "averaged"}
    found = analyse(DISC, "exponential", "equilibrium", None, settings, A=amplitude).values
    known = system(DISC, "exponential").known(defaults(DISC, "exponential"))
    fast = amplitude / (22.0 * known["omega_0_2"] / 2.0)
    law = {"mu_k": 1.2, "mu_0": 1.5, "mu_s": 1.5, "alpha": 1.0}
    share = integral_at("exponential", 0.5, fast, **law) if fast else average_at_rest(0.5, **law)
    assert found["F_T"][0] == pytest.approx(share * found["F_N"][0], rel=1e-10)
    assert found["complete"] == "certified"
    assert found["residual"][0] < 1e-10


def average_at_rest(v: float, mu_0: float, mu_k: float, mu_s: float, alpha: float) -> float:
    return mu_k + (mu_0 - mu_k) * float(np.exp(-alpha * v))


def test_the_averaged_jacobian_on_a_disc_is_the_slope_of_its_rates() -> None:
    """Central differences of the rates, friction falling with the speed and turned around."""
    parameters = defaults(DISC, "exponential", A=2e4, xi=2e-4)
    built = system(DISC, "exponential")
    known = {**parameters, **built.known(parameters)}
    state = sliding_system(built, known, "averaged")
    at = equilibria(state)[0]
    jacobian = state.jacobian(at)
    for column in range(len(at)):
        step = np.zeros(len(at))
        step[column] = 1e-6 * (1e-3 if column < len(at) // 2 else 1.0)
        difference = (state.rates(at + step) - state.rates(at - step)) / (2.0 * step[column])
        scale = max(1.0, float(np.max(np.abs(jacobian[:, column]))))
        np.testing.assert_allclose(jacobian[:, column] / scale, difference / scale, atol=1e-5)


@pytest.mark.parametrize(("mu_s", "mu_k", "amplitude"), [(1.5, 1.2, 2e4), (2.25, 2.0, 5e4)])
def test_the_excitation_of_figure_5_10_suppresses(
    mu_s: float, mu_k: float, amplitude: float
) -> None:
    """Both cases of Figure 5.9 are unstable, and stable at the printed amplitudes."""
    law = {"mu_s": mu_s, "mu_k": mu_k, "xi": 2e-4}
    settings = {"system": "averaged"}
    for force, expected in ((0.0, "unstable"), (amplitude, "stable")):
        found = analyse(DISC, "exponential", "eigenvalues", None, settings, A=force, **law)
        assert (found.values["stable"], found.reason) == (expected, "")


@pytest.mark.parametrize(("ratio", "reason"), [(15.4, "averaging_invalid"), (15.5, "")])
def test_fast_against_the_highest_mode_of_the_disc(ratio: float, reason: str) -> None:
    """5 times 2774 rad/s (of the disc, stiffened by the contact) over 911.9 rad/s."""
    settings = {"system": "averaged"}
    found = analyse(DISC, "exponential", "eigenvalues", None, settings, R=ratio, A=2e4, xi=2e-4)
    assert (found.status, found.reason) == ("ok", reason)
