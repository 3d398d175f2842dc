"""Collecting everything that is wrong in a case, each with its place."""

from __future__ import annotations

import re
from collections.abc import Collection, Iterator, Mapping, Sequence
from contextlib import contextmanager

from fiv_cli.errors import CaseError, Problem
from fiv_cli.notation.names import listed, suggest

Path = tuple[str | int, ...]

# Of more, nobody reads the rest; and each costs the time of a "did you mean".
MOST_PROBLEMS = 1000

_BARE = re.compile(r"[^\s.\"'=\[\]]+")

MISSING = "is missing"


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

    They are told by phases: first the form of the case, as soon as it is read (`raise_if_broken`),
    then names that nothing has, with values that are wrong whatever was meant by these; then what
    does not fit together. So a mistake is told once: what may only follow from a name that is not
    known waits for it. Keys that a table does not have are told in each phase: they are read as
    what was meant.

    Parameters
    ----------
    source : the file, as given
    lines : path -> line of the file (see `lines.locate`)
    overrides : path -> the ``--set`` argument that put a value there
    """

    def __init__(
        self, source: str, lines: Mapping[Path, int], overrides: Mapping[Path, str]
    ) -> None:
        self.source = source
        self._keys: list[Problem] = []
        self._names: list[Problem] = []
        self._values: list[Problem] = []
        self._relations: list[Problem] = []
        self._relates = False
        self._lines = lines
        self._overrides = overrides
        self._files: list[str] = []

    def add(
        self,
        path: Path,
        message: str,
        allowed: str = "",
        suggestion: str = "",
        of_name: bool = False,
        of_key: bool = False,
        relates: bool = False,
    ) -> None:
        """Note that `message` is wrong with the value at `path`, with its name, or with the key.

        A value may be wrong only as it `relates` to a name in another table.
        """
        values = self._relations if relates or self._relates else self._values
        problems = self._keys if of_key else self._names if of_name else values
        if len(problems) <= MOST_PROBLEMS:
            override = self._override_at(path)
            line = None if override else self._line_at(path)
            problem = Problem(dotted(path), message, allowed, suggestion, line, override=override)
            problems.append(problem)

    def unknown(
        self,
        path: Path,
        message: str,
        name: str,
        known: Collection[str],
        suggestion: str = "",
        of_key: bool = False,
    ) -> None:
        """Note that `name`, at `path`, is none of the `known` names (or keys of its table)."""
        if max(len(self._keys), len(self._names)) <= MOST_PROBLEMS:
            hint = suggestion or suggest(name, known)
            self.add(path, message, listed(known), hint, not of_key, of_key)

    @contextmanager
    def noting(self, path: Path, allowed: str) -> Iterator[None]:
        """A block whose ValueError is noted as what is wrong with the value at `path`."""
        try:
            yield
        except ValueError as error:
            self.add(path, str(error), allowed)

    def go_on_to_relations(self) -> None:
        """From here on values are held against what other tables name."""
        self._relates = True

    def call_for(self, file: str) -> None:
        """Note that this file of models and laws has what the case names."""
        self._files.append(file)

    def add_problems(self, problems: Sequence[Problem]) -> None:
        """Note problems that know their place already."""
        self._values.extend(problems)

    def understands(self, path: Path) -> bool:
        """Whether all names in the table at `path` are known."""
        return not any(problem.path.startswith(f"{dotted(path)}.") for problem in self._names)

    def is_sound(self, path: Path) -> bool:
        """Whether nothing is wrong at `path`, nor below it."""
        at, below = dotted(path), f"{dotted(path)}."
        found = (problem.path for problem in (*self._names, *self._values, *self._relations))
        return not any(place == at or place.startswith(below) for place in found)

    def raise_if_broken(self) -> None:
        """CaseError with every problem, unless there are none but of keys."""
        if self._names or self._values:
            self._raise([*self._keys, *self._names, *self._sure(self._values)])

    def raise_by_phase(self) -> None:
        """CaseError with every unknown key and name, and all else that does not wait for these."""
        asking = ("figure.", "claim.")  # nothing follows from what these name
        waits = any(not problem.path.startswith(asking) for problem in self._names)
        values = self._whatever_meant() if waits else [*self._values, *self._relations]
        self._raise([*self._keys, *self._names, *self._sure(values)])

    def _whatever_meant(self) -> list[Problem]:
        """The values that are wrong in themselves.

        None is of what varies in time, which is read against all else, nor of an unknown law.
        """
        unknown = any(problem.path.startswith("friction.") for problem in self._names)
        waiting = ("schedule.", "forcing.", *(("friction.",) if unknown else ()))
        return [one for one in self._values if not one.path.startswith(waiting)]

    def _sure(self, values: Sequence[Problem]) -> list[Problem]:
        """Those that do not only follow from an unknown key of the same table."""
        in_doubt = {problem.path.rpartition(".")[0] for problem in self._keys}
        return [
            problem
            for problem in values
            if problem.path not in in_doubt
            and (problem.message != MISSING or problem.path.rpartition(".")[0] not in in_doubt)
        ]

    def _raise(self, problems: Sequence[Problem]) -> None:
        if not problems:
            return
        told = in_order(problems)[:MOST_PROBLEMS]
        if len(problems) > MOST_PROBLEMS:
            told.append(Problem("case", f"no more than {MOST_PROBLEMS:,} problems are told"))
        raise CaseError(self.source, told, self._files)

    def is_overridden(self, path: Path) -> bool:
        """Whether the value at `path` is of a ``--set``."""
        return bool(self._override_at(path))

    def _override_at(self, path: Path) -> str:
        """The last override that wrote `path`, or a table above it, or made it on its way."""
        for place, text in reversed(list(self._overrides.items())):
            made = path not in self._lines and place[: len(path)] == path
            if made or path[: len(place)] == place:
                return text
        return ""

    def _line_at(self, path: Path) -> int | None:
        """The line of `path`, or of the nearest table above it that the file has."""
        for length in range(len(path), 0, -1):
            if path[:length] in self._lines:
                return self._lines[path[:length]]
        return None
