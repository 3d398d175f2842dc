"""Slider on an elastically supported moving belt, five degrees of freedom (thesis 6.2).

    M x1'' + c1 x1' + (k1 + k3/2) x1 - k3/2 y1 = F_T
    M y1'' + c2 y1' - k3/2 x1 + k3/2 y1 + F    = F_N
    m x2'' + c4 x2' + k4 x2                    = -F_T
    m y2'' + c5 s1' + k5 s1 + c6 s2' + k6 s2   = -F_N
    J phi'' + l1 (c5 s1' + k5 s1) - l2 (c6 s2' + k6 s2) = F_N (x1 - x2)

    s1 = y2 + l1 phi,  s2 = y2 - l2 phi,  d = y2 - (x1 - x2) phi - y1  (compression)
    F_N = k2 d + k_nl d^3 while d > 0,    v_rel = v + x2' - x1'

Thesis 6.1, 6.2 and 6.5. Options and where the thesis' equations need a word:

- ``geometry = linear``: the belt does not rotate (phi = 0), the state phi does not exist.
- ``states = slip``: bilateral contact (F_N may be negative) and F_T = +mu_k F_N always.
- ``slope_force = include`` adds the forces +F_N phi on x1 and -F_N phi on x2. With them the
  contact derives from a potential; 6.1 keeps only their moment on phi (``omit``).
- ``impact = plastic``: the gap rate is zero after re-contact. 6.13 lacks (x1' - x2') phi;
  ``thesis`` is the literal 6.14-6.17, which leaves a gap rate and so makes micro-bounces. The
  impulse acts on the coordinates as F_N does, its tangential part is ignored (6.10-6.12).

Units of Table 6.1 corrected: c in N s/m, k1 to k3 in N/m, k_nl in N/m^3. The equilibrium printed
for mu_k = 1.4 has x1 = +0.0053 m.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from fiv_cli.models.base import (
    Contact,
    Equations,
    Example,
    Model,
    Option,
    Options,
    Parameter,
    State,
)

if TYPE_CHECKING:
    from sympy import Expr

    from fiv_cli.models.symbols import Symbols


def _damping(name: str, symbol: str, meaning: str) -> Parameter:
    return Parameter(name, symbol, "N s m-1", 0.1, f"damping coefficient, {meaning}", "6.1", 0.0)


def _stiffness(name: str, symbol: str, default: float, meaning: str) -> Parameter:
    return Parameter(name, symbol, "N m-1", default, f"stiffness, {meaning}", "6.1", 0.0)


PARAMETERS = (
    Parameter("M", "M", "kg", 1.0, "mass of the slider", "6.1", 0.0, exclusive=True),
    Parameter("m", "m", "kg", 1.0, "mass of the belt", "6.1", 0.0, exclusive=True),
    Parameter("J", "J", "kg m2", 0.1, "rotational inertia of the belt", "6.1", 0.0, exclusive=True),
    _damping("c1", "c_1", "slider, horizontal"),
    _damping("c2", "c_2", "slider, vertical"),
    _damping("c4", "c_4", "belt, horizontal"),
    _damping("c5", "c_5", "first wheel, vertical"),
    _damping("c6", "c_6", "second wheel, vertical"),
    _stiffness("k1", "k_1", 1e4, "slider, horizontal"),
    Parameter(
        "k2", "k_2", "N m-1", 5e3, "contact stiffness, linear part", "6.2", 0.0, exclusive=True
    ),
    _stiffness("k3", "k_3", 6e3, "slider, at 45 degrees"),
    _stiffness("k4", "k_4", 1e4, "belt, horizontal"),
    _stiffness("k5", "k_5", 1e4, "first wheel, vertical"),
    _stiffness("k6", "k_6", 1e4, "second wheel, vertical"),
    Parameter("k_nl", "k_{nl}", "N m-3", 1e4, "contact stiffness, cubic part", "6.2", 0.0),
    Parameter("l1", "l_1", "m", 0.2, "distance of the first wheel", "6.1"),
    Parameter("l2", "l_2", "m", 0.2, "distance of the second wheel", "6.1"),
    Parameter("v", "v", "m s-1", 1.0, "belt velocity", "6.3", role="speed"),
    Parameter("F", "F", "N", 200.0, "preload", "6.1", 0.0, role="preload"),
)

ROTATION = State("phi", r"\varphi", "rad", "rotation of the belt", small=0.25)
STATES = (
    State("x1", "x_1", "m", "horizontal displacement of the slider"),
    State("y1", "y_1", "m", "vertical displacement of the slider"),
    State("x2", "x_2", "m", "horizontal displacement of the belt"),
    State("y2", "y_2", "m", "vertical displacement of the belt"),
)

OPTIONS = (
    Option(
        "contact_stiffness",
        ("nonlinear", "linear"),
        "nonlinear",
        "whether the cubic contact spring k_nl is there",
    ),
    Option(
        "geometry",
        ("nonlinear", "linear"),
        "nonlinear",
        "whether the belt rotates under the slider; linear: phi = 0",
    ),
    Option(
        "states",
        ("all", "slip"),
        "all",
        "stick, slip and separation, or sliding in bilateral contact",
    ),
    Option(
        "impact",
        ("plastic", "thesis", "none"),
        "plastic",
        "re-contact: gap rate zero after it, the literal 6.14-6.17, or no impulse",
    ),
    Option(
        "slope_force",
        ("omit", "include"),
        "omit",
        "horizontal forces F_N phi on slider and belt",
    ),
)


@dataclass(frozen=True)
class _Motion:
    """Coordinates and velocities by name; phi is 0 where the belt does not rotate."""

    q: dict[str, Expr]
    rate: dict[str, Expr]


def _motion(symbols: Symbols, rotates: bool) -> _Motion:
    names = [state.name for state in STATES]
    q = {name: symbols.coordinate(name) for name in names}
    rate = {name: symbols.velocity(name) for name in names}
    q["phi"] = symbols.coordinate("phi") if rotates else 0
    rate["phi"] = symbols.velocity("phi") if rotates else 0
    return _Motion(q, rate)


def states(options: Options) -> tuple[State, ...]:
    """Generalised coordinates: phi only where the belt rotates."""
    return (*STATES, ROTATION) if options["geometry"] == "nonlinear" else STATES


def equations(symbols: Symbols, options: Options) -> Equations:
    """Equations 6.1 and 6.2 under given contact forces."""
    motion = _motion(symbols, options["geometry"] == "nonlinear")
    return Equations(
        accelerations=_accelerations(symbols, options, motion),
        contacts=(_contact(symbols, options, motion),),
        kinetic_energy=_kinetic_energy(symbols, motion),
        potential_energy=_potential_energy(symbols, options, motion),
    )


def _accelerations(symbols: Symbols, options: Options, motion: _Motion) -> dict[str, Expr]:
    p, q, rate = symbols.parameter, motion.q, motion.rate
    normal, tangential = symbols.normal_force(0), symbols.tangential_force(0)
    along = normal * q["phi"] if options["slope_force"] == "include" else 0
    diagonal = p("k3") / 2 * (q["x1"] - q["y1"])
    first, second = _wheel(p, motion, "5", p("l1")), _wheel(p, motion, "6", -p("l2"))
    slider_x = tangential + along - p("c1") * rate["x1"] - p("k1") * q["x1"] - diagonal
    slider_y = normal - p("F") - p("c2") * rate["y1"] + diagonal
    belt_x = -tangential - along - p("c4") * rate["x2"] - p("k4") * q["x2"]
    belt_y = -normal - first - second
    moment = normal * (q["x1"] - q["x2"]) - p("l1") * first + p("l2") * second
    found = {
        "x1": slider_x / p("M"),
        "y1": slider_y / p("M"),
        "x2": belt_x / p("m"),
        "y2": belt_y / p("m"),
    }
    return found | ({"phi": moment / p("J")} if q["phi"] != 0 else {})


def _wheel(p: Expr, motion: _Motion, number: str, arm: Expr) -> Expr:
    """Force of a wheel's spring and damper."""
    stretch = motion.q["y2"] + arm * motion.q["phi"]
    rate = motion.rate["y2"] + arm * motion.rate["phi"]
    return p(f"c{number}") * rate + p(f"k{number}") * stretch


