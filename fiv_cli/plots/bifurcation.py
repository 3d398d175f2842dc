"""Bifurcation diagram: what the motion passes at the Poincaré section, against a parameter.

Where a motion rests it is drawn at its value. What no motion comes to, as all that is unstable,
other analyses of the case know: equilibria an `eigenvalues` analysis, cycles a `cycle` analysis, or
the dataset of a branch that is drawn with it; where equilibria turn stable a `critical` one.
"""

from __future__ import annotations

import itertools
import json
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import reduce
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.lines import Line2D

from fiv_cli.errors import EmptyFigureError, UsageError
from fiv_cli.flags import CYCLE_END, NOT_COMPUTED, SECTION
from fiv_cli.plots import branch, labels, points, smooth, style
from fiv_cli.plots.drawn import DECORATION, UNNAMED, leave_out
from fiv_cli.plots.turns import up_to_turns
from fiv_cli.reading import select
from fiv_cli.reading.datasets import class_names, is_class, numbers

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from matplotlib.typing import ColorType

DEFAULT = "section_value"
CROWD = 8  # values at one point of the grid; more are drawn smaller: their marks would be a bar
FINER = 0.3  # share of its size that a mark has in a crowd ...
UNMET = (
    "stable cycles that never meet the section are not drawn; one that all motions have, such as "
    'section = {{ zero = "{}_dot" }} in the cases of cycles and diagram, has them'
)
STILL_SEEN = 0.6  # ... and where it is undecided: upon a line of equilibria, too
BAR = 0.4  # size of a dot times columns, in widths: the widest marks, one in another, are a bar
SEEN_ON_LINES = 2.4  # size of dots that lines lead through, where columns have room for them ...
FILLED = 0.75  # ... which is this share of it
APART = 1.9  # size of marks that stand apart, and ...
SHAPES = 24  # ... how many there are of one cloud from one side to the other
MOST_ROWS = 4  # of one cloud whose ends have marks
DOTS_BETWEEN = 4  # marks, or more: at every second place they would look like another sort
# Of the key of marks that stand among dots: these to both sides.
AMONG_DOTS: dict[str, Any] = {"ls": (0, (0.01, 3.5)), "lw": 1.3, "dash_capstyle": "round"}
TURNS = 4  # in which the dots of crowds are drawn: those of several starts are all seen
ONE_PLACE = 0.01  # of the extent of a cloud: values that lie so close are one mark
SEEN_BEHIND = 1.2  # share by which dots of the first of many sorts are wider than of the last
FINEST = 0.6  # pt: of smaller dots nothing is seen in print
UNSETTLED = "values where undecided"
BEYOND = 0.05  # of its length: what is seen beyond an axis
# Of changes of cycles: full, since the hollow marks are those of starts.
CHANGE: dict[str, Any] = {"mec": "white", "mew": 0.4, "ms": 4.0, "ls": "none"}
SECTION_WORDS = {
    "slip_to_stick": r"slip $\to$ stick",
    "stick_to_slip": r"stick $\to$ slip",
    "turning_point": "a turning point",
    "impact": "an impact",
}
PASSING = {"up": ", rising", "down": ", falling", "both": ""}
EQUILIBRIA = {"stable": ("-", 0.7), "unstable": (":", 1.1), "neutral": ("-.", 0.7)}
TURNS_HERE = "equilibrium turns unstable"
TURN: dict[str, Any] = {"marker": "|", "ms": 9.0, "mew": 1.6, "ls": "none", "zorder": 4.7}
SAME = 1e-6  # relative distance of values of one motion
ALIKE = 1e-3  # of heights that are the same in a figure


def suits(dataset: xr.Dataset) -> bool:
    """Whether the dataset holds section values along some axis; a branch is another figure."""
    along_axes = DEFAULT in dataset and bool(points.varying_axes(dataset))
    return along_axes and not branch.suits(dataset)


