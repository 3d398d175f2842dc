"""The journal of a run: the run directory, its shards, and which points they hold.

STEM.run/   identity.json  what the stored points belong to
            case.toml      the case as it is run, overrides as comments
            shards/        one file per finished chunk; all that is needed for the dataset
            parts/         run directories of parts of the plan, see `parts`
            dataset.json   what the dataset was made from, see `receipt`
            run.log        what happened, with dates
            lock           see `lock`
"""

from __future__ import annotations

import json
import os
import re
import shutil
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from fiv_cli.data.block import KEY_BYTES, Block, fault_of_block, joined
from fiv_cli.data.shard import UnreadableShard, read_shard, write_atomically, write_shard
from fiv_cli.errors import StorageError
from fiv_cli.flags import NOT_COMPUTED, STATUS, retried_codes
from fiv_cli.sweep.borders import BLANK
from fiv_cli.sweep.failures import explained
from fiv_cli.sweep.plan import AnalysisPlan, Plan
from fiv_cli.sweep.refine import Stage
from fiv_cli.sweep.worker import ChainState

if TYPE_CHECKING:
    from fiv_cli.data.assemble import Placed

Positions = NDArray[np.int64]

_NUMBER = re.compile(r"[0-9]{1,18}")
OK, PENDING = STATUS.codes["ok"], STATUS.codes["pending"]
_PROVISIONAL = [STATUS.codes["failed"], STATUS.codes["not_reached"]]


DECISIVE = 16
"""Bytes of a key by which a point is known: of 1e9 points no two share them by chance."""

KEPT = 16 * 2**20
"""Bytes of results that stay in memory until the dataset is made; the rest is read again."""

AGES = (2**19, 2**23)
"""Bytes from which a shard is no longer young, and from which it is old, and stays as it is."""

MANY, LARGEST = 32, 64 * 2**20
"""Shards of an age that are merged, and how large, in bytes, what comes of it may be."""


@dataclass(frozen=True)
class Shard:
    """A stored block.

    Attributes
    ----------
    path : its file
    positions : of its rows; -1: not a point of this plan
    nbytes : that its arrays take
    row_sizes, shapes : of the block
    kept : the block itself; None where it is read again when it is needed
    """

    path: Path
    positions: Positions
    nbytes: int
    row_sizes: Mapping[str, NDArray[np.int32]]
    shapes: Mapping[str, tuple[int, ...]]
    kept: Block | None

    def block(self) -> Block:
        """What is stored."""
        return read_shard(self.path)[0] if self.kept is None else self.kept


@dataclass
class Record:
    """What is stored of one analysis.

    Attributes
    ----------
    status, reason : (size,) codes; pending where nothing is stored
    told : (size,) codes of the class that the analysis tells of each point
    mine : (size,) points that are this journal's business: all of them, or one part
    ran : (size,) points run now; one that failed is tried again in another run, not in this one
    goes_on : (size,) points that others of their chains begin from
    shards : the stored blocks, in order
    states : position -> state of the chain after that point, which goes on from it
    classes : (size,) values of the class along whose borders the analysis is refined; of one that
        is not refined, empty
    stage : how far a refined analysis has come; None: every point is run
    """

    status: NDArray[np.int8]
    reason: NDArray[np.int8]
    told: NDArray[np.int8]
    mine: NDArray[np.bool_]
    ran: NDArray[np.bool_]
    goes_on: NDArray[np.bool_]
    classes: NDArray[np.int32]
    shards: list[Shard] = field(default_factory=list)
    states: dict[int, ChainState] = field(default_factory=dict)
    stage: Stage | None = None

    def wanted(self) -> NDArray[np.bool_]:
        """Which points are to be run, as far as is known, and which were."""
        return self.mine if self.stage is None else self.stage.wanted & self.mine

    def done(self) -> NDArray[np.bool_]:
        """Which points need not be run again."""
        return self.stored() & ~(self.in_vain() & ~self.ran)

    def in_vain(self) -> NDArray[np.bool_]:
        """Which points have no answer for reasons that do not lie in them."""
        return _in_vain(self.status, self.reason)

    def outdoes(self, block: Block, positions: Positions) -> NDArray[np.bool_]:
        """Rows of a block that failed in vain where there is an answer (from another part)."""
        status, reason = self.status[positions], self.reason[positions]
        answered = (status != PENDING) & ~_in_vain(status, reason)
        return _in_vain(block.status, block.reason) & answered

    def surviving(self, positions: Positions, blocks: Sequence[Block]) -> Positions:
        """Rows of blocks that must be kept: of each point the last, by position.

        Those of no point of this plan stay, as another plan may have them; what failed in vain goes
        where there is an answer by now, or no point.
        """
        status = np.concatenate([block.status for block in blocks])
        reason = np.concatenate([block.reason for block in blocks])
        answered = self.stored() & ~self.in_vain()
        superseded = _in_vain(status, reason) & ((positions < 0) | answered[positions])
        _, last = np.unique(positions[::-1], return_index=True)
        latest = positions < 0
        latest[len(positions) - 1 - last] = True
        rows = np.flatnonzero(latest & ~superseded)
        return rows[np.argsort(positions[rows], kind="stable")]

    def stored(self) -> NDArray[np.bool_]:
        """Which points have a result, a failed one included."""
        stored: NDArray[np.bool_] = self.status != PENDING
        return stored

    @property
    def grows(self) -> bool:
        """Whether what is to be run is not all known yet: a map is still being refined."""
        return self.stage is not None and not self.stage.complete

    def told_classes(self) -> NDArray[np.int32]:
        """Class of each point of a refined analysis, blank where it was run in vain."""
        return np.where(self.in_vain(), np.int32(BLANK), self.classes)


