"""Motions sampled in time, with their event ledgers and energy balances."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from functools import cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fiv_cli.analyses.base import Columns, Outcome, Request, Settings
from fiv_cli.analyses.common import Balance, beginning, carry, rest_of, start_motion, stopped
from fiv_cli.analyses.rest.surface import Place, weights
from fiv_cli.codegen.codes import CODE_PIECE, CODE_STICK, ENERGY_OUTPUTS, PER_CONTACT
from fiv_cli.dynamics.motion import Motion, Stop
from fiv_cli.dynamics.recorder import Beginning, Recorder
from fiv_cli.dynamics.system import System, Vector
from fiv_cli.flags import CONTACT_EVENT
from fiv_cli.friction.base import STORED

DEFAULT_SAMPLES = 2000

Curves = dict[str, NDArray[Any]]


def record(system: System, requests: Sequence[Request]) -> list[Outcome]:
    """States, contact forces and energies at the sample times, and every event.

    On discs also the displacement w at the points asked for.
    """
    found = [_beginning(system, request) for request in requests]
    begun = [one for one in found if not isinstance(one, Outcome)]
    recorded = iter(_recorded(system, requests[0], begun) if begun else ())
    return [one if isinstance(one, Outcome) else next(recorded) for one in found]


def _recorded(system: System, request: Request, begun: Sequence[Beginning]) -> list[Outcome]:
    """The motions of points; a failure where one went on to its end and its energies are none."""
    times, places = sample_times(request.settings), request.settings["points"]
    recorder = Recorder(system, request.solver, begun, times)
    stops = recorder.run()
    curves = _curves(system, recorder)
    values = curves | {
        name: np.broadcast_to(curve, (len(begun), len(times)))
        for name, curve in {"time": times, **varying_at(system, times)}.items()
    }
    if places:
        values |= _surfaces(system, [one.parameters for one in begun], recorder.states, places)
    values |= _told(system, recorder) | _works(system, recorder, curves)
    columns = Columns(values, _events(system, recorder), recorder.lengths)
    residuals = values["energy_residual"].tolist()
    found = [_outcome(stop, residuals[row], columns, row) for row, stop in enumerate(stops)]
    for row, outcome in enumerate(found):
        if stops[row] == Stop.REACHED and outcome.status == "ok":
            sticking = recorder.codes[row, :, -1] == CODE_STICK
            outcome.carry = carry("", recorder.states[row, :, -1], sticking)
    return found


def _outcome(stop: Stop, residual: float, columns: Columns, row: int) -> Outcome:
    if stop == Stop.REACHED and math.isnan(residual):
        message = "energy_residual is no number"
        return Outcome(status="failed", reason="no_number", message=message)
    outcome = stopped(stop) or Outcome()
    outcome.columns, outcome.row = columns, row
    return outcome


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


def begun(system: System, request: Request) -> Motion | Outcome:
    """The motion from the start; an equilibrium is looked for only where it needs one."""
    return start_motion(system, request, _equilibrium(system, request))


def _beginning(system: System, request: Request) -> Beginning | Outcome:
    return beginning(system, request, _equilibrium(system, request))


def _equilibrium(system: System, request: Request) -> Vector | None:
    """The equilibrium that a start may need; None where there is none, or it needs none."""
    assert request.start is not None
    solutions = [] if request.start.kind == "state" else rest_of(system, request)[1]
    return solutions[0] if solutions else None


# --- columns -------------------------------------------------------------------------------------
def _curves(system: System, recorder: Recorder) -> Curves:
    """Everything over time; NaN after the end of a motion that stopped early."""
    contacts, outputs = system.n_contacts, recorder.outputs
    of_contacts = outputs[:, : PER_CONTACT * contacts]
    energies, stored = outputs[:, -len(ENERGY_OUTPUTS) :], outputs[:, PER_CONTACT * contacts :]
    stored = stored[:, : system.generated.n_stored]
    curves = {name: recorder.states[:, place] for place, name in enumerate(system.motions)}
    curves |= _internal(system, recorder.states)
    if system.generated.n_stored:
        curves[STORED.name] = _of_contacts(stored)
    curves["F_N"] = _of_contacts(of_contacts[:, ::PER_CONTACT])
    curves["F_T"] = _of_contacts(of_contacts[:, 1::PER_CONTACT])
    curves |= {name: energies[:, place] for place, name in enumerate(ENERGY_OUTPUTS)}
    return curves | {"contact_state": _of_contacts(recorder.codes)}


def _internal(system: System, states: NDArray[np.float64]) -> Curves:
    """The states of the friction law over time."""
    found, several = {}, system.n_contacts > 1
    for state in system.setup.law.states:
        names = [f"{state.name}_{contact + 1}" for contact in range(system.n_contacts)]
        places = [system.places.get(name) for name in (names if several else [state.name])]
        none = np.full(states.shape[::2], np.nan)  # of a contact with a law of its own
        rows = [none if place is None else states[:, place] for place in places]
        found[state.name] = _of_contacts(np.stack(rows, axis=1))
    return found


def _of_contacts(values: NDArray[Any]) -> NDArray[Any]:
    """(motion, contact, time), or (motion, time) on models with one contact."""
    return values[:, 0] if values.shape[1] == 1 else values


def _surfaces(
    system: System,
    parameters: Sequence[Mapping[str, float]],
    states: NDArray[np.float64],
    places: Sequence[Place],
) -> Curves:
    """w over (motion, place, time), and where the places are."""
    weighed = np.array([weights(system, one, places) for one in parameters])
    radius, angle = np.broadcast_to(
        np.array(places, float).T[:, None], (2, len(states), len(places))
    )
    w = weighed @ states[:, : len(system.coordinates)]
    return {"w": w, "point_radius": radius, "point_angle": angle}


def varying_at(system: System, times: Vector) -> dict[str, Vector]:
    """Each parameter that varies in time, at `times`."""
    return {
        name: np.interp(times, [t for t, _ in points], [value for _, value in points])
        for name, points in system.setup.schedule.curves
    }


def _told(system: System, recorder: Recorder) -> Curves:
    """What each motion says of itself."""
    names = ["n_steps", "n_events"]
    if system.setup.model.stops:
        names += ["n_impacts", "n_accumulations"]
    return {name: recorder.told(name) for name in names}


def _works(system: System, recorder: Recorder, curves: Curves) -> Curves:
    """The energy balance of each motion, from its first sample on, and where that begins."""
    after, stored_after = recorder.energies()
    has_begun, first = recorder.told("n_sampled") > 0, {n: c[..., 0] for n, c in curves.items()}
    motions = recorder.own("y")[:, : len(system.motions)]
    initial = np.column_stack([first[name] for name in system.motions])
    before = np.where(has_begun, first["kinetic_energy"] + first["potential_energy"], after)
    terms = [f"{term}_{'loss' if term == 'impact' else 'work'}" for term in Balance._fields[2:]]
    works = {name: recorder.told(name) for name in terms}
    columns = (column.tolist() for column in (before, after, *works.values()))
    balances = map(Balance._make, zip(*columns, strict=True))
    works["energy_residual"] = np.array([balance.residual for balance in balances])
    works["initial_state"] = np.where(has_begun[:, None], initial, motions)
    for name, work in zip(system.setup.model.powers, recorder.works.T, strict=True):
        works[f"{name}_work"] = work
    if system.generated.n_stored:
        stored = first[STORED.name].reshape(len(after), -1).sum(axis=1)
        gained = np.where(has_begun, stored_after - stored, 0.0)
        works["friction_loss"] = works["drive_work"] - works["friction_work"] - gained
    return works


def _events(system: System, recorder: Recorder) -> Curves:
    """The ledger of all motions."""
    ledger, codes = recorder.ledger, _codes_of_events(system)
    return {
        "event_time": ledger.times,
        "event_from": codes[ledger.before],
        "event_to": codes[ledger.after],
        "event_contact": ledger.contacts + 1,
        "event_residual": ledger.residuals,
    }


@cache
def _codes_of_events(system: System) -> NDArray[np.int8]:
    """What a ledger holds -> code of `flags.CONTACT_EVENT`: contact states, pieces of laws."""
    words = system.pieces.events
    codes = [*range(CODE_PIECE), *(CONTACT_EVENT.codes[word] for word in words)]
    return np.array(codes, np.int8)
