"""What is in a dataset, in a few lines: counts of classes, ranges, and how far to trust it."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from math import inf, prod
from typing import TYPE_CHECKING, Any

import numpy as np

from fiv_cli.analyses.catalogue import named
from fiv_cli.analyses.variables import OF_MOTION, Role, Variable
from fiv_cli.case.identity import MOTION, STEADY_STATE
from fiv_cli.data.refined import described, in_full
from fiv_cli.flags import ENDED_EARLY, NOT_COMPUTED, REASON, advice, left_out
from fiv_cli.notation.amounts import told_apart, with_error
from fiv_cli.reading import each_point, over_laws, over_starts, select, shares, small
from fiv_cli.reading.claims import point_name
from fiv_cli.reading.datasets import (
    analysis_of,
    error_of,
    flag_names,
    is_class,
    numbers,
    standard_error_of,
    variables_in,
)
from fiv_cli.reading.scans import BEYOND, found_from_start, scanned, still_followed

if TYPE_CHECKING:
    import xarray as xr

# Labels of an axis, or values at the only point, that are all listed; of more, the ends.
MOST_NAMES = 8
MANY = 50  # points, of which shares are told

# Reasons of points that are no motion which went on to its end.
WITHOUT_MOTION = (*ENDED_EARLY, "no_cycle", "no_return")

# What impacts take, and what the drive gives, in a `response` and in a `history`.
IMPACTS_AND_DRIVE = (("mean_impact_power", "mean_drive_power"), ("impact_loss", "drive_work"))

OF_EVERY_MOTION = {variable.name for variable in OF_MOTION}

GLOBAL = (
    *("title", "reference", "model", "law", MOTION, STEADY_STATE),
    *("fingerprint", "source", "partial"),
    "assumed_of_contacts",
)


def summarise(analyses: Mapping[str, xr.Dataset]) -> dict[str, Any]:
    """The summary as plain values (what ``fiv show --json`` prints under a schema number).

    Parameters
    ----------
    analyses : name -> dataset
    """
    first = next(iter(analyses.values()))
    return {
        **{key: str(first.attrs[key]) for key in GLOBAL if first.attrs.get(key)},
        "analyses": {
            name: _analysis(dataset, analysis_of(dataset, name))
            for name, dataset in analyses.items()
        },
    }


def _analysis(dataset: xr.Dataset, told: Mapping[str, Any]) -> dict[str, Any]:
    """The summary of an analysis of this kind and these settings."""
    settings = told.get("settings", {})
    still, ends = still_followed(dataset, settings), each_point.branch_ends(dataset)
    begin, struck = _beginning(dataset, settings), _into_impacts(dataset)
    return {
        "dims": {str(dim): dataset.sizes[dim] for dim in dataset["status"].dims},
        "axes": {name: _axis(dataset, name) for name in _grid_axes(dataset)},
        "counts": {
            flag.name: _counts(dataset[flag.name], dataset["status"].ndim)
            for flag in [*variables_in(dataset, Role.STATUS, Role.CLASS), *_detailed(dataset)]
        },
        "shares": shares.shares(dataset),
        "shares_at_each_point": shares.at_each_point(dataset),
        "shares_of_cycles": shares.of_cycles(dataset),
        "over_starts": over_starts.differing(dataset),
        "advice": _advice(dataset, told.get("kind", ""), left_out(settings)),
        "ranges": _ranges(dataset),
        **({"into_impacts": struck} if struck else {}),
        "beyond_small": small.passing(dataset),
        "each_point": each_point.each_point(dataset),
        **({"branches_begin": begin} if begin else {}),
        **({"branch_ends": ends} if ends else {}),
        "trust": {
            variable.name: _worst(dataset, variable)
            for variable in variables_in(dataset, Role.TRUST, Role.WORK)
            if _is_number(dataset, variable.name)
        },
        "over_laws": over_laws.spread(dataset),
        **({"scanned": scanned(dataset)} if "scan_class" in dataset else {}),
        **({"still_followed": still} if still else {}),
        **({"found_from_start": True} if found_from_start(dataset) else {}),
        **({"refined": described(dataset.attrs)} if described(dataset.attrs) else {}),
        **({"runs_the_rest": _runs_the_rest(dataset)} if "refined_of" in dataset.attrs else {}),
    }


def _runs_the_rest(dataset: xr.Dataset) -> str:
    """What to type to run also the points of a refined map that were filled in."""
    halved = [pair.rsplit(" ", 1)[0] for pair in dataset.attrs["refined_from"].split(", ")]
    every = in_full({dim: dataset[dim].values for dim in halved})
    return " ".join([dataset.attrs["history"], every, "-o THIS.nc"])


def _beginning(dataset: xr.Dataset, settings: Mapping[str, Any]) -> str:
    """The value of the parameter along which branches are followed at which they begin, if any."""
    name = (settings.get("parameter") or {}).get("name", "")
    if name not in dataset.coords or dataset[name].ndim:  # of joined runs each has its own
        return ""
    return f"{name} = {dataset[name].item():g}{_unit({'units': '1', **dataset[name].attrs})}"


def _grid_axes(dataset: xr.Dataset) -> list[str]:
    """Axes of the grid and ``initial``; not those of variables' own dims."""
    grid = set(dataset["status"].dims)
    return [n for n in select.axis_names(dataset) if select.axis_of(dataset, n).dims[0] in grid]


