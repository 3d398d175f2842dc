"""What the figures and claims of a case ask for, against what its analyses will hold.

A misspelt variable is told before anything is computed, not after.
"""

from __future__ import annotations

import json
import re
from collections.abc import Mapping, Sequence
from typing import Any, get_args

from fiv_cli.analyses import get_analysis
from fiv_cli.analyses.catalogue import ALL_ASKED, computed_by, own_dims, variables_of
from fiv_cli.analyses.variables import COMPUTED, Variable, derived
from fiv_cli.case.case import AnalysisSpec, Case, ClaimSpec, FigureSpec
from fiv_cli.case.grammar import Bounds, OfClass, Reference, Trend, parse_condition
from fiv_cli.case.physics import state_units
from fiv_cli.case.places import NUMERIC, Places
from fiv_cli.case.report import Path, Report
from fiv_cli.case.structure import COUNTED, EACH, MOST_LINES, FigureKind
from fiv_cli.case.toml import toml_value
from fiv_cli.case.words import variable_meant
from fiv_cli.flags import TABLES
from fiv_cli.models import get_model
from fiv_cli.notation.names import listed, suggest
from fiv_cli.notation.units import parse_unit

# Kinds of figures of what `fiv history` computes of a point, too.
OF_MOTIONS = ("history", "phase", "spectrum", "spectrogram")
OF_A_MOTION = ("time", "contact", "point")  # dims that it has

# Kinds of figures of one variable: the group of ragged variables that it belongs to, "" for none.
RAGGED = {"curve": "", "map": "", "bifurcation": "section"}

# Kinds of figures of one analysis -> a variable that it alone has.
SHOWN = {
    "basin": "initial_state",
    "bifurcation": "section_value",
    "branch": "branch_value",
    "eigenvalues": "eigenvalue_real",
    "mode-shape": "shape",
}

# Kinds of figures of several panels -> the variables that these show.
PANELS = {"eigenvalues": ("eigenvalue_real", "mode_frequency")}

Held = Mapping[str, Sequence[Variable] | None]
"""Name of an analysis -> its variables; None where it does not suit the model."""


def check_what_is_asked(case: Case, report: Report) -> None:
    """Note every variable that a figure or a claim names and no analysis of the case computes.

    Of an analysis that is not understood itself, any that it could have under other settings.
    """
    held = {
        spec.name: _variables(case, spec, report.understands(("analysis", index)))
        for index, spec in enumerate(case.analyses)
    }
    for index, figure in enumerate(case.figures):
        _check_figure(figure, case, held, ("figure", index), report)
    for index, claim in enumerate(case.claims):
        _check_claim(claim, case, held, ("claim", index), report)
    _check_refined(case, held, report)


def drawn_of_motions(case: Case) -> list[str]:
    """Names of the figures that show a motion, where no analysis of the case keeps one."""
    held = (_variables(case, spec, True) or () for spec in case.analyses)
    if any(variable.name == "contact_state" for variables in held for variable in variables):
        return []
    return [one.name for one in case.figures if _is_of_a_motion(one, case)]


def _is_of_a_motion(figure: FigureSpec, case: Case) -> bool:
    """Whether a figure shows a motion, and no spectrum that an analysis of the case computes."""
    steady = {spec.kind for spec in case.analyses} & {"spectrum", "spectrogram"}
    return figure.kind in OF_MOTIONS and figure.kind not in steady


def numbers_of_refined(case: Case) -> list[tuple[str, str]]:
    """(figure, variable) of each map of a number that points which are filled in do not have, or
    with its levels."""
    refined = case.refinement
    if refined is None:
        return []
    held = {spec.name: _variables(case, spec, True) or () for spec in case.analyses}
    filled_in = {name: own for name, own in held.items() if refined.of in [v.name for v in own]}
    return [
        (figure.name, variable.name)
        for figure in case.figures
        for name, own in filled_in.items()
        for variable in own
        if figure.kind == "map"
        and variable.name in [figure.settings.get("variable"), *_levelled(figure)]
        and not variable.is_class
        and figure.settings.get("analysis", name) == name
    ]


def _levelled(figure: FigureSpec) -> list[str]:
    """Other variables of which a map has lines."""
    level = figure.settings.get("level")
    return [name.rpartition(":")[2] for name in level] if isinstance(level, Mapping) else []


