"""A refined sweep: few runs, the whole picture, and the same bits however it came about."""

from __future__ import annotations

import dataclasses
import re
import shlex
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import sweep_fakes
import xarray as xr

from fiv_cli.case.load import parse_case
from fiv_cli.data.netcdf import read_datasets
from fiv_cli.errors import CaseError
from fiv_cli.flags import ATTRACTOR, COMPUTED, REASON, STATUS
from fiv_cli.plots import map as maps
from fiv_cli.plots import points
from fiv_cli.reading.claims import evaluate
from fiv_cli.reading.summary import lines, summarise
from fiv_cli.sweep.plan import make_plan
from fiv_cli.sweep.policy import Policy
from fiv_cli.sweep.progress import Bar, Lines, Silent
from fiv_cli.sweep.run import Summary, run_case

HERE = Policy(workers=1, executor="sweep_fakes:region", preparer="sweep_fakes:prepare")
FULL = sweep_fakes.REFINED.replace('refine = { levels = 3, of = "attractor" }', "").replace(
    "num = 9", "num = 65"
).replace("num = 5", "num = 33")  # fmt: skip

CLAIMS = """
[[claim]]
source = "test"
text = "no vibration at the edge"
variable = "attractor"
at = { N = 1.0 }
expect = "equilibrium"
[[claim]]
source = "test"
text = "none anywhere"
variable = "attractor"
expect = "equilibrium"
[[claim]]
source = "test"
text = "a number that most points have not"
variable = "L_s"
expect = { value = 5, tolerance = 5 }
"""


def sweep(output: Path, text: str = sweep_fakes.REFINED, **changes: Any) -> Summary:
    """Run a case from text."""
    return run_case(sweep_fakes.case(text), output, dataclasses.replace(HERE, **changes), Silent())


def dataset(path: Path) -> xr.Dataset:
    """The one dataset of a file."""
    return read_datasets(path)[""]


def is_code(array: xr.DataArray, code: int) -> np.ndarray:
    """Where a flag has a value."""
    return (array == code).values


def test_the_picture_is_that_of_the_full_grid(tmp_path: Path) -> None:
    summary = sweep(tmp_path / "a.nc")
    sweep(tmp_path / "full.nc", FULL)
    refined, full = dataset(tmp_path / "a.nc"), dataset(tmp_path / "full.nc")
    assert refined["attractor"].shape == (65, 33, 2)
    for axis in ("N", "v"):
        assert (refined[axis].values == full[axis].values).all()
    assert (refined["attractor"].values == full["attractor"].values).all()
    run = refined["computed"].values > 0
    assert is_code(refined["computed"], COMPUTED.codes["run"]).mean() < 0.5
    assert (refined["L_s"].values[run] == full["L_s"].values[run]).all()
    assert np.isnan(refined["L_s"].values[~run]).all()
    assert (is_code(refined["status"], STATUS.codes["ok"]) == run).all()
    assert (is_code(refined["reason"], REASON.codes["filled_in"]) == ~run).all()
    assert summary.complete
    assert summary.counts["ok"] == run.sum() == summary.ran
    assert summary.counts["not_computed"] == (~run).sum()


def test_each_start_is_refined_along_its_own_border(tmp_path: Path) -> None:
    sweep(tmp_path / "a.nc")
    computed = dataset(tmp_path / "a.nc")["computed"]
    shares = (computed > 0).mean(["N", "v"])
    assert float(shares.sel(initial="near")) < float(shares.sel(initial="far"))
    first = sweep_fakes.REFINED.split("[[initial]]")
    alone = "[[initial]]".join([first[0], first[2]])
    sweep(tmp_path / "far.nc", alone)
    one = dataset(tmp_path / "far.nc")["computed"]
    assert (one.sel(initial="far").values == computed.sel(initial="far").values).all()


def test_workers_chunks_and_interruptions_leave_no_trace(tmp_path: Path) -> None:
    text = sweep_fakes.REFINED.replace("levels = 3", "levels = 2, sample = 20")
    sweep(tmp_path / "a.nc", text)
    expected = (tmp_path / "a.nc").read_bytes()
    for name, changes in {
        "few": {"chunk_points": 17},
        "many": {"chunk_points": 1000},
        "workers": {"workers": 2, "in_process_below": 0.0, "chunk_points": 60},
    }.items():
        sweep(tmp_path / f"{name}.nc", text, **changes)
        assert (tmp_path / f"{name}.nc").read_bytes() == expected, name
    for count in (1, 50, 100, 200):
        partial = sweep(tmp_path / "parts.nc", text, max_points=count, chunk_points=40)
        assert (partial.ran, partial.complete) == (count, False)
        assert "so far" in partial.lines()[-2]
    assert sweep(tmp_path / "parts.nc", text).complete
    assert (tmp_path / "parts.nc").read_bytes() == expected
    (tmp_path / "parts.nc").unlink()
    assert sweep(tmp_path / "parts.nc", text).ran == 0
    assert (tmp_path / "parts.nc").read_bytes() == expected


