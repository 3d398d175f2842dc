"""Laws given by pieces: loops of exact area, the laws that they tend to, their events, tangents."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
import sympy
from motions import TIGHT, by_both, defaults, motion, system, times, transitions
from numpy.typing import NDArray
from small_models import TWO_MASSES

from fiv_cli import api
from fiv_cli.analyses.base import SolverSettings
from fiv_cli.analyses.rest.linearisation import free_states
from fiv_cli.dynamics.motion import Motion, Stop, samples_at
from fiv_cli.friction import all_laws, get_law
from fiv_cli.friction.base import Slip
from fiv_cli.models.base import Equations, Model

STILL = {"m": 1e12, "k": 1e12}  # what a belt under this mass does not move
SHAKEN = {"v": [(0.0, 1.0), (1.0, -1.0), (2.0, 1.0), (3.0, -1.0)]}  # m/s: by 0.25 m about a mean
AT_REST = ("equilibrium", "eigenvalues")
SMALL = {"c": 0.05, "v": 0.3, "N": 5.0}


def cycled(law: str, **changes: float) -> Motion:
    """A motion under a cycle of slip, from a turn to the same turn, measured along it."""
    begun = motion("belt-1dof", law, {}, curves=SHAKEN, **STILL, **changes)
    assert begun.run(0.5) == Stop.REACHED
    begun.start_measuring(np.zeros(1))
    begun.keep_ledger(100)
    assert begun.run(2.5, measuring=True) == Stop.REACHED
    return begun


# --- one slider, one band -------------------------------------------------------------------------
@pytest.mark.parametrize("law", ["jenkins", "reset-integrator"])
def test_the_cycle_of_a_slider_is_a_parallelogram(law: str) -> None:
    """Of area 4 mu_k N (A - mu_k/sigma_0) under a slip of amplitude A, as its docstring says."""
    undamped = {"sigma_1": 0.0, "a_stick": 0.4} if law == "reset-integrator" else {}
    begun = cycled(law, mu_k=0.3, sigma_0=10.0, N=5.0, **undamped)
    assert begun.measures.drive_work == pytest.approx(4 * 0.3 * 5.0 * (0.25 - 0.03), rel=1e-11)
    names = ["holds->slides-", "slides-->holds", "holds->slides+", "slides+->holds"]
    assert transitions(begun) == names
    assert begun.y[2] == pytest.approx(1.0, rel=1e-12)


def test_the_force_of_a_reset_integrator_jumps_at_break_away_and_as_slip_turns() -> None:
    given = {"mu_k": 0.3, "sigma_0": 10.0, "N": 5.0, "sigma_1": 0.0, "a_stick": 0.4}
    begun = motion("belt-1dof", "reset-integrator", {}, curves=SHAKEN, **STILL, **given)
    begun.run(0.5)
    broken, turned = times(begun)
    samples = samples_at(begun.system, np.array([0.5 * broken, broken + 1e-9, 0.5 + 1e-9]))
    begun = motion("belt-1dof", "reset-integrator", {}, curves=SHAKEN, **STILL, **given)
    begun.run(0.6, samples=samples)
    assert turned == pytest.approx(0.5) and broken == pytest.approx(0.5 - 0.22**0.5, rel=1e-9)
    forces = samples.forces[:, 0, 1]
    bent = 0.5 * broken - (0.5 * broken) ** 2
    np.testing.assert_allclose(forces, [1.4 * 50.0 * bent, 1.5, 1.4 * 1.5], rtol=1e-6)


def test_the_cycle_of_elements_in_parallel_is_the_sum_of_theirs() -> None:
    shares, stiffness = (0.1, 0.2, 0.3, 0.4), (20.0, 10.0, 5.0, 0.4)  # the last never slides
    elements = dict(zip(("alpha_1", "alpha_2", "alpha_3", "alpha_4"), shares, strict=True))
    elements |= dict(zip(("k_1", "k_2", "k_3", "k_4"), stiffness, strict=True))
    begun = cycled("gms", mu_s=0.3, mu_k=0.3, N=5.0, **elements)
    limits = 0.3 * np.array(shares)
    slid = np.maximum(0.25 - limits / stiffness, 0.0)
    assert begun.measures.drive_work == pytest.approx(float(4 * 5.0 * limits @ slid), rel=1e-11)


def test_four_equal_elements_are_one_slider() -> None:
    equal = {f"alpha_{i}": 0.25 for i in range(1, 5)} | {f"k_{i}": 50.0 for i in range(1, 5)}
    several = motion("belt-1dof", "gms", {"x": 0.4}, mu_s=0.3, mu_k=0.3, **equal, **SMALL)
    one = motion("belt-1dof", "jenkins", {"x": 0.4}, mu_k=0.3, sigma_0=200.0, **SMALL)
    assert several.run(6.0) == one.run(6.0) == Stop.REACHED
    np.testing.assert_allclose(several.y[:2], one.y[:2], atol=1e-11)
    assert sum(several.y[2:]) == pytest.approx(0.3 * one.y[2], abs=1e-9)


def test_bristles_snap_after_the_same_slip_again_and_again() -> None:
    """Each after its own; a quarter of mu_k N each is the mean of what they bear."""
    given = {"mu_k": 0.3, "delta_b": 0.01, "spread": 0.3, "N": 5.0, "v": 1.0}
    begun = motion("belt-1dof", "bristle", {}, **STILL, **given)
    begun.start_measuring(np.zeros(1))
    until = 0.6935  # a whole number of bonds of no bristle
    assert begun.run(until, measuring=True) == Stop.REACHED
    spans = 0.01 * np.array([0.7, 0.9, 1.1, 1.3])
    snaps = np.sort(np.concatenate([span * np.arange(1, until / span + 1e-6) for span in spans]))
    np.testing.assert_allclose(times(begun), snaps, atol=1e-9)
    assert begun.measures.drive_work == pytest.approx(0.3 * 5.0 * until, rel=1e-2)


def test_what_snaps_for_ever_has_no_equilibrium() -> None:
    found = api.analyse("belt-1dof", "bristle", "equilibrium", v=0.3)
    assert found.reason == "no_equilibrium"


def test_bristles_that_bend_before_they_yield_do_not_drift() -> None:
    """Under a load that pulsates below break-away; those of LuGre creep on and on."""
    given = {"v": 0.0, "N": 5.0, "mu_s": 0.4, "mu_k": 0.4, "sigma_0": 100.0, "sigma_1": 10.0}
    pulse = {"c": 1.0, "u0": 0.2, "omega": 5.0}
    drifts = {}
    for law in ("elasto-plastic", "lugre"):
        begun = motion("belt-1dof", law, {"x": -0.7}, **given, **pulse)
        ends = [begun.y[0] for cycles in (20, 40) if begun.run(cycles * 0.4 * np.pi) is not None]
        drifts[law] = abs(ends[1] - ends[0])
    assert drifts["elasto-plastic"] < 1e-9 and drifts["lugre"] > 1e-4


def test_a_slider_that_holds_throughout_takes_nothing() -> None:
    begun = motion("belt-1dof", "jenkins", {"x": 0.01}, N=5.0, v=0.0, sigma_0=10.0, mu_k=0.3)
    before = begun.energy()
    assert begun.run(50.0) == Stop.REACHED and begun.n_events == 0
    stored = 10.0 * 5.0 * (0.03 * begun.y[2]) ** 2 / 2
    assert begun.energy() + stored == pytest.approx(before, rel=1e-9)


def misses(law: str, name: str, values: Sequence[float], **given: float) -> NDArray[np.float64]:
    """How far a mass under a law is from one under Coulomb's, as a parameter doubles or halves."""
    start = {"x": given.pop("x", 0.0)}
    given |= {"N": 5.0, "mu_k": 0.1}
    ends = [motion("belt-1dof", law, start, **given, **{name: value}) for value in values]
    ends.append(motion("belt-1dof", "coulomb", start, **given, mu_s=given["mu_k"]))
    assert all(begun.run(6.0) == Stop.REACHED for begun in ends)
    found: NDArray[np.float64] = np.abs([float(begun.y[0] - ends[-1].y[0]) for begun in ends[:-1]])
    return found


