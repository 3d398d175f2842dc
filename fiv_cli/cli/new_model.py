"""``fiv new-model``: a file of a model to start from."""

from __future__ import annotations

import click


@click.command("new-model")
@click.argument("name")
def command(name: str) -> None:
    """Write a commented file of a model called NAME to stdout: a mass on a belt, to be changed.

    It runs as it stands. What you write is checked as what is in the box: names, units, that the
    energies fit the accelerations, that friction opposes slip. `fiv verify --with FILE.py` adds
    derivatives against differences, the energy of a motion, two ways of integrating, and what the
    function verify(bench) in the file knows.

    \b
    Examples:
      fiv new-model my-belt > my_belt.py
      fiv verify --with my_belt.py
      fiv new my-belt --with my_belt.py > a.toml && fiv run a.toml --with my_belt.py
    """
    from fiv_cli.own.template import model_template

    click.echo(model_template(name), nl=False)
