"""Slider on a spinning elastic disc under a tangential excitation (thesis 5.3).

The slider of ``compliant_disc.py`` and the disc of ``disc.py`` with F_N = k2 (w - u) and the
force A sin(omega t) on the slider, omega = R omega_cr. omega_cr is the lowest critical speed of
the disc, min omega_kl / l over its modes with l > 0 (5.32).

Thesis 5.16-5.31. 5.30 agrees with 5.19: F_N = k2 (w - u) > 0 in contact pushes the disc down and
the slider up. As printed the disc is undamped, and then every speed is unstable; a modal damping
ratio xi of about 2e-4 restores the printed onset.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import TYPE_CHECKING

from fiv_cli.models import compliant_disc, disc
from fiv_cli.models.base import (
    Contact,
    Derived,
    Equations,
    Example,
    Forcing,
    Model,
    Option,
    Options,
    Parameter,
)

if TYPE_CHECKING:
    from fiv_cli.models.symbols import Symbols

PARAMETERS = (
    *compliant_disc.parameters(5.0),
    Parameter("F", "F", "N", 100.0, "preload", "5.17", 0.0, role="preload"),
    Parameter("Omega", r"\Omega", "rad s-1", 5.0, "disc speed", "5.24", role="speed"),
    disc.damping_ratio(0.0),
    Parameter(
        "A", "A", "N", 0.0, "amplitude of the tangential force", "5.16", 0.0, role="amplitude"
    ),
    Parameter(
        "R",
        "R",
        "1",
        22.0,
        "frequency ratio omega/omega_cr",
        "5.32",
        0.0,
        exclusive=True,
        role="frequency",
    ),
)


def _read_modes(value: object) -> str:
    """Modes of which one at least is a doublet: only those have a critical speed."""
    text = disc.read_modes(value)
    if all(n == 0 for _, n in disc.modes({"modes": text})):
        raise ValueError(
            "no mode has a nodal diameter: without a critical speed the force has no frequency"
        )
    return text


MODES = replace(disc.MODES, read=_read_modes, form=f"{disc.MODES.form}, with one at least of l > 0")

STATES_OF_MOTION = Option(
    "states",
    ("slip", "all"),
    "slip",
    "bilateral contact as in the thesis (friction reverses with slip), or separation too",
)


def _names(options: Options) -> tuple[str, ...]:
    return (*disc.DERIVED.names(options), "omega_cr")


def _values(parameters: Mapping[str, float], options: Options) -> dict[str, float]:
    """The numbers of the plate, and the lowest critical speed in rad/s."""
    found = dict(disc.DERIVED.values(parameters, options))
    speeds = [found[f"omega_{k}_{n}"] / n for k, n in disc.modes(options) if n]
    return found | {"omega_cr": min(speeds, default=0.0)}


def equations(symbols: Symbols, options: Options) -> Equations:
    """Equations 5.16-5.17 and 5.30 under given contact forces."""
    import sympy

    p = symbols.parameter
    plate = disc.Disc(symbols, options, symbols.coordinate("phi"))
    compression = compliant_disc.compression(symbols, plate)
    bilateral = options["states"] == "slip"
    contact = Contact(
        slip_velocity=compliant_disc.slip_velocity(symbols),
        slip_coordinate="phi",
        normal_force=p("k2") * compression,
        gap=None if bilateral else -compression,
    )
    excitation = p("A") * sympy.sin(p("R") * p("omega_cr") * symbols.time)
    energy = p("k2") * compression**2 / 2
    return compliant_disc.equations(symbols, options, plate, contact, excitation, energy)


def omega(parameters: Mapping[str, float]) -> float:
    """Angular frequency of the tangential force, rad/s (5.32)."""
    return parameters["R"] * parameters["omega_cr"]


def fast_velocity(parameters: Mapping[str, float]) -> float:
    """Amplitude of the fast slip velocity, m/s: omega_cr C_d of 5.45 and 5.51.

    Zero without a critical speed, where the excitation has no frequency.
    """
    frequency = omega(parameters)
    return parameters["A"] / (parameters["m"] * frequency) if frequency else 0.0


MODEL = Model(
    name="excited-disc",
    title="slider on a spinning elastic disc with a tangential excitation",
    reference="thesis 5.3, 5.4.2; equations 5.16-5.54",
    numerics_version=1,
    parameters=PARAMETERS,
    states=compliant_disc.states,
    equations=equations,
    default_law="exponential",
    law_defaults={"mu_s": 1.5, "mu_k": 1.2, "alpha": 1.0},
    options=(MODES, STATES_OF_MOTION, disc.SLOPE_FORCE, disc.DISC_DAMPING),
    forcings=(Forcing("A", omega, "tangential harmonic force", fast_velocity),),
    revolution=lambda p: p["Omega"],
    derived=Derived(_names, _values, disc.DERIVED.sources),
    surface=disc.surface,
    vibration=("phi", "u"),
    requirements=(disc.ON_THE_DISC,),
    singular=disc.singular,
    example=Example("Omega", 0.5, 2.0, {"xi": 2e-4}, disc.SHORT),
    sliding=Example("Omega", 1.0, 20.0, {"xi": 2e-4}, law="stribeck"),
)
