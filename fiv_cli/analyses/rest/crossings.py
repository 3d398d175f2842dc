"""Where eigenvalues cross the imaginary axis along one parameter.

The bracket is sampled adaptively: a piece is finished when every mode, followed through its ends
and its middle, is told by a straight line well enough that its real part has no zero, or exactly
one, in between, and no two modes can meet; nor does slip reverse there, nor a law go on by another
of its pieces. A root is then found by Brent's method on its own mode. What stays unresolved down
to `NARROWEST` is a singularity: there the number of growing modes (or the existence of the
equilibrium, or its way of slipping) is bisected to rounding, and what the eigenvalues do across it
tells a root (undamped flutter, where they branch) from a jump. Wherever a value without
an equilibrium turns up in between (a critical speed of a disc), the piece is divided there.

A scan is a generator: it hands out the values at which it wants the modes and is sent these, so
that scans of many points advance side by side and what all of them want is computed at once.
"""

from __future__ import annotations

from collections.abc import Callable, Generator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import islice
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from fiv_cli import ending
from fiv_cli.analyses.base import Outcome, Request
from fiv_cli.analyses.rest.averaging import LEAST_RATIO, frequency_ratio
from fiv_cli.analyses.rest.brent import ULP, zero
from fiv_cli.analyses.rest.equilibria import equilibria, equilibria_at, why_none
from fiv_cli.analyses.rest.linearisation import (
    NEUTRAL,
    free_jacobian,
    modes_at,
    sliding_system,
    sliding_systems,
)
from fiv_cli.analyses.rest.modes import Modes, followed, modes_of
from fiv_cli.dynamics.system import System

Real = NDArray[np.float64]
Complex = NDArray[np.complex128]

PIECES = 32  # into which a bracket is divided at least
NARROWEST = 2.0**-20  # share of the bracket at which a piece is not divided any more
NARROW = 2.0**10  # times that: a piece as wide is divided where a law goes on by another of its
MOST_SAMPLES = 20_000
BENT = 0.25  # largest departure from a straight line, over the change of a real part with a root
MARGIN = 2.0  # by which departures from a straight line must be smaller than what they could hide
MEET = 1e-7  # changes below this share of the largest eigenvalue do not let two modes meet
ASIDE = 0.071  # share of a piece by which what divides it is moved off a root
JUMP = 1e-5  # share of the largest eigenvalue by which a jump moves one
HALVINGS = 64
ROUNDED = 64.0 * ULP  # share of a value by which the other parameters' rounding moves it (up to 23)
NEIGHBOURS = 8  # numbers on each side of a root without frequency that are looked at

NOWHERE = Modes(np.zeros(0, complex), np.zeros((0, 0), complex), np.zeros(0, np.intp))


@dataclass(frozen=True)
class Sample:
    """The modes at one value of the parameter, in the order in which they are followed.

    Attributes
    ----------
    at : value of the parameter
    modes : in rad/s; none where there is no equilibrium
    signs : of the slip of each contact; 0 where it may stand still
    piece : the system, of several averaged ones, and the numbers of the pieces of laws
    """

    at: float
    modes: Modes
    signs: tuple[float, ...] = ()
    piece: tuple[object, ...] = ()

    @property
    def values(self) -> Complex:
        """The eigenvalues, rad/s."""
        return self.modes.values

    @property
    def exists(self) -> bool:
        """Whether there is a sliding equilibrium."""
        return len(self.values) > 0

    @property
    def scale(self) -> float:
        """Modulus of the largest eigenvalue, rad/s."""
        return float(np.abs(self.values).max())

    @property
    def growing(self) -> NDArray[np.bool_]:
        """Which modes grow by more than rounding, (modes,)."""
        result: NDArray[np.bool_] = self.values.real > NEUTRAL * self.scale
        return result

    @property
    def decaying(self) -> NDArray[np.bool_]:
        """Which modes decay by more than rounding, (modes,)."""
        result: NDArray[np.bool_] = self.values.real < -NEUTRAL * self.scale
        return result

    @property
    def unstable(self) -> int:
        """Number of growing modes; -1 where there is no equilibrium."""
        return int(self.growing.sum()) if self.exists else -1

    def after(self, previous: Sample) -> Scan[Sample]:
        """The same with its modes in the order in which they continue those of `previous`."""
        if not (self.exists and previous.exists):
            return self
        modes = self.modes.taken((yield previous.modes, self.modes))
        return self if modes is self.modes else replace(self, modes=modes)


