"""The flag tables of datasets: small integers with names.

To add a reason: append a `Reason` to `REASONS` (never reorder: stored shards hold the numbers).
"""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass
from typing import Any

NOT_COMPUTED = "not_computed"


@dataclass(frozen=True)
class FlagTable:
    """Names of the values of a flag variable.

    Attributes
    ----------
    codes : name -> int8 value, in increasing order of value
    fill : name that stands where nothing was computed
    """

    codes: Mapping[str, int]
    fill: str

    @property
    def names(self) -> dict[int, str]:
        """Value -> name."""
        return {code: name for name, code in self.codes.items()}

    @property
    def fill_code(self) -> int:
        """Value that stands where nothing was computed."""
        return self.codes[self.fill]


@dataclass(frozen=True)
class Reason:
    """Why a point has no answer, or not the one hoped for.

    Attributes
    ----------
    name : key in datasets and in `Outcome.reason`
    advice : one sentence that says what it means and what to do
    retried : True when outer circumstances are to blame: such a point is run again on resume
    """

    name: str
    advice: str
    retried: bool = False


LONGER = "raise t_max, a hundredfold say: what settles ends before"

REASONS: tuple[Reason, ...] = (
    Reason("none", "nothing to report"),
    Reason(
        "internal_error",
        "the program failed on this point; run.log holds the traceback, please report it",
        retried=True,
    ),
    Reason(
        "worker_died",
        "the process that computed this point died twice (memory?); run again with --workers 1",
        retried=True,
    ),
    Reason(
        "wall_clock",
        "the point took longer than --time-limit allows; run again with a larger limit",
        retried=True,
    ),
    Reason("no_equilibrium", "no sliding equilibrium exists here; start from a state instead"),
    Reason(
        "singular_equilibrium",
        "the stiffness is singular at the equilibrium: a fold, or a disc at a critical speed "
        "omega_kl / l; move the parameter off it",
    ),
    Reason(
        "mu_k_above_mu_s",
        "kinetic friction above static friction: raise mu_s or shorten the axis of mu_k; or let "
        'mu_s follow: mu_s = "mu_k" under [friction]',
    ),
    Reason("too_many_events", "raise solver.max_events, or lower t_max if the motion chatters"),
    Reason("too_many_steps", "raise solver.max_steps, or loosen solver.rtol (of rk4: solver.step)"),
    Reason("time_budget", f"the motion had not settled at t_max: {LONGER}"),
    Reason(
        "diverged",
        "the motion grows without bound: an answer, not a failure; where the contact is bilateral "
        "only separation or damping would end it",
    ),
    Reason(
        "contact_lost",
        "the normal force reached zero, where this model ends",
    ),
    Reason(
        "no_consistent_state",
        "no contact state agrees with the forces: where the load depends on friction a Painlevé "
        "paradox (lower mu or move the start); friction that turns faster than a step resolves "
        "(lower solver.rtol); or a law that is no number at this speed, at these parameters "
        "(look at it with `fiv plot --law`)",
    ),
    Reason(
        "neutral_oscillation",
        "an undamped oscillation keeps the amplitude of its start for ever, whatever that is, and "
        "so has no attractor: add damping, or take what is measured from this start",
    ),
    Reason(
        "class_changed",
        "the branch that was followed ended before this point; the motion is carried on whatever "
        'its class with on_loss = "go-on", and begun anew with "restart"',
    ),
    Reason(
        "jammed",
        "friction is too high for the slope of the contact: the algebraic normal force has no "
        "finite value, or would pull; lower mu, or move the start",
    ),
    Reason("not_converged", "the iteration did not settle: try another start or a smaller step"),
    Reason(
        "tests_disagree",
        "section points and Lyapunov exponent say different things of the motion, as they do where "
        "chaos is weak or comes and goes: a hundredfold t_max decides some, a few another section: "
        'the other event ("stick->slip" for "slip->stick", or the contrary), { zero = "x_dot" } '
        "for a displacement x, or of another contact; the rest stays undecided, and its numbers, "
        "such as L_s, stand",
    ),
    Reason(
        "chattering",
        "more than 50 transitions at one instant: no contact state lasts; move the start, or what "
        "stick bears",
    ),
    Reason("stuck", "what sticks holds all and nothing moves: an equilibrium, but not of sliding"),
    Reason(
        "no_drive",
        "the drive of a contact stands still, so not all contacts slide at rest: give each a "
        "speed, or leave these points to a case whose starts are states",
    ),
    Reason(
        "contact_would_pull",
        "every sliding equilibrium needs a negative normal force, or lies beyond a stop: raise the "
        "preload, lower mu_k, or move the stop",
    ),
    Reason(
        "filled_in",
        "only the class is given, that of the points around it (sweep.refine); the last line of "
        "`fiv show` runs these too",
    ),
    Reason(
        "averaging_invalid",
        "the excitation is below 5 times the highest natural frequency, so averaging over it is in "
        "doubt: raise its frequency (R), or compare with `response` of the excited system",
    ),
    Reason(
        "no_crossing",
        "nothing changes inside the bracket (`boundary`: scan_class says what holds; `critical`: "
        "unstable throughout where growth_at_low is above 0, stable where it is below): widen it, "
        "or look closer (`critical`: at `eigenvalues` along it; `boundary`: at more points, scan)",
    ),
    Reason(
        "no_equilibrium_in_part",
        "part of the bracket has no sliding equilibrium (its end is a crossing of kind `end`)",
    ),
    Reason(
        "no_return",
        "the motion does not come back to the section: mostly it rests or sticks for ever (ask "
        "`response`; start where it vibrates, or change the parameters); else name a section that "
        "it has, or raise t_max",
    ),
    Reason(
        "no_cycle",
        "Newton's method found no periodic motion near what the start leads to, at the case's own "
        "value of the parameter that is followed: where it comes to rest move that value, or the "
        "start; else start nearer to it, or give its multiplicity. One that repels, on the border "
        "between two basins, takes both a start beside it and a t_max of a few of its periods, "
        "before the motion is away; with a `parameter` the branch of the stable cycle beside it "
        "often leads round to it",
    ),
    Reason(
        "outside_bracket",
        "the branch begins at the case's own value of the parameter: move it into the bracket",
    ),
    Reason(
        "undecided_in_part",
        "runs in part of the bracket have no class, or not the number that is asked for (where "
        "contact is lost, say), so what changes there is not known: raise t_max, ask for a class, "
        "look at `scan_class` and shorten the bracket, or let what is undecided count as another "
        'class than the one asked for: of = { ..., undecided = "counts" }',
    ),
    Reason(
        "branch_ended",
        "what was followed left nothing to go on from (contact lost, diverged, failed): the rest "
        "of the bracket was not looked at",
    ),
    Reason(
        "no_section_points",
        "the motion never met the section: where the case names none, raise t_max; where it does, "
        "leave it out, and the motion chooses one that it has; or name another, such as section = "
        '{ zero = "x_dot" } for a displacement x, or of an event, which is that of contact 1 '
        "unless the section says contact = 2",
    ),
    Reason(
        "window_too_long",
        "a window of the spectrogram is longer than the motion: raise t_end, or shorten window "
        "(or raise resolution)",
    ),
    Reason(
        "node_at_r0",
        "a mode has a node at r0 (the message names it): nothing that acts there moves it, and its "
        "shape has no scale; move r0, or leave the mode out",
    ),
    Reason("no_plate", "the radii make no disc with the slider on it: a < b and a <= r0 <= b"),
    Reason(
        "slide_not_decided",
        "the motion slides, but its time was up before its level fell as that of the linearised "
        "system does (near a border, or growing; or it slips back and forth without ever meeting "
        "the section): raise t_max, a hundredfold say, or leave out a section that the case names; "
        'of what slides for ever section = { zero = "x_dot" } (x a displacement) tells more, but '
        "takes a slow way to rest for a torus; what rests, unstably, from its start on needs "
        "another start",
    ),
    Reason(
        "cycle_not_confirmed",
        "the section repeats, but Newton's method finds no stable cycle of the motion's own there "
        "(an event that grazes, a multiplier of 1; a symmetry that the start keeps): lower rtol in "
        "[solver], choose another section, raise t_max, or move the start",
    ),
    Reason(
        "section_drifts",
        "the first and the second half of the section points differ by more than sampling "
        f"explains, so the motion is still on its way: {LONGER}",
    ),
    Reason(
        "hole_too_small",
        "the disc's hole is so small that a mode cannot be told from that of a disc without one "
        "(the message names it): raise a, or leave the mode out",
    ),
    Reason(
        "inexact_equilibrium",
        "what is left of the forces at a supposed equilibrium is no rounding: the parameters are "
        "too many orders of magnitude apart for it to be found; bring them closer",
    ),
    Reason(
        "dependent_contacts",
        "what holds a contact here depends on another (slip velocities of one direction), or on a "
        "slip_coordinate that does not move it: what each would bear in stick is open; move the "
        "parameters off it, make one contact of them, or name another slip_coordinate",
    ),
    Reason(
        "no_number",
        "a force, a rate or an energy is no number here (a division by zero, a root or a "
        "power of a negative number): the answer means nothing; look at the equations and the "
        "parameters",
    ),
    Reason(
        "sector_not_read",
        "the sector differs by mu_s_2 and mu_k_2, and the friction law has no mu_k: beta = 0, or "
        "another law",
    ),
    Reason(
        "no_common_period",
        "excitations that are on have no common period, or the frequency of one varies: give "
        "them frequencies in a ratio of whole numbers, or switch all but one off",
    ),
    Reason(
        "leaves_range",
        "a parameter that varies harmonically leaves its range: lower its amplitude",
    ),
    Reason(
        "time_stands_still",
        "steps are too short to move the time (a number has 16 digits), so more of them lead "
        "nowhere: a law or a spring is too stiff (lower its stiffness: sigma, sigma_0, k, ...), or "
        "the motion runs into a pole of a law of your own",
    ),
    Reason(
        "nonhyperbolic",
        "to first order the equilibrium neither attracts nor repels, as exactly at a Hopf point, "
        "and the motion about it changes ever more slowly: a larger t_max follows it further "
        "(`fiv history` shows whether it dies away) and never to its end; move the parameter a "
        "little, or add damping",
    ),
)

