"""What a run has found, in a few lines: classes and reasons with counts, and what to change."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from fiv_cli.analyses.variables import SLIP_BEYOND
from fiv_cli.flags import ATTRACTOR, REASON, STATUS, TABLES, advice, left_out
from fiv_cli.reading import small

if TYPE_CHECKING:
    from fiv_cli.case.case import StartSpec
    from fiv_cli.data.block import Block
    from fiv_cli.sweep.journal import Journal

# Reasons that are told with what they mean; the rest is for `fiv show`.
MOST_REASONS = 3


# Reasons of points that were computed and yet have not all that was asked for.
UNANSWERED = ("no_cycle", "no_return", "undecided_in_part")

LOST = (
    'in its [[initial]], on_loss = "go-on" carries any motion on (of a cycle that has ended there '
    'is none), on_loss = "restart" begins anew'
)
ENDED = (
    "the motion itself ended there, for a reason above, and what begins at the end of that chain "
    'has no beginning; let the axis end before it, or on_loss = "restart" begin anew'
)


@dataclass(frozen=True)
class Answer:
    """What one analysis has found.

    Attributes
    ----------
    name, kind : of the analysis
    options : names of those that the model has
    classes : class -> number of points, the most frequent first; empty where it tells none
    found : the numbers it is asked for, each with its range, where it tells no class
    reasons : reason why there is no better answer -> number of points, likewise; of those behind
        the end of a chain none
    said : reason -> what the first point that has it says of it, if it says anything
    asked, open : points that were run, and those of them that have no answer
    filled : points whose class is filled in, which are not counted
    not_reached : points behind the end of a chain
    going_on : whether every chain carries any motion on
    beyond : points whose friction was not measured, and those that pass what their equations take
        as small, in words
    still : at which end of a bracket what was followed has not ended, and which impacts motions
        have, in words
    """

    name: str
    kind: str
    options: tuple[str, ...]
    classes: dict[str, int]
    found: tuple[str, ...]
    reasons: dict[str, int]
    said: dict[str, str]
    asked: int
    open: int
    filled: int
    not_reached: int
    going_on: bool
    beyond: tuple[str, ...]
    still: tuple[str, ...]

    def lines(self, reasons: bool = True) -> Iterator[str]:
        """For people, with what the reasons mean or without."""
        counts = (f"{name} {count}" for name, count in self.classes.items())
        answered = self.asked - self.open
        told = [*counts, *self.found] or [f"{answered} answer" + "s" * (answered != 1)]
        of = f" (of {self.asked} run; fiv show counts the map)" if self.filled else ""
        yield f"  {self.name}: {', '.join(told)}{of}"
        if reasons:
            yield from self._reasons()
            yield from (f"    {remark}" for remark in self.still)
        if 2 * self.open > self.asked:
            none = "have no answer"
            if self.reasons.get("undecided_in_part", 0) == self.open:
                none += " for all of the bracket"
            yield f"  WARNING: {self.open} of {self.asked} points of {self.name} {none}"
        yield from (f"  WARNING: {remark}" for remark in self.beyond)
        if self.not_reached:
            yield (
                f"  WARNING: {self.not_reached} points of {self.name} lie behind the end of what "
                f"was followed; {ENDED if self.going_on else LOST}"
            )

    def _reasons(self) -> Iterator[str]:
        for name, count in list(self.reasons.items())[:MOST_REASONS]:
            yield f"    {name} {count}: {advice(name, self.kind, self.options)}"
            if name in self.said:
                yield f"      {self.said[name]}"
        if len(self.reasons) > MOST_REASONS:
            yield f"    and {len(self.reasons) - MOST_REASONS} reasons more: fiv show"


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
    undecided |= asked & np.isin(record.reason[wanted], [REASON.codes[n] for n in UNANSWERED])
    reasons = _counts(record.reason[wanted][~behind], REASON.names, but="none")
    return Answer(
        name=analysis.layout.name,
        kind=analysis.layout.kind,
        options=(*journal.plan.case.options, *left_out(analysis.template.settings)),
        classes={name: count for name, count in classes.items() if name != "not_computed"},
        found=() if table else tuple(_found(journal, index)),
        reasons=reasons,
        said=_said(journal, index, [*reasons][:MOST_REASONS]),
        asked=int(asked.sum()),
        open=int((failed | undecided).sum()),
        filled=0 if record.stage is None else int(np.count_nonzero(record.stage.filled)),
        not_reached=int(behind.sum()),
        going_on=all(start.on_loss == "go-on" for start in _followed(journal)),
        beyond=(*_beyond_measured(journal, index), *_beyond_small(journal, index)),
        still=(*_still(journal, index), *_impacts(journal, index)),
    )


def _found(journal: Journal, index: int) -> Iterator[str]:
    """``boundary 6.84 to 14.83 rad s-1 (9, within 2e-07)``: the range of what is asked for, how
    many there are, and how far they may be off."""
    from fiv_cli.reading.datasets import error_of

    variables = journal.plan.analyses[index].layout.variables
    for variable in (one for one in variables if one.headline and one.kind == "float"):
        values = _values_of(journal, index, variable.name)
        errors = _values_of(journal, index, error_of(variable.name))
        known = np.isfinite(values)
        off = _how_exact(errors[known]) if errors.size == known.size else ""
        values = values[known]
        ends = {f"{end:.6g}": None for end in (values.min(), values.max())} if values.size else {}
        unit = "" if variable.units == "1" else f" {variable.units}"
        count = f"{values.size}{off}"
        yield f"{variable.name} {' to '.join(ends) or 'none'}{unit} ({count})"


def _how_exact(errors: NDArray[Any]) -> str:
    """How far values may be off, and of how many that is not known."""
    known = errors[np.isfinite(errors)]
    within = f", within {known.max():.2g}" if known.size else ""
    return within + f", {errors.size - known.size} by an unknown error" * (known.size < errors.size)


def _values_of(journal: Journal, index: int, name: str) -> NDArray[Any]:
    """What the points of the grid have of a variable by now; nothing of what there is not."""
    blocks = [
        np.ravel(block.values[name][positions >= 0])
        for positions, block in journal.blocks(index)
        if name in block.values
    ]
    return np.concatenate([np.zeros(0), *blocks])


def _followed(journal: Journal) -> list[StartSpec]:
    return [start for start in journal.plan.case.starts if start.kind == "continue"]


def _said(journal: Journal, index: int, reasons: Sequence[str]) -> dict[str, str]:
    """What the first point that was run and has a reason says of it; failed points say it apart."""
    analysis, record = journal.plan.analyses[index], journal.records[index]
    found = {}
    for name in reasons:
        has_it = (record.reason == REASON.codes[name]) & (record.status == STATUS.codes["ok"])
        position = int(has_it.argmax())
        message = journal.message_at(index, position) if has_it[position] else ""
        if message:
            found[name] = f"{analysis.named(position)}: {message}"
    return found


def _still(journal: Journal, index: int) -> list[str]:
    """Where what a `boundary` followed has not ended at the end of its bracket."""
    settings = journal.plan.analyses[index].layout.settings
    if settings.get("follow", "none") == "none":
        return []
    from fiv_cli.reading.scans import still

    each = (settings["scan"],)
    looked = {"scan_class": each, "scan_class_back": each, "n_crossings": ()}
    found: dict[str, list[NDArray[Any]]] = {name: [] for name in looked}
    for positions, block in journal.blocks(index):
        for name, shape in looked.items():  # what no point of a block has is not in it
            nothing = np.full((len(positions), *shape), ATTRACTOR.fill_code)
            found[name].append(block.values.get(name, nothing)[positions >= 0])
    if not found["n_crossings"]:
        return []
    classes = {name: np.concatenate(codes) for name, codes in found.items()}
    return still(settings["of"], settings["follow"], classes, classes["n_crossings"])


def _impacts(journal: Journal, index: int) -> Iterator[str]:
    """What is assumed of impacts where motions separate and come back: it decides how large they
    are."""
    case = journal.plan.case
    if case.options.get("impact") == "plastic" and all(axis.name != "impact" for axis in case.axes):
        leave = int((_values_of(journal, index, "separation_fraction") > 0.0).sum())
        told = (
            f"{leave} with separation: contact begins anew at the speed of its partner (impact = "
            '"plastic"); at their own speed: --set model.options.impact=none'
        )
        yield from [told] * bool(leave)


def _beyond_small(journal: Journal, index: int) -> list[str]:
    """How many points pass what the equations of the model take as small."""
    analysis = journal.plan.analyses[index]
    words = {variable.name: variable.long_name for variable in analysis.layout.variables}
    branch = words.get(small.BRANCH[0], "")
    blocks = ((at, one.values | _along(one, branch)) for at, one in journal.blocks(index))
    return small.lines(small.passing_in(journal.plan.case.model, blocks, analysis.size))


def _along(block: Block, branch: str) -> dict[str, NDArray[Any]]:
    """How far the state that the words of a `branch` name goes along that of each point."""
    if small.BRANCH[0] not in block.ragged:
        return {}
    name = small.along_branch(small.observed_along(branch))
    return {name: small.furthest(block.ragged, block.row_sizes["branch"])}


def _beyond_measured(journal: Journal, index: int) -> Iterator[str]:
    """How many points slip faster than their law is known, and where fastest; or nothing."""
    analysis = journal.plan.analyses[index]
    reach, slips = analysis.layout.reach, np.full(analysis.size, np.nan)
    if reach < np.inf:
        for positions, block in journal.blocks(index):
            some, found = positions >= 0, block.values.get(SLIP_BEYOND.name)
            if found is not None:
                slips[positions[some]] = found[some]
    count = int(np.isfinite(slips).sum())
    if count:
        fastest = int(np.nanargmax(slips))
        yield (
            f"{count} of {analysis.size} points of {analysis.layout.name} slip faster than "
            f"friction was measured, {reach:g} m/s, the fastest at {slips[fastest]:.3g} m/s "
            f"(at {analysis.named(fastest)}); there it is that of the last row"
        )


def _counts(codes: NDArray[np.int8], names: dict[int, str], but: str = "") -> dict[str, int]:
    """Name -> how many, the most frequent first; those that do not occur left out."""
    found, counts = np.unique(codes, return_counts=True)
    pairs = sorted(zip(counts.tolist(), found.tolist(), strict=True), reverse=True)
    return {names[code]: count for count, code in pairs if names[code] != but}