def _check_figure(figure: FigureSpec, case: Case, held: Held, place: Path, report: Report) -> None:
    """Note what no analysis gives that a figure shows."""
    _check_scale(figure, place, report)
    if figure.kind in ("history", "phase"):  # of others the key itself is refused
        _check_contact(figure, get_model(case.model).contacts, place, report)
    analysis = figure.settings.get("analysis")
    known = _known(case, held, analysis, figure.kind in OF_MOTIONS)
    if known and SHOWN.get(figure.kind, "status") not in known:
        message = f"no analysis of this case gives what a figure of kind {figure.kind!r} shows"
        given = computed_by(SHOWN[figure.kind])
        report.add((*place, "kind"), "\n".join(filter(None, (message, given))), _kinds(known))
        return
    if figure.kind == "phase" and known:
        _check_phase(figure, known, place, report)
    if figure.kind == "basin":
        _check_basin(figure, case, place, report)
    key = "y" if figure.kind == "curve" and "variable" not in figure.settings else "variable"
    names = _named(figure.settings.get(key, [])) if known else []
    _check_limits(figure, names or _displacements(figure, known), (*place, "ylim"), report)
    shown = known
    if figure.kind in ("history", "phase"):
        shown = _moving(known)
        names = [name for name in names if not _is_still(name, known, shown, (*place, key), report)]
    names = [n for n in names if not _of_another(n, analysis, known, held, (*place, key), report)]
    sound = [name for name in names if _check(name, shown, (*place, key), report)]
    for name in sound:
        places = _places(case, held, analysis, name)
        _check_drawn(figure, name, known, places, (*place, key), report)
        if figure.kind in ("curve", "map") and "take" not in figure.settings:
            _refuse_motion(figure.kind, name, held, (*place, key), report)
    if _is_of_a_motion(figure, case):
        _refuse_own_dims(figure, (*place, "select"), report)
    unsaid = [] if "take" in figure.settings else _mapped(figure, held, ())
    first = [SHOWN[figure.kind]] if figure.kind in SHOWN else unsaid
    drawn = next(iter((*sound, *names, *first, "status")))
    places = _places(case, held, analysis, drawn)
    of_lines = _check_levels(figure, case, held, names, (*place, "level"), report)
    if places is not None and figure.kind not in OF_MOTIONS:
        selected = figure.settings.get("select", {})
        beside = [one for one in held[places.name] or () if one.name not in places.own]
        of_classes = selected if figure.kind == "curve" else {}
        asked = "curve", of_classes, known.get(drawn), beside, (*place, "select")
        results = _check_classes(*asked, report)
        own = {n: one for n, one in selected.items() if n not in {*of_lines, *results}}
        every = [of for name in sound for of in [_places(case, held, analysis, name)] if of]
        for name, wanted in own.items():  # each is of the first analysis that has it
            of = next((of for of in every if name in (*of.grid, *of.own)), places)
            of.check({name: wanted}, (*place, "select"), report)
    if len(sound) == len(names) > 1 and analysis is None:
        _check_of_several(figure, case, names, held, (*place, key), report)
    if analysis is None and figure.kind in ("curve", "map", "basin"):
        unasked = ["attractor"] if figure.kind == "basin" else _mapped(figure, held, ())
        first = sound if names else unasked
        _check_of_which(first, held, (*place, key), report)


def _check_limits(figure: FigureSpec, names: Sequence[str], place: Path, report: Report) -> None:
    """Note ranges of variables that no panel of a figure shows."""
    limits = figure.settings.get("ylim")
    if not isinstance(limits, dict):
        return
    shown = PANELS.get(figure.kind, names if figure.kind in ("curve", "history") else ())
    if not shown:
        message = "a range for each variable is of a figure with a panel for each"
        report.add(place, message, "[low, high], or variable = [...] of a curve or history")
        return
    for name in limits:
        if name not in shown:
            message = f"{name!r} is no variable of this figure"
            report.unknown((*place, name), message, name, shown)


def _displacements(figure: FigureSpec, known: Mapping[str, Variable | None]) -> list[str]:
    """What a history shows that names nothing."""
    return [name for name in known if figure.kind == "history" and f"{name}_dot" in known]


