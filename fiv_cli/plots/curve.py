"""Variables against an axis, a line for each start and for each value of the other axes.

Variables of one unit share a panel.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import chain, combinations, product
from operator import itemgetter
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.path import Path

from fiv_cli.errors import UsageError
from fiv_cli.notation.names import listed
from fiv_cli.plots import branch, labels, points, style
from fiv_cli.plots.coinciding import each_once
from fiv_cli.plots.crossings import broken
from fiv_cli.plots.curve_lines import (
    DATASET,
    DOT,
    SORT_MARKS,
    TOO_SHORT,
    VARIABLE,
    Curve,
    equilibria,
    is_edge,
    lines_of,
    lines_of_branches,
    lines_without_axis,
    sorts_of,
    told_by_bars,
)
from fiv_cli.plots.curve_panel import UNSEEN, draw_panel, has_marks, is_of_classes
from fiv_cli.plots.diagram_lines import is_critical_along, mark_critical
from fiv_cli.plots.mergers import GROWTH
from fiv_cli.reading import select
from fiv_cli.reading.datasets import error_of, flag_names, headlines, numbers

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

AMPLITUDE = "_amplitude"  # how the names of such variables end
MOST_TOLD = 2  # lines of motions that are not joined, of which it is told
OF_A_PAIR = "eigenvalue_real", "mode_frequency"  # alike for both of a conjugate pair
OF_TABLE = re.compile(r"(?:^| )\d{3,}$")  # how the starts of a table are called
MARKED_WIDER = 1.3  # than marks that are seen through others are dots
TOLD = 1e-9  # share of what a panel shows: errors that are less are those of any number
OF_UNDECIDED = "x"  # their mark
LONG_LABEL = 36  # letters of an entry of a legend
TO_SEE_DASHES = 4  # times the room between marks without it
# With the caps of those that are drawn.
CAPPED = Path([(-3, 6), (3, 6), (0, 6), (0, -6), (-3, -6), (3, -6)], [1, 2, 1, 2, 1, 2])
ERROR_BAR: dict[str, Any] = {"marker": CAPPED, "ms": 8, "mew": 0.8, "ls": "none"}  # in the legend
CLASS_COLOURS = {name.replace("_", " "): colour for name, colour in style.CLASSES.items()}

_Parts = Mapping[int, points.Layer]
"""The layers that have a variable, by their number in the figure."""


def suits(dataset: xr.Dataset) -> bool:
    """Whether there is a scalar variable along some axis."""
    return bool(_headlines(dataset)) and bool(points.varying_axes(dataset))


def has_an_axis(dataset: xr.Dataset) -> bool:
    """Whether a branch of cycles has an axis of parameters; over starts alone it tells nothing."""
    along = [axis.name for axis in points.varying_axes(dataset)]
    return along != ["initial"] or not branch.suits(dataset)


@dataclass(frozen=True)
class _Shown:
    """What a curve shows: the `parts` of each variable, those of them `along` the axis, and the
    variables of each panel."""

    axis: xr.DataArray
    parts: Mapping[str, _Parts]
    along: Mapping[str, Sequence[points.Layer]]
    panels: Sequence[Mapping[str, xr.DataArray]]
    settings: points.Settings

    @property
    def first(self) -> str:
        """The first variable."""
        return next(iter(self.parts))

    @property
    def bare(self) -> list[int]:
        """The panels, by their numbers, in which no lines join points."""
        numeric = select.is_numeric(self.axis)
        return [n for n, own in enumerate(self.panels) if not numeric or is_of_classes(own)]

    @property
    def of_panels(self) -> list[points.Settings]:
        """The settings of each panel."""
        return [points.of_panel(self.settings, n, own) for n, own in enumerate(self.panels)]


def draw(layers: Sequence[points.Layer], settings: points.Settings) -> Figure:
    """Lines of every layer; undecided points are hollow, or bars over all that they may be.

    No line leads through these, nor from a point of one class to a neighbour of another.
    """
    layers, settings = points.with_named_places(_laid_over(layers), settings)
    layers, critical = _without_critical(layers, settings)
    shown = _shown(layers, settings)
    drawn = each_once([*_lines(shown)])
    points.refuse_empty(layers[0].dataset, any(one.is_known for _, one in drawn), shown.first)
    title = points.title(*(layer.dataset for layer in layers))
    figure, axes = style.new_panels(len(shown.panels), 1, title, sharex=True)
    dashed = _told_by_dashes(drawn, shown.bare)
    drawn = _marked_apart(drawn, dashed) if dashed else _seen_through(drawn)
    _draw_panels(axes, shown, drawn, dashed)
    for (ax, own), other in product(zip(axes, shown.panels, strict=True), critical):
        having = shown.parts[GROWTH].values() if GROWTH in own else layers
        if any(map(_is_zero_at_turns, own)):
            datasets = [one.dataset for one in _swept_along(shown.axis, having)]
            mark_critical(ax, other, datasets, shown.axis, of_largest=GROWTH in own)
    gaps = ("undecided", *points.ENDED) if [*shown.parts] == ["attractor"] else ()
    points.dress(axes, _with_gaps(shown.along), shown.of_panels, gaps)
    joined = [curve for place, curve in drawn if place not in shown.bare]
    broken_at = ["the class of motion changes"] * any(curve.leaves_class for curve in joined)
    broken_at += ["their numbers leap"] * any(curve.apart for curve in joined)
    if broken_at:
        style.add_to_caption(figure, f"lines break where {' or '.join(broken_at)}")
    style.add_notes(figure, [*dict.fromkeys(_told(shown, [curve for _, curve in drawn], dashed))])
    return figure


def _swept_along(axis: xr.DataArray, layers: Iterable[points.Layer]) -> list[points.Layer]:
    """The layers whose grid has an axis; of a branch along it that is none."""
    return [one for one in layers if select.has_axis(one.dataset, axis.name)]


def _laid_over(layers: Sequence[points.Layer]) -> list[points.Layer]:
    """Branches and critical values after what they may lie over, whose axis, variables and title
    are those of the figure; unless no other file has anything of the kind."""
    laid = [branch.suits(one.dataset) or "critical_value" in one.dataset for one in layers]
    shows = any(
        any(map(_is_zero_at_turns, map(str, one.dataset))) and points.varying_axes(one.dataset)
        for one, is_laid in zip(layers, laid, strict=True)
        if not is_laid
    )
    pairs = zip(laid, layers, strict=True)
    return [one for _, one in sorted(pairs, key=itemgetter(0))] if shows else [*layers]


def _without_critical(
    layers: Sequence[points.Layer], settings: points.Settings
) -> tuple[list[points.Layer], list[points.Layer]]:
    """The layers of a figure of amplitudes or growth, and those whose critical values lie where
    these are zero; there are none where they are what is shown."""
    asked = variables_of(layers, settings)
    logarithmic = points.is_logarithmic(settings, "y")  # on which nothing is zero
    if logarithmic or not any(map(_is_zero_at_turns, asked)):
        return [*layers], []
    axis = points.abscissa(layers[0].dataset, settings)
    own, found = [*layers[:1]], list[points.Layer]()
    for one in layers[1:]:
        shows = any(name in one.dataset for name in asked)
        (found if is_critical_along(one.dataset, axis) and not shows else own).append(one)
    if len(own) == 1 < len(layers) and not own[0].dataset.attrs.get("called"):
        own = [replace(own[0], label="")]  # it stands alone
    return own, found


def _is_zero_at_turns(name: str) -> bool:
    """Whether a variable is zero where an equilibrium turns."""
    return name == GROWTH or name.endswith(AMPLITUDE)


def _shown(layers: Sequence[points.Layer], settings: points.Settings) -> _Shown:
    """What the figure asks for of some datasets.

    Raises
    ------
    UsageError : one of them has nothing of it
    """
    axis = points.abscissa(layers[0].dataset, settings)
    settings = {**settings, "x": str(axis.name)}  # of every analysis and file
    layers = _alone_unnamed(layers, axis)
    names = _of_each(layers, variables_of(layers, settings), axis)
    parts = {name: _having(layers, name) for name in names}
    for number, layer in enumerate(layers):
        _refuse_without(layer, [name for name, own in parts.items() if number in own], parts)
    along = {name: _along(own, axis) for name, own in parts.items()}
    panels = _panels({name: _first(own).dataset[name] for name, own in parts.items()})
    return _Shown(axis, parts, along, panels, settings)


def _draw_panels(
    axes: Sequence[Axes], shown: _Shown, drawn: Sequence[tuple[int, Curve]], dashed: str
) -> None:
    """Draw the lines of each panel; the words of the dim that is `dashed` are told by dashes."""
    every = [curve for _, curve in drawn]
    entries = _entries(every, dashed)
    of_panels: list[list[tuple[Curve, points.Entry]]] = [[] for _ in shown.panels]
    for (place, curve), entry in zip(drawn, entries, strict=True):
        of_panels[place].append((curve, entry))
    bare, numeric = shown.bare, select.is_numeric(shown.axis)
    most = max((_crowd(own) for n, own in enumerate(of_panels) if n not in bare), default=0)
    if dashed:
        _name_looks(axes[0], every, entries, dashed, most)
    logarithmic = points.is_logarithmic(shown.settings, "y")
    for ax, own, lines in zip(axes, shown.panels, of_panels, strict=True):
        if not all(curve.of_crossings for curve, _ in lines):
            lines = [(curve.marked_as_others(), entry) for curve, entry in lines]
        barred = draw_panel(ax, own, lines, most, numeric, logarithmic)
        told = [told_by_bars(one.dataset, name) for name in own for one in shown.along[name]]
        if barred and any(told):
            ax.plot([], [], color=style.BLACK, label=max(told, key=len), **ERROR_BAR)


def _told(shown: _Shown, every: Sequence[Curve], dashed: str) -> Iterator[str]:
    """What to do about what is not drawn, or not joined."""
    yield from _of_edges(shown.parts)
    alike = [own for name, own in shown.parts.items() if name in OF_A_PAIR]
    if any(one.dataset.sizes.get("mode", 1) > 1 for own in alike for one in own.values()):
        yield (
            "of a conjugate pair both are drawn, as one line; --figure eigenvalues draws one of "
            "them, where modes merge and where they turn unstable"
        )
    yield from _of_modes_alike(shown.parts.get("growth_frequency", {}).values())
    yield from _of_crossings(shown.parts, shown.axis)
    yield from _of_branches_not_drawn(shown.parts, shown.axis)
    known = [one for one in every if one.is_known]
    yield from _of_undecided(known, shown.panels)
    words = {dim: {one.words.get(dim) for one in known} for one in known for dim in one.words}
    dims = [d for d, told in words.items() if len(told) > 1 and d not in {VARIABLE, DATASET}]
    pieces = sum(one.pieces for one in known)
    is_broken = pieces > points.PIECES * len(known)
    names = [one.label if is_broken else one.without(dashed) for one in known]
    dims.sort(key=lambda dim: dim != "initial")
    yield from points.of_many_lines(names, dims, pieces if is_broken else 0)
    x = np.unique([place for one in every for place in one.x])
    for crossings in (True, False) if select.is_numeric(shown.axis) else ():
        told = [one for one in every if one.of_crossings == crossings and one.apart]
        for one in told if crossings else told[:MOST_TOLD]:
            what = "it" if crossings else "it, or another number of its motion,"
            yield from broken(one.label or shown.first, shown.axis.name, one.apart, x, what)


def _of_modes_alike(layers: Iterable[points.Layer]) -> Iterator[str]:
    """That which mode grows most is not told where several of other frequencies grow alike."""
    alike = 0
    for dataset in (one.dataset for one in layers if "eigenvalue_real" in one.dataset):
        growth, turning = dataset["eigenvalue_real"], abs(dataset["eigenvalue_imag"])
        most = growth >= growth.max("mode") - style.ROUNDING * abs(turning).max("mode")
        turning = turning.where(most)
        spread = turning.max("mode") - turning.min("mode")
        alike += int((spread > style.ROUNDING * turning.max("mode")).sum())
    if alike:
        yield (
            f"growth_frequency: at {alike} points modes of other frequencies grow as much, and it "
            "is that of one of them; --figure eigenvalues draws all"
        )


def _of_undecided(
    every: Sequence[Curve], panels: Sequence[Mapping[str, xr.DataArray]]
) -> Iterator[str]:
    """That marks of undecided values do not tell variables of one panel apart."""
    named = [{labels.name_of(array) for array in own.values()} for own in panels]
    hollow = {one.words.get(VARIABLE) for one in every if np.isfinite(one.y[one.open]).any()}
    for alike in (own & hollow for own in named if len(own & hollow) > 1):
        yield (
            f"values of undecided motions look alike for {listed(sorted(alike))}: a longer t_max "
            "decides most; --figure curve --variable NAME draws one alone"
        )


def _alone_unnamed(layers: Sequence[points.Layer], axis: xr.DataArray) -> list[points.Layer]:
    """Without the name of the only file over which the branches of others lie, if none is given."""
    swept = _swept_along(axis, layers)
    over = [one for one in layers if branch.suits(one.dataset)]
    bare = len(swept) == 1 and len(swept) + len(over) == len(layers) > 1
    return [
        replace(one, label="")
        if bare and one is swept[0] and not one.dataset.attrs.get("called")
        else one
        for one in layers
    ]


def _of_branches_not_drawn(parts: Mapping[str, _Parts], axis: xr.DataArray) -> Iterator[str]:
    """What to do where a branch along the abscissa tells nothing of what is drawn, or where one
    leads along another parameter."""
    for name, own in parts.items():
        for layer in own.values():
            dataset, (state, _, of) = layer.dataset, name.rpartition("_")
            leads = branch.leads_along(dataset, str(axis.name))
            if of in branch.OF_EXTREMES and not leads and (along := branch.parameter_of(dataset)):
                yield (
                    f"{name} of one cycle at each {axis.name}: its branch along {along} is in "
                    f"--figure branch, or over a response along {along} in a file before it"
                )
            if not leads or _is_told_beside(layer, own, name, axis):
                continue
            if not dataset[branch.ALONG].size:
                yield f"no branch of {layer.label}: of the starts drawn none found a cycle"
            elif of in branch.OF_EXTREMES and not branch.is_along(dataset, str(axis.name), state):
                yield (
                    f"{name} of one cycle of {layer.label}: its branch tells of another state; "
                    f'observe = "{state}" in its analysis, or in that of a file drawn with it'
                )


def _is_told_beside(layer: points.Layer, own: _Parts, name: str, axis: xr.DataArray) -> bool:
    """Whether a branch of another file tells a variable of cycles that this one's does not."""
    state, _, of = name.rpartition("_")
    tells = [branch.is_along(one.dataset, str(axis.name), state) for one in own.values()]
    is_one = branch.leads_along(layer.dataset, str(axis.name)) and of in branch.OF_EXTREMES
    return is_one and any(tells) and not branch.is_along(layer.dataset, str(axis.name), state)


