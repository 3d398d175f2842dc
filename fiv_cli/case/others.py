"""Cases that the claims and figures of a case compare with: they lie beside it."""

from __future__ import annotations

from collections.abc import Collection, Iterator
from pathlib import Path

from fiv_cli.analyses.variables import Variable
from fiv_cli.case.asked import check_number, known_in, references_of
from fiv_cli.case.case import Case
from fiv_cli.case.identity import output_of
from fiv_cli.case.report import Path as Place
from fiv_cli.case.report import Report
from fiv_cli.case.toml import parse_toml, toml_text
from fiv_cli.errors import FivError
from fiv_cli.notation.names import listed, suggest


def file_of(name: str, source: str) -> Path:
    """The file of the case `name` that the case at `source` names."""
    return Path(source).parent / f"{name.removesuffix('.toml')}.toml"


def not_run(case: Case) -> Iterator[str]:
    """What to run before claims of `case` can be held against what other cases found."""
    named = [one.case for claim in case.claims for one in references_of(claim).values()]
    for name in dict.fromkeys(filter(None, named)):
        if not output_of(name).exists():
            yield f"a claim compares with {name}, not run yet: fiv run {file_of(name, case.source)}"
    for name in dict.fromkeys(other for _, other, _, _ in _lines_of_others(case)):
        if not output_of(name).exists():
            file = file_of(name, case.source)
            yield f"a map draws a line of {name}, not run yet: fiv run {file}"


def _lines_of_others(case: Case) -> Iterator[tuple[Place, str, str, object]]:
    """(place, case, variable, level) of each line of another case that a map draws."""
    for index, figure in enumerate(case.figures):
        level = figure.settings.get("level")
        for name, own in level.items() if isinstance(level, dict) else ():
            other, colon, variable = name.partition(":")
            if colon:
                yield ("figure", index, "level", name), other, variable, own


def held_otherwise(case: Case) -> Iterator[str]:
    """What lines of other cases on maps are computed at that this case is not."""
    for name in dict.fromkeys(other for _, other, _, _ in _lines_of_others(case)):
        file = file_of(name, case.source)
        if not _is_there(file):  # a dataset alone: the figure tells
            continue
        other = _read(file)
        varied = {axis.name for axis in (*case.axes, *other.axes)}
        differ = [
            f"{key} = {value:g} (here {case.parameters[key]:g})"
            for key, value in other.parameters.items()
            if key not in varied and case.parameters.get(key, value) != value
        ]
        if differ:
            yield (
                f"a map draws a line of {name}, which is computed at {listed(differ)}: "
                f"give {file} what this case has, or an axis that has it"
            )


def check_others(case: Case, report: Report) -> None:
    """Note every other case that is named and that is not there, and variables it lacks."""
    for index, claim in enumerate(case.claims):
        for key, reference in references_of(claim).items():
            place = ("claim", index, "expect", key)
            other, variable = reference.case, reference.variable
            found = _found(other, variable, place, report) if other else None
            if found is not None:
                given = {*claim.at, *reference.at}
                foreign = _foreign(_read(file_of(other, case.source)), case, given)
                check_number(found, claim, reference, place, report, foreign)
    for at, name, variable, level in _lines_of_others(case):
        line = _found(name, variable, at, report)
        if line is not None and _has_no_line(line, level):
            message = f"{variable!r} has no one number at each point, and no level there"
            report.add(
                at,
                message,
                "the level of one, such as growth_rate; or of crossings, such as critical_value, "
                "the axis along which they lie, in place of a number",
            )


def _foreign(other: Case, case: Case, given: Collection[str]) -> dict[str, object]:
    """Axes of several values that another case has alone -> the first value of each.

    Of those that are zipped the first stands for all; none where one of them is `given`.
    """
    known, found = {axis.name for axis in case.axes} | {*given}, dict[str, object]()
    for axis in (one for one in other.axes if len(one.values) > 1):
        together = next((zipped for zipped in other.zips if axis.name in zipped), (axis.name,))
        if not {*together} & {*known, *found}:
            found[axis.name] = axis.values[0]
    return found


def _has_no_line(variable: Variable, level: object) -> bool:
    """Whether a variable has no level, or no values that an axis could have."""
    dims = {*variable.dims} - ({"crossing"} if isinstance(level, str) else set())
    return variable.kind == "flag" or bool(variable.ragged or dims)


def _found(name: str, variable: str, place: Place, report: Report) -> Variable | None:
    """The variable of another case, if that is there and has it; notes where it lacks it."""
    file = file_of(name, report.source)
    if not _is_there(file):
        beside = sorted(one.stem for one in file.parent.glob("*.toml"))
        if not _is_there(output_of(name)):
            allowed = f"the name of a case beside this one, or of a dataset {output_of('NAME')}"
            report.add(place, f"there is no case {file}", allowed, suggest(name, beside), True)
        return None
    try:
        known = _known(file)
    except (FivError, OSError, ValueError):
        report.add(place, f"{file} has mistakes", suggestion=f"fiv check {file}", of_name=True)
        return None
    if variable not in known:
        variables = [one.name for one in known.values() if one is not None]
        message = f"no analysis of {file} computes {variable!r}"
        report.unknown(place, message, variable, variables)
    return known.get(variable)


def _is_there(file: Path) -> bool:
    try:
        return file.is_file()
    except OSError:  # no name of a file
        return False


def _known(file: Path) -> dict[str, Variable | None]:
    """What another case will hold."""
    return known_in(_read(file))


def _read(file: Path) -> Case:
    """Another case without its own claims and figures, which may speak of this one."""
    from fiv_cli.case.load import parse_case

    document = parse_toml(file.read_text(encoding="utf-8"))
    rest = {key: value for key, value in document.items() if key not in ("claim", "figure")}
    return parse_case(toml_text(rest), str(file))
