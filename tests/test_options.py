"""Options that are lists, and axes that decide which states a model has."""

from __future__ import annotations

import numpy as np
import pytest
from motions import defaults

from fiv_cli.analyses.base import Outcome
from fiv_cli.analyses.catalogue import variables_of
from fiv_cli.api import analyse
from fiv_cli.case.load import parse_case
from fiv_cli.cli.common import parse_places, parse_selection
from fiv_cli.data.states import on_all_states
from fiv_cli.errors import CaseError, UsageError
from fiv_cli.models import get_model
from fiv_cli.models.disc import read_modes
from fiv_cli.notation.names import ascii_name
from fiv_cli.plate import AnnularPlate, mode
from fiv_cli.sweep.motion import find_point

DISC = """
schema = 1
[model]
name = "disc-nonlinear-contact"
OPTIONS
[grid]
GRID
[[analysis]]
kind = "equilibrium"
"""


def case(options: str = "", grid: str = ""):
    """A case of the disc with these lines under [model.options] and [grid]."""
    given = f"[model.options]\n{options}" if options else ""
    return parse_case(DISC.replace("OPTIONS", given).replace("GRID", grid), "a.toml")


@pytest.mark.parametrize(
    ("value", "text"),
    [([[0, 0]], "0,0"), ([[0, 3], [1, 0], [0, 0]], "0,0 0,3 1,0"), ("0,1  0,0", "0,0 0,1")],
)
def test_modes_have_one_text(value: object, text: str) -> None:
    assert read_modes(value) == text
    assert read_modes(text) == text


@pytest.mark.parametrize(
    "value",
    [[], "", "seven", "0,x", "-1,0", [0, 0], [[0]], [[0, -1]], [[0, 0.5]], [[0, True]], 3, None],
)
def test_what_is_no_list_of_modes_is_refused(value: object) -> None:
    with pytest.raises(ValueError, match="is no"):
        read_modes(value)


def test_a_mode_stands_once() -> None:
    with pytest.raises(ValueError, match="twice"):
        read_modes([[0, 1], [0, 1]])


def test_modes_of_a_case_decide_its_states() -> None:
    found = case("modes = [[0, 2], [0, 0]]")
    assert found.options["modes"] == "0,0 0,2"


def test_a_wrong_mode_is_reported_with_its_line() -> None:
    with pytest.raises(CaseError) as caught:
        case("modes = [[0, 0], [0]]")
    (problem,) = caught.value.problems
    assert (problem.path, problem.line) == ("model.options.modes", 6)
    assert "[0] is no mode" in problem.message
    assert "such as [[0, 0], [0, 1]]" in problem.allowed


def test_a_choice_is_suggested() -> None:
    with pytest.raises(CaseError, match="did you mean 'omit'"):
        case('slope_force = "omitt"')


def test_modes_may_be_an_axis() -> None:
    found = case(grid="modes = [[[0, 0]], [[0, 1], [0, 0]]]")
    assert found.axis("modes").values == ("0,0", "0,0 0,1")
    assert found.options["modes"] == "0,0 0,1"


def test_an_axis_that_adds_states_stands_for_the_most() -> None:
    assert case(grid='geometry = ["linear", "nonlinear"]').options["geometry"] == "nonlinear"


def test_equal_modes_repeat() -> None:
    with pytest.raises(CaseError, match="values repeat"):
        case(grid="modes = [[[0, 0], [0, 1]], [[0, 1], [0, 0]]]")


def test_the_name_that_chapter_4_gives_kinetic_friction() -> None:
    assert ascii_name("mu_1") == ascii_name("μ₁".replace("₁", "_1")) == "mu_k"
    text = DISC.replace("OPTIONS", "[friction]\nmu_1 = 0.25").replace("GRID", "")
    assert parse_case(text, "a.toml").parameters["mu_k"] == 0.25


def test_states_of_a_point_find_their_places() -> None:
    """Displacements, and vectors of displacements and velocities, go by name."""
    model = get_model("disc-nonlinear-contact")
    own = model.default_options() | {"modes": "0,1"}
    every = model.default_options() | {"modes": "0,0 0,1"}
    table = variables_of("eigenvalues", model, every, {})
    # own: phi u C_0_1 D_0_1; every: phi u C_0_0 C_0_1 D_0_1
    vectors = np.arange(16.0).reshape(2, 8)
    outcome = Outcome(values={"eigenvector_real": vectors})
    found = on_all_states(outcome, model, own, every, table).values["eigenvector_real"]
    missing = np.nan
    expected = [0, 1, missing, 2, 3, 4, 5, missing, 6, 7]
    np.testing.assert_array_equal(found[0], expected)
    short = variables_of("equilibrium", model, every, {})
    outcome = Outcome(values={"equilibrium": np.arange(4.0)[None]})
    found = on_all_states(outcome, model, own, every, short).values["equilibrium"]
    np.testing.assert_array_equal(found[0], expected[:5])
    assert on_all_states(outcome, model, own, own, short) is outcome


@pytest.mark.parametrize("written", ['"0,0 0,1"', "[[0,1], [0,0]]", "'0,0 0,1'"])
def test_a_point_is_found_by_its_modes(written: str) -> None:
    text = DISC.replace("OPTIONS", "").replace("GRID", "modes = [[[0, 0]], [[0, 0], [0, 1]]]")
    text = text.replace('"equilibrium"', '"history"\nt_end = 1.0')
    at = parse_places((f"modes={written},initial=rest",))
    point = find_point(parse_case(text, "a.toml"), at)
    assert point.place == {"modes": "0,0 0,1", "initial": "rest"}


