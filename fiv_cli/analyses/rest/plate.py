"""Natural frequencies and mode shapes of the annular plate (thesis 3.3, equations 3.53-3.58).

The modes are those of the model's option ``modes``, as arrays over nodal circles k, nodal
diameters l and radius r; how they are computed is told in ``fiv_cli/plate.py``.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from fiv_cli.analyses.base import Analysis, Outcome, Request, Setup
from fiv_cli.analyses.settings import Integer
from fiv_cli.models import disc
from fiv_cli.plate import mode

if TYPE_CHECKING:
    from fiv_cli.models.base import Model
from fiv_cli.analyses.variables import Subject, Variable, axis

NODE = 1e-9  # a mode whose shape at r0 is below this share of its largest has a node there


def plate_modes(setup: Setup, request: Request) -> Outcome:
    """Frequencies (rad/s), R(r0)^2/M (1/kg) and R(r)/R(r0) at radii from a to b.

    NaN stands for modes that are not asked for, and for shapes of modes with a node at r0: nothing
    that acts there moves them.
    """
    plate, r0 = disc.plate_of(request.parameters), request.parameters["r0"]
    pairs = disc.modes(setup.options)
    circles, diameters = (max(numbers) + 1 for numbers in zip(*pairs, strict=True))
    frequency = np.full((circles, diameters), np.nan)
    inverse_mass = frequency.copy()
    radius = np.linspace(plate.a, plate.b, request.settings["n_r"])
    shape = np.full((circles, diameters, len(radius)), np.nan)
    outcome = Outcome()
    for k, n in pairs:
        found = mode(plate, k, n)
        frequency[k, n], inverse_mass[k, n] = found.frequency, found.inverse_modal_mass(r0)
        curve, at_r0 = found.shape(radius), float(found.shape(r0))
        if abs(at_r0) > NODE * float(np.max(np.abs(curve))):
            shape[k, n] = curve / at_r0
        else:
            inverse_mass[k, n], outcome.reason = 0.0, "node_at_r0"
            outcome.message += f"mode ({k}, {n}) has a node at r0 = {r0!r} m\n"
    outcome.values = {
        "k": np.arange(circles, dtype=float),
        "l": np.arange(diameters, dtype=float),
        "radius": radius,
        "plate_frequency": frequency,
        "inverse_modal_mass": inverse_mass,
        "shape": shape,
    }
    return outcome


def unsuited(model: Model) -> str:
    """Why a model has no plate; empty where it has one."""
    if any(option.name == "modes" for option in model.options):
        return ""
    return f"{model.name} has no elastic disc, so there is no plate to compute modes of"


def variables(subject: Subject) -> list[Variable]:
    """What is told of each mode."""
    comment = "R(r0)^2/M: how a unit force at r0 accelerates the mode there; 0: a node"
    return [
        axis("k", "1", "nodal circles"),
        axis("l", "1", "nodal diameters"),
        Variable("radius", "m", "radius", "r", symbol="r"),
        Variable("plate_frequency", "rad s-1", "natural frequency of the disc", "k l"),
        Variable("inverse_modal_mass", "kg-1", "inverse modal mass at r0", "k l", comment=comment),
        Variable("shape", "1", "mode shape R(r)/R(r0)", "k l r"),
    ]


ANALYSIS = Analysis(
    "plate",
    "natural frequencies and mode shapes of the elastic disc",
    (
        Integer(
            "n_r",
            "radii at which shapes are given, from a to b, both included",
            default=101,
            least=2,
        ),
    ),
    variables,
    plate_modes,
    uses_starts=False,
    linear=True,
    unsuited=unsuited,
    generated=False,
    single=True,
    figure="mode-shape",
    answer="frequencies, modal masses and shapes of the disc alone",
)
