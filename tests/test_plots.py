"""Figures: what is drawn is what the dataset holds, labelled, and the same bytes each time."""

import csv
import json
import re
from itertools import combinations, pairwise, product
from pathlib import Path

import numpy as np
import pytest
import synthetic_datasets as data
import xarray as xr
from click.testing import CliRunner
from matplotlib.collections import LineCollection, PolyCollection, QuadMesh
from matplotlib.colors import BoundaryNorm, LogNorm, to_hex
from matplotlib.contour import ContourSet
from matplotlib.figure import Figure
from matplotlib.legend import Legend
from matplotlib.lines import Line2D
from matplotlib.text import Text

from fiv_cli import api
from fiv_cli.case.case import FigureSpec
from fiv_cli.cli.plot import Millimetres
from fiv_cli.cli.plot import command as plot_command
from fiv_cli.cli.show import command as show_command
from fiv_cli.dynamics.settings import Section
from fiv_cli.errors import CaseError, EmptyFigureError, InputError, StorageError, UsageError
from fiv_cli.flags import COMPUTED, REASON, advice
from fiv_cli.friction import get_law
from fiv_cli.plots import (
    default_figures,
    draw,
    draw_laws,
    drawing,
    figures_of,
    leaps,
    legends,
    levels,
    look_of,
    motion,
    phase,
    points,
    save,
    smooth,
    style,
)
from fiv_cli.plots import labels as words
from fiv_cli.plots.branch import stretches
from fiv_cli.plots.cloud_marks import FINEST
from fiv_cli.plots.critical_lines import _is_inside
from fiv_cli.plots.curve_lines import _narrowed
from fiv_cli.plots.drawing import _meant
from fiv_cli.plots.drawn import DECORATION, as_csv, in_one_line
from fiv_cli.plots.fitting import tame_texts
from fiv_cli.plots.law import force
from fiv_cli.plots.levels import MOST_WRITTEN
from fiv_cli.plots.points import GAP_MARKS
from fiv_cli.plots.spectrum import amplitude_spectrum
from fiv_cli.plots.style import (
    BLACK,
    class_colours,
    dot_size,
    finer,
    line_colours,
)
from fiv_cli.reading import sampling
from fiv_cli.reading.datasets import class_names, flag_names, is_class
from fiv_cli.reading.summary import lines as summary_lines
from fiv_cli.reading.summary import summarise
from fiv_cli.reading.take import taken

AT_A_JUMP = "a mode turns stable, at a jump"
SLIP_PLUS, SLIP_MINUS = r"slip+ ($v_\mathrm{rel} > 0$)", r"slip$-$ ($v_\mathrm{rel} < 0$)"
REST_ABOVE = "periodic below, equilibrium above"
UNDECIDED_ABOVE = "periodic below, undecided above"


def figure(kind, **settings):
    return FigureSpec(kind, kind, settings)


def marks(ax, label):
    """Points of the line with this label, shape (n, 2)."""
    (line,) = [line for line in ax.lines if line.get_label() == label]
    return line.get_xydata()


def legend_texts(owner):
    """Entries of the legend of a panel or, where it has none of its own, of the figure."""
    own = None if hasattr(owner, "legends") else owner.get_legend()
    return [text.get_text() for text in (own or owner.figure.legends[0]).get_texts()]


# --- bifurcation -------------------------------------------------------------------------------
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
    """Two starts of one preload have one colour: which of them is undecided, no mark tells."""
    rows = {("undecided", "a, up"): np.r_[1.0], ("undecided", "a, down"): np.r_[2.0]}
    for own, told in (({"a": "red"}, [("a", [1.0, 2.0])]), ({}, [("", [1.0, 2.0])])):
        looks = points._by_look(rows, own).values()
        assert [(whose, x.tolist()) for whose, x in looks] == told
    alone = points._by_look({("pending", "a, up"): np.r_[1.0]}, {})
    assert [whose for whose, _ in alone.values()] == ["a, up"]


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
    (around,) = [line for line in drawn if (line.get_marker(), line.get_mfc()) == ("D", "none")]
    assert around.get_markerfacecolor() == "none"
    assert around.get_markersize() > 1.5 * square.get_markersize()


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
    along = [one for one in ax.lines if 0.0 in one.get_ydata()]
    for times in (2.0, 3.0):
        width = times * style.SETTINGS["lines.linewidth"]
        wide = [one.get_ydata() for one in along if one.get_linewidth() == width]
        assert [int(np.isfinite(y).sum()) for y in wide] == [20] * (times <= len(starts))


@pytest.mark.parametrize(
    ("alone", "marks"), [([], ["None", "None"]), ([20], [".", "x"]), ([20, 21], [".", "x"])]
)
def test_points_that_stand_alone_tell_by_marks_what_dashes_do(alone, marks):
    """Their colour is the preload's: two dots of one were those of two variables. So they do where
    two points are a line too short for its dashes."""
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
    line = draw(dataset, figure("curve", variable="L_s", **asked)).axes[0].lines[0]
    assert np.flatnonzero(np.isnan(line.get_ydata())).tolist() == [200, 202, 403]
    assert (line.get_marker() == "None") == bool(asked)


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
    (wide, fine) = {line.get_markersize() for line in dots_of(draw(many, figure("bifurcation")))}
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


def marked(drawn):
    """Size of the first marks that are there."""
    return next(line.get_markersize() for line in drawn.axes[0].lines if len(line.get_xdata()))


def resting():
    """`bifurcation`, with where the motions rest: at 0.01 rad per rad/s, above 3.5 rad/s."""
    dataset = data.bifurcation()
    extreme = 0.01 * dataset["Omega"] * xr.ones_like(dataset["L_s"])
    return dataset.assign(phi_max=extreme.transpose("Omega", "initial"))


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