def test_points_are_those_of_the_full_grid_both_ways(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("FIV_TEST_COUNT", str(tmp_path / "count"))
    counted = {"executor": "sweep_fakes:region_counted"}
    refined = sweep(tmp_path / "a.nc", **counted).ran
    expected = (tmp_path / "a.nc").read_bytes()
    full = sweep(tmp_path / "a.nc", FULL, **counted)
    assert full.ran == 65 * 33 * 2 - refined
    sweep(tmp_path / "full.nc", FULL)
    assert (tmp_path / "a.nc").read_bytes() == (tmp_path / "full.nc").read_bytes()
    assert sweep(tmp_path / "a.nc").ran == 0
    assert (tmp_path / "a.nc").read_bytes() == expected


def test_a_finer_refinement_goes_on_from_a_coarser_one(tmp_path: Path) -> None:
    coarser = sweep(tmp_path / "a.nc", sweep_fakes.REFINED.replace("levels = 3", "levels = 2"))
    finer = sweep(tmp_path / "a.nc")
    sweep(tmp_path / "b.nc")
    assert (tmp_path / "a.nc").read_bytes() == (tmp_path / "b.nc").read_bytes()
    points = int((dataset(tmp_path / "b.nc")["computed"] > 0).sum())
    assert finer.ran <= points - (coarser.ran - 2 * 100)  # all but those of its sample


def test_a_failed_point_stops_nothing_and_is_made_good_on_resume(tmp_path: Path) -> None:
    broken = sweep(tmp_path / "a.nc", executor="sweep_fakes:region_raising")
    assert broken.counts["failed"] == 2
    assert not broken.complete
    assert broken.counts["pending"] == 0
    assert sweep(tmp_path / "a.nc").complete
    sweep(tmp_path / "b.nc")
    assert (tmp_path / "a.nc").read_bytes() == (tmp_path / "b.nc").read_bytes()


def test_the_share_of_mislabelled_points_is_measured_and_reported(tmp_path: Path) -> None:
    text = sweep_fakes.REFINED.replace('of = "attractor"', 'of = "attractor", sample = 1000')
    summary = sweep(tmp_path / "a.nc", text, executor="sweep_fakes:two_islands")
    sweep(tmp_path / "full.nc", FULL, executor="sweep_fakes:two_islands")
    refined, full = dataset(tmp_path / "a.nc"), dataset(tmp_path / "full.nc")
    origin = refined["computed"]
    sampled = is_code(origin, COMPUTED.codes["sampled"])
    wrong = is_code(origin, COMPUTED.codes["sampled_and_mislabelled"])
    assert refined.attrs["sample_size"] == (sampled | wrong).sum() == 2000
    assert refined.attrs["sample_mislabelled"] == wrong.sum() > 0
    assert refined.attrs["mislabelled_share"] == wrong.sum() / 2000
    assert (is_code(full["attractor"], ATTRACTOR.codes["chaotic"]) >= wrong).all()
    assert (refined["attractor"].values == full["attractor"].values)[sampled | wrong].all()
    assert f"{wrong.sum()} mislabelled ({wrong.sum() / 2000:.1%})" in summary.lines()[-1]


def test_by_default_a_tenth_of_what_is_filled_in_is_sampled_and_no_more_than_100(
    tmp_path: Path,
) -> None:
    sweep(tmp_path / "a.nc")
    text = sweep_fakes.REFINED.replace("levels = 3", "levels = 2")
    sweep(tmp_path / "b.nc", text)
    assert dataset(tmp_path / "a.nc").attrs["sample_size"] == 200
    small = dataset(tmp_path / "b.nc")["computed"]
    for label in ("near", "far"):
        filled = int((small.sel(initial=label) != COMPUTED.codes["run"]).sum())
        sampled = int((small.sel(initial=label) == COMPUTED.codes["sampled"]).sum())
        assert sampled == filled // 10


def test_without_a_sample_no_share_is_claimed(tmp_path: Path) -> None:
    text = sweep_fakes.REFINED.replace('of = "attractor"', 'of = "attractor", sample = 0')
    sweep(tmp_path / "a.nc", text)
    refined = dataset(tmp_path / "a.nc")
    assert refined.attrs["sample_size"] == 0
    assert "mislabelled_share" not in refined.attrs
    assert set(np.unique(refined["computed"])) == {0, 1}


def test_what_is_not_halved_stays_as_it_is(tmp_path: Path) -> None:
    text = sweep_fakes.REFINED.replace("num = 9 }", 'num = 9 }\nfriction = ["coulomb", "stribeck"]')
    text = text.replace('of = "attractor"', 'of = "attractor", along = ["v"]')
    sweep(tmp_path / "a.nc", text)
    refined = dataset(tmp_path / "a.nc")
    assert dict(refined.sizes)["N"] == 9
    assert refined["attractor"].shape == (9, 2, 33, 2)
    assert refined.attrs["refined_from"] == "v 5"
    whole = FULL.replace("num = 65 }", 'num = 9 }\nfriction = ["coulomb", "stribeck"]')
    sweep(tmp_path / "full.nc", whole)
    full = dataset(tmp_path / "full.nc")
    assert (refined["attractor"].values == full["attractor"].values).all()


def test_the_values_are_those_of_the_axis_written_out() -> None:
    coarse = sweep_fakes.REFINED.replace("9, num = 9 }", '9, num = 5, scale = "log" }')
    coarse = coarse.replace("{ start = 0.25, stop = 4.25, num = 5 }", "[0.1, 0.2, 0.3]")
    full = FULL.replace("9, num = 65 }", '9, num = 33, scale = "log" }')
    full = full.replace("start = 0.25, stop = 4.25, num = 33", "start = 0.1, stop = 0.3, num = 17")
    axes = sweep_fakes.case(coarse).axes
    assert [axis.values for axis in axes] == [a.values for a in sweep_fakes.case(full).axes]
    assert axes[1].values[8] == 0.2


def test_the_plan_says_what_is_run() -> None:
    plan = make_plan(sweep_fakes.case(sweep_fakes.REFINED))
    (line,) = [line for line in plan.describe() if "halved" in line]
    assert line.strip() == (
        "N 9 x v 5 halved 3 times along the borders of attractor: 90 to 4290 points are run, "
        "the class of the others is filled in"
    )


def test_the_plan_says_which_maps_have_numbers_of_what_is_run_alone() -> None:
    maps_ = "".join(f'[[figure]]\nname = "{v}"\nkind = "map"\nvariable = "{v}"\n'
                    for v in ("attractor", "L_s"))  # fmt: skip
    for text, told in ((sweep_fakes.REFINED, ["figure L_s: L_s is known only"]), (FULL, [])):
        plan = make_plan(sweep_fakes.case(text + maps_))
        said = [line.strip() for line in plan.describe() if "is known only where" in line]
        assert [line[: len("figure L_s: L_s is known only")] for line in said] == told


def test_progress_grows_with_what_is_asked_for(tmp_path: Path) -> None:
    lines: list[str] = []
    progress = Lines(lines.append)
    summary = run_case(sweep_fakes.case(sweep_fakes.REFINED), tmp_path / "a.nc", HERE, progress)
    progress.tell()
    assert lines[:2] == [
        "a refined map: what is to be run grows as its borders are found",
        "90 points, 0 already stored, 90 to run",
    ]
    assert lines[-1].startswith(f"{summary.ran} of {summary.ran} points done, 0 failed; ")


def test_the_bar_grows_with_it() -> None:
    bar = Bar()
    bar.begin(10, 2)
    bar.advance(5, 1)
    bar.begin(30, 7)
    (task,) = bar._bar.tasks
    assert (task.total, task.completed) == (30, 7)
    bar.end()


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (('of = "attractor"', 'of = "atractor"'), "did you mean 'attractor'"),
        (('of = "attractor"', 'of = "L_s"'), "has a class 'L_s'"),
        (("levels = 3", "levels = 0"), "0 is out of range"),
        (("levels = 3", "levels = 40"), "40 is out of range"),
        (('of = "attractor"', 'along = ["w"]'), "nothing called 'w'"),
        (('of = "attractor"', "sample = -1"), "-1 is out of range"),
        (('of = "attractor"', 'off = "x"'), "unknown key 'off'"),
        (("{ start = 1, stop = 9, num = 9 }", "[1, 2, 4.5]"), "do not rise evenly"),
        (("{ start = 1, stop = 9, num = 9 }", "{ start = 9, stop = 1, num = 9 }"), "do not rise"),
        (("levels = 3", "levels = 12"), "1,073,840,130 runs"),
        (
            ('kind = "state"\nstate = { x_dot = "v" }',
             'kind = "continue"\nalong = "v"\nfrom = "near"'),
            'follows every point of \'v\'; refine leaves some out',
        ),
    ],
)  # fmt: skip
def test_what_cannot_be_refined_is_refused(change: tuple[str, str], message: str) -> None:
    text = sweep_fakes.REFINED.replace(*change)
    assert text != sweep_fakes.REFINED
    with pytest.raises(CaseError, match="problem") as caught:
        make_plan(parse_case(text, "fake.toml", ()))
    assert message in str(caught.value)
    assert "fake.toml:" in str(caught.value)


