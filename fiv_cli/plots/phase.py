"""Phase portrait: one state against another, coloured by the state of the contact."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.collections import LineCollection
from matplotlib.lines import Line2D
from matplotlib.ticker import MaxNLocator

from fiv_cli.plots import labels, motion, points, style

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

suits = motion.suits


def draw(layers: Sequence[points.Layer], settings: points.Settings) -> Figure:
    """A panel for each motion, or one for all (``overlay``); a circle marks each start."""
    dataset = layers[0].dataset
    motions = motion.motions(dataset, settings)
    names = _states(dataset, settings)
    shared = bool(settings.get("overlay"))
    figure, axes = style.new_panels(1, 1 if shared else len(motions), points.title(dataset))
    for number, one in enumerate(motions):
        _panel(axes[0 if shared else number], one, names, settings)
    for ax, one in zip(axes, motions, strict=False):
        ax.set_title("" if shared else one.label)
        ax.set_xlabel(labels.short_label(dataset[names[0]]))
    axes[0].set_ylabel(labels.short_label(dataset[names[1]]))
    _legend(figure, motion.states_present(motions, settings), _shows_starts(settings))
    return figure


def _shows_starts(settings: points.Settings) -> bool:
    """A window of time may begin anywhere: its first sample is no start."""
    return "window" not in settings


def _states(dataset: xr.Dataset, settings: points.Settings) -> tuple[str, str]:
    """x and y: as the figure says, else the first displacement and its velocity."""
    x = str(settings.get("x", motion.variables(dataset, settings)[0]))
    y = str(settings.get("y", f"{x}_dot"))
    return motion.known_variable(dataset, x), motion.known_variable(dataset, y)


def _panel(ax: Axes, one: motion.Motion, names: tuple[str, str], settings: points.Settings) -> None:
    x, y = (motion.of_contact(one.data[name], settings) for name in names)
    path = np.column_stack([x, y])
    stretches: dict[str, list[np.ndarray]] = {}
    for state, first, last in _joined_runs(list(motion.contact_runs(one, settings))):
        stretches.setdefault(state, []).append(path[first:last])
    many = one.time.size > style.MANY_MARKS
    for state, pieces in stretches.items():
        ax.add_collection(
            LineCollection(
                pieces, colors=style.CLASSES[state], lw=1.0, label=state,
                rasterized=many,
            )
        )  # fmt: skip
    if _shows_starts(settings):
        ax.plot(x[:1], y[:1], "o", ms=5, mfc="none", color=style.BLACK)
    ax.autoscale_view()
    ax.xaxis.set_major_locator(MaxNLocator(5))
    points.scale(ax, settings)


def _joined_runs(runs: list[tuple[str, int, int]]) -> Iterator[tuple[str, int, int]]:
    """The runs, each prolonged so that they meet.

    The step from one run to the next goes to the one that slips, for what sticks moves straight
    on at constant velocity; between two that slip it goes to the first.
    """
    states = [None, *(state for state, _, _ in runs), None]
    for number, (state, first, last) in enumerate(runs, start=1):
        before, after = states[number - 1], states[number + 1]
        takes_before = before == "stick" != state
        takes_after = after is not None and not (state == "stick" != after)
        yield state, first - takes_before, last + takes_after


def _legend(figure: Figure, states: Sequence[str], with_start: bool) -> None:
    handles = [Line2D([], [], color=style.CLASSES[state], label=state) for state in states]
    start = Line2D([], [], color=style.BLACK, marker="o", mfc="none", ls="none", label="start")
    handles += [start] * with_start
    figure.legend(handles=handles, loc="outside lower center", ncols=len(handles))
