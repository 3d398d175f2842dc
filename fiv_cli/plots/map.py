"""A variable over two parameters: classes in their colours, numbers against a colour bar."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import cycle, islice
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib import colormaps
from matplotlib.colors import BoundaryNorm, Colormap, ListedColormap, LogNorm, Normalize
from matplotlib.patches import Patch

from fiv_cli.errors import EmptyFigureError, UsageError
from fiv_cli.flags import NOT_COMPUTED, ON_THE_WAY
from fiv_cli.notation.names import pick
from fiv_cli.plots import labels, legends, level_notes, levels, points, style
from fiv_cli.plots.critical_lines import CriticalLines
from fiv_cli.plots.level_notes import Panel
from fiv_cli.reading import select
from fiv_cli.reading.datasets import (
    ends_of,
    filled_in,
    flag_names,
    headlines,
    is_class,
    is_count,
    numbers,
)
from fiv_cli.reading.take import MOVING, SIZE

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.artist import Artist
    from matplotlib.axes import Axes
    from matplotlib.axis import Axis
    from matplotlib.collections import QuadMesh
    from matplotlib.figure import Figure
    from matplotlib.lines import Line2D
    from matplotlib.typing import ColorType

MOST_PANELS = 6
MOST_COLUMNS = 3
SIDE = 6  # letters beside a panel that its ticks take
MOST_FOLDED = 1.5  # lines that a label of one of several panels may take, else its symbol alone
HATCH = "////"
UNDECIDED = "undecided"
RIM = 0.5  # pt: of points that lines would cover
# Values of an axis that all have a tick where their steps differ by more: cells lie half-way.
FEW, UNEVEN = 8, 1.5
LINES_APART = 0.05  # of a panel: numbers that stand one above another
FINE = 40  # points along an axis, of which more have cells as narrow as a line
MOST_COUNTS = 12  # that have a shade each
NOT_RUN = "where it may be, points were filled in, which have a class and no number"
MOST_STARTS = 3  # of which each has lines of its own over a map that is taken over them
MIDDLE = "undecided points: middle of least and greatest"
# Whether there is less, and more, than a colour bar holds -> how that is shown.
EXTENDED = {(False, False): "neither", (True, False): "min", (False, True): "max",
            (True, True): "both"}  # fmt: skip
WITHOUT_BORDER = "it lies in the jump between rest and motion, which border = false leaves out"
SHADES = 512  # of a colour bar
SIGNED = ("growth_rate", "lyapunov")  # whose maps have the colours of both signs, whatever they are
FAINTEST = 0.25  # share of a shade, of which less is not told from none
BELOW = "#DDDDDD"  # of numbers that have no logarithm
MISSING, HATCHING = "#D8D8D8", "#8A8A8A"


def suits(dataset: xr.Dataset) -> bool:
    """Whether there are two axes, be it of laws or starts."""
    return len(points.varying_axes(dataset)) >= 2


def fills_plane(dataset: xr.Dataset) -> bool:
    """Whether something has one value at each point of a plane of two numeric axes."""
    numeric = sum(map(select.is_numeric, points.varying_axes(dataset)))
    return numeric >= 2 and bool(_headlines(dataset))


def draw(layers: Sequence[points.Layer], settings: points.Settings) -> Figure:
    """A panel for each start and each value of the other axes, or the lines of all in one."""
    dataset = layers[0].dataset
    planes = _planes(dataset, settings)
    lines = _lines(layers[0], planes, settings)
    if settings.get("overlay"):
        return _overlaid(planes, lines, settings)
    refuse_many(planes.panels, planes.array, planes.dims)
    points.refuse_empty(dataset, bool(planes.computed.any()), str(planes.array.name))
    missed = [word for one in lines for word in one.missed]
    words = "\n".join(filter(None, (points.title(dataset), how_run(dataset), *missed)))
    figure, axes, columns = style.grid_of_panels(
        len(planes.panels), MOST_COLUMNS, words, sharex=True, sharey=True
    )
    _paint(figure, axes, planes, lines, settings)
    for number, ax in enumerate(axes[: len(planes.panels)]):
        _dress(ax, number, columns, planes)
        points.scale(ax, settings)
    unwritten = _draw_lines(figure, axes, planes, lines)
    for ax in axes[: len(planes.panels)]:
        points.scale(ax, settings)
    inexact = [word for one in lines for word in one.inexact]
    of_the_map = any(isinstance(one, _Lines) and one.of_the_map for one in lines)
    if not flag_names(planes.array.attrs):
        own = numbers(planes.array)
        if rests := int((own.isnull() & _with_rests(planes, own).notnull()).sum()):
            at_rest = f"{planes.array.name} is 0 at rests that were filled in ({rests})"
            style.tell(figure, f"{at_rest}, as at all that were run")
    if not flag_names(planes.array.attrs) and not of_the_map:
        inexact += _of_filled(planes, "no value")
    otherwise = *_held_otherwise(layers[0], planes, settings), *_told_twice(planes, settings)
    told = *missed, *otherwise, *unwritten, *inexact
    style.add_notes(figure, told)
    _tell_accuracy(figure, lines)
    return figure


def _paint(
    figure: Figure,
    axes: Sequence[Axes],
    planes: _Planes,
    lines: Sequence[_Lines | CriticalLines],
    settings: points.Settings,
) -> None:
    """Paint every panel; what lines will lie on them is in its legend, too."""
    of_classes = bool(flag_names(planes.array.attrs))
    keys = [key for line in lines for key in line.keys(_colour(line, of_classes))]
    if of_classes:
        _paint_classes(figure, axes, planes, keys)
    else:
        shades = [points.in_si(end) for end in settings.get("zlim", ())]
        logarithmic = points.is_logarithmic(settings, "z")
        difference = settings.get("take", {}).get("what") == "difference"
        look = {"logarithmic": logarithmic, "difference": difference}
        _paint_numbers(figure, axes, planes, keys, shades, **look)


def _draw_lines(
    figure: Figure, axes: Sequence[Axes], planes: _Planes, lines: Sequence[_Lines | CriticalLines]
) -> list[str]:
    """Draw the lines on every panel; what to do about levels that are not written on theirs."""
    of_classes = bool(flag_names(planes.array.attrs))
    if lines:  # levels are written along lines as they look
        style.lay_out(figure)
    unwritten: dict[str, None] = {}
    for ax, panel in zip(axes, planes.panels, strict=False):
        for line in sorted(lines, key=_is_written_on):
            written = line.draw(ax, panel, _colour(line, of_classes))
            if isinstance(line, _Lines) and line.numbered:
                unwritten |= dict.fromkeys(line.unwritten(panel, written))
    return [*unwritten]


@dataclass(frozen=True)
class _Planes:
    """A variable over two axes: a plane for each start and each value of the other axes."""

    dataset: xr.Dataset
    array: xr.DataArray
    axes: tuple[xr.DataArray, xr.DataArray]
    panels: list[points.Line]

    @property
    def dims(self) -> tuple[str, str]:
        """The dims of both axes."""
        return str(self.axes[0].dims[0]), str(self.axes[1].dims[0])

    @property
    def places(self) -> tuple[np.ndarray, np.ndarray]:
        """Where the points lie along both axes."""
        return points.positions(self.axes[0]), points.positions(self.axes[1])

    @cached_property
    def computed(self) -> xr.DataArray:
        """Where there is an answer."""
        return is_class(self.dataset["status"], ("ok", "budget"))

    @cached_property
    def settled(self) -> xr.DataArray:
        """Where its numbers are an answer: not of a motion that was on its way yet.

        One that never met a section which the case names may be anything; where it names none,
        time was too short for the motion to choose one.
        """
        if "reason" not in self.dataset:
            return self.computed
        moving = (*ON_THE_WAY, "section_drifts", *["no_section_points"] * self._has_own_sections)
        return self.computed & ~is_class(self.dataset["reason"], moving)

    @cached_property
    def on_its_way(self) -> xr.DataArray:
        """Where there is an answer of a motion that was on its way yet."""
        return self.computed & ~self.settled

    @property
    def _has_own_sections(self) -> bool:
        return "section_kind" in self.dataset

    def of(self, array: xr.DataArray, panel: points.Line) -> np.ndarray:
        """Values of one panel, shape (points along y, points along x)."""
        own = {dim: index for dim, index in panel.index.items() if dim in array.dims}
        return array.isel(own).transpose(*reversed(self.dims)).values

    @cached_property
    def moving(self) -> xr.DataArray:
        """0 where an equilibrium is reached, as far as that is known; of a difference, by both."""
        found = self.dataset.get(MOVING)
        if found is None and "attractor" in self.dataset:
            found = 1 - is_class(self.dataset["attractor"], ("equilibrium",))
        if found is None or not {*found.dims} <= {*self.array.dims}:
            return self.computed * 0 + 1
        return found

    def ends(self, panel: points.Line, *, apart: bool = False) -> list[np.ndarray]:
        """The numbers of one panel (of an interval, at each end), NaN where there is no answer.

        They are stacks (`levels`) of one part or, `apart`, of what rests and of all else.
        """
        settled, moving = self.of(self.settled, panel), self.of(self.moving, panel)
        most = int(self.moving.max())
        parts = [settled & (moving == kind) for kind in range(most + 1)] if apart else [settled]
        stack = np.stack(parts)
        return [np.where(stack, self.of(end, panel), np.nan) for end in self._numbers]

    @cached_property
    def _numbers(self) -> list[xr.DataArray]:
        return [numbers(end) for end in levels.planes_of(self.dataset, self.array)]

    def mesh(self, ax: Axes, plane: np.ndarray, **looks: Any) -> QuadMesh:
        """Paint one panel."""
        many = plane.size > style.MANY_MARKS
        return ax.pcolormesh(*self.places, plane, shading="nearest", rasterized=many, **looks)


@dataclass(frozen=True)
class _Lines:
    """The lines at which one variable has its `levels`, each in a style of its own.

    Those `of_the_map` are of what is painted. Numbers are written on lines that are `numbered`. One
    level is the `border` of what rests, too, or none is.
    """

    planes: _Planes
    levels: Sequence[float]
    styles: Sequence[Any]
    of_the_map: bool
    numbered: bool
    border: bool

    @cached_property
    def ends(self) -> list[Panel]:
        """Of each panel and level the numbers, at each end of what they may be."""
        return [*map(self._of_panel, self.planes.panels)]

    @cached_property
    def drawn(self) -> list[Panel]:
        """Those of which lines are drawn: these are half-way where they lead along a jump."""
        kinds = [self.planes.of(self.planes.moving, panel) for panel in self.planes.panels]
        return [
            [
                [levels.half_way(plane, at_rest, kind, level) for plane in one]
                for one, level in zip(own, self.levels, strict=True)
            ]
            for own, at_rest, kind in zip(self.ends, self._at_rest, kinds, strict=True)
        ]

    @cached_property
    def _at_rest(self) -> list[np.ndarray]:
        """The numbers of what rests, of each panel: a stack of one part."""
        return [self.planes.ends(panel, apart=True)[0][:1] for panel in self.planes.panels]

    def _drawn(self, panel: points.Line) -> Panel:
        """Those of one."""
        return next(
            own for own, one in zip(self.drawn, self.planes.panels, strict=True) if one is panel
        )

    def _of_panel(self, panel: points.Line) -> Panel:
        """The levels next to what rests, to either side, are borders of regions, which may be
        jumps; no other line leads along one from rest. One at rest itself is no border, but where
        what moves passes it."""
        whole, apart = (self.planes.ends(panel, apart=one) for one in (False, True))
        at_rest = apart[0][0]
        if not np.isfinite(at_rest).any():
            return [whole] * len(self.levels)
        still = float(np.nanmedian(at_rest))
        off = np.subtract(self.levels, still)
        beside = {off[off > 0.0].min(initial=np.inf), off[off < 0.0].max(initial=-np.inf)}
        moving = [
            end if level_notes.side(end[0], still) else np.where(np.isfinite(at_rest), np.nan, end)
            for end in whole
        ]
        border = whole if self.border else apart
        return [
            moving if one == 0.0 else border if one in beside else apart for one in off.tolist()
        ]

    @property
    def missed(self) -> list[str]:
        """Why there is no line, of each level that has none; undecided points have none."""
        moving = bool(self.planes.on_its_way.any())
        told = [*level_notes.missed(self.planes.array, self.ends, self.levels)]
        jump = level_notes.IN_A_JUMP if self.border else WITHOUT_BORDER
        not_run = f"{NOT_RUN}; or " * bool(_filled_without(self.planes))
        told = [why.replace(level_notes.IN_A_JUMP, f"{not_run}{jump}") for why in told]
        return [f"{why}{', as far as points are decided' * moving}" for why in told]

    @property
    def inexact(self) -> Iterator[str]:
        """Which lines the grid does not tell apart, and which have gaps."""
        array, ends = self.planes.array, self.ends
        yield from level_notes.crowded(array, ends, self.levels)
        yield from level_notes.scattered(array, ends, self.levels)
        for told in (level_notes.steep, level_notes.saddles):
            yield from told(array, self.planes.axes, ends, self.levels)
        yield from level_notes.along_jumps(array, ends, self._at_rest, self.levels)
        unsure = points.gaps(self.planes.dataset).get(UNDECIDED, array.isnull() & False)
        undecided = [self.planes.of(unsure, panel) for panel in self.planes.panels]
        yield from level_notes.broken(array, ends, self.levels, undecided)
        yield from _of_filled(self.planes, "lines end")

    def keys(self, colour: ColorType) -> list[Line2D]:
        """Entries of a legend."""
        return levels.keys(self.planes.array, self.levels, colour, self.ends, self.styles)

    def unwritten(self, panel: points.Line, written: Collection[float]) -> Iterator[str]:
        """What to do about levels that are not written on their lines in a panel."""
        return level_notes.unwritten(self.planes.array, [self._drawn(panel)], self.levels, written)

    def draw(self, ax: Axes, panel: points.Line, colour: ColorType) -> Collection[float]:
        """Draw those of one panel; the levels that are written on their lines."""
        array, places, ends = self.planes.array, self.planes.places, self._drawn(panel)
        look: dict[str, Any] = {"named": self.numbered, "rim": not self.of_the_map}
        look["styles"] = self.styles
        return levels.draw(ax, array, places, ends, self.levels, colour, **look)


def _lines(
    layer: points.Layer, planes: _Planes, settings: points.Settings
) -> list[_Lines | CriticalLines]:
    """What lines a figure asks for: of the variable that it maps, and of others over its axes."""
    wanted = levels.asked(str(planes.array.name), settings.get("level", []))
    of_numbers = [name for name, own in wanted.items() if not isinstance(own, str) and own]
    # lines of one colour have each a style of its own, the least dashed of critical ones
    styles = {is_own: cycle(levels.STYLES) for is_own in (True, False)}
    found: list[_Lines | CriticalLines] = [
        _critical(one, planes, name, own, next(styles[False]))
        for name, own in wanted.items()
        if isinstance(own, str)
        for one in _of_each_start(_holding(layer, name), planes, name)
    ]
    exact = [one for one in found if isinstance(one, CriticalLines)]
    found = [*_named_apart(exact, settings.get("words", {}))]
    for name, own in wanted.items():
        is_own = name == planes.array.name
        if not isinstance(own, str) and own:
            alone = name.rpartition(":")[2]
            plain = [one.rpartition(":")[2] for one in (str(planes.array.name), *wanted)]
            shown = alone if plain.count(alone) == 1 else name
            over = planes if is_own else _beside(layer, planes, name, shown)
            levels.refuse_class(over.array)
            border = bool(settings.get("border", True))
            # numbers alone do not tell of which variable
            between = is_count(str(over.array.name)) and any(one != round(one) for one in own)
            numbered = (is_own or of_numbers == [name]) and not between
            dashes = _dashes(own, styles[is_own])
            found.append(_Lines(over, own, dashes, is_own, numbered, border))
    return found


def _named_apart(lines: Sequence[CriticalLines], words: Collection[str]) -> Iterator[CriticalLines]:
    """Exact lines, those that are called alike by what their cases differ in, or by names that the
    figure has `words` for."""
    called = [str(one.dataset[one.name].attrs["long_name"]) for one in lines]
    files = [(one.name.rpartition(":")[0], one.dataset) for one in lines]
    names = labels.told_apart(files) if len(lines) > 1 else [""]
    for one, word, name in zip(lines, called, names, strict=False):
        told = one.name if one.name in words else points.joined(labels.with_symbols(word), name)
        yield one if called.count(word) == 1 else replace(one, called=told)


def _of_each_start(dataset: xr.Dataset, planes: _Planes, name: str) -> list[xr.Dataset]:
    """What lines of a variable are drawn of over a map that is taken over starts: of each of few
    its own, which is called by it."""
    count = dataset[name].sizes.get("initial", 1)
    if "initial" in planes.array.dims or not 1 < count <= MOST_STARTS:
        return [dataset]
    own = [dataset.isel(initial=[place]) for place in range(count)]
    for one in own:
        words = (str(one[name].attrs["long_name"]), str(one["initial"].item()))
        one[name].attrs["long_name"] = ", ".join(words)
    return own


def _held_otherwise(
    layer: points.Layer, planes: _Planes, settings: points.Settings
) -> Iterator[str]:
    """What lines of other cases hold fixed at another value than the map."""
    for name in levels.asked(str(planes.array.name), settings.get("level", [])):
        if ":" in name:
            yield from levels.held_otherwise(name, _holding(layer, name), planes.dataset)


def _told_twice(planes: _Planes, settings: points.Settings) -> Iterator[str]:
    """That a growth rate is zero where a critical value is: of two lines one hides the other."""
    wanted = levels.asked(str(planes.array.name), settings.get("level", []))
    plain = {name.rpartition(":")[2]: own for name, own in wanted.items()}
    growing = plain.get("growth_rate", [])
    if "critical_value" in plain and not isinstance(growing, str) and 0.0 in growing:
        yield (
            "growth_rate = 0 and critical_value are one line, the latter as its case found it and "
            "the former read from the grid: leave growth_rate out"
        )


def _dashes(wanted: Sequence[float], styles: Iterator[Any]) -> list[Any]:
    """A style for each level from low to high; the least dashed for zero, where signs change."""
    own = [*islice(styles, len(wanted))]
    at = wanted.index(0.0) if 0.0 in wanted else 0
    return [own[at], *own[1:at], own[0], *own[at + 1 :]] if at else own


def _is_written_on(line: _Lines | CriticalLines) -> bool:
    """What has numbers written on it comes last, and these beside the other lines."""
    return isinstance(line, _Lines) and line.numbered


def _colour(line: _Lines | CriticalLines, on_classes: bool) -> str:
    """Levels of what is painted have one of their own; none of the classes is black."""
    is_own = isinstance(line, _Lines) and line.of_the_map
    return style.VERMILLION if is_own and not on_classes else style.BLACK


def _critical(
    dataset: xr.Dataset, planes: _Planes, name: str, upright: str, dashes: Any
) -> CriticalLines:
    """The lines where an axis of a map has the value of a variable."""
    axes = {str(axis.name): axis for axis in planes.axes}
    pick(upright, axes, "axis of this map", "name its x or its y")
    return CriticalLines(planes.dataset, planes.axes, planes.panels, dataset, name, upright, dashes)


def _holding(layer: points.Layer, name: str) -> xr.Dataset:
    """The dataset of the case, or of what another lends it, that has a variable.

    Raises
    ------
    UsageError : there is none
    """
    holding = (one for one in (layer.dataset, *layer.beside) if name in one)
    dataset = next(holding, None)
    if dataset is None:
        raise UsageError(
            f"{name}: no variable of this dataset, whose level could be drawn\n"
            "next: `fiv show FILE.nc` says what it holds"
        )
    return dataset


def _beside(layer: points.Layer, planes: _Planes, name: str, shown: str) -> _Planes:
    """The planes of another variable, of any analysis of the case, under the panels of a map.

    Legends have it as `shown`.

    Raises
    ------
    UsageError : there is none, or not one value of it at each place of a panel
    """
    panels = {dim for panel in planes.panels for dim in panel.index}
    dataset = levels.under_panels(_holding(layer, name), planes.dataset, panels)
    panels = {dim for dim in panels if levels.same_along(dataset, planes.dataset, dim)}
    dims = dataset[name].dims
    lacking = {*planes.dims} - {*dims}
    if lacking:
        raise UsageError(f"{name}: its level is no line, it has no value for each {min(lacking)}")
    further = [str(dim) for dim in dims if dim not in {*planes.dims, *panels}]
    single = levels.at_the_map(name, dataset, planes.dataset, further)
    x, y = (select.axis_of(single, str(axis.name)) for axis in planes.axes)
    single = single.rename({name: shown} if shown != name else {})
    return _Planes(single, single[shown], (x, y), planes.panels)


def _planes(dataset: xr.Dataset, settings: points.Settings) -> _Planes:
    x, y = _axes(dataset, settings)
    array = dataset[_variable(dataset, settings)]
    spread = [str(x.dims[0]), str(y.dims[0])]
    if spread[0] == spread[1] and x.name != y.name:
        raise UsageError(
            f"{x.name} and {y.name} advance together here (zip): a line of points, and no map\n"
            "next: --figure curve, or a case without that zip"
        )
    if not set(spread) <= set(array.dims) or select.row_sizes(dataset, str(array.name)) is not None:
        raise UsageError(f"{array.name}: not one value per point over {x.name} and {y.name}")
    panels = points.lines(dataset, spread, [str(dim) for dim in array.dims])
    return _Planes(dataset, array, (x, y), panels)


def _overlaid(
    planes: _Planes, lines: Sequence[_Lines | CriticalLines], settings: points.Settings
) -> Figure:
    """The lines at the levels, of every start and each value of the other axes, in one panel, with
    those that other cases found."""
    own = [one for one in lines if isinstance(one, _Lines) and one.of_the_map]
    exact = [one for one in lines if isinstance(one, CriticalLines)]
    if len(own) + len(exact) < len(lines):
        raise UsageError(
            "overlay shows levels of the variable that is mapped, and what a boundary or critical "
            "analysis found\nnext: leave overlay out"
        )
    figure, (ax,) = style.new_panels(1, 1, points.title(planes.dataset))
    if not own:
        name = planes.array.name
        raise UsageError(
            f"maps are overlaid as lines, and no level of {name} says which\n"
            f"next: level = NUMBER, or {{ {name} = NUMBER }} beside others"
        )
    if not level_notes.have_lines(own[0].ends, own[0].levels):
        reach = "next: levels between the least and the greatest value, which fiv show has"
        raise EmptyFigureError("\n".join([*own[0].missed, reach]))
    named = [panel.label for panel in planes.panels]
    for axis, which in zip(planes.axes, "xy", strict=True):
        points.dress_axis(ax, axis, which)
    # an axis without points of its own would be as large as the lines alone
    ax.set(**{f"{w}lim": (at.min(), at.max()) for w, at in zip("xy", planes.places, strict=True)})
    points.scale(ax, settings)
    shown = [*zip(named, own[0].drawn, strict=True)]
    for line in exact:
        colours = [style.BLACK] if line.is_one else style.line_colours(len(named))
        for panel, colour in zip(planes.panels, colours, strict=False):
            line.draw(ax, panel, colour)
    others = [key for line in exact for key in line.keys(style.BLACK)]
    levels.overlay(ax, planes.array, shown, planes.places, own[0].levels, others)
    missed = [word for line in exact for word in line.missed]
    style.add_notes(figure, [*missed, *(word for line in lines for word in line.inexact)])
    _tell_accuracy(figure, exact)
    points.scale(ax, settings)
    return figure


def _tell_accuracy(figure: Figure, lines: Sequence[_Lines | CriticalLines]) -> None:
    """How far exact lines may be off is for the caption."""
    for line in lines:
        if isinstance(line, CriticalLines) and line.accuracy:
            style.add_to_caption(figure, line.accuracy)


def _filled_without(planes: _Planes) -> int:
    """How many points that were filled in have no number."""
    told = planes.dataset.get("computed", planes.dataset["status"])  # as taken of several
    filled = is_class(told, ("filled_in",))
    return int((filled & _with_rests(planes, numbers(planes.array)).isnull()).sum())


def _of_filled(planes: _Planes, what: str) -> Iterator[str]:
    """What there is not at points that were filled in."""
    if filled := _filled_without(planes):
        yield (
            f"{planes.array.name}: {what} at the {filled} points that were filled in, of which the "
            "class alone is known; fiv show of the dataset says how to run all"
        )


def how_run(dataset: xr.Dataset) -> str:
    """How many of the points of a refined map were run, and how far to trust the others."""
    if "refined_of" not in dataset.attrs or "computed" not in dataset:  # taken over its points
        return ""
    names = "run", "sampled", "sampled_and_mislabelled", "filled_in"
    counts = [int(is_class(dataset["computed"], (name,)).sum()) for name in names]
    run, right, wrong, _ = counts
    tested, total = right + wrong, sum(counts)
    if dataset.attrs.get("partial"):  # how many there will be is not known yet
        return f"{run + tested} points run so far"
    share = f"{(run + tested) / total:.1%} of {total} points run"
    return f"{share}, {wrong} of {tested} sampled mislabelled" if tested else share


def _variable(dataset: xr.Dataset, settings: points.Settings) -> str:
    default = next(iter(_headlines(dataset)), "variable")
    return points.known_variable(dataset, points.one_variable(settings, default))


def _headlines(dataset: xr.Dataset) -> list[str]:
    """What a map shows unless the figure says otherwise: classes first."""
    grid = set(points.grid_dims(dataset))
    names = [name for name in headlines(dataset) if set(dataset[name].dims) <= grid]
    return sorted(names, key=lambda name: not flag_names(dataset[name].attrs))


def _axes(dataset: xr.Dataset, settings: points.Settings) -> tuple[xr.DataArray, xr.DataArray]:
    """The two axes: as the figure says, else the first two that vary, numeric ones before others.

    Raises
    ------
    UsageError : fewer than two axes vary
    """
    asked = {"x": settings.get("x"), "y": settings.get("y")}
    named = {key: select.axis_of(dataset, name) for key, name in asked.items() if name}
    taken = [axis.dims for axis in named.values()]
    free = [axis for axis in points.varying_axes(dataset) if axis.dims not in taken]
    free.sort(key=lambda axis: not select.is_numeric(axis))
    if len(named) + len(free) < 2:
        raise UsageError(
            "a map needs two axes along which the dataset varies\n"
            "draw a curve, or run the case with a second axis in [grid]"
        )
    x = named["x"] if "x" in named else free.pop(0)
    return x, named["y"] if "y" in named else free.pop(0)


def refuse_many(panels: Sequence[points.Line], array: xr.DataArray, spread: Sequence[str]) -> None:
    """UsageError where the axes that are not `spread` out make more panels than one figure has."""
    if len(panels) > MOST_PANELS:
        rest = ", ".join(str(d) for d in array.dims if d not in spread and array.sizes[d] > 1)
        raise UsageError(
            f"{len(panels)} maps in one figure are too many\n"
            f"choose from {rest} with `select` in the figure, or take two of these as the axes of "
            'kind = "map"'
        )


def _dress(ax: Axes, number: int, columns: int, planes: _Planes) -> None:
    ax.grid(False)
    room = style.letters(ax.figure.figure) // columns - SIDE
    if number + columns >= len(planes.panels):  # nothing below it
        points.dress_axis(ax, planes.axes[0], "x")
        if columns > 1 and style.longest([ax.get_xlabel()]) > MOST_FOLDED * room:
            ax.set_xlabel(labels.short_label(planes.axes[0]))
        ax.tick_params(labelbottom=True)
        _tick_few(ax.xaxis, planes.axes[0], room, is_x=True)
    if number % columns == 0:
        points.dress_axis(ax, planes.axes[1], "y")
        _tick_few(ax.yaxis, planes.axes[1], room, is_x=False)
    ax.set_title(planes.panels[number].label)


def _tick_few(drawn: Axis, axis: xr.DataArray, room: int, *, is_x: bool) -> None:
    """A tick at each of a few values that are far from even: their cells do not show where.

    Of those so near that their numbers, of which `room` letters stand side by side, would lie on
    one another the first has one.
    """
    values = np.sort(points.positions(axis))
    steps = np.diff(values)
    if 2 < values.size <= FEW and steps.max() > UNEVEN * steps.min():
        letters = style.longest([labels.number_text(one, values.tolist()) for one in values])
        apart = np.ptp(values) * ((2 + letters) / room if is_x else LINES_APART)
        told = [values[0]]
        told += [one for one in values[1:] if one - told[-1] >= apart]
        drawn.set_ticks(told)
        drawn.set_ticks(values, minor=True)


def _paint_classes(
    figure: Figure, axes: Sequence[Axes], planes: _Planes, lines: Sequence[Artist]
) -> None:
    array, dataset = planes.array, planes.dataset
    names = flag_names(array.attrs)
    answered = planes.computed | filled_in(dataset, str(array.name))
    known = answered.broadcast_like(array) & numbers(array).notnull()
    present = {code: name for code, name in names.items() if bool((known & (array == code)).any())}
    colours = style.class_colours(list(present.values()))
    order = [colours[list(present).index(code)] for code in sorted(present)]
    codes = {name: code for code, name in present.items()}
    rims = set()
    for ax, panel in zip(axes, planes.panels, strict=False):
        place = np.searchsorted(sorted(present), planes.of(array, panel)).astype(float)
        place[~planes.of(known, panel)] = np.nan
        if order:  # else nothing has a class, and all is hatched
            norm = BoundaryNorm(_edges(len(order)), len(order))
            planes.mesh(ax, place, cmap=ListedColormap(order), norm=norm)
        hatch(ax, np.isnan(place))
        if lines and UNDECIDED in present.values() and max(place.shape) > FINE:
            _mark_covered(ax, planes, place == sorted(present).index(codes[UNDECIDED]))
            rims.add(UNDECIDED)
    handles = [
        Patch(label=name.replace("_", " "), fc=colour, **edge)
        for colour, name in zip(colours, present.values(), strict=True)
        for edge in [{"ec": style.BLACK, "lw": RIM} if name in rims else {"ec": colour}]
    ]
    legend_below(figure, [*handles, *lines], why_missing(dataset, known))


def _mark_covered(ax: Axes, planes: _Planes, undecided: np.ndarray) -> None:
    """Undecided points of a fine map, whose cells the lines on it may cover."""
    told = points.unlisted(UNDECIDED)
    _dot(ax, planes, undecided, marker="s", color=style.CLASSES[UNDECIDED], label=told)


def _dot(ax: Axes, planes: _Planes, mask: np.ndarray, **look: Any) -> list[Line2D]:
    """Marks on the points of a panel that are in a mask, over the lines on it."""
    (rows, columns), (x, y) = np.nonzero(mask), planes.places
    edge: dict[str, Any] = {"mec": style.BLACK, "mew": RIM, "ms": 2.5, "ls": "none", "zorder": 4}
    return ax.plot(x[columns], y[rows], **edge, **look)


def _edges(count: int) -> np.ndarray:
    return np.arange(count + 1) - 0.5


def hatch(ax: Axes, missing: np.ndarray) -> None:
    """Where there is no answer the panel's own background shows: grey and hatched."""
    if missing.any():
        ax.set_facecolor(MISSING)
        ax.patch.set(hatch=HATCH, edgecolor=HATCHING)


