"""Amplitudes over frequency: closed-form Fourier coefficients, Parseval, and what has none."""

from __future__ import annotations

from math import atan, pi, sqrt
from typing import Any

import numpy as np
import pytest
from motions import TIGHT, defaults, system

from fiv_cli.analyses.base import Start
from fiv_cli.analyses.spectra.amplitudes import growing_modes, on_bins, period_lines, window_lines
from fiv_cli.analyses.spectra.resolution import frequencies
from fiv_cli.api import analyse

BINS = {"f_max": 2.0, "resolution": 0.01, "window": None}
T_STICK, T_SLIP = 3.4, pi + 2.0 * atan(1.0 / 1.7)


def coefficient(n: int) -> complex:
    """Fourier coefficient of x of the stick-slip cycle (N = 10, mu_s - mu_k = .17, m = k = v = 1).

    Stick: x = 0.6 + t; slip, from t = 0 again: x = 2.3 + Re((1.7 - i) exp(i t)).
    """
    period = T_STICK + T_SLIP
    w = 2.0 * pi * n / period
    turned = np.exp(-1j * w * T_STICK)
    stick = (1.0 - turned) / (1j * w)
    ramp = (turned * (1j * w * T_STICK + 1.0) - 1.0) / w**2
    total = 0.6 * stick + ramp
    total += 2.3 * turned * (1.0 - np.exp(-1j * w * T_SLIP)) / (1j * w)
    for factor, speed in (((1.7 - 1j) / 2.0, 1.0), ((1.7 + 1j) / 2.0, -1.0)):
        rate = 1j * (speed - w)
        total += turned * factor * (np.exp(rate * T_SLIP) - 1.0) / rate
    return complex(total / period)


@pytest.mark.parametrize(("observe", "power"), [("x", 0), ("x_dot", 1)])
def test_lines_of_a_stick_slip_cycle_are_its_fourier_coefficients(observe: str, power: int) -> None:
    found = analyse("belt-1dof", "coulomb", "spectrum", {}, BINS | {"observe": observe}, TIGHT)
    amplitude, first = found.values["amplitude"], 1.0 / (T_STICK + T_SLIP)
    for n in range(1, 15):
        expected = 2.0 * abs(coefficient(n)) * (2.0 * pi * n * first) ** power
        assert amplitude[round(n * first / 0.01)] == pytest.approx(expected, rel=2e-6, abs=1e-9)
    assert np.count_nonzero(amplitude) == 15  # lines up to 2.005 Hz, nothing between them
    assert found.values["response_frequency"] == pytest.approx(first, rel=1e-12)
    assert found.values["mean"] == pytest.approx(2.3 * (1 - power), abs=1e-8)


def test_half_the_sum_of_squares_is_the_mean_square() -> None:
    settings = BINS | {"f_max": 100.0, "resolution": 0.5}  # several lines in a bin
    found = analyse("belt-1dof", "coulomb", "spectrum", {}, settings, TIGHT).values
    measured = analyse("belt-1dof", "coulomb", "response", {}, {}, TIGHT).values
    total = found["mean"] ** 2 + 0.5 * np.sum(found["amplitude"] ** 2)
    assert total == pytest.approx(measured["x_rms"] ** 2, rel=1e-9)
    assert found["variance_shown"] == pytest.approx(1.0, abs=1e-9)


def test_a_forced_motion_has_lines_at_multiples_of_its_period() -> None:
    found = analyse(
        "belt-1dof", "coulomb", "spectrum", {}, BINS | {"f_max": 1.0}, u0=0.5, omega=0.85
    ).values
    lines = np.flatnonzero(found["amplitude"]) * 0.01
    np.testing.assert_allclose(lines, 0.85 / (2 * pi) * np.arange(1, 8), atol=0.005)


def test_a_window_shows_sinusoids_with_their_amplitudes() -> None:
    """Neither fits the window, and the second lies between two bins of the transform."""
    length, settings = 40.0, {"f_max": 10.0, "resolution": 0.5}
    time = length * np.arange(2**13) / 2**13
    motion = 7.0 + 2.0 * np.sin(2 * pi * 3.013 * time) + 0.3 * np.cos(2 * pi * 6.4871 * time + 1.0)
    found = on_bins(window_lines(motion, length), settings)
    assert found["amplitude"][6] == pytest.approx(2.0, rel=1e-4)
    assert found["amplitude"][13] == pytest.approx(0.3, rel=1e-3)
    assert found["response_frequency"] == pytest.approx(3.013, abs=1e-4)
    assert found["mean"] == pytest.approx(7.0, abs=0.02)
    assert 0.5 * np.sum(found["amplitude"] ** 2) == pytest.approx(2.0 + 0.045, rel=1e-3)


def test_a_window_shows_noise_with_its_power() -> None:
    values = np.random.default_rng(1).normal(0.0, 1.5, 2**14)
    found = on_bins(window_lines(values, 16.0), {"f_max": 600.0, "resolution": 1.0})
    assert 0.5 * np.sum(found["amplitude"] ** 2) == pytest.approx(1.5**2, rel=0.05)
    part = on_bins(window_lines(values, 16.0), {"f_max": 256.0, "resolution": 1.0})
    assert part["variance_shown"] == pytest.approx(0.5, abs=0.03)


@pytest.mark.parametrize("first", [3.4875, 3.5125])
def test_the_frequency_told_is_that_of_the_larger_of_two_sinusoids(first: float) -> None:
    """Though an edge of a bin splits it between two."""
    time = 40.0 * np.arange(2**13) / 2**13
    motion = np.sin(2 * pi * first * time + 1.0) + 0.75 * np.sin(2 * pi * 7.0 * time)
    found = on_bins(window_lines(motion, 40.0), {"f_max": 10.0, "resolution": 1.0})
    assert found["response_frequency"] == pytest.approx(first, abs=1e-3)


