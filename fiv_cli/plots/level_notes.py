"""What is said about lines at levels: where none leads, and what they cannot tell."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Sequence
from itertools import combinations, pairwise
from typing import TYPE_CHECKING, TypeAlias

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view
from scipy.ndimage import binary_dilation, label

from fiv_cli.notation.names import listed
from fiv_cli.plots import labels
from fiv_cli.reading.datasets import is_count

if TYPE_CHECKING:
    import xarray as xr

CROWDED = 0.5  # of the steps of the grid that a line crosses: another level lies in them, too
FLAT = 1e-3  # of the range of a plane: what varies by less at rest has one value there
MOSTLY = 0.9  # of a line: what is a border for so long is one
LEAP = 3.0  # times the step after it
ISLAND, MANY_ISLANDS = 3, 4  # points of the grid; islands of which a line has no few
NOT_KNOWN = "not known"
NO_CELLS = np.empty((0, 4))
ALONE = (
    "where it is passed no three neighbours have a value, as in one row of points alone, or beside "
    "points of a refined map that were not run or that rest at it"
)
IN_A_JUMP = (
    "it lies in the jump between rest and motion, where of several levels that next to rest alone "
    "has a line"
)
# Of each level the planes whose line is drawn: one, or one for each end of what its values may be.
Panel: TypeAlias = Sequence[Sequence[np.ndarray]]


def missed(array: xr.DataArray, panels: Sequence[Panel], levels: Sequence[float]) -> Iterator[str]:
    """Of levels that no plane reaches: why there is no line."""
    found: dict[str, list[float]] = {}
    for number, level in enumerate(levels):
        sides = {beside(plane, level) for panel in panels for plane in panel[number]}
        if "" not in sides:
            told = f"{' or '.join(sorted(sides))}{_reached(panels, number, sides, level)}"
            found.setdefault(told, []).append(level)
    for told, of in found.items():
        several = [words(array, level, levels) for level in of]
        if len(several) > 1 and not is_count(str(array.name)):
            unit = labels.unit_text(str(array.attrs.get("units", "1")))
            own = labels.quantity(array, str(array.name))
            several = [f"{own} = {_named(of, levels)} {unit}".rstrip()]
        yield f"no line {listed(several)}: {told}"


def _reached(panels: Sequence[Panel], number: int, sides: Collection[str], level: float) -> str:
    """What all planes reach that lie on one side of a level, where that is not next to it."""
    extremes = {"below everywhere": (np.nanmax, "most"), "above everywhere": (np.nanmin, "least")}
    if len(sides) != 1 or not {*sides} <= {*extremes}:
        return ""
    of, which = extremes[next(iter(sides))]
    reached = of([of(part) for panel in panels for plane in panel[number] for part in plane])
    told = float(f"{reached:.3g}")
    return f" (at {which} {labels.number_text(told)})" if told != level else ""


def unwritten(
    array: xr.DataArray,
    panels: Sequence[Panel],
    levels: Sequence[float],
    written: Collection[float],
) -> Iterator[str]:
    """Which of several levels are written on no line of theirs, and so told by dashes alone."""
    drawn = {
        level: labels.number_text(level, levels)
        for number, level in enumerate(levels)
        if _has_line(panels, number, level)
    }
    left = [text for level, text in drawn.items() if level not in written]
    if len(drawn) > 1 and left:
        yield (
            f"{array.name} = {listed(left)}: told in the legend alone, for want of room on its "
            "lines; more: --width, --height, fewer levels, or fewer panels (select)"
        )


def crowded(array: xr.DataArray, panels: Sequence[Panel], levels: Sequence[float]) -> Iterator[str]:
    """Which neighbouring levels pass between the same points: where, their grid cannot tell."""
    crossed = [
        np.concatenate([_crossed(plane, level) for panel in panels for plane in panel[number]])
        & _has_line(panels, number, level)
        for number, level in enumerate(levels)
    ]
    of_a_bundle = {
        number + one
        for number, (low, high) in enumerate(pairwise(crossed))
        if (low & high).sum() > CROWDED * max(low.sum(), high.sum())
        for one in (0, 1)
    }
    if of_a_bundle:
        told = _named([levels[number] for number in sorted(of_a_bundle)], levels)
        yield (
            f"{array.name} = {told}: between the same points of the grid along most of "
            "their lines, which are no more exact; more of it: a larger num, a narrower axis"
        )


def have_lines(panels: Sequence[Panel], levels: Sequence[float]) -> bool:
    """Whether there is a line at any of some levels."""
    return any(_has_line(panels, number, level) for number, level in enumerate(levels))


def _has_line(panels: Sequence[Panel], number: int, level: float) -> bool:
    return any(not beside(plane, level) for panel in panels for plane in panel[number])


def broken(
    array: xr.DataArray,
    panels: Sequence[Panel],
    levels: Sequence[float],
    undecided: Sequence[np.ndarray],
) -> Iterator[str]:
    """Which levels have a line with gaps at `undecided` points, shape (points along y, along x)."""
    for number, level in enumerate(levels):
        ends = sum(
            _ends(part, level, unsure)
            for panel, unsure in zip(panels, undecided, strict=True)
            for plane in panel[number]
            for part in plane
        )
        if ends > 1:
            yield (
                f"{_typed(array, level, levels)}: its line has gaps, where points are undecided; a "
                "longer t_max of the analysis decides most"
            )


def jumps_from(at_rest: np.ndarray, plane: np.ndarray) -> bool:
    """Whether what rests has one value, from which all else jumps; of what varies there none."""
    rests, known = at_rest[np.isfinite(at_rest)], plane[np.isfinite(plane)]
    if min(rests.size, known.size) == 0:
        return False
    return bool(np.ptp(rests) <= FLAT * np.ptp(known))


def along_jumps(
    array: xr.DataArray,
    panels: Sequence[Panel],
    at_rest: Sequence[np.ndarray],
    levels: Sequence[float],
) -> Iterator[str]:
    """Which lines lead in part along a jump to rest, or alone of several: no point has their level
    there. `at_rest` has a number of each panel where it rests."""
    met = []
    drawn = [(n, level) for n, level in enumerate(levels) if _has_line(panels, n, level)]
    for number, level in drawn:
        jumps, passed = 0, 0
        for panel, rests in zip(panels, at_rest, strict=True):
            planes = (one for one in panel[number] if len(one) == 1 and jumps_from(rests, one))
            for plane in planes:
                parts = (np.where(np.isfinite(rests) == here, plane, np.nan) for here in (0, 1))
                every = int(_crossed(plane, level).sum())
                jumps += every - sum(int(_crossed(part, level).sum()) for part in parts)
                passed += every
        if jumps and (len(levels) > 1 or jumps < MOSTLY * passed):
            met.append(level)
    if met:
        told = f"{_named(met, levels)} {labels.unit_text(str(array.attrs.get('units', '1')))}"
        others = "; no other line leads along it" if len(met) < len(drawn) else ""
        yield (
            f"{array.name} = {told.rstrip()}: along a jump to rest the line is the border, "
            f"half-way between the points{others} (border = false: all end there)"
        )


def scattered(
    array: xr.DataArray, panels: Sequence[Panel], levels: Sequence[float]
) -> Iterator[str]:
    """Which levels have a line in islands that are no larger than the grid tells, as on a ridge."""
    for number, level in enumerate(levels):
        if (islands := _count_islands(panels, number, level)) >= MANY_ISLANDS:
            yield (
                f"{_typed(array, level, levels)}: its line falls into {islands} islands of "
                f"{ISLAND} points or fewer, as along a ridge: a larger num, or another level"
            )


def _count_islands(panels: Sequence[Panel], number: int, level: float) -> int:
    parts = (part for panel in panels for plane in panel[number] for part in plane)
    return sum(int(label(one)[1]) for part in parts for one in _islands(part, level))


def steep(
    array: xr.DataArray,
    axes: tuple[xr.DataArray, xr.DataArray],
    panels: Sequence[Panel],
    levels: Sequence[float],
) -> Iterator[str]:
    """Which levels all run round the same few points, and where: a grid tells no more of a jump."""
    on, places = set[float](), dict[tuple[int, int], None]()
    for panel in panels:
        mine = [
            np.any([_leaps(part, level) for plane in planes for part in plane], axis=0)
            for planes, level in zip(panel, levels, strict=True)
        ]
        for y, x in np.argwhere(np.sum(mine, axis=0) > 1).tolist():
            places[y, x] = None
            on |= {level for level, own in zip(levels, mine, strict=True) if own[y, x]}
    if places:
        told = _named([level for level in levels if level in on], levels)
        place = _place(axes, next(iter(places)))
        more = " and other points" * (len(places) > 1)
        yield (
            f"{array.name} = {told}: their lines run round {place}{more}, where it jumps or the "
            "grid is coarse: an axis that ends beside it, or a larger num"
        )


def _leaps(part: np.ndarray, level: float) -> np.ndarray:
    """Points of small islands at a level from which it is far to a neighbour, and then no more."""
    islands, found = np.any(_islands(part, level), axis=0), np.zeros(part.shape, bool)
    for turns in range(4):  # each way in turn
        own, there, out = (np.rot90(one, turns) for one in (part, islands, found))
        first, second = np.abs(own[:-2] - own[1:-1]), np.abs(own[1:-1] - own[2:])
        out[:-2] |= there[:-2] & ~there[1:-1] & (first > LEAP * second)
    return found


def saddles(
    array: xr.DataArray,
    axes: tuple[xr.DataArray, xr.DataArray],
    panels: Sequence[Panel],
    levels: Sequence[float],
) -> Iterator[str]:
    """Which levels lie between four points such that both ways of joining them are right.

    None of those whose lines are `scattered`.
    """
    found = {
        level: np.concatenate(
            [_saddles(part, level) for panel in panels for plane in panel[number] for part in plane]
        )
        for number, level in enumerate(levels)
        if _count_islands(panels, number, level) < MANY_ISLANDS
    }
    met = [level for level, cells in found.items() if cells.size]
    if met:
        cells = np.concatenate([found[level] for level in met])
        between = _place(axes, cells[0], cells[0] + 1)
        more = " and elsewhere" * (len(cells) > 1)
        yield (
            f"{array.name} = {_named(met, levels)}: "
            f"between {between}{more} the points do not tell which of them its lines part, as on a "
            "saddle: a larger num does"
        )


def _saddles(part: np.ndarray, level: float) -> np.ndarray:
    """Cells, shape (n, 2), of which the corners across lie on one side of a level, both pairs.

    None at a leap, round which its lines run whichever way they are joined.
    """
    if min(part.shape) < 2:
        return np.zeros((0, 2), int)
    known = np.isfinite(part) & ~_leaps(part, level)
    values, sound = (sliding_window_view(one, (2, 2)).reshape(-1, 4) for one in (part, known))
    above = values > level
    across = (above[:, 0] == above[:, 3]) & (above[:, 1] == above[:, 2])
    is_saddle = sound.all(axis=1) & across & (above[:, 0] != above[:, 1])
    return np.argwhere(is_saddle.reshape(part.shape[0] - 1, -1))


def _named(some: Sequence[float], levels: Sequence[float]) -> str:
    """Some of the levels, in words."""
    return listed([labels.number_text(level, levels) for level in some])


def _place(axes: tuple[xr.DataArray, xr.DataArray], *points: Sequence[int] | np.ndarray) -> str:
    """Where points (row, column) lie: ``v = 1 and 2, N = 3 and 4``."""
    return ", ".join(
        f"{axis.name} = {' and '.join(_number(axis, int(at[number])) for at in points)}"
        for axis, number in zip(axes, (1, 0), strict=True)
    )


def _number(axis: xr.DataArray, index: int) -> str:
    """A place along an axis."""
    value = axis.values[index]
    return (
        labels.number_text(float(value), axis.values.tolist())
        if axis.dtype.kind == "f"
        else str(value)
    )


def _islands(part: np.ndarray, level: float) -> list[np.ndarray]:
    """Groups of so few neighbours on one side of a level among those on the other, of each side.

    What lies beside a point that is not known may be larger.
    """
    known, above = np.isfinite(part), part > level
    beside_unknown, found = binary_dilation(~known), []
    for side in (known & above, known & ~above):
        groups = label(side)[0]
        few = np.bincount(groups.ravel()) <= ISLAND
        few[groups[beside_unknown | ~side]] = False
        found.append(few[groups])
    return found


def _crossed(plane: np.ndarray, level: float) -> np.ndarray:
    """Between which neighbours, along y and then along x, the level is passed."""
    side = np.where(np.isfinite(plane), np.where(plane > level, 1, -1), 0)
    steps = side[:, 1:] * side[:, :-1], side[:, :, 1:] * side[:, :, :-1]
    return np.concatenate([np.ravel((step < 0).any(axis=0)) for step in steps])


def _ends(part: np.ndarray, level: float, undecided: np.ndarray) -> int:
    """How often a line ends inside a part of a plane because what lies ahead is undecided.

    It ends between two known neighbours on either side of the level: of a row, a column, or across
    the corner of a cell that is not known (there it leads through triangles).
    """
    if min(part.shape) < 2:
        return 0
    unsure = undecided & np.isnan(part)
    of_rows = sum(_ends_beside_rows(*one, level) for one in ((part, unsure), (part.T, unsure.T)))
    cells, ahead = (sliding_window_view(one, (2, 2)).reshape(-1, 4) for one in (part, unsure))
    alone = ahead.any(axis=1) & (np.isnan(cells).sum(axis=1) == 1)
    outer = np.isnan(cells[:, [0, 3]]).any(axis=1, keepdims=True)
    across = np.where(outer, cells[:, [1, 2]], cells[:, [0, 3]]) > level  # corners beside that one
    return of_rows + int((alone & (across[:, 0] != across[:, 1])).sum())


def _ends_beside_rows(values: np.ndarray, unsure: np.ndarray, level: float) -> int:
    """Of the lines that pass between two neighbours of a row, to the rows beside it."""
    above = values > level
    passed = np.isfinite(values[:, 1:] + values[:, :-1]) & (above[:, 1:] != above[:, :-1])
    unknown = np.isnan(values[:, 1:]) & np.isnan(values[:, :-1])
    stops = unknown & (unsure[:, 1:] | unsure[:, :-1])
    return int((passed[1:] & stops[:-1]).sum() + (passed[:-1] & stops[1:]).sum())


def beside(plane: np.ndarray, level: float) -> str:
    """On which side of the level a plane lies, or its parts; nothing where a line leads through."""
    sides = {side(part, level) for part in plane} - {NOT_KNOWN}
    if "" in sides or len(sides) < 2:
        return "" if "" in sides else "".join(sides) or NOT_KNOWN
    jumps = (_jumps_over(*pair, level=level) for pair in combinations(plane, 2))
    return IN_A_JUMP if any(jumps) else ALONE


def _jumps_over(one: np.ndarray, other: np.ndarray, *, level: float) -> bool:
    """Whether a point of one part and a neighbour of the other lie on either side of the level."""
    of_one, of_other = (
        np.where(np.isfinite(part), np.where(part > level, 1, -1), 0) for part in (one, other)
    )
    turned = ((np.rot90(of_one, turns), np.rot90(of_other, turns)) for turns in range(4))
    return any(bool((here[1:] * there[:-1] < 0).any()) for here, there in turned)


def side(part: np.ndarray, level: float) -> str:
    """On which side of the level it lies as a whole; nothing where the level runs through it."""
    known = part[np.isfinite(part)]
    if known.size == 0:
        return NOT_KNOWN
    if known.max() <= level:
        return "below everywhere" if known.max() < level else "at most so much everywhere"
    if known.min() >= level:
        return "above everywhere" if known.min() > level else "at least so much everywhere"
    return "" if _is_passed(part, level) else ALONE


def _is_passed(part: np.ndarray, level: float) -> bool:
    """Whether a line leads through it: between three points, or four, that are neighbours."""
    cells = sliding_window_view(part, (2, 2)).reshape(-1, 4) if min(part.shape) > 1 else NO_CELLS
    cells = cells[np.isfinite(cells).sum(axis=1) > 2]
    return bool(_passed(cells, level).any())


def _passed(cells: np.ndarray, level: float) -> np.ndarray:
    """In which cells, some of whose points are known, the level lies between two of these."""
    return np.asarray((np.nanmin(cells, axis=1) <= level) & (level < np.nanmax(cells, axis=1)))


def _typed(array: xr.DataArray, level: float, levels: Sequence[float]) -> str:
    """A level by the name that a case has it by."""
    unit = labels.unit_text(str(array.attrs.get("units", "1")))
    return f"{array.name} = {labels.number_text(level, levels)} {unit}".rstrip()


def words(array: xr.DataArray, level: float, levels: Sequence[float]) -> str:
    unit = labels.unit_text(str(array.attrs.get("units", "1")))
    own, value = labels.quantity(array, str(array.name)), labels.number_text(level, levels)
    if is_count(str(array.name)) and level != round(level):
        return f"{own}: {np.floor(level):g} to {np.ceil(level):g}"
    return f"{own} = {value} {unit}".rstrip()
