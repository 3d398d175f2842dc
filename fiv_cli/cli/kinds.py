"""``fiv kinds``: the kinds of analyses, starts, figures and claims, and their settings."""

from __future__ import annotations

from typing import TYPE_CHECKING

import click

from fiv_cli.cli.common import json_option, print_json, print_table
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

ELSEWHERE = (
    "fiv kinds; what stands under [model], [grid] and [friction]: fiv models NAME, "
    "fiv models --laws, and README.md"
)


@click.command("kinds")
@click.argument("name", required=False)
@json_option
def command(name: str | None, as_json: bool) -> None:
    """List the kinds of analyses, starts, figures and claims, or all settings of the kind NAME.

    NAME may also be a table of the case, initial, figure, claim or take: then all of its keys are
    listed; of claim also how claims and figures say which points, what is taken and expected.
    What an analysis gives, and figures and claims speak of, lists `fiv variables`.

    \b
    Examples:
      fiv kinds
      fiv kinds response
      fiv kinds continue
      fiv kinds claim
    """
    from fiv_cli.case.kinds import CLAIMS, all_kinds

    kinds, tables = all_kinds(), _tables()
    if name is not None:
        known = [kind.name for kind in kinds if kind.keys]
        pick(name, dict.fromkeys([*tables, *known]), "kind", ELSEWHERE)
        found, keys = [kind for kind in kinds if kind.name == name], tables.get(name, ())
        if as_json:
            print_json({"kinds": found, "keys": keys})
        else:
            click.echo(CLAIMS if name == "claim" else "", nl=name == "claim")
            _print_one(found, keys)
            _print_table(kinds, {"take": "claim.take", "claim": "claim.expect"}.get(name))
    elif as_json:
        print_json({"kinds": kinds})
    else:
        _print_all(kinds)


def _tables() -> dict[str, Sequence[Key]]:
    """The tables of a case that hold kinds -> all their keys."""
    from fiv_cli.case import structure
    from fiv_cli.case.kinds import keys_in

    return {
        "initial": keys_in(structure.InitialTable),
        "figure": keys_in(structure.FigureTable),
        "claim": keys_in(structure.ClaimTable),
        "take": keys_in(structure.TakeTable),
    }


def _print_all(kinds: Sequence[Kind]) -> None:
    for table in TITLES:
        _print_table(kinds, table)
    click.echo("fiv kinds NAME: its settings; fiv kinds claim: how claims and figures say it")


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
