"""Lumped models once more, typed from the thesis and integrated by SciPy: nothing of fiv is used.

Each contact state has its own right-hand side and its own switching functions, as the thesis
writes them (stick of the five-degree-of-freedom model is the reduced system 6.7 with x2 from 6.5).
`solve_ivp` (DOP853) goes to each event, which is then polished by Newton steps that integrate
again from the last accepted step: SciPy's own root is one of its interpolant.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import solve_ivp

Vector = NDArray[np.float64]
Rate = Callable[[float, Vector], Vector]
Guard = Callable[[float, Vector], float]
Parameters = Mapping[str, float]

RTOL = 1e-13
POLISHES = 4
SLOPE_STEP = 1e-7  # s, for the slope of a switching function in a Newton step


@dataclass(frozen=True)
class Mode:
    """One contact state: its name, its motion and what ends it (each guard falls to zero).

    It may be written in fewer states: where those begin, and the full state they stand for.
    """

    name: str
    rate: Rate
    guards: Mapping[str, Guard]
    begins: Vector | None = None
    full: Callable[[float, Vector], Vector] = lambda t, y: y


@dataclass(frozen=True)
class Crossing:
    """An event: when, between which contact states, and the state after it."""

    time: float
    before: str
    after: str
    state: Vector


def integrate(rate: Rate, t: float, y: Vector, t_end: float, atol: float) -> Vector:
    """The state at `t_end`, which may lie before `t`."""
    if t_end == t:
        return y
    return solve_ivp(rate, (t, t_end), y, method="DOP853", rtol=RTOL, atol=atol).y[:, -1]


def terminal(guard: Guard, direction: float) -> Guard:
    """An event that ends an integration where `guard` passes through zero in this direction."""

    def event(t: float, y: Vector) -> float:
        return guard(t, y)

    event.terminal, event.direction = True, direction  # type: ignore[attr-defined]
    return event


def first_event(
    mode: Mode, t: float, y: Vector, t_end: float, max_step: float, atol: float
) -> tuple[str | None, float, Vector]:
    """The guard that falls to zero first (None: none before `t_end`), when, and the state then."""
    events = [terminal(guard, -1.0) for guard in mode.guards.values()]
    found = solve_ivp(
        mode.rate, (t, t_end), y, "DOP853", events=events, rtol=RTOL, atol=atol, max_step=max_step
    )
    if found.status != 1:
        return None, t_end, found.y[:, -1]
    hit = min(
        (times[0], name)
        for times, name in zip(found.t_events, mode.guards, strict=True)
        if len(times)
    )[1]
    time, state = polished(mode, hit, found, atol)
    return hit, time, state


def polished(mode: Mode, hit: str, found: Any, atol: float) -> tuple[float, Vector]:
    """The event by Newton's method on integrations that start at the last accepted step."""
    guard, base = mode.guards[hit], len(found.t) - 2
    t, y = found.t[base], found.y[:, base]
    time, state = found.t[-1], found.y[:, -1]
    for _ in range(POLISHES):
        state = integrate(mode.rate, t, y, time, atol)
        rate = mode.rate(time, state)
        ahead, behind = (guard(time + h, state + h * rate) for h in (SLOPE_STEP, -SLOPE_STEP))
        time -= guard(time, state) * 2 * SLOPE_STEP / (ahead - behind)
    return time, integrate(mode.rate, t, y, time, atol)


