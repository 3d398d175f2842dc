"""Marking values at a section and rests, so that each of many starts and families is seen."""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from fiv_cli.plots import points, style
from fiv_cli.plots.clouds import Cloud, part_at
from fiv_cli.plots.drawn import DECORATION

if TYPE_CHECKING:
    from matplotlib.axes import Axes

FINER = 0.3  # share of its size that a mark has in a crowd ...
STILL_SEEN = 0.6  # ... and where it is undecided: upon a line of equilibria, too
BAR = 0.4  # size of a dot times columns, in widths: the widest marks, one in another, are a bar
SIDE_BY_SIDE = 0.3  # ... and of these next to one another
SEEN_ON_LINES = 2.4  # size of dots that lines lead through, where columns have room for them ...
FILLED = 0.75  # ... which is this share of it
APART = 1.9  # size of marks that stand apart, and ...
SHAPES = 24  # ... how many there are of one cloud from one side to the other
INNER = 0.6  # size of a square in a mark: the arms of a cross reach beyond it
OF_ALL = 1.3  # size of the mark of what every start leads to, in dots
MOST_ROWS = 4  # of one cloud whose ends have marks
DOTS_BETWEEN = 4  # marks, or more: at every second place they would look like another sort
# Of the key of marks that stand among dots: these to both sides.
AMONG_DOTS: dict[str, Any] = {"ls": (0, (0.01, 3.85)), "lw": 1.3, "dash_capstyle": "round"}
# Of the key of values that crowd: a row of fine dots.
ROW_OF_DOTS: dict[str, Any] = {"ls": (0, (0.01, 2.0)), "lw": 1.2, "dash_capstyle": "round"}
TURNS = 4  # in which the dots of crowds are drawn: those of several starts are all seen
ONE_PLACE = 0.01  # of the extent of all clouds: values that lie so close are one mark
OVER_ENDS = 4.6  # of marks that lie over those of the ends of branches, and are seen there
EDGE = 0.5  # pt: of marks that lie on lines of another colour
SEEN_BEHIND = 1.2  # share by which dots of the first of many sorts are wider than of the last
SEEN_AMONG = 2.0  # pt: of pale dots in columns beside which others stand
FINEST = 0.6  # pt: of smaller dots nothing is seen in print
WIDER = 0.8  # share by which a dot that lies beneath another is wider, for each of these
THINNED = (
    "marks tell starts at some places alone, and dots all: a greater --width, a narrower xlim or "
    "fewer points have room for more marks"
)
MANY = "many values at one place"
UNSETTLED = "values where undecided"


def mark_clouds(
    ax: Axes, clouds: Sequence[Cloud], columns: int, width: float, settings: points.Settings
) -> None:
    """Marks that show through one another: what comes first is the widest.

    Points at rest have a black square in their mark, since its colour tells something else; not
    those on lines of equilibria, which say so, nor where all rest, as the axis says. An equilibrium
    at which no contact sticks is no rest of what slides. Where marks of so many columns, in a
    figure so wide (inches), would be bars, there are dots, and marks on some of them.
    """
    entries = _entries(clouds)
    count, crowd = sum(one.y.size for one in clouds), sum(int(one.crowded.sum()) for one in clouds)
    many, size = count > style.MANY_MARKS, style.dot_size(columns, width)
    size *= style.finer(count - crowd + sum(one.rest_y.size for one in clouds))
    room = style.POINTS * width / columns
    several = max(entry.number for entry in entries) > 0
    if are_bars := several and size > BAR * room:
        size = max(size, min(SEEN_ON_LINES, FILLED * room))
    elif several:
        size = min(size, SIDE_BY_SIDE * room)
    apart, squares = np.concatenate([one.sticking[~one.told] for one in clouds]), count > 0
    if are_bars or (apart.size and squares):  # beneath a square no dot is seen
        entries = [*map(_no_dot, entries)]
    sorts = 1 + max(entry.number for entry in entries)
    resting = "at rest" if apart.any() else "steady sliding"
    _name_sorts(ax, clouds, entries, APART if are_bars else size, among_dots=are_bars)
    pairs = [*zip(clouds, entries, strict=True)]
    for number, (cloud, entry) in enumerate(pairs):
        if are_bars:
            _mark_beneath(ax, cloud, entry, [other for other, _ in pairs[number + 1 :]], size)
            _mark_finely(ax, cloud, entry, size, resting)
        else:
            _mark_values(ax, cloud, entry, size, sorts, many)
            _mark_rests(ax, cloud, entry, size, sorts, resting, squares, len(pairs) == 1)
    style.add_notes(ax.figure.figure, [*_hidden(pairs)] * (not are_bars))
    if are_bars:
        _mark_some(ax, pairs, sorts, resting, settings, squares)
        style.add_notes(ax.figure.figure, [THINNED])
    for turn, (cloud, entry) in itertools.product(range(TURNS), pairs):
        _mark_crowds(ax, cloud, entry, size, sorts, many, turn)
    heights = np.concatenate([np.append(one.y, one.rest_y) for one in clouds])
    for cloud, entry in pairs:
        _mark_gathered(ax, cloud, entry, float(np.ptp(heights)) if heights.size else 0.0)
    decided = any((one.crowded & ~one.undecided).any() for one in clouds)
    if decided and (sorts > 1 or crowd < count):
        colours = {entry.colour for entry in entries}
        colour = colours.pop() if len(colours) == 1 else style.BLACK
        ax.plot([], [], color=colour, label=MANY, **ROW_OF_DOTS)
    if apart.size and squares:
        square = _of_square(APART if are_bars else size, sorts == 1)
        ax.plot([], [], "s", ms=square, mew=0.0, color=style.BLACK, label=resting)
    _name_undecided(ax, pairs, STILL_SEEN * size)


