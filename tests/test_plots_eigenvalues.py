"""Eigenvalues and laws, drawn."""

import csv
from pathlib import Path

import numpy as np
import pytest
import synthetic_datasets as data
import xarray as xr
from plotted import figure, legend_texts, marks

from fiv_cli.errors import UsageError
from fiv_cli.friction import get_law
from fiv_cli.plots import draw, draw_laws, look_of, style
from fiv_cli.plots.drawn import as_csv
from fiv_cli.plots.eigenvalues import _up_to_turns, _upon_one_another
from fiv_cli.plots.law import force
from fiv_cli.plots.mergers import growth_at_mergers, mergers


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


def test_growth_has_its_corner_where_modes_merge_between_points():
    """Its line was straight there, and turned at a point of the grid."""
    dataset = data.eigenvalues().isel(mu_k=slice(9, None, 2))  # 0.475 and 0.525 among them
    merging = np.where(np.isclose(dataset["mu_k"], 0.475)[:, None], 0.5, np.nan) * np.ones(4)
    dataset["coupling_point"] = (("mu_k", "mode"), merging, {"along": "mu_k"})
    (ax,) = draw(dataset, figure("curve", variable="growth_rate")).axes
    x, y = ax.lines[0].get_data()
    assert (np.diff(x) > 0.0).all()
    np.testing.assert_allclose(y[x <= 0.5], -0.05, atol=1e-12)
    assert y[x == 0.5].size == 1
    exact = np.sqrt(np.fmax(x - 0.5, 0.0)) - 0.05  # the root between points, too
    np.testing.assert_allclose(y, exact, atol=1e-12)
    table = csv.DictReader(as_csv(ax.figure, Path("a.csv")).splitlines())
    known = [float(row["x"]) for row in table]
    assert np.isin(known, dataset["mu_k"]).all() and len(known) < x.size  # what was computed


@pytest.mark.parametrize("falling", [False, True])
@pytest.mark.parametrize("fewer", [False, True])
def test_growth_at_mergers_follows_its_axis_and_the_modes_that_there_are(falling, fewer):
    """It ran back and forth along a falling axis, and broke off where a model has fewer modes."""
    dataset = data.eigenvalues().isel(mu_k=slice(9, None, 2))
    at = np.isclose(dataset["mu_k"], 0.525 if falling else 0.475)
    merging = np.where(at[:, None], 0.5, np.nan) * np.ones(4)
    dataset["coupling_point"] = (("mu_k", "mode"), merging, {"along": "mu_k"})
    dataset = dataset.isel(mu_k=slice(None, None, -1)) if falling else dataset
    if fewer:
        dataset = dataset.pad(mode=(0, 2)).assign_attrs(dataset.attrs)
        dataset["coupling_point"].attrs["along"] = "mu_k"
    (ax,) = draw(dataset, figure("curve", variable="growth_rate")).axes
    x, y = ax.lines[0].get_data()
    assert (np.diff(x) * (-1.0 if falling else 1.0) > 0.0).all()
    np.testing.assert_allclose(y, np.sqrt(np.fmax(x - 0.5, 0.0)) - 0.05, atol=1e-12)
    marked = np.asarray(x)[ax.lines[0].get_markevery()]
    assert {*marked} == {*dataset["mu_k"].values}  # no mark where nothing was computed


def test_two_pairs_that_merge_in_one_step_are_both_followed_there():
    mu = np.linspace(0.0, 1.0, 6)
    roots = [np.sqrt(mu - at + 0j) for at in (0.45, 0.55)]
    values = np.stack([1j * (5 + n) + sign * root for n, root in enumerate(roots)
                       for sign in (1, -1)], axis=-1)  # fmt: skip
    places = np.where(np.isclose(mu, 0.4)[:, None], [0.45, 0.45, 0.55, 0.55], np.nan)
    rate = {"units": "rad s-1"}
    found = {
        "status": data.statuses(("mu_k",), np.array(["ok"] * 6)),
        "eigenvalue_real": (("mu_k", "mode"), values.real, rate),
        "eigenvalue_imag": (("mu_k", "mode"), values.imag, rate),
        "growth_rate": (("mu_k",), values.real.max(axis=-1), rate),
        "coupling_point": (("mu_k", "mode"), places, {"along": "mu_k"}),
    }
    part = xr.Dataset(found, data.axes(mu_k=mu))
    after, at, growth = growth_at_mergers(part, part["mu_k"])
    assert (np.diff(at) > 0.0).all() and {*after} == {3}
    assert (np.diff(growth) >= -1e-12).all()  # a tooth at each place of the other pair, it was
    exact = np.sqrt(np.fmax(at - 0.45, 0.0))  # the larger of both roots everywhere
    own = np.isin(at, mergers(part, part["mu_k"], 0)[1])
    np.testing.assert_allclose(growth[own], exact[own], atol=1e-12)


