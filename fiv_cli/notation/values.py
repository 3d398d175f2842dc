"""Values of a case file: numbers and quantities as TOML has them, and their JSON schemas."""

from __future__ import annotations

from math import isfinite
from typing import Any

QUANTITY_SCHEMA = {
    "anyOf": [{"type": "number"}, {"type": "string"}],
    "description": 'a number in SI, or a string with its unit: "20 rpm", "15 deg", "5 mm"',
}

WANTED_SCHEMA = {"anyOf": [QUANTITY_SCHEMA, {"type": "array", "items": QUANTITY_SCHEMA}]}

INTERVAL_SCHEMA = {"type": "array", "items": QUANTITY_SCHEMA, "minItems": 2, "maxItems": 2}


def describe(value: object) -> str:
    """A value and its type in TOML's words, for messages."""
    if isinstance(value, bool):
        return f"{str(value).lower()} (a boolean)"
    if isinstance(value, str):
        return f"{value!r} (a string)"
    if isinstance(value, dict):
        return "a table"
    if isinstance(value, list):
        return "a list"
    return repr(value)


def check_quantity(value: object) -> float | str:
    """A finite number or a string; ValueError for anything else."""
    if isinstance(value, bool) or not isinstance(value, int | float | str):
        several = " (several values are an axis, under [grid])" if isinstance(value, list) else ""
        message = f"must be a number, or a string with a unit, not {describe(value)}{several}"
        raise ValueError(message)
    return value if isinstance(value, str) else check_finite(value)


def check_wanted(value: object) -> Any:
    """A quantity, a text, or a list of these; ValueError for anything else."""
    if isinstance(value, list) and value:
        return [check_quantity(one) for one in value]
    return check_quantity(value)


def check_number(value: object) -> float:
    """A finite number; ValueError for anything else."""
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise ValueError(f"must be a number, not {describe(value)}")
    return check_finite(value)


def check_finite(value: float) -> float:
    """`value` unless it is NaN, infinite or beyond a double."""
    try:
        finite = isfinite(value)
    except OverflowError:
        finite = False
    if not finite:
        raise ValueError(f"must be a finite number, not {describe(value)}")
    return value


def check_interval(value: object) -> tuple[Any, Any]:
    """Two quantities; ValueError for anything else."""
    if not isinstance(value, list) or len(value) != 2:
        raise ValueError(f"must be a list of two numbers [low, high], not {describe(value)}")
    return check_quantity(value[0]), check_quantity(value[1])
