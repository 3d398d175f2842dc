"""The numbers behind a figure: a row for each point of its marks and lines."""

import csv
import io
import json
from pathlib import Path

import numpy as np
import pytest
import synthetic_datasets as data
from matplotlib.collections import PathCollection
from matplotlib.lines import Line2D

from fiv_cli.case.case import FigureSpec
from fiv_cli.cli.main import run as fiv
from fiv_cli.errors import UsageError
from fiv_cli.plots import draw, draw_laws, look_of
from fiv_cli.plots.drawn import COLUMNS, DECORATION, as_csv
from fiv_cli.reading.datasets import class_names

REST_ABOVE = "periodic below, equilibrium above"


def figure(kind, **settings):
    return FigureSpec(kind, kind, settings)


SHOWN = ("near", "far", "far, values where undecided")


def table(drawn):
    return list(csv.DictReader(io.StringIO(as_csv(drawn, Path("a.csv")))))


def points(rows, series):
    """Of one series, shape (n, 2)."""
    return np.array([(row["x"], row["y"]) for row in rows if row["series"] == series], float)


def test_a_diagram_has_a_row_for_each_value_at_the_section_and_for_each_point_at_rest():
    found = data.bifurcation()
    found["phi_max"] = 0.01 * found["Omega"] + 0.0 * found["L_s"]
    rows = table(draw(found, figure("bifurcation")))
    at_rest = found["Omega"].values[30:]
    told = points(rows, "near, at rest")
    np.testing.assert_array_equal(told, np.stack([at_rest, 0.01 * at_rest], axis=1))
    values = [row["y"] for row in rows if row["series"] in SHOWN]
    assert sorted(map(float, values)) == sorted(found["section_value"].values.tolist())
    (failed,) = [row for row in rows if row["series"].startswith("failed")]
    assert (float(failed["x"]), failed["y"]) == (found["Omega"].values[20], "nan")
    assert {(row["x_axis"], row["y_axis"]) for row in rows} == {
        ("disc speed Omega (rad/s)", "varphi at the section (rad)")
    }


def test_lines_at_a_level_of_a_map_are_told_and_a_plane_without_is_not():
    """L_s is 1e-5 Omega N0 where there is stick-slip."""
    found = data.stability_map(initial=("reached",), nx=96, ny=97)
    levels = {"variable": "L_s", "level": {"L_s": 1e-3}}
    for overlay in (False, True):
        rows = table(draw(found, figure("map", overlay=overlay, **levels)))
        x, y = points(rows, "L_s = 0.001 rad^2").T
        known = x < 0.09 * y  # away from where stick-slip ends
        assert (x * y)[known] == pytest.approx(np.full(known.sum(), 100.0), rel=0.02)
        assert known.sum() > 20
    with pytest.raises(UsageError, match="this figure is a plane"):
        table(draw(found, figure("map", variable="L_s")))


@pytest.mark.parametrize("style", ["screen", "paper"])
def test_a_table_names_the_parameters_with_their_values_and_the_start(style):
    """Those of a line in its series, those of all in the title, also of a figure without one."""
    found = data.stability_map(nx=2).isel(N0=slice(0, 30))
    asked = figure("curve", x="N0", variable="L_s", select={"initial": "reached"})
    rows = table(draw(found, asked, look=look_of(style)))
    assert {row["figure"] for row in rows} == {"A sweep (Figure 7.6); start: reached"}
    assert {row["series"].partition(",")[0] for row in rows if row["y"] != "nan"} == {
        "Omega = 0.5 rad/s", "Omega = 10 rad/s",
    }  # fmt: skip
    one = figure("curve", variable="L_s", select={"initial": "exists", "Omega": 10.0})
    (title,) = {row["figure"] for row in table(draw(found, one, look=look_of(style)))}
    assert "start: exists" in title and "Omega = 10 rad/s" in title


