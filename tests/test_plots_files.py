"""Figures as files."""

import csv
import json
from itertools import combinations, pairwise

import numpy as np
import pytest
import synthetic_datasets as data
import xarray as xr
from plotted import figure

from fiv_cli.errors import StorageError, UsageError
from fiv_cli.plots import default_figures, draw, look_of, save, style
from fiv_cli.plots.captions import caption
from fiv_cli.plots.cloud_marks import THINNED

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


def test_a_caption_has_the_law_and_the_few_starts_of_a_table_and_all_that_advances_together():
    case = "[friction]\nlaw = 'stribeck'\n[[initial]]\nlabel = 'mine'\nkind = 'table'\n"
    found = data.bifurcation().assign_coords(initial=["mine-000", "mine-001"])
    states = np.broadcast_to([[0.5, 2.0], [0.25, 0.0]], (found.sizes["Omega"], 2, 2))
    found["initial_state"] = ("Omega", "initial", "state"), states
    units = {"state": ["phi", "phi_dot"], "state_units": ("state", ["rad", "rad s-1"])}
    found = found.assign_coords(units).assign_attrs(case=case, law="stribeck")
    found.attrs["starts_json"] = json.dumps({"mine": "table"})
    (note,) = style.notes_on(draw(found, figure("curve"), look=look_of("paper")))
    assert note == (
        "for the caption: law: stribeck; mine 000: phi = 0.5 rad, phi_dot = 2 rad/s; "
        "mine 001: phi = 0.25 rad, phi_dot = 0 rad/s; "
        "lines break where the class of motion changes"
    )
    chosen = {"geometry": "linear", "impact": "plastic", "states": "all"}
    found = found.assign_attrs(
        case='[model.options]\ngeometry = "linear"\n', options_json=json.dumps(chosen)
    )
    for share, words in ((0.0, "geometry: linear; "), (0.3, "geometry: linear, impact: plastic; ")):
        found["separation_fraction"] = found["L_s"] * 0.0 + share
        (note,) = style.notes_on(draw(found, figure("curve"), look=look_of("paper")))
        assert words in note and "states" not in note  # which says nothing of what is drawn
    by_hand = found.assign_attrs(overrides='model.options.states="slip"')
    by_hand.attrs["options_json"] = json.dumps(chosen | {"states": "slip"})
    by_hand = by_hand.assign_coords(
        c1=((), 2.0, {"units": "N", "symbol": "c_1 = c_2"}),
        c2=((), 2.0, {"units": "N", "symbol": "c_2"}),
    )
    by_hand.attrs["case"] += '[model.parameters]\nc1 = 2.0\nc2 = "c1"\n'
    (note,) = style.notes_on(draw(by_hand, figure("curve"), look=look_of("paper")))
    assert "states: slip" in note and note.count("c_2 = 2 N") == 1
    fixed = {"F": ((), 1000.0, {"units": "N"}), "u0": ((), 0.0, {"units": "m"})}
    left = found.assign_coords(fixed)
    left = left.assign_attrs(case="[model]\nparameters = { k = 2.0 }\n")
    (note,) = style.notes_on(draw(left, figure("curve"), look=look_of("paper")))
    assert "; by default F = 1000 N; " in note  # and not what is 0
    many = left.assign_coords({f"p{n}": ((), 1.0 + n) for n in range(9)})
    (note,) = style.notes_on(draw(many, figure("curve"), look=look_of("paper")))
    assert "; 10 parameters by default (fiv models " in note  # which not all options need
    by_hand = left.assign_attrs(overrides="model.parameters.F=1000.0")
    (note,) = style.notes_on(draw(by_hand, figure("curve"), look=look_of("paper")))
    assert "by default" not in note
    given = left.assign_attrs(case="[model]\nparameters = { F = 1000.0 }\n")
    (note,) = style.notes_on(draw(given, figure("curve"), look=look_of("paper")))
    assert "F = 1000 N" in note and "by default" not in note
    together = data.bifurcation().isel(initial=[0]).rename(initial="pair")
    together = together.assign_coords(
        c1=("pair", [20.0], {"units": "N s m-1"}), c2=("pair", [4.0], {"units": "N s m-1"})
    ).drop_vars("pair")
    told = style.notes_on(draw(together, figure("curve"), look=look_of("paper")))
    assert "c1 = 20 N s/m, c2 = 4 N s/m" in told[-1].replace("_", "")
    assert "by default" not in told[-1]  # what advances together is none


