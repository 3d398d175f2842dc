"""Closed-form and published answers, computed anew by the installed build.

Each function below solves one problem whose answer is known independently of this program and
returns `Check` values: what was found against what is expected. `fiv verify` prints them and the
test suite runs them.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from math import asin, atan, cos, hypot, inf, nan, pi, sin, sqrt

from fiv_cli import api
from fiv_cli.analyses.base import Outcome, SolverSettings, Start

RTOL = 1e-12  # tighter than the default of runs, so that closed forms are met to rounding
CLOSED = 1e-11  # tolerance against a closed form
RELEASE = {"event": "stick->slip"}

Bench = Callable[..., Outcome]
"""`api.analyse` at this tolerance."""
Problem = Callable[[Bench], Iterator["Check"]]


@dataclass(frozen=True)
class Check:
    """One number against its known value.

    Attributes
    ----------
    name : what it is, with its unit
    source : where the expected value comes from
    found, expected : values
    tolerance : largest accepted absolute difference
    """

    name: str
    source: str
    found: float
    expected: float
    tolerance: float

    @property
    def error(self) -> float:
        """Absolute difference; infinite when nothing was found."""
        difference = abs(self.found - self.expected)
        return difference if difference == difference else inf

    @property
    def passed(self) -> bool:
        """Whether the error is within the tolerance."""
        return self.error <= self.tolerance


def verify(
    announce: Callable[[str], None] = lambda message: None,
    problems: Sequence[Problem] | None = None,
) -> list[Check]:
    """Every check, computed now.

    Parameters
    ----------
    announce : called with a sentence when something must be generated or compiled first
    problems : which of `PROBLEMS`; all when left out
    """
    bench = partial(api.analyse, solver=SolverSettings(rtol=RTOL), announce=announce)
    chosen = PROBLEMS if problems is None else problems
    return [check for problem in chosen for check in solve(problem, bench)]


def solve(problem: Problem, bench: Bench) -> list[Check]:
    """The checks of one problem; a problem that cannot be computed is a failed check."""
    try:
        return list(problem(bench))
    except Exception as error:
        name = f"{getattr(problem, '__name__', 'trial')}: {type(error).__name__}: {error}"
        return [Check(name, "not computed", nan, nan, 0.0)]


def _value(outcome: Outcome, name: str) -> float:
    """A scalar answer, NaN when there is none."""
    return float(outcome.values.get(name, nan))


def _sections(outcome: Outcome, count: int) -> list[float]:
    """The `count` section values in rising order, NaN when there are others than `count`."""
    values = sorted(float(value) for value in outcome.ragged.get("section_value", ()))
    return values if len(values) == count else [nan] * count


def _largest_difference(found: Sequence[float], expected: Sequence[float]) -> float:
    """Over all pairs; infinite when there are more of one than of the other."""
    if len(found) != len(expected):
        return inf
    return max(abs(float(a) - b) for a, b in zip(found, expected, strict=True))


def _is(outcome: Outcome, attractor: str) -> float:
    """1 when the attractor is the one named, else 0."""
    return float(outcome.values.get("attractor") == attractor)


# --- one mass on a belt ------------------------------------------------------------------------
def coulomb_belt(bench: Bench) -> Iterator[Check]:
    """Stick-slip with Coulomb friction: slip is an arc of a circle, stick a straight line."""
    source = "thesis 3.1.1; closed form"
    reach, equilibrium = 1.7, 2.3  # (mu_s - mu_k) N / k and mu_k N / k, m
    slip, stick = pi + 2 * atan(1 / reach), 2 * reach
    moved = bench("belt-1dof", "coulomb", "history", {}, {"t_end": 56.0})
    first = asin(1 / equilibrium)  # from rest at x = 0 the mass slips up to the belt's speed
    release = first + 4.0 - (equilibrium - sqrt(equilibrium**2 - 1))
    releases = [release + cycle * (slip + stick) for cycle in range(7)]
    expected = [first, *(time for begin in releases for time in (begin, begin + slip))]
    worst = _largest_difference(moved.ragged["event_time"], expected)
    yield Check("event times, largest error of 15 (s)", source, worst, 0.0, CLOSED)
    found = bench("belt-1dof", "coulomb", "response", {})
    radius = hypot(1.0, reach)
    yield Check("period (s)", source, _value(found, "period"), slip + stick, CLOSED)
    yield Check("x at stick (m)", source, _sections(found, 1)[0], equilibrium - reach, CLOSED)
    yield Check("x_max (m)", source, _value(found, "x_max"), equilibrium + radius, CLOSED)
    yield Check("x_min (m)", source, _value(found, "x_min"), equilibrium - radius, CLOSED)
    spread = (radius**2 * slip + 2 * reach) / 2 + 2 * reach**3 / 3
    yield Check("L_s (m2)", source, _value(found, "L_s"), spread / (slip + stick), CLOSED)
    released = bench("belt-1dof", "coulomb", "response", {}, {"section": RELEASE})
    yield Check("x at release (m)", source, _sections(released, 1)[0], 4.0, CLOSED)
    yield from _neutral_circle(bench)
    yield from _multipliers(found)


def _neutral_circle(bench: Bench) -> Iterator[Check]:
    """Inside the circle of radius v / sqrt(k/m) the undamped sliding oscillates for ever."""
    source = "thesis 3.1.1; closed form"
    inside = bench("belt-1dof", "coulomb", "response", {"x": 2.0})
    neutral = float(inside.reason == "neutral_oscillation")
    yield Check("neutral inside the circle (1 yes)", source, neutral, 1.0, 0.0)
    yield Check("its L_s (m2)", source, _value(inside, "L_s"), 0.3**2 / 2, CLOSED)


def _multipliers(found: Outcome) -> Iterator[Check]:
    """Stick forgets the start and the flow repeats itself."""
    source = "one degree of freedom: {1, 0} exactly"
    first, second = found.values.get("floquet_multiplier", (nan, nan))
    yield Check("first Floquet multiplier", source, float(first), 1.0, CLOSED)
    yield Check("second Floquet multiplier", source, float(second), 0.0, CLOSED)


def free_decay(bench: Bench) -> Iterator[Check]:
    """A Coulomb oscillator at rest loses 4 mu_k N / k per cycle and stops in its dead zone."""
    source = "Den Hartog 1930; closed form"
    begin, kinetic, static = 20.0, 0.23, 0.4  # m, N, N
    half_cycles = 0
    end = begin
    while abs(end) > static:
        half_cycles += 1
        end = (begin - 2 * half_cycles * kinetic) * (-1) ** half_cycles
    moved = bench("belt-1dof", "coulomb", "history", {"x": begin}, {"t_end": 200.0}, v=0.0, N=1.0)
    stops = float(moved.ragged["event_time"][-1]) if len(moved.ragged["event_time"]) else nan
    yield Check("rest position (m)", source, float(moved.values["x"][-1]), end, CLOSED)
    yield Check("time of rest (s)", source, stops, half_cycles * pi, CLOSED)


def den_hartog(bench: Bench) -> Iterator[Check]:
    """Harmonic force and dry friction, without sticking."""
    source = "Den Hartog, Trans. ASME 53 (1930) 107"
    for friction, force, ratio in ((0.5, 1.0, 0.6), (0.5, 1.0, 1.5), (0.2, 1.0, 2.0)):
        gain = 1 / (1 - ratio**2)
        lag = sin(pi / ratio) / (ratio * (1 + cos(pi / ratio)))
        expected = force * sqrt(gain**2 - (friction * lag / force) ** 2)
        found = bench(
            "belt-1dof", "coulomb", "response", {"x": 1.0}, {"section": {"phase": 0.0}},
            v=0.0, N=1.0, mu_k=friction, mu_s=friction, u0=force, omega=ratio,
        )  # fmt: skip
        name = f"amplitude at f={friction}, b={ratio} (m)"
        yield Check(name, source, _value(found, "x_max"), expected, 1e-9)


def excited_masses(bench: Bench) -> Iterator[Check]:
    """A force that does work, and a belt whose acceleration sticking has to give to the mass."""
    mass, stiffness, omega, static, swing = 2.0, 3.0, 2.0, 1.2, 1.5  # kg, N/m, rad/s, N, m/s
    demand = (mass * omega - stiffness / omega) * swing
    moved = bench(
        "belt-1dof + v(t)", "coulomb", "history", {"x_dot": swing}, {"t_end": pi / omega},
        m=mass, k=stiffness, v=0.0, A_v=swing, omega_v=omega, N=1.0, mu_s=static, mu_k=0.1,
    )  # fmt: skip
    release = float(moved.ragged["event_time"][0])
    expected = asin(static / demand) / omega
    yield Check("release by a belt that accelerates (s)", "closed form", release, expected, CLOSED)
    found = bench(
        "belt-1dof + force_x", "coulomb", "response", {"x": 4.0}, {"powers": "mean"},
        c=0.1, A_x=2.0, omega_x=0.8, F_x=0.3,
    )  # fmt: skip
    damped = 0.1 * _value(found, "x_dot_rms") ** 2
    put_in = _value(found, "mean_force_x_power") + _value(found, "mean_friction_power")
    name = "power of a force and of friction, less that of a damper (W)"
    yield Check(name, "balance of work and energy", put_in - damped, 0.0, 1e-9)


def negative_slope(bench: Bench) -> Iterator[Check]:
    """Sliding is unstable if and only if the slope of friction is below -c."""
    source = "thesis 3.1.1, linear slope: growth -(c + alpha_0)/(2 m)"
    for damping in (0.05, 0.1, 0.2):
        found = bench("belt-1dof", "linear-slope", "eigenvalues", c=damping)
        growth = _value(found, "growth_rate")
        name = f"growth rate at alpha_0=-0.1, c={damping} (1/s)"
        yield Check(name, source, growth, (0.1 - damping) / 2, 1e-14)


def flutter(bench: Bench) -> Iterator[Check]:
    """Mode coupling: the friction at which sliding becomes unstable, with and without damping."""
    source = "thesis 3.29 by the criterion of Hurwitz"
    undamped = 5 / 2 + sqrt(3)
    found = _critical(bench, "flutter-2dof", "mu_k", 6.0, {})
    name = "flutter without damping, mu_k"
    yield Check(name, source, _crossing(found, 0), undamped, 1e-13)
    frequency = _of_crossing(found, "crossing_frequency", 0)
    yield Check("frequencies meet at (rad/s)", source, frequency, sqrt(2), 1e-7)
    for c in (1e-6, 0.2, 0.5):
        found = _critical(bench, "flutter-2dof", "mu_k", 9.0, {"c1": c, "c2": c})
        expected = undamped + 4 * (2 + sqrt(3)) * c**2
        yield Check(f"flutter, c1 = c2 = {c}, mu_k", source, _crossing(found, 0), expected, CLOSED)
    for c1, c2 in ((1e-6, 2e-6), (0.2, 0.4), (0.5, 1.0), (0.3, 0.1)):
        found = _critical(bench, "flutter-2dof", "mu_k", 20.0, {"c1": c1, "c2": c2})
        name = f"flutter, c1 = {c1}, c2 = {c2}, mu_k"
        yield Check(name, source, _crossing(found, 0), _hurwitz(c1, c2), CLOSED)
    yield Check("the same as damping vanishes", source, _hurwitz(1e-6, 2e-6), 3.7655445, 5e-8)


def _hurwitz(c1: float, c2: float) -> float:
    """Critical friction of the flutter model at m = k1 = k2 = 1, k3 = 2."""
    k11, k22 = cos(pi / 4) ** 2 + cos(pi / 6) ** 2, sin(pi / 4) ** 2 + sin(pi / 6) ** 2 + 2.0
    k12 = -sin(pi / 4) * cos(pi / 4) + sin(pi / 6) * cos(pi / 6)
    a1, a2, a3 = c1 * k22 + c2 * k11, k11 + k22 + c1 * c2, c1 + c2
    return ((k11 * k22 - a1 * (a2 * a3 - a1) / a3**2) / k12 - k12) / 2.0


def averaged_friction(bench: Bench) -> Iterator[Check]:
    """Dry friction under a fast oscillation of the slip velocity is viscous while it reverses."""
    source = "thesis 5.14"
    for speed in (0.0, 0.3, 0.301, 0.4, 3.0, 3e4):
        found = bench(
            "excited-2dof", "coulomb", "equilibrium", settings={"system": "averaged"},
            A_b=20.0 * speed,
        )  # fmt: skip
        share = float(found.values["F_T"][0] / found.values["F_N"][0]) / 0.4
        expected = 1.0 if speed <= 0.3 else 2.0 / pi * asin(0.3 / speed)
        name = f"averaged friction over mu_k F_N, v = 0.3, fast velocity {speed:g} m/s"
        yield Check(name, source, share, expected, 1e-14)


def suppression(bench: Bench) -> Iterator[Check]:
    """Mode coupling suppressed by a tangential excitation: eigenvalues of the averaged system."""
    source = "thesis 5.15 with -2 zeta a_2 in the entry (2, 4); separate computation"
    rest = _critical(bench, "excited-2dof", "mu_k", 1.0, {})
    yield Check("without excitation, mu_k", source, _crossing(rest, 0), 0.36562415, 5e-9)
    crossings = {0.7: (0.3, 0.300208, 0.398407), 0.4: (0.3,)}
    for friction, expected in crossings.items():
        found = _critical(bench, "excited-2dof", "A_b", 20.0, {"mu_k": friction}, "averaged")
        name = f"mu_k = {friction}: crossings"
        yield Check(name, source, _value(found, "n_crossings"), len(expected), 0.0)
        for number, ratio in enumerate(expected):
            value = _crossing(found, number) / 20.0
            tolerance = 1e-15 if number == 0 else 5e-7  # the first is the belt's velocity itself
            yield Check(f"mu_k = {friction}: A_b/R (N)", source, value, ratio, tolerance)


def belt_with_five_degrees(bench: Bench) -> Iterator[Check]:
    """Critical friction of the five-degree-of-freedom belt."""
    source = "thesis 6.4.1; separate computation"
    stiff = {"k4": 5e6, "k5": 5e6, "k6": 5e6, "k_nl": 1e7, "F": 800.0}
    cases: tuple[tuple[str, str, dict[str, float], float], ...] = (
        ("F = 200, k_nl = 1e4", "nonlinear", {}, 1.513784),
        ("F = 200, k_nl = 1e4, linear geometry", "linear", {}, 1.973910),
        ("a stiff belt, F = 800, k_nl = 1e7", "nonlinear", stiff, 1.735143),
    )
    for name, geometry, changes, expected in cases:
        options = {"geometry": geometry}
        found = _critical(bench, "belt-5dof", "mu_k", 3.0, changes, options=options)
        yield Check(f"{name}: critical mu_k", source, _crossing(found, 0), expected, 5e-7)


# --- sliders on elastic discs, linearised ---------------------------------------------------------
def rigid_contact_on_a_disc(bench: Bench) -> Iterator[Check]:
    """Where sliding loses stability as a disc slows down, and as it gains speed."""
    source = "thesis 4.3.1, Figures 4.4-4.7, at frozen speed; separate computation"
    cases = (
        ("slowing down, falling friction", (2.5, 10.0), 2.699143, (11.0, 1.0, 10.0)),
        ("speeding up, moving load", (0.1, 2.0), 1.171690, (1.0, 2.0, 0.0)),
    )
    for name, bracket, expected, (c_z, moment, alpha) in cases:
        settings = {"parameter": "Omega", "bracket": bracket, "system": "original"}
        found = bench(
            "disc-rigid-contact", "exponential", "critical", None, settings,
            c_z=c_z, C_phi=moment, alpha=alpha,
        )  # fmt: skip
        yield Check(f"{name}: Omega (rad/s)", source, _crossing(found, 0), expected, 5e-7)


def excited_disc_at_rest(bench: Bench) -> Iterator[Check]:
    """A moving load: the speed above which sliding on a disc is unstable."""
    source = "thesis 5.4.2, Figure 5.8(a) with xi = 2e-4; separate computation"
    settings = {"parameter": "Omega", "bracket": [1.0, 40.0], "system": "original"}
    law = {"mu_s": 1.0, "mu_0": 1.0, "mu_k": 1.0, "alpha": 0.0}
    found = bench(
        "excited-disc", "exponential", "critical", None, settings, F=100.0, xi=2e-4, **law
    )
    yield Check("onset of instability, Omega (rad/s)", source, _crossing(found, 0), 10.525, 5e-4)


def rigid_disc_with_a_stiffening_contact(bench: Bench) -> Iterator[Check]:
    """Mode coupling of a slider on a rigid disc: critical friction for three contacts."""
    source = "thesis 6.5.1, Figure 6.20; separate computation"
    for stiffening, expected in ((0.0, 1.01667), (1e6, 0.36353), (1e8, 2.13047)):
        changes, rigid = {"F": 1e4, "k_nl": stiffening}, {"geometry": "linear"}
        found = _critical(bench, "disc-nonlinear-contact", "mu_k", 3.0, changes, options=rigid)
        name = f"rigid disc, k_nl = {stiffening:g}: critical mu_k"
        yield Check(name, source, _crossing(found, 0), expected, 5e-6)


def _critical(
    bench: Bench,
    model: str,
    parameter: str,
    highest: float,
    changes: Mapping[str, float],
    system: str = "original",
    options: Mapping[str, str] | None = None,
) -> Outcome:
    """Every critical value of a parameter from zero to `highest`."""
    settings = {"parameter": parameter, "bracket": [0.0, highest], "system": system}
    return bench(model, "coulomb", "critical", None, settings, options=options, **changes)


def _crossing(outcome: Outcome, number: int) -> float:
    """One of the critical values, NaN when there are not so many."""
    return _of_crossing(outcome, "critical_value", number)


def _of_crossing(outcome: Outcome, name: str, number: int) -> float:
    values = outcome.values.get(name, ())
    return float(values[number]) if number < len(values) else nan


def hyperbolic_belt(bench: Bench) -> Iterator[Check]:
    """Stick-slip with friction falling hyperbolically."""
    source = "Leine et al., Nonlinear Dynamics 16 (1998) 41; separate computation"
    found = bench("belt-1dof", "hyperbolic", "response", {}, N=2.5, v=0.2, mu_0=0.4, delta=3.0)
    for name, expected in (("period", 12.001031295), ("x_max", 1.133944676), ("L_s", 0.378624222)):
        yield Check(f"hyperbolic law, {name}", source, _value(found, name), expected, 2e-9)


def excited_belt(bench: Bench) -> Iterator[Check]:
    """A moving base: periods that are multiples of the excitation's, and two coexisting ones."""
    source = "thesis 3.1.2 (3.10); separate computation"
    cases = (
        (0.85, 0.0, 1, (3.7190204,)),
        (1.2, 0.0, 4, (3.531843, 3.625851)),
        (1.2, 1.0, 3, (3.866518, 4.026946)),
    )
    for omega, velocity, ratio, releases in cases:
        settings = {"section": RELEASE, "t_max": 4000.0}
        start = {"x_dot": velocity}
        found = bench("belt-1dof", "coulomb", "response", start, settings, u0=0.5, omega=omega)
        label = f"omega={omega} from x_dot={velocity}"
        yield Check(f"{label}: period_ratio", source, _value(found, "period_ratio"), ratio, 1e-8)
        for value, expected in zip(_sections(found, len(releases)), releases, strict=True):
            yield Check(f"{label}: release x (m)", source, value, expected, 1e-6)
    torus = bench("belt-1dof", "coulomb", "response", {}, {"t_max": 20000.0}, u0=0.5, omega=0.5)
    label = "omega=0.5: "
    yield Check(f"{label}quasi-periodic (1 yes)", source, _is(torus, "quasiperiodic"), 1.0, 0.0)
    yield Check(f"{label}exponent (1/s)", source, _value(torus, "lyapunov"), 0.0, 6e-4)