def _having(layers: Sequence[points.Layer], name: str) -> dict[int, points.Layer]:
    """Each layer that has a variable, by its number, as the analysis of its case that does."""
    held = ((number, one, [one.dataset, *one.beside]) for number, one in enumerate(layers))
    return {
        number: replace(layer, dataset=own)
        for number, layer, some in held
        for own in [one for one in some if name in one][:1]
    }


def _first(parts: _Parts) -> points.Layer:
    """The first layer that has a variable."""
    return next(iter(parts.values()))


def _of_each(layers: Sequence[points.Layer], names: Sequence[str], axis: xr.DataArray) -> list[str]:
    """The variables and, of each file along the axis that has none of them, its own number."""
    own = [
        next((n for n in _headlines(one.dataset) if not flag_names(one.dataset[n].attrs)), "")
        for one in _swept_along(axis, layers)
        if not any(name in part for part in (one.dataset, *one.beside) for name in names)
    ]
    return [*dict.fromkeys([*names, *filter(None, own)])]


def _refuse_without(layer: points.Layer, has: Sequence[str], names: Iterable[str]) -> None:
    """Raise a UsageError where a dataset has nothing of what is drawn."""
    if not has:
        raise UsageError(
            f"{layer.label}: no {' or '.join(names)}, which this curve shows of the other "
            "datasets\nnext: draw it alone (fiv plot FILE.nc); it has "
            f"{listed(headlines(layer.dataset))}"
        )