def branch_along_the_speed(parameter="Omega", preloads=(30.0,)):
    """The dataset of branches that turn unstable at 2.2 rad/s, one for each preload."""
    count, of_branch, of_ends = len(preloads), "branch_obs", "cycle_end_obs"
    value = np.tile([3.0, 2.0, 1.5, 1.0], count)
    stable = ["stable", "unstable", "unstable", "unstable"] * count
    sizes = np.full((count, 1), 4, np.int32)
    return xr.Dataset(
        {
            "status": data.statuses(("N0", "initial"), np.full((count, 1), "ok")),
            "branch_row_size": (("N0", "initial"), sizes, {"sample_dimension": of_branch}),
            "section_row_size": (("N0", "initial"), 0 * sizes, {"sample_dimension": "section_obs"}),
            "section_value": ("section_obs", np.zeros(0), {"long_name": "phi at the section"}),
            "branch_value": (of_branch, value, {"long_name": f"{parameter} along the branch"}),
            "branch_min": (of_branch, 0.0 * value, {"long_name": "least phi of the cycle"}),
            "branch_max": (of_branch, value, {"long_name": "greatest phi of the cycle"}),
            "branch_stable": data.flags(of_branch, stable, ("unstable", "stable")),
            "cycle_end_row_size": (("N0", "initial"), sizes // 2, {"sample_dimension": of_ends}),
            "cycle_end": (of_ends, np.tile([3.5, 2.2], count), {"units": "rad s-1"}),
        },
        data.axes(N0=list(preloads), initial=["followed"]),
        data.attributes(),
    )


def dashed(ax, dashes="--"):
    """What is drawn so; not what stands for it in the legend."""
    lines = [line for line in ax.lines if line.get_linestyle() == dashes]
    return [line.get_xydata() for line in lines if len(line.get_xdata())]


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
    told = {float(row["x"]) for row in rows if "equilibrium" in row["series"]}
    assert told == {*x}


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
    assert "equilibrium turns unstable" in legend_texts(ax)
    (ax,) = draw([("one", analyses)], figure("bifurcation")).axes
    assert "|" not in {line.get_marker() for line in ax.lines}
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
    assert [at for at in stable[:, 0] if at in unstable[:, 0]] == [met]
    np.testing.assert_allclose(stable[:, 1], 0.01 * stable[:, 0])
    assert stable[0].tolist() == unstable[-1].tolist()
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
    assert told["_one, read between points, equilibrium turns unstable"] == pytest.approx([2.93])
    rows = as_csv(draw(analyses, figure("bifurcation")), Path("a.csv"))
    assert "2.93" not in rows  # a line leads there, and nothing was computed
    assert "equilibrium turns unstable" in legend_texts(ax)


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


# --- curve -------------------------------------------------------------------------------------
def test_a_curve_has_a_line_for_every_start_and_none_leads_to_another_class():
    dataset = data.bifurcation()
    (ax,) = draw(dataset, figure("curve")).axes
    undecided = dataset["attractor"] == data.codes(data.ATTRACTORS, "undecided")
    for label in ("near", "far"):
        classes = dataset["attractor"].sel(initial=label).values
        expected = dataset["L_s"].where(~undecided).sel(initial=label).values
        cut = np.insert(expected, np.flatnonzero(np.diff(classes)) + 1, np.nan)
        assert len(cut) > len(expected)
        assert np.array_equal(marks(ax, label)[:, 1], cut, equal_nan=True)
    hollow, _ = [line for line in ax.lines if line.get_markerfacecolor() == "none"]
    assert hollow.get_linestyle() == "None"
    assert np.array_equal(hollow.get_ydata(), dataset["L_s"].values[undecided])
    assert ax.get_ylabel() == "$L_s$ (rad$^{2}$)"


def test_what_is_taken_over_undecided_points_is_called_undecided():
    dataset = data.bifurcation()
    taking = {"what": "spread", "over": ["initial"]}
    (ax,) = draw(dataset, figure("curve", variable="L_s", take=taking)).axes
    assert ax.get_ylabel().startswith("spread of $L")
    assert marks(ax, "undecided")[:, 0].tolist() == pytest.approx([1.5])
    assert marks(ax, "failed")[:, 0].tolist() == pytest.approx([2.5])


def share_of_periodic(undecided):
    """What is taken over both starts, and a dataset in which some points are undecided."""
    dataset = data.bifurcation()
    dataset["attractor"][undecided, 1] = data.codes(data.ATTRACTORS, "undecided")
    return dataset, {"what": "share", "of": "periodic", "over": ["initial"]}


def test_what_is_taken_over_undecided_points_is_a_bar_over_all_that_it_may_be():
    """The line leads through what is known alone."""
    dataset, taking = share_of_periodic([3, 4, 20])
    (ax,) = draw(dataset, figure("curve", variable="attractor", take=taking)).axes
    found = taken(dataset, "attractor", taking)
    ends = np.stack([found["share_low"], found["share_high"]], axis=-1)
    wide = ends[:, 0] < ends[:, 1]
    (bars,) = (np.array(c.get_segments()) for c in ax.collections)
    np.testing.assert_allclose(bars[:, 0, 0], dataset["Omega"].values[wide])
    np.testing.assert_allclose(bars[:, :, 1], ends[wide])
    known = ax.lines[0].get_ydata()
    np.testing.assert_allclose(known[np.isfinite(known)], ends[~wide, 0])
    assert {3, 4, 20} <= {*np.flatnonzero(wide)}
    assert legend_texts(ax).count("undecided points: from least to greatest") == 1
    taking = {"what": "greatest", "over": ["initial"]}
    (ax,) = draw(dataset, figure("curve", variable="L_s", take=taking)).axes
    (least,) = [line for line in ax.lines if line.get_label() == "_undecided points: at least"]
    assert {*dataset["Omega"].values[[3, 4, 20]]} <= {*least.get_xdata()}
    assert "undecided points: at least" in legend_texts(ax)


def test_where_nothing_is_known_of_what_is_taken_a_mark_stands_below():
    """Where no point is periodic but one undecided, the first that is may be this one or none."""
    dataset = data.stability_map(initial=["reached"])
    dataset["attractor"][:, :2] = data.codes(data.ATTRACTORS, "equilibrium")
    dataset["attractor"][7, 1] = data.codes(data.ATTRACTORS, "undecided")
    taking = {"what": "first", "of": "periodic", "over": ["Omega"]}
    (ax,) = draw(dataset, figure("curve", x="N0", variable="attractor", take=taking)).axes
    told = "undecided points: nothing known"
    assert marks(ax, f"_{told}").tolist() == [[dataset["N0"].values[1], 0.0]]
    assert told in legend_texts(ax)


def test_numbers_taken_over_undecided_points_are_marked_on_a_map():
    dataset = data.stability_map()
    dataset["attractor"][3, 5, 1] = data.codes(data.ATTRACTORS, "undecided")
    taking = {"what": "share", "of": "periodic", "over": ["initial"]}
    settings = {"variable": "attractor", "take": taking, "level": 0.6}
    drawn = draw(dataset, figure("map", **settings))
    told = "undecided points: middle of least and greatest"
    found = taken(dataset, "attractor", taking)
    wide = (found["share_low"] < found["share_high"]).transpose("Omega", "N0").values
    assert wide[3, 5]
    places = {(dataset["Omega"].values[x], dataset["N0"].values[y]) for x, y in np.argwhere(wide)}
    assert {*map(tuple, marks(drawn.axes[0], told))} == places
    (rings,) = [line for line in drawn.axes[0].lines if line.get_label() == told]
    assert rings.get_zorder() > max(lines.get_zorder() for lines in drawn.findobj(ContourSet))
    assert told in legend_texts(drawn)
    assert any(text.endswith("= 0.6, at least and at most") for text in legend_texts(drawn))
    settings = {"variable": "L_s", "take": {"what": "greatest", "over": ["initial"]}}
    (why,) = legend_texts(draw(dataset, figure("map", **settings)))[-1:]
    assert why.startswith("no value: ") and why.endswith(", undecided")


def test_what_is_filled_in_as_undecided_is_not_said_not_to_be_computed():
    """Of what is taken over it, for one; and once."""
    dataset = data.stability_map()
    statuses = {name: code for code, name in flag_names(dataset["status"].attrs).items()}
    was_run = dataset["status"].copy(data=np.zeros(dataset["status"].shape, np.int8))
    named = {"flag_values": np.array([0, 1], np.int8), "flag_meanings": "run filled_in"}
    dataset["computed"] = was_run.assign_attrs(named)
    dataset["attractor"][3, 5], dataset["attractor"][-3:, -2:] = (
        data.codes(data.ATTRACTORS, name) for name in ("undecided", "periodic")
    )
    dataset["status"][-3:, -2:] = statuses["ok"]
    dataset["status"][3, 5], dataset["computed"][3, 5] = statuses["not_computed"], 1
    take = {"what": "classes", "over": ["initial"]}
    (why,) = legend_texts(draw(dataset, figure("map", variable="attractor", take=take)))[-1:]
    assert why == "no value: undecided"


def test_hollow_values_are_named_and_keys_have_the_one_colour_that_they_stand_for():
    """Black where that is several."""
    hollow, dataset = "value of an undecided motion", data.bifurcation()
    one = draw(dataset, figure("curve")).axes[0]
    dataset["attractor"][10] = data.codes(data.ATTRACTORS, "undecided")
    both = draw(dataset, figure("curve")).axes[0]
    for ax, count in ((one, 1), (both, 2)):
        drawn = [line for line in ax.lines if str(line.get_label()).endswith(f", {hollow}")]
        (key,) = [line for line in ax.lines if line.get_label() == hollow]
        colours = [to_hex(line.get_color()) for line in drawn]
        assert len(colours) == count
        assert to_hex(key.get_color()) == (colours[0] if count == 1 else BLACK)
        assert hollow in legend_texts(ax)


def test_a_line_stands_where_the_section_that_motions_choose_changes():
    dataset = data.bifurcation()
    kinds = {"flag_values": [-1, 0, 2], "flag_meanings": "not_computed slip_to_stick turning_point"}
    chosen = np.where(dataset["attractor"] == data.codes(data.ATTRACTORS, "periodic"), 0, -1)
    same = dataset.assign(section_kind=(("Omega", "initial"), chosen.astype(np.int8), kinds))
    same["section_contact"] = dataset["L_s"] * 0.0 + 1.0
    assert "another section" not in legend_texts(draw(same, figure("bifurcation")).axes[0])
    chosen[25:, 1] = 2
    other = same.assign(section_kind=(("Omega", "initial"), chosen.astype(np.int8), kinds))
    (ax,) = draw(other, figure("bifurcation")).axes
    assert marks(ax, "another section")[:, 0].tolist() == pytest.approx([2.95, 2.95])
    (note,) = style.notes_on(ax.figure)
    assert "changes at Omega = 2.95, and" in note
    assert 'section = { zero = "phi_dot" }' in in_one_line(note)  # as it is told


def with_x_rms(unit):
    dataset = data.bifurcation()
    return dataset.assign(x_rms=(("Omega", "initial"), np.ones((46, 2)), {"units": unit}))


def test_several_variables_of_a_curve_are_named_in_its_legend():
    dataset = data.bifurcation().isel(initial=[0])
    dataset["x_rms"] = (("Omega", "initial"), np.ones((46, 1)), {"units": "rad2"})
    (ax,) = draw(dataset, figure("curve", variable=["L_s", "x_rms"])).axes
    assert legend_texts(ax)[:2] == ["$L_s$", r"$x_{\mathrm{rms}}$"]  # units stand at axes
    assert ax.get_ylabel() == r"$L_s$, $x_{\mathrm{rms}}$ (rad$^{2}$)"
    dataset["x_rms"].attrs["units"] = "rad"  # each unit has a panel, the first the limits
    wanted = {"variable": ["L_s", "x_rms"], "ylim": (0.0, 1.5), "ylabel": "mine"}
    top, below = draw(dataset, figure("curve", **wanted)).axes
    assert (top.get_ylabel(), below.get_ylabel()) == ("mine", r"$x_{\mathrm{rms}}$ (rad)")
    assert (top.get_xlabel(), below.get_xlabel()) == ("", r"disc speed $\Omega$ (rad/s)")
    assert top.get_ylim() == (0.0, 1.5) != below.get_ylim()
    wanted["ylim"] = {"x_rms": (0.5, 2.5)}
    top, below = draw(dataset, figure("curve", **wanted)).axes
    assert below.get_ylim() == (0.5, 2.5) != top.get_ylim()
    with pytest.raises(UsageError, match="one variable"):
        draw(data.stability_map(), figure("map", variable=["L_s", "attractor"]))


@pytest.mark.parametrize(
    ("asked", "shown"),
    [
        ({}, {"phi": None, "theta": None}),
        ({"ylim": (-1.0, 2.0)}, {"phi": (-1.0, 2.0), "theta": None}),
        ({"ylim": {"theta": (-1.0, 2.0)}}, {"phi": None, "theta": (-1.0, 2.0)}),
    ],
)
def test_histories_beside_one_another_have_one_range_of_each_variable(asked, shown):
    """That of all, or what the figure says of it; and one axis of time, of motions as long."""
    drawn = draw(data.history(), figure("history", variable=["phi", "theta"], **asked))
    for row, told in zip(np.reshape(drawn.axes, (2, 2)), shown.values(), strict=True):
        left, right = (ax.get_ylim() for ax in row)
        assert left == right == (told or left) != (0.0, 1.0)
    assert len({ax.get_xlim() for ax in drawn.axes}) == 1


def test_a_motion_that_would_be_flat_beside_another_has_a_range_of_its_own():
    found = data.history()
    small = found["phi"].where(found["initial"] == "far", 0.02 + 1e-3 * (found["phi"] - 0.02))
    far, near = draw(found.assign(phi=small), figure("history", variable=["phi"])).axes
    assert np.ptp(near.get_ylim()) < 1e-2 * np.ptp(far.get_ylim())


def test_all_variables_of_a_curve_leave_a_motion_at_the_same_points():
    """One that would go on as if nothing had happened stands at another motion there, too."""
    found = data.bifurcation().isel(initial=[0])
    x, after = found["Omega"].values, found["Omega"].values > 2.0
    (periodic,) = (c for c, n in flag_names(found["attractor"].attrs).items() if n == "periodic")
    found["attractor"] = found["attractor"].copy(data=np.full((x.size, 1), periodic))
    found["L_s"] = found["L_s"].copy(data=(1.0 + 0.1 * x)[:, None])
    found["x_rms"] = (("Omega", "initial"), (1.0 + 0.1 * x + after)[:, None], {"units": "rad"})
    breaks = [
        np.flatnonzero(np.isnan(ax.lines[0].get_ydata())).tolist()
        for names in (["L_s"], ["L_s", "x_rms"])
        for ax in draw(found, figure("curve", variable=names)).axes
    ]
    assert breaks == [[], [after.argmax()], [after.argmax()]]


def test_series_of_a_curve_without_a_name_of_their_own_have_no_comma():
    assert points.unlisted("", "stable cycle") == points.unlisted("_", "stable cycle")
    assert points.unlisted("_near", "stable cycle") == "_near, stable cycle"


def test_marks_are_at_the_points_of_all_panels_or_of_none():
    """Dashes take the room for marks in one of them alone."""
    dataset = data.bifurcation()
    for name, unit in (("x_rms", "1"), ("x_min", "1"), ("x_max", "m")):
        dataset[name] = (len(name) * dataset["L_s"]).assign_attrs(units=unit, long_name=name)
    dataset["x_min"] *= 2.0
    few = draw(dataset, figure("curve", variable="x_max")).axes
    panels = draw(dataset, figure("curve", variable=["x_rms", "x_min", "x_max"])).axes
    assert [marked_lines(ax) > 0 for ax in (*few, *panels)] == [True, False, False]


def marked_lines(ax):
    """How many lines have a mark at each of their points."""
    drawn = [line for line in ax.lines if np.isfinite(line.get_ydata()).sum() > 1]
    return sum(line.get_marker() != "None" and line.get_markevery() is None for line in drawn)


def test_variables_of_other_units_have_panels_of_their_own_above_each_other():
    asked = {"variable": ["L_s", "x_rms", "attractor"], "xlim": [1, 2], "ylim": [0, 3], "log": "x"}
    drawn = draw(with_x_rms("rad"), figure("curve", **asked, ylabel="mine"))
    top, middle, bottom = drawn.axes
    assert [ax.get_ylabel() for ax in (top, middle)] == ["mine", r"$x_{\mathrm{rms}}$ (rad)"]
    assert [bool(ax.get_xlabel()) for ax in drawn.axes] == [False, False, True]
    assert {ax.get_xlim() for ax in drawn.axes} == {(1, 2)}
    assert {ax.get_xscale() for ax in drawn.axes} == {"log"}
    assert top.get_ylim() == (0, 3) != middle.get_ylim()
    assert "periodic" in [tick.get_text() for tick in bottom.get_yticklabels()]
    assert legend_texts(drawn)[:2] == ["near", "far"]
    colours = {ax.lines[0].get_color() for ax in drawn.axes}
    assert len(colours) == 1
    with pytest.raises(UsageError, match="needs 3 panels"):
        draw(with_x_rms("rad"), figure("curve", **asked), axis=Figure().subplots())


def crossing_lines(**heights):
    """A curve for each start, a straight line from one height to another."""
    omega = data.bifurcation()["Omega"].values
    share = (omega - omega[0]) / np.ptp(omega)
    lines = [begin + (end - begin) * share for begin, end in heights.values()]
    dataset = data.bifurcation().drop_dims("section_obs").drop_vars("section_row_size")
    dataset = dataset.isel(initial=[0] * len(lines))
    dataset = dataset.assign_coords(initial=[*heights])
    dataset["L_s"] = dataset["L_s"].copy(data=np.stack(lines, axis=-1))
    return dataset.assign(attractor=dataset["attractor"] * 0 + 1, status=dataset["status"] * 0)


@pytest.mark.parametrize("style", ["screen", "talk"])
@pytest.mark.parametrize(
    ("heights", "inside"),
    [
        ({"a": (0.0, 1.0), "b": (0.0, 0.9)}, True),
        ({"a": (1.0, 1.0), "b": (0.0, 0.0)}, True),
        ({"a": (0.0, 1.0), "b": (1.0, 0.0), "a level": (0.5, 0.5)}, True),
        ({f"a start of long name {n}": (0.2 * n, 1.0 - 0.2 * n) for n in range(6)}, False),
    ],
)
def test_a_legend_stands_where_nothing_is_drawn_or_below(heights, inside, style):
    dataset = crossing_lines(**heights)
    drawn = draw(dataset, figure("curve", variable="L_s"), look=look_of(style, width=160.0))
    drawn.canvas.draw()
    (ax,) = drawn.axes
    legend = ax.get_legend()
    assert bool(drawn.legends) == (legend is None)
    if style == "screen":
        assert (legend is not None) == inside
    if legend is not None:
        box = legend.get_window_extent()
        for line in ax.lines:
            path = line.get_transform().transform_path(line.get_path())
            assert not path.intersects_bbox(box, filled=False)
            assert not box.count_contains(path.vertices)
    else:
        box = drawn.legends[0].get_window_extent()
        assert box.y1 < ax.xaxis.label.get_window_extent().y0


@pytest.mark.parametrize("width", [84.0, 160.0])
def test_a_legend_of_long_names_stays_on_the_page(width):
    names = [f"{word} of a start with a name of many words that no line holds" for word in "ab"]
    dataset = crossing_lines(**dict(zip(names, ((0.0, 1.0), (0.0, 2.0)), strict=True)))
    drawn = draw(dataset, figure("curve", variable="L_s"), look=look_of("paper", width=width))
    drawn.canvas.draw()
    (legend,) = drawn.legends or [drawn.axes[0].get_legend()]
    box = legend.get_window_extent()
    assert box.x0 >= 0.0 and box.x1 <= drawn.bbox.x1 and box.y0 >= 0.0
    texts = [text.get_text() for text in legend.get_texts()]
    assert [text.replace("\n", " ") for text in texts] == names


def test_a_legend_on_the_axis_of_a_user_stays_in_it():
    own = Figure()
    axis = own.subplots()
    draw(crossing_lines(a=(0.0, 1.0), b=(1.0, 0.0)), figure("curve", variable="L_s"), axis=axis)
    assert axis.get_legend() is not None and not own.legends


@pytest.mark.parametrize(
    ("height", "power"),
    [
        (2e-5, "10^{−5}"),
        (9e-4, "10^{−4}"),
        (2e-3, "10^{−3}"),
        (2e-2, ""),
        (5e4, ""),
        (3e5, "10^{5}"),
    ],
)
def test_small_and_large_numbers_have_one_power_of_ten_at_the_end_of_the_axis(height, power):
    dataset = crossing_lines(near=(0.0, height))
    drawn = draw(dataset, figure("curve", variable="L_s"))
    drawn.canvas.draw()
    words = drawn.axes[0].yaxis.get_offset_text().get_text()
    assert power in words and bool(words) == bool(power)


def test_a_curve_of_classes_has_their_names_at_the_ticks():
    (ax,) = draw(data.bifurcation(), figure("curve", variable="attractor")).axes
    ticks = [tick.get_text() for tick in ax.get_yticklabels()]
    assert ticks[:2] == ["equilibrium", "periodic"]
    assert "not computed" not in ticks


def test_lines_of_a_second_axis_say_its_value_with_unit():
    drawn = draw(data.stability_map(), figure("curve", x="Omega", select={"initial": "exists"}))
    assert {"$N_0$ = 2 N", "$N_0$ = 26 N", "$N_0$ = 50 N"} < {*legend_texts(drawn)}
    assert len([line for line in drawn.axes[0].lines if line.get_label().startswith("$N_0$")]) == 17


PRELOADS = ["$N_0$ = 10 N", "$N_0$ = 20 N", "$N_0$ = 30 N"]


def over_preloads(preloads=(10.0, 20.0, 30.0), starts=("far",)):
    """A line for each preload and start, and of each the shares of stick of two contacts."""
    one = crossing_lines(**{start: (1.0 + n, 2.0 + n**2) for n, start in enumerate(starts)})
    each = [one.assign(L_s=force * one["L_s"]) for force in preloads]
    found = xr.concat(each, "N0", data_vars="all")
    both = xr.concat([found["L_s"] / 100.0, found["L_s"] / 200.0], "contact")
    shares = both.transpose(..., "contact")
    found["stick_fraction"] = shares.assign_attrs(units="1", long_name="share of stick")
    return found.assign_coords(**data.axes(N0=preloads), contact=[1, 2])


@pytest.mark.parametrize(
    ("preloads", "starts", "variable", "told"),
    [
        ((10.0, 20.0, 30.0, 40.0), ("a", "b"), "stick_fraction", 8),  # dashes tell the contacts
        ((10.0, 20.0, 30.0), ("a", "b"), "stick_fraction", 0),
        ((10.0, 20.0, 30.0, 40.0), ("a", "b"), "L_s", 0),
        (range(10, 100, 10), ("a",), "L_s", 0),  # a ramp tells them
    ],
)
def test_lines_too_many_for_colours_are_told(preloads, starts, variable, told):
    dataset = over_preloads(preloads, starts)
    notes = style.notes_on(draw(dataset, figure("curve", x="Omega", variable=variable)))
    assert [note.split(" lines")[0] for note in notes] == [str(told)] * (told > 0)


def looks_of(ax, look):
    """Words of each line that has points -> its colour, or its dashes."""
    lines = [line for line in ax.lines if len(line.get_xdata())]
    return {line.get_label().strip("_"): getattr(line, f"get_{look}")() for line in lines}


def test_a_curve_shows_variables_of_several_analyses():
    """Of each the points without answer are marked in its colour, and the starts selected."""
    critical, motion = data.crossings().isel(crossing=[0]), data.bifurcation().isel(Omega=[0, 1, 2])
    motion = motion.rename(Omega="R").assign_coords(critical["R"].coords)
    motion["L_s"].attrs |= {"units": "N", "long_name": "half range"}
    motion["status"][2, 1], motion["L_s"][2, 1] = data.STATUS.index("failed"), np.nan
    asked = figure("curve", variable=["critical_value", "L_s"], select={"initial": "far"})
    (ax,) = draw({"critical": critical, "motion": motion}, asked).axes
    names, told = ["critical value of $A_{b}$", "half range $L_s$"], "failed: half range"
    assert legend_texts(ax) == [*names, f"{told} $L_s$"]
    np.testing.assert_array_equal(marks(ax, names[0])[:, 1], critical["critical_value"][:, 0])
    np.testing.assert_array_equal(marks(ax, names[1])[:, 1], motion["L_s"][:, 1])
    colours = looks_of(ax, "color")
    assert colours[f"{told} $L_s$"] == colours[names[1]] != colours[names[0]]
    with pytest.raises(UsageError, match="initial: no axis"):
        wanted = figure("curve", x="initial", variable=["L_s", "critical_value"])
        draw({"critical": critical, "motion": motion}, wanted)
    with pytest.raises(UsageError, match="L_s: not in this dataset"):
        wanted = figure("curve", analysis="critical", variable="L_s")
        draw({"critical": critical, "motion": motion}, wanted)


def test_a_value_has_one_colour_in_all_panels_and_each_contact_its_dashes():
    """The table has every line by all of its words."""
    drawn = draw(over_preloads(), figure("curve", x="Omega", variable=["L_s", "stick_fraction"]))
    assert legend_texts(drawn) == [*PRELOADS, "contact = 1", "contact = 2"]
    top, below = (looks_of(ax, "color") for ax in drawn.axes)
    assert len({*top.values()}) == 3
    assert below == {f"{one}, contact = {n}": top[one] for one, n in product(PRELOADS, (1, 2))}
    dashes = {(words[-1], dash) for words, dash in looks_of(drawn.axes[1], "linestyle").items()}
    assert dashes == {("1", "-"), ("2", "--")}
    keys = [key.get_color() for key in drawn.legends[0].legend_handles]
    assert keys == [*top.values(), BLACK, BLACK]
    rows = list(csv.reader(as_csv(drawn, Path("a.csv")).splitlines()))
    assert {row[4] for row in rows[1:]} == {in_one_line(words) for words in [*top, *below]}


@pytest.mark.parametrize(("points", "marker"), [(21, "None"), (8, ".")])
def test_marks_leave_room_for_dashes_that_tell_contacts_apart(points, marker):
    few = over_preloads().isel(Omega=slice(points))
    drawn = draw(few, figure("curve", variable="stick_fraction"), look=look_of("paper", width=84.0))
    assert {*looks_of(drawn.axes[0], "marker").values()} == {marker}
    one = few.isel(contact=[0], N0=[0, 1])  # two lines, of two colours
    drawn = draw(one, figure("curve", variable="stick_fraction"), look=look_of("paper", width=84.0))
    assert {*looks_of(drawn.axes[0], "marker").values()} == {"."}


def test_of_two_dims_that_of_more_values_has_the_colours_also_of_gaps():
    found = over_preloads((10.0, 20.0), ("a", "b", "c"))
    found["status"][1, 20, 1], found["L_s"][1, 20, 1] = data.STATUS.index("failed"), np.nan
    (ax,) = draw(found, figure("curve", x="Omega", variable="L_s")).axes
    assert legend_texts(ax) == ["a", "b", "c", *PRELOADS[:2], f"failed: {PRELOADS[1]}, b"]
    colours = looks_of(ax, "color")
    assert len({*colours.values()}) == 3
    assert colours[f"failed: {PRELOADS[1]}, b"] == colours[f"{PRELOADS[0]}, b"]


def test_a_line_without_value_and_lines_of_all_have_entries_beside_colours_and_dashes():
    found = over_preloads()
    found["stick_fraction"][0, ..., 1] = found["stick_fraction"][0, ..., 0]
    found["stick_fraction"][1, ..., 1] = np.nan
    found["L_s"][2] = np.nan  # its colour is told: it has values elsewhere
    drawn = draw(found, figure("curve", x="Omega", variable=["L_s", "stick_fraction"]))
    none, both = f"{PRELOADS[1]}, contact = 2: no value", "contact = 1 and contact = 2"
    assert legend_texts(drawn) == [*PRELOADS, both, "contact = 1", "contact = 2", none]


@pytest.mark.parametrize(
    ("preloads", "starts", "asked", "entries"),
    [
        ((10.0, 20.0), ("a", "b"), {"variable": "L_s"}, 4),  # no fewer by colour and dash
        ((10.0, 20.0, 30.0), ("a-001", "b-001"), {"variable": "L_s"}, 6),  # nor is a line drawn
        ((10.0, 20.0, 30.0), ("a", "b"), {"variable": "attractor"}, 3),  # both starts are one
        (
            (10.0, 20.0, 30.0),
            ("a", "b"),
            {"variable": "L_s", "x": "initial", "select": {"Omega": [0.5, 1.0]}},
            6,
        ),
    ],
)
def test_where_dashes_tell_nothing_each_line_has_its_colour(preloads, starts, asked, entries):
    found = over_preloads(preloads, starts)
    (ax,) = draw(found, figure("curve", **{"x": "Omega"} | asked)).axes
    assert len(legend_texts(ax)) == len({*looks_of(ax, "color").values()}) == entries


def test_a_curve_of_crossings_has_a_line_for_each_sort():
    dataset = data.crossings()
    (ax,) = draw(dataset, figure("curve")).axes
    assert legend_texts(ax) == [
        "a mode turns stable",
        "a mode turns unstable",
        AT_A_JUMP,
    ]
    np.testing.assert_array_equal(marks(ax, AT_A_JUMP), [[5, 1.5], [10, 3], [20, 6]])
    np.testing.assert_array_equal(marks(ax, "a mode turns stable"), [[5, 2], [10, 4]])
    (ax,) = draw(dataset.isel(crossing=[0]), figure("curve")).axes
    assert ax.get_legend() is None
    other = data.boundaries().isel(crossing=[0]).rename(N0="R")  # each variable has one sort
    other = other.assign_coords(dataset["R"].coords).isel(R=[0, 1])
    other["boundary"].attrs["units"] = "N"
    both = {"critical": dataset.isel(crossing=[0]), "ends": other}
    asked = figure("curve", x="R", variable=["critical_value", "boundary"])
    (ax,) = draw(both, asked).axes
    assert legend_texts(ax) == [
        "critical value of $A_{b}$",
        "$\\Omega$ at which the answer changes",
    ]
    assert {line.get_marker() for line in ax.lines if len(line.get_xdata())} == {"o", "_"}  # caps


@pytest.mark.parametrize(("values", "told"), [([4, 1, 1, 4], True), ([4, 3, 2, 1], False)])
def test_where_crossings_are_not_joined_is_told(values, told):
    """Of so few points none tells a bend from a leap."""
    axes = data.axes(Omega=[1.0, 2.0, 4.0, 5.0])
    dims, one = ("Omega", "crossing"), np.full((4, 1), "root")
    found = {"critical_value": (dims, np.array(values, float)[:, None])}
    found["status"] = data.statuses(("Omega",), np.full(4, "ok"))
    found["crossing_kind"] = data.flags(dims, one, ("root", "jump"))
    ways = np.full((4, 1), "to_stable")
    found["crossing_direction"] = data.flags(dims, ways, ("to_stable", "to_unstable"))
    drawn = draw(xr.Dataset(found, axes, data.attributes()), figure("curve"))
    told_of = "not joined between Omega = 1 and 2"
    assert len([note for note in style.notes_on(drawn) if told_of in note]) == told


def test_a_file_without_the_variable_of_a_curve_shows_its_own_number():
    """Of the same unit in the same panel: a border and the critical value beside it."""
    axes = data.axes(Omega=[1.0, 2.0, 3.0])
    status = data.statuses(("Omega",), np.full(3, "ok"))
    names = {"boundary": "boundary", "critical_value": "critical value of c"}
    sources = []
    for name, words_ in names.items():
        values = (("Omega",), [3.0, 2.0, 1.0], {"units": "N s m-1", "long_name": words_})
        attributes = data.attributes() | {"law": name}
        sources.append((name, xr.Dataset({name: values, "status": status}, axes, attributes)))
    drawn = draw(sources, figure("curve", variable="boundary"))
    (ax,) = drawn.axes
    assert len([line for line in ax.lines if np.isfinite(line.get_ydata()).any()]) == 2


def test_of_several_files_each_shows_those_variables_of_a_curve_that_it_has():
    whole = data.bifurcation()[["status", "attractor", "L_s"]]
    whole["stick_fraction"] = whole["L_s"].assign_attrs(units="s")
    asked = figure("curve", variable=["L_s", "stick_fraction"])
    part = whole.drop_vars("stick_fraction")
    drawn = draw([("whole", whole), ("part", part)], asked)
    lines = [[one for one in ax.lines if one.get_linestyle() != "None"] for ax in drawn.axes]
    told = [[one.get_label() for one in some] for some in lines]
    assert [any("part" in label for label in labels) for labels in told] == [True, False]
    with pytest.raises(UsageError, match=r"other: no L_s or stick_fraction.*\n.*it has attractor"):
        draw([("whole", whole), ("other", part.drop_vars("L_s"))], asked)


@pytest.mark.parametrize(("count", "marked"), [(25, True), (26, False)])
def test_marks_of_many_crossings_do_not_hide_their_lines(count, marked):
    """A crossing that no line leads through has a mark all the same."""
    along = np.linspace(0.1, 1.0, count + 1)
    dataset = data.crossings().isel(crossing=[1], R=[0] * (count + 1)).assign_coords(R=along)
    dataset["critical_value"][:, 0] = np.where(along > 0.1, along, 9.0)
    dataset["crossing_mode"][:, 0] = np.where(along > 0.1, 2, 0)
    (ax,) = draw(dataset, figure("curve")).axes
    has_marks = {line.get_xdata().size: line.get_marker() != "None" for line in ax.lines}
    assert has_marks == {1: True, count: marked}


@pytest.mark.parametrize(("error", "seen"), [(0.1, True), (1e-3, False)])
def test_error_bars_too_short_to_be_seen_have_no_ends(error, seen):
    found = data.bifurcation()
    found["L_s_error"] = error * found["L_s"].where(found["L_s"] > 0.0)
    (ax,) = draw(found, figure("curve", variable="L_s", select={"initial": "far"})).axes
    caps = [line.get_markevery() for line in ax.lines if line.get_marker() in (2, 3, "_")]
    assert caps and all(bool(shown) == seen for shown in caps)
    assert any(one.get_label().endswith("error bar") for one in ax.collections)


def test_where_colours_tell_another_axis_dashes_tell_the_sorts_of_crossings():
    one = data.crossings()
    both = xr.concat([one, one.assign(critical_value=2 * one["critical_value"])], "mu_k")
    (ax,) = draw(both.assign_coords(data.axes(mu_k=[0.2, 0.3])), figure("curve", x="R")).axes
    sorts = ["a mode turns stable", "a mode turns unstable", AT_A_JUMP]
    assert legend_texts(ax) == [*sorts, r"$\mu_k$ = 0.2", r"$\mu_k$ = 0.3"]
    drawn = [line for line in ax.lines if len(line.get_xdata())]
    assert len({line.get_linestyle() for line in drawn}) == 3
    assert len({line.get_marker() for line in drawn}) == 3
    assert len({line.get_color() for line in drawn}) == 2
    (ax,) = draw(both.isel(R=[0]), figure("curve", x="R")).axes  # of points the key has no line
    keys = {line.get_label(): line for line in ax.lines if not len(line.get_xdata())}
    assert {keys[sort].get_linestyle() for sort in sorts} == {"None"}
    assert len({keys[sort].get_marker() for sort in sorts}) == 3


def test_crossings_of_several_sorts_are_drawn_at_the_points_of_the_grid_alone():
    """Nothing was computed between these: neither a mark nor a bend says that it was."""
    one = data.crossings().isel(R=[0, 1, 0, 1, 0, 1, 0])
    one = one.assign_coords(data.axes(R=np.arange(7.0)))
    both = xr.concat([one, one.assign(critical_value=2 * one["critical_value"])], "mu_k")
    (ax,) = draw(both.assign_coords(data.axes(mu_k=[0.2, 0.3])), figure("curve", x="R")).axes
    drawn = [line.get_xdata() for line in ax.lines if len(line.get_xdata())]
    assert len(drawn) == 6
    for places in drawn:
        assert set(places) <= set(range(7))


def test_changes_between_motions_of_one_class_are_told_apart_by_their_answers():
    """To a question about a number; elsewhere by their classes."""
    answers, dims = ("no", "yes"), ("N0", "crossing")
    dataset = data.boundaries().drop_vars("boundary_error")
    dataset["answer_below"] = data.flags(dims, [["no"]] * 3, answers)
    dataset["answer_above"] = data.flags(dims, [["yes"]] * 3, answers)
    (ax,) = draw(dataset, figure("curve", variable="boundary")).axes
    assert legend_texts(ax) == [
        REST_ABOVE,
        UNDECIDED_ABOVE,
    ]
    dataset["class_above"][:] = dataset["class_below"].values
    dataset["class_above"][0] = data.codes(data.ATTRACTORS, "equilibrium")
    (ax,) = draw(dataset, figure("curve", variable="boundary")).axes
    assert ax.get_legend() is None
    (line,) = [line for line in ax.lines if len(line.get_xdata()) == 3]
    np.testing.assert_array_equal(line.get_xdata(), dataset["N0"].values)


def test_crossings_are_joined_in_order_or_by_their_mode():
    """Another mode crosses too at the second point, and at the last the modes' numbers differ."""
    dataset = data.crossings().isel(crossing=[1, 1], R=[0, 0, 0, 0])
    dataset = dataset.assign_coords(R=[1.0, 2.0, 3.0, 4.0])
    dataset["critical_value"][:] = [[1.0, np.nan], [0.2, 1.1], [1.2, np.nan], [1.3, np.nan]]
    dataset["crossing_mode"][:] = [[2, 0], [0, 2], [2, 0], [4, 0]]
    (ax,) = draw(dataset, figure("curve")).axes
    drawn = sorted(line.get_xydata().tolist() for line in ax.lines)
    assert drawn == [[[1.0, 1.0], [2.0, 1.1], [3.0, 1.2], [4.0, 1.3]], [[2.0, 0.2]]]


@pytest.mark.parametrize(
    ("heights", "modes", "lines"),
    [
        (  # one mode ends between the first two points, and another begins
            [[0.67, 0.98], [0.98, 4.9], [0.98, 1.8], [0.98, 1.5]],
            [[0, 2], [2, 4], [2, 4], [2, 4]],
            [[0.67], [0.98] * 4, [4.9, 1.8, 1.5]],
        ),
        (  # as many of the same mode, but not the same, for there was one more in all
            [[0.38, 3.8], [10.7, np.nan], [5.9, np.nan], [5.1, np.nan]],
            [[4, 6], [4, 0], [4, 0], [4, 0]],
            [[0.38], [3.8], [10.7, 5.9, 5.1]],
        ),
        ([[1, 5], [1.1, 5.1], [1.2, 5.2], [1.3, 5.3]],  # the numbers of two modes change
         [[0, 2], [2, 0], [2, 0], [2, 0]],
         [[1, 1.1, 1.2, 1.3], [5, 5.1, 5.2, 5.3]]),
    ],
)  # fmt: skip
def test_crossings_are_joined_only_as_far_as_they_can_be_followed(heights, modes, lines):
    dataset = data.crossings().isel(crossing=[1, 1], R=[0, 0, 0, 0])
    dataset = dataset.assign_coords(R=[1.0, 2.0, 3.0, 4.0])
    dataset["critical_value"][:], dataset["crossing_mode"][:] = heights, modes
    (ax,) = draw(dataset, figure("curve")).axes
    assert sorted(line.get_ydata().tolist() for line in ax.lines) == lines


def test_a_curve_of_boundaries_says_what_lies_below_and_above_and_how_well_it_is_known():
    dataset = data.boundaries()
    (ax,) = draw(dataset, figure("curve")).axes
    assert legend_texts(ax) == [
        REST_ABOVE,
        UNDECIDED_ABOVE,
        "error not known",
    ]
    np.testing.assert_array_equal(marks(ax, REST_ABOVE), [[20, 4], [30, 7]])
    (bars,) = (bars.get_segments() for bars in ax.collections)
    ends = [[[20, 3.9], [20, 4.1]], [[30, 6.8], [30, 7.2]]]
    np.testing.assert_allclose(bars, ends)
    unknown = marks(ax, f"_{UNDECIDED_ABOVE}, error not known")
    np.testing.assert_array_equal(unknown, [[40, 10]])


def test_a_curve_runs_along_the_longest_axis_unless_the_figure_says_otherwise():
    dataset = data.stability_map(nx=3, ny=50)
    drawn = draw(dataset, figure("curve", variable="L_s"))
    assert drawn.axes[0].get_xlabel() == "normal preload $N_0$ (N)"
    many = draw(dataset, figure("curve", variable="L_s", x="Omega"))
    preloads = [text for text in legend_texts(many) if "N_0" in text and ":" not in text]
    known = dataset["L_s"].notnull().any([d for d in dataset["L_s"].dims if d != "N0"])
    ends = dataset["N0"].values[known.values][[0, -1]]
    assert [preloads[0], preloads[-1]] == [f"$N_0$ = {end:.6g} N" for end in ends]


def test_axes_that_advance_together_are_each_an_axis():
    omega = data.bifurcation()["Omega"]
    dataset = data.bifurcation().rename_dims(Omega="Omega_N0").drop_indexes("Omega")
    dataset = dataset.assign_coords(N0=("Omega_N0", 10 * omega.values, {"units": "N"}))
    omega_label = r"disc speed $\Omega$ (rad/s), $N_{0}$ with it"
    for name, label in (("Omega", omega_label), ("N0", r"$N_{0}$ (N), $\Omega$ with it")):
        (ax,) = draw(dataset, figure("curve", x=name)).axes
        assert ax.get_xlabel() == label  # the other is not fixed
        at = marks(ax, "far")[:, 0]
        assert np.array_equal(at[np.isfinite(at)], dataset[name])
    lines = draw(dataset.isel(Omega_N0=[0, 9]), figure("curve", x="initial", variable="L_s"))
    assert "$\\Omega$ = 1.4 rad/s, $N_{0}$ = 14 N" in legend_texts(lines.axes[0])
    drawn = draw(dataset, figure("curve", x="initial", select={"N0": 20}))
    assert r"$\Omega$ = 2 rad/s" in drawn.get_suptitle()
    assert list(summarise({"": dataset})["analyses"][""]["axes"]) == ["Omega", "initial", "N0"]


def test_an_axis_of_names_is_drawn_at_its_names():
    dataset = data.bifurcation().rename(Omega="geometry")
    dataset = dataset.isel(geometry=[0, 1]).assign_coords(geometry=["linear", "nonlinear"])
    dataset = dataset[["status", "attractor", "L_s"]]
    (ax,) = draw(dataset, figure("curve", x="geometry")).axes
    assert [tick.get_text() for tick in ax.get_xticklabels()] == ["linear", "nonlinear"]


def test_scales_and_limits_follow_the_figure():
    drawn = draw(data.bifurcation(), figure("curve", log="x", xlim=[1, "120 rpm"], ylim=[0, 1]))
    (ax,) = drawn.axes
    assert (ax.get_xscale(), ax.get_yscale()) == ("log", "linear")
    assert ax.get_xlim() == pytest.approx((1, 4 * np.pi))
    assert ax.get_ylim()[1] == 1


@pytest.mark.parametrize("kind", ["bifurcation", "curve"])
def test_the_ordinate_reaches_over_what_lies_between_the_limits(kind):
    """Up to where a line is cut; gaps, and entries of the legend, are of what is seen."""
    dataset = data.bifurcation()
    asked = figure(kind, xlim=[2.03, 3.03], **{"variable": "L_s"} if kind == "curve" else {})
    (ax,) = draw(dataset, asked).axes
    low, high = (1e-4 * 2.03, 2e-4 * 3.03) if kind == "curve" else (0.0342, 0.058)
    margin = 0.05 * (high - low)
    assert ax.get_ylim()[1] == pytest.approx(high + margin)
    assert low - 4.0 * margin < ax.get_ylim()[0] <= low - 0.99 * margin  # the gaps stand below
    told = {"near", "far", "failed: far", "undecided: far", "value of an undecided motion"}
    assert told & {*legend_texts(ax)} == {"near", "far", "failed: far"}
    assert marks(ax, "failed: far").shape == (1, 2)
    given = figure(kind, **asked.settings, ylim=[-1.0, 1.0])
    assert draw(dataset, given).axes[0].get_ylim() == (-1.0, 1.0)
    beyond = figure(kind, **asked.settings | {"xlim": [9.0, 10.0]})
    assert not draw(dataset, beyond).findobj(Legend)


def test_a_part_in_view_that_is_constant_is_drawn_as_one():
    """But zero, above which modes grow, stays in the panel of their growth."""
    dataset = data.bifurcation()
    dataset["L_s"] = 0.03 + 1e-14 * dataset["Omega"] + (dataset["Omega"] < 2.0) * dataset["L_s"]
    low, high = draw(dataset, figure("curve", variable="L_s", xlim=[2.5, 4.0])).axes[0].get_ylim()
    assert low < 0.03 < high and high - low > 0.003
    growth = draw(data.eigenvalues(), figure("eigenvalues", xlim=[0.2, 0.4])).axes[0]
    low, high = growth.get_ylim()
    assert -0.1 < low < -0.05 and 0.0 < high < 0.1


def test_error_bars_in_view_have_room():
    """The line leads from 4 at 20 N to 7 ± 0.2 at 30 N."""
    asked = figure("curve", variable="boundary", xlim=[29.0, 35.0])
    assert draw(data.boundaries(), asked).axes[0].get_ylim() == pytest.approx((6.675, 7.225))


@pytest.mark.parametrize("log", ["x", "y", True])
def test_what_has_no_logarithm_is_counted_and_no_limit_reaches_for_it(log, stored):
    """Of speeds from -1 to 3.5 rad/s; L_s is zero at rest."""
    dataset = data.bifurcation()
    dataset["Omega"] = dataset["Omega"] - 1.5
    drawn = draw(dataset, figure("curve", variable="L_s", log=log))
    (ax,) = drawn.axes
    save(drawn, "log.png")
    told = [points for name in ("near", "far", "_far, value of an undecided motion")
            for points in marks(ax, name) if np.isfinite(points).all()]  # fmt: skip
    x, y = (of.values.ravel() for of in xr.broadcast(dataset["Omega"], dataset["L_s"]))
    shown = ((x > 0.0) | (log == "y")) & ((y > 0.0) | (log == "x")) & np.isfinite(y)
    assert sorted(map(tuple, told)) == sorted(zip(x[shown], y[shown], strict=True))
    assert f"not above 0, not shown: {np.isfinite(y).sum() - shown.sum()}" in legend_texts(ax)
    assert ax.dataLim.y0 == y[shown].min()
    remark = f"not above 0, not shown: {np.isfinite(y).sum() - shown.sum()}"
    assert f',"{remark}",,nan,nan' in as_csv(
        drawn, Path("log.csv")
    )  # nor are they in the table silently


# --- map ---------------------------------------------------------------------------------------
def test_a_map_has_a_panel_for_each_start_and_a_cell_for_each_point():
    dataset = data.stability_map()
    drawn = draw(dataset, figure("map"))
    for ax, label in zip(drawn.axes, ("reached", "exists"), strict=True):
        assert ax.get_title() == label
        (mesh,) = [c for c in ax.collections if isinstance(c, QuadMesh)]
        assert mesh.get_array().shape == (17, 21)
        assert mesh.get_array().mask.sum() == 6
        assert ax.get_xlabel() == r"disc speed $\Omega$ (rad/s)"
    assert drawn.axes[0].get_ylabel() == "normal preload $N_0$ (N)"


def test_a_map_colours_classes_alike_everywhere_and_names_them():
    dataset = data.stability_map()
    drawn = draw(dataset, figure("map"))
    expected = ["equilibrium", "periodic", "undecided", "not reached"]
    assert legend_texts(drawn) == expected
    (mesh,) = [c for c in drawn.axes[0].collections if isinstance(c, QuadMesh)]
    place = mesh.get_array()
    truth = dataset["attractor"].sel(initial="reached").transpose("N0", "Omega").values
    known = ~np.ma.getmaskarray(place)
    assert len(set(zip(place[known].tolist(), truth[known].tolist(), strict=True))) == 3


def test_a_map_of_which_nothing_has_a_class_is_hatched_all_over():
    dataset = data.stability_map()
    dataset["attractor"] = dataset["attractor"].copy(data=np.full_like(dataset["attractor"], -1))
    drawn = draw(dataset, figure("map"))
    assert not any(isinstance(c, QuadMesh) for ax in drawn.axes for c in ax.collections)


def test_values_that_reach_too_far_are_refused_in_words(tmp_path):
    dataset = data.bifurcation()
    dataset["L_s"] = dataset["L_s"] * 0.0 + 1e307
    with pytest.raises(UsageError, match=r"reach from .*e\+307, which cannot be drawn"):
        save(draw(dataset, figure("curve", variable="L_s")), tmp_path / "a.png")


def test_a_title_may_be_as_long_as_it_likes(tmp_path):
    dataset = data.bifurcation().assign_attrs(title="a" * 100_000)
    drawn = draw(dataset, figure("curve", variable="L_s", title="$\\mu^$ " + "b" * 100_000))
    save(drawn, tmp_path / "a.png")
    assert len(drawn._suptitle.get_text()) < 1000


def test_a_map_of_numbers_has_a_colour_bar_with_unit():
    drawn = draw(data.stability_map(), figure("map", variable="L_s"))
    assert drawn.axes[-1].get_ylabel() == "$L_s$ (rad$^{2}$)"
    (mesh,) = [c for c in drawn.axes[1].collections if isinstance(c, QuadMesh)]
    truth = data.stability_map()["L_s"].sel(initial="exists").transpose("N0", "Omega").values
    assert np.array_equal(mesh.get_array().filled(np.nan), truth, equal_nan=True)


@pytest.mark.parametrize("still", [0.0, -1.0])
def test_shades_of_a_map_may_be_logarithmic(still):
    """A rest has no logarithm: it is grey, and said to be 0."""
    dataset = data.stability_map()
    numbers = dataset["L_s"] = np.abs(dataset["L_s"]) + 1e-3
    numbers[0] = still
    dataset["L_s"] = numbers
    drawn = draw(dataset, figure("map", variable="L_s", log="z"))
    (mesh,) = [c for c in drawn.axes[1].collections if isinstance(c, QuadMesh)]
    least, greatest = (float(end) for end in mesh.get_clim())
    assert isinstance(mesh.norm, LogNorm) and 0.0 < least < greatest
    assert greatest == float(numbers.where(numbers > 0.0).max())
    assert to_hex(mesh.cmap(mesh.norm(0.5 * least))) == "#dddddd"
    assert legend_texts(drawn)[0] == ("$L_s$ = 0" if still == 0.0 else r"$L_s$ $\leq$ 0")
    dataset["L_s"] = 0.0 * numbers
    (mesh, *_) = draw(dataset, figure("map", variable="L_s", log="z")).axes[0].collections
    assert not isinstance(mesh.norm, LogNorm)


def test_cells_without_a_number_are_named_by_what_is_there():
    dataset = data.stability_map()
    moves = dataset["attractor"] == data.codes(data.ATTRACTORS, "periodic")
    dataset["period"] = dataset["L_s"].where(moves)
    assert legend_texts(draw(dataset, figure("map", variable="period"))) == [
        "no value: not reached, undecided, equilibrium"
    ]


def test_numbers_of_motions_that_had_not_settled_are_marked_on_a_map():
    dataset = data.stability_map()
    drawn = draw(dataset, figure("map", variable="L_s"))
    undecided = dataset["attractor"] == data.codes(data.ATTRACTORS, "undecided")
    (x,), (y,) = (dataset[name].values[:1] for name in ("Omega", "N0"))
    assert int(undecided.sum()) == 2  # the same point from both starts
    for ax in drawn.axes[:2]:
        assert marks(ax, "undecided").tolist() == [[x, y]]
    assert "undecided" in legend_texts(drawn)
    assert "undecided" in legend_texts(draw(dataset, figure("map")))  # there a class of its own
    decided = draw(dataset.isel(Omega=slice(1, None)), figure("map", variable="L_s"))
    assert not any(ax.lines for ax in decided.axes)


def test_a_number_of_a_motion_on_its_way_stretches_no_shades_of_a_map():
    """It is marked as any that is undecided; a cell without a shade would have said no number."""
    dataset = data.stability_map().isel(Omega=slice(0, 18))
    told = np.full(dataset["attractor"].shape, "none", dtype=object)
    told[0, 0] = "time_budget"
    codes = {"none": 0, "time_budget": 1}
    dataset["reason"] = data.flags(dataset["attractor"].dims, told, codes)
    dataset["L_s"].values[0, 0] = 1e9
    drawn = draw(dataset, figure("map", variable="L_s"))
    (mesh,) = [c for c in drawn.axes[0].collections if isinstance(c, QuadMesh)]
    assert mesh.norm.vmax < 1.0
    assert not np.ma.getmaskarray(mesh.get_array()).any()
    (of_bar,) = [c for c in drawn.axes[1].collections if isinstance(c, QuadMesh)]
    assert of_bar.colorbar.extend == "max"
    assert legend_texts(drawn) == ["undecided"]
    dataset["reason"].values[...] = 1  # where all are, these are the shades
    drawn = draw(dataset, figure("map", variable="L_s"))
    (mesh,) = [c for c in drawn.axes[0].collections if isinstance(c, QuadMesh)]
    assert mesh.norm.vmax == 1e9


@pytest.mark.parametrize(("count", "columns"), [(1, 1), (3, 3), (4, 2), (5, 3), (6, 3)])
def test_panels_stand_in_rows_that_are_as_long(count, columns):
    assert style.side_by_side(count, 3, 0) == columns


@pytest.mark.parametrize(("key", "is_told"), [({}, True), (style.COLOUR_ALONE, False)])
def test_a_key_has_the_colour_of_what_it_stands_for_unless_others_tell_colours(key, is_told):
    """The key of lines that lie on one another tells of these lines alone."""
    _, (ax,) = style.new_panels(1, 1, "")
    ax.plot([0.0, 1.0], [0.0, 1.0], color=style.PURPLE, label="_unstable cycle")
    ax.plot([], [], color=style.BLUE, label="small and up", **key)
    (stands_for,) = ax.plot([], [], color=BLACK, label="unstable cycle")
    legends.colour_keys([ax])
    assert (stands_for.get_color() == style.PURPLE.lower()) == is_told


def test_a_legend_has_no_more_columns_than_its_rows_need():
    assert legends.columns_of(["word"] * 6, 5 * (4 + legends.KEY_LETTERS)) == 3
    assert legends.columns_of(["word"] * 5, 5 * (4 + legends.KEY_LETTERS)) == 5
    assert legends.columns_of(["word"] * 6, 4) == legends.columns_of([], 4) == 1


@pytest.mark.parametrize(
    ("width", "more", "is_on_its_line"),
    [(85.0, 1.2345e-7, False), (90.0, 0.0, True), (240.0, 1e-9, True)],
)
def test_levels_are_written_where_a_panel_is_large_beside_them(width, more, is_on_its_line):
    """Along their lines; of a line that is too short, upright beside it."""
    dataset = data.stability_map()
    asked = figure("map", variable="L_s", level=[0.0005 + more, 0.001])
    drawn = draw(dataset, asked, look=look_of("paper", width=width))
    turned = [text.get_rotation() != 0.0 for text in drawn.axes[0].texts]
    assert turned and any(turned) == is_on_its_line
    assert any("0.0005" in text.get_text() for text in drawn.legends[0].get_texts())


def test_eight_sorts_of_points_have_marks_that_are_told_apart():
    looks = {style.mark_of(number, 8, 1.0)["marker"] for number in range(8)}
    assert len(looks) == 8


@pytest.mark.parametrize(("most", "shades"), [(3, 4), (40, 256), (10**12, 256)])
def test_counts_have_a_shade_each_where_they_are_few(most, shades):
    dataset = data.stability_map()
    dataset["n_solutions"] = (dataset["L_s"] / dataset["L_s"].max() * most).round()
    drawn = draw(dataset, figure("map", variable="n_solutions"))
    (mesh,) = [c for c in drawn.axes[0].collections if isinstance(c, QuadMesh)]
    assert len(np.unique(mesh.norm(np.linspace(0.0, most, 1000)))) == shades or most > 12
    assert isinstance(mesh.norm, BoundaryNorm) == (most <= 12)
    if most <= 12:
        assert drawn.axes[-1].get_yticks().tolist() == [0.0, 1.0, 2.0, 3.0]


def test_how_many_classes_there_are_is_a_count():
    taken = figure("map", take={"what": "classes", "over": ["initial"]})
    drawn = draw(data.stability_map(ny=30).isel(Omega=slice(1, None)), taken)
    (mesh,) = [c for c in drawn.axes[0].collections if isinstance(c, QuadMesh)]
    assert isinstance(mesh.norm, BoundaryNorm)
    assert drawn.axes[-1].get_yticks().tolist() == [1.0, 2.0]


def test_a_count_that_is_not_certain_has_no_shade():
    """Where a start is undecided there are one or two classes, and not one and a half."""
    taken = figure("map", take={"what": "classes", "over": ["initial"]})
    dataset = data.stability_map(ny=30)
    drawn = draw(dataset, taken)
    (mesh,) = [c for c in drawn.axes[0].collections if isinstance(c, QuadMesh)]
    assert isinstance(mesh.norm, BoundaryNorm)
    assert {*np.unique(mesh.get_array().compressed())} <= {1.0, 2.0}
    assert legend_texts(drawn) == ["no value: not reached, undecided"]


@pytest.mark.parametrize(
    ("number", "text"),
    [(-0.5, "\N{MINUS SIGN}0.5"), (30.0, "30"), (1e7, "$10^{7}$"), (-1e-5, "$-10^{-5}$"),
     (2.5e-4, "0.00025"), (-2.5e6, r"$-2.5 \times 10^{6}$"), (0.0, "0")],
)  # fmt: skip
def test_numbers_are_written_as_people_write_them_and_in_tables_as_programs_read_them(number, text):
    assert words.number_text(number) == text
    assert float(in_one_line(text)) == number


def test_a_map_has_the_label_of_its_colour_bar_that_it_asks_for():
    drawn = draw(data.stability_map(), figure("map", variable="L_s", zlabel="index"))
    (bar,) = (ax for ax in drawn.axes if ax.get_label() == "<colorbar>")
    assert bar.get_ylabel() == "index"
    with pytest.raises(UsageError, match="this map has no colour bar"):
        draw(data.stability_map(), figure("map", zlabel="class"))


@pytest.mark.parametrize(
    ("kind", "asked", "said", "kept"),
    [
        ("bifurcation", {"near": "from rest", "failed": "lost"}, ["from rest", "lost: far"], "far"),
        ("map", {"periodic": "squeal"}, ["squeal"], "equilibrium"),
        ("phase", {"stick": "held", "x": "y", "dot": "no"}, ["held"], r"$\dot{\varphi}$ (rad/s)"),
        ("history", {"time": "duration", "start": ""}, ["duration $t$ (s)"], "stick"),
        ("curve", {"disc speed Omega": "speed", "ear": "no"}, ["speed (rad/s)"], "near"),
    ],
)
def test_a_figure_is_written_in_words_of_ones_own(kind, asked, said, kept):
    """Names are matched whole, as they are written or as symbols; formulas have none in them."""
    dataset = {
        "map": data.stability_map, "phase": data.history, "history": data.history
    }.get(kind, data.bifurcation)()  # fmt: skip
    drawn = draw(dataset, figure(kind, words=asked))
    texts = [text.get_text() for one in drawn.findobj(Legend) for text in one.get_texts()]
    texts += [label for ax in drawn.axes for label in (ax.get_xlabel(), ax.get_ylabel())]
    assert {*said, kept} <= {*texts}
    told = draw(dataset, figure(kind))
    plain = [text.get_text() for one in told.findobj(Legend) for text in one.get_texts()]
    plain += [label for ax in told.axes for label in (ax.get_xlabel(), ax.get_ylabel())]
    assert kept in plain and not {*said} & {*plain}


def test_names_of_starts_are_no_part_of_other_words_nor_are_labels_that_are_given():
    dataset = data.bifurcation().assign_coords(initial=["rest", "disc speed"])
    words = {"rest": "from 0", "disc speed": "with the disc", "rad": "radian"}
    (ax,) = draw(dataset, figure("bifurcation", words=words, ylabel="where it is (rad)")).axes
    assert {"from 0", "with the disc"} <= {*legend_texts(ax)}
    assert any(text.startswith("undecided: with the disc") for text in legend_texts(ax))
    assert ax.get_xlabel().startswith("disc speed ") and ax.get_ylabel() == "where it is (rad)"
    assert not any("at from 0" in text for text in legend_texts(ax))


def test_words_of_ones_own_are_in_tables_and_under_axes_of_names():
    drawn = draw(data.bifurcation(), figure("bifurcation", words={"near": "from rest"}))
    rows = csv.reader(as_csv(drawn, Path("a.csv")).splitlines()[1:])
    assert {"from rest", "far"} <= {row[4] for row in rows}
    (ax,) = draw(data.bifurcation(), figure("curve", x="initial", words={"far": "away"})).axes
    assert [text.get_text() for text in ax.get_xticklabels()] == ["near", "away"]


def test_a_level_is_called_as_a_table_spells_it():
    level = {"L_s": 0.001}
    words = {"L_s = 0.001 rad^2": "border of stick-slip", "L_s": "index"}
    drawn = draw(data.stability_map(), figure("map", variable="attractor", level=level))
    assert "$L_s$ = 0.001 rad$^{2}$" in legend_texts(drawn)
    asked = figure("map", variable="attractor", level=level, words=words)
    drawn = draw(data.stability_map(), asked)
    assert "border of stick-slip" in legend_texts(drawn)
    assert style.unsaid(drawn) == ["L_s"]  # which stands in no other entry


def test_the_share_of_each_class_is_a_line():
    """They add up to one where each start has a class, and have the standard error of their own."""
    starts = [f"far-{n:03d}" for n in range(4)]
    classes = np.array([
        ["periodic", "chaotic", "contact_lost", "chaotic"],
        ["equilibrium"] * 4,
        ["equilibrium", "periodic", "periodic", "periodic"],
    ], object)  # fmt: skip
    axes = data.axes(Omega=[1.0, 2.0, 3.0], initial=starts)
    dataset = data.response(classes, np.ones(classes.shape), axes)
    dataset.attrs["starts_json"] = '{"far": "random"}'
    share = {"what": "share", "of": "each", "over": ["initial"]}
    drawn = draw(dataset, figure("curve", x="Omega", variable="attractor", take=share))
    error = "standard error; at 0 and 1: 95% bound"
    told = ["equilibrium", "periodic", "chaotic", "contact lost", error]
    (ax,) = drawn.axes
    assert legend_texts(ax) == told and ax.get_ylabel() == "share"
    drawn_in = {line.get_label(): line.get_color() for line in reversed(ax.lines)}
    assert all(drawn_in[name] == style.CLASSES[name.replace(" ", "_")] for name in told[:-1])
    rows = list(csv.DictReader(as_csv(drawn, Path("a.csv")).splitlines()))
    heights = [float(row["y"]) for row in rows if row["series"] in told]
    assert sum(heights) == pytest.approx(3.0) and len(heights) == 12
    assert any(row["series"] == "periodic, error bar" for row in rows)


def test_all_starts_have_one_name_in_all_panels():
    """By their own names in one, where these are short enough, they were other lines there."""
    starts = ["from rest", "with belt 1", "with belt 2"]
    axes = data.axes(V=[1.0, 2.0, 3.0], N0=[1.0, 2.0], initial=starts)
    dataset = data.response(np.full((3, 2, 3), "periodic", object), np.ones((3, 2, 3)), axes)
    dataset["L_s"].values[:] *= np.array([1.0, 2.0])[:, None]
    shares = np.ones((3, 2, 3, 2)) * np.array([0.3, 0.6])
    told = (("V", "N0", "initial", "contact"), shares / np.array([1.0, 2.0])[:, None, None])
    dataset = dataset.assign_coords(contact=[1, 2]).assign(stick_fraction=told)
    words = {"contact = 1": "on the belt on the left", "contact = 2": "on the belt on the right"}
    both = {"variable": ["L_s", "stick_fraction"], "x": "V", "words": words}
    told = legend_texts(draw(dataset, figure("curve", **both)).axes[0])
    assert sum("N_0$ = 1 N" in text for text in told) == 1, told


def test_lines_that_hide_one_another_keep_their_places():
    """Else they, and those after them, had other colours than in other figures of the dataset."""
    dims = ("Omega", "N0", "contact")
    shares = np.zeros((4, 4, 2))
    shares[:, 0], shares[:, 1, 0], shares[:, 2] = 0.3, 0.6, [0.2, 0.1]
    shares[:, 3, 1] = 0.5
    axes = data.axes(Omega=np.arange(4.0), N0=[1.0, 2.0, 3.0, 4.0])
    dataset = data.response(np.full((4, 4), "periodic", object), np.ones((4, 4)), axes)
    dataset = dataset.assign_coords(contact=[1, 2]).assign(stick_fraction=(dims, shares))
    (ax,) = draw(dataset, figure("curve", x="Omega", variable="stick_fraction")).axes
    told = [text for text in legend_texts(ax) if "N_0" in text]
    assert told == sorted(told) and len({text[:10] for text in told}) == 4


def test_a_share_steps_as_it_likes_and_is_one_line():
    classes = np.full((12, 8), "periodic", object)
    for row, rests in enumerate([0, 0, 0, 0, 0, 0, 7, 7, 7, 7, 7, 7]):
        classes[row, :rests] = "equilibrium"
    axes = data.axes(Omega=np.arange(12.0), initial=[f"far-{n:03d}" for n in range(8)])
    dataset = data.response(classes, np.ones(classes.shape), axes)
    share = {"what": "share", "of": "periodic", "over": ["initial"]}
    (ax,) = draw(dataset, figure("curve", x="Omega", variable="attractor", take=share)).axes
    (line,) = [line for line in ax.lines if len(line.get_xdata()) > 1]
    assert np.isfinite(line.get_ydata()).all() and line.get_ydata()[[5, 6]].tolist() == [1.0, 0.125]


def test_a_point_that_another_hides_has_a_ring():
    """Of lines that stand for points alone; where a line leads through it that is seen."""
    dataset = data.bifurcation()
    dataset["L_s"][:] = np.nan
    dataset["L_s"][5, :] = 0.1
    dataset["L_s"][9, 1] = 0.2
    (ax,) = draw(dataset, figure("curve", variable="L_s")).axes
    ring, key = [line for line in ax.lines if line.get_marker() == "s"]
    assert ring.get_ydata().tolist() == [0.1]
    assert key.get_label() == "several, one upon another" in legend_texts(ax)
    assert to_hex(ring.get_color()) == to_hex(points.colours([ax])["near"])


def test_words_of_ones_own_may_stand_for_a_variable_by_its_name():
    dataset = data.bifurcation()
    dataset = dataset.assign(L_s_reference=dataset["L_s"].assign_attrs(long_name="reference of x"))
    words = {"L_s": "strength", "L_s_reference": "rest"}
    wanted = figure(
        "curve", variable=["L_s", "L_s_reference"], select={"initial": "near"}, words=words
    )
    drawn = draw(dataset, wanted)
    told = [text.get_text() for one in drawn.findobj(Legend) for text in one.get_texts()]
    assert told == ["strength and rest"]  # of one start they are the same
    known = ["bound:boundary", "a:L_s", "b:L_s"]  # of another case, where no two have it
    assert [_meant(word, known) for word in ("boundary", "L_s")] == ["bound:boundary", "L_s"]


def test_a_contact_has_the_same_name_however_a_figure_writes_it():
    with style.looks(words={"contact 1": "belt", "x": ""}):
        told = style.worded("x, contact = 1, contact 10, contact 1 sticks, $x$, $\\dot{x}$")
    assert told == r", belt, contact 10, belt sticks, , $\dot{x}$"
    assert style.worded("x, contact 1") == "x, contact 1"


def test_words_and_limits_are_for_the_panel_that_is_given():
    both = Figure()
    given, other = both.subplots(1, 2)
    other.plot([0.0, 1.0], [0.0, 1.0])
    other.set_title("near far")
    draw(data.bifurcation(), figure("bifurcation", words={"near": "x"}, ylim=(0.0, 9.0)), given)
    assert other.get_title() == "near far" and other.lines[0].get_clip_on()
    assert "x" in legend_texts(given)


def test_words_that_a_figure_does_not_have_are_told_with_those_that_it_has(tmp_path):
    """As they are without its own, for which others are written."""
    words = {"belt": "disc", "ear": "", "near": "close"}  # "disc" is there by itself
    asked = FigureSpec("d", "bifurcation", {"words": words})
    data.bifurcation().assign_attrs(data.attributes(asked)).to_netcdf(tmp_path / "a.nc")
    told = CliRunner().invoke(plot_command, [str(tmp_path / "a.nc"), "-o", str(tmp_path / "a.png")])
    assert told.exit_code == 0
    assert "words: 'belt', 'ear': in no legend and at no axis; there: near; far" in told.stderr


@pytest.mark.parametrize("log", [False, "z"])
def test_the_shades_of_a_map_reach_as_far_as_it_says(log):
    """What lies beyond has the colour of the end; 0 has one of its own where there is no log."""
    dataset = data.stability_map(initial=("reached",))
    values = np.geomspace(1e-9, 1.0, dataset["L_s"].size)
    dataset["L_s"] = dataset["L_s"].copy(data=values.reshape(dataset["L_s"].shape))
    dataset["L_s"].values.ravel()[0] = 0.0
    drawn = draw(dataset, figure("map", variable="L_s", log=log, zlim=(1e-4, 1e-2)))
    (mesh,) = drawn.findobj(QuadMesh, include_self=False)[:1]
    assert (mesh.norm.vmin, mesh.norm.vmax) == (1e-4, 1e-2)
    shown = np.ma.filled(mesh.get_array(), np.nan)
    outside = {*shown[(shown < 1e-4) | (shown > 1e-2)].ravel()}
    assert outside == ({0.5e-4} if log else set())
    assert mesh.colorbar.extend == "both"


def test_equilibria_of_a_diagram_of_cycles_are_those_beside_it():
    """Where nothing says what L_s is measured from: an analysis `equilibrium` of the case does."""
    case = api.load(
        {
            "schema": 1,
            "model": {"name": "flutter-2dof", "parameters": {"c1": 0.1, "c2": 0.1}},
            "grid": {"mu_k": [4.0, 5.0, 6.0]},
            "initial": [{"kind": "equilibrium", "label": "near", "offset": {"x": 0.1}}],
            "analysis": [
                {"kind": "cycle", "section": {"zero": "x_dot"}, "t_max": 400.0},
                {"kind": "eigenvalues"},
                {"kind": "equilibrium"},
            ],
        }
    )
    found = {name: of.to_dataset() for name, of in api.run(case, workers=1).children.items()}
    (ax,) = draw(found, figure("bifurcation", x="mu_k")).axes
    heights = found["equilibrium"]["equilibrium"].sel(state="x").values.ravel()
    drawn = marks(ax, "unstable equilibrium")
    unstable = drawn[np.isfinite(drawn).all(axis=1)]
    assert unstable[-1].tolist() == [6.0, heights[2]] and (unstable[:, 0] > 4.0).all()
    assert len(marks(ax, "stable equilibrium"))


def test_a_line_that_passes_between_its_points_is_inside_a_map():
    corners = np.array([[1.0, 1.0], [2.0, 2.0]])
    across, beside = (np.array([0.0, 3.0]), np.array([0.5, 2.5])), (np.zeros(2), np.ones(2))
    assert _is_inside(across, corners) and not _is_inside(beside, corners)
    assert _is_inside((np.array([1.5]), np.array([2.0])), corners)


def test_of_a_refined_map_rests_that_were_filled_in_are_0_where_all_that_ran_are():
    """As L_s at an equilibrium is; where some rest elsewhere, nothing is known of the others."""
    for elsewhere, unknown in ((0.0, False), (0.5, True), (-0.5, True)):
        dataset = data.stability_map(initial=("reached",))
        rests = is_class(dataset["attractor"], ("equilibrium",)).values
        first, *_, last = np.argwhere(rests)
        dataset["L_s"].values[rests], dataset["L_s"].values[tuple(last)] = 0.0, elsewhere
        computed = np.full(rests.shape, "run", object)
        computed[tuple(first)] = "filled_in"
        dataset["L_s"].values[tuple(first)] = np.nan
        dataset["status"].values[tuple(first)] = data.codes(data.STATUS, "not_reached")
        dims = dataset["attractor"].dims
        dataset["computed"] = data.flags(dims, computed, ("run", "sampled", "filled_in"))
        drawn = draw(dataset.assign_attrs(refined_of="attractor"), figure("map", variable="L_s"))
        told = [one for one in legend_texts(drawn) if "filled in (the class alone)" in one]
        assert bool(told) == unknown


def test_a_level_between_values_that_lie_apart_has_a_line_without_a_point():
    """No cell between points is known whole, as where a refined map ran few of them."""
    dataset = data.stability_map(initial=("reached",))
    apart = np.zeros(dataset["L_s"].shape, bool)
    apart[2, 2], apart[6, 6] = True, True
    dataset["L_s"] = dataset["L_s"].copy(data=1.0 + np.arange(apart.size).reshape(apart.shape))
    dataset["L_s"] = dataset["L_s"].where(apart)
    level = float(dataset["L_s"].mean())
    drawn = draw(dataset, figure("map", variable="L_s", level=level))
    assert not drawn.findobj(ContourSet) and not drawn.axes[0].texts


def test_files_of_one_figure_take_each_over_axes_of_its_own():
    """The share of random starts, and that of a lattice, at each speed."""
    drawn, lattice = data.basin(), data.basin()
    drawn = drawn.assign_attrs(starts_json=json.dumps({"any": "random"}))
    lattice = lattice.drop_vars("initial_state").assign_coords(initial=np.arange(200.0))
    lattice = lattice.rename(initial="initial_x").expand_dims(initial=["plane"])
    taking = {"what": "share", "of": "periodic"}
    figures = [
        figure("curve", variable="attractor", take=taking | {"over": [over]})
        for over in ("initial", "initial.x")
    ]
    files = [
        (name, one.assign_attrs(data.attributes(own) | {"starts_json": one.attrs["starts_json"]}))
        for name, one, own in zip(("drawn", "lattice"), (drawn, lattice), figures, strict=True)
    ]
    for own, order in ((figures[0], files), (figures[1], files[::-1])):
        (ax,) = draw(order, own).axes
        lines = [marks(ax, name) for name in ("drawn", "lattice")]
        assert np.allclose(*lines)


def test_a_level_that_a_ridge_touches_has_no_line_along_it():
    """To rounding, which made fragments of one; where the level is crossed the line stays."""
    dataset = data.stability_map(initial=("reached",))
    height = np.abs(dataset["N0"] - dataset["N0"][8]) + 0.0 * dataset["L_s"]
    noise = 1e-17 * np.sin(1e3 * np.arange(height.size)).reshape(height.shape)
    for level, is_drawn in ((0.0, False), (12.0, True)):
        ridge = (height + noise + 0.0 * dataset["L_s"]).transpose(*dataset["L_s"].dims)
        mapped = dataset.assign(L_s=ridge.assign_attrs(dataset["L_s"].attrs))
        drawn = draw(mapped, figure("map", variable="L_s", level=level))
        assert bool(drawn.findobj(ContourSet)) == is_drawn


def test_a_level_without_a_line_has_no_entry_in_the_legend():
    levels = {"variable": "L_s", "level": [1e-3, 1.0]}
    drawn = draw(data.stability_map(), figure("map", **levels))
    told = [text for text in legend_texts(drawn) if text.startswith("$L_s$")]
    assert told == ["$L_s$ = 0.001 rad$^{2}$"]
    assert "no line $L_s$ = 1 " in drawn.get_suptitle()


@pytest.mark.parametrize("level", [-1e-3, 1e-3])
def test_a_level_is_written_in_a_white_box(level):
    dataset = data.stability_map(initial=("reached",), nx=60, ny=60)
    dataset["L_s"] = np.sign(level) * dataset["L_s"]
    (ax, *_) = draw(dataset, figure("map", variable="L_s", level=level)).axes
    assert {one.get_text() for one in ax.texts} == {words.number_text(level)}
    assert {to_hex(one.get_bbox_patch().get_facecolor()) for one in ax.texts} == {"#ffffff"}


@pytest.mark.parametrize("kind", ["map", "history", "spectrum"])
def test_a_figure_too_narrow_for_its_panels_says_how_wide_it_may_be(kind):
    dataset = {"map": data.stability_map(), "history": data.history(), "spectrum": data.spectra()}
    with pytest.raises(UsageError, match="next: --width") as refused:
        draw(dataset[kind], figure(kind), look=look_of("paper", width=30.0))
    wide = float(str(refused.value).split("--width ")[1].split(";")[0])
    assert wide >= 40.0
    assert draw(dataset[kind], figure(kind), look=look_of("paper", width=wide)).axes
    with pytest.raises(UsageError, match="leave --height out"):
        draw(dataset[kind], figure(kind), look=look_of("screen", height=20.0))


def test_starts_on_both_axes_of_a_map_are_called_alike():
    """However long the meaning of a state is."""
    found = data.stability_map(initial=("reached",)).rename(Omega="initial_x", N0="initial_x_dot")
    for name, symbol, unit, meaning in (
        ("initial_x", "x", "m", "start: displacement of the mass"),
        ("initial_x_dot", r"\dot{x}", "m s-1", "start: velocity: displacement of the mass"),
    ):
        found[name].attrs = {"symbol": symbol, "units": unit, "long_name": meaning}
    (ax,) = draw(found, figure("map", variable="attractor")).axes
    assert (ax.get_xlabel(), ax.get_ylabel()) == ("initial $x$ (m)", r"initial $\dot{x}$ (m/s)")


def test_the_axes_of_a_map_can_be_exchanged():
    drawn = draw(data.stability_map(), figure("map", x="N0", y="Omega"))
    assert drawn.axes[0].get_xlabel() == "normal preload $N_0$ (N)"


def test_too_many_maps_ask_for_a_selection():
    with pytest.raises(UsageError, match="select"):
        draw(data.stability_map(initial=[f"s{n}" for n in range(7)]), figure("map"))


def corners(ax, colour):
    """Corners (x, y) of every line drawn in a colour, shape (n, 2)."""
    drawn = [c for c in ax.collections if to_hex(c.get_edgecolor()[0]) == colour.lower()]
    return np.concatenate([path.vertices for c in drawn for path in c.get_paths()])


def test_angles_given_in_degrees_are_named_in_degrees():
    def beta(*values):
        return xr.DataArray(np.array(values), attrs={"units": "rad"}, name="beta")

    sectors = beta(0.0, np.radians(5.0), np.radians(15.0))
    words_of = [words.value_label(sectors, value) for value in sectors.values]
    assert words_of == [rf"$\beta$ = {angle} deg" for angle in (0, 5, 15)]
    for values, word in (((0.0, 0.1), "0.1 rad"), ((0.0,), "0 rad")):
        assert words.value_label(beta(*values), values[-1]) == rf"$\beta$ = {word}"


def test_lines_at_levels_of_several_maps_lie_in_one_panel():
    """L_s is 1e-5 Omega N0 where there is stick-slip: the line at a level is that hyperbola."""
    dataset = data.stability_map(nx=96, ny=97)
    (ax,) = draw(dataset, figure("map", variable="L_s", level=[1e-3, 2e-4], overlay=True)).axes
    assert len(ax.collections) == 4  # two starts, two levels
    for colour in line_colours(2):
        x, y = corners(ax, colour).T
        products = (x * y)[x < 0.09 * y]  # away from where stick-slip ends
        far, near = products[products > 60.0], products[products < 60.0]
        assert min(len(far), len(near)) > 20
        assert far == pytest.approx(np.full(len(far), 100.0), rel=0.02)
        assert near == pytest.approx(np.full(len(near), 20.0), rel=0.02)
    words = ["reached", "exists", "$L_s$ = 0.0002 rad$^{2}$", "$L_s$ = 0.001 rad$^{2}$"]
    assert legend_texts(ax.figure) == words
    assert (ax.get_xlim(), ax.get_ylim()) == ((0.5, 10.0), (2.0, 50.0))
    assert ax.get_ylabel() == "normal preload $N_0$ (N)"


def test_of_several_levels_the_line_at_zero_is_the_one_without_dashes():
    response = with_growth()["response"]
    response["L_s"].values[:] = response["Omega"].values[:, None, None] - 2.0
    drawn = draw(response, figure("map", variable="L_s", level=[-1.0, 0.0, 1.0, 2.0]))
    keys = [key for key in drawn.legends[0].get_lines() if key.get_linestyle() != "None"]
    assert [key.get_linestyle() for key in keys][:3] == ["--", "-", ":"]
    assert len({str(key._unscaled_dash_pattern) for key in keys}) == 4


def test_lines_of_a_map_have_their_levels_written_on_them():
    dataset = data.stability_map(initial=("reached",), nx=96, ny=97)
    levels = {"variable": "L_s", "level": [1e-3, 2e-4]}
    for overlay in (False, True):
        ax = draw(dataset, figure("map", overlay=overlay, **levels)).axes[0]
        assert {text.get_text() for text in ax.texts} == {"0.001", "0.0002"}
    single, said = {"variable": "L_s", "level": 1e-3}, "$L_s$ = 0.001 rad$^{2}$"
    drawn = draw(dataset, figure("map", overlay=True, **single))
    assert not drawn.axes[0].texts and legend_texts(drawn) == [said]
    assert said in legend_texts(draw(dataset, figure("map", **single)))  # also of short lines
    both = draw(data.stability_map(nx=96, ny=97), figure("map", overlay=True, **single))
    assert legend_texts(both) == ["reached", "exists"]
    assert both.legends[0].get_title().get_text() == said


@pytest.mark.parametrize("overlay", [False, True])
def test_of_several_levels_the_one_next_to_rest_lies_between_rest_and_motion(overlay):
    """As a single level does: it is the border of a region, though that is a jump."""
    dataset = data.stability_map(initial=("reached",), nx=96, ny=97)
    along_the_jump = {}
    for level in ([5e-4], [1e-3], [5e-4, 1e-3], [-1e-4, 5e-4, 1e-3]):
        drawn = draw(dataset, figure("map", variable="L_s", level=level, overlay=overlay))
        for lines in drawn.findobj(ContourSet):
            x, y = np.concatenate(lines.allsegs[0]).T
            key = len(level), float(lines.levels[0])
            along_the_jump[key] = np.count_nonzero(abs(y / x - 10.0) < 0.5)
    assert along_the_jump[1, 5e-4] > 20 and along_the_jump[1, 1e-3] > 20
    for count in (2, 3):  # one on the other side of rest is another border
        assert along_the_jump[count, 5e-4] > 20 and along_the_jump[count, 1e-3] < 5
    drawn = draw(dataset, figure("map", variable="L_s", level=[1e-6, 2e-5], overlay=overlay))
    assert any("it lies in the jump" in note for note in style.notes_on(drawn))


@pytest.mark.parametrize("width", [60.0, 84.0, 200.0])
def test_levels_written_on_lines_that_run_close_do_not_lie_on_each_other(width):
    dataset = data.stability_map(initial=("reached",), nx=96, ny=97)
    levels = {"variable": "L_s", "level": [5e-4, 7e-4, 9e-4]}
    drawn = draw(dataset, figure("map", **levels), look=look_of("paper", width=width))
    drawn.canvas.draw()
    boxes = [text.get_window_extent() for text in drawn.axes[0].texts]
    told = {text.get_text() for text in drawn.axes[0].texts}
    assert len(told) == 3 or width < 200.0  # there the legend tells their dashes
    assert sum("L_s" in text for text in legend_texts(drawn.axes[0])) == 3
    assert not any(one.overlaps(other) for one, other in combinations(boxes, 2))
    (x0, y0), (x1, y1) = drawn.axes[0].bbox.get_points()
    assert all(x0 < b.x0 and b.x1 < x1 and y0 < b.y0 and b.y1 < y1 for b in boxes)


@pytest.mark.parametrize("overlay", [False, True])
def test_levels_on_logarithmic_axes_are_written_along_their_lines(overlay):
    """Where x y is constant, which is straight and slopes down."""
    dataset = data.stability_map(initial=("reached",), nx=40, ny=40)
    x = np.geomspace(1e-3, 1.0, 40)
    axes = {name: (name, x, dataset[name].attrs) for name in ("Omega", "N0")}
    dataset = dataset.assign_coords(axes)
    dataset["L_s"] = dataset["L_s"].copy(data=np.log10(x[:, None] * x)[..., None])
    asked = {"variable": "L_s", "level": [-5.0, -3.0, -1.0], "log": "xy", "overlay": overlay}
    drawn = draw(dataset, figure("map", **asked))
    ax = drawn.axes[0]
    slope = np.degrees(np.arctan(-ax.bbox.height / ax.bbox.width))
    assert len(ax.texts) >= 3 and style.notes_on(drawn) == []
    for text in ax.texts:
        assert (text.get_rotation() - slope + 90.0) % 180.0 == pytest.approx(90.0, abs=2.0)
        level = float(text.get_text().replace("\N{MINUS SIGN}", "-"))
        assert np.log10(np.prod(text.get_position())) == pytest.approx(level, abs=0.05)


def test_levels_on_steep_lines_are_all_written_upwards():
    response = with_growth()["response"]
    x, y = (response[name].values for name in ("Omega", "N0"))
    for lean in (-0.05, 0.05):
        response["L_s"].values[:] = (x[:, None] + lean * y)[..., None]
        drawn = draw(response, figure("map", variable="L_s", level=[3.0, 5.0, 7.0]))
        turned = [text.get_rotation() for text in drawn.axes[0].texts]
        assert len(turned) >= 3 and all(60.0 < angle <= 90.0 for angle in turned)


@pytest.mark.parametrize("reach", [0.08, 0.11, 0.14, 0.18])
def test_levels_are_written_on_lines_whose_dashes_are_finer(reach):
    """On a straight one across a corner, which is shorter than the dashes of its level, too."""
    dataset = data.stability_map(initial=("reached",), nx=31, ny=31)
    x, y = np.meshgrid(np.linspace(0.0, 1.0, 31), np.linspace(0.0, 1.0, 31), indexing="ij")
    dataset["L_s"].values[:] = (3.0 - (1.0 - x + y) / reach)[..., None]
    asked = figure("map", variable="L_s", level=[-3.0, -1.0, 1.0, 2.0])
    drawn = draw(dataset, asked, look=look_of("paper", width=85.0))
    assert "2" in {text.get_text() for text in drawn.axes[0].texts}


def test_where_a_line_of_another_case_is_not_joined_or_straight_is_told(tmp_path, monkeypatch):
    """Of a few places a step may be a leap, or one line; between more of the map it is straight."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "runs").mkdir()
    response = with_growth()["response"]
    many = response["Omega"].values
    few = many[np.linspace(0, many.size - 1, 5).round().astype(int)]
    long_name = {"long_name": "critical value of N0"}
    notes = {}
    for name, x, values in (
        ("whole", many, 4.0 * many),
        ("few", few, 4.0 * few),
        ("leap", many, 4.0 * many + np.where(many < many[9], 20.0, 0.0)),
        ("short", many, np.where(many < many[9], np.nan, 4.0 * many)),
        ("narrow", many[:12], 4.0 * many[:12]),
        ("beside", many + 2.0 * many.max(), 4.0 * many),
    ):
        found = {"critical_value": ("Omega", values, long_name)}
        found["status"] = data.statuses(("Omega",), np.full(x.size, "ok"))
        axis = {"Omega": ("Omega", x, response["Omega"].attrs)}
        xr.Dataset(found, axis, response.attrs).to_netcdf(f"runs/{name}.nc")
        asked = figure("map", x="Omega", y="N0", level={f"{name}:critical_value": "N0"})
        notes[name] = style.notes_on(draw(response, asked))
    assert notes["whole"] == []
    (straight,), (apart,) = notes["few"], notes["leap"]
    assert f"straight between its {few.size} values of Omega" in straight
    ends = [words.number_text(one, many.tolist()) for one in many[8:10]]
    assert f"not joined between Omega = {ends[0]} and {ends[1]}, where it steps" in apart
    (short,) = notes["short"]
    assert "its line ends where there is no value, at 9 places along Omega" in short
    (nowhere,) = notes["beside"]
    assert "no value within the map" in nowhere
    (narrow,) = notes["narrow"]
    end = words.number_text(many[11], many.tolist())
    assert f"its line ends at Omega = {end}, where the values of its case end" in narrow
    both = data.stability_map(initial=("near", "far"))
    far = [np.nan, 20.0] * np.ones((many.size, 1))
    found = {"critical_value": (("Omega", "initial"), far, long_name)}
    found["status"] = data.statuses(("Omega", "initial"), np.full(far.shape, "ok"))
    axes = {"Omega": ("Omega", many, both["Omega"].attrs), "initial": ["near", "far"]}
    xr.Dataset(found, axes, both.attrs).to_netcdf("runs/far.nc")
    asked = figure("map", x="Omega", y="N0", level={"far:critical_value": "N0"})
    (lacking,) = style.notes_on(draw(both, asked))
    assert lacking.endswith(": no line in panel near: its case has no value there")


@pytest.mark.parametrize("panels", [[True, True], [True, False], [False, False]])
def test_a_level_that_one_panel_has_no_room_for_is_told(monkeypatch, panels):
    """Though it is written in another."""
    dataset = with_growth()["response"]
    both = dataset.expand_dims({"c": [0.1, 0.2]}).transpose("Omega", "N0", "c", "initial")
    written = iter(panels)
    monkeypatch.setattr(levels, "draw", lambda *_, **__: (3.0, 5.0) if next(written) else (5.0,))
    both["L_s"] = both["L_s"] * 0.0 + both["Omega"]
    asked = figure("map", variable="L_s", x="Omega", y="N0", level=[3.0, 5.0])
    notes = style.notes_on(draw(both, asked))
    told = [note for note in notes if "L_s = 3: told in the legend alone" in note]
    assert len(told) == (not all(panels))


def test_a_level_is_written_over_no_undecided_point_where_there_is_room():
    dataset = with_growth()["response"]
    x, y = (dataset[name].values for name in ("Omega", "N0"))
    dataset["L_s"].values[:] = (x[:, None] + 0.0 * y)[..., None]
    classes = dataset["attractor"].isel(initial=0).values
    classes[:] = data.codes(data.ATTRACTORS, "periodic")
    shown = figure("map", variable="L_s", x="Omega", y="N0", level=[float(x[x.size // 2]) + 0.02])
    (free,) = draw(dataset, shown).axes[0].texts
    near = np.abs(y - free.get_position()[1]).argmin()
    classes[x.size // 2 - 1 : x.size // 2 + 2, near] = data.codes(data.ATTRACTORS, "undecided")
    drawn = draw(dataset, shown)
    drawn.canvas.draw()
    ax = drawn.axes[0]
    (text,) = ax.texts
    marks = [line for line in ax.lines if line.get_marker() == "o"]
    assert marks
    places = np.concatenate([ax.transData.transform(one.get_xydata()) for one in marks])
    assert not any(text.get_window_extent().contains(*place) for place in places)


def test_a_level_is_written_where_its_line_is_straight_and_no_other_is_near(tmp_path, monkeypatch):
    """Not at a corner, though that is far from its ends, nor over a critical line."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "runs").mkdir()
    dataset = with_growth()["response"]
    x, y = (dataset[name].values for name in ("Omega", "N0"))
    bent = 6.0 - 5.0 * abs(np.linspace(-1.0, 1.0, y.size))
    dataset["L_s"].values[:] = (x[:, None] - bent)[..., None]
    crit = xr.Dataset(
        {"critical_value": ("N0", bent + 1.5, {"long_name": "critical value of Omega"})},
        coords={"N0": ("N0", y, dataset["N0"].attrs)},
        attrs=dataset.attrs,
    )
    crit["status"] = data.statuses(("N0",), np.full(y.size, "ok"))
    crit.to_netcdf("runs/crit.nc")
    wanted = {"L_s": -0.0125, "crit:critical_value": "Omega"}
    drawn = draw(dataset, figure("map", x="Omega", y="N0", variable="L_s", level=wanted))
    ax = drawn.axes[0]
    drawn.canvas.draw()
    (line,) = [one for one in ax.lines if len(one.get_xdata()) == y.size]
    places = ax.transData.transform(line.get_xydata())
    boxes = [one.get_window_extent() for one in ax.texts]
    assert boxes and not any(box.contains(*place) for box in boxes for place in places)
    assert all(one.get_position()[0] < 5.8 for one in ax.texts)


@pytest.mark.parametrize("sharp", [0.003, 0.01, 0.03])
def test_a_level_is_written_away_from_the_nose_of_its_line(sharp):
    """Though places at the nose are further from its ends."""
    dataset = data.stability_map(initial=("reached",), nx=96, ny=97)
    x, y = (np.linspace(0.0, 1.0, dataset.sizes[name]) for name in ("Omega", "N0"))
    nose = 0.6 - np.sqrt(sharp**2 + (0.6 * (y - 0.5)) ** 2)
    dataset["L_s"].values[:] = (x[:, None] - nose)[..., None]
    settings = figure("map", x="Omega", y="N0", variable="L_s", level=-0.025)
    drawn = draw(dataset, settings, look=look_of("paper", width=120.0))
    (ax, *_) = drawn.axes
    drawn.canvas.draw()
    (text,), pixels = ax.texts, ax.transData.transform
    Omega = np.interp(nose - 0.025, x, dataset["Omega"].values)
    line = pixels(np.column_stack([Omega, dataset["N0"].values]))
    nearest = line[nose.argmax()] - pixels(text.get_position())
    text.set_rotation(0.0)
    assert np.linalg.norm(nearest) > 0.8 * text.get_window_extent().width


def test_of_one_level_one_line_has_it_written_on_it():
    """Not each of many islands, nor both lines of what undecided points leave open."""
    dataset = data.stability_map(nx=96, ny=97)
    x, y = (np.linspace(0.0, 6.0 * np.pi, dataset.sizes[name]) for name in ("Omega", "N0"))
    dataset["L_s"].values[:] = (np.sin(x)[:, None] * np.sin(y))[..., None]
    islands = draw(dataset.isel(initial=[0]), figure("map", variable="L_s", level=0.1)).axes[0]
    assert len(islands.findobj(ContourSet)[0].allsegs[0]) == 18 and len(islands.texts) == 1
    several = draw(dataset.isel(initial=[0]), figure("map", variable="L_s", level=[-0.5, 0.5]))
    told = [one.get_text() for one in several.axes[0].texts]
    assert all(1 <= told.count(level) <= MOST_WRITTEN for level in ("−0.5", "0.5"))


def test_a_map_without_a_line_at_the_level_says_on_which_side_it_lies():
    dataset = data.stability_map()
    dataset["L_s"][:, :, 0] = 1.0
    dataset["L_s"][:, :, 1] = 0.0
    drawn = draw(dataset, figure("map", variable="L_s", level=0.5, overlay=True))
    assert legend_texts(drawn)[:2] == ["reached, above everywhere", "exists, below everywhere"]
    assert not drawn.axes[0].collections
    lines = figure("map", variable="L_s", level=[0.5, 2.0])
    reason = "no line $L_s$ = 2 rad$^{2}$: below everywhere"
    assert draw(dataset, lines).get_suptitle().endswith(f"\n{reason}")
    dataset["L_s"][:] = np.nan
    drawn = draw(dataset, figure("map", variable="L_s", level=0.5, overlay=True))
    assert legend_texts(drawn)[0] == "reached, not known"
    pending = dataset.assign(status=dataset["status"] * 0 + data.codes(data.STATUS, "pending"))
    with pytest.raises(UsageError, match=r"none of the 714 points has a value \(pending 714"):
        draw(pending, lines)


def test_a_level_that_single_points_of_a_refined_map_pass_is_in_no_jump_to_rest():
    """Motions beside rest stay below it, and beside those above none has a value."""
    dataset = data.stability_map(initial=("reached",), nx=20, ny=20)
    rests = is_class(dataset["attractor"], ("equilibrium",)).values
    values = np.where(rests, 0.0, 1.0)
    inside = np.argwhere(~rests[:, :, 0])
    y, x = inside[len(inside) // 2]
    values[max(y - 1, 0) : y + 2, max(x - 1, 0) : x + 2] = np.nan
    values[y, x] = 4.0
    dataset["L_s"] = dataset["L_s"].copy(data=values)
    (note,) = style.notes_on(draw(dataset, figure("map", variable="L_s", level=[0.5, 2.0])))
    assert note.startswith("no line $L_s$ = 2 rad$^{2}$: where it is passed no three neighbours")


def test_a_level_passed_in_one_row_alone_has_no_line_and_no_entry():
    """And levels that have lines, but no room on these, are told by the legend: that is said."""
    dataset = data.stability_map(initial=("reached",), nx=20, ny=20)
    values = np.full((20, 20, 1), np.nan)
    values[:, 0, 0] = np.linspace(0.0, 1.0, 20)
    dataset["L_s"] = dataset["L_s"].copy(data=values)
    asked = figure("map", variable="L_s", level=[0.30001, 0.60001])
    drawn = draw(dataset, asked)
    assert not [text for text in legend_texts(drawn) if "=" in text]
    assert all("as in one row of points alone" in note for note in style.notes_on(drawn))
    values[:, :, 0] = np.linspace(0.0, 1.0, 20)[:, None]
    dataset["L_s"] = dataset["L_s"].copy(data=values)
    assert style.notes_on(draw(dataset, asked)) == []
    dataset["L_s"] = dataset["L_s"].copy(data=values.transpose(1, 0, 2))
    close = figure("map", variable="L_s", level=[0.5 + 0.001 * n for n in range(8)])
    notes = style.notes_on(draw(dataset, close, look=look_of("paper", width=50.0)))
    assert all(note.startswith("L_s = 0.5") for note in notes)
    assert ["told in the legend alone" in note for note in notes] == [True, False]


@pytest.mark.parametrize("overlay", [False, True])
def test_levels_between_the_same_points_of_the_grid_are_told(overlay):
    """Where a value leaps their lines are as exact as the grid, and no more; elsewhere they are."""
    dataset = data.stability_map(initial=("reached",), nx=20, ny=20)
    asked = figure("map", variable="L_s", level=[0.1, 0.3, 0.6], overlay=overlay)
    along = np.linspace(0.0, 1.0, 20)
    for column, told in [(along, []), (np.where(along < 0.5, along**2, 2.0), ["L_s = 0.3, 0.6"])]:
        dataset["L_s"].values[:] = column[:, None, None]
        notes = style.notes_on(draw(dataset, asked))
        assert [note.partition(":")[0] for note in notes] == told
        assert all("between the same points of the grid" in note for note in notes)


@pytest.mark.parametrize("overlay", [False, True])
def test_gaps_of_a_line_where_points_are_undecided_are_told(overlay):
    """They look like dashes, that is like another level; what ends at a side or beside what no
    value is expected of has none."""
    dataset = data.stability_map(initial=("reached",), nx=20, ny=20)
    dataset["L_s"].values[:] = np.linspace(0.0, 1.0, 20)[:, None, None]
    dataset["attractor"].values[:] = data.codes(data.ATTRACTORS, "periodic")
    asked = figure("map", variable="L_s", level=[0.31, 0.71], overlay=overlay)
    assert style.notes_on(draw(dataset, asked)) == []
    between = int(0.31 * 19)  # the levels lie beside it
    dataset["L_s"].values[between : between + 2, 7:9] = np.nan
    assert style.notes_on(draw(dataset, asked)) == []
    undecided = data.codes(data.ATTRACTORS, "undecided")
    dataset["attractor"].values[between : between + 2, 7:9] = undecided
    (note,) = style.notes_on(draw(dataset, asked))
    assert note.startswith("$L_s$ = 0.31") and "its line has gaps" in note
    along = np.linspace(0.0, 1.0, 20)
    dataset["L_s"].values[:] = (along[:, None] + along)[..., None]
    dataset["L_s"].values[4, 8] = np.nan  # alone, across the corner of which the line would lead
    dataset["attractor"].values[:] = data.codes(data.ATTRACTORS, "periodic")
    slanted = figure("map", variable="L_s", level=[12.01 / 19.0, 1.5], overlay=overlay)
    assert style.notes_on(draw(dataset, slanted)) == []
    dataset["attractor"].values[4, 8] = undecided
    (note,) = style.notes_on(draw(dataset, slanted))
    assert note.startswith("$L_s$ = 0.63") and "its line has gaps" in note


def test_islands_that_the_grid_does_not_tell_are_told():
    """On a ridge across the grid each of its points is one."""
    dataset = data.stability_map(initial=("reached",), nx=20, ny=20)
    x, y = np.meshgrid(np.linspace(0.0, 1.0, 20), np.linspace(0.0, 1.0, 20), indexing="ij")
    for sharp, told in ((300.0, True), (3.0, False)):
        dataset["L_s"].values[:] = np.exp(-sharp * (x - y) ** 2)[..., None]
        notes = style.notes_on(draw(dataset, figure("map", variable="L_s", level=[0.6])))
        assert [note for note in notes if " islands of 3 points or fewer" in note] == notes
        assert bool(notes) == told
    lone = dataset.copy(deep=True)  # what lies among points that are not known may be larger
    values = np.full(x.shape, np.nan)
    values[::2, ::2] = (x + y)[::2, ::2]
    lone["L_s"].values[:] = values[..., None]
    notes = style.notes_on(draw(lone, figure("map", variable="L_s", level=[0.6])))
    assert not [note for note in notes if "islands" in note]


@pytest.mark.parametrize(("peak", "told"), [(0.9, True), (0.3, False)])
def test_levels_that_run_round_the_same_point_are_told(peak, told):
    """As where a value jumps at a corner of its plane; one such level alone is a peak."""
    dataset = data.stability_map(initial=("reached",), nx=20, ny=20)
    x, y = np.meshgrid(np.linspace(0.0, 1.0, 20), np.linspace(0.0, 1.0, 20), indexing="ij")
    dataset["L_s"].values[:] = (0.3 * (x + y))[..., None]
    dataset["L_s"].values[0, 0] = peak
    dataset["attractor"].values[:] = data.codes(data.ATTRACTORS, "periodic")
    asked = figure("map", x="Omega", y="N0", variable="L_s", level=[0.2, 0.4, 0.5])
    notes = [note for note in style.notes_on(draw(dataset, asked)) if "run round" in note]
    place = ", ".join(f"{name} = {float(dataset[name][0]):g}" for name in ("Omega", "N0"))
    expected = f"L_s = 0.2, 0.4, 0.5: their lines run round {place}, where it jumps"
    assert [note.startswith(expected) for note in notes] == [True] * told


@pytest.mark.parametrize(("points", "told"), [(20, True), (21, False)])
def test_a_saddle_between_four_points_is_told(points, told):
    """At its height two lines cross, and beside it two part: which, only a point there tells."""
    dataset = data.stability_map(initial=("reached",), nx=points, ny=points)
    along = np.linspace(-1.0, 1.0, points)
    dataset["L_s"].values[:] = (1.0 + along[:, None] * along)[..., None]
    dataset["attractor"].values[:] = data.codes(data.ATTRACTORS, "periodic")
    asked = figure("map", variable="L_s", level=[0.5, 1.0 + 1e-4])
    notes = [note for note in style.notes_on(draw(dataset, asked)) if "saddle" in note]
    assert [note.partition(":")[0] for note in notes] == ["L_s = 1.0001"] * told
    middle = [f"{float(dataset[name][n]):.6g}" for name in ("Omega", "N0") for n in (9, 10)]
    assert all(number in note for number in middle for note in notes)


@pytest.mark.parametrize(("points", "marked"), [(20, False), (60, True)])
def test_undecided_points_are_seen_beneath_lines_on_a_fine_map_of_classes(points, marked):
    """Their cells are as narrow as a line, and lie where one is drawn: at a border."""
    response = data.stability_map(initial=("reached",), nx=points, ny=points)
    response["attractor"].values[:] = data.codes(data.ATTRACTORS, "periodic")
    response["attractor"].values[5, 7] = data.codes(data.ATTRACTORS, "undecided")
    growth = response["Omega"] + 0.0 * response["N0"] - response["Omega"][5]
    status = response["status"].isel(initial=0, drop=True)
    beside = xr.Dataset({"status": status, "growth_rate": growth}, attrs=response.attrs)
    asked = figure("map", x="Omega", y="N0", variable="attractor", level={"growth_rate": 0.01})
    for lines in (True, False):
        settings = asked if lines else figure("map", x="Omega", y="N0", variable="attractor")
        ax = draw({"response": response, "eigenvalues": beside}, settings).axes[0]
        dots = [line.get_xydata().tolist() for line in ax.lines if line.get_marker() == "s"]
        place = [float(response["Omega"][5]), float(response["N0"][7])]
        assert dots == [[place]] * (marked and lines)


def test_a_level_that_no_line_has_is_told_also_where_a_figure_has_no_title(stored):
    asked = figure("map", variable="L_s", level=[5e-4, 2.0])
    data.stability_map().assign_attrs(data.attributes(asked)).to_netcdf("a.nc")
    result = run(plot_command, "a.nc", "--style", "paper", "-o", "a.png")
    assert "no line L_s = 2 rad^2: below everywhere" in result.stderr


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        ({"variable": "L_s"}, "no `level`"),
        ({"variable": "attractor", "level": 0.5}, "classes have no level"),
        ({"variable": "L_s", "level": [*range(9)]}, "9 levels"),
    ],
)
def test_lines_that_cannot_be_drawn_are_refused(settings, message):
    with pytest.raises(UsageError, match=message):
        draw(data.stability_map(), figure("map", overlay=True, **settings))


