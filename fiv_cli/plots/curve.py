"""Variables against an axis, a line for each start and for each value of the other axes.

Variables of one unit share a panel.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import chain, combinations, pairwise, product
from typing import TYPE_CHECKING, Any

import matplotlib as mpl
import numpy as np

from fiv_cli.errors import UsageError
from fiv_cli.flags import NOT_COMPUTED
from fiv_cli.notation.names import listed
from fiv_cli.plots import branch, labels, leaps, points, smooth, style
from fiv_cli.plots.drawn import DECORATION
from fiv_cli.plots.turns import up_to_turns
from fiv_cli.reading import select
from fiv_cli.reading.datasets import (
    ends_of,
    error_of,
    flag_names,
    headlines,
    is_class,
    numbers,
    standard_error_of,
    unknown_points,
)
from fiv_cli.reading.shares import ERROR, SURE, sampling_error

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

VARIABLE, DATASET = "variable", "dataset"  # what tells lines apart beside dims
CLASS_SHIFT = 0.06
DOT: dict[str, Any] = {"marker": ".", "ms": 3}
ACROSS = 0.8  # of the width of a figure: what a panel has
TOO_SHORT = 2  # points, at most, of a piece that does not show what its dashes are
AMPLITUDE = "_amplitude"  # how the names of such variables end
SORT_MARKS = (("o", 3.0), ("x", 4.5), ("^", 4.0), ("+", 5.5), ("D", 3.0), ("v", 4.0))
TO_SEE_DASHES = 4  # times the room between marks without it
MOST_MARKED = 25  # crossings on a line: of more the marks hide its dashes, and other lines
PLACE: dict[str, Any] = {"marker": "D", "ms": 4}  # of a dataset that lies at one of the axis
HOLLOW: dict[str, Any] = {"marker": "o", "ms": 3, "mfc": "none", "mew": 0.6, "ls": "none"}
FRAMED = "several, one upon another"
FRAME: dict[str, Any] = {"marker": "s", "ms": 7, "mfc": "none", "mew": 1.2, "ls": "none"}
ERROR_BAR: dict[str, Any] = {"marker": "|", "ms": 8, "mew": 0.8, "ls": "none"}  # in the legend
CAP = 2.0  # half the width of the ends of error bars, pt
UPON = 1e-6  # relative: values that differ by less are drawn at one place
UNSEEN = 5e-3  # of all that a panel shows: an error bar that is shorter has no ends
RESTS = {"stable": "-", "unstable": ":"}  # their dashes, which are no cycles'
BRANCH = 1.8  # as wide as other lines, which lie over it: it is seen beside these
BAR: dict[str, Any] = {"lw": 2.5, "alpha": 0.5}
NARROW = 2.5e-3  # of the greatest value: half of what may be, that is told by an error bar
UNSURE = {
    "value of an undecided motion": HOLLOW,
    "undecided points: from least to greatest": BAR,
    "undecided points: at least": {"marker": "^", "ms": 4, "ls": "none"},
    "undecided points: at most": {"marker": "v", "ms": 4, "ls": "none"},
    "undecided points: nothing known": {"marker": "x", "ms": 5, "ls": "none"},
    "error not known": {"marker": "o", "ms": 7, "mfc": "none", "mew": 0.6, "ls": "none"},
}
CLASS_COLOURS = {name.replace("_", " "): colour for name, colour in style.CLASSES.items()}
MOST_STEPS = 3  # of one line that are told of
MOSTLY = 0.9  # of their points, at which lines of all starts are one, but for what each has alone
MOST_COMPARED = 100  # lines that may lie on one another
ROOM = (1.0, 4.0, np.inf)  # of the steps beside it, that a step of a followed value may have ...
SMALL = 0.02  # ... or of all values
SHORTER = 1.01

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


_Parts = Mapping[int, points.Layer]
"""The layers that have a variable, by their number in the figure."""


def suits(dataset: xr.Dataset) -> bool:
    """Whether there is a scalar variable along some axis."""
    return bool(_headlines(dataset)) and bool(points.varying_axes(dataset))


def has_an_axis(dataset: xr.Dataset) -> bool:
    """Whether a branch of cycles has an axis of parameters; over starts alone it tells nothing."""
    along = [axis.name for axis in points.varying_axes(dataset)]
    return along != ["initial"] or not branch.suits(dataset)


def draw(layers: Sequence[points.Layer], settings: points.Settings) -> Figure:
    """Lines of every layer; undecided points are hollow, or bars over all that they may be.

    No line leads through these, nor from a point of one class to a neighbour of another.
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
    numeric = select.is_numeric(axis)
    bare = [n for n, own in enumerate(panels) if not numeric or _is_of_classes(own)]
    drawn = _each_once([*_lines(parts, along, panels, axis, settings)])
    points.refuse_empty(layers[0].dataset, any(one.is_known for _, one in drawn), names[0])
    title = points.title(*(layer.dataset for layer in layers))
    figure, axes = style.new_panels(len(panels), 1, title, sharex=True)
    dashed = _told_by_dashes(drawn, bare)
    drawn = _marked_apart(drawn, dashed)
    every = [curve for _, curve in drawn]
    entries = _entries(every, dashed)
    of_panels: list[list[tuple[_Curve, points.Entry]]] = [[] for _ in panels]
    for (place, curve), entry in zip(drawn, entries, strict=True):
        of_panels[place].append((curve, entry))
    most = max((_crowd(own) for n, own in enumerate(of_panels) if n not in bare), default=0)
    if dashed:
        _name_looks(axes[0], every, entries, dashed, most)
    own_settings = [points.of_panel(settings, n, own) for n, own in enumerate(panels)]
    for ax, own, lines in zip(axes, panels, of_panels, strict=True):
        if not all(curve.of_crossings for curve, _ in lines):
            lines = [(curve.marked_as_others(), entry) for curve, entry in lines]
        barred = _panel(ax, own, lines, most, numeric, points.is_logarithmic(settings, "y"))
        told = [_told_by_bars(one.dataset, name) for name in own for one in along[name]]
        if barred and any(told):
            ax.plot([], [], color=style.BLACK, label=max(told, key=len), **ERROR_BAR)
    gaps = ("undecided", *points.ENDED) if names == ["attractor"] else ()
    points.dress(axes, _with_gaps(along), own_settings, gaps)
    shown = [one.without(dashed) for one in every if one.is_known]
    unmet = _of_branches_not_drawn(parts, axis)
    x = np.unique([place for one in every for place in one.x])
    steps = [broken(one.label or names[0], axis.name, one.apart, x) for one in every]
    notes = *_of_edges(parts), *unmet, *points.of_many_lines(shown), *chain(*steps)
    style.add_notes(figure, notes)
    return figure


