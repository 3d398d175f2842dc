"""Modes followed from one linearised system to a neighbouring one."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache, cached_property

import numpy as np
from numpy.typing import NDArray

Complex = NDArray[np.complex128]
Order = NDArray[np.intp]

SHAPE = 0.1  # what a wholly different shape weighs against a change by the largest eigenvalue
TURNED = 1.0  # what a change of the sign of the imaginary part weighs
# Of two modes that merge, and that all but nothing distinguishes, the one with the lower number
# takes the larger growth rate: rounding must not decide.
TIE = 1e-3


@dataclass(frozen=True)
class Modes:
    """The modes of a linearised system, in any order.

    Attributes
    ----------
    values : eigenvalues, (modes,)
    vectors : eigenvectors as rows, (modes, states)
    """

    values: Complex
    vectors: Complex

    @cached_property
    def scale(self) -> float:
        """Modulus of the largest eigenvalue."""
        return float(np.abs(self.values).max())

    @cached_property
    def shapes(self) -> Complex:
        """The vectors, of unit length."""
        return _unit_rows(self.vectors)

    @cached_property
    def twins(self) -> list[int]:
        """See `_conjugates`."""
        return _conjugates(self.values.tolist())

    def follow(self, old: Modes) -> Order:
        """For each old mode the one that continues it: near in value and alike in shape.

        Returns
        -------
        (modes,): places; conjugate pairs go to conjugate pairs
        """
        scale = max(old.scale, np.finfo(float).tiny)
        cost = np.abs(old.values[:, None] - self.values) / scale
        cost += SHAPE * (1.0 - np.abs(old.shapes.conj() @ self.shapes.T))
        cost += TURNED * (old.values.imag[:, None] * self.values.imag < 0.0)
        cost += _ties(len(cost)) * self.values.real / scale
        return _paired(_cheapest(cost), old, self)

    def taken(self, order: Order) -> Modes:
        """The same in another order."""
        if order.tolist() == list(range(len(order))):
            return self
        return Modes(self.values[order], self.vectors[order])


@cache
def _ties(count: int) -> NDArray[np.float64]:
    """What a growth rate weighs for each old mode, (modes, 1)."""
    return TIE * np.linspace(0.0, 1.0, count)[:, None]


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


def _paired(order: Order, old: Modes, new: Modes) -> Order:
    """The same with the conjugate of each old mode going to the conjugate of its new mode.

    Where two modes merge, the halves of the two pairs could else be mixed.
    """
    places, twins, new_twins = order.tolist(), old.twins, new.twins
    if not (twins and new_twins) or all(
        places[twin] == new_twins[place] for twin, place in zip(twins, places, strict=True)
    ):
        return order
    upper, new_upper = old.values.imag > 0.0, new.values.imag > 0.0
    for mode in range(len(places)):
        if upper[mode] and new_upper[places[mode]]:
            twin, holder = twins[mode], places.index(new_twins[places[mode]])
            places[twin], places[holder] = places[holder], places[twin]
    return np.array(places, np.intp)


def _conjugates(values: list[complex]) -> list[int]:
    """Place of the conjugate of each eigenvalue; of a real one its own; empty: not in pairs."""
    places = list(range(len(values)))
    ranked = sorted(places, key=[(value.real, abs(value.imag)) for value in values].__getitem__)
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
