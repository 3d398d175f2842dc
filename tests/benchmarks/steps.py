"""What a step of a sweep costs: measured, with a tangent, as multiples of a plain one.

One core, processor time. Every run begins anew from the same state, so all take the same steps;
the least of some interleaved runs of each is compared.
"""

from __future__ import annotations

import time
from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from fiv_cli.analyses.base import SolverSettings
from fiv_cli.codegen.setup import Setup, default_parameters
from fiv_cli.dynamics.motion import Motion
from fiv_cli.dynamics.system import System, build_system
from fiv_cli.friction import get_law
from fiv_cli.models import get_model

SOLVER = SolverSettings()
ROUNDS = 7
PIECES = 32  # of a run, between which tangents are renormalised as in a window
LEAST_SECONDS = 0.01  # a run is repeated for about this long


@dataclass(frozen=True)
class Stepping:
    """A motion whose steps are timed.

    Attributes
    ----------
    name : one word
    model, changes : the model and parameters that differ from its defaults
    start : initial state, the rest 0
    t_end : s
    """

    name: str
    model: str
    changes: Mapping[str, float]
    start: Mapping[str, float]
    t_end: float
    options: Mapping[str, str] = field(default_factory=dict)

    def parameters(self) -> dict[str, float]:
        """Every parameter."""
        return default_parameters(get_model(self.model), get_law("coulomb"), **self.changes)

    def system(self) -> System:
        """The compiled system."""
        return build_system(Setup.of(self.model, "coulomb", self.options))


STEPPINGS = (
    Stepping("belt", "belt-1dof", {"u0": 0.5, "omega": 0.85}, {}, 4000.0),
    Stepping("pin", "pin-on-disc", {"Omega": 2.0, "N0": 30.0}, {"phi_dot": 2.0}, 300.0),
    Stepping("5-DoF", "belt-5dof", {"k_nl": 1e4, "F": 200.0, "mu_s": 3.0, "mu_k": 1.4}, {}, 20.0),
    Stepping("disc", "disc-nonlinear-contact", {"mu_s": 3.0, "mu_k": 2.2}, {}, 2.0),
)


def seconds_per_step(stepping: Stepping, measuring: bool, tangents: int) -> float:
    """Processor time of a step, s."""
    system, parameters = stepping.system(), stepping.parameters()
    taken, steps = 0.0, 0
    while taken < LEAST_SECONDS:
        motion = Motion(system, parameters, SOLVER, stepping.start)
        n = len(motion.y)
        if measuring:
            motion.start_measuring(np.zeros(len(system.coordinates)))
        carried = np.cos(1.0 + np.arange(tangents * n) * 2.0**0.5).reshape(tangents, n)
        motion.carry_tangents(carried)
        for goal in np.linspace(0.0, stepping.t_end, PIECES + 1)[1:]:
            begun = time.process_time()
            motion.run(float(goal), measuring=measuring)
            taken += time.process_time() - begun
            if tangents:
                sizes = np.linalg.norm(motion.tangents, axis=1)
                motion.carry_tangents(motion.tangents / sizes[:, None])
        steps += motion.n_steps
    return taken / steps


def report() -> None:
    """Print, per motion, a plain step and what is asked of it beside."""
    print("a step, one core: plain; measured; measured with one tangent; with as many as states")
    for stepping in STEPPINGS:
        print(_line(stepping), flush=True)


def _line(stepping: Stepping) -> str:
    n = len(stepping.system().state_names)
    ways = ((False, 0), (True, 0), (True, 1), (False, n))
    rounds = [[seconds_per_step(stepping, *way) for way in ways] for _ in range(ROUNDS)]
    plain, *others = np.min(rounds, axis=0)
    ratios = "; ".join(f"{other / plain:.2f}" for other in others)
    return f"  {stepping.name} ({n} states): {plain * 1e6:.3f} us; times {ratios}"
