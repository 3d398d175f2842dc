"""The journal of a run: the run directory, its shards, and which points they hold.

STEM.run/   identity.json  what the stored points belong to
            case.toml      the case as it is run, overrides as comments
            shards/        one file per finished chunk; all that is needed for the dataset
            dataset.json   what the dataset was made from, see `receipt`
            run.log        what happened, with dates
            lock           see `lock`
"""

from __future__ import annotations

import json
import re
import shutil
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fiv_cli.data.assemble import Placed
from fiv_cli.data.block import KEY_BYTES, Block, fault_of_block, fill_value
from fiv_cli.data.shard import UnreadableShard, read_shard, write_atomically, write_shard
from fiv_cli.errors import StorageError
from fiv_cli.flags import NOT_COMPUTED, REASONS, STATUS, retried_codes
from fiv_cli.sweep.borders import BLANK
from fiv_cli.sweep.plan import AnalysisPlan, Plan
from fiv_cli.sweep.refine import Stage
from fiv_cli.sweep.worker import ChainState

Positions = NDArray[np.int64]

_NUMBER = re.compile(r"[0-9]{1,18}")
PENDING = STATUS.codes["pending"]
_CODES = ("status", "reason")
_PROVISIONAL = [STATUS.codes["failed"], STATUS.codes["not_reached"]]


@dataclass
class Record:
    """What is stored of one analysis.

    Attributes
    ----------
    status, reason : (size,) codes; pending where nothing is stored
    ran : (size,) points run now; one that failed is tried again in another run, not in this one
    shards : files and the positions of their rows (-1: not a point of this plan), in order
    states : position -> state of the chain after that point
    classes : (size,) values of the class that the analysis is refined along; None: it is not
    """

    status: NDArray[np.int8]
    reason: NDArray[np.int8]
    ran: NDArray[np.bool_]
    shards: list[tuple[Path, Positions]] = field(default_factory=list)
    states: dict[int, ChainState] = field(default_factory=dict)
    classes: NDArray[np.int32] | None = None

    def done(self) -> NDArray[np.bool_]:
        """Which points need not be run again."""
        return self.stored() & ~(self.in_vain() & ~self.ran)

    def in_vain(self) -> NDArray[np.bool_]:
        """Which points have no answer for reasons that do not lie in them."""
        retried = np.isin(self.reason, list(retried_codes()))
        in_vain: NDArray[np.bool_] = retried & np.isin(self.status, _PROVISIONAL)
        return in_vain

    def stored(self) -> NDArray[np.bool_]:
        """Which points have a result, a failed one included."""
        stored: NDArray[np.bool_] = self.status != PENDING
        return stored


