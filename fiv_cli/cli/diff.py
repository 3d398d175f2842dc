"""``fiv diff``: do two datasets agree."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from fiv_cli.cli.common import json_option, print_json, print_table
from fiv_cli.errors import printable

if TYPE_CHECKING:
    from fiv_cli.reading.compare import Change, Difference, Tolerances

DIFFERENT = 5


SHOWN = 6


@click.command("diff")
@click.argument("first", type=click.Path(path_type=Path), metavar="A.nc")
@click.argument("second", type=click.Path(path_type=Path), metavar="B.nc")
@click.option(
    "--tolerances",
    type=click.Path(path_type=Path),
    help="TOML file with [default], [sampled], [variables.NAME] (rtol, atol) and ignore = [...].",
)
@json_option
def command(first: Path, second: Path, tolerances: Path | None, as_json: bool) -> int:
    """Compare two datasets; the exit code is 5 when they differ.

    First it says what they were computed from, where it differs: parameters, settings, versions,
    files of your own.

    Then how many points have come from which class into which; then, of numbers, the worst where
    both are of the same class, equilibrium or periodic (relative 1e-6 unless --tolerances says
    otherwise); quasi-periodic and chaotic motions are compared by L_s, mean powers and shares of
    time only, to 10 % ([sampled]) or, without --tolerances, four of their standard errors. Of what
    a refined map filled in the class alone is compared.

    \b
    Examples:
      fiv new pin-on-disc > a.toml && fiv run a.toml
      fiv run a.toml --set model.parameters.N0=20 -o lighter.nc
      fiv diff runs/a.nc lighter.nc
      fiv diff runs/a.nc lighter.nc --tolerances sweeps/pin-reached/tolerances.toml
    """
    from fiv_cli.reading.causes import causes
    from fiv_cli.reading.compare import (
        Tolerances,
        compare,
        count_filled,
        has_sampled,
        read_tolerances,
    )
    from fiv_cli.reading.datasets import read_analyses

    chosen = Tolerances() if tolerances is None else read_tolerances(tolerances)
    left, right = read_analyses(first), read_analyses(second)
    found = compare(left, right, chosen)
    heads = [next(iter(side.values())) for side in (left, right)]
    axes = {str(name) for head in heads for name, coord in head.coords.items() if coord.ndim}
    of_class_alone = count_filled(left, right)
    behind = causes(heads[0].attrs, heads[1].attrs, axes)
    if as_json:
        tolerances_used = {name: vars(getattr(chosen, name)) for name in ("default", "sampled")}
        told = {"equal": not found, "within": tolerances_used}
        told |= {"of_class_alone": of_class_alone}
        print_json(told | {"causes": behind, "differences": found})
    else:
        if of_class_alone:
            click.echo(
                f"{of_class_alone} points were filled in: of these the class alone is compared"
            )
        for cause in behind:
            click.echo(printable(f"computed with another {cause}"))
        for one in found:
            _print(one)
        if not found:
            wide = _sampled(chosen) if has_sampled(left) else ""
            within = f"numbers within a relative {chosen.default.rtol:g}{wide}"
            click.echo(f"{first} and {second} agree ({within}; what tells trust is left out)")
    return DIFFERENT if found else 0


def _sampled(chosen: Tolerances) -> str:
    """How closely motions that do not repeat are compared."""
    by_chance = " or four standard errors" if chosen.standard_errors else ""
    return (
        "; of quasi-periodic and chaotic motions L_s, mean powers and shares of time alone, within "
        f"{chosen.sampled.rtol:.0%}{by_chance}, shares within {chosen.sampled.atol:g} "
        "more"
    )


def _print(difference: Difference) -> None:
    if difference.changes:
        title = f"{difference.what}: {difference.count} of another class"
        rows = [(c.first, c.second, str(c.count), _places(c)) for c in difference.changes]
        print_table(title, ("from", "to", "how many", "where"), rows)
    else:
        count = f" (worst of {difference.count})" if difference.count > 1 else ""
        click.echo(printable(f"{difference.what}: {difference.text}{count}"))


def _places(change: Change) -> str:
    """The first; `--json` has up to a hundred."""
    more = f"; {len(change.places) - SHOWN} more" if len(change.places) > SHOWN else ""
    return printable("; ".join(change.places[:SHOWN]) + more)
