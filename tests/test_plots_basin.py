"""Basins, drawn from small datasets, and shares."""

import csv
import io
import json
import re
from itertools import combinations
from pathlib import Path

import numpy as np
import pytest
import synthetic_datasets as data
import xarray as xr
from click.testing import CliRunner
from matplotlib.collections import LineCollection, PolyCollection
from matplotlib.colors import to_hex
from matplotlib.lines import Line2D
from matplotlib.text import Text
from plotted import figure, legend_texts, marks

from fiv_cli.cli.plot import command as plot_command
from fiv_cli.cli.show import command as show_command
from fiv_cli.errors import EmptyFigureError, UsageError
from fiv_cli.flags import COMPUTED
from fiv_cli.plots import default_figures, draw, look_of, style
from fiv_cli.plots.curve_lines import _narrowed
from fiv_cli.plots.drawn import as_csv
from fiv_cli.plots.style import class_colours
from fiv_cli.reading import shares
from fiv_cli.reading.datasets import class_names, flag_names, is_class
from fiv_cli.reading.summary import lines as summary_lines
from fiv_cli.reading.summary import summarise


def test_a_basin_has_every_start_at_its_place_in_the_colour_of_what_it_reaches():
    dataset = data.basin()
    one, two = draw(dataset, figure("basin")).axes
    for ax, radius in ((one, 1.0), (two, 2.0)):
        rest, moving = (marks_of.get_offsets() for marks_of in ax.collections)
        assert len(rest) + len(moving) == 200
        assert np.hypot(*rest.T).max() < radius < np.hypot(*moving.T).min()
    colours = [to_hex(marks_of.get_facecolor()[0]) for marks_of in two.collections]
    assert colours == [c.lower() for c in class_colours(["equilibrium", "periodic"])]
    assert two.get_xlabel() == "initial $x$ (m)"
    assert one.get_ylabel() == r"initial $\dot{x}$ (m/s)"


def test_a_basin_takes_every_point_of_a_lattice_as_a_start():
    x, x_dot = np.linspace(-1.0, 1.0, 5), np.linspace(0.0, 2.0, 3)
    coords = data.axes(Omega=[1.0, 2.0], initial_x=x, initial_x_dot=x_dot, initial=["at"])
    inside = np.hypot(x[:, None], x_dot) < np.array([0.9, 1.9])[:, None, None]
    reached = np.where(inside, "equilibrium", "periodic").astype(object)[..., None]
    dataset = data.response(reached, np.zeros(reached.shape), coords)
    starts = np.stack(np.broadcast_arrays(x[:, None], x_dot), -1)[None, ..., None, :]
    dataset["initial_state"] = ((*coords, "state"), np.repeat(starts, 2, 0), {"units": "1"})
    units = ("state", ["m", "m s-1"])
    dataset = dataset.assign_coords(state=["x", "x_dot"], state_units=units)
    drawn = draw(dataset, figure("basin"))
    for ax, radius in zip(drawn.axes, (0.9, 1.9), strict=True):
        rest, moving = (marks_of.get_offsets() for marks_of in ax.collections)
        assert len(rest) + len(moving) == 15
        assert np.hypot(*rest.T).max() < radius < np.hypot(*moving.T).min()
    assert "equilibrium 20.0 % (3 of 15)" in drawn.axes[0].get_title()
    assert "standard error" not in " ".join(legend_texts(drawn))


def _refined_lattice(count=81, shift=0.0):
    """Every fourth start of a lattice was run; of the others the class alone is known."""
    x = np.linspace(-1.0, 1.0, count)
    coords = data.axes(initial_x=x, initial_x_dot=x, initial=["at"])
    reached = np.where(np.hypot(x[:, None], x) < 0.5, "equilibrium", "periodic")[..., None]
    dataset = data.response(reached.astype(object), np.zeros(reached.shape), coords)
    ran = np.zeros(reached.shape, bool)
    ran[::4, ::4] = True
    made = np.where(ran, "run", "filled_in")
    dataset["computed"] = data.flags([*coords], made, ("run", "sampled", "filled_in"))
    starts = np.stack(np.broadcast_arrays(x[:, None] + shift, x), -1)[..., None, :]
    dataset["initial_state"] = ((*coords, "state"), np.where(ran[..., None], starts, np.nan))
    for name in ("L_s", "x_max", "x_dot_max"):
        dataset[name] = dataset["L_s"].where(ran)
    units = ("state", ["m", "m s-1"])
    dataset = dataset.assign_coords(state=["x", "x_dot"], state_units=units)
    return dataset.assign_attrs(refined_of="attractor", starts_json='{"at": "state"}')


