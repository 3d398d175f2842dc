"""Periodic motions, stable or not, by Newton's method on the return map.

A cycle is held by a point on it, away from every event (`Anchor`), and by its period. The point
is moved in the plane across the flow until the motion closes: the Jacobian is that of the tangent
vectors that the driver carries through every event (saltation, thesis 3.2) and, for the free
period of a system without excitation, the rate of the state. The point lies inside a contact
state, not on the section: so the map is smooth there, whatever events the section is made of.

Directions in which the map does not move (a sticking contact; the multipliers {1, 0} of a
stick-slip cycle of one degree of freedom; the transverse motion of a slider in rigid contact,
which follows the disc) are dealt with by least squares.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import cache, cached_property
from math import sqrt
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from fiv_cli.analyses.base import Request, Section, SolverSettings, Varied
from fiv_cli.analyses.rest.equilibria import statics_of
from fiv_cli.codegen.codes import CODE_SEPARATION, SEPARATION, STICK
from fiv_cli.dynamics.motion import Ledger, Motion, Stop
from fiv_cli.dynamics.system import System, Vector

Matrix = NDArray[np.float64]
Event = tuple[int, int, int]  # code before, code after, contact

TIGHT = 1e-12  # tolerance of a step: the map must be smooth for Newton's method
NEWTON_STEPS = 12
CONVERGED = 1e-9  # last correction, relative to the motion's extent
CLOSED = 1e-6  # what the conditions may be left with there: least squares also rest elsewhere
SHORTENED = (1.0, 0.5, 0.25, 0.125)  # shares of a Newton step that are tried
CHORDS = 8  # steps with one derivative
SLOW = 0.3  # a step that leaves more than this of the conditions asks for another derivative
SPENT = 1e-12  # what may be left to the next step, where the derivative is from elsewhere
RANK = 1e-12  # singular values below this share of the largest count as zero
OPEN = 1e-10  # of a motion's extent, per unit of its multiplier: what is so far open is no cycle
EPSILON = 2.0**-52  # the last digit of 1
DIGITS = 10.0  # last digits of its states by which a tiny cycle may be open
UNIT = 1e-3  # distance from 1, per unit of the largest, of the multiplier along the flow
AT_REST = 1e-7  # a motion of this extent, relative to its distance from zero, is an equilibrium
SAME_POINT = 1e-6  # section points of one cycle lie further apart than this share of its extent
MOST_EVENTS = 4096  # events, and section points, per period that are told apart
ROUNDING = 1e-12  # a multiplier below this is zero: stick forgets, and eigenvalues are rounded
PRESSED = 1e-3  # m, taken up at once
NONE = np.zeros(0)


@dataclass(frozen=True)
class Problem:
    """A system under parameters, and the section that its cycles are reported at.

    Attributes
    ----------
    system : the compiled system
    parameters : every parameter, SI
    solver : integrator settings, tight enough for Newton's method (see `problem_of`)
    section : section of the report
    """

    system: System
    parameters: Mapping[str, float]
    solver: SolverSettings
    section: Section

    @cached_property
    def excitation(self) -> float | None:
        """Period of the excitation, s; None without one."""
        return self.system.setup.model.excitation_period(self.system.known(self.parameters))

    def changed(self, varied: Varied, value: float) -> Problem:
        """The same with one parameter, and what follows it, at another value (SI)."""
        parameters = varied.at(self.parameters, value)
        return Problem(self.system, parameters, self.solver, self.section)


def problem_of(system: System, request: Request) -> Problem:
    """What is asked, with steps so accurate that differences of motions are smooth."""
    return Problem(system, request.parameters, _tight(request.solver), request.settings["section"])


@cache
def _tight(solver: SolverSettings) -> SolverSettings:
    """The same at the tolerance that Newton's method needs."""
    return replace(solver, rtol=min(solver.rtol, TIGHT))


@dataclass(frozen=True)
class Anchor:
    """A point of a motion inside a contact state.

    Attributes
    ----------
    state : shape (n_states,)
    sticking : contacts that stick there
    phase : phase of the excitation, rad; 0 without one
    closed : contacts that are not open there; the gap of a rigid one is zero to rounding, and
        does not tell
    """

    state: Vector
    sticking: tuple[bool, ...]
    phase: float = 0.0
    closed: tuple[bool, ...] = ()


