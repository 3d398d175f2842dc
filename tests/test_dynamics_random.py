"""Random motions of every kind: energy balances, and two integrators see the same events."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from motions import motion, times, transitions
from small_models import BOUNCER, TWO_BOUNCERS, TWO_MASSES

from fiv_cli.analyses.base import SolverSettings
from fiv_cli.analyses.common import balance
from fiv_cli.dynamics.motion import Motion, Stop

COMPARED = 10  # events compared one by one: later ones may depend on the start without limit
ENDS = (Stop.REACHED, Stop.CONTACT_LOST)


class Draw:
    """Random numbers of one case."""

    def __init__(self, seed: int) -> None:
        self.random = np.random.default_rng(seed)

    def between(self, low: float, high: float) -> float:
        """Uniform."""
        return float(self.random.uniform(low, high))

    def scale(self, low: float, high: float) -> float:
        """Uniform in the logarithm."""
        return float(np.exp(self.random.uniform(np.log(low), np.log(high))))

    def often(self, value: float) -> float:
        """The value, or zero in one case of three."""
        return value if self.random.random() > 0.33 else 0.0

    def coulomb(self, largest: float = 1.0, equal: bool = False) -> dict[str, float]:
        """Two coefficients of friction; if they may be equal, they are in one case of three.

        Undamped, equal coefficients lead into the neutral circle that just touches the belt's
        speed: there rounding decides whether a mass sticks for an instant.
        """
        low, high = sorted((self.between(0.0, largest), self.between(0.0, largest)))
        more = self.often(high - low) if equal else high - low
        return {"mu_k": low, "mu_s": low + more}


def belt(draw: Draw, law: str) -> tuple[Any, ...]:
    """A forced mass on a belt."""
    changes = {
        "m": draw.scale(0.1, 10.0), "k": draw.scale(0.1, 10.0), "c": draw.scale(1e-3, 1.0),
        "N": draw.scale(1.0, 20.0), "v": draw.often(draw.between(-1.0, 1.0)),
        "u0": draw.often(draw.scale(0.01, 5.0)), "omega": draw.scale(0.1, 5.0),
    }  # fmt: skip
    changes |= {} if law == "hyperbolic" else draw.coulomb(equal=True)
    start = {"x": draw.between(-3.0, 3.0), "x_dot": draw.between(-2.0, 2.0)}
    return "belt-1dof", law, start, changes, {}, 60.0, 2e-3


def pin(draw: Draw) -> tuple[Any, ...]:
    """A pin on a disc with a sector."""
    changes = {
        "Omega": draw.scale(0.1, 50.0), "beta": draw.between(0.0, 6.28),
        "psi_a": draw.between(-7.0, 7.0), "N0": draw.scale(5.0, 60.0),
        "mu_k_2": draw.between(0.0, 0.3), "mu_s_2": draw.between(0.3, 0.6),
    }  # fmt: skip
    start = {"phi": draw.between(-0.05, 0.05), "phi_dot": draw.between(-3.0, 3.0)}
    return "pin-on-disc", "coulomb", start, changes | draw.coulomb(0.6), {}, 1.0, 2e-5


def bouncer(draw: Draw, contact: str) -> tuple[Any, ...]:
    """A mass that is lifted off its belt."""
    changes = {
        "A": draw.between(0.0, 30.0), "omega": draw.scale(0.5, 10.0), "k": draw.scale(0.1, 10.0),
        "k_z": draw.often(draw.scale(0.1, 10.0)), "v": draw.between(-2.0, 2.0),
        "k_c": draw.scale(50.0, 1e4),
    }  # fmt: skip
    start = {
        "z": draw.often(draw.between(0.0, 1.0)), "x_dot": draw.between(-1.0, 1.0),
        "z_dot": draw.often(draw.between(-1.0, 1.0)),
    }  # fmt: skip
    step = 2e-3 if contact == "rigid" else 2e-4
    return BOUNCER, "coulomb", start, changes | draw.coulomb(), {"contact": contact}, 8.0, step


def two_masses(draw: Draw) -> tuple[Any, ...]:
    """Two coupled masses on one belt."""
    changes = {name: draw.scale(0.1, 10.0) for name in ("k1", "k2", "k_c")}
    changes |= {"N1": draw.scale(1.0, 20.0), "N2": draw.scale(1.0, 20.0)}
    changes |= {"v": draw.between(-1.0, 1.0), **draw.coulomb()}
    start = {"x1": draw.between(-2.0, 2.0), "x2": draw.between(-2.0, 2.0)}
    return TWO_MASSES, "coulomb", start, changes, {}, 40.0, 2e-3


def two_bouncers(draw: Draw) -> tuple[Any, ...]:
    """Two masses that are lifted off one belt."""
    changes = {
        "A": draw.between(0.0, 30.0), "omega": draw.scale(0.5, 10.0), "k": draw.scale(0.1, 10.0),
        "m2": draw.scale(0.3, 3.0), "v": draw.between(-2.0, 2.0),
    }  # fmt: skip
    start = {name: draw.often(draw.between(0.0, 1.0)) for name in ("z1", "z2")}
    return TWO_BOUNCERS, "coulomb", start, changes | draw.coulomb(), {}, 8.0, 2e-3


def belt_2mass(draw: Draw, law: str) -> tuple[Any, ...]:
    """Two masses in a row on one belt."""
    changes = {
        "m1": draw.scale(0.3, 3.0), "m2": draw.scale(0.3, 3.0), "k1": draw.scale(0.1, 10.0),
        "k2": draw.scale(0.1, 10.0), "N": draw.scale(1.0, 20.0), "v": draw.between(-1.0, 1.0),
        "D": draw.scale(0.01, 0.5), "c1_over_c2": draw.often(draw.scale(0.1, 3.0)),
    }  # fmt: skip
    start = {"x1": draw.between(-3.0, 3.0), "x2": draw.between(-3.0, 3.0)}
    return "belt-2mass", law, start, changes | draw.coulomb(), {}, 40.0, 2e-3


def inclined(draw: Draw, model: str) -> tuple[Any, ...]:
    """A mass between inclined springs that may leave its belt."""
    changes = {
        "k3": draw.scale(0.3, 3.0), "c1": draw.often(draw.scale(1e-3, 0.3)),
        "c2": draw.often(draw.scale(1e-3, 0.3)), "F": draw.scale(0.5, 3.0),
        "v": draw.between(-1.0, 1.0), "alpha1": draw.between(0.2, 1.3),
    }  # fmt: skip
    if model == "excited-2dof":
        changes |= {"A_b": draw.often(draw.between(0.0, 5.0)), "R": draw.scale(0.5, 20.0)}
    start = {"x": draw.between(-2.0, 2.0), "y": draw.between(-3.0, 1.0)}
    return model, "coulomb", start, changes | draw.coulomb(1.5), {"states": "all"}, 30.0, 1e-3


def belt_5dof(draw: Draw, impact: str) -> tuple[Any, ...]:
    """The slider on an oscillating belt, with every option but the impact's drawn."""
    pick = draw.random.choice
    options = {
        "contact_stiffness": str(pick(["nonlinear", "linear"])),
        "geometry": str(pick(["nonlinear", "linear"])),
        "slope_force": str(pick(["omit", "include"])),
        "impact": impact,
    }
    changes = {
        "F": draw.scale(20.0, 1000.0), "k_nl": draw.scale(1e3, 1e7), "v": draw.between(-2.0, 2.0),
        "k1": draw.scale(3e3, 3e4), "k4": draw.scale(3e3, 3e4), "l1": draw.between(0.1, 0.4),
        "c4": draw.often(draw.scale(0.1, 10.0)),
    }  # fmt: skip
    start = {"x1": draw.between(-0.03, 0.03), "y1": draw.between(-0.08, 0.02)}
    start["x2"] = draw.often(draw.between(-0.03, 0.03))
    return "belt-5dof", "coulomb", start, changes | draw.coulomb(3.0), options, 0.5, 5e-5


