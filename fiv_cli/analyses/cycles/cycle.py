"""Periodic orbits, stable or not, and where they end along a parameter.

A first guess comes from the motion that the start leads to: two section points that nearly agree.
Newton's method makes a cycle of it (``periodic.py``). With `parameter` and `bracket` the branch
of that cycle is followed both ways (``branch.py``): what "exists" means, apart from what a start
reaches.
"""

from __future__ import annotations

from fiv_cli.analyses.base import Analysis, Later, Section, Varied
from fiv_cli.analyses.settings import (
    Bracket,
    Integer,
    Number,
    ParameterName,
    SectionSetting,
    StateName,
)
from fiv_cli.analyses.variables import (
    INITIAL_STATE,
    MULTIPLICITY,
    MULTIPLIERS,
    PERIOD_RATIO,
    Role,
    Subject,
    Variable,
    classes,
    count,
    detail,
    extremes,
    own_section,
    section_value,
    trust,
)

_KINDS = (
    "fold, flip (a multiplier passes -1), torus (a pair passes 1 in modulus), branching (a "
    "multiplier passes 1), grazing (an event enters or leaves), contact lost, equilibrium "
    "(the cycle shrinks to rest), bracket (its edge), budget (of points), mu_k above mu_s, "
    "closed (round to its first cycle), other (no cycle was found beyond, and none of these)"
)
_OFF = "how far it may be off"
_CYCLES_AGAIN = (
    "what it was bisected to, and what cycles of ten times the error of integration move it by; "
    "missing where these do not show it"
)


def variables(subject: Subject) -> list[Variable]:
    """What is told of a cycle and, along a parameter, of its branch."""
    observed, _ = subject.observed
    return [
        Variable("cycle_period", "s", "period of the cycle", symbol="T", headline=2),
        classes("stable", "whether the cycle is stable", headline=1),
        MULTIPLICITY,
        PERIOD_RATIO,
        Variable(
            "cycle_section",
            "1",
            f"point of the cycle at the section, of several that with the least {observed}",
            "state",
            comment="each state in its own unit (state_units)",
            velocities=True,
        ),
        section_value(subject),
        *own_section(subject),
        INITIAL_STATE,
        *MULTIPLIERS,
        *extremes(subject.states, rms=False),
        trust("residual", "miss after a period, over the extent of the cycle"),
        count("n_events", "events per period", role=Role.WORK),
        *(_branch(subject) if subject.settings.get("parameter") else ()),
    ]


def _branch(subject: Subject) -> list[Variable]:
    """The branch of a cycle along a parameter, and where it changes or ends."""
    varied, (observed, unit) = subject.varied, subject.observed
    name, branch = varied.name, "branch"
    return [
        Variable("branch_value", varied.unit, f"{name} along the branch", ragged=branch),
        Variable("branch_period", "s", "period along the branch", ragged=branch),
        Variable("branch_min", unit, f"least {observed} of the cycle", ragged=branch),
        Variable("branch_max", unit, f"greatest {observed} of the cycle", ragged=branch),
        count("branch_multiplicity", "section points per period along the branch", ragged=branch),
        Variable(
            "branch_section", unit, f"{observed} at the section along the branch",
            ragged="branch_section", comment="branch_multiplicity of each cycle, the least first",
        ),
        Variable(
            "branch_multiplier", "1", "modulus of the largest nontrivial multiplier", ragged=branch
        ),
        detail("branch_stable", "stability", of="stable", ragged=branch),
        *_changes(varied),
        *_end("lowest", varied),
        *_end("highest", varied),
        *_stable_end("lowest", varied),
        *_stable_end("highest", varied),
    ]  # fmt: skip


def _changes(varied: Varied) -> list[Variable]:
    """Where a branch changes or ends, in its order."""
    name, end = varied.name, "cycle_end"
    return [
        Variable(
            "cycle_end", varied.unit, f"{name} where the branch changes or ends", ragged=end,
            comment="in the order of the branch, within cycle_end_error",
        ),
        Variable(
            "cycle_end_width", varied.unit, "half the bracket that it was bisected to", ragged=end,
            comment="no bound of its error",
        ),
        Variable("cycle_end_error", varied.unit, _OFF, ragged=end, comment=_CYCLES_AGAIN),
        classes("cycle_end_kind", "what happens", of="cycle_end", ragged=end, comment=_KINDS),
        detail(
            "cycle_end_event", "what enters or leaves at a grazing", of="grazed", ragged=end,
            comment="order: events change their places",
        ),
        count("cycle_end_contact", "whose event that is; 0: none, or several contacts", ragged=end),
        count("cycle_end_direction", f"1: {name} rising, -1: falling", ragged=end),
        detail("cycle_end_goes_on", "whether it was followed beyond", of="goes_on", ragged=end),
    ]  # fmt: skip


def _end(side: str, varied: Varied) -> list[Variable]:
    """One end of the range of a parameter in which a branch lies."""
    name, unit = f"cycle_{side}", varied.unit
    return [
        Variable(
            name, unit, f"{side} {varied.name} of the branch", headline=int(side == "highest"),
            comment="of this branch; beyond it there may be another",
        ),
        Variable(f"{name}_width", unit, "half the bracket that it was bisected to"),
        Variable(f"{name}_error", unit, _OFF, comment=_CYCLES_AGAIN),
        classes(f"{name}_kind", "what is there", of="cycle_end"),
    ]  # fmt: skip


def _stable_end(side: str, varied: Varied) -> list[Variable]:
    """One end of the range in which the cycle stays stable, from where it was found."""
    name, unit = f"stable_{side}", varied.unit
    comment = "followed from where it was found, to the first change; it may be stable again beyond"
    way = "up" if side == "highest" else "down"
    meaning = f"{varied.name} {way} to which the cycle stays stable"
    return [
        Variable(name, unit, meaning, comment=comment),
        Variable(f"{name}_error", unit, _OFF, comment=_CYCLES_AGAIN),
        classes(f"{name}_kind", "what ends it there", of="cycle_end"),
    ]


ANALYSIS = Analysis(
    "cycle",
    "periodic orbits and where they end",
    (
        SectionSetting(
            "section",
            "Poincaré section whose returns give the first guess, and where the cycle is reported",
            default=Section("own"),
        ),
        StateName(
            "observe", "state whose value at the section is kept; the first state when left out"
        ),
        Number(
            "t_max",
            "time allowed for reaching a first guess; a few periods of one that repels, beside "
            "which it starts",
            default=100.0,
            unit="s",
            above=0.0,
        ),
        Number(
            "transient", "time before a first guess is looked for", default=0.0, unit="s", least=0.0
        ),
        Integer("multiplicity", "section points per period; found from the motion when left out"),
        ParameterName(
            "parameter",
            "along which the branch is followed: no axis of the grid",
            partner="bracket",
        ),
        Bracket(
            "bracket",
            "how far the branch is followed; a change and back within a twentieth may be missed",
            partner="parameter",
        ),
        Number(
            "width",
            "width to which its ends are bracketed, as a share of the bracket",
            default=1e-6,
            above=0.0,
        ),
    ),
    variables,
    Later("fiv_cli.analyses.cycles.find_cycle:find_cycle"),
    answer=(
        "periodic orbits, stable or not, by Newton on the return map; their branch along a "
        "parameter and where it ends: fold, flip, grazing"
    ),
)
