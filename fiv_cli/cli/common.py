"""What several commands share: options, tables, JSON."""

from __future__ import annotations

import json
import math
import re
import shlex
import sys
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import fields, is_dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

import click

from fiv_cli.errors import UsageError
from fiv_cli.notation.tables import plain_table

if TYPE_CHECKING:
    from fiv_cli.sweep.parts import Part

F = TypeVar("F", bound=Callable[..., Any])

# Exit codes of what was computed, where some points failed or used up events or steps, or are left.
UNSOUND, STILL_TO_RUN = 4, 8

# The version of what ``--json`` prints.
JSON_SCHEMA = 1

set_option: Callable[[F], F] = click.option(
    "--set",
    "overrides",
    multiple=True,
    metavar="PATH=VALUE",
    help="Change the case: --set grid.mu_k=[0.3], --set analysis.0.t_max=10. Repeatable.",
)


TAKE_FILES = (
    *("assemble", "check", "claims", "history", "models", "new", "plot", "regress", "run"),
    *("schema", "status", "variables", "verify"),
)
"""Commands that are told of models and laws in files."""


def with_files(text: str, files: Iterable[str]) -> str:
    """A message whose next commands are told of the files that this one was given."""
    given = [f" --with {shlex.quote(file)}" for file in files]
    return "\n".join(
        _told_of(given, line) if line.startswith("next:") else line for line in text.split("\n")
    )


def _told_of(given: Iterable[str], line: str) -> str:
    """A line whose commands have those options, too, that are not in it."""
    added = "".join(one for one in given if one not in line)
    command = rf"\bfiv (?:{'|'.join(TAKE_FILES)})(?![-\w])"
    return re.sub(command, lambda match: match[0] + added, line)


_NAMED = "fiv_cli.with"


def named_files() -> bool:
    """Whether this command was given files of models or laws."""
    return _NAMED in click.get_current_context().meta


def given_files() -> list[str]:
    """The files of models and laws on the line of this command; not those of the environment."""
    return list(click.get_current_context().meta.get(_NAMED, []))


def _use(context: click.Context, option: click.Parameter, paths: Sequence[Path]) -> None:
    """Have the models and laws of files at hand for this command; heavy only where there are.

    Files of the environment are there beside those of the command line: what is advised for a
    command, one more ``--with``, never takes away what its model needed.
    """
    always = map(Path, option.value_from_envvar(context) or ())
    if files := (*always, *paths):
        from fiv_cli.own.probe import use_files

        use_files(files)
        context.meta[_NAMED] = [*map(str, paths)]
        context.call_on_close(lambda: use_files(()))


with_option: Callable[[F], F] = click.option(
    "--with",
    "own",
    multiple=True,
    type=click.Path(path_type=Path),
    metavar="FILE.py",
    envvar="FIV_WITH",
    expose_value=False,
    callback=_use,
    help="Models and laws of your own: a file, or a folder of them. Repeatable, beside those of "
    "FIV_WITH=ONE.py:TWO.py.",
)

output_option: Callable[[F], F] = click.option(
    "-o",
    "--output",
    type=click.Path(path_type=Path),
    metavar="FILE",
    help="Write to this file, which must not be there yet.",
)


def hand_out(text: str, output: Path | None) -> None:
    """Print a template, or write it to a file that is not there yet.

    Raises
    ------
    UsageError
        the file is there: it may hold work.
    """
    if output is None:
        click.echo(text, nl=False)
        return
    try:
        with output.open("x", encoding="utf-8") as file:
            file.write(text)
    except FileExistsError as error:
        raise UsageError(f"{output}: is there already\nnext: -o ANOTHER, or remove it") from error


json_option: Callable[[F], F] = click.option(
    "--json", "as_json", is_flag=True, help="Print JSON instead of text."
)


def at_option(meaning: str) -> Callable[[F], F]:
    """``--at``, whose values `parse_places` reads."""
    return click.option("--at", "places", multiple=True, metavar="AXIS=VALUE,...", help=meaning)


_FLAT = re.compile(r"\[([^\[\]]*)\]")
_COMPARED = re.compile(r"([^\W\d][\w.]*)\s*(>=|<=|!=|>|<)\s*([-+.\d][^<>=]*)")
_WHOLE = re.compile(r""""[^"]*"|'[^']*'|\[[^=]*\]""")
"""What no comma divides: a quoted text, a list."""


