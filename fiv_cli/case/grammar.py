"""The grammar of figures and claims: conditions on ``.``, what is taken and what is expected.

README.md, "What a figure or a claim can say", is the same for people.
"""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from fiv_cli.case.toml import parse_toml, toml_text, toml_value
from fiv_cli.notation.values import check_number, describe

Test = tuple[str, float]
"""A sign of comparison and a bound: what ``.`` stands to the left of."""

Bound = float | str
"""A number, or ``CASE:variable``: what another case holds at the same point."""

SAME = 1e-9
"""Two doubles nearest to the same decimal differ by less."""

EXPECT_SCHEMA = {"anyOf": [{"type": "string"}, {"type": "object"}]}
HOLDS_SCHEMA = {"anyOf": [{"enum": ["all", "any"]}, {"type": "number"}]}

_FORMS = (
    'a class, "not CLASS", "increasing", "decreasing", { value = V, tolerance = T }, '
    "{ less_than = V }, { greater_than = V } or { between = [LOW, HIGH] }"
)
_NUMBER = r"[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?"
_CONDITION = re.compile(
    rf"\s*(?:(?P<low>{_NUMBER})\s*(?P<left><=?)\s*)?\.\s*"
    rf"(?:(?P<right><=?|>=?|==)\s*(?P<high>{_NUMBER})\s*)?"
)
_CLASS = re.compile(r"(?P<negated>not )?(?P<name>[a-z][a-z0-9_+\->]*)")
_OF_OTHER_CASE = re.compile(r"[^:\s]+:[A-Za-z]\w*")


@dataclass(frozen=True)
class OfClass:
    """``"periodic"``, ``"not periodic"``: the name of a flag."""

    name: str
    negated: bool = False


@dataclass(frozen=True)
class Trend:
    """``"increasing"`` or ``"decreasing"`` along the one axis that is left."""

    rises: bool


@dataclass(frozen=True)
class Bounds:
    """What a number may be: from `least` to `greatest`, the two included or not (`strict`)."""

    least: Bound = -math.inf
    greatest: Bound = math.inf
    strict: bool = False


Expected = OfClass | Trend | Bounds


def parse_condition(text: str) -> tuple[Test, ...]:
    """What `text` demands of ``.``, one or two tests; none when it is no condition.

    >>> parse_condition("0.9 <= . < 1.8")
    (('>=', 0.9), ('<', 1.8))
    """
    parts = _CONDITION.fullmatch(text)
    if parts is None:
        return ()
    tests = []
    if parts["left"]:
        # ``a < .`` is ``. > a``
        tests.append((parts["left"].replace("<", ">"), float(parts["low"])))
    if parts["right"]:
        tests.append((parts["right"], float(parts["high"])))
    return tuple(tests)


def parse_class(text: str) -> OfClass:
    """``CLASS`` or ``not CLASS``; ValueError for anything else."""
    parts = _CLASS.fullmatch(text)
    if parts is None:
        raise ValueError(f"{text!r} is no class; there may stand {_FORMS}")
    return OfClass(parts["name"], parts["negated"] is not None)


def parse_expect(said: object) -> Expected:
    """What a claim expects, from what stands in the case file; ValueError says what may stand.

    >>> parse_expect({"value": 3.0, "tolerance": 0.5})
    Bounds(least=2.5, greatest=3.5, strict=False)
    """
    match said:
        case OfClass() | Trend() | Bounds():
            return said
        case "increasing" | "decreasing":
            return Trend(rises=said == "increasing")
        case str():
            return parse_class(said)
        case {"value": value, "tolerance": tolerance, **rest} if not rest:
            return _around(check_number(value), check_number(tolerance))
        case {"less_than": bound, **rest} if not rest:
            return Bounds(greatest=_bound(bound), strict=True)
        case {"greater_than": bound, **rest} if not rest:
            return Bounds(least=_bound(bound), strict=True)
        case {"between": [low, high], **rest} if not rest:
            return _between(check_number(low), check_number(high))
        case {"interval": [low, high], "tolerance": tolerance, **rest}:
            ends = check_number(low), check_number(high), check_number(tolerance)
            raise ValueError(_in_place_of_interval(*ends, rest.get("of")))
    raise ValueError(f"must be {_FORMS}, not {_toml(said)}")


