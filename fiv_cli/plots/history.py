"""States against time, the contact states shaded behind them."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from matplotlib.patches import Patch

from fiv_cli.plots import labels, motion, points, style

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

suits = motion.suits
OTHER_STICKS: dict[str, Any] = {"fill": False, "hatch": "//", "ec": style.GREY, "lw": 0.0}
SHADE = 0.35


def draw(layers: Sequence[points.Layer], settings: points.Settings) -> Figure:
    """A row for each variable, a column for each motion."""
    dataset = layers[0].dataset
    motions = motion.motions(dataset, settings)
    names = motion.variables(dataset, settings)
    figure, axes = style.new_panels(len(names), len(motions), points.title(dataset), sharex="col")
    for number, ax in enumerate(axes):
        row, column = divmod(number, len(motions))
        _panel(ax, motions[column], names[row], settings)
        if row == 0:
            ax.set_title(motions[column].label)
        if column == 0:
            ax.set_ylabel(labels.short_label(dataset[names[row]]))
        if row == len(names) - 1:
            ax.set_xlabel(labels.axis_label(dataset["time"], "t"))
    contact = motion.named_contact(dataset, settings)
    others = [
        Patch(label=words, **OTHER_STICKS) for words in motion.others_sticking(motions, settings)
    ]
    _legend(figure, axes, motion.states_present(motions, settings), others, contact)
    return figure


def _panel(ax: Axes, one: motion.Motion, name: str, settings: points.Settings) -> None:
    many = one.time.size > style.MANY_MARKS
    for state, begin, end in motion.contact_spans(one, settings):
        ax.axvspan(begin, end, color=style.CLASSES[state], alpha=SHADE, lw=0)
    for _, begin, end in motion.other_sticks(one, settings):
        ax.axvspan(begin, end, **OTHER_STICKS)
    values = motion.of_contact(one.data[name], settings)
    if "point" in one.data[name].dims:
        for curve, label in zip(values, motion.places(one), strict=True):
            ax.plot(one.drawn_time, one.drawn(name, curve), lw=0.9, rasterized=many, label=label)
    else:
        shown, told = one.drawn(name, values), points.unlisted(one.label, name)
        ax.plot(one.drawn_time, shown, color=style.BLACK, lw=0.9, rasterized=many, label=told)
    ax.margins(x=0)
    style.level(ax)
    points.scale(ax, settings)


def _legend(
    figure: Figure,
    axes: Sequence[Axes],
    states: Sequence[str],
    others: Sequence[Patch],
    contact: str,
) -> None:
    """What the lines of points are, and the shades."""
    places, _ = style.told_in(axes)
    handles = [
        Patch(color=style.CLASSES[state], alpha=SHADE, lw=0, label=motion.CONTACT_STATES[state])
        for state in states
    ]
    style.legend_below(figure, [*places, *handles, *others], contact)
