"""``fiv variables``: what the analyses of a case give."""

from __future__ import annotations

from typing import TYPE_CHECKING

import click

from fiv_cli.cli.common import json_option, print_json, print_table, set_option, with_option

if TYPE_CHECKING:
    from collections.abc import Sequence

    from fiv_cli.analyses.variables import Variable


MOST_WORDS = 12  # classes of a variable that are listed in a table


@click.command("variables")
@click.argument("case")
@set_option
@with_option
@json_option
def command(case: str, overrides: tuple[str, ...], as_json: bool) -> None:
    """List the variables that the analyses of CASE give: dims, unit and meaning of each.

    These are the names that a [[figure]] draws and a [[claim]] speaks of. The dims of the grid
    come first, then `initial` where the analysis has starts, then those of the variable itself.

    \b
    Examples:
      fiv new pin-on-disc > a.toml && fiv variables a.toml
      fiv variables configs/ch7/fig_7_06_reached.toml --json
    """
    from fiv_cli import api
    from fiv_cli.analyses.variables import derived

    # who asks may have just been told that a figure or a claim names a variable that there is not
    loaded = api.load(case, (*overrides, "figure=[]", "claim=[]"))
    layouts = [analysis.layout for analysis in api.check(loaded).analyses]
    if as_json:
        given = {one.name: [*one.variables, *derived(one.variables)] for one in layouts}
        told = {
            n: [_described(v) | {"stored": not v.derived} for v in of] for n, of in given.items()
        }
        print_json({"analyses": told})
        return
    for one in layouts:
        _print(f"{one.name}: over {', '.join(one.dim_names) or 'one point'}", one.variables)
        _print(f"{one.name}: made of these by fiv (api.read), in no file", derived(one.variables))


def _print(title: str, variables: Sequence[Variable]) -> None:
    rows = [tuple(_described(variable, MOST_WORDS).values()) for variable in variables]
    if rows:
        print_table(title, ("name", "own dims", "unit", "what it is"), rows)
        click.echo()


def _described(variable: Variable, most: int | None = None) -> dict[str, str]:
    """A variable in words, of its classes no more than `most`."""
    from fiv_cli.flags import TABLES

    own = variable.sample_dim if variable.ragged else variable.along
    classes = TABLES[variable.flags].codes if variable.flags else ()
    few = most is None or len(classes) <= most
    words = " | ".join(classes) if few else f"{len(classes)} words, which --json lists"
    meaning = [variable.long_name, words, variable.comment]
    return {
        "name": variable.name,
        "dims": own,
        "unit": variable.units,
        "meaning": "; ".join(part for part in meaning if part),
    }
