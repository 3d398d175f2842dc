"""Maps, drawn from small datasets: classes, numbers, lines at levels and of other cases."""

import csv
import json
from itertools import combinations
from pathlib import Path
from types import SimpleNamespace

import matplotlib as mpl
import numpy as np
import pytest
import synthetic_datasets as data
import xarray as xr
from click.testing import CliRunner
from matplotlib import colormaps
from matplotlib.collections import QuadMesh
from matplotlib.colors import BoundaryNorm, LogNorm, Normalize, to_hex
from matplotlib.contour import ContourSet
from matplotlib.figure import Figure
from matplotlib.legend import Legend
from matplotlib.text import Annotation
from plotted import corners, figure, legend_texts, marks, run

from fiv_cli import api
from fiv_cli.case.case import FigureSpec
from fiv_cli.cli.main import run as fiv
from fiv_cli.cli.plot import command as plot_command
from fiv_cli.errors import EmptyFigureError, UsageError
from fiv_cli.plots import draw, legends, levels, look_of, points, save, style
from fiv_cli.plots import labels as words
from fiv_cli.plots.critical_lines import _is_inside
from fiv_cli.plots.drawing import _meant
from fiv_cli.plots.drawn import as_csv, in_one_line
from fiv_cli.plots.levels import MOST_WRITTEN
from fiv_cli.plots.map import _of_both_signs, _told_twice
from fiv_cli.plots.style import BLACK, line_colours
from fiv_cli.reading.datasets import is_class


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
    assert drawn.axes[-1].get_ylabel() == "$L_s$ ($10^{-3}$ rad$^{2}$)"
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
    mesh, below = (c for c in drawn.axes[1].collections if isinstance(c, QuadMesh))
    least, greatest = (float(end) for end in mesh.get_clim())
    assert isinstance(mesh.norm, LogNorm) and 0.0 < least < greatest
    assert greatest == float(numbers.where(numbers > 0.0).max())
    assert to_hex(below.cmap(0)) == "#dddddd" and below.get_array().count() == numbers[0, :, 1].size
    assert legend_texts(drawn)[0] == ("$L_s$ = 0" if still == 0.0 else r"$L_s$ $\leq$ 0")
    dataset["L_s"] = 0.0 * numbers
    (mesh, *_) = draw(dataset, figure("map", variable="L_s", log="z")).axes[0].collections
    assert not isinstance(mesh.norm, LogNorm)


def test_what_is_undecided_below_the_shades_has_not_that_of_their_end():
    """A logarithm has none for it, but that of zero; of numbers the end of the bar tells it."""
    dataset = data.stability_map()
    dataset["reason"] = data.flags(
        dataset["status"].dims,
        np.where(dataset["attractor"] == dataset["attractor"][0, 0], "time_budget", "none"),
        ("none", "time_budget"),
    )
    dataset["L_s"][0, 0] = 1e-12
    for settings, count in (({"log": "z"}, 1), ({}, 0), ({"log": "z", "zlim": [1e-13, 1.0]}, 0)):
        drawn = draw(dataset, figure("map", variable="L_s", **settings))
        mesh = next(c for c in drawn.axes[0].collections if isinstance(c, QuadMesh))
        shown = np.ma.filled(mesh.get_array().astype(float), np.nan)
        assert int(np.isnan(shown[0, 0])) == count
        assert ("no value: not reached, undecided" in legend_texts(drawn)) == bool(count)


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


