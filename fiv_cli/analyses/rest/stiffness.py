"""What a friction law costs: its steps against those under Coulomb's law, before any is taken.

The fastest rate of the linearised motion bounds the steps of an explicit method. A law that is
smooth, or has states of its own, brings rates that the model does not have: bristles relax at
sigma_0 |v|/g in sliding, the slope of a regularised sign is felt while a contact nearly rests. Both
are looked at: the sliding equilibrium, and the same place with all contacts at rest. Where bonds
snap, each is a step at least.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from fiv_cli.analyses.rest.equilibria import Sliding, equilibria_at, sliding_at
from fiv_cli.codegen.setup import Setup, default_parameters
from fiv_cli.dynamics.system import System, Vector, build_system
from fiv_cli.friction import get_law

Points = Sequence[Mapping[str, float]]
Real = NDArray[np.float64]
Snaps = Callable[[Mapping[str, float]], float]
Announce = Callable[[str], None]

REFERENCE = "coulomb"
# A step times the fastest rate, of the series of order 16: where a mode that has died out still
# bounds it (the real interval of stability), and where one that lives does (its error).
DEAD, ALIVE = 7.0, 2.0


class Cost(NamedTuple):
    """Steps of a law in those of Coulomb's, at each of several points.

    Attributes
    ----------
    sliding : at the sliding equilibrium
    resting : at most, while the contacts nearly rest
    """

    sliding: Real
    resting: Real


def cost_of(setup: Setup, points: Points, announce: Announce = lambda sentence: None) -> Cost:
    """The cost of the law of `setup` at `points`; NaN where Coulomb's motion has no rate.

    `announce` is told when code must be generated or compiled.
    """
    coulomb, adopted = _under_coulomb(setup, points)
    system = build_system(setup, announce)
    own = _fastest(system, points)
    if setup.law.snaps is not None:
        own[0] = np.maximum(own[0], DEAD * _snapping(system, setup.law.snaps, points))
    reference = _fastest(build_system(coulomb, announce), adopted)
    known = np.where(reference[0] > 0.0, reference[0], np.nan)
    return Cost(*(ALIVE / DEAD * own / known))


def _snapping(system: System, snaps: Snaps, points: Points) -> Real:
    """Events, 1/s, of contacts that slide as fast as they are driven."""
    slips = sliding_at(system, points).contact_forces(
        np.zeros((len(points), len(system.state_names)))
    )
    fast: Real = np.abs(slips[:, list(system.pieces.laws), 2]).sum(axis=-1)
    return fast * [snaps(point) for point in points]


def _under_coulomb(setup: Setup, points: Points) -> tuple[Setup, Points]:
    """The same model under Coulomb's law."""
    law = get_law(REFERENCE)
    usual = default_parameters(setup.model, law)
    adopted = [{n: point.get(n, value) for n, value in usual.items()} for point in points]
    return replace(setup, law=law, structural={}), adopted


def _fastest(system: System, points: Points) -> Real:
    """Greatest rate, 1/s, in sliding and at rest; shape (2, points)."""
    state = sliding_at(system, points)
    at_rest = np.zeros(len(system.state_names))
    found = [one.states[0] if one.states else at_rest for one in equilibria_at(state)]
    sliding = np.array(found)
    stopped = _stopped(state, sliding)
    return np.array([_greatest(state, sliding), _greatest(_begun(state), stopped)])


def _begun(state: Sliding) -> Sliding:
    """The same with the law in the pieces that it begins in, where nothing has slipped yet."""
    system, parameters = state.system, state.parameters.copy()
    first, rows = system.n_own_parameters, system.pieces.first_rows
    parameters[..., first : first + len(rows)] = rows
    return replace(state, parameters=parameters, coefficients=system.coefficients(parameters))


def _greatest(state: Sliding, y: Vector) -> Real:
    """The greatest eigenvalue of each point."""
    jacobians = state.jacobian(y)
    sound = np.asarray(np.isfinite(jacobians).all(axis=(-1, -2)))
    values = np.linalg.eigvals(np.where(sound[:, None, None], jacobians, 0.0))
    greatest: Real = np.where(sound, np.abs(values).max(axis=-1), np.inf)
    return greatest


def _stopped(state: Sliding, y: Vector) -> Vector:
    """The least velocities with which no contact slips, and bristles that stand upright."""
    system, m = state.system, len(state.system.coordinates)
    slips = state.contact_forces(y)[..., 2]
    units = np.eye(y.shape[-1])[m : 2 * m]
    changes = [state.contact_forces(y + unit)[..., 2] - slips for unit in units]
    stopped = y.copy()
    stopped[:, m : 2 * m] -= np.einsum("pvc,pc->pv", np.linalg.pinv(np.stack(changes, -1)), slips)
    stopped[:, len(system.motions) :] = 0.0
    return stopped
