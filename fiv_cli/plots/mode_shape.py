"""Mode shapes of a plate seen from above: R(r) cos(l theta) in colours."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from fiv_cli.errors import UsageError
from fiv_cli.plots import labels, points, style

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

MOST_MODES = 16
COLUMNS = 4
ANGLES = 181
SIZE = 2.7  # of a panel with its title, inches
COLOURS = "RdBu_r"


def suits(dataset: xr.Dataset) -> bool:
    """Whether the dataset holds mode shapes of a plate."""
    return "shape" in dataset and "plate_frequency" in dataset


def draw(layers: Sequence[points.Layer], settings: points.Settings) -> Figure:
    """A round panel for each mode, each in its own scale, with its frequency."""
    dataset = layers[0].dataset
    modes = _modes(dataset)
    figure, axes, columns = style.grid_of_panels(
        len(modes), COLUMNS, points.title(dataset), subplot_kw={"projection": "polar"}
    )
    rows = len(axes) // columns
    style.resize(figure, SIZE * columns + 1.2, SIZE * rows + 0.6, rows)
    for ax, mode in zip(axes, modes, strict=False):
        _paint(ax, mode, settings)
    label = r"$R(r)\,\cos(l\theta)$ over its largest value"
    figure.colorbar(axes[0].collections[0], ax=axes, label=label, shrink=0.75)
    return figure


def _modes(dataset: xr.Dataset) -> list[xr.Dataset]:
    """The modes of one point of the dataset, by rising frequency."""
    if not suits(dataset):
        raise UsageError("no mode shapes in this dataset\nrun a case with an analysis `plate`")
    varying = [str(axis.name) for axis in points.varying_axes(dataset)]
    if varying:
        raise UsageError(
            f"mode shapes are drawn of one plate, and {', '.join(varying)} varies\n"
            "choose a value with `select` in the figure"
        )
    alone = dataset.isel(dict.fromkeys(points.grid_dims(dataset), 0))
    pairs = np.argwhere(np.isfinite(alone["shape"].values).all(axis=2))
    modes = [alone.isel(k=int(k), l=int(n)) for k, n in pairs]
    if not 1 <= len(modes) <= MOST_MODES:
        raise UsageError(
            f"{len(modes)} modes in one figure\nchoose up to {MOST_MODES} with `select`: k, l"
        )
    return sorted(modes, key=lambda mode: float(mode["plate_frequency"]))


def _paint(ax: Axes, mode: xr.Dataset, settings: points.Settings) -> None:
    diameters, radius = int(mode["l"]), mode["radius"].values
    angle = np.linspace(0.0, 2.0 * np.pi, ANGLES)
    height = np.outer(mode["shape"].values, np.cos(diameters * angle))
    height /= np.max(np.abs(height))
    ax.grid(False)
    ax.pcolormesh(
        angle, radius, height, shading="gouraud", cmap=COLOURS, vmin=-1.0, vmax=1.0, rasterized=True
    )
    ax.plot(angle, np.full(ANGLES, radius[0]), color=style.GREY, lw=0.8)
    ax.set_ylim(0.0, radius[-1])
    ax.set_xticks([])
    ax.set_yticks([])
    ax.spines["polar"].set_color(style.GREY)
    frequency = mode["plate_frequency"]
    if settings.get("unit") == "Hz":
        words = f"{float(frequency) / (2.0 * np.pi):.1f} Hz"
    else:
        words = f"{float(frequency):.2f} {labels.unit_text(frequency.attrs['units'])}"
    ax.set_title(f"$k$ = {int(mode['k'])}, $l$ = {diameters}: {words}")
