"""A friction law under a slip that is stated: a mass so heavy that friction does not move it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from functools import partial
from math import tau
from typing import TYPE_CHECKING

import numpy as np

from fiv_cli.analyses.base import Outcome, Request, Start
from fiv_cli.analyses.common import stopped
from fiv_cli.analyses.motion.characteristic import OF_RECORDED
from fiv_cli.analyses.motion.recording import record
from fiv_cli.codegen.setup import Setup
from fiv_cli.dynamics.motion import Motion
from fiv_cli.dynamics.system import build_system
from fiv_cli.models.base import Contact, Equations, Model, Options, Parameter, State

if TYPE_CHECKING:
    from fiv_cli.models.symbols import Symbols

MASS = 1e15  # kg: what friction changes of the motion is below rounding


def equations(symbols: Symbols, options: Options) -> Equations:
    """s'' = A omega^2 cos(omega t) - F_T/m: on a shaken table, seen from there."""
    import sympy

    p, rate = symbols.parameter, symbols.velocity("slip")
    omega = p("stated_omega")
    shaken = p("stated_amplitude") * omega**2 * sympy.cos(omega * symbols.time)
    return Equations(
        accelerations={"slip": shaken - symbols.tangential_force(0) / MASS},
        contacts=(Contact(rate, "slip", p("stated_load")),),
        kinetic_energy=MASS * rate**2 / 2,
        potential_energy=sympy.Integer(0),
    )


MODEL = Model(
    name="stated-slip",
    title="a body whose slip is stated",
    reference="",
    numerics_version=1,
    parameters=(
        Parameter("stated_amplitude", "A", "m", 1.0, "amplitude of the slip"),
        Parameter("stated_omega", r"\omega", "rad s-1", 1.0, "frequency of the slip"),
        Parameter("stated_load", "N", "N", 1.0, "normal force"),
    ),
    states=lambda options: (State("slip", "s", "m", "slip"),),
    equations=equations,
    default_law="coulomb",
    law_defaults={},
    constant_load=True,
)


def characteristic(setup: Setup, request: Request) -> Outcome:
    """Force, slip and the law's states over time; the work of the last period."""
    asked, law = request.settings, setup.law
    own = {p.name: request.parameters[p.name] for p in law.parameters}
    stated = {f"stated_{name}": asked[name] for name in ("amplitude", "omega", "load")}
    parameters = own | stated
    system = build_system(Setup.of(MODEL, law, parameters=parameters, rtol=request.solver.rtol))
    state = {"slip": -asked["amplitude"], "slip_dot": asked["drift"]}
    begin = partial(Motion, system, parameters, request.solver, state)
    period = tau / asked["omega"]
    sampled = {"t_end": asked["periods"] * period, "sample": period / asked["samples"]}
    alone = replace(
        request,
        setup=system.setup,
        parameters=parameters,
        settings={**sampled, "points": ()},
        start=Start("stated", "state", state),
    )
    (recorded,) = record(system, [alone])
    outcome = recorded.whole()
    kept = [*(one.name for one in OF_RECORDED), *(state.name for state in law.inner)]
    outcome.values = {name: outcome.values[name] for name in kept}
    outcome.values |= {
        "static_capacity": _capacity(setup, parameters),
        "loop_work": _work(begin(), (asked["periods"] - 1) * period, sampled["t_end"]),
        "greatest_force": float(np.nanmax(np.abs(outcome.values["F_T"]))),
    }
    return outcome


def _capacity(setup: Setup, parameters: Mapping[str, float]) -> float:
    """What the contact can hold, N; NaN where it cannot stick."""
    capacity = setup.law.capacity
    if capacity is None:
        return float("nan")
    return float(capacity(parameters["stated_load"], parameters))


def _work(motion: Motion, begun: float, ended: float) -> float:
    """Work of friction between two instants, J; NaN where the motion ends before."""
    if stopped(motion.run(begun)) is None:
        motion.start_measuring()
        if stopped(motion.run(ended, measuring=True)) is None:
            return -motion.measures.friction_work
    return float("nan")
