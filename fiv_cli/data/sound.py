"""Whether a dataset has the form that fiv writes; whatever reads one relies on that.

A file may be damaged, or edited by hand. What follows from that is found here, once, and told;
behind it a missing class or a row of negative length cannot occur.
"""

from __future__ import annotations

import json
from collections.abc import Iterable, Iterator, Mapping
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from fiv_cli.analyses.catalogue import named
from fiv_cli.case.grammar import figure_of_before
from fiv_cli.case.structure import FigureTable
from fiv_cli.flags import TABLES
from fiv_cli.notation.names import can_name_a_file

if TYPE_CHECKING:
    import xarray as xr

    from fiv_cli.data.dataset import Dataset, Labelled

TEXTS = ("case", "title", "reference", "fingerprint", "source", "model", "law", "overrides")
MEANING = ("units", "long_name", "symbol", "role", "comment", "flag_meanings")
WORDS = (*MEANING, "sample_dimension", "along")
OBJECTS = ("parameters", "options", "starts", "schedule", "solver", "own", "packages")
COUNTS = ("refined_levels", "points_run", "points_filled_in", "sample_size", "sample_mislabelled")

# What a class or a count must have among its names for the rest to make sense.
STATUSES = {"ok", "pending", "not_computed"}

# Classes that are drawn and counted by their names; to other tables a later fiv may add.
CLOSED = ("attractor", "contact_state")


def fault_of(dataset: xr.Dataset, name: str) -> str:
    """The first thing found wrong with the dataset of one analysis; empty when it is sound."""
    return next(_faults(dataset, name), "")


def form_of(dataset: xr.Dataset | Dataset) -> dict[str, list[str]]:
    """Variable -> its kind and dims: by this a reader sees whether a file is as it was written."""
    return {
        str(name): [_kind(variable), *map(str, variable.dims)]
        for name, variable in dataset.variables.items()
    }


def _kind(variable: xr.Variable | Labelled) -> str:
    """What a variable holds; a count with gaps is read as a number."""
    if _is_flag(variable):
        return "classes"
    return "numbers" if variable.dtype.kind in "fiu" else "texts"


def _faults(dataset: xr.Dataset, analysis: str) -> Iterator[str]:
    yield from _of_attributes(dataset.attrs)
    if "variables_json" in dataset.attrs:  # 0.1.0 did not write it
        yield from _of_form(dataset, analysis)
    for name, variable in dataset.variables.items():
        yield from _of_variable(str(name), variable)
    yield from _of_status(dataset)
    yield from _of_axes(dataset)
    yield from _of_widths(dataset)
    yield from _of_ragged(dataset)
    yield from _of_events(dataset)
    yield from _of_shapes(dataset)


# --- attributes -----------------------------------------------------------------------------------
def _of_attributes(attributes: Mapping[str, Any]) -> Iterator[str]:
    for name in TEXTS:
        if not isinstance(attributes.get(name, ""), str):
            yield f"the attribute {name} is no text"
    yield from _of_objects(attributes)
    if "analyses_json" in attributes:
        yield from _of_analyses(attributes["analyses_json"])
    if "figures_json" in attributes:
        yield from _of_figures(attributes["figures_json"])
    if "refined_of" in attributes:
        yield from _of_refinement(attributes)


def _of_objects(attributes: Mapping[str, Any]) -> Iterator[str]:
    objects = {name: _parsed(attributes.get(f"{name}_json", "{}")) for name in OBJECTS}
    for name, held in objects.items():
        if not isinstance(held, dict):
            yield f"{name}_json is no table"
            return
    if not isinstance(objects["solver"].get("rtol", 0.0), float):
        yield "solver_json: its rtol is no number"
    if not all(map(_is_file, objects["own"].values())):
        yield "own_json holds something else than files"


def _is_file(file: object) -> bool:
    """Whether it is a file of one's own: its text, and the names of what it holds."""
    if not isinstance(file, dict) or not isinstance(file.get("text"), str):
        return False
    names = file.get("holds")
    return isinstance(names, list) and all(isinstance(name, str) for name in names)