@pytest.mark.parametrize("shift", [0.0, 1.0 / 3.0])  # starts off a rest lie off their axes
def test_a_basin_of_a_refined_lattice_has_a_cell_at_every_point(shift):
    drawn = draw(_refined_lattice(shift=shift), figure("basin", x="initial.x", y="x_dot"))
    (ax,) = drawn.axes
    rest, moving = (one for one in ax.collections if isinstance(one, PolyCollection))
    assert len(rest.get_paths()) + len(moving.get_paths()) == 81 * 81
    middles = [
        np.array([path.vertices[:4].mean(axis=0) for path in one.get_paths()]) - (shift, 0.0)
        for one in (rest, moving)
    ]
    assert np.hypot(*middles[0].T).max() < 0.5 <= np.hypot(*middles[1].T).min() + 1e-9
    (star,) = [line for line in ax.lines if line.get_label() == "where they rest"]
    assert star.get_xydata().tolist() == [[0.0, 0.0]]
    assert "6.7% of 6561 points run" in drawn.get_suptitle()
    partial = _refined_lattice(shift=shift).assign_attrs(partial="441 of 6561 points")
    told = draw(partial, figure("basin", x="initial.x", y="x_dot")).get_suptitle()
    assert "441 points run so far" in told and "%" not in told


@pytest.mark.parametrize(("count", "filled"), [(9, False), (41, True)])
def test_a_lattice_of_many_starts_is_filled_in_flat_panels_too(count, filled):
    """Marks as large as the smaller step would be stripes along it."""
    one = _refined_lattice(count)
    one["computed"] *= 0  # all of them were run
    one["computed"].attrs = _refined_lattice(count)["computed"].attrs
    every = [one.assign_coords(Omega=float(n)).expand_dims("Omega") for n in range(4)]
    drawn = draw(
        xr.concat(every, "Omega", data_vars="all").transpose(..., "state"), figure("basin")
    )
    for ax in drawn.axes:
        assert any(isinstance(cells, PolyCollection) for cells in ax.collections) == filled


def test_a_panel_of_a_basin_of_which_no_point_was_run_has_cells_too():
    dataset = _refined_lattice()
    other = dataset.assign({n: dataset[n].where(False) for n in ("initial_state", "L_s")})
    other["computed"] = other["computed"].where(False, 2).assign_attrs(dataset["computed"].attrs)
    drawn = draw(
        xr.concat([dataset, other], xr.Variable("Omega", [1.0, 2.0])).transpose(..., "state"),
        figure("basin"),
    )
    for ax in drawn.axes:
        cells = [one for one in ax.collections if isinstance(one, PolyCollection)]
        assert sum(len(one.get_paths()) for one in cells) == 81 * 81


def test_a_basin_of_a_refined_lattice_does_not_tell_cycles_apart():
    """Which of them a start reaches that was filled in is not known."""
    dataset = _refined_lattice()
    dataset["L_s"] = xr.where(dataset["initial_x"] > 0.0, 1.0, 2.0).where(dataset["L_s"].notnull())
    told = legend_texts(draw(dataset.transpose(..., "state"), figure("basin")))
    assert [word.split()[0] for word in told] == ["equilibrium", "periodic", "where"]


def test_a_basin_tells_cycles_of_one_class_apart_by_their_periods():
    """As L_s does; what is one motion to its errors is one."""
    dataset = data.basin(speeds=(1.0,))
    large = (dataset["initial_state"].sel(state="x") > 0.0).transpose(*dataset["status"].dims)
    dataset["L_s"] = dataset["L_s"].copy(data=np.where(large, 2.0, 1.0 + 1e-9 * np.arange(200)))
    dataset["period"] = dataset["L_s"].copy(data=np.where(large, 0.5, 2.0)).assign_attrs(units="s")
    dataset = dataset.assign_attrs(solver_json='{"rtol": 1e-9}', starts_json='{"any": "table"}')
    (ax,) = draw(dataset, figure("basin")).axes
    told = legend_texts(ax.figure)
    (long, short) = (next(one for one in told if f"$T$ = {t} s" in one) for t in ("2", "0.5"))
    counts = [int(one.rpartition(" of ")[0].rpartition("(")[2]) for one in (long, short)]
    cycle = dataset["attractor"].isel(Omega=0) == dataset["attractor"].max()
    assert counts == [int((cycle & (~large if n == 0 else large)).sum()) for n in (0, 1)]
    dataset["L_s"] = dataset["L_s"] * 0.0 + 1.0
    assert not [one for one in legend_texts(draw(dataset, figure("basin"))) if "$T$" in one]


def test_a_cycle_has_one_mark_in_all_panels_of_a_basin():
    """By its size: its period is another in each."""
    dataset = data.basin()
    lower = dataset["initial_state"].sel(state="x") < 0.0
    dataset["L_s"] = dataset["L_s"].copy(data=np.where(lower, 0.5, 1.5))
    dataset["L_s"][1] = xr.where(lower[1], 0.7, 0.5)  # which of them is the smaller changes
    dataset["period"] = dataset["L_s"].where(is_class(dataset["attractor"], ("periodic",)))
    drawn = draw(dataset, figure("basin"))
    legend = legend_texts(drawn)
    assert [one for one in legend if "cycle" in one] == ["cycle 1", "cycle 2"]
    narrow = draw(dataset, figure("basin"), look=look_of("paper", width=84.0)).legends[0]
    assert "\n" in narrow.get_title().get_text()  # a long heading takes no column from the keys
    assert narrow._ncols > 1
    looks = [
        {starts.get_label(): to_hex(starts.get_facecolor()[0]) for starts in ax.collections}
        for ax in drawn.axes
    ]
    assert looks[0] == looks[1] and len(looks[0]) == 3
    x = [{s.get_label(): s.get_offsets()[:, 0].max() for s in ax.collections} for ax in drawn.axes]
    assert [one["cycle 1"] < 0.0 for one in x] == [True, False]


