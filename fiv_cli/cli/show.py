"""``fiv show``: what is in a dataset."""

from __future__ import annotations

import json
from pathlib import Path

import click


@click.command("show")
@click.argument("file", type=click.Path(path_type=Path), metavar="FILE.nc")
@click.option("--json", "as_json", is_flag=True, help="Print the summary as JSON.")
def command(file: Path, as_json: bool) -> None:
    """Summarise the dataset FILE.nc.

    Says what was computed, how many points of each status and class there are, the range of
    every variable, and the worst value of each measure of trust with the point where it occurs.

    \b
    Example:
      fiv show runs/fig_7_06.nc
    """
    from fiv_cli.data.reading import read_analyses
    from fiv_cli.data.summary import lines, summarise

    summary = summarise(read_analyses(file))
    click.echo(json.dumps(summary, indent=2) if as_json else "\n".join(lines(summary)))
