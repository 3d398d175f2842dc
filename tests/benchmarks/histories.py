"""What one more point of a `history` sweep costs `fiv run`, against SciPy solving the same motion.

Processor time of a sweep of `MANY` points less that of `FEW`, per point: ledger, energy balance,
samples, shards and dataset are in it, and what a command costs at all is not. SciPy's runs are
those of ``against_scipy.py`` at the same error, which keep the points of a section and no more.
"""

from __future__ import annotations

from statistics import median

import numpy as np

from tests.benchmarks.against_scipy import (
    BELT,
    FIV_LADDER,
    SLIDER,
    Points,
    Sweep,
    cheapest,
    error,
    fiv_points,
    scipy_points,
    seconds,
)
from tests.benchmarks.processes import Place, place

FEW, MANY = 100, 1000
PAIRS = 5
RUNS = 5  # of each sweep, in turn: what a point adds is little beside what a command takes
GOALS = (1e-6, 1e-9)
SAMPLES = (100, 2000)  # of a motion; the latter when a case says nothing

CASE = """
schema = 1
[model]
name = "{model}"
parameters = {parameters}
[friction]
{friction}
[solver]
rtol = {rtol}
[grid]
{axis} = {{ start = {first}, stop = {last}, num = {points} }}
[[initial]]
label = "zero"
kind = "state"
state = {{}}
[[analysis]]
kind = "history"
t_end = {t_end}
sample = {sample}
"""


def report() -> None:
    """Print SciPy's time over that of a point, for each error and number of samples."""
    for sweep in (BELT, SLIDER):
        exact = fiv_points(sweep, 1e-14)
        print(f"{sweep.title}: one more point of a history sweep, one worker", flush=True)
        for goal in GOALS:
            tolerances = _tolerances(sweep, exact, goal)
            for samples in SAMPLES:
                found = _compare(sweep, tolerances, samples)
                print(f"  error <= {goal:g}, {samples} samples: {found}", flush=True)


def _tolerances(sweep: Sweep, exact: list[Points], goal: float) -> tuple[float, float]:
    """The cheapest of fiv and of SciPy that meet the goal."""
    own = cheapest(FIV_LADDER, lambda rtol: error(fiv_points(sweep, rtol), exact), goal)
    other = cheapest(sweep.scipy_ladder, lambda rtol: error(scipy_points(sweep, rtol), exact), goal)
    assert own is not None and other is not None, f"{goal:g} is not reached"
    return own[0], other[0]


def _compare(sweep: Sweep, tolerances: tuple[float, float], samples: int) -> str:
    rtol, scipy_rtol = tolerances
    with place() as folder:
        pairs = [
            (point_seconds(folder, sweep, rtol, samples), scipy_seconds(sweep, scipy_rtol))
            for _ in range(PAIRS)
        ]
    times = np.array(pairs)
    own, other = np.median(times, axis=0)
    ratio = np.median(times[:, 1] / times[:, 0])
    return f"fiv {own * 1e6:.0f} us; SciPy {other * 1e3:.0f} ms: ratio {ratio:.0f}"


def point_seconds(folder: Place, sweep: Sweep, rtol: float, samples: int) -> float:
    """Processor time of one more point, s."""
    cases = [case_of(sweep, rtol, samples, points) for points in (FEW, MANY)]
    runs = [[folder.run(case, "--workers", "1").processor for case in cases] for _ in range(RUNS)]
    few, many = map(median, zip(*runs, strict=True))
    return (many - few) / (MANY - FEW)


def case_of(sweep: Sweep, rtol: float, samples: int, points: int) -> str:
    """The case of a sweep of so many points."""
    own = {name: value for name, value in sweep.fixed.items() if name != "mu_s"}
    return CASE.format(
        model=sweep.model,
        parameters="{ " + ", ".join(f"{name} = {value}" for name, value in own.items()) + " }",
        friction="".join(f"{name} = {sweep.fixed[name]}" for name in sweep.fixed if name == "mu_s"),
        rtol=rtol,
        axis=sweep.axis,
        first=sweep.values[0],
        last=sweep.values[-1],
        points=points,
        t_end=sweep.t_end,
        sample=sweep.t_end / samples,
    )


def scipy_seconds(sweep: Sweep, rtol: float) -> float:
    """Processor time of a run by SciPy, s."""

    def runs() -> None:
        for value in sweep.values:
            sweep.scipy_run(value, sweep.t_end, rtol, np.inf)

    return seconds(runs) / len(sweep.values)
