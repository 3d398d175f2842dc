"""Annular Kirchhoff plate, clamped inside and free outside, by itself (thesis 3.3).

The disc of the other models at rest and without a slider: what is computed are its modes, by the
analysis ``plate`` (see ``fiv_cli/plate.py`` for the equations). It has no states and no contact.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from fiv_cli.models import disc
from fiv_cli.models.base import Equations, Model, Options

if TYPE_CHECKING:
    from fiv_cli.models.symbols import Symbols


def equations(symbols: Symbols, options: Options) -> Equations:
    """None: there is nothing that moves."""
    import sympy

    return Equations({}, (), sympy.Integer(0), sympy.Integer(0))


MODEL = Model(
    name="annular-plate",
    title="annular plate, clamped inside and free outside",
    reference="thesis 3.3; equations 3.36-3.58",
    numerics_version=1,
    parameters=disc.PLATE,
    states=lambda options: (),
    equations=equations,
    default_law="none",
    options=(disc.MODES,),
    contacts=0,
    derived=disc.DERIVED,
    requirements=(disc.ON_THE_DISC,),
)
