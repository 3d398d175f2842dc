"""belt-5dof: every transition against SciPy on equations typed anew, energy, impacts, re-contact.

mu_k = 0.5, mu_s = 3, k_nl = 1e4, F = 200 from the all-zero state: its first 50 events are slip in
both directions, stick, reversal, separation and landing in both directions.
"""

from __future__ import annotations

from collections.abc import Mapping
from itertools import product

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from lumped_reference import PHI, X1, FiveDof
from motions import TIGHT, booked, defaults, motion, times, transitions

from fiv_cli.analyses.base import SolverSettings
from fiv_cli.analyses.common import Balance
from fiv_cli.codegen.codes import CODE_SEPARATION, CODE_SLIP_PLUS
from fiv_cli.dynamics.motion import Motion, Stop

FIRST = 50  # events compared one by one
GOOD = 1e-9  # s, to which event times are certified
FIRST_50 = 1.2  # s: within it lie the first 50 events at each of MU_K
MU_K = (0.5, 1.4, 2.5)
Options = Mapping[str, str]
CHOICES = {
    "contact_stiffness": ("nonlinear", "linear"),
    "geometry": ("nonlinear", "linear"),
    "impact": ("plastic", "thesis", "none"),
    "slope_force": ("omit", "include"),
}
ALL_CHOICES: list[dict[str, str]] = [
    dict(zip(CHOICES, chosen, strict=True)) for chosen in product(*CHOICES.values())
]
# Each value of each option, and those pairs in which one changes what the other does.
CHOSEN: list[dict[str, str]] = [
    {},
    {"contact_stiffness": "linear"},
    {"geometry": "linear"},
    {"impact": "none"},
    {"impact": "thesis"},
    {"slope_force": "include"},
    {"slope_force": "include", "impact": "thesis"},
]
COORDINATES = ("x1", "y1", "x2", "y2", "phi")
STATES = (*COORDINATES, *(f"{name}_dot" for name in COORDINATES))


def five(start: Mapping[str, float] | None = None, options: Options | None = None,
         solver: SolverSettings = TIGHT, **changes: float) -> Motion:  # fmt: skip
    """The slider on the belt at the thesis' parameters of Figure 6.7."""
    return motion("belt-5dof", "coulomb", start or {}, solver, options, **changes)


def reference(options: Options | None = None, **changes: float) -> FiveDof:
    """The independent program at the same parameters."""
    return FiveDof(defaults("belt-5dof", "coulomb", **changes), options)


def name_of(options: Options) -> str:
    """Name of a test by what it chooses."""
    return "-".join(f"{key}={value}" for key, value in options.items()) or "default"


def agrees(begun: Motion, options: Options, t_end: float, **changes: float) -> list[str]:
    """Compare the first events with the independent program; returns them in words."""
    assert begun.run(t_end) == Stop.REACHED
    expected, _ = reference(options, **changes).follow(np.zeros(10), t_end, FIRST)
    found = transitions(begun)[: len(expected)]
    assert found == [f"{event.before}->{event.after}" for event in expected]
    assert begun.n_events == len(expected) or len(expected) == FIRST
    apart = times(begun)[: len(expected)] - np.array([event.time for event in expected])
    assert np.max(np.abs(apart)) < GOOD / 100
    return found


# --- the first 50 events -------------------------------------------------------------------------
@pytest.mark.parametrize("mu_k", MU_K)
def test_the_first_50_events_against_an_independent_program(mu_k: float) -> None:
    found = agrees(five(mu_k=mu_k), {}, FIRST_50, mu_k=mu_k)
    assert len(found) == FIRST
    kinds = {"slip+->stick", "stick->slip+", "slip+->slip-", "slip+->separation"}
    assert kinds | {"separation->slip+"} <= set(found)
    if mu_k == MU_K[0]:
        assert {"slip-->stick", "stick->slip-", "separation->slip-"} <= set(found)


