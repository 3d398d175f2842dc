"""What shares of many starts reach each class and, of those drawn at random, how sure that is."""

from __future__ import annotations

import csv
import io
import json
from collections.abc import Container, Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from fiv_cli.errors import UsageError
from fiv_cli.flags import NOT_COMPUTED
from fiv_cli.notation.amounts import with_error
from fiv_cli.notation.tables import plain_table
from fiv_cli.reading.cycles import number_of_each, size_of_cycles, tolerance
from fiv_cli.reading.datasets import flag_names, is_class

if TYPE_CHECKING:
    import xarray as xr

ERROR = "standard_error"
FEWEST = 10  # starts of a table of which shares are told
MOST_CYCLES = 8  # that are told one by one
MOST_POINTS = 24  # at which shares are told one by one
SURE = 0.05  # chance with which what all of a sample, or none, show is told wrongly
Share = tuple[float, float, int]
"""A share of n starts drawn at random, its standard error, sqrt(p (1 - p) / n), and n.

Of the points of a lattice, and of a table, there is no such error: NaN.
"""


def shares(dataset: xr.Dataset) -> dict[str, Any]:
    """Label of random starts, of a table or a lattice, -> class -> its `Share` over the grid.

    That is the ``least`` and the ``greatest``.
    """
    return {
        label: {name: _ends(each) for name, each in _of_classes(reached, label in drawn).items()}
        for drawn in [_families(dataset)]
        for label, reached in (drawn | _counted(dataset)).items()
    }


def without_error(dataset: xr.Dataset) -> str:
    """What shares of random starts have no error, and how far they may be off."""
    sizes = [
        size
        for reached in _families(dataset).values()
        for each in _of_classes(reached, True).values()
        for share, _, size in each
        if share in (0.0, 1.0)
    ]
    if not sizes:
        return ""
    return (
        f"no {ERROR} at shares of 0 and 1, which no start contradicts: they are within "
        f"{most_missed(min(sizes)):.2g} at {1.0 - SURE:.0%}"
    )


def as_csv(dataset: xr.Dataset) -> str:
    """A row for each class that starts of one label reach at a point: its share, and the error.

    What all of a sample reach, or none, has no error: there is no scatter that would tell it.

    Raises
    ------
    UsageError : there are neither random starts, nor a table or a lattice of many
    """
    drawn = _families(dataset)
    every = drawn | _counted(dataset)
    if not every:
        raise UsageError(
            "no starts here of which shares would be told: random ones, a table of "
            f"{FEWEST} or more, or a lattice (axes initial.x)\n"
            "next: fiv kinds random, fiv kinds table, fiv kinds grid"
        )
    table = io.StringIO()
    writer = csv.writer(table, lineterminator="\n")
    axes = [str(n) for one in every.values() for n, axis in _axes(one).items() if axis.size > 1]
    axes = [*dict.fromkeys(axes)]
    writer.writerow(["initial", *axes, "class", "share", ERROR, "starts"])
    for label, reached in every.items():
        places = [_spread(_axes(reached)[n], _points(reached)) for n in axes]
        for name, each in _of_classes(reached, label in drawn).items():
            for *place, (share, error, size) in zip(*places, each, strict=True):
                told = error if error > 0.0 else ""
                writer.writerow([label, *place, name, share, told, size])
    return table.getvalue()


def _points(reached: xr.DataArray) -> xr.DataArray:
    """The points of the grid from each of which starts begin."""
    return reached.isel(initial=0, drop=True)


def _axes(reached: xr.DataArray) -> dict[str, xr.DataArray]:
    return {str(name): axis for name, axis in _points(reached).coords.items()}


def at_each_point(dataset: xr.Dataset) -> dict[str, list[dict[str, Any]]]:
    """The same label -> name -> value of the axes and, of each class, its `Share`.

    Of a few points: there is a row for each.
    """
    rows, drawn = {}, _families(dataset)
    for label, reached in (drawn | _counted(dataset)).items():
        points = _points(reached)
        if 1 < points.size <= MOST_POINTS:
            axes = {n: axis for n, axis in _axes(reached).items() if axis.size > 1}
            columns = {n: _spread(axis, points) for n, axis in axes.items()}
            columns |= _of_classes(reached, label in drawn)
            rows[label] = [
                dict(zip(columns, row, strict=True))
                for row in zip(*columns.values(), strict=True)
                if all(map(_is_known, row))
            ]
    return rows


