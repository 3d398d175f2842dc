"""Contacts that open and close, and several contacts at once, on small models."""

from __future__ import annotations

from itertools import pairwise
from math import cos, pi, sin, sqrt
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from motions import booked, by_both, ledger, motion, times, transitions
from small_models import BOUNCER, TWO_BOUNCERS, TWO_MASSES

from fiv_cli.codegen.codes import CODE_SEPARATION, CODE_SLIP_PLUS, CODE_STICK, SEPARATION
from fiv_cli.dynamics.motion import Motion, Stop, samples_at

G = 10.0
LIFT_PHASE = pi / 3  # s: cos(3 t) = -1, the lifting force A cos(3 t) is at its lowest
RIGID, COMPLIANT, ELASTIC = ({"contact": c} for c in ("rigid", "compliant", "elastic"))


# --- separation and plastic re-contact -----------------------------------------------------------
@given(
    z=st.floats(0.1, 5.0), z_dot=st.floats(-3.0, 3.0), x=st.floats(-1.0, 1.0),
    x_dot=st.floats(-2.0, 2.0),
)  # fmt: skip
def test_free_flight_is_a_parabola_and_lands_plastically(
    z: float, z_dot: float, x: float, x_dot: float
) -> None:
    """The gap rate is lost, and with it half the mass times its square; x is not touched."""
    begun = motion(BOUNCER, start={"z": z, "z_dot": z_dot, "x": x, "x_dot": x_dot})
    landing = (z_dot + sqrt(z_dot**2 + 2 * G * z)) / G
    assert begun.run(0.5 * landing) == Stop.REACHED
    flown = begun.time
    assert begun.y[1] == pytest.approx(z + z_dot * flown - G * flown**2 / 2, abs=1e-12)
    found = booked(begun, landing + 1e-6)
    assert times(begun)[0] == pytest.approx(landing, abs=1e-12)
    assert found.impact == pytest.approx((G * landing - z_dot) ** 2 / 2, rel=1e-11)
    assert found.residual < 1e-11
    assert (begun.y[1], begun.y[3]) == (0.0, 0.0)
    assert begun.y[0] == pytest.approx(x * cos(landing) + x_dot * sin(landing), abs=1e-5)


@pytest.mark.parametrize(("x_dot", "lands"), [(1.0, "stick"), (0.5, "slip+"), (1.5, "slip-")])
def test_the_slip_velocity_at_landing_decides(x_dot: float, lands: str) -> None:
    begun = motion(BOUNCER, start={"z": 1.0, "x_dot": x_dot}, k=0.0)
    begun.run(0.5)
    assert transitions(begun)[0] == f"separation->{lands}"


def test_a_harmonic_lift_separates_where_the_normal_force_vanishes() -> None:
    """m g = A cos(omega t): closed form of the instant and of the flight after it."""
    begun = motion(BOUNCER, start={}, A=15.0, time=LIFT_PHASE, k=0.0)
    begun.run(2.5)
    assert transitions(begun) == ["slip+->stick", "stick->slip+", "slip+->separation"]
    lift = times(begun)[-1]
    assert times(begun)[1] == pytest.approx(lift, abs=1e-12)  # no normal force, no capacity
    expected = (2 * pi - np.arccos(G / 15.0)) / 3.0
    assert lift == pytest.approx(expected, abs=1e-12)
    tau = 2.5 - lift
    phase, begin = 3.0 * 2.5, 3.0 * lift
    height = -G * tau**2 / 2 - 15.0 / 9 * (cos(phase) - cos(begin)) - 15.0 / 3 * sin(begin) * tau
    assert begun.y[1] == pytest.approx(height, abs=1e-11)


def test_bouncing_on_a_lifted_belt_repeats_and_balances() -> None:
    begun = motion(BOUNCER, start={}, A=15.0)
    found = booked(begun, 60.0)
    assert begun.frame.n_impacts > 20
    assert found.residual < 1e-12
    assert found.impact > 0.0
    opened = [w for w in transitions(begun) if w.endswith("->separation")]
    closed = [w for w in transitions(begun) if w.startswith("separation->")]
    assert abs(len(opened) - len(closed)) <= 1
    assert all("separation" in a or "separation" not in b for a, b in pairwise(opened + closed))


@pytest.mark.parametrize("options", [RIGID, COMPLIANT, ELASTIC], ids=lambda o: o["contact"])
def test_two_integrators_agree_through_separation(options: Any) -> None:
    start = {"z": 0.2, "x_dot": 0.3}
    begun, rough = by_both(3.5, 2e-4, BOUNCER, start=start, options=options, A=15.0, k_c=200.0)
    assert begun.n_events >= 6
    np.testing.assert_allclose(begun.y, rough.y, atol=1e-7)