@pytest.mark.parametrize(
    ("reason", "chosen", "is_settled"),
    [
        ("section_drifts", True, False),
        ("no_section_points", True, False),
        ("no_section_points", False, True),  # of a section that the case names, it may be anything
        ("tests_disagree", True, True),
    ],
)
def test_which_undecided_motions_have_numbers_for_lines(reason, chosen, is_settled):
    dataset = data.stability_map(initial=("reached",), nx=20, ny=20)
    undecided = np.zeros(dataset["L_s"].shape, bool)
    undecided[8:12, 8:12] = True
    told = np.where(undecided, reason, "none").astype(object)
    dataset["reason"] = data.flags(dataset["L_s"].dims, told, {"none": 0, reason: 1})
    code = data.codes(data.ATTRACTORS, "undecided")
    dataset["attractor"] = dataset["attractor"].where(~undecided, code)
    dataset["L_s"] = dataset["L_s"].copy(data=np.where(undecided, 2.0, 1e-3))
    if chosen:
        dataset["section_kind"] = dataset["status"] * 0
    drawn = draw(dataset, figure("map", variable="L_s", level=1.0))
    assert bool(drawn.findobj(ContourSet)) == is_settled
    told = [note for note in style.notes_on(drawn) if note.startswith("no line")]
    assert [note.endswith("(at most 0.001), as far as points are decided") for note in told] == (
        [] if is_settled else [True]
    )


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
    """Along their lines; of a line that is too short, upright beside it, with a stroke to it."""
    dataset = data.stability_map()
    asked = figure("map", variable="L_s", level=[0.0005 + more, 0.001])
    drawn = draw(dataset, asked, look=look_of("paper", width=width))
    turned = [text.get_rotation() != 0.0 for text in drawn.axes[0].texts]
    assert turned and any(turned) == is_on_its_line
    feet = [text.xy for text in drawn.axes[0].texts if isinstance(text, Annotation)]
    (lines,) = drawn.findobj(ContourSet)[:1]
    pieces = [piece for own in lines.allsegs for piece in own]
    at = np.linspace(0.0, 1.0, 999)
    dense = [
        np.transpose([np.interp(at, np.linspace(0.0, 1.0, len(one)), w) for w in one.T])
        for one in pieces
    ]
    on_it = np.concatenate(dense)
    assert bool(feet) != is_on_its_line
    assert all(np.abs(on_it - foot).max(axis=1).min() < 0.1 for foot in feet)
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
    assert bar.get_ylabel() == "index ($10^{-3}$)"
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
    for row, rests in enumerate([1, 1, 1, 1, 1, 1, 7, 7, 7, 7, 7, 7]):
        classes[row, :rests] = "equilibrium"
    axes = data.axes(Omega=np.arange(12.0), initial=[f"far-{n:03d}" for n in range(8)])
    dataset = data.response(classes, np.ones(classes.shape), axes)
    share = {"what": "share", "of": "periodic", "over": ["initial"]}
    (ax,) = draw(dataset, figure("curve", x="Omega", variable="attractor", take=share)).axes
    (line,) = [line for line in ax.lines if len(line.get_xdata()) > 1]
    assert np.isfinite(line.get_ydata()).all() and line.get_ydata()[[5, 6]].tolist() == [
        0.875,
        0.125,
    ]


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
    assert ((shown >= 1e-4) & (shown <= 1e-2) | np.isnan(shown)).all()
    assert np.isnan(shown[0, 0]) == bool(log) and mesh.colorbar.extend == "both"
    below = mesh.colorbar.cmap.get_under()  # what the arrow has, as all between 0 and the bar
    assert to_hex(below) == to_hex(mesh.to_rgba(1e-4))


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
        notes = [note for note in style.notes_on(drawn) if "points that were filled in" in note]
        assert len(notes) == unknown
        at_rest = [
            note
            for note in style.notes_on(drawn)
            if note.startswith("L_s is 0 at rests that were filled in (1)")
        ]
        assert len(at_rest) == (not unknown)


def test_levels_that_none_reaches_are_told_together_and_alone_make_no_figure():
    dataset = data.stability_map(initial=("reached",))
    asked = figure("map", variable="L_s", level=[1.0, 2.0])
    (note,) = [one for one in style.notes_on(draw(dataset, asked)) if one.startswith("no line")]
    assert note.startswith("no line $L_s$ = 1, 2 rad$^{2}$: below everywhere (at most 0.0")
    with pytest.raises(EmptyFigureError, match="below everywhere"):
        draw(dataset, figure("map", variable="L_s", level=[1.0, 2.0], overlay=True))


def test_a_level_is_written_again_far_along_a_long_line():
    """Whose branches lie apart: one of them had but its dashes to tell it by."""
    dataset = data.stability_map(initial=("reached",), nx=61, ny=61)
    x, y = np.meshgrid(np.linspace(-1.0, 1.0, 61), np.linspace(0.0, 1.0, 61), indexing="ij")
    dataset["L_s"].values[:] = (y - 0.05 - 0.9 * np.abs(x) + 2.0)[..., None]
    drawn = draw(dataset, figure("map", variable="L_s", level=[2.0, 9.0], overlay=True))
    places = sorted(text.get_position()[0] for text in drawn.axes[0].texts)
    middle = float(dataset["Omega"].mean())
    assert len(places) > 1 and places[0] < middle < places[-1]


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


@pytest.mark.parametrize("sign", [-1.0, 1.0])
def test_a_plain_at_a_level_has_no_line_through_it(sign):
    """Nor along it, from whichever side it falls to it; a little aside there is one."""
    dataset = data.stability_map(initial=("reached",), nx=12, ny=9)
    x = dataset["Omega"] + 0.0 * dataset["L_s"]
    sloped = sign * (x - x.values[..., 5, :].max()).clip(max=0.0)
    mapped = dataset.assign(L_s=sloped.transpose(*dataset["L_s"].dims).assign_attrs(units="rad2"))
    for level, is_drawn in ((0.0, False), (-sign * 0.2, True)):
        drawn = draw(mapped, figure("map", variable="L_s", level=level))
        assert bool(drawn.findobj(ContourSet)) == is_drawn