def _check_levels(
    figure: FigureSpec, case: Case, held: Held, mapped: Sequence[str], at: Path, report: Report
) -> set[str]:
    """Note levels that no line of a map has; the axes of the variables of which there are."""
    said = figure.settings.get("level", [])
    plain = dict.fromkeys(_mapped(figure, held, mapped), said)
    of = said if isinstance(said, dict) else plain if said != [] else {}
    count = sum(len(own) if isinstance(own, list) else 1 for own in of.values())
    if count > MOST_LINES:
        message = f"{count} lines in one map cannot be told apart"
        report.add(at, message, f"{MOST_LINES} levels, or a figure for each few")
    if figure.settings.get("overlay") and of:
        place, numbers = (*at[:-1], "overlay"), {n for n in of if not isinstance(of[n], str)}
        mapped_alone = "overlay shows levels of the variable that is mapped, alone"
        exact = 'level = NUMBER, and of other cases "CASE:boundary" = "AXIS"; or leave overlay out'
        if others := numbers - {*plain}:
            report.add(place, f"{mapped_alone}, and none of {min(others)}", exact)
        elif not numbers:
            report.add(place, f"{mapped_alone}, and has none", f"variable = A NUMBER, {exact}")
    known = _known(case, held, None, with_motions=False)
    taken = figure.settings.get("take", {}).get("what")
    axes = {"crossing"} if any(isinstance(own, str) for own in of.values()) else set()
    for name in [name for name in of if known and name != taken and ":" not in name]:
        place = (*at, name) if isinstance(said, dict) else at
        if taken and name == figure.settings.get("variable"):
            message = f"this map shows the {taken} of {name!r}, and has lines at levels of that"
            report.add(place, message, f"level = {of[name]}, or {{ {taken} = ... }}")
        elif isinstance(of[name], str) and not _classes(known.get(name)):
            # found over the other axis: in a case that has not this one
            message = f"the line where {of[name]} has the value of {name!r} needs another case"
            report.add(place, message, '"CASE:VARIABLE" = "AXIS", found along the other axis')
        elif _check(name, known, place, report):
            _check_line(name, known, figure, place, report)
            places = _places(case, held, None, name)
            axes |= {*places.own} if places else set()
    return axes


def _mapped(figure: FigureSpec, held: Held, named: Sequence[str]) -> Sequence[str]:
    """What a figure shows: what it takes or names, or a headline of its analysis; of classes and
    numbers a map the first, a curve the second."""
    if "take" in figure.settings or named:
        return [figure.settings["take"]["what"]] if "take" in figure.settings else named
    wanted = figure.settings.get("analysis")
    of = (own or () for name, own in held.items() if name == (wanted or name))
    shown = next(filter(None, ([v for v in own if v.headline] for own in of)), [])
    first = sorted(shown, key=lambda v: (bool(_classes(v)) == (figure.kind == "curve"), v.headline))
    return [one.name for one in first[:1]]


def _check_line(
    name: str,
    known: Mapping[str, Variable | None],
    figure: FigureSpec,
    place: Path,
    report: Report,
) -> None:
    """Note a variable that has no one number at each point."""
    variable = known[name]
    if _classes(variable):
        numbers = [v.name for v in known.values() if v and v.headline and not _classes(v)]
        message = f"{name!r} holds classes, which have no level"
        allowed = (
            f"level = {{ VARIABLE = NUMBER }} of a number: {listed(numbers)}; for the border of a "
            'class, { "CASE:boundary" = "AXIS" } of a case that finds it, by an analysis `boundary`'
        )
        report.add(place, message, allowed)
    elif variable is not None and variable.ragged:
        report.add(place, f"{name!r} has any number of values at a point, and no level there")
    for dim in variable.dims if variable else ():
        if dim not in figure.settings.get("select", {}):
            report.add(place, f"{name!r} has a value for each {dim}", f"select = {{ {dim} = 0 }}")


def _check_of_several(
    figure: FigureSpec, case: Case, names: Sequence[str], held: Held, place: Path, report: Report
) -> None:
    """Note variables of which no analysis has all: a curve alone shows them, along one axis."""
    of = {analysis: {v.name for v in variables or ()} for analysis, variables in held.items()}
    homes = {name: [analysis for analysis, own in of.items() if name in own] for name in names}
    if not all(homes.values()) or any(own.issuperset(names) for own in of.values()):
        return
    if figure.kind != "curve":
        told = ", ".join(f"{name} is of {' and '.join(home)}" for name, home in homes.items())
        message = "a figure shows variables of one analysis"
        report.add(place, message, told, "write a figure for each")
        return
    for name, home in homes.items():
        if len(home) > 1:
            message = f"{len(home)} analyses compute {name!r}, and this figure cannot say which"
            alone = f'a figure of it alone, with analysis = "{home[-1]}"'
            report.add(place, message, listed(home), alone)
    if report.is_sound((*place[:-1], "x")):
        _check_along(figure.settings.get("x"), names, case, held, (*place[:-1], "x"), report)


def _check_along(
    x: str | None, names: Sequence[str], case: Case, held: Held, place: Path, report: Report
) -> None:
    """Note variables of several analyses that do not vary along the axis of their curve."""
    numeric = [axis for axis in case.axes if axis.kind in NUMERIC]
    longest = max(numeric or case.axes, key=lambda axis: len(axis.values), default=None)
    along = x or (longest.name if longest else "")
    for name in names:
        places = _places(case, held, None, name)
        if along and places is not None and along not in places.grid:
            message = f"{name!r} of the analysis {places.name!r} has no axis {along!r}"
            several = "a curve shows variables of several analyses along an axis that all have"
            report.add(place, message, listed([*places.grid]), several)


