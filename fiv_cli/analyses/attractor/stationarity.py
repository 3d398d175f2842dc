"""Does the set of section points stay where it is?

Means and spreads of the two halves are compared. How far they may differ by chance is told by how
far the partial sums of each half wander about their mean: of a quasi-periodic sequence these are
bounded, and what is left of a turn at the ends is all that its means differ by; of a random one
they wander as a bridge does, correlated or not. A mean that creeps at a constant rate differs by
4 times what its partial sums explain, however slowly it creeps. One that has all but arrived creeps
steadily enough in the last half of the set, which is asked too, and leaves a spread that is a share
of what it was.

On a slow spiral into a cycle, or a slow way to one along a torus, the halves may yet agree. There
neighbours are looked at: points and what comes closest to them, some returns later. On a torus
their distance varies with the place alone, and in the mean over as many returns hardly at all; on a
spiral, however slow, it creeps.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from fiv_cli.analyses.attractor.chaos import displacements
from fiv_cli.analyses.attractor.grounds import NEGLIGIBLE, STEADY, UNNOTICED, WANDERING

FEWEST = 32  # section points below which nothing is said
PARTS = (1, 2)  # of which the last is asked
SHRUNK = 0.5  # a half whose spread is below this share of the other's is not of the same set
LEAST = float(np.finfo(float).tiny)  # a distance that is none
STILL = 1e-9  # spread, over its values, of a state that does not move


def drift(points: NDArray[np.float64], kinds: tuple[int, ...] = ()) -> float:
    """Largest difference between the halves of a section set, in its spread; 0: stationary.

    A difference that sampling may bring about counts as none; NaN: too few points.

    Parameters
    ----------
    points : section points, oldest first; shape (count, n)
    kinds : places at which states of another kind (velocities after displacements) begin; the
        spread is the largest of a kind: what moves a thousandth of that may do as it likes
    """
    if len(points) < FEWEST:
        return float("nan")
    lasts = (points[-len(points) // share :] for share in PARTS)
    return max(_drift(last, kinds) for last in lasts if len(last) >= FEWEST)


def parting(points: NDArray[np.float64], kinds: tuple[int, ...] = ()) -> float:
    """Growth of the distance of neighbours between the halves of a section set, a logarithm.

    0: none that sampling does not explain, as on a torus; NaN: sampling may hide one that matters.

    Parameters
    ----------
    points, kinds : as of `drift`
    """
    shown, share = _shown(points, kinds)
    paths = shown * share
    later = 1 + int(np.argmin(np.sum(displacements(paths.T), axis=0)))
    distances = _lengths(paths[later:] - paths[:-later])
    passed = np.cumsum(np.log(np.maximum(distances, LEAST)))
    grown, sampling = _between_halves((passed[later:] - passed[:-later]) / later)
    if abs(grown) > max(WANDERING * sampling, UNNOTICED):
        return grown
    return 0.0 if WANDERING * sampling <= STEADY else float("nan")


def _lengths(steps: NDArray[np.float64]) -> NDArray[np.float64]:
    """Of steps, along principal directions in each of which they are made equally long."""
    squares, directions = np.linalg.eigh(steps.T @ steps / len(steps))
    leading = squares > NEGLIGIBLE**2 * squares[-1]
    evened = steps @ (directions[:, leading] / np.sqrt(squares[leading]))
    return np.asarray(np.linalg.norm(evened, axis=1))


def _shown(
    points: NDArray[np.float64], kinds: tuple[int, ...]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """The states that move, each with mean 0 and spread 1; its spread over that of its kind."""
    spread = np.std(points, axis=0)
    moving = np.flatnonzero(spread > STILL * np.max(np.abs(points), axis=0))
    largest = [np.full(len(kind), np.max(kind, initial=0.0)) for kind in np.split(spread, kinds)]
    shown = (points[:, moving] - np.mean(points[:, moving], axis=0)) / spread[moving]
    return shown, spread[moving] / np.concatenate(largest)[moving]


def _drift(points: NDArray[np.float64], kinds: tuple[int, ...]) -> float:
    shown, share = _shown(points, kinds)
    found = [max(map(_difference, (one, one**2))) for one in shown.T]
    shrunk = [max(pair) for pair in zip(found, map(_shrinking, shown.T), strict=True)]
    worst = float(np.max(share * shrunk, initial=0.0))
    return worst if worst > NEGLIGIBLE else 0.0


def _shrinking(values: NDArray[np.float64]) -> float:
    """Difference between the spreads of two halves; 0 unless one is a share of the other."""
    half = len(values) // 2
    less, more = sorted((float(np.std(values[:half])), float(np.std(values[-half:]))))
    return more - less if less < SHRUNK * more else 0.0


def _difference(values: NDArray[np.float64]) -> float:
    """Difference between the means of two halves; 0 where sampling explains it."""
    apart, sampling = _between_halves(values)
    return 0.0 if abs(apart) <= max(WANDERING * sampling, NEGLIGIBLE) else abs(apart)


def _between_halves(values: NDArray[np.float64]) -> tuple[float, float]:
    """Difference between the means of two halves, and what sampling explains of it."""
    half = len(values) // 2
    before, after = values[:half], values[-half:]
    return float(np.mean(after) - np.mean(before)), _wandering(before) + _wandering(after)


def _wandering(values: NDArray[np.float64]) -> float:
    """Range of the partial sums about the mean, over the number of values."""
    return float(np.ptp(np.cumsum(values - np.mean(values)))) / len(values)
