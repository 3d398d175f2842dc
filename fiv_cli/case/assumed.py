"""What is assumed of the model of a case, and is not its author's assumption (`assumed`)."""

from __future__ import annotations

from fiv_cli.case.case import Case
from fiv_cli.models import get_model


def assumed_of_contacts(case: Case) -> list[str]:
    """What is assumed of the forces of contacts that stick jointly; mostly nothing."""
    model = get_model(case.model)
    if model.contacts < 2:
        return []
    from fiv_cli.codegen.joint import assumed  # brings SymPy

    return assumed(model, case.options, case.laws)