def _along(parts: _Parts, axis: xr.DataArray) -> list[points.Layer]:
    """The first dataset of the figure, and those that have its axis."""
    return [
        one
        for number, one in parts.items()
        if not number or select.has_axis(one.dataset, axis.name)
    ]


def _with_gaps(along: Mapping[str, Sequence[points.Layer]]) -> list[points.Layer]:
    """Each dataset whose gaps are marked; of several analyses called by what is shown of it."""
    several = len({id(own[0].dataset) for own in along.values() if own}) > 1
    found = {}
    for name, own in along.items():
        for one in own:
            words = labels.name_of(one.dataset[name]) if several else ""
            found[id(one.dataset), words] = replace(one, label=points.joined(words, one.label))
    return [*found.values()]


def _lines(shown: _Shown) -> Iterator[tuple[int, Curve]]:
    """The lines of each panel, by its number, one dataset after the other."""
    parts, along, axis = shown.parts, shown.along, shown.axis
    own_sorts = [
        {sort: 0 for one in own.values() for sort in sorts_of(one.dataset)}
        for own in parts.values()
    ]
    several = max(map(len, own_sorts)) > 1  # else the variable tells the sort
    sorts = list(dict.fromkeys(chain(*own_sorts))) if several else []
    every = sorted({number for own in parts.values() for number in own})
    of_each = zip(shown.panels, shown.of_panels, strict=True)
    of_panels = {name: settings for own, settings in of_each for name in own}
    for number, (place, own) in product(every, enumerate(shown.panels)):
        for name in [name for name in own if number in parts[name]]:
            part, rest = parts[name][number], len(parts[name]) - len(along[name])
            if _is_told_beside(part, parts[name], name, axis):
                continue
            named = len(own) > 1
            curves = (
                lines_of(part, name, named, of_panels, sorts, rest > 0)
                if any(part is one for one in along[name])
                else lines_of_branches(part, name, axis, named, rest > 1, bool(along[name]))
                or lines_without_axis(part, name, named, _first(parts[name]).dataset, axis)
            )
            yield from ((place, curve) for curve in curves)
            if rest and name.endswith(AMPLITUDE):
                datasets = (one.dataset for one in parts[name].values())
                births = branch.births_along(datasets, str(axis.name), name.removesuffix(AMPLITUDE))
                yield from ((place, curve) for curve in equilibria(part, axis, births))