# --- two masses, five degrees of freedom ---------------------------------------------------------
def two_masses(bench: Bench) -> Iterator[Check]:
    """Two masses on one belt that stick and slip independently and together."""
    source = "thesis 3.13-3.21, Figure 3.9; separate computation"
    found = bench("belt-2mass", "stribeck", "cycle", {}, {"t_max": 1000.0}, D=0.3)
    yield Check("D=0.3: period (s)", source, _value(found, "cycle_period"), 19.25064477, 5e-9)
    found = bench("belt-2mass", "stribeck", "cycle", {}, {"t_max": 1000.0}, D=0.2)
    yield Check("D=0.2: second multiplier", source, _second_multiplier(found), -0.987, 5e-4)
    for damping, attractor in ((0.3, "periodic"), (0.1, "chaotic")):
        settings = {"t_max": 20000.0}
        found = bench("belt-2mass", "stribeck", "response", {}, settings, D=damping)
        yield Check(f"D={damping}: {attractor} (1 yes)", source, _is(found, attractor), 1.0, 0.0)


def _second_multiplier(found: Outcome) -> float:
    """The multiplier that decides stability, the 1 of the flow left out."""
    others = [float(m) for m in found.values.get("floquet_multiplier_real", (nan, nan))][1:]
    return max(others, key=abs)


