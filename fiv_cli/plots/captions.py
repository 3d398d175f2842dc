"""What a caption has to tell of a figure that has no title."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from itertools import product
from typing import TYPE_CHECKING, Any

from fiv_cli.case.overrides import parse_override
from fiv_cli.plots import branch, points, style
from fiv_cli.plots.drawn import in_one_line
from fiv_cli.plots.labels import title_of, unit_text
from fiv_cli.plots.same_parameters import held_words
from fiv_cli.reading import shares
from fiv_cli.reading.causes import case_of

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure


OF_TABLE = re.compile(r"[- ]\d{3,}$")  # the number of a start of a table in its label
MOST_DEFAULTS = 8  # of a model whose every parameter counts
MOST_STARTS = 5  # of a table that a caption has room for


def caption(drawn: Figure, datasets: Sequence[xr.Dataset]) -> list[str]:
    """What would stand below the title, what a case gives and all datasets have alike, starts."""
    if style.has_titles():
        return []
    below = str(drawn.get_label()).removeprefix(title_of(datasets[0].attrs)).splitlines()
    said = {word for line in below for word in line.split(", ")}
    names = [*dict.fromkeys(name for dataset in datasets for name in _given(dataset))]
    led = {str(n) for one in datasets for n in one.coords if branch.leads_along(one, str(n))}
    of_run = product(datasets, ("overrides", "overridden"))
    by_hand = {str(axis.name) for pair in of_run for axis in points.set_by_hand(*pair)}
    known = {*names, *led, *by_hand}
    names = [name for name in names if name not in led]
    swept = [one for one in datasets if "crossing" not in one.dims]  # others mark places alone
    every = [
        _of_all(*([held_words(one, name) for one in some] for some in (datasets, swept)))
        for name in names
    ]
    ends = {word: f" = {word.removeprefix('$')}" for word in every}  # of a parameter that leads it
    follow = {word for word in every for one in every if one.endswith(ends[word])}
    given = [word for word in every if word not in said | follow | {""}]
    with_starts = [one for one in datasets if "initial" in one or "share" in one]
    of_each = [[*_random_starts(one), *_starts_of_a_table(one)] for one in with_starts]
    alike = all(own == of_each[0] for own in of_each)
    starts = of_each[0] if of_each and alike else []
    if not alike and all(of_each):
        starts = [f"starts, file by file: {' | '.join('; '.join(own) for own in of_each)}"]
    left = _by_default(datasets, known)
    told = [*filter(None, below), ", ".join(given), *left, *starts, *style.caption_of(drawn)]
    words = in_one_line("; ".join(filter(None, told)))
    return [f"for the caption: {words}"] * bool(words)


def _by_default(datasets: Sequence[xr.Dataset], given: set[str]) -> list[str]:
    """The parameters that cases leave as they are in the model, but what is 0; of many, which not
    every option needs, where they stand."""
    fixed = (axis for axis in datasets[0].coords.values() if not axis.ndim)
    off = _still(datasets)
    told = (axis for axis in fixed if axis.attrs.get("long_name") not in off)
    names = [str(axis.name) for axis in told if axis.dtype.kind == "f"]
    held = [[held_words(one, name) for one in datasets] for name in names if name not in given]
    alike = [one[0][0] for one in held if one[0] and all(own == one[0] for own in one)]
    words = [word for word in alike if word.rpartition(" = ")[2].split()[0] != "0"]
    if len(words) > MOST_DEFAULTS:
        model = str(datasets[0].attrs.get("model", "MODEL")).partition(" + ")[0]
        return [f"{len(words)} parameters by default (fiv models {model})"]
    return [f"by default {', '.join(words)}"] * bool(words)


def _still(datasets: Sequence[xr.Dataset]) -> set[str]:
    """What the frequencies of excitations mean whose amplitudes are 0 in all datasets."""
    axes = [axis for one in datasets for axis in one.coords.values() if axis.dtype.kind == "f"]
    named = [(str(axis.attrs.get("long_name")), bool((axis != 0.0).any())) for axis in axes]
    still = {name for name, _ in named} - {name for name, moves in named if moves}
    parts = (name.partition("amplitude of ") for name in still)
    return {f"frequency of {what}" for _, of, what in parts if of}


def _given(dataset: xr.Dataset) -> Iterator[str]:
    """The names of the parameters and of the law that the case of a dataset gives, or varies."""
    case = case_of(dataset.attrs)
    axes = (str(name) for name, axis in dataset.coords.items() if axis.dims == (name,))
    is_one = "n_crossings" in dataset and bool((dataset["n_crossings"] <= 1).all())
    yield from (name for name in axes if not (name == "crossing" and is_one))
    yield from _table(_table(case, "model"), "parameters")
    yield from _table(case, "friction")
    yield from _table(_table(case, "model"), "options")
    yield from _options_by_hand(dataset)
    if "separation_fraction" in dataset and bool((dataset["separation_fraction"] > 0.0).any()):
        yield "impact"  # which decides how large motions are


def _options_by_hand(dataset: xr.Dataset) -> Iterator[str]:
    """The options of the model that the run was given with --set."""
    for told in ("overrides", "overridden"):
        given = map(parse_override, str(dataset.attrs.get(told, "")).splitlines())
        yield from (one.keys[-1] for one in given if one.keys[:-1] == ("model", "options"))


def _of_all(held: Sequence[Sequence[str]], swept: Sequence[Sequence[str]]) -> str:
    """The one value of all, which datasets that are not `swept` may have among more."""
    alone = {one[0] for one in held if len(one) == 1}
    is_one = len(alone) == 1 and all(alone <= {*one} for one in held)
    return next(iter(alone)) if is_one and all(len(one) == 1 for one in swept) else ""


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


def _starts_of_a_table(dataset: xr.Dataset) -> Iterator[str]:
    """Where each of a few starts of a table lies: their labels are but numbers."""
    tables = shares.labels_of(dataset, "table")
    labels = [str(one) for one in dataset["initial"].values.ravel()] if "initial" in dataset else []
    members = [one for one in labels if OF_TABLE.sub("", one) in tables]
    states = dataset.get("initial_state")
    units = dataset.coords.get("state_units")
    if states is None or units is None or "initial" not in states.dims or not states.size:
        return
    for label in members if len(members) <= MOST_STARTS else ():
        own = states.sel(initial=label).transpose("state", ...)
        rows = own.values.reshape(own.sizes["state"], -1)
        if (rows == rows[:, :1]).all():
            each = zip(own["state"].values, rows[:, 0], map(unit_text, units.values), strict=True)
            words = (f"{name} = {value:.6g} {unit}".rstrip() for name, value, unit in each)
            yield f"{label}: {', '.join(words)}"


def _table(of: Mapping[str, Any], key: str) -> Mapping[str, Any]:
    """A table of a table; an empty one where it is none, as in a case of others."""
    found = of.get(key, {})
    return found if isinstance(found, Mapping) else {}
