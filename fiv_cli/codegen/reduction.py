"""What is known of a model at rest, and the polynomials that its equilibria are roots of."""

from __future__ import annotations

from dataclasses import dataclass

FUNCTION, ELIMINATED = "statics", "eliminated"  # names of the generated functions

Slots = tuple[int, ...]


@dataclass(frozen=True)
class Reduction:
    """The polynomials of a reduced model; coefficients are slots, from s^0 upwards.

    Attributes
    ----------
    parameters : what the function takes: parameters, signs of slip, zone
    scalar : name of the unknown s: a coordinate, or ``F_N.0``
    unknowns : names of the others
    numerators : of each of `unknowns`
    denominator : of all of them
    closure : the polynomial whose roots are the equilibria
    n_slots : how many values the function writes
    eliminated : coordinates that were taken out before
    text : ``statics(c, t, parameters, slots)`` and, where something was taken out before,
        ``eliminated(c, t, y, values)`` with y the parameters, the scalar and the unknowns
    """

    parameters: tuple[str, ...]
    scalar: str
    unknowns: tuple[str, ...]
    numerators: tuple[Slots, ...]
    denominator: Slots
    closure: Slots
    n_slots: int
    eliminated: tuple[str, ...]
    text: str


@dataclass(frozen=True)
class Statics:
    """What is known of a model at rest.

    Attributes
    ----------
    bilateral : per contact, whether its normal force may be negative
    determined : coordinates that a closed rigid gap determines
    reductions : by different scalars, to be tried in this order (one may fail at some values of
        the parameters); none where the equations cannot be reduced to one polynomial
    """

    bilateral: tuple[bool, ...]
    determined: tuple[str, ...]
    reductions: tuple[Reduction, ...]