def _of_analyses(text: object) -> Iterator[str]:
    tables = _parsed(text)
    if not isinstance(tables, dict) or not all(map(_is_analysis, tables.values())):
        yield "analyses_json names no analyses"


def _is_analysis(table: object) -> bool:
    """Whether it has a kind and settings, and a section among them its words and numbers."""
    if not isinstance(table, dict) or not isinstance(table.get("kind"), str):
        return False
    settings = table.get("settings")
    section = settings.get("section") if isinstance(settings, dict) else 0
    return section is None or (
        isinstance(section, dict)
        and all(isinstance(v, str | int | float) for v in section.values())
    )


def _of_figures(text: object) -> Iterator[str]:
    figures = _parsed(text)
    if not isinstance(figures, list):
        yield "figures_json is no list of figures"
        return
    for figure in figures:
        if not isinstance(figure, dict) or set(figure) != {"name", "kind", "settings"}:
            yield "figures_json holds something else than a figure"
        elif not _is_figure(figure):
            yield f"figures_json: {figure['name']!r} is no figure that a case can ask for"


def _is_figure(figure: Mapping[str, Any]) -> bool:
    settings = figure["settings"]
    if not isinstance(settings, dict) or not isinstance(figure["name"], str):
        return False
    if not can_name_a_file(figure["name"]):
        return False
    try:
        FigureTable.model_validate({**figure_of_before(settings), "kind": figure["kind"]})
    except ValueError:
        return False
    return True


def _of_refinement(attributes: Mapping[str, Any]) -> Iterator[str]:
    for name in COUNTS:
        if not _is_count(attributes.get(name)):
            yield f"the attribute {name} of the refinement is no count"
    for name in ("refined_of", "refined_from"):
        if not isinstance(attributes.get(name), str):
            yield f"the attribute {name} of the refinement is no text"


def _is_count(value: object) -> bool:
    return isinstance(value, int | np.integer) and int(value) >= 0


def _parsed(text: object) -> Any:
    """What stands in a text of JSON; None where it is none."""
    try:
        return json.loads(text) if isinstance(text, str) else None
    except (ValueError, RecursionError):
        return None


def _of_form(dataset: xr.Dataset, analysis: str) -> Iterator[str]:
    """Every variable is there, of the kind and over the dims that were written."""
    forms = _parsed(dataset.attrs["variables_json"])
    form = (
        forms.get(analysis, next(iter(forms.values()), None)) if isinstance(forms, dict) else None
    )
    if not isinstance(form, dict):
        yield "variables_json does not say what was written"
        return
    now = form_of(dataset)
    for name, written in form.items():
        if name not in now:
            yield f"{name} is missing"
        elif now[name] != written:
            yield f"{name} is {now[name]}, and was written as {written}"


# --- variables ------------------------------------------------------------------------------------
def _of_variable(name: str, variable: xr.Variable) -> Iterator[str]:
    if variable.dtype.kind not in "fiuU" and not _holds_texts(variable):
        yield f"{name} holds neither numbers nor texts"
    for word in WORDS:
        if not isinstance(variable.attrs.get(word, ""), str):
            yield f"{name}: the attribute {word} is no text"
    if _is_flag(variable):
        yield from _of_flag(name, variable)


def _holds_texts(variable: xr.Variable) -> bool:
    """Whether it holds texts, which are read as objects."""
    return variable.dtype.kind == "O" and all(isinstance(v, str) for v in variable.values.flat)


def _is_flag(variable: xr.Variable | Labelled) -> bool:
    """Whether it is to be read as classes: they alone are stored in one byte."""
    named = {"flag_values", "flag_meanings"} & set(variable.attrs)
    return bool(named) or variable.dtype == np.int8


