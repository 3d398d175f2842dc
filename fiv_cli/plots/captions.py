"""What a caption has to tell of a figure that has no title."""

from __future__ import annotations

import tomllib
from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING, Any

from fiv_cli.plots import style
from fiv_cli.plots.drawn import in_one_line
from fiv_cli.plots.labels import title_of, value_label

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure


def caption(drawn: Figure, dataset: xr.Dataset) -> list[str]:
    """What would stand below the title, the parameters that the case gives, and random starts."""
    if style.has_titles():
        return []
    below = str(drawn.get_label()).removeprefix(title_of(dataset.attrs)).splitlines()
    given = [word for word in _given(dataset) if word not in ", ".join(below)]
    told = [*filter(None, below), ", ".join(given), *_random_starts(dataset)]
    words = in_one_line("; ".join(filter(None, told)))
    return [f"for the caption: {words}"] * bool(words)


def _given(dataset: xr.Dataset) -> Iterator[str]:
    """The parameters of which the case gives one number, as the dataset has them."""
    case = _case(dataset)
    tables = (case.get("model", {}).get("parameters", {}), case.get("friction", {}))
    for name in (name for table in tables for name in table):
        held = dataset.coords.get(name)
        if held is not None and not held.ndim and held.dtype.kind in "fi":
            yield value_label(held, held.item())


def _random_starts(dataset: xr.Dataset) -> Iterator[str]:
    """How many starts were drawn, and from which box; nothing where --set says otherwise."""
    if "initial." in dataset.attrs.get("overrides", ""):
        return
    for start in _case(dataset).get("initial", []):
        if start.get("kind") == "random":
            ends = (f"{n} from {a} to {b}" for n, (a, b) in dict(start.get("box", {})).items())
            yield f"{start.get('label')}: {start.get('count', 1)} random starts, {', '.join(ends)}"


def _case(dataset: xr.Dataset) -> Mapping[str, Any]:
    """The tables of the case; none of what was made without one."""
    try:
        return tomllib.loads(str(dataset.attrs.get("case", "")))
    except tomllib.TOMLDecodeError:
        return {}
