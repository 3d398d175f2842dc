"""Amplitudes over time and frequency: of a spectrogram, or of the samples of a history.

Of a history it is a short-time Fourier transform under Hann windows; ``resolution`` (Hz) in the
figure sets their length, 2 / resolution.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from fiv_cli.errors import UsageError
from fiv_cli.fourier import short_time
from fiv_cli.plots import labels, motion, points, spectrum, style
from fiv_cli.plots import map as map_
from fiv_cli.reading import sampling
from fiv_cli.reading.datasets import numbers

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure

VARIABLE = "spectrogram"
WINDOWS = 24.0  # of a history, where the figure gives no resolution
HOPS = 8  # windows that begin within the length of one
LINES = 2.0  # half the width of the lobe of a sinusoid under Hann's window, in its lines


@dataclass(frozen=True)
class Panel:
    """What one panel shows: `amplitude` has the shape (time, frequency)."""

    label: str
    time: np.ndarray
    frequency: np.ndarray
    amplitude: np.ndarray


def suits(dataset: xr.Dataset) -> bool:
    """Whether the dataset holds spectrograms, or motions in time."""
    return VARIABLE in dataset or motion.suits(dataset)


def draw(layers: Sequence[points.Layer], settings: points.Settings) -> Figure:
    """A panel for each start and each point, or for each variable of each motion."""
    dataset = layers[0].dataset
    panels, what = _stored(dataset) if VARIABLE in dataset else _of_motions(dataset, settings)
    figure, axes, columns = style.grid_of_panels(
        len(panels), map_.MOST_COLUMNS, points.title(dataset), sharex=True, sharey=True
    )
    highest = 0.0
    norm = spectrum.norm_of(np.concatenate([panel.amplitude.ravel() for panel in panels]))
    for number, (ax, panel) in enumerate(zip(axes, panels, strict=False)):
        spectrum.paint(ax, panel.time, panel.frequency, panel.amplitude.T, norm, settings)
        ax.set_title(panel.label)
        ax.set_xlabel(labels.axis_label(dataset["time"], "t"))
        ax.set_ylabel(spectrum.frequency_label(settings) if number % columns == 0 else "")
        points.scale(ax, settings)
        if "ylim" not in settings and VARIABLE not in dataset:
            seen = panel.frequency[(panel.amplitude > (norm.vmin or 0.0)).any(axis=0)]
            highest = max(highest, spectrum.factor_of(settings) * seen.max(initial=0.0))
    if highest > 0.0 and axes[0].get_yscale() == "linear":
        axes[0].set_ylim(0.0, spectrum.MARGIN * highest)  # of all panels
    figure.colorbar(axes[0].collections[0], ax=axes, label=what, extend="min")
    return figure


def _stored(dataset: xr.Dataset) -> tuple[list[Panel], str]:
    """The spectrograms of a dataset."""
    array = numbers(dataset[VARIABLE])
    points.refuse_empty(dataset, bool(array.notnull().any()), VARIABLE)
    spread = ["time", "frequency"]
    lines = points.lines(dataset, spread, [str(dim) for dim in array.dims])
    map_.refuse_many(lines, array, spread)
    time, frequency = dataset["time"].values, dataset["frequency"].values
    panels = [
        Panel(line.label, time, frequency, array.isel(line.index).transpose(*spread).values)
        for line in lines
    ]
    return panels, labels.axis_label(dataset[VARIABLE])


def _of_motions(dataset: xr.Dataset, settings: points.Settings) -> tuple[list[Panel], str]:
    """Spectrograms of the samples of histories."""
    motion.refuse_without(dataset)
    name = points.one_variable(settings, sampling.displacements(dataset)[0])
    motion.known_variable(dataset, name)
    panels = [
        _transformed(one, name, curve, label, settings)
        for one in motion.motions(dataset, settings)
        for label, curve in _curves(one, name, settings)
    ]
    if len(panels) > map_.MOST_PANELS:
        raise UsageError(
            f"{len(panels)} panels in one figure are too many\n"
            "choose a motion with `select` in the figure, or give the history fewer points"
        )
    return panels, f"amplitude of {motion.label_of(dataset[name], settings)}"


def _curves(
    one: motion.Motion, name: str, settings: points.Settings
) -> list[tuple[str, np.ndarray]]:
    """The curves of a variable: one, or one for each point of the disc."""
    values = motion.of_contact(one.data[name], settings)
    if "point" not in one.data[name].dims:
        return [("", values)]
    return list(zip(motion.places(one), values, strict=True))


def _transformed(
    one: motion.Motion, name: str, curve: np.ndarray, label: str, settings: points.Settings
) -> Panel:
    time, values = spectrum.uniform(one.time, curve)
    length = time[-1] - time[0]
    window = length / WINDOWS
    if "resolution" in settings:
        window = LINES / points.in_si(settings["resolution"])
    try:
        windows = short_time(values, length / (time.size - 1), window, window / HOPS)
    except ValueError as error:
        raise UsageError(
            f"{name}: {error}\nrun the history with a smaller `sample`, or give the figure another "
            "`resolution` (Hz)"
        ) from error
    words = points.joined(one.label, label)
    return Panel(words, time[0] + windows.time, windows.frequency, windows.amplitude)
