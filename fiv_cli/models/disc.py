"""What the models of a slider on a spinning elastic disc share (thesis 4.2, 5.3, 6.5).

The disc is an annular plate, clamped inside, free outside, spinning at Omega. In the space-fixed
frame

    w(r, theta, t) = sum R_kl(r)/R_kl(r0) (C_kl cos(l theta) + D_kl sin(l theta))

so that the modal coordinates C_kl and D_kl are metres of displacement at the slider's radius r0:
no answer depends on how mode shapes are scaled. With mu_kl = R_kl(r0)^2/M_kl (1/kg) and the
generalised forces P, Q of the contact

    C'' + d C' + 2 l Omega D' + l Omega' D + (omega^2 - l^2 Omega^2) C = mu_kl P
    D'' + d D' - 2 l Omega C' - l Omega' C + (omega^2 - l^2 Omega^2) D = mu_kl Q
    P = -F_N cos(l phi) - h/(2 r0) l sin(l phi) F_T
    Q = -F_N sin(l phi) + h/(2 r0) l cos(l phi) F_T

The terms with Omega' belong to the derivative of the momenta and are missing in 4.33 and 4.34.
Damping is that of 6.41, d = 2 xi omega_kl for ``disc_damping = constant``; the damping
d* lap lap w_t of 6.24 would give ``stiffness``: a ratio that grows with the frequency, xi being
that of the first mode of the set: fewest nodal circles, then diameters. Each l >= 1 is a doublet:
both C_kl and D_kl are there.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from functools import cache
from typing import TYPE_CHECKING

from fiv_cli.models.base import Derived, Option, Options, Parameter, Requirement, State

if TYPE_CHECKING:
    from sympy import Expr

    from fiv_cli.models.symbols import Symbols
    from fiv_cli.plate import AnnularPlate

NODE = 1e-9  # a mode whose shape at r0 is below about this share of its mean has a node there
THESIS_MODES = "0,0 0,1 0,2 0,3"

_WRITTEN = re.compile(r"\s*\d+,\d+(\s+\d+,\d+)*\s*")

PLATE = (
    Parameter("a", "a", "m", 0.044, "inner radius of the disc", "Table 4.1", 0.0, exclusive=True),
    Parameter("b", "b", "m", 0.12, "outer radius of the disc", "Table 4.1", 0.0, exclusive=True),
    Parameter("h", "h", "m", 0.002, "thickness of the disc", "Table 4.1", 0.0, exclusive=True),
    Parameter(
        "rho", r"\rho", "kg m-3", 7200.0, "density of the disc", "Table 4.1", 0.0, exclusive=True
    ),
    Parameter("E", "E", "Pa", 150e9, "Young's modulus", "Table 4.1", 0.0, exclusive=True),
    Parameter("nu", r"\nu", "1", 0.211, "Poisson's ratio", "Table 4.1", 0.0, 0.5),
    Parameter("r0", "r_0", "m", 0.1, "radius of the slider", "Table 4.1", 0.0, exclusive=True),
)

ON_THE_DISC = Requirement(
    ("a", "b", "r0"),
    lambda p: p["a"] < p["b"] and p["a"] <= p["r0"] <= p["b"],
    "a < b and a <= r0 <= b",
    "the slider is not on the disc",
    "no_plate",
)

SHORT = {"t_max": 60.0, "t_end": 2.0, "f_max": 1000.0, "resolution": 2.0}
"""Settings of a first case: discs vibrate in milliseconds."""

SPEED = Parameter("Omega", r"\Omega", "rad s-1", 10.0, "disc speed", "4.3", role="speed")


def damping_ratio(default: float) -> Parameter:
    """xi with the default of a model."""
    return Parameter(
        "xi", r"\xi", "1", default, "damping ratio of the disc's modes", "6.41", 0.0, role="damping"
    )


def read_modes(value: object) -> str:
    """``[[k, l], ...]`` -> ``"k,l ..."``, sorted; ValueError says what is wrong."""
    if isinstance(value, str) and _WRITTEN.fullmatch(value):
        value = [[int(number) for number in pair.split(",")] for pair in value.split()]
    if not isinstance(value, list | tuple) or not value:
        raise ValueError(f"{value!r} is no list of modes")
    pairs = [_read_mode(pair) for pair in value]
    if len(set(pairs)) < len(pairs):
        raise ValueError("a mode stands twice (each with l > 0 brings both of its doublet)")
    return " ".join(f"{k},{n}" for k, n in sorted(pairs))


def _read_mode(pair: object) -> tuple[int, int]:
    numbers = list(pair) if isinstance(pair, list | tuple) else []
    if len(numbers) != 2 or not all(type(n) is int and n >= 0 for n in numbers):
        raise ValueError(f"{pair!r} is no mode [nodal circles, nodal diameters]")
    return numbers[0], numbers[1]


MODES = Option(
    "modes",
    (),
    THESIS_MODES,
    "modes of the disc, nodal circles and diameters; with l > 0 both of a doublet",
    read_modes,
    'a list of [k, l], such as [[0, 0], [0, 1]], or "0,0 0,1"',
    lambda texts: read_modes(" ".join({pair for text in texts for pair in text.split()})),
)

DISC_DAMPING = Option(
    "disc_damping",
    ("constant", "stiffness"),
    "constant",
    "whether all modes have the damping ratio xi, or one that grows with their frequency",
)

SLOPE_FORCE = Option(
    "slope_force",
    ("omit", "include"),
    "omit",
    "circumferential force -F_N dw/dtheta on the slider, which the thesis omits",
)


def modes(options: Options) -> tuple[tuple[int, int], ...]:
    """(k, l) of each mode."""
    pairs = (pair.split(",") for pair in options["modes"].split())
    return tuple((int(k), int(n)) for k, n in pairs)


def states(options: Options) -> tuple[State, ...]:
    """Modal coordinates, in metres of displacement at r0."""
    return tuple(
        State(f"{part}_{k}_{n}", f"{part}_{{{k}{n}}}", "m", _meaning(part, k, n))
        for k, n in modes(options)
        for part in _parts(n)
    )


def _parts(diameters: int) -> str:
    return "CD" if diameters else "C"


def _meaning(part: str, circles: int, diameters: int) -> str:
    kind = {"C": "cosine", "D": "sine"}[part]
    return f"mode ({circles}, {diameters}), {kind} part, displacement at r0"


# --- numbers of the plate -------------------------------------------------------------------------
def _names(options: Options) -> tuple[str, ...]:
    return tuple(f"{what}_{k}_{n}" for k, n in modes(options) for what in ("omega", "mobility"))


def _values(parameters: Mapping[str, float], options: Options) -> dict[str, float]:
    """omega_kl in rad/s and mobility_kl = R_kl(r0)^2/M_kl in 1/kg."""
    plate = plate_of(parameters)
    found = {}
    for k, n in modes(options):
        frequency, mobility = _mode(plate, parameters["r0"], k, n)
        found[f"omega_{k}_{n}"], found[f"mobility_{k}_{n}"] = frequency, mobility
    return found


@cache
def _mode(plate: AnnularPlate, radius: float, circles: int, diameters: int) -> tuple[float, float]:
    from fiv_cli.plate import mode

    found = mode(plate, circles, diameters)
    return found.frequency, found.inverse_modal_mass(radius)


def plate_of(parameters: Mapping[str, float]) -> AnnularPlate:
    """The plate that the parameters describe."""
    from fiv_cli.plate import AnnularPlate

    return AnnularPlate(*(parameters[name] for name in ("a", "b", "h", "rho", "E", "nu")))


def surface(
    parameters: Mapping[str, float], options: Options, radius: float, angle: float
) -> dict[str, float]:
    """Modal coordinate -> its weight in w(radius, angle): R(r)/R(r0) cos or sin of l theta.

    NaN off the plate.
    """
    found = {}
    for k, n in modes(options):
        ratio = _ratio(plate_of(parameters), parameters["r0"], radius, k, n)
        found[f"C_{k}_{n}"] = ratio * math.cos(n * angle)
        if n:
            found[f"D_{k}_{n}"] = ratio * math.sin(n * angle)
    return found


@cache
def _ratio(plate: AnnularPlate, r0: float, radius: float, circles: int, diameters: int) -> float:
    """R(radius)/R(r0)."""
    from fiv_cli.plate import mode

    if not plate.a <= radius <= plate.b:
        return math.nan
    shape = mode(plate, circles, diameters).shape
    return float(shape(radius) / shape(r0))


def singular(known: Mapping[str, float], options: Options) -> tuple[str, str]:
    """Modes that the slider at r0 does not move: their coordinates, in metres there, are none."""
    area = math.pi * (known["b"] ** 2 - known["a"] ** 2)
    least = NODE**2 / (known["rho"] * known["h"] * area)
    nodes = [f"({k}, {n})" for k, n in modes(options) if not known[f"mobility_{k}_{n}"] > least]
    said = f"mode {', '.join(nodes)} has a node at r0 = {known['r0']!r} m"
    return ("node_at_r0", said) if nodes else ("", "")


DERIVED = Derived(_names, _values, tuple(parameter.name for parameter in PLATE))


# --- equations ------------------------------------------------------------------------------------
@dataclass(frozen=True)
class Disc:
    """The disc's part of the equations, as SymPy expressions.

    Attributes
    ----------
    symbols, options : what they are written in
    angle : where the slider is
    """

    symbols: Symbols
    options: Options
    angle: Expr

    def displacement(self) -> Expr:
        """w at the slider, m."""
        return sum((shape * self.symbols.coordinate(name) for name, shape in self._shapes()), 0)

    def slope(self) -> Expr:
        """dw/dtheta at the slider, m."""
        import sympy

        return sympy.diff(self.displacement(), self.angle)

    def _shapes(self) -> Iterable[tuple[str, Expr]]:
        """Modal coordinate -> its shape at the slider's angle."""
        from sympy import cos, sin

        for k, n in modes(self.options):
            for part in _parts(n):
                yield f"{part}_{k}_{n}", (cos if part == "C" else sin)(n * self.angle)

    def accelerations(self) -> dict[str, Expr]:
        """Modal coordinate -> acceleration under the contact forces."""
        import sympy

        p, normal = self.symbols.parameter, self.symbols.normal_force(0)
        moment = p("h") / (2 * p("r0")) * self.symbols.tangential_force(0)
        found = {}
        for name, shape in self._shapes():
            force = -normal * shape + moment * sympy.diff(shape, self.angle)
            mobility = p("mobility" + name[1:])
            found[name] = self._free(name) + mobility * force
        return found

    def _free(self, name: str) -> Expr:
        """Acceleration of a modal coordinate of the free spinning disc."""
        p, symbols = self.symbols.parameter, self.symbols
        part, k, n = name.split("_")
        speed, order = p("Omega"), int(n)
        own, rate = symbols.coordinate(name), symbols.velocity(name)
        free = (order**2 * speed**2 - p(f"omega_{k}_{n}") ** 2) * own - self._damping(k, n) * rate
        if order == 0:
            return free
        other = ("D" if part == "C" else "C") + name[1:]
        turned = 2 * speed * symbols.velocity(other)
        turned += symbols.parameter_rate("Omega") * symbols.coordinate(other)
        return free - order * turned if part == "C" else free + order * turned

    def _damping(self, circles: str, diameters: str) -> Expr:
        """d of the mode, 1/s."""
        p = self.symbols.parameter
        frequency = p(f"omega_{circles}_{diameters}")
        constant = 2 * p("xi") * frequency
        if self.options["disc_damping"] == "constant":
            return constant
        return constant * frequency / p(f"omega_{self._first()}")

    def _first(self) -> str:
        """The mode that xi belongs to."""
        k, n = modes(self.options)[0]
        return f"{k}_{n}"

    def kinetic_energy(self) -> Expr:
        """T of the spinning disc, J (thesis 4.28)."""
        p, total = self.symbols.parameter, 0
        for k, n in modes(self.options):
            turn = n * p("Omega")
            c, c_dot = self._pair(f"C_{k}_{n}")
            d, d_dot = self._pair(f"D_{k}_{n}") if n else (0, 0)
            square = (c_dot + turn * d) ** 2 + (d_dot - turn * c) ** 2
            total += square / (2 * p(f"mobility_{k}_{n}"))
        return total

    def strain_energy(self) -> Expr:
        """U of the disc, J (thesis 4.29)."""
        p, total = self.symbols.parameter, 0
        for k, n in modes(self.options):
            square = self._pair(f"C_{k}_{n}")[0] ** 2
            square += self._pair(f"D_{k}_{n}")[0] ** 2 if n else 0
            total += p(f"omega_{k}_{n}") ** 2 * square / (2 * p(f"mobility_{k}_{n}"))
        return total

    def _pair(self, name: str) -> tuple[Expr, Expr]:
        return self.symbols.coordinate(name), self.symbols.velocity(name)
