"""Critical values: closed forms, synthetic modes whose crossings are known, case files."""

from __future__ import annotations

from collections.abc import Callable, Generator, Sequence
from math import pi, sin, sqrt
from typing import Any

import mpmath as mp
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from motions import defaults, system
from scipy.optimize import brentq

from fiv_cli.analyses.base import Outcome, Varied
from fiv_cli.analyses.rest import crossings
from fiv_cli.analyses.rest.brent import ULP, zero
from fiv_cli.analyses.rest.crossings import Crossing, Sample, side_by_side
from fiv_cli.analyses.rest.equilibria import equilibria, sliding
from fiv_cli.analyses.rest.linearisation import modes_at
from fiv_cli.analyses.rest.modes import modes_of
from fiv_cli.api import analyse
from fiv_cli.case.load import parse_case
from fiv_cli.errors import CaseError
from fiv_cli.sweep.plan import make_plan

FLUTTER = 5 / 2 + sqrt(3)  # critical friction without damping


def critical(
    model: str,
    parameter: str,
    bracket: tuple[float, float],
    system: str = "original",
    law: str = "coulomb",
    followers: tuple[str, ...] = (),
    options: dict[str, str] | None = None,
    **changes: float,
) -> Outcome:
    """The crossings of one model from its defaults."""
    varied = Varied(parameter, followers)
    settings = {"parameter": varied, "bracket": bracket, "system": system}
    return analyse(model, law, "critical", None, settings, options=options, **changes)


def only(found: Outcome) -> float:
    """The one critical value."""
    assert found.status == "ok"
    (value,) = found.values["critical_value"]
    return float(value)


# --- mode coupling (thesis 3.1.3) -----------------------------------------------------------------
def hurwitz(c1: float, c2: float) -> Any:
    """Critical friction of the damped flutter model, by the criterion of Hurwitz on 3.29.

    In 40 digits.
    """
    with mp.workdps(40):
        k11 = mp.cos(mp.pi / 4) ** 2 + mp.cos(mp.pi / 6) ** 2
        k22 = mp.sin(mp.pi / 4) ** 2 + mp.sin(mp.pi / 6) ** 2 + 2
        k12 = -mp.sin(mp.pi / 4) * mp.cos(mp.pi / 4) + mp.sin(mp.pi / 6) * mp.cos(mp.pi / 6)
        c1, c2 = mp.mpf(c1), mp.mpf(c2)
        a1, a2, a3 = c1 * k22 + c2 * k11, k11 + k22 + c1 * c2, c1 + c2
        product = k11 * k22 - a1 * (a2 * a3 - a1) / a3**2
        return (product / k12 - k12) / 2


@pytest.mark.parametrize("ratio", [1.0, 2.0, 0.5, 10.0])
@pytest.mark.parametrize("c", [1e-9, 1e-6, 1e-3, 0.2, 0.5])
def test_a_critical_value_is_as_near_as_it_says(c: float, ratio: float) -> None:
    """Within its error of the closed form, and told to fourteen digits."""
    found = critical("flutter-2dof", "mu_k", (0.0, 200.0), c1=c, c2=ratio * c)
    (error,) = found.values["critical_error"]
    with mp.workdps(40):
        assert abs(mp.mpf(only(found)) - hurwitz(c, ratio * c)) <= error
    assert found.values["critical_width"][0] < error < 1e-13 * only(found)


def test_undamped_flutter_begins_where_two_frequencies_meet() -> None:
    found = critical("flutter-2dof", "mu_k", (0.0, 6.0))
    assert only(found) == pytest.approx(FLUTTER, rel=1e-14)
    assert found.values["critical_width"][0] < 1e-14
    assert found.values["crossing_kind"][0] == "root"
    assert found.values["crossing_direction"][0] == "to_unstable"
    assert found.values["crossing_frequency"][0] == pytest.approx(sqrt(2), rel=1e-7)
    assert (found.values["unstable_below"][0], found.values["unstable_above"][0]) == (0, 2)
    assert found.values["growth_at_low"] == 0.0