KINDS = {
    "Coulomb belt": lambda draw: belt(draw, "coulomb"),
    "Stribeck belt": lambda draw: belt(draw, "stribeck"),
    "hyperbolic belt": lambda draw: belt(draw, "hyperbolic"),
    "pin": pin,
    "rigid bouncer": lambda draw: bouncer(draw, "rigid"),
    "compliant bouncer": lambda draw: bouncer(draw, "compliant"),
    "elastic bouncer": lambda draw: bouncer(draw, "elastic"),
    "two masses": two_masses,
    "two bouncers": two_bouncers,
    "two masses in a row": lambda draw: belt_2mass(draw, "stribeck"),
    "two masses in a row, Coulomb": lambda draw: belt_2mass(draw, "coulomb"),
    "inclined springs": lambda draw: inclined(draw, "flutter-2dof"),
    "inclined springs, excited": lambda draw: inclined(draw, "excited-2dof"),
    "oscillating belt": lambda draw: belt_5dof(draw, "plastic"),
    "oscillating belt, elastic": lambda draw: belt_5dof(draw, "none"),
}


def followed(case: tuple[Any, ...], method: str) -> tuple[Motion, Stop, float]:
    """A motion to its end, why it ended, and what its energy balance leaves over."""
    model, law, start, changes, options, t_end, step = case
    solver = SolverSettings(method, 1e-12, step, max_steps=500_000)
    begun = motion(model, law, start, solver, options, **changes)
    begun.start_measuring(np.zeros(len(begun.system.coordinates)))
    before = begun.energy()
    stop = begun.run(t_end, measuring=True)
    return begun, stop, balance(begun, before).residual


def check(kind: str, seed: int) -> int:
    """Follow one random motion by both integrators; returns its number of events."""
    case = KINDS[kind](Draw(seed))
    exact, stop, residual = followed(case, "taylor")
    rough, rough_stop, _ = followed(case, "rk4")
    assert stop in ENDS, (kind, seed)
    assert stop == rough_stop, (kind, seed)
    assert residual < 1e-9, (kind, seed)
    count = min(COMPARED, exact.n_events)
    assert transitions(exact)[:count] == transitions(rough)[:count], (kind, seed)
    apart = np.abs(times(exact)[:count] - times(rough)[:count])
    assert np.max(apart, initial=0.0) < 1e-4 * case[5], (kind, seed)
    return exact.n_events


@pytest.mark.parametrize("kind", KINDS)
def test_random_motions(kind: str) -> None:
    assert sum(check(kind, seed) for seed in range(10)) > 50


@pytest.mark.campaign
@pytest.mark.parametrize("kind", KINDS)
def test_many_random_motions(kind: str) -> None:
    assert sum(check(kind, seed) for seed in range(10, 100)) > 500
