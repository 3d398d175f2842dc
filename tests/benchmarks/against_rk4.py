"""The map of Figure 7.6 through the command, against RK4 with bisection in C (`rk4_pin.c`).

The C program simulates 60 s from each of the 1,880 points and decides nothing; `fiv run` tells
what each of them reaches. Its step is the largest of the ladder with which a stick-slip motion has
the error asked for: largest difference of the states at slip->stick over the scale of each state,
from fiv at rtol 1e-13.
"""

from __future__ import annotations

import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np

from fiv_cli.analyses.base import SolverSettings
from fiv_cli.codegen.setup import Setup, default_parameters
from fiv_cli.dynamics.motion import Motion
from fiv_cli.dynamics.system import build_system
from fiv_cli.friction import get_law
from fiv_cli.models import get_model
from tests.benchmarks.against_scipy import STICKS, Points, error
from tests.benchmarks.maps import seconds
from tests.benchmarks.processes import processor_of_children

SOURCE = Path(__file__).with_name("rk4_pin.c")
CASE = "ch7/fig_7_06_reached"
LENGTH = 60.0  # of each motion of the map, s
OMEGA, PRELOAD, COMPARED = 2.0, 30.0, 10.0  # a periodic motion, and how much of it is compared, s
GOALS = (1e-3, 1e-6)
LADDER = tuple(2.0 ** (-k / 4) * 1e-3 for k in range(24))
PAIRS = 5
SECTIONS = 1000  # room for section points


def report() -> None:
    """Print the processor time of a map over that of the C program, at each error."""
    compiler = shutil.which("gcc") or shutil.which("cc")
    if compiler is None:
        print("rk4: no C compiler")
        return
    with tempfile.TemporaryDirectory() as folder:
        program = str(Path(folder, "rk4_pin"))
        subprocess.run([compiler, "-O2", "-o", program, str(SOURCE), "-lm"], check=True)
        print(f"Figure 7.6 against RK4 + bisection in C ({LENGTH:g} s of each motion), one core")
        for goal in GOALS:
            print(f"  error <= {goal:g}: {_compare(program, goal)}", flush=True)


def _compare(program: str, goal: float) -> str:
    exact = [fiv_points()]
    errors = ((step, error([points(program, step)], exact)) for step in LADDER)
    step, reached = next(pair for pair in errors if pair[1] <= goal)
    fiv = str(Path(sys.executable).with_name("fiv"))
    times = np.array([(seconds(fiv, CASE), map_seconds(program, step)) for _ in range(PAIRS)])
    ratio = float(np.median(times[:, 0] / times[:, 1]))
    own, other = np.median(times, axis=0)
    program_took = f"C (step {step:.2g} s, error {reached:.1e}) {other:.1f} s"
    return f"{program_took}; fiv {own:.1f} s: ratio {ratio:.2f}"


def fiv_points() -> Points:
    """States at slip->stick and, last, the final state, by fiv."""
    changes = {"Omega": OMEGA, "N0": PRELOAD}
    given = default_parameters(get_model("pin-on-disc"), get_law("coulomb"), **changes)
    system = build_system(Setup.of("pin-on-disc", "coulomb", rtol=1e-13))
    motion = Motion(system, given, SolverSettings(rtol=1e-13), {"phi_dot": OMEGA})
    states = np.empty((SECTIONS, len(system.state_names)))
    motion.run(COMPARED, STICKS, (np.empty(SECTIONS), states))
    return np.vstack([states[: motion.n_sections], motion.y])


def points(program: str, step: float) -> Points:
    """The same by the C program."""
    asked = [program, str(step), str(COMPARED), "points", str(OMEGA), str(PRELOAD)]
    printed = subprocess.run(asked, check=True, capture_output=True, text=True).stdout
    return np.loadtxt(printed.splitlines(), ndmin=2)


def map_seconds(program: str, step: float) -> float:
    """Processor time of the map by the C program, s."""
    begun = processor_of_children()
    subprocess.run([program, str(step), str(LENGTH), "map"], check=True)
    return processor_of_children() - begun