@pytest.mark.parametrize("c", [1e-9, 1e-6, 1e-3, 0.2, 0.5])
def test_proportional_damping_stabilises(c: float) -> None:
    found = critical("flutter-2dof", "mu_k", (0.0, 9.0), c1=c, c2=c)
    assert only(found) == pytest.approx(FLUTTER + 4 * (2 + sqrt(3)) * c**2, rel=1e-13)


def test_vanishing_damping_destabilises() -> None:
    found = critical("flutter-2dof", "mu_k", (0.0, 6.0), c1=1e-7, c2=2e-7)
    assert only(found) == pytest.approx(3.7655445, abs=5e-8)
    at_zero = critical("flutter-2dof", "c1", (0.0, 1.0), mu_k=4.0)
    assert only(at_zero) == pytest.approx(0.0, abs=1e-20)
    assert at_zero.values["crossing_kind"][0] == "root"


def test_damping_that_stabilises_is_found_as_well() -> None:
    found = critical("flutter-2dof", "c1", (0.01, 1.0), mu_k=4.0, c2=0.2)
    value = only(found)
    assert float(hurwitz(value, 0.2)) == pytest.approx(4.0, rel=1e-12)
    assert found.values["crossing_direction"][0] == "to_stable"


@pytest.mark.parametrize("low", [-1.7, -1e-3, -1e-4, -(2.0**-30), 0.0, 1e-4])
@pytest.mark.parametrize("high", [1.5, 1.7, 2.0 - 2.0**-30])
def test_what_lies_beside_a_belt_at_standstill_is_found_in_any_bracket(
    low: float, high: float
) -> None:
    """Stable for belts slower than 0.7 mm/s, whichever way; at 0 there is no sliding at all.

    A thousandth of a bracket: two roots and two ends between its first two samples. Where the two
    powers of 2 end it, its halves meet 0 itself.
    """
    law = {"mu_s": 0.4, "mu_k": 0.23, "v_s": 0.5, "delta": 2.0}
    found = critical("belt-1dof", "v", (low, high), law="stribeck", c=0.01, N=10.0, **law)

    def slope(v: float) -> float:
        return 0.01 - 10.0 * 0.17 * 2.0 * v / 0.25 * float(np.exp(-((v / 0.5) ** 2)))

    slow, fast = brentq(slope, 1e-5, 0.1, xtol=1e-17), brentq(slope, 0.5, 1.4, xtol=1e-15)
    expected = [
        (-fast, "root", "to_unstable"), (-slow, "root", "to_stable"), (0.0, "end", "lost"),
        (0.0, "end", "gained"), (slow, "root", "to_unstable"), (fast, "root", "to_stable"),
    ]  # fmt: skip
    inside = [one for one in expected if low < one[0] < high or (one[2] == "gained" and low <= 0.0)]
    told = [found.values[f"crossing_{name}"].tolist() for name in ("kind", "direction")]
    assert [*zip(*told, strict=True)] == [one[1:] for one in inside]
    values = [one[0] for one in inside]
    np.testing.assert_allclose(found.values["critical_value"], values, rtol=1e-12, atol=1e-20)


# --- tangential excitation (thesis 5.2) -----------------------------------------------------------
def test_the_excited_model_at_rest() -> None:
    assert only(critical("excited-2dof", "mu_k", (0.0, 1.0))) == pytest.approx(0.36562415, abs=5e-9)


def test_a_jump_and_a_root_close_behind_it() -> None:
    found = critical("excited-2dof", "A_b", (0.0, 20.0), "averaged", mu_k=0.7, R=20.0)
    np.testing.assert_allclose(
        found.values["critical_value"] / 20.0, [0.3, 0.300208, 0.398407], atol=5e-7
    )
    assert found.values["critical_value"][0] == pytest.approx(6.0, rel=1e-14)
    assert list(found.values["crossing_kind"]) == ["jump", "root", "root"]
    assert list(found.values["crossing_direction"]) == ["to_stable", "to_unstable", "to_stable"]
    assert list(found.values["unstable_above"]) == [0, 2, 0]
    assert found.reason == ""


def test_weaker_friction_leaves_the_jump_alone() -> None:
    found = critical("excited-2dof", "A_b", (0.0, 20.0), "averaged", mu_k=0.4, R=20.0)
    assert only(found) == pytest.approx(6.0, rel=1e-14)
    assert found.values["crossing_kind"][0] == "jump"


