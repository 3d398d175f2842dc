"""Curves, drawn from small datasets: lines, crossings, what is not sure, followed branches."""

import csv
import json
from itertools import permutations, product
from pathlib import Path

import matplotlib as mpl
import numpy as np
import pytest
import synthetic_datasets as data
import xarray as xr
from matplotlib.colors import to_hex
from matplotlib.contour import ContourSet
from matplotlib.figure import Figure
from matplotlib.legend import Legend
from plotted import (
    AT_A_JUMP,
    REST_ABOVE,
    UNDECIDED_ABOVE,
    branch_along_the_speed,
    crossing_lines,
    figure,
    legend_texts,
    marks,
)

from fiv_cli import api
from fiv_cli.errors import UsageError
from fiv_cli.plots import draw, leaps, legends, look_of, points, save, style
from fiv_cli.plots.curve_lines import Curve
from fiv_cli.plots.curve_panel import _hidden, _plot
from fiv_cli.plots.diagram_lines import mark_critical
from fiv_cli.plots.drawn import as_csv, in_one_line
from fiv_cli.plots.style import BLACK
from fiv_cli.reading.datasets import flag_names
from fiv_cli.reading.summary import summarise
from fiv_cli.reading.take import taken


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
    assert ax.get_ylabel() == "$L_s$ ($10^{-3}$ rad$^{2}$)"


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
    assert "changes between Omega = 2.9 and 3, and" in note
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


def test_where_a_line_leaves_a_motion_for_another_of_its_class_is_told():
    """Gaps that nothing explained; one where a cycle grows, between a bend and a stick, is none."""
    found = data.bifurcation().isel(initial=[0], Omega=slice(8))
    (periodic,) = (c for c, n in flag_names(found["attractor"].attrs).items() if n == "periodic")
    found["attractor"] = found["attractor"].copy(data=np.full((8, 1), periodic))
    at, found["multiplicity"] = found["Omega"].values, found["L_s"].copy(data=np.ones((8, 1)))
    for heights, gaps in (
        ([1.0, 1.1, 1.2, 1.3, 3.0, 3.1, 3.2, 3.3], [4]),
        ([1.0, 0.9, 0.8, 0.7, 1.0, 0.9, 0.8, 0.7], [4]),  # against both sides
        ([1.1, 2.0, 2.6, 2.6, 2.7, 2.7, 2.8, 2.8], []),  # sticks from the third on
    ):
        found["L_s"] = found["L_s"].copy(data=np.array(heights)[:, None])
        sticks = (not gaps) * np.fmax(0.0, 0.05 * np.arange(-1.0, 7.0))[:, None]
        found["stick_fraction"] = (("Omega", "initial"), sticks, {"units": "1"})
        drawn = draw(found, figure("curve", variable="L_s"))
        (ax,) = drawn.axes
        assert np.flatnonzero(np.isnan(ax.lines[0].get_ydata())).tolist() == gaps
        notes = [note for note in style.notes_on(drawn) if "not joined" in note]
        assert len(notes) == len(gaps)
        assert all(f"between Omega = {at[3]:.6g} and {at[4]:.6g}" in note for note in notes)


@pytest.mark.parametrize(("count", "entries"), [(4, 4), (7, 1)])
def test_a_few_starts_of_a_table_are_told_apart(count, entries):
    """Dots of one colour under one name: which start reaches what, was not to be seen."""
    classes = np.full((3, count), "periodic", object)
    names = [f"mine-{number:03d}" for number in range(count)]
    L_s = 1.0 + np.arange(count) + np.zeros((3, 1))
    found = data.response(classes, L_s, data.axes(Omega=[1.0, 2.0, 3.0], initial=names))
    found.attrs["starts_json"] = json.dumps({"mine": "table"})
    (ax,) = draw(found, figure("curve", variable="L_s")).axes
    told = ax.get_legend_handles_labels()[1]
    assert told == [f"mine {number:03d}" for number in range(count)][:entries] or (
        entries == 1 and told == ["mine"]
    )
    colours = {line.get_color() for line in ax.lines if len(line.get_xdata())}
    assert len(colours) == entries


