"""What changes the cost of a run and never its result."""

from __future__ import annotations

from dataclasses import dataclass

from fiv_cli.sweep.parts import Part
from fiv_cli.sweep.worker import EXECUTOR

PREPARER = "fiv_cli.analyses.execute:prepare"


@dataclass(frozen=True)
class Policy:
    """How a sweep is run.

    Attributes
    ----------
    workers : worker processes; 1: in this process
    fresh : throw stored results away
    fail_fast : stop at the first failed point
    max_points : run at most so many points now
    time_limit : wall-clock limit of one point, s
    chunk_points : points per task; None: measured
    chunk_seconds : aim for the duration of a task, s
    in_process_below : estimated work, s, below which no worker processes are started
    cluster : address or file of a scheduler that has the workers; empty: those of this machine
    foresee : try some points first, and say where the run may take more than an hour
    part : run this part of the plan only; None: all of it
    executor, preparer : ``module:function`` that runs a point, and that prepares the systems
    """

    workers: int = 2
    fresh: bool = False
    fail_fast: bool = False
    max_points: int | None = None
    time_limit: float | None = None
    chunk_points: int | None = None
    chunk_seconds: float = 0.5
    in_process_below: float = 4.0
    cluster: str = ""
    foresee: bool = False
    part: Part | None = None
    executor: str = EXECUTOR
    preparer: str = PREPARER
