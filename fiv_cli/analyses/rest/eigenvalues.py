"""Complex eigenvalues of the system linearised at its sliding equilibrium.

Thesis 3.2.1, equations 3.33-3.37; averaged over a fast excitation, 5.15. The Jacobian is exact:
it is generated from the equations, not differenced (``linearisation.py``).
"""

from __future__ import annotations

from fiv_cli.analyses.base import Analysis, Later
from fiv_cli.analyses.rest.modes import COUPLED
from fiv_cli.analyses.rest.system_choice import SYSTEM, averaging
from fiv_cli.analyses.settings import Integer
from fiv_cli.analyses.variables import Subject, Variable, classes, count


def variables(subject: Subject) -> list[Variable]:
    """What is told of each mode, and of the equilibrium."""
    mixed = "each state in its own unit; scaled to length one"
    both = "`mode` counts eigenvalues from 0, both of a conjugate pair; mode_number pairs, from 1"
    return [
        Variable("eigenvalue_real", "rad s-1", "real part of the eigenvalue", "mode"),
        Variable("eigenvalue_imag", "rad s-1", "imaginary part of the eigenvalue", "mode"),
        Variable("mode_frequency", "Hz", "frequency of the mode", "mode", comment=both),
        Variable("damping_ratio", "1", "damping ratio of the mode", "mode"),
        Variable(
            "eigenvector_real", "1", "real part of the eigenvector", "mode state",
            comment=mixed, velocities=True,
        ),
        Variable(
            "eigenvector_imag", "1", "imaginary part of the mode", "mode state",
            comment=mixed, velocities=True,
        ),
        count(
            "coupled_with",
            f"mode_number of the mode of equal frequency, to {COUPLED:.1%}, and another growth; "
            "-1: none",
            "mode",
        ),
        Variable(
            "coupling_point",
            "1",
            "where on the longest numeric axis, in its unit, the mode merges with another, before "
            "the next point",
            "mode",
            comment="between the points, where the two come to differ more in growth than in "
            "frequency, and in both by less than 1 %; with more damping they pass at a distance",
        ),
        Variable("growth_rate", "rad s-1", "largest real part", headline=1),
        Variable("growth_frequency", "Hz", "frequency of the mode that grows most"),
        classes(
            "stable",
            "whether the equilibrium is stable",
            comment="neutral: the largest real part is zero to rounding, as without damping",
            headline=1,
        ),
        *averaging(subject),
    ]  # fmt: skip


ANALYSIS = Analysis(
    "eigenvalues",
    "complex eigenvalues at the sliding equilibrium",
    (
        SYSTEM,
        Integer(
            "at_equilibrium", "which equilibrium, as `equilibrium` numbers them from 1", default=1
        ),
    ),
    variables,
    Later("fiv_cli.analyses.rest.linearisation:eigenvalues_at"),
    uses_starts=False,
    linear=True,
    in_blocks=True,
    figure="eigenvalues",
    answer=(
        "eigenvalues and modes from exact derivatives, followed along the grid, with the points "
        "where modes merge; of the system as it is or averaged over a fast excitation"
    ),
)