def test_a_basin_shows_where_its_motions_rest():
    dataset = data.basin(speeds=(2.0,))
    everywhere = xr.zeros_like(dataset["status"], float)
    rest = {"x_max": everywhere + 0.03, "x_dot_max": everywhere}
    (ax,) = draw(dataset.assign(rest), figure("basin")).axes
    star, *_ = ax.lines  # each place once, and the starts beneath are seen
    np.testing.assert_array_equal(star.get_xydata(), [[0.03, 0.0]])
    assert star.get_markerfacecolor() == "none"
    (key,) = [key for key in ax.figure.legends[0].legend_handles if isinstance(key, Line2D)]
    assert key.get_markersize() == star.get_markersize()
    (ax,) = draw(data.basin(speeds=(0.0,)), figure("basin")).axes
    assert "where they rest" not in legend_texts(ax)


def _motion_in_x(speed=2.0):
    names = {"phi": "x", "phi_dot": "x_dot"}
    return data.history(labels=("far",)).rename(names).assign_coords(Omega=speed)


def _lines_over(ax):
    return {one.get_label(): one for one in ax.collections if isinstance(one, LineCollection)}


def test_a_dashed_motion_over_basins_is_drawn_once_around():
    names = {"phi": "x", "phi_dot": "x_dot"}
    long = data.history(labels=("far",), t_end=6.0 * np.pi / 9.0, sample=0.002).rename(names)
    layers = [(name, long.assign_coords(Omega=2.0)) for name in ("one", "two")]
    _, ax = draw([("", data.basin()), *layers], figure("basin")).axes
    solid, dashed = (
        sum(len(piece) for piece in _lines_over(ax)[name].get_segments()) for name in ("one", "two")
    )
    assert solid == pytest.approx(3 * dashed, rel=0.02)


@pytest.mark.parametrize("turned", [False, True])
def test_a_motion_lies_over_the_basins_at_its_parameters(turned):
    """As its phase portrait has it, with what is between two of its contact states."""
    layers = [("", data.basin()), ("cycle", _motion_in_x())]
    one, two = draw(layers[::-1] if turned else layers, figure("basin")).axes
    assert not _lines_over(one)
    (path,) = _lines_over(two)["cycle"].get_segments()
    assert legend_texts(two).count("cycle") == 1
    (portrait,) = draw(_motion_in_x(), figure("phase")).axes
    pieces = [p for lines in portrait.collections for p in lines.get_segments()]
    assert {*map(tuple, np.concatenate(pieces))} <= {*map(tuple, path)}
    assert {float(v) for v in path[[0, -1], 0]} == {*_motion_in_x()["x"].values[0, [0, -1]]}


def test_a_motion_lies_over_a_single_basin_and_tells_where_its_parameters_are_others():
    of_cycle = _motion_in_x(2.0).assign_attrs(steady_state="unstable cycle")
    settled = _motion_in_x(2.0).assign_attrs(steady_state="periodic")
    words = (
        (_motion_in_x(2.0), "motion"),
        (of_cycle, "unstable cycle"),
        (settled, "cycle"),
        (settled.assign_attrs(steady_state="quasiperiodic"), "motion"),
    )
    for one, word in words:
        (ax,) = draw([("", data.basin(speeds=(1.0,))), ("", one)], figure("basin")).axes
        told = "of other parameters: $\\Omega$ = 2"
        assert [*_lines_over(ax)] == [f"{word}, {told}"] and told in style.notes_on(ax.figure)[0]
        (ax,) = draw([("", data.basin(speeds=(2.0,))), ("", one)], figure("basin")).axes
        assert [*_lines_over(ax)] == [word] and not style.notes_on(ax.figure)


def test_cycles_of_two_files_are_called_by_what_they_are_where_that_tells_them_apart():
    layers = [(name, _motion_in_x().assign_attrs(steady_state=f"{name} cycle", called=""))
              for name in ("unstable", "stable")]  # fmt: skip
    (ax,) = draw([("", data.basin(speeds=(2.0,))), *layers], figure("basin")).axes
    assert {*_lines_over(ax)} == {"unstable cycle", "stable cycle"}
    gaps = {name: one.get_linestyle()[0][1] for name, one in _lines_over(ax).items()}
    assert gaps["stable cycle"] is None and gaps["unstable cycle"]  # whichever file comes first
    layers[1] = ("other", layers[0][1])
    (ax,) = draw([("", data.basin(speeds=(2.0,))), *layers], figure("basin")).axes
    assert {*_lines_over(ax)} == {"unstable cycle: unstable", "unstable cycle: other"}


