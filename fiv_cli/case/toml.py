"""TOML text to plain values, after a look at how large and how deep it is.

``tomllib`` takes time with the square of the parts of a dotted key, and recursion with every
bracket. No case needs much of either, so what is over is refused before it is read.
"""

from __future__ import annotations

import re
import tomllib
from typing import Any

MOST_BYTES = 1024 * 1024
DEEPEST = 32
"""Brackets in one another, and parts of a dotted key."""

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
