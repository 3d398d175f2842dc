"""``fiv check``: is a case right, and what would a run do."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass, field
from typing import TYPE_CHECKING

import click

from fiv_cli.cli.common import (
    given_files,
    json_option,
    print_json,
    provide_cache,
    set_option,
    with_files,
    with_option,
)
from fiv_cli.errors import CaseError, FivError, printable

if TYPE_CHECKING:
    from fiv_cli.case.case import Case
    from fiv_cli.sweep.estimate import Estimate
    from fiv_cli.sweep.plan import Plan


@dataclass(frozen=True)
class Verdict:
    """What came of checking one case: its plan, what is to know of a run, or the error."""

    source: str
    plan: tuple[str, ...] = ()
    defaults: Mapping[str, float | str] = field(default_factory=dict)
    stiff: tuple[str, ...] = ()
    not_run: tuple[str, ...] = ()
    held_otherwise: tuple[str, ...] = ()
    estimates: tuple[Estimate, ...] = ()
    error: FivError | None = None

    @property
    def exit_code(self) -> int:
        """0 when the case is right."""
        return 0 if self.error is None else self.error.exit_code


@click.command("check")
@click.argument("cases", nargs=-1, required=True, metavar="CASE...")
@set_option
@with_option
@json_option
@click.option("--estimate", is_flag=True, help="Run a sample to say what a run will cost.")
@click.option(
    "--workers",
    type=click.IntRange(min=1),
    default=2,
    show_default=True,
    help="Workers that the estimate is for.",
)
def command(
    cases: tuple[str, ...],
    overrides: tuple[str, ...],
    as_json: bool,
    estimate: bool,
    workers: int,
) -> int:
    """Check case files and print what `fiv run` would do with them.

    Prints the grid, the analyses with their numbers of points, defaults (of the law, the preload,
    the speed and the like; --json: all), and a friction law that will cost more than 100 times the
    steps of Coulomb's. Mistakes are listed in three rounds at most, first those of form, then
    unknown names and wrong values, then what does not fit together, each with its line, what is
    allowed and what may have been meant; the exit code is then 3.
    Nothing is computed, unless --estimate asks for time, memory and disk: it runs a sample for up
    to some twenty seconds an analysis, gives a point up that takes more than 2.5 s of these, and
    keeps nothing of it.

    \b
    Examples:
      fiv new pin-on-disc > a.toml && fiv check a.toml    # then: fiv run a.toml
      fiv check configs/ch7/*.toml
      fiv check a.toml --estimate --workers 4
      fiv check a.toml --set grid.mu_k=[0.3] --set 'model.parameters.N0="30 N"'
    """
    on = workers if estimate else 0
    verdicts = [check_case(source, overrides, on) for source in cases]
    if as_json:
        print_json({"cases": [_document(verdict) for verdict in verdicts]})
    else:
        _print(verdicts)
    return max(verdict.exit_code for verdict in verdicts)


def check_case(source: str, overrides: Sequence[str], workers: int = 0) -> Verdict:
    """Read one case, plan it, and estimate its run on `workers`; an error is in the verdict."""
    from fiv_cli import api
    from fiv_cli.case.others import held_otherwise, not_run

    try:
        case = api.load(source, overrides)
        plan = api.check(case)
        estimates = tuple(_estimates(case, workers)) if workers else ()
        lines = tuple(plan.describe(is_estimated=bool(estimates)))
        told = lines, plan.defaults(), _stiff(plan), (*not_run(case),), (*held_otherwise(case),)
        return Verdict(source, *told, estimates)
    except FivError as error:
        return Verdict(source, error=error)


def _stiff(plan: Plan) -> tuple[str, ...]:
    from fiv_cli.sweep.stiff import stiff_laws

    provide_cache()
    return tuple(stiff_laws(plan.analyses, lambda sentence: click.echo(sentence, err=True)))


def _estimates(case: Case, workers: int) -> Iterator[Estimate]:
    from fiv_cli.sweep.estimate import estimate

    provide_cache()
    return estimate(case, workers, lambda sentence: click.echo(sentence, err=True))


def _print(verdicts: Iterable[Verdict]) -> None:
    for verdict in verdicts:
        if verdict.error is None:
            others = (*verdict.not_run, *verdict.held_otherwise)
            more = (f"  {sentence}" for sentence in (*verdict.stiff, *others))
            costs = (line for one in verdict.estimates for line in (one.line(), *one.failures()))
            lines = [*verdict.plan, *more, *costs]
            click.echo(printable("\n".join(lines)))
        else:
            click.echo(with_files(str(verdict.error), given_files()), err=True)


def _document(verdict: Verdict) -> dict[str, object]:
    problems = verdict.error.problems if isinstance(verdict.error, CaseError) else ()
    return {
        "case": verdict.source,
        "valid": verdict.error is None,
        "plan": verdict.plan,
        "defaults": verdict.defaults,
        "stiff": verdict.stiff,
        "not_run": verdict.not_run,
        "held_otherwise": verdict.held_otherwise,
        "estimates": [asdict(one) for one in verdict.estimates],
        "error": None if verdict.error is None else str(verdict.error).splitlines()[0],
        "problems": problems,
    }
