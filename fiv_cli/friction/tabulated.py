"""Measured friction: a table of slip speeds and coefficients, in a file beside the case.

    F_T = sgn(v) scale mu(|v|) N            sliding
    |F_T| <= stiction scale mu(0) N         sticking

mu goes through the rows of the table: as a monotone cubic (Fritsch & Butland, SIAM J. Scientific
and Statistical Computing 5 (1984) 300, whose slopes make no maximum that the table has not), or,
where the file says ``# interpolation: linear``, as straight lines. Outside of the table it is as at
its ends. A case names the file, ``law = "pad.csv"``:

    # interpolation: monotone
    slip velocity (mm/s), coefficient
    0.0, 0.45
    5.0, 0.38

The first column is a speed, in m/s unless the heading says otherwise, and rises from 0 or more.
Each interval is a piece, so that a step costs as under one cubic, however many rows there are;
where speed passes a row is an event. It knows no history: what was measured while speed rose and
while it fell are two tables.
"""

from __future__ import annotations

import re
from bisect import bisect
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from math import isfinite
from typing import TYPE_CHECKING

from fiv_cli.friction.base import Law, Slip
from fiv_cli.friction.intervals import guards, intervals
from fiv_cli.models.base import Parameter
from fiv_cli.notation.units import Unit, parse_unit

if TYPE_CHECKING:
    from sympy import Expr

SUFFIX = ".csv"
FORM = "two columns, slip velocity and coefficient, under a heading"
COLUMNS = ("slip velocity", "coefficient")
MONOTONE, LINEAR = "monotone", "linear"

PARAMETERS = (
    Parameter("scale", "s", "1", 1.0, "factor on the coefficients of the table", "", 0.0),
    Parameter("stiction", "s_s", "1", 1.0, "static coefficient over that at zero speed", "", 1.0),
)


@dataclass(frozen=True)
class Table:
    """Rows of speeds, m/s, that rise, and coefficients; how they are joined."""

    speeds: tuple[float, ...]
    coefficients: tuple[float, ...]
    interpolation: str

    def cubics(self) -> Iterator[tuple[float, float, float, float, float]]:
        """(speed, c0, c1, c2, c3) of the polynomial in the speed above `speed` of each interval."""
        slopes, secants = self._slopes(), self._secants()
        for i, secant in enumerate(secants):
            width = self.speeds[i + 1] - self.speeds[i]
            begin, end = (
                (secant, secant) if self.interpolation == LINEAR else (slopes[i], slopes[i + 1])
            )
            bend, twist = 3 * secant - 2 * begin - end, begin + end - 2 * secant
            yield self.speeds[i], self.coefficients[i], begin, bend / width, twist / width**2

    def _secants(self) -> list[float]:
        rows = zip(pairwise(self.coefficients), pairwise(self.speeds), strict=True)
        return [(b - a) / (w - v) for (a, b), (v, w) in rows]

    def _slopes(self) -> list[float]:
        """At each row; harmonic means of the secants on both sides, zero where these turn."""
        secants = self._secants()
        inner = [_mean(a, b) for a, b in pairwise(secants)]
        return [secants[0], *inner, secants[-1]]


def _mean(left: float, right: float) -> float:
    return 2 * left * right / (left + right) if left * right > 0.0 else 0.0


def read_table(text: str) -> Table:
    """The table that a file holds.

    Raises
    ------
    ValueError
        which row and column is wrong, and why.
    """
    rows: list[tuple[float, float]] = []
    interpolation, factor = MONOTONE, None
    for number, line in enumerate(text.splitlines(), 1):
        if line.lstrip().startswith("#"):
            interpolation = _interpolation(line, number) or interpolation
        elif line.strip():
            cells = [cell.strip() for cell in line.split(",")]
            if len(cells) != len(COLUMNS):
                raise ValueError(f"row {number}: has {len(cells)} columns, not {len(COLUMNS)}")
            if factor is None:
                factor = _factor(cells, number)
            else:
                rows.append(_row(cells, number, factor, rows))
    if len(rows) < 2:
        raise ValueError(f"has {len(rows)} rows under its heading, and needs two")
    speeds, coefficients = zip(*rows, strict=True)
    return Table(speeds, coefficients, interpolation)


