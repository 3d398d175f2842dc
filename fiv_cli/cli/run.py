"""``fiv run``: case files in, datasets out."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import click

from fiv_cli import ending
from fiv_cli.cli.common import (
    STILL_TO_RUN,
    UNSOUND,
    PartType,
    provide_cache,
    set_option,
    with_option,
)
from fiv_cli.errors import CaseError, FivError, InputError, UsageError

if TYPE_CHECKING:
    from fiv_cli.case.case import Case
    from fiv_cli.sweep.parts import Part
    from fiv_cli.sweep.policy import Policy
    from fiv_cli.sweep.progress import Progress
    from fiv_cli.sweep.run import Summary


@click.command("run")
@click.argument("cases", nargs=-1, required=True, metavar="CASE...")
@click.option(
    "-o",
    "--output",
    type=click.Path(path_type=Path),
    help="Dataset to write. Default: runs/STEM.nc; with --set, runs/STEM-DIGEST.nc.",
)
@set_option
@with_option
@click.option(
    "--workers",
    type=click.IntRange(min=1),
    default=2,
    show_default=True,
    help="Worker processes; 1: compute in this process.",
)
@click.option(
    "--cluster",
    metavar="ADDRESS or FILE",
    default="",
    help="Compute on the workers of this dask scheduler: tcp://HOST:PORT, or its scheduler file.",
)
@click.option(
    "--shard",
    "part",
    type=PartType(),
    help="Run part I of N of the points, in any order and anywhere; fiv assemble joins them.",
)
@click.option(
    "--resume/--fresh",
    default=True,
    help="Keep what is stored and run the rest (default), or throw it away.",
)
@click.option(
    "--keep-going/--fail-fast",
    default=True,
    help="Go on after a failed point (default), or stop.",
)
@click.option(
    "--max-points",
    type=click.IntRange(min=0),
    help="Run at most so many points now; exit code 8 where others are left and none failed.",
)
@click.option(
    "--time-limit",
    type=click.FloatRange(min=0.0, min_open=True),
    metavar="SECONDS",
    help="Wall-clock limit of one point; beyond it the point fails, and is run again on resume.",
)
@click.option("-q", "--quiet", is_flag=True, help="Say nothing but errors.")
@click.option("-v", "--verbose", is_flag=True, help="Say more; tracebacks of internal errors.")
def command(
    cases: tuple[str, ...],
    output: Path | None,
    overrides: tuple[str, ...],
    workers: int,
    cluster: str,
    part: Part | None,
    resume: bool,
    keep_going: bool,
    max_points: int | None,
    time_limit: float | None,
    quiet: bool,
    verbose: bool,
) -> int:
    """Run case files; each becomes one NetCDF dataset, whose path is printed.

    What is finished is kept in STEM.run beside the dataset: after a crash, Ctrl-C or kill the
    same command goes on where it stopped, and the dataset is the same to the last bit. Until then
    the dataset says that it is partial (`fiv show`, `fiv plot`, its attribute `partial`). A longer
    axis computes only its new points. A run that may take more than an hour says so before it
    begins, from a few points that it tries for some seconds. In the background
    (`fiv run a.toml &`) a shell has it ignore Ctrl-C: `fiv status a.toml` says its number, and
    `kill NUMBER` (SIGTERM) stops it likewise.

    --cluster computes on other machines: `pip install '.[cluster]'` on each, start `dask scheduler`
    on one and `dask worker` on each (its threads say how many points it runs at once, each in a
    process of its own). Workers may come, go and die; one that would give other bits is refused.
    Without a scheduler, --shard runs a part, and `fiv assemble` joins them.

    Exit code: 0 where every point has its answer (undecided is one: `fiv show` counts and says
    why), 8 where --max-points left some to run, 4 where some failed or met max_steps or max_events.

    \b
    Examples:
      fiv new pin-on-disc > a.toml && fiv run a.toml --max-points 3    # a first look
      fiv run a.toml                          # the rest; then: fiv show runs/a.nc
      fiv run configs/ch7/*reached.toml --workers 4
      fiv run a.toml --set model.parameters.N0=20 -o lighter.nc
      fiv run a.toml --cluster tcp://node1:8786
      fiv run a.toml --shard 3/16             # then: fiv assemble a.toml
    """
    from fiv_cli.sweep.policy import Policy
    from fiv_cli.sweep.progress import for_stderr

    provide_cache()
    policy = Policy(
        workers=workers,
        cluster=cluster,
        part=part,
        fresh=not resume,
        fail_fast=not keep_going,
        max_points=max_points,
        time_limit=time_limit,
        foresee=not quiet,
    )
    loaded = load_all(cases, overrides)
    outputs = _outputs(loaded, output)
    if not quiet and ending.how_to_end():
        click.echo(ending.how_to_end(), err=True)
    _refuse_any(loaded, outputs, policy)
    summaries = []
    for number, (case, path) in enumerate(zip(loaded, outputs, strict=True), 1):
        title = f"{number} of {len(loaded)}, {case.source}: " if len(loaded) > 1 else ""
        summaries.append(_run(case, path, policy, for_stderr(quiet, title), verbose))
        if not quiet:
            click.echo("\n".join(summaries[-1].lines()), err=True)
        if not summaries[-1].unwritten:
            click.echo(summaries[-1].output)
    if not all(summary.sound for summary in summaries):
        return UNSOUND
    left = max_points is not None and not all(summary.complete for summary in summaries)
    return STILL_TO_RUN if left else 0


def load_all(sources: Sequence[str], overrides: Sequence[str]) -> list[Case]:
    """Every case, or one error with what is wrong in any of them."""
    from fiv_cli import api

    cases, wrong = [], []
    for source in sources:
        try:
            cases.append(api.load(source, overrides))
        except CaseError as error:
            wrong.append(error)
    if len(wrong) == 1:
        raise wrong[0]
    if wrong:
        raise InputError("\n".join(str(error) for error in wrong))
    return cases


def _outputs(cases: Sequence[Case], output: Path | None) -> list[Path]:
    """Where each case goes; no two to the same place."""
    from fiv_cli.case.identity import default_output

    if output is not None and len(cases) > 1:
        raise UsageError("-o names one dataset, but there are several cases\nnext: leave -o out")
    paths = [output or default_output(case) for case in cases]
    for i, path in enumerate(paths):
        if path in paths[:i]:
            raise UsageError(
                f"{cases[paths.index(path)].source} and {cases[i].source} would both be written "
                f"to {path}\nnext: run them one by one with -o FILE.nc"
            )
    return paths


def _refuse_any(cases: Sequence[Case], outputs: Sequence[Path], policy: Policy) -> None:
    """Of several cases none is run where one could not be stored: it is told before hours pass."""
    from fiv_cli.sweep.run import refuse_output

    for case, output in zip(cases, outputs, strict=True):
        try:
            refuse_output(case, output, policy.fresh)
        except FivError as error:
            if len(cases) == 1:
                raise
            none = f"{case.source}: of the {len(cases)} cases none is run"
            raise type(error)(f"{none}\n{error}") from error


def _run(case: Case, output: Path, policy: Policy, progress: Progress, verbose: bool) -> Summary:
    from fiv_cli import api
    from fiv_cli.sweep.run import run_case
    from fiv_cli.sweep.worker import keep_memory

    keep_memory()
    if verbose:
        click.echo(api.check(case), err=True)
    return run_case(case, output, policy, progress)
