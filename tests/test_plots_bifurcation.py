"""Bifurcation diagrams, drawn from small datasets: marks, cycles, branches, equilibria."""

import csv
import json
import re
from itertools import combinations, pairwise, product
from pathlib import Path

import numpy as np
import pytest
import synthetic_datasets as data
import xarray as xr
from matplotlib.colors import to_hex
from matplotlib.figure import Figure
from matplotlib.legend import Legend
from plotted import (
    branch_along_the_speed,
    crossing_lines,
    dashed,
    figure,
    legend_texts,
    marked,
    marks,
    resting,
    run,
)

from fiv_cli import api
from fiv_cli.case.case import FigureSpec
from fiv_cli.cli.plot import command as plot_command
from fiv_cli.dynamics.settings import Section
from fiv_cli.errors import EmptyFigureError, UsageError
from fiv_cli.plots import draw, leaps, points, style
from fiv_cli.plots import labels as words
from fiv_cli.plots.branch import stretches
from fiv_cli.plots.cloud_marks import FINEST, SEEN_AMONG, _mark_gathered, mark_clouds
from fiv_cli.plots.clouds import Cloud
from fiv_cli.plots.diagram_lines import _colours_of
from fiv_cli.plots.drawn import DECORATION, as_csv
from fiv_cli.plots.points import GAP_MARKS
from fiv_cli.plots.style import BLACK, finer
from fiv_cli.reading.datasets import class_names, flag_names


def test_a_bifurcation_diagram_has_a_dot_for_every_section_value():
    dataset = data.bifurcation()
    (ax,) = draw(dataset, figure("bifurcation")).axes
    near, far, pale = (
        marks(ax, label) for label in ("near", "far", "_far, values where undecided")
    )
    passed = [*near[:, 1], *far[:, 1], *pale[:, 1]]
    assert sorted(passed) == sorted(dataset["section_value"].values)
    assert {*pale[:, 0]} == {dataset["Omega"].values[10]}  # which has no class


def test_each_section_value_stands_at_the_parameter_of_its_row():
    (ax,) = draw(data.bifurcation(), figure("bifurcation")).axes
    far = marks(ax, "far")
    assert np.sort(far[np.isclose(far[:, 0], 3.0), 1]) == pytest.approx([0.046, 0.058])
    assert marks(ax, "near")[:, 0].max() == pytest.approx(3.4)


def test_a_bifurcation_diagram_names_its_axes_with_symbol_and_unit():
    (ax,) = draw(data.bifurcation(), figure("bifurcation")).axes
    assert ax.get_xlabel() == r"disc speed $\Omega$ (rad/s)"
    assert ax.get_ylabel() == r"$\varphi$ at the section (rad)"


def test_a_bifurcation_diagram_reaches_over_the_whole_grid():
    """Also where nothing moves, so that there is no section point: from 3.5 rad/s on."""
    (ax,) = draw(data.bifurcation(), figure("bifurcation", select={"initial": "near"})).axes
    assert ax.get_xlim()[0] <= 0.5 and ax.get_xlim()[1] >= 5.0


@pytest.mark.parametrize(("share", "words"), [(0.0, "steady sliding"), (1.0, "at rest")])
def test_an_equilibrium_is_called_what_its_contacts_do(share, words):
    dataset = data.bifurcation().assign(phi_max=lambda whole: whole["L_s"])
    dataset["stick_fraction"] = dataset["L_s"] * 0.0 + share
    (ax,) = draw(dataset, figure("bifurcation")).axes
    assert {"at rest", "steady sliding"} & set(legend_texts(ax)) == {words}


@pytest.mark.parametrize("value", [3.349364905e-2, -3.349364905e-2])
@pytest.mark.parametrize("kind", ["bifurcation", "curve"])
def test_a_constant_is_drawn_as_one_and_its_ticks_hold_whole_values(kind, value):
    dataset = data.bifurcation()
    name = "section_value" if kind == "bifurcation" else "L_s"
    noise = 1e-14 * np.arange(dataset[name].size).reshape(dataset[name].shape)
    dataset[name] = dataset[name] * 0.0 + value + noise
    drawn = draw(dataset, figure(kind, variable=name))
    (ax,) = drawn.axes
    drawn.canvas.draw()
    low, high = ax.get_ylim()
    assert low < value < high and high - low > 0.1 * abs(value)
    assert not ax.yaxis.get_offset_text().get_text()


@pytest.mark.parametrize("kind", ["bifurcation", "curve"])
def test_points_without_answer_are_marked(kind):
    (ax,) = draw(data.bifurcation(), figure(kind)).axes
    assert marks(ax, "failed: far")[:, 0] == pytest.approx([2.5])
    assert marks(ax, "undecided: far")[:, 0] == pytest.approx([1.5])
    value = "value of an undecided motion" if kind == "curve" else "values where undecided"
    assert {"failed: far", "undecided: far", "near", "far", value} == set(legend_texts(ax))


def test_marks_of_points_without_answer_have_the_colour_of_their_line_or_none():
    """Of many lines, and of all, they are of no line."""
    dataset = data.bifurcation()
    (ax,) = draw(dataset, figure("curve", variable="L_s")).axes
    colours = {line.get_label(): line.get_color() for line in ax.lines}
    assert colours["failed: far"] == colours["far"] != colours["near"]
    dataset["status"][30] = data.STATUS.index("failed")
    (ax,) = draw(dataset, figure("curve", variable="L_s")).axes
    assert {"failed: near", "failed: far"} < set(legend_texts(ax))
    dataset["status"][:] = dataset["status"].values[:, :1]
    (ax,) = draw(dataset, figure("curve", variable="L_s")).axes
    (line,) = [line for line in ax.lines if line.get_label() == "failed"]
    assert line.get_color() not in colours.values()


def test_a_legend_hides_no_data():
    dataset = data.bifurcation().assign(L_s=lambda d: d["L_s"] * 0.0 + np.arange(46.0)[:, None] % 7)
    drawn = draw(dataset, figure("curve", variable="L_s"))
    assert drawn.axes[0].get_legend() is None and len(drawn.legends) == 1
    assert draw(data.bifurcation(), figure("curve")).axes[0].get_legend() is not None


def test_marks_of_gaps_stand_below_all_points_a_row_for_each_line_of_each_dataset():
    dataset = data.bifurcation()
    other = dataset.isel(initial=[1, 0]).assign(L_s=dataset["L_s"] * 1.1)
    (ax,) = draw([("one", dataset), ("two", other)], figure("curve", variable="L_s")).axes
    rows = [line for line in ax.lines if line.get_marker() in {m for m, _ in GAP_MARKS.values()}]
    heights = [line.get_ydata()[0] for line in rows]
    assert len(set(heights)) == len(heights) == 4
    low, high = ax.get_ylim()
    assert max(heights) < (ax.dataLim.y0 - low) / (high - low)
    limited = draw(dataset, figure("curve", variable="L_s", ylim=[-0.5, 1]))
    assert limited.axes[0].get_ylim() == (-0.5, 1)  # no line leads where the marks are


def test_lines_that_would_hide_one_another_are_one_with_the_name_of_all():
    """A table has each by its own name; what gaps they have is told in the colour of all."""
    lines = crossing_lines(rest=(0.0, 1.0), belt=(0.0, 1.0), other=(1.0, 0.0))
    drawn = draw(lines, figure("curve", variable="L_s"))
    assert legend_texts(drawn.axes[0]) == ["rest and belt", "other"]
    shown = [line for line in drawn.axes[0].lines if line.get_visible() and len(line.get_xdata())]
    assert len(shown) == 2
    rows = [row.split(",") for row in as_csv(drawn, Path("a.csv")).splitlines()[1:]]
    assert {row[4] for row in rows} == {"rest", "belt", "other"}
    assert points.is_of("a, rest, x", "a, rest and belt") and points.is_of("rest", "rest")
    assert not points.is_of("a, restless", "a, rest and belt") and not points.is_of("a", "a, b")


@pytest.mark.parametrize(
    ("names", "told"),
    [
        (["v = 1, up", "v = 1, down"], "v = 1, up and down"),
        (["v = 1, up", "v = 2, down"], ""),
        (["up", "v = 2, up"], ""),
        (["far-000", "far-001"], ""),
        (["a" * 30, "b" * 30], ""),
        (["far-000"], "far-000"),
    ],
)
def test_several_lines_have_a_name_of_all_where_it_is_no_others(names, told):
    assert points.of_all(names) == told


def test_marks_of_gaps_that_look_alike_are_one_row():
    """Two starts of one preload have one colour, and one mark: both are named."""
    rows = {("undecided", "a, up"): np.r_[1.0], ("undecided", "a, down"): np.r_[2.0]}
    for own, told in (({"a": "red"}, [("a, up and down", [1.0, 2.0])]), ({}, [("", [1.0, 2.0])])):
        looks = points._by_look(rows, own).values()
        assert [(whose, x.tolist()) for whose, x, _ in looks] == told
        assert all(is_mixed for *_, is_mixed in looks)  # neither has both, which is told
    alone = points._by_look({("pending", "a, up"): np.r_[1.0]}, {})
    assert [(whose, is_mixed) for whose, _, is_mixed in alone.values()] == [("a, up", False)]


def test_marks_of_gaps_leave_free_what_is_known_between_them():
    """They ran on over blocks of a partial run that were done, which were narrower than a mark."""
    ax = Figure(figsize=(6.4, 4.0)).add_subplot(xlim=(0.0, 1000.0))
    known = np.r_[400.0:410.0, 700.0:712.0]
    pending = np.setdiff1d(np.arange(1000.0), known)
    marked = pending[points._apart(ax, pending, known)]
    half = 0.5 * points.GAP_MARK * ax.figure.dpi / style.POINTS / (ax.bbox.width / 1000.0)
    assert np.abs(marked[:, None] - known).min() >= half
    assert np.diff(marked).max() < 2.0 * (half + 12.0)  # and all else is marked throughout
    lone = np.array([3.0, 500.0, 501.0])  # too short to keep away from what is beside them
    assert points._apart(ax, lone, np.setdiff1d(np.arange(1000.0), lone)) == [0, 1, 2]


def test_points_at_rest_of_one_start_are_squares_alone_and_a_partial_run_says_so():
    """A dot on each made a band of many, of which the legend told nothing."""
    found = resting().isel(initial=[0])
    for dataset, has_others in ((found, False), (resting(), True)):
        (ax,) = draw(dataset, figure("bifurcation")).axes
        shown = [line for line in ax.lines if len(line.get_xdata()) and line.get_zorder() == 4.1]
        assert bool({line.get_marker() for line in shown} - {"s"}) == has_others
    partial = found.assign_attrs(partial="30 of 46 points")
    assert "partial: 30 of 46 points" in draw(partial, figure("bifurcation")).get_suptitle()


def test_lines_have_the_colour_of_all_their_words():
    """Equilibria of the file of 1000 s had the colour of that of 100000 s, which begins alike."""
    known = {"t_max = 100000": "blue", "t_max = 1000": "red", "far": "black"}
    assert _colours_of("t_max = 1000", known) == _colours_of("t_max = 1000, far", known) == ["red"]
    assert _colours_of("", known) == _colours_of("t_max = 10", known) == []


def test_no_start_has_dots_for_marks_where_squares_of_rests_lie_on_them():
    """The fourth of a table was in the legend, and nowhere in the figure."""
    one, at, no = np.ones(1), np.full(1, 2.0), np.zeros(1, bool)
    clouds = [Cloud("", start, one, one, no, no, at, one, no, no) for start in "abcd"]
    ax = Figure().add_subplot()
    mark_clouds(ax, clouds, 9, 6.4, {})
    rests = {line.get_marker() for line in ax.lines if 2.0 in line.get_xdata()}
    assert rests == {"o", "+", "s", "^"}


def test_undecided_values_in_one_place_are_seen_on_a_line():
    """However little the motions of their own start differ: the legend told of what none saw."""
    found = resting()
    crowd = 0.03 + 1e-5 * np.random.default_rng(1).random(400)
    every, none = np.ones(400, bool), np.zeros(0)
    cloud = Cloud("", "near", np.full(400, 2.0), crowd, every, every, none, none, none, none)
    ax = Figure().add_subplot()
    entry = points.Entry("#0072B2", "-", "near", 0, False)
    _mark_gathered(ax, cloud, entry, float(np.ptp(found["section_value"].values)))
    (line,) = ax.lines
    assert line.get_xydata() == pytest.approx(np.array([[2.0, np.median(crowd)]]))
    assert line.get_zorder() > 3.5 and line.get_markeredgecolor() == entry.colour
    _mark_gathered(ax, cloud, entry, 1e-6)  # of a figure in which they are a column
    assert len(ax.lines) == 1