def test_words_of_ones_own_stand_in_entries_that_name_several_lines():
    dataset = data.eigenvalues()
    places = np.where(dataset["mu_k"].values[:, None] == 0.5, 0.5, np.nan) * np.ones(4)
    dataset["coupling_point"] = (("mu_k", "mode"), places, {"along": "mu_k"})
    further = dataset.assign(coupling_point=dataset["coupling_point"] + 0.1)
    never = dataset.assign(coupling_point=dataset["coupling_point"] * np.nan)
    loads = xr.Variable("N0", [20.0, 30.0, 40.0], {"units": "N"})
    three = xr.concat([dataset, further, never], loads)
    three["coupling_point"].attrs = dataset["coupling_point"].attrs
    top, _ = draw(three, figure("eigenvalues", words={"N_0 = 20 N": "light"})).axes
    assert "modes merge: light and $N_{0}$ = 30 N" in legend_texts(top)


def test_a_mode_beneath_another_is_seen_on_it():
    dataset = data.eigenvalues()
    _, bottom = draw(dataset, figure("eigenvalues")).axes
    first, second = (
        next(line for line in bottom.lines if line.get_label() == f"_mode {number}")
        for number in (1, 2)
    )
    usual = first.get_linewidth()
    (wide,) = [line for line in bottom.lines if usual < line.get_linewidth() < 3.0]
    x = np.asarray(wide.get_xdata())[np.isfinite(wide.get_ydata())]
    assert x.min() >= 0.5 and wide.get_color() == first.get_color() != second.get_color()
    assert wide.get_zorder() < second.get_zorder()


def test_critical_values_mark_the_largest_growth_and_lines_of_modes_each_by_its_fill():
    dataset = data.eigenvalues()
    laws = xr.Variable("friction", ["coulomb", "stribeck"])
    both = xr.concat([dataset, dataset.assign(growth_rate=dataset["growth_rate"] - 0.1)], laws)
    told = {"long_name": "critical value of mu_k", "units": "1"}
    values = xr.DataArray([[0.5025, 0.9], [0.525, np.nan]], dims=("friction", "crossing"))
    critical = xr.Dataset(
        {"status": data.statuses(("friction",), ["ok"] * 2), "critical_value": values},
        {"friction": laws},
        data.attributes(),
    )
    critical["critical_value"].attrs = told
    files = [("a", both), ("b", critical)]
    (ax,) = draw(files, figure("curve", variable="growth_rate")).axes
    words = r"critical value of $\mu_k$"
    met = {str(line.get_label()): line for line in ax.lines if words in str(line.get_label())}
    assert met[f"_coulomb, {words}"].get_xdata().tolist() == [0.5025]  # 0.9: a further mode
    both["growth_rate"][:, 21] = np.nan  # beside both: what is known there is not positive
    (ax,) = draw(files, figure("curve", variable="growth_rate")).axes
    assert [0.5025] in [line.get_xdata().tolist() for line in ax.lines if len(line.get_xdata())]
    other = both.drop_vars(["growth_rate", "eigenvalue_real", "eigenvalue_imag"])
    two = {"first": other, "eigenvalues": both}  # the figure names no analysis
    (ax,) = draw([("a", two), ("b", critical)], figure("curve", variable="growth_rate")).axes
    assert [0.5025] in [line.get_xdata().tolist() for line in ax.lines if len(line.get_xdata())]
    top, _ = draw(files, figure("eigenvalues")).axes
    fills = {
        str(line.get_label()): line.get_markerfacecolor()
        for line in top.lines
        if "critical value" in str(line.get_label())
    }
    assert [*fills] == ["critical value: coulomb", "critical value: stribeck"]
    assert len({*fills.values()}) == 2


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
        shown = sum(np.isfinite(band.get_ydata()).sum() for band in bands)
        assert shown == int(unstable.sum()) + 2  # and where growth is zero, of each line


