"""Natural frequencies and mode shapes of the annular plate (thesis 3.3, equations 3.53-3.58).

The modes are those of the model's option ``modes``; how they are computed is told in
``fiv_cli/plate.py``.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from fiv_cli.analyses.base import Analysis, Outcome, Setting, Setup, SolverSettings, Start

if TYPE_CHECKING:
    from fiv_cli.models.base import Model

SETTINGS = (
    Setting(
        "n_r", "integer", 101, "radii at which shapes are given, from a to b, both included",
        minimum=2,
    ),
)  # fmt: skip


def run(
    setup: Setup,
    parameters: Mapping[str, float],
    start: Start | None,
    settings: Mapping[str, Any],
    solver: SolverSettings,
) -> Outcome:
    """Frequencies, modal masses and shapes of the plate's modes."""
    from fiv_cli.analyses.rest.plate_modes import plate_modes

    return plate_modes(setup.options, parameters, int(settings["n_r"]))


def unsuited(model: Model) -> str:
    """Why a model has no plate; empty where it has one."""
    if any(option.name == "modes" for option in model.options):
        return ""
    return f"{model.name} has no elastic disc, so there is no plate to compute modes of"


ANALYSIS = Analysis(
    "plate",
    "natural frequencies and mode shapes of the elastic disc",
    SETTINGS,
    False,
    run,
    linear=True,
    unsuited=unsuited,
    generated=False,
)
