"""What a friction law makes of a slip that is stated: its curve and its loops (``stated_slip.py``).

    slip(t) = -A cos(omega t) + v_0 t,    under a constant normal force

The mechanics of the model take no part. Force against slip velocity is the law's curve, force
against slip the loop of a law with pre-sliding; about a mean velocity the curve of a law that lags
opens into a loop, too.
"""

from __future__ import annotations

from fiv_cli.analyses.base import Analysis, Later
from fiv_cli.analyses.motion.history import EVENTS
from fiv_cli.analyses.settings import Integer, Number
from fiv_cli.analyses.variables import Role, Subject, Variable, axis, count, detail

OF_RECORDED = (
    axis("time", "s", "time", symbol="t"),
    Variable("slip", "m", "slip", "time", symbol="s"),
    Variable("slip_dot", "m s-1", "slip velocity", "time", symbol=r"v_\mathrm{rel}"),
    Variable("F_T", "N", "friction force", "time", symbol="F_T"),
    detail("contact_state", "state of contact", "time"),
    count("n_steps", "integration steps", role=Role.WORK),
)
"""What is kept of the motion that is recorded, besides its events and the law's states."""


def variables(subject: Subject) -> list[Variable]:
    """What is told of each instant, and of the last period."""
    return [
        *OF_RECORDED,
        *(Variable(s.name, s.unit, s.meaning, "time", symbol=s.symbol) for s in subject.internal),
        Variable("static_capacity", "N", "greatest force in stick", comment="NaN: it cannot stick"),
        Variable("loop_work", "J", "work of friction over the last period"),
        Variable("greatest_force", "N", "greatest friction force of the samples"),
        *EVENTS,
    ]


ANALYSIS = Analysis(
    "characteristic",
    "the force of the friction law under a stated slip",
    (
        Number("amplitude", "A, of the slip", unit="m", above=0.0, required=True),
        Number("omega", "of the slip", default=1.0, unit="rad s-1", above=0.0),
        Number("drift", "v_0, the mean slip velocity", default=0.0, unit="m s-1"),
        Number("load", "the normal force", default=1.0, unit="N", above=0.0),
        Integer("periods", "how many of the slip", default=2, least=1),
        Integer("samples", "in a period", default=1000, least=16),
    ),
    variables,
    Later("fiv_cli.analyses.motion.stated_slip:characteristic"),
    uses_starts=False,
    generated=False,
    single=True,
    figure="phase",
    answer="force, slip, slip velocity and the law's own states over time; the work of a loop",
)