class Program:
    """A motion event by event, integrated with the absolute tolerance `atol`.

    Subclasses have the contact states `slip(sign)`, `stick(t, y)` and `separation()`, know which
    one a motion has at its `begin(y)` and where it `landed(t, y)`, how an impact `struck(y)`, and
    the friction force that is `holding(t, y)` beside the largest there is.
    """

    def follow(self, y: Vector, t_end: float, most: int) -> tuple[list[Crossing], Vector]:
        """Up to `most` events and the state at the last of them, or at `t_end`."""
        t, mode, events = 0.0, self.begin(y), list[Crossing]()
        while len(events) < most:
            start = y if mode.begins is None else mode.begins
            step = self.max_step(mode, t, y)
            hit, t, end = first_event(mode, t, start, t_end, step, self.atol)
            y = mode.full(t, end)
            if hit is None:
                break
            y = self.struck(y) if hit == "gap" else y
            before, mode = mode.name, self.next_mode(hit, t, y)
            events.append(Crossing(t, before, mode.name, y.copy()))
        return events, y

    def next_mode(self, hit: str, t: float, y: Vector) -> Mode:
        """The contact state that follows an event at (t, y)."""
        if hit == "normal":
            return self.separation()
        if hit == "gap":
            return self.landed(t, y)
        if hit in ("up", "down"):
            return self.slip(1.0 if hit == "up" else -1.0)
        friction, capacity = self.holding(t, y)
        held = abs(friction) <= capacity
        return self.stick(t, y) if held else self.slip(float(np.sign(friction)))


# --- five degrees of freedom (thesis 6.1-6.17) ---------------------------------------------------
X1, Y1, X2, Y2, PHI = range(5)
REDUCED = (X1, Y1, Y2, PHI)  # what is integrated in stick (6.7)
MAX_STEP_5DOF = 1.5e-3  # s: a thirtieth of the fastest oscillation of Table 6.1
STANDSTILL = 1e-11  # m/s: a gap rate this small after an impact is rounding


