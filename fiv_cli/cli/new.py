"""``fiv new``: a case file to start from."""

from __future__ import annotations

from pathlib import Path

import click

from fiv_cli.cli.common import hand_out, output_option, with_option
from fiv_cli.errors import UsageError


@click.command("new")
@click.argument("model")
@click.option(
    "--analysis",
    "kind",
    metavar="KIND",
    default="response",
    show_default=True,
    help="What to compute; `fiv kinds` lists the analyses.",
)
@output_option
@with_option
def command(model: str, kind: str, output: Path | None) -> None:
    """Write a commented case file of MODEL to stdout, or to a new file.

    It is valid as it stands, and in a response the model vibrates somewhere on its grid. All that
    may be changed is there as a comment: take the # off its line, and off the lines that are
    indented below it.

    \b
    Examples:
      fiv new pin-on-disc > a.toml && fiv run a.toml && fiv plot runs/a.nc
      fiv new flutter-2dof --analysis critical -o b.toml    # then: fiv check b.toml
    """
    from fiv_cli.analyses import all_analyses
    from fiv_cli.case.template import case_template
    from fiv_cli.models import all_models
    from fiv_cli.notation.names import pick
    from fiv_cli.own.load import following, seek

    seek(model)
    analyses = all_analyses()
    chosen = pick(model, all_models(), "model", following("new", model, "fiv models"))
    analysis = pick(kind, analyses, "analysis", "fiv kinds")
    unsuited = analysis.unsuited(chosen)
    if unsuited:
        suited = [name for name, one in analyses.items() if not one.unsuited(chosen)]
        raise UsageError(f"{unsuited}\nnext: fiv new {model} --analysis {suited[0]}")
    hand_out(case_template(chosen, analysis), output)
