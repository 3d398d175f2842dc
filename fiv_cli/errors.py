"""Everything that can stop a command, as one tree of exceptions with exit codes.

FivError                         1  internal error
├── UsageError                   2  the command line cannot be carried out
│   └── EmptyFigureError         2  a figure would show nothing
├── InputError                   3  an input file (case, dataset, shard) is invalid
│   └── CaseError                3  ... with all that is wrong in its form, names or values
│       └── ModelFileError       3  the same of a file of models and laws
├── DifferenceError              5  two things that should agree differ
├── StoreMismatchError           6  the stored run belongs to another case
├── LockedError                  7  a live run holds the run directory
├── ClusterError                 9  the workers of a cluster are out of reach or cannot be used
└── StorageError                 2  the output cannot be written (no space, no permission)

A message's first line says what and where; its last line says what to type or edit next.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

LONGEST_LINE = 4000  # characters of a line that are shown
LONG_LIST = 80  # characters of what is allowed that are not said twice


def printable(text: str) -> str:
    """`text` for a terminal: what would steer it is escaped, and no line is endless."""
    return "\n".join(map(_shown, text.split("\n")))


def _shown(line: str) -> str:
    rest = len(line) - LONGEST_LINE
    if rest > 0:
        line = f"{line[:LONGEST_LINE]} ... and {rest:,} more characters"
    if line.isprintable():
        return line
    return "".join(c if c.isprintable() else c.encode("unicode_escape").decode() for c in line)


class FivError(Exception):
    """Base of the tree; carries the exit code of the command that it ends."""

    exit_code = 1

    def __str__(self) -> str:
        return printable(super().__str__())


class UsageError(FivError):
    """The command line asks for something that cannot be done as asked."""

    exit_code = 2


class EmptyFigureError(UsageError):
    """A figure would show nothing: of what it draws no point has a value."""


class CrampedFigureError(UsageError):
    """The panels of a figure have no room for what they show; `width` in mm."""

    def __init__(self, message: str, width: float) -> None:
        super().__init__(message)
        self.width = width


class StorageError(UsageError):
    """An output cannot be written: no permission, no space, a folder in the way."""


class InputError(FivError):
    """An input file is invalid."""

    exit_code = 3


@dataclass(frozen=True)
class Problem:
    """One thing wrong in a case file.

    Attributes
    ----------
    path : dotted path of the key, e.g. ``model.parameters.mu_k``
    message : what is wrong, with the offending value
    allowed : what would be accepted (may be empty)
    suggestion : the "did you mean" or next step (may be empty)
    line : line in the file, 1-based, or None where there is none (an override)
    column : column, 1-based, or None
    override : the ``--set`` argument that put the value there (may be empty)
    """

    path: str
    message: str
    allowed: str = ""
    suggestion: str = ""
    line: int | None = None
    column: int | None = None
    override: str = ""

    @property
    def key(self) -> str:
        """The key, and which argument wrote it."""
        return f"{self.path} (--set {self.override})" if self.override else self.path


def _alike(problems: Sequence[Problem]) -> list[list[Problem]]:
    """The problems, those that are the same mistake in several places together."""
    groups: dict[tuple[str, ...], list[Problem]] = {}
    for problem in problems:
        key = problem.key.split(".")[-1]
        same = (key, problem.message, problem.allowed, problem.suggestion)
        groups.setdefault(same, []).append(problem)
    return list(groups.values())


def _place(problem: Problem) -> str:
    """Where a problem is, in a list of places."""
    return problem.key if problem.line is None else f"{problem.path} (line {problem.line})"


class CaseError(InputError):
    """A case file is invalid; holds every problem of a phase, form, names or values.

    Attributes
    ----------
    source : the file, as given
    problems : what is wrong in it
    files : of models and laws that have some of what the case names
    """

    def __init__(self, source: str, problems: Sequence[Problem], files: Sequence[str] = ()) -> None:
        self.source = source
        self.problems = tuple(problems)
        self.files = tuple(dict.fromkeys(files))
        super().__init__("\n".join(self._lines()))

    def _lines(self) -> list[str]:
        alike = _alike(self.problems)
        count = len(alike)
        noun = "problem" if count == 1 else "problems"
        lines = [f"{self.source}: {count} {noun}; nothing was computed"]
        listed: set[str] = set()  # long lists that stand above
        for problem, *others in alike:
            lines.extend(self._describe(problem, problem.allowed in listed))
            listed |= {problem.allowed} if len(problem.allowed) > LONG_LIST else set()
            if others:
                lines.append(f"      likewise: {', '.join(map(_place, others))}")
        added = "".join(f" --with {file}" for file in self.files)
        if added and all(problem.suggestion.startswith(self.files) for problem in self.problems):
            return [*lines, f"next: add{added}: fiv run {self.source}{added}"]
        return [*lines, f"next: correct {self._what_to_correct(added)}"]

    def _what_to_correct(self, added: str) -> str:
        """The file, the arguments, or both; and what to do then, with options `added`."""
        overrides = [bool(problem.override) for problem in self.problems]
        if all(overrides):
            return f"what --set says, then give the same command again{added and ' with'}{added}"
        if self.source.startswith("<"):
            return "it and try again"
        what = "the file and what --set says" if any(overrides) else "the file"
        return f"{what}, then `fiv check {self.source}{added}`"

    def _describe(self, problem: Problem, listed: bool) -> list[str]:
        place = self.source
        if problem.line is not None:
            place += f":{problem.line}"
        if problem.column is not None:
            place += f":{problem.column}"
        lines = [f"  {place}: {problem.key}: {problem.message}"]
        if problem.allowed:
            lines.append(f"      allowed: {'as above' if listed else problem.allowed}")
        if problem.suggestion:
            lines.append(f"      {problem.suggestion}")
        return lines


class ModelFileError(CaseError):
    """Files of models and laws are invalid; holds every problem that was found.

    Attributes
    ----------
    source, problems : of the first of them
    others : (file, what is wrong in it) of those beside it
    """

    def __init__(
        self,
        source: str,
        problems: Sequence[Problem],
        others: Sequence[tuple[str, Sequence[Problem]]] = (),
    ) -> None:
        self.others = tuple(others)
        super().__init__(source, problems)

    def _lines(self) -> list[str]:
        *lines, hint = super()._lines()
        for source, problems in self.others:
            lines += ModelFileError(source, problems)._lines()[:-1]
        return [*lines, hint]

    def _what_to_correct(self, added: str) -> str:
        sources = [self.source, *(source for source, _ in self.others)]
        given = "".join(f" --with {source}" for source in sources)
        return f"the file{'s' if self.others else ''}, then `fiv models{given}`"


class DifferenceError(FivError):
    """Two datasets, or a claim and a dataset, differ."""

    exit_code = 5


class StoreMismatchError(FivError):
    """The stored run at the output path belongs to another case."""

    exit_code = 6


class LockedError(FivError):
    """Another live process holds the run directory."""

    exit_code = 7


class ClusterError(FivError):
    """The scheduler of a cluster does not answer, or none of its workers can be used."""

    exit_code = 9