class FiveDof(Program):
    """The slider on an oscillating belt; state (x1, y1, x2, y2, phi) and their rates."""

    atol = 1e-15

    def __init__(self, parameters: Parameters, options: Mapping[str, str] | None = None) -> None:
        self.p = dict(parameters)
        chosen = dict(options or {})
        if chosen.get("contact_stiffness") == "linear":
            self.p["k_nl"] = 0.0
        self.turns = chosen.get("geometry", "nonlinear") == "nonlinear"
        self.impact = chosen.get("impact", "plastic")
        self.slope = chosen.get("slope_force", "omit") == "include"
        self.bilateral = chosen.get("states", "all") == "slip"

    # --- forces ---------------------------------------------------------------------------------
    def compression(self, y: Vector) -> float:
        """y2 - (x1 - x2) phi - y1 (6.2, 6.9)."""
        return y[Y2] - (y[X1] - y[X2]) * y[PHI] - y[Y1]

    def compression_rate(self, y: Vector) -> float:
        """Its time derivative, with the term that 6.13 lacks."""
        turning = (y[X1] - y[X2]) * y[5 + PHI] + (y[5 + X1] - y[5 + X2]) * y[PHI]
        return y[5 + Y2] - turning - y[5 + Y1]

    def normal(self, y: Vector) -> float:
        """F_N of a closed contact (6.2)."""
        d = self.compression(y)
        return self.p["k2"] * d + self.p["k_nl"] * d**3

    def slip_velocity(self, y: Vector) -> float:
        """v_r (6.3)."""
        return self.p["v"] + y[5 + X2] - y[5 + X1]

    def accelerations(self, y: Vector, friction: float, normal: float) -> Vector:
        """6.1, line by line."""
        p = self.p
        x1, y1, x2, y2, phi, x1_dot, y1_dot, x2_dot, y2_dot, phi_dot = y
        left = p["c5"] * (y2_dot + p["l1"] * phi_dot) + p["k5"] * (y2 + p["l1"] * phi)
        right = p["c6"] * (y2_dot - p["l2"] * phi_dot) + p["k6"] * (y2 - p["l2"] * phi)
        slope = normal * phi if self.slope else 0.0
        return np.array(
            [
                (friction + slope - p["c1"] * x1_dot - p["k1"] * x1 - 0.5 * p["k3"] * (x1 - y1))
                / p["M"],
                (normal - p["F"] - p["c2"] * y1_dot + 0.5 * p["k3"] * (x1 - y1)) / p["M"],
                (-friction - slope - p["c4"] * x2_dot - p["k4"] * x2) / p["m"],
                (-normal - left - right) / p["m"],
                (normal * (x1 - x2) - left * p["l1"] + right * p["l2"]) / p["J"] * self.turns,
            ]
        )

    def sticking(self, y: Vector) -> tuple[float, float]:
        """x1'' of 6.7, and the friction force that the first line of 6.1 then needs."""
        p = self.p
        slope = self.normal(y) * y[PHI] if self.slope else 0.0
        held = p["k1"] * y[X1] + 0.5 * p["k3"] * (y[X1] - y[Y1]) + p["c1"] * y[5 + X1]
        belt = p["c4"] * y[5 + X2] + p["k4"] * y[X2]
        acceleration = -(held + belt) / (p["M"] + p["m"])
        return acceleration, p["M"] * acceleration + held - slope

    # --- contact states -------------------------------------------------------------------------
    def slip(self, sign: float) -> Mode:
        """Sliding with friction of one sign (6.3, 6.4)."""

        def rate(t: float, y: Vector) -> Vector:
            normal = self.normal(y)
            friction = sign * self.p["mu_k"] * normal
            return np.concatenate([y[5:], self.accelerations(y, friction, normal)])

        guards: dict[str, Guard] = {
            "velocity": lambda t, y: sign * self.slip_velocity(y),
            "normal": lambda t, y: self.compression(y),
        }
        return Mode("slip+" if sign > 0 else "slip-", rate, {} if self.bilateral else guards)

    def stick(self, t_s: float, y_s: Vector) -> Mode:
        """The reduced system, written about the onset of stick (6.5, 6.7, 6.8)."""
        v, order = self.p["v"], [*REDUCED, *(5 + i for i in REDUCED)]

        def full(t: float, z: Vector) -> Vector:
            y = np.empty(10)
            y[order] = z
            y[X2] = y[X1] - y_s[X1] - v * (t - t_s) + y_s[X2]
            y[5 + X2] = y[5 + X1] - v
            return y

        def rate(t: float, z: Vector) -> Vector:
            y = full(t, z)
            x1_ddot, friction = self.sticking(y)
            others = self.accelerations(y, friction, self.normal(y))
            return np.array(
                [*(y[5 + i] for i in REDUCED), x1_ddot, others[Y1], others[Y2], others[PHI]]
            )

        def capacity(sign: float) -> Guard:
            def margin(t: float, z: Vector) -> float:
                y = full(t, z)
                return self.p["mu_s"] * self.normal(y) - sign * self.sticking(y)[1]

            return margin

        guards: dict[str, Guard] = {
            "up": capacity(1.0),
            "down": capacity(-1.0),
            "normal": lambda t, z: self.compression(full(t, z)),
        }
        return Mode("stick", rate, guards, y_s[order], full)

    def separation(self) -> Mode:
        """Out of contact (6.9)."""

        def rate(t: float, y: Vector) -> Vector:
            return np.concatenate([y[5:], self.accelerations(y, 0.0, 0.0)])

        return Mode("separation", rate, {"gap": lambda t, y: -self.compression(y)})

    # --- transitions ----------------------------------------------------------------------------
    def struck(self, y: Vector) -> Vector:
        """After the impact: 6.10-6.12 with 6.13 as corrected, or 6.14-6.17 as printed."""
        if self.impact == "none":
            return y
        p, lever, tilt = self.p, y[X1] - y[X2], y[PHI] if self.slope else 0.0
        missing = (y[5 + X1] - y[5 + X2]) * y[PHI]
        closing = self.compression_rate(y) + (missing if self.impact == "thesis" else 0.0)
        directions = np.array([tilt, 1.0, -tilt, -1.0, lever * self.turns])
        masses = np.array([p["M"], p["M"], p["m"], p["m"], p["J"]])
        effect = float(np.sum(directions**2 / masses))
        after = y.copy()
        after[5:] += closing / effect * directions / masses
        return after

    def kinetic(self, y: Vector) -> float:
        """T, J."""
        p = self.p
        masses = np.array([p["M"], p["M"], p["m"], p["m"], p["J"]])
        return float(np.sum(masses * y[5:] ** 2) / 2)

    def slips(self, y: Vector) -> Mode:
        """Sliding in the direction of the slip velocity."""
        return self.slip(1.0 if self.slip_velocity(y) > 0.0 else -1.0)

    def landed(self, t: float, y: Vector) -> Mode:
        """At zero compression the rate decides, and at zero rate the acceleration."""
        rate = self.compression_rate(y)
        decides = rate if abs(rate) > STANDSTILL else self.free_acceleration(y)
        return self.slips(y) if decides > 0.0 else self.separation()

    def free_acceleration(self, y: Vector) -> float:
        """Second derivative of the compression without contact forces."""
        a = self.accelerations(y, 0.0, 0.0)
        lever, sliding = y[X1] - y[X2], y[5 + X1] - y[5 + X2]
        turning = lever * a[PHI] + (a[X1] - a[X2]) * y[PHI] + 2 * sliding * y[5 + PHI]
        return a[Y2] - a[Y1] - turning

    def max_step(self, mode: Mode, t: float, y: Vector) -> float:
        """Short enough that no flight begins and ends within a step."""
        if mode.name != "separation":
            return MAX_STEP_5DOF
        hop = 2 * abs(self.compression_rate(y) / self.free_acceleration(y))
        return min(MAX_STEP_5DOF, hop / 4) if hop > 0.0 else MAX_STEP_5DOF

    def holding(self, t: float, y: Vector) -> tuple[float, float]:
        """Friction force that sticking needs, and the largest there is."""
        y[5 + X1] = self.p["v"] + y[5 + X2]
        return self.sticking(y)[1], self.p["mu_s"] * self.normal(y)

    def begin(self, y: Vector) -> Mode:
        """The contact state of a start with slip velocity."""
        d = self.compression(y)
        if self.bilateral:
            return self.slip(float(np.sign(self.p["v"])))
        if d == 0.0:
            return self.landed(0.0, y)
        return self.slips(y) if d > 0.0 else self.separation()


