"""Branches of cycles: least and greatest value along a parameter, stability, changes and ends."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from itertools import pairwise, permutations
from typing import TYPE_CHECKING, Any, NamedTuple

import matplotlib as mpl
import numpy as np

from fiv_cli.errors import UsageError
from fiv_cli.plots import labels, points, smooth, style
from fiv_cli.reading import select
from fiv_cli.reading.datasets import class_names

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from matplotlib.typing import ColorType

ALONG = "branch_value"
EXTREMES = ("branch_min", "branch_max")
AT_SECTION = "branch_section"
OF_EXTREMES: dict[str, Callable[[np.ndarray, np.ndarray], np.ndarray]] = {
    "min": lambda least, greatest: least,
    "max": lambda least, greatest: greatest,
    "amplitude": lambda least, greatest: 0.5 * (greatest - least),
}
DASHES = {"stable": "-", "unstable": "--", "neutral": "-."}
UNMARKED = ("closed", "not_computed")  # where a closed branch began says nothing of it
MARKS = {
    "fold": "o",
    "flip": "p",
    "torus": "D",
    "branching": "^",
    "grazing": "X",
    "contact_lost": "P",
    "equilibrium": "*",
    "budget": "v",
    "other": "h",
    "bracket": ">",
}
# Where bends lie close together the curve is seen inside their marks.
HOLLOW: dict[str, Any] = {"mfc": "none", "mew": 0.6, "ms": 4.5, "ls": "none"}
TOLD = {"equilibrium": "ends at equilibrium", "bracket": "goes on beyond the bracket"}
LARGER = {"*": 1.7}  # of other marks: a star of their size is a dot
UPON = 5e-3  # of the extent of two branches: no line is as thin
MOST_COMPARED = 300  # cycles of a branch
MOST_BENEATH = 3  # lines that are seen beneath another
SMOOTH = ("fold", "flip", "torus", "branching")  # at which a multiplier passes the unit circle
LEFTWARDS = "<"
UNSEEN = 5e-3  # share of a branch, along and across, below which a piece of it is no line
UNMET = "|"  # what the model asks of its parameters no longer holds


def suits(dataset: xr.Dataset) -> bool:
    """Whether the dataset holds branches of cycles."""
    return ALONG in dataset


def draw(layers: Sequence[points.Layer], settings: points.Settings) -> Figure:
    """A colour for each branch, solid where it is stable; a mark at each change and end."""
    for layer in layers:
        if not suits(layer.dataset):
            raise UsageError(
                "no branch of cycles in this dataset\n"
                "give its analysis of kind `cycle` a parameter and a bracket"
            )
    first = layers[0].dataset
    named = [
        (points.joined(layer.label, line.label), layer.dataset, line.index)
        for layer in layers
        for line in _each_once(layer.dataset)
    ]
    points.refuse_empty(first, bool(named), ALONG)
    figure, (ax,) = style.new_panels(1, 1, points.title(*(one.dataset for one in layers)))
    entries = points.entries([name for name, _, _ in named])
    words = {
        word
        for (_, dataset, index), entry in zip(named, entries, strict=True)
        for word in _branch(ax, dataset, index, entry)
    }
    _name_lines(ax, words)
    name_marks(ax, [dataset for _, dataset, _ in named])
    ax.set_xlabel(labels.axis_label(first[ALONG]))
    greatest = labels.axis_label(first[EXTREMES[1]])
    ax.set_ylabel(greatest.replace("greatest", "least and greatest"))
    points.scale(ax, settings)
    points.legend([ax])
    return figure


def _each_once(dataset: xr.Dataset) -> Iterator[points.Line]:
    """Every branch of a dataset; what all starts lead to once, as theirs."""
    lines = points.lines(dataset, [], points.grid_dims(dataset))
    every = [line for line in lines if _length(dataset, line.index)]
    count = dataset.sizes.get("initial", 1)
    for own in _by_place(every):
        first, *others = (_line(dataset, line.index) for line in own)
        same = all(_lies_on(*pair, 1.0) for one in others for pair in ((first, one), (one, first)))
        shared = {"initial": points.SHARED[count > 2]}
        if len(own) == count > 1 and same:
            yield replace(own[0], words={**own[0].words, **shared})
        else:
            yield from own


def _by_place(lines: Sequence[points.Line]) -> Collection[list[points.Line]]:
    """The lines of all starts at each place of the other axes."""
    beside: dict[tuple[tuple[str, int], ...], list[points.Line]] = {}
    for line in lines:
        rest = tuple((dim, at) for dim, at in line.index.items() if dim != "initial")
        beside.setdefault(rest, []).append(line)
    return beside.values()


def lines_apart(dataset: xr.Dataset) -> Iterator[points.Line]:
    """Every branch but those that lie on that of another start: dashes over dashes would be a line.

    Of two that are one and the same that of the later start.
    """
    for own in _by_place([*_each_once(dataset)]):
        paths = [_line(dataset, line.index) for line in own]
        covered = {
            one
            for one, other in permutations(range(len(own)), 2)
            if _lies_on(paths[one], paths[other], 1.0)
            and (other < one or not _lies_on(paths[other], paths[one], 1.0))
        }
        yield from (line for number, line in enumerate(own) if number not in covered)


def _branch(
    ax: Axes, dataset: xr.Dataset, index: Mapping[str, int], entry: points.Entry
) -> set[str]:
    """One branch: both extremes, in pieces of one stability, and its marks; their stabilities.

    That of an earlier start is wider where later ones lead to one and the same.
    """
    pieces = [*stretches(dataset, index)]
    upon = 0 if entry.label.endswith(points.SHARED) else _upon(dataset, index)
    wide = mpl.rcParams["lines.linewidth"] * (1 + min(upon, MOST_BENEATH))
    for word, value, extremes, _ in pieces:
        for height in extremes:
            told = points.unlisted(entry.label, word)
            look = {"ls": DASHES.get(word, "-"), "color": entry.colour, "lw": wide}
            smooth.draw(ax, value, height, told, **look)
    draw_marks(ax, dataset, index, entry.colour, entry.label)
    ax.plot([], [], color=entry.colour, label=entry.label, **style.COLOUR_ALONE)
    return {piece.stability for piece in pieces}


def _upon(dataset: xr.Dataset, index: Mapping[str, int]) -> int:
    """How many later starts lead to the same branch, or to one that it is a part of."""
    first, count = index.get("initial", 0), dataset.sizes.get("initial", 1)
    own, *others = (_line(dataset, {**index, "initial": n}) for n in range(first, count))
    return sum(_lies_on(own, other) for other in others)


def _line(dataset: xr.Dataset, index: Mapping[str, int]) -> np.ndarray:
    """The parameter along a branch and the extremes there, shape (cycles, 3)."""
    return np.vstack(_heights(dataset, index, at_section=False)).T


def _lies_on(own: np.ndarray, other: np.ndarray, share: float = 0.5) -> bool:
    """Whether so many cycles of a branch, or more, lie on the line through those of another."""
    if not len(own) or len(other) < 2:
        return False
    few = own[:: 1 + len(own) // MOST_COMPARED]
    return bool((off_line(few, other, np.vstack([own, other])) < UPON).mean() >= share)


def off_line(own: np.ndarray, other: np.ndarray, both: np.ndarray) -> np.ndarray:
    """How far points lie off the line through others, in extents of `both`."""
    rounding = np.maximum(style.ROUNDING * np.abs(both).max(axis=0), np.finfo(float).tiny)
    extent = np.maximum(np.ptp(both, axis=0), rounding)
    own, other = own / extent, other / extent
    away, steps = own[:, None] - other[:-1], np.diff(other, axis=0)
    lengths = np.maximum((steps**2).sum(axis=-1), np.finfo(float).tiny)
    along = np.clip((away * steps).sum(axis=-1) / lengths, 0.0, 1.0)
    return np.asarray(np.linalg.norm(away - along[..., None] * steps, axis=-1).min(axis=1))


def draw_marks(
    ax: Axes,
    dataset: xr.Dataset,
    index: Mapping[str, int],
    colour: ColorType,
    whose: str,
    look: Mapping[str, Any] = HOLLOW,
    *,
    at_section: bool = False,
) -> None:
    """A mark at each change and end of a branch, at the heights of the nearest of its cycles.

    Where that shrinks to an equilibrium these are one: the middle of its extremes, from which the
    section of so small a cycle is still seen to differ.
    """
    value, heights = _heights(dataset, index, at_section)
    _, extremes = _heights(dataset, index, at_section=False)
    for place, at, error, kind in _marks(dataset, index, value):
        mark, told = MARKS.get(kind, UNMET), points.unlisted(whose, _words(kind))
        mark = LEFTWARDS if kind == "bracket" and at < value.mean() else mark
        wide = LARGER.get(mark, 1.0) * look["ms"]
        here = heights[:, place]
        here = extremes[:, place].mean(keepdims=True) if kind == "equilibrium" else here
        for height in here:
            ax.plot(at, height, mark, color=colour, zorder=4.5, label=told, **{**look, "ms": wide})
        if error > 0.0:
            ends = at - error, at + error
            ax.hlines(here, *ends, colour, lw=0.8, label=f"{told}, error bar")


def is_along(dataset: xr.Dataset, parameter: str, observed: str) -> bool:
    """Whether it holds branches, along `parameter`, and they tell the extremes of `observed`."""
    words = str(dataset[EXTREMES[0]].attrs.get("long_name", "")) if suits(dataset) else ""
    return leads_along(dataset, parameter) and f" {observed} " in words


def leads_along(dataset: xr.Dataset, parameter: str) -> bool:
    """Whether it holds branches along `parameter`, of whichever state they tell."""
    return parameter_of(dataset) == parameter


def parameter_of(dataset: xr.Dataset) -> str:
    """The parameter along which it holds branches; "" of one that holds none."""
    words = str(dataset[ALONG].attrs.get("long_name", "")) if suits(dataset) else ""
    return words.partition(" ")[0]


def changes(dataset: xr.Dataset) -> np.ndarray:
    """Where along the parameter branches change, or end within their bracket."""
    kinds = _kinds(dataset)
    return np.asarray(dataset["cycle_end"].values[kinds != "bracket"])


def told_of(
    dataset: xr.Dataset, parameter: str, variable: str
) -> Iterator[tuple[points.Line, str, np.ndarray, np.ndarray]]:
    """Place, stability, `parameter` and a variable of motions along the pieces of branches.

    Of variables of the steady state that are the extremes of what branches tell, or their half
    distance.
    """
    observed, _, of = variable.rpartition("_")
    if of in OF_EXTREMES and is_along(dataset, parameter, observed):
        for line in lines_apart(dataset):
            for word, value, extremes, _ in stretches(dataset, line.index):
                yield line, word, value, OF_EXTREMES[of](*extremes)


def births_along(datasets: Iterable[xr.Dataset], axis: str, observed: str) -> np.ndarray:
    """Where branches along an axis end at an equilibrium."""
    along = (one for one in datasets if is_along(one, axis, observed))
    return np.concatenate([np.zeros(0), *map(births, along)])


def births(dataset: xr.Dataset) -> np.ndarray:
    """Where branches end at an equilibrium, from low to high; the same one, to its errors, once."""
    is_one = _kinds(dataset) == "equilibrium"
    ends = dataset["cycle_end"].values, dataset.get("cycle_end_error", dataset["cycle_end"]).values
    at, error = (of[is_one][np.argsort(ends[0][is_one])] for of in ends)
    apart = np.diff(at) > np.nan_to_num(error[1:] + error[:-1])
    return at[np.append(True, apart)[: at.size]]


def meets_sections(dataset: xr.Dataset) -> bool:
    """Whether some cycles are known to pass the section; what never sticks passes no stick."""
    return AT_SECTION in dataset and bool((dataset["branch_multiplicity"] > 0.0).any())


class Stretch(NamedTuple):
    """A piece of a branch, of one stability.

    Attributes
    ----------
    stability : a word of `DASHES`
    value : of the parameter
    heights : both extremes or, `at_section`, what is passed there, the least first
    """

    stability: str
    value: np.ndarray
    heights: list[np.ndarray]
    at_section: bool


def stretches(
    dataset: xr.Dataset, index: Mapping[str, int], *, at_section: bool = False
) -> Iterator[Stretch]:
    """The pieces of a branch; of cycles that pass no section extremes, though these are asked for.

    Pieces meet where the stability changes: at what was bisected, between two cycles that pass as
    often.
    """
    row, ends = _rows(dataset, ALONG, index), _rows(dataset, "cycle_end", index)
    if not _length(dataset, index):
        return
    cycles = np.vstack(_heights(dataset, index, at_section))
    stability = _seen(class_names(dataset["branch_stable"])[row], cycles)
    counts = np.isfinite(cycles).sum(axis=0)  # another one: no value goes on from one to the next
    passes = _passes(dataset, row) if at_section else np.zeros(counts.size, bool)
    counts[passes] *= -1
    differs = (stability[1:] != stability[:-1]) | (counts[1:] != counts[:-1])
    changes = (np.flatnonzero(differs) + 1).tolist()
    known = dataset["cycle_end"].values[ends]
    smooth = np.isin(_kinds(dataset)[ends], SMOOTH)
    alike = [at for at in changes if counts[at - 1] == counts[at]]
    ahead = {at: np.sign(np.diff(cycles[0, max(at - 2, 0) : at])).sum() for at in alike}
    met = {at: _between(cycles[:, at - 1], cycles[:, at], known, smooth, ahead[at]) for at in alike}
    for begin, end in pairwise([0, *changes, len(stability)]):
        joins = [met[at][:, None] if at in met else cycles[:, :0] for at in (begin, end)]
        piece = np.hstack([joins[0], cycles[:, begin:end], joins[1]])
        heights = [height for height in piece[1:] if np.isfinite(height).any()]
        yield Stretch(str(stability[begin]), piece[0], heights, bool(passes[begin]))


def _passes(dataset: xr.Dataset, row: slice) -> np.ndarray:
    """Which cycles pass the section."""
    return np.asarray(dataset["branch_multiplicity"].values[row] > 0.0)


def _seen(stability: np.ndarray, cycles: np.ndarray) -> np.ndarray:
    """The stability of points of a branch; of neutral ones too close to be seen their neighbour's.

    Where a cycle shrinks to an equilibrium its multiplier comes as close to 1 as digits tell.
    """
    words, whole = stability.copy(), _extent(cycles)
    begins = [0, *(np.flatnonzero(words[1:] != words[:-1]) + 1).tolist(), len(words)]
    for begin, end in pairwise(begins):
        beside = [*words[begin - 1 : begin], *words[end : end + 1]]
        is_seen = (_extent(cycles[:, begin:end]) > UNSEEN * whole).any()
        if words[begin] == "neutral" and beside and not is_seen:
            words[begin:end] = beside[0]
    return words


def _extent(cycles: np.ndarray) -> np.ndarray:
    """How far some cycles reach along the parameter, and in what is drawn of them."""
    value, *heights = np.nan_to_num(cycles)
    return np.array([np.ptp(value), max(map(np.ptp, heights), default=0.0)])


def _heights(
    dataset: xr.Dataset, index: Mapping[str, int], at_section: bool
) -> tuple[np.ndarray, np.ndarray]:
    """Values of the parameter along a branch, and extremes there or, if any, what is passed."""
    row = _rows(dataset, ALONG, index)
    value = dataset[ALONG].values[row]
    extremes = np.stack([dataset[name].values[row] for name in EXTREMES])
    if not at_section:
        return value, extremes
    passed = dataset[AT_SECTION].values[_rows(dataset, AT_SECTION, index)]
    heights = columns(passed, dataset["branch_multiplicity"].values[row])
    heights = np.pad(heights, ((0, max(2 - len(heights), 0)), (0, 0)), constant_values=np.nan)
    off = ~_passes(dataset, row)
    heights[:2, off] = extremes[:, off]
    return value, heights


def columns(values: np.ndarray, sizes: np.ndarray) -> np.ndarray:
    """Values of which the first `sizes[0]` belong together, and so on: sorted, a column for each.

    What a column has less than the longest is NaN.
    """
    sizes = sizes.astype(int)
    whole = np.full((sizes.max(initial=0), sizes.size), np.nan)
    for column, part in zip(whole.T, np.split(values, np.cumsum(sizes))[:-1], strict=True):
        column[: part.size] = np.sort(part)
    return whole


def _between(
    before: np.ndarray,
    after: np.ndarray,
    changes: np.ndarray,
    smooth: np.ndarray,
    ahead: float,
) -> np.ndarray:
    """Value of the parameter and extremes where two cycles that follow one another change.

    That is the nearest of the changes, of the `smooth` ones if any is near; at a fold it lies
    beyond both, on the side that lies `ahead` of the first (1: where the parameter is greater; 0:
    not known). None of their own step: midway.
    """
    middle, step = 0.5 * (before[0] + after[0]), abs(after[0] - before[0])
    near = np.abs(changes - middle) <= 1.5 * step
    near &= (np.abs(changes - middle) <= 0.5 * step) | (ahead * (changes - before[0]) >= 0.0)
    near = changes[near & smooth] if (near & smooth).any() else changes[near]
    at = near[np.argmin(np.abs(near - middle))] if near.size else middle
    share = np.clip((at - before[0]) / (after[0] - before[0]), 0.0, 1.0) if step else 0.5
    return np.array([at, *(before + share * (after - before))[1:]])


def _kinds(dataset: xr.Dataset) -> np.ndarray:
    """What each change or end of all branches is; nothing where a dataset does not tell."""
    if "cycle_end_kind" not in dataset:
        return np.full(dataset["cycle_end"].shape, "")
    return class_names(dataset["cycle_end_kind"])


def _length(dataset: xr.Dataset, index: Mapping[str, int]) -> int:
    """Points on the branch of one point of the grid."""
    row = _rows(dataset, ALONG, index)
    return row.stop - row.start


def _rows(dataset: xr.Dataset, name: str, index: Mapping[str, int]) -> slice:
    """Where the values of one point of the grid lie in a ragged variable."""
    sizes = select.row_sizes(dataset, name)
    assert sizes is not None
    ends = np.cumsum(sizes.values.ravel())
    place = int(np.ravel_multi_index([index[str(dim)] for dim in sizes.dims], sizes.shape))
    return slice(int(ends[place] - sizes.values.ravel()[place]), int(ends[place]))


def _marks(
    dataset: xr.Dataset, index: Mapping[str, int], value: np.ndarray
) -> Iterator[tuple[int, float, float, str]]:
    """Point of the branch, value of the parameter, its error and kind of every change.

    At an end of the branch its first or last point, else the nearest: of many at one value, as
    where the branch stands upright, one beside which the stability changes.
    """
    row = _rows(dataset, "cycle_end", index)
    at, error = (dataset[name].values[row].tolist() for name in ("cycle_end", "cycle_end_error"))
    stability = class_names(dataset["branch_stable"])[_rows(dataset, ALONG, index)]
    differs = np.append(stability[1:] != stability[:-1], False)
    beside = differs | np.roll(differs, 1)
    places = [_nearest(value, one, off, beside) for one, off in zip(at, error, strict=True)]
    if len(at) > 1 and "cycle_end_goes_on" in dataset:
        first, *_, last = class_names(dataset["cycle_end_goes_on"])[row] == "no"
        places[0], places[-1] = 0 if first else places[0], value.size - 1 if last else places[-1]
    kinds = class_names(dataset["cycle_end_kind"])[row]
    for place, one, off, kind in zip(places, at, error, kinds, strict=True):
        if kind not in UNMARKED:
            yield place, one, off, str(kind)


def _nearest(value: np.ndarray, at: float, error: float, beside: np.ndarray) -> int:
    """The nearest point; of those no further off than the error, rather one of some `beside`."""
    off = np.abs(value - at)
    near = beside & (off <= off.min() + np.nan_to_num(error))
    return int(np.argmin(np.where(near, off, np.inf) if near.any() else off))


def _name_lines(ax: Axes, stabilities: set[str]) -> None:
    """Legend entries of the dashes that are there."""
    for word, dash in DASHES.items():
        if word in stabilities:
            ax.plot([], [], dash, color=style.BLACK, label=word)


def name_marks(ax: Axes, datasets: Sequence[xr.Dataset], look: Mapping[str, Any] = HOLLOW) -> None:
    """Legend entries of the marks of changes and ends that are there, each as it is drawn."""
    kinds = {str(word) for d in datasets for word in class_names(d["cycle_end_kind"])}
    marks = MARKS | dict.fromkeys(sorted(kinds - {*MARKS, *UNMARKED}), UNMET)
    onwards = [line for line in ax.lines if str(line.get_label()).endswith(_words("bracket"))]
    if {line.get_marker() for line in onwards} == {LEFTWARDS}:
        marks["bracket"] = LEFTWARDS
    for word, mark in marks.items():
        if word in kinds:
            ax.plot([], [], mark, color=style.BLACK, label=_words(word), **look)


def _words(kind: str) -> str:
    """What a change or end is called in a legend."""
    return TOLD.get(kind, kind.replace("_", " "))