def _in_vain(status: NDArray[np.int8], reason: NDArray[np.int8]) -> NDArray[np.bool_]:
    """Which points have no answer for reasons that do not lie in them."""
    retried = np.isin(reason, list(retried_codes()))
    in_vain: NDArray[np.bool_] = retried & np.isin(status, _PROVISIONAL)
    return in_vain


class Journal:
    """The stored results of a plan; the only writer of the run directory.

    Parameters
    ----------
    others : run directories whose shards are read too, of parts of the plan (see `parts`)
    mine : of each analysis the points to run; None: all
    """

    def __init__(
        self,
        folder: Path,
        plan: Plan,
        others: Iterable[Path] = (),
        mine: Sequence[NDArray[np.bool_]] | None = None,
    ) -> None:
        self.folder, self.plan = folder, plan
        self._others = tuple(others)
        self.records = [_empty_record(analysis) for analysis in plan.analyses]
        for record, own in zip(self.records, mine or (), strict=False):
            record.mine = own
        self.ignored: list[tuple[Path, str]] = []
        self._next = 0
        self._kept = 0
        self.ask()

    @property
    def grows(self) -> bool:
        """Whether what is to be run of some analysis is not all known yet."""
        return any(record.grows for record in self.records)

    @property
    def shard_folder(self) -> Path:
        """Where the shards are."""
        return self.folder / "shards"

    def load(self) -> None:
        """Read what is stored; files that are not sound shards are listed in `ignored`.

        Those that a live run merges meanwhile are gone: what they became is read instead.
        """
        finders: dict[int, _Finder] = {}
        read: set[Path] = set()
        while paths := [path for path in self._paths() if path not in read]:
            read.update(paths)
            for path in paths:
                try:
                    self._take(path, *read_shard(path), finders)
                except UnreadableShard as error:
                    if os.path.lexists(path):
                        self.ignored.append((path, str(error)))
        self._next = 1 + max(self._numbers(read), default=-1)
        self.ask()

    def _paths(self) -> Iterator[Path]:
        """The files among the shards, its own first, in their order."""
        for folder in (self.folder, *self._others):
            yield from sorted(folder.glob("shards/*.h5"))

    def _numbers(self, paths: Iterable[Path]) -> Iterator[int]:
        own = (path.stem for path in paths if path.parent == self.shard_folder)
        yield from (int(stem) for stem in own if _NUMBER.fullmatch(stem))

    def _take(self, path: Path, block: Block, name: str, finders: dict[int, _Finder]) -> None:
        """Register a block that was read."""
        names = [analysis.layout.name for analysis in self.plan.analyses]
        if name not in names:
            raise UnreadableShard(f"it belongs to an analysis {name!r} that the case has not")
        index = names.index(name)
        analysis = self.plan.analyses[index]
        fault = fault_of_block(block, analysis.layout.variables)
        if fault:
            raise UnreadableShard(fault)
        states = _states(block)
        if block.plan == analysis.digest and (block.positions < analysis.size).all():
            own = block.positions.copy()  # not a view of all that was read
            self._register(index, path, own, block, states)
            return
        if index not in finders:
            finders[index] = _Finder(analysis.keys(DECISIVE))
        self._register(index, path, finders[index].positions(block.keys), block, states)

    def ask(self) -> None:
        """Settle what is to be run, from what has been found."""
        for analysis, record in zip(self.plan.analyses, self.records, strict=True):
            if analysis.maps is not None:
                chains = [chains.positions for chains in analysis.chain_sets()]
                record.stage = analysis.maps.stage(record.told_classes(), record.stored(), chains)

    def write(self, index: int, positions: Positions, block: Block) -> None:
        """Store a finished block of the analysis with this index.

        Raises
        ------
        StorageError
            it cannot be written; nothing that is stored is touched.
        """
        self._store(index, positions, block)
        self.records[index].ran[positions] = True
        self._merge(index)

    def _store(self, index: int, positions: Positions, block: Block) -> None:
        """Write a block under the next number."""
        analysis = self.plan.analyses[index]
        path = self.shard_folder / f"{self._next:06d}.h5"
        block.plan, block.positions = analysis.digest, positions
        write_shard(path, block, analysis.layout.name)
        self._next += 1
        self._register(index, path, positions, block, _states(block))

    def _merge(self, index: int) -> None:
        """Where there are many shards of an age, make one of them.

        First it is written, then they go: in between their points are stored twice.
        """
        for below, above in zip((0, *AGES), AGES, strict=False):
            of_age = [
                shard
                for shard in self.records[index].shards
                if below <= shard.nbytes < above and shard.path.parent == self.shard_folder
            ]
            if len(of_age) >= MANY:
                total = np.cumsum([shard.nbytes for shard in of_age])
                self._merge_shards(index, of_age[: max(2, int((total <= LARGEST).sum()))])

    def _merge_shards(self, index: int, shards: Sequence[Shard]) -> None:
        record, variables = self.records[index], self.plan.analyses[index].layout.variables
        try:
            blocks = [shard.block() for shard in shards]
        except UnreadableShard:  # damaged since: the next who loads it will say so
            return
        positions = np.concatenate([shard.positions for shard in shards])
        rows = record.surviving(positions, blocks)
        record.shards = [shard for shard in record.shards if shard not in shards]
        self._kept -= sum(shard.nbytes for shard in shards if shard.kept is not None)
        self._store(index, positions[rows], joined(blocks, rows, variables))
        for shard in shards:
            shard.path.unlink(missing_ok=True)

    def _register(
        self,
        index: int,
        path: Path,
        positions: Positions,
        block: Block,
        states: Mapping[int, ChainState],
    ) -> None:
        record = self.records[index]
        if (block.status != OK).any():
            positions = np.where(record.outdoes(block, positions), -1, positions)
        placed = positions >= 0
        kept = block if self._kept + block.nbytes <= KEPT else None
        self._kept += 0 if kept is None else block.nbytes
        sizes = {group: sizes.copy() for group, sizes in block.row_sizes.items()}
        record.shards.append(Shard(path, positions, block.nbytes, sizes, block.shapes, kept))
        record.status[positions[placed]] = block.status[placed]
        record.reason[positions[placed]] = block.reason[placed]
        layout, maps = self.plan.analyses[index].layout, self.plan.analyses[index].maps
        if layout.told is not None and layout.told.name in block.values:
            record.told[positions[placed]] = block.values[layout.told.name][placed]
        if maps is not None:
            record.classes[positions[placed]] = maps.classes_of(block)[placed]
        for row, state in states.items():
            if placed[row] and record.goes_on[positions[row]]:
                record.states[int(positions[row])] = state

    def statuses(self, index: int) -> NDArray[np.int8]:
        """Status of every point whose turn has come, (any number,); what is filled in included."""
        record = self.records[index]
        if record.stage is None:
            return record.status[record.mine]
        count = np.count_nonzero(record.stage.filled & record.mine)
        filled = np.full(count, STATUS.codes[NOT_COMPUTED], np.int8)
        return np.concatenate([record.status[record.wanted()], filled])

    def blocks(self, index: int) -> Iterator[tuple[Positions, Block]]:
        """The stored blocks of an analysis with the positions of their rows, in order."""
        for positions, stored in self.stored(index):
            yield positions, stored.block()

    def stored(self, index: int) -> Iterator[Placed]:
        """The same with the blocks as they are stored.

        What a refined analysis did not ask for (of a full grid that was run before) is left out.
        """
        wanted = self.records[index].wanted()
        for shard in self.records[index].shards:
            positions = shard.positions
            yield np.where((positions >= 0) & wanted[positions], positions, -1), shard

    def costs(self, index: int) -> NDArray[np.float32]:
        """What each point that is left will take, s: as those do that are known on either side."""
        record = self.records[index]
        seconds = np.full(len(record.status), np.nan, np.float32)
        for positions, block in self.blocks(index):
            seconds[positions[positions >= 0]] = block.seconds[positions >= 0]
        known = np.flatnonzero(seconds > 0.0)
        if not len(known):
            return np.ones(len(seconds), np.float32)
        likely = np.interp(np.arange(len(seconds)), known, seconds[known]).astype(np.float32)
        return np.where(record.done(), np.float32(0.0), likely)

    def shards(self) -> list[Path]:
        """The files that hold what is stored, in the order in which they count."""
        return [shard.path for record in self.records for shard in record.shards]

    def progress(self) -> tuple[int, int]:
        """How many points are done, and to be done, as far as is known what is to be run."""
        wanted = [record.wanted() for record in self.records]
        done = [some & record.done() for some, record in zip(wanted, self.records, strict=True)]
        return sum(map(np.count_nonzero, done)), sum(map(np.count_nonzero, wanted))

    def messages(self, index: int, limit: int) -> list[tuple[int, str]]:
        """(position, what) of failed points for different reasons, at most `limit`."""
        found: dict[str, tuple[int, str]] = {}
        failed = STATUS.codes["failed"]
        record = self.records[index]
        for shard in record.shards:
            if len(found) >= limit:
                break
            if (record.status[shard.positions[shard.positions >= 0]] == failed).any():
                self._collect(shard, record, found)
        return list(found.values())[:limit]

    def message_at(self, index: int, position: int) -> str:
        """What the point at `position` says of its answer; mostly nothing."""
        for shard in self.records[index].shards:
            rows = np.flatnonzero(shard.positions == position)
            if len(rows):
                return shard.block().messages.get(int(rows[-1]), "")
        return ""

    def _collect(self, shard: Shard, record: Record, found: dict[str, tuple[int, str]]) -> None:
        block, positions = shard.block(), shard.positions
        failed = STATUS.codes["failed"]
        for row in np.flatnonzero((block.status == failed) & (positions >= 0)):
            position = int(positions[row])
            if record.status[position] == failed:
                what = explained(int(block.reason[row]), block.messages.get(int(row), ""))
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


