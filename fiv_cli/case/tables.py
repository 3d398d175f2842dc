"""One table of the case file against its form, with every problem noted."""

from __future__ import annotations

from collections.abc import Mapping
from functools import reduce
from operator import getitem
from typing import Any, TypeVar, get_args

from pydantic import BaseModel, ValidationError

from fiv_cli.case.kinds import keys_for
from fiv_cli.case.report import MISSING, Path, Report
from fiv_cli.case.words import called_here
from fiv_cli.notation.names import suggest, surely_meant
from fiv_cli.notation.values import describe

MOST_TABLES = 2000
"""Elements of an array of tables; of starts, one table may give as many as one likes."""

T = TypeVar("T", bound=BaseModel)


def read_table(form: type[T], raw: object, path: Path, report: Report) -> T | None:
    """`raw` as a `form`, or None, and every problem noted, when it is none.

    A key that the form does not have is noted, and read as the one that is meant.
    """
    if not isinstance(raw, dict):
        report.add(path, f"must be a table, not {describe(raw)}", getattr(form, "example", ""))
        return None
    try:
        return form.model_validate(_as_meant(form, raw, path, report))
    except ValidationError as error:
        for place, details in _one_per_place(error).items():
            table = reduce(getitem, place[:-1], raw)
            _note(_form_at(form, place), table, (*path, *place), details, report)
    return None


def _as_meant(
    form: type[BaseModel], raw: Mapping[str, Any], path: Path, report: Report
) -> dict[str, Any]:
    """The table with each key that it does not have noted, and its value where it belongs.

    In an open table only a key that must be there can be missed.
    """
    is_open = form.model_config.get("extra") == "allow"
    fields = form.model_fields.items()
    known = {f.alias or n for n, f in fields if f.is_required() or not is_open}
    known &= keys_for(form, raw).keys()
    found = dict(raw)
    passed = {*keys_of(form), *getattr(form, "gone", {})}
    for key in [key for key in raw if key not in passed]:
        meant = surely_meant(key, sorted(known - found.keys()))
        if meant is not None or not is_open:
            _note_unknown(form, raw, (*path, key), report)
            value = found.pop(key)
            found |= {meant: value} if meant is not None else {}
    return found


def _form_at(form: type[BaseModel], place: Path) -> type[BaseModel]:
    """The form of the table, in a `form`, whose key is at `place`."""
    if len(place) < 2:
        return form
    field = {name.alias or key: name for key, name in form.model_fields.items()}.get(str(place[0]))
    if field is None:
        return form
    kinds = (field.annotation, *get_args(field.annotation))
    tables = (kind for kind in kinds if isinstance(kind, type) and issubclass(kind, BaseModel))
    return next(tables, form)


def read_tables(form: type[T], raw: object, key: str, report: Report) -> tuple[T, ...]:
    """The elements of an array of tables that are sound, and a note of every other."""
    if not isinstance(raw, list):
        report.add((key,), f"must be an array of tables [[{key}]], not {describe(raw)}")
        return ()
    if len(raw) > MOST_TABLES:
        report.add((key,), f"{len(raw):,} tables are too many", f"at most {MOST_TABLES:,}")
        return ()
    tables = [read_table(form, one, (key, index), report) for index, one in enumerate(raw)]
    return tuple(table for table in tables if table is not None)


def keys_of(form: type[BaseModel]) -> dict[str, str]:
    """Key as written in a case file -> its description."""
    return {
        field.alias or name: field.description or "" for name, field in form.model_fields.items()
    }


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


def _note(
    form: type[BaseModel],
    table: Mapping[str, Any],
    path: Path,
    details: Mapping[str, Any],
    report: Report,
) -> None:
    kind, value = details["type"], details["input"]
    gone = getattr(form, "gone", {}).get(path[-1])
    if kind == "extra_forbidden" and gone is not None:
        report.add(path, gone(value))
    elif kind == "extra_forbidden":
        _note_unknown(form, table, path, report)
    elif kind == "missing":
        report.add(path, MISSING, keys_of(form).get(str(path[-1]), ""))
    elif kind == "literal_error":
        expected = str(details["ctx"]["expected"])
        names = expected.replace("'", "").replace(" or ", ", ").split(", ")
        of_kinds = path[-1] in ("kind", "what")
        hint = called_here(str(value)) * of_kinds or suggest(str(value), names)
        hint = hint or "`fiv kinds` says what each is" * of_kinds
        report.add(path, f"{describe(value)} is not allowed", expected, hint)
    elif kind == "value_error":
        report.add(path, str(details["ctx"]["error"]))
    elif kind in ("greater_than_equal", "less_than_equal"):
        ((bound, limit),) = details["ctx"].items()
        allowed = f"{'at least' if bound == 'ge' else 'at most'} {limit}"
        report.add(path, f"{value!r} is out of range", allowed)
    else:
        about = keys_of(form).get([part for part in path if isinstance(part, str)][-1], "")
        wanted = _expected(kind, details) + (f" ({about})" if about else "")
        report.add(path, f"{describe(value)} does not fit", wanted)


def _note_unknown(
    form: type[BaseModel], table: Mapping[str, Any], path: Path, report: Report
) -> None:
    key, example, known = str(path[-1]), getattr(form, "example", ""), keys_for(form, table)
    here = getattr(form, "elsewhere", {}).get(key, key)
    hint = suggest(here, known) or (f"for example {example}" if example else "")
    report.unknown(path, f"unknown key {key!r}", key, known, hint, of_key=True)


def _expected(kind: str, details: Mapping[str, Any]) -> str:
    words = {
        "string_type": "a string",
        "int_type": "a whole number",
        "bool_type": "true or false",
        "list_type": "a list",
        "dict_type": "a table, as { NAME = VALUE }",
        "model_type": "a table",
    }
    return words.get(kind, str(details["msg"]))
