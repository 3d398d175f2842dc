"""Amplitudes over time and frequency."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from motions import TIGHT, defaults, system

from fiv_cli.analyses import get_analysis
from fiv_cli.analyses.base import Outcome, Request, SolverSettings, Start
from fiv_cli.analyses.execute import answer
from fiv_cli.cli.main import run
from fiv_cli.errors import UsageError
from fiv_cli.fourier import HANN_BANDWIDTH, short_time
from fiv_cli.plots import drawing


# --- the transform --------------------------------------------------------------------------------
def test_a_line_shows_the_amplitude_of_a_sinusoid_while_it_lasts() -> None:
    t = np.arange(10_000) * 1e-3
    late = np.where(t >= 5.0, 0.5 * np.sin(2 * np.pi * 120 * t), 0.0)
    found = short_time(7.0 + 3.0 * np.sin(2 * np.pi * 50 * t) + late, 1e-3, 0.5, 0.125)
    np.testing.assert_allclose(found.time, 0.25 + 0.125 * np.arange(77), atol=1e-12)
    assert found.amplitude.shape == (77, 251)
    early, after = found.time <= 4.75, found.time >= 5.25
    np.testing.assert_allclose(found.amplitude[early | after, 25], 3.0, rtol=1e-12)
    np.testing.assert_allclose(found.amplitude[after, 60], 0.5, rtol=1e-12)
    np.testing.assert_allclose(found.amplitude[early, 60], 0.0, atol=1e-12)
    np.testing.assert_allclose(found.mean[early], 7.0, rtol=1e-12)
    assert not found.amplitude[:, 0].any()


def test_noise_keeps_its_power() -> None:
    values = np.random.default_rng(1).normal(0.0, 2.0, 2**16)
    found = short_time(values, 0.01, 2**10 * 0.01, 2**9 * 0.01)
    power = np.mean(np.sum(found.amplitude**2, axis=1)) / HANN_BANDWIDTH / 2.0
    assert power == pytest.approx(4.0, rel=0.02)


@pytest.mark.parametrize("window", [0.02, 101.0])
def test_a_window_fits_the_samples(window: float) -> None:
    with pytest.raises(ValueError, match="does not fit"):
        short_time(np.zeros(10_000), 0.01, window, 1.0)


# --- the analysis ---------------------------------------------------------------------------------
def belt(
    curves: dict[str, list[tuple[float, float]]],
    settings: dict[str, float],
    start: dict[str, float],
    solver: SolverSettings = TIGHT,
    **changes: float,
) -> Outcome:
    """Spectrogram of a belt that always slips, with scheduled parameters."""
    parameters = defaults("belt-1dof", "coulomb", v=1e6, **changes)
    setup = system("belt-1dof", curves=curves).setup
    filled = get_analysis("spectrogram").default_settings | settings
    begin = Start("a", "state", start)
    return answer(Request(setup, parameters, "spectrogram", filled, solver, begin))


def test_a_constant_oscillation_has_its_amplitude_and_mean_all_the_time() -> None:
    """x'' + k x = mu_k N from 2 m beside the mean: 5 Hz."""
    k = (2 * np.pi * 5.0) ** 2
    rest = 0.23 * 10.0 / k
    settings = {"f_max": 20.0, "resolution": 1.0}
    found = belt({"m": [(0.0, 1.0), (10.0, 1.0)]}, settings, {"x": rest + 2.0}, k=k).values
    np.testing.assert_allclose(found["time"], 2.0 + np.arange(7), atol=1e-9)
    np.testing.assert_array_equal(found["frequency"], np.arange(21.0))
    np.testing.assert_allclose(found["spectrogram"][:, 5], 2.0, rtol=1e-8)
    assert np.max(np.delete(found["spectrogram"], 5, axis=1)) < 1e-6
    np.testing.assert_allclose(found["mean"], rest, atol=1e-9)
    np.testing.assert_array_equal(found["m"], 1.0)
    assert found["energy_residual"] < 1e-9


def test_the_frequency_follows_a_stiffness_that_grows() -> None:
    low, high = (2 * np.pi * 5.0) ** 2, (2 * np.pi * 15.0) ** 2
    settings = {"f_max": 25.0, "resolution": 1.0, "window": 2.0, "hop": 0.5}
    curves = {"k": [(0.0, low), (60.0, high)]}
    found = belt(curves, settings, {"x": 1.0}).values
    peak = found["frequency"][np.argmax(found["spectrogram"], axis=1)]
    expected = np.sqrt(low + (high - low) * found["time"] / 60.0) / (2 * np.pi)
    assert len(peak) == 117
    assert np.max(np.abs(peak - expected)) < 0.5 + 0.25  # half a bin and half a line
    # the action k^(1/2) x^2 of a slowly varying oscillator is kept
    size = np.sqrt(np.sum(found["spectrogram"] ** 2, axis=1))
    action = size**2 * np.sqrt(found["k"])
    assert np.ptp(action) / np.mean(action) < 0.01


def test_a_window_longer_than_the_motion_is_an_answer() -> None:
    found = belt({"v": [(0.0, 1e6), (3.0, 1e6)]}, {"f_max": 25.0, "resolution": 1.0}, {})
    assert (found.status, found.reason) == ("failed", "window_too_long")


def test_what_ends_early_is_not_known_after_it() -> None:
    settings = {"f_max": 2.0, "resolution": 0.2, "t_end": 400.0}
    short = replace(TIGHT, max_steps=200)
    found = belt({"m": [(0.0, 1.0)]}, settings, {"x": 1.0}, solver=short)
    assert (found.status, found.reason) == ("budget", "too_many_steps")
    known = np.isfinite(found.values["spectrogram"]).all(axis=1)
    assert known[0] and not known[-1]
    assert np.array_equal(known, np.sort(known)[::-1])


# --- through the shell ----------------------------------------------------------------------------
CASE = """\
schema = 1
title = "A belt that slows down"
[model]
name = "belt-1dof"
[schedule]
v = { start = 1.5, stop = 0.5, over = 200.0 }
[[analysis]]
kind = "spectrogram"
f_max = 0.5
resolution = 0.05
[[analysis]]
kind = "history"
t_end = 200.0
sample = 0.1
"""


def test_datasets_and_figures(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    Path("a.toml").write_text(CASE)
    assert run(["run", "a.toml", "--workers", "1", "-q"]) == 0
    with xr.open_dataset("runs/a.nc", group="spectrogram") as dataset:
        assert dataset["spectrogram"].dims == ("initial", "time", "frequency")
        assert dataset["spectrogram"].attrs["units"] == "m"
        assert dataset["v"].dims == ("initial", "time")
    figures = drawing.figures_of("runs/a.nc")
    assert [figure.kind for figure in figures if figure.settings["analysis"] == "spectrogram"] == [
        "spectrogram"
    ]
    stored = next(figure for figure in figures if figure.kind == "spectrogram")
    for settings in (stored.settings, {"analysis": "history", "resolution": 0.1}):
        figure = drawing.draw("runs/a.nc", type(stored)("x", "spectrogram", settings))
        axes, bar = figure.axes
        (mesh,) = axes.collections
        assert mesh.get_array().count() > 50
        assert bar.get_ylabel().startswith("amplitude of")
    wrong = type(stored)("x", "spectrogram", {"analysis": "history", "resolution": 1e-4})
    with pytest.raises(UsageError, match="resolution"):
        drawing.draw("runs/a.nc", wrong)


def test_a_spectrogram_without_a_window_is_not_drawn(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("a.toml").write_text(CASE.partition('[[analysis]]\nkind = "history"')[0])
    failed = ["run", "a.toml", "--workers", "1", "-q", "--set", "analysis.0.resolution=0.001"]
    assert run([*failed, "-o", "a.nc"]) == 4
    (stored,) = drawing.figures_of("a.nc")
    with pytest.raises(UsageError, match="nothing to draw"):
        drawing.draw("a.nc", stored)