@pytest.mark.parametrize(("off", "told"), [(1e-4, True), (0.1, False)])
def test_that_a_line_of_a_mode_hides_another_is_told(off, told):
    """Frequencies that damping hardly changes: of three dampings two lines were seen."""
    one = data.eigenvalues().assign_coords(c1=1.0)
    other = one.assign_coords(c1=2.0)
    other["mode_frequency"] = other["mode_frequency"] * (1.0 + off)
    other["eigenvalue_real"] = other["eigenvalue_real"] - 0.2
    drawn = draw(xr.concat([one, other], "c1").assign_attrs(one.attrs), figure("eigenvalues"))
    notes = style.notes_on(drawn)
    hidden = "mode_frequency: mode 1 is one line at c_1 = 1 and c_1 = 2, nearly everywhere, and 1"
    assert any(note.startswith(hidden) for note in notes) == told


def test_a_band_of_what_is_unstable_begins_where_growth_is_zero():
    x = np.arange(4.0)
    for growth, begins in (([-1.0, 1.0, 2.0, 3.0], 0.5), ([-1.0, 0.0, 1.0, 2.0], 1.0)):
        places, heights, unstable = _up_to_turns(x, 2.0 * x, np.array(growth))
        assert places[unstable].min() == begins and heights[unstable].min() == 2.0 * begins
    apart = {"mode 1": [("a", np.array([1.0, np.nan])), ("b", np.array([np.nan, 2.0]))]}
    assert [*_upon_one_another(xr.DataArray([1.0, 2.0], name="mode_frequency"), apart)] == []


def test_lines_of_modes_lead_through_the_point_where_they_merge():
    """Between two points of the grid; a table has those alone."""
    whole = data.eigenvalues()
    dataset = whole.isel(mu_k=[0, 10, 19, 21, 30, 40])  # they merge at 0.5
    places = np.full((6, 4), np.nan)
    places[2] = 0.5
    told = {"along": "mu_k", "units": "1"}
    dataset["coupling_point"] = (("mu_k", "mode"), places, told)
    drawn = draw(dataset, figure("eigenvalues"))
    for ax, met in zip(drawn.axes, (-0.05, 5.0 / (2.0 * np.pi)), strict=True):
        lines = [line.get_xydata() for line in ax.lines
                 if "_mode " in line.get_label() and len(line.get_xdata())]  # fmt: skip
        assert len(lines) == 2
        for line in lines:
            np.testing.assert_allclose(line[line[:, 0] == 0.5], [[0.5, met]], atol=1e-12)
    rows = list(csv.DictReader(as_csv(drawn, Path("a.csv")).splitlines()))
    assert {row["series"] for row in rows if row["x"] == "0.5"} == {"modes merge"}


