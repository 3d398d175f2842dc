"""No friction: the law of a model without a frictional contact."""

from __future__ import annotations

from fiv_cli.friction.base import Law

LAW = Law(
    name="none",
    title="no friction",
    reference="",
    numerics_version=1,
    parameters=(),
    force=lambda slip, p: 0 * slip.N,
    capacity=None,
)