def with_growth(**coords):
    """Analyses of one case: a map, and a growth rate that changes its sign at N0 = 4 Omega."""
    response = data.stability_map(initial=("reached",), nx=96, ny=97)
    axes = {name: response[name] for name in ("Omega", "N0")} | coords
    modes = axes.get("mode", xr.DataArray(0))
    values = response["N0"] - 4.0 * response["Omega"] + 8.0 * modes + 0.0 * axes["Omega"]
    growth = values.transpose("Omega", "N0", ...).drop_attrs().assign_attrs(units="rad s-1")
    status = response["status"].isel(initial=0, drop=True)
    beside = xr.Dataset({"status": status, "growth_rate": growth}, attrs=response.attrs)
    return {"response": response, "eigenvalues": beside}


def test_counts_of_another_case_have_lines_in_the_panels_that_it_knows_alone():
    known, grid = with_growth(), {"c": [0.1, 0.2]}
    mapped = known["response"].expand_dims(grid).transpose("Omega", "N0", "c", "initial")
    counted = (known["eigenvalues"]["growth_rate"] > 0.0).astype(np.int32).assign_attrs(units="1")
    of_one = known["eigenvalues"].assign(n_unstable=counted).assign_coords(c=0.1)
    under = levels.under_panels(of_one, mapped.assign_coords(c=("c", [0.1, 0.2])), ["c"])
    assert under["n_unstable"].isel(c=0).notnull().all()
    assert under["n_unstable"].isel(c=1).isnull().all()


