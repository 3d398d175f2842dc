"""Lines over a bifurcation diagram: cycles and equilibria that motions do not show."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import reduce
from itertools import compress
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.lines import Line2D

from fiv_cli.errors import UsageError
from fiv_cli.flags import CYCLE_END, NOT_COMPUTED, SECTION
from fiv_cli.notation.names import listed
from fiv_cli.plots import branch, labels, points, smooth, style
from fiv_cli.plots.clouds import ALIKE, DEFAULT, SAME, observed_state
from fiv_cli.plots.drawn import DECORATION, leave_out
from fiv_cli.plots.mergers import GROWTH
from fiv_cli.plots.same_parameters import differing, of_the_same
from fiv_cli.plots.turns import up_to_turns
from fiv_cli.reading import select
from fiv_cli.reading.datasets import class_names, is_class, numbers

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes
    from matplotlib.typing import ColorType

# Of changes of cycles: full, since the hollow marks are those of starts.
CHANGE: dict[str, Any] = {"mec": "white", "mew": 0.4, "ms": 4.0, "ls": "none"}
CYCLE: dict[str, Any] = {"lw": 1.2, "zorder": 1.5}
LONE: dict[str, Any] = {"marker": "o", "ms": 2.5}  # a cycle that no line leads to
EQUILIBRIA = {"stable": ("-", 0.7), "unstable": (":", 1.1), "neutral": ("-.", 0.7)}
TURNS_HERE = "equilibrium turns stable or unstable"
BETWEEN = "read between points"
ROUNDING = 1e-9  # of the greatest: growth that is none
CRITICAL: dict[str, Any] = {
    "color": style.BLACK, "ls": "none", "marker": "D", "ms": 4.0, "mfc": "white", "mew": 0.9,
    "zorder": 5,
}  # fmt: skip
# Of critical values of lines that share a colour: "" has this one.
FILLS = ("white", "", style.GREY)
# How much larger marks are beneath others so near, in points, how near, of the whole axis, and
# beneath how many.
LARGER, UPON, MOST_UPON = 3.0, 0.012, 2
TURN: dict[str, Any] = {"marker": "|", "ms": 9.0, "mew": 1.6, "ls": "none", "zorder": 4.7}


def critical_values(dataset: xr.Dataset, axis: xr.DataArray) -> np.ndarray:
    """Where along an axis modes turn stable or unstable; none of what has other axes as well."""
    if not is_critical_along(dataset, axis):
        return np.zeros(0)
    others = [d for d, size in dataset["critical_value"].sizes.items() if size == 1]
    found = dataset["critical_value"].squeeze([d for d in others if d != "crossing"])
    if found.dims != ("crossing",):
        return np.zeros(0)
    return np.sort(found.dropna("crossing").values)


def is_critical_along(dataset: xr.Dataset, axis: xr.DataArray) -> bool:
    """Whether it holds critical values of an axis."""
    words = str(dataset.get("critical_value", axis).attrs.get("long_name", ""))
    return "critical_value" in dataset and words.endswith(f" of {axis.name}")


def mark_critical(
    ax: Axes,
    other: points.Layer,
    datasets: Sequence[xr.Dataset],
    axis: xr.DataArray,
    *,
    colours_tell: bool = True,
    of_largest: bool = False,
) -> None:
    """Where, at the parameters of each line, another dataset found that modes turn: at zero.

    They have the colour of their line or, where colours tell something else, each a fill; those
    `of_largest` growth are not of further modes that turn.

    Raises
    ------
    UsageError : it found nothing at these parameters
    """
    found = [pair for dataset in datasets for pair in _critical_of_lines(other, dataset, axis)]
    if not any(at.size for _, at, _ in found):
        differs = listed(differing(other.dataset, datasets[0])) if datasets else ""
        raise UsageError(
            f"{other.label}: no critical value of {axis.name} at parameters of this figure"
            f"{f' (of another {differs})' * bool(differs)}\n"
            f'next: an analysis `critical` with parameter = "{axis.name}", in a case of these '
            "parameters, finds it; or draw each file by itself"
        )
    words = f"critical value of {labels.quantity(axis, str(axis.name))}"
    drawn = style.own_axes(ax.figure.figure)  # the legend is that of all
    known = points.colours(drawn) if colours_tell and len(found) > 1 else {}
    own = [select.axis_of(one, str(axis.name)) for one in datasets if axis.name in one.coords]
    x = np.concatenate([*map(points.positions, own or [axis])])
    places = [every[is_largest] if of_largest else every for _, every, is_largest in found]
    lines = [label for label, *_ in found]
    looks = [*_looks_of_critical(lines, words, known)]
    coloured = len({look["color"] for _, look in looks}) > 1
    for number, (at, (told, look)) in enumerate(zip(places, looks, strict=True)):
        above = zip(places[number:], looks[number:], strict=True)
        near = sum(_is_near(at, one, UPON * np.ptp(x)) for one, its in above if its[1] != look)
        size = CRITICAL["ms"] + LARGER * min(near, MOST_UPON)
        if at.size:
            label = points.unlisted(lines[number], told) if coloured else told
            ax.plot(at, 0.0 * at, label=label, **CRITICAL | look | {"ms": size})
    for told, look in dict(looks).items() if coloured else ():
        fill = style.BLACK if look["mfc"] == look["color"] else look["mfc"]
        ax.plot([], [], label=told, **CRITICAL | {"mfc": fill})
    _tell_of_those_beyond(ax, np.concatenate(places), x, f"{words} at", str(axis.name))
    several = len({(label, *at.tolist()) for label, at in zip(lines, places, strict=True)}) > 1
    if several and len({str(look) for _, look in looks}) == 1:
        note = (
            f"{words}: one mark for those of {listed([*dict.fromkeys(lines)])}; of a single start "
            "(select in the figure) they have the colours of their lines"
        )
        style.add_notes(ax.figure.figure, [*{note} - {*style.notes_on(ax.figure.figure)}])


def _looks_of_critical(
    lines: Sequence[str], words: str, known: Mapping[str, ColorType]
) -> Iterator[tuple[str, dict[str, Any]]]:
    """How the critical values of each line are marked: in its colour and, of lines that share one,
    each with a fill; these have none of their own where there are more lines than fills."""
    colours = [next(iter(_colours_of(line, known)), style.BLACK) for line in lines]
    if len({*colours}) == 1:
        colours = [style.BLACK for _ in lines]  # dashes, say, tell them
    pairs = [*zip(lines, colours, strict=True)]
    fills = [
        [*dict.fromkeys(one for one, its in pairs if its == colour)].index(line)
        for line, colour in pairs
    ]  # lines of several files that are called alike have one
    shared = {fill: _of_all([*compress(lines, np.equal(fills, fill))]) for fill in fills}
    if max(fills) >= len(FILLS) or not all(shared.values()):
        fills = [0 for _ in lines]
    for colour, fill in zip(colours, fills, strict=True):
        # beside one another, of the abscissa, they are short enough for a line each
        told = f"{words.partition(' of ')[0]}: {shared[fill]}" if any(fills) else words
        yield told, {"color": colour, "mfc": FILLS[fill] or colour}


def _of_all(names: Sequence[str]) -> str:
    """The words that all of some names have."""
    first, *others = (name.split(", ") for name in names)
    return ", ".join(word for word in first if all(word in one for one in others))


def _tell_of_those_beyond(
    ax: Axes, marked: np.ndarray, x: np.ndarray, words: str, axis: str
) -> None:
    """Note which places lie beyond the points along an axis."""
    beyond = np.unique(marked[(marked < x.min()) | (marked > x.max())])
    if beyond.size:
        told = listed([labels.number_text(value, beyond.tolist()) for value in beyond])
        note = f"{words} {told}: beyond the lines, which a wider {axis} in their case leads on"
        style.add_notes(ax.figure.figure, [*{note} - {*style.notes_on(ax.figure.figure)}])


def _is_near(places: np.ndarray, others: np.ndarray, distance: float) -> bool:
    """Whether some of them lie next to one another."""
    return bool((np.abs(places[:, None] - others) < distance).any())


def _colours_of(label: str, known: Mapping[str, ColorType]) -> list[ColorType]:
    """The colour of the lines that have all words of a label, or that tells some of them."""
    words = {*label.split(", ")} - {""}
    told = [({*name.split(", ")}, of) for name, of in known.items()]
    whole = [of for own, of in told if words and words <= own]
    return [*whole, *(of for own, of in told if own <= words and of != style.BLACK)][:1]


def _critical_of_lines(
    other: points.Layer, dataset: xr.Dataset, axis: xr.DataArray
) -> Iterator[tuple[str, np.ndarray, np.ndarray]]:
    """What each line of a dataset along an axis is called, its critical values, and which of them
    are of its largest growth."""
    along = [str(axis.dims[0]), "initial"]
    for line in points.lines(dataset, along, points.grid_dims(dataset)):
        own = dataset.isel(line.index)
        parts = [of_the_same(one, own) for one in (other.dataset, *other.beside)]
        met = [critical_values(_of_roots(part), axis) for part in parts if part is not None]
        values = np.unique(np.concatenate([np.zeros(0), *met]))
        yield line.label, values, _turns_here(values, own, axis)


def _of_roots(critical: xr.Dataset) -> xr.Dataset:
    """Without where an equilibrium begins or ends, at which its growth is not zero."""
    if "crossing_kind" not in critical:
        return critical
    found = critical["critical_value"].where(~is_class(critical["crossing_kind"], ("end",)))
    return critical.assign(critical_value=found)


def _turns_here(values: np.ndarray, line: xr.Dataset, axis: xr.DataArray) -> np.ndarray:
    """Beside which values along an axis the growth rate of a line is not positive throughout, as
    far as it is known."""
    if GROWTH not in line:
        return np.ones(values.shape, bool)
    growth = line[GROWTH].max([dim for dim in line[GROWTH].dims if dim not in axis.dims]).values
    order = np.argsort(points.positions(axis))
    after = np.searchsorted(points.positions(axis)[order], values)
    beside = growth[order][np.clip([after - 1, after], 0, order.size - 1)]
    least = np.fmin.reduce(beside)
    return np.asarray(~(least > ROUNDING * np.fmax.reduce(np.abs(growth))))


def _changes_along(
    line: xr.Dataset, others: Sequence[xr.Dataset], axis: xr.DataArray, observed: str
) -> np.ndarray:
    """Where along an axis the equilibria of a line of a diagram change, as another analysis found.

    That is a critical value or, where there is none, at which a cycle shrinks to one of them.
    """
    same = (of_the_same(one, line) for one in others)
    parts = [part for part in same if part is not None]
    found = [critical_values(part, axis) for part in parts]
    found += [
        branch.births(part) for part in parts if branch.is_along(part, str(axis.name), observed)
    ]
    return next((changes for changes in found if changes.size), np.zeros(0))


def draw_cycles(
    ax: Axes,
    datasets: Sequence[xr.Dataset],
    axis: xr.DataArray,
    layer: points.Layer,
    name: str,
) -> set[str]:
    """Every cycle along `axis`, in the colour of its diagram: what it passes at the section.

    Of a cycle that is not known there the least and the greatest, and only if it is not stable: the
    marks of a stable one lie elsewhere. Tells which of both sorts are not drawn as on the section.
    """
    unmet, drawn = set[str](), dict[tuple[str, str], list[tuple[np.ndarray, np.ndarray]]]()
    observed = observed_state(layer.dataset[name])
    extremes = f" cycle: extremes of ${labels.symbol_of_name(observed)}$"
    colours = points.colours([ax])
    for dataset in datasets:
        at_section = name == DEFAULT and _of_one_section(dataset, layer.dataset)
        for own, (word, x, heights, passes) in _cycles(dataset, axis, observed, at_section):
            unmet |= {word} & {*branch.DASHES} if name == DEFAULT and not passes else set()
            if word not in branch.DASHES or (word == "stable" and not passes):
                continue
            told = f"{word}{' cycle' if passes else extremes}"
            place, colour = _whose(layer, own, axis, colours)
            alike = drawn.setdefault((told, place), [])
            before = [*alike]  # of other files, or parts of this
            for height in heights:
                shown = _beside(x, height, before)
                alike.append((x, height))
                if np.isfinite(shown).any():
                    _draw_cycle(ax, x, shown, word, (place, told), colour)
        tells = "cycle_end_kind" in dataset and branch.is_along(dataset, str(axis.name), observed)
        if at_section and tells:
            _mark_changes(ax, dataset, axis, layer, colours)
    return unmet


def _beside(
    x: np.ndarray, height: np.ndarray, drawn: Sequence[tuple[np.ndarray, np.ndarray]]
) -> np.ndarray:
    """The heights of a line that is not drawn yet, NaN where one that is leads through its points:
    the dashes of both would fill each other's gaps.

    Where lines only meet, or one begins on another, none of it is left out.
    """
    for its_x, its_height in drawn:
        again = _is_upon((x, height), (its_x, its_height))
        own = np.pad(~again & np.isfinite(height), 1)
        height = np.where(again & ~own[:-2] & ~own[2:], np.nan, height)
    return height


def _is_upon(
    line: tuple[np.ndarray, np.ndarray], other: tuple[np.ndarray, np.ndarray]
) -> np.ndarray:
    """At which points a line lies upon another, of whatever points."""
    own, its = (np.column_stack(of) for of in (line, other))
    known, there = (np.isfinite(of).all(axis=1) for of in (own, its))
    upon = np.zeros(known.size, bool)
    if known.any() and there.sum() > 1:
        both = np.vstack([own[known], its[there]])
        upon[known] = branch.off_line(own[known], its[there], both) < branch.UPON
    return upon


def _draw_cycle(
    ax: Axes,
    x: np.ndarray,
    height: np.ndarray,
    word: str,
    called: tuple[str, str],
    colour: ColorType,
) -> None:
    """A line and, where none leads, a dot; each is in the legend by what it is `called` last."""
    alone, dashes = points.alone(np.isfinite(height)), branch.DASHES[word]
    smooth.draw(ax, x, height, points.unlisted(*called), color=colour, ls=dashes, **CYCLE)
    entry = next((line for line in ax.lines if line.get_label() == called[-1]), None)
    if entry is None:
        (entry,) = ax.plot([], [], color=style.BLACK, label=called[-1], **CYCLE, ls="none")
    if np.isfinite(height[~alone]).any():
        entry.set(ls=dashes)
    if alone.any():
        entry.set(**LONE, mfc=style.BLACK if word == "stable" else "none")
        look = {**LONE, "mfc": colour if word == "stable" else "none", "ls": "none"}
        ax.plot(x[alone], height[alone], color=colour, label=DECORATION, **look)


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
    sections = sections_of(dataset, "cycle")
    return len(sections) == 1 and sections == sections_of(diagram, "response")


def sections_of(dataset: xr.Dataset, kind: str) -> set[tuple[object, ...]]:
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


@dataclass(frozen=True)
class Equilibria:
    """The heights of a diagram's equilibria by their word of `EQUILIBRIA`, NaN of other words, and
    the largest growth rate of each."""

    called: Mapping[str, xr.DataArray]
    growth: xr.DataArray

    @property
    def every(self) -> xr.DataArray:
        """The heights of all."""
        return reduce(lambda one, other: one.fillna(other), self.called.values())


def equilibria_of(
    layer: points.Layer,
    shown: Sequence[points.Layer],
    others: Sequence[xr.Dataset],
    axis: xr.DataArray,
    observed: str,
) -> Equilibria:
    """The equilibria of a diagram, but for those of another that is `shown`.

    What tells whether they are stable, along `axis`, is of the diagram's case or one of the others:
    first of those that have it at the places where the equilibria are known.
    """
    diagram = layer.dataset
    nowhere = diagram["status"] * np.nan
    parts = [(one, _on_axes_of(diagram, one)) for one in (*layer.beside, *others)]
    name = str(axis.name)
    same = [(one, own) for one, own in parts if own is not None and select.has_axis(own, name)]
    taken = {id(d) for one in shown if one is not layer for d in (one.dataset, *one.beside)}
    free = [own for one, own in same if id(one) not in taken]
    pairs = [
        (judged, place, judged[name].variable.equals(place[name].variable))
        for judged in (own for _, own in same if {"stable", "growth_rate"} <= {*own})
        for place in _heights(diagram, free, observed, _linearised_at(judged))
    ]
    pairs = [one for one in pairs if one[2] or any(one[0] is own for own in free)]
    if not pairs:
        return Equilibria(dict.fromkeys(EQUILIBRIA, nowhere), nowhere)
    # at the same places, and these the most; of the best the first
    judged, place, _ = max(pairs, key=lambda one: (one[2], one[1][name].size))
    called = {word: place.where(is_class(judged["stable"], (word,))) for word in EQUILIBRIA}
    growth = judged["growth_rate"].where(place.notnull()).reindex_like(place)  # of another grid
    return Equilibria({word: here.reindex_like(place) for word, here in called.items()}, growth)


def _on_axes_of(diagram: xr.Dataset, dataset: xr.Dataset) -> xr.Dataset | None:
    """The part of a dataset at the same parameters, if it has no further axes but of one value."""
    part = of_the_same(dataset, diagram)
    if part is None:
        return None
    further = [d for d in part["status"].dims if d not in diagram.dims]
    is_one = all(part.sizes[d] == 1 for d in further)
    return part.isel(dict.fromkeys(further, 0)) if is_one else None


def _heights(
    diagram: xr.Dataset, beside: Sequence[xr.Dataset], observed: str, number: int
) -> Iterator[xr.DataArray]:
    """Those of an equilibrium: what L_s is measured from, and what `equilibrium` analyses found."""
    if "L_s_reference" in diagram and observed in diagram["state"]:
        known = diagram["L_s_reference"].where(diagram["L_s_reference_index"] == number)
        yield known.sel(state=observed).max([dim for dim in known.dims if dim == "initial"])
    for one in beside:
        if "equilibrium" in one and observed in one["state"] and number <= one.sizes["solution"]:
            yield one["equilibrium"].isel(solution=number - 1).sel(state=observed)


def draw_equilibria(
    ax: Axes,
    layer: points.Layer,
    equilibria: Equilibria,
    others: Sequence[xr.Dataset],
    axis: xr.DataArray,
    observed: str,
) -> tuple[list[Line2D], bool]:
    """Equilibria of a diagram, by what the eigenvalues of its case tell of them, up to where they
    change, as its case or `others` know or, where none does, where growth rates are zero.

    Those of several diagrams, or at several values of other axes, have the colours of these.
    Returned are marks where they turn unstable, not drawn yet, and whether some are one line.
    """
    every, turns, shares = equilibria.every, [], False
    of_case = every.to_dataset(name="height")  # of the one that has them, maybe another
    axis = select.axis_of(of_case, str(axis.name))
    dim, x = str(axis.dims[0]), points.positions(axis)
    lines = points.lines(of_case, [dim, "initial"], [str(d) for d in every.dims])
    of_lines = [of_the_same(layer.dataset, of_case.isel(line.index)) for line in lines]
    changes_of = [
        np.zeros(0) if own is None
        else _changes_along(own, (*layer.beside, *others), axis, observed)
        for own in of_lines
    ]  # fmt: skip
    colours = points.colours([ax]) if len(lines) > 1 or layer.label else {}
    known_words = {str(line.get_label()) for line in ax.lines}
    for word, height in equilibria.called.items():
        dashes, weight = EQUILIBRIA[word]
        of_word = every, height, equilibria.growth
        parts = [[of.isel(line.index).values for of in of_word] for line in lines]
        drawn = [
            (points.joined(layer.label, line.label), *up_to_turns(changes, x, every, own, growth))
            for line, (every, own, growth), changes in zip(lines, parts, changes_of, strict=True)
            if np.isfinite(own).any()
        ]
        called = f"{word} equilibrium"
        for label, places, values, met, known in drawn:
            own = points.unlisted(label, called) if colours else called
            colour = next(iter(_colours_of(label, colours)), style.BLACK)
            (line,) = ax.plot(places, values, dashes, lw=weight, zorder=3.5,
                              color=colour, label=own)  # fmt: skip
            leave_out(line, met[~known])
            shares |= _blacken_shared(ax, line)
            for part, how in ((known, ""), (~known, BETWEEN)) if word == "unstable" else ():
                told = points.unlisted(label, how, TURNS_HERE)
                turns.append(Line2D(*met[part].T, color=line.get_color(), label=told))
        if colours and drawn and called not in known_words:
            ax.plot([], [], dashes, lw=weight, color=style.BLACK, label=called)
    return turns, shares


def mark_turns(ax: Axes, turns: Sequence[Line2D], shared: bool) -> None:
    """Where equilibria turn stable or unstable: what was read between points, or has the mark of a
    cycle that ends there, is seen only where some are a `shared` line, which tells of none."""
    marked = [of.get_xdata() for of in ax.lines if of.get_marker() == branch.MARKS["equilibrium"]]
    ends = np.concatenate([np.zeros(0), *marked])
    is_any = False
    for one in turns:
        places = np.array(one.get_data(), float)
        apart = np.abs(np.subtract.outer(places[0], ends)).min(axis=1, initial=np.inf)
        told = (apart <= branch.UPON * np.ptp(ax.get_xlim())) | (BETWEEN in str(one.get_label()))
        for part, visible in ((~told, True), (told, shared)):
            if part.any():
                look = {**TURN, "color": one.get_color(), "label": one.get_label()}
                ax.plot(*places[:, part], visible=visible, **look)
                is_any |= visible
    if is_any:
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