def _told_by_dashes(drawn: Sequence[tuple[int, Curve]], bare: Sequence[int]) -> str:
    """The dim whose words dashes tell, and colours those of all others; "" where none is.

    It leaves fewer entries than lines, or as many, but short ones, or where some starts lead to the
    same: one colour is seen beneath another, and two sorts of dashes are a tangle. Better is one
    that not all panels have, and of few values. In `bare` panels, and among members of random
    starts, no dashes are seen; beside branches they tell what is stable.
    """
    if any(one.sort for _, one in drawn):
        return ""
    names, fit = {points.stem(one.label) for _, one in drawn}, {}
    most = len(names) + _coincide(drawn)
    for dim in dict.fromkeys(chain(*(one.words for _, one in drawn))):
        told = [(place, one) for place, one in drawn if one.words.get(dim)]
        panels = {place for place, _ in told}
        unseen = any(place in bare or one.is_random for place, one in told)
        mixed = any(place in panels and not one.words.get(dim) for place, one in drawn)
        sorts = {one.words[dim] for _, one in told}
        count = len(sorts) + len({points.stem(one.without(dim)) for _, one in drawn})
        few = len(names) <= len(style.LINES)  # that colours tell all of
        hidden = dim == "initial" and few and _coincide(told)
        unfit = unseen or mixed or hidden
        fewer = count < most + (count == len(names) and max(map(len, names)) > LONG_LABEL)
        if 0 < len(sorts) <= len(style.DASHES) and fewer and not unfit:
            fit[dim] = len(panels), len(sorts)
    return min(fit, key=lambda dim: fit[dim], default="")