def _check_of_which(names: Sequence[str], held: Held, place: Path, report: Report) -> None:
    """Note variables that several analyses have where the figure does not say of which one."""
    homes = [
        analysis
        for analysis, own in held.items()
        if names and {variable.name for variable in own or ()}.issuperset(names)
    ]
    if len(homes) > 1:
        message = f"{len(homes)} analyses compute {listed(names)}, and a figure shows that of one"
        several = "; of both, a case for each, since several files share a curve: fiv plot --help"
        report.add(
            (*place[:-1], "analysis"), message, listed(homes), f'analysis = "{homes[-1]}"{several}'
        )


def _refuse_own_dims(figure: FigureSpec, place: Path, report: Report) -> None:
    """Note what is selected of a motion that only other results have, such as a state."""
    selected = figure.settings.get("select", {})
    for dim in [one for one in own_dims() if one in selected and one not in OF_A_MOTION]:
        shown = f"variable = {json.dumps(selected[dim])}" if dim == "state" else ""
        report.add((*place, dim), f"a motion has no axis {dim!r}", shown)


def _check_phase(
    figure: FigureSpec, known: Mapping[str, Variable | None], place: Path, report: Report
) -> None:
    """Note an axis of a phase portrait that does not vary along a motion."""
    moving = {name: variable for name, variable in known.items() if _moves(variable)}
    for key in [key for key in ("x", "y") if key in figure.settings]:
        name, at = figure.settings[key], (*place, key)
        if not _is_still(name, known, moving, at, report):
            _check(name, moving, at, report)


def _check_basin(figure: FigureSpec, case: Case, place: Path, report: Report) -> None:
    """Note an axis that is no component of a start; ``initial.x`` is that of ``x``."""
    states = state_units(get_model(case.model), case.options)
    for key in [key for key in ("x", "y") if key in figure.settings]:
        name = figure.settings[key].removeprefix("initial.")
        if name not in states:
            report.unknown((*place, key), f"there is no state {name!r}", name, states)


def _is_still(
    name: str,
    known: Mapping[str, Variable | None],
    moving: Mapping[str, Variable | None],
    place: Path,
    report: Report,
) -> bool:
    """Whether a variable has other values than along a motion; notes what shows them."""
    variable = known.get(name)
    if variable is None or name in moving:
        return False
    message = f"{name!r} has no value at each instant of a motion, which this figure shows"
    hint = computed_by(name, along="time") or _shown_by(variable)
    report.add(place, message, listed([*moving]), hint)
    return True


def _shown_by(variable: Variable) -> str:
    """The kind of figure that shows a variable along an axis; "" where none does."""
    kinds = {ragged: kind for kind, ragged in RAGGED.items() if kind != "map"}
    kind = kinds.get(variable.ragged)
    return f'kind = "{kind}" shows {variable.name} along an axis' if kind else ""


def _moving(known: Mapping[str, Variable | None]) -> dict[str, Variable | None]:
    """What varies along a motion."""
    return {name: v for name, v in known.items() if v is not None and "time" in v.dims}


def _moves(variable: Variable | None) -> bool:
    return variable is not None and "time" in variable.dims and variable.kind == "float"


def _check_claim(claim: ClaimSpec, case: Case, held: Held, place: Path, report: Report) -> None:
    """Note what no analysis gives that a claim speaks of, or compares with."""
    known = _known_of(claim, case, held, place, report)
    if not known:
        return
    _refuse_ambiguous(claim.variable, claim.analysis, held, (*place, "variable"), report)
    if claim.undecided_counts and claim.variable == "attractor":
        message = (
            "what counts of undecided motions are numbers measured of them; they have no class"
        )
        allowed = 'it left out; or of = { undecided = "counts", ... } in an analysis `boundary`'
        report.add((*place, "undecided"), message, allowed)
    _check_expected(claim, known, place, report)
    for key, reference in references_of(claim).items():
        at = (*place, "expect", key)
        elsewhere = {} if reference.case else _known_of(reference, case, held, at, report)
        if elsewhere:
            _check_compared(claim, reference, known, elsewhere, at, report)


def _refuse_ambiguous(name: str, analysis: str, held: Held, place: Path, report: Report) -> None:
    """Note a variable that several analyses have, where none is named: it is not one thing."""
    homes = [one for one, own in held.items() if own and name in [v.name for v in own]]
    if not analysis and len(homes) > 1:
        message = f"{name!r} is of several analyses"
        report.add(place, message, " or ".join(f'analysis = "{home}"' for home in homes))


def references_of(claim: ClaimSpec) -> Mapping[str, Reference]:
    """Key of the table ``expect`` of a claim -> what it compares with."""
    return claim.expect.references if isinstance(claim.expect, Bounds) else {}