# --- compliant contacts --------------------------------------------------------------------------
@pytest.mark.parametrize("gravity", [10.0, -10.0])
def test_a_compliant_contact_begins_at_zero_compression_and_zero_rate(gravity: float) -> None:
    """After a plastic impact only the gap acceleration tells whether contact is kept."""
    begun = motion(BOUNCER, start={"z": 1.0, "z_dot": -8.0}, options=COMPLIANT, g=gravity, mu_s=9.0)
    begun.run(1.0)
    kept = gravity > 0.0
    assert transitions(begun)[0] == ("separation->slip+" if kept else "separation->separation")
    if not kept:
        tau = 1.0 - times(begun)[0]
        assert begun.y[1] == pytest.approx(10.0 * tau**2 / 2, abs=1e-11)
    assert begun.frame.n_impacts == 1


def test_an_elastic_contact_returns_what_it_takes() -> None:
    """Without an impact law the spring gives the mass back its speed."""
    begun = motion(BOUNCER, start={"z": 1.0}, options=ELASTIC, mu_k=0.0, mu_s=0.0)
    found = booked(begun, 6.0)
    assert begun.frame.n_impacts == 0
    assert found.residual < 1e-12
    landings = [t for t, w in zip(times(begun), transitions(begun), strict=True) if w[:3] == "sep"]
    landing = sqrt(2 / G)
    stiffness, speed = 1e4, G * landing
    frequency = sqrt(stiffness)
    contact = 2 * (pi - np.arctan2(speed * frequency, G)) / frequency
    np.testing.assert_allclose(np.diff(landings), 2 * landing + contact, rtol=1e-11)
    assert landings[0] == pytest.approx(landing, abs=1e-13)


@pytest.mark.parametrize("options", [RIGID, COMPLIANT, ELASTIC], ids=lambda o: o["contact"])
@pytest.mark.parametrize(
    ("start", "code"),
    [
        ({"z": 0.0, "z_dot": 2.0}, CODE_SEPARATION),
        ({"z": 0.0, "z_dot": -2.0}, CODE_SLIP_PLUS),
        ({"z": 0.0}, CODE_SLIP_PLUS),
        ({"z": 0.0, "x_dot": 1.0}, CODE_STICK),
        ({"z": 1e-9}, CODE_SEPARATION),
    ],
)
def test_starts_on_the_border_of_contact(options: Any, start: Any, code: int) -> None:
    begun = motion(BOUNCER, start=start, options=options)
    if "x_dot" in start and options is not RIGID:
        code = CODE_STICK if begun.codes == [CODE_STICK] else CODE_SLIP_PLUS
    assert begun.codes == [code]
    assert begun.run(0.1) == Stop.REACHED


def test_a_start_that_is_lifted_separates_at_once() -> None:
    begun = motion(BOUNCER, start={}, A=15.0)
    assert begun.codes == [CODE_SEPARATION]
    begun.run(0.1)
    assert begun.y[1] == pytest.approx(-G * 0.01 / 2 + 15.0 / 9 * (1 - cos(0.3)), abs=1e-13)


# --- two masses on one belt ----------------------------------------------------------------------
def two_sticking(**changes: float) -> Motion:
    """Two masses that stick from the start."""
    begun = motion(TWO_MASSES, start={"x1_dot": 1.0, "x2_dot": 1.0}, **changes)
    assert begun.codes == [CODE_STICK] * 2
    return begun


@pytest.mark.parametrize(
    ("normal", "first", "released"),
    [((10.0, 8.0), 2, 3.2), ((8.0, 10.0), 1, 3.2), ((10.0, 3.0), 2, 1.2)],
)
def test_the_weaker_contact_releases_first(normal: Any, first: int, released: float) -> None:
    """Both move with the belt: their springs reach mu_s N one after the other."""
    begun = two_sticking(N1=normal[0], N2=normal[1])
    begun.run(released + 0.3)
    assert transitions(begun) == [f"stick->slip+ {first - 1}"]
    assert times(begun)[0] == pytest.approx(released, abs=1e-13)
    place = begun.system.state_names.index(f"x{3 - first}_dot")
    assert begun.y[place] == 1.0


def test_both_release_at_once() -> None:
    """By symmetry; each has its own row in the ledger, and neither feels the coupling."""
    begun = two_sticking()
    alone = motion("belt-1dof", start={"x_dot": 1.0}, mu_k=0.3)
    begun.run(20.0)
    alone.run(20.0)
    assert transitions(begun)[:4] == [
        "stick->slip+ 0", "stick->slip+ 1", "slip+->stick 0", "slip+->stick 1",
    ]  # fmt: skip
    np.testing.assert_allclose(times(begun)[::2], times(alone), atol=1e-11)
    assert np.array_equal(times(begun)[::2], times(begun)[1::2])
    np.testing.assert_allclose(begun.y, np.repeat(alone.y, 2), atol=1e-11)