def on_the_lines(drawn):
    """Corners of all lines on the first panel of a map, shape (n, 2)."""
    every = [segments for one in drawn.findobj(ContourSet) for segments in one.allsegs]
    return np.concatenate([piece for segments in every for piece in segments])


def test_a_short_piece_of_a_dashed_line_shows_its_dashes():
    """In a corner, shorter than one dash, it looked like the solid line of another level."""
    dataset = with_growth()["response"]
    x, y = (dataset[name].values for name in ("Omega", "N0"))
    share = [(of - of[0]) / np.ptp(of) for of in (x, y)]
    sums = share[0][:, None] + share[1]
    heights = np.interp(sums, [0.0, 0.5, 1.0, 2.0], [2.0, 1.0, 1.95, 3.0])
    dataset["L_s"].values[:] = heights[..., None]
    drawn = draw(dataset, figure("map", variable="L_s", x="Omega", y="N0", level=[1.2, 1.95]))
    drawn_lines = drawn.findobj(ContourSet)
    (dashed,) = {one for one in drawn_lines if one.get_linestyle()[0][1] is not None}
    periods = [sum(pattern) for _, pattern in dashed.get_linestyle()]
    assert len(periods) == len(dashed.allsegs) == 2 and periods[1] < periods[0]
    lengths = [
        np.linalg.norm(np.diff(drawn.axes[0].transData.transform(piece), axis=0), axis=1).sum()
        for (piece,) in dashed.allsegs
    ]
    assert lengths[1] * 72.0 / drawn.dpi == pytest.approx(1.6 * periods[1], rel=0.02)
    rows = as_csv(drawn, Path("a.csv")).splitlines()
    assert sum("1.95" in row for row in rows) >= sum(len(piece) for (piece,) in dashed.allsegs)