def test_whole_numbers_have_none_between_them_and_the_axes_to_halve_are_to_be_named() -> None:
    text = """schema = 1
[model]
name = "belt-1dof"
[friction]
law = "stribeck"
[grid]
v = [0.5, 1.0, 1.5]
delta = [1, 2]
[sweep]
refine = { levels = 1ALONG }
[[initial]]
kind = "equilibrium"
[[analysis]]
kind = "response"
"""
    with pytest.raises(CaseError, match=r"cannot be halved: 1\.5 is not a whole") as caught:
        make_plan(parse_case(text.replace("ALONG", ""), "a.toml"))
    assert "along = [" in str(caught.value)
    named = parse_case(text.replace("ALONG", ', along = ["v"]'), "a.toml")
    assert [len(axis.values) for axis in named.axes] == [5, 2]


def test_a_single_point_is_run_alone(tmp_path: Path) -> None:
    case = sweep_fakes.case(sweep_fakes.REFINED, "grid.N=[3.0]", "grid.v=[2.0]")
    assert run_case(case, tmp_path / "a.nc", HERE, Silent()).ran == 2
    assert "computed" not in dataset(tmp_path / "a.nc")


def test_a_claim_about_the_class_is_judged_on_what_is_filled_in_too(tmp_path: Path) -> None:
    text = sweep_fakes.REFINED + CLAIMS
    sweep(tmp_path / "a.nc", text)
    claims = sweep_fakes.case(text).claims
    analyses = read_datasets(tmp_path / "a.nc")
    found = [evaluate(claim, analyses, lambda case: None) for claim in claims]
    assert [one.verdict for one in found] == ["confirmed", "contradicted", "undetermined"]
    assert re.search(r", \d+ of \d+ run, others filled in$", found[0].found)