def begin(problem: Problem, anchor: Anchor, events: int = 0) -> Motion:
    """The motion through `anchor`, with room for so many events in a ledger."""
    time = anchor.phase / (2 * np.pi) * (problem.excitation or 0.0)
    motion = Motion(
        problem.system, problem.parameters, problem.solver, anchor.state.copy(), time,
        anchor.sticking, events,
    )  # fmt: skip
    opened = SEPARATION in motion.kinds.tolist() and _parted(anchor, motion)
    return _closed(problem, anchor, motion, events) if opened else motion


def _parted(anchor: Anchor, motion: Motion) -> int:
    """Number of contacts that are open in `motion` and closed at `anchor`."""
    pairs = zip(anchor.closed, motion.kinds, strict=False)
    return sum(closed and kind == SEPARATION for closed, kind in pairs)


def _closed(problem: Problem, anchor: Anchor, motion: Motion, events: int = 0) -> Motion:
    """`motion` with the contacts closed that rounding has opened.

    Begun an instant before it lands, a motion would be right, but not its derivatives. A closed
    rigid contact takes up its gap, so it does not matter how far it is pressed in, nor is what
    sticks asked for again: `motion` has the velocity of the drive there.
    """
    names = problem.system.state_names
    for name in statics_of(problem.system).determined:
        pressed = motion.y - PRESSED * np.array([state == name for state in names])
        trial = Motion(
            problem.system, problem.parameters, problem.solver, pressed, motion.time, (), events
        )
        motion = trial if _parted(anchor, trial) < _parted(anchor, motion) else motion
    return motion


class Passage(NamedTuple):
    """A motion along a stretch of time.

    Attributes
    ----------
    begun : state at the beginning, as contact lets it be: a sticking contact has no slip velocity
    projection : derivative of `begun` by the state that was asked for
    state : at the end
    rates : of the state at the end; shape (n_states,), or (0,) without tangents
    monodromy : derivative of the end by the beginning; shape (n_states, n_states), or (n_states,
        0) without tangents
    times : of the events, s from the beginning
    events : code before, code after and contact of each, but for impacts that contact does not
        survive: where bounces pile up, one more or less changes nothing
    stop : why it ended
    """

    begun: Vector
    projection: Matrix
    state: Vector
    rates: Vector
    monodromy: Matrix
    times: Vector
    events: tuple[Event, ...]
    stop: Stop


def passage(problem: Problem, anchor: Anchor, span: float, tangents: bool = True) -> Passage:
    """Follow the motion through `anchor` for `span` seconds, with its tangents or without."""
    return _gone_on(begin(problem, anchor, MOST_EVENTS), span, tangents)


def _gone_on(motion: Motion, span: float, tangents: bool, *watched: Any) -> Passage:
    """What `motion` does in `span` seconds; `watched` is what `Motion.run` takes besides."""
    started, before = motion.time, motion.y.copy()
    identity = _identity(len(before))
    projection = _projection(motion) if tangents and motion.started else identity
    if tangents:
        motion.carry_tangents(identity.copy())
    stop = motion.run(started + span, *watched)
    ledger = motion.ledger
    return Passage(
        begun=before,
        projection=projection,
        state=motion.y.copy(),
        rates=motion.rates() if tangents else NONE,
        monodromy=motion.tangents.T.copy(),
        times=ledger.times - started,
        events=tuple(event for event in _events(ledger) if not _bounces(event)),
        stop=stop,
    )


@cache
def _identity(n: int) -> Matrix:
    """The identity, made once; nobody writes to it."""
    return np.eye(n)


def _projection(motion: Motion) -> Matrix:
    """Derivative of the state where a motion is by the state asked for, by differentiated code."""
    index = motion.state_index
    if not _is_constrained(motion.system, index):
        return _identity(len(motion.y))
    return _tangents_at(motion.system, index, motion.coefficients, motion.time, motion.y)


@cache
def _is_constrained(system: System, index: int) -> bool:
    """Whether a contact state determines entries of the state, which then do not count."""
    n, coefficients = len(system.state_names), np.zeros(max(system.generated.n_coefficients, 1))
    return not np.array_equal(
        _tangents_at(system, index, coefficients, 0.0, np.zeros(n)), np.eye(n)
    )


