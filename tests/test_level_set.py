"""What slides to an equilibrium: level sets against closed forms and long motions."""

from __future__ import annotations

from math import hypot, log
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from motions import defaults, system
from small_models import DOUBLE_WELL

from fiv_cli.analyses.attractor import descent as descent_kernels
from fiv_cli.analyses.attractor.descent import Descent
from fiv_cli.analyses.attractor.grounds import AGREEMENT, FALLEN
from fiv_cli.analyses.attractor.level_set import LevelSet, level_sets, under_excitation
from fiv_cli.analyses.base import Section, Start
from fiv_cli.analyses.rest.equilibria import equilibria, sliding
from fiv_cli.analyses.rest.linearisation import free_jacobian
from fiv_cli.api import analyse

DAMPING = 0.05
STRIBECK = {"c": 0.1, "N": 1.0, "mu_s": 1.0, "mu_k": 0.5, "v_s": 0.5, "v": 1.5}


def levels(model: Any, law: str, number: int = 1, **changes: float) -> LevelSet | None:
    """The level sets about an equilibrium of a model."""
    parameters = defaults(model, law, **changes)
    unexcited = sliding(system(model, law, parameters=parameters), parameters)
    rest = equilibria(unexcited)[number - 1]
    jacobian = free_jacobian(unexcited, rest)
    rows, found = level_sets(unexcited[None], rest[None], jacobian[None], np.array([number]))
    return found[0] if len(rows) else None


def about_the_belt(**changes: float) -> LevelSet:
    found = levels("belt-1dof", "coulomb", **({"c": DAMPING} | changes))
    assert found is not None
    return found


PLACES = st.floats(-2.0, 2.0)


# --- linear sliding: the bound is exact -----------------------------------------------------------
@given(x=PLACES, x_dot=PLACES.filter(lambda value: value < 0.99))
def test_a_level_below_one_meets_no_surface_and_the_bound_is_close(x: float, x_dot: float) -> None:
    """m = k = v = 1: with weak damping the velocity passes its largest value once a turn."""
    target = about_the_belt(c=1e-6)
    state = target.equilibrium + np.array([x, x_dot])
    level = target.level(target.amplitudes(state))
    assert level == pytest.approx(hypot(x, x_dot), rel=1e-5, abs=1e-9)
    (margin,) = target[None].margins(state[None])
    assert margin == pytest.approx(Descent(target).margin(0.0, state), nan_ok=True)
    assert np.isnan(margin) == (level >= 1.0) or level == pytest.approx(1.0, abs=1e-9)
    settings = {"t_end": 7.0, "sample": 7.0}
    start = dict(zip(("x", "x_dot"), state, strict=True))
    moved = analyse("belt-1dof", "coulomb", "history", start, settings, c=1e-6)
    assert (len(moved.ragged["event_time"]) > 0) == (level > 1.0) or abs(level - 1.0) < 1e-4


def test_linear_sliding_is_told_at_once() -> None:
    start = Start("a", "equilibrium", {"x": 0.9})
    found = analyse("belt-1dof", "coulomb", "response", start, c=DAMPING).values
    assert (found["attractor"], found["transient_used"], found["n_steps"]) == ("equilibrium", 0, 0)
    assert found["decay_margin"] == pytest.approx(0.1, abs=2e-2)
    assert (found["equilibrium_index"], found["L_s_reference_index"], found["L_s"]) == (1, 1, 0.0)


@pytest.mark.parametrize("changes", [{"c": 0.0}, {"c": -0.01}, {"c": 1e-12}])
def test_what_does_not_decay_has_no_level_sets(changes: dict[str, float]) -> None:
    assert levels("belt-1dof", "linear-slope", alpha_0=0.0, **changes) is None


# --- sliding that is not linear: it must be seen to fall ------------------------------------------
def spiral(target: LevelSet, rate: float, level: float, looks: int = 40) -> list[float]:
    """Margins of a spiral at the target's frequency that changes at `rate`, look by look."""
    descent = Descent(target)
    descent.slide.bent = 0.0  # known to be nonlinear at any level
    growth = complex(rate, abs(target.eigenvalues[0].imag))
    one = target.vectors[:, 0] * (target.eigenvalues[0].imag > 0) + target.vectors[:, 1] * (
        target.eigenvalues[1].imag > 0
    )
    scale = level / target.level(target.amplitudes(target.equilibrium + one.real))
    times = target.period * np.arange(looks)
    return [
        descent.margin(float(t), target.equilibrium + scale * (one * np.exp(growth * t)).real)
        for t in times
    ]


@pytest.mark.parametrize("share", [1.0, 1.0 - 0.8 * AGREEMENT, 1.0 + 0.8 * AGREEMENT])
def test_a_fall_at_the_linear_rate_is_believed_when_it_is_deep_enough(share: float) -> None:
    target = about_the_belt()
    rate = -share * target.slowest
    margins = spiral(target, rate, 0.9)
    first = next(look for look, margin in enumerate(margins) if not np.isnan(margin))
    assert np.exp(rate * target.period * first) <= FALLEN
    assert first * target.period <= 3.0 * log(1.0 / FALLEN) / -rate + 2.0 * target.period
    assert margins[first] >= 1.0 - FALLEN


