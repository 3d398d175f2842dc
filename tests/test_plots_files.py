"""Figures as files."""

from itertools import combinations

import pytest
import synthetic_datasets as data
from plotted import figure

from fiv_cli.errors import StorageError, UsageError
from fiv_cli.plots import default_figures, draw, look_of, save, style

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
    of_one = draw(data.bifurcation(), figure(kind, select={"initial": "near"}), look=paper)
    assert "for the caption: start: near" in style.notes_on(of_one)  # which a title would tell
    case = "[model]\nparameters = { N = 5.0 }\n[[initial]]\nlabel = 'any'\nkind = 'random'\n"
    given = data.bifurcation().assign_attrs(case=case).assign_coords(N=((), 5.0, {"units": "N"}))
    assert style.notes_on(draw(given, figure(kind), look=paper)) == ["for the caption: N = 5 N"]
    files = [("a", given), ("b", given.assign_coords(N=((), 6.0, {"units": "N"})))]
    assert not any(
        "caption" in note for note in style.notes_on(draw(files, figure(kind), look=paper))
    )
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