def test_lines_are_counted_and_a_gap_ends_one():
    found = data.eigenvalues()
    rows = table(draw(found, figure("eigenvalues")))
    top = [row for row in rows if row["y_axis"].startswith("real part")]
    first = [row for row in top if row["series"] == "mode 1"]
    by_line = [[row for row in first if row["line"] == line] for line in ("1", "2")]
    assert [len(part) for part in by_line] == [7, found.sizes["mu_k"] - 8]  # the eighth has failed
    joined = points(top, "mode 1")
    known = np.isfinite(found["eigenvalue_real"].values[:, 0])
    np.testing.assert_array_equal(joined[:, 0], found["mu_k"].values[known])
    np.testing.assert_array_equal(joined[:, 1], found["eigenvalue_real"].values[known, 0])
    assert {row["x_axis"] for row in top} == {row["x_axis"] for row in rows}  # which panels share


def test_error_bars_are_told_by_their_ends():
    found = data.boundaries()
    rows = table(draw(found, figure("curve")))
    told = points(rows, f"{REST_ABOVE}, error bar")
    np.testing.assert_allclose(told, [[20, 3.9], [20, 4.1], [30, 6.8], [30, 7.2]])
    assert points(rows, REST_ABOVE).tolist() == [[20, 4], [30, 7]]


def test_values_that_are_classes_are_told_in_words():
    found = data.bifurcation()
    rows = table(draw(found, figure("curve", variable="attractor")))
    for number, start in enumerate(("near", "far")):
        told = {float(row["x"]): row["y"] for row in rows if row["series"] == start}
        classes = class_names(found["attractor"]).reshape(-1, 2)[:, number]
        classes = dict(zip(found["Omega"].values, classes, strict=True))
        assert told == {x: name for x, name in classes.items() if name != "not_computed"}


def test_every_member_of_random_starts_has_its_points_though_the_legend_has_one_entry():
    found = data.bifurcation().assign_coords(initial=["any-000", "any-001"])
    rows = table(draw(found, figure("bifurcation")))
    told = [points(rows, series) for series in ("any", "any, values where undecided")]
    assert sum(map(len, told)) == found.sizes["section_obs"]


def test_a_scatter_of_starts_and_the_phase_portrait_of_a_motion():
    found = data.basin()
    rows = table(draw(found, figure("basin")))
    starts = found["initial_state"].values.reshape(-1, 2)
    told = np.array([(row["x"], row["y"]) for row in rows], float)
    assert sorted(told.tolist()) == sorted(starts.tolist())
    starts = {
        start: tuple(place) for start, place in zip(found["initial"].values, starts, strict=False)
    }
    first = [row for row in rows if row["panel"] == "Omega = 1 rad/s"]
    assert {row["start"]: (float(row["x"]), float(row["y"])) for row in first} == starts
    assert {row["panel"] for row in rows} == {"Omega = 1 rad/s", "Omega = 2 rad/s"}
    one = table(draw(found, figure("basin", select={"Omega": 2.0})))
    assert {(row["panel"], row["series"]) for row in one} == {("", "equilibrium"), ("", "periodic")}
    rows = table(draw(data.history(labels=("far",)), figure("phase")))
    assert {row["series"].rpartition(", ")[2] for row in rows} >= {"slip+", "stick", "start"}


def test_of_a_law_both_branches_and_what_it_holds_in_stick():
    rows = table(draw_laws(["coulomb:mu_k=0.25,mu_s=0.5"]))
    (name,) = {row["series"] for row in rows if "held" not in row["series"]}
    sliding = points(rows, name)
    assert {(-1.0, -0.25), (1.0, 0.25)} == {(np.sign(v), round(f, 12)) for v, f in sliding}
    np.testing.assert_array_equal(points(rows, f"{name}, held in stick"), [[0, -0.5], [0, 0.5]])


@pytest.mark.parametrize(
    ("dataset", "kind"),
    [
        (data.bifurcation(), "bifurcation"),
        (data.bifurcation(), "curve"),
        (data.crossings(), "curve"),
        (data.boundaries(), "curve"),
        (data.eigenvalues(), "eigenvalues"),
        (data.history(), "history"),
        (data.basin(), "basin"),
    ],
)
def test_every_point_that_is_drawn_has_a_row(dataset, kind):
    drawn = draw(dataset, figure(kind))
    told = [row for row in table(drawn) if row["y"] != "nan"]
    rows = [row for row in told if not row["series"].endswith("error bar")]
    assert len(rows) == sum(map(len, shown(drawn)))


