"""A motion sampled in time, with its event ledger and energy balance."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from copy import deepcopy
from functools import cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fiv_cli.analyses.base import Outcome, Request, Settings
from fiv_cli.analyses.common import (
    balance,
    impacts,
    initial_state,
    rest_of,
    start_motion,
    stopped,
    trust,
)
from fiv_cli.analyses.rest.surface import Place, weights
from fiv_cli.codegen.codes import CODE_PIECE
from fiv_cli.dynamics.motion import Ledger, Motion, Samples, samples_at
from fiv_cli.dynamics.system import System, Vector
from fiv_cli.flags import CONTACT_EVENT
from fiv_cli.friction.base import STORED

DEFAULT_SAMPLES = 2000
LEDGER_ROWS = 4096  # first size of the ledger; it grows as events come


def record(system: System, request: Request) -> Outcome:
    """States, contact forces and energies at the sample times, and every event.

    On discs also the displacement w at the points asked for.
    """
    room = LEDGER_ROWS + system.n_contacts  # several at one instant
    motion, settings = begun(system, request, room), request.settings
    if isinstance(motion, Outcome):
        return motion
    times = sample_times(settings)
    samples = samples_at(system, times)
    initial, energy_before = initial_state(motion), motion.energy()
    stored_before = motion.stored_energy()
    motion.start_measuring()
    ledger, end = _run_with_ledger(motion, float(times[-1]), samples)
    outcome = end or Outcome()
    outcome.values |= {"time": times, **_curves(system, samples), **varying_at(system, times)}
    if settings["points"]:
        outcome.values |= _surface(system, request.parameters, outcome.values, settings["points"])
    codes = _codes_of_events(system)
    outcome.values |= initial | trust(motion) | impacts(motion)
    outcome.values |= _works(motion, energy_before, stored_before)
    outcome.ragged |= {
        "event_time": ledger.times,
        "event_from": codes[ledger.before],
        "event_to": codes[ledger.after],
        "event_contact": ledger.contacts + 1,
        "event_residual": ledger.residuals,
    }
    return outcome


@cache
def _codes_of_events(system: System) -> NDArray[np.int64]:
    """What a ledger holds -> code of `flags.CONTACT_EVENT`: contact states, pieces of laws."""
    words = system.pieces.events
    return np.array([*range(CODE_PIECE), *(CONTACT_EVENT.codes[word] for word in words)])


def sample_times(settings: Settings) -> Vector:
    """Times of the samples, s: from 0, t_end always included."""
    t_end = float(settings["t_end"])
    interval = settings["sample"]
    if interval is None:
        return np.linspace(0.0, t_end, DEFAULT_SAMPLES + 1)
    count = int(np.floor(t_end / interval + 1e-9)) + 1
    times: Vector = interval * np.arange(count, dtype=np.float64)
    reached = abs(times[-1] - t_end) <= 1e-9 * t_end
    return times if reached else np.append(times, t_end)


def begun(system: System, request: Request, events: int = 0) -> Motion | Outcome:
    """The motion from the start; an equilibrium is looked for only where it needs one.

    `events` : room for a ledger that is kept from the start
    """
    assert request.start is not None
    given = request.start.kind == "state"
    solutions = [] if given else rest_of(system, request)[1]
    return start_motion(system, request, solutions[0] if solutions else None, events)


def _run_with_ledger(
    motion: Motion, t_end: float, samples: Samples
) -> tuple[Ledger, Outcome | None]:
    """Run to `t_end`, stopping whenever the ledger is full to go on with an empty one."""
    pages: list[Ledger] = []
    budget = motion.frame.max_events
    while True:
        motion.frame.n_ledger = 0
        motion.frame.max_events = min(budget, motion.n_events + LEDGER_ROWS)
        stop = motion.run(t_end, samples=samples, measuring=True)
        pages.append(motion.ledger)
        page_full = stop == stop.EVENT_BUDGET and motion.n_events < budget
        if not page_full:
            return Ledger(*map(np.concatenate, zip(*pages, strict=True))), stopped(stop)
        pages[-1] = deepcopy(pages[-1])  # the next page has the same room


def _curves(system: System, samples: Samples) -> dict[str, NDArray[Any]]:
    """Everything over time; NaN after the end of a motion that stopped early."""
    samples.states[samples.count :] = samples.outputs[samples.count :] = np.nan
    samples.codes[samples.count :] = -1
    curves: dict[str, NDArray[Any]] = dict(zip(system.motions, samples.states.T, strict=False))
    curves |= _internal(system, samples)
    curves["F_N"] = _contact_rows(samples.forces[:, :, 0])
    curves["F_T"] = _contact_rows(samples.forces[:, :, 1])
    return {**curves, **samples.energies, "contact_state": _contact_rows(samples.codes)}


def _internal(system: System, samples: Samples) -> dict[str, NDArray[np.float64]]:
    """The states of the friction law over time, and what it has stored."""
    found, several = {}, system.n_contacts > 1
    for state in system.setup.law.states:
        names = [f"{state.name}_{contact + 1}" for contact in range(system.n_contacts)]
        places = [system.places.get(name) for name in (names if several else [state.name])]
        none = np.full(len(samples.times), np.nan)  # of a contact with a law of its own
        rows = [none if place is None else samples.states[:, place] for place in places]
        found[state.name] = _contact_rows(np.column_stack(rows))
    return found | ({STORED.name: _contact_rows(samples.stored)} if samples.stored.size else {})


def _surface(
    system: System,
    parameters: Mapping[str, float],
    curves: Mapping[str, object],
    places: Sequence[Place],
) -> dict[str, NDArray[np.float64]]:
    """w over (place, time), and where the places are."""
    coordinates = np.array([curves[name] for name in system.coordinates])
    radius, angle = np.array(places, float).T
    w = weights(system, parameters, places) @ coordinates
    return {"w": w, "point_radius": radius, "point_angle": angle}


def varying_at(system: System, times: Vector) -> dict[str, Vector]:
    """Each parameter that varies in time, at `times`."""
    return {
        name: np.interp(times, [t for t, _ in points], [value for _, value in points])
        for name, points in system.setup.schedule.curves
    }


def _contact_rows(values: NDArray[Any]) -> NDArray[Any]:
    """(contact, time), or (time,) on models with one contact."""
    return values[:, 0] if values.shape[1] == 1 else values.T


def _works(motion: Motion, energy_before: float, stored_before: float) -> dict[str, float]:
    found, excited = balance(motion, energy_before), motion.frame.works.tolist()
    named = (f"{name}_work" for name in motion.system.setup.model.powers)
    works = dict(zip(named, excited, strict=True))
    if motion.system.generated.n_stored:
        stored = motion.stored_energy() - stored_before
        works["friction_loss"] = found.drive - found.friction - stored
    return works | {
        "energy_residual": found.residual,
        "friction_work": found.friction,
        "drive_work": found.drive,
        "other_work": found.other,
        "impact_loss": found.impact,
    }
