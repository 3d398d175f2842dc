"""What the figures and claims of a case ask for, against what its analyses will hold.

A misspelt variable is told before anything is computed, not after.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path as FilePath

from fiv_cli.analyses import get_analysis
from fiv_cli.analyses.catalogue import variables_of
from fiv_cli.analyses.settings import StateName
from fiv_cli.analyses.variables import COMPUTED, Variable, motions
from fiv_cli.case.case import AnalysisSpec, Case, ClaimSpec, FigureSpec
from fiv_cli.case.grammar import OfClass
from fiv_cli.case.lines import locate
from fiv_cli.case.load import load_case, parse_case
from fiv_cli.case.overrides import apply_overrides, parse_override
from fiv_cli.case.report import Path, Report, in_order
from fiv_cli.case.toml import parse_toml
from fiv_cli.data.layout import varying_in
from fiv_cli.errors import CaseError, Problem
from fiv_cli.flags import TABLES
from fiv_cli.models import get_model
from fiv_cli.notation.names import listed, suggest

Held = Mapping[str, Sequence[Variable]]
"""Name of an analysis -> its variables."""


def load_checked(
    path: str | FilePath, overrides: Sequence[str] = (), text: str | None = None
) -> Case:
    """The case at `path` (or of `text`); what its figures and claims ask for will be there.

    Raises
    ------
    UsageError, CaseError
        as `load_case`; the problems of figures and claims are told with all the others.
    """
    try:
        if text is None:
            case = load_case(path, overrides)
        else:
            case = parse_case(text, str(path), overrides)
    except CaseError as error:
        refused = error.case
        if refused is None or not all(_is_sound(refused, spec) for spec in refused.analyses):
            raise
        told = {problem.path for problem in error.problems}
        further = [problem for problem in _problems(refused) if problem.path not in told]
        raise CaseError(error.source, in_order([*error.problems, *further])) from None
    refuse_what_will_not_be_there(case)
    return case


def _is_sound(case: Case, spec: AnalysisSpec) -> bool:
    """Whether the variables of an analysis can be told: all it needs is given, and its states are
    those of the model."""
    settings = get_analysis(spec.kind).settings
    needed = [setting.name for setting in settings if setting.required]
    named = [
        spec.settings.get(setting.name) for setting in settings if isinstance(setting, StateName)
    ]
    states = [name for name, *_ in motions(get_model(case.model).states(case.options))]
    given = all(spec.settings.get(name) is not None for name in needed)
    return given and all(name is None or name in states for name in named)


def refuse_what_will_not_be_there(case: Case) -> None:
    """Check every variable that a figure or a claim names.

    Raises
    ------
    CaseError
        one names what no analysis of the case computes, or asks a number for its class.
    """
    problems = _problems(case)
    if problems:
        raise CaseError(case.source, in_order(problems))


def _problems(case: Case) -> list[Problem]:
    """What is wrong with the variables that figures and claims name."""
    held = {spec.name: _variables(case, spec) for spec in case.analyses}
    set_on = [parse_override(line) for line in case.overrides]
    _, places, _ = apply_overrides(parse_toml(case.text), set_on)
    report = Report(case.source, locate(case.text), places)
    for index, figure in enumerate(case.figures):
        known = _known(case, held, figure.settings.get("analysis"), with_motions=True)
        for name in _named(figure):
            _check(name, known, ("figure", index, "variable"), report)
        _check_scale(figure, ("figure", index), report)
    for index, claim in enumerate(case.claims):
        place: Path = ("claim", index)
        known = _known(case, held, claim.analysis, with_motions=False)
        if _check(claim.variable, known, (*place, "variable"), report):
            _check_expected(claim, known[claim.variable], place, report)
    return report.problems


def _variables(case: Case, spec: AnalysisSpec) -> Sequence[Variable]:
    model = get_model(case.model)
    return variables_of(spec.kind, model, case.options, spec.settings, varying_in(case))


def _named(figure: FigureSpec) -> Iterable[str]:
    named = figure.settings.get("variable", [])
    return [named] if isinstance(named, str) else named


def _known(
    case: Case, held: Held, analysis: str | None, with_motions: bool
) -> dict[str, Variable | None]:
    """Everything that stands in the dataset of the case, or of one of its analyses.

    A figure may also be drawn of a motion that ``fiv history`` computes (`with_motions`).
    """
    chosen = [variables for name, variables in held.items() if not analysis or name == analysis]
    found: dict[str, Variable | None] = dict.fromkeys(
        [*(axis.dim for axis in case.axes), COMPUTED.name]
    )
    if with_motions:
        own = variables_of("history", get_model(case.model), case.options, {})
        found |= {variable.name: variable for variable in own}
    for variables in chosen:
        found |= {f"{v.ragged}_row_size": None for v in variables if v.ragged}
        found |= {variable.name: variable for variable in variables}
    return found


def _check(name: str, known: Mapping[str, Variable | None], place: Path, report: Report) -> bool:
    """Whether there is such a variable; notes where there is none."""
    if name not in known:
        variables = {v.name: v.long_name for v in known.values() if v is not None}
        message = f"no analysis of this case computes {name!r}"
        report.add(place, message, listed(variables), suggest(name, variables))
    return name in known


def _check_expected(
    claim: ClaimSpec, variable: Variable | None, place: Path, report: Report
) -> None:
    """Note a class that is expected of a number, and a number that is expected of a class."""
    if variable is None or claim.take:
        return
    classes = list(TABLES[variable.flags].codes) if variable.kind == "flag" else []
    if not isinstance(claim.expect, OfClass):
        if classes:
            message = f"{variable.name!r} holds a class, not a number"
            report.add((*place, "expect"), message, f'{listed(classes)}, or "not CLASS"')
    elif not classes:
        message = f"{claim.variable!r} is a number and has no class {claim.expect.name!r}"
        forms = '"increasing", "decreasing", { value, tolerance } or { less_than }'
        report.add((*place, "expect"), message, forms)
    elif claim.expect.name not in classes:
        message = f"{variable.name!r} has no class {claim.expect.name!r}"
        hint = suggest(claim.expect.name, classes)
        report.add((*place, "expect"), message, listed(classes), hint)


def _check_scale(figure: FigureSpec, place: Path, report: Report) -> None:
    """Note limits that a logarithmic axis cannot have."""
    log = figure.settings.get("log", False)
    for which in ("x", "y"):
        limits = figure.settings.get(f"{which}lim", ())
        logarithmic = log is True or (isinstance(log, str) and which in log)
        numbers = [bound for bound in limits if isinstance(bound, int | float)]
        if logarithmic and any(bound <= 0 for bound in numbers):
            message = f"a logarithmic axis begins above 0, not at {min(numbers)!r}"
            report.add((*place, f"{which}lim"), message, "[low, high] with 0 < low")
