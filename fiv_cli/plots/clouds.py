"""What a bifurcation diagram marks: values at the section and rests, for each start and place."""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from fiv_cli.errors import UsageError
from fiv_cli.plots import points
from fiv_cli.reading import select
from fiv_cli.reading.datasets import is_class

if TYPE_CHECKING:
    import xarray as xr

DEFAULT = "section_value"
CROWD = 8  # values at one point of the grid; more are drawn smaller: their marks would be a bar
SAME = 1e-6  # relative distance of values of one motion
ALIKE = 1e-3  # of heights that are the same in a figure


@dataclass(frozen=True)
class Cloud:
    """One line of points: what their motions pass at the section, and where they are at rest.

    `family` says at which values of other axes, `start` from which start. `crowded` are the values
    at points that have many, `undecided` those of points of no class. `told` are the rests through
    which a line of equilibria is drawn, `sticking` those at which a contact sticks.
    """

    family: str
    start: str
    x: np.ndarray
    y: np.ndarray
    crowded: np.ndarray
    undecided: np.ndarray
    rest_x: np.ndarray
    rest_y: np.ndarray
    told: np.ndarray
    sticking: np.ndarray

    @property
    def label(self) -> str:
        """Where it is of which start."""
        return points.joined(self.family, self.start)


def clouds_of(
    layer: points.Layer, name: str, equilibria: xr.DataArray, settings: points.Settings
) -> Iterator[Cloud]:
    """The lines of points of one dataset, a line for each start and value of the other axes.

    `equilibria` are the heights of those that are drawn as lines.
    """
    dataset = layer.dataset
    sizes = select.row_sizes(dataset, name)
    if sizes is None:
        raise UsageError(f"{name}: no values at a section\nnext: draw it as a curve")
    axis = points.abscissa(dataset, settings)
    dim, dims = str(axis.dims[0]), [str(d) for d in sizes.dims]
    point = select.row_of_each(sizes)
    place = dict(zip(dims, np.unravel_index(point, sizes.shape), strict=True))
    crowded = sizes.values.ravel()[point] > CROWD
    doubt = points.gaps(dataset).get("undecided", sizes < 0).transpose(*dims).values.ravel()
    undecided = doubt[point]
    x, y, rest = points.positions(axis), dataset[name].values, _rest(dataset, name)
    lines = equilibria.reindex_like(rest)  # of a case with other points, maybe
    told, sticking = abs(rest - lines) <= ALIKE * abs(lines), _sticking(dataset)
    for line in points.lines(dataset, [dim], dims):
        belongs = np.logical_and.reduce(
            [place[d] == index for d, index in line.index.items()], initial=True
        ) & np.ones(y.shape, bool)
        still, on_line, sticks = (one.isel(line.index).values for one in (rest, told, sticking))
        known = np.isfinite(still)
        values = [word for dim, word in line.words.items() if dim != "initial"]
        family, start = points.joined(layer.label, *values), line.words.get("initial", "")
        at_section = x[place[dim][belongs]], y[belongs], crowded[belongs], undecided[belongs]
        at_rest = x[known], still[known], on_line[known], sticks[known]
        yield Cloud(family, start, *at_section, *at_rest)


def places_of(clouds: Sequence[Cloud]) -> np.ndarray:
    """Where some clouds have values or rest."""
    return np.unique(np.concatenate([own for one in clouds for own in (one.x, one.rest_x)]))


def shared_apart(clouds: Sequence[Cloud]) -> Iterator[Cloud]:
    """With a cloud of its own for what all starts lead to: their marks would be a tangle."""
    for _, group in itertools.groupby(clouds, lambda cloud: cloud.family):
        family = [*group]
        starts = {points.stem(cloud.start) for cloud in family}
        shared = _where_alike(family) if 1 < len(starts) == len(family) else np.zeros(0)
        yield from (part_at(cloud, shared, without=True) for cloud in family)
        if shared.size:
            yield replace(part_at(family[0], shared), start=points.SHARED[len(starts) > 2])


def _where_alike(clouds: Sequence[Cloud]) -> np.ndarray:
    """The places at which all have the same values, and rest alike."""
    places = places_of(clouds[:1])
    heights = np.concatenate([own for one in clouds for own in (one.y, one.rest_y)])
    off = SAME * np.abs(heights).max(initial=0.0)
    alike = [
        all(len(one) == len(first) and np.allclose(one, first, SAME, off) for one in others)
        for first, *others in zip(*(_told_at(cloud, places) for cloud in clouds), strict=True)
    ]
    return places[np.array(alike, bool)]


def _told_at(cloud: Cloud, places: np.ndarray) -> list[np.ndarray]:
    """What a cloud has at each place: how many values, these, of a class or not, and its rests."""
    order = np.lexsort([cloud.y, cloud.x])
    passed = np.column_stack([cloud.y, cloud.undecided])[order]
    ends = (np.searchsorted(cloud.x[order], places, side) for side in ("left", "right"))
    return [
        np.concatenate([[end - begin], *passed[begin:end].T, cloud.rest_y[cloud.rest_x == place]])
        for place, begin, end in zip(places, *ends, strict=True)
    ]


def part_at(cloud: Cloud, places: np.ndarray, *, without: bool = False) -> Cloud:
    """The part of a cloud at some places, or `without` these."""
    passed, rests = (np.isin(own, places) != without for own in (cloud.x, cloud.rest_x))
    of_values = {n: getattr(cloud, n)[passed] for n in ("x", "y", "crowded", "undecided")}
    of_rests = {n: getattr(cloud, n)[rests] for n in ("rest_x", "rest_y", "told", "sticking")}
    return replace(cloud, **of_values, **of_rests)


def observed_state(variable: xr.DataArray) -> str:
    """The state that a variable at the section is about: the first of its words."""
    return str(variable.attrs.get("long_name", "")).split(" ")[0]


def _rest(dataset: xr.Dataset, name: str) -> xr.DataArray:
    """Where each point rests, NaN where it does not."""
    extreme = f"{observed_state(dataset[name])}_max"
    if extreme not in dataset or "attractor" not in dataset:
        return dataset["status"] * np.nan
    return dataset[extreme].where(is_class(dataset["attractor"], ("equilibrium",)))


def _sticking(dataset: xr.Dataset) -> xr.DataArray:
    """Where some contact sticks, or nothing is known of that."""
    share = dataset.get("stick_fraction", dataset["status"] * np.nan)
    return ~(share.max([d for d in share.dims if d not in dataset["status"].dims]) <= 0.0)