def _alone_unnamed(layers: Sequence[points.Layer], axis: xr.DataArray) -> list[points.Layer]:
    """Without the name of the only file over which the branches of others lie, if none is given."""
    swept = [one for one in layers if select.has_axis(one.dataset, axis.name)]
    over = [one for one in layers if branch.suits(one.dataset)]
    bare = len(swept) == 1 and len(swept) + len(over) == len(layers) > 1
    return [
        replace(one, label="")
        if bare and one is swept[0] and not one.dataset.attrs.get("called")
        else one
        for one in layers
    ]


def _of_branches_not_drawn(parts: Mapping[str, _Parts], axis: xr.DataArray) -> Iterator[str]:
    """What to do where a branch along the abscissa tells nothing of what is drawn."""
    for name, own in parts.items():
        for layer in own.values():
            dataset, (state, _, of) = layer.dataset, name.rpartition("_")
            if not branch.leads_along(dataset, str(axis.name)):
                continue
            if not dataset[branch.ALONG].size:
                yield f"no branch of {layer.label}: of the starts drawn none found a cycle"
            elif of in branch.OF_EXTREMES and not branch.is_along(dataset, str(axis.name), state):
                yield (
                    f"{name} of one cycle of {layer.label}: its branch tells of another state; "
                    f'observe = "{state}" in its analysis'
                )


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
        for one in layers
        if select.has_axis(one.dataset, axis.name)
        and not any(name in part for part in (one.dataset, *one.beside) for name in names)
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


def _lines(
    parts: Mapping[str, _Parts],
    along: Mapping[str, Sequence[points.Layer]],
    panels: Sequence[Mapping[str, xr.DataArray]],
    axis: xr.DataArray,
    settings: points.Settings,
) -> Iterator[tuple[int, _Curve]]:
    """The lines of each panel, by its number, one dataset after the other.

    Of each variable there are the `parts` that have it, some of which vary `along` the axis.
    """
    own_sorts = [
        {sort: 0 for one in own.values() for sort in _sorts(one.dataset)} for own in parts.values()
    ]
    several = max(map(len, own_sorts)) > 1  # else the variable tells the sort
    sorts = list(dict.fromkeys(chain(*own_sorts))) if several else []
    every = sorted({number for own in parts.values() for number in own})
    of_panels = {
        name: points.of_panel(settings, place, own)
        for place, own in enumerate(panels)
        for name in own
    }
    for number, (place, own) in product(every, enumerate(panels)):
        for name in [name for name in own if number in parts[name]]:
            part, rest = parts[name][number], len(parts[name]) - len(along[name])
            curves = (
                _curves(part, name, len(own) > 1, of_panels, sorts, rest > 0)
                if any(part is one for one in along[name])
                else _of_branches(part, name, axis, rest > 1, bool(along[name]))
                or _without_axis(part, name, _first(parts[name]).dataset, axis)
            )
            yield from ((place, curve) for curve in curves)
            if rest and name.endswith(AMPLITUDE):
                births = _births(parts[name].values(), axis, name.removesuffix(AMPLITUDE))
                yield from ((place, curve) for curve in _rests(part, axis, births))


def _births(layers: Iterable[points.Layer], axis: xr.DataArray, observed: str) -> np.ndarray:
    """Where branches along an axis end at an equilibrium."""
    every = [one.dataset for one in layers]
    along = [one for one in every if branch.is_along(one, str(axis.name), observed)]
    return np.concatenate([np.zeros(0), *map(branch.births, along)])