def test_a_level_without_a_line_has_no_entry_in_the_legend():
    levels = {"variable": "L_s", "level": [1e-3, 1.0]}
    drawn = draw(data.stability_map(), figure("map", **levels))
    told = [text for text in legend_texts(drawn) if text.startswith("$L_s$")]
    assert told == ["$L_s$ = 0.001 rad$^{2}$"]
    assert "no line $L_s$ = 1 " in drawn.get_suptitle()


@pytest.mark.parametrize("level", [-1e-3, 1e-3])
def test_a_level_is_written_with_a_white_rim(level):
    """A box would hide what lies around its letters."""
    dataset = data.stability_map(initial=("reached",), nx=60, ny=60)
    dataset["L_s"] = np.sign(level) * dataset["L_s"]
    (ax, *_) = draw(dataset, figure("map", variable="L_s", level=level)).axes
    assert {one.get_text() for one in ax.texts} == {words.number_text(level)}
    assert {one.get_bbox_patch() for one in ax.texts} == {None}
    assert all(one.get_path_effects() for one in ax.texts)


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
    for level in ([5e-4], [1e-3], [5e-4, 1e-3], [-1e-4, 5e-4, 1e-3], [-1e-4, 0.0, 5e-4, 1e-3]):
        drawn = draw(dataset, figure("map", variable="L_s", level=level, overlay=overlay))
        at_rest = [
            one for one in style.notes_on(drawn) if one.endswith("at least so much everywhere")
        ]
        for lines in drawn.findobj(ContourSet):
            x, y = np.concatenate(lines.allsegs[0]).T
            key = len(level), float(lines.levels[0])
            along_the_jump[key] = np.count_nonzero(abs(y / x - 10.0) < 0.5)
    assert along_the_jump[1, 5e-4] > 20 and along_the_jump[1, 1e-3] > 20
    for count in (2, 3, 4):  # one on the other side of rest is another border, one at rest none
        assert along_the_jump[count, 5e-4] > 20 and along_the_jump[count, 1e-3] < 5
    assert len(at_rest) == 1 and "= 0 rad" in at_rest[0]  # of the last
    drawn = draw(dataset, figure("map", variable="L_s", level=[1e-6, 2e-5], overlay=overlay))
    assert any("it lies in the jump" in note for note in style.notes_on(drawn))


@pytest.mark.parametrize("overlay", [False, True])
def test_in_a_jump_to_rest_a_level_lies_half_way(overlay):
    """Read between 0 and what vibrates it would lie beside the point that rests."""
    dataset = data.stability_map(initial=("reached",), nx=31, ny=31)
    drawn = draw(dataset, figure("map", variable="L_s", level=1e-6, overlay=overlay))
    corners = on_the_lines(drawn)
    axes = (dataset["Omega"].values, dataset["N0"].values)
    halves = (
        np.transpose(
            [
                (own - axis[0]) / (axis[1] - axis[0])
                for own, axis in zip(corners.T, axes, strict=True)
            ]
        )
        * 2.0
    )  # steps of half the grid's
    cut = abs(halves - halves.round()).max(axis=1) > 1e-5  # on both sides of the level
    assert len(halves) > 20 and cut.sum() <= 2
    assert (halves[~cut].round() % 2).any(axis=1).all()  # none lies on a point of the grid
    asked = figure("map", variable="L_s", level=1e-6, border=False, overlay=overlay)
    if overlay:
        with pytest.raises(EmptyFigureError, match="which border = false leaves out"):
            draw(dataset, asked)
    else:
        assert not draw(dataset, asked).findobj(ContourSet)


def test_a_level_at_rest_has_a_line_where_what_moves_passes_it_alone():
    """A difference of two starts that changes its sign along x = 4, and is 0 where both rest."""
    dataset = data.stability_map(nx=31, ny=31)
    x, y = (dataset[name].values for name in ("Omega", "N0"))
    rests = np.add.outer(x / x.max(), y / y.max()) > 1.2
    dataset["attractor"].values[:] = np.where(rests, 0, 1)[..., None]  # equilibrium, periodic
    dataset["status"].values[:] = dataset["status"].values[0, 0, 0]
    dataset["L_s"].values[:] = np.where(rests, 0.0, 1.0)[..., None]
    dataset["L_s"].values[..., 1] += np.where(rests, 0.0, 0.1 * (x - 4.0)[:, None])
    take = {"what": "difference", "over": ["initial"]}
    corners = on_the_lines(draw(dataset, figure("map", variable="L_s", take=take, level=0.0)))
    assert len(corners) > 10 and corners[:, 0] == pytest.approx(4.0)


