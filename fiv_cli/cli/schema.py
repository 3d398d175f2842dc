"""``fiv schema``: the JSON schema of case files."""

from __future__ import annotations

import json

import click

from fiv_cli.cli.common import with_option


@click.command("schema")
@with_option
def command() -> None:
    """Print the JSON schema of case files, which editors complete and check from.

    \b
    Example, for any editor with a TOML language server (taplo, Even Better TOML):
      fiv schema > fiv.schema.json
    and as the first line of a case file:
      #:schema ./fiv.schema.json
    """
    from fiv_cli.case.schema import case_schema

    click.echo(json.dumps(case_schema(), indent=2, ensure_ascii=False))