def why_missing(dataset: xr.Dataset, known: xr.DataArray) -> str:
    """What the hatched cells are: failed, not reached, ...; nothing where every cell is known."""
    if bool(known.all()):
        return ""
    reasons = points.gaps(dataset) | _decided(dataset)
    kinds = [kind for kind, mask in reasons.items() if bool((mask & ~known).any())]
    if "computed" in dataset:
        filled = int((is_class(dataset["computed"], ("filled_in",)) & ~known).sum())
        kinds += [f"{filled} filled in (the class alone)"] * (filled > 0)
    return ", ".join(kinds)


def _decided(dataset: xr.Dataset) -> dict[str, xr.DataArray]:
    """Class -> the points that have it: what has no period, say, may be a rest."""
    if "attractor" not in dataset:
        return {}
    answered, classes = is_class(dataset["status"], ("ok",)), flag_names(dataset["attractor"].attrs)
    return {
        name.replace("_", " "): answered & (dataset["attractor"] == code)
        for code, name in classes.items()
        if name not in (UNDECIDED, NOT_COMPUTED)
    }


def legend_below(figure: Figure, handles: Sequence[Artist], missing: str) -> None:
    """A legend under the panels, with the hatching where something is `missing`."""
    hatching = Patch(fc=MISSING, ec=HATCHING, hatch=HATCH, label=missing)
    shown = [*handles, hatching] if missing else handles
    legends.legend_below(figure, shown)


