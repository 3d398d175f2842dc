"""``fiv new-law``: a file of a friction law to start from."""

from __future__ import annotations

import click


@click.command("new-law")
@click.argument("name")
def command(name: str) -> None:
    """Write a commented file of a friction law called NAME to stdout.

    \b
    Examples:
      fiv new-law my-law > my_law.py
      fiv plot --law my-law --with my_law.py -o my_law.png
      fiv run a.toml --with my_law.py --set friction.law=my-law
    """
    from fiv_cli.own.template import law_template

    click.echo(law_template(name), nl=False)