def test_all_classes_have_a_colon_where_words_of_ones_own_hold_a_number():
    words = {"periodic": "stick-slip on belt 1"}
    (ax,) = draw(data.basin(speeds=(1.0,)), figure("basin", words=words)).axes
    told = [text for text in legend_texts(ax) if text.startswith(("stick-slip", "equilibrium"))]
    assert len(told) == 2 and all(": " in text for text in told), told


def test_a_motion_at_the_parameters_of_no_basin_is_refused():
    with pytest.raises(
        UsageError, match=r"no panel .*\n.*Omega = 1 rad/s; Omega = 2 rad/s\nnext: "
    ):
        draw([("", data.basin()), ("", _motion_in_x(3.0))], figure("basin"))
    with pytest.raises(UsageError, match=r"x: no variable over time"):
        draw([("", data.basin()), ("", data.history(labels=("far",)))], figure("basin"))


def test_a_file_without_a_motion_is_not_laid_over_basins():
    cycle = data.response("periodic", 1.0, {}).assign(cycle_section=("state", [1.0, 0.0]))
    with pytest.raises(UsageError, match=r"no motion in time.*\nnext: fiv history.*cycle_section"):
        draw([("", data.basin()), ("", cycle)], figure("basin"))
    with pytest.raises(UsageError, match="shows one dataset"):
        draw([("", data.basin()), ("", data.basin())], figure("basin"))


def test_motions_of_further_files_lie_over_each_file_of_basins(tmp_path):
    files = {"a": data.basin(), "b": data.basin(speeds=(2.0,)), "m": _motion_in_x()}
    for name, dataset in files.items():
        dataset.to_netcdf(tmp_path / f"{name}.nc")
    paths = [str(tmp_path / f"{name}.nc") for name in ("m", "a", "b")]
    told = CliRunner().invoke(
        plot_command, [*paths, "--figure", "basin", "-o", str(tmp_path / "c.csv")]
    )
    assert told.exit_code == 0, told.output
    for name in ("a", "b"):
        (rows,) = (path.read_text().splitlines() for path in tmp_path.glob(f"c-{name}-*.csv"))
        assert sum(",motion," in row for row in rows) > 800
    named = ["--label", "cycle", "--label", "basins", "--label", "others"]
    told = CliRunner().invoke(
        plot_command, [*paths, "--figure", "basin", "-o", str(tmp_path / "c.csv"), *named]
    )
    assert told.exit_code == 0 and "--label" not in told.stderr  # of basins a title tells


def test_a_file_that_gives_nothing_to_figures_is_told(tmp_path):
    point = data.response("periodic", 1.0, {}).assign_coords(mu_k=0.2)
    point = point.assign(cycle_section=("state", [1.0, 0.0]))
    for name, dataset in (("a", data.basin()), ("b", point)):
        dataset.to_netcdf(tmp_path / f"{name}.nc")
    paths = [str(tmp_path / f"{name}.nc") for name in ("a", "b")]
    told = CliRunner().invoke(plot_command, [*paths, "-o", str(tmp_path / "c.png")])
    assert told.exit_code == 0
    assert f"{paths[1]}: left out: a single point" in told.stderr
    assert "--figure basin" in told.stderr and "cycle_section" in told.stderr


def test_a_dashed_motion_is_drawn_once_around():
    """Else the dashes of its further periods would fill their gaps; a solid one has them all."""
    motions = data.history(t_end=6.0 * np.pi / 9.0, sample=0.002)  # three periods
    (ax,) = draw(motions, figure("phase", overlay=True)).axes
    ways = {str(lines.get_linestyle()[0][1]): 0.0 for lines in ax.findobj(LineCollection)}
    for lines in ax.findobj(LineCollection):
        pieces = [np.diff(one, axis=0) / [0.01, 0.09] for one in lines.get_segments()]
        length = sum(np.linalg.norm(one, axis=1).sum() for one in pieces)
        ways[str(lines.get_linestyle()[0][1])] += length
    solid, dashed = (ways[key] for key in sorted(ways, key=lambda one: one != "None"))
    assert solid == pytest.approx(6.0 * np.pi, rel=0.01)  # of radius 1
    assert dashed == pytest.approx(0.3 * 2.0 * np.pi, rel=0.01)


def test_many_basins_fit_a_column_of_a_page():
    six = data.basin(speeds=(0.5, 1.0, 1.5, 2.0, 2.5, 3.0))
    drawn = draw(six, figure("basin"), look=look_of("paper", width=84.0))
    drawn.canvas.draw()
    assert drawn.get_figheight() < 240.0 / 25.4
    (legend,) = drawn.legends
    boxes = [ax.title.get_window_extent() for ax in drawn.axes] + [legend.get_window_extent()]
    assert not any(one.overlaps(other) for one, other in combinations(boxes, 2))
    assert all(box.x0 >= 0.0 and box.x1 <= drawn.bbox.x1 for box in boxes)


def test_a_class_has_one_mark_in_all_panels_of_a_basin():
    moving, both = (
        {c.get_label(): len(c.get_paths()[0].vertices) for c in ax.collections}
        for ax in draw(data.basin(speeds=(0.0, 1.0)), figure("basin")).axes
    )
    assert len(moving) == 1 and moving["periodic"] == both["periodic"] != both["equilibrium"]


