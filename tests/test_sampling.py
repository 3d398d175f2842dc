"""Curves are drawn through samples that follow a motion, and through no others."""

from __future__ import annotations

import csv
from pathlib import Path

import numpy as np
import pytest
import synthetic_datasets as data
import xarray as xr

from fiv_cli import api
from fiv_cli.case.case import FigureSpec
from fiv_cli.cli.main import run
from fiv_cli.plots import draw
from fiv_cli.reading.datasets import read_analyses
from fiv_cli.reading.sampling import enough, is_coarse

CASE = """schema = 1
[model]
name = "belt-1dof"
parameters = { c = 0.0 }
[[initial]]
label = "far"
kind = "state"
state = { x = 12.0 }
[[analysis]]
kind = "response"
"""


def harmonic(samples_a_period: float, periods: float = 50.3) -> xr.Dataset:
    time = np.arange(0.0, periods, 1.0 / samples_a_period)
    angle = 2.0 * np.pi * time
    motion = {"x": np.sin(angle), "x_dot": 2.0 * np.pi * np.cos(angle)}
    return xr.Dataset({n: ("time", v) for n, v in motion.items()}, {"time": time})


@pytest.mark.parametrize(
    ("samples", "coarse"), [(46, False), (12, False), (8, False), (4, True), (2.2, True), (1, True)]
)
def test_samples_are_too_few_from_a_few_a_period_on(samples: float, coarse: bool) -> None:
    """Once a period, too, where they all lie at the same value and the speed says otherwise."""
    motion = harmonic(samples)
    assert is_coarse(motion) == is_coarse(motion, "x_dot") == coarse
    if coarse and samples > 1:
        assert 1 / 60 < enough(motion) < 1 / 20


@pytest.mark.parametrize("sample", [0.1, 0.3, 1.0, 2.2])
def test_nothing_is_drawn_faster_than_the_belt_that_drives_it(
    sample: float, tmp_path: Path
) -> None:
    """Its speed has a corner at each landing, from which samples lead beyond."""
    case, path = tmp_path / "case.toml", tmp_path / "m.nc"
    case.write_text(CASE)
    given = ["--t-end", "90", "--sample", f"{sample}", "--set", "initial.far.state.x=0"]
    assert run(["history", str(case), *given, "-o", str(path)]) == 0
    analyses = read_analyses(path)
    (motion,) = analyses.values()
    assert is_coarse(motion.squeeze(drop=True)) == (sample >= 1.0)
    (ax,) = draw(analyses, FigureSpec("p", "phase", {})).axes
    pieces = [s for c in ax.collections for s in c.get_segments()]
    pieces += [line.get_xydata() for line in ax.lines]
    fastest = np.concatenate(pieces)[:, 1].max()
    assert 0.99 < fastest <= 1.0 + 1e-9


@pytest.mark.parametrize("fast", [1.0, 30.0])
def test_where_samples_follow_one_state_of_a_figure_and_not_another_all_are_points(
    fast: float,
) -> None:
    dataset = data.history(labels=("far",))
    dataset = dataset.drop_vars([name for name in dataset if name.startswith("event_")])
    angle = dataset["time"] * 6.0 * fast
    dataset["theta"][0], dataset["theta_dot"][0] = np.sin(angle), 6.0 * fast * np.cos(angle)
    for kind in ("history", "phase"):
        axes = draw(dataset, FigureSpec("f", kind, {"x": "phi", "y": "theta"})).axes
        if kind == "phase":
            key = axes[0].figure.legends[0].legend_handles[0]  # of a state of the contact
            assert (key.get_linestyle() == "None") == (fast > 1.0)
        for ax in axes:
            assert any(line.get_marker() == "." for line in ax.lines) == (fast > 1.0)
            assert fast == 1.0 or not [one for one in ax.collections if one.get_paths()]


@pytest.fixture
def drawn(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A stick-slip of a period of 7 s, sampled every 5 s, and drawn."""
    monkeypatch.chdir(tmp_path)
    Path("case.toml").write_text(CASE)
    assert run(["history", "case.toml", "--t-end", "3000", "--sample", "5", "-o", "m.nc"]) == 0
    assert run(["plot", "m.nc", "--figure", "history", "-o", "h.csv"]) == 0
    assert run(["plot", "m.nc", "--figure", "phase", "-o", "p.csv"]) == 0
    return tmp_path


def values(path: Path) -> np.ndarray:
    rows = list(csv.DictReader(path.read_text().splitlines()))
    return np.array([float(row["y"]) for row in rows if row["y"]])


def test_what_lies_between_too_few_samples_is_not_invented(drawn: Path, capsys) -> None:
    """No value is drawn but those of samples: not one above the speed of the belt."""
    motion = api.read(drawn / "m.nc")
    for name, file in (("x", "h.csv"), ("x_dot", "p.csv")):
        assert {*values(drawn / file)} <= {*np.ravel(motion[name])}
    assert run(["history", "case.toml", "--t-end", "300", "--sample", "5", "-o", "m.nc"]) == 0
    said = capsys.readouterr().err
    assert "samples 5 s apart are too few" in said
    sample = said.partition("--sample ")[2].partition(",")[0]
    assert run(["history", "case.toml", "--t-end", "300", "--sample", sample, "-o", "m.nc"]) == 0
    assert "too few" not in capsys.readouterr().err


def test_many_samples_too_few_for_a_curve_are_drawn_as_their_range(drawn: Path) -> None:
    assert run(["history", "case.toml", "--t-end", "30000", "--sample", "5", "-o", "n.nc"]) == 0
    assert run(["plot", "n.nc", "--figure", "history", "-o", "n.csv"]) == 0
    ranges = values(drawn / "n.csv").reshape(-1, 2)
    x = api.read(drawn / "n.nc")["x"].values
    assert len(ranges) == 600
    assert (ranges.min(), ranges.max()) == (x.min(), x.max())
    assert (ranges[:, 0] <= ranges[:, 1]).all()


def test_no_force_is_drawn_beyond_what_friction_can_bear(tmp_path: Path) -> None:
    """Its law falls within a few samples of each landing: what leads there leads beyond."""
    law = '[friction]\nlaw = "exponential"\nalpha = 10.0\n[[initial]]'
    case, motion = tmp_path / "case.toml", tmp_path / "m.nc"
    case.write_text(CASE.replace("[[initial]]", law))
    assert run(["history", str(case), "--t-end", "100", "--sample", "0.1", "-o", str(motion)]) == 0
    drawn = draw(read_analyses(motion), FigureSpec("f", "history", {"variable": ["F_T"]}))
    (line,) = drawn.axes[0].lines
    force, capacity = np.abs(line.get_ydata()), 0.4 * 10.0
    assert capacity * 0.999 < force.max() <= capacity * (1.0 + 1e-12)
