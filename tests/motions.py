"""What the engine's tests share: systems and motions in one line."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fiv_cli.analyses import get_analysis
from fiv_cli.analyses.base import Outcome, SolverSettings, Start
from fiv_cli.codegen.generate import generate
from fiv_cli.dynamics.motion import CODE_NAMES, Motion
from fiv_cli.dynamics.system import System, taylor_order
from fiv_cli.friction import get_law
from fiv_cli.models import get_model
from fiv_cli.models.base import Model

TIGHT = SolverSettings(rtol=1e-13)


def model_of(model: str | Model) -> Model:
    """A model of the program by name, or one of the test suite itself."""
    return get_model(model) if isinstance(model, str) else model


def defaults(model: str | Model, law: str, **changes: float) -> dict[str, float]:
    """Every parameter of a model with a law at its default, SI."""
    table = model_of(model)
    own = (*table.parameters, *table.adopted(get_law(law).parameters))
    given = {p.name: p.default for p in own if p.default is not None} | changes
    follow = {p.name: given[p.default_from] for p in own if p.default_from in given}
    return follow | given


_BUILT: dict[tuple[Any, ...], System] = {}


def system(
    model: str | Model,
    law: str = "coulomb",
    options: Mapping[str, str] | None = None,
    rtol: float = TIGHT.rtol,
    parameters: Mapping[str, float] | None = None,
) -> System:
    """A compiled system; `parameters` gives the law's structural values."""
    table, friction, order = model_of(model), get_law(law), taylor_order(rtol)
    given = parameters or defaults(model, law)
    structural = {name: given[name] for name in friction.structural}
    chosen = table.default_options() | dict(options or {})
    key = (table.name, law, tuple(chosen.items()), tuple(structural.items()), order)
    if key not in _BUILT:
        generated = generate(table, friction, chosen, structural, order)
        _BUILT[key] = System(table, friction, chosen, generated)
    return _BUILT[key]


def motion(
    model: str | Model,
    law: str = "coulomb",
    start: Mapping[str, float] | None = None,
    solver: SolverSettings = TIGHT,
    options: Mapping[str, str] | None = None,
    time: float = 0.0,
    **changes: float,
) -> Motion:
    """A motion from `start` with a ledger of 20,000 rows; `changes` differ from the defaults."""
    parameters = defaults(model, law, **changes)
    built = system(model, law, options, solver.rtol, parameters)
    begun = Motion(built, parameters, solver, start or {}, time)
    begun.keep_ledger(20_000)
    return begun


def ledger(moved: Motion) -> NDArray[np.float64]:
    """Rows (time, from, to, contact, residual) of the events so far."""
    return np.column_stack(moved.ledger)


def times(moved: Motion) -> NDArray[np.float64]:
    """Event times so far, s."""
    return ledger(moved)[:, 0]


def transitions(moved: Motion) -> list[str]:
    """Events so far in words, with the contact's number where there are several."""
    several = moved.system.n_contacts > 1
    return [
        f"{CODE_NAMES[int(row[1])]}->{CODE_NAMES[int(row[2])]}" + f" {int(row[3])}" * several
        for row in ledger(moved)
    ]


def analyse(
    model: str | Model,
    law: str,
    analysis: str,
    start: Mapping[str, float] | Start | None = None,
    settings: Mapping[str, Any] | None = None,
    solver: SolverSettings | None = None,
    options: Mapping[str, str] | None = None,
    **changes: float,
) -> Outcome:
    """One outcome of an analysis from the defaults."""
    solver = solver or SolverSettings()
    parameters = defaults(model, law, **changes)
    kind = get_analysis(analysis)
    filled = {item.name: item.default for item in kind.settings} | dict(settings or {})
    begin = start if start is None or isinstance(start, Start) else Start("a", "state", start)
    built = system(model, law, options, solver.rtol, parameters)
    return kind.run(built, parameters, begin, filled, solver)
