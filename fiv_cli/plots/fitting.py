"""Setting the words of a figure as there is room for them, and the weight of its lines."""

from __future__ import annotations

import itertools
import re
import warnings
from collections.abc import Sequence
from functools import cache
from typing import TYPE_CHECKING, Any

import matplotlib as mpl
import numpy as np
from matplotlib.collections import LineCollection
from matplotlib.figure import Figure
from matplotlib.font_manager import FontProperties
from matplotlib.lines import Line2D
from matplotlib.mathtext import MathTextParser
from matplotlib.text import Text
from matplotlib.textpath import TextPath
from matplotlib.ticker import AutoLocator, ScalarFormatter

from fiv_cli.errors import CrampedFigureError
from fiv_cli.plots import drawn, legends, style

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.axis import Axis

LONGEST_TEXT = 600  # characters
FEWEST_TICKS = 3  # steps between them, on an axis of any length
TICK_LETTERS, TICK_GAP = 7, 2  # that a tick and the gap beside it take at least, and the gap
SAMPLE = "equilibrium 0.870 ± 0.015"
POWER = re.compile(r"\$\\times\\mathdefault\{10\^\{(\D?\d+)\}\}(?:\\mathdefault\{\})?\$")
NARROW_PANEL = 6.0  # in heights of letters: less holds no more than two ticks


def finish(figure: Figure) -> None:
    """Give lines and marks the weight of the look, and axes words and ticks that have room."""
    own = style.own_axes(figure)
    words = [
        (style.worded(title), style.worded(xlabel), style.worded(ylabel))
        for title, xlabel, ylabel in _texts(figure)
    ]
    for text in itertools.chain.from_iterable(ax.texts for ax in own):
        text.set_text(style.worded(text.get_text()))
    tame_texts(figure)
    if not _is_set(figure, words):
        width, height = (side / style.MM for side in figure.get_size_inches())
        message = f"its panels have no room in {width:.0f} by {height:.0f} mm"
        raise CrampedFigureError(message, float(width))
    thicken(figure)
    for artist in itertools.chain.from_iterable([*ax.lines, *ax.collections] for ax in own):
        name = str(artist.get_label()).removeprefix("_")  # which hides it from legends, not tables
        artist.set_label(str(artist.get_label()).replace(name, style.worded(name)))
    style.keep_words(figure)


def _is_set(figure: Figure, words: Sequence[tuple[str, str, str]]) -> bool:
    """Set title and labels of each panel, and legends; whether all have room."""
    with warnings.catch_warnings():
        warnings.filterwarnings("error", "constrained_layout not applied")
        try:
            added, is_drawn = _set_words(figure, words, 0)
            if style.given() is None and legends.clear_legends(figure, is_drawn):
                _set_words(figure, words, added)
        except UserWarning:  # the words leave nothing for the panels
            return False
    return style.given() is not None or style.look().width is None or _has_room(figure)


def _has_room(figure: Figure) -> bool:
    """Whether each panel is wide enough for two ticks."""
    places = [ax.get_position() for ax in figure.axes if ax.get_subplotspec()]
    least = NARROW_PANEL * style.look().size / style.POINTS
    return all(place.width * figure.get_figwidth() >= least for place in places)


def _set_words(
    figure: Figure, words: Sequence[tuple[str, str, str]], added: int
) -> tuple[int, bool]:
    """Fit title and labels of each panel; how many lines they have more, of `added` before, and
    whether panels lie as they did with these, but for what other ticks need."""
    for _ in range(min(2, len(words))):  # what is folded upright takes room from what is not
        style.lay_out(figure)  # panels have their places then
        told = _texts(figure), added
        lines = [_fit(ax, *own) for ax, own in zip(style.own_axes(figure), words, strict=True)]
        added = max(lines)
        style.make_room(figure, added - told[1])
        if (_texts(figure), added) == told:
            return added, True
    return added, False


def _texts(figure: Figure) -> list[tuple[str, str, str]]:
    """Title and labels of each panel."""
    return [(ax.get_title(), ax.get_xlabel(), ax.get_ylabel()) for ax in style.own_axes(figure)]


def _fit(ax: Axes, title: str, xlabel: str, ylabel: str) -> int:
    """Set words and ticks as there is room; lines that all panels above each other have more."""
    beside, upright = _room(ax)
    for axis in (ax.xaxis, ax.yaxis):
        locator = axis.get_major_locator()
        locator = locator.own if isinstance(locator, style.TicksAbove) else locator
        if isinstance(locator, AutoLocator):
            # as many as there is room for now: else labels and panels could change in turns
            most = max(FEWEST_TICKS - 1, min(9, axis.get_tick_space()))
            locator.set_params(nbins=most, min_n_ticks=FEWEST_TICKS)
            if axis is ax.xaxis:
                _fit_ticks(axis, locator, beside)
    above = "\n".join(style.folded(one, beside) for one in title.splitlines())
    below = style.folded(_with_power(ax, "x", xlabel), beside)
    left = style.folded(_with_power(ax, "y", ylabel), upright)
    ax.set(title=above, xlabel=below, ylabel=left)
    drawn.name_axes(ax, {below: xlabel, left: ylabel})
    for label in (ax.xaxis.label, ax.yaxis.label):
        label.set_linespacing(1.1)
    return (above.count("\n") - title.count("\n") + below.count("\n")) * _rows(ax)


