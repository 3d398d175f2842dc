"""Lines through computed points that are as smooth as what they were computed of."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from fiv_cli.plots.drawn import DECORATION

if TYPE_CHECKING:
    from matplotlib.axes import Axes

FEWEST = 4  # points of a stretch that a spline is put through
FEWEST_ALONG = 6  # ... of a line of which not even the places are known
FINER = 6
UNSEEN = 1e-5  # of the extent: a step that shows no direction, as one from a fold


def through(places: np.ndarray, path: np.ndarray) -> np.ndarray:
    """The path through points (points, values) at rising places, with little overshoot."""
    if places.size < FEWEST:
        return path
    from scipy.interpolate import Akima1DInterpolator

    between = np.linspace(0.0, 1.0, FINER, endpoint=False)
    fine = np.append((places[:-1, None] + between * np.diff(places)[:, None]).ravel(), places[-1])
    smooth: np.ndarray = Akima1DInterpolator(places, path, method="makima")(fine)
    return smooth


def draw(ax: Axes, x: np.ndarray, y: np.ndarray, label: str, **look: Any) -> None:
    """Draw a line of a branch; a table of the figure has its points, as they were computed."""
    line = along(x, y)
    is_another = line[0] is not x
    ax.plot(x, y, label=label, visible=not is_another, **look)
    if is_another:
        ax.plot(*line, label=DECORATION, **look)


def along(x: np.ndarray, y: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The same along a line of a branch, between whose points nothing is known: not over gaps, and
    nowhere beyond the two points that it lies between."""
    path = np.column_stack([x, y])
    extent = np.ptp(path, axis=0)
    extent = np.where(extent > 0.0, extent, 1.0)
    steps = np.linalg.norm(np.diff(path, axis=0) / extent, axis=1)
    if not (steps > 0.0).all():
        return x, y
    path = path[_seen(steps)]
    steps = np.linalg.norm(np.diff(path, axis=0) / extent, axis=1)
    if len(path) < FEWEST_ALONG:
        return x, y
    before, after = (
        np.repeat(end(path[:-1], path[1:]), FINER, axis=0) for end in (np.minimum, np.maximum)
    )
    smooth = through(np.append(0.0, np.cumsum(steps)), path)
    smooth[:-1] = np.clip(smooth[:-1], before, after)
    return smooth[:, 0], smooth[:, 1]


def _seen(steps: np.ndarray) -> np.ndarray:
    """Which points of a path lie apart from the one before; its last one in any case."""
    apart = np.append(True, steps > UNSEEN)
    if apart.size > 2 and not apart[-1]:
        apart[-2:] = False, True
    return apart
