"""Forces, moving bases and parameters that vary harmonically, against answers known apart.

Hong & Liu, Journal of Sound and Vibration 229 (2000) 1171 and 244 (2001) 883: a Coulomb oscillator
under a harmonic force, event by event. Shaw, Journal of Sound and Vibration 108 (1986) 305: with a
static coefficient above the kinetic one.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import partial

import numpy as np
import pytest
from motions import booked, motion, times
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

from fiv_cli import api
from fiv_cli.case.load import parse_case
from fiv_cli.errors import CaseError, UsageError
from fiv_cli.models import get_model


# --- the forced Coulomb oscillator ----------------------------------------------------------------
@dataclass(frozen=True)
class CoulombOscillator:
    """x'' + x = F + A cos(omega t + phase) - friction, the support at rest, in closed form."""

    A: float
    omega: float
    phase: float
    F: float
    kinetic: float
    static: float

    def force(self, t: float) -> float:
        return self.F + self.A * np.cos(self.omega * t + self.phase)

    def slide(self, t0: float, x0: float, v0: float, sign: float, t: float) -> tuple[float, float]:
        """Position and velocity while friction is `sign` * kinetic."""
        gain = self.A / (1.0 - self.omega**2)
        level = self.F + sign * self.kinetic

        def forced(s: float) -> tuple[float, float]:
            angle = self.omega * s + self.phase
            return level + gain * np.cos(angle), -gain * self.omega * np.sin(angle)

        (p0, d0), (p, d) = forced(t0), forced(t)
        c, s = np.cos(t - t0), np.sin(t - t0)
        a, b = x0 - p0, v0 - d0
        return p + a * c + b * s, d - a * s + b * c

    def events(self, x: float, count: int) -> list[float]:
        """Stops, releases and reversals of a motion from x, at rest or about to move."""
        found: list[float] = []
        t = 0.0
        while len(found) < count:
            if abs(self.force(t) - x) <= self.static:
                t = first_root(lambda s, x=x: self.static - abs(self.force(s) - x), t)
                found += [t]
            direction = np.sign(self.force(t) - x)
            slide = partial(self.slide, t, x, 0.0, -direction)
            end = first_root(lambda s, move=slide, way=direction: way * move(s)[1], t)
            t, x = end, slide(end)[0]
            found += [t]
        return found[:count]


def first_root(function: Callable[[float], float], start: float, step: float = 1e-3) -> float:
    """The first instant after `start` at which a function that is positive comes down to zero."""
    low = start + step
    while function(low + step) > 0.0:
        low += step
    return float(brentq(function, low, low + step, xtol=1e-15, rtol=1e-15))


@pytest.mark.parametrize(
    ("oscillator", "x"),
    [
        (CoulombOscillator(3.0, 0.6, 0.4, 0.3, 1.0, 1.0), 0.2),  # Hong & Liu, two stops a period
        (CoulombOscillator(1.6, 0.3, -1.0, 0.0, 1.0, 1.0), 0.0),  # several stops a period
        (CoulombOscillator(2.0, 1.7, 0.0, -0.4, 0.5, 1.2), 0.0),  # Shaw: mu_s above mu_k
    ],
)
def test_stops_and_reversals_of_a_forced_coulomb_oscillator(
    oscillator: CoulombOscillator, x: float
) -> None:
    o = oscillator
    begun = motion(
        "belt-1dof + force_x", start={"x": x}, v=0.0, N=1.0, mu_k=o.kinetic, mu_s=o.static,
        A_x=o.A, omega_x=o.omega, phase_x=o.phase, F_x=o.F,
    )  # fmt: skip
    expected = np.array(o.events(x, 30))
    begun.run(expected[-1] + 1e-6)
    found = np.unique(times(begun))  # a reversal is two transitions at one instant
    assert found == pytest.approx(expected, abs=1e-11)


def test_a_mass_without_a_spring_is_exact() -> None:
    """A belt takes it along; under a force it slides over the floor until both are even."""
    N, mu, m = 10.0, 0.23, 2.0
    taken = motion("belt-1dof", k=0.0, m=m, N=N, mu_k=mu, v=1.0)
    taken.run(5.0)
    caught = m / (mu * N)
    assert times(taken) == pytest.approx([caught], abs=1e-14)
    assert taken.y == pytest.approx([5.0 - caught / 2, 1.0], abs=1e-14)

    A, omega = 5.0, 2.0
    pushed = motion("belt-1dof + force_x", k=0.0, v=0.0, N=N, mu_k=mu, A_x=A, omega_x=omega)
    stop = first_root(lambda t: A / omega * np.sin(omega * t) - mu * N * t, 0.0)
    pushed.run(stop)
    assert times(pushed)[-1] == pytest.approx(stop, abs=1e-14)
    assert pushed.y[0] == pytest.approx(
        A / omega**2 * (1 - np.cos(omega * stop)) - mu * N * stop**2 / 2, abs=1e-14
    )


@pytest.mark.parametrize(("f", "p", "b", "amplitude"), [(0.5, 1.0, 0.6, 1.4865816)])
def test_the_amplitude_of_den_hartog(f: float, p: float, b: float, amplitude: float) -> None:
    found = api.analyse(
        "belt-1dof + force_x", "coulomb", "response", {"x": 1.0},
        {"section": {"phase": 0.0}}, v=0.0, N=1.0, mu_k=f, mu_s=f, A_x=p, omega_x=b,
    )  # fmt: skip
    assert found.values["attractor"] == "periodic"
    assert found.values["x_max"] == pytest.approx(amplitude, abs=1e-7)


# --- a speed that varies --------------------------------------------------------------------------
BELT = {"c": 0.05, "v": 1.0, "A_v": 0.8, "omega_v": 0.83, "phase_v": 0.3}
MU = {"mu_k": 0.23, "mu_s": 0.4}


def belt_events(count: int) -> list[float]:
    """Event times of a belt at a harmonic speed, from (4, 0), by SciPy on equations typed here."""
    c, v, A, omega, phase = BELT.values()
    kinetic, static = 10.0 * MU["mu_k"], 10.0 * MU["mu_s"]

    def speed(t: float) -> float:
        return v + A * np.cos(omega * t + phase)

    def held(t0: float, x0: float, t: float) -> tuple[float, float]:
        """Where the belt has carried the mass, and the force that holds it there."""
        turned = np.sin(omega * t + phase) - np.sin(omega * t0 + phase)
        x = x0 + v * (t - t0) + A / omega * turned
        return x, x + c * speed(t) - A * omega * np.sin(omega * t + phase)

    t, y, found = 0.0, np.array([4.0, 0.0]), list[float]()
    while len(found) < count:
        sign = np.sign(speed(t) - y[1]) or np.sign(held(t, y[0], t)[1])

        def rates(s: float, u: np.ndarray, sign: float = sign) -> list[float]:
            return [u[1], sign * kinetic - u[0] - c * u[1]]

        def slip(s: float, u: np.ndarray, sign: float = sign) -> float:
            return float(sign * (speed(s) - u[1]))

        slip.terminal, slip.direction = True, -1.0
        run = solve_ivp(rates, (t, t + 50.0), y, "DOP853", events=slip, rtol=1e-13, atol=1e-13,
                        max_step=0.02)  # fmt: skip
        t, y = float(run.t_events[0][0]), run.y_events[0][0]
        found.append(t)
        if abs(held(t, y[0], t)[1]) <= static:
            force = partial(held, t, y[0])
            t = first_root(lambda s, f=force: static - abs(f(s)[1]), t)
            y = np.array([force(t)[0], speed(t)])
            found.append(t)
    return found[:count]


def test_a_harmonic_speed_agrees_with_scipy_through_50_events() -> None:
    begun = motion("belt-1dof + v(t)", start={"x": 4.0}, N=10.0, **BELT, **MU)
    expected = np.array(belt_events(50))
    begun.run(expected[-1] + 1e-6)
    assert np.unique(times(begun)) == pytest.approx(expected, abs=1e-10)


def test_rest_on_a_belt_that_slows_down_is_told_by_its_least_speed() -> None:
    """From 0.1 off rest the mass moves at 0.1; a belt that comes down to 0.05 takes it along."""
    belt = "belt-1dof + v(t)"
    given = {"c": 0.1, "v": 1.0, "omega_v": 0.83, **MU}
    slides, sticks = (
        api.analyse(belt, "coulomb", "response", {"x": 2.4}, A_v=A, **given).values
        for A in (0.5, 0.95)
    )
    assert slides["attractor"] == "equilibrium"
    assert slides["decay_margin"] == pytest.approx(1 - 0.1 / 0.5, abs=5e-3)
    assert sticks["attractor"] == "periodic" and sticks["stick_fraction"] > 0.4


@pytest.mark.parametrize("A", [0.9, 1.1])
def test_what_a_force_cannot_move_is_at_rest(A: float) -> None:
    """It holds k x + A at the worst phase, 3 + A against 4, or slides at times."""
    given = {"v": 0.0, "mu_s": 0.4, "mu_k": 0.4, "A_x": A, "omega_x": 0.7}
    told = api.analyse("belt-1dof + force_x", "coulomb", "response", {"x": 3.0}, **given)
    assert (told.values["attractor"] == "equilibrium") == (A < 1.0)
    assert told.values["attractor"] != "equilibrium" or told.reason == "stuck"


def test_the_belts_acceleration_is_part_of_what_sticking_demands() -> None:
    """A mass that the belt shakes from its middle demands (k / omega - m omega) A sin(omega t)."""
    m, k, A, omega, hold = 2.0, 3.0, 1.5, 2.0, 1.2
    rest = motion("belt-1dof + v(t)", start={"x_dot": A}, m=m, k=k, v=0.0, A_v=A, omega_v=omega,
                  N=1.0, mu_s=hold, mu_k=0.1)  # fmt: skip
    demand = abs(k / omega - m * omega) * A
    assert hold < demand and hold > k / omega * A * 0.5  # neither part alone lets go then
    rest.run(np.pi / omega)
    release = times(rest)[0]
    assert release == pytest.approx(np.arcsin(hold / demand) / omega, abs=1e-12)


def test_a_disc_at_a_harmonic_speed_is_the_limit_of_a_schedule_of_points() -> None:
    start, A, omega, until = {"phi": 1e-3}, 1.0, 8.0, 0.4
    exact = motion(
        "excited-disc + Omega(t)", "exponential", start, Omega=5.0, A_Omega=A, omega_Omega=omega
    )
    exact.run(until)
    apart = []
    for count in (200, 800):
        instants = np.linspace(0.0, until, count + 1)
        points = [(t, 5.0 + A * np.cos(omega * t)) for t in instants.tolist()]
        near = motion("excited-disc", "exponential", start, curves={"Omega": points})
        near.run(until)
        apart.append(np.max(np.abs(near.y - exact.y)))
    assert apart[1] < apart[0] / 10 < 1e-4 * np.max(np.abs(exact.y))
    assert len(times(exact)) > 10


def test_a_base_that_moves_is_a_force_and_a_belt_that_moves_seen_from_it() -> None:
    a, omega, phase, c = 2.0, 1.3, 0.7, 0.2
    shaken = motion("belt-1dof + base", start={"x": 1.0}, c=c, A_base=a, omega_base=omega,
                    phase_base=phase)  # fmt: skip
    carried = motion(
        "belt-1dof + force_x + v(t)", c=c, A_x=a * omega**2, omega_x=omega, phase_x=phase,
        A_v=a * omega, omega_v=omega, phase_v=phase - np.pi / 2,
        start={"x": 1.0 - a * np.cos(phase), "x_dot": a * omega * np.sin(phase)},
    )  # fmt: skip
    shaken.run(60.0)
    carried.run(60.0)
    assert len(times(shaken)) > 20
    assert times(shaken) == pytest.approx(times(carried), abs=1e-10)


# --- energies -------------------------------------------------------------------------------------
EXCITED: Mapping[str, tuple[Mapping[str, float], Mapping[str, float]]] = {
    "belt-1dof + force_x + base": ({"x": 3.0}, {"A_x": 1.0, "A_base": 0.3, "F_x": 0.5, "c": 0.1}),
    "belt-2mass + force_x2 + base + v(t)": ({"x1": 1.0}, {"A_x2": 2.0, "A_base": 0.2, "A_v": 0.3}),
    "flutter-2dof + base + force_y": ({"y": -0.5}, {"A_base": 0.1, "A_y": 0.1, "c1": 0.1}),
    "excited-2dof + base": ({"y": -1.0}, {"A_base": 0.1, "omega_base": 0.5}),
    "belt-5dof + force_phi + base": ({"x1": 0.02}, {"A_phi": 1.0, "A_base": 1e-3}),
    "pin-on-disc + force_theta + N0(t)": ({"phi_dot": 2.0}, {"A_theta": 0.01, "A_N0": 3.0}),
}


@pytest.mark.parametrize("name", EXCITED)
def test_the_energies_of_excited_models_balance(name: str) -> None:
    start, changes = EXCITED[name]
    law = get_model(name).default_law
    found = booked(motion(name, law, start, **changes), 3.0)
    assert found.residual < 1e-11
    assert abs(found.other) > 1e-6


def test_mean_powers_balance_and_are_those_of_each_force() -> None:
    """On a cycle friction takes what is put in; a force, a base and a damper share the rest."""
    settings = {"section": {"phase": 0.0}, "powers": "mean"}
    given = {"c": 0.1, "A_x": 2.0, "omega_x": 0.8, "phase_x": 0.4, "F_x": 0.3}
    found = api.analyse(
        "belt-1dof + force_x", "coulomb", "response", {"x": 4.0}, settings, **given
    ).values
    assert found["attractor"] == "periodic" and found["stick_fraction"] > 0.1
    damped = given["c"] * found["x_dot_rms"] ** 2
    assert found["mean_other_power"] == pytest.approx(
        found["mean_force_x_power"] - damped, abs=1e-10
    )
    assert found["mean_friction_power"] + found["mean_other_power"] == pytest.approx(0.0, abs=1e-9)
    assert (
        found["mean_wear_power"] == found["mean_drive_power"] - found["mean_friction_power"] > 0.0
    )

    shaken = api.analyse(
        "belt-1dof + base", "coulomb", "response", {"x": 4.0}, settings,
        A_base=1.5, omega_base=0.8,
    ).values  # fmt: skip
    assert shaken["attractor"] == "periodic"
    assert shaken["mean_base_power"] == pytest.approx(shaken["mean_other_power"], abs=1e-10)
    assert abs(shaken["mean_base_power"]) > 1e-2


def test_a_history_books_the_work_of_each_force() -> None:
    """A spring without friction: from rest, a constant force has done F x."""
    found = api.analyse(
        "belt-1dof + force_x + base", "coulomb", "history", {}, {"t_end": 2.0},
        N=0.0, v=5.0, F_x=1.0,
    ).values  # fmt: skip
    assert found["x"][-1] == pytest.approx(1.0 - np.cos(2.0), abs=1e-9)
    assert found["force_x_work"] == pytest.approx(found["x"][-1], abs=1e-9)
    assert found["base_work"] == 0.0


@pytest.mark.parametrize(
    ("x", "c", "attractor"), [(6.0, 0.0, "periodic"), (2.31, 0.1, "equilibrium")]
)
def test_wear_of_stick_slip_and_of_sliding_in_closed_form(
    x: float, c: float, attractor: str
) -> None:
    """The belt slips by v T a period, whatever the mass does: mu_k N v; so it does at rest."""
    settings = {"powers": "mean"}
    found = api.analyse("belt-1dof", "coulomb", "response", {"x": x}, settings, c=c).values
    assert found["attractor"] == attractor
    assert found["mean_wear_power"] == pytest.approx(2.3, abs=1e-8)
    assert found["mean_friction_power"] == pytest.approx(0.0, abs=1e-8)


# --- in a case ------------------------------------------------------------------------------------
CASE = """\
schema = 1
[model]
name = "belt-1dof"
parameters = { c = 0.1 }
[forcing]
x = { amplitude = 2.0, omega = 0.7, phase = "30 deg", constant = 0.1 }
[schedule]
v = { mean = 1.2, amplitude = 0.2, omega = "omega_x" }
[grid]
A_v = [0.1, 0.2]
[[analysis]]
kind = "response"
section = { phase = 0 }
t_max = 400.0
"""
V, X = CASE.splitlines()[7], CASE.splitlines()[5]


def test_a_case_names_its_excitations_and_sweeps_them() -> None:
    text = CASE.replace("amplitude = 0.2, ", "")
    case = parse_case(text, "excited.toml", ())
    assert case.model == "belt-1dof + force_x + v(t) + omega_v = omega_x"
    at = case.parameters_at("coulomb", {"A_v": 0.2})
    assert at["omega_v"] == at["omega_x"] == 0.7 and at["v"] == 1.2
    assert at["phase_x"] == pytest.approx(np.pi / 6)
    found = api.run(case)
    assert (api.names_of(found["attractor"]) == "periodic").all()
    assert (found["period_ratio"] % 1.0 == 0.0).all()  # a count


def test_what_takes_the_value_of_what_varies_varies_with_it() -> None:
    one_belt = CASE.replace("belt-1dof", "belt-2mass").replace("parameters = { c = 0.1 }", "")
    one_belt = one_belt.replace("x = {", "x1 = {").replace("omega_x", "omega_x1")
    case = parse_case(one_belt.replace("amplitude = 0.2, ", ""), "two.toml", ())
    assert "v2(t)" in case.model
    at = case.parameters_at("stribeck", {"A_v": 0.2})
    assert (at["v2"], at["A_v2"], at["omega_v2"]) == (1.2, 0.2, 0.7)
    both = CASE.replace("belt-1dof", "excited-2dof").replace("parameters = { c = 0.1 }", "")
    both = both.replace(V, "mu_k = { amplitude = 0.1 }").replace("A_v = [0.1, 0.2]", "v = [0.3]")
    assert "mu_s(t)" in parse_case(both, "both.toml", ()).model  # and they stay equal
    given = one_belt.replace('name = "belt-2mass"', 'name = "belt-2mass"\nparameters.v2 = 1.0')
    assert "v2(t)" not in parse_case(given.replace("amplitude = 0.2, ", ""), "two.toml", ()).model


@pytest.mark.parametrize(
    ("was", "lines", "path", "words"),
    [
        (X, "y = { amplitude = 1.0 }", "forcing.y", "belt-1dof has no 'y' to force"),
        (X, "x = { omega = 1.0 }", "forcing.x.amplitude", "is missing"),
        (X, "x = { amplitude = -1.0 }", "forcing.x.amplitude", "out of range"),
        (X, "x = { amplitude = 1.0, mean = 1.0 }", "forcing.x.mean", "unknown key 'mean'"),
        (X, 'x = { amplitude = "1 m" }', "forcing.x.amplitude", "does not fit"),
        (X, X + "\nbase = { constant = 1.0 }", "forcing.base.constant", "no constant"),
        (V, "w = { amplitude = 1.0 }", "schedule.w", "there is no parameter 'w'"),
        (V, "v = { amplitude = 0.2, stop = 1.0 }", "schedule.v", "neither a ramp"),
        (V, "omega = { amplitude = 0.2 }", "schedule.omega", "constant one"),
        (V, 'v = { amplitude = 1.0, omega = "k" }', "schedule.v.omega", "'k' is in N m-1"),
        (V, 'v = { amplitude = 1.0, omega = "omega_v" }', "schedule.v.omega", "cannot follow"),
        (V, "c = { mean = 0.2, amplitude = 0.1 }", "schedule.c.mean", "also given by"),
        (V, "mu_k = { amplitude = 0.3 }", "schedule.mu_k.amplitude", "leaves its range"),
        (V, "mu_s = { mean = 0.3, amplitude = 0.1 }", "schedule.mu_s", "is above mu_s"),
        (V, "v = { amplitude = 0.1, omega = 0.33333 }", "forcing.x.amplitude", "common period"),
    ],
)
def test_what_is_wrong_is_said_with_its_place(was: str, lines: str, path: str, words: str) -> None:
    text = CASE.replace(was, lines).replace("[grid]\nA_v = [0.1, 0.2]\n", "")
    with pytest.raises(CaseError) as caught:
        parse_case(text, "excited.toml", ())
    assert [problem.path for problem in caught.value.problems] == [path]
    assert words in caught.value.problems[0].message


def test_a_pin_has_no_base_that_moves_and_is_told_what_a_moving_anchor_is() -> None:
    text = 'schema = 1\n[model]\nname = "pin-on-disc"\n[forcing]\nbase = { amplitude = 1e-4 }\n'
    with pytest.raises(CaseError, match=r"axes that stand still.*far end moves.*give it as phi"):
        parse_case(text + '[[analysis]]\nkind = "response"\n', "pin.toml", ())


@pytest.mark.parametrize(
    "name",
    ["belt-1dof + force_y", "belt-1dof + mu_k(t)", "belt-1dof + u", "pin-on-disc + base",
     "excited-disc + force_phi", "belt + force_x", "belt-1dof + force_x + force_x"],
)  # fmt: skip
def test_what_does_not_excite_a_model_is_refused_with_what_to_type(name: str) -> None:
    with pytest.raises(UsageError, match="next: "):
        api.analyse(name, None, "equilibrium")


def test_discs_are_driven_by_a_harmonic_speed_and_take_no_other_force() -> None:
    disc = CASE.replace("belt-1dof", "excited-disc").replace("parameters = { c = 0.1 }", "")
    speed = disc.replace(f"[forcing]\n{X}\n", "").replace(V, "Omega = { amplitude = 0.5 }")
    speed = speed.replace("[grid]\nA_v = [0.1, 0.2]\n", "")
    assert parse_case(speed, "disc.toml", ()).model == "excited-disc + Omega(t)"
    with pytest.raises(CaseError, match="takes no"):
        parse_case(disc, "disc.toml", ())


def test_a_fast_force_is_averaged_as_that_of_the_model_that_has_one() -> None:
    """Thesis 5.2 once by its own force, once as flutter-2dof under an external one."""
    shape = {"k1": 1.0, "k2": 0.5, "k3": 0.5, "alpha1": np.pi / 6, "alpha2": np.pi / 4}
    given = {**shape, "c1": 0.0, "c2": 0.0, "F": 2.0, "v": 0.3, "mu_k": 0.7, "mu_s": 0.7}
    settings, none = {"system": "averaged"}, None
    own = api.analyse("excited-2dof", "coulomb", "eigenvalues", none, settings,
                      A_b=8.0, R=20.0, **given)  # fmt: skip
    forced = api.analyse(
        "flutter-2dof + force_x", "coulomb", "eigenvalues", none, settings,
        A_x=8.0, omega_x=20.0, **given,
    )  # fmt: skip
    for part in ("eigenvalue_real", "eigenvalue_imag", "averaging_ratio"):
        np.testing.assert_allclose(forced.values[part], own.values[part], rtol=1e-9, atol=1e-12)


def test_cycles_of_a_harmonic_speed_have_the_multipliers_of_what_is_beside_them() -> None:
    """Sticking leaves one direction at each phase: one multiplier is zero, one is its decay."""
    given = {"v": 1.0, "A_v": 0.8, "omega_v": 0.83, **MU}
    found = api.analyse("belt-1dof + v(t)", "coulomb", "cycle", {"x": 4.0}, **given).values
    assert found["cycle_period"] == pytest.approx(2 * np.pi / 0.83, rel=1e-9)
    beside = []
    pair = [motion("belt-1dof + v(t)", start={"x": x}, **given) for x in (4.0, 4.001)]
    for turns in (11, 12):
        for one in pair:
            one.run(turns * found["cycle_period"])
        beside.append(pair[1].y[0] - pair[0].y[0])
    decay, zero = np.abs(found["floquet_multiplier"])
    assert zero < 1e-9 and decay == pytest.approx(beside[1] / beside[0], rel=1e-4)
