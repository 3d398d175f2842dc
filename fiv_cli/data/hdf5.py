"""NetCDF4 files as xarray datasets, read through HDF5, which a damaged file does not bring down.

The NetCDF library ends the whole process at some damaged files, and HDF5 never returns from others.
So a digest follows what they write, where neither looks; whoever changes a file cuts it off.

What NetCDF adds to HDF5 is little: dims are datasets that others refer to, and a dim whose name no
variable has stands there empty.
Before anything is read it is asked whether fiv writes such types, and whether an array of that
size can be stored: one of a damaged size would be allocated first.
"""

from __future__ import annotations

import hashlib
import math
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import h5py
import numpy as np

if TYPE_CHECKING:
    import xarray as xr

MOST_DEFLATED = 1040
"""Deflate makes nothing smaller by more than this."""

ALLOWANCE = 64 * 1024  # bytes that an array may claim without any being stored: fill values
BARE_DIM = b"This is a netCDF dimension but not a netCDF variable"
SIGNATURE = b"\x89HDF\r\n\x1a\n"
SEAL, DIGEST_BYTES = b"\nfiv sha256 ", 32
PIECE = 2**20  # bytes of a file that are hashed at once

# What the libraries keep among the attributes for themselves.
OWN_ATTRIBUTES = {"CLASS", "NAME", "DIMENSION_LIST", "REFERENCE_LIST", "_Netcdf4Dimid",
                  "_Netcdf4Coordinates", "_NCProperties", "_nc3_strict"}  # fmt: skip


def read_groups(path: Path) -> dict[str, xr.Dataset]:
    """Group -> dataset, in memory; a file without groups is one of the name "".

    Global attributes stand on every dataset. A damaged file may raise anything, but nothing worse.
    """
    refuse_damaged(path)
    with h5py.File(path, "r") as file:
        refuse_what_fiv_does_not_write(file)
        root = _dataset(file)
        groups = {n: _dataset(g) for n, g in _members(file) if isinstance(g, h5py.Group)}
    if not groups:
        return {"": root}
    return {name: group.assign_attrs(root.attrs) for name, group in groups.items()}


def read_attributes(path: Path) -> dict[str, Any]:
    """Global attributes; as for damage as `read_groups`."""
    refuse_damaged(path)
    with h5py.File(path, "r") as file:
        return _attributes(file.attrs)


def is_hdf5(path: Path) -> bool:
    """Whether the file begins as those do that hold datasets."""
    with path.open("rb") as file:
        return file.read(len(SIGNATURE)) == SIGNATURE


def seal(path: Path) -> None:
    """Append the digest of a file to it."""
    with path.open("r+b") as file:
        digest = hashlib.file_digest(file, "sha256").digest()
        file.write(SEAL + digest)


def seal_of(path: Path) -> bytes:
    """What `seal` has appended to a file; ValueError where that is no longer its end."""
    with path.open("rb") as file:
        file.seek(max(path.stat().st_size - len(SEAL) - DIGEST_BYTES, 0))
        found = file.read()
    if not found.startswith(SEAL):
        raise ValueError("no digest stands at its end")
    return found


def refuse_damaged(path: Path) -> None:
    """ValueError where a file is not what its digest says; without one nothing is known."""
    with path.open("rb") as file:
        length = path.stat().st_size - len(SEAL) - DIGEST_BYTES
        file.seek(max(length, 0))
        sealed = file.read()
        if not sealed.startswith(SEAL):
            return
        file.seek(0)
        digest = hashlib.sha256()
        for begin in range(0, length, PIECE):
            digest.update(file.read(min(PIECE, length - begin)))
    if sealed != SEAL + digest.digest():
        raise ValueError("its digest does not match")


