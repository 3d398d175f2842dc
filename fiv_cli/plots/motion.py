"""Motions of a history, one at a time: what the figures over time have in common."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from fiv_cli.errors import UsageError
from fiv_cli.plots import points
from fiv_cli.reading import select
from fiv_cli.reading.datasets import flag_names

if TYPE_CHECKING:
    import xarray as xr

MOST_MOTIONS = 4
MOST_OVERLAID = 20
CONTACT_STATES = ("slip+", "slip-", "stick", "separation")


@dataclass(frozen=True)
class Event:
    """A transition: instant, s; contact, from 1; contact states before and after."""

    time: float
    contact: int
    before: str
    after: str


@dataclass(frozen=True)
class Motion:
    """One motion: `label` names what tells it from the others; `time` in s, without padding."""

    label: str
    time: np.ndarray
    data: xr.Dataset
    events: tuple[Event, ...]


def suits(dataset: xr.Dataset) -> bool:
    """Whether the dataset holds motions in time."""
    return "time" in dataset.variables and "contact_state" in dataset


def refuse_without(dataset: xr.Dataset) -> None:
    """UsageError where the dataset holds no motion in time."""
    if not suits(dataset):
        raise UsageError(
            "no motion in time in this dataset\n"
            "compute one with: fiv history CASE --at AXIS=VALUE,initial=LABEL"
        )


def motions(dataset: xr.Dataset, settings: points.Settings) -> list[Motion]:
    """Every motion of the dataset, over the figure's ``window`` of time.

    Raises
    ------
    UsageError : it holds none, or more than a figure can show
    """
    refuse_without(dataset)
    lines = points.lines(dataset, [], points.grid_dims(dataset))
    if len(lines) > (MOST_OVERLAID if settings.get("overlay") else MOST_MOTIONS):
        axes = ", ".join(str(axis.name) for axis in points.varying_axes(dataset))
        raise UsageError(
            f"{len(lines)} motions in one figure are too many\n"
            f"choose from {axes} with `select` in the figure"
        )
    begin, end = (points.in_si(bound) for bound in settings.get("window", (-np.inf, np.inf)))
    return [_motion(dataset, line, begin, end) for line in lines]


def _motion(dataset: xr.Dataset, line: points.Line, begin: float, end: float) -> Motion:
    data = dataset.isel(line.index)
    time = data["time"].values
    known = np.isfinite(time) & np.isfinite(data[displacements(dataset)[0]].values)
    known &= (begin <= time) & (time <= end)
    ledger = tuple(_events(dataset, line, begin, end))
    return Motion(line.label, time[known], data.isel(time=np.flatnonzero(known)), ledger)


def _events(dataset: xr.Dataset, line: points.Line, begin: float, end: float) -> Iterator[Event]:
    """The events of one motion between two instants; nothing where the dataset keeps none."""
    columns = [f"event_{of}" for of in ("time", "contact", "from", "to")]
    if not all(name in dataset for name in columns):
        return
    sizes = select.row_sizes(dataset, "event_to")
    assert sizes is not None  # the ledger is ragged by its definition
    row = np.ravel_multi_index([line.index[str(d)] for d in sizes.dims], sizes.shape)
    times = dataset["event_time"].values
    mine = (select.row_of_each(sizes) == row) & (begin < times) & (times < end)
    before, after = (flag_names(dataset[f"event_{end}"].attrs) for end in ("from", "to"))
    for time, contact, from_, to in zip(*(dataset[c].values[mine] for c in columns), strict=True):
        yield Event(float(time), int(contact), before[int(from_)], after[int(to)])


def displacements(dataset: xr.Dataset) -> list[str]:
    """The displacement states: those that have a velocity ``NAME_dot`` beside them."""
    return [str(name) for name in dataset.data_vars if f"{name}_dot" in dataset]


def variables(dataset: xr.Dataset, settings: points.Settings) -> list[str]:
    """The variables that the figure names, else every displacement.

    Raises
    ------
    UsageError : a variable does not exist
    """
    named = points.variables(settings, displacements(dataset))
    return [known_variable(dataset, name) for name in named]


def known_variable(dataset: xr.Dataset, name: str) -> str:
    """`name`, when it varies in time; UsageError otherwise."""
    if name not in dataset or "time" not in dataset[name].dims:
        known = [str(n) for n, v in dataset.data_vars.items() if "time" in v.dims]
        raise UsageError(f"{name}: no variable over time\nthere are: {', '.join(known)}")
    return name


def of_contact(array: xr.DataArray, settings: points.Settings) -> np.ndarray:
    """Values over time; of the figure's ``contact`` (from 1) where there are several."""
    if "contact" not in array.dims:
        return array.values
    number = int(settings.get("contact", 1))
    if not 1 <= number <= array.sizes["contact"]:
        raise UsageError(f"contact = {number}: there are {array.sizes['contact']}")
    return array.isel(contact=number - 1).values


def places(motion: Motion) -> list[str]:
    """Where the points of the disc are that the motion is given at."""
    radii, angles = motion.data["point_radius"].values, motion.data["point_angle"].values
    return [rf"$r$ = {r:g} m, $\theta$ = {a:.4g} rad" for r, a in zip(radii, angles, strict=True)]


def contact_runs(motion: Motion, settings: points.Settings) -> Iterator[tuple[str, int, int]]:
    """(contact state, first sample, last sample + 1) of each stretch without a transition."""
    states = motion.data["contact_state"]
    names = flag_names(states.attrs)
    codes = of_contact(states, settings)
    if codes.size == 0:
        return
    starts = [0, *(np.flatnonzero(np.diff(codes)) + 1).tolist()]
    for first, last in zip(starts, [*starts[1:], codes.size], strict=True):
        yield names.get(int(codes[first]), "unknown"), first, last


def contact_spans(motion: Motion, settings: points.Settings) -> Iterator[tuple[str, float, float]]:
    """(contact state, begin, end in s): from the event ledger, else between samples.

    None of a motion without a known sample, whatever its ledger holds.
    """
    contact = int(settings.get("contact", 1))
    events = [event for event in motion.events if event.contact == contact]
    if not events or not motion.time.size:
        for state, first, last in contact_runs(motion, settings):
            # a stretch reaches to the sample after it, where the next one begins
            yield state, motion.time[first], motion.time[min(last, motion.time.size - 1)]
        return
    changes = [event for event in events if event.before != event.after]  # bounces change nothing
    borders = [motion.time[0], *(event.time for event in changes), motion.time[-1]]
    states = [events[0].before, *(event.after for event in changes)]
    yield from zip(states, borders[:-1], borders[1:], strict=True)


def states_present(every: Sequence[Motion], settings: points.Settings) -> list[str]:
    """The contact states that occur, in their fixed order."""
    seen = {name for motion in every for name, _, _ in contact_spans(motion, settings)}
    return [name for name in CONTACT_STATES if name in seen]