@pytest.mark.parametrize("variable", ["attractor", "L_s"])
def test_a_map_has_lines_at_a_level_of_another_analysis(variable):
    growth = figure("map", variable=variable, level={"growth_rate": 0.0})
    drawn = draw(with_growth(), growth)
    x, y = on_the_lines(drawn).T
    known = x < 9.5  # where there is an equilibrium
    assert y[known] == pytest.approx(4.0 * x[known])
    assert known.sum() > 50 and "growth rate = 0 rad/s" in legend_texts(drawn)
    assert len(drawn.findobj(QuadMesh)) >= 1
    both = figure("map", variable="L_s", level={"L_s": 1e-3, "growth_rate": [0.0, 99.0]})
    drawn = draw(with_growth(), both)
    keys = [key for key in drawn.legends[0].get_lines() if key.get_linestyle() != "None"]
    looks = {(key.get_linestyle(), key.get_color()) for key in keys}
    assert len(looks) == 2  # each line that is drawn is told from the others
    assert "no line growth rate = 99 rad/s: below everywhere" in drawn.get_suptitle()


def test_of_several_modes_a_map_has_the_line_of_the_one_that_is_selected():
    modes = {"mode": xr.DataArray([0, 1], dims="mode")}
    growth = {"variable": "attractor", "level": {"growth_rate": 0.0}}
    with pytest.raises(UsageError, match="several values at a point"):
        draw(with_growth(**modes), figure("map", **growth))
    drawn = draw(with_growth(**modes), figure("map", select={"mode": 1}, **growth))
    x, y = on_the_lines(drawn).T
    assert (y + 8.0)[x < 9.5] == pytest.approx((4.0 * x)[x < 9.5])


def test_a_map_has_lines_of_another_case_on_points_of_its_own(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    wanted = figure("map", variable="attractor", level={"fine:growth_rate": 0.0})
    response = with_growth()["response"]
    with pytest.raises(UsageError, match=r"runs/fine\.nc is not there\nnext: fiv run fine\.toml"):
        draw(response, wanted)
    fine = with_growth()["eigenvalues"].isel(Omega=slice(None, None, 2))
    (tmp_path / "runs").mkdir()
    fine.to_netcdf("runs/fine.nc")
    drawn = draw(response, wanted)
    x, y = on_the_lines(drawn).T
    assert y == pytest.approx(4.0 * x)
    assert "growth rate = 0 rad/s" in legend_texts(drawn)
    called = {"fine:growth_rate": "growth of sliding"}
    drawn = draw(response, figure("map", **wanted.settings, words=called))
    assert "growth of sliding = 0 rad/s" in legend_texts(drawn)
    both = {"fine:growth_rate": 0.0, "growth_rate": 1.0}
    drawn = draw(with_growth(), figure("map", variable="attractor", level=both))
    assert {*legend_texts(drawn)} >= {"fine:growth rate = 0 rad/s", "growth rate = 1 rad/s"}
    with pytest.raises(UsageError, match=r"no variable of runs/fine\.nc"):
        draw(response, figure("map", variable="attractor", level={"fine:stable": 0.0}))
    several = xr.concat([fine.expand_dims(initial=[n], axis=2) for n in "ab"], "initial")
    several.to_netcdf("runs/starts.nc")  # of starts that are others than those of the map
    with pytest.raises(UsageError, match="choose from initial with `select`"):
        draw(response, figure("map", variable="attractor", level={"starts:growth_rate": 0.0}))


def test_a_line_of_a_variable_beside_section_values_is_drawn():
    """Counts of these stay whole numbers."""
    dataset = data.stability_map(initial=("reached",))
    counts = dataset["status"].copy(data=np.ones(dataset["status"].shape, np.int32))
    counts.attrs = {"sample_dimension": "section_obs"}
    values = ("section_obs", np.zeros(counts.size), {"units": "rad"})
    full = dataset.assign(section_row_size=counts, section_value=values)
    full = full.assign(phi_max=full["L_s"].fillna(0.0))
    level = {"phi_max": float(full["L_s"].mean())}
    drawn = draw(full, figure("map", variable="attractor", level=level))
    assert drawn.findobj(ContourSet)


def test_a_line_lies_in_the_panel_of_all_its_parameters_that_advance_together(
    tmp_path, monkeypatch
):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "runs").mkdir()
    response, fine = with_growth().values()
    mapped = xr.concat([response.assign_coords(c=own) for own in (0.1, 0.2)], "c")
    mapped = mapped.assign_coords(k=("c", [7.0, 8.0]))
    drawn = figure("map", x="Omega", y="N0", variable="attractor", level={"fine:growth_rate": 0.0})
    for k, lines in ((7.0, [True, False]), (5.0, [False, False])):
        fine.assign_coords(c=0.1, k=k).to_netcdf("runs/fine.nc", mode="w")
        panels = [ax for ax in draw(mapped, drawn).axes if ax.findobj(QuadMesh)]
        assert [bool(ax.findobj(ContourSet)) for ax in panels] == lines


def test_a_line_of_one_law_or_parameter_lies_in_its_panel_alone(tmp_path, monkeypatch):
    """Whether another case varies it, or holds it fixed; in no panel of another value."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "runs").mkdir()
    analyses, level = with_growth(), {"fine:growth_rate": 0.0}
    for dim, values in (("friction", ["coulomb", "stribeck"]), ("c", [0.1, 0.2])):
        mapped = xr.concat([analyses["response"].assign_coords({dim: own}) for own in values], dim)
        fine = analyses["eigenvalues"]
        fixed = fine.assign_attrs(law=values[0]) if dim == "friction" else fine.assign_coords(c=0.1)
        varied = fine.expand_dims({dim: values[:1]})
        other = fine.assign_attrs(law="none") if dim == "friction" else fine.assign_coords(c=0.3)
        for given, lines in ((fixed, [True, False]), (varied, [True, False]), (other, [False] * 2)):
            given.to_netcdf("runs/fine.nc", mode="w")
            drawn = draw(
                mapped, figure("map", x="Omega", y="N0", variable="attractor", level=level)
            )
            panels = [ax for ax in drawn.axes if ax.findobj(QuadMesh)]
            assert [bool(ax.findobj(ContourSet)) for ax in panels] == lines


@pytest.mark.parametrize("what", ["N0", 0.0])
def test_a_line_of_a_case_of_other_parameters_is_told(tmp_path, monkeypatch, what):
    """Over a map at N = 5 N it lies where it lies at 10 N: nothing else in the figure says so."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "runs").mkdir()
    analyses = with_growth()
    mapped, lined = (
        analyses[kind].assign_coords(N=((), load, {"units": "N"}), v=1.0)
        for kind, load in (("response", 5.0), ("eigenvalues", 10.0))
    )
    if what == "N0":
        lined = lined.isel(N0=[0]).rename(N0="crossing", growth_rate="critical_value")
        lined["critical_value"].attrs["long_name"] = "critical value"
    name = "growth_rate" if what == 0.0 else "critical_value"
    asked = figure("map", x="Omega", y="N0", variable="attractor", level={f"fine:{name}": what})
    for other, said in (
        (lined, f"fine:{name}: its line is that at N = 10 N, over a map at N = 5 N; for"),
        (lined.assign_coords(N=5.0), ""),
        (lined.assign_coords(N=5.0).assign_attrs(law="none"), "is that at none, over a map at"),
    ):
        other.to_netcdf("runs/fine.nc", mode="w")
        told = [note for note in style.notes_on(draw(mapped, asked)) if "its line is" in note]
        assert len(told) == bool(said) and all(said in note for note in told)


@pytest.mark.parametrize("turned", [False, True])
def test_a_map_has_the_line_where_an_axis_has_the_value_that_another_case_found(
    tmp_path, monkeypatch, turned
):
    """As its case found it, on places of its own, each crossing; ranges are those of the map."""
    monkeypatch.chdir(tmp_path)
    speeds = np.linspace(0.0, 12.0, 40)
    values = np.stack([4.0 * speeds, 90.0 - speeds], axis=1)
    modes = np.tile([0, 1], (40, 1))
    values[:5], modes[:5] = values[:5, ::-1], modes[:5, ::-1]  # whatever their numbers
    crit = xr.Dataset(
        {
            "critical_value": (
                ("Omega", "crossing"),
                values,
                {"long_name": "critical value of N0"},
            ),
            "crossing_mode": (("Omega", "crossing"), modes),
            "status": data.statuses(("Omega",), np.full(40, "ok")),
        },
        coords={"Omega": ("Omega", speeds, {"units": "rad s-1"})},
        attrs=with_growth()["response"].attrs,
    )
    (tmp_path / "runs").mkdir()
    crit.to_netcdf("runs/crit.nc")
    response = with_growth()["response"]
    response["attractor"].values[:] = data.codes(data.ATTRACTORS, "periodic")  # none is marked
    axes = {"x": "N0", "y": "Omega"} if turned else {"x": "Omega", "y": "N0"}
    drawn = draw(response, figure("map", **axes, level={"crit:critical_value": "N0"}))
    plain = draw(response, figure("map", **axes))
    for ax, without in zip(drawn.axes, plain.axes, strict=True):
        assert (ax.get_xlim(), ax.get_ylim()) == (without.get_xlim(), without.get_ylim())
        rising = next(line for line in ax.lines if len(line.get_xdata()) == 40)
        speed, value = np.array(rising.get_data())[:: -1 if turned else 1]
        assert value == pytest.approx(4.0 * speed)
    assert "critical value of $N_{0}$" in legend_texts(drawn)
    words = np.where(np.arange(40) == 0, "undecided_in_part", "none")
    reasons = data.flags(("Omega",), words, ("none", "undecided_in_part"))
    crit.assign(reason=reasons).to_netcdf("runs/open.nc")
    left = draw(response, figure("map", **axes, level={"open:critical_value": "N0"}))
    assert 39 in {len(line.get_xdata()) for line in left.axes[0].lines}
    assert [note for note in style.notes_on(left) if "not at 1 of 40 places" in note]
    rows = as_csv(drawn, Path("a.csv")).splitlines()[1:]  # though the rest of the figure is a plane
    assert any(",critical value of N_0," in row for row in rows)
    for first, count in ((0, 1), (1, 0)):  # the mode that turns unstable where all were stable
        growing = {
            "unstable_below": 2 * (modes != first),
            "unstable_above": 2 + 2 * (modes != first),
        }
        beyond = crit.assign({name: (("Omega", "crossing"), of) for name, of in growing.items()})
        beyond.to_netcdf(f"runs/beyond-{first}.nc")
        line = {f"beyond-{first}:critical_value": "N0"}
        borders = draw(response, figure("map", **axes, level=line))
        assert len(borders.axes[0].lines) == count
    low = crit.assign(critical_value=crit["critical_value"].copy(data=values - 500.0))
    low.to_netcdf("runs/low.nc")
    further = [crit.assign_coords(mu_k=0.23 + 0.1 * n).expand_dims("mu_k") for n in (0, 1)]
    xr.concat(further, "mu_k").to_netcdf("runs/further.nc")  # of which the map has one
    at = {n: response.assign_coords(mu_k=n) for n in (0.33, 0.4)}
    line = figure("map", **axes, level={"further:critical_value": "N0"})
    assert len(draw(at[0.33], line).axes[0].lines) == len(drawn.axes[0].lines)
    with pytest.raises(UsageError, match=r"on this map is that at mu_k = 0\.4: not in this data"):
        draw(at[0.4], line)
    with pytest.raises(UsageError, match="choose from mu_k with `select`"):
        draw(response, line)
    drawn = draw(response, figure("map", level={"low:critical_value": "N0"}))
    one = crit.isel(Omega=slice(20, 21), crossing=slice(0, 1)).assign(
        critical_value=crit["critical_value"][20:21, :1]
    )
    one.to_netcdf("runs/one.nc")
    (place,) = draw(response, figure("map", level={"one:critical_value": "N0"})).axes[0].lines
    assert (place.get_marker(), *place.get_xydata()[0]) == ("D", speeds[20], values[20, 0])
    assert "no line of the critical value of $N_{0}$: no value within" in drawn.get_suptitle()
    with pytest.raises(UsageError, match="no axis of this map 'mu_k'"):
        draw(response, figure("map", level={"crit:critical_value": "mu_k"}))
    with pytest.raises(UsageError, match="needs its values along N0, and it varies along Omega"):
        draw(response, figure("map", level={"crit:critical_value": "Omega"}))


def test_what_is_taken_has_lines_of_what_it_is_not_taken_of():
    take = {"what": "share", "of": "periodic", "over": ["initial"]}
    wanted = figure("map", variable="attractor", take=take, level={"share": 0.5, "growth_rate": 0})
    told = legend_texts(draw(with_growth(), wanted))
    assert {"share = 0.5", "growth rate = 0 rad/s"} <= {*told}


@pytest.mark.parametrize(
    ("level", "message"),
    [
        ({"stable": 0.5}, "stable: no variable of this dataset"),
        ({"growth_rate": 0.0, "L_s": [*range(1, 9)]}, "9 levels in one figure"),
        ({"attractor": 0.5}, "classes have no level\ndraw the level of a number"),
    ],
)
def test_lines_that_a_map_cannot_have_are_refused(level, message):
    with pytest.raises(UsageError, match=message):
        draw(with_growth(), figure("map", variable="L_s", level=level))
    with pytest.raises(UsageError, match="overlay shows the lines of the variable that is mapped"):
        draw(with_growth(), figure("map", variable="L_s", level={"growth_rate": 0}, overlay=True))


def test_a_map_needs_two_axes():
    one_start = data.bifurcation().isel(initial=[0])[["status", "attractor", "L_s"]]
    with pytest.raises(UsageError, match="two axes"):
        draw(one_start, figure("map"))


# --- basin --------------------------------------------------------------------------------------
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
    assert "equilibrium 3 of 15" in drawn.axes[0].get_title()
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
    counts = [int(one.rpartition(" of ")[0].rpartition(" ")[2]) for one in (long, short)]
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


def test_a_motion_lies_over_a_single_basin_whatever_its_parameters():
    of_cycle = _motion_in_x(2.0).assign_attrs(steady_state="unstable cycle")
    for one, word in ((_motion_in_x(2.0), "motion"), (of_cycle, "unstable cycle")):
        (ax,) = draw([("", data.basin(speeds=(1.0,))), ("", one)], figure("basin")).axes
        assert [*_lines_over(ax)] == [word]


def test_cycles_of_two_files_are_called_by_what_they_are_where_that_tells_them_apart():
    layers = [(name, _motion_in_x().assign_attrs(steady_state=f"{name} cycle", called=""))
              for name in ("unstable", "stable")]  # fmt: skip
    (ax,) = draw([("", data.basin(speeds=(1.0,))), *layers], figure("basin")).axes
    assert {*_lines_over(ax)} == {"unstable cycle", "stable cycle"}
    layers[1] = ("other", layers[0][1])
    (ax,) = draw([("", data.basin(speeds=(1.0,))), *layers], figure("basin")).axes
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


def test_shares_of_a_lattice_of_starts_have_no_standard_error():
    lattice = data.basin().assign_attrs(starts_json=json.dumps({"any": "grid"}))
    drawn = draw(lattice, figure("basin"))
    assert not [text for text in drawn.findobj(Text) if re.search("±|error", text.get_text())]
    reached = class_names(lattice["attractor"][0])
    assert f"periodic {(reached == 'periodic').sum()} of 200" in drawn.axes[0].get_title()


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
    with pytest.raises(UsageError, match="no random starts here"):
        CliRunner().invoke(
            show_command, [str(tmp_path / "b.nc"), "--csv", "shares"], catch_exceptions=False
        )


@pytest.mark.parametrize(("kind", "told"), [("random", 1), ("table", 0)])
def test_show_tells_the_shares_of_random_starts_with_their_standard_errors(kind, told):
    starts = json.dumps({"any": kind})
    dataset = data.basin(speeds=(1.0, 2.0, 9.0)).assign_attrs(starts_json=starts)
    printed = [line for line in summary_lines(summarise({"": dataset})) if "shares" in line]
    assert len(printed) == 2 * told
    if told:
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


# --- history, phase, spectrum ------------------------------------------------------------------
def test_a_history_has_every_sample_and_shades_every_contact_state():
    dataset = data.history()
    drawn = draw(dataset, figure("history"))
    assert len(drawn.axes) == 4
    top = drawn.axes[0]
    x, y = top.lines[0].get_data()
    samples = np.isin(x, dataset["time"])
    assert np.array_equal(y[samples], dataset["phi"].sel(initial="far"))
    transitions = np.count_nonzero(np.diff(dataset["contact_state"].sel(initial="far")))
    assert len(top.patches) == transitions + 1
    assert top.get_ylabel() == r"$\varphi$ (rad)"
    assert drawn.axes[2].get_xlabel() == "time $t$ (s)"
    assert legend_texts(drawn) == [SLIP_PLUS, SLIP_MINUS, "stick"]


def without_events(dataset):
    return dataset.drop_vars([name for name in dataset if name.startswith("event_")])


def with_ledger():
    dataset = without_events(data.history())
    dataset["event_row_size"] = ("initial", [3, 1], {"sample_dimension": "event_obs"})
    dataset["event_time"] = ("event_obs", [1.0, 1.001, 2.5, 3.0], {"units": "s"})
    dataset["event_contact"] = ("event_obs", [1, 1, 1, 1], {"units": "1"})
    before, after = ["slip+", "stick", "slip+", "slip-"], ["stick", "slip+", "stick", "slip+"]
    for name, states in (("event_from", before), ("event_to", after)):
        dataset[name] = data.flags("event_obs", states, data.CONTACT_STATES)
    return dataset


def test_shades_follow_the_event_ledger_where_there_is_one():
    dataset = with_ledger()
    drawn = draw(dataset, figure("history"))
    far, near = (
        [(p.get_x(), p.get_x() + p.get_width()) for p in ax.patches] for ax in drawn.axes[:2]
    )
    end = float(dataset["time"][-1])
    assert np.ravel(far) == pytest.approx([0, 1, 1, 1.001, 1.001, 2.5, 2.5, end])
    assert np.ravel(near) == pytest.approx([0, 3, 3, end])
    assert legend_texts(drawn) == [SLIP_PLUS, SLIP_MINUS, "stick"]


def test_motions_without_a_known_sample_are_not_drawn():
    dataset = with_ledger()
    with pytest.raises(EmptyFigureError, match="window from 90 to 91 s: nothing to draw"):
        draw(dataset, figure("phase", window=[90.0, 91.0]))
    dataset["phi"][1] = np.nan
    assert not draw(dataset, figure("history")).axes[1].patches
    dataset["phi"][:] = np.nan
    with pytest.raises(EmptyFigureError, match="nothing to draw"):
        draw(dataset, figure("history"))


def test_no_line_goes_back_along_an_axis_that_others_advance_with():
    """Two values of the damping at one of the ratio: neither is joined to the other."""
    for dataset, name in ((data.crossings(), "critical_value"), (data.bifurcation(), "L_s")):
        axis = next(iter(dataset[name].dims))
        values = dataset[axis].values.copy()
        values[1::2] = values[:-1:2]
        back = dataset.assign_coords({axis: (axis, values, dataset[axis].attrs)})
        (ax,) = draw(back, figure("curve", variable=name, x=axis)).axes
        steps = [np.diff(line.get_xdata()) for line in ax.lines if line.get_linestyle() != "None"]
        assert steps and not any((along <= 0.0).any() for along in steps)


def test_spectra_none_of_which_is_known_are_not_drawn():
    dataset = data.spectra()
    dataset["amplitude"][:] = np.nan
    with pytest.raises(EmptyFigureError, match="amplitude: nothing to draw"):
        draw(dataset, figure("spectrum"))


def test_a_history_that_ended_early_is_drawn_as_far_as_it_goes():
    dataset = data.history()
    for name in ("phi", "phi_dot", "theta", "theta_dot"):
        dataset[name][1, 300:] = np.nan
    ended = draw(dataset, figure("history")).axes[1]
    assert np.isin(ended.lines[0].get_xdata(), dataset["time"]).sum() == 300
    assert max(p.get_x() + p.get_width() for p in ended.patches) < 3.0


@pytest.mark.parametrize("kind", ["history", "phase"])
def test_of_several_contacts_the_legend_says_which_one_is_shown(kind):
    dataset = data.history(labels=("far",))
    dataset["contact_state"] = dataset["contact_state"].expand_dims(contact=[1, 2], axis=1)
    for asked in ({"contact": 2}, {"select": {"contact": 2}}):
        drawn = draw(dataset, figure(kind, variable="phi", **asked))
        assert drawn.legends[0].get_title().get_text() == "colours: contact 2"
    both = draw(dataset, figure(kind, variable="phi", contact=[2, 1]))
    told = [note for note in style.notes_on(both) if note.startswith("contact 1: where it sticks")]
    assert len(told) == (kind == "history")
    first = draw(dataset.drop_vars("event_contact"), figure(kind, variable="phi"))
    assert first.legends[0].get_title().get_text() == "colours: contact 1"
    with pytest.raises(UsageError, match="contact = 3: there are 1, 2"):
        draw(dataset, figure(kind, variable="phi", contact=3))
    alone = draw(data.history(labels=("far",)), figure(kind, variable="phi"))
    assert alone.legends[0].get_title().get_text() == ""


def test_a_side_of_one_sample_tells_nothing_of_a_corner():
    """Another contact's event lies just before: the slip up to the stick has one sample."""
    time, values = np.arange(8.0), np.array([0.0, 0.05, 0.1, 0.13, 0.3, 0.3, 0.3, 0.3])
    events = (motion.Event(2.5, 2, "slip+", "stick"), motion.Event(3.7, 1, "slip+", "stick"))
    one = motion.Motion("", time, xr.Dataset(), events)
    sides = [sampling.led_to(one.instants, time, values, side) for side in (-1, 1)]
    assert one._met(values, *sides, 2)[1] == pytest.approx(0.3)
    again = motion.Event(3.8, 1, "stick", "stick")
    twice = motion.Motion("", time, xr.Dataset(), (events[1], again))  # no sample between
    sides = [sampling.led_to(twice.instants, time, values, side) for side in (-1, 1)]
    assert twice._met(values, *sides, 2) == pytest.approx([0.3, 0.3])
    line = motion.Motion(
        "",
        time,
        xr.Dataset(),
        (motion.Event(2.1, 1, "slip+", "stick"), motion.Event(2.9, 2, "slip+", "stick")),
    )
    sides = [sampling.led_to(line.instants, time, time, side) for side in (-1, 1)]
    assert line._met(time, *sides, 2) == pytest.approx([2.1, 2.9])


@pytest.mark.parametrize("kind", ["history", "phase"])
def test_a_motion_that_ended_before_its_time_has_a_mark_where_it_did(kind):
    dataset = data.history(labels=("far",))
    whole = draw(dataset, figure(kind, variable="phi")).legends[0]
    assert "contact lost" not in [text.get_text() for text in whole.get_texts()]
    lost = np.full(dataset["status"].shape, "contact_lost", object)
    dataset["reason"] = data.flags(dataset["status"].dims, lost, [*REASON.codes])
    drawn = draw(dataset, figure(kind, variable="phi"))
    assert "contact lost" in [text.get_text() for text in drawn.legends[0].get_texts()]
    (end,) = [line for line in drawn.axes[0].lines if line.get_marker() == "X"]
    last = dataset.squeeze().isel(time=-1)
    assert end.get_xdata()[0] == (last["time"] if kind == "history" else last["phi"])
    part = draw(dataset, figure(kind, variable="phi", window=(0.0, 0.1))).legends[0]
    assert "contact lost" not in [text.get_text() for text in part.get_texts()]


@pytest.mark.parametrize("kind", ["history", "phase"])
def test_sticks_of_other_contacts_are_marked_where_no_panel_is_about_one(kind):
    dataset = data.history(labels=("far",))
    states = dataset["contact_state"].expand_dims(contact=[1, 2], axis=1).copy()
    held = [n for n, word in flag_names(states.attrs).items() if word == "stick"]
    states[:, 1] = held[0]
    dataset["contact_state"] = states
    told = {}
    for asked in (None, 1, 2, (1, 2)):
        settings = {} if asked is None else {"contact": [*np.atleast_1d(asked).tolist()]}
        (legend,) = draw(dataset, figure(kind, variable="phi", **settings)).legends
        told[asked] = [text.get_text() for text in legend.get_texts()]
    assert "contact 2 sticks" in told[None] and "contact 1 sticks" not in told[None]
    assert told[1, 2] == told[None]
    assert told[1] == told[None]
    assert "contact 1 sticks" in told[2] and "contact 2 sticks" not in told[2]
    if kind == "phase":  # files of other numbers of contacts
        three = dataset.reindex(contact=[1, 2, 3]).assign(
            contact_state=states.isel(contact=[0, 1, 1]).assign_coords(contact=[1, 2, 3])
        )
        one = data.history(labels=("near",))
        for files in ([one, dataset], [dataset, three], [three, dataset]):
            shown = draw([(f"{n}", part) for n, part in enumerate(files)], figure(kind))
            words_ = [text.get_text() for text in shown.legends[0].get_texts()]
            assert "contact 2 sticks" in words_
            assert ("contact 3 sticks" in words_) == any(one is three for one in files)
    (ax,) = draw(dataset, figure(kind, variable="phi")).axes
    bars = [patch.get_extents().height / ax.bbox.height for patch in ax.patches]
    assert kind == "phase" or min(bars) < 0.05 < 0.9 < max(bars)  # across, one is seen


@pytest.mark.parametrize("kind", ["map", "curve"])
def test_of_several_contacts_a_figure_says_which_one_is_selected(kind):
    both = data.stability_map().rename(L_s="stick_fraction")
    both["stick_fraction"] = both["stick_fraction"].expand_dims(contact=[1, 2], axis=-1)
    asked = {"variable": "stick_fraction"} | ({"select": {"N0": 10.0}} if kind == "curve" else {})
    every, second = (
        draw(both, figure(kind, **asked | {"select": asked.get("select", {}) | chosen}))
        for chosen in ({}, {"contact": 2})
    )
    one = draw(both.isel(contact=[1]), figure(kind, **asked))  # of the model itself
    told = [drawn.get_suptitle().count("contact = 2") for drawn in (every, second, one)]
    assert told == [0, 1, 0]
    with pytest.raises(UsageError, match="contact = 7: not in this dataset\ncontact: 1, 2"):
        draw(both, figure(kind, variable="stick_fraction", select={"contact": 7}))


def of_two_contacts():
    """A motion on two contacts: 6 N of friction at the first, -1 N at the second."""
    dataset = data.history(labels=("far",))
    states = dataset["contact_state"].expand_dims(contact=[1, 2], axis=1)
    forces = dataset["F_T"].expand_dims(contact=[1, 2], axis=1).copy()
    forces[:, 1] = -1.0
    return dataset.assign(contact_state=states, F_T=forces)


FORCES = {"$F_T$ of contact 1 (N)": 6.0, "$F_T$ of contact 2 (N)": -1.0}


@pytest.mark.parametrize("asked", [{}, {"contact": [1, 2]}, {"contact": 2}, {"contact": [1]}])
def test_a_force_is_drawn_of_every_contact_that_is_not_left_out_each_by_its_name(asked):
    drawn = draw(of_two_contacts(), figure("history", variable=["phi", "F_T"], **asked))
    state, *of_contacts = drawn.axes
    found = {ax.get_ylabel(): ax.lines[0].get_ydata()[0] for ax in of_contacts}
    wanted = np.atleast_1d(asked.get("contact", [1, 2]))
    assert found == {word: force for word, force in FORCES.items() if int(word[-5]) in wanted}
    assert state.get_ylabel() == r"$\varphi$ (rad)"


@pytest.mark.parametrize("contact", [1, 2])
def test_a_loop_says_of_which_contact_its_force_is(contact):
    loop = figure("phase", x="phi", y="F_T", contact=contact)
    assert draw(of_two_contacts(), loop).axes[0].get_ylabel() == [*FORCES][contact - 1]
    lines = figure("spectrum", variable="F_T", select={"contact": contact})
    assert [*FORCES][contact - 1] in draw(of_two_contacts(), lines).axes[0].get_ylabel()


