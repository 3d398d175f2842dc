"""Small models of the test suite: contacts that open, and several contacts at once."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from fiv_cli.analyses import all_analyses
from fiv_cli.models import all_models
from fiv_cli.models.base import (
    Contact,
    Equations,
    Forcing,
    Model,
    Option,
    Options,
    Parameter,
    State,
)

# Names of the shipped models and of the analyses that suit them.
SUITED = [
    (name, kind)
    for name, model in all_models().items()
    for kind, analysis in all_analyses().items()
    if not analysis.unsuited(model)
]


def _parameters(**defaults: float) -> tuple[Parameter, ...]:
    return tuple(Parameter(name, name, "1", value, name) for name, value in defaults.items())


def _coordinates(*names: str) -> tuple[State, ...]:
    return tuple(State(name, name, "m", name) for name in names)


# What all of them have in common.
SMALL = Model(
    name="",
    title="",
    reference="test suite",
    numerics_version=1,
    parameters=(),
    states=lambda options: (),
    equations=lambda symbols, options: Equations({}, (), 0, 0),
    default_law="coulomb",
    law_defaults={},
)


# --- a mass that slides on a belt and can leave it -------------------------------------------
def _bouncer(symbols: Any, options: Options) -> Equations:
    """m x'' = F_T - k x,  m z'' = F_N - m g - k_z (z - z0) + A cos(omega t); closed at z = 0."""
    import sympy

    p = symbols.parameter
    x, z = symbols.coordinate("x"), symbols.coordinate("z")
    x_dot, z_dot = symbols.velocity("x"), symbols.velocity("z")
    rigid = options["contact"] == "rigid"
    push = p("A") * sympy.cos(p("omega") * symbols.time)
    vertical = -p("m") * p("g") - p("k_z") * (z - p("z0")) + push
    compression = 0 if rigid else symbols.closed(0) * p("k_c") * z**2 / 2
    return Equations(
        accelerations={
            "x": (symbols.tangential_force(0) - p("k") * x) / p("m"),
            "z": (symbols.normal_force(0) + vertical) / p("m"),
        },
        contacts=(
            Contact(
                slip_velocity=p("v") - x_dot,
                slip_coordinate="x",
                normal_force=None if rigid else -p("k_c") * z,
                gap=z,
                gap_coordinate="z" if rigid else None,
                impact="none" if options["contact"] == "elastic" else "plastic",
            ),
        ),
        kinetic_energy=p("m") * (x_dot**2 + z_dot**2) / 2,
        potential_energy=p("k") * x**2 / 2
        + p("m") * p("g") * z
        + p("k_z") * (z - p("z0")) ** 2 / 2
        + compression,
    )


BOUNCER = replace(
    SMALL,
    name="bouncer",
    title="mass on a belt with a unilateral contact",
    parameters=_parameters(m=1.0, k=1.0, g=10.0, k_z=0.0, z0=0.0, k_c=1e4, A=0.0, omega=3.0, v=1.0),
    states=lambda options: _coordinates("x", "z"),
    equations=_bouncer,
    options=(
        Option("contact", ("rigid", "compliant", "elastic"), "rigid", "how the contact gives way"),
    ),
)


# --- ... over a floor whose height is a state ---------------------------------------------------
def _raised(symbols: Any, options: Options) -> Equations:
    """The bouncer, closed where z is the height of a floor that nothing moves."""
    found = _bouncer(symbols, options)
    (contact,) = found.contacts
    gap = symbols.coordinate("z") - symbols.coordinate("floor")
    force = None if contact.normal_force is None else -symbols.parameter("k_c") * gap
    return replace(
        found,
        accelerations={**found.accelerations, "floor": 0},
        contacts=(replace(contact, gap=gap, normal_force=force),),
    )


RAISED_BOUNCER = replace(
    BOUNCER,
    name="raised-bouncer",
    states=lambda options: _coordinates("x", "z", "floor"),
    equations=_raised,
)


# --- two masses on one belt ------------------------------------------------------------------
def _two_masses(symbols: Any, options: Options) -> Equations:
    """Two equal-sided masses on one belt, each on a spring, coupled by another."""
    p = symbols.parameter
    x = [symbols.coordinate(name) for name in ("x1", "x2")]
    x_dot = [symbols.velocity(name) for name in ("x1", "x2")]
    coupling = p("k_c") * (x[0] - x[1])
    pulls = (-p("k1") * x[0] - coupling, -p("k2") * x[1] + coupling)
    force = symbols.tangential_force
    return Equations(
        accelerations={"x1": (force(0) + pulls[0]) / p("m"), "x2": (force(1) + pulls[1]) / p("m")},
        contacts=tuple(
            Contact(
                slip_velocity=p("v") - x_dot[i],
                slip_coordinate=f"x{i + 1}",
                normal_force=p(f"N{i + 1}"),
            )
            for i in range(2)
        ),
        kinetic_energy=p("m") * (x_dot[0] ** 2 + x_dot[1] ** 2) / 2,
        potential_energy=(p("k1") * x[0] ** 2 + p("k2") * x[1] ** 2) / 2
        + p("k_c") * (x[0] - x[1]) ** 2 / 2,
    )


TWO_MASSES = replace(
    SMALL,
    name="two-masses",
    title="two masses on one belt, coupled by a spring",
    parameters=_parameters(m=1.0, k1=1.0, k2=1.0, k_c=0.5, N1=10.0, N2=10.0, v=1.0),
    states=lambda options: _coordinates("x1", "x2"),
    equations=_two_masses,
    contacts=2,
)


# --- one mass on two belts ---------------------------------------------------------------------
def _on_two_belts(symbols: Any, options: Options) -> Equations:
    """m x'' = F_T1 + F_T2 - k x: the belts, above and below, pull at one and the same mass."""
    p = symbols.parameter
    x, x_dot = symbols.coordinate("x"), symbols.velocity("x")
    pulls = symbols.tangential_force(0) + symbols.tangential_force(1)
    return Equations(
        accelerations={"x": (pulls - p("k") * x) / p("m")},
        contacts=tuple(
            Contact(slip_velocity=p(f"V{i}") - x_dot, slip_coordinate="x", normal_force=p(f"N{i}"))
            for i in (1, 2)
        ),
        kinetic_energy=p("m") * x_dot**2 / 2,
        potential_energy=p("k") * x**2 / 2,
    )


ON_TWO_BELTS = replace(
    SMALL,
    name="on-two-belts",
    title="one mass between two belts",
    parameters=_parameters(m=1.0, k=1.0, N1=6.0, N2=4.0, V1=1.0, V2=1.0),
    states=lambda options: _coordinates("x"),
    equations=_on_two_belts,
    contacts=2,
)


# --- pads at levers, and in a plane ---------------------------------------------------------------
def _clutch(symbols: Any, options: Options) -> Equations:
    """J phi'' = r1 F_T1 - r2 F_T2 - k phi: one pad at r1, one at r2 that counts slip backwards."""
    p, force = symbols.parameter, symbols.tangential_force
    phi, phi_dot = symbols.coordinate("phi"), symbols.velocity("phi")
    return Equations(
        accelerations={"phi": p("r1") * force(0) - p("r2") * force(1) - p("k") * phi},
        contacts=tuple(
            Contact(sense * p(r) * (p("Omega") - phi_dot), "phi", p(load))
            for sense, r, load in ((1, "r1", "N1"), (-1, "r2", "N2"))
        ),
        kinetic_energy=phi_dot**2 / 2,
        potential_energy=p("k") * phi**2 / 2,
    )


CLUTCH = replace(
    SMALL,
    name="clutch",
    title="two pads at one shaft",
    parameters=_parameters(k=1.0, r1=0.5, r2=1.5, N1=6.0, N2=4.0, Omega=1.0),
    states=lambda options: _coordinates("phi"),
    equations=_clutch,
    contacts=2,
)


def _pads(symbols: Any, options: Options) -> Equations:
    """x'' = F - x, y'' = F - y: pads that pull at a body in a plane, each in its direction."""
    p, force = symbols.parameter, symbols.tangential_force
    x, y, z = map(symbols.coordinate, "xyz")
    x_dot, y_dot, z_dot = map(symbols.velocity, "xyz")
    moved, solved_for = {
        "crossed": ([x_dot, x_dot + p("a") * y_dot], "xy"),
        "turning": ([x_dot, x_dot + z * y_dot], "xy"),
        "on-one-state": ([x_dot, x_dot + y_dot], "xx"),
        "three": ([x_dot, y_dot, x_dot + y_dot], "xyy"),
        "rigid": ([x_dot, x_dot], "xx"),
    }[options["pads"]]
    rigid = options["pads"] == "rigid"
    gaps = [(z, "z"), (z + y, "y")]
    pulls = {
        name: sum(force(i) * rate.diff(of) for i, rate in enumerate(moved))
        for name, of in (("x", x_dot), ("y", y_dot), ("z", z_dot))
    }
    pulls["z"] += sum(symbols.normal_force(i) for i in range(2)) - 10 if rigid else 0
    pulls["y"] += symbols.normal_force(1) if rigid else 0
    return Equations(
        accelerations={name: pull - symbols.coordinate(name) for name, pull in pulls.items()},
        contacts=tuple(
            Contact(p("v") - rate, state, None, *gaps[i])
            if rigid
            else Contact(p("v") - rate, state, p("N"))
            for i, (rate, state) in enumerate(zip(moved, solved_for, strict=True))
        ),
        kinetic_energy=(x_dot**2 + y_dot**2 + z_dot**2) / 2,
        potential_energy=(x**2 + y**2 + z**2) / 2,
    )


PADS = replace(
    SMALL,
    name="pads",
    title="pads at a body in a plane",
    parameters=_parameters(a=1.0, N=10.0, v=1.0),
    states=lambda options: _coordinates("x", "y", "z"),
    equations=_pads,
    contacts=2,
    options=(
        Option(
            "pads",
            ("crossed", "turning", "on-one-state", "three", "rigid"),
            "crossed",
            "how they lie",
        ),
    ),
)


# --- two masses that can leave the belt ------------------------------------------------------
def _two_bouncers(symbols: Any, options: Options) -> Equations:
    """Two masses over one belt, lifted by one harmonic force; each contact opens on its own."""
    import sympy

    p = symbols.parameter
    push = p("A") * sympy.cos(p("omega") * symbols.time)
    x_dot = [symbols.velocity(name) for name in ("x1", "x2")]
    z_dot = [symbols.velocity(name) for name in ("z1", "z2")]
    x = [symbols.coordinate(name) for name in ("x1", "x2")]
    z = [symbols.coordinate(name) for name in ("z1", "z2")]
    accelerations, contacts = {}, []
    for i, mass in enumerate((p("m1"), p("m2"))):
        force = symbols.tangential_force(i) - p("k") * x[i]
        accelerations[f"x{i + 1}"] = force / mass
        lift = symbols.normal_force(i) - mass * p("g") + push
        accelerations[f"z{i + 1}"] = lift / mass
        contacts.append(
            Contact(
                slip_velocity=p("v") - x_dot[i],
                slip_coordinate=f"x{i + 1}",
                normal_force=None,
                gap=z[i],
                gap_coordinate=f"z{i + 1}",
            )
        )
    masses = (p("m1"), p("m2"))
    return Equations(
        accelerations=accelerations,
        contacts=tuple(contacts),
        kinetic_energy=sum(
            mass * (x_dot[i] ** 2 + z_dot[i] ** 2) / 2 for i, mass in enumerate(masses)
        ),
        potential_energy=sum(
            mass * p("g") * z[i] + p("k") * x[i] ** 2 / 2 for i, mass in enumerate(masses)
        ),
    )


TWO_BOUNCERS = replace(
    SMALL,
    name="two-bouncers",
    title="two masses over one belt, both contacts unilateral",
    parameters=_parameters(m1=1.0, m2=1.0, k=1.0, g=10.0, A=0.0, omega=3.0, v=1.0),
    states=lambda options: _coordinates("x1", "x2", "z1", "z2"),
    equations=_two_bouncers,
    contacts=2,
)


# --- a ball on a shaking table -----------------------------------------------------------------
def _ball(symbols: Any, options: Options) -> Equations:
    """z'' = -g, x'' + c x' + k x = 0; the table is at A cos(omega t), restitution e."""
    import sympy

    p = symbols.parameter
    x, z = symbols.coordinate("x"), symbols.coordinate("z")
    x_dot, z_dot = symbols.velocity("x"), symbols.velocity("z")
    table = p("A") * sympy.cos(p("omega") * symbols.time)
    gap = z - table
    gap_rate = z_dot - sympy.diff(table, symbols.time)
    return Equations(
        accelerations={
            "x": symbols.tangential_force(0) - p("c") * x_dot - p("k") * x,
            "z": symbols.normal_force(0) - p("g"),
        },
        contacts=(
            Contact(
                slip_velocity=p("v") - x_dot,
                slip_coordinate="x",
                normal_force=-p("k_c") * gap,
                gap=gap,
                closing_rate=(1 + p("e")) * gap_rate,
            ),
        ),
        kinetic_energy=(x_dot**2 + z_dot**2) / 2,
        potential_energy=p("g") * z + p("k") * x**2 / 2,
    )


