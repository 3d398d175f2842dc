"""How answers on the disc converge with the number of its modes, and which do not.

Fast: chapter 4's slider in rigid contact as `disc_reference.py` has it, with any set of modes, held
against the program for the thesis' seven.
"""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest
from disc_reference import NORMAL, RigidContact, Shape
from motions import defaults
from numpy.typing import NDArray
from scipy.integrate import solve_ivp

from fiv_cli.api import analyse
from fiv_cli.dynamics.settings import Section
from fiv_cli.models import disc
from fiv_cli.plate import mode

Real = NDArray[np.float64]
PLATE = disc.plate_of(defaults("disc-rigid-contact", "exponential"))
LARGEST = 20  # diameters and twice the circles of a mode: all of the first ninety lie below
STEP = 1e-30  # of a complex step
LOW = 3000.0  # rad/s: above the thesis' seven modes, below the next

STRONGLY_DAMPED = {"c_z": 2.0, "C_phi": 0.5, "alpha": 1.0, "Omega": 2 * np.pi}  # Figure 4.13
RESTING = {  # Figures 4.6 and 4.4: sliding is stable with seven modes
    "4.6": {"c_z": 1.0, "C_phi": 2.0, "alpha": 0.0, "Omega": 1.0},
    "4.4": {"c_z": 11.0, "C_phi": 1.0, "alpha": 10.0, "Omega": 10.0},
}


