"""Motions of a history, one at a time: what the figures over time have in common."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
import xarray as xr
from matplotlib.lines import Line2D

from fiv_cli.case.identity import STEADY_STATE
from fiv_cli.errors import UsageError
from fiv_cli.flags import ENDED_EARLY, MOTION_OF_A_CYCLE
from fiv_cli.notation.names import listed, suggest
from fiv_cli.plots import labels, points
from fiv_cli.reading import sampling, select
from fiv_cli.reading.datasets import class_names, flag_names, is_class

MOST_MOTIONS = 4
MOST_OVERLAID = 20
# The contact states in their fixed order, and what they are called in legends.
CONTACT_STATES = {
    "slip+": r"slip+ ($v_\mathrm{rel} > 0$)",
    "slip-": r"slip$-$ ($v_\mathrm{rel} < 0$)",
    "stick": "stick",
    "separation": "separation",
}
STICKING = 1e-6  # of what changes on the other side of an event: where less does
CLOSE = 1e-9  # share of a motion: an event so near to its end is there
END: dict[str, Any] = {"marker": "X", "ms": 6.0, "color": "black", "mew": 0.0, "ls": "none"}
# Forces and powers jump where a contact changes; all else does so at an impact only.
JUMPING = ("N", "W")


@dataclass(frozen=True)
class Event:
    """A transition: instant, s; contact, from 1; contact states before and after."""

    time: float
    contact: int
    before: str
    after: str


@dataclass(frozen=True)
class Motion:
    """One motion: `label` names what tells it from the others; `time` in s, without padding.

    Its `events` are those between the first sample and the last; `end` is what it ended by before
    its time, if it did: "contact lost".
    A motion is drawn through its events too: each instant stands twice in `drawn_time`, for what is
    before and what is after it. What its samples do not follow is drawn as these alone.
    """

    label: str
    time: np.ndarray
    data: xr.Dataset
    events: tuple[Event, ...]
    end: str = ""

    @cached_property
    def instants(self) -> np.ndarray:
        """The instants of events, s, without repetition."""
        return np.unique([event.time for event in self.events])

    @cached_property
    def drawn_time(self) -> np.ndarray:
        """The samples and, twice, each instant, s; of one at the end what is before it."""
        whole = np.insert(self.time, *self._pairs(self.instants, self.instants))
        return whole[:-2] if self._ends_at_an_instant else whole

    @property
    def _ends_at_an_instant(self) -> bool:
        """Whether its last sample is what comes after an event there, as of whole periods."""
        close = CLOSE * np.ptp(self.time) if self.time.size else 0.0
        return bool(self.instants.size and self.time[-1] - self.instants[-1] <= close)

    def is_coarse(self, *names: str) -> bool:
        """Whether a curve through the samples of one of these variables would be invented."""
        return any(sampling.is_coarse(self.data, name, self.instants) for name in names)

    def _pairs(self, before: np.ndarray, after: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Where both values at each instant come among the samples, and these."""
        places = np.searchsorted(self.time, self.instants, "right")
        return np.repeat(places, 2), np.stack([before, after], axis=-1).reshape(-1)

    def _met(
        self, values: np.ndarray, before: np.ndarray, after: np.ndarray, fewest: int
    ) -> np.ndarray:
        """One value at each instant: beyond the samples beside it as far as both sides lead.

        The side on which less changes up to it, as in stick, knows it better; one of less than the
        `fewest` samples knows nothing. The sides of instants without a sample between them are
        those of all, and a line leads from one to the other where none sticks.
        """
        last = np.searchsorted(self.time, self.instants, "right") - 1
        first, final = np.searchsorted(last, last), np.searchsorted(last, last, "right") - 1
        counts = np.diff(last, prepend=-1, append=self.time.size - 1)
        few = counts[first] < fewest, counts[final + 1] < fewest
        before, after = before[first], after[final]
        beside = np.sort([values[last], values[last + 1]], axis=0)
        least, greatest = np.sort([before, after], axis=0)
        low, high = np.minimum(beside[0], greatest), np.maximum(beside[1], least)
        off = np.abs(before - values[last]), np.abs(after - values[last + 1])
        share = off[0] / np.maximum(off[0] + off[1], np.finfo(float).tiny)  # of what is after it
        share = np.where(few[0] == few[1], share, few[0])
        begin, end = self.instants[first], self.instants[final]
        line = (self.instants - begin) / np.where(begin < end, end - begin, 1.0)
        moving = np.minimum(*off) > STICKING * np.maximum(*off)  # on both sides
        share = np.where((begin < end) & moving & ~few[0] & ~few[1], line, share)
        met = np.clip(before + share * (after - before), low, high)
        return np.where(few[0] & few[1], np.interp(self.instants, self.time, values), met)

    def drawn(self, name: str, values: np.ndarray) -> np.ndarray:
        """Values of a variable over `drawn_time`.

        At an event those before and after it, each as the samples of its side lead there; one for
        both where the variable does not jump.
        """
        if not self.instants.size:
            return values
        before, after = self._sides(name, values)
        if self.data[name].attrs.get("units") in JUMPING:
            # friction has bounds: no value is drawn beyond those of samples
            bounds = np.nanmin(values), np.nanmax(values)
            before, after = np.clip(before, *bounds), np.clip(after, *bounds)
        whole = np.insert(values, *self._pairs(before, after))
        return whole[:-2] if self._ends_at_an_instant else whole

    def jumps(self, name: str, values: np.ndarray) -> np.ndarray:
        """How far a variable jumps at each of the instants, in its unit."""
        before, after = self._sides(name, values)
        return after - before

    def _sides(self, name: str, values: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Values before and after each of the instants."""
        rates = self.data[f"{name}_dot"].values if f"{name}_dot" in self.data else None
        before, after = (
            sampling.led_to(self.instants, self.time, values, side, rates) for side in (-1, 1)
        )
        if self.data[name].attrs.get("units") not in JUMPING:
            impacts = [e.time for e in self.events if e.before == "separation" and rates is None]
            fewest, jumps = 1 + (rates is None), np.isin(self.instants, impacts)
            met = self._met(values, before, after, fewest)
            before, after = np.where(jumps, before, met), np.where(jumps, after, met)
        return before, after


def suits(dataset: xr.Dataset) -> bool:
    """Whether the dataset holds motions in time."""
    return "time" in dataset.variables and "contact_state" in dataset


def what_it_is(dataset: xr.Dataset) -> str:
    """A motion, or a cycle: that which one has settled to, or one that is unstable."""
    reached = str(dataset.attrs.get(STEADY_STATE, ""))
    reached = "cycle" if reached == "periodic" else reached
    return reached if reached.endswith("cycle") else "motion"


def refuse_without(dataset: xr.Dataset) -> None:
    """UsageError where the dataset holds no motion in time."""
    if not suits(dataset):
        of_a_cycle = f"; {MOTION_OF_A_CYCLE}" * ("cycle_section" in dataset)
        raise UsageError(
            "no motion in time in this dataset\n"
            f"next: fiv history CASE --at AXIS=VALUE,initial=LABEL{of_a_cycle}"
        )


def motions(dataset: xr.Dataset, settings: points.Settings) -> list[Motion]:
    """Every motion of the dataset, over the figure's ``window`` of time.

    Raises
    ------
    UsageError : it holds none, or more than a figure can show
    EmptyFigureError : none has a sample in the window
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
    span = f" in the window from {begin:g} to {end:g} s" if "window" in settings else ""
    found = [_motion(dataset, line, begin, end) for line in lines]
    points.refuse_empty(dataset, any(motion.time.size for motion in found), f"time{span}")
    return found


def of_files(layers: Sequence[points.Layer], settings: points.Settings) -> list[Motion]:
    """The motions of all datasets: by their starts where these tell them apart, whatever the case,
    and the only cycle that is stable, or not, by that.

    Else by what their datasets are called too; so where a name was given to these.
    """
    found = [(layer, one) for layer in layers for one in motions(layer.dataset, settings)]
    starts = [
        str(one.data.coords.get("initial", xr.DataArray(one.label)).values) for _, one in found
    ]
    given = any(layer.dataset.attrs.get("called", layer.label) for layer in layers)
    by_start = all(one.label in ("", start) for (_, one), start in zip(found, starts, strict=True))
    if len(layers) > 1 and by_start and not given and len({*starts}) == len(starts):
        whats = [what_it_is(layer.dataset) for layer, _ in found]
        names = [
            start if what == "motion" or whats.count(what) > 1 else what
            for what, start in zip(whats, starts, strict=True)
        ]
        return [replace(one, label=name) for (_, one), name in zip(found, names, strict=True)]
    return [replace(one, label=points.joined(layer.label, one.label)) for layer, one in found]


def _motion(dataset: xr.Dataset, line: points.Line, begin: float, end: float) -> Motion:
    data = dataset.isel(line.index)
    time = data["time"].values
    known = np.isfinite(time) & np.isfinite(data[sampling.displacements(dataset)[0]].values)
    last = time[known].max(initial=-np.inf)
    known &= (begin <= time) & (time <= end)
    kept = time[known]
    ledger = tuple(_events(dataset, line, kept[0], kept[-1])) if kept.size else ()
    early = "reason" in data and is_class(data["reason"], ENDED_EARLY) and last in kept
    word = class_names(data["reason"]).item().replace("_", " ") if early else ""
    return Motion(line.label, kept, data.isel(time=np.flatnonzero(known)), ledger, word)


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


def variables(dataset: xr.Dataset, settings: points.Settings) -> list[str]:
    """The variables that the figure names, else every displacement.

    Raises
    ------
    UsageError : a variable does not exist
    """
    named = points.variables(settings, sampling.displacements(dataset))
    return [known_variable(dataset, name) for name in named]


def known_variable(dataset: xr.Dataset, name: str) -> str:
    """`name`, when it varies in time; UsageError otherwise."""
    refuse_without(dataset)
    if name not in dataset or "time" not in dataset[name].dims:
        known = [str(n) for n, v in dataset.data_vars.items() if "time" in v.dims]
        hint = suggest(name, known) or f"there are: {', '.join(known)}"
        raise UsageError(f"{name}: no variable over time\n{hint}")
    return name


def of_contact(array: xr.DataArray, settings: points.Settings) -> np.ndarray:
    """Values over time; of the figure's ``contact`` (from 1) where there are several."""
    if "contact" not in array.dims:
        return array.values
    number, known = _contact(array, settings), array["contact"].values.tolist()
    if number not in known:
        raise UsageError(f"contact = {number}: there are {', '.join(map(str, known))}")
    return array.sel(contact=number).values


def _contact(array: xr.DataArray, settings: points.Settings) -> int:
    """The number of the contact that is drawn: the figure's, else the one that colours are about,
    else the first that is selected."""
    known = np.atleast_1d(array["contact"].values) if "contact" in array.coords else [1]
    coloured = settings.get("coloured", known[0])
    selected = coloured if coloured in known else known[0]
    return int(np.atleast_1d(settings.get("contact", selected))[0])


def about_one_that_sticks(every: Sequence[Motion], settings: points.Settings) -> points.Settings:
    """The settings of a figure that is, where it names no contact, about the first that sticks."""
    for motion in every:
        states = motion.data["contact_state"]
        if "contact" in states.dims:
            others = [dim for dim in states.dims if dim != "contact"]
            sticks = is_class(states, ("stick",)).any(others)
            if sticks.any():
                return {
                    **settings,
                    "coloured": int(states["contact"].values[sticks.values.argmax()]),
                }
    return settings


def of_all_contacts(dataset: xr.Dataset, settings: points.Settings) -> points.Settings:
    """The settings of a figure of one contact, with all others after it where there are several."""
    states = dataset["contact_state"]
    if "contact" not in states.dims:
        return settings
    own = _contact(states, settings)
    others = [number for number in states["contact"].values.tolist() if number != own]
    return {**settings, "contact": [own, *others]}


def of_each_contact(
    dataset: xr.Dataset, name: str, settings: points.Settings
) -> list[points.Settings]:
    """The settings under which a variable is drawn: those of each contact where it has several.

    What is of none has the colours of the first that is asked for, and the sticks of the others; of
    all others where one is asked for.
    """
    if "contact" not in dataset[name].dims:
        one = np.size(settings.get("contact", [])) == 1
        return [of_all_contacts(dataset, settings) if one else settings]
    numbers = settings.get("contact", dataset[name]["contact"].values.tolist())
    return [{**settings, "contact": number} for number in np.atleast_1d(numbers).tolist()]


def label_of(array: xr.DataArray, settings: points.Settings) -> str:
    """Symbol and unit of a variable and, of a model of several contacts, which one it is of."""
    several = "contact" in array.dims
    of = f" of contact {_contact(array, settings)}" if several else ""
    return labels.short_label(array, of=of)


def places(motion: Motion) -> list[str]:
    """Where the points of the disc are that the motion is given at."""
    radii, angles = motion.data["point_radius"].values, motion.data["point_angle"].values
    return [rf"$r$ = {r:g} m, $\theta$ = {a:.4g} rad" for r, a in zip(radii, angles, strict=True)]


def contact_spans(motion: Motion, settings: points.Settings) -> Iterator[tuple[str, float, float]]:
    """(contact state, begin, end in s) of each stretch between two changes in the event ledger.

    None of a motion without a known sample, whatever its ledger holds.
    """
    if not motion.time.size:
        return
    sampled = motion.data["contact_state"]
    contact = _contact(sampled, settings)
    events = [event for event in motion.events if event.contact == contact]
    drawn = CONTACT_STATES.keys()  # the pieces of a law are not; and a bounce changes nothing
    changes = [e for e in events if e.before != e.after and {e.before, e.after} <= drawn]
    first = flag_names(sampled.attrs).get(int(of_contact(sampled, settings)[0]), "unknown")
    borders = [motion.time[0], *(event.time for event in changes), motion.time[-1]]
    states = [changes[0].before if changes else first, *(event.after for event in changes)]
    for state, begin, end in zip(states, borders[:-1], borders[1:], strict=True):
        if end - begin > CLOSE * np.ptp(motion.time):
            yield state, begin, end


def sampled(every: Sequence[Motion], names: Sequence[str], what: str = "samples") -> list[Line2D]:
    """Legend entry of variables of which the samples alone are drawn, if there are any."""
    label = f"{what}, too few for a curve"
    points = Line2D([], [], color="black", marker=".", ls="none", label=label)
    return [points] if any(one.is_coarse(*names) for one in every) else []


def ends(every: Sequence[Motion]) -> list[Line2D]:
    """Legend entries of what motions ended by before their time."""
    return [Line2D([], [], label=word, **END) for word in sorted({one.end for one in every} - {""})]


def states_present(every: Sequence[Motion], *settings: points.Settings) -> list[str]:
    """The contact states that occur under some settings, in their fixed order."""
    spans = (contact_spans(motion, own) for own in settings for motion in every)
    seen = {name for one in spans for name, _, _ in one}
    return [name for name in CONTACT_STATES if name in seen]


def other_sticks(motion: Motion, settings: points.Settings) -> Iterator[tuple[int, float, float]]:
    """(contact, begin, end in s) of each stick of a contact that the colours are not about.

    None of a panel that is about one; of several that its settings name the first is.
    """
    known = motion.data["contact_state"].coords.get("contact")
    if known is None or not known.ndim:
        return
    shown = _contact(motion.data["contact_state"], settings)
    asked = np.atleast_1d(settings.get("contact", known.values)).tolist()
    for contact in [number for number in asked if number != shown]:
        for state, begin, end in contact_spans(motion, {**settings, "contact": contact}):
            if state == "stick":
                yield contact, begin, end


def others_sticking(every: Sequence[Motion], *settings: points.Settings) -> list[int]:
    """The contacts that these sticks are of."""
    sticks = (other_sticks(motion, own) for own in settings for motion in every)
    return sorted({contact for one in sticks for contact, _, _ in one})


def sticking(contact: int) -> str:
    """What sticks of a contact are called."""
    return f"contact {contact} sticks"


def without_colours(
    dataset: xr.Dataset, asked: points.Settings, shown: Sequence[points.Settings]
) -> Iterator[str]:
    """What to do about contacts that are asked for, and whose slip no panel shows."""
    coloured = {_contact(dataset["contact_state"], own) for own in shown}
    for contact in np.atleast_1d(asked.get("contact", [])).tolist():
        if contact not in coloured:
            yield (
                f"contact {contact}: where it sticks is marked, and no panel has the colours of "
                'its slip; a variable that contacts have, such as "F_T", has a panel for each'
            )


def of_joint_stick(every: Sequence[Motion], names: Sequence[str]) -> Iterator[str]:
    """Which forces of contacts are not those of the motion alone, if any of them is drawn."""
    for one in every:
        assumed = str(one.data.attrs.get("assumed_of_contacts", ""))
        states = one.data["contact_state"]
        of_each = [n for n in names if "contact" in one.data[n].dims and n != states.name]
        if assumed and of_each and is_class(states, ("stick",)).all("contact").any():
            yield f"{listed(of_each)} where all contacts stick: {assumed}"
            return


def named_contact(dataset: xr.Dataset, *settings: points.Settings, of_each: bool = False) -> str:
    """Which contact the colours of panels are about, where there are several; each may have its
    own."""
    states = dataset["contact_state"]
    if "contact" not in states.dims:
        return ""
    first, *others = dict.fromkeys(_contact(states, own) for own in settings)
    if of_each and others:
        return "colours: the contact of each panel"
    return f"colours: contact {first}" + ", or that of the panel" * bool(others)