def known_in(case: Case) -> dict[str, Variable | None]:
    """Everything that stands in the dataset of a case without mistakes."""
    held = {spec.name: _variables(case, spec, True) for spec in case.analyses}
    return _known(case, held, None, with_motions=False)


def _known_of(
    said: ClaimSpec | Reference, case: Case, held: Held, place: Path, report: Report
) -> Mapping[str, Variable | None]:
    """All that stands where a claim looks; nothing, and a note, where its variable does not."""
    known = _known(case, held, said.analysis, with_motions=False)
    asked = said.variable, said.analysis, known, held, (*place, "variable")
    if not known or _of_another(*asked, report):
        return {}
    if not _check(said.variable, known, (*place, "variable"), report):
        return {}
    if said.take:
        _check_taken(said.take, said.variable, known, (*place, "take"), report)
    places = _places(case, held, said.analysis, said.variable)
    if places is None:
        return known
    beside = [one for one in held[places.name] or () if one.name not in places.own]
    axes = [*places.grid, *places.own]
    of_results = _check_narrowed(said, known, beside, axes, (*place, "at"), report)
    on_axes = {name: wanted for name, wanted in said.at.items() if name not in of_results}
    places.check(on_axes, (*place, "at"), report)
    if said.take:
        over, reference = said.take["over"], said.take.get("relative_to", {})
        places.check_over(over, known[said.variable], (*place, "take", "over"), report)
        places.check(reference, (*place, "take", "relative_to"), report)
    has_trend = isinstance(said, ClaimSpec) and isinstance(said.expect, Trend)
    if has_trend and report.is_sound((*place, "at")):
        over = said.take["over"] if said.take else ()
        places.check_trend(on_axes, over, (*place, "expect"), report)
    return known


def _check_narrowed(
    said: ClaimSpec | Reference,
    known: Mapping[str, Variable | None],
    beside: Sequence[Variable],
    axes: Sequence[str],
    place: Path,
    report: Report,
) -> Sequence[str]:
    """The results to whose classes a claim narrows; notes where these are not beside each value."""
    results = [one for one in beside if one.name in said.at]
    trend = isinstance(said, ClaimSpec) and isinstance(said.expect, Trend)
    refused = [one for one in results if _classes(one)] if said.take or trend else []
    for one in refused:
        message = "a result narrows what is tried value by value, no trend and nothing taken"
        report.add((*place, one.name), message, f"of axes: {listed(axes)}")
    if refused:
        return [one.name for one in results]
    return _check_classes("claim", said.at, known[said.variable], beside, place, report)


def _check_classes(
    what: str,
    wanted: Mapping[str, Any],
    own: Variable | None,
    beside: Sequence[Variable],
    place: Path,
    report: Report,
) -> Sequence[str]:
    """The results to whose classes something narrows; notes where they are not beside each value.

    Parameters
    ----------
    wanted : name -> classes, of results; the rest is of axes
    own : the variable whose values are narrowed
    beside : variables of the same analysis
    """
    results = [one for one in beside if one.name in wanted]
    for one in results:
        at, classes, asked = (*place, one.name), _classes(one), wanted[one.name]
        fits = own is not None and _is_beside(one, own)
        if not classes:
            message = f"{one.name!r} is a number, and no axis: a {what} is narrowed to classes"
            report.add(at, message, listed([v.name for v in beside if _classes(v)]))
        elif not fits:
            name = own.name if own else "what is shown"
            message = f"{one.name!r} does not stand beside each value of {name!r}"
            fitting = [v.name for v in beside if not _classes(v) and _is_beside(one, v)]
            report.add(at, message, f"beside those of {listed(fitting)}" if fitting else "")
        else:
            for name in asked if isinstance(asked, list) else [asked]:
                _check_class(one.name, classes, str(name), at, report)
    return [one.name for one in results]


def _is_beside(one: Variable, own: Variable) -> bool:
    """Whether each value of a variable, `own`, has one of another."""
    return one.ragged in ("", own.ragged) and {*one.dims} <= {*own.dims}


def _check_compared(
    claim: ClaimSpec,
    reference: Reference,
    known: Mapping[str, Variable | None],
    elsewhere: Mapping[str, Variable | None],
    place: Path,
    report: Report,
) -> None:
    """Note what cannot be compared: a class, several numbers at a point, another unit."""
    sides = ((one.variable, one.analysis, one.take) for one in (claim, reference))
    if not reference.at and next(sides) == next(sides) and report.is_sound(place):
        report.add(place, "is what the claim itself is about", "at = { AXIS = VALUE }, elsewhere")
    one, other = known[claim.variable], elsewhere[reference.variable]
    if other is None:
        return
    check_number(other, claim, reference, place, report)
    if report.is_sound(place) and one is not None and not (claim.take or reference.take):
        _check_units(one, other, reference.times, place, report)