def test_marks_of_gaps_stand_within_the_frame():
    (ax,) = draw(data.bifurcation(), figure("curve", variable="L_s")).axes
    marked = [line for line in ax.lines if line.get_transform() == ax.get_xaxis_transform()]
    heights = np.array([line.get_ydata()[0] for line in marked]) * ax.bbox.height
    assert len(marked) == 2
    assert heights.min() > 0.5 * points.GAP_MARK * ax.figure.dpi / style.POINTS


@pytest.mark.parametrize("log", [False, "y"])
def test_marks_of_gaps_stand_on_a_strip_below_what_has_a_value(log):
    (ax,) = draw(data.bifurcation(), figure("curve", variable="L_s", log=log)).axes
    (strip,) = (one for one in ax.patches if to_hex(one.get_facecolor()) == to_hex(points.STRIP))
    marked = [line for line in ax.lines if line.get_transform() == ax.get_xaxis_transform()]
    top = strip.get_height()
    assert all(0.0 < line.get_ydata()[0] < top for line in marked)
    values = [line.get_xydata() for line in ax.lines if line.get_transform() == ax.transData]
    pixels = ax.transData.transform(np.concatenate([one[one[:, 1] > 0.0] for one in values]))
    assert (ax.transAxes.inverted().transform(pixels)[:, 1] > top).all()
    ticks = ax.transData.transform([(1.0, tick) for tick in ax.get_yticks()])
    assert (ax.transAxes.inverted().transform(ticks)[:, 1] >= top - 1e-5).all()


def test_classes_keep_their_names_in_tables_where_points_failed():
    drawn = draw(data.bifurcation(), figure("curve", variable="attractor"))
    assert any(text.startswith("failed") for text in legend_texts(drawn.axes[0]))
    rows = csv.DictReader(as_csv(drawn, Path("a.csv")).splitlines())
    told = {row["y"] for row in rows if row["series"] in ("near", "far")}
    assert {"equilibrium", "periodic"} <= told and not any(word[0].isdigit() for word in told)


@pytest.mark.parametrize("log", [False, "y"])
def test_the_strip_of_gaps_lies_below_a_limit_and_over_what_is_below_it(log):
    dataset = data.bifurcation()
    low, high = 0.3 * float(dataset["L_s"].max()), float(dataset["L_s"].max())
    asked = figure("curve", variable="L_s", log=log, ylim=(low, high))
    (ax,) = draw(dataset, asked).axes
    (strip,) = (one for one in ax.patches if to_hex(one.get_facecolor()) == to_hex(points.STRIP))
    at = ax.transAxes.inverted().transform(ax.transData.transform([(1.0, low), (1.0, high)]))
    assert at[:, 1] == pytest.approx([strip.get_height(), 1.0])
    marked = [line for line in ax.lines if line.get_transform() == ax.get_xaxis_transform()]
    others = [line for line in ax.lines if line not in marked]
    assert all(line.get_zorder() > strip.get_zorder() for line in marked)
    assert all(line.get_zorder() < strip.get_zorder() for line in others)


def test_of_many_lines_those_few_that_have_gaps_are_named():
    """Eight lines, of which one has an undecided point."""
    values = np.array(["periodic"] * 8, object)[:, None, None].repeat(3, axis=2)
    values[5, 0, 1] = "undecided"
    dataset = data.response(
        values.transpose(0, 2, 1), np.ones((8, 3, 1)),
        data.axes(N0=np.arange(8.0), Omega=[1.0, 2.0, 3.0], initial=["near"]),
    )  # fmt: skip
    (ax,) = draw(dataset, figure("curve", variable="L_s", x="Omega")).axes
    (told,) = [text for text in legend_texts(ax) if text.startswith("undecided")]
    assert "= 5" in told


def test_marks_on_a_limit_are_whole_and_none_is_drawn_beyond_one():
    """Shares of 0 and 1, for example."""
    dataset = data.bifurcation().isel(initial=[0])
    greatest = float(dataset["L_s"].max())
    for top, clips in ((greatest, False), (0.5 * greatest, True)):
        (ax,) = draw(dataset, figure("curve", variable="L_s", ylim=(0.0, top))).axes
        assert max(ax.lines, key=lambda one: one.get_xdata().size).get_clip_on() == clips


def test_gaps_of_all_lines_of_one_of_two_datasets_are_its():
    one, other = data.bifurcation(), data.bifurcation()
    one["status"][:] = data.STATUS.index("ok")
    other["status"][:] = other["status"].values[:, 1:]
    (ax,) = draw([("one", one), ("other", other)], figure("curve", variable="L_s")).axes
    assert [text for text in legend_texts(ax) if text.startswith("failed")] == ["failed: other"]


def test_of_several_files_each_shows_those_of_the_starts_selected_that_it_has():
    dataset = data.bifurcation()
    sources = [("one", dataset), ("two", dataset.isel(initial=[0]))]  # near alone
    (ax,) = draw(sources, figure("curve", select={"initial": ["near", "far"]})).axes
    assert {"one, near", "one, far", "two"} <= set(legend_texts(ax))
    with pytest.raises(UsageError, match="initial = fra: not in this dataset"):
        draw(sources, figure("curve", select={"initial": ["near", "fra"]}))


def test_gaps_of_too_many_lines_are_nobodys():
    dataset = data.bifurcation()
    many = [(label, dataset) for label in ("one", "two", "three", "four")]
    (ax,) = draw(many, figure("curve", variable="L_s")).axes
    grey = {line.get_label(): to_hex(line.get_color()) for line in ax.lines}
    assert grey["undecided"].upper() == GAP_MARKS["undecided"][1]
    assert not [label for label in grey if label.startswith("undecided:")]
    assert marks(ax, "failed")[:, 0].tolist() == pytest.approx([2.5])


def test_each_reason_for_a_missing_answer_has_a_mark_of_its_own():
    dataset = data.bifurcation()
    for code in range(1, len(data.STATUS)):
        dataset["status"][code, 0] = code
    (ax,) = draw(dataset, figure("curve")).axes
    kinds = [status.replace("_", " ") for status in data.STATUS[1:]]
    looks = {line.get_marker() for line in ax.lines if line.get_label().partition(":")[0] in kinds}
    assert len(looks) == len(kinds)


def test_a_selection_leaves_its_rows_only_and_is_named():
    drawn = draw(data.bifurcation(), figure("bifurcation", select={"initial": "near"}))
    dots = marks(drawn.axes[0], drawn.axes[0].lines[0].get_label())
    assert len(dots) == int(data.bifurcation()["section_row_size"].sel(initial="near").sum())
    assert "start: near" in drawn.get_suptitle()


def test_several_datasets_share_a_diagram():
    one, two = data.bifurcation(), data.bifurcation().isel(initial=[0])
    two = two.isel(section_obs=slice(0, int(two["section_row_size"].sum())))
    (ax,) = draw([("damped", one), ("undamped", two)], figure("bifurcation")).axes
    assert {"damped, near", "damped, far", "undamped"} <= set(legend_texts(ax))


@pytest.mark.parametrize("kind", ["bifurcation", "curve"])
def test_members_of_a_random_start_share_colour_and_legend_entry(kind):
    dataset = data.bifurcation().assign_coords(initial=["far-000", "far-001"])
    (ax,) = draw(dataset, figure(kind)).axes
    assert legend_texts(ax)[0] == "far"
    own = [line for line in ax.lines if line.get_label() in ("far", "_far")]
    assert len(own) > 1 and len({line.get_color() for line in own}) == 1
    assert not {"far-000", "far-001"} & set(legend_texts(ax))
    assert {line.get_linestyle() for line in own} == {"None"}


def test_a_family_from_several_starts_has_its_colour_and_each_start_its_mark():
    """The legend has each once; what reaches nothing is not in it."""
    one = data.bifurcation()
    gone = one.assign_coords(initial=["lost", "far"])
    gone["section_row_size"] = gone["section_row_size"].where(gone["initial"] == "far", 0)
    kept = np.repeat(one["initial"].values[None] == "far", one.sizes["Omega"], axis=0)
    rows = np.repeat(kept.ravel(), one["section_row_size"].values.ravel())
    gone = gone.isel(section_obs=rows)
    (ax,) = draw([("soft", one), ("stiff", one), ("bare", gone)], figure("bifurcation")).axes
    assert legend_texts(ax)[:5] == ["soft", "stiff", "bare", "near", "far"]
    lines = {f"{line.get_label()}": line for line in reversed(ax.lines)}  # crowds come later
    pairs = product(("soft", "stiff"), ("near", "far"))
    drawn = [lines[f"_{family}, {start}"] for family, start in pairs]
    colours, shapes = [one.get_color() for one in drawn], [one.get_marker() for one in drawn]
    assert colours[0] == colours[1] != colours[2] == colours[3]
    assert shapes[:2] == shapes[2:] and shapes[0] != shapes[1]
    assert lines["soft"].get_color() == colours[0] and lines["far"].get_marker() == shapes[1]
    assert not [word for word in legend_texts(ax) if "lost" in word and ":" not in word]


def test_what_all_of_many_starts_lead_to_has_one_mark():
    """Each start has its own where one leads elsewhere."""
    two = data.bifurcation()
    counts = two["section_row_size"].values
    near = np.split(two["section_value"].values, np.cumsum(counts.ravel())[:-1])[::2]
    away = [[0.2], *near[1:]]  # where the first of the points leads from the last start
    rows = [row for pair in zip(near, near, away, strict=True) for row in pair]
    last = two.isel(initial=[0], drop=False)
    starts = [last.assign_coords(initial=[name]) for name in ("a", "b", "c")]
    three = xr.concat([one.drop_vars("section_value") for one in starts], "initial")
    three["section_row_size"] = three["section_row_size"].transpose("Omega", "initial")
    three["section_row_size"].values[:] = np.reshape([len(row) for row in rows], (-1, 3))
    three["section_value"] = ("section_obs", np.concatenate(rows), two["section_value"].attrs)
    (ax,) = draw(three, figure("bifurcation")).axes
    assert legend_texts(ax)[:4] == ["a", "b", "c", "all starts"]
    drawn = {str(line.get_label()): line for line in reversed(ax.lines)}
    assert [drawn[name].get_xdata().tolist() for name in "abc"] == [[0.5], [0.5], [0.5]]
    shared = drawn["all starts"].get_xydata()
    assert len(shared) == sum(map(len, near)) - len(near[0])
    (ax,) = draw(three, figure("bifurcation", select={"initial": ["a", "b"]})).axes
    assert legend_texts(ax)[0] == "both starts"


def test_a_rest_of_all_starts_is_seen_inside_their_mark():
    dataset = data.bifurcation().isel(Omega=slice(30, None))
    dataset["attractor"][:] = data.codes(data.ATTRACTORS, "equilibrium")
    dataset = dataset.drop_dims("section_obs").assign(
        section_row_size=dataset["section_row_size"] * 0,
        section_value=("section_obs", [0.5, 0.5], data.bifurcation()["section_value"].attrs),
        phi_max=dataset["L_s"] * 0.0 + 1.0,
    )
    dataset["section_row_size"][0, :] = 1  # of motions that do not rest
    dataset["attractor"][0, :] = data.codes(data.ATTRACTORS, "periodic")
    (ax,) = draw(dataset, figure("bifurcation")).axes
    drawn = [line for line in ax.lines if len(line.get_xdata())]
    (square,) = [line for line in drawn if line.get_marker() == "s"]
    around = next(line for line in drawn if line.get_marker() == "D"
                  and set(square.get_xdata()) <= set(line.get_xdata()))  # fmt: skip
    assert around.get_markersize() > 1.5 * square.get_markersize()
    assert around.get_zorder() < square.get_zorder()  # which lies in it


def test_crowds_of_several_starts_are_seen_through_one_another():
    """Chaos that all reach: none hides another, and their keys are dots."""
    crowd = 0.03 + 0.001 * np.arange(40)
    classes = np.full((3, 2), "chaotic", object)
    coords = data.axes(Omega=[1.0, 2.0, 3.0], initial=["near", "far"])
    rows = [list(crowd + 1e-3 * start) for start in [0, 1] * 3]
    dataset = data.response(classes, np.ones((3, 2)), coords, rows=rows)
    (ax,) = draw(dataset, figure("bifurcation")).axes
    drawn = [line for line in ax.lines if len(line.get_xdata())]
    told = [str(line.get_label()) for line in drawn]
    assert told == ["_near", "_far", *[DECORATION] * 6]  # a table has each once
    colours = [to_hex(line.get_color()) for line in drawn]
    assert colours == [colours[0], colours[1]] * 4 and colours[0] != colours[1]
    assert [len(line.get_xdata()) for line in drawn] == [120, 120, *[30] * 6]
    keys = {str(line.get_label()): line for line in ax.lines if not len(line.get_xdata())}
    assert {keys[name].get_marker() for name in ("near", "far")} == {"."}