def draw(layers: Sequence[points.Layer], settings: points.Settings) -> Figure:
    """Marks of every layer, one sort for each start or further axis, and lines of cycles."""
    name = points.one_variable(settings, DEFAULT)
    holding = [layer for layer in layers if name in layer.dataset]
    shown = [layer for layer in holding if not branch.suits(layer.dataset)] or holding
    shown = shown if len(shown) > 1 else [replace(one, label="") for one in shown]
    if not shown:
        raise UsageError(
            f"{name}: no values at a section in this dataset (or part of one)\n"
            "a bifurcation diagram needs a response analysis; draw another variable as a curve"
        )
    first = shown[0].dataset
    others = [one for layer in layers for one in (layer.dataset, *layer.beside)]
    unmet = False
    axis, observed = points.abscissa(first, settings), _observed(first[name])
    equilibria = [_equilibria(layer, others, axis, observed) for layer in shown]
    changes = [_changes(layer, others, axis, observed) for layer in shown]
    found = [
        cloud
        for layer, lines in zip(shown, equilibria, strict=True)
        for cloud in _shared_apart([*_clouds(layer, name, _all_of(lines), settings)])
    ]
    clouds = [cloud for cloud in found if cloud.y.size or cloud.rest_y.size]
    points.refuse_empty(first, bool(clouds), name)
    figure, (ax,) = style.new_panels(1, 1, points.title(*(one.dataset for one in shown)))
    _refuse_of_none(layers, shown)
    for layer in layers:
        if not any(layer.dataset is one.dataset for one in shown):
            _refuse_apart(layer, shown, axis, observed)
    before = len(ax.lines)
    _mark(ax, clouds, axis.size, figure.get_figwidth(), settings)
    marked = len(ax.lines)
    along = [one for one in others if branch.is_along(one, str(axis.name), observed)]
    settings = _as_the_grid(settings, axis, along)
    for layer in shown:  # a dataset that belongs to several is drawn with the first of them
        parts = [of_the_same(one, layer.dataset) for one in others]
        own = [part for part in parts if part is not None]
        others = [one for one, part in zip(others, parts, strict=True) if part is None]
        unmet |= _draw_cycles(ax, own, axis, layer, name)
    drawn = [
        _draw_equilibria(ax, layer, lines, found_at, axis)
        for layer, lines, found_at in zip(shown, equilibria, changes, strict=True)
    ]
    if any(shares for _, shares in drawn):
        _mark_turns(ax, [turn for turns, _ in drawn for turn in turns])
    words = _section_words(shown) if any(cloud.y.size for cloud in clouds) else "rest"
    ax.set_ylabel(labels.axis_label(first[name]).replace("the section", words))
    others_at = _mark_other_sections(ax, [layer.dataset for layer in shown], settings)
    sorts = [cloud.family or cloud.label for cloud in clouds]
    notes = [*_of_other_sections(others_at, axis, observed), *points.of_many_lines(sorts)]
    notes += [UNMET.format(observed)] * unmet
    style.add_notes(figure, notes)
    if not clouds[0].label:
        _name_alone(ax.lines[before:marked], _start_of(first))
        if style.told_in([ax])[1] or points.gaps(first) or points.ended(first):  # a legend anyway
            ax.lines[before].set_label(_start_of(first))
    points.dress([ax], shown, [settings])
    return figure


def _name_alone(lines: Sequence[Line2D], name: str) -> None:
    """Give what has no name in a table the name of all of them."""
    for line in lines:
        if str(line.get_label()) == "_" or str(line.get_label()).startswith(UNNAMED):
            line.set_label(points.unlisted(name))


def _start_of(diagram: xr.Dataset) -> str:
    """What the only dots of a diagram are called."""
    alone = diagram.sizes.get("initial", 1) == 1 and "initial" in diagram.coords
    return f"start: {diagram['initial'].item()}" if alone else "section values"


@dataclass(frozen=True)
class _Cloud:
    """One line of points: what their motions pass at the section, and where they are at rest.

    `family` says at which values of other axes, `start` from which start. `crowded` are the values
    at points that have many, `undecided` those of points of no class. `told` are the rests through
    which a line of equilibria is drawn, `sticking` those at which a contact sticks.
    """

    family: str
    start: str
    x: np.ndarray
    y: np.ndarray
    crowded: np.ndarray
    undecided: np.ndarray
    rest_x: np.ndarray
    rest_y: np.ndarray
    told: np.ndarray
    sticking: np.ndarray

    @property
    def label(self) -> str:
        """Where it is of which start."""
        return points.joined(self.family, self.start)


def _clouds(
    layer: points.Layer, name: str, equilibria: xr.DataArray, settings: points.Settings
) -> Iterator[_Cloud]:
    """The lines of points of one dataset, a line for each start and value of the other axes.

    `equilibria` are the heights of those that are drawn as lines.
    """
    dataset = layer.dataset
    sizes = select.row_sizes(dataset, name)
    if sizes is None:
        raise UsageError(f"{name}: no values at a section\nnext: draw it as a curve")
    axis = points.abscissa(dataset, settings)
    dim, dims = str(axis.dims[0]), [str(d) for d in sizes.dims]
    point = select.row_of_each(sizes)
    place = dict(zip(dims, np.unravel_index(point, sizes.shape), strict=True))
    crowded = sizes.values.ravel()[point] > CROWD
    doubt = points.gaps(dataset).get("undecided", sizes < 0).transpose(*dims).values.ravel()
    undecided = doubt[point]
    x, y, rest = points.positions(axis), dataset[name].values, _rest(dataset, name)
    told, sticking = abs(rest - equilibria) <= ALIKE * abs(equilibria), _sticking(dataset)
    for line in points.lines(dataset, [dim], dims):
        belongs = np.logical_and.reduce(
            [place[d] == index for d, index in line.index.items()], initial=True
        ) & np.ones(y.shape, bool)
        still, on_line, sticks = (one.isel(line.index).values for one in (rest, told, sticking))
        known = np.isfinite(still)
        values = [word for dim, word in line.words.items() if dim != "initial"]
        family, start = points.joined(layer.label, *values), line.words.get("initial", "")
        at_section = x[place[dim][belongs]], y[belongs], crowded[belongs], undecided[belongs]
        at_rest = x[known], still[known], on_line[known], sticks[known]
        yield _Cloud(family, start, *at_section, *at_rest)


def _shared_apart(clouds: Sequence[_Cloud]) -> Iterator[_Cloud]:
    """With a cloud of its own for what all starts lead to: their marks would be a tangle."""
    for _, group in itertools.groupby(clouds, lambda cloud: cloud.family):
        family = [*group]
        starts = {points.stem(cloud.start) for cloud in family}
        shared = _where_alike(family) if 1 < len(starts) == len(family) else np.zeros(0)
        yield from (_at(cloud, shared, without=True) for cloud in family)
        if shared.size:
            yield replace(_at(family[0], shared), start=points.SHARED[len(starts) > 2])


