"""Coulomb friction with pre-sliding: the contact is a spring that yields (Dahl).

    dz/dt = (1 - sigma_0 z sgn(v)/mu_k) v,    F_T = sigma_0 z N     (thesis 2.11)

z is the deflection of the surfaces' asperities, sigma_0 its stiffness per unit of normal force, so
that the law holds under any load, also one that vanishes; the thesis' sigma_0, a force per length,
is sigma_0 N. In steady sliding F_T = mu_k N. There is no static friction and no break-away: under a
constant force the contact holds, under a pulsating one it creeps. While a contact is open the
deflection stays as it was.
"""

from __future__ import annotations

from dataclasses import replace

from fiv_cli.friction.base import Law
from fiv_cli.friction.coulomb import MU_K
from fiv_cli.models.base import Parameter, State

POSITIVE_MU_K = replace(MU_K, exclusive=True)
SIGMA_0 = Parameter(
    "sigma_0", r"\sigma_0", "m-1", 1e3, "stiffness of the asperities, per normal force", "2.11",
    0.0, exclusive=True,
)  # fmt: skip
DEFLECTION = State("deflection", "z", "m", "deflection of the asperities")

LAW = Law(
    name="dahl",
    title="Coulomb friction with pre-sliding displacement",
    reference="thesis 2.11",
    numerics_version=1,
    parameters=(POSITIVE_MU_K, SIGMA_0),
    force=lambda slip, p: p["sigma_0"] * slip.states["deflection"] * slip.N,
    capacity=None,
    states=(DEFLECTION,),
    stored=lambda slip, p: p["sigma_0"] * slip.states["deflection"] ** 2 * slip.N / 2,
    rates=lambda slip, p: {
        "deflection": slip.v - p["sigma_0"] * slip.states["deflection"] * slip.speed / p["mu_k"],
    },
)
