"""One shard: a finished chunk of points as a checksummed HDF5 file that appears all at once.

The file is built in memory and written under a temporary name in the same folder, flushed to
the disk and renamed, so that a crash at any instant leaves the old state or the new one. A shard
that cannot be read as it was written is an `UnreadableShard`: its points are simply run again.

Before what HDF5 reads stands a digest of that, where it leaves room to users. It is asked to open
no file that does not match: at some damaged ones it never returns, or ends the process.

All arrays lie one after the other in one dataset, `content`; `header` says in JSON what they are
(of a file for each array, HDF5 takes most of the time that it takes to read a shard).
"""

from __future__ import annotations

import io
import json
import math
import zlib
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

import h5py
import numpy as np

from fiv_cli.data.block import Array, Block, from_plain, to_plain
from fiv_cli.errors import StorageError
from fiv_cli.files import write_whole

FORMAT = "fiv shard"
VERSION = 4

DIGEST_BYTES, BEFORE = 4, 512
"""Of the CRC of the file of HDF5 (damage is no malice), and of all before that (no fewer can)."""

ALIGNMENT = 8
"""Bytes; where each array begins is a multiple of it."""


class UnreadableShard(Exception):
    """A file among the shards that is truncated, damaged or foreign."""


def write_shard(path: Path, block: Block, analysis: str) -> None:
    """Write `block` as a shard at `path`, atomically.

    Raises
    ------
    StorageError
        no space, no permission; `path` is left as it was and no temporary file stays behind.
    """
    write_atomically(path, *shard_parts(block, analysis))


def shard_parts(block: Block, analysis: str) -> list[bytes | memoryview]:
    """The HDF5 file of a block, part after part."""
    arrays = _to_arrays(block)
    table = [(name, array.dtype.str, array.shape) for name, array in arrays.items()]
    content = [_aligned(array) for array in arrays.values()]
    head = _head(json.dumps(table).encode(), sum(map(len, content)), analysis)
    return [_digest([head[BEFORE:], *content]), head[DIGEST_BYTES:], *content]


def _digest(parts: Iterable[bytes | memoryview]) -> bytes:
    found = 0
    for part in parts:
        found = zlib.crc32(part, found)
    return found.to_bytes(DIGEST_BYTES, "little")


def _aligned(array: Array) -> memoryview:
    """The bytes of an array, and zeros up to where the next one begins."""
    flat = np.ascontiguousarray(array).reshape(-1).view(np.uint8)
    missing = -len(flat) % ALIGNMENT
    return np.append(flat, np.zeros(missing, np.uint8)).data if missing else flat.data


def _head(header: bytes, size: int, analysis: str) -> bytes:
    """An HDF5 file up to its content, the last that it has: so this is never copied."""
    image = io.BytesIO()
    with h5py.File(image, "w", userblock_size=BEFORE) as file:
        file.attrs["format"] = FORMAT
        file.attrs["version"] = VERSION
        file.attrs["analysis"] = analysis
        file.create_dataset("header", data=np.frombuffer(header, np.uint8))
        how = h5py.h5p.create(h5py.h5p.DATASET_CREATE)
        how.set_alloc_time(h5py.h5d.ALLOC_TIME_EARLY)
        how.set_fill_time(h5py.h5d.FILL_TIME_NEVER)
        room = h5py.h5s.create_simple((size,))
        h5py.h5d.create(file.id, b"content", h5py.h5t.NATIVE_UINT8, room, how)
    return image.getvalue()


def read_shard(path: Path) -> tuple[Block, str]:
    """The block stored at `path`, and the name of its analysis.

    Raises
    ------
    UnreadableShard
        the file is truncated, damaged, of another version, or not a shard.
    """
    arrays, analysis = _verified_arrays(path)
    try:
        return _from_arrays(arrays), analysis
    except Exception as error:  # a checksum can be made for anything
        raise UnreadableShard(f"it holds no block: {type(error).__name__}: {error}") from error


