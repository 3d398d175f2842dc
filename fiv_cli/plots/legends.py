"""Legends: in a panel where nothing is drawn, or below, in as many columns as there is room for."""

from __future__ import annotations

import itertools
import re
from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING, Any

import matplotlib as mpl
import numpy as np
from matplotlib.collections import Collection, LineCollection, PathCollection
from matplotlib.colors import to_hex
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from fiv_cli.plots import style

if TYPE_CHECKING:
    from matplotlib.artist import Artist
    from matplotlib.axes import Axes
    from matplotlib.legend import Legend
    from matplotlib.path import Path as Outline

KEYS, STAR_KEY = (3.2, 6.5), 8.0  # least and greatest size of the marks in legends, pt; of stars
# Where a legend is looked for a place in a panel, and the sides of the compass there.
SIDES: dict[Any, Any] = {
    "upper right": "NE", "upper left": "NW", "lower right": "SE", "lower left": "SW",
    "center right": "E", "center left": "W", "upper center": "N", "lower center": "S",
    "center": "C",
}  # fmt: skip
NARROWER = 1.2  # letters of legends stand where one of a title does
# Of the width of a figure: longer entries leave no room for another column, and are folded.
FOLDED = (1.0, 0.65, 0.5)
KEY_LETTERS = 7  # that the key of an entry of a legend takes


def legend_below(figure: Figure, handles: Sequence[Artist], title: str = "") -> None:
    """A legend under the panels, in as many columns as there is room for."""
    most, room = style.letters(figure) - KEY_LETTERS, int(NARROWER * style.letters(figure))
    heading = style.folded(style.worded(title), most)
    whole = [style.worded(str(one.get_label())) for one in handles]
    folded = [[style.folded(one, int(part * most)) for one in whole] for part in FOLDED]
    counts = [{even_columns(len(w), n) for n in range(columns_of(w, room), 0, -1)} for w in folded]
    tried = [(w, n) for w, of in zip(folded, counts, strict=True) for n in sorted(of)]
    tried.sort(key=lambda one: _rows(*one))
    for words, columns in tried if handles else ():
        legend = figure.legend(
            handles, words, loc="outside lower center", ncols=columns, title=heading or None
        )
        legend.get_title().set_multialignment("center")
        even_keys(legend)
        if columns == 1 or legend.get_window_extent().width <= figure.bbox.width:
            break
        legend.remove()
    style.make_room(figure, len(heading.splitlines()) + (_rows(words, columns) if handles else 0))


def _rows(words: Sequence[str], columns: int) -> int:
    """The lines of the longest column of a legend."""
    rows = [sum(1 + word.count("\n") for word in part) for part in _parted(words, columns)]
    return max(rows, default=0)


def columns_of(words: Sequence[str], room: int) -> int:
    """How many columns of a legend stand side by side: each is as wide as its longest entry."""
    for most in range(len(words), 1, -1):
        columns = even_columns(len(words), most)
        if sum(KEY_LETTERS + style.longest(part) for part in _parted(words, columns)) <= room:
            return columns
    return 1