def test_a_line_is_seen_beneath_one_that_runs_upon_it_for_a_while():
    dataset = data.bifurcation()
    dataset["status"][:] = data.STATUS.index("ok")
    dataset["attractor"][:] = data.codes(data.ATTRACTORS, "periodic")
    values = np.arange(46.0)[:, None] * [1.0, 1.0] + np.where(np.arange(46) < 20, 0.0, 5.0)[:, None]
    values[:20, 1] += 3.0
    dataset["L_s"][:] = np.arange(92.0).reshape(46, 2)  # which leaves no motion
    two = dataset.assign(
        x_rms=(("Omega", "initial"), values, {"units": "m"}),
        y_rms=(("Omega", "initial"), values + 1.0, {"units": "m"}),
    )
    _, ax = draw(two, figure("curve", variable=["L_s", "x_rms", "y_rms"])).axes
    beneath = 2.0 * style.SETTINGS["lines.linewidth"]
    wide = [one for one in ax.lines if one.get_linewidth() == beneath]
    assert len(wide) == 2  # of both variables
    for line in wide:
        x, y = line.get_data()
        assert np.isfinite(y).tolist() == (dataset["Omega"].values >= x[20]).tolist()


@pytest.mark.parametrize("starts", ["ab", "abc", "abcd"])
def test_of_lines_along_the_axis_two_beneath_the_last_are_seen(starts):
    """One beneath more would be a bar there. What the dashes tell is the variable."""
    values = np.zeros((46, len(starts)))
    values[20:] = np.arange(1.0, 1.0 + len(starts))
    axes = data.axes(Omega=np.linspace(0.5, 5.0, 46), initial=[*starts])
    classes = np.full(values.shape, "periodic", object)
    both = {name: (("Omega", "initial"), values + n, {"units": "m"})
            for n, name in ((0.0, "x_rms"), (9.0, "y_rms"))}  # fmt: skip
    dataset = data.response(classes, values + 1.0, axes).assign(both)
    ax = draw(dataset, figure("curve", variable=["L_s", *both])).axes[1]
    along = sorted(
        (one for one in ax.lines if 0.0 in one.get_ydata()), key=lambda one: one.get_linewidth()
    )
    widest = {one.get_color(): one for one in along}.values()
    for times in (2.0, 3.0):
        width = times * style.SETTINGS["lines.linewidth"]
        wide = [one.get_ydata() for one in widest if one.get_linewidth() == width]
        assert [int(np.isfinite(y).sum()) for y in wide] == [20] * (times <= len(starts))


@pytest.mark.parametrize(
    ("alone", "marks"), [([], ["None", "None"]), ([20], [".", "^"]), ([20, 21], [".", "^"])]
)
def test_points_that_stand_alone_tell_by_marks_what_dashes_do(alone, marks):
    """Their colour is the preload's: two dots of one were those of two variables. So they do where
    two points are a line too short for its dashes. None has the mark of what is undecided."""
    values = np.linspace(1.0, 2.0, 46)[:, None] + np.array([0.0, 3.0, 6.0])
    classes = np.full(values.shape, "periodic", object)
    classes[alone] = "equilibrium"
    axes = data.axes(Omega=np.linspace(0.5, 5.0, 46), N0=[10.0, 20.0, 30.0])
    dims, unit = ("Omega", "N0"), {"units": "m"}
    both = {"x_rms": (dims, values, unit), "y_rms": (dims, values + 19.0, unit)}
    dataset = data.response(classes, values, axes).assign(both)
    drawn = draw(dataset, figure("curve", x="Omega", variable=[*both]))
    (legend,) = drawn.legends or [drawn.axes[0].get_legend()]
    assert [key.get_marker() for key in legend.legend_handles[-2:]] == marks
    seen = [line for line in drawn.axes[0].lines if len(line.get_xdata()) > 40]
    told = {(line.get_linestyle(), line.get_marker()) for line in seen if alone}
    assert told == {*zip(("-", "--"), marks, strict=True)} if alone else len(seen) == 6
    marked = {tuple(np.asarray(line.get_xdata())[line.get_markevery()]) for line in seen if alone}
    assert marked == {tuple(dataset["Omega"].values[alone])} if alone else not marked


def test_the_key_of_a_dash_has_a_mark_where_its_line_has_some():
    """An equilibrium is there at each point, and stands alone at none."""
    speeds, dims = np.linspace(0.5, 5.0, 46), ("Omega", "N0")
    values = np.linspace(1.0, 2.0, 46)[:, None] + np.array([0.0, 3.0, 6.0])
    classes = np.full(values.shape, "periodic", object)
    classes[20] = "equilibrium"
    dataset = data.response(classes, values, data.axes(Omega=speeds, N0=[10.0, 20.0, 30.0]))
    dataset["x_max"] = (dims, values, {"units": "m"})
    rest = {"equilibrium": (dims, values + 19.0, {"units": "m", "long_name": "steady sliding"})}
    beside = dataset[["status"]].assign(rest)
    sources = [("", {"response": dataset, "equilibrium": beside})]
    drawn = draw(sources, figure("curve", x="Omega", variable=["x_max", "equilibrium"]))
    (legend,) = drawn.legends or [drawn.axes[0].get_legend()]
    assert [key.get_marker() for key in legend.legend_handles[-2:]] == [".", "None"]


def test_dashes_tell_no_starts_whose_lines_are_one_for_a_while():
    """In one colour those beneath would not be seen there."""
    values = np.zeros((46, 2))
    values[:, 0], values[:, 1] = np.arange(46.0), np.maximum(np.arange(46.0), 20.0)
    axes = data.axes(Omega=np.linspace(0.5, 5.0, 46), initial=["a", "b"])
    classes = np.full(values.shape, "periodic", object)
    names = "stick_fraction", "slip_fraction", "separation_fraction"
    dims = "Omega", "initial"
    shares = {name: (dims, values / 46.0 + n, {"units": "1"}) for n, name in enumerate(names)}
    dataset = data.response(classes, np.ones(values.shape), axes).assign(shares)
    (ax,) = draw(dataset, figure("curve", variable=[*names])).axes
    lines = [line for line in ax.lines if len(line.get_xdata())]
    assert len({line.get_color() for line in lines}) == 2  # of the starts
    assert len({line.get_linestyle() for line in lines}) == 3


def test_lines_of_all_starts_are_one_though_their_names_are_long():
    labels = [f"from the {n} of all the many starts" for n in ("first", "second", "third")]
    dataset = data.bifurcation().isel(initial=[0, 0, 0]).assign_coords(initial=labels)
    drawn = draw(dataset[["status", "attractor", "L_s"]], figure("curve", variable="L_s"))
    rows = list(csv.reader(as_csv(drawn, Path("a.csv")).splitlines()))[1:]
    assert {row[4] for row in rows} == {*labels}
    visible = [line for line in drawn.axes[0].lines if len(line.get_xdata()) and line.get_visible()]
    assert len(visible) == 1
    two = draw(dataset.isel(initial=[0, 1])[["status", "attractor", "L_s"]],
               figure("curve", variable="L_s", select={"initial": labels[:2]}))  # fmt: skip
    assert "both starts" in legend_texts(two.axes[0])


def test_what_lines_of_all_starts_share_but_for_a_few_points_is_one_line():
    """Lines of several dashes that lay on one another looked like one that is striped."""
    dataset = data.bifurcation().isel(initial=[0, 0, 0], Omega=[0] * 40)
    dataset = dataset.assign_coords(Omega=np.arange(40.0), initial=["a", "b", "c"])
    dataset = dataset[["status", "attractor", "L_s"]].assign_attrs(dataset.attrs)
    dataset["L_s"].values[:, :] = np.arange(40.0)[:, None]
    dataset["L_s"].values[10, 1] = 10.5
    drawn = draw(dataset, figure("curve", variable="L_s"))
    seen = [
        np.flatnonzero(np.isfinite(line.get_ydata())).tolist()
        for line in drawn.axes[0].lines
        if len(line.get_xdata()) and line.get_visible() and line.get_linestyle() != "None"
    ]
    shared = [place for place in range(40) if place != 10]
    assert seen == [shared, [9, 10, 11], [9, 10, 11]]
    assert legend_texts(drawn.axes[0]) == ["all starts", "a and c", "b"]
    for preloads in ([20.0], [20.0, 30.0]):  # a table has each point of each start once
        parts = [dataset.assign_coords(N0=N0).expand_dims("N0") for N0 in preloads]
        of_both = draw(xr.concat(parts, "N0"), figure("curve", variable="L_s", x="Omega"))
        rows = list(csv.reader(as_csv(of_both, Path("a.csv")).splitlines()))[1:]
        assert len({(row[4], row[6]) for row in rows}) == len(rows) == 120 * len(preloads)


@pytest.mark.parametrize(
    ("known", "told"), [(39, ["both starts", "a", "failed: b"]), (0, ["a", "b"])]
)
def test_a_start_that_failed_at_a_point_is_not_told_to_have_no_value(known, told):
    dataset = data.bifurcation().isel(initial=[0, 0], Omega=[0] * 40)
    dataset = dataset.assign_coords(Omega=np.arange(40.0), initial=["a", "b"])
    dataset = dataset[["status", "attractor", "L_s"]].assign_attrs(dataset.attrs)
    dataset["L_s"].values[:, :] = np.arange(40.0)[:, None]
    if known:
        dataset["status"].values[10, 1], dataset["attractor"].values[10, 1] = 2, -1
        dataset["L_s"].values[10, 1] = np.nan
    else:  # what no start knows is nothing that they share
        dataset["L_s"].values[3:] = np.nan
        dataset["L_s"].values[:3, 1] += 1.0
    assert legend_texts(draw(dataset, figure("curve", variable="L_s")).axes[0]) == told


@pytest.mark.parametrize(("at_its_place", "marker"), [(True, "D"), (False, "None")])
def test_a_dataset_without_the_axis_keeps_its_mark_beside_others(at_its_place, marker):
    whole = data.bifurcation().isel(initial=[0])[["status", "attractor", "L_s"]]
    flat = whole.isel(Omega=5, drop=not at_its_place)
    (ax,) = draw([("whole", whole), ("flat", flat)], figure("curve", variable="L_s")).axes
    (line,) = [one for one in ax.lines if one.get_label() == "flat" and len(one.get_xdata())]
    assert line.get_marker() == marker


@pytest.mark.parametrize("asked", [{"initial": "near"}, {"initial": "other"}])
def test_each_file_of_a_figure_selects_what_its_own_figure_of_that_name_does(asked):
    """But what is selected for all of them is."""
    one, two = data.bifurcation(), data.bifurcation().assign_coords(initial=["held", "free"])
    near = figure("bifurcation", select={"initial": "near"})
    files = [
        ("one", one.assign_attrs(data.attributes(near))),
        ("two", two.assign_attrs(data.attributes(figure("bifurcation")))),
    ]
    if asked["initial"] == "other":
        with pytest.raises(UsageError, match="initial = other: not in this dataset"):
            draw(files, figure("bifurcation", select=asked))
        return
    (ax,) = draw(files, figure("bifurcation", select=asked)).axes
    told = " ".join(legend_texts(ax))
    assert all(word in told for word in ("one", "held", "free")) and "far" not in told


@pytest.mark.parametrize(
    ("step", "kind", "breaks"),
    [(0.1, "multiplicity", 1), (0.1, "stick_fraction", 1), (0.0, "multiplicity", 0), (0.01, "", 1)],
)
def test_a_curve_breaks_where_it_steps_to_a_cycle_of_another_kind(step, kind, breaks):
    """Or with another contact in stick, or leaps; not where it goes on through grazing."""
    dataset = data.bifurcation().isel(initial=[0], Omega=slice(0, 10))
    later = np.arange(10) >= 5
    dataset["L_s"].values[:, 0] = 1e-3 * np.arange(10) + step * later
    if kind:
        dataset[kind] = dataset["status"].copy(data=later[:, None] + 1 - (kind != "multiplicity"))
    line = draw(dataset, figure("curve", variable="L_s")).axes[0].lines[0]
    assert np.isnan(line.get_ydata()).sum() == breaks


def test_a_curve_does_not_break_where_no_leap_is_seen():
    """Where both of two contacts stick at once, for the share of time that each sticks."""
    shares = np.array([0.0, 0.0, 0.0, 0.8821, 0.8835, 0.8833, 0.8832])
    kinds = np.array([1.0, 1.0, 1.0, 3.0, 2.0, 2.0, 2.0])
    assert np.flatnonzero(leaps.leaps(shares, kinds, (0.0, 0.8835), False)).tolist() == [2]


