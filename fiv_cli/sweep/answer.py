"""What a run has found, in a few lines: classes and reasons with counts, and what to change."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from fiv_cli.flags import REASON, STATUS, TABLES, advice

if TYPE_CHECKING:
    from fiv_cli.sweep.journal import Journal

# Reasons that are told with what they mean; the rest is for `fiv show`.
MOST_REASONS = 3


@dataclass(frozen=True)
class Answer:
    """What one analysis has found.

    Attributes
    ----------
    name : of the analysis
    classes : class -> number of points, the most frequent first; empty where it tells none
    reasons : reason why there is no better answer -> number of points, likewise; of those behind
        the end of a chain none
    asked, open : points that were run, and those of them that have no answer
    not_reached : points behind the end of a chain
    """

    name: str
    classes: dict[str, int]
    reasons: dict[str, int]
    asked: int
    open: int
    not_reached: int

    def lines(self) -> Iterator[str]:
        """For people."""
        listed = ", ".join(f"{name} {count}" for name, count in self.classes.items())
        if listed or self.reasons:
            yield f"  {self.name}: {listed or f'{self.asked - self.open} answers'}"
        for name, count in list(self.reasons.items())[:MOST_REASONS]:
            yield f"    {name} {count}: {advice(name)}"
        if len(self.reasons) > MOST_REASONS:
            yield f"    and {len(self.reasons) - MOST_REASONS} reasons more: fiv show"
        if 2 * self.open > self.asked:
            yield f"  WARNING: {self.open} of {self.asked} points of {self.name} have no answer"
        if self.not_reached:
            yield (
                f"  WARNING: {self.not_reached} points of {self.name} lie behind the end of what "
                'was followed; in its [[initial]], on_loss = "go-on" carries any motion on (of a '
                'cycle that has ended there is none), on_loss = "restart" begins anew'
            )


def answers(journal: Journal) -> list[Answer]:
    """What each analysis has found so far."""
    return [_answer(journal, index) for index in range(len(journal.records))]


def _answer(journal: Journal, index: int) -> Answer:
    analysis, record = journal.plan.analyses[index], journal.records[index]
    wanted = record.wanted()
    status, told = record.status[wanted], record.told[wanted]
    variable = analysis.layout.told
    table = TABLES[variable.flags].names if variable is not None else {}
    behind = status == STATUS.codes["not_reached"]
    asked = np.isin(status, [STATUS.codes[name] for name in ("ok", "failed", "budget")])
    classes = _counts(told[asked], table) if table else {}
    failed = asked & (status != STATUS.codes["ok"])
    undecided = asked & np.isin(told, [c for c, name in table.items() if name == "undecided"])
    return Answer(
        name=analysis.layout.name,
        classes={name: count for name, count in classes.items() if name != "not_computed"},
        reasons=_counts(record.reason[wanted][~behind], REASON.names, but="none"),
        asked=int(asked.sum()),
        open=int((failed | undecided).sum()),
        not_reached=int(behind.sum()),
    )


def _counts(codes: NDArray[np.int8], names: dict[int, str], but: str = "") -> dict[str, int]:
    """Name -> how many, the most frequent first; those that do not occur left out."""
    found, counts = np.unique(codes, return_counts=True)
    pairs = sorted(zip(counts.tolist(), found.tolist(), strict=True), reverse=True)
    return {names[code]: count for count, code in pairs if names[code] != but}
