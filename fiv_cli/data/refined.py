"""The dataset of a refined analysis: classes filled in, and what says which points were run."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fiv_cli.analyses.variables import COMPUTED as RUN
from fiv_cli.case.report import dotted
from fiv_cli.data.dataset import Dataset, Labelled
from fiv_cli.flags import COMPUTED, NOT_COMPUTED, STATUS, reason_code

EVEN = 1e-9  # relative distance of an axis from one that is evenly spaced, at most
_SAMPLED = [COMPUTED.codes["sampled"], COMPUTED.codes["sampled_and_mislabelled"]]


def fill_in(dataset: Dataset, of: str, classes: NDArray[Any], origins: NDArray[np.int8]) -> Dataset:
    """The dataset with the class of points that were not run.

    Only that class is given; the status of such a point is ``not_computed``, its reason
    ``filled_in``, and all numbers are missing.

    Parameters
    ----------
    dataset : as assembled
    of : the variable that holds the class
    classes : (size,) class of each point
    origins : (size,) codes of `flags.COMPUTED`
    """
    from fiv_cli.data.assemble import attributes_of

    points = dataset.variables["status"]
    filled = (origins == COMPUTED.codes["filled_in"]).reshape(points.values.shape)
    which = origins.reshape(filled.shape)
    changed = {RUN.name: Labelled(points.dims, which, attributes_of(RUN))}
    for name, value in (
        (of, classes.reshape(filled.shape)),
        ("status", STATUS.codes[NOT_COMPUTED]),
        ("reason", reason_code("filled_in")),
    ):
        known = dataset.variables[name]
        values = np.where(filled, value, known.values).astype(known.dtype)
        changed[name] = replace(known, values=values)
    return dataset.assign(changed)


def refinement_attributes(
    of: str, levels: int, coarse: Mapping[str, int], origins: NDArray[np.int8]
) -> dict[str, object]:
    """What a reader must know of a refined dataset.

    Parameters
    ----------
    coarse : dim -> points of the grid that was halved
    """
    tested = int(np.isin(origins, _SAMPLED).sum())
    wrong = int((origins == COMPUTED.codes["sampled_and_mislabelled"]).sum())
    attributes = {
        "refined_of": of,
        "refined_levels": levels,
        "refined_from": ", ".join(f"{dim} {count}" for dim, count in coarse.items()),
        "points_run": int((origins > 0).sum()),
        "points_filled_in": int((origins == COMPUTED.codes["filled_in"]).sum()),
        "sample_size": tested,
        "sample_mislabelled": wrong,
    }
    return attributes | ({"mislabelled_share": wrong / tested} if tested else {})


def described(attributes: Mapping[str, Any]) -> str:
    """The attributes of a refined dataset in a sentence; empty for any other."""
    if "refined_of" not in attributes:
        return ""
    run, filled = int(attributes["points_run"]), int(attributes["points_filled_in"])
    levels = int(attributes["refined_levels"])
    tested, wrong = int(attributes["sample_size"]), int(attributes["sample_mislabelled"])
    sampled = f"of {tested} filled in and run all the same, {wrong} mislabelled"
    share = f" ({wrong / tested:.1%})" if tested else ""
    return (
        f"along the borders of {attributes['refined_of']}, {attributes['refined_from']} halved "
        f"{levels} time{'s' * (levels != 1)}: {run} of {run + filled} points run "
        f"({run / max(run + filled, 1):.1%}); {sampled}{share}"
    )


def in_full(axes: Mapping[str, Sequence[float] | np.ndarray]) -> str:
    """What runs every point of a refined map, as words of a command: by its axes, halved."""
    own = (
        f"--set '{dotted(('grid', name))}={_as_grid(np.asarray(values))}'"
        for name, values in axes.items()
    )
    return " ".join(["--set 'sweep={}'", *own])


def _as_grid(values: np.ndarray) -> str:
    """An axis as a case gives it: evenly spaced, so on a logarithmic scale, or a list."""
    first, last, size = float(values[0]), float(values[-1]), len(values)
    ends = f"start = {first}, stop = {last}, num = {size}"
    if np.allclose(values, np.linspace(first, last, size), rtol=EVEN, atol=0.0):
        return f"{{ {ends} }}"
    if first > 0.0 and np.allclose(values, np.geomspace(first, last, size), rtol=EVEN, atol=0.0):
        return f'{{ {ends}, scale = "log" }}'
    return f"{values.tolist()}"