def five_degrees_at_rest(bench: Bench) -> Iterator[Check]:
    """Sliding equilibria and the eigenvalues of the coupled modes, to their printed digits."""
    source = "thesis 6.4.2.1, as printed (x1 at mu_k = 1.4 with its sign corrected)"
    for friction, printed, modes in FIVE_DEGREES:
        found = bench("belt-5dof", "coulomb", "equilibrium", mu_k=friction)
        worst = _largest_difference(found.values["equilibrium"][0], printed)
        yield Check(f"mu_k={friction}: equilibrium (m, rad)", source, worst, 0.0, 5e-5)
        linear = bench("belt-5dof", "coulomb", "eigenvalues", mu_k=friction)
        pairs = list(
            zip(linear.values["eigenvalue_real"], linear.values["eigenvalue_imag"], strict=True)
        )
        for growth, frequency, digit in modes:
            real, imaginary = min(
                pairs, key=lambda pair: hypot(pair[0] - growth, pair[1] - frequency)
            )
            name = f"mu_k={friction}: eigenvalue near {growth} + {frequency}i"
            yield Check(f"{name}, real (1/s)", source, float(real), growth, digit)
            yield Check(f"{name}, imaginary (rad/s)", source, float(imaginary), frequency, 0.05)


# Friction; x1, y1, x2, y2, phi; growth, frequency and half the last digit of the growth.
FIVE_DEGREES = (
    (0.3, (-0.0042, -0.0304, -0.0036, -0.0061, -0.0001),
     ((-0.05, 100.0, 0.005), (-0.04, 89.4, 0.005))),
    (1.4, (0.0053, -0.0263, -0.0147, -0.0053, 0.0026),
     ((-0.05, 98.7, 0.005), (-0.048, 93.7, 0.0005))),
    (2.5, (0.0124, -0.0233, -0.0232, -0.0046, 0.0041),
     ((11.98, 102.6, 0.005), (-12.08, 102.6, 0.005))),
)  # fmt: skip


