"""Whether the samples of a motion follow it, or are too few for a curve through them."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    import xarray as xr

MISSED = 0.1  # of the way gone at the usual speed: the trapezoid misses more over a coarse interval
TOO_MANY = 0.5  # share of such intervals in one of the parts; that of four samples a period
PARTS, FEWEST = 10, 20  # parts into which a motion is divided, of as many intervals at least
SAMPLES_A_PERIOD = 40.0


def displacements(dataset: xr.Dataset) -> list[str]:
    """The displacement states: those that have a velocity ``NAME_dot`` beside them."""
    return [str(name) for name in dataset.data_vars if f"{name}_dot" in dataset]


def is_coarse(motion: xr.Dataset, name: str = "", instants: np.ndarray | None = None) -> bool:
    """Whether a variable, over the dim ``time``, moves between its samples as they do not tell.

    Where they follow it, a displacement changes by what the velocities at both ends make of the
    time, and no two events lie between them. What is no displacement, nor a velocity, moves as all
    of them do; so does all, unnamed.

    Parameters
    ----------
    instants : of the events, s; None: all that the dataset has
    """
    time, known = motion["time"].values, displacements(motion)
    if instants is None:
        instants = np.ravel(motion["event_time"].values) if "event_time" in motion else np.empty(0)
    own = [one for one in known if name in (one, f"{one}_dot")]
    states = (_states(motion, one) for one in own or known)
    return time.size > 2 and any(_is_missed(time, *one, instants) for one in states)


def _states(motion: xr.Dataset, name: str) -> tuple[np.ndarray, np.ndarray]:
    return motion[name].values, motion[f"{name}_dot"].values


def _is_missed(time: np.ndarray, x: np.ndarray, speed: np.ndarray, instants: np.ndarray) -> bool:
    span, usual = np.diff(time), np.sqrt(np.nanmean(speed**2))
    events, _ = np.histogram(np.unique(instants), time)
    strays = np.abs(np.diff(x) - 0.5 * span * (speed[:-1] + speed[1:])) > MISSED * span * usual
    missed = np.where(events > 1, True, strays)[events != 1]  # at one event the way may bend
    parts = np.array_split(missed, min(PARTS, max(1, missed.size // FEWEST)))
    return not missed.size or any(part.mean() > TOO_MANY for part in parts)


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
