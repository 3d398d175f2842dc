"""What is assumed of the model of a case, and is not its author's assumption (`assumed`)."""

from __future__ import annotations

from fiv_cli.case.case import Case
from fiv_cli.models import get_model


def assumed_of_contacts(case: Case) -> list[str]:
    """What is assumed of the forces of contacts that stick jointly, and of those of a user's model
    that cannot part; mostly nothing."""
    model, found = get_model(case.model), list[str]()
    if model.contacts > 1:
        from fiv_cli.codegen.joint import assumed  # brings SymPy

        found += assumed(model, case.options, case.laws)
    if model.origin is not None:
        from fiv_cli.own.mechanics import pulling  # brings SymPy

        found += pulling(model, case.options)
    return found
