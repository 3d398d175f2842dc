"""``fiv show``: what is in a dataset."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from fiv_cli.cli.common import at_option, json_option, parse_selection, print_json
from fiv_cli.errors import UsageError, printable
from fiv_cli.files import refuse_special, write_whole
from fiv_cli.notation.names import pick

if TYPE_CHECKING:
    import xarray as xr


@click.command("show")
@click.argument("file", type=click.Path(path_type=Path), metavar="FILE.nc")
@at_option(
    "Only the points there: values, conditions ('. >= 7'), initial=LABEL, "
    "'initial=[ONE,OTHER]'. Repeatable."
)
@click.option("--analysis", "chosen", metavar="NAME", help="Only this one of several analyses.")
@click.option(
    "--csv",
    "columns",
    metavar="NAME,...",
    help="Print variables as a table instead: a row for each value, its point beside it, in SI; "
    "'NAME[x]' is the column of one state or contact, 'NAME[*]' one of each; 'shares' are those of "
    "random starts, with their standard errors, or of a lattice, without. What has an error of its "
    "own has it beside it. Here --at takes "
    "classes, too.",
)
@click.option(
    "-o", "--output", type=click.Path(path_type=Path), metavar="FILE.csv", help="Where --csv goes."
)
@json_option
def command(
    file: Path,
    places: tuple[str, ...],
    chosen: str | None,
    columns: str | None,
    output: Path | None,
    as_json: bool,
) -> None:
    """Summarise the dataset FILE.nc.

    Says what was computed, how many points of each status and class there are, where starts end
    differently (hysteresis, bistable ranges), the range of every variable, each answer with its
    error where points are few, and the worst value of each measure of trust with the point where it
    occurs. `fiv variables CASE` says what a variable is.

    \b
    Examples:
      fiv new pin-on-disc > a.toml && fiv run a.toml && fiv show runs/a.nc
      fiv show runs/a.nc --at "Omega=. >= 5"
      fiv show runs/a.nc --csv attractor,L_s -o a.csv
      fiv show runs/a.nc --csv 'attractor,initial_state[*]' --at attractor=undecided
      fiv show runs/a.nc --json
    """
    from fiv_cli.reading.changed import changed_since
    from fiv_cli.reading.datasets import read_analyses
    from fiv_cli.reading.select import part_of_each
    from fiv_cli.reading.summary import lines, summarise

    analyses, at = read_analyses(file), parse_selection(places)
    kinds = {name: dict.fromkeys(values) for name, values in at.items()}
    several = [f"{name} = {', '.join(values)}" for name, values in kinds.items() if len(values) > 1]
    if len(several) > 1 and len(places) > 1:
        click.echo(f"--at: every combination of {' and '.join(several)}", err=True)
        click.echo("next: of single points, a command for each", err=True)
    if changed := changed_since(next(iter(analyses.values())).attrs, file, drawn=False):
        click.echo(f"WARNING: {file} is shown as it was run; {changed}", err=True)
    if chosen is not None and [*analyses] != [""]:
        following = f"fiv show {file}"
        analyses = {chosen: pick(chosen, analyses, "analysis", following)}
    if columns is not None and as_json:
        raise UsageError(
            "--csv and --json: one of them\nnext: --csv NAME,... -o FILE.csv, or --json"
        )
    if columns is not None:
        told, remark = _table(analyses, columns, at)
        if remark:
            click.echo(remark, err=True)
        if output is None:
            click.echo(told, nl=False)
        else:
            refuse_special(output)
            write_whole(output, told.encode(), durable=False)
            click.echo(output)
        return
    if output is not None:
        raise UsageError("-o: of what?\nnext: name variables, --csv attractor,L_s -o FILE.csv")
    summary = summarise(part_of_each(analyses, at))
    if as_json:
        print_json(summary)
    else:
        click.echo(printable("\n".join(lines(summary))))


def _table(
    analyses: Mapping[str, xr.Dataset], columns: str, at: Mapping[str, Any]
) -> tuple[str, str]:
    """The table that is asked for, and what it leaves out."""
    from fiv_cli.reading import shares
    from fiv_cli.reading.select import part_of_each
    from fiv_cli.reading.table import as_csv, without_row

    names = [name.strip() for name in columns.split(",")]
    reaching = {name: one for name, one in analyses.items() if "attractor" in one}
    if names == ["shares"] and len(reaching) == 1:
        (part,) = part_of_each(reaching, at).values()
        return shares.as_csv(part), shares.without_error(part)
    return as_csv(analyses, names, at), without_row(analyses, names, at)