@pytest.mark.parametrize(
    ("law", "name", "values", "given", "order"),
    [
        ("jenkins", "sigma_0", (1e3, 2e3, 4e3), {"x": 4.0, "v": 0.0}, 0.5),
        ("linear-regularisation", "v_tol", (4e-3, 2e-3, 1e-3), {"v": 0.3, "c": 0.05}, 1.0),
    ],
)
def test_laws_of_pieces_tend_to_coulomb(
    law: str, name: str, values: tuple[float, ...], given: dict[str, float], order: float
) -> None:
    """Of a spring, the slip that turns it round takes a time of sigma_0 to the power -1/2."""
    errors = misses(law, name, values, **given)
    assert np.log2(errors[:-1] / errors[1:]) == pytest.approx(order, abs=0.05)


# --- every law of pieces --------------------------------------------------------------------------
STORING = tuple(name for name, law in all_laws().items() if law.stored is not None)
LAWS = tuple(name for name, law in all_laws().items() if law.pieces)
RESTING = tuple(name for name in LAWS if get_law(name).rests)
# Where an event of a law's pieces lies in each: model, start, options, changes, until.
SITES: dict[str, tuple[str, dict[str, float], dict[str, str], dict[str, float], float]] = {
    "belt": ("belt-1dof", {"x": 0.4}, {}, SMALL, 3.0),
    "two contacts": ("belt-2mass", {"x1": 0.5, "x2": 0.2}, {}, {"v": 0.4}, 3.0),
    "algebraic normal force": (
        "disc-rigid-contact",
        {"phi_dot": 3.0},
        {"modes": "0,1 0,2"},
        {"Omega": 3.0, "N0": 500.0},
        0.02,
    ),
    "separation": ("belt-5dof", {"x1_dot": 4.0, "y1": 1e-3}, {}, {}, 0.4),
}
# Compiling takes longer than moving: every law on the belt, one law everywhere.
LONG = {"algebraic normal force": pytest.mark.campaign}
PAIRS = (
    *((law, "belt") for law in LAWS),
    *(pytest.param("jenkins", site, marks=LONG.get(site, ())) for site in SITES if site != "belt"),
)
by_pair = pytest.mark.parametrize(("law", "site"), PAIRS)