def _where_alike(clouds: Sequence[_Cloud]) -> np.ndarray:
    """The places at which all have the same values, and rest alike."""
    places = np.unique(np.concatenate([clouds[0].x, clouds[0].rest_x]))
    heights = np.concatenate([own for one in clouds for own in (one.y, one.rest_y)])
    off = SAME * np.abs(heights).max(initial=0.0)
    alike = [
        all(len(one) == len(first) and np.allclose(one, first, SAME, off) for one in others)
        for first, *others in zip(*(_told_at(cloud, places) for cloud in clouds), strict=True)
    ]
    return places[np.array(alike, bool)]


def _told_at(cloud: _Cloud, places: np.ndarray) -> list[np.ndarray]:
    """What a cloud has at each place: how many values, these, of a class or not, and its rests."""
    order = np.lexsort([cloud.y, cloud.x])
    passed = np.column_stack([cloud.y, cloud.undecided])[order]
    ends = (np.searchsorted(cloud.x[order], places, side) for side in ("left", "right"))
    return [
        np.concatenate([[end - begin], *passed[begin:end].T, cloud.rest_y[cloud.rest_x == place]])
        for place, begin, end in zip(places, *ends, strict=True)
    ]


def _at(cloud: _Cloud, places: np.ndarray, *, without: bool = False) -> _Cloud:
    """The part of a cloud at some places, or `without` these."""
    passed, rests = (np.isin(own, places) != without for own in (cloud.x, cloud.rest_x))
    of_values = {n: getattr(cloud, n)[passed] for n in ("x", "y", "crowded", "undecided")}
    of_rests = {n: getattr(cloud, n)[rests] for n in ("rest_x", "rest_y", "told", "sticking")}
    return replace(cloud, **of_values, **of_rests)


def _observed(variable: xr.DataArray) -> str:
    """The state that a variable at the section is about: the first of its words."""
    return str(variable.attrs.get("long_name", "")).split(" ")[0]


def _rest(dataset: xr.Dataset, name: str) -> xr.DataArray:
    """Where each point rests, NaN where it does not."""
    extreme = f"{_observed(dataset[name])}_max"
    if extreme not in dataset or "attractor" not in dataset:
        return dataset["status"] * np.nan
    return dataset[extreme].where(is_class(dataset["attractor"], ("equilibrium",)))


def _sticking(dataset: xr.Dataset) -> xr.DataArray:
    """Where some contact sticks, or nothing is known of that."""
    share = dataset.get("stick_fraction", dataset["status"] * np.nan)
    return ~(share.max([d for d in share.dims if d not in dataset["status"].dims]) <= 0.0)


