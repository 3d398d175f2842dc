"""Sliders on elastic discs: every transition against a saddle-point solve, impacts, energies."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
import pytest
from disc_reference import ExcitedDisc, NonlinearContact, RigidContact, SliderOnDisc
from lumped_reference import integrate
from motions import TIGHT, defaults, motion, times, transitions

from fiv_cli.api import analyse
from fiv_cli.dynamics.motion import Motion, Stop
from fiv_cli.models import get_model

FIRST = 30  # events compared one by one
FEWER = 10  # the same for options that change little
GOOD = 1e-11  # s, to which event times are certified
SOON = 1e-7  # s after a landing
Points = Sequence[tuple[float, float]]

PROGRAMS: dict[str, tuple[type[SliderOnDisc], str]] = {
    "disc-rigid-contact": (RigidContact, "exponential"),
    "disc-nonlinear-contact": (NonlinearContact, "coulomb"),
    "excited-disc": (ExcitedDisc, "exponential"),
}


@dataclass(frozen=True)
class Setting:
    """A motion that both programs compute."""

    model: str
    start: Mapping[str, float]
    t_end: float
    options: Mapping[str, str] = field(default_factory=dict)
    turn: Points = ()
    changes: Mapping[str, float] = field(default_factory=dict)

    @property
    def law(self) -> str:
        """The model's own friction law."""
        return PROGRAMS[self.model][1]

    def parameters(self) -> dict[str, float]:
        """Every parameter, SI."""
        return defaults(self.model, self.law, **self.changes)

    def chosen(self) -> dict[str, str]:
        """Every option."""
        return get_model(self.model).default_options() | dict(self.options)

    def motion(self) -> Motion:
        """The program's motion from the start."""
        return motion(
            self.model, self.law, self.start, TIGHT, self.options,
            curves={"Omega": self.turn} if self.turn else {}, **self.changes,
        )  # fmt: skip

    def other(self) -> SliderOnDisc:
        """The independent program."""
        return PROGRAMS[self.model][0](self.parameters(), self.chosen(), self.turn)


def agrees(setting: Setting, most: int = FIRST) -> list[str]:
    """Compare events and the state where the independent program ends; events in words."""
    other = setting.other()
    expected, state = other.follow(other.state(setting.start), setting.t_end, most)
    begun, full = setting.motion(), len(expected) == most
    assert begun.run(expected[-1].time + 1e-9 if full else setting.t_end) == Stop.REACHED
    found = transitions(begun)
    assert found == [f"{event.before}->{event.after}" for event in expected]
    apart = times(begun) - np.array([event.time for event in expected])
    assert np.max(np.abs(apart), initial=0.0) < GOOD
    if not full:
        values = other.values(state)
        for part in (slice(None, other.size), slice(other.size, None)):
            largest = np.max(np.abs(values[part]))
            assert np.max(np.abs(begun.y[part] - values[part])) < 1e-9 * largest
    return found


LIFTED = {"z": 1e-3, "phi_dot": 10.0}
LIGHT = {"N0": 50.0}


def rigid(options: Mapping[str, str] | None = None, turn: Points = (), t_end: float = 0.1,
          start: Mapping[str, float] = LIFTED, **changes: float) -> Setting:  # fmt: skip
    """Chapter 4's slider, lightly pressed on unless said otherwise, begun above the disc."""
    return Setting("disc-rigid-contact", start, t_end, options or {}, turn, {**LIGHT, **changes})


@pytest.mark.parametrize(
    "setting",
    [
        pytest.param(rigid(N0=500.0), id="table-4.1"),
        pytest.param(rigid({"impact": "none"}), id="impact=none"),
        pytest.param(rigid({"slope_force": "include"}), id="slope_force=include"),
        pytest.param(rigid({"disc_damping": "stiffness"}, xi=1e-3), id="disc_damping=stiffness"),
        pytest.param(rigid(xi=1e-3), id="lightly-pressed"),
        pytest.param(
            rigid(start={"z": 1e-3, "phi_dot": -10.0, "C_0_1": 1e-3}, Omega=50.0, c_z=0.0),
            id="figure-4.25",
        ),
    ],
)  # fmt: skip
def test_a_rigid_contact_against_the_saddle_point(setting: Setting) -> None:
    found = agrees(setting, FIRST if setting.changes["N0"] > 100.0 else FEWER)
    assert len(found) >= 6
    assert any(word.startswith("separation") for word in found)
    assert "slip+->stick" in found or "slip-->stick" in found or setting.changes.get("Omega")


@pytest.mark.parametrize(
    "turn",
    [
        pytest.param([(0.0, 6.0), (0.1, 3.0)], id="decelerating"),
        pytest.param([(0.0, 6.0), (0.1, 60.0)], id="accelerating"),
    ],
)
def test_stick_on_a_disc_whose_speed_changes(turn: Points) -> None:
    """In stick phi'' = Omega' is the disc's; the friction force and F_N follow from it."""
    found = agrees(rigid({}, turn, 0.099, {}, N0=500.0), FEWER)
    assert "slip+->stick" in found


