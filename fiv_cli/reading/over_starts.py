"""Where starts end differently: the range in which what is reached depends on the start."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from itertools import combinations, islice
from typing import Any

import xarray as xr

from fiv_cli.reading import select
from fiv_cli.reading.cycles import displacements, size_of_cycles, tolerance
from fiv_cli.reading.datasets import flag_names, is_class
from fiv_cli.reading.over_laws import OPEN, stretches

MOST_PAIRED = 3  # starts that are held against one another; more are told together
NAMED = 4  # stretches of an axis that are named; of more the range


def differing(dataset: xr.Dataset) -> list[dict[str, Any]]:
    """How what is reached depends on the start; [] without classes, or with one start.

    Returns
    -------
    list : for each pair of a few starts, or for many together: the ``starts``, in words, at how
        many ``points`` two of them are decided, at how many of these they ``differ`` in class and
        where (``at``), of a pair also between which ``classes`` how often; at how many two reach
        ``another`` cycle, as its size says, and where (``another_at``), of those at which that of
        several ``cycles`` is known; and at how many of those at which several are ``stuck`` they
        are so ``elsewhere``, and where (``elsewhere_at``)
    """
    reached = dataset.get("attractor")
    if reached is None or reached.dims != dataset["status"].dims or "initial" not in reached.dims:
        return []
    # what has one value at each point
    asked = dataset[[name for name, told in dataset.items() if told.dims == reached.dims]]
    labels = dataset["initial"].values
    if len(labels) > MOST_PAIRED:
        return [{"starts": f"all {len(labels)} starts", **_among(asked)}]
    return [_of_pair(asked.sel(initial=list(pair))) for pair in combinations(labels, 2)]


def _of_pair(pair: xr.Dataset) -> dict[str, Any]:
    differ, names = _differ(pair).values, flag_names(pair["attractor"].attrs)
    codes = (pair["attractor"].isel(initial=start).values[differ].tolist() for start in (0, 1))
    counts = Counter(zip(*codes, strict=True)).most_common()
    classes = {f"{names[one]} against {names[other]}": count for (one, other), count in counts}
    starts = f"starts {' and '.join(pair['initial'].values)}"
    return {"starts": starts, **_among(pair), "classes": classes}


def _among(dataset: xr.Dataset) -> dict[str, Any]:
    differ = _differ(dataset)
    several, another = _another(dataset)
    stuck, elsewhere = _elsewhere(dataset)
    decided = (~is_class(dataset["attractor"], OPEN)).sum("initial")
    return {
        "points": int((decided > 1).sum()),
        "differ": int(differ.sum()),
        "at": _places(differ),
        "cycles": int(several.sum()),
        "another": int(another.sum()),
        "another_at": _places(another),
        "stuck": int(stuck.sum()),
        "elsewhere": int(elsewhere.sum()),
        "elsewhere_at": _places(elsewhere),
    }


def _differ(dataset: xr.Dataset) -> xr.DataArray:
    """Where two starts are of different classes, and both decided."""
    decided = dataset["attractor"].where(~is_class(dataset["attractor"], OPEN))
    return decided.max("initial") > decided.min("initial")


def _another(dataset: xr.Dataset) -> tuple[xr.DataArray, xr.DataArray]:
    """Where several starts reach cycles, and where their size differs by more than errors."""
    of_cycles = size_of_cycles(dataset)
    several = of_cycles.notnull().sum("initial") > 1
    return several, _spread(of_cycles) > tolerance(dataset) * of_cycles.max("initial")


def _elsewhere(dataset: xr.Dataset) -> tuple[xr.DataArray, xr.DataArray]:
    """Where several starts end stuck, and where they do so at other displacements."""
    is_stuck = is_class(dataset.get("reason", dataset["attractor"]), ("stuck",))
    elsewhere = is_stuck.any("initial") & False
    for name in displacements(dataset):
        greatest = dataset[f"{name}_max"]
        at_rest = greatest.where(is_stuck)
        elsewhere |= _spread(at_rest) > tolerance(dataset) * abs(greatest).max()
    return is_stuck.sum("initial") > 1, elsewhere


def _spread(values: xr.DataArray) -> xr.DataArray:
    return values.max("initial") - values.min("initial")


def _places(marked: xr.DataArray) -> list[str]:
    """Stretches along an axis; of many, over several axes, the range of the marked on each."""
    axes = [axis for axis in marked.coords.values() if axis.ndim == 1 and axis.size > 1]
    if len(axes) == 1:
        return [f"{stretch}{_unit(axes[0])}" for stretch in stretches(marked)]
    named = [*islice(stretches(marked), NAMED + 1)]
    if len(named) <= NAMED:
        return named
    others = ((axis, [dim for dim in marked.dims if dim not in axis.dims]) for axis in axes)
    return [", ".join(_range(axis[marked.any(rest).values]) for axis, rest in others)]


def _range(axis: xr.DataArray) -> str:
    """An axis from its least value to its greatest; of one without numbers each value."""
    if not select.is_numeric(axis):
        return f"{axis.name} = {', '.join(map(str, axis.values))}"
    ends = dict.fromkeys(f"{end:g}" for end in (axis.values.min(), axis.values.max()))
    return f"{axis.name} = {' to '.join(ends)}{_unit(axis)}"


def _unit(axis: xr.DataArray) -> str:
    unit = str(axis.attrs.get("units", "1"))
    return "" if unit == "1" else f" {unit}"


def lines(told: Sequence[Mapping[str, Any]]) -> list[str]:
    """The same for people, a line or two for each pair."""
    return [line for facts in told if facts["points"] for line in _lines(facts)]


def _lines(facts: Mapping[str, Any]) -> Iterator[str]:
    starts, points = f"  {facts['starts']}:", f"{facts['points']} points decided"
    between = ", ".join(f"{both} {count}" for both, count in facts.get("classes", {}).items())
    if facts["differ"]:
        told = f"{facts['differ']} of {points}{_named(facts['at'])}"
        yield f"{starts} different classes at {told}" + f" ({between})" * bool(between)
    if facts["another"]:
        of = f"{facts['cycles']} points where several were found periodic"
        told = f"{facts['another']} of {of}{_named(facts['another_at'])}"
        yield f"{starts} another periodic motion at {told}"
    if facts["elsewhere"]:
        of = f"{facts['stuck']} points where several are stuck"
        told = f"{facts['elsewhere']} of {of}{_named(facts['elsewhere_at'])}"
        yield f"{starts} stuck elsewhere at {told}"
    if not facts["differ"] and not facts["another"] and not facts["elsewhere"]:
        yield f"{starts} the same at all {points}"


def _named(places: Sequence[str]) -> str:
    more = len(places) - NAMED
    told = "; ".join(filter(None, places[:NAMED]))
    return f", {told}" * bool(told) + f"; and {more} more" * (more > 0)
