"""Sliding equilibria of the unexcited system: all of them (thesis 3.31, 6.18, 7.12-7.17).

How they are found, and when the set is certified to be complete, is told in ``equilibria.py``.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from fiv_cli.analyses.base import Analysis, Outcome, Request
from fiv_cli.analyses.rest.system_choice import SYSTEM
from fiv_cli.analyses.variables import Subject, Variable, classes, count, trust

if TYPE_CHECKING:
    from fiv_cli.analyses.rest.equilibria import Equilibria, Sliding
    from fiv_cli.dynamics.system import System


def run(system: System, requests: Sequence[Request]) -> list[Outcome]:
    """Equilibria, contact forces there and what is left of the equations (residual)."""
    from fiv_cli.analyses.rest.equilibria import equilibria_at
    from fiv_cli.analyses.rest.linearisation import sliding_systems

    outcomes: dict[int, Outcome] = {}
    points, which = [request.parameters for request in requests], requests[0].settings["system"]
    for rows, sliding in sliding_systems(system, points, which):
        for place, found in enumerate(equilibria_at(sliding)):
            row = int(rows[place])
            outcomes[row] = _outcome(system, points[row], sliding[place], found)
    return [outcomes[row] for row in range(len(requests))]


def _outcome(
    system: System, parameters: Mapping[str, float], state: Sliding, equilibria: Equilibria
) -> Outcome:
    """What is told of a point."""
    from fiv_cli.analyses.rest.surface import at_the_contact

    solutions = equilibria.states
    counts: dict[str, object] = {
        "n_solutions": len(solutions),
        "n_pulling": equilibria.pulling,
        "complete": "certified" if equilibria.certified else "not_certified",
    }
    counts |= {} if equilibria.n_complex is None else {"n_complex": equilibria.n_complex}
    if not solutions:
        return Outcome(status="failed", reason=equilibria.reason, values=counts)
    forces = np.array([state.contact_forces(y) for y in solutions])
    m = len(system.coordinates)
    if system.setup.model.surface is not None:
        counts["w"] = np.array([at_the_contact(system, parameters, y) for y in solutions])
    return Outcome(
        values=counts
        | {
            "equilibrium": np.array([y[:m] for y in solutions]),
            "F_N": _per_contact(forces[:, :, 0]),
            "F_T": _per_contact(forces[:, :, 1]),
            "residual": np.array([np.max(np.abs(state.rates(y))) for y in solutions]),
        }
    )


def _per_contact(values: NDArray[np.float64]) -> NDArray[np.float64]:
    """(solution, contact), or (solution,) on models with one contact."""
    return values[:, 0] if values.shape[1] == 1 else values


_DISPLACEMENT = Variable("w", "m", "displacement of the disc at the contact", "solution")


def variables(subject: Subject) -> list[Variable]:
    """What is told of each solution, and of all."""
    at_contacts = f"solution {subject.contact}"
    return [
        Variable(
            "equilibrium",
            subject.of_states(),
            "sliding equilibrium of the unexcited system",
            "solution state",
            comment=subject.mixed,
        ),
        count(
            "n_solutions",
            "sliding equilibria with closed contacts",
            comment="the first is the one that growing loads lead to, then by distance from it",
            headline=1,
        ),
        count("n_pulling", "real solutions in which a contact would pull"),
        count("n_complex", "solutions that are not real"),
        classes("complete", "whether these are all the solutions"),
        Variable("F_N", "N", "normal contact force", at_contacts, symbol="F_N"),
        Variable("F_T", "N", "tangential contact force", at_contacts, symbol="F_T"),
        trust("residual", "largest acceleration left", "solution"),
        *([_DISPLACEMENT] if subject.surface else []),
    ]


ANALYSIS = Analysis(
    "equilibrium",
    "sliding equilibria of the unexcited system",
    (SYSTEM,),
    variables,
    run,
    uses_starts=False,
    linear=True,
    in_blocks=True,
    answer="all of them and their contact forces; whether that is all is said",
)
