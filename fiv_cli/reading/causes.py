"""What two datasets were computed from, where it differs: the causes of what differs in them."""

from __future__ import annotations

import json
import tomllib
from collections.abc import Collection, Iterator, Mapping
from difflib import ndiff
from typing import Any

from fiv_cli.case.identity import section_as_written
from fiv_cli.case.structure import InitialTable

WORDS = {
    "model": "model",
    "law": "law",
    "source": "program",
    "numerics_version": "numerics version",
    "model_numerics_version": "numerics version of the model",
    "law_numerics_version": "numerics version of the law",
}
TABLES = {
    "parameters_json": "parameter",
    "options_json": "option",
    "schedule_json": "schedule",
    "solver_json": "solver",
    "analyses_json": "analysis",
}


NONE = "none"  # a parameter, of a model that did not have it


def causes(
    left: Mapping[str, Any], right: Mapping[str, Any], axes: Collection[str] = ()
) -> list[str]:
    """What the global attributes of two datasets say of different models, values and settings.

    A line each; what only one of them fixes while the other has it on one of the `axes` is a
    difference of their coordinates.
    """
    added = "parameter" if left.get("model") == right.get("model") else ""
    words = [(WORDS[key], left.get(key), right.get(key)) for key in WORDS]
    tables = [
        (f"{what} {name}", one.get(name, NONE), other.get(name, NONE))
        for key, what in TABLES.items()
        for one, other in [(_flat(_read(side, key)) for side in (left, right))]
        for name in one | other
        if name in one.keys() & other.keys() or (what == added and name not in axes)
    ]
    starts = _of_starts(_starts(left), _starts(right))
    pairs = [*words, *tables, *starts]
    told = [f"{what}: {_spoken(a)} against {_spoken(b)}" for what, a, b in pairs if a != b]
    return [*told, *_of_texts(_texts(left), _texts(right))]


def settings_of(attributes: Mapping[str, Any]) -> dict[str, Any]:
    """Dotted name of each setting of each analysis -> its value."""
    told = _flat(_read(attributes, "analyses_json"))
    return {name: value for name, value in told.items() if ".settings." in name}


def case_of(attributes: Mapping[str, Any]) -> dict[str, Any]:
    """The tables of the case of a dataset; none of one that nobody has made from a case."""
    try:
        return tomllib.loads(str(attributes.get("case", "")))
    except tomllib.TOMLDecodeError:
        return {}


def _starts(attributes: Mapping[str, Any]) -> dict[str, dict[str, Any]]:
    """Label of a start, or what ``--set`` says of one -> what the case says of it."""
    tables = case_of(attributes).get("initial", [])
    own = {f"start {one.get('label', number)}": _flat(one) for number, one in enumerate(tables)}
    said = (line.partition("=") for line in attributes.get("overrides", "").splitlines())
    changed = {name: value for name, _, value in said if name.startswith("initial")}
    return own | {"--set": changed}


def _of_starts(
    left: Mapping[str, dict[str, Any]], right: Mapping[str, dict[str, Any]]
) -> list[tuple[str, Any, Any]]:
    """What is said otherwise of starts that both have."""
    return [
        (f"{start} {key}", *(side[start].get(key, _unsaid(key)) for side in (left, right)))
        for start in left.keys() & right.keys()
        for key in left[start] | right[start]
    ]


def _unsaid(key: str) -> Any:
    """What a start has where its case says nothing."""
    field = InitialTable.model_fields.get("from_label" if key == "from" else key)
    return NONE if field is None or field.default is None else field.get_default()


def _read(attributes: Mapping[str, Any], key: str) -> dict[str, Any]:
    return dict(json.loads(attributes.get(key, "{}")))


def _flat(table: Mapping[str, Any], prefix: str = "") -> dict[str, Any]:
    """Dotted name -> value."""
    found: dict[str, Any] = {}
    for key, value in table.items():
        if key == "section" and isinstance(value, dict):
            found[prefix + key] = section_as_written(value)
        elif isinstance(value, dict):
            found |= _flat(value, f"{prefix}{key}.")
        else:
            found[prefix + key] = value
    return found


def _spoken(value: object) -> str:
    return f"{value:.12g}" if isinstance(value, float) else str(value)


def _texts(attributes: Mapping[str, Any]) -> dict[str, tuple[str, str]]:
    """Model or law of an own file -> the file, and what stood there."""
    files = _read(attributes, "own_json")
    return {name: (path, file["text"]) for path, file in files.items() for name in file["holds"]}


def _of_texts(
    left: Mapping[str, tuple[str, str]], right: Mapping[str, tuple[str, str]]
) -> Iterator[str]:
    for name, (path, text) in left.items():
        other = right.get(name, (path, text))
        if other[1] != text:
            lines = ndiff(text.splitlines(), other[1].splitlines())
            changed = [line for line in lines if line[:2] in ("- ", "+ ")]
            files = path if path == other[0] else f"{path}, {other[0]}"
            yield f"text of {name} ({files}), of {len(changed)} changed lines: {changed[0]}"
