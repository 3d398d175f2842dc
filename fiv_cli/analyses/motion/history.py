"""The motion in time, with its event ledger and energy balance (recorded by ``recording.py``)."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from fiv_cli.analyses.base import Analysis, Outcome, Setting, SolverSettings, Start

if TYPE_CHECKING:
    from fiv_cli.dynamics.system import System

DEFAULT_SAMPLES = 2000

SETTINGS = (
    Setting(
        "t_end",
        "number",
        None,
        "end of the motion",
        "s",
        minimum=0.0,
        exclusive=True,
        required=True,
    ),
    Setting(
        "sample",
        "number",
        None,
        "interval of the samples; t_end / 2000 when left out",
        "s",
        minimum=0.0,
        exclusive=True,
    ),
    Setting(
        "points",
        "points",
        None,
        "[radius (m), angle (rad)] on the disc, fixed in space, whose displacement w is given",
    ),
)


def sample_times(settings: Mapping[str, Any]) -> NDArray[np.float64]:
    """Times of the samples, s: from 0, t_end always included."""
    t_end = float(settings["t_end"])
    interval = settings["sample"]
    if interval is None:
        return np.linspace(0.0, t_end, DEFAULT_SAMPLES + 1)
    count = int(np.floor(t_end / interval + 1e-9)) + 1
    times: NDArray[np.float64] = interval * np.arange(count, dtype=np.float64)
    reached = abs(times[-1] - t_end) <= 1e-9 * t_end
    return times if reached else np.append(times, t_end)


def run(
    system: System,
    parameters: Mapping[str, float],
    start: Start | None,
    settings: Mapping[str, Any],
    solver: SolverSettings,
) -> Outcome:
    """States, contact forces and energies at the sample times, and every event."""
    from fiv_cli.analyses.motion.recording import record

    assert start is not None
    places = settings.get("points") or ()
    return record(system, parameters, start, sample_times(settings), solver, places)


ANALYSIS = Analysis(
    "history",
    "the motion in time",
    SETTINGS,
    True,
    run,
    varying=True,
    recorded=lambda schedule: True,
    sizes=lambda settings: {"time": sample_times(settings)},
)