def test_the_map_is_drawn_whole_and_says_how_much_was_run(tmp_path: Path) -> None:
    sweep(tmp_path / "a.nc")
    refined = dataset(tmp_path / "a.nc")
    layers = [points.Layer("", refined)]
    classes = maps.draw(layers, {"variable": "attractor"})
    share = refined.attrs["points_run"] / 4290
    words = f"{share:.1%} of 4290 points run, 0 of 200 sampled mislabelled"
    assert words in classes.get_suptitle()
    assert [ax.patch.get_hatch() for ax in classes.axes] == [None, None]
    numbers = maps.draw(layers, {"variable": "L_s"})
    (legend,) = numbers.legends
    (told,) = [text.get_text() for text in legend.get_texts()]
    filled = 4290 - refined.attrs["points_run"]
    assert told == f"no value: {filled} filled in (the class alone)"
    assert not points.gaps(refined)


def test_the_coarse_grid_that_was_run_is_found_by_its_refined_map(tmp_path: Path) -> None:
    coarse = sweep_fakes.REFINED.replace('refine = { levels = 3, of = "attractor" }', "")
    lines: list[str] = []
    run_case(sweep_fakes.case(coarse), tmp_path / "a.nc", HERE, Lines(lines.append))
    run_case(sweep_fakes.case(sweep_fakes.REFINED), tmp_path / "b.nc", HERE, Lines(lines.append))
    assert any(f"lie in {tmp_path / 'a.run'}" in line for line in lines)


def test_what_was_run_is_told_from_what_is_filled_in(tmp_path: Path) -> None:
    summary = sweep(tmp_path / "a.nc")
    origin = dataset(tmp_path / "a.nc")["computed"].values
    run, filled = int((origin > 0).sum()), int((origin == 0).sum())
    first, classes = summary.lines()[:2]
    assert f": 4290 points: {run} ok, {filled} filled in (" in first
    assert classes.endswith(f" (of {run} run; fiv show counts the map)")
    partial = sweep(tmp_path / "b.nc", max_points=200)
    assert "filled in" not in partial.lines()[0]


def test_what_is_shown_of_a_refined_dataset(tmp_path: Path) -> None:
    sweep(tmp_path / "a.nc")
    shown = lines(summarise(read_datasets(tmp_path / "a.nc")))
    run = int((dataset(tmp_path / "a.nc")["computed"] > 0).sum())
    (classes,) = [line for line in shown if line.split()[:1] == ["attractor"]]
    assert classes.endswith(f" (with the {4290 - run} filled in)")
    assert f"halved 3 times: {run} of 4290 points run" in shown[-2]
    command, place = "    runs the others: fiv run fake.toml ", " -o THIS.nc"
    assert shown[-1].startswith(command) and shown[-1].endswith(place)
    given = shlex.split(shown[-1].removeprefix(command).removesuffix(place))
    rest = sweep_fakes.case(sweep_fakes.REFINED, *given[1::2])
    assert run_case(rest, tmp_path / "a.nc", HERE, Lines(lambda line: None)).ran == 4290 - run
    assert any(line.split()[:1] == ["computed"] and "filled_in" in line for line in shown)