def _axis(dataset: xr.Dataset, name: str) -> dict[str, Any]:
    axis = select.axis_of(dataset, name)
    facts: dict[str, Any] = {"size": axis.size, "units": str(axis.attrs.get("units", "1"))}
    if select.is_numeric(axis):
        ends = {"first": float(axis.values[0]), "last": float(axis.values[-1])}
        steps = np.diff(axis.values)
        turns = not ((steps > 0.0).all() or (steps < 0.0).all())
        return facts | ends | ({"each": axis.values.tolist()} if turns else {})
    return {**facts, "values": [str(value) for value in axis.values]}


def _detailed(dataset: xr.Dataset) -> list[Variable]:
    """Classes that say how an answer was come by, one for each point: its section, for example."""
    grid, details = {*dataset["status"].dims}, variables_in(dataset, Role.DETAIL)
    return [
        one
        for one in details
        if flag_names(dataset[one.name].attrs) and {*dataset[one.name].dims} <= grid
    ]


def _counts(flag: xr.DataArray, grid_dims: int) -> dict[str, int]:
    """Class -> number of points, the most frequent first; classes that do not occur left out.

    Of a flag with dims of its own only what is there is counted, not what fills up its rows.
    """
    counted = {name: int((flag == code).sum()) for code, name in flag_names(flag.attrs).items()}
    if flag.ndim > grid_dims:
        counted.pop(NOT_COMPUTED, None)
    return dict(sorted(((n, c) for n, c in counted.items() if c), key=lambda item: -item[1]))


def _advice(dataset: xr.Dataset, kind: str, without: Sequence[str]) -> dict[str, str]:
    """Reason -> what it means and what to do, of those that occur, `without` what is left out."""
    counts = _counts(dataset["reason"], dataset["status"].ndim) if "reason" in dataset else {}
    known = (name for name in counts if name in REASON.codes and name != "none")
    options = json.loads(dataset.attrs.get("options_json", "{}"))
    return {name: advice(name, kind, [*options, *without]) for name in known}


def _is_number(dataset: xr.Dataset, name: str) -> bool:
    """Whether `name` is a variable of numbers, not of classes."""
    return (
        name in dataset.data_vars
        and not flag_names(dataset[name].attrs)
        and dataset[name].dtype.kind in "fiu"
    )


def _ranges(dataset: xr.Dataset) -> dict[str, dict[str, Any]]:
    """Least and greatest value of every variable of numbers that has any."""
    counts = {str(sizes.name) for sizes in select.ragged_dims(dataset).values()}
    counts |= {name.replace("_row_size", "_point") for name in counts}
    told = counts | {variable.name for variable in variables_in(dataset, Role.TRUST, Role.WORK)}
    names = [str(name) for name in dataset.data_vars if _is_number(dataset, str(name))]
    alone = dataset["status"].size == 1
    ranges = {name: _range(dataset[name], alone) for name in names if name not in told}
    return {
        name: span | _of_points(dataset, name, span["values"])
        for name, span in ranges.items()
        if span
    }


def _of_points(dataset: xr.Dataset, name: str, known: int) -> dict[str, int]:
    """Of how many points a number that leads has a value at some, if it lacks any."""
    status = dataset["status"]
    leads = named(name).headline > 0 and dataset[name].dims == status.dims
    return {"of": status.size} if leads and known < status.size else {}


def _range(variable: xr.DataArray, only_point: bool) -> dict[str, Any]:
    """Its ends; of the only point of a dataset each value, where they are few."""
    values = numbers(variable).values
    known = values[np.isfinite(values)]
    if known.size == 0:
        return {}
    few = only_point and np.ptp(known) > 0.0 and known.size == values.size <= MOST_NAMES
    return {
        "least": float(known.min()),
        "greatest": float(known.max()),
        "values": int(known.size),
        **({"each": known.ravel().tolist()} if few else {}),
        **({"sampled": True} if "time" in variable.dims else {}),
        "units": str(variable.attrs.get("units", "1")),
    }