def test_only_the_ratio_of_amplitude_and_frequency_counts() -> None:
    found = critical("excited-2dof", "R", (5.5, 100.0), "averaged", mu_k=0.7, A_b=6.0)
    expected = critical("excited-2dof", "A_b", (0.0, 20.0), "averaged", mu_k=0.7, R=20.0)
    inverse = 6.0 * 20.0 / expected.values["critical_value"][::-1]
    np.testing.assert_allclose(found.values["critical_value"], inverse, rtol=1e-11)
    assert list(found.values["crossing_kind"]) == ["root", "root", "jump"]


def test_a_slow_excitation_is_said_to_be_one() -> None:
    found = critical("excited-2dof", "A_b", (0.0, 2.0), "averaged", R=4.0)
    assert (found.status, found.reason) == ("ok", "averaging_invalid")
    assert found.values["averaging_ratio"][0] < 5.0
    assert only(found) == pytest.approx(1.2, rel=1e-14)


@pytest.mark.parametrize(("R", "reason"), [(4.0, "averaging_invalid"), (20.0, "no_crossing")])
def test_without_a_crossing_too_a_slow_excitation_is_said_to_be_one(R: float, reason: str) -> None:
    found = critical("excited-2dof", "A_b", (0.05 * R, 0.2 * R), "averaged", R=R)
    assert (found.values["n_crossings"], found.reason) == (0, reason)


# --- five degrees of freedom (thesis 6.4.1) -------------------------------------------------------
@pytest.mark.parametrize(("geometry", "expected"), [("nonlinear", 1.513784), ("linear", 1.973910)])
def test_geometric_nonlinearity_lowers_the_critical_friction(
    geometry: str, expected: float
) -> None:
    found = critical("belt-5dof", "mu_k", (0.0, 3.0), options={"geometry": geometry})
    assert only(found) == pytest.approx(expected, abs=5e-7)


def test_a_stiff_belt() -> None:
    changes = {"k4": 5e6, "k5": 5e6, "k6": 5e6, "k_nl": 1e7, "F": 800.0}
    assert only(critical("belt-5dof", "mu_k", (0.0, 3.0), **changes)) == pytest.approx(
        1.735143, abs=5e-7
    )


def test_any_parameter_may_be_the_one() -> None:
    """The surface mu_c(F) met from its other side."""
    friction = only(critical("belt-5dof", "mu_k", (0.0, 3.0), F=300.0))
    assert only(critical("belt-5dof", "F", (50.0, 900.0), mu_k=friction)) == pytest.approx(300.0)


# --- rigid contact with a disc (thesis chapter 4) -------------------------------------------------
@pytest.mark.parametrize(
    ("changes", "bracket", "number", "expected"),
    [
        ({"c_z": 11.0, "C_phi": 1.0, "alpha": 10.0}, (0.5, 10.0), -1, 2.699143),
        ({"c_z": 1.0, "C_phi": 2.0, "alpha": 0.0}, (0.1, 3.0), 0, 1.171690),
    ],
    ids=["decelerating", "accelerating"],
)
def test_sliding_on_a_disc_loses_stability_at_a_speed(
    changes: dict[str, float], bracket: tuple[float, float], number: int, expected: float
) -> None:
    found = critical("disc-rigid-contact", "Omega", bracket, law="exponential", **changes)
    assert found.values["critical_value"][number] == pytest.approx(expected, abs=5e-7)


def test_what_a_rigid_contact_determines_has_no_modes_of_its_own() -> None:
    name, law = "disc-rigid-contact", "exponential"
    state = sliding(system(name, law), defaults(name, law))
    at = equilibria(state)[0]
    values, vectors = modes_at(state, at)
    jacobian = state.jacobian(at)
    assert len(values) == len(at) - 2
    scale = np.abs(jacobian @ vectors).max(axis=0)
    np.testing.assert_allclose((jacobian @ vectors - vectors * values) / scale, 0.0, atol=1e-11)