@pytest.mark.parametrize("mu_k", MU_K)
def test_the_first_50_events_do_not_depend_on_order_and_tolerance(mu_k: float) -> None:
    """Orders 14 to 19; the time of every event moves by no more than the tolerance's share."""
    exact = five(mu_k=mu_k)
    exact.run(FIRST_50)
    for rtol in (1e-8, 1e-10, 1e-12):
        other = five(mu_k=mu_k, solver=SolverSettings(rtol=rtol))
        assert other.system.generated.order < exact.system.generated.order
        other.run(FIRST_50)
        assert transitions(other)[:FIRST] == transitions(exact)[:FIRST]
        apart = np.abs(times(other)[:FIRST] - times(exact)[:FIRST])
        assert np.max(apart) < max(1e-11, 10 * rtol)
        if rtol <= 1e-10:
            assert np.max(apart) < GOOD


@pytest.mark.parametrize("mu_k", MU_K)
def test_the_first_50_events_by_runge_kutta_with_bisection(mu_k: float) -> None:
    """The thesis' fixed step: its error falls with the fourth power of the step, through events."""
    exact = five(mu_k=mu_k)
    exact.run(FIRST_50)
    errors = []
    for step in (1e-4, 5e-5):
        rough = five(mu_k=mu_k, solver=SolverSettings("rk4", TIGHT.rtol, step))
        rough.run(FIRST_50)
        assert transitions(rough)[:FIRST] == transitions(exact)[:FIRST]
        errors.append(float(np.max(np.abs(times(rough)[:FIRST] - times(exact)[:FIRST]))))
    assert errors[1] < GOOD
    assert errors[1] < errors[0] / 12


# --- options -------------------------------------------------------------------------------------
@pytest.mark.parametrize("options", CHOSEN, ids=name_of)
def test_options_against_an_independent_program(options: Options) -> None:
    agrees(five(options=options, mu_k=0.5), options, 0.7, mu_k=0.5)


@pytest.mark.campaign
@pytest.mark.parametrize("mu_k", MU_K)
@pytest.mark.parametrize("options", ALL_CHOICES, ids=name_of)
def test_all_options_against_an_independent_program(options: Options, mu_k: float) -> None:
    agrees(five(options=options, mu_k=mu_k), options, FIRST_50, mu_k=mu_k)


@pytest.mark.parametrize("options", CHOSEN, ids=name_of)
def test_energy_balances_through_stick_slip_and_impacts(options: Options) -> None:
    """Friction, dampers and impacts book their work; the belt's power is booked too."""
    begun = five(options=options, mu_k=1.4)
    found = booked(begun, 2.0)
    assert found.residual < 1e-11
    assert begun.frame.n_impacts > 10 or options.get("impact") == "none"
    assert found.drive > found.other > -found.drive  # the belt drives what the dampers take


@pytest.mark.parametrize("options", CHOSEN[:4], ids=name_of)
def test_bilateral_sliding_against_an_independent_program(options: Options) -> None:
    """Unstable sliding grows; friction keeps its sign, the normal force may pull."""
    chosen = {**options, "states": "slip"}
    begun = five(options=chosen, mu_k=2.5, solver=SolverSettings(rtol=1e-12))
    found = booked(begun, 0.1)
    assert found.residual < 1e-11
    assert begun.n_events == 0
    _, expected = reference(chosen, mu_k=2.5).follow(np.zeros(10), 0.1, 1)
    present = [STATES.index(name) for name in begun.system.state_names]
    scale = np.max(np.abs(expected))
    np.testing.assert_allclose(begun.y, expected[present], atol=1e-10 * scale)


def test_unbounded_growth_is_told_as_divergence() -> None:
    begun = five(options={"states": "slip"}, mu_k=2.5, solver=SolverSettings(rtol=1e-9))
    assert begun.run(100.0) == Stop.DIVERGED
    assert np.all(np.isfinite(begun.y))


# --- impacts -------------------------------------------------------------------------------------
MASSES = {"x1": 1.0, "y1": 1.0, "x2": 1.0, "y2": 1.0, "phi": 0.1}  # M, M, m, m, J of Table 6.1


