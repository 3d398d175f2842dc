"""Transverse displacement of an elastic disc at given places, from its modal coordinates."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from fiv_cli.dynamics.system import System, Vector

Place = tuple[float, float]  # (radius in m, angle in rad, fixed in space)


def weights(
    system: System, parameters: Mapping[str, float], places: Sequence[Place]
) -> NDArray[np.float64]:
    """What each coordinate adds to w at each place; shape (places, coordinates).

    NaN at places that are not on the disc.
    """
    surface = system.setup.model.surface
    assert surface is not None
    found = np.zeros((len(places), len(system.coordinates)))
    for row, (radius, angle) in enumerate(places):
        for name, weight in surface(parameters, system.setup.options, radius, angle).items():
            found[row, system.coordinates.index(name)] = weight
    return found


def at_the_contact(system: System, parameters: Mapping[str, float], state: Vector) -> float:
    """w where the slider touches the disc (r0, phi), m, in a state of the system."""
    angle = float(state[system.coordinates.index("phi")])
    (row,) = weights(system, parameters, [(parameters["r0"], angle)])
    return float(row @ state[: len(row)])
