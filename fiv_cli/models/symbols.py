"""The vocabulary that models and laws are written in."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from copy import copy

import sympy

from fiv_cli.schedule import rate_of


class Symbols:
    """SymPy symbols by name; two calls with one name give the same symbol.

    A parameter that must be written into the code (a structural one) is a number instead; one
    that varies in time is a linear function of it (a scheduled one) or a harmonic one.
    """

    def __init__(
        self, structural: Mapping[str, float] | None = None, scheduled: Collection[str] = ()
    ) -> None:
        self._structural = dict(structural or {})
        self._scheduled = frozenset(scheduled)
        self._varied: frozenset[str] = frozenset()
        self.time = sympy.Symbol("t", real=True)
        self.zone = self._real("zone")

    @staticmethod
    def _real(name: str) -> sympy.Symbol:
        return sympy.Symbol(name, real=True)

    def parameter(self, name: str) -> sympy.Expr:
        """Parameter `name`; a number where its value is structural, a function of a schedule."""
        if name in self._structural:
            return sympy.nsimplify(self._structural[name])
        if name in self._varied:
            return self._real(f"p.{name}") + self.swing(name)
        return self._real(f"p.{name}") + self.parameter_rate(name) * self.time

    def parameter_rate(self, name: str) -> sympy.Expr:
        """Rate of parameter `name`, per second: zero unless it varies in time."""
        if name in self._varied:
            return sympy.diff(self.swing(name), self.time)
        return self._real(f"p.{rate_of(name)}") if name in self._scheduled else sympy.Integer(0)

    def varying(self, names: Collection[str]) -> Symbols:
        """The same symbols, of which these parameters vary harmonically."""
        found = copy(self)
        found._varied = frozenset(names)
        return found

    def swing(self, of: str) -> sympy.Expr:
        """The harmonic part of what is called so: A cos(omega t + phase)."""
        turned = self.parameter(f"omega_{of}") * self.time + self.parameter(f"phase_{of}")
        return self.parameter(f"A_{of}") * sympy.cos(turned)

    def coordinate(self, name: str) -> sympy.Symbol:
        """Generalised coordinate (or internal state of the law)."""
        return self._real(f"q.{name}")

    def velocity(self, name: str) -> sympy.Symbol:
        """Rate of the generalised coordinate `name`."""
        return self._real(f"q.{name}_dot")

    def tangential_force(self, contact: int) -> sympy.Symbol:
        """F_T of a contact, N, along +v_rel on the model."""
        return self._real(f"F_T.{contact}")

    def share(self, contact: int) -> sympy.Symbol:
        """What a contact bears of the demand on all that stick jointly with it."""
        return self._real(f"share.{contact}")

    def normal_force(self, contact: int) -> sympy.Symbol:
        """F_N of a contact, N, positive in compression."""
        return self._real(f"F_N.{contact}")

    def closed(self, contact: int) -> sympy.Symbol:
        """1 while the contact is closed, 0 in separation (for energies)."""
        return self._real(f"closed.{contact}")

    def sign(self, contact: int) -> sympy.Symbol:
        """Sign of slip of a contact, +1 or -1: a property of the contact state."""
        return self._real(f"sign.{contact}")

    def rows(self, contact: int, elements: int, length: int) -> list[list[sympy.Symbol]]:
        """The numbers of the pieces that the elements of a contact's law are in."""
        return [
            [self._real(f"piece.{contact}.{element}.{place}") for place in range(length)]
            for element in range(elements)
        ]

    def in_zone(self, outside: sympy.Expr, inside: sympy.Expr) -> sympy.Expr:
        """`outside` off the sector and `inside` on it, both exactly."""
        return outside * (1 - self.zone) + inside * self.zone