class Landing:
    """The first landing of a motion: what is known of it without the program under test.

    Attributes
    ----------
    time : of the landing, s
    found : energy balance from the start to just after the landing
    before, after : states by name on both sides, `after` by the independent program
    rate, lever, tilt : rate of compression, x1 - x2, and phi where it enters the impulse
    loss : T before minus T after, J
    """

    def __init__(self, options: Options, start: Mapping[str, float]) -> None:
        other, flight = reference(options), five(start, options)
        assert flight.codes == [CODE_SEPARATION]
        flight.run(0.2)
        self.time = times(flight)[0]
        flight = five(start, {**options, "impact": "none"})
        flight.run(self.time)  # without an impact law the state at the landing is that before it
        self.before = dict(zip(flight.system.state_names, flight.y, strict=True))
        state = np.array([self.before.get(name, 0.0) for name in STATES])
        landed = other.struck(state)
        self.after = dict(zip(STATES, landed, strict=True))
        self.rate, self.rate_after = other.compression_rate(state), other.compression_rate(landed)
        self.lever = self.before["x1"] - self.before["x2"]
        self.tilt = self.before["phi"] if options.get("slope_force") == "include" else 0.0
        self.loss = other.kinetic(state) - other.kinetic(landed)
        self.begun = five(start, options)
        self.found = booked(self.begun, self.time + 1e-7)
        assert self.begun.frame.n_impacts == (options.get("impact") != "none")


@st.composite
def flights(draw: st.DrawFn) -> dict[str, float]:
    """A start above the belt: the gap is y1 - y2 + (x1 - x2) phi."""
    x1, phi = draw(st.floats(-0.05, 0.05)), draw(st.floats(-0.2, 0.2))
    gap, fall = draw(st.floats(1e-4, 1e-2)), draw(st.floats(0.0, 2.0))
    slide = draw(st.floats(-2.0, 3.0))
    return {"x1": x1, "phi": phi, "y1": gap - x1 * phi, "y1_dot": -fall, "x1_dot": slide}


@settings(max_examples=20)
@given(start=flights())
def test_an_impact_along_the_whole_gap_gradient_costs_half_the_reduced_mass(
    start: dict[str, float],
) -> None:
    """slope_force = include: exactly half the reduced mass times the square of the gap rate."""
    landing = Landing({"slope_force": "include"}, start)
    flexibility = 2 / 1.0 + landing.lever**2 / 0.1 + 2 * landing.tilt**2 / 1.0
    expected = landing.rate**2 / flexibility / 2
    assert landing.found.impact == pytest.approx(expected, rel=1e-9)
    assert landing.found.residual < 1e-11


@settings(max_examples=20)
@given(start=flights())
def test_an_impact_without_slope_force_ends_the_gap_rate_and_keeps_its_momenta(
    start: dict[str, float],
) -> None:
    """slope_force = omit: T before minus T after is booked; x1 and x2 are not touched."""
    landing = Landing({}, start)
    begun = five(landing.after, time=landing.time)
    begun.run(landing.time + 1e-7)
    np.testing.assert_allclose(begun.y, landing.begun.y, atol=1e-11)
    assert abs(landing.rate_after) < 1e-13
    change = {
        name: MASSES[name] * (landing.after[f"{name}_dot"] - landing.before[f"{name}_dot"])
        for name in COORDINATES
    }
    assert change["x1"] == change["x2"] == 0.0
    assert change["y1"] + change["y2"] == pytest.approx(0.0, abs=1e-13)
    assert change["phi"] == pytest.approx(landing.lever * change["y1"], abs=1e-13)
    assert landing.found.impact == pytest.approx(landing.loss, rel=1e-9, abs=1e-13)
    assert landing.found.residual < 1e-11


@pytest.mark.parametrize(("slide", "opens"), [(2.0, True), (-2.0, False)])
def test_the_literal_impact_leaves_a_gap_rate(slide: float, opens: bool) -> None:
    """6.14 misses (x1' - x2') phi: that gap rate is left, and opens the contact or presses it."""
    start = {"x1": 0.02, "phi": 0.1, "y1": 0.0, "y1_dot": -1.0, "x1_dot": slide}
    landing = Landing({"impact": "thesis"}, start)
    left = (landing.before["x1_dot"] - landing.before["x2_dot"]) * landing.before["phi"]
    assert -landing.rate_after == pytest.approx(left, rel=1e-10)
    assert (left > 0.1) == opens
    assert (landing.begun.codes == [CODE_SEPARATION]) == opens
    assert landing.found.impact == pytest.approx(landing.loss, rel=1e-9)


