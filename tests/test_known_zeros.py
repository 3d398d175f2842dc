"""What is known to be zero where a contact state is decided is not asked of rounding.

Each test fails without one case of `known_zeros_of` in the kernel, which names the test.
"""

from __future__ import annotations

import numpy as np
import pytest
from motions import defaults, motion, transitions

from fiv_cli.codegen.codes import CODE_SLIP_MINUS, CODE_SLIP_PLUS, CODE_STICK
from fiv_cli.codegen.setup import Setup
from fiv_cli.dynamics.motion import Motion, Stop
from fiv_cli.dynamics.settings import SolverSettings
from fiv_cli.dynamics.system import build_system
from fiv_cli.schedule import make_schedule

LOOSE = SolverSettings(rtol=1e-4)


@pytest.mark.parametrize("law", ["linear-slope", "exponential"])
def test_a_release_at_all_the_capacity_goes_on(law: str) -> None:
    """The friction of slip begins with the force that held: their difference is rounding."""
    for Omega in np.linspace(0.1, 0.5, 100):
        begun = motion("pin-on-disc", law, solver=LOOSE, Omega=Omega)
        assert begun.run(4.0) == Stop.REACHED
        assert "stick->slip+" in transitions(begun)


@pytest.mark.parametrize("law", ["coulomb", "stribeck"])
@pytest.mark.parametrize(("edge", "code"), [(-0.014, CODE_STICK), (0.011, CODE_SLIP_PLUS)])
def test_a_start_at_all_the_capacity_goes_on(law: str, edge: float, code: int) -> None:
    """Carried by a belt towards the spring's rest it sticks, away from it it slips at once."""
    held = {"m": 5.0, "k": 2000.0, "c": 10.0, "N": 50.0, "v": 0.3, "mu_s": 0.5, "mu_k": 0.3}
    for ulps in range(-20, 21):
        start = {"x": edge * (1 + ulps * 2.0**-52), "x_dot": 0.3}
        begun = motion("belt-1dof", law, start, **held)
        assert begun.codes == [code]
        assert begun.run(0.5) == Stop.REACHED


@pytest.mark.parametrize(("turn", "code"), [(-10.0, CODE_SLIP_MINUS), (10.0, CODE_SLIP_PLUS)])
def test_what_stuck_slides_the_way_it_is_left_behind(turn: float, code: int) -> None:
    """A box on a belt that jerks: the last digits of its slip velocity say nothing.

    Without a spring its motion is a polynomial, with no time in which they would be small.
    """
    parameters = defaults("belt-1dof", "coulomb", k=0.0)
    solver = SolverSettings(max_steps=1000)
    for rise in np.linspace(0.1, 0.9, 20):
        belt = make_schedule({"v": [(0.0, 1.0), (2.0, 1.0 + rise), (3.0, 1.0 + rise + turn)]})
        built = build_system(Setup.of("belt-1dof", "coulomb", rtol=solver.rtol, schedule=belt))
        begun = Motion(built, parameters, solver, {})
        begun.run(1.9)
        assert begun.codes == [CODE_STICK]
        assert begun.run(2.05) == Stop.REACHED
        assert begun.codes == [code]


def test_a_contact_that_opens_has_no_gap() -> None:
    """Where the normal force vanishes the gap is zero, whatever its last digits are."""
    slider = {"v": 0.0431, "mu_s": 0.862, "mu_k": 0.3, "F": 66.4, "k_nl": 410.0}
    begun = motion("belt-5dof", "stribeck", solver=LOOSE, **slider)
    assert begun.run(5.0) == Stop.REACHED
    assert "slip+->separation" in transitions(begun)
