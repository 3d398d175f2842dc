"""Datasets as NetCDF4 files: written under a temporary name, read back, then renamed."""

from __future__ import annotations

import errno
import json
import os
import shutil
import zlib
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import replace
from datetime import datetime
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from fiv_cli import ending
from fiv_cli.analyses.variables import INT_FILL
from fiv_cli.case.identity import output_of
from fiv_cli.data.dataset import Dataset, Labelled
from fiv_cli.data.hdf5 import read_attributes, read_groups, seal
from fiv_cli.data.log import came, run_folder, runs_in
from fiv_cli.data.mapped import let_go
from fiv_cli.data.sound import form_of
from fiv_cli.errors import InputError, StorageError, UsageError
from fiv_cli.files import NETCDF, replacing
from fiv_cli.notation.names import suggest

if TYPE_CHECKING:
    import netCDF4
    import xarray as xr

ANEW = "remove it, and `fiv run CASE` writes it anew from what is stored beside it"
"""What to do about a damaged dataset."""

LARGE = 64 * 1024
"""Arrays above this many bytes are compressed, where that pays."""

WORTH = 0.25
"""Size of a part of an array when it is compressed, over what it was, below which it pays: the
digits of a motion are noise, and to compress them takes longer than to compute them."""

LEVEL = 1
"""Of compression: higher ones take several times as long and gain little."""

LOOKED_AT, PIECES = 64 * 1024, 16
"""Bytes of an array that are tried, and in how many pieces."""

MUCH = 128 * 2**20
"""Bytes of a dataset that the library must not keep a second time when it writes or reads them."""

SLAB = 2**24
"""Bytes of a variable that are written or compared at once, where it has more."""

CACHE = 2**20
"""Bytes that it then keeps of each variable."""


def write_datasets(
    path: Path, datasets: Mapping[str, Dataset], attributes: Mapping[str, Any]
) -> None:
    """Write the datasets of a run: at the root when there is one, as groups when several.

    Parameters
    ----------
    path : replaced as a whole, or not at all
    datasets : analysis name -> dataset
    attributes : global attributes, see `to_attribute`

    Raises
    ------
    StorageError
        no space or no permission; nothing is left behind.
    """
    form = {name: form_of(dataset) for name, dataset in datasets.items()}
    attributes = {**attributes, "variables_json": form}
    try:
        _check_space(path, datasets)
        much = any(dataset.nbytes > MUCH for dataset in datasets.values())
        with replacing(path) as temporary, ending.last_act(temporary.unlink), _caches(much):
            _write(temporary, datasets, attributes)
            _check(temporary, datasets)
            seal(temporary)
    except (OSError, RuntimeError) as error:
        raise StorageError(
            f"{path}: cannot be written: {_cause(error)}\n"
            "next: free some space or correct the permissions, then run the same command again; "
            "what is finished is kept"
        ) from error


def read_datasets(path: Path) -> dict[str, xr.Dataset]:
    """The datasets in a file: group name -> dataset; the name is "" for a file without groups.

    Global attributes stand on every dataset; integers are not turned into floats.

    Raises
    ------
    UsageError
        there is no such file, or it is a folder.
    InputError
        the file is not a dataset of fiv.
    """
    if not path.is_file():
        _refuse_unwritten(path)
        what = "is a folder" if path.is_dir() else "no such file"
        raise UsageError(f"{path}: {what}\nnext: {_meant(path)}")
    if path.suffix == ".toml":
        raise UsageError(f"{path}: a case, not a dataset\nnext: {_dataset_of(path)}")
    try:
        return read_groups(path)
    except Exception as error:  # a damaged file can fail in any way inside the libraries
        with path.open("rb") as file:
            signed = file.read(8).startswith(NETCDF)
        damage = f"a damaged dataset ({type(error).__name__}: {error})\nnext: {ANEW}"
        other = "not a NetCDF dataset\nnext: name a dataset written by `fiv run`"
        raise InputError(f"{path}: {damage if signed else other}") from error


def _refuse_unwritten(path: Path) -> None:
    """Say of a dataset that is not there how far its run has come, if there is one."""
    if path.exists() or not path.name:
        return
    runs, parts = runs_in(run_folder(path)), run_folder(path) / "parts"
    if parts.is_dir() and not runs:
        raise UsageError(
            f"{path}: not written; its points are run in parts (fiv run --shard)\n"
            "next: fiv assemble CASE, which joins them and says what is missing"
        )
    if runs:
        course, command = runs[-1].course, runs[-1].command
        at = datetime.fromtimestamp(course.times[-1]).strftime("%H:%M:%S")
        comes = "; it comes when that ends, or is stopped (Ctrl-C) after a point"
        raise UsageError(
            f"{path}: not written; its run had {came(course.done, course.total)} at {at}"
            f"{comes * (course.done < course.total)}\n"
            f"next: {command.replace('run', 'status', 1)}; to go on, or to write it anew: {command}"
        )


