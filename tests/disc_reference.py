"""Sliders on elastic discs once more, typed from the thesis and integrated by SciPy.

Nothing of the program's equations is used. The disc's modes come with a scale of their own: shapes
R(r), modal masses M_kl by quadrature of 4.35, frequencies. With q the thesis' modal coordinates
and n = R(r0) {cos, sin}(l phi), the motion is the solution of one linear system at each instant,

    [ masses   -(B + s mu D) ] [accelerations]   [forces]
    [   G             0      ] [     F_N     ] = [ -G'  ]

where B is what a unit normal force does to each coordinate, D what a unit friction force does, G
the gradient of the gap z - w(r0, phi) and G' its part quadratic in the velocities (4.17). In stick
phi'' = Omega' is one more row and the friction force one more unknown. With a contact spring F_N
is known and the last row is not there. `lumped_reference` locates and polishes the events.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from lumped_reference import Guard, Mode, Parameters, Program, Vector
from numpy.typing import NDArray
from scipy.integrate import quad

from fiv_cli.plate import AnnularPlate, mode

Matrix = NDArray[np.float64]
PHI, NORMAL = 0, 1  # the slider's two coordinates, before those of the disc
MAX_STEP = 2e-4  # s: a tenth of the period of the highest mode
STANDSTILL = 1e-11  # m/s: a gap rate this small after an impact is rounding


@dataclass(frozen=True)
class Shape:
    """One real mode in the thesis' scale: cosine or sine, R(r0), M_kl and omega_kl."""

    diameters: int
    sine: bool
    radius: float
    mass: float
    frequency: float


def shapes(parameters: Parameters, scale: float = 3.7) -> list[Shape]:
    """The thesis' seven modes; shapes are `scale` times the mass-normalised ones."""
    p = parameters
    plate = AnnularPlate(*(p[name] for name in ("a", "b", "h", "rho", "E", "nu")))
    found = []
    for n in range(4):
        plain = mode(plate, 0, n)
        integral = quad(lambda r, m=plain: float(m.shape(r)) ** 2 * r, p["a"], p["b"])[0]
        mass = p["rho"] * p["h"] * np.pi * (1 if n else 2) * integral * scale**2
        radius = scale * float(plain.shape(p["r0"]))
        found += [
            Shape(n, sine, radius, mass, plain.frequency) for sine in ((False, True)[: 1 + (n > 0)])
        ]
    return found


class Turn:
    """Omega(t): piecewise linear through points, constant outside."""

    def __init__(self, points: Sequence[tuple[float, float]]) -> None:
        self.points = list(points)

    def speed(self, t: float) -> float:
        """Omega, rad/s."""
        return float(np.interp(t, *zip(*self.points, strict=True)))

    def rate(self, t: float) -> float:
        """Omega', rad/s^2, of the piece that begins at or before `t`."""
        for (begun, first), (ended, last) in pairwise(self.points):
            if begun <= t <= ended:
                return (last - first) / (ended - begun)
        return 0.0