def _rests(layer: points.Layer, axis: xr.DataArray, births: np.ndarray) -> Iterator[_Curve]:
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
                at, y, _ = up_to_turns(births, x, every, y) if births.size else (x, y, ())
                what = at, y, np.zeros(at.size, bool), (y, y), np.zeros(at.size)
                look: dict[str, Any] = {"dash": dash, "mark": {"marker": "None"}}
                words = {DATASET: layer.label, **line.words}
                yield _Curve(words, *what, **look, sort=f"{word} equilibrium")


def _each_once(drawn: Sequence[tuple[int, _Curve]]) -> list[tuple[int, _Curve]]:
    """The same (panel, line), with one in place of a few that would hide one another."""
    if len(drawn) > MOST_COMPARED:
        return [*drawn]
    starts = {*filter(None, (one.words.get("initial") for _, one in drawn))}
    parted = [*_parted(drawn, starts)]
    groups: list[list[int]] = []
    for number, (place, one) in enumerate(parted):
        firsts = (group for group in groups if parted[group[0]][0] == place)
        group = next((own for own in firsts if one.hides(parted[own[0]][1])), None)
        if group is None:
            groups.append([number])
        else:
            group.append(number)
    alike = [[parted[number] for number in group] for group in groups]
    called = chain(parted, *(_as_one(group, starts) for group in alike))
    by_name = all(one.words.get("initial") not in points.SHARED for _, one in called)
    found: dict[int, tuple[int, _Curve]] = {}
    for group, own in zip(groups, alike, strict=True):
        # what stays apart keeps its place, and with it its colour
        found |= zip(group, _as_one(own, starts, by_name), strict=False)
    return [found[number] for number in sorted(found)]


def _parted(
    drawn: Sequence[tuple[int, _Curve]], starts: Collection[str]
) -> Iterator[tuple[int, _Curve]]:
    """The same (panel, line); what all `starts` share of lines that are one nearly everywhere once.

    Of each such line there is what it has for itself then.
    """
    alike: dict[tuple[int, str], list[_Curve]] = {}
    for place, one in drawn:
        alike.setdefault((place, one.without("initial")), []).append(one)
    shared = [_shared(own, starts) for own in alike.values()]
    if not MOSTLY <= min((share for _, share in shared), default=1.0) < 1.0:
        yield from drawn
        return
    for ((place, _), own), (part, _) in zip(alike.items(), shared, strict=True):
        called = {**own[0].words, "initial": points.SHARED[len(starts) > 2]}
        names = tuple(one.label for one in own)
        if not part.any():
            yield from ((place, one) for one in own)
            continue
        yield place, replace(own[0].only(part), words=called, names=names, way=np.zeros(0))
        yield from ((place, one.only(~part)) for one in own if (one.known & ~part).any())


def _shared(own: Sequence[_Curve], starts: Collection[str]) -> tuple[np.ndarray, float]:
    """At which points lines of several starts are one, and at what share of those with a value.

    Of what is no line of a start, none.
    """
    plain = all("initial" in one.words and not one.is_random for one in own)
    if not plain or len(own) != len(starts) or not all(one.can_hide(own[0]) for one in own):
        return np.zeros(1, bool), 0.0
    known = np.any([one.known for one in own], axis=0)
    part = known & np.all([one.agrees_with(own[0]) for one in own], axis=0)
    return part, float(part.sum() / known.sum()) if known.any() else 1.0


def _as_one(
    group: list[tuple[int, _Curve]], starts: Collection[str], by_name: bool = True
) -> list[tuple[int, _Curve]]:
    """Lines that hide one another as the first, which has the name of all, if there is one.

    Those of all `starts` at one place have one, that of each or, not `by_name`, of all of them.
    Where several places have one line, the starts of each place may.
    """
    (place, first), told = group[0], tuple(one.label for _, one in group)
    names = tuple(chain(*(one.names or (one.label,) for _, one in group)))
    if len(group) == 1 or len({(*one.words,) for _, one in group}) > 1:
        return group
    own = {one.words.get("initial") for _, one in group}
    is_one = len({one.without("initial") for _, one in group}) == 1 and len(group) == len(own)
    of_each = is_one and own == starts and not any(one.is_random for _, one in group)
    if of_each and not (by_name and points.of_all(told)):
        words = {**first.words, "initial": points.SHARED[len(starts) > 2]}
        return [(place, replace(first, words=words, names=names))]
    if not points.of_all(told):
        places: dict[str, list[tuple[int, _Curve]]] = {}
        for at, one in group:
            places.setdefault(one.without("initial"), []).append((at, one))
        apart = [*places.values()] if len(places) > 1 else [[one] for one in group]
        return [*chain(*(_as_one(one, starts, by_name) for one in apart))]
    words = {
        dim: points.BOTH.join(dict.fromkeys(one.words[dim] for _, one in group))
        for dim in first.words
    }
    return [(place, replace(first, words=words, names=names))]