def test_what_a_law_holds_in_stick_is_named_in_its_loop():
    dataset = data.history(labels=("far",))
    dataset = dataset.rename(phi="slip", phi_dot="slip_dot")
    assert "held in stick" not in legend_texts(draw(dataset, figure("phase", y="F_T")))
    held = dataset.assign(static_capacity=0.4)
    drawn = draw(held, figure("phase", x="slip_dot", y="F_T"))
    assert marks(drawn.axes[0], "_held in stick").tolist() == [[0.0, -0.4], [0.0, 0.4]]
    assert "held in stick" in legend_texts(drawn)


def test_other_variables_of_a_history_can_be_asked_for():
    drawn = draw(data.history(), figure("history", variable=["F_T"], select={"initial": "far"}))
    assert drawn.axes[0].get_ylabel() == "$F_T$ (N)"
    with pytest.raises(UsageError, match="no variable over time"):
        draw(data.history(), figure("history", variable="status"))


def test_a_phase_portrait_is_coloured_by_contact_state_without_gaps():
    dataset = data.history(labels=("far",))
    drawn = draw(dataset, figure("phase"))
    (ax,) = drawn.axes
    assert (ax.get_xlabel(), ax.get_ylabel()) == (r"$\varphi$ (rad)", r"$\dot{\varphi}$ (rad/s)")
    collections = [c for c in ax.collections if isinstance(c, LineCollection)]
    segments = [segment for c in collections for segment in c.get_segments()]
    begins, ends = ({tuple(np.round(s[at], 12)) for s in segments} for at in (0, -1))
    assert len(begins ^ ends) == 2  # where the motion begins and ends; else one meets the next
    assert len({tuple(c.get_colors()[0]) for c in collections}) == 3
    assert legend_texts(drawn) == [SLIP_PLUS, SLIP_MINUS, "stick", "start"]


def sawtooth(sample):
    """A mass that is braked and driven in turn, from 0.5 s on each second: F_T is 3 N or -1 N."""
    time = np.arange(0.0, 5.0, sample)
    kicks = np.arange(0.5, 5.0)
    driven = np.searchsorted(kicks, time) % 2 == 1
    knots = np.append(0.0, kicks)
    pushes = np.where(np.arange(knots.size) % 2 == 1, 3.0, -1.0)
    speeds = np.append(0.0, np.cumsum(pushes[:-1] * np.diff(knots)))
    piece = np.searchsorted(kicks, time)
    since = time - knots[piece]
    ways = np.append(
        0.0, np.cumsum(speeds[:-1] * np.diff(knots) + 0.5 * pushes[:-1] * np.diff(knots) ** 2)
    )
    dataset = without_events(data.history(labels=("far",))).isel(time=slice(len(time)))
    states = np.where(driven, "slip+", "slip-")[None]
    found = dataset.assign_coords(time=("time", time)).assign(
        phi=(
            ("initial", "time"),
            (ways[piece] + speeds[piece] * since + 0.5 * pushes[piece] * since**2)[None],
        ),
        phi_dot=(("initial", "time"), (speeds[piece] + pushes[piece] * since)[None]),
        theta=(("initial", "time"), 0.0 * since[None]),
        theta_dot=(("initial", "time"), 0.0 * since[None]),
        F_T=(("initial", "time"), pushes[piece][None], {"units": "N"}),
        contact_state=data.flags(("initial", "time"), states, data.CONTACT_STATES),
        **data.ledger(time, states),
    )
    found["event_time"][:] = kicks
    return found, np.column_stack([ways[1:], speeds[1:]])


@pytest.mark.parametrize("sample", [0.09, 0.31])
def test_motions_are_drawn_through_the_instants_of_their_events(sample):
    """Jumps of the friction force stand upright there, and a phase portrait has its corners."""
    dataset, corners = sawtooth(sample)
    (ax,) = draw(dataset, figure("history", variable="F_T")).axes
    time, force = ax.lines[0].get_data()
    jumps = np.flatnonzero(np.diff(force))
    np.testing.assert_array_equal(time[jumps], time[jumps + 1])
    np.testing.assert_array_equal(time[jumps], np.arange(0.5, 5.0))
    (ax,) = draw(dataset, figure("phase")).axes
    segments = [s for c in ax.collections for s in c.get_segments()]
    ends = np.array(sorted((s[-1] for s in segments if len(s) > 2), key=lambda p: p[0]))
    for corner in corners:
        np.testing.assert_allclose(np.min(np.abs(ends - corner).max(axis=1)), 0.0, atol=1e-12)


def test_a_jump_in_a_phase_portrait_is_of_neither_state_beside_it():
    """No slip has a force that it never has, and the head lies on no jump."""
    found, _ = sawtooth(0.09)
    (ax,) = draw(found, figure("phase", x="phi_dot", y="F_T")).axes
    parts = {str(c.get_label()): np.concatenate(c.get_segments()) for c in ax.collections}
    jumps = parts.pop("_jump")
    assert {*map(tuple, np.ptp(jumps.reshape(-1, 2, 2), axis=1))} == {(0.0, 4.0)}
    assert {name: {*points[:, 1]} for name, points in parts.items()} == {
        "slip+": {3.0},
        "slip-": {-1.0},
    }
    assert ax.texts[0].xyann[1] == ax.texts[0].xy[1]
    assert "jump" in legend_texts(ax.figure)
    smooth = draw(found, figure("phase"))
    assert "jump" not in legend_texts(smooth)


def test_motions_of_which_one_is_coarse_share_a_phase_portrait():
    coarse, fine = (sawtooth(sample)[0] for sample in (0.8, 0.09))
    for layers in ([("a", coarse), ("b", fine)], [("b", fine), ("a", coarse)]):
        drawn = draw(layers, figure("phase", x="phi_dot", y="F_T"))
        assert {"jump", SLIP_PLUS, SLIP_MINUS} <= {*legend_texts(drawn)}


def test_what_no_line_would_show_in_a_phase_portrait_is_a_dot():
    """One that lasts for a sample of hundreds."""
    found = data.history(labels=("far",))
    time = found["time"].values
    states = np.where(np.arange(time.size) == time.size // 2, "stick", "slip+")[None]
    for name in ("phi", "theta"):
        found[name] = found[name].copy(data=(time / time[-1])[None])
        found[f"{name}_dot"] = found[name].copy(data=np.full_like(time, 1.0 / time[-1])[None])
    found["contact_state"] = data.flags(("initial", "time"), states, data.CONTACT_STATES)
    found = found.drop_dims("event_obs").assign(data.ledger(time, states))
    drawn = draw(found, figure("phase", x="phi", y="theta"))
    (dot,) = (line for line in drawn.axes[0].lines if line.get_marker() == ".")
    assert dot.get_label().endswith("stick") and dot.get_xdata() == pytest.approx(0.5, abs=0.01)
    (legend,) = drawn.legends
    keys = {t.get_text(): h for t, h in zip(legend.get_texts(), legend.legend_handles, strict=True)}
    assert [keys[word].get_marker() for word in ("stick", SLIP_PLUS)] == [".", "None"]


def test_a_corner_without_a_sample_behind_it_is_as_what_is_before_leads_there():
    """Where a second event comes before the next sample."""
    time = np.arange(0.0, 2.05, 0.1)
    speed = np.minimum(time / 0.95, 1.0)
    found = xr.Dataset({"x": ("time", time), "x_dot": ("time", speed)}, {"time": time})
    events = (motion.Event(0.95, 1, "slip+", "stick"), motion.Event(0.97, 2, "slip+", "slip-"))
    drawn = motion.Motion("", time, found, events).drawn("x_dot", speed)
    np.testing.assert_allclose(drawn[10:14], 1.0, atol=1e-12)


def test_a_phase_portrait_points_in_the_direction_of_its_motion():
    found = without_events(data.history(labels=("far",)))
    (ax,) = draw(found, figure("phase")).axes
    (arrow,) = ax.texts
    (x, y), (next_x, _) = arrow.xyann, arrow.xy
    assert (next_x - x) * y > 0.0  # phi grows where its rate is above zero
    corners = np.concatenate([c.get_segments() for c in ax.collections if len(c.get_segments())])
    nearest = np.abs((corners.reshape(-1, 2) - arrow.xy) / np.ptp(corners, axis=(0, 1))).max(axis=1)
    assert nearest.min() < 0.01
    begun = found["time"] < 1.0
    resting = found.assign({name: found[name].where(begun, 0.0) for name in ("phi", "phi_dot")})
    (arrow,) = draw(resting, figure("phase")).axes[0].texts  # not where it rests
    assert np.abs(arrow.xyann / np.abs(corners).max(axis=(0, 1))).max() > 0.1


def test_motions_of_several_files_share_a_phase_portrait():
    """Each with a mark of its own, by the name of its file."""
    layers = [
        (name, data.history(labels=(label,))) for name, label in (("a", "far"), ("b", "near"))
    ]
    (ax,) = draw(layers, figure("phase")).axes
    assert [text for text in legend_texts(ax) if text.startswith("start: ")] == [
        "start: a",
        "start: b",
    ]
    unnamed = [(name, one.assign_attrs(called="")) for name, one in layers]
    (ax,) = draw(unnamed, figure("phase")).axes
    assert {"start: far", "start: near"} <= {*legend_texts(ax)}
    dashes = {
        line.get_linestyle()
        for line in ax.figure.legends[0].get_lines()
        if line.get_marker() in "os"
    }
    assert len(dashes) == 2
    settled = unnamed[0][1].assign_attrs(steady_state="unstable cycle", point="x, settled")
    for called, told in (("", "unstable cycle"), ("mine", "mine")):
        cycle = ("a", settled.assign_attrs(called=called))
        assert told in legend_texts(draw([cycle, unnamed[1]], figure("phase")).axes[0])
    reaches = [np.ptp(line.get_xydata()[:, 0]) for line in ax.lines]
    assert len(ax.texts) == 2 and len(reaches) >= 2
    with pytest.raises(UsageError, match="theta_dot: no variable over time"):
        lacking = data.history().drop_vars("theta_dot")
        draw([layers[0], ("c", lacking)], figure("phase", x="phi", y="theta_dot"))


def test_histories_that_have_no_room_side_by_side_stand_below():
    """Each motion with all its variables; empty places stay empty."""
    found = without_events(data.history()).isel(initial=[0, 1, 0])
    found["initial"] = ["start-0", "start-1", "start-2"]
    drawn = draw(found, figure("history", variable=["phi", "theta"]), look=look_of("paper", 84.0))
    titled = [ax.get_title() for ax in drawn.axes]
    assert titled == ["start-0", "start-1", "", "", "start-2", "", "", ""]
    assert [ax.axison for ax in drawn.axes] == [True] * 5 + [False, True, False]
    resting = data.history(labels=("far",))
    for name in ("phi", "phi_dot", "theta", "theta_dot"):
        resting[name] = 0.0 * resting[name] + (1e-17 if name.endswith("_dot") else 0.02)
    (ax,) = draw(resting, figure("history", variable="phi_dot")).axes
    assert not ax.lines[0].get_ydata().any()  # what it has is rounding


@pytest.mark.parametrize("turn", [0.0, 1.5 * np.pi])
def test_the_arrow_of_a_phase_portrait_does_not_hide_its_start(turn):
    """It stands on the straight part of the curve, that of stick, beside where that begins."""
    found = without_events(data.history(labels=("far",)))
    angle = 9.0 * found["time"] + turn
    rate = np.minimum(-0.09 * np.sin(angle), 0.05)
    phi = 0.02 + 0.01 * np.cos(angle)
    found["phi"], found["phi_dot"] = (
        found[name].copy(data=one.values[None]) for name, one in (("phi", phi), ("phi_dot", rate))
    )
    (arrow,) = draw(found, figure("phase")).axes[0].texts
    middle = 0.5 * (np.array(arrow.xyann) + arrow.xy)
    start = np.array([phi.isel(time=0), rate.isel(time=0)])
    assert np.linalg.norm((middle - start) / [0.02, 0.14]) > 0.1
    assert middle[1] == pytest.approx(0.05, abs=1e-3)


def test_the_arrow_of_a_phase_portrait_does_not_hide_a_short_stick():
    found = data.history(labels=("far",))
    angle = 9.0 * found["time"].values
    short = (np.sin(angle) > 0.995)[None]
    states = np.where(short, "stick", "slip+")
    found["phi_dot"] = found["phi_dot"].copy(data=np.minimum(-0.09 * np.sin(angle), 0.08)[None])
    found["contact_state"] = data.flags(("initial", "time"), states, data.CONTACT_STATES)
    found = found.drop_dims("event_obs").assign(data.ledger(found["time"].values, states))
    (ax,) = draw(found, figure("phase")).axes
    stick = next(one for one in ax.collections if one.get_label().endswith("stick"))
    places = np.concatenate(stick.get_segments())
    (arrow,) = ax.texts
    middle = 0.5 * (np.array(arrow.xyann) + arrow.xy)
    assert np.linalg.norm((middle - places) / [0.02, 0.17], axis=1).min() > 0.1


@pytest.mark.parametrize(
    ("periods", "log", "lines"), [(3.0, "", 2), (3.0, "y", 3), (2.9, "", None)]
)
def test_of_whole_periods_a_spectrum_has_upright_lines_at_their_harmonics(periods, log, lines):
    """At 2, 6 and 10 Hz, the last too small to be seen but on a logarithmic axis."""
    time = np.linspace(0.0, periods / 2.0, 601)
    angle = 4.0 * np.pi * time
    values = np.sin(angle) + 0.2 * np.cos(3.0 * angle) + 1e-4 * np.sin(5.0 * angle)
    found = without_events(data.history(labels=("far",))).isel(time=slice(601))
    found = found.assign_coords(time=("time", time, found["time"].attrs))
    for name in ("phi", "theta"):
        rates = np.gradient(values, time)
        rates[-1] = rates[0]
        for of, its in (("", values), ("_dot", rates)):
            found[name + of].values[:] = its if found[name + of].ndim == 1 else its[None]
    (ax,) = draw(found, figure("spectrum", variable="phi", **({"log": log} if log else {}))).axes
    (line,) = ax.lines
    x, height = line.get_data()
    top, (_, right) = height[np.isfinite(height)].max(), ax.get_xlim()
    if lines is None:
        assert x.size == 301 and right < 10.0
        return
    seen = height > top * (1e-6 if log else 1e-3)
    np.testing.assert_allclose(x[seen], [2.0, 6.0, 10.0][:lines])
    np.testing.assert_allclose(height[seen], [1.0, 0.2, 1e-4][:lines], rtol=1e-9)
    assert right == pytest.approx(1.05 * x[seen].max())
    assert not log or ax.get_ylim()[0] == pytest.approx(1e-6 * top)
    (both,) = draw(found, figure("spectrum", variable=["phi", "theta"])).axes
    assert both.get_ylim()[1] == pytest.approx(1.05)
    wide = figure("spectrum", variable=["phi", "theta"], xlim=[0.0, 200.0])
    (note,) = style.notes_on(draw(found, wide, look=look_of("paper", width=84.0)))
    assert note.startswith("lines of 2 spectra stand side by side, here up to 0.")
    assert style.notes_on(both.figure) == []  # of 10 Hz
    for look in ("screen", "paper", "talk"):
        asked = figure("spectrum", variable=["phi", "theta"])
        (both,) = draw(found, asked, look=look_of(look)).axes
        x, _ = np.transpose([line.get_transform().transform((2.0, 0.5)) for line in both.lines])
        wide = both.lines[0].get_linewidth() / 72.0 * both.figure.dpi
        assert x[1] - x[0] > wide  # one does not hide the other
    rows = [*csv.DictReader(as_csv(both.figure, Path("a.csv")).splitlines())]
    told = np.array([[float(row["x"]), float(row["y"])] for row in rows])
    heights = [line.get_ydata()[1::3] for line in both.lines]
    np.testing.assert_array_equal(told[:, 1], np.concatenate(heights))  # and not one of their feet
    np.testing.assert_allclose(told[told[:, 1] > 0.1 * top, 0], [2.0, 6.0] * 2)


def test_the_spectrum_of_what_jumps_between_samples_knows_where():
    """A square wave, 1 for 0.3037 of its period and 0 else: |c_n| = |sin(0.3037 n pi)| / (n pi)."""
    share, first, count = 0.3037, 0.2218, 100
    time = np.arange(count + 1) / count
    values = (((time - first) % 1.0) < share).astype(float)
    edges = np.array([first, first + share])
    _, whole = amplitude_spectrum(time, values, True, (edges, np.array([1.0, -1.0])))
    numbers = np.arange(1, 11)
    known = 2.0 * np.abs(np.sin(np.pi * share * numbers)) / (np.pi * numbers)
    np.testing.assert_allclose(whole[1:11], known, rtol=1e-12)
    _, sampled = amplitude_spectrum(time, values, True)
    assert np.abs(sampled[1:11] / known - 1.0).max() > 0.01


def test_a_phase_portrait_of_other_states():
    (ax,) = draw(data.history(labels=("far",)), figure("phase", x="theta", y="phi")).axes
    assert (ax.get_xlabel(), ax.get_ylabel()) == (r"$\theta$ (rad)", r"$\varphi$ (rad)")


def test_motions_may_share_one_phase_portrait():
    drawn = draw(data.history(), figure("phase", overlay=True))
    (ax,) = drawn.axes
    marks = {line.get_label(): (line.get_marker(), line.get_xydata().tolist()) for line in ax.lines}
    assert [marker for marker, _ in marks.values()] == ["o", "s"]
    assert legend_texts(drawn)[-2:] == ["start: far", "start: near"]
    assert ax.get_title() == ""


def test_a_motion_at_rest_is_a_mark_in_its_phase_portrait():
    """Not a line through the last digits of what it would be."""
    found = without_events(data.history(labels=("far",)))
    digits = 1e-17 * np.arange(found.sizes["time"])
    still = {name: 0.0 * found[name] + 1.0 for name in ("phi", "theta")}
    moving = dict.fromkeys(("phi_dot", "theta_dot"), 0.0 * found["phi"] + digits)
    drawn = draw(found.assign(still | moving), figure("phase"))
    (ax,) = drawn.axes
    (mark,) = ax.lines
    assert mark.get_xydata().tolist() == [[1.0, 0.0]] and not ax.collections
    assert legend_texts(drawn)[-1] == "at rest"


@pytest.mark.parametrize("kind", ["phase", "history"])
def test_a_window_of_time_is_all_that_is_drawn(kind):
    dataset = data.history(labels=("far",))
    drawn = draw(dataset, figure(kind, window=[2.0, "3 s"], variable="phi"))
    (ax,) = drawn.axes
    if kind == "history":
        (line,) = ax.lines
        assert (line.get_xdata().min(), line.get_xdata().max()) == pytest.approx((2.0, 3.0))
    else:
        assert not ax.lines  # a window has no start
        assert "start" not in legend_texts(drawn)


def test_motions_need_a_history_and_a_choice():
    for kind in ("history", "phase", "spectrum", "spectrogram"):
        with pytest.raises(UsageError, match="no motion"):
            draw(data.bifurcation(), figure(kind))
    many = xr.concat(
        [
            without_events(data.history()).assign_coords(initial=[f"{n}-a", f"{n}-b"])
            for n in range(3)
        ],
        "initial",
        data_vars="minimal",
    )
    with pytest.raises(UsageError, match="choose from initial"):
        draw(many, figure("phase"))
    with pytest.raises(UsageError, match="next: fiv history CASE --at"):
        draw(data.bifurcation(), figure("spectrum", variable=["F_N", "F_T"]))


def test_motions_of_several_files_stand_side_by_side_in_a_history():
    """Each by its start, or as a cycle, stable or not; with a range for all."""
    far, near = (data.history(labels=(label,)).assign_attrs(called="") for label in ("far", "near"))
    cycle = near.assign_attrs(steady_state="unstable cycle", point="v=1, settled")
    drawn = draw([("a", far), ("b", cycle)], figure("history", variable="phi"))
    assert [ax.get_title() for ax in drawn.axes] == ["far", "unstable cycle"]
    assert len({ax.get_ylim() for ax in drawn.axes}) == 1
    (phase,) = draw([("a", far), ("b", cycle)], figure("phase")).axes
    assert {"start: far", "unstable cycle"} <= {*legend_texts(phase)}
    many = [(f"{n}", far) for n in range(6)]  # more than stand side by side
    several = draw(many, figure("history", variable="phi")).axes
    assert len({round(ax.get_position().y0, 2) for ax in several}) == 2
    lacking = near.drop_vars("theta_dot")
    with pytest.raises(UsageError, match="theta_dot: no variable over time"):
        draw([("a", far), ("b", lacking)], figure("history", variable="theta_dot"))


@pytest.mark.parametrize("amplitude", [0.3, 2.0])
def test_a_sine_shows_its_amplitude_at_its_frequency(amplitude):
    time = np.append(np.arange(0.0, 4.0, 0.005), 4.0021)
    frequency, height = amplitude_spectrum(time, 7.0 + amplitude * np.sin(2 * np.pi * 12.5 * time))
    assert frequency[np.argmax(height)] == pytest.approx(12.5)
    assert height.max() == pytest.approx(amplitude, rel=1e-6)


def test_a_spectrum_refuses_samples_that_are_not_uniform():
    with pytest.raises(UsageError, match="equal intervals"):
        amplitude_spectrum(np.linspace(0.0, 1.0, 50) ** 2, np.zeros(50))
    with pytest.raises(UsageError, match="16 samples"):
        amplitude_spectrum(np.linspace(0.0, 1.0, 8), np.zeros(8))


@pytest.mark.parametrize(
    ("unit", "label", "peak"),
    [("Hz", "$f$ (Hz)", 9 / (2 * np.pi)), ("rad/s", r"$\omega$ (rad/s)", 9)],
)
def test_a_spectrum_is_in_the_unit_asked_for(unit, label, peak):
    (ax,) = draw(data.history(labels=("far",)), figure("spectrum", unit=unit, variable="phi")).axes
    x, y = ax.lines[0].get_data()
    assert ax.get_xlabel() == label
    assert x[np.argmax(y)] == pytest.approx(peak, abs=x[1])
    assert ax.get_ylabel() == r"amplitude of $\varphi$ (rad)"


def test_spectra_along_a_parameter_are_colours_with_dots_at_growing_modes():
    drawn = draw(data.spectra(), figure("spectrum"))
    near, far = drawn.axes[:2]
    assert (near.get_title(), far.get_title()) == ("near", "far")
    (mesh,) = [c for c in far.collections if isinstance(c, QuadMesh)]
    cells = mesh.get_array().reshape(81, 12)
    np.testing.assert_allclose(cells[50], 1e-3 * np.linspace(0.1, 1.2, 12))
    assert np.all(cells[0] == pytest.approx(1.2e-6))  # nothing: three decades below the largest
    dots = np.concatenate([line.get_xydata() for line in far.lines])
    dots = dots[np.isfinite(dots[:, 1])]
    np.testing.assert_allclose(dots[:, 1], 20.0 + dots[:, 0])
    assert len(dots) == np.count_nonzero(np.linspace(0.1, 1.2, 12) > 0.5)


def test_a_motion_without_bound_leaves_its_column_hatched_and_named():
    drawn = draw(data.spectra(), figure("spectrum", select={"initial": "near"}))
    (mesh,) = [c for c in drawn.axes[0].collections if isinstance(c, QuadMesh)]
    assert np.ma.getmaskarray(mesh.get_array()).reshape(81, 12)[:, -1].all()
    assert drawn.axes[0].patch.get_hatch()
    assert legend_texts(drawn) == ["unstable eigenfrequency", "diverged"]


@pytest.mark.parametrize(("unit", "factor"), [("Hz", 1.0), ("rad/s", 2 * np.pi)])
def test_a_single_spectrum_is_a_line_with_growing_modes_upright(unit, factor):
    (ax,) = draw(
        data.spectra(), figure("spectrum", select={"mu_k": 0.9, "initial": "far"}, unit=unit)
    ).axes
    x, y = ax.lines[0].get_data()
    assert x[np.argmax(y)] == pytest.approx(25.0 * factor)
    (upright,) = [line for line in ax.lines if line.get_label() == "unstable eigenfrequency"]
    assert upright.get_xdata()[0] == pytest.approx(20.9 * factor)
    assert ax.get_ylabel() == "amplitude of $x$ (m)"


def test_harmonics_of_a_period_stand_where_they_are_and_not_in_the_middle_of_an_interval():
    one = data.spectra().isel(mu_k=[5]).sel(initial=["far"])
    raster = float(one["frequency"][1])
    heights = np.zeros(one["frequency"].size)
    heights[[30, 59]] = 2e-3, 1e-3
    one["amplitude"].values[...] = heights.reshape(one["amplitude"].shape)
    whole = draw(one, figure("spectrum")).axes[0].lines[0].get_xdata()
    assert whole.size == heights.size
    basic = 29.7 * raster
    one["period"] = one["status"] * 0.0 + 1.0 / basic
    x, y = draw(one, figure("spectrum")).axes[0].lines[0].get_data()
    np.testing.assert_allclose(x, np.repeat([basic, 2 * basic], 3))
    (word,) = draw(one, figure("spectrum", unit="rad/s")).axes[0].texts
    assert word.get_text() == rf"$\omega_1$ = {2 * np.pi * basic:.4g} rad/s"
    assert word.xy == pytest.approx((2 * np.pi * basic, 2e-3))
    for log in (False, "y"):  # it stands within the panel
        drawn = draw(one, figure("spectrum", log=log), look=look_of("paper", width=84.0))
        drawn.draw_without_rendering()
        (ax,) = drawn.axes
        assert ax.texts[0].get_window_extent().y1 <= ax.bbox.y1 + 1.0
    np.testing.assert_array_equal(y, [0.0, 2e-3, np.nan, 0.0, 1e-3, np.nan])
    one["period"] = one["period"] * 0.0 + 2.0 / raster  # several harmonics in each interval
    assert draw(one, figure("spectrum")).axes[0].lines[0].get_xdata().size == heights.size


# --- eigenvalues, laws -------------------------------------------------------------------------
def test_modes_that_a_line_does_not_have_are_not_in_its_legend():
    full = data.eigenvalues()
    fewer = full.copy(deep=True)
    for name in ("eigenvalue_real", "eigenvalue_imag", "mode_frequency"):
        fewer[name][:, 2:] = np.nan
    dataset = xr.concat([full, fewer], xr.Variable("geometry", ["nonlinear", "linear"]))
    top, _ = draw(dataset, figure("eigenvalues")).axes
    lines = {line.get_label() for line in top.lines}
    assert {"_mode 2, nonlinear", "_mode 1, linear"} <= lines
    assert "_mode 2, linear" not in lines
    assert legend_texts(top)[:4] == ["mode 1", "mode 2", "nonlinear", "linear"]


def test_frequencies_of_modes_come_in_the_unit_that_is_asked_for():
    in_hertz, in_radians = (
        draw(data.eigenvalues(), figure("eigenvalues", **unit)).axes[1]
        for unit in ({}, {"unit": "rad/s"})
    )
    assert " ".join(in_radians.get_ylabel().split()) == "angular frequency of the mode (rad/s)"
    drawn = (
        [line for line in ax.lines if line.get_marker() != "X"] for ax in (in_hertz, in_radians)
    )
    for one, other in zip(*drawn, strict=True):
        np.testing.assert_allclose(other.get_ydata(), 2.0 * np.pi * np.asarray(one.get_ydata()))


def test_a_line_stands_where_modes_merge():
    dataset = data.eigenvalues()
    points = np.where(dataset["mu_k"].values[:, None] == 0.5, 0.5, np.nan) * np.ones(4)
    dataset["coupling_point"] = (("mu_k", "mode"), points, {"along": "mu_k"})
    top, bottom = draw(dataset, figure("eigenvalues")).axes
    for ax in (top, bottom):
        assert marks(ax, "_modes merge")[:, 0].tolist() == [0.5, 0.5]
    dataset["coupling_point"].attrs["along"] = "F"
    top, _ = draw(dataset, figure("eigenvalues")).axes
    assert "modes merge" not in [line.get_label() for line in top.lines]
    dataset["coupling_point"].attrs["along"] = "mu_k"
    apart = dataset.assign(coupling_point=dataset["coupling_point"] * np.nan)
    laws = xr.Variable("friction", ["coulomb", "stribeck"])
    top, _ = draw(xr.concat([dataset, apart], laws), figure("eigenvalues")).axes
    assert marks(top, "_modes merge, coulomb")[:, 0].tolist() == [0.5, 0.5]
    assert "_modes merge" not in [line.get_label() for line in top.lines]
    moved = dataset.assign(coupling_point=dataset["coupling_point"] + 0.1)
    top, _ = draw(xr.concat([dataset, moved], laws), figure("eigenvalues")).axes
    merging = {line.get_label(): line for line in top.lines if "merge" in line.get_label()}
    looks = [merging[f"_modes merge, {law}"].get_linestyle() for law in laws.values]
    assert looks == ["-", "--"]
    merge = [text for text in legend_texts(top) if "merge" in text]
    assert merge == ["modes merge"]  # the dashes say whose it is


@pytest.mark.parametrize(("apart", "one"), [(1e-5, True), (0.01, False)])
def test_mergers_that_interpolation_does_not_tell_apart_are_one(apart, one):
    """Of points 0.025 apart: of another pair of modes, and at another value of another axis."""
    dataset = data.eigenvalues()
    points = np.where(dataset["mu_k"].values[:, None] == 0.5, 0.5, np.nan) * np.ones(4)
    dataset["coupling_point"] = (("mu_k", "mode"), points, {"along": "mu_k"})
    pairs = dataset.assign(coupling_point=dataset["coupling_point"] + [0.0, 0.0, apart, apart])
    top, _ = draw(pairs, figure("eigenvalues")).axes
    drawn = [line for line in top.lines if "_modes merge" in line.get_label()]
    assert len(drawn) == (1 if one else 2)
    moved = dataset.assign(coupling_point=dataset["coupling_point"] + apart)
    laws = xr.Variable("friction", ["coulomb", "stribeck"])
    top, _ = draw(xr.concat([dataset, moved], laws), figure("eigenvalues")).axes
    assert ("_modes merge" in [line.get_label() for line in top.lines]) == one


def test_of_many_modes_the_legend_names_some():
    few = data.eigenvalues().isel(mode=[0] * 20).drop_vars("mode_frequency", errors="ignore")
    many = few.assign(mode_frequency=data.eigenvalues()["mode_frequency"].isel(mode=[0] * 20))
    top, _ = draw(many, figure("eigenvalues")).axes
    told = [text for text in legend_texts(top) if text.startswith("mode")]
    assert len(told) == 6 and (told[0], told[-1]) == ("mode 1", "mode 20")


def test_eigenvalues_mark_every_unstable_point():
    dataset = data.eigenvalues()
    top, bottom = draw(dataset, figure("eigenvalues")).axes
    unstable = int(((dataset["eigenvalue_real"] > 0) & (dataset["eigenvalue_imag"] > 0)).sum())
    for ax in (top, bottom):
        assert (
            sum(len(line.get_xdata()) for line in ax.lines if line.get_marker() == "o") == unstable
        )
    assert top.get_ylabel().replace("\n", " ") == "real part of the eigenvalue (rad/s)"
    assert bottom.get_ylabel() == "frequency of the mode (Hz)"
    assert bottom.get_xlabel() == r"coefficient of kinetic friction $\mu_k$"
    assert marks(bottom, "failed")[:, 0] == pytest.approx([0.175])


def test_the_dashes_of_several_lines_of_a_mode_are_seen_where_it_is_unstable():
    laws = xr.Variable("friction", ["coulomb", "stribeck"])
    both = xr.concat([data.eigenvalues()] * 2, laws)
    unstable = (both["eigenvalue_real"] > 0.0) & (both["eigenvalue_imag"] > 0.0)
    for ax in draw(both, figure("eigenvalues")).axes:
        dashed = [line for line in ax.lines if "_mode " in line.get_label()]
        bands = [line for line in ax.lines if line.get_marker() == "o" and line.get_xydata().size]
        assert max(band.get_zorder() for band in bands) < min(line.get_zorder() for line in dashed)
        assert sum(np.isfinite(band.get_ydata()).sum() for band in bands) == int(unstable.sum())


def test_a_mode_can_be_selected_by_its_number():
    dataset = data.eigenvalues().assign_coords(mode=range(4))
    top, _ = draw(dataset, figure("eigenvalues", select={"mode": 2})).axes
    assert np.array_equal(
        marks(top, "_mode = 2")[:, 1], dataset["eigenvalue_real"][:, 2], equal_nan=True
    )
    assert len([text for text in legend_texts(top) if text.startswith("mode")]) == 1


def test_modes_are_counted_as_modes_not_as_eigenvalues():
    top, _ = draw(data.eigenvalues(), figure("eigenvalues")).axes
    assert legend_texts(top)[:2] == ["mode 1", "mode 2"]


@pytest.mark.parametrize(
    ("name", "velocity", "expected"),
    [
        ("coulomb", [0.5, 2.0], [0.3, 0.3]),
        ("coulomb", [-2.0, -0.5], [-0.3, -0.3]),
        ("stribeck", [1.0], [0.3 + 0.1 * np.exp(-1)]),
        ("hyperbolic", [1.0], [0.1]),
        ("tanh of coulomb", [-0.02], [-0.3 * np.tanh(1.0)]),
        ("linear-slope", [-1.0], [-9.9]),
    ],
)
def test_laws_are_drawn_as_they_are_written(name, velocity, expected):
    law = get_law(name)
    assert force(law, np.array(velocity), law.defaults) == pytest.approx(expected)


@pytest.mark.parametrize("width", [84.0, 160.0])
def test_a_legend_of_laws_stays_on_the_page(width):
    drawn = draw_laws(["coulomb", "stribeck:v_s=0.05", "lugre"], look_of("paper", width=width))
    drawn.canvas.draw()
    box = drawn.legends[0].get_window_extent()
    assert box.x0 >= 0.0 and box.x1 <= drawn.bbox.x1 and box.y0 >= 0.0


def test_a_law_of_a_coefficient_and_one_of_a_force_have_their_own_axis():
    assert draw_laws(["coulomb"]).axes[0].get_ylabel() == "$F_T/F_N$"
    assert draw_laws(["linear-slope"]).axes[0].get_ylabel() == "$F_T$ (N)"
    with pytest.raises(UsageError, match="no axis"):
        draw_laws(["coulomb", "linear-slope"])


def test_what_a_contact_holds_in_stick_is_drawn():
    (ax,) = draw_laws(["coulomb"]).axes
    dotted = [line for line in ax.lines if line.get_linestyle() == ":" and len(line.get_xdata())]
    assert list(dotted[0].get_ydata()) == [-0.4, 0.4]


def test_laws_are_drawn_with_the_parameters_that_are_given():
    wanted = ["stribeck:v_s=5 cm/s, mu_s=0.5", "stribeck", "exponential:mu_s=0.6"]
    (ax,) = draw_laws(wanted, fastest=0.1).axes
    drawn = [line for line in ax.lines if len(line.get_xdata()) > 2][1::2]  # of positive speed
    ends = [(line.get_ydata()[0], line.get_ydata()[-1]) for line in drawn]
    expected = [(0.5, 0.3 + 0.2 * np.exp(-2.0)), (0.4, 0.3 + 0.1 * np.exp(-0.1)), (0.6, None)]
    for found, (begun, ended) in zip(ends, expected, strict=True):
        assert found[0] == pytest.approx(begun)
        assert ended is None or found[1] == pytest.approx(ended, rel=1e-3)
    assert len({line.get_linestyle() for line in ax.lines}) > 2
    for wrong, said in (("stribeck:vs=1", "did you mean 'v_s'"), ("stribeck:v_s=-1", "> 0")):
        with pytest.raises(UsageError, match=said):
            draw_laws([wrong])


def test_unknown_laws_and_kinds_are_named():
    with pytest.raises(UsageError, match="did you mean 'coulomb'"):
        draw_laws(["columb"])
    with pytest.raises(UsageError, match=r"there are: map"):
        draw(data.bifurcation(), figure("pie"))


# --- which figures -----------------------------------------------------------------------------
@pytest.mark.parametrize(
    ("dataset", "kinds"),
    [
        (data.bifurcation(), ["bifurcation", "curve"]),
        (data.stability_map(), ["map"]),
        (data.history(), ["history", "phase"]),
        (data.eigenvalues(), ["eigenvalues"]),
    ],
)
def test_a_dataset_without_figures_gets_those_that_suit_it(dataset, kinds):
    assert [spec.kind for spec in default_figures(dataset)] == kinds
    assert [spec.kind for spec in figures_of(dataset)] == kinds


def test_the_case_says_which_figures_there_are():
    figures = [figure("map"), figure("map", variable="L_s"), figure("curve", select={"N0": 30})]
    dataset = data.stability_map().assign_attrs(data.attributes(*figures))
    assert figures_of(dataset) == figures


def test_a_figure_takes_the_analysis_that_suits_it_or_the_one_it_names():
    analyses = {"modes": data.eigenvalues(), "steady": data.bifurcation()}
    (ax,) = draw(analyses, figure("bifurcation")).axes
    assert "at the section" in ax.get_ylabel()
    (ax,) = draw(analyses, figure("curve", analysis="modes", variable="growth_rate")).axes
    assert ax.get_ylabel() == "growth rate (rad/s)"
    with pytest.raises(UsageError, match="no analysis"):
        draw(analyses, figure("curve", analysis="other"))


def test_defaults_of_several_analyses_name_theirs():
    figures = default_figures({"modes": data.eigenvalues(), "steady": data.bifurcation()})
    assert [(f.name, f.settings["analysis"]) for f in figures] == [
        ("eigenvalues", "modes"),
        ("bifurcation", "steady"),
        ("curve", "steady"),
    ]


@pytest.mark.parametrize(
    ("selection", "words_of_error"),
    [
        ({"initial": "middle"}, "initial: near, far"),
        ({"N0": 30}, "its axes: Omega, initial"),
        ({"Omega": "fast"}, "Omega = fast"),
    ],
)
def test_an_unknown_selection_says_what_exists(selection, words_of_error):
    with pytest.raises(UsageError, match=words_of_error):
        draw(data.bifurcation(), figure("curve", select=selection))


@pytest.mark.parametrize(("wanted", "nearest"), [(3.01, 3.0), ("30 rpm", 3.1), (99, 5.0)])
def test_a_number_selects_the_nearest_point(wanted, nearest):
    drawn = draw(data.bifurcation(), figure("curve", x="initial", select={"Omega": wanted}))
    assert rf"$\Omega$ = {nearest:g} rad/s" in drawn.get_suptitle()


def test_an_unknown_variable_says_what_there_is():
    with pytest.raises(UsageError, match="it has: status, attractor, L_s"):
        draw(data.bifurcation(), figure("curve", variable="energy"))
    with pytest.raises(UsageError, match="not one value per point"):
        draw(data.bifurcation(), figure("curve", variable="section_value"))
    with pytest.raises(UsageError, match="no values at a section"):
        draw(data.stability_map(), figure("bifurcation"))


def test_a_figure_may_have_a_title_of_its_own():
    drawn = draw(data.bifurcation(), figure("curve", title="Both branches"))
    assert drawn.get_suptitle() == "Both branches"
    assert draw(data.bifurcation(), figure("curve")).get_suptitle() == "A sweep (Figure 7.6)"


def test_what_a_file_differs_in_is_named_once():
    """Though it is an axis of one value, which the title names by itself."""
    axes = data.axes(c=[0.5], Omega=[1.0, 2.0])
    dataset = data.response(np.full((1, 2), "periodic"), np.ones((1, 2)), axes)
    own = points.title(dataset)
    assert "$c$ = 0.5" in own
    assert points.title(dataset.assign_attrs(differs="$c$ = 0.5, $k$ = 2 N/m")) == (
        f"{own}, $k$ = 2 N/m"
    )


@pytest.mark.parametrize(
    ("direction", "told"), [("both", ""), ("up", ", rising"), ("down", ", falling")]
)
def test_values_are_told_with_the_section_that_they_are_passed_at(direction, told):
    section = {"kind": "zero", "state": "phi_dot", "direction": direction, "contact": 1}
    analyses = {"response": {"kind": "response", "settings": {"section": section}}}
    dataset = data.bifurcation().assign_attrs(analyses_json=json.dumps(analyses))
    (ax,) = draw(dataset, figure("bifurcation")).axes
    assert ax.get_ylabel() == rf"$\varphi$ at $\dot{{\varphi}}$ = 0{told} (rad)"


def test_a_figure_names_the_parameters_that_were_set_by_hand():
    """The title of the case is that of another value; in one figure lines are called by it."""
    both = []
    for value in (2.0, 5.0):
        set_by_hand = data.bifurcation().assign_coords(c2=xr.DataArray(value, attrs={"units": "1"}))
        both.append(set_by_hand.assign_attrs(overrides=f"model.parameters.c2={value}\nsweep={{}}"))
    alone = draw(both[1], figure("curve"))
    assert alone.get_suptitle() == "A sweep (Figure 7.6)\n$c_{2}$ = 5"
    together = draw([("a", both[0]), ("b", both[1])], figure("curve"))
    assert together.get_suptitle() == "A sweep (Figure 7.6)"


def test_a_title_of_two_lines_is_drawn_without_a_word_of_complaint(caplog):
    drawn = Figure()
    title = drawn.suptitle("Both branches\nat $\\mu_k$ = 0.3")
    tame_texts(drawn)
    assert caplog.messages == []
    assert title.get_parse_math()


# --- words and colours -------------------------------------------------------------------------
@pytest.mark.parametrize(
    ("unit", "text"),
    [
        ("1", ""),
        ("rad", "rad"),
        ("rad s-1", "rad/s"),
        ("N s m-1", "N s/m"),
        ("kg m2", "kg m$^{2}$"),
        ("m s-2", "m/s$^{2}$"),
        ("s-1", "s$^{-1}$"),
        ("J kg-1 K-1", "J kg$^{-1}$ K$^{-1}$"),
    ],
)
def test_units_read_as_people_write_them(unit, text):
    assert words.unit_text(unit) == text


@pytest.mark.parametrize(
    ("name", "latex"),
    [
        ("x", "x"),
        ("mu_k", r"\mu_{k}"),
        ("phi_dot", r"\dot{\varphi}"),
        ("x1_dot", r"\dot{x}_{1}"),
        ("x1_dot_max", r"\dot{x}_{1,\mathrm{max}}"),
        ("C_0_1", "C_{0,1}"),
        ("psi_a", r"\psi_{a}"),
    ],
)
def test_names_become_symbols(name, latex):
    assert words.symbol_of_name(name) == latex


def test_words_stay_words_and_symbols_symbols():
    solutions = xr.DataArray(0, name="n_solutions", attrs={"long_name": "equilibria found"})
    assert words.axis_label(solutions) == "equilibria found"
    assert words.axis_label(xr.DataArray(0, name="C_0_1", attrs={"units": "m"})) == "$C_{0,1}$ (m)"


def test_a_class_has_one_colour():
    assert (
        class_colours(["periodic", "equilibrium"])[0] == class_colours(["chaotic", "periodic"])[1]
    )


@pytest.mark.parametrize("count", [1, 7, 8, 40])
def test_lines_differ_in_colour(count):
    assert len({tuple(np.atleast_1d(c).tolist()) for c in line_colours(count)}) == count


def test_dots_shrink_where_there_are_many():
    assert dot_size(10) > dot_size(100) > dot_size(1000)
    assert dot_size(10, 3.3) == dot_size(10)
    assert dot_size(200, 3.3) < dot_size(200)


# --- files -------------------------------------------------------------------------------------

SIGNATURES = {"png": b"\x89PNG", "svg": b"<?xml", "pdf": b"%PDF"}


@pytest.mark.parametrize("suffix", SIGNATURES)
@pytest.mark.parametrize(
    "dataset",
    [data.bifurcation(), data.stability_map(), data.history()],
    ids=["dots", "map", "motion"],
)
def test_the_same_data_gives_the_same_bytes(tmp_path, suffix, dataset):
    contents = []
    for name in ("one", "two"):
        path = tmp_path / f"{name}.{suffix}"
        save(draw(dataset, default_figures(dataset)[0]), path)
        contents.append(path.read_bytes())
    assert contents[0].startswith(SIGNATURES[suffix])
    assert contents[0] == contents[1]


def test_a_figure_does_not_depend_on_the_users_configuration(tmp_path):
    import matplotlib as mpl

    paths = [tmp_path / "plain.svg", tmp_path / "configured.svg"]
    save(draw(data.bifurcation(), figure("curve")), paths[0])
    with mpl.rc_context({"font.size": 20, "axes.facecolor": "red", "svg.hashsalt": None}):
        save(draw(data.bifurcation(), figure("curve")), paths[1])
    assert paths[0].read_bytes() == paths[1].read_bytes()


@pytest.mark.parametrize("kind", ["bifurcation", "curve"])
def test_on_paper_a_figure_is_as_wide_as_asked_without_title_and_in_its_font(tmp_path, kind):
    paper = look_of("paper", width=84.0)
    drawn = draw(data.bifurcation(), figure(kind), look=paper)
    assert drawn.get_figwidth() * 25.4 == pytest.approx(84.0)
    assert drawn.get_suptitle() == ""
    save(drawn, tmp_path / "a.svg", paper)
    written = (tmp_path / "a.svg").read_text()
    assert f'width="{84.0 / 25.4 * 72.0:.6f}'.rstrip("0") in written
    assert "STIXGeneral" in written
    assert "DejaVu" not in written.replace("DejaVuSans-Oblique", "")
    titled = draw(data.bifurcation(), figure(kind), look=look_of("paper", titled=True))
    assert "A sweep" in titled.get_suptitle()


@pytest.mark.parametrize("kind", ["bifurcation", "map"])
def test_a_figure_has_the_height_and_the_labels_asked_for(kind):
    dataset = data.stability_map() if kind == "map" else data.bifurcation()
    asked = figure(kind, xlabel="speed (rad/s)", ylabel="what is seen")
    drawn = draw(dataset, asked, look=look_of("talk", width=160.0, height=90.0))
    assert drawn.get_size_inches() * 25.4 == pytest.approx([160.0, 90.0])
    panels = [ax for ax in drawn.axes if ax.get_label() != "<colorbar>"]
    labels = [ax.get_xlabel().replace("\n", " ") for ax in panels]
    assert set(labels) == {"speed (rad/s)"}
    assert panels[0].get_ylabel().replace("\n", " ") == "what is seen"


def test_titles_of_panels_side_by_side_have_room():
    starts = [f"beta = {beta} deg, mu_s = 0.4, mu_k = 0.23" for beta in (0, 15, 30)]
    drawn = draw(data.stability_map(starts), figure("map"), look=look_of("talk", width=160.0))
    drawn.canvas.draw()
    boxes = [ax.title.get_window_extent() for ax in drawn.axes if ax.get_title()]
    assert len(boxes) == 3
    assert not any(one.overlaps(other) for one, other in combinations(boxes, 2))


def test_a_talk_has_larger_letters_and_thicker_lines():
    looks = [look_of("screen", width=200.0), look_of("talk", width=200.0)]
    small, large = (draw(data.bifurcation(), figure("curve"), look=look) for look in looks)
    sizes = [drawn.axes[0].xaxis.label.get_size() for drawn in (small, large)]
    widths = [drawn.axes[0].lines[0].get_linewidth() for drawn in (small, large)]
    assert sizes[1] > 1.5 * sizes[0]
    assert widths[1] == 2 * widths[0]


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("poster",), "there are: screen, paper, talk"),
        (("paper", 2.0), "--width 2: .* 20 to 2000 mm"),
        (("paper", None, None, None, 3e3), "--height 3000: .* 20 to 2000 mm"),
        (("paper", None, "No Such Font"), "not installed"),
    ],
)
def test_looks_that_cannot_be_had_are_told(arguments, message):
    with pytest.raises(UsageError, match=message):
        look_of(*arguments)


