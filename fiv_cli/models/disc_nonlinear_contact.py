"""Slider in nonlinear contact with a spinning elastic disc (thesis 6.5).

The slider of ``compliant_disc.py`` and the disc of ``disc.py`` with

    F_N = k2 d + k_nl d^3 while d = w(r0, phi, t) - u > 0

Thesis 6.21-6.41. The moment term of 6.24 has the opposite sign there; 6.41c and d lack
sgn(Omega - phi') in it, 6.41d a factor l; in stick mu F_N is the friction force of 6.28; 6.38 to
6.40 lack a factor s in the terms with phi'.

Options: ``geometry = linear`` is the rigid disc (w = 0); ``states`` are the thesis' reduced
assumptions: ``slip`` (bilateral, always sliding), ``slip+separation`` (sliding one way, and
apart), ``slip+reverse+separation`` (no static friction: at zero slip velocity it would chatter,
which is stick with mu_s = mu_k).
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

from fiv_cli.models import compliant_disc, disc
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
    *compliant_disc.parameters(0.1),
    Parameter("k_nl", "k_{nl}", "N m-3", 1e6, "contact stiffness, cubic part", "6.25", 0.0),
    Parameter("F", "F", "N", 1000.0, "preload", "6.22", 0.0, role="preload"),
    Parameter("Omega", r"\Omega", "rad s-1", 10.0, "disc speed", "6.24", role="speed"),
    disc.damping_ratio(1e-4),
)

OPTIONS = (
    disc.MODES,
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
        "elastic disc, or a rigid one: two degrees of freedom",
    ),
    Option(
        "states",
        ("all", "slip", "slip+separation", "slip+reverse+separation"),
        "all",
        "states of motion: stick, slip both ways and separation, or fewer; without separation the "
        "contact may pull, and without reverse slip friction keeps its sense",
    ),
    Option(
        "impact",
        ("plastic", "none"),
        "plastic",
        "re-contact: slider and disc go on together, as in the thesis, or with their own "
        "velocities, k3 being a spring that only pushes",
    ),
    disc.SLOPE_FORCE,
    disc.DISC_DAMPING,
)


def states(options: Options) -> tuple[State, ...]:
    """phi, u and, on an elastic disc, the modal coordinates."""
    if options["geometry"] == "linear":
        return compliant_disc.SLIDER
    return compliant_disc.states(options)


def equations(symbols: Symbols, options: Options) -> Equations:
    """Equations 6.21, 6.22, 6.25 and 6.41, corrected, under given contact forces."""
    p = symbols.parameter
    elastic = options["geometry"] == "nonlinear"
    plate = disc.Disc(symbols, options, symbols.coordinate("phi")) if elastic else None
    d = compliant_disc.compression(symbols, plate)
    cubic = p("k_nl") if options["contact_stiffness"] == "nonlinear" else 0
    chosen = options["states"]
    contact = Contact(
        slip_velocity=compliant_disc.slip_velocity(symbols),
        slip_coordinate="phi",
        normal_force=p("k2") * d + cubic * d**3,
        gap=None if chosen == "slip" else -d,
        impact=options["impact"],
        sliding_only=chosen in ("slip", "slip+separation"),
        static_friction=chosen != "slip+reverse+separation",
    )
    energy = p("k2") * d**2 / 2 + cubic * d**4 / 4
    return compliant_disc.equations(symbols, options, plate, contact, 0, energy)


def surface(
    parameters: Mapping[str, float], options: Options, radius: float, angle: float
) -> Mapping[str, float]:
    """Weights of the modal coordinates; none on a rigid disc, where w = 0."""
    if options["geometry"] == "linear":
        return {}
    return disc.surface(parameters, options, radius, angle)


def singular(known: Mapping[str, float], options: Options) -> tuple[str, str]:
    """A rigid disc has no modes."""
    return ("", "") if options["geometry"] == "linear" else disc.singular(known, options)


MODEL = Model(
    name="disc-nonlinear-contact",
    title="slider in nonlinear contact with a disc: elastic, or rigid (two degrees of freedom)",
    reference="thesis 6.5; equations 6.21-6.42",
    numerics_version=1,
    parameters=PARAMETERS,
    states=states,
    equations=equations,
    default_law="coulomb",
    law_defaults={"mu_k": 0.3, "mu_s": 3.0},
    options=OPTIONS,
    revolution=lambda p: p["Omega"],
    derived=disc.DERIVED,
    surface=surface,
    vibration=("phi", "u"),
    requirements=(disc.ON_THE_DISC,),
    singular=singular,
    example=Example("Omega", 1.0, 4.0, {"F": 300.0, "xi": 1e-3}, disc.SHORT),
    sliding=Example("Omega", 1.0, 25.0, {"F": 300.0, "xi": 1e-3}, law="stribeck"),
)
