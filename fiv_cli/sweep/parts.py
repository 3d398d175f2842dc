"""One part of a plan, of several that run anywhere, each in a run directory of its own.

    STEM.run/parts/16/division-DIGEST.npy   the part that each unit of the plan belongs to
                      03/                   the run directory of part 3 of 16 (see `journal`)

What is dealt out are units that no two parts can share: points that start on their own, chains, and
the maps of a refined analysis, those as one that chains go through. The first part that begins
deals them, by what points have cost so far, and all others keep to it. Nothing depends on it: who
joins the parts sees points, not parts.
"""

from __future__ import annotations

import hashlib
import io
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fiv_cli.errors import StorageError
from fiv_cli.files import write_first
from fiv_cli.sweep.plan import AnalysisPlan, Plan

FOLDER = "parts"
MOST = 9999  # parts

Numbers = NDArray[np.uint16]
Costs = NDArray[Any]


@dataclass(frozen=True)
class Part:
    """The part with this number, from 1, of so many."""

    number: int
    of: int

    def __str__(self) -> str:
        return f"{self.number}/{self.of}"

    def folder(self, run: Path) -> Path:
        """Its run directory within that of the case."""
        return run / FOLDER / str(self.of) / f"{self.number:0{len(str(self.of))}d}"


def part_folders(run: Path) -> dict[Part, Path]:
    """The parts that have begun and their run directories, in order."""
    found = {}
    for folder in run.glob(f"{FOLDER}/*/*"):
        of, number = folder.parent.name, folder.name
        if of.isdecimal() and number.isdecimal() and 1 <= int(number) <= int(of):
            found[Part(int(number), int(of))] = folder
    return dict(sorted(found.items(), key=lambda item: (item[0].of, item[0].number)))


def divisions(run: Path) -> list[int]:
    """Into how many parts the plan was dealt out, each time that it was."""
    return sorted({part.of for part in part_folders(run)})


def dealt_out(
    plan: Plan, of: int, run: Path, costs: Callable[[], Sequence[Costs]] | None = None
) -> list[Numbers]:
    """The part that each point of each analysis belongs to, (size,), from 1.

    Parameters
    ----------
    costs : of each analysis what its points will take, s; the first who asks deals by them
    """
    units = [_units(analysis) for analysis in plan.analyses]
    path = run / FOLDER / str(of) / f"division-{_digest(plan)}.npy"
    if not path.is_file():
        weights = [np.ones(len(unit)) for unit in units] if costs is None else costs()
        _write(path, _dealt(units, weights, of))
    ends = np.cumsum([0, *(int(unit.max()) + 1 for unit in units)])
    dealt = np.split(np.load(path), ends[1:-1])
    return [parts[unit] for parts, unit in zip(dealt, units, strict=True)]


def _units(analysis: AnalysisPlan) -> NDArray[np.int64]:
    """(size,) number of the unit that each point belongs to."""
    units = np.empty(analysis.size, np.int64)
    if analysis.maps is not None:
        numbers = analysis.maps.numbers
        units[numbers.reshape(len(numbers), -1).T] = np.arange(len(numbers))
        for chains in analysis.chain_sets():
            units[chains.positions] = units[chains.positions].min(axis=1, keepdims=True)
        return units
    singles = analysis.single_positions()
    units[singles] = np.arange(len(singles))
    begin = len(singles)
    for chains in analysis.chain_sets():
        units[chains.positions.T] = begin + np.arange(len(chains.positions))
        begin += len(chains.positions)
    return units


def _dealt(units: Sequence[NDArray[np.int64]], costs: Sequence[Costs], of: int) -> Numbers:
    """The part of each unit of all analyses: the dearest first, there and back again."""
    total = np.concatenate([np.bincount(*pair) for pair in zip(units, costs, strict=True)])
    order = np.argsort(-total, kind="stable")
    there = np.arange(1, of + 1)
    dealt = np.empty(len(total), np.uint16)
    dealt[order] = np.resize(np.concatenate([there, there[::-1]]), len(total))
    return dealt


def _digest(plan: Plan) -> str:
    """Of the points of a plan: another plan is dealt anew."""
    digest = hashlib.sha256()
    for analysis in plan.analyses:
        digest.update(analysis.digest)
    return digest.hexdigest()[:16]


def _write(path: Path, dealt: Numbers) -> None:
    content = io.BytesIO()
    np.save(content, dealt)
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        write_first(path, content.getvalue())
    except OSError as error:
        raise StorageError(
            f"{path}: cannot be written: {error.strerror}\n"
            "next: choose another place with -o FILE.nc"
        ) from error
