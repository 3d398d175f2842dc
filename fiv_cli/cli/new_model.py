"""``fiv new-model``: a file of a model to start from."""

from __future__ import annotations

from pathlib import Path

import click

from fiv_cli.cli.common import hand_out, output_option


@click.command("new-model")
@click.argument("name")
@output_option
def command(name: str, output: Path | None) -> None:
    """Write a commented file of a model called NAME to stdout, or to a new file: a mass on a
    belt, to be changed.

    It runs as it stands. What you write is checked as what is in the box: names, units, that the
    energies fit the accelerations, that friction opposes slip. `fiv verify --with FILE.py` adds
    derivatives against differences, the energy of a motion, two ways of integrating, and what the
    function verify(bench) in the file knows.

    \b
    Examples:
      fiv new-model my-belt > my_belt.py
      fiv verify --with my_belt.py
      fiv new my-belt --with my_belt.py > b.toml && fiv run b.toml --with my_belt.py
    """
    from fiv_cli.own.template import model_template

    hand_out(model_template(name), output)
