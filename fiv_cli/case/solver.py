"""The table ``[solver]``: how motions are integrated."""

from __future__ import annotations

from fiv_cli.analyses.base import SolverSettings
from fiv_cli.case.form import Form
from fiv_cli.case.report import Report
from fiv_cli.notation.units import convert


def read_solver(form: Form, report: Report) -> SolverSettings:
    """The solver settings, defaults filled in."""
    table, step = form.solver, SolverSettings().step
    with report.noting(("solver", "step"), "a number in s, > 0 (step of rk4)"):
        step = convert(table.step, "s")
        if step <= 0:
            raise ValueError(f"{step!r} is out of range")
    return SolverSettings(
        method=table.method,
        rtol=float(table.rtol),
        step=step,
        max_events=table.max_events,
        max_steps=table.max_steps,
    )