def five_degrees_in_motion(bench: Bench) -> Iterator[Check]:
    """The fiftieth event of the slider from rest: slip, stick, reversal, separation, landing."""
    source = "thesis 6.1-6.17; separate computation (DOP853, every event polished)"
    cases = (
        (0.5, "plastic", 1.0356742081226),
        (1.4, "plastic", 1.0826872173375),
        (2.5, "plastic", 1.0853510460312),
        (1.4, "thesis", 0.0923560661710),
    )
    for friction, impact, expected in cases:
        options = {"impact": impact}
        moved = bench(
            "belt-5dof", "coulomb", "history", {}, {"t_end": 1.2}, options=options, mu_k=friction
        )
        yield _event(f"mu_k={friction}, impact {impact}", source, moved, 50, expected, 1e-10)
        yield _balance(f"mu_k={friction}, impact {impact}: energy", moved)


def _event(
    label: str, source: str, moved: Outcome, number: int, expected: float, tolerance: float
) -> Check:
    """The time of an event of a motion; that there was none in time is a failed check."""
    times = moved.ragged["event_time"]
    time = float(times[number - 1]) if len(times) >= number else nan
    return Check(f"{label}: time of event {number} (s)", source, time, expected, tolerance)


def _balance(name: str, moved: Outcome) -> Check:
    """Friction, damping and drive book their work; the rest is the change of T + U."""
    rest = _value(moved, "energy_residual")
    return Check(name, "energy balance: relative residual", rest, 0.0, CLOSED)


