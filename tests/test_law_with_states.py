"""A law with an internal state: a spring that creeps, which has a closed form."""

from __future__ import annotations

import numpy as np
from scipy.linalg import expm

from fiv_cli.analyses.base import SolverSettings
from fiv_cli.codegen.setup import Setup, default_parameters
from fiv_cli.dynamics.motion import Motion
from fiv_cli.dynamics.system import build_system
from fiv_cli.friction.base import Law
from fiv_cli.models import get_model
from fiv_cli.models.base import Parameter

BELT = get_model("belt-1dof")
MAXWELL = Law(
    name="maxwell",
    title="a spring of stiffness sigma in series with a damper: F_T = sigma z, z' = v - z/tau",
    reference="",
    numerics_version=1,
    parameters=(
        Parameter("sigma", r"\sigma", "N m-1", 3.0, "stiffness", "", 0.0),
        Parameter("tau", r"\tau", "s", 0.7, "how long the spring remembers", "", 0.0),
    ),
    force=lambda slip, p: p["sigma"] * slip.states["z"],
    capacity=None,
    states={"z": "m"},
    rates=lambda slip, p: {"z": slip.v - slip.states["z"] / p["tau"]},
)


def test_an_internal_state_moves_with_the_slip() -> None:
    """m x'' = -k x - c x' + sigma z and z' = v - x' - z/tau: linear, so a matrix exponential."""
    p = default_parameters(BELT, MAXWELL, c=0.1, m=2.0)
    solver = SolverSettings(rtol=1e-13)
    begun = Motion(build_system(Setup.of(BELT, MAXWELL, parameters=p)), p, solver, {"x": 0.3})
    begun.run(5.0)
    matrix = np.zeros((4, 4))  # of x, x', z and 1
    matrix[0, 1] = 1.0
    matrix[1, :3] = np.array([-p["k"], -p["c"], p["sigma"]]) / p["m"]
    matrix[2, 1:] = -1.0, -1.0 / p["tau"], p["v"]
    expected = expm(5.0 * matrix) @ np.array([0.3, 0.0, 0.0, 1.0])
    np.testing.assert_allclose(begun.y, expected[:3], rtol=0.0, atol=1e-11)
