"""Two sweeps against SciPy's DOP853 with events: same runs, same error, one core.

Error: largest difference of the states at slip->stick and of the final state from a reference at
rtol 1e-14, over the scale of each state. Both sides run a ladder of tolerances; for each error
goal each side's cheapest run that meets it is compared, in interleaved pairs.

SciPy runs twice: as fast as it goes, which may step over a pair of events, and with steps of at
most a thirtieth of the fastest oscillation, which a user needs who wants none missed (fiv bounds
the roots of its switching functions and misses none at any step).

fiv is timed twice as well: its driver alone, called from C (``repeat.c``) with motions that were
set out before, and from Python, which sets each motion out.
"""

from __future__ import annotations

import ctypes
import subprocess
import tempfile
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from fiv_cli.analyses.base import Section, SolverSettings
from fiv_cli.codegen.memory import address_of
from fiv_cli.codegen.setup import Setup, default_parameters
from fiv_cli.dynamics.compiled import DRIVER
from fiv_cli.dynamics.motion import STOPS, Motion, Stop
from fiv_cli.dynamics.system import System, build_system
from fiv_cli.friction import get_law
from fiv_cli.models import get_model
from tests.benchmarks import scipy_belt, scipy_belt_5dof

STICKS = Section("event")  # slip->stick
SECTIONS = 300  # room for section points of a run
PAIRS = 5
FIV_SECONDS = 0.1  # fiv's runs are repeated for about this long
FIV_LADDER = tuple(10.0**-k for k in range(3, 15))

Points = NDArray[np.float64]
ScipyRun = Callable[[float, float, float, float], tuple[Points, Points]]


@dataclass(frozen=True)
class Sweep:
    """Runs from zero along one parameter.

    Attributes
    ----------
    title : one line
    model, fixed : the model and parameters that differ from its defaults
    axis, values : the parameter of the sweep
    t_end : length of a run, s
    guarded_step : bound of SciPy's steps, s
    goals : errors at which both sides are compared
    scipy_ladder : SciPy's tolerances, coarsest first
    scipy_run : (value, t_end, rtol, max_step) -> states at slip->stick, final state
    """

    title: str
    model: str
    fixed: Mapping[str, float]
    axis: str
    values: tuple[float, ...]
    t_end: float
    guarded_step: float
    goals: tuple[float, ...]
    scipy_ladder: tuple[float, ...]
    scipy_run: ScipyRun

    def parameters(self, value: float) -> dict[str, float]:
        """Every parameter of one run."""
        changes = {**self.fixed, self.axis: value}
        return default_parameters(get_model(self.model), get_law("coulomb"), **changes)

    def system(self, rtol: float) -> tuple[System, SolverSettings]:
        """The compiled model at a tolerance."""
        return build_system(Setup.of(self.model, "coulomb", rtol=rtol)), SolverSettings(rtol=rtol)


BELT = Sweep(
    title="base-excited belt (belt-1dof, u0 = 0.5)",
    model="belt-1dof",
    fixed={"u0": 0.5},
    axis="omega",
    values=tuple(np.linspace(0.82, 0.88, 7)),
    t_end=400.0,
    guarded_step=2.0 * np.pi / 30.0,
    goals=(1e-6, 1e-9, 1e-12),
    scipy_ladder=tuple(10.0**-k for k in range(4, 14)),
    scipy_run=scipy_belt.stick_points,
)
SLIDER = Sweep(
    title="slider on an oscillating belt (belt-5dof, plastic impact)",
    model="belt-5dof",
    fixed={"k_nl": 1e4, "F": 200.0, "mu_s": 3.0},
    axis="mu_k",
    values=(0.9, 1.4, 2.0, 2.5),
    t_end=20.0,
    guarded_step=1.5e-3,
    goals=(1e-6, 1e-9),
    scipy_ladder=tuple(10.0**-k for k in range(5, 14)),
    scipy_run=scipy_belt_5dof.stick_points,
)


def fiv_run(
    system: System, solver: SolverSettings, parameters: Mapping[str, float], t_end: float
) -> tuple[Motion, Points]:
    """One run with its section points."""
    motion = Motion(system, parameters, solver, {})
    times, states = np.empty(SECTIONS), np.empty((SECTIONS, len(system.state_names)))
    motion.run(t_end, STICKS, (times, states))
    return motion, states


@cache
def repeat() -> Callable[..., int]:
    """`repeat` of ``repeat.c``."""
    with tempfile.TemporaryDirectory() as folder:
        library = Path(folder, "repeat.so")
        source = str(Path(__file__).with_name("repeat.c"))
        subprocess.run(["gcc", "-O2", "-shared", "-fPIC", "-o", library, source], check=True)
        function = ctypes.CDLL(str(library)).repeat
    address, count = ctypes.c_void_p, ctypes.c_int64
    function.argtypes = address, address, address, count, ctypes.c_double, count
    return function