def test_critical_values_lie_where_amplitudes_begin():
    """A file of them was refused beside a curve."""
    speeds = np.linspace(1.0, 5.0, 9)
    classes = np.where(speeds < 3.2, "equilibrium", "periodic").astype(object)[:, None]
    found = data.response(classes, np.ones((9, 1)), data.axes(Omega=speeds, initial=["near"]))
    heights = np.sqrt(np.fmax(speeds - 3.1, 0.0))[:, None]
    found["phi_amplitude"] = (("Omega", "initial"), heights, {"units": "rad"})
    told = {"long_name": "critical value of Omega", "units": "rad s-1"}
    critical = xr.Dataset(
        {
            "status": data.statuses((), np.array("ok")),
            "critical_value": ("crossing", [3.1, 99.0], told),
        },
        attrs=data.attributes(),
    )
    wanted = figure("curve", variable="phi_amplitude")
    (ax,) = draw([("a", found), ("b", critical)], wanted).axes
    assert marks(ax, "critical value of $\\Omega$").tolist() == [[3.1, 0.0], [99.0, 0.0]]
    (note,) = style.notes_on(ax.figure)
    assert note.startswith("critical value of $\\Omega$ at 99: beyond the lines")
    chosen = figure("curve", variable="phi_amplitude", select={"initial": "near"})
    (ax,) = draw([("a", found), ("b", critical)], chosen).axes  # of which these know nothing
    assert len(marks(ax, "critical value of $\\Omega$")) == 2
    several = found.expand_dims(N0=[1.0, 2.0]).copy(deep=True)
    several["phi_amplitude"].values[1] *= 2.0
    several["theta_amplitude"] = several["phi_amplitude"].assign_attrs(units="m")
    two = critical.expand_dims(N0=[1.0, 2.0])
    wanted = figure("curve", x="Omega", variable=["phi_amplitude", "theta_amplitude"])
    upper, lower = (
        [one.get_color() for one in ax.lines if "critical" in str(one.get_label())][:2]
        for ax in draw([("a", several), ("b", two)], wanted).axes
    )
    assert upper == lower and len({*upper}) == 2  # of the lines, in every panel
    of_two = several.expand_dims(k=[1.0, 2.0, 3.0]).copy(deep=True)
    of_two["phi_amplitude"] = of_two["phi_amplitude"] * of_two["k"]
    wanted = figure("curve", x="Omega", variable="phi_amplitude")
    (ax,) = draw([("a", of_two), ("b", two.expand_dims(k=of_two["k"].values))], wanted).axes
    at = [one for one in ax.lines if "critical" in str(one.get_label()) and len(one.get_xdata())]
    looks = {(one.get_color(), one.get_mfc()) for one in at}
    assert len(at) == len(looks) == 6 and len({colour for colour, _ in looks}) == 3
    told = [text for text in legend_texts(ax) if "critical value" in text]
    assert told == [f"critical value: $N_{{0}}$ = {own}" for own in (1, 2)]
    two = critical.expand_dims(N0=[1.0, 2.0, 3.0])
    starts = found.expand_dims(N0=[1.0, 2.0, 3.0]).isel(initial=[0, 0]).copy(deep=True)
    starts = starts.assign_coords(initial=["near", "far"])
    rising = np.repeat(np.arange(27.0), 2).reshape(starts["phi_amplitude"].shape)
    rising[:, :4, 1] += 30.0  # from there on both starts lead to one motion: colours tell them
    starts["phi_amplitude"] = starts["phi_amplitude"].copy(data=rising)
    wanted = figure("curve", x="Omega", variable="phi_amplitude")
    (ax,) = draw([("a", starts), ("b", two)], wanted).axes
    told = [text for text in legend_texts(ax) if "critical value" in text]
    fills = {str(one.get_mfc()) for one in ax.lines if "critical value" in str(one.get_label())}
    assert len(told) == len(fills) == 3 and all("$N_{0}$ = " in text for text in told)
    many = [1.0, 2.0, 3.0, 4.0]  # more than there are fills: black, and all alike
    of_all, other = found.expand_dims(N0=many), critical.expand_dims(N0=many)
    ax = Figure().add_subplot()
    mark_critical(ax, points.Layer("b", other), [of_all], found["Omega"], colours_tell=False)
    assert any("one mark for those of" in note for note in style.notes_on(ax.figure))
    wanted = figure("curve", variable="phi_amplitude")
    critical["critical_value"].attrs["long_name"] = "critical value of N0"
    with pytest.raises(UsageError, match="no phi_amplitude"):
        draw([("a", found), ("b", critical)], wanted)


