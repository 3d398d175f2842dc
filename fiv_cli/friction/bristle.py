"""Bristles that bend, snap, and bond anew (Haessig and Friedland).

    F_T = sum sigma_i u_i N,    du_i/dt = v;    where |u_i| reaches delta_i it begins anew at zero

(thesis 2.12, with u_i = x_i - b_i). Of four bristles with thresholds
delta_i = delta (1 +- spread/3, 1 +- spread) each has the stiffness sigma_i that lets its mean force
in steady sliding be a quarter of mu_k N: sigma_i = mu_k/(2 delta_i). The original places new bonds
at random; here they are where the bristle is, so that a motion can be repeated. The force of steady
sliding is a sawtooth about mu_k N that never ends: there is no equilibrium but at a standstill,
where the bristles are springs, and every bond that snaps is an event. The thesis calls it
inefficient; it is here to be compared with the laws that stand for its mean. Haessig & Friedland,
ASME J. Dynamic Systems, Measurement and Control 113 (1991) 354-362. While the contact is open the
bristles stay as they were.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

from fiv_cli.friction.base import Exit, Law, Piece, Slip
from fiv_cli.friction.coulomb import MU_K
from fiv_cli.models.base import Parameter, State

if TYPE_CHECKING:
    from sympy import Expr

THIRDS = (-3, -1, 1, 3)  # of the spread, by bristle
NAMES = tuple(f"bend_{i}" for i in range(1, len(THIRDS) + 1))
# A bond that snaps stays in its piece, and what it is bent by begins anew.
ANEW = Exit("bonded", (0, 0), begins_anew=True)
BONDED = Piece("bonded", (1.0,), (ANEW, ANEW))


def _thresholds(p: Mapping[str, Any]) -> list[Any]:
    return [p["delta_b"] * (1 + p["spread"] * third / 3) for third in THIRDS]


def force(slip: Slip, p: Mapping[str, Expr]) -> Expr:
    """F_T in N (thesis 2.12)."""
    bent = [slip.states[name] / limit for name, limit in zip(NAMES, _thresholds(p), strict=True)]
    return sum(bent) * p["mu_k"] / 2 * slip.N


def stored(slip: Slip, p: Mapping[str, Expr]) -> Expr:
    """J; a bond that snaps loses all of its."""
    limits = _thresholds(p)
    bent = [slip.states[name] ** 2 / limit for name, limit in zip(NAMES, limits, strict=True)]
    return sum(bent) * p["mu_k"] / 4 * slip.N


def guards(slip: Slip, p: Mapping[str, Expr]) -> Sequence[Sequence[Expr]]:
    """What is left to each bristle until it snaps, one way and the other."""
    bent = [slip.states[name] / limit for name, limit in zip(NAMES, _thresholds(p), strict=True)]
    return [(1 - share, 1 + share) for share in bent]


LAW = Law(
    name="bristle",
    title="bristles that bend, snap and bond anew (Haessig and Friedland)",
    reference="thesis 2.12; Haessig & Friedland, J. Dyn. Syst. Meas. Control 113 (1991) 354",
    numerics_version=1,
    parameters=(
        MU_K,
        Parameter(
            "delta_b", r"\delta_b", "m", 1e-3, "mean deflection at which bonds snap", "2.12",
            0.0, exclusive=True,
        ),
        Parameter("spread", "s", "1", 0.3, "by which thresholds differ from it", "", 0.0, 0.9),
    ),
    force=force,
    capacity=None,
    states=tuple(
        State(name, f"u_{i}", "m", f"deflection of bristle {i}") for i, name in enumerate(NAMES, 1)
    ),
    rates=lambda slip, p: dict.fromkeys(NAMES, slip.v),
    steady=lambda slip, p: slip.sign * p["mu_k"] * slip.N,
    stored=stored,
    pieces=(BONDED,),
    elements=len(NAMES),
    guards=guards,
    snaps=lambda p: sum(1 / limit for limit in _thresholds(p)),
)  # fmt: skip
