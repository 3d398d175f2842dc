"""One table of the case file against its form, with every problem noted."""

from __future__ import annotations

from collections.abc import Mapping
from copy import deepcopy
from typing import Any, TypeVar

from pydantic import BaseModel, ValidationError

from fiv_cli.case.names import listed, suggest
from fiv_cli.case.report import Path, Report
from fiv_cli.case.structure import describe

T = TypeVar("T", bound=BaseModel)


def read_table(form: type[T], raw: object, path: Path, report: Report) -> T | None:
    """`raw` as a `form`, or None when too little of it is right.

    Keys with a problem are noted and left out, so that the rest of the table can still be
    checked.
    """
    if not isinstance(raw, dict):
        report.add(path, f"must be a table, not {describe(raw)}")
        return None
    try:
        return form.model_validate(raw)
    except ValidationError as error:
        errors = _one_per_place(error)
    remaining = deepcopy(raw)
    for place, details in errors.items():
        _note(form, path + place, details, report)
        _remove(remaining, place)
    return _valid_or_none(form, remaining)


def read_tables(
    form: type[T], raw: object, path: Path, report: Report
) -> list[tuple[Path, dict[str, Any], T]]:
    """Each readable element of an array of tables, with its path and its raw keys."""
    if not isinstance(raw, list):
        report.add(path, f"must be an array of tables [[{path[-1]}]], not {describe(raw)}")
        return []
    places = [(*path, index) for index in range(len(raw))]
    tables = [
        (place, element, read_table(form, element, place, report))
        for place, element in zip(places, raw, strict=True)
    ]
    return [(place, element, table) for place, element, table in tables if table is not None]


def keys_of(form: type[BaseModel]) -> dict[str, str]:
    """Key as written in a case file -> its description."""
    return {
        field.alias or name: field.description or "" for name, field in form.model_fields.items()
    }


def _valid_or_none(form: type[T], raw: dict[str, Any]) -> T | None:
    try:
        return form.model_validate({**getattr(form, "placeholders", {}), **raw})
    except ValidationError:
        return None


def _one_per_place(error: ValidationError) -> dict[Path, Mapping[str, Any]]:
    """Pydantic names the branch of a union in the place; cut there, and keep the first error."""
    places: dict[Path, Mapping[str, Any]] = {}
    for details in error.errors(include_url=False, include_context=True):
        places.setdefault(_place_in_file(details["loc"]), details)
    return places


def _place_in_file(loc: tuple[str | int, ...]) -> Path:
    kept: list[str | int] = []
    for part in loc:
        if part in ("str", "bool") or str(part).startswith(("list[", "dict[", "literal[")):
            break
        kept.append(part)
    return tuple(kept)


def _note(form: type[BaseModel], path: Path, details: Mapping[str, Any], report: Report) -> None:
    kind, value = details["type"], details["input"]
    if kind == "extra_forbidden":
        keys = keys_of(form)
        report.add(path, f"unknown key {path[-1]!r}", listed(keys), suggest(str(path[-1]), keys))
    elif kind == "missing":
        report.add(path, "is missing", keys_of(form).get(str(path[-1]), ""))
    elif kind == "literal_error":
        expected = str(details["ctx"]["expected"])
        names = expected.replace("'", "").replace(" or ", ", ").split(", ")
        report.add(path, f"{describe(value)} is not allowed", expected, suggest(str(value), names))
    elif kind == "value_error":
        report.add(path, str(details["ctx"]["error"]))
    else:
        report.add(path, f"{describe(value)} does not fit", _expected(kind, details))


def _expected(kind: str, details: Mapping[str, Any]) -> str:
    words = {
        "string_type": "a string",
        "int_type": "a whole number",
        "bool_type": "true or false",
        "list_type": "a list",
        "dict_type": "a table",
        "model_type": "a table",
    }
    return words.get(kind, str(details["msg"]))


def _remove(raw: dict[str, Any], place: Path) -> None:
    """Delete what is at `place`; of a list, the whole list."""
    parent: Any = raw
    for part in place[:-1]:
        if not isinstance(parent.get(part), dict):
            parent.pop(part, None)
            return
        parent = parent[part]
    parent.pop(place[-1], None)