def check_number(
    other: Variable,
    claim: ClaimSpec,
    reference: Reference,
    place: Path,
    report: Report,
    foreign: Mapping[str, object] | None = None,
) -> None:
    """Note what is not one number at each point, with which alone a claim can compare.

    `foreign` : axes of the other case alone -> their first value
    """
    wanted: dict[str, object] = {**dict.fromkeys(other.dims, 0), **(foreign or {})}
    several = {dim: at for dim, at in wanted.items() if dim not in {*claim.at, *reference.at}}
    if reference.take:
        return
    if other.kind == "flag":
        message = f"{other.name!r} holds a class, with which no number is compared"
        report.add((*place, "variable"), message)
    elif other.ragged or several:
        message = f"{other.name!r} has several values at a point"
        said = "one value at each point"
        if several:
            one_of_all = f'take = {{ what = "greatest", over = "{next(iter(several))}" }}'
            one_of_all = f"; or, of those that exist, {one_of_all}" * (len(several) == 1)
            told = {"case": reference.case, "variable": other.name, "analysis": reference.analysis}
            table: dict[str, Any] = {key: word for key, word in told.items() if word}
            table["at"] = {**reference.at, **several}
            table |= {"times": reference.times} if reference.times != 1.0 else {}
            first = f"{place[-1]} = {toml_value(table, str(place[-1]))}"
            said = f"{first}, or that `at` for both sides{one_of_all}"
        report.add(place, message, said)


def _check_units(one: Variable, other: Variable, times: float, place: Path, report: Report) -> None:
    """Note numbers that do not measure the same, or do in units of which no factor makes one."""
    if one.units == other.units:
        return
    message = f"{other.name!r} is in {other.units}, {one.name!r} in {one.units}"
    try:
        unit, of_other = parse_unit(one.units), parse_unit(other.units)
    except ValueError:  # of a model from outside
        return
    if not of_other.fits(unit):
        report.add(place, message, "a variable of the same unit")
    elif times == 1.0:
        report.add(place, message, f"times = {float(of_other.factor / unit.factor):.12g}")


def _check_drawn(
    figure: FigureSpec,
    name: str,
    known: Mapping[str, Variable | None],
    places: Places | None,
    place: Path,
    report: Report,
) -> None:
    """Note what a figure of this kind cannot draw of the variable at `place`, and points that it
    has not."""
    table = place[:-1]
    variable, take = known[name], figure.settings.get("take")
    if take:
        _check_taken(take, name, known, (*table, "take"), report)
    elif variable is not None and figure.kind in RAGGED and RAGGED[figure.kind] != variable.ragged:
        wanted = "the values at a section" if RAGGED[figure.kind] else "one value at each point"
        message = f"{name!r} cannot be drawn as a {figure.kind}, which shows {wanted}"
        meant = _shown_by(variable) + _at_section(name, known)
        report.add(place, message, _drawable(known, RAGGED[figure.kind]), meant)
    if places is not None and figure.kind not in OF_MOTIONS and take:
        places.check_over(take["over"], variable, (*table, "take", "over"), report)


def _at_section(name: str, known: Mapping[str, Variable | None]) -> str:
    """How the extremes of a state come to be the values at a section; "" of what is none."""
    state = re.sub("_(min|max|amplitude)$", "", name)
    if state == name or f"{state}_dot" not in map(_stem, known) or "section_value" not in known:
        return ""
    section = f'observe = "{state}" and section = {{ zero = "{state}_dot" }}'
    return f"; every value at which {state} turns back: {section} in the analysis"


def _stem(name: str) -> str:
    return re.sub("_(min|max|rms)$", "", name)


def _refuse_motion(kind: str, name: str, held: Held, place: Path, report: Report) -> None:
    """Note what has a value at each instant only: a figure of points shows one of each."""
    found = [one for variables in held.values() for one in variables or () if one.name == name]
    if found and all("time" in one.dims for one in found):
        message = f"{name!r} varies along a motion, and a {kind} shows one value at each point"
        report.add(place, message, 'it in a figure of kind "history" or "phase", or with take')


def _kinds(known: Mapping[str, Variable | None]) -> str:
    """The kinds of figures that analyses with these variables can be drawn as."""
    every = get_args(FigureKind)
    return listed([kind for kind in every if SHOWN.get(kind, "status") in known])


def _drawable(known: Mapping[str, Variable | None], ragged: str) -> str:
    return listed([v.name for v in known.values() if v and v.ragged == ragged and not v.dims])


