"""Friction with Stribeck effect and a viscous part: it falls, then rises with the slip speed.

    F_T = sgn(v) (mu_k + (mu_s - mu_k) exp(-(|v|/v_s)^delta)) N + F_V v     sliding
    |F_T| <= mu_s N                                                         sticking

Thesis 2.2 and 2.3 together; the curve of Figure 2.1 d and its rise at high speed.
"""

from __future__ import annotations

from dataclasses import replace

from fiv_cli.friction import stribeck
from fiv_cli.friction.viscous import F_V, with_viscous_part

LAW = replace(
    stribeck.LAW,
    name="stribeck-viscous",
    title="Coulomb friction with Stribeck effect and a viscous part",
    reference="thesis 2.2, 2.3",
    numerics_version=1,
    parameters=(*stribeck.LAW.parameters, F_V),
    force=with_viscous_part(stribeck.LAW),
)
