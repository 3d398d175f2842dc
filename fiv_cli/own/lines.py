"""On which line of a file of models something stands."""

from __future__ import annotations

import ast
import re
import traceback
from collections.abc import Iterator, Mapping
from dataclasses import fields, is_dataclass
from typing import Any

from fiv_cli.errors import Problem
from fiv_cli.friction.base import Law
from fiv_cli.models import base
from fiv_cli.notation.names import suggest

_ALIKE = {"Contact": ("Contact", "stop")}
_TOO_MUCH = re.compile(r"(\w+)\.__init__\(\) got an unexpected keyword argument '(\w+)'.*")
_LACKS = re.compile(r"(?:\w+\.)*?(\w+?)(?:\.__init__)?\(\) missing \d+ .*? arguments?: (.*)")


class Lines:
    """The lines of a text, whose form may be none."""

    def __init__(self, text: str) -> None:
        try:
            tree: ast.AST = ast.parse(text)
        except (SyntaxError, ValueError, RecursionError):
            tree = ast.Module([], [])
        self._nodes = list(ast.walk(tree))

    def of(self, call: str, key: str | int = 0, keyword: str = "") -> int | None:
        """The line of ``call(key, ...)``, or of what it is given as `keyword`.

        Parameters
        ----------
        key : the first argument, or ``name=``; a number: which of the calls, from 0
        """
        calls = sorted(self._calls(call), key=lambda node: node.lineno)
        if isinstance(key, str):
            calls = [node for node in calls if key in _named(node)]
        elif calls:
            calls = [calls[min(key, len(calls) - 1)]]
        for node in calls[:1]:
            given = (k.value.lineno for k in node.keywords if k.arg == keyword)
            return next(given, node.lineno)
        return None

    def of_text(self, text: str) -> int | None:
        """The first line on which a text constant stands."""
        constants = (node for node in self._nodes if isinstance(node, ast.Constant))
        return min((node.lineno for node in constants if node.value == text), default=None)

    def imports(self) -> Iterator[tuple[str, int]]:
        """(package, line) of everything that is imported."""
        for node in self._nodes:
            if isinstance(node, ast.Import):
                yield from ((alias.name.partition(".")[0], node.lineno) for alias in node.names)
            elif isinstance(node, ast.ImportFrom) and not node.level:
                yield (node.module or "").partition(".")[0], node.lineno

    def problem(self, error: BaseException, path: str) -> Problem:
        """What an exception says that came out of the file, with the line that raised it."""
        if isinstance(error, SyntaxError) and error.filename == path:
            return Problem("syntax", error.msg, line=error.lineno, column=error.offset)
        frames = traceback.extract_tb(error.__traceback__)
        line = next((f.lineno for f in reversed(frames) if f.filename == path), None)
        place = next((f.name for f in reversed(frames) if f.filename == path), "file")
        advice = str(error).partition("\nnext: ")[2] or _advice(error)
        return Problem(place.strip("<>"), _said(error), "", advice, line or self.of("Model"))

    def _calls(self, name: str) -> Iterator[ast.Call]:
        for node in self._nodes:
            if isinstance(node, ast.Call):
                called = getattr(node.func, "id", getattr(node.func, "attr", ""))
                if called in _ALIKE.get(name, (name,)):
                    yield node


def _named(call: ast.Call) -> set[object]:
    """What the first argument or ``name=`` of a call is."""
    given = [*call.args[:1], *(k.value for k in call.keywords if k.arg == "name")]
    return {node.value for node in given if isinstance(node, ast.Constant)}


def _said(error: BaseException) -> str:
    """An exception in words."""
    lacks = _LACKS.fullmatch(str(error)) if isinstance(error, TypeError) else None
    if lacks is not None:
        return f"{lacks[1]} is not given {lacks[2]}".replace("'", "")
    given = _TOO_MUCH.fullmatch(str(error))
    if given is not None:
        return f"{given[1]} is given {given[2]!r}, which it does not have"
    if isinstance(error, KeyError):
        return f"there is no {error}"
    first = str(error).partition("\nnext:")[0]
    return first if type(error).__module__.startswith("fiv_cli") else _spoken(error, first)


def _advice(error: BaseException) -> str:
    """What mends a mistake that Python tells in words of its own."""
    if isinstance(error, AttributeError) and isinstance(error.obj, Mapping):
        return f'write ["{error.name}"] for .{error.name}'
    if isinstance(error, AttributeError) and is_dataclass(error.obj):
        return f"it has {', '.join(one.name for one in fields(error.obj))}"
    if isinstance(error, NameError) and hasattr(base, error.name or ""):
        return f"from fiv_cli.models.base import {error.name}"
    return _advice_on_types(str(error)) if isinstance(error, TypeError) else ""


def _advice_on_types(said: str) -> str:
    if "truth value of Relational" in said:
        return (
            "of a slip velocity, slip.sign is the sign and slip.speed the modulus, no `if` is asked"
        )
    if "expression to float" in said or "loop of ufunc" in said:
        return "functions of math and numpy take numbers alone: use those of sympy"
    if said == "'method' object is not subscriptable":
        return 'write ("name") for ["name"]: what `symbols` has is called'
    given = _TOO_MUCH.fullmatch(said)
    kind: Any = given and {**vars(base), "Law": Law}.get(given[1])
    if given is None or kind is None:
        return ""
    names = [one.name for one in fields(kind)]
    return suggest(given[2], names) or f"it has {', '.join(names)}"


def _spoken(error: BaseException, text: str) -> str:
    return f"{type(error).__name__}: {text}" if text else type(error).__name__