def _marked_apart(drawn: Sequence[tuple[int, Curve]], dashed: str) -> list[tuple[int, Curve]]:
    """The lines, with marks that tell what dashes do where one of their points stands alone."""
    if not any(one.has_lone for _, one in drawn if one.words.get(dashed)):
        return [*drawn]
    words = dict.fromkeys(one.words.get(dashed, "") for _, one in drawn)
    own_marks = (mark for mark in SORT_MARKS[1:] if mark[0] != OF_UNDECIDED)
    hollow = {"mfc": "none", "mew": 0.8}  # a dot is seen in each
    keys = (dict(zip(("marker", "ms"), mark, strict=True)) | hollow for mark in own_marks)
    marks = dict(zip(filter(None, words), (DOT, *keys), strict=False))
    own = ((place, one, marks.get(one.words.get(dashed, ""), DOT)) for place, one in drawn)
    return [(place, replace(one, mark=mark, short=TOO_SHORT)) for place, one, mark in own]


def _seen_through(drawn: Sequence[tuple[int, Curve]]) -> list[tuple[int, Curve]]:
    """The lines, those of starts of a table with marks through which others are seen: here they
    lead to one motion, and there to another."""
    starts = [*dict.fromkeys(one.words.get("initial", "") for _, one in drawn)]
    if len(starts) < 2 or not all(map(OF_TABLE.search, starts)):
        return [*drawn]
    size = DOT["ms"] / MARKED_WIDER
    marks = {name: style.mark_of(n, len(starts), size) for n, name in enumerate(starts)}
    return [(place, replace(one, mark=marks[one.words["initial"]])) for place, one in drawn]


