"""What several commands share: options, tables, JSON."""

from __future__ import annotations

import atexit
import json
import os
import shutil
import sys
import tempfile
from collections.abc import Callable, Sequence
from functools import partial
from typing import Any, TypeVar

import click

from fiv_cli import ending

F = TypeVar("F", bound=Callable[..., Any])

# The version of what ``--json`` prints.
JSON_SCHEMA = 1

# Bytes that a cache must have room for: the integrator and a model with its tangents.
CACHE_ROOM = 8_000_000

set_option: Callable[[F], F] = click.option(
    "--set",
    "overrides",
    multiple=True,
    metavar="PATH=VALUE",
    help="Change the case: --set grid.mu_k=[0.3], --set analysis.0.t_max=10. Repeatable.",
)

json_option: Callable[[F], F] = click.option(
    "--json", "as_json", is_flag=True, help="Print JSON instead of text."
)


def provide_cache() -> None:
    """Let compiled code go to a temporary folder where the user's cache cannot be written.

    Called before anything is compiled. The environment carries the choice to worker processes.
    """
    from fiv_cli.codegen.cache import cache_root

    try:
        root = cache_root()
    except RuntimeError:  # neither HOME nor an entry of this user among the accounts
        _compile_for_once("the folder of compiled code is unknown (there is no home folder)")
        return
    try:
        root.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=root) as file:
            file.write(bytes(CACHE_ROOM))
    except OSError as error:
        _compile_for_once(f"{root}: compiled code cannot be kept there ({error.strerror})")


def _compile_for_once(why: str) -> None:
    from fiv_cli.codegen.cache import VARIABLE

    folder = tempfile.mkdtemp(prefix="fiv-cache-")
    remove = partial(shutil.rmtree, folder, ignore_errors=True)
    atexit.register(remove)
    ending.at_last(remove)
    os.environ[VARIABLE] = folder
    click.echo(
        f"{why}; it is compiled for this run only, which takes up to a minute\n"
        f"next time: {VARIABLE}=FOLDER in the environment, a folder that can be written",
        err=True,
    )


def print_json(document: dict[str, Any]) -> None:
    """One JSON object with the schema number first."""
    click.echo(json.dumps({"schema": JSON_SCHEMA, **document}, indent=2, ensure_ascii=False))


def print_table(title: str, columns: Sequence[str], rows: Sequence[Sequence[str]]) -> None:
    """A table: drawn by rich on a terminal, in plain columns elsewhere."""
    if sys.stdout.isatty():
        _print_rich(title, columns, rows)
    else:
        click.echo("\n".join([title, *plain_table(columns, rows)]))


def plain_table(columns: Sequence[str], rows: Sequence[Sequence[str]]) -> list[str]:
    """Lines of columns two blanks apart, the header first."""
    lines = [columns, *rows]
    widths = [max(len(line[i]) for line in lines) for i in range(len(columns))]
    return [
        "  ".join(cell.ljust(width) for cell, width in zip(line, widths, strict=True)).rstrip()
        for line in lines
    ]


def _print_rich(title: str, columns: Sequence[str], rows: Sequence[Sequence[str]]) -> None:
    from rich.console import Console
    from rich.table import Table
    from rich.text import Text

    table = Table(title=Text(title), title_justify="left", header_style="bold")
    for column in columns:
        table.add_column(column, overflow="fold")
    for row in rows:
        table.add_row(*(Text(cell) for cell in row))
    Console().print(table)
