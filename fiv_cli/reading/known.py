"""Which points of a dataset have an answer, as far as a variable goes."""

from __future__ import annotations

from typing import TYPE_CHECKING

from fiv_cli.analyses.catalogue import named
from fiv_cli.analyses.variables import Role
from fiv_cli.reading.datasets import flag_names, numbers

if TYPE_CHECKING:
    import xarray as xr


def unknown_points(part: xr.Dataset, variable: str, allow_undecided: bool) -> xr.DataArray:
    """Points whose `variable` the dataset cannot tell, over the grid (and starts).

    Parameters
    ----------
    part : a dataset or a part of it, with its ``status``
    variable : what is asked for
    allow_undecided : "undecided" is itself an answer: a run that used up its budget and says so
    """
    status, role = part["status"], named(variable).role
    if role is Role.STATUS:
        return status != status
    missing = ~is_class(status, ("ok",)) & ~filled_in(part, variable)
    # how a motion that has not settled sticks and slips is known even where its period is not
    if "attractor" not in part or role is Role.SHARE:
        return missing
    undecided = is_class(part["attractor"], ("undecided",))
    if allow_undecided and variable == "attractor":
        return missing & ~undecided
    return missing | undecided


def filled_in(part: xr.Dataset, variable: str) -> xr.DataArray:
    """Points that were not run and whose class is that of the points around them.

    Only the class that a sweep was refined along is filled in; of any other variable, nothing.
    """
    status = part["status"]
    if "computed" not in part or part.attrs.get("refined_of") != variable:
        return status != status
    given = numbers(part[variable]).notnull()
    return is_class(part["computed"], ("filled_in",)) & given


def is_class(array: xr.DataArray, names: tuple[str, ...]) -> xr.DataArray:
    """Where a flag variable has one of the classes."""
    codes = [code for code, name in flag_names(array.attrs).items() if name in names]
    return array.isin(codes)