@dataclass(frozen=True)
class Crossing:
    """One change of stability.

    Attributes
    ----------
    value, width : of the parameter: where it lies, and how wide the bracket is that holds it
    kind : "root", "jump" or "end" (of the sliding equilibrium)
    direction : "to_stable" or "to_unstable" of this mode as the parameter rises; "gained" or
        "lost" of the equilibrium
    mode : number of the mode, counted at the lower end of the bracket by rising frequency; -1
        for an end
    frequency : of the mode, rad/s; NaN for an end
    below, above : number of growing modes on either side; -1 without an equilibrium
    """

    value: float
    width: float
    kind: str
    direction: str
    mode: int
    frequency: float
    below: int
    above: int

    @property
    def error(self) -> float:
        """How far `value` may be off.

        Its interval is that of the equations as rounded: of parameters and what is computed from
        them.
        """
        return self.width + ROUNDED * abs(self.value)


Found = TypeVar("Found")
Wish = list[float] | tuple[Modes, Modes]
Scan = Generator[Wish, Any, Found]


class ScanTooLong(Exception):
    """The modes are too rough a function of the parameter to be resolved."""


class _Hole(Exception):
    """Between two equilibria there is a `sample` without one."""

    def __init__(self, sample: Sample) -> None:
        super().__init__(sample)
        self.sample = sample


def critical_values(system: System, requests: Sequence[Request]) -> list[Outcome]:
    """Every crossing inside the bracket by rising value, with its kind, direction and mode."""
    settings = requests[0].settings
    varied, bracket, which = settings["parameter"], settings["bracket"], settings["system"]

    def answer(asked: Sequence[tuple[int, float]]) -> list[Sample]:
        points = [varied.at(requests[place].parameters, at) for place, at in asked]
        return _samples(system, points, which, [at for _, at in asked])

    scans = [find_crossings(*bracket) for _ in requests]
    found = side_by_side(scans, answer)
    ends = answer([(place, end) for place in range(len(requests)) for end in bracket])
    return [
        _outcome(system, request, crossings, pair)
        for request, crossings, pair in zip(
            requests, found, zip(ends[::2], ends[1::2], strict=True), strict=True
        )
    ]


def side_by_side(
    scans: Sequence[Scan[Found]], answer: Callable[[Sequence[tuple[int, float]]], list[Sample]]
) -> list[Found | None]:
    """What each scan finds; None of one that gives up.

    Parameters
    ----------
    answer : the modes for each (place of the scan, value) that is asked for
    """
    found: list[Found | None] = [None] * len(scans)
    wanted: dict[int, Wish] = {}

    def send(place: int, given: object) -> None:
        try:
            wanted[place] = scans[place].send(given)
        except StopIteration as end:
            found[place] = end.value
        except ScanTooLong:
            pass

    for place in range(len(scans)):
        send(place, None)
    while wanted:
        ending.heed()
        while pairs := {place: wish for place, wish in wanted.items() if isinstance(wish, tuple)}:
            for place, order in zip(pairs, followed(list(pairs.values())), strict=True):
                del wanted[place]
                send(place, order)
        asked = {place: wish for place, wish in wanted.items() if isinstance(wish, list)}
        wanted.clear()
        values = [(place, at) for place, wish in asked.items() for at in wish]
        samples = iter(answer(values) if values else ())
        for place, wish in asked.items():
            send(place, list(islice(samples, len(wish))))
    return found


