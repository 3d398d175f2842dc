"""Figures of branches of cycles, from a case to the marks."""

from __future__ import annotations

from math import exp
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr
from matplotlib.colors import to_hex
from matplotlib.lines import Line2D

from fiv_cli import api
from fiv_cli.case.case import FigureSpec
from fiv_cli.case.load import parse_case
from fiv_cli.errors import UsageError
from fiv_cli.plots import branch, default_figures, draw, figures_of, smooth
from fiv_cli.plots.branch import _nearest
from fiv_cli.plots.diagram_lines import _beside
from fiv_cli.plots.drawn import DECORATION
from fiv_cli.plots.labels import told_apart, values_along
from fiv_cli.plots.style import BLACK, notes_on
from fiv_cli.reading.datasets import flag_names, read_analyses
from fiv_cli.reading.summary import summarise
from fiv_cli.sweep.policy import Policy
from fiv_cli.sweep.progress import for_stderr
from fiv_cli.sweep.run import run_case

CASE = """
schema = 1
title = "stick-slip, the unstable sliding cycle, and rest"
[model]
name = "belt-1dof"
[friction]
law = "stribeck"
[grid]
N = [9.0, 10.0]
[[analysis]]
kind = "cycle"
t_max = 60.0
parameter = "c"
bracket = [0.0, 2.0]
"""


@pytest.fixture(scope="module")
def branches(tmp_path_factory: pytest.TempPathFactory) -> Any:
    """The dataset of the case."""
    output = tmp_path_factory.mktemp("branches") / "branches.nc"
    run_case(parse_case(CASE, "case.toml"), output, Policy(workers=1), for_stderr(quiet=True))
    (dataset,) = read_analyses(Path(output)).values()
    return dataset


def words(flags: xr.DataArray) -> list[str]:
    return [flag_names(flags.attrs)[int(code)] for code in flags.values.ravel()]


def test_a_branch_is_stored_with_its_ends(branches: xr.Dataset) -> None:
    assert words(branches["stable"]) == ["stable", "stable"]
    assert words(branches["cycle_end_kind"]) == ["bracket", "grazing", "equilibrium"] * 2
    assert words(branches["cycle_end_goes_on"]) == ["no", "yes", "no"] * 2
    rest = branches["cycle_end"].values[[2, 5]]
    np.testing.assert_allclose(rest, [0.17 * N * exp(-1.0) for N in (9.0, 10.0)], atol=3e-6)
    assert branches["cycle_end"].attrs["units"] == "N s m-1"
    assert words(branches["cycle_highest_kind"]) == ["grazing", "grazing"]
    assert branches["cycle_section"].sizes["state"] == 2
    assert branches["branch_row_size"].sum() == branches.sizes["branch_obs"]
    counts = summarise({"": branches})["analyses"][""]["counts"]
    assert counts["cycle_end_kind"] == {"bracket": 2, "grazing": 2, "equilibrium": 2}
    assert counts["cycle_highest_kind"] == {"grazing": 2}


def test_a_branch_is_solid_where_it_is_stable_and_marked_where_it_turns(
    branches: xr.Dataset,
) -> None:
    (figure,) = [one for one in default_figures(branches) if one.kind == "branch"]
    assert figure in figures_of(branches)
    (ax,) = draw(branches, figure).axes
    drawn = [line for line in ax.lines if line.get_visible() and len(line.get_xdata())]
    dashes = [line.get_linestyle() for line in drawn if line.get_marker() == "None"]
    assert dashes == ["-", "-", "--", "--"] * 2  # least and greatest value of two branches
    grazing = [line for line in drawn if line.get_marker() == "X"]
    highest = np.repeat(branches["cycle_highest"].values, 2)
    np.testing.assert_array_equal([line.get_xdata()[0] for line in grazing], highest)
    bars = [bars for bars in ax.collections if "grazing, error bar" in bars.get_label()]
    ends = np.array([one.get_segments()[0][:, 0] for one in bars])
    error = branches["cycle_highest_error"].values
    np.testing.assert_allclose(ends, branches["cycle_highest"].values + error * [-1.0, 1.0])
    entries = [text.get_text() for text in ax.figure.legends[0].get_texts()]
    happens = ["grazing", "ends at equilibrium", "goes on beyond the bracket"]
    assert entries[2:] == ["stable", "unstable", *happens]
    assert "least and greatest" in ax.get_ylabel()