def _into_impacts(dataset: xr.Dataset) -> dict[str, Any]:
    """The share of the drive's work that impacts take, if they take any."""
    for lost, given in IMPACTS_AND_DRIVE:
        if lost in dataset and given in dataset:
            share = _range(dataset[lost] / dataset[given].where(dataset[given] > 0.0), False)
            return {**share, "units": "1"} if share.get("greatest", 0.0) > 0.0 else {}
    return {}


def _worst(dataset: xr.Dataset, variable: Variable) -> dict[str, Any]:
    """The worst value and the point where it occurs; how many points that want it have none."""
    name = variable.name
    values = numbers(dataset[name])
    ragged = select.row_sizes(dataset, name)
    flat = np.abs(values.values.ravel())
    facts = _lacking(dataset, values) if name in OF_EVERY_MOTION else {}
    if not np.isfinite(flat).any():
        return facts
    place = int(np.nanargmin(flat) if variable.margin else np.nanargmax(flat))
    row = values if ragged is None else ragged
    index = place if ragged is None else int(select.row_of_each(ragged)[place])
    units = str(values.attrs.get("units", dataset[name].attrs.get("units", "1")))
    return {**facts, "worst": float(flat[place]), "at": point_name(row, index), "units": units}


def _lacking(dataset: xr.Dataset, values: xr.DataArray) -> dict[str, int]:
    """How many points whose motion went on to its end have no value, of how many; if any."""
    status = dataset["status"]
    if not set(values.dims) <= set(status.dims):
        return {}
    went_on = is_class(status, ("ok",)) & ~is_class(dataset.get("reason", status), WITHOUT_MOTION)
    without = int((went_on & values.isnull()).sum())
    return {"without": without, "of": int(went_on.sum())} if without else {}


def lines(summary: Mapping[str, Any]) -> list[str]:
    """The summary for people, a line each."""
    heading = [f"{key:<12} {summary[key]}" for key in GLOBAL if key in summary]
    parts = [line for name, part in summary["analyses"].items() for line in _part(name, part)]
    return [*heading, *parts]


def _part(name: str, part: Mapping[str, Any]) -> list[str]:
    dims = " x ".join(f"{dim} {size}" for dim, size in part["dims"].items()) or "one point"
    return [
        "",
        f"{name or 'points'}: {dims}",
        *(f"  {axis:<22} {_axis_line(facts)}" for axis, facts in part["axes"].items()),
        *_count_lines(part),
        *shares.lines(part["shares"]),
        *shares.lines_of_points(part["shares_at_each_point"]),
        *shares.lines_of_cycles(part["shares_of_cycles"]),
        *over_starts.lines(part["over_starts"]),
        *_range_lines(part["ranges"], _at_edges(part["counts"])),
        *([_impact_line(part["into_impacts"])] if "into_impacts" in part else []),
        *(f"  {line}" for line in small.lines(part["beyond_small"])),
        *each_point.lines(part, _units(part), prod(part["dims"].values())),
        *([f"  branches begin at {part['branches_begin']}"] if "branches_begin" in part else []),
        *each_point.lines_of_ends(part, _units(part)),
        *_scan_lines(part),
        *over_laws.lines(part["over_laws"]),
        *_trust_lines(part["trust"]),
        *([f"  refined {part['refined']}"] if "refined" in part else []),
        *([f"    runs the others: {part['runs_the_rest']}"] if "runs_the_rest" in part else []),
    ]


def _units(part: Mapping[str, Any]) -> dict[str, str]:
    told = {**part["axes"], **part["ranges"]}
    return {name: facts["units"] for name, facts in told.items() if "units" in facts}


def _scan_lines(part: Mapping[str, Any]) -> list[str]:
    """What was met along the brackets of a `boundary`."""
    told = part.get("scanned", {})
    rest = prod(part["dims"].values()) - len(told)
    lines = [f"    {f'{place}: ' if place else ''}{found}" for place, found in told.items()]
    more = [f"    and {rest} more brackets"] if rest else []
    beyond = [BEYOND] if part.get("found_from_start") else []
    remarks = [f"    {remark}" for remark in [*part.get("still_followed", ()), *beyond]]
    return ["  along the bracket:", *lines, *more, *remarks] if told else []


def _axis_line(axis: Mapping[str, Any]) -> str:
    if "values" in axis:
        names = axis["values"]
        listed = names if len(names) <= MOST_NAMES else [names[0], "...", names[-1]]
        return ", ".join(listed) + (f", {len(names)} values" if listed != names else "")
    if axis["size"] == 1:
        return f"{axis['first']:g}{_unit(axis)}"
    if "each" in axis and axis["size"] <= MOST_NAMES:
        return f"{', '.join(told_apart(axis['each']))}{_unit(axis)}"
    if "each" in axis:
        low, high = min(axis["each"]), max(axis["each"])
        return f"within {low:g} and {high:g}{_unit(axis)}, {axis['size']} values"
    return f"{axis['first']:g} to {axis['last']:g}{_unit(axis)}, {axis['size']} values"


