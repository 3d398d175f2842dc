"""What whole processes cost: a first run, a second run, two workers, a million points.

Every figure is that of real `fiv run` processes. Wall times depend on what else the machine does;
processor times, printed beside them, hardly do.
"""

from __future__ import annotations

import os
import resource
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from statistics import median

FIRST_RUNS = 3
PAIRS = 5
WORKER_PAIRS = 3

ONE_POINT = """
schema = 1
[model]
name = "{model}"
[[initial]]
label = "far"
kind = "state"
state = {{ {state} = 1.0 }}
[[analysis]]
kind = "response"
t_max = 20.0
"""

SMALL = """
schema = 1
[model]
name = "belt-1dof"
[grid]
v = { start = 0.5, stop = 2.0, num = 10 }
[[initial]]
label = "far"
kind = "state"
state = { x = 10.0 }
[[analysis]]
kind = "response"
"""

# About a minute on one worker.
MINUTE = """
schema = 1
[model]
name = "pin-on-disc"
[grid]
Omega = { start = 0.5, stop = 12.0, num = 389 }
N0 = { start = 1.0, stop = 40.0, num = 100 }
[[initial]]
label = "disc-speed"
kind = "state"
state = { phi_dot = "Omega" }
[[analysis]]
kind = "response"
t_max = 200.0
"""

# Each run slides back to its equilibrium without an event.
MILLION = """
schema = 1
[model]
name = "belt-1dof"
[grid]
c = { start = 0.1, stop = 0.5, num = 1000 }
v = { start = 1.0, stop = 2.0, num = 1000 }
[[initial]]
label = "near"
kind = "equilibrium"
offset = { x = 1e-3 }
[[analysis]]
kind = "response"
"""

# Runs a case and says, as its last line, which modules that took and the peak of its memory.
RUN = """
import sys
from pathlib import Path
from fiv_cli.cli.main import run
if __name__ == "__main__":
    code = run(sys.argv[1:])
    lines = Path("/proc/self/status").read_text().splitlines()
    peak = next(line.split()[1] for line in lines if line.startswith("VmHWM"))
    print(peak, *sys.modules)
    sys.exit(code)
"""

IMPORT = """
import importlib, sys
from contextlib import suppress
for name in sys.stdin.read().split():
    with suppress(ImportError):
        importlib.import_module(name)
"""


@dataclass(frozen=True)
class Cost:
    """What a process took: wall clock and processor time in s, peak memory in kB, its modules."""

    wall: float
    processor: float
    peak: int = 0
    modules: str = ""


class Place:
    """A folder with a case in it and a cache of its own."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder

    def run(self, case: str, *options: str) -> Cost:
        """One `fiv run` of a case, from nothing stored."""
        (self.folder / "case.toml").write_text(case)
        cost, out = self._process([RUN, "run", "case.toml", "-q", "--fresh", *options])
        peak, _, modules = out.splitlines()[-1].partition(" ")
        return Cost(cost.wall, cost.processor, int(peak), modules)

    def imports(self, modules: str) -> Cost:
        """A process that imports these modules and does nothing else."""
        return self._process([IMPORT], modules)[0]

    def _process(self, program: list[str], text: str = "") -> tuple[Cost, str]:
        before, begun = processor_of_children(), time.perf_counter()
        done = subprocess.run(
            [sys.executable, "-W", "ignore", "-c", *program],
            cwd=self.folder,
            env={**os.environ, "FIV_CACHE_DIR": str(self.folder / "cache")},
            input=text,
            check=True,
            stdout=subprocess.PIPE,
            text=True,
        )
        return Cost(time.perf_counter() - begun, processor_of_children() - before), done.stdout


def processor_of_children() -> float:
    """Processor time of all ended children, s."""
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


@contextmanager
def place() -> Iterator[Place]:
    """A folder for the runs of a benchmark."""
    with tempfile.TemporaryDirectory() as folder:
        yield Place(Path(folder))


def report_cold() -> None:
    """Print what a user's first run takes (integrator and model), and the first of a new model."""
    belt = ONE_POINT.format(model="belt-1dof", state="x")
    pin = ONE_POINT.format(model="pin-on-disc", state="phi_dot")
    runs = []
    for _ in range(FIRST_RUNS):
        with place() as folder:
            runs.append((folder.run(belt), folder.run(pin), folder.run(pin)))
    first, new_model, again = (list(costs) for costs in zip(*runs, strict=True))
    print("a run of one point, in a new process")
    for what, costs in (
        ("with nothing in the cache: integrator and belt-1dof compiled", first),
        ("with the integrator in the cache: pin-on-disc generated and compiled", new_model),
        ("with everything in the cache", again),
    ):
        print(f"  {what}: {_walls(costs):.1f} s ({_processors(costs):.1f} s of processor)")


def report_warm() -> None:
    """Print what a second run of a small case takes beyond the imports of other packages."""
    with place() as folder:
        folder.run(SMALL)
        pairs = [_with_imports(folder) for _ in range(PAIRS)]
    runs, imports = (list(costs) for costs in zip(*pairs, strict=True))
    beyond = median(run.wall - other.wall for run, other in pairs)
    processor = median(run.processor - other.processor for run, other in pairs)
    print(
        f"second run of a small case: {_walls(runs):.2f} s, importing other packages "
        f"{_walls(imports):.2f} s; all else, the ten runs included, {beyond:.2f} s "
        f"({processor:.2f} s of processor)"
    )


def _with_imports(folder: Place) -> tuple[Cost, Cost]:
    run = folder.run(SMALL)
    others = [name for name in run.modules.split() if not name.startswith("fiv_cli")]
    return run, folder.imports(" ".join(others))


def report_workers() -> None:
    """Print how much faster two workers are than one."""
    with place() as folder:
        folder.run(ONE_POINT.format(model="pin-on-disc", state="phi_dot"))
        pairs = [
            (folder.run(MINUTE, "--workers", "1"), folder.run(MINUTE, "--workers", "2"))
            for _ in range(WORKER_PAIRS)
        ]
    ones, twos = (list(costs) for costs in zip(*pairs, strict=True))
    ratios = [one.wall / two.wall for one, two in pairs]
    print(
        f"a sweep of {_walls(ones):.0f} s on one worker: two workers are {median(ratios):.2f} "
        f"times as fast (pairs: {' '.join(f'{ratio:.2f}' for ratio in ratios)}; "
        f"processor time {_processors(ones):.0f} s and {_processors(twos):.0f} s)"
    )


def report_memory() -> None:
    """Print what a sweep of a million points takes, and the peak memory of the parent."""
    with place() as folder:
        folder.run(SMALL)  # what is compiled is kept: to compile it takes memory too
        cost = folder.run(MILLION, "--workers", "2")
    print(
        f"a million points: {cost.wall:.0f} s ({cost.processor:.0f} us of processor each), "
        f"peak of the parent {cost.peak / 1024:.0f} MiB"
    )


def _walls(costs: list[Cost]) -> float:
    return median(cost.wall for cost in costs)


def _processors(costs: list[Cost]) -> float:
    return median(cost.processor for cost in costs)