def parse_places(places: tuple[str, ...]) -> dict[str, str]:
    """``--at`` as axis -> text.

    Raises
    ------
    UsageError
        a part has no ``=``, or an axis stands twice.
    """
    found: dict[str, str] = {}
    for name, value in _assigned(places, "--at AXIS=VALUE,initial=LABEL"):
        if name in found:
            raise UsageError(f"--at: {name} is given twice\nnext: give it once")
        found[name] = value
    return found


def parse_selection(places: tuple[str, ...]) -> dict[str, list[str]]:
    """``--at`` as axis -> texts, of an axis that stands several times, or with a list, all.

    Raises
    ------
    UsageError
        a part has no ``=``, or of several conditions it is not clear which are to hold.
    """
    found: dict[str, list[str]] = {}
    for name, value in _assigned(
        places, "--at AXIS=VALUE, or of several --at 'AXIS=[ONE,OTHER]'", conditions=True
    ):
        several = _FLAT.fullmatch(value)
        texts = several[1].split(",") if several else [value]
        found.setdefault(name, []).extend(text.strip().strip("\"'") for text in texts)
        if len(found[name]) > 1 and any(sign in text for text in found[name] for sign in "<>"):
            raise UsageError(
                f"--at: {name} is given twice\nnext: one condition, --at '{name}=5 <= . < 7'"
            )
    return found


def _assigned(
    places: tuple[str, ...], form: str, conditions: bool = False
) -> Iterator[tuple[str, str]]:
    for part in (part.strip() for place in places for part in _parts(place)):
        name, equals, value = (text.strip() for text in part.partition("="))
        if conditions and (compared := _COMPARED.fullmatch(part)):
            condition = "{}=. {} {}".format(*compared.groups())
            raise UsageError(f"--at {part}: malformed\nnext: a condition, --at '{condition}'")
        if not equals or not name or not value:
            raise UsageError(f"--at {part}: malformed\nnext: {form}")
        yield name, value


def _parts(place: str) -> list[str]:
    """`place` divided at its commas, but for those in quotes and brackets."""
    kept = _WHOLE.sub(lambda match: match[0].replace(",", "\0"), place)
    return [part.replace("\0", ",") for part in kept.split(",")]


class PartType(click.ParamType):
    """``3/16``: the third of sixteen parts."""

    name = "I/N"

    def convert(
        self, value: Any, parameter: click.Parameter | None, context: click.Context | None
    ) -> Part:
        """The part that a text names."""
        from fiv_cli.sweep.parts import MOST, Part

        number, _, of = str(value).partition("/")
        if not (number.isdecimal() and of.isdecimal() and 1 <= int(number) <= int(of) <= MOST):
            self.fail(f"{value!r}: part I of N is written I/N, from 1/N to N/N, N up to {MOST}")
        return Part(int(number), int(of))


def provide_cache() -> None:
    """Settle where compiled code goes before anything is compiled; workers inherit the choice."""
    from fiv_cli.codegen import cache

    cache.provide()


def print_json(document: Mapping[str, object]) -> None:
    """One JSON object with the schema number first; see `plain`."""
    found = {"schema": JSON_SCHEMA, **plain(document)}
    click.echo(json.dumps(found, indent=2, ensure_ascii=False))


def plain(value: Any) -> Any:
    """Dataclasses, tables and sequences as JSON values.

    JSON has no NaN and no infinity (null stands for them), and of a dataclass what is a function is
    left out.
    """
    if is_dataclass(value):
        shown = {field.name: getattr(value, field.name) for field in fields(value)}
        return {name: plain(item) for name, item in shown.items() if not callable(item)}
    if isinstance(value, Mapping):
        return {str(key): plain(item) for key, item in value.items()}
    if isinstance(value, tuple | list):
        return [plain(item) for item in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value


def print_table(title: str, columns: Sequence[str], rows: Sequence[Sequence[str]]) -> None:
    """A table: drawn by rich on a terminal, in plain columns elsewhere."""
    if sys.stdout.isatty():
        _print_rich(title, columns, rows)
    else:
        click.echo("\n".join([title, *plain_table(columns, rows)]))


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
