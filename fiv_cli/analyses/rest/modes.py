"""Modes followed from one linearised system to a neighbouring one."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Complex = NDArray[np.complex128]
Order = NDArray[np.intp]

SHAPE = 0.1  # what a wholly different shape weighs against a change by the largest eigenvalue
TURNED = 1.0  # what a change of the sign of the imaginary part weighs
# Of two modes that merge, and that all but nothing distinguishes, the one with the lower number
# takes the larger growth rate: rounding must not decide.
TIE = 1e-3


def matched(
    old_values: Complex, old_vectors: Complex, new_values: Complex, new_vectors: Complex
) -> Order:
    """For each old mode the new one that continues it: near in value and alike in shape.

    Parameters
    ----------
    old_values, new_values : eigenvalues, (modes,)
    old_vectors, new_vectors : eigenvectors as rows, (modes, states)

    Returns
    -------
    (modes,): place of the new mode; conjugate pairs go to conjugate pairs
    """
    scale = max(float(np.abs(old_values).max()), np.finfo(float).tiny)
    cost = np.abs(old_values[:, None] - new_values[None, :]) / scale
    cost += SHAPE * (1.0 - np.abs(_unit_rows(old_vectors).conj() @ _unit_rows(new_vectors).T))
    cost += TURNED * (old_values.imag[:, None] * new_values.imag[None, :] < 0.0)
    cost += TIE * np.linspace(0.0, 1.0, len(cost))[:, None] * new_values.real[None, :] / scale
    return _paired(_cheapest(cost), old_values, new_values)


def _cheapest(cost: NDArray[np.float64]) -> Order:
    """The column of each row in the assignment of least cost.

    Mostly every row has its cheapest column to itself, and nothing is to be weighed.
    """
    cheapest = cost <= cost.min(axis=1, keepdims=True)
    if (cheapest.sum(axis=0) == 1).all():
        return cheapest.argmax(axis=1)
    from scipy.optimize import linear_sum_assignment

    order: Order = linear_sum_assignment(cost)[1]
    return order


def _paired(order: Order, old_values: Complex, new_values: Complex) -> Order:
    """The same with the conjugate of each old mode going to the conjugate of its new mode.

    Where two modes merge, the halves of the two pairs could else be mixed.
    """
    old, new = old_values.tolist(), new_values.tolist()
    old_twins, new_twins = _conjugates(old), _conjugates(new)
    if not old_twins or not new_twins:
        return order
    places = order.tolist()
    for mode, value in enumerate(old):
        if value.imag > 0.0 and new[places[mode]].imag > 0.0:
            twin, holder = old_twins[mode], places.index(new_twins[places[mode]])
            places[twin], places[holder] = places[holder], places[twin]
    return np.array(places, np.intp)


def _conjugates(values: list[complex]) -> list[int]:
    """Place of the conjugate of each eigenvalue; of a real one its own; empty: not in pairs."""
    places = list(range(len(values)))
    ranked = sorted(places, key=lambda place: (values[place].real, abs(values[place].imag)))
    upper = [place for place in ranked if values[place].imag > 0.0]
    lower = [place for place in ranked if values[place].imag < 0.0]
    if len(upper) != len(lower):
        return []
    for one, other in zip(upper, lower, strict=True):
        places[one], places[other] = other, one
    return places


def _unit_rows(vectors: Complex) -> Complex:
    if not np.isfinite(vectors).all():
        vectors = np.nan_to_num(vectors)
    lengths = np.sqrt((vectors.conj() * vectors).real.sum(axis=1, keepdims=True))
    lengths[lengths == 0.0] = 1.0
    result: Complex = vectors / lengths
    return result
