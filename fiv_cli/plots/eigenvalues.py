"""Complex eigenvalues against a parameter: growth rates above, frequencies below."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from fiv_cli.data import select
from fiv_cli.errors import UsageError
from fiv_cli.plots import labels, points, style

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

PARTS = ("eigenvalue_real", "mode_frequency")
DASHES = ("-", "--", "-.", ":")


def suits(dataset: xr.Dataset) -> bool:
    """Whether the dataset holds eigenvalues along some axis."""
    return PARTS[0] in dataset and bool(points.varying_axes(dataset))


def draw(layers: Sequence[points.Layer], settings: Mapping[str, Any]) -> Figure:
    """A colour for each mode, a dash for each value of the other axes; unstable points marked."""
    dataset = layers[0].dataset
    if PARTS[0] not in dataset:
        raise UsageError("no eigenvalues in this dataset\nadd an analysis of kind `eigenvalues`")
    axis = points.abscissa(dataset, settings)
    figure, axes = style.new_panels(2, 1, points.title(dataset), sharex=True)
    for ax, name in zip(axes, PARTS, strict=True):
        _panel(ax, dataset, name, axis)
        ax.set_ylabel(labels.axis_label(dataset[name]))
        points.scale(ax, settings)
    axes[0].axhline(0.0, color=style.BLACK, lw=0.8)
    points.dress_axis(axes[1], axis, "x")
    points.mark_gaps(axes[1], dataset, axis)
    points.legend(axes[0])
    return figure


def _panel(ax: Axes, dataset: xr.Dataset, name: str, axis: xr.DataArray) -> None:
    dim = str(axis.dims[0])
    x = points.positions(axis)
    modes = select.axis_of(dataset, "mode").values
    lines = points.lines(dataset, [dim], points.grid_dims(dataset))
    # the colour of unstable points is no mode's
    colours = [c for c in style.line_colours(modes.size + 1) if c != style.VERMILLION]
    for number, line in enumerate(lines):
        part = dataset.isel(line.index)
        for mode, number_of_mode in enumerate(modes):
            y = part[name].isel(mode=mode).values
            dash = DASHES[number % len(DASHES)]
            label = points.joined(f"mode {number_of_mode}", line.label)
            ax.plot(x, y, dash, color=colours[mode], label=label)
            unstable = part[PARTS[0]].isel(mode=mode).values > 0.0
            ax.plot(
                x[unstable], y[unstable], "o", ms=3.5, color=style.VERMILLION, mec="white", mew=0.4,
                zorder=4,
            )  # fmt: skip
    if np.any(dataset[PARTS[0]].values > 0.0):
        ax.plot([], [], "o", ms=3.5, color=style.VERMILLION, label="unstable")
