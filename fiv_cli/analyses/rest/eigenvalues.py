"""Complex eigenvalues of the system linearised at its sliding equilibrium.

Thesis 3.2.1, equations 3.33-3.37; averaged over a fast excitation, 5.15. The Jacobian is exact:
it is generated from the equations, not differenced (``linearisation.py``).
"""

from __future__ import annotations

from fiv_cli.analyses.base import Analysis, Later
from fiv_cli.analyses.rest.linear import SYSTEM
from fiv_cli.analyses.settings import Integer

ANALYSIS = Analysis(
    "eigenvalues",
    "complex eigenvalues at the sliding equilibrium",
    (
        SYSTEM,
        Integer(
            "at_equilibrium", "which equilibrium, as `equilibrium` numbers them from 1", default=1
        ),
    ),
    Later("fiv_cli.analyses.rest.linearisation:eigenvalues_at"),
    uses_starts=False,
    linear=True,
    figure="eigenvalues",
)
