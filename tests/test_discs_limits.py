"""Where discs end or should not matter: jamming, critical speeds, scale and number of modes."""

from __future__ import annotations

import itertools

import numpy as np
import pytest
from disc_reference import RigidContact
from motions import defaults, motion, system

from fiv_cli.analyses.base import SolverSettings, Varied
from fiv_cli.api import analyse
from fiv_cli.dynamics.motion import Stop
from fiv_cli.flags import REASONS
from fiv_cli.models import get_model
from fiv_cli.models.base import Options
from fiv_cli.plate import mode

RIGID = "disc-rigid-contact"
LAWS = {RIGID: "exponential", "disc-nonlinear-contact": "coulomb", "excited-disc": "exponential"}
SEVEN = "0,0 0,1 0,2 0,3"
SETS = (SEVEN, f"{SEVEN} 0,4 0,5 0,6", f"{SEVEN} 0,4 0,5 0,6 0,7 0,8 1,0 1,1 1,2 1,3 1,4 1,5")


def rough(mu: float) -> dict[str, float]:
    """A friction coefficient that does not fall with speed."""
    return {"mu_0": mu, "mu_k": mu, "mu_s": mu}


# --- jamming --------------------------------------------------------------------------------------
@pytest.mark.parametrize(("mu", "jams"), [(20.0, False), (100.0, True)])
def test_sliding_up_a_steep_disc_jams_where_the_determinant_is_negative(
    mu: float, jams: bool
) -> None:
    """1/m + sum R^2/M - mu w_theta / (m r0) divides the normal force (saddle-point system)."""
    start = {"C_0_1": 0.005, "phi": -1.2}
    other = RigidContact(defaults(RIGID, "exponential", **rough(mu)))
    y = other.state({**start, "z": 0.005 * np.cos(1.2)})
    response = (other.pressed(y) + mu * other.dragged(y)) / other.masses()
    assert (float(other.gradient(y) @ response) < 0.0) == jams
    begun = motion(RIGID, "exponential", start, **rough(mu))
    assert (begun.run(1e-3) == Stop.JAMMED) == jams


def test_a_jammed_response_says_why_and_what_to_do() -> None:
    found = analyse(
        RIGID, "exponential", "response", {"C_0_1": 0.005, "phi": -1.2}, {"t_max": 1.0},
        **rough(100.0),
    )  # fmt: skip
    assert (found.status, found.reason) == ("failed", "jammed")
    (reason,) = (one for one in REASONS if one.name == "jammed")
    assert "lower mu" in reason.advice


# --- critical speeds ------------------------------------------------------------------------------
@pytest.mark.parametrize("model", LAWS)
def test_a_critical_speed_inside_a_bracket_ends_the_equilibrium(model: str) -> None:
    """There is none at that one speed, and none beyond where the contact would have to pull."""
    table, parameters = get_model(model), defaults(model, LAWS[model])
    assert table.derived is not None
    speed = table.derived.values(parameters, table.default_options())["omega_0_2"] / 2
    settings = {
        "parameter": Varied("Omega"), "bracket": (0.98 * speed, 1.005 * speed),
        "system": "original",
    }  # fmt: skip
    found = analyse(model, LAWS[model], "critical", None, settings)
    assert (found.status, found.reason) == ("ok", "no_equilibrium_in_part")
    ends = found.values["crossing_kind"] == "end"
    assert found.values["critical_value"][ends][0] == pytest.approx(speed, rel=1e-12)
    assert found.values["crossing_direction"][ends][0] == "lost"
    assert np.all(np.diff(found.values["critical_value"]) >= 0.0)


# --- scale of mode shapes -------------------------------------------------------------------------
@pytest.mark.parametrize("scale", [-250.0, 1e-3, 1.0])
def test_the_scale_of_mode_shapes_does_not_matter(scale: float) -> None:
    """Shapes and modal masses in another scale give the same accelerations, phi, z and w."""
    from disc_reference import shapes

    start = {"phi": 0.3, "phi_dot": 2.0, "C_0_1": 1e-4, "D_0_2": 2e-4, "C_0_0_dot": 0.3}
    other = RigidContact(defaults(RIGID, "exponential"))
    other.modes = shapes(other.p, scale)
    other.radius = np.array([one.radius for one in other.modes])
    other.modal_masses = np.array([one.mass for one in other.modes])
    y = other.state({**start, "z": -1.0})
    expected = other.values(other.slip(1.0).rate(0.0, y))
    begun = motion(RIGID, "exponential", start)
    assert begun.y == pytest.approx(other.values(y), rel=1e-12, abs=1e-14)
    assert begun.rates() == pytest.approx(expected, rel=1e-10, abs=1e-9)


# --- number of modes ------------------------------------------------------------------------------
def pressed(modes: str) -> float:
    """F_N at rest: N0 / (1 + k_z S), S = sum R^2/(M (omega^2 - l^2 Omega^2)) over the modes."""
    p = defaults(RIGID, "exponential")
    disc, total = get_model(RIGID), 0.0
    assert disc.derived is not None
    numbers = disc.derived.values(p, {"modes": modes})
    for pair in modes.split():
        k, n = pair.split(",")
        stiffness = numbers[f"omega_{k}_{n}"] ** 2 - (int(n) * p["Omega"]) ** 2
        total += numbers[f"mobility_{k}_{n}"] / stiffness
    return p["N0"] / (1 + p["k_z"] * total)


@pytest.mark.parametrize("modes", [SEVEN, f"{SEVEN} 0,4"])
def test_the_equilibrium_is_the_closed_form_with_any_modes(modes: str) -> None:
    options: Options = {"modes": modes}
    found = analyse(RIGID, "exponential", "equilibrium", options=options).values
    assert found["F_N"][0] == pytest.approx(pressed(modes), rel=1e-12)


def test_the_equilibrium_converges_with_the_number_of_modes() -> None:
    """7, 13 and 25 real modes: the change is some 1 %, then less."""
    values = [pressed(modes) for modes in SETS]
    changes = [abs(b / a - 1.0) for a, b in itertools.pairwise(values)]
    assert changes[0] < 0.02
    assert changes[1] < changes[0]


@pytest.mark.campaign
def test_fifty_modes_are_generated_compiled_and_move() -> None:
    """A text so large that LLVM takes its quick way; the equilibrium is the closed form."""
    from fiv_cli.plate import AnnularPlate

    plate = AnnularPlate(0.044, 0.12, 0.002, 7200.0, 150e9, 0.211)
    pairs = [(k, n) for k in range(3) for n in range(13)]
    lowest = sorted(pairs, key=lambda pair: mode(plate, *pair).frequency)[:27]
    modes = " ".join(f"{k},{n}" for k, n in sorted(lowest))
    built = system(RIGID, "exponential", {"modes": modes}, 1e-9)
    assert len(built.coordinates) > 50
    solver = SolverSettings(rtol=1e-9)
    begun = motion(RIGID, "exponential", {"C_0_1": 1e-4}, solver, {"modes": modes})
    assert begun.run(0.02) == Stop.REACHED
    assert begun.n_events > 0
    found = analyse(RIGID, "exponential", "equilibrium", None, None, solver, {"modes": modes})
    assert found.values["F_N"][0] == pytest.approx(pressed(modes), rel=1e-10)