def _places(case: Case, held: Held, analysis: str | None, variable: str) -> Places | None:
    """The axes of the analysis that a figure or a claim speaks of: the first with the variable."""
    for spec in case.analyses:
        variables = held[spec.name] or ()
        if spec.name == (analysis or spec.name) and variable in [v.name for v in variables]:
            return Places.of(case, spec, variables)
    return None


def _check_refined(case: Case, held: Held, report: Report) -> None:
    """Note that no analysis has the class whose borders are refined."""
    if case.refinement is None or None in held.values():
        return
    name = case.refinement.of
    told = [variable for variables in held.values() for variable in variables or ()]
    classes = sorted({variable.name for variable in told if variable.is_class})
    if name not in classes:
        message = f"no analysis of this case has a class {name!r}"
        report.unknown(("sweep", "refine", "of"), message, name, classes)


def _variables(case: Case, spec: AnalysisSpec, understood: bool) -> Sequence[Variable] | None:
    model, analysis = get_model(case.model), get_analysis(spec.kind)
    if analysis.unsuited(model):
        return None
    needed = (one.name for one in analysis.settings if one.required)
    sound = understood and all(spec.settings.get(name) is not None for name in needed)
    settings = spec.settings if sound else ALL_ASKED
    of_laws = case.varying, case.internal, case.reach
    stored = variables_of(spec.kind, model, case.options, settings, *of_laws)
    return (*stored, *derived(stored))


def _named(said: str | list[str]) -> list[str]:
    return [said] if isinstance(said, str) else said


def _known(
    case: Case, held: Held, analysis: str | None, with_motions: bool
) -> dict[str, Variable | None]:
    """Everything that stands in the dataset of the case, or of one of its analyses.

    Nothing where there is no such analysis. A figure may also be drawn of a motion that
    ``fiv history`` computes (`with_motions`).
    """
    chosen = [held.get(name) for name in ([analysis] if analysis else held)]
    found: dict[str, Variable | None] = dict.fromkeys(
        [*(axis.dim for axis in case.axes), COMPUTED.name]
    )
    for variables in chosen:
        if variables is None:
            return {}
        found |= {f"{v.ragged}_row_size": None for v in variables if v.ragged}
        found |= {variable.name: variable for variable in variables}
    if with_motions:  # which have a force at each instant, an equilibrium but one
        model, internal = get_model(case.model), case.internal
        own = variables_of("history", model, case.options, {}, internal=internal)
        found |= {variable.name: variable for variable in own}
    return found


def _of_another(
    name: str,
    analysis: str | None,
    known: Mapping[str, Variable | None],
    held: Held,
    place: Path,
    report: Report,
) -> bool:
    """Whether a variable is of other analyses of the case than the one that is named; notes it."""
    homes = [one for one, own in held.items() if own and name in [v.name for v in own]]
    is_other = bool(analysis and homes and known) and name not in known
    if is_other:
        message = f"the analysis {analysis!r} does not compute {name!r}"
        report.add(place, message, " or ".join(f'analysis = "{home}"' for home in homes))
    return is_other


def _check(name: str, known: Mapping[str, Variable | None], place: Path, report: Report) -> bool:
    """Whether there is such a variable; notes where there is none."""
    if name not in known:
        variables = {v.name: v.long_name for v in known.values() if v is not None}
        message = f"no analysis of this case computes {name!r}"
        told = f"`fiv variables {report.source}` says what each is"
        if ":" in name:
            case, _, of_it = name.partition(":")
            told = f'what another case found is held against: expect = {{ less_than = "{name}" }}'
            told = f'case = "{case}", variable = "{of_it}"' if "expect" in place else told
        meant = _of_one_contact(name, known, place) or variable_meant(name, variables)
        if name in ("share", "shares") and "attractor" in variables:
            each = f', of = "{EACH}"' if place[0] == "figure" else ', of = "CLASS"'
            meant = f'variable = "attractor", take = {{ what = "share"{each}, over = "initial" }}'
            meant += ", or over an axis" + ": in a curve or map" * (place[0] == "figure")
        meant = meant or suggest(name, variables)
        if given := computed_by(name):
            meant = f"{meant or told}; {given}"
        said, held = told if ":" in name else meant or told, [*variables]
        if place[0] == "claim" and (dims := _own_dims(known)):
            held = [f"{one} [{', '.join(dims[one])}]" if one in dims else one for one in variables]
            first = next(iter(dims.values()))[0]
            said += f"; of what has [{first}], at = {{ {first} = 0 }} tells which"
        report.unknown(place, message, name, held, said)
    return name in known


def _own_dims(known: Mapping[str, Variable | None]) -> dict[str, tuple[str, ...]]:
    """The dims over which a variable has several values at a point, of each that has some."""
    told = (variable for variable in known.values() if variable is not None)
    return {one.name: tuple(one.dims) for one in told if one.dims}