def test_that_a_line_leads_along_a_jump_is_told_where_it_is_no_border_as_a_whole():
    dataset = data.stability_map(initial=("reached",), nx=31, ny=31)
    told = "along a jump to rest the line is the border, half-way between the points"
    ended = " (border = false: all end there)"
    others = f"; no other line leads along it{ended}"
    for level, ending in ((1e-6, None), (5e-4, ended), ([5e-4, 1e-3], others)):
        drawn = draw(dataset, figure("map", variable="L_s", level=level))
        notes = [note.partition(": ")[2] for note in style.notes_on(drawn) if told in note]
        assert notes == ([] if ending is None else [f"{told}{ending}"])


def test_shades_of_what_rests_alone_are_those_of_what_is_undecided():
    dataset = data.stability_map(initial=("reached",), nx=8, ny=8)
    moving = dataset["L_s"].values > 0.0
    dataset["reason"] = dataset["status"].copy(data=np.zeros(dataset["status"].shape, np.int8))
    dataset["reason"].attrs = {"flag_values": [0, 1], "flag_meanings": "none time_budget"}
    dataset["reason"].values[moving] = 1
    (mesh,) = draw(dataset, figure("map", variable="L_s")).axes[0].findobj(QuadMesh)
    assert mesh.get_clim() == pytest.approx((0.0, dataset["L_s"].values[moving].max()))


def test_no_level_of_a_difference_follows_a_jump_but_the_one_next_to_none():
    """Two starts of which both, one, or none vibrate: the border between the first two, y = 10 x,
    has no line, that between the last two, y = 5 x, one of the level next to zero."""
    dataset = data.stability_map(nx=96, ny=97)
    dataset["L_s"] = dataset["L_s"] * xr.DataArray([1.0, 2.0], dims="initial")
    take = {"what": "difference", "over": ["initial"]}
    drawn = draw(dataset, figure("map", variable="L_s", take=take, level=[5e-4, 1e-3, 2e-3]))
    along = {}
    for lines in drawn.findobj(ContourSet):
        x, y = np.concatenate(lines.allsegs[0]).T
        counts = [np.count_nonzero(abs(y / x - slope) < 0.05 * slope) for slope in (5.0, 10.0)]
        along[float(lines.levels[0])] = counts
    assert along[5e-4][0] > 20
    assert all(max(counts) < 5 for level, counts in along.items() if level > 5e-4)


def test_no_level_of_a_spread_leads_along_a_jump_without_a_border():
    """It did on both sides of where one of two starts vibrates, unlike that of a difference."""
    dataset = data.stability_map(nx=96, ny=97)
    dataset["L_s"] = dataset["L_s"] * xr.DataArray([1.0, 2.0], dims="initial")
    take = {"what": "spread", "over": ["initial"]}
    asked = {"variable": "L_s", "take": take, "level": [5e-4, 1e-3], "border": False}
    for lines in draw(dataset, figure("map", **asked)).findobj(ContourSet):
        x, y = np.concatenate([np.zeros((0, 2)), *lines.allsegs[0]]).T
        assert np.count_nonzero(abs(y / x - 5.0) < 0.25) < 5


def test_a_level_is_not_written_over_its_whole_line():
    """It stood there without a line, and the legend promised a dashed one."""
    array = xr.DataArray(np.zeros((2, 2)), dims=("a", "b"), name="L_s", attrs={"units": "m"})
    for width, is_written in ((0.3, True), (0.04, False)):
        ax = Figure(figsize=(6.4, 4.0)).add_subplot(xlim=(0.0, 1.0), ylim=(0.0, 1.0))
        places = 0.5 + width * np.array([-0.5, 0.5]), np.array([0.2, 0.8])
        plane = np.array([[[0.0, 0.0], [4.0, 4.0]]])
        with mpl.rc_context({"legend.fontsize": 8.0}):
            levels.draw(ax, array, places, [[plane]], [2.0], "black")
        (text,) = ax.texts
        assert isinstance(text, Annotation) != is_written  # else beside, with a stroke
        if not is_written:  # which does not look like a bend at the end of the line
            assert abs(text.xy[0] - 0.5) < 0.3 * width


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