@pytest.mark.parametrize(("far", "asked"), [(0.3, {}), (1.6, {}), (1.6, {"ylim": [0.05, 0.1]})])
def test_a_leap_to_a_cycle_of_one_point_is_one_whatever_else_a_panel_shows(far, asked):
    """A far value stretched the panel, and the leap was joined; nor is the dot of it a key then."""
    periods = np.array([*np.linspace(0.07, 0.06, 200), 0.287, *np.linspace(0.056, 0.055, 200), far])
    kinds = np.array([1] * 200 + [4] + [1] * 200 + [28])
    dataset = data.bifurcation()[["status", "attractor", "L_s"]]
    dataset = dataset.isel(initial=[0], Omega=np.zeros(kinds.size, int))
    dataset = dataset.assign_coords(Omega=("Omega", np.arange(1.0 * kinds.size), {"units": "1"}))
    dataset["L_s"].values[:, 0] = periods
    dataset["multiplicity"] = dataset["status"].copy(data=kinds[:, None])
    lines = draw(dataset, figure("curve", variable="L_s", **asked)).axes[0].lines
    line = max(lines, key=lambda one: len(one.get_xdata()))
    assert np.flatnonzero(np.isnan(line.get_ydata())).tolist() == [200, 202, 403]
    assert (line.get_marker() == "None") == bool(asked)
    assert lines[0].get_marker() == "None"  # its key


def test_a_line_breaks_where_any_mark_of_its_motion_leaps():
    """At a fold amplitudes rise steeply on their own: sticks tell the other cycle."""
    amplitude = np.array([327, 307, 291, 373, 675, 681, 687, 693]) * 1e-4
    sticks = np.array([160, 140, 122, 108, 431, 429, 427, 424]) * 1e-3
    omega = 4.2 + 0.05 * np.arange(8)
    dataset = data.response(
        np.full((8, 1), "periodic", object), np.ones((8, 1)),
        data.axes(Omega=omega, initial=["far"]), rows=[[0.1]] * 8,
    ).assign(phi_amplitude=(("Omega", "initial"), amplitude[:, None]))  # fmt: skip
    wanted = figure("curve", variable="phi_amplitude", xlim=[0.5, 9.0], ylim=[0.0, 0.2])
    for told, pieces in ((None, [8]), (sticks, [4, 4])):
        if told is not None:
            dataset["stick_fraction"] = ("Omega", "initial", "contact"), told[:, None, None]
        (ax,) = draw(dataset, wanted).axes
        (line,) = [line for line in ax.lines if len(line.get_xdata()) > 1]
        known = "".join("-x"[int(one)] for one in np.isfinite(line.get_ydata()))
        assert [len(piece) for piece in known.split("-")] == pieces


def test_where_a_mark_alone_tells_another_cycle_a_small_step_breaks_a_line_too():
    """Of the same kind, as a cycle that sticks for longer; a steady staircase has no such step."""
    sticks = np.array([475, 479, 483, 486, 489, 558, 557, 557, 557, 556]) * 1e-3
    heights = np.array([769, 767, 765, 764, 763, 755, 756, 756, 757, 757]) * 1e-4
    kinds = np.full(10, 1.0 + leaps.MANY)
    for mark, breaks in ((sticks, [4]), (np.linspace(0.4, 0.6, 10), [])):
        own, surely = leaps.told_apart(kinds, [xr.DataArray(mark)])
        found = leaps.leaps(heights, own, (0.0, 0.08), False, surely)
        assert np.flatnonzero(found).tolist() == breaks


@pytest.mark.parametrize(
    ("to", "breaks"),
    [
        (5.0 + 0.1 * np.arange(8), [7]),
        (1.0 + np.sqrt(np.arange(1.0, 9.0)), []),
        (1.5 + 0.0 * np.arange(8), []),
    ],
)
def test_a_leap_within_a_kind_breaks_a_curve_but_no_steep_beginning(to, breaks):
    heights = np.array([*(1.0 + 0.01 * np.arange(8)), *to])
    found = leaps.leaps(heights, np.ones(16), (1.0, 6.0), False)
    assert np.flatnonzero(found).tolist() == breaks


def test_a_leap_from_a_lone_point_is_one_though_its_kind_stays():
    """Before it all is chaos; after it the amplitude is more than twice as great, and grows."""
    heights = np.array([np.nan, 0.0131, 0.0313, 0.0335, 0.0356, 0.0375, 0.0393, 0.0411])
    found = leaps.leaps(heights, np.ones(8), (0.0131, 0.0411), False)
    assert np.flatnonzero(found).tolist() == [1]
    root = np.sqrt(np.arange(8.0))  # which begins steeply
    assert not leaps.leaps(root, np.ones(8), (0.0, 2.7), False).any()


@pytest.mark.parametrize(("log", "breaks"), [(False, 0), ("y", 1)])
def test_a_leap_of_decades_is_seen_on_a_logarithmic_axis_alone(log, breaks):
    dataset = data.bifurcation().isel(initial=[0], Omega=slice(0, 8))
    dataset["L_s"].values[:, 0] = [1e-4, 1.1e-4, 1.2e-4, 1e-2, 2e-2, 4e-2, 0.3, 1.0]
    dataset["multiplicity"] = dataset["status"].copy(data=1 + (np.arange(8) >= 3)[:, None])
    line = draw(dataset, figure("curve", variable="L_s", log=log)).axes[0].lines[0]
    assert np.isnan(line.get_ydata()).sum() == breaks


def test_files_of_which_one_has_an_axis_more_share_a_curve():
    """Though a line of one lies upon a line of the other."""
    one = data.bifurcation().isel(initial=[0])[["status", "attractor", "L_s"]]
    parts = [one.assign_coords(c=c).expand_dims(c=[c]) for c in (0.0, 1.0)]
    more = xr.concat(parts, "c").transpose("Omega", "initial", "c").assign_attrs(one.attrs)
    (ax,) = draw([("two", more), ("one", one)], figure("curve", variable="L_s")).axes
    assert any(np.isfinite(line.get_ydata()).any() for line in ax.lines)


def test_marks_of_a_dense_diagram_are_smaller():
    few = data.bifurcation()
    many = few.isel(section_obs=np.repeat(np.arange(few.sizes["section_obs"]), 40))
    many["section_row_size"] = 40 * few["section_row_size"]
    size, smaller = (marked(draw(one, figure("bifurcation"))) for one in (few, many))
    assert finer(2_000) == 1.0 and finer(1_000_000) == 0.5
    crowd = many.sizes["section_obs"]
    assert crowd > 2_000
    assert 1.5 * FINEST <= smaller < 0.5 * size  # and are dots, one sort wider than the next
    sizes = {line.get_markersize() for line in dots_of(draw(many, figure("bifurcation")))}
    (wide, fine) = sizes - {SEEN_AMONG}  # of what is undecided, among the columns of others
    assert max(wide, fine) > 1.5 * min(wide, fine)


def test_marks_that_would_be_bars_are_dots_and_marks_at_some_of_them():
    """Each value is a dot, once in the table; the keys of starts are their marks."""
    omega = np.linspace(0.5, 5.0, 900)
    dims, starts = ("Omega", "initial"), ["near", "far"]
    rows = [[0.01 * x] if start == "far" or x < 3.0 else [] for x in omega for start in starts]
    classes = np.where([[len(row) > 0] for row in rows], "periodic", "equilibrium")
    shape = omega.size, len(starts)
    extreme = dims, np.full(shape, 0.02), {"long_name": "greatest phi", "units": "rad"}
    dense = data.response(
        classes.reshape(shape), np.ones(shape), data.axes(Omega=omega, initial=starts), rows=rows
    ).assign(phi_max=extreme)
    drawn = draw(dense, figure("bifurcation"))
    (ax,) = drawn.axes
    shapes = [line for line in ax.lines if len(line.get_xdata()) and line.get_marker() in "o+"]
    assert {line.get_marker() for line in shapes} == {"o", "+"}
    assert all(0 < len(line.get_xdata()) <= 25 for line in shapes)
    x, y = np.hstack([line.get_data() for line in shapes])
    np.testing.assert_allclose(y, np.where(np.isclose(y, 0.02), 0.02, 0.01 * x))
    assert {omega[omega >= 3.0][0], omega[-1]} <= {*x}  # dots between the ends of a row are of it
    table = [row.split(",") for row in as_csv(drawn, Path("dense.csv")).splitlines()]
    told = [row[-2:] for row in table[1:] if row[-1]]
    assert len(told) == len({*map(tuple, told)}) == 900 + (omega >= 3.0).sum()
    keys = {str(line.get_label()): line for line in ax.lines if not len(line.get_xdata())}
    assert {keys[start].get_linestyle() for start in starts} != {"None"}  # marks among dots
    assert keys["at rest"].get_linestyle() == "None"
    assert {"near", "far", "both starts", "at rest"} == {*legend_texts(ax)}


def test_a_dot_is_seen_around_that_of_another_start_upon_it():
    """Where two of three starts lead to the same, at every place but where all do."""
    omega, starts = np.linspace(0.5, 5.0, 900), ["a", "b", "c"]
    heights = np.stack([omega, omega, np.where(omega < 4.0, 2.0, 1.0) * omega], axis=1)
    axes = data.axes(Omega=omega, initial=starts)
    rows = [[height] for height in heights.ravel()]
    classes = np.full(heights.shape, "periodic", object)
    dense = data.response(classes, np.ones(heights.shape), axes, rows=rows)
    (ax,) = draw(dense, figure("bifurcation")).axes
    dots = [line for line in ax.lines if len(line.get_xdata()) == (omega < 4.0).sum()]
    sizes = [line.get_ms() for line in dots if to_hex(line.get_color()) == style.BLUE.lower()]
    assert len(sizes) == 2 and max(sizes) > 1.5 * min(sizes)


def test_the_key_of_rests_in_a_dense_diagram_is_as_they_are_drawn():
    """Black, though the dots at rest have one colour."""
    omega, preloads = np.linspace(0.5, 5.0, 300), [10.0, 20.0]
    rows = [[0.01 * x] if preload > 10.0 else [] for x in omega for preload in preloads]
    classes = np.where([[len(row) > 0] for row in rows], "periodic", "equilibrium")
    shape, axes = (300, 2), data.axes(Omega=omega, N0=preloads)
    rest = ("Omega", "N0"), np.full(shape, 0.02), {"units": "rad"}
    dataset = data.response(classes.reshape(shape), np.ones(shape), axes, rows=rows)
    (ax,) = draw(dataset.assign(phi_max=rest), figure("bifurcation", x="Omega")).axes
    (key,) = [line for line in ax.lines if line.get_label() == "at rest"]
    assert to_hex(key.get_color()) == BLACK.lower()


def dense(rows, classes):
    """A diagram of 900 columns and two starts."""
    omega, shape = np.linspace(0.5, 5.0, 900), (900, 2)
    coords = data.axes(Omega=omega, initial=["near", "far"])
    return data.response(classes.reshape(shape), np.ones(shape), coords, rows=rows)


def test_a_start_that_differs_in_a_narrow_window_of_a_dense_diagram_has_a_mark():
    window = np.arange(900) // 25 == 20
    rows = [[0.01 * n + 0.5 * (far and own)] for n, own in enumerate(window) for far in (0, 1)]
    (ax,) = draw(dense(rows, np.full(1800, "periodic", object)), figure("bifurcation")).axes
    keys = {str(line.get_label()): line.get_marker() for line in ax.lines if line.get_label()}
    drawn = {line.get_marker() for line in ax.lines if len(line.get_xdata())}
    assert {keys["near"], keys["far"]} == {"o", "+"} < drawn


def test_points_at_rest_of_a_dense_diagram_have_few_marks():
    rows = [[0.01 * n + 0.1 * far] if n < 20 else [] for n in range(900) for far in (0, 1)]
    classes = np.where([len(row) > 0 for row in rows], "periodic", "equilibrium")
    rest = ("Omega", "initial"), np.tile([0.02, 0.03], (900, 1)), {"units": "rad"}
    drawn = draw(dense(rows, classes).assign(phi_max=rest), figure("bifurcation"))
    (ax,) = drawn.axes
    marks = {line.get_marker(): len(line.get_xdata()) for line in ax.lines if line.get_xdata().size}
    assert 10 < max(marks["o"], marks["+"]) <= 25


@pytest.mark.parametrize("log", [False, "x"])
def test_marks_of_a_dense_diagram_are_as_far_apart_in_a_short_stretch(log):
    """Of 900 speeds one start rests from the 500th to the 560th: its marks were a bar there."""
    rows = [[0.01 * n] if far or not 500 <= n < 560 else [] for n in range(900) for far in (0, 1)]
    classes = np.where([len(row) > 0 for row in rows], "periodic", "equilibrium")
    rest = ("Omega", "initial"), np.tile([0.02, 0.03], (900, 1)), {"units": "rad"}
    asked = figure("bifurcation", log=log)
    (ax,) = draw(dense(rows, classes).assign(phi_max=rest), asked).axes
    some = [line for line in ax.lines if len(line.get_xdata()) and line.get_marker() in "o+"]
    way = ax.transAxes.inverted().transform(
        ax.transData.transform(np.concatenate([line.get_xydata() for line in some]))
    )
    short = way[np.isclose(np.concatenate([line.get_ydata() for line in some]), 0.02)]
    assert 0 < len(short) <= 2
    for line in some:
        along = ax.transAxes.inverted().transform(ax.transData.transform(line.get_xydata()))
        assert (np.diff(np.sort(along[:, 0])) > 0.9 / 25).all()