class Driver:
    """The driver alone, with the motions of a sweep set out before it is called."""

    def __init__(self, system: System, solver: SolverSettings, sweep: Sweep) -> None:
        self.until, self.begun = sweep.t_end, []
        for value in sweep.values:
            motion = Motion(system, sweep.parameters(value), solver, {})
            states = np.empty((SECTIONS, len(system.state_names)))
            motion.show_section(STICKS, np.empty(SECTIONS), states)
            frame = motion._frame  # `frame` would decide the contact state: part of the run
            frame.max_steps = solver.max_steps
            self.begun.append((frame, frame.words.copy()))

    def seconds(self, times: int) -> float:
        """Processor time of a run, over so many of every motion."""
        return seconds(lambda: self._run(times)) / times / len(self.begun)

    def _run(self, times: int) -> None:
        for frame, begun in self.begun:
            places = address_of(frame.words), address_of(begun), len(begun)
            stop = repeat()(DRIVER.address, *places, self.until, times)
            assert STOPS[stop] == Stop.REACHED


def fiv_points(sweep: Sweep, rtol: float) -> list[Points]:
    """States at slip->stick and, last, the final state, for the whole sweep."""
    system, solver = sweep.system(rtol)
    found = []
    for value in sweep.values:
        motion, states = fiv_run(system, solver, sweep.parameters(value), sweep.t_end)
        found.append(np.vstack([states[: motion.n_sections], motion.y]))
    return found


def scipy_points(sweep: Sweep, rtol: float) -> list[Points]:
    """The same by SciPy."""
    runs = [sweep.scipy_run(value, sweep.t_end, rtol, np.inf) for value in sweep.values]
    return [np.vstack([points, final]) for points, final in runs]


def error(points: list[Points], reference: list[Points]) -> float:
    """Largest scaled difference; infinite when an event is missing."""
    if any(a.shape != b.shape for a, b in zip(points, reference, strict=True)):
        return float("inf")
    scale = np.max(np.abs(np.vstack(reference)), axis=0)
    pairs = zip(points, reference, strict=True)
    return max(float(np.max(np.abs(a - b) / scale)) for a, b in pairs)


def cheapest(
    ladder: tuple[float, ...], error_at: Callable[[float], float], goal: float
) -> tuple[float, float] | None:
    """First tolerance of the ladder that meets the goal, with its error."""
    errors = ((rtol, error_at(rtol)) for rtol in ladder)
    return next((pair for pair in errors if pair[1] <= goal), None)


def seconds(action: Callable[[], object], repeats: int = 1) -> float:
    """Processor time of one call, over `repeats`."""
    begun = time.process_time()
    for _ in range(repeats):
        action()
    return (time.process_time() - begun) / repeats


def report() -> None:
    """Print the ratio at each error goal of each sweep."""
    for sweep in (BELT, SLIDER):
        exact, runs = fiv_points(sweep, 1e-14), f"{len(sweep.values)} runs of {sweep.t_end:g} s"
        print(f"{sweep.title}, {runs}, one core", flush=True)
        for goal in sweep.goals:
            print(f"  error <= {goal:g}: {_compare(sweep, exact, goal)}", flush=True)


def _compare(sweep: Sweep, exact: list[Points], goal: float) -> str:
    fiv = cheapest(FIV_LADDER, lambda rtol: error(fiv_points(sweep, rtol), exact), goal)
    scipy = cheapest(sweep.scipy_ladder, lambda rtol: error(scipy_points(sweep, rtol), exact), goal)
    if fiv is None or scipy is None:
        return ("fiv" if fiv is None else "SciPy") + " does not reach it"
    system, solver = sweep.system(fiv[0])
    given = [sweep.parameters(value) for value in sweep.values]

    driver = Driver(system, solver, sweep)

    def fiv_runs() -> None:
        for parameters in given:
            fiv_run(system, solver, parameters, sweep.t_end)

    def scipy_runs(max_step: float) -> None:
        for value in sweep.values:
            sweep.scipy_run(value, sweep.t_end, scipy[0], max_step)

    repeats = max(1, round(FIV_SECONDS / seconds(fiv_runs)))
    times = [
        (
            driver.seconds(repeats),
            seconds(fiv_runs, repeats) / len(given),
            seconds(lambda: scipy_runs(np.inf)) / len(given),
            seconds(lambda: scipy_runs(sweep.guarded_step)) / len(given),
        )
        for _ in range(PAIRS)
    ]
    times = np.array(times)
    alone, whole, scipy_time, guarded = np.median(times, axis=0)
    ratios = [np.median(times[:, 2] / times[:, own]) for own in (0, 1)]
    bounded = np.median(times[:, 3] / times[:, 0])
    return (
        f"driver (rtol {fiv[0]:g}, error {fiv[1]:.1e}) {alone * 1e6:.0f} us, from Python "
        f"{whole * 1e6:.0f}; "
        f"SciPy (rtol {scipy[0]:g}, error {scipy[1]:.1e}) {scipy_time * 1e3:.0f} ms: "
        f"ratios {ratios[0]:.0f} and {ratios[1]:.0f}; "
        f"steps bounded {guarded * 1e3:.0f} ms: ratio {bounded:.0f}"
    )