@pytest.mark.parametrize("overlay", [False, True])
@pytest.mark.parametrize("shape", ["line", "ring"])
def test_a_dashed_line_begins_on_both_sides_of_its_level(shape, overlay):
    """A part of a dash beside a figure looks like a point of it; it loses nothing else."""
    dataset = data.stability_map(initial=("reached",), nx=31, ny=31)
    x, y = np.meshgrid(np.linspace(-1.0, 1.0, 31), np.linspace(-1.0, 1.0, 31), indexing="ij")
    values = {"line": x + 0.3 * y + 2.0, "ring": np.hypot(x, y) + 0.5}[shape]
    dataset["L_s"].values[:] = values[..., None]
    asked = figure("map", variable="L_s", level=[1.0, 1.2, 2.2], overlay=overlay)
    ax = draw(dataset, asked, look=look_of("paper", width=85.0)).axes[0]
    assert len(ax.texts) >= (3 if shape == "line" else 2)
    pieces = [one for lines in ax.findobj(ContourSet) for own in lines.allsegs for one in own]
    for text in ax.texts:
        written = ax.transData.transform(text.get_position())
        pixels = [ax.transData.transform(one) for one in pieces]
        starts = np.sort([np.linalg.norm(one[0] - written) for one in pixels])
        nearest = min(np.linalg.norm(one - written, axis=1).min() for one in pixels)
        assert starts[1] == pytest.approx(starts[0], rel=0.1)
        assert nearest == pytest.approx(starts[0])
        text.set_rotation(0.0)
        box = text.get_window_extent()
        assert 0.5 * box.width < starts[0] < 0.5 * (box.width + box.height)
    rows = [*csv.DictReader(as_csv(ax.figure, Path("a.csv")).splitlines())]
    for number in {row["line"] for row in rows}:  # the table has what is hidden beneath, too
        told = [[float(row[w]) for w in "xy"] for row in rows if row["line"] == number]
        steps = np.diff(told, axis=0) / [np.diff(dataset[w].values)[0] for w in ("Omega", "N0")]
        assert np.abs(steps).max(initial=0.0) < 1.01


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
    level = {"L_s": [0.001, 0.002], "whole:critical_value": "N0"}
    asked = figure("map", variable="L_s", x="Omega", y="N0", level=level, overlay=True)
    (ax,) = draw(response, asked).axes  # levels on white, and what another case found
    (line,) = [one for one in ax.lines if "critical value" in str(one.get_label())]
    assert line.get_ydata().tolist() == (4.0 * many).tolist()
    assert "critical value of $N_{0}$" in legend_texts(ax.figure)
    level = {"whole:critical_value": "N0", "few:critical_value": "N0"}
    of_both = [response, figure("map", x="Omega", y="N0", level=level)]
    keys = [text for text in legend_texts(draw(*of_both)) if "critical" in text]
    assert keys == [f"critical value of $N_{{0}}$, {name}" for name in ("whole", "few")]
    of_both[1] = figure("map", x="Omega", y="N0", level=level, words={"few:critical_value": "mine"})
    mine = legend_texts(draw(*of_both))
    assert {"critical value of $N_{0}$, whole", "mine"} <= {*mine}
    for name in ("one", "two"):  # levels of two cases: the word of the map's own variable stays
        response.to_netcdf(f"runs/{name}.nc")
    level = {"one:L_s": 1e-3, "two:L_s": 2e-3}
    asked = figure("map", x="Omega", y="N0", variable="L_s", level=level, words={"L_s": "mine"})
    assert draw(response, asked).axes[-1].get_ylabel().startswith("mine")
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
    assert len(islands.findobj(ContourSet)[0].allsegs[0]) == 19  # the 18th is cut on its far side
    assert len(islands.texts) == 1
    several = draw(dataset.isel(initial=[0]), figure("map", variable="L_s", level=[-0.5, 0.5]))
    told = [one.get_text() for one in several.axes[0].texts]
    assert all(1 <= told.count(level) <= MOST_WRITTEN for level in ("−0.5", "0.5"))


def test_a_map_without_a_line_at_the_level_says_on_which_side_it_lies():
    dataset = data.stability_map()
    dataset["L_s"][:, :, 0] = 1.0
    dataset["L_s"][:, :, 1] = 0.0
    with pytest.raises(EmptyFigureError, match=r"0.5 .*: above everywhere or below everywhere"):
        draw(dataset, figure("map", variable="L_s", level=0.5, overlay=True))
    one_of_two = dataset.copy(deep=True)
    one_of_two["L_s"][:9, :, 1] = 1.0
    drawn = draw(one_of_two, figure("map", variable="L_s", level=0.5, overlay=True))
    assert legend_texts(drawn)[:2] == ["reached, above everywhere", "exists"]
    lines = figure("map", variable="L_s", level=[0.5, 2.0])
    reason = "no line $L_s$ = 2 rad$^{2}$: below everywhere (at most 1)"
    assert draw(dataset, lines).get_suptitle().endswith(f"\n{reason}")
    dataset["L_s"][:] = np.nan
    with pytest.raises(EmptyFigureError, match="not known"):
        draw(dataset, figure("map", variable="L_s", level=0.5, overlay=True))
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
    notes = style.notes_on(draw(dataset, figure("map", variable="L_s", level=[0.5, 2.0])))
    told = "along a jump to rest", "too short a line for its number"  # around what is not known
    (note,) = [one for one in notes if not any(word in one for word in told)]
    assert note.startswith("no line $L_s$ = 2 rad$^{2}$: where it is passed no three neighbours")


