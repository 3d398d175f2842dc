"""The grammar of figures and claims: conditions on ``.``, what is taken and what is expected.

`fiv kinds claim` is the same for people.
"""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from dataclasses import dataclass, field, fields
from typing import Any

from fiv_cli.case.toml import parse_toml, toml_text, toml_value
from fiv_cli.notation.names import listed
from fiv_cli.notation.units import in_si
from fiv_cli.notation.values import check_number, check_wanted, describe

Test = tuple[str, float]
"""A sign of comparison and a bound: what ``.`` stands to the left of."""

SAME = 1e-9
"""Two doubles nearest to the same decimal differ by less."""

EXPECT_SCHEMA = {"anyOf": [{"type": "string"}, {"type": "object"}]}
HOLDS_SCHEMA = {"anyOf": [{"enum": ["all", "any"]}, {"type": "number"}]}

_FORMS = (
    'a class, "not CLASS", "increasing", "decreasing", { value = V, tolerance = T }, '
    "{ less_than = V }, { greater_than = V } or { between = [LOW, HIGH] }"
)
_REFERS = "{ variable, analysis, case, at, take, times }"
_AROUND = '{ value = V, tolerance = T }, T a number or a share such as "5 %"'
_NUMBER = r"[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?"
_CONDITION = re.compile(
    rf"\s*(?:(?P<low>{_NUMBER})\s*(?P<left><=?)\s*)?\.\s*"
    rf"(?:(?P<right><=?|>=?|[!=]=)\s*(?P<high>{_NUMBER})\s*)?"
)
_CLASS = re.compile(r"(?P<negated>not )?(?P<name>[a-z][a-z0-9_+\->]*)")
_NAME = r"(?:(?P<case>[^:\s*]+):)?(?P<variable>[A-Za-z]\w*)"
_SCALED = re.compile(rf"\s*(?P<times>{_NUMBER})\s*\*\s*{_NAME}\s*")
_SHARE = re.compile(rf"\s*(?P<percent>{_NUMBER})\s*%\s*")


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
class Reference:
    """What is compared with: a variable elsewhere, in this case or in another, at the same points.

    Attributes
    ----------
    variable : empty: that of the claim
    case : another case beside this one, by its name; empty: this one
    analysis : the one that is meant; empty: the first that has the variable
    at : where it is looked up, besides what the claim says of where
    take : the one number that is taken of it; None: that of the claim, of the same variable
    times : what it is multiplied by
    """

    variable: str = ""
    case: str = ""
    analysis: str = ""
    at: Mapping[str, Any] = field(default_factory=dict)
    take: Mapping[str, Any] | None = None
    times: float = 1.0


Bound = float | Reference


@dataclass(frozen=True)
class Bounds:
    """What a number may be: from `least` to `greatest`, the two included or not (`strict`).

    By `margin`, and by a `share` of them, it may lie outside of bounds that refer to a variable.
    """

    least: Bound = -math.inf
    greatest: Bound = math.inf
    strict: bool = False
    margin: float = 0.0
    share: float = 0.0

    @property
    def references(self) -> dict[str, Reference]:
        """Key of the table ``expect`` -> what it refers to."""
        keys = ("greater_than", "less_than") if self.strict else ("value", "value")
        bounds = zip(keys, (self.least, self.greatest), strict=True)
        return {key: bound for key, bound in bounds if isinstance(bound, Reference)}


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
        case str() if _alone(said):
            raise ValueError(
                f"{said!r} is no class; a value has a tolerance: {_AROUND}; {_alone(said)}"
            )
        case str():
            return parse_class(said)
        case {"value": value, "tolerance": tolerance, **rest} if not rest:
            return _around(_bound(value), *_tolerance(tolerance))
        case {"value": value, **rest} if not rest:
            raise ValueError(f"{_fault(value)}a value has a tolerance: {_AROUND}")
        case {"less_than": bound, **rest} if not rest:
            return Bounds(greatest=_bound(bound), strict=True)
        case {"greater_than": bound, **rest} if not rest:
            return Bounds(least=_bound(bound), strict=True)
        case {"between": [low, high], **rest} if not rest:
            return _between(_number(low), _number(high))
        case {"interval": [low, high], "tolerance": tolerance, **rest}:
            ends = check_number(low), check_number(high), check_number(tolerance)
            raise ValueError(_in_place_of_interval(*ends, rest.get("of")))
    raise ValueError(f"must be {_FORMS}, not {_toml(said)}")


def _around(value: Bound, margin: float, share: float) -> Bounds:
    if isinstance(value, Reference):
        return Bounds(value, value, margin=margin, share=share)
    tolerance = margin + share * abs(value)
    return Bounds(value - tolerance, value + tolerance)