# --- discs ---------------------------------------------------------------------------------------
def annular_plate(bench: Bench) -> Iterator[Check]:
    """Frequencies and modal masses of the disc of Table 4.1, and of a tabulated plate."""
    from fiv_cli.plate import AnnularPlate, mode

    source = "thesis 3.3, corrected; separate computation"
    disc = AnnularPlate(a=0.044, b=0.12, h=0.002, rho=7200.0, E=150e9, nu=0.211)
    expected = (
        (1491.92691, 2.331299),
        (1516.75732, 4.654327),
        (1823.88110, 4.618520),
        (2774.19385, 4.541565),
    )
    for diameters, (frequency, mobility) in enumerate(expected):
        found, label = mode(disc, 0, diameters), f"mode (0, {diameters}): "
        yield Check(f"{label}frequency (rad/s)", source, found.frequency, frequency, 6e-6)
        inverse = found.inverse_modal_mass(0.1)
        yield Check(f"{label}R(r0)^2/M (1/kg)", source, inverse, mobility, 6e-7)
    half = AnnularPlate(a=0.5, b=1.0, h=0.01, rho=1.0, E=1.0, nu=0.3)
    for diameters, squared in enumerate((13.024, 13.290, 14.704, 18.562)):
        found, label = mode(half, 0, diameters), f"a/b = 0.5, nu = 0.3, mode (0, {diameters}): "
        yield Check(f"{label}lambda^2", "tables of plates", found.beta**2, squared, 6e-4)


