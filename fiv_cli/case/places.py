"""Whether what figures and claims select lies on the axes of the analysis that they speak of."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from fiv_cli.analyses import get_analysis
from fiv_cli.analyses.catalogue import every_variable
from fiv_cli.analyses.variables import Variable
from fiv_cli.case.case import AnalysisSpec, Axis, Case
from fiv_cli.case.grammar import SAME, Test, parse_condition
from fiv_cli.case.report import Path, Report
from fiv_cli.models import get_model
from fiv_cli.notation.names import listed

NUMERIC = ("parameter", "start", "number")  # kinds of axes


@dataclass(frozen=True)
class Places:
    """The axes of one analysis.

    Attributes
    ----------
    name : of the analysis
    grid : name -> axis of the grid
    own : those that its variables have besides, and ``initial``
    leads : name -> the first of the axes that advance together with it
    contact : that of the contacts of the model, from 1
    is_shortened : whether the grid is another than that of the file, by ``--set``: then a claim
        may speak of points that are not there
    """

    name: str
    grid: Mapping[str, Axis]
    own: Sequence[str]
    leads: Mapping[str, str]
    contact: Axis
    is_shortened: bool

    @classmethod
    def of(cls, case: Case, spec: AnalysisSpec, variables: Sequence[Variable]) -> Places:
        """The axes of an analysis of a case, of its variables all that they have."""
        starts = get_analysis(spec.kind).uses_starts
        grid = {a.name: a for a in case.axes if starts or a.kind != "start"}
        own = dict.fromkeys(dim for variable in variables for dim in variable.dims)
        shortened = any(line.startswith(("grid.", "sweep.")) for line in case.overrides)
        contact = Axis("contact", "number", tuple(range(1, 1 + get_model(case.model).contacts)))
        names = [*(["initial"] if starts else []), *own]
        leads = {name: group[0] for group in case.zips for name in group}
        return cls(spec.name, grid, names, leads, contact, shortened)

    def check(self, selection: Mapping[str, Any], place: Path, report: Report) -> None:
        """Note axes that the analysis has not, and values off the grid."""
        for name, wanted in selection.items():
            if name not in (*self.grid, *self.own):
                message = f"the analysis {self.name!r} has no axis {name!r}"
                hint = "a result narrows what is drawn, or claimed, of its own analysis alone"
                axes = listed([*self.grid, *self.own])
                report.add((*place, name), message, axes, hint * (name in every_variable()))
            elif name == self.contact.name:
                _check_values(self.contact, wanted, (*place, name), report)
            elif name in self.grid and not self.is_shortened and report.is_sound(("grid", name)):
                _check_values(self.grid[name], wanted, (*place, name), report)

    def check_trend(
        self, at: Mapping[str, Any], over: Sequence[str], place: Path, report: Report
    ) -> None:
        """Note that not one numeric axis alone is left, along which something would rise or fall.

        Others are narrowed by ``at``, or something is taken over them.
        """
        narrowed = {
            self.leads.get(name, name)
            for name, axis in self.grid.items()
            if name in over or len(_met(axis, at.get(name, [*axis.values]))) == 1
        }
        numeric = [name for name, axis in self.grid.items() if axis.kind in NUMERIC]
        every = dict.fromkeys(self.leads.get(name, name) for name in numeric)
        left = [name for name in every if name not in narrowed]
        if len(left) != 1 and not self.is_shortened:
            message = f"a trend is along one numeric axis, and left are {listed(left)}"
            report.add(place, message, "all others narrowed to one value each by `at`")

    def check_over(
        self, over: Sequence[str], variable: Variable | None, place: Path, report: Report
    ) -> None:
        """Note axes along which the variable has no values."""
        if variable is not None and variable.ragged:
            message = f"{variable.name!r} has any number of values at a point, and no axis of them"
            report.add(place, message, "a variable with one value at each place along the axes")
            return
        known = [*self.grid, *(set(self.own) & {"initial"}), *(variable.dims if variable else ())]
        for name in over:
            if name not in known:
                message = f"{variable.name if variable else self.name!r} has no axis {name!r}"
                report.add(place, message, listed(known))


def _check_values(axis: Axis, wanted: Any, place: Path, report: Report) -> None:
    """Note values that are not on an axis."""
    for one in _missed(axis, wanted):
        report.add(place, f"{one!r} is not on the axis {axis.name}", _extent(axis, one))


def _missed(axis: Axis, wanted: Any) -> Iterator[Any]:
    """What of a selection meets no value of the axis."""
    return (one for one in _each(wanted) if not _met(axis, one))


def _met(axis: Axis, wanted: Any) -> list[Any]:
    """The values of an axis that a selection meets."""
    return [
        value for value in axis.values if any(_meets(axis, value, one) for one in _each(wanted))
    ]


def _each(wanted: Any) -> list[Any]:
    return wanted if isinstance(wanted, list) else [wanted]


def _meets(axis: Axis, value: Any, wanted: Any) -> bool:
    numeric = axis.kind in NUMERIC
    tests = parse_condition(wanted) if numeric and isinstance(wanted, str) else ()
    if tests:
        return all(_holds(value, test) for test in tests)
    return _is(value, wanted, numeric)


def _is(value: Any, wanted: Any, numeric: bool) -> bool:
    return abs(value - wanted) <= SAME * abs(wanted) if numeric else bool(value == wanted)


def _holds(value: float, test: Test) -> bool:
    sign, bound = test
    if _is(value, bound, True):
        return sign in ("<=", ">=", "==")
    return (value < bound and "<" in sign) or (value > bound and ">" in sign) or sign == "!="


def _extent(axis: Axis, wanted: Any) -> str:
    if axis.kind not in NUMERIC or len(axis.values) <= 8:
        return listed([str(value) for value in axis.values])
    told = f"{len(axis.values)} values from {min(axis.values):g} to {max(axis.values):g}"
    if isinstance(wanted, str):
        return told
    return f"{told}; the nearest is {min(axis.values, key=lambda value: abs(value - wanted))!r}"
