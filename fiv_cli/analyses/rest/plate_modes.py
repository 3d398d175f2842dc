"""The modes of a plate as arrays over nodal circles k, nodal diameters l and radius r."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from fiv_cli.analyses.base import Outcome
from fiv_cli.models import disc
from fiv_cli.models.base import Options
from fiv_cli.plate import mode

NODE = 1e-9  # a mode whose shape at r0 is below this share of its largest has a node there


def plate_modes(options: Options, parameters: Mapping[str, float], n_r: int) -> Outcome:
    """Frequencies (rad/s), R(r0)^2/M (1/kg) and R(r)/R(r0) at `n_r` radii from a to b.

    NaN stands for modes that are not asked for, and for shapes of modes with a node at r0: nothing
    that acts there moves them.
    """
    plate, r0 = disc.plate_of(parameters), parameters["r0"]
    pairs = disc.modes(options)
    circles, diameters = (max(numbers) + 1 for numbers in zip(*pairs, strict=True))
    frequency = np.full((circles, diameters), np.nan)
    inverse_mass = frequency.copy()
    shape = np.full((circles, diameters, n_r), np.nan)
    radius = np.linspace(plate.a, plate.b, n_r)
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
