"""Contacts whose slip velocities depend on each other: held jointly, or refused with the reason."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from motions import booked, motion, system, times, transitions
from small_models import CLUTCH, ON_TWO_BELTS, PADS, TWO_MASSES

from fiv_cli import api
from fiv_cli.analyses.base import SolverSettings
from fiv_cli.analyses.common import balance
from fiv_cli.cli.equations import equation_lines
from fiv_cli.codegen.codes import CODE_SLIP_PLUS, CODE_STICK, SLIP, STICK
from fiv_cli.dynamics.motion import Stop, samples_at
from fiv_cli.errors import UsageError
from fiv_cli.models import get_model
from fiv_cli.models.base import Equations, Options

MU = {"mu_k": 0.3, "mu_s": 0.4}
RAMP = ((0.0, 1.0), (5.0, 2.0), (200.0, 2.0))


def test_contacts_that_are_not_declared_are_refused() -> None:
    silent = replace(ON_TWO_BELTS, name="two-belts", contacts=1)
    said = r"two-belts returns 2 contacts and declares 1\nnext: write contacts=2 in its Model"
    with pytest.raises(UsageError, match=said):
        api.analyse(silent, "coulomb", "response", {"x": 0.0})
    with pytest.raises(UsageError, match=said):
        equation_lines(silent)


# --- a mass on two belts ---------------------------------------------------------------------
@pytest.mark.parametrize("load", [6.0, 10.0, 0.0])
@pytest.mark.parametrize("curve", [(), RAMP], ids=["steady", "speeding-up"])
def test_two_belts_of_one_speed_are_one(load: float, curve: Any) -> None:
    """Whatever each belt bears: as one belt that bears all, in every event, and in its energy."""
    loads = {"N1": load, "N2": 10.0 - load}
    both = {"V1": curve, "V2": curve} if curve else {}
    two = motion(ON_TWO_BELTS, start={"x": 0.3}, curves=both, **loads, **MU)
    one = motion("belt-1dof", start={"x": 0.3}, curves={"v": curve} if curve else {}, **MU)
    assert booked(two, 60.0).residual < 1e-12
    booked(one, 60.0)
    np.testing.assert_allclose(times(two)[::2], times(one), atol=1e-10)
    np.testing.assert_allclose(two.y, one.y, atol=1e-9)
    assert one.n_events >= 2
    for own in two.measures.shares:
        np.testing.assert_allclose(own, one.measures.shares[0], atol=1e-9)


@pytest.mark.parametrize("speed", [0.0, 1e-9, -1e-9, 1e-5])
@pytest.mark.parametrize(("start", "rest"), [(20.0, -2.0), (-20.0, 2.0), (25.9, 1.9)])
def test_slips_of_two_contacts_reverse_together_at_rest(
    speed: float, start: float, rest: float
) -> None:
    """On belts that stand, or nearly, all velocities vanish where the mass turns, and each swing
    is by 2 mu_k N / k shorter: 20, -14, 8, -2."""
    given = {"N1": 4.0, "N2": 6.0, "V1": speed, "V2": speed, "k": 1.0, "m": 1.0, **MU}
    begun = motion(ON_TWO_BELTS, start={"x": start}, **given)
    begun.run(40.0)
    assert begun.y[0] == pytest.approx(rest, abs=1e-10 + 100.0 * abs(speed))
    found = api.analyse(ON_TWO_BELTS, "coulomb", "response", {"x": start}, {"t_max": 60.0}, **given)
    assert found.status == "ok"


def test_what_holds_jointly_is_shared_as_it_can_be_borne() -> None:
    begun = motion(ON_TWO_BELTS, start={"x_dot": 1.0}, **MU)
    taken = samples_at(begun.system, np.linspace(0.0, 3.9, 14))
    begun.run(4.1, samples=taken)
    assert np.all(taken.codes == CODE_STICK)
    forces = taken.forces[:, :, 1]
    np.testing.assert_allclose(forces.sum(axis=1), taken.states[:, 0], atol=1e-13)
    np.testing.assert_allclose(forces[:, 0] * 4.0, forces[:, 1] * 6.0, atol=1e-13)
    # it lets go where the spring pulls with all that both can bear
    assert times(begun) == pytest.approx([4.0, 4.0], abs=1e-13)
    assert transitions(begun) == ["stick->slip+ 0", "stick->slip+ 1"]


def test_the_equations_say_that_the_parts_are_assumed() -> None:
    told = "\n".join(equation_lines(ON_TWO_BELTS))
    assert "contacts 1, 2 hold jointly" in told and "assumed" in told
    for apart in (TWO_MASSES, get_model("belt-2mass"), get_model("belt-5dof")):
        assert "jointly" not in "\n".join(equation_lines(apart))


def test_of_two_belts_of_different_speeds_one_holds() -> None:
    """Belt 2 is reached first, and holds until the spring pulls with mu_k N1 + mu_s N2."""
    begun = motion(ON_TWO_BELTS, start={"x": 0.3}, V2=0.5, **MU)
    assert booked(begun, 100.0).residual < 1e-12
    assert set(transitions(begun)) == {"slip+->stick 1", "stick->slip+ 1"}
    assert begun.measures.greatest[0] < 5.0
    caught, freed = times(begun)[2:4]
    # from 3.4 on the belt it swings about 3 with amplitude sqrt(0.16 + 0.25), and back to 2.6
    assert freed - caught == pytest.approx(0.8 / 0.5, abs=1e-12)


def test_belts_that_part_let_one_go() -> None:
    """Belt 2 speeds up from the speed of belt 1: the mass stays on belt 1, pulled ahead by 2."""
    curve = ((0.0, 1.0), (1.0, 1.0), (3.0, 3.0), (200.0, 3.0))
    begun = motion(ON_TWO_BELTS, start={"x_dot": 1.0}, curves={"V2": curve}, **MU)
    assert begun.codes == [CODE_STICK, CODE_STICK]
    begun.run(2.0)
    assert begun.codes == [CODE_STICK, CODE_SLIP_PLUS]
    begun.run(3.7)
    assert times(begun) == pytest.approx([0.3 * 4.0 + 0.4 * 6.0], abs=1e-12)


def test_the_steady_state_on_two_belts_has_a_balance() -> None:
    """The published nonsense: 947 m on a spring against friction of 6 N, and no balance at all."""
    found = api.analyse(ON_TWO_BELTS, "coulomb", "response", {"x": 0.0}, N1=6.0, N2=4.0, **MU)
    alone = api.analyse("belt-1dof", "coulomb", "response", {"x": 0.0}, N=10.0, **MU)
    assert found.values["attractor"] == "periodic"
    assert found.values["energy_residual"] < 1e-10
    assert found.values["period"] == pytest.approx(alone.values["period"], rel=1e-10)


def test_a_mass_that_a_belt_at_standstill_holds_is_stuck_beside_one_that_slides() -> None:
    """It comes to rest where belt 2, which bears 3.2, holds it against belt 1, 0.6, and spring."""
    held = {"N1": 2.0, "N2": 8.0, "V2": 0.0}
    found = api.analyse(ON_TWO_BELTS, "coulomb", "response", {"x": 8.0}, **held, **MU)
    assert (found.values["attractor"], found.reason) == ("equilibrium", "stuck")
    assert found.values["stick_fraction"].tolist() == [0.0, 1.0]
    assert found.values["slip_fraction"].tolist() == [1.0, 0.0]
    assert found.values["transient_used"] < 30.0
    assert -3.2 <= found.values["x_max"] - 0.6 <= 3.2


@pytest.mark.parametrize("speed", [0.05, 0.2, 0.25, 0.6, 0.9, 1.3])
def test_what_is_held_is_stuck_though_the_force_that_holds_it_is_solved_to_rounding(
    speed: float,
) -> None:
    """Its acceleration, the balance of forces of 12 N on 1.3 kg, is of 1e-15 m/s2, not zero."""
    held = {"m": 1.3, "k": 9.7, "N1": 3.7, "N2": 8.0, "V1": speed, "V2": 0.0}
    law = {"mu_k": 0.23, "mu_s": 0.41, "v_s": 0.5}
    found = api.analyse(ON_TWO_BELTS, "stribeck", "response", {"x": 5.3}, **held, **law)
    assert (found.values["attractor"], found.reason) == ("equilibrium", "stuck")
    drags = 3.7 * (0.23 + 0.18 * np.exp(-((speed / 0.5) ** 2)))
    assert abs(9.7 * found.values["x_max"] - drags) <= 0.41 * 8.0


def test_a_mass_that_stands_still_and_is_free_to_move_is_not_stuck() -> None:
    """The belt of mass 2 stands: it sticks; mass 1 is where its springs and friction balance."""

    def equations(symbols: Any, options: Options) -> Equations:
        found = TWO_MASSES.equations(symbols, options)
        first, second = found.contacts
        still = replace(second, slip_velocity=-symbols.velocity("x2"))
        return replace(found, contacts=(first, still))

    model = replace(TWO_MASSES, name="two-masses-on-two-belts", equations=equations)
    begun = motion(model, start={"x1": 2.0}, **MU)
    assert begun.kinds.tolist() == [SLIP, STICK] and not begun.rates().any()
    found = api.analyse(model, "coulomb", "response", {"x1": 2.0}, {"t_max": 40.0}, **MU)
    assert found.values["attractor"] == "undecided"


EQUAL = {"k1": 1.0, "k2": 1.0, "k_c": 1.2, "m": 1.0, "v": 0.1}  # what moves alike from rest


@pytest.mark.parametrize("load", [1.5, 4.0, 6.5, 9.0, 12.5, 15.5])
def test_slips_that_end_together_are_told_from_rounding(load: float) -> None:
    """Both end at one instant, which is known as closely as the tolerance asks for."""
    law = {"mu_s": 0.4, "mu_k": 0.2, "v_s": 0.5}
    loads, coarse = {"N1": load, "N2": load}, SolverSettings(rtol=1e-6)
    begun = motion(TWO_MASSES, "stribeck", solver=coarse, **EQUAL, **loads, **law)
    assert begun.run(300.0) == Stop.REACHED


# --- levers: directions that differ by a factor ------------------------------------------------
def test_a_pad_holds_by_its_lever() -> None:
    begun = motion(CLUTCH, start={"phi_dot": 1.0}, **MU)
    assert booked(begun, 20.0).residual < 1e-12
    torque = 0.4 * (0.5 * 6.0 + 1.5 * 4.0)
    np.testing.assert_allclose(times(begun)[:2], torque, atol=1e-12)
    assert transitions(begun)[:2] == ["stick->slip+ 0", "stick->slip- 1"]


# --- what cannot be resolved -------------------------------------------------------------------


@pytest.mark.parametrize(
    ("pads", "says"),
    [
        ("three", "contacts 1, 2, 3 stick at once, and their directions depend on one another"),
        ("on-one-state", "slip_coordinate"),
        ("rigid", "contacts 1, 2 stick at once, and they have one direction"),
    ],
)
def test_what_leaves_forces_open_is_refused(pads: str, says: str) -> None:
    """When the system is set up, with what to do."""
    with pytest.raises(UsageError, match=says) as refused:
        system(replace(PADS, contacts=3 if pads == "three" else 2), options={"pads": pads})
    assert "\nnext: " in str(refused.value)


def test_directions_that_meet_only_at_some_parameters() -> None:
    """Where they do and both pads come to rest, the point fails with the reason."""
    crossed = motion(PADS, start={"x_dot": 1.0}, a=1.0, **MU)
    assert crossed.codes == [CODE_STICK, CODE_STICK]
    assert booked(crossed, 30.0).residual < 1e-12
    start = {"x": 0.3}
    found = api.analyse(PADS, "coulomb", "history", start, {"t_end": 30.0, "sample": 1.0}, a=0.0)
    assert (found.status, found.reason) == ("failed", "dependent_contacts")


@pytest.mark.parametrize("start", [{"z": 1.0, "x_dot": 1.0}, {"z": 0.3, "y": 1.0}])
def test_directions_that_meet_on_the_way(start: dict[str, float]) -> None:
    """The direction of a pad turns through that of the other after a quarter of a period."""
    begun = motion(PADS, start=start, options={"pads": "turning"}, **MU)
    begun.start_measuring(np.zeros(3))
    before = begun.energy()
    assert begun.run(20.0, measuring=True) == Stop.DEPENDENT
    assert begun.time == pytest.approx(np.pi / 2, abs=1e-6)
    assert balance(begun, before).residual < 1e-12


def test_what_another_contact_holds_does_not_slip() -> None:
    """At one speed no state is met in which one belt holds the mass and the other slips on it."""
    begun = motion(ON_TWO_BELTS, start={"x": 0.3}, **MU)
    taken = samples_at(begun.system, np.linspace(0.0, 60.0, 6001))
    assert begun.run(60.0, samples=taken) == Stop.REACHED
    assert np.array_equal(taken.codes[:, 0], taken.codes[:, 1])
    assert set(np.unique(taken.codes)) >= {CODE_SLIP_PLUS, CODE_STICK}
