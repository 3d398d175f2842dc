"""What the engine's tests share: systems and motions in one line."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fiv_cli.analyses.base import SolverSettings
from fiv_cli.analyses.common import Balance, balance
from fiv_cli.codegen.codes import CODE_NAMES
from fiv_cli.codegen.setup import Setup, default_parameters
from fiv_cli.dynamics.motion import Motion, Stop
from fiv_cli.dynamics.system import System, build_system
from fiv_cli.models.base import Model
from fiv_cli.schedule import make_schedule

TIGHT = SolverSettings(rtol=1e-13)
Curves = Mapping[str, Sequence[tuple[float, float]]]
NO_CURVES: Curves = {}


def defaults(model: str | Model, law: str, **changes: float) -> dict[str, float]:
    """Every parameter of a model with a law at its default, SI."""
    setup = Setup.of(model, law)
    return default_parameters(setup.model, setup.law, **changes)


def system(
    model: str | Model,
    law: str = "coulomb",
    options: Mapping[str, str] | None = None,
    rtol: float = TIGHT.rtol,
    parameters: Mapping[str, float] | None = None,
    curves: Curves = NO_CURVES,
) -> System:
    """A compiled system; `parameters` gives the law's structural values, `curves` what varies."""
    return build_system(Setup.of(model, law, options, parameters, rtol, make_schedule(curves)))


def motion(
    model: str | Model,
    law: str = "coulomb",
    start: Mapping[str, float] | None = None,
    solver: SolverSettings = TIGHT,
    options: Mapping[str, str] | None = None,
    time: float = 0.0,
    curves: Curves = NO_CURVES,
    **changes: float,
) -> Motion:
    """A motion from `start` with a ledger of 20,000 rows; `changes` differ from the defaults."""
    parameters = defaults(model, law, **changes)
    built = system(model, law, options, solver.rtol, parameters, curves)
    begun = Motion(built, parameters, solver, start or {}, time)
    begun.keep_ledger(20_000)
    return begun


def ledger(moved: Motion) -> NDArray[np.float64]:
    """Rows (time, from, to, contact, residual) of the events so far."""
    return np.column_stack(moved.ledger)


def times(moved: Motion) -> NDArray[np.float64]:
    """Event times so far, s."""
    return ledger(moved)[:, 0]


def booked(begun: Motion, t_end: float) -> Balance:
    """The energy balance of a motion taken to `t_end`."""
    begun.start_measuring(np.zeros(len(begun.system.coordinates)))
    before = begun.energy()
    assert begun.run(t_end, measuring=True) == Stop.REACHED
    return balance(begun, before)


def by_both(t_end: float, step: float, *given: Any, **named: Any) -> tuple[Motion, Motion]:
    """A motion to `t_end` by the series and by rk4 of this step; both meet the same events."""
    solvers = (TIGHT, SolverSettings("rk4", TIGHT.rtol, step))
    exact, rough = (motion(*given, solver=solver, **named) for solver in solvers)
    assert exact.run(t_end) == rough.run(t_end) == Stop.REACHED
    assert transitions(exact) == transitions(rough)
    np.testing.assert_allclose(times(exact), times(rough), atol=1e-8)
    return exact, rough


def transitions(moved: Motion) -> list[str]:
    """Events so far in words, with the contact's number where there are several."""
    several, names = moved.system.n_contacts > 1, (*CODE_NAMES, *moved.system.setup.law.events)
    return [
        f"{names[int(row[1])]}->{names[int(row[2])]}" + f" {int(row[3])}" * several
        for row in ledger(moved)
    ]
