"""Lines of a map where one axis has the value that another case found along the other.

The critical value of mu_k over Omega, say, on a map over Omega and mu_k: to rounding, not to half a
step of the map as the line at which a growth rate is zero between its points. Where more modes turn
unstable beyond that, no border lies.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.lines import Line2D
from matplotlib.path import Path
from matplotlib.transforms import Bbox

from fiv_cli.errors import UsageError
from fiv_cli.notation.names import listed
from fiv_cli.plots import crossings, labels, levels, points, style
from fiv_cli.plots.curve_lines import PLACE
from fiv_cli.reading.datasets import error_of, is_class

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes
    from matplotlib.typing import ColorType

COARSE = 1  # places of a map on a straight piece of a line
LEFT_OPEN = "undecided_in_part"
Piece = tuple[np.ndarray, np.ndarray]
"""Places of a line along both axes."""
Joined = tuple["xr.DataArray", np.ndarray, list[list[crossings.Place]]]
"""An axis, crossings along it, shape (places, crossings), and which make a line."""


@dataclass(frozen=True)
class CriticalLines:
    """A variable along one axis of the `mapped`, whose values lie `upright`, along the other.

    It is `called` by that, or as the variable is.
    """

    mapped: xr.Dataset
    axes: tuple[xr.DataArray, xr.DataArray]
    panels: Sequence[points.Line]
    dataset: xr.Dataset
    name: str
    upright: str
    style: Any
    called: str = ""

    @property
    def missed(self) -> list[str]:
        """That there is no line, where no value lies within the map; places that are not known."""
        inside = any(self._pieces(panel) for panel in self.panels)
        none = f"no line of the {self._words}: no value within the map"
        is_open, known = _is_left_open(self.dataset), self._is_known(self.dataset)
        dims = [dim for dim in known.dims if dim not in is_open.dims]
        left, places = int((is_open & ~known.any(dims)).sum()), self.dataset["status"].size
        told = f"{self._words}: not at {left} of {places} places ({LEFT_OPEN}: raise t_max there)"
        return [*[none] * (not inside), *[told] * bool(left)]

    @property
    def accuracy(self) -> str:
        """How far what lies within the map may be off, where that is known and more than
        rounding."""
        (along,) = (one for one in self.axes if str(one.name) == self.upright)
        ends = points.positions(along).min(), points.positions(along).max()
        array, error = self._of_the_border(self.dataset), self._error(self.dataset)
        inside = np.isfinite(error) & (ends[0] <= array) & (array <= ends[1])
        most = float(error.where(inside).max())
        unit = labels.unit_text(str(array.attrs.get("units", "1")))
        is_told = most > style.ROUNDING * np.ptp(ends)
        within = f"{self._words}: within {most:.2g} {unit}".rstrip()
        return f"{within} at its values of {self._along.name}" if is_told else ""

    @property
    def inexact(self) -> Iterator[str]:
        """Where neighbours are not joined, and that there are few values to draw lines through."""
        along, drawn = self._along, [self._joined(panel) for panel in self.panels]
        steps = sorted({step for of_panel in drawn for step in crossings.not_joined(*of_panel)})
        x = points.positions(drawn[0][0]) if drawn else np.zeros(0)
        yield from crossings.broken(
            self._words, along.name, [(x[at], x[at + 1]) for at in steps], x
        )
        known = [np.isfinite(values).any(axis=1) for _, values, _ in drawn]
        without = [one.label for one, own in zip(self.panels, known, strict=True) if not own.any()]
        if without and len(without) < len(known):
            yield f"{self._words}: no line in panel {listed(without)}: its case has no value there"
        if lacking := sum(int((~own).sum()) for own in known if own.any()):
            yield (
                f"{self._words}: its line ends where there is no value, at {lacking} "
                f"place{'s' * (lacking > 1)} along "
                f"{along.name}; fiv show of its dataset says why"
            )
        if stops := [labels.number_text(x[at], x.tolist()) for at in self._stops(x, drawn)]:
            yield (
                f"{self._words}: its line ends at {along.name} = {listed(stops)}, where the values "
                f"of its case end and the map does not; a wider {along.name} there leads it on"
            )
        between = np.diff(np.searchsorted(np.sort(points.positions(along)), np.sort(x)))
        if between.max(initial=0) > COARSE:
            yield (
                f"{self._words}: straight between its {x.size} values of {along.name}, of which "
                "the map has more; as many in its case bend it"
            )

    def _stops(self, x: np.ndarray, drawn: Sequence[Joined]) -> list[int]:
        """At which of its outer places a line ends within the map, which goes on."""
        ends = {own.name: points.positions(own) for own in self.axes}
        mapped, (upright,) = ends.pop(self._along.name), ends.values()
        step = np.ptp(mapped) / max(mapped.size - 1, 1)
        outer = [int(x.argmin())] * bool(mapped.min() + step < x.min() <= mapped.max())
        outer += [int(x.argmax())] * bool(mapped.min() <= x.max() < mapped.max() - step)
        inside = [(upright.min() <= own) & (own <= upright.max()) for _, own, _ in drawn]
        return [at for at in outer if any(own[at].any() for own in inside)]

    def keys(self, colour: ColorType) -> list[Line2D]:
        """Its entry of a legend and, beside lines, that of places that no line leads through."""
        pieces = [piece for panel in self.panels for piece in self._pieces(panel)]
        pieces.sort(key=lambda piece: piece[0].size, reverse=True)
        looks = [self._look(piece) for piece in pieces[:1]]
        if pieces and pieces[0][0].size > 1 == pieces[-1][0].size:
            looks.append(self._look(pieces[-1]))
        told = (self._words, "the same, at one place alone")
        return [
            Line2D([], [], color=colour, label=label, **look)
            for label, look in zip(told, looks, strict=False)
        ]

    def draw(self, ax: Axes, panel: points.Line, colour: ColorType) -> tuple[()]:
        """Draw the lines of one panel, whose ranges stay as they are; they have no levels."""
        ranges = {"xlim": ax.get_xlim(), "ylim": ax.get_ylim()}
        for x, y in self._pieces(panel):
            label = points.unlisted(self._words)
            (drawn,) = ax.plot(x, y, color=colour, label=label, **self._look((x, y)))
            drawn.set_clip_on(x.size > 1)  # a mark is whole beside a frame, too
        ax.set(**ranges)
        return ()

    @property
    def is_one(self) -> bool:
        """Whether it is the same in all panels."""
        first, *others = (
            [np.array(one).tolist() for one in self._pieces(panel)] for panel in self.panels
        )
        return all(one == first for one in others)

    def _look(self, piece: Piece) -> dict[str, Any]:
        """A line or, of a single place, a mark."""
        look = {"ls": self.style, "lw": 1.5} if piece[0].size > 1 else PLACE | {"ls": "none"}
        return look | {"path_effects": levels.RIM}

    @property
    def _words(self) -> str:
        own = str(self.dataset[self.name].attrs["long_name"])
        return self.called or labels.with_symbols(own)

    def _pieces(self, panel: points.Line) -> list[Piece]:
        """The lines that have a part within a panel."""
        ends = [(own.min(), own.max()) for own in map(points.positions, self.axes)]
        corners = np.column_stack(ends)
        return [piece for piece in self._lines(panel) if _is_inside(piece, corners)]

    def _lines(self, panel: points.Line) -> list[Piece]:
        """Crossings of neighbours joined, as far as they belong together."""
        axis, values, joined = self._joined(panel)
        x = points.positions(axis)
        lines = [(x[at[0]], values[at]) for at in (tuple(np.array(line).T) for line in joined)]
        return [(y, x) for x, y in lines] if self._is_turned else lines

    @property
    def _is_turned(self) -> bool:
        return self.upright == str(self.axes[0].name)

    @property
    def _along(self) -> xr.DataArray:
        """The axis of the map along which the values are known."""
        return self.axes[1 if self._is_turned else 0]

    def _joined(self, panel: points.Line) -> Joined:
        """What is drawn in a panel."""
        along = self._along
        dataset = self._on_the_map(along)
        array, axis = self._of_the_border(dataset), dataset[along.name]
        own = {dim: at for dim, at in panel.index.items() if dim in array.dims}
        values, modes = (
            one.isel(own).transpose(along.dims[0], ...).values.reshape(axis.size, -1)
            for one in (array, crossings.modes_of(dataset, array))
        )
        return axis, values, crossings.joined(axis, values, modes)

    def _on_the_map(self, along: xr.DataArray) -> xr.Dataset:
        """What it is drawn of, along one axis and those of the panels alone.

        Raises
        ------
        UsageError : there are others at each place, or none along that axis
        """
        panels = {dim for panel in self.panels for dim in panel.index}
        dataset = levels.under_panels(self.dataset, self.mapped, panels)
        array, dim = dataset[self.name], along.dims[0]
        if dim not in array.dims:
            raise UsageError(
                f"{self.name}: a line of it on this map needs its values along {along.name}, and "
                f"it varies along {listed(sorted(map(str, array.dims)))}\n"
                f"next: give its case {along.name} as an axis, under [grid]"
            )
        kept = {one for one in panels if levels.same_along(dataset, self.mapped, one)}
        further = [str(one) for one in array.dims if one not in {dim, "crossing", *kept}]
        return levels.at_the_map(self.name, dataset, self.mapped, further)

    def _of_the_border(self, dataset: xr.Dataset) -> xr.DataArray:
        """Of several crossings those at which the equilibrium itself turns stable or unstable."""
        values = dataset[self.name].where(self._is_known(dataset))
        sides = [dataset[one] for one in ("unstable_below", "unstable_above") if one in dataset]
        if values.sizes.get("crossing", 1) == 1 or not sides:
            return values
        return values.where((sides[0] <= 0) | (sides[-1] <= 0))

    def _is_known(self, dataset: xr.Dataset) -> xr.DataArray:
        """Which values are such, whatever else is open at their place."""
        return ~_is_left_open(dataset) | np.isfinite(self._error(dataset))

    def _error(self, dataset: xr.Dataset) -> xr.DataArray:
        """How far values may be off; NaN where that is not known."""
        plain = self.name.rpartition(":")[2]  # without the case that it is of
        return dataset.get(error_of(plain), dataset[self.name] * np.nan)


def _is_left_open(dataset: xr.Dataset) -> xr.DataArray:
    """Where undecided runs leave so much open that a value may be none, the middle of what may be;
    what it may be off is not known then."""
    return is_class(dataset.get("reason", dataset["status"]), (LEFT_OPEN,))


def _is_inside(piece: Piece, corners: np.ndarray) -> bool:
    """Whether some of a line, not of its points alone, lies between the `corners` of a map."""
    places = np.column_stack(piece)
    if ((corners[0] <= places) & (places <= corners[1])).all(axis=1).any():
        return True
    return bool(Path(places).intersects_bbox(Bbox(corners), filled=False))
