"""The largest nontrivial Lyapunov exponent of a motion."""

from __future__ import annotations

import numpy as np

from fiv_cli.dynamics.motion import Motion
from fiv_cli.dynamics.system import Vector


class Exponent:
    """The exponent from one tangent vector.

    On an autonomous system the direction of the flow is trivial; the vector is kept orthogonal
    to it, so that its growth is that of the next direction. Saltation at events is the driver's.
    """

    def __init__(self, motion: Motion, autonomous: bool) -> None:
        self.motion = motion
        self.autonomous = autonomous
        n = len(motion.y)
        self.scales = np.maximum(np.abs(motion.y), 1e-300)
        self.begun = motion.time
        self.growths: list[float] = []
        self.spans: list[float] = []
        self.last = motion.time
        # A fixed direction without symmetry, so that no invariant subspace is met by accident.
        vector = np.cos(1.0 + np.arange(n) * 2.0**0.5)
        motion.carry_tangents(self._normalised(vector)[0][None, :])

    def _normalised(self, vector: Vector) -> tuple[Vector, float]:
        if self.autonomous:
            flow = self.motion.rates()
            size = float(flow @ flow)
            vector = vector - (vector @ flow) / size * flow if size > 0.0 else vector
        norm = float(np.linalg.norm(vector))
        return (vector / norm if norm > 0.0 else vector), norm

    def update(self) -> None:
        """Book the growth since the last call."""
        vector, norm = self._normalised(self.motion.tangents[0])
        span = self.motion.time - self.last
        if span > 0.0:
            self.growths.append(float(np.log(norm)) if norm > 0.0 else -np.inf)
            self.spans.append(span)
            self.last = self.motion.time
            self.motion.carry_tangents(vector[None, :])

    def release(self) -> None:
        """Stop carrying the tangent."""
        self.motion.carry_tangents(np.zeros((0, len(self.motion.y))))

    @property
    def mean(self) -> float:
        """1/s."""
        return float(np.sum(self.growths) / np.sum(self.spans)) if self.spans else float("nan")

    @property
    def error(self) -> float:
        """Standard error of `mean`, from the scatter of blocks; 0 where it is not finite."""
        if not np.all(np.isfinite(self.growths)):
            return 0.0
        groups = np.array_split(np.arange(len(self.growths)), min(16, max(len(self.growths), 1)))
        growths, spans = np.array(self.growths), np.array(self.spans)
        rates = np.array([growths[g].sum() / spans[g].sum() for g in groups if len(g)])
        return float(np.std(rates) / np.sqrt(max(len(rates) - 1, 1)))