def _paint_numbers(
    figure: Figure,
    axes: Sequence[Axes],
    planes: _Planes,
    handles: Sequence[Artist],
    shades: Sequence[float],
    *,
    logarithmic: bool,
    difference: bool,
) -> None:
    values = _with_rests(planes, numbers(planes.array).where(planes.computed))
    unsure = _unsure(planes)[MIDDLE]
    if is_count(str(planes.array.name)):  # between one and two there is no number
        values = values.where(~unsure)
    if difference:  # of one motion twice there is rounding alone
        rounding = style.ROUNDING * planes.array.attrs[SIZE]
        values = values.where(~(np.abs(values) <= rounding), 0.0)
    low, high = shades or _shades(planes, values, logarithmic)
    if logarithmic and not shades:  # below the shades there is that of zero alone
        values = values.where(~planes.on_its_way | ~(values < low))
    known = values.values[np.isfinite(values.values)]
    whole = is_count(str(planes.array.name)) and bool((known == known.round()).all())
    counted = whole and high - low < MOST_COUNTS and not logarithmic
    norm = _norm(low, high, logarithmic=logarithmic, counted=counted)
    least = 0.0 if logarithmic and low > 0.0 else -np.inf  # a logarithm paints no zero
    is_signed = difference or str(planes.array.name).rpartition(":")[2] in SIGNED
    signed = not (logarithmic or counted) and (is_signed or low < 0.0 < high)
    colours = _of_both_signs(low, high) if signed else colormaps["cividis"]
    beside = (high - low) / SHADES * signed  # the shade of zero is of nothing else
    for ax, panel in zip(axes, planes.panels, strict=False):
        plane = planes.of(values, panel)
        apart = np.sign(plane) * np.maximum(np.abs(plane), beside)
        painted = np.where(plane > least, np.clip(apart, low, high), np.nan)
        image = planes.mesh(ax, painted, cmap=colours, norm=norm)
        if (plane <= least).any():
            below = np.where(plane <= least, 0.0, np.nan)
            planes.mesh(ax, below, cmap=ListedColormap([BELOW]))
        hatch(ax, np.isnan(plane))
    # which contact, where one of several is shown
    of_several = str(planes.dataset.attrs.get("of_several", ""))
    figure.colorbar(
        image, ax=list(axes), label=points.joined(labels.axis_label(planes.array), of_several),
        extend=EXTENDED[bool(((known > least) & (known < low)).any()), bool((known > high).any())],
        ticks=np.arange(low, high + 1.0) if counted else None,
    )  # fmt: skip
    if is_signed and not counted and low <= 0.0 <= high and (known == 0.0).any():
        white = colours(norm(0.0))  # which the bar has at one place alone
        own = "difference" if difference else labels.quantity(planes.array, str(planes.array.name))
        handles = [*handles, Patch(fc=white, ec=style.GREY, lw=RIM, label=f"{own} = 0")]
    if (known <= least).any():
        own = labels.quantity(planes.array, str(planes.array.name))
        sign = "=" if known.min() == 0.0 else r"$\leq$"
        handles = [*handles, Patch(color=BELOW, label=f"{own} {sign} 0")]
    unbounded = bool((unsure & values.isnull()).any())
    why = why_missing(planes.dataset, values.notnull())
    if UNDECIDED not in why:
        why = points.joined(why, "undecided points" if unbounded else "")
    missing = "" if bool(values.notnull().all()) else f"no value{': ' * bool(why)}{why}"
    told = [*handles, *_mark_undecided(axes, planes, values.notnull())]
    if missing or told:
        legend_below(figure, told, missing)