def _tangents_at(
    system: System, index: int, coefficients: Vector, time: float, state: Vector
) -> Matrix:
    """What a contact state leaves of tangents along each entry of the state, as columns."""
    found = system.linearised(index, coefficients, time, state, range(len(state)))
    return np.ascontiguousarray(found[:, :, 0].T)


def _events(ledger: Ledger) -> list[Event]:
    """Code before, code after and contact of each event."""
    columns = (ledger.before.tolist(), ledger.after.tolist(), ledger.contacts.tolist())
    return list(zip(*columns, strict=True))


def _bounces(event: Event) -> bool:
    return event[0] == event[1] == CODE_SEPARATION


# --- the closing conditions ----------------------------------------------------------------------
class Equations(NamedTuple):
    """What must vanish somewhere.

    Attributes
    ----------
    values : what should be zero
    jacobian : gives its derivative, which costs as much as many motions; None where there is none
    around : the motion over a period
    """

    values: Vector
    jacobian: Callable[[], Matrix | None]
    around: Passage


Conditions = Callable[[Vector], Equations | None]


@dataclass(frozen=True)
class Shooting:
    """The conditions that close a motion, in unknowns of order one.

    The unknowns are the state over `scales` and, without an excitation, the period over
    `period`. With an excitation the period is `turns` of its own.

    Attributes
    ----------
    anchor : reference point
    period : reference period, s
    scales : extent of the motion in every state
    normal : direction of the flow at the reference, scaled; None with an excitation
    turns : periods of the excitation per cycle; 0 without one
    """

    anchor: Anchor
    period: float
    scales: Vector
    normal: Vector | None
    turns: int

    @cached_property
    def start(self) -> Vector:
        """The unknowns at the reference."""
        period = [] if self.normal is None else [1.0]
        return np.concatenate([self.anchor.state / self.scales, period])

    def anchor_of(self, unknowns: Vector) -> Anchor:
        """The point that `unknowns` stand for."""
        state, reference = unknowns[: len(self.scales)] * self.scales, self.anchor
        return Anchor(state, reference.sticking, reference.phase, reference.closed)

    def period_of(self, problem: Problem, unknowns: Vector) -> float:
        """The period that `unknowns` stand for, s."""
        if self.normal is None:
            assert problem.excitation is not None
            return self.turns * problem.excitation
        return float(unknowns[len(self.scales)] * self.period)

    def around(self, problem: Problem, unknowns: Vector, tangents: bool = True) -> Passage | None:
        """The motion over a period; None where it does not last that long."""
        period = self.period_of(problem, unknowns)
        if not 0.2 * self.period < period < 5.0 * self.period:
            return None
        motion = passage(problem, self.anchor_of(unknowns), period, tangents)
        finite = bool(np.isfinite(motion.monodromy).all())
        return motion if finite and motion.stop == Stop.REACHED else None

    def values(self, motion: Passage, unknowns: Vector) -> Vector:
        """What must vanish: the gap after a period, what contact does not let be, and, where the
        period is free, the way along the flow."""
        n, begun = len(self.scales), motion.begun / self.scales
        parts = [motion.state / self.scales - begun, begun - unknowns[:n]]
        if self.normal is not None:
            parts.append(np.array([self.normal @ (begun - self.start[:n])]))
        return np.concatenate(parts)

    def jacobian(self, motion: Passage) -> Matrix:
        """Derivative of `values` by the unknowns."""
        n, free = len(self.scales), int(self.normal is not None)
        found = np.zeros((2 * n + free, n + free))
        projection = motion.projection * self.scales / self.scales[:, None]
        found[:n, :n] = motion.monodromy * self.scales / self.scales[:, None] - projection
        found[n : 2 * n, :n] = projection - _identity(n)
        if self.normal is not None:
            found[:n, n] = motion.rates / self.scales * self.period
            found[2 * n, :n] = self.normal @ projection
        return found

    def conditions(self, problem: Problem, unknowns: Vector) -> Equations | None:
        """`values` and their Jacobian; None where the motion does not last a period."""
        motion = self.around(problem, unknowns, tangents=False)
        if motion is None:
            return None

        def jacobian() -> Matrix | None:
            along = self.around(problem, unknowns)
            return None if along is None else self.jacobian(along)

        return Equations(self.values(motion, unknowns), jacobian, motion)


