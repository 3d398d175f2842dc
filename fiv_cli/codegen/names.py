"""Names that equations and generated code must agree on."""

from __future__ import annotations


def rate_of(parameter: str) -> str:
    """Name of the rate of a parameter that varies in time."""
    return f"{parameter}.rate"
