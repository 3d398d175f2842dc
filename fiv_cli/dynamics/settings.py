"""What the integrator and the Poincaré sections are told."""

from __future__ import annotations

from dataclasses import dataclass, replace

from fiv_cli.codegen.setup import DEFAULT_RTOL

LEAST_RTOL = 1e-14  # shorter steps only add rounding
RK4_ORDER = 4


@dataclass(frozen=True)
class Section:
    """A Poincaré section.

    Attributes
    ----------
    kind : "event" (a transition), "zero" (a velocity passes zero, or comes to rest there),
        "phase" (stroboscopic) or "own" (one that the motion has)
    event : "slip->stick", "stick->slip" or "impact" when kind is "event"
    state : velocity state, e.g. ``x1_dot``, when kind is "zero"
    direction : "up", "down" or "both" when kind is "zero"
    phase : phase of the excitation, rad, when kind is "phase"
    contact : contact of the event, 1-based
    """

    kind: str
    event: str = "slip->stick"
    state: str = ""
    direction: str = "both"
    phase: float = 0.0
    contact: int = 1


@dataclass(frozen=True)
class SolverSettings:
    """How motions are integrated.

    Attributes
    ----------
    method : "taylor" or "rk4"
    rtol : relative tolerance of a Taylor step
    step : step of rk4, s (ignored by taylor)
    max_events : events after which a run ends with status "budget"
    max_steps : steps after which a run ends with status "budget"
    """

    method: str = "taylor"
    rtol: float = DEFAULT_RTOL
    step: float = 1e-3
    max_events: int = 1_000_000
    max_steps: int = 50_000_000

    def with_error(self, share: float) -> SolverSettings:
        """The same with an error of integration of about this share of its own."""
        rtol = max(self.rtol * share, LEAST_RTOL)
        return replace(self, rtol=rtol, step=self.step * share ** (1 / RK4_ORDER))