# --- two masses on one belt (thesis 3.13-3.21) ---------------------------------------------------
MAX_STEP_2MASS = 0.15  # s


class TwoMasses(Program):
    """Two masses on one belt with Stribeck friction; state (x1, x2, x1', x2').

    They begin in the states `kinds`: +1 or -1 for slip of that sign, 0 for stick.
    """

    atol = 1e-13

    def __init__(self, parameters: Parameters, kinds: Sequence[float]) -> None:
        self.p, self.kinds = dict(parameters), list(kinds)
        self.c2 = 2.0 * self.p["D"] * np.sqrt(self.p["m2"] * self.p["k2"])
        self.c1 = self.p["c1_over_c2"] * self.c2
        self.loads = self.p["N"], self.p["N2"]
        self.speeds = self.p["v"], self.p["v2"]

    def pulls(self, y: Vector) -> tuple[float, float]:
        """What springs and dampers pull with, against friction (3.13, 3.14; 3.16, 3.17)."""
        k1, k2 = self.p["k1"], self.p["k2"]
        x1, x2, x1_dot, x2_dot = y
        first = (self.c1 + self.c2) * x1_dot - self.c2 * x2_dot + (k1 + k2) * x1 - k2 * x2
        return first, self.c2 * (x2_dot - x1_dot) + k2 * (x2 - x1)

    def friction(self, mass: int, sign: float, slip: float) -> float:
        """3.12 with 3.15, continued analytically through zero slip."""
        p = self.p
        falling = (p["mu_s"] - p["mu_k"]) * np.exp(-sign * slip)
        return sign * (p["mu_k"] + falling) * self.loads[mass]

    def begin(self, y: Vector) -> Mode:
        """The combination of states that both contacts are in."""
        masses, kinds = (self.p["m1"], self.p["m2"]), tuple(self.kinds)
        v, capacities = self.speeds, [self.p["mu_s"] * load for load in self.loads]

        def rate(t: float, y: Vector) -> Vector:
            pulls = self.pulls(y)
            a = [
                (self.friction(i, kind, v[i] - y[2 + i]) - pulls[i]) / masses[i] if kind else 0.0
                for i, kind in enumerate(kinds)
            ]
            return np.array([y[2], y[3], *a])

        guards: dict[str, Guard] = {}
        for i, kind in enumerate(kinds):
            if kind:
                guards[f"{i} velocity"] = lambda t, y, i=i, kind=kind: kind * (v[i] - y[2 + i])
            else:
                guards[f"{i} up"] = lambda t, y, i=i: capacities[i] - self.pulls(y)[i]
                guards[f"{i} down"] = lambda t, y, i=i: capacities[i] + self.pulls(y)[i]
        return Mode(" ".join(_WORDS[kind] for kind in kinds), rate, guards)

    def next_mode(self, hit: str, t: float, y: Vector) -> Mode:
        """The contact that an event is on slips the way it is pulled, or sticks."""
        contact, what = int(hit[0]), hit[2:]
        self.kinds[contact] = {"up": 1.0, "down": -1.0}.get(what, 0.0)
        if what == "velocity":
            y[2 + contact] = self.speeds[contact]
            demand = self.pulls(y)[contact]
            held = abs(demand) <= self.p["mu_s"] * self.loads[contact]
            self.kinds[contact] = 0.0 if held else float(np.sign(demand))
        return self.begin(y)

    def max_step(self, mode: Mode, t: float, y: Vector) -> float:
        """Short enough that no pair of zeros is missed."""
        return MAX_STEP_2MASS