def _coincide(drawn: Sequence[tuple[int, Curve]]) -> bool:
    """Whether lines that differ in their start alone run upon each other for a while.

    Of one colour those beneath would not be seen.
    """
    pairs = (
        (one, other)
        for (place, one), (there, other) in combinations(drawn, 2)
        if place == there and one.without("initial") == other.without("initial")
    )
    met = (
        np.isclose(one.y, other.y, rtol=points.UPON, atol=0.0)
        for one, other in pairs
        if np.array_equal(one.x, other.x)
    )
    return any((at[1:] & at[:-1]).any() for at in met)


def _entries(lines: Sequence[Curve], dashed: str) -> list[points.Entry]:
    """How each line looks, by its words and those of the dim that is `dashed`, if one is.

    One that has no value in any panel is said to have none.
    """
    shown = [one for one in lines if one.is_known or one.of_crossings]
    known = {"", *(word for one in shown for word in (one.label, one.without(dashed)))}
    names = [one.without(dashed) for one in lines]
    entries = points.entries(names)
    if {*names} <= {*CLASS_COLOURS}:  # as in maps
        of_classes = zip(entries, names, strict=True)
        entries = [replace(entry, colour=CLASS_COLOURS[name]) for entry, name in of_classes]
    if any(one.sort for one in lines):  # dashes tell these
        entries = [replace(entry, dash="-") for entry in entries]
    if dashed:
        sorts = filter(None, dict.fromkeys(one.words.get(dashed) for one in lines))
        dashes = dict(zip(sorts, style.DASHES, strict=False))
        entries = [
            replace(
                entry,
                dash=dashes.get(one.words.get(dashed, ""), "-"),
                label=points.unlisted(points.stem(one.label)),
            )
            for one, entry in zip(lines, entries, strict=True)
        ]
    return [
        entry if one.label in known else replace(entry, label=f"{one.label}: no value")
        for one, entry in zip(lines, entries, strict=True)
    ]


