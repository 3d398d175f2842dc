"""Looks of every figure: palette, sizes, and files whose bytes depend on the data alone.

The palette is Okabe and Ito's, told apart by people of every colour vision. A class has one
colour in every figure.
"""

from __future__ import annotations

import io
import itertools
import math
import re
import textwrap
import warnings
from collections.abc import Iterator, Mapping, Sequence
from collections.abc import Set as AbstractSet
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING, Any
from weakref import WeakKeyDictionary

import matplotlib as mpl
import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.collections import Collection, LineCollection, PathCollection
from matplotlib.colors import to_hex, to_rgb
from matplotlib.figure import Figure
from matplotlib.font_manager import FontProperties, findfont
from matplotlib.lines import Line2D
from matplotlib.mathtext import MathTextParser
from matplotlib.text import Text
from matplotlib.textpath import TextPath
from matplotlib.ticker import AutoLocator, FuncFormatter, Locator

from fiv_cli.errors import CrampedFigureError, StorageError, UsageError
from fiv_cli.files import refuse_special, write_whole
from fiv_cli.plots import drawn, labels

if TYPE_CHECKING:
    from matplotlib.artist import Artist
    from matplotlib.axes import Axes
    from matplotlib.axis import Axis
    from matplotlib.legend import Legend
    from matplotlib.path import Path as Outline
    from matplotlib.typing import ColorType

BLACK, ORANGE, SKY, GREEN, YELLOW, BLUE, VERMILLION, PURPLE = (
    "#000000", "#E69F00", "#56B4E9", "#009E73", "#F0E442", "#0072B2", "#D55E00", "#CC79A7",
)  # fmt: skip
GREY = "#BBBBBB"
# Marks and their sizes, of dots: the first are seen around those that lie on them. Two neighbours
# are a pair that is told apart where they coincide: a cross in a circle, a dot in a square.
MARKS = (
    *(("o", 2.4), ("+", 1.9), ("s", 1.8), (".", 2.0)),
    *(("^", 2.2), ("x", 1.5), ("v", 2.2), ("D", 1.6)),
)
DOT_AMONG_MARKS = [marker for marker, _ in MARKS].index(".")
LINES = (BLUE, VERMILLION, GREEN, PURPLE, ORANGE, SKY, BLACK)
COLOUR_ALONE: dict[str, Any] = {"lw": 5.0, "solid_capstyle": "butt"}  # a key that is no mark
DASHES = ("-", "--", "-.", (0, (5, 1.5, 1, 1.5, 1, 1.5)))

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

PALE = 0.4  # of a colour
PANEL = (6.4, 4.2)  # inches
ROOMY = 60  # columns of dots across it that do not crowd
DENSE = 2_000  # marks in a diagram
# Beyond this a vector figure is slow to open: the marks become an image inside it.
MANY_MARKS = 20_000
LONGEST_TEXT = 600  # characters
TITLE_LETTERS = 92  # in a figure of one panel on a screen
MARKUP = re.compile(r"\\[A-Za-z]+|[{}$_^]")
POINTS = 72.0  # an inch
FEWEST_TICKS = 3  # steps between them, on an axis of any length
TICK_LETTERS = 7  # that a tick and the gap beside it take
LETTER, LINE = 0.55, 1.7  # width of a letter, height of an entry of a legend; of the letters' size
KEY, STAR_KEY = 4.5, 8.0  # sizes of the marks in legends, pt
# Where a legend is looked for a place in a panel, and the sides of the compass there.
SIDES: dict[Any, Any] = {
    "upper right": "NE", "upper left": "NW", "lower right": "SE", "lower left": "SW",
    "center right": "E", "center left": "W", "upper center": "N", "lower center": "S",
    "center": "C",
}  # fmt: skip
SAMPLE = "equilibrium 0.870 ± 0.015"
NARROWER = 1.2  # letters of legends stand where one of a title does
KEY_LETTERS = 7  # that the key of an entry of a legend takes
ROUNDING = 1e-9  # of a value: what varies by less is drawn as constant
IMMENSE = 1e250  # what matplotlib squares on its way must stay a number