def test_pieces_of_lines_that_have_no_room_for_their_number_are_told():
    """One in a corner had neither number nor dashes that the legend could tell it by."""
    dataset = data.stability_map(initial=("reached",), nx=60, ny=60)
    rising = np.linspace(0.0, 1.0, 60) * np.ones((60, 1))
    moving = dataset["L_s"].copy(data=rising[:, :, None])
    kinds = dataset["attractor"].copy(data=np.full(moving.shape, 1))
    asked, told = (
        figure("map", variable="L_s", level=[0.3, 0.5]),
        "too short a line for its number",
    )
    for corner, beside, left in ((0.4, ["0.3"], 0), (0.6, ["0.3"], 1)):  # one has no room
        moving[:2, 0] = corner
        drawn = draw(dataset.assign(L_s=moving, attractor=kinds), asked)
        assert [one.get_text() for one in drawn.findobj(Annotation)] == beside
        assert len([one for one in style.notes_on(drawn) if told in one]) == left


def test_many_pieces_without_a_number_are_told_in_one_note():
    """Forty were as many notes."""
    dataset = data.stability_map(initial=("reached",), nx=120, ny=120)
    rising = np.linspace(0.0, 1.0, 120) * np.ones((120, 1))
    moving = dataset["L_s"].copy(data=rising[:, :, None])
    moving[5:115:10, 5:35:10] = 0.8
    kinds = dataset["attractor"].copy(data=np.full(moving.shape, 1))
    asked = figure("map", variable="L_s", level=[0.6, 0.7])
    notes = style.notes_on(draw(dataset.assign(L_s=moving, attractor=kinds), asked))
    told = [one for one in notes if "too short a line for its number at (" in one]
    assert len(told) == 2 and all("29 more places" in one for one in told)


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
    *notes, caption = style.notes_on(draw(dataset, close, look=look_of("paper", width=50.0)))
    assert caption.startswith("for the caption: start: ")
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
    assert note.startswith("L_s = 0.31 rad") and "its line has gaps" in note
    along = np.linspace(0.0, 1.0, 20)
    dataset["L_s"].values[:] = (along[:, None] + along)[..., None]
    dataset["L_s"].values[4, 8] = np.nan  # alone, across the corner of which the line would lead
    dataset["attractor"].values[:] = data.codes(data.ATTRACTORS, "periodic")
    slanted = figure("map", variable="L_s", level=[12.01 / 19.0, 1.5], overlay=overlay)
    assert style.notes_on(draw(dataset, slanted)) == []
    dataset["attractor"].values[4, 8] = undecided
    (note,) = style.notes_on(draw(dataset, slanted))
    assert note.startswith("L_s = 0.63") and "its line has gaps" in note


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
        (key,) = [one for one in told_patches(ax.figure) if one.get_label() == "undecided"]
        assert (key.get_edgecolor()[:3] == (0.0, 0.0, 0.0)) == (marked and lines)


def told_patches(drawn):
    """The patches in the legends of a figure."""
    return [one for legend in drawn.findobj(Legend) for one in legend.get_patches()]


def test_a_few_values_far_from_even_have_a_tick_each():
    """Where cells end half-way, nothing else shows where anything was computed."""
    whole = data.stability_map(initial=("reached",), nx=21)
    for chosen, told in (([0, 2, 3, 20], True), ([0, 5, 10, 15], False)):
        some = whole.isel(Omega=chosen)
        ax = draw(some, figure("map", x="Omega", y="N0", variable="attractor")).axes[0]
        assert np.array_equal(ax.get_xticks(), some["Omega"]) == told


def test_a_level_that_no_line_has_is_told_also_where_a_figure_has_no_title(stored):
    asked = figure("map", variable="L_s", level=[5e-4, 2.0])
    data.stability_map().assign_attrs(data.attributes(asked)).to_netcdf("a.nc")
    result = run(plot_command, "a.nc", "--style", "paper", "-o", "a.png")
    assert "no line L_s = 2 rad^2: below everywhere" in result.stderr


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        ({"variable": "L_s"}, "no level of L_s says which"),
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


def test_a_short_piece_of_a_dashed_line_shows_its_dashes(monkeypatch):
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
    (short,) = dashed.allsegs[1]
    pixels = drawn.axes[0].transData.transform(short)
    length = np.linalg.norm(np.diff(pixels, axis=0), axis=1).sum()
    assert length * 72.0 / drawn.dpi == pytest.approx(1.6 * periods[1], rel=0.02)
    monkeypatch.setattr(levels, "_begin_beside", lambda ax, lines, text: None)
    uncut = draw(dataset, figure("map", variable="L_s", x="Omega", y="N0", level=[1.2, 1.95]))
    assert as_csv(drawn, Path("a.csv")) == as_csv(uncut, Path("a.csv"))
    assert sum("1.95" in row for row in as_csv(drawn, Path("a.csv")).splitlines()) >= len(short)


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