class Journal:
    """The stored results of a plan; the only writer of the run directory."""

    def __init__(self, folder: Path, plan: Plan) -> None:
        self.folder = folder
        self.plan = plan
        self.records = [_empty_record(analysis) for analysis in plan.analyses]
        self.ignored: list[tuple[Path, str]] = []
        self._next = 0

    @property
    def shard_folder(self) -> Path:
        """Where the shards are."""
        return self.folder / "shards"

    def load(self) -> None:
        """Read what is stored; files that are not sound shards are listed in `ignored`."""
        paths = sorted(self.shard_folder.glob("*.h5"))
        numbers = [int(path.stem) for path in paths if _NUMBER.fullmatch(path.stem)]
        self._next = max(numbers, default=-1) + 1
        finders: dict[str, _Finder] = {}
        refined: dict[int, list[_Stored]] = {}
        for path in paths:
            try:
                self._take(path, *read_shard(path), finders, refined)
            except UnreadableShard as error:
                self.ignored.append((path, str(error)))
        for index, stored in refined.items():
            self._place(index, stored)

    def _take(
        self,
        path: Path,
        block: Block,
        name: str,
        finders: dict[str, _Finder],
        refined: dict[int, list[_Stored]],
    ) -> None:
        """Register a block, or keep it until it is known which points are wanted."""
        names = [analysis.layout.name for analysis in self.plan.analyses]
        if name not in names:
            raise UnreadableShard(f"it belongs to an analysis {name!r} that the case has not")
        index = names.index(name)
        fault = fault_of_block(block, self.plan.analyses[index].layout.variables)
        if fault:
            raise UnreadableShard(fault)
        states = _states(block)
        if self.plan.analyses[index].maps is not None:
            classes = self._classes(index, block)
            stored = _Stored(path, block.keys, block.status, block.reason, classes)
            refined.setdefault(index, []).append(stored)
            return
        if name not in finders:
            finders[name] = _Finder(self.plan.analyses[index].keys())
        self._register(index, path, finders[name].positions(block.keys), block, states)

    def _place(self, index: int, stored: Sequence[_Stored]) -> None:
        """Register what is stored of a refined analysis: stage by stage, what each stage wants.

        Only points that are wanted need a key; the lattice may have many more.
        """
        record, analysis = self.records[index], self.plan.analyses[index]
        assert record.classes is not None
        finder = _Finder(np.concatenate([one.keys for one in stored]))
        status, reason = (np.concatenate([getattr(s, n) for s in stored]) for n in _CODES)
        classes = np.concatenate([one.classes for one in stored])
        positions = np.full(len(status), -1, np.int64)
        tried = np.zeros(analysis.size, bool)
        while (new := np.flatnonzero(self.wanted(index) & ~tried)).size:
            tried[new] = True
            rows = finder.positions(analysis.keys_of(new))
            new, rows = new[rows >= 0], rows[rows >= 0]
            positions[rows] = new
            record.status[new], record.reason[new] = status[rows], reason[rows]
            record.classes[new] = classes[rows]
        ends = np.cumsum([len(one.status) for one in stored])
        parts = np.split(positions, ends[:-1])
        record.shards += [(s.path, part) for s, part in zip(stored, parts, strict=True)]

    def write(self, index: int, positions: Positions, block: Block) -> None:
        """Store a finished block of the analysis with this index.

        Raises
        ------
        StorageError
            it cannot be written; nothing that is stored is touched.
        """
        path = self.shard_folder / f"{self._next:06d}.h5"
        write_shard(path, block, self.plan.analyses[index].layout.name)
        self._next += 1
        self._register(index, path, positions, block, _states(block))
        self.records[index].ran[positions] = True

    def _register(
        self,
        index: int,
        path: Path,
        positions: Positions,
        block: Block,
        states: Mapping[int, ChainState],
    ) -> None:
        record = self.records[index]
        placed = positions >= 0
        record.shards.append((path, positions))
        record.status[positions[placed]] = block.status[placed]
        record.reason[positions[placed]] = block.reason[placed]
        if record.classes is not None:
            record.classes[positions[placed]] = self._classes(index, block)[placed]
        for row, state in states.items():
            if placed[row]:
                record.states[int(positions[row])] = state

    def _classes(self, index: int, block: Block) -> NDArray[Any]:
        """The class of each row of a block by which its analysis is refined."""
        maps = self.plan.analyses[index].maps
        assert maps is not None
        return block.values.get(maps.refinement.of, np.full(len(block), self.fill(index)))

    def fill(self, index: int) -> int:
        """What the class of a refined analysis is where there is none."""
        analysis = self.plan.analyses[index]
        assert analysis.maps is not None
        name = analysis.maps.refinement.of
        return int(fill_value(next(v for v in analysis.layout.variables if v.name == name)))

    def stage(self, index: int) -> Stage | None:
        """How far a refined analysis has come; None for one of which every point is run."""
        maps, record = self.plan.analyses[index].maps, self.records[index]
        if maps is None:
            return None
        return maps.stage(self.classes(index), record.stored())

    def classes(self, index: int) -> NDArray[np.int32]:
        """Class of each point of a refined analysis, blank where it was run in vain."""
        record = self.records[index]
        assert record.classes is not None
        return np.where(record.in_vain(), np.int32(BLANK), record.classes)

    def wanted(self, index: int) -> NDArray[np.bool_]:
        """Points of an analysis that are to be run, as far as is known, and those that were."""
        stage = self.stage(index)
        return np.ones(self.plan.analyses[index].size, bool) if stage is None else stage.wanted

    def statuses(self, index: int) -> NDArray[np.int8]:
        """Status of every point whose turn has come, (any number,); what is filled in included."""
        stage, status = self.stage(index), self.records[index].status
        if stage is None:
            return status
        filled = np.full(np.count_nonzero(stage.filled), STATUS.codes[NOT_COMPUTED], np.int8)
        return np.concatenate([status[stage.wanted], filled])

    def blocks(self, index: int) -> Iterator[Placed]:
        """The stored blocks of an analysis with the positions of their rows, in order.

        What a refined analysis did not ask for (of a full grid that was run before) is left out.
        """
        wanted = self.wanted(index)
        for path, positions in self.records[index].shards:
            block, _ = read_shard(path)
            yield np.where((positions >= 0) & wanted[positions], positions, -1), block

    def shards(self) -> list[Path]:
        """The files that hold what is stored, in the order in which they count."""
        return [path for record in self.records for path, _ in record.shards]

    def messages(self, index: int, limit: int) -> list[tuple[int, str]]:
        """(position, what) of failed points for different reasons, at most `limit`."""
        found: dict[str, tuple[int, str]] = {}
        failed = STATUS.codes["failed"]
        record = self.records[index]
        for path, positions in record.shards:
            if len(found) >= limit:
                break
            if (record.status[positions[positions >= 0]] == failed).any():
                self._collect(path, positions, record, found)
        return list(found.values())[:limit]

    def _collect(
        self, path: Path, positions: Positions, record: Record, found: dict[str, tuple[int, str]]
    ) -> None:
        block, _ = read_shard(path)
        failed = STATUS.codes["failed"]
        for row in np.flatnonzero((block.status == failed) & (positions >= 0)):
            position = int(positions[row])
            if record.status[position] == failed:
                what = _explained(int(block.reason[row]), block.messages.get(int(row), ""))
                found.setdefault(what, (position, what))


