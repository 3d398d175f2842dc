"""Friction by bristles that bend, with Stribeck effect and a viscous part (LuGre).

    dz/dt = v - sigma_0 z |v|/g,    g = mu_k + (mu_s - mu_k) exp(-(|v|/v_s)^delta)
    F_T = (sigma_0 z + sigma_1 dz/dt + sigma_2 v) N                        (thesis 2.13)

z is the mean deflection of the bristles; sigma_0, sigma_1, sigma_2 and g are per unit of normal
force, so that the law holds under any load, also one that vanishes (Canudas de Wit & Tsiotras,
38th IEEE CDC (1999) 3746); the thesis' are these times N. In steady sliding F_T = g N + sigma_2 N
v. `delta` is a whole number, 2 in the original: Canudas de Wit, Olsson, Astrom & Lischinsky, IEEE
Trans. Automatic Control 40 (1995) 419-425.

It does not stick: under a pulsating force below break-away the contact creeps. While it is open the
bristles stay as they were. Apart from what they store it only takes energy where sigma_1^2 |v| <=
4 g (sigma_1 + sigma_2). Stiff bristles cost steps of the order of g/(sigma_0 |v|).
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

from fiv_cli.friction.base import Law, Slip
from fiv_cli.friction.coulomb import FALLING, MU_S
from fiv_cli.friction.dahl import DEFLECTION, POSITIVE_MU_K, SIGMA_0
from fiv_cli.friction.stribeck import V_S, exponent
from fiv_cli.models.base import Parameter

if TYPE_CHECKING:
    from sympy import Expr

SIGMA_1 = Parameter("sigma_1", r"\sigma_1", "s m-1", 0.1, "damping of the bristles", "2.13", 0.0)
SIGMA_2 = Parameter("sigma_2", r"\sigma_2", "s m-1", 0.0, "viscous friction", "2.13", 0.0)


def _bending(slip: Slip, p: Mapping[str, Expr]) -> Expr:
    """dz/dt in m/s."""
    import sympy

    fall = sympy.exp(-((slip.speed / p["v_s"]) ** p["delta"]))
    steady = p["mu_k"] + (p["mu_s"] - p["mu_k"]) * fall
    return slip.v - p["sigma_0"] * slip.states["deflection"] * slip.speed / steady


def force(slip: Slip, p: Mapping[str, Expr]) -> Expr:
    """F_T in N."""
    damping = p["sigma_1"] * _bending(slip, p) + p["sigma_2"] * slip.v
    return (p["sigma_0"] * slip.states["deflection"] + damping) * slip.N


LAW = Law(
    name="lugre",
    title="bristles that bend, with Stribeck effect (LuGre)",
    reference="thesis 2.13; Canudas de Wit et al., IEEE Trans. Automatic Control 40 (1995) 419",
    numerics_version=1,
    parameters=(
        MU_S,
        POSITIVE_MU_K,
        V_S,
        exponent(2.0),
        SIGMA_0,
        SIGMA_1,
        SIGMA_2,
    ),
    force=force,
    capacity=None,
    states=(DEFLECTION,),
    rates=lambda slip, p: {"deflection": _bending(slip, p)},
    stored=lambda slip, p: p["sigma_0"] * slip.states["deflection"] ** 2 * slip.N / 2,
    structural=("delta",),
    requirements=(FALLING,),
)
