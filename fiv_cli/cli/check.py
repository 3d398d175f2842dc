"""``fiv check``: is a case right, and what would a run do."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import click

from fiv_cli.cli.common import json_option, print_json, set_option
from fiv_cli.errors import CaseError, FivError, printable


@dataclass(frozen=True)
class Verdict:
    """What came of checking one case: the lines of its plan, or the error."""

    source: str
    plan: tuple[str, ...] = ()
    error: FivError | None = None

    @property
    def exit_code(self) -> int:
        """0 when the case is right."""
        return 0 if self.error is None else self.error.exit_code


@click.command("check")
@click.argument("cases", nargs=-1, required=True, metavar="CASE...")
@set_option
@json_option
def command(cases: tuple[str, ...], overrides: tuple[str, ...], as_json: bool) -> int:
    """Check case files and print what `fiv run` would do with them.

    Mistakes are listed in three looks at most, first all of the form, then all unknown names, then
    all wrong values, each with its line, what is allowed and what may have been meant. Nothing is
    computed. The exit code is 3 when a case is invalid.

    \b
    Examples:
      fiv check configs/ch7/*.toml
      fiv check a.toml --set grid.mu_k=[0.3] --set 'model.parameters.N0="30 N"'
    """
    verdicts = [check_case(source, overrides) for source in cases]
    if as_json:
        print_json({"cases": [_document(verdict) for verdict in verdicts]})
    else:
        _print(verdicts)
    return max(verdict.exit_code for verdict in verdicts)


def check_case(source: str, overrides: Sequence[str]) -> Verdict:
    """Read one case and plan it; an error becomes part of the verdict."""
    from fiv_cli import api

    try:
        plan = api.check(api.load(source, overrides))
    except FivError as error:
        return Verdict(source, error=error)
    return Verdict(source, plan=tuple(plan.describe()))


def _print(verdicts: Iterable[Verdict]) -> None:
    for verdict in verdicts:
        if verdict.error is None:
            click.echo(printable("\n".join(verdict.plan)))
        else:
            click.echo(str(verdict.error), err=True)


def _document(verdict: Verdict) -> dict[str, object]:
    problems = verdict.error.problems if isinstance(verdict.error, CaseError) else ()
    return {
        "case": verdict.source,
        "valid": verdict.error is None,
        "plan": verdict.plan,
        "error": None if verdict.error is None else str(verdict.error).splitlines()[0],
        "problems": problems,
    }