# Reasons of motions that ended: answers, without what a motion has at its end.
ENDED_EARLY = ("diverged", "contact_lost")

MOTION_OF_A_CYCLE = (
    "of the cycle that its `cycle` found, which may be unstable, a [[initial]] of kind `state` "
    "at `cycle_section` (fiv show FILE.nc --csv 'cycle_section[*],cycle_period'), with t_end its "
    "period; over basins: fiv plot BASINS.nc HISTORY.nc --figure basin"
)

# Reasons of undecided motions whose time was up before they had settled: what they did until then
# says nothing of where they end.
ON_THE_WAY = ("time_budget", "slide_not_decided", "nonhyperbolic")

STATUS = FlagTable(
    {"ok": 0, "pending": 1, "failed": 2, "budget": 3, "not_reached": 4, NOT_COMPUTED: 5},
    fill="pending",
)
REASON = FlagTable({reason.name: code for code, reason in enumerate(REASONS)}, fill="none")
ATTRACTOR = FlagTable(
    {
        NOT_COMPUTED: -1,
        "equilibrium": 0,
        "periodic": 1,
        "quasiperiodic": 2,
        "chaotic": 3,
        "undecided": 4,
        "diverged": 5,
        "contact_lost": 6,
    },
    fill=NOT_COMPUTED,
)
CONTACT_STATE = FlagTable(
    {NOT_COMPUTED: -1, "slip+": 0, "slip-": 1, "stick": 2, "separation": 3}, fill=NOT_COMPUTED
)
PIECES = (
    "holds",
    "slides+",
    "slides-",
    "creeping",
    "forward",
    "backward",
    "elastic",
    "yields",
    "plastic",
    "interval",
    "bonded",
)
"""What the elements of friction laws may be in."""
CONTACT_EVENT = FlagTable(
    {**CONTACT_STATE.codes, **{name: code for code, name in enumerate(PIECES, 4)}},
    fill=NOT_COMPUTED,
)
CROSSING_KIND = FlagTable({NOT_COMPUTED: -1, "root": 0, "jump": 1, "end": 2}, fill=NOT_COMPUTED)
CROSSING_DIRECTION = FlagTable(
    {NOT_COMPUTED: -1, "to_stable": 0, "to_unstable": 1, "lost": 2, "gained": 3},
    fill=NOT_COMPUTED,
)
STABLE = FlagTable({NOT_COMPUTED: -1, "unstable": 0, "stable": 1, "neutral": 2}, fill=NOT_COMPUTED)
COMPLETE = FlagTable({NOT_COMPUTED: -1, "not_certified": 0, "certified": 1}, fill=NOT_COMPUTED)
CYCLE_END = FlagTable(
    {
        NOT_COMPUTED: -1,
        "fold": 0,
        "flip": 1,
        "torus": 2,
        "branching": 3,
        "grazing": 4,
        "contact_lost": 5,
        "equilibrium": 6,
        "bracket": 7,
        "budget": 8,
        "other": 9,
        "mu_k_above_mu_s": 10,
        "closed": 11,
    },
    fill=NOT_COMPUTED,
)
GRAZED = FlagTable(
    {
        NOT_COMPUTED: -1,
        "stick": 0,
        "slip_reversal": 1,
        "separation": 2,
        "law_piece": 3,
        "order": 4,
    },
    fill=NOT_COMPUTED,
)
GOES_ON = FlagTable({NOT_COMPUTED: -1, "no": 0, "yes": 1}, fill=NOT_COMPUTED)
RANGE_END = FlagTable(
    {NOT_COMPUTED: -1, "change": 0, "bracket": 1, "undecided": 2}, fill=NOT_COMPUTED
)
ANSWER = FlagTable({NOT_COMPUTED: -1, "no": 0, "yes": 1, "open": 2}, fill=NOT_COMPUTED)
FOLLOWED = FlagTable({NOT_COMPUTED: -1, "none": 0, "up": 1, "down": 2}, fill=NOT_COMPUTED)
SECTION = FlagTable(
    {NOT_COMPUTED: -1, "slip_to_stick": 0, "stick_to_slip": 1, "turning_point": 2, "impact": 3},
    fill=NOT_COMPUTED,
)
COMPUTED = FlagTable(
    {
        NOT_COMPUTED: -1,
        "filled_in": 0,
        "run": 1,
        "sampled": 2,
        "sampled_and_mislabelled": 3,
    },
    fill=NOT_COMPUTED,
)