# --- no crossing, no equilibrium ------------------------------------------------------------------
def test_a_bracket_without_a_crossing_says_so() -> None:
    found = critical("flutter-2dof", "mu_k", (0.0, 3.0), c1=0.1, c2=0.1)
    assert (found.status, found.reason) == ("ok", "no_crossing")
    assert found.values["n_crossings"] == 0
    assert found.values["growth_at_low"] < 0.0 and found.values["growth_at_high"] < 0.0


def test_without_an_equilibrium_there_is_nothing_to_cross() -> None:
    found = critical("belt-1dof", "c", (0.0, 1.0), v=0.0)
    assert (found.status, found.reason) == ("failed", "no_drive")
    beyond = critical("flutter-2dof", "mu_k", (2.0, 3.0), alpha1=-pi / 4)
    assert (beyond.status, beyond.reason) == ("failed", "contact_would_pull")


def test_divergence_ends_the_equilibrium_of_a_contact_that_can_open() -> None:
    """With spring 1 inclined the other way the stiffness of 3.25 becomes singular; beyond, a
    contact that cannot open has an equilibrium again, from which it diverges."""
    k11, k22, k12 = 5 / 4, 11 / 4, 1 / 2 + sqrt(3) / 4
    singular = (k11 * k22 / k12 - k12) / 2.0
    lost = critical("flutter-2dof", "mu_k", (0.0, 3.0), alpha1=-pi / 4)
    assert lost.reason == "no_equilibrium_in_part"
    # where the displacements pass all bounds, just before they are infinite
    assert only(lost) == pytest.approx(singular, rel=1e-5)
    assert lost.values["crossing_kind"][0] == "end"
    assert lost.values["crossing_direction"][0] == "lost"
    assert lost.values["unstable_above"][0] == -1
    slip = {"states": "slip"}
    diverging = critical("flutter-2dof", "mu_k", (0.0, 3.0), options=slip, alpha1=-pi / 4)
    assert list(diverging.values["crossing_direction"]) == ["lost", "gained"]
    assert list(diverging.values["unstable_above"]) == [-1, 1]


def test_what_follows_the_parameter_moves_with_it() -> None:
    free = critical("flutter-2dof", "mu_k", (0.0, 6.0), law="stribeck", followers=("mu_s",), c1=0.1)
    fixed = critical("flutter-2dof", "mu_k", (0.0, 6.0), law="stribeck", mu_s=0.3, c1=0.1)
    coulomb = critical("flutter-2dof", "mu_k", (0.0, 6.0), c1=0.1)
    assert only(free) == pytest.approx(only(coulomb), rel=1e-12)
    assert list(fixed.values["critical_value"]) != list(free.values["critical_value"])


# --- the scan, on modes that are known -----------------------------------------------------------
def find_crossings(
    probe: Callable[[float], Sample], low: float, high: float
) -> list[Crossing] | None:
    """What one scan finds."""
    scans = [crossings.find_crossings(low, high)]
    (found,) = side_by_side(scans, lambda asked: [probe(at) for _, at in asked])
    return found


def sample(at: float, values: Any, shapes: Any) -> Sample:
    """The modes at one value of the parameter."""
    return Sample(at, modes_of(values[None], shapes[None])[0])


def probe_of(*eigenvalues: Callable[[float], complex]) -> Callable[[float], Sample]:
    """Uncoupled modes: each eigenvalue and, where it is complex, its conjugate."""

    def probe(at: float) -> Sample:
        values = [z for f in eigenvalues for z in {complex(f(at)), complex(f(at)).conjugate()}]
        ordered = sorted(values, key=lambda z: (abs(z.imag), -z.imag))
        places = [values.index(z) for z in ordered]
        return sample(at, np.array(ordered), np.eye(len(values), dtype=complex)[places])

    return probe


def kinds(found: Sequence[Crossing]) -> list[tuple[str, str]]:
    """Kind and direction of each crossing."""
    return [(crossing.kind, crossing.direction) for crossing in found]


@settings(max_examples=200, deadline=None)
@given(st.floats(-0.9, 0.9), st.floats(0.1, 9.0), st.floats(-3.0, 3.0), st.integers(1, 4))
def test_a_zero_is_that_of_scipy_to_the_last_bit(
    at: float, steep: float, bent: float, power: int
) -> None:
    def curve(x: float) -> float:
        return (x - at) ** (2 * power - 1) * (steep + (bent * x) ** 2)

    def asked(x: float) -> Generator[float, float, float]:
        return (yield x)

    search = zero(asked, -1.0, 1.0, 1e-15)
    wanted = next(search)
    with pytest.raises(StopIteration) as ended:
        while True:
            wanted = search.send(curve(wanted))
    assert ended.value.value == brentq(curve, -1.0, 1.0, xtol=1e-15, rtol=4.0 * ULP, disp=False)