def _tolerance(said: object) -> tuple[float, float]:
    """A number, or a share ("5 %") of what is compared with."""
    percent = _SHARE.fullmatch(said) if isinstance(said, str) else None
    if isinstance(said, str) and not percent and not _alone(said):
        raise ValueError(
            f'the tolerance {said!r} is neither a number nor a share such as "5 %"; of a value '
            "that has an error (`fiv show` tells it) it must be greater than that"
        )
    tolerance = float(percent["percent"]) / 100.0 if percent else _number(said)
    if tolerance < 0:
        raise ValueError(f"the tolerance is negative: {said!r}")
    return (0.0, tolerance) if percent else (tolerance, 0.0)


def _between(low: float, high: float) -> Bounds:
    if low > high:
        raise ValueError(f"between [{low!r}, {high!r}] lies nothing")
    return Bounds(low, high)


def _bound(said: object) -> Bound:
    if isinstance(said, dict):
        return _reference(said)
    named = re.fullmatch(_NAME, said) if isinstance(said, str) else None
    return Reference(named["variable"], named["case"] or "") if named else _number(said)


def _reference(said: Mapping[str, Any]) -> Reference:
    unknown = said.keys() - {one.name for one in fields(Reference)}
    if unknown:
        raise ValueError(f"what is compared with has no {listed(sorted(unknown))}: {_REFERS}")
    for key in said.keys() & {"variable", "case", "analysis"}:
        if not isinstance(said[key], str):
            raise ValueError(f"{key} must be a name, not {describe(said[key])}")
    for key in said.keys() & {"at", "take"}:
        if not isinstance(said[key], dict):
            raise ValueError(f"{key} must be a table, not {describe(said[key])}")
    if _number(said.get("times", 1.0)) <= 0.0:
        raise ValueError(f"times must be above 0, not {said['times']!r}")
    for value in said.get("at", {}).values():
        check_wanted(value)
    return Reference(**said)


def _number(said: object) -> float:
    """A number; ValueError says what to write instead of a text."""
    if not isinstance(said, str):
        return check_number(said)
    scaled = _SCALED.fullmatch(said)
    if scaled:
        named = {"variable": scaled["variable"], "times": float(scaled["times"])}
        named |= {"case": scaled["case"]} if scaled["case"] else {}
        raise ValueError(f"{said!r} is no number: write {_toml(named)}")
    other = f'what is compared with is "VARIABLE", "CASE:VARIABLE" or {_REFERS}'
    raise ValueError(f"{said!r} is no number; {_alone(said) or other}")


def _alone(said: str) -> str:
    """How to write a number that stands with its unit; nothing of another text."""
    try:
        value = in_si(said)
    except ValueError:
        return ""
    unit = "write it alone, in the unit of the variable (`fiv variables CASE` tells it)"
    return f"{unit}: {said} is {value:.12g} in SI"


def _fault(said: object) -> str:
    try:
        _bound(said)
    except ValueError as error:
        return f"{error}; and "
    return ""


def check_holds(said: object) -> str | float:
    """How many points must agree: "all", "any" or a share; ValueError for anything else."""
    if said == "all" or said == "any":
        return str(said)
    if isinstance(said, bool) or not isinstance(said, int | float) or not 0 < said <= 1:
        raise ValueError(f'must be "all", "any" or a share in (0, 1], not {describe(said)}')
    return said


def check_counted(said: object) -> None:
    """ValueError unless `said`, what is counted, is a condition, a class, or several classes."""
    if isinstance(said, list) and said and all(isinstance(one, str) for one in said):
        for one in said:
            if parse_class(one).negated:
                raise ValueError(f"{one!r} in a list of classes; name those that count")
    elif not isinstance(said, str) or not (_CLASS.fullmatch(said) or parse_condition(said)):
        raise ValueError(
            f'{describe(said)} is neither a condition such as ". > 0" nor a class, or a list of '
            "classes"
        )


# --- what stood in the cases of 0.1.0 -------------------------------------------------------------
def figure_of_before(settings: Mapping[str, Any]) -> dict[str, Any]:
    """The settings of a figure that a dataset of 0.1.0 asks for: its ``share`` as a `take`."""
    rest = {key: value for key, value in settings.items() if key != "share"}
    return rest | ({"take": _taken_of_share(settings["share"])} if "share" in settings else {})


def text_of_before(text: str) -> str:
    """The text of a case of 0.1.0 with its figures in today's words, and without its claims.

    And without what had no effect, as keys of figures of other kinds.
    """
    from fiv_cli.case.kinds import keys_for
    from fiv_cli.case.structure import FigureTable

    try:
        document = parse_toml(text)
    except ValueError:
        return text  # no TOML at all: told where it is read
    figures, rest = document.get("figure"), {k: v for k, v in document.items() if k != "claim"}
    if isinstance(figures, list) and all(isinstance(figure, dict) for figure in figures):
        todays = [figure_of_before(figure) for figure in figures]
        known = [keys_for(FigureTable, figure) for figure in todays]
        rest["figure"] = [
            {key: value for key, value in figure.items() if key in keys}
            for figure, keys in zip(todays, known, strict=True)
        ]
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
