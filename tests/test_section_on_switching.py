"""A section on the switching surface: the velocity that passes zero is the slip velocity."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st
from motions import motion, times, transitions

from fiv_cli.analyses.base import SolverSettings
from fiv_cli.api import analyse, load, names_of, run
from fiv_cli.dynamics.motion import Stop
from fiv_cli.dynamics.settings import Section

LOOSE = SolverSettings(rtol=1e-9)
STEPWISE = SolverSettings("rk4", 1e-9, 1e-2)
LAWS = {
    "coulomb": {"mu_s": 0.6, "mu_k": 0.3},
    "stribeck": {"mu_s": 0.6, "mu_k": 0.2},
    "hyperbolic": {},
}
# On ground at rest slip is positive where the velocity is negative.
FROM = {"up": ("slip+->",), "down": ("slip-->",), "both": ("slip+->", "slip-->")}


def over_ground(law: str, force: float, frequency: float, solver: Any) -> Any:
    """A mass on a spring, pulled to and fro over ground at rest."""
    drive = {"v": 0.0, "N": 1.0, "u0": force, "omega": frequency}
    return motion("belt-1dof", law, {"x": 0.2}, solver, **LAWS[law], **drive)


@pytest.mark.parametrize("solver", [LOOSE, STEPWISE], ids=["taylor", "rk4"])
@pytest.mark.parametrize("direction", ["up", "down", "both"])
@settings(max_examples=12)
@given(law=st.sampled_from(sorted(LAWS)), force=st.floats(0.5, 3.0), frequency=st.floats(0.15, 3.0))
@example(law="coulomb", force=0.65, frequency=0.4)
@example(law="stribeck", force=1.59, frequency=1.75)
@example(law="hyperbolic", force=0.51, frequency=2.78)
def test_every_stop_is_one_point(
    solver: Any, direction: str, law: str, force: float, frequency: float
) -> None:
    """Where it comes to rest and where it reverses, once, whatever follows."""
    section = Section("zero", state="x_dot", direction=direction)
    points = np.zeros(400), np.zeros((400, 2))
    begun = over_ground(law, force, frequency, solver)
    assert begun.run(60.0, section, points) == Stop.REACHED
    stops = [
        time
        for time, word in zip(times(begun), transitions(begun), strict=True)
        if word.startswith(FROM[direction])
    ]
    np.testing.assert_array_equal(points[0][: begun.n_sections], stops)
    assert not points[1][: begun.n_sections, 1].any()


@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize(("force", "frequency"), [(0.8, 0.6), (1.6, 1.75), (2.0, 0.9)])
def test_the_class_is_that_of_the_stroboscopic_section(
    law: str, force: float, frequency: float
) -> None:
    """Both sections see the same cycle, which sticks or not."""
    drive = {"v": 0.0, "N": 1.0, "u0": force, "omega": frequency, "c": 0.1}
    found = [
        analyse("belt-1dof", law, "response", {"x": 0.2}, {"section": section}, LOOSE,
                **LAWS[law], **drive)
        for section in (Section("zero", state="x_dot", direction="down"), Section("phase"))
    ]  # fmt: skip
    zero, strobe = (outcome.values for outcome in found)
    assert zero["attractor"] == strobe["attractor"] == "periodic"
    assert zero["period"] == pytest.approx(strobe["period"], rel=1e-7)
    assert zero["x_max"] == pytest.approx(strobe["x_max"], rel=1e-5)


@pytest.mark.parametrize("force", [0.8, 1.6])
def test_newton_finds_the_cycle_from_such_a_section(force: float) -> None:
    drive = {"v": 0.0, "N": 1.0, "u0": force, "omega": 0.6, "c": 0.1}
    section = Section("zero", state="x_dot", direction="down")
    found = analyse(
        "belt-1dof", "coulomb", "cycle", {"x": 0.2}, {"section": section}, LOOSE,
        **LAWS["coulomb"], **drive,
    )  # fmt: skip
    assert found.reason == ""
    assert found.values["cycle_period"] == pytest.approx(2 * np.pi / 0.6, rel=1e-9)


def test_a_motion_that_begins_along_its_section_goes_on() -> None:
    """From an equilibrium a mass is thrown across its coordinate: the velocity and acceleration of
    that are zero, the one exactly, the other to rounding, and time went on by 1e-21 s a step."""
    case = {
        "schema": 1,
        "model": {
            "name": "flutter-2dof",
            "parameters": {
                "m": 0.1,
                "k1": 1e6,
                "k2": 5e5,
                "k3": 6e5,
                "c1": 20.0,
                "c2": 0.5,
                "F": 100.0,
                "alpha1": "30 deg",
                "alpha2": "45 deg",
                "v": 0.5,
            },
            "options": {"states": "all", "impact": "none"},
        },
        "grid": {"mu_k": [0.329, 0.336, 0.337, 0.352, 0.38, 0.408, 0.432, 0.451, 0.472, 0.497]},
        "initial": [{"kind": "equilibrium", "offset": {"y_dot": 1.0}}],
        "analysis": [{"kind": "response", "t_max": 3.0, "observe": "x"}],
        "solver": {"max_steps": 100_000},
    }
    found = run(load(case), workers=1)
    assert set(names_of(found["status"]).values.ravel()) == {"ok"}
    assert set(names_of(found["attractor"]).values.ravel()) == {"periodic"}


def test_what_follows_a_long_stick_is_on_no_section() -> None:
    """A stick is one step of a second; over as long a step the series of the slip that follows, at
    a fifth of a hundredth of that, is so large that its velocity was zero beside it."""
    at = {"k1": 1.0, "k2": 0.6, "k3": 1.0, "alpha1": np.pi / 4, "alpha2": 0.0, "c1": 0.098}
    at |= {"c2": 0.002, "v": 0.02, "mu_s": 0.8, "v_s": 0.007, "mu_k": 0.46}
    start = {"x": 2.72, "y": -0.38}
    options = {"states": "all", "impact": "none"}
    begun = motion("flutter-2dof", "stribeck", start, LOOSE, options, **at)
    section = Section("zero", state="x_dot", direction="down")
    points = np.zeros(400), np.zeros((400, 4))
    assert begun.run(400.0, section, points) == Stop.REACHED and begun.n_sections > 20
    alone = motion("flutter-2dof", "stribeck", start, LOOSE, options, **at)
    for time in points[0][: begun.n_sections]:
        alone.run(time)
        assert abs(alone.y[2]) < 1e-6
