"""Datasets back from disk, one per analysis, as they were written."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING

from fiv_cli.data.flags import NOT_COMPUTED
from fiv_cli.data.variables import INT_FILL
from fiv_cli.errors import InputError, UsageError

if TYPE_CHECKING:
    import xarray as xr

# Without it a file is NetCDF, but none of ours.
MARK = "case"


def read_analyses(path: str | Path) -> dict[str, xr.Dataset]:
    """Every analysis of the dataset at `path`, in memory.

    Parameters
    ----------
    path : NetCDF file written by ``fiv run``

    Returns
    -------
    dict : name of the analysis -> dataset, in the order of the file; a file that holds one
        analysis has the name ``""``. The global attributes of the file stand in each.

    Raises
    ------
    UsageError : there is no such file, or it is a folder
    InputError : it is no dataset of fiv
    """
    path = Path(path)
    if not path.exists():
        raise UsageError(f"{path}: there is no such file\nwrite it with: fiv run CASE -o {path}")
    if path.is_dir():
        raise UsageError(f"{path}: a folder, not a dataset\nname a file: {path}/NAME.nc")
    analyses = _load_groups(path)
    if not any(MARK in dataset.attrs for dataset in analyses.values()):
        raise InputError(
            f"{path}: a NetCDF file that fiv did not write (it holds no case)\n"
            "write a dataset with: fiv run CASE"
        )
    return analyses


def flag_names(attributes: Mapping[str, object]) -> dict[int, str]:
    """Value -> name of a flag variable, from its attributes; empty for any other variable."""
    if "flag_meanings" not in attributes:
        return {}
    import numpy as np

    values = np.atleast_1d(np.asarray(attributes["flag_values"]))
    return dict(zip(values.tolist(), str(attributes["flag_meanings"]).split(), strict=True))


def numbers(array: xr.DataArray) -> xr.DataArray:
    """`array` as floats, NaN where an integer or a flag says that it was not computed."""
    fill = {code for code, name in flag_names(array.attrs).items() if name == NOT_COMPUTED}
    if array.dtype.kind == "i" and not fill:
        fill = {INT_FILL}
    return array.astype(float).where(~array.isin(list(fill)))


def _load_groups(path: Path) -> dict[str, xr.Dataset]:
    import netCDF4

    try:
        with netCDF4.Dataset(path) as file:
            groups = list(file.groups)
            shared = {name: file.getncattr(name) for name in file.ncattrs()}
        loaded = {group: _load_group(path, group) for group in groups or [""]}
    except (OSError, ValueError, RuntimeError) as error:
        raise InputError(
            f"{path}: not a dataset that can be read ({error})\nwrite one with: fiv run CASE"
        ) from error
    return {name: data.assign_attrs({**shared, **data.attrs}) for name, data in loaded.items()}


def _load_group(path: Path, group: str) -> xr.Dataset:
    """One group, undecoded: flags stay integers, seconds stay numbers."""
    import xarray as xr

    with xr.open_dataset(
        path,
        group=group or None,
        engine="netcdf4",
        mask_and_scale=False,
        decode_times=False,
        decode_timedelta=False,
    ) as dataset:
        return dataset.load()