def test_shares_of_a_basin_have_the_standard_error_of_a_random_sample():
    """A circle of radius 2 in a square of side 6: the share is known, the error covers it."""
    drawn = draw(data.basin(), figure("basin"))
    shares = drawn.axes[1].get_title().split("\n")[1:]
    share, error = (float(w) for w in shares[0].split()[1::2])
    assert [words.split()[0] for words in shares] == ["equilibrium", "periodic"]
    told = "shares of the starts above each panel ± standard error"
    assert drawn.legends[0].get_title().get_text() == told
    drawn = draw(data.basin(), figure("basin", select={"Omega": 2.0}))
    assert drawn.axes[0].get_title() == ""  # of one panel the legend says it
    assert legend_texts(drawn) == shares
    assert error == pytest.approx(np.sqrt(share * (1 - share) / 200), abs=6e-4)
    assert abs(share - np.pi / 9.0) < 3 * error
    assert legend_texts(draw(data.basin(speeds=(9.0,)), figure("basin"))) == [
        "equilibrium (all 200)"
    ]


def test_a_share_that_leaps_is_not_drawn_as_a_decline():
    """Where the attractor ends; what falls from point to point is one line."""
    count, speeds = 40, np.linspace(1.0, 2.0, 9)
    starts = [f"any-{n:03d}" for n in range(count)]
    take = {"what": "share", "of": "periodic", "over": ["initial"]}
    gradual = np.r_[40, 40, 40, 38, 38, 36, 30, 30, 24]
    for kept, leaps in (
        (np.r_[[36] * 5, [0] * 4], True),
        (np.arange(36, 0, -4), False),
        (gradual, False),
        (40 - gradual, False),
        (np.r_[[40] * 5, [0] * 4], True),
        (np.r_[[28] * 5, [0] * 4], True),
    ):
        classes = np.where(np.arange(count) < kept[:, None], "periodic", "equilibrium")
        axes = data.axes(v=speeds, initial=starts)
        found = data.response(classes.astype(object), np.ones(classes.shape), axes)
        found = found.assign_attrs(starts_json='{"any": "random"}')
        told = style.notes_on(draw(found, figure("curve", variable="attractor", take=take)))
        assert any("not joined" in one for one in told) == leaps


def test_shares_of_a_lattice_of_starts_have_no_standard_error():
    lattice = data.basin().assign_attrs(starts_json=json.dumps({"any": "grid"}))
    drawn = draw(lattice, figure("basin"))
    assert not [text for text in drawn.findobj(Text) if re.search("±|error", text.get_text())]
    reached = class_names(lattice["attractor"][0])
    assert f"({(reached == 'periodic').sum()} of 200)" in drawn.axes[0].get_title()


def test_of_a_difference_what_was_filled_in_is_not_said_to_be_undecided():
    found = data.stability_map(nx=4, ny=3)
    filled = np.zeros(found["attractor"].shape, bool)
    filled[1:3, 1] = True
    found["L_s"] = found["L_s"].where(~filled)
    codes = np.where(filled, COMPUTED.codes["filled_in"], COMPUTED.codes["run"]).astype(np.int8)
    table = COMPUTED.names
    words = {"flag_values": np.array([*table], np.int8), "flag_meanings": " ".join(table.values())}
    found["computed"] = (found["L_s"].dims, codes, words)
    found.attrs["refined_of"] = "attractor"
    taken = {"what": "difference", "over": ["initial"]}
    drawn = draw(found, figure("map", variable="L_s", take=taken))
    (missing,) = [text for text in legend_texts(drawn) if text.startswith("no value")]
    assert "filled in" in missing


def test_shares_of_a_table_of_many_starts_are_counted():
    """They were refused, and the legend had counts alone."""
    found = data.basin().assign_attrs(starts_json=json.dumps({"any": "table"}))
    reached = class_names(found["attractor"][0])
    share = float((reached == "periodic").mean())
    table = shares.as_csv(found)
    rows = list(csv.DictReader(io.StringIO(table)))
    ends = [int(row["starts"]) for row in rows if float(row["share"]) in (0.0, 1.0)]
    told = f"within {shares.most_missed(min(ends)):.2g} at 95%" if ends else ""
    assert shares.without_error(found).endswith(told)
    assert bool(shares.without_error(found)) == bool(ends)
    (own,) = [row for row in rows if row["class"] == "periodic" and float(row["Omega"]) == 1.0]
    assert float(own["share"]) == share and own["standard_error"] == ""
    title = draw(found, figure("basin")).axes[0].get_title()
    assert f"periodic {100 * share:.1f} % ({200 * share:.0f} of 200)" in title
    few = found.isel(initial=slice(9))
    with pytest.raises(UsageError, match="a table of 10 or more, or a lattice"):
        shares.as_csv(few)