def test_several_values_of_an_axis_are_selected_in_a_list_or_one_by_one() -> None:
    both = {"initial": ["up", "down"], "Omega": ["2"]}
    assert parse_selection(("initial=[up, 'down'],Omega=2",)) == both
    assert parse_selection(("initial=up", "Omega=2,initial=down")) == both
    assert parse_selection(("modes=[[0,1], [0,0]]",)) == {"modes": ["[[0,1], [0,0]]"]}
    with pytest.raises(UsageError, match=r"one condition, --at 'Omega=5 <= \. < 7'"):
        parse_selection(("Omega=. > 5", "Omega=. < 7"))
    for sign in (">", ">=", "!="):
        with pytest.raises(UsageError, match=rf"next: a condition, --at 'Omega=\. {sign} 5'"):
            parse_selection((f"Omega{sign}5",))
    for other in ("5 < v < 7", ". < 7"):
        with pytest.raises(UsageError, match="next: --at AXIS=VALUE"):
            parse_selection((other,))
    with pytest.raises(UsageError, match="next: --at AXIS=VALUE,initial"):
        parse_places(("Omega>5",))  # one place: no condition
    assert parse_selection(("v=. >= 0.85",)) == {"v": [". >= 0.85"]}
    with pytest.raises(UsageError, match=r"--at down: malformed\nnext: .*'AXIS=\[ONE,OTHER\]'"):
        parse_selection(("initial=up,down",))


# --- displacement of a disc -----------------------------------------------------------------------
def test_w_of_a_disc_is_the_sum_of_its_modes() -> None:
    """At r0 the modal coordinates are displacements; elsewhere shapes give their ratio."""
    model = get_model("disc-nonlinear-contact")
    parameters, options = (
        defaults(model, "coulomb"),
        {**model.default_options(), "modes": "0,2 1,0"},
    )
    assert model.surface is not None
    at_r0 = model.surface(parameters, options, parameters["r0"], np.pi / 8.0)
    root = np.sqrt(0.5)
    assert at_r0 == pytest.approx({"C_1_0": 1.0, "C_0_2": root, "D_0_2": root}, rel=1e-14)
    edge = model.surface(parameters, options, 0.12, 0.0)
    shape = mode(AnnularPlate(0.044, 0.12, 0.002, 7200.0, 150e9, 0.211), 0, 2).shape
    assert edge["C_0_2"] == pytest.approx(float(shape(0.12) / shape(0.1)), rel=1e-14)
    assert edge["D_0_2"] == 0.0
    clamped = model.surface(parameters, options, 0.044, 0.3)
    assert max(map(abs, clamped.values())) < 1e-12
    assert np.isnan(model.surface(parameters, options, 0.13, 0.0)["C_1_0"])
    assert model.surface(parameters, {**options, "geometry": "linear"}, 0.1, 0.0) == {}


def test_w_over_time_and_at_rest() -> None:
    options, places = {"modes": "0,0 0,2"}, ((0.1, 0.0), (0.12, 0.7))
    start = {"u": -2e-2, "C_0_0": 1e-3, "D_0_2": 1e-3}
    settings = {"t_end": 0.02, "sample": 0.01, "points": places}
    outcome = analyse(
        "disc-nonlinear-contact", "coulomb", "history", start, settings, None, options
    )
    found = outcome.values
    np.testing.assert_allclose(found["w"][0], found["C_0_0"] + found["C_0_2"], rtol=1e-14)
    assert found["w"].shape == (2, 3)
    np.testing.assert_array_equal(found["point_radius"], [0.1, 0.12])
    rest = analyse("disc-nonlinear-contact", "coulomb", "equilibrium", options=options).values
    phi, u, c0, c2, d2 = rest["equilibrium"][0]
    w = c0 + c2 * np.cos(2 * phi) + d2 * np.sin(2 * phi)
    assert rest["w"][0] == pytest.approx(w, rel=1e-12)
    spring = 5e4 * (w - u) + 1e6 * (w - u) ** 3
    assert rest["F_N"][0] == pytest.approx(spring, rel=1e-10)


@pytest.mark.parametrize(
    ("model", "points", "words"),
    [
        ("belt-1dof", "[[0.1, 0.0]]", "has no elastic disc"),
        ("excited-disc", "[[0.2, 0.0]]", "off the disc"),
        ("excited-disc", "[0.1, 0.0]", "must be a list of two numbers"),
        ("excited-disc", "[]", "must be a list of points"),
    ],
)
def test_points_are_on_the_disc(model: str, points: str, words: str) -> None:
    text = f'schema = 1\n[model]\nname = "{model}"\n[[analysis]]\nkind = "history"\nt_end = 1.0\n'
    with pytest.raises(CaseError, match=words):
        parse_case(text + f"points = {points}\n", "a.toml")


def test_a_claim_finds_modes_in_any_order() -> None:
    claim = '[[claim]]\nsource = "a"\ntext = "b"\nvariable = "F_N"\nexpect = { less_than = 9 }\n'
    text = DISC.replace("OPTIONS", "").replace("GRID", "modes = [[[0, 0]], [[0, 0], [0, 1]]]")
    found = parse_case(text + claim + 'at = { modes = "0,1 0,0" }\n', "a.toml")
    assert found.claims[0].at == {"modes": "0,0 0,1"}
    with pytest.raises(CaseError, match=r"is no mode|is no list of modes"):
        parse_case(text + claim + 'at = { modes = "seven" }\n', "a.toml")
