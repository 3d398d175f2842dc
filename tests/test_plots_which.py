"""Which figures a dataset has, and in which words and colours."""

import json

import numpy as np
import pytest
import synthetic_datasets as data
import xarray as xr
from matplotlib.figure import Figure
from plotted import figure

from fiv_cli.errors import UsageError
from fiv_cli.plots import default_figures, draw, figures_of, points
from fiv_cli.plots import labels as words
from fiv_cli.plots.fitting import tame_texts
from fiv_cli.plots.style import class_colours, dot_size, line_colours


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
    both = xr.Dataset(
        {"status": data.statuses(("c1_c2",), ["ok"])},
        {name: ("c1_c2", [10.0], {"units": "N s m-1"}) for name in ("c1", "c2")},
        data.attributes(),
    )
    told = points.title(both.assign_attrs(differs="$c_{1}$ = 10 N s/m, $c_{2}$ = 10 N s/m"))
    assert told.splitlines()[1:] == ["$c_{1}$ = $c_{2}$ = 10 N s/m"]  # and not twice
    assert points.title(dataset.assign_attrs(differs="$c$ = 0.5, $k$ = 2 N/m")) == (
        f"{own}, $k$ = 2 N/m"
    )


@pytest.mark.parametrize(
    ("direction", "told"),
    [("both", "= 0"), ("up", "rising through 0"), ("down", "falling through 0")],
)
def test_values_are_told_with_the_section_that_they_are_passed_at(direction, told):
    section = {"kind": "zero", "state": "phi_dot", "direction": direction, "contact": 1}
    analyses = {"response": {"kind": "response", "settings": {"section": section}}}
    dataset = data.bifurcation().assign_attrs(analyses_json=json.dumps(analyses))
    (ax,) = draw(dataset, figure("bifurcation")).axes
    assert ax.get_ylabel() == rf"$\varphi$ at $\dot{{\varphi}}$ {told} (rad)"


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
