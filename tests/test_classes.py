"""Whether the classes that `response` tells are true: against proofs, in bistable systems.

The reference (``classes_reference.py``) decides by theorems and SciPy alone. Starts lie all over
both basins and on both sides of what separates them, down to a millionth of the distance from the
equilibrium. No class may be wrong; being undecided is no error, but must stay rare.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from functools import cache

import classes_reference as reference
import numpy as np
import pytest
from hypothesis import assume, example, given, settings
from hypothesis import strategies as st
from motions import motion
from numpy.typing import NDArray

from fiv_cli.analyses.base import Outcome, Question, SolverSettings, Start, Varied
from fiv_cli.api import analyse
from fiv_cli.dynamics.settings import Section

EQUILIBRIUM, PERIODIC = reference.EQUILIBRIUM, reference.PERIODIC
UNDECIDED = "undecided"
PATIENT = 20_000.0  # s; next to a border the slowest of these starts needs half of it
UNDECIDED_AT_MOST = 0.02  # share of a campaign's starts
DISTANCES = tuple(10.0**-power for power in range(1, 7))  # from a border, relative

Starts = NDArray[np.float64]


@dataclass(frozen=True)
class Bistable:
    """A system of the program beside its reference, both in the same variables.

    Attributes
    ----------
    model, law, parameters : as the program knows it
    truth : the reference's classifier of a start
    states : what a start is made of
    """

    model: str
    law: str
    parameters: Mapping[str, float]
    truth: Callable[..., str]
    states: tuple[str, ...]

    def told(self, start: Iterable[float], t_max: float = PATIENT) -> Outcome:
        """What `response` makes of a start."""
        values = dict(zip(self.states, map(float, start), strict=True))
        return analyse(
            self.model, self.law, "response", values, {"t_max": t_max}, **self.parameters
        )

    def told_truly(self, starts: Starts, truths: Iterable[str]) -> list[str]:
        """The classes that starts are told: none is false, and few are missing."""
        found = [str(self.told(start).values["attractor"]) for start in starts]
        wrong = [
            f"{tuple(map(float, start))} is {true}, told {told}"
            for start, true, told in zip(starts, truths, found, strict=True)
            if told not in (true, UNDECIDED)
        ]
        said = f"{self.model} {self.law} {dict(self.parameters)}: {len(wrong)} of {len(found)}"
        assert not wrong, "\n".join([f"{said} starts are told a false class", *wrong])
        assert found.count(UNDECIDED) / len(found) <= UNDECIDED_AT_MOST
        return found


# --- one mass on a belt --------------------------------------------------------------------------
DAMPING = 0.1  # N s/m
LAWS = {
    "stribeck": {"N": 1.0, "mu_s": 1.0, "mu_k": 0.5, "v_s": 0.5},
    "hyperbolic": {"N": 10.0, "mu_0": 0.4, "delta": 3.0},
}
BELTS = [
    ("stribeck", 1.175),  # a little above the Hopf point, ln(10)/2
    ("stribeck", 1.3),
    ("stribeck", 1.5),
    ("stribeck", 1.7),
    ("stribeck", 1.8),  # a little below the speed at which stick-slip is lost
    ("hyperbolic", 3.4),
    ("hyperbolic", 4.0),
    ("hyperbolic", 6.0),
    ("hyperbolic", 8.0),
]
every_belt = pytest.mark.parametrize(("law", "v"), BELTS)


@cache
def belt(law: str, v: float) -> reference.Belt:
    """The reference's belt; cached with its unstable cycle."""
    return reference.Belt(getattr(reference, law)(**LAWS[law]), v, DAMPING)


def on_a_belt(law: str, v: float) -> Bistable:
    """The same belt in the program."""
    own = LAWS[law] | ({"delta": 1.0} if law == "stribeck" else {})
    parameters = {"m": 1.0, "k": 1.0, "c": DAMPING, "v": v, **own}
    return Bistable("belt-1dof", law, parameters, belt(law, v).classify, ("x", "x_dot"))


