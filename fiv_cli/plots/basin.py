"""Basins: the starts of the motions over two of their components, coloured by what they reach.

The share of the starts that reach a class estimates the volume of its basin. Of starts drawn at
random, not of others, its standard error is sqrt(p (1 - p) / n) (Menck et al., Nature Physics 9
(2013) 89).
"""

from __future__ import annotations

import re
from collections.abc import Collection, Mapping, Sequence
from dataclasses import replace
from itertools import chain, cycle
from typing import TYPE_CHECKING, Any

import numpy as np
import xarray as xr
from matplotlib.collections import PolyCollection

from fiv_cli.errors import UsageError
from fiv_cli.flags import NOT_COMPUTED
from fiv_cli.notation.amounts import with_error
from fiv_cli.plots import drawn, labels, legends, motion, phase, points, style
from fiv_cli.plots import map as map_
from fiv_cli.plots.same_parameters import differing, held_words, of_the_same
from fiv_cli.reading import shares
from fiv_cli.reading.cycles import number_of_each, size_of_cycles, tolerance
from fiv_cli.reading.datasets import class_names, flag_names, is_class

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

STARTS = "initial_state"
FEWEST = 10  # starts that make a figure of their own
SHARE = 26  # letters of a share and its class
SEAM = 0.2  # pt, around a cell, so that none is seen
DENSE = 4.0  # of the size of a mark: a cell of a lattice that is smaller is filled
MANY = 400  # starts on a lattice, of which marks would be stripes in a flat panel
CORNERS = ((-1, -1), (1, -1), (1, 1), (-1, 1))  # of a cell
STAR = 8.0  # size of the mark of an equilibrium, pt
NUMBER = re.compile(r"\d")  # no class has one in its name, but in words of one's own
SAME = 1e-6  # of the greatest: places of rest that differ by less are one
# Marks of cycles where there are several, and their colours, which only what diverged, or lost
# contact, may have beside them.
OF_CYCLES = {"o": style.ORANGE, "^": style.BLACK, "D": style.PURPLE, "s": style.BLUE}
MARKS = (".", "o", "s", "^", "D", "x", "P", "v")  # of the classes, in the order of their codes


def suits(dataset: xr.Dataset) -> bool:
    """Whether the dataset holds many starts, and what they reach."""
    if STARTS not in dataset or "attractor" not in dataset:
        return False
    starts = _of_starts(dataset)
    return starts.sizes["initial"] >= FEWEST and len(_varying(starts)) >= 2


