"""What a `boundary` analysis found along each bracket, in a line."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from itertools import groupby
from typing import TYPE_CHECKING, Any

import numpy as np

from fiv_cli.analyses.base import Question
from fiv_cli.flags import ATTRACTOR
from fiv_cli.notation.amounts import with_error
from fiv_cli.reading.claims import BY_EIGENVALUES, beside, point_name, wider_than_asked
from fiv_cli.reading.datasets import class_names, is_class

if TYPE_CHECKING:
    import xarray as xr

# Brackets that are told of; of more, only the first.
MOST_BRACKETS = 8

BEYOND = (
    "every run began at the start, whose answer changes here; a motion may go on beyond, to where "
    'follow = "up", "down" or "both" finds its end'
)

WIDEN, PERHAPS = ": widen it", ", and perhaps beyond; what was found inside it stands"
UNMET = (
    ": what is asked for was not met inside it: a start in its basin (a `state`, say) meets it, or "
    "a bracket that is wider at either end"
)

# Setting `follow` -> the classes along each way, which of them is the last, at which end.
_ENDS = {
    "up": (("scan_class", -1, "upper"),),
    "down": (("scan_class", 0, "lower"),),
    "both": (("scan_class", -1, "upper"), ("scan_class_back", 0, "lower")),
}
COARSE = "boundary_width is more than was asked for"
_GOING_ON = ("equilibrium", "periodic", "quasiperiodic", "chaotic")


def found_from_start(dataset: xr.Dataset) -> bool:
    """Whether a `boundary` has found changes between runs that began at the start."""
    return "found_going" in dataset and bool(is_class(dataset["found_going"], ("none",)).any())


def still_followed(dataset: xr.Dataset, settings: Mapping[str, Any]) -> list[str]:
    """What `still` says of a dataset, by its settings, and whether a change is found coarsely."""
    if "of" not in settings:
        return []
    classes = {
        name: dataset[name].transpose(..., "scan").values.reshape(-1, dataset.sizes["scan"])
        for name in ("scan_class", "scan_class_back")
        if name in dataset
    }
    crossings = dataset["n_crossings"].values.ravel()
    wide = wider_than_asked(dataset, settings, dataset["boundary_width"])
    coarse = f"{COARSE}; {BY_EIGENVALUES}; else {beside(dataset, wide)} lessens it"
    question = Question(**settings["of"])
    return [
        *still(question, settings["follow"], classes, crossings),
        *_of_its_time(dataset, question, settings["t_max"]),
        *([coarse] if bool(wide.any()) else []),
    ]


def _of_its_time(dataset: xr.Dataset, question: Question, t_max: float) -> Iterator[str]:
    """That a border of what was undecided in its time is one of that time."""
    sides = [is_class(dataset[f"class_{side}"], ("undecided",)) for side in ("below", "above")]
    count = int((sides[0] | sides[1]).sum())
    if question.counts and count:
        number = f"{count} changes are" if count > 1 else "a change is"
        yield (
            f"{number} between a class and undecided, which counts: where t_max = {t_max:g} s puts "
            "it; more time moves it further than its error says"
        )


def still(
    question: Question, follow: str, classes: Mapping[str, np.ndarray], crossings: np.ndarray
) -> list[str]:
    """Where what was followed is at an end of the bracket what it was throughout, or is asked for.

    Parameters
    ----------
    classes : ``scan_class``, and ``scan_class_back``: codes, shape (points, scan)
    crossings : changes that were found at each point
    """
    said = []
    for way, place, end in _ENDS.get(follow, ()):
        for name in _GOING_ON:
            asked = question.below is None and (name == question.name) != question.negated
            here = classes[way][:, place] == ATTRACTOR.codes[name]
            none = WIDEN if asked or question.below is not None else UNMET
            for found, what in ((crossings == 0, none), ((crossings > 0) & asked, PERHAPS)):
                count = int((here & found).sum())
                of = f" at {count} of {len(crossings)} points" if len(crossings) > 1 else ""
                said += [f"still {name} at the {end} end of the bracket{of}{what}"] * (count > 0)
    return said


def scanned(dataset: xr.Dataset) -> dict[str, str]:
    """Point -> the classes along its bracket, both ways where it was followed so; at most some."""
    if "scan_class" not in dataset:
        return {}
    points = dataset["status"]
    return {
        point_name(points, row): "; ".join(_told(dataset, row))
        for row in range(min(points.size, MOST_BRACKETS))
    }


def _told(dataset: xr.Dataset, row: int) -> Iterator[str]:
    scan = dataset["scan"].values
    yield _stretches(scan, class_names(_of(dataset, "scan_class", row)))
    if "scan_class_back" in dataset:
        yield f"back {_stretches(scan, class_names(_of(dataset, 'scan_class_back', row)))}"
        ends = (_ends(dataset, f"bistable_{end}", row) for end in ("low", "high"))
        yield from (f"bistable from {low} to {high}" for low, high in zip(*ends, strict=True))


def _ends(dataset: xr.Dataset, name: str, row: int) -> list[str]:
    """One end of each range, and what is there where no answer changes."""
    values = _of(dataset, name, row).values
    off = f"{name}_error"  # which, as kinds, datasets of 0.1.0 do not have
    errors = _of(dataset, off, row).values if off in dataset else [None] * values.size
    kind = f"{name}_kind"
    kinds = class_names(_of(dataset, kind, row)) if kind in dataset else [""] * values.size
    told = {"bracket": " (end of the bracket)", "undecided": " (undecided beyond)"}
    ends = zip(values, errors, kinds, strict=True)
    return [
        f"{with_error(value, error)}{told.get(kind, '')}"
        for value, error, kind in ends
        if np.isfinite(value)
    ]


def _of(dataset: xr.Dataset, name: str, row: int) -> xr.DataArray:
    """What a variable holds along its own dim at one point."""
    points = dataset["status"]
    place = np.unravel_index(row, points.shape) if points.ndim else ()
    return dataset[name].isel(dict(zip(points.dims, place, strict=True)))


def _stretches(scan: np.ndarray, classes: Iterable[str]) -> str:
    """``equilibrium from 0 to 5, periodic from 7.5 to 20``; of one class, that it holds."""
    found = [
        (name, [value for value, _ in members])
        for name, members in groupby(zip(scan, classes, strict=True), key=lambda one: one[1])
    ]
    if len(found) == 1:
        return f"{found[0][0]} throughout"
    return ", ".join(f"{name} {_span(values)}" for name, values in found)


def _span(values: Sequence[float]) -> str:
    first, last = values[0], values[-1]
    return f"at {first:g}" if first == last else f"from {first:g} to {last:g}"
