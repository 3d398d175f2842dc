"""The two sweeps of `against_scipy` against scalar Taylor series in C: same runs, same error.

The programs (`taylor_belt.c`, `taylor_slider.c`) do one system each, with its numbers written into
them; they keep no tables, decide no contact state but those two or three, and are given the order
and the tolerance that cost them least. gcc may reorder their sums. Both are timed without what
sets a motion out; the programs keep no section points, the driver does.
"""

from __future__ import annotations

import shutil
import subprocess
import tempfile
from pathlib import Path
from typing import NamedTuple

import numpy as np

from tests.benchmarks.against_scipy import (
    BELT,
    FIV_LADDER,
    FIV_SECONDS,
    SLIDER,
    Driver,
    Points,
    Sweep,
    cheapest,
    error,
    fiv_points,
)

FOLDER = Path(__file__).parent
FLAGS = ("-O3", "-march=native", "-ffast-math")
ORDERS = (10, 12, 14, 16, 18)
GOALS = (1e-6, 1e-9)
PAIRS = 9
OPPONENTS = ((BELT, "taylor_belt"), (SLIDER, "taylor_slider"))


class Opponent(NamedTuple):
    """A program at an order and a tolerance, and the error that it has."""

    order: int
    program: Path
    rtol: float
    error: float

    def seconds(self, sweep: Sweep, repeats: int) -> float:
        """Processor time of a run, s."""
        values = map(repr, map(float, sweep.values))
        return float(_told(self.program, self.rtol, sweep, str(repeats), *values).split()[0])


def report() -> None:
    """Print the processor time of fiv over that of the C program, at each error."""
    compiler = shutil.which("gcc")
    if compiler is None:
        print("taylor: no gcc")
        return
    for sweep, name in OPPONENTS:
        exact = fiv_points(sweep, 1e-14)
        print(f"{sweep.title}, against scalar Taylor series in C, one core", flush=True)
        with tempfile.TemporaryDirectory() as folder:
            programs = {order: _compiled(compiler, name, order, folder) for order in ORDERS}
            for goal in GOALS:
                print(f"  error <= {goal:g}: {_compare(sweep, programs, exact, goal)}", flush=True)


def _compiled(compiler: str, name: str, order: int, folder: str) -> Path:
    program = Path(folder, f"{name}_{order}")
    source = str(FOLDER / f"{name}.c")
    command = [compiler, *FLAGS, f"-DORDER={order}", "-o", str(program), source, "-lm"]
    subprocess.run(command, check=True)
    return program


def _told(program: Path, rtol: float, sweep: Sweep, *asked: str) -> str:
    command = [str(program), repr(rtol), repr(sweep.t_end), *asked]
    return subprocess.run(command, check=True, capture_output=True, text=True).stdout


def _points(program: Path, rtol: float, sweep: Sweep) -> list[Points]:
    told = [_told(program, rtol, sweep, "points", repr(float(value))) for value in sweep.values]
    return [np.loadtxt(printed.splitlines(), ndmin=2) for printed in told]


def _best(sweep: Sweep, programs: dict[int, Path], exact: list[Points], goal: float) -> Opponent:
    """The order and the tolerance that meet the goal in the least time."""
    found = []
    for order, program in programs.items():
        tried = cheapest(
            FIV_LADDER, lambda rtol, at=program: error(_points(at, rtol, sweep), exact), goal
        )
        if tried is not None:
            found.append(Opponent(order, program, *tried))
    return min(found, key=lambda one: min(one.seconds(sweep, 10) for _ in range(3)))


def _compare(sweep: Sweep, programs: dict[int, Path], exact: list[Points], goal: float) -> str:
    fiv = cheapest(FIV_LADDER, lambda rtol: error(fiv_points(sweep, rtol), exact), goal)
    if fiv is None:
        return "fiv does not reach it"
    driver = Driver(*sweep.system(fiv[0]), sweep)
    best = _best(sweep, programs, exact, goal)
    repeats = max(1, round(FIV_SECONDS / driver.seconds(1) / len(sweep.values)))
    times = [(driver.seconds(repeats), best.seconds(sweep, repeats)) for _ in range(PAIRS)]
    times = np.array(times)
    own, other = np.median(times, axis=0) * 1e6
    return (
        f"C (order {best.order}, rtol {best.rtol:g}, error {best.error:.1e}) {other:.0f} us; "
        f"driver (rtol {fiv[0]:g}, error {fiv[1]:.1e}) {own:.0f} us: "
        f"ratio {np.median(times[:, 0] / times[:, 1]):.2f}"
    )
