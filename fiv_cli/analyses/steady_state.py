"""The steady state reached from a start: its class, L_s, period, section, exponents.

A run ends as soon as its answer is known: the return map has settled (periodic), stick-slip has
died and the sliding equilibrium is stable (equilibrium), the motion has diverged or lost contact.
When half of the time budget has not brought that, the other half is measured as a window, with
the largest Lyapunov exponent carried along; beyond periodic, a class needs that exponent and the
0-1 test of the section set to agree, and is ``undecided`` otherwise.

Definitions: L_s is the mean of the sum of (X - X_e)^2 over the displacement states (thesis 6.20),
on discs those of the slider (6.42), integrated along whole periods, or along the window.
Stick-slip has died when every contact has slipped without an event for the longest of 4 s, three
revolutions of disc or excitation, and three periods of the slowest mode of the sliding
equilibrium.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fiv_cli.analyses.base import Outcome, Section, SolverSettings, Start
from fiv_cli.analyses.chaos import regularity
from fiv_cli.analyses.common import (
    Sliding,
    balance,
    equilibria,
    sliding,
    start_motion,
    stopped,
    trust,
)
from fiv_cli.analyses.decay import Decay
from fiv_cli.analyses.linearisation import free_jacobian
from fiv_cli.analyses.settling import lasting_period, settled_period
from fiv_cli.dynamics import kernel
from fiv_cli.dynamics.motion import Motion, Stop
from fiv_cli.dynamics.system import System, Vector

QUIET_TIME = 4.0  # s; see the module's docstring
QUIET_PERIODS = 3.0
CHUNK = 16  # section points between two looks at the return map
BLOCKS = 64  # pieces of a measured window, between which a tangent is renormalised
KEPT = 4096  # section points kept
SHOWN = 512  # section values stored of a motion that is not periodic
NEAR = 1e-6  # distance from an equilibrium, relative to its size, that counts as being there
NEUTRAL = 1e-9  # growth rate below this share of the frequency: neither grows nor decays
REGULAR, CHAOTIC = 0.3, 0.7  # what the 0-1 test must say
SIGNIFICANT = 3.0  # standard errors
RESTING = 1e-3  # an exponent smaller than this per excitation or section period counts as zero
GROWN = 5.0  # ... and so does one by which a distance changes by less than e^5 over the window
STEADY = 0.9  # a section set whose spread falls below this share of itself is still settling


def steady_state(
    system: System,
    parameters: Mapping[str, float],
    start: Start,
    settings: Mapping[str, Any],
    solver: SolverSettings,
) -> Outcome:
    """The steady state that `start` leads to."""
    unexcited = sliding(system, parameters)
    solutions = equilibria(unexcited)
    equilibrium = solutions[0] if solutions else None
    motion = start_motion(system, parameters, start, solver, equilibrium)
    if isinstance(motion, Outcome):
        return motion
    return _Response(system, parameters, settings, unexcited, equilibrium, motion).outcome()


def from_least(values: Vector) -> Vector:
    """A cycle begun at its least value: the order tells nothing of the transient."""
    return np.roll(values, -int(np.argmin(values)))


class _Response:
    """One run on its way to a steady state."""

    def __init__(
        self,
        system: System,
        parameters: Mapping[str, float],
        settings: Mapping[str, Any],
        unexcited: Sliding,
        equilibrium: Vector | None,
        motion: Motion,
    ) -> None:
        self.system = system
        self.settings = settings
        self.equilibrium = equilibrium
        self.motion = motion
        forcing = system.model.active_forcing(parameters)
        known = system.known(parameters)
        self.excitation = None if forcing is None else 2 * np.pi / forcing.frequency(known)
        jacobian = None if equilibrium is None else unexcited.jacobian(equilibrium)
        self.eigenvalues = (
            None
            if equilibrium is None
            else np.linalg.eigvals(free_jacobian(unexcited, equilibrium))
        )
        self.quiet = self._quiet_time(parameters)
        self.decay = (
            None
            if equilibrium is None or jacobian is None
            else Decay(jacobian, equilibrium, self.quiet)
        )
        self.last_event = motion.time
        self.section: Section = settings["section"]
        self.observed = system.state_names.index(settings["observe"] or system.state_names[0])
        self.times = np.zeros(KEPT)
        self.points = np.zeros((KEPT, len(system.state_names)))
        self.count = 0
        self.stop: Stop = Stop.REACHED
        self.exponent_error = 0.0

    def _quiet_time(self, parameters: Mapping[str, float]) -> float:
        """Time without an event after which stick-slip has died, s."""
        turning = self.system.model.revolution
        spans = [QUIET_TIME]
        if turning is not None:
            spans.append(QUIET_PERIODS * 2 * np.pi / abs(turning(parameters)))
        if self.excitation is not None:
            spans.append(QUIET_PERIODS * self.excitation)
        if self.eigenvalues is not None:
            slow = np.abs(self.eigenvalues.imag)
            slow = slow[slow > 0.0]
            spans += [QUIET_PERIODS * 2 * np.pi / float(np.min(slow))] if len(slow) else []
        return max(spans)

    # --- the course of a run ----------------------------------------------------------------------
    def outcome(self) -> Outcome:
        """Follow the motion until its class is known."""
        t_max, transient = self.settings["t_max"], self.settings["transient"]
        if transient > 0.0:
            self.stop = self.motion.run(min(transient, t_max))
            self.last_event = self.motion.time
        half = transient + 0.5 * max(t_max - transient, 0.0)
        found = self._ended() or self._settle(half) or self._window(t_max)
        found.values |= trust(self.motion)
        self._add_reference(found)
        return found

    def _ended(self) -> Outcome | None:
        """The outcome of a motion that cannot go on."""
        outcome = stopped(self.stop)
        if outcome is None:
            return None
        classes = {Stop.DIVERGED: "diverged", Stop.CONTACT_LOST: "contact_lost"}
        outcome.values["attractor"] = classes.get(self.stop, "undecided")
        outcome.values["transient_used"] = self.motion.time
        return outcome

    def _settle(self, until: float) -> Outcome | None:
        """Go on until the return map settles or stick-slip dies; None when neither does."""
        last_point = self.motion.time
        while self.motion.time < until and self.stop in (Stop.REACHED, Stop.SECTION_FULL):
            before = self.count
            quiet = self._step(min(self.motion.time + self.quiet, until), self.section)
            if self.count > before:
                last_point = self.motion.time
            period = settled_period(self._map_points()) if self.count > before else 0
            if period:
                return self._periodic_from_section(period)
            # An excited motion may reverse, or pass from sector to sector, and never stick.
            pointless = self.motion.time - last_point >= self.quiet * (1.0 - 1e-12)
            if quiet or (self.excitation is not None and pointless):
                found = self._after_stick_slip(until)
                last_point = self.motion.time
            else:
                found = self._at_rest()
            if found is not None:
                return found
        return self._ended()

    def _at_rest(self) -> Outcome | None:
        """Every contact sticks and nothing moves: it stays so (a drive at standstill)."""
        sticking = bool(np.all(self.motion.kinds == kernel.STICK))
        if not sticking or self.excitation is not None or np.any(self.motion.rates() != 0.0):
            return None
        outcome = self._resting_values(self.motion.y, sticking=True)
        outcome.reason = "stuck"
        return outcome

    def _step(self, until: float, section: Section, measuring: bool = False) -> bool:
        """Run on, keeping section points; whether all contacts slipped without an event."""
        if self.count + CHUNK > KEPT:
            self._forget_oldest()
        room = (
            self.times[self.count : self.count + CHUNK],
            self.points[self.count : self.count + CHUNK],
        )
        events = self.motion.n_events
        self._aim_phase(section)
        self.stop = self.motion.run(until, section, room, None, measuring, self._strobe_period())
        self.count += self.motion.n_sections
        if self.motion.n_events != events:
            self.last_event = self.motion.time
        return self._is_quiet()

    def _is_quiet(self) -> bool:
        """Whether all contacts have slipped long enough without an event."""
        slipping = bool(np.all(self.motion.kinds == kernel.SLIP))
        return slipping and self.motion.time - self.last_event >= self.quiet * (1.0 - 1e-12)

    def _forget_oldest(self) -> None:
        half = KEPT // 2
        kept = self.count - half
        self.times[:kept] = self.times[half : self.count]
        self.points[:kept] = self.points[half : self.count]
        self.count = kept

    def _aim_phase(self, section: Section) -> None:
        """Set the next instant of a stroboscopic section."""
        if section.kind != "phase":
            return
        period = self._strobe_period()
        offset = section.phase / (2 * np.pi) * period
        turns = np.floor((self.motion.time - offset) / period + 1e-9) + 1
        self.motion.clock[kernel.NEXT_PHASE] = offset + turns * period

    def _strobe_period(self) -> float:
        return self.excitation if self.excitation is not None else self.quiet

    def _map_points(self) -> NDArray[np.float64]:
        """Section points, with the phase of the excitation where there is one."""
        points = self.points[: self.count]
        if self.excitation is None:
            return points
        phase = 2 * np.pi * self.times[: self.count] / self.excitation
        reach = np.max(np.abs(points), initial=np.finfo(float).tiny)
        # Shifted by 2: a sine that is always zero must not be judged by its rounding.
        return np.column_stack([points, reach * (2 + np.cos(phase)), reach * (2 + np.sin(phase))])

    # --- stick-slip has died ----------------------------------------------------------------------
    def _after_stick_slip(self, until: float) -> Outcome | None:
        if self.excitation is not None:
            return self._forced_sliding(until)
        if self.equilibrium is None or self.eigenvalues is None:
            return None
        growth = float(np.max(self.eigenvalues.real))
        frequency = float(np.max(np.abs(self.eigenvalues)))
        if growth < -NEUTRAL * frequency:
            return self._at_equilibrium()
        if abs(growth) <= NEUTRAL * frequency:
            return self._neutral()
        return None

    def _at_equilibrium(self) -> Outcome | None:
        """Stable, and nothing but slip left: the motion decays to it.

        Without stick (of the law, or in a contact that only slides) there are no events that could
        die: there the motion must have arrived, or decay as it does only near the equilibrium.
        """
        assert self.equilibrium is not None
        never_sticks = self.system.law.capacity is None or all(self.system.generated.smooth)
        if never_sticks and not self._arrives(self.equilibrium):
            return None
        outcome = self._resting_values(self.equilibrium, sticking=False)
        outcome.values["L_s"] = 0.0
        return outcome

    def _arrives(self, equilibrium: Vector) -> bool:
        assert self.decay is not None
        decays = self.decay.confirms(self.motion.time, self.motion.y)
        return decays or self._is_near(equilibrium)

    def _is_near(self, equilibrium: Vector) -> bool:
        assert self.eigenvalues is not None
        n = len(self.system.coordinates)
        size = float(np.max(np.abs(equilibrium)))
        away = np.abs(self.motion.y - equilibrium)
        speed = size * float(np.max(np.abs(self.eigenvalues)))
        return bool(np.all(away[:n] <= NEAR * size) and np.all(away[n : 2 * n] <= NEAR * speed))

    def _resting_values(self, state: Vector, sticking: bool) -> Outcome:
        values: dict[str, Any] = {
            "attractor": "equilibrium",
            "stick_fraction": self._per_contact(float(sticking)),
            "slip_fraction": self._per_contact(float(not sticking)),
            "separation_fraction": self._per_contact(0.0),
            "transient_used": self.motion.time,
            "energy_residual": 0.0,
        }
        for name, value in zip(self.system.state_names, state, strict=True):
            values |= {f"{name}_min": value, f"{name}_max": value, f"{name}_rms": abs(value)}
        return Outcome(values=values, carry=self._carry("equilibrium"))

    def _per_contact(self, value: float) -> Any:
        count = self.system.n_contacts
        return value if count == 1 else np.full(count, value)

    def _neutral(self) -> Outcome:
        """Undamped sliding: what is found depends on the start, so it is no attractor."""
        outcome = self._measure_window(self.motion.time + self.quiet)
        outcome.reason = "neutral_oscillation"
        outcome.values["attractor"] = "undecided"
        return outcome

    def _forced_sliding(self, until: float) -> Outcome | None:
        """Does a motion that never sticks repeat with the excitation?"""
        strobe = Section("phase")
        self.count = 0
        self._start_measuring()
        while self.motion.time < until and self.stop in (Stop.REACHED, Stop.SECTION_FULL):
            before = self.count
            self._step(until, strobe, measuring=True)
            if np.any(self.motion.measures.shares[:, kernel.STICK] > 0.0):
                break
            period = settled_period(self._map_points()) if self.count > before else 0
            if period and self.stop == Stop.SECTION_FULL:
                return self._periodic(period, strobe)
        self.count = 0
        return None

    # --- periodic ---------------------------------------------------------------------------------
    def _periodic(self, multiplicity: int, section: Section) -> Outcome:
        """Measure one period from a section point on."""
        begun = self._start_measuring()
        energy = self.motion.energy()
        points = self._next_points(multiplicity, section, measuring=True)
        period = self.motion.time - begun
        if self.stop != Stop.SECTION_FULL or period <= 0.0:
            return self._ended() or Outcome(
                reason="not_converged", values={"attractor": "undecided"}
            )
        values = self._measured(energy) | {
            "attractor": "periodic",
            "period": period,
            "multiplicity": multiplicity,
            "response_frequency": 1.0 / period,
            "transient_used": begun,
        }
        if self.excitation is not None:
            values["period_ratio"] = period / self.excitation
        shown = from_least(points[:, self.observed]) if section is self.section else np.zeros(0)
        values |= self._floquet(multiplicity, section, period)
        carry = self._carry("periodic")
        return Outcome(values=values, ragged={"section_value": shown}, carry=carry)

    def _next_points(
        self, count: int, section: Section, measuring: bool = False
    ) -> NDArray[np.float64]:
        times, points = np.zeros(count), np.zeros((count, len(self.system.state_names)))
        self._aim_phase(section)
        until = self.motion.time + self.settings["t_max"]
        self.stop = self.motion.run(
            until, section, (times, points), None, measuring, self._strobe_period()
        )
        return points

    def _start_measuring(self) -> float:
        reference = np.zeros(len(self.system.coordinates))
        if self.equilibrium is not None:
            reference = self.equilibrium[: len(reference)].copy()
        counted = self.system.model.vibration or self.system.coordinates
        reference[[name not in counted for name in self.system.coordinates]] = np.nan
        self.motion.start_measuring(reference)
        return self.motion.time

    def _measured(self, energy_before: float) -> dict[str, Any]:
        """Everything that was integrated along the measured stretch."""
        measures, motion = self.motion.measures, self.motion
        time = measures.time
        shares = measures.shares / time
        per_contact = shares if len(shares) > 1 else shares[0][None, :]
        fractions = [
            per_contact[:, kind] if len(shares) > 1 else float(per_contact[0, kind])
            for kind in (kernel.STICK, kernel.SLIP, kernel.SEPARATION)
        ]
        values: dict[str, Any] = {
            "L_s": float(measures.totals[kernel.M_SPREAD]) / time,
            "L_s_window": time,
            "stick_fraction": fractions[0],
            "slip_fraction": fractions[1],
            "separation_fraction": fractions[2],
            "energy_residual": balance(motion, energy_before).residual,
        }
        if self.equilibrium is None:
            values["L_s"] = float("nan")
        least, greatest, squares = measures.extremes
        for i, name in enumerate(self.system.state_names):
            values[f"{name}_min"] = float(least[i])
            values[f"{name}_max"] = float(greatest[i])
            values[f"{name}_rms"] = float(np.sqrt(squares[i] / time))
        return values

    def _floquet(self, multiplicity: int, section: Section, period: float) -> dict[str, Any]:
        """Multipliers of the periodic motion, by tangents over one more period."""
        if self.settings["lyapunov"] == "never":
            return {}
        n = len(self.system.state_names)
        self.motion.carry_tangents(np.eye(n))
        self._next_points(multiplicity, section)
        monodromy = self.motion.tangents.T.copy()
        self.motion.carry_tangents(np.zeros((0, n)))
        if self.stop != Stop.SECTION_FULL or not np.all(np.isfinite(monodromy)):
            return {}
        multipliers = np.linalg.eigvals(monodromy).astype(complex)
        multipliers = multipliers[np.lexsort((-multipliers.imag, -np.abs(multipliers)))]
        modulus = np.abs(multipliers)
        nontrivial = multipliers
        if self.excitation is None:
            nontrivial = np.delete(multipliers, np.argmin(np.abs(multipliers - 1.0)))
        largest = float(np.max(np.abs(nontrivial), initial=0.0))
        exponent = np.log(largest) / period if largest > 0.0 else -np.inf
        return {
            "floquet_multiplier": modulus,
            "floquet_multiplier_real": multipliers.real,
            "floquet_multiplier_imag": multipliers.imag,
            "lyapunov": float(exponent),
        }

    # --- not periodic -----------------------------------------------------------------------------
    def _window(self, t_max: float) -> Outcome:
        """Measure the rest of the budget and say what its tests say."""
        self.count = 0
        with_exponent = self.settings["lyapunov"] != "never"
        outcome = self._measure_window(t_max, with_exponent)
        ended = self._ended()
        if ended is not None:
            return ended
        points = self._map_points()
        period = settled_period(points) or lasting_period(points)
        if period:
            return self._periodic_from_section(period)
        dead = self._is_quiet() and self.excitation is None
        found = self._after_stick_slip(t_max) if dead else None
        if found is not None:
            return found
        outcome.values["attractor"], outcome.reason = self._class_of(outcome)
        outcome.carry = self._carry(outcome.values["attractor"])
        return outcome

    def _periodic_from_section(self, period: int) -> Outcome:
        """Go to the next section point and measure a period from there."""
        if self.stop != Stop.SECTION_FULL:
            self._next_points(1, self.section)
        return self._periodic(period, self.section)

    def _measure_window(self, until: float, with_exponent: bool = False) -> Outcome:
        begun = self._start_measuring()
        energy = self.motion.energy()
        exponent = _Exponent(self.motion, self.excitation is None) if with_exponent else None
        for goal in np.linspace(begun, until, BLOCKS + 1)[1:]:
            self._run_to(float(goal))
            if exponent is not None:
                exponent.update()
        if exponent is not None:
            exponent.release()
        if self.motion.measures.time <= 0.0:
            return Outcome(reason="time_budget", values={"attractor": "undecided"})
        values = self._measured(energy) | {"transient_used": begun}
        if exponent is not None:
            values["lyapunov"] = exponent.mean
            self.exponent_error = exponent.error
        shown = self.points[: self.count, self.observed][-SHOWN:].copy()
        return Outcome(values=values, ragged={"section_value": shown})

    def _run_to(self, goal: float) -> None:
        """Measure up to `goal`, keeping section points."""
        while self.motion.time < goal and self.stop in (Stop.REACHED, Stop.SECTION_FULL):
            self._step(goal, self.section, measuring=True)

    def _class_of(self, outcome: Outcome) -> tuple[str, str]:
        """Two agreeing tests, or undecided."""
        if self.count == 0:
            return "undecided", "no_section_points"
        exponent = outcome.values.get("lyapunov", float("nan"))
        regular = regularity(self.points[: self.count, self.observed])
        if not (np.isfinite(exponent) and np.isfinite(regular)):
            return "undecided", "time_budget"
        window = self.times[self.count - 1] - self.times[0]
        uncertain, most = SIGNIFICANT * self.exponent_error, RESTING * max(self.count - 1, 1)
        # On a torus neighbours drift apart in proportion to time, and never approach.
        drift = GROWN + np.log(self.count)
        threshold = max(uncertain, min(most, drift) / window)
        if exponent > threshold and regular > CHAOTIC:
            return "chaotic", ""
        if exponent < -max(uncertain, min(most, GROWN) / window):  # it settles
            return "undecided", "time_budget"
        if abs(exponent) > threshold or regular >= REGULAR:
            return "undecided", "tests_disagree"
        return ("quasiperiodic", "") if self._keeps_its_spread() else ("undecided", "time_budget")

    def _keeps_its_spread(self) -> bool:
        """Whether the section set is as wide at the end as before: a slow spiral is not."""
        before, after = np.array_split(self.points[: self.count, self.observed], 2)
        return bool(STEADY < np.std(after) / np.std(before) < 1.0 / STEADY)

    # --- what is handed on ------------------------------------------------------------------------
    def _carry(self, attractor: str) -> dict[str, Any]:
        """State for a continuing neighbour: at phase 0 of an excitation, else where it is."""
        motion = self.motion
        if self.excitation is not None and attractor != "equilibrium":
            turns = np.ceil(motion.time / self.excitation - 1e-9)
            motion.run(turns * self.excitation)
        return {
            "attractor": attractor,
            "state": motion.y.tolist(),
            "sticking": [int(kind == kernel.STICK) for kind in motion.kinds],
        }

    def _add_reference(self, outcome: Outcome) -> None:
        if self.equilibrium is not None:
            outcome.values["L_s_reference"] = self.equilibrium[: len(self.system.coordinates)]


class _Exponent:
    """The largest nontrivial Lyapunov exponent, from one tangent vector.

    On an autonomous system the direction of the flow is trivial; the vector is kept orthogonal
    to it, so that its growth is that of the next direction. Saltation at events is the driver's.
    """

    def __init__(self, motion: Motion, autonomous: bool) -> None:
        self.motion = motion
        self.autonomous = autonomous
        n = len(motion.y)
        self.scales = np.maximum(np.abs(motion.y), 1e-300)
        self.begun = motion.time
        self.growths: list[float] = []
        self.spans: list[float] = []
        self.last = motion.time
        # A fixed direction without symmetry, so that no invariant subspace is met by accident.
        vector = np.cos(1.0 + np.arange(n) * 2.0**0.5)
        motion.carry_tangents(self._normalised(vector)[0][None, :])

    def _normalised(self, vector: Vector) -> tuple[Vector, float]:
        if self.autonomous:
            flow = self.motion.rates()
            size = float(flow @ flow)
            vector = vector - (vector @ flow) / size * flow if size > 0.0 else vector
        norm = float(np.linalg.norm(vector))
        return (vector / norm if norm > 0.0 else vector), norm

    def update(self) -> None:
        """Book the growth since the last call."""
        vector, norm = self._normalised(self.motion.tangents[0])
        span = self.motion.time - self.last
        if span > 0.0:
            self.growths.append(float(np.log(norm)) if norm > 0.0 else -np.inf)
            self.spans.append(span)
            self.last = self.motion.time
            self.motion.carry_tangents(vector[None, :])

    def release(self) -> None:
        """Stop carrying the tangent."""
        self.motion.carry_tangents(np.zeros((0, len(self.motion.y))))

    @property
    def mean(self) -> float:
        """1/s."""
        return float(np.sum(self.growths) / np.sum(self.spans)) if self.spans else float("nan")

    @property
    def error(self) -> float:
        """Standard error of `mean`, from the scatter of blocks; 0 where it is not finite."""
        if not np.all(np.isfinite(self.growths)):
            return 0.0
        groups = np.array_split(np.arange(len(self.growths)), min(16, max(len(self.growths), 1)))
        growths, spans = np.array(self.growths), np.array(self.spans)
        rates = np.array([growths[g].sum() / spans[g].sum() for g in groups if len(g)])
        return float(np.std(rates) / np.sqrt(max(len(rates) - 1, 1)))