@pytest.mark.parametrize("share", [0.0, -0.5, 0.5, 1.0 - 1.2 * AGREEMENT, 1.0 + 1.2 * AGREEMENT])
def test_another_rate_is_not(share: float) -> None:
    """A standstill, a growth, a slower and a faster fall: an unstable cycle may be near."""
    target = about_the_belt()
    assert np.all(np.isnan(spiral(target, -share * target.slowest, 0.9)))


def test_a_level_beyond_the_surface_is_not_looked_at() -> None:
    target = about_the_belt()
    assert np.all(np.isnan(spiral(target, -target.slowest, 30.0, looks=20)))


def test_sliding_with_a_stribeck_law_is_linear_only_near_its_equilibrium() -> None:
    """The nonlinear part grows with the distance, here as its square at least."""
    target = levels("belt-1dof", "stribeck", **STRIBECK)
    assert target is not None
    parts = [target.nonlinearity(np.full(2, size)) for size in (1e-1, 1e-2, 1e-3)]
    assert parts[0] > 5.0 * parts[1] > 25.0 * parts[2]
    descent = Descent(target)
    for size in (1e-1, 1e-2, 1e-3):
        state = target.equilibrium + size
        descent.margin(0.0, state)
        expected = target.nonlinearity(target.amplitudes(state))
        assert descent_kernels.nonlinearity(descent.slide) == pytest.approx(expected, rel=1e-6)
    assert about_the_belt().nonlinearity(np.full(2, 1.0)) < 1e-9


@pytest.mark.parametrize(("x", "kind"), [(1.87, "periodic"), (0.9, "equilibrium")])
def test_a_slide_that_grows_is_no_equilibrium(x: float, kind: str) -> None:
    """Beside the unstable cycle of a subcritical Hopf bifurcation no event tells, for long."""
    moved = {"t_max": 3000.0}
    found = analyse("belt-1dof", "stribeck", "response", {"x": x}, moved, **STRIBECK).values
    assert found["attractor"] == kind


def test_the_unstable_cycle_itself_is_no_class() -> None:
    """A motion on it repeats for long, but a multiplier is above 1."""
    section = {"section": Section("zero", state="x_dot", direction="up")}
    start = Start("a", "equilibrium", {"x": 1.25})
    cycle = analyse("belt-1dof", "stribeck", "cycle", start, section, **STRIBECK)
    assert cycle.values["stable"] == "unstable"
    names = ("x", "x_dot")
    begun = dict(zip(names, cycle.values["cycle_section"], strict=True))
    settings = section | {"t_max": 300.0}
    found = analyse("belt-1dof", "stribeck", "response", begun, settings, **STRIBECK)
    assert (found.values["attractor"], found.status) == ("undecided", "ok")


# --- several equilibria ---------------------------------------------------------------------------
@pytest.mark.parametrize("x", [-1.2, -0.9, 0.8, 1.1])
def test_every_stable_equilibrium_is_one_to_come_to(x: float) -> None:
    found = analyse(DOUBLE_WELL, "coulomb", "response", {"x": x}).values
    rest = analyse(DOUBLE_WELL, "coulomb", "equilibrium").values["equilibrium"]
    reached = rest[found["equilibrium_index"] - 1, 0]
    assert found["attractor"] == "equilibrium"
    assert np.sign(reached) == np.sign(x)
    assert (found["x_min"], found["x_max"], found["L_s"]) == (reached, reached, 0.0)
    assert found["L_s_reference"].tolist() == [reached]


def test_the_saddle_between_two_wells_holds_nothing() -> None:
    assert [levels(DOUBLE_WELL, "coulomb", number) is None for number in (1, 2, 3)].count(True) == 1


# --- an excitation --------------------------------------------------------------------------------
@pytest.mark.parametrize(("mu_k_2", "freely"), [(0.23, True), (0.2, False)])
def test_a_sector_of_the_same_kinetic_friction_does_not_disturb_a_slide(
    mu_k_2: float, freely: bool
) -> None:
    changes = {"mu_k": 0.23, "mu_s_2": 0.23, "mu_k_2": mu_k_2, "beta": 0.5, "Omega": 5.0}
    parameters = defaults("pin-on-disc", "coulomb", **changes)
    built = system("pin-on-disc", "coulomb", parameters=parameters)
    target = levels("pin-on-disc", "coulomb", **changes)
    assert target is not None
    assert (under_excitation(built, parameters, target) is target) == freely
    start = Start("a", "equilibrium", {"phi": 1e-4})
    told = analyse("pin-on-disc", "coulomb", "response", start, {"t_max": 60.0}, **changes).values
    assert told["attractor"] == ("equilibrium" if freely else "periodic")


def test_a_law_without_surface_has_nothing_to_meet() -> None:
    """tanh: no contact ever sticks, so the level has no bound, and its fall alone decides."""
    changes = {"c": 0.3, "v": 0.5, "sigma": 1.0}
    target = levels("belt-1dof", "tanh of coulomb", **changes)
    assert target is not None and not target.is_bounded
    assert target.level(np.full(2, 1e3)) == 0.0
    start = Start("a", "equilibrium", {"x": 3.0})
    found = analyse("belt-1dof", "tanh of coulomb", "response", start, **changes).values
    assert found["attractor"] == "equilibrium"
    assert found["transient_used"] >= log(1.0 / FALLEN) / (2.0 * target.slowest)