def test_marks_are_hollow_and_the_key_points_where_the_branch_goes_on(branches: xr.Dataset) -> None:
    """Beyond the lower end of the bracket; the key of a branch is its colour alone, no line."""
    (figure,) = [one for one in default_figures(branches) if one.kind == "branch"]
    (ax,) = draw(branches, figure).axes
    onwards = [line for line in ax.lines if "goes on" in str(line.get_label())]
    assert {line.get_marker() for line in onwards} == {"<"} and len(onwards) == 5
    marks = [line for line in ax.lines if line.get_marker() != "None"]
    assert {line.get_markerfacecolor() for line in marks} == {"none"}
    keys = {str(line.get_label()): line for line in ax.lines if not len(line.get_xdata())}
    branch, stable = keys["$N$ = 9 N"], keys["stable"]
    assert branch.get_linewidth() > 3.0 * stable.get_linewidth()
    assert stable.get_color() == BLACK


def test_a_branch_that_all_starts_lead_to_is_one(branches: xr.Dataset) -> None:
    (figure,) = [one for one in default_figures(branches) if one.kind == "branch"]
    alone = branches.squeeze("initial", drop=True) if "initial" in branches.dims else branches
    apart = alone.drop_vars("N").rename(N="initial").assign_coords(initial=["a", "b"])
    first = int(apart["branch_row_size"][0])
    same = apart.isel(branch_obs=np.tile(np.arange(first), 2))
    same["branch_row_size"].values[:] = first
    shorter = same.isel(branch_obs=np.arange(2 * first - first // 4))
    shorter["branch_row_size"] = same["branch_row_size"].copy(data=[first, first - first // 4])
    for dataset, starts in ((apart, {"a", "b"}), (same, {"both starts"}), (shorter, {"a", "b"})):
        lines = draw(dataset, figure).axes[0].lines
        told = {str(line.get_label()).strip("_").partition(",")[0] for line in lines}
        assert told & {"a", "b", "both starts"} == starts
    upon = [branch._upon(dataset, {"initial": 0}) for dataset in (apart, same, shorter)]
    assert upon == [0, 1, 1]  # where some lead to it alone, that is seen by its width
    apart, same, shorter = (branch.lines_apart(one) for one in (apart, same, shorter))
    assert [line.index["initial"] for line in (*apart, *same, *shorter)] == [0, 1, 0, 0]


def test_an_end_is_marked_at_the_end_of_its_branch(branches: xr.Dataset) -> None:
    """Not at another of many cycles at one value of the parameter; once, where it is gone."""
    (figure,) = [one for one in default_figures(branches) if one.kind == "branch"]
    upright = branches["branch_value"].copy(data=np.full(branches["branch_value"].size, 1.0))
    (ax,) = draw(branches.assign(branch_value=upright), figure).axes
    marks = [line for line in ax.lines if "at equilibrium" in str(line.get_label())]
    heights = [height for line in marks for height in line.get_ydata()]
    rows = np.cumsum(branches["branch_row_size"].values.ravel()) - 1
    ends = np.stack([branches[f"branch_{end}"].values[rows] for end in ("min", "max")])
    assert heights == ends.mean(axis=0).tolist()
    ax.clear()  # nor where the section is that its last cycle passes at its greatest
    greatest = branches["branch_max"].values
    passed = xr.DataArray(greatest, dims="branch_section_obs")
    counts = branches["branch_multiplicity"] * 0 + 1
    sizes = branches["branch_row_size"].rename("branch_section_row_size")
    at_greatest = branches.drop_vars(["branch_section", "branch_section_row_size"]).drop_dims(
        "branch_section_obs", errors="ignore"
    )
    at_greatest["branch_section"] = passed.assign_attrs(branches["branch_section"].attrs)
    sizes = sizes.assign_attrs(branches["branch_section_row_size"].attrs)
    at_greatest = at_greatest.assign(branch_multiplicity=counts, branch_section_row_size=sizes)
    for number in range(2):
        branch.draw_marks(ax, at_greatest, {"N": number, "initial": 0}, "k", "", at_section=True)
    marks = [line for line in ax.lines if "at equilibrium" in str(line.get_label())]
    assert [height for line in marks for height in line.get_ydata()] == heights


@pytest.mark.parametrize(("height", "seen"), [(0.002, "unstable"), (0.1, "neutral")])
def test_neutral_cycles_that_are_too_few_to_be_seen_are_not_named(height: float, seen: str) -> None:
    """Beside a Hopf point the multiplier is 1 to its digits: a key of the legend without a line."""
    heights = np.array([0.0, 0.5 * height, height, 0.3, 1.0])
    cycles = np.stack([heights**2, -heights, heights])
    words = branch._seen(np.array(["neutral"] * 3 + ["unstable"] * 2), cycles)
    assert words.tolist() == [seen] * 3 + ["unstable"] * 2


def test_of_many_cycles_at_one_value_a_change_is_marked_where_the_stability_changes() -> None:
    value, beside = np.array([1.0, 1.0, 1.0 + 1e-9, 1.1]), np.array([False, False, True, True])
    assert _nearest(value, 1.0, 1e-6, beside) == 2
    assert _nearest(value, 1.0, np.nan, beside) == 0
    assert _nearest(value, 1.09, 1e-6, ~beside) == 3


def test_a_dataset_without_branches_says_what_to_do(branches: xr.Dataset) -> None:
    (figure,) = [one for one in default_figures(branches) if one.kind == "branch"]
    with pytest.raises(UsageError, match="parameter and a bracket"):
        draw(branches.drop_vars("branch_value"), figure)


TWO = """
schema = 1
[model]
name = "belt-1dof"
[grid]
c = [0.1, 0.2]
N = [9.0, 10.0]
[sweep]
zip = [["c", "N"]]
[[initial]]
kind = "state"
state = { x = 10.0 }
[[analysis]]
"""
DIAGRAM = """kind = "response"
section = { event = "slip->stick" }
"""
BRANCH = """kind = "cycle"
section = { event = "slip->stick" }
parameter = "v"
bracket = [0.3, 6.0]
"""


def test_branches_have_the_colours_of_the_diagrams_of_their_parameters(tmp_path: Path) -> None:
    """Of a diagram of two parameters that advance together, too; with marks where they end."""
    speeds = "[grid]\nv = { start = 0.5, stop = 4.5, num = 5 }\n"
    sources = []
    for name, case in (("d", TWO.replace("[grid]\n", speeds) + DIAGRAM), ("b", TWO + BRANCH)):
        path = tmp_path / f"{name}.nc"
        run_case(parse_case(case, "c.toml"), path, Policy(workers=1), for_stderr(quiet=True))
        sources.append((name, read_analyses(path)))
    spec = FigureSpec("diagram", "bifurcation", {"x": "v"})
    (ax,) = draw(sources, spec).axes
    assert ax.get_ylabel() == r"$x$ at slip $\to$ stick (m)"
    lines = {str(line.get_label()).removeprefix("_"): line for line in ax.lines}
    colours = set()
    for place in ("$c$ = 0.1 N s/m, $N$ = 9 N", "$c$ = 0.2 N s/m, $N$ = 10 N"):
        own = {lines[f"{place}{what}"].get_color() for what in ("", ", stable cycle", ", grazing")}
        assert len(own) == 1
        colours |= own
    assert len(colours) == 2
    assert {"stable cycle", "grazing"} <= {*lines}


def flutter(**tables: Any) -> Any:
    """A case of flutter under friction of 5 along mu_k, at which all turning points are kept."""
    return {
        "schema": 1,
        "model": {"name": "flutter-2dof", "parameters": {"c1": 0.1, "c2": 0.1}}
        | {"options": {"states": "all"}},
        "friction": {"law": "coulomb", "mu_k": 5.0},
        "initial": [{"kind": "state"}],
    } | tables


def test_neutral_cycles_are_in_a_diagram_too() -> None:
    """They join a branch to the equilibrium that it ends at."""
    table = flutter()
    section = {"observe": "x", "section": {"zero": "x_dot", "direction": "both"}}
    followed = {"kind": "cycle", "parameter": "mu_k", "bracket": [3.0, 8.8], "t_max": 600.0}
    cycles = api.run(api.load(table | {"analysis": [section | followed | {"transient": 500.0}]}))
    swept = table | {"analysis": [section | {"kind": "response", "t_max": 600.0}]}
    found = api.run(api.load(swept, {"grid.mu_k": [5.0, 6.0, 7.0]}))
    (diagram,) = [one for one in default_figures(found) if one.kind == "bifurcation"]
    (ax,) = draw([("", found), ("", cycles)], diagram).axes
    neutral = [line for line in ax.lines if str(line.get_label()).endswith("neutral cycle")]
    drawn = [line.get_xydata() for line in neutral if len(line.get_xdata())]
    at = np.concatenate(drawn)
    np.testing.assert_allclose(at[:, 0], 4.38133283987, atol=1e-6)
    assert np.ptp(at[:, 1]) > 1.3


@pytest.fixture(scope="module")
def fluttering(tmp_path_factory: pytest.TempPathFactory) -> tuple[Any, Any]:
    """The steady states between 4 and 6 with their eigenvalues, and the branch of the cycle."""
    section = {"observe": "x", "section": {"zero": "x_dot", "direction": "both"}}
    followed = {"kind": "cycle", "parameter": "mu_k", "bracket": [3.0, 8.8], "t_max": 600.0}
    cycles = api.run(api.load(flutter(analysis=[section | followed | {"transient": 500.0}])))
    response = section | {"kind": "response", "t_max": 600.0}
    swept = flutter(analysis=[response, {"kind": "eigenvalues"}])
    path = tmp_path_factory.mktemp("fluttering") / "swept.nc"
    case = api.load(swept, {"grid.mu_k": [4.0, 5.0, 6.0]})
    run_case(case, path, Policy(workers=1), for_stderr(quiet=True))
    return read_analyses(path), cycles


def test_a_point_without_a_branch_leaves_the_others_in_a_diagram(tmp_path: Path) -> None:
    """One that came to rest has no cycle; the diagram is that of what there is."""
    rest = '[[initial]]\nkind = "equilibrium"\nlabel = "rest"\n'
    speeds = "[grid]\nv = { start = 0.5, stop = 4.5, num = 5 }\n"
    branch = TWO.replace("[[analysis]]", f"{rest}[[analysis]]") + BRANCH
    sources = []
    for name, case in (("d", TWO.replace("[grid]\n", speeds) + DIAGRAM), ("b", branch)):
        path = tmp_path / f"{name}.nc"
        run_case(parse_case(case, "c.toml"), path, Policy(workers=1), for_stderr(quiet=True))
        sources.append((name, read_analyses(path)))
    (ax,) = draw(sources, FigureSpec("diagram", "bifurcation", {"x": "v"})).axes
    assert [line for line in ax.lines if "stable cycle" in str(line.get_label())]
    draw(sources[1][1], FigureSpec("alone", "branch", {}))


def test_equilibria_change_where_a_branch_ends_at_one(fluttering: tuple[Any, Any]) -> None:
    """Or, where no branch is drawn with them, where a line between growth rates is zero."""
    found, cycles = fluttering
    (diagram,) = [one for one in default_figures(found) if one.kind == "bifurcation"]
    growth = found["eigenvalues"]["growth_rate"]
    between = float(np.interp(0.0, growth.values, growth["mu_k"].values))
    assert abs(between - 4.38133283987) < 0.07  # of points that are 1 apart
    for datasets, change in (([found, cycles], 4.38133283987), ([found], between)):
        (ax,) = draw([("", one) for one in datasets], diagram).axes
        lines = {str(line.get_label()).removeprefix("_"): line for line in ax.lines}
        stable, unstable = (
            lines[f"{word} equilibrium"].get_xydata() for word in ("stable", "unstable")
        )
        known = [line[np.isfinite(line).all(axis=1), 0] for line in (stable, unstable)]
        assert known[0].max() == known[1].min() == pytest.approx(change, abs=1e-6)


def doubled(cycles: xr.Dataset) -> xr.Dataset:
    """The branch of one start as that of two, which is stored twice."""
    ragged = [str(dim) for dim in cycles.dims if str(dim).endswith("_obs")]
    twice = {dim: np.tile(np.arange(cycles.sizes[dim]), 2) for dim in ragged}
    return cycles.isel(twice | {"initial": [0, 0]}).assign_coords(initial=["a", "b"])


@pytest.mark.parametrize("kind", ["bifurcation", "curve"])
def test_a_branch_that_two_starts_lead_to_is_drawn_once(
    fluttering: tuple[Any, Any], kind: str
) -> None:
    """Dashes over dashes would be a line."""
    found, cycles = fluttering
    asked = {"variable": "x_amplitude"} if kind == "curve" else {"x": "mu_k"}
    spec = FigureSpec(kind, kind, {**asked, "analysis": "response"})
    told = []
    for over in (cycles, doubled(cycles)):
        (ax,) = draw([("", found), ("", over)], spec).axes
        lines = [line for line in ax.lines if len(line.get_xdata())]
        names = [str(line.get_label()).removeprefix("_") for line in lines]
        told.append(sorted(name for name in names if "cycle" in name or "grazing" in name))
    assert told[0] == told[1] and told[0]


def test_of_two_variables_each_has_the_branch_of_the_file_that_tells_of_it(
    fluttering: tuple[Any, Any],
) -> None:
    """And neither is said to lack one; of what no file tells one cycle is drawn."""
    found, cycles = fluttering
    of_y = cycles.copy()
    for end in ("branch_min", "branch_max"):
        words = cycles[end].attrs["long_name"].replace(" x ", " y ")
        of_y[end] = cycles[end].assign_attrs(long_name=words)
    asked = {"variable": ["x_amplitude", "y_amplitude"], "analysis": "response"}
    spec = FigureSpec("curve", "curve", asked)
    for files, lacking in (((cycles,), 1), ((cycles, of_y), 0)):
        layers = [("", found), *((f"of {number}", one) for number, one in enumerate(files))]
        (ax,) = draw(layers, spec).axes
        told = [one for one in notes_on(ax.figure) if "tells of another state" in one]
        assert len(told) == lacking and all('observe = "y"' in note for note in told)
        lines = [line for line in ax.lines if len(line.get_xdata())]
        branches = [str(line.get_label()) for line in lines if "cycle" in line.get_label()]
        named = {state for state in "xy" if any(f"of ${state}$" in label for label in branches)}
        assert named == ({"x"} if lacking else {"x", "y"})


def test_a_curve_of_an_amplitude_has_the_branch_that_is_drawn_with_it(
    fluttering: tuple[Any, Any],
) -> None:
    found, cycles = fluttering
    for name in ("x_amplitude", "x_max", "x_min"):
        spec = FigureSpec("curve", "curve", {"variable": name, "analysis": "response"})
        (ax,) = draw([("", found), ("", cycles)], spec).axes
        words = [str(text.get_text()) for text in ax.get_legend().get_texts()]
        assert {"stable cycle", "unstable cycle", "neutral cycle"} <= {*words}
        rests = [line for line in ax.lines if "unstable equilibrium" in str(line.get_label())]
        assert bool(rests) == (name == "x_amplitude")
        at = np.concatenate([line.get_xydata() for line in rests] or [np.zeros((0, 2))])
        at = at[np.isfinite(at[:, 1])]  # from where the cycle is born
        expected = [[4.38133283987, 0.0], [5.0, 0.0], [6.0, 0.0]] if rests else np.zeros((0, 2))
        np.testing.assert_allclose(at, expected, atol=1e-6)
        stable = [line for line in ax.lines if "_stable equilibrium" in str(line.get_label())]
        places = [line.get_xydata()[np.isfinite(line.get_ydata())].tolist() for line in stable]
        met = [[4.0, 0.0], [pytest.approx(4.38133283987, abs=1e-6), 0.0]]
        assert places == ([met] if rests else [])
        drawn = [line.get_xydata() for line in ax.lines if "stable cycle" in str(line.get_label())]
        (own,) = (line[np.isclose(line[:, 0], 5.0)] for line in drawn if 5.0 in line[:, 0])
        steady = found["response"][name].sel(mu_k=5.0).squeeze()
        assert own[0, 1] == pytest.approx(float(steady), rel=1e-6)
        orders: dict[bool, set[float]] = {True: set(), False: set()}
        for line in told_lines(ax):
            told = any(one in str(line.get_label()) for one in (" cycle", " equilibrium"))
            orders[told].add(line.get_zorder())
        assert max(orders[True]) < min(orders[False])  # which start leads there is seen


def told_lines(ax: Any) -> list[Any]:
    """The lines of a panel that its table has: a smooth one through the points is none."""
    told = (line for line in ax.lines if line.get_label() != DECORATION)
    return [line for line in told if len(line.get_xdata()) > 1]


def test_a_branch_over_one_sweep_leaves_this_its_names_and_says_what_it_lacks(
    fluttering: tuple[Any, Any],
) -> None:
    found, cycles = fluttering
    spec = FigureSpec("curve", "curve", {"variable": "x_amplitude", "analysis": "response"})
    drawn = draw([("sweep", found), ("cycles", cycles)], spec)
    words = [str(text.get_text()) for text in drawn.axes[0].get_legend().get_texts()]
    assert not any("sweep" in word for word in words) and not notes_on(drawn)
    through = [line for line in drawn.axes[0].lines if line.get_label() == DECORATION]
    assert max(len(line.get_xdata()) for line in through) > 3 * max(
        len(line.get_xdata()) for line in told_lines(drawn.axes[0])
    )
    spec = FigureSpec("curve", "curve", {"variable": "x_dot_amplitude", "analysis": "response"})
    (note,) = notes_on(draw([("sweep", found), ("cycles", cycles)], spec))
    assert note.startswith("x_dot_amplitude of one cycle of cycles: its branch tells of another")
    assert note.endswith('observe = "x_dot" in its analysis, or in that of a file drawn with it')
    none = cycles.isel(branch_obs=slice(0)).assign(branch_row_size=cycles["branch_row_size"] * 0)
    (note,) = notes_on(draw([("sweep", found), ("cycles", none)], spec))
    assert note == "no branch of cycles: of the starts drawn none found a cycle"


def test_a_branch_beside_starts_is_not_told_by_the_start_that_it_was_found_from() -> None:
    """Where it leads this start may end elsewhere."""
    starts = [{"label": "one", "kind": "state"}]
    starts += [{"label": "two", "kind": "state", "state": {"x": 3.0}}]
    section = {"observe": "x", "section": {"zero": "x_dot", "direction": "both"}}
    followed = {"kind": "cycle", "parameter": "mu_k", "bracket": [4.9, 5.1], "transient": 500.0}
    table = flutter(initial=starts)
    cycles = api.run(api.load(table | {"analysis": [section | followed | {"t_max": 600.0}]}))
    response = api.load(
        table | {"analysis": [section | {"kind": "response", "t_max": 600.0}]},
        {"grid.mu_k": [4.95, 5.0, 5.05]},
    )
    spec = FigureSpec("curve", "curve", {"variable": "x_amplitude", "x": "mu_k"})
    (ax,) = draw([("", api.run(response)), ("", cycles)], spec).axes
    branch, reached = (
        {line.get_color() for line in told_lines(ax) if (" cycle" in str(line.get_label())) is told}
        for told in (True, False)
    )
    assert len(branch) == 1 and reached and not branch & reached


def test_a_dataset_at_one_place_of_the_abscissa_is_drawn_there() -> None:
    """One that differs in more is drawn across, as what it is compared with."""
    spec = FigureSpec("curve", "curve", {"variable": "growth_rate"})
    swept, one, other = (
        api.run(api.load(flutter(analysis=[{"kind": "eigenvalues"}]), changes))
        for changes in (
            {"grid.mu_k": [4.0, 5.0, 6.0]},
            {"friction.mu_k": 5.5},
            {"friction.mu_k": 5.5, "model.parameters.c2": 0.2},
        )
    )
    for dataset, places in ((one, [5.5]), (other, [4.0, 6.0])):
        (ax,) = draw([("swept", swept), ("one", dataset)], spec).axes
        (line,) = [one for one in ax.lines if one.get_label() == "one"]
        assert line.get_xdata().tolist() == places


def test_neutral_cycles_that_cannot_be_seen_have_no_entry() -> None:
    """Next to where a cycle is born its multiplier is 1 to all digits, whatever it is beyond."""
    table = {
        "schema": 1,
        "model": {"name": "belt-1dof", "parameters": {"k": 100.0, "c": 1.0, "N": 10.0, "v": 0.4}},
        "friction": {"law": "stribeck", "mu_s": 0.4, "mu_k": 0.25, "v_s": 0.1},
        "initial": [{"kind": "state", "state": {"x": 0.0635}}],
    }
    followed = {"kind": "cycle", "parameter": "v", "bracket": [0.1, 0.9], "width": 1e-9}
    section = {"zero": "x_dot", "direction": "down"}
    cycles = api.run(api.load(table | {"analysis": [followed | {"section": section}]}))
    assert "neutral" in words(cycles["branch_stable"])
    (ax,) = draw(cycles, FigureSpec("branch", "branch", {})).axes
    assert not [line for line in ax.lines if "neutral" in str(line.get_label())]
    assert [line for line in ax.lines if line.get_label() == "unstable"]


def test_datasets_of_an_axis_of_one_value_are_called_by_it() -> None:
    one, other = (
        xr.Dataset(
            {"status": ("c", [0])},
            {"c": ("c", [c], {"units": "N s m-1", "symbol": "c"}), "N": 9.0},
        )
        for c in (0.1, 0.2)
    )
    assert told_apart([("a", one), ("b", other)]) == ["$c$ = 0.1 N s/m", "$c$ = 0.2 N s/m"]


def test_values_that_advance_together_and_are_equal_are_one_word() -> None:
    damping = {"units": "N s m-1"}
    c1, c2 = (xr.DataArray([0.1, 0.2], attrs=damping | {"symbol": f"c_{n}"}) for n in (1, 2))
    assert values_along([c1, c2], 1) == ["$c_1$ = $c_2$ = 0.2 N s/m"]
    assert values_along([c1, 2.0 * c2.assign_attrs(damping)], 0)[0] == "$c_1$ = 0.1 N s/m"


def test_a_branch_that_is_a_part_of_anothers_is_seen_beneath_it() -> None:
    """Its cycles are others, and lie on the same line."""
    turn = np.linspace(0.0, np.pi, 41)
    constant = np.full(turn.shape, 5.0) * (1.0 + 1e-16 * np.arange(41))  # the least at a stop
    whole = np.stack([np.cos(turn), np.sin(turn), constant], axis=-1)
    part = (0.5 * (whole[1:] + whole[:-1]))[:15]
    assert branch._lies_on(part, whole) and not branch._lies_on(whole, part)
    assert not branch._lies_on(part + np.array([0.0, 0.1, 0.0]), whole)
    assert not branch._lies_on(part[:0], whole) and not branch._lies_on(part, whole[:1])


@pytest.mark.parametrize("words", [{}, {"stable cycle": "cycle", "unstable cycle": "cycle"}])
def test_no_two_keys_of_amplitudes_look_alike_whichever_file_is_first(
    fluttering: tuple[Any, Any], words: dict[str, str]
) -> None:
    spec = FigureSpec("curve", "curve", {"variable": "x_amplitude", "words": words})
    told = []
    for layers in ([("", one) for one in fluttering], [("", one) for one in fluttering[::-1]]):
        (ax,) = draw(layers, spec).axes
        legend = ax.get_legend()
        keys = [one for one in legend.legend_handles if isinstance(one, Line2D)]
        looks = [(to_hex(k.get_color()), k.get_linestyle(), k.get_marker()) for k in keys]
        assert len({*looks}) == len(looks)
        told.append([text.get_text() for text in legend.get_texts()])
        assert told[-1].count("cycle") == 2 * bool(words)  # a solid line and dashes
    assert told[0] == told[1]


def test_of_a_branch_that_another_file_has_its_own_part_alone_is_drawn() -> None:
    """Dashes of both filled each other's gaps, and an unstable cycle was solid; their points are
    others."""
    first, second = (np.linspace(*ends) for ends in ((0.0, 2.0, 41), (0.5, 3.0, 33)))
    shown = _beside(second, second**2, [(first, first**2)])
    np.testing.assert_array_equal(np.isfinite(shown), second >= second[second <= 2.0].max())
    other = _beside(second, second**2 + 0.1, [(first, first**2)])
    assert np.isfinite(other).all()
    x = np.linspace(0.0, 1.0, 11)
    for heights in (1.0 - x, x[0] - x):  # crosses it, or begins on it
        assert np.isfinite(_beside(x, heights, [(x, x)])).all()
    assert np.isfinite(_beside(x, 0.0 * x + 1.5e-3, [(x, 0.0 * x + 1.0e-3)])).all()  # both level


def test_a_smooth_line_leaves_a_fold_upright() -> None:
    """Beside it lies a point as high, which shows no direction: a parabola, to 1 % of its width."""
    height = np.array([0.0, 0.0, 0.3, 0.5, 0.7, 0.9, 1.1])
    value = height**2 + np.array([0.0, 1e-8, *[0.0] * 5])
    x, y = smooth.along(value, height)
    assert [x[0], y[0], x[-1], y[-1]] == pytest.approx([0.0, 0.0, value[-1], 1.1], abs=1e-12)
    assert np.abs(x - y**2).max() < 0.0121