def _interpolation(line: str, number: int) -> str:
    """What a comment says of the interpolation; empty where nothing."""
    found = re.fullmatch(r"\s*#\s*interpolation\s*[:=]\s*(.*?)\s*", line)
    if found and found[1] not in (MONOTONE, LINEAR):
        raise ValueError(f"row {number}: interpolation is {MONOTONE} or {LINEAR}, not {found[1]!r}")
    return found[1] if found else ""


def _factor(headings: Sequence[str], number: int) -> float:
    """The unit of the speeds in m/s, of the headings."""
    if _is_number(headings[0]):
        raise ValueError(
            f"row {number}: is no heading; write {', '.join(COLUMNS)} above the numbers"
        )
    speed, coefficient = map(_unit, headings)
    if coefficient is not None:
        raise ValueError(
            f"row {number}, column 2: {headings[1]!r} has a unit; the coefficient has none, and "
            f"the columns are {', '.join(COLUMNS)}"
        )
    unit = speed or Unit(1, length=1, time=-1)  # type: ignore[arg-type]
    if (unit.mass, unit.length, unit.time, unit.angle) != (0, 1, -1, 0):
        raise ValueError(f"row {number}, column 1: {headings[0]!r} is in no unit of speed")
    return float(unit.factor)


def _unit(heading: str) -> Unit | None:
    """What stands behind a heading in brackets; None where nothing does, or that it has none."""
    named = re.search(r"[(\[](.*)[)\]]", heading)
    return None if named is None or named[1].strip() in ("", "1", "-") else parse_unit(named[1])


def _is_number(cell: str) -> bool:
    try:
        return isfinite(float(cell))
    except ValueError:
        return False


def _row(
    cells: Sequence[str], number: int, factor: float, above: Sequence[tuple[float, float]]
) -> tuple[float, float]:
    for column, cell in enumerate(cells, 1):
        place = f"row {number}, column {column} ({COLUMNS[column - 1]}): {cell!r}"
        if not _is_number(cell):
            raise ValueError(f"{place} is no number")
        if float(cell) < 0.0:
            raise ValueError(f"{place} is negative")
    speed = factor * float(cells[0])
    if above and speed <= above[-1][0]:
        raise ValueError(
            f"row {number}, column 1 ({COLUMNS[0]}): {cells[0]!r} is not above the last"
        )
    return speed, float(cells[1])


def force(slip: Slip, p: Mapping[str, Expr]) -> Expr:
    """F_T in N."""
    ((start, c0, c1, c2, c3, *_),) = slip.rows
    above = slip.speed - start
    coefficient = c0 + above * (c1 + above * (c2 + above * c3))
    return slip.sign * p["scale"] * coefficient * slip.N


def _title(table: Table) -> str:
    """What was read, in one line."""
    speeds, coefficients = table.speeds, table.coefficients
    return (
        f"measured friction, {len(speeds)} rows, {min(coefficients):g} to {max(coefficients):g} at "
        f"{speeds[0]:g} to {speeds[-1]:g} m/s, {table.interpolation} between them, constant beyond"
    )


def tabulated(name: str, text: str) -> Law:
    """The law of the table in a file called `name`; ValueError where it holds none."""
    table = read_table(text)
    inner = list(table.cubics())
    first, last = ((table.speeds[i], table.coefficients[i], 0.0, 0.0, 0.0) for i in (0, -1))
    rows = [*([first] if table.speeds[0] > 0.0 else []), *inner, last]
    borders = table.speeds if table.speeds[0] > 0.0 else table.speeds[1:]
    names = [f"interval {number}" for number in range(1, len(rows) + 1)]
    at_rest = table.coefficients[0]
    return Law(
        name=name,
        title=_title(table),
        reference=name,
        numerics_version=1,
        parameters=PARAMETERS,
        force=force,
        capacity=lambda N, p: p["stiction"] * p["scale"] * at_rest * N,
        only_in_stick=("stiction",),
        pieces=intervals(borders, names, rows),
        guards=lambda slip, p: [guards(slip.speed, slip.rows[0])],
        resting=lambda v, p: [names[bisect(borders, abs(v))]],
        reach=table.speeds[-1],
    )
