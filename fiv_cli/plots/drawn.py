"""What a figure draws, as a table: the numbers behind a figure, for who draws it with other means.

An artist is told by its label; one without an entry in the legend has a label that begins with an
underscore.
"""

from __future__ import annotations

import csv
import io
import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import TYPE_CHECKING
from weakref import WeakKeyDictionary

import numpy as np
from matplotlib.artist import Artist
from matplotlib.collections import LineCollection, PathCollection, QuadMesh
from matplotlib.contour import ContourSet
from matplotlib.lines import Line2D
from matplotlib.ticker import FixedLocator
from matplotlib.transforms import BlendedGenericTransform

from fiv_cli.errors import UsageError

if TYPE_CHECKING:
    from pathlib import Path

    from matplotlib.axes import Axes
    from matplotlib.axis import Axis
    from matplotlib.figure import Figure

COLUMNS = ("figure", "panel", "x_axis", "y_axis", "series", "line", "x", "y")
LEFT_OUT = "not above 0, not shown"
DECORATION = "_nolegend_"
"""Label of what tells nothing by itself."""
START = "start"
"""A column more, of figures whose points have names: those of starts."""
_NAMES: WeakKeyDictionary[Artist, Sequence[str]] = WeakKeyDictionary()
_LEFT_OUT: WeakKeyDictionary[Artist, set[tuple[float, float]]] = WeakKeyDictionary()
_AXES: WeakKeyDictionary[Axes, Mapping[str, str]] = WeakKeyDictionary()
_WHOLE: WeakKeyDictionary[Artist, Sequence[np.ndarray]] = WeakKeyDictionary()
UNNAMED = "_child"  # what matplotlib calls an artist without a label, and counts


def name_points(artist: Artist, names: Sequence[str]) -> None:
    """Give the points of an artist names, which stand beside them in the table."""
    _NAMES[artist] = names


def name_axes(ax: Axes, labels: Mapping[str, str]) -> None:
    """What its labels are in units without the power of ten that the ticks may be in."""
    _AXES[ax] = labels


def leave_out(artist: Artist, points: np.ndarray) -> None:
    """These points of an artist, shape (n, 2), tell nothing that was computed: in no table."""
    _LEFT_OUT[artist] = {(x, y) for x, y in points.tolist()}


def keep_whole(lines: ContourSet) -> None:
    """Their pieces as they are now: the table has these, whatever is cut out to write there."""
    _WHOLE.setdefault(lines, [np.asarray(piece) for own in lines.allsegs for piece in own])


def as_csv(figure: Figure, path: Path) -> str:
    """A row for each point of marks and lines, in the units and words of the figure.

    `figure` is its title, with the start and the values of parameters that no series names. Each
    line, and all marks of one series, have a number; what stands at an x alone has no y (``nan``),
    and what the figure says in words neither. Where
    points have names there is a column more.

    Raises
    ------
    UsageError : the figure paints a plane, and there are no lines on it
    """
    if has_plane(figure) and not _has_lines(figure):
        raise UsageError(
            f"{path}: not written: a table of points and lines, and this figure is a plane\n"
            "next: the variable that it shows, as fiv show FILE.nc --csv VARIABLE -o FILE.csv"
        )
    table = io.StringIO()
    writer = csv.writer(table, lineterminator="\n")
    named = any(_NAMES.get(artist) for artist in figure.findobj(PathCollection))
    writer.writerow([*COLUMNS, START] if named else COLUMNS)
    for ax in figure.axes:
        told = (str(figure.get_label()).replace("\n", "; "), _panel(ax), *_axis_labels(figure, ax))
        panel = [in_one_line(word) for word in told]
        for series, line, points, names in _lines(ax):
            x, y = (_told(own, points[:, at]) for at, own in enumerate((ax.xaxis, ax.yaxis)))
            columns = [x, y, names or [""] * len(x)] if named else [x, y]
            rows = zip(*columns, strict=True)
            writer.writerows([*panel, series, line, *row] for row in rows)
        for remark in _remarks(ax):
            writer.writerow([*panel, remark, "", np.nan, np.nan])
    return table.getvalue()


def has_plane(figure: Figure) -> bool:
    """Whether it paints a plane, which is in no table of lines."""
    return bool(figure.findobj(QuadMesh, include_self=False))


def _has_lines(figure: Figure) -> bool:
    """Whether lines lie on a plane: at a level, or where another case found them."""
    lines = (line for ax in figure.axes for line in ax.lines)
    drawn = any(
        line.get_linestyle() != "None" and len(np.ravel(line.get_xdata())) for line in lines
    )
    return bool(figure.findobj(ContourSet)) or drawn


def _remarks(ax: Axes) -> Iterator[str]:
    """What the legend says of points that are not drawn."""
    labels = (str(line.get_label()) for line in ax.lines)
    return (label for label in labels if label.startswith(LEFT_OUT))


