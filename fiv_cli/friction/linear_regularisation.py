"""Coulomb friction whose sign function is a straight line about zero slip.

    F_T = mu_k N v/v_tol,     |v| <= v_tol     (thesis 2.4)
    F_T = mu_k N sgn(v),      |v| >  v_tol

As v_tol tends to zero it tends to Coulomb's law with mu_s = mu_k, at first order. There is no
static coefficient and no stick: under a force below mu_k N the contact creeps, at up to v_tol, and
the smaller v_tol, the stiffer the equations while it does.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

from fiv_cli.friction.base import Law, Slip
from fiv_cli.friction.coulomb import MU_K
from fiv_cli.friction.intervals import guards, intervals, piece_at
from fiv_cli.models.base import Parameter

if TYPE_CHECKING:
    from sympy import Expr

BORDERS = (-1.0, 1.0)  # of v/v_tol
PIECES = intervals(
    BORDERS, ("backward", "creeping", "forward"), ((0.0, -1.0), (1.0, 0.0), (0.0, 1.0))
)
CREEPING_FIRST = (PIECES[1], PIECES[0], PIECES[2])


def force(slip: Slip, p: Mapping[str, Expr]) -> Expr:
    """F_T in N (thesis 2.4)."""
    ((slope, level, *_),) = slip.rows
    return (slope * slip.v / p["v_tol"] + level) * p["mu_k"] * slip.N


LAW = Law(
    name="linear-regularisation",
    title="Coulomb friction, its sign function a line about zero slip",
    reference="thesis 2.4",
    numerics_version=1,
    parameters=(
        MU_K,
        Parameter(
            "v_tol", "v_{tol}", "m s-1", 1e-2, "slip speed up to which the force grows", "2.4",
            0.0, exclusive=True,
        ),
    ),
    force=force,
    capacity=None,
    pieces=CREEPING_FIRST,
    guards=lambda slip, p: [guards(slip.v / p["v_tol"], slip.rows[0])],
    resting=lambda v, p: [piece_at(v / p["v_tol"], BORDERS, PIECES).name],
)  # fmt: skip