@pytest.mark.parametrize(("kind", "bars"), [("random", 2), ("table", 0)])
def test_a_curve_of_shares_of_random_starts_has_their_standard_error(kind, bars):
    """At two speeds; a table of starts is no sample."""
    starts = json.dumps({"any": kind})
    over = {"what": "share", "of": "periodic", "over": ["initial"]}
    settings = {"x": "Omega", "variable": "attractor", "take": over}
    (ax,) = draw(data.basin().assign_attrs(starts_json=starts), figure("curve", **settings)).axes
    share = ax.lines[0].get_ydata()
    drawn = [bar[:, 1] for bars_ in ax.collections for bar in bars_.get_segments()]
    assert all(0.0 <= low <= high <= 1.0 for low, high in drawn)
    assert len(drawn) == bars == 2 * [*map(Line2D.get_label, ax.lines)].count("standard error")
    for (low, high), p in zip(drawn, share, strict=False):
        assert high - low == pytest.approx(2.0 * np.sqrt(p * (1.0 - p) / 200))


@pytest.mark.parametrize(("reached", "share"), [("periodic", 1.0), ("chaotic", 0.0)])
def test_the_share_of_what_all_of_a_sample_show_or_none_has_a_bound(reached, share):
    """Such that a share p beyond it shows that in one sample of n starts of twenty: p^n = 0.05."""
    found = data.basin().assign_attrs(starts_json=json.dumps({"any": "random"}))
    found["attractor"][0] = data.codes(data.ATTRACTORS, reached)
    over = {"what": "share", "of": "periodic", "over": ["initial"]}
    settings = {"x": "Omega", "variable": "attractor", "take": over}
    (ax,) = draw(found, figure("curve", **settings)).axes
    (first, _) = [bar[:, 1] for bars in ax.collections for bar in bars.get_segments()]
    missed = 1.0 - 0.05 ** (1.0 / found.sizes["initial"])
    assert first == pytest.approx([1.0 - missed, 1.0] if share else [0.0, missed])
    assert "standard error; at 0 and 1: 95% bound" in legend_texts(ax)


@pytest.mark.parametrize(("told", "undecided"), [(0, 1), (0, 9), (60, 20), (100, 100), (190, 10)])
def test_the_error_of_a_share_holds_those_of_all_that_its_undecided_starts_may_be(told, undecided):
    found = data.basin().assign_attrs(starts_json=json.dumps({"any": "random"}))
    count = found.sizes["initial"]
    reached = ["periodic"] * told + ["undecided"] * undecided
    reached += ["equilibrium"] * (count - len(reached))
    found["attractor"][0] = data.codes(data.ATTRACTORS, np.array(reached))
    over = {"what": "share", "of": "periodic", "over": ["initial"]}
    settings = {"x": "Omega", "variable": "attractor", "take": over}
    (ax,) = draw(found, figure("curve", **settings)).axes
    (bars,) = (own for own in ax.collections if str(own.get_label()).endswith("error bar"))
    low, high = bars.get_segments()[0][:, 1]
    missed = 1.0 - 0.05 ** (1.0 / count)
    shares = np.arange(told, told + undecided + 1) / count
    off = np.where(shares % 1.0 > 0.0, np.sqrt(shares * (1.0 - shares) / count), missed)
    least, greatest = (
        np.clip((shares - off).min(), 0.0, 1.0),
        np.clip((shares + off).max(), 0.0, 1.0),
    )
    assert low <= least + 1e-12 and greatest - 1e-12 <= high
    assert high - low <= 1.3 * (greatest - least)  # it is no wider than it must be, or little


def test_a_map_counts_the_filled_in_points_of_what_it_shows():
    """Not those of the panels that a selection leaves out."""
    grid = data.axes(N0=[1.0, 2.0], mu_k=[0.1, 0.2], Omega=[1.0, 2.0, 3.0])
    found = data.response(np.full((2, 2, 3), "periodic"), np.ones((2, 2, 3)), grid)
    codes = np.array([[[0, 1, 1], [1, 1, 1]], [[0, 0, 0], [2, 1, 1]]], np.int8)
    table = COMPUTED.names
    words_of = {
        "flag_values": np.array([*table], np.int8),
        "flag_meanings": " ".join(table.values()),
    }
    found["computed"] = (found["status"].dims, codes, words_of)
    found["L_s"] = found["L_s"].where(found["computed"] > 0)
    found = found.assign_attrs(refined_of="attractor", points_run=8, points_filled_in=4)
    chosen = {"x": "mu_k", "y": "Omega", "variable": "L_s", "select": {"N0": 2.0}}
    drawn = draw(found, figure("map", **chosen))
    (told,) = (text for text in legend_texts(drawn) if "filled in" in text)
    assert "3 filled in (the class alone)" in told
    assert "50.0% of 6 points run, 0 of 1 sampled mislabelled" in drawn.get_suptitle()
    take = {"what": "classes", "over": ["N0"]}  # which leaves no point that was run
    over = figure("map", x="mu_k", y="Omega", variable="attractor", take=take)
    assert "points run" not in draw(found, over).get_suptitle()


def test_a_table_holds_the_error_bars_that_are_known():
    """Of an undecided point the share may be anything: it has none."""
    over = {"what": "share", "of": "periodic", "over": ["initial"]}
    found = data.basin()
    codes = found["attractor"].values
    codes[0] = data.codes(data.ATTRACTORS, "undecided")
    settings = {"x": "Omega", "variable": "attractor", "take": over}
    rows = as_csv(draw(found, figure("curve", **settings)), Path("a.csv")).splitlines()
    assert sum("error bar" in row for row in rows) == 2


