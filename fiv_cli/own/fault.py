"""One thing that is wrong with a model or a law, and how it is said."""

from __future__ import annotations

import re
from collections.abc import Iterable
from dataclasses import dataclass

from sympy import Expr, sstr

from fiv_cli.errors import Problem
from fiv_cli.notation.names import listed, suggest
from fiv_cli.own.lines import Lines

Place = tuple[str, str | int, str]

SHOWN = 160  # characters of an expression that are shown


@dataclass(frozen=True)
class Fault:
    """One thing wrong.

    Attributes
    ----------
    place : (call, key, keyword) as `Lines.of` takes them; the key is left out of what is said
        where it is a number
    """

    place: Place
    message: str
    allowed: str = ""
    suggestion: str = ""

    def problem(self, lines: Lines) -> Problem:
        """The same with its line."""
        named = ".".join(str(part) for part in self.place if isinstance(part, str) and part)
        line = lines.of(*self.place) or lines.of(self.place[0])
        return Problem(named, self.message, self.allowed, self.suggestion, line)


def none_called(
    call: str, key: str | int, keyword: str, what: str, known: Iterable[str], name: str = ""
) -> Fault:
    """Nothing of this kind is called so; what there is, and what may have been meant."""
    names, wanted = [*known], name or str(key)
    message = f"there is no {what} {wanted!r}"
    return Fault((call, key, keyword), message, listed(names), suggest(wanted, names))


def shown(expression: Expr) -> str:
    """An expression, no longer than a line bears."""
    text = named(sstr(expression))
    return text if len(text) <= SHOWN else f"{text[:SHOWN]} ..."


def named(text: str) -> str:
    """Symbols by the names that a model gives them."""
    return re.sub(r"\b[pq]\.", "", re.sub(r"\b(F_[NT])\.(\d+)", _numbered, text))


def _numbered(force: re.Match[str]) -> str:
    return f"{force[1]} of contact {int(force[2]) + 1}"