THROWN = {"u": 1e-2, "phi_dot": 20.0}
ROUGH = {"mu_s": 0.8, "mu_k": 0.5}


def sprung(options: Mapping[str, str] | None = None, t_end: float = 0.28,
           turn: Points = ()) -> Setting:  # fmt: skip
    """6.5's slider thrown on the disc."""
    return Setting("disc-nonlinear-contact", THROWN, t_end, options or {}, turn, ROUGH)


@pytest.mark.parametrize(
    "options",
    [
        {},
        {"slope_force": "include"},
        {"impact": "none"},
        {"disc_damping": "stiffness"},
        {"contact_stiffness": "linear"},
        {"states": "slip"},
        {"states": "slip+separation"},
        {"states": "slip+reverse+separation"},
    ],
    ids=lambda options: "-".join(f"{k}={v}" for k, v in options.items()) or "default",
)
def test_a_contact_spring_against_the_independent_program(options: dict[str, str]) -> None:
    setting = sprung(options, 0.1 if options.get("states") == "slip" else 0.28)
    found = agrees(setting, FEWER if options else 20)
    if options.get("states") == "slip":
        assert not found
    else:
        assert {"slip+->separation", "separation->slip+"} <= set(found)


@pytest.mark.campaign
def test_a_contact_spring_on_an_accelerating_disc() -> None:
    turn = [(0.0, 10.0), (0.2, 20.0)]
    assert len(agrees(sprung(turn=turn, t_end=0.19), FEWER)) == FEWER


@pytest.mark.parametrize("amplitude", [0.0, 2e4])
def test_the_excited_disc_against_the_independent_program(amplitude: float) -> None:
    setting = Setting(
        "excited-disc", THROWN, 0.1, {"states": "all"}, (), {"A": amplitude, "xi": 2e-4}
    )
    found = agrees(setting, FEWER)
    assert "separation->slip+" in found
    assert ("slip+->slip-" in found) == (amplitude > 0.0) or len(found) > 5


# --- energy (Jacobi integral) --------------------------------------------------------------------
CALM = {"C_phi": 0.0, "c_z": 0.0, "mu_0": 0.0, "mu_k": 0.0, "mu_s": 0.0}


def jacobi(other: SliderOnDisc, begun: Motion, potential: float) -> float:
    """T2 - T0 + U, J: T2 quadratic in the velocities, T0 of the disc's turning (thesis 4.28)."""
    scale = np.concatenate([[1.0, 1.0], 1.0 / other.radius])
    coordinates, rates = scale * begun.y[: other.size], scale * begun.y[other.size :]
    masses = other.masses()
    turning = other.order * other.turn.speed(0.0) * coordinates[2:]
    quadratic = np.sum(masses * rates**2) - np.sum(other.modal_masses * turning**2)
    strain = np.sum(other.modal_masses * (other.frequencies * coordinates[2:]) ** 2)
    return float(quadratic + strain) / 2 + potential


def rigid_potential(p: Mapping[str, float], begun: Motion) -> float:
    """Springs and preload of chapter 4, J."""
    phi, z = begun.y[:2]
    return float((p["K_phi"] * phi**2 + p["k_z"] * z**2) / 2 + p["N0"] * z)


def sprung_potential(p: Mapping[str, float], begun: Motion, d: float) -> float:
    """Springs, preload and contact spring of 6.5, J."""
    along, u = p["r0"] * begun.y[0], begun.y[1]
    springs = p["k1"] * along**2 / 2 + p["k3"] * (along - u) ** 2 / 4 + p["F"] * u
    return float(springs + p["k2"] * d**2 / 2 + p["k_nl"] * d**4 / 4)


@pytest.mark.parametrize("slope_force", ["include", "omit"])
def test_the_jacobi_integral_of_a_rigid_contact(slope_force: str) -> None:
    """Without friction, damping and impact it stays, if the contact has a potential."""
    start = {"phi": 0.1, "phi_dot": 0.3, "C_0_1": 1e-4, "D_0_2": 1e-4}
    setting = rigid({"slope_force": slope_force}, start=start, N0=500.0, Omega=20.0, **CALM)
    begun, other = setting.motion(), setting.other()
    before = jacobi(other, begun, rigid_potential(other.p, begun))
    assert begun.run(1.0) == Stop.REACHED
    assert not any("separation" in word for word in transitions(begun))
    drift = abs(jacobi(other, begun, rigid_potential(other.p, begun)) / before - 1.0)
    assert drift < 1e-10 if slope_force == "include" else drift > 1e-4