def draw(layers: Sequence[points.Layer], settings: points.Settings) -> Figure:
    """A panel for each value of the other axes, with the shares of the classes above it.

    Those of a single panel stand in the legend. Motions of further datasets lie over it.
    """
    first, *others = layers
    dataset = _of_starts(first.dataset)
    names = _components(dataset, settings)
    known = is_class(dataset["status"], ("ok", "budget"))
    points.refuse_empty(dataset, bool(known.any()), "attractor")
    panels = points.lines(dataset, ["initial"], points.grid_dims(dataset))
    map_.refuse_many(panels, dataset["attractor"], ["initial"])
    words = "\n".join(filter(None, (points.title(dataset), map_.how_run(dataset))))
    figure, axes, columns = style.grid_of_panels(
        len(panels), map_.MOST_COLUMNS, words, SHARE, sharex=True, sharey=True
    )
    single = len(panels) == 1
    parts = [dataset.isel(panel.index) for panel in panels]
    reached = [_motions(part, single) for part in parts]
    looks = _looks(dataset, {name for one in reached for name in one})
    for number, (ax, panel, own) in enumerate(zip(axes, panels, reached, strict=False)):
        shares_of = _shares(own, _is_sample(dataset))
        _scatter(ax, parts[number], own, names, looks, shares_of if single else {})
        heading = [] if single else [*_told(shares_of).values()]
        ax.set_title("\n".join(filter(None, (panel.label, *heading))))
        ax.set_label(panel.label)  # of the table
        ax.set_xlabel(_label(dataset, names[0]))
        ax.tick_params(labelbottom=True)
        ax.set_ylabel(_label(dataset, names[1]) if number % columns == 0 else "")
        points.scale(ax, settings)
    _lay_over(axes, parts, others, names, settings)
    rows = -(-len(panels) // columns)
    style.make_room(figure, rows * max(ax.get_title().count("\n") for ax in axes))
    error = " ± standard error" if _is_sample(dataset) else ""
    of_starts = f"shares of the starts{'' if single else ' above each panel'}{error}"
    if not single and any("cycle" in name for name in looks):
        of_starts += "; cycles by size"
    legends.legend_below(figure, legends.told_in(axes)[0], of_starts)
    return figure


def _of_starts(dataset: xr.Dataset) -> xr.Dataset:
    """With every point of a lattice of starts (axes ``initial.x``) as a start of its own."""
    axes = [dim for dim in points.grid_dims(dataset) if dim.startswith("initial_")]
    if not axes or STARTS not in dataset or len(_varying(dataset)) >= 2:
        return dataset
    placed = dataset.assign({STARTS: _places(dataset, axes)})
    stacked = placed.stack(start=[*axes, "initial"], create_index=False)
    return stacked.swap_dims(start="initial").transpose(..., "state", "initial")


def _places(dataset: xr.Dataset, axes: Sequence[str]) -> xr.DataArray:
    """Where each start is; one that was filled in stands where its axes, off a rest, have it."""
    starts = dataset[STARTS]
    along = xr.zeros_like(starts)
    for dim in axes:
        along += dataset[dim] * (dataset["state"] == dim.removeprefix("initial_"))
    rest = (starts - along).max(axes)
    others = [dim for dim in rest.dims if dim not in ("state", "initial")]
    alike = rest.max(others).where(rest.max(others) == rest.min(others))
    return starts.fillna(along + rest.fillna(alike))  # of a plane of which no point was run


def _varying(dataset: xr.Dataset) -> list[str]:
    """The components in which the starts of some point differ."""
    starts = dataset[STARTS]
    spread = starts.max("initial") - starts.min("initial")
    differ = (spread > 0.0).any([dim for dim in spread.dims if dim != "state"])
    names = [str(name) for name in dataset["state"].values]
    return [name for name, does in zip(names, differ.values, strict=True) if does]


def _components(dataset: xr.Dataset, settings: points.Settings) -> tuple[str, str]:
    """The components to draw: as the figure says, else a state and its velocity if both vary.

    Raises
    ------
    UsageError : what starts reach is not in the dataset, or it has no such state
    """
    if not {STARTS, "attractor"} <= {*dataset}:
        raise UsageError(
            "no starts in this dataset with what each reaches, of which basins are drawn\n"
            "next: a case with an analysis of kind `response` and an [[initial]] of many starts"
        )
    known, free = [str(name) for name in dataset["state"].values], _varying(dataset)
    asked = {key: str(settings.get(key, "")).removeprefix("initial.") for key in ("x", "y")}
    for which, name in asked.items():
        if name and name not in known:
            raise UsageError(f"{which} = {name}: no state\nthe states are: {', '.join(known)}")
    if len(free) < 2 and not {"x", "y"} <= set(settings):
        raise UsageError(
            "the starts differ in fewer than two components\n"
            "next: draw a curve, or give [[initial]] a box in two states"
        )
    x = asked["x"] or [*free, *known][0]
    others = (name for name in free if name != x)
    partner = f"{x}_dot" if f"{x}_dot" in free else next(others, x)
    return x, asked["y"] or partner


def _label(dataset: xr.Dataset, name: str) -> str:
    unit = labels.unit_text(str(dataset["state_units"].sel(state=name).values))
    return f"initial ${labels.symbol_of_name(name)}$ ({unit})"


def _looks(dataset: xr.Dataset, reached: Collection[str]) -> dict[str, dict[str, Any]]:
    """The mark and the colour of each class that is reached, and of each of several cycles."""
    classes = list(flag_names(dataset["attractor"].attrs).values())
    colours = zip(classes, MARKS, style.class_colours(classes), strict=False)
    looks = {name: (mark, colour) for name, mark, colour in colours if name in reached}
    cycles = sorted({*reached} - {*classes})
    looks |= dict(zip(cycles, OF_CYCLES.items(), strict=False))
    return {name: {"marker": mark, "color": colour} for name, (mark, colour) in looks.items()}


def _scatter(
    ax: Axes,
    part: xr.Dataset,
    reached: np.ndarray,
    names: tuple[str, str],
    looks: Mapping[str, Mapping[str, Any]],
    told: Mapping[str, str],
) -> None:
    """The starts of one panel, and where they rest; the legend says what is `told` of classes."""
    x, y = (part[STARTS].sel(state=name).values for name in names)
    size = 4.0 * style.dot_size(len(x)) * min(1.0, ax.bbox.width / ax.figure.dpi / style.PANEL[0])
    filled = _is_dense(ax, x, y, size)  # then cells without seams in place of marks
    for name, look in looks.items():
        mask, label = reached == name, _words(name)
        if not mask.any():
            continue
        key = {**look, "marker": "s"} if filled else look
        starts = ax.scatter(
            x[mask], y[mask], size, zorder=3.0 - mask.mean(), lw=0.5, **look,
            label=points.unlisted(label) if name in told or filled else label,
            rasterized=len(x) > style.MANY_MARKS, visible=not filled,
        )  # fmt: skip
        drawn.name_points(starts, part["initial"].values[mask].tolist())
        if filled:
            cells = _cells(x, y, mask)
            look_of = {"color": look["color"], "rasterized": len(x) > style.MANY_MARKS}
            ax.add_collection(PolyCollection([*cells], lw=SEAM, zorder=2.0, **look_of))
            ax.margins(0.0)  # they fill the panel, as on a map
        if name in told or filled:
            words = _told(told)[name] if name in told else label
            ax.scatter([], [], lw=0.5, label=words, **key)
    rests = _rests(part.isel(initial=np.flatnonzero(reached == "equilibrium")), names)
    if rests.size:  # the starts beneath are seen through it
        ax.plot(*rests.T, "*", ms=STAR, mfc="none", mec=style.BLACK, mew=0.8, zorder=3.5,
                label="where they rest")  # fmt: skip


def _is_dense(ax: Axes, x: np.ndarray, y: np.ndarray, size: float) -> bool:
    """Whether starts are a lattice: of many, or of cells hardly larger than marks."""
    counts = np.array([_distinct(x), _distinct(y)])
    if counts.prod() != x.size or counts.min() < 2:
        return False
    cell = np.array(ax.bbox.size) / ax.figure.dpi * style.POINTS / counts
    return bool(cell.min() ** 2 < DENSE * size) or x.size >= MANY


def _cells(x: np.ndarray, y: np.ndarray, mask: np.ndarray) -> np.ndarray:
    """Corners of the cells of some points of a lattice, shape (cells, 4, 2)."""
    sides = np.array([np.ptp(every) / (_distinct(every) - 1) for every in (x, y)])
    return np.column_stack([x, y])[mask][:, None] + 0.5 * sides * np.array(CORNERS)


def _distinct(values: np.ndarray) -> int:
    """How many values there are: what differs by rounding is one."""
    steps = (values - values.min()) / (SAME * max(float(np.ptp(values)), np.finfo(float).tiny))
    return np.unique(steps.round()).size


def _motions_in_time(layer: points.Layer, of_file: bool) -> list[motion.Motion]:
    """Those of a file, of whichever of its analyses has any; `of_file`: by its name, too."""
    dataset = _in_time(layer)
    every = motion.motions(dataset, {"overlay": True})
    given = dataset.attrs.get("called", layer.label)
    file, word = layer.label if of_file or given else "", motion.what_it_is(dataset)
    alone = len(every) == 1 and word != "motion"  # a cycle is one from wherever it was reached
    names = [points.joined(file, "" if alone else one.label) for one in every]
    labels_of = names if given else [f"{word}{': ' * bool(name)}{name}" for name in names]
    return [replace(one, label=label) for one, label in zip(every, labels_of, strict=True)]


def _in_time(layer: points.Layer) -> xr.Dataset:
    """The analysis of a file that has motions in time, if one has."""
    return next(filter(motion.suits, (layer.dataset, *layer.beside)), layer.dataset)


def _lay_over(
    axes: Sequence[Axes],
    parts: Sequence[xr.Dataset],
    layers: Sequence[points.Layer],
    names: tuple[str, str],
    settings: points.Settings,
) -> None:
    """Motions of further files as thin black lines, each in the panels of its parameters."""
    words = [motion.what_it_is(_in_time(layer)) for layer in layers]
    alike = [len(words) > 1 and (word == "motion" or words.count(word) > 1) for word in words]
    every = chain(*map(_motions_in_time, layers, alike))
    solid, *broken = style.DASHES
    dashes = {False: cycle([solid, *broken[1:]]), True: cycle([broken[0], *broken[2:]])}
    for one in every:
        dash = next(dashes[motion.what_it_is(one.data).startswith("unstable")])
        for name in names:
            motion.known_variable(one.data, name)
        path = phase.path_of(one, names, settings)
        until = path.once_around() if dash != "-" else np.inf  # dashes would fill their gaps
        whole, look = path.between(-np.inf, until), {"color": style.BLACK, "lw": 1.0, "ls": dash}
        told = _of_other_parameters(one, parts)
        style.add_notes(axes[0].figure.figure, [f"{one.label}: {told}"] * bool(told))
        for ax in _panels_of(one, axes, parts):
            path.draw(ax, whole, points.joined(one.label, told), zorder=3.2, **look)
            ax.autoscale_view()


def _of_other_parameters(one: motion.Motion, parts: Sequence[xr.Dataset]) -> str:
    """What a motion over basins of a single panel has that these have not."""
    names = differing(one.data, parts[0]) if len(parts) == 1 else []
    words = [*chain(*(held_words(one.data, name) for name in names))]
    return f"of other parameters: {', '.join(words)}" if words else ""


def _panels_of(one: motion.Motion, axes: Sequence[Axes], parts: Sequence[xr.Dataset]) -> list[Axes]:
    """Those whose parameters a motion has; a single one takes all, which say what differs."""
    pairs = [*zip(axes, parts, strict=False)]
    found = [ax for ax, part in pairs if len(parts) == 1 or of_the_same(one.data, part) is not None]
    if not found:
        labels_of = "; ".join(str(ax.get_label()) for ax, _ in pairs)
        raise UsageError(
            f"{drawn.in_one_line(one.label)}: no panel of these basins has its parameters\n"
            f"the panels are: {drawn.in_one_line(labels_of)}\n"
            "next: fiv history CASE --at what one of them has"
        )
    return found


def _motions(part: xr.Dataset, single: bool) -> np.ndarray:
    """What each start reaches: its class or, of a few cycles of one class, which of them.

    In a `single` panel they go by their periods, else by their numbers: others have other periods.
    """
    reached = class_names(part["attractor"]).astype(object)
    size = size_of_cycles(part).values
    is_cycle = np.isfinite(size)
    if is_cycle.sum() < (reached == "periodic").sum():  # which of them was filled in is not known
        return reached
    number = number_of_each(size[is_cycle], tolerance(part))
    if 0 < number.max(initial=0) < len(OF_CYCLES):
        by_period = single and "period" in part
        names = _by_period(part["period"].values[is_cycle], number) if by_period else None
        numbers = [f"cycle {one}" for one in range(1, len(OF_CYCLES) + 1)]
        reached[is_cycle] = np.array(names or numbers, object)[number]
    return reached


def _by_period(periods: np.ndarray, number: np.ndarray) -> list[str]:
    """What the cycles are called: by their periods and, where two have one, by their number."""
    firsts = [float(f"{periods[number == one][0]:.4g}") for one in range(number.max() + 1)]
    names = [f"periodic, $T$ = {labels.number_text(period)} s" for period in firsts]
    if len({*names}) == len(names):
        return names
    return [f"{name}, cycle {one}" for one, name in enumerate(names, 1)]


def _rests(part: xr.Dataset, names: tuple[str, str]) -> np.ndarray:
    """Where motions rest, each place once, shape (places, 2); none where it is not known."""
    ends = [f"{name}_max" for name in names]
    if not {*ends} <= {*part}:
        return np.zeros((0, 2))
    places = np.stack([part[end].values for end in ends], axis=1)
    places = places[np.isfinite(places).all(axis=1)]  # those that were run
    steps = np.round(places / (SAME * max(float(np.abs(places).max(initial=0.0)), SAME)))
    return places[np.sort(np.unique(steps, axis=0, return_index=True)[1])]


def _words(name: str) -> str:
    return name.replace("_", " ")


def _told(shares_of: Mapping[str, str]) -> dict[str, str]:
    """Each class, or cycle by its period or number, and the share of its basin."""
    are_numbers = any(NUMBER.search(style.worded(_words(name))) for name in shares_of)
    return {name: f"{_words(name)}{':' * are_numbers} {share}" for name, share in shares_of.items()}


def _shares(reached: np.ndarray, sample: bool) -> dict[str, str]:
    """Class -> its share in one panel: periodic -> ``0.621 ± 0.034``, equilibrium -> ``(all 200)``.

    Of starts that are no random `sample` it is a count, too: ``62.0 % (124 of 200)``.
    """
    names, counts = np.unique(reached[reached != NOT_COMPUTED].astype(str), return_counts=True)
    total = int(counts.sum())
    found = {}
    for name, count in zip(names.tolist(), counts.tolist(), strict=True):
        share = count / total
        told = with_error(share, shares.standard_error(share, total))
        found[name] = told if sample else f"{100.0 * share:.1f} % ({count} of {total})"
        if count == total:
            found[name] = f"(all {total})"
    return found


def _is_sample(dataset: xr.Dataset) -> bool:
    return shares.is_sample(dataset, shares.drawn_of(dataset))