class SliderOnDisc(Program):
    """State (phi, z or u, q...) and rates; subclasses say what the slider is held by."""

    rigid, atol = True, 1e-18

    def __init__(
        self,
        parameters: Parameters,
        options: Mapping[str, str] | None = None,
        turn: Sequence[tuple[float, float]] = (),
        modes: Sequence[Shape] = (),
    ) -> None:
        self.p = dict(parameters)
        self.options = dict(options or {})
        self.modes = list(modes) or shapes(parameters)
        self.turn = Turn(turn or [(0.0, self.p["Omega"])])
        order = np.array([s.diameters for s in self.modes])
        self.order, self.sine = order, np.array([s.sine for s in self.modes])
        self.radius = np.array([s.radius for s in self.modes])
        self.modal_masses = np.array([s.mass for s in self.modes])
        self.frequencies = np.array([s.frequency for s in self.modes])
        self.size = 2 + len(self.modes)
        self.slope = self.options.get("slope_force", "omit") == "include"
        self.states = self.options.get("states", "all")

    # --- geometry ---------------------------------------------------------------------------------
    def shape(self, phi: float, derivative: int = 0) -> Vector:
        """n = R(r0) cos or sin of l phi, or a derivative: each brings a factor l."""
        angle = self.order * phi + derivative * np.pi / 2 - np.where(self.sine, np.pi / 2, 0.0)
        return self.radius * self.order.astype(float) ** derivative * np.cos(angle)

    def gap(self, y: Vector) -> float:
        """z - w(r0, phi)."""
        return y[NORMAL] - self.shape(y[PHI]) @ y[2 : self.size]

    def gradient(self, y: Vector) -> Vector:
        """d gap / d (phi, z, q)."""
        n, g = self.shape(y[PHI]), self.shape(y[PHI], 1)
        return np.array([-g @ y[2 : self.size], 1.0, *-n])

    def gap_rate(self, y: Vector) -> float:
        """Gap rate (4.16)."""
        return self.gradient(y) @ y[self.size :]

    def curvature(self, y: Vector) -> float:
        """Second derivative of the gap without that of the coordinates (4.17)."""
        q, q_dot, turn = y[2 : self.size], y[self.size + 2 :], y[self.size + PHI]
        coriolis = 2 * turn * self.shape(y[PHI], 1) @ q_dot
        return -coriolis - turn**2 * self.shape(y[PHI], 2) @ q

    def slip_velocity(self, t: float, y: Vector) -> float:
        """r0 (Omega - phi')."""
        return self.p["r0"] * (self.turn.speed(t) - y[self.size + PHI])

    # --- forces -----------------------------------------------------------------------------------
    def masses(self) -> Vector:
        """Diagonal of the mass matrix: phi as m r0^2 phi'' = moment."""
        return np.array([self.p["m"] * self.p["r0"] ** 2, self.p["m"], *self.modal_masses])

    def forces(self, t: float, y: Vector) -> Vector:
        """All but the contact's."""
        speed, rate = self.turn.speed(t), self.turn.rate(t)
        q, q_dot = y[2 : self.size], y[self.size + 2 :]
        other, other_dot = self.partner(q), self.partner(q_dot)
        gyro = 2 * self.order * speed * other_dot + self.order * rate * other
        stiffness = (self.frequencies**2 - (self.order * speed) ** 2) * q
        free = -self.modal_masses * (gyro + stiffness + self.damping() * q_dot)
        return np.array([*self.slider_forces(t, y), *free])

    def partner(self, q: Vector) -> Vector:
        """D beside C, and -C beside D."""
        found = np.zeros_like(q)
        for i, shape in enumerate(self.modes):
            if shape.diameters:
                found[i] = -q[i - 1] if shape.sine else q[i + 1]
        return found

    def damping(self) -> Vector:
        """d_kl, 1/s: the same ratio for all, or one that grows with the frequency."""
        ratio = self.p["xi"] * np.ones(len(self.modes))
        if self.options.get("disc_damping") == "stiffness":
            ratio = ratio * self.frequencies / self.frequencies[0]
        return 2 * ratio * self.frequencies

    def slider_forces(self, t: float, y: Vector) -> tuple[float, float]:
        """Moment on phi, N m, and force along the normal, N."""
        raise NotImplementedError

    def kinetic_friction(self, v: float, sign: float) -> float:
        """Coefficient, continued analytically through zero slip."""
        raise NotImplementedError

    def normal(self, y: Vector) -> float:
        """F_N of a contact spring."""
        raise NotImplementedError

    def pressed(self, y: Vector) -> Vector:
        """What a unit normal force does."""
        moment = self.gradient(y)[PHI] if self.slope else 0.0
        return np.array([moment, 1.0, *-self.shape(y[PHI])])

    def dragged(self, y: Vector) -> Vector:
        """What a unit friction force does: on phi, and by its moment h/2 on the slope (4.32)."""
        lever = self.p["h"] / (2 * self.p["r0"])
        return np.array([self.p["r0"], 0.0, *lever * self.shape(y[PHI], 1)])

    # --- one instant ------------------------------------------------------------------------------
    def solve(
        self, t: float, y: Vector, sticks: bool, sign: float, touches: bool = True
    ) -> tuple[Vector, float, float]:
        """Accelerations, F_N and F_T from the saddle-point system."""
        masses, right = np.diag(self.masses()), self.forces(t, y)
        if not touches:
            return right / self.masses(), 0.0, 0.0
        pressed, dragged = self.pressed(y), self.dragged(y)
        mu = sign * self.kinetic_friction(self.slip_velocity(t, y), sign)
        columns, rows = [], []
        if self.rigid:
            columns.append(pressed + (0.0 if sticks else mu) * dragged)
            rows.append((self.gradient(y), -self.curvature(y)))
        else:
            normal = self.normal(y)
            right = right + normal * (pressed + (0.0 if sticks else mu) * dragged)
        if sticks:
            columns.append(dragged)
            rows.append((np.eye(self.size)[PHI], self.turn.rate(t)))
        found = _saddle(masses, columns, rows, right)
        reactions = list(found[self.size :])
        if self.rigid:
            normal = reactions.pop(0)
        friction = reactions[0] if sticks else mu * normal
        return found[: self.size], normal, friction

    # --- contact states ---------------------------------------------------------------------------
    def moving(self, sticks: bool, sign: float, touches: bool = True) -> Callable[..., Vector]:
        """Rate of the state."""

        def rate(t: float, y: Vector) -> Vector:
            return np.concatenate([y[self.size :], self.solve(t, y, sticks, sign, touches)[0]])

        return rate

    def slip(self, sign: float) -> Mode:
        """Sliding with friction of one sign."""
        guards: dict[str, Guard] = {}
        if self.states in ("all", "slip+reverse+separation"):
            guards["velocity"] = lambda t, y: sign * self.slip_velocity(t, y)
        if self.states != "slip":
            guards["normal"] = lambda t, y: self.solve(t, y, False, sign)[1]
        return Mode("slip+" if sign > 0 else "slip-", self.moving(False, sign), guards)

    def stick(self, t: float, y: Vector) -> Mode:
        """phi' = Omega."""

        def margin(sign: float) -> Guard:
            def guard(t: float, y: Vector) -> float:
                _, normal, friction = self.solve(t, y, True, 0.0)
                return self.static_friction() * normal - sign * friction

            return guard

        guards: dict[str, Guard] = {
            "up": margin(1.0),
            "down": margin(-1.0),
            "normal": lambda t, y: self.solve(t, y, True, 0.0)[1],
        }
        return Mode("stick", self.moving(True, 0.0), guards)

    def static_friction(self) -> float:
        """mu_s, or mu at rest where there is no static friction."""
        if self.states == "slip+reverse+separation":
            return self.kinetic_friction(0.0, 1.0)
        return self.p["mu_s"]

    def separation(self) -> Mode:
        """Out of contact (4.40-4.43)."""
        return Mode("separation", self.moving(False, 0.0, False), {"gap": lambda t, y: self.gap(y)})

    # --- transitions ------------------------------------------------------------------------------
    def struck(self, y: Vector) -> Vector:
        """After a plastic impact (4.45-4.56); without one a rigid slider takes the disc's speed."""
        after = y.copy()
        if self.options.get("impact", "plastic") == "none":
            after[self.size + NORMAL] -= self.gap_rate(y) if self.rigid else 0.0
            return after
        response = self.pressed(y) / self.masses()
        impulse = -self.gap_rate(y) / float(self.gradient(y) @ response)
        after[self.size :] += impulse * response
        return after

    def kinetic(self, t: float, y: Vector) -> float:
        """T of slider and spinning disc (4.28), J."""
        rates = y[self.size :].copy()
        rates[2:] += self.order * self.turn.speed(t) * self.partner(y[2 : self.size])
        return float(np.sum(self.masses() * rates**2) / 2)

    def slides(self, t: float, y: Vector) -> Mode:
        """Sliding the way the slip velocity points."""
        if self.states in ("slip", "slip+separation"):
            return self.slip(1.0 if self.turn.speed(t) > 0.0 else -1.0)
        return self.slip(1.0 if self.slip_velocity(t, y) > 0.0 else -1.0)

    def landed(self, t: float, y: Vector) -> Mode:
        """What follows a landing: contact that pulls is none, and one that opens neither."""
        sliding = self.slides(t, y)
        if self.rigid:
            sign = 1.0 if sliding.name == "slip+" else -1.0
            return sliding if self.solve(t, y, False, sign)[1] > 0.0 else self.separation()
        rate = self.gap_rate(y)
        if abs(rate) <= STANDSTILL:
            free = self.solve(t, y, False, 0.0, False)[0]
            rate = float(self.gradient(y) @ free) + self.curvature(y)
        return sliding if rate < 0.0 else self.separation()

    def holding(self, t: float, y: Vector) -> tuple[float, float]:
        """Friction force that sticking needs, and the largest there is."""
        _, normal, friction = self.solve(t, y, True, 0.0)
        return friction, self.static_friction() * normal

    def begin(self, y: Vector) -> Mode:
        """The contact state of a start that is not at zero slip velocity."""
        if self.states == "slip":
            return self.slides(0.0, y)
        gap = self.gap(y)
        if self.rigid and abs(gap) < 1e-15:
            return self.landed(0.0, y)
        return self.separation() if gap > 0.0 else self.slides(0.0, y)

    def max_step(self, mode: Mode, t: float, y: Vector) -> float:
        """Short enough that no flight begins and ends within a step."""
        if mode.name != "separation":
            return MAX_STEP
        free = self.solve(t, y, False, 0.0, False)[0]
        curvature = float(self.gradient(y) @ free) + self.curvature(y)
        hop = 2 * abs(self.gap_rate(y) / curvature)
        return min(MAX_STEP, hop / 4) if hop > STANDSTILL else MAX_STEP / 50

    # --- the program's names ----------------------------------------------------------------------
    def names(self) -> list[str]:
        """Coordinates as the program names them."""
        disc = [f"{'D' if s.sine else 'C'}_0_{s.diameters}" for s in self.modes]
        return ["phi", "z" if self.rigid else "u", *disc]

    def state(self, given: Mapping[str, float]) -> Vector:
        """State vector from the program's values: its modal coordinates are metres at r0."""
        scale = np.array([1.0, 1.0, *1.0 / self.radius])
        values = [given.get(name, 0.0) for name in self.names()]
        rates = [given.get(f"{name}_dot", 0.0) for name in self.names()]
        y = np.concatenate([scale * values, scale * rates])
        if self.rigid and self.gap(y) <= 0.0:
            y[NORMAL] -= self.gap(y)
            y[self.size + NORMAL] -= self.gap_rate(y)
        return y

    def values(self, y: Vector) -> Vector:
        """Coordinates and rates in the program's scale and order."""
        scale = np.array([1.0, 1.0, *self.radius])
        return np.concatenate([scale * y[: self.size], scale * y[self.size :]])


