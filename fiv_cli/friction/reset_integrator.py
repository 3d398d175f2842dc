"""A spring that yields at once at its limit, and holds more than it slides with.

    F_T = (sigma_0 (1 + a) z + sigma_1 dz/dt) N,  dz/dt = v   while |sigma_0 z| < mu_k   it holds
    F_T = sigma_0 z N,  sigma_0 z = +-mu_k                    while +-v > 0              it slides

Thesis 2.14, 2.15 with z_0 = mu_k/sigma_0; sigma_0 and sigma_1 are per unit of normal force, as in
Dahl's law, and the state is z/z_0. At the limit the force falls from (1 + a) mu_k N to mu_k N,
break-away, and as slip turns it jumps back: (1 + a) mu_k is its static coefficient. With a = 0 and
sigma_1 = 0 it is a Jenkins element. While the contact is open the spring stays as it was. Haessig &
Friedland, ASME J. Dynamic Systems, Measurement and Control 113 (1991) 354-362.

As it begins to hold it has energy that no work was done for, a mu_k^2 N/(2 sigma_0), and loses it
at break-away: over a cycle it takes energy, within one it may give more than it was given.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import TYPE_CHECKING

from fiv_cli.friction import jenkins
from fiv_cli.friction.base import Slip
from fiv_cli.friction.lugre import SIGMA_1
from fiv_cli.models.base import Parameter

if TYPE_CHECKING:
    from sympy import Expr


def force(slip: Slip, p: Mapping[str, Expr]) -> Expr:
    """F_T in N (thesis 2.15)."""
    ((way, _),) = slip.rows
    slides, spring = way**2, p["mu_k"] * slip.states[jenkins.BENT.name]
    held = (1 + p["a_stick"]) * spring + p["sigma_1"] * slip.v
    return ((1 - slides) * held + slides * spring) * slip.N


LAW = replace(
    jenkins.LAW,
    name="reset-integrator",
    title="a spring that yields at its limit, with break-away (reset integrator)",
    reference="thesis 2.14, 2.15; Haessig & Friedland, J. Dyn. Syst. Meas. Control 113 (1991) 354",
    numerics_version=1,
    parameters=(
        *jenkins.LAW.parameters,
        Parameter("a_stick", "a", "1", 0.3, "static over sliding friction, less one", "2.15", 0.0),
        SIGMA_1,
    ),
    force=force,
    stored=None,
)
