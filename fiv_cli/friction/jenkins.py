"""A spring in series with a Coulomb slider (Jenkins element): Coulomb friction with pre-sliding.

    F_T = sigma_0 z N,    dz/dt = v while |sigma_0 z| < mu_k         the slider holds
                          sigma_0 z = +-mu_k while +-v > 0           it slides

z is the spring's deflection and sigma_0 its stiffness per unit of normal force, as in Dahl's law:
the force of a slider that slides follows mu_k N at once under any load. The cycle under a slip of
amplitude A > mu_k/sigma_0 is a parallelogram of area 4 mu_k N (A - mu_k/sigma_0). As sigma_0 grows
it tends to Coulomb's law with mu_s = mu_k, motions that turn round at the order 1/2. There is no
static friction; under a load that pulsates below mu_k N the contact does not creep, as it does
under Dahl's law. While it is open the spring stays as it was. Iwan, J. Applied Mechanics 33 (1966)
893-900.

It cannot have a stiffness that does not depend on the normal force: where that varies, the energy
of the spring does too. Where mu_k varies (in a sector, in time) a slider that slides comes to its
new limit over a slip of some mu_k/sigma_0.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

from fiv_cli.friction.base import Exit, Law, Piece, Slip
from fiv_cli.friction.dahl import DEFLECTION, POSITIVE_MU_K, SIGMA_0

if TYPE_CHECKING:
    from sympy import Expr

# The one number of a piece: the way that the slider slides. Guards: the spring against the limit
# above and below while the slider holds; the slip velocity while it slides. As slip turns, the
# spring is at the limit, at a rate of zero.
HOLDS, FORWARD, BACKWARD = "holds", "slides+", "slides-"
SLIDER = (
    Piece(HOLDS, (0.0,), (Exit(FORWARD, (0, 0)), Exit(BACKWARD, (0, 0)))),
    Piece(FORWARD, (1.0,), (Exit(HOLDS, (2, 0)), None)),
    Piece(BACKWARD, (-1.0,), (Exit(HOLDS, (0, 2)), None)),
)


def slider_guards(way: Expr, deflection: Expr, v: Expr) -> tuple[Expr, Expr]:
    """Of an element of `SLIDER`; the deflection is over that at which the slider slides."""
    slides = way**2
    upper = (1 - slides) * (1 - deflection) + way * v
    lower = (1 - slides) * (1 + deflection) + slides
    return upper, lower


def steadily(v: float) -> str:
    """The piece that a slider comes to be in at a slip velocity."""
    return HOLDS if v == 0.0 else FORWARD if v > 0.0 else BACKWARD


def _share(slip: Slip, p: Mapping[str, Expr]) -> Expr:
    """Deflection over that at which the slider slides."""
    return p["sigma_0"] * slip.states["deflection"] / p["mu_k"]


def rates(slip: Slip, p: Mapping[str, Expr]) -> Mapping[str, Expr]:
    """Rate of the deflection in m/s: where the slider slides it keeps to the limit."""
    ((way,),) = slip.rows
    return {"deflection": slip.v * (1 - way * _share(slip, p))}


def guards(slip: Slip, p: Mapping[str, Expr]) -> Sequence[Sequence[Expr]]:
    """What is positive while the slider holds, or slides."""
    ((way,),) = slip.rows
    return [slider_guards(way, _share(slip, p), slip.v)]


LAW = Law(
    name="jenkins",
    title="a spring in series with a Coulomb slider (Jenkins element)",
    reference="Iwan, J. Applied Mechanics 33 (1966) 893",
    numerics_version=1,
    parameters=(POSITIVE_MU_K, SIGMA_0),
    force=lambda slip, p: p["sigma_0"] * slip.states["deflection"] * slip.N,
    capacity=None,
    states=(DEFLECTION,),
    rates=rates,
    pieces=SLIDER,
    guards=guards,
    stored=lambda slip, p: p["sigma_0"] * slip.states["deflection"] ** 2 * slip.N / 2,
    resting=lambda v, p: [steadily(v)],
)
