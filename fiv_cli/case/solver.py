"""The table ``[solver]``: how motions are integrated."""

from __future__ import annotations

from fiv_cli.analyses.base import SolverSettings
from fiv_cli.case.form import Form
from fiv_cli.case.report import Report
from fiv_cli.case.structure import SolverTable
from fiv_cli.notation.units import convert

_RTOL = (1e-15, 1e-3)


def read_solver(form: Form, report: Report) -> SolverSettings:
    """The solver settings, defaults filled in."""
    table = form.solver
    if not _RTOL[0] <= table.rtol <= _RTOL[1]:
        report.add(
            ("solver", "rtol"), f"{table.rtol!r} is out of range", f"{_RTOL[0]:g} to {_RTOL[1]:g}"
        )
    for key in ("max_events", "max_steps"):
        if getattr(table, key) < 1:
            report.add(
                ("solver", key), f"{getattr(table, key)} is out of range", "a whole number >= 1"
            )
    return SolverSettings(
        method=table.method,
        rtol=float(table.rtol),
        step=_step(table, report),
        max_events=table.max_events,
        max_steps=table.max_steps,
    )


def _step(table: SolverTable, report: Report) -> float:
    try:
        step = convert(table.step, "s")
        if step <= 0:
            raise ValueError(f"{step!r} is out of range")
    except ValueError as error:
        report.add(("solver", "step"), str(error), "a number in s, > 0 (step of rk4)")
        return SolverSettings().step
    return step