def _name_undecided(ax: Axes, pairs: Sequence[tuple[Cloud, points.Entry]], size: float) -> None:
    """Legend entry of what is pale."""
    colours = [style.pale(own.colour) for one, own in pairs if one.undecided.any()]
    if colours:
        halves: dict[str, Any] = {"fillstyle": "left", "mfcalt": colours[-1], "ms": size}
        ax.plot([], [], "o", mew=0.0, color=colours[0], label=UNSETTLED, **halves)


def _no_dot(entry: points.Entry) -> points.Entry:
    """With a mark that is told from dots."""
    return replace(entry, number=entry.number + (entry.number >= style.DOT_AMONG_MARKS))


def _hidden(pairs: Sequence[tuple[Cloud, points.Entry]]) -> Iterator[str]:
    """Which clouds lie, mostly, beneath others whose mark is the same: those of runs that agree."""
    for (one, own), (other, its) in itertools.combinations(pairs, 2):
        if own.number == its.number and own.colour != its.colour:
            x, y = np.append(one.x, one.rest_x), np.append(one.y, one.rest_y)
            above = np.append(other.x, other.rest_x), np.append(other.y, other.rest_y)
            hidden = int((points.met_by(x, y, [above]) > 0).sum())
            if 2 * hidden > x.size:
                yield (
                    f"{one.label}: {hidden} of its {x.size} values lie beneath those of "
                    f"{other.label}, whose mark is the same; draw it alone to see them"
                )


def _mark_beneath(
    ax: Axes, cloud: Cloud, entry: points.Entry, later: Sequence[Cloud], size: float
) -> None:
    """Wider dots where those of `later` clouds lie upon those of one: it is seen around them."""
    own, *others = (
        (np.append(one.x[~one.crowded], one.rest_x), np.append(one.y[~one.crowded], one.rest_y))
        for one in (cloud, *later)
    )
    count = points.met_by(*own, others)
    for times in np.unique(count[count > 0]).tolist():
        dots = style.mark_of(0, 1, size * (1.0 + WIDER * times)) | {"ls": "none", "zorder": 1.9}
        here = count == times
        ax.plot(own[0][here], own[1][here], color=entry.colour, label=DECORATION, **dots)


def _mark_finely(ax: Axes, cloud: Cloud, entry: points.Entry, size: float, resting: str) -> None:
    """The values of one cloud that do not crowd, and its points at rest, as dots."""
    untold = replace(entry, label=points.unlisted(entry.label))
    _mark_values(ax, replace(cloud, start=""), untold, size, 1, many=True)  # in no start's mark
    dots = style.mark_of(0, 1, size) | {"ls": "none", "color": entry.colour, "rasterized": True}
    for part, word in ((~cloud.told, resting), (cloud.told, "equilibrium")):
        label = points.unlisted(entry.label, word)
        ax.plot(cloud.rest_x[part], cloud.rest_y[part], zorder=4, label=label, **dots)