@pytest.mark.parametrize("slope_force", ["include", "omit"])
def test_the_jacobi_integral_of_a_contact_spring(slope_force: str) -> None:
    changes = {"c1": 0.0, "c2": 0.0, "mu_k": 0.0, "mu_s": 0.0, "xi": 0.0, "Omega": 20.0}
    start = {"phi": 0.05, "u": -0.02, "C_0_1": 1e-4, "D_0_2": 1e-4}
    options = {"slope_force": slope_force}
    setting = Setting("disc-nonlinear-contact", start, 1.0, options, (), changes)
    begun, other = setting.motion(), setting.other()

    def integral() -> float:
        scale = np.concatenate([[1.0, 1.0], 1.0 / other.radius])
        d = -other.gap(np.concatenate([scale * begun.y[: other.size], begun.y[other.size :]]))
        return jacobi(other, begun, sprung_potential(other.p, begun, d))

    before = integral()
    assert begun.run(1.0) == Stop.REACHED
    assert not any("separation" in word for word in transitions(begun))
    drift = abs(integral() / before - 1.0)
    assert drift < 1e-10 if slope_force == "include" else drift > 1e-5


# --- plastic impact -------------------------------------------------------------------------------
@pytest.mark.parametrize("slope_force", ["include", "omit"])
@pytest.mark.parametrize("angle", [0.4, -1.3])
def test_a_plastic_impact_on_a_disc(slope_force: str, angle: float) -> None:
    """The gap rate ends; along the whole gradient half the reduced mass is what T2 loses.

    T loses more or less than T2: the impulse has a moment about the axis, against which the drive
    holds the disc at its speed.
    """
    start = {"phi": angle, "phi_dot": 3.0, "C_0_1": 2e-4, "D_0_2": -3e-4, "C_0_0": 1e-4}
    setting = rigid({"slope_force": slope_force}, start=start | {"z": 1e-3, "z_dot": -1.0})
    other = setting.other()
    landing, *_ = other.follow(other.state(setting.start), 0.05, 1)[0]
    flight = integrate(
        other.separation().rate, 0.0, other.state(setting.start), landing.time, 1e-18
    )
    masses, jump = other.masses(), (landing.state - flight)[other.size :]
    squares = flight[other.size :] ** 2 - landing.state[other.size :] ** 2
    flexibility = other.gradient(flight) ** 2 @ (1.0 / masses)
    half = other.gap_rate(flight) ** 2 / flexibility / 2
    lost = float(masses @ squares) / 2
    assert (lost == pytest.approx(half, rel=1e-9)) == (slope_force == "include")
    assert other.gap_rate(landing.state) == pytest.approx(0.0, abs=1e-12)
    momenta = masses * jump
    assert momenta[2:] == pytest.approx(-momenta[1] * other.shape(flight[0]), rel=1e-6)
    assert (abs(momenta[0]) < 1e-14) == (slope_force == "omit")
    begun = setting.motion()
    begun.start_measuring(np.zeros(other.size))
    begun.run(landing.time + SOON, measuring=True)
    assert begun.frame.n_impacts == 1
    loss = other.kinetic(landing.time, flight) - other.kinetic(landing.time, landing.state)
    assert begun.measures.impact_loss == pytest.approx(loss, rel=1e-8)
    follows = {"slip+": other.slip(1.0), "slip-": other.slip(-1.0)}
    rate = follows.get(landing.after, other.separation()).rate
    later = integrate(rate, landing.time, landing.state, landing.time + SOON, 1e-18)
    assert begun.y == pytest.approx(other.values(later), rel=1e-9, abs=1e-10)


# --- vibration intensity --------------------------------------------------------------------------
@pytest.mark.parametrize("model", PROGRAMS)
def test_vibration_intensity_counts_the_slider_alone(model: str) -> None:
    """Thesis 6.42: the modal coordinates of the disc are no part of L_s."""
    setting = Setting(model, {"C_0_1": 1e-3, "phi_dot": 3.0}, 0.02)
    begun, counted = setting.motion(), get_model(model).vibration
    names = begun.system.coordinates
    assert counted == names[:2]
    reference = np.array([0.0 if name in counted else np.nan for name in names])
    begun.start_measuring(reference)
    begun.run(setting.t_end, measuring=True)
    squares = begun.measures.squares[: len(names)]
    assert begun.measures.spread == pytest.approx(squares[0] + squares[1])
    assert squares[3] > 0.0


def test_response_on_a_disc_measures_the_slider_from_its_equilibrium() -> None:
    """A run too short to settle: L_s over the window is what the slider's motion gives."""
    found = analyse(
        "disc-rigid-contact", "exponential", "response", {}, {"t_max": 0.4, "transient": 0.1}
    ).values
    p, e = found, found["L_s_reference"]
    spread = 0.0
    for place, name in enumerate(("phi", "z")):
        least, greatest = p[f"{name}_min"] - e[place], p[f"{name}_max"] - e[place]
        spread += max(least**2, greatest**2)
    assert 0.0 < found["L_s"] < spread