def test_a_dataset_without_the_axis_of_a_curve_lies_across_it():
    found = data.bifurcation()
    alone = found.isel(Omega=40, initial=1, drop=True)
    (ax,) = draw([("swept", found), ("alone", alone)], figure("curve", variable="L_s")).axes
    (level,) = (line for line in ax.lines if line.get_label() == "alone")
    assert level.get_xdata().tolist() == [0.5, 5.0]
    assert set(level.get_ydata()) == {alone["L_s"].item()}


def test_a_share_as_good_as_known_is_a_point_of_its_line():
    """One failed start of thousands: an error bar over what it leaves open."""
    y, error, ends = _narrowed(
        np.array([0.9, np.nan, np.nan]), np.zeros(3),
        [np.array([0.9, 0.8, 0.1]), np.array([0.9, 0.802, 0.5])],
    )  # fmt: skip
    np.testing.assert_allclose(y, [0.9, 0.801, np.nan])
    np.testing.assert_allclose(error, [0.0, 0.001, 0.0])
    np.testing.assert_allclose(ends, [[0.9, 0.801, 0.1], [0.9, 0.801, 0.5]])


def test_a_line_without_values_in_one_panel_is_that_of_the_others():
    found = data.bifurcation()
    found["phi_amplitude"] = found["L_s"].copy().assign_attrs(units="rad", long_name="half range")
    found["L_s"] = found["L_s"].where(found["initial"] == "far")
    drawn = draw(found, figure("curve", variable=["phi_amplitude", "L_s"]))
    told = [text for ax in drawn.axes for text in legend_texts(ax)]
    assert "near" in told and not [text for text in told if "no value" in text]


def test_a_share_between_two_has_an_error_beyond_both():
    """Of 20 random starts 10 are periodic, and 2 have no class: 0.5 to 0.6, and the error of 20."""
    classes = np.array([["periodic"] * 10 + ["undecided"] * 2 + ["equilibrium"] * 8], object)
    starts = [f"any-{n:03d}" for n in range(20)]
    axes = data.axes(Omega=np.array([1.0])) | {"initial": ("initial", starts)}
    points = data.response(classes, np.ones((1, 20)), axes)
    points = xr.concat([points, points.assign_coords(Omega=[2.0])], "Omega", data_vars="minimal")
    points = points.assign_attrs(starts_json=json.dumps({"any": "random"}))
    taking = {"what": "share", "of": "periodic", "over": ["initial"]}
    (ax,) = draw(points, figure("curve", variable="attractor", take=taking)).axes
    ends = [line[:, 1] for one in ax.collections for line in one.get_segments() if len(line)]
    error = np.sqrt(0.5 * 0.5 / 20)  # the greatest of what lies between
    assert np.isclose(ends, [0.5 - error, 0.6 + error]).all(axis=1).sum() == 2


def test_a_line_of_a_curve_without_any_value_is_said_to_have_none():
    found = data.bifurcation()
    found["L_s"] = found["L_s"].where(found["initial"] == "far")
    (ax,) = draw(found, figure("curve", variable="L_s")).axes
    assert "near: no value" in legend_texts(ax) and "far" in legend_texts(ax)
    printed = summary_lines(summarise({"": found}))
    (told,) = (line for line in printed if " L_s " in line)
    assert told.endswith(f" rad2 (at {found['L_s'].count().item()} of 92 points)")


def test_no_line_leads_from_one_motion_to_that_of_another_start():
    """Both have a class, and the same: that they meet, and what continues better, tells."""
    found = data.bifurcation()
    size = found["Omega"].values[:, None]
    low, high, leaves = 1.0 + size, 3.0 + size, size > 2.0
    found["L_s"] = found["L_s"].copy(
        data=np.where([False, True] & leaves, low, np.hstack([low, high]))
    )
    (periodic,) = (c for c, n in flag_names(found["attractor"].attrs).items() if n == "periodic")
    found["attractor"] = found["attractor"].copy(data=np.full_like(found["attractor"], periodic))
    (ax,) = draw(found, figure("curve", variable="L_s")).axes
    near, far = (marks(ax, label) for label in ("near", "far"))
    assert np.isfinite(near).all()
    cuts = np.flatnonzero(np.isnan(far[:, 0]))
    assert [far[cut - 1, 0] <= 2.0 < far[cut + 1, 0] for cut in cuts] == [True]


def test_no_error_of_a_share_reaches_beyond_0_and_1():
    """Of few that were decided, and some that were not."""
    found = data.bifurcation().rename(L_s="share")
    found["share"] = found["share"].copy(data=np.full(found["share"].shape, 0.01))
    found["standard_error"] = found["share"] * 5.0
    (ax,) = draw(found, figure("curve", variable="share")).axes
    bars = [line[:, 1] for bars in ax.collections for line in bars.get_segments() if len(line)]
    assert len(bars) > 0
    np.testing.assert_allclose(bars, [[0.0, 0.06]] * len(bars))