def test_the_key_of_what_only_crowds_is_a_dot_in_a_dense_diagram_too():
    rows = [
        [0.01 * n] if start == "near" else [*(0.02 * n + 0.001 * np.arange(12))]
        for n in range(900)
        for start in ("near", "far")
    ]
    classes = np.array(["periodic", "chaotic"] * 900)
    (ax,) = draw(dense(rows, classes), figure("bifurcation")).axes
    keys = {str(line.get_label()): line.get_marker() for line in ax.lines}
    assert (keys["near"], keys["far"]) == ("o", ".")


def test_every_value_of_a_diagram_of_one_start_has_its_name_in_the_table():
    """Of a crowd, too: tables are grouped by it, and rows without one are left out."""
    rows = [[*(0.02 * n + 0.001 * np.arange(12 if n % 2 else 2))] for n in range(12)]
    dataset = data.response(
        np.array(["periodic", "chaotic"] * 6)[:, None], np.ones((12, 1)),
        data.axes(Omega=np.linspace(0.5, 5.0, 12), initial=["far"]), rows=rows,
    )  # fmt: skip
    table = as_csv(draw(dataset, figure("bifurcation")), Path("crowd.csv")).splitlines()
    series = [dict(zip(table[0].split(","), row.split(","), strict=True)) for row in table[1:]]
    assert [row["series"] for row in series] == ["start: far"] * (6 * 12 + 6 * 2)


def test_no_mark_among_dots_is_a_dot():
    preloads = [10.0, 20.0, 30.0, 40.0, 50.0]
    rows = [[0.01 * x + preload] for x in range(300) for preload in preloads]
    axes = data.axes(Omega=np.linspace(0.5, 5.0, 300), N0=preloads)
    dataset = data.response(np.full((300, 5), "periodic"), np.ones((300, 5)), axes, rows=rows)
    (ax,) = draw(dataset, figure("bifurcation", x="Omega")).axes
    keys = [line for line in ax.lines if not str(line.get_label()).startswith("_")]
    assert len({line.get_marker() for line in keys} - {"."}) == 5


def dots_of(drawn):
    """The lines of full dots, but those that stand for a crowd in one place."""
    dots = (line for line in drawn.axes[0].lines if line.get_marker() == ".")
    return [line for line in dots if len(line.get_xdata()) and line.get_label() != DECORATION]


def test_a_point_at_rest_is_a_square_in_the_mark_of_its_start():
    """Of one start the square alone, of which the key has the colour."""
    omega = np.linspace(0.5, 5.0, 46)[30:]
    for starts in (["near"], ["near", "far"]):
        (ax,) = draw(resting(), figure("bifurcation", select={"initial": starts})).axes
        rest = [line for line in ax.lines if np.array_equal(line.get_xdata(), omega)]
        squares = [line for line in rest if line.get_marker() == "s" and line.get_mfc() != "none"]
        (key,) = [line for line in ax.lines if line.get_label() == "at rest"]
        for line in rest:
            np.testing.assert_allclose(line.get_ydata(), 0.01 * omega)
        assert len(squares) == 1 and "at rest" in legend_texts(ax)
        assert to_hex(key.get_color()) == to_hex(squares[0].get_color())
        own = {line.get_marker() for line in ax.lines if line.get_label() == "near"}
        assert own <= {line.get_marker() for line in rest} | {"."}


def test_where_all_rest_there_are_no_squares():
    """The axis says it; the dots of very many are finer."""
    starts = [f"box-{n:03d}" for n in range(200)]
    shape, axes = (20, 200), data.axes(Omega=np.linspace(0.5, 5.0, 20), initial=starts)
    dataset = data.response(np.full(shape, "equilibrium"), np.ones(shape), axes, rows=[[]] * 4000)
    places = np.random.default_rng(1).normal(size=shape)
    dataset["phi_max"] = ("Omega", "initial"), places, {"units": "rad"}
    (ax,) = draw(dataset, figure("bifurcation")).axes
    assert "at rest" in ax.get_ylabel() and "at rest" not in legend_texts(ax)
    shown = [line for line in ax.lines if len(line.get_xdata())]
    assert {line.get_marker() for line in shown} == {"."}
    few = draw(dataset.isel(initial=slice(3)), figure("bifurcation"))
    assert max(map(drawn_size, shown)) < 0.8 * marked(few)


@pytest.mark.parametrize("kind", ["bifurcation", "curve"])
@pytest.mark.parametrize("ended", ["contact_lost", "diverged"])
def test_motions_that_ended_stand_among_the_gaps(kind, ended):
    dataset = data.bifurcation()
    codes = {name: code for code, name in flag_names(dataset["attractor"].attrs).items()}
    dataset["attractor"][dataset["Omega"].values > 4.0, 1] = codes[ended]
    wanted = {"variable": "L_s"} if kind == "curve" else {}
    (ax,) = draw(dataset, figure(kind, **wanted)).axes
    word = ended.replace("_", " ")
    (strip,) = [line for line in ax.lines if str(line.get_label()).startswith(word)]
    assert (strip.get_xdata() > 4.0).all() and len(strip.get_xdata()) == 10
    files = [("none", data.bifurcation()), ("some", dataset)]  # a class of one of them alone
    for drawn in (dataset, files):
        (ax,) = draw(drawn, figure("curve", variable="attractor")).axes
        assert not [line for line in ax.lines if str(line.get_label()).startswith(word)]


def test_colours_tell_families_and_marks_the_rest():
    """A key of a mark has no colour of a family, though only one of them has such marks."""
    one = resting()
    moving = one.assign(attractor=one["attractor"].where(one["attractor"] != 0, 1))
    moving["attractor"].attrs = one["attractor"].attrs
    (ax,) = draw([("soft", one), ("stiff", moving)], figure("bifurcation")).axes
    keys = {str(line.get_label()): line for line in ax.lines if not len(line.get_xdata())}
    assert {keys[word].get_marker() for word in ("soft", "stiff")} == {"None"}
    assert {to_hex(keys[word].get_color()) for word in ("near", "far", "at rest")} == {BLACK}
    drawn = [line for line in ax.lines if str(line.get_label()).endswith(", at rest")]
    assert {to_hex(line.get_color()) for line in drawn} == {BLACK}


def test_the_dots_of_one_start_have_an_entry_where_there_is_a_legend():
    near = figure("bifurcation", select={"initial": "near"})
    (ax,) = draw(with_eigenvalues(), near).axes
    told = {"start: near", "stable equilibrium", "unstable equilibrium"}
    assert {*legend_texts(ax)} == told
    assert len(marks(ax, "start: near")) == data.bifurcation()["section_row_size"][:, 0].sum()
    assert not draw(data.bifurcation(), near).findobj(Legend)
    far = draw(data.bifurcation(), figure("bifurcation", select={"initial": "far"})).axes[0]
    told = {"start: far", "failed", "undecided", "values where undecided"}
    assert {*legend_texts(far)} == told


def test_neutral_equilibria_of_what_is_undamped_are_lines_of_their_own():
    analyses = with_eigenvalues()
    stable = analyses["eigenvalues"]["stable"]
    words = {"stable": "neutral"}
    told = [words.get(word, word) for word in stable.attrs["flag_meanings"].split()]
    stable.attrs["flag_meanings"] = " ".join(told)
    (ax,) = draw(analyses, figure("bifurcation", select={"initial": "near"})).axes
    assert {"neutral equilibrium", "unstable equilibrium"} < {*legend_texts(ax)}


def test_what_is_undecided_has_a_key_of_the_colours_that_it_has():
    dataset = data.bifurcation()
    (ax,) = draw(dataset, figure("bifurcation")).axes
    colours = {name: to_hex(colour) for name, colour in points.colours([ax]).items()}
    assert colours["values where undecided"] == style.pale(colours["far"])
    dataset["attractor"][:, 0] = data.codes(data.ATTRACTORS, "undecided")
    (ax,) = draw(dataset, figure("bifurcation")).axes
    (key,) = [line for line in ax.lines if line.get_label() == "values where undecided"]
    halves = [to_hex(half) for half in (key.get_markerfacecolor(), key.get_markerfacecoloralt())]
    assert halves == [style.pale(colours["near"]), style.pale(colours["far"])]


def test_many_values_of_one_point_are_dots():
    """Of marks that lie on one another nothing is told."""
    few = data.bifurcation().isel(initial=[0])
    told = {}
    for count in (8, 9):
        rows = [[0.03 + 0.001 * n for n in range(count)]] * few.sizes["Omega"]
        dataset = data.response(
            np.full((few.sizes["Omega"], 1), "periodic", object), few["L_s"].values,
            data.axes(Omega=few["Omega"].values, initial=["near"]), rows=rows,
        )  # fmt: skip
        (ax,) = draw(dataset, figure("bifurcation")).axes
        told[count] = [line.get_markersize() for line in ax.lines if line.get_xdata().size > 1]
    assert told[9] < told[8]


def test_each_start_has_a_mark_that_shows_through_the_next():
    (ax,) = draw(data.bifurcation(), figure("bifurcation")).axes
    first, second = (
        next(line for line in ax.lines if line.get_label() == label) for label in ("near", "far")
    )
    assert first.get_marker() != second.get_marker()
    assert first.get_markerfacecolor() == "none"
    assert first.get_markersize() > second.get_markersize()


def test_marks_that_coincide_are_told_apart_and_are_those_of_the_legend():
    dataset = data.bifurcation().isel(initial=[0])
    dataset = dataset.isel(section_obs=slice(0, int(dataset["section_row_size"].sum())))
    four = [(label, dataset) for label in ("one", "two", "three", "four")]
    (ax,) = draw(four, figure("bifurcation")).axes
    drawn = [line for line in ax.lines if line.get_label() in dict(four)]
    assert len({line.get_marker() for line in drawn}) == 4
    for outer, inner in pairwise(drawn):
        assert outer.get_markerfacecolor() == "none"
        assert drawn_size(inner) < drawn_size(outer)
    assert drawn_size(drawn[-1]) < drawn_size(drawn[-2]) - 2 * drawn[-2].get_markeredgewidth()
    legend = ax.get_legend() or ax.figure.legends[0]
    keys = [key for key in legend.legend_handles if key.get_label() in dict(four)]
    assert [key.get_marker() for key in keys] == [line.get_marker() for line in drawn]


def drawn_size(line):
    """Diameter of a mark; of a point it is half of what it is said to be."""
    return line.get_markersize() * (0.5 if line.get_marker() == "." else 1.0)


def cycles_along_the_grid():
    """An analysis `cycle` of the same case: unstable below 2 rad/s, between 0.02 and 0.09 rad."""
    dims = ("Omega", "initial")
    omega, start = data.bifurcation()["Omega"].values, ["near"]
    stable = np.where(omega < 2.0, "unstable", "stable")[:, None]
    of_phi = {"units": "rad"}
    return xr.Dataset(
        {
            "status": data.statuses(dims, np.full((46, 1), "ok")),
            "cycle_period": (dims, np.ones((46, 1)), {"units": "s"}),
            "stable": data.flags(dims, stable, ("unstable", "stable")),
            "phi_min": (dims, np.full((46, 1), 0.02), of_phi),
            "phi_max": (dims, np.full((46, 1), 0.09), of_phi),
        },
        data.axes(Omega=omega, initial=start),
        data.attributes(),
    )


def test_a_single_start_over_branches_has_a_colour_and_an_entry_of_its_own():
    """Else what rests would pass for a stable cycle of no amplitude."""
    branch, swept = branch_along_the_speed(), data.bifurcation().isel(initial=[1])
    swept = swept.assign(phi_max=swept["L_s"].assign_attrs(units="rad", long_name="greatest phi"))
    branch["phi_max"] = ("N0", "initial"), [[3.0]], {"units": "rad", "long_name": "greatest phi"}
    layers = [("sweep", swept.assign_attrs(called="")), ("branch", branch)]
    (ax,) = draw(layers, figure("curve", x="Omega", variable="phi_max")).axes
    named = {text: line for line in ax.lines if (text := str(line.get_label()))[0] != "_"}
    start = f"start: {swept['initial'].item()}"
    assert {start, "stable cycle", "unstable cycle"} <= {*legend_texts(ax)}
    assert named[start].get_color() != named["stable cycle"].get_color()
    widths = [one.get_linewidth() for one in ax.lines if "cycle" in str(one.get_label())]
    assert max(widths) > named[start].get_linewidth()  # which is seen beneath it


