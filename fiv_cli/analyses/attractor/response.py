"""The steady state reached from a start: its class, L_s, period, section, exponents.

What is computed, and how a run ends, is told in ``steady_state.py``.
"""

from __future__ import annotations

from fiv_cli.analyses.attractor.grounds import CHAOTIC, REGULAR
from fiv_cli.analyses.base import EACH, Analysis, Later, Section
from fiv_cli.analyses.settings import Choice, Number, SectionSetting, StateName
from fiv_cli.analyses.variables import (
    ATTRACTOR,
    INITIAL_STATE,
    MULTIPLICITY,
    MULTIPLIERS,
    OF_STEADY_STATE,
    PERIOD,
    PERIOD_RATIO,
    Role,
    Subject,
    Variable,
    count,
    extremes,
    impacts,
    own_section,
    section_value,
    share,
)

SETTINGS = (
    SectionSetting(
        "section", "Poincaré section by which the steady state is judged", default=Section("own")
    ),
    StateName("observe", "state whose value at the section is kept; the first state when left out"),
    Number("t_max", "budget of simulated time", default=1000.0, unit="s", above=0.0),
    Number(
        "transient", "time before the steady state is looked for", default=0.0, unit="s", least=0.0
    ),
    Choice(
        "lyapunov",
        "exponents and multipliers: auto computes them where the class needs them and on "
        "periodic motions, never leaves them out, and what is chaotic undecided",
        default="auto",
        choices=("auto", "never"),
    ),
)

SPANS = ("t_max", "transient")

POWERS_TOLD = Choice(
    "powers",
    "mean powers of friction, wear, drive, impacts and each external force; each tells those of "
    "each contact and of dampers too, and works, over a period and between section points",
    default="none",
    choices=("none", "mean", EACH),
    later=True,
)


def variables(subject: Subject) -> list[Variable]:
    """What is told of a steady state."""
    states, contact = subject.states, subject.contact
    return [
        ATTRACTOR,
        INITIAL_STATE,
        Variable(
            "L_s",
            subject.of_states("2"),
            "vibration intensity: mean squared distance from the sliding equilibrium",
            symbol="L_s",
            comment="thesis 6.20, on discs 6.42 (of the slider alone); over one period, or over "
            "L_s_window; 0 at the equilibrium, missing where nothing slides at rest (stuck on a "
            f"drive that stands still){_mixed_squares(subject)}",
            headline=1,
            statistic=True,
            unbounded=True,
        ),
        Variable(
            "L_s_standard_error",
            subject.of_states("2"),
            "standard error of L_s of what has no period",
            role=Role.DETAIL,
            comment="by its scatter over 16 stretches of the window",
        ),
        *_reference(subject),
        Variable(
            "L_s_window", "s", "window of L_s, of extremes and of fractions", role=Role.DETAIL
        ),
        PERIOD,
        MULTIPLICITY,
        PERIOD_RATIO,
        Variable("response_frequency", "Hz", "one over the period"),
        section_value(subject),
        *own_section(subject),
        share("stick_fraction", "share of time in stick", contact),
        share("slip_fraction", "share of time in slip", contact),
        share("separation_fraction", "share of time in separation", contact),
        *extremes(states, rms=True),
        Variable(
            "lyapunov",
            "s-1",
            "largest nontrivial Lyapunov exponent",
            comment="none of a cycle whose multipliers are zero within rounding, as where stick "
            "forgets what was before",
        ),
        Variable(
            "lyapunov_standard_error",
            "s-1",
            "standard error of the exponent of what has no period",
            role=Role.DETAIL,
            comment="by its scatter over 16 stretches of the window",
        ),
        Variable(
            "zero_one",
            "1",
            "K of the 0-1 test of what has no period: near 0 regular, near 1 chaotic",
            role=Role.DETAIL,
            comment="Gottwald and Melbourne 2009; median of as many test frequencies as settle on "
            f"which side of {REGULAR} and {CHAOTIC} it lies",
        ),
        *MULTIPLIERS,
        *impacts(subject, "over a period, or over L_s_window"),
        *_powers(subject),
        *OF_STEADY_STATE,
    ]


POWERS = {
    "friction": "friction on the model",
    "wear": "what friction turns into heat and wear, at all contacts: drive less friction",
    "drive": "the belt or the disc, through the contacts",
    "other": "all else but impacts: damping, external forces, what varies",
    "impact": "impacts, lost",
}
"""Whose mean power -> what it is; friction + other - impact is the growth of energy."""


def _powers(subject: Subject) -> list[Variable]:
    """Mean powers over the window of L_s, and works."""
    asked, every = subject.settings.get("powers"), dict(subject.powers) | POWERS
    if asked not in ("mean", EACH):
        return []
    found = [
        Variable(f"mean_{name}_power", "W", f"mean power of {words}", statistic=True)
        for name, words in every.items()
    ]
    for name, words in every.items() if asked == EACH else ():
        found.append(Variable(f"{name}_work", "J", f"work of {words}, over a period"))
        since = f"work of {words}, since the section point before"
        found.append(Variable(f"section_{name}_work", "J", since, ragged="section"))
    return found


def _mixed_squares(subject: Subject) -> str:
    """What the unit of a sum of squares is where displacements have several."""
    units = " and ".join(subject.units)
    return f"; squares of states in {units} are added as numbers" if subject.mixed else ""


def _reference(subject: Subject) -> list[Variable]:
    """The equilibria that a steady state is measured from, and comes to rest at."""
    return [
        Variable(
            "L_s_reference",
            subject.of_states(),
            "sliding equilibrium that L_s is measured from",
            "state",
            comment=f"displacements only{subject.mixed and f'; {subject.mixed}'}",
            role=Role.DETAIL,
        ),
        count(
            "L_s_reference_index",
            "number of that equilibrium among the solutions of `equilibrium`, from 1",
            comment="the one reached; of a motion that does not rest, the first, from which a "
            "start of kind `equilibrium` is offset too",
            role=Role.DETAIL,
        ),
        count(
            "equilibrium_index",
            "number of the equilibrium reached, among the solutions of `equilibrium`, from 1",
            role=Role.DETAIL,
        ),
    ]


ANALYSIS = Analysis(
    "response",
    "steady-state response",
    (*SETTINGS, POWERS_TOLD),
    variables,
    Later("fiv_cli.analyses.attractor.side_by_side:steady_states"),
    in_blocks=True,
    spans=SPANS,
    figure="bifurcation",
    answer=(
        "class, period, multiplicity, vibration intensity L_s, shares of stick and slip, "
        "extremes, Floquet multipliers or the largest Lyapunov exponent, section points: of "
        "what each start reaches"
    ),
)
