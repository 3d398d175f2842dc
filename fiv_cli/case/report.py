"""Collecting everything that is wrong in a case, each with its place."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from typing import Any

from fiv_cli.errors import CaseError, Problem

Path = tuple[str | int, ...]

# Of more, nobody reads the rest; and each costs the time of a "did you mean".
MOST_PROBLEMS = 1000

_BARE = re.compile(r"[^\s.\"'=\[\]]+")


def dotted(path: Path) -> str:
    """``("grid", "initial.x_dot")`` -> ``grid."initial.x_dot"``, as ``--set`` takes it."""
    return ".".join(_part(part) for part in path) or "case"


def in_order(problems: Sequence[Problem]) -> list[Problem]:
    """The problems in the order of the file."""
    return sorted(problems, key=lambda problem: problem.line or 0)


def _part(part: str | int) -> str:
    text = str(part)
    return text if _BARE.fullmatch(text) else f'"{text}"'


class Report:
    """The problems found so far.

    Parameters
    ----------
    source : the file, as given
    lines : path -> line of the file (see `lines.locate`)
    overrides : path -> the ``--set`` argument that put a value there

    Attributes
    ----------
    misread : misspelt axis -> what was noted of it
    """

    def __init__(
        self, source: str, lines: Mapping[Path, int], overrides: Mapping[Path, str]
    ) -> None:
        self.source = source
        self.problems: list[Problem] = []
        self._lines = lines
        self._overrides = overrides
        self._unsure: set[str] = set()
        self.misread: dict[str, tuple[str, str, str]] = {}

    def unsure_of(self, what: str) -> None:
        """Note that a name of a kind (`what`: "axes", "law", ...) was misread.

        What would only follow from that is not noted: a mistake is told once.
        """
        self._unsure.add(what)

    def is_sure_of(self, *kinds: str) -> bool:
        """Whether all names of these kinds were understood."""
        return self._unsure.isdisjoint(kinds)

    def rename(self, written: str, meant: str) -> None:
        """Find the lines of the table `written` under the name `meant` from here on."""
        self._lines = {
            (meant, *path[1:]) if path[0] == written else path: line
            for path, line in self._lines.items()
        }

    def add(self, path: Path, message: str, allowed: str = "", suggestion: str = "") -> None:
        """Note that `message` is wrong with the value at `path`."""
        override = self._override_at(path)
        place = dotted(path) if override is None else f"{dotted(path)} (--set {override})"
        line = None if override is not None else self._line_at(path)
        self.problems.append(Problem(place, message, allowed, suggestion, line))
        if len(self.problems) >= MOST_PROBLEMS:
            enough = Problem("case", f"no more than {MOST_PROBLEMS:,} problems are told")
            raise CaseError(self.source, [*in_order(self.problems), enough])

    def add_problems(self, problems: Sequence[Problem]) -> None:
        """Note problems that know their place already."""
        self.problems.extend(problems)

    def raise_if_any(self, case: Any = None) -> None:
        """CaseError with every problem, and the case as far as it is sure, if there is one."""
        if self.problems:
            raise CaseError(self.source, in_order(self.problems), case)

    def _override_at(self, path: Path) -> str | None:
        """The last override that wrote `path`, or a table above it, or made it on its way."""
        for place, text in reversed(list(self._overrides.items())):
            made = path not in self._lines and place[: len(path)] == path
            if made or path[: len(place)] == place:
                return text
        return None

    def _line_at(self, path: Path) -> int | None:
        """The line of `path`, or of the nearest table above it that the file has."""
        for length in range(len(path), 0, -1):
            if path[:length] in self._lines:
                return self._lines[path[:length]]
        return None
