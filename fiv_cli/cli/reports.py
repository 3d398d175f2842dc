"""What a pipeline shows of a command's verdicts: JUnit XML, and a table in Markdown."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypeVar
from xml.etree import ElementTree

import click

F = TypeVar("F", bound=Callable[..., Any])


@dataclass(frozen=True)
class Verdict:
    """Of one thing that was tried.

    Attributes
    ----------
    group, name : what it is
    found : in a few words
    passed : whether it is as it should be
    seconds : that it took
    """

    group: str
    name: str
    found: str
    passed: bool
    seconds: float = 0.0


def report_options(command: F) -> F:
    """``--junit FILE`` and ``--summary FILE``."""
    path = click.Path(path_type=Path, dir_okay=False)
    junit = click.option("--junit", type=path, help="Write the verdicts as JUnit XML too.")
    summary = click.option(
        "--summary",
        type=path,
        help="Append them as a Markdown table: --summary $GITHUB_STEP_SUMMARY.",
    )
    return junit(summary(command))


def report(
    title: str, verdicts: Sequence[Verdict], junit: Path | None, summary: Path | None
) -> None:
    """Write what the options of `report_options` ask for."""
    from fiv_cli.files import append_line, write_whole

    if junit is not None:
        write_whole(junit, as_junit(title, verdicts), durable=False)
    if summary is not None:
        append_line(summary, as_markdown(title, verdicts))


def as_junit(title: str, verdicts: Sequence[Verdict]) -> bytes:
    """A JUnit document: a suite with a case for each verdict."""
    failed = sum(not verdict.passed for verdict in verdicts)
    numbers = {"tests": str(len(verdicts)), "failures": str(failed), "errors": "0"}
    root = ElementTree.Element("testsuites", numbers)
    seconds = f"{sum(verdict.seconds for verdict in verdicts):.3f}"
    suite = ElementTree.SubElement(root, "testsuite", {"name": title, "time": seconds, **numbers})
    for verdict in verdicts:
        own = {"classname": verdict.group, "name": verdict.name, "time": f"{verdict.seconds:.3f}"}
        case = ElementTree.SubElement(suite, "testcase", _written(own))
        if not verdict.passed:
            failure = ElementTree.SubElement(case, "failure", _written({"message": verdict.found}))
            failure.text = failure.get("message")
    ElementTree.indent(root)
    return ElementTree.tostring(root, encoding="utf-8", xml_declaration=True)


def _written(texts: dict[str, str]) -> dict[str, str]:
    """Texts without what XML cannot hold."""
    return {
        name: "".join(c for c in text if c.isprintable() or c in "\n\t")
        for name, text in texts.items()
    }


def as_markdown(title: str, verdicts: Sequence[Verdict]) -> str:
    """A table, those that failed first."""
    passed = sum(verdict.passed for verdict in verdicts)
    lines = [
        f"### {title}: {passed} of {len(verdicts)} passed",
        "",
        "| | what | found |",
        "| --- | --- | --- |",
    ]
    for verdict in sorted(verdicts, key=lambda verdict: verdict.passed):
        mark = "passed" if verdict.passed else "**FAILED**"
        lines.append(
            f"| {mark} | {_cell(verdict.group)}: {_cell(verdict.name)} | {_cell(verdict.found)} |"
        )
    return "\n".join([*lines, ""])


def _cell(text: str) -> str:
    """A text in a cell of a table."""
    return " ".join(text.replace("|", "\\|").split())
