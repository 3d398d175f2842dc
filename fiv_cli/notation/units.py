"""Numbers with units: ``"20 rpm"`` where a parameter is in rad s-1.

Conversion is exact: a decimal times a rational factor, rounded to a double once at the end, so
``"5 mm"`` is the double nearest to 0.005. Factors with pi carry fifty digits of it.

Units are written as UDUNITS or everyday text has them: ``N m-1``, ``N/m``, ``kg*m^2``, ``kg m²``.
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from fractions import Fraction
from math import isfinite

PI = Fraction("3.14159265358979323846264338327950288419716939937510")

_NUMBER = re.compile(r"\s*([+-]?(?:\d[\d_]*\.?\d*|\.\d+)(?:[eE][+-]?\d+)?)\s*(.*?)\s*", re.DOTALL)
_FACTOR = re.compile(r"([A-Za-zµμ°%]+)\^?([+-]?\d+)?")
_SUPERSCRIPTS = str.maketrans("⁻⁰¹²³⁴⁵⁶⁷⁸⁹", "-0123456789")
# A number so long or so large that only a mistake writes it; exact arithmetic would crawl on it.
_LONGEST = 60
_LARGEST_EXPONENT = 330


@dataclass(frozen=True)
class Unit:
    """A unit: its value in SI and its exponents of kg, m, s and rad."""

    factor: Fraction
    mass: int = 0
    length: int = 0
    time: int = 0
    angle: int = 0

    def __mul__(self, other: Unit) -> Unit:
        return Unit(
            self.factor * other.factor,
            self.mass + other.mass,
            self.length + other.length,
            self.time + other.time,
            self.angle + other.angle,
        )

    def __pow__(self, exponent: int) -> Unit:
        return Unit(
            self.factor**exponent,
            self.mass * exponent,
            self.length * exponent,
            self.time * exponent,
            self.angle * exponent,
        )

    def fits(self, other: Unit) -> bool:
        """Whether a value in `self` can stand where `other` is wanted.

        The radian is told apart from 1 where nothing mechanical is in the unit (``Hz`` and
        ``s-1`` are not the same), and ignored otherwise (``N m/rad`` fits ``N m``).
        """
        mechanical = (self.mass, self.length, self.time)
        same = mechanical == (other.mass, other.length, other.time)
        return same and (self.angle == other.angle or bool(self.mass or self.length))


_ONE = Fraction(1)
_PLAIN = {
    "%": Unit(Fraction(1, 100)),
    "deg": Unit(PI / 180, angle=1),
    "°": Unit(PI / 180, angle=1),
    "rev": Unit(2 * PI, angle=1),
    "rpm": Unit(2 * PI / 60, time=-1, angle=1),
    "min": Unit(Fraction(60), time=1),
    "h": Unit(Fraction(3600), time=1),
}
_PREFIXED = {
    "g": Unit(Fraction(1, 1000), mass=1),
    "m": Unit(_ONE, length=1),
    "s": Unit(_ONE, time=1),
    "rad": Unit(_ONE, angle=1),
    "N": Unit(_ONE, 1, 1, -2),
    "Pa": Unit(_ONE, 1, -1, -2),
    "J": Unit(_ONE, 1, 2, -2),
    "W": Unit(_ONE, 1, 2, -3),
    "Hz": Unit(2 * PI, time=-1, angle=1),
}
_PREFIXES = {
    "": _ONE,
    "n": Fraction(1, 10**9),
    "u": Fraction(1, 10**6),
    "µ": Fraction(1, 10**6),
    "μ": Fraction(1, 10**6),
    "m": Fraction(1, 1000),
    "c": Fraction(1, 100),
    "k": Fraction(1000),
    "M": Fraction(10**6),
    "G": Fraction(10**9),
}
UNITS: dict[str, Unit] = {
    prefix + name: Unit(factor) * unit
    for name, unit in _PREFIXED.items()
    for prefix, factor in _PREFIXES.items()
} | _PLAIN


_FORMULA = re.compile(r"[*/+(]")
_NO = (
    "no formula (axes that advance together: zip in [sweep]; a parameter that follows from others: "
    "a model of your own, fiv new-model)"
)


def parse_unit(text: str) -> Unit:
    """The unit that `text` names; ValueError when it names none."""
    unit = Unit(_ONE)
    for sign, factor in _factors(text.translate(_SUPERSCRIPTS)):
        match = _FACTOR.fullmatch(factor)
        if match is None or match[1] not in UNITS:
            told = "" if text.strip()[:1].isalpha() else f": a text is a number and its unit, {_NO}"
            raise ValueError(f"unknown unit {text!r}{told}")
        unit = unit * UNITS[match[1]] ** (sign * int(match[2] or 1))
    return unit


def exact(value: float | str, unit: str) -> Fraction:
    """`value` in `unit`, exactly: the decimal written, its own unit converted if it has one.

    Raises
    ------
    ValueError
        Not a number, an unknown unit, or one that does not fit `unit`.
    """
    if not isinstance(value, str):
        if not isfinite(value):
            raise ValueError(f"must be finite, not {value!r}")
        return Fraction(repr(value))
    number, given = _split(value, unit)
    if not given:
        return number
    target = parse_unit(unit)
    try:
        source = parse_unit(given)
    except ValueError as error:
        raise ValueError(f"{error}; {_fitting(unit)}") from None
    if not source.fits(target):
        raise ValueError(f"the unit of {value!r} does not fit {_spoken(unit)}; {_fitting(unit)}")
    return number * source.factor / target.factor


def convert(value: float | str, unit: str) -> float:
    """The double nearest to `value` in `unit`; ValueError as `exact`, or when it overflows."""
    return nearest_double(exact(value, unit))


def in_si(text: str) -> float:
    """The number with a unit that `text` states, in SI; ValueError when it states none."""
    number, unit = _split(text, "1")
    return nearest_double(number * parse_unit(unit or "1").factor)


def nearest_double(value: Fraction) -> float:
    """The double nearest to `value`; ValueError when there is none."""
    try:
        return float(value)
    except OverflowError:
        raise ValueError("the number is too large for a double") from None


def _fitting(unit: str) -> str:
    """The units that a value in `unit` may be given in."""
    names = list(dict.fromkeys(_FACTOR.fullmatch(factor)[1] for _, factor in _factors(unit)))  # type: ignore[index]
    whole = [*([] if [unit] == names else [unit]), *_like(parse_unit(unit))]
    parts = [f"{name}: {', '.join(_like(UNITS[name]))}" for name in names if [unit] != names]
    return "; of ".join([f"it may be in {', '.join(whole)}", *parts])


def _like(wanted: Unit) -> list[str]:
    """The names of all units that measure the same."""
    return [name for name, unit in UNITS.items() if name.isascii() and unit.fits(wanted)]


def _split(text: str, unit: str) -> tuple[Fraction, str]:
    match = _NUMBER.fullmatch(text)
    if match is None:
        example = "2.5" if unit == "1" else f"2.5 {unit}"
        told = f": {_NO}" if _FORMULA.search(text) else ""
        raise ValueError(f'{text!r} is not a number with a unit, such as "{example}"{told}')
    if match[2].startswith(","):
        raise ValueError(f"{text!r} has a comma; decimals stand behind a point")
    _refuse_absurd(match[1])
    return Fraction(match[1]), match[2]


def _refuse_absurd(digits: str) -> None:
    exponent = re.split("[eE]", digits)[1:] or ["0"]
    if len(digits) > _LONGEST or abs(int(exponent[0])) > _LARGEST_EXPONENT:
        raise ValueError(f"{digits} is out of the range of a double")


def _factors(text: str) -> list[tuple[int, str]]:
    """``N s/m`` -> [(1, "N"), (1, "s"), (-1, "m")]: a slash turns the one factor behind it."""
    tokens = re.sub(r"[*·.]", " ", text.replace("**", "^").replace("/", " / ")).split()
    signed, sign = [], 1
    for token in tokens:
        if token == "/":
            sign = -1
        else:
            signed.append((sign, token))
            sign = 1
    if not signed or sign == -1:
        raise ValueError(f"unknown unit {text!r}")
    return [(sign, token) for sign, token in signed if token != "1"]


def _spoken(unit: str) -> str:
    return "a number without unit" if unit == "1" else f"{unit!r}"