def test_a_long_entry_of_a_legend_is_folded_where_others_stand_beside_it_then():
    """Ten entries stood one below another, taking a third of the figure."""
    short, long = [f"$c_1$ = 0.{n} N s/m" for n in range(9)], "modes merge: " + "$c_1$ = 0, " * 9
    found = Figure(figsize=(6.4, 4.0), layout="constrained")
    keys = [found.add_subplot().plot([], [], label=text)[0] for text in (*short, long)]
    legends.legend_below(found, keys)
    (legend,) = found.legends
    texts = [text.get_text() for text in legend.get_texts()]
    assert texts[:9] == short and "\n" in texts[9] and texts[9].split() == long.split()
    assert legend._ncols > 1 and legend.get_window_extent().width <= found.bbox.width
    even = Figure(figsize=(6.4, 4.0), layout="constrained")
    words = ["equilibrium", "quasiperiodic", "chaotic", "undecided", "contact lost", "periodic"]
    ax = even.add_subplot()
    legends.legend_below(even, [ax.plot([], [], label=text)[0] for text in words])
    assert even.legends[0]._ncols == 3  # in as few columns as make no more rows
    alone = Figure(figsize=(6.4, 4.0), layout="constrained")
    legends.legend_below(alone, [alone.add_subplot().plot([], [], label=long[:60])[0]])
    assert "\n" not in alone.legends[0].get_texts()[0].get_text()


def test_cycles_of_ever_other_multiplicity_are_no_line():
    """One dash-dot line led through cycles of 10, 9, 11 and 23 section points per period."""
    for passages, told in (
        ([1, 1, 2, 2, 4, 4], [False] * 5),
        ([1, 1, 2, 4, 8, 8], [False] * 5),  # whose period doubles
        ([1, 1, 9, 11, 4, 4], [False, True, True, True, False]),
        ([1, 0, 2, 0, 4, 4], [False] * 5),  # of which none passes there is no number
    ):
        kinds = np.array(passages, float) + leaps.MANY * np.array([0, 1, 0, 1, 0, 1])
        assert leaps.of_changing_passages(kinds).tolist() == told


def test_where_sticking_goes_over_to_another_contact_at_one_point_no_line_leads():
    """The shares of stick of two belts at one speed were joined to those beside it, and a kink."""
    for sticks, told in (
        ([1, 1, 3, 2, 2], [False, True, True, False]),
        ([1, 1, 0, 2, 2], [False, True, True, False]),
        ([1, 1, 3, 3, 2], [False] * 4),  # of both there is a line
        ([0, 0, 1, 3, 3], [False] * 4),  # one after the other
        ([0, 0, 1, 0, 0], [False] * 4),
    ):
        assert leaps.of_a_handover(1.0 + leaps.MANY * np.array(sticks)).tolist() == told