def _outcome(
    system: System,
    request: Request,
    crossings: Sequence[Crossing] | None,
    ends: Sequence[Sample],
) -> Outcome:
    """What is told of a point."""
    varied, bracket = request.settings["parameter"], request.settings["bracket"]
    which, parameters = request.settings["system"], request.parameters
    if crossings is None:
        return Outcome(status="failed", reason="not_converged")
    if not crossings and not ends[0].exists:
        nowhere = sliding_system(system, varied.at(parameters, bracket[0]), which)
        return Outcome(status="failed", reason=why_none(nowhere))
    values = _described(crossings, ends)
    if which == "original":
        return Outcome(reason=_reason(crossings, []), values=values)
    ratios = [_ratio(system, varied.at(parameters, crossing.value)) for crossing in crossings]
    values["averaging_ratio"] = np.array(ratios)
    judged = ratios or [_ratio(system, varied.at(parameters, end)) for end in bracket]
    return Outcome(reason=_reason(crossings, judged), values=values)


def _described(crossings: Sequence[Crossing], ends: Sequence[Sample]) -> dict[str, object]:
    """The variables that hold the crossings."""
    growth = [float(end.values.real.max()) if end.exists else float("nan") for end in ends]
    return {
        "critical_value": np.array([c.value for c in crossings], float),
        "critical_width": np.array([c.width for c in crossings], float),
        "critical_error": np.array([c.error for c in crossings], float),
        "crossing_kind": np.array([c.kind for c in crossings], np.str_),
        "crossing_direction": np.array([c.direction for c in crossings], np.str_),
        "crossing_mode": np.array([c.mode for c in crossings], np.int64),
        "crossing_frequency": np.array([c.frequency for c in crossings], float),
        "unstable_below": np.array([c.below for c in crossings], np.int64),
        "unstable_above": np.array([c.above for c in crossings], np.int64),
        "n_crossings": len(crossings),
        "growth_at_low": growth[0],
        "growth_at_high": growth[1],
    }


def _reason(crossings: Sequence[Crossing], ratios: Sequence[float]) -> str:
    """The gravest; that nothing crosses, or ends, is also told by the crossings themselves."""
    if any(ratio < LEAST_RATIO for ratio in ratios):
        return "averaging_invalid"
    if any(crossing.kind == "end" for crossing in crossings):
        return "no_equilibrium_in_part"
    return "" if crossings else "no_crossing"


def _samples(
    system: System, points: Sequence[Mapping[str, float]], which: str, values: Sequence[float]
) -> list[Sample]:
    """The modes at the first equilibrium of each point, where the parameter has these values."""
    samples = [Sample(at, NOWHERE) for at in values]
    for rows, sliding in sliding_systems(system, points, which):
        signs, pieces = sliding.slip_signs.tolist(), sliding.pieces.tolist()
        firsts = [one.states[:1] for one in equilibria_at(sliding)]
        exist = [place for place, first in enumerate(firsts) if first]
        if exist:
            own, vectors = modes_at(sliding[exist], np.array([firsts[place][0] for place in exist]))
            modes = modes_of(own, vectors.swapaxes(1, 2))
            for place, row in enumerate(rows[exist].tolist()):
                at = exist[place]
                piece = (id(sliding.system), *pieces[at])
                samples[row] = Sample(values[row], modes[place], tuple(signs[at]), piece)
    return samples


def _ratio(system: System, parameters: Mapping[str, float]) -> float:
    """Excitation frequency over the highest natural one; NaN without an equilibrium."""
    state = sliding_system(system, parameters, "averaged")
    solutions = equilibria(state)
    if not solutions:
        return float("nan")
    return frequency_ratio(system, parameters, free_jacobian(state, solutions[0]))


