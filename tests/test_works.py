"""Works of each force: over a period, from section point to section point, at rest."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from test_stops import STOPPED

from fiv_cli import api

EACH = {"powers": "each"}
PERIODIC: dict[str, tuple[Any, dict[str, float], dict[str, Any], dict[str, float]]] = {
    "two masses": ("belt-2mass", {"x1": 1.0}, {}, {}),
    "force and base": (
        "belt-1dof + force_x + base", {"x": 4.0}, {"section": {"phase": 0.0}},
        {"c": 0.1, "A_x": 2.0, "omega_x": 0.8, "F_x": 0.3, "A_base": 0.2},
    ),
    "impacts": (
        STOPPED, {"x_dot": 0.4}, {},
        {"ahead": 0.5, "e": 0.8, "v": 0.4, "N": 1.0, "mu_k": 0.2, "mu_s": 0.8},
    ),
    "pin": ("pin-on-disc", {"phi_dot": 2.0}, {}, {}),
}  # fmt: skip


@pytest.mark.parametrize("name", PERIODIC)
def test_over_a_period_works_add_up_to_nothing_and_those_of_parts_to_the_whole(name: str) -> None:
    model, start, settings, given = PERIODIC[name]
    found = api.analyse(model, None, "response", start, settings | EACH, **given)
    v, r = found.values, found.ragged
    assert v["attractor"] == "periodic"
    assert v["friction_work"] + v["other_work"] == pytest.approx(v["impact_work"], abs=1e-7)
    assert v["drive_work"] == pytest.approx(v["friction_work"] + v["wear_work"])
    for part in ("friction", "wear"):
        parts = [v[n] for n in v if n.startswith(f"{part}_") and n[-6].isdigit()]
        assert sum(parts, start=0.0 if parts else v[f"{part}_work"]) == pytest.approx(
            v[f"{part}_work"], abs=1e-9
        )
    excited = sum(v[n] for n in ("force_x_work", "base_work") if n in v)
    assert v["damping_work"] + excited == pytest.approx(v["other_work"], abs=1e-9)
    assert (v["damping_work"] < 0.0) == (name != "impacts") == (v["impact_work"] == 0.0)
    for work in [n for n in v if n.endswith("_work")]:
        assert len(r[f"section_{work}"]) == len(r["section_value"]) == v["multiplicity"]
        assert np.sum(r[f"section_{work}"]) == pytest.approx(v[work], abs=1e-12)
        assert v[f"mean_{work.removesuffix('_work')}_power"] * v["period"] == pytest.approx(v[work])


def test_nothing_else_changes_where_works_are_asked_for() -> None:
    asked = "belt-2mass", "stribeck", "response", {"x1": 1.0}
    without, told = (api.analyse(*asked, settings) for settings in ({"powers": "mean"}, EACH))
    np.testing.assert_equal({n: told.values[n] for n in without.values}, without.values)


def test_work_of_a_force_against_friction_is_that_of_den_hartog() -> None:
    """The mass never stops: friction takes 4 f X a cycle, which the force has put in."""
    friction, amplitude = 0.5, 1.4865816
    found = api.analyse(
        "belt-1dof + force_x", "coulomb", "response", {"x": 1.0},
        {"section": {"phase": 0.0}} | EACH,
        v=0.0, N=1.0, mu_k=friction, mu_s=friction, A_x=1.0, omega_x=0.6,
    ).values  # fmt: skip
    assert found["friction_work"] == pytest.approx(-4 * friction * amplitude, abs=1e-7)
    assert found["force_x_work"] == pytest.approx(4 * friction * amplitude, abs=1e-7)
    assert found["wear_work"] == pytest.approx(-found["friction_work"], abs=1e-12)
    assert found["damping_work"] == found["drive_work"] == 0.0


def test_what_sliding_wears_is_load_times_coefficient_times_way() -> None:
    """A mass that slides is no sink: what the belt puts in wears, mu_k N v a second."""
    found = api.analyse("belt-1dof", None, "response", {}, EACH, c=0.1, v=3.0).values
    assert found["attractor"] == "equilibrium" and "wear_work" not in found
    assert found["mean_wear_power"] == found["mean_drive_power"] == pytest.approx(0.23 * 10 * 3.0)


def test_wear_between_section_points_of_chaos_is_that_of_the_way_slipped() -> None:
    """mu_k N (v T - x): the belt slips by what the mass does not go along, and never back."""
    v, omega = 0.5, 1.45
    found = api.analyse(
        "belt-1dof + force_x", "coulomb", "response", {},
        {"section": {"phase": 0.0}, "t_max": 1000.0} | EACH, A_x=1.5, omega_x=omega, v=v,
    )  # fmt: skip
    assert found.values["attractor"] == "chaotic" and found.values["x_dot_max"] <= v + 1e-12
    x, wear = found.ragged["section_value"], found.ragged["section_wear_work"]
    assert np.isfinite(wear).all() and len(wear) == len(x) > 50
    way = v * 2 * np.pi / omega - np.diff(x)
    np.testing.assert_allclose(wear[1:], 2.3 * way, atol=1e-8)
    assert "wear_work" not in found.values
