"""The motion in time, with its event ledger and energy balance (recorded by ``recording.py``)."""

from __future__ import annotations

from fiv_cli.analyses.base import Analysis, Later
from fiv_cli.analyses.settings import DiscPoints, Number

ANALYSIS = Analysis(
    "history",
    "the motion in time",
    (
        Number("t_end", "end of the motion", unit="s", above=0.0, required=True),
        Number(
            "sample", "interval of the samples; t_end / 2000 when left out", unit="s", above=0.0
        ),
        DiscPoints(
            "points",
            "[radius (m), angle (rad)] on the disc, fixed in space, whose displacement w is given",
        ),
    ),
    Later("fiv_cli.analyses.motion.recording:record"),
    varying=True,
    recorded=True,
    single=True,
    figure="history",
)