def test_ticks_are_in_the_power_of_ten_that_the_label_has_beside_the_unit(tmp_path):
    """It stood over the label of a narrow panel; a table has the numbers themselves."""
    found = data.stability_map().assign_coords(
        Omega=lambda of: of["Omega"].copy(data=1e4 * of["Omega"].values)
    )
    found["Omega"].attrs["units"] = "N m-1"
    drawn = draw(found, figure("map", variable="L_s"), look=look_of("paper"))
    drawn.draw_without_rendering()
    lower = [ax for ax in drawn.axes if ax.get_xlabel()]
    for ax in lower:
        assert ax.get_xlabel().endswith("($10^{5}$ N/m)")
        assert not ax.xaxis.get_offset_text().get_visible()
        boxes = [text.get_window_extent() for text in ax.get_xticklabels() if text.get_text()]
        inside = [box for box in boxes if ax.bbox.x0 < 0.5 * (box.x0 + box.x1) < ax.bbox.x1]
        assert len(inside) > 1
        assert all(one.x1 < other.x0 for one, other in pairwise(inside))
    curve = draw(found, figure("curve", x="Omega", select={"N0": float(found["N0"][0])}))
    save(curve, tmp_path / "a.csv")
    rows = [*csv.DictReader((tmp_path / "a.csv").read_text().splitlines())]
    assert {row["x_axis"] for row in rows} == {"disc speed Omega (N/m)"}
    assert max(float(row["x"]) for row in rows) == found["Omega"].values.max()


def test_a_power_of_ten_that_not_all_panels_beside_a_label_have_stays_at_each():
    """The label of the first would have read the others wrong; and what is no unit is none."""
    found = data.history(labels=("a", "b"))
    found["phi"] = found["phi"] * xr.DataArray([1e-4, 1.0], dims="initial")
    first, second = draw(found, figure("history", variable="phi")).axes
    assert first.get_ylabel() == r"$\varphi$ (rad)" and second.get_ylabel() == ""
    assert first.yaxis.get_offset_text().get_visible()
    small = data.history(labels=("a", "b"))
    small["phi"] = 1e-4 * small["phi"]
    alike = draw(small, figure("history", variable="phi"))
    assert alike.axes[0].get_ylabel().endswith("$ rad)")
    assert not any(ax.yaxis.get_offset_text().get_visible() for ax in alike.axes)
    curve = data.bifurcation().isel(initial=[0])
    for asked, told in (("load (normal)", "load (normal) ($10^{-4}$)"), ("a $", "a $"),
                        ("rate (1/s)", "rate ($10^{-4}$ 1/s)"),
                        ("rate (static) (1/s)", "rate (static) ($10^{-4}$ 1/s)")):  # fmt: skip
        drawn = draw(curve, figure("curve", variable="L_s", ylabel=asked))
        assert drawn.axes[0].get_ylabel() == told