@settings(max_examples=40, deadline=None)
@given(
    st.lists(st.floats(0.02, 0.98), min_size=1, max_size=4, unique_by=lambda x: round(x, 3)),
    st.floats(0.5, 20.0),
)
def test_every_simple_root_is_found(roots: list[float], frequency: float) -> None:
    roots = sorted(roots)

    def mode(at: float) -> complex:
        return complex(np.prod([at - root for root in roots]), frequency + at)

    found = find_crossings(probe_of(mode), 0.0, 1.0)
    np.testing.assert_allclose([c.value for c in found], roots, rtol=1e-12)
    # the last crossing is upward, and each turns what the one before it did
    directions = ["to_unstable" if i % 2 == 0 else "to_stable" for i in range(len(roots))][::-1]
    assert [c.direction for c in found] == directions
    assert all(c.width < 1e-12 for c in found)


@pytest.mark.parametrize("rounding", [0.0, 1e-17, -1e-17])
@pytest.mark.parametrize(
    "root", [*(n / 64.0 for n in (1, 20, 31, 63)), 24.0 / 64.0 + 2.0**-12, 0.375 - 2.0**-52]
)
@pytest.mark.parametrize("slope", [1.0, -1.0])
def test_a_root_on_what_divides_the_bracket_is_found(root, rounding, slope) -> None:
    """In halves of the bracket, in which there is none to either side."""
    mode = probe_of(lambda s: complex(slope * (s - root) * (1.0 + s * s) + rounding, 3.0))
    (found,) = find_crossings(mode, 0.0, 1.0)
    assert abs(found.value - root) <= found.error < 1e-13
    assert found.direction == ("to_unstable" if slope > 0.0 else "to_stable")
    below, above = (0, 2) if slope > 0.0 else (2, 0)
    assert (found.kind, found.below, found.above) == ("root", below, above)


@pytest.mark.parametrize("rounding", [0.0, 1e-17, -1e-17])
@pytest.mark.parametrize(
    ("slope", "bracket", "count"),
    [
        (1.0, (0.375, 1.0), 1),
        (-1.0, (0.375, 1.0), 0),
        (1.0, (0.0, 0.375), 0),
        (-1.0, (0.0, 0.375), 1),
    ],
)
def test_a_root_at_an_edge_of_the_bracket_is_one_where_something_grows_inside(
    slope, bracket, count, rounding
) -> None:
    """At the edge itself nothing grows, whatever it does beyond."""
    found = find_crossings(
        probe_of(lambda s: complex(slope * (s - 0.375) + rounding, 3.0)), *bracket
    )
    assert len(found) == count
    for one in found:
        assert one.direction == ("to_unstable" if slope > 0.0 else "to_stable")
        assert abs(one.below - one.above) == 2 and one.value == pytest.approx(0.375, abs=1e-12)


@pytest.mark.parametrize("c1", [0.0025, 0.015, 0.1, 0.4])
def test_critical_friction_of_three_eighths_lies_in_brackets_of_any_ends(c1: float) -> None:
    """With one damping alone it is 3/8, whatever that is; which of halves end there as well."""
    changes = {"k1": 1.0, "k2": 1.0, "k3": 4.0 / 3.0, "alpha1": pi / 4.0, "alpha2": 0.0, "c2": 0.0}
    for bracket in ((0.0, 2.0), (0.0, 1.7), (0.25, 0.5)):
        found = critical("flutter-2dof", "mu_k", bracket, v=0.5, c1=c1, **changes)
        assert abs(only(found) - 0.375) <= found.values["critical_error"][0] < 1e-13
        assert found.values["crossing_direction"] == ["to_unstable"]