def _shades(planes: _Planes, values: xr.DataArray, logarithmic: bool) -> tuple[float, float]:
    """The least and the greatest that are shown; what is on its way stretches no shades."""
    known = values.values[np.isfinite(values.values)]
    settled = values.where(~planes.on_its_way).values
    settled = settled[np.isfinite(settled)]
    tells = settled.size and (np.ptp(settled) > 0.0 or np.ptp(known) == 0.0)
    return _ends(settled if tells else known, logarithmic)


def _with_rests(planes: _Planes, values: xr.DataArray) -> xr.DataArray:
    """The values, and 0 where a rest was filled in, of what is 0 at all rests that were run."""
    if "computed" not in planes.dataset or "attractor" not in planes.dataset:
        return values
    resting = is_class(planes.dataset["attractor"], ("equilibrium",))
    ran = resting & planes.computed
    if bool(ran.any()) and bool((values == 0.0).where(ran, True).all()):
        return values.where(~(resting & filled_in(planes.dataset, "attractor")), 0.0)
    return values


def _of_both_signs(low: float, high: float) -> Colormap:
    """Colours from one number to another that part at zero, whose shade is white, to both sides
    alike; the least beside it is told from that."""
    shares = np.linspace(low, high, SHADES) / (max(abs(low), abs(high)) or 1.0)
    seen = np.sign(shares) * (FAINTEST + (1.0 - FAINTEST) * np.abs(shares))
    if low <= 0.0 <= high:
        seen[min(int(Normalize(low, high)(0.0) * SHADES), SHADES - 1)] = 0.0
    return ListedColormap(colormaps["PRGn"](0.5 + 0.5 * seen))


