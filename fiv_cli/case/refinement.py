"""The key ``[sweep] refine``: a coarse grid, halved along the borders of a class only."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from fiv_cli.case.axes import AxisError, Span, span_of_list
from fiv_cli.case.case import Refinement, StartSpec
from fiv_cli.case.physics import Physics, note_no_axis
from fiv_cli.case.report import Path, Report
from fiv_cli.case.structure import SweepTable
from fiv_cli.notation.names import ascii_name
from fiv_cli.notation.units import exact
from fiv_cli.notation.values import check_quantity

if TYPE_CHECKING:
    from fiv_cli.case.grid import Candidate

Form = Span | list[Any]

PLACE: Path = ("sweep", "refine")

MOST_LEVELS = 12
"""A lattice halved more often than this has more points than can be held."""


def read_refinement(
    table: SweepTable | None,
    counted: Sequence[tuple[Candidate, Form]],
    zips: Sequence[Sequence[str]],
    physics: Physics,
    report: Report,
) -> Refinement | None:
    """What ``refine`` asks for; None where nothing is refined, or not soundly."""
    if table is None or table.refine is None:
        return None
    refine = table.refine
    numeric = [candidate.name for candidate, _ in counted if candidate.unit is not None]
    alone = [name for name in numeric if not any(name in group for group in zips)]
    named = None if refine.along is None else [_axis_name(name) for name in refine.along]
    sound = _sound(refine.levels, refine.sample, refine.seed, report)
    if not _known(alone if named is None else named, alone, physics, report) or not sound:
        return None
    axes = tuple(alone if named is None else named)
    return Refinement(refine.levels, ascii_name(refine.of), axes, refine.sample, refine.seed)


def _axis_name(name: str) -> str:
    return ascii_name(name).removeprefix("friction.")


def _sound(levels: int, sample: int | None, seed: int, report: Report) -> bool:
    """Whether the numbers are in their ranges; notes those that are not."""
    if not 1 <= levels <= MOST_LEVELS:
        report.add((*PLACE, "levels"), f"{levels} is out of range", f"1 to {MOST_LEVELS}")
    counts = {"sample": sample or 0, "seed": seed}
    for key, value in counts.items():
        if value < 0:
            report.add((*PLACE, key), f"{value} is out of range", "0 or more")
    return 1 <= levels <= MOST_LEVELS and min(counts.values()) >= 0


def _known(names: Sequence[str], alone: Sequence[str], physics: Physics, report: Report) -> bool:
    """Whether there are axes to halve, and each is a number that stands alone."""
    if not names and report.is_sure_of("axes"):
        report.add(PLACE, "there is no numeric axis to halve", "an axis of numbers under [grid]")
    unknown = [name for name in names if name not in alone]
    for name in unknown:
        message = f"{name!r} is no numeric axis that stands alone"
        note_no_axis(name, message, (*PLACE, "along"), alone, physics, report)
    return bool(names) and not unknown


def halved(
    counted: Sequence[tuple[Candidate, Form]], refinement: Refinement, report: Report
) -> list[tuple[Candidate, Form]]:
    """The axes with those that are refined on their finest lattice."""
    return [
        (one, _halved(one, form, refinement, report) if one.name in refinement.axes else form)
        for one, form in counted
    ]


def _halved(candidate: Candidate, form: Form, refinement: Refinement, report: Report) -> Form:
    try:
        span = form if isinstance(form, Span) else _span(form, candidate)
    except AxisError as error:
        report.add(
            candidate.place,
            f"cannot be halved: {error}",
            "{ start, stop, num } or an evenly spaced list",
            'or name the axes to halve: refine = { ..., along = ["..."] }',
        )
        return form
    except ValueError:
        return form  # a value that is no number is noted where the values are read
    return span.halved(refinement.levels)


def _span(values: list[Any], candidate: Candidate) -> Span:
    unit = candidate.unit or "1"
    if not values:
        raise ValueError("an empty axis")
    return span_of_list([exact(check_quantity(value), unit) for value in values])


def refuse_chains(
    refinement: Refinement | None, starts: Sequence[StartSpec], report: Report
) -> None:
    """A point that goes on from its neighbour cannot be run where the neighbour is not."""
    for index, start in enumerate(starts):
        if refinement is not None and start.kind == "continue":
            report.add(
                ("initial", index),
                f"the start {start.label!r} follows every point of an axis; refine leaves some out",
                'kind = "equilibrium", "state" or "random"',
                "or remove [sweep] refine; the analysis boundary finds the end of a branch",
            )


def coarse_size(size: int, levels: int) -> int:
    """Points of the coarse axis whose finest lattice has `size` points."""
    return (size - 1) // 2**levels + 1