def _mark(
    ax: Axes, clouds: Sequence[_Cloud], columns: int, width: float, settings: points.Settings
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
    are_bars = max(entry.number for entry in entries) > 0 and size > BAR * room
    if are_bars:
        entries, size = [*map(_no_dot, entries)], max(size, min(SEEN_ON_LINES, FILLED * room))
    sorts = 1 + max(entry.number for entry in entries)
    apart, squares = np.concatenate([one.sticking[~one.told] for one in clouds]), count > 0
    resting = "at rest" if apart.any() else "steady sliding"
    _name_sorts(ax, clouds, entries, APART if are_bars else size, among_dots=are_bars)
    pairs = [*zip(clouds, entries, strict=True)]
    for cloud, entry in pairs:
        if are_bars:
            _mark_finely(ax, cloud, entry, size, resting)
        else:
            _mark_values(ax, cloud, entry, size, sorts, many)
            _mark_rests(ax, cloud, entry, size, sorts, resting, squares)
    if are_bars:
        _mark_some(ax, pairs, sorts, resting, settings, squares)
    for turn, (cloud, entry) in itertools.product(range(TURNS), pairs):
        _mark_crowds(ax, cloud, entry, size, sorts, many, turn)
    if apart.size and squares:
        ax.plot([], [], "s", mew=0.0, color=style.BLACK, label=resting)
    _name_undecided(ax, pairs)


def _name_undecided(ax: Axes, pairs: Sequence[tuple[_Cloud, points.Entry]]) -> None:
    """Legend entry of what is pale."""
    colours = [style.pale(own.colour) for one, own in pairs if one.undecided.any()]
    if colours:
        halves: dict[str, Any] = {"fillstyle": "left", "mfcalt": colours[-1]}
        ax.plot([], [], "o", mew=0.0, color=colours[0], label=UNSETTLED, **halves)


def _no_dot(entry: points.Entry) -> points.Entry:
    """With a mark that is told from dots."""
    return replace(entry, number=entry.number + (entry.number >= style.DOT_AMONG_MARKS))


def _mark_finely(ax: Axes, cloud: _Cloud, entry: points.Entry, size: float, resting: str) -> None:
    """The values of one cloud that do not crowd, and its points at rest, as dots."""
    _mark_values(ax, cloud, replace(entry, label=points.unlisted(entry.label)), size, 1, many=True)
    dots = style.mark_of(0, 1, size) | {"ls": "none", "color": entry.colour, "rasterized": True}
    for part, word in ((~cloud.told, resting), (cloud.told, "equilibrium")):
        label = points.unlisted(entry.label, word)
        ax.plot(cloud.rest_x[part], cloud.rest_y[part], zorder=4, label=label, **dots)


def _mark_some(
    ax: Axes,
    pairs: Sequence[tuple[_Cloud, points.Entry]],
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
        own = _at(cloud, places[chosen]) if places.size else cloud
        _mark_values(ax, own, entry, APART, sorts, many=False)
        _mark_rests(ax, own, entry, APART, sorts, resting, squares)
    for line in ax.lines[before:]:
        label = str(line.get_label())
        line.set_label(DECORATION)  # a table has these values as dots
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
    ax: Axes, cloud: _Cloud, entry: points.Entry, size: float, sorts: int, many: bool
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
    cloud: _Cloud,
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
    of_turn = cloud.crowded & ((turn == 0) | (np.cumsum(cloud.crowded) % TURNS == turn))
    for part, colour, told in (
        (of_turn & ~cloud.undecided, entry.colour, ""),
        (of_turn & cloud.undecided, style.pale(entry.colour), UNSETTLED),
    ):
        if part.any():
            label = DECORATION if turn else points.unlisted(entry.label, told)
            ax.plot(cloud.x[part], cloud.y[part], color=colour, label=label, **look)
    if not turn and (gathered := _gathered(cloud)).size:
        wide: dict[str, Any] = {**style.mark_of(0, 1, SEEN_ON_LINES), "ls": "none", "zorder": 3.8}
        ax.plot(*gathered, color=style.pale(entry.colour), label=DECORATION, **wide)


def _gathered(cloud: _Cloud) -> np.ndarray:
    """Undecided values that crowd in one place, as on the way to rest, shape (2, places)."""
    here = cloud.crowded & cloud.undecided
    whole = np.ptp([*cloud.y, *cloud.rest_y]) if here.any() else 0.0
    columns = [(x, cloud.y[here & (cloud.x == x)]) for x in np.unique(cloud.x[here])]
    near = [(x, float(np.median(y))) for x, y in columns if np.ptp(y) < ONE_PLACE * whole]
    return np.array(near).T


def _mark_rests(
    ax: Axes,
    cloud: _Cloud,
    entry: points.Entry,
    size: float,
    sorts: int,
    resting: str,
    squares: bool,
) -> None:
    """The points at rest of one cloud, with `squares` in their mark where no line tells of them."""
    rest, on_line = ((cloud.rest_x[part], cloud.rest_y[part]) for part in (~cloud.told, cloud.told))
    mark = _mark_of(cloud.start, entry.number, sorts, size)
    look = mark | {"color": entry.colour, "ls": "none"}
    around: dict[str, Any] = {"ms": 1.9 * size, "mfc": "none", "mew": 0.25 * size}
    at_rest = points.unlisted(entry.label, resting)
    if squares:
        square: dict[str, Any] = {
            "marker": "s",
            "ms": size,
            "mew": 0.0,
            "ls": "none",
            "color": style.BLACK,
        }
        ax.plot(*rest, label=at_rest, zorder=4.1, **square)
        at_rest = DECORATION
    rings = around if squares and cloud.start in points.SHARED else {}
    ax.plot(*rest, label=at_rest, zorder=4.1, **look | rings)
    ax.plot(*on_line, label=points.unlisted(entry.label, "equilibrium"), zorder=4, **look)


def _mark_of(start: str, number: int, sorts: int, size: float) -> dict[str, Any]:
    """The mark of a start, or of what all of them lead to."""
    if start in points.SHARED:
        return {"marker": "D", "ms": size, "mew": 0.0}
    return style.mark_of(number, sorts, size)


def _entries(clouds: Sequence[_Cloud]) -> list[points.Entry]:
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
    clouds: Sequence[_Cloud],
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


def _mark_other_sections(
    ax: Axes, datasets: Sequence[xr.Dataset], settings: points.Settings
) -> list[float]:
    """A line across where the section that motions choose changes: values jump there with it."""
    met = {place for dataset in datasets for place in _other_sections(dataset, settings)}
    places = sorted(met)
    for number, place in enumerate(places):
        label = points.unlisted("another section") if number else "another section"
        ax.axvline(place, color=style.GREY, ls=":", lw=1.0, zorder=1, label=label)
    return places


def _of_other_sections(places: Sequence[float], axis: xr.DataArray, observed: str) -> list[str]:
    """What to ask for where values of other sections stand side by side."""
    if not places:
        return []
    where = ", ".join(f"{place:.4g}" for place in places[:3]) + ", ..." * (len(places) > 3)
    zero = "STATE" if observed.endswith("_dot") else f"{observed}_dot"
    one = f'section = {{ zero = "{zero}" }} in the analysis, say, is one for all'
    return [f"the section changes at {axis.name} = {where}, and values jump there; {one}"]


def _other_sections(dataset: xr.Dataset, settings: points.Settings) -> Iterator[float]:
    """The middles between neighbours along the axis whose motions have different sections."""
    if "section_kind" not in dataset:
        return
    axis = points.abscissa(dataset, settings)
    x, dim = points.positions(axis), str(axis.dims[0])
    contact = numbers(dataset["section_contact"]).fillna(0)
    chosen = numbers(dataset["section_kind"]) + len(SECTION.codes) * contact
    for line in points.lines(dataset, [dim], [str(d) for d in chosen.dims]):
        section = chosen.isel(line.index).values
        met = np.flatnonzero(np.isfinite(section))
        for one, other in itertools.pairwise(met.tolist()):
            if section[one] != section[other]:
                yield float(0.5 * (x[one] + x[other]))


# --- what motions do not show ---------------------------------------------------------------------
def of_the_same(dataset: xr.Dataset, diagram: xr.Dataset) -> xr.Dataset | None:
    """The part of a dataset at what a diagram holds fixed; None: it has no such."""
    known, chosen = _axes_and_numbers(dataset), _choices(dataset)
    fixed = _numbers_held(diagram, known) | _choices(diagram)
    spread = {n: value for n, value in fixed.items() if n in known and known[n].size > 1}
    for name, value in fixed.items():
        if name not in spread and not _agree(chosen.get(name, known.get(name, value)), value):
            return None
    try:
        return select.subset(dataset, spread, nearest=False)
    except select.SelectionError:
        return None


def _axes_and_numbers(dataset: xr.Dataset) -> dict[str, xr.DataArray]:
    return {str(name): coord for name, coord in dataset.coords.items() if coord.ndim < 2}


def _numbers_held(diagram: xr.Dataset, known: Mapping[str, xr.DataArray]) -> dict[str, Any]:
    return {
        name: coord.item()
        for name, coord in _axes_and_numbers(diagram).items()
        if coord.size == 1 and coord.dtype.kind in "fiu" and name in known
    }


def _choices(dataset: xr.Dataset) -> dict[str, Any]:
    """Law and options of a dataset, where each is one."""
    told = json.loads(dataset.attrs.get("options_json", "{}"))
    told |= {"friction": dataset.attrs["law"]} if "law" in dataset.attrs else {}
    axes = {name: dataset[name] for name in told if name in dataset.coords}
    return {
        name: axes[name].item() if name in axes else value
        for name, value in told.items()
        if name not in axes or axes[name].size == 1
    }


def _agree(one: Any, other: Any) -> bool:
    """Whether two names, or two numbers, are the same."""
    return bool(one == other if isinstance(other, str) else np.isclose(one, other, atol=0.0))


def _as_the_grid(
    settings: points.Settings, axis: xr.DataArray, branches: Sequence[xr.Dataset]
) -> points.Settings:
    """Limits of the abscissa where branches lead beyond the grid, and what happens to them."""
    if "xlim" in settings or not branches:
        return settings
    reached = np.concatenate([one[branch.ALONG].values for one in branches])
    logarithmic = points.is_logarithmic(settings, "x")
    places = np.concatenate([axis.values, *map(branch.changes, branches)])
    places = places[places > 0.0] if logarithmic else places
    low, high = np.nanmin(places, initial=np.inf), np.nanmax(places, initial=-np.inf)
    if (low <= np.nanmin(reached) and np.nanmax(reached) <= high) or not high > low:
        return settings
    if logarithmic:
        margin = (high / low) ** BEYOND
        return {**settings, "xlim": (low / margin, high * margin)}
    margin = BEYOND * (high - low)
    return {**settings, "xlim": (low - margin, high + margin)}


def _refuse_of_none(layers: Sequence[points.Layer], shown: Sequence[points.Layer]) -> None:
    """EmptyFigureError of a branch that is none, or with no diagram of its parameters."""
    for layer in layers:
        if not branch.suits(layer.dataset):
            continue
        if not layer.dataset[branch.ALONG].size:
            raise EmptyFigureError(
                f"{layer.label}: no cycle was found, so there is no branch to lay over them\n"
                "next: fiv show FILE.nc says why; the diagram alone: fiv plot of its file"
            )
        if all(of_the_same(layer.dataset, one.dataset) is None for one in shown):
            raise EmptyFigureError(
                f"the branch {layer.label} is of other parameters than the bifurcation diagrams\n"
                "next: draw it with a diagram of its own parameters, or alone: --figure branch"
            )


def _refuse_apart(
    layer: points.Layer, shown: Sequence[points.Layer], axis: xr.DataArray, observed: str
) -> None:
    """UsageError of a dataset of which the diagrams show nothing."""
    parts = (
        of_the_same(one, diagram.dataset)
        for one in (layer.dataset, *layer.beside)
        for diagram in shown
    )
    if not any(part is not None and _has_part(part, axis, observed) for part in parts):
        raise UsageError(
            f"{layer.label}: nothing that a bifurcation diagram along {axis.name} shows\n"
            "next: draw it alone (fiv plot FILE.nc); what would be shown are section values, and "
            "at the same parameters, along the same axis, answers of `cycle` and `eigenvalues`"
        )


def _has_part(dataset: xr.Dataset, axis: xr.DataArray, observed: str) -> bool:
    """Whether there are cycles or eigenvalues along an axis of diagrams."""
    told = "cycle_period" in dataset or {"stable", "growth_rate"} <= {*dataset}
    is_along = axis.name in dataset.coords and told
    is_along |= bool(_critical(dataset, axis).size)
    return is_along or branch.is_along(dataset, str(axis.name), observed)


def _critical(dataset: xr.Dataset, axis: xr.DataArray) -> np.ndarray:
    """Where along an axis modes turn stable or unstable; none of what has other axes as well."""
    if "critical_value" not in dataset or dataset["critical_value"].dims != ("crossing",):
        return np.zeros(0)
    found = dataset["critical_value"].dropna("crossing")
    is_along = str(found.attrs.get("long_name", "")).endswith(f" of {axis.name}")
    return np.sort(found.values) if is_along else np.zeros(0)


def _changes(
    layer: points.Layer, others: Sequence[xr.Dataset], axis: xr.DataArray, observed: str
) -> np.ndarray:
    """Where along an axis the equilibria of a diagram change, as another analysis found it.

    That is a critical value or, where there is none, at which a cycle shrinks to one of them.
    """
    same = (of_the_same(one, layer.dataset) for one in (*layer.beside, *others))
    parts = [part for part in same if part is not None]
    found = [_critical(part, axis) for part in parts]
    found += [
        branch.births(part) for part in parts if branch.is_along(part, str(axis.name), observed)
    ]
    return next((changes for changes in found if changes.size), np.zeros(0))


def _draw_cycles(
    ax: Axes,
    datasets: Sequence[xr.Dataset],
    axis: xr.DataArray,
    layer: points.Layer,
    name: str,
) -> bool:
    """Every cycle along `axis`, in the colour of its diagram: what it passes at the section.

    Of a cycle that is not known there the least and the greatest, and only if it is not stable: the
    marks of a stable one lie elsewhere. Tells whether one that is stable never meets the section.
    """
    unmet = False
    observed = _observed(layer.dataset[name])
    extremes = f" cycle: extremes of ${labels.symbol_of_name(observed)}$"
    colours = points.colours([ax])
    for dataset in datasets:
        at_section = name == DEFAULT and _of_one_section(dataset, layer.dataset)
        for own, (word, x, heights, passes) in _cycles(dataset, axis, observed, at_section):
            if word not in branch.DASHES or (word == "stable" and not passes):
                unmet |= at_section and word == "stable"
                continue
            told = f"{word}{' cycle' if passes else extremes}"
            place, colour = _whose(layer, own, axis, colours)
            look: dict[str, Any] = {"ls": branch.DASHES[word], "lw": 1.2, "zorder": 1.5}
            if told not in [line.get_label() for line in ax.lines]:
                ax.plot([], [], color=style.BLACK, label=told, **look)
            for height in heights:
                smooth.draw(ax, x, height, points.unlisted(place, told), color=colour, **look)
                alone = points.alone(np.isfinite(height))  # no line leads there
                fill = colour if word == "stable" else "none"
                dot: dict[str, Any] = {"marker": "o", "ms": 2.5, "mfc": fill, "ls": "none"}
                ax.plot(x[alone], height[alone], color=colour, label=DECORATION, **dot)
        tells = "cycle_end_kind" in dataset and branch.is_along(dataset, str(axis.name), observed)
        if at_section and tells:
            _mark_changes(ax, dataset, axis, layer, colours)
    return unmet


def _mark_changes(
    ax: Axes,
    dataset: xr.Dataset,
    axis: xr.DataArray,
    layer: points.Layer,
    colours: Mapping[str, ColorType],
) -> None:
    """A mark at each change and end of branches, in the colour of their diagram."""
    dataset = _without_outer_ends(dataset, axis)
    for line in branch.lines_apart(dataset):
        place, colour = _whose(layer, dataset.isel(line.index), axis, colours)
        branch.draw_marks(ax, dataset, line.index, colour, place, CHANGE, at_section=True)
    branch.name_marks(ax, [dataset], CHANGE)


def _without_outer_ends(dataset: xr.Dataset, axis: xr.DataArray) -> xr.Dataset:
    """Branches whose brackets are no ends where they reach over the diagram, which ends there."""
    kind, low, high = dataset["cycle_end_kind"], axis.min(), axis.max()
    inside = (dataset["cycle_end"] > low) & (dataset["cycle_end"] < high)
    kept = kind.where(inside | ~is_class(kind, ("bracket",)), CYCLE_END.codes[NOT_COMPUTED])
    return dataset.assign(cycle_end_kind=kept.assign_attrs(kind.attrs))


def _whose(
    layer: points.Layer, own: xr.Dataset, axis: xr.DataArray, colours: Mapping[str, ColorType]
) -> tuple[str, ColorType]:
    """Which of a diagram's parameters a cycle is of, and the colour of these; black without any."""
    place = points.joined(layer.label, _place_in(layer.dataset, own, str(axis.dims[0])))
    for words in ({*one.split(", ")} for one in (place, layer.label) if one):
        for entry, colour in colours.items():
            if words <= {*entry.split(", ")}:
                return place, colour
    return place, style.BLACK


def _place_in(diagram: xr.Dataset, own: xr.Dataset, along: str) -> str:
    """What the lines of a diagram that are at the parameters of a cycle are called by these."""
    for line in points.lines(diagram, [along, "initial"], points.grid_dims(diagram)):
        there = diagram.isel(line.index).coords
        known = [n for n in there if n in own.coords and not there[n].ndim and not own[n].ndim]
        if all(there[name].item() == own[name].item() for name in known):
            return line.label
    return ""


def _of_one_section(dataset: xr.Dataset, diagram: xr.Dataset) -> bool:
    """Whether cycles and diagram lie on the same section, the only one that either has."""
    if branch.suits(dataset) and not branch.meets_sections(dataset):
        return False
    sections = _sections(dataset, "cycle")
    return len(sections) == 1 and sections == _sections(diagram, "response")


def _sections(dataset: xr.Dataset, kind: str) -> set[tuple[object, ...]]:
    """The sections that an analysis of this kind was asked for, or that its motions chose."""
    if "section_kind" in dataset:
        kinds = class_names(dataset["section_kind"]).ravel()
        contacts = numbers(dataset["section_contact"]).values.ravel()
        chosen = set(zip(kinds.tolist(), np.nan_to_num(contacts).tolist(), strict=True))
        return {one for one in chosen if one[0] != SECTION.fill}
    asked = [one["settings"].get("section") for one in _analyses(dataset) if one["kind"] == kind]
    return {_of_section(section) for section in asked if section}


def _of_section(section: Mapping[str, Any]) -> tuple[object, ...]:
    """What a section is asked to be: its event and contact, or its state and direction."""
    if section.get("kind") == "event":
        return section["event"].replace("->", "_to_"), section["contact"]
    if section.get("kind") == "zero":
        return "zero", section["state"], section["direction"]
    return tuple(section.values())


def _section_words(shown: Sequence[points.Layer]) -> str:
    """The section of all diagrams, as an axis is called by it; "the section" where it has no words.

    Of a model of several contacts it is told which.
    """
    sections = {one for layer in shown for one in _sections(layer.dataset, "response")}
    kind, contact, *of = next(iter(sections)) if len(sections) == 1 else ("", 1)
    if kind == "zero":
        return f"${labels.symbol_of_name(str(contact))}$ = 0{PASSING[str(of[0])]}"
    if kind not in SECTION_WORDS:
        return "the section"
    several = any(layer.dataset.sizes.get("contact", 1) > 1 for layer in shown)
    return f"{SECTION_WORDS[kind]}{f' of contact {contact:g}' if several else ''}"


def _equilibria(
    layer: points.Layer, others: Sequence[xr.Dataset], axis: xr.DataArray, observed: str
) -> dict[str, xr.DataArray]:
    """Word of `EQUILIBRIA` -> heights of the equilibria of a diagram that are called so, else NaN.

    What tells whether they are stable, along `axis`, is of the diagram's case or one of the others.
    """
    diagram = layer.dataset
    nowhere = dict.fromkeys(EQUILIBRIA, diagram["status"] * np.nan)
    parts = [of_the_same(one, diagram) for one in (*layer.beside, *others)]
    beside = [one for one in parts if one is not None and axis.name in one.coords]
    place = _heights(diagram, beside, observed)
    judged = next((d["stable"] for d in beside if {"stable", "growth_rate"} <= {*d}), None)
    if judged is None or place is None:
        return nowhere
    called = {word: place.where(is_class(judged, (word,))) for word in EQUILIBRIA}
    return {word: here.reindex_like(place) for word, here in called.items()}  # of another grid


def _heights(
    diagram: xr.Dataset, beside: Sequence[xr.Dataset], observed: str
) -> xr.DataArray | None:
    """Those of the equilibrium that is linearised: what L_s is measured from or, where a diagram
    has none, what an `equilibrium` analysis beside it found."""
    number = _linearised_at(diagram)
    if "L_s_reference" in diagram and observed in diagram["state"]:
        known = diagram["L_s_reference"].where(diagram["L_s_reference_index"] == number)
        return known.sel(state=observed).max([dim for dim in known.dims if dim == "initial"])
    for one in beside:
        if "equilibrium" in one and observed in one["state"] and number <= one.sizes["solution"]:
            return one["equilibrium"].isel(solution=number - 1).sel(state=observed)
    return None


def _all_of(equilibria: Mapping[str, xr.DataArray]) -> xr.DataArray:
    """The heights of equilibria of every word."""
    return reduce(lambda one, other: one.fillna(other), equilibria.values())


def _draw_equilibria(
    ax: Axes,
    layer: points.Layer,
    equilibria: Mapping[str, xr.DataArray],
    changes: np.ndarray,
    axis: xr.DataArray,
) -> tuple[list[Line2D], bool]:
    """Equilibria of a diagram, by what the eigenvalues of its case tell of them, up to `changes`.

    Those of several diagrams, or at several values of other axes, have the colours of these.
    Returned are marks where they turn unstable, not drawn yet, and whether some are one line.
    """
    diagram, turns, shares = layer.dataset, [], False
    axis = select.axis_of(diagram, str(axis.name))
    dim, x = str(axis.dims[0]), points.positions(axis)
    lines = points.lines(diagram, [dim, "initial"], points.grid_dims(diagram))
    colours = points.colours([ax]) if len(lines) > 1 or layer.label else {}
    known_words = {str(line.get_label()) for line in ax.lines}
    for word, height in equilibria.items():
        dashes, weight = EQUILIBRIA[word]
        of_word = _all_of(equilibria), height
        parts = [[of.isel(line.index).values for of in of_word] for line in lines]
        drawn = [
            (points.joined(layer.label, line.label), *up_to_turns(changes, x, every, own))
            for line, (every, own) in zip(lines, parts, strict=True)
            if np.isfinite(own).any()
        ]
        called = f"{word} equilibrium"
        for label, places, values, met in drawn:
            own = points.unlisted(label, called) if colours else called
            of_line = (colour for name, colour in colours.items() if name.startswith(label))
            (line,) = ax.plot(places, values, dashes, lw=weight, zorder=3.5,
                              color=next(of_line, style.BLACK), label=own)  # fmt: skip
            leave_out(line, met[0])
            shares |= _blacken_shared(ax, line)
            told = points.unlisted(label, TURNS_HERE)
            turns += [Line2D(*met, color=line.get_color(), label=told)] * (word == "unstable")
        if colours and drawn and called not in known_words:
            ax.plot([], [], dashes, lw=weight, color=style.BLACK, label=called)
    return turns, shares


def _mark_turns(ax: Axes, turns: Sequence[Line2D]) -> None:
    """Where each of several equilibria that are one line turns unstable: the line tells of none."""
    pairs = [(one, np.array(one.get_data(), float)) for one in turns]
    seen = [(one, places) for one, places in pairs if places.size]
    for one, places in seen:
        ax.plot(*places, color=one.get_color(), label=one.get_label(), **TURN)
    if seen:
        ax.plot([], [], color=style.BLACK, label=TURNS_HERE, **TURN)


def _blacken_shared(ax: Axes, line: Line2D) -> bool:
    """What is the same in two diagrams is of neither's colour: the later would hide the other.

    Tells whether there is any.
    """
    alike = [one for one in ax.lines[:-1] if one.get_linestyle() == line.get_linestyle()]
    parts = [
        shared for shared in (_shared(line, one) for one in alike) if np.isfinite(shared).any()
    ]
    for shared in parts:
        ax.plot(line.get_xdata(), shared, line.get_linestyle(), lw=line.get_linewidth(),
                zorder=line.get_zorder(), color=style.BLACK, label=DECORATION)  # fmt: skip
    return bool(parts)


def _shared(line: Line2D, other: Line2D) -> np.ndarray:
    """The heights of a line where another is as high, to a thousandth; NaN elsewhere."""
    (x, y), (its_x, its_y) = (np.array(one.get_data(), float) for one in (line, other))
    between = np.interp(x, its_x, its_y, left=np.nan, right=np.nan) if its_x.size else x * np.nan
    return np.where(np.isclose(y, between, rtol=ALIKE, atol=0.0), y, np.nan)


def _linearised_at(diagram: xr.Dataset) -> int:
    """The number of the equilibrium that the `eigenvalues` of a case are of."""
    settings = [one["settings"] for one in _analyses(diagram) if one["kind"] == "eigenvalues"]
    return int(settings[0].get("at_equilibrium", 1)) if settings else 1


def _analyses(diagram: xr.Dataset) -> list[dict[str, Any]]:
    """Kind and settings of the analyses of the case of a diagram."""
    return list(json.loads(diagram.attrs.get("analyses_json", "{}")).values())


def _cycles(
    dataset: xr.Dataset, axis: xr.DataArray, observed: str, at_section: bool
) -> Iterator[tuple[xr.Dataset, branch.Stretch]]:
    """Where cycles are on other axes, and they along this one, of a branch or points of the grid.

    The heights are both extremes, or what they pass `at_section`.
    """
    if branch.is_along(dataset, str(axis.name), observed):
        for line in branch.lines_apart(dataset):
            stretches = branch.stretches(dataset, line.index, at_section=at_section)
            yield from ((dataset.isel(line.index), stretch) for stretch in stretches)
    elif "cycle_period" in dataset and f"{observed}_min" in dataset and axis.name in dataset.coords:
        if not dataset.coords[str(axis.name)].ndim:
            dataset = dataset.expand_dims(str(axis.name))
        own = dataset.coords[str(axis.name)]
        x, dim = points.positions(own), str(own.dims[0])
        extremes = [dataset[f"{observed}_{end}"] for end in ("min", "max")]
        heights = [*_at_section(dataset)] if at_section else extremes
        lines = [*points.lines(dataset, [dim], points.grid_dims(dataset))]
        for word in branch.DASHES:
            before: list[tuple[dict[str, int], np.ndarray]] = []
            for line in lines:
                mask = is_class(dataset["stable"], (word,)).isel(line.index)
                if not mask.any():
                    continue
                every = np.array([one.isel(line.index).where(mask).values for one in heights])
                place = {name: at for name, at in line.index.items() if name != "initial"}
                shown = _not_again(every, [one for there, one in before if there == place])
                if np.isfinite(shown).any():
                    before.append((place, every))
                    yield dataset.isel(line.index), branch.Stretch(word, x, [*shown], at_section)


def _not_again(heights: np.ndarray, before: Sequence[np.ndarray]) -> np.ndarray:
    """The cycles of a start, shape (heights, points along the axis), that no start `before` found.

    Dashes over dashes would be a line. Neighbours of others are kept, to which their lines lead.
    """
    same = [
        np.isclose(heights, one, rtol=SAME, atol=0.0, equal_nan=True).all(axis=0) for one in before
    ]
    again = np.logical_or.reduce([np.zeros(heights.shape[-1], bool), *same])
    own = np.pad(~again & np.isfinite(heights).any(axis=0), 1)
    return np.where(~again | own[:-2] | own[2:], heights, np.nan)


def _at_section(dataset: xr.Dataset) -> Iterator[xr.DataArray]:
    """The least that each cycle passes at the section, the one above it, and so on."""
    sizes = select.row_sizes(dataset, DEFAULT)
    assert sizes is not None
    for values in branch.columns(dataset[DEFAULT].values, sizes.values.ravel()):
        yield sizes.copy(data=values.reshape(sizes.shape))