def enclosed(law: str, v: float, starts: Starts) -> list[str]:
    """The true classes, from which side of the unstable cycle the starts lie on."""
    inside = [belt(law, v).inside(x, x_dot) < 1.0 for x, x_dot in starts]
    return [EQUILIBRIUM if one else PERIODIC for one in inside]


def around(law: str, v: float, count: int) -> Starts:
    """Starts in both basins, slip against the belt's motion included, shape (count, 2)."""
    own, random = belt(law, v), np.random.default_rng(round(1000 * v))
    reach = 1.4 * max(own.cycle - own.rest, v)
    return random.uniform((own.rest - reach, -reach), (own.rest + reach, reach), (count, 2))


def beside_the_cycle(law: str, v: float, angles: Iterable[float]) -> tuple[Starts, list[str]]:
    """Starts on both sides of the unstable cycle, shape (n, 2), and their true classes."""
    own, starts, truths = belt(law, v), [], []
    for angle in angles:
        for distance in DISTANCES:
            starts += [own.beside(angle, 1.0 - distance), own.beside(angle, 1.0 + distance)]
            truths += [EQUILIBRIUM, PERIODIC]
    return np.array(starts), truths


def test_growing_stick_slip_is_no_equilibrium() -> None:
    """Velocity maxima 1.27, 1.31, 1.35, and then 1.5, the speed of the belt, in every period."""
    assert belt("stribeck", 1.5).classify(1.87, 0.0) == PERIODIC
    assert on_a_belt("stribeck", 1.5).told((1.87, 0.0)).values["attractor"] == PERIODIC


@every_belt
def test_classes_on_both_sides_of_the_unstable_cycle(law: str, v: float) -> None:
    starts, truths = beside_the_cycle(law, v, (0.3, 3.4))
    on_a_belt(law, v).told_truly(starts, truths)


@every_belt
def test_classes_all_over_both_basins(law: str, v: float) -> None:
    starts = around(law, v, 50)
    on_a_belt(law, v).told_truly(starts, enclosed(law, v, starts))


BASIN = ((-2.0, 2.0), (0.0, 2.0))  # x, x': Stender & Hoffmann, bSTAB, Nonlinear Dynamics 2021
# Share of 5,000 starts that come to rest, there.
PUBLISHED = {
    1.175: 0.0132, 1.25: 0.08, 1.325: 0.1478, 1.4: 0.213, 1.475: 0.2776, 1.5: 0.304, 1.55: 0.3544,
    1.625: 0.4202, 1.7: 0.4922, 1.775: 0.5678,
}  # fmt: skip


def box(seed: int, count: int) -> Starts:
    """Random starts of the published box, shape (count, 2)."""
    low, high = zip(*BASIN, strict=True)
    return np.random.default_rng(seed).uniform(low, high, (count, 2))


def deviation(share: float, count: int) -> float:
    """Standard deviation of a share counted in a sample."""
    return float(np.sqrt(share * (1.0 - share) / count))


def resting_in_the_box(v: float, count: int) -> float:
    """Share of random starts of the published box that are told to rest."""
    starts = box(round(1000 * v), count)
    truths = enclosed("stribeck", v, starts)
    return on_a_belt("stribeck", v).told_truly(starts, truths).count(EQUILIBRIUM) / count


@pytest.mark.parametrize("v", [1.175, 1.5])
def test_the_share_of_resting_starts(v: float) -> None:
    count, share = 1000, belt("stribeck", v).share(*BASIN)
    assert resting_in_the_box(v, count) == pytest.approx(share, abs=3.0 * deviation(share, count))


def test_a_boundary_lies_where_the_unstable_cycle_meets_the_start() -> None:
    def beyond(v: float) -> float:
        own = belt("stribeck", v)
        return own.cycle - own.rest - 0.8

    place, known = 1.29086, 1e-5
    assert beyond(place - known) < 0.0 < beyond(place + known)
    of = on_a_belt("stribeck", 1.3)
    start = Start("beside", "equilibrium", {"x": 0.8})
    low, high, width = 1.16, 1.7, 1e-5  # m/s; the width is a share of the bracket
    asked = {
        "parameter": Varied("v"), "bracket": (low, high), "of": Question(name=EQUILIBRIUM),
        "width": width, "t_max": PATIENT,
    }  # fmt: skip
    found = analyse(of.model, of.law, "boundary", start, asked, **of.parameters)
    assert found.values["boundary"] == pytest.approx([place], abs=known + width * (high - low))


