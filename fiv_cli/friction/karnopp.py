"""Coulomb friction whose stick is a band of slip velocities, in which slip stays (Karnopp).

    F_T = sgn(v) mu_k N                 |v| > eta          it slides
    F_T = D                             |D| <= mu_s N      it holds
    F_T = sgn(D) mu_s N                 else               it yields

D is the force demanded: that under which v would stay as it is. Karnopp, ASME J. Dynamic Systems,
Measurement and Control 107 (1985) 100. It is `switch` with alpha = 0, and tends to `coulomb` as
that does; where it lets go the way that it had slid it does so at once, and the order is 1.

What it cannot do: the slip velocity that is left as it begins to hold stays, so that the contact
creeps, at up to eta. Karnopp too keeps the momentum, but reads a velocity of zero while it holds:
here places move as momenta say. Nor can it do what `switch` cannot.
"""

from __future__ import annotations

from dataclasses import replace

from fiv_cli.friction import switch
from fiv_cli.friction.coulomb import MU_K, MU_S

LAW = replace(
    switch.LAW,
    name="karnopp",
    title="Coulomb friction whose stick is a band of slip velocities (Karnopp)",
    reference="Karnopp, J. Dyn. Syst. Meas. Control 107 (1985) 100",
    parameters=(MU_S, MU_K, switch.BAND),
    force=lambda slip, p: switch.force(slip, {**p, "alpha": 0}),
)
