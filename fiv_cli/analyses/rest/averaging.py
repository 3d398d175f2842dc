"""Fast and slow motion apart: the system averaged over its high-frequency excitation.

Thesis 5.7-5.15. The averaged system is the model without its excitation, under the friction law
averaged over the fast slip velocity that the excitation makes (`friction.averaged`). It holds
while the excitation is fast against what it is averaged out of: the amplitude of the fast motion
is off by a share of (natural frequency / excitation frequency)^2.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from fiv_cli.analyses.rest.equilibria import Sliding, sliding_at
from fiv_cli.dynamics.system import System, build_system
from fiv_cli.friction.averaged import FAST_VELOCITY, averaged
from fiv_cli.schedule import STEADY

# Least ratio of the excitation's frequency to the highest natural one: the fast motion is then
# known to (1/5)^2 = 4 %.
LEAST_RATIO = 5.0

ORDER = 1  # of the series: an averaged system is linearised, never integrated


def averaged_sliding(
    system: System, points: Sequence[Mapping[str, float]]
) -> Iterator[tuple[NDArray[np.intp], Sliding]]:
    """The averaged systems, sliding as the drive imposes at rest, and which points are in each.

    The excitation reverses slip where its fast velocity is above the slip speed at rest: 5.15b;
    at equality it does not yet (5.15a).
    """
    amplitudes = np.array([fast_velocity(system, parameters) for parameters in points])
    speeds = np.abs(rest_velocities(sliding_at(system, points))).max(axis=-1)
    known = [
        {**parameters, FAST_VELOCITY.name: amplitude}
        for parameters, amplitude in zip(points, amplitudes.tolist(), strict=True)
    ]
    for reversing in (False, True):
        rows = np.flatnonzero((amplitudes > speeds) == reversing)
        if len(rows) > 0:
            slow = averaged_system(system, reversing)
            yield rows, sliding_at(slow, [known[row] for row in rows])


def fast_velocity(system: System, parameters: Mapping[str, float]) -> float:
    """Amplitude of the slip velocity that the excitation makes, m/s."""
    forcing = system.setup.model.averaged_forcing()
    assert forcing is not None and forcing.fast_velocity is not None
    return forcing.fast_velocity(system.known(parameters))


def rest_velocities(state: Sliding) -> NDArray[np.float64]:
    """Slip velocity of each contact while the model is at rest, m/s; shape (..., n_contacts)."""
    at_rest = np.zeros((*state.parameters.shape[:-1], len(state.system.state_names)))
    return state.contact_forces(at_rest)[..., 2]


def averaged_system(
    system: System, reversing: bool, announce: Callable[[str], None] = lambda sentence: None
) -> System:
    """`system` under its law averaged with, or without, reversal of slip; made once."""
    law = averaged(system.setup.law, reversing)
    return build_system(replace(system.setup, law=law, order=ORDER, schedule=STEADY), announce)


def frequency_ratio(
    system: System, parameters: Mapping[str, float], jacobian: NDArray[np.float64]
) -> float:
    """Excitation frequency over the highest undamped natural frequency of the averaged system.

    The damping is left out because it has a pole where the fast velocity just reaches the slip
    speed: in that layer the slow motion is as fast as the excitation at any frequency.

    Parameters
    ----------
    jacobian : of the averaged system at its equilibrium, (2m, 2m)
    """
    forcing = system.setup.model.averaged_forcing()
    assert forcing is not None
    m = len(jacobian) // 2
    squares = np.abs(np.linalg.eigvals(jacobian[m:, :m]))
    return float(forcing.frequency(system.known(parameters)) / np.sqrt(squares.max()))