def test_cycles_of_the_same_case_are_dashed_where_they_are_unstable():
    analyses = {"response": data.bifurcation(), "cycle": cycles_along_the_grid()}
    (ax,) = draw(analyses, figure("bifurcation", select={"initial": "far"})).axes
    low, high = (line[np.isfinite(line[:, 1])] for line in dashed(ax))
    assert low[:, 0].max() < 2.0
    assert {*low[:, 1], *high[:, 1]} == {0.02, 0.09}
    assert r"unstable cycle: extremes of $\varphi$" in legend_texts(ax)
    told = [note for note in style.notes_on(ax.figure) if "cycles on another section" in note]
    assert [note.partition(" ")[0] for note in told] == ["stable", "unstable"]


def test_cycles_lie_over_a_diagram_whichever_start_of_it_is_selected():
    both = cycles_along_the_grid().isel(initial=[0, 0])
    both = both.assign_coords(initial=["near", "guess"])
    known = both["initial"] == "guess"
    both = both.assign({name: both[name].where(known) for name in ("phi_min", "phi_max")})
    analyses = {"response": data.bifurcation(), "cycle": both}
    (ax,) = draw(analyses, figure("bifurcation", select={"initial": "near"})).axes
    low, high = (line[np.isfinite(line[:, 1])] for line in dashed(ax))
    assert {*low[:, 1], *high[:, 1]} == {0.02, 0.09}


def test_cycles_at_one_value_of_the_axis_are_marks():
    one = cycles_along_the_grid().isel(Omega=5)
    analyses = {"response": data.bifurcation(), "cycle": one}
    (ax,) = draw(analyses, figure("bifurcation", select={"initial": "far"})).axes
    dots = [
        line.get_xydata() for line in ax.lines if line.get_marker() == "o" and line.get_ms() < 3
    ]
    assert sorted(np.concatenate(dots)[:, 1]) == [0.02, 0.09]


def test_cycles_that_several_starts_find_are_drawn_once_and_single_ones_as_marks():
    """Else dashes filled one another's gaps, and what stands alone was not seen; whatever else
    advances with the axis of the diagram."""
    one = cycles_along_the_grid()
    fan = one.isel(initial=[0, 0, 0]).assign_coords(initial=["a", "b", "c"])
    omega = one["Omega"].values
    fan["phi_max"] = (
        fan["phi_max"]
        .where(fan["initial"] != "c", 0.5)
        .where((fan["initial"] != "c") | (fan["Omega"] == omega[5]))
    )
    fan["phi_min"] = fan["phi_min"].where(fan["phi_max"].notnull())
    fan = fan.rename_dims(Omega="both").assign_coords(mu_k=("both", omega))
    (ax,) = draw(
        {"response": data.bifurcation(), "cycle": fan},
        figure("bifurcation", select={"initial": "far"}),
    ).axes
    lines = [line[np.isfinite(line[:, 1])] for line in dashed(ax)]
    whole = [line[:, 1] for line in lines if len(line) > 5]
    assert sorted(line[0] for line in whole) == [0.02, 0.09]
    dots = [line.get_xydata() for line in ax.lines if line.get_marker() == "o"]
    assert [omega[5], 0.5] in np.concatenate(dots).tolist()


def with_eigenvalues():
    """`resting`, with its equilibria, which turn stable between 2.9 and 3 rad/s."""
    response, omega = resting(), data.bifurcation()["Omega"].values
    states = xr.DataArray(0.01 * omega, dims="Omega") * xr.ones_like(response["L_s"])
    response = response.assign(
        L_s_reference=states.expand_dims(state=["phi"]), L_s_reference_index=0.0 * states + 1.0
    )
    words = np.where(omega < 3.0, "unstable", "stable")
    eigenvalues = xr.Dataset(
        {
            "status": data.statuses(("Omega",), np.full(46, "ok")),
            "stable": data.flags(("Omega",), words, ("unstable", "stable")),
            "growth_rate": ("Omega", 3.0 - omega),
        },
        data.axes(Omega=omega),
        data.attributes(),
    )
    return {"response": response, "eigenvalues": eigenvalues}


def test_equilibria_that_leap_are_joined_by_no_line_and_no_table_has_a_place_between():
    """As where the drive of a contact changes its sense; and a turn lies between two points."""
    analyses = with_eigenvalues()
    states, x = analyses["response"]["L_s_reference"], analyses["response"]["Omega"].values
    analyses["response"]["L_s_reference"] = states.where(states["Omega"] > x[9], -0.1)
    drawn = draw(analyses, figure("bifurcation"))
    lines = [one.get_xydata() for one in drawn.axes[0].lines if "equilibrium" in one.get_label()]
    between = [one[(one[:, 0] > x[9]) & (one[:, 0] < x[10]), 1] for one in lines if len(one) > 2]
    assert any(one.size for one in between) and np.isnan(np.concatenate(between)).all()
    rows = list(csv.DictReader(as_csv(drawn, Path("a.csv")).splitlines()))
    told = {float(row["x"]) for row in rows if row["series"].endswith("able equilibrium")}
    assert told == {*x}


def test_cycles_and_equilibria_of_cases_with_other_points_lie_in_a_diagram():
    """In whichever order, also where they have few points, one section value or none in common."""
    friction = {"law": "stribeck", "mu_s": 0.4, "mu_k": 0.2, "v_s": 0.2}
    case = {
        "schema": 1,
        "model": {"name": "belt-1dof", "parameters": {"c": 0.15}},
        "friction": friction,
        "initial": [{"kind": "equilibrium", "label": "near", "offset": {"x": 0.1}}],
    }
    section = {"zero": "x_dot", "direction": "down"}
    linearised = [{"kind": "equilibrium"}, {"kind": "eigenvalues"}]
    analyses = {
        "sweep": [{"kind": "response", "section": section, "t_max": 300.0}, *linearised],
        "plain": [{"kind": "response", "section": section, "t_max": 300.0}],
        "rests": linearised,
        "cycle": [{"kind": "cycle", "section": section, "t_max": 300.0}],
        "alone": [{"kind": "cycle", "section": section, "t_max": 300.0}],
    }
    speeds = {"rests": np.linspace(0.05, 0.45, 9), "cycle": [0.21, 0.25, 0.3], "alone": [0.3]}
    analyses["point"] = linearised  # at one speed, which leads along nothing
    speeds["point"] = [0.2]
    found = {}
    for name, asked in analyses.items():
        grid = {"v": list(speeds.get(name, np.linspace(0.1, 0.4, 11)))}
        grid |= {"N": [0.5, 1.0] if name == "rests" else [1.0]}
        answer = api.run(api.load({**case, "grid": grid, "analysis": asked}), workers=1)
        if isinstance(answer, xr.DataTree):
            answer = {one: each.to_dataset() for one, each in answer.children.items()}
        found[name] = answer
    every, point = {}, found.pop("point")
    lone = {one: each.squeeze("v") for one, each in point.items()}
    for beside in (point, lone):
        layers = [("plain", found["plain"]), ("point", beside), ("rests", found["rests"])]
        (ax,) = draw(layers, figure("bifurcation")).axes
        known = {x for line in ax.lines if "equilibrium" in str(line.get_label())
                 for x in line.get_xdata()}  # fmt: skip
        assert {*found["rests"]["equilibrium"]["v"].values} <= known
    for chosen, first in product(combinations(found, 3), range(3)):
        if not {"sweep", "plain"} & {*chosen} or {"sweep", "plain"} < {*chosen}:
            continue
        names = chosen[first:] + chosen[:first]  # each is the first, and each of two is before
        (ax,) = draw([(name, found[name]) for name in names], figure("bifurcation")).axes
        lines = [one for one in ax.lines if "equilibrium" in str(one.get_label())]
        known = {(x, y) for line in lines for x, y in line.get_xydata().tolist() if np.isfinite(y)}
        assert every.setdefault(frozenset(names), known) == known
        if {"sweep", "rests"} & {*names}:
            own = "sweep" if "sweep" in names else "rests"
            assert {*found[own]["equilibrium"]["v"].values} <= {x for x, _ in known}
        cycles = any("stable cycle" in word for word in legend_texts(ax))
        assert cycles == bool({"cycle", "alone"} & {*names})


def test_equilibria_of_which_none_is_known_to_be_stable_are_told_to_be_left_out():
    response, eigenvalues = with_eigenvalues().values()
    rests = eigenvalues.drop_vars(["stable", "growth_rate"]).assign(equilibrium=response["L_s"])
    notes = style.notes_on(
        draw({"response": response, "equilibrium": rests}, figure("bifurcation"))
    )
    assert any("add an analysis `eigenvalues`" in note for note in notes)
    notes = style.notes_on(draw(with_eigenvalues(), figure("bifurcation")))
    assert not any("analysis `eigenvalues`" in note for note in notes)


def test_equilibria_of_the_same_case_are_drawn_by_their_stability():
    omega = data.bifurcation()["Omega"].values
    analyses = with_eigenvalues()
    response, eigenvalues = analyses.values()
    words = class_names(eigenvalues["stable"])
    (ax,) = draw(analyses, figure("bifurcation")).axes
    lines = {line.get_label(): line.get_xydata() for line in ax.lines}
    for word in ("stable", "unstable"):
        drawn = lines[f"{word} equilibrium"]
        there = drawn[np.isfinite(drawn[:, 1])]
        np.testing.assert_array_equal(there[there[:, 0] != 2.95, 0], omega[words == word])
        assert (there[0] if word == "stable" else there[-1])[0] == 2.95  # where both lines meet
        np.testing.assert_allclose(there[:, 1], 0.01 * there[:, 0])
    (equilibrium,) = [line for line in ax.lines if line.get_label() == "stable equilibrium"]
    marked = [line for line in ax.lines if line.get_zorder() > equilibrium.get_zorder()]
    resting_x = np.concatenate([line.get_xdata() for line in marked])
    assert {*omega[30:]} <= {*resting_x}  # what came to rest lies upon the line, in its own mark
    assert "_" not in {line.get_marker() for line in marked}
    later = {"response": response, "eigenvalues": later_stable(eigenvalues)}
    (ax,) = draw([("one", analyses), ("two", later)], figure("bifurcation")).axes
    drawn = [line for line in ax.lines if line.get_linestyle() == "-" and len(line.get_xdata())]
    begin = {
        to_hex(line.get_color()): line.get_xdata()[np.isfinite(line.get_ydata())].min()
        for line in drawn
    }
    # where both are stable black, upon the colours of both
    assert begin.pop(BLACK.lower()) == pytest.approx(3.95)
    assert sorted(begin.values()) == pytest.approx([2.95, 3.95])
    turns = {to_hex(line.get_color()): line.get_xdata().tolist() for line in ax.lines
             if line.get_marker() == "|" and len(line.get_xdata())}  # fmt: skip
    assert {colour: [at] for colour, at in begin.items()} == turns  # ... of which each is marked
    assert "equilibrium turns stable or unstable" in legend_texts(ax)
    (ax,) = draw([("one", analyses)], figure("bifurcation")).axes
    assert "|" not in {line.get_marker() for line in ax.lines if line.get_visible()}
    short = {name: one.isel(Omega=slice(35)) for name, one in analyses.items()}
    (ax,) = draw([("all", analyses), ("part", short)], figure("bifurcation")).axes
    drawn = [line for line in ax.lines if line.get_linestyle() == "-" and len(line.get_xdata())]
    x, y = drawn[-1].get_data()
    assert to_hex(drawn[-1].get_color()) == BLACK.lower() and x.max() == omega[34]
    assert {*x[np.isfinite(y)]} == {2.95, *omega[:35][words[:35] == "stable"]}
    (ax,) = draw([("one", analyses), ("two", analyses)], figure("bifurcation")).axes
    drawn = [line for line in ax.lines if line.get_linestyle() == "-" and len(line.get_xdata())]
    assert to_hex(drawn[-1].get_color()) == BLACK.lower()  # upon the same of the other diagram


def test_a_rest_through_which_no_line_of_equilibria_is_drawn_keeps_its_mark():
    """None is where eigenvalues failed, or are of another grid; or what sticks is off the line."""
    response, eigenvalues = with_eigenvalues().values()
    omega = eigenvalues["Omega"].values
    late, off = omega > 4.0, omega == omega[32]
    words = np.where(omega < 3.0, "unstable", np.where(late, "not_computed", "stable"))
    failed = eigenvalues.assign(stable=data.flags(("Omega",), words, ("unstable", "stable")))
    response["phi_max"] = response["phi_max"].where(~off[:, None], 0.05)
    response["stick_fraction"] = response["L_s"] * 0.0 + 1.0
    for judged in (failed, eigenvalues.isel(Omega=~late)):
        both = {"response": response, "eigenvalues": judged}
        (ax,) = draw(both, figure("bifurcation")).axes
        np.testing.assert_array_equal(marks(ax, "_near, at rest")[:, 0], omega[late | off])
        told = (omega >= 3.5) & ~late & ~off
        np.testing.assert_array_equal(marks(ax, "_near, equilibrium")[:, 0], omega[told])
        assert {"at rest", "stable equilibrium"} <= {*legend_texts(ax)}


