"""Drawing the lines of a curve whose variables share a unit, and what is not sure of them."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from itertools import combinations
from typing import TYPE_CHECKING, Any

import matplotlib as mpl
import numpy as np

from fiv_cli.flags import NOT_COMPUTED
from fiv_cli.plots import branch, labels, points, smooth, style
from fiv_cli.plots.curve_lines import DATASET, DOT, Curve
from fiv_cli.plots.drawn import DECORATION, in_one_line, leave_out
from fiv_cli.reading.datasets import flag_names

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes

CLASS_SHIFT = 0.06
HOLLOW: dict[str, Any] = {"marker": "o", "ms": 3, "mfc": "none", "mew": 0.6, "ls": "none"}
FRAMED = "several, one upon another"
FRAME: dict[str, Any] = {"marker": "s", "ms": 7, "mfc": "none", "mew": 1.2, "ls": "none"}
CAP = 2.0  # half the width of the ends of error bars, pt
UNSEEN = 5e-3  # of all that a panel shows: an error bar that is shorter has no ends
THIN = 2e-3  # of it: lines that lie closer are one to the eye
BRANCH = 1.8  # as wide as other lines, which lie over it: it is seen beside these
BAR: dict[str, Any] = {"lw": 2.5, "alpha": 0.5}
UNSURE = {
    "value of an undecided motion": HOLLOW,
    "undecided points: from least to greatest": BAR,
    "undecided points: at least": {"marker": "^", "ms": 4, "ls": "none"},
    "undecided points: at most": {"marker": "v", "ms": 4, "ls": "none"},
    "undecided points: nothing known": {"marker": "x", "ms": 5, "ls": "none"},
    "error not known": {"marker": "o", "ms": 7, "mfc": "none", "mew": 0.6, "ls": "none"},
}


def draw_panel(
    ax: Axes,
    variables: Mapping[str, xr.DataArray],
    lines: Sequence[tuple[Curve, points.Entry]],
    most: int,
    numeric: bool,
    logarithmic: bool,
) -> bool:
    """The lines of some variables of one unit, against an axis that is `numeric` or of names.

    `most` are the points of the longest line of a figure. Tells whether the ends of some error
    bars are seen.
    """
    extent, barred = _extent([curve for curve, _ in lines], logarithmic), False
    beneath = False
    classes = is_of_classes(variables)
    _name_sorts(ax, [curve for curve, _ in lines if curve.sort])
    lies_below, framed = any(not curve.sort for curve, _ in lines), False
    for place, (curve, entry) in enumerate(_black_where_plain(lines)):
        later = lines[place + 1 :]
        thin = 0.0 if logarithmic else THIN * extent
        over = (_upon(other, (curve, entry), thin) for other in later)
        shares = sum(over, np.zeros(curve.x.size))
        upon = np.floor(shares).astype(int)
        style.add_notes(ax.figure.figure, [*_hidden(curve, upon)])
        # along the axis more would be a bar
        upon[(curve.y == 0.0) & (upon > branch.MOST_BENEATH)] = 0
        # lines of classes lie on one another: each is moved a little
        shift = classes * CLASS_SHIFT * (entry.number - lines[-1][1].number / 2)
        apart = classes or entry.scattered or not numeric
        beneath |= bool(upon.any()) and not apart
        room_for = 0 if curve.of_crossings else most
        if not apart:
            framed |= _frame_hidden(ax, curve, entry, [other for other, _ in later])
        if lies_below and curve.sort and curve.dash == "-":
            curve = replace(curve, mark={**curve.mark, "lw": _width(BRANCH)})
        for named in _each_named(ax, curve, entry, apart, room_for):
            _plot(ax, curve, shift, named, apart, room_for, upon)
            barred |= _plot_errors(ax, curve, shift, named, extent * UNSEEN, logarithmic)
    if beneath:
        style.add_to_caption(ax.figure.figure, "a line beneath others is wider")
    if not classes:
        style.add_notes(ax.figure.figure, [*_of_one_colour(lines)])
    if framed:
        ax.plot([], [], color=style.BLACK, label=FRAMED, **FRAME)
    _name_unsure(ax)
    _name_values(ax, [*variables.values()])
    return barred


def _hidden(curve: Curve, upon: np.ndarray) -> Iterator[str]:
    """What to do about a line on all of which more lines run than it may be wide for."""
    sure = np.isfinite(curve.y) & ~curve.open & ~curve.is_wide
    if curve.label and sure.any() and (upon[sure] > branch.MOST_BENEATH).all():
        yield (
            f"{curve.label}: its line lies beneath {upon[sure].min()} others that have the same "
            "values; select in the figure draws some of them alone"
        )


def _of_one_colour(lines: Sequence[tuple[Curve, points.Entry]]) -> Iterator[str]:
    """That dashed lines fill the gaps of others of their colour, which have the same values."""
    pairs = [
        (one, other)
        for (one, entry), (other, beneath) in combinations(lines, 2)
        if entry.colour == beneath.colour and entry.dash != beneath.dash
        and one.label and other.label and not (one.sort or other.sort)
        and np.array_equal(one.x, other.x) and _is_upon(one, other)
    ]  # fmt: skip
    if pairs:
        one, other = pairs[0]
        more = f", and {len(pairs) - 1} more such pairs" if len(pairs) > 1 else ""
        yield (
            f"{in_one_line(one.label)} and {in_one_line(other.label)}: one line in one colour, for "
            f"they have the same values{more}; select in the figure draws one of them alone"
        )


def _is_upon(one: Curve, other: Curve) -> bool:
    """Whether wherever both lines have values these are the same, and all that one of them has."""
    known = [own.known & ~own.open for own in (one, other)]
    met = known[0] & known[1]
    alone = [bool((own & ~met).any()) for own in known]
    return bool(met.sum() > 1 and not all(alone) and one.agrees_with(other)[met].all())


def _name_sorts(ax: Axes, curves: Sequence[Curve]) -> None:
    """Entries of a legend for what dashes and marks mean."""
    for sort in dict.fromkeys(curve.sort for curve in curves):
        own = sorted((one for one in curves if one.sort == sort), key=lambda one: one.x.size)
        dash = own[-1].dash if own[-1].x.size > 1 else "none"
        mark = {**own[0].mark, **({} if own[0].is_marked else {"marker": "None"})}
        ax.plot([], [], ls=dash, color=style.BLACK, label=sort, **mark)


def _name_unsure(ax: Axes) -> None:
    """Entries of a legend for what is drawn of numbers that are not sure."""
    for told, look in UNSURE.items():
        if any(str(drawn.get_label()).endswith(told) for drawn in (*ax.lines, *ax.collections)):
            ax.plot([], [], color=style.BLACK, label=told, **look)


def _black_where_plain(
    lines: Sequence[tuple[Curve, points.Entry]],
) -> list[tuple[Curve, points.Entry]]:
    """The lines, with black equilibria where it is plain whose they are."""
    of_rests = {curve.label for curve, _ in lines if curve.is_rest}
    of_cycles = {curve.words.get(DATASET) for curve, _ in lines if curve.is_branch}
    plain = len(of_rests) == 1 and len(of_cycles) <= 1
    return [
        (curve, replace(entry, colour=style.BLACK) if plain and curve.is_rest else entry)
        for curve, entry in lines
    ]


def _width(times: float) -> float:
    """So many times that of a line."""
    return float(times * mpl.rcParams["lines.linewidth"])


def is_of_classes(variables: Mapping[str, xr.DataArray]) -> bool:
    """Whether the variables of a panel are classes."""
    return any(flag_names(one.attrs) for one in variables.values())


def _each_named(
    ax: Axes, curve: Curve, entry: points.Entry, apart: bool, most: int
) -> Iterator[points.Entry]:
    """How a line is drawn; under the names of those that it hides it is in tables alone."""
    if len(curve.names) < 2:
        yield entry
        return
    hidden = not apart and _marked_where_seen(ax, curve.y, most)
    look = {**curve.mark, **({"marker": "None"} if hidden else {})}
    dash = "none" if apart else entry.dash
    ax.plot([], [], ls=dash, color=entry.colour, label=entry.label, **look)
    for number, name in enumerate(curve.names):
        before = {*ax.get_children()}
        yield replace(entry, label=points.unlisted(name))
        for artist in {*ax.get_children()} - before if number else ():
            artist.set_visible(False)


def _extent(curves: Sequence[Curve], logarithmic: bool) -> float:
    """From the least to the greatest of what is drawn, errors included; of its logarithm."""
    ends = [end for one in curves for end in (one.y - one.error, one.y + one.error, one.y)]
    heights = np.concatenate([np.zeros(0), *map(np.ravel, ends)])
    heights = heights[np.isfinite(heights)]
    heights = np.log(heights[heights > 0.0]) if logarithmic else heights
    return float(np.ptp(heights)) if heights.size else 0.0


def _upon(
    over: tuple[Curve, points.Entry], under: tuple[Curve, points.Entry], thin: float
) -> np.ndarray:
    """At which points of a line another, of another colour, runs upon it; it counts half if it is
    dashed otherwise: a line is seen through the dashes of one, and not of two."""
    (one, entry), (other, beneath) = over, under
    if entry.colour == beneath.colour or one.sort or not np.array_equal(one.x, other.x):
        return np.zeros(other.x.size)
    hides, off = (1.0, 0.0) if entry.dash == beneath.dash else (0.5, thin)
    met = np.isclose(one.y, other.y, rtol=points.UPON, atol=off) & ~one.open & ~one.is_wide
    met = np.pad(met, 1)
    return np.asarray(hides * (met[1:-1] & (met[2:] | met[:-2])))


def _frame_hidden(ax: Axes, curve: Curve, entry: points.Entry, later: Sequence[Curve]) -> bool:
    """A square about each point of a line that stands alone, and that of a `later` one hides.

    It is the wider the more of these there are. Tells whether there is any.
    """
    alone = points.alone(np.isfinite(curve.y) & ~curve.is_wide)
    x, y = curve.x[alone], curve.y[alone]
    count = points.met_by(x, y, ((other.x, other.y) for other in later))
    for number in np.unique(count[count > 0]).tolist():
        here, wide = count == number, FRAME["ms"] * (1.0 + 0.5 * (number - 1))
        look = {**FRAME, "ms": wide, "color": entry.colour, "label": DECORATION}
        ax.plot(x[here], y[here], **look)
    return bool(count.any())


def _plot(
    ax: Axes,
    curve: Curve,
    shift: float,
    entry: points.Entry,
    apart: bool,
    most: int,
    upon: np.ndarray,
) -> None:
    """One line, wider where others run `upon` it; none between points that stand `apart`.

    What starts lead to lies over the branches that tell of it.
    """
    y = np.where(curve.is_wide, np.nan, curve.y) + shift
    look = {"color": entry.colour, "zorder": 1.9 if curve.sort else 2.0, **curve.mark}
    if curve.is_branch and curve.dash == "-":  # it is seen beneath what starts lead to
        look["lw"] = _width(2)
    known = np.where(curve.open, np.nan, y)
    x, cut = (np.insert(one, curve.jumps, np.nan) for one in (curve.x, known))
    dash = curve.dash if curve.sort else entry.dash
    label = points.unlisted(entry.label, curve.sort) if curve.sort else entry.label
    way = curve.whole_way + shift
    if not apart:
        seen = _marked_where_seen(ax, way, most, curve.short)
        look |= seen if curve.is_marked else {"marker": "None"}
    for count in (
        range(1, 1 + min(int(upon.max(initial=0)), branch.MOST_BENEATH)) if not apart else ()
    ):
        beneath = np.insert(np.where(upon >= count, known, np.nan), curve.jumps, np.nan)
        wide: dict[str, Any] = {"lw": _width(1 + count), "color": entry.colour}
        ax.plot(x, beneath, ls=dash, label=DECORATION, **wide)
    if curve.way.size and not apart:
        ax.plot([], [], ls=dash, label=label, **look)
        ax.plot(x, way, ls=dash, label=DECORATION, **{**look, "marker": "None"})
        dash, label = "none", points.unlisted(label)
    elif "markevery" in look and curve.short == 1 and not curve.sort and _has_pieces(way):
        ax.plot([], [], ls=dash, color=entry.colour, label=label)  # its points alone have marks
        label = points.unlisted(label)
    if curve.is_branch and not apart:
        smooth.draw(ax, x, cut, label, ls=dash, **look)
    else:
        (line,) = ax.plot(x, cut, ls="none" if apart else dash, label=label, **look)
        leave_out(line, curve.between)
        if curve.between.size and "markevery" not in look:  # marks are of what was computed
            line.set_markevery(np.flatnonzero(~np.isin(x, curve.between[:, 0])).tolist())
    if curve.sort:  # the colour alone
        ax.plot([], [], color=entry.colour, marker="s", ls="none", label=entry.label)
    _plot_unsure(ax, curve, shift, entry)


def _has_pieces(way: np.ndarray) -> bool:
    """Whether a line leads from some point to the next."""
    known = np.isfinite(way)
    return bool((known[1:] & known[:-1]).any())


def _plot_errors(
    ax: Axes,
    curve: Curve,
    shift: float,
    entry: points.Entry,
    least_seen: float,
    logarithmic: bool,
) -> bool:
    """The error bars of a line, without ends where these are too near; whether some have ends."""
    y = np.where(curve.is_wide, np.nan, curve.y) + shift
    off = np.where(np.isfinite(curve.error), curve.error, np.nan)
    bounded = curve.is_wide & np.isfinite(curve.ends).all(axis=0) & (off > 0.0)
    low, high = (np.where(bounded, end, 0.0) for end in curve.ends)
    y = np.where(bounded, 0.5 * (low + high) + shift, y)
    off = np.where(bounded, off + 0.5 * (high - low), off)  # beyond both of what may be
    if not np.nan_to_num(off).any():
        return False
    least, most = curve.limits
    both = np.stack([np.minimum(off, y - least), np.minimum(off, most - y)])
    bars = ax.errorbar(curve.x, y, both, fmt="none", ecolor=entry.colour, lw=0.8, capsize=CAP)
    _, caps, (lengths,) = bars.lines
    lengths.set_label(points.unlisted(entry.label, "error bar"))
    wide = np.flatnonzero(off > least_seen * (np.abs(y) if logarithmic else 1.0))
    for cap in caps:
        cap.set(label=DECORATION, markevery=wide.tolist())
    return bool(wide.size)


def _marked_where_seen(ax: Axes, heights: np.ndarray, most: int, short: int = 1) -> dict[str, Any]:
    """Marks at all points; where these would hide a line, at those alone that no line meets, or one
    of no more than `short` points.

    `most` are the points of the longest of the lines that look alike.
    """
    known, room = (
        np.isfinite(heights),
        style.ACROSS * ax.figure.figure.get_figwidth() * style.POINTS,
    )
    if max(most, np.count_nonzero(known)) * DOT["ms"] < room:
        return {}
    alone = np.flatnonzero(points.alone(known, short)).tolist()
    return {"markevery": alone} if alone else {"marker": "None"}


def has_marks(ax: Axes, curve: Curve, most: int) -> bool:
    """Whether some points of a line are marked."""
    look = _marked_where_seen(ax, curve.whole_way, most, curve.short)
    return curve.is_marked and look.get("marker") != "None"


def _plot_unsure(ax: Axes, curve: Curve, shift: float, entry: points.Entry) -> None:
    """What is no sure number: hollow or, in the ways of `UNSURE`, all that it may be."""
    low, high = curve.ends
    has_low, has_high = (curve.is_wide & np.isfinite(end) for end in curve.ends)
    bounded, unknown = has_low & has_high, curve.is_wide & ~has_low & ~has_high
    hollow, bar, least, greatest, nothing, far = UNSURE
    known = ~curve.is_wide & ~curve.open
    for told, at, y in (
        (hollow, curve.open, curve.y + shift),
        (least, has_low & ~has_high, low),
        (greatest, has_high & ~has_low, high),
        (nothing, unknown, 0.0 * curve.x),
        (far, known & np.isinf(curve.error), curve.y + shift),
    ):
        if np.isfinite(y[at]).any():
            label = points.unlisted(entry.label, told)
            where = ax.get_xaxis_transform() if told == nothing else ax.transData
            ax.plot(curve.x[at], y[at], color=entry.colour, label=label, transform=where,
                    clip_on=told != nothing, **UNSURE[told])  # fmt: skip
    if bounded.any():
        label = points.unlisted(entry.label, bar)
        ax.vlines(curve.x[bounded], low[bounded], high[bounded], entry.colour, label=label, **BAR)


def _name_values(ax: Axes, variables: Sequence[xr.DataArray]) -> None:
    """What stands beside the values: the name of one variable, the names of classes."""
    several = len(variables) > 1
    ax.set_ylabel(labels.shared_label(variables) if several else labels.axis_label(variables[0]))
    classes = {c: n for c, n in flag_names(variables[0].attrs).items() if n != NOT_COMPUTED}
    if classes:
        ax.set_yticks(list(classes), labels=[word.replace("_", " ") for word in classes.values()])
