"""Looks of every figure: palette, sizes, and files whose bytes depend on the data alone.

The palette is Okabe and Ito's, told apart by people of every colour vision. A class has one
colour in every figure.
"""

from __future__ import annotations

import io
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from contextvars import ContextVar
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any

import matplotlib as mpl
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.mathtext import MathTextParser
from matplotlib.text import Text

from fiv_cli.errors import StorageError, UsageError
from fiv_cli.files import refuse_special, write_whole

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.typing import ColorType

BLACK, ORANGE, SKY, GREEN, YELLOW, BLUE, VERMILLION, PURPLE = (
    "#000000", "#E69F00", "#56B4E9", "#009E73", "#F0E442", "#0072B2", "#D55E00", "#CC79A7",
)  # fmt: skip
GREY = "#BBBBBB"
# Marks and their sizes, of dots: the first are seen around those that lie on them.
MARKS = (("o", 1.5), ("+", 1.2), ("x", 0.8), ("s", 0.5))
LINES = (BLUE, VERMILLION, GREEN, PURPLE, ORANGE, SKY, BLACK)

CLASSES = {
    "equilibrium": SKY,
    "periodic": ORANGE,
    "quasiperiodic": GREEN,
    "chaotic": VERMILLION,
    "undecided": GREY,
    "diverged": BLACK,
    "contact_lost": PURPLE,
    "slip+": BLUE,
    "slip-": GREEN,
    "stick": ORANGE,
    "separation": PURPLE,
    "not_computed": "#F2F2F2",
    "stable": SKY,
    "unstable": VERMILLION,
    "neutral": GREY,
}

PANEL = (6.4, 4.2)  # inches
# Beyond this a vector figure is slow to open: the marks become an image inside it.
MANY_MARKS = 20_000
LONGEST_TEXT = 600  # characters
IMMENSE = 1e250  # what matplotlib squares on its way must stay a number

SETTINGS: dict[Any, Any] = {
    "font.size": 9.0,
    "axes.titlesize": 9.5,
    "axes.axisbelow": True,
    "axes.grid": True,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "grid.color": "#DDDDDD",
    "grid.linewidth": 0.5,
    "lines.linewidth": 1.2,
    "legend.fontsize": 8.0,
    "legend.framealpha": 0.9,
    "savefig.dpi": 160,
    "pdf.fonttype": 42,
    # names of SVG elements are hashed with a fixed salt: the same data gives the same bytes
    "svg.hashsalt": "fiv",
}

# What each format would otherwise stamp with the time of writing.
UNDATED = {
    ".png": {"Software": "fiv"},
    ".svg": {"Date": None, "Creator": "fiv"},
    ".pdf": {"CreationDate": None, "ModDate": None, "Creator": "fiv", "Producer": "fiv"},
}


_GIVEN: ContextVar[Axes | None] = ContextVar("_GIVEN", default=None)
"""The panel to draw on; None: each figure makes its own."""


@contextmanager
def looks(axis: Axes | None = None) -> Iterator[None]:
    """The settings above over matplotlib's own defaults, whatever the user's configuration.

    What is drawn meanwhile is drawn on `axis`, if one is given.
    """
    given = _GIVEN.set(axis)
    try:
        with mpl.rc_context():
            mpl.rcdefaults()
            mpl.rcParams.update(SETTINGS)
            yield
    finally:
        _GIVEN.reset(given)


def new_panels(rows: int, columns: int, title: str, **shared: Any) -> tuple[Figure, list[Axes]]:
    """A figure with rows x columns panels (listed row by row) and a title."""
    given = _GIVEN.get()
    if given is not None:
        return _given_panel(given, rows * columns, title, shared.get("subplot_kw"))
    width, height = PANEL
    figure = Figure(
        figsize=(width * _spread(columns), height * _spread(rows)), layout="constrained"
    )
    FigureCanvasAgg(figure)
    if title:
        figure.suptitle(title, fontsize=SETTINGS["axes.titlesize"])
    axes = figure.subplots(rows, columns, squeeze=False, **shared)
    return figure, list(axes.ravel())