def _mark_some(
    ax: Axes,
    pairs: Sequence[tuple[Cloud, points.Entry]],
    sorts: int,
    resting: str,
    settings: points.Settings,
    squares: bool,
) -> None:
    """Marks of clouds at places in turn, as far apart as they are seen as such, and their keys."""
    before = len(ax.lines)
    everything = np.concatenate([np.append(cloud.x, cloud.rest_x) for cloud, _ in pairs])
    shown = _along(_seen(everything, settings), settings)
    most = max(1, min(SHAPES, shown.size // DOTS_BETWEEN))
    apart = float(shown[-1] - shown[0]) / most if shown.size else 0.0
    for turn, (cloud, entry) in enumerate(pairs):
        places = _seen(np.append(cloud.x[~cloud.crowded], cloud.rest_x), settings)
        at = _along(places, settings)
        ends = _ends(at, np.searchsorted(shown, at), apart)
        chosen = [
            *(
                one
                for one in _spread(at, apart, turn * apart / len(pairs))
                if _is_far(at, one, ends, apart)
            ),
            *ends,
        ]
        own = part_at(cloud, places[chosen]) if places.size else cloud
        _mark_values(ax, own, entry, APART, sorts, many=False)
        _mark_rests(ax, own, entry, APART, sorts, resting, squares, len(pairs) == 1)
    for line in ax.lines[before:]:
        label = str(line.get_label())
        # a table has these values as dots; what lies over another mark does so still
        line.set(label=DECORATION, zorder=OVER_ENDS + 0.1 * (line.get_zorder() - 4.0))
        if not label.startswith("_"):
            (key,) = ax.plot([], [])
            key.update_from(line)
            key.set(label=label, **AMONG_DOTS)


def _seen(x: np.ndarray, settings: points.Settings) -> np.ndarray:
    """Rising places that the axis shows."""
    low, high = sorted(points.in_si(end) for end in settings.get("xlim", (-np.inf, np.inf)))
    least = np.finfo(float).tiny if points.is_logarithmic(settings, "x") else low
    return np.unique(x[(max(low, least) <= x) & (x <= high)])


def _along(x: np.ndarray, settings: points.Settings) -> np.ndarray:
    """How far along the axis places lie."""
    return np.log(x) if points.is_logarithmic(settings, "x") else x


def _ends(at: np.ndarray, column: np.ndarray, apart: float) -> list[int]:
    """The first and the last of each long row of places without a gap: dots between are of it."""
    gaps = np.flatnonzero(np.diff(column) > 1)
    rows = zip([0, *(gaps + 1)], [*gaps, at.size - 1], strict=True) if at.size else []
    long = [row for row in rows if at[row[1]] - at[row[0]] > apart]
    return [int(end) for row in long for end in row] if len(long) <= MOST_ROWS else []


def _is_far(at: np.ndarray, one: int, ends: Sequence[int], apart: float) -> bool:
    """Whether a mark has its room beside those at the ends of rows."""
    return all(abs(at[one] - at[end]) >= apart for end in ends)


def _spread(at: np.ndarray, apart: float, off: float) -> list[int]:
    """Some of rising places, as far `off` the first and, or more, `apart` from each other."""
    chosen: list[int] = []
    least = at.min(initial=np.inf) + off
    for number, place in enumerate(at):
        if place >= least or (not chosen and number == at.size - 1):
            chosen.append(number)
            least = place + apart
    return chosen


def _mark_values(
    ax: Axes, cloud: Cloud, entry: points.Entry, size: float, sorts: int, many: bool
) -> None:
    """The values of one cloud that do not crowd, pale and small where undecided.

    The key of a cloud that has no others, and no rests, is a dot as these are.
    """
    apart, undecided = ~cloud.crowded, cloud.undecided
    sizes = size, STILL_SEEN * size
    mark, small = (_mark_of(cloud.start, entry.number, sorts, one) for one in sizes)
    is_crowd = not apart.any() and cloud.crowded.any() and not cloud.rest_x.size
    look: dict[str, Any] = {"ls": "none", "rasterized": many}
    own, pale = entry.colour, style.pale(entry.colour)
    for part, shape, colour, label in (
        (apart & ~undecided, style.mark_of(0, 1, size) if is_crowd else mark, own, entry.label),
        (apart & undecided, {**small, "zorder": 4}, pale, points.unlisted(entry.label, UNSETTLED)),
    ):
        if part.any() or label == entry.label:
            ax.plot(cloud.x[part], cloud.y[part], color=colour, label=label, **shape, **look)


def _mark_crowds(
    ax: Axes,
    cloud: Cloud,
    entry: points.Entry,
    size: float,
    sorts: int,
    many: bool,
    turn: int,
) -> None:
    """The values that crowd and then, in `TURNS`, parts of them again: one cloud is seen through
    another."""
    seen = 1.0 + SEEN_BEHIND * (sorts - 1 - entry.number) / sorts
    fine = seen * max(FINEST, FINER * style.finer(int(cloud.crowded.sum())) * size)
    look = style.mark_of(0, 1, fine) | {"ls": "none", "rasterized": many}
    among = {"zorder": 2.5, "ms": max(float(look["ms"]), SEEN_AMONG)}
    of_turn = cloud.crowded & ((turn == 0) | (np.cumsum(cloud.crowded) % TURNS == turn))
    for part, colour, told, above in (
        (of_turn & ~cloud.undecided, entry.colour, "", {}),
        (of_turn & cloud.undecided, style.pale(entry.colour), UNSETTLED, among),
    ):
        if part.any():
            label = DECORATION if turn else points.unlisted(entry.label, told)
            ax.plot(cloud.x[part], cloud.y[part], color=colour, label=label, **look | above)


def _mark_gathered(ax: Axes, cloud: Cloud, entry: points.Entry, extent: float) -> None:
    """Undecided values that crowd in one place of a figure that reaches so far, as on the way to
    rest: each place has a mark that is seen on a line."""
    here = cloud.crowded & cloud.undecided
    columns = [(x, cloud.y[here & (cloud.x == x)]) for x in np.unique(cloud.x[here])]
    near = [(x, float(np.median(y))) for x, y in columns if np.ptp(y) < ONE_PLACE * extent]
    if near:
        wide: dict[str, Any] = {**style.mark_of(0, 1, SEEN_ON_LINES), "ls": "none", "zorder": 3.8}
        wide |= {"mec": entry.colour, "mew": EDGE}
        ax.plot(*np.transpose(near), color=style.pale(entry.colour), label=DECORATION, **wide)


def _mark_rests(
    ax: Axes,
    cloud: Cloud,
    entry: points.Entry,
    size: float,
    sorts: int,
    resting: str,
    squares: bool,
    alone: bool,
) -> None:
    """The points at rest of one cloud, with `squares` in their mark where no line tells of them.

    A dot lies upon its square, any other mark beneath: what is seen of it is the rest of it. Of a
    cloud that is `alone` there are but squares: the dots would tell nothing, and hide them in rows.
    """
    rest, on_line = ((cloud.rest_x[part], cloud.rest_y[part]) for part in (~cloud.told, cloud.told))
    mark = _mark_of(cloud.start, entry.number, sorts, size)
    look = mark | {"color": entry.colour, "ls": "none"}
    at_rest = points.unlisted(entry.label, resting)
    is_dot = sorts == 1 and cloud.start not in points.SHARED
    square: dict[str, Any] = {"marker": "s", "mew": 0.0, "ls": "none", "color": style.BLACK}
    square |= {"ms": _of_square(size, is_dot), "zorder": 4.1 if is_dot else 4.2}
    if squares:
        ax.plot(*rest, label=at_rest, **square)
        at_rest = DECORATION
    if not (squares and alone and is_dot):
        ax.plot(*rest, label=at_rest, zorder=4.1, **look)
    ax.plot(*on_line, label=points.unlisted(entry.label, "equilibrium"), zorder=4, **look)


def _of_square(size: float, is_dot: bool) -> float:
    """Size of the square of what rests, beneath a dot or in another mark."""
    return size if is_dot else INNER * size


def _mark_of(start: str, number: int, sorts: int, size: float) -> dict[str, Any]:
    """The mark of a start, or of what all of them lead to."""
    if start in points.SHARED:
        return {"marker": "D", "ms": OF_ALL * size, "mew": 0.0}
    return style.mark_of(number, sorts, size)


def _entries(clouds: Sequence[Cloud]) -> list[points.Entry]:
    """A sort of marks for each line; of families from several starts a colour for each family."""
    families = [*dict.fromkeys(cloud.family for cloud in clouds)]
    starts = [*dict.fromkeys(points.stem(cloud.start) for cloud in clouds)]
    starts.sort(key=lambda start: start in points.SHARED)
    if min(len(families), len(starts)) < 2 or "" in starts:
        return points.entries([cloud.label for cloud in clouds])
    colours = points.colours_of(families)
    return [
        points.Entry(
            colours[cloud.family], "-", points.unlisted(points.stem(cloud.label)),
            starts.index(points.stem(cloud.start)), scattered=True,
        )
        for cloud in clouds
    ]  # fmt: skip


def _name_sorts(
    ax: Axes,
    clouds: Sequence[Cloud],
    entries: Sequence[points.Entry],
    size: float,
    among_dots: bool,
) -> None:
    """Legend entries of families, by their colours, and of starts, by their marks."""
    if any(not entry.label.startswith("_") for entry in entries):  # they name themselves
        return
    pairs = [*zip(clouds, entries, strict=True)]
    for family, colour in {cloud.family: entry.colour for cloud, entry in pairs}.items():
        ax.plot([], [], color=colour, label=family, **style.COLOUR_ALONE)
    starts = {points.stem(cloud.start): entry.number for cloud, entry in pairs}
    for start, number in starts.items():
        look = _mark_of(start, number, len(starts), size)
        look |= AMONG_DOTS if among_dots else {"ls": "none"}
        ax.plot([], [], color=style.BLACK, label=start, **look)