def _of_one_contact(name: str, known: Mapping[str, Variable | None], place: Path) -> str:
    """What to write for the value of a numbered contact, such as ``F_T_1``; "" for what is none."""
    parts = re.fullmatch(r"(\w*?)_?(\d+)", name)
    variable = known.get(parts[1]) if parts else None
    if parts is None or variable is None or "contact" not in variable.dims:
        return ""
    if place[0] == "claim":
        where = f"at = {{ contact = {parts[2]} }}"
    elif "time" in variable.dims:
        where = f"contact = {parts[2]}"
    else:
        where = f"select = {{ contact = {parts[2]} }}"
    key = "variable" if place[0] == "claim" else place[-1]
    return f'write {key} = "{parts[1]}", {where}'


def _check_expected(
    claim: ClaimSpec, known: Mapping[str, Variable | None], place: Path, report: Report
) -> None:
    """Note a class that is expected of a number, and a number that is expected of a class."""
    name, classes, at = claim.variable, _classes(known[claim.variable]), (*place, "expect")
    if claim.take:
        name, classes = claim.take["what"], []
    if not isinstance(claim.expect, OfClass):
        if classes:
            message = f"{name!r} holds a class, not a number"
            report.add(at, message, f'{listed(classes)}, or "not CLASS"')
    elif classes:
        _check_class(name, classes, claim.expect.name, at, report)
    else:
        message = f"{name!r} is a number and has no class {claim.expect.name!r}"
        forms = '"increasing", "decreasing", { value, tolerance }, { less_than }, '
        forms += "{ greater_than } or { between }"
        report.add(at, message, forms)


def _check_taken(
    take: Mapping[str, Any],
    name: str,
    known: Mapping[str, Variable | None],
    place: Path,
    report: Report,
) -> None:
    """Note a class that is counted of a number, and a number that is taken of a class."""
    classes, of, what = _classes(known[name]), take.get("of", ""), take["what"]
    if classes and not of and what != "classes":
        message = f"{name!r} holds a class, of which there is no {what}"
        report.add((*place, "what"), message, listed([*COUNTED, "classes"]))
    elif what == "classes" and not classes:
        message = f"{name!r} is a number and has no classes"
        report.add((*place, "what"), message, "spread: the greatest less the least")
    elif classes and of == EACH and what == "share" and place[0] == "figure":
        return
    elif classes and of:
        for one in of if isinstance(of, list) else [of.removeprefix("not ")]:
            _check_class(name, classes, one, (*place, "of"), report)
    elif of and (isinstance(of, list) or not parse_condition(of)):
        message = f"{name!r} is a number and has no class {of!r}"
        report.add((*place, "of"), message, 'a condition such as ". > 0"')


def _check_class(
    name: str, classes: Sequence[str], wanted: str, place: Path, report: Report
) -> None:
    if wanted not in classes:
        report.unknown(place, f"{name!r} has no class {wanted!r}", wanted, classes)


def _classes(variable: Variable | None) -> list[str]:
    """What a flag may say; nothing of a number."""
    return list(TABLES[variable.flags].codes) if variable and variable.kind == "flag" else []


def _check_contact(figure: FigureSpec, contacts: int, place: Path, report: Report) -> None:
    """Note contacts that the model has not, and several where one is drawn."""
    said = figure.settings.get("contact", [])
    selected = figure.settings.get("select", {}).get("contact", [])
    for at, wanted in ((("contact",), said), (("select", "contact"), selected)):
        numbers = wanted if isinstance(wanted, list) else [wanted]
        for number in [one for one in numbers if one not in range(1, contacts + 1)]:
            if not isinstance(number, str):
                report.add((*place, *at), f"there is no contact {number}", f"1 to {contacts}")
    if isinstance(said, list) and len(said) > 1 and figure.kind != "history":
        report.add((*place, "contact"), f"a {figure.kind} shows one contact", "a figure for each")


def _check_scale(figure: FigureSpec, place: Path, report: Report) -> None:
    """Note limits that a logarithmic axis cannot have, and shades where there are none."""
    log = figure.settings.get("log", False)
    if "z" in str(log) and figure.kind != "map":
        report.add((*place, "log"), f"a {figure.kind} has no shades", 'true, "x", "y" or "xy"')
    logarithms = "xy" if log is True else log or ""
    for which in "xyz":
        limits = figure.settings.get(f"{which}lim", ())
        numbers = [bound for bound in limits if isinstance(bound, int | float)]
        if which in logarithms and any(bound <= 0 for bound in numbers):
            message = f"a logarithmic axis begins above 0, not at {min(numbers)!r}"
            report.add((*place, f"{which}lim"), message, "[low, high] with 0 < low")
