"""The Poincaré section of a motion whose case names none: one that the motion has.

The first contact coming to stick is tried first. A motion that is through without it is watched a
little longer: the first of the other contacts that comes to stick decides or, failing that, one
that is torn loose, or the first stop that is struck; where there is neither, the points at which
the observed coordinate turns back.
"""

from __future__ import annotations

import numpy as np

from fiv_cli.analyses.base import Outcome, Section
from fiv_cli.codegen.codes import (
    CODE_SEPARATION,
    CODE_SLIP_MINUS,
    CODE_SLIP_PLUS,
    CODE_STICK,
    SEPARATION,
    STICK,
)
from fiv_cli.dynamics.motion import Motion
from fiv_cli.dynamics.system import System

OWN = "own"  # kind of the section that a case leaves to the motion
MISSED = ("no_section_points", "slide_not_decided")  # reasons why another section may tell more
SLIPS = (CODE_SLIP_PLUS, CODE_SLIP_MINUS)
ROWS = 4096  # events looked at
PERIODS = 2.0  # watched, so that each event comes at least once
SHARE = 0.25  # of the budget that is watched where no period is known


def first_section(system: System, observed: str) -> Section:
    """The section that is tried first."""
    sticks = any(STICK in state.kinds for state in system.generated.states.values())
    return Section("event") if sticks else turning_points(system, observed)


def is_missed(outcome: Outcome) -> bool:
    """Whether a motion that goes on has not met its section."""
    goes_on = outcome.values["attractor"] == "periodic" or outcome.reason in MISSED
    return goes_on and not _points(outcome)


def long_enough(outcome: Outcome, patience: float, t_max: float) -> float:
    """Time in which a motion meets all that it meets, s: two of its periods, where it has one."""
    period = outcome.values.get("period", np.nan)
    return max(patience, PERIODS * period if np.isfinite(period) else SHARE * t_max)


def tells_more(found: Outcome, section: Section, before: Outcome) -> bool:
    """Whether the run by another section is the better answer.

    Of a slide only what is proved: until it has settled it passes for a torus.
    """
    proved = found.values["attractor"] not in ("undecided", "quasiperiodic", "chaotic")
    slides = before.reason != "no_section_points" and section.event != "impact"
    return proved or not slides


def own_section(motion: Motion, observed: str, span: float) -> Section:
    """A section that `motion` meets in its next `span` seconds.

    Parameters
    ----------
    observed : state that is looked at
    span : long enough for what repeats to come round
    """
    motion.keep_ledger(ROWS)
    motion.run(motion.time + span)
    before, after, contacts = motion.ledger.before, motion.ledger.after, motion.ledger.contacts
    begun = np.isin(before, SLIPS) & (after == CODE_STICK)
    ended = (before == CODE_STICK) & np.isin(after, SLIPS)
    stops = motion.frame.sliding_kinds == SEPARATION
    struck = (before == CODE_SEPARATION) & stops[contacts]
    for event, happens in (("slip->stick", begun), ("stick->slip", ended), ("impact", struck)):
        if happens.any():
            return Section("event", event=event, contact=int(contacts[happens].min()) + 1)
    return turning_points(motion.system, observed)


def turning_points(system: System, observed: str) -> Section:
    """Where the observed coordinate, or that of the observed velocity, is least."""
    name = observed.removesuffix("_dot")
    coordinate = name if name in system.coordinates else system.coordinates[0]
    return Section("zero", state=f"{coordinate}_dot", direction="up")


def recorded(outcome: Outcome, section: Section) -> Outcome:
    """`outcome`, with what section its points lie on."""
    if _points(outcome) and section.kind == "event":
        kind = section.event.replace("->", "_to_")
        outcome.values |= {"section_kind": kind, "section_contact": section.contact}
    elif _points(outcome):
        outcome.values["section_kind"] = "turning_point"
    return outcome


def _points(outcome: Outcome) -> int:
    return len(outcome.ragged.get("section_value", ()))
