"""Contacts that stick jointly: those whose slip velocities are one and the same but for a factor.

A mass between two belts of one speed is held by both. What it takes to hold it is known, which belt
takes how much of it is not: each is given the part that it can bear, so the contacts let go
together, when the demand passes all that they can bear. At different speeds one of them holds.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import chain

import numpy as np
import sympy
from numpy.typing import NDArray
from sympy import Expr

from fiv_cli.errors import UsageError
from fiv_cli.friction import get_law
from fiv_cli.models.base import Model, Options
from fiv_cli.models.symbols import Symbols

Row = Sequence[Expr]

ROUNDING = 1e-9  # a least singular value of this share is zero: entries have 16 digits
TRIES = 3  # places by chance at which rows may be dependent though almost everywhere they are not


@dataclass(frozen=True)
class Joint:
    """Sticking contacts of one direction.

    Attributes
    ----------
    factors : contact -> its slip velocity over that of the first, where nothing is driven
    """

    factors: Mapping[int, Expr]

    @property
    def leader(self) -> int:
        """The first: whose slip velocity stands for all."""
        return next(iter(self.factors))

    @property
    def followers(self) -> Iterator[tuple[int, Expr]]:
        """The others with their factors."""
        return ((contact, f) for contact, f in self.factors.items() if contact != self.leader)


def assumed(model: Model, options: Options, laws: Iterable[str]) -> list[str]:
    """What is assumed of contacts that hold jointly where all stick; nothing where none do."""
    every = (_assumed(model, options, law) for law in laws)
    return list(dict.fromkeys(chain.from_iterable(every)))


def _assumed(model: Model, options: Options, law: str) -> Iterator[str]:
    symbols = Symbols()
    equations = model.mechanics(symbols, options)
    velocities = [symbols.velocity(name) for name in equations.accelerations]
    slips = {
        index: [sympy.diff(contact.slip_velocity, velocity) for velocity in velocities]
        for index, contact in enumerate(equations.contacts)
        if not contact.sliding_only and get_law(contact.law or law).capacity is not None
    }
    for joint in joints(slips, {}):
        if len(joint.factors) > 1:
            yield (
                f"contacts {_numbers([*joint.factors])} hold jointly where all stick: only the sum "
                "of their forces follows from the motion; assumed: each bears in proportion to "
                "what it can"
            )


def joints(slips: Mapping[int, Row], gaps: Mapping[int, Row]) -> list[Joint]:
    """Sticking contacts by direction.

    Parameters
    ----------
    slips : sticking contact -> derivatives of its slip velocity with respect to the velocities
    gaps : closed rigid contact -> those of its gap rate

    Raises
    ------
    UsageError
        their conditions depend on one another in another way, which leaves forces open.
    """
    found: list[Joint] = []
    for contact, row in slips.items():
        of_same = next((j for j in found if not are_free([slips[j.leader], row])), None)
        if of_same is None:
            found.append(Joint({contact: sympy.Integer(1)}))
        else:
            factor = _factor(slips[of_same.leader], row)
            found[found.index(of_same)] = Joint({**of_same.factors, contact: factor})
    conditions = [slips[joint.leader] for joint in found] + list(gaps.values())
    several = [contact for joint in found if len(joint.factors) > 1 for contact in joint.factors]
    if len(conditions) > 1 and not are_free(conditions):
        raise _dependent([*slips, *gaps], "their directions depend on one another")
    if any(contact in gaps for contact in several):
        raise _dependent(several, "they have one direction, and their normal forces are algebraic")
    return found


def are_free(rows: Sequence[Row]) -> bool:
    """Whether the rows of a matrix of expressions are independent almost everywhere."""
    matrix, random = sympy.Matrix(rows), np.random.default_rng(0)
    symbols = sorted(matrix.free_symbols, key=str)
    tries = (random.uniform(0.1, 0.9, len(symbols)) for _ in range(TRIES))
    places = (dict(zip(symbols, values.tolist(), strict=True)) for values in tries)
    at = (np.array(matrix.subs(place).evalf(), dtype=float) for place in places)
    return any(_least_share(numbers) > ROUNDING for numbers in at)


def _least_share(matrix: NDArray[np.float64]) -> float:
    """The least singular value over the greatest."""
    singular = np.linalg.svd(matrix, compute_uv=False)
    return float(singular[-1] / singular[0]) if len(matrix) <= matrix.shape[1] else 0.0


def _factor(leading: Row, row: Row) -> Expr:
    """How often one row is the other."""
    ratios = (own / its for own, its in zip(row, leading, strict=True) if its != 0)
    return sympy.simplify(next(ratios))


def _dependent(contacts: Sequence[int], why: str) -> UsageError:
    return UsageError(
        f"contacts {_numbers(contacts)} stick at once, and {why}: what each of them bears cannot "
        "be told\n"
        "next: make one contact of them, let one be sliding_only, or give the body between them "
        "a coordinate of its own, on a stiff spring"
    )


def _numbers(contacts: Sequence[int]) -> str:
    """As people count them."""
    return ", ".join(str(contact + 1) for contact in sorted(set(contacts)))
