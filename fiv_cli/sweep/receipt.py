"""The receipt of a dataset: from what it was made, and what came of it.

Of a finished run that is given again nothing is assembled anew: the receipt says whether the file
that is there is, to the last byte, what would be written.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

import fiv_cli
from fiv_cli.data.hdf5 import refuse_damaged, seal_of
from fiv_cli.data.shard import digest_of, write_atomically
from fiv_cli.errors import StorageError

NAME = "dataset.json"


def made_from(shards: Iterable[Path], attributes: Mapping[str, Any]) -> str:
    """Digest of all that decides a dataset: shards, global attributes, the program itself."""
    digest = hashlib.sha256(json.dumps(attributes, default=str).encode())
    digest.update(b"".join(map(digest_of, shards)))
    for path in sorted(Path(fiv_cli.__file__).parent.rglob("*.py")):
        digest.update(f"{path.name}|".encode() + hashlib.sha256(path.read_bytes()).digest())
    return digest.hexdigest()


def is_made(folder: Path, output: Path, sources: str) -> bool:
    """Whether the dataset at `output` was made from `sources` and is as it was then."""
    path = folder / NAME
    try:
        receipt = json.loads(path.read_text(encoding="utf-8")) if path.is_file() else None
        is_same = receipt is not None and receipt["made_from"] == sources
        if not is_same or receipt != _receipt(output, sources):
            return False
        refuse_damaged(output)
        return True
    except (OSError, ValueError, TypeError, KeyError, RecursionError):
        return False


def write_receipt(folder: Path, output: Path, sources: str) -> None:
    """Note what the dataset at `output` was made from; without the note it is made again."""
    try:
        write_atomically(folder / NAME, json.dumps(_receipt(output, sources)).encode())
    except (OSError, ValueError, StorageError):
        return


def _receipt(output: Path, sources: str) -> dict[str, str]:
    return {"made_from": sources, "seal": seal_of(output).hex()}