def shooting(problem: Problem, anchor: Anchor, period: float, scales: Vector) -> Shooting:
    """The closing conditions about a guess."""
    if problem.excitation is not None:
        turns = max(round(period / problem.excitation), 1)
        return Shooting(anchor, turns * problem.excitation, scales, None, turns)
    motion = begin(problem, anchor)
    rates = motion.rates() if motion.started else np.zeros_like(scales)
    return across_flow(replace(anchor, state=motion.y.copy()), period, scales, rates)


def across_flow(anchor: Anchor, period: float, scales: Vector, rates: Vector) -> Shooting:
    """The closing conditions of a free period about a point that moves on with these rates."""
    flow = rates / scales
    normal = flow / max(_length(flow), np.finfo(float).tiny)
    return Shooting(anchor, period, scales, normal, 0)


def newton(
    conditions: Conditions, start: Vector, inverse: Matrix | None = None, reach: float = np.inf
) -> tuple[Vector, Equations] | None:
    """Root of `conditions` no further than `reach` from `start`, and the last ones looked at.

    Newton's method; None where it finds none. Where a derivative from nearby is known, steps are
    taken with it, corrected by what they do to the conditions (Broyden 1965), and with those that
    follow it, as long as they go well; where it points out of reach, nothing is looked for.

    Parameters
    ----------
    inverse : of the derivative known
    """
    here, equations, slow = start, conditions(start), 0.0 if inverse is None else SLOW

    def bounded(trial: Vector) -> Equations | None:
        return conditions(trial) if _length(trial - start) <= reach else None

    if equations is None:
        return None
    if inverse is not None and _length(inverse @ equations.values) > reach:
        return None
    for _ in range(NEWTON_STEPS):
        known = inverse_of(equations.jacobian()) if inverse is None else inverse
        if known is None:
            return None
        shares = SHORTENED if inverse is None else SHORTENED[:1]
        here, equations, is_root = _chords(bounded, here, equations, known, shares, slow)
        if equations is None:
            return None
        if is_root:
            return here, equations
        inverse = None
    return None


def inverse_of(jacobian: Matrix | None) -> Matrix | None:
    """Least squares as a matrix; None where there is no Jacobian."""
    if jacobian is None or not np.isfinite(jacobian).all():
        return None
    return least_squares(jacobian)


def least_squares(matrix: Matrix) -> Matrix:
    """The pseudo-inverse of a matrix (numpy's own takes twice as long)."""
    left, sizes, right = np.linalg.svd(matrix, full_matrices=False)
    kept = sizes > RANK * sizes[0]
    inverses = np.divide(1.0, sizes, out=np.zeros_like(sizes), where=kept)
    return np.asarray(right.T @ (inverses[:, None] * left.T))


def _chords(
    conditions: Conditions,
    here: Vector,
    equations: Equations,
    inverse: Matrix,
    shares: tuple[float, ...],
    slow: float,
) -> tuple[Vector, Equations | None, bool]:
    """Steps with one derivative: where they lead, the equations there, whether that is the root.

    No equations: they lead nowhere.

    Parameters
    ----------
    shares : of the first step that are tried; several where the derivative is that of `here`
    slow : share of the conditions beyond which what a step leaves asks for another derivative
    """
    left, before = 0.0 if shares is SHORTENED else 1.0, _length(equations.values)
    for _ in range(CHORDS):
        values = equations.values
        step = -inverse @ values
        size = float(abs(step).max())
        if size <= CONVERGED and size * left <= SPENT:
            is_root = bool(abs(values).max() <= CLOSED)
            return (here + step, equations, True) if is_root else (here, None, False)
        moved = _shortened(conditions, here, step / max(1.0, size), shares, before)
        if moved is None:
            return here, None if shares is SHORTENED else equations, False
        taken, (here, equations), shares = moved[0] - here, moved, SHORTENED[:1]
        after, change = _length(equations.values), equations.values - values
        left, before = after / before, after
        seen = taken @ inverse
        if left > slow or not seen @ change > 0.0:
            break
        inverse = inverse + np.outer((taken - inverse @ change) / (seen @ change), seen)
    return here, equations, False


