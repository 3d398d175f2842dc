"""Starts in a CSV file beside the case: a header of states, then a start in each row."""

from __future__ import annotations

import csv
import re
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path as FilePath

from fiv_cli.case.physics import Physics, note_no_state
from fiv_cli.case.report import Path, Report
from fiv_cli.notation.names import ascii_name

MOST_BYTES = 16 * 1024 * 1024
CALLED = "starts of a table are called LABEL-000, LABEL-001, ...; LABEL stands in [[initial]]"
HEADER = "a header of states such as x, x_dot [mm/s], then a start in each row"

_COLUMN = re.compile(r"\s*([^\s\[(]+)\s*(?:[\[(]\s*(.*?)\s*[\])])?\s*")


def rows_in(
    name: str, place: Path, physics: Physics, report: Report
) -> Iterator[tuple[Path, Mapping[str, str]]]:
    """Place and cells, with their units, of each row of the file called `name`.

    What is wrong with the file as a whole is noted; then there are no rows.
    """
    with report.noting(place, f"a CSV file beside the case: {HEADER}"):
        table = _read(FilePath(report.source).parent / name, name)
        columns = [_column(cell) for cell in table[0][1]]
        if _check_names([column for column, _ in columns], place, physics, report):
            return iter([*_rows(table[1:], columns, place)])
    return iter(())


def _read(path: FilePath, name: str) -> Sequence[tuple[int, list[str]]]:
    """The rows of a file that are not empty, with their numbers; ValueError where it has none."""
    try:
        if path.stat().st_size > MOST_BYTES:
            raise ValueError(f"{name!r} is larger than {MOST_BYTES // 2**20} MiB")
        lines = path.read_text(encoding="utf-8-sig").splitlines()
        numbered = list(enumerate(csv.reader(lines, delimiter=_delimiter(lines)), start=1))
    except OSError as error:
        raise ValueError(f"{str(path)!r} cannot be read: {error.strerror}") from None
    except (UnicodeDecodeError, csv.Error) as error:
        raise ValueError(f"{name!r} is no CSV file in UTF-8: {error}") from None
    table = [(number, cells) for number, cells in numbered if any(map(str.strip, cells))]
    if len(table) < 2:
        raise ValueError(f"{name!r} holds no starts")
    return table


def _delimiter(lines: Sequence[str]) -> str:
    """What stands between the cells of a header."""
    header = next(filter(str.strip, lines), "")
    return next((mark for mark in ";\t" if mark in header), ",")


def _column(cell: str) -> tuple[str, str]:
    """State and unit of a column: ``x_dot [mm/s]``; a header may begin as a comment does."""
    match = _COLUMN.fullmatch(cell.strip().removeprefix("#"))
    if match is None:
        raise ValueError(f"{cell!r} in its header is no state")
    return ascii_name(match[1]), match[2] or ""


def _check_names(names: Sequence[str], place: Path, physics: Physics, report: Report) -> bool:
    """Whether every column is a state, and no two are the same one."""
    for name in dict.fromkeys(names):
        if name not in physics.units_of_states():
            note_no_state(name, (*place, name), physics, report, CALLED if name == "label" else "")
        elif names.count(name) > 1:
            raise ValueError(f"the column {name} stands in it twice")
    return report.understands(place)


def _rows(
    table: Sequence[tuple[int, list[str]]], columns: Sequence[tuple[str, str]], place: Path
) -> Iterator[tuple[Path, Mapping[str, str]]]:
    for number, cells in table:
        if len(cells) != len(columns):
            message = f"row {number} has {len(cells)} cells, and the header {len(columns)}"
            raise ValueError(message)
        pairs = zip(columns, cells, strict=True)
        row = {name: _with_unit(cell.strip(), unit) for (name, unit), cell in pairs}
        yield (*place, f"row {number}"), row


def _with_unit(cell: str, unit: str) -> str:
    """A number of a column with its unit; what has one of its own keeps it."""
    return cell if cell[-1:].isalpha() else f"{cell} {unit}".strip()
