"""Phase portrait: one state against another, coloured by the state of the contact."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any

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


def draw(layers: Sequence[points.Layer], settings: Mapping[str, Any]) -> Figure:
    """A panel for each motion; the start is marked by a circle."""
    dataset = layers[0].dataset
    motions = motion.motions(dataset)
    names = _states(dataset, settings)
    figure, axes = style.new_panels(1, len(motions), points.title(dataset))
    for ax, one in zip(axes, motions, strict=True):
        _panel(ax, one, names, settings)
        ax.set_xlabel(labels.short_label(dataset[names[0]]))
    axes[0].set_ylabel(labels.short_label(dataset[names[1]]))
    _legend(figure, motion.states_present(motions, settings))
    return figure


def _states(dataset: xr.Dataset, settings: Mapping[str, Any]) -> tuple[str, str]:
    """x and y: as the figure says, else the first displacement and its velocity."""
    x = str(settings.get("x", motion.variables(dataset, settings)[0]))
    y = str(settings.get("y", f"{x}_dot"))
    return motion.known_variable(dataset, x), motion.known_variable(dataset, y)


def _panel(
    ax: Axes, one: motion.Motion, names: tuple[str, str], settings: Mapping[str, Any]
) -> None:
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
    ax.plot(x[:1], y[:1], "o", ms=5, mfc="none", color=style.BLACK)
    ax.autoscale_view()
    ax.set_title(one.label)
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


def _legend(figure: Figure, states: Sequence[str]) -> None:
    handles = [Line2D([], [], color=style.CLASSES[state], label=state) for state in states]
    start = Line2D([], [], color=style.BLACK, marker="o", mfc="none", ls="none", label="start")
    figure.legend(handles=[*handles, start], loc="outside lower center", ncols=len(handles) + 1)
