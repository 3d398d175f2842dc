"""A surface whose friction varies along it: a smooth seeded random function of the place.

    r(s) = sqrt(2) sum a_j cos(kappa_j s/l + phi_j),    kappa_j = 1/4, 3/4 ... 11/4
    a_j^2 as exp(-kappa_j^2/2), together 1;    phi_j = 10^4 sin(78.233 seed + 12.9898 j)

s is by how far the surfaces have slid over one another, l the correlation length. Along a surface
and over the seeds r has the mean 0, the variance 1, and, to 0.005 and up to 8 l, the correlation
exp(-s^2/(2 l^2)). Its wavelength is 8 pi l, half of one on it is -r, and it never exceeds
`HIGHEST`. The phases are a formula: a seed means the same everywhere, and may be an axis.

s follows from the model: what the slip velocity is the rate of. Under a steady drive a surface
excites the system with the period at which the drive passes a wavelength.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from functools import cache
from math import exp, pi, sqrt
from typing import TYPE_CHECKING

from fiv_cli.errors import UsageError
from fiv_cli.friction.base import Law, Surface
from fiv_cli.models.base import Contact, Forcing, Model, Parameter
from fiv_cli.models.excitation import common_period

if TYPE_CHECKING:
    from sympy import Expr

    from fiv_cli.models.symbols import Symbols

TERMS = 6
PER_UNIT = 2  # terms in a unit of kappa
SPREAD, OF_SEED, OF_TERM = 1e4, 78.233, 12.9898


def _weights() -> list[tuple[float, float]]:
    """(kappa_j, sqrt(2) a_j)."""
    wavenumbers = [(j - 0.5) / PER_UNIT for j in range(1, TERMS + 1)]
    every = sum(exp(-(kappa**2) / 2) for kappa in wavenumbers)
    return [(kappa, sqrt(2 * exp(-(kappa**2) / 2) / every)) for kappa in wavenumbers]


HIGHEST = sum(weight for _, weight in _weights())

LENGTH = Parameter(
    "correlation_length", "l", "m", 0.1, "way over which the surface stays alike", "2.9",
    0.0, exclusive=True,
)  # fmt: skip
SEED = Parameter(
    "seed", "n", "1", 1.0, "which of the random surfaces it is", "2.9", 0.0, integer=True
)


def roughness_at(way: Expr, p: Mapping[str, Expr]) -> Expr:
    """r, where the surfaces have slid by `way`, m."""
    import sympy

    total = sympy.Integer(0)
    for j, (wavenumber, weight) in enumerate(_weights(), 1):
        phase = SPREAD * sympy.sin(OF_SEED * p["seed"] + OF_TERM * j)
        turned = wavenumber * way / p["correlation_length"]
        total += weight * sympy.cos(turned + phase)
    return total


def rough(amplitude: str) -> Surface:
    """The surface on which a parameter is what it is called times r."""
    return Surface(
        amplitude,
        lambda p: 4 * pi * PER_UNIT * p["correlation_length"],
        lambda way, p: {amplitude: p[amplitude] * roughness_at(way, p)},
    )


def way_slid(
    contact: Contact, coordinates: Sequence[str], symbols: Symbols, scheduled: Sequence[str]
) -> Expr:
    """What the slip velocity of a contact is the rate of, m; 0 at t = 0 and in the origin.

    Raises
    ------
    UsageError
        it is the rate of nothing, or of something that a schedule has no formula of.
    """
    import sympy

    t, velocities = symbols.time, {q: symbols.velocity(q) for q in coordinates}
    shares = {q: sympy.diff(contact.slip_velocity, v) for q, v in velocities.items()}
    drive = contact.slip_velocity.subs(dict.fromkeys(velocities.values(), 0))
    places = {symbols.coordinate(q) for q in coordinates}
    bound = {*places, t, *velocities.values()}
    told = set().union(*(sympy.sympify(share).free_symbols for share in shares.values()))
    rates = {symbols.parameter_rate(name) for name in scheduled}
    if told & (bound | rates) or drive.free_symbols & (places | rates):
        raise UsageError(
            "how far this contact has slid does not follow from where the system is, and its "
            "friction varies along the surface\nnext: another friction law, or no [schedule]"
        )
    positive = {s: sympy.Dummy(positive=True) for s in drive.free_symbols - {t}}
    travelled = sympy.integrate(drive.xreplace(positive), (t, 0, t))
    carried = travelled.xreplace({dummy: s for s, dummy in positive.items()})
    return carried + sum(share * symbols.coordinate(q) for q, share in shares.items())


@cache
def on_surface(model: Model, law: Law) -> Model:
    """`model` under a law that varies along the surface, which excites it."""
    surface = law.surface
    assert surface is not None
    forcings = tuple(_forcing(surface, drive) for drive in _drives(model))
    every = (*model.forcings, *forcings)
    together = common_period(every, model.derived is not None)
    requirements = (*model.requirements, together)
    return replace(model, forcings=every, requirements=requirements)


def forcings_under(model: Model, laws: Iterable[Law]) -> tuple[Forcing, ...]:
    """What excites `model` under any of these laws."""
    under = (model if law.surface is None else on_surface(model, law) for law in laws)
    return tuple(dict.fromkeys(forcing for one in under for forcing in one.forcings))


def _forcing(surface: Surface, drive: Callable[[Mapping[str, float]], float]) -> Forcing:
    return Forcing(
        surface.amplitude,
        lambda p: 2 * pi * drive(p) / surface.wavelength(p),
        "surface whose friction varies along it",
    )


def _drives(model: Model) -> Iterator[Callable[[Mapping[str, float]], float]]:
    """Of each contact under the law of the case, its mean slip velocity at rest, of parameters."""
    import sympy

    from fiv_cli.models.symbols import Symbols

    symbols = Symbols()
    off = {symbols.parameter(forcing.amplitude): 0 for forcing in model.forcings}
    still = off | {symbols.velocity(s.name): 0 for s in model.states(model.default_options())}
    for contact in model.equations(symbols, model.default_options()).contacts:
        if contact.law is None:
            drive = sympy.sympify(contact.slip_velocity).subs(still)
            free = sorted(drive.free_symbols, key=str)
            names = [str(symbol).removeprefix("p.") for symbol in free]
            yield _function(names, sympy.lambdify(free, drive, "math"))


def _function(
    names: Sequence[str], value: Callable[..., float]
) -> Callable[[Mapping[str, float]], float]:
    return lambda p: float(value(*(p[name] for name in names)))