def _name_looks(
    ax: Axes, lines: Sequence[Curve], entries: Sequence[points.Entry], dashed: str, most: int
) -> None:
    """Legend entries of colours and of dashes, each by the words that it tells.

    Where marks tell what dashes do those that have some are shown with them.
    """
    pairs = [pair for pair in zip(lines, entries, strict=True) if pair[0].is_known]
    colours = {points.stem(one.without(dashed)): entry.colour for one, entry in pairs}
    for word, colour in colours.items():
        ax.plot([], [], color=colour, label=word, **style.COLOUR_ALONE)
    looks: dict[str, tuple[Any, Mapping[str, Any]]] = {}
    for one, entry in pairs:
        tells = one.short == TOO_SHORT and has_marks(ax, one, most)
        _, before = looks.get(one.words.get(dashed, ""), ("", {}))
        looks[one.words.get(dashed, "")] = entry.dash, one.mark if tells else before
    for word, (dash, mark) in looks.items():
        if word:
            ax.plot([], [], ls=dash, color=style.BLACK, label=word, **mark)


def _panels(variables: Mapping[str, xr.DataArray]) -> list[dict[str, xr.DataArray]]:
    """The variables of each panel: those of one unit, and each of classes by itself."""
    panels: dict[tuple[str, str], dict[str, xr.DataArray]] = {}
    for name, variable in variables.items():
        kind = name if flag_names(variable.attrs) else ""
        panels.setdefault((str(variable.attrs.get("units", "1")), kind), {})[name] = variable
    return list(panels.values())


def _crowd(lines: Sequence[tuple[Curve, points.Entry]]) -> int:
    """The points of the longest line of a panel; more of them where dashes are to be seen."""
    crowd = max((np.isfinite(c.y).sum() for c, _ in lines if not c.of_crossings), default=0)
    looks = {(entry.colour, str(entry.dash)) for _, entry in lines}
    dashes = {dash for _, dash in looks}
    tell_more = len(looks) > len({colour for colour, _ in looks}) or len(dashes) > 2
    return int(crowd) * (TO_SEE_DASHES if tell_more else 1)


def _of_crossings(parts: Mapping[str, _Parts], axis: xr.DataArray) -> Iterator[str]:
    """Where what may be met several times, or never, is not; and how far the rest may be off."""
    for name, own in parts.items():
        for layer in own.values():
            array = numbers(layer.dataset[name])
            dims = [dim for dim in array.dims if dim != "crossing"]
            if len(dims) == array.ndim or not select.has_axis(layer.dataset, axis.name):
                continue
            met = array.notnull().any("crossing")
            if lacking := int((~met).sum()):
                yield (
                    f"{name}: none at {lacking} of {met.size} places, where there is no line; "
                    "fiv show of its file says why"
                )
            error = numbers(layer.dataset.get(error_of(name), array * np.nan)).max().item()
            unit = f" {array.attrs.get('units', '1')}".removesuffix(" 1")
            extent = float(array.max() - array.min())
            if TOLD * extent < error <= UNSEEN * extent:
                yield f"{name}: off by at most {error:.2g}{unit}, less than is seen of error bars"


def _of_edges(parts: Mapping[str, _Parts]) -> list[str]:
    """What to do about ends that are none, by the variables of a figure."""
    counts = {
        name: sum(int(is_edge(one.dataset, name).sum()) for one in own.values())
        for name, own in parts.items()
    }
    return [
        f"{name}: {count} of them an edge of the bracket, beyond which it may go on: widen it"
        for name, count in counts.items()
        if count
    ]


def _headlines(dataset: xr.Dataset) -> list[str]:
    """What a curve shows unless the figure says otherwise: numbers first."""
    return sorted(headlines(dataset), key=lambda name: bool(flag_names(dataset[name].attrs)))


def variables_of(layers: Sequence[points.Layer], settings: points.Settings) -> list[str]:
    """The variables that the figure names (``variable``, or ``y``), else the preferred one.

    Raises
    ------
    UsageError : no dataset has it, nor, where no analysis is named, one beside it
    """
    first, alone = layers[0].dataset, "analysis" in settings
    default = settings.get("y", next(iter(_headlines(first)), "variable"))
    others = [own for one in layers for own in (one.dataset, *(() if alone else one.beside))]
    beside = {name for dataset in others for name in dataset.data_vars}
    return [
        name if name in beside else points.known_variable(first, name)
        for name in points.variables(settings, default)
    ]