def refuse_what_fiv_does_not_write(file: h5py.File) -> None:
    """ValueError where an array is of a strange type, or claims more than is stored of it."""

    def check(name: str, node: object) -> None:
        if isinstance(node, h5py.Dataset) and not _is_bare_dim(node):
            if not _is_known(node.dtype):
                raise ValueError(f"{name} is of the type {node.dtype}")
            claimed, stored = _claimed(node), node.id.get_storage_size()
            if claimed > MOST_DEFLATED * stored + ALLOWANCE:
                raise ValueError(f"{name} claims {claimed:,} bytes, and {stored:,} are stored")

    file.visititems(check)


def _is_known(dtype: np.dtype) -> bool:
    """Whether it is one of numbers, of single characters, or of texts of any length."""
    text = h5py.check_string_dtype(dtype)
    if text is not None:
        return text.length in (None, 1)
    return bool(dtype.kind in "iu" or (dtype.kind == "f" and dtype.itemsize in (4, 8)))


def _claimed(node: h5py.Dataset) -> int:
    """Bytes that reading an array takes, at the least a chunk of it."""
    entries = max(math.prod(node.shape or ()), math.prod(node.chunks or ()))
    return int(entries * node.dtype.itemsize)


def _is_bare_dim(node: h5py.Dataset) -> bool:
    """Whether this stands for a dim that no array carries the name of: it holds nothing."""
    name = node.attrs.get("NAME", b"")
    return isinstance(name, bytes) and name.startswith(BARE_DIM)


# --- what NetCDF adds -----------------------------------------------------------------------------
def _members(group: h5py.Group) -> Iterator[tuple[str, h5py.Dataset | h5py.Group]]:
    """Name and node of what stands in a group, in the order in which it was made."""
    names: list[bytes] = []
    order = h5py.h5.INDEX_CRT_ORDER
    if not group["."].id.get_create_plist().get_link_creation_order():
        order = h5py.h5.INDEX_NAME
    group.id.links.iterate(names.append, idx_type=order)
    for name in names:
        yield name.decode(), group[name]


def _dataset(group: h5py.Group) -> xr.Dataset:
    """The variables of one group, decoded: texts from characters, NaN where nothing was filled."""
    import xarray as xr

    nodes = {n: node for n, node in _members(group) if isinstance(node, h5py.Dataset)}
    numbered = {int(n.attrs["_Netcdf4Dimid"]): name for name, n in nodes.items() if n.is_scale}
    variables = {
        name: xr.Variable(_dims(name, node, numbered), _content(node), _attributes(node.attrs))
        for name, node in nodes.items()
        if not _is_bare_dim(node)
    }
    raw = xr.Dataset(variables, attrs=_attributes(group.attrs))
    dataset = xr.decode_cf(raw, decode_times=False).load()  # what cannot be decoded fails here
    for variable in dataset.variables.values():  # so that xarray writes it, or a part, as it was
        variable.encoding.pop("char_dim_name", None)
        variable.encoding.setdefault("_FillValue", None)
    return dataset


def _content(node: h5py.Dataset) -> np.ndarray:
    """The array; texts of any length as such."""
    text = h5py.check_string_dtype(node.dtype)
    return node.asstr()[()] if text is not None and text.length is None else node[()]


def _dims(name: str, node: h5py.Dataset, numbered: Mapping[int, str]) -> tuple[str, ...]:
    """Names of the dims of an array."""
    if "_Netcdf4Coordinates" in node.attrs:
        return tuple(numbered[int(number)] for number in node.attrs["_Netcdf4Coordinates"])
    if node.is_scale:
        return (name,)
    return tuple(str(axis[0].name).rpartition("/")[2] for axis in node.dims)


def _attributes(stored: h5py.AttributeManager) -> dict[str, Any]:
    """Attributes as NetCDF means them: texts, numbers, arrays of several numbers."""
    return {name: _plain(stored[name]) for name in stored if name not in OWN_ATTRIBUTES}


def _plain(value: object) -> object:
    if isinstance(value, h5py.Empty):
        return ""
    if isinstance(value, bytes):
        return value.decode()
    if isinstance(value, np.ndarray) and value.size == 1:
        return _plain(value.ravel()[0])
    return value
