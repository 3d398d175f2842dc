"""The points of a dataset as figures see them: axes, lines, gaps."""

from __future__ import annotations

import itertools
import re
from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import reduce
from typing import TYPE_CHECKING, Any, TypedDict

import numpy as np
from matplotlib.collections import LineCollection
from matplotlib.lines import Line2D
from matplotlib.patches import Rectangle
from matplotlib.ticker import FixedLocator

from fiv_cli.case.overrides import parse_override
from fiv_cli.errors import EmptyFigureError, UsageError
from fiv_cli.flags import ENDED_EARLY
from fiv_cli.notation.names import suggest
from fiv_cli.notation.units import parse_unit
from fiv_cli.plots import labels, legends, style
from fiv_cli.plots.drawn import DECORATION, LEFT_OUT
from fiv_cli.reading import select
from fiv_cli.reading.datasets import flag_names, is_class

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.artist import Artist
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from matplotlib.typing import ColorType


MOST_ENTRIES_INSIDE = 6
LEAST_LETTERS = 70  # side by side, of a figure with a legend inside or beside it
MOST_ENTRIES_IN_COLUMN = 20
MOST_ENTRIES = 2 * MOST_ENTRIES_IN_COLUMN
MOST_TICKS = 24

# The number that a random start's label ends with.
MOST_OF_A_RAMP = 5
# Lines of which more are hard to tell apart where each is in so many pieces.
MANY_IN_PIECES, PIECES = 3, 3
UPON = 1e-6  # relative: values that differ by less are drawn at one place
MOST_COMPARED = 4_000_000  # pairs of points of which it is told whether they are one
VALUE = re.compile(r"= [-+−]?\d[^,=]*$")  # the last of the words of an entry
RANDOM_MEMBER = re.compile(r"-\d{3,}(?=,|$)")


class Settings(TypedDict, total=False):
    """What a figure is asked for: the keys of a ``[[figure]]`` table, checked where it is read."""

    title: str
    words: Mapping[str, str]
    analysis: str
    x: str
    y: str
    variable: str | list[str]
    select: Mapping[str, object]
    take: Mapping[str, Any]
    level: float | list[float] | Mapping[str, float | list[float]]
    contact: int | list[int]
    window: tuple[float | str, float | str]
    overlay: bool
    border: bool
    log: bool | str
    xlim: tuple[float | str, float | str]
    ylim: tuple[float | str, float | str] | Mapping[str, tuple[float | str, float | str]]
    zlim: tuple[float | str, float | str]
    xlabel: str
    zlabel: str
    ylabel: str
    unit: str
    resolution: float | str
    coloured: int  # no key of the table: the contact that is shown, in colours, if it names none


@dataclass(frozen=True)
class Layer:
    """One dataset of a figure; `label` tells it from the others when there are several.

    `beside` are the other analyses of its case, narrowed to what the figure selects.
    """

    label: str
    dataset: xr.Dataset
    beside: tuple[xr.Dataset, ...] = ()


@dataclass(frozen=True)
class Line:
    """One combination of values along the dims that a figure does not spread out.

    `words` has those of each dim that tells it from other lines.
    """

    index: Mapping[str, int]
    words: Mapping[str, str]

    @property
    def label(self) -> str:
        """All of its words."""
        return joined(*self.words.values())


def grid_dims(dataset: xr.Dataset) -> tuple[str, ...]:
    """The grid's dims and, where there are starts, ``initial``; without variables' own dims."""
    return tuple(str(dim) for dim in dataset["status"].dims)


def varying_axes(dataset: xr.Dataset) -> list[xr.DataArray]:
    """One axis for each dim of the grid along which there is more than one point, in order."""
    dims = [dim for dim in grid_dims(dataset) if dataset.sizes[dim] > 1]
    return [_first_axis(dataset, dim) for dim in dims]


def _first_axis(dataset: xr.Dataset, dim: str) -> xr.DataArray:
    """The axis of `dim`: its own coordinate, else the first of those that advance along it."""
    return _axes_along(dataset, dim)[0]


def _axes_along(dataset: xr.Dataset, dim: str) -> list[xr.DataArray]:
    """The axis of `dim`, or the axes that advance along it together."""
    along = [str(name) for name, coord in dataset.coords.items() if coord.dims == (dim,)]
    names = [dim] if dim in along or not along else along
    beside = [name for name in along if name not in names]  # of joined runs, which differ in more
    if names == [dim] and select.axis_of(dataset, dim).dtype.kind == "f":
        names = [dim, *(name for name in beside if dataset.coords[name].dtype.kind == "f")]
    return [select.axis_of(dataset, name) for name in names]


def abscissa(dataset: xr.Dataset, settings: Settings) -> xr.DataArray:
    """The axis that ``x`` names, else the numeric one with the most values, the first of these.

    Raises
    ------
    UsageError : no axis varies, so there is nothing to draw against
    """
    if "x" in settings:
        return select.axis_of(dataset, str(settings["x"]))
    varying = varying_axes(dataset)
    numeric = [axis for axis in varying if select.is_numeric(axis)]
    if not varying:
        raise UsageError(
            "this figure needs an axis along which the dataset varies, and there is none\n"
            "draw a history, or run the case with a [grid]"
        )
    return max(numeric or varying, key=lambda axis: axis.size)