def find_crossings(low: float, high: float) -> Scan[list[Crossing]]:
    """Every crossing between `low` and `high`, in order.

    Raises
    ------
    ScanTooLong : the modes are too rough a function of the parameter
    """
    scan = _Scan(NARROWEST * (high - low))
    ends = np.linspace(low, high, PIECES + 1)
    every = yield from scan.ask(*np.linspace(low, high, 2 * PIECES + 1).tolist())
    for place in range(1, PIECES):
        if _is_on_a_zero(*every[2 * place - 1 : 2 * place + 2]):
            ends[place] += ASIDE * (ends[1] - ends[0])
    yield from scan.ask(*ends.tolist(), *((ends[:-1] + ends[1:]) / 2.0).tolist())
    left, *others = yield from scan.ask(*ends.tolist())
    for right in others:
        left = yield from scan.piece(left, right)
    return sorted(scan.found, key=lambda crossing: crossing.value)


class _Scan:
    """Goes through a bracket from below, following the modes, and remembers what it was told."""

    def __init__(self, narrowest: float) -> None:
        self.narrowest = narrowest
        self.known: dict[float, Sample] = {}
        self.found: list[Crossing] = []

    def ask(self, *values: float) -> Scan[list[Sample]]:
        """The modes at these values, asked for where they are not known yet."""
        new = [at for at in dict.fromkeys(values) if at not in self.known]
        if len(self.known) + len(new) > MOST_SAMPLES:
            raise ScanTooLong
        if new:
            self.known |= zip(new, (yield new), strict=True)
        return [self.known[at] for at in values]

    def piece(self, left: Sample, right: Sample) -> Scan[Sample]:
        """Find what lies between two samples; the right one with its modes in order."""
        (middle,) = yield from self.ask((left.at + right.at) / 2.0)
        middle = yield from middle.after(left)
        ordered = yield from right.after(middle)
        try:
            is_wide = right.at - left.at > NARROW * self.narrowest
            one_piece = left.piece == middle.piece == right.piece
            if _is_resolved(left, middle, ordered) and (one_piece or not is_wide):
                self.found += yield from self.roots(left, ordered)
                return ordered
            if right.at - left.at <= self.narrowest and not _differs(middle, left, right):
                self.found += yield from self.singularity(left, ordered)
                return ordered
        except _Hole as hole:
            middle = hole.sample
        if _is_on_a_zero(left, middle, right):
            (middle,) = yield from self.ask(middle.at + ASIDE * (right.at - left.at))
        yield from self.ask((left.at + middle.at) / 2.0, (middle.at + right.at) / 2.0)
        middle = yield from self.piece(left, middle)
        return (yield from self.piece(middle, right))

    def roots(self, left: Sample, right: Sample) -> Scan[list[Crossing]]:
        """The roots of a resolved piece: one for each mode whose growth changes sign."""
        found: list[Crossing] = []
        if left.exists:
            changed = (left.growing != right.growing) & (left.values.imag >= 0.0)
            for mode in np.flatnonzero(changed).tolist():
                found.append((yield from self.root(left, right, mode)))
        return found

    def root(self, left: Sample, right: Sample, mode: int) -> Scan[Crossing]:
        """Where the real part of one mode, of opposite signs at the ends, is zero."""

        def eigenvalue(at: float) -> Scan[complex]:
            sample = yield from self.between(left, right, at)
            return complex(_solid(sample).values[mode])

        def rising(at: float) -> Scan[float]:
            growth = (yield from eigenvalue(at)).real
            return growth if right.growing[mode] else -growth

        resolution = 4.0 * ULP * max(abs(left.at), abs(right.at))
        value = yield from zero(rising, left.at, right.at, resolution)
        frequency = abs((yield from eigenvalue(value)).imag)
        if frequency == 0.0:
            yield from self.look_for_a_hole(value)
        low, high = yield from _straddled(rising, value, resolution, left.at, right.at)
        below, above = yield from self.ask(low, high)
        return Crossing(
            value=value,
            width=high - low,
            kind="root",
            direction="to_unstable" if right.growing[mode] else "to_stable",
            mode=mode,
            frequency=frequency,
            below=_count(below),
            above=_count(above),
        )

    def look_for_a_hole(self, value: float) -> Scan[None]:
        """Where an eigenvalue vanishes the stiffness is singular, and there may be no equilibrium.

        The hole may be as narrow as one floating-point number, which a root need not meet.
        """
        steps = range(-NEIGHBOURS, NEIGHBOURS + 1)
        for sample in (yield from self.ask(*(value + k * float(np.spacing(value)) for k in steps))):
            _solid(sample)

    def between(self, left: Sample, right: Sample, at: float) -> Scan[Sample]:
        """The modes inside a resolved piece, where straight lines lead to them."""
        share = (at - left.at) / (right.at - left.at)
        near = left if share < 0.5 else right
        expected = (1.0 - share) * left.values + share * right.values
        (sample,) = yield from self.ask(at)
        modes = modes_of(expected[None], near.modes.shapes[None])
        return (yield from sample.after(Sample(at, modes[0])))

    def singularity(self, left: Sample, right: Sample) -> Scan[list[Crossing]]:
        """What changes across a piece that cannot be resolved."""
        if left.exists != right.exists:
            ends = yield from self.bisected(left, right, lambda one: one.exists == left.exists)
            return [_end(*ends)]
        if any(one * other < 0.0 for one, other in zip(left.signs, right.signs, strict=True)):
            return (yield from self.reversal(left, right))
        if left.unstable != right.unstable:
            low, high = yield from self.bisected(left, right, _same_count(left, right))
            low = yield from low.after(left)
            return [_branching(low, (yield from high.after(low)))]
        return []

    def reversal(self, left: Sample, right: Sample) -> Scan[list[Crossing]]:
        """Where slip reverses: where it would stand still there is no equilibrium."""
        low, high = yield from self.bisected(
            left, right, lambda one: one.exists and one.signs == left.signs
        )
        still = Sample((low.at + high.at) / 2.0, NOWHERE) if high.exists else high
        gained = [_end(still, high)] if high.exists else []  # else it is what comes after
        before = yield from self.singularity(left, low)
        after = yield from self.singularity(high, right)
        return [*before, _end(low, still), *gained, *after]

    def bisected(
        self, left: Sample, right: Sample, is_left: Callable[[Sample], bool]
    ) -> Scan[tuple[Sample, Sample]]:
        """Two samples, as near as can be, between which `is_left` ceases to hold."""
        low, high = left, right
        for _ in range(HALVINGS):
            (middle,) = yield from self.ask((low.at + high.at) / 2.0)
            if middle.at in (low.at, high.at):
                break
            low, high = (middle, high) if is_left(middle) else (low, middle)
        return low, high


