"""Basins: the starts of the motions over two of their components, coloured by what they reach.

The share of the starts that reach a class estimates the volume of its basin. Of starts drawn at
random, not of others, its standard error is sqrt(p (1 - p) / n) (Menck et al., Nature Physics 9
(2013) 89).
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np

from fiv_cli.errors import UsageError
from fiv_cli.flags import NOT_COMPUTED
from fiv_cli.notation.amounts import with_error
from fiv_cli.plots import labels, points, style
from fiv_cli.plots import map as map_
from fiv_cli.reading import shares
from fiv_cli.reading.datasets import class_names, flag_names, is_class

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

STARTS = "initial_state"
FEWEST = 10  # starts that make a figure of their own
SHARE = 26  # letters of a share and its class
STAR = 60.0  # area of the mark of an equilibrium, in square points
MARKS = (".", "o", "s", "^", "D", "x", "P", "v")  # of the classes, in the order of their codes


def suits(dataset: xr.Dataset) -> bool:
    """Whether the dataset holds many starts, and what they reach."""
    if STARTS not in dataset or "attractor" not in dataset:
        return False
    return dataset.sizes["initial"] >= FEWEST and len(_varying(dataset)) >= 2


def draw(layers: Sequence[points.Layer], settings: points.Settings) -> Figure:
    """A panel for each value of the other axes; the shares of the classes above it."""
    dataset = layers[0].dataset
    names = _components(dataset, settings)
    known = is_class(dataset["status"], ("ok", "budget"))
    points.refuse_empty(dataset, bool(known.any()), "attractor")
    panels = points.lines(dataset, ["initial"], points.grid_dims(dataset))
    map_.refuse_many(panels, dataset["attractor"], ["initial"])
    figure, axes, columns = style.grid_of_panels(
        len(panels), map_.MOST_COLUMNS, points.title(dataset), SHARE, sharex=True, sharey=True
    )
    for number, (ax, panel) in enumerate(zip(axes, panels, strict=False)):
        _scatter(ax, dataset.isel(panel.index), names)
        ax.set_title("\n".join(filter(None, (panel.label, *_shares(dataset, panel.index)))))
        ax.set_xlabel(_label(dataset, names[0]))
        ax.tick_params(labelbottom=True)
        ax.set_ylabel(_label(dataset, names[1]) if number % columns == 0 else "")
        points.scale(ax, settings)
    rows = -(-len(panels) // columns)
    style.make_room(figure, rows * max(ax.get_title().count("\n") for ax in axes))
    error = " ± standard error" if _is_sample(dataset) else ""
    style.legend_below(figure, style.told_in(axes)[0], f"above: shares of the starts{error}")
    return figure


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
    for which in ("x", "y"):
        name = str(settings.get(which, known[0]))
        if name not in known:
            raise UsageError(f"{which} = {name}: no state\nthe states are: {', '.join(known)}")
    if len(free) < 2 and not {"x", "y"} <= set(settings):
        raise UsageError(
            "the starts differ in fewer than two components\n"
            "next: draw a curve, or give [[initial]] a box in two states"
        )
    x = str(settings.get("x", free[0] if free else known[0]))
    others = (name for name in free if name != x)
    partner = f"{x}_dot" if f"{x}_dot" in free else next(others, x)
    return x, str(settings.get("y", partner))


def _label(dataset: xr.Dataset, name: str) -> str:
    unit = labels.unit_text(str(dataset["state_units"].sel(state=name).values))
    return f"initial ${labels.symbol_of_name(name)}$ ({unit})"


def _scatter(ax: Axes, part: xr.Dataset, names: tuple[str, str]) -> None:
    """The starts of one panel, and where they rest."""
    x, y = (part[STARTS].sel(state=name).values for name in names)
    reached = class_names(part["attractor"])
    marks = dict(zip(flag_names(part["attractor"].attrs).values(), MARKS, strict=False))
    table = [name for name in marks if name in reached]
    size = 4.0 * style.dot_size(len(x)) * min(1.0, ax.bbox.width / ax.figure.dpi / style.PANEL[0])
    for name, colour in zip(table, style.class_colours(table), strict=True):
        mask = reached == name
        ax.scatter(
            x[mask], y[mask], size, color=colour, marker=marks[name], lw=0.5,
            zorder=3.0 - mask.mean(), label=name.replace("_", " "),
            rasterized=len(x) > style.MANY_MARKS,
        )  # fmt: skip
    resting, ends = reached == "equilibrium", [f"{name}_max" for name in names]
    if {*ends} <= {*part} and resting.any():
        x, y = (part[end].values[resting] for end in ends)
        ax.scatter(
            x, y, STAR, color=style.BLACK, marker="*", ec="white", lw=0.4, zorder=3.5,
            label="where they rest",
        )  # fmt: skip


def _shares(dataset: xr.Dataset, index: Mapping[str, int]) -> Iterator[str]:
    """The share of each class in one panel: ``periodic 0.621 ± 0.034``, ``equilibrium (all 200)``.

    Of starts that are no random sample it is a count: ``periodic 124 of 200``.
    """
    reached = class_names(dataset["attractor"].isel(index))
    names, counts = np.unique(reached[reached != NOT_COMPUTED].astype(str), return_counts=True)
    total, sample = int(counts.sum()), _is_sample(dataset)
    for name, count in zip(names.tolist(), counts.tolist(), strict=True):
        share = count / total
        told = with_error(share, np.sqrt(share * (1.0 - share) / total))
        told = told if sample else f"{count} of {total}"
        yield f"{name.replace('_', ' ')} {f'(all {total})' if count == total else told}"


def _is_sample(dataset: xr.Dataset) -> bool:
    return shares.is_sample(dataset, shares.drawn_of(dataset))
