"""Which motion a start leads to, once more: SciPy alone, nothing of fiv is used.

Three bistable systems, typed from the thesis (3.1 with 3.12 or a hyperbolic law; 7.12, 7.13 and
7.17). A motion goes from extremum to extremum of the slip velocity with DOP853, so that no pair of
zeros between two of them is missed. A class is told only where it is proved:

*One mass on a belt, equilibrium.* With F(u) convex, the damping force
D(y) = c y - (F(v - y) - F(v)) is concave, so y D(y) > 0 for every velocity y below its first
positive zero y*. The energy about the equilibrium falls at the rate y D(y); once it is below
min(y*, v)^2/2 the velocity stays below y* and v for ever, and the motion ends at rest.

*One mass on a belt, stick-slip.* Every stick ends in the same point of release. The future of all
motions that ever stick is that of this point: it is followed once.

*One mass on a belt, all starts at once.* The unstable cycle between the two is a closed curve of
a plane flow that is unique forwards and backwards along it. Nothing crosses it: what is inside
comes to rest, what is outside sticks. That there is one such cycle a campaign finds by integration.

*Pin, equilibrium.* V = |W^-1 y|^2 with the eigenvectors W of sliding falls at least as fast as
2 min|Re lambda| V in linear sliding. Below a level at which the rest of the force cannot make up
for that, and which touches neither zero slip nor zero normal force, it falls for ever.

*Pin, stick-slip.* The point of release has come within `NEAR` of that of a cycle, followed before
until it repeated to `REPEATS`, and still approaches.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from lumped_reference import Guard, Rate, Vector, terminal
from numpy.typing import NDArray
from scipy.integrate import solve_ivp
from scipy.optimize import brentq, minimize_scalar, root

EQUILIBRIUM, PERIODIC, LOST = "equilibrium", "periodic", "contact_lost"
RTOL = 1e-11
MOST_TURNS = 20_000  # extrema of the slip velocity of one motion
TURN = 8.0  # s: more than a period of the belt
SMALL = 1e-5  # m/s, for the slope of a law
NEAR = 1e-4  # of a cycle's point of release, relative to its size
REPEATS = 1e-9
GRAZES = 1e-9  # m/s or rad/s: a zero of the slip velocity no deeper than this is its minimum
FALLING, RISING = -1.0, 1.0


@dataclass(frozen=True)
class Path:
    """A smooth motion up to the first of several events: which one, and every step till then."""

    hit: int
    times: Vector
    states: NDArray[np.float64]  # (step, state)

    @property
    def end(self) -> Vector:
        """The state at the event."""
        return self.states[-1]


def until(
    rate: Rate, y: Vector, guards: list[tuple[Guard, float]], max_step: float, atol: float
) -> Path:
    """To the first guard that passes through zero in its direction."""

    events = [terminal(*guard) for guard in guards]
    found = solve_ivp(
        rate, (0.0, 1e6), y, "DOP853", events=events, rtol=RTOL, atol=atol, max_step=max_step
    )
    times = [(when[0], n) for n, when in enumerate(found.t_events) if len(when)]
    return Path(min(times)[1], found.t, found.y.T)


@dataclass(frozen=True)
class Passage:
    """From one extremum of the slip velocity to the next, or to a zero before it."""

    state: Vector
    time: float
    arrived: str  # "greatest", "least", "zero" or "lost"


class Slider:
    """What belt and pin share: passages of one sign of slip, and the way to the equilibrium.

    Attributes
    ----------
    equilibrium : state of steady sliding
    jacobian : of sliding at it
    max_step : of the integration, s; far below the fastest period
    atol : its absolute tolerance
    safe : normal force from which none is lost between two steps, N
    """

    equilibrium: Vector
    jacobian: NDArray[np.float64]
    max_step: float
    atol: float
    safe: float

    def rate(self, sign: float) -> Rate:
        """State -> its rate while the slip velocity has this sign."""
        raise NotImplementedError

    def slip(self, y: Vector) -> float:
        """Slip velocity, in any unit."""
        raise NotImplementedError

    def slip_rate(self, sign: float, y: Vector) -> float:
        """Its time derivative."""
        raise NotImplementedError

    def normal(self, y: Vector) -> float:
        """Normal force, N."""
        raise NotImplementedError

    @cached_property
    def modes(self) -> tuple[Vector, NDArray[np.complex128], NDArray[np.complex128]]:
        """Eigenvalues and eigenvectors W of sliding at the equilibrium, and W^-1."""
        values, vectors = np.linalg.eig(self.jacobian)
        return values, vectors, np.linalg.inv(vectors)

    def distance(self, y: Vector) -> Vector:
        """|W^-1 (y - equilibrium)| of states (..., n): in linear sliding it always falls."""
        return np.linalg.norm((y - self.equilibrium) @ self.modes[2].T, axis=-1)

    def passage(self, sign: float, y: Vector, rises: bool) -> Passage:
        """To the greatest slip speed where it rises, else to the least or to zero."""
        lost = (lambda t, y: self.normal(y), FALLING)
        speed = (lambda t, y: sign * self.slip(y), FALLING)
        turn: Guard = lambda t, y: sign * self.slip_rate(sign, y)  # noqa: E731
        guards = [lost, (turn, FALLING)] if rises else [lost, (turn, RISING), speed]
        words = ["lost", "greatest"] if rises else ["lost", "least", "zero"]
        step = self.max_step
        while True:
            path = until(self.rate(sign), y, guards, step, self.atol)
            if self.dips(self.rate(sign), path):
                return Passage(path.end, path.times[-1], "lost")
            word, depth = words[path.hit], -sign * self.slip(path.end)
            if word != "least" or depth <= GRAZES:
                grazes = word == "least" and depth >= 0.0
                return Passage(path.end, path.times[-1], "zero" if grazes else word)
            step = min(step, path.times[-1]) / 10.0

    def dips(self, rate: Rate, path: Path) -> bool:
        """Whether the normal force was lost and came back between two steps."""
        forces = [self.normal(y) for y in path.states]
        if min(forces) > self.safe:
            return False
        least = int(np.argmin(forces))
        low, high = max(least - 1, 0), min(least + 1, len(forces) - 1)
        times = path.times[low], path.times[high]
        near = solve_ivp(
            rate, times, path.states[low], "DOP853", rtol=RTOL, atol=self.atol, dense_output=True
        )
        found = minimize_scalar(
            lambda t: self.normal(near.sol(t)),
            bounds=times,
            method="bounded",
            options={"xatol": 1e-9 * (times[1] - times[0])},
        )
        return bool(found.fun < 0.0)


# --- one mass on a belt (thesis 3.1), m = k = 1 --------------------------------------------------
Law = Callable[[float], float]
"""Friction force, N, against slip speed u >= 0, m/s: convex and falling."""


def stribeck(N: float, mu_s: float, mu_k: float, v_s: float) -> Law:
    """3.12 with delta = 1."""
    return lambda u: N * (mu_k + (mu_s - mu_k) * np.exp(-u / v_s))


def hyperbolic(N: float, mu_0: float, delta: float) -> Law:
    """mu_0 N / (1 + delta u)."""
    return lambda u: N * mu_0 / (1.0 + delta * u)


class Belt(Slider):
    """State (x, x'); the slip velocity is v - x'."""

    def __init__(self, law: Law, v: float, c: float) -> None:
        self.force, self.v, self.c = law, v, c
        self.max_step, self.atol, self.safe = 0.05, 1e-13, 0.0
        self.rest = self.force(v)
        self.equilibrium = np.array([self.rest, 0.0])
        falls = (self.force(v - SMALL) - self.force(v + SMALL)) / (2.0 * SMALL)
        self.jacobian = np.array([[0.0, 1.0], [-1.0, falls - c]])

    def rate(self, sign: float) -> Rate:
        def motion(t: float, y: Vector) -> Vector:
            friction = sign * self.force(sign * (self.v - y[1]))
            return np.array([y[1], friction - self.c * y[1] - y[0]])

        return motion

    def slip(self, y: Vector) -> float:
        return self.v - y[1]

    def slip_rate(self, sign: float, y: Vector) -> float:
        return -self.rate(sign)(0.0, y)[1]

    def normal(self, y: Vector) -> float:
        return 1.0

    def energy(self, y: Vector) -> float:
        """About the equilibrium, J."""
        return ((y[0] - self.rest) ** 2 + y[1] ** 2) / 2.0

    @cached_property
    def level(self) -> float:
        """Energy below which sliding comes to rest, J; 0 where the equilibrium is unstable."""

        def damping(y: float) -> float:
            return self.c * y - self.force(self.v - y) + self.force(self.v)

        least = 1e-6 * self.v
        if damping(least) <= 0.0:
            return 0.0
        first = self.v if damping(self.v) > 0.0 else brentq(damping, least, self.v)
        return 0.999 * first**2 / 2.0

    def demand(self, x: float) -> float:
        """Friction force that stick at x needs, N."""
        return x + self.c * self.v

    @cached_property
    def released(self) -> tuple[str, float, float]:
        """What the point of release leads to, where it sticks again, m, and the period, s."""
        y = np.array([self.force(0.0) - self.c * self.v, self.v])
        kind, x, time = self._slides(1.0, y, True)
        return kind or PERIODIC, x, time + (y[0] - x) / self.v

    def _slides(self, sign: float, y: Vector, rises: bool) -> tuple[str, float, float]:
        """Slide until it is known to come to rest, or to where the slip velocity is zero."""
        total = 0.0
        for _ in range(MOST_TURNS):
            if sign > 0.0 and self.energy(y) < self.level:
                return EQUILIBRIUM, y[0], total
            found = self.passage(sign, y, rises)
            y, rises, total = found.state, found.arrived != "greatest", total + found.time
            if found.arrived == "zero":
                return "", y[0], total
        raise RuntimeError(f"not decided from {y}")

    def classify(self, x: float, x_dot: float) -> str:
        """The class of the motion from (x, x')."""
        y = np.array([x, x_dot])
        sign = float(np.sign(self.slip(y)))
        while True:
            if sign != 0.0:
                rises = sign * self.slip_rate(sign, y) > 0.0
                kind, x, _ = self._slides(sign, y, rises)
                if kind:
                    return kind
            if abs(self.demand(x)) <= self.force(0.0):
                return self.released[0]
            y, sign = np.array([x, self.v]), float(np.sign(self.demand(x)))

    # --- the unstable cycle ----------------------------------------------------------------------
    def returns(self, x: float) -> float:
        """How much further out a motion from (x, 0), x > x_e, turns next; inf where it sticks."""
        turned: Guard = lambda t, y: y[1]  # noqa: E731
        sticks: Guard = lambda t, y: self.slip(y)  # noqa: E731
        there, back = [(turned, RISING)], [(sticks, FALLING), (turned, FALLING)]
        rate, y = self.rate(1.0), np.array([x, 0.0])
        left = until(rate, y, there, self.max_step, self.atol).end
        path = until(rate, left, back, self.max_step, self.atol)
        return float(path.end[0] - x) if path.hit else np.inf

    @cached_property
    def cycle(self) -> float:
        """Greatest displacement of the unstable cycle, m: where `returns` is zero, by bisection."""
        low, high = self.rest + np.sqrt(2.0 * self.level), self.rest + 2.0 * self.v
        while high - low > 1e-13:
            middle = (low + high) / 2.0
            low, high = (middle, high) if self.returns(middle) <= 0.0 else (low, middle)
        return (low + high) / 2.0

    @cached_property
    def border(self) -> tuple[Vector, Vector]:
        """The unstable cycle about the equilibrium: angle, rad, rising, and distance, m."""
        y = np.array([self.cycle, 0.0])
        around = solve_ivp(
            self.rate(1.0), (0.0, TURN), y, "DOP853", np.linspace(0.0, TURN, 50_001), rtol=RTOL,
            atol=self.atol, max_step=self.max_step,
        )  # fmt: skip
        x, x_dot = around.y[0] - self.rest, around.y[1]
        angle = np.unwrap(np.arctan2(-x_dot, x))
        once = angle < 2.0 * np.pi
        return np.append(angle[once], 2.0 * np.pi), np.append(np.hypot(x, x_dot)[once], x[0])

    def inside(self, x: float, x_dot: float) -> float:
        """Distance from the equilibrium; 1: on the unstable cycle."""
        angle = np.arctan2(-x_dot, x - self.rest) % (2.0 * np.pi)
        return float(np.hypot(x - self.rest, x_dot) / np.interp(angle, *self.border))

    def beside(self, angle: float, ratio: float) -> tuple[float, float]:
        """The start (x, x') with this ratio of distances, in this direction, rad."""
        distance = ratio * float(np.interp(angle, *self.border))
        return self.rest + distance * np.cos(angle), -distance * np.sin(angle)

    def share(self, x: tuple[float, float], x_dot: tuple[float, float]) -> float:
        """Share of a box of starts that the unstable cycle encloses."""
        angle, distance = self.border
        place, speed = self.rest + distance * np.cos(angle), -distance * np.sin(angle)
        upper = angle >= np.pi
        places = np.linspace(*x, 100_001)
        high = np.interp(places, place[upper], speed[upper], left=0.0, right=0.0)
        low = np.interp(places, place[~upper][::-1], speed[~upper][::-1], left=0.0, right=0.0)
        inside = np.clip(high, *x_dot) - np.clip(low, *x_dot)
        return float(np.mean(inside) / (x_dot[1] - x_dot[0]))


# --- pin on a disc with an L-mechanism (thesis chapter 7, Table 7.1) -----------------------------
PHI, THETA = range(2)
J = np.array([12e-4, 5e-4])  # J_c and J_L, kg m2
K1, K2, K3 = 1500.0, 1000.0, 1000.0  # N/m
ARM = 0.1  # m: a0, b0, c0 and l2
HALF = ARM**2 / (2.0 * ARM)  # b0^2 / (2 l2), m


class Pin(Slider):
    """State (phi, theta, phi', theta'); the slip velocity, over b0, is Omega - phi'."""

    mu_s, mu_k = 0.4, 0.23

    def __init__(
        self, Omega: float, N0: float, damping: float, settles: tuple[float, ...] = ()
    ) -> None:
        self.Omega, self.N0, self.c = Omega, N0, damping
        self.settles = settles or (0.0, 0.0, Omega, 0.0)  # a start that ends in stick-slip
        self.max_step, self.atol, self.safe = 2e-3, 1e-14, 0.2 * N0

    def stretch(self, y: Vector) -> float:
        """Of spring k2 (7.7), m."""
        return ARM * y[THETA] + HALF * y[PHI] ** 2

    def normal(self, y: Vector) -> float:
        return self.N0 - K2 * self.stretch(y)

    def pull(self, y: Vector) -> float:
        """What springs and damper of the cylinder need of friction to keep phi'' = 0 (7.15), N."""
        springs = (K1 + K3) * ARM**2 * y[PHI] + 2.0 * K2 * HALF * y[PHI] * self.stretch(y)
        return (springs + K3 * ARM**2 * y[THETA] + self.c * y[2]) / ARM

    def lever(self, y: Vector) -> float:
        """theta'' (7.13)."""
        springs = K3 * ARM * (ARM * y[THETA] + ARM * y[PHI]) + K2 * ARM * self.stretch(y)
        return (-self.c * y[3] - springs) / J[THETA]

    def turned(self, sign: float, y: Vector) -> float:
        """phi'' of sliding (7.12 with 7.14)."""
        return ARM * (sign * self.mu_k * self.normal(y) - self.pull(y)) / J[PHI]

    def rate(self, sign: float) -> Rate:
        return lambda t, y: np.array([y[2], y[3], self.turned(sign, y), self.lever(y)])

    def slip(self, y: Vector) -> float:
        return self.Omega - y[2]

    def slip_rate(self, sign: float, y: Vector) -> float:
        return -self.turned(sign, y)

    # --- sliding equilibrium ---------------------------------------------------------------------
    @cached_property
    def equilibrium(self) -> Vector:  # type: ignore[override]
        def forces(q: Vector) -> Vector:
            y = np.array([*q, 0.0, 0.0])
            return np.array([self.turned(1.0, y), self.lever(y)])

        return np.array([*root(forces, np.zeros(2), tol=1e-14).x, 0.0, 0.0])

    @cached_property
    def jacobian(self) -> NDArray[np.float64]:  # type: ignore[override]
        phi, s = self.equilibrium[PHI], self.stretch(self.equilibrium)
        lever = 2 * HALF * phi  # of phi in the stretch
        cylinder = (K1 + K3) * ARM**2 + 2 * K2 * HALF * (s + phi * lever)
        crossed = K3 * ARM**2 + 2 * K2 * HALF * phi * ARM
        pressed = ARM * self.mu_k * K2
        stiffness = np.array(
            [
                [cylinder + pressed * lever, crossed + pressed * ARM],
                [K3 * ARM**2 + K2 * ARM * lever, (K2 + K3) * ARM**2],
            ]
        )
        damping = self.c * np.eye(2)
        below = -np.hstack([stiffness, damping]) / J[:, None]
        return np.vstack([np.hstack([np.zeros((2, 2)), np.eye(2)]), below])

    @cached_property
    def level(self) -> float:
        """Distance below which every motion slides to the equilibrium for ever."""
        values, vectors, inverse = self.modes
        decay, reach = -np.max(values.real), np.linalg.norm(vectors, axis=1)
        if decay <= 0.0:
            return 0.0
        pushes = np.linalg.norm(inverse, axis=0)[2:] / J

        def spare(r: float) -> float:
            return min(
                decay * r - float(pushes @ self._rest_of_force(r * reach)),
                self.Omega - r * reach[2],
                self.normal(self.equilibrium) - K2 * self._rest_of_stretch(r * reach),
            )

        return 0.999 * float(brentq(spare, 1e-9, 1e3))

    def _rest_of_stretch(self, away: Vector) -> float:
        """Bound of the change of the stretch for coordinates this far from the equilibrium, m."""
        a, b = away[:2]
        return ARM * b + 2 * HALF * abs(self.equilibrium[PHI]) * a + HALF * a**2

    def _rest_of_force(self, away: Vector) -> Vector:
        """Bound of the moments beyond those of `sliding`, N m."""
        a, phi = away[PHI], abs(self.equilibrium[PHI])
        cylinder = 2 * K2 * HALF * (a * self._rest_of_stretch(away) + phi * HALF * a**2)
        return np.array([cylinder + ARM * self.mu_k * K2 * HALF * a**2, K2 * ARM * HALF * a**2])

    # --- motions ---------------------------------------------------------------------------------
    def stick(self, y: Vector) -> Passage:
        """To the release; "greatest": pulled forwards, "least": backwards."""

        def rate(t: float, y: Vector) -> Vector:
            return np.array([self.Omega, y[3], 0.0, self.lever(y)])

        def spare(sign: float) -> Guard:
            return lambda t, y: self.mu_s * self.normal(y) - sign * self.pull(y)

        guards = [(lambda t, y: self.normal(y), FALLING), (spare(1.0), FALLING),
                  (spare(-1.0), FALLING)]  # fmt: skip
        path = until(rate, y, guards, self.max_step, self.atol)
        word = "lost" if self.dips(rate, path) else ("lost", "greatest", "least")[path.hit]
        return Passage(path.end, path.times[-1], word)

    def sticks(self, y: Vector) -> bool:
        """Whether a pin without slip stays so."""
        return abs(self.pull(y)) <= self.mu_s * self.normal(y)

    def slide(self, sign: float, y: Vector, rises: bool) -> tuple[str, Vector]:
        """Slide until it is known to come to rest, or to where the slip velocity is zero."""
        for _ in range(MOST_TURNS):
            if sign > 0.0 and self.distance(y) < self.level:
                return EQUILIBRIUM, y
            found = self.passage(sign, y, rises)
            y, rises = found.state, found.arrived != "greatest"
            if found.arrived in ("zero", "lost"):
                return LOST if found.arrived == "lost" else "", y
        raise RuntimeError(f"not decided from {y}")

    def motion(self, y: Vector, near: Callable[[Vector], bool]) -> str:
        """The class of a motion; periodic once a point of release is `near`."""
        if self.normal(y) <= 0.0:
            return LOST
        sign = float(np.sign(self.slip(y)))
        rises = sign * self.slip_rate(sign, y) > 0.0
        while True:
            if sign != 0.0:
                kind, y = self.slide(sign, y, rises)
                if kind:
                    return kind
                y[2] = self.Omega
            if self.sticks(y):
                held = self.stick(y)
                if held.arrived == "lost":
                    return LOST
                y = held.state
                if near(y):
                    return PERIODIC
            sign, rises = float(np.sign(self.pull(y))), True

    @cached_property
    def cycle(self) -> Vector:
        """Point of release of the stick-slip cycle, of one stick a period."""
        points: list[Vector] = []

        def repeats(y: Vector) -> bool:
            points.append(y.copy())
            apart = [np.max(np.abs(p - y) / np.abs(y)) for p in points[-4:-1]]
            return len(apart) == 3 and max(apart) < REPEATS

        kind = self.motion(np.array(self.settles), repeats)
        if kind != PERIODIC:
            raise RuntimeError(f"no cycle from {self.settles}: {kind}")
        return points[-1]

    def classify(self, *y: float) -> str:
        """The class of the motion from (phi, theta, phi', theta')."""
        apart: list[float] = []

        def near(y: Vector) -> bool:
            apart.append(float(np.max(np.abs(y / self.cycle - 1.0))))
            approaches = len(apart) > 1 and apart[-1] < apart[-2]
            return apart[-1] < REPEATS or (apart[-1] < NEAR and approaches)

        return self.motion(np.array(y), near)
