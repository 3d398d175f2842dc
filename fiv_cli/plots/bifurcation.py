"""Bifurcation diagram: what the motion passes at the Poincaré section, against a parameter.

Where a motion rests it is drawn at its value. What no motion comes to, as all that is unstable,
other analyses of the case know: equilibria an `eigenvalues` analysis, cycles a `cycle` analysis, or
the dataset of a branch that is drawn with it; where equilibria turn stable a `critical` one, else
it is read between the points of the grid.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.lines import Line2D

from fiv_cli.errors import EmptyFigureError, UsageError
from fiv_cli.flags import SECTION
from fiv_cli.plots import branch, labels, legends, points, style
from fiv_cli.plots.cloud_marks import mark_clouds
from fiv_cli.plots.clouds import DEFAULT, clouds_of, observed_state, places_of, shared_apart
from fiv_cli.plots.diagram_lines import (
    Equilibria,
    draw_cycles,
    draw_equilibria,
    equilibria_of,
    is_critical_along,
    mark_turns,
    sections_of,
)
from fiv_cli.plots.drawn import UNNAMED
from fiv_cli.plots.same_parameters import of_the_same
from fiv_cli.reading.datasets import numbers

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

UNMET = {
    "stable": "are not drawn",
    "unstable": "are drawn by their extremes, which meet no line of the section's values",
}
HAVING = (
    "{} cycles on another section, or that never meet it, {}; one for all, such as "
    'section = {{ zero = "{}_dot" }} in the cases of cycles and diagram, has them'
)
UNJUDGED = (
    "equilibria, and where they turn, are not drawn, since nothing tells which are stable: add an "
    "analysis `eigenvalues` to the case of the diagram"
)
BEYOND = 0.05  # of its length: what is seen beyond an axis
SECTION_WORDS = {
    "slip_to_stick": r"slip $\to$ stick",
    "stick_to_slip": r"stick $\to$ slip",
    "turning_point": "a turning point",
    "impact": "an impact",
}
PASSING = {"up": "rising through 0", "down": "falling through 0", "both": "= 0"}


def suits(dataset: xr.Dataset) -> bool:
    """Whether the dataset holds section values along some axis; a branch is another figure."""
    along_axes = DEFAULT in dataset and bool(points.varying_axes(dataset))
    return along_axes and not branch.suits(dataset)


def draw(layers: Sequence[points.Layer], settings: points.Settings) -> Figure:
    """Marks of every layer, one sort for each start or further axis, and lines of cycles."""
    name = points.one_variable(settings, DEFAULT)
    shown = _diagrams(layers, name)
    first = shown[0].dataset
    others = [one for layer in layers for one in (layer.dataset, *layer.beside)]
    axis, observed = points.abscissa(first, settings), observed_state(first[name])
    equilibria = [equilibria_of(layer, shown, others, axis, observed) for layer in shown]
    found = [
        cloud
        for layer, lines in zip(shown, equilibria, strict=True)
        for cloud in shared_apart([*clouds_of(layer, name, lines.every, settings)])
    ]
    clouds = [cloud for cloud in found if cloud.y.size or cloud.rest_y.size]
    points.refuse_empty(first, bool(clouds), name)
    figure, (ax,) = style.new_panels(1, 1, points.title(*(one.dataset for one in shown)))
    _refuse_of_none(layers, shown)
    for layer in layers:
        if not any(layer.dataset is one.dataset for one in shown):
            _refuse_apart(layer, shown, axis, observed)
    before = len(ax.lines)
    columns = axis.size if not first.attrs.get("partial") else places_of(clouds).size
    mark_clouds(ax, clouds, columns, figure.get_figwidth(), settings)
    marks = ax.lines[before:]
    along = [one for one in others if branch.is_along(one, str(axis.name), observed)]
    framed = _as_the_grid(settings, axis, along)
    unmet = _draw_all_cycles(ax, shown, others, axis, name)
    _draw_all_equilibria(ax, shown, equilibria, others, axis, observed)
    words = _section_words(shown) if any(cloud.y.size for cloud in clouds) else "rest"
    ax.set_ylabel(labels.axis_label(first[name]).replace("the section", words))
    others_at = _mark_other_sections(ax, [layer.dataset for layer in shown], framed)
    sorts = [cloud.family or cloud.label for cloud in clouds]
    notes = [*_of_other_sections(others_at, axis, observed), *points.of_many_lines(sorts)]
    notes += [*dict.fromkeys(_held_where_points_vary(first, axis, along))]
    is_unjudged = any("equilibrium" in one for one in others) and not any(
        {"stable", "growth_rate"} <= {*one} for one in others
    )
    is_unjudged |= any(is_critical_along(one, axis) for one in others) and not any(
        bool(lines.every.notnull().any()) for lines in equilibria
    )
    notes += [HAVING.format(word, UNMET[word], observed) for word in sorted(unmet & {*UNMET})]
    style.add_notes(figure, [*notes, *[UNJUDGED] * is_unjudged])
    if not clouds[0].label:
        _name_marks(ax, marks, first)
    points.dress([ax], shown, [framed])
    if "xlim" not in settings:
        style.add_notes(figure, [*_beyond(ax, along)])
    return figure


def _held_where_points_vary(
    diagram: xr.Dataset, axis: xr.DataArray, branches: Sequence[xr.Dataset]
) -> Iterator[str]:
    """What branches hold fixed and the points of a diagram vary together with its axis."""
    together = [n for n, one in diagram.coords.items() if one.dims == axis.dims and n != axis.name]
    for name, one in itertools.product(together, branches):
        if name in one.coords and not one[name].ndim and one[name].dtype.kind == "f":
            held = labels.value_label(one[name], one[name].item())
            yield f"branches are those at {held}, which the points vary with {axis.name}"


def _diagrams(layers: Sequence[points.Layer], name: str) -> list[points.Layer]:
    """The layers whose motions are marked, or cycles where there are none; the only one needs no
    label.

    Raises
    ------
    UsageError : none has values at a section
    """
    holding = [layer for layer in layers if name in layer.dataset]
    no_branches = [layer for layer in holding if not branch.suits(layer.dataset)]
    motions = [layer for layer in no_branches if "attractor" in layer.dataset]
    shown = motions or no_branches or holding
    if not shown:
        raise UsageError(
            f"{name}: no values at a section in this dataset (or part of one)\n"
            "a bifurcation diagram needs a response analysis; draw another variable as a curve"
        )
    return shown if len(shown) > 1 else [replace(shown[0], label="")]


def _draw_all_cycles(
    ax: Axes,
    shown: Sequence[points.Layer],
    others: Sequence[xr.Dataset],
    axis: xr.DataArray,
    name: str,
) -> set[str]:
    """Draw the cycles of every diagram; which sorts are not drawn as on the section.

    A dataset that belongs to several diagrams is drawn with the first of them.
    """
    unmet = set[str]()
    for layer in shown:
        parts = [of_the_same(one, layer.dataset) for one in others]
        own = [part for part in parts if part is not None]
        others = [one for one, part in zip(others, parts, strict=True) if part is None]
        unmet |= draw_cycles(ax, own, axis, layer, name)
    return unmet


def _draw_all_equilibria(
    ax: Axes,
    shown: Sequence[points.Layer],
    equilibria: Sequence[Equilibria],
    others: Sequence[xr.Dataset],
    axis: xr.DataArray,
    observed: str,
) -> None:
    """Draw the equilibria of every diagram, with marks where they turn, as another analysis found.

    What is read between points the dashes alone tell, and a table; where some are one line, marks.
    """
    drawn = [
        draw_equilibria(ax, layer, lines, others, axis, observed)
        for layer, lines in zip(shown, equilibria, strict=True)
    ]
    turns = [turn for turns, _ in drawn for turn in turns]
    mark_turns(ax, turns, any(shares for _, shares in drawn))


def _name_marks(ax: Axes, marks: Sequence[Line2D], diagram: xr.Dataset) -> None:
    """Give the only marks of a diagram their name, in a legend if there is one anyway."""
    _name_alone(marks, _start_of(diagram))
    if legends.told_in([ax])[1] or points.gaps(diagram) or points.ended(diagram):
        marks[0].set_label(_start_of(diagram))


def _name_alone(lines: Sequence[Line2D], name: str) -> None:
    """Give what has no name in a table the name of all of them."""
    for line in lines:
        if str(line.get_label()) == "_" or str(line.get_label()).startswith(UNNAMED):
            line.set_label(points.unlisted(name))


def _start_of(diagram: xr.Dataset) -> str:
    """What the only dots of a diagram are called."""
    alone = diagram.sizes.get("initial", 1) == 1 and "initial" in diagram.coords
    return f"start: {diagram['initial'].item()}" if alone else "section values"


def _mark_other_sections(
    ax: Axes, datasets: Sequence[xr.Dataset], settings: points.Settings
) -> list[tuple[float, float]]:
    """A line across where the section that motions choose changes, half-way between neighbours:
    values jump there with it."""
    places = sorted({step for one in datasets for step in _other_sections(one, settings)})
    for number, ends in enumerate(places):
        label = points.unlisted("another section") if number else "another section"
        ax.axvline(0.5 * sum(ends), color=style.GREY, ls=":", lw=1.0, zorder=1, label=label)
    return places


def _of_other_sections(
    places: Sequence[tuple[float, float]], axis: xr.DataArray, observed: str
) -> list[str]:
    """What to ask for where values of other sections stand side by side."""
    if not places:
        return []
    shown = ", ".join(f"{low:.4g} and {high:.4g}" for low, high in places[:3])
    where = f"{shown}{', ...' * (len(places) > 3)}"
    zero = "STATE" if observed.endswith("_dot") else f"{observed}_dot"
    one = f'section = {{ zero = "{zero}" }} in the analysis, say, is one for all'
    return [f"the section changes between {axis.name} = {where}, and values jump there; {one}"]


def _other_sections(
    dataset: xr.Dataset, settings: points.Settings
) -> Iterator[tuple[float, float]]:
    """Neighbours along the axis whose motions have different sections, from low to high."""
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
                yield min(x[one], x[other]), max(x[one], x[other])


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


def _beyond(ax: Axes, branches: Sequence[xr.Dataset]) -> Iterator[str]:
    """What to do where branches lead on beyond the frame."""
    reached = np.concatenate([np.zeros(0), *(one[branch.ALONG].values for one in branches)])
    (low, high), least = sorted(ax.get_xlim()), 0.0 if ax.get_xscale() == "log" else -np.inf
    ends = reached[np.isfinite(reached) & (reached > least)]
    if ends.size and (ends.min() < low or high < ends.max()):
        first, last = min(low, ends.min()), max(high, ends.max())
        yield (
            f"a branch leads on from {ends.min():.6g} to {ends.max():.6g}, beyond the frame; "
            f"xlim = [{_outward(first, np.floor):.6g}, {_outward(last, np.ceil):.6g}] in the "
            "figure shows it all"
        )


def _outward(value: float, to: Callable[[float], float]) -> float:
    """A limit in few digits that is no further inside."""
    digit = 10.0 ** (np.floor(np.log10(abs(value) or 1.0)) - 2.0)
    return float(to(value / digit) * digit)


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
            "at the same parameters, along the same axis, answers of `cycle`, `eigenvalues` or "
            "`critical`"
        )


def _has_part(dataset: xr.Dataset, axis: xr.DataArray, observed: str) -> bool:
    """Whether there are cycles or eigenvalues along an axis of diagrams."""
    told = "cycle_period" in dataset or {"stable", "growth_rate"} <= {*dataset}
    is_along = axis.name in dataset.coords and told
    is_along |= is_critical_along(dataset, axis)
    return is_along or branch.is_along(dataset, str(axis.name), observed)


def _section_words(shown: Sequence[points.Layer]) -> str:
    """The section of all diagrams, as an axis is called by it; "the section" where it has no words.

    Of a model of several contacts it is told which.
    """
    sections = {one for layer in shown for one in sections_of(layer.dataset, "response")}
    kind, contact, *of = next(iter(sections)) if len(sections) == 1 else ("", 1)
    if kind == "zero":
        return f"${labels.symbol_of_name(str(contact))}$ {PASSING[str(of[0])]}"
    if kind not in SECTION_WORDS:
        return "the section"
    several = any(layer.dataset.sizes.get("contact", 1) > 1 for layer in shown)
    return f"{SECTION_WORDS[kind]}{f' of contact {contact:g}' if several else ''}"