def _shortened(
    conditions: Conditions, here: Vector, step: Vector, shares: tuple[float, ...], before: float
) -> tuple[Vector, Equations] | None:
    """Where the longest share of a step leads that leaves less than `before`; the equations."""
    for share in shares:
        found = conditions(here + share * step)
        if found is not None and _length(found.values) < before:
            return here + share * step, found
    return None


def _length(vector: Vector) -> float:
    """Euclidean norm (numpy's own takes twice as long)."""
    return sqrt(float(vector @ vector))


# --- cycles --------------------------------------------------------------------------------------
@dataclass(frozen=True)
class Orbit:
    """A closed motion, and what becomes of its neighbours.

    Attributes
    ----------
    anchor : a point on it, inside a contact state
    period : s
    residual : what the motion misses itself by after a period, relative to its extent
    multipliers : Floquet multipliers, largest first; complex, shape (n_states,)
    autonomous : whether one of them, 1, is the direction of the flow
    """

    anchor: Anchor
    period: float
    residual: float
    multipliers: NDArray[np.complex128]
    autonomous: bool

    @cached_property
    def nontrivial(self) -> NDArray[np.complex128]:
        """The multipliers without that of the flow's direction."""
        kept = np.ones(len(self.multipliers), bool)
        if self.autonomous:
            kept[np.argmin(np.abs(self.multipliers - 1.0))] = False
        return self.multipliers[kept]

    @cached_property
    def largest(self) -> float:
        """Modulus of the largest nontrivial multiplier."""
        return float(np.abs(self.nontrivial).max(initial=0.0))

    @property
    def stable(self) -> bool:
        """Whether neighbours come nearer."""
        return self.largest < 1.0


@dataclass(frozen=True)
class Cycle(Orbit):
    """A periodic motion that was watched over a period.

    Attributes
    ----------
    around : the motion over a period
    points : states at the section, in order; shape (multiplicity, n_states)
    extremes : least and greatest value of every state; shape (2, n_states)
    """

    around: Passage
    points: Matrix
    extremes: Matrix

    @cached_property
    def scales(self) -> Vector:
        """Extent of the motion in every state."""
        return extents(self.extremes)

    @property
    def last_digits(self) -> float:
        """What the last digits of its states are of its extent."""
        return EPSILON * float(np.max(np.abs(self.extremes) / self.scales))

    @property
    def is_closed(self) -> bool:
        """Whether it comes back to itself, and does not only rest nearly.

        Where a motion dies away Newton's method converges to rest, and what is left there of the
        way may pass for a motion; no neighbour along its flow keeps its distance.
        """
        size = max(1.0, self.largest)
        is_back = self.residual <= max(OPEN * size, DIGITS * self.last_digits)
        along = float(np.abs(self.multipliers - 1.0).min(initial=np.inf))
        return is_back and (not self.autonomous or along <= UNIT * size)

    @cached_property
    def signature(self) -> tuple[Event, ...]:
        """Its events in order, whichever comes first."""
        events = self.around.events
        return min(events[i:] + events[:i] for i in range(max(len(events), 1)))


def sorted_multipliers(monodromy: Matrix) -> NDArray[np.complex128]:
    """Eigenvalues of a monodromy matrix, largest first, of a pair the upper one first."""
    multipliers = np.linalg.eigvals(monodromy).astype(np.complex128)
    return multipliers[np.lexsort((-multipliers.imag, -np.abs(multipliers)))]


def floquet(multipliers: NDArray[np.complex128]) -> dict[str, Vector]:
    """Floquet multipliers as the variables of an answer."""
    return {
        "floquet_multiplier": np.abs(multipliers),
        "floquet_multiplier_real": multipliers.real,
        "floquet_multiplier_imag": multipliers.imag,
    }


def extents(extremes: Matrix) -> Vector:
    """Half the range of every state; where it does not move, its size, or 1."""
    half = 0.5 * (extremes[1] - extremes[0])
    largest = np.abs(extremes).max(axis=0)
    moving = half > AT_REST * largest
    return np.where(moving, half, np.where(largest > 0.0, largest, 1.0))


