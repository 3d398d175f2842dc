"""Parameters that vary in time."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from motions import TIGHT, defaults

from fiv_cli.codegen.setup import Setup
from fiv_cli.dynamics.motion import Motion, Stop
from fiv_cli.dynamics.system import build_system
from fiv_cli.schedule import Schedule, make_schedule


def belt(curves: dict[str, list[tuple[float, float]]], **changes: float) -> Motion:
    """The Coulomb belt with scheduled parameters, from rest."""
    parameters = defaults("belt-1dof", "coulomb", **changes)
    schedule = make_schedule(curves)
    built = build_system(Setup.of("belt-1dof", "coulomb", rtol=TIGHT.rtol, schedule=schedule))
    return Motion(built, parameters, TIGHT, {})


def test_a_constant_schedule_changes_nothing() -> None:
    scheduled, steady = belt({"v": [(0.0, 1.0)]}), belt({})
    for motion in (scheduled, steady):
        assert motion.run(60.0) == Stop.REACHED
    assert np.allclose(scheduled.y, steady.y, atol=1e-11)


def test_a_sticking_mass_follows_a_decelerating_belt() -> None:
    """x' = v(t) in stick; the demand is k x + m v', and the mass lets go at mu_s N."""
    motion = belt({"v": [(0.0, 1.0), (10.0, 0.0)]}, k=0.01)
    motion.keep_ledger(1)
    motion.run(5.0)
    begun = float(motion.ledger.times[0])
    assert motion.codes == [2]
    x_begun = _slip_from_rest(begun)
    travelled = (5.0 - 0.05 * 25.0) - (begun - 0.05 * begun**2)
    assert motion.y[0] == pytest.approx(x_begun + travelled, abs=1e-11)
    assert motion.y[1] == pytest.approx(0.5, abs=1e-13)


def _slip_from_rest(t: float) -> float:
    """Undamped oscillator on k = 0.01 under mu_k N = 2.3 N from rest."""
    return 230.0 * (1.0 - np.cos(0.1 * t))


def test_a_kink_releases_a_sticking_mass() -> None:
    """The belt's sudden deceleration asks for more than the static capacity."""
    curves = {"v": [(0.0, 1.0), (2.0, 1.0), (2.1, 0.0)]}
    motion = belt(curves, k=1e-6)
    motion.run(1.9)
    assert motion.codes == [2]
    motion.run(2.05)
    assert motion.codes == [1]  # v' = -10 m/s^2 against 4 N/kg: it overtakes the belt
    friction = -0.23 * 10.0
    assert motion.y[1] == pytest.approx(1.0 + friction * 0.05, rel=1e-6)


def test_a_schedule_may_be_of_a_parameter_of_the_law() -> None:
    motion = belt({"mu_k": [(0.0, 0.1), (1.0, 0.3)]}, v=100.0)
    motion.run(1.0)
    # x'' + x = 1 + 2 t from rest, slipping all the time.
    expected = (1.0 - np.cos(1.0)) + 2.0 * (1.0 - np.sin(1.0))
    assert motion.y[0] == pytest.approx(expected, abs=1e-12)


@given(st.lists(st.tuples(st.floats(-50, 50), st.floats(-9, 9)), min_size=1, max_size=6), st.data())
def test_pieces_join(points: list[tuple[float, float]], data: st.DataObject) -> None:
    rising = [(t, v) for t, v in sorted(points) if abs(t) > 1e-3 or t == 0.0]
    kept = [p for i, p in enumerate(rising) if i == 0 or p[0] > rising[i - 1][0] + 1e-3]
    if not kept:
        return
    schedule = make_schedule({"v": kept})
    expected = np.interp(
        time := data.draw(st.floats(-60, 60)), [t for t, _ in kept], [v for _, v in kept]
    )
    assert schedule.values(time)["v"] == pytest.approx(expected, rel=1e-6, abs=1e-6)
    after = schedule.next_kink(time)
    assert after > time and (after == np.inf or after in schedule.kinks)


@pytest.mark.parametrize("points", [[], [(0.0, 1.0), (0.0, 2.0)], [(1.0, 1.0), (0.0, 2.0)]])
def test_curves_that_are_none_are_refused(points: list[tuple[float, float]]) -> None:
    with pytest.raises(ValueError, match="schedule of v"):
        make_schedule({"v": points})


def test_no_schedule_has_no_kinks() -> None:
    assert Schedule().next_kink(0.0) == np.inf and not Schedule().names
