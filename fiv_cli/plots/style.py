"""Looks of every figure: palette, sizes, words and panels.

The palette is Okabe and Ito's, told apart by people of every colour vision. A class has one
colour in every figure.
"""

from __future__ import annotations

import math
import re
import textwrap
from collections.abc import Iterator, Mapping, Sequence
from collections.abc import Set as AbstractSet
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import dataclass, replace
from types import MappingProxyType
from typing import TYPE_CHECKING, Any
from weakref import WeakKeyDictionary

import matplotlib as mpl
import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.colors import to_hex, to_rgb
from matplotlib.figure import Figure
from matplotlib.font_manager import FontProperties, findfont
from matplotlib.ticker import FuncFormatter, Locator

from fiv_cli.errors import UsageError
from fiv_cli.plots import drawn, labels

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.axis import Axis
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
DASHES = ("-", "--", "-.", (0, (3.2, 1, 1, 1, 1, 1)))

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
TITLE_LETTERS = 92  # in a figure of one panel on a screen
MARKUP = re.compile(r"\\[A-Za-z]+|[{}$_^]")
POINTS = 72.0  # an inch
ACROSS = 0.8  # of the width of a figure: what a panel has
LETTER, LINE = 0.55, 1.7  # width of a letter, height of an entry of a legend; of the letters' size
ROUNDING = 1e-9  # of a value: what varies by less is drawn as constant

MM = 1.0 / 25.4  # inches
LEAST_PANEL = 14.4  # upright, in heights of letters
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
    "legend.handlelength": 2.8,  # dashes are seen whole
    "pdf.fonttype": 42,
    # names of SVG elements are hashed with a fixed salt: the same data gives the same bytes
    "svg.hashsalt": "fiv",
}


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
_CAPTIONS: WeakKeyDictionary[Figure, list[str]] = WeakKeyDictionary()
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
    ``contact 1`` may be ``contact = 1``. All of a text, and each of those that an entry names
    (``modes merge: A and B``), may be as tables have it: ``L_s = 1 m^2``.
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
    parts = (text, *re.split(r": | and ", text))
    plain = ((part, drawn.in_one_line(part)) for part in parts)
    spelt |= {part: told for part, told in plain if told in own}
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


def add_to_caption(figure: Figure, words: str) -> None:
    """What readers of a figure should know, and see nowhere in it."""
    _CAPTIONS.setdefault(figure, []).append(words)


def tell(figure: Figure, words: str) -> None:
    """What readers of a figure should know: for its caption or, where it has a title, beside it."""
    if has_titles():
        add_notes(figure, [words])
    else:
        add_to_caption(figure, words)


def caption_of(figure: Figure) -> list[str]:
    """All that was added to the caption of a figure, each once."""
    return [*dict.fromkeys(_CAPTIONS.get(figure, []))]


def look() -> Look:
    """The look that figures are drawn in now."""
    return _LOOK.get()


def given() -> Axes | None:
    """The panel that is drawn on, where a figure does not make its own."""
    return _GIVEN.get()


def keep_words(figure: Figure) -> None:
    """Remember which words a figure has in place of others, and those without a place in it."""
    _OWN_WORDS[figure] = dict(_BEFORE.get() or {})
    wanted = [word for word, own in (_WORDS.get() or {}).items() if word != own]
    _UNSAID[figure] = [word for word in wanted if word not in (_MET.get() or ())]


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


def lay_out(figure: Figure) -> None:
    """Give panels, ticks and words their places, as drawing does, which takes longer."""
    engine = figure.get_layout_engine()
    if engine is None:
        figure.draw_without_rendering()
    else:
        engine.execute(figure)


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


UNIT = r"(?: (?:kg|rad|deg|Hz|[NmsJW])(?![A-Za-z])\S*)*"  # of a number before it


def folded(words: str, most: int) -> str:
    """Words in lines of at most so many letters, no formula, number, error nor unit divided."""
    lines = [""]
    for word in re.findall(
        rf"(?:\$[^$]*\$|\S)+(?: \d+(?!\S))?(?: [=±] \S+{UNIT})*(?: \([^()=]*\)$)?", words
    ):
        line = f"{lines[-1]} {word}".strip()
        if len(MARKUP.sub("", line)) <= most or not lines[-1]:
            lines[-1] = line
        else:
            lines.append(word)
    return "\n".join(lines)


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
    figure.align_ylabels()
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
    return min(2.8, max(1.5, 2.8 * math.sqrt(roomy / max(columns, 1))))


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
