"""``fiv assemble``: the dataset of what runs of parts have stored."""

from __future__ import annotations

from pathlib import Path

import click

from fiv_cli.cli.common import STILL_TO_RUN, UNSOUND, set_option, with_option


@click.command("assemble")
@click.argument("case")
@click.option("-o", "--output", type=click.Path(path_type=Path), help="The dataset, as of the run.")
@set_option
@with_option
def command(case: str, output: Path | None, overrides: tuple[str, ...]) -> int:
    """Write the dataset of CASE from what `fiv run --shard` has stored, and say what is missing.

    Joins all parts, and what was run of the case without --shard; the dataset is that of one run,
    to the last bit. Exit code: 0 where all is there; 8 where points are still to run; 4 where some
    have failed.

    \b
    Examples:
      fiv new pin-on-disc > a.toml
      fiv run a.toml --shard 1/2; fiv run a.toml --shard 2/2; fiv assemble a.toml

    \b
    A job array of Slurm, sbatch job.sh, then fiv assemble a.toml (no blanks before its lines):
      #!/bin/sh
      #SBATCH --array=1-16 --cpus-per-task=4 --time=12:00:00
      export FIV_RUN_SHARD="$SLURM_ARRAY_TASK_ID/16" FIV_RUN_WORKERS="$SLURM_CPUS_PER_TASK"
      fiv run a.toml    # as with --shard 3/16 --workers 4

    \b
    GNU make as the queue (make -j 4):
      runs/a.nc: $(addsuffix .part,$(shell seq 16)) ; fiv assemble a.toml
      %.part: ; fiv run a.toml --shard $*/16 --workers 1
    """
    from fiv_cli import api
    from fiv_cli.case.identity import default_output
    from fiv_cli.sweep.run import assemble_case

    loaded = api.load(case, overrides)
    summary, missing = assemble_case(loaded, output or default_output(loaded))
    click.echo("\n".join([*summary.lines(), *(f"  {line}" for line in missing)]), err=True)
    if summary.output.exists():
        click.echo(summary.output)
    if summary.complete:
        return 0
    return UNSOUND if not summary.sound else STILL_TO_RUN