def begun_at(law: str, site: str, state: Any = None, solver: SolverSettings = TIGHT) -> Motion:
    """A motion of a law at one of `SITES`, from its start or another state."""
    model, start, options, changes, _ = SITES[site]
    named = start if state is None else dict(zip(names_at(law, site), state, strict=True))
    return motion(model, law, named, solver, options, **changes)


def names_at(law: str, site: str) -> tuple[str, ...]:
    """Entries of the state vector."""
    model, _, options, changes, _ = SITES[site]
    return system(model, law, options, parameters=defaults(model, law, **changes)).state_names


@by_pair
def test_the_series_and_runge_kutta_meet_the_same_pieces(law: str, site: str) -> None:
    model, start, options, changes, until = SITES[site]
    step = until / 100_000
    exact, rough = by_both(until, step, model, law, start, options=options, **changes)
    assert exact.n_events > 0
    np.testing.assert_allclose(rough.y, exact.y, rtol=1e-6, atol=1e-9)


@by_pair
def test_tangents_follow_neighbours_through_events_of_pieces(law: str, site: str) -> None:
    """A spring at its limit bends the flow by its own entry: that one alone is left out."""
    begun, until = begun_at(law, site), SITES[site][-1]
    begun.run(until / 20)
    state = begun.y.copy()
    carried = begun_at(law, site, state)
    carried.carry_tangents(np.eye(len(state)))
    assert carried.run(until / 3) == Stop.REACHED
    scale = np.maximum(np.abs(state), 1e-3)
    columns, places = [], [i for i in free_states(begun.system) if i < len(begun.system.motions)]
    pressed = state.copy()  # a rigid contact that would overlap is closed, whatever is displaced
    pressed[[i for i in range(len(begun.system.coordinates)) if i not in places]] = -1.0
    for i in places:
        ends = []
        for shift in (1e-6, -1e-6):
            near = pressed.copy()
            near[i] += shift * scale[i]
            ends.append(begun_at(law, site, near))
            ends[-1].run(until / 3)
        columns.append((ends[0].y - ends[1].y) / 2e-6)
    expected = np.array(columns).T / scale[:, None]
    found = (carried.tangents.T * scale / scale[:, None])[:, places]
    np.testing.assert_allclose(found, expected, atol=1e-6 * max(1.0, np.abs(expected).max()))