def test_along_what_advances_together_in_no_order_places_are_called_by_all_of_it():
    """A line led from one damping to another over a third, whose second value stood nowhere."""
    values, none = {"c1": [0.0, 20.0, 5.0], "c2": [0.0, 20.0, 35.0]}, np.array(["ok"] * 3)
    held = {name: ("c1_c2", own, {"units": "N s m-1"}) for name, own in values.items()}
    found = {"status": data.statuses(("c1_c2",), none)}
    found["critical_value"] = ("c1_c2", [1.0, 1.1, 0.8], {"long_name": "critical value of mu_k"})
    dataset = xr.Dataset(found, held, data.attributes())
    drawn = draw(dataset, figure("curve", variable="critical_value"))
    (ax,) = drawn.axes
    ticks = [" ".join(one.get_text().split()) for one in ax.get_xticklabels()]
    assert ticks[2] == "$c_{1}$ = 5 N s/m, $c_{2}$ = 35 N s/m"
    assert all(line.get_linestyle() == "None" for line in ax.lines if len(line.get_xdata()))
    rows = csv.reader(as_csv(drawn, Path("a.csv")).splitlines())
    assert not style.notes_on(drawn) and "c_1 = 5 N s/m, c_2 = 35 N s/m" in {
        row[-2] for row in rows
    }
    (ax,) = draw(dataset, figure("curve", variable="critical_value", x="c1")).axes
    assert ax.get_xlim()[1] > 20.0  # as asked
    rising = dataset.isel(c1_c2=[0, 2, 1])
    assert draw(rising, figure("curve", variable="critical_value")).axes[0].get_xlim()[1] > 20.0


def test_many_lines_in_many_pieces_are_told():
    """Six of chaotic motions lay over one another, and nothing said what to do."""
    words = [f"$k$ = {one} N/m, {start}" for one in (1, 2, 3) for start in ("near", "far")]
    assert points.of_many_lines(words, ["initial"]) == []
    (told,) = points.of_many_lines(words, ["initial"], 36)
    assert told.startswith("6 lines in 36 pieces are hard to tell apart; select = { initial = ")
    assert points.of_many_lines(words[:3], ["initial"], 36) == []


def test_branches_and_critical_values_lie_over_amplitudes_whichever_file_comes_first():
    """By another order it was a figure along the other axis, or refused without a file's name."""
    speeds = np.linspace(1.0, 4.0, 7)
    found = data.response(
        np.full((7, 1, 1), "periodic", dtype=object),
        np.ones((7, 1, 1)),
        data.axes(Omega=speeds, N0=[30.0], initial=["near"]),
    )
    rising = speeds[:, None, None]
    found["phi_amplitude"] = (("Omega", "N0", "initial"), rising, {"units": "rad"})
    told = {"long_name": "critical value of Omega", "units": "rad s-1"}
    critical = xr.Dataset(
        {
            "status": data.statuses((), np.array("ok")),
            "critical_value": ("crossing", [3.1], told),
        },
        attrs=data.attributes(),
    )
    branch = branch_along_the_speed()
    branch["phi_amplitude"] = (("N0", "initial"), [[1.5]], {"units": "rad"})
    files = [("a", found), ("b", branch), ("c", critical)]
    drawn = []
    for order in permutations(files):
        (ax,) = draw([*order], figure("curve", variable="phi_amplitude")).axes
        drawn.append((ax.get_xlabel(), {str(line.get_xydata()) for line in ax.lines}))
        assert marks(ax, "critical value of $\\Omega$").tolist() == [[3.1, 0.0]]
    assert all(one == drawn[0] for one in drawn) and "Omega" in drawn[0][0]


def test_a_line_that_two_with_other_dashes_run_upon_is_wider_and_seen():
    """As frequencies at several stiffnesses, which differ by less than a line is wide."""
    axes = data.axes(Omega=np.linspace(1.0, 2.0, 9), N0=[1.0, 2.0, 3.0], initial=["a"])
    values = np.linspace(70.0, 78.0, 9)[:, None, None] + 1e-3 * np.arange(3)[:, None]
    found = data.response(np.full((9, 3, 1), "periodic", object), values, axes)
    for count, widest in ((3, 2.0), (2, 1.2)):
        asked = figure("curve", variable="L_s", x="Omega")
        (ax,) = draw(found.isel(N0=slice(count)), asked).axes
        widths = {one.get_linewidth() for one in ax.lines if len(one.get_xdata()) > 1}
        assert (max(widths) > 1.5 * min(widths)) == (count == 3)
        assert max(widths) >= widest