def _meant(path: Path) -> str:
    """What may have been meant instead of a dataset that is not there."""
    there = [*path.parent.glob("*.nc"), *Path("runs").glob("*.nc")] if path.name else []
    hint = suggest(str(path), sorted({str(other) for other in there}))
    return hint or "name a dataset written by `fiv run`"


def _dataset_of(case: Path) -> str:
    """What to do where a case stands for its dataset."""
    path = output_of(case)
    return f"name its dataset, {path}" if path.is_file() else f"fiv run {case}, which writes {path}"


def global_attributes(path: Path) -> dict[str, Any] | None:
    """Global attributes of the file at `path`; None when it is not a NetCDF file, or damaged."""
    try:
        return read_attributes(path)
    except Exception:  # as above
        return None


def to_attribute(value: object) -> object:
    """A value as NetCDF can hold it: tables as JSON, lists of names as lines; None is left out."""
    if isinstance(value, bool | np.bool_):
        return np.int8(value)
    if isinstance(value, Mapping):
        return json.dumps(value, sort_keys=True, default=str)
    if isinstance(value, tuple | list):
        return "\n".join(str(item) for item in value)
    return value


class _Later:
    """Holds arrays back until everything is defined, but for those that take much memory.

    A file that changes between being defined and being filled goes through all that it has each
    time: hundreds of groups would take minutes.
    """

    def __init__(self, datasets: Mapping[str, Dataset]) -> None:
        self._parts: list[tuple[netCDF4.Variable, NDArray[Any]]] = []
        self._all = [v.values for one in datasets.values() for v in one.variables.values()]

    def add(self, target: netCDF4.Variable, source: NDArray[Any]) -> None:
        """What goes where."""
        if source.nbytes > SLAB:
            for array in self._all:  # of one of them `source` was made
                let_go(array)
            _fill_in_slabs(target, source)
        else:
            self._parts.append((target, source))

    def write(self) -> None:
        """Fill what was defined."""
        for target, source in self._parts:
            target[...] = source


def _fill_in_slabs(target: netCDF4.Variable, source: NDArray[Any]) -> None:
    """Write a large array piece by piece: the library copies what it is given, more than once."""
    for slab in _slabs(source, target.chunking()):
        target[slab] = source[slab]
        let_go(source)