def _saddle(
    masses: Matrix, columns: list[Vector], rows: list[tuple[Vector, float]], right: Vector
) -> Vector:
    """Solve masses a - columns x = right, rows a = their values."""
    if not columns:
        found: Vector = right / np.diag(masses)
        return found
    conditions, values = (np.array(part) for part in zip(*rows, strict=True))
    nothing = np.zeros((len(columns), len(columns)))
    matrix = np.block([[masses, -np.array(columns).T], [conditions, nothing]])
    return np.linalg.solve(matrix, np.concatenate([right, values]))


class RigidContact(SliderOnDisc):
    """Chapter 4: K_phi, C_phi, k_z, c_z and N0 hold the slider; friction falls with speed (4.5)."""

    def slider_forces(self, t: float, y: Vector) -> tuple[float, float]:
        """4.4 and 4.18."""
        p, phi_dot, z_dot = self.p, y[self.size + PHI], y[self.size + NORMAL]
        moment = -p["C_phi"] * phi_dot - p["K_phi"] * y[PHI]
        return moment, -p["N0"] - p["c_z"] * z_dot - p["k_z"] * y[NORMAL]

    def kinetic_friction(self, v: float, sign: float) -> float:
        """4.5."""
        p = self.p
        return p["mu_k"] + (p["mu_0"] - p["mu_k"]) * np.exp(-p["alpha"] * sign * v)