def _panel(ax: Axes) -> str:
    """What a panel is called: its heading or, where this says more, its label."""
    label = str(ax.get_label())
    return ax.get_title() if label in ("", "<colorbar>") else label


def _axis_labels(figure: Figure, ax: Axes) -> tuple[str, str]:
    """Labels of both axes; panels that share them have x below the last and y beside the first."""
    here = figure.axes.index(ax)
    below, beside = (
        [_AXES.get(one, {}).get(word, word) for one, word in zip(figure.axes, words, strict=True)]
        for words in ([one.get_xlabel() for one in figure.axes],
                      [one.get_ylabel() for one in figure.axes])
    )  # fmt: skip
    return below[here] or _last(below), _last(beside[: 1 + here])


def _last(words: Iterable[str]) -> str:
    """The last that is not empty."""
    return next(filter(None, reversed([*words])), "")


def _lines(ax: Axes) -> Iterator[tuple[str, int, np.ndarray, Sequence[str]]]:
    """Series, number of the line, points, shape (n, 2), and their names, of all that is shown."""
    number = 0
    for artist in ax.get_children():
        label = str(artist.get_label())
        series = "" if label.startswith(UNNAMED) else in_one_line(label).removeprefix("_")
        for points in () if label == DECORATION else _pieces(artist, ax):
            number += 1
            yield series, number, _told_of(artist, points), _NAMES.get(artist, ())


def _told_of(artist: Artist, points: np.ndarray) -> np.ndarray:
    """The points of a piece of an artist but for those that are left out."""
    left_out = _LEFT_OUT.get(artist)
    if not left_out:
        return points
    return points[[(x, y) not in left_out for x, y in points.tolist()]]


def _pieces(artist: Artist, ax: Axes) -> Iterable[np.ndarray]:
    """The points of each piece of an artist."""
    if isinstance(artist, Line2D):
        return _pieces_of_line(artist, ax)
    if isinstance(artist, LineCollection):
        pieces = map(np.asarray, artist.get_segments())
        return (piece for piece in pieces if piece.size)  # an error bar that is not known has none
    if isinstance(artist, ContourSet):
        return _WHOLE.get(artist) or (np.asarray(one) for own in artist.allsegs for one in own)
    marks = np.asarray(artist.get_offsets()) if isinstance(artist, PathCollection) else np.empty(0)
    return [marks] if marks.size else []


def _pieces_of_line(line: Line2D, ax: Axes) -> list[np.ndarray]:
    """The points of a line between its gaps, or all its marks; a height off the axis is NaN."""
    points = np.array(line.get_xydata(), float)
    transform = line.get_transform()  # that of data, perhaps shifted, or one for each direction
    apart = transform == ax.transAxes or isinstance(transform, BlendedGenericTransform)
    if apart and not transform.contains_branch_seperately(ax.transData)[1]:
        pieces = [np.unique(points[:, :1], axis=0) * (1.0, np.nan)]
    else:
        known = np.isfinite(points).all(axis=1)
        gaps = np.flatnonzero(~known & (line.get_linestyle() != "None"))
        pieces = [
            piece[here]
            for piece, here in zip(np.split(points, gaps), np.split(known, gaps), strict=True)
        ]
    return [piece for piece in pieces if piece.size]


def _told(axis: Axis, values: np.ndarray) -> list[float | str]:
    """Values along an axis: numbers, NaN where there is none, or the words at their ticks."""
    if isinstance(axis.get_major_locator(), FixedLocator):
        words = [in_one_line(text.get_text()) for text in axis.get_ticklabels()]
        named = dict(zip(axis.get_ticklocs().round().tolist(), words, strict=True))
        return [named.get(value, value) for value in values.round().tolist()]
    return [*values.tolist()]


def in_one_line(words: str) -> str:
    r"""Words of a figure without their markup: ``c_1 = 0.1 N m s`` of ``$c_1$ = 0.1 N m s``."""
    words = re.sub(r"\\(d*)dot\{(.*?)\}(_\{.*?\}|_\w)?", r"\2\3_\1dot", words.replace("\n", " "))
    words = re.sub(r"(?:([\d.]+) \\times |(?<![\w.]))10\^\{(-?\d+)\}", _plain_power, words)
    words = words.replace("\N{MINUS SIGN}", "-")
    words = re.sub(r"\\(?:mathrm|mathit|,|;)", "", words.replace(r"\to", "->"))
    return re.sub(r"\$(.*?)\$", lambda symbols: re.sub(r"[{}\\]", "", symbols[1]), words)


def _plain_power(written: re.Match[str]) -> str:
    """A power of ten as programs read it: ``2.5e-4``."""
    return f"{written[1] or 1}e{written[2]}"