# --- pin on a disc -------------------------------------------------------------------------------
STATES = ("phi", "theta", "phi_dot", "theta_dot")


@dataclass(frozen=True)
class Line:
    """Starts on a line from the equilibrium.

    Attributes
    ----------
    away : the line's end, as an offset from the equilibrium
    border : share of it up to which starts come to rest; a campaign computes it again
    beyond : class behind the border
    """

    away: tuple[float, float, float, float]
    border: float
    beyond: str = PERIODIC


@dataclass(frozen=True)
class Pin:
    """A pin, how far from the equilibrium starts are drawn, and lines across its borders."""

    name: str
    own: reference.Pin
    reach: tuple[float, float, float, float]
    lines: tuple[Line, ...]

    @property
    def system(self) -> Bistable:
        """The same pin in the program."""
        own = self.own
        parameters = {"Omega": own.Omega, "N0": own.N0, "c1": own.c, "c2": own.c}
        return Bistable("pin-on-disc", "coulomb", parameters, own.classify, STATES)

    def around(self, count: int) -> Starts:
        """Random starts, shape (count, 4)."""
        random = np.random.default_rng(round(1000 * self.own.Omega + self.own.N0))
        reach = np.array(self.reach)
        return self.own.equilibrium + random.uniform(-reach, reach, (count, 4))

    def on(self, line: Line, ratio: float) -> Starts:
        """The start on a line with this ratio of its distance to that of the border."""
        return self.own.equilibrium + ratio * line.border * np.array(line.away)

    def across(self) -> tuple[Starts, list[str]]:
        """Starts on both sides of every border, shape (n, 4), and their classes."""
        starts, truths = [], []
        for line in self.lines:
            for distance in DISTANCES:
                starts += [self.on(line, 1.0 - distance), self.on(line, 1.0 + distance)]
                truths += [EQUILIBRIUM, line.beyond]
        return np.array(starts), truths

    def border(self, line: Line) -> float:
        """The border of a line, by bisection with the reference."""
        low, high = 0.99 * line.border, 1.01 * line.border
        while high - low > 1e-9 * high:
            middle = (low + high) / 2.0
            rests = self.own.classify(*self.on(line, middle / line.border)) == EQUILIBRIUM
            low, high = (middle, high) if rests else (low, middle)
        return (low + high) / 2.0


PINS = [
    Pin(
        "damped",
        reference.Pin(2.0, 30.0, 0.01),
        (0.1, 0.08, 2.4, 8.0),
        (
            Line((-0.1, 0.1, 0.0, 0.0), 0.1764348044),
            Line((0.0, 0.0, -2.0, 0.0), 1.7541636828),
            Line((0.05, 0.0, 0.0, 5.0), 0.6413043239),
        ),
    ),
    Pin(
        "usual",
        reference.Pin(5.0, 30.0, 0.001),
        (0.1, 0.08, 6.0, 8.0),
        (
            Line((-0.1, 0.1, 0.0, 0.0), 0.4069695489),
            Line((0.0, 0.0, -5.0, 0.0), 1.2717460436),
            Line((0.05, 0.0, 0.0, 5.0), 0.9014517397),
        ),
    ),
    Pin(
        "fast",
        reference.Pin(8.0, 30.0, 0.001, (-0.1, 0.0, -10.0, 0.0)),
        (0.12, 0.08, 12.0, 8.0),
        (
            Line((-0.1, 0.1, 0.0, 0.0), 0.6488222914),
            Line((0.0, 0.0, -8.0, 0.0), 1.4046302172),
            Line((-0.1, 0.0, -4.0, 0.0), 1.6783133578),
        ),
    ),
    Pin(
        "light",
        reference.Pin(2.0, 8.0, 0.001, (-0.02, 0.0, -3.0, 0.0)),
        (0.1, 0.05, 6.0, 5.0),
        (
            Line((-0.1, 0.1, 0.0, 0.0), 0.5223943126),
            Line((0.0, 0.0, -2.0, 0.0), 1.4539514351),
            Line((0.05, 0.0, 0.0, 5.0), 1.5002349352, beyond=reference.LOST),
        ),
    ),
]
every_pin = pytest.mark.parametrize("pin", PINS, ids=lambda pin: pin.name)


