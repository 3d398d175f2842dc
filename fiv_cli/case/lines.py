"""Where in a TOML text each key stands.

``tomllib`` keeps no positions, so this walks a text that ``tomllib`` has accepted and notes the
line of every key. It need not detect errors: the text is known to be valid.
"""

from __future__ import annotations

import re

from fiv_cli.case.report import Path

_BLANK = re.compile(r"(?:[ \t\r\n]+|#[^\n]*)*")
_STRING = re.compile(
    r'"""(?:\\.|[^\\])*?"""(?:"{0,2})|\'\'\'.*?\'\'\'(?:\'{0,2})|"(?:\\.|[^"\\\n])*"|\'[^\'\n]*\'',
    re.DOTALL,
)
_BARE_KEY = re.compile(r"[A-Za-z0-9_-]+")
_SCALAR = re.compile(r"[^,\]}\n#]+")


def locate(text: str) -> dict[Path, int]:
    """Path of every table, key and array element of a valid TOML `text` -> its line, 1-based."""
    return _Walk(text).run()


class _Walk:
    def __init__(self, text: str) -> None:
        self.text = text
        self.at = 0
        self.counted = self.passed = 0  # up to where lines are counted, and how many there are
        self.lines: dict[Path, int] = {}
        self.counts: dict[Path, int] = {}

    def run(self) -> dict[Path, int]:
        table: Path = ()
        self.skip_blank()
        while self.at < len(self.text):
            table = self.statement(table)
            self.skip_blank()
        return self.lines

    def statement(self, table: Path) -> Path:
        """One header or one ``key = value``; returns the table that is current after it."""
        if self.text.startswith("[[", self.at):
            return self.header(2)
        if self.text[self.at] == "[":
            return self.header(1)
        self.pair(table)
        return table

    def header(self, brackets: int) -> Path:
        line = self.line()
        self.at += brackets
        key = self.key()
        self.skip_blank()
        self.at += brackets
        path = self.resolve(key[:-1]) + key[-1:]
        self.lines.setdefault(path, line)
        if brackets == 1:
            return path
        index = self.counts.get(path, -1) + 1
        self.counts[path] = index
        self.lines[(*path, index)] = line
        return (*path, index)

    def resolve(self, path: Path) -> Path:
        """`path` with the index of the latest element put behind each array of tables."""
        resolved: Path = ()
        for part in path:
            resolved = (*resolved, part)
            if resolved in self.counts:
                resolved = (*resolved, self.counts[resolved])
        return resolved

    def pair(self, table: Path) -> None:
        line = self.line()
        key = self.key()
        for length in range(1, len(key) + 1):
            self.lines.setdefault(table + key[:length], line)
        self.skip_blank()
        self.at += 1  # the "="
        self.skip_blank()
        self.value(table + key)

    def key(self) -> Path:
        parts = [self.key_part()]
        self.skip_blank()
        while self.text.startswith(".", self.at):
            self.at += 1
            self.skip_blank()
            parts.append(self.key_part())
            self.skip_blank()
        return tuple(parts)

    def key_part(self) -> str:
        self.skip_blank()
        quoted = _STRING.match(self.text, self.at)
        if quoted:
            self.at = quoted.end()
            return _unquoted(quoted.group())
        return self.take(_BARE_KEY)

    def value(self, path: Path) -> None:
        opening = self.text[self.at]
        if opening == "[":
            self.elements(path)
        elif opening == "{":
            self.inline_table(path)
        elif opening in "\"'":
            self.take(_STRING)
        else:
            self.take(_SCALAR)

    def elements(self, path: Path) -> None:
        self.at += 1
        index = 0
        while not self.closed("]"):
            self.lines[(*path, index)] = self.line()
            self.value((*path, index))
            index += 1

    def inline_table(self, path: Path) -> None:
        self.at += 1
        while not self.closed("}"):
            self.pair(path)

    def closed(self, bracket: str) -> bool:
        """Step over a comma or the closing `bracket`; True after the latter."""
        self.skip_blank()
        if self.text[self.at] == ",":
            self.at += 1
            self.skip_blank()
        if self.text[self.at] != bracket:
            return False
        self.at += 1
        return True

    def skip_blank(self) -> None:
        self.take(_BLANK)

    def take(self, pattern: re.Pattern[str]) -> str:
        match = pattern.match(self.text, self.at)
        assert match is not None, f"not TOML at offset {self.at}"
        self.at = match.end()
        return match.group()

    def line(self) -> int:
        self.passed += self.text.count("\n", self.counted, self.at)
        self.counted = self.at
        return self.passed + 1


def _unquoted(key: str) -> str:
    """The key that a quoted key means (escapes included)."""
    import tomllib

    return str(tomllib.loads(f"key = {key}")["key"])
