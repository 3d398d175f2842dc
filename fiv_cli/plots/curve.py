"""A variable against an axis, a line for each start and for each value of the other axes."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from fiv_cli.data import select
from fiv_cli.data.flags import NOT_COMPUTED
from fiv_cli.data.reading import flag_names, numbers
from fiv_cli.errors import UsageError
from fiv_cli.plots import labels, points, style

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

# What a curve shows unless the figure says otherwise: the first of these that is there.
PREFERRED = ("L_s", "growth_rate", "n_solutions", "attractor")

CLASS_SHIFT = 0.06


def suits(dataset: xr.Dataset) -> bool:
    """Whether there is a scalar variable along some axis."""
    return any(name in dataset for name in PREFERRED) and bool(points.varying_axes(dataset))


def draw(layers: Sequence[points.Layer], settings: Mapping[str, Any]) -> Figure:
    """Lines of every layer; points without an answer are marked along the lower edge."""
    figure, (ax,) = style.new_panels(1, 1, points.title(layers[0].dataset))
    name = variable_of(layers[0].dataset, settings)
    curves = [curve for layer in layers for curve in _curves(layer, name, settings)]
    colours = style.line_colours(len(curves))
    classes = bool(flag_names(layers[0].dataset[name].attrs))
    for number, ((label, x, y), colour) in enumerate(zip(curves, colours, strict=True)):
        # lines of classes lie on one another: each is moved a little, and there is no in-between
        shift = classes * CLASS_SHIFT * (number - (len(curves) - 1) / 2)
        ax.plot(x, y + shift, "." if classes else ".-", ms=3, color=colour, label=label)
    _dress(ax, layers, name, settings)
    return figure


def variable_of(dataset: xr.Dataset, settings: Mapping[str, Any]) -> str:
    """The variable that the figure names (``variable``, or ``y``), else the preferred one.

    Raises
    ------
    UsageError : the dataset has no such variable
    """
    known = [str(name) for name in dataset.data_vars]
    default = next((name for name in PREFERRED if name in known), "")
    name = str(settings.get("variable", settings.get("y", default)))
    if name not in known:
        raise UsageError(f"{name or 'variable'}: not in this dataset\nit has: {', '.join(known)}")
    return name


def _curves(
    layer: points.Layer, name: str, settings: Mapping[str, Any]
) -> list[tuple[str, np.ndarray, np.ndarray]]:
    """(label, x, y) of each line of one dataset."""
    dataset = layer.dataset
    axis = points.abscissa(dataset, settings)
    array = numbers(dataset[name])
    dim = str(axis.dims[0])
    if dim not in array.dims or select.row_sizes(dataset, name) is not None:
        raise UsageError(
            f"{name}: not one value per point along {axis.name}\n"
            f"it varies along: {', '.join(map(str, array.dims)) or 'nothing'}"
        )
    x = points.positions(axis)
    return [
        (points.joined(layer.label, line.label), x, array.isel(line.index).values)
        for line in points.lines(dataset, [dim], [str(d) for d in array.dims])
    ]


def _dress(
    ax: Axes, layers: Sequence[points.Layer], name: str, settings: Mapping[str, Any]
) -> None:
    first = layers[0].dataset
    points.dress_axis(ax, points.abscissa(first, settings), "x")
    ax.set_ylabel(labels.axis_label(first[name]))
    classes = {c: n for c, n in flag_names(first[name].attrs).items() if n != NOT_COMPUTED}
    if classes:
        ax.set_yticks(list(classes), labels=[word.replace("_", " ") for word in classes.values()])
    for layer in layers:
        points.mark_gaps(ax, layer.dataset, points.abscissa(layer.dataset, settings))
    points.scale(ax, settings)
    points.legend(ax)