def _states(block: Block) -> dict[int, ChainState]:
    """Row -> state of the chain after it.

    Raises
    ------
    UnreadableShard
        what is stored is none.
    """
    try:
        states = {row: ChainState(**state) for row, state in block.carries.items()}
    except TypeError as error:
        raise UnreadableShard(f"what a chain carries on has another form: {error}") from error
    if not all(state.is_sound() for state in states.values()):
        raise UnreadableShard("what a chain carries on has another form")
    return states


def _explained(code: int, message: str) -> str:
    """Why a point failed: its own words, or what the table of reasons says."""
    reason = REASONS[code]
    return message.partition("\n")[0] or f"{reason.name}: {reason.advice}"


@dataclass(frozen=True)
class _Stored:
    """A block of a refined analysis, as far as is needed to see which points are wanted."""

    path: Path
    keys: NDArray[np.uint8]
    status: NDArray[np.int8]
    reason: NDArray[np.int8]
    classes: NDArray[Any]


class _Finder:
    """Positions of points by key; of equal keys the last counts."""

    def __init__(self, keys: NDArray[np.uint8]) -> None:
        sortable = _as_bytes(keys)
        self._order = np.argsort(sortable, kind="stable")
        self._sorted = sortable[self._order]

    def positions(self, keys: NDArray[np.uint8]) -> Positions:
        """Position of each key; -1 where there is none."""
        wanted = _as_bytes(keys)
        places = np.maximum(np.searchsorted(self._sorted, wanted, side="right") - 1, 0)
        known = self._sorted[places] == wanted
        return np.where(known, self._order[places], -1).astype(np.int64)


def _as_bytes(keys: NDArray[np.uint8]) -> NDArray[Any]:
    """Each key as hexadecimal text: fixed-width strings of NumPy drop trailing zero bytes."""
    digits = np.frombuffer(b"0123456789abcdef", np.uint8)
    text = np.empty((len(keys), 2 * KEY_BYTES), np.uint8)
    text[:, 0::2], text[:, 1::2] = digits[keys >> 4], digits[keys & 15]
    return text.view(f"S{2 * KEY_BYTES}").ravel()


def _empty_record(analysis: AnalysisPlan) -> Record:
    size = analysis.size
    classes = None if analysis.maps is None else np.zeros(size, np.int32)
    status, reason = np.full(size, PENDING, np.int8), np.zeros(size, np.int8)
    return Record(status, reason, np.zeros(size, bool), classes=classes)


def stored_identity(folder: Path) -> dict[str, Any] | None:
    """The document that says what the points in a run directory belong to; None: nothing stored."""
    path = folder / "identity.json"
    try:
        document = json.loads(path.read_text(encoding="utf-8")) if path.is_file() else None
    except (OSError, ValueError, RecursionError):
        return None
    return document if isinstance(document, dict) else None


def create(folder: Path) -> None:
    """Make the run directory.

    Raises
    ------
    StorageError
        it cannot be made.
    """
    try:
        (folder / "shards").mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise StorageError(
            f"{folder}: cannot be created: {error.strerror}\n"
            "next: choose another place with -o FILE.nc"
        ) from error


def write_identity(folder: Path, document: dict[str, Any], case_text: str) -> None:
    """Write what the run directory belongs to, and the case as it is run."""
    text = json.dumps(document, indent=1, sort_keys=True)
    write_atomically(folder / "case.toml", case_text.encode())
    write_atomically(folder / "identity.json", text.encode())


def clear(folder: Path) -> None:
    """Throw the stored results in a run directory away (nothing else that may lie there)."""
    shutil.rmtree(folder / "shards", ignore_errors=True)
    (folder / "identity.json").unlink(missing_ok=True)
