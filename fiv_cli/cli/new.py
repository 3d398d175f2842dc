"""``fiv new``: a case file to start from."""

from __future__ import annotations

import click

from fiv_cli.errors import UsageError


@click.command("new")
@click.argument("model")
@click.option(
    "--analysis",
    "kind",
    metavar="KIND",
    default="response",
    show_default=True,
    help="What to compute: history, equilibrium, eigenvalues, response, ...",
)
def command(model: str, kind: str) -> None:
    """Write a commented case file of MODEL to stdout.

    It is valid as it stands; everything that may be changed is in it, behind a #.

    \b
    Example:
      fiv new pin-on-disc --analysis response > a.toml
    """
    from fiv_cli.analyses import all_analyses
    from fiv_cli.case.template import case_template
    from fiv_cli.models import all_models
    from fiv_cli.notation.names import pick

    analyses = all_analyses()
    chosen = pick(model, all_models(), "model", "fiv models")
    analysis = pick(kind, analyses, "analysis", f"fiv new {model} --analysis KIND")
    unsuited = analysis.unsuited(chosen)
    if unsuited:
        suited = [name for name, one in analyses.items() if not one.unsuited(chosen)]
        raise UsageError(f"{unsuited}\nnext: fiv new {model} --analysis {suited[0]}")
    click.echo(case_template(chosen, analysis), nl=False)