class Sprung(SliderOnDisc):
    """Figures 5.2 and 6.19: k1, k3 at 45 degrees, c1, c2, preload F, contact spring."""

    rigid = False

    def slider_forces(self, t: float, y: Vector) -> tuple[float, float]:
        """5.16, 5.17; 6.21, 6.22: the tangential equation times r0."""
        p = self.p
        along, across = p["r0"] * y[PHI], y[NORMAL]
        along_dot, across_dot = p["r0"] * y[self.size + PHI], y[self.size + NORMAL]
        diagonal = 0.5 * p["k3"] * (along - across)
        tangential = self.excitation(t) - p["c1"] * along_dot - p["k1"] * along - diagonal
        return p["r0"] * tangential, -p["F"] - p["c2"] * across_dot + diagonal

    def excitation(self, t: float) -> float:
        """Tangential force, N."""
        return 0.0


class NonlinearContact(Sprung):
    """6.5: F_N = k2 d + k_nl d^3 with Coulomb friction."""

    def normal(self, y: Vector) -> float:
        """6.25."""
        cubic = self.options.get("contact_stiffness", "nonlinear") == "nonlinear"
        d = -self.gap(y)
        return self.p["k2"] * d + (self.p["k_nl"] * d**3 if cubic else 0.0)

    def kinetic_friction(self, v: float, sign: float) -> float:
        """mu_k."""
        return self.p["mu_k"]


class ExcitedDisc(Sprung):
    """5.3: F_N = k2 (w - u), friction that falls with speed (5.18), A sin(R omega_cr t)."""

    def normal(self, y: Vector) -> float:
        """5.19."""
        return -self.p["k2"] * self.gap(y)

    def excitation(self, t: float) -> float:
        """5.16 with omega = R omega_cr; omega_cr is min omega_kl / l (5.32)."""
        critical = min(s.frequency / s.diameters for s in self.modes if s.diameters)
        return float(self.p["A"] * np.sin(self.p["R"] * critical * t))

    def kinetic_friction(self, v: float, sign: float) -> float:
        """5.18: mu_k + (mu_s - mu_k) exp(-alpha |v|)."""
        p = self.p
        return float(p["mu_k"] + (p["mu_s"] - p["mu_k"]) * np.exp(-p["alpha"] * sign * v))