def grid_of_panels(
    count: int, most_columns: int, title: str, **shared: Any
) -> tuple[Figure, list[Axes], int]:
    """A figure with `count` panels, places for more at its end left blank, and its columns."""
    columns = min(count, most_columns)
    figure, axes = new_panels(-(-count // columns), columns, title, **shared)
    for ax in axes[count:]:
        ax.set_axis_off()
    return figure, axes, columns


def _given_panel(axis: Axes, count: int, title: str, form: object) -> tuple[Figure, list[Axes]]:
    """A panel that is there already.

    Raises
    ------
    UsageError
        the figure needs several, or one of another form.
    """
    if count > 1 or form is not None:
        what = f"{count} panels" if count > 1 else "a panel of its own form"
        raise UsageError(f"this figure needs {what}\nnext: leave `axis` out, or select one")
    axis.set_title(title)
    return axis.figure.figure, [axis]


def _spread(count: int) -> float:
    """Width of `count` panels side by side, in panels: the more, the smaller each."""
    return 1.0 if count == 1 else 0.62 * count


def class_colours(names: Sequence[str]) -> list[str]:
    """A colour for each class: its own, or the next of the palette."""
    return [CLASSES.get(name, LINES[index % len(LINES)]) for index, name in enumerate(names)]


def dot_size(columns: int) -> float:
    """Diameter (points) of the dots of a diagram with so many columns of dots side by side."""
    if columns < 60:
        return 3.5
    return 2.2 if columns < 400 else 1.2


def mark_of(number: int, count: int, size: float) -> dict[str, Any]:
    """The mark of one of `count` sorts of points, each of which shows through those after it."""
    if count == 1 or number >= len(MARKS):
        return {"marker": ".", "ms": size, "mew": 0.0}
    marker, wide = MARKS[number]
    return {"marker": marker, "ms": wide * size, "mfc": "none", "mew": 0.25 * size}


def line_colours(count: int) -> list[ColorType]:
    """A colour for each of `count` lines; many lines get a ramp from dark to light."""
    if count <= len(LINES):
        return list(LINES[:count])
    ramp = mpl.colormaps["viridis"]
    return [ramp(0.92 * index / (count - 1)) for index in range(count)]


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


def refuse_the_immense(figure: Figure, path: Path) -> None:
    """Refuse axes so long that no ticks can be set on them.

    Raises
    ------
    UsageError
    """
    for axes in figure.axes:
        for low, high in (axes.get_xlim(), axes.get_ylim()):
            if not abs(low) < IMMENSE > abs(high):
                raise UsageError(
                    f"{path}: it would reach from {low:g} to {high:g}, which cannot be drawn\n"
                    "next: choose a part with `select`, `xlim` or `ylim` in the [[figure]]"
                )


@cache
def _is_sound(words: str) -> bool:
    """Whether matplotlib can set the mathematics in `words`, if there is any (line by line)."""
    try:
        for line in words.splitlines():
            MathTextParser("path").parse(line)
    except ValueError:
        return False
    return True


def save(figure: Figure, path: str | Path) -> None:
    """Write `figure` as PNG, SVG or PDF, by the suffix of `path`.

    Raises
    ------
    UsageError : another suffix, or what is there is no regular file
    StorageError : the file cannot be written
    """
    path = Path(path)
    suffix = path.suffix.lower()
    if suffix not in UNDATED:
        raise UsageError(
            f"{path}: figures are written as {', '.join(UNDATED)}\nuse -o {path.stem or 'NAME'}.png"
        )
    refuse_special(path)
    image = io.BytesIO()
    with looks():
        refuse_the_immense(figure, path)
        tame_texts(figure)
        figure.savefig(image, format=suffix[1:], metadata=UNDATED[suffix])
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        write_whole(path, image.getvalue(), durable=False)
    except OSError as error:
        raise StorageError(
            f"{path}: cannot be written ({error.strerror})\nchoose -o FIG"
        ) from error
