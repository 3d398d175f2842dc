"""Chapter 4's decelerating disc: its whole run, and one second of it against SciPy's DOP853.

Times are of the processor. Error: largest difference of the event times and of the final state,
over the scale of each, from a reference at rtol 1e-14.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fiv_cli.analyses.base import SolverSettings
from fiv_cli.codegen.setup import Setup, default_parameters
from fiv_cli.dynamics.motion import Motion
from fiv_cli.dynamics.system import System, build_system
from fiv_cli.friction import get_law
from fiv_cli.models import get_model
from fiv_cli.schedule import make_schedule
from tests.benchmarks import scipy_disc
from tests.benchmarks.against_scipy import cheapest

MODEL, LAW = "disc-rigid-contact", "exponential"
CASES = (("Figure 4.10", 0.1, 0.1), ("Figure 4.15", 2.0, 0.5))  # c_z, r0^2 c_phi
SPEED, OVER, STRETCH = 2.0 * np.pi, 35.0, 1.0
GOALS = (1e-6, 1e-9)
FIV_LADDER = tuple(10.0**-k for k in range(4, 14))
SCIPY_LADDER = tuple(10.0**-k for k in range(6, 14))
REPEATS = 5
EVENTS = 100_000  # room in the ledger

Vector = NDArray[np.float64]
Run = Callable[[float], tuple[Vector, Vector]]


def processor(action: Callable[[], object], repeats: int = 1) -> float:
    """Processor time of one call, s: the least of some."""
    found = []
    for _ in range(repeats):
        begun = time.process_time()
        action()
        found.append(time.process_time() - begun)
    return min(found)


def parameters(c_z: float, c_phi: float) -> dict[str, float]:
    """Every parameter of a case."""
    return default_parameters(get_model(MODEL), get_law(LAW), c_z=c_z, C_phi=c_phi)


def system(rtol: float, given: dict[str, float]) -> tuple[System, SolverSettings]:
    """The decelerating disc at a tolerance."""
    schedule = make_schedule({"Omega": [(0.0, SPEED), (OVER, 0.0)]})
    setup = Setup.of(MODEL, LAW, parameters=given, rtol=rtol, schedule=schedule)
    return build_system(setup), SolverSettings(rtol=rtol)


def fiv_run(rtol: float, given: dict[str, float], t_end: float) -> tuple[Vector, Vector]:
    """Event times and (phi, q, phi', q') at the end."""
    built, solver = system(rtol, given)
    motion = Motion(built, given, solver, {})
    motion.keep_ledger(EVENTS)
    motion.run(t_end)
    kept = [i for i, name in enumerate(built.state_names) if not name.startswith("z")]
    return motion.ledger.times.copy(), motion.y[kept]


def opponent(given: dict[str, float]) -> scipy_disc.Slider:
    """The same disc for SciPy; the plate's numbers are given to it to the last digit."""
    derived: Any = get_model(MODEL).derived
    numbers = derived.values(given, get_model(MODEL).default_options())
    count = (1, 2, 2, 2)
    omega = np.repeat([numbers[f"omega_0_{n}"] for n in range(4)], count)
    mobility = np.repeat([numbers[f"mobility_0_{n}"] for n in range(4)], count)
    return scipy_disc.Slider(mobility, omega, SPEED, 0.0, OVER, given["c_z"], given["C_phi"])


def error(found: tuple[Vector, Vector], reference: tuple[Vector, Vector]) -> float:
    """Largest scaled difference; infinite when an event is missing."""
    if found[0].shape != reference[0].shape:
        return float("inf")
    halves = np.split(np.abs(found[1] - reference[1]), 2)
    scales = [float(np.max(np.abs(half))) for half in np.split(reference[1], 2)]
    parts = [float(np.max(half)) / scale for half, scale in zip(halves, scales, strict=True)]
    apart = np.abs(found[0] - reference[0])
    return max(*parts, float(np.max(apart, initial=0.0)) / STRETCH)


def report() -> None:
    """Print the time of the whole run, and the ratio at each error goal."""
    for title, c_z, c_phi in CASES:
        given = parameters(c_z, c_phi)
        fiv_run(1e-9, given, 0.01)
        events = len(fiv_run(1e-9, given, OVER)[0])
        whole = processor(lambda given=given: fiv_run(1e-9, given, OVER), 3)
        print(f"{title}: {OVER:g} s, {events} events, in {whole:.2f} s of processor", flush=True)
        slider = opponent(given)

        def fiv(rtol: float, given: dict[str, float] = given) -> tuple[Vector, Vector]:
            return fiv_run(rtol, given, STRETCH)

        def scipy(rtol: float, slider: scipy_disc.Slider = slider) -> tuple[Vector, Vector]:
            return scipy_disc.run(slider, STRETCH, rtol, np.inf)

        exact = fiv(1e-14)
        for goal in GOALS:
            print(f"  first {STRETCH:g} s, error <= {goal:g}: {_compare(fiv, scipy, exact, goal)}")


def _compare(fiv: Run, scipy: Run, exact: Any, goal: float) -> str:
    ours = cheapest(FIV_LADDER, lambda rtol: error(fiv(rtol), exact), goal)
    theirs = cheapest(SCIPY_LADDER, lambda rtol: error(scipy(rtol), exact), goal)
    if ours is None or theirs is None:
        return ("fiv" if ours is None else "SciPy") + " does not reach it"
    (ours, _), (theirs, _) = ours, theirs
    quick, slow = processor(lambda: fiv(ours), REPEATS), processor(lambda: scipy(theirs))
    return (
        f"fiv (rtol {ours:g}) {quick * 1e3:.1f} ms, SciPy (rtol {theirs:g}) {slow:.2f} s: "
        f"ratio {slow / quick:.0f}"
    )
