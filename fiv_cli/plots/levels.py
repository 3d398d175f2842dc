"""Lines along which a variable over two parameters has a stated value: borders of regions.

Between the points of the grid the variable is taken to be linear. On a share of starts, say, the
line at 0.5 is the border of the region in which half of them or more do it. A share that is an
interval has a line for each end: the border is known where the two are one.

A plane is a stack of parts, shape (parts, points along y, points along x): no line leads from one
to another, as from what rests to what vibrates; of several levels that next to rest has one part.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping, Sequence
from itertools import chain, compress, cycle
from operator import itemgetter
from typing import TYPE_CHECKING, Any

import matplotlib as mpl
import numpy as np
from matplotlib.contour import QuadContourSet
from matplotlib.lines import Line2D
from matplotlib.path import Path
from matplotlib.patheffects import withStroke
from matplotlib.text import Text
from scipy import ndimage

from fiv_cli.case.structure import MOST_LINES
from fiv_cli.errors import UsageError
from fiv_cli.notation.names import listed
from fiv_cli.plots import labels, legends, level_notes, points, style
from fiv_cli.plots.drawn import keep_whole
from fiv_cli.plots.level_notes import Panel
from fiv_cli.reading import select
from fiv_cli.reading.datasets import ends_of, flag_names

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes
    from matplotlib.typing import ColorType

# Between levels written on lines, and at the ends of these, in lengths of the writing; where a line
# has less, and its level would be written nowhere, at its ends and to others at least.
ROOM, LEAST_ROOM, BESIDE = 1.5, 0.7, 1.3
# Of the half of what is written: another line is not to come so near, and the own is straight as
# far, from best to least; where that leaves no room, a line of another level that is still nearer
# is one with it.
CLEAR, ALIKE = (2.0, 1.4, 1.0), (0.4,)
DOWNWARD = -60.0  # degrees: what would be written more steeply down is written up, as most is
MOST_CRUMBS = 2  # pieces of a level shorter than it that have it beside them
MOST_WRITTEN = 4  # times each of several levels: on its longest lines, not on each island
# Of the diagonal of a panel, how far two levels on one line lie apart; of that, along the line.
AGAIN, LONG = 0.25, 2.0
# Of a panel's width and height: levels that take more hide what they name; the legend tells them.
LARGEST = np.array([0.16, 0.3])
TOUCH = 1e-9  # of the largest value: what lies as close to a level is at it
MOST_PLACES, MOST_ELSEWHERE = 150, 5000
UNHIDDEN = 2.5  # times as long as its level a line is at least that has it on it, and is seen
STEP = 0.25  # between points of other lines, in heights of letters
# Heights of letters between a short line and its level beside it, and where there is no room for
# that; ways there; places tried.
BY, FURTHER, MOST_BESIDE = 0.3, 1.0, 30
ENOUGH = 0.5  # of these heights, by which another line is further off: then rather at the middle
WAYS = np.array([(1, 0), (-1, 0), (1, 1), (1, -1), (-1, -1), (-1, 1), (0, -1), (0, 1)], float)
AT_END = 0.25  # of the length of a line: where a stroke to it would look like a bend
PAD = 0.25  # around a level that is written, in heights of its letters
STROKE: Any = {"arrowstyle": "-", "lw": 0.8, "shrinkA": 0.0, "shrinkB": 0.0}
# To each side of a level on its line, of the height of letters; of that: its place there.
CUT, CLOSE = 0.45, 0.05
HALO: Any = [withStroke(linewidth=2.0, foreground="white")]  # of words that lie on lines
OVER_MARKS = 4.5
LEAST_PERIODS = 1.6  # of dashes that a piece of a line shows
RIM: Any = [withStroke(linewidth=2.3, foreground="white")]  # of lines on any shade
STYLES: tuple[Any, ...] = (
    *("solid", "dashed", "dotted", (0, (3.2, 1.2, 1.0, 1.2))),  # which short lines show too
    *((0, (8.0, 2.0)), (0, (8.0, 1.5, 1.0, 1.5)), (0, (1.0, 4.0))),
    (0, (5.0, 1.5, 1.0, 1.5, 1.0, 1.5)),
)


def asked(mapped: str, said: Any) -> dict[str, list[float] | str]:
    """Variable -> its levels from low to high, of what stands at `level` in a map of `mapped`.

    The name of an axis is kept: the line lies where that has the value of the variable.

    Raises
    ------
    UsageError : more than can be told apart
    """
    of = said if isinstance(said, Mapping) else {mapped: said}
    levels = {
        name: own if isinstance(own, str) else sorted(float(one) for one in np.atleast_1d(own))
        for name, own in of.items()
    }
    count = sum(1 if isinstance(own, str) else len(own) for own in levels.values())
    if count > MOST_LINES:
        raise UsageError(f"{count} levels in one figure are too many\nask for {MOST_LINES}")
    return levels


def refuse_class(array: xr.DataArray) -> None:
    """UsageError of a variable that has no numbers."""
    if flag_names(array.attrs):
        raise UsageError(
            f"{array.name}: classes have no level\n"
            "draw the level of a number: level = { VARIABLE = NUMBER }"
        )


def same_along(dataset: xr.Dataset, other: xr.Dataset, dim: str) -> bool:
    """Whether two datasets, maybe of different cases, have the same values along `dim`."""
    if dim not in dataset.dims:
        return False
    one, two = (select.axis_of(of, dim).values for of in (dataset, other))
    return np.array_equal(one, two)


def under_panels(dataset: xr.Dataset, mapped: xr.Dataset, dims: Collection[str]) -> xr.Dataset:
    """A dataset along the `dims` of the panels of a map: what it has none of is not known there.

    Of a law or a parameter that it holds fixed it has that one value. Starts that are called
    otherwise are left as they are.
    """
    for dim in dims:
        axes = [axis for axis in mapped.coords.values() if axis.dims == (dim,)]
        if dim not in dataset.dims:
            fixed = {str(axis.name): _held(dataset, str(axis.name)) for axis in axes}
            held = {name: value for name, value in fixed.items() if value is not None}
            if not held:
                continue
            dataset = dataset.drop_vars(held, errors="ignore").expand_dims(dim)
            dataset = dataset.assign_coords({name: (dim, [value]) for name, value in held.items()})
        own = [dataset.coords.get(axis.name) for axis in axes]
        pairs = [
            (a, b) for a, b in zip(own, axes, strict=True) if a is not None and a.dims == (dim,)
        ]
        met = np.all([one.values[None] == two.values[:, None] for one, two in pairs], axis=0)
        if pairs and (met.any() or (dataset.sizes[dim] == 1 and dim != "initial")):
            dataset = _as_along(dataset, axes, met, dim)
    return dataset


def _held(dataset: xr.Dataset, name: str) -> Any:
    """The one value of a parameter, or the law, of a dataset that does not vary it."""
    if name == "friction":
        return dataset.attrs.get("law")
    axis = dataset.coords.get(name)
    return axis.item() if axis is not None and axis.ndim == 0 else None


def _as_along(
    dataset: xr.Dataset, axes: Sequence[xr.DataArray], met: np.ndarray, dim: str
) -> xr.Dataset:
    """What it has along the axes of a dim, where it is `met` there; unknown elsewhere."""
    is_there = axes[0].copy(data=met.any(axis=1)).variable
    own = [name for name, one in dataset.coords.items() if dim in one.dims]
    taken = dataset.isel({dim: met.argmax(axis=1)}).drop_vars(own)
    known = {
        name: one.where(is_there, other=np.nan)
        for name, one in taken.items()
        if dim in one.dims and "sample_dimension" not in one.attrs  # which lead to rows
    }
    return taken.assign(known).assign_coords({str(axis.name): axis.variable for axis in axes})


def at_the_map(
    name: str, dataset: xr.Dataset, mapped: xr.Dataset, further: Collection[str]
) -> xr.Dataset:
    """What lines of a variable are drawn of, where its `further` axes have what a map holds fixed.

    Raises
    ------
    UsageError : it has none of that, or several of what the map knows nothing of
    """
    known = [dim for dim in further if dataset.sizes[dim] > 1 and dim in mapped.coords]
    there = {dim: np.unique(mapped[dim]) for dim in known if select.is_numeric(mapped[dim])}
    fixed = {dim: own.item() for dim, own in there.items() if own.size == 1}
    try:
        dataset = select.subset(dataset, fixed, nearest=False)
    except select.SelectionError as error:
        raise UsageError(f"{name}: its line on this map is that at {error}") from None
    several = [dim for dim in further if dataset.sizes[dim] > 1]
    if several:
        raise UsageError(
            f"{name}: several values at a point, and its line on a map is drawn of one\n"
            f"choose from {', '.join(several)} with `select` in the figure"
        )
    return dataset.squeeze(further, drop=True)


def held_otherwise(name: str, dataset: xr.Dataset, mapped: xr.Dataset) -> Iterator[str]:
    """What lines of a variable, of another case, hold fixed at another value than their map."""
    laws = [str(one.attrs.get("law", "")) for one in (dataset, mapped)]
    fixed = [] if "friction" in mapped.coords or laws[0] == laws[1] else [laws]
    for values in labels.fixed_otherwise([dataset, mapped]):
        units = [str(one.attrs.get("units", "1")) for one in values]
        numbers = [labels.number_text(one.item(), [v.item() for v in values]) for one in values]
        pairs = zip(numbers, units, strict=True)
        fixed.append([f"{values[0].name} = {n} {u if u != '1' else ''}".rstrip() for n, u in pairs])
    if fixed:
        own, here = (", ".join(words) for words in zip(*fixed, strict=True))
        yield (
            f"{name}: its line is that at {own}, over a map at {here}; for its line there, give "
            "its case that value, or an axis that has it"
        )


def planes_of(dataset: xr.Dataset, array: xr.DataArray) -> list[xr.DataArray]:
    """The variable, or the two ends of what it may be."""
    low, high = ends_of(dataset, str(array.name))
    return [array] if low.equals(high) else [low, high]


def half_way(plane: np.ndarray, at_rest: np.ndarray, kinds: np.ndarray, level: float) -> np.ndarray:
    """A plane whose line lies half-way in jumps: with the middles of its cells and of their sides.

    Where in a jump, between points of two `kinds`, a level is passed is not known, and what is read
    there, of a low one, would be beside the point that rests. Of one part, where what is `at_rest`
    has one value; any other plane is left as it is.
    """
    if len(plane) > 1 or not level_notes.jumps_from(at_rest, plane):
        return plane
    part = plane[0]
    found = np.full(2 * np.array(part.shape) - 1, np.nan)
    is_jump = np.zeros(found.shape, bool)
    found[::2, ::2] = part
    for values, kind, middles, jumps in (
        (part, kinds, found[1::2, ::2], is_jump[1::2, ::2]),
        (part.T, kinds.T, found[::2, 1::2].T, is_jump[::2, 1::2].T),
    ):
        apart = (kind[1:] != kind[:-1]) & ((values[1:] - level) * (values[:-1] - level) < 0.0)
        middles[:] = np.where(apart, level, 0.5 * (values[1:] + values[:-1]))
        jumps[:] = apart
    across = 0.5 * (part[1:, 1:] + part[:-1, :-1]), 0.5 * (part[1:, :-1] + part[:-1, 1:])
    both = 0.5 * (across[0] + across[1])
    middles = np.where(np.isfinite(both), both, np.fmin(*across))  # or, of three points, of a side
    beside = is_jump[1::2, :-1:2] | is_jump[1::2, 2::2] | is_jump[:-1:2, 1::2] | is_jump[2::2, 1::2]
    found[1::2, 1::2] = np.where(beside & np.isfinite(middles), level, middles)
    return found[None]


def _halved(places: tuple[np.ndarray, np.ndarray], shape: Sequence[int]) -> list[np.ndarray]:
    """The places along both axes of a part, with the middles between them where it has these."""
    return [
        own if own.size == count else np.interp(np.arange(count) / 2.0, np.arange(own.size), own)
        for own, count in zip(places, reversed(shape), strict=True)
    ]


def draw(
    ax: Axes,
    array: xr.DataArray,
    places: tuple[np.ndarray, np.ndarray],
    planes: Panel,
    levels: Sequence[float],
    colour: ColorType,
    *,
    label: str = "",
    named: bool = True,
    rim: bool = False,
    styles: Sequence[Any] = STYLES,
) -> Collection[float]:
    """Lines where the planes of a panel reach their levels, one for each end of what is drawn.

    Each has its level written on it, if they are `named` and each has the room: those levels. A
    `rim` sets them off from any shade.
    """
    drawn = []
    for level, ends, dashes in zip(levels, planes, styles, strict=False):
        for plane in ends:
            parts = (_off_the_level(part, level) for part in plane)
            for part in [part for part in parts if not level_notes.side(part, level)]:
                lines = ax.contour(
                    *_halved(places, part.shape), part, levels=[level], colors=[colour],
                    linestyles=[dashes], linewidths=1.5,
                )  # fmt: skip
                lines.set_path_effects(RIM if rim else [])
                _dash_short_pieces(ax, lines)
                lines.set_label(points.unlisted(label, level_notes.words(array, level, levels)))
                drawn.append((lines, level))
    if not named:
        return ()
    whole = [_pieces(lines) for lines, _ in drawn]  # what levels are written on is cut
    written = _name(ax, drawn, levels)
    if len(levels) > 1:
        notes = _name_crumbs(ax, drawn, whole, levels)
        style.add_notes(ax.figure.figure, [f"{array.name} = {note}" for note in notes])
    return written


def _name_crumbs(
    ax: Axes,
    drawn: Sequence[tuple[QuadContourSet, float]],
    whole: Sequence[Sequence[np.ndarray]],
    levels: Sequence[float],
) -> Iterator[str]:
    """Write each level beside the pieces of its lines, `whole`, that are shorter than it, where
    these are few and have the room; say where the others are."""
    marks, panel = [*_drawn_marks(ax)], f" in panel {ax.get_title()}" * bool(ax.get_title())
    for (lines, level), pieces in zip(drawn, whole, strict=True):
        text, colour = labels.number_text(level, levels), _colour_of(lines)
        crumbs, left = _crumbs(ax, pieces, 2.0 * _half_of(ax, text)[0]), list[str]()
        for crumb in crumbs:
            others = [one for one in chain(*whole) if one is not crumb]
            beside = [crumb], colour, text, others, marks
            if len(crumbs) > MOST_CRUMBS or not _write_beside(ax, *beside):
                left.append(", ".join(f"{one:.3g}" for one in crumb[len(crumb) // 2]))
        more = [f"{len(left) - MOST_WRITTEN} more places"] * (len(left) > MOST_WRITTEN)
        if places := [*(f"({at})" for at in left[:MOST_WRITTEN]), *more]:
            yield f"{text}: too short a line for its number at {listed(places)}{panel}"


def _crumbs(ax: Axes, pieces: Sequence[np.ndarray], length: float) -> list[np.ndarray]:
    """The pieces of a line within a panel that are shorter than that, where some are not."""
    short = [one for one in pieces if _length(ax, one) < length]
    inside = (ax.viewLim.contains(*one[len(one) // 2]) for one in short)
    return [*compress(short, inside)] if len(short) < len(pieces) else []


def _colour_of(lines: QuadContourSet) -> Any:
    """The one that lines of a level have."""
    return lines.get_edgecolor()[0]


def _dash_short_pieces(ax: Axes, lines: QuadContourSet) -> None:
    """Dash the pieces of a dashed line that are shorter than its dashes more finely, for they look
    like a solid one."""
    looks: Any = lines.get_linestyle()
    width, found = np.max(lines.get_linewidth()), []
    for own, (start, pattern) in zip(lines.allsegs, cycle(looks), strict=False):
        if not pattern:
            return
        period = sum(pattern) * ax.figure.figure.dpi / style.POINTS
        pieces = [(_length(ax, one) / (LEAST_PERIODS * period), one) for one in own if len(one)]
        whole = [piece for share, piece in pieces if share >= 1.0]
        found += [(start, pattern, 1.0, whole)] * bool(whole)
        found += [(start, pattern, share, [piece]) for share, piece in pieces if share < 1.0]
    if any(share < 1.0 for *_, share, _ in found):
        # with codes, which levels that are written along lines are looked for by
        lines.set_paths([Path.make_compound_path(*map(Path, pieces)) for *_, pieces in found])
        finer: Any = [(start, [share * dash / width for dash in pattern])
                      for start, pattern, share, _ in found]  # fmt: skip
        lines.set_linestyle(finer)


def _length(ax: Axes, piece: np.ndarray) -> float:
    """Length of a piece of a line, pixels."""
    return float(_way(ax.transData.transform(piece))[-1])


def _off_the_level(part: np.ndarray, level: float) -> np.ndarray:
    """Values at the level, to rounding, on the side of those around all of them that are together:
    a ridge has no line, nor has a plain."""
    off = part - level
    rounding = TOUCH * max(float(np.abs(part[np.isfinite(part)]).max(initial=0.0)), abs(level))
    at = np.abs(off) <= rounding
    if not at.any():
        return part
    rest = np.pad(np.where(at | np.isnan(off), 0.0, np.sign(off)), 1)
    rows, columns = part.shape
    around = sum(rest[i : i + rows, j : j + columns] for i in range(3) for j in range(3))
    groups = ndimage.label(at, structure=np.ones((3, 3)))[0]
    sides = np.bincount(groups.ravel(), weights=np.ravel(around))
    return np.where(at, level + rounding * np.where(sides[groups] < 0.0, -1.0, 1.0), part)


def _height(ax: Axes) -> float:
    """Of the letters of levels, in pixels."""
    return float(mpl.rcParams["legend.fontsize"] * ax.figure.dpi / style.POINTS)


def _name(
    ax: Axes, drawn: Sequence[tuple[QuadContourSet, float]], levels: Sequence[float]
) -> Collection[float]:
    """Write each level on its lines that have the room, and say which; the legend tells all.

    Of the lines of two ends on those of one of them, and a single level once.
    """
    most = MOST_WRITTEN if len(levels) > 1 else 1
    written = [one.get_position() for one in ax.texts]
    own = [lines for lines, _ in drawn]
    further = [one for one in ax.collections if isinstance(one, QuadContourSet) and one not in own]
    crossing = [*_drawn_lines(ax), *(piece for one in further for piece in _pieces(one))]
    marks = [*_drawn_marks(ax)]
    found: list[tuple[QuadContourSet, float, list[np.ndarray]]] = []
    for lines, level in drawn:
        if any(of == level and places for _, of, places in found):
            continue
        others = [piece for one, of in drawn if of != level for piece in _pieces(one)]
        taken = [*written, *(place for _, _, places in found for place in places)]
        text = labels.number_text(level, levels)
        rooms = (
            _rooms(ax, lines, text, (others, shares), [*crossing, *marks], taken)
            for shares in (CLEAR, ALIKE)
        )
        found.append((lines, level, next(filter(None, rooms), [])[:most]))
    hidden, told = [], set[float]()
    for lines, level, places in found:
        if not places or _is_hidden(ax, lines, level, levels):
            hidden.append((lines, level, places))
        else:
            _write_on(ax, lines, level, levels, places)
            told.add(level)
    for lines, level, places in hidden:
        others = [piece for one, of in drawn if of != level for piece in _pieces(one)]
        text = labels.number_text(level, levels)
        whole = _pieces(lines), _colour_of(lines), text, [*others, *crossing], marks
        if not (is_beside := _write_beside(ax, *whole)):
            _write_on(ax, lines, level, levels, places)
        told |= {level} if is_beside or places else set()
    return told


def _is_hidden(ax: Axes, lines: QuadContourSet, level: float, levels: Sequence[float]) -> bool:
    """Whether little is seen of a line on which its level is written."""
    longest = max((_length(ax, piece) for piece in _pieces(lines)), default=0.0)
    return bool(longest < UNHIDDEN * 2.0 * _half_of(ax, labels.number_text(level, levels))[0])


def _write_on(
    ax: Axes,
    lines: QuadContourSet,
    level: float,
    levels: Sequence[float],
    places: Sequence[np.ndarray],
) -> None:
    """Write a level on its line at some places."""
    # cut by matplotlib, a line may lose three times as much beneath a bend
    look: dict[str, Any] = {"fontsize": mpl.rcParams["legend.fontsize"], "inline": False}
    told = {level: labels.number_text(level, levels)}
    for text in ax.clabel(lines, fmt=told, manual=places, **look) if places else ():
        upwards = (text.get_rotation() - DOWNWARD) % 180.0 + DOWNWARD
        text.set(path_effects=HALO, zorder=OVER_MARKS, rotation=0.0)
        _begin_beside(ax, lines, text)
        text.set_rotation(min(upwards, 90.0))  # none is turned over


def _begin_beside(ax: Axes, lines: QuadContourSet, text: Text) -> None:
    """Cut the piece on which a level is written, without a turn as yet, beneath that.

    Its dashes begin on both sides: a part of one beside a figure would look like a point of it.
    """
    keep_whole(lines)
    pixels, place = ax.transData, ax.transData.transform(text.get_position())
    half = 0.5 * text.get_window_extent().width + CUT * _height(ax)
    own = [[pixels.transform(piece) for piece in of if len(piece)] for of in lines.allsegs]
    step = STEP * _height(ax)
    written = min(chain(*own), key=lambda one: _distances(_dense(one, step), [place]).min())
    others = [pixels.transform(one.get_position()) for one in ax.texts if one is not text]
    cut = (
        [_beside_gap(one, place, half, others) if one is written else [one] for one in of]
        for of in own
    )
    back = pixels.inverted().transform
    lines.set_paths([Path.make_compound_path(*map(Path, map(back, chain(*of)))) for of in cut])
    _dash_short_pieces(ax, lines)


def _beside_gap(
    line: np.ndarray, place: np.ndarray, half: float, others: Sequence[np.ndarray]
) -> list[np.ndarray]:
    """The parts of a line on both sides of a place, each from so far beside it onward; of one that
    leads to another of such places each half from its own."""
    if len(line) > 2 and (line[0] == line[-1]).all():  # a ring: both lead to its far side
        nearest = _distances(line[:-1], [place]).argmin()
        line = np.roll(line[:-1], len(line) // 2 - nearest, axis=0)
        line = np.concatenate([line, line[:1]])
    way = _way(line)
    off = _distances(_dense(line, CLOSE * half), [place])
    at = way[-1] * off.argmin() / (off.size - 1)
    ends = [[np.interp(at + to, way, one) for one in line.T] for to in (-half, half)]
    before, after = line[way < at - half], line[way > at + half]
    parts = [(ends[0], before[::-1]), (ends[1], after)]
    whole = [np.concatenate([[end], part]) for end, part in parts if len(part)]
    return [half_ for one in whole for half_ in _from_both(one, half, others)]


def _from_both(line: np.ndarray, half: float, others: Sequence[np.ndarray]) -> list[np.ndarray]:
    """A line, or both its halves from its ends on, if it leads to one of these places."""
    if len(line) < 3 or _distances(line[-1:], others)[0] > (1.0 + CLOSE) * half:
        return [line]
    middle = len(line) // 2
    return [line[: middle + 1], line[middle:][::-1]]


def _write_beside(
    ax: Axes,
    lines: Sequence[np.ndarray],
    colour: ColorType,
    text: str,
    others: Sequence[np.ndarray],
    marks: Sequence[np.ndarray],
) -> bool:
    """Write a level beside its longest line, which is too short to have it on it; whether it does.

    Next to its middle, or where else it lies upon no line and no other level, and nearer to its own
    line than to `others`, and upon none of the `marks`; with a stroke to the line.
    """
    height, half, pixels = _height(ax), _half_of(ax, text), ax.transData.transform
    own, far, hidden = (_lying(ax, pieces) for pieces in (lines, others, marks))
    line = max((pixels(piece) for piece in lines), key=_extent, default=own)
    line = _thinned(_dense(line, STEP * height), MOST_BESIDE)
    middle = line[np.argsort(np.abs(np.arange(len(line)) - len(line) // 2))]
    ways = np.concatenate([WAYS * (half + by * height) for by in (BY, FURTHER)])
    places = (middle[:, None] + ways).reshape(-1, 2)
    texts = np.reshape([pixels(one.get_position()) for one in ax.texts], (-1, 2))
    upon = _gaps(places, half, np.concatenate([own, far])) == 0.0
    upon |= _gaps(places, 2.0 * half, texts) == 0.0  # of boxes as large
    gaps = [_gaps(places, half, one) for one in (own, far)]
    inside = (ax.bbox.min + half <= places) & (places <= ax.bbox.max - half)
    upon |= _gaps(places, half, hidden) == 0.0
    free = inside.all(axis=1) & ~upon & (2.0 * gaps[0] < gaps[1])
    off = np.round(gaps[0] / (BY * height))  # what is off its line may be of another
    near = -np.minimum(gaps[1] - gaps[0], ENOUGH * height)
    feet = own[np.linalg.norm(own - places[:, None], axis=-1).argmin(axis=1)]
    off_ends = np.linalg.norm(feet[:, None] - line[[0, -1]], axis=-1).min(axis=1)
    at_end = off_ends < AT_END * _way(line)[-1]
    best = np.flatnonzero(free)[np.lexsort([key[free] for key in (near, off, at_end)])[:1]]
    for place, nearest in zip(places[best], feet[best], strict=True):
        here, foot = map(tuple, ax.transData.inverted().transform([place, nearest]).tolist())
        size = mpl.rcParams["legend.fontsize"]
        look: dict[str, Any] = {"ha": "center", "va": "center", "zorder": OVER_MARKS}
        look["path_effects"] = HALO
        ax.annotate(text, foot, here, fontsize=size, color=colour,
                    arrowprops={**STROKE, "color": colour}, **look)  # fmt: skip
    return bool(free.any())


def _half_of(ax: Axes, text: str) -> np.ndarray:
    """Half the width and the height of a level with some room around it, in pixels."""
    return np.array([0.5 * style.longest([text]) * style.LETTER + PAD, 0.5 + PAD]) * _height(ax)


def _lying(ax: Axes, pieces: Sequence[np.ndarray]) -> np.ndarray:
    """Points on lines, close enough that no level lies between two of them, in pixels."""
    step, pixels = STEP * _height(ax), ax.transData.transform
    every = [np.zeros((0, 2)), *(_dense(pixels(one), step) for one in pieces)]
    return _thinned(np.concatenate(every), MOST_ELSEWHERE)


def _gaps(places: np.ndarray, half: np.ndarray, points: np.ndarray) -> np.ndarray:
    """Distances of boxes of these halves from the nearest of some points."""
    off = np.maximum(np.abs(points - places[:, None]) - half, 0.0)
    nearest: np.ndarray = np.linalg.norm(off, axis=-1).min(axis=1, initial=np.inf)
    return nearest


def _rooms(
    ax: Axes,
    lines: QuadContourSet,
    text: str,
    others: tuple[Sequence[np.ndarray], Sequence[float]],
    crossing: Sequence[np.ndarray],
    written: Sequence[Any],
) -> list[np.ndarray]:
    """Where the level can be written on pieces of its lines beside what is `written` already.

    There it reaches over no side of the panel and no line of those `crossing`, its own is straight,
    and those of `others` levels are further away than a share of it: the first that leaves room.
    """
    height, box = _height(ax), _half_of(ax, text)
    length = 2.0 * (box[0] - PAD * height)
    ax.get_xlim(), ax.get_ylim()  # the panel has its scale when it is asked for
    pixels = ax.transData.transform
    near, far = (_lying(ax, pieces) for pieces in (others[0], crossing))
    taken = [pixels(place) for place in written]
    chosen: list[np.ndarray] = []
    roomiest: tuple[float, list[np.ndarray]] = (LEAST_ROOM * length, [])
    for whole in sorted(_pieces(lines), key=lambda one: -_extent(pixels(one)))[:MOST_WRITTEN]:
        along = _thinned(_dense(pixels(whole), STEP * height), MOST_PLACES)
        piece = ax.transData.inverted().transform(along)
        apart = _distances(along, [along[0], along[-1]])
        ahead = np.abs(_directions(along))
        half = box[0] * ahead + box[1] * ahead[:, ::-1]
        outside = (along - half < ax.bbox.min) | (along + half > ax.bbox.max)
        too_large = length * ahead > LARGEST * ax.bbox.size
        apart[(outside | too_large).any(axis=1)] = 0.0
        off = _distances(along, taken)
        for share in others[1]:
            around = max(1.0, share) * box
            hides = _reaches(along, near, share * box) | _reaches(along, far, around)
            free = np.where(hides | _bends(along, around[0], box[1]), 0.0, apart)
            best = np.where(off > ROOM * length, free, 0.0)
            if best.max() > ROOM * length:
                far_off = AGAIN * float(np.linalg.norm(ax.bbox.size))
                own = _spread(along, best, far_off, MOST_WRITTEN - len(chosen))
                chosen.extend(piece[own])
                taken.extend(along[own])
                break
        least = np.where(off > BESIDE * length, free, 0.0)
        roomiest = max(roomiest, (least.max(), [piece[least.argmax()]]), key=itemgetter(0))
    return chosen or roomiest[1]


def _spread(along: np.ndarray, room: np.ndarray, apart: float, most: int) -> list[int]:
    """Which points of a line have the most room and, of a long one, lie so far from the first and
    from each other, along it and across the panel."""
    way, found = _way(along), list[int]()
    while room.max() > 0.0 and len(found) < most:
        at = int(room.argmax())
        found.append(at)
        near = _distances(along, [along[at]]) < apart
        room = np.where(near | (np.abs(way - way[at]) < LONG * apart), 0.0, room)
    return found


def _extent(line: np.ndarray) -> float:
    """How far a line reaches, along the axis along which it reaches further."""
    return float(np.ptp(line, axis=0).max())


def _thinned(line: np.ndarray, most: int) -> np.ndarray:
    """Some points of a long line, evenly spread: each is compared with each of another."""
    return line[:: -(-len(line) // most)] if len(line) else line


def _dense(line: np.ndarray, step: float) -> np.ndarray:
    """Points of a line, at most so far apart."""
    way = _way(line)
    known = np.isfinite(way)
    if known.sum() < 2:
        return line[known]
    at = np.linspace(0.0, way[known][-1], 2 + int(way[known][-1] / step))
    return np.column_stack([np.interp(at, way[known], one[known]) for one in line.T])


def _way(line: np.ndarray) -> np.ndarray:
    """How far along a line each of its points lies."""
    return np.append(0.0, np.cumsum(np.linalg.norm(np.diff(line, axis=0), axis=1)))


def _directions(along: np.ndarray) -> np.ndarray:
    """Those of a line at its points, of length one."""
    ahead = np.gradient(along, axis=0) if len(along) > 1 else np.ones((1, 2))
    size = np.linalg.norm(ahead, axis=1, keepdims=True)
    return np.asarray(ahead / np.maximum(size, np.finfo(float).tiny))


def _in_frames(along: np.ndarray, points: np.ndarray) -> np.ndarray:
    """Distances of points from each of a line, along it and across, shape (line, points, 2)."""
    ahead = _directions(along)
    apart, across = points - along[:, None], ahead[:, ::-1] * (-1.0, 1.0)
    return np.abs(np.stack([(apart * one[:, None]).sum(-1) for one in (ahead, across)], axis=-1))


def _reaches(along: np.ndarray, elsewhere: np.ndarray, box: np.ndarray) -> np.ndarray:
    """Where a box along a line, of these halves, reaches over points of other lines."""
    inside = _in_frames(along, elsewhere) < box
    return np.asarray(np.any(inside.all(axis=-1), axis=1))


def _bends(along: np.ndarray, length: float, height: float) -> np.ndarray:
    """Where a line leaves a box along it, of these halves, by its long sides, for good or not."""
    near = np.linalg.norm(along - along[:, None], axis=-1) < length
    return np.asarray(np.any(near & (_in_frames(along, along)[..., 1] > height), axis=1))


def _drawn_lines(ax: Axes) -> Iterator[np.ndarray]:
    """The lines of a panel that are drawn already, in its own numbers."""
    for line in ax.lines:
        if line.get_transform() == ax.transData and line.get_linestyle() != "None":
            yield np.asarray(line.get_xydata(), float)


def _drawn_marks(ax: Axes) -> Iterator[np.ndarray]:
    """Each mark that stands alone in a panel, as a line of one point, in its own numbers."""
    for line in ax.lines:
        if line.get_transform() == ax.transData and line.get_linestyle() == "None":
            yield from np.asarray(line.get_xydata(), float)[:, None]


def _distances(points: np.ndarray, others: Sequence[np.ndarray]) -> np.ndarray:
    """Of each point to the nearest of the others."""
    if not others:
        return np.full(len(points), np.inf)
    nearest: np.ndarray = np.linalg.norm(points[:, None] - np.array(others), axis=-1).min(axis=1)
    return nearest


def _pieces(lines: QuadContourSet) -> list[np.ndarray]:
    """The pieces of lines at one level; beside what is not known there are some without a point."""
    return [piece for own in lines.allsegs for piece in own if len(piece)]


def overlay(
    ax: Axes,
    array: xr.DataArray,
    planes: Sequence[tuple[str, Panel]],
    places: tuple[np.ndarray, np.ndarray],
    levels: Sequence[float],
    others: Sequence[Line2D] = (),
) -> None:
    """The lines of several planes (label, what it is at each level) in one panel: a colour for each
    plane, a kind of line for each level or, of a single level, for each plane.

    The legend has the keys of `others`, too.
    """
    figure, colours, single = ax.figure.figure, style.line_colours(len(planes)), len(levels) == 1
    dashes = [style.dash(number, len(planes)) if single else "-" for number in range(len(planes))]
    told = [
        Line2D([], [], color=colour, ls=dash, label=word)
        for (label, panel), colour, dash in zip(planes, colours, dashes, strict=True)
        if (word := _entry(label, panel, levels))
    ]
    panels = [panel for _, panel in planes]
    of_all = keys(array, levels, style.BLACK if len(planes) > 1 else colours[0], panels)
    both = _both([ends for panel in panels for ends in panel])
    of_one = bool(told and single and not others)
    heading = f"{level_notes.words(array, levels[0], levels)}{both}" if of_one else ""
    legends.legend_below(figure, [*told, *([] if of_one else of_all), *others], heading)
    style.lay_out(figure)  # levels are written along lines as they look
    written: set[float] = set()
    for (label, panel), colour, dash in zip(planes, colours, dashes, strict=True):
        look: dict[str, Any] = {"label": label, "named": not single}
        look["styles"] = [dash] if single else STYLES
        written |= {*draw(ax, array, places, panel, levels, colour, **look)}
    if not single:
        notes = level_notes.unwritten(array, panels, levels, written)
        style.add_notes(figure, [*level_notes.missed(array, panels, levels), *notes])


def keys(
    array: xr.DataArray,
    levels: Sequence[float],
    colour: ColorType,
    panels: Sequence[Panel],
    styles: Sequence[Any] = STYLES,
) -> list[Line2D]:
    """An entry of a legend for each level that is drawn in some panels."""
    drawn = [
        (level_notes.words(array, level, levels) + _both([panel[number] for panel in panels]), dash)
        for number, (level, dash) in enumerate(zip(levels, styles, strict=False))
        if any(not level_notes.beside(plane, level) for panel in panels for plane in panel[number])
    ]
    return [Line2D([], [], color=colour, ls=dash, label=word) for word, dash in drawn]


def _both(planes: Sequence[Sequence[np.ndarray]]) -> str:
    """What lines there are where planes have two ends."""
    return ", at least and at most" if any(len(ends) > 1 for ends in planes) else ""


def _entry(label: str, panel: Panel, levels: Sequence[float]) -> str:
    """The label of a plane; of one without a line it says on which side of the levels it lies."""
    pairs = zip(panel, levels, strict=True)
    sides = {level_notes.beside(plane, level) for ends, level in pairs for plane in ends}
    return points.joined(label, next(iter(sides)) if len(sides) == 1 else "")