@pytest.mark.parametrize("distance", [1e-1, 1e-3, 1e-5])
def test_two_roots_close_together_are_two(distance: float) -> None:
    low, high = 0.4137, 0.4137 + distance
    found = find_crossings(probe_of(lambda s: complex(-(s - low) * (s - high), 3.0)), 0.0, 1.0)
    np.testing.assert_allclose([c.value for c in found], [low, high], rtol=1e-9)
    assert kinds(found) == [("root", "to_unstable"), ("root", "to_stable")]


def test_a_touch_is_no_crossing() -> None:
    found = find_crossings(probe_of(lambda s: complex(-((s - 0.4137) ** 2) - 1e-9, 3.0)), 0.0, 1.0)
    assert found == []


def test_a_jump_is_told_from_a_root() -> None:
    found = find_crossings(probe_of(lambda s: complex(-1.0 if s < 0.3 else 0.5, 3.0)), 0.0, 1.0)
    assert kinds(found) == [("jump", "to_unstable")]
    assert found[0].value == pytest.approx(0.3, rel=1e-14)
    assert found[0].frequency == 3.0


@pytest.mark.parametrize("width", [1e-1, 1e-3, 1e-5])
def test_flutter_in_a_narrow_window_is_not_missed(width: float) -> None:
    """Two undamped frequencies that meet, and part again: nothing grows outside the window."""
    centre = 0.5137

    def mode(sign: int) -> Callable[[float], complex]:
        return lambda s: 2j + sign * np.sqrt(complex(width**2 / 4 - (s - centre) ** 2))

    found = find_crossings(probe_of(mode(1), mode(-1)), 0.0, 1.0)
    edges = [centre - width / 2, centre + width / 2]
    np.testing.assert_allclose([c.value for c in found], edges, rtol=1e-12)
    assert kinds(found) == [("root", "to_unstable"), ("root", "to_stable")]


@pytest.mark.parametrize("coupling", [0.3, 0.03, 0.003, 3e-5])
def test_weakly_coupled_modes_that_pass_flutter_in_between(coupling: float) -> None:
    """Far from where they pass nothing tells that two damped modes are coupled at all."""
    centre, damping = 0.4871, coupling / 2.0

    def probe(at: float) -> Sample:
        rates = np.diag([2.0 + 4.0 * at, 2.0 + 4.0 * centre]) * 1j - damping * np.eye(2)
        values, shapes = np.linalg.eig(rates + coupling * np.array([[0.0, 1.0], [1.0, 0.0]]))
        order = np.argsort(values.imag)
        return sample(at, values[order], shapes.T[order])

    found = find_crossings(probe, 0.0, 1.0)
    reach = sqrt(coupling**2 - damping**2) / 2.0
    np.testing.assert_allclose([c.value for c in found], [centre - reach, centre + reach])
    assert kinds(found) == [("root", "to_unstable"), ("root", "to_stable")]


def test_modes_that_pass_each_other_keep_their_numbers() -> None:
    """The third mode begins above the others, passes them and crosses last."""
    found = find_crossings(
        probe_of(
            lambda s: complex(s - 0.31, 2.0),
            lambda s: complex(s - 0.62, 3.0),
            lambda s: complex(s - 0.93, 5.0 - 4.0 * s),
        ),
        0.0,
        1.0,
    )
    np.testing.assert_allclose([c.value for c in found], [0.31, 0.62, 0.93], rtol=1e-12)
    assert [c.mode for c in found] == [0, 2, 4]
    assert [(c.below, c.above) for c in found] == [(0, 2), (2, 4), (4, 6)]


def test_the_ends_of_the_equilibrium() -> None:
    known = probe_of(lambda s: complex(-1.0, 3.0))

    def probe(at: float) -> Sample:
        nothing = sample(at, np.zeros(0, complex), np.zeros((0, 0), complex))
        return known(at) if 0.2 < at < 0.7 else nothing

    found = find_crossings(probe, 0.0, 1.0)
    assert kinds(found) == [("end", "gained"), ("end", "lost")]
    np.testing.assert_allclose([c.value for c in found], [0.2, 0.7], rtol=1e-14)
    assert [(c.below, c.above) for c in found] == [(-1, 0), (0, -1)]