def _slabs(array: Any, chunks: Sequence[int] | str) -> Iterator[slice]:
    """Pieces along the first dim that begin and end where chunks of the file do, if it has any."""
    rows = 1 if isinstance(chunks, str) else chunks[0]
    step = rows * max(1, SLAB * len(array) // (array.nbytes * rows))
    return (slice(begin, begin + step) for begin in range(0, len(array), step))


def _write(path: Path, datasets: Mapping[str, Dataset], attributes: Mapping[str, Any]) -> None:
    """All groups into one file that is opened once: each opening reads all that it has."""
    import netCDF4

    clean = {name: to_attribute(v) for name, v in attributes.items() if v is not None}
    later = _Later(datasets)
    with netCDF4.Dataset(path, "w", format="NETCDF4") as file:
        if len(datasets) == 1:
            (dataset,) = datasets.values()
            _define(file, replace(dataset, attrs={**dataset.attrs, **clean}), later)
        else:
            each = f"each analysis is a group of this file: {', '.join(datasets)}"
            _define(file, Dataset({}, frozenset(), {"comment": each, **clean}), later)
            for name, dataset in datasets.items():
                _define(file.createGroup(name), dataset, later)
        later.write()


@contextmanager
def _caches(small: bool) -> Iterator[None]:
    """What the library keeps of files that are opened meanwhile; `small`: little."""
    import netCDF4

    usual = netCDF4.get_chunk_cache()
    if small:
        netCDF4.set_chunk_cache(CACHE)
    try:
        yield
    finally:
        netCDF4.set_chunk_cache(*usual)


def _define(group: netCDF4.Dataset, dataset: Dataset, later: _Later) -> None:
    """All that a group holds, as xarray would write it and reads it."""
    coordinates = _coordinates(dataset)
    none = dataset.coords.difference(*map(str.split, coordinates.values()), dataset.sizes)
    apart = {"coordinates": " ".join(sorted(none))} if none else {}
    group.setncatts({**dataset.attrs, **apart})
    stored = {
        name: _as_characters(replace(one, attrs={**one.attrs, **_named(coordinates.get(name))}))
        for name, one in dataset.variables.items()
    }
    for dim, size in replace(dataset, variables=stored).sizes.items():
        group.createDimension(dim, size)
    for name, one in stored.items():
        target = group.createVariable(
            name, one.dtype, one.dims, fill_value=_fill(one), shuffle=True, **_compression(one)
        )
        target.set_auto_maskandscale(False)
        target.set_auto_chartostring(False)
        target.setncatts(one.attrs)
        later.add(target, one.values)


def _coordinates(dataset: Dataset) -> dict[str, str]:
    """Variable -> coordinates of its points beside those of its dims."""
    own = sorted(dataset.coords.difference(dataset.sizes))
    found = {
        name: [c for c in own if set(dataset.variables[c].dims) <= set(one.dims)]
        for name, one in dataset.variables.items()
        if name not in own and name not in one.dims
    }
    return {name: " ".join(names) for name, names in found.items() if names}


def _named(coordinates: str | None) -> dict[str, str]:
    return {} if coordinates is None else {"coordinates": coordinates}


def _as_characters(variable: Labelled) -> Labelled:
    """Texts as characters of a fixed width, readable everywhere; anything else as it is."""
    if variable.dtype.kind != "U":
        return variable
    texts = np.char.encode(variable.values, "utf-8")
    width = texts.dtype.itemsize
    characters = np.ascontiguousarray(texts).view("S1").reshape(*texts.shape, width)
    attributes = {**variable.attrs, "_Encoding": "utf-8"}
    return Labelled((*variable.dims, f"string{width}"), characters, attributes)


def _compression(variable: Labelled) -> dict[str, Any]:
    if variable.values.nbytes <= LARGE or not _shrinks(variable.values):
        return {}
    return {"zlib": True, "complevel": LEVEL}


def _shrinks(array: NDArray[Any]) -> bool:
    """Whether an array is worth compressing, by pieces from all over it."""
    flat = array.reshape(-1)
    count = LOOKED_AT // PIECES // flat.itemsize
    begins = np.linspace(0, len(flat) - count, PIECES, dtype=np.int64)
    tried = np.concatenate([flat[begin : begin + count] for begin in begins])
    let_go(array)
    shuffled = tried.view(np.uint8).reshape(-1, flat.itemsize).T.tobytes()
    return len(zlib.compress(shuffled, LEVEL)) < WORTH * len(shuffled)


def _fill(variable: Labelled) -> float | np.int32 | None:
    """NaN for numbers; counts carry a missing value; flags, sizes and coordinates none."""
    if variable.dtype.kind == "f" and "ancillary_variables" in variable.attrs:
        return np.nan
    if variable.dtype == np.int32 and "ancillary_variables" in variable.attrs:
        return np.int32(INT_FILL)
    return None


def _check(path: Path, datasets: Mapping[str, Dataset]) -> None:
    """Read back what was written, one variable at a time."""
    import netCDF4

    with netCDF4.Dataset(path) as file:
        file.set_auto_maskandscale(False)
        for name, dataset in datasets.items():
            group = file if len(datasets) == 1 else file.groups[name]
            _check_group(group.variables, dataset)


def _check_group(written: Mapping[str, netCDF4.Variable], dataset: Dataset) -> None:
    for name, variable in dataset.variables.items():
        if name not in written:
            raise RuntimeError(f"{name} is missing after writing")
        back, values = written[name], variable.values
        for part in _slabs(values, back.chunking()) if values.nbytes > SLAB else (...,):
            if not _same(back[part], values[part]):
                raise RuntimeError(f"{name} reads back differently")
            let_go(values)


def _same(back: NDArray[Any], values: NDArray[Any]) -> bool:
    """Whether two arrays hold the same; of numbers the bits are compared, which is soonest done."""
    if values.dtype != np.float64 or back.dtype != np.float64:
        return np.array_equal(back, values)
    bits = np.ascontiguousarray(back).view(np.int64), np.ascontiguousarray(values).view(np.int64)
    return np.array_equal(*bits)


def _check_space(path: Path, datasets: Mapping[str, Dataset]) -> None:
    """Refuse early what cannot fit even well compressed."""
    needed = sum(dataset.nbytes for dataset in datasets.values()) // 20
    if shutil.disk_usage(path.parent).free < needed:
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))


def _cause(error: Exception) -> str:
    """What the system says; the NetCDF library hides that a disk is full behind its own words."""
    if isinstance(error, OSError) and error.strerror and (error.errno or 0) > 0:
        return error.strerror
    return f"{error} (is the disk full?)"
