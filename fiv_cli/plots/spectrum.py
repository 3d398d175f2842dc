"""Amplitudes over frequency: of steady states along a parameter, of one, or of a motion in time.

Along a parameter the colour is the amplitude and dark dots are the unstable eigenfrequencies of
the linearised system (thesis Figure 6.18). Of a motion in time it is a windowed discrete Fourier
transform of its samples.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING, Any, TypeAlias

import matplotlib as mpl
import numpy as np
from matplotlib.colors import LogNorm
from matplotlib.transforms import ScaledTranslation

from fiv_cli.errors import UsageError
from fiv_cli.flags import ENDED_EARLY
from fiv_cli.plots import labels, levels, motion, points, style
from fiv_cli.plots import map as map_
from fiv_cli.plots.drawn import leave_out
from fiv_cli.reading import select
from fiv_cli.reading.datasets import is_class, numbers
from fiv_cli.reading.sampling import displacements

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.artist import Artist
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from matplotlib.text import Annotation

    _Shape: TypeAlias = tuple[np.ndarray, np.ndarray]  # frequencies, amplitudes

FREQUENCIES = {"Hz": ("f", "Hz"), "rad/s": (r"\omega", "rad/s")}  # symbol, unit
STEADY, GROWING = "amplitude", "unstable_frequency"
WINDOW = "hann"
# Samples count as uniform when their intervals agree to this share.
UNIFORM = 1e-6
FEWEST_SAMPLES = 16
CLOSED = 1e-6  # share of its extent within which a motion that ends where it began has closed
MARGIN = 1.05  # of the highest frequency that is shown
LOG_DECADES, LINEAR_DECADES = 6.0, 1.7  # of amplitude on an axis of them, and on a plain one
WORTH_DECADES = 3.0  # of amplitude beyond which nothing is told to be left out
NO_JUMPS = np.zeros(0), np.zeros(0)
UPRIGHT = 0.8  # pt
ASIDE, MOST_ASIDE = 1.5, 8.0  # widths from one line of a frequency to the next, and of all
TALL = 1e-2  # of the greatest amplitude: what has less is not looked at
SEEN = 0.1  # share of a frequency by which a line that stands beside it is seen to
FEW = 3  # spectra that are lines, though a parameter varies
DECADES = 3.0  # of amplitude in a colour scale; what is less has its lowest colour


def suits(dataset: xr.Dataset) -> bool:
    """Whether the dataset holds spectra of steady states, or motions in time."""
    return STEADY in dataset or motion.suits(dataset)


def draw(layers: Sequence[points.Layer], settings: points.Settings) -> Figure:
    """Colours along a parameter, lines where none varies or of a few points."""
    dataset = layers[0].dataset
    if STEADY not in dataset:
        return _draw_motions(dataset, settings)
    points.refuse_empty(dataset, bool(dataset[STEADY].notnull().any()), STEADY)
    many = "x" in settings or dataset["status"].size > FEW
    if many and any(select.is_numeric(axis) for axis in points.varying_axes(dataset)):
        return _draw_along(dataset, settings)
    return _draw_steady(dataset, settings)


# --- steady states along a parameter --------------------------------------------------------------
def _draw_along(dataset: xr.Dataset, settings: points.Settings) -> Figure:
    """A panel for each start and each value of the other axes."""
    axis = points.abscissa(dataset, settings)
    array = numbers(dataset[STEADY])
    spread = [str(axis.dims[0]), "frequency"]
    panels = points.lines(dataset, spread, [str(dim) for dim in array.dims])
    map_.refuse_many(panels, array, spread)
    figure, axes, columns = style.grid_of_panels(
        len(panels), map_.MOST_COLUMNS, points.title(dataset), sharex=True, sharey=True
    )
    norm, x, frequency = norm_of(array.values), points.positions(axis), dataset["frequency"].values
    for number, (ax, panel) in enumerate(zip(axes, panels, strict=False)):
        part = dataset.isel(panel.index)
        plane = part[STEADY].transpose("frequency", spread[0]).values
        paint(ax, x, frequency, plane, norm, settings)
        if GROWING in part:
            _mark_growing(ax, part[GROWING].transpose(spread[0], "mode"), x, settings)
        ax.set_title(panel.label)
        points.dress_axis(ax, axis, "x")
        ax.set_ylabel(frequency_label(settings) if number % columns == 0 else "")
        points.scale(ax, settings)
        if "ylim" not in settings:
            ax.set_ylim(
                0.0 if ax.get_yscale() == "linear" else None, factor_of(settings) * frequency[-1]
            )
    figure.colorbar(
        axes[0].collections[0], ax=axes, label=labels.axis_label(dataset[STEADY]), extend="min"
    )
    _explain(figure, dataset)
    return figure


def norm_of(values: np.ndarray) -> LogNorm:
    """Colours over the `DECADES` below the largest amplitude."""
    known = values[np.isfinite(values) & (values > 0.0)]
    top = float(known.max()) if known.size else 1.0
    return LogNorm(top / 10.0**DECADES, top, clip=True)


def paint(
    ax: Axes,
    x: np.ndarray,
    frequency: np.ndarray,
    amplitudes: np.ndarray,
    norm: LogNorm,
    settings: points.Settings,
) -> None:
    """Amplitudes in colours, shape (frequency, x); hatched where there are none."""
    shown = np.where(np.isfinite(amplitudes), np.maximum(amplitudes, norm.vmin or 0.0), np.nan)
    height = frequency * factor_of(settings)
    ax.pcolormesh(x, height, shown, shading="nearest", cmap="YlOrRd", norm=norm, rasterized=True)
    map_.hatch(ax, np.isnan(shown))
    ax.grid(False)


def _mark_growing(ax: Axes, modes: xr.DataArray, x: np.ndarray, settings: points.Settings) -> None:
    """Dots where an eigenvalue grows; `modes` over x and the modes."""
    size = style.dot_size(x.size)
    height = modes.values * factor_of(settings)
    ax.plot(x, height, "o", ms=size, mew=0, color=style.BLACK, zorder=4)


def _explain(figure: Figure, dataset: xr.Dataset) -> None:
    """What dots and hatching mean."""
    handles: list[Artist] = []
    if GROWING in dataset and bool(dataset[GROWING].notnull().any()):
        (dot,) = figure.axes[0].plot([], [], "o", ms=3.5, mew=0, color=style.BLACK)
        dot.set_label("unstable eigenfrequency")
        handles.append(dot)
    known = dataset[STEADY].notnull().all("frequency")
    missing = _unbounded(dataset) or map_.why_missing(dataset, known)
    if handles or missing:
        map_.legend_below(figure, handles, missing)


def _unbounded(dataset: xr.Dataset) -> str:
    """The classes of motion without a spectrum that the dataset holds."""
    names = [n for n in ENDED_EARLY if bool(is_class(dataset["attractor"], (n,)).any())]
    return points.joined(*(name.replace("_", " ") for name in names))


# --- one steady state -----------------------------------------------------------------------------
def _draw_steady(dataset: xr.Dataset, settings: points.Settings) -> Figure:
    """Each motion in its colour; unstable eigenfrequencies upright and dashed."""
    figure, (ax,) = style.new_panels(1, 1, points.title(dataset))
    array = numbers(dataset[STEADY])
    lines = points.lines(dataset, ["frequency"], [str(dim) for dim in array.dims])
    colours = style.line_colours(len(lines))
    ax.set_xlim(0.0, dataset["frequency"].values[-1] * factor_of(settings))
    points.scale(ax, settings)  # before the lines are drawn: the foot of an upright is no value
    written: Annotation | None = None
    spectra = [_shape(dataset.isel(line.index), settings) for line in lines]
    for number, (line, colour) in enumerate(zip(lines, colours, strict=True)):
        x, height = spectra[number]
        place, words = _fundamental(dataset.isel(line.index), (x, height), settings)
        label = points.joined(line.label, words) if len(lines) > 1 else line.label
        _plot_among(ax, number, spectra, color=colour, label=label)
        if words and len(lines) == 1:  # words of several would lie on one another
            written = ax.annotate(
                words, (x[place], height[place]), (0.0, 2.0), textcoords="offset points",
                color=colour, fontsize=mpl.rcParams["legend.fontsize"], path_effects=levels.HALO,
            )  # fmt: skip
    growing = np.unique(dataset[GROWING].values) if GROWING in dataset else np.zeros(0)
    for number, frequency in enumerate(growing[np.isfinite(growing)] * factor_of(settings)):
        label = points.unlisted("unstable eigenfrequency") if number else "unstable eigenfrequency"
        ax.axvline(frequency, ls="--", lw=0.9, color=style.BLACK, label=label, zorder=1)
    ax.set_xlabel(frequency_label(settings))
    ax.set_ylabel(labels.axis_label(dataset[STEADY]))
    points.legend([ax])
    style.add_notes(figure, [*_moved(ax, spectra)])
    if written and "ylim" not in settings:
        _make_room_for(ax, written)
    return figure


def _make_room_for(ax: Axes, written: Annotation) -> None:
    """Let the ordinate reach over words that stand at a point of a line."""
    style.lay_out(ax.figure.figure)  # panels and words have their sizes then
    foot, top = ax.bbox.y0, ax.bbox.y1
    point = ax.transData.transform(written.xy)[1]
    higher = (point - foot) / (top - foot - (written.get_window_extent().y1 - point))
    if higher > 1.0:
        reach = ax.transData.inverted().transform((0.0, foot + higher * (top - foot)))[1]
        ax.set_ylim(top=float(reach))


def _fundamental(
    one: xr.Dataset, drawn: tuple[np.ndarray, np.ndarray], settings: points.Settings
) -> tuple[int, str]:
    """Which point of a line stands for the frequency of a period, and this; "" where none does."""
    basic = factor_of(settings) / one["period"].item() if "period" in one else np.nan
    known = np.isnan(drawn[1]).any()  # else no harmonic stands where it is
    for place in np.flatnonzero(np.isclose(drawn[0], basic) & (drawn[1] > 0.0) & known)[:1]:
        symbol, unit = FREQUENCIES[settings.get("unit") or "Hz"]
        return int(place), f"${symbol}_1$ = {labels.number_text(float(f'{basic:.4g}'))} {unit}"
    return 0, ""


def _shape(motion: xr.Dataset, settings: points.Settings) -> tuple[np.ndarray, np.ndarray]:
    """The line of one spectrum: upright at each harmonic of a period, else through all intervals.

    Amplitudes are kept for intervals of frequency; where a period tells each apart, a harmonic
    stands where it is and not in the middle of its interval.
    """
    frequency, height = motion["frequency"].values, motion[STEADY].values
    basic = 1.0 / motion["period"].item() if "period" in motion else np.nan
    if not basic >= frequency[1] - frequency[0]:
        return frequency * factor_of(settings), height
    kept = np.flatnonzero(height > 0.0)
    harmonics = np.round(frequency[kept] / basic) * basic * factor_of(settings)
    return upright(harmonics, height[kept])


def _plot_among(ax: Axes, number: int, spectra: Sequence[_Shape], **look: Any) -> None:
    """One of some spectra, which is seen: upright lines beside others, else one behind them."""
    (x, height), count = spectra[number], len(spectra)
    of_lines = _of_lines(spectra)
    width = UPRIGHT * (1 if number in of_lines else 1 + (count - 1 - number) / count)
    (line,) = ax.plot(x, height, lw=width, solid_capstyle="butt", **look)
    if number in of_lines:
        leave_out(line, np.column_stack([x, 0.0 * x]))  # their feet
        # they are moved when the panel has its limits, which are those of values
        place = of_lines.index(number) - 0.5 * (len(of_lines) - 1)
        scale = ax.figure.dpi_scale_trans
        aside = ScaledTranslation(place * _step(len(of_lines)), 0.0, scale)
        line.set_transform(ax.transData + aside)


def _of_lines(spectra: Sequence[_Shape]) -> list[int]:
    """Which of some spectra are upright lines."""
    return [n for n, (_, y) in enumerate(spectra) if np.isnan(y).any() and (y > 0.0).any()]


def _step(count: int) -> float:
    """How far, in inches, upright lines of so many spectra stand beside one another."""
    return min(ASIDE, MOST_ASIDE / count) * UPRIGHT * style.weight() / style.POINTS


def _moved(ax: Axes, spectra: Sequence[_Shape]) -> Iterator[str]:
    """What to do where lines stand beside their frequency by a good part of the first of these."""
    uprights = [spectra[number] for number in _of_lines(spectra)]
    count = len(uprights)
    if count < 2 or ax.get_xscale() == "log":
        return
    first = min(x[y > TALL * np.nanmax(y)].min(initial=np.inf) for x, y in uprights)
    low, high = ax.get_xlim()
    wide = (high - low) / (style.ACROSS * ax.figure.figure.get_figwidth())
    off = 0.5 * (count - 1) * _step(count) * wide
    if off > SEEN * first:
        yield (
            f"lines of {count} spectra stand side by side, here up to {off:.1g} beside their "
            "frequency; where they are: a narrower xlim, or one alone (variable, select)"
        )


def upright(frequency: np.ndarray, height: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """A line from zero to each height, as one line with gaps."""
    feet, gaps = np.zeros(height.size), np.full(height.size, np.nan)
    return np.repeat(frequency, 3), np.stack([feet, height, gaps], axis=1).ravel()


def factor_of(settings: points.Settings) -> float:
    """From Hz to the unit of the figure."""
    return 2.0 * np.pi if settings.get("unit") == "rad/s" else 1.0


def frequency_label(settings: points.Settings) -> str:
    """What stands at an axis of frequencies."""
    symbol, unit = FREQUENCIES[settings.get("unit") or "Hz"]
    return f"${symbol}$ ({unit})"


# --- a motion in time -----------------------------------------------------------------------------
def _draw_motions(dataset: xr.Dataset, settings: points.Settings) -> Figure:
    """A panel for each unit, with a line for each of its variables of each motion; the mean is
    taken off before.

    Of a motion over whole periods, upright lines at their harmonics.
    """
    units: dict[str, list[str]] = {}
    for name in motion.variables(dataset, settings):
        units.setdefault(str(dataset[name].attrs.get("units", "1")), []).append(name)
    every = motion.motions(dataset, settings)
    shown = [[(one, name) for one in every for name in names] for names in units.values()]
    spectra = [[_spectrum_of(*pair, settings) for pair in own] for own in shown]
    figure, axes = style.new_panels(len(units), 1, points.title(dataset), sharex=True)
    own_settings = [points.of_panel(settings, n, own) for n, own in enumerate(units.values())]
    decades = LOG_DECADES if points.is_logarithmic(settings, "y") else LINEAR_DECADES
    highest = max(_highest(own, decades) for own in spectra)
    for ax, own, of_panel in zip(axes, spectra, own_settings, strict=True):
        _frame(ax, own, of_panel, highest)
    for ax, pairs, own, names in zip(axes, shown, spectra, units.values(), strict=True):
        _draw_spectra(ax, dataset, pairs, own, names, settings)
    axes[-1].set_xlabel(frequency_label(settings))
    points.legend(axes)
    moved = [note for ax, own in zip(axes, spectra, strict=True) for note in _moved(ax, own)]
    cut = _cut(highest, max(_highest(own, WORTH_DECADES) for own in spectra), decades, settings)
    style.add_notes(figure, [*moved, *cut])
    if any(len(_of_lines(own)) > 1 for own in spectra):
        style.add_to_caption(figure, "lines of one frequency stand side by side")
    return figure


def _cut(highest: float, last: float, decades: float, settings: points.Settings) -> Iterator[str]:
    """That a spectrum goes on beyond the frequency to which it is shown."""
    whole = "xlim" in settings or points.is_logarithmic(settings, "x")
    if not whole and 0.0 < MARGIN * highest < last:
        unit = FREQUENCIES[settings.get("unit") or "Hz"][1]
        yield (
            f"beyond {highest:.3g} {unit} no amplitude is over {10.0**-decades:.1g} of the "
            "greatest; "
            'xlim, or log = "y", in a [[figure]] shows them'
        )


def _draw_spectra(
    ax: Axes,
    dataset: xr.Dataset,
    shown: Sequence[tuple[motion.Motion, str]],
    spectra: Sequence[_Shape],
    names: Sequence[str],
    settings: points.Settings,
) -> None:
    """The lines of one panel, and what its ordinate is called."""
    for number, (one, name) in enumerate(shown):
        label = points.joined(one.label, motion.label_of(dataset[name], settings))
        label = label if len(shown) > 1 else points.unlisted(label)  # at its ordinate
        colour = style.line_colours(len(shown))[number]
        _plot_among(ax, number, spectra, color=colour, label=label)
    unit = labels.unit_text(str(dataset[names[0]].attrs.get("units", "1")))
    several = f" ({unit})" if unit else ""
    alone = f" of {motion.label_of(dataset[names[0]], settings)}"
    ax.set_ylabel(f"amplitude{alone if len(names) == 1 else several}")


def _spectrum_of(
    one: motion.Motion, name: str, settings: points.Settings
) -> tuple[np.ndarray, np.ndarray]:
    """Frequencies, in the unit of the figure, and amplitudes."""
    values, whole = motion.of_contact(one.data[name], settings), _is_closed(one)
    jumps = (one.instants - one.time[0], one.jumps(name, values)) if whole else NO_JUMPS
    frequency, height = amplitude_spectrum(one.time, values, whole, jumps)
    frequency = frequency * factor_of(settings)
    return upright(frequency[1:], height[1:]) if whole else (frequency, height)


def _is_closed(one: motion.Motion) -> bool:
    """Whether a motion ends, on the raster, in the state that it began in: after whole periods."""
    steps = np.diff(one.time)
    if steps.size < FEWEST_SAMPLES or np.ptp(steps) > UNIFORM * steps.mean():
        return False
    states = [one.data[f"{n}{of}"].values for n in displacements(one.data) for of in ("", "_dot")]
    return all(abs(x[-1] - x[0]) <= CLOSED * np.ptp(x) for x in states)


def _frame(
    ax: Axes,
    spectra: Sequence[_Shape],
    settings: points.Settings,
    highest: float,
) -> None:
    """As the figure asks; else to the highest frequency, a logarithmic axis down to what is seen.

    It comes before what is drawn: the foot of an upright is no value.
    """
    if not points.is_logarithmic(settings, "x") and highest > 0.0:
        ax.set_xlim(0.0, MARGIN * highest)
    points.scale(ax, settings)
    top = max((height.max(initial=0.0) for _, height in _seen(spectra)), default=0.0)
    if points.is_logarithmic(settings, "y") and "ylim" not in settings and top > 0.0:
        (low, high), foot = ax.get_xlim(), top * 10.0**-LOG_DECADES
        within = (height[(low <= x) & (x <= high)] for x, height in _seen(spectra))
        least = min((one[one > foot].min(initial=top) for one in within), default=foot)
        ax.set_ylim(max(foot, 0.1 * least), 10.0 * top)


def _highest(spectra: Sequence[_Shape], decades: float) -> float:
    """The highest frequency at which an amplitude is seen beside the largest."""
    known = _seen(spectra)
    foot = max((height.max(initial=0.0) for _, height in known), default=0.0) * 10.0**-decades
    return float(max((x[height > foot].max(initial=0.0) for x, height in known), default=0.0))


def _seen(spectra: Sequence[_Shape]) -> list[tuple[np.ndarray, np.ndarray]]:
    """What is above zero."""
    return [(x[height > 0.0], height[height > 0.0]) for x, height in spectra]


def amplitude_spectrum(
    time: np.ndarray,
    values: np.ndarray,
    whole: bool = False,
    jumps: tuple[np.ndarray, np.ndarray] = NO_JUMPS,
) -> tuple[np.ndarray, np.ndarray]:
    """Frequencies and amplitudes of a sampled motion.

    Parameters
    ----------
    time : s, shape (n,), uniform but for the last interval, which may be shorter
    values : shape (n,)
    whole : the record is one of whole periods: it ends where it began, and needs no window
    jumps : of such a record, instants between samples, s from the first, and how far it jumps there

    Returns
    -------
    frequency : Hz, shape (n // 2 + 1,)
    amplitude : unit of `values`; a sine of amplitude A that fits the record shows A

    Raises
    ------
    UsageError : the samples are too few, or not uniform
    """
    from scipy import fft, signal

    time, values = uniform(time, values)
    if whole:
        time, values = time[:-1], values[:-1]
    window = signal.get_window("boxcar" if whole else WINDOW, values.size)
    interval = (time[-1] - time[0]) / (time.size - 1)
    teeth, of_teeth = _sawteeth(values.size, interval, *jumps)
    smooth = values - teeth
    spectrum = fft.rfft((smooth - smooth.mean()) * window) + of_teeth
    return fft.rfftfreq(values.size, interval), 2.0 * np.abs(spectrum) / window.sum()


def _sawteeth(
    count: int, interval: float, instants: np.ndarray, heights: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """What jumps and else falls evenly, of one period: its samples, and its own spectrum.

    Samples alone do not tell where between two of them it jumps.
    """
    phases = np.subtract.outer(np.arange(count), instants / interval) / count % 1.0
    harmonics = np.arange(1, 1 + count // 2)[:, None]
    turns = np.exp(-2j * np.pi * harmonics * instants / (count * interval))
    series = count * (turns @ heights) / (2j * np.pi * harmonics[:, 0])
    return (0.5 - phases) @ heights, np.append(0.0, series)


def uniform(time: np.ndarray, values: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
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
