"""A spring in series with a Coulomb slider (Jenkins element): Coulomb friction with pre-sliding.

    F_T = x mu_k N,    dx/dt = v sigma_0/mu_k while |x| < 1    the slider holds
                       x = +-1 while +-v > 0                   it slides

x is the share of its limit that the spring is bent to, at a deflection of x mu_k/sigma_0: sigma_0
is its stiffness per unit of normal force, as in Dahl's law, and the force of a slider that slides
is mu_k N at once under any load. The cycle under a slip of amplitude A > mu_k/sigma_0 is a
parallelogram of area 4 mu_k N (A - mu_k/sigma_0). As sigma_0 grows it tends to Coulomb's law with
mu_s = mu_k, motions that turn round at the order 1/2. There is no static friction; under a load
that pulsates below mu_k N the contact does not creep, as it does under Dahl's law. While it is open
the spring stays as it was. Iwan, J. Applied Mechanics 33 (1966) 893-900.

It cannot have a stiffness that does not depend on the normal force: where that varies, the energy
of the spring does too.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

from fiv_cli.friction.base import Exit, Law, Piece, Slip
from fiv_cli.friction.dahl import POSITIVE_MU_K, SIGMA_0
from fiv_cli.models.base import State

if TYPE_CHECKING:
    from sympy import Expr

# The numbers of a piece: the way that the slider slides, and how its spring, per metre of slip,
# keeps to the limit where it is (so that it has a place to be where all else rests). Guards: the
# spring against the limit above and below while the slider holds; the slip velocity while it
# slides. As slip turns, the spring is at the limit, at a rate of zero.
HOLDS, FORWARD, BACKWARD = "holds", "slides+", "slides-"
SLIDER = (
    Piece(HOLDS, (0.0, 0.0), (Exit(FORWARD, (0, 0)), Exit(BACKWARD, (0, 0)))),
    Piece(FORWARD, (1.0, 1.0), (Exit(HOLDS, (2, 0)), None)),
    Piece(BACKWARD, (-1.0, 1.0), (Exit(HOLDS, (0, 2)), None)),
)
BENT = State("bent", "x", "1", "share of its limit that the spring is bent to")


def _slider_guards(way: Expr, bent: Expr, v: Expr) -> tuple[Expr, Expr]:
    """Of an element of `SLIDER`."""
    slides = way**2
    upper = (1 - slides) * (1 - bent) + way * v
    lower = (1 - slides) * (1 + bent) + slides
    return upper, lower


def steadily(v: float) -> str:
    """The piece that a slider comes to be in at a slip velocity."""
    return HOLDS if v == 0.0 else FORWARD if v > 0.0 else BACKWARD


def rates(slip: Slip, p: Mapping[str, Expr]) -> Mapping[str, Expr]:
    """Rate of what the spring is bent to, 1/s."""
    ((way, keeping),) = slip.rows
    held = (1 - way**2) * p["sigma_0"] / p["mu_k"]
    return {BENT.name: slip.v * (held + keeping * (1 - way * slip.states[BENT.name]))}


def guards(slip: Slip, p: Mapping[str, Expr]) -> Sequence[Sequence[Expr]]:
    """What is positive while the slider holds, or slides."""
    ((way, _),) = slip.rows
    return [_slider_guards(way, slip.states[BENT.name], slip.v)]


def stored(slip: Slip, p: Mapping[str, Expr]) -> Expr:
    """Energy of the spring, J."""
    return (p["mu_k"] * slip.states[BENT.name]) ** 2 / p["sigma_0"] * slip.N / 2


LAW = Law(
    name="jenkins",
    title="a spring in series with a Coulomb slider (Jenkins element)",
    reference="Iwan, J. Applied Mechanics 33 (1966) 893",
    numerics_version=1,
    parameters=(POSITIVE_MU_K, SIGMA_0),
    force=lambda slip, p: slip.states[BENT.name] * p["mu_k"] * slip.N,
    capacity=None,
    states=(BENT,),
    rates=rates,
    pieces=SLIDER,
    guards=guards,
    steady=lambda slip, p: slip.sign * p["mu_k"] * slip.N,
    stored=stored,
    resting=lambda v, p: [steadily(v)],
)
