"""What a caption has to tell of a figure that has no title."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any

from fiv_cli.plots import style
from fiv_cli.plots.drawn import in_one_line
from fiv_cli.plots.labels import title_of, value_label
from fiv_cli.reading.causes import case_of

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure


def caption(drawn: Figure, datasets: Sequence[xr.Dataset]) -> list[str]:
    """What would stand below the title, what the cases give all datasets alike, random starts."""
    if style.has_titles():
        return []
    below = str(drawn.get_label()).removeprefix(title_of(datasets[0].attrs)).splitlines()
    said = {word for line in below for word in line.split(", ")}
    every = [[*_given(dataset)] for dataset in datasets]
    given = [word for word in every[0] if all(word in own for own in every) and word not in said]
    told = [*filter(None, below), ", ".join(given), *_random_starts(datasets[0])]
    words = in_one_line("; ".join(filter(None, told)))
    return [f"for the caption: {words}"] * bool(words)


def _given(dataset: xr.Dataset) -> Iterator[str]:
    """The parameters of which the case gives one number, as the dataset has them."""
    case = case_of(dataset.attrs)
    tables = (_table(_table(case, "model"), "parameters"), _table(case, "friction"))
    for name in (name for table in tables for name in table):
        held = dataset.coords.get(name)
        if held is not None and not held.ndim and held.dtype.kind in "fi":
            yield value_label(held, held.item())


def _random_starts(dataset: xr.Dataset) -> Iterator[str]:
    """How many starts of those drawn are random, and from which box.

    Nothing where --set says otherwise, or of what knows no starts.
    """
    if "initial." in dataset.attrs.get("overrides", ""):
        return
    shown = [str(one) for one in dataset["initial"].values.ravel()] if "initial" in dataset else []
    for start in case_of(dataset.attrs).get("initial", []):
        label = str(start.get("label"))
        is_shown = "share" in dataset or any(one.startswith(f"{label}-") for one in shown)
        if start.get("kind") == "random" and is_shown:
            ends = (f"{n} from {a} to {b}" for n, (a, b) in _table(start, "box").items())
            yield f"{label}: {start.get('count', 1)} random starts, {', '.join(ends)}"


def _table(of: Mapping[str, Any], key: str) -> Mapping[str, Any]:
    """A table of a table; an empty one where it is none, as in a case of others."""
    found = of.get(key, {})
    return found if isinstance(found, Mapping) else {}
