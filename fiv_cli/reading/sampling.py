"""Whether the samples of a motion follow it, or are too few for a curve through them."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    import xarray as xr

MISSED = 0.1  # of the way gone at the usual speed: the trapezoid misses more over a coarse interval
TOO_MANY = 0.5  # share of such intervals in one of the parts; that of four samples a period
PARTS, FEWEST = 10, 20  # parts into which a motion is divided, of as many intervals at least
APART, TORN, FEWEST_EVENTS = 0.05, 0.1, 5  # of the extent; share of events in one of the parts
SAMPLES_A_PERIOD = 40.0
STILL = 1e-9  # of the greatest displacement: one that changes by no more rests


def displacements(dataset: xr.Dataset) -> list[str]:
    """The displacement states: those that have a velocity ``NAME_dot`` beside them."""
    return [str(name) for name in dataset.data_vars if f"{name}_dot" in dataset]


def is_coarse(motion: xr.Dataset, name: str = "", instants: np.ndarray | None = None) -> bool:
    """Whether a variable, over the dim ``time``, moves between its samples as they do not tell.

    Where they follow it, a displacement changes by what the velocities at both ends make of the
    time, no two events lie between them, and to an event the samples before it lead as those after
    it do. What is no displacement, nor a velocity, moves as all of them do; so does all, unnamed.

    Parameters
    ----------
    instants : of the events, s; None: all that the dataset has
    """
    time, known = motion["time"].values, displacements(motion)
    if instants is None:
        instants = np.ravel(motion["event_time"].values) if "event_time" in motion else np.empty(0)
    own = [one for one in known if name in (one, f"{one}_dot")]
    if time.size <= 2:
        return False
    inside = np.unique(instants[(time[0] < instants) & (instants < time[-1])])
    states = (_states(motion, one) for one in own or known if not _rests(motion[one].values))
    return any(_is_missed(time, *one, inside) or _is_torn(time, *one, inside) for one in states)


def is_at_rest(motion: xr.Dataset) -> bool:
    """Whether no displacement moves by more than rounding."""
    return all(_rests(motion[name].values) for name in displacements(motion))


def _rests(x: np.ndarray) -> bool:
    return bool(np.nanmax(x) - np.nanmin(x) <= STILL * np.nanmax(np.abs(x)))


def _states(motion: xr.Dataset, name: str) -> tuple[np.ndarray, np.ndarray]:
    return motion[name].values, motion[f"{name}_dot"].values


def _is_missed(time: np.ndarray, x: np.ndarray, speed: np.ndarray, instants: np.ndarray) -> bool:
    span, usual = np.diff(time), np.sqrt(np.nanmean(speed**2))
    events, _ = np.histogram(instants, time)
    strays = np.abs(np.diff(x) - 0.5 * span * (speed[:-1] + speed[1:])) > MISSED * span * usual
    missed = np.where(events > 1, True, strays)[events != 1]  # at one event the way may bend
    return not missed.size or _is_often(missed, FEWEST, TOO_MANY)


def _is_torn(time: np.ndarray, x: np.ndarray, speed: np.ndarray, instants: np.ndarray) -> bool:
    before, after = (led_to(instants, time, x, side, speed) for side in (-1, 1))
    torn = np.abs(before - after) > APART * (np.nanmax(x) - np.nanmin(x))
    return bool(torn.size) and _is_often(torn, FEWEST_EVENTS, TORN)


def _is_often(held: np.ndarray, fewest: int, share: float) -> bool:
    """Whether it holds of more than a share of some part, of as many at least."""
    parts = np.array_split(held, min(PARTS, max(1, held.size // fewest)))
    return any(part.mean() > share for part in parts)


def led_to(
    instants: np.ndarray,
    time: np.ndarray,
    values: np.ndarray,
    side: int,
    rates: np.ndarray | None = None,
) -> np.ndarray:
    """Values at the instants of events as led there from the samples before (-1) or after (1) each.

    Along the parabola through the three nearest or, of what has known rates of change, along
    the rate. Fewer without an event between them make a line, or one value; where there is
    none, a line leads from the last sample before to the first after.
    """
    stretch = np.searchsorted(instants, time)  # between the same two events: the same number
    own = np.arange(instants.size) + (side > 0)
    near = np.searchsorted(time, instants, "right") - (side < 0)
    ahead = instants - time[near]
    if rates is None:
        second, third = (np.clip(near + n * side, 0, time.size - 1) for n in (1, 2))
        two, three = stretch[second] == own, (stretch[third] == own) & (third != second)
        line = _ratio(values[second] - values[near], time[second] - time[near], two)
        next_ = _ratio(values[third] - values[second], time[third] - time[second], three)
        bend = _ratio(next_ - line, time[third] - time[near], three)
        along = values[near] + line * ahead + bend * ahead * (instants - time[second])
    else:
        there = led_to(instants, time, rates, side)
        along = values[near] + 0.5 * (rates[near] + there) * ahead
    return np.where(stretch[near] == own, along, np.interp(instants, time, values))


def _ratio(above: np.ndarray, below: np.ndarray, known: np.ndarray) -> np.ndarray:
    """Divided differences; 0 where there is none."""
    known &= below != 0.0
    return np.where(known, above / np.where(known, below, 1.0), 0.0)


def enough(motion: xr.Dataset) -> float:
    """Interval of samples that follow a coarse motion, s: by the usual speeds over the extents."""
    rates = [0.0]
    for name in displacements(motion):
        x, speed = _states(motion, name)
        if np.nanstd(x) > 0.0:
            rates.append(float(np.sqrt(np.nanmean(speed**2)) / np.nanstd(x)))
    spacing = float(np.median(np.diff(motion["time"].values)))
    wanted = 2.0 * np.pi / (SAMPLES_A_PERIOD * max(rates)) if max(rates) else spacing
    return float(f"{min(wanted, spacing / 4.0):.1g}")


def remark(motion: xr.Dataset) -> str:
    """That samples are too few, and what to type; empty where they follow the motion."""
    if not is_coarse(motion):
        return ""
    spacing = float(np.median(np.diff(motion["time"].values)))
    return (
        f"samples {spacing:.3g} s apart are too few to follow this motion: figures show them as "
        f"points\nnext: the same with --sample {enough(motion):g}, or with --periods 3 --settled"
    )