@cache
def modes() -> list[Shape]:
    """Modes by frequency, as large as 1 at the slider; a doublet twice."""
    found = []
    for circles in range(LARGEST // 2):
        for diameters in range(LARGEST - 2 * circles):
            plain = mode(PLATE, circles, diameters)
            mass = 1.0 / plain.inverse_modal_mass(0.1)
            parts = (False, True) if diameters else (False,)
            found += [Shape(diameters, sine, 1.0, mass, plain.frequency) for sine in parts]
    return sorted(found, key=lambda shape: shape.frequency)


def compliance(count: int) -> float:
    """Displacement of the slider's place under a unit load at rest, m/N, with `count` modes."""
    # of a doublet at rest one mode is moved
    return sum((0.5 if m.diameters else 1.0) / m.mass / m.frequency**2 for m in modes()[:count])


class Sliding(RigidContact):
    """Slip in contact (thesis 4.33-4.39): state (phi, q...) and rates, z being w(r0, phi)."""

    def __init__(self, count: int, **changes: float) -> None:
        parameters = defaults("disc-rigid-contact", "exponential", **changes)
        super().__init__(parameters, modes=modes()[:count])
        self.half = 1 + count

    def accelerations(self, y: NDArray[np.generic]) -> tuple[NDArray[np.generic], complex]:
        """phi'', q'' and F_N."""
        full = np.insert(y, [NORMAL, self.half + NORMAL], 0.0)
        full[NORMAL] = -self.gap(full)
        full[self.size + NORMAL] = -self.gap_rate(full)
        found, normal, _ = self.solve(0.0, full, False, 1.0)
        return np.delete(found, NORMAL), normal

    def rates(self, y: NDArray[np.generic]) -> NDArray[np.generic]:
        """Of the whole state."""
        return np.concatenate([y[self.half :], self.accelerations(y)[0]])

    def jacobian(self, y: Real) -> Real:
        """Of the rates, by complex steps."""
        steps = y.astype(complex) + 1j * STEP * np.eye(len(y))
        return np.array([self.rates(row).imag / STEP for row in steps]).T

    def equilibrium(self) -> Real:
        """The sliding equilibrium, by Newton's method."""
        y = np.zeros(2 * self.half)
        for _ in range(20):
            stiffness = self.jacobian(y)[self.half :, : self.half]
            y[: self.half] -= np.linalg.solve(stiffness, self.accelerations(y)[0])
        return y

    def eigenvalues(self) -> NDArray[np.complex128]:
        """Of sliding, those of positive frequency by rising frequency."""
        found = np.linalg.eigvals(self.jacobian(self.equilibrium()))
        found = found[found.imag > 0.0]
        return found[np.argsort(found.imag)]


@pytest.mark.parametrize("changes", [STRONGLY_DAMPED, *RESTING.values()])
def test_the_seven_modes_are_those_of_the_program(changes: dict[str, float]) -> None:
    values = analyse("disc-rigid-contact", "exponential", "eigenvalues", {}, {}, **changes).values
    expected = values["eigenvalue_real"] + 1j * values["eigenvalue_imag"]
    expected = expected[expected.imag > 0.0]
    assert Sliding(7, **changes).eigenvalues() == pytest.approx(expected, rel=1e-9)


def test_the_compliance_converges_as_the_reciprocal_of_the_number_of_modes() -> None:
    """A plate's frequencies rise in proportion to the number of the mode, so 1/n is left out."""
    few, more, most = 31, 62, 88
    rate = (compliance(more) - compliance(few)) / (1.0 / few - 1.0 / more)
    step = compliance(most) - compliance(more)
    assert step == pytest.approx(rate * (1.0 / more - 1.0 / most), rel=0.1)
    limit = compliance(most) + rate / most
    assert 1.0 - compliance(7) / limit == pytest.approx(0.10, abs=0.005)


@pytest.mark.parametrize("count", [7, 13, 32])
def test_the_normal_force_of_sliding_follows_the_compliance(count: int) -> None:
    """F_N = N0/(1 + k_z S), S the compliance: the moment of friction lifts one side by as much."""
    sliding = Sliding(count, Omega=1e-6)
    normal = sliding.accelerations(sliding.equilibrium())[1]
    assert normal == pytest.approx(500.0 / (1.0 + 3e4 * compliance(count)), rel=1e-9)


def test_eigenvalues_of_low_modes_move_in_proportion_to_the_compliance_left_out() -> None:
    """... so with 1/n as well; with seven modes frequencies are right to 1 %, growth to 10 %."""
    low = {n: Sliding(n, **STRONGLY_DAMPED).eigenvalues()[:8] for n in (7, 13, 22, 45)}
    assert all(np.all(values.imag < LOW) for values in low.values())
    per_compliance = [
        abs(low[many][0] - low[few][0]) / (compliance(many) - compliance(few))
        for few, many in ((7, 13), (13, 22), (22, 45))
    ]
    assert per_compliance == pytest.approx(np.full(3, per_compliance[0]), rel=0.06)
    assert low[7].imag == pytest.approx(low[45].imag, rel=0.011)
    grown = low[45].real.max()
    assert 0.05 < low[7].real.max() / grown - 1.0 < 0.12
    assert low[22].real.max() == pytest.approx(grown, rel=0.015)


@pytest.mark.parametrize("changes", RESTING.values(), ids=RESTING)
def test_modes_beyond_the_seven_bring_instabilities_of_their_own(changes: dict[str, float]) -> None:
    """They are hardly damped: nothing but the contact does it, where they hardly move the slider.

    A damping ratio of 2e-4 of the disc is more than any of them grows by.
    """
    assert Sliding(7, **changes).eigenvalues().real.max() < 0.0
    for count in (13, 22, 32, 45):
        values = Sliding(count, **changes).eigenvalues()
        growing = values[values.real > 0.0]
        assert np.all(growing.imag > LOW)
        assert 0.1 < growing.real.max() < 2.5
        assert np.max(growing.real / growing.imag) < 1e-4
        assert Sliding(count, xi=2e-4, **changes).eigenvalues().real.max() < 0.0


def test_a_short_motion_converges_with_the_compliance() -> None:
    """The slider laid on the disc at rest; the disc is fast enough for no stick."""
    moved = {}
    for count in (7, 13, 22, 45):
        sliding = Sliding(count, Omega=300.0, C_phi=0.5, c_z=2.0)
        start = np.zeros(2 * sliding.half)
        times = np.linspace(0.0, 4e-3, 41)
        found = solve_ivp(
            lambda t, y, s=sliding: s.rates(y), (0.0, 4e-3), start, "DOP853", times,
            rtol=1e-8, atol=1e-11,
        )  # fmt: skip
        assert np.max(found.y[sliding.half]) < 300.0
        assert all(sliding.accelerations(y)[1] > 0.0 for y in found.y.T)
        moved[count] = found.y[0]
    apart = {n: np.max(np.abs(moved[n] - moved[45])) / np.ptp(moved[45]) for n in (7, 13, 22)}
    assert 0.01 < apart[7] < 0.1
    assert apart[13] < apart[7] / 2
    assert apart[22] < apart[13]


MODES = {7: "0,0 0,1 0,2 0,3", 13: "0,0 0,1 0,2 0,3 0,4 0,5 0,6"}


@pytest.mark.campaign
@pytest.mark.parametrize(
    ("xi", "count", "expected"),
    [(0.0, 7, 206.0), (0.0, 13, None), (2e-4, 7, 205.7), (2e-4, 13, 204.2)],
)
def test_stick_slip_of_seven_modes_is_that_of_thirteen_on_a_damped_disc_only(
    xi: float, count: int, expected: float | None
) -> None:
    """Figure 4.13, from rest: 206 Hz. Thirteen modes without damping give some 274 Hz."""
    settings = {"observe": "phi", "f_max": 400.0, "resolution": 1.0, "t_max": 20.0}
    found = analyse(
        "disc-rigid-contact", "exponential", "spectrum", {},
        settings | {"section": Section("event", "slip->stick")}, None, {"modes": MODES[count]},
        xi=xi, **STRONGLY_DAMPED,
    ).values["response_frequency"]  # fmt: skip
    if expected is None:
        assert abs(found - 206.0) > 10.0
    else:
        assert found == pytest.approx(expected, abs=0.5)