def _of_flag(name: str, variable: xr.Variable) -> Iterator[str]:
    codes = np.atleast_1d(np.asarray(variable.attrs.get("flag_values", ())))
    names = str(variable.attrs.get("flag_meanings", "")).split()
    if variable.dtype.kind not in "iu" or codes.dtype.kind not in "iu":
        yield f"{name}: its classes are no whole numbers"
    elif not len(codes) == len(names) == len(set(codes.tolist())) == len(set(names)) > 0:
        yield f"{name}: {len(codes)} flag_values do not go with {len(names)} flag_meanings"
    elif not set(names) <= _classes(name, names):
        yield f"{name} names classes that there are not"
    elif not np.isin(variable.values, codes).all():
        yield f"{name} holds a number that no class has"


def _classes(name: str, names: Iterable[str]) -> set[str]:
    """The classes that a flag variable may have: `names` where its table is open."""
    table = named(name).flags
    return set(TABLES[table].codes if table in CLOSED else names)


def _of_status(dataset: xr.Dataset) -> Iterator[str]:
    status = dataset["status"]
    if not set(str(status.attrs.get("flag_meanings", "")).split()) >= STATUSES:
        yield f"status does not tell {', '.join(sorted(STATUSES))} apart"
    if not all(dataset.sizes[dim] for dim in status.dims):
        yield "it holds no point"
    if "reason" in dataset and dataset["reason"].dims != status.dims:
        yield "status and reason are not of the same points"


def _of_axes(dataset: xr.Dataset) -> Iterator[str]:
    for name, axis in dataset.coords.items():
        on_grid = set(axis.dims) <= set(dataset["status"].dims)
        if axis.ndim > 1:
            yield f"{name} is no axis: it has {axis.ndim} dims"
        elif axis.dtype.kind == "f" and on_grid and not np.isfinite(axis.values).all():
            yield f"the axis {name} holds something else than finite numbers"
    if "time" in dataset and not _goes_on(dataset["time"].values):
        yield "time does not go on"


def _goes_on(time: NDArray[Any]) -> bool:
    """Whether what is known of a time, or of each of several, increases."""
    return time.dtype.kind in "fiu" and not bool((np.diff(np.atleast_1d(time), axis=-1) <= 0).any())


def _of_widths(dataset: xr.Dataset) -> Iterator[str]:
    for width in {named(str(name)).width for name in dataset.data_vars} & {*dataset.data_vars}:
        if dataset[width].dtype.kind in "fi" and bool((dataset[width].values < 0).any()):
            yield f"{width} holds a negative width"


# --- how variables go together --------------------------------------------------------------------
def _of_ragged(dataset: xr.Dataset) -> Iterator[str]:
    """Row sizes: whole numbers, one for each point, that come to what is stored."""
    for name, sizes in dataset.data_vars.items():
        dim = sizes.attrs.get("sample_dimension")
        if dim is None:
            continue
        if sizes.dims != dataset["status"].dims or sizes.dtype.kind not in "iu":
            yield f"{name} is not one whole number for each point"
        elif (sizes.values < 0).any():
            yield f"{name} counts rows of negative length"
        elif dim in dataset.dims and int(sizes.values.sum(dtype=object)) != dataset.sizes[dim]:
            yield f"{name} does not come to the {dataset.sizes[dim]} values along {dim}"
        elif dim in dataset["status"].dims:
            yield f"{name}: {dim} is a dim of the points"


def _of_events(dataset: xr.Dataset) -> Iterator[str]:
    """Every event is of a contact."""
    if "event_contact" in dataset and not np.isfinite(dataset["event_contact"].values).all():
        yield "event_contact tells of an event without a contact"


def _of_shapes(dataset: xr.Dataset) -> Iterator[str]:
    """Every variable lies over the points, then its own dims; or over the rows of a ragged one."""
    points = dataset["status"].dims
    ragged = {v.attrs.get("sample_dimension") for v in dataset.data_vars.values()}
    for name, variable in dataset.data_vars.items():
        over_points = variable.dims[: len(points)] == points
        over_rows = len(variable.dims) == 1 and variable.dims[0] in ragged
        if not (over_points or over_rows):
            dims = ", ".join(map(str, variable.dims)) or "nothing"
            yield f"{name} lies over {dims}, not over the points ({', '.join(map(str, points))})"