def test_without_an_impact_law_nothing_is_lost() -> None:
    landing = Landing({"impact": "none"}, {"x1": 0.02, "phi": 0.1, "y1": 0.0, "y1_dot": -1.0})
    assert landing.found.impact == 0.0
    assert landing.after == landing.before
    assert landing.begun.codes != [CODE_SEPARATION]


# --- neutral mechanics ---------------------------------------------------------------------------
FREE = dict.fromkeys(("c1", "c2", "c4", "c5", "c6", "mu_k", "mu_s"), 0.0)


def drift(found: Balance) -> float:
    """Change of T + U over the motion, relative."""
    change = found.kinetic_potential_after - found.kinetic_potential_before
    return abs(change / found.kinetic_potential_before)


@pytest.mark.parametrize("slope_force", ["omit", "include"])
def test_only_the_slope_force_makes_the_mechanics_neutral(slope_force: str) -> None:
    """Without friction and dampers the energy stays only if the contact has a potential."""
    start = {"x1": 0.01, "phi": 0.02, "y1": -0.12, "phi_dot": 0.5, "x1_dot": 0.5}
    begun = five(start, {"slope_force": slope_force}, F=600.0, **FREE)
    found = booked(begun, 1.0)
    assert begun.frame.n_impacts == 0
    assert not any("separation" in word for word in transitions(begun))
    assert drift(found) < 1e-11 if slope_force == "include" else drift(found) > 1e-4
    assert found.residual < 1e-12


@pytest.mark.parametrize("slope_force", ["omit", "include"])
def test_bouncing_without_friction_and_impact_law(slope_force: str) -> None:
    """impact = none: the contact spring gives back what it takes, through many landings."""
    options = {"slope_force": slope_force, "impact": "none"}
    begun = five({"y1": 0.01, "x1": 0.02, "phi": 0.05}, options, **FREE)
    found = booked(begun, 1.0)
    assert sum(word.startswith("separation") for word in transitions(begun)) > 5
    assert drift(found) < 1e-11 if slope_force == "include" else drift(found) > 1e-4
    assert found.residual < 1e-12


# --- re-contact at zero compression and zero gap rate ---------------------------------------------
@pytest.mark.parametrize(("height", "code"), [(0.001, CODE_SLIP_PLUS), (0.02, CODE_SEPARATION)])
def test_the_gap_acceleration_decides_at_the_belt(height: float, code: int) -> None:
    """Slider and belt held up together: the preload presses, the belt's springs pull it away."""
    start = {"x1_dot": 0.5, "y1": height, "y2": height}
    gap_acceleration = -200.0 - 3e3 * height + 2e4 * height
    assert (gap_acceleration < 0.0) == (code == CODE_SLIP_PLUS)
    begun = five(start)
    assert begun.codes == [code]
    begun.run(1e-4)
    assert begun.n_events == 0
    state = dict(zip(begun.system.state_names, begun.y, strict=True))
    gap = state["y1"] - state["y2"] + (state["x1"] - state["x2"]) * state["phi"]
    assert gap == pytest.approx(gap_acceleration * 1e-8 / 2, rel=0.02)


@pytest.mark.parametrize("height", [0.001, 0.02])
def test_a_landing_without_gap_rate_is_kept_or_not_by_the_acceleration(height: float) -> None:
    """The same after a plastic impact, which ends the gap rate."""
    start = {"x1_dot": 0.5, "y1": height + 1e-7, "y2": height, "y1_dot": -0.1}
    begun = five(start)
    begun.run(1e-5)
    assert begun.frame.n_impacts == 1
    after = "slip+" if height < 0.01 else "separation"
    assert transitions(begun) == [f"separation->{after}"]


@pytest.mark.parametrize(("clearance", "meets"), [(1e-9, False), (-1e-9, True)])
def test_a_flight_that_grazes_the_belt(clearance: float, meets: bool) -> None:
    """F lifts a slider that comes down to the belt, turns there and leaves again."""
    alone = {"k3": 0.0, "c2": 0.0, "F": -50.0}
    turning, speed = 0.1, 5.0  # s, m/s: lift 50 N on 1 kg
    start = {"y1": speed * turning / 2 + clearance, "y1_dot": -speed, "x1_dot": 0.5}
    begun = five(start, **alone)
    begun.run(2 * turning)
    assert transitions(begun) == (["separation->separation"] if meets else [])
    assert begun.frame.n_impacts == meets
    if meets:  # a height of 1e-9 m before the turn
        early = np.sqrt(2 * 1e-9 / 50.0)
        assert times(begun)[0] == pytest.approx(turning - early, abs=1e-9)