def stored_in(begun: Motion) -> float:
    """What the law of a mass on a belt has stored, J."""
    law = begun.system.setup.law
    values = defaults("belt-1dof", law.name, **SMALL)
    assert law.stored is not None
    states = {state.name: begun.y[begun.system.places[state.name]] for state in law.states}
    return float(law.stored(Slip(0, 1, 0, values["N"], states, ()), values))


@pytest.mark.parametrize("law", STORING)
def test_friction_gives_back_no_more_than_it_has_stored(law: str) -> None:
    """int F_T v_rel dt less what is stored never falls."""
    begun = begun_at(law, "belt")
    begun.start_measuring(np.zeros(1))
    taken = [0.0]
    for until in np.linspace(0.02, 3.0, 150):
        begun.run(until, measuring=True)
        measures = begun.measures
        taken.append(measures.drive_work - measures.friction_work - stored_in(begun))
    assert np.diff(taken).min() > -1e-12 * taken[-1] and taken[-1] > 0.05


# --- at a standstill ------------------------------------------------------------------------------
BENDING = ("dahl", "lugre", "jenkins", "gms", "elasto-plastic", "reset-integrator", "bristle")
HELD = {"jenkins": {"sigma_0": 20.0}, "reset-integrator": {"sigma_0": 20.0, "sigma_1": 0.1},
        "bristle": {"delta_b": 0.02}}  # fmt: skip


@pytest.mark.parametrize("law", BENDING)
def test_bristles_that_hold_are_springs(law: str) -> None:
    """Upright where the drive stands still: a frequency of theirs, and zeros, as any bend holds."""
    given = {"v": 0.0, "c": 0.1, "N": 5.0, "k": 2.0, "m": 3.0}
    rest = api.analyse("belt-1dof", law, "equilibrium", **given)
    assert rest.status == "ok" and rest.values["equilibrium"].item() == 0.0
    p = defaults("belt-1dof", law, **given)
    bent = {
        "gms": sum(p.get(f"k_{i}", 0.0) for i in range(1, 5)),
        "bristle": sum(0.5 * p["mu_k"] / p.get("delta_b", 1.0) / (1 + 0.3 * s / 3)
                       for s in (-3, -1, 1, 3)),
        "reset-integrator": p.get("sigma_0", 0.0) * (1 + p.get("a_stick", 0.0)),
    }.get(law, p.get("sigma_0", 0.0))  # fmt: skip
    stiffness, damping = 2.0 + 5.0 * bent, 0.1 + 5.0 * p.get("sigma_1", 0.0)
    found = api.analyse("belt-1dof", law, "eigenvalues", **given).values
    values = found["eigenvalue_real"] + 1j * found["eigenvalue_imag"]
    expected = np.roots([3.0, damping, stiffness])
    assert sorted(values, key=abs)[-2:] == pytest.approx(sorted(expected, key=abs), rel=1e-9)
    assert np.count_nonzero(np.abs(values) < 1e-9) == len(get_law(law).states)
    assert found["stable"] == "neutral"


@pytest.mark.parametrize("x", [0.0, 0.3, 5.0])
@pytest.mark.parametrize("law", HELD)
def test_where_a_motion_is_held_by_springs_is_told_before_it_is_there(law: str, x: float) -> None:
    given = {"v": 0.0, "c": 0.2, "N": 5.0, "mu_k": 0.2, **HELD[law]}
    told = api.analyse("belt-1dof", law, "response", {"x": x}, **given).values
    assert told["attractor"] == "equilibrium" and told["transient_used"] < 20.0
    begun = motion("belt-1dof", law, {"x": x}, **given)
    begun.run(400.0)
    assert told["x_max"] == pytest.approx(float(begun.y[0]), abs=1e-9)
    assert (told["L_s"], told["L_s_reference"].item()) == (0.0, told["x_max"])


def test_a_drive_that_stands_still_is_no_error() -> None:
    """The period of a revolution was divided by."""
    given = {"t_max": 20.0}, None, {"modes": "0,1 0,2"}
    found = api.analyse(
        "disc-rigid-contact", "coulomb", "response", {"phi_dot": 1.0}, *given, Omega=0.0
    )
    assert found.status == "ok"