# Model, law, start, changes, an event's number and its time (s). Up to it the motions slip, stick,
# separate and land.
RUNS = (
    ("disc-rigid-contact", "exponential", {"z": 1e-3, "phi_dot": 10.0}, {"N0": 50.0},
     30, 0.1400515870493637),
    ("disc-nonlinear-contact", "coulomb", {"u": 1e-2, "phi_dot": 20.0},
     {"mu_s": 0.8, "mu_k": 0.5}, 30, 0.2733972729113049),
)  # fmt: skip


def motion_on_a_disc(bench: Bench) -> Iterator[Check]:
    """Separation, landing, stick and reversal on elastic discs, by the event."""
    source = "saddle-point equations; separate computation (DOP853, every event polished)"
    for model, law, start, changes, number, expected in RUNS:
        moved = bench(model, law, "history", start, {"t_end": 0.3}, **changes)
        yield _event(model, source, moved, number, expected, 1e-11)
        yield _balance(f"{model}: energy", moved)


def main_frequencies_on_a_disc(bench: Bench) -> Iterator[Check]:
    """The lines of stick-slip on the undamped disc at constant speed, from the spectrum of 8 s.

    The motion settles for minutes (its second line grows); its frequencies are there at once:
    180.940 Hz from 4 to 12 s, 180.924 Hz half a minute later.
    """
    source = "thesis 4.3.2, Figures 4.8, 4.9, 4.13; separate computation"
    start = Start("near", "equilibrium", {"phi": 1e-4})
    settings = {
        "observe": "phi", "f_max": 400.0, "resolution": BIN, "window": 1.0 / BIN, "t_max": 8.0,
        "lyapunov": "never",
    }  # fmt: skip
    for c_z, C_phi, main, line in SPECTRA:
        found = bench(
            "disc-rigid-contact", "exponential", "spectrum", start, settings,
            c_z=c_z, C_phi=C_phi, alpha=1.0, Omega=2.0 * pi,
        )  # fmt: skip
        label = f"slider on the disc, c_z = {c_z:g}: "
        frequency = _value(found, "response_frequency")
        yield Check(f"{label}main frequency (Hz)", source, frequency, main, 0.05)
        if line is not None:
            second = _line_between(found, 280.0, 300.0)
            yield Check(f"{label}second line (Hz)", source, second, line, BIN)


