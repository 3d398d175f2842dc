"""``fiv new-model``: a file of a model to start from."""

from __future__ import annotations

import click


@click.command("new-model")
@click.argument("name")
def command(name: str) -> None:
    """Write a commented file of a model called NAME to stdout: a mass on a belt, to be changed.

    It runs as it stands, and has a test of its own, which `fiv verify --with FILE.py` runs.

    \b
    Examples:
      fiv new-model my-belt > my_belt.py
      fiv verify --with my_belt.py
      fiv new my-belt --with my_belt.py > a.toml && fiv run a.toml --with my_belt.py
    """
    from fiv_cli.own.template import model_template

    click.echo(model_template(name), nl=False)