def _solid(sample: Sample) -> Sample:
    """The sample; `_Hole` where it has no equilibrium."""
    if not sample.exists:
        raise _Hole(sample)
    return sample


def _differs(middle: Sample, left: Sample, right: Sample) -> bool:
    """Whether only the middle has an equilibrium, or only the middle has none."""
    return left.exists == right.exists != middle.exists


def _is_on_a_zero(left: Sample, middle: Sample, right: Sample) -> bool:
    """Whether more real parts vanish in the middle than on either side: a root lies just there.

    No piece may end at it: to each side of it there would be none.
    """
    if not (left.exists and middle.exists and right.exists):
        return False
    vanishing = [int((~one.growing & ~one.decaying).sum()) for one in (left, middle, right)]
    return vanishing[1] > max(vanishing[::2])


def _is_resolved(left: Sample, middle: Sample, right: Sample) -> bool:
    """Whether straight lines tell all that the modes do between `left` and `right`."""
    if not left.exists == middle.exists == right.exists:
        return False
    if not left.exists:
        return True
    if len({one.signs for one in (left, middle, right)}) > 1:
        return False
    samples = np.array([left.values, middle.values, right.values])
    scale = float(np.abs(samples).max())
    signs_told = _signs_are_told(samples.real, NEUTRAL * scale)
    return bool(np.all(signs_told) and _cannot_meet(samples, scale))


