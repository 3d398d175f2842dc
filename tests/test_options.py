"""Options that are lists, and axes that decide which states a model has."""

from __future__ import annotations

import numpy as np
import pytest

from fiv_cli.analyses.base import Outcome
from fiv_cli.case.load import parse_case
from fiv_cli.case.names import ascii_name
from fiv_cli.cli.history import parse_places
from fiv_cli.data.states import on_all_states
from fiv_cli.data.variables import variables_of
from fiv_cli.errors import CaseError
from fiv_cli.models import get_model
from fiv_cli.models.disc import read_modes
from fiv_cli.sweep.again import find_point

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
    [
        ([[0, 0]], "0,0"),
        ([[0, 3], [1, 0], [0, 0]], "0,0 0,3 1,0"),
        ("0,1  0,0", "0,0 0,1"),
    ],
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