# Damping of the contact and of the slider, main and second frequency (Hz) as far as they are known.
SPECTRA = ((0.1, 0.1, 180.9, 290.4), (2.0, 0.5, 205.7, None))
BIN = 0.125  # Hz


def _line_between(found: Outcome, low: float, high: float) -> float:
    """Frequency of the highest bin between two frequencies, Hz; NaN without a spectrum."""
    pairs = zip(found.values.get("frequency", ()), found.values.get("amplitude", ()), strict=False)
    inside = [(amplitude, f) for f, amplitude in pairs if low < f < high]
    return float(max(inside)[1]) if inside else nan


# --- pin on a disc -----------------------------------------------------------------------------
def pin_equilibrium(bench: Bench) -> Iterator[Check]:
    """Sliding equilibrium and eigenvalues at N0 = 30 N."""
    source = "thesis 7.12, 7.13, 7.17; separate computation"
    found = bench("pin-on-disc", "coulomb", "equilibrium")
    phi, theta = found.values["equilibrium"][0]
    yield Check("phi at equilibrium (rad)", source, float(phi), 0.03710376, 5e-9)
    yield Check("theta at equilibrium (rad)", source, float(theta), -0.01889605, 5e-9)
    yield Check("F_N at equilibrium (N)", source, float(found.values["F_N"][0]), 31.8207708, 5e-8)
    linear = bench("pin-on-disc", "coulomb", "eigenvalues")
    growths, frequencies = linear.values["eigenvalue_real"], linear.values["eigenvalue_imag"]
    expected = ((-0.5494, 112.8355), (-0.8673, 219.1599))
    for mode, (growth, frequency) in enumerate(expected):
        label = f"eigenvalue {mode + 1}"
        yield Check(f"{label}, real (1/s)", source, float(growths[2 * mode]), growth, 6e-5)
        imaginary = abs(float(frequencies[2 * mode]))
        yield Check(f"{label}, imaginary (rad/s)", source, imaginary, frequency, 6e-5)