def _signs_are_told(growth: Real, rounding: float) -> NDArray[np.bool_]:
    """For each mode, whether its real part has no zero in a piece, or just one, or is zero.

    Parameters
    ----------
    growth : real parts at the left end, in the middle and at the right end, (3, modes)
    rounding : what a vanishing real part may be
    """
    left, middle, right = growth
    bend = np.abs(middle - (left + right) / 2.0)
    zero = np.abs(growth) <= rounding
    one_sided = np.all(growth > rounding, axis=0) | np.all(growth < -rounding, axis=0)
    away = one_sided & (np.abs(growth).min(axis=0) > MARGIN * bend)
    opposite = (left * right < 0.0) & ~zero[0] & ~zero[2]
    rising_or_falling = (middle - left) * (right - middle) >= 0.0
    straight = bend <= BENT * np.abs(right - left)
    result: NDArray[np.bool_] = (
        np.all(zero, axis=0) | away | (opposite & rising_or_falling & straight)
    )
    return result


def _cannot_meet(samples: Complex, scale: float) -> bool:
    """Whether no two modes come so near that they could merge unseen inside the piece.

    Their difference must not turn by more than its own size: else they may pass each other, and
    modes that pass interact.

    Parameters
    ----------
    samples : eigenvalues at the left end, in the middle and at the right end, (3, modes)
    """
    apart = samples[:, :, None] - samples[:, None, :]
    change = np.abs(np.diff(apart, axis=0)).sum(axis=0)
    told = change <= np.abs(apart).min(axis=0)
    return bool(np.all(told | (change <= MEET * scale)))


def _count(sample: Sample) -> int:
    """Number of growing modes, those counted too that grow by no more than rounding."""
    return int((sample.values.real > 0.0).sum())


def _same_count(left: Sample, right: Sample) -> Callable[[Sample], bool]:
    """Whether as many modes grow as in `left`, those of rounding counted where they are none."""
    exact = _count(left) == left.unstable and _count(right) == right.unstable
    if exact:
        return lambda sample: _count(_solid(sample)) == left.unstable
    return lambda sample: _solid(sample).unstable == left.unstable


def _straddled(
    rising: Callable[[float], Scan[float]],
    value: float,
    step: float,
    lowest: float,
    highest: float,
) -> Scan[tuple[float, float]]:
    """The narrowest interval about a root, doubled from `step`, across which `rising` rises.

    At a distance of rounding it may do anything.
    """
    for _ in range(HALVINGS):
        low, high = max(value - step, lowest), min(value + step, highest)
        below = yield from rising(low)
        if below < 0.0 < (yield from rising(high)):
            return low, high
        step *= 2.0
    return lowest, highest


def _end(low: Sample, high: Sample) -> Crossing:
    """An end of the sliding equilibrium."""
    return Crossing(
        value=(low.at + high.at) / 2.0,
        width=high.at - low.at,
        kind="end",
        direction="lost" if low.exists else "gained",
        mode=-1,
        frequency=float("nan"),
        below=low.unstable,
        above=high.unstable,
    )


def _branching(low: Sample, high: Sample) -> Crossing:
    """A change of stability where modes branch (a root), or do not hang together (a jump)."""
    grew, grows = (one.values.real > 0.0 for one in (low, high))
    if grew.sum() == grows.sum():  # on one side rounding decides
        grew, grows = low.growing, high.growing
    rises = bool(grows.sum() > grew.sum())
    mode, growing = (
        _most_changed(high, grows & ~grew) if rises else _most_changed(low, grew & ~grows)
    )
    moved = float(np.abs(high.values - low.values).max())
    return Crossing(
        value=(low.at + high.at) / 2.0,
        width=high.at - low.at,
        kind="jump" if moved > JUMP * max(low.scale, high.scale) else "root",
        direction="to_unstable" if rises else "to_stable",
        mode=mode,
        frequency=abs(growing.imag),
        below=int(grew.sum()),
        above=int(grows.sum()),
    )


def _most_changed(sample: Sample, changed: NDArray[np.bool_]) -> tuple[int, complex]:
    """Of the modes that grow on one side alone the one that grows most: place and eigenvalue."""
    growth = np.where(changed & (sample.values.imag >= 0.0), sample.values.real, -np.inf)
    mode = int(np.argmax(growth))
    return mode, complex(sample.values[mode])