def test_a_break_that_is_none_of_classes_is_not_told_to_be():
    """As where a speed changes its sign."""
    at = np.linspace(-1.0, 1.0, 10)
    found = data.response(
        np.full((10, 1), "periodic", object), np.ones((10, 1)), data.axes(Omega=at, initial=["a"])
    )
    found["Omega"].attrs["role"] = "speed"
    told = style.notes_on(draw(found, figure("curve", variable="L_s"), look=look_of("paper")))
    assert not any("class of motion" in one for one in told)


def test_that_undecided_values_of_two_variables_look_alike_is_told():
    dataset = with_x_rms("m2")
    dataset["L_s"] = dataset["L_s"].assign_attrs(units="m2")
    both, alone = (figure("curve", variable=of) for of in (["L_s", "x_rms"], "L_s"))
    decided = dataset.copy(deep=True)
    undecided = data.codes(data.ATTRACTORS, "undecided")
    at = decided["attractor"].values == undecided
    decided["attractor"].values[at] = data.codes(data.ATTRACTORS, "periodic")
    for of, asked, count in ((dataset, both, 1), (dataset, alone, 0), (decided, both, 0)):
        notes = style.notes_on(draw(of, asked))
        assert sum("look alike for" in note for note in notes) == count


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
    with pytest.raises(UsageError, match=r"F_T: not in this dataset(.|\n)*`fiv history` does"):
        draw(data.bifurcation(), figure("curve", variable="F_T"))
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


def test_a_line_that_fills_the_gaps_of_another_of_its_colour_is_told():
    """Of critical values that do not depend on a parameter: a legend has both lines."""
    case = {
        "schema": 1,
        "model": {"name": "belt-1dof"},
        "friction": {"law": "stribeck", "mu_s": 0.4, "mu_k": 0.2, "v_s": 0.5},
        "grid": {"N": [8.0, 9.0, 10.0], "c": [0.2, 0.3, 0.4], "k": [1.0, 2.0]},
        "analysis": [{"kind": "critical", "parameter": "v", "bracket": [0.01, 9.0]}],
    }
    found = api.run(api.load(case), workers=1)
    asked = figure("curve", x="N", variable="critical_value")
    (note,) = [one for one in style.notes_on(draw(found, asked)) if "in one colour" in one]
    assert "k = 1 N/m and c = 0.2 N s/m, k = 2 N/m: one line" in note
    assert "and 2 more such pairs; select in the figure" in note
    alone = figure("curve", x="N", variable="critical_value", select={"k": 1.0})
    assert not any("in one colour" in one for one in style.notes_on(draw(found, alone)))


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
    ("upon", "widths"),
    [([4, 4, 5, 9], [2, 3, 4]), ([3, 3, 5, 9], [2, 3, 4]), ([0, 2, 2, 0], [2, 3])],
)
def test_a_line_is_as_wide_as_what_runs_upon_it_and_told_where_nothing_of_it_is_seen(upon, widths):
    """The last point is not sure; four lines upon one another are seen."""
    x, y = np.arange(4.0), np.array([1.0, 2.0, 3.0, 4.0])
    unsure = np.array([False, False, False, True])
    curve = Curve({"initial": "a"}, x, y, unsure, (y, y), 0.0 * x)
    notes = [*_hidden(curve, np.array(upon))]
    assert [note.split(" others")[0] for note in notes] == (
        ["a: its line lies beneath 4"] if min(upon) > 3 else []
    )
    _, (ax,) = style.new_panels(1, 1, "")
    entry = points.Entry(style.BLUE, "-", "a", 0, scattered=False)
    _plot(ax, curve, 0.0, entry, False, 4, np.array(upon))
    drawn = {one.get_linewidth() / mpl.rcParams["lines.linewidth"] for one in ax.lines}
    assert sorted(drawn) == pytest.approx([1, *widths])


