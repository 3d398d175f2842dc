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
from dataclasses import asdict, dataclass, replace
from typing import TYPE_CHECKING

from fiv_cli.codegen import cache
from fiv_cli.codegen.generate import load_text, text_key
from fiv_cli.codegen.reduction import ELIMINATED, FUNCTION, Reduction, Statics
from fiv_cli.codegen.setup import Setup
from fiv_cli.schedule import STEADY

if TYPE_CHECKING:
    from llvmlite.binding import ExecutionEngine

ORDER = 0  # no Taylor series: what stands for the order in the key


def generate_statics(setup: Setup) -> Statics:
    """The statics of a system, from the cache or derived now (with SymPy)."""
    still = replace(setup, order=ORDER, schedule=STEADY)
    name = text_key(still) + ".statics.json"
    content = cache.frozen(json.loads(cache.kept(name, lambda: _derived(still))))
    reductions = tuple(Reduction(**reduction) for reduction in content.pop("reductions"))
    return Statics(**content, reductions=reductions)


def _derived(setup: Setup) -> bytes:
    from fiv_cli.codegen.reduce import derive_statics

    return json.dumps(asdict(derive_statics(setup))).encode()


@dataclass(frozen=True)
class Loaded:
    """Addresses of the functions of a reduction (0: none); `engine` keeps their code alive."""

    engine: ExecutionEngine
    statics: int
    eliminated: int


def load_reduction(reduction: Reduction) -> Loaded:
    """The functions of `reduction`, compiled unless the cache has them."""
    engine = load_text(reduction.text)
    names = (FUNCTION, ELIMINATED if reduction.eliminated else "")
    addresses = (int(engine.get_function_address(name)) if name else 0 for name in names)
    return Loaded(engine, *addresses)