@every_pin
def test_classes_on_both_sides_of_the_pin_s_borders(pin: Pin) -> None:
    pin.system.told_truly(*pin.across())


@every_pin
def test_classes_of_the_pin_all_over_its_basins(pin: Pin) -> None:
    starts = pin.around(3)
    pin.system.told_truly(starts, [pin.own.classify(*start) for start in starts])


# --- what was told stays so ----------------------------------------------------------------------
LONGER = 10.0
FINE = 30  # samples of a period
BETWEEN = 1.01  # what lies between two samples, relative
ROUNDING = 1e-9  # of the distance of the unloaded state from the equilibrium
NEARBY, SAME = 1e-2, 1e-5  # distance from a cycle's section points, relative to its size
KEPT = 500  # later section points looked at


def stays_at_rest(system: Bistable, own: reference.Slider, start: Starts, decided: float) -> None:
    """No event, no growth, and nearer at the end than when it was told."""
    values = dict(zip(system.states, map(float, start), strict=True))
    slowest = 2.0 * np.pi / np.min(np.abs(own.modes[0].imag))
    asked = {"t_end": LONGER * decided + 2 * slowest, "sample": slowest / FINE}
    moved = analyse(system.model, system.law, "history", values, asked, **system.parameters)
    later = moved.values["time"] >= decided
    states = np.column_stack([moved.values[name][later] for name in system.states])
    floor = ROUNDING * own.distance(np.zeros(len(own.equilibrium)))
    distance = np.maximum(own.distance(states), floor)
    turns = [np.max(turn) for turn in np.array_split(distance, len(distance) // FINE)]
    assert np.max(moved.ragged["event_time"], initial=0.0) <= decided, start
    assert max(turns) <= BETWEEN * turns[0], start
    assert turns[-1] < turns[0] or turns[0] == floor, start


def stays_periodic(system: Bistable, start: Starts, told: Outcome) -> None:
    """Every later section point is near one of those told, and the last ones are the same."""
    values = dict(zip(system.states, map(float, start), strict=True))
    decided = told.values["transient_used"] + told.values["period"]
    moved = motion(
        system.model, system.law, values, SolverSettings(), None, 0.0, **system.parameters
    )
    moved.run(decided)
    room = np.zeros(KEPT), np.zeros((KEPT, len(system.states)))
    moved.run(LONGER * decided, Section("event"), room)
    points = room[1][: moved.n_sections, 0]
    least, greatest = (told.values[f"{system.states[0]}_{end}"] for end in ("min", "max"))
    apart = np.min(np.abs(points[:, None] - told.ragged["section_value"]), axis=1)
    assert len(points) > 0, start
    assert np.max(apart) <= NEARBY * (greatest - least), start
    assert np.max(apart[-len(told.ragged["section_value"]) :]) <= SAME * (greatest - least), start


def stays(system: Bistable, own: reference.Slider, start: Starts) -> None:
    """What `response` told of a start is still so after ten times the time."""
    told = system.told(start)
    kind = told.values["attractor"]
    if kind == EQUILIBRIUM:
        stays_at_rest(system, own, start, float(told.values["transient_used"]))
    elif kind == PERIODIC:
        stays_periodic(system, start, told)


unit = st.floats(-1.0, 1.0)
laws = st.sampled_from(sorted(LAWS))
offsets = st.lists(unit, min_size=4, max_size=4)
FROM_TO = {"stribeck": (1.0, 2.0), "hyperbolic": (3.0, 9.0)}  # m/s: round the bistable ranges


def belt_stays(law: str, speed: float, x: float, x_dot: float) -> None:
    """Speed and start are shares of their ranges."""
    assume(abs(x) + abs(x_dot) > 1e-6)  # an unstable equilibrium itself is left by rounding
    low, high = FROM_TO[law]
    own = belt(law, low + (high - low) * speed)
    stays(on_a_belt(law, own.v), own, own.equilibrium + 1.2 * own.v * np.array([x, x_dot]))


def pin_stays(pin: Pin, offset: list[float]) -> None:
    """The start is a share of the pin's reach."""
    stays(pin.system, pin.own, pin.own.equilibrium + np.array(pin.reach) * offset)


@settings(max_examples=100)
@example("stribeck", 0.5, 0.747, 0.0)  # (1.87, 0) at 1.5 m/s
@given(laws, st.floats(0.0, 1.0), unit, unit)
def test_what_is_told_of_a_belt_stays_so(law: str, speed: float, x: float, x_dot: float) -> None:
    belt_stays(law, speed, x, x_dot)


@settings(max_examples=20)
@given(st.sampled_from(PINS), offsets)
def test_what_is_told_of_a_pin_stays_so(pin: Pin, offset: list[float]) -> None:
    pin_stays(pin, offset)


# --- campaigns -----------------------------------------------------------------------------------
@pytest.mark.campaign
@every_belt
def test_many_classes_on_a_belt(law: str, v: float) -> None:
    """By integration, all over the basins and beside the unstable cycle."""
    starts = np.concatenate([around(law, v, 160), beside_the_cycle(law, v, (0.0, 1.1, 4.2))[0]])
    system = on_a_belt(law, v)
    system.told_truly(starts, [system.truth(*start) for start in starts])


@pytest.mark.campaign
@every_belt
def test_the_unstable_cycle_encloses_what_comes_to_rest(law: str, v: float) -> None:
    """The two proofs of the reference agree, also beside the cycle."""
    near, truths = beside_the_cycle(law, v, (0.3, 3.4))
    assert [belt(law, v).classify(*start) for start in near] == truths
    starts = around(law, v, 60)
    assert [belt(law, v).classify(*start) for start in starts] == enclosed(law, v, starts)


@pytest.mark.campaign
@pytest.mark.parametrize("v", PUBLISHED)
def test_shares_of_many_starts(v: float) -> None:
    """4,000 starts each; the published shares are within their own sampling error, too."""
    exact, count = belt("stribeck", v).share(*BASIN), 4000
    assert PUBLISHED[v] == pytest.approx(exact, abs=3.0 * deviation(exact, 5000))
    assert resting_in_the_box(v, count) == pytest.approx(exact, abs=3.0 * deviation(exact, count))


@pytest.mark.campaign
@every_pin
def test_many_classes_of_the_pin(pin: Pin) -> None:
    starts = np.concatenate([pin.around(120), pin.across()[0]])
    system = pin.system
    system.told_truly(starts, [system.truth(*start) for start in starts])


@pytest.mark.campaign
@every_pin
def test_the_borders_of_the_pin(pin: Pin) -> None:
    """Those of the quick tests, and the classes on their two sides."""
    for line in pin.lines:
        assert pin.border(line) == pytest.approx(line.border, rel=1e-8)
    starts, truths = pin.across()
    assert [pin.own.classify(*start) for start in starts] == truths


@pytest.mark.campaign
@settings(max_examples=1000)
@given(laws, st.floats(0.0, 1.0), unit, unit)
def test_what_is_told_of_many_belts_stays_so(
    law: str, speed: float, x: float, x_dot: float
) -> None:
    belt_stays(law, speed, x, x_dot)


@pytest.mark.campaign
@settings(max_examples=300)
@given(st.sampled_from(PINS), offsets)
def test_what_is_told_of_many_pins_stays_so(pin: Pin, offset: list[float]) -> None:
    pin_stays(pin, offset)