def _compression(motion: _Motion) -> Expr:
    q = motion.q
    return q["y2"] - (q["x1"] - q["x2"]) * q["phi"] - q["y1"]


def _contact(symbols: Symbols, options: Options, motion: _Motion) -> Contact:
    p, rate = symbols.parameter, motion.rate
    compression = _compression(motion)
    bilateral = options["states"] == "slip"
    cubic = p("k_nl") * compression**3 if options["contact_stiffness"] == "nonlinear" else 0
    return Contact(
        slip_velocity=p("v") + rate["x2"] - rate["x1"],
        slip_coordinate="x1",
        normal_force=p("k2") * compression + cubic,
        gap=None if bilateral else -compression,
        impact="none" if options["impact"] == "none" else "plastic",
        closing_rate=_closing_rate(motion) if options["impact"] == "thesis" else None,
        sliding_only=bilateral,
    )


def _closing_rate(motion: _Motion) -> Expr:
    """Gap rate as 6.14 has it: without the part that comes from slip."""
    q, rate = motion.q, motion.rate
    return rate["y1"] - rate["y2"] + (q["x1"] - q["x2"]) * rate["phi"]


def _kinetic_energy(symbols: Symbols, motion: _Motion) -> Expr:
    p, rate = symbols.parameter, motion.rate
    slider = p("M") * (rate["x1"] ** 2 + rate["y1"] ** 2)
    belt = p("m") * (rate["x2"] ** 2 + rate["y2"] ** 2)
    return (slider + belt + p("J") * rate["phi"] ** 2) / 2


def _potential_energy(symbols: Symbols, options: Options, motion: _Motion) -> Expr:
    p, q = symbols.parameter, motion.q
    springs = p("k1") * q["x1"] ** 2 + p("k3") / 2 * (q["x1"] - q["y1"]) ** 2
    springs += p("k4") * q["x2"] ** 2
    springs += p("k5") * (q["y2"] + p("l1") * q["phi"]) ** 2
    springs += p("k6") * (q["y2"] - p("l2") * q["phi"]) ** 2
    d = _compression(motion)
    cubic = p("k_nl") * d**4 / 4 if options["contact_stiffness"] == "nonlinear" else 0
    return springs / 2 + p("F") * q["y1"] + symbols.closed(0) * (p("k2") * d**2 / 2 + cubic)


MODEL = Model(
    name="belt-5dof",
    title="slider on an elastically supported belt, five degrees of freedom",
    reference="thesis 6.2-6.4; equations 6.1-6.17",
    numerics_version=1,
    parameters=PARAMETERS,
    states=states,
    equations=equations,
    default_law="coulomb",
    law_defaults={"mu_k": 0.3, "mu_s": 3.0},
    options=OPTIONS,
    base=("x1", "x2"),
    example=Example(
        "mu_k", 0.3, 2.7, {"mu_s": 3.0}, {"t_end": 2.0, "f_max": 100.0, "resolution": 0.5}
    ),
)
