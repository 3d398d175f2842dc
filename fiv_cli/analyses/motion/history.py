"""The motion in time, with its event ledger and energy balance (recorded by ``recording.py``)."""

from __future__ import annotations

from fiv_cli.analyses.base import Analysis, Later
from fiv_cli.analyses.settings import DiscPoints, Number
from fiv_cli.analyses.variables import (
    INITIAL_STATE,
    OF_SOLVER,
    Subject,
    Variable,
    axis,
    count,
    detail,
    impacts,
    motions,
    trust,
)
from fiv_cli.friction.base import STORED

EVENTS = (
    Variable("event_time", "s", "instant of the event", ragged="event"),
    detail("event_from", "contact before", of="contact_event", ragged="event"),
    detail("event_to", "contact after", of="contact_event", ragged="event"),
    count("event_contact", "contact, counted from 1", ragged="event"),
    trust("event_residual", "switching function left at the event", ragged="event"),
)

_SURFACE = (
    Variable("w", "m", "transverse displacement of the disc", "point time", symbol="w"),
    axis("point_radius", "m", "radius of the point", "point", symbol="r"),
    axis("point_angle", "rad", "angle of the point", "point", symbol=r"\theta"),
)
"""The displacement of a disc at points that are fixed in space."""

_FRICTION_LOSS = Variable(
    "friction_loss",
    "J",
    "energy that friction has taken and not stored",
    comment="drive_work - friction_work less what stored_energy has grown by, of all contacts; "
    "where the normal force varies, what is stored varies with it, at no one's expense",
)


def variables(subject: Subject) -> list[Variable]:
    """What a motion holds at its samples, of its events, and of its energy."""
    at_contacts = f"{subject.contact} time"
    return [
        axis("time", "s", "time", symbol="t"),
        *(Variable(n, u, m, "time", symbol=s) for n, u, s, m in motions(subject.states)),
        *(
            Variable(s.name, s.unit, s.meaning, at_contacts, symbol=s.symbol)
            for s in subject.internal
        ),
        Variable("F_T", "N", "tangential contact force", at_contacts, symbol="F_T"),
        Variable("F_N", "N", "normal contact force", at_contacts, symbol="F_N"),
        detail("contact_state", "state of contact", at_contacts),
        Variable("kinetic_energy", "J", "kinetic energy", "time"),
        Variable("potential_energy", "J", "potential energy", "time"),
        Variable("friction_power", "W", "power of friction on the model", "time"),
        Variable("drive_power", "W", "power of the drive", "time"),
        Variable("other_power", "W", "power of all other forces", "time"),
        Variable("friction_work", "J", "work of friction on the model"),
        Variable("drive_work", "J", "work of the drive"),
        Variable("other_work", "J", "work of all other forces"),
        *(Variable(f"{n}_work", "J", f"work of {words}") for n, words in subject.powers.items()),
        Variable("impact_loss", "J", "energy lost in impacts"),
        *impacts(subject, "up to t_end"),
        *([_FRICTION_LOSS] if STORED in subject.internal else ()),
        *EVENTS,
        INITIAL_STATE,
        *(_SURFACE if subject.settings.get("points") else ()),
        *OF_SOLVER,
    ]


ANALYSIS = Analysis(
    "history",
    "the motion in time",
    (
        Number("t_end", "end of the motion", unit="s", above=0.0, required=True),
        Number(
            "sample", "interval of the samples; t_end / 2000 when left out", unit="s", above=0.0
        ),
        DiscPoints(
            "points",
            "[radius (m), angle (rad)] on the disc, fixed in space, whose displacement w is given",
        ),
    ),
    variables,
    Later("fiv_cli.analyses.motion.recording:record"),
    in_blocks=True,
    varying=True,
    recorded=True,
    spans=("t_end",),
    single=True,
    figure="history",
    answer="states, forces, contact state and energies over time, and every event",
)
