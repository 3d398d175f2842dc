"""What stands in a dataset of fiv: its analyses, the names of its flags, what has no answer."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from fiv_cli.analyses.catalogue import named
from fiv_cli.analyses.variables import INT_FILL, Role, Variable, amplitude, ranged
from fiv_cli.case.case import FigureSpec
from fiv_cli.case.grammar import figure_of_before, text_of_before
from fiv_cli.data.netcdf import ANEW, read_datasets
from fiv_cli.data.sound import fault_of
from fiv_cli.errors import InputError
from fiv_cli.flags import NOT_COMPUTED, ON_THE_WAY

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
    InputError : it is no dataset of fiv, or a damaged one; says what is wrong
    """
    analyses = read_datasets(Path(path))
    if not all(MARK in dataset.attrs and "status" in dataset for dataset in analyses.values()):
        raise InputError(
            f"{path}: a NetCDF file that fiv did not write (it holds no case, or no status)\n"
            "write a dataset with: fiv run CASE"
        )
    for name, dataset in analyses.items():
        fault = fault_of(dataset, name)
        if fault:
            raise InputError(
                f"{path}: not as fiv wrote it, another program changed it: "
                f"{f'{name}: ' if name else ''}{fault}\n"
                f"next: name the file that `fiv run` wrote, or, if this is it, {ANEW}"
            )
    return {name: _with_derived(dataset) for name, dataset in analyses.items()}


def _with_derived(dataset: xr.Dataset) -> xr.Dataset:
    """The dataset with the amplitude of what has a least and a greatest value at each point."""
    at_points = {str(n): one for n, one in dataset.items() if one.dims == dataset["status"].dims}
    found = {}
    for stem in ranged(at_points):
        least, greatest = at_points[f"{stem}_min"], at_points[f"{stem}_max"]
        told = amplitude(stem, str(greatest.attrs["units"]))
        attributes = {"units": told.units, "long_name": told.long_name, "comment": told.comment}
        found[told.name] = (0.5 * (greatest - least)).assign_attrs(attributes)
    return dataset.assign(found)


def figures_in(analyses: Mapping[str, xr.Dataset]) -> list[FigureSpec]:
    """The figures that the case of a dataset asks for, as they were understood when it was run.

    Raises
    ------
    InputError : a dataset of 0.1.0, which kept the text of its case alone, and that is none
    """
    attributes = next(iter(analyses.values())).attrs
    if "figures_json" in attributes:
        return [
            FigureSpec(figure["name"], figure["kind"], figure_of_before(figure["settings"]))
            for figure in json.loads(attributes["figures_json"])
        ]
    from fiv_cli.case.load import parse_case

    text = text_of_before(str(attributes["case"]))
    overrides = str(attributes.get("overrides", "")).splitlines()
    return list(parse_case(text, "the case in the dataset", overrides).figures)


def name_of_only(dataset: xr.Dataset) -> str:
    """The name of the analysis of a dataset that holds one, which the file does not say."""
    return next(iter(json.loads(dataset.attrs.get("analyses_json", "{}"))), "")


def analysis_of(dataset: xr.Dataset, name: str) -> dict[str, Any]:
    """Kind and settings of the analysis called `name` in its file; {} where it does not say."""
    told = json.loads(dataset.attrs.get("analyses_json", "{}"))
    return dict(told.get(name or name_of_only(dataset), {}))


def variables_in(dataset: xr.Dataset, *roles: Role) -> list[Variable]:
    """What is known of the variables of a dataset that are there for one of `roles`."""
    known = (named(str(name)) for name in dataset.data_vars)
    return [variable for variable in known if variable.role in roles]


def headlines(dataset: xr.Dataset) -> list[str]:
    """What figures show of a dataset unless they say otherwise, the first choice first."""
    known = (named(str(name)) for name in dataset.data_vars)
    shown = [variable for variable in known if variable.headline]
    return [variable.name for variable in sorted(shown, key=lambda variable: variable.headline)]


def is_count(name: str) -> bool:
    """Whether a variable, or what is taken of one, is a whole number."""
    return name in ("classes", "entries") or named(name).kind == "int"


def error_of(name: str) -> str:
    """What says how far a variable may be off, in a dataset that has it."""
    return f"{named(name).width.removesuffix('_width') or name}_error"


def standard_error_of(name: str) -> str:
    """What says how far a mean over a window may be off by chance, in a dataset that has it."""
    return f"{name}_standard_error"


def flag_names(attributes: Mapping[str, object]) -> dict[int, str]:
    """Value -> name of a flag variable, from its attributes; empty for any other variable."""
    if "flag_meanings" not in attributes:
        return {}
    values = np.atleast_1d(np.asarray(attributes["flag_values"]))
    return dict(zip(values.tolist(), str(attributes["flag_meanings"]).split(), strict=True))


def class_names(flags: xr.DataArray) -> np.ndarray:
    """The class at each point of a flag variable, flat (C order); "" where there is none."""
    names = flag_names(flags.attrs)
    return np.array([names.get(code, "") for code in flags.values.ravel().tolist()], dtype=object)


def numbers(array: xr.DataArray) -> xr.DataArray:
    """`array` as floats, NaN where an integer or a flag says that it was not computed."""
    fill = {code for code, name in flag_names(array.attrs).items() if name == NOT_COMPUTED}
    if array.dtype.kind == "i" and not fill:
        fill = {INT_FILL}
    return array.astype(float).where(~array.isin(list(fill)))


def ends_of(dataset: xr.Dataset, variable: str) -> tuple[xr.DataArray, xr.DataArray]:
    """The least and the greatest numbers that a variable may be; the same where it is known."""
    ends = (f"{variable}_low", f"{variable}_high")
    low, high = ends if all(end in dataset for end in ends) else (variable, variable)
    return numbers(dataset[low]), numbers(dataset[high])


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
    if "attractor" not in part:
        return missing
    undecided = is_class(part["attractor"], ("undecided",))
    if role is Role.SHARE:  # how a motion that goes on sticks and slips is known without its class
        return missing | (undecided & is_class(part.get("reason", status), ON_THE_WAY))
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
