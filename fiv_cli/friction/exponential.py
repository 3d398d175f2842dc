"""Friction that falls exponentially from its value at rest to its kinetic value.

    F_T = sgn(v) (mu_k + (mu_0 - mu_k) exp(-alpha |v|)) N     sliding
    |F_T| <= mu_s N                                           sticking

Thesis 4.5 (where mu_k is called mu_1) and 5.18 (where mu_0 = mu_s). With alpha = 0 it is
Coulomb's law with the coefficient mu_0. With mu_0 = mu_s it is Stribeck's of delta = 1 and v_s =
1/alpha; there is no viscous rise.

Its average over a fast slip velocity V + U cos s (5.51, where a factor r0 is missing in front of
the velocities of the disc and of the slider) is, while slip does not reverse (U <= |V|),

    sgn(V) (mu_k + (mu_0 - mu_k) exp(-alpha |V|) I_0(alpha U)) N

and else, with theta = arcsin(V/U),

    (2/pi mu_k theta + (mu_0 - mu_k)/pi (J(theta) - J(-theta))) N
    J(theta) = int_-pi/2^theta exp(-alpha U (sin theta - sin x)) dx

that is, split where the fast velocity passes through zero: both integrands are smooth, and so the
derivative is exact, 2 mu_0/(pi sqrt(U^2 - V^2)) and a smooth part. `NODES` nodes of Gauss, drawn
together where the friction falls fastest, leave an error of 1e-14 up to alpha U = 100 and of
1e-11 up to 1000.
"""

from __future__ import annotations

from collections.abc import Mapping
from functools import cache
from typing import TYPE_CHECKING

from fiv_cli.friction.base import Law, Slip
from fiv_cli.friction.coulomb import FALLING, MU_K, MU_S
from fiv_cli.models.base import Parameter

if TYPE_CHECKING:
    from sympy import Expr

NODES = 48


def force(slip: Slip, p: Mapping[str, Expr]) -> Expr:
    """F_T in N (thesis 4.5, 5.18)."""
    import sympy

    decay = sympy.exp(-p["alpha"] * slip.speed)
    return slip.sign * (p["mu_k"] + (p["mu_0"] - p["mu_k"]) * decay) * slip.N


def average(slip: Slip, p: Mapping[str, Expr], amplitude: Expr, reversing: bool) -> Expr:
    """F_T in N averaged over a fast slip velocity of this amplitude (thesis 5.51)."""
    import sympy

    fall = p["mu_0"] - p["mu_k"]
    if not reversing:
        decay = sympy.exp(-p["alpha"] * (slip.speed - amplitude)) * _bessel(p["alpha"] * amplitude)
        return slip.sign * (p["mu_k"] + fall * decay) * slip.N
    theta = sympy.asin(slip.v / amplitude)
    forward = _side(slip.v, theta, p["alpha"], amplitude)
    backward = _side(-slip.v, -theta, p["alpha"], amplitude)
    return (2 * p["mu_k"] * theta + fall * (forward - backward)) / sympy.pi * slip.N


def _bessel(argument: Expr) -> Expr:
    """exp(-z) I_0(z) = 1/pi int_0^pi exp(-z (1 - cos s)) ds."""
    import sympy

    angles = ((weight, sympy.pi * node) for node, weight in _rule())
    return sum(weight * sympy.exp(-argument * (1 - sympy.cos(s))) for weight, s in angles)


def _side(v: Expr, theta: Expr, alpha: Expr, amplitude: Expr) -> Expr:
    """J(theta), v = U sin theta: what one direction of slip adds to the average."""
    import sympy

    length = theta + sympy.pi / 2
    terms = (
        weight * sympy.exp(-alpha * (v - amplitude * sympy.sin(theta - length * node)))
        for node, weight in _rule()
    )
    return length * sympy.Add(*terms)


@cache
def _rule() -> tuple[tuple[float, float], ...]:
    """(node, weight) of Gauss' rule for the integral over (0, 1) of f(t^2) 2 t dt."""
    import numpy as np

    nodes, weights = np.polynomial.legendre.leggauss(NODES)
    root, share = (nodes + 1.0) / 2.0, weights / 2.0
    return tuple(zip((root**2).tolist(), (2.0 * root * share).tolist(), strict=True))


LAW = Law(
    name="exponential",
    title="Coulomb friction that falls exponentially with speed",
    reference="thesis 4.5, 5.18",
    numerics_version=1,
    parameters=(
        MU_S,
        MU_K,
        Parameter(
            "mu_0",
            r"\mu_0",
            "1",
            None,
            "coefficient of kinetic friction at rest",
            "4.5",
            0.0,
            default_from="mu_s",
            role="friction",
        ),
        Parameter("alpha", r"\alpha", "s m-1", 1.0, "rate of the fall", "4.5", 0.0),
    ),
    force=force,
    capacity=lambda N, p: p["mu_s"] * N,
    average=average,
    requirements=(FALLING,),
)