@pytest.mark.parametrize("height", [60.0, 68.5, 77.0])
def test_a_label_is_whole_though_ticks_and_panels_could_change_in_turns(height):
    """One more tick of longer numbers made its panel lower, and so went away, again and again."""
    found = data.response(
        np.full((13, 1), "periodic", object), np.linspace(0.0, 0.0169, 13)[:, None],
        data.axes(Omega=np.linspace(0.2, 1.4, 13), initial=["a"]),
    )  # fmt: skip
    paper = look_of("paper", height=height)
    drawn = draw(found, figure("curve", variable="L_s"), look=paper)
    drawn.draw_without_rendering()
    assert drawn.axes[0].yaxis.label.get_window_extent().x0 >= 0.0


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
    of_one = draw(data.bifurcation(), figure(kind, select={"initial": "near"}), look=paper)
    (note,) = style.notes_on(of_one)
    assert note.startswith("for the caption: start: near")  # which a title would tell
    case = "[model]\nparameters = { N = 5.0 }\n[[initial]]\nlabel = 'any'\nkind = 'random'\n"
    given = data.bifurcation().assign_attrs(case=case).assign_coords(N=((), 5.0, {"units": "N"}))
    breaks = "; lines break where the class of motion changes" if kind == "curve" else ""
    random = "[[initial]]\nlabel = 'any'\nkind = 'random'\ncount = {}\nbox = {{ phi = [0, 1] }}\n"
    files = [
        (name, given.assign_coords(initial=["any-0", "any-1"]).assign_attrs(case=random.format(n)))
        for name, n in (("a", 100), ("b", 400))
    ]
    told = "".join(style.notes_on(draw(files, figure(kind), look=paper)))
    assert "file by file: any: 100 random starts, phi from 0 to 1 | any: 400 random" in told
    told = [f"for the caption: N = 5 N{breaks}"]
    thinned = [THINNED] * (kind == "bifurcation")  # for want of room
    assert style.notes_on(draw(given, figure(kind), look=paper)) == [*thinned, *told]
    of_drive = {"role": "frequency", "units": "rad s-1", "long_name": "frequency of the drive"}
    driven = [
        given.assign_coords(
            A=((), force, {"units": "N", "long_name": "amplitude of the drive"}),
            omega=((), 2.0, of_drive),
        )
        for force in (0.0, 0.1)
    ]
    with style.looks(look=paper):  # a drive that is off has no frequency to tell of
        for some, told_too in (([0, 0], False), ([0, 1], True), ([1, 0], True)):
            (words,) = caption(drawn, [driven[number] for number in some])
            assert ("omega = 2 rad/s" in words) == told_too
    files = [("a", given), ("b", given.assign_coords(N=((), 6.0, {"units": "N"})))]
    assert not any("N = " in note for note in style.notes_on(draw(files, figure(kind), look=paper)))
    other = [("a", given), ("b", given.assign_attrs(case="", law="stribeck"))]  # its default
    (note,) = [n for n in style.notes_on(draw(other, figure(kind), look=paper)) if "caption" in n]
    assert note == told[0]
    of_two = given.drop_vars("N").expand_dims(N=[5.0, 6.0])  # with an axis that has it, too
    of_two["N"].attrs["units"] = "N"
    with style.looks(look=paper):
        for beside in (of_two.isel(N=[0]), of_two):
            beside = beside.assign_coords(crossing=("crossing", [0]))  # as of critical values
            assert caption(drawn, [given, beside]) == told
        assert not any("N = " in one for one in caption(drawn, [given, of_two]))  # whose lines are
        assert not any("N = " in told for told in caption(drawn, [given, of_two.isel(N=[1])]))
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


def test_no_number_is_parted_from_its_unit():
    words = "exponential ($\\alpha$ = 1 s/m, $c_1$ = 0.05 N s/m), far"
    lines = [line for most in range(12, 40) for line in style.folded(words, most).splitlines()]
    assert not [line for line in lines if line.startswith(("s/m", "N ", "= "))]


def test_files_of_other_titles_say_that_there_is_none():
    one, other = data.bifurcation(), data.bifurcation()
    other.attrs["title"] = "Another"
    for second, told in ((one, 0), (other, 1)):
        drawn = draw([("a", one), ("b", second)], figure("curve"))
        notes = [note for note in style.notes_on(drawn) if note.startswith("no title")]
        assert len(notes) == told
        assert ("A sweep" in drawn.get_suptitle()) == (not told)


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