@pytest.mark.parametrize("exact", [True, False])
def test_the_frequency_told_is_that_of_the_largest_bin(exact: bool) -> None:
    """A bin of three lines may hold more than one that is the largest of all."""
    time = 40.0 * np.arange(2**13) / 2**13
    waves = {3.0: 1.0, 3.1: 1.1, 3.2: 1.0, 7.0: 1.4}
    motion = sum(size * np.sin(2 * pi * f * time + f) for f, size in waves.items())
    lines = period_lines(motion, 40.0) if exact else window_lines(motion, 40.0)
    found = on_bins(lines, {"f_max": 10.0, "resolution": 1.0})
    assert np.argmax(found["amplitude"]) == 3
    assert found["response_frequency"] == pytest.approx(3.1, abs=0.01)


def test_nothing_that_moves_has_no_frequency() -> None:
    for lines in (period_lines(np.ones(64), 1.0), window_lines(np.ones(64), 1.0)):
        found = on_bins(lines, {"f_max": 10.0, "resolution": 1.0})
        assert np.max(found["amplitude"]) < 1e-15 and found["mean"] == 1.0
        assert found["variance_shown"] == 1.0 or not np.isnan(found["response_frequency"])


@pytest.mark.parametrize(
    ("settings", "count", "last"),
    [
        ({"f_max": 64.0, "resolution": None}, 257, 64.0),
        ({"f_max": 1.0, "resolution": 0.1}, 11, 1.0),
        ({"f_max": 1.0, "resolution": 0.3}, 4, 0.9),
    ],
)
def test_bins_reach_up_to_the_highest_frequency(settings: Any, count: int, last: float) -> None:
    grid = frequencies(settings)
    assert (len(grid), grid[0]) == (count, 0.0)
    assert grid[-1] == pytest.approx(last)


def test_a_chaotic_motion_is_windowed() -> None:
    """Its lines carry the variance that the response measures, within its own scatter."""
    settings = {"f_max": 1.0, "resolution": 0.01, "t_max": 6000.0}
    found = analyse("belt-2mass", "stribeck", "spectrum", {}, settings, D=0.1)
    measured = analyse("belt-2mass", "stribeck", "response", {}, {"t_max": 6000.0}, D=0.1)
    assert found.values["attractor"] == measured.values["attractor"] == "chaotic"
    assert "period" not in found.values and found.carry is not None
    total = found.values["mean"] ** 2 + 0.5 * np.sum(found.values["amplitude"] ** 2)
    assert total == pytest.approx(measured.values["x1_rms"] ** 2, rel=0.05)


# --- what has none --------------------------------------------------------------------------------
def test_at_rest_every_amplitude_is_zero() -> None:
    near = Start("near", "equilibrium", {"x": 1e-3})
    found = analyse("belt-1dof", "coulomb", "spectrum", near, BINS, c=0.1)
    assert found.values["attractor"] == "equilibrium"
    assert not np.any(found.values["amplitude"])
    assert found.values["mean"] == pytest.approx(2.3)
    assert "response_frequency" not in found.values


@pytest.mark.parametrize(
    ("model", "options", "changes"),
    [
        ("belt-5dof", {}, {"mu_k": 2.5}),
        ("belt-5dof", {"geometry": "linear"}, {"mu_k": 2.5}),
        ("belt-5dof", {"contact_stiffness": "linear"}, {"mu_k": 1.6}),
        ("flutter-2dof", {}, {"mu_k": 5.0, "mu_s": 5.0}),
    ],
)
def test_unbounded_growth_is_an_answer_without_a_spectrum(
    model: str, options: dict[str, str], changes: dict[str, float]
) -> None:
    """Bilateral contact beyond the critical friction (thesis 6.4.2.2, 3.2.1)."""
    slip = options | {"states": "slip"}
    near = Start("near", "equilibrium", {"x1" if model == "belt-5dof" else "x": 1e-4})
    for kind in ("response", "spectrum"):
        never_met = {"section": {"event": "slip->stick"}}  # points of another would end steps
        settings = never_met | (BINS if kind == "spectrum" else {})
        found = analyse(model, "coulomb", kind, near, settings, options=slip, **changes)
        assert (found.status, found.reason) == ("ok", "diverged")
        assert found.values["attractor"] == "diverged" and found.carry is None
        assert found.values["n_steps"] < 100_000
    assert "amplitude" not in found.values
    assert np.any(found.values["unstable_frequency"] > 0.0)


# --- eigenfrequencies -----------------------------------------------------------------------------
def test_the_growing_mode_of_flutter_has_the_frequency_at_which_modes_meet() -> None:
    """Undamped, beyond mu_c = 5/2 + sqrt 3: s^2 = -2 +- i b, and s^4 + 4 s^2 + 4 + b^2 = 0."""
    built, critical = system("flutter-2dof"), 2.5 + sqrt(3.0)
    below = growing_modes(built, defaults("flutter-2dof", "coulomb", mu_k=critical - 1e-3))
    assert np.all(np.isnan(below["unstable_frequency"]))
    above = growing_modes(built, defaults("flutter-2dof", "coulomb", mu_k=critical + 1e-8))
    growing = above["unstable_frequency"][np.isfinite(above["unstable_frequency"])]
    np.testing.assert_allclose(growing, sqrt(2.0) / (2 * pi), rtol=1e-6)
    assert np.max(above["mode_growth"]) > 0.0
