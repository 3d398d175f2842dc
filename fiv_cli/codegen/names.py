"""The numbers that equations and generated code may name."""

from __future__ import annotations

from collections.abc import Mapping

from fiv_cli.friction.base import Law
from fiv_cli.models.base import Model


def parameter_names(model: Model, law: Law, options: Mapping[str, str]) -> list[str]:
    """What equations may name: parameters of the model, then of the law, then derived numbers."""
    own = [p.name for p in model.parameters]
    theirs = [p.name for p in law.parameters if p.name not in own]
    return [*own, *theirs, *(model.derived.names(options) if model.derived else ())]
