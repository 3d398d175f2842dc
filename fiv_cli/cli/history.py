"""``fiv history``: one point of a sweep again, with its full motion."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from fiv_cli.cli.common import (
    at_option,
    parse_places,
    provide_cache,
    set_option,
    with_option,
)

if TYPE_CHECKING:
    import xarray as xr

    from fiv_cli.analyses.base import Outcome
    from fiv_cli.case.case import Case

FAILED = 4


@click.command("history")
@click.argument("case")
@at_option("The point: a value for each axis, and initial=LABEL. Repeatable.")
@click.option(
    "--t-end",
    metavar="TIME",
    help='End of the motion, s (or "2 min"). Default: the case\'s own t_end, or its t_max.',
)
@click.option(
    "--sample",
    metavar="TIME",
    help="Interval of the samples, s. Default: t_end / 2000, or the period / 1000; with --periods "
    "the next shorter one that divides these.",
)
@click.option(
    "--periods", type=float, metavar="N", help="End after N periods of the steady state instead."
)
@click.option(
    "--settled",
    is_flag=True,
    help="Begin where the steady state is reached: no transient. In a case of a cycle, stable or "
    "not, without a response: on it.",
)
@click.option(
    "-o",
    "--output",
    type=click.Path(path_type=Path),
    metavar="FILE.nc",
    help="Dataset to write. Default: runs/STEM-history-POINT.nc.",
)
@set_option
@with_option
def command(
    case: str,
    places: tuple[str, ...],
    t_end: str | None,
    sample: str | None,
    periods: float | None,
    settled: bool,
    output: Path | None,
    overrides: tuple[str, ...],
) -> int:
    """Run any point of a sweep again and keep its whole motion: states, forces, events.

    The point must be on the grid of CASE; an axis with a single value may be left out. A start
    that continues from its neighbour is followed along its branch up to the point. The last state
    is printed as a start takes it, to begin another motion there. A motion that the file holds
    already is replaced, and said to be; a sweep is left alone.

    \b
    Examples:
      fiv history configs/ch7/fig_7_06_reached.toml --at Omega=2,N0=30 --t-end 20
      fiv history configs/ch7/fig_7_06_reached.toml --at Omega=2,N0=30 --periods 3 --settled -o m.nc
      fiv plot m.nc --figure phase
    """
    from fiv_cli import api
    from fiv_cli.sweep.motion import find_point, motion_settings, steady_part, write_motion

    provide_cache()
    loaded = api.load(case, overrides)
    settings = motion_settings(t_end, sample)
    point = find_point(loaded, parse_places(places))
    path = output or _default_output(loaded, point.place)
    steady = steady_part(periods, settled, t_end)
    outcome = write_motion(point, settings, path, lambda text: click.echo(text, err=True), steady)
    return _report(outcome, path, loaded)


def _default_output(case: Case, place: dict[str, Any]) -> Path:
    from fiv_cli.case.identity import default_output

    stem = default_output(case).stem
    point = "_".join(f"{name}={value}" for name, value in place.items())
    return Path("runs") / f"{stem}-history-{point.replace('/', '-') or 'point'}.nc"


def _report(outcome: Outcome, path: Path, case: Case) -> int:
    from fiv_cli.flags import ENDED_EARLY, advice
    from fiv_cli.reading import sampling
    from fiv_cli.reading.datasets import read_analyses

    click.echo(path)
    if outcome.status == "ok":
        (motion,) = read_analyses(path).values()
        early = outcome.reason in ENDED_EARLY
        why = f"{outcome.reason}: {advice(outcome.reason)}" if early else ""
        said = [why, _end(motion, case), sampling.remark(motion.squeeze())]
        click.echo("\n".join(filter(None, said)), err=True)
        return 0
    click.echo(f"{outcome.status}: {outcome.reason}\n{outcome.message}".rstrip(), err=True)
    return FAILED


def _end(motion: xr.Dataset, case: Case) -> str:
    """The state in which a motion ended, as ``[[initial]]`` of kind "state" takes it."""
    import numpy as np

    from fiv_cli.case.physics import state_units
    from fiv_cli.models import get_model
    from fiv_cli.reading import sampling

    names = state_units(get_model(case.model), case.options)
    known = np.isfinite(motion[sampling.displacements(motion)[0]].values.ravel())
    *_, place = known.nonzero()[0]
    last, after = motion.isel(time=place), motion["time"].values[place + 1 : place + 2]
    state = ", ".join(f"{name} = {last[name].item()!r}" for name in names if name in motion)
    more = "\nit ended before {0:.12g} s, the next sample: --t-end {0:.12g}, no --sample, has more"
    told = f"at t = {last['time'].item():.12g} s: state = {{ {state} }}"
    return "".join([told, *map(more.format, after)])
