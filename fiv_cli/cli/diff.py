"""``fiv diff``: do two datasets agree."""

from __future__ import annotations

from pathlib import Path

import click

from fiv_cli.cli.common import json_option, print_json
from fiv_cli.errors import printable

DIFFERENT = 5


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

    Status and class are compared exactly; numbers where both sides are equilibrium or periodic
    (relative 1e-6 unless --tolerances says otherwise); quasi-periodic and chaotic motions by L_s
    and shares of time only.

    \b
    Examples:
      fiv new pin-on-disc > a.toml && fiv run a.toml
      fiv run a.toml --set model.parameters.N0=20 -o lighter.nc
      fiv diff runs/a.nc lighter.nc
      fiv diff runs/a.nc lighter.nc --tolerances sweeps/pin-reached/tolerances.toml
    """
    from fiv_cli.reading.causes import causes
    from fiv_cli.reading.compare import Tolerances, compare, read_tolerances
    from fiv_cli.reading.datasets import read_analyses

    chosen = Tolerances() if tolerances is None else read_tolerances(tolerances)
    left, right = read_analyses(first), read_analyses(second)
    found = compare(left, right, chosen)
    behind = causes(*(next(iter(side.values())).attrs for side in (left, right)))
    if as_json:
        print_json({"equal": not found, "causes": behind, "differences": found})
    else:
        for cause in behind:
            click.echo(printable(f"computed with another {cause}"))
        for one in found:
            count = f" ({one.count})" if one.count > 1 else ""
            click.echo(printable(f"{one.what}: {one.text}{count}"))
        if not found:
            click.echo(f"{first} and {second} agree")
    return DIFFERENT if found else 0
