"""States against time, the contact states shaded behind them."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import cycle
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.patches import Patch

from fiv_cli.plots import labels, legends, motion, points, style
from fiv_cli.plots.drawn import DECORATION
from fiv_cli.reading import sampling

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.artist import Artist
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

suits = motion.suits
# A bar at the top of a panel: however short a stick is, it is seen.
OTHER_STICKS: dict[str, Any] = {"fc": "#555555", "ec": "#555555", "lw": 0.5}
BAR = {"ymin": 0.965, "ymax": 1.0}
# A stretch that is narrower than this share of a motion has an edge: it would not be seen.
THIN, THIN_SHADE = 2e-3, {"lw": 0.6, "alpha": 0.6}
SHADES = {"slip+": 0.15, "slip-": 0.3, "stick": 0.4, "separation": 0.4}
LETTERS = 19  # for which a panel has room at least
COLUMNS = 600  # short times over which the range of many samples is drawn ...
FEWEST_IN_COLUMN = 8  # ... where there are as many
FLAT = 6.0  # times the extent of a motion that a range has which shows little of it
ALIKE = 0.02  # share of their time by which motions begin and end apart that have one axis of it


def draw(layers: Sequence[points.Layer], settings: points.Settings) -> Figure:
    """A row for each variable, of each contact that it has a value of; a column for each motion,
    of whichever file.

    Of motions that have no room side by side further ones stand below.
    """
    dataset = layers[0].dataset
    motions = motion.of_files(layers, settings)
    settings = motion.about_one_that_sticks(motions, settings)
    names, *_ = [motion.variables(one.dataset, settings) for one in layers]  # which all must have
    rows = [
        (name, points.of_panel(own, number, [name]))
        for number, name in enumerate(names)
        for own in motion.of_each_contact(dataset, name, settings)
    ]
    figure, axes = _draw_panels(dataset, motions, rows, names)
    every = [own for _, own in rows]
    of_each = all("contact" in dataset[name].dims for name in names)
    contact = motion.named_contact(dataset, *every, of_each=of_each)
    numbers = motion.others_sticking(motions, *every)
    others = [Patch(label=motion.sticking(number), **OTHER_STICKS) for number in numbers]
    what = "range of samples" if all(map(_is_dense, motions)) else "samples"
    told = [*others, *motion.ends(motions), *motion.sampled(motions, names, what)]
    _legend(figure, axes, motion.states_present(motions, *every), told, contact)
    style.add_notes(figure, [*motion.without_colours(dataset, settings, every)])
    for assumed in motion.of_joint_stick(motions, names):
        style.tell(figure, assumed)
    return figure


def _draw_panels(
    dataset: xr.Dataset,
    motions: Sequence[motion.Motion],
    rows: Sequence[tuple[str, points.Settings]],
    names: Sequence[str],
) -> tuple[Figure, list[Axes]]:
    """Blocks of a column for each motion, as many as stand side by side, and of all rows."""
    columns = style.side_by_side(len(motions), motion.MOST_MOTIONS, LETTERS)
    blocks = -(-len(motions) // columns)
    figure, axes = style.new_panels(
        blocks * len(rows), columns, points.title(dataset), sharex=_with_one_time(motions, blocks)
    )
    for number, ax in enumerate(axes):
        below, column = divmod(number, columns)
        block, row = divmod(below, len(rows))
        place, (name, own) = block * columns + column, rows[row]
        if place >= len(motions):
            ax.set_axis_off()
            continue
        _panel(ax, motions[place], name, own, coarse=motions[place].is_coarse(*names))
        if row == 0:
            ax.set_title(motions[place].label)
        if column == 0:
            ax.set_ylabel(motion.label_of(dataset[name], own))
        if row == len(rows) - 1:
            ax.set_xlabel(labels.axis_label(dataset["time"], "t"))
    of_rows = [
        [ax for n, ax in enumerate(axes) if n // columns % len(rows) == row]
        for row in range(len(rows))
    ]
    for name in names:  # of each of its contacts, too
        _share_heights(
            name, [of for of, (one, _) in zip(of_rows, rows, strict=True) if one == name]
        )
    return figure, axes


def _with_one_time(motions: Sequence[motion.Motion], blocks: int) -> Any:
    """Which panels have one axis of time: all, where motions are about as long, else a column."""
    if blocks > 1:
        return False
    first, last = np.transpose([one.time[[0, -1]] for one in motions if one.time.size])
    apart = max(np.ptp(first), np.ptp(last))
    return "all" if apart <= ALIKE * (last.max() - first.min()) else "col"


def _share_heights(name: str, rows: Sequence[Sequence[Axes]]) -> None:
    """Let panels of one variable have one range of it, of each contact at least, or say that some
    would be flat there."""
    axes = [ax for row in rows for ax in row]
    extents = [
        np.ptp(ax.dataLim.intervaly) for ax in axes if np.isfinite(ax.dataLim.intervaly).all()
    ]
    low, high = np.transpose([ax.get_ylim() for ax in axes if ax.axison])
    if extents and high.max() - low.min() <= FLAT * min(extents):
        for ax in axes:
            ax.set_ylim(low.min(), high.max())
    elif np.ptp(low) == np.ptp(high) == 0.0:
        return
    elif len(rows) > 1:
        for row in rows:
            _share_heights(name, [row])
        _note_apart(axes[0], f"{name}: each contact has", low.min(), high.max())
    else:
        _note_apart(axes[0], f"{axes[0].get_ylabel()}: each panel has", low.min(), high.max())


def _note_apart(ax: Axes, told: str, low: float, high: float) -> None:
    """That ranges differ, and how they would not."""
    both = f"ylim = [{low:.3g}, {high:.3g}] in the figure is one for all"
    note = f"{told} a range of its own, or some would be flat; {both}"
    style.add_notes(ax.figure.figure, [note])


def _panel(
    ax: Axes, one: motion.Motion, name: str, settings: points.Settings, *, coarse: bool
) -> None:
    for state, begin, end in motion.contact_spans(one, settings):
        thin = THIN_SHADE if end - begin < THIN * np.ptp(one.time) else {}
        ax.axvspan(begin, end, **_shade(state) | thin)
    for _, begin, end in motion.other_sticks(one, settings):
        ax.axvspan(begin, end, **BAR, **OTHER_STICKS)
    values, many = motion.of_contact(one.data[name], settings), one.time.size > style.MANY_MARKS
    if name.endswith("_dot") and sampling.is_at_rest(one.data):
        values = np.zeros_like(values)  # what it has is rounding
    if "point" in one.data[name].dims:
        for curve, label, color in zip(values, motion.places(one), cycle(style.LINES)):
            _curve(ax, one, name, curve, coarse, color=color, label=label, rasterized=many)
    else:
        told = points.unlisted(one.label, name)
        _curve(ax, one, name, values, coarse, color=style.BLACK, label=told, rasterized=many)
    ax.margins(x=0)
    style.level(ax)
    points.scale(ax, settings)
    for value in np.atleast_2d(values)[:, -1] if one.end else ():
        told = points.unlisted(one.label, one.end)
        ax.plot(one.time[-1], value, label=told, clip_on=False, **motion.END)


def _shade(state: str) -> dict[str, Any]:
    return {"color": style.CLASSES[state], "alpha": SHADES[state], "lw": 0, "snap": False}


def _curve(
    ax: Axes, one: motion.Motion, name: str, values: np.ndarray, coarse: bool, **look: Any
) -> None:
    """The curve through samples and events; where it would be invented, what the samples tell.

    That is their range over each of many short times, where many of them lie there.
    """
    if not coarse:
        ax.plot(one.drawn_time, one.drawn(name, values), lw=0.9, **look)
    elif not _is_dense(one):
        ax.plot(one.time, values, ".", ms=1.5, **look)
    else:
        ranges = [(t[t.size // 2], v.min(), v.max()) for t, v in _in_columns(one.time, values)]
        ax.vlines(*np.transpose(ranges), lw=0.8, capstyle="projecting", **look)
        middle, low, _ = np.transpose(ranges)  # a range of no height is a line of none
        ax.plot(middle, low, ".", ms=1.0, mew=0.0, **look | {"label": DECORATION})


def _is_dense(one: motion.Motion) -> bool:
    return one.time.size >= COLUMNS * FEWEST_IN_COLUMN


def _in_columns(time: np.ndarray, values: np.ndarray) -> Iterator[tuple[np.ndarray, np.ndarray]]:
    borders = np.linspace(time[0], time[-1], COLUMNS + 1)[1:-1]
    places = np.searchsorted(time, borders)
    pieces = zip(np.split(time, places), np.split(values, places), strict=True)
    return ((t, v) for t, v in pieces if t.size)


def _legend(
    figure: Figure,
    axes: Sequence[Axes],
    states: Sequence[str],
    others: Sequence[Artist],
    contact: str,
) -> None:
    """What the lines of points are, and the shades."""
    places, _ = legends.told_in(axes)
    handles = [
        Patch(
            color=style.CLASSES[state],
            alpha=SHADES[state],
            lw=0,
            label=motion.CONTACT_STATES[state],
        )
        for state in states
    ]
    legends.legend_below(figure, [*places, *handles, *others], contact)