def of_cycles(dataset: xr.Dataset) -> dict[str, list[dict[str, Any]]]:
    """Label of random starts -> value of the axes, and of each of several cycles its `Share`.

    Its ``period``, s, stands beside. Of a few points, as `at_each_point`, where there are several.
    """
    rows: dict[str, list[dict[str, Any]]] = {}
    for label, reached in _families(dataset).items():
        family = dataset.sel(initial=reached["initial"])
        points = _points(reached)
        for place in range(points.size if points.size <= MOST_POINTS else 0):
            index = dict(zip(points.dims, np.unravel_index(place, points.shape), strict=True))
            one = family.isel(index)
            axes = {str(n): one[n].item() for n, axis in points.coords.items() if axis.size > 1}
            rows.setdefault(label, []).extend(axes | cycle for cycle in _cycles(one))
    return {label: found for label, found in rows.items() if found}


def _cycles(part: xr.Dataset) -> Iterator[dict[str, Any]]:
    """Of each cycle that starts of one point reach; nothing of one alone, nor of many."""
    sizes = size_of_cycles(part[[n for n in part if part[n].dims == ("initial",)]]).values
    number = number_of_each(sizes[np.isfinite(sizes)], tolerance(part))
    if not 0 < number.max(initial=0) < MOST_CYCLES or "period" not in part:
        return
    total = int((~is_class(part["attractor"], (NOT_COMPUTED,))).sum())
    for one, count in enumerate(np.bincount(number).tolist()):
        period = part["period"].values[np.isfinite(sizes)][number == one][0]
        share = count / total
        yield {"period": float(period), "share": (share, standard_error(share, total), total)}


def _is_known(value: Any) -> bool:
    """Whether it is no share of nothing."""
    return not isinstance(value, tuple) or value[2] > 0


def _spread(axis: xr.DataArray, points: xr.DataArray) -> list[Any]:
    """The value of an axis at each point."""
    return list(axis.broadcast_like(points).transpose(*points.dims).values.ravel().tolist())


def _families(dataset: xr.Dataset, kind: str = "random") -> dict[str, xr.DataArray]:
    """Label of starts of a kind, of which there are many -> the classes that they reach,
    ``initial`` last."""
    if "attractor" not in dataset or "initial" not in dataset.coords:
        return {}
    families = [family_of(label) for label in dataset["initial"].values]
    labels = labels_of(dataset, kind)
    members = {label: np.flatnonzero([f == label for f in families]) for label in labels}
    reached = dataset["attractor"].transpose(..., "initial")
    return {label: reached.isel(initial=own) for label, own in members.items() if own.size}


def _counted(dataset: xr.Dataset) -> dict[str, xr.DataArray]:
    """The same of starts that are no sample: each of them counts alike."""
    tables = _families(dataset, "table").items()
    return _lattices(dataset) | {k: own for k, own in tables if own.sizes["initial"] >= FEWEST}


def _lattices(dataset: xr.Dataset) -> dict[str, xr.DataArray]:
    """Label of starts that are laid out along axes (``initial.x``) -> the same."""
    reached = dataset.get("attractor")
    axes = [] if reached is None else [d for d in reached.dims if str(d).startswith("initial_")]
    if reached is None or not axes or "initial" not in reached.coords:
        return {}
    return {
        str(label): reached.sel(initial=label, drop=True).stack(initial=axes, create_index=False)
        for label in reached["initial"].values
        if family_of(label) not in drawn_of(dataset)
    }


def with_standard_error(
    shares: xr.Dataset, taken_of: xr.Dataset, take: Mapping[str, Any], drawn: Container[str]
) -> xr.Dataset:
    """What was taken, with the error of the sample if it is a share of random starts alone.

    Parameters
    ----------
    shares : what was taken of `taken_of`, as `take` says
    drawn : labels of the starts that are random
    """
    if take["what"] != "share" or [*take["over"]] != ["initial"] or take.get("relative_to"):
        return shares
    if not is_sample(taken_of, drawn):
        return shares
    # of what lies between two ends, as starts are undecided, the greatest: it rises up to one half
    ends, size = (shares["share_low"], shares["share_high"]), taken_of.sizes.get("initial", 1)
    dearest = np.clip(0.5, *ends)
    return shares.assign({ERROR: standard_error(dearest, size).assign_attrs(starts=size)})


def standard_error(share: Any, size: Any) -> Any:
    """That of a share of so many starts drawn at random; numbers, or arrays of them."""
    return (share * (1.0 - share) / size) ** 0.5