def _fit_ticks(axis: Axis, locator: AutoLocator, room: int) -> None:
    """As many ticks along x as there is room for: by how long they are, after a first guess."""
    letters = TICK_LETTERS
    for _ in range(2):
        most = max(2, min(9, room // letters))
        locator.set_params(nbins=most, min_n_ticks=min(most, FEWEST_TICKS))
        texts = axis.get_major_formatter().format_ticks(list(axis.get_majorticklocs()))
        letters = max(TICK_LETTERS, style.longest(texts or [""]) + TICK_GAP)


def _with_power(ax: Axes, which: str, label: str) -> str:
    """A label with the power of ten that the numbers at the ticks are in, as ``(10^5 N/m)``.

    Matplotlib's own place for it, at the end of the axis, is where long labels and headings are; it
    stays there where panels beside it, which that label is for, too, have another.
    """
    axes = [_axis(one, which) for one in (ax, *_labelled_by(ax, which))]
    power, *others = dict.fromkeys(map(_power, axes))
    if not label or not power or others or label.count("$") % 2:
        return label
    for axis in axes:
        axis.get_major_formatter().set_powerlimits((power, power))  # whatever becomes of its limits
        axis.get_offset_text().set_visible(False)
    unit = re.search(r"\s\((?:1/)?(\S[^()]*)\)$", label)
    if unit and re.fullmatch(style.UNIT, f" {unit[1]}"):
        return f"{label[: unit.start()]} ($10^{{{power}}}$ {unit[0].strip()[1:]}"
    return f"{label} ($10^{{{power}}}$)"


def _axis(ax: Axes, which: str) -> Any:
    return ax.xaxis if which == "x" else ax.yaxis


def _power(axis: Any) -> int:
    """The power of ten of the numbers at the ticks; 0 where there is none, or an offset as well."""
    formatter = axis.get_major_formatter()
    if not isinstance(formatter, ScalarFormatter):
        return 0
    formatter.format_ticks(list(axis.get_majorticklocs()))
    found = POWER.fullmatch(formatter.get_offset())
    return int(found[1].replace("\N{MINUS SIGN}", "-")) if found else 0


def _labelled_by(ax: Axes, which: str) -> list[Axes]:
    """The panels of the same row, or column, that have no label of their own."""
    place = ax.get_subplotspec()
    if place is None:
        return []
    span = "colspan" if which == "x" else "rowspan"
    beside = (
        one for one in style.own_axes(ax.figure.figure) if one.get_subplotspec() and one.axison
    )
    return [
        one
        for one in beside
        if getattr(one.get_subplotspec(), span) == getattr(place, span)
        and not _axis(one, which).label.get_text()
    ]


def _rows(ax: Axes) -> int:
    """How many panels stand one above the other; of what is beside panels none."""
    place = ax.get_subplotspec()
    return 0 if place is None else place.get_gridspec().nrows


def _room(ax: Axes) -> tuple[int, int]:
    """How many letters there is room for along the sides of a panel."""
    figure, place = ax.figure.figure, ax.get_position()
    letter = _letter(style.look().font) * mpl.rcParams["axes.titlesize"] / style.POINTS
    sides = place.width * figure.get_figwidth(), place.height * figure.get_figheight()
    return int(sides[0] / letter), int(sides[1] / letter)


@cache
def _letter(font: str) -> float:
    """Width of a letter of a font, of the letters' size: a page holds more in a narrow one."""
    path = TextPath((0.0, 0.0), SAMPLE, size=1.0, prop=FontProperties(family=font or None))
    return float(path.get_extents().width) / len(SAMPLE)


def thicken(figure: Figure) -> None:
    """Lines and marks of the weight of the look."""
    weight = style.look().weight
    drawn = (style.given() or figure).findobj()
    for line in [one for one in drawn if isinstance(one, Line2D) and weight != 1.0]:
        line.set(lw=weight * line.get_linewidth(), ms=weight * line.get_markersize())
        line.set_markeredgewidth(weight * line.get_markeredgewidth())
    for lines in [one for one in drawn if isinstance(one, LineCollection) and weight != 1.0]:
        lines.set_linewidth([weight * width for width in np.atleast_1d(lines.get_linewidth())])


def tame_texts(figure: Figure) -> None:
    """Let every text of `figure` whose mathematics is broken be drawn letter by letter.

    A title is the user's, a symbol the dataset's: neither may keep a figure from being drawn, nor
    take minutes by its length.
    """
    for axes in figure.axes:
        axes.get_xticklabels(), axes.get_yticklabels()  # the labels of ticks are made when asked
    for text in figure.findobj(Text):
        if len(text.get_text()) > LONGEST_TEXT:
            text.set_text(f"{text.get_text()[:LONGEST_TEXT]} ...")
        if not _is_sound(text.get_text()):
            text.set_parse_math(False)


@cache
def _is_sound(words: str) -> bool:
    """Whether matplotlib can set the mathematics in `words`, if there is any (line by line)."""
    try:
        for line in words.splitlines():
            MathTextParser("path").parse(line)
    except ValueError:
        return False
    return True