def shown(drawn):
    """The known points of marks and lines, each of shape (n, 2); of a mark upright, none."""
    for artist in drawn.findobj(lambda one: isinstance(one, Line2D | PathCollection)):
        if (
            artist.axes is None
            or artist.get_label() == DECORATION
            or artist not in artist.axes.get_children()
        ):
            continue
        line = isinstance(artist, Line2D)
        if line and artist.get_transform() != artist.axes.transData:
            continue
        xy = np.array(artist.get_xydata() if line else artist.get_offsets(), float)
        yield xy[np.isfinite(xy).all(axis=1)]


def test_a_plane_has_no_such_table():
    with pytest.raises(UsageError, match=r"a\.csv: not written: .*\nnext: .* --csv VARIABLE"):
        table(draw(data.stability_map(), figure("map")))


def test_plot_writes_the_table(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    data.bifurcation().to_netcdf("a.nc")
    assert fiv(["plot", "a.nc", "--figure", "bifurcation", "-o", "b/a.csv"]) == 0
    assert capsys.readouterr().out == "b/a.csv\n"
    header, first, *_ = (tmp_path / "b/a.csv").read_text().splitlines()
    assert header == ",".join(COLUMNS)
    assert len(first.split(",")) == len(COLUMNS)
    asked = data.attributes(figure("map"), figure("curve"))
    data.stability_map().assign_attrs(asked).to_netcdf("b.nc")
    assert fiv(["plot", "b.nc", "-o", "b.csv"]) == 2
    told = capsys.readouterr()
    assert told.out == "b-curve.csv\n"
    assert "b-map.csv: not written" in told.err
    assert fiv(["plot", "a.nc", "--figure", "bifurcation", "-o", "a.txt"]) == 2
    assert "use -o a.png, or, for the numbers that it draws, a.csv" in capsys.readouterr().err


def test_files_are_called_as_they_are_labelled(tmp_path, monkeypatch):
    """In a table as in a legend, whatever they differ in."""
    monkeypatch.chdir(tmp_path)
    for name, law in (("a", "coulomb"), ("b", "stribeck")):
        data.bifurcation().assign_attrs(law=law).to_netcdf(f"{name}.nc")
    for labels, names in ((["one", "far out"], ["one", "far out"]), ([], ["coulomb", "stribeck"])):
        asked = [part for label in labels for part in ("--label", label)]
        assert fiv(["plot", "a.nc", "b.nc", "--figure", "curve", *asked, "-o", "c.csv"]) == 0
        series = {row.split(",")[4] for row in Path("c.csv").read_text().splitlines()[1:]}
        assert all(any(name in one for one in series) for name in names)
    twice = ["plot", "a.nc", "a.nc", "--label", "one", "--label", "two"]  # each in its place
    assert fiv([*twice, "--figure", "curve", "-o", "c.csv"]) == 0
    assert all(f"{label}, far" in Path("c.csv").read_text() for label in ("one", "two"))


def test_a_table_of_the_lines_of_a_map_says_that_it_is_of_these_alone(
    tmp_path, monkeypatch, capsys
):
    monkeypatch.chdir(tmp_path)
    asked = {"name": "m", "kind": "map", "settings": {"variable": "L_s", "level": 1e-3}}
    data.stability_map().assign_attrs(figures_json=json.dumps([asked])).to_netcdf("a.nc")
    assert fiv(["plot", "a.nc", "--figure", "m", "-o", "m.csv", "-o", "m.png"]) == 0
    (told,) = [line for line in capsys.readouterr().err.splitlines() if "m.csv" in line]
    assert "the map itself: fiv show FILE.nc --csv" in told


def test_several_outputs_are_those_of_each_alone(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    data.bifurcation().to_netcdf("a.nc")
    asked = ["plot", "a.nc", "--figure", "bifurcation", "--style", "paper"]
    names = ["a.pdf", "a.csv", "a.png"]
    assert fiv([*asked, *(part for name in names for part in ("-o", name))]) == 0
    assert capsys.readouterr().out.split() == names
    for name in names:
        assert fiv([*asked, "-o", f"alone-{name}"]) == 0
        assert (tmp_path / name).read_bytes() == (tmp_path / f"alone-{name}").read_bytes()
    capsys.readouterr()
    assert fiv([*asked, "--figure", "curve", "-o", "b.png"]) == 0
    assert capsys.readouterr().out.split() == ["b-a-bifurcation.png", "b-a-curve.png"]