def test_long_labels_of_small_panels_are_folded_but_not_in_a_formula():
    dataset = data.eigenvalues()
    dataset["eigenvalue_real"].attrs["long_name"] = "damping ratio c2 / (2 sqrt(m2 k2))"
    drawn = draw(dataset, figure("eigenvalues"), look=look_of("paper", width=50.0))
    lines = drawn.axes[0].get_ylabel().split("\n")
    assert len(lines) > 1
    assert all(line.count("$") % 2 == 0 for line in lines)
    maps = draw(data.stability_map(), figure("map"), look=look_of("paper", width=60.0))
    assert maps.axes[0].get_xlabel() == "disc speed\n$\\Omega$ (rad/s)"


def test_figures_need_a_known_suffix_and_a_place(tmp_path):
    drawn = draw(data.bifurcation(), figure("curve"))
    with pytest.raises(UsageError, match=r"\.png, \.svg, \.pdf"):
        save(drawn, tmp_path / "figure.gif")
    (tmp_path / "file").write_text("")
    with pytest.raises(StorageError, match="cannot be written"):
        save(drawn, tmp_path / "file" / "figure.png")


# --- the commands ------------------------------------------------------------------------------
@pytest.fixture
def stored(tmp_path, monkeypatch):
    """A folder with a dataset of each form."""
    monkeypatch.chdir(tmp_path)
    for name in ("bifurcation", "stability_map", "history", "eigenvalues"):
        getattr(data, name)().to_netcdf(tmp_path / f"{name}.nc")
    return tmp_path


def run(command, *arguments):
    result = CliRunner().invoke(command, [str(argument) for argument in arguments])
    if result.exception and not isinstance(result.exception, SystemExit):
        raise result.exception
    return result


def test_plot_writes_beside_the_dataset_and_prints_the_paths(stored):
    result = run(plot_command, "bifurcation.nc")
    assert result.stdout.split() == ["bifurcation-bifurcation.png", "bifurcation-curve.png"]
    assert all((stored / path).stat().st_size > 1000 for path in result.stdout.split())


def test_plot_takes_one_figure_and_a_path(stored):
    result = run(plot_command, "history.nc", "--figure", "spectrum", "-o", "out/s.svg")
    assert result.stdout == "out/s.svg\n"
    assert (stored / "out/s.svg").exists()


def test_plot_writes_several_figures_beside_the_path_given(stored):
    result = run(plot_command, "history.nc", "-o", "motion.pdf")
    assert result.stdout.split() == ["motion-history-history.pdf", "motion-history-phase.pdf"]


def test_plot_draws_every_analysis_of_a_file_with_several(stored):
    from fiv_cli.data.dataset import Dataset
    from fiv_cli.data.netcdf import write_datasets

    analyses = {"modes": data.eigenvalues(), "steady": data.bifurcation()}
    bare = {n: Dataset.of(one.drop_attrs(deep=False)) for n, one in analyses.items()}
    write_datasets(stored / "two.nc", bare, data.attributes())
    assert run(plot_command, "two.nc").stdout.split() == [
        "two-eigenvalues.png",
        "two-bifurcation.png",
        "two-curve.png",
    ]
    assert "steady: Omega 46 x initial 2" in run(show_command, "two.nc").stdout


def test_plot_leaves_out_figures_of_the_sweep_that_a_history_cannot_show(stored):
    sweep = figure("bifurcation")
    for figures, drawn in (
        ([sweep], ["one-history.png", "one-phase.png"]),
        ([sweep, figure("phase")], ["one-phase.png"]),
    ):
        data.history().assign_attrs(data.attributes(*figures)).to_netcdf(stored / "one.nc")
        result = run(plot_command, "one.nc")
        assert result.stdout.split() == drawn
        assert "figure bifurcation left out: section_value: no values at a section" in result.stderr
    with pytest.raises(UsageError, match="no values at a section"):
        run(plot_command, "one.nc", "--figure", "bifurcation")


def test_plot_draws_the_map_over_laws_that_its_case_asks_for(stored):
    """Unasked it is a curve: a line for each law says more."""
    over_laws = data.stability_map().isel(N0=[0, 1]).rename(N0="friction")
    over_laws = over_laws.assign_coords(friction=["coulomb", "stribeck"])
    over_laws.to_netcdf(stored / "laws.nc")
    assert "laws-map.png" not in run(plot_command, "laws.nc").stdout
    asked = over_laws.assign_attrs(data.attributes(figure("map", y="friction")))
    asked.to_netcdf(stored / "asked.nc")
    assert run(plot_command, "asked.nc").stdout.split() == ["asked-map.png"]


def test_plot_overlays_files_where_a_figure_can(stored):
    result = run(plot_command, "bifurcation.nc", "bifurcation.nc", "--figure", "curve")
    assert result.stdout.split() == ["bifurcation-curve.png"]


@pytest.mark.parametrize(
    ("changes", "called"),
    [
        ({}, ["one", "two"]),
        ({"N0": 20.0}, ["$N_{0}$ = 30 N", "$N_{0}$ = 20 N"]),
        ({"N0": 20.0, "c": 1.0}, ["$c$ = 0, $N_{0}$ = 30 N", "$c$ = 1, $N_{0}$ = 20 N"]),
        ({"N0": 30.0 + 1e-9}, ["one", "two"]),
        (
            {"N0": 20.0, "c": 1.0, "k": 1.0},
            ["$c$ = $k$ = 0, $N_{0}$ = 30 N", "$c$ = $k$ = 1, $N_{0}$ = 20 N"],
        ),
        ({"N0": 20.0, "c": 1.0, "k": 2.0}, ["one", "two"]),
        ({"N0": 20.0, "law": "stribeck"}, ["coulomb", "stribeck"]),
    ],
)
def test_datasets_of_one_figure_are_called_by_what_they_differ_in(changes, called):
    one = data.bifurcation().assign_attrs(law="coulomb").assign_coords(c=0.0, k=0.0)
    one["N0"] = ((), 30.0, {"units": "N"})
    one = one.set_coords("N0")
    law = {"law": changes.pop("law", "coulomb")}
    fixed = {name: ((), value, one[name].attrs) for name, value in changes.items()}
    other = one.assign_coords(fixed).assign_attrs(law)
    assert words.told_apart([("one", one), ("two", other)]) == called


def test_datasets_are_not_called_by_settings_of_an_analysis_that_one_of_them_has_not():
    analyses = {"response": {"kind": "response", "settings": {"t_max": 10.0}}}
    linear = {"eigenvalues": {"kind": "eigenvalues", "settings": {"at_equilibrium": 1}}}
    longer = {"response": {"kind": "response", "settings": {"t_max": 20.0}}}
    called = []
    for first, second in ((analyses | linear, analyses), (analyses | linear, longer)):
        one, other = (
            data.bifurcation().assign_attrs(analyses_json=json.dumps(told), starts_json="[]")
            for told in (first, second)
        )
        called += words.told_apart([("one", one), ("two", other)])
    assert called == ["one", "two", "t_max = 10.0", "t_max = 20.0"]


def test_what_one_dataset_fixes_and_another_varies_is_its_name():
    """The lines of the other tell theirs, unless it has but the axis of the figure."""
    grid = data.axes(c=[1.0, 2.0], mu_k=[0.1, 0.2, 0.3])
    swept = data.response(np.full((2, 3), "periodic"), np.ones((2, 3)), grid)
    swept["c"].attrs |= {"units": "N", "symbol": "c"}
    alone = swept.isel(c=0, mu_k=0)
    assert words.told_apart([("a", swept), ("b", alone)])[0] == ""
    assert words.told_apart([("a", swept), ("b", alone)])[1].startswith("$c$ = 1 N, ")
    assert words.told_apart([("a", swept.isel(c=0)), ("b", alone)])[0] == "a"
    of_one_value = swept.isel(c=[0], mu_k=[0])
    assert words.told_apart([("a", swept), ("b", of_one_value)])[1].startswith("$c$ = 1 N, ")
    files = [("a", swept.assign_coords(k=1.0)), ("b", of_one_value.assign_coords(k=2.0))]
    of_many, of_one = words.told_apart(files)  # who differ in another one as well
    assert of_many == "$k$ = 1" and of_one.startswith("$k$ = 2, $c$ = 1 N, ")


def test_datasets_of_other_settings_are_called_by_these_and_not_by_their_crossings():
    def followed(way, crossings):
        grid = data.axes(N0=[1.0, 2.0], crossing=np.arange(crossings))
        made = data.response(np.full((2, crossings), "periodic"), np.ones((2, crossings)), grid)
        made["status"] = made["status"].isel(crossing=0, drop=True)
        told = {"ends": {"settings": {"follow": way, "width": 1e-6, "bracket": [1.0, 2.0]}}}
        return made.assign_attrs(analyses_json=json.dumps(told))

    files = [("a", followed("none", 2)), ("b", followed("up", 1))]
    assert words.told_apart(files) == ["follow = none", "follow = up"]
    assert words.told_apart([files[0], ("b", followed("none", 1))]) == ["a", "b"]


def test_a_spectrum_along_an_axis_may_have_logarithmic_frequencies(recwarn):
    """Up to the highest, as a linear axis, without a word of matplotlib's."""
    (ax, _), top = draw(data.spectra(), figure("spectrum", log="y")).axes[:2], 40.0
    assert ax.get_yscale() == "log" and ax.get_ylim()[0] > 0.0
    assert ax.get_ylim()[1] == pytest.approx(top)
    assert not [str(one.message) for one in recwarn if "limit" in str(one.message)]


