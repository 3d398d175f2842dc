"""What the two models with a contact spring on a disc share (thesis Figures 5.2 and 6.19).

A slider with a tangential spring k1, a spring k3 at 45 degrees and dampers c1, c2, pressed on the
disc by F through the contact stiffness k2:

    m r0 phi'' + c1 r0 phi' + (k1 + k3/2) r0 phi - k3/2 u = F_T  [- F_N dw/dtheta / r0]
    m u'' + c2 u' - k3/2 r0 phi + k3/2 u + F             = F_N
    v_rel = r0 (Omega - phi'),      compression d = w(r0, phi, t) - u

Thesis 5.16, 5.17, 6.21 and 6.22. In brackets: ``slope_force = include``, which consistent
mechanics has and the thesis omits.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from fiv_cli.models import disc
from fiv_cli.models.base import Contact, Equations, Options, Parameter, State

if TYPE_CHECKING:
    from sympy import Expr

    from fiv_cli.models.symbols import Symbols


def parameters(damping: float) -> tuple[Parameter, ...]:
    """The plate and the slider, the default of both dampers being `damping`, N s/m."""
    return (
        *disc.PLATE,
        Parameter("m", "m", "kg", 1.0, "mass of the slider", "5.16", 0.0, exclusive=True),
        _stiffness("k1", "k_1", 1e5, "tangential stiffness"),
        Parameter("k2", "k_2", "N m-1", 5e4, "contact stiffness", "5.19", 0.0, exclusive=True),
        _stiffness("k3", "k_3", 6e4, "stiffness of the spring at 45 degrees"),
        Parameter("c1", "c_1", "N s m-1", damping, "tangential damping", "5.16", 0.0),
        Parameter("c2", "c_2", "N s m-1", damping, "normal damping", "5.17", 0.0),
    )


def _stiffness(name: str, symbol: str, default: float, meaning: str) -> Parameter:
    return Parameter(name, symbol, "N m-1", default, meaning, "5.16", 0.0)


SLIDER = (
    State("phi", r"\varphi", "rad", "angle of the slider"),
    State("u", "u", "m", "normal displacement of the slider"),
)


def compression(symbols: Symbols, plate: disc.Disc | None) -> Expr:
    """d = w - u; on a rigid disc w = 0."""
    displacement = 0 if plate is None else plate.displacement()
    return displacement - symbols.coordinate("u")


def equations(
    symbols: Symbols,
    options: Options,
    plate: disc.Disc | None,
    contact: Contact,
    excitation: Expr,
    contact_energy: Expr,
) -> Equations:
    """Slider and disc under given contact forces; `plate` is None for a rigid disc."""
    p = symbols.parameter
    phi, u = symbols.coordinate("phi"), symbols.coordinate("u")
    phi_dot, u_dot = symbols.velocity("phi"), symbols.velocity("u")
    r0, normal = p("r0"), symbols.normal_force(0)
    diagonal = p("k3") / 2 * (r0 * phi - u)
    along = symbols.tangential_force(0) + excitation
    along -= p("c1") * r0 * phi_dot + p("k1") * r0 * phi + diagonal
    if plate is not None and options["slope_force"] == "include":
        along -= normal * plate.slope() / r0
    across = normal - p("F") - p("c2") * u_dot + diagonal
    kinetic = p("m") * ((r0 * phi_dot) ** 2 + u_dot**2) / 2
    springs = (p("k1") * (r0 * phi) ** 2 + p("k3") / 2 * (r0 * phi - u) ** 2) / 2
    potential = springs + p("F") * u + symbols.closed(0) * contact_energy
    modal = {} if plate is None else plate.accelerations()
    return Equations(
        accelerations={"phi": along / (p("m") * r0), "u": across / p("m"), **modal},
        contacts=(contact,),
        kinetic_energy=kinetic + (0 if plate is None else plate.kinetic_energy()),
        potential_energy=potential + (0 if plate is None else plate.strain_energy()),
    )


def states(options: Options) -> tuple[State, ...]:
    """phi, u and the modal coordinates."""
    return (*SLIDER, *disc.states(options))


def slip_velocity(symbols: Symbols) -> Expr:
    """v_rel of the slider, m/s."""
    p = symbols.parameter
    return p("r0") * (p("Omega") - symbols.velocity("phi"))
