"""Motions that never stick: which decaying slides count as the equilibrium, and which not."""

from __future__ import annotations

from math import pi
from typing import Any

import pytest

from fiv_cli.analyses.base import Outcome, Section, Start
from fiv_cli.api import analyse, load, names_of, run

# Bilateral and stiff (thesis 6.4.2.2): below the critical 1.735 a stable equilibrium and a large
# motion are both there.
STIFF = {"k_nl": 1e7, "F": 800.0, "k4": 5e6, "k5": 5e6, "k6": 5e6, "mu_k": 1.5}
TURNING = Section("zero", state="x1_dot", direction="up")
EVENT = Section("event")


def slide(offset: float, section: Section, t_max: float) -> Outcome:
    """The bilateral model from an offset of x1 (m) off its equilibrium."""
    start = Start("a", "equilibrium", {"x1": offset})
    settings: dict[str, Any] = {"section": section, "t_max": t_max}
    slip = {"states": "slip"}
    return analyse("belt-5dof", "coulomb", "response", start, settings, options=slip, **STIFF)


@pytest.mark.parametrize("section", [EVENT, TURNING])
def test_a_slide_near_the_equilibrium_is_known_long_before_it_arrives(section: Section) -> None:
    """At a decay of 0.05 1/s arriving takes some 200 s, and halving, which is asked for, 14 s."""
    found = slide(1e-3, section, 400.0)
    assert found.values["attractor"] == "equilibrium" and found.values["L_s"] == 0.0
    assert 14.0 < found.values["transient_used"] < 25.0


@pytest.mark.parametrize(("section", "reason"), [(EVENT, "slide_not_decided"), (TURNING, None)])
def test_a_slide_far_out_does_not_end_at_the_stable_equilibrium(
    section: Section, reason: str | None
) -> None:
    found = slide(0.3, section, 20.0)
    assert found.values["attractor"] != "equilibrium"
    assert found.values["L_s"] > 0.01
    assert reason is None or found.reason == reason
    assert reason is None or "lyapunov" not in found.values  # in 20 s it is that of the start


def test_stick_slip_that_died_is_seen_through_a_section_at_velocity_zero() -> None:
    """Many section points a second are no events."""
    turning = {"section": Section("zero", state="x_dot", direction="both")}
    start = Start("a", "equilibrium", {"x": 0.5})
    found = analyse("belt-1dof", "coulomb", "response", start, turning, c=0.05)
    assert found.values["attractor"] == "equilibrium"
    assert found.values["transient_used"] < 40.0


@pytest.mark.parametrize("speed", [0.5, 1.0])
@pytest.mark.parametrize("load", [5.0, 10.0])
@pytest.mark.parametrize("turns", [0.0, 1 / 3, 2 / 3])
def test_a_slide_over_a_sector_is_periodic_after_few_turns_whatever_their_rounding(
    speed: float, load: float, turns: float
) -> None:
    """Between two sectors the strongly damped pin comes to rest, and its section to 1e-16."""
    sector = {"beta": pi / 36, "psi_a": 2 * pi * turns}
    pin = {"Omega": speed, "N0": load, "c1": 0.01, "c2": 0.01}
    asked = {"section": Section("event", event="slip->stick"), "observe": "phi", "t_max": 100.0}
    start = {"phi_dot": speed}
    found = analyse("pin-on-disc", "coulomb", "response", start, asked, **sector, **pin)
    assert (found.values["attractor"], found.values["stick_fraction"]) == ("periodic", 0.0)
    assert found.values["period"] == pytest.approx(2 * pi / speed, rel=1e-12)
    assert found.values["cycle_residual"] < 1e-12 and found.values["floquet_multiplier"].max() < 0.1


def test_a_swinging_speed_leaves_a_slide_alone_where_there_is_no_sector() -> None:
    """Other friction in a sector of no width is met nowhere."""
    case = load(
        {
            "schema": 1,
            "model": {"name": "pin-on-disc", "parameters": {"Omega": 5.0, "beta": 0.0}},
            "schedule": {"Omega": {"amplitude": 0.2, "omega": 5.0}},
            "initial": [{"kind": "equilibrium", "offset": {"phi": 1e-4}}],
            "analysis": [{"kind": "response"}],
        }
    )
    assert names_of(run(case, workers=1)["attractor"]).item() == "equilibrium"
