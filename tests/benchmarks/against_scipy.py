"""The base-excited belt against SciPy's DOP853 with events: same runs, same error, one core.

Error: largest difference of the states at slip->stick and of the final state from a reference at
rtol 1e-14, over the scale of the displacement (4 m). Both sides run a ladder of tolerances; for
each error goal each side's cheapest run that meets it is compared, in interleaved pairs.

SciPy runs twice: as fast as it goes, which may step over a pair of events, and with steps of at
most a thirtieth of an oscillation, which a user needs who wants none missed (fiv bounds the roots
of its switching functions and misses none at any step).
"""

from __future__ import annotations

import time
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from fiv_cli.analyses.base import Section, SolverSettings
from fiv_cli.dynamics.motion import Motion
from fiv_cli.dynamics.system import System, build_system
from tests.benchmarks.scipy_belt import stick_points

OMEGAS = np.linspace(0.82, 0.88, 7)
T_END = 400.0
SECTIONS = 200  # room for section points of a run
SCALE = 4.0
GOALS = (1e-6, 1e-9, 1e-12)
PAIRS = 5
GUARDED_STEP = 2.0 * np.pi / 30.0
FIV_LADDER = (1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-9, 1e-10, 1e-11, 1e-12, 1e-13, 1e-14)
SCIPY_LADDER = (1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-9, 1e-10, 1e-11, 1e-12, 1e-13)

Points = NDArray[np.float64]


def parameters(omega: float) -> dict[str, float]:
    """The belt of section 3.1.2.2 with u0 = 0.5."""
    return {
        "m": 1.0, "k": 1.0, "c": 0.0, "N": 10.0, "v": 1.0, "u0": 0.5, "omega": omega,
        "mu_s": 0.4, "mu_k": 0.23,
    }  # fmt: skip


def system_for(rtol: float) -> tuple[System, SolverSettings]:
    """The compiled belt at a tolerance."""
    solver = SolverSettings(rtol=rtol)
    return build_system("belt-1dof", "coulomb", {}, parameters(1.0), solver), solver


def fiv_run(
    system: System, solver: SolverSettings, belt: dict[str, float]
) -> tuple[Motion, Points]:
    """One run with its section points."""
    motion = Motion(system, belt, solver, {})
    times, states = np.zeros(SECTIONS), np.zeros((SECTIONS, 2))
    motion.run(T_END, Section("event"), (times, states))
    return motion, states


def fiv_points(system: System, solver: SolverSettings, omega: float) -> Points:
    """States at slip->stick and, last, the final state."""
    motion, states = fiv_run(system, solver, parameters(omega))
    return np.vstack([states[: motion.n_sections], motion.y])


def scipy_points(rtol: float, omega: float) -> Points:
    """The same by SciPy."""
    points, final = stick_points(omega, T_END, rtol)
    return np.vstack([points, final])


def error(points: list[Points], reference: list[Points]) -> float:
    """Largest scaled difference; infinite when an event is missing."""
    if any(a.shape != b.shape for a, b in zip(points, reference, strict=True)):
        return float("inf")
    return max(float(np.max(np.abs(a - b))) / SCALE for a, b in zip(points, reference, strict=True))


def cheapest(
    ladder: tuple[float, ...],
    sweep: Callable[[float], list[Points]],
    reference: list[Points],
    goal: float,
) -> tuple[float, float] | None:
    """First tolerance of the ladder that meets the goal, with its error."""
    for rtol in ladder:
        found = error(sweep(rtol), reference)
        if found <= goal:
            return rtol, found
    return None


def fiv_sweep(rtol: float) -> list[Points]:
    """The whole sweep by fiv."""
    system, solver = system_for(rtol)
    return [fiv_points(system, solver, omega) for omega in OMEGAS]


def scipy_sweep(rtol: float) -> list[Points]:
    """The whole sweep by SciPy."""
    return [scipy_points(rtol, omega) for omega in OMEGAS]


def seconds(action: Callable[[], object], repeats: int) -> float:
    """Wall time of one call, over `repeats`."""
    begun = time.perf_counter()
    for _ in range(repeats):
        action()
    return (time.perf_counter() - begun) / repeats


def report() -> None:
    """Print the ratio at each error goal."""
    reference = fiv_sweep(1e-14)
    print(f"base-excited belt, {len(OMEGAS)} runs of {T_END:g} time units, one core")
    for goal in GOALS:
        fiv = cheapest(FIV_LADDER, fiv_sweep, reference, goal)
        scipy = cheapest(SCIPY_LADDER, scipy_sweep, reference, goal)
        if fiv is None or scipy is None:
            who = "fiv" if fiv is None else "SciPy"
            print(f"  error {goal:g}: {who} does not reach it")
            continue
        print(_compare(goal, fiv, scipy))


def _compare(goal: float, fiv: tuple[float, float], scipy: tuple[float, float]) -> str:
    system, solver = system_for(fiv[0])
    belts = [parameters(omega) for omega in OMEGAS]

    def fiv_runs() -> None:
        for belt in belts:
            fiv_run(system, solver, belt)

    def scipy_runs(max_step: float) -> Callable[[], None]:
        def run() -> None:
            for omega in OMEGAS:
                stick_points(omega, T_END, scipy[0], max_step)

        return run

    times = np.array(
        [
            [
                seconds(fiv_runs, 50) / len(OMEGAS),
                seconds(scipy_runs(np.inf), 1) / len(OMEGAS),
                seconds(scipy_runs(GUARDED_STEP), 1) / len(OMEGAS),
            ]
            for _ in range(PAIRS)
        ]
    )
    ratio, guarded = np.median(times[:, 1:] / times[:, :1], axis=0)
    fiv_time, scipy_time, guarded_time = np.median(times, axis=0)
    return (
        f"  error <= {goal:g}: fiv (rtol {fiv[0]:g}, error {fiv[1]:.1e}) {fiv_time * 1e6:.0f} us; "
        f"SciPy (rtol {scipy[0]:g}, error {scipy[1]:.1e}) {scipy_time * 1e3:.0f} ms: "
        f"ratio {ratio:.0f}; steps bounded {guarded_time * 1e3:.0f} ms: ratio {guarded:.0f}"
    )
