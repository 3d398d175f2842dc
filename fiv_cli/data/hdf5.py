"""Files of HDF5 that may be damaged: what is to be known of them before anything is read."""

from __future__ import annotations

import math
from typing import Any

import h5py

MOST_DEFLATED = 1040
"""Deflate makes nothing smaller by more than this."""

ALLOWANCE = 64 * 1024  # bytes that an array may claim without any being stored: fill values
BARE_DIM = b"This is a netCDF dimension but not a netCDF variable"


def refuse_what_fiv_does_not_write(file: h5py.File) -> None:
    """ValueError where an array is of a strange type, or claims more than is stored of it.

    Nothing of it is read for that: an array of a damaged size would be allocated first, and at
    some types (numbers of 16 bits with a point) the NetCDF library ends the process.
    """

    def check(name: str, node: object) -> None:
        if isinstance(node, h5py.Dataset) and not _is_bare_dim(node):
            if not _is_known(node.dtype):
                raise ValueError(f"{name} is of the type {node.dtype}")
            claimed, stored = _claimed(node), node.id.get_storage_size()
            if claimed > MOST_DEFLATED * stored + ALLOWANCE:
                raise ValueError(f"{name} claims {claimed:,} bytes, and {stored:,} are stored")

    file.visititems(check)


def _is_known(dtype: Any) -> bool:
    """Whether it is one of numbers, of single characters, or of texts of any length."""
    text = h5py.check_string_dtype(dtype)
    if text is not None:
        return text.length in (None, 1)
    return bool(dtype.kind in "iu" or (dtype.kind == "f" and dtype.itemsize in (4, 8)))


def _claimed(node: Any) -> int:
    """Bytes that reading an array takes, at the least a chunk of it."""
    entries = max(math.prod(node.shape or ()), math.prod(node.chunks or ()))
    return int(entries * node.dtype.itemsize)


def _is_bare_dim(node: Any) -> bool:
    """Whether this stands for a dim that no array carries the name of: it holds nothing."""
    name = node.attrs.get("NAME", b"")
    return isinstance(name, bytes) and name.startswith(BARE_DIM)
