"""Phase portrait: one state against another, coloured by the state of the contact."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.collections import LineCollection
from matplotlib.lines import Line2D

from fiv_cli.plots import labels, motion, points, style

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

suits = motion.suits
FEWEST_SMOOTH = 4  # samples of a stretch that a spline is put through
FINER = 6
OTHER_STICKS: dict[str, Any] = {"color": style.BLACK, "ls": (0, (1, 1.5)), "lw": 2.0, "zorder": 3}


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
    present, contact = (
        motion.states_present(motions, settings),
        motion.named_contact(dataset, settings),
    )
    others = motion.others_sticking(motions, settings)
    _legend(figure, present, others, contact, _shows_starts(dataset, settings))
    return figure


def _shows_starts(dataset: xr.Dataset, settings: points.Settings) -> bool:
    """A window of time may begin anywhere, a settled motion too: its first sample is no start."""
    return "window" not in settings and not points.is_settled(dataset)


def _states(dataset: xr.Dataset, settings: points.Settings) -> tuple[str, str]:
    """x and y: as the figure says, else the first displacement and its velocity.

    Of a law under a stated slip it is the loop: the slip and the force.
    """
    x = str(settings.get("x", motion.variables(dataset, settings)[0]))
    y = str(settings.get("y", "F_T" if "static_capacity" in dataset else f"{x}_dot"))
    return motion.known_variable(dataset, x), motion.known_variable(dataset, y)


def _panel(ax: Axes, one: motion.Motion, names: tuple[str, str], settings: points.Settings) -> None:
    x, y = (one.drawn(name, motion.of_contact(one.data[name], settings)) for name in names)
    path = np.column_stack([x, y])
    stretches: dict[str, list[np.ndarray]] = {}
    for state, begin, end in motion.contact_spans(one, settings):
        first, last = np.searchsorted(one.drawn_time, (begin, end))
        part = slice(first, last + 1)
        stretches.setdefault(state, []).append(_smooth(one.drawn_time[part], path[part]))
    many = one.time.size > style.MANY_MARKS
    for state, pieces in stretches.items():
        ax.add_collection(
            LineCollection(
                pieces, colors=style.CLASSES[state], lw=1.0, label=points.joined(one.label, state),
                rasterized=many,
            )
        )  # fmt: skip
    for contact, begin, end in motion.other_sticks(one, settings):
        part = slice(*np.searchsorted(one.drawn_time, (begin, end)) + np.array([0, 1]))
        stick = points.unlisted(one.label, f"contact {contact} sticks")
        ax.plot(*_smooth(one.drawn_time[part], path[part]).T, **OTHER_STICKS, label=stick)
    if _shows_starts(one.data, settings):
        start = points.unlisted(one.label, "start")
        ax.plot(x[:1], y[:1], "o", ms=5, mfc="none", color=style.BLACK, label=start)
    held = float(one.data["static_capacity"]) if "static_capacity" in one.data else np.nan
    if names == ("slip_dot", "F_T") and np.isfinite(held):
        stick = points.unlisted(one.label, "held in stick")
        ax.plot([0.0, 0.0], [-held, held], "--", color=style.BLACK, lw=1.0, label=stick)
    ax.autoscale_view()
    points.scale(ax, settings)


def _smooth(time: np.ndarray, path: np.ndarray) -> np.ndarray:
    """The path through its samples, smooth and without overshoot between any two events."""
    corners = np.flatnonzero(np.diff(time) <= 0.0) + 1
    pieces = zip(np.split(time, corners), np.split(path, corners), strict=True)
    return np.concatenate([_spline(*piece) for piece in pieces])


def _spline(time: np.ndarray, path: np.ndarray) -> np.ndarray:
    if time.size < FEWEST_SMOOTH:
        return path
    from scipy.interpolate import PchipInterpolator

    between = np.linspace(0.0, 1.0, FINER, endpoint=False)
    fine = np.append((time[:-1, None] + between * np.diff(time)[:, None]).ravel(), time[-1])
    smooth: np.ndarray = PchipInterpolator(time, path)(fine)
    return smooth


def _legend(
    figure: Figure, states: Sequence[str], others: Sequence[str], contact: str, with_start: bool
) -> None:
    handles = [
        Line2D([], [], color=style.CLASSES[state], label=motion.CONTACT_STATES[state])
        for state in states
    ]
    handles += [Line2D([], [], label=words, **OTHER_STICKS) for words in others]
    start = Line2D([], [], color=style.BLACK, marker="o", mfc="none", ls="none", label="start")
    handles += [start] * with_start
    style.legend_below(figure, handles, contact)
