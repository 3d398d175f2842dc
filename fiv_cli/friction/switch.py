"""Coulomb friction whose stick is a band of slip velocities, in which slip dies out (switch model).

    F_T = sgn(v) mu_k N                                         |v| > eta          it slides
    F_T such that dv/dt = -alpha v                              |D| <= mu_s N      it holds
    F_T = sgn(D) mu_s N                                         else               it yields

D is the force demanded: that under which v would stay as it is. Leine, van Campen, de Kraker & van
den Steen, Nonlinear Dynamics 16 (1998) 41, where alpha = sqrt(k/m) and sliding is `hyperbolic`;
after Karnopp. Made to find stick with a fixed step, it is here to be compared with `coulomb`, whose
stick is exact. That is its limit as eta tends to zero: a contact that yields has its static
friction until v = eta, late by a time of the order sqrt(eta); with mu_s = mu_k the order is 1.

What it cannot do: while it holds the slip velocity is never zero, and its force, off D by alpha v
times the mass, may then work on the system. Under a drive slower than eta there is no steady slide.
Of contacts that act on one another none knows what is demanded of it alone: they cannot have it.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

from fiv_cli.friction.base import Exit, Law, Piece, Slip
from fiv_cli.friction.coulomb import FALLING, MU_K, MU_S
from fiv_cli.friction.intervals import NO_BORDER
from fiv_cli.models.base import Parameter

if TYPE_CHECKING:
    from sympy import Expr

HOLDS, FORWARD, BACKWARD, ONWARD, BACK = "holds", "slides+", "slides-", "yields +", "yields -"
EDGE = 1 + 1e-6  # of the band, for what holds and does not leave it, but may be put down beyond it


def _piece(
    name: str,
    ways: tuple[float, float, float],
    edges: tuple[float, float, float, float],
    *exits: Exit | None,
) -> Piece:
    """`ways` that it slides, yields, and whether it holds; the edges of v/eta as in `intervals`."""
    return Piece(name, (*ways, *edges), exits)


# Guards: v/eta against the upper and the lower edge, the demand against +mu_s N, and -mu_s N.
PIECES = (
    _piece(
        HOLDS, (0.0, 0.0, 1.0), (EDGE, -1.0, EDGE, 1.0),
        Exit(FORWARD, (0, 0, 0, 0)), Exit(BACKWARD, (0, 0, 0, 0)),
        Exit(ONWARD, (0, 0, 1, 0)), Exit(BACK, (0, 0, 1, 0)),
    ),
    _piece(FORWARD, (1.0, 0.0, 0.0), (*NO_BORDER, -1.0, 1.0),
           None, Exit(HOLDS, (0, 0, 0, 0)), None, None),
    _piece(BACKWARD, (-1.0, 0.0, 0.0), (-1.0, -1.0, *NO_BORDER),
           Exit(HOLDS, (0, 0, 0, 0)), None, None, None),
    _piece(ONWARD, (0.0, 1.0, 0.0), (1.0, -1.0, EDGE, 1.0),
           Exit(FORWARD, (0, 1, 0, 0)), Exit(BACKWARD, (0, 0, 0, 0)),
           Exit(HOLDS, (0, 0, 1, 0)), None),
    _piece(BACK, (0.0, -1.0, 0.0), (EDGE, -1.0, 1.0, 1.0),
           Exit(FORWARD, (0, 0, 0, 0)), Exit(BACKWARD, (1, 0, 0, 0)),
           Exit(HOLDS, (0, 0, 0, 1)), None),
)  # fmt: skip

BAND = Parameter(
    "eta", r"\eta", "m s-1", 1e-3, "slip speed up to which it holds", "", 0.0, exclusive=True
)


def force(slip: Slip, p: Mapping[str, Expr]) -> Expr:
    """F_T in N."""
    ((slides, yields, held, *_),) = slip.rows
    limit = (slides * p["mu_k"] + yields * p["mu_s"]) * slip.N
    return limit + held * slip.holding(-p["alpha"] * slip.v)


def guards(slip: Slip, p: Mapping[str, Expr]) -> Sequence[Sequence[Expr]]:
    """What is positive while it holds, slides, or yields."""
    ((_, yields, held, upper, falling, lower, rising),) = slip.rows
    share, demand, most = slip.v / p["eta"], slip.holding(0), p["mu_s"] * slip.N
    above = held * (most - demand) + yields * demand - yields**2 * most + 1 - held - yields**2
    below = held * (most + demand) + 1 - held
    return [(upper + falling * share, lower + rising * share, above, below)]


def steady(slip: Slip, p: Mapping[str, Expr]) -> Expr:
    """F_T in N of a steady slide."""
    return slip.rows[0][0] * p["mu_k"] * slip.N


def steadily(v: float, p: Mapping[str, float]) -> list[str]:
    """The piece of a steady slide."""
    return [HOLDS if abs(v) <= p["eta"] else FORWARD if v > 0.0 else BACKWARD]


LAW = Law(
    name="switch",
    title="Coulomb friction whose stick is a band of slip velocities (switch model)",
    reference="Leine, van Campen, de Kraker & van den Steen, Nonlinear Dynamics 16 (1998) 41",
    numerics_version=1,
    parameters=(
        MU_S,
        MU_K,
        BAND,
        Parameter(
            "alpha", r"\alpha", "s-1", 10.0, "rate at which slip in the band dies out", "", 0.0
        ),
    ),
    force=force,
    capacity=None,
    pieces=PIECES,
    guards=guards,
    steady=steady,
    resting=steadily,
    requirements=(FALLING,),
)