class _Finder:
    """Positions of points by the decisive bytes of their keys; of equal keys the last counts.

    Sorted by the first of them; of two points that share these one is not found and run again.
    """

    def __init__(self, keys: NDArray[np.uint8]) -> None:
        self._keys = keys
        self._order = np.argsort(_first_bytes(keys), kind="stable")
        self._sorted = _first_bytes(keys)[self._order]

    def positions(self, keys: NDArray[np.uint8]) -> Positions:
        """Position of each key; -1 where there is none."""
        places = np.searchsorted(self._sorted, _first_bytes(keys), side="right") - 1
        found = self._order[np.maximum(places, 0)]
        same = (self._keys[found] == keys[:, :DECISIVE]).all(axis=1)
        return np.where(same, found, -1).astype(np.int64)


def _first_bytes(keys: NDArray[np.uint8]) -> NDArray[np.uint64]:
    return np.ascontiguousarray(keys[:, :8]).view(np.uint64).ravel()


def _empty_record(analysis: AnalysisPlan) -> Record:
    size = analysis.size
    goes_on = np.zeros(size, bool)
    for chains in analysis.chain_sets():
        goes_on[chains.positions[:, :-1]] = True
    return Record(
        status=np.full(size, PENDING, np.int8),
        reason=np.zeros(size, np.int8),
        told=np.full(size, -1, np.int8),
        mine=np.ones(size, bool),
        ran=np.zeros(size, bool),
        goes_on=goes_on,
        classes=np.zeros(0 if analysis.maps is None else size, np.int32),
    )


def stored_identity(folder: Path) -> dict[str, Any] | None:
    """The document that says what the points in a run directory belong to; None: nothing stored."""
    path = folder / "identity.json"
    try:
        document = json.loads(path.read_text(encoding="utf-8")) if path.is_file() else None
    except (OSError, ValueError, RecursionError):
        return None
    return document if isinstance(document, dict) else None


def most(folder: Path) -> int:
    """More points than a run directory can hold: each takes the bytes of its key, and more."""
    return sum(path.stat().st_size for path in folder.glob("shards/*.h5")) // KEY_BYTES


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
    for part in ("shards", "parts"):
        shutil.rmtree(folder / part, ignore_errors=True)
    (folder / "identity.json").unlink(missing_ok=True)