@pytest.mark.parametrize(
    ("found", "met"), [([2.96], 2.96), ([2.92, 2.94, 2.97], 2.95), ([1.05], 2.95), ([0.1, 9], 2.95)]
)
def test_lines_of_equilibria_meet_where_a_critical_value_says_or_midway(found, met):
    """Between the points of the grid; three between two of them, or one elsewhere, say nothing."""
    critical = xr.Dataset(
        {
            "status": data.statuses((), np.array("ok")),
            "critical_value": ("crossing", found, {"long_name": "critical value of Omega"}),
        },
        attrs=data.attributes(),
    )
    layers = [("", with_eigenvalues()), ("critical", critical)]
    (ax,) = draw(layers, figure("bifurcation")).axes
    lines = {line.get_label(): line.get_xydata() for line in ax.lines}
    stable, unstable = (lines[f"{word}stable equilibrium"] for word in ("", "un"))
    stable, unstable = (line[np.isfinite(line[:, 1])] for line in (stable, unstable))
    turns = [one.get_xdata() for one in ax.lines if one.get_marker() == "|" and one.get_visible()]
    seen = [at for of in turns for at in of]  # what a critical value tells has a mark
    assert seen == ([met] if met == found[0] else [])
    assert [at for at in stable[:, 0] if at in unstable[:, 0]] == [met]
    np.testing.assert_allclose(stable[:, 1], 0.01 * stable[:, 0])
    assert stable[0].tolist() == unstable[-1].tolist()
    others = critical.assign(critical_value=critical["critical_value"] + 1.0)
    of_several = xr.concat([critical, others], "c")
    of_several = of_several.assign_coords(c=[0.1, 0.2]).assign_attrs(critical.attrs)
    here = {name: one.assign_coords(c=0.1) for name, one in with_eigenvalues().items()}
    for apart in (of_several, of_several.isel(c=[0])):  # of one value, and of that among others
        (ax,) = draw([("", here), ("critical", apart)], figure("bifurcation")).axes
        (line,) = [one for one in ax.lines if one.get_label() == "stable equilibrium"]
        drawn = line.get_xydata()
        np.testing.assert_array_equal(drawn[np.isfinite(drawn[:, 1])], stable)
    other = critical["critical_value"].assign_attrs(long_name="critical value of N0")
    with pytest.raises(UsageError, match="critical: nothing that a bifurcation diagram"):
        draw(
            [layers[0], ("critical", critical.assign(critical_value=other))], figure("bifurcation")
        )


def test_lines_of_equilibria_meet_where_growth_rates_are_zero_without_a_critical_value():
    """By a straight line between two points; a table of marks says so."""
    analyses = with_eigenvalues()
    analyses["eigenvalues"]["growth_rate"] -= 0.07  # zero at 2.93, between 2.9 and 3
    (ax,) = draw(analyses, figure("bifurcation")).axes
    for word, end in (("stable", 0), ("unstable", -1)):
        (line,) = [one for one in ax.lines if one.get_label() == f"{word} equilibrium"]
        x, y = line.get_data()
        assert (x[np.isfinite(y)][end], y[np.isfinite(y)][end]) == pytest.approx((2.93, 0.0293))
    both = draw([("one", analyses), ("two", with_eigenvalues())], figure("bifurcation"))
    (ax,) = both.axes
    told = {str(one.get_label()): one.get_xdata().tolist() for one in ax.lines
            if one.get_marker() == "|" and len(one.get_xdata())}  # fmt: skip
    assert told["_one, read between points, equilibrium turns stable or unstable"] == pytest.approx(
        [2.93]
    )
    table = as_csv(draw(analyses, figure("bifurcation")), Path("a.csv"))
    rows = [row for row in csv.DictReader(table.splitlines()) if row["x"] == "2.93"]
    # the lines lead there, where nothing was computed: that is told by their end alone
    assert [row["series"] for row in rows] == [
        "read between points, equilibrium turns stable or unstable"
    ]
    assert "equilibrium turns stable or unstable" in legend_texts(ax)


def test_of_several_lines_each_turns_where_its_own_critical_value_says():
    """A file with several values of another axis told none of them, or took one for all."""
    one = with_eigenvalues()
    found = [[2.91], [2.97], [2.99]]
    told = {"long_name": "critical value of Omega"}
    critical = xr.Dataset(
        {
            "status": data.statuses(("N0",), np.full(3, "ok")),
            "critical_value": (("N0", "crossing"), found, told),
        },
        data.axes(N0=[1.0, 2.0, 3.0]),
        attrs=data.attributes(),
    )
    for place, met in zip((1.0, 2.0), (2.91, 2.97), strict=True):
        here = {name: part.assign_coords(N0=place) for name, part in one.items()}
        (ax,) = draw([("", here), ("critical", critical)], figure("bifurcation")).axes
        lines = [line for line in ax.lines if line.get_marker() == "|" and line.get_visible()]
        assert [at for line in lines for at in line.get_xdata()] == [met]


def test_a_line_of_equilibria_does_not_lead_to_where_there_is_none():
    """Where it ended, or eigenvalues failed, the line stops at the neighbour."""
    response, eigenvalues = with_eigenvalues().values()
    omega = eigenvalues["Omega"].values
    ended = response.assign(L_s_reference=response["L_s_reference"].where(omega[:, None] < 2.95))
    words = np.where(np.isclose(omega, 3.0), "not_computed", class_names(eigenvalues["stable"]))
    failed = eigenvalues.assign(stable=data.flags(("Omega",), words, ("unstable", "stable")))
    for one, other in ((ended, eigenvalues), (response, failed)):
        (ax,) = draw({"response": one, "eigenvalues": other}, figure("bifurcation")).axes
        unstable = marks(ax, "unstable equilibrium")
        assert unstable[np.isfinite(unstable[:, 1]), 0].max() == omega[24]


def later_stable(eigenvalues):
    """Of another damping: stable from 4 rad/s on."""
    words = np.where(eigenvalues["Omega"].values < 4.0, "unstable", "stable")
    return eigenvalues.assign(stable=data.flags(("Omega",), words, ("unstable", "stable")))


def test_panels_of_a_joined_dataset_name_all_that_differs():
    one = data.stability_map(initial=("reached",))
    both = xr.concat([one, one], xr.Variable("c1", [0.1, 1.0], {"units": "N s m-1"}))
    both = both.assign_coords(c2=("c1", [0.2, 2.0], {"units": "N s m-1"}))
    titles = [ax.get_title() for ax in draw(both, figure("map", x="Omega", y="N0")).axes[:2]]
    assert titles == [
        f"$c_{{1}}$ = {a} N s/m, $c_{{2}}$ = {b} N s/m" for a, b in ((0.1, 0.2), (1, 2))
    ]


def test_datasets_of_different_titles_have_none_in_one_figure():
    one, other = (data.bifurcation().assign_attrs(title=title) for title in ("one", "other"))
    for second, told in ((one, True), (other, False)):
        drawn = draw([("a", one), ("b", second)], figure("bifurcation"))
        assert ("one" in drawn.get_suptitle()) == told


def test_a_branch_may_be_laid_over_a_bifurcation_diagram_along_its_parameter():
    response = data.bifurcation()
    named = [("", response), ("branch", branch_along_the_speed())]
    low, high = dashed(draw(named, figure("bifurcation")).axes[0])
    begins = [2.2, 2.2]  # where it flips, which no cycle of it is computed at
    np.testing.assert_allclose(high, [begins, [2.0, 2.0], [1.5, 1.5], [1.0, 1.0]])
    np.testing.assert_array_equal(low[:, 1], 0.0)
    other = [("", response), ("branch", branch_along_the_speed("N0"))]
    with pytest.raises(UsageError, match="branch: nothing that a bifurcation diagram along Omega"):
        draw(other, figure("bifurcation"))


@pytest.mark.parametrize("chosen", [True, False])
def test_unstable_cycles_are_drawn_at_the_section_of_the_diagram(chosen):
    """Of as many points as each passes there; where sections differ, by their extremes."""
    response = on_section(data.bifurcation(), "response", chosen)
    sizes = xr.full_like(branch_along_the_speed()["branch_row_size"], 7)
    branch = branch_along_the_speed().assign(
        branch_multiplicity=("branch_obs", [1.0, 2.0, 2.0, 2.0]),
        branch_section_row_size=sizes.assign_attrs(sample_dimension="branch_section_obs"),
        branch_section=("branch_section_obs", [9.0, 0.3, 0.2, 0.15, 0.25, 0.1, 0.2]),
    )
    along = [("", response), ("branch", on_section(branch, "cycle", chosen))]
    (ax,) = draw(along, figure("bifurcation")).axes
    low, high = (line[np.isfinite(line[:, 1])] for line in dashed(ax))
    np.testing.assert_allclose(low[-3:], [[2.0, 0.2], [1.5, 0.15], [1.0, 0.1]])
    np.testing.assert_allclose(high, [[2.0, 0.3], [1.5, 0.25], [1.0, 0.2]])
    assert [[3.0, 9.0]] in [line.tolist() for line in dashed(ax, "-")]  # of one point, no line on
    assert {"stable cycle", "unstable cycle"} <= {*legend_texts(ax)}
    other = on_section(branch, "cycle", chosen, "stick->slip")
    apart = [
        branch.assign(branch_multiplicity=sizes * branch["branch_multiplicity"])
        for sizes in (np.nan, xr.zeros_like(branch["branch_multiplicity"]))
    ]  # none is passed
    for one in (other, *(on_section(sliding, "cycle", chosen) for sliding in apart)):
        (ax,) = draw([("", response), ("branch", one)], figure("bifurcation")).axes
        assert {*dashed(ax)[0][:, 1]} == {0.0}
    sliding = branch.assign(
        branch_multiplicity=("branch_obs", [1.0, 2.0, 2.0, 0.0]),
        branch_section_row_size=sizes * 0 + 5,
        branch_section=("branch_section_obs", [9.0, 0.3, 0.2, 0.15, 0.25]),
    )  # the last passes none: of it alone both extremes
    sliding["branch_section_row_size"].attrs = sizes.attrs | {
        "sample_dimension": "branch_section_obs"
    }
    both = [("", response), ("branch", on_section(sliding, "cycle", chosen))]
    (ax,) = draw(both, figure("bifurcation")).axes
    drawn = [line[np.isfinite(line[:, 1])].tolist() for line in dashed(ax)]
    assert [[1.0, 0.0]] in drawn and [[1.0, 1.0]] in drawn
    assert {"unstable cycle", r"unstable cycle: extremes of $\varphi$"} <= {*legend_texts(ax)}


def test_a_branch_beyond_the_grid_is_followed_to_what_happens_to_it_only():
    response = data.bifurcation()
    response = response.sel(Omega=response["Omega"] >= 1.5).assign_attrs(response.attrs)
    (ax,) = draw([("", response), ("branch", branch_along_the_speed())], figure("bifurcation")).axes
    low, high = ax.get_xlim()
    assert 1.0 < low < 1.5 and 5.0 < high < 5.5
    (note,) = [one for one in style.notes_on(ax.figure) if "beyond the frame" in one]
    (shown,) = re.findall(r"xlim = (\[.*\])", note)
    both = [("", response), ("branch", branch_along_the_speed())]
    (wide,) = draw(both, figure("bifurcation", xlim=json.loads(shown))).axes
    assert wide.get_xlim()[0] <= 1.0 and "beyond" not in "".join(style.notes_on(wide.figure))
    from_zero = response.assign_coords(Omega=response["Omega"] - 1.5)
    along = [("", from_zero), ("branch", branch_along_the_speed())]
    (ax,) = draw(along, figure("bifurcation", log="x")).axes
    assert 0.0 < ax.get_xlim()[0] < 0.1


@pytest.mark.parametrize(
    ("known", "dashes", "marker"),
    [([2], "None", "o"), ([0, 1, 3], "--", "o"), ([0, 1, 2], "--", "None")],
)
def test_a_cycle_that_no_line_leads_to_is_a_mark_that_the_legend_has(known, dashes, marker):
    cycles = cycles_along_the_grid()
    found = np.isin(np.arange(46), known)
    for name in ("phi_min", "phi_max"):
        cycles[name] = cycles[name].where(xr.DataArray(found, dims="Omega"))
    drawn = draw({"response": data.bifurcation(), "cycle": cycles}, figure("bifurcation"))
    called = r"unstable cycle: extremes of $\varphi$"
    (entry,) = [line for line in drawn.axes[0].lines if line.get_label() == called]
    assert (entry.get_linestyle(), entry.get_marker()) == (dashes, marker)