def with_named_places(
    layers: Sequence[Layer], settings: Settings
) -> tuple[Sequence[Layer], Settings]:
    """Layers along a few values that advance together, none of which orders them: their places are
    called by all of these. Not where the figure names the axis."""
    if {"x", "xlim"} & {*settings} or is_logarithmic(settings, "x"):
        return layers, settings
    axis = abscissa(layers[0].dataset, settings)
    dim = str(axis.dims[0])
    if not select.is_numeric(axis) or _is_ordered(axis) or axis.size > MOST_TICKS:
        return layers, settings
    along = [one for one in _axes_along(layers[0].dataset, dim) if select.is_numeric(one)]
    ordered = [str(one.name) for one in along if _is_ordered(one)]
    if ordered and all(_is_ordered(one, standing=True) for one in along):
        return layers, {**settings, "x": ordered[0]}
    if not all(dim in one.dataset.dims for one in layers):
        return layers, settings
    named = [replace(one, dataset=_at_named_places(one.dataset, dim)) for one in layers]
    places = {tuple(one.dataset[dim].values.tolist()) for one in named}
    return (named, {**settings, "x": dim}) if len(places) == 1 else (layers, settings)


def _is_ordered(axis: xr.DataArray, *, standing: bool = False) -> bool:
    """Whether its values rise throughout, or fall, or are those of their dim; `standing`: or stand
    still in part."""
    steps = np.diff(axis.values)
    falls, rises = (steps < 0.0, steps > 0.0) if not standing else (steps <= 0.0, steps >= 0.0)
    return axis.name == axis.dims[0] or bool(falls.all() or rises.all())


def _at_named_places(dataset: xr.Dataset, dim: str) -> xr.Dataset:
    """With the words of the values that advance together as the coordinate of their dim."""
    axes = _axes_along(dataset, dim)
    words = [joined(*labels.values_along(axes, place)) for place in range(dataset.sizes[dim])]
    told = {"symbol": r",\ ".join(labels.symbol(one, str(one.name)) for one in axes)}
    return dataset.assign_coords({dim: (dim, words, told)})


def known_variable(dataset: xr.Dataset, name: str) -> str:
    """`name`, when the dataset has such a variable; UsageError otherwise."""
    known = [str(variable) for variable in dataset.data_vars]
    if name not in known:
        hint = suggest(name, known) or select.computing(name)
        hint = hint or f"it has: {', '.join(known)}"
        raise UsageError(f"{name}: not in this dataset\n{hint}")
    return name


def variables(settings: Settings, default: str | list[str]) -> list[str]:
    """The variables that a figure names, or those that it shows by default."""
    named = settings.get("variable", default)
    return [named] if isinstance(named, str) else list(named)


def one_variable(settings: Settings, default: str) -> str:
    """The variable of a figure that shows just one; UsageError when several are named."""
    named = variables(settings, default)
    if len(named) != 1:
        raise UsageError("this kind of figure shows one variable\nmake it a [[figure]] for each")
    return named[0]


def positions(axis: xr.DataArray) -> np.ndarray:
    """Where the values of `axis` lie in a figure: numbers at themselves, labels at 0, 1, 2, ..."""
    return axis.values.astype(float) if select.is_numeric(axis) else np.arange(float(axis.size))