def test_critical_values_of_another_file_lie_where_growth_is_zero():
    """Of each line those at its parameters; of what has none there it is said."""
    stiff = data.eigenvalues().assign_coords(k=2.0)
    lines = xr.concat([data.eigenvalues().assign_coords(k=1.0), stiff], "k")
    lines = lines.assign_attrs(stiff.attrs)
    found = {
        "status": data.statuses(("k",), ["ok"] * 3),
        "critical_value": (("k", "crossing"), [[0.5, np.nan], [0.6, 0.7], [0.9, np.nan]]),
    }
    critical = xr.Dataset(found, data.axes(k=[1.0, 2.0, 3.0]), data.attributes())
    critical["critical_value"].attrs["long_name"] = "critical value of mu_k"
    drawn = draw([("", lines), ("critical", critical)], figure("eigenvalues"))
    words = "critical value"
    found = [line for line in drawn.axes[0].lines if words in str(line.get_label())]
    places = [place for line in found for place in line.get_xydata().tolist()]
    assert places == [[0.5, 0.0], [0.6, 0.0], [0.7, 0.0]]
    critical["critical_value"] = critical["critical_value"].copy(
        data=[[0.6, np.nan], [0.6001, np.nan], [0.9, np.nan]]
    )
    drawn = draw([("", lines), ("critical", critical)], figure("eigenvalues"))
    beneath, upon = (line for line in drawn.axes[0].lines if words in str(line.get_label()))
    assert beneath.get_markersize() > 1.5 * upon.get_markersize()  # and is seen around it
    kinds = [["root", "not_computed"], ["end", "not_computed"], ["root", "not_computed"]]
    critical["crossing_kind"] = data.flags(
        ("k", "crossing"), kinds, ("not_computed", "root", "end")
    )
    drawn = draw([("", lines), ("critical", critical)], figure("eigenvalues"))
    found = [line for line in drawn.axes[0].lines if words in str(line.get_label())]
    places = [line.get_xdata().tolist() for line in found if len(line.get_xdata())]
    assert places == [[0.6]]  # where an equilibrium ends no growth is zero
    with pytest.raises(UsageError, match="no critical value of mu_k at parameters of this"):
        other = critical.isel(k=[2])
        draw([("", lines), ("critical", other)], figure("eigenvalues"))


def test_that_modes_grow_alike_is_told_of_the_one_that_grows_most():
    """Below flutter without damping it is one of two, and the figure drew it as a finding."""
    found = data.eigenvalues()
    found["growth_frequency"] = abs(found["eigenvalue_imag"]).isel(mode=0, drop=True)
    told = style.notes_on(draw(found, figure("curve", variable="growth_frequency")))
    alike = [note for note in told if "modes of other frequencies grow as much" in note]
    real, turning = found["eigenvalue_real"], abs(found["eigenvalue_imag"])
    most = turning.where(real == real.max("mode"))
    count = int((most.max("mode") - most.min("mode") > 1e-6).sum())
    assert count > 0 and f"at {count} points" in alike[0]
    apart = found.assign(eigenvalue_real=real + 0.1 * found["mode"])
    told = style.notes_on(draw(apart, figure("curve", variable="growth_frequency")))
    assert not [note for note in told if "grow as much" in note]


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


def test_what_several_laws_hold_in_stick_is_one_line_with_the_end_of_each():
    """Upon one another they were a patchwork, or one hid the others."""
    drawn = draw_laws(["coulomb", "exponential:mu_s=0.6"])
    lines = [line for line in drawn.axes[0].lines if len(line.get_xdata())]
    (dotted,) = [line for line in lines if line.get_linestyle() == ":"]
    assert list(dotted.get_ydata()) == [-0.6, 0.6]
    ends = [list(line.get_ydata()) for line in lines if line.get_marker() == "_"]
    assert ends == [[-0.4, 0.4], [-0.6, 0.6]]
    table = as_csv(drawn, Path("a.csv"))
    assert sum("held in stick" in row for row in table.splitlines()) == 4
    assert legend_texts(drawn)[-1] == "held in stick: each law to its mark"
    alike = draw_laws(["coulomb", "exponential"])  # one mark would hide the other
    black = [line for line in alike.axes[0].lines if line.get_color() == style.BLACK]
    assert [line.get_marker() for line in black if len(line.get_xdata())] == ["None", "_"]
    assert legend_texts(alike)[-1] == "held in stick, to the marks"
    assert legend_texts(draw_laws(["coulomb", "dahl"], called=["A", "B"]))[:2] == ["A", "B"]
    assert "held in stick" not in legend_texts(draw_laws(["dahl", "lugre"]))  # neither sticks


@pytest.mark.parametrize(("fastest", "told"), [(1.0, 0), (5.0, 1)])
def test_that_one_law_flattens_the_others_is_told(fastest, told):
    notes = style.notes_on(draw_laws(["coulomb", "cubic"], fastest=fastest))
    assert sum(note.startswith("cubic reaches ") for note in notes) == told


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
