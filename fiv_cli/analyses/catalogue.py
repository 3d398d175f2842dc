"""Every variable of every analysis: by analysis, or by name where only a dataset is at hand."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from functools import cache
from json import dumps
from math import inf

from fiv_cli.analyses import all_analyses, get_analysis
from fiv_cli.analyses.base import EACH, Analysis, Section, Settings, Varied, as_asked
from fiv_cli.analyses.variables import (
    COMPUTED,
    REASON,
    SLIP_BEYOND,
    STATUS,
    Subject,
    Variable,
    derived,
)  # fmt: skip
from fiv_cli.friction.base import STORED
from fiv_cli.models.base import Model, Options, Parameter, State


def variables_of(
    kind: str,
    model: Model,
    options: Options,
    settings: Settings,
    varying: tuple[Parameter, ...] = (),
    internal: tuple[State, ...] = (),
    reach: float = inf,
) -> tuple[Variable, ...]:
    """Every variable of an analysis of `kind` on `model`, ``status`` and ``reason`` first.

    Parameters
    ----------
    kind : kind of the analysis
    options : options of the model (they decide its states)
    settings : settings of the analysis (``observe`` decides the unit of ``section_value``)
    varying : parameters that vary in time; each is a variable over ``time``
    internal : states of the friction laws, and what they store
    reach : slip speed up to which the laws are known, m/s
    """
    contact = "contact" if model.contacts > 1 else ""
    surface = model.surface is not None
    powers = as_asked(model, settings).powers
    subject = Subject(
        model.states(options), contact, surface, settings, internal, powers, model.stops
    )
    own = list(get_analysis(kind).variables(subject))
    own += [SLIP_BEYOND] if reach < inf and get_analysis(kind).generated else []
    over_time = [Variable(p.name, p.unit, p.meaning, "time", symbol=p.symbol) for p in varying]
    return (STATUS, REASON, *own, *over_time)


ALL_ASKED: Settings = {
    "parameter": Varied("parameter"), "follow": "both", "points": ((0.0, 0.0),),
    "system": "averaged", "section": Section("own"), "powers": EACH,
}  # fmt: skip
"""Settings under which every analysis has all the variables that it can have."""

_ANYTHING = Subject(
    (State("state", "x", "1", "any state"),), "contact", True, ALL_ASKED, (STORED,), stops=1
)


def possible_variables(analysis: Analysis) -> Sequence[Variable]:
    """Every variable that an analysis can have, on a model with a state ``state``."""
    return analysis.variables(_ANYTHING)


@cache
def every_variable() -> Mapping[str, Variable]:
    """All variables that there are, by name; the state ``state`` stands for those of any model."""
    known = [v for analysis in all_analyses().values() for v in possible_variables(analysis)]
    return {v.name: v for v in (STATUS, REASON, COMPUTED, SLIP_BEYOND, *known, *derived(known))}


def named(name: str) -> Variable:
    """What is known of the variable of this name, in a dataset of any model, from its name alone.

    Role and all that goes with it, not its unit or dims. The states of a model and what this
    version does not know are plain answers.
    """
    known, ending = every_variable(), name.rpartition("_")[2]
    plain = Variable(name, "1", name)
    return known.get(name) or known.get(f"state_{ending}") or plain


def computed_by(name: str, along: str = "", had: Collection[str] = ()) -> str:
    """Which kinds of analyses compute a variable (`along` a dim), as a hint; "" where none does.

    One that is `had`, and did not compute it, does so under other settings.
    """
    kinds = [
        kind
        for kind, one in all_analyses().items()
        if any(v.name == name and (not along or along in v.dims) for v in possible_variables(one))
    ]
    again = [kind for kind in kinds if kind in had]
    if again:
        return f"{again[0]} computes it under other settings: fiv kinds {again[0]}"
    return f"[[analysis]] kind = {' or '.join(map(dumps, kinds))} computes it" if kinds else ""


def own_dims() -> list[str]:
    """The dims that variables have besides those of the grid."""
    return list(dict.fromkeys(dim for v in every_variable().values() for dim in v.dims))