_WORDS = {1.0: "slip+", -1.0: "slip-", 0.0: "stick"}


# --- linear motions of the two-degree-of-freedom models (thesis 3.22, 5.1) ------------------------
def flutter_matrices(p: Parameters) -> tuple[Vector, Vector]:
    """Damping and stiffness of 3.22, 3.23: c1 horizontal, c2 vertical."""
    return np.diag([p["c1"], p["c2"]]), inclined(p, p["k1"], p["k2"], p["k3"])


def excited_matrices(p: Parameters) -> tuple[Vector, Vector]:
    """Damping and stiffness of 5.1, 5.2: dampers along the springs."""
    return inclined(p, p["c1"], p["c2"], 0.0), inclined(p, p["k1"], p["k2"], p["k3"])


def inclined(p: Parameters, first: float, second: float, vertical: float) -> Vector:
    """Two inclined elements and a vertical one (3.23, 5.2)."""
    s1, c1 = np.sin(p["alpha1"]), np.cos(p["alpha1"])
    s2, c2 = np.sin(p["alpha2"]), np.cos(p["alpha2"])
    cross = -first * s1 * c1 + second * s2 * c2
    return np.array(
        [
            [first * c1**2 + second * c2**2, cross],
            [cross, first * s1**2 + second * s2**2 + vertical],
        ]
    )


def sliding_motion(
    p: Parameters, matrices: tuple[Vector, Vector], start: Vector, times: Vector, sign: float = 1.0
) -> Vector:
    """(x, y, x', y') of bilateral sliding at `times`, by the matrix exponential.

    m q'' + C q' + K q = (sign mu N + A_b sin(omega t), -F) with N = -k3 y: the harmonic force and
    the constant are carried as two further pairs of states of one linear system.
    """
    from scipy.linalg import expm

    damping, stiffness = matrices
    m, amplitude = p["m"], p.get("A_b", 0.0)
    omega = p.get("R", 0.0) * np.sqrt(p["k1"] / m)
    friction = np.zeros((2, 2))
    friction[0, 1] = sign * p["mu_k"] * p["k3"]
    matrix = np.zeros((7, 7))
    matrix[:2, 2:4] = np.eye(2)
    matrix[2:4, :2] = -(stiffness + friction) / m
    matrix[2:4, 2:4] = -damping / m
    matrix[3, 4] = -p["F"] / m
    matrix[2, 5] = amplitude / m
    matrix[5, 6], matrix[6, 5] = omega, -omega
    begin = np.array([*start, 1.0, 0.0, 1.0])
    return np.array([(expm(matrix * t) @ begin)[:4] for t in times])