def _told_by_dashes(drawn: Sequence[tuple[int, _Curve]], bare: Sequence[int]) -> str:
    """The dim whose words dashes tell, and colours those of all others; "" where none is.

    It leaves fewer entries than lines; better one that not all panels have, and of few values. In
    `bare` panels, and among members of random starts, no dashes are seen; beside branches they tell
    what is stable.
    """
    if any(one.sort for _, one in drawn):
        return ""
    names, fit = {points.stem(one.label) for _, one in drawn}, {}
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
        if 0 < len(sorts) <= len(style.DASHES) and count < len(names) and not unfit:
            fit[dim] = len(panels), len(sorts)
    return min(fit, key=lambda dim: fit[dim], default="")


def _marked_apart(drawn: Sequence[tuple[int, _Curve]], dashed: str) -> list[tuple[int, _Curve]]:
    """The lines, with marks that tell what dashes do where one of their points stands alone."""
    if not any(one.has_lone for _, one in drawn if one.words.get(dashed)):
        return [*drawn]
    words = dict.fromkeys(one.words.get(dashed, "") for _, one in drawn)
    keys = (dict(zip(("marker", "ms"), mark, strict=True)) for mark in SORT_MARKS[1:])
    marks = dict(zip(filter(None, words), (DOT, *keys), strict=False))
    own = ((place, one, marks.get(one.words.get(dashed, ""), DOT)) for place, one in drawn)
    return [(place, replace(one, mark=mark, short=TOO_SHORT)) for place, one, mark in own]


def _coincide(drawn: Sequence[tuple[int, _Curve]]) -> bool:
    """Whether lines that differ in their start alone run upon each other for a while.

    Of one colour those beneath would not be seen.
    """
    pairs = (
        (one, other)
        for (place, one), (there, other) in combinations(drawn, 2)
        if place == there and one.without("initial") == other.without("initial")
    )
    met = (
        np.isclose(one.y, other.y, rtol=UPON, atol=0.0)
        for one, other in pairs
        if np.array_equal(one.x, other.x)
    )
    return any((at[1:] & at[:-1]).any() for at in met)


def _entries(lines: Sequence[_Curve], dashed: str) -> list[points.Entry]:
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
    ax: Axes, lines: Sequence[_Curve], entries: Sequence[points.Entry], dashed: str, most: int
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
        tells = one.short == TOO_SHORT and _has_marks(ax, one, most)
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


def _crowd(lines: Sequence[tuple[_Curve, points.Entry]]) -> int:
    """The points of the longest line of a panel; more of them where dashes are to be seen."""
    crowd = max((np.isfinite(c.y).sum() for c, _ in lines if not c.of_crossings), default=0)
    looks = {(entry.colour, str(entry.dash)) for _, entry in lines}
    dashes = {dash for _, dash in looks}
    tell_more = len(looks) > len({colour for colour, _ in looks}) or len(dashes) > 2
    return int(crowd) * (TO_SEE_DASHES if tell_more else 1)


def _panel(
    ax: Axes,
    variables: Mapping[str, xr.DataArray],
    lines: Sequence[tuple[_Curve, points.Entry]],
    most: int,
    numeric: bool,
    logarithmic: bool,
) -> bool:
    """The lines of some variables of one unit, against an axis that is `numeric` or of names.

    `most` are the points of the longest line of a figure. Tells whether the ends of some error
    bars are seen.
    """
    extent, barred = _extent([curve for curve, _ in lines], logarithmic), False
    classes = _is_of_classes(variables)
    for sort in dict.fromkeys(curve.sort for curve, _ in lines if curve.sort):
        own = sorted((c for c, _ in lines if c.sort == sort), key=lambda one: one.x.size)
        dash = own[-1].dash if own[-1].x.size > 1 else "none"
        mark = {**own[0].mark, **({} if own[0].is_marked else {"marker": "None"})}
        ax.plot([], [], ls=dash, color=style.BLACK, label=sort, **mark)
    lies_below, framed = any(not curve.sort for curve, _ in lines), False
    of_rests = len({curve.label for curve, _ in lines if curve.is_rest})
    of_cycles = len({curve.words.get(DATASET) for curve, _ in lines if curve.is_branch})
    for place, (curve, entry) in enumerate(lines):
        if curve.is_rest and of_rests == 1 and of_cycles <= 1:  # whose they are is plain
            entry = replace(entry, colour=style.BLACK)
        upon = sum((_upon(other, (curve, entry)) for other in lines[place + 1 :]), 0 * curve.x)
        most_seen = branch.MOST_BENEATH
        upon[(curve.y == 0.0) & (upon > most_seen)] = 0  # along the axis more would be a bar
        # lines of classes lie on one another: each is moved a little
        shift = classes * CLASS_SHIFT * (entry.number - lines[-1][1].number / 2)
        apart = classes or entry.scattered or not numeric
        room_for = 0 if curve.of_crossings else most
        if not apart:
            framed |= _frame_hidden(ax, curve, entry, [other for other, _ in lines[place + 1 :]])
        if lies_below and curve.sort and curve.dash == "-":
            curve = replace(curve, mark={**curve.mark, "lw": _width(BRANCH)})
        for named in _each_named(ax, curve, entry, apart, room_for):
            _plot(ax, curve, shift, named, apart, room_for, upon)
            barred |= _plot_errors(ax, curve, shift, named, extent * UNSEEN, logarithmic)
    if framed:
        ax.plot([], [], color=style.BLACK, label=FRAMED, **FRAME)
    for told, look in UNSURE.items():
        if any(str(drawn.get_label()).endswith(told) for drawn in (*ax.lines, *ax.collections)):
            ax.plot([], [], color=style.BLACK, label=told, **look)
    _name_values(ax, [*variables.values()])
    return barred


