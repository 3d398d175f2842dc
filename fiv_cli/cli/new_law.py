"""``fiv new-law``: a file of a friction law to start from."""

from __future__ import annotations

from pathlib import Path

import click

from fiv_cli.cli.common import hand_out, output_option


@click.command("new-law")
@click.argument("name")
@output_option
def command(name: str, output: Path | None) -> None:
    """Write a commented file of a friction law called NAME to stdout, or to a new file.

    It works as it stands. What you write is checked as what is in the box; `fiv verify --with
    FILE.py` checks it in motion.

    \b
    Examples:
      fiv new-law my-law > my_law.py
      fiv plot --law my-law --with my_law.py -o my_law.png
      fiv new pin-on-disc > a.toml
      fiv run a.toml -o own.nc --with my_law.py --set friction.law=my-law
    """
    from fiv_cli.own.template import law_template

    hand_out(law_template(name), output)
