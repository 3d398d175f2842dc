"""The lines of a curve: what a dataset tells along an axis, for each start and other value."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import product
from typing import TYPE_CHECKING, Any

import numpy as np

from fiv_cli.errors import UsageError
from fiv_cli.flags import NOT_COMPUTED
from fiv_cli.plots import branch, labels, leaps, points, style
from fiv_cli.plots.crossings import joined, modes_of, not_joined, parted
from fiv_cli.plots.mergers import GROWTH, growth_at_mergers
from fiv_cli.plots.turns import up_to_turns
from fiv_cli.reading import select
from fiv_cli.reading.datasets import (
    ends_of,
    error_of,
    flag_names,
    is_class,
    numbers,
    standard_error_of,
    unknown_points,
)
from fiv_cli.reading.shares import ERROR, SURE, sampling_error

if TYPE_CHECKING:
    import xarray as xr

VARIABLE, DATASET = "variable", "dataset"  # what tells lines apart beside dims
MANY_STARTS = 0.45  # of all: however few these are, where so many part an attractor ends
DOT: dict[str, Any] = {"marker": ".", "ms": 3}
TOO_SHORT = 2  # points, at most, of a piece that does not show what its dashes are
SORT_MARKS = (("o", 3.0), ("x", 4.5), ("^", 4.0), ("+", 5.5), ("D", 3.0), ("v", 4.0))
MOST_MARKED = 25  # crossings on a line: of more the marks hide its dashes, and other lines
PLACE: dict[str, Any] = {"marker": "D", "ms": 4}  # of a dataset that lies at one of the axis
RESTS = {"stable": "-", "unstable": ":"}  # their dashes, which are no cycles'
NARROW = 2.5e-3  # of the greatest value: half of what may be, that is told by an error bar

# The pairs of classes that tell crossings apart. To a question about a number motions of one class
# may give two answers; then these tell.
CLASSES, ANSWERS = ("class_below", "class_above"), ("answer_below", "answer_above")
SORTS = (("crossing_kind", "crossing_direction"), CLASSES, ANSWERS)
# What becomes of a sliding equilibrium as the parameter rises.
BECOMES = {
    "to_stable": "a mode turns stable",
    "to_unstable": "a mode turns unstable",
    "lost": "equilibrium ends",
    "gained": "equilibrium begins",
}


def equilibria(layer: points.Layer, axis: xr.DataArray, births: np.ndarray) -> Iterator[Curve]:
    """The equilibria of a case, whose amplitude is none: what eigenvalues tell of them, along an
    axis, and `births` of cycles where they turn stable or unstable.

    Motions come to the stable ones, but not up to where these end.
    """
    told = (one for one in layer.beside if {"stable", "growth_rate"} <= {*one})
    judged = next((one for one in told if select.has_axis(one, str(axis.name))), None)
    if judged is None:
        return
    own = select.axis_of(judged, str(axis.name))
    x, dim = points.positions(own), str(own.dims[0])
    known = is_class(judged["stable"], (*RESTS,))
    for word, dash in RESTS.items():
        of_word = is_class(judged["stable"], (word,))
        for line in points.lines(judged, [dim], points.grid_dims(judged)):
            every, y = (
                np.where(one.isel(line.index).values, 0.0, np.nan) for one in (known, of_word)
            )
            if np.isfinite(y).any():
                growth = judged["growth_rate"].isel(line.index).values
                at, y, turns, _ = up_to_turns(births, x, every, y, growth)
                what = at, y, np.zeros(at.size, bool), (y, y), np.zeros(at.size)
                look: dict[str, Any] = {"dash": dash, "mark": {"marker": "None"}}
                words = {DATASET: layer.label, **line.words}
                yield Curve(words, *what, **look, sort=f"{word} equilibrium", between=turns)


@dataclass(frozen=True)
class Curve:
    """One line: the words for its place by dim, and for its variable if several share the panel.

    `open` are the points whose class is undecided: their numbers are those of some stretch of time.
    `ends` are the least and the greatest that each may be, `error` is how far it may be off:
    infinite where that is not known. `jumps` are the places at which another class begins. `sort`
    is what `dash` and `mark` mean, where colours mean another thing. A line `of_crossings` has no
    gaps. No error reaches beyond the `limits`, such as 0 and 1 of a share. `names` are the labels
    of all for which it stands. Of a part of a line the `way` leads to its points, too. Pieces of
    no more than `short` points have marks by all means. `apart` are neighbours with crossings both,
    or whose motions are of one class, between which no line leads. Of its points those `between`
    two of the grid, shape (n, 2), were not computed. It has a gap where its motion `leaves_class`.
    """

    words: Mapping[str, str]
    x: np.ndarray
    y: np.ndarray
    open: np.ndarray
    ends: tuple[np.ndarray, np.ndarray]
    error: np.ndarray
    jumps: Sequence[int] = ()
    dash: Any = "-"
    mark: Mapping[str, Any] = field(default_factory=lambda: DOT)
    sort: str = ""
    of_crossings: bool = False
    limits: tuple[float, float] = (-np.inf, np.inf)
    names: tuple[str, ...] = ()
    way: np.ndarray = field(default_factory=lambda: np.zeros(0))
    short: int = 1
    apart: tuple[tuple[float, float], ...] = ()
    between: np.ndarray = field(default_factory=lambda: np.zeros((0, 2)))
    leaves_class: bool = False

    @property
    def is_branch(self) -> bool:
        """Whether it is a branch of cycles, close enough to each other for a smooth line."""
        return self.sort.endswith(" cycle")

    @property
    def is_rest(self) -> bool:
        """Whether it is an equilibrium beside cycles."""
        return self.sort.endswith(" equilibrium")

    def marked_as_others(self) -> Curve:
        """The same; of crossings whose mark tells nothing, with that of other lines, where they
        have theirs."""
        if not self.of_crossings or self.sort:
            return self
        return replace(self, mark=DOT, of_crossings=False)

    def hides(self, other: Curve) -> bool:
        """Whether it would lie upon another, mark by mark."""
        if not self.can_hide(other) or [*self.jumps] != [*other.jumps]:
            return False
        return bool(self.agrees_with(other).all())

    def can_hide(self, other: Curve) -> bool:
        """Whether it has the points of another."""
        plain = not (self.sort or self.of_crossings)
        return plain and np.array_equal(self.x, other.x)

    def agrees_with(self, other: Curve) -> np.ndarray:
        """At which points it would lie upon another that has the same."""
        own, others = ((one.y, one.error, *one.ends) for one in (self, other))
        pairs = zip(own, others, strict=True)
        near = [np.isclose(a, b, rtol=points.UPON, atol=0.0, equal_nan=True) for a, b in pairs]
        return np.asarray(np.all([*near, self.open == other.open], axis=0))

    def only(self, part: np.ndarray) -> Curve:
        """What there is of it at some points, and what leads to them from those beside."""
        y, error, low, high = (
            np.where(part, one, np.nan) for one in (self.y, self.error, *self.ends)
        )
        whole = ~np.isin(np.arange(1, part.size), self.jumps)
        to, after = np.append(part[1:] & whole, False), np.append(False, part[:-1] & whole)
        sure = ~self.open & ~self.is_wide
        way = np.where((part | to | after) & sure, self.y, np.nan)
        return replace(self, y=y, error=error, ends=(low, high), open=self.open & part, way=way)

    @property
    def label(self) -> str:
        """All of its words."""
        return self.without("")

    def without(self, dim: str) -> str:
        """Its words but those of a dim."""
        return points.joined(*(word for own, word in self.words.items() if own != dim))

    @property
    def is_random(self) -> bool:
        """Whether it is of a member of random starts."""
        return points.stem(self.label) != self.label

    @property
    def known(self) -> np.ndarray:
        """At which points it has a value."""
        return np.asarray(np.isfinite([self.y, *self.ends]).any(axis=0))

    @property
    def has_lone(self) -> bool:
        """Whether to some of its points no line leads, or one too short for its dashes."""
        sure = np.where(self.known & ~self.open & ~self.is_wide, 1.0, np.nan)
        known = np.isfinite(np.insert(sure, self.jumps, np.nan))
        return bool(points.alone(known, TOO_SHORT).any())

    @property
    def whole_way(self) -> np.ndarray:
        """What its line leads through, with its gaps."""
        sure = np.where(self.open | self.is_wide, np.nan, self.y)
        return np.insert(self.way if self.way.size else sure, self.jumps, np.nan)

    @property
    def pieces(self) -> int:
        """In how many its line is drawn, points that stand alone among them."""
        known = np.isfinite(self.whole_way)
        return int((known & ~np.append(False, known[:-1])).sum())

    @property
    def is_known(self) -> bool:
        """Whether it has any value."""
        return bool(self.known.any())

    @property
    def is_marked(self) -> bool:
        """Whether its points have marks."""
        return not self.of_crossings or self.x.size <= MOST_MARKED

    @property
    def is_wide(self) -> np.ndarray:
        """Where it may be more than one number."""
        return self.ends[0] < self.ends[1]


def _through_mergers(curve: Curve, part: xr.Dataset, axis: xr.DataArray) -> Curve:
    """A line of growth rates with the places at which modes merge between its points."""
    if not {"eigenvalue_real", "coupling_point"} <= {*part}:
        return curve
    after, places, growth = growth_at_mergers(part, axis)
    x, y = np.insert(curve.x, after, places), np.insert(curve.y, after, growth)
    low, high = (np.insert(end, after, growth) for end in curve.ends)
    return replace(
        curve,
        x=x,
        y=y,
        open=np.insert(curve.open, after, False),
        ends=(low, high),
        error=np.insert(curve.error, after, 0.0),
        jumps=[at + int((after <= at).sum()) for at in curve.jumps],
        between=np.column_stack([places, growth]),
    )


def lines_of(
    layer: points.Layer,
    name: str,
    named: bool,
    of_panels: Mapping[str, points.Settings],
    sorts: Sequence[str],
    over: bool,
) -> list[Curve]:
    """The lines of one variable of one dataset; their labels have its words if it is `named`.

    All variables of a figure leave a motion at the same points. `sorts` are those of the crossings
    of all datasets. What lies `over` branches is called by its start, if by nothing else.
    """
    dataset = layer.dataset
    axis = points.abscissa(dataset, of_panels[name])
    array = numbers(dataset[name])
    dim = str(axis.dims[0])
    if dim not in array.dims or select.row_sizes(dataset, name) is not None:
        raise UsageError(
            f"{name}: not one value per point along {axis.name}\n"
            f"it varies along: {', '.join(map(str, array.dims)) or 'nothing'}"
        )
    x, words = points.positions(axis), labels.name_of(dataset[name]) if named else ""
    if "crossing" in array.dims and _sorting(dataset):
        return _by_sort(layer, array, words, axis, sorts)
    unsure = unknown_points(dataset, name, allow_undecided=True).broadcast_like(array)
    classes = dataset.get("attractor", dataset["status"]).broadcast_like(array)
    errors = _errors(dataset, array)
    numeric = [own for own in of_panels if own in dataset and not flag_names(dataset[own].attrs)]
    alike = [own for own in numeric if dataset[own].dims == array.dims and own != "share"]
    every = array, unsure & array.notnull(), classes, errors, *ends_of(dataset, name)
    motions, held = _Motions(dataset), {own: numbers(dataset[own]) for own in {name, *alike}}
    curves = []
    for line in points.lines(dataset, [dim], [str(d) for d in array.dims]):
        y, open_, told, error, *ends = (one.isel(line.index).values for one in every)
        y, error, ends = _narrowed(y, error, ends)
        differ = told[1:] != told[:-1]
        apart = differ | parted(axis)
        left = np.logical_or.reduce(
            [_leaves(motions, one, line.index, of_panels[own]) for own, one in held.items()]
        )
        jumps = (np.flatnonzero(apart | left) + 1).tolist()
        shown = np.isfinite(np.where(open_, np.nan, y))
        steps = np.flatnonzero(left & ~apart & shown[1:] & shown[:-1])
        told_by = {VARIABLE: words, DATASET: layer.label, **line.words}
        if over and not any(told_by.values()) and dataset.sizes.get("initial") == 1:
            told_by["initial"] = f"start: {dataset['initial'].item()}"
        limits = (0.0, 1.0) if name == "share" else (-np.inf, np.inf)
        of_line = x, y, open_, (ends[0], ends[1]), error, jumps
        pairs = tuple((x[at], x[at + 1]) for at in steps)
        leaves = bool((differ & ~parted(axis) & shown[1:] & shown[:-1]).any())
        curve = Curve(told_by, *of_line, limits=limits, apart=pairs, leaves_class=leaves)
        part = dataset.isel(line.index) if name == GROWTH else None
        curves.append(curve if part is None else _through_mergers(curve, part, axis))
    return curves


@dataclass(frozen=True)
class _Motions:
    """What tells the motions of a dataset apart, of all of its lines."""

    dataset: xr.Dataset

    @cached_property
    def kinds(self) -> xr.DataArray:
        """How often each passes the section, and what sticks on it."""
        return leaps.kinds(self.dataset)

    @cached_property
    def marks(self) -> list[xr.DataArray]:
        """What leaps from one to another."""
        return [*leaps.marks_of_motions(self.dataset)]


def _leaves(
    motions: _Motions, array: xr.DataArray, index: Mapping[str, int], settings: points.Settings
) -> np.ndarray:
    """Between which neighbours along a line a variable goes over to another motion; not where the
    line of another start has these values and goes on."""
    left = _leaves_alone(motions, array, index, settings)
    for start in range(array.sizes.get("initial", 1) if left.any() and "initial" in index else 0):
        there = {**index, "initial": start}
        met = np.isclose(array.isel(index), array.isel(there), rtol=leaps.SAME, atol=0.0)
        if (shared := left & met[1:] & met[:-1]).any():
            left = left & ~(shared & ~_leaves_alone(motions, array, there, settings))
    return left


def _leaves_alone(
    motions: _Motions, array: xr.DataArray, index: Mapping[str, int], settings: points.Settings
) -> np.ndarray:
    """The same, by what is known of the line itself."""
    fixed = {dim: at for dim, at in index.items() if dim != "initial"}  # of all starts
    y, starts = array.isel(index).values, array.isel(fixed)
    left = leaps.changes_over(
        y, starts.transpose(..., *array.isel(index).dims).values.reshape(-1, y.size)
    )
    if array.name == "share":
        starts = motions.dataset.get(_standard_error("share"), array).attrs.get("starts", 0)
        return left | _ends_of_an_attractor(y, starts)
    marks = [one.isel(index, missing_dims="ignore") for one in motions.marks]
    plain = motions.kinds.broadcast_like(array).isel(index).values
    kinds, surely = leaps.told_apart(plain, marks)
    left = left | leaps.of_changing_passages(plain)
    if "contact" in array.dims:
        left = left | leaps.of_a_handover(plain)
    shown, logarithmic = points.shown_of(settings, y), points.is_logarithmic(settings, "y")
    return left | leaps.leaps(y, kinds, shown, logarithmic, surely)


def _ends_of_an_attractor(share: np.ndarray, starts: int) -> np.ndarray:
    """Between which neighbours all of some starts, or none, reach something on one side, and many
    others on the other; else a share may step as it likes, and by a start or two there too."""
    steps, last = np.abs(np.diff(share)), np.isin(share, (0.0, 1.0))
    apart = np.diff(np.unique([0.0, 1.0, *share[np.isfinite(share)]]))
    quantum = 1.0 / starts if starts else apart[apart > leaps.SAME].min()
    is_great = steps > max(leaps.SEEN_ALONE, min(leaps.STEP * quantum, MANY_STARTS))
    leap = [leaps.leaps(one, np.ones(one.size), (0.0, 1.0), False) for one in (share, 1.0 - share)]
    return np.asarray((last[1:] | last[:-1]) & is_great & (leap[0] | leap[1]))


def _narrowed(
    y: np.ndarray, error: np.ndarray, ends: list[np.ndarray]
) -> tuple[np.ndarray, np.ndarray, list[np.ndarray]]:
    """Values and errors where the ends of what may be lie too close to be told apart in a figure.

    One undecided start of thousands leaves a share as good as known.
    """
    low, high = ends
    half, greatest = 0.5 * (high - low), np.abs(high[np.isfinite(high)]).max(initial=0.0)
    narrow = (half > 0.0) & (half <= NARROW * greatest)
    middle = np.where(narrow, high - np.where(narrow, half, 0.0), y)
    bar = np.where(narrow, half + np.where(np.isfinite(error), error, 0.0), error)
    return middle, bar, [np.where(narrow, middle, end) for end in ends]


def lines_of_branches(
    layer: points.Layer,
    name: str,
    axis: xr.DataArray,
    named: bool,
    several: bool,
    beside_starts: bool,
) -> list[Curve]:
    """What branches along the abscissa tell of the variable, if there are any.

    They are called by the variable if that is `named`, those of `several` datasets, or of one with
    a name of its own, by that, and by their start where nothing stands `beside_starts`: what of
    these leads there is not told by a branch.
    """
    curves, own = [], layer.label if several or layer.dataset.attrs.get("called") else ""
    for line, word, x, y in branch.told_of(layer.dataset, str(axis.name), name):
        sure = np.zeros(x.size, bool)
        look: dict[str, Any] = {"dash": branch.DASHES.get(word, "-"), "mark": {"marker": "None"}}
        what = x, y, sure, (y, y), np.zeros(x.size)
        kept = {dim: told for dim, told in line.words.items() if dim != "initial"}
        called = labels.name_of(layer.dataset[name]) if named else ""
        words = {VARIABLE: called, DATASET: own, **(kept if beside_starts else line.words)}
        curves.append(Curve(words, *what, **look, sort=f"{word} cycle"))
    return curves


def lines_without_axis(
    layer: points.Layer, name: str, named: bool, first: xr.Dataset, axis: xr.DataArray
) -> list[Curve]:
    """The values of a dataset that does not vary along the abscissa, each over all of it.

    One that differs from the first in its place there alone has that place.
    """
    array, x = numbers(layer.dataset[name]), points.positions(axis)
    called = {VARIABLE: labels.name_of(array) if named else "", DATASET: layer.label}
    at = np.array([x.min(), x.max()])
    if _is_at_one_place(layer.dataset, first, axis):
        at = layer.dataset[axis.name].values.reshape(1).astype(float)
    flat = [
        ({**called, **line.words}, np.full(at.size, float(array.isel(line.index))))
        for line in points.lines(layer.dataset, [], [str(dim) for dim in array.dims])
    ]
    sure, mark = np.zeros(at.size, bool), {"marker": "None"} if at.size > 1 else PLACE
    return [
        Curve(words, at, y, sure, (y, y), np.zeros(at.size), mark=mark)
        for words, y in flat
        if np.isfinite(y).all()
    ]


def _is_at_one_place(dataset: xr.Dataset, first: xr.Dataset, axis: xr.DataArray) -> bool:
    """Whether all parameters of a dataset but the axis are those of the first, or among them."""
    own, known = ({str(n): one for n, one in of.coords.items()} for of in (dataset, first))
    fixed = [n for n, one in own.items() if one.ndim == 0 and select.is_numeric(one) and n in known]
    rest = [n for n in fixed if n != axis.name]
    return axis.name in fixed and all(np.isin(own[n], known[n]).all() for n in rest)


def _by_sort(
    layer: points.Layer,
    array: xr.DataArray,
    words: str,
    axis: xr.DataArray,
    every: Sequence[str],
) -> list[Curve]:
    """Lines of crossings of one sort: a colour for each or, where colours tell lines, a dash.

    Each of `every` sort looks the same in all datasets of a figure.
    """
    dataset, x, dim = layer.dataset, points.positions(axis), str(axis.dims[0])
    sorts, errors, modes = sorts_of(dataset), _errors(dataset, array), modes_of(dataset, array)
    along = [str(d) for d in array.dims if d != "crossing"]
    curves = []
    for line in points.lines(dataset, [dim], along):
        told_by = {VARIABLE: words, DATASET: layer.label, **line.words}
        is_told = any(told_by.values())
        for sort, mask in sorts.items() if len(every) > 1 else [("", True)]:
            number = every.index(sort) if sort else 0
            dash = style.dash(number, len(every))
            mark = dict(zip(("marker", "ms"), SORT_MARKS[number % len(SORT_MARKS)], strict=True))
            kept, error, mode = (
                part.where(mask).isel(line.index).transpose(dim, "crossing").values
                for part in (array, errors, modes)
            )
            lines = joined(axis, kept, mode)
            steps = [(x[at], x[at + 1]) for at in not_joined(axis, kept, lines)]
            for place, places in enumerate(lines):
                at = tuple(np.array(places).T)
                unsure = np.zeros(len(places), bool)
                found = (x[at[0]], kept[at], unsure, (kept[at], kept[at]), error[at])
                dashed = {"dash": dash, "mark": mark, "sort": sort} if is_told else {}
                own = told_by if is_told else {"sort": sort}
                apart = tuple(steps) if not place else ()  # told once
                curves.append(Curve(own, *found, **dashed, of_crossings=True, apart=apart))
    return curves


def _errors(dataset: xr.Dataset, array: xr.DataArray) -> xr.DataArray:
    """How far each value may be off, infinite where it is not known; 0 for one that does not say.

    Of what is a mean of a sample it is the standard error; of what all of it show, or none, how far
    it may be off all the same.
    """
    name = str(array.name)
    if error_of(name) in dataset:
        known = dataset[error_of(name)].where(~is_edge(dataset, name))
        return numbers(known).fillna(np.inf).broadcast_like(array)
    error = dataset.get(_standard_error(name), 0.0 * array)
    if "starts" in error.attrs:
        error = sampling_error(dataset)
    return error.broadcast_like(array)


def is_edge(dataset: xr.Dataset, name: str) -> xr.DataArray:
    """Where the end of a branch is an edge of its bracket, beyond which it may go on."""
    kind = f"{name}_kind"
    return is_class(dataset.get(kind, dataset[name] * np.nan), ("bracket",))


def _standard_error(name: str) -> str:
    """What says how far the mean of a sample may be off, in a dataset that has it."""
    return ERROR if name == "share" else standard_error_of(name)


def told_by_bars(dataset: xr.Dataset, name: str) -> str:
    """What the error bars of a variable tell."""
    error = dataset.get(_standard_error(name))
    if error is None or not bool(error.notnull().any()):
        return "error bound" * (error_of(name) in dataset)
    certain = "starts" in error.attrs and bool((sampling_error(dataset) > error).any())
    return "standard error" + f"; at 0 and 1: {1.0 - SURE:.0%} bound" * certain


def _sorting(dataset: xr.Dataset) -> tuple[str, str] | None:
    """The pair of classes that tells the crossings of a dataset apart, if it has one."""
    pair = next((pair for pair in SORTS if all(name in dataset for name in pair)), None)
    return ANSWERS if pair == CLASSES and _is_of_a_number(dataset) else pair


def _is_of_a_number(dataset: xr.Dataset) -> bool:
    """Whether some change has one and the same class on both sides."""
    below, above = (numbers(dataset[name]) for name in CLASSES)
    return all(name in dataset for name in ANSWERS) and bool((below == above).any())


def sorts_of(dataset: xr.Dataset) -> dict[str, xr.DataArray]:
    """What crossings there are (``a mode turns stable``) -> which ones are of that sort."""
    pair = _sorting(dataset)
    if pair is None:
        return {}
    first, second = (dataset[name] for name in pair)
    tables = [flag_names(first.attrs), flag_names(second.attrs)]
    sorts = {}
    for kind, direction in product(*tables):
        mask = (first == kind) & (second == direction)
        if bool(mask.any()) and NOT_COMPUTED not in (tables[0][kind], tables[1][direction]):
            sorts[_sort_words(tables[0][kind], tables[1][direction])] = mask
    return sorts


def _sort_words(first: str, second: str) -> str:
    """What happens at a crossing, or what is below and above it."""
    if second in BECOMES:
        return BECOMES[second] + ", at a jump" * (first == "jump")
    return f"{first} below, {second} above".replace("_", " ")
