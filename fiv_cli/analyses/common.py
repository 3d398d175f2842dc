"""What several analyses need: starts, ends, energy balance, sliding equilibria."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from typing import NamedTuple, TypeVar

import numpy as np
from numpy.typing import NDArray

from fiv_cli.analyses.base import Batch, Outcome, Request, Start
from fiv_cli.analyses.rest.equilibria import (
    Sliding,
    equilibria,
    equilibria_at,
    sliding,
    sliding_at,
    why_none,
)
from fiv_cli.dynamics.motion import STOP_REASONS, Motion, Stop
from fiv_cli.dynamics.recorder import Beginning
from fiv_cli.dynamics.system import System, Vector

__all__ = [
    "Balance",
    "Sliding",
    "at_once",
    "balance",
    "beginning",
    "carry",
    "equilibria",
    "impacts",
    "initial_state",
    "rest_of",
    "rests",
    "sliding",
    "start_motion",
    "start_state",
    "start_states",
    "stopped",
    "trust",
]

Found = TypeVar("Found")


def at_once(
    system: System, request: Request, find: Callable[[System, Sequence[Request]], Sequence[Found]]
) -> Found:
    """What `find` makes of a point, together with those that are run with it.

    That takes a fifth of the time.
    """
    batch = request.batch
    if batch is None or not batch.has(request):
        batch = Batch([request])
    own = find, system, id(request.parameters)
    if own not in batch.known:
        points = batch.alike(request)
        try:
            found = find(system, points)
        except Exception:  # of one of them: which, and what, is found alone
            points = [request]
            found = find(system, points)
        for point, one in zip(points, found, strict=True):
            batch.known[find, system, id(point.parameters)] = one
    answer: Found = batch.known[own]
    return answer


def rest_of(system: System, request: Request) -> tuple[Sliding, list[Vector]]:
    """The unexcited system in sliding, and its equilibria."""
    return at_once(system, request, _rests)


def _rests(system: System, requests: Sequence[Request]) -> list[tuple[Sliding, list[Vector]]]:
    state, solutions = rests(system, requests)
    return [(state[row], one) for row, one in enumerate(solutions)]


def rests(system: System, requests: Sequence[Request]) -> tuple[Sliding, list[list[Vector]]]:
    """The unexcited system in sliding at several points, in rows, and the equilibria of each."""
    state = sliding_at(system, [request.parameters for request in requests])
    return state, [one.states for one in equilibria_at(state)]


def start_state(system: System, start: Start, equilibrium: Vector | None) -> Vector | None:
    """The state that a start describes, if no neighbour does; None without the equilibrium."""
    return _placed(start, system.state_vector(start.values), equilibrium)


def _placed(start: Start, given: Vector, equilibrium: Vector | None) -> Vector | None:
    if start.kind == "state":
        return given
    return None if equilibrium is None else equilibrium + given


def start_states(
    system: System, requests: Sequence[Request], equilibria: Sequence[Vector | None]
) -> NDArray[np.float64]:
    """The states that starts describe, NaN where none does; shape (requests, n_states)."""
    starts = {id(one.start): one.start for one in requests if one.start is not None}
    given = {place: system.state_vector(start.values) for place, start in starts.items()}
    unknown, states = np.full(len(system.state_names), np.nan), []
    for request, equilibrium in zip(requests, equilibria, strict=True):
        start = request.start
        state = None if start is None else _placed(start, given[id(start)], equilibrium)
        states.append(unknown if state is None else state)
    return np.array(states)


def start_motion(system: System, request: Request, equilibrium: Vector | None) -> Motion | Outcome:
    """The motion that the start describes, or the outcome that says why there is none."""
    begun = beginning(system, request, equilibrium)
    if isinstance(begun, Outcome):
        return begun
    state, sticking = begun.state, begun.sticking
    return Motion(system, begun.parameters, request.solver, state, 0.0, sticking)


def beginning(system: System, request: Request, equilibrium: Vector | None) -> Beginning | Outcome:
    """Where the start says that the motion begins, or the outcome that says why it does not."""
    start, parameters = request.start, request.parameters
    assert start is not None
    if start.kind == "continue" and start.carried is not None:
        rested = start.carried["attractor"] == "equilibrium"
        if start.from_rest or not rested:
            stuck = tuple(bool(s) for s in start.carried["sticking"])
            state = np.array(start.carried["state"], dtype=float)
            begun = state + system.state_vector(start.values) if rested else state
            return Beginning(parameters, begun, () if start.literal else stuck)
    described = start_state(system, start, equilibrium)
    if described is None:
        return Outcome(status="failed", reason=why_none(sliding(system, parameters)))
    return Beginning(parameters, described)


def carry(attractor: str, state: Vector, sticking: Iterable[bool]) -> dict[str, object]:
    """What a point leaves to its neighbour on a chain; of a motion without a class, none."""
    return {
        "attractor": attractor,
        "state": state.tolist(),
        "sticking": [int(one) for one in sticking],
    }


def initial_state(motion: Motion) -> Vector:
    """Displacements and velocities of a motion that has just begun."""
    return motion.y[: 2 * len(motion.system.coordinates)].copy()


def stopped(stop: Stop) -> Outcome | None:
    """The outcome of a motion that could not go on; None when it could."""
    reason = STOP_REASONS.get(stop)
    if reason is None:
        return None
    if stop in (Stop.STEP_BUDGET, Stop.EVENT_BUDGET, Stop.STANDS_STILL):
        return Outcome(status="budget", reason=reason)
    if stop in (Stop.DIVERGED, Stop.CONTACT_LOST):
        return Outcome(reason=reason)
    return Outcome(status="failed", reason=reason)


class Balance(NamedTuple):
    """Energy balance over a measured stretch, J."""

    kinetic_potential_before: float
    kinetic_potential_after: float
    other: float
    friction: float
    drive: float
    impact: float

    @property
    def residual(self) -> float:
        """What the balance leaves over, relative to its largest term."""
        change = self.kinetic_potential_after - self.kinetic_potential_before
        largest = max(map(abs, self))
        rest = change - self.other - self.friction + self.impact
        return abs(rest) / largest if largest != 0.0 else 0.0  # NaN stays


def balance(motion: Motion, energy_before: float) -> Balance:
    """Energy balance of what `motion` has measured."""
    after, frame = motion.energy(), motion.frame
    works = frame.other_work, frame.friction_work, frame.drive_work, frame.impact_loss
    return Balance(energy_before, after, *works)


def impacts(motion: Motion) -> dict[str, int]:
    """What has been counted at stops, where there are any."""
    frame, has_stops = motion.frame, motion.system.setup.model.stops > 0
    return {name: getattr(frame, name) for name in ("n_impacts", "n_accumulations") if has_stops}


def trust(motion: Motion) -> dict[str, float]:
    """The variables that say how far a run can be trusted, without the energy balance."""
    return {
        "event_residual": motion.frame.largest_residual,
        "n_steps": motion.n_steps,
        "n_events": motion.n_events,
    }
