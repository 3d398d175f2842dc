"""Measured friction from a file beside the case: its curve, motions, identity, errors."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from motions import TIGHT, motion, transitions

from fiv_cli import api
from fiv_cli.analyses.base import SolverSettings
from fiv_cli.case.identity import fingerprint
from fiv_cli.cli.main import run
from fiv_cli.codegen.setup import Setup, default_parameters
from fiv_cli.dynamics.motion import Motion, Stop
from fiv_cli.dynamics.system import build_system
from fiv_cli.errors import CaseError
from fiv_cli.friction import know_laws
from fiv_cli.friction.base import Law, Slip
from fiv_cli.friction.tabulated import read_table
from fiv_cli.models import get_model
from fiv_cli.models.origin import Origin
from fiv_cli.own.load import declared
from fiv_cli.sweep.policy import Policy
from fiv_cli.sweep.progress import for_stderr
from fiv_cli.sweep.run import run_case

BELT = {"c": 0.05, "v": 0.4, "N": 5.0}
CASE = """\
schema = 1
[model]
name = "belt-1dof"
[friction]
law = "pad.csv"
[grid]
v = [0.3, 0.8]
[[analysis]]
kind = "equilibrium"
"""


def table(rows: Sequence[tuple[float, float]], interpolation: str = "monotone") -> Law:
    """The law of a table."""
    lines = [f"# interpolation: {interpolation}", "slip velocity, coefficient"]
    lines += [f"{speed!r}, {coefficient!r}" for speed, coefficient in rows]
    (law,) = declared(Origin("pad.csv", "\n".join(lines)))
    assert isinstance(law, Law)
    return law


def under(law: Law, start: dict[str, float], solver: SolverSettings = TIGHT) -> Motion:
    """A mass on a belt under a law."""
    p = default_parameters(get_model("belt-1dof"), law, **BELT)
    begun = Motion(build_system(Setup.of("belt-1dof", law, rtol=solver.rtol)), p, solver, start)
    begun.keep_ledger(1000)
    return begun


def coefficient(law: Law, v: float) -> float:
    """F_T at a slip velocity, over the normal force."""
    sign = 1 if v >= 0.0 else -1
    slip = Slip(v, sign, sign * v, 1.0, rows=law.rows_at(v, law.defaults))
    return float(law.sliding(slip, law.defaults))


# --- the curve ------------------------------------------------------------------------------------
ROWS = ((0.1, 0.45), (0.3, 0.30), (0.4, 0.28), (1.0, 0.28), (2.0, 0.40))


@pytest.mark.parametrize("interpolation", ["monotone", "linear"])
def test_a_table_goes_through_its_rows_and_makes_no_extreme_between_them(
    interpolation: str,
) -> None:
    law = table(ROWS, interpolation)
    speeds, values = np.array(ROWS).T
    assert [coefficient(law, v) for v in speeds] == pytest.approx(values, rel=1e-14)
    for (low, left), (high, right) in pairwise(ROWS):
        found = [coefficient(law, v) for v in np.linspace(low, high, 41)]
        assert np.all(np.diff(found) * np.sign(right - left) >= -1e-15)
    assert coefficient(law, 0.0) == coefficient(law, 0.05) == 0.45
    assert coefficient(law, 9.0) == 0.40 and coefficient(law, -0.35) == -coefficient(law, 0.35)


# --- motions --------------------------------------------------------------------------------------
def test_two_rows_are_the_linear_slope_in_stick_slip() -> None:
    """As long as the slip stays inside of the table."""
    law = table(((0.0, 0.4), (5.0, 0.15)), "linear")
    sloped = motion("belt-1dof", "linear-slope", {}, F0=2.0, alpha_0=-0.25, **BELT)
    begun = under(law, {})
    assert begun.run(30.0) == sloped.run(30.0) == Stop.REACHED
    assert transitions(begun) == transitions(sloped) and begun.n_events > 5
    np.testing.assert_allclose(begun.y, sloped.y, rtol=1e-10)


@pytest.mark.parametrize(("interpolation", "order"), [("linear", 2.0), ("monotone", 4.0)])
def test_tables_of_a_curve_tend_to_it(interpolation: str, order: float) -> None:
    """Each row is passed as an event: nothing is left of the kinks but what the curve misses."""
    exact = motion("belt-1dof", "exponential", {}, mu_s=0.4, mu_0=0.4, mu_k=0.2, alpha=1.0, **BELT)
    exact.run(3.0)
    errors = []
    for rows in (16, 32, 64):
        speeds = np.linspace(0.0, 3.0, rows + 1)
        pairs = zip(speeds.tolist(), (0.2 + 0.2 * np.exp(-speeds)).tolist(), strict=True)
        begun = under(table(tuple(pairs), interpolation), {})
        begun.run(3.0)
        errors.append(float(np.abs(begun.y - exact.y).max()))
        assert transitions(begun).count("interval->interval") >= rows / 8
    assert np.log2(np.array(errors[:-1]) / errors[1:]) == pytest.approx(order, abs=0.1)


def test_runge_kutta_and_tangents_pass_the_same_rows() -> None:
    law, start = table(ROWS, "linear"), {"x": 2.5}
    exact, rough = under(law, start), under(law, start, SolverSettings("rk4", TIGHT.rtol, 1e-4))
    exact.carry_tangents(np.eye(2))
    assert exact.run(2.0) == rough.run(2.0) == Stop.REACHED
    assert transitions(exact) == transitions(rough) and "interval->interval" in transitions(exact)
    np.testing.assert_allclose(rough.y, exact.y, atol=1e-9)
    ends = [under(law, {"x": 2.5 + shift}) for shift in (1e-6, -1e-6)]
    assert all(begun.run(2.0) == Stop.REACHED for begun in ends)
    slope = (ends[0].y - ends[1].y) / 2e-6
    np.testing.assert_allclose(exact.tangents[0], slope, atol=1e-7)


# --- in a case ------------------------------------------------------------------------------------
@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    monkeypatch.chdir(tmp_path)
    Path("case.toml").write_text(CASE)
    Path("pad.csv").write_text("speed (mm/s), mu\n0, 0.4\n500, 0.3\n1000, 0.25\n")
    yield tmp_path
    know_laws((), alone=True)


def test_a_case_names_the_file_and_its_content_is_the_case(folder: Path) -> None:
    case = api.load("case.toml")
    Path("pad.csv").write_text("v, mu\n0, 0.4\n1, 0.1\n")
    assert fingerprint(api.load("case.toml")) != fingerprint(case)
    policy = Policy(workers=2, chunk_points=1, in_process_below=0.0)
    run_case(case, Path("two.nc"), policy, for_stderr(quiet=True))
    read = "pad.csv: measured friction, 3 rows, 0.25 to 0.4 at 0 to 1 m/s, monotone between them"
    assert read in str(api.check(case))
    found = api.read("two.nc")  # of what the file held when the case was loaded
    x = found["equilibrium"].sel(v=0.3).values.ravel()[0]
    law = table(((0.0, 0.4), (0.5, 0.3), (1.0, 0.25)))
    assert x == pytest.approx(10.0 * coefficient(law, 0.3), rel=1e-12)


def test_a_table_may_lie_in_another_folder_which_is_named_from_that_of_the_case(
    folder: Path,
) -> None:
    """The law is called as the case calls it, wherever the command is typed."""
    Path("cases").mkdir()
    Path("cases/one.toml").write_text(CASE.replace("pad.csv", "../pad.csv"))
    policy = Policy(workers=2, chunk_points=1, in_process_below=0.0)
    run_case(api.load("cases/one.toml"), Path("one.nc"), policy, for_stderr(quiet=True))
    run_case(api.load("case.toml"), Path("two.nc"), policy, for_stderr(quiet=True))
    one, two = api.read("one.nc"), api.read("two.nc")
    assert one.drop_attrs().identical(two.drop_attrs())
    assert one.attrs["law"] == "../pad.csv" and one.attrs["history"] == "fiv run cases/one.toml"


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("v, mu\n0, 0.4\n1, abc\n", "row 3, column 2 (coefficient): 'abc' is no number"),
        ("v, mu\n0, 0.4\n\n1\n", "row 4: has 1 columns, not 2"),
        ("v, mu\n0, 0.4\n1, -0.2\n", "row 3, column 2 (coefficient): '-0.2' is negative"),
        ("v, mu\n1, 0.4\n1, 0.2\n", "row 3, column 1 (slip velocity): '1' is not above the last"),
        ("0, 0.4\n1, 0.3\n", "row 1: is no heading"),
        ("v (N), mu\n0, 0.4\n1, 0.3\n", "row 1, column 1: 'v (N)' is in no unit of speed"),
        ("mu, v (m/s)\n0.4, 0\n0.3, 1\n", "row 1, column 2: 'v (m/s)' has a unit; the coefficient"),
        ("# interpolation: spline\nv, mu\n0, 0.4\n1, 0.3\n", "not 'spline'"),
        ("v, mu\n0, 0.4\n", "has 1 rows under its heading, and needs two"),
    ],
)
def test_what_is_wrong_in_a_table_is_told_by_row_and_column(
    folder: Path, text: str, said: str
) -> None:
    with pytest.raises(ValueError, match="row"):
        read_table(text)
    Path("pad.csv").write_text(text)
    with pytest.raises(CaseError) as caught:
        api.load("case.toml")
    assert "friction.law: pad.csv: " in str(caught.value) and said in str(caught.value)


def test_slip_beyond_the_last_row_is_told_of_each_point_and_behind_the_run(folder: Path) -> None:
    """Of motions what they reach, of an equilibrium the speed of the belt; else nothing."""
    text = CASE.replace("[0.3, 0.8]", "[0.3, 1.5]").replace('"equilibrium"', '"history"\nt_end = 9')
    text += '[[analysis]]\nkind = "equilibrium"\n[[initial]]\nlabel = "far"\n'
    Path("case.toml").write_text(text + 'kind = "state"\nstate = { x = 2.0 }\n')
    progress = for_stderr(quiet=True)
    summary = run_case(api.load("case.toml"), Path("two.nc"), Policy(workers=1), progress)
    found = api.read("two.nc")
    moved, rests = found["history"].ds.squeeze(), found["equilibrium"].ds
    slips = np.abs(moved["v"] - moved["x_dot"]).max("time").values
    told = moved["slip_beyond"].values / slips  # at the ends of steps
    assert slips[0] > 1.5 and np.all(told > 0.9) and np.all(told < 1.0 + 1e-6)
    np.testing.assert_array_equal(rests["slip_beyond"], [np.nan, 1.5])
    said = "\n".join(summary.lines())
    assert "WARNING: 2 of 2 points of history slip faster than friction was measured, 1 m/s" in said
    assert "WARNING: 1 of 2 points of equilibrium" in said and "1.5 m/s (at v=1.5)" in said


def test_a_table_that_is_not_there_is_told(folder: Path) -> None:
    Path("pad.csv").unlink()
    with pytest.raises(CaseError, match=r"pad\.csv' cannot be read"):
        api.load("case.toml")


def test_a_table_is_shown_and_drawn_wherever_it_lies(
    folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (folder / "data").mkdir()
    Path("pad.csv").rename("data/pad.csv")
    assert run(["models", "data/pad.csv"]) == 0
    shown = capsys.readouterr().out
    assert shown.startswith("pad.csv: measured friction, 3 rows") and "stiction" in shown
    assert run(["plot", "--law", "data/pad.csv:scale=2", "--law", "coulomb", "-o", "a.png"]) == 0
    assert Path("a.png").is_file()
    assert run(["models", "pad.csv"]) == 2
    assert "'pad.csv' cannot be read" in capsys.readouterr().err
