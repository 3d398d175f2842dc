"""Bristles that only bend at first, then yield: LuGre friction without its drift (Dupont).

    dz/dt = v (1 - alpha sigma_0 z sgn(v)/g),    g = mu_k + (mu_s - mu_k) exp(-(v/v_s)^2)
    F_T = (sigma_0 z + sigma_1 dz/dt + sigma_2 v) N

with, of the share x = sigma_0 z sgn(v)/g of what the bristles come to be bent by in steady sliding,

    alpha = 0 for xi <= 0,   1 for xi >= 1,   (1 - cos(pi xi))/2 between,
    xi = (x - x_ba)/(x_max - x_ba),    x_max = x_ba + blend (1 - x_ba)

Below x_ba, and while they are bent back, the bristles are a spring: a load that pulsates below
break-away moves the contact to and fro and no farther, where LuGre's creeps on. Dupont, Hayward,
Armstrong & Altpeter, IEEE Trans. Automatic Control 47 (2002) 787-792; there x_max = 1, which
steady sliding takes for ever to reach: here it is below. sigma_0, sigma_1, sigma_2 and g are per
unit of normal force, as in LuGre's law. With x_ba = 0 and x_max near 0 it is LuGre's while slip
does not turn. It does not stick, and while the contact is open the bristles stay as they were.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

from fiv_cli.friction import intervals
from fiv_cli.friction.base import Law, Slip
from fiv_cli.friction.coulomb import FALLING, MU_S
from fiv_cli.friction.dahl import DEFLECTION, POSITIVE_MU_K, SIGMA_0
from fiv_cli.friction.lugre import SIGMA_1, SIGMA_2
from fiv_cli.friction.stribeck import V_S
from fiv_cli.models.base import Parameter

if TYPE_CHECKING:
    from sympy import Expr

# Numbers of a piece: alpha = first + second (1 - cos(pi xi))/2. Borders: of xi.
PIECES = intervals.intervals(
    (0.0, 1.0), ("elastic", "yields", "plastic"), ((0.0, 0.0), (0.0, 1.0), (1.0, 0.0))
)


def _curve(slip: Slip, p: Mapping[str, Expr]) -> Expr:
    """g."""
    import sympy

    return p["mu_k"] + (p["mu_s"] - p["mu_k"]) * sympy.exp(-((slip.v / p["v_s"]) ** 2))


def _share(slip: Slip, p: Mapping[str, Expr]) -> Expr:
    """x, positive where the bristles are bent the way that the contact slips."""
    return slip.sign * p["sigma_0"] * slip.states["deflection"] / _curve(slip, p)


def _beyond(slip: Slip, p: Mapping[str, Expr]) -> Expr:
    """xi."""
    return (_share(slip, p) - p["x_ba"]) / (p["blend"] * (1 - p["x_ba"]))


def _bending(slip: Slip, p: Mapping[str, Expr]) -> Expr:
    """dz/dt in m/s."""
    import sympy

    ((whole, blended, *_),) = slip.rows
    alpha = whole + blended * (1 - sympy.cos(sympy.pi * _beyond(slip, p))) / 2
    return slip.v * (1 - alpha * _share(slip, p))


def force(slip: Slip, p: Mapping[str, Expr]) -> Expr:
    """F_T in N."""
    damping = p["sigma_1"] * _bending(slip, p) + p["sigma_2"] * slip.v
    return (p["sigma_0"] * slip.states["deflection"] + damping) * slip.N


LAW = Law(
    name="elasto-plastic",
    title="bristles that bend, then yield: LuGre without drift (Dupont)",
    reference="Dupont et al., IEEE Trans. Automatic Control 47 (2002) 787",
    numerics_version=1,
    parameters=(
        MU_S,
        POSITIVE_MU_K,
        V_S,
        SIGMA_0,
        SIGMA_1,
        SIGMA_2,
        Parameter(
            "x_ba", "x_{ba}", "1", 0.5, "share of the steady deflection below which none yield", "",
            0.0, 0.99,
        ),
        Parameter(
            "blend", "b", "1", 0.8, "share of the rest over which all come to yield", "",
            0.0, 0.99, exclusive=True,
        ),
    ),
    force=force,
    capacity=None,
    states=(DEFLECTION,),
    rates=lambda slip, p: {"deflection": _bending(slip, p)},
    requirements=(FALLING,),
    steady=lambda slip, p: (slip.sign * _curve(slip, p) + p["sigma_2"] * slip.v) * slip.N,
    stored=lambda slip, p: p["sigma_0"] * slip.states["deflection"] ** 2 * slip.N / 2,
    pieces=PIECES,
    guards=lambda slip, p: [intervals.guards(_beyond(slip, p), slip.rows[0])],
    resting=lambda v, p: ["plastic"],
)  # fmt: skip