def test_cycles_of_the_grid_are_drawn_at_the_section_of_the_diagram():
    cycles = cycles_along_the_grid()
    sizes = xr.full_like(cycles["phi_min"], 2, int).assign_attrs(sample_dimension="section_obs")
    passed = ("section_obs", np.tile([0.05, 0.03], 46), {"long_name": "phi at the section"})
    cycles = on_section(cycles.assign(section_row_size=sizes, section_value=passed), "cycle", False)
    response = on_section(data.bifurcation(), "response", False)
    (ax,) = draw({"response": response, "cycle": cycles}, figure("bifurcation")).axes
    heights = [{*line[np.isfinite(line[:, 1]), 1]} for line in dashed(ax)]
    assert heights == [{0.03}, {0.05}] and "unstable cycle" in legend_texts(ax)


def on_section(dataset, kind, chosen, event="slip->stick"):
    """A dataset whose points lie on a section that the case asked for, or the motions chose."""
    if not chosen:
        asked = {"kind": kind, "settings": {"section": Section("event", event).__dict__}}
        return dataset.assign_attrs(analyses_json=json.dumps({kind: asked}))
    dims, shape = dataset["status"].dims, dataset["status"].shape
    names = np.full(shape, event.replace("->", "_to_"), object)
    names.flat[1:2] = "not_computed"
    kinds = data.flags(dims, names, ("not_computed", "slip_to_stick", "stick_to_slip"))
    return dataset.assign(section_kind=kinds, section_contact=(dims, np.ones(shape)))


def test_a_diagram_of_an_analysis_takes_branches_from_datasets_that_have_no_such():
    asked = figure("bifurcation", analysis="response")
    ends = {"critical": data.eigenvalues(), "cycle": branch_along_the_speed()}
    (ax,) = draw([("sweep", {"response": data.bifurcation()}), ("ends", ends)], asked).axes
    assert len(dashed(ax)) == 2 and {"near", "far"} <= {*legend_texts(ax)}
    with pytest.raises(UsageError, match="response: no analysis of this dataset"):
        draw([("ends", ends), ("again", ends)], asked)
    with pytest.raises(UsageError, match="response: no analysis of this dataset"):
        draw([("sweep", {"response": data.bifurcation()}), ("ends", ends)],
             figure("curve", analysis="response", variable="L_s"))  # fmt: skip


@pytest.mark.parametrize(
    ("preloads", "lines"), [((30.0,), 2), ((10.0, 30.0), 2), ((20.0,), 0), ((10.0, 20.0), 0)]
)
def test_only_branches_at_the_fixed_parameters_of_a_diagram_are_laid_over_it(preloads, lines):
    response = data.bifurcation().assign_coords(N0=30.0)
    named = [("", response), ("branch", branch_along_the_speed(preloads=preloads))]
    near = figure("bifurcation", select={"initial": "near"})  # no start of the branch is called so
    if lines:
        assert len(dashed(draw(named, near).axes[0])) == lines
    else:
        with pytest.raises(EmptyFigureError, match="the branch branch is of other parameters"):
            draw(named, near)


@pytest.mark.parametrize("axis", [False, True])
def test_only_branches_of_its_law_and_options_are_laid_over_a_diagram(axis):
    diagram = data.bifurcation().assign_attrs(law="coulomb", options_json='{"impact": "plastic"}')
    for impact, lines in (("plastic", 2), ("thesis", 0)):
        branches = branch_along_the_speed(preloads=(30.0,)).assign_attrs(law="coulomb")
        branches.attrs["options_json"] = json.dumps({"impact": impact})
        if axis:  # the options tell the default where the grid varies it
            branches = branches.assign_coords(impact=impact)
            branches.attrs["options_json"] = '{"impact": "plastic"}'
        named = [("", diagram), ("branch", branches)]
        if lines:
            assert len(dashed(draw(named, figure("bifurcation")).axes[0])) == lines
        else:
            with pytest.raises(EmptyFigureError, match="the branch branch is of other parameters"):
                draw(named, figure("bifurcation"))


@pytest.mark.parametrize(("ends", "place"), [([2.6, 9.0], 2.6), ([3.4], 3.4), ([9.0], 2.5)])
def test_pieces_of_a_branch_meet_where_its_stability_changes(ends, place):
    """Also at a fold, beyond both cycles; midway where what changes it was not found."""
    one = branch_along_the_speed().drop_dims("cycle_end_obs")
    sizes = (
        one["branch_row_size"]
        .copy(data=[[len(ends)]])
        .assign_attrs(sample_dimension="cycle_end_obs")
    )
    one = one.assign(cycle_end=("cycle_end_obs", ends), cycle_end_row_size=sizes)
    (first, x, *_), (then, others, *_) = stretches(one, {"N0": 0, "initial": 0})
    assert (first, then) == ("stable", "unstable")
    assert (x[-1], others[0]) == (place, place)


def test_a_branch_changes_at_a_grazing_not_at_a_fold_that_lies_behind_it():
    """It comes from 2.0 to a grazing at 3.0 and goes on, unstable, to a fold at 1.4."""
    one = branch_along_the_speed()
    at = one["branch_value"].copy(data=[2.0, 3.0, 1.6, 1.45])
    stable = ["stable", "stable", "unstable", "unstable"]
    flags = data.flags("branch_obs", stable, ("unstable", "stable"))
    kinds = data.flags("cycle_end_obs", ["grazing", "fold"], ("grazing", "fold"))
    ends = one["cycle_end"].copy(data=[3.0, 1.4])
    found = one.assign(branch_value=at, branch_stable=flags, cycle_end_kind=kinds, cycle_end=ends)
    (first, x, *_), (then, others, *_) = stretches(found, {"N0": 0, "initial": 0})
    assert (first, then) == ("stable", "unstable")
    assert (x[-1], others[0]) == (3.0, 3.0)


def test_each_diagram_has_the_branches_of_its_own_parameters():
    """In its colour, and called as it is, though a branch has the same parameter."""
    made = {}
    for value in (20.0, 30.0):
        ends = branch_along_the_speed(preloads=(value,)).isel(N0=0)
        made[f"sweep-{value}"] = data.bifurcation().assign_coords(N0=ends["N0"])
        made[f"ends-{value}"] = ends
    names = words.told_apart([*made.items()])
    assert [name.partition(" = ")[2] for name in names] == ["20 N", "20 N", "30 N", "30 N"]
    another = ("begun-elsewhere", made["ends-30.0"])
    assert words.told_apart([*made.items(), another]) == [*names, names[-1]]
    near = figure("bifurcation", select={"initial": "near"})
    (ax,) = draw([*zip(names, made.values(), strict=True)], near).axes
    lines = [line for line in ax.lines if line.get_linestyle() == "--" and len(line.get_xdata())]
    assert len(lines) == 4 and len({line.get_color() for line in lines}) == 2
    assert sum("unstable cycle" in text for text in legend_texts(ax)) == 1
    whose = [line.get_label().partition(",")[0] for line in lines]
    assert {*whose} == {f"_{name}" for name in names}


def test_that_two_runs_agree_or_a_branch_holds_fixed_what_points_vary_is_told():
    """Marks of the former lay beneath those of the latter, all of them, without a word."""
    runs = [(name, data.bifurcation()) for name in ("coarse", "fine")]
    told = style.notes_on(draw(runs, figure("bifurcation")))
    assert any("coarse, near" in note and "lie beneath those of fine" in note for note in told)
    runs[1] = "fine", runs[1][1].assign(section_value=runs[1][1]["section_value"] + 1.0)
    told = style.notes_on(draw(runs, figure("bifurcation")))
    assert not any("lie beneath" in note for note in told)
    held = branch_along_the_speed().isel(N0=0).assign_coords(mu_s=((), 1.6, {"units": "1"}))
    points = data.bifurcation()
    points = points.assign_coords(mu_s=("Omega", points["Omega"].values))
    sweeps = [points, points.drop_vars("mu_s").assign_coords(mu_s=held["mu_s"])]
    sweeps = [one.assign_attrs(analyses_json=f'{{"settings": {{"t_max": {n}.0}}}}')
              for n, one in enumerate(sweeps)]  # fmt: skip
    called = words.told_apart([("a", sweeps[0]), ("b", sweeps[1])])  # not by what decides nothing
    assert called == ["$\\mu_{s}$ = $\\Omega$", "$\\mu_{s}$ = 1.6"]
    names = words.told_apart([("sweep", points), ("branch", held)])
    told = style.notes_on(draw([(names[0], points), (names[1], held)], figure("bifurcation")))
    said = [note for note in told if note.startswith("branches are those at")]
    assert said == ["branches are those at $\\mu_{s}$ = 1.6, which the points vary with Omega"]


def test_marks_that_would_hide_a_line_are_left_out_but_where_no_line_leads():
    values = np.linspace(1.0, 2.0, 400)
    values[[200, 202]] = np.nan
    dataset = data.response(np.full(400, "periodic", object), values, {"v": np.arange(400.0)})
    drawn = draw(dataset, figure("curve", variable="L_s"))
    (line,) = [line for line in drawn.axes[0].lines if len(line.get_xdata()) > 1]
    (alone,) = line.get_markevery()
    assert line.get_xdata()[alone] == 201.0
    (few,) = draw(dataset.isel(v=slice(40)), figure("curve", variable="L_s")).axes[0].lines[:1]
    assert (few.get_marker(), few.get_markevery()) == (".", None)


@pytest.mark.parametrize("kind", ["bifurcation", "curve"])
def test_a_figure_that_would_be_empty_says_why(kind, stored):
    dataset = data.bifurcation().isel(Omega=[20, 20], initial=[1])
    dataset = dataset.isel(section_obs=[]).assign_attrs(data.attributes(figure(kind)))
    with pytest.raises(EmptyFigureError, match=r"none of the 2 points has a value \(failed 2\)"):
        draw(dataset, figure(kind))
    dataset.to_netcdf("failed.nc")
    with pytest.raises(EmptyFigureError, match=rf"{kind} of .*failed.nc: not written: .*failed 2"):
        run(plot_command, "failed.nc")
    class_too = data.attributes(figure(kind), figure("curve", variable="attractor"))
    filled = dataset.assign(attractor=dataset["attractor"] * 0).assign_attrs(class_too)
    filled["attractor"].attrs = dataset["attractor"].attrs
    filled.to_netcdf("filled.nc")
    result = run(plot_command, "filled.nc")
    assert "not written" in result.stderr
    assert len(result.stdout.split()) == len(list(stored.glob("*.png"))) == 1


def test_one_figure_that_cannot_be_drawn_leaves_the_others(stored):
    classes = FigureSpec("classes", "curve", {"variable": "attractor"})
    figures = figure("curve", variable="gone"), classes
    dataset = data.bifurcation().assign_attrs(data.attributes(*figures))
    dataset.to_netcdf("wrong.nc")
    with pytest.raises(UsageError, match=r"curve of .*wrong\.nc: not written: gone"):
        run(plot_command, "wrong.nc")
    assert [path.name for path in stored.glob("wrong-*.png")] == ["wrong-classes.png"]


def test_many_starts_do_not_print_their_labels_over_each_other():
    starts = [f"far-{number:03d}" for number in range(200)]
    dataset = data.response(
        np.full(200, "periodic", object), np.arange(200.0), data.axes(initial=starts)
    )
    (ax,) = draw(dataset, figure("curve", variable="L_s")).axes
    printed = [tick.get_text() for tick in ax.get_xticklabels()]
    assert printed[0] == "far-000"
    assert 4 <= len(printed) <= 15
    (line,) = [line for line in ax.lines if len(line.get_xdata()) == 200]
    assert line.get_linestyle() == "None"  # between two starts there is nothing


def test_kinds_of_one_dataset_refuse_several():
    with pytest.raises(UsageError, match="shows one dataset"):
        draw([("a", data.stability_map()), ("b", data.stability_map())], figure("map"))


def test_marks_of_a_partial_run_are_as_large_as_those_there_are_have_room():
    """Two points of 8001 were specks."""
    classes = np.full((4000, 1), "not_computed", object)
    classes[:2] = "periodic"
    rows = [[0.1], [0.2], *([[]] * 3998)]
    axes = data.axes(Omega=np.arange(4000.0), initial=["far"])
    found = data.response(classes, np.ones((4000, 1)), axes, rows=rows)
    sizes = [
        max(line.get_markersize() for line in ax.lines if line.get_marker() == ".")
        for one in (found, found.assign_attrs(partial="2 of 4000 points"))
        for ax in draw(one, figure("bifurcation")).axes
    ]
    assert sizes[1] > 1.5 * sizes[0]