def test_two_variables_from_two_starts_that_lead_to_the_same_for_a_while_have_two_colours():
    found = over_preloads((10.0,), ("a", "b")).isel(N0=0)
    same = found["L_s"].isel(initial=[0, 0]).assign_coords(initial=found["initial"])
    later = found["Omega"] > found["Omega"].values[len(found["Omega"]) // 2]
    found["L_s"] = found["L_s"].where(later, same).assign_attrs(found["L_s"].attrs)
    found["other"] = (2.0 * found["L_s"]).assign_attrs(units="rad2", long_name="other")
    asked = figure("curve", x="Omega", variable=["L_s", "other"])
    (ax,) = draw(found, asked).axes
    assert len(legend_texts(ax)) == 4 and len({*looks_of(ax, "color").values()}) == 2


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
        "error bound",
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


@pytest.mark.parametrize(("role", "lines"), [("speed", 2), ("preload", 1)])
def test_no_line_leads_over_a_drive_that_stands_still(role, lines):
    """Nor is one said to be missing there."""
    dataset = data.crossings().isel(crossing=[1], R=[0, 0, 0, 0])
    dataset = dataset.assign_coords(R=("R", [-2.0, -1.0, 1.0, 2.0], {"role": role}))
    dataset["critical_value"][:], dataset["crossing_mode"][:] = [[1.3], [1.2], [1.1], [1.0]], 2
    (ax,) = draw(dataset, figure("curve")).axes
    assert len([line for line in ax.lines if len(line.get_xdata()) > 1]) == lines
    assert "not joined" not in "".join(style.notes_on(ax.figure))
    value = dataset["critical_value"].isel(crossing=0).rename("L_s")
    of_motions = dataset[["status"]].assign(L_s=value, attractor=dataset["status"] * 0 + 1)
    (ax,) = draw(of_motions, figure("curve", variable="L_s")).axes
    (line,) = [line for line in ax.lines if len(line.get_xdata()) > 2]
    assert np.isnan(line.get_ydata()).sum() == lines - 1


def test_lines_that_run_along_the_axis_upon_one_another_are_each_seen():
    """Of three preloads whose L_s is zero from 2 rad/s on; dashes tell it from another variable."""
    dataset = over_preloads()
    dataset["other"] = (dataset["L_s"] + 50.0).assign_attrs(units="rad2", long_name="other")
    dataset["L_s"] = dataset["L_s"].where(dataset["Omega"] < 2.0, 0.0)
    (ax,) = draw(dataset, figure("curve", x="Omega", variable=["L_s", "other"])).axes
    along = [line for line in ax.lines if np.nanmax(line.get_ydata(), initial=0.0) == 0.0]
    widths = {line.get_linewidth() for line in along if len(line.get_xdata())}
    assert len(widths) == 2 and min(widths) > mpl.rcParams["lines.linewidth"]


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
        "error bound",
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


def test_the_line_of_a_start_goes_on_where_that_of_another_does_upon_it():
    """Of a cycle that one of them reaches at two points alone a step was no line, as the same step
    was of the other."""
    near = np.array([1.5, 0.78, 0.64, 0.79, 1.1, 1.3])
    far = np.where(np.arange(6) < 2, near, 0.0)
    classes = np.where(np.stack([near, far], axis=1) > 0.0, "periodic", "equilibrium")
    axes = data.axes(Omega=np.arange(1.0, 7.0), initial=["near", "far"])
    found = data.response(classes.astype(object), np.ones((6, 2)), axes)
    found["L_s"] = (("Omega", "initial"), np.stack([near, far], axis=1), {"units": "1"})
    found["multiplicity"] = (found["L_s"] > 0.0).astype(int)
    assert style.notes_on(draw(found, figure("curve", variable="L_s"))) == []
    alone = draw(found, figure("curve", variable="L_s", select={"initial": "far"}))
    (note,) = style.notes_on(alone)
    assert "not joined between Omega = 1 and 2" in note