TABLES: Mapping[str, FlagTable] = {
    "status": STATUS,
    "reason": REASON,
    "attractor": ATTRACTOR,
    "contact_state": CONTACT_STATE,
    "contact_event": CONTACT_EVENT,
    "stable": STABLE,
    "crossing_kind": CROSSING_KIND,
    "crossing_direction": CROSSING_DIRECTION,
    "complete": COMPLETE,
    "cycle_end": CYCLE_END,
    "grazed": GRAZED,
    "goes_on": GOES_ON,
    "range_end": RANGE_END,
    "section": SECTION,
    "computed": COMPUTED,
    "answer": ANSWER,
    "followed": FOLLOWED,
}


def reason_code(name: str) -> int:
    """Code of a reason; an empty name is ``none``.

    Raises
    ------
    KeyError
        the table has no such reason.
    """
    return REASON.codes[name or "none"]


def retried_codes() -> frozenset[int]:
    """Codes of the reasons whose points are run again on resume."""
    return frozenset(code for code, reason in enumerate(REASONS) if reason.retried)


def is_retried(name: str) -> bool:
    """Whether a point that failed for this reason is run again on resume."""
    return any(reason.retried and reason.name == name for reason in REASONS)


ADVICE_OF = {
    ("no_crossing", "boundary"): "the answer to `of` is the same wherever it was looked at in the "
    "bracket (scan_class says which class holds): start elsewhere, in the basin of another motion, "
    "widen the bracket, look at more points (scan), or ask for another class (of)",
    ("time_budget", "response"): "the motion had not settled by half of t_max, from where on it is "
    f"measured: {LONGER}; another section decides some",
    **{
        ("too_many_events", kind): "raise solver.max_events, or lower t_end if the motion chatters"
        for kind in ("history", "spectrogram")
    },
    ("no_crossing", "critical"): "no mode changes its stability inside the bracket (unstable "
    "throughout where growth_at_low is above 0, stable where it is below): widen it, or look "
    "closer, at `eigenvalues` along it",
}
"""(Reason, kind of analysis) -> what it means there, where it means several things."""


WITH_OPTION = {
    ("contact_lost", "states"): "; its option `states` lets it go on in separation (fiv models "
    "NAME)",
    ("time_budget", "lyapunov"): '; under lyapunov = "never" chaos is undecided: "auto" tells it',
    ("tests_disagree", "lyapunov"): '; under lyapunov = "never" no exponent is asked: "auto"',
}
"""(Reason, option of a model, or what is left out) -> what more there is to do then."""


def left_out(settings: Mapping[str, Any]) -> tuple[str, ...]:
    """What an analysis under these settings does without."""
    return ("lyapunov",) if settings.get("lyapunov") == "never" else ()


def advice(name: str, kind: str = "", options: Collection[str] = ()) -> str:
    """The sentence that says what to do about a reason, of an analysis of this kind.

    `options` are those that the model has, and what the analysis does without.
    """
    told = ADVICE_OF.get((name, kind)) or REASONS[reason_code(name)].advice
    more = (WITH_OPTION.get((name, option), "") for option in options)
    return "".join([told, *more])
