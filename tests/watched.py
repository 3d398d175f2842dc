"""Motions watched in every way, and all that they leave."""

from __future__ import annotations

from typing import Any

import numpy as np
from motions import motion
from numpy.typing import NDArray
from small_models import BOUNCER

from fiv_cli.analyses.base import SolverSettings
from fiv_cli.dynamics.motion import Motion, samples_at
from fiv_cli.dynamics.settings import Section

LOOSE = SolverSettings(rtol=1e-6)
STEPWISE = SolverSettings("rk4", 1e-6, 0.05)
SMALL: dict[str, Any] = {
    "belt": ("belt-1dof", {"x": 0.0}, LOOSE, {}, {}, 80.0, "x_dot"),
    "forced belt": (
        "belt-1dof", {"x": 0.0}, LOOSE, {}, {"u0": 0.5, "omega": 1.2}, 50.0, "x_dot",
    ),
    "belt, rk4": ("belt-1dof", {"x": 0.0}, STEPWISE, {}, {}, 20.0, "x_dot"),
    "impacts": (BOUNCER, {"z": 0.2, "x_dot": 0.3}, LOOSE, {}, {"A": 15.0}, 5.0, "z_dot"),
    "separation": (
        BOUNCER, {"z": 0.2, "x_dot": 0.3}, LOOSE, {"contact": "elastic"},
        {"A": 15.0, "k_c": 200.0}, 4.0, "z_dot",
    ),
    "sector": (
        "pin-on-disc", {"phi_dot": 2.0}, LOOSE, {}, {"beta": 2.0, "psi_a": 0.3}, 1.0, "phi_dot",
    ),
}  # fmt: skip
LARGE: dict[str, Any] = {
    "slider with impacts": (
        "belt-5dof", {}, LOOSE, {},
        {"k_nl": 1e4, "F": 200.0, "mu_s": 3.0, "mu_k": 1.4}, 5.0, "x1_dot",
    ),
    "disc": ("disc-nonlinear-contact", {}, LOOSE, {}, {"mu_s": 3.0, "mu_k": 2.2}, 0.05, "phi_dot"),
}  # fmt: skip
CASES = SMALL | LARGE

# What a motion has of its own, in the parts that the digests of test_frozen_bits.py were taken of.
PARTS = {
    "clock": (
        "time", "last_step", "sector_low", "sector_high", "next_phase", "first_step", "filled_for",
        "task",
    ),
    "parameters": ("parameters",),
    "coefficients": ("coefficients",),
    "y": ("y",),
    "measures": (
        "measured_time", "spread", "other_work", "friction_work", "drive_work", "impact_loss",
        "largest_residual",
    ),
    "tolerances": ("rtol", "fixed_step", "bound"),
    "kinds": ("kinds",),
    "strips": ("known_zeros", "zeros_at_upper", "zeros_at_lower", "zeros_on_section"),
    "counters": (
        "n_steps", "n_events", "n_chained", "n_sections", "n_sampled", "n_ledger", "n_grazings",
        "n_impacts",
    ),
    "limits": ("max_steps", "max_events", "max_sections"),
}  # fmt: skip


def watched(name: str) -> tuple[Motion, dict[str, NDArray[Any]]]:
    """A motion of `CASES` in three pieces, watched in every way, and all that it leaves."""
    model, start, solver, options, changes, t_end, state = CASES[name]
    begun = motion(model, "coulomb", start, solver, options, **changes)
    n = len(begun.y)
    begun.start_measuring(np.full(len(begun.system.coordinates), 0.1))
    if solver.method == "taylor":
        begun.carry_tangents(np.eye(n)[:2])
    samples = samples_at(begun.system, np.linspace(0.0, t_end, 30))
    times, states = np.zeros(40), np.zeros((40, n))
    zero = Section("zero", state=state, direction="up")
    for share in (0.1, 0.5, 1.0):
        begun.run(share * t_end, zero, (times, states), samples, measuring=True)
    own = {part: in_words(begun, names) for part, names in PARTS.items()}
    own["measures"] = np.zeros_like(own["measures"])  # lay elsewhere when the digests were taken
    measured = {
        "totals": in_floats(begun, PARTS["measures"]),
        "extremes": np.array([begun.frame.least, begun.frame.greatest, begun.frame.squares]),
        "shares": begun.frame.shares,
        "reference": begun.frame.reference,
    }
    rows = (f"ledger_{name}" for name in begun.ledger._fields)
    ledger = np.column_stack([getattr(begun.frame, name) for name in rows])
    others = {"ledger": ledger, "tangents": begun.tangents, "met": states, "at": times}
    return begun, own | measured | vars(samples) | others


def in_floats(begun: Motion, names: tuple[str, ...]) -> NDArray[np.float64]:
    """Fields of a motion's frame, one after the other."""
    return np.concatenate([np.atleast_1d(getattr(begun.frame, name)) for name in names])


def in_words(begun: Motion, names: tuple[str, ...]) -> NDArray[np.int64]:
    """The same, as the bits that they are."""
    values = [np.atleast_1d(getattr(begun.frame, name)) for name in names]
    return np.concatenate([value.view(np.int64) for value in values])