BALL = replace(
    SMALL,
    name="ball",
    title="ball on a shaking table, with a coefficient of restitution",
    parameters=_parameters(
        k=1.0, c=0.2, g=10.0, k_c=1e4, e=0.8, A=0.1, omega=6.283185307179586, v=5.0
    ),
    states=lambda options: _coordinates("x", "z"),
    equations=_ball,
    law_defaults={"mu_k": 0.0, "mu_s": 0.0},
    forcings=(Forcing("A", lambda p: p["omega"], "shaking of the table"),),
)


# --- a mass on a belt between two wells ----------------------------------------------------------
def _double_well(symbols: Any, options: Options) -> Equations:
    """m x'' + c x' + k (x^3 - x) = F_T: two stable sliding equilibria and one between them."""
    p = symbols.parameter
    x, x_dot = symbols.coordinate("x"), symbols.velocity("x")
    force = -p("k") * (x**3 - x) - p("c") * x_dot
    return Equations(
        accelerations={"x": (force + symbols.tangential_force(0)) / p("m")},
        contacts=(Contact(slip_velocity=p("v") - x_dot, slip_coordinate="x", normal_force=p("N")),),
        kinetic_energy=p("m") * x_dot**2 / 2,
        potential_energy=p("k") * (x**4 / 4 - x**2 / 2),
    )


DOUBLE_WELL = replace(
    SMALL,
    name="double-well",
    title="mass on a belt between two wells",
    parameters=_parameters(m=1.0, k=1.0, c=0.2, N=0.5, v=2.0),
    states=lambda options: _coordinates("x"),
    equations=_double_well,
    law_defaults={"mu_s": 0.2, "mu_k": 0.1},
)
