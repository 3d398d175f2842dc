"""`fiv plot`, and what it says."""

import csv
import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import synthetic_datasets as data
import xarray as xr
from click.testing import CliRunner
from matplotlib.collections import PolyCollection, QuadMesh
from matplotlib.figure import Figure
from matplotlib.text import Text
from plotted import branch_along_the_speed, crossing_lines, figure, legend_texts, marks, run

from fiv_cli.case.case import FigureSpec
from fiv_cli.cli.plot import Millimetres, _plain, _showing
from fiv_cli.cli.plot import command as plot_command
from fiv_cli.cli.show import command as show_command
from fiv_cli.errors import CaseError, InputError, UsageError
from fiv_cli.flags import REASON, advice
from fiv_cli.plots import default_figures, draw, drawing, phase, smooth, style
from fiv_cli.plots import labels as words
from fiv_cli.plots.drawn import as_csv
from fiv_cli.reading.summary import lines as summary_lines
from fiv_cli.reading.summary import summarise


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


@pytest.mark.parametrize(
    ("attributes", "called"),
    [
        ({"model": "two-belts + V2 = V1"}, ["$V_{2}$ = 1 m/s", "$V_{2}$ = $V_{1}$"]),
        ({"options_json": '{"states": "slip"}'}, ["states = all", "states = slip"]),
    ],
)
def test_datasets_are_called_by_options_and_ties_before_settings(attributes, called):
    """A longer t_max was taken for what two systems differ in."""
    settings = {"response": {"kind": "response", "settings": {"t_max": 1000.0}}}
    told = {"analyses_json": json.dumps(settings), "options_json": '{"states": "all"}'}
    one = data.bifurcation().assign_attrs(told | {"model": "two-belts"})
    one = one.assign_coords(V2=((), 1.0, {"units": "m s-1"}))
    settings["response"]["settings"]["t_max"] = 5.0
    longer = told | {"analyses_json": json.dumps(settings)}
    assert words.told_apart([("one", one), ("two", one.assign_attrs(longer))]) == [
        "t_max = 1000",
        "t_max = 5",
    ]
    other = one.assign_attrs(told | longer | attributes)
    other = other.drop_vars("V2") if "model" in attributes else other
    assert words.told_apart([("one", one), ("two", other)]) == called
    more = other.assign_coords(c=0.0, k=0.0)  # with two more no word hides another
    found = words.told_apart([("one", one.assign_coords(c=1.0, k=2.0)), ("two", more)])
    assert found == ["t_max = 1000", "t_max = 5"]
    foreign = other.assign_attrs(options_json='{"modes": "0,1"}', model="disc")
    assert not any("modes" in name for name in words.told_apart([("one", one), ("two", foreign)]))


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
    assert called == ["one", "two", "t_max = 10", "t_max = 20"]


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


def test_what_may_lie_over_a_figure_of_another_file_is_told_with_what_to_type(stored):
    critical = xr.Dataset(
        {
            "status": data.statuses((), np.array("ok")),
            "critical_value": ("crossing", [0.3], {"long_name": "critical value of mu_k"}),
        },
        attrs=data.attributes(),
    )
    critical.to_netcdf(stored / "critical.nc")
    told = "fiv plot eigenvalues.nc critical.nc --figure eigenvalues\n"
    assert told in run(plot_command, "eigenvalues.nc", "critical.nc").stderr
    asked = ["--figure", "eigenvalues"]
    assert told not in run(plot_command, "eigenvalues.nc", "critical.nc", *asked).stderr
    assert "may lie over" not in run(plot_command, "eigenvalues.nc", "bifurcation.nc").stderr


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
    near = summary_lines(summarise({"": dataset.assign_coords(N=[1.0, 1.00000001])}))
    assert [line.split()[0] for line in near[near.index(text[row]) + 2 :][:3]] == [
        "1",
        "1",
        "1.00000001",
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
    assert words.told_apart(of_one) == ["t_max = 1000", "t_max = 10000"]


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
    assert 20 < len(marked) < 50 and {298.0, 299.0, 399.0} <= {*marked}
    assert 200.0 < marked.min() < 207.0  # half a mark off what is known


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


def test_what_a_figure_shows_can_be_named_on_the_command_line(tmp_path):
    """Forces of a motion: the case had to be edited, and the motion computed again."""
    file, table = tmp_path / "m.nc", tmp_path / "m.csv"
    data.history(labels=("far",)).to_netcdf(file)
    wanted = ["--figure", "history", "--variable", "F_T", "--variable", "phi"]
    assert CliRunner().invoke(plot_command, [str(file), *wanted, "-o", str(table)]).exit_code == 0
    labels = {row["y_axis"] for row in csv.DictReader(table.read_text().splitlines())}
    assert labels == {"F_T (N)", "varphi (rad)"}
    alone = CliRunner().invoke(plot_command, [str(file), "--variable", "F_T"])
    assert "--variable: of which figure?" in str(alone.exception)
    own = figure("curve", variable="L_s", ylim=[0.0, 1.0], xlim=[0.0, 9.0])
    assert set(_showing(own, ["period"]).settings) == {"variable", "xlim"}
    taken = figure("curve", variable="L_s", take={"what": "spread", "over": ["initial"]})
    with pytest.raises(UsageError, match="takes spread of its own"):
        _showing(taken, ["period"])
    levels = figure("map", variable="L_s", level={"b:boundary": "c"}, zlim=[0.0, 1.0])
    assert set(_showing(levels, ["period"]).settings) == {"variable", "level"}  # of what they are
    named = [(tmp_path, [], replace(one, name=name)) for name, one in (("a", taken), ("b", own))]
    assert _plain(named, "a") == named  # which is refused: it is asked for by its name
    assert _plain(named, "curve") == named[1:]
    ((*_, without),) = _plain(named[:1], "curve")  # its own advice led nowhere
    assert "take" not in without.settings


def test_an_end_that_is_an_edge_of_the_bracket_has_no_error_and_is_told():
    """A branch may go on beyond: its edge, off by 0, stood as an end in a figure."""
    found = data.response(np.full(4, "periodic"), np.ones(4), {"v": np.arange(4.0)})
    kinds = np.array(["bracket", "grazing", "grazing", "grazing"])
    found["cycle_highest"] = ("v", [10.0, 9.0, 8.0, 7.0], {"units": "m s-1"})
    found["cycle_highest_error"] = ("v", [0.0, 0.1, 0.1, 0.1], {"units": "m s-1"})
    found["cycle_highest_kind"] = data.flags(("v",), kinds, ("grazing", "bracket"))
    drawn = draw(found, figure("curve", variable="cycle_highest"))
    assert marks(drawn.axes[0], "_error not known").tolist() == [[0.0, 10.0]]
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
