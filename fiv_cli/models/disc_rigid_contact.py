"""Slider in rigid contact with a spinning elastic disc (thesis chapter 4).

    m r0^2 phi'' + C_phi phi' + K_phi phi = r0 F_T  [- F_N dw/dtheta]
    m z'' + c_z z' + k_z z = F_N - N0,         z = w(r0, phi, t) while in contact
    v_rel = r0 (Omega - phi')

and the disc of ``disc.py``. Thesis 4.4-4.56, with C_phi = r0^2 c_phi and K_phi = r0^2 k_phi. The
normal force is algebraic: it keeps z on the disc, z'' being the second derivative of w along the
slider's path; in 4.33-4.39 the printed -m phi' sin(s phi) is -m s phi'' sin(s phi), and every
single derivative with respect to theta needs its factor s. 4.43 has c, k for c_z, k_z. In
brackets: ``slope_force = include``, which consistent mechanics has and the thesis omits. Its
denominator is positive unless friction jams the contact; the run then ends, ``jammed``.

A disc that decelerates or accelerates (4.1, 4.2) is a schedule of Omega.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from fiv_cli.models import disc
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
    from fiv_cli.models.symbols import Symbols

PARAMETERS = (
    *disc.PLATE,
    Parameter("m", "m", "kg", 0.1, "mass of the slider", "Table 4.1", 0.0, exclusive=True),
    Parameter("k_z", "k_z", "N m-1", 3e4, "transverse stiffness of the slider", "4.18", 0.0),
    Parameter("c_z", "c_z", "N s m-1", 0.1, "transverse damping of the slider", "4.18", 0.0),
    Parameter("K_phi", r"r_0^2k_\varphi", "N m", 2000.0, "in-plane stiffness", "4.4", 0.0),
    Parameter("C_phi", r"r_0^2c_\varphi", "N m s", 0.1, "in-plane damping", "4.4", 0.0),
    Parameter("N0", "N_0", "N", 500.0, "normal preload", "4.18", 0.0, role="preload"),
    Parameter("Omega", r"\Omega", "rad s-1", 6.283185, "disc speed", "4.3", role="speed"),
    disc.damping_ratio(0.0),
)

IMPACT = Option(
    "impact",
    ("plastic", "none"),
    "plastic",
    "re-contact: slider and disc go on together, or with their own velocities",
)


def states(options: Options) -> tuple[State, ...]:
    """phi, z and the modal coordinates."""
    return (
        State("phi", r"\varphi", "rad", "angle of the slider"),
        State("z", "z", "m", "transverse displacement of the slider"),
        *disc.states(options),
    )


def equations(symbols: Symbols, options: Options) -> Equations:
    """Equations 4.4, 4.18 and 4.33-4.34, corrected, under given contact forces."""
    p = symbols.parameter
    phi, z = symbols.coordinate("phi"), symbols.coordinate("z")
    phi_dot, z_dot = symbols.velocity("phi"), symbols.velocity("z")
    plate = disc.Disc(symbols, options, phi)
    inertia = p("m") * p("r0") ** 2
    moment = p("r0") * symbols.tangential_force(0) - p("C_phi") * phi_dot - p("K_phi") * phi
    if options["slope_force"] == "include":
        moment -= symbols.normal_force(0) * plate.slope()
    lift = symbols.normal_force(0) - p("N0") - p("c_z") * z_dot - p("k_z") * z
    kinetic = (inertia * phi_dot**2 + p("m") * z_dot**2) / 2
    potential = (p("K_phi") * phi**2 + p("k_z") * z**2) / 2 + p("N0") * z
    return Equations(
        accelerations={"phi": moment / inertia, "z": lift / p("m"), **plate.accelerations()},
        contacts=(
            Contact(
                slip_velocity=p("r0") * (p("Omega") - phi_dot),
                slip_coordinate="phi",
                normal_force=None,
                gap=z - plate.displacement(),
                gap_coordinate="z",
                impact=options["impact"],
            ),
        ),
        kinetic_energy=kinetic + plate.kinetic_energy(),
        potential_energy=potential + plate.strain_energy(),
    )


MODEL = Model(
    name="disc-rigid-contact",
    title="slider in rigid contact with a spinning elastic disc",
    reference="thesis chapter 4; equations 4.1-4.56",
    numerics_version=1,
    parameters=PARAMETERS,
    states=states,
    equations=equations,
    default_law="exponential",
    law_defaults={"mu_0": 0.6, "mu_k": 0.35, "mu_s": 0.8, "alpha": 1.0},
    options=(disc.MODES, IMPACT, disc.SLOPE_FORCE, disc.DISC_DAMPING),
    revolution=lambda p: p["Omega"],
    derived=disc.DERIVED,
    surface=disc.surface,
    vibration=("phi", "z"),
    requirements=(disc.ON_THE_DISC,),
    singular=disc.singular,
    example=Example("Omega", 1.0, 10.0, {"xi": 1e-3}, disc.SHORT),
    sliding=Example("Omega", 20.0, 40.0, {"xi": 1e-3}, law="stribeck"),
)
