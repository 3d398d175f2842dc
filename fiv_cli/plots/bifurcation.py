"""Bifurcation diagram: what the motion passes at the Poincaré section, against a parameter."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from fiv_cli.errors import UsageError
from fiv_cli.plots import labels, points, style
from fiv_cli.reading import select

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure

DEFAULT = "section_value"


def suits(dataset: xr.Dataset) -> bool:
    """Whether the dataset holds section values along some axis."""
    return DEFAULT in dataset and bool(points.varying_axes(dataset))


def draw(layers: Sequence[points.Layer], settings: points.Settings) -> Figure:
    """Dots of every layer; one colour per start, branch or further axis."""
    figure, (ax,) = style.new_panels(1, 1, points.title(layers[0].dataset))
    name = points.one_variable(settings, DEFAULT)
    clouds = [cloud for layer in layers for cloud in _clouds(layer, name, settings)]
    count = sum(y.size for _, _, y in clouds)
    places = points.positions(points.abscissa(layers[0].dataset, settings))
    looks: dict[str, Any] = {
        "ms": style.dot_size(places.size),
        "rasterized": count > style.MANY_MARKS,
    }
    entries = points.entries([label for label, _, _ in clouds])
    for (_, x, y), entry in zip(clouds, entries, strict=True):
        ax.plot(x, y, ".", mew=0, ls="none", color=entry.colour, label=entry.label, **looks)
    # The axis reaches over the whole grid: where there are no dots nothing moves.
    ends = np.column_stack([[places.min(), places.max()], [0.0, 0.0]])
    ax.update_datalim(ends, updatey=False)
    ax.autoscale_view()
    ax.set_ylabel(labels.axis_label(layers[0].dataset[name]))
    points.dress(ax, layers, settings)
    return figure


def _clouds(
    layer: points.Layer, name: str, settings: points.Settings
) -> list[tuple[str, np.ndarray, np.ndarray]]:
    """(label, x, y) of each line of points of one dataset."""
    dataset = layer.dataset
    sizes = select.row_sizes(dataset, name) if name in dataset else None
    if sizes is None:
        raise UsageError(
            f"{name}: no values at a section in this dataset\n"
            "a bifurcation diagram needs a response analysis; draw another variable as a curve"
        )
    axis = points.abscissa(dataset, settings)
    dim = str(axis.dims[0])
    dims = [str(d) for d in sizes.dims]
    place = dict(zip(dims, np.unravel_index(select.row_of_each(sizes), sizes.shape), strict=True))
    x, y = points.positions(axis)[place[dim]], dataset[name].values
    clouds = []
    for line in points.lines(dataset, [dim], dims):
        belongs = np.logical_and.reduce(
            [place[d] == index for d, index in line.index.items()], initial=True
        ) & np.ones(y.shape, bool)
        clouds.append((points.joined(layer.label, line.label), x[belongs], y[belongs]))
    return clouds
