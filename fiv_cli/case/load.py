"""From a TOML text to a `Case`, or to one error with all that is wrong in it.

What is wrong is told in three looks (`Report`): the form of the tables (``form.py``), then names
that nothing has, with values that are wrong whatever these mean, then what does not fit together
(``fit.py``).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path as FilePath
from typing import Any

from fiv_cli.case.analysis import read_analyses
from fiv_cli.case.asked import check_what_is_asked
from fiv_cli.case.case import Axis, Case
from fiv_cli.case.excitation import with_excitations
from fiv_cli.case.fit import refuse_what_does_not_fit
from fiv_cli.case.form import known_tables, read_form
from fiv_cli.case.grid import read_grid, refuse_fixed_axes
from fiv_cli.case.lines import locate
from fiv_cli.case.others import check_others
from fiv_cli.case.overrides import apply_overrides, parse_override
from fiv_cli.case.physics import Physics, read_physics
from fiv_cli.case.report import Report
from fiv_cli.case.results import Answers, read_claims, read_figures
from fiv_cli.case.schedule import at_the_start, read_schedule
from fiv_cli.case.solver import read_solver
from fiv_cli.case.starts import read_starts
from fiv_cli.case.syntax import syntax_problem
from fiv_cli.case.toml import MOST_BYTES, TooMuchError, parse_toml, too_large
from fiv_cli.errors import CaseError, Problem, UsageError
from fiv_cli.files import NETCDF
from fiv_cli.friction.base import Law
from fiv_cli.models.base import Parameter
from fiv_cli.notation.names import suggest


def load_case(path: str | FilePath, overrides: Sequence[str] = ()) -> Case:
    """Read the case file at `path` and apply ``--set`` lines.

    Raises
    ------
    UsageError
        There is no readable file at `path`, or an override is malformed.
    CaseError
        The file, or an override, is invalid; holds every problem of the first of its form, its
        names and its values in which there are any.
    """
    source = str(path)
    return parse_case(_read(source), source, overrides)


def parse_case(text: str, source: str, overrides: Sequence[str] = ()) -> Case:
    """The case that `text` means; errors as `load_case`, naming `source`."""
    parsed = [parse_override(override) for override in overrides]
    try:
        document, places, unplaced = apply_overrides(_toml(text, source), parsed)
    except RecursionError:  # of paths of --set, which are no text of the case
        raise CaseError(source, [Problem("case", "tables or lists nest too deeply")]) from None
    report = Report(source, locate(text), places)
    report.add_problems(unplaced)
    case = _build(document, report, source, text, tuple(overrides))
    report.raise_by_phase()
    return case


def _read(source: str) -> str:
    try:
        with FilePath(source).open("rb") as file:
            content = file.read(MOST_BYTES + 1)
        if content.startswith(NETCDF):
            raise UsageError(
                f"{source}: a dataset, not a case file\n"
                f"next: fiv show {source}, fiv plot {source}, or name its case "
                f"(fiv claims CASE -o {source})"
            )
        if len(content) > MOST_BYTES:
            raise _too_much(source, too_large(len(content)))
        return content.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        line = error.object[: error.start].count(b"\n") + 1
        problem = Problem("case", "is not UTF-8 text", "a TOML file in UTF-8", line=line)
        raise CaseError(source, [problem]) from None
    except FileNotFoundError:
        raise UsageError(f"{source}: there is no such file{_nearby(source)}") from None
    except IsADirectoryError:
        raise UsageError(
            f"{source} is a folder, not a case file\nnext: name a file in it, e.g. {source}/*.toml"
        ) from None
    except (OSError, ValueError) as error:
        raise UsageError(f"{source}: cannot be read: {error}") from None


def _nearby(source: str) -> str:
    """What may have been meant instead of a missing file."""
    path = FilePath(source)
    siblings = [str(other) for other in path.parent.glob("*.toml")] if path.parent.is_dir() else []
    hint = suggest(source, sorted(siblings))
    return f"\nnext: {hint}" if hint else "\nnext: check the path; `fiv new MODEL` writes a case"


def _toml(text: str, source: str) -> dict[str, Any]:
    try:
        return parse_toml(text)
    except TooMuchError as error:
        raise _too_much(source, error) from None
    except ValueError as error:  # TOMLDecodeError, or an integer too long to read
        raise CaseError(source, [syntax_problem(str(error), text)]) from None


def _too_much(source: str, error: TooMuchError) -> CaseError:
    return CaseError(source, [Problem("case", error.message, error.allowed, line=error.line)])


def _build(
    raw: Mapping[str, Any], report: Report, source: str, text: str, overrides: tuple[str, ...]
) -> Case:
    """The case, as far as it can be understood; every problem goes to `report`."""
    raw = known_tables(raw, report)
    form = read_form(raw, report)
    given = with_excitations(form, read_physics(form, report), report)
    axes, zips, refinement = read_grid(form, given, report)
    refuse_fixed_axes(form, report)
    schedule = read_schedule(form, given, axes, report)
    physics = at_the_start(given, schedule)
    analyses = read_analyses(form, given, axes, report)
    starts = read_starts(form, given, axes, report)
    solver = read_solver(form, report)
    report.go_on_to_relations()
    answers = Answers(given, axes, starts, analyses)
    case = Case(
        source=source,
        text=text,
        overrides=overrides,
        title=form.header.title,
        reference=form.header.reference,
        assumed=tuple(form.header.assumed),
        model=physics.model.name,
        options=physics.options,
        law=physics.laws[0].name,
        parameters=_fixed_parameters(physics, axes),
        explicit=tuple(physics.fixed),
        axes=axes,
        zips=zips,
        starts=starts,
        analyses=analyses,
        figures=read_figures(form, raw.get("figure", []), answers, report),
        claims=read_claims(form, answers, report),
        solver=solver,
        refinement=refinement,
        schedule=schedule,
        own=physics.origins(),
    )
    check_what_is_asked(case, report)
    check_others(case, report)
    refuse_what_does_not_fit(case, form, physics, report)
    return case


def _fixed_parameters(physics: Physics, axes: Sequence[Axis]) -> dict[str, float]:
    """Every parameter that is no axis: as given, or its default.

    A parameter that follows an axis (`default_from`) is left to the point. Where several laws
    are in use and give a parameter different values, it is kept by law, as ``LAW.NAME``.
    """
    varied = {axis.name for axis in axes}
    by_law = {law.name: _values_under(physics, law) for law in physics.laws}
    found = dict(_values(physics, "", physics.model.parameters))
    for law, values in by_law.items():
        for name, value in values.items():
            agreed = all(other.get(name, value) == value for other in by_law.values())
            found[name if agreed else f"{law}.{name}"] = value
    return {
        key: value
        for key, value in found.items()
        if value is not None and key.split(".")[-1] not in varied
    }


def _values_under(physics: Physics, law: Law) -> dict[str, float | None]:
    return _values(physics, f"{law.name}.", physics.model.adopted(law))


def _values(physics: Physics, prefix: str, table: Sequence[Parameter]) -> dict[str, float | None]:
    """The values of the parameters of one table, what is given for one law going first.

    None where it follows another parameter.
    """
    fixed = physics.fixed
    return {p.name: fixed.get(prefix + p.name, fixed.get(p.name, p.default)) for p in table}