def even_columns(count: int, most: int) -> int:
    """As few columns as make no more rows of a legend, which are about as long then."""
    rows = -(-count // most)
    return -(-count // rows)


def _parted(words: Sequence[str], columns: int) -> list[list[str]]:
    """Entries in columns, as a legend has them: one after another, the first no shorter."""
    rows, longer = divmod(len(words), columns)
    ends = np.cumsum([rows + (column < longer) for column in range(columns)]).tolist()
    return [[*words[begin:end]] for begin, end in itertools.pairwise([0, *ends])]


def even_keys(legend: Legend) -> None:
    """Marks as large as in the figure, but where these are too small to see what they are."""
    for key in legend.legend_handles:
        if isinstance(key, Line2D):
            size = float(np.clip(key.get_markersize(), *KEYS))
            key.set_markersize(STAR_KEY if key.get_marker() == "*" else size)
        elif isinstance(key, PathCollection):
            key.set_sizes([(np.mean(KEYS) * style.look().weight) ** 2])  # is not thickened


def colour_keys(axes: Sequence[Axes]) -> None:
    """Keys of legends that stand for what is drawn in one colour have this one, not black.

    A key is a black line without points; what it stands for has its words at the end of a label,
    and is of marks where the key is, of these. Where other keys tell what colours mean, those of
    marks and dashes stay black.
    """
    drawn, listed = [*_coloured(axes)], told_in(axes)[0]
    keys = [line for ax in axes for line in ax.lines if _is_key(line)]
    if any(key in listed and key.get_linewidth() == style.COLOUR_ALONE["lw"] for key in keys):
        return
    for key in keys:
        words = re.compile(f"_(.*, )?{re.escape(str(key.get_label()))}")
        mark = key.get_marker() if key.get_linestyle() == "None" else None
        colours = {
            colour
            for label, colour, own in drawn
            if words.fullmatch(label) and (mark is None or mark == own)
        }
        if len(colours) == 1:
            key.set_color(colours.pop())


def _coloured(axes: Sequence[Axes]) -> Iterator[tuple[str, str, Any]]:
    """Label, colour and mark of the lines that are drawn."""
    for ax in axes:
        for line in ax.lines:
            if not _is_key(line):
                yield str(line.get_label()), to_hex(line.get_color()), line.get_marker()
        for lines in ax.collections:
            if isinstance(lines, LineCollection):
                yield str(lines.get_label()), to_hex(np.atleast_2d(lines.get_color())[0]), None


def _is_key(line: Line2D) -> bool:
    return not np.size(line.get_xdata())


def seen_in(ax: Axes) -> Iterator[tuple[str, bool]]:
    """Label of each line that has points, and whether any of it lies within its panel."""
    ax.get_xlim(), ax.get_ylim()  # the panel has its scale when it is asked for
    within = ax.bbox.padded(1.0)
    for artist, path in _paths(ax):
        if np.isfinite(path.vertices).all(axis=1).any():
            crosses = _joins(artist) and path.intersects_bbox(within, filled=False)
            yield str(artist.get_label()), crosses or within.count_contains(path.vertices) > 0


def told_in(axes: Sequence[Axes]) -> tuple[list[Artist], list[str]]:
    """What the legend of some panels tells, and its words: once what several of them show."""
    told: dict[str, Artist] = {}
    for ax in axes:
        for handle, word in zip(*ax.get_legend_handles_labels(), strict=True):
            told.setdefault(word, handle)
    return list(told.values()), list(told)


def clear_legends(figure: Figure, is_drawn: bool) -> bool:
    """Put the legend of a panel where nothing is drawn or, where there is no such place, below.

    Whether it is below now. Of a figure that `is_drawn` the panels lie where they will.
    """
    legends = [(ax, own) for ax in figure.axes if (own := ax.get_legend())]
    if legends and not is_drawn:
        style.lay_out(figure)  # panels and legends have their sizes then
    hiding = [own for ax, own in legends if not _find_place(ax, own)]
    for own in hiding:
        own.remove()
    if hiding:
        legend_below(figure, told_in(figure.axes)[0])
    return bool(hiding)


def _find_place(ax: Axes, legend: Legend) -> bool:
    """Put a legend at the first side of its panel where nothing is drawn; whether there is one."""
    size = legend.get_window_extent()
    letter = mpl.rcParams["legend.fontsize"] * ax.figure.dpi / style.POINTS
    within = ax.bbox.padded(-legend.borderaxespad * letter)
    outlines, marks = _outlines(ax), _marks(ax)
    for place, side in SIDES.items():
        taken = size.anchored(side, within).padded(0.5 * letter)
        lines = any(outline.intersects_bbox(taken, filled=False) for outline in outlines)
        if not lines and not taken.count_contains(marks):
            legend.set_loc(place)
            return True
    return False


def _outlines(ax: Axes) -> list[Outline]:
    """The lines of a panel, in pixels."""
    return [path for artist, path in _paths(ax) if _joins(artist)]


def _paths(ax: Axes) -> Iterator[tuple[Line2D | Collection, Outline]]:
    """Lines, marks and bundles of lines of a panel, with their points in pixels."""
    for line in ax.lines:
        yield line, line.get_transform().transform_path(line.get_path())
    for lines in ax.collections:
        for path in lines.get_paths():
            yield lines, lines.get_transform().transform_path(path)


def _joins(artist: Line2D | Collection) -> bool:
    """Whether there is a line through the points of an artist."""
    return not isinstance(artist, Line2D) or artist.get_linestyle() != "None"


def _marks(ax: Axes) -> np.ndarray:
    """The points of a panel and the corners of its words, in pixels, shape (n, 2)."""
    places = [line.get_transform().transform(line.get_xydata()) for line in ax.lines]
    written = [text.get_window_extent().corners() for text in ax.texts]
    return np.concatenate([np.zeros((0, 2)), *places, *written])