def write_atomically(path: Path, *content: bytes | memoryview) -> None:
    """Replace the file at `path` by `content`: all of it or nothing.

    Raises
    ------
    StorageError
        no space, no permission; nothing is left behind.
    """
    try:
        write_whole(path, *content)
    except OSError as error:
        raise StorageError(
            f"{path}: cannot be written: {error.strerror or error}\n"
            "next: free some space or correct the permissions, then run the same command again; "
            "what is finished is kept"
        ) from error


def _to_arrays(block: Block) -> dict[str, Array]:
    return {
        "keys": block.keys,
        "status": block.status,
        "reason": block.reason,
        "seconds": block.seconds,
        "plan": np.frombuffer(block.plan, np.uint8),
        "positions": block.positions,
        "messages": _json_array(block.messages),
        "carries": _json_array(block.carries),
        **{f"values/{name}": array for name, array in sorted(block.values.items())},
        **{f"row_sizes/{name}": array for name, array in sorted(block.row_sizes.items())},
        **{f"ragged/{name}": array for name, array in sorted(block.ragged.items())},
    }


def _from_arrays(arrays: Mapping[str, Array]) -> Block:
    return Block(
        keys=arrays["keys"],
        status=arrays["status"],
        reason=arrays["reason"],
        values=_group(arrays, "values/"),
        row_sizes=_group(arrays, "row_sizes/"),
        ragged=_group(arrays, "ragged/"),
        messages=_from_json(arrays["messages"]),
        carries=_from_json(arrays["carries"]),
        seconds=arrays.get("seconds", np.zeros(0, np.float32)),
        plan=arrays.get("plan", np.zeros(0, np.uint8)).tobytes(),
        positions=arrays.get("positions", np.zeros(0, np.int64)),
    )


def _group(arrays: Mapping[str, Array], prefix: str) -> dict[str, Array]:
    return {n.removeprefix(prefix): a for n, a in arrays.items() if n.startswith(prefix)}


def _verified_arrays(path: Path) -> tuple[dict[str, Array], str]:
    """What is stored at `path`; no file there may end a run, whatever it is."""
    try:
        if not path.is_file():
            raise ValueError("no file")
        whole = np.fromfile(path, np.uint8)
        if _digest([whole[BEFORE:].data]) != whole[:DIGEST_BYTES].tobytes():
            raise ValueError("damaged, or of another version of fiv: its digest does not match")
        with h5py.File(path, "r") as file:
            if file.attrs["format"] != FORMAT or file.attrs["version"] != VERSION:
                raise ValueError("not a shard of this version of fiv")
            content = whole[file["content"].id.get_offset() :]
            return _unpacked(file["header"][()], content), str(file.attrs["analysis"])
    except Exception as error:
        raise UnreadableShard(f"{type(error).__name__}: {error}") from error


def digest_of(path: Path) -> bytes:
    """The digest that a shard begins with."""
    with path.open("rb") as file:
        return file.read(DIGEST_BYTES)


def _unpacked(header: Array, content: Array) -> dict[str, Array]:
    """The arrays that a header describes, as views of the content."""
    arrays, begin = {}, 0
    for name, kind, shape in json.loads(header.tobytes()):
        dtype = np.dtype(kind)
        end = begin + dtype.itemsize * math.prod(shape)
        arrays[str(name)] = content[begin:end].view(dtype).reshape(shape)
        begin = end + -end % ALIGNMENT
    if begin != len(content):
        raise ValueError("its arrays are longer or shorter than it says")
    return arrays


def _json_array(rows: Mapping[int, Any]) -> Array:
    """Row -> plain data as a byte array; numbers keep every bit (Python writes them exactly)."""
    text = json.dumps({str(row): to_plain(value) for row, value in sorted(rows.items())})
    return np.frombuffer(text.encode(), np.uint8)


def _from_json(array: Array) -> dict[int, Any]:
    rows = json.loads(array.tobytes().decode())
    return {int(row): from_plain(value) for row, value in rows.items()}
