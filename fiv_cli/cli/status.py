"""``fiv status``: how far a run has come."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click

from fiv_cli.cli.common import json_option, print_json, set_option


@click.command("status")
@click.argument("case")
@click.option(
    "-o", "--output", type=click.Path(path_type=Path), help="The dataset, if not the default."
)
@set_option
@json_option
def command(case: str, output: Path | None, overrides: tuple[str, ...], as_json: bool) -> None:
    """Say how many points of CASE are done, failed or still to run, without running anything.

    \b
    Examples:
      fiv status configs/ch7/fig_7_06_reached.toml
      fiv status a.toml --set grid.mu_k=[0.3] --json
    """
    document = _document(case, output, overrides)
    if as_json:
        print_json(document)
        return
    for line in _lines(document):
        click.echo(line)


def _document(source: str, output: Path | None, overrides: tuple[str, ...]) -> dict[str, Any]:
    """What is known of a run, as plain data."""
    from fiv_cli import api
    from fiv_cli.case.identity import default_output, differences
    from fiv_cli.sweep.journal import Journal, stored_identity
    from fiv_cli.sweep.lock import holder
    from fiv_cli.sweep.output import run_folder
    from fiv_cli.sweep.plan import make_plan
    from fiv_cli.sweep.run import count_statuses, refinements

    case = api.load(source, overrides)
    path = output or default_output(case)
    folder = run_folder(path)
    journal = Journal(folder, make_plan(case))
    stored = stored_identity(folder)
    differing = [] if stored is None else differences(stored, case)
    if not differing:
        journal.load()
    return {
        "case": source,
        "dataset": str(path),
        "dataset_exists": path.exists(),
        "running": holder(folder),
        "points": sum(count_statuses(journal).values()),
        "counts": count_statuses(journal),
        "refined": refinements(journal),
        "ignored_shards": [f"{shard}: {why}" for shard, why in journal.ignored],
        "stored_case_differs": differing,
    }


def _lines(document: dict[str, Any]) -> list[str]:
    counts = document["counts"]
    done = document["points"] - counts["pending"]
    lines = [
        f"{document['case']}: {done} of {document['points']} points done",
        *(f"  {count} {status}" for status, count in counts.items() if count),
        *(f"  {line}" for line in document["refined"]),
        f"  dataset {document['dataset']}"
        + ("" if document["dataset_exists"] else " (not written yet)"),
    ]
    if document["running"] is not None:
        lines.append(f"  process {document['running']} is running it")
    lines += [f"  ignored {shard}" for shard in document["ignored_shards"]]
    if document["stored_case_differs"]:
        lines.append("  what is stored belongs to another case:")
        lines += [f"    {line}" for line in document["stored_case_differs"]]
    return lines