def test_levels_over_classes_have_their_numbers_where_these_tell_of_which_variable():
    """Dashes alone told four levels; and the border, dashed too, was hard to tell from them."""
    found, several = {"growth_rate": [0.0, 1.0]}, {"growth_rate": [0.0, 1.0], "L_s": [1e-3]}
    for asked, told in ((found, {"0", "1"}), (several, set())):
        drawn = draw(with_growth(), figure("map", variable="attractor", level=asked))
        written = {text.get_text() for ax in drawn.axes for text in ax.texts}
        assert written == told


def test_numbers_of_both_signs_and_differences_have_shades_that_part_at_zero():
    dataset = data.stability_map(initial=("reached",))
    dataset["L_s"] -= 1e-3
    taken = {"what": "difference", "over": ["initial"]}
    several = data.stability_map()
    for of, settings in ((dataset, {}), (several, {"take": taken})):
        drawn = draw(of, figure("map", variable="L_s", **settings))
        (mesh,) = drawn.axes[0].findobj(QuadMesh)
        ends = np.array([mesh.norm.vmin, mesh.norm.vmax])
        for value in (0.0, *ends, 0.5 * ends.max()):
            off = value / np.abs(ends).max()  # the least beside zero is told from it
            share = 0.5 + 0.5 * np.sign(off) * (0.25 + 0.75 * abs(off))
            np.testing.assert_allclose(mesh.to_rgba(value), colormaps["PRGn"](share), atol=0.02)
    near = dataset.assign(L_s=dataset["L_s"].copy(deep=True))
    near["L_s"][0, 0] = np.abs(near["L_s"]).max() * 1e-5  # no zero, whose shade it had
    drawn = draw(near, figure("map", variable="L_s"))
    shade = drawn.findobj(QuadMesh)[0]
    shown = {to_hex(one) for one in shade.to_rgba(shade.get_array()).reshape(-1, 4)}
    assert to_hex(colormaps["PRGn"](0.5)) not in shown
    assert not [text for text in legend_texts(drawn) if text.endswith("= 0")]
    plain = draw(data.stability_map(), figure("map", variable="L_s"))
    assert plain.findobj(QuadMesh)[0].get_cmap().name == "cividis"
    for ends in ((-1.0, 1.0), (-1.0, 2.0), (-0.9, 1.0), (0.0, 1.0), (-1.0, 0.0)):
        zero = _of_both_signs(*ends)(Normalize(*ends)(0.0))
        assert to_hex(zero) == to_hex(colormaps["PRGn"](0.5)), ends
    noise = np.random.default_rng(1).standard_normal(several["L_s"].shape[:2])
    alike = several["L_s"].copy(deep=True)
    alike[..., 1] = alike[..., 0] * (1.0 + 1e-15 * noise)
    for log in (False, "z"):  # of one motion twice there is rounding alone
        drawn = draw(several.assign(L_s=alike), figure("map", variable="L_s", take=taken, log=log))
        assert "difference = 0" in legend_texts(drawn)
        assert np.ptp(np.ma.compressed(drawn.findobj(QuadMesh)[0].get_array())) == 0.0
    alike[0, 0, 1] += 1.0
    for low, log, told in ((-2.0, False, True), (0.1, False, False), (0.1, "z", True)):
        asked = figure("map", variable="L_s", take=taken, log=log, zlim=[low, 2.0])
        drawn = draw(several.assign(L_s=alike), asked)
        assert ("difference = 0" in legend_texts(drawn)) == told  # else the arrow of the bar tells
        extend = drawn.findobj(QuadMesh, include_self=False)[0].colorbar.extend
        assert extend == ("min" if low > 0.0 and not log else "neither")
    growing = with_growth()
    growing["eigenvalues"]["growth_rate"] = abs(growing["eigenvalues"]["growth_rate"])
    (mesh, *_) = draw(growing["eigenvalues"], figure("map", variable="growth_rate")).findobj(
        QuadMesh
    )
    assert mesh.get_cmap().name != "cividis"  # as that of one whose growth has both signs


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
    error = crit["critical_value"].copy(data=np.where(modes == 0, 1e-9, np.nan))
    crit.assign(reason=reasons, critical_error=error).to_netcdf("runs/partly.nc")
    sure = draw(response, figure("map", **axes, level={"partly:critical_value": "N0"}))
    assert 40 in {len(line.get_xdata()) for line in sure.axes[0].lines}
    assert not [note for note in style.notes_on(sure) if "not at 1 of 40 places" in note]
    for scale, told in ((1.0, False), (1e6, True)):  # what is rounding alone is not told
        crit.assign(critical_error=scale * error).to_netcdf(f"runs/off{told}.nc")
        wanted = figure("map", **axes, level={f"off{told}:critical_value": "N0"})
        notes = style.notes_on(draw(response, wanted, look=look_of("paper")))
        within = "critical value of N_0: within 0.001 at its values of Omega"
        assert any(within in note for note in notes) == told
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


