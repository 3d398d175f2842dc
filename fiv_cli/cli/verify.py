"""``fiv verify``: closed-form answers on the installed build."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import click

from fiv_cli.cli.common import (
    json_option,
    named_files,
    plain,
    print_json,
    print_table,
    provide_cache,
    with_option,
)
from fiv_cli.cli.reports import Verdict, report, report_options

if TYPE_CHECKING:
    from fiv_cli.verify import Check

DIFFERENCE = 5
COLUMNS = ("what", "found", "expected", "error", "tolerance", "verdict")


@click.command("verify")
@json_option
@report_options
@with_option
def command(as_json: bool, junit: Path | None, summary: Path | None) -> int:
    """Check this installation against answers that are known without it.

    Computes stick-slip cycles, forced responses, equilibria, eigenvalues and energy balances whose
    closed forms or published values are known, and prints the error of each beside its tolerance.
    Exit code 5 when any is outside.

    With --with the models and laws of files are checked instead, each model under its own law and
    under those of the files: energy balance, derivatives against differences, two ways of
    integrating, and what a function verify(bench) of a file says.

    \b
    Examples:
      fiv verify
      fiv verify --json
      fiv verify --junit verify.xml
      fiv new-model my-belt > my_belt.py && fiv verify --with my_belt.py
    """
    provide_cache()
    checks = _checks(lambda message: click.echo(message, err=True))
    failed = [check for check in checks if not check.passed]
    if as_json:
        print_json({"passed": not failed, "checks": [_document(check) for check in checks]})
    else:
        _print(checks)
    report("fiv verify", [_verdict(check) for check in checks], junit, summary)
    click.echo(f"{len(checks) - len(failed)} of {len(checks)} checks passed", err=True)
    return DIFFERENCE if failed else 0


def _checks(announce: Callable[[str], None]) -> list[Check]:
    """Of the installation; or of what --with has named."""
    if named_files():
        from fiv_cli.trial import try_own

        return try_own(announce)
    from fiv_cli.verify import verify

    return verify(announce)


def _verdict(check: Check) -> Verdict:
    found = f"{check.found:.12g}, expected {check.expected:.12g}, error {check.error:.1e}"
    return Verdict(check.source, check.name, found, check.passed)


def _document(check: Check) -> dict[str, object]:
    return {**plain(check), "error": check.error, "passed": check.passed}


def _print(checks: Sequence[Check]) -> None:
    """One table for each source."""
    for source in dict.fromkeys(check.source for check in checks):
        rows = [_row(check) for check in checks if check.source == source]
        print_table(source, COLUMNS, rows)
        click.echo()


def _row(check: Check) -> tuple[str, ...]:
    return (
        check.name,
        f"{check.found:.12g}",
        f"{check.expected:.12g}",
        f"{check.error:.1e}",
        f"{check.tolerance:.1e}",
        "ok" if check.passed else "FAILED",
    )