def pin_stick_slip(bench: Bench) -> Iterator[Check]:
    """Stick-slip at Omega = 2 rad/s, and the sliding that coexists with it."""
    source = "thesis 7.3; separate computation"
    settings = {"section": RELEASE, "t_max": 60.0}
    found = bench("pin-on-disc", "coulomb", "response", {"phi_dot": 2.0}, settings)
    yield Check("period (s)", source, _value(found, "period"), 0.06852382, 5e-9)
    yield Check("phi at release (rad)", source, _sections(found, 1)[0], 0.06695594, 5e-9)
    near = {"phi": 0.037, "phi_dot": 0.1, "theta": -0.019}
    slides = bench("pin-on-disc", "coulomb", "response", near, settings)
    yield Check("slides from near (1 yes)", source, _is(slides, "equilibrium"), 1.0, 0.0)


def energy(bench: Bench) -> Iterator[Check]:
    """Friction, damping and drive book their work; the rest is the change of T + U."""
    belt = bench(
        "belt-1dof", "hyperbolic", "history", {}, {"t_end": 100.0}, u0=0.5, omega=0.85, c=0.1
    )
    yield _balance("belt, 100 s", belt)
    pin = bench(
        "pin-on-disc", "coulomb", "history", {"phi_dot": 2.0}, {"t_end": 3.0}, beta=2.0, psi_a=1.0
    )
    yield _balance("pin on a sector, 3 s", pin)


PROBLEMS: tuple[Problem, ...] = (
    coulomb_belt,
    free_decay,
    den_hartog,
    excited_masses,
    negative_slope,
    flutter,
    averaged_friction,
    suppression,
    belt_with_five_degrees,
    rigid_contact_on_a_disc,
    excited_disc_at_rest,
    rigid_disc_with_a_stiffening_contact,
    hyperbolic_belt,
    excited_belt,
    two_masses,
    five_degrees_at_rest,
    five_degrees_in_motion,
    annular_plate,
    motion_on_a_disc,
    main_frequencies_on_a_disc,
    pin_equilibrium,
    pin_stick_slip,
    energy,
)
