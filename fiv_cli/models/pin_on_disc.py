"""Pin on a spinning disc, its normal force adjusted by an L-mechanism (thesis chapter 7).

    J_c phi'' + c1 phi' + (k1 a0^2 + k3 b0^2) phi + k2 b0^2/l2 phi s + k3 b0 c0 theta = F_T b0
    J_L theta'' + c2 theta' + k3 c0 (c0 theta + b0 phi) + k2 c0 s = 0
    F_N = N0 - k2 s,    s = c0 theta + b0^2 phi^2 / (2 l2)
    v_rel = b0 (Omega - phi')

Thesis 7.12, 7.13 and 7.17. The slip velocity is the pin's, in m/s at its radius b0; the thesis
writes Omega - phi', which has the same sign. Nothing in the equations keeps F_N positive: the run
ends with ``contact_lost`` when it reaches zero.

Sector: the pin stands at psi = Omega t - phi on the disc (modulo 2 pi). On
[psi_a, psi_a + beta) the coefficients of friction are mu_s_2 and mu_k_2 (section 7.4). The
phase psi_a is an input: the answer depends on it. A sticking pin cannot change sector.
"""

from __future__ import annotations

from math import pi
from typing import TYPE_CHECKING

from fiv_cli.models.base import (
    Contact,
    Equations,
    Example,
    Forcing,
    Model,
    Options,
    Parameter,
    Requirement,
    State,
    Zone,
)

if TYPE_CHECKING:
    from fiv_cli.models.symbols import Symbols


def _length(name: str, symbol: str, meaning: str) -> Parameter:
    return Parameter(name, symbol, "m", 0.1, meaning, "Table 7.1", 0.0, exclusive=True)


def _stiffness(name: str, symbol: str, default: float) -> Parameter:
    return Parameter(name, symbol, "N m-1", default, f"stiffness of spring {symbol}", "7.2", 0.0)


PARAMETERS = (
    Parameter("J_c", "J_c", "kg m2", 12e-4, "inertia of the cylinder", "7.1", 0.0, exclusive=True),
    Parameter(
        "J_L", "J_L", "kg m2", 5e-4, "inertia of the L-structure", "7.1", 0.0, exclusive=True
    ),
    _stiffness("k1", "k_1", 1500.0),
    _stiffness("k2", "k_2", 1000.0),
    _stiffness("k3", "k_3", 1000.0),
    Parameter("c1", "c_1", "N m s", 1e-3, "damping of the cylinder's rotation", "7.9", 0.0),
    Parameter("c2", "c_2", "N m s", 1e-3, "damping of the L-structure's rotation", "7.9", 0.0),
    _length("a0", "a_0", "arm of spring k1 about the central axis"),
    _length("b0", "b_0", "arm of springs k2, k3 and of the pin about the central axis"),
    _length("c0", "c_0", "arm of springs k2, k3 about the pivot"),
    _length("l1", "l_1", "free length of spring k1 (not in the expanded equations)"),
    _length("l2", "l_2", "free length of spring k2"),
    _length("l3", "l_3", "free length of spring k3 (not in the expanded equations)"),
    Parameter("N0", "N_0", "N", 30.0, "normal preload", "7.17", 0.0, role="preload"),
    Parameter(
        "Omega", r"\Omega", "rad s-1", 2.0, "disc speed", "7.14", 0.0, exclusive=True, role="speed"
    ),
    Parameter("beta", r"\beta", "rad", 0.0, "span of the sector", "7.4", 0.0, 2 * pi),
    Parameter("psi_a", r"\psi_a", "rad", 0.0, "start of the sector on the disc", "7.4"),
    Parameter("mu_s_2", r"\mu_{s,2}", "1", 0.3, "static friction on the sector", "7.4", 0.0),
    Parameter("mu_k_2", r"\mu_{k,2}", "1", 0.2, "kinetic friction on the sector", "7.4", 0.0),
)

STATES = (
    State("phi", r"\varphi", "rad", "rotation of the cylinder with the pin", small=0.25),
    State("theta", r"\theta", "rad", "rotation of the L-structure", small=0.25),
)


def equations(symbols: Symbols, options: Options) -> Equations:
    """Equations 7.12, 7.13 and 7.17 under a given friction force."""
    p = symbols.parameter
    phi, theta = symbols.coordinate("phi"), symbols.coordinate("theta")
    phi_dot, theta_dot = symbols.velocity("phi"), symbols.velocity("theta")
    a0, b0, c0, l2 = p("a0"), p("b0"), p("c0"), p("l2")
    k1, k2, k3 = p("k1"), p("k2"), p("k3")
    stretch_2 = c0 * theta + b0**2 / (2 * l2) * phi**2
    stretch_3 = c0 * theta + b0 * phi
    moment_phi = -k1 * a0**2 * phi - k2 * b0**2 / l2 * phi * stretch_2 - k3 * b0 * stretch_3
    moment_theta = -k3 * c0 * stretch_3 - k2 * c0 * stretch_2
    friction = b0 * symbols.tangential_force(0)
    return Equations(
        accelerations={
            "phi": (moment_phi - p("c1") * phi_dot + friction) / p("J_c"),
            "theta": (moment_theta - p("c2") * theta_dot) / p("J_L"),
        },
        contacts=(
            Contact(
                slip_velocity=b0 * (p("Omega") - phi_dot),
                slip_coordinate="phi",
                normal_force=p("N0") - k2 * stretch_2,
                ends_at_zero_normal_force=True,
            ),
        ),
        kinetic_energy=p("J_c") * phi_dot**2 / 2 + p("J_L") * theta_dot**2 / 2,
        potential_energy=(k1 * (a0 * phi) ** 2 + k2 * stretch_2**2 + k3 * stretch_3**2) / 2,
        law_parameters={
            "mu_s": symbols.in_zone(p("mu_s"), p("mu_s_2")),
            "mu_k": symbols.in_zone(p("mu_k"), p("mu_k_2")),
        },
        zone=Zone(angle=p("Omega") * symbols.time - phi, start="psi_a", width="beta"),
    )


FALLING_ON_THE_SECTOR = Requirement(
    ("mu_k_2", "mu_s_2", "beta"),
    lambda p: p["beta"] == 0.0 or p["mu_k_2"] <= p["mu_s_2"],
    "mu_k_2 <= mu_s_2",
    "mu_k_2 is above mu_s_2",
    "mu_k_above_mu_s",
    in_motion=True,
)
READ_ON_THE_SECTOR = Requirement(
    ("beta",),
    lambda p: p["beta"] == 0.0 or "mu_k" in p,
    "beta = 0, or a friction law with mu_k",
    "the sector differs by mu_s_2 and mu_k_2, and this friction law has no mu_k",
    "sector_not_read",
)

MODEL = Model(
    name="pin-on-disc",
    title="pin on a spinning disc with an L-mechanism",
    reference="thesis chapter 7; equations 7.1-7.17",
    numerics_version=1,
    parameters=PARAMETERS,
    states=lambda options: STATES,
    equations=equations,
    default_law="coulomb",
    law_defaults={"mu_s": 0.4, "mu_k": 0.23},
    forcings=(Forcing("beta", lambda p: p["Omega"], "sector of the disc passing the pin"),),
    revolution=lambda p: p["Omega"],
    requirements=(FALLING_ON_THE_SECTOR, READ_ON_THE_SECTOR),
    example=Example("Omega", 0.5, 7.0, {}, {"t_end": 2.0, "f_max": 200.0, "resolution": 1.0}),
    sliding=Example("Omega", 10.0, 60.0, law="stribeck"),
)
