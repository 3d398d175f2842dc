"""belt-2mass: two contacts that stick and slip for themselves and together (thesis 3.13-3.21).

While both masses stick their distance does not change, and so neither does the force on mass 2:
on a belt of constant speed mass 1 releases first, or both at once if mass 2 is held by its whole
capacity. That mass 2 releases first, from both sticking, needs contacts of different strength
(``test_dynamics_contacts.py``).
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from lumped_reference import TwoMasses
from motions import TIGHT, booked, by_both, defaults, ledger, motion, times, transitions
from small_models import TWO_MASSES

from fiv_cli.analyses.base import SolverSettings
from fiv_cli.api import analyse
from fiv_cli.codegen.codes import CODE_NAMES, CODE_SLIP_MINUS, CODE_SLIP_PLUS, CODE_STICK
from fiv_cli.dynamics.motion import Motion, Stop

COMPARED = 40  # events
CAPACITY = 8.0  # N: mu_s N
SIGNS = {CODE_SLIP_PLUS: 1.0, CODE_SLIP_MINUS: -1.0, CODE_STICK: 0.0}
STATES = ("x1", "x2", "x1_dot", "x2_dot")
TOGETHER = {"x1_dot": 1.0, "x2_dot": 1.0}  # both move with the belt
CASES: list[tuple[dict[str, float], float]] = [
    ({}, 0.3),
    ({"x1": 0.5, "x2": -0.5}, 0.3),
    (TOGETHER, 0.2),
    ({"x1": 3.0, "x2": -2.0}, 0.1),
    ({"x1": 9.0, "x2": 12.0, "x1_dot": 1.0, "x2_dot": -2.0}, 0.05),
]


def masses(
    start: Mapping[str, float],
    law: str = "stribeck",
    solver: SolverSettings = TIGHT,
    **changes: float,
) -> Motion:
    """Two masses on the belt of Figure 3.9."""
    return motion("belt-2mass", law, start, solver, None, **changes)


def joint_states(begun: Motion, before: list[int], count: int) -> list[str]:
    """The states of both contacts after each of the first events."""
    names, found = [CODE_NAMES[code] for code in before], []
    for row in ledger(begun)[:count]:
        names[int(row[3])] = CODE_NAMES[int(row[2])]
        found.append(" ".join(names))
    return found


# --- against an independent program --------------------------------------------------------------
@pytest.mark.parametrize(
    ("start", "changes"),
    [(start, {"D": damping}) for start, damping in CASES]
    + [
        ({"x1": 3.0, "x2": -2.0}, {"D": 0.1, "v": 0.7, "v2": -0.4, "N2": 8.0}),
        ({"x1": 1.0, "x2": 4.0}, {"D": 0.2, "N": 0.0, "N2": 20.0}),
    ],
)
def test_events_against_an_independent_program(
    start: Mapping[str, float], changes: Mapping[str, float]
) -> None:
    begun = masses(start, **changes)
    before = begun.codes
    assert begun.run(200.0) == Stop.REACHED
    kinds = [SIGNS[code] for code in before]
    other = TwoMasses(defaults("belt-2mass", "stribeck", **changes), kinds)
    state = np.array([start.get(name, 0.0) for name in STATES])
    expected, _ = other.follow(state, 200.0, COMPARED)
    assert joint_states(begun, before, COMPARED) == [event.after for event in expected]
    apart = times(begun)[:COMPARED] - np.array([event.time for event in expected])
    assert np.max(np.abs(apart)) < 1e-10


def test_the_cases_meet_every_way_into_and_out_of_sticking_together() -> None:
    met = set()
    for start, damping in CASES:
        begun = masses(start, D=damping)
        before = " ".join(CODE_NAMES[code] for code in begun.codes)
        codes = begun.codes
        begun.run(200.0)
        for after in joint_states(begun, codes, COMPARED):
            met.add((before, after))
            before = after
    assert ("slip+ stick", "stick stick") in met
    assert ("stick slip+", "stick stick") in met
    assert ("stick stick", "slip+ stick") in met
    assert ("slip+ stick", "slip- stick") in met


@pytest.mark.parametrize("law", ["stribeck", "coulomb", "hyperbolic"])
def test_two_integrators_agree(law: str) -> None:
    changes = {"mu_0": 0.4, "delta": 1.0} if law == "hyperbolic" else {}
    exact, _ = by_both(60.0, 5e-3, "belt-2mass", law, {"x1": 0.5}, **changes)
    assert exact.n_events >= 5


@pytest.mark.parametrize("damping", [0.0, 0.1, 0.3])
def test_energy_is_balanced(damping: float) -> None:
    begun = masses({"x1": 0.5}, D=damping)
    found = booked(begun, 200.0)
    assert begun.n_events > 10
    assert found.residual < 1e-12
    assert (found.other == 0.0) == (damping == 0.0)


# --- both sticking -------------------------------------------------------------------------------
def test_mass_1_releases_first_where_mass_2_has_capacity_left() -> None:
    """k1 x1 + c1 v + k2 (x1 - x2) reaches mu_s N; the pull on mass 2 stays as it was."""
    begun = masses({**TOGETHER, "x1": 0.5, "x2": 3.0})
    assert begun.codes == [CODE_STICK] * 2
    begun.run(20.0)
    assert transitions(begun)[0] == "stick->slip+ 0"
    release = (CAPACITY - 0.6 + 2.5) / 2.0 - 0.5  # c1 = 2 D sqrt(m2 k2) = 0.6
    assert times(begun)[0] == pytest.approx(release, abs=1e-13)
    assert times(begun)[1] > release + 1e-3


@pytest.mark.parametrize("law", ["stribeck", "coulomb"])
@pytest.mark.parametrize("x1", [0.0, 0.3, 1.0])
def test_both_release_at_once_where_mass_2_is_held_by_all_its_capacity(law: str, x1: float) -> None:
    """Mass 2 is on the border until mass 1 goes, and then has to follow at the same instant."""
    begun = masses({**TOGETHER, "x1": x1, "x2": x1 + CAPACITY}, law)
    assert begun.codes == [CODE_STICK] * 2
    assert begun.run(20.0) == Stop.REACHED
    assert transitions(begun)[:2] == ["stick->slip+ 0", "stick->slip+ 1"]
    release = (CAPACITY - 0.6 + CAPACITY) / 2.0 - x1
    assert times(begun)[0] == times(begun)[1] == pytest.approx(release, abs=1e-12)


@pytest.mark.parametrize(("beyond", "sticks"), [(-1e-9, True), (1e-9, False)])
def test_the_border_of_sticking_together(beyond: float, sticks: bool) -> None:
    """A pull on mass 2 just below its capacity holds, one just above slips at once."""
    begun = masses({**TOGETHER, "x2": CAPACITY + beyond})
    expected = CODE_STICK if sticks else CODE_SLIP_PLUS
    assert begun.codes == [CODE_STICK, expected]
    begun.run(20.0)
    if sticks:
        assert transitions(begun)[:2] == ["stick->slip+ 0", "stick->slip+ 1"]
        assert 0.0 < times(begun)[1] - times(begun)[0] < 1e-3


@pytest.mark.parametrize("method", ["taylor", "rk4"])
def test_a_mass_held_below_its_capacity_stays_when_the_other_goes(method: str) -> None:
    """Strong stiction allows that mass 2 jumps off instead, which nothing demands."""
    changes = {
        "m1": 0.5, "m2": 0.4, "k1": 2.1, "k2": 2.3, "N": 16.0, "v": 0.5, "D": 0.4,
        "c1_over_c2": 2.5, "mu_k": 0.02, "mu_s": 0.8,
    }  # fmt: skip
    solver = SolverSettings(method, TIGHT.rtol, 2e-3)
    begun = masses({"x1": -2.9, "x2": -0.5}, "coulomb", solver, **changes)
    begun.run(25.0)
    words = transitions(begun)
    released = words.index("stick->slip+ 0")
    assert words[:released] == ["slip+->stick 0", "slip+->stick 1"]
    assert "stick->slip- 1" not in words


# --- invariances ---------------------------------------------------------------------------------
@settings(max_examples=10)
@given(
    strengths=st.tuples(st.floats(3.0, 12.0), st.floats(3.0, 12.0)),
    stiffness=st.tuples(st.floats(0.5, 2.0), st.floats(0.5, 2.0)),
    places=st.tuples(st.floats(-2.0, 2.0), st.floats(-2.0, 2.0)),
)
def test_the_order_of_the_contacts_does_not_matter(
    strengths: tuple[float, float], stiffness: tuple[float, float], places: tuple[float, float]
) -> None:
    """Names swapped, the two masses of a symmetric model make the same motion."""
    begun, swapped = (
        motion(
            TWO_MASSES, "coulomb", {"x1": places[i], "x2": places[j]},
            N1=strengths[i], N2=strengths[j], k1=stiffness[i], k2=stiffness[j],
        )
        for i, j in ((0, 1), (1, 0))
    )  # fmt: skip
    for each in (begun, swapped):
        each.run(15.0)
    for contact in (0, 1):  # apart: at one instant the first contact's row stands first
        own, others = ledger(begun), ledger(swapped)
        own, others = own[own[:, 3] == contact], others[others[:, 3] == 1 - contact]
        np.testing.assert_array_equal(own[:, 1:3], others[:, 1:3])
        np.testing.assert_allclose(own[:, 0], others[:, 0], rtol=1e-10)


@settings(max_examples=10)
@given(powers=st.tuples(*[st.integers(-10, 10)] * 3))
def test_units_do_not_matter(powers: tuple[int, int, int]) -> None:
    """Mass, length and time in other units, the speed scale of the law too."""
    mass, length, time = (2.0**power for power in powers)
    stiffness, speed = mass / time**2, length / time
    start = {"x1": 0.5, "x2": -0.5}
    original = masses(start)
    scaled = masses(
        {name: value * length for name, value in start.items()},
        m1=2.5 * mass, m2=mass, k1=2.0 * stiffness, k2=stiffness, N=20.0 * stiffness * length,
        v=speed, v_s=speed,
    )  # fmt: skip
    original.run(40.0)
    scaled.run(40.0 * time)
    assert transitions(scaled) == transitions(original) and original.n_events > 5
    np.testing.assert_allclose(times(scaled) / time, times(original), rtol=1e-11)


def test_a_belt_that_runs_the_other_way_mirrors_the_motion() -> None:
    start = {"x1": 0.5, "x2": -0.5}
    original = masses(start)
    mirrored = masses({name: -value for name, value in start.items()}, v=-1.0)
    original.run(60.0)
    mirrored.run(60.0)
    np.testing.assert_array_equal(times(mirrored), times(original))
    np.testing.assert_array_equal(mirrored.y, -original.y)


# --- what they lead to ---------------------------------------------------------------------------
def test_the_attractors_of_figure_3_9() -> None:
    """Period at D = 0.3 from a separate computation; slowly periodic at 0.2; chaotic at 0.1."""
    found = {
        damping: analyse("belt-2mass", "stribeck", "response", {}, {"t_max": 60000.0}, D=damping)
        for damping in (0.3, 0.2, 0.1)
    }
    kinds = {damping: outcome.values["attractor"] for damping, outcome in found.items()}
    assert kinds == {0.3: "periodic", 0.2: "periodic", 0.1: "chaotic"}
    assert found[0.3].values["period"] == pytest.approx(19.25064477, abs=1e-6)
    assert found[0.1].values["lyapunov"] > 0.01
    slowest = sorted(np.abs(found[0.2].values["floquet_multiplier"]))[-2]
    assert slowest == pytest.approx(0.987, abs=5e-4)