# --- at rest --------------------------------------------------------------------------------------
@pytest.mark.parametrize("law", RESTING)
def test_steady_sliding_is_that_of_coulomb(law: str) -> None:
    """Its eigenvalues too, beside one of each spring at its limit, which decays."""
    even = {"mu_s": 0.2} if "mu_s" in get_law(law).defaults else {}
    given = {"v": 0.4, "c": 0.1, "mu_k": 0.2}
    slides = {
        name: {kind: api.analyse("belt-1dof", name, kind, **given, **more) for kind in AT_REST}
        for name, more in ((law, even), ("coulomb", {"mu_s": 0.2}))
    }
    own, coulomb = slides[law], slides["coulomb"]
    assert own["equilibrium"].values["complete"] == "certified"
    found, exact = (one["equilibrium"].values["equilibrium"] for one in (own, coulomb))
    np.testing.assert_allclose(found, exact, rtol=1e-14)
    growth = own["eigenvalues"].values["growth_rate"]
    assert growth == pytest.approx(coulomb["eigenvalues"].values["growth_rate"], rel=1e-12)


@pytest.mark.parametrize("law", RESTING)
def test_what_slides_to_rest_is_told_before_it_is_there(law: str) -> None:
    found = api.analyse("belt-1dof", law, "response", v=2.0, c=0.3, mu_k=0.2, N=5.0)
    assert found.values["attractor"] == "equilibrium" and found.values["decay_margin"] > 0.0


# --- a contact with a law of its own --------------------------------------------------------------
GIVEN: dict[str, dict[str, float]] = {
    "gms": {"mu_s": 0.4, "mu_k": 0.25, "v_s": 0.3, **{f"k_{i}": 9.0 for i in range(1, 5)}},
    "linear-regularisation": {"mu_k": 0.2, "v_tol": 0.3},
    "jenkins": {"mu_k": 0.3, "sigma_0": 4.0},
    "elasto-plastic": {"mu_s": 0.4, "mu_k": 0.3, "v_s": 0.3, "sigma_0": 7.0, "sigma_1": 0.1},
    "coulomb": {"mu_s": 0.4, "mu_k": 0.3},
}


def of_its_own(contact: int, law: str) -> Model:
    """Two masses on a belt, of which one has a law of its own."""

    def equations(symbols: Any, options: Mapping[str, str]) -> Equations:
        found = TWO_MASSES.equations(symbols, options)
        told = {n: sympy.Float(x) for n, x in (get_law(law).defaults | GIVEN[law]).items()}
        contacts = list(found.contacts)
        contacts[contact] = replace(contacts[contact], law=law, law_parameters=told)
        return replace(found, contacts=tuple(contacts))

    return replace(TWO_MASSES, name=f"contact {contact} under {law}", equations=equations)


@pytest.mark.parametrize(
    ("first", "second"),
    [("gms", "linear-regularisation"), ("jenkins", "elasto-plastic"), ("coulomb", "jenkins")],
)
def test_it_is_the_same_whether_the_case_or_a_contact_names_a_law(first: str, second: str) -> None:
    """Motion, events, equilibrium, eigenvalues: either law may be the one of the case."""
    given = {"v": 0.4, "k2": 2.0, "N2": 5.0}
    begun = [
        motion(of_its_own(1, second), first, {"x1": 1.0}, **given, **GIVEN[first]),
        motion(of_its_own(0, first), second, {"x1": 1.0}, **given, **GIVEN[second]),
    ]
    assert all(one.run(8.0) == Stop.REACHED for one in begun) and begun[0].n_events > 4
    np.testing.assert_allclose(begun[1].y, begun[0].y, atol=1e-10)
    np.testing.assert_allclose(times(begun[1]), times(begun[0]), atol=1e-9)
    rests = [
        [
            api.analyse(model, law, kind, **given, **GIVEN[law]).values
            for kind, law, model in (
                (kind, first, of_its_own(1, second)), (kind, second, of_its_own(0, first)),
            )
        ]
        for kind in AT_REST
    ]  # fmt: skip
    for name, pair in zip(("equilibrium", "eigenvalue_real"), rests, strict=True):
        np.testing.assert_allclose(pair[1][name], pair[0][name], rtol=1e-9, atol=1e-12)