def dress_axis(ax: Axes, axis: xr.DataArray, which: str) -> None:
    """Label and, for an axis of names, ticks: of many names as many as there is room for."""
    spine = ax.xaxis if which == "x" else ax.yaxis
    spine.set_label_text(", ".join([labels.axis_label(axis), *_advancing_with(axis)]))
    if not select.is_numeric(axis):
        words = [style.worded(str(value)) for value in axis.values]
        room = style.letters(ax.figure.figure)
        folded = [style.folded(word, max(1, room // len(words) - 2)) for word in words]
        fits = style.longest(folded) <= room // len(words) - 2
        if which == "x" and not fits and len(words) <= MOST_TICKS:
            ax.tick_params("x", rotation=90.0)
        is_thinned = which == "x" and len(words) > MOST_TICKS
        beside = max(1, room // (2 + style.longest(words))) if is_thinned else MOST_TICKS
        kept = np.arange(0, axis.size, -(-axis.size // beside))
        words = folded if which == "x" and fits else words
        spine.set_ticks(kept, labels=[words[place] for place in kept])


def _advancing_with(axis: xr.DataArray) -> list[str]:
    """What varies along an axis of numbers with it, none of which is fixed: ``$V_2$ with it``."""
    beside = [one for name, one in axis.coords.items() if name != axis.name and one.size > 1]
    varying = [one for one in beside if select.is_numeric(one) and (one != one[0]).any()]
    symbols = [labels.quantity(one, str(one.name)) for one in varying]
    return [f"{', '.join(symbols)} with it"] if symbols and select.is_numeric(axis) else []


def reach(ax: Axes, axis: xr.DataArray) -> None:
    """Let the abscissa reach over the whole grid, also where there is nothing to draw."""
    places = _of_scale(ax, positions(axis))
    ax.update_datalim([(places.min(), 0.0), (places.max(), 0.0)], updatey=False)
    ax.autoscale_view()


def _of_scale(ax: Axes, places: np.ndarray) -> np.ndarray:
    """Those of some places that the abscissa, where it is logarithmic, has."""
    return places[places > 0.0] if ax.get_xscale() == "log" else places


def scale(ax: Axes, settings: Settings) -> None:
    """Logarithmic axes and limits, as the figure asks; of what is drawn later, limits alone."""
    logarithmic = [which for which in "xy" if is_logarithmic(settings, which)]
    _leave_out(ax, ["xy".index(which) for which in logarithmic])
    ax.set(**{f"{which}scale": "log" for which in logarithmic})
    for which in logarithmic:
        style.label_log(ax.xaxis if which == "x" else ax.yaxis)
    for which, limits in (("x", settings.get("xlim")), ("y", settings.get("ylim"))):
        if limits is not None:
            ax.set(**{f"{which}lim": [in_si(bound) for bound in limits]})
    if "xlim" in settings and "ylim" not in settings:
        _scale_to_view(ax)
    if settings.keys() & {"xlim", "ylim"}:
        _unmark(ax)


def _unmark(ax: Axes) -> None:
    """Lines whose marked points all lie beyond the limits have no marks in the legend either."""
    for line in ax.lines:
        marked, xy = line.get_markevery(), np.asarray(line.get_xydata(), float)
        if isinstance(marked, list) and len(xy) and not _inside(ax, xy[marked]).any():
            line.set_marker("None")


def _inside(ax: Axes, points: np.ndarray) -> np.ndarray:
    """Which points lie within the limits of a panel, or on them."""
    (x, y), (left, right), (low, high) = points.T, sorted(ax.get_xlim()), sorted(ax.get_ylim())
    return np.asarray((left <= x) & (x <= right) & (low <= y) & (y <= high))


def show_on_the_frame(ax: Axes) -> None:
    """Whole marks on the limits of a panel, of lines that do not reach beyond."""
    for line in [one for one in ax.lines if one.get_transform() == ax.transData]:
        xy = np.asarray(line.get_xydata(), float).reshape(-1, 2)
        known = np.isfinite(xy).all(axis=1)
        line.set_clip_on(not known.any() or not _inside(ax, xy[known]).all())


def is_logarithmic(settings: Settings, which: str) -> bool:
    """Whether the figure asks for logarithms on "x" or "y", or of the shades, "z"."""
    log = settings.get("log", "")
    return which in ("xy" if log is True else str(log))


def shown_of(settings: Settings, heights: np.ndarray) -> tuple[float, float]:
    """The least and the greatest of some heights that a figure shows; of none (1, 1)."""
    drawn = np.isfinite(heights) & ((heights > 0.0) | (not is_logarithmic(settings, "y")))
    low, high = sorted(map(in_si, settings.get("ylim", (-np.inf, np.inf))))
    within = heights[drawn & (low <= heights) & (heights <= high)]
    known = within if within.size else heights[drawn]
    return (float(known.min()), float(known.max())) if known.size else (1.0, 1.0)


def _scale_to_view(ax: Axes) -> None:
    """Let the ordinate reach over what marks and lines have between the limits of x."""
    collections = [one for one in ax.collections if isinstance(one, LineCollection)]
    if len(collections) < len(ax.collections):  # a plane has its own
        return
    own = [line for line in ax.lines if line.get_transform() == ax.transData]
    drawn = [(line.get_xydata(), line.get_linestyle() != "None") for line in own]
    pieces = (piece for lines in collections for piece in lines.get_segments())
    drawn += [(piece, True) for piece in pieces if len(piece)]
    limits = sorted(ax.get_xlim())
    heights = np.concatenate([[], *(_heights(np.asarray(xy), on, limits) for xy, on in drawn)])
    known = heights[np.isfinite(heights)]
    if known.size:
        ax.dataLim.intervaly = known.min(), known.max()
        ax.autoscale_view(scalex=False)


def _heights(points: np.ndarray, joined: bool, limits: Sequence[float]) -> np.ndarray:
    """Heights of points between two limits and, where they are joined, of the line at these."""
    (x, y), (low, high) = points.T, limits
    heights = [y[(low <= x) & (x <= high)]]
    for limit in limits if joined else ():
        left = np.flatnonzero((x[:-1] - limit) * (x[1:] - limit) < 0.0)
        share = (limit - x[left]) / (x[left + 1] - x[left])
        heights.append(y[left] + share * (y[left + 1] - y[left]))
    return np.concatenate(heights)


def _leave_out(ax: Axes, logarithmic: Sequence[int]) -> None:
    """Take the points that have no logarithm out of lines, and out of the limits; say how many."""
    count = 0
    for line in [line for line in ax.lines if line.get_transform() == ax.transData]:
        xy = np.array(line.get_xydata(), float)
        out = np.isfinite(xy).all(axis=1) & (xy[:, logarithmic] <= 0.0).any(axis=1)
        line.set_data(*np.where(out[:, None], np.nan, xy).T)
        count += int(out.sum()) * (line.get_label() != DECORATION)
    if count:
        ax.relim()
        ax.plot([], [], ls="none", color=style.BLACK, label=f"{LEFT_OUT}: {count}")


def of_panel(settings: Settings, number: int, names: Iterable[str]) -> Settings:
    """The settings for one of several panels, which shows these variables."""
    kept, limits = settings.copy(), settings.get("ylim")
    if isinstance(limits, Mapping):
        limits = next((limits[name] for name in names if name in limits), None)
    elif number:
        limits = None
    kept.pop("ylim", None)
    return {**kept, "ylim": limits} if limits else kept


def relabel(figure: Figure, settings: Settings) -> None:
    """The labels that the figure asks for, in place of those that its first panels have."""
    own = style.own_axes(figure)
    panels = [ax for ax in own if ax.get_label() != "<colorbar>"]
    for key in ("xlabel", "ylabel"):
        words = [getattr(ax, f"get_{key}")() for ax in panels]  # inner panels have none
        first = next(filter(None, words), "")
        for ax, word in zip(panels, words, strict=True):
            if key in settings and word and word == first:
                ax.set(**{key: settings[key]})
    bars = [ax for ax in own if ax.get_label() == "<colorbar>"]
    for key in ("zlabel", "zlim") if not bars else ():
        if key in settings:
            raise UsageError(f"{key}: this map has no colour bar\nnext: leave {key} out")
    for ax in bars if "zlabel" in settings else ():
        ax.set_ylabel(settings["zlabel"])


def in_si(value: float | str) -> float:
    """A number, or a number with a unit, in SI (which is what datasets hold)."""
    number, _, unit = str(value).strip().partition(" ")
    return float(number) * float(parse_unit(unit).factor) if unit else float(number)


def lines(dataset: xr.Dataset, along: Sequence[str], dims: Sequence[str]) -> list[Line]:
    """Every combination of the `dims` that are not spread out `along` an axis.

    Labels name only what differs: ``far``, ``$N_0$ = 30 N``.
    """
    rest = [dim for dim in dims if dim not in along]
    groups = [_axes_along(dataset, dim) for dim in rest]
    places = itertools.product(*(range(group[0].size) for group in groups))
    return [_line(groups, rest, place) for place in places]


def _line(
    groups: Sequence[Sequence[xr.DataArray]], dims: Sequence[str], place: Sequence[int]
) -> Line:
    words = [
        joined(*labels.values_along([axis for axis in group if axis.size > 1], index))
        for group, index in zip(groups, place, strict=True)
    ]
    return Line(dict(zip(dims, place, strict=True)), dict(zip(dims, words, strict=True)))


def title(dataset: xr.Dataset, *others: xr.Dataset) -> str:
    """The case's title and reference and, below, the one value of each axis that does not vary.

    The start is always named: what is reached from one start need not be from another. So is the
    one that is selected of several contacts, modes or others that the variable has, and so are
    parameters that were set on the command line, which the case's title knows nothing of, and what
    a dataset differs in from those drawn beside it. What another of these has another value of is
    no value of the figure.
    """
    single = [dim for dim in grid_dims(dataset) if dataset.sizes[dim] == 1]
    alone = [
        [axis for axis in _axes_along(dataset, dim) if all(_has_no_other(o, axis) for o in others)]
        for dim in single
    ]
    changed = [labels.value_label(one, one.item()) for one in set_by_hand(dataset)]
    words = [
        *(word for axes in alone for word in _alone(axes)),
        str(dataset.attrs.get("of_several", "")),
        *changed,
    ]
    differs = str(dataset.attrs.get("differs", "")).split(", ")
    told = [labels.value_label(one, one.item()) for axes in alone for one in axes]
    words += [word for word in differs if word not in {*words, *told}]
    words += ["settled"] * all(map(is_settled, (dataset, *others)))
    words.append(str(dataset.attrs.get("without", "")))
    if "partial" in dataset.attrs and not others:
        words.append(f"partial: {dataset.attrs['partial']}")
    return "\n".join(part for part in (labels.title_of(dataset.attrs), joined(*words)) if part)


def _has_no_other(dataset: xr.Dataset, axis: xr.DataArray) -> bool:
    """Whether a dataset has no other values of an axis than the one of `axis`."""
    of_a_start = str(axis.name).startswith("initial_")  # which another motion has none of
    if axis.name not in dataset.coords:
        return not of_a_start
    own = dataset[axis.name].values
    return bool(np.all(own == axis.values[0]))


def set_by_hand(dataset: xr.Dataset, told: str = "overrides") -> list[xr.DataArray]:
    """Fixed parameters that the run was given with --set, as an attribute has them."""
    given = map(parse_override, str(dataset.attrs.get(told, "")).splitlines())
    names = dict.fromkeys(one.keys[-1] for one in given)
    return [dataset.coords[n] for n in names if n in dataset.coords and not dataset[n].ndim]


def is_settled(dataset: xr.Dataset) -> bool:
    """Whether a motion begins where its steady state was reached, rather than at its start."""
    return str(dataset.attrs.get("point", "")).endswith(", settled")


def _alone(axes: Sequence[xr.DataArray]) -> list[str]:
    words = labels.values_along(axes, 0) if axes else []
    return [f"start: {words[0]}"] if [one.name for one in axes] == ["initial"] else words


def joined(*words: str) -> str:
    """The words that are there, separated by commas."""
    return ", ".join(word for word in words if word)


def of_all(names: Sequence[str]) -> str:
    """One name for lines that have these: ``rest and belt``; "" where it would mislead.

    That is where some others would have it too, where it takes a line by itself, and for the
    members of a random start, which are not called one by one.
    """
    parts = [name.split(", ") for name in names]
    if len({len(one) for one in parts}) > 1 or any(stem(name) != name for name in names):
        return names[0] if len(names) == 1 else ""
    own = [list(dict.fromkeys(column)) for column in zip(*parts, strict=True)]
    are_all = len({*names}) == len(names) == np.prod([len(column) for column in own])
    name = joined(*map(BOTH.join, own))
    is_short = len(names) == 1 or style.longest([name]) <= MOST_LETTERS
    return name if are_all and is_short else ""


def is_of(whose: str, entry: str) -> bool:
    """Whether what is called `whose` has the words of an entry of a legend, be it one `of_all`."""
    own = whose.split(", ")
    words = filter(None, entry.split(", "))
    return all(told in own or not {*own}.isdisjoint(told.split(BOTH)) for told in words)


def unlisted(*words: str) -> str:
    """What a line is called where it has no entry of its own in the legend."""
    return f"_{joined(*(word.removeprefix('_') for word in words))}"


@dataclass(frozen=True)
class Entry:
    """How a line looks.

    Attributes
    ----------
    colour, dash : matplotlib colour and style of line
    label : legend entry; with an underscore before it: not in the legend
    number : counts the colours
    scattered : its points have starts of their own, so a line between them means nothing
    """

    colour: ColorType
    dash: Any
    label: str
    number: int
    scattered: bool


def stem(name: str) -> str:
    """The name of a line without the number of a member of random starts."""
    return RANDOM_MEMBER.sub("", name)


def entries(names: Sequence[str]) -> list[Entry]:
    """An entry for each line; the members of a random start share one (``far-000`` is ``far``).

    What all starts share has the last colour, so that each start has its own whether there is any
    or not; and the first of dashes, for it is most of what is seen.
    """
    stems = [*map(stem, names)]
    distinct = sorted(dict.fromkeys(stems), key=lambda name: name.endswith(SHARED))
    colours = colours_of(distinct)
    numbers = [distinct.index(own) for own in stems]
    shared = sum(name.endswith(SHARED) for name in distinct)
    return [
        Entry(
            colours[own],
            style.dash((number + shared) % len(distinct), len(distinct)),
            unlisted(own) if own in stems[:place] else own,
            number,
            own != names[place],
        )
        for place, (own, number) in enumerate(zip(stems, numbers, strict=True))
    ]


def colours_of(names: Sequence[str]) -> dict[str, ColorType]:
    """A colour for each of some distinct names; of many values of one parameter a ramp."""
    of_values = _of_one_parameter(names)
    ramp = [name for own in of_values if len(own) > len(style.LINES) for name in own]
    others = [name for name in names if name not in ramp]
    others, ramp = (others, ramp) if len(others) <= len(style.LINES) else ([], [*names])
    return {
        name: colour
        for some in (others, ramp)
        for name, colour in zip(some, style.line_colours(len(some)), strict=True)
    }


def of_many_lines(
    names: Sequence[str], dims: Sequence[str] = ("initial",), pieces: int = 0
) -> list[str]:
    """What to do where lines that differ in more than one parameter are too many for colours or, in
    many `pieces`, for dashes.

    Parameters
    ----------
    dims : of which they have several values
    """
    distinct = [*dict.fromkeys(map(stem, names))]
    most = MANY_IN_PIECES if pieces else len(style.LINES)
    if len(distinct) <= most or len(_of_one_parameter(distinct)) == 1:
        return []
    some = f"select = {{ {dims[0]} = ... }}" if dims else "fewer under variable"
    told = f" in {pieces} pieces" * bool(pieces)
    return [f"{len(distinct)} lines{told} are hard to tell apart; {some}, say, takes some of them"]


def _of_one_parameter(names: Sequence[str]) -> list[list[str]]:
    """Names that differ in the value of one parameter, the last of their words, together."""
    groups: dict[str, list[str]] = {}
    for name in names:
        groups.setdefault(VALUE.sub("=", name), []).append(name)
    return [*groups.values()]


def gaps(dataset: xr.Dataset) -> dict[str, xr.DataArray]:
    """Kind of gap -> the points that have it: failed, not reached, ... and undecided."""
    status = dataset["status"]
    kinds = {
        name.replace("_", " "): status == code
        for code, name in flag_names(status.attrs).items()
        if name != "ok"
    }
    if "computed" in dataset:  # what is filled in has an answer, the only one that was asked for
        kinds["not computed"] &= ~is_class(dataset["computed"], ("filled_in",))
    if "attractor" in dataset:
        undecided = is_class(dataset["attractor"], ("undecided",))
        kinds["undecided"] = undecided & is_class(status, ("ok", "budget"))
    selected = ~dataset.get(NOT_SELECTED, status < 0)
    return {name: mask & selected for name, mask in kinds.items() if bool((mask & selected).any())}


def ended(dataset: xr.Dataset) -> dict[str, xr.DataArray]:
    """Class of motions that came to no steady state -> the points that have it."""
    if "attractor" not in dataset:
        return {}
    selected = ~dataset.get(NOT_SELECTED, dataset["status"] < 0)
    kinds = {
        word: is_class(dataset["attractor"], (name,)) & selected for word, name in ENDED.items()
    }
    return {word: mask for word, mask in kinds.items() if bool(mask.any())}


def alone(known: np.ndarray, most: int = 1) -> np.ndarray:
    """Which points of a line are known, and neither of their neighbours: no line leads there.

    Or, of `most` that are neighbours, a line too short for its dashes.
    """
    piece = np.cumsum(~known)
    sizes = np.bincount(piece[known], minlength=piece.max(initial=0) + 1)
    return np.asarray(known & (sizes[piece] <= most))


def met_by(
    x: np.ndarray, y: np.ndarray, others: Iterable[tuple[np.ndarray, np.ndarray]]
) -> np.ndarray:
    """How many of some `others` (their x, their y) have a point at each of these points; none of
    one with too many to compare."""
    count = np.zeros(x.size, int)
    for its_x, its_y in others:
        if x.size * its_x.size <= MOST_COMPARED:
            met = (x[:, None] == its_x) & np.isclose(y[:, None], its_y, rtol=UPON, atol=0.0)
            count += met.any(axis=1)
    return count


def refuse_empty(dataset: xr.Dataset, anything: bool, name: str) -> None:
    """UsageError where there is not anything to draw: says why.

    A figure without a single value is not written.
    """
    if not anything:
        size, why = dataset["status"].size, gaps(dataset)
        counts = ", ".join(f"{kind} {int(mask.sum())}" for kind, mask in why.items())
        raise EmptyFigureError(
            f"{name}: nothing to draw, none of the {size} points has a value"
            f"{f' ({counts})' if counts else ''}\nnext: `fiv show FILE.nc` says why, with reasons"
        )


def dress(
    axes: Sequence[Axes],
    layers: Sequence[Layer],
    own: Sequence[Settings],
    told: Collection[str] = (),
) -> None:
    """What panels above each other share: axis, gaps but for those told, a legend.

    Each of them has settings of its `own`.
    """
    axis = abscissa(layers[0].dataset, own[0])
    dress_axis(axes[-1], axis, "x")
    for ax, settings in zip(axes, own, strict=True):
        scale(ax, settings)
        if ax.get_autoscaley_on():
            style.level(ax)
        reach(ax, axis)
    mark_gaps(axes, layers, own[-1], told)
    legend(axes)


BOTH = " and "
SHARED = "both starts", "all starts"
MOST_LETTERS = 50  # of a name of several lines

ENDED = {name.replace("_", " "): name for name in ENDED_EARLY}
NOT_SELECTED = "not_selected"  # points of none of the classes that a figure selects
GAP_MARKS = {
    "undecided": ("x", "#777777"),
    "failed": ("X", style.BLACK),
    "budget": ("v", "#777777"),
    "contact lost": ("^", style.BLACK),
    "diverged": ("P", style.BLACK),
    "not reached": ("|", "#777777"),
    "not computed": ("2", style.GREY),
    "pending": ("1", style.GREY),
}


MOST_GAP_ROWS = 6
APART = 2.5  # pt: marks in a row are no bar
GAP_MARK = 5.0  # pt
TOUCHING = 1e-6  # share of a strip by which a tick at its edge may lie in it
STRIP = "0.92"  # colour of where marks stand that have no height


def colours(axes: Sequence[Axes]) -> dict[str, ColorType]:
    """Legend entry -> colour, of the lines drawn so far."""
    pairs = zip(*legends.told_in(axes), strict=True)
    return {name: line.get_color() for line, name in pairs if isinstance(line, Line2D)}


def mark_gaps(
    axes: Sequence[Axes],
    layers: Sequence[Layer],
    settings: Settings,
    told: Collection[str] = (),
) -> None:
    """Marks on a strip along the lower edge of the last panel where points have no answer.

    None of the kinds that are `told` otherwise. Of a few among several lines each has a row, in its
    own colour.
    """
    ax = axes[-1]
    found = _gap_rows(layers, settings, told)
    low, high = sorted(ax.get_xlim())
    shown = {row: x[(low <= x) & (x <= high)] for row, x in found.items()}
    looks = _by_look({row: here for row, here in shown.items() if here.size}, colours(axes))
    step = (GAP_MARK + 1.0) * ax.figure.dpi / style.POINTS / ax.bbox.height
    every = [positions(abscissa(layer.dataset, settings)) for layer in layers]
    for level, ((name, colour), (whose, x, is_mixed)) in enumerate(looks.items()):
        entry = f"{name}: {whose}" if whose else name
        note = f"{entry}: ticks of several lines in one row, which `select` of one tells apart"
        style.add_notes(ax.figure.figure, [note] * is_mixed)
        ax.plot(
            x, np.full(x.shape, step * (level + 0.5)), GAP_MARKS[name][0], color=colour,
            ms=GAP_MARK, ls="none", label=entry, clip_on=False,
            transform=ax.get_xaxis_transform(), zorder=5,
            markevery=_apart(ax, x, np.setdiff1d(np.concatenate(every), x)),
        )  # fmt: skip
    if not looks:
        return
    place: Any = (0.0, 0.0), 1.0, step * len(looks)
    strip = Rectangle(*place, transform=ax.transAxes, fc=STRIP, ec="none", label=DECORATION)
    ax.add_patch(strip)
    if "ylim" not in settings:
        _make_room_below(ax, step * (len(looks) + 1))  # marks of values reach below these
        strip.set_zorder(1.6)  # over the grid
    elif _is_used_below(ax, step * len(looks)):
        _make_room_below(ax, step * len(looks), ax.get_ylim()[0])
        strip.set_zorder(4.9)  # over what lies below the limit
        ax.spines[:].set_zorder(4.95)
    _leave_out_ticks(ax, step * len(looks))


def _by_look(
    rows: Mapping[tuple[str, str], np.ndarray], own: Mapping[str, ColorType]
) -> dict[tuple[str, ColorType], tuple[str, np.ndarray, bool]]:
    """Kind of gap and colour -> whose it is, where, and whether of some not everywhere: what looks
    alike is one row."""
    looks: dict[tuple[str, ColorType], list[tuple[str, str, np.ndarray]]] = {}
    for (name, whose), x in rows.items():
        of = next((entry for entry in own if is_of(whose, entry)), "")
        looks.setdefault((name, own.get(of, GAP_MARKS[name][1])), []).append((whose, of, x))
    return {look: _in_one_row(alike) for look, alike in looks.items()}


def _in_one_row(alike: Sequence[tuple[str, str, np.ndarray]]) -> tuple[str, np.ndarray, bool]:
    """Whose gaps that look alike are, and where, and whether not all have all: of those of one
    legend entry, or of nobody's."""
    names, entry = [whose for whose, *_ in alike], alike[-1][1]
    whose = (of_all(names) or entry) if entry or len(alike) == 1 else ""
    every = reduce(np.union1d, [x for *_, x in alike])
    return whose, every, any(x.size < every.size for *_, x in alike)


def _gap_rows(
    layers: Sequence[Layer], settings: Settings, told: Collection[str]
) -> dict[tuple[str, str], np.ndarray]:
    """Kind of gap, whose it is -> where; of too many lines they are nobody's."""
    found = [
        (name, whose, positions(axis)[where])
        for layer in layers
        for axis in [abscissa(layer.dataset, settings)]
        for name, mask in (gaps(layer.dataset) | ended(layer.dataset)).items()
        for whose, where in _rows(mask, str(axis.dims[0]), layer.label)
        if name not in told
    ]
    many = len({(name, whose) for name, whose, _ in found}) > MOST_GAP_ROWS
    rows: dict[tuple[str, str], np.ndarray] = {}
    for name, whose, x in found:
        row = name, "" if many else whose
        rows[row] = np.union1d(rows.get(row, []), x)
    return rows


def _apart(ax: Axes, x: np.ndarray, others: np.ndarray) -> list[int]:
    """Which of some rising places are marked: the ends of each row, and all far from one before.

    What lies beside one of the `others` is so only where no mark of its row is near: else the marks
    of two rows hide that there are some between.
    """
    both = np.concatenate([x, others])
    across = ax.transData.transform(np.column_stack([both, np.full(both.size, ax.get_ylim()[0])]))
    places, beside = np.split(across[:, 0], [x.size])
    far, kept = APART * ax.figure.dpi / style.POINTS, [0]
    is_last = np.append(np.abs(np.diff(places)) >= far, True)  # of its row
    for number, place in enumerate(places[1:], 1):
        if is_last[number] or abs(place - places[kept[-1]]) >= far:
            kept.append(number)
    row = np.searchsorted(np.sort(others), x)[kept]
    off = np.abs(places[kept, None] - beside).min(axis=1, initial=np.inf)
    wide = GAP_MARK * ax.figure.dpi / style.POINTS
    clear = off >= 0.5 * wide
    away = np.abs(places[kept, None] - places[kept][clear]).min(axis=1, initial=np.inf) > wide
    return np.array(kept)[clear | away | ~np.isin(row, row[clear])].tolist()


def _make_room_below(ax: Axes, share: float, lowest: float | None = None) -> None:
    """Let what is drawn, or what is as high as the `lowest`, begin above a `share` of a panel."""
    is_log = ax.get_yscale() == "log"
    drawn = ax.dataLim.minposy if is_log else ax.dataLim.y0
    ends = (*ax.get_ylim(), drawn if lowest is None else lowest)
    low, high, bottom = np.log(ends) if is_log else ends
    if bottom < high and bottom - low < share * (high - low):
        least = (bottom - share * high) / (1.0 - share)
        ax.set_ylim(np.exp(least) if is_log else least)


def _is_used_below(ax: Axes, share: float) -> bool:
    """Whether a line leads, between the limits, through the lowest `share` of a panel."""
    drawn = [line for line in ax.lines if line.get_transform() == ax.transData]
    lines = [np.reshape(np.asarray(line.get_xydata(), float), (-1, 2)) for line in drawn]
    pixels = ax.transData.transform(np.concatenate([np.zeros((0, 2)), *lines]))
    across, height = ax.transAxes.inverted().transform(pixels).T
    return bool(np.any((across >= 0.0) & (across <= 1.0) & (height >= 0.0) & (height <= share)))


def _leave_out_ticks(ax: Axes, share: float) -> None:
    """No ticks at the lowest `share` of the heights of a panel: what is there has none."""
    place = ax.transAxes.transform((0.0, (1.0 - TOUCHING) * share))
    least = float(ax.transData.inverted().transform(place)[1])
    for of, replaced in (
        (ax.yaxis.get_major_locator(), ax.yaxis.set_major_locator),
        (ax.yaxis.get_minor_locator(), ax.yaxis.set_minor_locator),
    ):
        if not isinstance(of, FixedLocator):  # ticks of names stand at lines
            replaced(style.TicksAbove(of, least))


def _rows(mask: xr.DataArray, dim: str, label: str) -> list[tuple[str, np.ndarray]]:
    """Where points are, line by line with its label where a few of several have any; else of all.

    Parameters
    ----------
    mask : the points
    dim : along which a line runs
    """
    found: dict[str, np.ndarray] = {}
    for line in lines(mask.to_dataset(name="status"), [dim], [str(d) for d in mask.dims]):
        name = stem(joined(label, line.label))
        here = mask.isel(line.index).values
        found[name] = found.get(name, False) | here
    some = {name: here for name, here in found.items() if here.any()}
    if len(some) > MOST_ENTRIES_INSIDE or len({here.tobytes() for here in found.values()}) == 1:
        return [(label, np.logical_or.reduce([*some.values()]))]
    return [*some.items()]


def legend(axes: Sequence[Axes]) -> None:
    """A legend where it hides nothing, or beside the panels when it is long; below narrow ones.

    Of several panels it is below. None for a single line.
    """
    figure = axes[0].figure.figure
    legends.colour_keys(axes)
    _unlist_unseen(axes)
    handles, told = _thinned(*legends.told_in(axes))
    names = [*map(style.worded, told)]
    beside, many = style.letters(figure), len(names) > MOST_ENTRIES_INSIDE
    narrow = beside < LEAST_LETTERS and len(names) > 2
    if narrow or (many and style.longest(names) > beside // 6) or (names and len(axes) > 1):
        legends.legend_below(figure, handles)
    elif many:
        columns = 1 + (len(names) - 1) // MOST_ENTRIES_IN_COLUMN
        legends.even_keys(figure.legend(handles, names, loc="outside right center", ncols=columns))
    elif names:
        legends.even_keys(axes[0].legend(handles, names))


def _unlist_unseen(axes: Sequence[Axes]) -> None:
    """Leave out of the legend what is drawn beyond the limits of its panels alone."""
    drawn = [(_words_of(label), seen) for ax in axes for label, seen in legends.seen_in(ax)]
    told = [zip(*ax.get_legend_handles_labels(), strict=True) for ax in axes]
    for handle, name in itertools.chain(*told):
        own = [seen for words, seen in drawn if _words_of(name) <= words]
        if own and not any(own):
            handle.set_label(unlisted(name))


def _words_of(label: str) -> set[str]:
    """The words of an entry of a legend, which are among those of what it stands for."""
    return {*label.removeprefix("_").split(", ")}


def _thinned(handles: Sequence[Artist], names: Sequence[str]) -> tuple[list[Artist], list[str]]:
    """Of too many entries some, evenly spread: the colours of many lines are a ramp.

    So of the values of one parameter, of which there are keys of both ends and some between.
    """
    told = {
        own[at]
        for own in _of_one_parameter(names)
        for at in _spread(len(own), MOST_OF_A_RAMP if len(own) > len(style.LINES) else len(own))
    }
    pairs = [pair for pair in zip(handles, names, strict=True) if pair[1] in told]
    pairs = [pairs[at] for at in _spread(len(pairs), MOST_ENTRIES)]
    return [handle for handle, _ in pairs], [name for _, name in pairs]


def _spread(count: int, most: int) -> list[int]:
    """Places among so many, at most so many of them: both ends, and evenly between."""
    return np.unique(np.linspace(0, count - 1, min(count, most)).astype(int)).tolist()