@pytest.mark.parametrize("changes", [{"N2": 8.0}, {"k2": 1.7}, {"N1": 4.0, "k_c": 2.0}])
def test_two_masses_by_two_integrators(changes: Any) -> None:
    begun, rough = by_both(40.0, 1e-3, TWO_MASSES, start={"x1": 0.3}, **changes)
    assert {int(row[3]) for row in ledger(begun)} == {0, 1}
    np.testing.assert_allclose(begun.y, rough.y, atol=1e-8)


def test_two_masses_balance_their_energy() -> None:
    assert booked(motion(TWO_MASSES, start={"x1": 0.3}, N2=8.0), 60.0).residual < 1e-12


def test_the_sections_of_each_contact() -> None:
    from fiv_cli.dynamics.settings import Section

    for contact in (1, 2):
        begun = motion(TWO_MASSES, start={"x1": 0.3}, N2=8.0)
        found, states = np.zeros(5), np.zeros((5, 4))
        section = Section("event", "slip->stick", contact=contact)
        assert begun.run(1e3, section, (found, states)) == Stop.SECTION_FULL
        rows = ledger(begun)
        own = rows[(rows[:, 3] == contact - 1) & (rows[:, 2] == CODE_STICK)]
        assert np.array_equal(found, own[:, 0])
        assert np.all(states[:, 1 + contact] == 1.0)


# --- two contacts that open ----------------------------------------------------------------------
@settings(max_examples=20)
@given(ratio=st.floats(0.7, 2.0), height=st.floats(0.1, 2.0))
def test_two_masses_fall_and_land_each_for_itself(ratio: float, height: float) -> None:
    begun = motion(TWO_BOUNCERS, start={"z1": height, "z2": ratio * height}, m2=1.3)
    found = booked(begun, 3.0)
    falls = dict(zip(ledger(begun)[:, 3].astype(int), times(begun), strict=True))
    landings = {int(row[3]): row[0] for row in ledger(begun) if row[1] == CODE_SEPARATION}
    assert set(falls) == {0, 1}
    assert landings[0] == pytest.approx(sqrt(2 * height / G), abs=1e-12)
    assert landings[1] == pytest.approx(sqrt(2 * ratio * height / G), abs=1e-12)
    assert found.impact == pytest.approx(G * height * (1 + 1.3 * ratio), rel=1e-11)


@pytest.mark.parametrize("start", [{"z1": 1.0, "z2": 1.0}, {}], ids=["landing", "lifting"])
def test_two_contacts_at_one_instant(start: Any) -> None:
    """By symmetry both open, and both close, at once: chained, each with its row and impact."""
    begun = motion(TWO_BOUNCERS, start=start, A=15.0, time=LIFT_PHASE)
    single = motion(BOUNCER, start={"z": start.get("z1", 0.0)}, A=15.0, time=LIFT_PHASE)
    assert begun.run(9.0) == single.run(9.0) == Stop.REACHED
    assert begun.n_events == 2 * single.n_events > 10
    assert begun.frame.n_impacts == 2 * single.frame.n_impacts > 2
    np.testing.assert_allclose(times(begun)[::2], times(single), atol=1e-11)
    np.testing.assert_allclose(begun.y, np.repeat(single.y, 2), atol=1e-10)


def test_samples_know_the_contact_states() -> None:
    begun = motion(BOUNCER, start={"z": 1.0}, A=0.0)
    taken = samples_at(begun.system, np.linspace(0.0, 1.0, 101))
    begun.run(1.0, samples=taken)
    landing = sqrt(2 / G)
    flying = taken.times < landing
    assert np.all(taken.codes[flying, 0] == CODE_SEPARATION)
    assert np.all(taken.codes[~flying, 0] != CODE_SEPARATION)
    assert np.all(taken.outputs[flying, 0] == 0.0)
    np.testing.assert_allclose(taken.outputs[~flying, 0], G, rtol=1e-14)


def test_bounces_that_pile_up_end_in_contact() -> None:
    """The literal impact law of thesis 6.14 leaves the gap rate (x1' - x2') phi.

    The bounces that follow grow shorter as that rate passes zero, and infinitely many end at one
    instant: from there on the contact stays closed.
    """
    begun = motion("belt-5dof", options={"impact": "thesis"}, mu_k=1.4)
    found = booked(begun, 0.5)
    events = transitions(begun)
    assert events.count("separation->separation") > 100
    assert "separation->slip+" in events[events.index("separation->separation") :]
    assert found.residual < 1e-9


@pytest.mark.parametrize("gap", [1e-22, 1e-24])
def test_flights_shorter_than_rounding_end_in_contact(gap: float) -> None:
    """After 1e6 s a flight of picoseconds takes no time: without loss it would go on for ever."""
    moved = motion(BOUNCER, start={"z": gap}, options=ELASTIC, time=1e6)
    assert moved.run(1e6 + 1.0) == Stop.REACHED
    assert moved.kinds[0] != SEPARATION
    assert moved.n_events < 100
