"""What is assumed of the model of a case, and is not its author's assumption (`assumed`)."""

from __future__ import annotations

from collections.abc import Iterable

from fiv_cli.case.case import Case
from fiv_cli.models import get_model
from fiv_cli.models.base import Model, Options


def assumed_of_contacts(case: Case) -> list[str]:
    """What is assumed of the forces of contacts of the model of a case."""
    return assumed_of(get_model(case.model), case.options, case.laws)


def assumed_of(model: Model, options: Options, laws: Iterable[str]) -> list[str]:
    """That some contacts stick jointly, and that those of a user's model cannot part; mostly
    nothing."""
    found: list[str] = []
    if model.contacts > 1:
        from fiv_cli.codegen.joint import assumed  # brings SymPy

        found += assumed(model, options, laws)
    if model.origin is not None:
        from fiv_cli.own.mechanics import pulling  # brings SymPy

        found += pulling(model, options)
    return found