def test_a_sort_of_crossing_has_one_mark_in_all_datasets_of_a_figure():
    """One that a dataset alone has takes no mark of another in its place."""
    both = crossings_of(["periodic", "equilibrium"])
    one = crossings_of(["equilibrium"])
    (ax,) = draw([("both", both), ("one", one)], figure("curve", variable="boundary")).axes
    marks = {
        str(line.get_label()).removeprefix("_"): line.get_marker()
        for line in ax.lines
        if len(line.get_xdata()) and line.get_marker() not in ("None", "s")
    }
    told = {label.split(", ", 1)[1]: set() for label in marks}
    for label, mark in marks.items():
        told[label.split(", ", 1)[1]].add(mark)
    assert len(told) == 2 and all(len(own) == 1 for own in told.values())


def crossings_of(below):
    """Changes of a boundary from each of these classes to chaos, at three preloads."""
    grid = data.axes(N0=[1.0, 2.0, 3.0])
    dims, size = ("N0", "crossing"), len(below)
    found = data.response(np.full(3, "periodic"), np.ones(3), grid).drop_vars("attractor")
    heights = np.arange(1.0, 1.0 + size) + np.zeros((3, 1))
    found["boundary"] = (dims, heights, {"units": "N", "long_name": "border"})
    for side, names in (("below", below), ("above", ["chaotic"] * size)):
        classes = np.tile(names, (3, 1))
        found[f"class_{side}"] = data.flags(dims, classes, data.ATTRACTORS)
    return found


@pytest.mark.parametrize(
    ("low", "high", "told"),
    [(0.3, 8.0, ["0.5", "1", "2", "5"]), (0.3, 300.0, ["$10^{0}$", "$10^{1}$", "$10^{2}$"])],
)
def test_a_short_logarithmic_axis_has_plain_numbers_and_a_long_one_powers(low, high, told):
    found = data.bifurcation()
    found = found.assign_coords(Omega=np.geomspace(low, high, found.sizes["Omega"]))
    (ax,) = draw(found, figure("curve", variable="L_s", log="x", xlim=[low, high])).axes
    ticks = [(tick.get_loc(), tick.label1.get_text()) for tick in ticks_of(ax.xaxis)]
    assert [text for at, text in sorted(ticks) if low <= at <= high and text] == told


def ticks_of(axis):
    axis.figure.draw_without_rendering()
    return [*axis.get_major_ticks(), *axis.get_minor_ticks()]


def test_of_several_files_the_one_that_cannot_be_drawn_is_named(stored):
    asked = ["bifurcation.nc", "stability_map.nc", "--figure", "branch"]
    with pytest.raises(
        UsageError, match=r"branch of all files: not written: bifurcation\.nc: no br"
    ):
        run(plot_command, *asked, "-o", "both.png")


@pytest.mark.parametrize("given", ["84", "84mm", "84 mm", "8.4cm", "0.084 m", "8.4e1"])
def test_a_width_is_a_number_of_mm_or_a_length(given):
    assert Millimetres().convert(given, None, None) == pytest.approx(84.0)


@pytest.mark.parametrize("given", ["84px", "mm", "", "84 kg", "nan", "84,5"])
def test_a_width_that_is_no_length_is_told_the_unit(stored, given):
    result = run(plot_command, "bifurcation.nc", "--width", given)
    assert result.exit_code == 2
    assert "is no length: a number of mm, 84, or one with its unit" in result.output


def test_no_file_of_several_is_left_out_without_a_word(stored):
    """What has no part in a figure of the first file is drawn itself, or refused by its name."""
    result = run(plot_command, "stability_map.nc", "bifurcation.nc")
    drawn = ["stability_map-map.png", "bifurcation-bifurcation.png", "bifurcation-curve.png"]
    assert result.stdout.split() == drawn
    both = ["bifurcation.nc", "eigenvalues.nc"]
    with pytest.raises(UsageError, match=r"eigenvalues: no L_s.*\nnext: draw it alone"):
        run(plot_command, *both, "--figure", "curve")
    with pytest.raises(UsageError, match=r"eigenvalues\.nc: nothing that a bifurcation diagram"):
        run(plot_command, *both, "--figure", "bifurcation")
    assert not (stored / "bifurcation-curve.png").stat().st_size < 1000


def test_of_several_files_no_branch_that_a_diagram_takes_is_blamed_for_another(stored):
    branch_along_the_speed().to_netcdf(stored / "branch.nc")
    data.bifurcation()[["status", "L_s"]].to_netcdf(stored / "apart.nc")
    asked = ["bifurcation.nc", "branch.nc", "apart.nc", "--figure", "bifurcation"]
    for files in (asked, [*asked[2::-1], *asked[3:]]):
        with pytest.raises(UsageError, match=r"not written: apart\.nc: nothing that a bif"):
            run(plot_command, *files)
    named = run(plot_command, *asked[:2], *asked[3:], "--label", "sweep", "--label", "cycles")
    told = "--label cycles: not in the figure bifurcation; lines drawn over those of another file"
    assert named.exit_code == 0 and told in named.stderr
    assert "--label" not in run(plot_command, *asked[:2], *asked[3:]).stderr


def test_a_diagram_refuses_what_gives_it_nothing(stored):
    apart = data.bifurcation()[["status", "L_s"]]
    with pytest.raises(UsageError, match="other: nothing that a bifurcation diagram along Omega"):
        draw([("one", data.bifurcation()), ("other", apart)], figure("bifurcation"))


def test_plot_draws_laws_without_a_dataset(stored):
    result = run(plot_command, "--law", "coulomb", "--law", "tanh of coulomb")
    assert result.stdout == "runs/law-coulomb-tanh-of-coulomb.png\n"
    assert (stored / "runs/law-coulomb-tanh-of-coulomb.png").exists()


def test_plot_draws_loops_of_laws_with_their_parameters(stored):
    wanted = ("--law", "dahl:mu_k=0.5", "--law", "lugre:sigma_1=10", "--loop")
    result = run(plot_command, *wanted, "amplitude=1 mm,omega=5")
    assert result.stdout == "runs/loop-dahl-lugre.png\n"
    assert (stored / "runs/loop-dahl-lugre.png").exists()
    with pytest.raises(CaseError, match="did you mean 'amplitude'"):
        run(plot_command, *wanted, "amplitud=1")
    with pytest.raises(UsageError, match="given twice"):
        run(plot_command, *wanted, "amplitude=1", "--law", "dahl")


@pytest.mark.parametrize(
    ("arguments", "error", "message"),
    [
        ([], UsageError, "datasets or laws"),
        (["history.nc", "--loop", "amplitude=1"], UsageError, "of which law"),
        (["missing.nc"], UsageError, "missing.nc"),
        (["."], UsageError, "folder"),
        (["broken.nc"], InputError, "broken.nc"),
        (["foreign.nc"], InputError, "holds no case"),
        (["history.nc", "--figure", "portrait"], UsageError, "there are: history, phase"),
        (["history.nc", "-o", "a.gif"], UsageError, "use -o a.*png"),
        (
            ["stability_map.nc", "-o", "a.csv"],
            UsageError,
            "a.csv: not written(.|\n)*--csv VARIABLE",
        ),
    ],
)
def test_plot_refuses_what_cannot_be_drawn(stored, arguments, error, message):
    (stored / "broken.nc").write_bytes(b"CDF or not")
    xr.Dataset({"x": 1.0}).to_netcdf(stored / "foreign.nc")
    with pytest.raises(error, match=message):
        run(plot_command, *arguments)


def test_maps_of_several_files_are_drawn_as_one_of_them_asks_and_say_what_they_differ_in(
    stored, monkeypatch
):
    titles = []
    note = lambda figure: titles.append(" ".join(t.get_text() for t in figure.findobj(Text)))  # noqa: E731
    monkeypatch.setattr("fiv_cli.plots.fitting.finish", note)
    asked = FigureSpec("reached", "map", {"variable": "attractor"})
    for k2, figures in ((1e3, [asked]), (2e3, [])):
        whole = data.stability_map().attrs | data.attributes(*figures)
        coordinate = ((), k2, {"units": "N m-1", "symbol": "k_2"})
        dataset = data.stability_map().assign_attrs(whole).assign_coords(k2=coordinate)
        dataset.to_netcdf(stored / f"{k2:g}.nc")
    run(plot_command, "1000.nc", "2000.nc", "--figure", "reached", "-o", "a.png")
    assert [("= 1000 N/m" in title, "= 2000 N/m" in title) for title in titles] == [
        (True, False),
        (False, True),
    ]


@pytest.mark.parametrize(("model", "told"), [("belt-5dof", True), ("one-of-mine", False)])
def test_show_counts_motions_that_pass_what_the_equations_take_as_small(model, told):
    dataset = data.stability_map().assign_attrs(model=model)
    dims, shape = dataset["L_s"].dims, dataset["L_s"].shape
    least = np.zeros(shape)
    least.flat[:3] = -0.2, -0.3, np.nan
    ends = {"phi_min": (dims, least), "phi_max": (dims, np.full(shape, 0.1))}
    found = summarise({"": dataset.assign(ends)})
    passed = f"phi passes 0.25 rad at 1 of {least.size} points"
    assert (passed in "\n".join(summary_lines(found))) == told


def test_show_counts_classes_and_ranges(stored):
    printed = run(show_command, "bifurcation.nc").stdout
    assert "title        A sweep" in printed
    assert "Omega 46 x initial 2" in printed
    assert "0.5 to 5 rad s-1, 46 values" in printed
    assert "near, far" in printed
    assert "ok 91 (98.9%), failed 1 (1.1%)" in printed
    assert "periodic 74 (80.4%), equilibrium 16 (17.4%), not_computed 1 (1.1%)" in printed
    assert "0 to 0.001 rad2" in printed


def test_show_lists_few_labels_and_counts_many():
    dataset = data.stability_map(initial=[f"far-{n:03d}" for n in range(30)])
    assert "far-000, ..., far-029, 30 values" in "\n".join(summary_lines(summarise({"": dataset})))


def test_show_tells_works_that_range_alike_in_one_line():
    told = {"wear_work": (1.0, 2.0), "section_wear_work": (1.0, 2.0)}
    told |= {"drive_work": (1.0, 3.0), "section_drive_work": (2.0, 3.0)}
    told |= {"other_work": (0.0, 0.0), "impact_work": (0.0, 0.0)}
    dataset = data.stability_map().isel(Omega=slice(2), N0=0, initial=0, drop=True)
    (dim,) = dataset["status"].dims
    works = {name: (dim, np.array(pair), {"units": "J"}) for name, pair in told.items()}
    printed = summary_lines(summarise({"": dataset.assign(works)}))
    assert [line.split() for line in printed if "_work" in line] == [
        ["wear_work,", "section_wear_work", "1", "to", "2", "J"],
        ["drive_work", "1", "to", "3", "J"],
        ["section_drive_work", "2", "to", "3", "J"],
        ["0", "throughout", "other_work,", "impact_work"],
    ]


@pytest.mark.parametrize(
    ("lost", "given", "told"),
    [
        ((0.0, 3.0), (2.0, 4.0), ["0 to 0.75 of the drive's work"]),
        ((1.0, 3.0), (0.0, 4.0), ["0.75 of the drive's work"]),
        ((0.0, 0.0), (2.0, 4.0), []),
    ],
)
def test_show_tells_the_share_that_impacts_take(lost, given, told):
    dataset = data.stability_map().isel(Omega=slice(2), N0=0, initial=0, drop=True)
    for names in (("mean_impact_power", "mean_drive_power"), ("impact_loss", "drive_work")):
        terms = dict(zip(names, (lost, given), strict=True))
        powers = {n: (dataset["status"].dims, np.array(pair)) for n, pair in terms.items()}
        printed = summary_lines(summarise({"": dataset.assign(powers)}))
        assert [line[25:] for line in printed if line.startswith("  into impacts")] == told


def test_show_says_what_the_reasons_mean_that_occur():
    dataset = data.stability_map()
    codes = np.zeros(dataset["status"].shape, np.int8)
    codes.flat[:2] = REASON.codes["no_crossing"]
    attrs = {"flag_values": np.array(list(REASON.codes.values()), np.int8)}
    attrs["flag_meanings"] = " ".join(REASON.codes)
    dataset["reason"] = (dataset["status"].dims, codes, attrs)
    text = summary_lines(summarise({"": dataset}))
    row = next(n for n, line in enumerate(text) if line.startswith("  reason "))
    assert "no_crossing 2" in text[row]
    assert text[row + 1] == f"    no_crossing: {advice('no_crossing')}"
    assert not any("nothing to report" in line for line in text)


def a_scan(N=(1.0, 2.0), **given):
    """A bracket of four values at two loads, followed up and down, with a bistable range at one."""
    dims, along, size = ("N", "initial"), ("N", "initial", "scan"), (len(N), 1)
    up = [["equilibrium"] * 2 + ["periodic"] * 2, ["periodic"] * 4]
    low, high = np.full((2, *size, 1), np.nan)
    low[0], high[0] = 0.25, 1.75
    coords = data.axes(N=N, initial=["rest"], scan=np.arange(4.0)) | given
    of_classes = {
        "status": data.statuses(dims, np.full(size, "ok")),
        "scan_class": data.flags(along, np.reshape(up[: len(N)], (*size, 4)), data.ATTRACTORS),
        "scan_class_back": data.flags(along, np.full((*size, 4), "periodic"), data.ATTRACTORS),
    }
    ends = {f"bistable_{end}": ((*dims, "range"), v) for end, v in (("low", low), ("high", high))}
    for end, kind in (("low", "change"), ("high", "bracket")):
        named = data.flags((*dims, "range"), np.full((*size, 1), kind), ("change", "bracket"))
        ends[f"bistable_{end}_kind"] = named
    return xr.Dataset({**of_classes, **ends}, coords, data.attributes())


def test_show_says_what_holds_along_each_bracket():
    text = summary_lines(summarise({"": a_scan()}))
    row = text.index("  along the bracket:")
    assert text[row + 1 : row + 3] == [
        "    N = 1: equilibrium from 0 to 1, periodic from 2 to 3; back periodic throughout; "
        "bistable from 0.25 to 1.75 (end of the bracket)",
        "    N = 2: periodic throughout; back periodic throughout",
    ]
    many = xr.concat([a_scan()] * 5, "N").assign_coords(N=np.arange(10.0))
    assert "    and 2 more brackets" in summary_lines(summarise({"": many}))


@pytest.mark.parametrize("figure", [(), ("--figure", "curve")])
def test_a_figure_of_a_single_point_asks_for_an_axis(tmp_path, monkeypatch, figure):
    monkeypatch.chdir(tmp_path)
    a_scan(N=(1.0,), mu_k=((), 0.3, {"units": "1"})).to_netcdf("one.nc")
    with pytest.raises(UsageError, match=r"a single point.*\n.*under \[grid\]: mu_k"):
        run(plot_command, "one.nc", *figure)


def test_show_tells_few_points_one_by_one_each_answer_with_its_error():
    along, changes = ("N", "crossing"), [[1.5, 2.5], [np.nan, np.nan]]
    kinds = data.flags(
        along, [["to_unstable", "to_stable"], ["not_computed"] * 2], ("to_stable", "to_unstable")
    )
    known = {
        "status": data.statuses(("N",), ["ok", "ok"]),
        "reason": data.flags(("N",), ["none", "no_crossing"], ("none", "no_crossing")),
        "critical_value": (along, changes, {"units": "m s-1"}),
        "critical_error": (along, 0.01 * np.array(changes), {"units": "m s-1"}),
        "crossing_direction": kinds,
    }
    dataset = xr.Dataset(known, data.axes(N=[1.0, 2.0]), data.attributes())
    text = summary_lines(summarise({"": dataset}))
    row = text.index("  at each point:")
    assert [line.split() for line in text[row + 1 : row + 5]] == [
        ["N", "critical_value", "(m", "s-1)", "crossing_direction", "status"],
        ["1", "1.500", "±", "0.015", "to_unstable", "ok"],
        ["1", "2.500", "±", "0.025", "to_stable", "ok"],
        ["2", "ok,", "no_crossing"],
    ]
    many = xr.concat([dataset] * 20, "N").assign_coords(N=np.arange(40.0))
    assert "    and 16 more points" in summary_lines(summarise({"": many}))
    single = data.bifurcation()  # of one answer at each of 92 points
    assert summarise({"": single})["analyses"][""]["each_point"] == []
    some = summarise({"": single.isel(Omega=[0, 45])})["analyses"][""]["each_point"]
    assert [(one["Omega"], one["attractor"]) for one in some if one["initial"] == "near"] == [
        (0.5, "periodic"),
        (5.0, "equilibrium"),
    ]


def test_show_names_the_point_of_the_worst_value():
    dataset = data.bifurcation()
    residual = np.full((46, 2), 1e-12)
    residual[7, 1], residual[3, 0] = -3e-9, np.nan
    dataset["energy_residual"] = (("Omega", "initial"), residual, {"units": "1"})
    worst = summarise({"": dataset})["analyses"][""]["trust"]["energy_residual"]
    known = {"worst": 3e-9, "at": "Omega = 1.2, initial = far", "units": "1"}
    assert worst == known | {"without": 1, "of": 91}  # one of 92 points failed, one has no number
    text = "\n".join(summary_lines(summarise({"": dataset})))
    assert "3e-09 at Omega = 1.2, initial = far, no number at 1 of 91 points" in text
    dataset["energy_residual"][:] = np.nan
    text = "\n".join(summary_lines(summarise({"": dataset})))
    assert "energy_residual      no number at 91 of 91 points" in text


def test_show_as_json_is_plain_and_versioned(stored):
    import json

    summary = json.loads(run(show_command, "eigenvalues.nc", "--json").stdout)
    assert summary["schema"] == 1
    assert summary["analyses"][""]["axes"]["mu_k"]["last"] == 1.0


def test_show_refuses_what_is_no_dataset(stored):
    (stored / "broken.nc").write_bytes(b"nothing")
    with pytest.raises(InputError):
        run(show_command, "broken.nc")


def test_files_of_other_starts_are_not_called_by_a_setting_in_which_they_differ_too():
    made = []
    for name, kind, t_max in (("drawn", "random", 1e3), ("lattice", "state", 1e4)):
        asked = {"response": {"kind": "response", "settings": {"t_max": t_max}}}
        starts = {"starts_json": json.dumps({name: kind}), "analyses_json": json.dumps(asked)}
        made.append((name, data.bifurcation().assign_attrs(starts)))
    assert words.told_apart(made) == ["drawn", "lattice"]
    of_one = [(name, one.assign_attrs(starts_json="{}")) for name, one in made]
    assert words.told_apart(of_one) == ["t_max = 1000.0", "t_max = 10000.0"]


def test_a_dense_lattice_of_starts_has_no_seams_between_its_cells():
    plane = np.stack(np.meshgrid(np.linspace(-3, 3, 100), np.linspace(-3, 3, 90)), axis=-1)
    starts = plane.reshape(1, -1, 2)
    found = data.basin(count=starts.shape[1], speeds=(1.0,))
    found["initial_state"] = found["initial_state"].copy(data=starts)
    inside = np.hypot(*starts[0].T) < 1.0
    codes = found["attractor"].attrs["flag_values"]
    names = found["attractor"].attrs["flag_meanings"].split()
    told = [codes[names.index(name)] for name in ("equilibrium", "periodic")]
    found["attractor"] = found["attractor"].copy(data=np.where(inside, *told)[None])
    drawn = draw(found, figure("basin"))
    cells = [one for one in drawn.axes[0].collections if isinstance(one, PolyCollection)]
    sides = [np.ptp(path.vertices, axis=0) for one in cells for path in one.get_paths()]
    assert len(sides) == 9000 and np.allclose(sides, [6.0 / 99.0, 6.0 / 89.0])
    rows = as_csv(drawn, Path("a.csv")).splitlines()
    assert len(rows) == 9001  # each start once


def test_a_mark_of_one_gap_alone_is_drawn():
    classes = np.array(["periodic", "undecided", "periodic"], object)
    found = data.response(classes, np.array([1.0, np.nan, 1.0]), {"v": [0.0, 1.0, 2.0]})
    (ax,) = draw(found, figure("curve", variable="L_s")).axes
    (gap,) = [
        line for line in ax.lines if line.get_label() == "undecided" and len(line.get_xdata())
    ]
    assert gap.get_markevery() == [0] and gap.get_xdata().tolist() == [1.0]
    rows = np.full(400, "undecided", object)
    rows[:200] = "periodic"
    rows[250:298], rows[300:350] = "periodic", "periodic"  # between them two, near each other
    many = data.response(rows, np.where(rows == "periodic", 1.0, np.nan), {"v": np.arange(400.0)})
    (ax,) = draw(many, figure("curve", variable="L_s")).axes
    (gap,) = [
        line for line in ax.lines if line.get_label() == "undecided" and len(line.get_xdata())
    ]
    marked = gap.get_xdata()[gap.get_markevery()]
    assert 20 < len(marked) < 50 and {200.0, 249.0, 298.0, 299.0, 350.0, 399.0} <= {*marked}


def test_a_map_of_one_of_several_crossings_is_the_one_that_the_case_asks_for():
    critical = data.crossings().expand_dims(c=[1.0, 2.0])
    asked = figure("map", variable="critical_value", select={"crossing": 0})
    assert drawing.possible_figures(critical.assign_attrs(data.attributes(asked))) == [asked]
    assert "map" not in [one.kind for one in default_figures(critical)]


def test_a_branch_is_round_at_its_folds():
    """Through its points, and between them nearer to what it is than the chords."""
    fold = np.linspace(-1.0, 1.0, 9)
    x, y = smooth.along(fold**2, fold)
    assert np.isin(fold, y).all() and x.size > 4 * fold.size
    chords = np.interp(y, fold, fold**2)
    inner = np.abs(y) < 0.75  # at its ends a spline knows one side alone
    assert np.abs(x - y**2).max() < 0.5 * np.abs(chords - y**2).max()
    assert np.abs(x - y**2)[inner].max() < 0.25 * np.abs(chords - y**2)[inner].max()
    steep = np.array([0.0, 1e-9, 1e-9, 3e-9, 2e-9, 1e-9, 1.0])  # as of a branch that stands upright
    heights = np.array([0.0, 1.0, 2.0, 2.5, 2.8, 2.87, 2.871])
    _, drawn = smooth.along(steep + 1e-12 * np.arange(7), heights)
    assert (np.diff(drawn) >= 0.0).all() and drawn.max() == heights.max()
    gap = np.where(fold == 0.0, np.nan, fold)
    for line in (gap, fold[[0, 0, *range(1, 9)]]):  # nor where two are at one place
        np.testing.assert_array_equal(smooth.along(line, line)[0], line)


def test_a_table_has_the_points_of_a_branch_that_is_drawn_smooth():
    fold = np.linspace(-1.0, 1.0, 9)
    figure_ = Figure()
    ax = figure_.subplots()
    smooth.draw(ax, fold**2, fold, "_stable", color="k", ls="--")
    hidden, shown = ax.lines
    assert not hidden.get_visible() and len(shown.get_xdata()) > 4 * fold.size
    rows = [row.split(",") for row in as_csv(figure_, Path("a.csv")).splitlines()[1:]]
    assert [float(row[7]) for row in rows] == fold.tolist()
    assert {row[4] for row in rows} == {"stable"}


def test_spectra_of_a_few_points_are_lines_unless_an_axis_is_asked_for():
    few = data.spectra(labels=("far",), points=2)
    (ax,) = draw(few, figure("spectrum")).axes
    assert not ax.findobj(QuadMesh) and ax.get_xlabel().startswith("$f$")
    axis = str(few["status"].dims[0])
    assert draw(few, figure("spectrum", x=axis)).axes[0].findobj(QuadMesh)


def test_figures_that_select_another_motion_are_not_drawn_of_this_one():
    asked = [
        figure("history", select={"v": 9.01}),
        figure("phase", select={"v": 9.0, "initial": ["near", "other"]}),
        figure("phase", select={"initial": "other"}),
    ]
    one = data.history(labels=("near",)).expand_dims(v=[9.0]).assign_attrs(data.attributes(*asked))
    assert drawing.possible_figures(one) == asked[1:2]


def test_an_end_that_is_an_edge_of_the_bracket_has_no_error_and_is_told():
    """A branch may go on beyond: its edge, off by 0, stood as an end in a figure."""
    found = data.response(np.full(4, "periodic"), np.ones(4), {"v": np.arange(4.0)})
    kinds = np.array(["bracket", "grazing", "grazing", "grazing"])
    found["cycle_highest"] = ("v", [16.0, 9.0, 8.0, 7.0], {"units": "m s-1"})
    found["cycle_highest_error"] = ("v", [0.0, 0.1, 0.1, 0.1], {"units": "m s-1"})
    found["cycle_highest_kind"] = data.flags(("v",), kinds, ("grazing", "bracket"))
    drawn = draw(found, figure("curve", variable="cycle_highest"))
    assert marks(drawn.axes[0], "_error not known").tolist() == [[0.0, 16.0]]
    assert style.notes_on(drawn) == [
        "cycle_highest: 1 of them an edge of the bracket, beyond which it may go on: widen it"
    ]
    told = "\n".join(summary_lines(summarise({"": found})))
    assert "(at 1 of 4 the bracket's edge: it may go on beyond)" in told


def test_words_of_ones_own_leave_the_names_of_files_as_they_were_given():
    one = crossing_lines(a=(0.0, 1.0))
    named = [(name, one.assign_attrs(called=name)) for name in ("slow cycle", "fast cycle")]
    named[1] = (named[1][0], named[1][1].assign(L_s=one["L_s"] + 1.0))
    words_ = {"cycle": "orbit", "$L_s$": "strength"}
    (ax,) = draw(named, figure("curve", variable="L_s", words=words_)).axes
    assert legend_texts(ax) == ["slow cycle", "fast cycle"]
    assert ax.get_ylabel().startswith("strength")


def test_only_variables_that_are_shares_of_one_thing_are_called_by_what_they_share():
    def called(*told):
        names = ((name, {"long_name": words, "units": unit}) for name, words, unit in told)
        return words.shared_label([xr.DataArray(0.0, name=name, attrs=own) for name, own in names])

    shares = [(f"{kind}_fraction", f"share of time in {kind}", "1") for kind in ("stick", "slip")]
    assert called(*shares) == "share of time"
    work = "work of friction on the model, over"
    of_work = [
        ("friction_work", f"{work} a period", "J"),
        ("section_work", f"{work} a return", "J"),
    ]
    assert called(*of_work) == "friction work, section work (J)"


def test_a_path_that_comes_back_to_where_it_rests_is_looked_at_once_each_visit():
    """Of its many instants near the start one is tried; it retraces itself from its period on."""
    time = np.linspace(0.0, 60.0, 40_001)
    pulse = np.where(time % 20.0 < 5.0, np.sin(np.pi * (time % 20.0) / 5.0) ** 2, 0.0)
    path = phase._Path(time, np.column_stack([pulse, np.gradient(pulse, time)]), False, False)
    assert 5.0 <= path.once_around() <= 20.0 + 0.01


def test_a_curve_is_narrowed_to_a_class():
    classes = np.array(["periodic", "chaotic", "periodic", "equilibrium"], object)
    found = data.response(classes, np.arange(1.0, 5.0), {"v": np.arange(4.0)})
    chosen = figure("curve", variable="L_s", select={"attractor": ["periodic", "chaotic"]})
    (ax,) = draw(found, chosen).axes
    assert np.nanmax(np.concatenate([line.get_ydata() for line in ax.lines])) == 3.0
    found["attractor"][1] = data.codes(data.ATTRACTORS, "undecided")
    assert not draw(found, chosen).axes[0].get_legend()  # it is of neither class, and no gap
    failed = found.copy(deep=True)
    failed["attractor"][2] = data.codes(data.ATTRACTORS, "not_computed")
    failed["status"][2] = data.codes(data.STATUS, "failed")
    assert legend_texts(draw(failed, chosen).axes[0]) == ["failed"]  # it may be of one of them
    assert "undecided" in legend_texts(draw(found, figure("curve", variable="L_s")).axes[0])
    wrong = figure("curve", variable="L_s", select={"attractor": "periodc"})
    with pytest.raises(UsageError, match="attractor = periodc: no such class"):
        draw(found, wrong)


def test_levels_are_written_with_exponents_where_one_of_them_is():
    assert words.number_text(1e-4, [1e-5, 1e-4]) == "$10^{-4}$"
    assert words.number_text(2.5e-4, [1e-5]) == r"$2.5 \times 10^{-4}$"
    assert [words.number_text(one, [1e-4, 0.0]) for one in (1e-4, 0.0)] == ["0.0001", "0"]
    dataset = data.stability_map(initial=("reached",), nx=96, ny=97)
    drawn = draw(dataset, figure("map", variable="L_s", level=[5e-5, 1e-3]))
    assert r"$L_s$ = $5 \times 10^{-5}$ rad$^{2}$" in legend_texts(drawn)
    assert r"$L_s$ = $10^{-3}$ rad$^{2}$" in legend_texts(drawn)