def test_a_map_that_is_taken_over_starts_has_a_line_of_each(tmp_path, monkeypatch):
    """That a border is known for two starts was a reason to refuse it, or to leave out one."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "runs").mkdir()
    speeds, starts = np.linspace(0.0, 12.0, 9), ["reached", "exists"]
    values = np.stack([4.0 * speeds, 40.0 - speeds], axis=1)
    told = {"long_name": "N0 at the border of periodic"}
    border = xr.Dataset(
        {
            "boundary": (("Omega", "initial"), values, told),
            "status": data.statuses(("Omega", "initial"), np.full(values.shape, "ok")),
        },
        coords={"Omega": ("Omega", speeds, {"units": "rad s-1"}), "initial": starts},
        attrs=with_growth()["response"].attrs,
    )
    border.to_netcdf("runs/border.nc")
    taken = {"what": "classes", "over": ["initial"]}
    asked = {"variable": "attractor", "level": {"border:boundary": "N0"}}
    drawn = draw(with_growth(), figure("map", take=taken, **asked))
    words = [
        "$N_{0}$ at the border of periodic, reached",
        "$N_{0}$ at the border of periodic, exists",
    ]
    assert [text for text in legend_texts(drawn) if "border" in text] == words
    lines = {str(one.get_label()): one for one in drawn.axes[0].lines if len(one.get_xdata()) == 9}
    for word, value in zip(words, values.T, strict=True):
        assert lines[f"_{word}"].get_ydata() == pytest.approx(value)
    assert len({one.get_linestyle() for one in lines.values()}) == 2
    (ax, *_) = draw(with_growth(), figure("map", **asked)).axes  # of the one start that it has
    (line,) = (one for one in ax.lines if len(one.get_xdata()) == 9)
    assert line.get_ydata() == pytest.approx(values[:, 0])


def test_what_is_taken_has_lines_of_what_it_is_not_taken_of():
    take = {"what": "share", "of": "periodic", "over": ["initial"]}
    wanted = figure("map", variable="attractor", take=take, level={"share": 0.5, "growth_rate": 0})
    told = legend_texts(draw(with_growth(), wanted))
    assert {"share = 0.5", "growth rate = 0 rad/s"} <= {*told}


def test_axes_that_advance_together_span_no_map():
    dataset = data.stability_map(initial=("reached",), nx=8, ny=8)
    along = xr.DataArray(np.arange(8), dims="pair")
    zipped = dataset.isel(Omega=along, N0=along)
    with pytest.raises(UsageError, match="Omega and N0 advance together"):
        draw(zipped, figure("map", x="Omega", y="N0"))


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
    with pytest.raises(UsageError, match="overlay shows levels of the variable that is mapped"):
        draw(with_growth(), figure("map", variable="L_s", level={"growth_rate": 0}, overlay=True))


def test_a_map_may_have_the_starts_along_an_axis(tmp_path):
    """Which start reaches what along one parameter: refused as if nothing were called so."""
    case = tmp_path / "a.toml"
    text = """schema = 1
[model]
name = "belt-1dof"
[grid]
v = [0.5, 1.0]
[[initial]]
label = "one"
kind = "state"
state = { x_dot = "v" }
[[initial]]
label = "two"
kind = "equilibrium"
[[analysis]]
kind = "response"
[[figure]]
kind = "map"
x = "v"
y = "initial"
"""
    case.write_text(text)
    assert fiv(["check", str(case)]) == 0
    case.write_text(text.partition('[[initial]]\nlabel = "two"')[0] + text[text.index("[[ana") :])
    assert fiv(["check", str(case)]) == 3
    drawn = draw(data.bifurcation(), figure("map", x="Omega", y="initial", variable="attractor"))
    ticks = [text.get_text() for text in drawn.axes[0].get_yticklabels()]
    assert ticks == [*data.bifurcation()["initial"].values]


def test_a_growth_rate_of_zero_beside_critical_values_is_told_to_be_twice():
    planes = SimpleNamespace(array=xr.DataArray(0.0, name="attractor"))
    for growing, told in (({"growth_rate": 0.0}, 1), ({"growth_rate": 1.0}, 0), ({}, 0)):
        level = {**growing, "crit:critical_value": "N0"}
        assert len([*_told_twice(planes, {"level": level})]) == told


def test_a_map_needs_two_axes():
    one_start = data.bifurcation().isel(initial=[0])[["status", "attractor", "L_s"]]
    with pytest.raises(UsageError, match="two axes"):
        draw(one_start, figure("map"))
