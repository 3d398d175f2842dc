"""The table [schedule]: what it takes, what it refuses, and where it is found again."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
import xarray as xr

from fiv_cli.case.case import Case
from fiv_cli.case.identity import differences, document, fingerprint
from fiv_cli.case.load import parse_case
from fiv_cli.cli.main import run
from fiv_cli.errors import CaseError, Problem
from fiv_cli.sweep.plan import make_plan

BELT = """\
schema = 1
[model]
name = "belt-1dof"
parameters = { c = 0.1 }
[schedule]
v = { start = 1.0, stop = 0.0, over = 20.0 }
[[analysis]]
kind = "history"
t_end = 25.0
"""
V = "v = { start = 1.0, stop = 0.0, over = 20.0 }"


def parse(text: str = BELT, *overrides: str) -> Case:
    return parse_case(text, "belt.toml", overrides)


def with_schedule(lines: str, model: str = "belt-1dof", above: str = "") -> str:
    text = BELT.replace(V, lines).replace('"belt-1dof"', f'"{model}"')
    return text.replace("parameters = { c = 0.1 }", above)


def problem(text: str) -> Problem:
    """The one problem of a case."""
    with pytest.raises(CaseError) as caught:
        parse(text)
    (only,) = caught.value.problems
    return only


# --- what it takes --------------------------------------------------------------------------------
def test_a_ramp_is_linear_from_the_start_on() -> None:
    case = parse()
    assert case.schedule.curves == (("v", ((0.0, 1.0), (20.0, 0.0))),)
    assert case.parameters["v"] == 1.0


@pytest.mark.parametrize(
    ("line", "points"),
    [
        ("v = { points = [[0, 1.0], [2, 3]] }", ((0.0, 1.0), (2.0, 3.0))),
        ("v = { points = [[-1, 4.0], [3, 0.0]] }", ((-1.0, 4.0), (3.0, 0.0))),
        ('v = { points = [["500 ms", "50 mm/s"]] }', ((0.5, 0.05),)),
        ('v = { start = "1 m/s", stop = 2, over = "1 min" }', ((0.0, 1.0), (60.0, 2.0))),
    ],
)
def test_points_and_units(line: str, points: tuple[tuple[float, float], ...]) -> None:
    case = parse(with_schedule(line))
    assert case.schedule.curves == (("v", points),)
    assert case.parameters["v"] == case.schedule.values(0.0)["v"]


@pytest.mark.parametrize("line", ["μ_k", '"friction.mu_k"', "friction.mu_k", "mu_1"])
def test_parameters_of_the_law_go_by_any_of_their_names(line: str) -> None:
    quoted = line if line.startswith(('"', "friction")) or line.isascii() else f'"{line}"'
    case = parse(with_schedule(f"{quoted} = {{ start = 0.1, stop = 0.2, over = 5 }}"))
    assert case.schedule.names == ("mu_k",)


def test_what_follows_a_parameter_varies_with_it() -> None:
    text = with_schedule(
        "mu_s = { start = 0.8, stop = 0.6, over = 1 }", "disc-rigid-contact", ""
    ).replace("[schedule]", '[friction]\nlaw = "tanh"\nof = "exponential"\n[schedule]')
    assert parse(text.replace("mu_s =", "mu_k =")).schedule.names == ("mu_k",)
    excited = with_schedule("mu_s = { start = 1.6, stop = 1.4, over = 1 }", "excited-disc")
    assert parse(excited).schedule.names == ("mu_0", "mu_s")
    given = excited.replace("[schedule]", "[friction]\nmu_0 = 1.4\n[schedule]")
    assert parse(given).schedule.names == ("mu_s",)


def test_it_may_be_set_from_the_command_line() -> None:
    case = parse(BELT, "schedule.v.over=10", "schedule.N.points=[[0, 10.0], [1, 20.0]]")
    assert case.schedule.curves == (
        ("N", ((0.0, 10.0), (1.0, 20.0))),
        ("v", ((0.0, 1.0), (10.0, 0.0))),
    )


# --- what it refuses ------------------------------------------------------------------------------
RAMP = "{ start = 1.0, stop = 0.5, over = 2.0 }"


@pytest.mark.parametrize(
    ("lines", "path", "words"),
    [
        (f"w = {RAMP}", "schedule.w", "there is no parameter 'w'"),
        ("v = 3.0", "schedule.v", "must be a table"),
        ("v = { start = 1.0, stop = 0.0 }", "schedule.v", "neither a ramp nor a list"),
        ("v = { start = 1, stop = 0, over = 1, points = [] }", "schedule.v", "neither a ramp"),
        ("v = { start = 1, stop = 0, over = 0 }", "schedule.v.over", "out of range"),
        ("v = { start = 1, stop = 0, over = -1 }", "schedule.v.over", "out of range"),
        ("v = { points = [] }", "schedule.v.points", "one point at least"),
        ("v = { points = [[1, 2], [1, 3]] }", "schedule.v.points.1", "does not rise"),
        ("v = { points = [[1, 2, 3]] }", "schedule.v.points.0", "not 3 numbers"),
        ("v = { points = [[0, 1], [1, true]] }", "schedule.v.points.1.1", "a boolean"),
        ('v = { points = [[0, 1], [1, "2 kg"]] }', "schedule.v.points.1", "does not fit"),
        ("m = { start = 1.0, stop = 0.0, over = 1 }", "schedule.m.stop", "out of range"),
        ("v = { start = 1, end = 0, over = 1 }", "schedule.v.end", "unknown key 'end'"),
        ("mu_k = { start = 0.3, stop = 0.5, over = 1 }", "schedule.mu_k", "is above mu_s"),
    ],
)
def test_what_is_wrong_is_said_with_its_place(lines: str, path: str, words: str) -> None:
    found = problem(with_schedule(lines))
    assert found.path == path
    assert words in found.message
    assert found.line == 6


def test_a_misspelt_name_is_suggested() -> None:
    assert "did you mean 'mu_k'" in problem(with_schedule(f"mu_kk = {RAMP}")).suggestion


@pytest.mark.parametrize(
    ("more", "shown"),
    [
        ("parameters = { v = 2.0 }", "model.parameters.v"),
        ("[grid]\nv = [1.0, 2.0]", "grid.v"),
    ],
)
def test_a_parameter_has_one_value_or_one_schedule(more: str, shown: str) -> None:
    found = problem(with_schedule(V, above=more))
    assert found.path == "schedule.v"
    assert shown in found.message and found.allowed == "one of the two"


def test_the_form_of_a_law_is_fixed() -> None:
    law = '[friction]\nlaw = "stribeck"'
    assert "form of the law" in problem(with_schedule(f"delta = {RAMP}", above=law)).message


def test_the_plate_keeps_its_shape() -> None:
    found = problem(with_schedule("h = { start = 1e-3, stop = 2e-3, over = 1 }", "excited-disc"))
    assert "modes of the plate" in found.message


def test_a_phase_needs_a_constant_frequency() -> None:
    lines = "omega = { start = 1.0, stop = 2.0, over = 9 }"
    parse(with_schedule(lines))  # without excitation it is nothing
    found = problem(with_schedule(lines, above="parameters = { u0 = 0.5 }"))
    assert "phase" in found.message and "u0 = 0" in found.suggestion


def test_a_sector_passes_at_a_constant_speed() -> None:
    lines = "Omega = { start = 2.0, stop = 1.0, over = 9 }"
    parse(with_schedule(lines, "pin-on-disc"))
    sector = "parameters = { beta = 1.0 }"
    assert "phase" in problem(with_schedule(lines, "pin-on-disc", sector)).message
    moved = "psi_a = { start = 0.0, stop = 1.0, over = 9 }"
    assert "sector" in problem(with_schedule(moved, "pin-on-disc", sector)).message


@pytest.mark.parametrize("kind", ["response", "equilibrium", "eigenvalues"])
def test_steady_answers_belong_to_constant_parameters(kind: str) -> None:
    text = BELT.replace("history", kind).replace("t_end = 25.0\n", "")
    found = problem(text)
    assert found.path == "analysis.0"
    assert f"'{kind}' belongs to constant parameters, but v varies in time" in found.message
    assert "history" in found.allowed and "without [schedule]" in found.suggestion


# --- identity -------------------------------------------------------------------------------------
def test_only_a_schedule_changes_the_identity() -> None:
    constant = parse(BELT.replace(f"[schedule]\n{V}\n", ""))
    assert "schedule" not in document(constant)
    slower = parse(BELT, "schedule.v.over=30")
    assert len({fingerprint(case) for case in (constant, parse(), slower)}) == 3
    assert differences(document(parse()), slower) == [
        "schedule.v: stored [[0.0, 1.0], [20.0, 0.0]], now [[0.0, 1.0], [30.0, 0.0]]"
    ]


def test_points_of_an_axis_are_excluded_where_friction_rises_on_the_way() -> None:
    lines = "mu_k = { start = 0.1, stop = 0.3, over = 1 }"
    text = with_schedule(lines, above="[grid]\nmu_s = [0.2, 0.4]")
    plan = make_plan(parse(text))
    assert plan.analyses[0].excluded().total() == 1


def test_the_plan_prints_it() -> None:
    assert "  v varies in time: 1.0 at 0.0 s, 0.0 at 20.0 s" in make_plan(parse()).describe()


# --- through the shell ----------------------------------------------------------------------------
@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    Path("belt.toml").write_text(BELT)
    return tmp_path


def test_a_run_carries_what_varies(folder: Path) -> None:
    assert run(["run", "belt.toml", "--workers", "1", "-q"]) == 0
    assert run(["history", "belt.toml", "--at", "initial=rest", "-o", "again.nc"]) == 0
    for name in ("runs/belt.nc", "again.nc"):
        with xr.open_dataset(folder / name) as dataset:
            speed = dataset["v"].squeeze()
            assert speed.dims == ("time",) and speed.attrs["units"] == "m s-1"
            expected = np.maximum(1.0 - dataset["time"].values / 20.0, 0.0)
            np.testing.assert_allclose(speed.values, expected, atol=1e-15)
            assert json.loads(dataset.attrs["schedule_json"]) == {"v": [[0.0, 1.0], [20.0, 0.0]]}
            assert float(dataset["energy_residual"].squeeze()) < 1e-9
            sticking = dataset["contact_state"].squeeze().values == 2
            velocity = dataset["x_dot"].squeeze().values
            assert sticking.any()
            np.testing.assert_allclose(velocity[sticking], expected[sticking], atol=1e-12)


SPECTROGRAM = BELT.replace("history", "spectrogram").replace("t_end = 25.0", "f_max = 10.0")


def test_a_spectrogram_needs_something_that_varies() -> None:
    found = problem(SPECTROGRAM.replace(f"[schedule]\n{V}\n", ""))
    assert found.path == "analysis.0"
    assert "no [schedule]" in found.message and 'kind = "spectrum"' in found.suggestion


def test_a_spectrum_is_of_a_steady_state() -> None:
    found = problem(SPECTROGRAM.replace("spectrogram", "spectrum"))
    assert found.path == "analysis.0" and "v varies in time" in found.message
    assert found.suggestion == 'kind = "spectrogram"'


@pytest.mark.parametrize("line", ["hop = 1.0", "t_end = 20.0"])
def test_a_spectrum_with_settings_of_a_spectrogram_is_told_of_it(line: str) -> None:
    text = SPECTROGRAM.replace("spectrogram", "spectrum")
    found = problem(text.replace("f_max = 10.0", f"f_max = 10.0\n{line}"))
    assert found.suggestion.endswith('belongs to kind = "spectrogram"')


@pytest.mark.parametrize("line", ["t_max = 100.0", 'lyapunov = "never"'])
def test_a_spectrogram_has_no_settings_of_a_steady_state(line: str) -> None:
    found = problem(SPECTROGRAM.replace("f_max = 10.0", f"f_max = 10.0\n{line}"))
    assert found.path == f"analysis.0.{line.split()[0]}"
    assert "hop" in found.allowed


def test_a_spectrogram_does_not_ask_for_a_section() -> None:
    """The law never sticks, so a steady state would need one."""
    law = '[friction]\nlaw = "tanh"\n[schedule]'
    case = parse(SPECTROGRAM.replace("[schedule]", law))
    assert case.analyses[0].settings["t_end"] is None
