"""Modes followed from one linearised system to a neighbouring one."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields
from typing import Any

import numpy as np
from numpy.typing import NDArray

Complex = NDArray[np.complex128]
Order = NDArray[np.intp]

SHAPE = 0.1  # what a wholly different shape weighs against a change by the largest eigenvalue
TURNED = 1.0  # what a change of the sign of the imaginary part weighs
# Of two modes that merge, and that all but nothing distinguishes, the one with the lower number
# takes the larger growth rate: rounding must not decide.
TIE = 1e-3
COUPLED = 1e-3  # relative distance of the frequencies of two coupled modes


@dataclass(frozen=True)
class Modes:
    """The modes of a linearised system, in any order; in rows, of several.

    Attributes
    ----------
    values : eigenvalues, (..., modes)
    shapes : eigenvectors of unit length as rows, (..., modes, states)
    twins : place of the conjugate of each mode, of a real one its own; -1: they are not in pairs
    """

    values: Complex
    shapes: Complex
    twins: Order

    def __getitem__(self, rows: Any) -> Modes:
        return Modes(self.values[rows], self.shapes[rows], self.twins[rows])

    def taken(self, order: Order) -> Modes:
        """The same in another order."""
        if order.tolist() == list(range(len(order))):
            return self
        twins = self.twins[..., order]
        renamed = np.where(twins < 0, -1, np.argsort(order)[twins])
        shapes = np.ascontiguousarray(self.shapes[..., order, :])
        return Modes(np.ascontiguousarray(self.values[..., order]), shapes, renamed)


def modes_of(values: Complex, vectors: Complex) -> Modes:
    """The modes of some systems, in rows.

    Parameters
    ----------
    values : (systems, modes)
    vectors : as rows, (systems, modes, states)
    """
    return Modes(values, _unit_rows(vectors), _twins(values))


def followed(pairs: Sequence[tuple[Modes, Modes]]) -> Order:
    """`continued` of some pairs of old and new modes."""
    old, new = (
        Modes(*(np.array([getattr(one, field.name) for one in some]) for field in fields(Modes)))
        for some in zip(*pairs, strict=True)
    )
    return continued(old, new)


def continued(old: Modes, new: Modes) -> Order:
    """For each old mode of a row the new one that continues it: near in value, alike in shape.

    Parameters
    ----------
    old, new : in rows, with as many modes

    Returns
    -------
    (rows, modes): places; conjugate pairs go to conjugate pairs
    """
    orders = _cheapest(_cost(old.values, old.shapes, new.values, new.shapes))
    going, coming = (
        np.take_along_axis(orders, old.twins, 1),
        np.take_along_axis(new.twins, orders, 1),
    )
    told = (old.twins >= 0).all(axis=1) & (new.twins >= 0).all(axis=1)
    for row in np.flatnonzero((going != coming).any(axis=1) & told).tolist():
        orders[row] = _paired(orders[row], old[row], new[row])
    return orders


def _cost(
    values: Complex, shapes: Complex, new_values: Complex, new_shapes: Complex
) -> NDArray[np.float64]:
    """What it costs that a new mode continues an old one, (pairs, old modes, new modes)."""
    scale = np.maximum(np.abs(values).max(axis=1), np.finfo(float).tiny)[:, None, None]
    values, new_values = values[:, :, None], new_values[:, None, :]
    cost: NDArray[np.float64] = np.abs(values - new_values) / scale
    cost += SHAPE * (1.0 - np.abs(shapes.conj() @ new_shapes.swapaxes(1, 2)))
    cost += TURNED * (values.imag * new_values.imag < 0.0)
    cost += TIE * np.linspace(0.0, 1.0, cost.shape[1])[:, None] * new_values.real / scale
    return cost


def _cheapest(cost: NDArray[np.float64]) -> Order:
    """The column of each row in the assignment of least cost, for each matrix.

    Mostly every row has its cheapest column to itself, and nothing is to be weighed.
    """
    cheapest = cost <= cost.min(axis=2, keepdims=True)
    orders: Order = cheapest.argmax(axis=2)
    for place in np.flatnonzero((cheapest.sum(axis=1) != 1).any(axis=1)):
        from scipy.optimize import linear_sum_assignment

        orders[place] = linear_sum_assignment(cost[place])[1]
    return orders


def _paired(order: Order, old: Modes, new: Modes) -> Order:
    """The same with the conjugate of each old mode going to the conjugate of its new mode.

    Where two modes merge, the halves of the two pairs could else be mixed.
    """
    places = order.tolist()
    for mode in np.flatnonzero(old.values.imag > 0.0):
        if new.values[places[mode]].imag > 0.0:
            twin, holder = old.twins[mode], places.index(new.twins[places[mode]])
            places[twin], places[holder] = places[holder], places[twin]
    return np.array(places, np.intp)


def _twins(values: Complex) -> Order:
    """See `Modes.twins`, for each row: by rising real part, then modulus of the imaginary one."""
    count = values.shape[1]
    signs = np.sign(values.imag)
    ranked = np.lexsort((np.abs(values.imag), values.real, signs))  # lower, real, upper
    lower, upper = (signs < 0.0).sum(axis=1), (signs > 0.0).sum(axis=1)
    reach, places = (count - lower)[:, None], np.arange(count)
    partners = np.where(places < lower[:, None], places + reach, places)
    partners = np.where(places >= reach, places - reach, partners)
    twins = np.empty(values.shape, np.intp)
    np.put_along_axis(twins, ranked, np.take_along_axis(ranked, partners % count, 1), 1)
    twins[lower != upper] = -1
    return twins


def coupled_modes(values: Complex) -> Order:
    """Of each eigenvalue of a row the place of the (last) one it has merged with, else -1.

    Two modes have merged when they differ in growth and not, or less, in frequency.
    """
    frequency, growth = values.imag[..., None], values.real[..., None]
    split = np.abs(frequency - values.imag[..., None, :])
    same = (split <= COUPLED * np.abs(frequency)) & (frequency != 0.0)
    merged = same & (split < np.abs(growth - values.real[..., None, :]))
    partner: Order = np.where(merged, np.arange(values.shape[-1]), -1).max(axis=-1)
    return partner


def _unit_rows(vectors: Complex) -> Complex:
    if not np.isfinite(vectors).all():
        vectors = np.nan_to_num(vectors)
    lengths = np.sqrt((vectors.conj() * vectors).real.sum(axis=-1, keepdims=True))
    lengths[lengths == 0.0] = 1.0
    result: Complex = vectors / lengths
    return result
