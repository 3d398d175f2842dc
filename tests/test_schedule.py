"""Parameters that vary in time."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from motions import motion

from fiv_cli.dynamics.motion import Stop
from fiv_cli.schedule import Schedule, make_schedule


def test_a_constant_schedule_changes_nothing() -> None:
    scheduled, steady = motion("belt-1dof", curves={"v": [(0.0, 1.0)]}), motion("belt-1dof")
    for moved in (scheduled, steady):
        assert moved.run(60.0) == Stop.REACHED
    assert np.allclose(scheduled.y, steady.y, atol=1e-11)


def test_a_sticking_mass_follows_a_decelerating_belt() -> None:
    """x' = v(t) in stick; the demand is k x + m v', and the mass lets go at mu_s N."""
    moved = motion("belt-1dof", curves={"v": [(0.0, 1.0), (10.0, 0.0)]}, k=0.01)
    moved.run(5.0)
    begun = float(moved.ledger.times[0])
    assert moved.codes == [2]
    x_begun = _slip_from_rest(begun)
    travelled = (5.0 - 0.05 * 25.0) - (begun - 0.05 * begun**2)
    assert moved.y[0] == pytest.approx(x_begun + travelled, abs=1e-11)
    assert moved.y[1] == pytest.approx(0.5, abs=1e-13)


def _slip_from_rest(t: float) -> float:
    """Undamped oscillator on k = 0.01 under mu_k N = 2.3 N from rest."""
    return 230.0 * (1.0 - np.cos(0.1 * t))


def test_a_kink_releases_a_sticking_mass() -> None:
    """The belt's sudden deceleration asks for more than the static capacity."""
    curves = {"v": [(0.0, 1.0), (2.0, 1.0), (2.1, 0.0)]}
    moved = motion("belt-1dof", curves=curves, k=1e-6)
    moved.run(1.9)
    assert moved.codes == [2]
    moved.run(2.05)
    assert moved.codes == [1]  # v' = -10 m/s^2 against 4 N/kg: it overtakes the belt
    friction = -0.23 * 10.0
    assert moved.y[1] == pytest.approx(1.0 + friction * 0.05, rel=1e-6)


def test_a_schedule_may_be_of_a_parameter_of_the_law() -> None:
    moved = motion("belt-1dof", curves={"mu_k": [(0.0, 0.1), (1.0, 0.3)]}, v=100.0)
    moved.run(1.0)
    # x'' + x = 1 + 2 t from rest, slipping all the time.
    expected = (1.0 - np.cos(1.0)) + 2.0 * (1.0 - np.sin(1.0))
    assert moved.y[0] == pytest.approx(expected, abs=1e-12)


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