def is_at_rest(extremes: Matrix, n_coordinates: int) -> bool:
    """Whether no displacement moves: an equilibrium closes at any period."""
    reach = (extremes[1] - extremes[0])[:n_coordinates]
    return bool((reach <= AT_REST * np.abs(extremes).max(axis=0)[:n_coordinates]).all())


def close(problem: Problem, anchor: Anchor, period: float, scales: Vector) -> Cycle | None:
    """The cycle near a guess; None when there is none that Newton's method finds."""
    conditions = shooting(problem, anchor, period, scales)
    found = newton(lambda unknowns: conditions.conditions(problem, unknowns), conditions.start)
    if found is None:
        return None
    root, _ = found
    cycle = describe(problem, conditions.anchor_of(root), conditions.period_of(problem, root))
    if cycle is None or not cycle.is_closed:
        return None
    share = repeats(problem, cycle.points, cycle.scales, cycle.period)
    return cycle if share == 1 else close(problem, cycle.anchor, period / share, cycle.scales)


def describe(problem: Problem, anchor: Anchor, period: float) -> Cycle | None:
    """Multipliers, events, section points and extremes of a closed motion.

    None where the motion does not last, or rests.
    """
    motion, displacements = begin(problem, anchor, MOST_EVENTS), len(problem.system.coordinates)
    times, points = np.zeros(MOST_EVENTS), np.zeros((MOST_EVENTS, len(motion.y)))
    motion.start_measuring(np.zeros(displacements))
    sections = problem.section, (times, points), None, True, problem.excitation or period
    around = _gone_on(motion, period, True, *sections)
    if around.stop != Stop.REACHED or not np.all(np.isfinite(around.monodromy)):
        return None
    extremes = motion.extremes
    if is_at_rest(extremes, displacements):
        return None
    return Cycle(
        anchor=replace(anchor, state=around.begun),
        period=period,
        residual=float(np.max(np.abs(around.state - around.begun) / extents(extremes))),
        multipliers=sorted_multipliers(around.monodromy),
        autonomous=problem.excitation is None,
        around=around,
        points=points[: motion.n_sections].copy(),
        extremes=extremes,
    )


def repeats(problem: Problem, points: Matrix, scales: Vector, period: float) -> int:
    """How many times the true period goes into the one that was found.

    Parameters
    ----------
    points : at the section, in order; shape (multiplicity, n_states)
    scales : extent of the motion in every state
    period : s
    """
    count = len(points)
    for share in range(count, 1, -1):
        if count % share or not _may_be_shared(problem, period, share):
            continue
        apart = np.abs(np.roll(points, count // share, axis=0) - points)
        if np.max(apart / scales) <= SAME_POINT:
            return share
    return 1


def _may_be_shared(problem: Problem, period: float, share: int) -> bool:
    """A period is a whole number of periods of the excitation."""
    if problem.excitation is None:
        return True
    return round(period / problem.excitation) % share == 0


# --- the anchor ----------------------------------------------------------------------------------
def pieces(times: Vector, span: float) -> Matrix:
    """(beginning, end) of the pieces between events of a periodic motion, s; shape (n, 2).

    The last piece runs on into the next period.
    """
    if len(times) == 0:
        return np.array([[0.0, span]])
    found = np.empty((len(times), 2))
    found[:, 0] = times
    found[:-1, 1], found[-1, 1] = times[1:], times[0] + span
    return found


def to_longest_piece(times: Vector, span: float) -> float:
    """Time to the middle of the longest piece between events, s."""
    stretches = pieces(times, span)
    begun, ended = stretches[np.argmax(stretches[:, 1] - stretches[:, 0])]
    return float(0.5 * (begun + ended) % span)


def anchor_at(problem: Problem, motion: Motion) -> Anchor:
    """The point where a motion is."""
    sticking = tuple(bool(kind == STICK) for kind in motion.kinds)
    phase = 0.0
    if problem.excitation is not None:
        phase = 2 * np.pi * (motion.time / problem.excitation % 1.0)
    closed = tuple(bool(kind != SEPARATION) for kind in motion.kinds)
    return Anchor(motion.y.copy(), sticking, phase, closed)
