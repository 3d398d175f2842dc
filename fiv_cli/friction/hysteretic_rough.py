"""`hysteretic` friction on a surface that is not alike everywhere: its stochastic part.

    g + f_R for g,    f_R = roughness r(s)                              sliding
    |F_T| <= (mu_k + (mu_s + Delta mu_s - mu_k)(1 + f_R)) N             sticking

Thesis 2.9, 2.10, where f_R is left open. r, of `surface`, is a smooth function of how far the
surfaces have slid, one for each seed, with the mean 0 and the variance 1: what is random is the
surface, not the motion, which a seed repeats. With roughness = 0 this is `hysteretic`. At a steady
slip F_T is, on average over a wavelength 8 pi l, that of `hysteretic`. Friction opposes slip where
(mu_s - mu_k)(1 + 3.07 roughness) <= mu_k. Each contact has slid from where it was at t = 0.

The surface excites the system: where it slides there is no rest, but a motion of the period
8 pi l/v, v the speed of the drive. What is linear is that of the smooth surface. It cannot be under
a drive whose speed a [schedule] ramps, as how far it has slid has no formula then.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import TYPE_CHECKING

from fiv_cli.friction import hysteretic, stefanski
from fiv_cli.friction.base import Slip
from fiv_cli.friction.surface import LENGTH, SEED, rough
from fiv_cli.models.base import Parameter

if TYPE_CHECKING:
    from sympy import Expr

ROUGHNESS = Parameter(
    "roughness", r"\varrho", "1", 0.1, "standard deviation of f_R", "2.9", 0.0, 0.3,
    role="amplitude",
)  # fmt: skip


def force(slip: Slip, p: Mapping[str, Expr]) -> Expr:
    """F_T in N (thesis 2.9, 2.10)."""
    sense = stefanski.sense(slip, p)
    rise = p["Delta_mu_s"] / (1 + slip.speed / p["v_s"]) * (1 + sense) / 2
    step = (p["mu_s"] - p["mu_k"]) * sense + rise
    return hysteretic.force(slip, p) + slip.sign * p["roughness"] * step * slip.N


def capacity(N: Expr, p: Mapping[str, Expr]) -> Expr:
    """What stick can bear here, N."""
    above = p["mu_s"] + p["Delta_mu_s"] - p["mu_k"]
    return (p["mu_k"] + above * (1 + p["roughness"])) * N


LAW = replace(
    hysteretic.LAW,
    name="hysteretic-rough",
    title="friction as `hysteretic`, on a surface that is not alike everywhere",
    parameters=(*hysteretic.LAW.parameters, ROUGHNESS, LENGTH, SEED),
    force=force,
    capacity=capacity,
    surface=rough(ROUGHNESS.name),
)