@pytest.mark.parametrize("name", ["L_s_error", "L_s_standard_error"])
def test_a_value_that_has_an_error_of_its_own_has_a_bar(name):
    found = data.bifurcation()
    found[name] = 0.1 * found["L_s"].where(found["L_s"] > 0.0)
    (ax,) = draw(found, figure("curve", variable="L_s")).axes
    (told,) = {"standard error" in legend_texts(ax), name == "L_s_standard_error"}
    bars = {line[0, 0]: line[:, 1] for line in ax.collections[1].get_segments() if len(line)}
    far = found["L_s"].sel(initial="far").dropna("Omega")
    assert bars.keys() == {*far["Omega"].values}
    np.testing.assert_allclose([*bars.values()], np.outer(far, [0.9, 1.1]))
    assert told == ("error not known" not in legend_texts(ax))


def test_shares_are_a_table(tmp_path):
    """Each class at each point; what all of a sample reach has no error."""
    dataset = data.basin(speeds=(1.0, 9.0)).assign_attrs(starts_json=json.dumps({"any": "random"}))
    dataset.to_netcdf(tmp_path / "a.nc")
    run = CliRunner().invoke(show_command, [str(tmp_path / "a.nc"), "--csv", "shares"])
    head, *rows = [line.split(",") for line in run.stdout.splitlines()]
    assert head == ["initial", "Omega", "class", "share", "standard_error", "starts"]
    assert [row[:3] for row in rows] == [
        ["any", speed, name] for name in ("equilibrium", "periodic") for speed in ("1.0", "9.0")
    ]
    share, error, count = map(float, rows[0][3:])
    assert error == pytest.approx(np.sqrt(share * (1.0 - share) / count))
    assert rows[1][3:] == ["1.0", "", "200"] and rows[3][3:] == ["0.0", "", "200"]
    with pytest.raises(UsageError, match="--csv and --json: one of them"):
        show_command.main(
            [str(tmp_path / "a.nc"), "--csv", "shares", "--json"], standalone_mode=False
        )
    data.bifurcation().to_netcdf(tmp_path / "b.nc")
    with pytest.raises(UsageError, match="no starts here of which shares would be told"):
        CliRunner().invoke(
            show_command, [str(tmp_path / "b.nc"), "--csv", "shares"], catch_exceptions=False
        )


@pytest.mark.parametrize(("kind", "told"), [("random", 1), ("table", 0)])
def test_show_tells_the_shares_of_random_starts_with_their_standard_errors(kind, told):
    starts = json.dumps({"any": kind})
    dataset = data.basin(speeds=(1.0, 2.0, 9.0)).assign_attrs(starts_json=starts)
    printed = [line for line in summary_lines(summarise({"": dataset})) if "shares" in line]
    assert len(printed) == 2
    if not told:  # each of a table counts alike
        assert "±" not in "".join(printed) and " all of " not in printed[0]
    else:
        rest, moving = re.findall(r" (?:equilibrium|periodic) ([^,;]*)", printed[0])
        assert rest.endswith(" (all of 200: at least 0.985 at 95%)")  # 0.985 ** 200 is 0.05
        rest, none = rest.split(" (")[0], " (none of 200: at most 0.01 at 95%)"
        assert none in moving
        moving = moving.replace(none, "")
        one, error = map(float, rest.split(" to ")[0].split(" ± "))
        assert abs(one - np.pi / 36.0) < 3 * error and rest.endswith(" to 1")
        assert error == pytest.approx(np.sqrt(one * (1 - one) / 200), rel=0.05)
        assert moving == f"0 to {1 - one:.3f} ± {error:.3f}"  # in as many digits as it is known
        every = summary_lines(summarise({"": dataset}))
        _, head, *rows = every[every.index("  shares of any at each point:") :][:5]
        assert head.split() == ["Omega", "equilibrium", "periodic"]
        assert rows[0].split() == ["1", *rest.split(" to ")[0].split(), *moving.split()[2:]]
        assert re.fullmatch(r" *9  +1 \(all of 200: .*\)  +0 \(none of 200: .*\)", rows[2])


def test_basins_need_starts_that_differ_in_two_states():
    dataset = data.basin()
    assert [spec.kind for spec in default_figures(dataset)] == ["basin"]
    for lacking in ("initial_state", "attractor"):  # as a branch of cycles, which has starts
        with pytest.raises(UsageError, match="next: a case with an analysis of kind `response`"):
            draw(dataset.drop_vars(lacking), figure("basin", x="x", y="x_dot"))
    with pytest.raises(UsageError, match="the states are: x, x_dot"):
        draw(dataset, figure("basin", x="y"))
    flat = dataset.assign(initial_state=dataset["initial_state"] * [1.0, 0.0])
    with pytest.raises(UsageError, match=r"fewer than two components\nnext: "):
        draw(flat, figure("basin"))
    lost = dataset.assign(status=dataset["status"] * 0 + data.codes(data.STATUS, "failed"))
    lost["status"].attrs = dataset["status"].attrs
    with pytest.raises(EmptyFigureError, match="failed 400"):
        draw(lost, figure("basin"))
