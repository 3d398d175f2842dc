"""What a system is made of: a model under a friction law, and how both are taken."""

from __future__ import annotations

import math
from collections.abc import Hashable, Mapping
from dataclasses import dataclass
from functools import cached_property

from fiv_cli.errors import UsageError
from fiv_cli.friction import get_law
from fiv_cli.friction.base import Law
from fiv_cli.friction.surface import on_surface
from fiv_cli.models import get_model
from fiv_cli.models.base import Contact, Model, followed
from fiv_cli.schedule import STEADY, Schedule

LEAST_ORDER = 14
EXTRA_ORDER = 4.0  # the systems are small: a step costs more in events and roots than in series
DEFAULT_RTOL = 1e-9


def taylor_order(rtol: float) -> int:
    """Even order of the series that costs least at this tolerance: near 5 - ln(rtol)/2.

    Jorba & Zou, Experimental Mathematics 14 (2005) 99, section 3.2, give 1 - ln(rtol)/2 for a cost
    that is all in the series; what is added was measured on the belt and the pin. An odd order
    costs one more than the even one below and hardly lengthens the steps.
    """
    best = 1.0 - 0.5 * math.log(rtol) + EXTRA_ORDER
    return max(LEAST_ORDER, 2 * round(best / 2.0))


@dataclass(frozen=True, eq=False)
class Setup:
    """A model under a friction law: everything that decides the generated code of a system.

    Attributes
    ----------
    model, law : what moves, and how it rubs
    options : every option of the model
    structural : the law's parameters whose value is written into the code
    order : of the Taylor series
    schedule : parameters that vary in time
    """

    model: Model
    law: Law
    options: Mapping[str, str]
    structural: Mapping[str, float]
    order: int
    schedule: Schedule = STEADY

    @classmethod
    def of(
        cls,
        model: str | Model,
        law: str | Law | None = None,
        options: Mapping[str, str] | None = None,
        parameters: Mapping[str, float] | None = None,
        rtol: float = DEFAULT_RTOL,
        schedule: Schedule = STEADY,
    ) -> Setup:
        """A setup from names or objects; what is left out is as the model has it.

        Parameters
        ----------
        law : None: the model's first
        options : those that differ from the model's defaults
        parameters : values, SI, of which the law's structural ones are taken
        rtol : tolerance that the order of the series is made for
        """
        chosen = get_model(model) if isinstance(model, str) else model
        under = law or chosen.default_law
        friction = get_law(under) if isinstance(under, str) else under
        values = parameters or default_parameters(chosen, friction)
        return cls(
            chosen if friction.surface is None else on_surface(chosen, friction),
            friction,
            dict(sorted({**chosen.default_options(), **(options or {})}.items())),
            {name: values[name] for name in friction.structural},
            taylor_order(rtol),
            schedule,
        )

    def law_of(self, contact: Contact) -> Law:
        """How a contact rubs: as the model says, else as the case does."""
        if contact.law is None:
            return self.law
        law, known = get_law(contact.law), {*self.parameter_names, *contact.law_parameters}
        missing = [p.name for p in law.parameters if p.name not in known]
        if missing:
            raise UsageError(
                f"a contact of {self.model.name} has the law {law.name!r} without its "
                f"{', '.join(missing)}\nnext: give it law_parameters={{{missing[0]!r}: ...}}"
            )
        return law

    def own_parameters(self, contact: int, known: Mapping[str, float]) -> dict[str, float]:
        """Values of the parameters of the law of a contact that has its own."""
        import sympy

        from fiv_cli.models.symbols import Symbols

        symbols = Symbols(self.structural)
        mechanics = self.model.mechanics(symbols, self.options)
        table = self.law_of(mechanics.contacts[contact]).parameters
        values = {
            sympy.Symbol(f"p.{name}", real=True): known[name] for name in self.parameter_names
        }
        told = mechanics.law_parameters_at(contact, table, symbols)
        return {name: float(expression.subs(values)) for name, expression in told.items()}

    @cached_property
    def key(self) -> Hashable:
        """The same for two setups that make the same system."""
        options, structural = (
            tuple(sorted(table.items())) for table in (self.options, self.structural)
        )
        return self.model, self.law, options, structural, self.order, self.schedule

    @cached_property
    def parameter_names(self) -> tuple[str, ...]:
        """What equations may name: parameters of model and law, then derived numbers."""
        own, derived = [p.name for p in self.model.parameters], self.model.derived
        theirs = [p.name for p in self.law.parameters if p.name not in own]
        return (*own, *theirs, *(derived.names(self.options) if derived else ()))

    @property
    def title(self) -> str:
        """``belt-1dof with coulomb friction``."""
        return f"{self.model.name} with {self.law.name} friction"


def default_parameters(model: Model, law: Law, **changes: float) -> dict[str, float]:
    """Every parameter of a model under a law, SI: as in `changes`, else at its default."""
    table = model.parameters_under(law)
    given = {p.name: p.default for p in table if p.default is not None} | changes
    return followed(table, given) | given
