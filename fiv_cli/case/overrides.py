"""``--set PATH=VALUE``: changing a case from the command line.

A path is dotted (``grid.mu_k``, ``analysis.0.t_max``, ``grid."initial.x_dot"``); an element of an
array of tables goes by its index or by its name or label. A value is TOML; a bare word that is
no TOML is a string.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from copy import deepcopy
from dataclasses import dataclass, replace
from typing import Any

from fiv_cli.case.report import Path, dotted
from fiv_cli.case.toml import DEEPEST, TooMuchError, parse_toml
from fiv_cli.errors import Problem, UsageError
from fiv_cli.notation.names import axis_name, listed, suggest

_KEY = r"""(?:"[^"]*"|'[^']*'|[^\s."'=\[\]]+)"""
_PATH = re.compile(rf"\s*({_KEY}(?:\.{_KEY})*)\s*=(.*)", re.DOTALL)
_BARE_WORD = re.compile(r"""[^\[\]{}"',=#\n]+""")
_NAMING_KEYS = ("name", "label", "kind")
# A name with a dot in it may be written without quotes: initial.x = ..., friction.mu_k = ...
WITH_A_DOT = ("friction", "initial")


@dataclass(frozen=True)
class Override:
    """One ``--set``: its text, the keys of its path, and its value."""

    text: str
    keys: tuple[str, ...]
    value: Any


def parse_override(text: str) -> Override:
    """Read ``PATH=VALUE``; UsageError when it has not that form."""
    match = _PATH.fullmatch(text)
    if match is None:
        raise _malformed(text, "PATH=VALUE is wanted")
    keys = tuple(key.strip("\"'") for key in re.findall(_KEY, match[1]))
    if len(keys) > DEEPEST:
        raise _malformed(text[:80], f"a path of {len(keys)} parts; at most {DEEPEST} are allowed")
    return Override(text, keys, _value(text, match[2].strip()))


def apply_overrides(
    document: dict[str, Any], overrides: Sequence[Override]
) -> tuple[dict[str, Any], dict[Path, str], list[Problem]]:
    """A copy of `document` with `overrides` in it, the places written, and what has no place.

    A parameter that is made an axis is no longer fixed by the document.
    """
    changed = deepcopy(document)
    places: dict[Path, str] = {}
    problems = []
    for override in overrides:
        try:
            place = _write(changed, _as_written(changed, override))
        except _NoPlace as error:
            problems.append(error.problem)
        else:
            places.pop(place, None)
            places[place] = override.text
            _let_vary(changed, place, places)
    return changed, places, problems


def _as_written(document: Mapping[str, Any], override: Override) -> Override:
    """The override of an axis at the name that the document gives it, as ``friction.μ_k``."""
    keys, grid = override.keys, document.get("grid")
    if keys[0] != "grid" or not isinstance(grid, dict):
        return override
    written: dict[str, tuple[str, ...]] = {}
    for name, value in grid.items():
        inner = value if name in WITH_A_DOT and isinstance(value, dict) else {}
        written |= {axis_name(f"{name}.{key}"): ("grid", name, key) for key in inner}
        written |= {} if inner else {axis_name(name): ("grid", name)}
    is_dotted = len(keys) > 2 and keys[1] in WITH_A_DOT and not keys[2].isdigit()
    end = 3 if is_dotted else 2
    name = axis_name(".".join(keys[1:end]))
    if name in written:
        return replace(override, keys=(*written[name], *keys[end:]))
    if is_dotted and not isinstance(grid.get(keys[1], {}), dict):  # a list of laws
        return replace(override, keys=("grid", f"{keys[1]}.{keys[2]}", *keys[3:]))
    return override


def _let_vary(document: dict[str, Any], place: Path, places: Mapping[Path, str]) -> None:
    """Take away what fixes the parameter, or the law, that `place` makes an axis.

    What another override fixes stays, and is told.
    """
    if len(place) < 2 or place[0] != "grid":
        return
    axis = axis_name(".".join(map(str, place[1:])))
    name = "law" if axis == "friction" else axis
    for home in (("model", "parameters"), ("friction",)):
        table: Any = document
        for key in home:
            table = table.get(key) if isinstance(table, dict) else None
        if isinstance(table, dict) and (*home, name) not in places:
            table.pop(name, None)


class _NoPlace(Exception):
    def __init__(self, override: Override, message: str, suggestion: str = "") -> None:
        place = dotted(override.keys)
        self.problem = Problem(place, message, suggestion=suggestion, override=override.text)


def _write(document: dict[str, Any], override: Override) -> Path:
    """Put the value where the path says, making tables on the way; returns the place."""
    parent: Any = document
    place: Path = ()
    for key, following in zip(override.keys[:-1], override.keys[1:], strict=True):
        step = _step(parent, key, override)
        place = (*place, step)
        if isinstance(parent, dict):
            parent.setdefault(step, [] if _starts_array(place, following) else {})
        parent = parent[step]
    last = _step(parent, override.keys[-1], override)
    parent[last] = override.value
    return (*place, last)


def _starts_array(place: Path, following: str) -> bool:
    return place in (("analysis",), ("initial",), ("figure",), ("claim",)) and following == "0"


def _step(parent: Any, key: str, override: Override) -> str | int:
    """The key or index that `key` means in `parent`."""
    if isinstance(parent, dict):
        return key
    if not isinstance(parent, list):
        raise _NoPlace(override, f"there is no {key!r} to set: what stands above it is no table")
    if key == "0" and not parent:
        parent.append({})
    if key.isdigit() and int(key) < len(parent):
        return int(key)
    return _index_by_name(parent, key, override)


def names_of(elements: Sequence[Any]) -> list[str]:
    """What the tables of an array of tables are called."""
    tables = (element for element in elements if isinstance(element, dict))
    return [next((str(t[key]) for key in _NAMING_KEYS if key in t), "") for t in tables]


def _index_by_name(elements: list[Any], key: str, override: Override) -> int:
    names = names_of(elements)
    if key in names:
        return names.index(key)
    known = [*map(str, range(len(elements))), *names]
    hint = suggest(key, known) or f"there are: {listed(known)}"
    raise _NoPlace(override, f"there is no element {key!r}", hint)


def _value(text: str, value: str) -> Any:
    try:
        parsed = parse_toml(f"value = {value}")
    except TooMuchError as error:
        raise _malformed(text[:80], str(error)) from None
    except ValueError:
        if _BARE_WORD.fullmatch(value):
            return value
        raise _malformed(text, f"{value!r} is neither a TOML value nor a bare word") from None
    if set(parsed) != {"value"}:
        raise _malformed(text, "one value is wanted")
    return parsed["value"]


def _malformed(text: str, reason: str) -> UsageError:
    return UsageError(
        f"--set {text}: {reason}\n"
        "next: write it like --set grid.mu_k=[0.3] or --set 'model.parameters.N0=\"30 N\"'"
    )
