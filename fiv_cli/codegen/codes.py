"""Codes that equations, generated code and driver must agree on."""

from __future__ import annotations

from collections.abc import Sequence

# Kinds of contact state.
SLIP, STICK, SEPARATION = 0, 1, 2

# Contact states, with the sense of slip, in ledgers and samples.
CODE_SLIP_PLUS, CODE_SLIP_MINUS, CODE_STICK, CODE_SEPARATION = 0, 1, 2, 3
CODE_NAMES = ("slip+", "slip-", "stick", "separation")
CODE_PIECE = len(CODE_NAMES)  # of a law's first piece; the others follow

# Kinds of switching function; each is positive inside the contact state that it guards.
VELOCITY = 0  # sign * v_rel of a slipping contact
CAPACITY_UP = 1  # static capacity - F_T of a sticking contact
CAPACITY_DOWN = 2  # static capacity + F_T of a sticking contact
NORMAL = 3  # F_N of a closed contact
GAP = 4  # gap of a separated contact
JAMMING = 5  # determinant of the algebraic forces where a contact is rigid
PARTING = 6  # of contacts that stick jointly: negative unless their drives go on alike
SINGULAR = 7  # determinant of the conditions of stick, in forces or in velocities
PIECE = 8  # what the piece is left by that an element of the law is in

# What `field` functions report per contact, and of the energy balance: where each stands there.
CONTACT_OUTPUTS = ("F_N", "F_T", "slip_velocity")
ENERGY_OUTPUTS = (
    "kinetic_energy",
    "potential_energy",
    "other_power",  # damping, excitation, normal forces: what changes T + U without friction
    "friction_power",  # of the friction forces on the system
    "drive_power",  # put in by the belt or the disc through the contacts
)
PER_CONTACT = len(CONTACT_OUTPUTS)
SLIP_VELOCITY = CONTACT_OUTPUTS.index("slip_velocity")
KINETIC, POTENTIAL, OTHER_POWER, FRICTION_POWER, DRIVE_POWER = range(len(ENERGY_OUTPUTS))

OWN_POWERS = DRIVE_POWER + 1 - OTHER_POWER  # of every model
LANES = 4  # tangent vectors that generated code moves at once
NODES = 8  # ... and times of a step that it tells powers at


def index_of(kinds: Sequence[int]) -> int:
    """Index of a combination of contact kinds: base 3, contact 0 first."""
    return sum(kind * 3**place for place, kind in enumerate(kinds))