def test_what_cannot_be_resolved_is_given_up(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(crossings, "MOST_SAMPLES", 100)
    rough, smooth = (probe_of(lambda s, k=k: complex(sin(k * s), 3.0)) for k in (300.0, 4.0))
    assert find_crossings(rough, 0.0, 1.0) is None
    scans = [crossings.find_crossings(0.5, 1.0) for _ in range(2)]
    found = side_by_side(scans, lambda asked: [(rough, smooth)[place](at) for place, at in asked])
    assert found[0] is None and [c.value for c in found[1]] == pytest.approx([pi / 4], rel=1e-12)


# --- case files -----------------------------------------------------------------------------------
CASE = """
schema = 1
[model]
name = "excited-2dof"
[friction]
law = "coulomb"
[grid]
R = [10.0, 20.0]
[[analysis]]
kind = "critical"
"""


def problems(lines: str) -> str:
    """What is wrong with a case of these settings."""
    with pytest.raises(CaseError) as caught:
        parse_case(CASE + lines, "case.toml")
    return str(caught.value)


def test_a_case_names_the_parameter_and_its_bracket() -> None:
    case = parse_case(CASE + 'parameter = "A_b"\nbracket = ["0 mN", "20 N"]', "case.toml")
    assert case.analyses[0].settings == {
        "parameter": Varied("A_b", (), "N"),
        "bracket": (0.0, 20.0),
        "system": "original",
    }
    assert make_plan(case).analyses[0].size == 2


def test_followers_are_those_that_nothing_else_decides() -> None:
    lines = 'parameter = "mu_k"\nbracket = [0, 1]'
    free = parse_case(CASE + lines, "case.toml")
    assert free.analyses[0].settings["parameter"].followers == ("mu_s",)
    given_too = CASE.replace('law = "coulomb"', 'law = "coulomb"\nmu_s = 0.5')
    fixed = parse_case(given_too + lines, "case.toml")
    assert fixed.analyses[0].settings["parameter"].followers == ()


@pytest.mark.parametrize(
    ("lines", "fragment"),
    [
        ("bracket = [0, 1]", "is missing"),
        ('parameter = "A_b"', "is missing"),
        ('parameter = "A-b"\nbracket = [0, 1]', "did you mean 'A_b'"),
        ('parameter = "R"\nbracket = [1, 2]', "is an axis of the grid"),
        ('parameter = "A_b"\nbracket = [2, 1]', "is not below"),
        ('parameter = "A_b"\nbracket = [0, 1, 2]', "a list of two numbers"),
        ('parameter = "A_b"\nbracket = [-1, 1]', "is out of range"),
        ('parameter = "A_b"\nbracket = ["0 m", "1 m"]', "unit"),
        ('parameter = 3\nbracket = [0, 1]', "must be the name of a parameter"),
    ],
)  # fmt: skip
def test_what_a_case_may_not_ask(lines: str, fragment: str) -> None:
    assert fragment in problems(lines)


def test_what_varies_is_a_parameter_of_every_law() -> None:
    laws = CASE.replace("[grid]", '[grid]\nfriction = ["coulomb", "hyperbolic"]')
    laws = laws.replace('law = "coulomb"', "")
    with pytest.raises(
        CaseError, match=r"'mu_k' is no parameter of hyperbolic\n.*of hyperbolic: mu"
    ):
        parse_case(laws + 'parameter = "mu_k"\nbracket = [0, 1]', "case.toml")


def test_a_law_without_an_average_is_refused() -> None:
    lines = 'parameter = "A_b"\nbracket = [0, 1]\nsystem = "averaged"'
    tanh = CASE.replace('law = "coulomb"', 'law = "tanh"\nof = "coulomb"')
    with pytest.raises(CaseError, match="has no average"):
        parse_case(tanh + lines, "case.toml")
    flutter = CASE.replace("excited-2dof", "flutter-2dof").replace("R = [10.0, 20.0]", "")
    with pytest.raises(CaseError, match="no fast excitation"):
        parse_case(flutter + lines.replace("A_b", "F"), "case.toml")


def test_a_plan_says_what_is_varied() -> None:
    case = parse_case(CASE + 'parameter = "mu_k"\nbracket = [0, 1]', "case.toml")
    assert "    mu_k is varied from 0.0 to 1.0, and with it mu_s" in make_plan(case).describe()