def sampling_error(shares: xr.Dataset) -> xr.DataArray:
    """How far shares of a sample may be off: the standard error, or what none and all may hide."""
    error, low, high = shares[ERROR], shares["share_low"], shares["share_high"]
    hidden = most_missed(error.attrs["starts"])
    for bound in ((hidden - high).where(low == 0.0, 0.0), (hidden - 1.0 + low).where(high == 1.0)):
        error = error.where(~(bound > error), bound)
    return error


def most_missed(size: int) -> float:
    """The greatest share of which so many starts show none; all but it are theirs if all do."""
    return float(1.0 - SURE ** (1.0 / size))


def drawn_of(dataset: xr.Dataset) -> list[str]:
    """Labels of the random starts of the case of a dataset; 0.1.0 did not tell them."""
    return labels_of(dataset, "random")


def labels_of(dataset: xr.Dataset, kind: str) -> list[str]:
    """Labels of the starts of a kind."""
    kinds = json.loads(dataset.attrs.get("starts_json", "{}"))
    return [label for label, own in kinds.items() if own == kind]


def family_of(label: Any) -> str:
    """The label of the random starts that one of them belongs to."""
    return str(label).rpartition("-")[0]


def is_sample(dataset: xr.Dataset, drawn: Container[str]) -> bool:
    """Whether all starts of a dataset are random: shares of others have no standard error."""
    return all(family_of(label) in drawn for label in dataset["initial"].values)


def _of_classes(reached: xr.DataArray, is_drawn: bool) -> dict[str, list[Share]]:
    """Class that occurs -> its share at each point of the grid."""
    count = (~is_class(reached, (NOT_COMPUTED,))).sum("initial")
    found = {}
    for code, name in flag_names(reached.attrs).items():
        share = ((reached == code).sum("initial") / count.where(count > 0)).values.ravel()
        if name != NOT_COMPUTED and np.nanmax(share, initial=0.0) > 0.0:
            sizes = count.values.ravel()
            errors = standard_error(share, sizes) if is_drawn else share * np.nan
            columns = (share, errors, sizes)
            found[name] = [*zip(*(column.tolist() for column in columns), strict=True)]
    return found


def _ends(each: Sequence[Share]) -> dict[str, Share]:
    """The least and the greatest of some, of which one at least is known."""
    known = sorted(share for share in each if share[-1] > 0)
    return {"least": known[0], "greatest": known[-1]}


def lines(told: Mapping[str, Mapping[str, Mapping[str, Share]]]) -> list[str]:
    """The same for people, a line for each label."""
    spans = {
        label: ", ".join(f"{name} {_span(**ends)}" for name, ends in classes.items())
        for label, classes in told.items()
        if classes
    }
    return [
        f"  {f'shares of {label}':<22} {span}" + "; ± standard error" * ("±" in span)
        for label, span in spans.items()
    ]


def lines_of_points(told: Mapping[str, Sequence[Mapping[str, Any]]]) -> list[str]:
    """The same of each point, a table for each label."""
    lines = []
    for label, rows in told.items():
        cells = [[_cell(value) for value in row.values()] for row in rows]
        lines += [f"  shares of {label} at each point:"]
        lines += [f"    {line}" for line in plain_table([*rows[0]], cells)]
    return lines


def lines_of_cycles(told: Mapping[str, Sequence[Mapping[str, Any]]]) -> list[str]:
    """The same of each of several cycles."""
    lines = []
    for label, rows in told.items():
        heads = ["period (s)" if name == "period" else name for name in rows[0]]
        cells = [[_cell(value) for value in row.values()] for row in rows]
        lines += [f"  shares of {label}, cycle by cycle, where there are several:"]
        lines += [f"    {line}" for line in plain_table(heads, cells)]
    return lines


def _cell(value: Any) -> str:
    if isinstance(value, tuple):
        return _shown(value)
    return f"{value:g}" if isinstance(value, float) else str(value)


def _span(least: Share, greatest: Share) -> str:
    return " to ".join(dict.fromkeys(map(_shown, (least, greatest))))


def _shown(share: Share) -> str:
    """``0.6215 ± 0.0034``; of a sample that is all alike, how far that may be off."""
    found, error, size = share
    if np.isnan(error):
        return f"{found:.5g}"
    if error > 0.0:
        return with_error(found, error)
    missed = most_missed(size)
    bound = f"at least {1.0 - missed:.3f}" if found else f"at most {missed:.1g}"
    return f"{found:g} ({'all' if found else 'none'} of {size}: {bound} at {1.0 - SURE:.0%})"
