"""A model of which the power of each force is told apart: friction, contact by contact, dampers.

    friction    F_T times what a unit of it does to the energies, of each contact
    wear        F_T v_rel, of each contact
    damping     what of the other forces vanishes with the parameters of role ``damping``

As a model under an excitation it is another one, so that of the model itself nothing changes.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import replace
from functools import cache, wraps
from typing import TYPE_CHECKING

from fiv_cli.models.base import Equations, Model, Options

if TYPE_CHECKING:
    from sympy import Expr

    from fiv_cli.models.symbols import Symbols

DAMPING = "damping"


@cache
def with_each_power(model: Model) -> Model:
    """`model` with powers of each contact and of dampers among those that it measures."""
    return replace(
        model,
        name=f"{model.name}, each force apart",
        equations=_equations(model),
        powers={**model.powers, **_words(model)},
    )


def _words(model: Model) -> dict[str, str]:
    """Power -> what it is, in words."""
    found = {DAMPING: "dampers"}
    for number, contact in _contacts(model):
        found |= {
            f"friction{number}": f"friction on the model, {contact}",
            f"wear{number}": f"what friction turns into heat and wear, {contact}",
        }
    return found


def _contacts(model: Model) -> list[tuple[str, str]]:
    """What follows a name at each contact, and what the contact is called."""
    if model.contacts == 1:
        return [("", "at the contact")]
    return [(f"_{i + 1}", f"at contact {i + 1}") for i in range(model.contacts)]


def _equations(model: Model) -> Callable[[Symbols, Options], Equations]:
    @wraps(model.equations)
    def equations(symbols: Symbols, options: Options) -> Equations:
        found = model.equations(symbols, options)
        apart = dict(_of_contacts(model, found, symbols))
        damping = _of_dampers(model, found, symbols)
        return replace(found, powers={**found.powers, **apart, DAMPING: damping})

    return equations


def _of_contacts(model: Model, found: Equations, symbols: Symbols) -> Iterator[tuple[str, Expr]]:
    import sympy

    for i, ((number, _), contact) in enumerate(zip(_contacts(model), found.contacts, strict=True)):
        force = symbols.tangential_force(i)
        responses = {q: sympy.diff(a, force) for q, a in found.accelerations.items()}
        yield f"friction{number}", force * _power(found, symbols, responses)
        yield f"wear{number}", force * contact.slip_velocity


def _of_dampers(model: Model, found: Equations, symbols: Symbols) -> Expr:
    """What they take from the model is lost but for what they pass on to what excites it."""
    names = [p.name for p in model.parameters if p.role == DAMPING]
    names += [f"A_{name}" for name in names if name in model.varied]
    power = _power(found, symbols, found.accelerations) - sum(found.powers.values())
    return power - power.subs({symbols.parameter(name): 0 for name in names})


def _power(found: Equations, symbols: Symbols, accelerations: Mapping[str, Expr]) -> Expr:
    """What these accelerations add to the rate of the energies."""
    import sympy

    energy = sympy.sympify(found.kinetic_energy + found.potential_energy)
    slopes = ((sympy.diff(energy, symbols.velocity(q)), a) for q, a in accelerations.items())
    return sum((slope * a for slope, a in slopes), sympy.Integer(0))
