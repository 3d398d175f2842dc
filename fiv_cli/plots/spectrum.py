"""Amplitude spectrum of a motion: a windowed discrete Fourier transform of its samples."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from fiv_cli.errors import UsageError
from fiv_cli.plots import labels, motion, points, style

if TYPE_CHECKING:
    from matplotlib.figure import Figure

suits = motion.suits
WINDOW = "hann"
# Samples count as uniform when their intervals agree to this share.
UNIFORM = 1e-6
FEWEST_SAMPLES = 16


def draw(layers: Sequence[points.Layer], settings: Mapping[str, Any]) -> Figure:
    """A line for each variable of each motion; the mean is taken off before."""
    dataset = layers[0].dataset
    figure, (ax,) = style.new_panels(1, 1, points.title(dataset))
    unit = str(settings.get("unit", "Hz"))
    names = motion.variables(dataset, settings)
    shown = [(one, name) for one in motion.motions(dataset, settings) for name in names]
    for (one, name), colour in zip(shown, style.line_colours(len(shown)), strict=True):
        values = motion.of_contact(one.data[name], settings)
        frequency, height = amplitude_spectrum(one.time, values)
        factor = 2.0 * np.pi if unit == "rad/s" else 1.0
        label = points.joined(one.label, labels.short_label(dataset[name]))
        ax.plot(frequency * factor, height, color=colour, label=label, lw=0.9)
    letter = r"\omega" if unit == "rad/s" else "f"
    ax.set_xlabel(f"${letter}$ ({unit})")
    ax.set_ylabel(
        "amplitude" + (f" of {labels.short_label(dataset[names[0]])}" * (len(names) == 1))
    )
    ax.margins(x=0)
    points.scale(ax, settings)
    points.legend(ax)
    return figure


def amplitude_spectrum(time: np.ndarray, values: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Frequencies and amplitudes of a sampled motion.

    Parameters
    ----------
    time : s, shape (n,), uniform but for the last interval, which may be shorter
    values : shape (n,)

    Returns
    -------
    frequency : Hz, shape (n // 2 + 1,)
    amplitude : unit of `values`; a sine of amplitude A that fits the record shows A

    Raises
    ------
    UsageError : the samples are too few, or not uniform
    """
    from scipy import fft, signal

    time, values = _uniform(time, values)
    window = signal.get_window(WINDOW, values.size)
    spectrum = fft.rfft((values - values.mean()) * window)
    interval = (time[-1] - time[0]) / (time.size - 1)
    return fft.rfftfreq(values.size, interval), 2.0 * np.abs(spectrum) / window.sum()


def _uniform(time: np.ndarray, values: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The samples at equal intervals: the end of a motion may lie off the raster."""
    steps = np.diff(time)
    if time.size >= FEWEST_SAMPLES and abs(steps[-1] - steps[0]) > UNIFORM * steps[0]:
        time, values, steps = time[:-1], values[:-1], steps[:-1]
    if time.size < FEWEST_SAMPLES or np.ptp(steps) > UNIFORM * steps.mean():
        raise UsageError(
            f"a spectrum needs {FEWEST_SAMPLES} samples or more, at equal intervals\n"
            "run the history with a smaller `sample`"
        )
    return time, values