MM = 1.0 / 25.4  # inches
LEAST_PANEL = 14.4  # upright, in heights of letters
NARROW_PANEL = 6.0  # in heights of letters: less holds no more than two ticks
NARROWEST, WIDEST = 20.0, 2000.0  # mm


@dataclass(frozen=True)
class Look:
    """How figures look in the place that they are for.

    Attributes
    ----------
    width, height : of a whole figure, mm; None: as its panels ask for
    size : of letters, pt
    font : family of letters; empty: matplotlib's own
    titled : whether titles stand above figures
    dpi : dots per inch of images
    weight : by which lines and marks are thicker than on a screen
    """

    width: float | None = None
    height: float | None = None
    size: float = 9.0
    font: str = ""
    titled: bool = True
    dpi: int = 160
    weight: float = 1.0

    def settings(self) -> dict[Any, Any]:
        """What differs from `SETTINGS`."""
        settings: dict[Any, Any] = {
            "font.size": self.size,
            "axes.titlesize": 1.05 * self.size,
            "legend.fontsize": 0.89 * self.size,
            "axes.linewidth": 0.8 * self.weight,
            "savefig.dpi": self.dpi,
        }
        if self.font in MATHEMATICS:
            settings |= {"mathtext.fontset": MATHEMATICS[self.font]}
        elif self.font:
            of_font = {"rm": self.font, "it": f"{self.font}:italic", "bf": f"{self.font}:bold"}
            settings |= {f"mathtext.{kind}": name for kind, name in of_font.items()}
            settings |= {"mathtext.fontset": "custom"}
        return settings | ({"font.family": self.font} if self.font else {})


MATHEMATICS = {"STIXGeneral": "stix", "DejaVu Serif": "dejavuserif", "DejaVu Sans": "dejavusans"}
SCREEN = Look()
LOOKS = {
    "screen": SCREEN,
    "paper": Look(width=90.0, size=8.0, font="STIXGeneral", titled=False, dpi=600, weight=0.8),
    "talk": Look(width=240.0, size=16.0, dpi=200, weight=2.0),
}


def look_of(
    name: str,
    width: float | None = None,
    font: str | None = None,
    titled: bool | None = None,
    height: float | None = None,
) -> Look:
    """One of `LOOKS`, changed in what is given.

    Raises
    ------
    UsageError : there is no such look or font, or the size cannot be drawn
    """
    if name not in LOOKS:
        raise UsageError(f"--style {name}: no such style\nthere are: {', '.join(LOOKS)}")
    for side, size in {"width": width, "height": height}.items():
        if size is not None and not NARROWEST <= size <= WIDEST:
            raise UsageError(
                f"--{side} {size:g}: figures are 20 to 2000 mm wide and high\nnext: --{side} 90"
            )
    if font:
        try:
            findfont(FontProperties(family=font), fallback_to_default=False)
        except ValueError:
            raise UsageError(
                f"--font {font}: not installed on this machine\nnext: --font STIXGeneral (Times), "
                "or one that `fc-list : family` lists"
            ) from None
    look = LOOKS[name]
    return replace(
        look,
        width=look.width if width is None else width,
        height=height,
        font=look.font if font is None else font,
        titled=look.titled if titled is None else titled,
    )


