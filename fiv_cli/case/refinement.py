"""The key ``[sweep] refine``: a coarse grid, halved along the borders of a class only."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from fiv_cli.case.axes import AxisError, Candidate, Span, span_of_list
from fiv_cli.case.case import Refinement, StartSpec
from fiv_cli.case.physics import Physics, note_no_axis
from fiv_cli.case.report import Path, Report
from fiv_cli.case.structure import SweepTable
from fiv_cli.notation.names import ascii_name, axis_name
from fiv_cli.notation.units import exact
from fiv_cli.notation.values import check_quantity

PLACE: Path = ("sweep", "refine")


def read_refinement(
    table: SweepTable,
    counted: Sequence[Candidate],
    zips: Sequence[Sequence[str]],
    physics: Physics,
    report: Report,
) -> Refinement | None:
    """What ``refine`` asks for; None where nothing is refined, or not soundly."""
    refine = table.refine
    if refine is None:
        return None
    numeric = [one.name for one in counted if one.unit is not None]
    alone = [name for name in numeric if not any(name in group for group in zips)]
    axes = alone if refine.along is None else list(map(axis_name, refine.along))
    if not _known(axes, alone, physics, report):
        return None
    return Refinement(refine.levels, ascii_name(refine.of), tuple(axes), refine.sample, refine.seed)


def _known(names: Sequence[str], alone: Sequence[str], physics: Physics, report: Report) -> bool:
    """Whether there are axes to halve, and each is a number that stands alone."""
    if not names:
        report.add(PLACE, "there is no numeric axis to halve", "an axis of numbers under [grid]")
    unknown = [name for name in names if name not in alone]
    for name in unknown:
        message = f"{name!r} is no numeric axis that stands alone"
        note_no_axis(name, message, (*PLACE, "along"), alone, physics, report)
    return bool(names) and not unknown


def halved(counted: Sequence[Candidate], refinement: Refinement, report: Report) -> list[Candidate]:
    """The axes with those that are refined on their finest lattice."""
    return [
        _halved(one, refinement.levels, report) if one.name in refinement.axes else one
        for one in counted
    ]


def _halved(axis: Candidate, levels: int, report: Report) -> Candidate:
    written, unit = axis.written, axis.unit or "1"
    try:
        if isinstance(written, list) and written:
            written = span_of_list([exact(check_quantity(value), unit) for value in written])
        if isinstance(written, Span) and written.start > written.stop:
            raise AxisError("its values do not rise evenly")
        if isinstance(written, Span):
            finest = written.halved(levels)
            _refuse_halves(axis, written, finest)
            return replace(axis, written=finest)
    except AxisError as error:
        report.add(
            axis.place,
            f"cannot be halved: {error}",
            "{ start, stop, num }, or an evenly spaced list, that rises",
            'or name the axes to halve: refine = { ..., along = ["..."] }',
        )
    except ValueError:
        pass  # a value that is no number is noted where the values are read
    return axis


def _refuse_halves(axis: Candidate, written: Span, finest: Span) -> None:
    """AxisError where a value is allowed, and one on the way to it is not: whole numbers."""
    axis.read(written.second)  # what is noted where the values are read
    try:
        axis.read(finest.second)
    except ValueError as error:
        raise AxisError(str(error)) from None


def refuse_along_chains(
    refinement: Refinement | None, starts: Sequence[StartSpec], report: Report
) -> None:
    """A point that goes on from its neighbour cannot be run where the neighbour is not."""
    axes = () if refinement is None else refinement.axes
    for index, start in enumerate(starts):
        if start.along in axes:
            others = ", ".join(f'"{name}"' for name in axes if name != start.along)
            report.add(
                ("initial", index),
                f"{start.label!r} follows every point of {start.along!r}; refine leaves some out",
                f"refine = {{ ..., along = [{others}] }}" if others else "",
                "or remove [sweep] refine; the analysis boundary finds the end of a branch",
            )


def coarse_size(size: int, levels: int) -> int:
    """Points of the coarse axis whose finest lattice has `size` points."""
    return (size - 1) // 2**levels + 1
