"""Where a run writes to, and whether it may."""

from __future__ import annotations

import os
from pathlib import Path

from fiv_cli.case.case import Case
from fiv_cli.case.identity import MOTION, is_of
from fiv_cli.data.hdf5 import is_hdf5
from fiv_cli.data.log import RUN_SUFFIX
from fiv_cli.data.netcdf import global_attributes
from fiv_cli.errors import InputError, StorageError, StoreMismatchError, UsageError
from fiv_cli.files import refuse_special


def check_output(output: Path, case: Case | None) -> None:
    """Refuse an output that cannot or must not be written, before anything is computed.

    Parameters
    ----------
    case : what a dataset that is there must be of; None: it is replaced

    Raises
    ------
    UsageError
        a folder, a pipe or a device, or a file that is no dataset of fiv.
    StorageError
        its folder cannot be made or written.
    InputError
        a damaged dataset.
    StoreMismatchError
        the dataset of another case.
    """
    refuse_special(output)
    if output.suffix == RUN_SUFFIX:
        raise UsageError(f"{output}: {RUN_SUFFIX} is the run directory\nnext: -o NAME.nc")
    _check_folder(output)
    if output.exists():
        _check_existing(output, case)


def _check_folder(output: Path) -> None:
    folder = output.parent
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise StorageError(
            f"{folder}: cannot be created: {error.strerror}\n"
            "next: choose another place with -o FILE.nc"
        ) from error
    if not os.access(folder, os.W_OK | os.X_OK):
        raise StorageError(
            f"{folder}: cannot be written: no permission\n"
            "next: choose another place with -o FILE.nc"
        )


def _check_existing(output: Path, case: Case | None) -> None:
    attributes = global_attributes(output)
    if attributes is None and is_hdf5(output):
        raise InputError(
            f"{output}: a damaged dataset, or another file of HDF5; it is left alone\n"
            "next: remove it (a dataset is made again from what is stored beside it), or choose "
            "another place with -o FILE.nc"
        )
    if attributes is None or "fingerprint" not in attributes:
        raise UsageError(
            f"{output}: exists and is no dataset of fiv; it is left alone\n"
            "next: choose another place with -o FILE.nc, or remove it (a damaged dataset is made "
            "again from what is stored beside it)"
        )
    if case is not None and MOTION in attributes:
        raise StoreMismatchError(
            f"{output}: holds the motion at {attributes[MOTION]}; it is left alone\n"
            "next: choose another place with -o FILE.nc, or replace it with --fresh"
        )
    if case is not None and not is_of(attributes, case):
        raise StoreMismatchError(
            f"{output}: holds the dataset of another case ({attributes.get('title', '')!r})\n"
            "next: `fiv status CASE` says how they differ; choose another place with -o FILE.nc, "
            "or replace it with --fresh"
        )
