"""Models and laws from outside, tried as those in the box are.

Of each: whether its equations are sound; and of a model under its own law and those from outside,
of a law on a model of the box, whether energy is booked to rounding, whether derivatives agree with
differences, and whether two ways of integrating give one motion. Then what a file holds to be
known, in a function ``verify(bench)`` that yields `Check`.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from functools import partial
from math import nan
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fiv_cli import api
from fiv_cli.analyses.base import Outcome, SolverSettings, Start
from fiv_cli.analyses.common import sliding
from fiv_cli.codegen.setup import Setup, default_parameters
from fiv_cli.dynamics.system import build_system
from fiv_cli.friction import TANH_OF, all_laws, get_law, laws_of
from fiv_cli.friction.base import Law
from fiv_cli.models import all_models
from fiv_cli.models.base import Model
from fiv_cli.models.origin import Origin
from fiv_cli.own.check import asymmetry, problems_of
from fiv_cli.own.lines import Lines
from fiv_cli.own.load import module_of
from fiv_cli.own.mechanics import fed_by_damping
from fiv_cli.verify import RTOL, Bench, Check, solve

PERIODS = 5.0  # of the slowest mode, that a motion is followed
STEPS = 400.0  # of rk4 in a period of the fastest mode, at first
HALVINGS = 4  # of its steps, where a law turns within one: a wrong motion does not agree by them
DECAY, MOST = 10.0, 1e6  # of them while what decays fastest falls to 1/e, and in all
BEGUN = 0.7  # of the speed of the drive, at the start
BALANCED, DERIVED, SAME = 1e-10, 1e-6, 1e-6  # largest relative errors
NUDGE = 0.01  # of a coordinate or velocity, over its size, for differences


def try_own(announce: Callable[[str], None] = lambda message: None) -> list[Check]:
    """The checks of every model and law from outside that is known, computed now."""
    known: Sequence[Model | Law] = (*all_models().values(), *all_laws().values())
    own = [t for t in known if t.origin is not None and not t.name.startswith(TANH_OF)]
    bench = partial(api.analyse, solver=SolverSettings(rtol=RTOL), announce=announce)
    for thing in own:
        if remark := asymmetry(thing) if isinstance(thing, Law) else fed_by_damping(thing):
            announce(remark)
    checks = [check for thing in own for check in solve(partial(_trial, thing), bench)]
    for origin in dict.fromkeys(thing.origin for thing in own if thing.origin):
        checks += solve(partial(_of_file, origin), bench)
    return checks


def _of_file(origin: Origin, bench: Bench) -> Iterator[Check]:
    """What a file holds to be known; of what cannot be computed, the line."""
    try:
        found = getattr(module_of(origin), "verify", lambda bench: ())(bench)
        for check in found if isinstance(found, Iterable) else (found,):
            if not isinstance(check, Check):
                raise TypeError(f"verify is to yield Check(...), not {type(check).__name__}")
            yield check
    except Exception as error:
        wrong = Lines(origin.text).problem(error, origin.path)
        what = f"{origin.path}:{wrong.line}: {wrong.path}: {wrong.message}"
        yield Check(what, "not computed", nan, nan, 0.0)


def _trial(thing: Model | Law, bench: Bench) -> Iterator[Check]:
    """What holds of every model, and of every law on a model."""
    assert thing.origin is not None
    source = f"{thing.origin.path}: {thing.name}"
    sound = float(not problems_of(thing, thing.origin))
    yield Check("names, units, energies of the equations (1 sound)", source, sound, 1.0, 0.0)
    for model, law in _pairs(thing):
        yield from _of_pair(model, law, bench, f"{thing.origin.path}: {model.name} with {law.name}")


def _of_pair(model: Model, law: Law, bench: Bench, source: str) -> Iterator[Check]:
    """What holds of a model under a law."""
    if not model.contacts:
        return
    parameters = _example(model)
    names, found, differences = _jacobians(model, law, parameters)
    wrong = np.abs(found - differences) / (np.abs(differences).max(axis=0) + 1.0)
    row, column = np.unravel_index(np.argmax(wrong), wrong.shape)
    name = f"derivatives against differences, worst: rate of {names[row]} by {names[column]}"
    yield Check(name, source, float(wrong[row, column]), 0.0, DERIVED)
    yield from _of_motion(model, law, parameters, np.linalg.eigvals(found), bench, source)


def _pairs(thing: Model | Law) -> list[tuple[Model, Law]]:
    """A model under its law and those from outside; a law on the first model that takes it."""
    if isinstance(thing, Law):
        known = all_models().values()
        return [next((model, thing) for model in known if thing.name in laws_of(model))]
    own = [n for n in laws_of(thing) if get_law(n).origin and not n.startswith(TANH_OF)]
    return [(thing, get_law(name)) for name in dict.fromkeys([thing.default_law, *own])]


def _example(model: Model) -> dict[str, float]:
    """Parameters under which the model vibrates, if it says so."""
    if model.example is None:
        return {}
    given = {n: v for n, v in model.example.given.items() if not isinstance(v, str)}
    return {**given, model.example.axis: model.example.middle}


def _jacobians(
    model: Model, law: Law, changes: Mapping[str, float]
) -> tuple[tuple[str, ...], NDArray[np.float64], NDArray[np.float64]]:
    """Names of the states, and the derivatives of their rates, exact and by differences."""
    parameters = default_parameters(model, law, **changes)
    state = sliding(build_system(Setup.of(model, law, parameters=parameters)), parameters)
    names = state.system.state_names
    at = np.random.default_rng(0).uniform(0.01, 0.02, len(names))
    columns = []
    for i in range(len(names)):
        nudge = np.zeros(len(names))
        nudge[i] = NUDGE * at[i]
        near, far = (state.rates(at + n * nudge) - state.rates(at - n * nudge) for n in (1, 2))
        columns.append((8.0 * near - far) / (12.0 * nudge[i]))
    return names, state.jacobian(at), np.array(columns).T


def _of_motion(
    model: Model,
    law: Law,
    parameters: Mapping[str, float],
    eigenvalues: NDArray[Any],
    bench: Bench,
    source: str,
) -> Iterator[Check]:
    """A motion: its energy, and the same by steps of rk4."""
    rates = np.abs(eigenvalues.imag)
    rates = rates[rates > 0.0] if rates.any() else np.ones(1)
    fastest = max(rates.max() * STEPS / (2.0 * np.pi), np.abs(eigenvalues.real).max() * DECAY)
    t_end = min(PERIODS * 2.0 * np.pi / rates.min(), MOST / fastest)
    settings = {"t_end": float(t_end)}
    begin = Start("trial", "equilibrium", _speeds(model, parameters))
    if bench(model, law, "equilibrium", **parameters).status != "ok":
        begin = Start("trial", "state", begin.values)
    exact = bench(model, law, "history", begin, settings, **parameters)
    residual = float(exact.values.get("energy_residual", np.nan))
    name = f"energy over {t_end:.4g} s, relative"
    yield Check(name, source, residual, 0.0, BALANCED)
    for step in 1.0 / fastest * 0.5 ** np.arange(1 + HALVINGS):
        rk4 = SolverSettings("rk4", RTOL, float(step))
        stepped = bench(model, law, "history", begin, settings, solver=rk4, **parameters)
        apart = _apart(exact, stepped, model)
        if apart <= SAME or t_end / step > MOST:
            break
    yield Check("Taylor against rk4, relative", source, apart, 0.0, SAME)


def _speeds(model: Model, parameters: Mapping[str, float]) -> dict[str, float]:
    """Every coordinate at the greater part of the speed of the drive."""
    given = {p.name: p.default or 0.0 for p in model.parameters} | dict(parameters)
    speed = next((given[p.name] for p in model.parameters if p.role == "speed"), 0.0) or 1.0
    return {f"{s.name}_dot": BEGUN * speed for s in model.states(model.default_options())}


def _apart(one: Outcome, other: Outcome, model: Model) -> float:
    """How far two motions are apart at their end, over how far each coordinate goes.

    One that loses its contact is over before.
    """
    names = [state.name for state in model.states(model.default_options())]
    ways = [np.array([one.values[n], other.values[n]], float) for n in names]
    known = np.isfinite(ways).all(axis=(0, 1))
    return max(float(abs(a - b) / (np.ptp(way[0, known]) + 1e-300))
               for way in ways for a, b in [way[:, known][:, -1]])  # fmt: skip
