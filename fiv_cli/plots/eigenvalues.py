"""Complex eigenvalues against a parameter: growth rates above, frequencies below."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from itertools import combinations
from operator import itemgetter
from typing import TYPE_CHECKING, Any, TypeAlias

import matplotlib as mpl
import numpy as np
from scipy.ndimage import label

from fiv_cli.errors import UsageError
from fiv_cli.plots import labels, points, style
from fiv_cli.plots.diagram_lines import mark_critical
from fiv_cli.plots.drawn import DECORATION, in_one_line, leave_out
from fiv_cli.plots.mergers import mergers
from fiv_cli.reading import select

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from matplotlib.typing import ColorType

PARTS = ("eigenvalue_real", "mode_frequency")
MERGER = "#808080"  # darker than what lines of a grid and of zero are
NUMBERS = "modes that have merged have one frequency: their numbers tell them apart by growth alone"
MOST_NAMED = 6  # modes in a legend: of more some, for their colours are a ramp
# Mergers are interpolated between points of the grid: places that differ by less than this share of
# the step between these are one.
SAME = 0.01
MARKED = 40  # unstable points of a line that have a mark, about
# Of several lines of a mode what is unstable is a band beneath: their dashes are seen.
BAND: dict[str, Any] = {
    "color": "#F6C3A0", "lw": 4.0, "marker": "o", "ms": 4.0, "mew": 0.0, "zorder": 1.5,
    "solid_capstyle": "butt",
}  # fmt: skip
DOTS: dict[str, Any] = {
    "color": style.VERMILLION, "ls": "none", "marker": "o", "ms": 2.6, "mew": 0.0, "zorder": 4
}  # fmt: skip

# Of all that a panel shows: a distance of two lines that is not seen; at which shares of points.
UNSEEN, MOSTLY, PARTLY = 5e-3, 0.9, 0.2
CROSSING = 0.03  # of an axis: two lines that cross are one so far
WIDER = 2.2  # times as wide as others: what lies beneath another
_Drawn: TypeAlias = "tuple[np.ndarray, np.ndarray, ColorType]"


def suits(dataset: xr.Dataset) -> bool:
    """Whether the dataset holds eigenvalues along some axis."""
    return PARTS[0] in dataset and bool(points.varying_axes(dataset))


def draw(layers: Sequence[points.Layer], settings: points.Settings) -> Figure:
    """A colour for each mode, a dash for each value of the other axes; unstable points marked.

    Where two modes merge a grey line stands: dotted, or with the dash of what it is of. The legend
    names each once. Critical values of further datasets lie where growth is zero.

    Of a conjugate pair the eigenvalue with positive imaginary part is drawn.
    """
    (first, *others), dataset = layers, layers[0].dataset
    if PARTS[0] not in dataset:
        raise UsageError("no eigenvalues in this dataset\nadd an analysis of kind `eigenvalues`")
    points.refuse_empty(dataset, bool(dataset[PARTS[0]].notnull().any()), PARTS[0])
    axis = points.abscissa(dataset, settings)
    if settings.get("unit") == "rad/s":
        dataset = dataset.assign({PARTS[1]: _angular(dataset[PARTS[1]])})
    figure, axes = style.new_panels(2, 1, points.title(dataset), sharex=True)
    own = [points.of_panel(settings, number, [name]) for number, name in enumerate(PARTS)]
    for ax, name, of_panel in zip(axes, PARTS, own, strict=True):
        _panel(ax, dataset, name, axis)
        ax.set_ylabel(labels.axis_label(dataset[name]))
        points.scale(ax, of_panel)
        points.reach(ax, axis)
        _mark_mergers(ax, dataset, axis)
    if dataset.get("coupling_point", axis).attrs.get("along") == axis.name:
        style.add_notes(figure, [NUMBERS] * bool(dataset["coupling_point"].notnull().any()))
    axes[0].axhline(
        0.0, color=style.GREY, lw=0.8, zorder=1.8, label=DECORATION
    )  # under growth of 0
    for other in others:
        mark_critical(axes[0], other, [dataset], axis, colours_tell=False)
    points.dress_axis(axes[1], axis, "x")
    points.mark_gaps(axes, [first], own[-1])
    points.legend(axes)
    return figure


def _angular(frequency: xr.DataArray) -> xr.DataArray:
    """In rad/s."""
    attributes = {"long_name": "angular frequency of the mode", "units": "rad s-1"}
    return (2.0 * np.pi * frequency).assign_attrs(attributes)


def _panel(ax: Axes, dataset: xr.Dataset, name: str, axis: xr.DataArray) -> None:
    dim = str(axis.dims[0])
    x = points.positions(axis)
    modes = _modes(dataset)
    lines = points.lines(dataset, [dim], points.grid_dims(dataset))
    # the colour of unstable points is no mode's
    colours = [c for c in style.line_colours(len(modes) + 1) if c != style.VERMILLION]
    drawn: dict[str, ColorType] = {}
    of_modes: dict[str, list[tuple[str, np.ndarray]]] = {}
    look = BAND if len(lines) > 1 else DOTS
    for number, line in enumerate(lines):
        part, beneath = dataset.isel(line.index), list[_Drawn]()
        for (mode, name_of_mode), colour in zip(modes.items(), colours, strict=False):
            y, growth = (part[one].isel(mode=mode).values for one in (name, PARTS[0]))
            if not np.any(np.isfinite(y)):
                continue  # under other options the model has more modes
            dash = style.dash(number, len(lines))
            name_of_line = points.unlisted(name_of_mode, line.label)
            after, places, values = mergers(part, axis, mode)
            met = values.real if name == PARTS[0] else _frequencies(values, part[name])
            whole = np.insert(x, after, places), np.insert(y, after, met)
            (drawn_line,) = ax.plot(*whole, ls=dash, color=colour, label=name_of_line)
            leave_out(drawn_line, np.column_stack([places, met]))
            drawn |= {name_of_mode: colour}
            of_modes.setdefault(name_of_mode, []).append((line.label, y))
            if look is BAND:
                _mark_band(ax, *whole, np.insert(growth, after, values.real))
            else:
                _mark_points(ax, x, y, growth)
            _widen_beneath(ax, whole, dash, beneath, dataset[name])
            beneath.append((*whole, colour))
    style.add_notes(ax.figure.figure, [*_upon_one_another(dataset[name], of_modes)])
    for place in np.unique(np.linspace(0, len(drawn) - 1, MOST_NAMED).astype(int)):
        ax.plot([], [], "-", color=[*drawn.values()][place], label=[*drawn][place])
    for number, line in enumerate(lines if len(lines) > 1 else ()):
        dash = style.dash(number, len(lines))
        ax.plot([], [], ls=dash, color=style.BLACK, label=line.label)
    if np.any(dataset[PARTS[0]].values > 0.0):
        ax.plot([], [], label="unstable", **(look if look is DOTS else look | {"marker": "None"}))


def _widen_beneath(
    ax: Axes,
    line: tuple[np.ndarray, np.ndarray],
    dash: Any,
    beneath: Sequence[_Drawn],
    variable: xr.DataArray,
) -> None:
    """A wider line of the first mode that lies beneath another, as those that merged do: its colour
    is seen on both sides."""
    x, y = line
    for its_x, its_y, colour in beneath:
        order = np.argsort(its_x)
        near = np.abs(np.interp(x, its_x[order], its_y[order]) - y) <= _unseen(variable)
        hidden = _long(near, x)
        if hidden.any():
            look = {"lw": WIDER * mpl.rcParams["lines.linewidth"], "zorder": 1.9}
            shown = np.where(hidden, y, np.nan)
            ax.plot(x, shown, ls=_of_width(dash), color=colour, label=DECORATION, **look)
            return


def _long(near: np.ndarray, x: np.ndarray) -> np.ndarray:
    """What of the points at which two lines are near is a stretch of them, and no crossing."""
    groups, count = label(near)
    wide = [np.ptp(x[groups == one]) > CROSSING * np.ptp(x) for one in range(1, count + 1)]
    return np.append(False, wide)[groups]


def _of_width(dash: Any) -> Any:
    """Dashes of a wider line that are as long as those of the others."""
    if dash == "-":
        return dash
    named = {
        "--": mpl.rcParams["lines.dashed_pattern"],
        "-.": mpl.rcParams["lines.dashdot_pattern"],
    }
    pattern = named[dash] if isinstance(dash, str) else dash[1]
    return (0, [length / WIDER for length in pattern])


def _unseen(variable: xr.DataArray) -> float:
    """A distance of two lines of a variable that is not seen."""
    return UNSEEN * (float(variable.max()) - float(variable.min()))


def _upon_one_another(
    variable: xr.DataArray, of_modes: Mapping[str, Sequence[tuple[str, np.ndarray]]]
) -> Iterator[str]:
    """That lines of one mode are one nearly everywhere, or along a part, to what is seen: one hides
    the other."""
    least = _unseen(variable)
    shares = [
        (mode, one, other, np.mean((np.abs(y - its) <= least)[np.isfinite(y + its)]))
        for mode, lines in of_modes.items()
        for (one, y), (other, its) in combinations(lines, 2)
        if np.isfinite(y + its).sum() > 1
    ]
    pairs = [pair for pair in shares if pair[-1] >= PARTLY]
    if pairs:
        mode, one, other, share = max(pairs, key=itemgetter(-1))
        where = "nearly everywhere" if share >= MOSTLY else "along a part"
        more = f", and {len(pairs) - 1} more such pairs" if len(pairs) > 1 else ""
        yield (
            f"{variable.name}: {mode} is one line at {in_one_line(one)} and {in_one_line(other)}, "
            f"{where}{more}; select in the figure draws one of them alone"
        )


def _frequencies(values: np.ndarray, frequency: xr.DataArray) -> np.ndarray:
    """Those of eigenvalues, rad/s, in the unit of the others."""
    return np.abs(values.imag) / (2.0 * np.pi if frequency.attrs["units"] == "Hz" else 1.0)


def _up_to_turns(
    x: np.ndarray, y: np.ndarray, growth: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """A line with the places where its growth, straight between two points, is zero, and where of
    all of them it is unstable: there, too."""
    at = np.flatnonzero(growth[1:] * growth[:-1] < 0.0)
    share = growth[at] / (growth[at] - growth[at + 1])
    places, heights = (of[at] + share * (of[at + 1] - of[at]) for of in (x, y))
    whole = [np.insert(of, at + 1, own) for of, own in ((x, places), (y, heights))]
    begins = np.pad(growth > 0.0, 1)  # beside what is zero at a point
    unstable = (growth > 0.0) | ((growth == 0.0) & (begins[:-2] | begins[2:]))
    return whole[0], whole[1], np.insert(unstable, at + 1, True)


def _mark_points(ax: Axes, x: np.ndarray, y: np.ndarray, growth: np.ndarray) -> None:
    """Dots on some of the unstable points of a line."""
    marked = np.flatnonzero(growth > 0.0)[:: max(1, x.size // MARKED)]
    ax.plot(x[marked], y[marked], label=DECORATION, **DOTS)


def _mark_band(ax: Axes, x: np.ndarray, y: np.ndarray, growth: np.ndarray) -> None:
    """A band along what is unstable of a line."""
    x, y, unstable = _up_to_turns(x, y, growth)
    shown = np.where(unstable, y, np.nan)
    alone = np.flatnonzero(points.alone(np.isfinite(shown)))
    ax.plot(x, shown, markevery=alone.tolist(), label=DECORATION, **BAND)


def _mark_mergers(ax: Axes, dataset: xr.Dataset, axis: xr.DataArray) -> None:
    """A line across where two modes merge or part, found between the points along `axis`."""
    if dataset.get("coupling_point", axis).attrs.get("along") != axis.name:
        return
    lines = points.lines(dataset, [str(axis.dims[0])], points.grid_dims(dataset))
    x = np.sort(points.positions(axis))
    found = {one.label: _places(dataset["coupling_point"].isel(one.index), x) for one in lines}
    first, *others = found.values()
    alike = all(len(one) == len(first) and _same(one, first, x).all() for one in others)
    told = [("", found[lines[0].label])] if alike else found.items()
    for line, (whose, places) in enumerate(told):
        dash = ":" if alike else style.dash(line, len(lines))  # as the modes of that line
        for place in places:
            label = points.unlisted("modes merge", whose)
            ax.axvline(place, color=MERGER, ls=dash, lw=1.0, zorder=1, label=label)
    merging = [whose for whose, places in told if len(places)]
    if merging:
        ls, some = ":" if alike else "-", not alike and len(merging) < len(lines)
        whose = f": {points.BOTH.join(merging)}" if some else ""
        ax.plot([], [], color=MERGER, ls=ls, lw=1.0, label=f"modes merge{whose}")


def _places(merging: xr.DataArray, x: np.ndarray) -> np.ndarray:
    """Where modes merge, by rising value: two pairs that do so at one place have one line."""
    found = np.unique(merging.values[np.isfinite(merging.values)])
    return found[np.append(True, ~_same(found[1:], found[:-1], x))[: found.size]]


def _same(places: np.ndarray, others: np.ndarray, x: np.ndarray) -> np.ndarray:
    """Which of two rows of places are the same: the difference is told in steps of the grid."""
    steps = (np.interp(one, x, np.arange(float(x.size))) for one in (places, others))
    return np.abs(np.subtract(*steps)) <= SAME


def _modes(dataset: xr.Dataset) -> dict[int, str]:
    """Place -> name of the modes to draw: of a conjugate pair the one of positive frequency.

    They are counted from 1 where all are there; of a selection each is called as it was selected.
    """
    numbers = select.axis_of(dataset, "mode").values
    imaginary = dataset["eigenvalue_imag"].transpose(..., "mode").values.reshape(-1, numbers.size)
    twins = (imaginary < 0.0).any(axis=0) & ~(imaginary >= 0.0).any(axis=0)
    places = np.flatnonzero(~twins).tolist()
    if numbers.tolist() == list(range(numbers.size)):
        return {place: f"mode {count}" for count, place in enumerate(places, start=1)}
    return {place: f"mode = {numbers[place]}" for place in places}
