"""``fiv kinds``: the kinds of analyses, starts, figures and claims, and their settings."""

from __future__ import annotations

from typing import TYPE_CHECKING

import click

from fiv_cli.cli.common import json_option, print_json, print_table
from fiv_cli.errors import UsageError
from fiv_cli.notation.names import pick

if TYPE_CHECKING:
    from collections.abc import Sequence

    from fiv_cli.case.kinds import Key, Kind

# Table of a case -> what `fiv kinds` calls its kinds.
TITLES = {
    "analysis": 'Analyses: [[analysis]] kind = "NAME"',
    "initial": 'Starts: [[initial]] kind = "NAME"',
    "schedule": "In time: [schedule] PARAMETER = { KEY = ..., ... }",
    "forcing": "Forces: [forcing] NAME = { KEY = ..., ... }",
    "figure": 'Figures: [[figure]] kind = "NAME"',
    "claim.take": 'Taken of many values, by claims and figures: take = { what = "NAME", ... }',
    "claim.expect": "What a [[claim]] expects: expect = ...",
}

ELSEWHERE = "fiv kinds; models and laws: fiv models, fiv models --laws"


@click.command("kinds")
@click.argument("name", required=False)
@json_option
def command(name: str | None, as_json: bool) -> None:
    """List the kinds of analyses, starts, figures and claims, or all settings of the kind NAME.

    NAME may also be a table of a case, such as grid, friction, schedule or claim. Then its keys
    are listed, with an example of what is not plain. `fiv variables CASE` lists what an analysis
    gives, which figures draw and claims speak of.

    \b
    Examples:
      fiv kinds              # what there is
      fiv kinds response     # settings of the steady-state analysis
      fiv kinds continue     # ... of a start where the neighbour's motion ended
      fiv kinds grid         # axes: values, units, a state of the start
      fiv kinds friction     # one law, several, measured friction
      fiv kinds refine       # more points along the borders of a map only
      fiv kinds claim        # what figures and claims can say, on one page
    """
    from fiv_cli.case.kinds import TABLES, all_kinds, keys_in

    kinds = all_kinds()
    if name is not None:
        _refuse_unknown(name, kinds)
        text, form = TABLES.get(name, ("", None))
        found, keys = [kind for kind in kinds if kind.name == name], keys_in(form) if form else ()
        if as_json:
            print_json({"kinds": found, "keys": keys})
        else:
            click.echo(f"{text}\n" if text else "", nl=False)
            _print_one(found, keys)
            of = {"analysis": name, "take": "claim.take", "claim": "claim.expect"}
            _print_table(kinds, of.get(name))
    elif as_json:
        print_json({"kinds": kinds})
    else:
        _print_all(kinds)


def _refuse_unknown(name: str, kinds: Sequence[Kind]) -> None:
    """Say what a word of the field is called here, or what resembles it.

    Raises
    ------
    UsageError
        there is no kind of this name.
    """
    from fiv_cli.case.kinds import TABLES
    from fiv_cli.case.words import meant

    known = {**dict.fromkeys(TABLES, ""), **{k.name: k.meaning for k in reversed(kinds) if k.keys}}
    found = [] if name in known else meant(name)
    if found:
        told = "\n".join(f"  fiv kinds {one}: {known[one]}".rstrip(": ") for one in found)
        raise UsageError(f"there is no kind {name!r}; here it is\n{told}")
    homes = dict.fromkeys(kind.name for kind in kinds if name in {key.name for key in kind.keys})
    if name not in known and homes:
        asking = ", ".join(f"fiv kinds {home}" for home in homes)
        raise UsageError(f"there is no kind {name!r}; it is a setting: {asking}")
    pick(name, dict.fromkeys(known), "kind", ELSEWHERE)


def _print_all(kinds: Sequence[Kind]) -> None:
    from fiv_cli.case.kinds import TABLES

    for table in TITLES:
        _print_table(kinds, table)
    click.echo(
        f"fiv kinds NAME: its settings. NAME is also a table of a case:\n{', '.join(TABLES)}"
    )


def _print_table(kinds: Sequence[Kind], table: str | None) -> None:
    """What may stand in a table of a case."""
    rows = [(kind.name, kind.meaning) for kind in kinds if kind.table == table]
    if table is not None:
        print_table(TITLES[table], ("name", "what it is"), rows)
        click.echo()


def _print_one(kinds: Sequence[Kind], keys: Sequence[Key]) -> None:
    for kind in kinds:
        title = f"{TITLES[kind.table].replace('NAME', kind.name)}: {kind.meaning}"
        _print_keys(f"{title}\n{kind.answer}".rstrip(), kind.keys)
    if keys:
        _print_keys("Every key of the table", keys)


def _print_keys(title: str, keys: Sequence[Key]) -> None:
    rows = [(key.name, key.default, key.meaning) for key in keys]
    print_table(title, ("key", "default", "what it means"), rows)
    click.echo()