def _count_lines(part: Mapping[str, Any]) -> list[str]:
    """The classes that occur; behind the reasons, what each of them means."""
    counts = {key: f"  {key:<22} {_count_line(n)}" for key, n in part["counts"].items() if n}
    filled = part["counts"].get("computed", {}).get("filled_in")
    for key in counts if filled else ():
        if part["refined"].startswith(f"along the borders of {key},"):
            counts[key] += f" (with the {filled} filled in)"
    meant = [f"    {name}: {sentence}" for name, sentence in part["advice"].items()]
    return [line for key in counts for line in (counts[key], *(meant if key == "reason" else []))]


def _count_line(counts: Mapping[str, int]) -> str:
    """How many points there are of each; of many, what share of them."""
    total = sum(counts.values())
    shares = {name: f" ({count / total:.1%})" * (total >= MANY) for name, count in counts.items()}
    several = len(counts) > 1
    return ", ".join(f"{name} {n}{shares[name] * several}" for name, n in counts.items())


def _at_edges(counts: Mapping[str, Mapping[str, int]]) -> dict[str, str]:
    """Where ends of branches and ranges are no more than an edge of what was looked at."""
    return {
        name.removesuffix("_kind"): f"at {kinds['bracket']} of {sum(kinds.values())} "
        * (len(kinds) > 1)
        for name, kinds in counts.items()
        if kinds.get("bracket")
    }


def _range_lines(ranges: Mapping[str, Mapping[str, Any]], at_edges: Mapping[str, str]) -> list[str]:
    """A line for each; one for a work that ranges alike at the section, and for terms that vanish.

    Terms are the powers and works of the balance of energy. The error of a single value follows it;
    so does that it is but an edge of the bracket, which `at_edges` names.
    """
    alone = {name: span for name, span in ranges.items() if span["values"] == 1}
    errors = {name: inf for name in alone if named(name).width}  # where none was found
    for error in (standard_error_of, error_of):
        errors |= {name: alone[error(name)]["least"] for name in alone if error(name) in alone}
    told = {
        name: _range_line(span, errors.get(name))
        + f" ({at_edges.get(name, '')}the bracket's edge: it may go on beyond)" * (name in at_edges)
        + (f" (at {span['values']} of {span['of']} points)" if "of" in span else "")
        for name, span in ranges.items()
    }
    terms = [name for name in told if name.endswith(("_work", "_power"))]
    alike = {name for name in terms if told.get(f"section_{name}") == told[name]}
    names = {
        name: f"{name}, section_{name}" if name in alike else name
        for name in told
        if name.removeprefix("section_") not in alike or name in alike
    }
    zero = [name for name in terms if name in names and told[name] == f"0{_unit(ranges[name])}"]
    left_out = {*zero, *map(error_of, errors)}
    lines = {n: f"  {names[n]:<22} {told[n]}" for n in names if n not in left_out}
    made = [n for n in lines if named(n).derived]
    return [
        *(line for n, line in lines.items() if n not in made),
        *([f"  {'0 throughout':<22} {', '.join(names[n] for n in zero)}"] if zero else []),
        *(["  made of these by fiv (api.read), in no file:"] if made else []),
        *(f"  {lines[n]}" for n in made),
    ]


def _range_line(span: Mapping[str, Any], error: float | None) -> str:
    if "each" in span:
        return ", ".join(f"{value:.6g}" for value in span["each"]) + _unit(span)
    least, greatest = (with_error(span[end], error) for end in ("least", "greatest"))
    of_samples = " (of its samples)" if "sampled" in span else ""
    return (least if least == greatest else f"{least} to {greatest}") + _unit(span) + of_samples


def _impact_line(share: Mapping[str, Any]) -> str:
    return f"  {'into impacts':<22} {_range_line(share, None)} of the drive's work"


def _trust_lines(trust: Mapping[str, Mapping[str, Any]]) -> list[str]:
    worst = {name: facts for name, facts in trust.items() if facts}
    if not worst:
        return []
    return ["  trust, worst values:", *(_trust_line(name, facts) for name, facts in worst.items())]


def _trust_line(name: str, worst: Mapping[str, Any]) -> str:
    parts = []
    if "worst" in worst:
        place = f" at {worst['at']}" if worst["at"] else ""
        parts = [f"{worst['worst']:.6g}{_unit(worst)}{place}"]
    if "without" in worst:
        parts.append(f"no number at {worst['without']} of {worst['of']} points: mistrust them")
    return f"    {name:<20} {', '.join(parts)}"


def _unit(facts: Mapping[str, Any]) -> str:
    return "" if facts["units"] == "1" else f" {facts['units']}"
