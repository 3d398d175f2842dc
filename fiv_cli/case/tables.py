"""One table of the case file against its form, with every problem noted."""

from __future__ import annotations

from collections.abc import Mapping
from copy import deepcopy
from typing import Any, TypeVar, get_args

from pydantic import BaseModel, ValidationError

from fiv_cli.case.report import Path, Report
from fiv_cli.notation.names import listed, nearest, suggest
from fiv_cli.notation.values import describe

MOST_TABLES = 2000
"""Elements of an array of tables; of starts, one table may give as many as one likes."""

T = TypeVar("T", bound=BaseModel)


def read_table(form: type[T], raw: object, path: Path, report: Report) -> T | None:
    """`raw` as a `form`, or None when too little of it is right.

    Keys with a problem are noted and left out, so that the rest of the table can still be
    checked.
    """
    if not isinstance(raw, dict):
        report.add(path, f"must be a table, not {describe(raw)}")
        return None
    raw = _meant(form, raw, path, report)
    try:
        return form.model_validate(raw)
    except ValidationError as error:
        errors = _one_per_place(error)
    remaining = deepcopy(raw)
    for place, details in errors.items():
        _note(form, path + place, details, report)
        _remove(remaining, place)
    return _valid_or_none(form, remaining)


def _meant(
    form: type[BaseModel], raw: dict[str, Any], path: Path, report: Report
) -> dict[str, Any]:
    """`raw` with each misspelt key, noted, under the key that it resembles and that is not given.

    In a table whose further keys are checked elsewhere only the keys that must be there count.
    """
    keys = keys_of(form)
    is_open = form.model_config.get("extra") == "allow"
    fields = form.model_fields.items()
    needed = {field.alias or name for name, field in fields if field.is_required() or not is_open}
    found = {key: value for key, value in raw.items() if key in keys}
    for key in [key for key in raw if key not in keys]:
        meant = nearest(key, needed - found.keys())
        if meant is not None:
            _note_unknown(keys, (*path, key), report)
        found[meant or key] = raw[key]
    for name, inner in _tables_in(form).items():
        if isinstance(found.get(name), dict):
            found[name] = _meant(inner, found[name], (*path, name), report)
    return found


def _tables_in(form: type[BaseModel]) -> dict[str, type[BaseModel]]:
    """Key -> form, of the keys that hold a table."""
    return {
        field.alias or name: kind
        for name, field in form.model_fields.items()
        for kind in (field.annotation, *get_args(field.annotation))
        if isinstance(kind, type) and issubclass(kind, BaseModel)
    }


def _note_unknown(keys: Mapping[str, str], path: Path, report: Report) -> None:
    key = str(path[-1])
    report.add(path, f"unknown key {key!r}", listed(keys), suggest(key, keys))


def read_tables(
    form: type[T], raw: object, path: Path, report: Report
) -> list[tuple[Path, dict[str, Any], T]]:
    """Each readable element of an array of tables, with its path and its raw keys."""
    if not isinstance(raw, list):
        report.add(path, f"must be an array of tables [[{path[-1]}]], not {describe(raw)}")
        return []
    if len(raw) > MOST_TABLES:
        report.add(path, f"{len(raw):,} tables are too many", f"at most {MOST_TABLES:,}")
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
    gone = getattr(form, "gone", {}).get(path[-1])
    if kind == "extra_forbidden" and gone is not None:
        report.add(path, gone(value))
    elif kind == "extra_forbidden":
        _note_unknown(keys_of(form), path, report)
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
