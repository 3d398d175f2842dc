"""The friction laws, by name."""

from __future__ import annotations

from fiv_cli.friction import coulomb, exponential, hyperbolic, linear_slope, none, stribeck, tanh
from fiv_cli.friction.base import Law

_LAWS: tuple[Law, ...] = (
    coulomb.LAW,
    stribeck.LAW,
    exponential.LAW,
    linear_slope.LAW,
    hyperbolic.LAW,
)

TANH_OF = "tanh of "


_REGULARISED = tuple(map(tanh.regularised, _LAWS))


def all_laws() -> dict[str, Law]:
    """Every friction law, by name, each law's regularised form included (a copy)."""
    return {law.name: law for law in (*_LAWS, *_REGULARISED)}


def get_law(name: str) -> Law:
    """The law called `name` (``coulomb``, ``tanh of coulomb``); KeyError where none is listed.

    ``none`` is that of models without a contact; it is not listed.
    """
    laws = {none.LAW.name: none.LAW, **all_laws()}
    if name not in laws:
        raise KeyError(f"no law {name!r} is listed in fiv_cli/friction/__init__.py")
    return laws[name]
