"""All benchmarks but the long ones, or those named: ``python -m tests.benchmarks cold memory``."""

from __future__ import annotations

import sys
from collections.abc import Callable

from tests.benchmarks import (
    against_rk4,
    against_scipy,
    against_taylor,
    discs,
    histories,
    maps,
    processes,
    steps,
)

BENCHMARKS: dict[str, Callable[[], None]] = {
    "scipy": against_scipy.report,
    "taylor": against_taylor.report,
    "rk4": against_rk4.report,
    "histories": histories.report,
    "discs": discs.report,
    "steps": steps.report,
    "maps": maps.report,
    "cold": processes.report_cold,
    "warm": processes.report_warm,
    "workers": processes.report_workers,
    "memory": processes.report_memory,
}

LONG = ("memory",)  # only when asked for: a quarter of an hour


def main(names: list[str]) -> None:
    """Run the benchmarks called `names`, or all that are not long."""
    for name in names or [name for name in BENCHMARKS if name not in LONG]:
        BENCHMARKS[name]()


main(sys.argv[1:])
