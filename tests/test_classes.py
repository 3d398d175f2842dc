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
from hypothesis import given, settings
from hypothesis import strategies as st
from motions import analyse, motion
from numpy.typing import NDArray
from scipy.optimize import brentq

from fiv_cli.analyses.base import Outcome, Question, SolverSettings, Start, Varied
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

    def compared(self, starts: Starts, truths: Iterable[str]) -> Comparison:
        """Every start that is told another class than the true one."""
        found = [str(self.told(start).values["attractor"]) for start in starts]
        wrong = [
            f"{self.model} {self.law} {dict(self.parameters)}: {tuple(map(float, start))} is {true}, told {told}"
            for start, true, told in zip(starts, truths, found, strict=True)
            if told not in (true, UNDECIDED)
        ]
        return Comparison(found, wrong)


@dataclass(frozen=True)
class Comparison:
    """What `response` told, and where that is false."""

    found: list[str]
    wrong: list[str]

    def share(self, kind: str) -> float:
        """Share of the starts that were told this class."""
        return self.found.count(kind) / len(self.found)


def assert_true(comparison: Comparison) -> None:
    """No class is false, and few are missing."""
    wrong, count = comparison.wrong, len(comparison.found)
    assert not wrong, "\n".join([f"{len(wrong)} of {count} starts are told a false class", *wrong])
    assert comparison.share(UNDECIDED) <= UNDECIDED_AT_MOST


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
    assert_true(on_a_belt(law, v).compared(starts, truths))


@every_belt
def test_classes_all_over_both_basins(law: str, v: float) -> None:
    starts = around(law, v, 50)
    assert_true(on_a_belt(law, v).compared(starts, enclosed(law, v, starts)))


BASIN = ((-2.0, 2.0), (0.0, 2.0))  # x, x': Stender & Hoffmann, bSTAB, Nonlinear Dynamics 2021
SHARES = {1.175: (0.01790, 0.0132), 1.5: (0.30579, 0.304)}  # exact; theirs, of 5,000 starts


def box(seed: int, count: int) -> Starts:
    """Random starts of the published box, shape (count, 2)."""
    low, high = zip(*BASIN, strict=True)
    return np.random.default_rng(seed).uniform(low, high, (count, 2))


def deviation(share: float, count: int) -> float:
    """Standard deviation of a share counted in a sample."""
    return float(np.sqrt(share * (1.0 - share) / count))


def compared_in_the_box(v: float, count: int) -> Comparison:
    """What random starts of the published box are told."""
    starts = box(round(1000 * v), count)
    found = on_a_belt("stribeck", v).compared(starts, enclosed("stribeck", v, starts))
    assert_true(found)
    return found


@pytest.mark.parametrize("v", SHARES)
def test_the_share_of_resting_starts(v: float) -> None:
    count, share = 1000, SHARES[v][0]
    found = compared_in_the_box(v, count)
    assert found.share(EQUILIBRIUM) == pytest.approx(share, abs=3.0 * deviation(share, count))


def test_a_boundary_lies_where_the_unstable_cycle_meets_the_start() -> None:
    def beyond(v: float) -> float:
        own = belt("stribeck", v)
        return own.cycle - own.rest - 0.8

    place = brentq(beyond, 1.2, 1.5, xtol=1e-9)
    assert place == pytest.approx(1.29086, abs=1e-5)
    of = on_a_belt("stribeck", 1.3)
    start = Start("beside", "equilibrium", {"x": 0.8})
    asked = {
        "parameter": Varied("v"), "bracket": (1.16, 1.7), "of": Question(name=EQUILIBRIUM),
        "t_max": PATIENT,
    }  # fmt: skip
    found = analyse(of.model, of.law, "boundary", start, asked, **of.parameters)
    (value,), (width,) = found.ragged["boundary"], found.ragged["boundary_width"]
    assert abs(value - place) <= width


# --- pin on a disc -------------------------------------------------------------------------------
@dataclass(frozen=True)
class Line:
    """Starts on a line from the equilibrium, which change their class at `border` of its length."""

    direction: tuple[float, ...]
    border: float


@dataclass(frozen=True)
class PinCase:
    """Speed, preload, damping; a start that ends in stick-slip; starts; and lines across a border.

    `border` of each line is recomputed by bisection in a campaign.
    """

    name: str
    pin: reference.Pin
    reach: tuple[float, ...]
    lines: tuple[Line, ...]


PINS = [
    PinCase("damped", reference.Pin(2.0, 30.0, 0.01), (0.1, 0.08, 2.4, 8.0), (
        Line((-0.1, 0.1, 0.0, 0.0), 0.0), Line((0.0, 0.0, -2.0, 0.0), 0.0),
        Line((0.05, 0.0, 0.0, 5.0), 0.0))),
    PinCase("usual", reference.Pin(5.0, 30.0, 0.001), (0.1, 0.08, 6.0, 8.0), (
        Line((-0.1, 0.1, 0.0, 0.0), 0.0), Line((0.0, 0.0, -5.0, 0.0), 0.0),
        Line((0.05, 0.0, 0.0, 5.0), 0.0))),
    PinCase("fast", reference.Pin(8.0, 30.0, 0.001, (-0.1, 0.0, -10.0, 0.0)),
            (0.12, 0.08, 12.0, 8.0), (Line((-0.1, 0.1, 0.0, 0.0), 0.0),)),
    PinCase("light", reference.Pin(2.0, 8.0, 0.001, (-0.02, 0.0, -3.0, 0.0)),
            (0.1, 0.05, 6.0, 5.0), (Line((-0.1, 0.1, 0.0, 0.0), 0.0),)),
]  # fmt: skip
every_pin = pytest.mark.parametrize("case", PINS, ids=lambda case: case.name)


def of_a_pin(pin: reference.Pin) -> Bistable:
    """The same pin in the program."""
    parameters = {"Omega": pin.Omega, "N0": pin.N0, "c1": pin.c, "c2": pin.c}
    states = ("phi", "theta", "phi_dot", "theta_dot")
    return Bistable("pin-on-disc", "coulomb", parameters, pin.classify, states)
