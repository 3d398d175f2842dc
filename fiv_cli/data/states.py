"""Arrays over the dim ``state`` where an axis of the grid decides which states there are."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from fiv_cli.analyses.base import Outcome
from fiv_cli.analyses.variables import Variable, motions
from fiv_cli.models.base import Model, Options

STATE = "state"


def on_all_states(
    outcome: Outcome, model: Model, own: Options, every: Options, variables: Sequence[Variable]
) -> Outcome:
    """`outcome` with its arrays over ``state`` spread over the states of the dataset.

    Parameters
    ----------
    own : options of the point, under which the outcome was computed
    every : options under which the model has the states of every point
    variables : the variables of the analysis

    Returns
    -------
    the same outcome where both have the same states; NaN stands for a state that it lacks
    """
    states, wanted = model.states(own), model.states(every)
    if states == wanted:
        return outcome
    shared = {v.name: v.dims.index(STATE) for v in variables if STATE in v.dims}
    names, all_names = ([name for name, *_ in motions(table)] for table in (states, wanted))
    spread = {
        name: _spread(np.asarray(outcome.values[name], float), axis, names, all_names)
        for name, axis in shared.items()
        if name in outcome.values
    }
    return replace(outcome, values={**outcome.values, **spread})


def _spread(array: np.ndarray, axis: int, own: Sequence[str], every: Sequence[str]) -> np.ndarray:
    """`array` over `own` names along `axis`, displacements or all, as one over `every`."""
    size = len(every) * array.shape[axis] // len(own)
    places: Mapping[str, int] = {name: place for place, name in enumerate(every)}
    along_last = np.moveaxis(array, axis, -1)
    result = np.full((*along_last.shape[:-1], size), np.nan)
    result[..., [places[name] for name in own[: array.shape[axis]]]] = along_last
    return np.moveaxis(result, -1, axis)