SETTINGS: dict[Any, Any] = {
    "axes.axisbelow": True,
    "axes.formatter.useoffset": False,  # ticks hold the values themselves, but for a power of ten
    "axes.formatter.limits": (-3, 5),
    "axes.formatter.use_mathtext": True,
    "axes.grid": True,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "grid.color": "#DDDDDD",
    "grid.linewidth": 0.5,
    "lines.linewidth": 1.2,
    "legend.framealpha": 0.9,
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
TABLE = ".csv"


_GIVEN: ContextVar[Axes | None] = ContextVar("_GIVEN", default=None)
"""The panel to draw on; None: each figure makes its own."""


_LOOK: ContextVar[Look] = ContextVar("_LOOK", default=SCREEN)


_WORDS: ContextVar[Mapping[str, str] | None] = ContextVar("_WORDS", default=None)
"""What stands in texts -> what to write in its place."""

_CALLED: ContextVar[Mapping[str, Sequence[str]]] = ContextVar(
    "_CALLED", default=MappingProxyType({})
)
"""Name of a variable -> what it is called in figures."""

_STARTS: ContextVar[AbstractSet[str]] = ContextVar("_STARTS", default=frozenset())
"""What starts are called: no part of other words, as of "at rest" and "velocity of belt 1"."""

_MET: ContextVar[set[str] | None] = ContextVar("_MET", default=None)
"""What of it stood in some."""

_BEFORE: ContextVar[dict[str, str] | None] = ContextVar("_BEFORE", default=None)
"""Texts in words of the figure -> what they were."""

_UNSAID: WeakKeyDictionary[Figure, list[str]] = WeakKeyDictionary()
_OWN_WORDS: WeakKeyDictionary[Figure, dict[str, str]] = WeakKeyDictionary()
_NOTES: WeakKeyDictionary[Figure, list[str]] = WeakKeyDictionary()


_OTHERS: ContextVar[Sequence[Axes]] = ContextVar("_OTHERS", default=())
"""The panels beside the one to draw on, which are of another figure of whoever gives it."""


@contextmanager
def looks(
    axis: Axes | None = None,
    look: Look | None = None,
    words: Mapping[str, str] | None = None,
    called: Mapping[str, Sequence[str]] = MappingProxyType({}),
    starts: AbstractSet[str] = frozenset(),
) -> Iterator[None]:
    """The settings above over matplotlib's own defaults, whatever the user's configuration.

    What is drawn meanwhile is drawn on `axis`, if one is given, and written in `words` of its own.
    Some of these may be names of variables, which a figure shows as they are `called`, or `starts`.
    """
    look = look or SCREEN
    given, looking, writing = _GIVEN.set(axis), _LOOK.set(look), _WORDS.set(words)
    calling, starting = _CALLED.set(called), _STARTS.set(starts)
    met, before = _MET.set(set()), _BEFORE.set({})
    root = axis.figure.figure if axis else None
    beside = _OTHERS.set([one for one in root.axes if one is not axis] if root else ())
    try:
        with mpl.rc_context():
            mpl.rcdefaults()
            mpl.rcParams.update(SETTINGS | look.settings())
            yield
    finally:
        _GIVEN.reset(given)
        _LOOK.reset(looking)
        _WORDS.reset(writing)
        _CALLED.reset(calling)
        _STARTS.reset(starting)
        _MET.reset(met)
        _BEFORE.reset(before)
        _OTHERS.reset(beside)


def worded(text: str) -> str:
    """A text in the words that the figure has in place of others, which are no part of formulas.

    They are matched as they are written, or as a figure shows them: ``of v`` is ``of $v$``, and
    ``contact 1`` may be ``contact = 1``.
    """
    own, met = _WORDS.get(), _MET.get()
    if not own or met is None:
        return text
    spelt = {
        form: word
        for word in own
        for form in (
            *(word, labels.with_symbols(word), re.sub(r"(?<=[a-z]) (?=\d+$)", " = ", word)),
            *_CALLED.get().get(word, ()),
        )
    }
    longest = "|".join(map(_matched, sorted(spelt, key=len, reverse=True)))
    known = rf"(?<!\w)(?:{longest})(?!\w|\.\d)|\$[^$]*\$"
    met.update(spelt[one] for one in re.findall(known, text) if one in spelt)
    found = re.sub(known, lambda match: own.get(spelt.get(match[0], ""), match[0]), text)
    if (texts := _BEFORE.get()) is not None:
        texts.setdefault(" ".join(found.split()), text)
    return found


def _matched(form: str) -> str:
    """What finds a word in texts; the name of a start where it stands by itself between others."""
    found = re.escape(form)
    if form not in _STARTS.get():
        return found
    return rf"(?:(?m:^)|(?<=, )|(?<=: )|(?<= and )){found}(?=(?m:$)|,|:| and | \()"


def unsaid(figure: Figure) -> list[str]:
    """The words of one's own that a figure has no place for."""
    return _UNSAID.get(figure, [])


def add_notes(figure: Figure, notes: Sequence[str]) -> None:
    """What whoever asked for a figure should know, as what of it is not there; no part of it."""
    _NOTES.setdefault(figure, []).extend(notes)


def notes_on(figure: Figure) -> list[str]:
    """All that was added of a figure."""
    return _NOTES.get(figure, [])


def weight() -> float:
    """By which lines are thicker than on a screen."""
    return _LOOK.get().weight


def has_titles() -> bool:
    """Whether titles stand above figures."""
    return _LOOK.get().titled


def before(figure: Figure, text: str) -> str:
    """A text of a figure, in one line, before words of one's own took the place of others."""
    words = " ".join(text.split())
    return " ".join(_OWN_WORDS.get(figure, {}).get(words, words).split())


def own_axes(figure: Figure) -> list[Axes]:
    """The panels that are drawn, with their colour bars."""
    return [ax for ax in figure.axes if ax not in _OTHERS.get()]


def letters(figure: Figure) -> int:
    """How many letters of its titles stand side by side in a figure."""
    return _letters(figure.get_figwidth())


def _letters(inches: float) -> int:
    return 1 + int(TITLE_LETTERS * inches / PANEL[0] * SCREEN.size / _LOOK.get().size)


def longest(words: Sequence[str]) -> int:
    """How many letters the longest of some words has when it is set."""
    return max(
        (len(MARKUP.sub("", line)) for word in words for line in word.split("\n")), default=0
    )


def legend_below(figure: Figure, handles: Sequence[Artist], title: str = "") -> None:
    """A legend under the panels, in as many columns as there is room for."""
    most = letters(figure) - KEY_LETTERS
    words = [_folded(worded(str(one.get_label())), most) for one in handles]
    heading = _folded(worded(title), most)
    columns = columns_of(words, int(NARROWER * letters(figure)))
    while words:
        legend = figure.legend(
            handles, words, loc="outside lower center", ncols=columns, title=heading or None
        )
        legend.get_title().set_multialignment("center")
        even_keys(legend)
        if columns == 1 or legend.get_window_extent().width <= figure.bbox.width:
            break
        legend.remove()
        columns = even_columns(len(words), columns - 1)
    rows = [sum(1 + word.count("\n") for word in part) for part in _parted(words, columns)]
    make_room(figure, len(heading.splitlines()) + max(rows, default=0))


def columns_of(words: Sequence[str], room: int) -> int:
    """How many columns of a legend stand side by side: each is as wide as its longest entry."""
    for most in range(len(words), 1, -1):
        columns = even_columns(len(words), most)
        if sum(KEY_LETTERS + longest(part) for part in _parted(words, columns)) <= room:
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
    """Marks of one size, however small or large they are in the figure."""
    for key in legend.legend_handles:
        if isinstance(key, Line2D):
            key.set_markersize(STAR_KEY if key.get_marker() == "*" else KEY)
        elif isinstance(key, PathCollection):
            key.set_sizes([(KEY * _LOOK.get().weight) ** 2])  # what is no line is not thickened


def colour_keys(axes: Sequence[Axes]) -> None:
    """Keys of legends that stand for what is drawn in one colour have this one, not black.

    A key is a black line without points; what it stands for has its words at the end of a label,
    and is of marks where the key is, of these. Where other keys tell what colours mean, those of
    marks and dashes stay black.
    """
    drawn, listed = [*_coloured(axes)], told_in(axes)[0]
    keys = [line for ax in axes for line in ax.lines if _is_key(line)]
    if any(key in listed and key.get_linewidth() == COLOUR_ALONE["lw"] for key in keys):
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
        figure.draw_without_rendering()  # panels and legends have their sizes then
    hiding = [own for ax, own in legends if not _find_place(ax, own)]
    for own in hiding:
        own.remove()
    if hiding:
        legend_below(figure, told_in(figure.axes)[0])
    return bool(hiding)


def _find_place(ax: Axes, legend: Legend) -> bool:
    """Put a legend at the first side of its panel where nothing is drawn; whether there is one."""
    size = legend.get_window_extent()
    letter = mpl.rcParams["legend.fontsize"] * ax.figure.dpi / POINTS
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


def make_room(figure: Figure, lines: int) -> None:
    """Make a small figure higher by the lines of a legend: its panels have nothing to spare."""
    look = _LOOK.get()
    if look.width is not None and look.height is None:
        figure.set_figheight(figure.get_figheight() + LINE * lines * look.size / POINTS)


def resize(figure: Figure, width: float, height: float, rows: int) -> None:
    """Give a figure its size (inches), or the same form at the width of the look."""
    look = _LOOK.get()
    if look.width is not None:
        factor = look.width * MM / width
        least = LEAST_PANEL * look.size / POINTS
        width, height = look.width * MM, max(height * factor, least * rows)
    if look.height is not None:
        height = look.height * MM
    figure.set_size_inches(width, height)


def level(ax: Axes) -> None:
    """Give values that differ by rounding alone a range as high as they are, not as they differ."""
    low, high = ax.dataLim.intervaly
    if 0.0 <= high - low < ROUNDING * abs(low):
        ax.set_ylim(*sorted((0.9 * low, 1.1 * low)))


def label_log(axis: Axis) -> None:
    """Over less than two decades write the numbers themselves, at 1, 2 and 5; else powers of ten.

    Matplotlib's own minor labels run into each other on a small figure.
    """

    def told(value: float, _: object) -> str:
        low, high = sorted(axis.get_view_interval())
        power = int(np.floor(np.log10(value) + ROUNDING))
        first = round(value / 10.0**power, 6)
        if high < 100.0 * low:
            return f"{value:g}" if first in (1.0, 2.0, 5.0) else ""
        return f"$10^{{{power}}}$" if first == 1.0 else ""

    axis.set_major_formatter(FuncFormatter(told))
    axis.set_minor_formatter(FuncFormatter(told))
    # the numbers of both kinds of ticks on one line, though minor ones are shorter
    shorter = mpl.rcParams["xtick.major.size"] - mpl.rcParams["xtick.minor.size"]
    axis.set_tick_params(which="minor", pad=mpl.rcParams["xtick.major.pad"] + shorter)


class TicksAbove(Locator):
    """The ticks of an `own` locator but those below a value, where marks have no height."""

    def __init__(self, own: Locator, least: float) -> None:
        self.own, self.least = own, least

    def set_axis(self, axis: Any) -> None:
        """Tell both whose ticks they are."""
        super().set_axis(axis)
        self.own.set_axis(axis)

    def __call__(self) -> Any:
        """Where there are ticks."""
        return [value for value in self.own() if value >= self.least]

    def view_limits(self, vmin: float, vmax: float) -> tuple[float, float]:
        """The own ends."""
        return self.own.view_limits(vmin, vmax)

    def nonsingular(self, v0: float, v1: float) -> tuple[float, float]:
        """The own ends of a range that is too small."""
        return self.own.nonsingular(v0, v1)


def finish(figure: Figure) -> None:
    """Give lines and marks the weight of the look, and axes words and ticks that have room."""
    own = own_axes(figure)
    words = [
        (worded(title), worded(xlabel), worded(ylabel)) for title, xlabel, ylabel in _texts(figure)
    ]
    for text in itertools.chain.from_iterable(ax.texts for ax in own):
        text.set_text(worded(text.get_text()))
    tame_texts(figure)
    if not _is_set(figure, words):
        width, height = (side / MM for side in figure.get_size_inches())
        message = f"its panels have no room in {width:.0f} by {height:.0f} mm"
        raise CrampedFigureError(message, float(width))
    thicken(figure)
    for artist in itertools.chain.from_iterable([*ax.lines, *ax.collections] for ax in own):
        name = str(artist.get_label()).removeprefix("_")  # which hides it from legends, not tables
        artist.set_label(str(artist.get_label()).replace(name, worded(name)))
    _OWN_WORDS[figure] = dict(_BEFORE.get() or {})
    wanted = [word for word, own in (_WORDS.get() or {}).items() if word != own]
    _UNSAID[figure] = [word for word in wanted if word not in (_MET.get() or ())]


def _is_set(figure: Figure, words: Sequence[tuple[str, str, str]]) -> bool:
    """Set title and labels of each panel, and legends; whether all have room."""
    with warnings.catch_warnings():
        warnings.filterwarnings("error", "constrained_layout not applied")
        try:
            added, is_drawn = _set_words(figure, words, 0)
            if _GIVEN.get() is None and clear_legends(figure, is_drawn):
                _set_words(figure, words, added)
        except UserWarning:  # the words leave nothing for the panels
            return False
    return _GIVEN.get() is not None or _LOOK.get().width is None or _has_room(figure)


def _has_room(figure: Figure) -> bool:
    """Whether each panel is wide enough for two ticks."""
    places = [ax.get_position() for ax in figure.axes if ax.get_subplotspec()]
    least = NARROW_PANEL * _LOOK.get().size / POINTS
    return all(place.width * figure.get_figwidth() >= least for place in places)


def _set_words(
    figure: Figure, words: Sequence[tuple[str, str, str]], added: int
) -> tuple[int, bool]:
    """Fit title and labels of each panel; how many lines they have more, of `added` before, and
    whether panels lie as they did with these, but for what other ticks need."""
    for _ in range(min(2, len(words))):  # what is folded upright takes room from what is not
        figure.draw_without_rendering()  # panels have their places then
        told = _texts(figure), added
        lines = [_fit(ax, *own) for ax, own in zip(own_axes(figure), words, strict=True)]
        added = max(lines)
        make_room(figure, added - told[1])
        if (_texts(figure), added) == told:
            return added, True
    return added, False


def _texts(figure: Figure) -> list[tuple[str, str, str]]:
    """Title and labels of each panel."""
    return [(ax.get_title(), ax.get_xlabel(), ax.get_ylabel()) for ax in own_axes(figure)]


def _fit(ax: Axes, title: str, xlabel: str, ylabel: str) -> int:
    """Set words and ticks as there is room; lines that all panels above each other have more."""
    beside, upright = _room(ax)
    for axis in (ax.xaxis, ax.yaxis):
        locator = axis.get_major_locator()
        locator = locator.own if isinstance(locator, TicksAbove) else locator
        if isinstance(locator, AutoLocator):
            locator.set_params(min_n_ticks=FEWEST_TICKS)
            if axis is ax.xaxis:
                locator.set_params(nbins=max(FEWEST_TICKS, min(9, beside // TICK_LETTERS)))
    above = "\n".join(_folded(one, beside) for one in title.splitlines())
    below = _folded(xlabel, beside)
    ax.set(title=above, xlabel=below, ylabel=_folded(ylabel, upright))
    for label in (ax.xaxis.label, ax.yaxis.label):
        label.set_linespacing(1.1)
    return (above.count("\n") - title.count("\n") + below.count("\n")) * _rows(ax)


def _rows(ax: Axes) -> int:
    """How many panels stand one above the other; of what is beside panels none."""
    place = ax.get_subplotspec()
    return 0 if place is None else place.get_gridspec().nrows


def _room(ax: Axes) -> tuple[int, int]:
    """How many letters there is room for along the sides of a panel."""
    figure, place = ax.figure.figure, ax.get_position()
    letter = _letter(_LOOK.get().font) * mpl.rcParams["axes.titlesize"] / POINTS
    sides = place.width * figure.get_figwidth(), place.height * figure.get_figheight()
    return int(sides[0] / letter), int(sides[1] / letter)


@cache
def _letter(font: str) -> float:
    """Width of a letter of a font, of the letters' size: a page holds more in a narrow one."""
    path = TextPath((0.0, 0.0), SAMPLE, size=1.0, prop=FontProperties(family=font or None))
    return float(path.get_extents().width) / len(SAMPLE)


def _folded(words: str, most: int) -> str:
    """Words in lines of at most so many letters, no formula, number, error nor unit divided."""
    lines = [""]
    for word in re.findall(
        r"(?:\$[^$]*\$|\S)+(?: \d+(?!\S))?(?: [=±] \S+)*(?: \([^()=]*\)$)?", words
    ):
        line = f"{lines[-1]} {word}".strip()
        if len(MARKUP.sub("", line)) <= most or not lines[-1]:
            lines[-1] = line
        else:
            lines.append(word)
    return "\n".join(lines)


def thicken(figure: Figure) -> None:
    """Lines and marks of the weight of the look."""
    weight = _LOOK.get().weight
    drawn = (_GIVEN.get() or figure).findobj()
    for line in [one for one in drawn if isinstance(one, Line2D) and weight != 1.0]:
        line.set(lw=weight * line.get_linewidth(), ms=weight * line.get_markersize())
        line.set_markeredgewidth(weight * line.get_markeredgewidth())
    for lines in [one for one in drawn if isinstance(one, LineCollection) and weight != 1.0]:
        lines.set_linewidth([weight * width for width in np.atleast_1d(lines.get_linewidth())])


def new_panels(rows: int, columns: int, title: str, **shared: Any) -> tuple[Figure, list[Axes]]:
    """A figure with rows x columns panels (listed row by row) and a title."""
    given = _GIVEN.get()
    if given is not None:
        return _given_panel(given, rows * columns, title, shared.get("subplot_kw"))
    figure = Figure(layout="constrained")
    resize(figure, PANEL[0] * _spread(columns), PANEL[1] * _spread(rows), rows)
    FigureCanvasAgg(figure)
    figure.set_label(title)  # for tables of numbers, though it may stand above none
    if title and _LOOK.get().titled:
        words = "\n".join(textwrap.fill(line, letters(figure)) for line in title.splitlines())
        figure.suptitle(words, fontsize=mpl.rcParams["axes.titlesize"])
    axes = figure.subplots(rows, columns, squeeze=False, **shared)
    return figure, list(axes.ravel())


def grid_of_panels(
    count: int, most_columns: int, title: str, least: int = 0, **shared: Any
) -> tuple[Figure, list[Axes], int]:
    """A figure with `count` panels, places for more at its end left blank, and its columns.

    In a figure of given width each panel has room for `least` letters side by side.
    """
    columns = side_by_side(count, most_columns, least)
    figure, axes = new_panels(-(-count // columns), columns, title, **shared)
    for ax in axes[count:]:
        ax.set_axis_off()
    return figure, axes, columns


def side_by_side(count: int, most: int, least: int) -> int:
    """How many of `count` panels, `most` of them, stand side by side, each with room for `least`
    letters in a figure of given width."""
    width = _LOOK.get().width
    if width is not None and least:
        most = max(1, min(most, _letters(width * MM) // least))
    columns = min(count, most)
    return -(-count // -(-count // columns))  # as many in each row, where that is as many rows


def _given_panel(axis: Axes, count: int, title: str, form: object) -> tuple[Figure, list[Axes]]:
    """A panel that is there already.

    Raises
    ------
    UsageError
        the figure needs several, or one of another form.
    """
    if count > 1 or form is not None:
        what = f"{count} panels" if count > 1 else "a panel of its own form"
        one = "take one: select={'initial': 'LABEL'}"
        raise UsageError(f"this figure needs {what}\nnext: leave `axis` out, or {one}")
    axis.set_title(title if _LOOK.get().titled else "")
    return axis.figure.figure, [axis]


def _spread(count: int) -> float:
    """Width of `count` panels side by side, in panels: the more, the smaller each."""
    return 1.0 if count == 1 else 0.62 * count


def class_colours(names: Sequence[str]) -> list[str]:
    """A colour for each class: its own, or the next of the palette."""
    return [CLASSES.get(name, LINES[index % len(LINES)]) for index, name in enumerate(names)]


def pale(colour: ColorType) -> str:
    """What is not certain: a colour on white paper, through which nothing else is seen."""
    red, green, blue = (1.0 - PALE * (1.0 - part) for part in to_rgb(colour))
    return to_hex((red, green, blue))


def dot_size(columns: int, width: float = PANEL[0]) -> float:
    """Diameter (points) of the dots of a diagram, `width` inches wide, with so many columns."""
    roomy = ROOMY * min(1.0, width / PANEL[0])
    return min(2.8, max(1.1, 2.8 * math.sqrt(roomy / max(columns, 1))))


def finer(marks: int) -> float:
    """By how much smaller so many marks are than few: from `DENSE` on, down to half."""
    return min(1.0, max(0.5, math.sqrt(DENSE / max(marks, 1))))


def mark_of(number: int, count: int, size: float) -> dict[str, Any]:
    """The mark of one of `count` sorts of points, each of which shows through those after it."""
    if count == 1 or number >= len(MARKS):
        return {"marker": ".", "ms": 1.5 * size, "mew": 0.0}
    marker, wide = MARKS[number]
    hollow = {"mew": 0.0} if marker == "." else {"mfc": "none", "mew": 0.25 * size}
    return {"marker": marker, "ms": wide * size, **hollow}


def line_colours(count: int) -> list[ColorType]:
    """A colour for each of `count` lines; many lines get a ramp from dark to light."""
    if count <= len(LINES):
        return list(LINES[:count])
    ramp = mpl.colormaps["viridis"]
    return [ramp(0.92 * index / (count - 1)) for index in range(count)]


def dash(number: int, count: int) -> Any:
    """The dashes of one of `count` lines, which colours alone would not tell apart in grey."""
    return DASHES[number % len(DASHES)] if count <= len(LINES) else "-"


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


def save(figure: Figure, path: str | Path, look: Look | None = None) -> None:
    """Write `figure`, drawn in a look, as PNG, SVG or PDF, or as the numbers that it draws (CSV).

    Raises
    ------
    UsageError : another suffix, or what is there is no regular file; a plane as CSV
    StorageError : the file cannot be written
    """
    path = Path(path)
    suffix = path.suffix.lower()
    if suffix not in UNDATED | {TABLE: {}}:
        told = f"{path}: figures are written as {', '.join(UNDATED)}"
        table = f", or, for the numbers that it draws, {path.stem or 'NAME'}{TABLE}"
        raise UsageError(f"{told}\nuse -o {path.stem or 'NAME'}.png{table}")
    refuse_special(path)
    contents = (
        drawn.as_csv(figure, path).encode() if suffix == TABLE else _image(figure, path, look)
    )
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        write_whole(path, contents, durable=False)
    except OSError as error:
        raise StorageError(
            f"{path}: cannot be written ({error.strerror})\nchoose -o FIG"
        ) from error


def _image(figure: Figure, path: Path, look: Look | None) -> bytes:
    """The bytes of an image of the format that `path` names."""
    image, suffix = io.BytesIO(), path.suffix.lower()
    with looks(look=look):
        refuse_the_immense(figure, path)
        tame_texts(figure)
        figure.savefig(image, format=suffix[1:], metadata=UNDATED[suffix])
    return image.getvalue()
