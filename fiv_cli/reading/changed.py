"""Whether the case file of a dataset still is what it was when it was run."""

from __future__ import annotations

import json
import re
from collections.abc import Iterator, Mapping
from contextlib import suppress
from importlib.util import decode_source
from pathlib import Path
from typing import Any

from fiv_cli.case.case import Case
from fiv_cli.case.identity import differences, document, output_of
from fiv_cli.case.load import parse_case
from fiv_cli.errors import FivError

SHOWN = 3
"""Differences that are told."""

_ANEW = " --fresh, or to another -o"
_COMMAND = re.compile(r"fiv run (.*?)(?: --(?:with|set) .*)?")


def changed_since(attributes: Mapping[str, Any], file: Path, drawn: bool = True) -> str:
    """How the case file of a dataset, or a file of one's own, differs by now, and what to do.

    Parameters
    ----------
    file : the dataset
    drawn : figures count, too

    Returns
    -------
    str : empty where nothing does that the dataset shows, or is not where it was
    """
    run = str(attributes.get("history", ""))
    command = _COMMAND.fullmatch(run)
    source, text = command[1] if command else "", str(attributes["case"])
    if file.resolve() != output_of(source).resolve():
        run += f" -o {file}"
    if path := next(_edited(attributes), ""):
        return f"{path} was changed since: {run}{_ANEW}"
    try:
        now = Path(source).read_bytes().decode("utf-8-sig")
    except (OSError, ValueError):
        return ""
    if now == text:
        return ""
    overrides = str(attributes.get("overrides", "")).splitlines()
    try:
        then, present = (parse_case(one, source, overrides) for one in (text, now))
    except FivError:
        return f"{source} was changed since (fiv status {source} says whether it differs)"
    found = list(_different(then, present, drawn))
    if not found:
        return ""
    anew = _ANEW if differences(document(then), present) else ""
    said = "; ".join([*found[:SHOWN], *["..."] * (len(found) > SHOWN)])
    return f"{source} was changed since ({said}): {run}{anew}"


def _edited(attributes: Mapping[str, Any]) -> Iterator[str]:
    """Files of one's own that hold another text by now."""
    for path, file in json.loads(attributes.get("own_json", "{}")).items():
        with suppress(OSError, SyntaxError, UnicodeDecodeError):
            if decode_source(Path(path).read_bytes()) != file["text"]:
                yield path


def _different(then: Case, now: Case, drawn: bool) -> Iterator[str]:
    yield from differences(document(then), now)
    if then.axes != now.axes:
        yield "other values in the grid"
    if [start.labels for start in then.starts] != [start.labels for start in now.starts]:
        yield "other starts"
    if drawn and then.figures != now.figures:
        yield "other figures"
