"""Whether a slide decays as the linearised system does, so that it must end at the equilibrium.

Where nothing sticks no event tells that the motion has come to rest, and waiting until it has
arrived takes long with weak damping. But near enough the amplitude of each mode falls at the rate
of its eigenvalue; further out, towards an unstable limit cycle, it falls more slowly.
"""

from __future__ import annotations

from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from fiv_cli.dynamics.system import Vector

LEADING = 0.1  # modes with this share of the largest amplitude are looked at
AGREEMENT = 0.1  # of the measured rate with the eigenvalue's


class Decay:
    """Amplitudes of the modes, from look to look.

    Parameters
    ----------
    jacobian : of the rates at the equilibrium, shape (n, n)
    equilibrium : state vector, shape (n,)
    span : least time between two looks, s
    """

    def __init__(self, jacobian: NDArray[np.float64], equilibrium: Vector, span: float) -> None:
        self.jacobian = jacobian
        self.equilibrium = equilibrium
        self.span = span
        self.time = -np.inf
        self.amplitudes = np.zeros(len(equilibrium))

    @cached_property
    def _modes(self) -> tuple[Vector, NDArray[np.complex128]]:
        """Growth rates and vectors."""
        values, vectors = np.linalg.eig(self.jacobian)
        return values.real, vectors.astype(complex)

    def confirms(self, time: float, state: Vector) -> bool:
        """Whether the leading modes fell at their rates since the last look (s, state vector).

        False at the first look and where the modes do not span the states.
        """
        elapsed = time - self.time
        if elapsed < self.span * (1.0 - 1e-12):
            return False
        rates, vectors = self._modes
        try:
            found = np.abs(np.linalg.solve(vectors, state - self.equilibrium))
        except np.linalg.LinAlgError:
            return False
        before = self.amplitudes
        self.time, self.amplitudes = time, found
        return _fell_at(rates, before, found, elapsed)


def _fell_at(rates: Vector, before: Vector, after: Vector, elapsed: float) -> bool:
    """Whether what was largest changed at its rate (1/s)."""
    leading = (before > 0.0) & (before >= LEADING * np.max(before))
    if not np.any(leading) or np.any(after[leading] <= 0.0):
        return False
    measured = np.log(after[leading] / before[leading]) / elapsed
    allowed = AGREEMENT * np.abs(rates[leading])
    return bool(np.all(np.abs(measured - rates[leading]) <= allowed))