# --- invariances ---------------------------------------------------------------------------------
UNITS = {  # exponents of mass, length and time of each parameter and state
    "M": (1, 0, 0), "m": (1, 0, 0), "J": (1, 2, 0), "F": (1, 1, -2), "v": (0, 1, -1),
    "l1": (0, 1, 0), "l2": (0, 1, 0), "k_nl": (1, -2, -2), "mu_k": (0, 0, 0), "mu_s": (0, 0, 0),
    **{f"c{i}": (1, 0, -1) for i in (1, 2, 4, 5, 6)}, **{f"k{i}": (1, 0, -2) for i in range(1, 7)},
    "x1": (0, 1, 0), "y1": (0, 1, 0), "x2": (0, 1, 0), "y2": (0, 1, 0), "phi": (0, 0, 0),
}  # fmt: skip


def in_units(values: Mapping[str, float], factors: tuple[float, float, float]) -> dict[str, float]:
    """Values in other units of mass, length and time."""
    scaled = {}
    for name, value in values.items():
        exponents = np.array(UNITS[name.removesuffix("_dot")], float)
        exponents[2] -= name.endswith("_dot")
        scaled[name] = value * float(np.prod(np.power(factors, exponents)))
    return scaled


@settings(max_examples=10)
@given(powers=st.tuples(*[st.integers(-12, 12)] * 3))
def test_units_do_not_matter(powers: tuple[int, int, int]) -> None:
    """In units that differ by powers of two every event time is the same, to the last bit."""
    factors = tuple(2.0**power for power in powers)
    start, changes = {"x1": 0.01, "phi": 0.02}, defaults("belt-5dof", "coulomb", mu_k=0.5)
    original = five(start, **changes)
    scaled = five(in_units(start, factors), **in_units(changes, factors))  # type: ignore[arg-type]
    original.run(0.6)
    scaled.run(0.6 * factors[2])
    assert transitions(scaled) == transitions(original)
    np.testing.assert_allclose(times(scaled) / factors[2], times(original), rtol=1e-12)


def test_a_later_start_moves_every_event() -> None:
    start = {"x1": 0.01, "phi": 0.02}
    original, later = five(start, mu_k=0.5), motion("belt-5dof", "coulomb", start, TIGHT, None,
                                                    time=7.25, mu_k=0.5)  # fmt: skip
    original.run(0.6)
    later.run(7.85)
    assert transitions(later) == transitions(original)
    np.testing.assert_allclose(times(later) - 7.25, times(original), atol=1e-13)


def test_a_belt_that_runs_the_other_way_mirrors_the_motion() -> None:
    """x1, x2, phi and v change sign together; the inclined spring, which would not, is left out."""
    start = {"x1": 0.01, "phi": 0.02, "y1": -0.03}
    mirrored = {name: -value if name != "y1" else value for name, value in start.items()}
    original = five(start, mu_k=0.5, mu_s=1.0, k3=0.0)
    other = five(mirrored, mu_k=0.5, mu_s=1.0, k3=0.0, v=-1.0)
    original.run(1.0)
    other.run(1.0)
    swapped = [word.translate(str.maketrans("+-", "-+")).replace("+>", "->")
               for word in transitions(original)]  # fmt: skip
    assert transitions(other) == swapped and len(swapped) > 5
    np.testing.assert_array_equal(times(other), times(original))


def test_turning_under_the_slider_takes_part() -> None:
    """The geometric nonlinearity is really there: the gap rate has the term of phi."""
    y = np.zeros(10)
    y[X1], y[PHI], y[5 + X1] = 0.1, 0.2, 3.0
    assert reference().compression(y) == pytest.approx(-0.1 * 0.2)
    assert reference().compression_rate(y) == pytest.approx(-3.0 * 0.2)
    start = {"x1": 0.1, "phi": 0.2, "y1": -0.01, "x1_dot": 3.0}
    assert five(start).codes == [CODE_SEPARATION]  # 0.02 m below it
    assert five(start, {"geometry": "linear"}).codes != [CODE_SEPARATION]
