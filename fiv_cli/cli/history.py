"""``fiv history``: one point of a sweep again, with its full motion."""

from __future__ import annotations

import re
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from fiv_cli.cli.common import provide_cache, set_option
from fiv_cli.errors import UsageError

if TYPE_CHECKING:
    import xarray as xr

    from fiv_cli.analyses.base import Outcome
    from fiv_cli.case.case import Case
    from fiv_cli.sweep.again import Point

FAILED = 4
_WHOLE = re.compile(r""""[^"]*"|'[^']*'|\[[^=]*\]""")
"""What no comma divides: a quoted text, a list."""
MARK = "point"
"""Global attribute that only the motion of a single point has."""


@click.command("history")
@click.argument("case")
@click.option(
    "--at",
    "places",
    multiple=True,
    metavar="AXIS=VALUE,...",
    help="The point: a value for each axis, and initial=LABEL. Repeatable.",
)
@click.option(
    "--t-end",
    metavar="TIME",
    help='End of the motion, s (or "2 min"). Default: the case\'s own t_end, or its t_max.',
)
@click.option("--sample", metavar="TIME", help="Interval of the samples, s. Default: t_end / 2000.")
@click.option(
    "-o",
    "--output",
    type=click.Path(path_type=Path),
    help="Dataset to write. Default: runs/STEM-history-POINT.nc.",
)
@set_option
def command(
    case: str,
    places: tuple[str, ...],
    t_end: str | None,
    sample: str | None,
    output: Path | None,
    overrides: tuple[str, ...],
) -> int:
    """Run any point of a sweep again and keep its whole motion: states, forces, events.

    The point must be on the grid of CASE; an axis with a single value may be left out. A start
    that continues from its neighbour is followed along its branch up to the point.

    \b
    Examples:
      fiv history configs/ch7/fig_7_06.toml --at Omega=2,N0=30,initial=far --t-end 20
      fiv history a.toml --at mu_k=0.3 -o motion.nc && fiv plot motion.nc
    """
    from fiv_cli.case.load import load_case
    from fiv_cli.sweep.again import find_point, run_again

    provide_cache()
    loaded = load_case(case, overrides)
    settings = {"t_end": _seconds("--t-end", t_end), "sample": _seconds("--sample", sample)}
    given = {name: value for name, value in settings.items() if value is not None}
    point = find_point(loaded, parse_places(places))
    path = output or _default_output(loaded, point.place)
    _check(path)
    dataset, outcome = run_again(point, given, lambda text: click.echo(text, err=True))
    _write(point, dataset, path)
    return _report(outcome, path)


def parse_places(places: tuple[str, ...]) -> dict[str, str]:
    """``--at`` as axis -> text.

    Raises
    ------
    UsageError
        a part has no ``=``, or an axis stands twice.
    """
    found: dict[str, str] = {}
    for part in (part.strip() for place in places for part in _parts(place)):
        name, equals, value = part.partition("=")
        if not equals or not name.strip() or not value.strip():
            raise UsageError(f"--at {part}: malformed\nnext: --at AXIS=VALUE,initial=LABEL")
        if name.strip() in found:
            raise UsageError(f"--at: {name.strip()} is given twice\nnext: give it once")
        found[name.strip()] = value.strip()
    return found


def _parts(place: str) -> list[str]:
    """`place` divided at its commas, but for those in quotes and brackets."""
    kept = _WHOLE.sub(lambda match: match[0].replace(",", "\0"), place)
    return [part.replace("\0", ",") for part in kept.split(",")]


def _seconds(option: str, text: str | None) -> float | None:
    """A positive time in s; a plain number or one with its unit."""
    from fiv_cli.notation.units import convert

    if text is None:
        return None
    try:
        value = convert(_number_or_text(text), "s")
    except ValueError as error:
        raise UsageError(
            f'{option} {text}: {error}\nnext: {option} 20 or {option} "2 min"'
        ) from error
    if not 0.0 < value < float("inf"):
        raise UsageError(f"{option} {text}: must be a positive time\nnext: {option} 20")
    return value


def _number_or_text(text: str) -> float | str:
    try:
        return float(text)
    except ValueError:
        return text


def _default_output(case: Case, place: dict[str, Any]) -> Path:
    from fiv_cli.case.identity import default_output

    stem = default_output(case).stem
    point = "_".join(f"{name}={value}" for name, value in place.items())
    return Path("runs") / f"{stem}-history-{point.replace('/', '-') or 'point'}.nc"


def _check(path: Path) -> None:
    """Refuse an output that cannot be written, or that holds a whole sweep."""
    from fiv_cli.data.netcdf import global_attributes
    from fiv_cli.sweep.output import check_output

    check_output(path, "", fresh=True)
    if path.exists() and MARK not in (global_attributes(path) or {}):
        raise UsageError(f"{path}: holds a sweep; it is left alone\nnext: -o ANOTHER.nc")


def _write(point: Point, dataset: xr.Dataset, path: Path) -> None:
    from fiv_cli.case.identity import fingerprint
    from fiv_cli.data.netcdf import write_datasets
    from fiv_cli.data.provenance import provenance

    attributes = provenance(point.case, fingerprint(point.case))
    attributes[MARK] = ", ".join(f"{name}={value}" for name, value in point.place.items())
    write_datasets(path, {"history": dataset}, attributes)


def _report(outcome: Outcome, path: Path) -> int:
    click.echo(path)
    if outcome.status == "ok":
        return 0
    click.echo(f"{outcome.status}: {outcome.reason}\n{outcome.message}".rstrip(), err=True)
    return FAILED
