"""TOML text to plain values, after a look at how large and how deep it is; and back to text.

``tomllib`` takes time with the square of the parts of a dotted key, and recursion with every
bracket. No case needs much of either, so what is over is refused before it is read.
"""

from __future__ import annotations

import json
import re
import tomllib
from collections.abc import Mapping
from datetime import date, time
from typing import Any

from fiv_cli.errors import CaseError, Problem

MOST_BYTES = 1024 * 1024
DEEPEST = 32
"""Brackets in one another, and parts of a dotted key."""

DICT = "<dict>"
"""Stands for the file of a case that is no file but a dict."""

_BARE_KEY = re.compile(r"[A-Za-z0-9_-]+")
_SURROGATE = re.compile(r"[\ud800-\udfff]")  # half a character
_TOKEN = re.compile(r"\"\"\"|'''|[\"'#\[\]{}.=,\n]")
# What ends a text that begins with these quotes (a match follows the opening).
_REST = {
    '"""': re.compile(r'(?:[^"\\]|\\.|"(?!""))*+"{3,5}', re.DOTALL),
    "'''": re.compile(r"(?:[^']|'(?!''))*+'{3,5}"),
    '"': re.compile(r'(?:[^"\\\n]|\\.)*+"'),
    "'": re.compile(r"[^'\n]*+'"),
    "#": re.compile(r"[^\n]*+"),
}


class TooMuchError(ValueError):
    """A text is larger or nested deeper than any case needs; says what is allowed."""

    def __init__(self, message: str, allowed: str, line: int | None = None) -> None:
        super().__init__(f"{message}; allowed: {allowed}")
        self.message, self.allowed, self.line = message, allowed, line


def parse_toml(text: str) -> dict[str, Any]:
    """What `text` means.

    Raises
    ------
    ValueError
        it is no TOML, or an integer in it is too long to read.
    TooMuchError
        it is too large, or too deep.
    """
    if len(text) > MOST_BYTES:
        raise too_large(len(text))
    place = _too_deep(text)
    if place is not None:
        message = "tables, lists or dotted keys nest too deeply"
        raise TooMuchError(message, f"{DEEPEST} levels", text.count("\n", 0, place) + 1)
    return tomllib.loads(text)


def too_large(size: int) -> TooMuchError:
    """The error of a text of `size` bytes or more."""
    message = f"is too large for a TOML file of fiv ({size:,} bytes)"
    return TooMuchError(message, f"{MOST_BYTES:,} bytes")


def _too_deep(text: str) -> int | None:
    """Where `text` begins to nest too deeply; None where it does not, or is no TOML before that."""
    at = depth = parts = 0
    while (token := _TOKEN.search(text, at)) is not None:
        at, sign = token.end(), token.group()
        if sign in _REST:
            rest = _REST[sign].match(text, at)
            if rest is None:
                return None
            at = rest.end()
            continue
        depth += (sign in "[{") - (sign in "]}")
        parts = parts + 1 if sign == "." else 0
        if max(depth, parts) > DEEPEST:
            return at
    return None


def toml_text(document: Mapping[str, Any]) -> str:
    """The text of a case whose tables are those of `document`.

    Raises
    ------
    CaseError
        something in it can stand in no case file.
    """
    plain = {key: value for key, value in document.items() if not _is_of_tables(value)}
    lines = _entries(plain, "")
    for key, value in document.items():
        if isinstance(value, Mapping):
            lines += ["", f"[{_key(key, '')}]", *_entries(value, f"{key}.")]
        elif key not in plain:
            for index, table in enumerate(value):
                lines += ["", f"[[{_key(key, '')}]]", *_entries(table, f"{key}.{index}.")]
    return "\n".join([*lines, ""])


def plain(value: Any) -> Any:
    """A number or an array of NumPy's as Python's own; anything else as it is."""
    return value.tolist() if hasattr(value, "tolist") else value


def toml_value(value: Any, place: str) -> str:
    """A value as TOML; `place` says where it stands.

    Raises
    ------
    CaseError
        it can stand in no case file.
    """
    value = plain(value)
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, str) and not _SURROGATE.search(value):
        return json.dumps(value, ensure_ascii=False).replace("\x7f", "\\u007f")
    if isinstance(value, int):
        return str(int(value))
    if isinstance(value, float):
        return repr(float(value))
    if isinstance(value, date | time):  # a datetime is a date
        return value.isoformat()
    if isinstance(value, list | tuple):
        return f"[{', '.join(toml_value(v, f'{place}.{i}') for i, v in enumerate(value))}]"
    if isinstance(value, Mapping):
        return f"{{ {', '.join(_entries(value, f'{place}.'))} }}" if value else "{}"
    allowed = "a number, a text, true or false, a list, a dict"
    raise CaseError(DICT, [Problem(place, f"{value!r} can stand in no case", allowed)])


def _is_of_tables(value: Any) -> bool:
    if isinstance(value, list | tuple):
        return bool(value) and all(isinstance(element, Mapping) for element in value)
    return isinstance(value, Mapping)


def _entries(table: Mapping[str, Any], place: str) -> list[str]:
    return [f"{_key(key, place)} = {toml_value(v, f'{place}{key}')}" for key, v in table.items()]


def _key(key: Any, place: str) -> str:
    if not isinstance(key, str):
        raise CaseError(DICT, [Problem(place + repr(key), "is no name", "a text")])
    return key if _BARE_KEY.fullmatch(key) else toml_value(key, place)
