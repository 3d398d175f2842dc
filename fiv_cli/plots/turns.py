"""Where, between two points of a grid, equilibria turn stable or unstable."""

from __future__ import annotations

import numpy as np

from fiv_cli.plots import leaps, points


def up_to_turns(
    changes: np.ndarray, x: np.ndarray, every: np.ndarray, own: np.ndarray, growth: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Places and heights of one's own among `every` equilibrium, up to where it turns another's.

    Between two neighbours that is the only one of the `changes` there, else where a straight line
    between their rates of `growth` is zero, or the middle where these have not two signs; none
    where equilibria leap from one to the other, as where a drive changes its sense, and no line
    leads there. Last come where it turns, shape (turns, 2), and which of these a change tells.
    """
    known = np.isfinite(own)
    leap = leaps.leaps(every, np.zeros(every.size, int), points.shown_of({}, every), False)
    goes_on = np.isfinite(every[1:] + every[:-1]) & ~leap
    right = 1 + np.flatnonzero((known[1:] != known[:-1]) & goes_on)
    pairs = [slice(at - 1, at + 1) for at in right]
    told = np.array([_between(changes, x[pair]).size == 1 for pair in pairs], bool)
    share = np.array([_share(changes, x[pair], growth[pair]) for pair in pairs])
    at, height = (of[right - 1] + share * (of[right] - of[right - 1]) for of in (x, every))
    cuts = 1 + np.flatnonzero(leap)
    places = np.insert(x, [*right, *cuts], [*at, *(0.5 * (x[cuts] + x[cuts - 1]))])
    heights = np.insert(own, [*right, *cuts], [*height, *np.full(cuts.size, np.nan)])
    return places, heights, np.array([at, height]).T, told


def _between(changes: np.ndarray, places: np.ndarray) -> np.ndarray:
    """The changes between two neighbours."""
    one, other = places
    return changes[((changes - one) * (changes - other) <= 0.0) & (one != other)]


def _share(changes: np.ndarray, places: np.ndarray, growth: np.ndarray) -> float:
    """How far from one neighbour to the other an equilibrium turns."""
    (one, other), (before, after) = places, growth
    if (between := _between(changes, places)).size == 1:
        return float((between[0] - one) / (other - one))
    return float(before / (before - after)) if before * after < 0.0 else 0.5