def _around(value: float, tolerance: float) -> Bounds:
    if tolerance < 0:
        raise ValueError(f"the tolerance is negative: {tolerance!r}")
    return Bounds(value - tolerance, value + tolerance)


def _between(low: float, high: float) -> Bounds:
    if low > high:
        raise ValueError(f"between [{low!r}, {high!r}] lies nothing")
    return Bounds(low, high)


def _bound(said: object) -> Bound:
    if isinstance(said, str) and _OF_OTHER_CASE.fullmatch(said):
        return said
    if isinstance(said, str):
        raise ValueError(f'a bound is a number or "CASE:variable", not {describe(said)}')
    return check_number(said)


def check_holds(said: object) -> str | float:
    """How many points must agree: "all", "any" or a share; ValueError for anything else."""
    if said == "all" or said == "any":
        return str(said)
    if isinstance(said, bool) or not isinstance(said, int | float) or not 0 < said <= 1:
        raise ValueError(f'must be "all", "any" or a share in (0, 1], not {describe(said)}')
    return said


def check_counted(text: str) -> None:
    """ValueError unless `text`, what is counted, is a condition or a class."""
    if not _CLASS.fullmatch(text) and not parse_condition(text):
        raise ValueError(f'{text!r} is neither a condition such as ". > 0" nor a class')


# --- what stood in the cases of 0.1.0 -------------------------------------------------------------
def figure_of_before(settings: Mapping[str, Any]) -> dict[str, Any]:
    """The settings of a figure that a dataset of 0.1.0 asks for: its ``share`` as a `take`."""
    rest = {key: value for key, value in settings.items() if key != "share"}
    return rest | ({"take": _taken_of_share(settings["share"])} if "share" in settings else {})


def text_of_before(text: str) -> str:
    """The text of a case of 0.1.0 with its figures in today's words, and without its claims."""
    try:
        document = parse_toml(text)
    except ValueError:
        return text  # no TOML at all: told where it is read
    figures, rest = document.get("figure"), {k: v for k, v in document.items() if k != "claim"}
    if isinstance(figures, list) and all(isinstance(figure, dict) for figure in figures):
        rest["figure"] = [figure_of_before(figure) for figure in figures]
    return toml_text(rest)


def in_place_of_share(share: object) -> str:
    """What to write for a ``share``."""
    return f"share has become a take: write take = {_toml(_taken_of_share(share))}"


def in_place_of_reduce(reduce: object) -> str:
    """What to write for a ``reduce``."""
    said = dict(reduce) if isinstance(reduce, Mapping) else {}
    what = said.pop("take", "")
    take = {"what": "spread" if what == "range" else what, **said}
    return f"reduce has become a take: write take = {_toml(take)}"


def _taken_of_share(share: object) -> dict[str, Any]:
    return {"what": "share", **(share if isinstance(share, Mapping) else {})}


def _in_place_of_interval(low: float, high: float, tolerance: float, of: object) -> str:
    """What to write for an interval: bounds, or the first or the last place along the axis."""
    if of is None:
        wide = [round(low - tolerance, 12), round(high + tolerance, 12)]
        return f"interval has become between: write expect = {{ between = {_toml(wide)} }}"
    written = (
        f"take = {{ what = {_toml(what)}, of = {_toml(of)}, over = AXIS }} and "
        f"expect = {{ value = {_toml(value)}, tolerance = {_toml(tolerance)} }}"
        for what, value in (("first", low), ("last", high))
    )
    return f"interval has become a take: write {', or '.join(written)}"


def _toml(value: object) -> str:
    return toml_value(value, "claim")
