"""The largest nontrivial Lyapunov exponent of a motion."""

from __future__ import annotations

import math

import numpy as np

from fiv_cli.codegen.memory import FixedInt, Floats, Frame, call_generated, native
from fiv_cli.dynamics.kernel import Run, state_index
from fiv_cli.dynamics.motion import Motion

STRETCHES = 16


class Growth(Frame):
    """How a tangent vector has grown, block after block."""

    is_autonomous: FixedInt
    count: int  # blocks
    last: float  # time at which the last one ended, s
    growths: Floats  # logarithms
    spans: Floats  # s


def growth_at(address: int) -> Growth:
    """The growth whose frame is at an address."""
    return Growth.at(address)


@native
def normalise_tangent(growth: Growth, run: Run) -> float:
    """Give the tangent length one, across the flow where that is trivial; its length before."""
    n, index, flow = run.n_states, state_index(run.kinds, run.n_contacts), run.outputs
    if growth.is_autonomous == 1 and run.field[index] != 0:
        call_generated(run.field[index], run.coefficients, run.time, run.y, flow)
        along, size = 0.0, 0.0
        for i in range(n):
            along += run.tangents[0, i] * flow[n + i]
            size += flow[n + i] * flow[n + i]
        if size > 0.0:
            for i in range(n):
                run.tangents[0, i] -= along / size * flow[n + i]
    square = 0.0
    for i in range(n):
        square += run.tangents[0, i] * run.tangents[0, i]
    norm = math.sqrt(square)
    if norm > 0.0:
        for i in range(n):
            run.tangents[0, i] /= norm
    return norm


@native
def book_growth(growth: Growth, run: Run) -> None:
    """Book the growth since the last call."""
    if run.time > growth.last:
        norm = normalise_tangent(growth, run)
        growth.growths[growth.count] = math.log(norm) if norm > 0.0 else -math.inf
        growth.spans[growth.count] = run.time - growth.last
        growth.last = run.time
        growth.count += 1


def error_of_mean(amounts: Floats, spans: Floats) -> float:
    """Standard error of a mean over time, from the scatter of 16 stretches; 0 where there is none.

    Parameters
    ----------
    amounts, spans : what was added up in each block of time, and how long it lasted, s
    """
    if not len(amounts) or not np.all(np.isfinite(amounts)):
        return 0.0
    stretches = np.array_split(np.arange(len(amounts)), min(STRETCHES, len(amounts)))
    means = np.array([amounts[one].sum() / spans[one].sum() for one in stretches])
    return float(np.std(means) / np.sqrt(max(len(means) - 1, 1)))


class Exponent:
    """The exponent from one tangent vector.

    On an autonomous system the direction of the flow is trivial; the vector is kept orthogonal
    to it, so that its growth is that of the next direction. Saltation at events is the driver's.

    Parameters
    ----------
    blocks : between which the tangent is normalised (`book_growth`), at most
    """

    def __init__(self, motion: Motion, autonomous: bool, blocks: int) -> None:
        self.motion = motion
        room = {"growths": np.zeros(blocks), "spans": np.zeros(blocks)}
        self.growth = Growth.holding(room, {})
        self.growth.is_autonomous, self.growth.last = int(autonomous), motion.time
        # A fixed direction without symmetry, so that no invariant subspace is met by accident.
        vector = np.cos(1.0 + np.arange(len(motion.y)) * 2.0**0.5)
        motion.carry_tangents(vector[None, :])
        normalise_tangent(self.growth, motion.frame)

    def release(self) -> None:
        """Stop carrying the tangent."""
        self.motion.carry_tangents(np.zeros((0, len(self.motion.y))))

    @property
    def mean(self) -> float:
        """1/s; NaN of a motion that was not followed, or whose tangent grew beyond all numbers."""
        growths, spans = self._blocks
        if not len(spans) or np.isposinf(growths).any():
            return float("nan")
        return float(np.sum(growths) / np.sum(spans))

    @property
    def error(self) -> float:
        """Standard error of `mean`, from the scatter of blocks; 0 where there is none."""
        return error_of_mean(*self._blocks)

    @property
    def _blocks(self) -> tuple[Floats, Floats]:
        """Growths and spans of the blocks so far."""
        count = self.growth.count
        return self.growth.growths[:count], self.growth.spans[:count]
