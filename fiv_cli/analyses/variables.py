"""The one table of dataset variables: names, units, meanings, own dims, flags.

To add a variable: add a `Variable` to the function of its analysis. Everything else (shards,
assembly, NetCDF attributes, comparison) reads it from here.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from fiv_cli.analyses.base import Varied
from fiv_cli.models.base import Model, Parameter, State

INT_FILL = -2147483647
"""Stands for "not computed" in integer variables (the NetCDF default for int32)."""


@dataclass(frozen=True)
class Variable:
    """One variable of a dataset.

    Attributes
    ----------
    name : name in datasets and in `Outcome.values` / `Outcome.ragged`
    units : UDUNITS string
    long_name : what it is
    dims : own dims, after those of the grid and ``initial``
    kind : "float", "int", "flag" or "coordinate" (along its own only dim, no grid dims)
    flags : key of `flags.TABLES` when kind is "flag"
    ragged : name of the group of ragged arrays it belongs to ("" when it is not ragged)
    symbol : LaTeX
    comment : what else a reader must know
    """

    name: str
    units: str
    long_name: str
    dims: tuple[str, ...] = ()
    kind: str = "float"
    flags: str = ""
    ragged: str = ""
    symbol: str = ""
    comment: str = ""

    @property
    def sample_dim(self) -> str:
        """Dim along which its ragged group is stored."""
        return f"{self.ragged}_obs"


_NO_WAY = (
    "zero for what contact determines: a slip velocity that sticks, and the transverse position "
    "and velocity of a slider in rigid contact"
)

STATUS = Variable("status", "1", "whether the point was computed", kind="flag", flags="status")
REASON = Variable("reason", "1", "why there is no better answer", kind="flag", flags="reason")


def variables_of(
    kind: str,
    model: Model,
    options: Mapping[str, str],
    settings: Mapping[str, Any],
    varying: tuple[Parameter, ...] = (),
) -> tuple[Variable, ...]:
    """Every variable of an analysis of `kind` on `model`, ``status`` and ``reason`` first.

    Parameters
    ----------
    kind : kind of the analysis
    options : options of the model (they decide its states)
    settings : settings of the analysis (``observe`` decides the unit of ``section_value``)
    varying : parameters that vary in time; each is a variable over ``time``
    """
    states = model.states(options)
    contact = ("contact",) if model.contacts > 1 else ()
    own = _BY_KIND[kind](states, contact, settings)
    if kind == "equilibrium" and model.surface is not None:
        own.append(Variable("w", "m", "displacement of the disc at the contact", ("solution",)))
    over_time = [Variable(p.name, p.unit, p.meaning, ("time",), symbol=p.symbol) for p in varying]
    return (STATUS, REASON, *own, *over_time)


def rate_unit(unit: str) -> str:
    """Unit of the time derivative of a quantity in `unit`."""
    return "s-1" if unit == "1" else f"{unit} s-1"


def motions(states: tuple[State, ...]) -> list[tuple[str, str, str, str]]:
    """(name, unit, symbol, meaning) of every state, then of every velocity."""
    positions = [(s.name, s.unit, s.symbol, s.meaning) for s in states]
    velocities = [
        (f"{s.name}_dot", rate_unit(s.unit), rf"\dot{{{s.symbol}}}", f"velocity: {s.meaning}")
        for s in states
    ]
    return positions + velocities


def _squared_unit(states: tuple[State, ...]) -> str:
    units = {state.unit for state in states}
    return f"{units.pop()}2" if len(units) == 1 else "1"


def _common_unit(states: tuple[State, ...]) -> str:
    units = {state.unit for state in states}
    return units.pop() if len(units) == 1 else "1"


def _mixed(states: tuple[State, ...]) -> str:
    mixed = len({state.unit for state in states}) > 1
    return "each state in its own unit (state_units)" if mixed else ""


def _solver_trust() -> list[Variable]:
    return [
        Variable("energy_residual", "1", "largest energy imbalance over the energy exchanged"),
        Variable("n_steps", "1", "integration steps", kind="int"),
        Variable("n_events", "1", "events (transitions of contact)", kind="int"),
    ]


def _history(
    states: tuple[State, ...], contact: tuple[str, ...], settings: Mapping[str, Any]
) -> list[Variable]:
    along = (*contact, "time")
    return [
        Variable("time", "s", "time", ("time",), kind="coordinate", symbol="t"),
        *(Variable(n, u, m, ("time",), symbol=s) for n, u, s, m in motions(states)),
        Variable("F_T", "N", "tangential contact force", along, symbol="F_T"),
        Variable("F_N", "N", "normal contact force", along, symbol="F_N"),
        Variable("contact_state", "1", "state of contact", along, "flag", "contact_state"),
        Variable("kinetic_energy", "J", "kinetic energy", ("time",)),
        Variable("potential_energy", "J", "potential energy", ("time",)),
        Variable("friction_power", "W", "power of friction on the model", ("time",)),
        Variable("drive_power", "W", "power of the drive", ("time",)),
        Variable("other_power", "W", "power of all other forces", ("time",)),
        Variable("friction_work", "J", "work of friction on the model"),
        Variable("drive_work", "J", "work of the drive"),
        Variable("other_work", "J", "work of all other forces"),
        Variable("impact_loss", "J", "energy lost in impacts"),
        Variable("event_time", "s", "instant of the event", ragged="event"),
        Variable("event_from", "1", "contact before", (), "flag", "contact_state", ragged="event"),
        Variable("event_to", "1", "contact after", (), "flag", "contact_state", ragged="event"),
        Variable("event_contact", "1", "contact, counted from 1", (), "int", ragged="event"),
        Variable("event_residual", "1", "switching function left at the event", ragged="event"),
        *(_surface() if settings.get("points") else ()),
        *_solver_trust(),
    ]


def _surface() -> list[Variable]:
    """The displacement of a disc at points that are fixed in space."""
    point = ("point",)
    return [
        Variable("w", "m", "transverse displacement of the disc", ("point", "time"), symbol="w"),
        Variable("point_radius", "m", "radius of the point", point, "coordinate", symbol="r"),
        Variable("point_angle", "rad", "angle of the point", point, "coordinate", symbol=r"\theta"),
    ]


def _equilibrium(
    states: tuple[State, ...], contact: tuple[str, ...], settings: Mapping[str, Any]
) -> list[Variable]:
    forces = ("solution", *contact)
    return [
        Variable(
            "equilibrium",
            _common_unit(states),
            "sliding equilibrium of the unexcited system",
            ("solution", "state"),
            comment=_mixed(states),
        ),
        Variable(
            "n_solutions",
            "1",
            "sliding equilibria with closed contacts",
            kind="int",
            comment="the first is the one that growing loads lead to, then by distance from it",
        ),
        Variable("n_pulling", "1", "real solutions in which a contact would pull", kind="int"),
        Variable("n_complex", "1", "solutions that are not real", kind="int"),
        Variable("complete", "1", "whether these are all the solutions", (), "flag", "complete"),
        Variable("F_N", "N", "normal contact force", forces, symbol="F_N"),
        Variable("F_T", "N", "tangential contact force", forces, symbol="F_T"),
        Variable("residual", "1", "largest acceleration left", ("solution",)),
    ]


def _eigenvalues(
    states: tuple[State, ...], contact: tuple[str, ...], settings: Mapping[str, Any]
) -> list[Variable]:
    mode, vector = ("mode",), ("mode", "state")
    mixed = "each state in its own unit; scaled to length one"
    return [
        Variable("eigenvalue_real", "rad s-1", "real part of the eigenvalue", mode),
        Variable("eigenvalue_imag", "rad s-1", "imaginary part of the eigenvalue", mode),
        Variable("mode_frequency", "Hz", "frequency of the mode", mode),
        Variable("damping_ratio", "1", "damping ratio of the mode", mode),
        Variable("eigenvector_real", "1", "real part of the eigenvector", vector, comment=mixed),
        Variable("eigenvector_imag", "1", "imaginary part of the mode", vector, comment=mixed),
        Variable("coupled_with", "1", "mode of equal frequency; -1: none", mode, "int"),
        Variable(
            "coupling_point",
            "1",
            "where on the longest numeric axis the mode merges with another, before the next point",
            mode,
            comment="between the points, where the two come to differ more in growth than in "
            "frequency, and in both by less than 1 %; with more damping they pass at a distance",
        ),
        Variable("growth_rate", "rad s-1", "largest real part"),
        Variable(
            "stable",
            "1",
            "whether the equilibrium is stable",
            (),
            "flag",
            "stable",
            comment="neutral: the largest real part is zero to rounding, as without damping",
        ),
        *_averaging(settings),
    ]


def _critical(
    states: tuple[State, ...], contact: tuple[str, ...], settings: Mapping[str, Any]
) -> list[Variable]:
    varied, along = settings["parameter"], ("crossing",)
    ranked = "as at the lower end of the bracket, by rising frequency from 0; followed from there"
    return [
        Variable("critical_value", varied.unit, f"critical value of {varied.name}", along),
        Variable("critical_width", varied.unit, "width of the interval that holds it", along),
        Variable("crossing_kind", "1", "what happens there", along, "flag", "crossing_kind"),
        Variable(
            "crossing_direction",
            "1",
            f"what the mode (or the equilibrium) does as {varied.name} rises",
            along,
            "flag",
            "crossing_direction",
        ),
        Variable("crossing_mode", "1", "mode that crosses; -1: none", along, "int", comment=ranked),
        Variable("crossing_frequency", "rad s-1", "frequency of the mode that crosses", along),
        Variable("unstable_below", "1", "growing eigenvalues below; -1: none at all", along, "int"),
        Variable("unstable_above", "1", "growing eigenvalues above; -1: none at all", along, "int"),
        Variable("n_crossings", "1", "crossings in the bracket", kind="int"),
        Variable("growth_at_low", "rad s-1", "largest real part at the lower end of the bracket"),
        Variable("growth_at_high", "rad s-1", "largest real part at the upper end of the bracket"),
        *_averaging(settings, along),
    ]


def _averaging(settings: Mapping[str, Any], dims: tuple[str, ...] = ()) -> list[Variable]:
    """How far an averaged system can be trusted."""
    if settings.get("system") != "averaged":
        return []
    comment = "of the averaged system without damping; below 5 averaging is in doubt"
    name = "excitation frequency over the highest natural one"
    return [Variable("averaging_ratio", "1", name, dims, comment=comment)]


def _response(
    states: tuple[State, ...], contact: tuple[str, ...], settings: Mapping[str, Any]
) -> list[Variable]:
    units = {name: unit for name, unit, _, _ in motions(states)}
    observed = settings.get("observe") or states[0].name
    return [
        Variable("attractor", "1", "class of the steady state", (), "flag", "attractor"),
        Variable(
            "L_s",
            _squared_unit(states),
            "vibration intensity: mean squared distance from the sliding equilibrium",
            symbol="L_s",
            comment="thesis 6.20, on discs 6.42 (of the slider alone); over one period, or over "
            "L_s_window; 0 at the equilibrium",
        ),
        Variable(
            "L_s_reference",
            _common_unit(states),
            "sliding equilibrium that L_s is measured from",
            ("state",),
            comment=_mixed(states),
        ),
        Variable(
            "L_s_reference_index",
            "1",
            "number of that equilibrium among the solutions of `equilibrium`, from 1",
            kind="int",
            comment="the one reached; of a motion that does not rest, the first, from which a "
            "start of kind `equilibrium` is offset too",
        ),
        _EQUILIBRIUM_REACHED,
        Variable("L_s_window", "s", "window of L_s, of extremes and of fractions"),
        Variable("period", "s", "period of the attractor", symbol="T"),
        Variable("multiplicity", "1", "section points per period", kind="int"),
        Variable("period_ratio", "1", "period over the period of the excitation"),
        Variable("response_frequency", "Hz", "one over the period"),
        Variable("section_value", units[observed], f"{observed} at the section", ragged="section"),
        Variable("stick_fraction", "1", "share of time in stick", contact),
        Variable("slip_fraction", "1", "share of time in slip", contact),
        Variable("separation_fraction", "1", "share of time in separation", contact),
        *_extremes(states),
        Variable("lyapunov", "s-1", "largest nontrivial Lyapunov exponent"),
        *_multipliers(),
        *_grounds(),
        *_solver_trust(),
        Variable("event_residual", "1", "largest switching function left at an event"),
        Variable("transient_used", "s", "time simulated before the steady state was accepted"),
    ]


_EQUILIBRIUM_REACHED = Variable(
    "equilibrium_index",
    "1",
    "number of the equilibrium reached, among the solutions of `equilibrium`, from 1",
    kind="int",
)


def _grounds() -> list[Variable]:
    """By how much a class meets its grounds (`analyses/attractor/grounds.py`)."""
    return [
        Variable(
            "decay_margin",
            "1",
            "share of the way to the nearest switching surface that a slide to rest leaves free",
            comment="of the level set through the motion when its class was told; equilibria only",
        ),
        Variable(
            "cycle_residual",
            "1",
            "miss of the cycle after a period, over its extent",
            comment="of the cycle that Newton's method found; periodic motions only",
        ),
        Variable(
            "section_drift",
            "1",
            "difference between the halves of the section set, over its spread; 0: stationary",
            comment="of means and spreads, the largest beyond what sampling explains",
        ),
    ]


def _boundary(
    states: tuple[State, ...], contact: tuple[str, ...], settings: Mapping[str, Any]
) -> list[Variable]:
    varied, along = settings["parameter"], ("crossing",)
    way = "direction in which it was met; none: every run begins at the start"
    unit, classes = varied.unit, "class of the steady state"
    bisected = "width of the interval that it was bisected to"
    confirmed = "distance within which runs in shorter steps and with more time find it; missing "
    confirmed += "where a side is open or they do not find it"
    return [
        Variable("boundary", unit, f"{varied.name} at which the answer changes", along),
        Variable("boundary_width", unit, bisected, along, comment="no bound of its error"),
        Variable("boundary_error", unit, "how far it may be off", along, comment=confirmed),
        Variable("class_below", "1", f"{classes} below", along, "flag", "attractor"),
        Variable("class_above", "1", f"{classes} above", along, "flag", "attractor"),
        Variable("answer_below", "1", "answer to the question below", along, "flag", "answer"),
        Variable("answer_above", "1", "answer to the question above", along, "flag", "answer"),
        Variable("found_going", "1", way, along, "flag", "followed"),
        Variable("n_crossings", "1", "changes in the bracket", kind="int"),
        Variable("n_runs", "1", "responses computed", kind="int"),
        Variable("n_undecided", "1", "responses without an answer", kind="int"),
        Variable("scan", unit, f"{varied.name} looked at first", ("scan",), kind="coordinate"),
        Variable("scan_class", "1", f"{classes} there", ("scan",), "flag", "attractor"),
        *(_way_back(unit, classes) if settings["follow"] == "both" else ()),
        *_solver_trust(),
        Variable("event_residual", "1", "largest switching function left at an event"),
    ]


def _way_back(unit: str, classes: str) -> list[Variable]:
    """What a bracket followed up and down again has besides."""
    back = f"{classes} there on the way down"
    end = "end of a range in which the way up and the way down differ"
    known = "width of the interval that it was bisected to; missing at the end of the bracket"
    return [
        Variable("scan_class_back", "1", back, ("scan",), "flag", "attractor"),
        Variable("bistable_low", unit, f"lower {end}", ("range",)),
        Variable("bistable_low_width", unit, known, ("range",)),
        Variable("bistable_high", unit, f"upper {end}", ("range",)),
        Variable("bistable_high_width", unit, known, ("range",)),
    ]


def _spectrum(
    states: tuple[State, ...], contact: tuple[str, ...], settings: Mapping[str, Any]
) -> list[Variable]:
    units = {name: unit for name, unit, _, _ in motions(states)}
    observed = settings.get("observe") or states[0].name
    unit, mode = units[observed], ("mode",)
    pair = "of the linearised system at the first sliding equilibrium, a conjugate pair once"
    return [
        Variable("frequency", "Hz", "middle of the bin", ("frequency",), "coordinate", symbol="f"),
        Variable("attractor", "1", "class of the steady state", (), "flag", "attractor"),
        Variable(
            "amplitude",
            unit,
            f"amplitude of {observed}",
            ("frequency",),
            comment="peak of a sinusoid; root of the sum of squares over the bin, mean left out; "
            "lines of a period, or a Hann window where the motion is not periodic",
        ),
        Variable("mean", unit, f"mean of {observed}"),
        Variable("response_frequency", "Hz", "frequency of the largest amplitude"),
        Variable("variance_shown", "1", "share of the mean square that lies below f_max"),
        Variable("period", "s", "period of the attractor", symbol="T"),
        Variable("multiplicity", "1", "section points per period", kind="int"),
        Variable("mode_frequency", "Hz", "frequency of the mode", mode, comment=pair),
        Variable("mode_growth", "rad s-1", "growth rate of the mode", mode, comment=pair),
        Variable("unstable_frequency", "Hz", "frequency of the growing mode", mode, comment=pair),
        *_grounds(),
        *_solver_trust(),
        Variable("event_residual", "1", "largest switching function left at an event"),
        Variable("transient_used", "s", "time simulated before the steady state was accepted"),
    ]


def _spectrogram(
    states: tuple[State, ...], contact: tuple[str, ...], settings: Mapping[str, Any]
) -> list[Variable]:
    units = {name: unit for name, unit, _, _ in motions(states)}
    observed = settings.get("observe") or states[0].name
    comment = "peak of a sinusoid; root of the sum of squares over the bin, mean left out; Hann"
    along = ("time", "frequency")
    return [
        Variable("time", "s", "middle of the window", ("time",), "coordinate", symbol="t"),
        Variable("frequency", "Hz", "middle of the bin", ("frequency",), "coordinate", symbol="f"),
        Variable(
            "spectrogram", units[observed], f"amplitude of {observed}", along, comment=comment
        ),
        Variable("mean", units[observed], f"mean of {observed} in the window", ("time",)),
        *_solver_trust(),
        Variable("event_residual", "1", "largest switching function left at an event"),
    ]


def _cycle(
    states: tuple[State, ...], contact: tuple[str, ...], settings: Mapping[str, Any]
) -> list[Variable]:
    units = {name: unit for name, unit, _, _ in motions(states)}
    observed = settings.get("observe") or states[0].name
    return [
        Variable("cycle_period", "s", "period of the cycle", symbol="T"),
        Variable("stable", "1", "whether the cycle is stable", (), "flag", "stable"),
        Variable("multiplicity", "1", "section points per period", kind="int"),
        Variable("period_ratio", "1", "period over the period of the excitation"),
        Variable(
            "cycle_section",
            "1",
            f"point of the cycle at the section, where {observed} is least",
            ("state",),
            comment="each state in its own unit (state_units)",
        ),
        Variable("section_value", units[observed], f"{observed} at the section", ragged="section"),
        *_multipliers(),
        *_extremes(states, _LEAST_AND_GREATEST),
        Variable("residual", "1", "miss after a period, over the extent of the cycle"),
        Variable("n_events", "1", "events per period", kind="int"),
        *(_branch(settings["parameter"], observed, units[observed]) if _varies(settings) else []),
    ]


def _varies(settings: Mapping[str, Any]) -> bool:
    return settings.get("parameter") is not None


def _branch(varied: Varied, observed: str, unit: str) -> list[Variable]:
    """The branch of a cycle along a parameter, and where it changes or ends."""
    name, branch, end = varied.name, "branch", "cycle_end"
    kind = "fold, flip (a multiplier passes -1), torus (a pair passes 1 in modulus), branching (a "
    kind += "multiplier passes 1), grazing (an event enters or leaves), contact lost, equilibrium "
    kind += "(the cycle shrinks to rest), bracket (its edge), budget (of points), mu_k above mu_s, "
    kind += "closed (round to its first cycle)"
    off = "how far it may be off"
    again = "what it was bisected to, and what cycles of ten times the error of integration move "
    again += "it by; missing where these do not show it"
    return [
        Variable("branch_value", varied.unit, f"{name} along the branch", ragged=branch),
        Variable("branch_period", "s", "period along the branch", ragged=branch),
        Variable("branch_min", unit, f"least {observed} of the cycle", ragged=branch),
        Variable("branch_max", unit, f"greatest {observed} of the cycle", ragged=branch),
        Variable(
            "branch_multiplier", "1", "modulus of the largest nontrivial multiplier", ragged=branch
        ),
        Variable("branch_stable", "1", "stability", (), "flag", "stable", ragged=branch),
        Variable(
            "cycle_end",
            varied.unit,
            f"{name} where the branch changes or ends",
            ragged=end,
            comment="in the order of the branch, within cycle_end_error",
        ),
        Variable(
            "cycle_end_width",
            varied.unit,
            "half the bracket that it was bisected to",
            ragged=end,
            comment="no bound of its error",
        ),
        Variable("cycle_end_error", varied.unit, off, ragged=end, comment=again),
        Variable("cycle_end_kind", "1", "what happens", (), "flag", "cycle_end", end, comment=kind),
        Variable("cycle_end_direction", "1", f"1: {name} rising, -1: falling", (), "int", "", end),
        Variable(
            "cycle_end_goes_on", "1", "whether the branch goes on", (), "flag", "goes_on", end
        ),
        *(
            variable
            for side in ("lowest", "highest")
            for variable in (
                Variable(f"cycle_{side}", varied.unit, f"{side} {name} of the branch"),
                Variable(
                    f"cycle_{side}_width", varied.unit, "half the bracket that it was bisected to"
                ),
                Variable(f"cycle_{side}_error", varied.unit, off, comment=again),
                Variable(f"cycle_{side}_kind", "1", "what is there", (), "flag", "cycle_end"),
            )
        ),
    ]


_LEAST_AND_GREATEST = (("min", "least"), ("max", "greatest"))


def _multipliers() -> tuple[Variable, ...]:
    """Floquet multipliers of a periodic motion."""
    dims, what = ("multiplier",), "of the multiplier"
    return (
        Variable("floquet_multiplier", "1", f"modulus {what}", dims, comment=_NO_WAY),
        Variable("floquet_multiplier_real", "1", f"real part {what}", dims),
        Variable("floquet_multiplier_imag", "1", "imaginary part", dims),
    )


def _extremes(
    states: tuple[State, ...],
    kinds: tuple[tuple[str, str], ...] = (*_LEAST_AND_GREATEST, ("rms", "root mean square of")),
) -> list[Variable]:
    return [
        Variable(f"{name}_{short}", unit, f"{long} {name} in the steady state")
        for name, unit, _, _ in motions(states)
        for short, long in kinds
    ]


def _plate(
    states: tuple[State, ...], contact: tuple[str, ...], settings: Mapping[str, Any]
) -> list[Variable]:
    mode, along_r = ("k", "l"), ("k", "l", "r")
    comment = "R(r0)^2/M: how a unit force at r0 accelerates the mode there; 0: a node"
    return [
        Variable("k", "1", "nodal circles", ("k",), "coordinate"),
        Variable("l", "1", "nodal diameters", ("l",), "coordinate"),
        Variable("radius", "m", "radius", ("r",), symbol="r"),
        Variable("plate_frequency", "rad s-1", "natural frequency of the disc", mode),
        Variable("inverse_modal_mass", "kg-1", "inverse modal mass at r0", mode, comment=comment),
        Variable("shape", "1", "mode shape R(r)/R(r0)", along_r),
    ]


_BY_KIND = {
    "history": _history,
    "equilibrium": _equilibrium,
    "eigenvalues": _eigenvalues,
    "critical": _critical,
    "response": _response,
    "spectrum": _spectrum,
    "spectrogram": _spectrogram,
    "boundary": _boundary,
    "cycle": _cycle,
    "plate": _plate,
}
