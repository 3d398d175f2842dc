"""Whether the case file of a dataset still is what it was when it was run."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from fiv_cli.case.case import Case
from fiv_cli.case.identity import differences, document
from fiv_cli.case.load import parse_case
from fiv_cli.errors import FivError

SHOWN = 3
"""Differences that are told."""

_COMMAND = re.compile(r"fiv run (.*?)(?: --(?:with|set) .*)?")


def changed_since(attributes: Mapping[str, Any]) -> str:
    """How the case file of a dataset differs by now, and what to do.

    Returns
    -------
    str : empty where it does not in anything that the dataset shows, or is not where it was
    """
    command = _COMMAND.fullmatch(str(attributes.get("history", "")))
    source, text = command[1] if command else "", str(attributes["case"])
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
    found = list(_different(then, present))
    if not found:
        return ""
    anew = " --fresh, or with another -o" if differences(document(then), present) else ""
    said = "; ".join([*found[:SHOWN], *["..."] * (len(found) > SHOWN)])
    return f"{source} was changed since ({said}): fiv run {source}{anew}"


def _different(then: Case, now: Case) -> Iterator[str]:
    yield from differences(document(then), now)
    if then.axes != now.axes:
        yield "other values in the grid"
    if [start.labels for start in then.starts] != [start.labels for start in now.starts]:
        yield "other starts"
    if then.figures != now.figures:
        yield "other figures"
