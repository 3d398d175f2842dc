"""The friction laws, by name."""

from __future__ import annotations

from collections.abc import Iterable

from fiv_cli.friction import (
    bristle,
    coulomb,
    cubic,
    dahl,
    elasto_plastic,
    exponential,
    four_parameter,
    gms,
    hyperbolic,
    hysteretic,
    hysteretic_rough,
    jenkins,
    karnopp,
    linear_regularisation,
    linear_slope,
    lugre,
    none,
    rate_and_state,
    rate_and_state_cutoff,
    rational,
    reset_integrator,
    simscape,
    stefanski,
    stribeck,
    stribeck_viscous,
    switch,
    tanh,
    viscous,
)
from fiv_cli.friction.base import Law
from fiv_cli.models.base import Model
from fiv_cli.notation.names import declare, listed

_LAWS: tuple[Law, ...] = (
    coulomb.LAW,
    viscous.LAW,
    stribeck.LAW,
    stribeck_viscous.LAW,
    exponential.LAW,
    linear_slope.LAW,
    hyperbolic.LAW,
    four_parameter.LAW,
    rational.LAW,
    cubic.LAW,
    simscape.LAW,
    linear_regularisation.LAW,
    switch.LAW,
    karnopp.LAW,
    dahl.LAW,
    jenkins.LAW,
    reset_integrator.LAW,
    gms.LAW,
    bristle.LAW,
    lugre.LAW,
    elasto_plastic.LAW,
    rate_and_state.LAW,
    rate_and_state_cutoff.LAW,
    stefanski.LAW,
    hysteretic.LAW,
    hysteretic_rough.LAW,
)

TANH_OF = "tanh of "


def _with_regularised(laws: Iterable[Law]) -> dict[str, Law]:
    """Laws by name, and behind them the regularised forms of those that are set-valued."""
    plain = tuple(laws)
    whole = (law for law in plain if law.kind == "set-valued" and not law.pieces)
    smooth = map(tanh.regularised, whole)
    return {law.name: law for law in (*plain, *smooth)}


_BOX = _with_regularised(_LAWS)
_BY_NAME = dict(_BOX)


def all_laws() -> dict[str, Law]:
    """Every friction law, by name, each law's regularised form included (a copy)."""
    return dict(_BY_NAME)


def know_laws(laws: Iterable[Law], alone: bool = False) -> None:
    """List laws that are not in the box; `alone`: no others from outside."""
    known = dict(_BOX) if alone else dict(_BY_NAME)
    _BY_NAME.clear()
    _BY_NAME.update(known | _with_regularised(laws))
    declare("laws", (p.name for law in _BY_NAME.values() for p in law.parameters))


def get_law(name: str) -> Law:
    """The law called `name` (``coulomb``, ``tanh of coulomb``); KeyError where none is listed.

    ``none`` is that of models without a contact; it is not listed.
    """
    law = none.LAW if name == none.LAW.name else _BY_NAME.get(name)
    if law is None:
        raise KeyError(f"no law {name!r} is listed in fiv_cli/friction/__init__.py")
    return law


def laws_of(model: Model) -> tuple[str, ...]:
    """The names of the laws that `model` takes, its default first: all but those it cannot."""
    if not model.contacts:
        return (none.LAW.name,)
    fit = (name for name, law in _BY_NAME.items() if not why_unfit(model, law))
    return tuple(dict.fromkeys((model.default_law, *fit)))


def why_unfit(model: Model, law: Law) -> str:
    """Why `model` cannot take `law`, in words; empty where it can."""
    if not model.contacts:
        return f"{model.name} has no frictional contact"
    if law.constant_load and not model.constant_load:
        return f"{law.name!r} gives a force whatever the load, and that of {model.name} varies"
    for what, own, others in (
        ("parameters", law.parameters, model.parameters),
        ("states", law.states, model.states(model.default_options())),
    ):
        shared = {one.name for one in own} & {one.name for one in others}
        if shared:
            origin = law.origin or model.origin
            rename = f"; give it another name in {origin.path}" if origin else ""
            return (
                f"{law.name!r} and {model.name} have {what} of one name: {listed(shared)}{rename}"
            )
    return ""
