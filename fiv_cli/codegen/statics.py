"""Sliding equilibria reduced to one polynomial: what is generated for it, and how it is read.

At rest most unknowns (coordinates and normal forces) enter the equations linearly once one of
them, the *scalar* s, is fixed: the coordinates of a belt under a given normal force, for example.
So ``A(s) u = b(s)`` gives ``u = numerator(s) / denominator(s)``, and the equation that is left,
the *closure*, becomes a polynomial in s alone, whose real roots are all the equilibria there are.

Generated is one function from the parameters to the coefficients of these polynomials. The modes
of a disc, which turn with the slider's angle, are taken out before (see ``eliminate.py``); a second
function gives them back. Models that cannot be reduced so have no reduction.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from typing import TYPE_CHECKING, Any

from fiv_cli.codegen import cache
from fiv_cli.codegen.generate import load_text, text_key

if TYPE_CHECKING:
    from fiv_cli.friction.base import Law
    from fiv_cli.models.base import Model

FUNCTION, ELIMINATED = "statics", "eliminated"
ORDER = 0  # no Taylor series: what stands for the order in the key

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


def generate_statics(
    model: Model, law: Law, options: Mapping[str, str], structural: Mapping[str, float]
) -> Statics:
    """The statics of a system, from the cache or derived now (with SymPy)."""
    name = text_key(model, law, options, structural, ORDER) + ".statics.json"
    stored = cache.read(name)
    if stored is None:
        from fiv_cli.codegen.reduce import derive_statics

        stored = json.dumps(asdict(derive_statics(model, law, options, structural))).encode()
        cache.write(name, stored)
    return _from_json(json.loads(stored))


@dataclass(frozen=True)
class Loaded:
    """Addresses of the functions of a reduction (0: none); `engine` keeps their code alive."""

    engine: Any
    statics: int
    eliminated: int


def load_reduction(reduction: Reduction) -> Loaded:
    """The functions of `reduction`, compiled unless the cache has them."""
    engine = load_text(reduction.text)
    names = (FUNCTION, ELIMINATED if reduction.eliminated else "")
    addresses = (int(engine.get_function_address(name)) if name else 0 for name in names)
    return Loaded(engine, *addresses)


def _from_json(content: dict[str, Any]) -> Statics:
    return Statics(
        bilateral=tuple(content["bilateral"]),
        determined=tuple(content["determined"]),
        reductions=tuple(map(_reduction, content["reductions"])),
    )


def _reduction(found: dict[str, Any]) -> Reduction:
    return Reduction(
        parameters=tuple(found["parameters"]),
        scalar=found["scalar"],
        unknowns=tuple(found["unknowns"]),
        numerators=tuple(tuple(slots) for slots in found["numerators"]),
        denominator=tuple(found["denominator"]),
        closure=tuple(found["closure"]),
        n_slots=found["n_slots"],
        eliminated=tuple(found["eliminated"]),
        text=found["text"],
    )