def _width(times: float) -> float:
    """So many times that of a line."""
    return float(times * mpl.rcParams["lines.linewidth"])


def _is_of_classes(variables: Mapping[str, xr.DataArray]) -> bool:
    """Whether the variables of a panel are classes."""
    return any(flag_names(one.attrs) for one in variables.values())


def _each_named(
    ax: Axes, curve: _Curve, entry: points.Entry, apart: bool, most: int
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


def _extent(curves: Sequence[_Curve], logarithmic: bool) -> float:
    """From the least to the greatest of what is drawn, errors included; of its logarithm."""
    ends = [end for one in curves for end in (one.y - one.error, one.y + one.error, one.y)]
    heights = np.concatenate([np.zeros(0), *map(np.ravel, ends)])
    heights = heights[np.isfinite(heights)]
    heights = np.log(heights[heights > 0.0]) if logarithmic else heights
    return float(np.ptp(heights)) if heights.size else 0.0


def _upon(over: tuple[_Curve, points.Entry], under: tuple[_Curve, points.Entry]) -> np.ndarray:
    """At which points of a line another, of another colour and as dashed, runs upon it."""
    (one, entry), (other, beneath) = over, under
    alike = entry.dash == beneath.dash and entry.colour != beneath.colour and not one.sort
    if not alike or not np.array_equal(one.x, other.x):
        return np.zeros(other.x.size, int)
    met = np.isclose(one.y, other.y, rtol=UPON, atol=0.0) & ~one.open & ~one.is_wide
    if one.without("initial") != other.without("initial"):
        met &= one.y != 0.0  # along the axis it would look like a bar
    met = np.pad(met, 1)
    return np.asarray(met[1:-1] & (met[2:] | met[:-2]), int)


def _frame_hidden(ax: Axes, curve: _Curve, entry: points.Entry, later: Sequence[_Curve]) -> bool:
    """A square about each point of a line that stands alone, and that of a `later` one hides.

    It is the wider the more of these there are. Tells whether there is any.
    """
    alone = points.alone(np.isfinite(curve.y) & ~curve.is_wide)
    x, y = curve.x[alone], curve.y[alone]
    count = np.zeros(x.size, int)
    for other in later if x.size else []:
        met = (other.x == x[:, None]) & np.isclose(other.y, y[:, None], rtol=UPON, atol=0.0)
        count += met.any(axis=1)
    for number in np.unique(count[count > 0]).tolist():
        here, wide = count == number, FRAME["ms"] * (1.0 + 0.5 * (number - 1))
        look = {**FRAME, "ms": wide, "color": entry.colour, "label": DECORATION}
        ax.plot(x[here], y[here], **look)
    return bool(count.any())


def _plot(
    ax: Axes,
    curve: _Curve,
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
    hidden = np.where(upon > 0, known, np.nan)
    x, cut, beneath = (np.insert(one, curve.jumps, np.nan) for one in (curve.x, known, hidden))
    dash = curve.dash if curve.sort else entry.dash
    label = points.unlisted(entry.label, curve.sort) if curve.sort else entry.label
    way = curve.whole_way + shift
    if not apart:
        seen = _marked_where_seen(ax, way, most, curve.short)
        look |= seen if curve.is_marked else {"marker": "None"}
    if upon.any() and not apart:
        wide = _width(1 + min(upon.max(), branch.MOST_BENEATH))
        ax.plot(x, beneath, ls=dash, lw=wide, color=entry.colour, label=DECORATION)
    if curve.way.size and not apart:
        ax.plot([], [], ls=dash, label=label, **look)
        ax.plot(x, way, ls=dash, label=DECORATION, **{**look, "marker": "None"})
        dash, label = "none", points.unlisted(label)
    if curve.is_branch and not apart:
        smooth.draw(ax, x, cut, label, ls=dash, **look)
    else:
        ax.plot(x, cut, ls="none" if apart else dash, label=label, **look)
    if curve.sort:  # the colour alone
        ax.plot([], [], color=entry.colour, marker="s", ls="none", label=entry.label)
    _plot_unsure(ax, curve, shift, entry)


def _plot_errors(
    ax: Axes,
    curve: _Curve,
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
    known, room = np.isfinite(heights), ACROSS * ax.figure.figure.get_figwidth() * style.POINTS
    if max(most, np.count_nonzero(known)) * DOT["ms"] < room:
        return {}
    alone = np.flatnonzero(points.alone(known, short)).tolist()
    return {"markevery": alone} if alone else {"marker": "None"}


def _has_marks(ax: Axes, curve: _Curve, most: int) -> bool:
    """Whether some points of a line are marked."""
    look = _marked_where_seen(ax, curve.whole_way, most, curve.short)
    return curve.is_marked and look.get("marker") != "None"


def _plot_unsure(ax: Axes, curve: _Curve, shift: float, entry: points.Entry) -> None:
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


@dataclass(frozen=True)
class _Curve:
    """One line: the words for its place by dim, and for its variable if several share the panel.

    `open` are the points whose class is undecided: their numbers are those of some stretch of time.
    `ends` are the least and the greatest that each may be, `error` is how far it may be off:
    infinite where that is not known. `jumps` are the places at which another class begins. `sort`
    is what `dash` and `mark` mean, where colours mean another thing. A line `of_crossings` has no
    gaps. No error reaches beyond the `limits`, such as 0 and 1 of a share. `names` are the labels
    of all for which it stands. Of a part of a line the `way` leads to its points, too. Pieces of
    no more than `short` points have marks by all means. `apart` are neighbours with crossings both,
    between which no line leads.
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

    @property
    def is_branch(self) -> bool:
        """Whether it is a branch of cycles, close enough to each other for a smooth line."""
        return self.sort.endswith(" cycle")

    @property
    def is_rest(self) -> bool:
        """Whether it is an equilibrium beside cycles."""
        return self.sort.endswith(" equilibrium")

    def marked_as_others(self) -> _Curve:
        """The same; of crossings whose mark tells nothing, with that of other lines, where they
        have theirs."""
        if not self.of_crossings or self.sort:
            return self
        return replace(self, mark=DOT, of_crossings=False)

    def hides(self, other: _Curve) -> bool:
        """Whether it would lie upon another, mark by mark."""
        if not self.can_hide(other) or [*self.jumps] != [*other.jumps]:
            return False
        return bool(self.agrees_with(other).all())

    def can_hide(self, other: _Curve) -> bool:
        """Whether it has the points of another."""
        plain = not (self.sort or self.of_crossings)
        return plain and np.array_equal(self.x, other.x)

    def agrees_with(self, other: _Curve) -> np.ndarray:
        """At which points it would lie upon another that has the same."""
        own, others = ((one.y, one.error, *one.ends) for one in (self, other))
        pairs = zip(own, others, strict=True)
        near = [np.isclose(a, b, rtol=UPON, atol=0.0, equal_nan=True) for a, b in pairs]
        return np.asarray(np.all([*near, self.open == other.open], axis=0))

    def only(self, part: np.ndarray) -> _Curve:
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


def _curves(
    layer: points.Layer,
    name: str,
    named: bool,
    of_panels: Mapping[str, points.Settings],
    sorts: Sequence[str],
    over: bool,
) -> list[_Curve]:
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
        return _by_sort(layer, array, words, x, dim, sorts)
    unsure = unknown_points(dataset, name, allow_undecided=True).broadcast_like(array)
    classes = dataset.get("attractor", dataset["status"]).broadcast_like(array)
    errors = _errors(dataset, array)
    numeric = [own for own in of_panels if own in dataset and not flag_names(dataset[own].attrs)]
    alike = [own for own in numeric if dataset[own].dims == array.dims and own != "share"]
    curves = []
    for line in points.lines(dataset, [dim], [str(d) for d in array.dims]):
        y, open_, told, error, *ends = (
            one.isel(line.index).values
            for one in (
                *(array, unsure & array.notnull(), classes, errors),
                *ends_of(dataset, name),
            )
        )
        y, error, ends = _narrowed(y, error, ends)
        apart = (told[1:] != told[:-1]) | _turns_back(x)
        for own in {name, *alike}:
            apart |= _leaves(dataset, own, line.index, of_panels[own])
        jumps = (np.flatnonzero(apart) + 1).tolist()
        told_by = {VARIABLE: words, DATASET: layer.label, **line.words}
        if over and not any(told_by.values()) and dataset.sizes.get("initial") == 1:
            told_by["initial"] = f"start: {dataset['initial'].item()}"
        limits = (0.0, 1.0) if name == "share" else (-np.inf, np.inf)
        curves.append(_Curve(told_by, x, y, open_, (ends[0], ends[1]), error, jumps, limits=limits))
    return curves


def _leaves(
    dataset: xr.Dataset, name: str, index: Mapping[str, int], settings: points.Settings
) -> np.ndarray:
    """Between which neighbours along a line a variable goes over to another motion."""
    array = numbers(dataset[name])
    fixed = {dim: at for dim, at in index.items() if dim != "initial"}  # of all starts
    y, starts = array.isel(index).values, array.isel(fixed)
    left = leaps.changes_over(
        y, starts.transpose(..., *array.isel(index).dims).values.reshape(-1, y.size)
    )
    if name == "share":  # which may step as it likes
        return left
    marks = [one.isel(index, missing_dims="ignore") for one in leaps.marks_of_motions(dataset)]
    kinds = leaps.told_apart(leaps.kinds(dataset).broadcast_like(array).isel(index).values, marks)
    logarithmic = points.is_logarithmic(settings, "y")
    return left | leaps.leaps(y, kinds, points.shown_of(settings, y), logarithmic)


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


def _of_branches(
    layer: points.Layer, name: str, axis: xr.DataArray, several: bool, beside_starts: bool
) -> list[_Curve]:
    """What branches along the abscissa tell of the variable, if there are any.

    Those of `several` datasets, or of one with a name of its own, are called by that, and by their
    start where nothing stands `beside_starts`: what of these leads there is not told by a branch.
    """
    curves, own = [], layer.label if several or layer.dataset.attrs.get("called") else ""
    for line, word, x, y in branch.told_of(layer.dataset, str(axis.name), name):
        sure = np.zeros(x.size, bool)
        look: dict[str, Any] = {"dash": branch.DASHES.get(word, "-"), "mark": {"marker": "None"}}
        what = x, y, sure, (y, y), np.zeros(x.size)
        kept = {dim: told for dim, told in line.words.items() if dim != "initial"}
        words = {DATASET: own, **(kept if beside_starts else line.words)}
        curves.append(_Curve(words, *what, **look, sort=f"{word} cycle"))
    return curves


def _without_axis(
    layer: points.Layer, name: str, first: xr.Dataset, axis: xr.DataArray
) -> list[_Curve]:
    """The values of a dataset that does not vary along the abscissa, each over all of it.

    One that differs from the first in its place there alone has that place.
    """
    array, x = numbers(layer.dataset[name]), points.positions(axis)
    at = np.array([x.min(), x.max()])
    if _is_at_one_place(layer.dataset, first, axis):
        at = layer.dataset[axis.name].values.reshape(1).astype(float)
    flat = [
        ({DATASET: layer.label, **line.words}, np.full(at.size, float(array.isel(line.index))))
        for line in points.lines(layer.dataset, [], [str(dim) for dim in array.dims])
    ]
    sure, mark = np.zeros(at.size, bool), {"marker": "None"} if at.size > 1 else PLACE
    return [
        _Curve(words, at, y, sure, (y, y), np.zeros(at.size), mark=mark)
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
    x: np.ndarray,
    dim: str,
    every: Sequence[str],
) -> list[_Curve]:
    """Lines of crossings of one sort: a colour for each or, where colours tell lines, a dash.

    Each of `every` sort looks the same in all datasets of a figure.
    """
    dataset = layer.dataset
    sorts, errors, modes = _sorts(dataset), _errors(dataset, array), modes_of(dataset, array)
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
            lines = joined(x, kept, mode)
            steps = [(x[at], x[at + 1]) for at in not_joined(kept, lines)]
            for place, places in enumerate(lines):
                at = tuple(np.array(places).T)
                unsure = np.zeros(len(places), bool)
                found = (x[at[0]], kept[at], unsure, (kept[at], kept[at]), error[at])
                dashed = {"dash": dash, "mark": mark, "sort": sort} if is_told else {}
                own = told_by if is_told else {"sort": sort}
                apart = tuple(steps) if not place else ()  # told once
                curves.append(_Curve(own, *found, **dashed, of_crossings=True, apart=apart))
    return curves


def _turns_back(x: np.ndarray) -> np.ndarray:
    """Between which neighbours an axis that others advance with stands still, or turns."""
    steps = np.diff(x)
    first: float = next(iter(steps[steps != 0.0]), 1.0)
    return steps * first <= 0.0


Place = tuple[int, int]
"""Numbers of a point and of a crossing there."""


def joined(x: np.ndarray, values: np.ndarray, modes: np.ndarray) -> list[list[Place]]:
    """Lines through crossings, shape (points, crossings), as places along them.

    Crossings of neighbours are joined as far as it can be told that they belong together.
    """
    rows = [
        [(point, int(i)) for i in np.argsort(row)[: np.isfinite(row).sum()]]
        for point, row in enumerate(values)
    ]
    lines: dict[Place, list[Place]] = {place: [place] for row in rows for place in row}
    for (before, after), apart in zip(pairwise(rows), _turns_back(x), strict=True):
        for one, other in [] if apart else _pairs(before, after, values, modes):
            lines[other] = lines[one]
            lines[one].append(other)
    distinct = {id(line): line for line in lines.values()}.values()
    return [piece for line in distinct for piece in _followed(line, x, values, modes)]


def not_joined(values: np.ndarray, lines: Sequence[Sequence[Place]]) -> list[int]:
    """Points between which and the next fewer lines lead than both have crossings."""
    counts = np.isfinite(values).sum(axis=1)
    led = np.zeros(counts.size - 1, int)
    for line in lines:
        led[[place for place, _ in line[:-1]]] += 1
    steps: list[int] = np.flatnonzero(np.minimum(counts[1:], counts[:-1]) > led).tolist()
    return steps


def broken(
    words: str, along: object, steps: Sequence[tuple[float, float]], x: np.ndarray
) -> Iterator[str]:
    """What to do where lines of crossings are not joined, from one place to the next of all x."""
    for step in steps[:MOST_STEPS]:
        ends = " and ".join(labels.number_text(one, x.tolist()) for one in step)
        yield (
            f"{words}: not joined between {along} = {ends}, where it steps by more than beside it; "
            f"if it is one line, more values of {along} in its case join it"
        )


def _pairs(
    before: list[Place], after: list[Place], values: np.ndarray, modes: np.ndarray
) -> list[tuple[Place, Place]]:
    """Which crossings of two neighbours may be one: of one mode, the others in order.

    All are in order where that is the shorter way: the numbers of modes differ then.
    """
    pairs = []
    for mode in {modes[place] for place in before}:
        own, its = ([p for p in row if modes[p] == mode] for row in (before, after))
        pairs += _nearest(own, its, values)
    if len(before) != len(after):
        return pairs
    left = ([p for p in row if p not in chain(*pairs)] for row in (before, after))
    pairs += zip(*left, strict=True)
    in_order = [*zip(before, after, strict=True)]
    return in_order if _way(pairs, values) > SHORTER * _way(in_order, values) else pairs


def _way(pairs: Sequence[tuple[Place, Place]], values: np.ndarray) -> float:
    return float(sum(abs(values[one] - values[other]) for one, other in pairs))


def _nearest(
    before: list[Place], after: list[Place], values: np.ndarray
) -> list[tuple[Place, Place]]:
    """In order where they are equally many, else those that are nearest to one another."""
    if len(before) == len(after) or not before or not after:
        return [*zip(before, after, strict=False)]
    apart = np.abs(np.subtract.outer([values[p] for p in before], [values[p] for p in after]))
    to, back = apart.argmin(axis=1).tolist(), apart.argmin(axis=0).tolist()
    return [(before[n], after[m]) for n, m in enumerate(to) if back[m] == n]


def _followed(
    line: list[Place], x: np.ndarray, values: np.ndarray, modes: np.ndarray
) -> list[list[Place]]:
    """The pieces of a line between steps that are large against those beside them.

    The more speaks for a step, the larger it may be: that as many crossings of the same mode lie
    at both its ends, and that the line goes on as it does.
    """
    at = tuple(np.array(line).T)
    steps, counts = np.diff(values[at]), np.isfinite(values).sum(axis=1)[at[0]]
    slopes = steps / np.diff(x[at[0]])
    alike = (np.diff(counts) == 0) & (np.diff(modes[at]) == 0)
    beside = np.stack([np.append(np.nan, slopes)[:-1], np.append(slopes, np.nan)[1:]])
    goes_on = (beside * slopes > 0.0).any(axis=0)
    room = np.take(ROOM, alike * 1 + goes_on) * np.nan_to_num(np.abs(beside)).max(axis=0)
    kept = (np.abs(slopes) <= room) | (alike & np.isnan(beside).all(axis=0))
    kept |= np.abs(steps) <= SMALL * (np.nanmax(values) - np.nanmin(values))
    cuts = [0, *(np.flatnonzero(~kept) + 1).tolist(), len(line)]
    return [line[begin:end] for begin, end in pairwise(cuts)]


def modes_of(dataset: xr.Dataset, array: xr.DataArray) -> xr.DataArray:
    """The mode of each crossing; one and the same where that means nothing."""
    return dataset["crossing_mode"] if "crossing_mode" in dataset else array * 0.0


def _errors(dataset: xr.Dataset, array: xr.DataArray) -> xr.DataArray:
    """How far each value may be off, infinite where it is not known; 0 for one that does not say.

    Of what is a mean of a sample it is the standard error; of what all of it show, or none, how far
    it may be off all the same.
    """
    name = str(array.name)
    if error_of(name) in dataset:
        known = dataset[error_of(name)].where(~_is_edge(dataset, name))
        return numbers(known).fillna(np.inf).broadcast_like(array)
    error = dataset.get(_standard_error(name), 0.0 * array)
    if "starts" in error.attrs:
        error = sampling_error(dataset)
    return error.broadcast_like(array)


def _is_edge(dataset: xr.Dataset, name: str) -> xr.DataArray:
    """Where the end of a branch is an edge of its bracket, beyond which it may go on."""
    kind = f"{name}_kind"
    return is_class(dataset.get(kind, dataset[name] * np.nan), ("bracket",))


def _of_edges(parts: Mapping[str, _Parts]) -> list[str]:
    """What to do about ends that are none, by the variables of a figure."""
    counts = {
        name: sum(int(_is_edge(one.dataset, name).sum()) for one in own.values())
        for name, own in parts.items()
    }
    return [
        f"{name}: {count} of them an edge of the bracket, beyond which it may go on: widen it"
        for name, count in counts.items()
        if count
    ]


def _standard_error(name: str) -> str:
    """What says how far the mean of a sample may be off, in a dataset that has it."""
    return ERROR if name == "share" else standard_error_of(name)


def _told_by_bars(dataset: xr.Dataset, name: str) -> str:
    """What the error bars of a variable tell if they are of a sample."""
    error = dataset.get(_standard_error(name))
    if error is None or not bool(error.notnull().any()):
        return ""
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


def _sorts(dataset: xr.Dataset) -> dict[str, xr.DataArray]:
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


def _name_values(ax: Axes, variables: Sequence[xr.DataArray]) -> None:
    """What stands beside the values: the name of one variable, the names of classes."""
    several = len(variables) > 1
    ax.set_ylabel(labels.shared_label(variables) if several else labels.axis_label(variables[0]))
    classes = {c: n for c, n in flag_names(variables[0].attrs).items() if n != NOT_COMPUTED}
    if classes:
        ax.set_yticks(list(classes), labels=[word.replace("_", " ") for word in classes.values()])