def _norm(low: float, high: float, *, logarithmic: bool, counted: bool) -> Normalize:
    """Shades between two numbers; of counts one for each."""
    if counted:
        return BoundaryNorm(np.arange(low - 0.5, high + 1.0), colormaps["cividis"].N)
    return LogNorm(low, high) if logarithmic and low > 0.0 else Normalize(low, high)


def _ends(known: np.ndarray, logarithmic: bool) -> tuple[float, float]:
    """The least, or the least above zero, and the greatest of the numbers that are shown."""
    above = known[known > 0.0]
    shown = above if logarithmic and above.size else known
    return (float(shown.min()), float(shown.max())) if shown.size else (0.0, 1.0)


def _mark_undecided(axes: Sequence[Axes], planes: _Planes, known: xr.DataArray) -> list[Artist]:
    """Dots on numbers that are not sure, and the entries of a legend for them."""
    entries: list[Artist] = []
    for told, unsure in _unsure(planes).items():
        if unsure.dims == known.dims and bool((unsure & known).any()):
            for ax, panel in zip(axes, planes.panels, strict=False):
                seen = planes.of(unsure & known, panel)
                marked = _dot(ax, planes, seen, marker="o", color="white", label=told)
            entries += marked
    return entries


def _unsure(planes: _Planes) -> dict[str, xr.DataArray]:
    """Why -> numbers of motions that had not settled, and what is taken over such."""
    gaps = points.gaps(planes.dataset)
    low, high = ends_of(planes.dataset, str(planes.array.name))
    own = {UNDECIDED: gaps[UNDECIDED]} if UNDECIDED in gaps else {}
    return own | {MIDDLE: low < high}
