"""The mechanical models, by name."""

from __future__ import annotations

from collections.abc import Iterable

from fiv_cli.models import (
    annular_plate,
    belt_1dof,
    belt_2mass,
    belt_5dof,
    disc_nonlinear_contact,
    disc_rigid_contact,
    excited_2dof,
    excited_disc,
    flutter_2dof,
    pin_on_disc,
)
from fiv_cli.models.base import Model
from fiv_cli.models.excitation import BETWEEN, excited
from fiv_cli.notation.names import declare

_BOX: tuple[Model, ...] = (
    belt_1dof.MODEL,
    belt_2mass.MODEL,
    flutter_2dof.MODEL,
    excited_2dof.MODEL,
    belt_5dof.MODEL,
    annular_plate.MODEL,
    disc_rigid_contact.MODEL,
    excited_disc.MODEL,
    disc_nonlinear_contact.MODEL,
    pin_on_disc.MODEL,
)
_BY_NAME = {model.name: model for model in _BOX}


def all_models() -> dict[str, Model]:
    """Every model, by name (a copy)."""
    return dict(_BY_NAME)


def know_models(models: Iterable[Model], alone: bool = False) -> None:
    """List models that are not in the box; `alone`: no others from outside."""
    if alone:
        _BY_NAME.clear()
        _BY_NAME.update({model.name: model for model in _BOX})
    _BY_NAME.update({model.name: model for model in models})
    declare("models", (p.name for model in _BY_NAME.values() for p in model.parameters))


def get_model(name: str) -> Model:
    """The model called `name`, perhaps an excited one; KeyError when there is none."""
    plain, plus, _ = name.partition(BETWEEN)
    return excited(_BY_NAME[plain], name) if plus else _BY_NAME[name]
